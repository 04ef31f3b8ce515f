/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Writes extraction operators as one plain binary file, for programs that want nothing but numbers.
 *
 * Little-endian throughout; integers have 64 bits, numbers are IEEE doubles; nothing is padded:
 *
 *     8 bytes                     "tsolidE1"
 *     4 integers                  n_functions, n_elements, n_entries, n_coefficients
 *     control                     n_functions rows w x, w y, w z, w
 *     block                       n_elements integers: 0 the core, 1 + side an arm
 *     box                         n_elements rows lo[3], hi[3] in cross coordinates
 *     degree                      n_elements rows of 3
 *     function_start              n_elements + 1 integers: element e has the entries
 *                                 function_start[e] .. function_start[e+1]-1
 *     function                    n_entries integers, from 0, ascending within an element
 *     coefficient                 one row of (d0+1)(d1+1)(d2+1) Bernstein coefficients per entry,
 *                                 u[0] fastest
 *
 * The homogeneous Bezier points of element e are the sums of rows times control points. The names
 * and rows are those of BEXT, written out: no vector is shared. */
#include <stdlib.h>

#include "file_io.h"
#include "matrix.h"

static const char stage[] = "export";

typedef struct writer {
  tsi_output out;
  const tsolid_solid *solid;
  int most;
  int *function, *list; /* as the space gives them; ascending, each once */
  double *given, *sum;
} writer;

static void put_word(writer *w, uint64_t value) {
  unsigned char bytes[8];
  for (int k = 0; k < 8; k++)
    bytes[k] = (unsigned char)(value >> 8 * k & 255);
  tsi_output_add(&w->out, bytes, sizeof bytes);
}

static void put_double(writer *w, double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  put_word(w, bits);
}

static size_t width_of(const tsi_element *e) {
  return (size_t)(e->degree[0] + 1) * (size_t)(e->degree[1] + 1) * (size_t)(e->degree[2] + 1);
}

static int compare_ints(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

static void put_head(writer *w) {
  const tsolid_space *space = w->solid->space;
  uint64_t n_functions = (uint64_t)space->n_inner + 2 * (uint64_t)space->n_surface;
  uint64_t n = (uint64_t)space->n_elements, n_entries = 0, n_coefficients = 0;
  for (int e = 0; e < space->n_elements; e++) {
    uint64_t count = (uint64_t)tsi_element_function_list(space, e, w->list);
    n_entries += count;
    n_coefficients += count * width_of(&space->element[e]);
  }
  tsi_output_add(&w->out, "tsolidE1", 8);
  put_word(w, n_functions);
  put_word(w, n);
  put_word(w, n_entries);
  put_word(w, n_coefficients);
  for (size_t k = 0; k < 4 * n_functions; k++)
    put_double(w, w->solid->control[k]);
  for (int e = 0; e < space->n_elements; e++)
    put_word(w, (uint64_t)space->element[e].block);
  for (int e = 0; e < space->n_elements; e++)
    for (int k = 0; k < 6; k++)
      put_double(w, space->element[e].box[k]);
  for (int e = 0; e < space->n_elements; e++)
    for (int k = 0; k < 3; k++)
      put_word(w, (uint64_t)space->element[e].degree[k]);
}

static void put_functions(writer *w) {
  const tsolid_space *space = w->solid->space;
  uint64_t start = 0;
  put_word(w, 0);
  for (int e = 0; e < space->n_elements; e++)
    put_word(w, start += (uint64_t)tsi_element_function_list(space, e, w->list));
  for (int e = 0; e < space->n_elements; e++) {
    int n = tsi_element_function_list(space, e, w->list);
    for (int k = 0; k < n; k++)
      put_word(w, (uint64_t)w->list[k]);
  }
}

/* A function of several pieces on the element has the sum of their coefficients. */
static tsolid_status put_rows(writer *w, int element) {
  const tsolid_space *space = w->solid->space;
  size_t width = width_of(&space->element[element]);
  int n = 0, n_list = tsi_element_function_list(space, element, w->list);
  tsolid_status status =
      tsolid_space_extraction(w->out.context, space, element, w->most, &n, w->function, w->given);
  if (status)
    return status;
  memset(w->sum, 0, (size_t)n_list * width * sizeof *w->sum);
  for (int k = 0; k < n; k++) {
    const int *at = bsearch(&w->function[k], w->list, (size_t)n_list, sizeof *at, compare_ints);
    for (size_t i = 0; at && i < width; i++)
      w->sum[(size_t)(at - w->list) * width + i] += w->given[(size_t)k * width + i];
  }
  for (size_t i = 0; i < (size_t)n_list * width; i++)
    put_double(w, w->sum[i]);
  return element % 64 ? TSOLID_OK
                      : tsi_progress(w->out.context, stage, (double)element / space->n_elements);
}

static tsolid_status put_document(writer *w) {
  tsolid_status status = TSOLID_OK;
  put_head(w);
  put_functions(w);
  for (int e = 0; e < w->solid->space->n_elements && !status && !w->out.status; e++)
    status = put_rows(w, e);
  return status;
}

tsolid_status tsolid_write_extraction(tsolid_context *context, const tsolid_solid *solid,
                                      const char *path) {
  if (!context || !solid || !path)
    return TSOLID_ERROR_ARGUMENT;
  writer w = {.solid = solid, .most = tsi_most_functions(solid->space)};
  size_t most = (size_t)w.most, width = 0;
  tsolid_status status = TSOLID_OK;
  for (int e = 0; e < solid->space->n_elements; e++)
    width =
        width_of(&solid->space->element[e]) > width ? width_of(&solid->space->element[e]) : width;
  tsi_arena arena = tsi_arena_create(context);
  w.function = tsi_arena_new(&arena, most, sizeof *w.function);
  w.list = tsi_arena_new(&arena, most, sizeof *w.list);
  w.given = tsi_arena_new(&arena, most * width, sizeof *w.given);
  w.sum = tsi_arena_new(&arena, most * width, sizeof *w.sum);
  if (!w.function || !w.list || !w.given || !w.sum) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  if (tsi_output_open(&w.out, context, stage, path) == TSOLID_OK)
    status = put_document(&w);
  status = tsi_output_close(&w.out, status);
done:
  tsi_arena_free(&arena);
  return status;
}
