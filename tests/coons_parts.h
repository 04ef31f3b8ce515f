/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Border curves for the tests of planar patches: lines, polylines, arcs, random splines. */
#ifndef TSOLID_TEST_COONS_PARTS_H
#define TSOLID_TEST_COONS_PARTS_H

#include <math.h>
#include <string.h>

#include "tsolid.h"

enum { COONS_MAX_CONTROL = 160, COONS_MAX_KNOTS = 200 };

/* A curve in the plane z = 0 with room for its arrays. */
typedef struct flat_curve {
  int degree, n;
  double knots[COONS_MAX_KNOTS], point[COONS_MAX_CONTROL][3], weight[COONS_MAX_CONTROL];
} flat_curve;

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
  c.knots[0] = 0.0;
  c.knots[n + 1] = n - 1;
  return c;
}

/* The arc of a circle from angle a to b, |b - a| < pi, as one rational quadratic. */
static inline flat_curve flat_arc(double x, double y, double radius, double a, double b) {
  flat_curve c = {.degree = 2, .n = 3, .knots = {0, 0, 0, 1, 1, 1}};
  double middle = 0.5 * (a + b), half = cos(0.5 * (b - a));
  for (int i = 0; i < 3; i++) {
    double angle = i == 0 ? a : i == 1 ? middle : b, r = i == 1 ? radius / half : radius;
    c.point[i][0] = x + r * cos(angle);
    c.point[i][1] = y + r * sin(angle);
    c.weight[i] = i == 1 ? half : 1.0;
  }
  return c;
}

#endif
