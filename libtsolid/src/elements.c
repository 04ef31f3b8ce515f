/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Bezier elements: boxes inside one cell on which every function is polynomial.
 *
 * A cell of positive measure is cut at the knots of all functions that reach into it (their planes
 * may end in T-junctions on its surface), in arms also at the input's lines, that is until each
 * part lies in one Bezier element of the side. */
#include "bvh.h"
#include "extract.h"

#include <stdlib.h>

static const char *const STAGE = "space";

void tsi_piece_support(const tsolid_tmesh *tmesh, const tsi_piece *piece, double box[6]) {
  for (int a = 0; a < 3; a++) {
    box[a] = tmesh->plane_value[a][piece->knot[a][0]];
    box[a + 3] = tmesh->plane_value[a][piece->knot[a][4]];
  }
}

/* ---- cuts of cells by knots
 * ---------------------------------------------------------------------- */

typedef struct cut {
  int cell, axis;
  double value;
} cut;

/* Everything that the steps below share. */
typedef struct builder {
  tsolid_context *context;
  tsolid_space *space;
  const tsolid_tmesh *tmesh;
  tsi_arena arena;
  int n_cells; /* of positive measure */
  int *cell;   /* their indices */
  double *cell_box;
  struct tsi_bvh *cell_tree;
  int n_cuts, cut_capacity;
  cut *cuts; /* our own growing array */
  struct tsi_bvh *side_tree[6];
  int n_elements, element_capacity;
  tsi_element *element;
  tsi_lateral_request *request; /* one per element, side -1 in the core */
  const tsi_piece *piece;       /* the one that cuts now */
  double support[6];
  int failed;
} builder;

/* Makes room for one more row of `size` bytes in an array of our own; 0: no memory. */
static int grow(const tsi_allocator *allocator, void **array, int count, int *capacity,
                size_t size) {
  if (count < *capacity)
    return 1;
  if (*capacity > TSI_MAX_COUNT / 2)
    return 0;
  int more = *capacity ? 2 * *capacity : 64;
  void *grown = tsi_new(allocator, (size_t)more, size);
  if (!grown)
    return 0;
  if (count)
    memcpy(grown, *array, (size_t)count * size);
  tsi_delete(allocator, *array);
  *array = grown;
  *capacity = more;
  return 1;
}

static tsolid_status find_cells(builder *b) {
  const tsolid_tmesh *t = b->tmesh;
  b->cell = tsi_arena_new(&b->arena, (size_t)t->n_cells, sizeof *b->cell);
  b->cell_box = tsi_arena_new(&b->arena, (size_t)t->n_cells, 6 * sizeof *b->cell_box);
  if (!b->cell || !b->cell_box)
    return tsi_no_memory(b->context, STAGE);
  for (int c = 0; c < t->n_cells; c++) {
    double *box = b->cell_box + 6 * (size_t)b->n_cells;
    int positive = 1;
    for (int i = 0; i < 6; i++)
      box[i] = t->plane_value[i % 3][t->cell[6 * (size_t)c + (size_t)i]];
    for (int a = 0; a < 3; a++)
      positive &= box[a] < box[a + 3];
    if (positive)
      b->cell[b->n_cells++] = c;
  }
  b->cell_tree = tsi_bvh_create(&b->space->allocator, b->n_cells, b->cell_box);
  return b->cell_tree ? TSOLID_OK : tsi_no_memory(b->context, STAGE);
}

static int overlap(const double p[6], const double q[6]) {
  for (int a = 0; a < 3; a++)
    if (!(p[a] < q[a + 3] && q[a] < p[a + 3]))
      return 0;
  return 1;
}

/* Notes where the current piece's knots cut a cell that it overlaps. */
static int cut_cell(void *data, int item) {
  builder *b = data;
  const double *box = b->cell_box + 6 * (size_t)item;
  int block = b->tmesh->cell_block[b->cell[item]];
  if ((b->piece->block >= 0 && b->piece->block != block) || !overlap(b->support, box))
    return 0;
  for (int a = 0; a < 3; a++)
    for (int k = 0; k < 5; k++) {
      double value = b->tmesh->plane_value[a][b->piece->knot[a][k]];
      if (!(box[a] < value && value < box[a + 3]))
        continue;
      if (!grow(&b->space->allocator, (void **)&b->cuts, b->n_cuts, &b->cut_capacity,
                sizeof *b->cuts)) {
        b->failed = 1;
        return 1;
      }
      b->cuts[b->n_cuts++] = (cut){item, a, value};
    }
  return 0;
}

static int compare_cuts(const void *x, const void *y) {
  const cut *p = x, *q = y;
  if (p->cell != q->cell)
    return p->cell < q->cell ? -1 : 1;
  if (p->axis != q->axis)
    return p->axis < q->axis ? -1 : 1;
  return (p->value > q->value) - (p->value < q->value);
}

static tsolid_status find_cuts(builder *b) {
  const tsolid_space *space = b->space;
  for (int i = 0; i < space->piece_start[space->n_inner]; i++) {
    b->piece = &space->piece[i];
    tsi_piece_support(b->tmesh, b->piece, b->support);
    tsi_bvh_overlapping(b->cell_tree, b->support, 0.0, cut_cell, b);
    if (b->failed)
      return tsi_no_memory(b->context, STAGE);
  }
  if (b->n_cuts == 0)
    return TSOLID_OK;
  qsort(b->cuts, (size_t)b->n_cuts, sizeof *b->cuts, compare_cuts);
  int unique = 1;
  for (int i = 1; i < b->n_cuts; i++)
    if (compare_cuts(&b->cuts[i], &b->cuts[unique - 1]) != 0)
      b->cuts[unique++] = b->cuts[i];
  b->n_cuts = unique;
  return TSOLID_OK;
}

/* ---- elements
 * ------------------------------------------------------------------------------------- */

static int add_element(builder *b, int block, const double box[6], int side_element) {
  int capacity = b->element_capacity;
  if (!grow(&b->space->allocator, (void **)&b->element, b->n_elements, &capacity,
            sizeof *b->element))
    return 0;
  if (!grow(&b->space->allocator, (void **)&b->request, b->n_elements, &b->element_capacity,
            sizeof *b->request))
    return 0;
  int at = b->n_elements++;
  tsi_element *e = &b->element[at];
  *e = (tsi_element){.block = block, .lateral = -1, .radial = {-1, -1}};
  memcpy(e->box, box, sizeof e->box);
  for (int a = 0; a < 3; a++)
    e->degree[a] = TSI_INNER_DEGREE;
  tsi_lateral_request *r = &b->request[at];
  *r = (tsi_lateral_request){.side = block - 1, .side_element = side_element, .element = at};
  if (block == 0)
    return 1;
  int s = tsi_side_s(r->side), t = tsi_side_t(r->side);
  const int *degree = b->space->boundary->side[r->side].degree;
  if (degree[0] > e->degree[s])
    e->degree[s] = degree[0];
  if (degree[1] > e->degree[t])
    e->degree[t] = degree[1];
  double lateral[4] = {box[s], box[s + 3], box[t], box[t + 3]};
  memcpy(r->box, lateral, sizeof lateral);
  return 1;
}

/* The first side element that overlaps a lateral box, and a line of it that cuts the box. */
typedef struct side_query {
  const tsi_side *side;
  double box[4];
  int found, cut_axis;
  double cut_value;
} side_query;

static int meet_side_element(void *data, int item) {
  side_query *q = data;
  const double *e = q->side->box + 4 * (size_t)item, *box = q->box;
  if (!(e[0] < box[1] && box[0] < e[1] && e[2] < box[3] && box[2] < e[3]))
    return 0;
  q->found = item;
  q->cut_axis = -1;
  for (int i = 0; i < 4 && q->cut_axis < 0; i++)
    if (box[i & 2] < e[i] && e[i] < box[(i & 2) + 1]) {
      q->cut_axis = i >> 1;
      q->cut_value = e[i];
    }
  return 1;
}

/* Splits an arm's box at the side's lines until every part lies in one of its elements. */
static tsolid_status cut_by_side(builder *b, int block, const double box[6]) {
  int side = block - 1, axis[2] = {tsi_side_s(side), tsi_side_t(side)};
  side_query q = {.side = &b->space->boundary->side[side],
                  .box = {box[axis[0]], box[axis[0] + 3], box[axis[1]], box[axis[1] + 3]},
                  .found = -1};
  double flat[6] = {q.box[0], q.box[2], 0.0, q.box[1], q.box[3], 0.0};
  tsi_bvh_overlapping(b->side_tree[side], flat, 0.0, meet_side_element, &q);
  if (q.found < 0)
    return tsi_fail(b->context, TSOLID_ERROR_INTERNAL, STAGE,
                    "No Bezier element of side %d covers an arm cell", side);
  if (q.cut_axis < 0)
    return add_element(b, block, box, q.found) ? TSOLID_OK : tsi_no_memory(b->context, STAGE);
  double low[6], high[6];
  memcpy(low, box, sizeof low);
  memcpy(high, box, sizeof high);
  low[axis[q.cut_axis] + 3] = high[axis[q.cut_axis]] = q.cut_value;
  tsolid_status status = cut_by_side(b, block, low);
  return status == TSOLID_OK ? cut_by_side(b, block, high) : status;
}

/* Interval m of an axis of a cell that is cut at n ascending values. */
static void interval(const double *cell_box, int axis, int n, const cut *cuts, int m,
                     double box[6]) {
  box[axis] = m == 0 ? cell_box[axis] : cuts[m - 1].value;
  box[axis + 3] = m == n ? cell_box[axis + 3] : cuts[m].value;
}

static tsolid_status make_elements(builder *b) {
  tsolid_status status = TSOLID_OK;
  int at = 0;
  for (int c = 0; c < b->n_cells && status == TSOLID_OK; c++) {
    const double *cell_box = b->cell_box + 6 * (size_t)c;
    int block = b->tmesh->cell_block[b->cell[c]], n[3];
    const cut *cuts[3];
    for (int a = 0; a < 3; a++) {
      cuts[a] = b->cuts ? b->cuts + at : NULL;
      for (n[a] = 0; at < b->n_cuts && b->cuts[at].cell == c && b->cuts[at].axis == a; at++)
        n[a]++;
    }
    for (int m = 0; m < (n[0] + 1) * (n[1] + 1) * (n[2] + 1) && status == TSOLID_OK; m++) {
      double box[6];
      interval(cell_box, 0, n[0], cuts[0], m % (n[0] + 1), box);
      interval(cell_box, 1, n[1], cuts[1], m / (n[0] + 1) % (n[1] + 1), box);
      interval(cell_box, 2, n[2], cuts[2], m / ((n[0] + 1) * (n[1] + 1)), box);
      if (block > 0)
        status = cut_by_side(b, block, box);
      else if (!add_element(b, 0, box, -1))
        status = tsi_no_memory(b->context, STAGE);
    }
  }
  return status;
}

static tsolid_status plant_side_trees(builder *b) {
  for (int side = 0; side < 6; side++) {
    const tsi_side *s = &b->space->boundary->side[side];
    double *box = tsi_arena_new(&b->arena, (size_t)s->n_elements, 6 * sizeof *box);
    if (!box)
      return tsi_no_memory(b->context, STAGE);
    for (int e = 0; e < s->n_elements; e++) {
      const double *from = s->box + 4 * (size_t)e;
      double row[6] = {from[0], from[2], 0.0, from[1], from[3], 0.0};
      memcpy(box + 6 * (size_t)e, row, sizeof row);
    }
    b->side_tree[side] = tsi_bvh_create(&b->space->allocator, s->n_elements, box);
    if (!b->side_tree[side])
      return tsi_no_memory(b->context, STAGE);
  }
  return TSOLID_OK;
}

tsolid_status tsi_elements_create(tsolid_context *context, tsolid_space *space) {
  builder b = {.context = context, .space = space, .tmesh = space->tmesh};
  b.arena = tsi_arena_create(context);
  tsolid_status status = find_cells(&b);
  if (status == TSOLID_OK)
    status = find_cuts(&b);
  if (status == TSOLID_OK)
    status = plant_side_trees(&b);
  if (status == TSOLID_OK)
    status = make_elements(&b);
  space->element = b.element; /* owned by the space from here on, also on failure */
  space->n_elements = b.n_elements;
  if (status == TSOLID_OK) {
    int first = 0; /* core elements ask for nothing and come first */
    while (first < b.n_elements && b.element[first].block == 0)
      first++;
    status = tsi_laterals_create(context, space, b.n_elements - first, b.request + first);
  }
  for (int side = 0; side < 6; side++)
    tsi_bvh_free(b.side_tree[side]);
  tsi_bvh_free(b.cell_tree);
  tsi_delete(&space->allocator, b.cuts);
  tsi_delete(&space->allocator, b.request);
  tsi_arena_free(&b.arena);
  return status;
}
