/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stdio.h>

#include "bspline.h"
#include "vector.h"
#include "patch.h"

static const char stage[] = "boundary";

/* Knots closer than this part of the range are one (STEP files keep 12 digits). */
static const double knot_resolution = 1e-11;
/* Bounds that keep squares and products of control points finite. */
static const double largest_coordinate = 1e100, largest_weight = 1e50;

const char *tsi_name_patch(const char *name, int k, char text[TSI_NAME_SIZE]) {
  if (!name || !*name) {
    snprintf(text, TSI_NAME_SIZE, "patch %d", k);
    return text;
  }
  snprintf(text, TSI_NAME_SIZE, "%s", name);
  for (char *c = text; *c; c++)
    if ((unsigned char)*c < 32)
      *c = ' ';
  return text;
}

/* ---- vetting --------------------------------------------------------------------------------- */

static tsolid_finding patch_finding(int k) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
  finding.entity = TSOLID_ENTITY_PATCH;
  finding.index[0] = k;
  return finding;
}

static tsolid_status vet_sizes(tsolid_context *context, const tsolid_patch *patch, int k,
                               const char *name) {
  tsolid_finding finding = patch_finding(k);
  for (int d = 0; d < 2; d++) {
    finding.measured = patch->degree[d];
    finding.allowed = TSI_MAX_DEGREE;
    if (patch->degree[d] < 1 || patch->degree[d] > TSI_MAX_DEGREE)
      return tsi_report(context, &finding, "%s has degree %d in %c, not one of 1 to %d", name,
                        patch->degree[d], 'u' + d, (int)TSI_MAX_DEGREE);
    finding.measured = patch->n_control[d];
    finding.allowed = patch->degree[d] + 1;
    if (patch->n_control[d] < patch->degree[d] + 1)
      return tsi_report(context, &finding,
                        "%s has %d control points in %c, degree %d needs at least %d", name,
                        patch->n_control[d], 'u' + d, patch->degree[d], patch->degree[d] + 1);
  }
  finding.measured = (double)patch->n_control[0] * patch->n_control[1];
  finding.allowed = TSI_MAX_COUNT / 16;
  if (finding.measured > finding.allowed)
    return tsi_report(context, &finding, "%s has too many control points: %d x %d", name,
                      patch->n_control[0], patch->n_control[1]);
  if (!patch->knots[0] || !patch->knots[1] || !patch->points)
    return tsi_report(context, &finding, "%s has no knots or no control points", name);
  return TSOLID_OK;
}

static tsolid_status vet_knots(tsolid_context *context, const tsolid_patch *patch, int k, int d,
                               const char *name) {
  tsolid_finding finding = patch_finding(k);
  const double *knots = patch->knots[d];
  int p = patch->degree[d], n = patch->n_control[d], c = 'u' + d;
  for (int i = 0; i < n + p + 1; i++) {
    if (!isfinite(knots[i]))
      return tsi_report(context, &finding, "%s: knot %d in %c is not a finite number", name, i, c);
    if (i && knots[i] < knots[i - 1])
      return tsi_report(context, &finding, "%s: the knots in %c decrease at knot %d (%.17g, %.17g)",
                        name, c, i, knots[i - 1], knots[i]);
  }
  double first = knots[0], last = knots[n + p], range = last - first;
  if (!(range > 0.0) || !isfinite(range))
    return tsi_report(context, &finding, "%s: the knots in %c span no finite interval", name, c);
  if (knots[p] != first || knots[n] != last)
    return tsi_report(context, &finding,
                      "%s: the knots in %c are not clamped: the first and the last must each stand "
                      "%d times",
                      name, c, p + 1);
  for (int i = p + 1; i < n; i++) {
    double x = (knots[i] - first) / range;
    if (!(x > knot_resolution && x < 1.0 - knot_resolution))
      return tsi_report(context, &finding,
                        "%s: knot %d in %c lies on the end of the range, or too near to it", name,
                        i, c);
    if (i + p < n && knots[i + p] == knots[i])
      return tsi_report(context, &finding,
                        "%s: knot %d in %c stands more than %d times, the surface is torn there",
                        name, i, c, p);
  }
  return TSOLID_OK;
}

static tsolid_status vet_points(tsolid_context *context, const tsolid_patch *patch, int k,
                                const char *name) {
  size_t n = (size_t)patch->n_control[0] * (size_t)patch->n_control[1];
  for (size_t i = 0; i < n; i++) {
    tsolid_finding finding = patch_finding(k);
    int column = (int)(i % (size_t)patch->n_control[0]),
        row = (int)(i / (size_t)patch->n_control[0]);
    const double *point = patch->points + 3 * i;
    for (int c = 0; c < 3; c++)
      if (!(fabs(point[c]) <= largest_coordinate))
        return tsi_report(context, &finding,
                          "%s: control point (%d, %d) is not finite or too large", name, column,
                          row);
    if (!patch->weights)
      continue;
    double w = patch->weights[i];
    finding.has_point = 1;
    memcpy(finding.point, point, sizeof finding.point);
    finding.measured = w;
    finding.allowed = 0.0;
    if (!(w > 0.0) || !(w <= largest_weight) || !(w >= 1.0 / largest_weight))
      return tsi_report(context, &finding,
                        "%s: the weight of control point (%d, %d) is %g, it must be positive and "
                        "finite",
                        name, column, row, w);
  }
  return TSOLID_OK;
}

tsolid_status tsi_patch_vet(tsolid_context *context, const tsolid_patch *patch, int k) {
  char name[TSI_NAME_SIZE];
  tsi_name_patch(patch->name, k, name);
  tsolid_status status = vet_sizes(context, patch, k, name);
  for (int d = 0; !status && d < 2; d++)
    status = vet_knots(context, patch, k, d, name);
  if (!status)
    status = vet_points(context, patch, k, name);
  for (int b = 0; !status && b < 4; b++) {
    double tolerance = patch->border_tolerance[b];
    tsolid_finding finding = patch_finding(k);
    finding.entity = TSOLID_ENTITY_BORDER;
    finding.index[1] = b;
    if (!(tolerance >= 0.0) || !isfinite(tolerance))
      status =
          tsi_report(context, &finding,
                     "%s: the tolerance of border %d is %g, it must be finite and not negative",
                     name, b, tolerance);
  }
  return status;
}

/* ---- reading and orienting ------------------------------------------------------------------- */

static int allocate_patch(tsi_arena *arena, tsi_patch *patch) {
  size_t n = (size_t)patch->n[0] * (size_t)patch->n[1];
  for (int d = 0; d < 2; d++) {
    patch->knots[d] =
        tsi_arena_new(arena, (size_t)(patch->n[d] + patch->degree[d] + 1), sizeof(double));
    if (!patch->knots[d])
      return 0;
  }
  patch->control = tsi_arena_new(arena, n, 4 * sizeof(double));
  return patch->control != NULL;
}

int tsi_patch_read(tsi_arena *arena, const tsolid_patch *source, tsi_patch *patch) {
  for (int d = 0; d < 2; d++) {
    patch->degree[d] = source->degree[d];
    patch->n[d] = source->n_control[d];
  }
  if (!allocate_patch(arena, patch))
    return 0;
  for (int d = 0; d < 2; d++)
    tsi_knots_normalise(patch->n[d] + patch->degree[d] + 1, source->knots[d], patch->knots[d]);
  size_t n = (size_t)patch->n[0] * (size_t)patch->n[1];
  for (size_t i = 0; i < n; i++) {
    double w = source->weights ? source->weights[i] : 1.0;
    for (size_t c = 0; c < 3; c++)
      patch->control[4 * i + c] = w * source->points[3 * i + c] + 0.0; /* no -0 */
    patch->control[4 * i + 3] = w;
  }
  return 1;
}

int tsi_patch_orient(tsi_arena *arena, const tsi_patch *from, const int flip[2], int swap,
                     tsi_patch *patch) {
  for (int d = 0; d < 2; d++) {
    int e = swap ? 1 - d : d;
    patch->degree[e] = from->degree[d];
    patch->n[e] = from->n[d];
  }
  if (!allocate_patch(arena, patch))
    return 0;
  for (int d = 0; d < 2; d++) {
    int e = swap ? 1 - d : d, n_knots = from->n[d] + from->degree[d] + 1;
    memcpy(patch->knots[e], from->knots[d], (size_t)n_knots * sizeof(double));
    if (flip[d])
      tsi_knots_reverse(n_knots, patch->knots[e]);
  }
  for (int j = 0; j < from->n[1]; j++)
    for (int i = 0; i < from->n[0]; i++) {
      int u = flip[0] ? from->n[0] - 1 - i : i, v = flip[1] ? from->n[1] - 1 - j : j;
      size_t to = swap ? (size_t)v + (size_t)patch->n[0] * (size_t)u
                       : (size_t)u + (size_t)patch->n[0] * (size_t)v;
      size_t at = (size_t)i + (size_t)from->n[0] * (size_t)j;
      memcpy(patch->control + 4 * to, from->control + 4 * at, 4 * sizeof(double));
    }
  return 1;
}

/* ---- refinement ------------------------------------------------------------------------------ */

/* A copy of the net with room for n_to rows along `along`; all other values as they were. */
static double *widen_net(tsi_arena *arena, const tsi_patch *patch, int along, int n_to) {
  size_t n[2] = {(size_t)patch->n[0], (size_t)patch->n[1]};
  n[along] = (size_t)n_to;
  double *control = tsi_arena_new(arena, n[0] * n[1], 4 * sizeof *control);
  if (!control)
    return NULL;
  for (int j = 0; j < patch->n[1]; j++)
    memcpy(control + 4 * n[0] * (size_t)j, patch->control + 4 * (size_t)patch->n[0] * (size_t)j,
           4 * (size_t)patch->n[0] * sizeof *control);
  return control;
}

/* One degree more along `along`: times the linear function from factor[0] to factor[1], or as it
 * is for NULL. `out` gets arrays of its own, but for the knots across. */
static int elevate(tsi_arena *arena, const tsi_patch *patch, int along, const double *factor,
                   tsi_patch *out) {
  int degree = patch->degree[along], n = patch->n[along];
  int n_to = tsi_knots_raise(degree, n, patch->knots[along], NULL);
  int components = along ? 4 * patch->n[0] : 4, n_rows = along ? 1 : patch->n[1];
  double *to = tsi_arena_new(arena, (size_t)(n_to + degree + 2), sizeof *to);
  double *work =
      tsi_arena_new(arena, tsi_bspline_raise_work(degree, n_to, components), sizeof *work);
  double *control = widen_net(arena, patch, along, n_to);
  if (!to || !work || !control)
    return 0;
  tsi_knots_raise(degree, n, patch->knots[along], to);
  for (int j = 0; j < n_rows; j++) {
    const double *from = patch->control + 4 * (size_t)n * (size_t)j;
    double *target = control + 4 * (size_t)n_to * (size_t)j;
    if (factor)
      tsi_bspline_multiply(degree, n, patch->knots[along], factor[0], factor[1], n_to, to,
                           components, from, target, work);
    else
      tsi_bspline_raise(degree, n, patch->knots[along], n_to, to, components, from, target, work);
  }
  *out = *patch;
  out->degree[along]++;
  out->n[along] = n_to;
  out->knots[along] = to;
  out->control = control;
  return 1;
}

int tsi_patch_refine(tsi_arena *arena, tsi_patch *patch, int along, int raise, int n_to,
                     const double *to) {
  for (int r = 0; r < raise; r++)
    if (!elevate(arena, patch, along, NULL, patch))
      return 0;
  int degree = patch->degree[along], n = patch->n[along];
  size_t n_knots = (size_t)(n_to + degree + 1);
  double *control = widen_net(arena, patch, along, n_to);
  double *knots = tsi_arena_new(arena, n_knots, sizeof *knots);
  if (!control || !knots)
    return 0;
  memcpy(knots, to, n_knots * sizeof *knots);
  if (along)
    tsi_bspline_insert(degree, n, patch->knots[1], n_to, to, 4 * patch->n[0], control);
  else
    for (int j = 0; j < patch->n[1]; j++)
      tsi_bspline_insert(degree, n, patch->knots[0], n_to, to, 4,
                         control + 4 * (size_t)n_to * (size_t)j);
  patch->n[along] = n_to;
  patch->knots[along] = knots;
  patch->control = control;
  return 1;
}

/* ---- the same surface, otherwise ---------------------------------------------------------------
 */

int tsi_patch_multiply(tsi_arena *arena, tsi_patch *patch, const double corner[4], int *n_raised) {
  static const double fall[2] = {1.0, 0.0}, rise[2] = {0.0, 1.0};
  double low[2] = {corner[0], corner[1]}, high[2] = {corner[2], corner[3]};
  double across[2] = {corner[0], corner[2]};
  int varies[2] = {corner[0] != corner[1] || corner[2] != corner[3],
                   corner[0] != corner[2] || corner[1] != corner[3]};
  tsi_patch at_low, at_high;
  *n_raised = varies[0] + varies[1];
  if (!varies[0])
    return elevate(arena, patch, 1, across, patch);
  if (!varies[1])
    return elevate(arena, patch, 0, low, patch);
  if (!elevate(arena, patch, 0, low, &at_low) || !elevate(arena, patch, 0, high, &at_high) ||
      !elevate(arena, &at_low, 1, fall, &at_low) || !elevate(arena, &at_high, 1, rise, &at_high))
    return 0;
  for (size_t i = 0; i < 4 * (size_t)at_low.n[0] * (size_t)at_low.n[1]; i++)
    at_low.control[i] += at_high.control[i];
  *patch = at_low;
  return 1;
}

int tsi_patch_reparametrise(tsi_patch *patch, int along, double c) {
  int degree = patch->degree[along], n = patch->n[along];
  double *knots = patch->knots[along], extent = degree * fabs(log(c));
  if (!(extent <= log(1e9)))
    return 0;
  if (!tsi_knots_moebius(degree, n, c, knots))
    return 0;
  for (int j = 0; j < patch->n[1]; j++)
    for (int i = 0; i < patch->n[0]; i++) {
      int m = along ? j : i;
      double factor = 1.0, *at = patch->control + 4 * ((size_t)i + (size_t)patch->n[0] * (size_t)j);
      for (int k = 1; k <= degree; k++)
        factor *= (1.0 - knots[m + k]) + c * knots[m + k];
      for (int k = 0; k < 4; k++)
        at[k] *= factor;
    }
  return 1;
}

/* ---- evaluation ------------------------------------------------------------------------------ */

void tsi_patch_evaluate(const tsi_patch *patch, double u, double v, double point[4],
                        double d[2][4]) {
  double value[2][TSI_MAX_ORDER], slope[2][TSI_MAX_ORDER];
  int iu = tsi_bspline_basis(patch->degree[0], patch->n[0], patch->knots[0], u, value[0],
                             d ? slope[0] : NULL);
  int iv = tsi_bspline_basis(patch->degree[1], patch->n[1], patch->knots[1], v, value[1],
                             d ? slope[1] : NULL);
  memset(point, 0, 4 * sizeof *point);
  if (d)
    memset(d, 0, 2 * sizeof *d);
  for (int j = 0; j <= patch->degree[1]; j++)
    for (int i = 0; i <= patch->degree[0]; i++) {
      const double *at =
          patch->control + 4 * ((size_t)(iu + i) + (size_t)patch->n[0] * (size_t)(iv + j));
      for (int c = 0; c < 4; c++) {
        point[c] += value[0][i] * value[1][j] * at[c];
        if (d) {
          d[0][c] += slope[0][i] * value[1][j] * at[c];
          d[1][c] += value[0][i] * slope[1][j] * at[c];
        }
      }
    }
}

void tsi_border_point(int border, double x, double uv[2]) {
  double along = border < 2 ? x : 1.0 - x;
  uv[0] = border & 1 ? (border == 1 ? 1.0 : 0.0) : along;
  uv[1] = border & 1 ? along : (border == 2 ? 1.0 : 0.0);
}

/* Gauss-Legendre points and weights on [0,1], by Newton's method. */
static void find_gauss(int n, double *x, double *w) {
  const double pi = 3.14159265358979323846;
  for (int i = 0; i < n; i++) {
    double z = cos(pi * (i + 0.75) / (n + 0.5)), slope = 1.0;
    for (int step = 0; step < 100; step++) {
      double p0 = 1.0, p1 = z;
      for (int k = 2; k <= n; k++) {
        double p2 = ((2 * k - 1) * z * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      slope = n * (z * p1 - p0) / (z * z - 1.0);
      double change = p1 / slope;
      z -= change;
      if (fabs(change) < 1e-15)
        break;
    }
    x[i] = 0.5 * (1.0 - z);
    w[i] = 1.0 / ((1.0 - z * z) * slope * slope);
  }
}

void tsi_patch_point(const tsi_patch *patch, double u, double v, double x[3]) {
  double h[4];
  tsi_patch_evaluate(patch, u, v, h, NULL);
  tsi_project_point(h, x);
}

void tsi_patch_normal(const tsi_patch *patch, double u, double v, double x[3], double normal[3]) {
  double h[4], d[2][4], t[2][3];
  tsi_patch_evaluate(patch, u, v, h, d);
  for (int c = 0; c < 3; c++) {
    x[c] = h[c] / h[3];
    for (int k = 0; k < 2; k++)
      t[k][c] = (d[k][c] - x[c] * d[k][3]) / h[3];
  }
  tsi_cross3(t[0], t[1], normal);
}

void tsi_patch_measure(const tsi_patch *patch, const double origin[3], double *area, double *flux) {
  enum { MAX_POINTS = 3 * TSI_MAX_DEGREE / 2 + 2 };
  double x[2][MAX_POINTS], w[2][MAX_POINTS], at[3], normal[3];
  int n[2];
  for (int d = 0; d < 2; d++) {
    n[d] = 3 * patch->degree[d] / 2 + 1; /* the integrand has degree 3p - 1 */
    if (n[d] < 4)
      n[d] = 4;
    find_gauss(n[d], x[d], w[d]);
  }
  *area = *flux = 0.0;
  for (int j = patch->degree[1]; j < patch->n[1]; j++)
    for (int i = patch->degree[0]; i < patch->n[0]; i++) {
      double u0 = patch->knots[0][i], du = patch->knots[0][i + 1] - u0;
      double v0 = patch->knots[1][j], dv = patch->knots[1][j + 1] - v0;
      if (!(du > 0.0) || !(dv > 0.0))
        continue;
      for (int b = 0; b < n[1]; b++)
        for (int a = 0; a < n[0]; a++) {
          double weight = w[0][a] * w[1][b] * du * dv;
          tsi_patch_normal(patch, u0 + x[0][a] * du, v0 + x[1][b] * dv, at, normal);
          *area += weight * hypot(hypot(normal[0], normal[1]), normal[2]);
          for (int c = 0; c < 3; c++)
            *flux += weight * (at[c] - origin[c]) * normal[c] / 3.0;
        }
    }
}
