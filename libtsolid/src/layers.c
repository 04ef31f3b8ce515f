/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Bands and layers: the T-mesh's cells from the core's boxes.
 *
 * Source: Zhang, Wang, Hughes (2012), sections 4 and 5. Every core boundary face is extruded into
 * two layers and the zero-interval layer under the boundary. Cells that touch an irregular edge get
 * zero-interval planes beside it:
 *
 *      arm cell on the diagonal            core cell on a core edge (x high and y high)
 *
 *   r1 +-----------+--+                 high +-----------+--+
 *      |           |  |                      |           |  |
 *      |           |  |                   1' +-----------+--+   1' and high have one value
 *   1''+-----------+--+                      |           |  |
 *  high+-----------+--+                      |           |  |
 *      lo         1' high                    +-----------+--+
 *
 * With a sharp core surface all cells at it get them, so that the functions are C^0 across it and
 * can follow a map that is smooth block by block.
 */
#include "closure.h"
#include "internal.h"
#include "tmesh.h"

#include <stdlib.h>

static const char *const STAGE = "tmesh";

enum { MAX_GRID = 1 << 27 };

/* ---- the boxes tile the core --------------------------------------------------------------------
 */

static int box_is_sane(const int *box, const int n_lines[3]) {
  for (int a = 0; a < 3; a++)
    if (box[a] < 0 || box[a] >= box[a + 3] || box[a + 3] >= n_lines[a])
      return 0;
  return 1;
}

/* Paints every box on the grid of the lines: each grid cell must be covered exactly once. */
static tsolid_status check_tiling(tsolid_context *context, const int n_lines[3], int n_boxes,
                                  const int *box) {
  size_t n[3], grid = 1, painted = 0;
  for (int a = 0; a < 3; a++) {
    n[a] = (size_t)n_lines[a] - 1;
    if (grid > MAX_GRID / n[a])
      return tsi_fail(context, TSOLID_ERROR_REFUSED, STAGE, "The core has too many lines");
    grid *= n[a];
  }
  unsigned char *covered = tsi_new(&context->allocator, grid, 1);
  if (!covered)
    return tsi_no_memory(context, STAGE);
  tsolid_status status = TSOLID_OK;
  for (int b = 0; b < n_boxes && status == TSOLID_OK; b++) {
    const int *c = box + 6 * (size_t)b;
    if (!box_is_sane(c, n_lines)) {
      status = tsi_fail(context, TSOLID_ERROR_INPUT, STAGE, "Core cell %d is not a box", b);
      break;
    }
    for (int k = c[2]; k < c[5]; k++)
      for (int j = c[1]; j < c[4]; j++)
        for (int i = c[0]; i < c[3]; i++) {
          unsigned char *at = covered + ((size_t)k * n[1] + (size_t)j) * n[0] + (size_t)i;
          if (*at && status == TSOLID_OK)
            status =
                tsi_fail(context, TSOLID_ERROR_INPUT, STAGE, "Core cells overlap at cell %d", b);
          *at = 1;
          painted++;
        }
  }
  if (status == TSOLID_OK && painted != grid)
    status = tsi_fail(context, TSOLID_ERROR_INPUT, STAGE, "The core's cells leave a gap");
  tsi_delete(&context->allocator, covered);
  return status;
}

/* ---- cells
 * ----------------------------------------------------------------------------------------- */

/* Consecutive planes that cut one axis of a cell. */
typedef struct cuts {
  int n, plane[5];
} cuts;

static void add_cut(cuts *c, int plane) {
  c->plane[c->n++] = plane;
}

static int plane_of_line(const tsolid_tmesh *tmesh, int axis, int line) {
  if (line == 0)
    return TSI_LOW_PLANE;
  return line == tmesh->n_lines[axis] - 1 ? tsi_high_plane(tmesh, axis) : TSI_LOW_PLANE + 1 + line;
}

/* Planes along one axis of a core box, with the zero-interval ones where `banded`. */
static cuts core_cuts(const tsolid_tmesh *tmesh, const int *box, int axis, int banded) {
  cuts c = {0, {0}};
  int low = box[axis] == 0, high = box[axis + 3] == tmesh->n_lines[axis] - 1;
  add_cut(&c, plane_of_line(tmesh, axis, box[axis]));
  if (low && banded)
    add_cut(&c, TSI_LOW_PLANE + 1);
  if (high && banded)
    add_cut(&c, tsi_high_plane(tmesh, axis) - 1);
  add_cut(&c, plane_of_line(tmesh, axis, box[axis + 3]));
  return c;
}

/* Planes through the layers of an arm, from low to high. */
static cuts layer_cuts(const tsolid_tmesh *tmesh, int side, int banded) {
  cuts c = {0, {0}};
  int high = tsi_high_plane(tmesh, tsi_side_axis(side));
  if (side & 1) {
    add_cut(&c, high);
    if (banded)
      add_cut(&c, high + 1);
    add_cut(&c, high + 2);
    add_cut(&c, high + 3);
    add_cut(&c, high + 4);
  } else {
    add_cut(&c, 0);
    add_cut(&c, 1);
    add_cut(&c, 2);
    if (banded)
      add_cut(&c, 3);
    add_cut(&c, 4);
  }
  return c;
}

static void emit_cells(tsolid_tmesh *tmesh, const cuts c[3], int block) {
  for (int k = 0; k + 1 < c[2].n; k++)
    for (int j = 0; j + 1 < c[1].n; j++)
      for (int i = 0; i + 1 < c[0].n; i++) {
        int at = tmesh->n_cells++;
        if (!tmesh->cell)
          continue; /* counting pass */
        int row[6] = {c[0].plane[i],     c[1].plane[j],     c[2].plane[k],
                      c[0].plane[i + 1], c[1].plane[j + 1], c[2].plane[k + 1]};
        memcpy(tmesh->cell + 6 * (size_t)at, row, sizeof row);
        tmesh->cell_block[at] = block;
      }
}

static int touches(const tsolid_tmesh *tmesh, const int *box, int axis) {
  return box[axis] == 0 || box[axis + 3] == tmesh->n_lines[axis] - 1;
}

static int touches_side(const tsolid_tmesh *tmesh, const int *box, int side) {
  int axis = tsi_side_axis(side);
  return side & 1 ? box[axis + 3] == tmesh->n_lines[axis] - 1 : box[axis] == 0;
}

/* The core box itself (block 0) or its extrusion through an arm (block 1 + side). */
static void emit_box(tsolid_tmesh *tmesh, const int *box, int block) {
  cuts c[3];
  int everywhere = tmesh->flags & TSI_TMESH_SHARP_CORE;
  for (int a = 0; a < 3; a++) {
    int b = (a + 1) % 3, d = (a + 2) % 3;
    int banded = everywhere || touches(tmesh, box, b) || touches(tmesh, box, d);
    if (block > 0 && tsi_side_axis(block - 1) == a)
      c[a] = layer_cuts(tmesh, block - 1, banded);
    else /* in an arm, a lateral border is on a diagonal: always banded */
      c[a] = core_cuts(tmesh, box, a, block > 0 || banded);
  }
  emit_cells(tmesh, c, block);
}

static void emit_all(tsolid_tmesh *tmesh) {
  tmesh->n_cells = 0;
  for (int block = 0; block < 7; block++)
    for (int b = 0; b < tmesh->n_boxes; b++) {
      const int *box = tmesh->box + 6 * (size_t)b;
      if (block == 0 || touches_side(tmesh, box, block - 1))
        emit_box(tmesh, box, block);
    }
}

/* ---- planes
 * ---------------------------------------------------------------------------------------- */

static void set_plane_values(tsolid_tmesh *tmesh, int axis) {
  double *v = tmesh->plane_value[axis];
  int n = tmesh->n_planes[axis], m = tmesh->n_lines[axis];
  double low = tmesh->arm_height[2 * axis], high = tmesh->arm_height[2 * axis + 1];
  v[0] = v[1] = -low;
  v[2] = -0.5 * low; /* r1 = R/2 in every arm: gluing maps r/R */
  v[3] = v[4] = v[5] = 0.0;
  for (int line = 1; line + 1 < m; line++)
    v[TSI_LOW_PLANE + 1 + line] = tmesh->line[axis][line];
  v[n - 6] = v[n - 5] = v[n - 4] = 1.0;
  v[n - 3] = 1.0 + 0.5 * high;
  v[n - 2] = v[n - 1] = 1.0 + high;
}

static tsolid_status check_lines(tsolid_context *context, const int n_lines[3],
                                 const double *const line[3], const double arm_height[6]) {
  for (int a = 0; a < 3; a++) {
    if (n_lines[a] < 2 || n_lines[a] > MAX_GRID)
      return tsi_fail(context, TSOLID_ERROR_INPUT, STAGE, "Axis %d has %d core lines", a,
                      n_lines[a]);
    int sane = line[a][0] == 0.0 && line[a][n_lines[a] - 1] == 1.0;
    for (int i = 1; sane && i < n_lines[a]; i++)
      sane = line[a][i] > line[a][i - 1];
    if (!sane)
      return tsi_fail(context, TSOLID_ERROR_INPUT, STAGE,
                      "The core lines of axis %d do not ascend from 0 to 1", a);
  }
  for (int i = 0; i < 6; i++)
    if (!(arm_height[i] > 0.0 && arm_height[i] <= 4.0))
      return tsi_fail(context, TSOLID_ERROR_INPUT, STAGE, "Arm %d has height %g", i, arm_height[i]);
  return TSOLID_OK;
}

/* Copies lines, boxes and heights and makes room for the planes; 0: no memory. */
static int fill_tmesh(tsolid_tmesh *t, const int n_lines[3], const double *const line[3],
                      int n_boxes, const int *box, const double arm_height[6]) {
  memcpy(t->arm_height, arm_height, sizeof t->arm_height);
  t->n_boxes = n_boxes;
  t->box = tsi_new(&t->allocator, 6 * (size_t)n_boxes, sizeof *t->box);
  if (!t->box)
    return 0;
  memcpy(t->box, box, 6 * (size_t)n_boxes * sizeof *t->box);
  for (int a = 0; a < 3; a++) {
    t->n_lines[a] = n_lines[a];
    t->n_planes[a] = n_lines[a] + TSI_EXTRA_PLANES;
    t->line[a] = tsi_new(&t->allocator, (size_t)n_lines[a], sizeof(double));
    t->plane_value[a] = tsi_new(&t->allocator, (size_t)t->n_planes[a], sizeof(double));
    if (!t->line[a] || !t->plane_value[a])
      return 0;
    memcpy(t->line[a], line[a], (size_t)n_lines[a] * sizeof(double));
    set_plane_values(t, a);
  }
  emit_all(t); /* counts */
  t->cell = tsi_new(&t->allocator, 6 * (size_t)t->n_cells, sizeof *t->cell);
  t->cell_block = tsi_new(&t->allocator, (size_t)t->n_cells, sizeof *t->cell_block);
  if (!t->cell || !t->cell_block)
    return 0;
  emit_all(t);
  t->n_cells_before_closure = t->n_cells;
  return 1;
}

tsolid_status tsi_tmesh_from_boxes(tsolid_context *context, const int n_lines[3],
                                   const double *const line[3], int n_boxes, const int *box,
                                   const double arm_height[6], int flags, tsolid_tmesh **tmesh) {
  *tmesh = NULL;
  tsolid_status status = check_lines(context, n_lines, line, arm_height);
  if (status == TSOLID_OK)
    status = check_tiling(context, n_lines, n_boxes, box);
  if (status != TSOLID_OK)
    return status;
  tsolid_tmesh *t = tsi_new(&context->allocator, 1, sizeof *t);
  if (!t)
    return tsi_no_memory(context, STAGE);
  t->allocator = context->allocator;
  t->references = 1;
  t->flags = flags;
  if (!fill_tmesh(t, n_lines, line, n_boxes, box, arm_height))
    status = tsi_no_memory(context, STAGE);
  if (status == TSOLID_OK && !(flags & TSI_TMESH_CLOSURE_OFF))
    status = tsi_closure(context, t, &t->n_closure_rounds);
  if (status == TSOLID_OK)
    status = tsi_tmesh_count_nodes(context, t);
  if (status == TSOLID_OK)
    *tmesh = t;
  else
    tsolid_tmesh_free(t);
  return status;
}
