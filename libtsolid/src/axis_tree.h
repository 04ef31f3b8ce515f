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

/* Values inside are split further until there are at least min_cells intervals. All in the arena;
 * 0: no memory. */
int tsi_axis_tree_create(const tsolid_boundary *boundary, int axis, int min_cells, tsi_arena *arena,
                         tsi_axis_tree *tree);

/* Index of the value nearest x. */
int tsi_axis_tree_nearest(const tsi_axis_tree *tree, double x);

#endif
