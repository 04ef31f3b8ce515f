/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Parts for the C tests: the surface of a tensor product B-spline cube as Bezier elements, with any
 * degree, spans and knot multiplicity per axis, its functions crossing the isolines; and solids
 * whose inner control points are the boundary drawn together towards the centre. */
#ifndef TSOLID_TEST_CUBE_PART_H
#define TSOLID_TEST_CUBE_PART_H

#include <stdio.h>
#include <stdlib.h>

#include "bernstein.h"
#include "conform.h"
#include "internal.h"

typedef struct cube_axis {
  int degree, n_spans, multiplicity; /* of inner knots: 1 .. degree */
} cube_axis;

typedef struct cube_part {
  tsolid_bezier_boundary boundary;
  int n[3];   /* functions per axis */
  int *id;    /* n[0]*n[1]*n[2]: surface function, or -1 */
  int *place; /* per surface function: 3 indices */
} cube_part;

/* Moves a Greville point of the unit cube and sets its weight: p = x, y, z, w. */
typedef void (*cube_map)(double p[4]);

static inline double cube_break(const cube_axis *axis, int i) {
  double x = (double)i / axis->n_spans;
  return i == 0 || i == axis->n_spans ? x : x + 0.2 / axis->n_spans * sin(3.0 * x + 0.5);
}

static inline int cube_n_functions(const cube_axis *axis) {
  return axis->degree + 1 + (axis->n_spans - 1) * axis->multiplicity;
}

static inline void cube_knots(const cube_axis *axis, double *knot) {
  int n = 0;
  for (int i = 0; i <= axis->n_spans; i++) {
    int end = i == 0 || i == axis->n_spans;
    for (int k = 0; k < (end ? axis->degree + 1 : axis->multiplicity); k++)
      knot[n++] = cube_break(axis, i);
  }
}

static inline void cube_fill_side(cube_part *part, const cube_axis axis[3], double *const knot[3],
                                  int side) {
  tsolid_bezier_side *out = &part->boundary.side[side];
  int a[2] = {tsi_side_s(side), tsi_side_t(side)}, p = axis[a[0]].degree, q = axis[a[1]].degree;
  int n_elements = axis[a[0]].n_spans * axis[a[1]].n_spans, nf = (p + 1) * (q + 1), at = 0;
  double *box = calloc((size_t)n_elements * 4, sizeof *box);
  int *start = calloc((size_t)n_elements + 1, sizeof *start);
  int *function = calloc((size_t)(n_elements * nf), sizeof *function);
  double *coefficient = calloc((size_t)(n_elements * nf) * (size_t)nf, sizeof *coefficient);
  for (int e = 0; e < n_elements; e++) {
    int span[2] = {e % axis[a[0]].n_spans, e / axis[a[0]].n_spans};
    for (int k = 0; k < 4; k++)
      box[4 * e + k] = cube_break(&axis[a[k / 2]], span[k / 2] + k % 2);
    for (int f = 0; f < nf; f++, at++) {
      int i[3], local[2] = {f % (p + 1), f / (p + 1)};
      double row[2][TSI_MAX_ORDER];
      i[side / 2] = side & 1 ? part->n[side / 2] - 1 : 0;
      for (int k = 0; k < 2; k++) {
        i[a[k]] = span[k] * axis[a[k]].multiplicity + local[k];
        tsi_bspline_bernstein(axis[a[k]].degree, knot[a[k]] + i[a[k]], box[4 * e + 2 * k],
                              box[4 * e + 2 * k + 1], row[k]);
      }
      function[at] = part->id[i[0] + part->n[0] * (i[1] + part->n[1] * i[2])];
      for (int k = 0; k < nf; k++)
        coefficient[at * nf + k] = row[0][k % (p + 1)] * row[1][k / (p + 1)];
    }
    start[e + 1] = at;
  }
  *out = (tsolid_bezier_side){{p, q}, n_elements, box, start, function, coefficient};
}

static inline cube_part cube_part_create(const cube_axis axis[3], cube_map map) {
  cube_part part = {.id = NULL};
  double *knot[3], *points;
  int total = 1, count = 0;
  for (int d = 0; d < 3; d++) {
    part.n[d] = cube_n_functions(&axis[d]);
    total *= part.n[d];
    knot[d] = calloc((size_t)(part.n[d] + axis[d].degree + 1), sizeof(double));
    cube_knots(&axis[d], knot[d]);
  }
  part.id = calloc((size_t)total, sizeof *part.id);
  part.place = calloc((size_t)total, 3 * sizeof *part.place);
  points = calloc((size_t)total, 4 * sizeof *points);
  for (int g = 0; g < total; g++) {
    int i[3] = {g % part.n[0], g / part.n[0] % part.n[1], g / (part.n[0] * part.n[1])}, on = 0;
    double p[4] = {0.0, 0.0, 0.0, 1.0};
    for (int d = 0; d < 3; d++) {
      on |= i[d] == 0 || i[d] == part.n[d] - 1;
      for (int k = 1; k <= axis[d].degree; k++)
        p[d] += knot[d][i[d] + k] / axis[d].degree;
    }
    part.id[g] = on ? count : -1;
    if (!on)
      continue;
    if (map)
      map(p);
    for (int c = 0; c < 4; c++)
      points[4 * count + c] = c < 3 ? p[c] * p[3] : p[3];
    memcpy(part.place + 3 * count++, i, sizeof i);
  }
  part.boundary.n_functions = count;
  part.boundary.points = points;
  for (int side = 0; side < 6; side++)
    cube_fill_side(&part, axis, knot, side);
  for (int d = 0; d < 3; d++)
    free(knot[d]);
  return part;
}

static inline void cube_part_free(cube_part *part) {
  for (int side = 0; side < 6; side++) {
    const tsolid_bezier_side *s = &part->boundary.side[side];
    const void *owned[] = {s->box, s->function_start, s->function, s->coefficient};
    for (int k = 0; k < 4; k++)
      free((void *)(uintptr_t)owned[k]);
  }
  free((void *)(uintptr_t)part->boundary.points);
  free(part->id);
  free(part->place);
}

/* ---- solids ------------------------------------------------------------------------------------
 */

typedef struct cube_solid {
  tsolid_boundary *boundary;
  tsolid_tmesh *tmesh;
  tsolid_space *space;
  tsolid_solid *solid;
} cube_solid;

/* A point drawn together: the boundary point in the direction of cross coordinates u, moved
 * towards the centre of the part; a star-shaped part stays free of folds. */
static inline void cube_inner_point(const tsolid_space *space, const double centre[3],
                                    const double u[3], double point[3]) {
  double v[3], most = 0.0, factor = 0.6, unit[3];
  int side = 0;
  for (int d = 0; d < 3; d++) {
    double height =
        u[d] < 0.0 ? space->tmesh->arm_height[2 * d] : space->tmesh->arm_height[2 * d + 1];
    double outside = u[d] < 0.0 ? -u[d] : u[d] > 1.0 ? u[d] - 1.0 : 0.0;
    v[d] = 2.0 * fmin(fmax(u[d], 0.0), 1.0) - 1.0;
    factor = outside > 0.0 ? 0.6 + 0.4 * outside / height : factor;
    if (fabs(v[d]) > most) {
      most = fabs(v[d]);
      side = 2 * d + (v[d] > 0.0);
    }
  }
  for (int d = 0; d < 3; d++)
    unit[d] = most > 0.0 ? 0.5 + 0.5 * v[d] / most : 0.5;
  double surface[3] = {centre[0], centre[1], centre[2]};
  tsi_boundary_point(space->boundary, side, fmin(fmax(unit[tsi_side_s(side)], 0.0), 1.0),
                     fmin(fmax(unit[tsi_side_t(side)], 0.0), 1.0), surface);
  for (int d = 0; d < 3; d++)
    point[d] = centre[d] + factor * most * (surface[d] - centre[d]);
}

static inline double cube_noise(unsigned *state) {
  *state = *state * 1664525u + 1013904223u;
  return (double)(*state >> 8) / (1 << 24) - 0.5;
}

/* noise: inner points and weights are scattered by so much (relative to the part's size). */
static inline double *cube_control(const tsolid_space *space, double noise) {
  size_t n_inner = (size_t)space->n_inner, n_surface = (size_t)space->n_surface;
  double *control = calloc(4 * (n_inner + 2 * n_surface), sizeof *control), centre[3] = {0, 0, 0};
  const double *input = space->boundary->points;
  double size = 0.0;
  unsigned state = 7;
  for (size_t i = 0; i < 4 * n_surface; i++)
    if (i % 4 < 3)
      centre[i % 4] += input[i] / input[i - i % 4 + 3] / (double)n_surface;
  for (size_t i = 0; i < 4 * n_surface; i++)
    if (i % 4 < 3)
      size = fmax(size, fabs(input[i] / input[i - i % 4 + 3] - centre[i % 4]));
  for (size_t f = 0; f < n_inner + n_surface; f++) {
    double point[3], u[3], w = 1.0;
    if (f < n_inner) {
      for (int d = 0; d < 3;
           d++) { /* the Greville point: planes of one value would give points of one place */
        const double *value = space->tmesh->plane_value[d];
        const int *knot = space->piece[space->piece_start[f]].knot[d];
        u[d] = (value[knot[1]] + value[knot[2]] + value[knot[3]]) / 3.0;
      }
      cube_inner_point(space, centre, u, point);
    } else {
      const double *from = input + 4 * (f - n_inner);
      w = from[3];
      for (int d = 0; d < 3; d++)
        point[d] = centre[d] + 0.933 * (from[d] / w - centre[d]);
    }
    w *= 1.0 + noise * cube_noise(&state);
    for (size_t d = 0; d < 3; d++)
      control[4 * f + d] = w * (point[d] + noise * size * cube_noise(&state));
    control[4 * f + 3] = w;
  }
  memcpy(control + 4 * (n_inner + n_surface), input, 4 * n_surface * sizeof *control);
  return control;
}

static inline void cube_solid_free(cube_solid *s) {
  tsolid_solid_free(s->solid);
  tsolid_space_free(s->space);
  tsolid_tmesh_free(s->tmesh);
  tsolid_boundary_free(s->boundary);
}

/* 1: made; else what is missing is NULL and the context holds a finding. */
static inline int cube_solid_create(tsolid_context *context, const cube_axis axis[3], cube_map map,
                                    int min_cells, double noise, cube_solid *s) {
  cube_part part = cube_part_create(axis, map);
  tsolid_boundary_input input = {.bezier = &part.boundary};
  tsolid_tmesh_options options = {.min_cells = min_cells};
  *s = (cube_solid){.solid = NULL};
  tsolid_status status = tsolid_boundary_create(context, &input, NULL, NULL, &s->boundary);
  if (status == TSOLID_OK)
    status = tsolid_tmesh_create(context, s->boundary, &options, &s->tmesh);
  if (status == TSOLID_OK)
    status = tsolid_space_create(context, s->boundary, s->tmesh, &s->space);
  if (status == TSOLID_OK) {
    double *control = cube_control(s->space, noise);
    status = tsolid_solid_from_control(context, s->space, control, &s->solid);
    free(control);
  }
  cube_part_free(&part);
  if (status != TSOLID_OK && tsolid_context_n_findings(context) > 0)
    fprintf(stderr, "%s\n",
            tsolid_context_finding(context, tsolid_context_n_findings(context) - 1)->text);
  return status == TSOLID_OK;
}

/* Some maps. */
static inline void cube_wave(double p[4]) {
  double x = p[0], y = p[1], z = p[2];
  p[0] = 3.0 * x + 0.15 * sin(4.0 * y + z);
  p[1] = 2.0 * y + 0.15 * cos(3.0 * z + x);
  p[2] = 1.5 * z + 0.15 * sin(2.0 * x + 3.0 * y);
}

static inline void cube_rational(double p[4]) {
  cube_wave(p);
  p[3] = 1.0 + 0.3 * sin(p[0] + 2.0 * p[1] - p[2]);
}

#endif
