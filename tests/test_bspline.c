/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Knot insertion and degree raising against evaluation by de Boor's algorithm: every multiplicity
 * at every position, degrees 1 to 9 and 25, rational points. */
#include <stdlib.h>
#include <string.h>

#include "bspline.h"
#include "check.h"
#include "internal.h"

enum { MAX_KNOTS = 400, MAX_POINTS = 400 };

static unsigned long long state = 12345;

static double random_unit(void) {
  state = state * 6364136223846793005ULL + 1442695040888963407ULL;
  return (double)(state >> 11) / 9007199254740992.0;
}

typedef struct curve {
  int degree, n;
  double knots[MAX_KNOTS], points[4 * MAX_POINTS];
} curve;

/* Clamped knots on [0,1]: values[i] with multiplicity[i]. Random points, weights 0.5 to 2. */
static void make_curve(curve *c, int degree, int n_values, const double *values,
                       const int *multiplicity) {
  int n = 0;
  for (int i = 0; i <= degree; i++)
    c->knots[n++] = 0.0;
  for (int k = 0; k < n_values; k++)
    for (int i = 0; i < multiplicity[k]; i++)
      c->knots[n++] = values[k];
  for (int i = 0; i <= degree; i++)
    c->knots[n++] = 1.0;
  c->degree = degree;
  c->n = n - degree - 1;
  for (int i = 0; i < c->n; i++) {
    double w = 0.5 + 1.5 * random_unit();
    for (int k = 0; k < 3; k++)
      c->points[4 * i + k] = w * (random_unit() - 0.5);
    c->points[4 * i + 3] = w;
  }
}

/* de Boor on the span [knots[i], knots[i+1]] that holds x; nothing shared with the library. */
static void de_boor(const curve *c, double x, double out[4]) {
  double d[TSI_MAX_ORDER][4];
  int p = c->degree, i = c->n - 1;
  while (i > p && (c->knots[i] > x || c->knots[i] == c->knots[i + 1]))
    i--;
  for (int j = 0; j <= p; j++)
    memcpy(d[j], c->points + 4 * (i - p + j), sizeof d[j]);
  for (int r = 1; r <= p; r++)
    for (int j = p; j >= r; j--) {
      double left = c->knots[i - p + j], right = c->knots[i + 1 + j - r];
      double a = (x - left) / (right - left);
      for (int k = 0; k < 4; k++)
        d[j][k] = (1.0 - a) * d[j - 1][k] + a * d[j][k];
    }
  memcpy(out, d[p], sizeof d[p]);
}

static double compare_curves(const curve *a, const curve *b) {
  double worst = 0.0;
  for (int i = 0; i <= 60; i++) {
    double x = i / 60.0, pa[4], pb[4];
    de_boor(a, x, pa);
    de_boor(b, x, pb);
    for (int k = 0; k < 3; k++)
      worst = fmax(worst, fabs(pa[k] / pa[3] - pb[k] / pb[3]));
    worst = fmax(worst, fabs(pa[3] - pb[3]));
  }
  return worst;
}

static void insert_into(const curve *from, int n_new, const double *x, curve *to) {
  int n_old = from->n + from->degree + 1, i = 0, k = 0, n = 0;
  *to = *from;
  while (i < n_old || k < n_new)
    to->knots[n++] = k < n_new && (i == n_old || x[k] < from->knots[i]) ? x[k++] : from->knots[i++];
  to->n = n - from->degree - 1;
  tsi_bspline_insert(from->degree, from->n, from->knots, to->n, to->knots, 4, to->points);
}

static void raise_curve(const curve *from, curve *to) {
  static double work[10 * MAX_POINTS];
  to->degree = from->degree + 1;
  to->n = tsi_knots_raise(from->degree, from->n, from->knots, to->knots);
  CHECK(tsi_bspline_raise_work(from->degree, to->n, 4) <= sizeof work / sizeof *work);
  tsi_bspline_raise(from->degree, from->n, from->knots, to->n, to->knots, 4, from->points,
                    to->points, work);
}

static int same_ends(const curve *a, const curve *b) {
  return memcmp(a->points, b->points, 4 * sizeof(double)) == 0 &&
         memcmp(a->points + 4 * (a->n - 1), b->points + 4 * (b->n - 1), 4 * sizeof(double)) == 0;
}

/* A curve whose knot `at` of three has multiplicity m and the others one. */
static void make_test_curve(curve *c, int degree, int at, int m) {
  const double values[3] = {0.2, 0.45, 0.7};
  int multiplicity[3] = {1, 1, 1};
  multiplicity[at] = m;
  make_curve(c, degree, 3, values, multiplicity);
}

static void test_insertion(int degree) {
  static curve from, to;
  const double places[6] = {0.1, 0.2, 0.3, 0.45, 0.7, 0.95};
  double worst = 0.0;
  for (int at = 0; at < 3; at++)
    for (int m = 1; m <= degree; m++)
      for (int place = 0; place < 6; place++) {
        make_test_curve(&from, degree, at, m);
        int has = 0;
        for (int i = 0; i < from.n + degree + 1; i++)
          has += from.knots[i] == places[place];
        double x[TSI_MAX_DEGREE];
        for (int count = 1; count <= degree - has; count++) {
          for (int i = 0; i < count; i++)
            x[i] = places[place];
          insert_into(&from, count, x, &to);
          worst = fmax(worst, compare_curves(&from, &to));
          CHECK(same_ends(&from, &to));
        }
      }
  CHECK_NEAR(worst, 0.0, 1e-13);
}

static void test_raising(int degree) {
  static curve from, to, twice;
  double worst = 0.0;
  for (int at = 0; at < 3; at++)
    for (int m = 1; m <= degree; m++) {
      make_test_curve(&from, degree, at, m);
      raise_curve(&from, &to);
      CHECK(to.n == from.n + 4); /* spans: three knots make four */
      worst = fmax(worst, compare_curves(&from, &to));
      CHECK(same_ends(&from, &to));
      if (degree + 2 <= TSI_MAX_DEGREE) {
        raise_curve(&to, &twice);
        worst = fmax(worst, compare_curves(&from, &twice));
      }
    }
  CHECK_NEAR(worst, 0.0, 1e-13);
}

/* Many knots at once, with multiplicities, into a curve of many spans. */
static void test_many(int degree) {
  static curve from, to;
  double values[12], x[40];
  int multiplicity[12], n_new = 0;
  for (int i = 0; i < 12; i++) {
    values[i] = (i + 1) / 13.0;
    multiplicity[i] = 1 + i % (degree < 3 ? degree : 3);
  }
  make_curve(&from, degree, 12, values, multiplicity);
  for (int i = 0; i < 13; i++) {
    x[n_new++] = (i + 0.3) / 13.0;
    if (i % 2 && degree > 1)
      x[n_new++] = (i + 0.3) / 13.0;
    x[n_new++] = (i + 0.6) / 13.0;
  }
  insert_into(&from, n_new, x, &to);
  CHECK_NEAR(compare_curves(&from, &to), 0.0, 1e-13);
}

/* Equal values must come out equal, bit for bit: weights of one, points in a plane. */
static void test_constants(int degree) {
  static curve from, to, raised;
  const double x[4] = {0.1, 0.15, 1.0 / 3.0, 0.9};
  make_test_curve(&from, degree, 1, degree);
  for (int i = 0; i < from.n; i++) {
    from.points[4 * i + 1] = 0.1;
    from.points[4 * i + 3] = 1.0;
  }
  insert_into(&from, 4, x, &to);
  int same = 1;
  for (int i = 0; i < to.n; i++)
    same = same && to.points[4 * i + 1] == 0.1 && to.points[4 * i + 3] == 1.0;
  if (degree < TSI_MAX_DEGREE) {
    raise_curve(&from, &raised);
    for (int i = 0; i < raised.n; i++)
      same = same && raised.points[4 * i + 1] == 0.1 && raised.points[4 * i + 3] == 1.0;
  }
  CHECK(same);
}

static void test_nothing_inserted(int degree) {
  static curve from, to;
  make_test_curve(&from, degree, 0, 1);
  insert_into(&from, 0, NULL, &to);
  CHECK(memcmp(from.points, to.points, 4 * (size_t)from.n * sizeof(double)) == 0);
}

static void test_basis(int degree) {
  static curve c;
  make_test_curve(&c, degree, 2, degree);
  double worst = 0.0, worst_slope = 0.0;
  for (int i = 0; i <= 50; i++) {
    double x = i / 50.0, value[TSI_MAX_ORDER], slope[TSI_MAX_ORDER], point[4], sum[4] = {0.0};
    double derivative[4] = {0.0};
    int first = tsi_bspline_basis(degree, c.n, c.knots, x, value, slope);
    for (int j = 0; j <= degree; j++)
      for (int k = 0; k < 4; k++) {
        sum[k] += value[j] * c.points[4 * (first + j) + k];
        derivative[k] += slope[j] * c.points[4 * (first + j) + k];
      }
    de_boor(&c, x, point);
    /* the derivative is the curve of degree - 1 through the differences of the points */
    static curve h;
    double expected[4];
    if (degree > 1) {
      h.degree = degree - 1;
      h.n = c.n - 1;
      memcpy(h.knots, c.knots + 1, (size_t)(c.n + degree - 1) * sizeof(double));
      for (int j = 0; j < h.n; j++)
        for (int k = 0; k < 4; k++) {
          double gap = c.knots[j + degree + 1] - c.knots[j + 1];
          h.points[4 * j + k] = degree * (c.points[4 * j + 4 + k] - c.points[4 * j + k]) / gap;
        }
      if (x != 0.7) { /* the corner of the curve */
        de_boor(&h, x, expected);
        for (int k = 0; k < 4; k++)
          worst_slope = fmax(worst_slope, fabs(expected[k] - derivative[k]) / (100.0 * degree));
      }
    }
    for (int k = 0; k < 4; k++)
      worst = fmax(worst, fabs(sum[k] - point[k]));
  }
  CHECK_NEAR(worst, 0.0, 1e-13);
  CHECK_NEAR(worst_slope, 0.0, 1e-13);
}

static void test_normal_form(void) {
  double knots[9] = {0, 0, 0.1, 0.3, 1.0 / 3.0, 0.7, 0.9, 1, 1}, reversed[9], a[9], b[9];
  for (int i = 0; i < 9; i++)
    reversed[i] = 1.0 - knots[8 - i];
  tsi_knots_normalise(9, knots, a);
  tsi_knots_normalise(9, reversed, b);
  tsi_knots_reverse(9, b);
  CHECK(memcmp(a, b, sizeof a) == 0);
  for (int i = 0; i < 9; i++)
    CHECK_NEAR(a[i], knots[i], 1.2e-16);
  double scaled[9];
  for (int i = 0; i < 9; i++)
    scaled[i] = -8.0 + 4.0 * a[i]; /* exact */
  tsi_knots_normalise(9, scaled, b);
  for (int i = 0; i < 9; i++)
    CHECK_NEAR(a[i], b[i], 1e-15);
  for (int n = 2; n <= 200; n++) /* 1/3 and 2/3 are mirror images, too */
    for (int i = 0; i <= n; i++) {
      double x = tsi_knot_normalise(-1.0, n - 1.0, i - 1.0);
      CHECK(x == 1.0 - tsi_knot_normalise(1.0 - n, 1.0, 1.0 - i));
      CHECK_NEAR(x, (double)i / n, 1.2e-16);
    }
}

int main(void) {
  for (int degree = 1; degree <= 10; degree++) {
    int p = degree == 10 ? 25 : degree;
    test_insertion(p);
    if (p < TSI_MAX_DEGREE)
      test_raising(p);
    test_many(p < 10 ? p : 9);
    test_constants(p);
    test_nothing_inserted(p);
    test_basis(p);
  }
  test_raising(24);
  test_normal_form();
  return check_done();
}
