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
};

/* Mesh lines: x[0..2] in [0,1] along the axes, x[3] = r/R in [0,1] through the layers; n[d]
 * intervals, order * n[d] + 1 values, the middle of each interval among them when order is 2. */
typedef struct tsi_hex_lines {
  int order, n[4];
  double *x[4];
} tsi_hex_lines;

/* hex_lines.c: divisions and positions. The lines' arrays are the arena's. */
tsolid_status tsi_hex_lines_create(tsolid_context *context, tsi_arena *arena,
                                   const tsolid_solid *solid, const tsolid_hex_options *options,
                                   int n_regions, const tsolid_region *region,
                                   tsi_hex_lines *lines);

/* hex_quality.c: the worst scaled Jacobian of the elements as finite elements see them. */
void tsi_hex_measure(tsolid_hex *hex);

/* write_inp.c: nodes of S1..S6 among the 20 of an element, corners first: the normal of that
 * quadrilateral points outward; then the mids between them. */
extern const signed char tsi_hex_face_nodes[6][8];

static inline int tsi_hex_width(int order) {
  return order == 2 ? 20 : 8;
}

#endif
