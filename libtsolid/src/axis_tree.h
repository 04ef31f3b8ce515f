/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TSI_AXIS_TREE_H
#define TSI_AXIS_TREE_H

#include "internal.h"

/* An interval between two values of an axis; children: none, or the parts below and above the value
 * nearest its middle. */
typedef struct tsi_interval {
  int first, last; /* indices of values */
  int level;
  int child[2];
} tsi_interval;

typedef struct tsi_axis_tree {
  int n_values;
  double *value; /* 0 = value[0] < ... < value[n_values - 1] = 1 */
  int n_nodes;
  tsi_interval *node; /* node 0: the whole axis */
} tsi_axis_tree;

/* From n values in [0,1], in any order, repeats allowed. Values inside are split further until
 * there are at least min_cells intervals. All in the arena; 0: no memory. */
int tsi_axis_tree_from_values(int n, const double *values, int min_cells, tsi_arena *arena,
                              tsi_axis_tree *tree);
/* The same from the element borders of the four sides that carry the axis. */
int tsi_axis_tree_create(const tsolid_boundary *boundary, int axis, int min_cells, tsi_arena *arena,
                         tsi_axis_tree *tree);

/* Can an interval without children be split in the middle? Not when it is as narrow as round-off.
 */
int tsi_interval_has_middle(const tsi_axis_tree *tree, int node);

/* Gives two children to the marked leaves, with the middle between them. Nodes keep their numbers,
 * values get new ones. 0: no memory. */
int tsi_axis_tree_halve(tsi_axis_tree *tree, const unsigned char *marked, tsi_arena *arena);

/* Index of the value nearest x. */
int tsi_axis_tree_nearest(const tsi_axis_tree *tree, double x);

#endif
