/* SPDX-License-Identifier: LGPL-2.1-or-later
 * See bernstein_product.h for the form and the error model. Source of the scaled form: R. Farouki,
 * V. Rajan, Algorithms for polynomials in Bernstein form (1988), section 2. */
#include "bernstein_product.h"

#include "bernstein.h"
#include "internal.h"

double tsi_unit_scale(double largest) {
  int exponent;
  if (!(largest > 0.0) || !isfinite(largest))
    return 1.0;
  (void)frexp(largest, &exponent);
  return ldexp(1.0, exponent < -1000 ? 1000 : -exponent);
}

double tsi_gamma(double n) {
  double nu = n * TSI_ROUND_OFF;
  return nu / (1.0 - nu) * (1.0 + 0x1p-50);
}

void tsi_product_clear(tsi_product *c, const tsi_product *a, const tsi_product *b) {
  for (int i = 0; i < 3; i++)
    c->n[i] = a->n[i] + b->n[i] - 1;
  c->delta = 0.0;
  memset(c->pair, 0, tsi_product_size(c) * 2 * sizeof *c->pair);
}

/* c[i + j] += a[i] b[j] on one row, pairwise: two lanes of one SIMD register. */
static void add_row(double *restrict c, double sign, const double *restrict a, int na,
                    const double *restrict b, int nb) {
  for (int i = 0; i < na; i++) {
    double v = sign * a[2 * i], m = a[2 * i + 1];
    double *restrict out = c + 2 * (ptrdiff_t)i;
    for (int j = 0; j < nb; j++) {
      out[2 * j] += v * b[2 * j];
      out[2 * j + 1] += m * b[2 * j + 1];
    }
  }
}

void tsi_product_add(tsi_product *c, double sign, const tsi_product *a, const tsi_product *b) {
  for (int a2 = 0; a2 < a->n[2]; a2++)
    for (int b2 = 0; b2 < b->n[2]; b2++)
      for (int a1 = 0; a1 < a->n[1]; a1++)
        for (int b1 = 0; b1 < b->n[1]; b1++) {
          size_t ia = (size_t)(a1 + a->n[1] * a2) * (size_t)a->n[0];
          size_t ib = (size_t)(b1 + b->n[1] * b2) * (size_t)b->n[0];
          size_t ic = (size_t)(a1 + b1 + c->n[1] * (a2 + b2)) * (size_t)c->n[0];
          add_row(c->pair + 2 * ic, sign, a->pair + 2 * ia, a->n[0], b->pair + 2 * ib, b->n[0]);
        }
}

void tsi_product_close(tsi_product *c, int n_products, const tsi_product *a, const tsi_product *b) {
  double n_terms = (double)n_products;
  for (int i = 0; i < 3; i++)
    n_terms *= (double)(a->n[i] < b->n[i] ? a->n[i] : b->n[i]);
  /* the five small products are rounded as well: the factor */
  double sum = a->delta + b->delta + a->delta * b->delta;
  c->delta = (sum + tsi_gamma(n_terms) * (1.0 + sum)) * (1.0 + 0x1p-48);
}

void tsi_product_unscale(tsi_product *c) {
  double row[4 * TSI_MAX_DEGREE];
  for (int i = 0; i < c->n[0]; i++)
    row[i] = tsi_binomial(c->n[0] - 1, i);
  for (int k = 0; k < c->n[2]; k++)
    for (int j = 0; j < c->n[1]; j++) {
      double b = tsi_binomial(c->n[1] - 1, j) * tsi_binomial(c->n[2] - 1, k);
      double *pair = c->pair + 2 * (size_t)(j + c->n[1] * k) * (size_t)c->n[0];
      for (int i = 0; i < c->n[0]; i++) {
        double factor = 1.0 / (b * row[i]);
        pair[2 * i] *= factor;
        pair[2 * i + 1] *= factor;
      }
    }
  /* binomials up to C(99, k) carry up to 50 roundings each, the division and products four */
  double rounding = tsi_gamma((double)(c->n[0] + c->n[1] + c->n[2]) + 4.0);
  c->delta = (c->delta + rounding * (1.0 + c->delta)) * (1.0 + 0x1p-48);
}

void tsi_net_bisect(const int n[3], int n_components, double *low, double *high, int axis) {
  size_t inner = (size_t)n_components, outer = 1;
  for (int i = 0; i < axis; i++)
    inner *= (size_t)n[i];
  for (int i = axis + 1; i < 3; i++)
    outer *= (size_t)n[i];
  size_t count = (size_t)n[axis];
  for (size_t o = 0; o < outer; o++) {
    double *restrict from = low + o * count * inner, *restrict right = high + o * count * inner;
    memcpy(right, from, count * inner * sizeof *right);
    /* after step r right[0] is point r of the lower half; at the end right is the upper half */
    for (size_t r = 1; r < count; r++) {
      for (size_t k = 0; k < (count - r) * inner; k++)
        right[k] = 0.5 * (right[k] + right[k + inner]);
      memcpy(from + r * inner, right, inner * sizeof *right);
    }
  }
}

void tsi_product_bisect(tsi_product *low, tsi_product *high, int axis) {
  tsi_net_bisect(low->n, 2, low->pair, high->pair, axis);
  double rounding = tsi_gamma((double)low->n[axis]);
  low->delta = (low->delta + rounding * (1.0 + low->delta)) * (1.0 + 0x1p-48);
  memcpy(high->n, low->n, sizeof high->n);
  high->delta = low->delta;
}
