/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The octree keeps its rules, by brute force; the closure makes any set of boxes analysis-suitable:
 * the functions sum to one, none tears, and the rank is full. */
#include <stdlib.h>

#include "axis_tree.h"
#include "check.h"
#include "conform.h"
#include "cube_part.h"

static double random_unit(void) {
  static uint64_t state = 1987;
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) * 0x1p-53;
}

static tsolid_boundary *boundary_of(tsolid_context *context, const cube_axis axis[3]) {
  cube_part part = cube_part_create(axis, NULL);
  tsolid_boundary *boundary = NULL;
  tsolid_boundary_input input = {.bezier = &part.boundary};
  CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_OK);
  cube_part_free(&part);
  return boundary;
}

/* ---- the octree's rules
 * ------------------------------------------------------------------------------ */

/* T-junctions of a side strictly inside the open box (in s and t); a degenerate interval means "on
 * this line". Corners of elements, each position once. */
static int slow_count(const tsi_side *side, double s0, double s1, double t0, double t1) {
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

static void check_rule(const tsolid_tmesh *tmesh, const tsolid_boundary *boundary) {
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
static int level_of(const tsi_axis_tree *tree, double low, double high) {
  for (int i = 0; i < tree->n_nodes; i++)
    if (tree->value[tree->node[i].first] == low && tree->value[tree->node[i].last] == high)
      return tree->node[i].level;
  return -1;
}

static int touch(const int *p, const int *q) {
  for (int a = 0; a < 3; a++)
    if (p[a] > q[a + 3] || q[a] > p[a + 3])
      return 0;
  return 1;
}

static void check_balance(tsolid_context *context, const tsolid_tmesh *t,
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

/* ---- what the closure promises
 * ------------------------------------------------------------------------- */

static void check_basis(tsolid_context *context, const tsolid_boundary *boundary,
                        const tsolid_tmesh *tmesh) {
  tsolid_space *space;
  tsolid_basis_report r;
  tsi_arena arena = tsi_arena_create(context);
  tsi_face *face;
  int n_faces;
  if (!CHECK(tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK))
    return;
  CHECK(tsi_faces_create(context, space, &arena, &n_faces, &face) == TSOLID_OK);
  CHECK(tsi_basis_measure(context, space, n_faces, face, 1200, &r) == TSOLID_OK);
  CHECK_NEAR(r.sum_defect, 0.0, 1e-12);
  CHECK_NEAR(r.diagonal_jump, 0.0, 1e-12);
  CHECK_NEAR(r.core_jump, 0.0, 1e-12);
  CHECK(r.smallest_value >= 0.0);
  CHECK(!r.rank_measured || r.inner_eigenvalue > r.inner_roundoff);
  tsi_arena_free(&arena);
  tsolid_space_free(space);
}

static void test_octree(tsolid_context *context) {
  static const cube_axis parts[][3] = {
      {{2, 4, 1}, {2, 4, 1}, {2, 4, 1}},    {{3, 9, 1}, {2, 5, 1}, {1, 14, 1}},
      {{2, 16, 1}, {3, 2, 1}, {2, 7, 2}},   {{5, 1, 1}, {4, 3, 1}, {2, 12, 1}},
      {{2, 11, 1}, {2, 10, 1}, {2, 11, 1}},
  };
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
    for (int min_cells = 1; min_cells <= 3; min_cells += 2) {
      tsolid_boundary *boundary = boundary_of(context, parts[i]);
      tsolid_tmesh *tmesh;
      tsolid_tmesh_options options = {.min_cells = min_cells};
      CHECK(tsolid_tmesh_create(context, boundary, &options, &tmesh) == TSOLID_OK);
      check_rule(tmesh, boundary);
      check_balance(context, tmesh, boundary, min_cells);
      for (int a = 0; a < 3; a++)
        CHECK(tmesh->n_lines[a] - 1 >= min_cells);
      CHECK(tmesh->n_extraordinary == 8);
      check_basis(context, boundary, tmesh);
      tsolid_tmesh_free(tmesh);
      tsolid_boundary_free(boundary);
    }
}

/* ---- closure on random octrees
 * ------------------------------------------------------------------------- */

enum { FINEST = 8, MAX_BOXES = 1024 };

typedef struct box_list {
  int n, box[MAX_BOXES][6];
} box_list;

static int width(const int *box) {
  return box[3] - box[0];
}

/* Replaces a box by its eight parts. */
static void split_box(box_list *list, int index) {
  int box[6], h = width(list->box[index]) / 2;
  memcpy(box, list->box[index], sizeof box);
  for (int k = 0; k < 8; k++) {
    int *part = list->box[k == 0 ? index : list->n++];
    for (int a = 0; a < 3; a++) {
      part[a] = box[a] + (k >> a & 1) * h;
      part[a + 3] = part[a] + h;
    }
  }
}

/* Random splits, then strong balance: boxes that touch differ by at most one level. */
static void random_octree(box_list *list, double chance) {
  static const int root[6] = {0, 0, 0, FINEST, FINEST, FINEST};
  list->n = 1;
  memcpy(list->box[0], root, sizeof root);
  split_box(list, 0);
  for (int level = 0; level < 2; level++)
    for (int i = list->n - 1; i >= 0; i--)
      if (width(list->box[i]) > 1 && random_unit() < chance)
        split_box(list, i);
  for (int changed = 1; changed;) {
    changed = 0;
    for (int i = 0; i < list->n; i++)
      for (int j = 0; j < list->n; j++)
        if (touch(list->box[i], list->box[j]) && width(list->box[i]) > 2 * width(list->box[j])) {
          split_box(list, i);
          changed = 1;
        }
  }
}

static void test_random_octrees(tsolid_context *context) {
  static const double height[6] = {0.5, 0.4, 0.3, 0.5, 0.6, 0.4};
  static const cube_axis axis[3] = {{2, 3, 1}, {2, 2, 1}, {3, 3, 1}};
  static box_list list;
  tsolid_boundary *boundary = boundary_of(context, axis);
  const int n_lines[3] = {FINEST + 1, FINEST + 1, FINEST + 1};
  int n_closed = 0;
  for (int trial = 0; trial < 6; trial++) {
    double line[3][FINEST + 1];
    const double *lines[3] = {line[0], line[1], line[2]};
    for (int a = 0; a < 3; a++)
      for (int i = 0; i <= FINEST; i++)
        line[a][i] = i == FINEST ? 1.0 : (i + (i > 0) * 0.6 * (random_unit() - 0.5)) / FINEST;
    random_octree(&list, 0.05 + 0.05 * trial);
    tsolid_tmesh *tmesh;
    if (!CHECK(tsi_tmesh_from_boxes(context, n_lines, lines, list.n, list.box[0], height, 0,
                                    &tmesh) == TSOLID_OK))
      continue;
    n_closed += tmesh->n_closure_rounds > 0;
    check_basis(context, boundary, tmesh);
    tsolid_tmesh_free(tmesh);
  }
  CHECK(n_closed >= 3); /* there was something to repair */
  tsolid_boundary_free(boundary);
}

/* Cuts at random places along random axes: unbalanced, T-junctions everywhere. */
static void cut_box(box_list *list, const int box[6], double chance) {
  int axis = (int)(3.0 * random_unit()), low[6], high[6];
  for (int k = 0; k < 3 && box[axis + 3] - box[axis] < 2; k++)
    axis = (axis + 1) % 3;
  if (box[axis + 3] - box[axis] < 2 || random_unit() > chance) {
    memcpy(list->box[list->n++], box, 6 * sizeof *box);
    return;
  }
  int cut = box[axis] + 1 + (int)(random_unit() * (box[axis + 3] - box[axis] - 1));
  memcpy(low, box, sizeof low);
  memcpy(high, box, sizeof high);
  low[axis + 3] = high[axis] = cut;
  cut_box(list, low, chance);
  cut_box(list, high, chance);
}

/* What no octree would make. Without the nodes where edges cross, half of these fail. */
static void test_wild_boxes(tsolid_context *context) {
  static const double height[6] = {0.5, 0.4, 0.3, 0.5, 0.6, 0.4};
  static const cube_axis axis[3] = {{2, 1, 1}, {2, 1, 1}, {3, 1, 1}};
  static box_list list;
  tsolid_boundary *boundary = boundary_of(context, axis);
  for (int trial = 0; trial < 12; trial++) {
    int n = 3 + trial % 4, n_lines[3] = {n + 1, n + 1, n + 1};
    double line[3][FINEST + 1];
    const double *lines[3] = {line[0], line[1], line[2]};
    for (int a = 0; a < 3; a++)
      for (int i = 0; i <= n; i++)
        line[a][i] = i == n ? 1.0 : (i + (i > 0) * 0.4 * (random_unit() - 0.5)) / n;
    list.n = 0;
    cut_box(&list, (int[6]){0, 0, 0, n, n, n}, 0.85);
    tsolid_tmesh *tmesh;
    if (!CHECK(tsi_tmesh_from_boxes(context, n_lines, lines, list.n, list.box[0], height, 0,
                                    &tmesh) == TSOLID_OK))
      continue;
    check_basis(context, boundary, tmesh);
    tsolid_tmesh_free(tmesh);
  }
  tsolid_boundary_free(boundary);
}

int main(void) {
  tsolid_context *context;
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  test_octree(context);
  test_random_octrees(context);
  test_wild_boxes(context);
  tsolid_context_free(context);
  return check_done();
}
