/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TSI_SOLID_H
#define TSI_SOLID_H

#include "internal.h"

/* A solid with these homogeneous control points (copied). Every way to make a solid ends here. */
tsolid_status tsi_solid_new(tsolid_context *context, const tsolid_space *space,
                            const double *control, double start_worst, tsolid_solid **solid);

/* Euclidean boundary control points, rows of 3, relative to the centre of their bounding box. */
void tsi_boundary_positions(const tsolid_space *space, double *position, double centre[3]);

/* Weights of all functions into column 3 of control (homogeneous rows of 4). */
tsolid_status tsi_weights_choose(tsolid_context *context, const tsolid_space *space,
                                 double *control);

#endif
