/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Reads a dense table of numbers: MatrixMarket text ("array", real or integer, general; numbers
 * column by column) or a vector in PETSc's binary form (big-endian: class id, length, numbers). */
#include "file_io.h"

static const char stage[] = "read";

enum { VECTOR_CLASS = 1211214, WORD_SIZE = 24 };
static const size_t largest_file = (size_t)1 << 34;

typedef struct table {
  tsolid_context *context;
  const char *path, *at, *end;
  int n_rows, n_columns;
  double *value;
} table;

static tsolid_status fail(const table *t, const char *text) {
  return tsi_fail(t->context, TSOLID_ERROR_INPUT, stage, "'%s': %s", t->path, text);
}

static tsolid_status new_values(table *t, size_t most) {
  size_t n = (size_t)t->n_rows * (size_t)t->n_columns;
  if (n > TSI_MAX_COUNT || n > most)
    return fail(t, "more numbers are announced than the file can hold");
  t->value = tsi_new(&t->context->allocator, n, sizeof *t->value);
  return t->value ? TSOLID_OK : tsi_no_memory(t->context, stage);
}

/* ---- PETSc -------------------------------------------------------------------------------------
 */

static uint64_t get_big(const char *bytes, int size) {
  uint64_t value = 0;
  for (int k = 0; k < size; k++)
    value = value << 8 | (unsigned char)bytes[k];
  return value;
}

static tsolid_status read_petsc(table *t) {
  size_t size = (size_t)(t->end - t->at);
  uint64_t n = get_big(t->at + 4, 4);
  if (n > TSI_MAX_COUNT || size != 8 + 8 * n)
    return fail(t, "the length of the file is not that of the vector");
  t->n_rows = (int)n;
  t->n_columns = 1;
  tsolid_status status = new_values(t, (size_t)n);
  for (size_t k = 0; !status && k < n; k++) {
    uint64_t bits = get_big(t->at + 8 + 8 * k, 8);
    memcpy(&t->value[k], &bits, sizeof bits);
    if (!isfinite(t->value[k]))
      return fail(t, "a number is not finite");
  }
  return status;
}

/* ---- MatrixMarket ------------------------------------------------------------------------------
 */

static int is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* The next word in small letters; longer ones than any that is known become empty. */
static void take_word(table *t, char word[WORD_SIZE]) {
  size_t n = 0;
  while (t->at < t->end && is_blank(*t->at))
    t->at++;
  for (; t->at < t->end && !is_blank(*t->at); t->at++)
    if (n < WORD_SIZE)
      word[n++] = *t->at >= 'A' && *t->at <= 'Z' ? (char)(*t->at - 'A' + 'a') : *t->at;
  word[n < WORD_SIZE ? n : 0] = 0;
}

static void skip_comments(table *t) {
  for (;;) {
    while (t->at < t->end && is_blank(*t->at))
      t->at++;
    if (t->at == t->end || *t->at != '%')
      return;
    while (t->at < t->end && *t->at != '\n')
      t->at++;
  }
}

static int take_number(table *t, double *value) {
  const char *stop;
  while (t->at < t->end && is_blank(*t->at))
    t->at++;
  if (t->at == t->end)
    return 0;
  *value = tsi_number_parse(t->at, &stop);
  if (stop == t->at || (stop < t->end && !is_blank(*stop)) || !isfinite(*value))
    return 0;
  t->at = stop;
  return 1;
}

static int take_count(table *t, int *count) {
  double value;
  if (!take_number(t, &value) || !(value >= 1 && value <= TSI_MAX_COUNT) || value != floor(value))
    return 0;
  *count = (int)value;
  return 1;
}

static int take_head(table *t) {
  static const char *const wanted[] = {"%%matrixmarket", "matrix", "array", "real", "general"};
  char word[WORD_SIZE];
  for (int k = 0; k < 5; k++) {
    take_word(t, word);
    if (strcmp(word, wanted[k]) != 0 && !(k == 3 && strcmp(word, "integer") == 0))
      return 0;
  }
  skip_comments(t);
  return 1;
}

static tsolid_status read_market(table *t) {
  if (!take_head(t))
    return fail(t, "neither a dense MatrixMarket file ('%%MatrixMarket matrix array real general') "
                   "nor a PETSc vector");
  if (!take_count(t, &t->n_rows) || !take_count(t, &t->n_columns))
    return fail(t, "the numbers of rows and columns are expected");
  tsolid_status status = new_values(t, ((size_t)(t->end - t->at) + 1) / 2);
  for (int j = 0; !status && j < t->n_columns; j++)
    for (int i = 0; i < t->n_rows; i++)
      if (!take_number(t, &t->value[(size_t)i * (size_t)t->n_columns + (size_t)j]))
        return fail(t, "a finite number is expected, or the file ends before its last number");
  skip_comments(t);
  return status || t->at == t->end ? status : fail(t, "there is more behind the last number");
}

/* ---- public ------------------------------------------------------------------------------------
 */

tsolid_status tsolid_read_table(tsolid_context *context, const char *path, int *n_rows,
                                int *n_columns, double **value) {
  char *bytes = NULL;
  size_t size = 0;
  if (!context || !path || !n_rows || !n_columns || !value)
    return TSOLID_ERROR_ARGUMENT;
  *n_rows = *n_columns = 0;
  *value = NULL;
  tsolid_status status = tsi_file_read(context, stage, path, largest_file, &bytes, &size);
  table t = {.context = context, .path = path, .at = bytes, .end = bytes ? bytes + size : NULL};
  if (status)
    return status;
  status = size >= 8 && get_big(bytes, 4) == VECTOR_CLASS ? read_petsc(&t) : read_market(&t);
  tsi_delete(&context->allocator, bytes);
  if (status) {
    tsi_delete(&context->allocator, t.value);
    return status;
  }
  *n_rows = t.n_rows;
  *n_columns = t.n_columns;
  *value = t.value;
  return TSOLID_OK;
}
