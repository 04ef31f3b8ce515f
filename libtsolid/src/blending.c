/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Inner functions: one per T-mesh node of the core and of the arms below R-.
 *
 * A node in an arm that lies on a diagonal is the same node as its image in the neighbouring arm:
 * it is one function with one piece per arm that meets there (two on a diagonal, three on a spoke).
 * Everywhere else a function is one piece, which reaches from the core into an arm, or back, by its
 * local knots. Functions are numbered by the position of their node on the core surface and their
 * depth in the layers, so that glued nodes stand together. */
#include "blending.h"
#include "tmesh.h"

#include <stdlib.h>

static const char *const STAGE = "space";

/* A node with the key under which glued nodes meet: its place projected to the core surface along
 * the arm, and its depth (in planes) in the layers; depth 0: not glued. */
typedef struct entry {
  int key[4]; /* plane 2, plane 1, plane 0, depth */
  int block;  /* the arm of a glued piece, else -1 */
  int node;
} entry;

static int compare_entries(const void *a, const void *b) {
  const entry *p = a, *q = b;
  for (int i = 0; i < 4; i++)
    if (p->key[i] != q->key[i])
      return p->key[i] < q->key[i] ? -1 : 1;
  return (p->block > q->block) - (p->block < q->block);
}

/* Depth of R-: nodes from there outward carry surface functions. */
enum { DEPTH_R_MINUS = 3 };

/* 0 when the node carries no inner function. */
static int make_entry(const tsolid_tmesh *tmesh, const int *node, int index, entry *e) {
  int arm_axis = -1, depth = 0, on_diagonal = 0, projected[3];
  for (int a = 0; a < 3; a++) {
    int p = node[a], high = tsi_high_plane(tmesh, a);
    projected[a] = p < TSI_LOW_PLANE ? TSI_LOW_PLANE : p > high ? high : p;
    if (p != projected[a]) {
      arm_axis = a;
      depth = abs(p - projected[a]);
    }
  }
  if (depth >= DEPTH_R_MINUS)
    return 0;
  for (int a = 0; a < 3 && arm_axis >= 0; a++)
    if (a != arm_axis)
      on_diagonal |= node[a] == TSI_LOW_PLANE || node[a] == tsi_high_plane(tmesh, a);
  const int *place = on_diagonal ? projected : node;
  *e = (entry){
      .key = {place[2], place[1], place[0], on_diagonal ? depth : 0}, .block = -1, .node = index};
  if (on_diagonal)
    e->block = 1 + 2 * arm_axis + (node[arm_axis] > TSI_LOW_PLANE);
  return 1;
}

static int same_key(const entry *a, const entry *b) {
  return memcmp(a->key, b->key, sizeof a->key) == 0;
}

/* Numbers the functions and copies their nodes' local knots; 0: no memory. */
static int fill_pieces(tsolid_space *space, int n_entries, const entry *list, const int *node,
                       const tsi_columns columns[3]) {
  int n_functions = 0;
  for (int i = 0; i < n_entries; i++)
    n_functions += i == 0 || !same_key(&list[i], &list[i - 1]);
  space->n_inner = n_functions;
  space->piece_start =
      tsi_new(&space->allocator, (size_t)n_functions + 1, sizeof *space->piece_start);
  space->piece = tsi_new(&space->allocator, (size_t)n_entries, sizeof *space->piece);
  if (!space->piece_start || !space->piece)
    return 0;
  int f = 0;
  for (int i = 0; i < n_entries; i++) {
    if (i == 0 || !same_key(&list[i], &list[i - 1]))
      space->piece_start[f++] = i;
    space->piece[i].block = list[i].block;
    for (int a = 0; a < 3; a++)
      tsi_columns_local_knots(&columns[a], node + 3 * (size_t)list[i].node,
                              space->piece[i].knot[a]);
  }
  space->piece_start[n_functions] = n_entries;
  return 1;
}

tsolid_status tsi_blending_create(tsolid_context *context, tsolid_space *space) {
  tsi_arena arena = tsi_arena_create(context);
  tsi_columns columns[3];
  int n_nodes, *node, n_entries = 0;
  tsolid_status status = tsi_tmesh_nodes(context, space->tmesh, &arena, &n_nodes, &node);
  for (int a = 0; a < 3 && status == TSOLID_OK; a++)
    status = tsi_columns_create(context, space->tmesh, a, n_nodes, node, &arena, &columns[a]);
  if (status != TSOLID_OK)
    goto done;
  entry *list = tsi_arena_new(&arena, (size_t)n_nodes, sizeof *list);
  if (!list) {
    status = tsi_no_memory(context, STAGE);
    goto done;
  }
  for (int i = 0; i < n_nodes; i++)
    n_entries += make_entry(space->tmesh, node + 3 * (size_t)i, i, &list[n_entries]);
  qsort(list, (size_t)n_entries, sizeof *list, compare_entries);
  if (!fill_pieces(space, n_entries, list, node, columns))
    status = tsi_no_memory(context, STAGE);
done:
  tsi_arena_free(&arena);
  return status;
}
