/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Points and vectors in space. */
#ifndef TSI_VECTOR_H
#define TSI_VECTOR_H

#include <math.h>

static inline double tsi_dot3(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void tsi_cross3(const double a[3], const double b[3], double c[3]) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double tsi_distance(const double a[3], const double b[3]) {
  return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

/* The Euclidean point of a homogeneous one. */
static inline void tsi_project_point(const double h[4], double x[3]) {
  for (int c = 0; c < 3; c++)
    x[c] = h[c] / h[3];
}

#endif
