/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Seams of the shell: the common borders of two patches, as rows of control points and as curves.
 */
#ifndef TSI_SEAMS_H
#define TSI_SEAMS_H

#include "boundary.h"
#include "vector.h"

/* Direction `along` of patch p at the `end` of the other one, twice: both rows run alike. */
typedef struct tsi_seam {
  struct {
    int patch, along, end;
  } row[2];
  int isoline; /* -1: inside a side */
  int side;
} tsi_seam;

/* All 2 n_patches seams: isolines first, then inside the sides. NULL: no memory. */
tsi_seam *tsi_seams_list(tsi_arena *arena, const tsi_shell *shell, int *n);
/* Whether both sides are curves of their own (tsi_tspline_row); seams that are not have no control
 * points to count. */
int tsi_seam_has_rows(const tsi_shell *shell, const tsi_seam *s);
/* Control point m of a row, and the number of them. */
double *tsi_seam_point(const tsi_shell *shell, const tsi_seam *s, int which, int m);
int tsi_seam_count(const tsi_shell *shell, const tsi_seam *s, int which);
/* Corner of the patch, bit 0: u high, bit 1: v high, at the low or high end of a row. */
int tsi_seam_corner(const tsi_seam *s, int which, int high);
/* The patch's own border under a row: v low, u high, v high, u low. */
int tsi_seam_border(const tsi_shell *shell, const tsi_seam *s, int which);
/* The larger of both sides' tolerances. */
double tsi_seam_tolerance(const tsi_shell *shell, const tsi_seam *s);
/* "Edge7 of Face3" of both sides; the first becomes the entity of the finding. */
void tsi_seam_name(const tsi_shell *shell, const tsi_seam *s, char text[2][TSI_BORDER_NAME_SIZE],
                   tsolid_finding *finding);

/* A row as a rational curve of its own; n = 0: there is none. */
typedef struct tsi_row {
  int degree, n;
  const double *knots;
  double *point;
  size_t step;   /* doubles from one control point to the next, */
  const int *at; /* or, unless NULL, rows of `point` */
} tsi_row;

tsi_row tsi_seam_row(const tsi_shell *shell, const tsi_seam *s, int which);
double *tsi_row_point(const tsi_row *row, int m);
/* Homogeneous point, and its derivative unless NULL. */
void tsi_row_evaluate(const tsi_row *row, double t, double point[4], double *derivative);
/* Parameters 0..1 that tell rational curves of this degree and these spans apart. Returns how many;
 * `sample` (NULL allowed) has room for them. */
int tsi_row_samples(const tsi_row *row, double *sample);

/* Of two homogeneous points. */
double tsi_seam_distance(const double a[4], const double b[4]);

/* Positive numbers of which only ratios are known: a forest of logarithms. */
typedef struct tsi_ratios {
  int *parent;
  double *log_ratio; /* of the number to its parent's */
} tsi_ratios;

int tsi_ratios_create(tsi_arena *arena, int n, tsi_ratios *ratios); /* 0: no memory */
/* The root that i's number is known relative to, and log(number i / number of the root). */
int tsi_ratios_find(tsi_ratios *ratios, int i, double *log_ratio);
/* number j = exp(log_ratio) * number i, unless their ratio is known already. */
void tsi_ratios_join(tsi_ratios *ratios, int i, int j, double log_ratio);

#endif
