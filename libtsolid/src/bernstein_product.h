/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Products of trivariate polynomials in Bernstein form with a bound on their round-off.
 *
 * A polynomial of degree n[i] - 1 in direction i is kept as interleaved pairs (v_k, m_k), u[0]
 * fastest. In *scaled* form a coefficient is multiplied by its three binomials: products are then
 * plain convolutions (Vandermonde: sum_i C(p,i) C(q,k-i) = C(p+q,k), so an unscaled coefficient of
 * a product is a convex combination of products of unscaled coefficients).
 *
 * Error model. v_k is the computed coefficient, V_k the true one, m_k >= 0 a magnitude:
 *
 *     |V_k| <= m_k,    |v_k - V_k| <= delta m_k                                             (*)
 *
 * Sums of n products: |fl(sum a b) - sum a b| <= gamma_n sum |a b|, gamma_n = n u / (1 - n u),
 * u = 2^-53 (Higham, Accuracy and Stability of Numerical Algorithms, 2002, section 3.1). With (*)
 * for both factors it follows for c = sum_t +-a_t b_t, with m_c = the same sum of products of
 * magnitudes, that (*) holds with
 *
 *     1 + delta_c = (1 + delta_a) (1 + delta_b) (1 + gamma_n).
 *
 * The magnitudes are themselves rounded, each by a relative gamma of at most 1e-9 for all sizes
 * taken here, which TSI_MAGNITUDE_SLACK covers where they are used. The bound is per coefficient,
 * not a norm of the whole: coefficients near a corner of small weights stay sharp. Because (*) is
 * linear in Bernstein coefficients it also holds pointwise, |v(x) - V(x)| <= delta m(x), and so
 * covers perturbations of V that are no polynomials themselves.
 */
#ifndef TSI_BERNSTEIN_PRODUCT_H
#define TSI_BERNSTEIN_PRODUCT_H

#include <stddef.h>

#define TSI_ROUND_OFF 0x1p-53
#define TSI_MAGNITUDE_SLACK (1.0 + 1e-8)

typedef struct tsi_product {
  int n[3]; /* coefficients per direction: degree + 1 */
  double delta;
  double *pair; /* n[0] n[1] n[2] pairs (v, m) */
} tsi_product;

static inline size_t tsi_product_size(const tsi_product *a) {
  return (size_t)a->n[0] * (size_t)a->n[1] * (size_t)a->n[2];
}

/* Power of two that brings `largest` into [1/2, 1); 1 for zero. */
double tsi_unit_scale(double largest);

/* n u / (1 - n u), rounded up. */
double tsi_gamma(double n);

/* c = 0 with c->n as for a product of a and b, delta = 0. */
void tsi_product_clear(tsi_product *c, const tsi_product *a, const tsi_product *b);

/* c += sign a b in scaled form; sign +1 or -1. delta_c is not touched: see tsi_product_close. */
void tsi_product_add(tsi_product *c, double sign, const tsi_product *a, const tsi_product *b);

/* Sets delta_c after n_products additions of products like a b. */
void tsi_product_close(tsi_product *c, int n_products, const tsi_product *a, const tsi_product *b);

/* Scaled form -> Bernstein coefficients, delta included. n[i] <= 4 TSI_MAX_DEGREE. */
void tsi_product_unscale(tsi_product *c);

/* Unscaled `low` becomes its restriction to the lower half in direction `axis`, `high` (allocated,
 * otherwise ignored) that to the upper half. Convex combinations only, delta included. */
void tsi_product_bisect(tsi_product *low, tsi_product *high, int axis);

/* The same for plain rows of n_components doubles. */
void tsi_net_bisect(const int n[3], int n_components, double *low, double *high, int axis);

#endif
