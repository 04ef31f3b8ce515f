/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Patch operations against evaluation at mapped parameters; vetting, one violation at a time. */
#include <stdlib.h>
#include <string.h>

#include "bspline.h"
#include "check.h"
#include "patch.h"

static unsigned long long state = 777;

static double random_unit(void) {
  state = state * 6364136223846793005ULL + 1442695040888963407ULL;
  return (double)(state >> 11) / 9007199254740992.0;
}

enum { N_U = 6, N_V = 5 };

/* Degrees 3 and 2, unequal knots with a double one, outside [0,1]. */
static const double knots_u[N_U + 4] = {-2, -2, -2, -2, -1, 0.5, 2, 2, 2, 2};
static const double knots_v[N_V + 3] = {10, 10, 10, 14, 14, 20, 20, 20};
static double points[3 * N_U * N_V], weights[N_U * N_V];

static tsolid_patch make_source(int rational) {
  for (int i = 0; i < 3 * N_U * N_V; i++)
    points[i] = random_unit();
  for (int i = 0; i < N_U * N_V; i++)
    weights[i] = 0.5 + random_unit();
  return (tsolid_patch){.degree = {3, 2},
                        .n_control = {N_U, N_V},
                        .knots = {knots_u, knots_v},
                        .points = points,
                        .weights = rational ? weights : NULL};
}

static double compare_at(const tsi_patch *a, const tsi_patch *b, const int flip[2], int swap) {
  double worst = 0.0;
  for (int i = 0; i < 50; i++) {
    double uv[2] = {random_unit(), random_unit()}, x[4], y[4];
    double p = flip[0] ? 1.0 - uv[0] : uv[0], q = flip[1] ? 1.0 - uv[1] : uv[1];
    tsi_patch_evaluate(a, uv[0], uv[1], x, NULL);
    tsi_patch_evaluate(b, swap ? q : p, swap ? p : q, y, NULL);
    for (int c = 0; c < 3; c++)
      worst = fmax(worst, fabs(x[c] / x[3] - y[c] / y[3]));
  }
  return worst;
}

static void test_orient(tsi_arena *arena, int rational) {
  tsolid_patch source = make_source(rational);
  tsi_patch patch, moved, back;
  CHECK(tsi_patch_read(arena, &source, &patch));
  for (int k = 0; k < 8; k++) {
    int flip[2] = {k & 1, k >> 1 & 1}, swap = k >> 2;
    CHECK(tsi_patch_orient(arena, &patch, flip, swap, &moved));
    CHECK_NEAR(compare_at(&patch, &moved, flip, swap), 0.0, 1e-14);
    int undo[2] = {flip[swap], flip[1 - swap]}; /* flips act before the exchange */
    CHECK(tsi_patch_orient(arena, &moved, undo, swap, &back));
    CHECK(memcmp(back.control, patch.control, sizeof(double) * 4 * N_U * N_V) == 0);
    CHECK(memcmp(back.knots[0], patch.knots[0], sizeof knots_u) == 0);
    CHECK(memcmp(back.knots[1], patch.knots[1], sizeof knots_v) == 0);
  }
  for (int i = 0; !rational && i < N_U * N_V; i++)
    CHECK(memcmp(patch.control + 4 * i, points + 3 * i, 3 * sizeof(double)) == 0 &&
          patch.control[4 * i + 3] == 1.0);
}

static void test_refine(tsi_arena *arena, int rational) {
  static const int none[2] = {0, 0};
  tsolid_patch source = make_source(rational);
  tsi_patch patch, fine;
  CHECK(tsi_patch_read(arena, &source, &patch));
  for (int along = 0; along < 2; along++)
    for (int raise = 0; raise < 4; raise++) {
      double raised[64], to[64];
      int degree = patch.degree[along], n = patch.n[along], n_knots = n + degree + 1, count = 0;
      memcpy(raised, patch.knots[along], (size_t)n_knots * sizeof(double));
      for (int r = 0; r < raise; r++) {
        double next[64];
        n = tsi_knots_raise(degree++, n, raised, next);
        n_knots = n + degree + 1;
        memcpy(raised, next, (size_t)n_knots * sizeof(double));
      }
      for (int i = 0; i < n_knots; i++) { /* two new knots in every span */
        to[count++] = raised[i];
        for (int k = 1; k < 3 && i + 1 < n_knots && raised[i] < raised[i + 1]; k++)
          to[count++] = raised[i] + k * (raised[i + 1] - raised[i]) / 3.0;
      }
      fine = patch;
      CHECK(tsi_patch_refine(arena, &fine, along, raise, count - degree - 1, to));
      CHECK(fine.degree[along] == patch.degree[along] + raise);
      CHECK(fine.n[along] == count - degree - 1);
      CHECK(fine.n[1 - along] == patch.n[1 - along]);
      CHECK_NEAR(compare_at(&patch, &fine, none, 0), 0.0, 1e-13);
    }
}

/* Homogeneous values times the bilinear function, at the same parameters. */
static void test_multiply(tsi_arena *arena) {
  static const double corners[4][4] = {
      {1.3, 0.7, 2.1, 0.9}, {1, 2, 1, 2}, {3, 3, 0.5, 0.5}, {2, 2, 2, 2.0000001}};
  tsolid_patch source = make_source(1);
  tsi_patch patch, product;
  CHECK(tsi_patch_read(arena, &source, &patch));
  for (int k = 0; k < 4; k++) {
    const double *f = corners[k];
    int n_raised;
    product = patch;
    CHECK(tsi_patch_multiply(arena, &product, f, &n_raised));
    CHECK(n_raised == (k == 1 || k == 2 ? 1 : 2));
    CHECK(product.degree[0] == 3 + (k != 2) && product.degree[1] == 2 + (k != 1));
    for (int i = 0; i < 50; i++) {
      double u = i < 4 ? i & 1 : random_unit(), v = i < 4 ? i >> 1 : random_unit(), x[4], y[4];
      double factor = (1 - v) * ((1 - u) * f[0] + u * f[1]) + v * ((1 - u) * f[2] + u * f[3]);
      tsi_patch_evaluate(&patch, u, v, x, NULL);
      tsi_patch_evaluate(&product, u, v, y, NULL);
      for (int c = 0; c < 4; c++)
        CHECK_NEAR(y[c], factor * x[c], 1e-14);
    }
    for (int i = 0; i < product.n[0] * product.n[1]; i++)
      CHECK(product.control[4 * i + 3] > 0.0);
  }
}

/* Knots, a double one among them, move; the points stay, at projectively mapped parameters. */
static void test_reparametrise(tsi_arena *arena) {
  tsolid_patch source = make_source(1);
  tsi_patch patch, old;
  for (int k = 0; k < 8; k++) {
    double c = pow(1.9, k - 3.5);
    int along = k & 1;
    CHECK(tsi_patch_read(arena, &source, &old) && tsi_patch_read(arena, &source, &patch));
    CHECK(tsi_patch_reparametrise(&patch, along, c));
    for (int i = 0; i < 50; i++) {
      double t[2] = {random_unit(), random_unit()}, u[2] = {t[0], t[1]}, x[4], y[4];
      u[along] = c * t[along] / (c * t[along] + 1.0 - t[along]);
      tsi_patch_evaluate(&patch, t[0], t[1], x, NULL);
      tsi_patch_evaluate(&old, u[0], u[1], y, NULL);
      for (int d = 0; d < 3; d++)
        CHECK_NEAR(x[d] / x[3], y[d] / y[3], 1e-14);
    }
    CHECK(memcmp(patch.control, old.control, 4 * sizeof(double)) == 0);
    CHECK_NEAR(patch.control[4 * (N_U * N_V - 1) + 3],
               old.control[4 * (N_U * N_V - 1) + 3] * pow(c, patch.degree[along]), 1e-11);
  }
  tsi_patch same = patch;
  same.knots[0] = tsi_arena_new(arena, N_U + 4, sizeof(double));
  memcpy(same.knots[0], patch.knots[0], sizeof knots_u);
  CHECK(!tsi_patch_reparametrise(&same, 0, 1e4)); /* 1e4^3 > 1e9 */
  CHECK(!tsi_patch_reparametrise(&same, 0, (double)NAN));
  CHECK(!tsi_patch_reparametrise(&same, 0, 0.0));
  CHECK(memcmp(same.knots[0], patch.knots[0], sizeof knots_u) == 0);
  same.knots[0][4] = nextafter(0.0, 1.0) + 2.3e-16; /* would fall on the end */
  CHECK(!tsi_patch_reparametrise(&same, 0, 900.0));
}

/* Derivatives against central differences. */
static void test_derivatives(tsi_arena *arena) {
  tsolid_patch source = make_source(1);
  tsi_patch patch;
  CHECK(tsi_patch_read(arena, &source, &patch));
  for (int i = 0; i < 20; i++) {
    double u = 0.05 + 0.9 * random_unit(), v = 0.05 + 0.9 * random_unit(), h = 1e-5;
    double x[4], d[2][4], low[4], high[4];
    tsi_patch_evaluate(&patch, u, v, x, d);
    for (int k = 0; k < 2; k++) {
      tsi_patch_evaluate(&patch, k ? u : u - h, k ? v - h : v, low, NULL);
      tsi_patch_evaluate(&patch, k ? u : u + h, k ? v + h : v, high, NULL);
      for (int c = 0; c < 4; c++)
        CHECK_NEAR(d[k][c], (high[c] - low[c]) / (2.0 * h), 2e-3);
    }
  }
}

/* A quarter of a cylinder of radius 2 and height 3, exact as rational quadratic x linear. */
static void test_measure(tsi_arena *arena) {
  static const double knots[6] = {0, 0, 0, 1, 1, 1}, line[4] = {0, 0, 1, 1};
  static const double at[18] = {2, 0, 0, 2, 2, 0, 0, 2, 0, 2, 0, 3, 2, 2, 3, 0, 2, 3};
  const double h = sqrt(0.5), pi = 3.14159265358979323846, origin[3] = {0, 0, 0};
  const double w[6] = {1, h, 1, 1, h, 1};
  tsolid_patch source = {
      .degree = {2, 1}, .n_control = {3, 2}, .knots = {knots, line}, .points = at, .weights = w};
  tsi_patch patch;
  double area, flux;
  CHECK(tsi_patch_read(arena, &source, &patch));
  tsi_patch_measure(&patch, origin, &area, &flux);
  CHECK_NEAR(area, 3.0 * pi, 1e-3);             /* rational: the quadrature is not exact */
  CHECK_NEAR(flux, 3.0 * pi * 2.0 / 3.0, 1e-3); /* x . n = radius, normal outward */
}

static void expect_input_error(tsolid_context *context, const tsolid_patch *patch,
                               const char *text) {
  tsolid_context_clear(context);
  CHECK(tsi_patch_vet(context, patch, 4) == TSOLID_ERROR_INPUT);
  CHECK(tsolid_context_n_findings(context) == 1);
  const tsolid_finding *finding = tsolid_context_finding(context, 0);
  if (!CHECK(finding && strstr(finding->text, text) != NULL && strstr(finding->text, "Face9")))
    fprintf(stderr, "    '%s' is not in: %s\n", text, finding ? finding->text : "nothing");
  CHECK(finding && finding->index[0] == 4 && finding->status == TSOLID_ERROR_INPUT);
}

static void test_vetting_sizes(tsolid_context *context) {
  tsolid_patch good = make_source(1), bad;
  good.name = "Face9";
  CHECK(tsi_patch_vet(context, &good, 4) == TSOLID_OK);
  for (int d = 0; d < 2; d++) {
    static const int degrees[4] = {0, -1, 26, 1 << 30};
    for (int k = 0; k < 4; k++) {
      bad = good;
      bad.degree[d] = degrees[k];
      expect_input_error(context, &bad, "not one of 1 to 25");
    }
    bad = good;
    bad.n_control[d] = bad.degree[d];
    expect_input_error(context, &bad, "needs at least");
    bad.n_control[d] = 0x7fffffff;
    expect_input_error(context, &bad, "too many");
    bad = good;
    bad.knots[d] = NULL;
    expect_input_error(context, &bad, "no knots");
  }
  bad = good;
  bad.points = NULL;
  expect_input_error(context, &bad, "no control points");
  for (int b = 0; b < 4; b++) {
    bad = good;
    bad.border_tolerance[b] = b & 1 ? -1e-7 : (double)NAN;
    expect_input_error(context, &bad, "tolerance");
  }
}

static void test_vetting_knots(tsolid_context *context) {
  static const struct {
    int index;
    double value;
    const char *text;
  } cases[] = {{4, (double)NAN, "finite"},
               {4, (double)INFINITY, "finite"},
               {0, -(double)INFINITY, "finite"},
               {5, -1.5, "decrease"},
               {3, -1.5, "clamped"},
               {6, 1.5, "clamped"},
               {4, -2.0 + 1e-12, "too near"},
               {4, -2.0, "on the end"},
               {5, 2.0, "on the end"}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    double knots[N_U + 4];
    tsolid_patch bad = make_source(0);
    bad.name = "Face9";
    memcpy(knots, knots_u, sizeof knots);
    knots[cases[i].index] = cases[i].value;
    bad.knots[0] = knots;
    expect_input_error(context, &bad, cases[i].text);
  }
  static const double torn[N_V + 3] = {0, 0, 0, 1, 1, 3, 3, 3};
  static const double flat[N_V + 3] = {1, 1, 1, 1, 1, 1, 1, 1};
  static const double triple[9] = {0, 0, 0, 1, 1, 1, 3, 3, 3};
  tsolid_patch bad = make_source(0);
  bad.name = "Face9";
  bad.knots[1] = torn;
  CHECK(tsi_patch_vet(context, &bad, 4) == TSOLID_OK); /* double in degree 2: a C^0 line, taken */
  bad.knots[1] = flat;
  expect_input_error(context, &bad, "no finite interval");
  bad.knots[1] = triple;
  bad.n_control[0] = 5;
  bad.n_control[1] = 6;
  static const double short_u[9] = {0, 0, 0, 0, 1, 2, 2, 2, 2};
  bad.knots[0] = short_u;
  expect_input_error(context, &bad, "torn");
}

static void test_vetting_points(tsolid_context *context) {
  static const double wrong[] = {0.0, -1.0, -0.0, (double)NAN, (double)INFINITY, 1e-60};
  tsolid_patch bad = make_source(1);
  bad.name = "Face9";
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    weights[7] = wrong[i];
    expect_input_error(context, &bad, "weight of control point (1, 1)");
  }
  weights[7] = 1.0;
  for (int i = 0; i < 3; i++) {
    points[3 * 8 + i] = i == 0 ? (double)NAN : i == 1 ? (double)INFINITY : -1e200;
    expect_input_error(context, &bad, "control point (2, 1) is not finite");
    points[3 * 8 + i] = 0.0;
  }
  CHECK(tsi_patch_vet(context, &bad, 4) == TSOLID_OK);
}

int main(void) {
  tsolid_context *context = NULL;
  if (tsolid_context_create(NULL, &context))
    return 1;
  tsi_arena arena = tsi_arena_create(context);
  for (int rational = 0; rational < 2; rational++) {
    test_orient(&arena, rational);
    test_refine(&arena, rational);
  }
  test_multiply(&arena);
  test_reparametrise(&arena);
  test_derivatives(&arena);
  test_measure(&arena);
  test_vetting_sizes(context);
  test_vetting_knots(context);
  test_vetting_points(context);
  tsi_arena_free(&arena);
  tsolid_context_free(context);
  return check_done();
}
