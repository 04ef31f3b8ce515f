/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TSI_PRECONDITION_H
#define TSI_PRECONDITION_H

#include "internal.h"

/* Diagonal of  sum over elements and axes of factor[e][a] int (d phi / d xi_a)^2  for the free
 * functions phi = w N (zeroed by the caller; for layer R- an estimate): enough to scale a solve.
 * 0: no memory. */
int tsi_stiffness_diagonal(const tsolid_space *space, const tsi_allocator *allocator,
                           const double *control, const double (*factor)[3], double *diagonal);

#endif
