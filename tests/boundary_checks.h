/* SPDX-License-Identifier: LGPL-2.1-or-later
 * What the boundary tests have in common: make a boundary, compare two, compare one with its part.
 */
#ifndef TSOLID_TEST_BOUNDARY_CHECKS_H
#define TSOLID_TEST_BOUNDARY_CHECKS_H

#include "boundary_parts.h"
#include "check.h"
#include "internal.h"

static inline tsolid_context *new_context(void) {
  tsolid_context *context = NULL;
  if (tsolid_context_create(NULL, &context))
    exit(1);
  return context;
}

static inline tsolid_boundary *create(tsolid_context *context, const part *p,
                                      const tsolid_boundary_options *options) {
  tsolid_boundary *boundary = NULL;
  tsolid_boundary_input input = {.n_patches = p->n, .patches = p->patch};
  tsolid_status status = tsolid_boundary_create(context, &input, options, NULL, &boundary);
  if (!CHECK(status == TSOLID_OK && boundary))
    for (int i = 0; i < tsolid_context_n_findings(context); i++)
      fprintf(stderr, "    %s\n", tsolid_context_finding(context, i)->text);
  return boundary;
}

static inline int same_sides(const tsolid_bezier_side *a, const tsolid_bezier_side *b) {
  if (a->degree[0] != b->degree[0] || a->degree[1] != b->degree[1] ||
      a->n_elements != b->n_elements)
    return 0;
  size_t n = (size_t)a->n_elements;
  if (memcmp(a->function_start, b->function_start, (n + 1) * sizeof(int)) != 0)
    return 0;
  size_t m = (size_t)a->function_start[n];
  size_t width = (size_t)(a->degree[0] + 1) * (size_t)(a->degree[1] + 1);
  return memcmp(a->box, b->box, 4 * n * sizeof(double)) == 0 &&
         memcmp(a->function, b->function, m * sizeof(int)) == 0 &&
         memcmp(a->coefficient, b->coefficient, m * width * sizeof(double)) == 0;
}

static inline int same_boundaries(const tsolid_boundary *a, const tsolid_boundary *b) {
  if (!a || !b)
    return 0;
  tsolid_bezier_boundary x, y;
  tsolid_boundary_view(a, &x);
  tsolid_boundary_view(b, &y);
  if (x.n_functions != y.n_functions ||
      memcmp(x.points, y.points, 4 * (size_t)x.n_functions * sizeof(double)) != 0)
    return 0;
  for (int i = 0; i < 6; i++)
    if (!same_sides(&x.side[i], &y.side[i]))
      return 0;
  return memcmp(a->requirement.corner, b->requirement.corner, sizeof a->requirement.corner) == 0;
}

static inline int same_records(const tsolid_boundary *a, const tsolid_boundary *b) {
  return memcmp(&a->requirement, &b->requirement, sizeof a->requirement) == 0 &&
         memcmp(&a->preparation, &b->preparation, sizeof a->preparation) == 0 &&
         memcmp(&a->scale, &b->scale, sizeof a->scale) == 0;
}

/* (u, v) of a patch to (s, t) of the side. */
static inline void apply_placement(const tsolid_placement *place, double u, double v, double *s,
                                   double *t) {
  double p = (u - place->domain[0]) / (place->domain[1] - place->domain[0]);
  double q = (v - place->domain[2]) / (place->domain[3] - place->domain[2]);
  double m = place->moebius[0], n = place->moebius[1];
  p = m * p / (m * p + (1.0 - p));
  q = n * q / (n * q + (1.0 - q));
  double a = place->flip[0] ? 1.0 - p : p, b = place->flip[1] ? 1.0 - q : q;
  *s = fmin(place->box[0] + (place->swap ? b : a) * (place->box[1] - place->box[0]), 1.0);
  *t = fmin(place->box[2] + (place->swap ? a : b) * (place->box[3] - place->box[2]), 1.0);
}

/* Largest distance of one patch and the boundary at n random parameters, and the four corners of
 * all its pieces. */
static inline double measure_patch_distance(const tsolid_patch *patch, int k,
                                            const tsolid_boundary *boundary, int n) {
  tsolid_bezier_boundary view;
  double worst = 0.0, area = 0.0, whole = 1.0;
  int n_pieces = tsolid_boundary_n_placements(boundary, k);
  tsolid_boundary_view(boundary, &view);
  for (int d = 0; d < 2; d++)
    whole *= patch->knots[d][patch->n_control[d]] - patch->knots[d][patch->degree[d]];
  for (int j = 0; j < n_pieces; j++) {
    tsolid_placement place;
    if (tsolid_boundary_placement(boundary, k, j, &place))
      return INFINITY;
    area += (place.domain[1] - place.domain[0]) * (place.domain[3] - place.domain[2]);
    for (int i = 0; i < 4 + n / n_pieces; i++) {
      double p = i < 4 ? i & 1 : random_unit(), q = i < 4 ? i >> 1 : random_unit(), s, t;
      double u = place.domain[0] + p * (place.domain[1] - place.domain[0]), x[3], y[3];
      double v = place.domain[2] + q * (place.domain[3] - place.domain[2]);
      apply_placement(&place, u, v, &s, &t);
      evaluate_patch(patch, u, v, x);
      if (!evaluate_boundary(&view, place.side, s, t, y))
        return INFINITY;
      worst = fmax(worst, hypot(hypot(x[0] - y[0], x[1] - y[1]), x[2] - y[2]));
    }
  }
  return fabs(area / whole - 1.0) < 1e-12 ? worst : INFINITY; /* the pieces are the patch */
}

/* The largest of all patches, relative to the part's size. */
static inline double measure_distance(const part *p, const tsolid_boundary *boundary) {
  double worst = 0.0;
  for (int k = 0; k < p->n; k++)
    worst = fmax(worst, measure_patch_distance(&p->patch[k], k, boundary, 60));
  return worst / tsolid_boundary_scale(boundary);
}

static inline double largest_snap(const tsolid_boundary *boundary) {
  double largest = 0.0;
  for (int i = 0; i < 12; i++)
    largest = fmax(largest, boundary->preparation.snap[i]);
  for (int i = 0; i < 6; i++)
    largest = fmax(largest, boundary->preparation.snap_inside[i]);
  return largest;
}

/* Random orders and orientations of the patches change nothing. */
static inline void check_shuffles(tsolid_context *context, const part *p, int n, double allowed) {
  tsolid_boundary *first = create(context, p, NULL);
  int *order = malloc((size_t)p->n * sizeof *order);
  for (int i = 0; i < n; i++) {
    part other = shuffle_part(p, order);
    tsolid_boundary *boundary = create(context, &other, NULL);
    CHECK(same_boundaries(first, boundary));
    if (boundary && first) {
      CHECK(same_records(first, boundary));
      CHECK_NEAR(measure_distance(&other, boundary), 0.0, allowed);
    }
    tsolid_boundary_free(boundary);
    part_free(&other);
  }
  free(order);
  tsolid_boundary_free(first);
}

/* The six patches relabelled by all 48 symmetries of the parametric cube: new axis a is old axis
 * permutation[a], reversed where flip says. */
static inline void check_orientations(tsolid_context *context, const part *p) {
  static const int permutations[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                         {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  tsolid_boundary *first = create(context, p, NULL);
  for (int k = 0; k < 48; k++) {
    const int *permutation = permutations[k % 6];
    int flip[3] = {k / 6 & 1, k / 12 & 1, k / 24 & 1};
    part other = {6, calloc(6, sizeof *other.patch)};
    for (int side = 0; side < 6; side++) {
      int a = side >> 1, s = a == 0 ? 1 : 0, t = a == 2 ? 1 : 2;
      int old = 2 * permutation[a] + ((side & 1) ^ flip[a]);
      int swap = permutation[s] > permutation[t];
      other.patch[side] =
          reorient_patch(&p->patch[old], swap ? flip[t] : flip[s], swap ? flip[s] : flip[t], swap);
    }
    tsolid_boundary *boundary = create(context, &other, NULL);
    CHECK(same_boundaries(first, boundary));
    CHECK(boundary && same_records(first, boundary));
    tsolid_boundary_free(boundary);
    part_free(&other);
  }
  tsolid_boundary_free(first);
}

/* ---- memory ------------------------------------------------------------------------------------
 */

typedef struct counting {
  long n_requests, fail_at, n_live;
} counting;

static inline void *count_allocate(void *data, size_t size) {
  counting *c = data;
  if (++c->n_requests == c->fail_at)
    return NULL;
  void *memory = malloc(size);
  c->n_live += memory != NULL;
  return memory;
}

static inline void count_release(void *data, void *memory) {
  ((counting *)data)->n_live--;
  free(memory);
}

/* Fails the k-th request, k = 1, 2, ..., until nothing fails. */
static inline void check_failing_memory(const tsolid_boundary_input *input) {
  for (long k = 1; k < 100000; k++) {
    counting c = {0, k, 0};
    tsolid_context_options context_options = {
        .allocate = count_allocate, .release = count_release, .allocator_data = &c};
    tsolid_context *context = NULL;
    tsolid_boundary *boundary = NULL;
    tsolid_status status = tsolid_context_create(&context_options, &context);
    if (!status)
      status = tsolid_boundary_create(context, input, NULL, NULL, &boundary);
    CHECK(status == TSOLID_OK || (status == TSOLID_ERROR_MEMORY && !boundary));
    tsolid_context_free(context);
    int survived = status == TSOLID_OK;
    if (survived)
      CHECK(boundary && tsolid_boundary_scale(boundary) > 0.0); /* outlives its context */
    tsolid_boundary_free(boundary);
    CHECK(c.n_live == 0);
    if (survived) {
      CHECK(c.n_requests < k && k > 50);
      return;
    }
  }
  check_that(0, "memory ran out for ever", __FILE__, __LINE__);
}

/* Largest |sum of the functions - 1| over the Bernstein coefficients of all elements. */
static inline double sum_defect(const tsolid_boundary *boundary) {
  double worst = 0.0;
  for (int i = 0; i < 6; i++) {
    const tsi_side *side = &boundary->side[i];
    int width = (side->degree[0] + 1) * (side->degree[1] + 1);
    for (int e = 0; e < side->n_elements; e++)
      for (int c = 0; c < width; c++) {
        double sum = 0.0;
        for (int k = side->function_start[e]; k < side->function_start[e + 1]; k++)
          sum += side->coefficient[k * width + c];
        worst = fmax(worst, fabs(sum - 1.0));
      }
  }
  return worst;
}

#endif
