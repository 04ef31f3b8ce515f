/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Evaluation against slow twins (de Casteljau on nets, the product rule), extraction against nets,
 * location on every border, inversion there and back. */
#include "check.h"

#include "cube_part.h"
#include "evaluate.h"

static unsigned state = 11;

static double random_unit(void) {
  return cube_noise(&state) + 0.5;
}

/* ---- twins -------------------------------------------------------------------------------------
 */

enum { MAX_NET = 12 * 12 * 12 };

/* One component of a net, by repeated linear interpolation along each direction in turn. */
static double casteljau(const int degree[3], const double *net, int component, const double x[3]) {
  static double work[MAX_NET];
  int n[3] = {degree[0] + 1, degree[1] + 1, degree[2] + 1};
  for (int i = 0; i < n[0] * n[1] * n[2]; i++)
    work[i] = net[4 * i + component];
  int count = n[0] * n[1] * n[2];
  for (int d = 0; d < 3; d++) {
    count /= n[d];
    for (int line = 0; line < count; line++) {
      double *w = work + line * n[d];
      for (int r = n[d] - 1; r > 0; r--)
        for (int i = 0; i < r; i++)
          w[i] = (1.0 - x[d]) * w[i] + x[d] * w[i + 1];
    }
    for (int line = 0; line < count; line++)
      work[line] = work[line * n[d]];
  }
  return work[0];
}

/* The net of the derivative along d, by the element's own coordinates. */
static void differentiate(int degree[3], double *net, int d, double width) {
  static double from[4 * MAX_NET];
  int n[3] = {degree[0] + 1, degree[1] + 1, degree[2] + 1}, stride[3] = {1, n[0], n[0] * n[1]};
  memcpy(from, net, 4 * (size_t)(n[0] * n[1] * n[2]) * sizeof *from);
  int at = 0, i[3];
  for (i[2] = 0; i[2] < n[2] - (d == 2); i[2]++)
    for (i[1] = 0; i[1] < n[1] - (d == 1); i[1]++)
      for (i[0] = 0; i[0] < n[0] - (d == 0); i[0]++)
        for (int c = 0; c < 4; c++, at++) {
          int source = 4 * (i[0] + i[1] * stride[1] + i[2] * stride[2]) + c;
          net[at] = degree[d] * (from[source + 4 * stride[d]] - from[source]) / width;
        }
  degree[d]--;
}

static const int orders[10][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0},
                                  {0, 2, 0}, {0, 0, 2}, {0, 1, 1}, {1, 0, 1}, {1, 1, 0}};

/* ---- evaluation --------------------------------------------------------------------------------
 */

/* Checks X = W x and its first and second derivatives by the product rule: no division. */
static void check_element(tsolid_context *context, const cube_solid *s, int element) {
  static double net[4 * MAX_NET], derived[4 * MAX_NET];
  const tsi_element *e = &s->space->element[element];
  double u[3], x[3], out[10][3], h[10][4], size = s->boundary->scale;
  CHECK(tsolid_solid_bezier(context, s->solid, element, net) == TSOLID_OK);
  for (int d = 0; d < 3; d++) {
    x[d] = random_unit();
    u[d] = e->box[d] + x[d] * (e->box[d + 3] - e->box[d]);
    x[d] = (u[d] - e->box[d]) / (e->box[d + 3] - e->box[d]);
  }
  CHECK(tsolid_solid_evaluate(context, s->solid, e->block, u, 2, out[0]) == TSOLID_OK);
  for (int k = 0; k < 10; k++) {
    int degree[3] = {e->degree[0], e->degree[1], e->degree[2]};
    memcpy(derived, net, sizeof net);
    for (int d = 0; d < 3; d++)
      for (int times = 0; times < orders[k][d]; times++)
        differentiate(degree, derived, d, e->box[d + 3] - e->box[d]);
    for (int c = 0; c < 4; c++)
      h[k][c] = casteljau(degree, derived, c, x);
  }
  for (int k = 0; k < 10; k++) {
    double width = 1.0;
    for (int d = 0; d < 3; d++)
      width *= pow(e->box[d + 3] - e->box[d], orders[k][d]);
    for (int c = 0; c < 3; c++) {
      double product = h[0][3] * out[k][c] + (k > 0 ? h[k][3] * out[0][c] : 0.0);
      if (k > 3) { /* w_ij x + w_i x_j + w_j x_i + w x_ij */
        int first[6] = {1, 2, 3, 2, 1, 1}, second[6] = {1, 2, 3, 3, 3, 2};
        int i = first[k - 4], j = second[k - 4];
        product += h[i][3] * out[j][c] + h[j][3] * out[i][c];
      }
      CHECK_NEAR(product, h[k][c], 2e-13 * size * (k > 3 ? 50.0 : k > 0 ? 5.0 : 1.0) / width);
    }
  }
}

/* Coefficients times control points are the element's net. */
static void check_extraction(tsolid_context *context, const cube_solid *s, int element) {
  int n, few;
  CHECK(tsolid_space_extraction(context, s->space, element, 0, &n, NULL, NULL) == TSOLID_OK);
  size_t size = s->space->bezier_start[element + 1] - s->space->bezier_start[element];
  int *function = calloc((size_t)n, sizeof *function);
  double *coefficient = calloc((size_t)n * size, sizeof *coefficient);
  double *net = calloc(size, 4 * sizeof *net), worst = 0.0;
  CHECK(tsolid_space_extraction(context, s->space, element, n, &few, function, coefficient) ==
        TSOLID_OK);
  CHECK(few == n);
  CHECK(tsolid_solid_bezier(context, s->solid, element, net) == TSOLID_OK);
  for (size_t i = 0; i < size; i++)
    for (int c = 0; c < 4; c++) {
      double sum = 0.0;
      for (int f = 0; f < n; f++)
        sum += coefficient[(size_t)f * size + i] * s->solid->control[4 * function[f] + c];
      worst = fmax(worst, fabs(sum - net[4 * i + (size_t)c]));
    }
  CHECK_NEAR(worst, 0.0, 1e-14 * s->boundary->scale);
  int unique = 1;
  for (int f = 0; f < n; f++)
    for (int g = 0; g < f; g++)
      unique &= function[f] != function[g];
  CHECK(unique);
  CHECK(tsolid_space_extraction(context, s->space, element, n - 1, &few, function, NULL) ==
        TSOLID_ERROR_ARGUMENT);
  free(function);
  free(coefficient);
  free(net);
}

/* An element owns its lower corner; at the block's upper ends also its upper corner. */
static void check_location(const cube_solid *s) {
  int right = 1;
  for (int e = 0; e < s->space->n_elements; e++) {
    const tsi_element *element = &s->space->element[e];
    double range[6], u[3];
    tsi_block_range(s->tmesh, element->block, range);
    right &= tsi_space_locate(s->space, element->block, element->box) == e;
    for (int d = 0; d < 3; d++)
      u[d] = element->box[d + 3] == range[d + 3] ? element->box[d + 3]
                                                 : 0.5 * (element->box[d] + element->box[d + 3]);
    right &= tsi_space_locate(s->space, element->block, u) == e;
  }
  CHECK(right);
}

static void check_boundary(tsolid_context *context, const cube_solid *s) {
  for (int i = 0; i < 600; i++) {
    double u[3], inside[3], input[3], st[2] = {random_unit(), random_unit()};
    int side = i % 6;
    for (int k = 0; k < 2; k++)
      st[k] = i % 7 == 0 ? floor(2.0 * st[k]) : st[k]; /* isolines and corners too */
    int block = tsolid_solid_boundary_point(s->solid, side, st[0], st[1], u);
    CHECK(block == 1 + side);
    CHECK(tsolid_solid_evaluate(context, s->solid, block, u, 0, inside) == TSOLID_OK);
    CHECK(tsi_boundary_point(s->boundary, side, st[0], st[1], input));
    for (int c = 0; c < 3; c++)
      CHECK_NEAR(inside[c], input[c], 1e-14 * s->boundary->scale);
  }
}

static void check_arguments(tsolid_context *context, const cube_solid *s) {
  double nan = (double)NAN, out[30], points[4],
         bad[4][3] = {{0.5, 0.5, 1.01}, {nan, 0.5, 0.5}, {-1e-9, 0, 0}, {INFINITY, 0, 0}};
  double good[3] = {0.5, 0.5, 0.5}, u[3], distance;
  int n, found, block;
  for (int k = 0; k < 4; k++)
    CHECK(tsolid_solid_evaluate(context, s->solid, 0, bad[k], 0, out) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_solid_evaluate(context, s->solid, 7, good, 0, out) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_solid_evaluate(context, s->solid, -1, good, 0, out) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_solid_evaluate(context, s->solid, 0, good, 3, out) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_solid_evaluate(context, s->solid, 1, good, 0, out) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_solid_bezier(context, s->solid, -1, points) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_solid_bezier(context, s->solid, s->space->n_elements, points) ==
        TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_space_extraction(context, s->space, -1, 0, &n, NULL, NULL) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_solid_invert(context, s->solid, bad[1], 0.0, &found, &block, u, &distance) ==
        TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_solid_invert(context, s->solid, good, nan, &found, &block, u, &distance) ==
        TSOLID_ERROR_ARGUMENT);
}

/* ---- inversion ---------------------------------------------------------------------------------
 */

/* There and back: inside elements, on their faces, edges and corners (so also on diagonals, the
 * core surface and the boundary). */
static void check_inversion(tsolid_context *context, const cube_solid *s, int n_points) {
  double worst = 0.0, worst_u = 0.0;
  for (int i = 0; i < n_points; i++) {
    int element = (int)(random_unit() * s->space->n_elements), block, found, interior = 1;
    const tsi_element *e = &s->space->element[element];
    double u[3], v[3], point[3], back[3], distance;
    for (int d = 0; d < 3; d++) {
      double x = random_unit();
      if (i % 3 == 0 && random_unit() < 0.5) {
        x = floor(2.0 * x);
        interior = 0;
      }
      u[d] = (1.0 - x) * e->box[d] + x * e->box[d + 3];
    }
    CHECK(tsolid_solid_evaluate(context, s->solid, e->block, u, 0, point) == TSOLID_OK);
    CHECK(tsolid_solid_invert(context, s->solid, point, 0.0, &found, &block, v, &distance) ==
          TSOLID_OK);
    if (!CHECK(found))
      continue;
    CHECK(tsolid_solid_evaluate(context, s->solid, block, v, 0, back) == TSOLID_OK);
    for (int c = 0; c < 3; c++)
      worst = fmax(worst, fabs(point[c] - back[c]));
    if (interior) {
      CHECK(block == e->block);
      for (int d = 0; d < 3; d++)
        worst_u = fmax(worst_u, fabs(u[d] - v[d]));
    }
  }
  CHECK_NEAR(worst, 0.0, 1e-13 * s->boundary->scale);
  CHECK_NEAR(worst_u, 0.0, 1e-10);
}

/* Points off the surface along its normal: outside, and at that distance when it is small. */
static void check_outside(tsolid_context *context, const cube_solid *s) {
  for (int i = 0; i < 120; i++) {
    double u[3], out[4][3], point[3], normal[3], v[3], distance, length = 0.0;
    double step = s->boundary->scale * (i % 2 ? 1e-2 : 1e-7);
    int side = i % 6, axis = tsi_side_axis(side), found, at;
    int block = tsolid_solid_boundary_point(s->solid, side, 0.1 + 0.8 * random_unit(),
                                            0.1 + 0.8 * random_unit(), u);
    CHECK(tsolid_solid_evaluate(context, s->solid, block, u, 1, out[0]) == TSOLID_OK);
    const double *a = out[1 + (axis + 1) % 3], *b = out[1 + (axis + 2) % 3];
    for (int c = 0; c < 3; c++) {
      normal[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
      length += normal[c] * normal[c];
    }
    for (int c = 0; c < 3; c++)
      point[c] = out[0][c] + (side & 1 ? step : -step) * normal[c] / sqrt(length);
    CHECK(tsolid_solid_invert(context, s->solid, point, 0.0, &found, &at, v, &distance) ==
          TSOLID_OK);
    CHECK(!found);
    CHECK_NEAR(distance, step, 1e-3 * step);
    CHECK(at == block);
    for (int c = 0; c < 3; c++) /* and as far inside it is found */
      point[c] = 2.0 * out[0][c] - point[c];
    CHECK(tsolid_solid_invert(context, s->solid, point, 0.0, &found, &at, v, &distance) ==
          TSOLID_OK);
    CHECK(found);
  }
}

/* Distances to a unit cube are known everywhere. */
static void check_unit_cube(tsolid_context *context) {
  cube_axis axis[3] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  cube_solid s;
  if (CHECK(cube_solid_create(context, axis, NULL, 0, 0.0, &s)))
    for (int i = 0; i < 2000; i++) {
      double p[3], u[3], distance, expected = 0.0;
      int found, block;
      for (int d = 0; d < 3; d++) {
        p[d] = 3.0 * random_unit() - 1.0;
        double out = fmax(fmax(-p[d], p[d] - 1.0), 0.0);
        expected += out * out;
      }
      CHECK(tsolid_solid_invert(context, s.solid, p, 0.0, &found, &block, u, &distance) ==
            TSOLID_OK);
      CHECK(found == (expected == 0.0));
      CHECK_NEAR(distance, sqrt(expected), 1e-9 + 1e-3 * sqrt(expected));
    }
  cube_solid_free(&s);
}

int main(void) {
  static const struct {
    cube_axis axis[3];
    cube_map map;
    int min_cells;
  } cases[] = {{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, NULL, 0},
               {{{3, 3, 1}, {3, 4, 2}, {3, 5, 1}}, cube_wave, 0},
               {{{2, 3, 1}, {5, 2, 1}, {3, 4, 1}}, cube_rational, 0},
               {{{4, 2, 1}, {9, 1, 1}, {2, 9, 1}}, cube_rational, 5}};
  tsolid_context *context;
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    cube_solid s;
    if (CHECK(
            cube_solid_create(context, cases[k].axis, cases[k].map, cases[k].min_cells, 0.0, &s))) {
      for (int e = 0; e < s.space->n_elements; e++)
        check_element(context, &s, e);
      for (int e = 0; e < s.space->n_elements; e += 7)
        check_extraction(context, &s, e);
      check_location(&s);
      check_boundary(context, &s);
      check_arguments(context, &s);
      check_inversion(context, &s, 2000);
      check_outside(context, &s);
    }
    cube_solid_free(&s);
  }
  check_unit_cube(context);
  tsolid_context_free(context);
  return check_done();
}
