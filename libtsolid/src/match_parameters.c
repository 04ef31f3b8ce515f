/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Both sides of every seam brought to the same parameter, where a Moebius change does that exactly.
 *
 * The sides of a seam are curves A and B. When B(c t/(c t + 1 - t)) = A(t) the two are one rational
 * curve that was given two projective parameters. Such constants c, seam by seam, tell how the
 * parameters of all patches around a belt are related; the one that most of its patches share
 * stands, the other patches are changed, and nothing of the surface is. */
#include <stdlib.h>

#include "seams.h"

static const char stage[] = "boundary";

/* A gap this small, of the row's length, is round-off. */
static const double roundoff = 1e-12;
/* A change of parameter must explain all but this part of the gap, else the gap is something else.
 */
static const double explained = 1e-3;
/* Logarithms of constants closer than this are the same constant. */
static const double same_constant = 1e-12;

/* Around a belt they must close this well; what is left shows as a gap at the end. */
static const double closure = 1e-6;

enum { MAX_SHOWN = 20 };

static double moebius(double c, double t) {
  return c * t / (c * t + (1.0 - t));
}

/* ---- two rows ---------------------------------------------------------------------------------
 */

typedef struct row_pair {
  tsi_row row[2];
  int n_samples[2];
  double *sample[2]; /* parameters of row 0, of row 1 */
  double length;     /* of the control polygon of row 0 */
} row_pair;

static int make_pair(tsi_arena *arena, const tsi_shell *shell, const tsi_seam *s, row_pair *pair) {
  pair->length = 0.0;
  for (int k = 0; k < 2; k++) {
    pair->row[k] = tsi_seam_row(shell, s, k);
    pair->n_samples[k] = tsi_row_samples(&pair->row[k], NULL);
    pair->sample[k] = tsi_arena_new(arena, (size_t)pair->n_samples[k], sizeof(double));
    if (!pair->sample[k])
      return 0;
    tsi_row_samples(&pair->row[k], pair->sample[k]);
  }
  for (int m = 1; m < pair->row[0].n; m++)
    pair->length +=
        tsi_seam_distance(tsi_seam_point(shell, s, 0, m - 1), tsi_seam_point(shell, s, 0, m));
  return 1;
}

/* Largest distance of A(t) and B(moebius(c, t)) at the samples of both; where, on A. */
static double measure_gap(const row_pair *pair, double c, double at[3]) {
  double worst = -1.0;
  for (int k = 0; k < 2; k++)
    for (int i = 0; i < pair->n_samples[k]; i++) {
      double x = pair->sample[k][i], a[4], b[4];
      tsi_row_evaluate(&pair->row[0], k ? moebius(1.0 / c, x) : x, a, NULL);
      tsi_row_evaluate(&pair->row[1], k ? x : moebius(c, x), b, NULL);
      double distance = tsi_seam_distance(a, b);
      if (distance > worst) {
        worst = distance;
        tsi_project_point(a, at);
      }
    }
  return worst;
}

/* One Gauss-Newton step towards the point x: quadratic where x is on the curve. */
static double step_towards(const tsi_row *row, double t, const double x[3]) {
  double h[4], d[4], along = 0.0, square = 0.0;
  tsi_row_evaluate(row, t, h, d);
  for (int c = 0; c < 3; c++) {
    double y = h[c] / h[3], slope = (d[c] - y * d[3]) / h[3];
    along += (x[c] - y) * slope;
    square += slope * slope;
  }
  return square > 0.0 ? along / square : 0.0;
}

/* The parameter of the row nearest to the homogeneous point. */
static double find_nearest(const tsi_row *row, int n, const double *sample, const double point[4],
                           double *distance) {
  double x[3], h[4];
  int best = 0;
  *distance = INFINITY;
  tsi_project_point(point, x);
  for (int i = 0; i < n; i++) {
    tsi_row_evaluate(row, sample[i], h, NULL);
    double found = tsi_seam_distance(h, point);
    if (found < *distance) {
      *distance = found;
      best = i;
    }
  }
  double t = sample[best], low = sample[best > 0 ? best - 1 : 0],
         high = sample[best + 1 < n ? best + 1 : best];
  for (int i = 0; i < 30; i++) {
    double step = step_towards(row, t, x), to = fmin(fmax(t + step, low), high);
    tsi_row_evaluate(row, to, h, NULL);
    double found = tsi_seam_distance(h, point);
    if (!(found < *distance))
      break;
    *distance = found;
    t = to;
  }
  return t;
}

/* Largest distance of either row's samples from the other row as a point set. */
static double measure_separation(const row_pair *pair) {
  double worst = 0.0;
  for (int k = 0; k < 2; k++)
    for (int i = 0; i < pair->n_samples[k]; i++) {
      double h[4], distance;
      tsi_row_evaluate(&pair->row[k], pair->sample[k][i], h, NULL);
      find_nearest(&pair->row[1 - k], pair->n_samples[1 - k], pair->sample[1 - k], h, &distance);
      worst = fmax(worst, distance);
    }
  return worst;
}

/* The constant that brings the rows together best, of those that one common point each asks for;
 * its gap in *gap. */
static double find_constant(const row_pair *pair, double *gap) {
  static const double at[3] = {0.5, 0.25, 0.75};
  double best = 1.0, place[3];
  for (int k = 0; k < 3; k++) {
    double h[4], distance;
    tsi_row_evaluate(&pair->row[0], at[k], h, NULL);
    double t = find_nearest(&pair->row[1], pair->n_samples[1], pair->sample[1], h, &distance);
    double c = t / (1.0 - t) * (1.0 - at[k]) / at[k];
    if (!(c >= 1e-9 && c <= 1e9))
      continue;
    double found = measure_gap(pair, c, place);
    if (found < *gap) {
      *gap = found;
      best = c;
    }
  }
  return best;
}

static tsolid_status refuse_seam(tsolid_context *context, const tsi_shell *shell, const tsi_seam *s,
                                 const row_pair *pair) {
  char name[2][TSI_BORDER_NAME_SIZE];
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  tsi_seam_name(shell, s, name, &finding);
  finding.has_point = 1;
  finding.measured = measure_gap(pair, 1.0, finding.point);
  finding.allowed = tsi_seam_tolerance(shell, s);
  if (measure_separation(pair) <= finding.allowed)
    return tsi_report(context, &finding,
                      "%s and %s run along one curve with different parameters: up to %.3g apart "
                      "at equal ones, the tolerance is %.3g, near (%.6g, %.6g, %.6g)",
                      name[0], name[1], finding.measured, finding.allowed, finding.point[0],
                      finding.point[1], finding.point[2]);
  return tsi_report(context, &finding,
                    "%s and %s differ by %.3g, more than the tolerance of %.3g, near (%.6g, %.6g, "
                    "%.6g): they run apart",
                    name[0], name[1], finding.measured, finding.allowed, finding.point[0],
                    finding.point[1], finding.point[2]);
}

/* The logarithm of the seam's constant, 0 where the parameters agree. */
static tsolid_status compare_rows(tsolid_context *context, const tsi_shell *shell,
                                  const tsi_seam *s, double *log_constant) {
  tsi_arena own = tsi_arena_create(context);
  tsolid_status status = TSOLID_OK;
  row_pair pair;
  double gap, at[3], tolerance = tsi_seam_tolerance(shell, s);
  *log_constant = 0.0;
  if (!tsi_seam_has_rows(shell, s))
    return TSOLID_OK;
  if (!make_pair(&own, shell, s, &pair)) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  gap = measure_gap(&pair, 1.0, at);
  if (gap <= roundoff * pair.length)
    goto done;
  double changed = explained * gap, c = find_constant(&pair, &changed);
  if (c != 1.0 && changed <= tolerance)
    *log_constant = log(c);
  else if (!(gap <= tolerance))
    status = refuse_seam(context, shell, s, &pair);
done:
  tsi_arena_free(&own);
  return status;
}

/* ---- belts ------------------------------------------------------------------------------------
 */

/* A patch direction, 2 * patch + along, and the logarithm of its parameter's constant relative to
 * the root of its belt. */
typedef struct member {
  int root, node;
  double constant;
} member;

static int compare_members(const void *a, const void *b) {
  const member *p = a, *q = b;
  if (p->root != q->root)
    return p->root < q->root ? -1 : 1;
  if (p->constant != q->constant)
    return p->constant < q->constant ? -1 : 1;
  return (p->node > q->node) - (p->node < q->node);
}

/* The constant that most of the n members of a belt share, of several the one with the first node;
 * they stand in order of constants. */
static double choose_constant(int n, const member *list) {
  int most = 0, lowest = 0;
  double chosen = 0.0;
  for (int first = 0, end; first < n; first = end) {
    int node = list[first].node;
    for (end = first + 1; end < n && list[end].constant - list[first].constant <= same_constant;
         end++)
      node = list[end].node < node ? list[end].node : node;
    if (end - first > most || (end - first == most && node < lowest)) {
      most = end - first;
      lowest = node;
      chosen = list[first].constant;
    }
  }
  return chosen;
}

static tsolid_status refuse_change(tsolid_context *context, const tsi_shell *shell, int p,
                                   double c) {
  char name[TSI_NAME_SIZE];
  const tsi_facet *facet = &shell->facet[shell->place[p]->facet];
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = TSOLID_ENTITY_PATCH;
  finding.index[0] = facet->patch;
  finding.measured = c;
  return tsi_report(context, &finding,
                    "%s runs along the edges of its neighbours with another parameter, t to c t/(c "
                    "t + 1 - t), c = %.12g, which is too far from 1 for its degree or its knots",
                    tsi_name_facet(facet, name), c);
}

static tsolid_status refuse_other(tsolid_context *context, const tsi_shell *shell, int p) {
  char name[TSI_NAME_SIZE];
  const tsi_facet *facet = &shell->facet[shell->place[p]->facet];
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = TSOLID_ENTITY_PATCH;
  finding.index[0] = facet->patch;
  return tsi_report(context, &finding,
                    "%s runs along the edges of its neighbours with another parameter; only that "
                    "of NURBS patches can be changed",
                    tsi_name_facet(facet, name));
}

static tsolid_status change_belts(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                  tsi_ratios *ratios, tsolid_preparation *preparation) {
  int n = 2 * shell->first[6];
  member *list = tsi_arena_new(arena, (size_t)n, sizeof *list);
  if (!list)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < n; i++) {
    list[i].node = i;
    list[i].root = tsi_ratios_find(ratios, i, &list[i].constant);
  }
  qsort(list, (size_t)n, sizeof *list, compare_members);
  for (int first = 0, end; first < n; first = end) {
    for (end = first; end < n && list[end].root == list[first].root;)
      end++;
    double chosen = choose_constant(end - first, list + first);
    for (int i = first; i < end; i++) {
      int p = list[i].node / 2, along = list[i].node % 2;
      if (fabs(list[i].constant - chosen) <= same_constant)
        continue;
      double c = exp(list[i].constant - chosen);
      if (!shell->patch[p].n[0])
        return refuse_other(context, shell, p);
      if (!tsi_patch_reparametrise(&shell->patch[p], along, c))
        return refuse_change(context, shell, p, c);
      shell->moebius[p][along] = 1.0 / c;
      preparation->n_moebius++;
    }
  }
  return TSOLID_OK;
}

/* Constants that do not multiply to one around a belt: no change of whole patches serves. */
static tsolid_status check_constants(tsolid_context *context, const tsi_shell *shell, int n,
                                     const tsi_seam *list, const double *constant,
                                     tsi_ratios *ratios) {
  tsolid_status status = TSOLID_OK;
  for (int i = 0, n_shown = 0; i < n && n_shown < MAX_SHOWN; i++) {
    const tsi_seam *s = &list[i];
    double from, to;
    tsi_ratios_find(ratios, 2 * s->row[0].patch + s->row[0].along, &from);
    tsi_ratios_find(ratios, 2 * s->row[1].patch + s->row[1].along, &to);
    if (fabs(to - from - constant[i]) <= closure)
      continue;
    tsi_arena own = tsi_arena_create(context);
    row_pair pair;
    status = make_pair(&own, shell, s, &pair) ? refuse_seam(context, shell, s, &pair)
                                              : tsi_no_memory(context, stage);
    tsi_arena_free(&own);
    if (status != TSOLID_ERROR_REFUSED)
      return status;
    n_shown++;
  }
  return status;
}

tsolid_status tsi_shell_match_parameters(tsolid_context *context, tsi_arena *arena,
                                         tsi_shell *shell, tsolid_preparation *preparation) {
  int n, differ = 0, n_shown = 0;
  tsi_seam *list = tsi_seams_list(arena, shell, &n);
  double *constant = list ? tsi_arena_new(arena, (size_t)n, sizeof *constant) : NULL;
  tsi_ratios ratios;
  if (!constant || !tsi_ratios_create(arena, 2 * shell->first[6], &ratios))
    return tsi_no_memory(context, stage);
  tsolid_status status = TSOLID_OK;
  for (int i = 0; i < n && n_shown < MAX_SHOWN; i++) {
    tsolid_status found = compare_rows(context, shell, &list[i], &constant[i]);
    if (found && found != TSOLID_ERROR_REFUSED)
      return found;
    status = found ? found : status;
    n_shown += found != TSOLID_OK;
    differ |= constant[i] != 0.0;
  }
  if (status || !differ)
    return status;
  for (int changed = 0; changed < 2; changed++) /* patches that agree stay together */
    for (int i = 0; i < n; i++) {
      const tsi_seam *s = &list[i];
      if ((constant[i] != 0.0) == changed)
        tsi_ratios_join(&ratios, 2 * s->row[0].patch + s->row[0].along,
                        2 * s->row[1].patch + s->row[1].along, constant[i]);
    }
  status = check_constants(context, shell, n, list, constant, &ratios);
  return status ? status : change_belts(context, arena, shell, &ratios, preparation);
}
