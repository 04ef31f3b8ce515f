/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A T-spline patch on [0,1]^2: functions N(u) M(v) with local knot vectors of their own, and its
 * Bezier elements. NURBS patches become such patches once their knots are settled. */
#ifndef TSI_TSPLINE_H
#define TSI_TSPLINE_H

#include "patch.h"

/* Function N(u) M(v): its local knots in direction d are knots[d][knot[d]] .. knots[d][knot[d] +
 * degree[d] + 1] of the patch. */
typedef struct tsi_blend {
  int knot[2];
  int point; /* row of the shell's control points */
} tsi_blend;

/* The functions that do not vanish on a border, when they are the B-splines of one clamped knot
 * vector along it and all one on it across: they make a curve of their own. n = 0: they do not. */
typedef struct tsi_tspline_row {
  int n;
  double *knots; /* n + degree + 1, from 0 to 1 */
  int *blend;
  int *point; /* that of the blend */
} tsi_tspline_row;

typedef struct tsi_tspline {
  int degree[2];
  int n_knots[2];
  double *knots[2]; /* all local knots, in no order */
  int n;
  tsi_blend *blend;
  tsi_tspline_row row[2][2]; /* [direction along the border][end of the other direction] */
} tsi_tspline;

/* All that return int return 0 for want of memory; what they make is the arena's. */

/* The functions of a tensor product; control point (i, j) is row first_point + i + n[0]*j. */
int tsi_tspline_from_patch(tsi_arena *arena, const tsi_patch *patch, int first_point,
                           tsi_tspline *tspline);
/* Finds the four rows. */
int tsi_tspline_find_rows(tsi_arena *arena, tsi_tspline *tspline);
/* u -> 1-u, v -> 1-v as flip says, then u and v exchanged; rows are found anew. */
int tsi_tspline_orient(tsi_arena *arena, const tsi_tspline *from, const int flip[2], int swap,
                       tsi_tspline *tspline);

/* Replaces a row of functions by the finer ones of the n + degree + 1 knots `to`, exactly: those
 * that are not in the row yet get the control points from first_point on, in order. Returns 1, 0
 * for want of memory, or -1 when functions to be split differ across the border. */
int tsi_tspline_refine_row(tsi_arena *arena, tsi_tspline *tspline, int along, int end, int n,
                           const double *to, int first_point);
/* How many functions of the row for `to` are not in it yet. */
int tsi_tspline_count_new(const tsi_tspline *tspline, int along, int end, int n, const double *to);

/* The NURBS patch of a T-spline that is one: its functions are all products of two clamped knot
 * vectors'. control: homogeneous, by point. Returns 1, 0 for want of memory, -1 when it is none. */
int tsi_tspline_to_patch(tsi_arena *arena, const tsi_tspline *tspline, const double *control,
                         tsi_patch *patch);

/* Bezier elements with coefficients raised to `degree`: the boxes that the knot lines of all
 * functions cut [0,1]^2 into, lines that end inside a box led on through it. Functions are rows of
 * control points; a function that is there twice is two entries. Refuses what is too large with a
 * finding that calls the patch `name`. */
tsolid_status tsi_tspline_elements(tsolid_context *context, tsi_arena *arena,
                                   const tsi_tspline *tspline, const int degree[2],
                                   const char *name, tsi_side *elements);

#endif
