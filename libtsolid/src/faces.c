/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Faces are found through the tree over element boxes; one element may meet many across a
 * T-junction or the core surface. Borders inside blocks are equal bit for bit; along diagonals r /
 * R is rounded, so slivers of that width are no faces. */
#include "faces.h"

#include "bvh.h"
#include "evaluate.h"

#define SLIVER 1e-12

static const char *const STAGE = "report";

/* ---- two passes: count, then fill --------------------------------------------------------------
 */

typedef struct collector {
  const tsolid_space *space;
  tsi_face *face; /* NULL: count only */
  int n;
  int element, axis; /* inside blocks: the element whose high face is looked at */
  const int *other;  /* on diagonals: the elements of the second arm */
  const double *other_box;
  tsi_face diagonal; /* all but element[1] and box */
} collector;

static void emit(collector *c, const tsi_face *face) {
  if (c->face)
    c->face[c->n] = *face;
  c->n++;
}

static int intersect(const double a[4], const double b[4], double sliver, double box[4]) {
  for (int k = 0; k < 4; k += 2) {
    box[k] = fmax(a[k], b[k]);
    box[k + 1] = fmin(a[k + 1], b[k + 1]);
    if (!(box[k + 1] - box[k] > sliver))
      return 0;
  }
  return 1;
}

/* ---- faces normal to an axis -------------------------------------------------------------------
 */

static int may_meet(const tsi_element *low, const tsi_element *high, int axis) {
  if (low->block == high->block)
    return 1;
  return low->block == 0 ? high->block == 2 + 2 * axis
                         : high->block == 0 && low->block == 1 + 2 * axis;
}

static int meet_above(void *data, int item) {
  collector *c = data;
  int d = c->axis, s = tsi_side_s(2 * d), t = tsi_side_t(2 * d);
  const tsi_element *low = &c->space->element[c->element], *high = &c->space->element[item];
  if (high->box[d] != low->box[d + 3] || !may_meet(low, high, d))
    return 0;
  tsi_face face = {.kind = low->block == high->block ? TSI_FACE_BLOCK : TSI_FACE_CORE,
                   .element = {c->element, item},
                   .axis = {d, d},
                   .end = {1, 0},
                   .along = {{s, t}, {s, t}},
                   .scale = {1.0, 1.0}};
  double a[4] = {low->box[s], low->box[s + 3], low->box[t], low->box[t + 3]};
  double b[4] = {high->box[s], high->box[s + 3], high->box[t], high->box[t + 3]};
  if (intersect(a, b, 0.0, face.box))
    emit(c, &face);
  return 0;
}

static void collect_straight(collector *c) {
  for (int e = 0; e < c->space->n_elements; e++)
    for (int d = 0; d < 3; d++) {
      double box[6];
      memcpy(box, c->space->element[e].box, sizeof box);
      box[d] = box[d + 3];
      c->element = e;
      c->axis = d;
      tsi_bvh_overlapping(c->space->locate, box, 0.0, meet_above, c);
    }
}

/* ---- diagonals ---------------------------------------------------------------------------------
 */

/* One of the two arms at an isoline: its side, and the lateral axis and end that face the other. */
typedef struct wing {
  int side, lateral_axis, lateral_end;
  double offset, scale; /* u[axis] = offset + scale rho */
} wing;

static wing make_wing(const tsolid_tmesh *tmesh, int side, int other_side) {
  double range[6];
  int axis = tsi_side_axis(side);
  tsi_block_range(tmesh, 1 + side, range);
  double height = range[axis + 3] - range[axis];
  return (wing){.side = side,
                .lateral_axis = tsi_side_axis(other_side),
                .lateral_end = other_side & 1,
                .offset = side & 1 ? 1.0 : 0.0,
                .scale = side & 1 ? height : -height};
}

/* The (rho, along) rectangle of an element's face on the diagonal; 0: it has none. */
static int wing_rectangle(const tsi_element *element, const wing *w, int along, double box[4]) {
  int axis = tsi_side_axis(w->side), b = w->lateral_axis;
  if (element->block != 1 + w->side || element->box[b + 3 * w->lateral_end] != w->lateral_end)
    return 0;
  double r0 = (element->box[axis] - w->offset) / w->scale;
  double r1 = (element->box[axis + 3] - w->offset) / w->scale;
  box[0] = fmin(r0, r1);
  box[1] = fmax(r0, r1);
  box[2] = element->box[along];
  box[3] = element->box[along + 3];
  return 1;
}

static int meet_across(void *data, int item) {
  collector *c = data;
  tsi_face face = c->diagonal;
  const double *flat = c->other_box + 6 * (size_t)item;
  double other[4] = {flat[0], flat[3], flat[1], flat[4]};
  face.element[1] = c->other[item];
  if (intersect(c->diagonal.box, other, SLIVER, face.box))
    emit(c, &face);
  return 0;
}

static tsi_face diagonal_face(const wing *first, const wing *second, int along) {
  return (tsi_face){
      .kind = TSI_FACE_DIAGONAL,
      .axis = {first->lateral_axis, second->lateral_axis},
      .end = {first->lateral_end, second->lateral_end},
      .along = {{tsi_side_axis(first->side), along}, {tsi_side_axis(second->side), along}},
      .offset = {first->offset, second->offset},
      .scale = {first->scale, second->scale}};
}

static tsolid_status collect_diagonal(tsolid_context *context, collector *c, int isoline,
                                      int *other, double *other_box) {
  int along = isoline >> 2, a = tsi_side_s(2 * along), b = tsi_side_t(2 * along);
  int side[2] = {2 * a + (isoline & 1), 2 * b + (isoline >> 1 & 1)}, n = 0;
  wing first = make_wing(c->space->tmesh, side[0], side[1]);
  wing second = make_wing(c->space->tmesh, side[1], side[0]);
  double box[4];
  for (int e = 0; e < c->space->n_elements; e++)
    if (wing_rectangle(&c->space->element[e], &second, along, box)) {
      double flat[6] = {box[0], box[2], 0.0, box[1], box[3], 0.0};
      memcpy(other_box + 6 * (size_t)n, flat, sizeof flat);
      other[n++] = e;
    }
  struct tsi_bvh *tree = tsi_bvh_create(&context->allocator, n, other_box);
  if (!tree)
    return tsi_no_memory(context, STAGE);
  c->other = other;
  c->other_box = other_box;
  for (int e = 0; e < c->space->n_elements; e++)
    if (wing_rectangle(&c->space->element[e], &first, along, box)) {
      double flat[6] = {box[0], box[2], 0.0, box[1], box[3], 0.0};
      c->diagonal = diagonal_face(&first, &second, along);
      c->diagonal.element[0] = e;
      memcpy(c->diagonal.box, box, sizeof box);
      tsi_bvh_overlapping(tree, flat, 0.0, meet_across, c);
    }
  tsi_bvh_free(tree);
  return TSOLID_OK;
}

/* ---- driver ------------------------------------------------------------------------------------
 */

tsolid_status tsi_faces_create(tsolid_context *context, const tsolid_space *space, tsi_arena *arena,
                               int *n, tsi_face **face) {
  size_t n_elements = (size_t)space->n_elements;
  collector c = {.space = space};
  int *other = tsi_arena_new(arena, n_elements, sizeof *other);
  double *other_box = tsi_arena_new(arena, n_elements, 6 * sizeof *other_box);
  if (!other || !other_box)
    return tsi_no_memory(context, STAGE);
  for (int pass = 0; pass < 2; pass++) {
    c.n = 0;
    collect_straight(&c);
    for (int isoline = 0; isoline < 12; isoline++) {
      tsolid_status status = collect_diagonal(context, &c, isoline, other, other_box);
      if (status != TSOLID_OK)
        return status;
    }
    if (pass == 0)
      c.face = tsi_arena_new(arena, (size_t)c.n, sizeof *c.face);
    if (!c.face)
      return tsi_no_memory(context, STAGE);
  }
  *n = c.n;
  *face = c.face;
  return TSOLID_OK;
}

void tsi_face_local(const tsolid_space *space, const tsi_face *face, int k, double p, double q,
                    double x[3]) {
  const tsi_element *element = &space->element[face->element[k]];
  double u[3];
  u[face->axis[k]] = element->box[face->axis[k] + 3 * face->end[k]];
  u[face->along[k][0]] = face->offset[k] + face->scale[k] * p;
  u[face->along[k][1]] = q;
  tsi_element_local(element, u, x);
}
