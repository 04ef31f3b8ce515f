/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Nodes and rays of a T-mesh: integer topology only.
 *
 * Source: Sederberg et al. (2003), rule 1 for local knot vectors, in three dimensions: the knots of
 * a node along an axis are the planes of the next two faces that its ray meets each way. Rays along
 * one line share a column: its planes are found once, by letting every cell mark the columns that
 * run through it (closed), so the cost is the number of (cell, column) pairs that meet. */
#include "tmesh.h"

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

/* ---- nodes
 * ------------------------------------------------------------------------------------------ */

static int compare_nodes(const void *a, const void *b) {
  const int *p = a, *q = b;
  for (int i = 2; i >= 0; i--)
    if (p[i] != q[i])
      return p[i] < q[i] ? -1 : 1;
  return 0;
}

tsolid_status tsi_tmesh_nodes(tsolid_context *context, const tsolid_tmesh *tmesh, tsi_arena *arena,
                              int *n, int **node) {
  size_t n_corners = 8 * (size_t)tmesh->n_cells, unique = 0;
  *n = 0;
  *node = tsi_arena_new(arena, n_corners, 3 * sizeof(int));
  if (!*node || n_corners > TSI_MAX_COUNT)
    return tsi_no_memory(context, STAGE);
  for (size_t c = 0; c < n_corners; c++)
    for (int a = 0; a < 3; a++)
      (*node)[3 * c + (size_t)a] = tmesh->cell[6 * (c / 8) + (size_t)(a + 3 * (int)(c >> a & 1))];
  qsort(*node, n_corners, 3 * sizeof(int), compare_nodes);
  for (size_t c = 0; c < n_corners; c++)
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
