/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TSI_TRANSFINITE_H
#define TSI_TRANSFINITE_H

#include "internal.h"

/* Euclidean positions, relative to `centre`, of the free functions (inner, then R-): rows of 3. */
tsolid_status tsi_transfinite_start(tsolid_context *context, const tsolid_space *space,
                                    const double centre[3], double *position);

/* Moves all free control points (rows of 4 of all functions) so that the solid follows the same map
 * closely; they stay where a weight would not be positive. */
tsolid_status tsi_transfinite_follow(tsolid_context *context, const tsolid_space *space,
                                     double *control);

#endif
