/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The functions are a basis, for every degree, knot multiplicity and number of cells; and the
 * measurements find what is broken on purpose: a doubled function, a torn trace, a wrong sum. */
#include "check.h"

#include "cube_part.h"
#include "evaluate.h"

static tsolid_status measure(tsolid_context *context, const tsolid_space *space, int limit,
                             tsolid_basis_report *report) {
  tsi_arena arena = tsi_arena_create(context);
  tsi_face *face;
  int n;
  tsolid_status status = tsi_faces_create(context, space, &arena, &n, &face);
  if (status == TSOLID_OK)
    status = tsi_basis_measure(context, space, n, face, limit, report);
  tsi_arena_free(&arena);
  return status;
}

static void check_is_basis(tsolid_context *context, const tsolid_space *space) {
  tsolid_basis_report r;
  if (!CHECK(measure(context, space, 0, &r) == TSOLID_OK))
    return;
  CHECK_NEAR(r.sum_defect, 0.0, 1e-12);
  CHECK(r.smallest_value >= 0.0);
  CHECK_NEAR(r.diagonal_jump, 0.0, 1e-13);
  CHECK_NEAR(r.core_jump, 0.0, 1e-13);
  CHECK(r.rank_measured);
  CHECK(r.inner_eigenvalue > r.inner_roundoff);
  CHECK(r.surface_eigenvalue > r.surface_roundoff);
  CHECK(r.inner_eigenvalue < 1.0 && r.surface_eigenvalue < 1.0);
  CHECK_NEAR(r.inner_roundoff, 100.0 * space->n_inner * 0x1p-52, 0.0);
}

/* ---- eigenvalues -------------------------------------------------------------------------------
 */

/* All eigenvalues of the diagonally scaled matrix by Jacobi rotations; returns the smallest. */
static double dense_smallest(const tsi_symmetric *m) {
  int n = m->n;
  double *a = calloc((size_t)n * (size_t)n, sizeof *a), least = (double)INFINITY, off = 1.0;
  for (int i = 0; i < n; i++)
    for (size_t k = m->start[i]; k < m->start[i + 1]; k++)
      a[i * n + m->column[k]] = m->value[k];
  double *scale = calloc((size_t)n, sizeof *scale);
  for (int i = 0; i < n; i++)
    scale[i] = sqrt(a[i * n + i]);
  for (int i = 0; i < n * n; i++)
    a[i] /= scale[i / n] * scale[i % n];
  for (int sweep = 0; sweep < 40 && off > 1e-30; sweep++) {
    off = 0.0;
    for (int p = 0; p < n; p++)
      for (int q = p + 1; q < n; q++) {
        off += a[p * n + q] * a[p * n + q];
        if (a[p * n + q] == 0.0)
          continue;
        double theta = 0.5 * (a[q * n + q] - a[p * n + p]) / a[p * n + q];
        double t = (theta >= 0.0 ? 1.0 : -1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
        double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
        for (int k = 0; k < n; k++) {
          double x = a[k * n + p], y = a[k * n + q];
          a[k * n + p] = c * x - s * y;
          a[k * n + q] = s * x + c * y;
        }
        for (int k = 0; k < n; k++) {
          double x = a[p * n + k], y = a[q * n + k];
          a[p * n + k] = c * x - s * y;
          a[q * n + k] = s * x + c * y;
        }
      }
  }
  for (int i = 0; i < n; i++)
    least = fmin(least, a[i * n + i]);
  free(scale);
  free(a);
  return least;
}

/* The matrix of the same functions and one more: (1 - share) of number `from` plus share of
 * `other`, so that share = 0 doubles a function. Rows in malloc'ed memory. */
static tsi_symmetric append_function(const tsi_symmetric *m, int from, int other, double share) {
  int n = m->n, size = n + 1;
  double *a = calloc((size_t)size * (size_t)size, sizeof *a);
  for (int i = 0; i < n; i++)
    for (size_t k = m->start[i]; k < m->start[i + 1]; k++)
      a[i * size + m->column[k]] = m->value[k];
  for (int i = 0; i < n; i++)
    a[i * size + n] = a[n * size + i] =
        (1.0 - share) * a[from * size + i] + share * a[other * size + i];
  a[n * size + n] = (1.0 - share) * a[n * size + from] + share * a[n * size + other];
  tsi_symmetric out = {.n = size};
  out.start = calloc((size_t)size + 1, sizeof *out.start);
  out.column = calloc((size_t)size * (size_t)size, sizeof *out.column);
  out.value = calloc((size_t)size * (size_t)size, sizeof *out.value);
  size_t count = 0;
  for (int i = 0; i < size; i++) {
    for (int j = 0; j < size; j++)
      if (a[i * size + j] != 0.0) {
        out.column[count] = j;
        out.value[count++] = a[i * size + j];
      }
    out.start[i + 1] = count;
  }
  free(a);
  return out;
}

static void free_matrix(tsi_symmetric *m) {
  free(m->start);
  free(m->column);
  free(m->value);
}

/* A copy, for every measurement scales in place. */
static double smallest(tsolid_context *context, const tsi_symmetric *m, tsi_eigen_method method) {
  tsi_symmetric copy = *m;
  double eigenvalue = (double)NAN;
  copy.value = malloc(m->start[m->n] * sizeof *copy.value);
  memcpy(copy.value, m->value, m->start[m->n] * sizeof *copy.value);
  CHECK(tsi_smallest_eigenvalue(context, &copy, method, &eigenvalue) == TSOLID_OK);
  free(copy.value);
  return eigenvalue;
}

/* Any one function doubled is found, by both methods; one that is merely close is not. */
static void check_doubled(tsolid_context *context, const tsi_symmetric *m) {
  double roundoff = 100.0 * (m->n + 1) * 0x1p-52;
  for (int from = 0; from < m->n; from += 1 + m->n / 5) {
    int other = from > 0 ? from - 1 : 1;
    tsi_symmetric doubled = append_function(m, from, other, 0.0);
    CHECK(smallest(context, &doubled, TSI_EIGEN_DIRECT) <= roundoff);
    CHECK(smallest(context, &doubled, TSI_EIGEN_ITERATIVE) <= roundoff);
    free_matrix(&doubled);
  }
}

/* A doubled function with a part of its own of 1e-7 in the square of its norm: a small eigenvalue,
 * but no zero, and both methods agree on it. */
static void check_close(tsolid_context *context, const tsi_symmetric *m) {
  tsi_symmetric close = append_function(m, m->n / 2, m->n / 2 + 1, 0.0);
  close.value[close.start[close.n] - 1] *= 1.0 + 1e-7;
  double direct = smallest(context, &close, TSI_EIGEN_DIRECT);
  double iterative = smallest(context, &close, TSI_EIGEN_ITERATIVE);
  CHECK(direct > 100.0 * close.n * 0x1p-52 && direct < 1e-7);
  CHECK_NEAR(iterative, direct, 1e-2 * direct);
  free_matrix(&close);
}

static void check_eigenvalues(tsolid_context *context, const cube_solid *s, int dense) {
  tsi_arena arena = tsi_arena_create(context);
  tsi_symmetric inner, surface;
  if (CHECK(tsi_mass_inner(context, s->space, &arena, &inner) == TSOLID_OK) &&
      CHECK(tsi_mass_surface(context, s->boundary, &arena, &surface) == TSOLID_OK)) {
    tsi_symmetric *both[2] = {&inner, &surface};
    for (int k = 0; k < 2; k++) {
      double direct = smallest(context, both[k], TSI_EIGEN_DIRECT);
      CHECK_NEAR(smallest(context, both[k], TSI_EIGEN_ITERATIVE), direct, 2e-3 * direct);
      CHECK_NEAR(smallest(context, both[k], TSI_EIGEN_AUTO), direct, 2e-3 * direct);
      if (dense && both[k]->n < 200)
        CHECK_NEAR(dense_smallest(both[k]), direct, 2e-3 * direct);
      check_doubled(context, both[k]);
    }
    check_close(context, &inner);
    double volume = 0.0, measure_of_cross = 1.0, area = 0.0;
    for (size_t k = 0; k < inner.start[inner.n]; k++)
      volume += inner.value[k];
    for (size_t k = 0; k < surface.start[surface.n]; k++)
      area += surface.value[k];
    for (int side = 0; side < 6; side++)
      measure_of_cross += s->tmesh->arm_height[side];
    CHECK_NEAR(area, 6.0, 1e-12); /* the square of sum N_i = 1, integrated */
    CHECK(volume > 1.0 && volume < measure_of_cross);
  }
  tsi_arena_free(&arena);
}

/* A function that is zero everywhere. */
static void check_zero_function(tsolid_context *context) {
  size_t start[] = {0, 1, 1};
  int column[] = {0};
  double value[] = {2.0}, eigenvalue = 1.0;
  tsi_symmetric m = {2, start, column, value};
  CHECK(tsi_smallest_eigenvalue(context, &m, TSI_EIGEN_AUTO, &eigenvalue) == TSOLID_OK);
  CHECK(eigenvalue == 0.0);
}

/* ---- what is broken on purpose -----------------------------------------------------------------
 */

/* An element of an arm at r = 0, or of an arm at a diagonal. */
static int find_element(const tsolid_space *space, int at_diagonal) {
  for (int e = 0; e < space->n_elements; e++) {
    const tsi_element *element = &space->element[e];
    if (element->block == 0)
      continue;
    int axis = tsi_side_axis(element->block - 1), b = (axis + 1) % 3;
    int at_core = element->box[axis] == 1.0 || element->box[axis + 3] == 0.0;
    if (at_diagonal ? element->box[b] == 0.0 && !at_core : at_core && element->box[b] > 0.0)
      return e;
  }
  return -1;
}

/* Swaps the rows of one function on one element for others: its trace and the sum change there. */
static void check_torn(tsolid_context *context, cube_solid *s, int at_diagonal) {
  tsolid_basis_report before, after;
  int e = find_element(s->space, at_diagonal);
  if (!CHECK(e >= 0))
    return;
  CHECK(measure(context, s->space, -1, &before) == TSOLID_OK);
  size_t entry = s->space->inner_start[e];
  int kept[3], other = s->space->n_rows;
  double *row = malloc(((size_t)other + 1) * 4 * sizeof *row), *old = s->space->row;
  memcpy(row, old, (size_t)other * 4 * sizeof *row);
  memcpy(kept, s->space->inner_row[entry], sizeof kept);
  for (int k = 0; k < 4; k++)
    row[4 * other + k] = 0.25;
  for (int d = 0; d < 3; d++)
    s->space->inner_row[entry][d] = other;
  s->space->row = row;
  CHECK(measure(context, s->space, -1, &after) == TSOLID_OK);
  s->space->row = old;
  memcpy(s->space->inner_row[entry], kept, sizeof kept);
  free(row);
  CHECK(!before.rank_measured && isnan(before.inner_eigenvalue));
  CHECK(before.sum_defect < 1e-12 && after.sum_defect > 1e-3);
  CHECK((at_diagonal ? before.diagonal_jump : before.core_jump) < 1e-12);
  CHECK((at_diagonal ? after.diagonal_jump : after.core_jump) > 1e-3);
}

static void check_negative(tsolid_context *context, cube_solid *s) {
  tsolid_basis_report r;
  double *value = &s->space->row[4 * s->space->inner_row[0][1]], kept = *value;
  *value = -1e-9;
  CHECK(measure(context, s->space, -1, &r) == TSOLID_OK);
  CHECK(r.smallest_value < 0.0);
  *value = kept;
  kept = s->space->lateral_coefficient[3];
  s->space->lateral_coefficient[3] = -1e-9;
  CHECK(measure(context, s->space, -1, &r) == TSOLID_OK);
  CHECK(r.smallest_value < 0.0);
  s->space->lateral_coefficient[3] = kept;
}

/* One surface function given twice, each half as large: the sum is one, the rank is not full. */
static void check_doubled_surface(tsolid_context *context) {
  cube_axis axis[3] = {{3, 2, 1}, {3, 2, 1}, {3, 2, 1}};
  cube_part part = cube_part_create(axis, NULL);
  tsi_arena arena = tsi_arena_create(context);
  tsolid_boundary boundary = {.n_functions = part.boundary.n_functions + 1};
  int victim = 5;
  for (int k = 0; k < 6; k++) {
    const tsolid_bezier_side *from = &part.boundary.side[k];
    tsi_side *to = &boundary.side[k];
    int n = from->n_elements, total = from->function_start[n], at = 0;
    size_t size = (size_t)(from->degree[0] + 1) * (size_t)(from->degree[1] + 1);
    *to = (tsi_side){.degree = {from->degree[0], from->degree[1]}, .n_elements = n};
    to->box = (double *)(uintptr_t)from->box;
    to->function_start = tsi_arena_new(&arena, (size_t)n + 1, sizeof(int));
    to->function = tsi_arena_new(&arena, 2 * (size_t)total, sizeof(int));
    to->coefficient = tsi_arena_new(&arena, 2 * (size_t)total * size, sizeof(double));
    for (int e = 0; e < n; e++) {
      for (int i = from->function_start[e]; i < from->function_start[e + 1]; i++)
        for (int copy = 0; copy < (from->function[i] == victim ? 2 : 1); copy++, at++) {
          to->function[at] = copy ? boundary.n_functions - 1 : from->function[i];
          for (size_t c = 0; c < size; c++)
            to->coefficient[(size_t)at * size + c] =
                from->coefficient[(size_t)i * size + c] * (from->function[i] == victim ? 0.5 : 1.0);
        }
      to->function_start[e + 1] = at;
    }
  }
  tsi_symmetric mass;
  if (CHECK(tsi_mass_surface(context, &boundary, &arena, &mass) == TSOLID_OK))
    CHECK(smallest(context, &mass, TSI_EIGEN_DIRECT) <= 100.0 * mass.n * 0x1p-52);
  tsi_arena_free(&arena);
  cube_part_free(&part);
}

/* ---- all together ------------------------------------------------------------------------------
 */

static void check_threads(const cube_solid *s) {
  tsolid_basis_report report[2];
  for (int k = 0; k < 2; k++) {
    tsolid_context_options options = {.n_threads = k ? 3 : 1};
    tsolid_context *context;
    memset(&report[k], 0, sizeof report[k]);
    if (CHECK(tsolid_context_create(&options, &context) == TSOLID_OK))
      CHECK(measure(context, s->space, 0, &report[k]) == TSOLID_OK);
    tsolid_context_free(context);
  }
  CHECK(report[0].inner_eigenvalue == report[1].inner_eigenvalue);
  CHECK(report[0].surface_eigenvalue == report[1].surface_eigenvalue);
  CHECK(report[0].sum_defect == report[1].sum_defect);
  CHECK(report[0].diagonal_jump == report[1].diagonal_jump);
  CHECK(report[0].core_jump == report[1].core_jump);
}

static void check_case(tsolid_context *context, const cube_axis axis[3], int min_cells, int deep) {
  cube_solid s;
  if (CHECK(cube_solid_create(context, axis, NULL, min_cells, 0.0, &s))) {
    check_is_basis(context, s.space);
    if (deep) {
      check_eigenvalues(context, &s, 1);
      check_torn(context, &s, 0);
      check_torn(context, &s, 1);
      check_negative(context, &s);
      check_threads(&s);
      check_is_basis(context, s.space); /* all is as it was */
    }
  }
  cube_solid_free(&s);
}

int main(void) {
  tsolid_context *context;
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  for (int p = 1; p <= 9; p++) { /* degrees 1 to 9, every knot multiplicity up to 3 */
    cube_axis axis[3] = {{p, 3, 1}, {1 + p % 4, 2, 1}, {3, 4, 1 + (p - 1) % 3}};
    check_case(context, axis, 0, 0);
  }
  cube_axis one[3] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}},
            cubic[3] = {{3, 3, 1}, {3, 2, 1}, {2, 4, 1}};
  cube_axis long_one[3] = {{2, 16, 1}, {3, 1, 1}, {3, 2, 2}},
            fine[3] = {{3, 10, 1}, {3, 10, 1}, {3, 10, 1}};
  check_case(context, one, 0, 1);
  check_case(context, cubic, 0, 1);
  check_case(context, long_one, 0, 0);
  check_case(context, one, 7, 0);
  check_case(context, fine, 9, 0);
  check_zero_function(context);
  check_doubled_surface(context);
  tsolid_context_free(context);
  return check_done();
}
