/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The steps from input to boundary, private to the stage:
 *
 *     patches -> facets -> cube -> shell (canonical patches) -> belts, weights, snapping -> draft
 *     Bezier sides -> facets -> cube -> draft
 *     draft -> boundary */
#ifndef TSI_BOUNDARY_H
#define TSI_BOUNDARY_H

#include "cube.h"
#include "patch.h"

/* Sides in canonical position; functions still numbered anyhow. All arrays the arena's. */
typedef struct tsi_draft {
  int n_functions;
  double *points;
  tsi_side side[6];
} tsi_draft;

/* The patches in canonical position: side by side, each t-major, with knots on [0,1]. */
typedef struct tsi_shell {
  int n_strips[3];
  int first[7]; /* patches of side i: first[i] .. first[i+1]-1, (i, j) at i + n_s*j */
  tsi_patch *patch;
  const tsi_place **place;
  const tsi_facet *facet; /* by input number */
  double *line[3];        /* n_strips + 1 values where strips begin and end */
} tsi_shell;

/* Raises and inserts until all patches of every belt share degree and knots. */
tsolid_status tsi_shell_unify(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                              const tsolid_boundary_options *options,
                              tsolid_preparation *preparation);
/* Scales patches by constants until weights agree along all seams. */
tsolid_status tsi_shell_match_weights(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                      tsolid_preparation *preparation);
/* Makes the control rows of every seam one, bit for bit. */
tsolid_status tsi_shell_snap(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                             tsolid_preparation *preparation);
/* Strip widths, then Bezier elements and functions. */
tsolid_status tsi_shell_draft(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                              tsi_draft *draft);

/* Checks six Bezier sides, finds the cube in them and moves them to their places. */
tsolid_status tsi_draft_from_bezier(tsolid_context *context, tsi_arena *arena,
                                    const tsolid_bezier_boundary *input, double tolerance,
                                    tsolid_requirement *requirement, tsi_draft *draft);

/* Every invariant of sides; see tsi_boundary_validate. Isolines only make sense in canonical
 * position. */
tsolid_status tsi_sides_check(tsolid_context *context, int n_functions, const double *points,
                              const tsi_side side[6], int with_isolines);

#endif
