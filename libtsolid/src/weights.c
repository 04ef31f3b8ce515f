/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Positive weights inside.
 *
 * If the boundary's weights are all one number, so are the inner ones. Else each inner weight is a
 * positive average of others (an M-matrix): minimise the sum over elements of
 *   sum_f m_f (w_f - mean)^2,  m_f = mean of function f on the element, mean = sum m w / sum m,
 * with the surface functions' weights given. (A Galerkin solve could go negative.) */
#include "solid.h"
#include "solve.h"

static const char *const STAGE = "solid";

static const double REDUCTION = 1e-13;
enum { MAX_STEPS = 2000 };

typedef struct weight_system {
  const tsolid_space *space;
  const double *entry_mean;   /* per entry of the space: m_f */
  const double *surface_mean; /* per element: sum of m of all surface functions on it */
} weight_system;

static double row_mean(const double row[4]) {
  return 0.25 * (row[0] + row[1] + row[2] + row[3]);
}

/* y = A w: per element m_f (w_f - mean), surface weights zero. */
static void apply_weights(void *data, const double *w, double *y) {
  const weight_system *s = data;
  const tsolid_space *space = s->space;
  memset(y, 0, (size_t)space->n_inner * sizeof *y);
  for (int e = 0; e < space->n_elements; e++) {
    double total = s->surface_mean[e], sum = 0.0;
    size_t first = space->inner_start[e], end = space->inner_start[e + 1];
    for (size_t i = first; i < end; i++) {
      total += s->entry_mean[i];
      sum += s->entry_mean[i] * w[space->inner_function[i]];
    }
    for (size_t i = first; i < end; i++) {
      int f = space->inner_function[i];
      y[f] += s->entry_mean[i] * (w[f] - sum / total);
    }
  }
}

/* Means of surface functions on an element: sum of m, and sum of m times the weight. */
static void surface_means(const tsolid_space *space, int element, double *sum_m, double *sum_mw) {
  const tsi_element *e = &space->element[element];
  *sum_m = *sum_mw = 0.0;
  if (e->block == 0)
    return;
  const tsi_lateral *l = &space->lateral[e->lateral];
  double radial = 0.0;
  for (int layer = 0; layer < 2; layer++)
    if (e->radial[layer] >= 0)
      radial += row_mean(space->row + 4 * (size_t)e->radial[layer]);
  int size = (l->degree[0] + 1) * (l->degree[1] + 1);
  const double *c = space->lateral_coefficient + l->coefficient_first;
  for (int f = l->function_first; f < l->function_end; f++, c += size) {
    double mean = 0.0;
    for (int i = 0; i < size; i++)
      mean += c[i];
    mean *= radial / size;
    *sum_m += mean;
    *sum_mw += mean * space->boundary->points[4 * (size_t)space->lateral_function[f] + 3];
  }
}

static tsolid_status solve_weights(tsolid_context *context, const tsolid_space *space, double low,
                                   double high, double *weight) {
  tsi_arena arena = tsi_arena_create(context);
  tsolid_status status = TSOLID_OK;
  size_t n = (size_t)space->n_inner, n_entries = space->inner_start[space->n_elements];
  double *mean = tsi_arena_new(&arena, n_entries, sizeof *mean);
  double *surface = tsi_arena_new(&arena, (size_t)space->n_elements, sizeof *surface);
  double *b = tsi_arena_new(&arena, n, sizeof *b), *diagonal = tsi_arena_new(&arena, n, sizeof *b);
  if (!mean || !surface || !b || !diagonal) {
    status = tsi_no_memory(context, STAGE);
    goto done;
  }
  for (int e = 0; e < space->n_elements; e++) {
    double given, total;
    surface_means(space, e, &surface[e], &given);
    total = surface[e];
    for (size_t i = space->inner_start[e]; i < space->inner_start[e + 1]; i++) {
      mean[i] = 1.0;
      for (int a = 0; a < 3; a++)
        mean[i] *= row_mean(space->row + 4 * (size_t)space->inner_row[i][a]);
      total += mean[i];
    }
    for (size_t i = space->inner_start[e]; i < space->inner_start[e + 1]; i++) {
      int f = space->inner_function[i];
      b[f] += mean[i] * given / total;
      diagonal[f] += mean[i] * (1.0 - mean[i] / total);
    }
  }
  for (size_t f = 0; f < n; f++)
    weight[f] = sqrt(low * high);
  weight_system system = {space, mean, surface};
  int steps;
  status = tsi_conjugate_gradients(context, STAGE, space->n_inner, apply_weights, &system, diagonal,
                                   b, REDUCTION, MAX_STEPS, weight, &steps);
  for (size_t f = 0; f < n; f++) /* round-off of the solve */
    weight[f] = fmin(fmax(weight[f], low), high);
done:
  tsi_arena_free(&arena);
  return status;
}

tsolid_status tsi_weights_choose(tsolid_context *context, const tsolid_space *space,
                                 double *control) {
  size_t n = (size_t)space->n_inner, m = (size_t)space->n_surface;
  const double *points = space->boundary->points;
  double low = points[3], high = points[3];
  for (size_t i = 0; i < m; i++) {
    double w = points[4 * i + 3];
    low = fmin(low, w);
    high = fmax(high, w);
    control[4 * (n + i) + 3] = control[4 * (n + m + i) + 3] = w;
  }
  if (low == high) {
    for (size_t f = 0; f < n; f++)
      control[4 * f + 3] = low;
    return TSOLID_OK;
  }
  double *weight = tsi_new(&context->allocator, n, sizeof *weight);
  if (!weight)
    return tsi_no_memory(context, STAGE);
  tsolid_status status = solve_weights(context, space, low, high, weight);
  for (size_t f = 0; f < n; f++)
    control[4 * f + 3] = weight[f];
  tsi_delete(&context->allocator, weight);
  return status;
}
