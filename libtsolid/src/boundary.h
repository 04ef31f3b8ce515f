/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The steps from input to boundary, private to the stage:
 *
 *     patches -> facets -> pieces -> cube -> shell (canonical patches)
 *             -> parameters, factors, belts, rows along seams, weights, snapping -> draft
 *     Bezier sides -> facets -> cube -> draft
 *     draft -> boundary */
#ifndef TSI_BOUNDARY_H
#define TSI_BOUNDARY_H

#include "cube.h"
#include "patch.h"
#include "tspline.h"

/* Sides in canonical position; functions still numbered anyhow. All arrays the arena's. */
typedef struct tsi_draft {
  int n_functions;
  double *points;
  tsi_side side[6];
} tsi_draft;

/* The patches in canonical position: side by side, each t-major, with knots on [0,1]. A patch is a
 * NURBS patch until tsi_shell_refine_rows makes a T-spline of it, a T-spline, or Bezier elements.
 */
typedef struct tsi_shell {
  int n_strips[3];
  int first[7];         /* patches of side i: first[i] .. first[i+1]-1, (i, j) at i + n_s*j */
  tsi_patch *patch;     /* n[0] = 0: none */
  tsi_tspline *tspline; /* n = 0: none, or not yet */
  tsi_side *elements;   /* n_elements = 0: none; functions are rows of `control` */
  double *control;      /* homogeneous points of T-splines and elements, rows of 4 */
  int n_control, control_capacity;
  const tsi_place **place;
  const tsi_facet *facet; /* by number in the list of patches, */
  double (*domain)[4];    /* and their bounds in the input patches' own parameters */
  double *line[3];        /* n_strips + 1 values where strips begin and end */
  double (*moebius)[2];   /* per patch: its own x is now moebius x/(moebius x + 1 - x) */
} tsi_shell;

/* The patches of the input, or pieces of them: each is of one of three kinds (see tsi_shell); a
 * T-spline has its elements too. */
typedef struct tsi_patch_list {
  int n;
  tsi_patch *patch;
  tsi_tspline *tspline;
  tsi_side *elements;
  tsi_facet *facet;
  double (*domain)[4]; /* bounds of the input patch's own parameters */
} tsi_patch_list;

int tsi_patch_list_create(tsi_arena *arena, int n, tsi_patch_list *list); /* 0: no memory */
/* All of a facet that its geometry tells. */
void tsi_facet_measure(const tsi_patch *patch, const double origin[3], tsi_facet *facet);

/* Cuts patches along isolines, exactly, until no corner of one lies inside a border of another.
 * Notes tell which, refusals why not. */
tsolid_status tsi_split(tsolid_context *context, tsi_arena *arena,
                        const tsolid_boundary_input *input, double tolerance,
                        const double origin[3], tsi_patch_list *list,
                        tsolid_preparation *preparation);

/* Gives both sides of every seam one parameter by Moebius changes of patches; refuses seams whose
 * sides are apart at equal parameters for another reason. */
tsolid_status tsi_shell_match_parameters(tsolid_context *context, tsi_arena *arena,
                                         tsi_shell *shell, tsolid_preparation *preparation);
/* Multiplies patches by constants and bilinear functions where weights do not agree along all seams
 * up to one constant per patch; else does nothing. */
tsolid_status tsi_shell_multiply_weights(tsolid_context *context, tsi_arena *arena,
                                         tsi_shell *shell, tsolid_preparation *preparation);

/* Raises degrees until all patches of every belt share one, and makes knots that are nearly equal
 * there equal. */
tsolid_status tsi_shell_unify(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                              const tsolid_boundary_options *options,
                              tsolid_preparation *preparation);
/* Inserts what knots one side of a seam has and the other has not into the functions along it. All
 * patches but those of Bezier elements are T-splines then. */
tsolid_status tsi_shell_refine_rows(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                    tsolid_preparation *preparation);
/* Room for n more control points; the first one's row, or -1: no memory. */
int tsi_shell_add_points(tsi_arena *arena, tsi_shell *shell, int n);
/* Scales patches by constants until weights agree along all seams. */
tsolid_status tsi_shell_match_weights(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                      tsolid_preparation *preparation);
/* Makes the control rows of every seam one, bit for bit. */
tsolid_status tsi_shell_snap(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                             tsolid_preparation *preparation);
/* Number of the point x on the surface of the lattice n[0] x n[1] x n[2], and how many there are.
 */
size_t tsi_lattice_id(const size_t n[3], const size_t x[3]);
double tsi_lattice_count(const size_t n[3]);

/* T-spline and Bezier patches of the input in their own orientation: checked, with their elements.
 * The patch's form is its tspline (n > 0) or else its elements. */
tsolid_status tsi_form_read(tsolid_context *context, tsi_arena *arena,
                            const tsolid_boundary_input *input, int k, tsi_tspline *tspline,
                            tsi_side *elements);
/* Bounds of the patch's own parameter in direction d. */
void tsi_form_domain(const tsolid_patch *patch, int d, double domain[2]);

/* Joins the functions (tsi_join_functions) of the two sides of all seams that are not rows, where
 * their values on the seam and their control points agree, and refuses seams with other functions.
 * Needs the elements of all patches. */
tsolid_status tsi_shell_match_functions(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                        int *parent, tsolid_preparation *preparation);
/* Refuses seams that are not as smooth as the input says. */
tsolid_status tsi_shell_check_smooth(tsolid_context *context, tsi_arena *arena,
                                     const tsi_shell *shell, const tsolid_boundary_input *input,
                                     int *parent);
/* parent[i] of control point i: a forest; one function where the roots are one. */
int tsi_find_function(int *parent, int i);
void tsi_join_functions(int *parent, int a, int b);

/* Strip widths, then Bezier elements and functions. */
tsolid_status tsi_shell_draft(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                              const tsolid_boundary_input *input, tsolid_preparation *preparation,
                              tsi_draft *draft);

/* Checks six Bezier sides, finds the cube in them and moves them to their places. */
tsolid_status tsi_draft_from_bezier(tsolid_context *context, tsi_arena *arena,
                                    const tsolid_bezier_boundary *input, double tolerance,
                                    tsolid_requirement *requirement, tsi_draft *draft);

/* How findings call a side or a patch of Bezier elements. */
typedef struct tsi_side_label {
  tsolid_entity entity;
  int index;
  char text[TSI_NAME_SIZE];
} tsi_side_label;

/* Sizes, functions and coefficients, and that the elements tile the unit square. last_use: per
 * function, the number of the last element that names it; elements are numbered from first_element
 * > 0 on. */
tsolid_status tsi_side_check(tsolid_context *context, tsi_arena *arena, const tsi_side_label *label,
                             int n_functions, const tsi_side *side, int first_element,
                             int *last_use);
/* All functions are continuous from element to element. entry: zero for every function, before and
 * after. */
tsolid_status tsi_side_check_tears(tsolid_context *context, tsi_arena *arena,
                                   const tsi_side_label *label, const tsi_side *side, int *entry);
tsolid_status tsi_points_check(tsolid_context *context, int n, const double *points);

/* What the check of the cube needs to know of a side, or patch, of Bezier elements. */
tsolid_status tsi_side_measure(tsolid_context *context, const double *points, const tsi_side *side,
                               const double origin[3], tsi_facet *facet);
/* The side with its parameters reversed as flip says, then exchanged. */
tsolid_status tsi_side_move(tsolid_context *context, tsi_arena *arena, const tsi_side *from,
                            const tsi_place *place, tsi_side *to);

/* Every invariant of sides; see tsi_boundary_validate. Isolines only make sense in canonical
 * position. */
tsolid_status tsi_sides_check(tsolid_context *context, int n_functions, const double *points,
                              const tsi_side side[6], int with_isolines);

#endif
