/* SPDX-License-Identifier: LGPL-2.1-or-later
 * What the boundary alone says about the Jacobian of any solid under it. */
#ifndef TSI_BOUNDARY_BOUND_H
#define TSI_BOUNDARY_BOUND_H

#include "bernstein_product.h"
#include "internal.h"

/* Relative: tangents are normalised before they are compared. */
#define TSI_SINGULAR_TOLERANCE 1e-12

/* What the coordinates themselves may be off, by some roundings of numbers of this size. Far from
 * the origin a short leg's direction is known no better than this over its length: there tangents
 * that agree so far, and to 1e-6 at worst, are taken for one. */
static inline double tsi_data_error(double scale) {
  return 32.0 * TSI_ROUND_OFF * scale;
}
static inline double tsi_singular_tolerance(double scale, double leg) {
  double tolerance = tsi_data_error(scale) / leg;
  return !(tolerance > TSI_SINGULAR_TOLERANCE) ? TSI_SINGULAR_TOLERANCE
         : tolerance > 1e-6                    ? 1e-6
                                               : tolerance;
}

/* One Bezier element of a side at work. */
typedef struct tsi_patch_net {
  int side, degree[3];
  double size; /* largest distance of two control points' coordinates */
  double point[TSI_MAX_ORDER * TSI_MAX_ORDER * 4];
} tsi_patch_net;

void tsi_net_load(const tsolid_boundary *boundary, int side, int element, tsi_patch_net *net);

/* Point at local (x, y) of the element, and n, the product of the unit tangents. n points to the
 * inside of the part in the canonical position: along s x t on the low side of axis 0 and 2, where
 * (s, t, inward) is right-handed. Returns the shorter of the legs: what control points beside a
 * corner are away from it. */
double tsi_net_normal(const tsi_patch_net *net, double x, double y, double point[3],
                      double normal[3]);

/* At a corner of the cube: its point; per side that meets there (axis 0, 1, 2) the product n of the
 * side's unit tangents, pointing inward, zero where the isolines are tangent or stand still;
 * whether det J = 0 there in the arm over that side, whatever the inside, but for `tolerance`; the
 * sine of the angle that makes it so; the bound of the corner. */
typedef struct tsi_corner {
  double point[3];
  double normal[3][3];
  int singular[3];
  double tolerance, sine;
  double bound;
} tsi_corner;

void tsi_corner_measure(const tsolid_boundary *boundary, int corner, tsi_corner *result);

/* Bits of an element's corners that are singular corners of the input. */
int tsi_singular_corners(const tsolid_space *space, const tsi_corner corners[8], int element);

/* Distance of the origin from the convex hull of n = 1, 2 or 3 vectors. */
double tsi_hull_distance(int n, const double (*vector)[3]);

/* The smallest bound over corners, isolines and sides, and where. Needs memory for a sort. */
tsolid_status tsi_boundary_bound(tsolid_context *context, const tsolid_boundary *boundary,
                                 double *bound, double point[3]);

#endif
