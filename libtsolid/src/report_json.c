/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The report as one JSON document (resources/report.schema.json). Keys are the names of the
 * struct's fields; what is not a number is null. */
#include "json_writer.h"

/* ---- the report's parts ------------------------------------------------------------------------
 */

#define NUMBER(field) tsi_doc_add_number(w, o, #field, s->field)
#define FLAG(field) tsi_doc_add_flag(w, o, #field, s->field)
#define NUMBERS(field, n) tsi_doc_add_numbers(w, o, #field, s->field, n)

/* All eight, or none where the input named none. */
static void add_corner_names(tsi_doc *w, cJSON *o, const tsolid_requirement *s) {
  cJSON *list = cJSON_CreateArray();
  int named = 0;
  for (int k = 0; k < 8; k++)
    named |= s->satisfied && s->corner_name[k][0];
  for (int k = 0; k < 8 && named; k++)
    tsi_doc_append(w, list, cJSON_CreateString(s->corner_name[k]));
  tsi_doc_add(w, o, "corner_name", list);
}

static void put_requirement(tsi_doc *w, cJSON *o, tsolid_requirement *s) {
  cJSON *grid = cJSON_CreateArray();
  int n = s->satisfied ? 6 : 0;
  FLAG(satisfied);
  FLAG(closed);
  FLAG(connected);
  NUMBER(genus);
  NUMBER(n_patches);
  NUMBER(n_vertices);
  NUMBER(n_edges);
  NUMBER(n_extraordinary);
  NUMBER(n_violations);
  tsi_doc_add_points(w, o, "corner", s->corner, s->satisfied ? 8 : 0);
  for (int k = 0; k < n; k++) {
    double pair[2] = {s->side_grid[k][0], s->side_grid[k][1]};
    tsi_doc_append(w, grid, tsi_doc_numbers(w, pair, 2));
  }
  tsi_doc_add(w, o, "side_grid", grid);
  add_corner_names(w, o, s);
}

static void put_preparation(tsi_doc *w, cJSON *o, const tsolid_preparation *s) {
  NUMBERS(snap, 12);
  NUMBERS(snap_inside, 6);
  NUMBERS(weight_factor, 6);
  NUMBER(knot_merge);
  NUMBER(n_knots_inserted);
  NUMBER(n_degrees_raised);
  NUMBER(refine_knots);
  NUMBER(raise_degree);
  NUMBER(n_bilinear_factors);
  NUMBER(n_moebius);
  NUMBER(n_cut_patches);
  NUMBER(n_cuts);
  NUMBER(n_knots_merged);
}

static void put_statistics(tsi_doc *w, cJSON *o, const tsolid_statistics *s) {
  NUMBER(input_nodes);
  NUMBER(input_elements);
  NUMBER(tmesh_nodes);
  NUMBER(interior_extraordinary_nodes);
  NUMBER(partial_extraordinary_nodes);
  NUMBER(core_cells);
  NUMBER(n_functions);
  NUMBER(n_inner);
  NUMBER(bezier_elements);
  tsi_doc_add_counts(w, o, "core_cells_of_level", s->core_cells_of_level, 24);
  FLAG(analysis_suitable);
  NUMBER(tmesh_cells);
  NUMBER(tmesh_cells_before_closure);
}

static void put_conformity(tsi_doc *w, cJSON *o, const tsolid_conformity_report *s) {
  NUMBER(n_samples);
  NUMBER(distance);
  NUMBER(scale);
  FLAG(control_identical);
  NUMBER(volume);
  NUMBER(flux);
}

static void put_basis(tsi_doc *w, cJSON *o, const tsolid_basis_report *s) {
  NUMBER(sum_defect);
  NUMBER(input_sum_defect);
  NUMBER(smallest_value);
  FLAG(rank_measured);
  NUMBER(inner_eigenvalue);
  NUMBER(surface_eigenvalue);
  NUMBER(inner_roundoff);
  NUMBER(surface_roundoff);
  NUMBER(diagonal_jump);
  NUMBER(core_jump);
}

static void put_continuity(tsi_doc *w, cJSON *o, const tsolid_continuity_report *s) {
  NUMBERS(area, 4);
  NUMBER(n_faces);
  NUMBER(n_below_expected);
  NUMBER(largest_excess);
}

static const char *verdict_text(tsolid_verdict verdict) {
  return verdict == TSOLID_POSITIVE       ? "positive"
         : verdict == TSOLID_NOT_POSITIVE ? "not positive"
                                          : "undecided";
}

static void put_certificate(tsi_doc *w, cJSON *o, tsolid_certificate *s) {
  int n_singular = s->n_singular < 0 ? 0 : s->n_singular > 8 ? 8 : s->n_singular;
  tsi_doc_add_text(w, o, "verdict", verdict_text(s->verdict));
  NUMBER(n_elements);
  NUMBER(n_positive);
  NUMBER(n_not_positive);
  NUMBER(n_undecided);
  NUMBER(n_singular);
  tsi_doc_add_points(w, o, "singular", s->singular, n_singular);
  NUMBER(depth);
  NUMBER(element);
  NUMBERS(u, 3);
  NUMBERS(point, 3);
  NUMBER(smallest_bound);
}

static void put_quality(tsi_doc *w, cJSON *o, const tsolid_quality *s) {
  NUMBER(worst);
  NUMBER(mean);
  NUMBER(best);
  NUMBER(worst_element);
  NUMBERS(worst_u, 3);
  NUMBERS(worst_point, 3);
  NUMBER(start_worst);
  NUMBER(bound);
  NUMBERS(bound_point, 3);
  NUMBER(ratio);
}

static void put_timing(tsi_doc *w, cJSON *o, const tsolid_timing *s) {
  NUMBER(boundary);
  NUMBER(tmesh);
  NUMBER(space);
  NUMBER(start);
  NUMBER(optimise);
  NUMBER(certify);
  NUMBER(report);
  NUMBER(total);
  NUMBER(peak_memory_mib);
}

/* ---- driver ------------------------------------------------------------------------------------
 */

static void put_report(tsi_doc *w, cJSON *root, tsolid_context *context, tsolid_report *report) {
  tsi_doc_add_text(w, root, "format", "tsolid report");
  tsi_doc_add_number(w, root, "version", 1);
  put_requirement(w, tsi_doc_add_object(w, root, "requirement"), &report->requirement);
  put_preparation(w, tsi_doc_add_object(w, root, "preparation"), &report->preparation);
  put_statistics(w, tsi_doc_add_object(w, root, "statistics"), &report->statistics);
  put_conformity(w, tsi_doc_add_object(w, root, "conformity"), &report->conformity);
  put_basis(w, tsi_doc_add_object(w, root, "basis"), &report->basis);
  put_continuity(w, tsi_doc_add_object(w, root, "continuity"), &report->continuity);
  put_certificate(w, tsi_doc_add_object(w, root, "certificate"), &report->certificate);
  put_quality(w, tsi_doc_add_object(w, root, "quality"), &report->quality);
  put_timing(w, tsi_doc_add_object(w, root, "timing"), &report->timing);
  tsi_doc_add_findings(w, root, context);
}

tsolid_status tsolid_report_json(tsolid_context *context, const tsolid_report *report,
                                 char **json) {
  tsi_doc w = {0};
  if (json)
    *json = NULL;
  if (!context || !report || !json)
    return TSOLID_ERROR_ARGUMENT;
  tsolid_report copy = *report; /* 2-D arrays cannot be passed as const in C11 */
  cJSON *root = cJSON_CreateObject();
  put_report(&w, root, context, &copy);
  return tsi_doc_finish(&w, context, root, json);
}
