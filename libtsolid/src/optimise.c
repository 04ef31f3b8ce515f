/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Untangling and quality: inner control points that make det J positive, then raise its worst
 * place.
 *
 * With F = J diag(1/tau), tau the element's own target lengths (the mean physical length of its
 * block per direction times its share: plates of 1:100 are ordinary parts), D = det F and
 *   chi(D) = (D + sqrt(eps^2 + D^2)) / 2,
 * the density is a sum of
 *   shape   |F|^2 / (3 chi^(2/3)) + theta (D^2 + 1) / chi
 *   angle   (|F_0| |F_1| |F_2| / chi)^p, the p-th power of the inverse scaled Jacobian,
 * finite on inverted elements for eps > 0 and a barrier at D -> 0+ for eps -> 0.
 *
 * Source: Garanzha et al. (2021), Foldover-free maps in 50 lines of code, section 3, for the
 * regularisation; the angle term is ours. */
#include <lbfgs.h>

#include "boundary_bound.h"
#include "kernel.h"
#include "precondition.h"
#include "solid.h"

static const char *const STAGE = "optimise";

enum { HISTORY = 12, UNTANGLE_ROUNDS = 12, UNTANGLE_STEPS = 30, MAX_POWER = 32, ALL_UP_TO = 4 };

static const double THETA = 0.1;       /* weight of size against shape while untangling */
static const double SHAPE_KEPT = 0.01; /* what stays of shape while the worst place is raised */
static const double FIRST_EPSILON = 0.3, EPSILON_FALL = 0.3, LAST_EPSILON = 1e-4;
static const double NEGLIGIBLE = 1e-4; /* share of the worst element's energy */

/* What an effort aims at: when the worst place is that share of the input's own bound it is good
 * enough; steps per power. */
static const struct {
  double goal;
  int steps;
} EFFORT[4] = {{0.9, 40}, {0.0, 0}, {0.5, 20}, {0.99, 120}};

/* ---- densities
 * ------------------------------------------------------------------------------------------- */

typedef struct barrier {
  const double (*target)[3]; /* tau per element */
  const double *scale;       /* weight per element */
  double epsilon, theta, shape, angle;
  int power;
} barrier;

static double integer_power(double x, int n) {
  double y = 1.0;
  for (; n > 0; n >>= 1, x *= x)
    if (n & 1)
      y *= x;
  return y;
}

/* Energy of one point and its gradient in F (columns f[a], rows of 3). */
static double point_energy(const barrier *b, double f[3][3], double g[3][3]) {
  double cofactor[3][3], length2[3];
  for (int a = 0; a < 3; a++) {
    const double *u = f[(a + 1) % 3], *v = f[(a + 2) % 3];
    cofactor[a][0] = u[1] * v[2] - u[2] * v[1];
    cofactor[a][1] = u[2] * v[0] - u[0] * v[2];
    cofactor[a][2] = u[0] * v[1] - u[1] * v[0];
    length2[a] = f[a][0] * f[a][0] + f[a][1] * f[a][1] + f[a][2] * f[a][2];
  }
  double d = f[0][0] * cofactor[0][0] + f[0][1] * cofactor[0][1] + f[0][2] * cofactor[0][2];
  double root = sqrt(b->epsilon * b->epsilon + d * d);
  double chi = d >= 0.0 ? 0.5 * (d + root) : 0.5 * b->epsilon * b->epsilon / (root - d);
  chi = fmax(chi, 1e-300);
  double slope = chi / root; /* d chi / d D */
  double trace = length2[0] + length2[1] + length2[2], third = cbrt(chi);
  double shape = b->shape * trace / (3.0 * third * third);
  double size = b->shape * b->theta * (d * d + 1.0) / chi;
  double lengths = sqrt(length2[0] * length2[1] * length2[2]);
  double angle = b->angle * integer_power(lengths / chi, b->power);
  double by_chi = -(2.0 / 3.0 * shape + size + b->power * angle) / chi;
  double by_d = by_chi * slope + 2.0 * b->shape * b->theta * d / chi;
  for (int a = 0; a < 3; a++) {
    double by_f =
        2.0 * b->shape / (3.0 * third * third) + b->power * angle / fmax(length2[a], 1e-300);
    for (int c = 0; c < 3; c++)
      g[a][c] = by_f * f[a][c] + by_d * cofactor[a][c];
  }
  return shape + size + angle;
}

static void barrier_density(const void *data, int element, int n, int stride, const double *weight,
                            const double *j, double *energy, double *g) {
  const barrier *b = data;
  const double *tau = b->target[element];
  double sum = 0.0, inverse[3] = {1.0 / tau[0], 1.0 / tau[1], 1.0 / tau[2]};
  for (int q = 0; q < n; q++) {
    double f[3][3], df[3][3], w = weight[q] * b->scale[element];
    for (int c = 0; c < 3; c++)
      for (int a = 0; a < 3; a++)
        f[a][c] = j[(ptrdiff_t)(3 * c + a) * stride + q] * inverse[a];
    sum += w * point_energy(b, f, df);
    for (int c = 0; c < 3; c++)
      for (int a = 0; a < 3; a++)
        g[(ptrdiff_t)(3 * c + a) * stride + q] = w * df[a][c] * inverse[a];
  }
  *energy += sum;
}

/* "Energy" of an element: its smallest scaled Jacobian. */
static void worst_density(const void *data, int element, int n, int stride, const double *weight,
                          const double *j, double *energy, double *g) {
  double worst = INFINITY;
  (void)data, (void)element, (void)weight, (void)g;
  for (int q = 0; q < n; q++) {
    double f[9];
    for (int i = 0; i < 9; i++)
      f[i] = j[(ptrdiff_t)i * stride + q];
    double d = f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6]) +
               f[2] * (f[3] * f[7] - f[4] * f[6]);
    double lengths = 1.0;
    for (int a = 0; a < 3; a++)
      lengths *= sqrt(f[a] * f[a] + f[3 + a] * f[3 + a] + f[6 + a] * f[6 + a]);
    worst = fmin(worst, lengths > 0.0 ? d / lengths : 0.0);
  }
  *energy = worst;
}

/* ---- state
 * -------------------------------------------------------------------------------------------------
 */

typedef struct optimiser {
  tsolid_context *context;
  const tsolid_space *space;
  int n_free;
  tsi_kernel *inside; /* Gauss-Lobatto points */
  tsi_kernel *grid;   /* 7^3 points */
  double *position, *best, *gradient, *element_worst, *diagonal;
  double (*target)[3];
  double *scale;
  unsigned char *active; /* elements that count now */
  double best_worst;
  barrier barrier;
  tsolid_status status;
  int evaluations;
  double fraction;
} optimiser;

static void length_density(const void *data, int element, int n, int stride, const double *weight,
                           const double *j, double *energy, double *g) {
  (void)energy, (void)g;
  double(*mean)[3] = ((optimiser *)(uintptr_t)data)->target;
  for (int a = 0; a < 3; a++) {
    double sum = 0.0;
    for (int q = 0; q < n; q++) {
      double x = j[(ptrdiff_t)a * stride + q], y = j[(ptrdiff_t)(3 + a) * stride + q],
             z = j[(ptrdiff_t)(6 + a) * stride + q];
      sum += weight[q] * sqrt(x * x + y * y + z * z);
    }
    mean[element][a] = sum;
  }
}

/* tau: mean physical length per direction and block, times the element's share of the block. */
static void choose_targets(optimiser *o) {
  double energy, length[7][3] = {{0}}, extent[7] = {0};
  tsi_kernel_energy(o->inside, o->position, length_density, o, NULL, &energy, NULL, NULL);
  for (int e = 0; e < o->space->n_elements; e++) {
    const tsi_element *el = &o->space->element[e];
    double h[3] = {el->box[3] - el->box[0], el->box[4] - el->box[1], el->box[5] - el->box[2]};
    double volume = h[0] * h[1] * h[2];
    extent[el->block] += volume;
    for (int a = 0; a < 3; a++)
      length[el->block][a] += volume * o->target[e][a] / h[a];
  }
  double total = 0.0;
  for (int e = 0; e < o->space->n_elements; e++) {
    const tsi_element *el = &o->space->element[e];
    o->scale[e] = 1.0;
    for (int a = 0; a < 3; a++) {
      o->target[e][a] = length[el->block][a] / extent[el->block] * (el->box[a + 3] - el->box[a]);
      o->scale[e] *= o->target[e][a];
    }
    total += o->scale[e];
  }
  for (int e = 0; e < o->space->n_elements; e++)
    o->scale[e] /= total;
}

static double worst_of(optimiser *o, const double *position) {
  double energy, worst = INFINITY;
  tsi_kernel_energy(o->grid, position, worst_density, o, NULL, &energy, NULL, o->element_worst);
  for (int e = 0; e < o->space->n_elements; e++)
    worst = fmin(worst, o->element_worst[e]);
  return worst;
}

static lbfgsfloatval_t evaluate(void *data, const lbfgsfloatval_t *x, lbfgsfloatval_t *g,
                                const int n, const lbfgsfloatval_t step) {
  optimiser *o = data;
  double energy;
  (void)step;
  for (int i = 0; i < n; i++)
    o->position[i] = x[i] * o->diagonal[i / 3];
  tsi_kernel_energy(o->inside, o->position, barrier_density, &o->barrier, o->active, &energy, g,
                    NULL);
  for (int i = 0; i < n; i++)
    g[i] *= o->diagonal[i / 3];
  o->evaluations++;
  return energy;
}

static int progress(void *data, const lbfgsfloatval_t *x, const lbfgsfloatval_t *g,
                    const lbfgsfloatval_t fx, const lbfgsfloatval_t xnorm,
                    const lbfgsfloatval_t gnorm, const lbfgsfloatval_t step, int n, int k, int ls) {
  optimiser *o = data;
  (void)x, (void)g, (void)fx, (void)xnorm, (void)gnorm, (void)step, (void)n, (void)k, (void)ls;
  o->status = tsi_progress(o->context, STAGE, o->fraction);
  return o->status != TSOLID_OK;
}

/* Minimises the barrier from o->position, at most max_steps; leaves the result there. */
static tsolid_status descend(optimiser *o, int max_steps) {
  int n = 3 * o->n_free;
  lbfgs_parameter_t parameter;
  lbfgs_parameter_init(&parameter);
  parameter.m = HISTORY;
  parameter.max_iterations = max_steps;
  parameter.max_linesearch = 30;
  parameter.epsilon = 1e-9;
  parameter.past = 5; /* stop when five steps gain less than delta */
  parameter.delta = 1e-4;
  lbfgsfloatval_t *x = lbfgs_malloc(n), fx;
  if (!x)
    return tsi_no_memory(o->context, STAGE);
  for (int i = 0; i < n; i++)
    x[i] = o->position[i] / o->diagonal[i / 3];
  int rc = lbfgs(n, x, &fx, evaluate, progress, o, &parameter);
  (void)rc; /* whatever the reason to stop, the last point is the best so far */
  for (int i = 0; i < n; i++)
    o->position[i] = x[i] * o->diagonal[i / 3];
  lbfgs_free(x);
  return o->status;
}

/* Keeps the position when its worst scaled Jacobian is the best so far. */
static void keep_best(optimiser *o) {
  double worst = worst_of(o, o->position);
  if (!(worst > o->best_worst))
    return;
  o->best_worst = worst;
  memcpy(o->best, o->position, 3 * (size_t)o->n_free * sizeof *o->best);
}

/* Shape energy with a falling epsilon until every sampled det J is positive. */
static tsolid_status untangle(optimiser *o) {
  tsolid_status status = TSOLID_OK;
  double epsilon = o->best_worst > 0.0 ? 0.01 : FIRST_EPSILON;
  o->barrier = (barrier){.target = (const double(*)[3])o->target,
                         .scale = o->scale,
                         .theta = THETA,
                         .shape = 1.0,
                         .power = 1};
  for (int round = 0; round < UNTANGLE_ROUNDS && status == TSOLID_OK; round++) {
    o->fraction = 0.5 * round / UNTANGLE_ROUNDS;
    o->barrier.epsilon = epsilon;
    status = descend(o, UNTANGLE_STEPS);
    keep_best(o);
    if (o->best_worst > 0.0)
      break;
    epsilon = fmax(epsilon * EPSILON_FALL, LAST_EPSILON);
  }
  return status;
}

/* Leaves out elements whose energy cannot matter: their dofs rest unless a bad element moves them.
 */
static void choose_active(optimiser *o, int power) {
  double limit = INFINITY;
  if (power > ALL_UP_TO)
    limit = fmax(o->best_worst, 0.0) * pow(NEGLIGIBLE, -1.0 / power);
  (void)worst_of(o, o->position);
  for (int e = 0; e < o->space->n_elements; e++)
    o->active[e] = !(o->element_worst[e] > limit);
}

/* Ever higher powers of the inverse scaled Jacobian, every element with the same weight. The first
 * power also evens out what untangling left; the others start from the best so far. */
static tsolid_status raise_worst(optimiser *o, int effort, double bound) {
  tsolid_status status = TSOLID_OK;
  for (int e = 0; e < o->space->n_elements; e++)
    o->scale[e] = 1.0 / o->space->n_elements;
  o->barrier.epsilon = 1e-3;
  o->barrier.shape = SHAPE_KEPT;
  for (int power = 1; power <= MAX_POWER && status == TSOLID_OK; power *= 2) {
    if (power > 1 && o->best_worst >= EFFORT[effort].goal * bound)
      break;
    o->fraction = fmin(o->fraction + 0.08, 0.95);
    choose_active(o, power);
    o->barrier.power = power;
    o->barrier.angle = integer_power(fmax(o->best_worst, 0.01), power);
    status = descend(o, EFFORT[effort].steps);
    keep_best(o);
  }
  return status;
}

/* ---- driver
 * --------------------------------------------------------------------------------------------------
 */

static tsolid_status prepare(optimiser *o, const tsolid_solid *start, tsi_arena *arena,
                             double centre[3]) {
  const tsolid_space *space = o->space;
  size_t n_free = (size_t)o->n_free, n_elements = (size_t)space->n_elements;
  o->position = tsi_arena_new(arena, n_free + (size_t)space->n_surface, 3 * sizeof(double));
  o->best = tsi_arena_new(arena, n_free, 3 * sizeof(double));
  o->target = tsi_arena_new(arena, n_elements, sizeof *o->target);
  o->scale = tsi_arena_new(arena, n_elements, sizeof(double));
  o->element_worst = tsi_arena_new(arena, n_elements, sizeof(double));
  o->diagonal = tsi_arena_new(arena, n_free, sizeof(double));
  o->active = tsi_arena_new(arena, n_elements, 1);
  double(*factor)[3] = tsi_arena_new(arena, n_elements, sizeof *factor);
  if (!o->position || !o->best || !o->target || !o->scale || !o->element_worst || !o->diagonal ||
      !o->active || !factor)
    return tsi_no_memory(o->context, STAGE);
  tsi_boundary_positions(space, o->position + 3 * n_free, centre);
  for (size_t f = 0; f < n_free; f++)
    for (size_t c = 0; c < 3; c++)
      o->position[3 * f + c] = start->control[4 * f + c] / start->control[4 * f + 3] - centre[c];
  tsolid_status status =
      tsi_kernel_create(o->context, space, start->control, TSI_LOBATTO, &o->inside);
  if (status == TSOLID_OK)
    status = tsi_kernel_create(o->context, space, start->control, TSI_GRID, &o->grid);
  if (status != TSOLID_OK)
    return status;
  memset(o->active, 1, n_elements);
  choose_targets(o);
  for (size_t e = 0; e < n_elements; e++)
    for (int a = 0; a < 3; a++)
      factor[e][a] = o->scale[e] / (o->target[e][a] * o->target[e][a]);
  if (!tsi_stiffness_diagonal(space, &o->context->allocator, start->control,
                              (const double(*)[3])factor, o->diagonal))
    return tsi_no_memory(o->context, STAGE);
  for (size_t f = 0; f < n_free; f++)
    o->diagonal[f] = 1.0 / sqrt(o->diagonal[f]);
  o->best_worst = -INFINITY;
  keep_best(o);
  return TSOLID_OK;
}

static tsolid_status finish(optimiser *o, const tsolid_solid *start, double start_worst,
                            const double centre[3], tsi_arena *arena, tsolid_solid **solid) {
  size_t n_free = (size_t)o->n_free, n = n_free + (size_t)o->space->n_surface;
  double *control = tsi_arena_new(arena, n, 4 * sizeof *control);
  if (!control)
    return tsi_no_memory(o->context, STAGE);
  memcpy(control, start->control, 4 * n * sizeof *control);
  for (size_t f = 0; f < n_free; f++)
    for (size_t c = 0; c < 3; c++)
      control[4 * f + c] = control[4 * f + 3] * (o->best[3 * f + c] + centre[c]);
  return tsi_solid_new(o->context, o->space, control, start_worst, solid);
}

tsolid_status tsolid_solid_optimise(tsolid_context *context, const tsolid_solid *start,
                                    const tsolid_solid_options *options, tsolid_solid **solid) {
  if (!context || !start || !solid)
    return TSOLID_ERROR_ARGUMENT;
  *solid = NULL;
  int effort = options ? options->effort : 0;
  if (effort < 0 || effort > 3)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, STAGE, "Effort must be 0 to 3, not %d", effort);
  tsi_arena arena = tsi_arena_create(context);
  optimiser o = {.context = context,
                 .space = start->space,
                 .n_free = start->space->n_inner + start->space->n_surface};
  double centre[3], bound, bound_point[3];
  tsolid_status status = tsi_boundary_bound(context, start->space->boundary, &bound, bound_point);
  if (status == TSOLID_OK)
    status = prepare(&o, start, &arena, centre);
  double start_worst = o.best_worst;
  if (status == TSOLID_OK && effort != 1)
    status = untangle(&o);
  if (status == TSOLID_OK && effort != 1)
    status = raise_worst(&o, effort, bound);
  if (status == TSOLID_OK)
    status = finish(&o, start, start_worst, centre, &arena, solid);
  tsi_kernel_free(o.inside);
  tsi_kernel_free(o.grid);
  tsi_arena_free(&arena);
  return status;
}
