/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The space: functions, Bezier elements and the separable extraction between them.
 *
 * On an element an inner function is the product of three cubics. Their Bernstein rows depend only
 * on (axis, local knots, interval), so equal rows are stored once and an entry (element, function)
 * is three row numbers.
 *
 * Source: Borden, Scott, Evans, Hughes (2011), Bezier extraction; here never as matrices. */
#include "extract.h"
#include "bernstein.h"
#include "blending.h"
#include "bvh.h"

#include <stdlib.h>

static const char *const STAGE = "space";

/* ---- rows, each stored once
 * ------------------------------------------------------------------------ */

typedef struct row_key {
  int axis, knot[5];
  double lo, hi;
} row_key;

typedef struct row_pool {
  tsi_allocator allocator;
  int n, capacity;
  double *row;
  row_key *key;
  int *slot; /* open addressing; -1: free; a power of two at least twice n */
  size_t n_slots;
} row_pool;

static size_t hash_key(const row_key *key) {
  uint64_t h = 0xcbf29ce484222325u, bits;
  for (int i = 0; i < 5; i++)
    h = (h ^ (uint64_t)(unsigned)key->knot[i]) * 0x100000001b3u;
  memcpy(&bits, &key->lo, sizeof bits);
  h = (h ^ bits ^ (uint64_t)(unsigned)key->axis) * 0x100000001b3u;
  memcpy(&bits, &key->hi, sizeof bits);
  h = (h ^ bits) * 0x100000001b3u;
  return (size_t)(h ^ (h >> 29));
}

static int same_row_key(const row_key *a, const row_key *b) {
  return a->axis == b->axis && memcmp(a->knot, b->knot, sizeof a->knot) == 0 && a->lo == b->lo &&
         a->hi == b->hi;
}

static void insert_slot(row_pool *pool, int index) {
  size_t at = hash_key(&pool->key[index]) & (pool->n_slots - 1);
  while (pool->slot[at] >= 0)
    at = (at + 1) & (pool->n_slots - 1);
  pool->slot[at] = index;
}

static int grow_pool(row_pool *pool) {
  int capacity = pool->capacity ? 2 * pool->capacity : 256;
  size_t n_slots = 4 * (size_t)capacity;
  if (capacity > TSI_MAX_COUNT)
    return 0;
  double *row = tsi_new(&pool->allocator, (size_t)capacity, 4 * sizeof *row);
  row_key *key = tsi_new(&pool->allocator, (size_t)capacity, sizeof *key);
  int *slot = tsi_new(&pool->allocator, n_slots, sizeof *slot);
  if (!row || !key || !slot) {
    tsi_delete(&pool->allocator, row);
    tsi_delete(&pool->allocator, key);
    tsi_delete(&pool->allocator, slot);
    return 0;
  }
  if (pool->n) {
    memcpy(row, pool->row, (size_t)pool->n * 4 * sizeof *row);
    memcpy(key, pool->key, (size_t)pool->n * sizeof *key);
  }
  tsi_delete(&pool->allocator, pool->row);
  tsi_delete(&pool->allocator, pool->key);
  tsi_delete(&pool->allocator, pool->slot);
  memset(slot, -1, n_slots * sizeof *slot);
  pool->row = row;
  pool->key = key;
  pool->slot = slot;
  pool->n_slots = n_slots;
  pool->capacity = capacity;
  for (int i = 0; i < pool->n; i++)
    insert_slot(pool, i);
  return 1;
}

/* The number of the row of a function with these knots on [lo, hi]; -1: no memory. */
static int find_row(row_pool *pool, const tsolid_tmesh *tmesh, int axis, const int knot[5],
                    double lo, double hi) {
  row_key key = {.axis = axis, .lo = lo, .hi = hi};
  memcpy(key.knot, knot, sizeof key.knot);
  if (pool->n == pool->capacity && !grow_pool(pool))
    return -1;
  size_t at = hash_key(&key) & (pool->n_slots - 1);
  for (; pool->slot[at] >= 0; at = (at + 1) & (pool->n_slots - 1))
    if (same_row_key(&pool->key[pool->slot[at]], &key))
      return pool->slot[at];
  double value[5];
  for (int i = 0; i < 5; i++)
    value[i] = tmesh->plane_value[axis][knot[i]];
  tsi_bspline_bernstein(TSI_INNER_DEGREE, value, lo, hi, pool->row + 4 * (size_t)pool->n);
  pool->key[pool->n] = key;
  pool->slot[at] = pool->n;
  return pool->n++;
}

static void free_pool(row_pool *pool) {
  tsi_delete(&pool->allocator, pool->key);
  tsi_delete(&pool->allocator, pool->slot);
}

/* ---- entries: which functions on which elements
 * ------------------------------------------------------ */

/* One walk over all (piece, element) pairs that overlap: counts, or fills rows. */
typedef struct walk {
  tsolid_space *space;
  row_pool *pool; /* NULL: count only */
  int function;
  const tsi_piece *piece;
  double support[6];
  size_t *fill; /* per element */
  int failed;
} walk;

static int meet_element(void *data, int item) {
  walk *w = data;
  const tsi_element *e = &w->space->element[item];
  if (w->piece->block >= 0 && w->piece->block != e->block)
    return 0;
  for (int a = 0; a < 3; a++)
    if (!(w->support[a] < e->box[a + 3] && e->box[a] < w->support[a + 3]))
      return 0;
  size_t at = w->fill[item]++;
  if (!w->pool)
    return 0;
  w->space->inner_function[at] = w->function;
  for (int a = 0; a < 3; a++) {
    int row = find_row(w->pool, w->space->tmesh, a, w->piece->knot[a], e->box[a], e->box[a + 3]);
    w->failed |= row < 0;
    w->space->inner_row[at][a] = row;
  }
  return w->failed;
}

static int walk_pieces(walk *w) {
  const tsolid_space *space = w->space;
  for (int f = 0; f < space->n_inner && !w->failed; f++)
    for (int i = space->piece_start[f]; i < space->piece_start[f + 1]; i++) {
      w->function = f;
      w->piece = &space->piece[i];
      tsi_piece_support(space->tmesh, w->piece, w->support);
      tsi_bvh_overlapping(space->locate, w->support, 0.0, meet_element, w);
    }
  return !w->failed;
}

typedef struct inner_entry {
  int row[3], function;
} inner_entry;

static int compare_inner_entries(const void *a, const void *b) {
  const inner_entry *p = a, *q = b;
  for (int i = 2; i >= 0; i--)
    if (p->row[i] != q->row[i])
      return p->row[i] < q->row[i] ? -1 : 1;
  return (p->function > q->function) - (p->function < q->function);
}

/* Brings each element's entries into the order that lets sums factorise. */
static int sort_entries(tsolid_space *space) {
  size_t largest = 0;
  for (int e = 0; e < space->n_elements; e++) {
    size_t n = space->inner_start[e + 1] - space->inner_start[e];
    largest = n > largest ? n : largest;
  }
  inner_entry *work = tsi_new(&space->allocator, largest, sizeof *work);
  if (!work)
    return 0;
  for (int e = 0; e < space->n_elements; e++) {
    size_t first = space->inner_start[e], n = space->inner_start[e + 1] - first;
    for (size_t i = 0; i < n; i++) {
      memcpy(work[i].row, space->inner_row[first + i], sizeof work[i].row);
      work[i].function = space->inner_function[first + i];
    }
    qsort(work, n, sizeof *work, compare_inner_entries);
    for (size_t i = 0; i < n; i++) {
      memcpy(space->inner_row[first + i], work[i].row, sizeof work[i].row);
      space->inner_function[first + i] = work[i].function;
    }
  }
  tsi_delete(&space->allocator, work);
  return 1;
}

static int make_entries(tsolid_space *space, row_pool *pool) {
  size_t n = (size_t)space->n_elements;
  space->inner_start = tsi_new(&space->allocator, n + 1, sizeof(size_t));
  size_t *fill = tsi_new(&space->allocator, n + 1, sizeof *fill);
  int complete = space->inner_start && fill;
  walk w = {.space = space, .fill = fill};
  if (complete)
    complete = walk_pieces(&w);
  size_t total = 0;
  for (size_t e = 0; complete && e < n; e++) {
    space->inner_start[e] = total;
    total += fill[e];
    fill[e] = space->inner_start[e];
  }
  if (complete) {
    space->inner_start[n] = total;
    space->inner_function = tsi_new(&space->allocator, total, sizeof(int));
    space->inner_row = tsi_new(&space->allocator, total, sizeof *space->inner_row);
    complete = space->inner_function && space->inner_row;
  }
  w.pool = pool;
  if (complete)
    complete = walk_pieces(&w) && sort_entries(space);
  tsi_delete(&space->allocator, fill);
  return complete;
}

/* ---- radial rows, transpose, views
 * --------------------------------------------------------------------- */

/* M_R- and M_R on the element's interval of its arm's axis: local knots [0,r1,R,R,R] and
 * [r1,R,R,R,R], mirrored on low sides. */
static int make_radial_rows(tsolid_space *space, row_pool *pool) {
  for (int i = 0; i < space->n_elements; i++) {
    tsi_element *e = &space->element[i];
    if (e->block == 0)
      continue;
    int axis = tsi_side_axis(e->block - 1), last = space->tmesh->n_planes[axis] - 1;
    int high = (e->block - 1) & 1;
    int knots[2][5] = {{0, 0, 1, 2, TSI_LOW_PLANE}, {0, 0, 0, 1, 2}};
    for (int layer = 0; layer < 2; layer++) {
      int k[5];
      for (int j = 0; j < 5; j++)
        k[j] = high ? last - knots[layer][4 - j] : knots[layer][j];
      double lo = space->tmesh->plane_value[axis][k[0]], hi = space->tmesh->plane_value[axis][k[4]];
      if (!(lo < e->box[axis + 3] && e->box[axis] < hi))
        continue;
      e->radial[layer] = find_row(pool, space->tmesh, axis, k, e->box[axis], e->box[axis + 3]);
      if (e->radial[layer] < 0)
        return 0;
    }
  }
  return 1;
}

static int make_transpose(tsolid_space *space) {
  size_t n = (size_t)space->n_inner, total = space->inner_start[space->n_elements];
  space->use_start = tsi_new(&space->allocator, n + 1, sizeof(size_t));
  space->use_element = tsi_new(&space->allocator, total, sizeof(int));
  space->use_entry = tsi_new(&space->allocator, total, sizeof(size_t));
  size_t *fill = tsi_new(&space->allocator, n + 1, sizeof *fill);
  int complete = space->use_start && space->use_element && space->use_entry && fill;
  if (complete) {
    for (size_t i = 0; i < total; i++)
      space->use_start[space->inner_function[i] + 1]++;
    for (size_t f = 0; f < n; f++) {
      space->use_start[f + 1] += space->use_start[f];
      fill[f] = space->use_start[f];
    }
    for (int e = 0; e < space->n_elements; e++)
      for (size_t i = space->inner_start[e]; i < space->inner_start[e + 1]; i++) {
        size_t at = fill[space->inner_function[i]]++;
        space->use_element[at] = e;
        space->use_entry[at] = i;
      }
  }
  tsi_delete(&space->allocator, fill);
  return complete;
}

static int make_views(tsolid_space *space) {
  size_t n = (size_t)space->n_elements;
  space->element_degree = tsi_new(&space->allocator, n, 3 * sizeof(int));
  space->element_block = tsi_new(&space->allocator, n, sizeof(int));
  space->element_box = tsi_new(&space->allocator, n, 6 * sizeof(double));
  space->bezier_start = tsi_new(&space->allocator, n + 1, sizeof(size_t));
  if (!space->element_degree || !space->element_block || !space->element_box ||
      !space->bezier_start)
    return 0;
  for (size_t i = 0; i < n; i++) {
    const tsi_element *e = &space->element[i];
    size_t points = 1;
    for (int a = 0; a < 3; a++) {
      space->element_degree[3 * i + (size_t)a] = e->degree[a];
      points *= (size_t)e->degree[a] + 1;
    }
    space->element_block[i] = e->block;
    memcpy(space->element_box + 6 * i, e->box, sizeof e->box);
    space->bezier_start[i + 1] = space->bezier_start[i] + points;
  }
  return 1;
}

/* ---- handle
 * ---------------------------------------------------------------------------------------------- */

/* The matrices that raise cubics to the lateral degrees in use. */
static int make_raise_matrices(tsolid_space *space) {
  for (int i = 0; i < 2 * space->n_laterals; i++) {
    int degree = space->lateral[i / 2].degree[i % 2];
    if (space->raise[degree])
      continue;
    double *m = tsi_new(&space->allocator, (size_t)degree + 1, 4 * sizeof *m);
    if (!m)
      return 0;
    space->raise[degree] = m;
    for (int j = 0; j < 4; j++) {
      double unit[4] = {0}, column[TSI_MAX_ORDER];
      unit[j] = 1.0;
      tsi_bernstein_raise(TSI_INNER_DEGREE, degree, 1, unit, column);
      for (int k = 0; k <= degree; k++)
        m[4 * k + j] = column[k];
    }
  }
  return 1;
}

static tsolid_status build_space(tsolid_context *context, tsolid_space *space) {
  tsolid_status status = tsi_blending_create(context, space);
  if (status == TSOLID_OK)
    status = tsi_progress(context, STAGE, 0.3);
  if (status == TSOLID_OK)
    status = tsi_elements_create(context, space);
  if (status == TSOLID_OK)
    status = tsi_progress(context, STAGE, 0.5);
  if (status != TSOLID_OK)
    return status;
  row_pool pool = {.allocator = space->allocator};
  int complete = make_views(space) && make_raise_matrices(space);
  if (complete) {
    space->locate = tsi_bvh_create(&space->allocator, space->n_elements, space->element_box);
    complete = space->locate && make_entries(space, &pool) && make_radial_rows(space, &pool) &&
               make_transpose(space);
  }
  space->row = pool.row;
  space->n_rows = pool.n;
  free_pool(&pool);
  return complete ? tsi_progress(context, STAGE, 1.0) : tsi_no_memory(context, STAGE);
}

tsolid_status tsolid_space_create(tsolid_context *context, const tsolid_boundary *boundary,
                                  const tsolid_tmesh *tmesh, tsolid_space **space) {
  if (!context || !boundary || !tmesh || !space)
    return TSOLID_ERROR_ARGUMENT;
  *space = NULL;
  tsolid_space *s = tsi_new(&context->allocator, 1, sizeof *s);
  if (!s)
    return tsi_no_memory(context, STAGE);
  s->allocator = context->allocator;
  s->references = 1;
  s->boundary = boundary;
  s->tmesh = tmesh;
  s->n_surface = boundary->n_functions;
  tsi_boundary_retain(boundary);
  tsi_tmesh_retain(tmesh);
  tsolid_status status = build_space(context, s);
  if (status == TSOLID_OK)
    *space = s;
  else
    tsolid_space_free(s);
  return status;
}

void tsi_space_retain(const tsolid_space *space) {
  ((tsolid_space *)(uintptr_t)space)->references++; /* the count is no part of the value */
}

void tsolid_space_free(tsolid_space *space) {
  if (!space || --space->references > 0)
    return;
  tsi_allocator allocator = space->allocator;
  tsolid_boundary_free((tsolid_boundary *)(uintptr_t)space->boundary);
  tsolid_tmesh_free((tsolid_tmesh *)(uintptr_t)space->tmesh);
  tsi_bvh_free(space->locate);
  for (int d = 0; d < TSI_MAX_ORDER; d++)
    tsi_delete(&allocator, space->raise[d]);
  void *owned[] = {
      space->piece_start,         space->piece,       space->element,     space->element_degree,
      space->element_block,       space->element_box, space->row,         space->inner_start,
      space->inner_function,      space->inner_row,   space->lateral,     space->lateral_function,
      space->lateral_coefficient, space->use_start,   space->use_element, space->use_entry,
      space->bezier_start};
  for (size_t i = 0; i < sizeof owned / sizeof *owned; i++)
    tsi_delete(&allocator, owned[i]);
  tsi_delete(&allocator, space);
}

void tsolid_space_get(const tsolid_space *space, tsolid_space_view *view) {
  *view = (tsolid_space_view){.n_functions = space->n_inner + 2 * space->n_surface,
                              .n_inner = space->n_inner,
                              .n_surface = space->n_surface,
                              .n_elements = space->n_elements,
                              .element_block = space->element_block,
                              .element_degree = space->element_degree,
                              .element_box = space->element_box};
}

const tsolid_boundary *tsolid_space_boundary(const tsolid_space *space) {
  return space->boundary;
}

const tsolid_tmesh *tsolid_space_tmesh(const tsolid_space *space) {
  return space->tmesh;
}
