/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The steps from a solid to hexahedra, private to the stage:
 *
 *     options -> lines (positions on the axes and through the layers) -> lattice of nodes ->
 *     elements, regions -> points -> quality */
#ifndef TSI_HEX_H
#define TSI_HEX_H

#include "internal.h"

struct tsolid_hex {
  tsi_allocator allocator;
  int references;
  int order, divisions[4];
  int n_nodes, n_elements, n_regions;
  double *nodes;
  int *element; /* n_elements rows of 8 or 20 */
  char *names;  /* all names, one after the other */
  const char **region_name;
  int *region_start, *region_face;
  double worst;
  int worst_element, proved;
  int n_parts, n_shared; /* of an assembly, or 0 */
  int *part_start;       /* first element of each part, and their number */
  char *part_names;
  const char **part_name;
};

/* Mesh lines: x[0..2] in [0,1] along the axes, x[3] = r/R in [0,1] through the layers; n[d]
 * intervals, order * n[d] + 1 values, the middle of each interval among them when order is 2. */
typedef struct tsi_hex_lines {
  int order, n[4];
  double *x[4];
} tsi_hex_lines;

/* Speeds along an axis, or through the layers (axis 3), of n_lines lines between hard positions. */
typedef struct tsi_hex_axis {
  int n_hard, n_lines; /* intervals between hard positions; lines sampled */
  double *hard;        /* n_hard + 1 positions, 0 and 1 among them */
  double *length;      /* [interval][line] */
  double *mean;        /* [interval][station] mean speed over the lines */
} tsi_hex_axis;

/* hex_lines.c: divisions and positions. All arrays are the arena's. */

/* Fills all but the hard positions. */
tsolid_status tsi_hex_axis_sample(tsolid_context *context, tsi_arena *arena,
                                  const tsolid_solid *solid, int d, tsi_hex_axis *axis);
/* Length of the longest line in an interval. */
double tsi_hex_axis_longest(const tsi_hex_axis *axis, int interval);
/* Position in the interval where the share of its mean length is reached. */
double tsi_hex_axis_position(const tsi_hex_axis *axis, int interval, double share);
/* The lines of axis d by the options of one solid; sets lines->order, n[d] and x[d]. */
tsolid_status tsi_hex_axis_lines(tsolid_context *context, tsi_arena *arena,
                                 const tsolid_solid *solid, const tsolid_hex_options *options,
                                 int d, tsi_hex_lines *lines);
/* Of the box of all control points. */
double tsi_hex_diagonal(const tsolid_boundary *boundary);

/* hex_mesh.c: the mesh on given lines; regions as options->regions has them. */

/* Order, size, grading, divisions, regions are sound; the default regions are put where there are
 * none. */
tsolid_status tsi_hex_check_options(tsolid_context *context, tsolid_hex_options *options);
/* The certificate; TSOLID_ERROR_REFUSED where it is not positive, unless the options allow it. */
tsolid_status tsi_hex_check_proof(tsolid_context *context, const tsolid_solid *solid,
                                  const tsolid_hex_options *options, int *proved);
/* Not measured. *surface, unless NULL: the arena's list of the nodes of the outermost layer, by
 * tsi_lattice_id; -1 where no element has a node. */
tsolid_status tsi_hex_build(tsolid_context *context, tsi_arena *arena, const tsolid_solid *solid,
                            const tsolid_hex_options *options, const tsi_hex_lines *lines,
                            int **surface, tsolid_hex **hex);
/* An empty mesh that one handle refers to; NULL: no memory. */
tsolid_hex *tsi_hex_new(tsolid_context *context);
/* The element of lattice cell (0, 0) of a side's outer faces; the others follow, s fastest. */
int tsi_hex_first_outer(const tsi_hex_lines *lines, int side);
/* Measures all elements; TSOLID_ERROR_REFUSED when one folds. */
tsolid_status tsi_hex_check_quality(tsolid_context *context, tsolid_hex *hex);

/* hex_quality.c: the worst scaled Jacobian of the elements as finite elements see them. */
void tsi_hex_measure(tsolid_hex *hex);

/* write_inp.c: nodes of S1..S6 among the 20 of an element, corners first: the normal of that
 * quadrilateral points outward; then the mids between them. */
extern const signed char tsi_hex_face_nodes[6][8];

static inline int tsi_hex_width(int order) {
  return order == 2 ? 20 : 8;
}

#endif
