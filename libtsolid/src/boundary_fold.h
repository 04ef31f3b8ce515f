/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TSI_BOUNDARY_FOLD_H
#define TSI_BOUNDARY_FOLD_H

#include "internal.h"

/* TSOLID_ERROR_REFUSED, with a finding for every side that does, when a side's surface folds over
 * itself: then det J > 0 cannot be had. */
tsolid_status tsi_boundary_check_folds(tsolid_context *context, const tsolid_boundary *boundary);

#endif
