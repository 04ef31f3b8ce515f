/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Polynomials in Bernstein form, B_k(x) = C(p,k) x^k (1-x)^(p-k) on [0,1], and B-splines as such.
 */
#ifndef TSI_BERNSTEIN_H
#define TSI_BERNSTEIN_H

/* C(n, k) as the nearest double, 0 <= k <= n <= 128 (exact up to n = 56). */
double tsi_binomial(int n, int k);

/* value[0..degree] = B_k(x), any degree 0..128, |x| <= 1 for accuracy. */
void tsi_bernstein(int degree, double x, double *value);

/* Rows of values and derivatives: value[d*(degree+1) + k] = d^d B_k / dx^d (x), d = 0..order,
 * order <= 2, degree <= TSI_MAX_DEGREE. */
void tsi_bernstein_derivatives(int degree, double x, int order, double *value);

/* Rewrites `degree` coefficients as `to` >= degree coefficients of the same polynomial. Rows of
 * n_components interleaved values; from and target must not overlap. Convex combinations only. */
void tsi_bernstein_raise(int degree, int to, int n_components, const double *from, double *target);

/* In place: coefficients on [0,1] -> coefficients of the same polynomial on [x0, x1], 0 <= x0 < x1
 * <= 1. Coefficient k is coefficient[k*stride]. Convex combinations only; bitwise unchanged for
 * x0 = 0, x1 = 1. */
void tsi_bernstein_restrict(int degree, double x0, double x1, double *coefficient, int stride);

/* The B-spline of `degree` (<= TSI_MAX_DEGREE) with local knots knot[0..degree+1], on [lo, hi] with
 * no knot inside (lo, hi), lo < hi: coefficient[0..degree], all >= 0. Zero outside the support. At
 * knots of full multiplicity the function is taken from inside [lo, hi]. */
void tsi_bspline_bernstein(int degree, const double *knot, double lo, double hi,
                           double *coefficient);

#endif
