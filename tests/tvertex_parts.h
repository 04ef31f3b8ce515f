/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Parts whose sides are cut into rectangles anyhow, so that corners lie inside neighbours' borders:
 * sub-patches of six rational Bezier patches, by de Casteljau's algorithm. */
#ifndef TSOLID_TEST_TVERTEX_PARTS_H
#define TSOLID_TEST_TVERTEX_PARTS_H

#include "boundary_parts.h"

enum { MAX_RECTANGLES = 1024 };

/* Rectangles u0, u1, v0, v1 that tile the unit square. */
typedef struct dissection {
  int n;
  double box[MAX_RECTANGLES][4];
} dissection;

static inline void whole_square(dissection *d) {
  *d = (dissection){1, {{0.0, 1.0, 0.0, 1.0}}};
}

/* Replaces rectangle k by the two beside the line at `x` of its direction `across`. */
static inline void cut_rectangle(dissection *d, int k, int across, double x) {
  double *old = d->box[k], *other = d->box[d->n++];
  memcpy(other, old, sizeof d->box[0]);
  old[2 * across + 1] = x;
  other[2 * across] = x;
}

/* Replaces rectangle k by five around a square: no straight line goes through. */
static inline void pinwheel_rectangle(dissection *d, int k) {
  double box[4], x[2], y[2];
  memcpy(box, d->box[k], sizeof box);
  for (int i = 0; i < 2; i++) {
    x[i] = box[0] + (0.3 + 0.35 * i + 0.1 * random_unit()) * (box[1] - box[0]);
    y[i] = box[2] + (0.3 + 0.35 * i + 0.1 * random_unit()) * (box[3] - box[2]);
  }
  double five[5][4] = {{box[0], x[1], box[2], y[0]},
                       {x[1], box[1], box[2], y[1]},
                       {x[0], box[1], y[1], box[3]},
                       {box[0], x[0], y[0], box[3]},
                       {x[0], x[1], y[0], y[1]}};
  memcpy(d->box[k], five[0], sizeof five[0]);
  memcpy(d->box[d->n], five[1], 4 * sizeof five[0]);
  d->n += 4;
}

static inline void random_dissection(dissection *d, int n_cuts, int n_pinwheels) {
  whole_square(d);
  while (n_pinwheels-- > 0)
    pinwheel_rectangle(d, random_below(d->n));
  while (n_cuts-- > 0) {
    int k = random_below(d->n), across = random_below(2);
    double low = d->box[k][2 * across], high = d->box[k][2 * across + 1];
    cut_rectangle(d, k, across, low + (0.2 + 0.6 * random_unit()) * (high - low));
  }
}

static inline void grid_dissection(dissection *d, int n, const double *x, int m, const double *y) {
  d->n = 0;
  for (int j = 0; j + 1 < m; j++)
    for (int i = 0; i + 1 < n; i++) {
      double box[4] = {x[i], x[i + 1], y[j], y[j + 1]};
      memcpy(d->box[d->n++], box, sizeof box);
    }
}

/* Blossoms: coefficients on [a, b] of the polynomial with coefficients on [0, 1]. */
static inline void restrict_row(int degree, double a, double b, double *h, int step) {
  long double from[26], to[26], work[26];
  for (int c = 0; c < 4; c++) {
    for (int i = 0; i <= degree; i++)
      from[i] = h[step * i + c];
    for (int i = 0; i <= degree; i++) {
      memcpy(work, from, sizeof work);
      for (int r = 0; r < degree; r++) {
        long double x = r < i ? b : a;
        for (int k = 0; k < degree - r; k++)
          work[k] = (1.0L - x) * work[k] + x * work[k + 1];
      }
      to[i] = work[0];
    }
    for (int i = 0; i <= degree; i++)
      h[step * i + c] = (double)to[i];
  }
}

static inline double *unit_knots(int degree) {
  double *knots = part_doubles((size_t)(2 * degree + 2));
  for (int i = 0; i <= degree; i++)
    knots[degree + 1 + i] = 1.0;
  return knots;
}

/* The part `box` of a Bezier patch as one of its own. */
static inline tsolid_patch sub_patch(const tsolid_patch *from, const double box[4]) {
  tsolid_patch to = *from;
  int p = from->degree[0], q = from->degree[1], n = (p + 1) * (q + 1);
  double *h = part_doubles(4 * (size_t)n), *points = part_doubles(3 * (size_t)n);
  double *weights = from->weights ? part_doubles((size_t)n) : NULL;
  for (int i = 0; i < n; i++) {
    double w = from->weights ? from->weights[i] : 1.0;
    for (int c = 0; c < 3; c++)
      h[4 * i + c] = w * from->points[3 * i + c];
    h[4 * i + 3] = w;
  }
  for (int j = 0; j <= q; j++)
    restrict_row(p, box[0], box[1], h + 4 * (p + 1) * j, 4);
  for (int i = 0; i <= p; i++)
    restrict_row(q, box[2], box[3], h + 4 * i, 4 * (p + 1));
  for (int i = 0; i < n; i++) {
    for (int c = 0; c < 3; c++)
      points[3 * i + c] = h[4 * i + c] / h[4 * i + 3];
    if (weights)
      weights[i] = h[4 * i + 3];
  }
  free(h);
  to.knots[0] = unit_knots(p);
  to.knots[1] = unit_knots(q);
  to.points = points;
  to.weights = weights;
  return to;
}

/* The six Bezier patches `whole`, side k cut into the rectangles side[k]. */
static inline part make_dissected(const part *whole, const dissection side[6]) {
  part p = {0, NULL};
  int n = 0;
  for (int k = 0; k < 6; k++)
    n += side[k].n;
  p.patch = calloc((size_t)n, sizeof *p.patch);
  for (int k = 0; k < 6; k++)
    for (int i = 0; i < side[k].n; i++)
      p.patch[p.n++] = sub_patch(&whole->patch[k], side[k].box[i]);
  return p;
}

static inline int compare_values(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* All values at which lines of an axis stand on the four sides that carry it, with 0 and 1. Returns
 * how many; values nearer than 1e-9 are one. */
static inline int axis_values(const dissection side[6], int axis, double *value) {
  int n = 0, count = 1;
  for (int k = 0; k < 6; k++) {
    if (k >> 1 == axis)
      continue;
    int d = (k >> 1 == 2 ? 1 : 2) == axis; /* s or t */
    for (int i = 0; i < side[k].n; i++)
      for (int e = 0; e < 2; e++)
        value[n++] = side[k].box[i][2 * d + e];
  }
  qsort(value, (size_t)n, sizeof *value, compare_values);
  for (int i = 1; i < n; i++)
    if (value[i] - value[count - 1] > 1e-9)
      value[count++] = value[i];
  return count;
}

/* The grids that the lines of all sides make when they are led around the part. */
static inline void close_dissections(const dissection side[6], dissection grid[6]) {
  static double value[3][6 * 2 * MAX_RECTANGLES];
  int n[3];
  for (int axis = 0; axis < 3; axis++)
    n[axis] = axis_values(side, axis, value[axis]);
  for (int k = 0; k < 6; k++) {
    int s = k >> 1 == 0 ? 1 : 0, t = k >> 1 == 2 ? 1 : 2;
    grid_dissection(&grid[k], n[s], value[s], n[t], value[t]);
  }
}

#endif
