/* SPDX-License-Identifier: LGPL-2.1-or-later
 * An input of patches or Bezier sides that owns its memory. */
#ifndef TSI_BOUNDARY_FILE_H
#define TSI_BOUNDARY_FILE_H

#include "internal.h"

struct tsolid_boundary_file {
  tsi_allocator allocator;
  tsi_arena arena; /* everything that `input` points to */
  tsolid_boundary_input input;
};

/* Empty; NULL: no memory. */
tsolid_boundary_file *tsi_boundary_file_new(tsolid_context *context);

#endif
