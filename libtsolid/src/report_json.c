/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The report as one JSON document (resources/report.schema.json). Keys are the names of the
 * struct's fields; what is not a number is null. */
#include <cjson/cJSON.h>

#include "file_io.h"
#include "json_reader.h"

static const char stage[] = "report";

/* Adding to NULL, or NULL to something, gives NULL in cJSON: failures stick. */
typedef struct writer {
  int failed;
} writer;

/* ---- values ------------------------------------------------------------------------------------
 */

/* cJSON's own numbers do not read back exactly and depend on the locale. */
static cJSON *new_number(double value) {
  char text[TSI_NUMBER_SIZE];
  if (!isfinite(value))
    return cJSON_CreateNull();
  tsi_number_print(value, text);
  return cJSON_CreateRaw(text);
}

static void add(writer *w, cJSON *object, const char *key, cJSON *item) {
  if (object && item && cJSON_AddItemToObject(object, key, item))
    return;
  cJSON_Delete(item);
  w->failed = 1;
}

static void append(writer *w, cJSON *list, cJSON *item) {
  if (list && item && cJSON_AddItemToArray(list, item))
    return;
  cJSON_Delete(item);
  w->failed = 1;
}

static cJSON *add_object(writer *w, cJSON *parent, const char *key) {
  cJSON *object = cJSON_AddObjectToObject(parent, key);
  if (!object)
    w->failed = 1;
  return object;
}

static void add_number(writer *w, cJSON *object, const char *key, double value) {
  add(w, object, key, new_number(value));
}

static void add_flag(writer *w, cJSON *object, const char *key, int value) {
  add(w, object, key, cJSON_CreateBool(value));
}

static void add_text(writer *w, cJSON *object, const char *key, const char *text) {
  add(w, object, key, cJSON_CreateString(text));
}

static cJSON *new_numbers(writer *w, const double *value, int n) {
  cJSON *list = cJSON_CreateArray();
  for (int k = 0; k < n; k++)
    append(w, list, new_number(value[k]));
  return list;
}

static void add_numbers(writer *w, cJSON *object, const char *key, const double *value, int n) {
  add(w, object, key, new_numbers(w, value, n));
}

/* Up to the last that is not zero. */
static void add_counts(writer *w, cJSON *object, const char *key, const int *value, int n) {
  cJSON *list = cJSON_CreateArray();
  while (n > 0 && value[n - 1] == 0)
    n--;
  for (int k = 0; k < n; k++)
    append(w, list, new_number(value[k]));
  add(w, object, key, list);
}

static void add_points(writer *w, cJSON *object, const char *key, double (*point)[3], int n) {
  cJSON *list = cJSON_CreateArray();
  for (int k = 0; k < n; k++)
    append(w, list, new_numbers(w, point[k], 3));
  add(w, object, key, list);
}

/* ---- the report's parts ------------------------------------------------------------------------
 */

#define NUMBER(field) add_number(w, o, #field, s->field)
#define FLAG(field) add_flag(w, o, #field, s->field)
#define NUMBERS(field, n) add_numbers(w, o, #field, s->field, n)

static void put_requirement(writer *w, cJSON *o, tsolid_requirement *s) {
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
  add_points(w, o, "corner", s->corner, s->satisfied ? 8 : 0);
  for (int k = 0; k < n; k++) {
    double pair[2] = {s->side_grid[k][0], s->side_grid[k][1]};
    append(w, grid, new_numbers(w, pair, 2));
  }
  add(w, o, "side_grid", grid);
}

static void put_preparation(writer *w, cJSON *o, const tsolid_preparation *s) {
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
}

static void put_statistics(writer *w, cJSON *o, const tsolid_statistics *s) {
  NUMBER(input_nodes);
  NUMBER(input_elements);
  NUMBER(tmesh_nodes);
  NUMBER(interior_extraordinary_nodes);
  NUMBER(partial_extraordinary_nodes);
  NUMBER(core_cells);
  NUMBER(n_functions);
  NUMBER(n_inner);
  NUMBER(bezier_elements);
  add_counts(w, o, "core_cells_of_level", s->core_cells_of_level, 24);
  FLAG(analysis_suitable);
  NUMBER(tmesh_cells);
  NUMBER(tmesh_cells_before_closure);
}

static void put_conformity(writer *w, cJSON *o, const tsolid_conformity_report *s) {
  NUMBER(n_samples);
  NUMBER(distance);
  NUMBER(scale);
  FLAG(control_identical);
  NUMBER(volume);
  NUMBER(flux);
}

static void put_basis(writer *w, cJSON *o, const tsolid_basis_report *s) {
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

static void put_continuity(writer *w, cJSON *o, const tsolid_continuity_report *s) {
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

static void put_certificate(writer *w, cJSON *o, tsolid_certificate *s) {
  int n_singular = s->n_singular < 0 ? 0 : s->n_singular > 8 ? 8 : s->n_singular;
  add_text(w, o, "verdict", verdict_text(s->verdict));
  NUMBER(n_elements);
  NUMBER(n_positive);
  NUMBER(n_not_positive);
  NUMBER(n_undecided);
  NUMBER(n_singular);
  add_points(w, o, "singular", s->singular, n_singular);
  NUMBER(depth);
  NUMBER(element);
  NUMBERS(u, 3);
  NUMBERS(point, 3);
  NUMBER(smallest_bound);
}

static void put_quality(writer *w, cJSON *o, const tsolid_quality *s) {
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

static void put_timing(writer *w, cJSON *o, const tsolid_timing *s) {
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

/* ---- findings ----------------------------------------------------------------------------------
 */

/* Texts hold names from files: what is no UTF-8 becomes '?'. NULL: no memory. */
static cJSON *new_text(tsolid_context *context, const char *text) {
  size_t size = strlen(text) + 1;
  char *copy = tsi_new(&context->allocator, size, 1);
  if (!copy)
    return NULL;
  memcpy(copy, text, size);
  for (char *c = copy; *c;) {
    int length = tsi_utf8_length(c);
    if (length == 0)
      *c = '?';
    c += length ? length : 1;
  }
  cJSON *item = cJSON_CreateString(copy);
  tsi_delete(&context->allocator, copy);
  return item;
}

/* What was noted in this context on the way here. Places are named by the texts. */
static void put_findings(writer *w, cJSON *root, tsolid_context *context) {
  static const char *const severity[] = {"note", "warning", "error"};
  cJSON *list = cJSON_AddArrayToObject(root, "findings");
  if (!list)
    w->failed = 1;
  for (int i = 0; i < context->n_findings; i++) {
    const tsolid_finding *f = &context->finding[i];
    cJSON *o = cJSON_CreateObject();
    add_text(w, o, "severity", severity[f->severity]);
    add_text(w, o, "stage", f->stage ? f->stage : "");
    add_text(w, o, "where", "");
    add(w, o, "text", new_text(context, f->text));
    add(w, o, "point", f->has_point ? new_numbers(w, f->point, 3) : cJSON_CreateNull());
    add_number(w, o, "measured", f->measured);
    add_number(w, o, "allowed", f->allowed);
    append(w, list, o);
  }
}

/* ---- driver ------------------------------------------------------------------------------------
 */

static void put_report(writer *w, cJSON *root, tsolid_context *context, tsolid_report *report) {
  add_text(w, root, "format", "tsolid report");
  add_number(w, root, "version", 1);
  put_requirement(w, add_object(w, root, "requirement"), &report->requirement);
  put_preparation(w, add_object(w, root, "preparation"), &report->preparation);
  put_statistics(w, add_object(w, root, "statistics"), &report->statistics);
  put_conformity(w, add_object(w, root, "conformity"), &report->conformity);
  put_basis(w, add_object(w, root, "basis"), &report->basis);
  put_continuity(w, add_object(w, root, "continuity"), &report->continuity);
  put_certificate(w, add_object(w, root, "certificate"), &report->certificate);
  put_quality(w, add_object(w, root, "quality"), &report->quality);
  put_timing(w, add_object(w, root, "timing"), &report->timing);
  put_findings(w, root, context);
}

tsolid_status tsolid_report_json(tsolid_context *context, const tsolid_report *report,
                                 char **json) {
  tsolid_status status = TSOLID_OK;
  writer w = {0};
  if (json)
    *json = NULL;
  if (!context || !report || !json)
    return TSOLID_ERROR_ARGUMENT;
  tsolid_report copy = *report; /* 2-D arrays cannot be passed as const in C11 */
  cJSON *root = cJSON_CreateObject();
  put_report(&w, root, context, &copy);
  char *text = w.failed ? NULL : cJSON_Print(root);
  size_t size = text ? strlen(text) + 1 : 0;
  *json = text ? tsi_new(&context->allocator, size, 1) : NULL;
  if (*json)
    memcpy(*json, text, size);
  else
    status = tsi_no_memory(context, stage);
  cJSON_free(text);
  cJSON_Delete(root);
  return status;
}
