/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The paper's rational T-spline: without the closure the functions do not sum to one, the solid is
 * their rational combination all the same. Everything is compared with an evaluator that knows
 * nothing but knots: Cox-de Boor per function, no extraction, no elements. */
#include "check.h"

#include "conform.h"
#include "cube_part.h"
#include "evaluate.h"
#include "kernel.h"

static double random_unit(void) {
  static uint64_t state = 1913;
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) * 0x1p-53;
}

/* ---- the slow evaluator
 * ------------------------------------------------------------------------------ */

static double bspline(const double *knot, int degree, double x) {
  if (degree == 0)
    return knot[0] <= x && x < knot[1];
  double value = 0.0;
  if (knot[degree] > knot[0])
    value += (x - knot[0]) / (knot[degree] - knot[0]) * bspline(knot, degree - 1, x);
  if (knot[degree + 1] > knot[1])
    value +=
        (knot[degree + 1] - x) / (knot[degree + 1] - knot[1]) * bspline(knot + 1, degree - 1, x);
  return value;
}

static double inner_function(const tsolid_space *space, int f, int block, const double u[3]) {
  double value = 0.0;
  for (int i = space->piece_start[f]; i < space->piece_start[f + 1]; i++) {
    double product = 1.0;
    if (space->piece[i].block >= 0 && space->piece[i].block != block)
      continue;
    for (int d = 0; d < 3; d++) {
      double knot[5];
      for (int k = 0; k < 5; k++)
        knot[k] = space->tmesh->plane_value[d][space->piece[i].knot[d][k]];
      product *= bspline(knot, 3, u[d]);
    }
    value += product;
  }
  return value;
}

static double power(double x, int n) {
  return n == 0 ? 1.0 : x * power(x, n - 1);
}

static double bernstein(int n, int i, double x) {
  double binomial = 1.0;
  for (int k = 0; k < i; k++)
    binomial = binomial * (n - k) / (k + 1);
  return binomial * power(x, i) * power(1.0 - x, n - i);
}

/* Adds the surface functions' part of sum w N (P, 1) at a point of an arm. */
static void add_surface(const tsolid_solid *solid, int side, const double u[3], double h[5]) {
  const tsolid_space *space = solid->space;
  const tsi_side *s = &space->boundary->side[side];
  int axis = side / 2, p = s->degree[0], q = s->degree[1];
  double height = space->tmesh->arm_height[side], r = side & 1 ? u[axis] - 1.0 : -u[axis];
  double r1 = 0.5 * height, at[2] = {u[axis == 0], u[axis == 2 ? 1 : 2]};
  const double knots[2][5] = {{0.0, r1, height, height, height},
                              {r1, height, height, height, height}};
  for (int e = 0; e < s->n_elements; e++) {
    const double *b = s->box + 4 * e;
    if (!(b[0] <= at[0] && at[0] < b[1] && b[2] <= at[1] && at[1] < b[3]))
      continue;
    double x = (at[0] - b[0]) / (b[1] - b[0]), y = (at[1] - b[2]) / (b[3] - b[2]);
    for (int k = s->function_start[e]; k < s->function_start[e + 1]; k++) {
      double lateral = 0.0;
      for (int i = 0; i < (p + 1) * (q + 1); i++)
        lateral += s->coefficient[k * (p + 1) * (q + 1) + i] * bernstein(p, i % (p + 1), x) *
                   bernstein(q, i / (p + 1), y);
      for (int layer = 0; layer < 2; layer++) {
        double value = lateral * bspline(knots[layer], 3, r);
        const double *control =
            solid->control + 4 * (space->n_inner + layer * space->n_surface + s->function[k]);
        for (int c = 0; c < 4; c++)
          h[c] += value * control[c];
        h[4] += value;
      }
    }
  }
}

/* h = sum w N P, sum w N, sum N. */
static void slow_sums(const tsolid_solid *solid, int block, const double u[3], double h[5]) {
  memset(h, 0, 5 * sizeof *h);
  for (int f = 0; f < solid->space->n_inner; f++) {
    double value = inner_function(solid->space, f, block, u);
    for (int c = 0; c < 4; c++)
      h[c] += value * solid->control[4 * f + c];
    h[4] += value;
  }
  if (block > 0)
    add_surface(solid, block - 1, u, h);
}

static void slow_point(const tsolid_solid *solid, int block, const double u[3], double x[3]) {
  double h[5];
  slow_sums(solid, block, u, h);
  for (int c = 0; c < 3; c++)
    x[c] = h[c] / h[3];
}

/* Columns by differences of fourth order. */
static void slow_jacobian(const tsolid_solid *solid, int block, const double u[3], double step,
                          double j[3][3]) {
  for (int d = 0; d < 3; d++) {
    static const double factor[4] = {1.0, -8.0, 8.0, -1.0}, place[4] = {-2.0, -1.0, 1.0, 2.0};
    memset(j[d], 0, sizeof j[d]);
    for (int k = 0; k < 4; k++) {
      double v[3] = {u[0], u[1], u[2]}, x[3];
      v[d] += place[k] * step;
      slow_point(solid, block, v, x);
      for (int c = 0; c < 3; c++)
        j[d][c] += factor[k] * x[c] / (12.0 * step);
    }
  }
}

static double determinant(double j[3][3]) {
  return j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1]) -
         j[0][1] * (j[1][0] * j[2][2] - j[1][2] * j[2][0]) +
         j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0]);
}

/* ---- checks
 * ------------------------------------------------------------------------------------------ */

static void inside_element(const tsi_element *e, double u[3]) {
  for (int d = 0; d < 3; d++)
    u[d] = e->box[d] + (0.1 + 0.8 * random_unit()) * (e->box[d + 3] - e->box[d]);
}

/* Points, derivatives, and the defect of the sum that the report states. */
static void check_evaluation(tsolid_context *context, const tsolid_solid *solid) {
  const tsolid_space *space = solid->space;
  double scale = space->boundary->scale, defect = 0.0;
  for (int e = 0; e < space->n_elements; e += 1 + space->n_elements / 100) {
    const tsi_element *element = &space->element[e];
    double u[3], x[3], j[3][3], found[12], h[5], width = 1.0;
    inside_element(element, u);
    for (int d = 0; d < 3; d++)
      width = fmin(width, element->box[d + 3] - element->box[d]);
    CHECK(tsolid_solid_evaluate(context, solid, element->block, u, 1, found) == TSOLID_OK);
    slow_point(solid, element->block, u, x);
    slow_jacobian(solid, element->block, u, 0.02 * width, j);
    slow_sums(solid, element->block, u, h);
    defect = fmax(defect, fabs(h[4] - 1.0));
    for (int c = 0; c < 3; c++) {
      CHECK_NEAR(found[c], x[c], 1e-13 * scale);
      for (int d = 0; d < 3; d++)
        CHECK_NEAR(found[3 + 3 * d + c], j[d][c], 1e-5 * scale);
    }
    CHECK(determinant(j) > 0.0);
  }
  tsi_arena arena = tsi_arena_create(context);
  tsolid_basis_report r;
  tsi_face *face;
  int n_faces;
  CHECK(tsi_faces_create(context, space, &arena, &n_faces, &face) == TSOLID_OK);
  CHECK(tsi_basis_measure(context, space, n_faces, face, -1, &r) == TSOLID_OK);
  CHECK(defect > 0.02 && defect <= r.sum_defect && r.sum_defect < 2.0);
  CHECK_NEAR(r.diagonal_jump, 0.0, 1e-12);
  CHECK_NEAR(r.core_jump, 0.0, 1e-12);
  CHECK(r.smallest_value >= 0.0);
  tsi_arena_free(&arena);
}

/* Column by column at the first grid point of every element, rows of 9. */
static void take_corner(const void *data, int element, int n, int stride, const double *weight,
                        const double *j, double *energy, double *g) {
  double *corner = (double *)(uintptr_t)data;
  (void)n, (void)weight, (void)g;
  for (int i = 0; i < 9; i++)
    corner[9 * element + i] = j[i * stride];
  *energy += 0.0;
}

/* What the optimisation sees of the Jacobian is what there is. */
static void check_kernel(tsolid_context *context, const tsolid_solid *solid) {
  const tsolid_space *space = solid->space;
  int n = space->n_inner + 2 * space->n_surface;
  double *position = calloc(3 * (size_t)n, sizeof *position), energy;
  double *corner = calloc(9 * (size_t)space->n_elements, sizeof *corner);
  for (int i = 0; i < 3 * n; i++)
    position[i] = solid->control[4 * (i / 3) + i % 3] / solid->control[4 * (i / 3) + 3];
  tsi_kernel *kernel;
  if (CHECK(tsi_kernel_create(context, space, solid->control, TSI_GRID, &kernel) == TSOLID_OK)) {
    tsi_kernel_energy(kernel, position, take_corner, corner, NULL, &energy, NULL, NULL);
    for (int e = 0; e < space->n_elements; e += 7) {
      const double *box = space->element[e].box;
      double found[12];
      CHECK(tsolid_solid_evaluate(context, solid, space->element[e].block, box, 1, found) ==
            TSOLID_OK);
      for (int i = 0; i < 9; i++)
        CHECK_NEAR(corner[9 * e + i],
                   found[3 + 3 * (i % 3) + i / 3] * (box[i % 3 + 3] - box[i % 3]),
                   1e-12 * space->boundary->scale);
    }
    tsi_kernel_free(kernel);
  }
  free(corner);
  free(position);
}

/* The certificate proves, and does not where an inner point is dragged through its neighbours. */
static void check_certificate(tsolid_context *context, const tsolid_solid *solid) {
  const tsolid_space *space = solid->space;
  size_t n = (size_t)space->n_inner + 2 * (size_t)space->n_surface;
  tsolid_certificate certificate;
  CHECK(tsolid_certify(context, solid, NULL, &certificate, NULL) == TSOLID_OK);
  CHECK(certificate.verdict == TSOLID_POSITIVE);
  double *control = malloc(4 * n * sizeof *control);
  memcpy(control, solid->control, 4 * n * sizeof *control);
  control[4 * (space->n_inner / 2)] += 2.0 * space->boundary->scale;
  tsolid_solid *folded;
  if (CHECK(tsolid_solid_from_control(context, space, control, &folded) == TSOLID_OK)) {
    CHECK(tsolid_certify(context, folded, NULL, &certificate, NULL) == TSOLID_OK);
    if (CHECK(certificate.verdict == TSOLID_NOT_POSITIVE && certificate.element >= 0)) {
      const tsi_element *e = &space->element[certificate.element];
      double j[3][3], u[3], width = 1.0;
      for (int d = 0; d < 3; d++) {
        width = fmin(width, e->box[d + 3] - e->box[d]);
        double margin = 1e-3 * (e->box[d + 3] - e->box[d]); /* differences stay in the element */
        u[d] = fmin(fmax(certificate.u[d], e->box[d] + margin), e->box[d + 3] - margin);
      }
      slow_jacobian(folded, e->block, u, 1e-4 * width, j);
      CHECK(determinant(j) < 1e-2);
    }
    tsolid_solid_free(folded);
  }
  free(control);
}

static int same_files(const char *a, const char *b) {
  FILE *f = fopen(a, "rb"), *g = fopen(b, "rb");
  int same = f && g, x = 0, y = 0;
  while (same && x != EOF) {
    x = fgetc(f);
    y = fgetc(g);
    same = x == y;
  }
  if (f)
    fclose(f);
  if (g)
    fclose(g);
  return same;
}

/* The file rebuilds the same T-mesh: without the option the closure would add functions. */
static void check_file(tsolid_context *context, const tsolid_solid *solid) {
  static const char a[] = "test_rational_a.tsolid", b[] = "test_rational_b.tsolid";
  tsolid_solid *read = NULL;
  CHECK(tsolid_write_tsolid(context, solid, a) == TSOLID_OK);
  if (CHECK(tsolid_read_tsolid(context, a, &read) == TSOLID_OK)) {
    CHECK(read->space->n_inner == solid->space->n_inner);
    CHECK(tsolid_write_tsolid(context, read, b) == TSOLID_OK);
    CHECK(same_files(a, b));
  }
  tsolid_solid_free(read);
  remove(a);
  remove(b);
}

static void test_part(tsolid_context *context, cube_map map, int isotropic, double noise) {
  static const cube_axis axis[3] = {{3, 12, 1}, {2, 10, 1}, {2, 4, 1}};
  cube_part part = cube_part_create(axis, map);
  tsolid_boundary_input input = {.bezier = &part.boundary};
  tsolid_tmesh_options options = {.isotropic = isotropic, .analysis_suitable_off = 1};
  cube_solid s = {.solid = NULL};
  tsolid_tmesh *closed = NULL;
  if (CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &s.boundary) == TSOLID_OK) &&
      CHECK(tsolid_tmesh_create(context, s.boundary, &options, &s.tmesh) == TSOLID_OK) &&
      CHECK(tsolid_space_create(context, s.boundary, s.tmesh, &s.space) == TSOLID_OK)) {
    double *control = cube_control(s.space, noise);
    CHECK(tsolid_solid_from_control(context, s.space, control, &s.solid) == TSOLID_OK);
    free(control);
    options.analysis_suitable_off = 0;
    CHECK(tsolid_tmesh_create(context, s.boundary, &options, &closed) == TSOLID_OK);
    CHECK(closed->n_cells > s.tmesh->n_cells); /* there was something to close */
    CHECK(closed->n_cells_before_closure == s.tmesh->n_cells);
    check_evaluation(context, s.solid);
    check_kernel(context, s.solid);
    check_certificate(context, s.solid);
    check_file(context, s.solid);
  }
  tsolid_tmesh_free(closed);
  cube_solid_free(&s);
  cube_part_free(&part);
}

int main(void) {
  tsolid_context *context;
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  test_part(context, cube_wave, 0, 0.0); /* all weights one: W is no constant nevertheless */
  test_part(context, cube_rational, 1, 0.0);
  tsolid_context_free(context);
  return check_done();
}
