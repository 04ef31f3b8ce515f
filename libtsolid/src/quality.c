/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Scaled Jacobians det J / (|J_0| |J_1| |J_2|), sampled.
 *
 * Per Bezier element of degree q: (q_0+1)(q_1+1)(q_2+1) Gauss points and a 7^3 grid with the faces,
 * edges and corners on it. Worst and best are over all of these, the mean over the grids, each
 * element with the same weight: no volumes in it. Points are evaluated by sum factorisation, in
 * homogeneous coordinates from control points translated to the origin. The bound is the input's
 * own (boundary_bound.c) and, at the core corners, where four hexahedra of the core and the arms
 * share four edges, 4/(3 sqrt 3): the best that four directions in space allow. */
#ifdef _OPENMP
#include <omp.h>
#endif

#include "bernstein.h"
#include "boundary_bound.h"
#include "evaluate.h"
#include "quadrature.h"

static const char *const STAGE = "quality";

enum { CHUNK = 256, GRID = 7, N_FIELDS = 4, MAX_POINTS = TSI_MAX_ORDER };

/* Points per direction with the basis and its derivative there. */
typedef struct axis_rule {
  int n_points, n_basis;
  double x[MAX_POINTS];
  double basis[2][MAX_POINTS * TSI_MAX_ORDER];
} axis_rule;

/* Of one element, in its own [0,1]^3. */
typedef struct sample {
  double worst, best, sum;
  double worst_x[3];
} sample;

/* Arrays of one thread. */
typedef struct workspace {
  double *net, *line, *plane, *field;
} workspace;

typedef struct run {
  const tsolid_space *space;
  double *control, centre[3];
  axis_rule *grid, *gauss; /* by degree */
  workspace *work;
  int n_threads;
  sample *sample;
} run;

/* ---- points
 * --------------------------------------------------------------------------------------- */

static void make_rule(axis_rule *rule, int degree, int n_points, const double *x) {
  double value[2 * TSI_MAX_ORDER];
  rule->n_points = n_points;
  rule->n_basis = degree + 1;
  for (int i = 0; i < n_points; i++) {
    rule->x[i] = x[i];
    tsi_bernstein_derivatives(degree, x[i], 1, value);
    for (int d = 0; d < 2; d++)
      memcpy(rule->basis[d] + i * rule->n_basis, value + d * rule->n_basis,
             (size_t)rule->n_basis * sizeof *value);
  }
}

static void make_rules(run *r) {
  for (int degree = 1; degree <= TSI_MAX_DEGREE; degree++) {
    double x[MAX_POINTS], weight[MAX_POINTS];
    for (int i = 0; i < GRID; i++)
      x[i] = (double)i / (GRID - 1);
    make_rule(&r->grid[degree], degree, GRID, x);
    tsi_gauss(degree + 1, x, weight);
    make_rule(&r->gauss[degree], degree, degree + 1, x);
  }
}

/* to[o][i][k] = sum_j basis[d][i][j] from[o][j][k], rows k of `inner` doubles. */
static void contract(const axis_rule *rule, int d, int n_outer, int inner, const double *from,
                     double *restrict to) {
  const double *basis = rule->basis[d];
  for (int o = 0; o < n_outer; o++)
    for (int i = 0; i < rule->n_points; i++, to += inner) {
      for (int k = 0; k < inner; k++)
        to[k] = 0.0;
      for (int j = 0; j < rule->n_basis; j++) {
        const double *row = from + (ptrdiff_t)(o * rule->n_basis + j) * inner;
        double b = basis[i * rule->n_basis + j];
        for (int k = 0; k < inner; k++)
          to[k] += b * row[k];
      }
    }
}

/* field[f] = X, X_0, X_1, X_2 at all points of the tensor rule, rows of 4, u[0] fastest. */
static void evaluate(const workspace *w, const axis_rule *const rule[3], double *field[N_FIELDS]) {
  const axis_rule *a = rule[0], *b = rule[1], *c = rule[2];
  size_t n_line = (size_t)(4 * a->n_points) * (size_t)(b->n_basis * c->n_basis);
  size_t n_plane = (size_t)(4 * a->n_points * b->n_points) * (size_t)c->n_basis;
  double *line[2] = {w->line, w->line + n_line};
  double *plane[3] = {w->plane, w->plane + n_plane, w->plane + 2 * n_plane};
  int row = 4 * a->n_points, sheet = row * b->n_points;
  for (int d = 0; d < 2; d++)
    contract(a, d, b->n_basis * c->n_basis, 4, w->net, line[d]);
  contract(b, 0, c->n_basis, row, line[0], plane[0]);
  contract(b, 0, c->n_basis, row, line[1], plane[1]);
  contract(b, 1, c->n_basis, row, line[0], plane[2]);
  for (int f = 0; f < 3; f++)
    contract(c, 0, 1, sheet, plane[f], field[f]);
  contract(c, 1, 1, sheet, plane[0], field[3]);
}

/* Zero where a derivative is, and where numbers overflow: never a NaN. */
static double scaled_jacobian(const double *homogeneous) {
  double x[12], length = 1.0;
  tsi_project(1, homogeneous, x);
  for (int d = 1; d <= 3; d++) {
    const double *v = x + 3 * d;
    length *= sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  double value = tsi_det3(x + 3, x + 6, x + 9) / length;
  return isfinite(value) ? value : 0.0;
}

static double sample_rule(const workspace *w, const axis_rule *const rule[3], sample *s) {
  size_t n = (size_t)(rule[0]->n_points * rule[1]->n_points * rule[2]->n_points), k = 0;
  double *field[N_FIELDS], sum = 0.0;
  for (int f = 0; f < N_FIELDS; f++)
    field[f] = w->field + 4 * n * (size_t)f;
  evaluate(w, rule, field);
  for (int l = 0; l < rule[2]->n_points; l++)
    for (int j = 0; j < rule[1]->n_points; j++)
      for (int i = 0; i < rule[0]->n_points; i++, k++) {
        double h[4 * N_FIELDS];
        for (int f = 0; f < N_FIELDS; f++)
          memcpy(h + 4 * f, field[f] + 4 * k, 4 * sizeof *h);
        double value = scaled_jacobian(h);
        sum += value;
        s->best = value > s->best ? value : s->best;
        if (value >= s->worst)
          continue;
        s->worst = value;
        s->worst_x[0] = rule[0]->x[i];
        s->worst_x[1] = rule[1]->x[j];
        s->worst_x[2] = rule[2]->x[l];
      }
  return sum;
}

static void sample_element(const run *r, int element, int thread) {
  const tsi_element *e = &r->space->element[element];
  const workspace *w = &r->work[thread];
  sample *s = &r->sample[element];
  const axis_rule *grid[3], *gauss[3];
  for (int d = 0; d < 3; d++) {
    grid[d] = &r->grid[e->degree[d]];
    gauss[d] = &r->gauss[e->degree[d]];
  }
  s->worst = INFINITY;
  s->best = -INFINITY;
  tsi_element_net(r->space, r->control, 4, element, w->net);
  s->sum = sample_rule(w, grid, s);
  (void)sample_rule(w, gauss, s);
}

static void sample_chunk(const run *r, int first, int end) {
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 8) num_threads(r->n_threads)
  for (int e = first; e < end; e++)
    sample_element(r, e, omp_get_thread_num());
#else
  for (int e = first; e < end; e++)
    sample_element(r, e, 0);
#endif
}

/* ---- driver
 * ---------------------------------------------------------------------------------------- */

static void translate_control(run *r, const double *control, size_t n) {
  for (int d = 0; d < 3; d++) {
    double low = INFINITY, high = -INFINITY;
    for (size_t k = 0; k < n; k++) {
      low = fmin(low, control[4 * k + (size_t)d] / control[4 * k + 3]);
      high = fmax(high, control[4 * k + (size_t)d] / control[4 * k + 3]);
    }
    r->centre[d] = 0.5 * low + 0.5 * high;
  }
  for (size_t k = 0; k < n; k++) {
    for (size_t d = 0; d < 3; d++)
      r->control[4 * k + d] = fma(-r->centre[d], control[4 * k + 3], control[4 * k + d]);
    r->control[4 * k + 3] = control[4 * k + 3];
  }
}

static tsolid_status prepare(tsolid_context *context, tsi_arena *arena, const double *control,
                             run *r) {
  size_t n = (size_t)r->space->n_inner + 2 * (size_t)r->space->n_surface, most = 1;
  for (int e = 0; e < r->space->n_elements; e++) {
    size_t points = 1;
    for (int d = 0; d < 3; d++) {
      int q = r->space->element[e].degree[d] + 1;
      points *= (size_t)(q > GRID ? q : GRID);
    }
    most = points > most ? points : most;
  }
  r->n_threads = context->n_threads;
  r->control = tsi_arena_new(arena, n, 4 * sizeof(double));
  r->sample = tsi_arena_new(arena, (size_t)r->space->n_elements, sizeof *r->sample);
  r->grid = tsi_arena_new(arena, TSI_MAX_ORDER, sizeof *r->grid);
  r->gauss = tsi_arena_new(arena, TSI_MAX_ORDER, sizeof *r->gauss);
  r->work = tsi_arena_new(arena, (size_t)r->n_threads, sizeof *r->work);
  int ok = r->control && r->sample && r->grid && r->gauss && r->work;
  for (int i = 0; ok && i < r->n_threads; i++) {
    workspace *w = &r->work[i];
    w->net = tsi_arena_new(arena, most, 4 * sizeof(double));
    w->line = tsi_arena_new(arena, most, 2 * 4 * sizeof(double));
    w->plane = tsi_arena_new(arena, most, 3 * 4 * sizeof(double));
    w->field = tsi_arena_new(arena, most, N_FIELDS * 4 * sizeof(double));
    ok = w->net && w->line && w->plane && w->field;
  }
  if (!ok)
    return tsi_no_memory(context, STAGE);
  translate_control(r, control, n);
  make_rules(r);
  return TSOLID_OK;
}

/* Point of the solid at local x of an element. */
static void point_of(const run *r, int element, const double x[3], double point[3]) {
  double h[4];
  tsi_element_net(r->space, r->control, 4, element, r->work[0].net);
  tsi_bezier_evaluate(r->space->element[element].degree, r->work[0].net, 4, x, 0, h);
  for (int d = 0; d < 3; d++)
    point[d] = h[d] / h[3] + r->centre[d];
}

static void summarise(const run *r, tsolid_quality *q) {
  tsi_sum sum = {0.0, 0.0};
  q->worst = INFINITY;
  q->best = -INFINITY;
  for (int e = 0; e < r->space->n_elements; e++) {
    const sample *s = &r->sample[e];
    tsi_sum_add(&sum, s->sum);
    q->best = fmax(q->best, s->best);
    if (!(s->worst >= q->worst)) {
      q->worst = s->worst;
      q->worst_element = e;
    }
  }
  q->mean = tsi_sum_get(&sum) / ((double)r->space->n_elements * GRID * GRID * GRID);
  const double *box = r->space->element[q->worst_element].box;
  const double *x = r->sample[q->worst_element].worst_x;
  for (int d = 0; d < 3; d++)
    q->worst_u[d] = box[d] + x[d] * (box[3 + d] - box[d]);
  point_of(r, q->worst_element, x, q->worst_point);
}

/* The bound of the core corners holds at all eight: the first stands for them. */
static void include_core_corner(const run *r, tsolid_quality *q) {
  const double bound = 4.0 / (3.0 * sqrt(3.0)), x[3] = {0.0, 0.0, 0.0};
  if (q->bound <= bound)
    return;
  q->bound = bound;
  for (int e = 0; e < r->space->n_elements; e++) {
    const tsi_element *at = &r->space->element[e];
    if (at->block == 0 && at->box[0] == 0.0 && at->box[1] == 0.0 && at->box[2] == 0.0) {
      point_of(r, e, x, q->bound_point);
      return;
    }
  }
}

tsolid_status tsolid_quality_measure(tsolid_context *context, const tsolid_solid *solid,
                                     tsolid_quality *quality) {
  if (!context)
    return TSOLID_ERROR_ARGUMENT;
  if (!solid || !quality)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, STAGE, "An argument is NULL");
  tsi_arena arena = tsi_arena_create(context);
  run r = {.space = solid->space};
  tsolid_quality q = {.start_worst = solid->start_worst};
  int n = r.space->n_elements;
  tsolid_status status = prepare(context, &arena, solid->control, &r);
  for (int first = 0; status == TSOLID_OK && first < n; first += CHUNK) {
    status = tsi_progress(context, STAGE, (double)first / (double)n);
    if (status == TSOLID_OK)
      sample_chunk(&r, first, n - first < CHUNK ? n : first + CHUNK);
  }
  if (status == TSOLID_OK)
    status = tsi_boundary_bound(context, r.space->boundary, &q.bound, q.bound_point);
  if (status == TSOLID_OK)
    status = tsi_progress(context, STAGE, 1.0);
  if (status != TSOLID_OK)
    goto done;
  summarise(&r, &q);
  include_core_corner(&r, &q);
  q.ratio = q.bound > 0.0 ? q.worst / q.bound : 0.0;
  *quality = q;
done:
  tsi_arena_free(&arena);
  return status;
}
