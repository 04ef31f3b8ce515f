/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A sharp core surface: the functions are a basis and C^0 across all of it; the start is the map
 * that is smooth block by block, straight lines through the arms, and follows it by fourth order; a
 * file keeps the choice. */
#include "check.h"

#include "cube_part.h"
#include "evaluate.h"
#include "quadrature.h"

/* The start of a cube of n_spans cubic spans per side. */
static int make(tsolid_context *context, cube_map map, int n_spans, int min_cells, int sharp,
                cube_solid *s) {
  cube_axis axis[3] = {{3, n_spans, 1}, {3, n_spans, 1}, {3, n_spans, 1}};
  cube_part part = cube_part_create(axis, map);
  tsolid_boundary_input input = {.bezier = &part.boundary};
  tsolid_tmesh_options options = {.min_cells = min_cells, .sharp_core = sharp};
  *s = (cube_solid){.solid = NULL};
  tsolid_status status = tsolid_boundary_create(context, &input, NULL, NULL, &s->boundary);
  if (status == TSOLID_OK)
    status = tsolid_tmesh_create(context, s->boundary, &options, &s->tmesh);
  if (status == TSOLID_OK)
    status = tsolid_space_create(context, s->boundary, s->tmesh, &s->space);
  if (status == TSOLID_OK)
    status = tsolid_solid_create(context, s->space, &s->solid);
  cube_part_free(&part);
  return CHECK(status == TSOLID_OK);
}

/* Puts scattered control points in the start's place: no smoother than the functions are. */
static void scatter(tsolid_context *context, cube_solid *s) {
  double *control = cube_control(s->space, 0.02);
  tsolid_solid_free(s->solid);
  s->solid = NULL;
  CHECK(tsolid_solid_from_control(context, s->space, control, &s->solid) == TSOLID_OK);
  free(control);
}

static void check_basis(tsolid_context *context, const cube_solid *s, int n, const tsi_face *face) {
  tsolid_basis_report r;
  if (!CHECK(tsi_basis_measure(context, s->space, n, face, 0, &r) == TSOLID_OK))
    return;
  CHECK_NEAR(r.sum_defect, 0.0, 1e-12);
  CHECK(r.smallest_value >= 0.0);
  CHECK_NEAR(r.diagonal_jump, 0.0, 1e-13);
  CHECK_NEAR(r.core_jump, 0.0, 1e-13);
  CHECK(r.rank_measured && r.inner_eigenvalue > r.inner_roundoff);
  CHECK(r.surface_eigenvalue > r.surface_roundoff);
}

/* Area of the core surface, in cross coordinates, where the measured order is as given. */
static double area_of_order(int n, const tsi_face *face, const int *order, int wanted) {
  double area = 0.0;
  for (int i = 0; i < n; i++)
    if (face[i].kind == TSI_FACE_CORE && order[i] == wanted)
      area += (face[i].box[1] - face[i].box[0]) * (face[i].box[3] - face[i].box[2]);
  return area;
}

static void test_functions(tsolid_context *context, int n_spans, int min_cells) {
  for (int sharp = 0; sharp < 2; sharp++) {
    cube_solid s;
    tsi_arena arena = tsi_arena_create(context);
    tsolid_continuity_report r;
    tsi_face *face;
    int n;
    if (make(context, cube_wave, n_spans, min_cells, sharp, &s) &&
        CHECK(tsi_faces_create(context, s.space, &arena, &n, &face) == TSOLID_OK)) {
      int *order = tsi_arena_new(&arena, (size_t)n, sizeof *order);
      int *expected = tsi_arena_new(&arena, (size_t)n, sizeof *expected);
      check_basis(context, &s, n, face);
      scatter(context, &s);
      CHECK(tsi_continuity_measure(context, s.solid, n, face, order, expected, &r) == TSOLID_OK);
      CHECK(r.n_below_expected == 0);
      double smooth = area_of_order(n, face, expected, 2);
      if (sharp)
        CHECK_NEAR(area_of_order(n, face, order, 0), 6.0, 1e-12);
      CHECK(min_cells == 0 || area_of_order(n, face, order, 2) >= smooth);
      CHECK(sharp ? smooth == 0.0 : min_cells == 0 || smooth > 0.3);
    }
    tsi_arena_free(&arena);
    cube_solid_free(&s);
  }
}

/* ---- the start ---------------------------------------------------------------------------------
 */

static double random_unit(void) {
  static uint64_t state = 5;
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) * 0x1p-53;
}

/* The largest |X(rho) - (1 - rho) X(0) - rho X(1)| on lines through the arms, in units of the part.
 */
static double bend_of_lines(tsolid_context *context, const cube_solid *s) {
  double worst = 0.0;
  for (int i = 0; i < 600; i++) {
    int side = i % 6, axis = tsi_side_axis(side);
    double u[3], x[3][3], rho = random_unit(), height = s->tmesh->arm_height[side];
    for (int a = 0; a < 3; a++)
      u[a] = random_unit();
    for (int k = 0; k < 3; k++) {
      double depth = height * (k == 2 ? rho : k);
      u[axis] = side & 1 ? 1.0 + depth : -depth;
      CHECK(tsolid_solid_evaluate(context, s->solid, 1 + side, u, 0, x[k]) == TSOLID_OK);
    }
    for (int c = 0; c < 3; c++)
      worst = fmax(worst, fabs(x[2][c] - (1.0 - rho) * x[0][c] - rho * x[1][c]));
  }
  return worst / s->boundary->scale;
}

static void cube_bent(double p[4]) {
  double z = p[2], bend = 0.4 * p[0] * p[0] + 0.3 * p[1] * p[1] * p[0];
  p[2] = z + bend;
  p[0] += 0.2 * z * z;
}

/* How far |x - 1/2| is from `factor` |u - 1/2|, both in ascending order: the canonical position may
 * have turned the cube. */
static double scaled_defect(const double u[3], const double x[3], double factor) {
  double p[3], q[3], worst = 0.0;
  for (int c = 0; c < 3; c++) {
    p[c] = factor * fabs(u[c] - 0.5);
    q[c] = fabs(x[c] - 0.5);
  }
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 2; k++) {
      double low = fmin(p[k], p[k + 1]), high = fmax(p[k], p[k + 1]);
      p[k] = low;
      p[k + 1] = high;
      low = fmin(q[k], q[k + 1]);
      high = fmax(q[k], q[k + 1]);
      q[k] = low;
      q[k + 1] = high;
    }
  for (int c = 0; c < 3; c++)
    worst = fmax(worst, fabs(p[c] - q[c]));
  return worst;
}

/* On the unit cube the core is a smaller cube: by the least share that an arm has. On a bent one
 * the lines through the arms are straight, of which a spline through the map's values as control
 * points is far: it is off by the square of a cell. */
static void test_start(tsolid_context *context) {
  cube_solid s;
  if (make(context, NULL, 2, 4, 1, &s)) {
    double share = 1.0, worst = 0.0;
    for (int side = 0; side < 6; side++) {
      const double *height = s.tmesh->arm_height + 2 * tsi_side_axis(side);
      share = fmin(share, height[side & 1] / (1.0 + height[0] + height[1]));
    }
    for (int i = 0; i < 100; i++) {
      double u[3] = {random_unit(), random_unit(), random_unit()}, x[3];
      CHECK(tsolid_solid_evaluate(context, s.solid, 0, u, 0, x) == TSOLID_OK);
      worst = fmax(worst, scaled_defect(u, x, 1.0 - 2.0 * share));
    }
    CHECK_NEAR(worst, 0.0, 1e-7);
    CHECK_NEAR(bend_of_lines(context, &s), 0.0, 1e-7);
  }
  cube_solid_free(&s);
  for (int n_cells = 4; n_cells <= 8; n_cells *= 2) {
    if (make(context, cube_bent, 1, n_cells, 1, &s))
      CHECK_NEAR(bend_of_lines(context, &s), 0.0, 1e-6);
    cube_solid_free(&s);
  }
}

/* ---- the file ----------------------------------------------------------------------------------
 */

static void test_file(tsolid_context *context) {
  cube_solid s;
  tsolid_solid *read = NULL;
  const char *path = "test_sharp_core.tsolid";
  if (make(context, cube_wave, 2, 8, 1, &s) &&
      CHECK(tsolid_write_tsolid(context, s.solid, path) == TSOLID_OK) &&
      CHECK(tsolid_read_tsolid(context, path, &read) == TSOLID_OK)) {
    size_t n = (size_t)s.space->n_inner + 2 * (size_t)s.space->n_surface;
    CHECK(read->space->tmesh->flags == TSI_TMESH_SHARP_CORE);
    CHECK(read->space->n_inner == s.space->n_inner);
    CHECK(memcmp(read->control, s.solid->control, 4 * n * sizeof(double)) == 0);
  }
  remove(path);
  tsolid_solid_free(read);
  cube_solid_free(&s);
}

int main(void) {
  tsolid_context *context;
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  test_functions(context, 2, 8);
  test_functions(context, 9, 0); /* cells of several sizes */
  test_start(context);
  test_file(context);
  tsolid_context_free(context);
  return check_done();
}
