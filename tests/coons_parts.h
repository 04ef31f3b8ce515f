/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Border curves for the tests of planar patches, and slow twins: areas by Green's theorem and by
 * quadrature over the patch. */
#ifndef TSOLID_TEST_COONS_PARTS_H
#define TSOLID_TEST_COONS_PARTS_H

#include <math.h>
#include <string.h>

#include "bspline.h"
#include "patch.h"
#include "quadrature.h"

enum { FLAT_MAX_CONTROL = 160, FLAT_MAX_KNOTS = 200 };

static const double flat_pi = 3.14159265358979323846;

/* A curve in the plane z = 0 until it is moved. */
typedef struct flat_curve {
  int degree, n;
  double knots[FLAT_MAX_KNOTS], point[FLAT_MAX_CONTROL][3], weight[FLAT_MAX_CONTROL];
} flat_curve;

/* v low, u high, v high, u low. */
typedef struct flat_loop {
  flat_curve border[4];
} flat_loop;

static inline tsolid_curve flat_view(const flat_curve *c) {
  return (tsolid_curve){.degree = c->degree,
                        .n_control = c->n,
                        .knots = c->knots,
                        .points = c->point[0],
                        .weights = c->weight};
}

/* Degree 1 through n points, given as x, y pairs: corners inside are C^0 kinks. */
static inline flat_curve flat_polyline(int n, const double *xy) {
  flat_curve c = {.degree = 1, .n = n};
  for (int i = 0; i < n; i++) {
    c.point[i][0] = xy[2 * i];
    c.point[i][1] = xy[2 * i + 1];
    c.weight[i] = 1.0;
    c.knots[i + 1] = i;
  }
  c.knots[n + 1] = n - 1;
  return c;
}

#define FLAT_LINE(...)                                                                             \
  flat_polyline((int)(sizeof((double[]){__VA_ARGS__}) / (2 * sizeof(double))),                     \
                (double[]){__VA_ARGS__})

/* The arc of a circle from angle a to b, |b - a| < pi, as one rational quadratic. */
static inline flat_curve flat_arc(double radius, double a, double b) {
  flat_curve c = {.degree = 2, .n = 3, .knots = {0, 0, 0, 1, 1, 1}};
  double half = cos(0.5 * (b - a));
  for (int i = 0; i < 3; i++) {
    double angle = i == 0 ? a : i == 1 ? 0.5 * (a + b) : b, r = i == 1 ? radius / half : radius;
    c.point[i][0] = r * cos(angle);
    c.point[i][1] = r * sin(angle);
    c.weight[i] = i == 1 ? half : 1.0;
  }
  return c;
}

static inline void flat_reverse(flat_curve *c) {
  int n_knots = c->n + c->degree + 1;
  for (int i = 0, j = c->n - 1; i < j; i++, j--) {
    double x[3], w = c->weight[i];
    memcpy(x, c->point[i], sizeof x);
    memcpy(c->point[i], c->point[j], sizeof x);
    memcpy(c->point[j], x, sizeof x);
    c->weight[i] = c->weight[j];
    c->weight[j] = w;
  }
  double low = c->knots[0], high = c->knots[n_knots - 1];
  for (int i = 0, j = n_knots - 1; i <= j; i++, j--) {
    double a = low + (high - c->knots[j]), b = low + (high - c->knots[i]);
    c->knots[i] = a;
    c->knots[j] = b;
  }
}

/* The same region with u reversed: its normal is the other one. */
static inline flat_loop flat_mirror(const flat_loop *l) {
  flat_loop m = {{l->border[0], l->border[3], l->border[2], l->border[1]}};
  flat_reverse(&m.border[0]);
  flat_reverse(&m.border[2]);
  return m;
}

/* x -> origin + scale (x a + y b + z c), (a, b, c) a rotation without zeros. */
static inline void flat_move(flat_loop *l, const double origin[3], double scale) {
  static const double q[4] = {0.8, 0.2, -0.4, 0.4}; /* a unit quaternion */
  double r[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      int k = 3 - i - j;
      double twist = i == j ? 0.0 : ((j - i + 3) % 3 == 1 ? -1.0 : 1.0) * q[0] * q[1 + k];
      r[i][j] = 2.0 * (q[1 + i] * q[1 + j] + twist) + (i == j ? 2.0 * q[0] * q[0] - 1.0 : 0.0);
    }
  for (int b = 0; b < 4; b++)
    for (int i = 0; i < l->border[b].n; i++) {
      double *x = l->border[b].point[i], y[3];
      for (int c = 0; c < 3; c++)
        y[c] = origin[c] + scale * (r[c][0] * x[0] + r[c][1] * x[1] + r[c][2] * x[2]);
      memcpy(x, y, sizeof y);
    }
  for (int k = 0; k < 4; k++) { /* the corners once more, bit for bit */
    int along = k < 2 ? 0 : 2, across = k == 0 || k == 3 ? 3 : 1;
    const flat_curve *from = &l->border[along];
    flat_curve *to = &l->border[across];
    memcpy(to->point[k < 2 ? 0 : to->n - 1], from->point[k == 1 || k == 2 ? from->n - 1 : 0],
           3 * sizeof(double));
  }
}

/* A point of the curve and its derivative: de Boor's functions, no library but those. */
static inline void flat_evaluate(const flat_curve *c, double t, double x[3], double dx[3]) {
  double value[TSI_MAX_ORDER], slope[TSI_MAX_ORDER], h[4] = {0.0}, d[4] = {0.0};
  int first = tsi_bspline_basis(c->degree, c->n, c->knots, t, value, slope);
  for (int i = 0; i <= c->degree; i++)
    for (int k = 0; k < 4; k++) {
      double w = c->weight[first + i], a = k == 3 ? w : w * c->point[first + i][k];
      h[k] += value[i] * a;
      d[k] += slope[i] * a;
    }
  for (int k = 0; k < 3; k++) {
    x[k] = h[k] / h[3];
    dx[k] = (d[k] - x[k] * d[3]) / h[3];
  }
}

/* Half the integral of x cross dx round the loop, seen from `origin`: the area vector. */
static inline void flat_green_area(const flat_loop *l, const double origin[3], double area[3]) {
  enum { N = 40 };
  double node[N], weight[N];
  tsi_gauss(N, node, weight);
  area[0] = area[1] = area[2] = 0.0;
  for (int b = 0; b < 4; b++) {
    const flat_curve *c = &l->border[b];
    for (int s = c->degree; s < c->n; s++)
      for (int q = 0; q < N && c->knots[s] < c->knots[s + 1]; q++) {
        double x[3], dx[3], dt = c->knots[s + 1] - c->knots[s];
        flat_evaluate(c, c->knots[s] + node[q] * dt, x, dx);
        for (int k = 0; k < 3; k++) {
          int i = (k + 1) % 3, j = (k + 2) % 3;
          double part = (x[i] - origin[i]) * dx[j] - (x[j] - origin[j]) * dx[i];
          area[k] += (b < 2 ? 0.5 : -0.5) * weight[q] * dt * part;
        }
      }
  }
}

/* The integral of x_u cross x_v over the patch. */
static inline void flat_patch_area(const tsi_patch *p, double area[3]) {
  enum { N = 40 };
  double node[N], weight[N];
  tsi_gauss(N, node, weight);
  area[0] = area[1] = area[2] = 0.0;
  for (int t = p->degree[1]; t < p->n[1]; t++)
    for (int s = p->degree[0]; s < p->n[0]; s++) {
      double du = p->knots[0][s + 1] - p->knots[0][s], dv = p->knots[1][t + 1] - p->knots[1][t];
      for (int q = 0; q < N * N && du > 0.0 && dv > 0.0; q++) {
        double h[4], d[2][4], e[2][3];
        tsi_patch_evaluate(p, p->knots[0][s] + node[q % N] * du, p->knots[1][t] + node[q / N] * dv,
                           h, d);
        for (int k = 0; k < 6; k++)
          e[k / 3][k % 3] = (d[k / 3][k % 3] - h[k % 3] / h[3] * d[k / 3][3]) / h[3];
        for (int k = 0; k < 3; k++) {
          int i = (k + 1) % 3, j = (k + 2) % 3;
          area[k] +=
              weight[q % N] * weight[q / N] * du * dv * (e[0][i] * e[1][j] - e[0][j] * e[1][i]);
        }
      }
    }
}

#endif
