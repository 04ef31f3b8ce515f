/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The octree keeps its rules, by brute force; the closure makes any set of boxes analysis-suitable:
 * the functions sum to one, none tears, and the rank is full. */
#include <stdlib.h>

#include "check.h"
#include "conform.h"
#include "cube_part.h"
#include "octree.h"
#include "octree_rules.h"

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
  CHECK_NEAR(r.input_sum_defect, 0.0, 1e-14);
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

/* ---- the paper's octree
 * ------------------------------------------------------------------------------ */

/* Where the paper splits an interval: at the T-junction value nearest the middle (the lower of
 * two), or there. */
static double split_place(int n, const double *value, double low, double high) {
  double middle = 0.5 * (low + high), best = middle, distance = 1.0;
  for (int i = 0; i < n; i++)
    if (low < value[i] && value[i] < high &&
        (fabs(value[i] - middle) < distance ||
         (fabs(value[i] - middle) == distance && value[i] < best))) {
      distance = fabs(value[i] - middle);
      best = value[i];
    }
  return best;
}

typedef struct slow_tree {
  int n_values[3], n_leaves, together;
  double value[3][64];
  struct slow_leaf {
    double lo[3], hi[3];
    int level;
  } leaf[8192];
  tsi_junctions side[6];
} slow_tree;

static int slow_touch(const slow_tree *t, int i, int j) {
  for (int a = 0; a < 3; a++)
    if (t->leaf[i].lo[a] > t->leaf[j].hi[a] || t->leaf[j].lo[a] > t->leaf[i].hi[a])
      return 0;
  return 1;
}

/* T-junctions of distinct places in the box of a side; degenerate intervals: on the line. */
static int slow_inside(const tsi_junctions *list, double s0, double s1, double t0, double t1) {
  int n = 0;
  for (int i = 0; i < list->n; i++) {
    double s = list->at[2 * i], t = list->at[2 * i + 1];
    int inside = (s0 == s1 ? s == s0 : s0 < s && s < s1) && (t0 == t1 ? t == t0 : t0 < t && t < t1);
    for (int k = 0; k < i && inside; k++)
      inside = list->at[2 * k] != s || list->at[2 * k + 1] != t;
    n += inside;
  }
  return n;
}

static int slow_breaks(const slow_tree *t, int leaf) {
  const struct slow_leaf *l = &t->leaf[leaf];
  for (int side = 0; side < 6; side++) {
    const tsi_junctions *list = &t->side[side];
    int s = tsi_side_s(side), v = tsi_side_t(side);
    if (side & 1 ? l->hi[side / 2] != 1.0 : l->lo[side / 2] != 0.0)
      continue;
    for (int k = 0; k < 9; k++) { /* the open face, its four edges (corners are never two) */
      double s0 = k % 3 == 2 ? l->hi[s] : l->lo[s], s1 = k % 3 == 1 ? s0 : l->hi[s];
      double t0 = k / 3 == 2 ? l->hi[v] : l->lo[v], t1 = k / 3 == 1 ? t0 : l->hi[v];
      if (slow_inside(list, s0, s1, t0, t1) > 1)
        return 1;
    }
  }
  return 0;
}

/* Splits one leaf; the axes that are not split together stay whole. */
static void slow_split(slow_tree *t, int leaf) {
  struct slow_leaf whole = t->leaf[leaf];
  double at[3];
  for (int a = 0; a < 3; a++)
    at[a] = split_place(t->n_values[a], t->value[a], whole.lo[a], whole.hi[a]);
  int made = 0;
  for (int k = 0; k < 8; k++) {
    struct slow_leaf part = whole;
    if (k & ~t->together)
      continue;
    for (int a = 0; a < 3; a++)
      if (t->together >> a & 1) {
        part.lo[a] = k >> a & 1 ? at[a] : whole.lo[a];
        part.hi[a] = k >> a & 1 ? whole.hi[a] : at[a];
      }
    part.level++;
    t->leaf[made++ == 0 ? leaf : t->n_leaves++] = part;
  }
}

/* The definition, without thought: as long as something is wrong, split it. */
static void grow_slowly(slow_tree *t, int min_cells) {
  t->n_leaves = 1;
  t->leaf[0] = (struct slow_leaf){{0, 0, 0}, {1, 1, 1}, 0};
  for (int changed = 1; changed;) {
    changed = 0;
    for (int i = 0; i < t->n_leaves; i++) {
      int wrong = slow_breaks(t, i);
      for (int a = 0; a < 3; a++)
        wrong |= t->together >> a & 1 && (t->leaf[i].hi[a] - t->leaf[i].lo[a]) * min_cells > 1.01;
      for (int j = 0; j < t->n_leaves && !wrong; j++)
        wrong = t->leaf[j].level - t->leaf[i].level > 1 && slow_touch(t, i, j);
      if (wrong)
        slow_split(t, i);
      changed |= wrong;
    }
  }
}

static int find_leaf(const slow_tree *t, const tsi_octree *tree, int box) {
  for (int i = 0; i < t->n_leaves; i++) {
    int same = 1;
    for (int a = 0; a < 3; a++)
      same &= t->leaf[i].lo[a] == tree->line[a][tree->box[6 * box + a]] &&
              t->leaf[i].hi[a] == tree->line[a][tree->box[6 * box + a + 3]];
    if (same)
      return i;
  }
  return -1;
}

/* The octree and its slow twin have the same leaves. */
static int check_twin(tsolid_context *context, slow_tree *t, int min_cells) {
  tsi_arena arena = tsi_arena_create(context);
  tsi_octree_input input = {.min_cells = min_cells, .together = t->together};
  tsi_octree tree;
  memcpy(input.side, t->side, sizeof t->side);
  int n = 0, missing = 0;
  grow_slowly(t, min_cells);
  if (CHECK(tsi_octree_create(context, &input, &arena, &tree) == TSOLID_OK)) {
    n = tree.n_boxes;
    CHECK(n == t->n_leaves);
    for (int b = 0; b < n; b++)
      missing += find_leaf(t, &tree, b) < 0;
    CHECK(missing == 0);
  }
  tsi_arena_free(&arena);
  return n;
}

/* Values of an axis, from a list per side, as they stand there. */
static void take_values(slow_tree *t) {
  for (int a = 0; a < 3; a++)
    for (int side = 0; side < 6; side++)
      for (int i = 0; i < t->side[side].n && side / 2 != a; i++) {
        double x = t->side[side].at[2 * i + (tsi_side_s(side) == a ? 0 : 1)];
        int known = x == 0.0 || x == 1.0;
        for (int k = 0; k < t->n_values[a] && !known; k++)
          known = t->value[a][k] == x;
        if (!known)
          t->value[a][t->n_values[a]++] = x;
      }
}

/* Figure 2 of the paper in spirit: a closed curve of four sides with 20 control points, four of
 * them corners; the square inside is subdivided until every boundary cell has one T-junction at
 * most. The third axis is there, but never split. */
static void test_figure_2(tsolid_context *context) {
  static const double at[4][8] = {{0.13, 0, 0.29, 0, 0.47, 0, 0.83, 0},
                                  {0.17, 0, 0.41, 0, 0.53, 0, 0.88, 0},
                                  {0.21, 0, 0.38, 0, 0.62, 0, 0.71, 0},
                                  {0.06, 0, 0.25, 0, 0.44, 0, 0.76, 0}};
  static slow_tree t;
  t = (slow_tree){.together = 3};
  for (int side = 0; side < 4; side++)
    t.side[side] = (tsi_junctions){4, at[side]};
  take_values(&t);
  int n = check_twin(context, &t, 1), n_boundary = 0, worst = 0;
  for (int i = 0; i < t.n_leaves; i++)
    for (int side = 0; side < 4; side++) {
      const struct slow_leaf *l = &t.leaf[i];
      int along = 1 - side / 2;
      if (side & 1 ? l->hi[side / 2] != 1.0 : l->lo[side / 2] != 0.0)
        continue;
      int inside = slow_inside(&t.side[side], l->lo[along], l->hi[along], 0.0, 0.0);
      worst = inside > worst ? inside : worst;
      n_boundary++;
    }
  CHECK(worst == 1 && n_boundary >= 12);
  CHECK(n % 3 == 1); /* every split of a quadtree adds three cells */
}

static void test_isotropic(tsolid_context *context) {
  static double at[6][2 * 25];
  static slow_tree t;
  for (int trial = 0; trial < 6; trial++) {
    t = (slow_tree){.together = 7};
    for (int side = 0; side < 6; side++) {
      int n = 1 + (int)(4.0 * random_unit());
      for (int i = 0; i < n; i++) /* well apart: values too close would be taken together */
        for (int d = 0; d < 2; d++)
          at[side][2 * i + d] = (1 + (int)(15.0 * random_unit())) / 16.0;
      t.side[side] = (tsi_junctions){n, at[side]};
    }
    take_values(&t);
    CHECK(check_twin(context, &t, 1 + trial % 3) % 7 == 1);
  }
}

/* The whole way: the paper's octree under a boundary, closed. */
static void test_isotropic_basis(tsolid_context *context) {
  static const cube_axis axis[3] = {{2, 12, 1}, {2, 5, 1}, {3, 2, 1}};
  static const tsolid_tmesh_options options = {.isotropic = 1};
  tsolid_boundary *boundary = boundary_of(context, axis);
  tsolid_tmesh *tmesh;
  CHECK(tsolid_tmesh_create(context, boundary, &options, &tmesh) == TSOLID_OK);
  CHECK(tmesh->n_boxes % 7 == 1);
  check_rule(tmesh, boundary);
  check_basis(context, boundary, tmesh);
  tsolid_tmesh_free(tmesh);
  tsolid_boundary_free(boundary);
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
  test_figure_2(context);
  test_isotropic(context);
  test_isotropic_basis(context);
  test_random_octrees(context);
  test_wild_boxes(context);
  tsolid_context_free(context);
  return check_done();
}
