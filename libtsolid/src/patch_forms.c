/* SPDX-License-Identifier: LGPL-2.1-or-later
 * T-spline and Bezier patches of the input: vetted and brought to [0,1]^2. */
#include "boundary.h"
#include "bspline.h"

static const char stage[] = "boundary";

/* Knots closer to the domain's ends than this part of it lie on them. */
static const double knot_resolution = 1e-11;
static const double largest_knot = 1e100;

static tsolid_finding form_finding(int k) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
  finding.entity = TSOLID_ENTITY_PATCH;
  finding.index[0] = k;
  return finding;
}

void tsi_form_domain(const tsolid_patch *patch, int d, double domain[2]) {
  domain[0] = 0.0;
  domain[1] = 1.0;
  if (patch->tspline) {
    domain[0] = patch->tspline->domain[2 * d];
    domain[1] = patch->tspline->domain[2 * d + 1];
  } else if (!patch->bezier) {
    domain[0] = patch->knots[d][0];
    domain[1] = patch->knots[d][patch->n_control[d] + patch->degree[d]];
  }
}

/* ---- T-splines --------------------------------------------------------------------------------
 */

static tsolid_status vet_sizes(tsolid_context *context, const tsolid_tspline *t, int k,
                               const char *name) {
  tsolid_finding finding = form_finding(k);
  for (int d = 0; d < 2; d++) {
    double low = t->domain[2 * d], high = t->domain[2 * d + 1];
    if (t->degree[d] < 1 || t->degree[d] > TSI_MAX_DEGREE)
      return tsi_report(context, &finding, "%s has degree %d in %c, not one of 1 to %d", name,
                        t->degree[d], 'u' + d, (int)TSI_MAX_DEGREE);
    if (!(fabs(low) <= largest_knot) || !(fabs(high) <= largest_knot) || !(low < high))
      return tsi_report(context, &finding, "%s: the domain in %c is [%g, %g]", name, 'u' + d, low,
                        high);
  }
  if (t->n_functions < 4 || t->n_functions > TSI_MAX_COUNT / 64)
    return tsi_report(context, &finding, "%s has %d functions", name, t->n_functions);
  if (!t->point || !t->knots[0] || !t->knots[1])
    return tsi_report(context, &finding, "%s has no functions or no knots", name);
  return TSOLID_OK;
}

/* Local knots of function i in direction d, on the patch's [0,1]. */
static tsolid_status read_knots(tsolid_context *context, const tsolid_tspline *t, int k, int i,
                                int d, const char *name, double *to) {
  tsolid_finding finding = form_finding(k);
  int n = t->degree[d] + 2, c = 'u' + d;
  const double *knot = t->knots[d] + (size_t)i * (size_t)n;
  double low = t->domain[2 * d], high = t->domain[2 * d + 1];
  for (int j = 0; j < n; j++) {
    if (!(fabs(knot[j]) <= largest_knot))
      return tsi_report(context, &finding, "%s: knot %d in %c of function %d is not finite", name,
                        j, c, i);
    if (j && knot[j] < knot[j - 1])
      return tsi_report(context, &finding,
                        "%s: the knots in %c of function %d decrease at knot %d (%.17g, %.17g)",
                        name, c, i, j, knot[j - 1], knot[j]);
    double x = tsi_knot_normalise(low, high, knot[j]);
    if (fabs(x) <= knot_resolution)
      x = 0.0;
    else if (fabs(x - 1.0) <= knot_resolution)
      x = 1.0;
    to[j] = x;
  }
  if (!(to[0] < to[n - 1]))
    return tsi_report(context, &finding, "%s: all knots in %c of function %d are one", name, c, i);
  if (!(to[0] < 1.0) || !(to[n - 1] > 0.0))
    return tsi_report(context, &finding,
                      "%s: function %d does not reach into the patch: its knots in %c run from "
                      "%.6g to %.6g",
                      name, i, c, knot[0], knot[n - 1]);
  return TSOLID_OK;
}

/* The functions must not vanish all on a part of an element. */
static tsolid_status vet_sum(tsolid_context *context, const tsi_side *side, int k,
                             const char *name) {
  size_t width = (size_t)(side->degree[0] + 1) * (size_t)(side->degree[1] + 1);
  for (int e = 0; e < side->n_elements; e++)
    for (size_t i = 0; i < width; i++) {
      double sum = 0.0;
      for (int f = side->function_start[e]; f < side->function_start[e + 1]; f++)
        sum += side->coefficient[(size_t)f * width + i];
      if (sum > 1e-6)
        continue;
      const double *box = side->box + 4 * (size_t)e;
      tsolid_finding finding = form_finding(k);
      finding.measured = sum;
      return tsi_report(context, &finding,
                        "%s: all functions vanish in a part of [%.6g, %.6g] x [%.6g, %.6g] of the "
                        "domain, taken as the unit square",
                        name, box[0], box[1], box[2], box[3]);
    }
  return TSOLID_OK;
}

static tsolid_status read_tspline(tsolid_context *context, tsi_arena *arena,
                                  const tsolid_tspline *t, int n_points, int k, const char *name,
                                  tsi_tspline *tspline, tsi_side *elements) {
  tsolid_status status = vet_sizes(context, t, k, name);
  if (status)
    return status;
  *tspline = (tsi_tspline){.degree = {t->degree[0], t->degree[1]}, .n = t->n_functions};
  tspline->blend = tsi_arena_new(arena, (size_t)tspline->n, sizeof *tspline->blend);
  for (int d = 0; d < 2; d++) {
    tspline->n_knots[d] = t->n_functions * (t->degree[d] + 2);
    tspline->knots[d] = tsi_arena_new(arena, (size_t)tspline->n_knots[d], sizeof(double));
  }
  if (!tspline->blend || !tspline->knots[0] || !tspline->knots[1])
    return tsi_no_memory(context, stage);
  for (int i = 0; i < t->n_functions; i++) {
    tsolid_finding finding = form_finding(k);
    if (t->point[i] < 0 || t->point[i] >= n_points)
      return tsi_report(context, &finding, "%s: function %d names point %d of %d", name, i,
                        t->point[i], n_points);
    tspline->blend[i].point = t->point[i];
    for (int d = 0; !status && d < 2; d++) {
      tspline->blend[i].knot[d] = i * (t->degree[d] + 2);
      status = read_knots(context, t, k, i, d, name, tspline->knots[d] + tspline->blend[i].knot[d]);
    }
    if (status)
      return status;
  }
  if (!tsi_tspline_find_rows(arena, tspline))
    return tsi_no_memory(context, stage);
  status = tsi_tspline_elements(context, arena, tspline, tspline->degree, name, elements);
  return status ? status : vet_sum(context, elements, k, name);
}

/* ---- Bezier elements --------------------------------------------------------------------------
 */

static tsolid_status read_bezier(tsolid_context *context, tsi_arena *arena,
                                 const tsolid_bezier_side *from, int n_points, int k,
                                 const char *name, tsi_side *elements) {
  tsi_side_label label = {.entity = TSOLID_ENTITY_PATCH, .index = k};
  int *last_use = tsi_arena_new(arena, (size_t)n_points, sizeof *last_use);
  if (!last_use)
    return tsi_no_memory(context, stage);
  memcpy(label.text, name, TSI_NAME_SIZE);
  *elements = (tsi_side){.degree = {from->degree[0], from->degree[1]},
                         .n_elements = from->n_elements,
                         .box = (double *)(uintptr_t)from->box,
                         .function_start = (int *)(uintptr_t)from->function_start,
                         .function = (int *)(uintptr_t)from->function,
                         .coefficient = (double *)(uintptr_t)from->coefficient,
                         .grid = {1, 1}};
  tsolid_status status = tsi_side_check(context, arena, &label, n_points, elements, 1, last_use);
  memset(last_use, 0, (size_t)n_points * sizeof *last_use);
  return status ? status : tsi_side_check_tears(context, arena, &label, elements, last_use);
}

tsolid_status tsi_form_read(tsolid_context *context, tsi_arena *arena,
                            const tsolid_boundary_input *input, int k, tsi_tspline *tspline,
                            tsi_side *elements) {
  char name[TSI_NAME_SIZE] = "";
  const tsolid_patch *patch = &input->patches[k];
  tsolid_finding finding = form_finding(k);
  tsi_name_patch(patch->name, k, name);
  if (patch->tspline && patch->bezier)
    return tsi_report(context, &finding, "%s is both a T-spline and Bezier elements", name);
  if (patch->tspline)
    return read_tspline(context, arena, patch->tspline, input->n_points, k, name, tspline,
                        elements);
  return read_bezier(context, arena, patch->bezier, input->n_points, k, name, elements);
}
