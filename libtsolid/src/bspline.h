/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The univariate kernel: clamped B-spline curves of any degree 1..TSI_MAX_DEGREE as `n` rows of
 * `n_components` interleaved values and n + degree + 1 knots. Everything here is a sequence of
 * convex combinations; equal values stay equal bit for bit (a plane stays a plane, w = 1 stays 1).
 */
#ifndef TSI_BSPLINE_H
#define TSI_BSPLINE_H

#include <stddef.h>

/* x = (knot - low) / (high - low), of the nearer end, then x = 1 - (1 - x): multiples of 2^-53, on
 * which the mirror image 1 - x is exact. Without the nearer end 1/3 and 2/3 would be no mirror
 * images: 1 - 1/3 is halfway between two doubles. */
double tsi_knot_normalise(double low, double high, double knot);
/* The same for all knots on [first, last]: a vector and its reverse have the same normal form. */
void tsi_knots_normalise(int n_knots, const double *knots, double *normal);
/* normal[i] -> 1 - normal[n-1-i], in place; exact on normalised knots. */
void tsi_knots_reverse(int n_knots, double *knots);
/* The knots after raising the degree by one, or their number alone when `raised` is NULL: every
 * distinct knot once more. Returns the number of control points. */
int tsi_knots_raise(int degree, int n, const double *knots, double *raised);

/* The i with knots[i] <= x < knots[i+1], degree <= i < n; at the upper end the last such span. */
int tsi_bspline_span(int degree, int n, const double *knots, double x);
/* Functions span-degree .. span at x: value[0..degree], derivative[0..degree] (may be NULL).
 * Returns the index of the first. Cox-de Boor. */
int tsi_bspline_basis(int degree, int n, const double *knots, double x, double *value,
                      double *derivative);

/* Control points for the finer knots `to` (n_to + degree + 1 of them, containing `knots` with
 * multiplicity, bit for bit), in place: `points` has room for n_to rows. Boehm's algorithm from
 * right to left, one pass. */
void tsi_bspline_insert(int degree, int n, const double *knots, int n_to, const double *to,
                        int n_components, double *points);

/* One degree more, exactly: target gets n_to rows for the knots `to` of tsi_knots_raise. By
 * Prautzsch (1984): the average of the degree + 1 refinements that leave out every (degree+1)-th
 * knot of `to`. work: tsi_bspline_raise_work() doubles. End points are copied bit for bit. */
void tsi_bspline_raise(int degree, int n, const double *knots, int n_to, const double *to,
                       int n_components, const double *from, double *target, double *work);
size_t tsi_bspline_raise_work(int degree, int n_to, int n_components);

/* The product with (1 - x) low + x high, low and high >= 0, on knots over [0,1]: otherwise as
 * tsi_bspline_raise. Where raising averages, each refinement is weighted by the linear function at
 * the knot that it leaves out: the blossom of the product. Convex combinations times positive
 * factors; where low = high = 1 it is tsi_bspline_raise but for round-off. */
void tsi_bspline_multiply(int degree, int n, const double *knots, double low, double high, int n_to,
                          const double *to, int n_components, const double *from, double *target,
                          double *work);

/* x = value/(value + c (1 - value)) on all knots, which the map u = c x/(c x + 1 - x) takes back;
 * in the normal form of tsi_knots_normalise. 0, knots as they were, when they would fall together
 * so that one stands more than `degree` times. */
int tsi_knots_moebius(int degree, int n, double c, double *knots);

#endif
