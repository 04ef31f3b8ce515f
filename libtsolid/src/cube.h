/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The requirement of Zhang, Wang, Hughes (2012), section 2, on any number of four-sided facets, and
 * the cube's canonical position. Blind to what the facets are made of. */
#ifndef TSI_CUBE_H
#define TSI_CUBE_H

#include "internal.h"

/* What the check needs to know about a patch. Border b runs from corner b to corner b+1 (mod 4). */
typedef struct tsi_facet {
  double corner[4][3];    /* (u,v) = 00, 10, 11, 01 */
  double sample[4][3][3]; /* border points at 1/4, 1/2, 3/4 of the border's parameter */
  double length[4];       /* of the border's control polygon or a polygon of points on it */
  double area, flux;      /* flux of x/3 with normal x_u x x_v */
  double centre[3];       /* the point at the middle of both parameters */
  double tolerance[4];    /* of each border, at least the caller's */
  int fixed;              /* its control points stand where borders are snapped */
  const char *name, *border_name[4], *corner_name[4];
  int patch;                            /* of the input, of which the facet may be a piece */
  unsigned char is_cut[4], is_inner[4]; /* borders and corners that the input's patch has not */
} tsi_facet;

/* Facet `facet` lies on a side with its (u,v) reversed as flip says, then exchanged if swap. */
typedef struct tsi_place {
  int facet, swap, flip[2];
} tsi_place;

typedef struct tsi_cube {
  int n_strips[3];     /* facets per axis */
  tsi_place *place[6]; /* per side: facet (i, j) along (s, t) is entry i + n_s*j */
} tsi_cube;

/* Finds the cube in `n` facets, and its canonical position: the corner that is least by x, then y,
 * then z becomes corner 0 (coordinates closer than 1e-9 of the corners' extent count as equal), its
 * least neighbour lies on the axis x, and the axes are right-handed in the part. Does not depend on
 * the order and orientation of the facets. Fills *requirement as far as it gets; each violation is
 * a finding and the status TSOLID_ERROR_REFUSED. The cube's arrays are the arena's. */
tsolid_status tsi_cube_find(tsolid_context *context, tsi_arena *arena, int n,
                            const tsi_facet *facet, tsolid_requirement *requirement,
                            tsi_cube *cube);

/* "Face3", "Edge7 of Face3", "border 1 of patch 2". Return `text`. */
enum { TSI_BORDER_NAME_SIZE = 224 };
const char *tsi_name_facet(const tsi_facet *facet, char text[TSI_NAME_SIZE]);
const char *tsi_name_border(const tsi_facet *facet, int b, char text[TSI_BORDER_NAME_SIZE]);

#endif
