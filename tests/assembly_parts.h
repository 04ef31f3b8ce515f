/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Assemblies for tests: blocks of one global wavy map, so that neighbours share their faces, in any
 * arrangement; and ways to give the same parts differently. */
#ifndef TSOLID_TEST_ASSEMBLY_PARTS_H
#define TSOLID_TEST_ASSEMBLY_PARTS_H

#include "boundary_parts.h"

/* The block [low, high] of the map's domain; then turned and shifted in the world. */
typedef struct block {
  double low[3], high[3];
  double wave;  /* amplitude */
  int rational; /* weights that vary */
  axis_spec axis[3];
} block;

static block current_block;

static inline void block_map(const double u[3], double point[3], double *weight) {
  const block *b = &current_block;
  double x[3];
  for (int d = 0; d < 3; d++)
    x[d] = b->low[d] + u[d] * (b->high[d] - b->low[d]);
  point[0] = x[0] + b->wave * sin(2.1 * x[1] + 0.9 * x[2]);
  point[1] = x[1] + b->wave * sin(1.7 * x[2] + 1.3 * x[0]);
  point[2] = x[2] + b->wave * sin(1.9 * x[0] + 1.1 * x[1]);
  *weight = b->rational ? 1.0 + 0.2 * sin(x[0] + 2.0 * x[1] - 1.5 * x[2]) : 1.0;
}

/* One strip per axis, of this degree and these inner knots. */
static inline axis_spec plain_axis(int degree, int n_inner) {
  axis_spec a = {.n_strips = 1};
  a.strip[0].degree = degree;
  a.strip[0].n_inner = n_inner;
  for (int i = 0; i < n_inner; i++)
    a.strip[0].inner[i] = (i + 1.0) / (n_inner + 1);
  return a;
}

static inline block plain_block(double x, double y, double z, double wave, int degree,
                                int n_inner) {
  block b = {.low = {x, y, z}, .high = {x + 1.0, y + 1.0, z + 1.0}, .wave = wave};
  for (int d = 0; d < 3; d++)
    b.axis[d] = plain_axis(degree, n_inner);
  return b;
}

static inline part make_block(const block *b) {
  current_block = *b;
  return make_part(b->axis, block_map, b->rational);
}

/* The block as it is, patch by patch in this orientation. */
static inline part turn_part(const part *from, int code) {
  part to = {from->n, calloc((size_t)from->n, sizeof *to.patch)};
  for (int k = 0; k < from->n; k++)
    to.patch[k] = reorient_patch(&from->patch[k], code & 1, code >> 1 & 1, code >> 2);
  return to;
}

static inline void shift_part(part *p, const double by[3]) {
  for (int k = 0; k < p->n; k++) {
    double *x = (double *)(size_t)p->patch[k].points;
    for (int i = 0; i < p->patch[k].n_control[0] * p->patch[k].n_control[1]; i++)
      for (int c = 0; c < 3; c++)
        x[3 * i + c] += by[c];
  }
}

/* About the line through `at` along z. */
static inline void rotate_part(part *p, const double at[2], double angle) {
  double c = cos(angle), s = sin(angle);
  for (int k = 0; k < p->n; k++) {
    double *x = (double *)(size_t)p->patch[k].points;
    for (int i = 0; i < p->patch[k].n_control[0] * p->patch[k].n_control[1]; i++) {
      double d[2] = {x[3 * i] - at[0], x[3 * i + 1] - at[1]};
      x[3 * i] = at[0] + c * d[0] - s * d[1];
      x[3 * i + 1] = at[1] + s * d[0] + c * d[1];
    }
  }
}

/* Knots to another range. */
static inline void rescale_knots(part *p, double first, double range) {
  for (int k = 0; k < p->n; k++)
    for (int d = 0; d < 2; d++) {
      double *knot = (double *)(size_t)p->patch[k].knots[d];
      for (int i = 0; i < p->patch[k].n_control[d] + p->patch[k].degree[d] + 1; i++)
        knot[i] = first + range * knot[i];
    }
}

/* Inputs that own nothing. */
enum { MOST_PARTS = 512 };

typedef struct scene {
  int n;
  part part[MOST_PARTS];
  tsolid_boundary_input boundary[MOST_PARTS];
  tsolid_part member[MOST_PARTS];
  tsolid_assembly_input input;
} scene;

static inline void scene_add(scene *s, part p) {
  int k = s->n++;
  s->part[k] = p;
  s->boundary[k] = (tsolid_boundary_input){.n_patches = p.n, .patches = p.patch};
  s->member[k] = (tsolid_part){.boundary = &s->boundary[k]};
  s->input = (tsolid_assembly_input){.n_parts = s->n, .parts = s->member};
}

static inline void scene_add_block(scene *s, const block *b) {
  scene_add(s, make_block(b));
}

static inline void scene_free(scene *s) {
  for (int k = 0; k < s->n; k++)
    part_free(&s->part[k]);
  s->n = 0;
}

#endif
