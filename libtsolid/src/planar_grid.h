/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Derivatives of a planar patch on a tensor grid of points, and gradients of sums over them. */
#ifndef TSI_PLANAR_GRID_H
#define TSI_PLANAR_GRID_H

#include "coons.h"

/* The points of one direction: m in each span, in order. */
typedef struct tsi_grid_line {
  int m, n_spans, n_points, order; /* order: degree + 1 */
  int *first;                      /* the first function that is not zero */
  double *value, *slope;           /* rows of `order` */
  double *weight;                  /* the sum over all points is one, over each span the same */
  double *u;
  double *target; /* for densities: a length per parameter; not set here */
} tsi_grid_line;

typedef struct tsi_grid {
  const tsi_planar *patch; /* its weights count; points are given anew each time */
  tsi_grid_line line[2];
  double *w[3]; /* W, W_u, W_v: rows of points along u */
  double *stage[4], *back[4], *row[6], *ones;
} tsi_grid;

/* At the row q of points, x_u = (d[0], d[1]) and x_v = (d[2], d[3]) at each point along u. Returns
 * the row's part of the sum; replaces the d by its derivatives by them when a gradient is wanted.
 */
typedef double (*tsi_grid_density)(void *data, const tsi_grid *grid, int q, double *const d[4]);

/* m_u, m_v: 2..TSI_MAX_GAUSS points per span. 0: no memory. */
int tsi_grid_create(tsi_arena *arena, const tsi_planar *patch, int m_u, int m_v, tsi_grid *grid);

/* point, gradient: rows of 2, one per control point; gradient may be NULL. */
double tsi_grid_sum(tsi_grid *grid, const double *point, tsi_grid_density density, void *data,
                    double *gradient);

#endif
