/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The solid: a space and its control points. */
#include "solid.h"
#include "bvh.h"
#include "transfinite.h"

static const char *const STAGE = "solid";

void tsi_boundary_positions(const tsolid_space *space, double *position, double centre[3]) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  const double *points = space->boundary->points;
  for (int i = 0; i < space->n_surface; i++)
    for (int c = 0; c < 3; c++) {
      double x = points[4 * (size_t)i + (size_t)c] / points[4 * (size_t)i + 3];
      position[3 * (size_t)i + (size_t)c] = x;
      low[c] = fmin(low[c], x);
      high[c] = fmax(high[c], x);
    }
  for (int c = 0; c < 3; c++)
    centre[c] = 0.5 * (low[c] + high[c]);
  for (int i = 0; i < 3 * space->n_surface; i++)
    position[i] -= centre[i % 3];
}

tsolid_status tsi_solid_new(tsolid_context *context, const tsolid_space *space,
                            const double *control, double start_worst, tsolid_solid **solid) {
  *solid = NULL;
  size_t n = (size_t)space->n_inner + 2 * (size_t)space->n_surface;
  tsolid_solid *s = tsi_new(&context->allocator, 1, sizeof *s);
  if (!s)
    return tsi_no_memory(context, STAGE);
  s->allocator = context->allocator;
  s->references = 1;
  s->space = space;
  s->start_worst = start_worst;
  tsi_space_retain(space);
  s->control = tsi_new(&context->allocator, 4 * n, sizeof *s->control);
  tsolid_status status = s->control ? TSOLID_OK : tsi_no_memory(context, STAGE);
  if (status == TSOLID_OK) {
    memcpy(s->control, control, 4 * n * sizeof *control);
    s->constant_weight = 1;
    for (size_t f = 1; f < n; f++)
      s->constant_weight &= control[4 * f + 3] == control[3];
    status = tsi_solid_index(context, s);
  }
  if (status == TSOLID_OK)
    *solid = s;
  else
    tsolid_solid_free(s);
  return status;
}

tsolid_status tsolid_solid_create(tsolid_context *context, const tsolid_space *space,
                                  tsolid_solid **solid) {
  if (!context || !space || !solid)
    return TSOLID_ERROR_ARGUMENT;
  *solid = NULL;
  size_t n_free = (size_t)(space->n_inner + space->n_surface), m = (size_t)space->n_surface;
  double *control = tsi_new(&context->allocator, n_free + m, 4 * sizeof *control);
  double *position = tsi_new(&context->allocator, n_free + m, 3 * sizeof *position), centre[3];
  tsolid_status status =
      control && position ? tsi_progress(context, STAGE, 0.0) : tsi_no_memory(context, STAGE);
  if (status == TSOLID_OK)
    status = tsi_weights_choose(context, space, control);
  if (status == TSOLID_OK) {
    tsi_boundary_positions(space, position + 3 * n_free, centre);
    status = tsi_transfinite_start(context, space, centre, position);
  }
  if (status == TSOLID_OK) {
    for (size_t f = 0; f < n_free; f++)
      for (size_t c = 0; c < 3; c++)
        control[4 * f + c] = control[4 * f + 3] * (position[3 * f + c] + centre[c]);
    memcpy(control + 4 * n_free, space->boundary->points, 4 * m * sizeof *control);
    if (space->tmesh->flags & TSI_TMESH_SHARP_CORE)
      status = tsi_transfinite_follow(context, space, control);
  }
  if (status == TSOLID_OK)
    status = tsi_solid_new(context, space, control, (double)NAN, solid);
  tsi_delete(&context->allocator, control);
  tsi_delete(&context->allocator, position);
  return status;
}

tsolid_status tsolid_solid_from_control(tsolid_context *context, const tsolid_space *space,
                                        const double *control, tsolid_solid **solid) {
  if (!context || !space || !control || !solid)
    return TSOLID_ERROR_ARGUMENT;
  *solid = NULL;
  size_t n_free = (size_t)space->n_inner + (size_t)space->n_surface;
  size_t n = n_free + (size_t)space->n_surface;
  for (size_t i = 0; i < 4 * n; i++)
    if (!isfinite(control[i]) || (i % 4 == 3 && !(control[i] > 0.0)))
      return tsi_fail(context, TSOLID_ERROR_INPUT, STAGE,
                      "Control point %zu has a coordinate that is not finite, or a weight that is "
                      "not positive",
                      i / 4);
  if (memcmp(control + 4 * n_free, space->boundary->points,
             4 * (size_t)space->n_surface * sizeof *control) != 0)
    return tsi_fail(context, TSOLID_ERROR_INPUT, STAGE,
                    "The control points of the boundary layer are not the boundary's own");
  return tsi_solid_new(context, space, control, (double)NAN, solid);
}

void tsi_solid_retain(const tsolid_solid *solid) {
  ((tsolid_solid *)(uintptr_t)solid)->references++; /* the count is no part of the value */
}

void tsolid_solid_free(tsolid_solid *solid) {
  if (!solid || --solid->references > 0)
    return;
  tsi_allocator allocator = solid->allocator;
  tsolid_space_free((tsolid_space *)(uintptr_t)solid->space);
  tsi_bvh_free(solid->physical);
  tsi_delete(&allocator, solid->control);
  tsi_delete(&allocator, solid);
}

const tsolid_space *tsolid_solid_space(const tsolid_solid *solid) {
  return solid->space;
}

const double *tsolid_solid_control(const tsolid_solid *solid) {
  return solid->control;
}
