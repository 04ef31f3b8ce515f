/* SPDX-License-Identifier: LGPL-2.1-or-later
 * T-vertices: corners of patches inside borders of others, and the pieces that isolines through
 * them cut the patches into. */
#ifndef TSI_SPLIT_H
#define TSI_SPLIT_H

#include "boundary.h"

/* An isoline at x of one direction, through search point `point` on border slot `border`. */
typedef struct tsi_cut {
  double x;
  int point, border;
} tsi_cut;

/* Ascending. */
typedef struct tsi_cuts {
  int n, capacity;
  tsi_cut *cut;
} tsi_cuts;

/* A patch in an orientation that its points alone tell: `place` leads there from the input's own.
 */
typedef struct tsi_split_patch {
  int number; /* in the list */
  tsi_place place;
  tsi_patch patch;   /* n[0] = 0: */
  tsi_side elements; /* instead, also of T-splines */
  tsi_cuts cuts[2];  /* constant u, constant v */
} tsi_split_patch;

/* Replaces the patches of the list by their pieces, exactly: in the list's order, u fastest. */
tsolid_status tsi_pieces_make(tsolid_context *context, tsi_arena *arena,
                              const tsolid_boundary_input *input, double tolerance,
                              const double origin[3], const tsi_split_patch *split,
                              tsi_patch_list *list);

#endif
