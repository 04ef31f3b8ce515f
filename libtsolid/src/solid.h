/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TSI_SOLID_H
#define TSI_SOLID_H

#include "internal.h"

/* A solid with these homogeneous control points (copied). Every way to make a solid ends here. */
tsolid_status tsi_solid_new(tsolid_context *context, const tsolid_space *space,
                            const double *control, double start_worst, tsolid_solid **solid);

/* Euclidean boundary control points, rows of 3, relative to the centre of their bounding box. */
void tsi_boundary_positions(const tsolid_space *space, double *position, double centre[3]);

/* Diagonal of  sum over elements and axes of factor[e][a] int (d phi / d xi_a)^2  for the free
 * functions phi = w N (zeroed by the caller; for layer R- an estimate): enough to scale a solve.
 * 0: no memory. */
int tsi_stiffness_diagonal(const tsolid_space *space, const tsi_allocator *allocator,
                           const double *control, const double (*factor)[3], double *diagonal);

#endif
