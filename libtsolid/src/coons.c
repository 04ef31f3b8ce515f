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
#include "quadrature.h"

static const double default_tolerance = 1e-7;
/* Coons weights below this part of the lightest border weight beside them are replaced. */
static const double lightest_inside = 0.05;
/* A border leg shorter than this part of the face gives no tangent. */
static const double shortest_leg = 1e-12;

struct tsolid_coons {
  tsi_allocator allocator;
  tsolid_patch patch;
  double *memory; /* knots, points, weights */
  char *text;     /* names */
};

typedef struct frame {
  double origin[3], axis[2][3], normal[3];
  double size; /* largest distance of a border control point from the origin */
} frame;

typedef struct work {
  tsolid_context *context;
  tsi_arena *arena;
  tsolid_coons_options options;
  tsolid_coons_report *report;
  char name[TSI_NAME_SIZE];
  tsi_border border[4];
  frame frame;
  tsi_planar planar;
  int singular; /* bits of corners */
} work;

/* ---- vectors --------------------------------------------------------------------------------- */

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double c[3]) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

static int normalise(double a[3]) {
  double length = sqrt(dot(a, a));
  if (!(length > 0.0) || !isfinite(length))
    return 0;
  for (int c = 0; c < 3; c++)
    a[c] /= length;
  return 1;
}

static void flatten(const frame *f, const double x[3], double flat[2]) {
  double d[3] = {x[0] - f->origin[0], x[1] - f->origin[1], x[2] - f->origin[2]};
  flat[0] = dot(d, f->axis[0]);
  flat[1] = dot(d, f->axis[1]);
}

static void place(const frame *f, const double flat[2], double x[3]) {
  for (int c = 0; c < 3; c++)
    x[c] = f->origin[c] + (flat[0] * f->axis[0][c] + flat[1] * f->axis[1][c]);
}

static tsolid_finding refusal_at(const double point[3]) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, TSI_COONS_STAGE);
  finding.has_point = 1;
  memcpy(finding.point, point, sizeof finding.point);
  return finding;
}

/* ---- the plane ------------------------------------------------------------------------------- */

/* One Jacobi rotation of the symmetric matrix a that makes a[p][q] zero; v collects rotations. */
static void rotate(double a[3][3], double v[3][3], int p, int q) {
  if (a[p][q] == 0.0)
    return;
  double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
  double t = (theta >= 0.0 ? 1.0 : -1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
  double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
  for (int k = 0; k < 3; k++) {
    double x = a[k][p], y = a[k][q];
    a[k][p] = c * x - s * y;
    a[k][q] = s * x + c * y;
  }
  for (int k = 0; k < 3; k++) {
    double x = a[p][k], y = a[q][k];
    a[p][k] = c * x - s * y;
    a[q][k] = s * x + c * y;
    x = v[k][p];
    y = v[k][q];
    v[k][p] = c * x - s * y;
    v[k][q] = s * x + c * y;
  }
}

/* The direction in which the border control points, relative to the origin, spread least. */
static void fit_normal(const work *w, double normal[3]) {
  double a[3][3] = {{0.0}}, v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, mean[3] = {0.0}, n = 0.0;
  for (int pass = 0; pass < 2; pass++) {
    for (int k = 0; k < 4; k++)
      for (int i = 0; i < w->border[k].curve.n[0]; i++) {
        double d[3];
        for (int c = 0; c < 3; c++)
          d[c] = (w->border[k].point[3 * i + c] - w->frame.origin[c]) / w->frame.size - mean[c];
        for (int c = 0; c < 3; c++)
          for (int e = 0; e < 3; e++)
            a[c][e] += pass ? d[c] * d[e] : 0.0;
        for (int c = 0; c < 3 && !pass; c++)
          normal[c] = (i || k ? normal[c] : 0.0) + d[c];
        n += !pass;
      }
    for (int c = 0; c < 3; c++)
      mean[c] = normal[c] / n;
  }
  for (int sweep = 0; sweep < 12; sweep++) {
    rotate(a, v, 0, 1);
    rotate(a, v, 0, 2);
    rotate(a, v, 1, 2);
  }
  int least = a[0][0] <= a[1][1] ? 0 : 1;
  least = a[2][2] < a[least][least] ? 2 : least;
  for (int c = 0; c < 3; c++)
    normal[c] = v[c][least];
}

/* The middle of the borders' bounding box; the size. */
static tsolid_status find_middle(work *w) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  frame *f = &w->frame;
  for (int k = 0; k < 4; k++)
    for (int i = 0; i < 3 * w->border[k].curve.n[0]; i++) {
      low[i % 3] = fmin(low[i % 3], w->border[k].point[i]);
      high[i % 3] = fmax(high[i % 3], w->border[k].point[i]);
    }
  f->size = 0.0;
  for (int c = 0; c < 3; c++) {
    f->origin[c] = low[c] == high[c] ? low[c] : 0.5 * low[c] + 0.5 * high[c];
    f->size = hypot(f->size, 0.5 * (high[c] - low[c]));
  }
  if (!(f->size > 0.0))
    return tsi_fail(w->context, TSOLID_ERROR_REFUSED, TSI_COONS_STAGE,
                    "The four borders of %s are one point", w->name);
  return TSOLID_OK;
}

/* Axes of the plane: of two coordinate directions, for a plane across the third. */
static void find_axes(frame *f) {
  int a = 0;
  for (int c = 1; c < 3; c++)
    if (fabs(f->normal[c]) < fabs(f->normal[a]))
      a = c;
  for (int c = 0; c < 3; c++)
    f->axis[0][c] = (c == a ? 1.0 : 0.0) - f->normal[a] * f->normal[c];
  (void)normalise(f->axis[0]);
  cross(f->normal, f->axis[0], f->axis[1]);
}

/* Moves the origin along the normal to the middle of the control points; the farthest of them. */
static tsolid_status check_plane(work *w) {
  frame *f = &w->frame;
  double low = INFINITY, high = -INFINITY, worst = -1.0, at[3] = {0.0, 0.0, 0.0};
  int worst_border = 0;
  for (int pass = 0; pass < 2; pass++) {
    for (int k = 0; k < 4; k++)
      for (int i = 0; i < w->border[k].curve.n[0]; i++) {
        const double *x = w->border[k].point + 3 * (ptrdiff_t)i;
        double d[3] = {x[0] - f->origin[0], x[1] - f->origin[1], x[2] - f->origin[2]};
        double h = dot(d, f->normal);
        low = fmin(low, h);
        high = fmax(high, h);
        if (pass && fabs(h) > worst) {
          worst = fabs(h);
          memcpy(at, x, sizeof at);
          worst_border = k;
        }
      }
    for (int c = 0; c < 3 && !pass; c++)
      f->origin[c] += 0.5 * (low + high) * f->normal[c];
  }
  w->report->plane_distance = worst;
  memcpy(w->report->origin, f->origin, sizeof f->origin);
  if (worst <= w->options.tolerance)
    return TSOLID_OK;
  tsolid_finding finding = refusal_at(at);
  finding.measured = worst;
  finding.allowed = w->options.tolerance;
  return tsi_report(w->context, &finding,
                    "%s is not planar: %s is up to %.6g away from the plane that fits best",
                    w->name, w->border[worst_border].name, worst);
}

/* Twice the area swept by a border seen from the origin: integral of x dy - y dx. */
static double sweep_area(const work *w, int k) {
  const tsi_patch *c = &w->border[k].curve;
  double node[TSI_MAX_GAUSS], weight[TSI_MAX_GAUSS], flat[2], area = 0.0;
  double value[TSI_MAX_ORDER], slope[TSI_MAX_ORDER];
  int p = c->degree[0], n_gauss = p + 12;
  tsi_gauss(n_gauss, node, weight);
  for (int s = p; s < c->n[0]; s++)
    for (int q = 0; q < n_gauss && c->knots[0][s] < c->knots[0][s + 1]; q++) {
      double t0 = c->knots[0][s], dt = c->knots[0][s + 1] - t0, h[3] = {0.0}, d[3] = {0.0};
      int first = tsi_bspline_basis(p, c->n[0], c->knots[0], t0 + node[q] * dt, value, slope);
      for (int i = 0; i <= p; i++) {
        double weight_i = c->control[4 * (first + i) + 3];
        flatten(&w->frame, w->border[k].point + 3 * (ptrdiff_t)(first + i), flat);
        const double x[3] = {weight_i * flat[0], weight_i * flat[1], weight_i};
        for (int e = 0; e < 3; e++) {
          h[e] += value[i] * x[e];
          d[e] += slope[i] * x[e];
        }
      }
      area += weight[q] * dt * (h[0] * d[1] - h[1] * d[0]) / (h[2] * h[2]);
    }
  return area;
}

/* The normal is given or fitted; its sign is that of the loop. */
static tsolid_status find_plane(work *w) {
  frame *f = &w->frame;
  tsolid_status status = find_middle(w);
  if (status)
    return status;
  memcpy(f->normal, w->options.normal, sizeof f->normal);
  if (f->normal[0] == 0.0 && f->normal[1] == 0.0 && f->normal[2] == 0.0)
    fit_normal(w, f->normal);
  if (!normalise(f->normal))
    return tsi_fail(w->context, TSOLID_ERROR_ARGUMENT, TSI_COONS_STAGE,
                    "The normal (%g, %g, %g) has no direction", w->options.normal[0],
                    w->options.normal[1], w->options.normal[2]);
  status = check_plane(w);
  if (status)
    return status;
  find_axes(f);
  double area = 0.5 * (sweep_area(w, 0) + sweep_area(w, 1) - sweep_area(w, 2) - sweep_area(w, 3));
  w->report->area = fabs(area);
  if (area < 0.0) {
    for (int c = 0; c < 3; c++)
      f->normal[c] = 0.0 - f->normal[c];
    find_axes(f);
  }
  memcpy(w->report->normal, f->normal, sizeof f->normal);
  if (!(fabs(area) > 1e-14 * f->size * f->size))
    return tsi_fail(w->context, TSOLID_ERROR_REFUSED, TSI_COONS_STAGE,
                    "The four borders of %s enclose no area", w->name);
  return TSOLID_OK;
}

/* ---- corners and kinks ----------------------------------------------------------------------- */

/* Unit tangent in the direction of the parameter beside control point i, towards i + step. */
static int find_tangent(const work *w, int k, int i, int step, double t[2]) {
  double a[2], b[2];
  flatten(&w->frame, w->border[k].point + 3 * (ptrdiff_t)i, a);
  flatten(&w->frame, w->border[k].point + 3 * (ptrdiff_t)(i + step), b);
  double d[2] = {step * (b[0] - a[0]), step * (b[1] - a[1])}, length = hypot(d[0], d[1]);
  t[0] = d[0] / length;
  t[1] = d[1] / length;
  return length > shortest_leg * w->frame.size;
}

static const char *name_corner(const work *w, int k) {
  static const char *const word[4] = {"its corner (0,0)", "its corner (1,0)", "its corner (1,1)",
                                      "its corner (0,1)"};
  const char *own = w->options.corner_name[k];
  return own && *own ? own : word[k];
}

static const double *corner_point(const work *w, int k) {
  const tsi_border *along = &w->border[tsi_corner_border(k, 0)];
  return along->point + 3 * (ptrdiff_t)(tsi_corner_end(k, 0) ? along->curve.n[0] - 1 : 0);
}

static tsolid_status check_corner(work *w, int k) {
  const double pi = 3.14159265358979323846;
  double t[2][2];
  tsolid_finding finding = refusal_at(corner_point(w, k));
  for (int d = 0; d < 2; d++) {
    int b = tsi_corner_border(k, d), high = tsi_corner_end(k, d);
    if (!find_tangent(w, b, high ? w->border[b].curve.n[0] - 1 : 0, high ? -1 : 1, t[d]))
      return tsi_report(w->context, &finding,
                        "%s has no direction at %s of %s: its control points coincide there",
                        w->border[b].name, name_corner(w, k), w->name);
  }
  double sine = t[0][0] * t[1][1] - t[0][1] * t[1][0];
  double cosine = (k & 1 ? -1.0 : 1.0) * (t[0][0] * t[1][0] + t[0][1] * t[1][1]);
  if (fabs(sine) <= TSI_SINGULAR_TOLERANCE) {
    tsolid_coons_report *r = w->report;
    memcpy(r->singular[r->n_singular++], finding.point, sizeof finding.point);
    w->singular |= 1 << k;
    return TSOLID_OK;
  }
  w->report->bound = fmin(w->report->bound, sine);
  if (sine > 0.0)
    return TSOLID_OK;
  finding.measured = 360.0 + atan2(sine, cosine) * 180.0 / pi;
  finding.allowed = 180.0;
  return tsi_report(w->context, &finding,
                    "%s has an angle of %.6g degrees at %s, where %s and %s meet: a patch that "
                    "does not fold needs less than 180 there. Choose other corners, or split the "
                    "face",
                    w->name, finding.measured, name_corner(w, k),
                    w->border[tsi_corner_border(k, 0)].name,
                    w->border[tsi_corner_border(k, 1)].name);
}

/* Where a border may turn suddenly: at inner knots that stand as often as the degree. */
static tsolid_status check_kinks(work *w, int k) {
  const tsi_patch *c = &w->border[k].curve;
  int p = c->degree[0];
  for (int i = p + 1; i < c->n[0]; i++) {
    double low[2], high[2];
    if (c->knots[0][i] != c->knots[0][i + p - 1] || c->knots[0][i] == c->knots[0][i - 1])
      continue;
    int at = i - 1; /* the control point on the curve */
    tsolid_finding finding = refusal_at(w->border[k].point + 3 * (ptrdiff_t)at);
    if (!find_tangent(w, k, at, -1, low) || !find_tangent(w, k, at, 1, high))
      continue;
    double half_turn = 0.5 * hypot(low[0] + high[0], low[1] + high[1]); /* its cosine */
    w->report->bound = fmin(w->report->bound, half_turn);
    if (half_turn <= TSI_SINGULAR_TOLERANCE)
      return tsi_report(w->context, &finding, "%s turns back on itself", w->border[k].name);
  }
  return TSOLID_OK;
}

/* ---- the Coons patch ------------------------------------------------------------------------- */

static double greville(const tsi_planar *p, int d, int i) {
  double sum = 0.0;
  for (int k = 1; k <= p->degree[d]; k++)
    sum += p->knots[d][i + k];
  return sum / p->degree[d];
}

static int allocate_planar(work *w) {
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
static void fill_border(work *w, int k) {
  tsi_planar *p = &w->planar;
  const tsi_border *b = &w->border[k];
  int across = k & 1, n = p->n[across];
  ptrdiff_t stride = across ? p->n[0] : 1;
  ptrdiff_t first = k == 1 ? p->n[0] - 1 : k == 2 ? (ptrdiff_t)p->n[0] * (p->n[1] - 1) : 0;
  for (int i = 0; i < n; i++) {
    ptrdiff_t row = first + i * stride;
    if (across && (i == 0 || i == n - 1))
      continue;
    flatten(&w->frame, b->point + 3 * (ptrdiff_t)i, p->point + 2 * row);
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
      combine(p, i, j, greville(p, 0, i), greville(p, 1, j), logarithmic, h);
      if (!logarithmic && !(h[2] > lightest_inside * lightest_beside(p, i, j)))
        return 0;
      p->weight[row] = logarithmic ? exp(h[2]) : h[2];
      p->point[2 * row] = logarithmic ? h[0] : h[0] / h[2];
      p->point[2 * row + 1] = logarithmic ? h[1] : h[1] / h[2];
    }
  return 1;
}

static tsolid_status make_coons(work *w) {
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
static tsolid_status make_patch(work *w, const tsolid_curve border[4], tsolid_coons **coons) {
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
        place(&w->frame, p->point + 2 * row, point + 3 * row);
      flatten(&w->frame, point + 3 * row, p->point + 2 * row);
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

static tsolid_status certify(work *w, tsi_planar_outcome *outcome) {
  double largest = 0.0;
  for (size_t i = 0; i < 2 * (size_t)w->planar.n[0] * (size_t)w->planar.n[1]; i++)
    largest = fmax(largest, fabs(w->planar.point[i]));
  /* three differences and products, and their sum, for a point at most sqrt(2) largest away; the
   * part across the plane is below the tolerance */
  double error = 32.0 * TSI_ROUND_OFF * (largest + w->report->plane_distance);
  tsolid_status status = tsi_planar_certify(w->context, &w->planar, w->singular, error, outcome);
  w->report->n_elements = outcome->n_elements;
  w->report->depth = outcome->depth;
  return status;
}

static void evaluate(const work *w, const double u[2], double x[3]) {
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
  place(&w->frame, flat, x);
}

static tsolid_status refuse_fold(work *w, const tsi_planar_outcome *outcome) {
  double x[3];
  evaluate(w, outcome->u, x);
  tsolid_finding finding = refusal_at(x);
  const char *tried = w->report->repaired ? ", also with control points moved inside" : "";
  if (outcome->verdict == TSOLID_NOT_POSITIVE)
    return tsi_report(w->context, &finding,
                      "The patch between the four borders of %s folds near (%.6g, %.6g, %.6g)%s. "
                      "Split the face, or choose other corners",
                      w->name, x[0], x[1], x[2], tried);
  return tsi_report(w->context, &finding,
                    "The patch between the four borders of %s cannot be proved not to fold near "
                    "(%.6g, %.6g, %.6g)%s",
                    w->name, x[0], x[1], x[2], tried);
}

static void note_singular(const work *w) {
  for (int k = 0; k < 4; k++) {
    if (!(w->singular >> k & 1))
      continue;
    tsolid_finding finding = refusal_at(corner_point(w, k));
    finding.severity = TSOLID_NOTE;
    finding.status = TSOLID_OK;
    tsi_report(w->context, &finding,
               "At %s of %s the two borders are tangent: det J is zero at this point, and proved "
               "positive beside it",
               name_corner(w, k), w->name);
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

static tsolid_status check_options(work *w, const tsolid_coons_options *options) {
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

static tsolid_status check_corners(work *w) {
  tsolid_status status = TSOLID_OK;
  for (int k = 0; !status && k < 4; k++)
    status = check_corner(w, k);
  for (int k = 0; !status && k < 4; k++)
    status = check_kinks(w, k);
  return status;
}

static tsolid_status run(work *w, const tsolid_curve border[4], tsolid_coons **coons) {
  tsi_planar_outcome outcome;
  tsolid_status status =
      tsi_borders_read(w->context, w->arena, border, &w->options, w->border, w->report);
  if (!status)
    status = find_plane(w);
  if (!status)
    status = check_corners(w);
  if (!status)
    status = make_coons(w);
  if (!status)
    status = make_patch(w, border, coons);
  if (!status)
    status = certify(w, &outcome);
  if (!status && outcome.verdict != TSOLID_POSITIVE)
    status = refuse_fold(w, &outcome);
  if (!status)
    note_singular(w);
  return status;
}

tsolid_status tsolid_coons_create(tsolid_context *context, const tsolid_curve border[4],
                                  const tsolid_coons_options *options, tsolid_coons_report *report,
                                  tsolid_coons **coons) {
  tsolid_coons_report own;
  if (!context || !border || !coons)
    return TSOLID_ERROR_ARGUMENT;
  *coons = NULL;
  work w = {.context = context, .report = report ? report : &own};
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
