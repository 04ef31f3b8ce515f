/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Interior faces: all of them are found; with scattered control points the measured order is the
 * expected one, which on the input's lines is min(2, degree - multiplicity); a small defect in one
 * row is seen. */
#include "check.h"

#include "cube_part.h"
#include "evaluate.h"
#include "quadrature.h"

/* ---- faces -------------------------------------------------------------------------------------
 */

/* Faces inside blocks and across the core surface by a loop over all pairs. */
static int count_straight(const tsolid_space *space, double area[2]) {
  int count = 0;
  area[0] = area[1] = 0.0;
  for (int i = 0; i < space->n_elements; i++)
    for (int j = 0; j < space->n_elements; j++)
      for (int d = 0; d < 3; d++) {
        const tsi_element *a = &space->element[i], *b = &space->element[j];
        int same = a->block == b->block, core = !same && (a->block == 0 || b->block == 0);
        if ((!same && !core) || a->box[d + 3] != b->box[d])
          continue;
        double size = 1.0;
        for (int k = 0; k < 3; k++)
          if (k != d)
            size *= fmax(fmin(a->box[k + 3], b->box[k + 3]) - fmax(a->box[k], b->box[k]), 0.0);
        count += size > 0.0;
        area[core] += size;
      }
  return count;
}

static void check_faces(const tsolid_space *space, int n, const tsi_face *face) {
  double area[3] = {0.0, 0.0, 0.0}, expected[2];
  int straight = 0, meets = 1;
  for (int i = 0; i < n; i++) {
    area[face[i].kind] += (face[i].box[1] - face[i].box[0]) * (face[i].box[3] - face[i].box[2]);
    straight += face[i].kind != TSI_FACE_DIAGONAL;
    meets &= face[i].box[0] < face[i].box[1] && face[i].box[2] < face[i].box[3];
  }
  CHECK(meets);
  CHECK(count_straight(space, expected) == straight);
  CHECK_NEAR(area[TSI_FACE_BLOCK], expected[0], 1e-10 * expected[0]);
  CHECK_NEAR(area[TSI_FACE_CORE], expected[1], 1e-12);
  CHECK_NEAR(area[TSI_FACE_CORE], 6.0, 1e-12);
  CHECK_NEAR(area[TSI_FACE_DIAGONAL], 12.0, 1e-11); /* each is 0 <= rho <= 1 by the isoline */
}

/* Both elements put a face's middle at the same place. */
static void check_places(tsolid_context *context, const cube_solid *s, int n,
                         const tsi_face *face) {
  double worst = 0.0;
  for (int i = 0; i < n; i++) {
    double out[2][3];
    for (int k = 0; k < 2; k++) {
      const tsi_element *e = &s->space->element[face[i].element[k]];
      double x[3], u[3];
      tsi_face_local(s->space, &face[i], k, 0.5 * (face[i].box[0] + face[i].box[1]),
                     0.5 * (face[i].box[2] + face[i].box[3]), x);
      for (int d = 0; d < 3; d++)
        u[d] = (1.0 - x[d]) * e->box[d] + x[d] * e->box[d + 3];
      CHECK(x[face[i].axis[k]] == (double)face[i].end[k]);
      CHECK(tsolid_solid_evaluate(context, s->solid, e->block, u, 0, out[k]) == TSOLID_OK);
    }
    for (int c = 0; c < 3; c++)
      worst = fmax(worst, fabs(out[0][c] - out[1][c]));
  }
  CHECK_NEAR(worst, 0.0, 1e-12 * s->boundary->scale);
}

/* ---- area --------------------------------------------------------------------------------------
 */

/* Area of a face by 40 x 40 secant quadrangles: independent of derivatives and nets. */
static double secant_area(tsolid_context *context, const cube_solid *s, const tsi_face *face) {
  enum { N = 40 };
  static double point[N + 1][N + 1][3];
  const tsi_element *e = &s->space->element[face->element[0]];
  double area = 0.0;
  for (int i = 0; i <= N; i++)
    for (int j = 0; j <= N; j++) {
      double x[3], u[3], p = (double)i / N, q = (double)j / N;
      tsi_face_local(s->space, face, 0, (1.0 - p) * face->box[0] + p * face->box[1],
                     (1.0 - q) * face->box[2] + q * face->box[3], x);
      for (int d = 0; d < 3; d++)
        u[d] = (1.0 - x[d]) * e->box[d] + x[d] * e->box[d + 3];
      CHECK(tsolid_solid_evaluate(context, s->solid, e->block, u, 0, point[i][j]) == TSOLID_OK);
    }
  for (int i = 0; i < N; i++)
    for (int j = 0; j < N; j++) {
      double a[3], b[3], length = 0.0;
      for (int c = 0; c < 3; c++) {
        a[c] = point[i + 1][j + 1][c] - point[i][j][c];
        b[c] = point[i][j + 1][c] - point[i + 1][j][c];
      }
      for (int c = 0; c < 3; c++) {
        double n = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
        length += n * n;
      }
      area += 0.5 * sqrt(length);
    }
  return area;
}

/* ---- orders ------------------------------------------------------------------------------------
 */

typedef struct measured {
  tsi_arena arena;
  int n, *order, *expected;
  tsi_face *face;
  tsolid_continuity_report report;
} measured;

static int measure(tsolid_context *context, const cube_solid *s, measured *m) {
  *m = (measured){.n = 0};
  m->arena = tsi_arena_create(context);
  if (!CHECK(tsi_faces_create(context, s->space, &m->arena, &m->n, &m->face) == TSOLID_OK))
    return 0;
  m->order = tsi_arena_new(&m->arena, (size_t)m->n, sizeof(int));
  m->expected = tsi_arena_new(&m->arena, (size_t)m->n, sizeof(int));
  return CHECK(tsi_continuity_measure(context, s->solid, m->n, m->face, m->order, m->expected,
                                      &m->report) == TSOLID_OK);
}

/* Is u the place of an inner break of the axis? (canonical position keeps a cube of breaks only up
 * to symmetry, so look them up in the boundary itself) */
static int is_input_line(const tsolid_boundary *boundary, int side, int d, double u) {
  for (int e = 0; e < boundary->side[side].n_elements; e++)
    if (boundary->side[side].box[4 * e + 2 * d] == u)
      return 1;
  return 0;
}

/* On the faces that lie on lines of the input: min(2, p - m), from the numbers the part was made
 * with. axis_order is by degree of the side's direction: degrees in a test case are distinct. */
static int line_order(const cube_axis axis[3], int degree) {
  for (int d = 0; d < 3; d++)
    if (axis[d].degree == degree) {
      int order = axis[d].degree - axis[d].multiplicity;
      return order < 2 ? order : 2;
    }
  return -1;
}

static int tensor_expectation(const cube_solid *s, const cube_axis axis[3], const tsi_face *face) {
  const tsi_element *low = &s->space->element[face->element[0]];
  int side = low->block - 1, normal = face->axis[0];
  if (face->kind != TSI_FACE_BLOCK)
    return 0; /* fewer than seven cells */
  if (low->block == 0 || normal == tsi_side_axis(side))
    return 2;
  int d = normal == tsi_side_s(side) ? 0 : 1;
  return is_input_line(s->boundary, side, d, low->box[normal + 3])
             ? line_order(axis, s->boundary->side[side].degree[d])
             : 2;
}

static void check_orders(tsolid_context *context, const cube_solid *s, const cube_axis axis[3]) {
  measured m;
  if (measure(context, s, &m)) {
    int as_told = 1, as_expected = 1, on_lines = 0;
    for (int i = 0; i < m.n; i++) {
      int told = tensor_expectation(s, axis, &m.face[i]);
      as_told &= m.expected[i] == told;
      as_expected &= m.order[i] == m.expected[i];
      on_lines += m.face[i].kind == TSI_FACE_BLOCK && told < 2;
    }
    CHECK(as_told);
    CHECK(as_expected); /* scattered control points: no smoother than theory has it */
    CHECK(m.report.n_below_expected == 0);
    CHECK(m.report.largest_excess <= 1.0);
    CHECK(m.report.n_faces == m.n);
    CHECK(m.report.area[0] == 0.0 && m.report.area[1] > 0.0 && m.report.area[3] > 0.0);
    int rough = 0;
    for (int d = 0; d < 3; d++)
      rough |= axis[d].n_spans > 1 && axis[d].degree - axis[d].multiplicity < 2;
    CHECK((on_lines > 0) == rough);
    check_faces(s->space, m.n, m.face);
    check_places(context, s, m.n, m.face);
  }
  tsi_arena_free(&m.arena);
}

/* With eight cells and more the middle of each core face is C^2 and measured so; at most the bands
 * of three cells are less. */
static void check_core_surface(tsolid_context *context, int n_cells) {
  cube_axis axis[3] = {{3, 2, 1}, {3, 2, 1}, {3, 2, 1}};
  cube_solid s;
  measured m;
  if (CHECK(cube_solid_create(context, axis, cube_wave, n_cells, 0.02, &s)) &&
      measure(context, &s, &m)) {
    double smooth = 0.0, band[3][2];
    for (int d = 0; d < 3; d++) {
      int last = s.tmesh->n_lines[d] - 1;
      band[d][0] = last > 6 ? s.tmesh->line[d][3] : 1.0;
      band[d][1] = last > 6 ? s.tmesh->line[d][last - 3] : 1.0;
    }
    for (int i = 0; i < m.n; i++)
      if (m.face[i].kind == TSI_FACE_CORE && m.expected[i] == 2)
        smooth += (m.face[i].box[1] - m.face[i].box[0]) * (m.face[i].box[3] - m.face[i].box[2]);
    CHECK(n_cells < 7 ? smooth == 0.0 : smooth > 0.0);
    double expected = 0.0;
    for (int side = 0; side < 6; side++) {
      const double *p = band[tsi_side_s(side)], *q = band[tsi_side_t(side)];
      expected += (p[1] - p[0]) * (q[1] - q[0]);
    }
    CHECK_NEAR(smooth, expected, 1e-12);
    CHECK(m.report.n_below_expected == 0);
    tsi_arena_free(&m.arena);
  }
  cube_solid_free(&s);
}

/* A part without scatter: no folds, where areas would not be smooth functions. */
static void check_areas(tsolid_context *context, const cube_axis axis[3], cube_map map) {
  cube_solid s;
  measured m;
  if (CHECK(cube_solid_create(context, axis, map, 0, 0.0, &s)) && measure(context, &s, &m)) {
    for (int i = 0; i < m.n; i += 1 + m.n / 30) {
      tsolid_continuity_report r;
      CHECK(tsi_continuity_measure(context, s.solid, 1, &m.face[i], NULL, NULL, &r) == TSOLID_OK);
      double area = r.area[0] + r.area[1] + r.area[2] + r.area[3];
      CHECK_NEAR(area, secant_area(context, &s, &m.face[i]), 1e-3 * area);
    }
    tsi_arena_free(&m.arena);
  }
  cube_solid_free(&s);
}

/* ---- cells of different size -------------------------------------------------------------------
 */

/* All core cells of an n^3 grid, but one block of 2^3 of them is a single cell: with its low corner
 * at `low`. 6 numbers per cell; returns their number. */
static int merge_cells(int n, const int low[3], int *box) {
  int count = 0;
  for (int i = 0; i < n * n * n; i++) {
    int at[3] = {i % n, i / n % n, i / (n * n)}, inside = 1, is_low = 1;
    for (int d = 0; d < 3; d++) {
      inside &= at[d] >= low[d] && at[d] < low[d] + 2;
      is_low &= at[d] == low[d];
    }
    if (inside && !is_low)
      continue;
    for (int d = 0; d < 3; d++) {
      box[6 * count + d] = at[d];
      box[6 * count + 3 + d] = at[d] + (inside ? 2 : 1);
    }
    count++;
  }
  return count;
}

/* T-junctions inside the core and on its surface: faces still tile, functions and the map are as
 * continuous as expected, and the volume is the boundary's. (The sum of the functions is not one
 * without closure: no matter here.) */
static void check_local_cells(tsolid_context *context, int n, int low_x) {
  static int box[6 * 8 * 8 * 8];
  cube_axis axis[3] = {{3, 2, 1}, {3, 2, 1}, {3, 2, 1}};
  int low[3] = {low_x, n / 2 - 1, n / 2 - 1};
  cube_solid tensor, s = {.solid = NULL};
  measured m = {.n = 0};
  if (CHECK(cube_solid_create(context, axis, cube_wave, n, 0.0, &tensor))) {
    const tsolid_tmesh *t = tensor.tmesh;
    CHECK(t->n_lines[0] == n + 1 && t->n_lines[1] == n + 1 && t->n_lines[2] == n + 1);
    CHECK(tsi_tmesh_from_boxes(context, t->n_lines, (const double *const *)t->line,
                               merge_cells(n, low, box), box, t->arm_height, 0,
                               &s.tmesh) == TSOLID_OK);
    tsi_boundary_retain(tensor.boundary);
    s.boundary = tensor.boundary;
  }
  if (s.tmesh && CHECK(tsolid_space_create(context, s.boundary, s.tmesh, &s.space) == TSOLID_OK)) {
    double *control = cube_control(s.space, 0.02);
    CHECK(tsolid_solid_from_control(context, s.space, control, &s.solid) == TSOLID_OK);
    free(control);
  }
  if (s.solid && measure(context, &s, &m)) {
    tsolid_basis_report basis;
    tsolid_conformity_report conformity;
    CHECK(m.report.n_below_expected == 0);
    check_faces(s.space, m.n, m.face);
    check_places(context, &s, m.n, m.face);
    CHECK(tsi_basis_measure(context, s.space, m.n, m.face, 0, &basis) == TSOLID_OK);
    CHECK_NEAR(basis.diagonal_jump, 0.0, 1e-13);
    CHECK_NEAR(basis.core_jump, 0.0, 1e-13);
    CHECK(basis.inner_eigenvalue > basis.inner_roundoff);
    CHECK(tsi_conformity_measure(context, s.solid, &conformity) == TSOLID_OK);
    CHECK_NEAR(conformity.volume, conformity.flux, 1e-12 * conformity.flux);
  }
  tsi_arena_free(&m.arena);
  cube_solid_free(&s);
  cube_solid_free(&tensor);
}

/* ---- defects -----------------------------------------------------------------------------------
 */

/* Changes one coefficient of a row by `size`: a jump of that order somewhere. */
static void check_defect(tsolid_context *context, const cube_axis axis[3], double size) {
  cube_solid s;
  measured m;
  if (CHECK(cube_solid_create(context, axis, cube_wave, 0, 0.05, &s))) {
    size_t entry = s.space->inner_start[s.space->n_elements / 2];
    double *row = s.space->row + 4 * s.space->inner_row[entry][0];
    row[1] += size;
    if (measure(context, &s, &m)) {
      CHECK(m.report.n_below_expected > 0);
      CHECK(m.report.largest_excess > 1.0);
    }
    tsi_arena_free(&m.arena);
  }
  cube_solid_free(&s);
}

/* Far from the origin the same part has the same orders. */
static void far_away(double p[4]) {
  cube_wave(p);
  p[0] += 1e4;
  p[1] -= 2e4;
}

static void check_threads(const cube_solid *s) {
  tsolid_continuity_report report[2];
  memset(report, 0, sizeof report);
  for (int k = 0; k < 2; k++) {
    tsolid_context_options options = {.n_threads = k ? 3 : 1};
    tsolid_context *context;
    measured m = {.n = 0};
    if (CHECK(tsolid_context_create(&options, &context) == TSOLID_OK) && measure(context, s, &m))
      report[k] = m.report;
    tsi_arena_free(&m.arena);
    tsolid_context_free(context);
  }
  for (int k = 0; k < 4; k++)
    CHECK(report[0].area[k] == report[1].area[k]);
  CHECK(report[0].largest_excess == report[1].largest_excess);
}

int main(void) {
  /* degrees of one case are distinct: so lines are told apart in any canonical position */
  static const cube_axis cases[][3] = {
      {{1, 3, 1}, {2, 3, 1}, {3, 4, 1}}, {{2, 2, 2}, {3, 3, 2}, {4, 2, 1}},
      {{3, 3, 3}, {4, 2, 2}, {5, 2, 3}}, {{3, 1, 1}, {6, 2, 4}, {5, 2, 5}},
      {{4, 3, 3}, {7, 2, 5}, {9, 1, 1}}, {{3, 4, 1}, {4, 3, 2}, {5, 2, 1}}};
  static const cube_map maps[] = {cube_wave, cube_rational, far_away};
  tsolid_context *context;
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    cube_solid s;
    if (CHECK(cube_solid_create(context, cases[k], maps[k % 3], 0, 0.02, &s)))
      check_orders(context, &s, cases[k]);
    if (k == 1)
      check_threads(&s);
    cube_solid_free(&s);
    check_areas(context, cases[k], maps[k % 3]);
  }
  check_core_surface(context, 4);
  check_core_surface(context, 6);
  check_core_surface(context, 7);
  check_core_surface(context, 10);
  check_local_cells(context, 6, 2);
  check_local_cells(context, 6, 0);
  check_local_cells(context, 8, 0);
  check_defect(context, cases[0], 1e-6);
  check_defect(context, cases[0], 1e-8);
  tsolid_context_free(context);
  return check_done();
}
