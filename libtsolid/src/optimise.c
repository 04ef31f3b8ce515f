/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Untangling and quality: inner control points that make det J positive, then raise its worst
 * place.
 *
 * With F = J diag(1/tau), tau the element's own target lengths (the mean physical length of its
 * block per direction times its share: plates of 1:100 are ordinary parts), D = det F and
 *   chi(D) = (D + sqrt(eps^2 + D^2)) / 2,
 * the density is a sum of
 *   shape   ((|F|^2 / 3)^(3/2) + theta (D^2 + 1)) / chi
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

enum {
  HISTORY = 12,
  UNTANGLE_ROUNDS = 12,
  UNTANGLE_STEPS = 30,
  FIRST_POWER = 2,
  MAX_POWER = 32,
  PROOF_ROUNDS = 4,
  PROOF_DEPTH = 6
};

static const double THETA = 0.1;       /* weight of size against shape while untangling */
static const double SHAPE_KEPT = 0.01; /* what stays of shape while the worst place is raised */
static const double FIRST_EPSILON = 0.3, EPSILON_FALL = 0.3, LAST_EPSILON = 1e-4;

/* What an effort aims at: when the worst place is that share of the input's own bound it is good
 * enough; steps per power. */
static const struct {
  double goal;
  int steps;
} EFFORT[4] = {{0.9, 40}, {0.0, 0}, {0.5, 20}, {0.98, 120}};

/* ---- densities
 * ------------------------------------------------------------------------------------------- */

/* Corners where det J = 0 whatever the inside are left out of energies and of the worst place:
 * there both are round-off. */
typedef struct sampling {
  const tsi_kernel *kernel;
  const int *singular; /* per element: bits of its corners */
} sampling;

static int is_left_out(const sampling *s, int element, int point) {
  int n[3], corner = 0;
  if (!s->singular[element])
    return 0;
  tsi_kernel_points(s->kernel, element, n);
  for (int a = 0; a < 3; a++) {
    int i = point % n[a];
    if (i > 0 && i < n[a] - 1)
      return 0;
    corner |= (i > 0) << a;
    point /= n[a];
  }
  return s->singular[element] >> corner & 1;
}

typedef struct barrier {
  sampling points;
  const double (*target)[3]; /* tau per element */
  const double *scale;       /* weight per element */
  double epsilon, theta, shape, angle;
  int power;
} barrier;

/* Keeps quotients finite where an edge or chi is zero. */
static const double TINY = 1e-150, HUGE_RATIO = 1e9;

static double integer_power(double x, int n) {
  double y = 1.0;
  for (; n > 0; n >>= 1, x *= x)
    if (n & 1)
      y *= x;
  return y;
}

enum { BATCH = 64 };

/* h^power per point. */
static void raise_to_power(int n, int power, const double *h, double *out) {
  double base[BATCH];
  for (int q = 0; q < n; q++) {
    base[q] = h[q];
    out[q] = 1.0;
  }
  for (; power > 0; power >>= 1)
    for (int q = 0; q < n; q++) {
      if (power & 1)
        out[q] *= base[q];
      base[q] *= base[q];
    }
}

/* One batch of n <= BATCH points: f[3a + c] = F_ca, replaced by d energy / d F; returns the sum of
 * weight * energy. Loops over points are kept plain so that they vectorise. */
static double batch_energy(const barrier *b, int n, const double *weight, double f[9][BATCH]) {
  double cofactor[9][BATCH], length2[3][BATCH], d[BATCH], chi[BATCH], h[BATCH], angle[BATCH];
  double shape[BATCH], by_d[BATCH], by_shape[BATCH], eps2 = b->epsilon * b->epsilon, sum = 0.0;
  for (int a = 0; a < 3; a++)
    for (int c = 0; c < 3; c++) {
      const double *u1 = f[3 * ((a + 1) % 3) + (c + 1) % 3],
                   *v2 = f[3 * ((a + 2) % 3) + (c + 2) % 3];
      const double *u2 = f[3 * ((a + 1) % 3) + (c + 2) % 3],
                   *v1 = f[3 * ((a + 2) % 3) + (c + 1) % 3];
      for (int q = 0; q < n; q++)
        cofactor[3 * a + c][q] = u1[q] * v2[q] - u2[q] * v1[q];
    }
  for (int a = 0; a < 3; a++)
    for (int q = 0; q < n; q++)
      length2[a][q] = f[3 * a][q] * f[3 * a][q] + f[3 * a + 1][q] * f[3 * a + 1][q] +
                      f[3 * a + 2][q] * f[3 * a + 2][q] + TINY;
  for (int q = 0; q < n; q++) {
    d[q] = f[0][q] * cofactor[0][q] + f[1][q] * cofactor[1][q] + f[2][q] * cofactor[2][q];
    double root = sqrt(eps2 + d[q] * d[q]), size = d[q] < 0.0 ? -d[q] : d[q];
    double small = 0.5 * eps2 / (root + size), large = 0.5 * (root + size);
    chi[q] = (d[q] < 0.0 ? small : large) + TINY;
    h[q] = sqrt(length2[0][q] * length2[1][q] * length2[2][q]) / chi[q];
    double mean = (length2[0][q] + length2[1][q] + length2[2][q]) / 3.0, edge = sqrt(mean);
    double volume = b->theta * (d[q] * d[q] + 1.0);
    by_shape[q] = b->shape * edge / chi[q];
    shape[q] = b->shape * (mean * edge + volume) / chi[q];
    by_d[q] = (2.0 * b->shape * b->theta * d[q] - shape[q] * chi[q] / root) / chi[q];
    h[q] = h[q] < HUGE_RATIO ? h[q] : HUGE_RATIO;
    d[q] = 1.0 / root; /* d chi / d D = chi / root */
  }
  raise_to_power(n, b->power, h, angle);
  for (int q = 0; q < n; q++) {
    angle[q] *= b->angle;
    sum += weight[q] * (shape[q] + angle[q]);
    by_d[q] -= b->power * angle[q] * d[q];
  }
  for (int i = 0; i < 9; i++)
    for (int q = 0; q < n; q++)
      f[i][q] = weight[q] * ((by_shape[q] + b->power * angle[q] / length2[i / 3][q]) * f[i][q] +
                             by_d[q] * cofactor[i][q]);
  return sum;
}

static void barrier_density(const void *data, int element, int n, int stride, const double *weight,
                            const double *j, double *energy, double *g) {
  const barrier *b = data;
  const double *tau = b->target[element];
  double f[9][BATCH], w[BATCH];
  for (int first = 0; first < n; first += BATCH) {
    int m = n - first < BATCH ? n - first : BATCH;
    for (int q = 0; q < m; q++)
      w[q] =
          is_left_out(&b->points, element, first + q) ? 0.0 : weight[first + q] * b->scale[element];
    for (int i = 0; i < 9; i++)
      for (int q = 0; q < m; q++)
        f[i][q] = j[(ptrdiff_t)(3 * (i % 3) + i / 3) * stride + first + q] / tau[i / 3];
    *energy += batch_energy(b, m, w, f);
    for (int i = 0; i < 9; i++)
      for (int q = 0; q < m; q++)
        g[(ptrdiff_t)(3 * (i % 3) + i / 3) * stride + first + q] = f[i][q] / tau[i / 3];
  }
}

/* "Energy" of an element: its smallest scaled Jacobian. */
static void worst_density(const void *data, int element, int n, int stride, const double *weight,
                          const double *j, double *energy, double *g) {
  double worst = INFINITY;
  (void)weight, (void)g;
  for (int q = 0; q < n; q++) {
    double f[9];
    if (is_left_out(data, element, q))
      continue;
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
  int *singular; /* per element: bits of its corners where det J = 0 */
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
  const sampling points = {o->grid, o->singular};
  tsi_kernel_energy(o->grid, position, worst_density, &points, NULL, &energy, NULL,
                    o->element_worst);
  for (int e = 0; e < o->space->n_elements; e++)
    worst = fmin(worst, o->element_worst[e]);
  return worst;
}

static lbfgsfloatval_t evaluate(void *data, const lbfgsfloatval_t *x, lbfgsfloatval_t *g,
                                const int n, const lbfgsfloatval_t step) {
  optimiser *o = data;
  double energy;
  (void)step;
  o->barrier.points = (sampling){o->inside, o->singular};
  for (int i = 0; i < n; i++)
    o->position[i] = x[i] * o->diagonal[i / 3];
  tsi_kernel_energy(o->inside, o->position, barrier_density, &o->barrier, NULL, &energy, g, NULL);
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
  parameter.delta = 1e-3;
  lbfgsfloatval_t *x = lbfgs_malloc(n), fx;
  if (!x)
    return tsi_no_memory(o->context, STAGE);
  for (int i = 0; i < n; i++)
    x[i] = o->position[i] / o->diagonal[i / 3];
  int rc = lbfgs(n, x, &fx, evaluate, progress, o, &parameter);
  if (rc == LBFGSERR_OUTOFMEMORY) /* else: whatever the reason to stop, the last point is good */
    o->status = tsi_no_memory(o->context, STAGE);
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

/* The power of the inverse scaled Jacobian alone, every element with its own weight. */
static tsolid_status raise_power(optimiser *o, int power, int steps) {
  o->barrier.epsilon = 1e-3;
  o->barrier.shape = SHAPE_KEPT;
  o->barrier.power = power;
  o->barrier.angle = integer_power(fmax(o->best_worst, 0.01), power);
  tsolid_status status = descend(o, steps);
  keep_best(o);
  return status;
}

/* Ever higher powers until the worst place is near the input's own bound. */
static tsolid_status raise_worst(optimiser *o, int effort, double bound) {
  tsolid_status status = TSOLID_OK;
  for (int e = 0; e < o->space->n_elements; e++)
    o->scale[e] = 1.0 / o->space->n_elements;
  for (int power = FIRST_POWER; power <= MAX_POWER && status == TSOLID_OK; power *= 2) {
    o->fraction = fmin(o->fraction + 0.08, 0.9);
    status = raise_power(o, power, EFFORT[effort].steps);
    if (o->best_worst >= EFFORT[effort].goal * bound)
      break;
  }
  return status;
}

/* ---- driver
 * --------------------------------------------------------------------------------------------------
 */

static void find_singular(optimiser *o) {
  tsi_corner corner[8];
  for (int c = 0; c < 8; c++)
    tsi_corner_measure(o->space->boundary, c, &corner[c]);
  for (int e = 0; e < o->space->n_elements; e++)
    o->singular[e] = tsi_singular_corners(o->space, corner, e);
}

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
  o->singular = tsi_arena_new(arena, n_elements, sizeof(int));
  double(*factor)[3] = tsi_arena_new(arena, n_elements, sizeof *factor);
  if (!o->position || !o->best || !o->target || !o->scale || !o->element_worst || !o->diagonal ||
      !o->singular || !factor)
    return tsi_no_memory(o->context, STAGE);
  find_singular(o);
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

/* The solid of the best position. */
static tsolid_status finish(optimiser *o, const tsolid_solid *start, double start_worst,
                            const double centre[3], tsolid_solid **solid) {
  size_t n_free = (size_t)o->n_free, n = n_free + (size_t)o->space->n_surface;
  double *control = tsi_new(&o->context->allocator, n, 4 * sizeof *control);
  if (!control)
    return tsi_no_memory(o->context, STAGE);
  memcpy(control, start->control, 4 * n * sizeof *control);
  for (size_t f = 0; f < n_free; f++)
    for (size_t c = 0; c < 3; c++)
      control[4 * f + c] = control[4 * f + 3] * (o->best[3 * f + c] + centre[c]);
  tsolid_status status = tsi_solid_new(o->context, o->space, control, start_worst, solid);
  tsi_delete(&o->context->allocator, control);
  return status;
}

/* Certifies without a word: the caller's own call will tell. */
static tsolid_status certify_quietly(optimiser *o, const tsolid_solid *solid, int max_depth,
                                     int *verdict, int *proved) {
  const tsolid_certificate_options options = {.max_depth = max_depth};
  tsolid_certificate certificate;
  int n_findings = o->context->n_findings;
  tsolid_status status = tsolid_certify(o->context, solid, &options, &certificate, verdict);
  if (status == TSOLID_OK)
    tsi_findings_truncate(o->context, n_findings);
  *proved = status == TSOLID_OK && certificate.verdict == TSOLID_POSITIVE;
  return status;
}

/* A proof is not given up: when only the start can be proved positive, it stays. */
static tsolid_status prefer_proved_start(optimiser *o, const tsolid_solid *start,
                                         double start_worst, tsolid_solid **solid) {
  int start_proved, proved;
  tsolid_status status = certify_quietly(o, start, PROOF_DEPTH, NULL, &start_proved);
  if (status != TSOLID_OK || !start_proved)
    return status;
  status = certify_quietly(o, *solid, 2 * PROOF_DEPTH, NULL, &proved);
  if (status != TSOLID_OK || proved)
    return status;
  tsolid_solid_free(*solid);
  return tsi_solid_new(o->context, o->space, start->control, start_worst, solid);
}

/* What the next position must exceed: a proof may cost some of what was gained, but what is
 * positive stays positive, and a positive start is never undercut. */
static double least_worst(const optimiser *o, double start_worst) {
  return start_worst > 0.0 ? start_worst : o->best_worst >= 0.0 ? 0.0 : -INFINITY;
}

/* Stops with the certificate: while elements are not proved positive, looks at more points of them
 * with more weight. */
static tsolid_status prove(optimiser *o, const tsolid_solid *start, double start_worst,
                           const double centre[3], int effort, tsolid_solid **solid) {
  int *verdict = tsi_new(&o->context->allocator, (size_t)o->space->n_elements, sizeof *verdict);
  int proved = effort == 1; /* the start only: nothing to prove */
  tsolid_status status = verdict ? TSOLID_OK : tsi_no_memory(o->context, STAGE);
  for (int round = 0; status == TSOLID_OK; round++) {
    status = finish(o, start, start_worst, centre, solid);
    if (status == TSOLID_OK && !proved)
      status = certify_quietly(o, *solid, PROOF_DEPTH, verdict, &proved);
    if (status != TSOLID_OK || proved || round == PROOF_ROUNDS)
      break;
    if (o->inside != o->grid)
      tsi_kernel_free(o->inside);
    o->inside = o->grid; /* from now on at the points of the grid */
    for (int e = 0; e < o->space->n_elements; e++)
      if (verdict[e] != TSOLID_POSITIVE)
        o->scale[e] *= 8.0;
    memcpy(o->position, o->best, 3 * (size_t)o->n_free * sizeof *o->best);
    o->best_worst = least_worst(o, start_worst);
    status = raise_power(o, FIRST_POWER << round, EFFORT[effort].steps);
    tsolid_solid_free(*solid);
    *solid = NULL;
  }
  if (status == TSOLID_OK && !proved)
    status = prefer_proved_start(o, start, start_worst, solid);
  tsi_delete(&o->context->allocator, verdict);
  if (status != TSOLID_OK) {
    tsolid_solid_free(*solid);
    *solid = NULL;
  }
  return status;
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
    status = prove(&o, start, start_worst, centre, effort, solid);
  if (o.inside != o.grid)
    tsi_kernel_free(o.inside);
  tsi_kernel_free(o.grid);
  tsi_arena_free(&arena);
  return status;
}
