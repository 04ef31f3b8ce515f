/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The plane of four borders, and what their corners allow.
 *
 * The plane through the middle of the border control points has the direction in which they spread
 * least (the eigenvector of their covariance, by Jacobi rotations: exact where a coordinate is the
 * same for all points) or the given one. All control points must be near it: a spline is as near as
 * its control points are.
 *
 * At a corner both borders fix x_u and x_v, so their angle must be between 0 and 180 degrees; where
 * it is one of these two, det J = 0 there whatever is inside. At a kink of a border, with unit
 * tangents a and b, the derivative across is one vector for both sides: no patch has there a better
 * scaled Jacobian than |a + b| / 2, the cosine of half the turn. */
#include "boundary_bound.h"
#include "bspline.h"
#include "coons.h"
#include "quadrature.h"

/* A border leg shorter than this part of the face gives no tangent. */
static const double shortest_leg = 1e-12;

/* ---- vectors --------------------------------------------------------------------------------- */

static int normalise(double a[3]) {
  double length = sqrt(tsi_dot3(a, a));
  if (!(length > 0.0) || !isfinite(length))
    return 0;
  for (int c = 0; c < 3; c++)
    a[c] /= length;
  return 1;
}

void tsi_frame_flatten(const tsi_frame *f, const double x[3], double flat[2]) {
  double d[3] = {x[0] - f->origin[0], x[1] - f->origin[1], x[2] - f->origin[2]};
  flat[0] = tsi_dot3(d, f->axis[0]);
  flat[1] = tsi_dot3(d, f->axis[1]);
}

void tsi_frame_place(const tsi_frame *f, const double flat[2], double x[3]) {
  for (int c = 0; c < 3; c++)
    x[c] = f->origin[c] + (flat[0] * f->axis[0][c] + flat[1] * f->axis[1][c]);
}

tsolid_finding tsi_coons_finding(const double point[3]) {
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
static void fit_normal(const tsi_coons_work *w, double normal[3]) {
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
static tsolid_status find_middle(tsi_coons_work *w) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  tsi_frame *f = &w->frame;
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
static void find_axes(tsi_frame *f) {
  int a = 0;
  for (int c = 1; c < 3; c++)
    if (fabs(f->normal[c]) < fabs(f->normal[a]))
      a = c;
  for (int c = 0; c < 3; c++)
    f->axis[0][c] = (c == a ? 1.0 : 0.0) - f->normal[a] * f->normal[c];
  (void)normalise(f->axis[0]);
  tsi_cross3(f->normal, f->axis[0], f->axis[1]);
}

/* Moves the origin along the normal to the middle of the control points; the farthest of them. */
static tsolid_status check_plane(tsi_coons_work *w) {
  tsi_frame *f = &w->frame;
  double low = INFINITY, high = -INFINITY, worst = -1.0, at[3] = {0.0, 0.0, 0.0};
  int worst_border = 0;
  for (int pass = 0; pass < 2; pass++) {
    for (int k = 0; k < 4; k++)
      for (int i = 0; i < w->border[k].curve.n[0]; i++) {
        const double *x = w->border[k].point + 3 * (ptrdiff_t)i;
        double d[3] = {x[0] - f->origin[0], x[1] - f->origin[1], x[2] - f->origin[2]};
        double h = tsi_dot3(d, f->normal);
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
  tsolid_finding finding = tsi_coons_finding(at);
  finding.measured = worst;
  finding.allowed = w->options.tolerance;
  return tsi_report(w->context, &finding,
                    "%s is not planar: %s is up to %.6g away from the plane that fits best",
                    w->name, w->border[worst_border].name, worst);
}

/* Twice the area swept by a border seen from the origin: integral of x dy - y dx. */
static double sweep_area(const tsi_coons_work *w, int k) {
  const tsi_patch *c = &w->border[k].curve;
  double node[TSI_MAX_GAUSS], weight[TSI_MAX_GAUSS], flat[2], area = 0.0;
  double value[TSI_MAX_ORDER], slope[TSI_MAX_ORDER];
  int p = c->degree[0], n_gauss = p + 30;
  tsi_gauss(n_gauss, node, weight);
  for (int s = p; s < c->n[0]; s++)
    for (int q = 0; q < n_gauss && c->knots[0][s] < c->knots[0][s + 1]; q++) {
      double t0 = c->knots[0][s], dt = c->knots[0][s + 1] - t0, h[3] = {0.0}, d[3] = {0.0};
      int first = tsi_bspline_basis(p, c->n[0], c->knots[0], t0 + node[q] * dt, value, slope);
      for (int i = 0; i <= p; i++) {
        double weight_i = c->control[4 * (first + i) + 3];
        tsi_frame_flatten(&w->frame, w->border[k].point + 3 * (ptrdiff_t)(first + i), flat);
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
tsolid_status tsi_coons_find_plane(tsi_coons_work *w) {
  tsi_frame *f = &w->frame;
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

/* Of the coordinates as they are in space. */
double tsi_coons_scale(const tsi_coons_work *w) {
  double far = 0.0;
  for (int c = 0; c < 3; c++)
    far = fmax(far, fabs(w->frame.origin[c]));
  return far + w->frame.size;
}

/* Unit tangent in the direction of the parameter beside control point i, towards i + step; the
 * distance of the two points, 0 where it is too small. */
static double find_tangent(const tsi_coons_work *w, int k, int i, int step, double t[2]) {
  double a[2], b[2];
  tsi_frame_flatten(&w->frame, w->border[k].point + 3 * (ptrdiff_t)i, a);
  tsi_frame_flatten(&w->frame, w->border[k].point + 3 * (ptrdiff_t)(i + step), b);
  double d[2] = {step * (b[0] - a[0]), step * (b[1] - a[1])}, length = hypot(d[0], d[1]);
  t[0] = d[0] / length;
  t[1] = d[1] / length;
  return length > shortest_leg * w->frame.size ? length : 0.0;
}

const char *tsi_coons_corner_name(const tsi_coons_work *w, int k) {
  static const char *const word[4] = {"its corner (0,0)", "its corner (1,0)", "its corner (1,1)",
                                      "its corner (0,1)"};
  const char *own = w->options.corner_name[k];
  return own && *own ? own : word[k];
}

const double *tsi_coons_corner_point(const tsi_coons_work *w, int k) {
  const tsi_border *along = &w->border[tsi_corner_border(k, 0)];
  return along->point + 3 * (ptrdiff_t)(tsi_corner_end(k, 0) ? along->curve.n[0] - 1 : 0);
}

static tsolid_status check_corner(tsi_coons_work *w, int k) {
  const double pi = 3.14159265358979323846;
  double t[2][2], leg[2];
  tsolid_finding finding = tsi_coons_finding(tsi_coons_corner_point(w, k));
  for (int d = 0; d < 2; d++) {
    int b = tsi_corner_border(k, d), high = tsi_corner_end(k, d);
    leg[d] = find_tangent(w, b, high ? w->border[b].curve.n[0] - 1 : 0, high ? -1 : 1, t[d]);
    if (!(leg[d] > 0.0))
      return tsi_report(w->context, &finding,
                        "%s has no direction at %s of %s: its control points coincide there",
                        w->border[b].name, tsi_coons_corner_name(w, k), w->name);
  }
  double sine = t[0][0] * t[1][1] - t[0][1] * t[1][0];
  double cosine = (k & 1 ? -1.0 : 1.0) * (t[0][0] * t[1][0] + t[0][1] * t[1][1]);
  if (fabs(sine) <= tsi_singular_tolerance(tsi_coons_scale(w), fmin(leg[0], leg[1]))) {
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
                    w->name, finding.measured, tsi_coons_corner_name(w, k),
                    w->border[tsi_corner_border(k, 0)].name,
                    w->border[tsi_corner_border(k, 1)].name);
}

/* Where a border may turn suddenly: at inner knots that stand as often as the degree. */
static tsolid_status check_kinks(tsi_coons_work *w, int k) {
  const tsi_patch *c = &w->border[k].curve;
  int p = c->degree[0];
  for (int i = p + 1; i < c->n[0]; i++) {
    double low[2], high[2];
    if (c->knots[0][i] != c->knots[0][i + p - 1] || c->knots[0][i] == c->knots[0][i - 1])
      continue;
    int at = i - 1; /* the control point on the curve */
    tsolid_finding finding = tsi_coons_finding(w->border[k].point + 3 * (ptrdiff_t)at);
    if (!(find_tangent(w, k, at, -1, low) > 0.0) || !(find_tangent(w, k, at, 1, high) > 0.0))
      continue;
    double half_turn = 0.5 * hypot(low[0] + high[0], low[1] + high[1]); /* its cosine */
    w->report->bound = fmin(w->report->bound, half_turn);
    if (half_turn <= TSI_SINGULAR_TOLERANCE)
      return tsi_report(w->context, &finding, "%s turns back on itself", w->border[k].name);
  }
  return TSOLID_OK;
}

tsolid_status tsi_coons_check_corners(tsi_coons_work *w) {
  tsolid_status status = TSOLID_OK;
  for (int k = 0; !status && k < 4; k++)
    status = check_corner(w, k);
  for (int k = 0; !status && k < 4; k++)
    status = check_kinks(w, k);
  return status;
}
