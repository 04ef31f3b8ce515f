/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TSI_CLOSURE_H
#define TSI_CLOSURE_H

#include "internal.h"

/* Splits cells until any two inner functions with overlapping supports disagree in one axis at most
 * (analysis-suitable: the functions sum to one), mirrored across the diagonals. *n_rounds receives
 * the number of rounds; a plain tensor core needs none. */
tsolid_status tsi_closure(tsolid_context *context, tsolid_tmesh *tmesh, int *n_rounds);

#endif
