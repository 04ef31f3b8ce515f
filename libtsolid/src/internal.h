/* SPDX-License-Identifier: LGPL-2.1-or-later
 * What the stages share: memory, errors, and the data that flows from one stage to the next. */
#ifndef TSI_INTERNAL_H
#define TSI_INTERNAL_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "tsolid.h"

enum { TSI_MAX_DEGREE = 25, TSI_MAX_ORDER = TSI_MAX_DEGREE + 1, TSI_INNER_DEGREE = 3 };

/* Limits on untrusted sizes: everything indexable by int with room to spare. */
enum { TSI_MAX_COUNT = 1 << 28 };

/* Of a name of the caller's, cut off where longer. */
enum { TSI_NAME_SIZE = 96 };

/* ---- memory ---------------------------------------------------------------------------------- */

typedef struct tsi_allocator {
  tsolid_allocate_fn allocate;
  tsolid_release_fn release;
  void *data;
} tsi_allocator;

/* n * size zeroed bytes (at least one), or NULL: out of memory or n * size overflows. */
void *tsi_new(const tsi_allocator *allocator, size_t n, size_t size);
void tsi_delete(const tsi_allocator *allocator, void *memory); /* NULL allowed */

/* Temporaries of a stage: many allocations, one release. */
typedef struct tsi_arena {
  const tsi_allocator *allocator;
  struct tsi_arena_block *last;
} tsi_arena;

tsi_arena tsi_arena_create(tsolid_context *context);
void *tsi_arena_new(tsi_arena *arena, size_t n, size_t size); /* zeroed, or NULL */
void tsi_arena_free(tsi_arena *arena);

/* ---- context ----------------------------------------------------------------------------------
 */

struct tsolid_context {
  tsi_allocator allocator;
  tsolid_progress_fn progress;
  void *progress_data;
  int n_threads; /* resolved: >= 1 */
  struct tsolid_finding *finding;
  int n_findings, finding_capacity;
};

/* Adds a finding of severity ERROR that explains `status`, with a printf text; returns `status`. */
#if defined(__GNUC__)
#define TSI_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define TSI_PRINTF(text, first)
#endif
tsolid_status tsi_fail(tsolid_context *context, tsolid_status status, const char *stage,
                       const char *format, ...) TSI_PRINTF(4, 5);
/* The same with a place; the fields of *finding but text are taken as they are (start from
 * tsi_finding()). Returns finding->status. */
tsolid_status tsi_report(tsolid_context *context, const tsolid_finding *finding, const char *format,
                         ...) TSI_PRINTF(3, 4);
tsolid_finding tsi_finding(tsolid_severity severity, tsolid_status status, const char *stage);
/* Forgets all findings but the first n. */
void tsi_findings_truncate(tsolid_context *context, int n);
tsolid_status tsi_no_memory(tsolid_context *context, const char *stage);

/* TSOLID_OK, or TSOLID_ERROR_CANCELLED (with its finding) when the callback asks to stop. */
tsolid_status tsi_progress(tsolid_context *context, const char *stage, double fraction);

/* ---- boundary ----------------------------------------------------------------------------------
 */

/* One side in canonical position, as Bezier elements (see tsolid_bezier_side). */
typedef struct tsi_side {
  int degree[2];
  int n_elements;
  double *box;
  int *function_start;
  int *function;
  double *coefficient;
  int grid[2]; /* patches along s and t; 1, 1 where not known */
} tsi_side;

struct tsolid_boundary {
  tsi_allocator allocator;
  int references;
  int n_functions;
  double *points; /* homogeneous, n_functions x 4 */
  tsi_side side[6];
  tsolid_requirement requirement;
  tsolid_preparation preparation;
  int n_patches;        /* of the input; 0: read from a file, or made of Bezier elements */
  int *placement_start; /* n_patches + 1 */
  tsolid_placement *placement;
  double scale;
};

void tsi_boundary_retain(const tsolid_boundary *boundary);
/* Allocates an empty boundary with room for n_functions and nothing else; NULL: no memory. */
tsolid_boundary *tsi_boundary_new(tsolid_context *context, int n_functions);
/* The larger of the bounding-box diagonal and the largest |coordinate| of the control points. */
double tsi_boundary_find_scale(const tsolid_boundary *boundary);
/* Deep, slow check of every invariant of canonical form (elements tile the side, functions >= 0
 * with sum 1 up to round-off or as given, ids in range, isolines agree, points finite, weights >
 * 0). */
tsolid_status tsi_boundary_validate(tsolid_context *context, const tsolid_boundary *boundary);

/* Axes (s, t) of a side, in increasing order. */
static inline int tsi_side_axis(int side) {
  return side >> 1;
}
static inline int tsi_side_s(int side) {
  return side >> 1 == 0 ? 1 : 0;
}
static inline int tsi_side_t(int side) {
  return side >> 1 == 2 ? 1 : 2;
}

/* ---- T-mesh -------------------------------------------------------------------------------------
 */

/* Planes of one axis, in index space, from low to high:
 *
 *   0   1   2     3    4    5     6 ...        n-7  n-6  n-5  n-4    n-3   n-2   n-1
 *   R   R-  r1    0''  0    0'    inner lines   .    1'   1    1''    r1    R-    R
 *
 * 4 and n-5 are the core surface, 3, 5, n-6, n-4 the zero-interval planes beside it; they and R-
 * exist only where a cell has a face on them. Core line m (0..n_lines-1) is plane 4 for m = 0,
 * 5 + m inside, n-5 for the last. */
enum { TSI_LOW_PLANE = 4, TSI_EXTRA_PLANES = 10 };

/* No closure: the functions need not sum to one. Zero-interval planes along all of the core
 * surface: the functions are C^0 across it. */
enum { TSI_TMESH_CLOSURE_OFF = 1, TSI_TMESH_SHARP_CORE = 2, TSI_TMESH_ALL_FLAGS = 3 };

struct tsolid_tmesh {
  tsi_allocator allocator;
  int references;
  int n_lines[3];  /* core lines per axis, both ends included */
  double *line[3]; /* their values, 0 = line[0] < ... < 1 */
  int n_boxes;     /* core cells before bands */
  int *box;        /* n_boxes x (lo[3], hi[3]) in core lines */
  int *box_level;  /* or NULL: see tsi_box_level */
  double arm_height[6];
  int n_planes[3];
  double *plane_value[3];
  int n_cells;
  int *cell; /* n_cells x (lo[3], hi[3]) in planes */
  int *cell_block;
  int n_nodes, n_partial_extraordinary, n_extraordinary;
  int n_closure_rounds, n_cells_before_closure;
  int flags; /* TSI_TMESH_... */
};

void tsi_tmesh_retain(const tsolid_tmesh *tmesh);
/* From lines and boxes (in core lines) and arm heights: bands, arms, cells, and the closure
 * unless a flag says no. Used by the octree, by callers' own boxes and by the reader. Checks that
 * the boxes tile the core. */
tsolid_status tsi_tmesh_from_boxes(tsolid_context *context, const int n_lines[3],
                                   const double *const line[3], int n_boxes, const int *box,
                                   const double arm_height[6], int flags, tsolid_tmesh **tmesh);

static inline int tsi_high_plane(const tsolid_tmesh *tmesh, int axis) {
  return tmesh->n_planes[axis] - 5;
}

/* ---- space --------------------------------------------------------------------------------------
 */

/* One product of three B-splines of degree 3: local knots as plane indices. */
typedef struct tsi_piece {
  int block; /* the arm it lives on, or -1: wherever its support reaches */
  int knot[3][5];
} tsi_piece;

typedef struct tsi_element {
  int block;
  int lateral; /* arms: index of its lateral cell; core: -1 */
  int degree[3];
  double box[6]; /* lo[3], hi[3] in cross coordinates */
  int radial[2]; /* arms: rows of the radial functions M_R- and M_R (row -1: zero) */
} tsi_element;

/* A lateral cell of an arm: a box inside one Bezier element of the side, with the surface functions
 * restricted to it, raised to the arm's lateral degrees. */
typedef struct tsi_lateral {
  int side;
  int degree[2]; /* max(3, the side's) */
  double box[4];
  int function_first, function_end; /* into lateral_function; coefficients: see lateral_offset */
  size_t coefficient_first;
} tsi_lateral;

struct tsolid_space {
  tsi_allocator allocator;
  int references;
  const tsolid_boundary *boundary;
  const tsolid_tmesh *tmesh;
  int n_inner, n_surface;

  int *piece_start; /* n_inner + 1 */
  tsi_piece *piece;

  int n_elements;
  tsi_element *element;
  int *element_degree; /* copies in the layout of the view */
  int *element_block;
  double *element_box;

  double *row; /* pool of rows of 4 Bernstein coefficients (cubic) */
  int n_rows;

  /* inner functions of element e: entries inner_start[e] .. inner_start[e+1]-1; function ascending
   */
  size_t *inner_start;
  int *inner_function;
  int (*inner_row)[3];

  int n_laterals;
  tsi_lateral *lateral;
  int *lateral_function;       /* ascending within a lateral cell */
  double *lateral_coefficient; /* per function (D_s+1)(D_t+1), s fastest */

  /* the transpose: for function f of 0..n_inner-1 the (element, entry) pairs that it appears in */
  size_t *use_start;
  int *use_element;
  size_t *use_entry;

  /* Bezier points of all elements: element e has bezier_start[e] .. bezier_start[e+1]-1 */
  size_t *bezier_start;

  /* per lateral degree in use: the matrix that raises cubics to it, (degree + 1) x 4 */
  double *raise[TSI_MAX_ORDER];

  struct tsi_bvh *locate; /* over element boxes, per block folded into one tree */
};

void tsi_space_retain(const tsolid_space *space);

struct tsolid_solid {
  tsi_allocator allocator;
  int references;
  const tsolid_space *space;
  double *control;          /* homogeneous, (n_inner + 2 n_surface) x 4: inner, R-, R */
  int constant_weight;      /* all weights are the same number: W is that constant */
  double start_worst;       /* worst scaled Jacobian of the start; NaN: not known */
  struct tsi_bvh *physical; /* over the elements' Euclidean control nets: tsi_solid_index */
};

/* Builds solid->physical (freed by tsolid_solid_free with tsi_bvh_free): every function that
 * creates a solid calls it last, once `control` is final. */
tsolid_status tsi_solid_index(tsolid_context *context, tsolid_solid *solid);

void tsi_solid_retain(const tsolid_solid *solid);

/* Homogeneous Bezier net of one element: n_components (<= 4) interleaved values per control point,
 * u[0] fastest, from `control` with rows of n_components for all functions. `net` has room for
 * (d0+1)(d1+1)(d2+1) rows. */
void tsi_element_net(const tsolid_space *space, const double *control, int n_components,
                     int element, double *net);

#endif
