/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Source: G. Farin, Curves and Surfaces for CAGD (2002), chapters 5, 6 and 8 (blossoms). */
#include "bernstein.h"

#include "internal.h"

double tsi_binomial(int n, int k) {
  if (k < 0 || k > n)
    return 0.0;
  if (k > n - k)
    k = n - k;
  double value = 1.0;
  for (int i = 1; i <= k; i++) {
    value = value * (double)(n - k + i) / (double)i;
    if (value < 0x1p52)
      value = floor(value + 0.5); /* each partial product is an integer: keep it exact */
  }
  return value;
}

void tsi_bernstein(int degree, double x, double *value) {
  double y = 1.0 - x;
  value[0] = 1.0;
  for (int p = 1; p <= degree; p++) {
    value[p] = x * value[p - 1];
    for (int k = p - 1; k > 0; k--)
      value[k] = y * value[k] + x * value[k - 1];
    value[0] *= y;
  }
}

void tsi_bernstein_derivatives(int degree, double x, int order, double *value) {
  double lower[TSI_MAX_ORDER + 1];
  int n = degree + 1;
  tsi_bernstein(degree, x, value);
  for (int d = 1; d <= order; d++) {
    double *row = value + (size_t)d * (size_t)n;
    if (d > degree) {
      memset(row, 0, (size_t)n * sizeof *row);
      continue;
    }
    /* d-th derivative = p!/(p-d)! * d-th backward difference of the degree p-d basis */
    int m = degree - d;
    double factor = 1.0;
    for (int i = 0; i < d; i++)
      factor *= (double)(degree - i);
    tsi_bernstein(m, x, lower);
    for (int k = 0; k < n; k++) {
      double sum = 0.0;
      for (int j = 0; j <= d; j++) {
        int i = k - j;
        if (i < 0 || i > m)
          continue;
        sum += ((d - j) % 2 ? -1.0 : 1.0) * tsi_binomial(d, j) * lower[i];
      }
      row[k] = factor * sum;
    }
  }
}

void tsi_bernstein_raise(int degree, int to, int n_components, const double *from, double *target) {
  int r = to - degree;
  for (int k = 0; k <= to; k++) {
    double *out = target + (ptrdiff_t)k * n_components;
    for (int c = 0; c < n_components; c++)
      out[c] = 0.0;
    int first = k - r > 0 ? k - r : 0;
    int last = k < degree ? k : degree;
    for (int i = first; i <= last; i++) {
      double a = tsi_binomial(degree, i) * tsi_binomial(r, k - i) / tsi_binomial(to, k);
      const double *in = from + (ptrdiff_t)i * n_components;
      for (int c = 0; c < n_components; c++)
        out[c] += a * in[c];
    }
  }
}

void tsi_bernstein_restrict(int degree, double x0, double x1, double *coefficient, int stride) {
  if (x1 < 1.0) /* keep the part below x1 */
    for (int r = 1; r <= degree; r++)
      for (int k = degree; k >= r; k--)
        coefficient[k * stride] =
            (1.0 - x1) * coefficient[(k - 1) * stride] + x1 * coefficient[k * stride];
  if (x0 > 0.0) { /* then the part above x0, in the new parameter */
    double x = x0 / x1;
    for (int r = 1; r <= degree; r++)
      for (int k = 0; k <= degree - r; k++)
        coefficient[k * stride] =
            (1.0 - x) * coefficient[k * stride] + x * coefficient[(k + 1) * stride];
  }
}

void tsi_bspline_bernstein(int degree, const double *knot, double lo, double hi,
                           double *coefficient) {
  enum { MAX_KNOTS = 3 * TSI_MAX_DEGREE + 4 };
  double extended[MAX_KNOTS], d[TSI_MAX_ORDER + 1];
  int p = degree;
  /* the p+2 knots with both ends repeated p times: function p of this clamped vector is ours */
  for (int i = 0; i < 3 * p + 2; i++) {
    int j = i - p;
    extended[i] = knot[j < 0 ? 0 : j > p + 1 ? p + 1 : j];
  }
  int span = -1;
  for (int i = p; i < 2 * p + 1; i++)
    if (extended[i] < extended[i + 1] && extended[i] <= lo && hi <= extended[i + 1])
      span = i;
  for (int k = 0; k <= p; k++) {
    coefficient[k] = 0.0;
    if (span < 0)
      continue;
    /* blossom at (lo^(p-k), hi^k) by de Boor's recursion */
    for (int j = 0; j <= p; j++)
      d[j] = span - p + j == p ? 1.0 : 0.0;
    for (int r = 1; r <= p; r++) {
      double x = r <= k ? hi : lo;
      for (int j = p; j >= r; j--) {
        double left = extended[span - p + j], right = extended[span + 1 + j - r];
        double a = (x - left) / (right - left);
        d[j] = (1.0 - a) * d[j - 1] + a * d[j];
      }
    }
    coefficient[k] = d[p];
  }
}
