/* SPDX-License-Identifier: LGPL-2.1-or-later
 * JSON documents from numbers, flags and texts. */
#include "json_writer.h"

#include "file_io.h"
#include "json_reader.h"

static const char stage[] = "report";

/* ---- values ------------------------------------------------------------------------------------
 */

/* cJSON's own numbers do not read back exactly and depend on the locale. */
cJSON *tsi_doc_number(double value) {
  char text[TSI_NUMBER_SIZE];
  if (!isfinite(value))
    return cJSON_CreateNull();
  tsi_number_print(value, text);
  return cJSON_CreateRaw(text);
}

void tsi_doc_add(tsi_doc *w, cJSON *object, const char *key, cJSON *item) {
  if (object && item && cJSON_AddItemToObject(object, key, item))
    return;
  cJSON_Delete(item);
  w->failed = 1;
}

void tsi_doc_append(tsi_doc *w, cJSON *list, cJSON *item) {
  if (list && item && cJSON_AddItemToArray(list, item))
    return;
  cJSON_Delete(item);
  w->failed = 1;
}

cJSON *tsi_doc_add_object(tsi_doc *w, cJSON *parent, const char *key) {
  cJSON *object = cJSON_AddObjectToObject(parent, key);
  if (!object)
    w->failed = 1;
  return object;
}

void tsi_doc_add_number(tsi_doc *w, cJSON *object, const char *key, double value) {
  tsi_doc_add(w, object, key, tsi_doc_number(value));
}

void tsi_doc_add_flag(tsi_doc *w, cJSON *object, const char *key, int value) {
  tsi_doc_add(w, object, key, cJSON_CreateBool(value));
}

void tsi_doc_add_text(tsi_doc *w, cJSON *object, const char *key, const char *text) {
  tsi_doc_add(w, object, key, cJSON_CreateString(text));
}

cJSON *tsi_doc_numbers(tsi_doc *w, const double *value, int n) {
  cJSON *list = cJSON_CreateArray();
  for (int k = 0; k < n; k++)
    tsi_doc_append(w, list, tsi_doc_number(value[k]));
  return list;
}

void tsi_doc_add_numbers(tsi_doc *w, cJSON *object, const char *key, const double *value, int n) {
  tsi_doc_add(w, object, key, tsi_doc_numbers(w, value, n));
}

void tsi_doc_add_counts(tsi_doc *w, cJSON *object, const char *key, const int *value, int n) {
  cJSON *list = cJSON_CreateArray();
  while (n > 0 && value[n - 1] == 0)
    n--;
  for (int k = 0; k < n; k++)
    tsi_doc_append(w, list, tsi_doc_number(value[k]));
  tsi_doc_add(w, object, key, list);
}

void tsi_doc_add_points(tsi_doc *w, cJSON *object, const char *key, double (*point)[3], int n) {
  cJSON *list = cJSON_CreateArray();
  for (int k = 0; k < n; k++)
    tsi_doc_append(w, list, tsi_doc_numbers(w, point[k], 3));
  tsi_doc_add(w, object, key, list);
}

cJSON *tsi_doc_text(tsolid_context *context, const char *text) {
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

void tsi_doc_add_findings(tsi_doc *w, cJSON *root, tsolid_context *context) {
  static const char *const severity[] = {"note", "warning", "error"};
  cJSON *list = cJSON_AddArrayToObject(root, "findings");
  if (!list)
    w->failed = 1;
  for (int i = 0; i < context->n_findings; i++) {
    const tsolid_finding *f = &context->finding[i];
    cJSON *o = cJSON_CreateObject();
    tsi_doc_add_text(w, o, "severity", severity[f->severity]);
    tsi_doc_add_text(w, o, "stage", f->stage ? f->stage : "");
    tsi_doc_add_text(w, o, "where", "");
    tsi_doc_add(w, o, "text", tsi_doc_text(context, f->text));
    tsi_doc_add(w, o, "point", f->has_point ? tsi_doc_numbers(w, f->point, 3) : cJSON_CreateNull());
    tsi_doc_add_number(w, o, "measured", f->measured);
    tsi_doc_add_number(w, o, "allowed", f->allowed);
    tsi_doc_append(w, list, o);
  }
}

/* ---- the document ------------------------------------------------------------------------------
 */

tsolid_status tsi_doc_finish(tsi_doc *w, tsolid_context *context, cJSON *root, char **json) {
  tsolid_status status = TSOLID_OK;
  char *text = w->failed ? NULL : cJSON_Print(root);
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
