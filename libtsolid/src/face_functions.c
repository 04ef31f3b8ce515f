/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The functions that do not vanish on a region of the boundary: what a Dirichlet condition sets.
 *
 * At r = R the layer R alone is not zero, and there it is the input's own functions. So a function
 * of that layer does not vanish on a region exactly when it is not the zero polynomial on an
 * element whose outer face shares an area with the region: when one of its Bernstein coefficients
 * there is not zero. */
#include "evaluate.h"

static const char stage[] = "matrix";

/* The region's box covers an area of the lateral cell. */
static int overlap(const tsi_lateral *lateral, const tsolid_region *region) {
  for (int d = 0; d < 2; d++)
    if (!(fmax(lateral->box[2 * d], region->box[2 * d]) <
          fmin(lateral->box[2 * d + 1], region->box[2 * d + 1])))
      return 0;
  return 1;
}

/* Marks the surface functions that are not zero on the cell. */
static void mark_cell(const tsolid_space *space, const tsi_lateral *lateral, unsigned char *mark) {
  size_t width = (size_t)(lateral->degree[0] + 1) * (size_t)(lateral->degree[1] + 1);
  const double *coefficient = space->lateral_coefficient + lateral->coefficient_first;
  for (int i = lateral->function_first; i < lateral->function_end; i++, coefficient += width)
    for (size_t k = 0; k < width; k++)
      if (coefficient[k] != 0.0) {
        mark[space->lateral_function[i]] = 1;
        break;
      }
}

tsolid_status tsolid_face_functions(tsolid_context *context, const tsolid_solid *solid,
                                    const tsolid_region *region, int capacity, int *n,
                                    int *function) {
  if (!context || !n)
    return TSOLID_ERROR_ARGUMENT;
  *n = 0;
  if (!solid || !region || region->side < 0 || region->side > 5)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "No solid, no region or no side");
  const tsolid_space *space = solid->space;
  tsi_arena arena = tsi_arena_create(context);
  unsigned char *mark = tsi_arena_new(&arena, (size_t)space->n_surface, 1);
  tsolid_status status = TSOLID_OK;
  if (!mark) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  for (int k = 0; k < space->n_laterals; k++)
    if (space->lateral[k].side == region->side && overlap(&space->lateral[k], region))
      mark_cell(space, &space->lateral[k], mark);
  int count = 0;
  for (int k = 0; k < space->n_surface; k++)
    if (mark[k]) {
      if (function && count < capacity)
        function[count] = space->n_inner + space->n_surface + k;
      count++;
    }
  *n = count;
  if (function && count > capacity)
    status = tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "%d functions, room for %d", count,
                      capacity);
done:
  tsi_arena_free(&arena);
  return status;
}
