/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TSI_OCTREE_H
#define TSI_OCTREE_H

#include "internal.h"

/* T-junctions of one side: n rows of (s, t) in [0,1]^2; repeats and the square's corners do no
 * harm. */
typedef struct tsi_junctions {
  int n;
  const double *at;
} tsi_junctions;

typedef struct tsi_octree_input {
  tsi_junctions side[6];
  int min_cells;
  int together; /* axes that are always split together, in the middle where no T-junction is left
                   (bits); 0: every axis for itself */
} tsi_octree_input;

typedef struct tsi_octree {
  int n_lines[3];
  double *line[3];
  int n_boxes, *box; /* n_boxes x (lo[3], hi[3]) in lines */
  int *level;        /* of every box: the largest of its three */
  double arm_height[6];
} tsi_octree;

/* The leaves of the octree; all in the arena. */
tsolid_status tsi_octree_create(tsolid_context *context, const tsi_octree_input *input,
                                tsi_arena *arena, tsi_octree *tree);

#endif
