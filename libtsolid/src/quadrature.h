/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Gauss-Legendre rules and sums that do not lose digits. */
#ifndef TSI_QUADRATURE_H
#define TSI_QUADRATURE_H

enum { TSI_MAX_GAUSS = 64 };

/* Nodes and weights on [0,1] with n <= TSI_MAX_GAUSS points: exact to degree 2n - 1. */
void tsi_gauss(int n, double *node, double *weight);

/* n Gauss-Lobatto points, 2 <= n <= TSI_MAX_GAUSS, both ends among them: exact to degree 2n - 3. */
void tsi_gauss_lobatto(int n, double *node, double *weight);

/* A running sum with Neumaier's compensation; starts as {0, 0}. */
typedef struct tsi_sum {
  double sum, carry;
} tsi_sum;

void tsi_sum_add(tsi_sum *sum, double value);
double tsi_sum_get(const tsi_sum *sum);

#endif
