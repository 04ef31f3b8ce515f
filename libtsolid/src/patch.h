/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A NURBS patch with homogeneous control points and knots on [0,1], and its exact operations. */
#ifndef TSI_PATCH_H
#define TSI_PATCH_H

#include "internal.h"

typedef struct tsi_patch {
  int degree[2];
  int n[2];
  double *knots[2]; /* n + degree + 1 each, from 0 to 1 */
  double *control;  /* (w x, w y, w z, w); control point (i, j) is row i + n[0]*j */
} tsi_patch;

/* "Face3", or "patch 2" for want of a name; blanks and control characters of the name are shown as
 * they are but for line breaks. Returns `text`. */
const char *tsi_name_patch(const char *name, int k, char text[TSI_NAME_SIZE]);

/* TSOLID_OK or TSOLID_ERROR_INPUT with one finding: sizes, knots, points, weights, tolerances. */
tsolid_status tsi_patch_vet(tsolid_context *context, const tsolid_patch *patch, int k);

/* The functions below that return int return 0 for want of memory; what they make is the arena's.
 */

/* Knots to [0,1], points to homogeneous form (without weights: w = 1 and x, y, z bit for bit).
 * `source` has been vetted. */
int tsi_patch_read(tsi_arena *arena, const tsolid_patch *source, tsi_patch *patch);
/* u -> 1-u, v -> 1-v as flip says, then u and v exchanged. Moves values only. */
int tsi_patch_orient(tsi_arena *arena, const tsi_patch *from, const int flip[2], int swap,
                     tsi_patch *patch);
/* Exact refinement along direction `along`: degree raised by `raise`, which brings its knots with
 * it, then knots inserted until they are `to` (n_to + degree + raise + 1 of them). */
int tsi_patch_refine(tsi_arena *arena, tsi_patch *patch, int along, int raise, int n_to,
                     const double *to);

/* The same points at the same parameters, times the function (1-u)(1-v) corner[0] + u (1-v)
 * corner[1] + (1-u) v corner[2] + u v corner[3], corner > 0: weights change, the surface does not.
 * One degree more in the directions that the function varies in; *n_raised counts them. */
int tsi_patch_multiply(tsi_arena *arena, tsi_patch *patch, const double corner[4], int *n_raised);
/* The new parameter t of direction `along` stands for c t/(c t + 1 - t): every control point is
 * multiplied by the product of 1 - t + c t over the new knots that it depends on, Euclidean points
 * and the weight at the low end stay. Exact, by the blossom, for any knots. Returns 0, and leaves
 * the patch alone, when knots would fall together or weights would leave the range
 * 1e-9 .. 1e9 of what they were. */
int tsi_patch_reparametrise(tsi_patch *patch, int along, double c);

/* Homogeneous point, and first derivatives in u and v unless `d` is NULL: rows of 4. */
void tsi_patch_evaluate(const tsi_patch *patch, double u, double v, double point[4],
                        double d[2][4]);
/* Euclidean point, and the normal x_u x x_v there, not of unit length. */
void tsi_patch_point(const tsi_patch *patch, double u, double v, double x[3]);
void tsi_patch_normal(const tsi_patch *patch, double u, double v, double x[3], double normal[3]);
/* The border of a patch from corner to corner: parameters of the point at x in [0,1]. */
void tsi_border_point(int border, double x, double uv[2]);
/* Area, and flux of (x - origin)/3 through the patch with normal x_u x x_v, by Gauss quadrature on
 * every pair of spans (for polynomial patches exact up to round-off for the flux). */
void tsi_patch_measure(const tsi_patch *patch, const double origin[3], double *area, double *flux);

#endif
