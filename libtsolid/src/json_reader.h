/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A pull reader for JSON: the caller asks for what the grammar has next, and whatever else stands
 * there becomes one finding with its line and its place in the document. It never recurses and
 * builds no tree, so its memory is that of the text. */
#ifndef TSI_JSON_READER_H
#define TSI_JSON_READER_H

#include "internal.h"

enum { TSI_JSON_DEPTH = 16, TSI_JSON_KEY = 32 };

typedef struct tsi_json {
  tsolid_context *context;
  const char *stage;
  const char *path;       /* of the file, for messages */
  const char *text, *end; /* a zero byte stands at end */
  const char *at;
  int depth;
  struct {
    char closing; /* ']' or '}' */
    int index;    /* items begun so far, minus one */
    char key[TSI_JSON_KEY];
  } step[TSI_JSON_DEPTH];
  tsolid_status status;
} tsi_json;

void tsi_json_start(tsi_json *json, tsolid_context *context, const char *stage, const char *path,
                    const char *text, size_t size);

/* A finding of TSOLID_ERROR_INPUT with file, line and place; the first one only. Returns 0. */
int tsi_json_fail(tsi_json *json, const char *format, ...) TSI_PRINTF(2, 3);

/* All of these return 1, or 0 after a failure (json->status).
 *
 *   if (tsi_json_enter(json, '['))
 *     while (tsi_json_next(json))
 *       read one value
 *
 * tsi_json_next returns 0 at the closing bracket, too; in an object it has read the key. */
int tsi_json_enter(tsi_json *json, char opening);
int tsi_json_next(tsi_json *json);
/* The current key's index among names (NULL ends them), or -1 after a failure: unknown or seen. */
int tsi_json_key(tsi_json *json, const char *const *names, unsigned *seen);
int tsi_json_number(tsi_json *json, double *value);
int tsi_json_integer(tsi_json *json, int low, int high, int *value);
/* UTF-8 without zero bytes, in the arena. */
int tsi_json_string(tsi_json *json, tsi_arena *arena, const char **value);
/* Length of the well-formed UTF-8 sequence at c, 0 for none; reads no further than a zero byte. */
int tsi_utf8_length(const char *c);
/* Nothing but white space may follow. */
int tsi_json_finish(tsi_json *json);

#endif
