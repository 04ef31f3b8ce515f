/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Reports as JSON documents: what the writers of reports share. What is not a number is null. */
#ifndef TSI_JSON_WRITER_H
#define TSI_JSON_WRITER_H

#include <cjson/cJSON.h>

#include "internal.h"

/* Adding to NULL, or NULL to something, gives NULL in cJSON: failures stick. */
typedef struct tsi_doc {
  int failed;
} tsi_doc;

cJSON *tsi_doc_number(double value);
cJSON *tsi_doc_numbers(tsi_doc *w, const double *value, int n);
/* Texts hold names from files: what is no UTF-8 becomes '?'. NULL: no memory. */
cJSON *tsi_doc_text(tsolid_context *context, const char *text);
void tsi_doc_add(tsi_doc *w, cJSON *object, const char *key, cJSON *item);
void tsi_doc_append(tsi_doc *w, cJSON *list, cJSON *item);
cJSON *tsi_doc_add_object(tsi_doc *w, cJSON *parent, const char *key);
void tsi_doc_add_number(tsi_doc *w, cJSON *object, const char *key, double value);
void tsi_doc_add_flag(tsi_doc *w, cJSON *object, const char *key, int value);
void tsi_doc_add_text(tsi_doc *w, cJSON *object, const char *key, const char *text);
void tsi_doc_add_numbers(tsi_doc *w, cJSON *object, const char *key, const double *value, int n);
/* Up to the last that is not zero. */
void tsi_doc_add_counts(tsi_doc *w, cJSON *object, const char *key, const int *value, int n);
void tsi_doc_add_points(tsi_doc *w, cJSON *object, const char *key, double (*point)[3], int n);
/* What was noted in this context on the way here, as "findings". Places are named by the texts. */
void tsi_doc_add_findings(tsi_doc *w, cJSON *root, tsolid_context *context);
/* The document as text of the context's allocator, or its finding. Takes root. */
tsolid_status tsi_doc_finish(tsi_doc *w, tsolid_context *context, cJSON *root, char **json);

#endif
