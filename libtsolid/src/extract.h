/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The steps from cells and functions to Bezier elements with separable extraction. */
#ifndef TSI_EXTRACT_H
#define TSI_EXTRACT_H

#include "internal.h"

/* Value of a piece's support along an axis: lo, hi per axis in cross coordinates. */
void tsi_piece_support(const tsolid_tmesh *tmesh, const tsi_piece *piece, double box[6]);

/* elements.c: cuts cells into elements (n_elements, element without rows) and makes the lateral
 * cells with the surface functions on them. */
tsolid_status tsi_elements_create(tsolid_context *context, tsolid_space *space);

/* lateral.c: lateral[e] is the lateral cell of the arm element with this box (s0, s1, t0, t1). */
typedef struct tsi_lateral_request {
  int side, side_element;
  double box[4];
  int element;
} tsi_lateral_request;

/* Makes the lateral cells asked for (equal ones once), sorted by side, element and box, and sets
 * element[request.element].lateral. */
tsolid_status tsi_laterals_create(tsolid_context *context, tsolid_space *space, int n_requests,
                                  tsi_lateral_request *request);

#endif
