/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Floating-point expansions: a number as an unevaluated sum of doubles that do not overlap.
 * Source: J. Shewchuk, Adaptive precision floating-point arithmetic and fast robust geometric
 * predicates (1997), theorems 7, 10; products by fma instead of splitting. */
#include "exact.h"

#include "internal.h"

enum { MAX_TERMS = 24 * 8 };

typedef struct expansion {
  int n;
  double term[MAX_TERMS];
} expansion;

/* Grows the expansion by one double (theorem 10); zero terms are dropped. */
static void grow(expansion *e, double b) {
  int n = 0;
  double q = b;
  for (int i = 0; i < e->n; i++) {
    double a = e->term[i], sum = q + a, part = sum - q;
    double rest = (q - (sum - part)) + (a - part);
    if (rest != 0.0)
      e->term[n++] = rest;
    q = sum;
  }
  if (q != 0.0)
    e->term[n++] = q;
  e->n = n;
}

/* Adds a b c d. */
static void add_product(expansion *e, double a, double b, double c, double d) {
  double term[8] = {a};
  double factor[3] = {b, c, d};
  for (int f = 0, n = 1; f < 3; f++, n *= 2)
    for (int i = 0; i < n; i++) {
      double high = term[i] * factor[f];
      term[n + i] = fma(term[i], factor[f], -high);
      term[i] = high;
    }
  for (int i = 0; i < 8; i++)
    grow(e, term[i]);
}

static int in_range(const double *const row[4]) {
  int low = 10000, high = -10000;
  for (int i = 0; i < 16; i++) {
    double x = row[i / 4][i % 4];
    int exponent;
    if (!isfinite(x))
      return 0;
    if (x == 0.0)
      continue;
    (void)frexp(x, &exponent);
    low = exponent < low ? exponent : low;
    high = exponent > high ? exponent : high;
  }
  /* the last bit of a product of four is 2^(4 low - 4*53) */
  return low > -200 && high < 200;
}

int tsi_exact_det4(const double *const row[4]) {
  static const int even[12][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 0, 3, 2},
                                  {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 0, 1, 3}, {2, 1, 3, 0},
                                  {2, 3, 0, 1}, {3, 0, 2, 1}, {3, 1, 0, 2}, {3, 2, 1, 0}};
  if (!in_range(row))
    return 2;
  expansion e = {0, {0.0}};
  for (int p = 0; p < 12; p++) {
    const int *c = even[p];
    add_product(&e, row[0][c[0]], row[1][c[1]], row[2][c[2]], row[3][c[3]]);
    add_product(&e, -row[0][c[1]], row[1][c[0]], row[2][c[2]], row[3][c[3]]);
  }
  if (e.n == 0)
    return 0;
  return e.term[e.n - 1] > 0.0 ? 1 : -1; /* the largest term outweighs all others together */
}
