/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Four border curves made to fit each other, exactly.
 *
 *            2 (v high)          corners 0..3: (u,v) = 00, 10, 11, 01
 *        3 o----->-----o 2       borders 0 and 2 run along u, 1 and 3 along v
 *          ^           ^
 *  3 (u low)           | 1 (u high)
 *          |           |
 *        0 o----->-----o 1
 *            0 (v low)
 *
 * Weights. A curve stays the same when its homogeneous control points are multiplied by a positive
 * number. With f_0 = 1 the corners 1, 2, 0 determine the factors of the borders 1, 2, 3; corner 3
 * is the test. Where it fails, no constants serve, and one border is multiplied by the linear
 * function that is one at its one end and makes up the difference at the other: same points, same
 * parameter, one degree more. It is the border of the least degree.
 *
 * Opposite borders then get one degree and one knot vector: degree raising and knot insertion
 * (bspline.c), both exact. What was refined is no longer the given curve bit for bit, but is the
 * same curve; a neighbour that has the unrefined one is refined along the seam by the boundary
 * stage. */
#include "bspline.h"
#include "coons.h"

/* Knots of opposite borders closer than this are one, as between neighbouring patches. */
static const double knot_resolution = 1e-11;
static const double weight_agreement = 1e-10;
/* Bounds that keep squares and products of control points finite. */
static const double largest_coordinate = 1e100, largest_weight = 1e50;

enum { MAX_CONTROL = 1 << 14 }; /* of one border */

/* ---- vetting --------------------------------------------------------------------------------- */

static tsolid_status vet_knots(tsolid_context *context, const tsolid_curve *curve,
                               const char *name) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, TSI_COONS_STAGE);
  const double *knots = curve->knots;
  int p = curve->degree, n = curve->n_control;
  for (int i = 0; i < n + p + 1; i++)
    if (!isfinite(knots[i]) || (i && knots[i] < knots[i - 1]))
      return tsi_report(context, &finding, "%s: knot %d is not a finite number, or decreases", name,
                        i);
  double first = knots[0], range = knots[n + p] - first;
  if (!(range > 0.0) || !isfinite(range))
    return tsi_report(context, &finding, "%s: the knots span no finite interval", name);
  if (knots[p] != first || knots[n] != knots[n + p])
    return tsi_report(context, &finding,
                      "%s: the knots are not clamped: the first and the last must each stand %d "
                      "times",
                      name, p + 1);
  for (int i = p + 1; i < n; i++) {
    double x = (knots[i] - first) / range;
    if (!(x > knot_resolution && x < 1.0 - knot_resolution))
      return tsi_report(context, &finding,
                        "%s: knot %d lies on the end of the range, or too near to it", name, i);
    if (i + p < n && knots[i + p] == knots[i])
      return tsi_report(context, &finding,
                        "%s: knot %d stands more than %d times, the curve is torn there", name, i,
                        p);
  }
  return TSOLID_OK;
}

static tsolid_status vet_points(tsolid_context *context, const tsolid_curve *curve,
                                const char *name) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, TSI_COONS_STAGE);
  for (int i = 0; i < curve->n_control; i++) {
    const double *x = curve->points + 3 * (size_t)i;
    for (int c = 0; c < 3; c++)
      if (!(fabs(x[c]) <= largest_coordinate))
        return tsi_report(context, &finding, "%s: control point %d is not finite or too large",
                          name, i);
    double w = curve->weights ? curve->weights[i] : 1.0;
    finding.measured = w;
    if (!(w > 0.0) || !(w <= largest_weight) || !(w >= 1.0 / largest_weight))
      return tsi_report(context, &finding,
                        "%s: the weight of control point %d is %g, it must be positive and finite",
                        name, i, w);
  }
  return TSOLID_OK;
}

static tsolid_status vet_curve(tsolid_context *context, const tsolid_curve *curve,
                               const char *name) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, TSI_COONS_STAGE);
  if (curve->degree < 1 || curve->degree > TSI_MAX_DEGREE)
    return tsi_report(context, &finding, "%s has degree %d, not one of 1 to %d", name,
                      curve->degree, (int)TSI_MAX_DEGREE);
  if (curve->n_control < curve->degree + 1 || curve->n_control > MAX_CONTROL)
    return tsi_report(context, &finding, "%s has %d control points, not %d to %d", name,
                      curve->n_control, curve->degree + 1, (int)MAX_CONTROL);
  if (!curve->knots || !curve->points)
    return tsi_report(context, &finding, "%s has no knots or no control points", name);
  tsolid_status status = vet_knots(context, curve, name);
  return status ? status : vet_points(context, curve, name);
}

/* ---- reading --------------------------------------------------------------------------------- */

static void name_border(const tsolid_curve *curve, int k, char name[TSI_NAME_SIZE]) {
  static const char *const word[4] = {"border v low", "border u high", "border v high",
                                      "border u low"};
  tsi_name_patch(curve->name && *curve->name ? curve->name : word[k], k, name);
}

static tsolid_status read_curve(tsolid_context *context, tsi_arena *arena,
                                const tsolid_curve *curve, tsi_border *border) {
  size_t n = (size_t)curve->n_control;
  tsi_patch *c = &border->curve;
  *c = (tsi_patch){.degree = {curve->degree, 0}, .n = {curve->n_control, 1}};
  c->knots[0] = tsi_arena_new(arena, n + (size_t)curve->degree + 1, sizeof(double));
  c->control = tsi_arena_new(arena, n, 4 * sizeof(double));
  border->point = tsi_arena_new(arena, n, 3 * sizeof(double));
  if (!c->knots[0] || !c->control || !border->point)
    return tsi_no_memory(context, TSI_COONS_STAGE);
  border->n_points = curve->n_control;
  tsi_knots_normalise(curve->n_control + curve->degree + 1, curve->knots, c->knots[0]);
  for (size_t i = 0; i < n; i++) {
    c->control[4 * i + 3] = curve->weights ? curve->weights[i] : 1.0;
    for (size_t d = 0; d < 3; d++)
      border->point[3 * i + d] = curve->points[3 * i + d] + 0.0; /* no -0 */
  }
  return TSOLID_OK;
}

/* Homogeneous from Euclidean points and weights. */
static void multiply_points(tsi_border *border) {
  for (int i = 0; i < border->curve.n[0]; i++)
    for (int c = 0; c < 3; c++)
      border->curve.control[4 * i + c] =
          border->curve.control[4 * i + 3] * border->point[3 * i + c];
}

static int end_row(const tsi_border *border, int end) {
  return end ? border->curve.n[0] - 1 : 0;
}

static double *end_weight(tsi_border *border, int end) {
  return border->curve.control + 4 * (ptrdiff_t)end_row(border, end) + 3;
}

/* ---- corners --------------------------------------------------------------------------------- */

static const char *const corner_word[4] = {"(u,v) = (0,0)", "(u,v) = (1,0)", "(u,v) = (1,1)",
                                           "(u,v) = (0,1)"};

/* The corner of both borders is where the one along u ends. */
static tsolid_status join_corners(tsolid_context *context, tsi_border b[4], double tolerance,
                                  tsolid_coons_report *report) {
  report->corner_gap = 0.0;
  for (int k = 0; k < 4; k++) {
    tsi_border *along = &b[tsi_corner_border(k, 0)], *across = &b[tsi_corner_border(k, 1)];
    const double *x = along->point + 3 * (ptrdiff_t)end_row(along, tsi_corner_end(k, 0));
    double *y = across->point + 3 * (ptrdiff_t)end_row(across, tsi_corner_end(k, 1));
    double gap = tsi_distance(x, y);
    report->corner_gap = fmax(report->corner_gap, gap);
    if (!(gap <= tolerance)) {
      tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, TSI_COONS_STAGE);
      finding.has_point = 1;
      memcpy(finding.point, x, sizeof finding.point);
      finding.measured = gap;
      finding.allowed = tolerance;
      return tsi_report(context, &finding, "%s and %s do not meet at %s: they are %.6g apart",
                        along->name, across->name, corner_word[k], gap);
    }
    memcpy(y, x, 3 * sizeof *y);
  }
  return TSOLID_OK;
}

static void scale_weights(tsi_border *border, double factor) {
  for (int i = 0; factor != 1.0 && i < border->curve.n[0]; i++)
    border->curve.control[4 * i + 3] *= factor;
}

static double agreed_ratio(double a, double b) {
  double ratio = a / b;
  return fabs(ratio - 1.0) <= weight_agreement ? 1.0 : ratio;
}

static tsolid_status check_weights(tsolid_context *context, const tsi_border b[4]) {
  for (int k = 0; k < 4; k++)
    for (int i = 0; i < b[k].curve.n[0]; i++) {
      double w = b[k].curve.control[4 * i + 3];
      if (!(w <= largest_weight) || !(w >= 1.0 / largest_weight))
        return tsi_fail(context, TSOLID_ERROR_REFUSED, TSI_COONS_STAGE,
                        "The weights of %s become too large or too small when they are made to "
                        "fit the borders next to it",
                        b[k].name);
    }
  return TSOLID_OK;
}

/* Multiplies one border by the linear function from low to high. */
static tsolid_status multiply_linear(tsolid_context *context, tsi_arena *arena, tsi_border *border,
                                     double low, double high) {
  const double corner[4] = {low, high, low, high};
  int n_raised;
  if (border->curve.degree[0] >= TSI_MAX_DEGREE)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, TSI_COONS_STAGE,
                    "The weights at the four corners do not fit, and the degree of %s would rise "
                    "above %d when they are made to",
                    border->name, (int)TSI_MAX_DEGREE);
  multiply_points(border);
  if (!tsi_patch_multiply(arena, &border->curve, corner, &n_raised))
    return tsi_no_memory(context, TSI_COONS_STAGE);
  border->refined = 1;
  return TSOLID_OK;
}

/* See the top. The factor of corner 3, seen along borders 2 and 3, must be one; `open` is it. */
static tsolid_status match_weights(tsolid_context *context, tsi_arena *arena, tsi_border b[4],
                                   tsolid_coons_report *report) {
  double *f = report->weight_factor;
  f[0] = 1.0;
  f[1] = agreed_ratio(*end_weight(&b[0], 1), *end_weight(&b[1], 0));
  f[3] = agreed_ratio(*end_weight(&b[0], 0), *end_weight(&b[3], 0));
  f[2] = agreed_ratio(f[1] * *end_weight(&b[1], 1), *end_weight(&b[2], 1));
  for (int k = 1; k < 4; k++)
    scale_weights(&b[k], f[k]);
  double open = *end_weight(&b[2], 0) / *end_weight(&b[3], 1);
  report->linear_border = -1;
  report->linear_factor[0] = report->linear_factor[1] = 1.0;
  tsolid_status status = check_weights(context, b);
  if (status || fabs(open - 1.0) <= weight_agreement)
    return status;
  /* Border 0 or 3 times 1 .. 1/open or 1 .. open; after a factor at corner 0 or 1 the borders that
   * hang on it follow by constants. Which border: the least degree. */
  int least = 0;
  for (int k = 1; k < 4; k++)
    if (b[k].curve.degree[0] < b[least].curve.degree[0])
      least = k;
  if (least == 0) { /* all that hangs on its high end: borders 1 and 2 */
    scale_weights(&b[1], 1.0 / open);
    scale_weights(&b[2], 1.0 / open);
    f[1] /= open;
    f[2] /= open;
  } else if (least == 1) {
    scale_weights(&b[2], 1.0 / open);
    f[2] /= open;
  }
  double low = least == 2 ? 1.0 / open : 1.0;
  double high = least == 3 ? open : least < 2 ? 1.0 / open : 1.0;
  report->linear_border = least;
  report->linear_factor[0] = low;
  report->linear_factor[1] = high;
  status = multiply_linear(context, arena, &b[least], low, high);
  return status ? status : check_weights(context, b);
}

/* ---- opposite borders ------------------------------------------------------------------------ */

/* Knots of b within the resolution of one of a become that one. Returns 0 when one then stands too
 * often. */
static int merge_knots(const tsi_patch *a, tsi_patch *b, double *largest) {
  int p = b->degree[0], n = b->n[0], n_a = a->n[0];
  for (int i = p + 1, k = a->degree[0] + 1; i < n; i++) {
    double *x = &b->knots[0][i];
    while (k < n_a && a->knots[0][k] < *x - knot_resolution)
      k++;
    if (k == n_a || !(fabs(a->knots[0][k] - *x) <= knot_resolution))
      continue;
    *largest = fmax(*largest, fabs(a->knots[0][k] - *x));
    *x = fmax(a->knots[0][k], b->knots[0][i - 1]);
  }
  for (int i = p + 1; i < n; i++)
    if (i + p < n && b->knots[0][i + p] == b->knots[0][i])
      return 0;
  return 1;
}

/* The union of two knot vectors of one degree, multiplicities included; the number of knots. */
static int unite_knots(const tsi_patch *a, const tsi_patch *b, double *to) {
  int n_a = a->n[0] + a->degree[0] + 1, n_b = b->n[0] + b->degree[0] + 1, n = 0;
  for (int i = 0, j = 0; i < n_a || j < n_b; n++) {
    if (j == n_b || (i < n_a && a->knots[0][i] <= b->knots[0][j])) {
      j += j < n_b && a->knots[0][i] == b->knots[0][j];
      to[n] = a->knots[0][i++];
    } else {
      to[n] = b->knots[0][j++];
    }
  }
  return n;
}

static int same_knots(const tsi_patch *a, int n_to, const double *to) {
  return a->n[0] == n_to &&
         memcmp(a->knots[0], to, (size_t)(n_to + a->degree[0] + 1) * sizeof *to) == 0;
}

/* Euclidean points of what was refined; those at the ends as they were, where a quotient may be off
 * by a rounding. */
static int divide_points(tsi_arena *arena, tsi_border *border) {
  int n = border->curve.n[0];
  const double *h = border->curve.control, *before = border->point;
  double *point = tsi_arena_new(arena, (size_t)n, 3 * sizeof *point);
  if (!point)
    return 0;
  for (int i = 0; i < n; i++, h += 4)
    for (int c = 0; c < 3; c++)
      point[3 * i + c] = i == 0       ? before[c]
                         : i == n - 1 ? before[3 * (border->n_points - 1) + c]
                                      : h[c] / h[3];
  border->point = point;
  border->n_points = n;
  return 1;
}

static int raise_border(tsi_arena *arena, tsi_border *border, int degree, int *n_raised) {
  tsi_patch *c = &border->curve;
  while (c->degree[0] < degree) {
    int n_to = tsi_knots_raise(c->degree[0], c->n[0], c->knots[0], NULL);
    double *to = tsi_arena_new(arena, (size_t)(n_to + c->degree[0] + 2), sizeof *to);
    if (!to)
      return 0;
    tsi_knots_raise(c->degree[0], c->n[0], c->knots[0], to);
    if (!tsi_patch_refine(arena, c, 0, 1, n_to, to))
      return 0;
    border->refined = 1;
    (*n_raised)++;
  }
  return 1;
}

static tsolid_status match_pair(tsolid_context *context, tsi_arena *arena, tsi_border *a,
                                tsi_border *b, tsolid_coons_report *report) {
  tsi_border *pair[2] = {a, b};
  int degree = a->curve.degree[0] > b->curve.degree[0] ? a->curve.degree[0] : b->curve.degree[0];
  if (!merge_knots(&a->curve, &b->curve, &report->knot_merge))
    return tsi_fail(context, TSOLID_ERROR_REFUSED, TSI_COONS_STAGE,
                    "Knots of %s lie so close to those of %s that they fall together, and the "
                    "curve would be torn there",
                    b->name, a->name);
  for (int k = 0; k < 2; k++)
    if (!raise_border(arena, pair[k], degree, &report->n_degrees_raised))
      return tsi_no_memory(context, TSI_COONS_STAGE);
  size_t most = (size_t)(a->curve.n[0] + b->curve.n[0] + 2 * degree + 2);
  double *to = tsi_arena_new(arena, most, sizeof *to);
  if (!to)
    return tsi_no_memory(context, TSI_COONS_STAGE);
  int n_to = unite_knots(&a->curve, &b->curve, to) - degree - 1;
  for (int k = 0; k < 2; k++) {
    tsi_patch *c = &pair[k]->curve;
    if (!same_knots(c, n_to, to)) {
      report->n_knots_inserted += n_to - c->n[0];
      pair[k]->refined = 1;
      if (!tsi_patch_refine(arena, c, 0, 0, n_to, to))
        return tsi_no_memory(context, TSI_COONS_STAGE);
    }
    if (pair[k]->refined && !divide_points(arena, pair[k]))
      return tsi_no_memory(context, TSI_COONS_STAGE);
  }
  return TSOLID_OK;
}

/* Every span halved, as often as it takes. */
static int halve_spans(tsi_arena *arena, const tsi_patch *c, int n_spans, int *n_to,
                       double **knots) {
  int n = c->n[0] + c->degree[0] + 1, spans = 0;
  double *to = c->knots[0];
  for (int i = 1; i < n; i++)
    spans += to[i] > to[i - 1];
  for (; spans < n_spans; spans *= 2) {
    double *next = tsi_arena_new(arena, (size_t)(n + spans), sizeof *next);
    int k = 0;
    if (!next)
      return 0;
    for (int i = 0; i < n; i++) {
      if (i && to[i] > to[i - 1])
        next[k++] = 0.5 * (to[i - 1] + to[i]);
      next[k++] = to[i];
    }
    to = next;
    n = k;
  }
  *n_to = n - c->degree[0] - 1;
  *knots = to;
  return 1;
}

tsolid_status tsi_borders_refine(tsolid_context *context, tsi_arena *arena, tsi_border *a,
                                 tsi_border *b, int degree, int n_spans, int *n_degrees,
                                 int *n_knots) {
  tsi_border *pair[2] = {a, b};
  int n_to, n_raised = 0;
  double *to;
  for (int k = 0; k < 2; k++)
    if (!raise_border(arena, pair[k], degree, &n_raised))
      return tsi_no_memory(context, TSI_COONS_STAGE);
  if (!halve_spans(arena, &a->curve, n_spans, &n_to, &to))
    return tsi_no_memory(context, TSI_COONS_STAGE);
  *n_degrees += n_raised / 2;
  *n_knots += n_to - a->curve.n[0];
  for (int k = 0; k < 2; k++) {
    pair[k]->refined = 1;
    if (!tsi_patch_refine(arena, &pair[k]->curve, 0, 0, n_to, to) || !divide_points(arena, pair[k]))
      return tsi_no_memory(context, TSI_COONS_STAGE);
  }
  return TSOLID_OK;
}

tsolid_status tsi_borders_read(tsolid_context *context, tsi_arena *arena,
                               const tsolid_curve border[4], const tsolid_coons_options *options,
                               tsi_border b[4], tsolid_coons_report *report) {
  tsolid_status status = TSOLID_OK;
  for (int k = 0; !status && k < 4; k++) {
    b[k] = (tsi_border){.refined = 0};
    name_border(&border[k], k, b[k].name);
    status = vet_curve(context, &border[k], b[k].name);
    if (!status)
      status = read_curve(context, arena, &border[k], &b[k]);
  }
  if (!status)
    status = join_corners(context, b, options->tolerance, report);
  if (!status)
    status = match_weights(context, arena, b, report);
  for (int k = 0; !status && k < 4; k++)
    if (!b[k].refined)
      multiply_points(&b[k]);
  if (!status)
    status = match_pair(context, arena, &b[0], &b[2], report);
  if (!status)
    status = match_pair(context, arena, &b[3], &b[1], report);
  return status;
}
