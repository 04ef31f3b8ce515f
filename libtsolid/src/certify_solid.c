/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The Jacobian certificate of a solid: certify.c for every Bezier element.
 *
 * The claim is about the T-spline defined by the stored control points and the space's stored
 * extraction coefficients, not about nets that happened to be computed. All control points are
 * first translated near the origin, P' = fl(P - c w) with one rounding. tsi_element_net then sums
 * products of non-negative coefficients with control points; with n entries of an element, three
 * factors each and the raising of degrees the computed net differs from the exact one by at most
 *
 *     gamma_K sum_A B_A |P_A'|,    K = n + NET_OPERATIONS,
 *
 * per component, and sum_A B_A |w x_A| <= max_A |x_A| W <= max |x| max W: error[] of the task.
 *
 * Where all control weights are one number w and the functions sum to one, W = w. The sum is not
 * assumed: a computed W within epsilon of w makes the true derivative numerators
 * A_i - A W_i / W, with |A / W| <= max |x| and |W_i| <= 2 q epsilon: max |x| epsilon is added to
 * the error of each control point, and the cheap form of N is used (which then is W^-1 times the
 * rational one). Where epsilon is not small the rational form is taken.
 *
 * Corners of the cube where the input itself has det J = 0 are known from the tangents of its sides
 * alone (boundary_bound.c). There the coefficient of N at this corner is zero by theory and may be
 * as large as its error bound; all others must be positive. */
#include "certify.h"

#ifdef _OPENMP
#include <omp.h>
#endif

#include "bernstein_product.h"
#include "boundary_bound.h"

static const char *const STAGE = "certify";

enum { CHUNK = 256, NET_OPERATIONS = 96 };

/* Weights of a net are taken for one number up to this relative difference. */
static const double CONSTANT_TOLERANCE = 1e-12;

static const double MAX_WORKSPACE = 1e9;

typedef struct run {
  const tsolid_solid *solid;
  const tsolid_space *space;
  double *control;   /* translated, all functions */
  double largest[3]; /* max |x - c| over the control points, Euclidean */
  double centre[3];
  tsi_corner corner[8];
  int max_depth, n_threads;
  tsi_certifier **certifier; /* one per thread */
  double **net;              /* one per thread */
  tsi_certify_outcome *outcome;
} run;

/* ---- steps --------------------------------------------------------------------------------------
 */

static size_t n_points(const int degree[3]) {
  return (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1) * (size_t)(degree[2] + 1);
}

static tsolid_status check_control(tsolid_context *context, const tsolid_solid *solid, size_t n) {
  for (size_t k = 0; k < n; k++) {
    const double *p = solid->control + 4 * k;
    if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]) || !isfinite(p[3]) || !(p[3] > 0.0))
      return tsi_fail(context, TSOLID_ERROR_INPUT, STAGE,
                      "Control point %zu is not finite or its weight is not positive", k);
  }
  return TSOLID_OK;
}

static void translate_control(run *r, size_t n) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t k = 0; k < n; k++) {
    const double *p = r->solid->control + 4 * k;
    for (int d = 0; d < 3; d++) {
      low[d] = fmin(low[d], p[d] / p[3]);
      high[d] = fmax(high[d], p[d] / p[3]);
    }
  }
  for (int d = 0; d < 3; d++) {
    r->centre[d] = 0.5 * low[d] + 0.5 * high[d];
    /* the slack covers the roundings of quotient, centre and difference */
    double size = fmax(fabs(high[d]), fabs(low[d]));
    r->largest[d] =
        fmax(high[d] - r->centre[d], r->centre[d] - low[d]) + 8.0 * TSI_ROUND_OFF * size;
  }
  for (size_t k = 0; k < n; k++) {
    const double *p = r->solid->control + 4 * k;
    for (int d = 0; d < 3; d++)
      r->control[4 * k + (size_t)d] = fma(-r->centre[d], p[3], p[d]);
    r->control[4 * k + 3] = p[3];
  }
}

/* Error of the net, see the top; decides between the two forms of N. */
static void set_errors(const run *r, int element, tsi_certify_task *task) {
  const tsi_element *e = &r->space->element[element];
  size_t n = r->space->inner_start[element + 1] - r->space->inner_start[element];
  double heaviest = 0.0, w = r->solid->control[3], spread = 0.0;
  if (e->block > 0) {
    const tsi_lateral *l = &r->space->lateral[e->lateral];
    n += 2 * (size_t)(l->function_end - l->function_first);
  }
  for (size_t k = 0; k < n_points(task->degree); k++) {
    double weight = task->points[4 * k + 3];
    heaviest = fmax(heaviest, weight);
    spread = fmax(spread, fabs(weight - w));
  }
  double gamma = tsi_gamma((double)n + (double)NET_OPERATIONS) * (1.0 + 0x1p-30);
  double error = gamma * heaviest;
  task->constant_weight =
      r->solid->constant_weight && spread + error <= CONSTANT_TOLERANCE * fabs(w);
  task->error[3] = error;
  for (int d = 0; d < 3; d++) {
    task->error[d] = error * r->largest[d];
    if (task->constant_weight)
      task->error[d] += (spread + error) * r->largest[d];
    if (task->singular) /* what is tangent is so but for this */
      task->error[d] += heaviest * tsi_data_error(r->space->boundary->scale);
  }
}

static void certify_one(const run *r, int element, int thread) {
  const tsi_element *e = &r->space->element[element];
  tsi_certify_task task = {{e->degree[0], e->degree[1], e->degree[2]},
                           r->net[thread],
                           {0.0, 0.0, 0.0, 0.0},
                           0,
                           0,
                           r->max_depth};
  tsi_element_net(r->space, r->control, 4, element, r->net[thread]);
  task.singular = tsi_singular_corners(r->space, r->corner, element);
  set_errors(r, element, &task);
  tsi_certify_run(r->certifier[thread], &task, &r->outcome[element]);
}

static void certify_chunk(const run *r, int first, int end) {
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 4) num_threads(r->n_threads)
  for (int e = first; e < end; e++)
    certify_one(r, e, omp_get_thread_num());
#else
  for (int e = first; e < end; e++)
    certify_one(r, e, 0);
#endif
}

/* ---- the answer
 * ----------------------------------------------------------------------------------- */

static int graver(tsolid_verdict a, tsolid_verdict b) {
  static const int grade[] = {
      [TSOLID_POSITIVE] = 0, [TSOLID_UNDECIDED] = 1, [TSOLID_NOT_POSITIVE] = 2};
  return grade[a] > grade[b];
}

static void summarise(const run *r, tsolid_certificate *c, int *element_verdict) {
  memset(c, 0, sizeof *c);
  c->element = -1;
  c->n_elements = r->space->n_elements;
  c->smallest_bound = INFINITY;
  for (int e = 0; e < c->n_elements; e++) {
    const tsi_certify_outcome *o = &r->outcome[e];
    c->n_positive += o->verdict == TSOLID_POSITIVE;
    c->n_not_positive += o->verdict == TSOLID_NOT_POSITIVE;
    c->n_undecided += o->verdict == TSOLID_UNDECIDED;
    c->depth = o->depth > c->depth ? o->depth : c->depth;
    c->smallest_bound = fmin(c->smallest_bound, o->bound);
    if (element_verdict)
      element_verdict[e] = (int)o->verdict;
    if (graver(o->verdict, c->verdict)) {
      c->verdict = o->verdict;
      c->element = e;
    }
  }
}

static void place(const run *r, tsolid_certificate *c) {
  if (c->element < 0)
    return;
  const tsi_element *e = &r->space->element[c->element];
  const double *u = r->outcome[c->element].u;
  tsi_element_net(r->space, r->control, 4, c->element, r->net[0]);
  tsi_net_point(e->degree, r->net[0], u, c->point);
  for (int d = 0; d < 3; d++) {
    c->u[d] = e->box[d] + u[d] * (e->box[3 + d] - e->box[d]);
    c->point[d] += r->centre[d];
  }
}

static void name_findings(tsolid_context *context, const run *r, tsolid_certificate *c) {
  for (int corner = 0; corner < 8; corner++) {
    const tsi_corner *k = &r->corner[corner];
    if (!k->singular[0] && !k->singular[1] && !k->singular[2])
      continue;
    memcpy(c->singular[c->n_singular++], k->point, sizeof k->point);
    tsolid_finding note = tsi_finding(TSOLID_NOTE, TSOLID_OK, STAGE);
    note.entity = TSOLID_ENTITY_CORNER;
    note.index[0] = corner;
    note.has_point = 1;
    memcpy(note.point, k->point, sizeof note.point);
    note.measured = k->sine;
    note.allowed = k->tolerance;
    (void)tsi_report(context, &note,
                     "The sides meet tangentially at this corner, so det J = 0 there in any solid");
  }
  if (c->element < 0)
    return;
  tsolid_finding warning = tsi_finding(TSOLID_WARNING, TSOLID_OK, STAGE);
  warning.entity = TSOLID_ENTITY_ELEMENT;
  warning.index[0] = c->element;
  warning.has_point = 1;
  memcpy(warning.point, c->point, sizeof warning.point);
  if (c->verdict == TSOLID_NOT_POSITIVE)
    (void)tsi_report(context, &warning, "det J is not positive at this point (%d of %d elements)",
                     c->n_not_positive, c->n_elements);
  else
    (void)tsi_report(context, &warning,
                     "det J > 0 could not be decided near this point (%d of %d elements)",
                     c->n_undecided, c->n_elements);
}

/* ---- driver
 * ---------------------------------------------------------------------------------------- */

/* So many threads that their workspaces stay below MAX_WORKSPACE bytes together. */
static int threads_for(const tsolid_context *context, const tsi_certify_size *size, int max_depth) {
  double one =
      ((double)size->jacobian + (double)size->net) * (max_depth + 2) * 2.0 * sizeof(double);
  double most = MAX_WORKSPACE / one;
  return most < context->n_threads ? (most < 1.0 ? 1 : (int)most) : context->n_threads;
}

/* Everything that needs memory, before any thread starts. */
static tsolid_status prepare(tsolid_context *context, tsi_arena *arena, run *r) {
  size_t n_functions = (size_t)r->space->n_inner + 2 * (size_t)r->space->n_surface;
  tsi_certify_size size = {0, 0, 0};
  for (int e = 0; e < r->space->n_elements; e++)
    tsi_certify_size_include(&size, r->space->element[e].degree);
  r->n_threads = threads_for(context, &size, r->max_depth);
  tsolid_status status = check_control(context, r->solid, n_functions);
  if (status != TSOLID_OK)
    return status;
  r->control = tsi_arena_new(arena, n_functions, 4 * sizeof *r->control);
  r->outcome = tsi_arena_new(arena, (size_t)r->space->n_elements, sizeof *r->outcome);
  r->certifier = tsi_arena_new(arena, (size_t)r->n_threads, sizeof(tsi_certifier *));
  r->net = tsi_arena_new(arena, (size_t)r->n_threads, sizeof(double *));
  if (!r->control || !r->outcome || !r->certifier || !r->net)
    return tsi_no_memory(context, STAGE);
  for (int i = 0; i < r->n_threads; i++) {
    r->certifier[i] = tsi_certifier_create(arena, &size, r->max_depth);
    r->net[i] = tsi_arena_new(arena, size.net, 4 * sizeof(double));
    if (!r->certifier[i] || !r->net[i])
      return tsi_no_memory(context, STAGE);
  }
  translate_control(r, n_functions);
  for (int corner = 0; corner < 8; corner++)
    tsi_corner_measure(r->space->boundary, corner, &r->corner[corner]);
  return TSOLID_OK;
}

tsolid_status tsolid_certify(tsolid_context *context, const tsolid_solid *solid,
                             const tsolid_certificate_options *options,
                             tsolid_certificate *certificate, int *element_verdict) {
  if (!context)
    return TSOLID_ERROR_ARGUMENT;
  if (!solid || !certificate)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, STAGE, "An argument is NULL");
  if (options && (options->max_depth < 0 || options->max_depth > TSI_CERTIFY_MAX_DEPTH))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, STAGE, "Depth %d is not in 0..%d",
                    options->max_depth, TSI_CERTIFY_MAX_DEPTH);
  tsi_arena arena = tsi_arena_create(context);
  run r = {.solid = solid, .space = solid->space};
  r.max_depth = options && options->max_depth ? options->max_depth : TSI_CERTIFY_DEPTH;
  int n = r.space->n_elements;
  tsolid_status status = prepare(context, &arena, &r);
  for (int first = 0; status == TSOLID_OK && first < n; first += CHUNK) {
    int end = n - first < CHUNK ? n : first + CHUNK;
    status = tsi_progress(context, STAGE, (double)first / (double)n);
    if (status == TSOLID_OK)
      certify_chunk(&r, first, end);
  }
  if (status == TSOLID_OK)
    status = tsi_progress(context, STAGE, 1.0);
  if (status != TSOLID_OK)
    goto done;
  summarise(&r, certificate, element_verdict);
  place(&r, certificate);
  name_findings(context, &r, certificate);
done:
  tsi_arena_free(&arena);
  return status;
}
