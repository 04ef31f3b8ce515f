/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A planar patch over four border curves.
 *
 * The bilinearly blended Coons patch of the homogeneous borders X_0 .. X_3 (v low, u high, v high,
 * u low) is
 *
 *     X(u,v) = (1-v) X_0(u) + v X_2(u) + (1-u) X_3(v) + u X_1(v)
 *              - (1-u)(1-v) X_00 - u (1-v) X_10 - (1-u) v X_01 - u v X_11.
 *
 * A linear function is the spline whose control points are its values at the Greville points, and
 * each product above has one factor in u and one in v: so the control net of X is the same formula
 * applied to the control points of the borders, with the Greville points of columns and rows for u
 * and v. It has the degrees and knots of the borders, its border rows are theirs, and as it is a
 * combination with sum one it stays in their plane. Weights that this makes too small (borders that
 * are light in their middle) are replaced: the logarithm of a weight is then the Coons combination
 * of logarithms, and points are combined instead of homogeneous points.
 *
 * All of this happens in coordinates of the plane, from the middle of the face. Points inside are
 * placed back into the plane; those of the borders stay as they were given, bit for bit. The
 * certificate is taken of the final points, projected to the plane, with the error of that.
 *
 * Source: S. Coons, Surfaces for computer-aided design of space forms (1967); G. Farin, Curves and
 * Surfaces for CAGD (2002), sections 22.1 to 22.3. In homogeneous form, and in a plane, ours. */
#include "bernstein_product.h"
#include "boundary_bound.h"
#include "bspline.h"
#include "coons.h"
#include "planar_repair.h"

static const double default_tolerance = 1e-7;
/* Worse than this part of what the borders allow is poor; then this part is the goal, and a proved
 * patch is given up only for one that is better by a factor. Near a singular corner every patch is
 * poor: those are not touched when they are proved. */
static const double poor = 0.5, good_enough = 0.8, worthwhile = 1.1;
/* Rounds of refinement before a patch that folds is given up, and of a proved one that is poor. */
enum { REPAIR_ROUNDS = 4, QUALITY_ROUNDS = 1, MAX_REPAIRED = 1 << 16 };
/* Coons weights below this part of the lightest border weight beside them are replaced. */
static const double lightest_inside = 0.05;
struct tsolid_coons {
  tsi_allocator allocator;
  tsolid_patch patch;
  double *memory; /* knots, points, weights */
  char *text;     /* names */
};

static int allocate_planar(tsi_coons_work *w) {
  tsi_planar *p = &w->planar;
  for (int d = 0; d < 2; d++) {
    const tsi_patch *c = &w->border[d ? 3 : 0].curve;
    p->degree[d] = c->degree[0];
    p->n[d] = c->n[0];
    p->knots[d] = c->knots[0];
  }
  size_t n = (size_t)p->n[0] * (size_t)p->n[1];
  p->point = tsi_arena_new(w->arena, n, 2 * sizeof(double));
  p->weight = tsi_arena_new(w->arena, n, sizeof(double));
  return p->point && p->weight;
}

/* Fills the row of border k. Corners are those of the borders along u: see coons_border.c. */
static void fill_border(tsi_coons_work *w, int k) {
  tsi_planar *p = &w->planar;
  const tsi_border *b = &w->border[k];
  int across = k & 1, n = p->n[across];
  ptrdiff_t stride = across ? p->n[0] : 1;
  ptrdiff_t first = k == 1 ? p->n[0] - 1 : k == 2 ? (ptrdiff_t)p->n[0] * (p->n[1] - 1) : 0;
  for (int i = 0; i < n; i++) {
    ptrdiff_t row = first + i * stride;
    if (across && (i == 0 || i == n - 1))
      continue;
    tsi_frame_flatten(&w->frame, b->point + 3 * (ptrdiff_t)i, p->point + 2 * row);
    p->weight[row] = b->curve.control[4 * i + 3];
  }
}

/* What is combined for the point (i, j): (w x, w y, w) or, with replaced weights, (x, y, log w). */
static void load(const tsi_planar *p, int i, int j, int logarithmic, double h[3]) {
  size_t row = (size_t)i + (size_t)p->n[0] * (size_t)j;
  double weight = p->weight[row], factor = logarithmic ? 1.0 : weight;
  h[0] = factor * p->point[2 * row];
  h[1] = factor * p->point[2 * row + 1];
  h[2] = logarithmic ? log(weight) : weight;
}

static void combine(const tsi_planar *p, int i, int j, double u, double v, int logarithmic,
                    double h[3]) {
  int last[2] = {p->n[0] - 1, p->n[1] - 1};
  double side[4][3], corner[4][3];
  load(p, i, 0, logarithmic, side[0]);
  load(p, last[0], j, logarithmic, side[1]);
  load(p, i, last[1], logarithmic, side[2]);
  load(p, 0, j, logarithmic, side[3]);
  for (int k = 0; k < 4; k++)
    load(p, k & 1 ? last[0] : 0, k & 2 ? last[1] : 0, logarithmic, corner[k]);
  for (int c = 0; c < 3; c++)
    h[c] = ((1.0 - v) * side[0][c] + v * side[2][c]) + ((1.0 - u) * side[3][c] + u * side[1][c]) -
           ((1.0 - v) * ((1.0 - u) * corner[0][c] + u * corner[1][c]) +
            v * ((1.0 - u) * corner[2][c] + u * corner[3][c]));
}

static double lightest_beside(const tsi_planar *p, int i, int j) {
  size_t n = (size_t)p->n[0];
  double w = fmin(p->weight[i], p->weight[(size_t)i + n * (size_t)(p->n[1] - 1)]);
  return fmin(w, fmin(p->weight[n * (size_t)j], p->weight[n * (size_t)j + n - 1]));
}

/* Returns 0 when a homogeneous weight is too small. */
static int fill_inside(tsi_planar *p, int logarithmic) {
  for (int j = 1; j + 1 < p->n[1]; j++)
    for (int i = 1; i + 1 < p->n[0]; i++) {
      size_t row = (size_t)i + (size_t)p->n[0] * (size_t)j;
      double h[3];
      combine(p, i, j, tsi_planar_greville(p, 0, i), tsi_planar_greville(p, 1, j), logarithmic, h);
      if (!logarithmic && !(h[2] > lightest_inside * lightest_beside(p, i, j)))
        return 0;
      p->weight[row] = logarithmic ? exp(h[2]) : h[2];
      p->point[2 * row] = logarithmic ? h[0] : h[0] / h[2];
      p->point[2 * row + 1] = logarithmic ? h[1] : h[1] / h[2];
    }
  return 1;
}

static tsolid_status make_coons(tsi_coons_work *w) {
  if (!allocate_planar(w))
    return tsi_no_memory(w->context, TSI_COONS_STAGE);
  for (int k = 0; k < 4; k++)
    fill_border(w, k);
  if (!fill_inside(&w->planar, 0)) {
    w->report->weights_replaced = 1;
    fill_inside(&w->planar, 1);
  }
  return TSOLID_OK;
}

/* ---- the patch in space ---------------------------------------------------------------------- */

/* The border of control point (i, j) and the number there; -1: inside. */
static int find_border(const tsi_planar *p, int i, int j, int *at) {
  int k = j == 0 ? 0 : j == p->n[1] - 1 ? 2 : i == 0 ? 3 : i == p->n[0] - 1 ? 1 : -1;
  *at = k & 1 ? j : i;
  return k;
}

static tsolid_coons *new_coons(tsolid_context *context, const tsi_planar *p) {
  size_t n = (size_t)p->n[0] * (size_t)p->n[1];
  size_t n_knots = (size_t)(p->n[0] + p->degree[0] + p->n[1] + p->degree[1] + 2);
  tsolid_coons *coons = tsi_new(&context->allocator, 1, sizeof *coons);
  if (!coons)
    return NULL;
  coons->allocator = context->allocator;
  coons->memory = tsi_new(&context->allocator, n_knots + 4 * n, sizeof *coons->memory);
  coons->text = tsi_new(&context->allocator, 9, TSI_NAME_SIZE);
  if (coons->memory && coons->text)
    return coons;
  tsolid_coons_free(coons);
  return NULL;
}

static const char *keep_name(tsolid_coons *coons, int slot, const char *name) {
  char *to = coons->text + slot * TSI_NAME_SIZE;
  return name && *name ? tsi_name_patch(name, 0, to) : NULL;
}

/* Space points and weights; then p's points are the projections of what is there now. */
static tsolid_status make_patch(tsi_coons_work *w, const tsolid_curve border[4],
                                tsolid_coons **coons) {
  tsi_planar *p = &w->planar;
  tsolid_coons *c = new_coons(w->context, p);
  if (!c)
    return tsi_no_memory(w->context, TSI_COONS_STAGE);
  double *to = c->memory;
  int weighted = 0;
  for (int d = 0; d < 2; d++) {
    size_t n_knots = (size_t)(p->n[d] + p->degree[d] + 1);
    c->patch.degree[d] = p->degree[d];
    c->patch.n_control[d] = p->n[d];
    c->patch.knots[d] = memcpy(to, p->knots[d], n_knots * sizeof *to);
    to += n_knots;
  }
  double *point = to, *weight = to + 3 * (size_t)p->n[0] * (size_t)p->n[1];
  c->patch.points = point;
  for (int j = 0; j < p->n[1]; j++)
    for (int i = 0; i < p->n[0]; i++) {
      size_t row = (size_t)i + (size_t)p->n[0] * (size_t)j;
      int at, k = find_border(p, i, j, &at);
      if (k >= 0)
        memcpy(point + 3 * row, w->border[k].point + 3 * (ptrdiff_t)at, 3 * sizeof *point);
      else
        tsi_frame_place(&w->frame, p->point + 2 * row, point + 3 * row);
      tsi_frame_flatten(&w->frame, point + 3 * row, p->point + 2 * row);
      weight[row] = p->weight[row];
      weighted |= weight[row] != 1.0;
    }
  c->patch.weights = weighted ? weight : NULL;
  c->patch.name = keep_name(c, 0, w->options.name);
  for (int k = 0; k < 4; k++) {
    c->patch.border_name[k] = keep_name(c, 1 + k, border[k].name);
    c->patch.corner_name[k] = keep_name(c, 5 + k, w->options.corner_name[k]);
    c->patch.border_tolerance[k] = w->options.tolerance;
  }
  *coons = c;
  return TSOLID_OK;
}

/* ---- certificate ----------------------------------------------------------------------------- */

static tsolid_status certify(tsi_coons_work *w, tsi_planar_outcome *outcome) {
  double largest = 0.0;
  for (size_t i = 0; i < 2 * (size_t)w->planar.n[0] * (size_t)w->planar.n[1]; i++)
    largest = fmax(largest, fabs(w->planar.point[i]));
  /* three differences and products, and their sum, for a point at most sqrt(2) largest away; the
   * part across the plane is below the tolerance; of coordinates in space, their own round-off */
  double error = 32.0 * TSI_ROUND_OFF * (largest + w->report->plane_distance);
  error += tsi_data_error(w->singular ? tsi_coons_scale(w) : 0.0);
  tsolid_status status = tsi_planar_certify(w->context, &w->planar, w->singular, error, outcome);
  return status;
}

static void evaluate(const tsi_coons_work *w, const double u[2], double x[3]) {
  const tsi_planar *p = &w->planar;
  double value[2][TSI_MAX_ORDER], h[3] = {0.0, 0.0, 0.0}, flat[2];
  int first[2];
  for (int d = 0; d < 2; d++)
    first[d] = tsi_bspline_basis(p->degree[d], p->n[d], p->knots[d], u[d], value[d], NULL);
  for (int j = 0; j <= p->degree[1]; j++)
    for (int i = 0; i <= p->degree[0]; i++) {
      size_t row = (size_t)(first[0] + i) + (size_t)p->n[0] * (size_t)(first[1] + j);
      double factor = value[0][i] * value[1][j] * p->weight[row];
      h[0] += factor * p->point[2 * row];
      h[1] += factor * p->point[2 * row + 1];
      h[2] += factor;
    }
  flat[0] = h[0] / h[2];
  flat[1] = h[1] / h[2];
  tsi_frame_place(&w->frame, flat, x);
}

static void note_singular(const tsi_coons_work *w) {
  for (int k = 0; k < 4; k++) {
    if (!(w->singular >> k & 1))
      continue;
    tsolid_finding finding = tsi_coons_finding(tsi_coons_corner_point(w, k));
    finding.severity = TSOLID_NOTE;
    finding.status = TSOLID_OK;
    tsi_report(w->context, &finding,
               "At %s of %s the two borders are tangent: det J is zero at this point, and proved "
               "positive beside it",
               tsi_coons_corner_name(w, k), w->name);
  }
}

/* ---- driver ---------------------------------------------------------------------------------- */

void tsolid_coons_free(tsolid_coons *coons) {
  if (!coons)
    return;
  tsi_allocator allocator = coons->allocator;
  tsi_delete(&allocator, coons->memory);
  tsi_delete(&allocator, coons->text);
  tsi_delete(&allocator, coons);
}

void tsolid_coons_get(const tsolid_coons *coons, tsolid_patch *patch) {
  if (coons && patch)
    *patch = coons->patch;
}

static tsolid_status check_options(tsi_coons_work *w, const tsolid_coons_options *options) {
  if (options)
    w->options = *options;
  const tsolid_coons_options *o = &w->options;
  if (!(o->tolerance >= 0.0) || !isfinite(o->tolerance) || !isfinite(o->normal[0]) ||
      !isfinite(o->normal[1]) || !isfinite(o->normal[2]) || o->repair < 0 ||
      o->repair > TSOLID_REPAIR_ALWAYS)
    return tsi_fail(w->context, TSOLID_ERROR_ARGUMENT, TSI_COONS_STAGE,
                    "An option is not finite, negative or unknown");
  if (o->tolerance == 0.0)
    w->options.tolerance = default_tolerance;
  if (o->name && *o->name)
    tsi_name_patch(o->name, 0, w->name);
  else
    memcpy(w->name, "the face", sizeof "the face");
  return TSOLID_OK;
}

/* A patch that is proved not to fold, and how good it is. */
typedef struct attempt {
  tsolid_coons *coons; /* NULL: none yet */
  tsi_planar_outcome outcome;
  tsi_planar_quality quality;
  double where[3], worst_point[3]; /* of the outcome, of the quality */
} attempt;

/* The patch of the points as they are now, with its certificate and quality. */
static tsolid_status make_attempt(tsi_coons_work *w, const tsolid_curve border[4], attempt *a) {
  tsolid_status status = make_patch(w, border, &a->coons);
  if (!status)
    status = certify(w, &a->outcome);
  if (!status)
    status = tsi_planar_measure(w->context, &w->planar, w->singular, &a->quality);
  if (!status) {
    evaluate(w, a->outcome.u, a->where);
    evaluate(w, a->quality.u, a->worst_point);
  }
  return status;
}

/* More control points inside: at least cubic, and 2^round spans. */
static tsolid_status refine(tsi_coons_work *w, int round) {
  tsolid_coons_report *r = w->report;
  tsolid_status status = TSOLID_OK;
  for (int d = 0; !status && d < 2; d++) {
    tsi_border *a = &w->border[d ? 3 : 0], *b = &w->border[d ? 1 : 2];
    int degree = a->curve.degree[0];
    status = tsi_borders_refine(w->context, w->arena, a, b, degree < 3 ? 3 : degree, 1 << round,
                                &r->n_inside_degrees, &r->n_inside_knots);
  }
  return status ? status : make_coons(w);
}

static int has_inside(const tsi_planar *p) {
  return p->n[0] > 2 && p->n[1] > 2;
}

/* Moves control points inside until the patch is proved not to fold and good enough; *best is what
 * came out best, as proved, as it was when nothing better was found. */
static tsolid_status repair(tsi_coons_work *w, const tsolid_curve border[4], attempt *best,
                            tsolid_coons_report *best_report) {
  double goal = good_enough * w->report->bound;
  int proved = best->outcome.verdict == TSOLID_POSITIVE;
  int last = proved ? QUALITY_ROUNDS : REPAIR_ROUNDS;
  tsolid_status status = TSOLID_OK;
  for (int round = has_inside(&w->planar) ? 0 : 1; !status && round <= last; round++) {
    attempt next = {.coons = NULL};
    if (round > 0)
      status = refine(w, round);
    if (!status && (size_t)w->planar.n[0] * (size_t)w->planar.n[1] > MAX_REPAIRED)
      break;
    if (!status)
      status = tsi_planar_improve(w->context, &w->planar, w->singular, goal, round);
    w->report->repaired = 1;
    if (!status)
      status = make_attempt(w, border, &next);
    int next_proved = !status && next.outcome.verdict == TSOLID_POSITIVE;
    if (next_proved ? !proved || next.quality.worst > worthwhile * best->quality.worst
                    : !status && !proved) {
      attempt old = *best;
      *best = next;
      next = old;
      *best_report = *w->report;
      last = next_proved && !proved ? round + QUALITY_ROUNDS : last;
      proved = next_proved;
    }
    tsolid_coons_free(next.coons);
    if (proved && best->quality.worst >= poor * w->report->bound)
      break;
  }
  return status;
}

static tsolid_status refuse_fold(tsi_coons_work *w, const attempt *a) {
  const double *x = a->where;
  tsolid_finding finding = tsi_coons_finding(x);
  const char *tried = w->report->repaired ? ", also with control points moved inside" : "";
  if (a->outcome.verdict == TSOLID_NOT_POSITIVE)
    return tsi_report(w->context, &finding,
                      "The patch between the four borders of %s folds near (%.6g, %.6g, %.6g)%s. "
                      "Split the face, or choose other corners",
                      w->name, x[0], x[1], x[2], tried);
  return tsi_report(w->context, &finding,
                    "The patch between the four borders of %s cannot be proved not to fold near "
                    "(%.6g, %.6g, %.6g)%s",
                    w->name, x[0], x[1], x[2], tried);
}

static tsolid_status finish(tsi_coons_work *w, const attempt *best) {
  tsolid_coons_report *r = w->report;
  r->n_elements = best->outcome.n_elements;
  r->depth = best->outcome.depth;
  r->worst = best->quality.worst;
  memcpy(r->worst_point, best->worst_point, sizeof r->worst_point);
  if (best->outcome.verdict != TSOLID_POSITIVE)
    return refuse_fold(w, best);
  note_singular(w);
  return TSOLID_OK;
}

static tsolid_status run(tsi_coons_work *w, const tsolid_curve border[4], tsolid_coons **coons) {
  attempt best = {.coons = NULL};
  tsolid_status status =
      tsi_borders_read(w->context, w->arena, border, &w->options, w->border, w->report);
  if (!status)
    status = tsi_coons_find_plane(w);
  if (!status)
    status = tsi_coons_check_corners(w);
  if (!status)
    status = tsi_coons_check_loop(w);
  if (!status)
    status = make_coons(w);
  if (!status)
    status = make_attempt(w, border, &best);
  if (!status) {
    int wanted = best.outcome.verdict != TSOLID_POSITIVE ||
                 (!w->singular && best.quality.worst < poor * w->report->bound) ||
                 w->options.repair == TSOLID_REPAIR_ALWAYS;
    tsolid_coons_report report = *w->report;
    report.start_worst = w->report->start_worst = best.quality.worst;
    if (wanted && w->options.repair != TSOLID_REPAIR_NEVER)
      status = repair(w, border, &best, &report);
    *w->report = report;
  }
  if (!status)
    status = finish(w, &best);
  *coons = best.coons;
  return status;
}

tsolid_status tsolid_coons_create(tsolid_context *context, const tsolid_curve border[4],
                                  const tsolid_coons_options *options, tsolid_coons_report *report,
                                  tsolid_coons **coons) {
  tsolid_coons_report own;
  if (!context || !border || !coons)
    return TSOLID_ERROR_ARGUMENT;
  *coons = NULL;
  tsi_coons_work w = {.context = context, .report = report ? report : &own};
  *w.report = (tsolid_coons_report){.weight_factor = {1.0, 1.0, 1.0, 1.0},
                                    .linear_border = -1,
                                    .linear_factor = {1.0, 1.0},
                                    .start_worst = (double)NAN,
                                    .worst = (double)NAN,
                                    .bound = 1.0};
  tsi_arena arena = tsi_arena_create(context);
  w.arena = &arena;
  tsolid_status status = check_options(&w, options);
  if (!status)
    status = run(&w, border, coons);
  tsi_arena_free(&arena);
  if (status) {
    tsolid_coons_free(*coons);
    *coons = NULL;
  }
  return status;
}
