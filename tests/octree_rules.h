/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The octree's rules, looked at by brute force. */
#ifndef TSOLID_TEST_OCTREE_RULES_H
#define TSOLID_TEST_OCTREE_RULES_H

#include <stdlib.h>

#include "axis_tree.h"
#include "check.h"

/* T-junctions of a side strictly inside the open box (in s and t); a degenerate interval means "on
 * this line". Corners of elements, each position once. */
static inline int slow_count(const tsi_side *side, double s0, double s1, double t0, double t1) {
  int n = 0;
  for (int e = 0; e < side->n_elements; e++) /* the low corner of every element, and the ends */
    for (int corner = 0; corner < 4; corner++) {
      const double *box = side->box + 4 * e;
      double s = box[corner & 1], t = box[2 + (corner >> 1)];
      int inside =
              (s0 == s1 ? s == s0 : s0 < s && s < s1) && (t0 == t1 ? t == t0 : t0 < t && t < t1),
          seen = 0;
      for (int k = 0; inside && k < e && !seen; k++)
        for (int c = 0; c < 4; c++)
          seen |= side->box[4 * k + (c & 1)] == s && side->box[4 * k + 2 + (c >> 1)] == t;
      n += inside && !seen;
    }
  return n;
}

static inline void check_rule(const tsolid_tmesh *tmesh, const tsolid_boundary *boundary) {
  int broken = 0;
  for (int b = 0; b < tmesh->n_boxes; b++)
    for (int side = 0; side < 6; side++) {
      const int *box = tmesh->box + 6 * b;
      int axis = side / 2, s = tsi_side_s(side), t = tsi_side_t(side);
      if (side & 1 ? box[axis + 3] != tmesh->n_lines[axis] - 1 : box[axis] != 0)
        continue;
      double s0 = tmesh->line[s][box[s]], s1 = tmesh->line[s][box[s + 3]];
      double t0 = tmesh->line[t][box[t]], t1 = tmesh->line[t][box[t + 3]];
      const tsi_side *sd = &boundary->side[side];
      broken += slow_count(sd, s0, s1, t0, t1) > 1 || slow_count(sd, s0, s0, t0, t1) > 1 ||
                slow_count(sd, s1, s1, t0, t1) > 1 || slow_count(sd, s0, s1, t0, t0) > 1 ||
                slow_count(sd, s0, s1, t1, t1) > 1;
    }
  CHECK(broken == 0);
}

/* Level of an interval in its axis tree; -1: not a node of the tree. */
static inline int level_of(const tsi_axis_tree *tree, double low, double high) {
  for (int i = 0; i < tree->n_nodes; i++)
    if (tree->value[tree->node[i].first] == low && tree->value[tree->node[i].last] == high)
      return tree->node[i].level;
  return -1;
}

static inline int touch(const int *p, const int *q) {
  for (int a = 0; a < 3; a++)
    if (p[a] > q[a + 3] || q[a] > p[a + 3])
      return 0;
  return 1;
}

static inline void check_balance(tsolid_context *context, const tsolid_tmesh *t,
                                 const tsolid_boundary *boundary, int min_cells) {
  tsi_arena arena = tsi_arena_create(context);
  int broken = 0, *level = malloc(3 * (size_t)t->n_boxes * sizeof *level);
  int *leaf = malloc(3 * (size_t)t->n_boxes * sizeof *leaf);
  for (int a = 0; a < 3; a++) {
    tsi_axis_tree tree;
    CHECK(tsi_axis_tree_create(boundary, a, min_cells, &arena, &tree));
    for (int b = 0; b < t->n_boxes; b++) {
      double low = t->line[a][t->box[6 * b + a]], high = t->line[a][t->box[6 * b + a + 3]];
      level[3 * b + a] = level_of(&tree, low, high);
      leaf[3 * b + a] = 1; /* of the tree: it cannot be split */
      for (int i = 0; i < tree.n_values; i++)
        leaf[3 * b + a] &= !(low < tree.value[i] && tree.value[i] < high);
      broken += level[3 * b + a] < 0;
    }
  }
  CHECK(broken == 0);
  for (int b = 0; b < t->n_boxes; b++)
    for (int c = 0; c < t->n_boxes; c++)
      for (int a = 0; a < 3 && touch(t->box + 6 * b, t->box + 6 * c); a++)
        broken += level[3 * c + a] - level[3 * b + a] > 1 && !leaf[3 * b + a];
  CHECK(broken == 0);
  free(level);
  free(leaf);
  tsi_arena_free(&arena);
}

#endif
