/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The steps from four border curves to a planar patch, private to the stage:
 *
 *     curves -> borders (agreeing corners, weights, degrees, knots) -> plane -> Coons patch
 *            -> certificate -> (repair -> certificate) -> patch */
#ifndef TSI_COONS_H
#define TSI_COONS_H

#include "patch.h"
#include "vector.h"

static const char *const TSI_COONS_STAGE = "coons";

/* ---- borders (coons_border.c) ------------------------------------------------------------------
 */

/* One border: a patch of one row on [0,1], and its Euclidean control points: as they were given
 * where nothing was refined, bit for bit. */
typedef struct tsi_border {
  tsi_patch curve; /* n[1] = 1, no knots across */
  double *point;   /* n_points rows of 3; those at the ends are never moved */
  int n_points;    /* n[0] but while the curve is refined */
  int refined;
  char name[TSI_NAME_SIZE];
} tsi_border;

/* Vetted and read; corners, weights, degrees and knots made to agree. Fills its part of *report. */
tsolid_status tsi_borders_read(tsolid_context *context, tsi_arena *arena,
                               const tsolid_curve border[4], const tsolid_coons_options *options,
                               tsi_border out[4], tsolid_coons_report *report);

/* Opposite borders raised to `degree` and, span by span, halved until there are `n_spans`, exactly.
 * Counts the raised degrees and the new knots of one of them. */
tsolid_status tsi_borders_refine(tsolid_context *context, tsi_arena *arena, tsi_border *a,
                                 tsi_border *b, int degree, int n_spans, int *n_degrees,
                                 int *n_knots);

/* Border of corner k ((u,v) = 00, 10, 11, 01) in direction d, and at which end of it. */
static inline int tsi_corner_border(int k, int d) {
  return d == 0 ? (k < 2 ? 0 : 2) : (k == 0 || k == 3 ? 3 : 1);
}
static inline int tsi_corner_end(int k, int d) {
  return d == 0 ? (k == 1 || k == 2) : k >= 2;
}

/* ---- a patch in its plane ----------------------------------------------------------------------
 */

/* Rational, clamped on [0,1]^2; control point (i, j) is row i + n[0]*j. */
typedef struct tsi_planar {
  int degree[2], n[2];
  double *knots[2];
  double *point;  /* rows of (x, y) */
  double *weight; /* > 0 */
} tsi_planar;

/* The Greville point of control point i in direction d. */
static inline double tsi_planar_greville(const tsi_planar *p, int d, int i) {
  double sum = 0.0;
  for (int k = 1; k <= p->degree[d]; k++)
    sum += p->knots[d][i + k];
  return sum / p->degree[d];
}

/* ---- plane and corners (coons_plane.c) ---------------------------------------------------------
 */

typedef struct tsi_frame {
  double origin[3], axis[2][3], normal[3]; /* right-handed, of unit length */
  double size;                             /* half the diagonal of the borders' bounding box */
} tsi_frame;

typedef struct tsi_coons_work {
  tsolid_context *context;
  tsi_arena *arena;
  tsolid_coons_options options;
  tsolid_coons_report *report;
  char name[TSI_NAME_SIZE];
  tsi_border border[4];
  tsi_frame frame;
  tsi_planar planar;
  int singular; /* bits of corners 00, 10, 11, 01 where the borders are tangent */
} tsi_coons_work;

/* Coordinates in the plane, and back. */
void tsi_frame_flatten(const tsi_frame *frame, const double x[3], double flat[2]);
void tsi_frame_place(const tsi_frame *frame, const double flat[2], double x[3]);

/* The size of the coordinates, by which their round-off is measured. */
double tsi_coons_scale(const tsi_coons_work *work);

/* A refusal with a place. */
tsolid_finding tsi_coons_finding(const double point[3]);

/* The normal is given or fitted; its sign is that of the loop. */
tsolid_status tsi_coons_find_plane(tsi_coons_work *work);

/* Singular corners and the bound; refuses corners without room, and borders that turn back. */
tsolid_status tsi_coons_check_corners(tsi_coons_work *work);

/* Refuses borders that meet elsewhere than at their corners (planar_border.c). */
tsolid_status tsi_coons_check_loop(tsi_coons_work *work);

const char *tsi_coons_corner_name(const tsi_coons_work *work, int corner);
const double *tsi_coons_corner_point(const tsi_coons_work *work, int corner);

/* ---- certificate (planar_certify.c) -------------------------------------------------------------
 */

typedef struct tsi_planar_outcome {
  tsolid_verdict verdict; /* the worst of the elements */
  int n_elements, depth;
  double u[2]; /* in [0,1]^2: where it is not positive, or not decided */
} tsi_planar_outcome;

/* singular: bits of the patch's corners 00, 10, 11, 01 where the borders are tangent. error: that
 * of every coordinate as given, absolute. TSOLID_OK whatever the verdict. */
tsolid_status tsi_planar_certify(tsolid_context *context, const tsi_planar *patch, int singular,
                                 double error, tsi_planar_outcome *outcome);

#endif
