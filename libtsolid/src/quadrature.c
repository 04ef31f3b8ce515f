/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Gauss-Legendre and Gauss-Lobatto nodes by Newton's method on the three-term recurrence. */
#include "quadrature.h"

#include <math.h>

/* P_n(x) and its derivative. */
static double legendre(int n, double x, double *derivative) {
  double previous = 1.0, value = x;
  for (int k = 2; k <= n; k++) {
    double next = ((2.0 * k - 1.0) * x * value - (k - 1.0) * previous) / (double)k;
    previous = value;
    value = next;
  }
  *derivative = (double)n * (x * value - previous) / (x * x - 1.0);
  return value;
}

void tsi_gauss(int n, double *node, double *weight) {
  const double pi = 3.14159265358979323846;
  for (int i = 0; i < (n + 1) / 2; i++) {
    double x = cos(pi * (i + 0.75) / (n + 0.5)), derivative = 1.0;
    if (2 * i + 1 == n)
      x = 0.0;
    for (int step = 0; step < 8; step++)
      x -= legendre(n, x, &derivative) / derivative;
    if (2 * i + 1 == n)
      x = 0.0;
    legendre(n, x, &derivative);
    double w = 1.0 / ((1.0 - x * x) * derivative * derivative);
    node[i] = 0.5 * (1.0 - x);
    node[n - 1 - i] = 0.5 * (1.0 + x);
    weight[i] = weight[n - 1 - i] = w;
  }
}

void tsi_gauss_lobatto(int n, double *node, double *weight) {
  const double pi = 3.14159265358979323846;
  double end = 1.0 / (n * (n - 1.0));
  int m = n - 1;
  for (int i = 0; i < (n + 1) / 2; i++) { /* the ends, and the roots of P_m' */
    double x = i == 0 ? 1.0 : cos(pi * i / m), slope, value = 1.0;
    for (int step = 0; i > 0 && step < 16; step++) {
      value = legendre(m, x, &slope);
      double curvature = (2.0 * x * slope - m * (m + 1.0) * value) / (1.0 - x * x);
      x -= slope / curvature;
    }
    if (2 * i + 1 == n)
      x = 0.0;
    if (i > 0)
      value = legendre(m, x, &slope);
    node[i] = 0.5 * (1.0 - x);
    node[n - 1 - i] = 0.5 * (1.0 + x);
    weight[i] = weight[n - 1 - i] = end / (value * value);
  }
}

void tsi_sum_add(tsi_sum *sum, double value) {
  double total = sum->sum + value;
  if (fabs(sum->sum) >= fabs(value))
    sum->carry += (sum->sum - total) + value;
  else
    sum->carry += (value - total) + sum->sum;
  sum->sum = total;
}

double tsi_sum_get(const tsi_sum *sum) {
  return sum->sum + sum->carry;
}
