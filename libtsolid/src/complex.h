/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The complex of four-sided facets: vertices, borders matched in pairs, orientation.
 *
 * A border slot 4k + b is border b of facet k, and corner slot 4k + b its first end. Once the
 * facets are oriented alike a border slot is also a dart: an edge walked with its facet on the
 * left. */
#ifndef TSI_COMPLEX_H
#define TSI_COMPLEX_H

#include "cube.h"
#include "vector.h"

typedef struct tsi_complex {
  tsolid_context *context;
  tsi_arena *arena;
  tsolid_requirement *requirement;
  int n;
  const tsi_facet *facet;
  int n_vertices;
  int *vertex;            /* 4n: vertex of facet corner */
  double (*point)[3];     /* n_vertices: the least of the corner points that meet there */
  int *mate;              /* 4n: the slot across the border, or -1 */
  unsigned char *flipped; /* n: walked clockwise */
  int *valence;           /* n_vertices */
  unsigned char *shared;  /* 4n: the border belongs to three or more facets */
} tsi_complex;

/* Each step needs the ones before; each violation is a finding, TSOLID_ERROR_REFUSED the status. */
tsolid_status tsi_complex_check_facets(tsi_complex *c);
tsolid_status tsi_complex_find_vertices(tsi_complex *c);
tsolid_status tsi_complex_find_duplicates(tsi_complex *c);
tsolid_status tsi_complex_match_borders(tsi_complex *c);
tsolid_status tsi_complex_check_closed(tsi_complex *c);
tsolid_status tsi_complex_orient(tsi_complex *c);
tsolid_status tsi_complex_check_fans(tsi_complex *c);
tsolid_status tsi_complex_check_genus(tsi_complex *c);
tsolid_status tsi_complex_check_valences(tsi_complex *c);
tsolid_status tsi_complex_orient_outward(tsi_complex *c);

/* Counts a violation and starts its finding. */
tsolid_finding tsi_violation(tsi_complex *c, tsolid_entity entity, int k, int part);
void tsi_set_point(tsolid_finding *finding, const double point[3]);
/* -1, 0, 1: by x, then y, then z. */
int tsi_compare_points(const double a[3], const double b[3]);

static inline int tsi_dart_origin_corner(const tsi_complex *c, int dart) {
  int b = dart % 4;
  return dart / 4 * 4 + (c->flipped[dart / 4] ? (b + 1) % 4 : b);
}

static inline int tsi_dart_end_corner(const tsi_complex *c, int dart) {
  int b = dart % 4;
  return dart / 4 * 4 + (c->flipped[dart / 4] ? b : (b + 1) % 4);
}

static inline int tsi_dart_origin(const tsi_complex *c, int dart) {
  return c->vertex[tsi_dart_origin_corner(c, dart)];
}

static inline int tsi_dart_end(const tsi_complex *c, int dart) {
  return c->vertex[tsi_dart_end_corner(c, dart)];
}

static inline int tsi_dart_next(const tsi_complex *c, int dart) {
  return dart / 4 * 4 + (dart + (c->flipped[dart / 4] ? 3 : 1)) % 4;
}

/* Straight on through the regular vertex at the end of `dart`. */
static inline int tsi_dart_straight(const tsi_complex *c, int dart) {
  return tsi_dart_next(c, c->mate[tsi_dart_next(c, dart)]);
}

#endif
