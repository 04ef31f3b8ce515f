/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Nodes and rays of a T-mesh: integer topology only.
 *
 * Source: Sederberg et al. (2003), rule 1 for local knot vectors, in three dimensions: the knots of
 * a node along an axis are the planes of the next two faces that its ray meets each way. Rays along
 * one line share a column: its planes are found once, by letting every cell mark the columns that
 * run through it (closed), so the cost is the number of (cell, column) pairs that meet. */
#include "tmesh.h"
#include "bvh.h"

#include <stdlib.h>

static const char *const STAGE = "tmesh";

/* ---- handles
 * --------------------------------------------------------------------------------------- */

void tsi_tmesh_retain(const tsolid_tmesh *tmesh) {
  ((tsolid_tmesh *)(uintptr_t)tmesh)->references++; /* the count is no part of the value */
}

void tsolid_tmesh_free(tsolid_tmesh *tmesh) {
  if (!tmesh || --tmesh->references > 0)
    return;
  tsi_allocator allocator = tmesh->allocator;
  for (int a = 0; a < 3; a++) {
    tsi_delete(&allocator, tmesh->line[a]);
    tsi_delete(&allocator, tmesh->plane_value[a]);
  }
  tsi_delete(&allocator, tmesh->box);
  tsi_delete(&allocator, tmesh->box_level);
  tsi_delete(&allocator, tmesh->cell);
  tsi_delete(&allocator, tmesh->cell_block);
  tsi_delete(&allocator, tmesh);
}

void tsolid_tmesh_get(const tsolid_tmesh *tmesh, tsolid_tmesh_view *view) {
  *view = (tsolid_tmesh_view){.n_cells = tmesh->n_cells,
                              .cell = tmesh->cell,
                              .cell_block = tmesh->cell_block,
                              .n_nodes = tmesh->n_nodes,
                              .n_partial_extraordinary = tmesh->n_partial_extraordinary,
                              .n_extraordinary = tmesh->n_extraordinary};
  for (int a = 0; a < 3; a++) {
    view->n_planes[a] = tmesh->n_planes[a];
    view->plane_value[a] = tmesh->plane_value[a];
    view->core_plane[a][0] = TSI_LOW_PLANE;
    view->core_plane[a][1] = tsi_high_plane(tmesh, a);
  }
  memcpy(view->arm_height, tmesh->arm_height, sizeof view->arm_height);
}

/* ---- levels
 * ----------------------------------------------------------------------------------------- */

int tsi_box_level(const tsolid_tmesh *tmesh, int b) {
  const int *box = tmesh->box + 6 * (size_t)b;
  double width = 1.0;
  if (tmesh->box_level)
    return tmesh->box_level[b];
  for (int a = 0; a < 3; a++)
    width = fmin(width, tmesh->line[a][box[a + 3]] - tmesh->line[a][box[a]]);
  double level = floor(0.5 - log2(width));
  return (int)fmin(level, TSI_MAX_LEVELS - 1);
}

tsolid_status tsi_tmesh_set_levels(tsolid_context *context, tsolid_tmesh *tmesh, const int *level) {
  tmesh->box_level = tsi_new(&tmesh->allocator, (size_t)tmesh->n_boxes, sizeof *level);
  if (!tmesh->box_level)
    return tsi_no_memory(context, STAGE);
  for (int b = 0; b < tmesh->n_boxes; b++)
    tmesh->box_level[b] = level[b] < TSI_MAX_LEVELS ? level[b] : TSI_MAX_LEVELS - 1;
  return TSOLID_OK;
}

void tsi_box_levels(const tsolid_tmesh *tmesh, int n[TSI_MAX_LEVELS]) {
  memset(n, 0, TSI_MAX_LEVELS * sizeof *n);
  for (int b = 0; b < tmesh->n_boxes; b++)
    n[tsi_box_level(tmesh, b)]++;
}

/* ---- nodes
 * ------------------------------------------------------------------------------------------ */

static int compare_nodes(const void *a, const void *b) {
  const int *p = a, *q = b;
  for (int i = 2; i >= 0; i--)
    if (p[i] != q[i])
      return p[i] < q[i] ? -1 : 1;
  return 0;
}

/* An edge of a cell: runs along `axis` from plane first to last; place: its two other planes at
 * their own axes' positions (place[axis] = first). */
typedef struct edge {
  int axis, last, place[3];
} edge;

static int compare_edges(const void *x, const void *y) {
  const edge *p = x, *q = y;
  const int a[5] = {p->axis, p->place[0], p->place[1], p->place[2], p->last};
  const int b[5] = {q->axis, q->place[0], q->place[1], q->place[2], q->last};
  for (int i = 0; i < 5; i++)
    if (a[i] != b[i])
      return a[i] < b[i] ? -1 : 1;
  return 0;
}

/* Distinct edges of all cells; NULL: no memory. */
static edge *find_edges(const tsolid_tmesh *tmesh, tsi_arena *arena, int *n) {
  edge *list = tsi_arena_new(arena, 12 * (size_t)tmesh->n_cells, sizeof *list);
  size_t count = 0;
  for (int c = 0; list && c < tmesh->n_cells; c++)
    for (int i = 0; i < 12; i++) {
      const int *cell = tmesh->cell + 6 * (size_t)c;
      int axis = i / 4, b = (axis + 1) % 3, d = (axis + 2) % 3;
      edge *e = &list[count++];
      e->axis = axis;
      e->place[axis] = cell[axis];
      e->last = cell[axis + 3];
      e->place[b] = cell[i & 1 ? b + 3 : b];
      e->place[d] = cell[i & 2 ? d + 3 : d];
    }
  if (!list)
    return NULL;
  qsort(list, count, sizeof *list, compare_edges);
  size_t unique = 0;
  for (size_t i = 0; i < count; i++)
    if (i == 0 || compare_edges(&list[i], &list[unique - 1]) != 0)
      list[unique++] = list[i];
  *n = (int)unique;
  return list;
}

/* The search for edges that cross inside each other: counts, or stores nodes. */
typedef struct crossings {
  const edge *edge;
  int current, n, *node;
} crossings;

static int meet_edge(void *data, int other) {
  crossings *x = data;
  const edge *p = &x->edge[x->current], *q = &x->edge[other];
  if (other <= x->current || p->axis == q->axis)
    return 0;
  int third = 3 - p->axis - q->axis, at_p = q->place[p->axis], at_q = p->place[q->axis];
  if (p->place[third] != q->place[third] || at_p <= p->place[p->axis] || at_p >= p->last ||
      at_q <= q->place[q->axis] || at_q >= q->last)
    return 0;
  if (x->node) {
    int *node = x->node + 3 * (size_t)x->n;
    node[third] = p->place[third];
    node[p->axis] = at_p;
    node[q->axis] = at_q;
  }
  x->n++;
  return 0;
}

/* Where edges cross inside each other there is a node of the T-mesh, though no cell has a corner
 * there: two cells that share a face may be split along different axes. */
static tsolid_status find_crossings(tsolid_context *context, const tsolid_tmesh *tmesh,
                                    tsi_arena *arena, int *n, int **node) {
  int n_edges;
  edge *list = find_edges(tmesh, arena, &n_edges);
  double *box = list ? tsi_arena_new(arena, (size_t)n_edges, 6 * sizeof *box) : NULL;
  if (!box)
    return tsi_no_memory(context, STAGE);
  for (int i = 0; i < n_edges; i++)
    for (int a = 0; a < 3; a++) {
      box[6 * (size_t)i + (size_t)a] = list[i].place[a];
      box[6 * (size_t)i + (size_t)a + 3] = a == list[i].axis ? list[i].last : list[i].place[a];
    }
  struct tsi_bvh *tree = tsi_bvh_create(&context->allocator, n_edges, box);
  if (!tree)
    return tsi_no_memory(context, STAGE);
  crossings x = {.edge = list};
  for (int pass = 0; pass < 2; pass++) {
    *n = x.n;
    x.n = 0;
    if (pass == 1 && *n > 0)
      x.node = tsi_arena_new(arena, (size_t)*n, 3 * sizeof *x.node);
    if (pass == 1 && !x.node)
      break;
    for (x.current = 0; x.current < n_edges; x.current++)
      tsi_bvh_overlapping(tree, box + 6 * (size_t)x.current, 0.0, meet_edge, &x);
  }
  tsi_bvh_free(tree);
  *node = x.node;
  return *n == 0 || x.node ? TSOLID_OK : tsi_no_memory(context, STAGE);
}

tsolid_status tsi_tmesh_nodes(tsolid_context *context, const tsolid_tmesh *tmesh, tsi_arena *arena,
                              int *n, int **node) {
  int n_crossings = 0, *crossing = NULL;
  tsolid_status status = find_crossings(context, tmesh, arena, &n_crossings, &crossing);
  *n = 0;
  *node = NULL;
  if (status != TSOLID_OK)
    return status;
  size_t n_corners = 8 * (size_t)tmesh->n_cells, total = n_corners + (size_t)n_crossings;
  size_t unique = 0;
  *node = tsi_arena_new(arena, total, 3 * sizeof(int));
  if (!*node || total > TSI_MAX_COUNT)
    return tsi_no_memory(context, STAGE);
  for (size_t c = 0; c < n_corners; c++)
    for (int a = 0; a < 3; a++)
      (*node)[3 * c + (size_t)a] = tmesh->cell[6 * (c / 8) + (size_t)(a + 3 * (int)(c >> a & 1))];
  if (n_crossings)
    memcpy(*node + 3 * n_corners, crossing, (size_t)n_crossings * 3 * sizeof(int));
  qsort(*node, total, 3 * sizeof(int), compare_nodes);
  for (size_t c = 0; c < total; c++)
    if (c == 0 || compare_nodes(*node + 3 * c, *node + 3 * (unique - 1)) != 0)
      memmove(*node + 3 * unique++, *node + 3 * c, 3 * sizeof(int));
  *n = (int)unique;
  return TSOLID_OK;
}

/* Nodes of the mesh before bands, as the paper counts them: one per place, the gluing done. Nodes
 * on the 12 core edges and 8 spokes are partial extraordinary, the 8 core corners extraordinary. */
tsolid_status tsi_tmesh_count_nodes(tsolid_context *context, tsolid_tmesh *tmesh) {
  tsi_arena arena = tsi_arena_create(context);
  int n, *node;
  tsolid_status status = tsi_tmesh_nodes(context, tmesh, &arena, &n, &node);
  for (int i = 0; status == TSOLID_OK && i < n; i++) {
    int on_edge = 0, counted = 1, arm = -1, depth = 0;
    for (int a = 0; a < 3; a++) {
      int p = node[3 * i + a], high = tsi_high_plane(tmesh, a);
      if (p == TSI_LOW_PLANE + 1 || p == high - 1 || p == TSI_LOW_PLANE - 1 || p == high + 1)
        counted = 0; /* a zero-interval twin */
      on_edge += p == TSI_LOW_PLANE || p == high;
      if (p < TSI_LOW_PLANE || p > high) {
        arm = a;
        depth = p < TSI_LOW_PLANE ? TSI_LOW_PLANE - p : p - high;
      }
    }
    if (depth == 3)
      counted = 0; /* R-: the twin of the boundary */
    if (arm >= 0)  /* on a diagonal: count it in the arm of the lowest axis only */
      for (int a = 0; a < arm; a++)
        if (node[3 * i + a] == TSI_LOW_PLANE || node[3 * i + a] == tsi_high_plane(tmesh, a))
          counted = 0;
    if (!counted)
      continue;
    tmesh->n_nodes++;
    if (arm < 0 && on_edge == 3)
      tmesh->n_extraordinary++;
    else if ((arm < 0 && on_edge == 2) || (arm >= 0 && on_edge == 2 && depth < 4))
      tmesh->n_partial_extraordinary++;
  }
  tsi_arena_free(&arena);
  return status;
}

/* ---- columns
 * ---------------------------------------------------------------------------------------- */

static int first_axis(int axis) {
  return axis == 0 ? 1 : 0;
}
static int second_axis(int axis) {
  return axis == 2 ? 1 : 2;
}

static int compare_pairs(const void *a, const void *b) {
  const int *p = a, *q = b;
  if (p[0] != q[0])
    return p[0] < q[0] ? -1 : 1;
  return (p[1] > q[1]) - (p[1] < q[1]);
}

static int compare_ints(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

/* First column of lateral plane `b` whose second plane is at least `c`. */
static int lower_column(const tsi_columns *columns, int b, int c) {
  int first = columns->lateral_start[b], end = columns->lateral_start[b + 1];
  while (first < end) {
    int middle = first + (end - first) / 2;
    if (columns->lateral[2 * middle + 1] < c)
      first = middle + 1;
    else
      end = middle;
  }
  return first;
}

/* Calls for every column through the closed cell: counts (plane NULL) or marks its two planes. */
static void mark_cell(const tsi_columns *columns, const int *cell, size_t *fill, int *plane) {
  int b = first_axis(columns->axis), c = second_axis(columns->axis);
  for (int p = cell[b]; p <= cell[b + 3]; p++)
    for (int k = lower_column(columns, p, cell[c]); k < columns->lateral_start[p + 1]; k++) {
      if (columns->lateral[2 * k + 1] > cell[c + 3])
        break;
      if (plane) {
        plane[fill[k]] = cell[columns->axis];
        plane[fill[k] + 1] = cell[columns->axis + 3];
      }
      fill[k] += 2;
    }
}

static void find_lateral(tsi_columns *columns, const tsolid_tmesh *tmesh, int n_nodes,
                         const int *node) {
  int b = first_axis(columns->axis), c = second_axis(columns->axis), n = 0;
  for (int i = 0; i < n_nodes; i++) {
    columns->lateral[2 * i] = node[3 * i + b];
    columns->lateral[2 * i + 1] = node[3 * i + c];
  }
  qsort(columns->lateral, (size_t)n_nodes, 2 * sizeof(int), compare_pairs);
  for (int i = 0; i < n_nodes; i++)
    if (i == 0 || compare_pairs(columns->lateral + 2 * i, columns->lateral + 2 * (n - 1)) != 0)
      memmove(columns->lateral + 2 * n++, columns->lateral + 2 * i, 2 * sizeof(int));
  columns->n_columns = n;
  int at = 0;
  for (int p = 0; p <= tmesh->n_planes[b]; p++) {
    while (at < n && columns->lateral[2 * at] < p)
      at++;
    columns->lateral_start[p] = at;
  }
}

/* Sorts each column's planes and drops repeats. */
static void tidy_columns(tsi_columns *columns) {
  size_t out = 0;
  for (int k = 0; k < columns->n_columns; k++) {
    size_t first = columns->start[k], end = columns->start[k + 1], begin = out;
    qsort(columns->plane + first, end - first, sizeof(int), compare_ints);
    columns->start[k] = begin;
    for (size_t i = first; i < end; i++)
      if (out == begin || columns->plane[i] != columns->plane[out - 1])
        columns->plane[out++] = columns->plane[i];
  }
  columns->start[columns->n_columns] = out;
}

tsolid_status tsi_columns_create(tsolid_context *context, const tsolid_tmesh *tmesh, int axis,
                                 int n_nodes, const int *node, tsi_arena *arena,
                                 tsi_columns *columns) {
  size_t n_planes = (size_t)tmesh->n_planes[first_axis(axis)];
  *columns = (tsi_columns){.axis = axis};
  columns->lateral = tsi_arena_new(arena, (size_t)n_nodes, 2 * sizeof(int));
  columns->lateral_start = tsi_arena_new(arena, n_planes + 1, sizeof(int));
  if (!columns->lateral || !columns->lateral_start)
    return tsi_no_memory(context, STAGE);
  find_lateral(columns, tmesh, n_nodes, node);
  size_t n = (size_t)columns->n_columns;
  size_t *fill = tsi_arena_new(arena, n + 1, sizeof *fill);
  columns->start = tsi_arena_new(arena, n + 1, sizeof *columns->start);
  if (!fill || !columns->start)
    return tsi_no_memory(context, STAGE);
  for (int c = 0; c < tmesh->n_cells; c++)
    mark_cell(columns, tmesh->cell + 6 * (size_t)c, fill, NULL);
  size_t total = 0;
  for (size_t k = 0; k < n; k++) {
    columns->start[k] = total;
    total += fill[k];
    fill[k] = columns->start[k];
  }
  columns->start[n] = total;
  columns->plane = tsi_arena_new(arena, total, sizeof(int));
  if (!columns->plane)
    return tsi_no_memory(context, STAGE);
  for (int c = 0; c < tmesh->n_cells; c++)
    mark_cell(columns, tmesh->cell + 6 * (size_t)c, fill, columns->plane);
  tidy_columns(columns);
  return TSOLID_OK;
}

void tsi_columns_local_knots(const tsi_columns *columns, const int node[3], int knot[5]) {
  int own = node[columns->axis];
  int k = lower_column(columns, node[first_axis(columns->axis)], node[second_axis(columns->axis)]);
  const int *plane = columns->plane + columns->start[k];
  int n = (int)(columns->start[k + 1] - columns->start[k]), at = 0, high = n;
  while (at < high) { /* the node's own plane: some cell has a corner there */
    int middle = at + (high - at) / 2;
    if (plane[middle] < own)
      at = middle + 1;
    else
      high = middle;
  }
  for (int i = -2; i <= 2; i++) {
    int j = at + i < 0 ? 0 : at + i > n - 1 ? n - 1 : at + i;
    knot[i + 2] = plane[j];
  }
}
