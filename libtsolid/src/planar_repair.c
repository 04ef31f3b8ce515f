/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Control points inside a planar patch, moved until it does not fold and its angles are good.
 *
 * With F = (x_u / tau_u, x_v / tau_v), tau the mean speeds of the two borders along the span, D =
 * det F and
 *
 *     chi(D) = (D + sqrt(eps^2 + D^2)) / 2,
 *
 * the density is, as in optimise.c one dimension higher, a sum of
 *
 *     shape   (|F|^2 / 2 + theta (D^2 + 1)) / chi
 *     angle   (|F_0| |F_1| / chi)^p, the p-th power of the inverse scaled Jacobian,
 *
 * finite where the patch is folded for eps > 0 and a barrier at D -> 0+ for eps -> 0. First shape
 * with falling eps until D > 0 at all points, then angle with rising p. Weights and borders stay.
 *
 * Each descent (L-BFGS) goes from coarse to fine: x_ij = x0_ij + sum_kl B_k(xi_i) B_l(eta_j) d_kl
 * with cubic B-splines B over a coarse uniform grid that vanish on the border, xi and eta the
 * Greville points; then all points by themselves. Folds as large as the face are undone in a few
 * coarse steps that way, whatever the number of control points.
 *
 * At corners where the borders are tangent D = 0 whatever is done: these points are left out, and
 * the angle term in their spans.
 *
 * Source: Garanzha et al. (2021), Foldover-free maps in 50 lines of code, section 3, for the
 * regularisation; the rest is ours. */
#include <lbfgs.h>

#include "bspline.h"
#include "planar_grid.h"
#include "planar_repair.h"

enum {
  HISTORY = 10,
  UNTANGLE_ROUNDS = 10,
  UNTANGLE_STEPS = 40,
  POWER_STEPS = 25,
  FIRST_POWER = 2,
  MAX_POWER = 16,
  COARSEST = 6, /* unknowns per direction; doubled from level to level */
  FINEST = 24,
  ALL_POINTS = 1 << 20,
  FINE = 14, /* up to so many points inside, there is but one level */
  MANY_SPANS = 24,
  QUALITY_POINTS = 5
};

static const double THETA = 0.1;
static const double SHAPE_KEPT = 0.02;
static const double FIRST_EPSILON = 0.5, EPSILON_FALL = 0.3, LAST_EPSILON = 1e-4;
static const double TINY = 1e-150, LARGEST_RATIO = 1e9;
/* Where the borders are slow (a pole of their parameter), no target is smaller than this part of
 * the mean. */
static const double LEAST_TARGET = 1e-3;

/* ---- densities ---------------------------------------------------------------------------------
 */

typedef struct barrier {
  int singular; /* bits of the patch's corners 00, 10, 11, 01 */
  double epsilon, shape, angle;
  int power;
} barrier;

/* Bits of corners at the low and at the high end of row q of points, or of its span. */
static int row_corners(const tsi_grid *g, int q, int of_span) {
  int n = g->line[1].n_points, m = of_span ? g->line[1].m : 1;
  return (q < m ? 1 | 2 : 0) | (q >= n - m ? 4 | 8 : 0);
}

/* Whether point k of a row, or its span, is at a singular corner of the row's `corners`. */
static int is_singular(const tsi_grid *g, int corners, int k, int of_span) {
  int n = g->line[0].n_points, m = of_span ? g->line[0].m : 1;
  return (k < m && (corners & (1 | 8))) || (k >= n - m && (corners & (2 | 4)));
}

static double integer_power(double x, int n) {
  double y = 1.0;
  for (; n > 0; n >>= 1, x *= x)
    if (n & 1)
      y *= x;
  return y;
}

/* Energy of one point with f = F; f becomes the gradient by F. */
static double point_energy(const barrier *b, double angle_weight, double f[4]) {
  double d = f[0] * f[3] - f[1] * f[2];
  double a = f[0] * f[0] + f[1] * f[1] + TINY, c = f[2] * f[2] + f[3] * f[3] + TINY;
  double root = sqrt(b->epsilon * b->epsilon + d * d);
  double chi = d > 0.0 ? 0.5 * (d + root) : 0.5 * b->epsilon * b->epsilon / (root - d);
  chi = fmax(chi, TINY);
  double shape = (0.5 * (a + c) + THETA * (d * d + 1.0)) / chi, ratio = sqrt(a * c) / chi;
  double angle = 0.0, slope = 0.0;
  if (angle_weight > 0.0) {
    angle = angle_weight * integer_power(fmin(ratio, LARGEST_RATIO), b->power);
    slope = ratio < LARGEST_RATIO ? b->power * angle : 0.0;
  }
  double by_d = b->shape * (2.0 * THETA * d / chi - shape / root) - slope / root;
  double by_f0 = b->shape / chi + slope / a, by_f1 = b->shape / chi + slope / c;
  double g[4] = {by_f0 * f[0] + by_d * f[3], by_f0 * f[1] - by_d * f[2], by_f1 * f[2] - by_d * f[1],
                 by_f1 * f[3] + by_d * f[0]};
  memcpy(f, g, sizeof g);
  return b->shape * shape + angle;
}

static double barrier_density(void *data, const tsi_grid *g, int q, double *const d[4]) {
  const barrier *b = data;
  int at_point = b->singular & row_corners(g, q, 0), at_span = b->singular & row_corners(g, q, 1);
  double sum = 0.0, tau_v = g->line[1].target[q], weight_v = g->line[1].weight[q];
  for (int k = 0; k < g->line[0].n_points; k++) {
    double tau_u = g->line[0].target[k], weight = weight_v * g->line[0].weight[k];
    if (at_point && is_singular(g, at_point, k, 0)) {
      d[0][k] = d[1][k] = d[2][k] = d[3][k] = 0.0;
      continue;
    }
    double f[4] = {d[0][k] / tau_u, d[1][k] / tau_u, d[2][k] / tau_v, d[3][k] / tau_v};
    int spare = at_span && is_singular(g, at_span, k, 1);
    sum += weight * point_energy(b, spare ? 0.0 : b->angle, f);
    d[0][k] = weight * f[0] / tau_u;
    d[1][k] = weight * f[1] / tau_u;
    d[2][k] = weight * f[2] / tau_v;
    d[3][k] = weight * f[3] / tau_v;
  }
  return sum;
}

/* The smallest scaled Jacobian, of all points and of those not in spans at singular corners. */
typedef struct worst_place {
  int singular;
  double all, regular;
  double u[2][2]; /* of all, of regular */
} worst_place;

static double worst_density(void *data, const tsi_grid *g, int q, double *const d[4]) {
  worst_place *w = data;
  int at_point = w->singular & row_corners(g, q, 0), at_span = w->singular & row_corners(g, q, 1);
  for (int k = 0; k < g->line[0].n_points; k++) {
    double lengths = hypot(d[0][k], d[1][k]) * hypot(d[2][k], d[3][k]);
    double scaled = lengths > 0.0 ? (d[0][k] * d[3][k] - d[1][k] * d[2][k]) / lengths : 0.0;
    if (is_singular(g, at_point, k, 0))
      continue;
    if (!(scaled >= w->all)) {
      w->all = scaled;
      w->u[0][0] = g->line[0].u[k];
      w->u[0][1] = g->line[1].u[q];
    }
    if (!(scaled >= w->regular) && !is_singular(g, at_span, k, 1)) {
      w->regular = scaled;
      w->u[1][0] = g->line[0].u[k];
      w->u[1][1] = g->line[1].u[q];
    }
  }
  return 0.0;
}

/* Speeds along u on the first and last row of points, along v at the first and last of each row,
 * added to the targets. */
static double speed_density(void *data, const tsi_grid *g, int q, double *const d[4]) {
  int n_u = g->line[0].n_points, n_v = g->line[1].n_points;
  (void)data;
  for (int k = 0; (q == 0 || q == n_v - 1) && k < n_u; k++)
    g->line[0].target[k] += 0.5 * hypot(d[0][k], d[1][k]);
  g->line[1].target[q] = 0.5 * (hypot(d[2][0], d[3][0]) + hypot(d[2][n_u - 1], d[3][n_u - 1]));
  return 0.0;
}

/* ---- quality -----------------------------------------------------------------------------------
 */

/* At least two, and where there are many spans not many more. */
static int points_per_span(const tsi_planar *p, int wanted, int least) {
  int spans = p->n[0] - p->degree[0] > p->n[1] - p->degree[1] ? p->n[0] - p->degree[0]
                                                              : p->n[1] - p->degree[1];
  int most = spans > MANY_SPANS ? least : TSI_MAX_DEGREE + 5;
  return wanted < most ? wanted : most;
}

static tsi_planar_quality measure(tsi_grid *grid, const double *point, int singular) {
  worst_place w = {.singular = singular, .all = INFINITY, .regular = INFINITY};
  tsi_grid_sum(grid, point, worst_density, &w, NULL);
  int regular = w.all > 0.0 && isfinite(w.regular);
  tsi_planar_quality quality = {.worst = regular ? w.regular : w.all,
                                .u = {w.u[regular][0], w.u[regular][1]}};
  return quality;
}

static int quality_grid(tsi_arena *arena, const tsi_planar *patch, tsi_grid *grid) {
  int m = points_per_span(patch, QUALITY_POINTS, 3);
  return tsi_grid_create(arena, patch, m, m, grid);
}

tsolid_status tsi_planar_measure(tsolid_context *context, const tsi_planar *patch, int singular,
                                 tsi_planar_quality *quality) {
  tsi_arena arena = tsi_arena_create(context);
  tsi_grid grid;
  tsolid_status status = TSOLID_OK;
  if (quality_grid(&arena, patch, &grid))
    *quality = measure(&grid, patch->point, singular);
  else
    status = tsi_no_memory(context, TSI_COONS_STAGE);
  tsi_arena_free(&arena);
  return status;
}

/* ---- levels ------------------------------------------------------------------------------------
 */

/* The unknowns of one direction: x_i += sum_k b[i*n + k] d_k for the points 1 .. n_inside. */
typedef struct level {
  int n, n_inside;
  int identity;
  double *b;
} level;

/* n unknowns, or all points. */
static int make_level(tsi_arena *arena, const tsi_planar *p, int d, int n, level *l) {
  double knots[64], value[4];
  int n_inside = p->n[d] - 2;
  *l = (level){.n = n, .n_inside = n_inside, .identity = n_inside <= n || n == ALL_POINTS};
  if (l->identity) {
    l->n = l->n_inside;
    return 1;
  }
  l->b = tsi_arena_new(arena, (size_t)l->n_inside * (size_t)n, sizeof *l->b);
  if (!l->b)
    return 0;
  int functions = n + 2, spans = functions - 3;
  for (int i = 0; i < functions + 4; i++) {
    int k = i - 3;
    knots[i] = k <= 0 ? 0.0 : k >= spans ? 1.0 : (double)k / spans;
  }
  for (int i = 0; i < l->n_inside; i++) {
    int first =
        tsi_bspline_basis(3, functions, knots, tsi_planar_greville(p, d, i + 1), value, NULL);
    for (int k = 0; k < 4; k++)
      if (first + k >= 1 && first + k <= n)
        l->b[i * n + first + k - 1] = value[k];
  }
  return 1;
}

static double entry(const level *l, int i, int k) {
  return l->identity ? (double)(i == k) : l->b[i * l->n + k];
}

/* ---- descent -----------------------------------------------------------------------------------
 */

typedef struct repairer {
  tsolid_context *context;
  tsi_planar *patch;
  tsi_grid grid[2], fine; /* of the energy on coarse levels and on the last, of the quality */
  tsi_grid *now;          /* one of the two */
  barrier barrier;
  level level[2];
  double *start, *position, *gradient, *half, *best; /* rows of 2 */
  double scale;                                      /* of unknowns: the size of the face */
  double best_worst;
  tsolid_status status;
} repairer;

/* position = start + scale P d, or with `back` the transposed: d = scale P^T gradient. The half
 * step is over the rows inside and the unknowns along u. */
static void prolong(repairer *r, const double *d) {
  const level *a = &r->level[0], *b = &r->level[1];
  size_t n0 = (size_t)r->patch->n[0], count = 2 * n0 * (size_t)r->patch->n[1];
  memcpy(r->position, r->start, count * sizeof *r->position);
  for (int l = 0; l < b->n; l++)
    for (int i = 0; i < a->n_inside; i++)
      for (int c = 0; c < 2; c++) {
        double sum = 0.0;
        for (int k = 0; k < a->n && !a->identity; k++)
          sum += a->b[i * a->n + k] * d[2 * (k + a->n * l) + c];
        r->half[2 * (i + a->n_inside * l) + c] = a->identity ? d[2 * (i + a->n * l) + c] : sum;
      }
  for (int j = 0; j < b->n_inside; j++)
    for (int l = 0; l < b->n; l++) {
      double f = r->scale * entry(b, j, l);
      double *to = r->position + 2 * (1 + n0 * (size_t)(j + 1));
      for (int i = 0; f != 0.0 && i < 2 * a->n_inside; i++)
        to[i] += f * r->half[i + 2 * a->n_inside * l];
    }
}

static void restrict_gradient(repairer *r, double *d) {
  const level *a = &r->level[0], *b = &r->level[1];
  size_t n0 = (size_t)r->patch->n[0];
  memset(r->half, 0, 2 * (size_t)a->n_inside * (size_t)b->n * sizeof *r->half);
  for (int j = 0; j < b->n_inside; j++)
    for (int l = 0; l < b->n; l++) {
      double f = r->scale * entry(b, j, l);
      const double *from = r->gradient + 2 * (1 + n0 * (size_t)(j + 1));
      for (int i = 0; f != 0.0 && i < 2 * a->n_inside; i++)
        r->half[i + 2 * a->n_inside * l] += f * from[i];
    }
  memset(d, 0, 2 * (size_t)a->n * (size_t)b->n * sizeof *d);
  for (int l = 0; l < b->n; l++)
    for (int i = 0; i < a->n_inside; i++)
      for (int c = 0; c < 2; c++) {
        double value = r->half[2 * (i + a->n_inside * l) + c];
        if (a->identity)
          d[2 * (i + a->n * l) + c] = value;
        for (int k = 0; k < a->n && !a->identity; k++)
          d[2 * (k + a->n * l) + c] += a->b[i * a->n + k] * value;
      }
}

static lbfgsfloatval_t evaluate(void *data, const lbfgsfloatval_t *x, lbfgsfloatval_t *g,
                                const int n, const lbfgsfloatval_t step) {
  repairer *r = data;
  (void)n, (void)step;
  prolong(r, x);
  double energy = tsi_grid_sum(r->now, r->position, barrier_density, &r->barrier, r->gradient);
  restrict_gradient(r, g);
  return energy;
}

static int progress(void *data, const lbfgsfloatval_t *x, const lbfgsfloatval_t *g,
                    const lbfgsfloatval_t fx, const lbfgsfloatval_t xnorm,
                    const lbfgsfloatval_t gnorm, const lbfgsfloatval_t step, int n, int k, int ls) {
  repairer *r = data;
  (void)x, (void)g, (void)fx, (void)xnorm, (void)gnorm, (void)step, (void)n, (void)k, (void)ls;
  r->status = tsi_progress(r->context, TSI_COONS_STAGE, 0.5);
  return r->status != TSOLID_OK;
}

static size_t net_bytes(const repairer *r) {
  return 2 * (size_t)r->patch->n[0] * (size_t)r->patch->n[1] * sizeof(double);
}

/* From r->position, at most max_steps; leaves the result there. */
static tsolid_status descend_level(repairer *r, int max_steps) {
  int n = 2 * r->level[0].n * r->level[1].n;
  lbfgs_parameter_t parameter;
  lbfgs_parameter_init(&parameter);
  parameter.m = HISTORY;
  parameter.max_iterations = max_steps;
  parameter.max_linesearch = 30;
  parameter.epsilon = 1e-9;
  parameter.past = 5;
  parameter.delta = 1e-3;
  lbfgsfloatval_t *d = lbfgs_malloc(n), energy;
  if (!d)
    return tsi_no_memory(r->context, TSI_COONS_STAGE);
  memset(d, 0, (size_t)n * sizeof *d);
  memcpy(r->start, r->position, net_bytes(r));
  int rc = lbfgs(n, d, &energy, evaluate, progress, r, &parameter);
  if (rc == LBFGSERR_OUTOFMEMORY) /* else: whatever the reason to stop, the last point is good */
    r->status = tsi_no_memory(r->context, TSI_COONS_STAGE);
  prolong(r, d);
  lbfgs_free(d);
  return r->status;
}

static tsolid_status descend(repairer *r, int max_steps) {
  const tsi_planar *p = r->patch;
  int inside = (p->n[0] > p->n[1] ? p->n[0] : p->n[1]) - 2;
  for (int n = inside <= FINE ? ALL_POINTS : COARSEST;; n = n < FINEST ? 2 * n : ALL_POINTS) {
    tsi_arena arena = tsi_arena_create(r->context);
    tsolid_status status = TSOLID_OK;
    for (int d = 0; d < 2; d++)
      if (!make_level(&arena, p, d, n, &r->level[d]))
        status = tsi_no_memory(r->context, TSI_COONS_STAGE);
    r->now = &r->grid[n == ALL_POINTS];
    if (!status)
      status = descend_level(r, max_steps);
    tsi_arena_free(&arena);
    if (status || n == ALL_POINTS)
      return status;
  }
}

/* ---- driver ------------------------------------------------------------------------------------
 */

static void keep_best(repairer *r) {
  double worst = measure(&r->fine, r->position, r->barrier.singular).worst;
  if (!(worst > r->best_worst))
    return;
  r->best_worst = worst;
  memcpy(r->best, r->position, net_bytes(r));
}

static void choose_targets(const tsi_planar *patch, tsi_grid *grid) {
  tsi_grid_line *line = grid->line;
  tsi_grid_sum(grid, patch->point, speed_density, NULL, NULL);
  for (int d = 0; d < 2; d++) {
    double mean = 0.0;
    for (int q = 0; q < line[d].n_points; q += line[d].m) { /* one for each span */
      double length = 0.0;
      for (int k = 0; k < line[d].m; k++)
        length += line[d].weight[q + k] * line[d].n_spans * line[d].target[q + k];
      for (int k = 0; k < line[d].m; k++)
        line[d].target[q + k] = length;
      mean += length / line[d].n_spans;
    }
    for (int q = 0; q < line[d].n_points; q++)
      line[d].target[q] = fmax(line[d].target[q], LEAST_TARGET * mean);
  }
}

static tsolid_status prepare(repairer *r, tsi_arena *arena, int round) {
  const tsi_planar *p = r->patch;
  size_t n = (size_t)p->n[0] * (size_t)p->n[1];
  double **net[5] = {&r->start, &r->position, &r->gradient, &r->half, &r->best};
  for (int k = 0; k < 5; k++)
    if (!(*net[k] = tsi_arena_new(arena, n, 2 * sizeof(double))))
      return tsi_no_memory(r->context, TSI_COONS_STAGE);
  for (int k = 0; k < 2; k++) {
    int m[2];
    for (int d = 0; d < 2; d++)
      m[d] = points_per_span(p, p->degree[d] + 2 + round, 2 + k + round);
    if (!tsi_grid_create(arena, p, m[0], m[1], &r->grid[k]))
      return tsi_no_memory(r->context, TSI_COONS_STAGE);
    choose_targets(p, &r->grid[k]);
  }
  if (!quality_grid(arena, p, &r->fine))
    return tsi_no_memory(r->context, TSI_COONS_STAGE);
  for (size_t i = 0; i < 2 * n; i++)
    r->scale = fmax(r->scale, fabs(p->point[i]));
  memcpy(r->position, p->point, net_bytes(r));
  r->best_worst = -INFINITY;
  keep_best(r);
  return TSOLID_OK;
}

static tsolid_status untangle(repairer *r) {
  tsolid_status status = TSOLID_OK;
  r->barrier.epsilon = r->best_worst > 0.0 ? 0.01 : FIRST_EPSILON;
  r->barrier.shape = 1.0;
  r->barrier.angle = 0.0;
  for (int round = 0; round < UNTANGLE_ROUNDS && !status; round++) {
    status = descend(r, UNTANGLE_STEPS);
    keep_best(r);
    if (r->best_worst > 0.0)
      break;
    r->barrier.epsilon = fmax(r->barrier.epsilon * EPSILON_FALL, LAST_EPSILON);
  }
  return status;
}

static tsolid_status raise_worst(repairer *r, double goal) {
  tsolid_status status = TSOLID_OK;
  r->barrier.epsilon = 1e-3;
  r->barrier.shape = SHAPE_KEPT;
  for (int power = FIRST_POWER; power <= MAX_POWER && !status; power *= 2) {
    r->barrier.power = power;
    r->barrier.angle = integer_power(fmax(r->best_worst, 0.01), power);
    status = descend(r, POWER_STEPS);
    keep_best(r);
    if (r->best_worst >= goal)
      break;
  }
  return status;
}

tsolid_status tsi_planar_improve(tsolid_context *context, tsi_planar *patch, int singular,
                                 double goal, int round) {
  tsi_arena arena = tsi_arena_create(context);
  repairer r = {.context = context, .patch = patch, .barrier = {.singular = singular}};
  tsolid_status status = prepare(&r, &arena, round);
  if (!status)
    status = untangle(&r);
  if (!status && r.best_worst > 0.0)
    status = raise_worst(&r, goal);
  if (!status)
    memcpy(patch->point, r.best, net_bytes(&r));
  tsi_arena_free(&arena);
  return status;
}
