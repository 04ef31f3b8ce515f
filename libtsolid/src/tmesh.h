/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Nodes of a T-mesh and the planes that a ray meets. */
#ifndef TSI_TMESH_H
#define TSI_TMESH_H

#include "internal.h"

enum { TSI_MAX_LEVELS = 24 }; /* as in tsolid_statistics */

/* The level of core cell (box) b: how often the core was split for it along the axis with most
 * splits. Where that is not known (boxes given by a caller, old files), by its smallest width. */
int tsi_box_level(const tsolid_tmesh *tmesh, int b);
/* Keeps the levels of all boxes. */
tsolid_status tsi_tmesh_set_levels(tsolid_context *context, tsolid_tmesh *tmesh, const int *level);
/* How many boxes of every level. */
void tsi_box_levels(const tsolid_tmesh *tmesh, int n[TSI_MAX_LEVELS]);

/* Distinct nodes: corners of cells and crossings of their edges, in lexicographic order of (plane
 * 2, plane 1, plane 0): n rows of 3 plane indices, in the arena. */
tsolid_status tsi_tmesh_nodes(tsolid_context *context, const tsolid_tmesh *tmesh, tsi_arena *arena,
                              int *n, int **node);

/* Fills n_nodes, n_partial_extraordinary, n_extraordinary. */
tsolid_status tsi_tmesh_count_nodes(tsolid_context *context, tsolid_tmesh *tmesh);

/* For one axis: the planes with a face that a line parallel to the axis meets, for every line
 * through a node (faces are closed: meeting a border counts). */
typedef struct tsi_columns {
  int axis;
  int n_columns;
  int *lateral;       /* n_columns rows: planes of the two other axes, in increasing order */
  int *lateral_start; /* per plane of the first other axis: its first column; n_planes + 1 */
  size_t *start;      /* n_columns + 1 */
  int *plane;         /* ascending within a column */
} tsi_columns;

tsolid_status tsi_columns_create(tsolid_context *context, const tsolid_tmesh *tmesh, int axis,
                                 int n_nodes, const int *node, tsi_arena *arena,
                                 tsi_columns *columns);

/* Local knot vector of a node along the axis of `columns`, as plane indices: two planes each way;
 * a ray that runs out of planes repeats the last. */
void tsi_columns_local_knots(const tsi_columns *columns, const int node[3], int knot[5]);

#endif
