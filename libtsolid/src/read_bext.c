/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Reads Bezier extraction as BEXT 2.0 text. Grammar and what is taken: blocks of trivariate
 * elements of type 1 (general) with dense coefficient vectors; numbers between blanks or commas;
 * "$" begins a comment. Every count is checked against the length of the text before memory is
 * asked for. */
#include <limits.h>

#include "file_io.h"

static const char stage[] = "read";

static const size_t largest_file = (size_t)1 << 32;

struct tsolid_bext {
  tsi_allocator allocator;
  int references;
  tsi_arena arena;
  tsolid_bext_view view;
};

typedef struct reader {
  tsolid_context *context;
  const char *path, *at, *end;
  int line;
  tsolid_status status;
} reader;

typedef struct element_block {
  int n_elements, n_functions, degree[3];
} element_block;

static int fail(reader *r, const char *text) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
  finding.entity = TSOLID_ENTITY_LINE;
  finding.index[0] = r->line;
  if (!r->status)
    r->status = tsi_report(r->context, &finding, "Line %d of '%s': %s", r->line, r->path, text);
  return 0;
}

/* ---- tokens ------------------------------------------------------------------------------------
 */

static int is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == '\n';
}

static void skip_blanks(reader *r) {
  while (r->at < r->end) {
    if (*r->at == '$') {
      while (r->at < r->end && *r->at != '\n')
        r->at++;
    } else if (is_blank(*r->at)) {
      r->line += *r->at == '\n';
      r->at++;
    } else {
      return;
    }
  }
}

static int read_real(reader *r, long double *value) {
  const char *stop;
  skip_blanks(r);
  if (r->at == r->end)
    return fail(r, "the file ends before its last number");
  *value = tsi_number_parse_long(r->at, &stop);
  if (stop == r->at || (stop < r->end && !is_blank(*stop)) || !isfinite(*value))
    return fail(r, "a finite number is expected");
  r->at = stop;
  return 1;
}

static int read_integer(reader *r, int low, int high, int *value) {
  long double number;
  if (!read_real(r, &number))
    return 0;
  if (!(number >= low && number <= high) || number != floorl(number))
    return fail(r, "a whole number is expected, or it is out of range");
  *value = (int)number;
  return 1;
}

/* How many numbers the rest of the text can hold. */
static size_t numbers_left(const reader *r) {
  return ((size_t)(r->end - r->at) + 1) / 2;
}

static int expect_room(reader *r, double n) {
  return n <= (double)numbers_left(r) && n <= (double)TSI_MAX_COUNT
             ? 1
             : fail(r, "more numbers are announced than the file can hold");
}

static void *new_array(reader *r, tsolid_bext *bext, size_t n, size_t size) {
  void *memory = tsi_arena_new(&bext->arena, n, size);
  if (!memory)
    r->status = tsi_no_memory(r->context, stage);
  return memory;
}

/* ---- blocks ------------------------------------------------------------------------------------
 */

static int read_head(reader *r, tsolid_bext_view *v) {
  static const char *const word[] = {"B", "E", "X", "T", "2.0"};
  for (int k = 0; k < 5; k++) {
    size_t n = strlen(word[k]);
    skip_blanks(r);
    if ((size_t)(r->end - r->at) <= n || memcmp(r->at, word[k], n) != 0 || !is_blank(r->at[n]))
      return fail(r, "this is no BEXT 2.0 text: 'B E X T 2.0' does not stand on its first line");
    r->at += n;
  }
  return read_integer(r, INT_MIN, INT_MAX, &v->patch) &&
         read_integer(r, 1, TSI_MAX_COUNT, &v->n_nodes) &&
         read_integer(r, 1, TSI_MAX_COUNT, &v->n_elements) &&
         read_integer(r, 1, TSI_MAX_COUNT, &v->n_vectors) && read_integer(r, 0, 1, &v->rational);
}

static int read_nodes(reader *r, tsolid_bext *bext) {
  tsolid_bext_view *v = &bext->view;
  if (!expect_room(r, 4.0 * v->n_nodes))
    return 0;
  double *node = new_array(r, bext, (size_t)v->n_nodes, 4 * sizeof *node);
  double *control = new_array(r, bext, (size_t)v->n_nodes, 4 * sizeof *control);
  if (!node || !control)
    return 0;
  for (size_t k = 0; k < (size_t)v->n_nodes; k++) {
    long double x[4];
    for (int c = 0; c < 4; c++)
      if (!read_real(r, &x[c]))
        return 0;
    long double w = (double)x[3]; /* as it was written: fewer digits than the coordinates' */
    if (!(w > 0))
      return fail(r, "a weight is not positive");
    for (size_t c = 0; c < 4; c++) {
      node[4 * k + c] = (double)x[c];
      control[4 * k + c] = (double)(c < 3 ? x[c] * w : w);
    }
  }
  v->nodes = node;
  v->control = control;
  return 1;
}

static int read_blocks(reader *r, tsolid_bext *bext, int *n_blocks, element_block **block) {
  double n_elements = 0.0, n_entries = 0.0;
  if (!read_integer(r, 1, bext->view.n_elements, n_blocks) || !expect_room(r, 7.0 * *n_blocks))
    return 0;
  *block = new_array(r, bext, (size_t)*n_blocks, sizeof **block);
  if (!*block)
    return 0;
  for (int k = 0; k < *n_blocks; k++) {
    element_block *b = &(*block)[k];
    int type, n_vectors;
    if (!read_integer(r, 0, INT_MAX, &type))
      return 0;
    if (type != 1)
      return fail(r, "elements of this type are not read, only those of type 1 (general)");
    if (!read_integer(r, 1, bext->view.n_elements, &b->n_elements) ||
        !read_integer(r, 1, bext->view.n_nodes, &b->n_functions) ||
        !read_integer(r, 1, TSI_MAX_COUNT, &n_vectors))
      return 0;
    if (n_vectors != b->n_functions)
      return fail(r, "an element needs as many coefficient vectors as nodes");
    for (int d = 0; d < 3; d++)
      if (!read_integer(r, 1, TSI_MAX_DEGREE, &b->degree[d]))
        return 0;
    n_elements += b->n_elements;
    n_entries += (double)b->n_elements * b->n_functions;
  }
  if (n_elements != bext->view.n_elements)
    return fail(r, "the blocks do not hold as many elements as the head says");
  return expect_room(r, 2.0 * n_entries);
}

static int read_elements(reader *r, tsolid_bext *bext) {
  tsolid_bext_view *v = &bext->view;
  element_block *block = NULL;
  int n_blocks, at = 0, e = 0;
  size_t n_entries = 0;
  if (!read_blocks(r, bext, &n_blocks, &block))
    return 0;
  for (int k = 0; k < n_blocks; k++)
    n_entries += (size_t)block[k].n_elements * (size_t)block[k].n_functions;
  int *degree = new_array(r, bext, (size_t)v->n_elements, 3 * sizeof *degree);
  int *start = new_array(r, bext, (size_t)v->n_elements + 1, sizeof *start);
  int *function = new_array(r, bext, n_entries, sizeof *function);
  int *vector = new_array(r, bext, n_entries, sizeof *vector);
  if (!degree || !start || !function || !vector)
    return 0;
  for (int k = 0; k < n_blocks; k++)
    for (int i = 0; i < block[k].n_elements; i++, e++) {
      memcpy(degree + 3 * e, block[k].degree, sizeof block[k].degree);
      for (int pass = 0; pass < 2; pass++)
        for (int f = 0; f < block[k].n_functions; f++) {
          int *to = (pass ? vector : function) + at + f;
          if (!read_integer(r, 1, pass ? v->n_vectors : v->n_nodes, to))
            return 0;
          --*to;
        }
      at += block[k].n_functions;
      start[e + 1] = at;
    }
  v->degree = degree;
  v->function_start = start;
  v->function = function;
  v->vector = vector;
  return 1;
}

static int read_vectors(reader *r, tsolid_bext *bext) {
  tsolid_bext_view *v = &bext->view;
  int n_dense, n_sparse, at = 0;
  if (!read_integer(r, 0, v->n_vectors, &n_dense) || !read_integer(r, 0, INT_MAX, &n_sparse))
    return 0;
  if (n_sparse)
    return fail(r, "sparse coefficient vectors are not read");
  int *start = new_array(r, bext, (size_t)v->n_vectors + 1, sizeof *start);
  if (!start)
    return 0;
  for (int k = 0; k < n_dense; k++) {
    int n, length;
    if (!read_integer(r, 1, v->n_vectors - at, &n) || !read_integer(r, 1, TSI_MAX_COUNT, &length) ||
        !expect_room(r, start[at] + (double)n * length))
      return 0;
    for (int i = 0; i < n; i++, at++)
      start[at + 1] = start[at] + length;
  }
  if (at != v->n_vectors)
    return fail(r, "there are fewer coefficient vectors than the head says");
  double *coefficient = new_array(r, bext, (size_t)start[at], sizeof *coefficient);
  if (!coefficient)
    return 0;
  for (int k = 0; k < start[at]; k++) {
    long double value;
    if (!read_real(r, &value))
      return 0;
    coefficient[k] = (double)value;
  }
  v->vector_start = start;
  v->coefficient = coefficient;
  return 1;
}

static int check_lengths(reader *r, const tsolid_bext_view *v) {
  for (int e = 0; e < v->n_elements; e++) {
    const int *degree = v->degree + 3 * e;
    int width = (degree[0] + 1) * (degree[1] + 1) * (degree[2] + 1);
    for (int k = v->function_start[e]; k < v->function_start[e + 1]; k++)
      if (v->vector_start[v->vector[k] + 1] - v->vector_start[v->vector[k]] != width)
        return fail(r,
                    "a coefficient vector has not the length that its element's degrees ask for");
  }
  return 1;
}

/* ---- public ------------------------------------------------------------------------------------
 */

tsolid_status tsolid_read_bext(tsolid_context *context, const char *path, tsolid_bext **result) {
  char *bytes = NULL;
  size_t size = 0;
  if (!context || !result)
    return TSOLID_ERROR_ARGUMENT;
  *result = NULL;
  if (!path)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "The path is NULL");
  tsolid_status status = tsi_file_read(context, stage, path, largest_file, &bytes, &size);
  if (status)
    return status;
  tsolid_bext *bext = tsi_new(&context->allocator, 1, sizeof *bext);
  if (!bext) {
    tsi_delete(&context->allocator, bytes);
    return tsi_no_memory(context, stage);
  }
  bext->allocator = context->allocator;
  bext->references = 1;
  bext->arena = (tsi_arena){&bext->allocator, NULL};
  reader r = {.context = context, .path = path, .at = bytes, .end = bytes + size, .line = 1};
  if (read_head(&r, &bext->view) && read_nodes(&r, bext) && read_elements(&r, bext) &&
      read_vectors(&r, bext) && check_lengths(&r, &bext->view))
    *result = bext;
  else
    tsolid_bext_free(bext);
  tsi_delete(&context->allocator, bytes);
  return r.status;
}

void tsolid_bext_free(tsolid_bext *bext) {
  if (!bext || --bext->references > 0)
    return;
  tsi_allocator allocator = bext->allocator;
  tsi_arena_free(&bext->arena);
  tsi_delete(&allocator, bext);
}

void tsolid_bext_get(const tsolid_bext *bext, tsolid_bext_view *view) {
  *view = bext->view;
}
