/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Writes the Bezier extraction of a solid as BEXT 2.0 text (Coreform, LS-DYNA, libMesh).
 *
 * Blocks: patch; nodes, Euclidean with weights; elements, grouped by number of functions and
 * degrees, each with its nodes in ascending order and one coefficient vector per node; coefficient
 * vectors, dense, equal ones stored once. Identifiers count from 1; Bernstein coefficients run with
 * u[0] fastest. Coordinates have as many digits as bring the homogeneous control points back bit
 * for bit where long double is wider than double.
 *
 * The grammar that is known of this format has no side sets, so they stand in comments behind the
 * last block, which readers pass over: "$#SIDE SET name n", then n lines "$# element face" with the
 * elements as the file numbers them, from 1, and faces 1 .. 6 = u[0] low, high, u[1] low, ... */

#include <stdlib.h>

#include "file_io.h"

static const char stage[] = "export";

enum { IDS_PER_LINE = 10, NUMBERS_PER_LINE = 5 };

/* ---- shared coefficient vectors ----------------------------------------------------------------
 */

/* Vectors by length, found again through a hash table with open addressing. */
typedef struct vector_pool {
  const tsi_allocator *allocator;
  double *value;
  size_t n_values, value_capacity;
  size_t *start; /* n_vectors + 1 */
  int n_vectors, vector_capacity;
  int *slot; /* number of a vector + 1; 0: free */
  size_t n_slots;
} vector_pool;

static int grow(const tsi_allocator *allocator, void **memory, size_t used, size_t wanted,
                size_t size) {
  void *larger = tsi_new(allocator, wanted, size);
  if (!larger)
    return 0;
  if (used)
    memcpy(larger, *memory, used * size);
  tsi_delete(allocator, *memory);
  *memory = larger;
  return 1;
}

static uint64_t hash_vector(const double *value, size_t n) {
  uint64_t hash = 1469598103934665603u ^ n;
  for (size_t i = 0; i < n; i++) {
    uint64_t bits;
    memcpy(&bits, &value[i], sizeof bits);
    hash = (hash ^ bits) * 1099511628211u;
    hash ^= hash >> 29;
  }
  return hash;
}

static size_t find_slot(const vector_pool *pool, const double *value, size_t n) {
  size_t slot = (size_t)hash_vector(value, n) & (pool->n_slots - 1);
  for (; pool->slot[slot]; slot = (slot + 1) & (pool->n_slots - 1)) {
    size_t first = pool->start[pool->slot[slot] - 1],
           length = pool->start[pool->slot[slot]] - first;
    if (length == n && memcmp(pool->value + first, value, n * sizeof *value) == 0)
      break;
  }
  return slot;
}

static int rehash(vector_pool *pool) {
  size_t n_slots = pool->n_slots ? 2 * pool->n_slots : 1024;
  int *slot = tsi_new(pool->allocator, n_slots, sizeof *slot);
  if (!slot)
    return 0;
  tsi_delete(pool->allocator, pool->slot);
  pool->slot = slot;
  pool->n_slots = n_slots;
  for (int k = 0; k < pool->n_vectors; k++) {
    size_t n = pool->start[k + 1] - pool->start[k];
    slot[find_slot(pool, pool->value + pool->start[k], n)] = k + 1;
  }
  return 1;
}

/* Number of the vector in the pool; -1: no memory. */
static int add_vector(vector_pool *pool, const double *value, size_t n) {
  if (2 * ((size_t)pool->n_vectors + 1) > pool->n_slots && !rehash(pool))
    return -1;
  size_t slot = find_slot(pool, value, n);
  if (pool->slot[slot])
    return pool->slot[slot] - 1;
  if (pool->n_values + n > pool->value_capacity) {
    size_t wanted = 2 * (pool->n_values + n);
    if (!grow(pool->allocator, (void **)&pool->value, pool->n_values, wanted, sizeof(double)))
      return -1;
    pool->value_capacity = wanted;
  }
  if (pool->n_vectors + 2 > pool->vector_capacity) {
    int wanted = 2 * pool->n_vectors + 64;
    size_t used = pool->n_vectors ? (size_t)pool->n_vectors + 1 : 0;
    if (!grow(pool->allocator, (void **)&pool->start, used, (size_t)wanted, sizeof(size_t)))
      return -1;
    pool->vector_capacity = wanted;
  }
  memcpy(pool->value + pool->n_values, value, n * sizeof *value);
  pool->n_values += n;
  pool->start[++pool->n_vectors] = pool->n_values;
  pool->slot[slot] = pool->n_vectors;
  return pool->n_vectors - 1;
}

static void free_pool(vector_pool *pool) {
  tsi_delete(pool->allocator, pool->value);
  tsi_delete(pool->allocator, pool->start);
  tsi_delete(pool->allocator, pool->slot);
}

/* ---- elements ----------------------------------------------------------------------------------
 */

typedef struct extraction {
  const tsolid_solid *solid;
  vector_pool pool;
  int *entry_start; /* n_elements + 1 */
  int *function, *vector;
  int n_blocks, *block_of, *block_first; /* by element; the block's first element */
  int *number;                           /* of each element in the file, from 1 */
} extraction;

static size_t element_width(const tsi_element *element) {
  return (size_t)(element->degree[0] + 1) * (size_t)(element->degree[1] + 1) *
         (size_t)(element->degree[2] + 1);
}

typedef struct entry {
  int function, index;
} entry;

static int compare_entries(const void *a, const void *b) {
  const entry *p = a, *q = b;
  return p->function != q->function ? (p->function > q->function) - (p->function < q->function)
                                    : (p->index > q->index) - (p->index < q->index);
}

/* Functions in ascending order into x, the same function with the sum of its coefficients once.
 * Returns how many there are, or -1: no memory. */
static int add_element(extraction *x, int at, int n, size_t width, entry *order, double *sum,
                       const int *function, const double *coefficient) {
  int kept = 0;
  for (int k = 0; k < n; k++)
    order[k] = (entry){function[k], k};
  qsort(order, (size_t)n, sizeof *order, compare_entries);
  for (int k = 0, end; k < n; k = end, kept++) {
    memcpy(sum, coefficient + (size_t)order[k].index * width, width * sizeof *sum);
    for (end = k + 1; end < n && order[end].function == order[k].function; end++)
      for (size_t i = 0; i < width; i++)
        sum[i] += coefficient[(size_t)order[end].index * width + i];
    x->function[at + kept] = order[k].function;
    x->vector[at + kept] = add_vector(&x->pool, sum, width);
    if (x->vector[at + kept] < 0)
      return -1;
  }
  return kept;
}

static tsolid_status extract(tsolid_context *context, tsi_arena *arena, extraction *x) {
  const tsolid_space *space = x->solid->space;
  size_t room = 0, total = 0, width = 0;
  int most = 0, at = 0;
  for (int e = 0; e < space->n_elements; e++) {
    int n = 0;
    tsolid_status status = tsolid_space_extraction(context, space, e, 0, &n, NULL, NULL);
    if (status)
      return status;
    size_t own = element_width(&space->element[e]);
    total += (size_t)n;
    most = n > most ? n : most;
    width = own > width ? own : width;
    room = (size_t)n * own > room ? (size_t)n * own : room;
  }
  if (total > TSI_MAX_COUNT)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "The solid is too large for BEXT");
  int *function = tsi_arena_new(arena, (size_t)most, sizeof *function);
  entry *order = tsi_arena_new(arena, (size_t)most, sizeof *order);
  double *coefficient = tsi_arena_new(arena, room, sizeof *coefficient);
  double *sum = tsi_arena_new(arena, width, sizeof *sum);
  x->entry_start = tsi_arena_new(arena, (size_t)space->n_elements + 1, sizeof *x->entry_start);
  x->function = tsi_arena_new(arena, total, sizeof *x->function);
  x->vector = tsi_arena_new(arena, total, sizeof *x->vector);
  if (!function || !order || !coefficient || !sum || !x->entry_start || !x->function || !x->vector)
    return tsi_no_memory(context, stage);
  for (int e = 0; e < space->n_elements; e++) {
    int n = 0;
    tsolid_status status =
        tsolid_space_extraction(context, space, e, most, &n, function, coefficient);
    if (!status && e % 64 == 0)
      status = tsi_progress(context, stage, 0.5 * e / space->n_elements);
    if (status)
      return status;
    n = add_element(x, at, n, element_width(&space->element[e]), order, sum, function, coefficient);
    if (n < 0)
      return tsi_no_memory(context, stage);
    at += n;
    x->entry_start[e + 1] = at;
  }
  return TSOLID_OK;
}

/* Blocks of elements with equal degrees and numbers of functions, by first appearance. */
static tsolid_status group(tsolid_context *context, tsi_arena *arena, extraction *x) {
  const tsolid_space *space = x->solid->space;
  size_t n = (size_t)space->n_elements;
  x->block_of = tsi_arena_new(arena, n, sizeof *x->block_of);
  x->block_first = tsi_arena_new(arena, n, sizeof *x->block_first);
  x->number = tsi_arena_new(arena, n, sizeof *x->number);
  if (!x->block_of || !x->block_first || !x->number)
    return tsi_no_memory(context, stage);
  for (int e = 0; e < space->n_elements; e++) {
    int block = 0, size = x->entry_start[e + 1] - x->entry_start[e];
    for (; block < x->n_blocks; block++) {
      int first = x->block_first[block];
      if (x->entry_start[first + 1] - x->entry_start[first] == size &&
          memcmp(space->element[first].degree, space->element[e].degree,
                 sizeof space->element[e].degree) == 0)
        break;
    }
    if (block == x->n_blocks)
      x->block_first[x->n_blocks++] = e;
    x->block_of[e] = block;
  }
  for (int block = 0, number = 0; block < x->n_blocks; block++)
    for (int e = 0; e < space->n_elements; e++)
      if (x->block_of[e] == block)
        x->number[e] = ++number;
  return TSOLID_OK;
}

/* ---- text --------------------------------------------------------------------------------------
 */

static void put_row(tsi_output *out, int n, const int *value) {
  for (int k = 0; k < n; k++) {
    tsi_output_text(out, " ");
    tsi_output_integer(out, value[k]);
  }
  tsi_output_text(out, "\n");
}

static void put_ids(tsi_output *out, int n, const int *id) {
  for (int k = 0; k < n; k++) {
    tsi_output_text(out, " ");
    tsi_output_integer(out, id[k] + 1);
    if (k % IDS_PER_LINE == IDS_PER_LINE - 1 || k == n - 1)
      tsi_output_text(out, "\n");
  }
}

static void put_nodes(tsi_output *out, const tsolid_solid *solid, int n) {
  char text[TSI_LONG_NUMBER_SIZE];
  for (int k = 0; k < n; k++) {
    const double *h = solid->control + 4 * (size_t)k;
    for (int c = 0; c < 3; c++) {
      tsi_output_text(out, " ");
      if (h[3] == 1.0)
        tsi_output_number(out, h[c]);
      else
        tsi_output_add(out, text, tsi_number_print_long((long double)h[c] / h[3], text));
    }
    tsi_output_text(out, " ");
    tsi_output_number(out, h[3]);
    tsi_output_text(out, "\n");
  }
}

static tsolid_status put_elements(tsi_output *out, const extraction *x) {
  const tsolid_space *space = x->solid->space;
  tsi_output_text(out, "$#BLOCK 3 - ELEMENTS\n");
  put_row(out, 1, &x->n_blocks);
  for (int b = 0; b < x->n_blocks; b++) {
    int first = x->block_first[b], n = x->entry_start[first + 1] - x->entry_start[first], count = 0;
    const int *degree = space->element[first].degree;
    for (int e = 0; e < space->n_elements; e++)
      count += x->block_of[e] == b;
    put_row(out, 7, (const int[7]){1, count, n, n, degree[0], degree[1], degree[2]});
  }
  for (int b = 0; b < x->n_blocks && out->status == TSOLID_OK; b++) {
    tsolid_status status = tsi_progress(out->context, stage, 0.5 + 0.3 * b / x->n_blocks);
    if (status)
      return status;
    for (int e = 0; e < space->n_elements; e++) {
      int first = x->entry_start[e], n = x->entry_start[e + 1] - first;
      if (x->block_of[e] != b)
        continue;
      put_ids(out, n, x->function + first);
      put_ids(out, n, x->vector + first);
    }
  }
  return TSOLID_OK;
}

/* A dense block for each run of vectors of one length. */
static tsolid_status put_vectors(tsi_output *out, const vector_pool *pool) {
  int n_runs = 0;
  tsi_output_text(out, "$#BLOCK 4 - COEFFICIENT VECTORS\n");
  for (int pass = 0; pass < 2; pass++) {
    if (pass)
      put_row(out, 2, (const int[2]){n_runs, 0});
    for (int first = 0, end; first < pool->n_vectors; first = end) {
      size_t length = pool->start[first + 1] - pool->start[first];
      for (end = first + 1; end < pool->n_vectors; end++)
        if (pool->start[end + 1] - pool->start[end] != length)
          break;
      if (pass)
        put_row(out, 2, (const int[2]){end - first, (int)length});
      else
        n_runs++;
    }
  }
  for (int k = 0; k < pool->n_vectors && out->status == TSOLID_OK; k++) {
    size_t first = pool->start[k], n = pool->start[k + 1] - first;
    for (size_t i = 0; i < n; i++) {
      tsi_output_text(out, " ");
      tsi_output_number(out, pool->value[first + i]);
      if (i % NUMBERS_PER_LINE == NUMBERS_PER_LINE - 1 || i == n - 1)
        tsi_output_text(out, "\n");
    }
    if (k % 1024 == 0) {
      tsolid_status status = tsi_progress(out->context, stage, 0.8 + 0.2 * k / pool->n_vectors);
      if (status)
        return status;
    }
  }
  return TSOLID_OK;
}

/* ---- side sets ---------------------------------------------------------------------------------
 */

/* 1: the element's outer face lies in the region, 0: beside it, -1: across its border. */
static int inside(const tsolid_solid *solid, const tsi_element *e, const tsolid_region *region) {
  double end[3];
  int axis = tsi_side_axis(region->side), high = region->side & 1, out = 0;
  int along[2] = {tsi_side_s(region->side), tsi_side_t(region->side)};
  tsolid_solid_boundary_point(solid, region->side, 0.0, 0.0, end);
  if (e->block != 1 + region->side || e->box[high ? axis + 3 : axis] != end[axis])
    return 0;
  for (int d = 0; d < 2; d++) {
    double low = e->box[along[d]], width = e->box[along[d] + 3] - low, near = 1e-9 * width;
    if (low + width <= region->box[2 * d] + near || low >= region->box[2 * d + 1] - near)
      return 0;
    out |= low < region->box[2 * d] - near || low + width > region->box[2 * d + 1] + near;
  }
  return out ? -1 : 1;
}

static tsolid_status check_sets(tsolid_context *context, const tsolid_solid *solid,
                                const tsolid_bext_options *options) {
  for (int r = 0; r < options->n_regions; r++) {
    const tsolid_region *region = &options->regions[r];
    int n = 0;
    if (!region->name || !*region->name || strpbrk(region->name, " \t\r\n") || region->side < 0 ||
        region->side > 5)
      return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                      "Region %d needs a side and a name without blanks", r);
    for (int e = 0; e < solid->space->n_elements; e++) {
      int in = inside(solid, &solid->space->element[e], region);
      if (in < 0)
        return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                        "The border of region '%s' cuts through elements: a side set is made of "
                        "whole faces of elements",
                        region->name);
      n += in;
    }
    if (n == 0)
      return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "Region '%s' is empty", region->name);
  }
  return TSOLID_OK;
}

/* Whether the element has a face in a piece of the set that region `first` is the first piece of:
 * 1 + its side; 0: none. */
static int face_in_set(const extraction *x, const tsolid_bext_options *options, int first, int e) {
  const tsolid_region *region = options->regions;
  for (int r = first; r < options->n_regions; r++)
    if (strcmp(region[r].name, region[first].name) == 0 &&
        inside(x->solid, &x->solid->space->element[e], &region[r]))
      return 1 + region[r].side;
  return 0;
}

static void put_set(tsi_output *out, const extraction *x, const tsolid_bext_options *options,
                    int first) {
  int n_elements = x->solid->space->n_elements, n = 0;
  for (int e = 0; e < n_elements; e++)
    n += face_in_set(x, options, first, e) != 0;
  tsi_output_text(out, "$#SIDE SET ");
  tsi_output_text(out, options->regions[first].name);
  put_row(out, 1, &n);
  for (int e = 0; e < n_elements; e++) {
    int face = face_in_set(x, options, first, e);
    if (face) {
      tsi_output_text(out, "$#");
      put_row(out, 2, (const int[2]){x->number[e], face});
    }
  }
}

static void put_sets(tsi_output *out, const extraction *x, const tsolid_bext_options *options) {
  for (int r = 0; r < options->n_regions; r++) {
    int first = 0;
    while (strcmp(options->regions[first].name, options->regions[r].name) != 0)
      first++;
    if (first == r)
      put_set(out, x, options, r);
  }
}

/* ---- the document ------------------------------------------------------------------------------
 */

static tsolid_status put_document(tsi_output *out, const extraction *x,
                                  const tsolid_bext_options *options, int not_proved) {
  int n_nodes = x->solid->space->n_inner + 2 * x->solid->space->n_surface, rational = 0;
  for (int k = 0; k < n_nodes && !rational; k++)
    rational = x->solid->control[4 * (size_t)k + 3] != 1.0;
  int patch[5] = {1, n_nodes, x->solid->space->n_elements, x->pool.n_vectors, rational};
  tsi_output_text(out, "B E X T 2.0\n$# Solid T-spline, made by tsolid " TSOLID_VERSION "\n");
  if (not_proved)
    tsi_output_text(out, "$# The solid is NOT proved valid: det J > 0 is not certain.\n");
  tsi_output_text(out, "$#BLOCK 1 - PATCH\n");
  put_row(out, 5, patch);
  tsi_output_text(out, "$#BLOCK 2 - NODES\n");
  put_nodes(out, x->solid, n_nodes);
  tsolid_status status = put_elements(out, x);
  if (!status)
    status = put_vectors(out, &x->pool);
  if (options)
    put_sets(out, x, options);
  tsi_output_text(out, "$#END FILE\n");
  return status;
}

/* options NULL: neither side sets nor a proof. */
static tsolid_status write_bext(tsolid_context *context, const tsolid_solid *solid,
                                const tsolid_bext_options *options, int not_proved,
                                const char *path) {
  tsi_output out;
  tsi_arena arena = tsi_arena_create(context);
  extraction x = {.solid = solid, .pool = {.allocator = &context->allocator}};
  tsolid_status status = extract(context, &arena, &x);
  if (!status)
    status = group(context, &arena, &x);
  if (status)
    goto done;
  if (tsi_output_open(&out, context, stage, path) == TSOLID_OK)
    status = put_document(&out, &x, options, not_proved);
  status = tsi_output_close(&out, status);
done:
  free_pool(&x.pool);
  tsi_arena_free(&arena);
  return status;
}

tsolid_status tsolid_write_bext(tsolid_context *context, const tsolid_solid *solid,
                                const char *path) {
  if (!context || !solid || !path)
    return TSOLID_ERROR_ARGUMENT;
  return write_bext(context, solid, NULL, 0, path);
}

tsolid_status tsolid_write_bext_sets(tsolid_context *context, const tsolid_solid *solid,
                                     const tsolid_bext_options *options, const char *path) {
  tsolid_certificate certificate;
  if (!context || !solid || !options || options->n_regions < 0 ||
      (options->n_regions > 0 && !options->regions) || !path)
    return TSOLID_ERROR_ARGUMENT;
  tsolid_status status = check_sets(context, solid, options);
  if (!status)
    status = tsolid_certify(context, solid, NULL, &certificate, NULL);
  if (status)
    return status;
  if (certificate.verdict != TSOLID_POSITIVE && !options->allow_unproved)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                    "The solid is not proved valid near (%g, %g, %g): it is not written for "
                    "analysis unless that is asked for",
                    certificate.point[0], certificate.point[1], certificate.point[2]);
  return write_bext(context, solid, options, certificate.verdict != TSOLID_POSITIVE, path);
}
