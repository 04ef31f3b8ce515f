/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Does the octree pay? Numbers of functions as the sides get finer, against a tensor core's, and
 * what the closure adds. */
#include "axis_tree.h"
#include "blending.h"
#include "check.h"
#include "conform.h"
#include "cube_part.h"

/* The most that the closure may add to the cells. */
static const double MOST_CLOSED = 1.6, MOST_CLOSED_ONE_SIDE = 1.3;

static void squeeze(double p[4]) {
  p[0] = 2.0 * p[0];
}

static tsolid_boundary *boundary_of(tsolid_context *context, const cube_axis axis[3]) {
  cube_part part = cube_part_create(axis, squeeze);
  tsolid_boundary *boundary = NULL;
  tsolid_boundary_input input = {.bezier = &part.boundary};
  CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_OK);
  cube_part_free(&part);
  return boundary;
}

static int count_inner(tsolid_context *context, const tsolid_tmesh *tmesh) {
  tsolid_space space = {.allocator = tmesh->allocator, .tmesh = tmesh};
  CHECK(tsi_blending_create(context, &space) == TSOLID_OK);
  tsi_delete(&space.allocator, space.piece_start);
  tsi_delete(&space.allocator, space.piece);
  return space.n_inner;
}

/* All functions of the T-mesh under a boundary, and how much the closure added. */
static int count_functions(tsolid_context *context, const tsolid_boundary *boundary) {
  tsolid_tmesh *tmesh;
  if (!CHECK(tsolid_tmesh_create(context, boundary, NULL, &tmesh) == TSOLID_OK))
    return 0;
  CHECK(tmesh->n_cells <= MOST_CLOSED * tmesh->n_cells_before_closure);
  int n = count_inner(context, tmesh) + 2 * boundary->n_functions;
  tsolid_tmesh_free(tmesh);
  return n;
}

/* Inner functions of a core of n x n x n cells. */
static double tensor_inner(tsolid_context *context, int n) {
  static const double height[6] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5};
  int n_lines[3] = {n + 1, n + 1, n + 1},
      *box = calloc((size_t)(n * n) * (size_t)n, 6 * sizeof *box);
  double *line = calloc((size_t)n + 1, sizeof *line);
  const double *lines[3] = {line, line, line};
  tsolid_tmesh *tmesh = NULL;
  int count = 0;
  for (int i = 0; i <= n; i++)
    line[i] = (double)i / n;
  for (int c = 0; c < n * n * n; c++)
    for (int a = 0; a < 3; a++) {
      box[6 * c + a] = a == 0 ? c % n : a == 1 ? c / n % n : c / (n * n);
      box[6 * c + a + 3] = box[6 * c + a] + 1;
    }
  if (CHECK(tsi_tmesh_from_boxes(context, n_lines, lines, n * n * n, box, height, 1, &tmesh) ==
            TSOLID_OK))
    count = count_inner(context, tmesh);
  tsolid_tmesh_free(tmesh);
  free(line);
  free(box);
  return count;
}

/* The same for any n: from some n on it is a cubic in n, whose differences four cores give. */
static double tensor_inner_cubic(tsolid_context *context, double n) {
  enum { FIRST = 5 };
  double d[4], x = n - FIRST;
  for (int i = 0; i < 4; i++)
    d[i] = tensor_inner(context, FIRST + i);
  for (int order = 1; order < 4; order++)
    for (int i = 3; i >= order; i--)
      d[i] -= d[i - 1];
  return d[0] + x * (d[1] + (x - 1.0) / 2.0 * (d[2] + (x - 2.0) / 3.0 * d[3]));
}

/* Cells of the tensor core: all values of the axis trees. */
static int tensor_cells(tsolid_context *context, const tsolid_boundary *boundary) {
  tsi_arena arena = tsi_arena_create(context);
  tsi_axis_tree tree;
  CHECK(tsi_axis_tree_create(boundary, 0, 3, &arena, &tree));
  int n = tree.n_values - 1;
  tsi_arena_free(&arena);
  return n;
}

static void test_growth(tsolid_context *context) {
  int previous = 0;
  CHECK(tensor_inner_cubic(context, 11.0) == tensor_inner(context, 11));
  for (int n = 8; n <= 64; n *= 2) {
    cube_axis axis[3] = {{3, n, 1}, {3, n, 1}, {3, n, 1}};
    tsolid_boundary *boundary = boundary_of(context, axis);
    int count = count_functions(context, boundary);
    double tensor =
        tensor_inner_cubic(context, tensor_cells(context, boundary)) + 2.0 * boundary->n_functions;
    printf("%2d spans per side: %d functions, %.1f %% of a tensor core's\n", n, count,
           100.0 * count / tensor);
    CHECK(tensor_cells(context, boundary) == n);
    CHECK(n < 64 || (count <= 4.5 * previous && count <= 0.25 * tensor));
    CHECK(count > previous && count < tensor);
    previous = count;
    tsolid_boundary_free(boundary);
  }
}

/* Unequal spans, degrees and multiplicities. */
static void test_unequal(tsolid_context *context) {
  static const cube_axis axis[][3] = {{{3, 8, 1}, {2, 16, 1}, {1, 64, 1}},
                                      {{2, 33, 1}, {3, 20, 2}, {2, 9, 1}},
                                      {{3, 64, 1}, {2, 11, 1}, {3, 12, 1}},
                                      {{1, 48, 1}, {1, 47, 1}, {1, 13, 1}}};
  for (size_t i = 0; i < sizeof axis / sizeof *axis; i++) {
    tsolid_boundary *boundary = boundary_of(context, axis[i]);
    CHECK(count_functions(context, boundary) > 0);
    tsolid_boundary_free(boundary);
  }
}

/* ---- one fine side
 * ----------------------------------------------------------------------------------- */

enum { FINEST = 64, MOST_CONTROL = FINEST + 3 };

/* A cubic box whose high x side has n x n spans, the others 2 x 2. */
static tsolid_boundary *one_fine_side(tsolid_context *context, int n) {
  static double knot[6][MOST_CONTROL + 4], point[6][MOST_CONTROL * MOST_CONTROL * 3];
  tsolid_patch patch[6];
  tsolid_boundary *boundary = NULL;
  memset(patch, 0, sizeof patch);
  for (int side = 0; side < 6; side++) {
    int spans = side == 1 ? n : 2, m = spans + 3;
    for (int i = 0; i < m + 4; i++)
      knot[side][i] = i < 4 ? 0.0 : i > m ? 1.0 : (double)(i - 3) / spans;
    for (int k = 0; k < m * m; k++) {
      double *x = point[side] + 3 * k, at[2];
      for (int d = 0; d < 2; d++) {
        const double *g = knot[side] + (d ? k / m : k % m);
        at[d] = (g[1] + g[2] + g[3]) / 3.0;
      }
      x[side / 2] = side & 1;
      x[tsi_side_s(side)] = at[0];
      x[tsi_side_t(side)] = at[1];
      x[2] *= 2.0; /* no cube: the sides can be told apart */
    }
    patch[side] = (tsolid_patch){.degree = {3, 3}, .n_control = {m, m}, .points = point[side]};
    patch[side].knots[0] = patch[side].knots[1] = knot[side];
  }
  tsolid_boundary_input input = {.n_patches = 6, .patches = patch};
  CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_OK);
  return boundary;
}

/* The sum of the functions, where the T-mesh is closed; no tears in any case. */
static void check_basis(tsolid_context *context, const tsolid_space *space, int closed) {
  tsi_arena arena = tsi_arena_create(context);
  tsolid_basis_report r;
  tsi_face *face;
  int n_faces;
  if (CHECK(tsi_faces_create(context, space, &arena, &n_faces, &face) == TSOLID_OK) &&
      CHECK(tsi_basis_measure(context, space, n_faces, face, -1, &r) == TSOLID_OK)) {
    CHECK(!closed || r.sum_defect < 1e-12);
    CHECK_NEAR(r.diagonal_jump, 0.0, 1e-12);
    CHECK_NEAR(r.core_jump, 0.0, 1e-12);
  }
  tsi_arena_free(&arena);
}

/* All functions, relative to those that are not zero in the arm over the fine side. */
static double layer_ratio(tsolid_context *context, int n, int analysis_suitable_off) {
  tsolid_boundary *boundary = one_fine_side(context, n);
  tsolid_tmesh_options options = {.analysis_suitable_off = analysis_suitable_off};
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  int fine = 0, own = 0, total = 0;
  if (!boundary || !CHECK(tsolid_tmesh_create(context, boundary, &options, &tmesh) == TSOLID_OK) ||
      !CHECK(tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK))
    goto done;
  CHECK(tmesh->n_cells <= MOST_CLOSED_ONE_SIDE * tmesh->n_cells_before_closure);
  check_basis(context, space, !analysis_suitable_off);
  total = space->n_inner + 2 * space->n_surface;
  for (int side = 1; side < 6; side++)
    if (boundary->side[side].n_elements > boundary->side[fine].n_elements)
      fine = side;
  CHECK(boundary->side[fine].n_elements == n * n);
  char *seen = calloc((size_t)total, 1);
  for (int e = 0; e < space->n_elements; e++) {
    const tsi_element *element = &space->element[e];
    if (element->block != 1 + fine)
      continue;
    for (size_t i = space->inner_start[e]; i < space->inner_start[e + 1]; i++)
      seen[space->inner_function[i]] = 1;
    const tsi_lateral *l = &space->lateral[element->lateral];
    for (int i = l->function_first; i < l->function_end; i++) /* both layers */
      seen[space->n_inner + space->lateral_function[i]] =
          seen[total - space->n_surface + space->lateral_function[i]] = 1;
  }
  for (int f = 0; f < total; f++)
    own += seen[f];
  free(seen);
done:
  tsolid_space_free(space);
  tsolid_tmesh_free(tmesh);
  tsolid_boundary_free(boundary);
  return own ? (double)total / own : INFINITY;
}

/* One fine side and five coarse ones: its own layers outweigh the rest the more, the finer it is.
 * (At 64 spans the octree alone comes to 1.32, closed to 1.45: cubics that sum to one need two
 * cells between changes of level, per axis.) */
static void test_one_side(tsolid_context *context) {
  double closed[3], open[3];
  for (int k = 0; k < 3; k++) {
    closed[k] = layer_ratio(context, 16 << k, 0);
    open[k] = layer_ratio(context, 16 << k, 1);
    printf("one side with %d spans: all functions are %.3f of its layers', without closure %.3f\n",
           16 << k, closed[k], open[k]);
    CHECK(closed[k] >= open[k]);
    CHECK(k == 0 || (closed[k] < closed[k - 1] && open[k] < open[k - 1]));
  }
  CHECK(closed[2] < 1.46 && open[2] < 1.33);
}

int main(void) {
  tsolid_context *context;
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  test_growth(context);
  test_unequal(context);
  test_one_side(context);
  tsolid_context_free(context);
  return check_done();
}
