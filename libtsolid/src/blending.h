/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TSI_BLENDING_H
#define TSI_BLENDING_H

#include "internal.h"

/* Fills n_inner, piece_start and piece of a space whose tmesh is set. */
tsolid_status tsi_blending_create(tsolid_context *context, tsolid_space *space);

#endif
