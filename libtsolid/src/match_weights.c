/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Weights made to agree along all seams.
 *
 * A surface stays the same, parameter by parameter, when its homogeneous control net is multiplied
 * by a positive function. Constants per patch suffice when the weights of the two sides A, B of
 * every seam have a constant ratio. Else the function is bilinear: on patch p it is T_v / w_pv at
 * vertex v, where w_pv is the patch's own weight and T_v > 0 one number for all patches around v.
 * Along a seam with weights A(t), B(t) and ends 0, 1 the two then agree if and only if
 *
 *     A(t)/B(t) = ((1-t) T_0/B(0) + t T_1/B(1)) / ((1-t) T_0/A(0) + t T_1/A(1)),
 *
 * which holds for any T where A/B is constant, and with L = A/B gives by its value at t = 1/2
 *
 *     T_1/T_0 = A(1)/A(0) (L(0) - L(1/2)) / (L(1/2) - L(1)).
 *
 * These ratios, the best conditioned first, give T; all samples of all seams decide if it serves.
 */
#include <stdlib.h>

#include "seams.h"

static const char stage[] = "boundary";

static const double weight_agreement = 1e-10;
/* Homogeneous products of several weights must stay finite. */
static const double largest_weight = 1e50;

/* ---- factors -----------------------------------------------------------------------------------
 */

static double sample_ratio(const tsi_row row[2], double t) {
  double a[4], b[4];
  tsi_row_evaluate(&row[0], t, a, NULL);
  tsi_row_evaluate(&row[1], t, b, NULL);
  return a[3] / b[3];
}

/* What is known of a seam: the ratio of its weights at t = 0, 1/2, 1. */
typedef struct seam_ratio {
  int seam, varies;
  double ratio[3], spread; /* |log(ratio[2] / ratio[0])| */
} seam_ratio;

/* Room for the samples of the longer one of any seam's rows. */
static double *new_samples(tsi_arena *arena, const tsi_shell *shell, int n, const tsi_seam *list) {
  int most = 1;
  for (int i = 0; i < n; i++)
    for (int k = 0; k < 2; k++) {
      tsi_row row = tsi_seam_row(shell, &list[i], k);
      int count = row.n ? tsi_row_samples(&row, NULL) : 0;
      most = count > most ? count : most;
    }
  return tsi_arena_new(arena, (size_t)most, sizeof(double));
}

static void measure_ratio(const tsi_shell *shell, const tsi_seam *list, int i, double *sample,
                          seam_ratio *found) {
  tsi_row row[2] = {tsi_seam_row(shell, &list[i], 0), tsi_seam_row(shell, &list[i], 1)};
  *found = (seam_ratio){.seam = i, .ratio = {1.0, 1.0, 1.0}};
  for (int k = 0; k < 3 && row[0].n && row[1].n; k++)
    found->ratio[k] = sample_ratio(row, 0.5 * k);
  found->spread = fabs(log(found->ratio[2] / found->ratio[0]));
  for (int k = 0; k < 2 && row[0].n && row[1].n; k++) {
    int n = tsi_row_samples(&row[k], sample);
    for (int m = 0; m < n; m++)
      found->varies |=
          !(fabs(sample_ratio(row, sample[m]) / found->ratio[0] - 1.0) <= weight_agreement);
  }
}

static int compare_spreads(const void *a, const void *b) {
  const seam_ratio *p = a, *q = b;
  if (p->varies != q->varies)
    return p->varies ? -1 : 1;
  if (p->spread != q->spread)
    return p->spread > q->spread ? -1 : 1;
  return (p->seam > q->seam) - (p->seam < q->seam);
}

/* Constants first: patches joined by seams of constant ratio get factors that make it one; where
 * only a varying ratio leads on, its ends' geometric mean. */
static void find_constants(const tsi_shell *shell, int n, const tsi_seam *list,
                           const seam_ratio *ratio, tsi_ratios *constants, double *factor) {
  for (int varies = 0; varies < 2; varies++)
    for (int i = 0; i < n; i++) {
      const tsi_seam *s = &list[ratio[i].seam];
      const double *r = ratio[i].ratio;
      double agreed = fabs(r[0] - 1.0) <= weight_agreement ? 0.0 : log(r[0]);
      if (ratio[i].varies == varies)
        tsi_ratios_join(constants, s->row[0].patch, s->row[1].patch,
                        varies ? 0.5 * (log(r[0]) + log(r[2])) : agreed);
    }
  double first, own;
  tsi_ratios_find(constants, 0, &first);
  for (int p = 0; p < shell->first[6]; p++) {
    tsi_ratios_find(constants, p, &own);
    factor[p] = exp(own - first);
  }
}

/* Vertex of the complex at corner k (bit 0: u high, bit 1: v high) of patch p. */
static int vertex_of(const tsi_shell *shell, int p, int k) {
  size_t n[3], x[3];
  int side = 0;
  while (p >= shell->first[side + 1])
    side++;
  for (int a = 0; a < 3; a++)
    n[a] = (size_t)shell->n_strips[a] + 1;
  int s = tsi_side_s(side), t = tsi_side_t(side), at = p - shell->first[side];
  x[tsi_side_axis(side)] = side & 1 ? n[tsi_side_axis(side)] - 1 : 0;
  x[s] = (size_t)(at % shell->n_strips[s] + (k & 1));
  x[t] = (size_t)(at / shell->n_strips[s] + (k >> 1));
  return (int)tsi_lattice_id(n, x);
}

static double corner_weight(const tsi_shell *shell, int p, int k) {
  const tsi_patch *patch = &shell->patch[p];
  size_t i = k & 1 ? (size_t)patch->n[0] - 1 : 0, j = k & 2 ? (size_t)patch->n[1] - 1 : 0;
  return patch->control[4 * (i + (size_t)patch->n[0] * j) + 3];
}

/* Ratios of T along the seams that determine them, the widest spread first. */
static void join_vertices(const tsi_shell *shell, int n, const tsi_seam *list,
                          const seam_ratio *ratio, tsi_ratios *vertices) {
  for (int i = 0; i < n && ratio[i].varies; i++) {
    const tsi_seam *s = &list[ratio[i].seam];
    const double *r = ratio[i].ratio;
    int p = s->row[0].patch, low = tsi_seam_corner(s, 0, 0), high = tsi_seam_corner(s, 0, 1);
    double slope = (r[0] - r[1]) / (r[1] - r[2]);
    if (!(slope > 0.0) || isinf(slope))
      continue; /* no factor serves: check_products will say so */
    tsi_ratios_join(vertices, vertex_of(shell, p, low), vertex_of(shell, p, high),
                    log(corner_weight(shell, p, high) / corner_weight(shell, p, low)) + log(slope));
  }
}

/* target[v] = T_v. A tree of several vertices is scaled so that the factors at its vertices have
 * the geometric mean one; a vertex that stands alone keeps its weight. */
static tsolid_status find_targets(tsolid_context *context, tsi_arena *arena, const tsi_shell *shell,
                                  const double *factor, tsi_ratios *vertices, int n_vertices,
                                  double *target) {
  double *sum = tsi_arena_new(arena, (size_t)n_vertices, sizeof *sum);
  int *count = tsi_arena_new(arena, (size_t)n_vertices, sizeof *count);
  int *members = tsi_arena_new(arena, (size_t)n_vertices, sizeof *members);
  double log_ratio;
  if (!sum || !count || !members)
    return tsi_no_memory(context, stage);
  for (int v = 0; v < n_vertices; v++)
    members[tsi_ratios_find(vertices, v, &log_ratio)]++;
  for (int p = 0; p < shell->first[6]; p++)
    for (int k = 0; k < 4; k++) {
      int v = vertex_of(shell, p, k), root = tsi_ratios_find(vertices, v, &log_ratio);
      double own = factor[p] * corner_weight(shell, p, k);
      sum[root] += log(own) - log_ratio;
      count[root]++;
      if (!(target[v] > 0.0))
        target[v] = own;
    }
  for (int v = 0; v < n_vertices; v++) {
    int root = tsi_ratios_find(vertices, v, &log_ratio);
    if (members[root] > 1)
      target[v] = exp(sum[root] / count[root] + log_ratio);
  }
  return TSOLID_OK;
}

/* Four factors per patch, all four the same bits where a constant serves. */
static void find_products(const tsi_shell *shell, const double *factor, const double *target,
                          double *product) {
  for (int p = 0; p < shell->first[6]; p++) {
    double *corner = product + 4 * (size_t)p;
    int constant = 1;
    for (int k = 0; k < 4; k++) {
      corner[k] = target[vertex_of(shell, p, k)] / corner_weight(shell, p, k);
      constant = constant && fabs(corner[k] / corner[0] - 1.0) <= weight_agreement;
    }
    if (fabs(corner[0] - 1.0) <= weight_agreement && constant)
      corner[0] = 1.0;
    else if (fabs(corner[0] / factor[p] - 1.0) <= weight_agreement && constant)
      corner[0] = factor[p];
    for (int k = 1; constant && k < 4; k++)
      corner[k] = corner[0];
  }
}

/* How far the weights of the seam would still be apart, as a part of them, and where. */
static double measure_misfit(const tsi_shell *shell, const tsi_seam *s, const double *product,
                             double *sample, double *at) {
  tsi_row row[2] = {tsi_seam_row(shell, s, 0), tsi_seam_row(shell, s, 1)};
  double end[2][2], worst = 0.0;
  *at = 0.0;
  for (int k = 0; k < 2; k++)
    for (int high = 0; high < 2; high++)
      end[k][high] = product[4 * (size_t)s->row[k].patch + (size_t)tsi_seam_corner(s, k, high)];
  for (int k = 0; k < 2; k++) {
    int n = tsi_row_samples(&row[k], sample);
    for (int m = 0; m < n; m++) {
      double t = sample[m], a = (1.0 - t) * end[0][0] + t * end[0][1],
             b = (1.0 - t) * end[1][0] + t * end[1][1];
      double off = fabs(sample_ratio(row, t) * a / b - 1.0);
      if (!(off <= worst)) {
        worst = off;
        *at = t;
      }
    }
  }
  return worst;
}

static tsolid_status check_products(tsolid_context *context, const tsi_shell *shell, int n,
                                    const tsi_seam *list, const double *product, double *sample) {
  int worst = -1;
  double misfit = weight_agreement, at = 0.0, t;
  for (int i = 0; i < n; i++) {
    double found = measure_misfit(shell, &list[i], product, sample, &t);
    if (found > misfit) {
      misfit = found;
      worst = i;
      at = t;
    }
  }
  if (worst < 0)
    return TSOLID_OK;
  char name[2][TSI_BORDER_NAME_SIZE];
  const tsi_seam *s = &list[worst];
  tsi_row row[2] = {tsi_seam_row(shell, s, 0), tsi_seam_row(shell, s, 1)};
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  double h[4];
  tsi_seam_name(shell, s, name, &finding);
  tsi_row_evaluate(&row[0], at, h, NULL);
  finding.has_point = 1;
  tsi_project_point(h, finding.point);
  finding.measured = misfit;
  finding.allowed = weight_agreement;
  return tsi_report(context, &finding,
                    "The weights of %s and %s do not fit: their ratio is %.12g at one end and "
                    "%.12g near (%.6g, %.6g, %.6g), no factor that is bilinear on each face evens "
                    "that out",
                    name[0], name[1], sample_ratio(row, 0.0), sample_ratio(row, at),
                    finding.point[0], finding.point[1], finding.point[2]);
}

static tsolid_status refuse_patch(tsolid_context *context, const tsi_shell *shell, int p,
                                  const char *why) {
  char name[TSI_NAME_SIZE];
  const tsi_facet *facet = &shell->facet[shell->place[p]->facet];
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = TSOLID_ENTITY_PATCH;
  finding.index[0] = facet->patch;
  return tsi_report(context, &finding, "%s would need other weights to fit its neighbours: %s",
                    tsi_name_facet(facet, name), why);
}

static void scale_patch(tsi_patch *patch, double factor) {
  size_t count = 4 * (size_t)patch->n[0] * (size_t)patch->n[1];
  for (size_t i = 0; i < count; i++)
    patch->control[i] *= factor;
}

static tsolid_status check_range(tsolid_context *context, const tsi_shell *shell, int p) {
  const tsi_patch *patch = &shell->patch[p];
  for (size_t i = 0; i < (size_t)patch->n[0] * (size_t)patch->n[1]; i++) {
    double w = patch->control[4 * i + 3];
    if (!(w <= largest_weight) || !(w >= 1.0 / largest_weight))
      return refuse_patch(context, shell, p, "they are too large or too small");
  }
  return TSOLID_OK;
}

/* Keeps of all factors of a side the one that is farthest from one. */
static void record_factor(const tsi_shell *shell, int p, double factor,
                          tsolid_preparation *preparation) {
  int side = 0;
  while (p >= shell->first[side + 1])
    side++;
  if (fabs(log(factor)) > fabs(log(preparation->weight_factor[side])))
    preparation->weight_factor[side] = factor;
}

static tsolid_status multiply_patch(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                    int p, const double corner[4],
                                    tsolid_preparation *preparation) {
  tsi_patch *patch = &shell->patch[p];
  int n_raised = 0;
  for (int k = 0; k < 4; k++)
    record_factor(shell, p, corner[k], preparation);
  if (corner[0] == corner[1] && corner[0] == corner[2] && corner[0] == corner[3]) {
    if (corner[0] == 1.0)
      return TSOLID_OK;
    scale_patch(patch, corner[0]);
    return check_range(context, shell, p);
  }
  if (patch->degree[0] >= TSI_MAX_DEGREE || patch->degree[1] >= TSI_MAX_DEGREE)
    return refuse_patch(context, shell, p, "the degree would rise above 25");
  if (4.0 * patch->n[0] * patch->n[1] > TSI_MAX_COUNT / 16)
    return refuse_patch(context, shell, p, "it would have too many control points");
  if (!tsi_patch_multiply(arena, patch, corner, &n_raised))
    return tsi_no_memory(context, stage);
  preparation->n_bilinear_factors++;
  preparation->n_degrees_raised += n_raised;
  return check_range(context, shell, p);
}

static tsolid_status multiply_varying(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                      int n, const tsi_seam *list, seam_ratio *ratio,
                                      double *sample, tsolid_preparation *preparation) {
  size_t n_lattice[3], n_patches = (size_t)shell->first[6];
  for (int a = 0; a < 3; a++)
    n_lattice[a] = (size_t)shell->n_strips[a] + 1;
  int n_vertices = (int)tsi_lattice_count(n_lattice);
  tsi_ratios constants, vertices;
  double *factor = tsi_arena_new(arena, n_patches, sizeof *factor);
  double *product = tsi_arena_new(arena, n_patches, 4 * sizeof *product);
  double *target = tsi_arena_new(arena, (size_t)n_vertices, sizeof *target);
  if (!factor || !product || !target || !tsi_ratios_create(arena, shell->first[6], &constants) ||
      !tsi_ratios_create(arena, n_vertices, &vertices))
    return tsi_no_memory(context, stage);
  qsort(ratio, (size_t)n, sizeof *ratio, compare_spreads);
  find_constants(shell, n, list, ratio, &constants, factor);
  join_vertices(shell, n, list, ratio, &vertices);
  tsolid_status status = find_targets(context, arena, shell, factor, &vertices, n_vertices, target);
  if (status)
    return status;
  find_products(shell, factor, target, product);
  status = check_products(context, shell, n, list, product, sample);
  for (int p = 0; !status && p < shell->first[6]; p++)
    status = multiply_patch(context, arena, shell, p, product + 4 * (size_t)p, preparation);
  return status;
}

tsolid_status tsi_shell_multiply_weights(tsolid_context *context, tsi_arena *arena,
                                         tsi_shell *shell, tsolid_preparation *preparation) {
  int n, varies = 0;
  for (int side = 0; side < 6; side++)
    preparation->weight_factor[side] = 1.0;
  tsi_seam *list = tsi_seams_list(arena, shell, &n);
  double *sample = list ? new_samples(arena, shell, n, list) : NULL;
  seam_ratio *ratio = list ? tsi_arena_new(arena, (size_t)n, sizeof *ratio) : NULL;
  if (!sample || !ratio)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < n; i++) {
    measure_ratio(shell, list, i, sample, &ratio[i]);
    varies |= ratio[i].varies;
  }
  for (int p = 0; varies && p < shell->first[6]; p++)
    if (!shell->patch[p].n[0])
      return refuse_patch(context, shell, p,
                          "somewhere round the part they differ by a factor that varies, and only "
                          "NURBS patches can be multiplied by one");
  return varies ? multiply_varying(context, arena, shell, n, list, ratio, sample, preparation)
                : TSOLID_OK;
}

/* ---- constants --------------------------------------------------------------------------------
 */

static double weight_ratio(const tsi_shell *shell, const tsi_seam *s, int m) {
  return tsi_seam_point(shell, s, 0, m)[3] / tsi_seam_point(shell, s, 1, m)[3];
}

/* Sides that are not rows must agree as they are: the functions of both are compared later. */
static int count_weights(const tsi_shell *shell, const tsi_seam *s) {
  return tsi_seam_has_rows(shell, s) ? tsi_seam_count(shell, s, 0) : 0;
}

static int weights_agree(const tsi_shell *shell, const tsi_seam *s) {
  for (int m = 0; m < count_weights(shell, s); m++)
    if (!(fabs(weight_ratio(shell, s, m) - 1.0) <= weight_agreement))
      return 0;
  return 1;
}

/* factor[p], propagated from patch 0 over the seams in order. A ratio that is one within the
 * agreement is one, so that no weight changes without need. */
static void propagate_factors(const tsi_shell *shell, int n, const tsi_seam *list, double *factor) {
  factor[0] = 1.0;
  for (int changed = 1; changed;) {
    changed = 0;
    for (int i = 0; i < n; i++) {
      int a = list[i].row[0].patch, b = list[i].row[1].patch;
      if ((factor[a] > 0.0) == (factor[b] > 0.0))
        continue;
      double ratio = weights_agree(shell, &list[i]) ? 1.0 : weight_ratio(shell, &list[i], 0);
      if (factor[a] > 0.0)
        factor[b] = factor[a] * ratio;
      else
        factor[a] = factor[b] / ratio;
      changed = 1;
    }
  }
}

static tsolid_status check_factors(tsolid_context *context, const tsi_shell *shell,
                                   const tsi_seam *s, const double *factor) {
  double wanted = factor[s->row[1].patch] / factor[s->row[0].patch], worst = 0.0;
  int at = 0;
  for (int m = 0; m < count_weights(shell, s); m++) {
    double off = fabs(weight_ratio(shell, s, m) / wanted - 1.0);
    if (!(off <= worst)) {
      worst = off;
      at = m;
    }
  }
  if (worst <= weight_agreement)
    return TSOLID_OK;
  char name[2][TSI_BORDER_NAME_SIZE];
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  tsi_seam_name(shell, s, name, &finding);
  finding.has_point = 1;
  tsi_project_point(tsi_seam_point(shell, s, 0, at), finding.point);
  finding.measured = worst;
  finding.allowed = weight_agreement;
  return tsi_report(context, &finding,
                    "The weights of %s and %s do not fit: their ratio is %.12g where the other "
                    "edges ask for %.12g",
                    name[0], name[1], weight_ratio(shell, s, at), wanted);
}

/* Every control point times the factor of its patch; those of several patches must have one. */
static tsolid_status apply_factors(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                   const double *factor, tsolid_preparation *preparation) {
  double *own = tsi_arena_new(arena, (size_t)shell->n_control, sizeof *own);
  if (!own)
    return tsi_no_memory(context, stage);
  for (int p = 0; p < shell->first[6]; p++) {
    const tsi_tspline *tspline = &shell->tspline[p];
    const tsi_side *elements = &shell->elements[p];
    int n = tspline->n ? tspline->n : elements->function_start[elements->n_elements];
    record_factor(shell, p, factor[p], preparation);
    for (int i = 0; i < n; i++) {
      int row = tspline->n ? tspline->blend[i].point : elements->function[i];
      if (own[row] > 0.0 && !(fabs(own[row] / factor[p] - 1.0) <= weight_agreement))
        return refuse_patch(context, shell, p, "but it shares functions with one of them");
      if (!(own[row] > 0.0))
        own[row] = factor[p];
    }
  }
  for (int i = 0; i < shell->n_control; i++) {
    double *h = shell->control + 4 * (size_t)i;
    if (!(own[i] > 0.0) || own[i] == 1.0)
      continue;
    for (int c = 0; c < 4; c++)
      h[c] *= own[i];
    if (!(h[3] <= largest_weight) || !(h[3] >= 1.0 / largest_weight))
      return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                      "Weights become too large or too small when they are made to fit");
  }
  return TSOLID_OK;
}

tsolid_status tsi_shell_match_weights(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                      tsolid_preparation *preparation) {
  int n, agree = 1;
  tsi_seam *list = tsi_seams_list(arena, shell, &n);
  double *factor = tsi_arena_new(arena, (size_t)shell->first[6], sizeof *factor);
  if (!list || !factor)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < n; i++)
    agree = agree && weights_agree(shell, &list[i]);
  if (agree)
    return TSOLID_OK;
  propagate_factors(shell, n, list, factor);
  tsolid_status status = TSOLID_OK;
  for (int i = 0; !status && i < n; i++)
    status = check_factors(context, shell, &list[i], factor);
  return status ? status : apply_factors(context, arena, shell, factor, preparation);
}
