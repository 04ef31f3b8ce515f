/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Input parts for the boundary tests: the six sides of a spline volume, cut into patches; and ways
 * to give the same part differently. Shares nothing with the library. */
#ifndef TSOLID_TEST_BOUNDARY_PARTS_H
#define TSOLID_TEST_BOUNDARY_PARTS_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tsolid.h"

static unsigned long long part_seed = 2024;

static inline double random_unit(void) {
  part_seed = part_seed * 6364136223846793005ULL + 1442695040888963407ULL;
  return (double)(part_seed >> 11) / 9007199254740992.0;
}

static inline int random_below(int n) {
  return (int)(random_unit() * n);
}

/* The knots of one strip of one axis: degree and inner knots on [0,1]. */
typedef struct strip {
  int degree, n_inner;
  double inner[8];
} strip;

typedef struct axis_spec {
  int n_strips;
  strip strip[4];
} axis_spec;

/* Owned patches; all arrays are malloc'ed. */
typedef struct part {
  int n;
  tsolid_patch *patch;
} part;

static inline double *part_doubles(size_t n) {
  return calloc(n ? n : 1, sizeof(double));
}

static inline void part_free(part *p) {
  for (int k = 0; k < p->n; k++) {
    free((void *)(size_t)p->patch[k].knots[0]);
    free((void *)(size_t)p->patch[k].knots[1]);
    free((void *)(size_t)p->patch[k].points);
    free((void *)(size_t)p->patch[k].weights);
  }
  free(p->patch);
  p->n = 0;
  p->patch = NULL;
}

static inline double *strip_knots(const strip *s, int *n_control) {
  int p = s->degree, n = 0;
  double *knots = part_doubles((size_t)(2 * p + 2 + s->n_inner));
  for (int i = 0; i <= p; i++)
    knots[n++] = 0.0;
  for (int i = 0; i < s->n_inner; i++)
    knots[n++] = s->inner[i];
  for (int i = 0; i <= p; i++)
    knots[n++] = 1.0;
  *n_control = n - p - 1;
  return knots;
}

/* Greville abscissae: control points there reproduce linear functions. */
static inline double greville(const double *knots, int degree, int i) {
  double sum = 0.0;
  for (int k = 1; k <= degree; k++)
    sum += knots[i + k];
  return sum / degree;
}

/* The map that places control points: world point and weight of (x, y, z) in [0,1]^3. */
typedef void (*part_map)(const double u[3], double point[3], double *weight);

/* One patch of side `side`: strips i, j of its two axes. */
static inline void make_side_patch(const axis_spec axis[3], int side, int i, int j, part_map map,
                                   int rational, tsolid_patch *patch) {
  int a = side >> 1, d[2] = {a == 0 ? 1 : 0, a == 2 ? 1 : 2}, at[2] = {i, j};
  double *knots[2];
  memset(patch, 0, sizeof *patch);
  for (int k = 0; k < 2; k++) {
    const strip *s = &axis[d[k]].strip[at[k]];
    patch->degree[k] = s->degree;
    knots[k] = strip_knots(s, &patch->n_control[k]);
    patch->knots[k] = knots[k];
  }
  size_t n = (size_t)patch->n_control[0] * (size_t)patch->n_control[1], row = 0;
  double *points = part_doubles(3 * n), *weights = part_doubles(n);
  for (int v = 0; v < patch->n_control[1]; v++)
    for (int u = 0; u < patch->n_control[0]; u++, row++) {
      double x[3];
      int index[2] = {u, v};
      x[a] = side & 1;
      for (int k = 0; k < 2; k++)
        x[d[k]] = (at[k] + greville(knots[k], patch->degree[k], index[k])) / axis[d[k]].n_strips;
      map(x, points + 3 * row, weights + row);
    }
  patch->points = points;
  patch->weights = rational ? weights : NULL;
  if (!rational)
    free(weights);
}

static inline part make_part(const axis_spec axis[3], part_map map, int rational) {
  part p = {0, NULL};
  int n[3] = {axis[0].n_strips, axis[1].n_strips, axis[2].n_strips};
  p.patch = calloc((size_t)(2 * (n[0] * n[1] + n[1] * n[2] + n[0] * n[2])), sizeof *p.patch);
  for (int side = 0; side < 6; side++) {
    int s = side >> 1 == 0 ? 1 : 0, t = side >> 1 == 2 ? 1 : 2;
    for (int j = 0; j < n[t]; j++)
      for (int i = 0; i < n[s]; i++)
        make_side_patch(axis, side, i, j, map, rational, &p.patch[p.n++]);
  }
  return p;
}

/* The same surface with u and v reversed as flip says, then exchanged. */
static inline tsolid_patch reorient_patch(const tsolid_patch *from, int flip_u, int flip_v,
                                          int swap) {
  tsolid_patch to = *from;
  int flip[2] = {flip_u, flip_v}, n0 = from->n_control[0], n1 = from->n_control[1];
  double *knots[2], *points = part_doubles(3 * (size_t)n0 * (size_t)n1);
  double *weights = from->weights ? part_doubles((size_t)n0 * (size_t)n1) : NULL;
  for (int d = 0; d < 2; d++) {
    int n = from->n_control[d] + from->degree[d] + 1;
    double first = from->knots[d][0], last = from->knots[d][n - 1];
    knots[d] = part_doubles((size_t)n);
    for (int i = 0; i < n; i++)
      knots[d][i] = flip[d] ? first + last - from->knots[d][n - 1 - i] : from->knots[d][i];
    int e = swap ? 1 - d : d;
    to.degree[e] = from->degree[d];
    to.n_control[e] = from->n_control[d];
    to.knots[e] = knots[d];
  }
  for (int j = 0; j < n1; j++)
    for (int i = 0; i < n0; i++) {
      int u = flip_u ? n0 - 1 - i : i, v = flip_v ? n1 - 1 - j : j;
      int at = swap ? v + to.n_control[0] * u : u + to.n_control[0] * v;
      memcpy(points + 3 * at, from->points + 3 * (i + n0 * j), 3 * sizeof(double));
      if (weights)
        weights[at] = from->weights[i + n0 * j];
    }
  to.points = points;
  to.weights = weights;
  /* natural border b of `to` is which border of `from`? Corners carry the names. */
  for (int b = 0; b < 4; b++) {
    int old[2];
    for (int k = 0; k < 2; k++) {
      int corner = (b + k) % 4, x = corner == 1 || corner == 2, y = corner >= 2;
      int p = swap ? y : x, q = swap ? x : y;
      p ^= flip_u;
      q ^= flip_v;
      old[k] = q ? (p ? 2 : 3) : (p ? 1 : 0);
    }
    int border = (old[0] + 1) % 4 == old[1] ? old[0] : old[1];
    to.corner_name[b] = from->corner_name[old[0]];
    to.border_name[b] = from->border_name[border];
    to.border_tolerance[b] = from->border_tolerance[border];
  }
  return to;
}

/* Random order and orientation of the patches; order[k]: where patch k went. */
static inline part shuffle_part(const part *from, int *order) {
  part to = {from->n, calloc((size_t)from->n, sizeof *to.patch)};
  for (int k = 0; k < from->n; k++)
    order[k] = k;
  for (int k = from->n - 1; k > 0; k--) {
    int j = random_below(k + 1), swap = order[k];
    order[k] = order[j];
    order[j] = swap;
  }
  for (int k = 0; k < from->n; k++)
    to.patch[order[k]] =
        reorient_patch(&from->patch[k], random_below(2), random_below(2), random_below(2));
  return to;
}

static inline part copy_part(const part *from) {
  part to = {from->n, calloc((size_t)from->n, sizeof *to.patch)};
  for (int k = 0; k < from->n; k++)
    to.patch[k] = reorient_patch(&from->patch[k], 0, 0, 0);
  return to;
}

/* S(u, v) by de Boor's algorithm, in every row and then across. */
static inline void part_de_boor(int p, int n, const double *knots, double x, int stride,
                                const double *points, double out[4]) {
  double d[26][4];
  int i = n - 1;
  while (i > p && (knots[i] > x || knots[i] == knots[i + 1]))
    i--;
  for (int j = 0; j <= p; j++)
    memcpy(d[j], points + 4 * stride * (i - p + j), sizeof d[j]);
  for (int r = 1; r <= p; r++)
    for (int j = p; j >= r; j--) {
      double left = knots[i - p + j], right = knots[i + 1 + j - r], a = (x - left) / (right - left);
      for (int k = 0; k < 4; k++)
        d[j][k] = (1.0 - a) * d[j - 1][k] + a * d[j][k];
    }
  memcpy(out, d[p], sizeof d[p]);
}

static inline void evaluate_patch(const tsolid_patch *patch, double u, double v, double x[3]) {
  int n0 = patch->n_control[0], n1 = patch->n_control[1];
  double *row = part_doubles(4 * (size_t)n0), *column = part_doubles(4 * (size_t)n1), h[4];
  for (int j = 0; j < n1; j++) {
    for (int i = 0; i < n0; i++) {
      double w = patch->weights ? patch->weights[i + n0 * j] : 1.0;
      for (int c = 0; c < 3; c++)
        row[4 * i + c] = w * patch->points[3 * (i + n0 * j) + c];
      row[4 * i + 3] = w;
    }
    part_de_boor(patch->degree[0], n0, patch->knots[0], u, 1, row, column + 4 * j);
  }
  part_de_boor(patch->degree[1], n1, patch->knots[1], v, 1, column, h);
  for (int c = 0; c < 3; c++)
    x[c] = h[c] / h[3];
  free(row);
  free(column);
}

/* The point (s, t) of a side of a boundary, by the monomials of the Bernstein basis. */
static inline int evaluate_boundary(const tsolid_bezier_boundary *b, int number, double s, double t,
                                    double x[3]) {
  const tsolid_bezier_side *side = &b->side[number];
  int n0 = side->degree[0] + 1, n1 = side->degree[1] + 1;
  for (int e = 0; e < side->n_elements; e++) {
    const double *box = side->box + 4 * e;
    if (s < box[0] || s > box[1] || t < box[2] || t > box[3])
      continue;
    double h[4] = {0.0, 0.0, 0.0, 0.0}, value[2][26];
    double at[2] = {(s - box[0]) / (box[1] - box[0]), (t - box[2]) / (box[3] - box[2])};
    for (int d = 0; d < 2; d++)
      for (int i = 0; i <= side->degree[d]; i++) {
        double binomial = 1.0;
        for (int k = 1; k <= i; k++)
          binomial = binomial * (side->degree[d] - i + k) / k;
        value[d][i] = binomial * pow(at[d], i) * pow(1.0 - at[d], side->degree[d] - i);
      }
    for (int k = side->function_start[e]; k < side->function_start[e + 1]; k++) {
      double n = 0.0;
      for (int j = 0; j < n1; j++)
        for (int i = 0; i < n0; i++)
          n += value[0][i] * value[1][j] * side->coefficient[(k * n1 + j) * n0 + i];
      for (int c = 0; c < 4; c++)
        h[c] += n * b->points[4 * side->function[k] + c];
    }
    for (int c = 0; c < 3; c++)
      x[c] = h[c] / h[3];
    return 1;
  }
  return 0;
}

#endif
