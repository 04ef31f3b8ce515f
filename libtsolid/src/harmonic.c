/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The start: positive inner weights, then a harmonic map of the cross.
 *
 * Weights: if the boundary's are all one number, so are the inner ones. Else each inner weight is a
 * positive average of others (an M-matrix): minimise sum over elements of
 *   sum_f m_f (w_f - mean)^2,  m_f = mean of function f on the element, mean = sum m w / sum m,
 * with the surface functions' weights given. A Galerkin solve could go negative.
 *
 * Positions: minimise 1/2 int |grad x|^2 over the cross with its own metric, rational basis, the
 * boundary layer given. */
#include "bernstein.h"
#include "kernel.h"
#include "solve.h"
#include "solid.h"

static const char *const STAGE = "solid";

static const double WEIGHT_REDUCTION = 1e-13, START_REDUCTION = 1e-7;
enum { MAX_STEPS = 2000 };

/* ---- weights
 * ----------------------------------------------------------------------------------------- */

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
                                   b, WEIGHT_REDUCTION, MAX_STEPS, weight, &steps);
  for (size_t f = 0; f < n; f++) /* round-off of the solve */
    weight[f] = fmin(fmax(weight[f], low), high);
done:
  tsi_arena_free(&arena);
  return status;
}

/* Weights of all functions into column 3 of control. */
static tsolid_status choose_weights(tsolid_context *context, const tsolid_space *space,
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

/* ---- positions
 * ------------------------------------------------------------------------------------------ */

/* Density of 1/2 |grad x|^2 in cross coordinates. */
static void dirichlet_density(const void *data, int element, int n, int stride,
                              const double *weight, const double *j, double *energy, double *g) {
  const double *box = ((const tsolid_space *)data)->element[element].box;
  double h[3], volume = 1.0, sum = 0.0;
  for (int a = 0; a < 3; a++) {
    h[a] = box[a + 3] - box[a];
    volume *= h[a];
  }
  for (int i = 0; i < 9; i++) {
    double factor = volume / (h[i % 3] * h[i % 3]);
    const double *x = j + (ptrdiff_t)i * stride;
    double *y = g + (ptrdiff_t)i * stride;
    for (int q = 0; q < n; q++) {
      y[q] = weight[q] * factor * x[q];
      sum += 0.5 * y[q] * x[q];
    }
  }
  *energy += sum;
}

typedef struct start_system {
  tsi_kernel *kernel;
  const tsolid_space *space;
  double *position; /* all functions; the boundary layer is zero while the operator is applied */
} start_system;

static void apply_start(void *data, const double *x, double *y) {
  start_system *s = data;
  double energy;
  size_t n_free = 3 * (size_t)(s->space->n_inner + s->space->n_surface);
  memcpy(s->position, x, n_free * sizeof *x);
  tsi_kernel_energy(s->kernel, s->position, dirichlet_density, s->space, NULL, &energy, y, NULL);
}

/* Integrals over [0,1] of the square of a cubic with Bernstein coefficients c, and of its slope. */
static void square_integrals(const double c[4], double *square, double *slope) {
  double sum = 0.0, sum_slope = 0.0, d[3] = {c[1] - c[0], c[2] - c[1], c[3] - c[2]};
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 4; k++)
      sum += c[i] * c[k] * tsi_binomial(3, i) * tsi_binomial(3, k) / tsi_binomial(6, i + k);
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++)
      sum_slope += d[i] * d[k] * tsi_binomial(2, i) * tsi_binomial(2, k) / tsi_binomial(4, i + k);
  *square = sum / 7.0;
  *slope = 9.0 * sum_slope / 5.0;
}

int tsi_stiffness_diagonal(const tsolid_space *space, const tsi_allocator *allocator,
                           const double *control, const double (*factor)[3], double *diagonal) {
  double(*integral)[2] = tsi_new(allocator, (size_t)space->n_rows, sizeof *integral);
  if (!integral)
    return 0;
  for (int r = 0; r < space->n_rows; r++)
    square_integrals(space->row + 4 * (size_t)r, &integral[r][0], &integral[r][1]);
  for (int e = 0; e < space->n_elements; e++) {
    const tsi_element *el = &space->element[e];
    for (size_t i = space->inner_start[e]; i < space->inner_start[e + 1]; i++)
      for (int a = 0; a < 3; a++) {
        double part = factor[e][a];
        for (int b = 0; b < 3; b++)
          part *= integral[space->inner_row[i][b]][a == b];
        diagonal[space->inner_function[i]] += part;
      }
    if (el->radial[0] < 0)
      continue;
    const tsi_lateral *l = &space->lateral[el->lateral];
    int side = el->block - 1, size = (l->degree[0] + 1) * (l->degree[1] + 1);
    const double *c = space->lateral_coefficient + l->coefficient_first;
    const double *radial = integral[el->radial[0]];
    double lateral = factor[e][tsi_side_s(side)] + factor[e][tsi_side_t(side)];
    for (int f = l->function_first; f < l->function_end; f++, c += size) {
      double square = 0.0;
      for (int i = 0; i < size; i++)
        square += c[i] * c[i] / size;
      diagonal[space->n_inner + space->lateral_function[f]] +=
          square * (radial[1] * factor[e][tsi_side_axis(side)] + 4.0 * radial[0] * lateral);
    }
  }
  tsi_delete(allocator, integral);
  for (int f = 0; f < space->n_inner + space->n_surface; f++)
    diagonal[f] *= control[4 * (size_t)f + 3] * control[4 * (size_t)f + 3];
  return 1;
}

/* Factors of the Dirichlet integral: volume / h_a^2. */
static double (*dirichlet_factors(const tsolid_space *space, tsi_arena *arena))[3] {
  double(*factor)[3] = tsi_arena_new(arena, (size_t)space->n_elements, sizeof *factor);
  for (int e = 0; factor && e < space->n_elements; e++) {
    const double *box = space->element[e].box;
    double h[3] = {box[3] - box[0], box[4] - box[1], box[5] - box[2]};
    for (int a = 0; a < 3; a++)
      factor[e][a] = h[0] * h[1] * h[2] / (h[a] * h[a]);
  }
  return factor;
}

static tsolid_status solve_positions(tsolid_context *context, const tsolid_space *space,
                                     double *control) {
  tsi_arena arena = tsi_arena_create(context);
  size_t n_free = (size_t)(space->n_inner + space->n_surface), m = (size_t)space->n_surface;
  double *position = tsi_arena_new(&arena, n_free + m, 3 * sizeof *position);
  double *x = tsi_arena_new(&arena, n_free, 3 * sizeof *x);
  double *b = tsi_arena_new(&arena, n_free, 3 * sizeof *b);
  double *diagonal = tsi_arena_new(&arena, n_free, sizeof *diagonal);
  double *diagonal3 = tsi_arena_new(&arena, n_free, 3 * sizeof *diagonal3);
  tsi_kernel *kernel = NULL;
  tsolid_status status = TSOLID_OK;
  double energy;
  int steps;
  double(*factor)[3] = dirichlet_factors(space, &arena);
  if (!position || !x || !b || !diagonal || !diagonal3 || !factor ||
      !tsi_stiffness_diagonal(space, &context->allocator, control,
                              (const double(*)[3])factor, diagonal)) {
    status = tsi_no_memory(context, STAGE);
    goto done;
  }
  status = tsi_kernel_create(context, space, control, TSI_GAUSS, &kernel);
  if (status != TSOLID_OK)
    goto done;
  double centre[3];
  tsi_boundary_positions(space, position + 3 * n_free, centre);
  tsi_kernel_energy(kernel, position, dirichlet_density, space, NULL, &energy, b, NULL);
  memset(position + 3 * n_free, 0, 3 * m * sizeof *position);
  for (size_t i = 0; i < 3 * n_free; i++) {
    b[i] = -b[i];
    diagonal3[i] = diagonal[i / 3];
  }
  start_system system = {kernel, space, position};
  status = tsi_conjugate_gradients(context, STAGE, (int)(3 * n_free), apply_start, &system,
                                   diagonal3, b, START_REDUCTION, MAX_STEPS, x, &steps);
  for (size_t f = 0; f < n_free && status == TSOLID_OK; f++)
    for (size_t c = 0; c < 3; c++)
      control[4 * f + c] = control[4 * f + 3] * (x[3 * f + c] + centre[c]);
done:
  tsi_kernel_free(kernel);
  tsi_arena_free(&arena);
  return status;
}

tsolid_status tsolid_solid_create(tsolid_context *context, const tsolid_space *space,
                                  tsolid_solid **solid) {
  if (!context || !space || !solid)
    return TSOLID_ERROR_ARGUMENT;
  *solid = NULL;
  size_t n_free = (size_t)(space->n_inner + space->n_surface), m = (size_t)space->n_surface;
  double *control = tsi_new(&context->allocator, 4 * (n_free + m), sizeof *control);
  if (!control)
    return tsi_no_memory(context, STAGE);
  tsolid_status status = choose_weights(context, space, control);
  if (status == TSOLID_OK)
    status = solve_positions(context, space, control);
  memcpy(control + 4 * n_free, space->boundary->points, 4 * m * sizeof *control);
  if (status == TSOLID_OK)
    status = tsi_solid_new(context, space, control, (double)NAN, solid);
  tsi_delete(&context->allocator, control);
  return status;
}
