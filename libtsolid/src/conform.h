/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The parts of the conformity report that measure a finished solid. */
#ifndef TSI_CONFORM_H
#define TSI_CONFORM_H

#include "faces.h"
#include "rank.h"

/* basis.c: sum, sign, traces and ranks of the functions. max_rank_functions as in
 * tsolid_report_options. */
tsolid_status tsi_basis_measure(tsolid_context *context, const tsolid_space *space, int n_faces,
                                const tsi_face *face, int max_rank_functions,
                                tsolid_basis_report *report);

/* Mass matrices of the inner functions over the parametric cross and of the surface
 * functions over six unit squares, not scaled; in the arena. */
tsolid_status tsi_mass_inner(tsolid_context *context, const tsolid_space *space, tsi_arena *arena,
                             tsi_symmetric *matrix);
tsolid_status tsi_mass_surface(tsolid_context *context, const tsolid_boundary *boundary,
                               tsi_arena *arena, tsi_symmetric *matrix);

/* continuity.c: measured against expected order on every interior face. order and expected (one
 * entry per face, -1..2) may be NULL. */
tsolid_status tsi_continuity_measure(tsolid_context *context, const tsolid_solid *solid,
                                     int n_faces, const tsi_face *face, int *order, int *expected,
                                     tsolid_continuity_report *report);

/* conform.c: distance to the input, volume and flux. */
tsolid_status tsi_conformity_measure(tsolid_context *context, const tsolid_solid *solid,
                                     tsolid_conformity_report *report);

/* conform.c: a boundary point by the boundary's own functions and control points; 0: no element
 * holds (s, t). */
int tsi_boundary_point(const tsolid_boundary *boundary, int side, double s, double t,
                       double point[3]);

#endif
