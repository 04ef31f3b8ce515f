/* SPDX-License-Identifier: LGPL-2.1-or-later
 *
 * tsolid: from the spline boundary of a part to a conformal solid T-spline.
 *
 * This header is the reference manual; it stands in pipeline order:
 *
 *     patches -> boundary -> T-mesh -> space -> solid -> certificate -> report
 *
 * Numbering of the cube, used everywhere
 *
 *            6--------7        axis   0 = x, 1 = y, 2 = z of the parametric cube
 *           /|       /|        side   2*axis + end         (end 0: low, 1: high)
 *          4--------5 |        corner x + 2*y + 4*z        (bits)
 *          | |      | |        isoline 4*axis + b + 2*c    (b, c: ends on the two other axes,
 *    z     | 2------|-3                                     in increasing order)
 *    | y   |/       |/         block  0 = core, 1 + side = the arm over that side
 *    |/    0--------1
 *    +---x
 *
 * A side's parameters (s, t) in [0,1]^2 run along the two other axes in increasing order.
 *
 * Cross coordinates u[3]: the core is the unit cube [0,1]^3, the arm over side (axis a, high) is
 * the box 1 <= u[a] <= 1 + R, over (a, low) the box -R <= u[a] <= 0, the other two coordinates in
 * [0,1]. r = |distance of u[a] from the core|; r = R is the boundary of the solid. Two arms that
 * share an isoline are glued along the diagonal: (u[a] = 1 + rho R_a, u[b] = 1) is the same point
 * as (u[a] = 1, u[b] = 1 + rho R_b). det J > 0 in these coordinates in every block.
 *
 * Points are homogeneous (w x, w y, w z, w) where an array is said to be so, else Euclidean.
 * All indices are zero-based. Units are those of the input.
 *
 * Errors: every fallible function returns a status (0 = ok) and leaves findings in the context;
 * on failure outputs are NULL and inputs unchanged. Handles are immutable and reference counted;
 * a result may outlive its context. One context must not be used by two threads at once.
 */
#ifndef TSOLID_H
#define TSOLID_H

#include <stddef.h>

#if defined(TSOLID_BUILD) && defined(__GNUC__)
#define TSOLID_API __attribute__((visibility("default")))
#else
#define TSOLID_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- version ------------------------------------------------------------------------------- */

#define TSOLID_VERSION "0.1.0"
#define TSOLID_ABI 1

/* The version string and ABI number that the library was built with. */
TSOLID_API const char *tsolid_version(void);
TSOLID_API int tsolid_abi(void);

/* sizeof of the public struct `name` ("tsolid_patch", ...) in the library; 0 for an unknown name.
 * A binding compares it with its own mirror before the first call. */
TSOLID_API size_t tsolid_struct_size(const char *name);

/* ---- status and findings ------------------------------------------------------------------- */

typedef enum tsolid_status {
  TSOLID_OK = 0,
  TSOLID_ERROR_MEMORY,    /* an allocation failed */
  TSOLID_ERROR_ARGUMENT,  /* the caller broke this header's contract */
  TSOLID_ERROR_INPUT,     /* malformed data: NaN, bad knots, truncated or alien file */
  TSOLID_ERROR_REFUSED,   /* well-formed, but outside the class of parts taken; findings say why */
  TSOLID_ERROR_IO,        /* the operating system refused a file operation */
  TSOLID_ERROR_CANCELLED, /* the progress callback asked to stop */
  TSOLID_ERROR_NUMERIC,   /* a solver did not reach its goal */
  TSOLID_ERROR_INTERNAL   /* an invariant of the library broke: a defect, please report */
} tsolid_status;

typedef enum tsolid_severity { TSOLID_NOTE = 0, TSOLID_WARNING, TSOLID_ERROR } tsolid_severity;

/* What a finding is about; index[0], index[1] mean: */
typedef enum tsolid_entity {
  TSOLID_ENTITY_NONE = 0,
  TSOLID_ENTITY_PATCH,   /* input patch */
  TSOLID_ENTITY_BORDER,  /* input patch, border 0..3 (v low, u high, v high, u low) */
  TSOLID_ENTITY_VERTEX,  /* input patch, corner 0..3 ((u,v) = 00, 10, 11, 01) */
  TSOLID_ENTITY_SIDE,    /* side of the cube */
  TSOLID_ENTITY_ISOLINE, /* isoline of the cube */
  TSOLID_ENTITY_CORNER,  /* corner of the cube */
  TSOLID_ENTITY_ELEMENT, /* Bezier element */
  TSOLID_ENTITY_FUNCTION,
  TSOLID_ENTITY_LINE,          /* line of a text file (1-based) */
  TSOLID_ENTITY_SURFACE_VERTEX /* vertex of a T-spline surface: its number in the file */
} tsolid_entity;

typedef struct tsolid_finding {
  tsolid_severity severity;
  tsolid_status status; /* the status this finding explains; TSOLID_OK for notes and warnings */
  tsolid_entity entity;
  int index[2];
  int has_point;
  double point[3];
  double measured, allowed; /* NaN where the finding has no such number */
  const char *stage;        /* "read", "boundary", "tmesh", "space", "solid", "certify", ... */
  const char *text;         /* one sentence, without a full stop's worth of jargon */
} tsolid_finding;

/* ---- context ------------------------------------------------------------------------------- */

typedef struct tsolid_context tsolid_context;

/* Returns memory for `size` > 0 bytes aligned for any type, or NULL. */
typedef void *(*tsolid_allocate_fn)(void *data, size_t size);
typedef void (*tsolid_release_fn)(void *data, void *memory);

/* Called on the calling thread only. fraction in [0,1] of the stage. Return nonzero to cancel. */
typedef int (*tsolid_progress_fn)(void *data, const char *stage, double fraction);

typedef struct tsolid_context_options { /* all zero = default */
  tsolid_allocate_fn allocate;          /* both or none; must live as long as any result */
  tsolid_release_fn release;
  void *allocator_data;
  tsolid_progress_fn progress;
  void *progress_data;
  int n_threads; /* 0 = all processors; results do not depend on it, not in one bit */
} tsolid_context_options;

/* options may be NULL. *context must be freed with tsolid_context_free (NULL is allowed there). */
TSOLID_API tsolid_status tsolid_context_create(const tsolid_context_options *options,
                                               tsolid_context **context);
TSOLID_API void tsolid_context_free(tsolid_context *context);

/* Findings of all calls since creation or the last clear; strings live until then. */
TSOLID_API int tsolid_context_n_findings(const tsolid_context *context);
TSOLID_API const tsolid_finding *tsolid_context_finding(const tsolid_context *context, int i);
TSOLID_API void tsolid_context_clear(tsolid_context *context);

/* Frees a string or array that a function of this header says is to be freed so. */
TSOLID_API void tsolid_release(tsolid_context *context, void *memory);

/* ---- T-spline surfaces -------------------------------------------------------------------------
 */

/* A bicubic T-spline surface as .tsm holds it (or Bezier elements as .iga does), open or closed.
 * Which surface results round vertices where not four edges meet: see surface_basis.c. The control
 * points of .tsm are taken as Euclidean with a weight (nobody has documented it otherwise; files
 * with other weights than 1 are not known to us). */
typedef struct tsolid_surface tsolid_surface;

/* Face f has Bezier elements element_start[f] .. element_start[f+1]-1; element e is the box
 * box[4e..4e+3] = (u0, u1, v0, v1) of the face's (u,v), which run from 0 to face_size[2f], [2f+1]
 * in knot units; its functions are given as in tsolid_bezier_side, `degree` in both directions. */
typedef struct tsolid_surface_view {
  int n_faces, n_edges, n_vertices, n_points;
  int n_t_junctions;
  int n_boundary_loops; /* 0: closed */
  int n_boundary_edges;
  int n_parts; /* connected components */
  int n_extraordinary;
  const int *extraordinary; /* interior vertices, numbered as in the file */
  const int *valence;       /* their edges */
  double sum_defect;    /* largest |sum of the functions - 1|: 0 up to round-off on a T-mesh that
                           is analysis-suitable */
  const double *points; /* homogeneous, n_points rows of 4 */
  const double *face_size;
  const int *element_start;
  int degree, n_elements;
  const double *box;
  const int *function_start;
  const int *function;
  const double *coefficient;
} tsolid_surface_view;

/* TSOLID_ERROR_INPUT for malformed files, with the line and the record. */
TSOLID_API tsolid_status tsolid_read_tsm(tsolid_context *context, const char *path,
                                         tsolid_surface **surface);
/* Reads back as the same surface, bit for bit, comments excepted. TSOLID_ERROR_REFUSED for a
 * surface that did not come from .tsm. */
TSOLID_API tsolid_status tsolid_write_tsm(tsolid_context *context, const tsolid_surface *surface,
                                          const char *path);
/* Bezier elements as they are, all raised to the highest degree among them. The format has neither
 * neighbours nor knot intervals: elements are glued where all functions agree, the ratios of
 * intervals come from functions that are C^1 across an edge, and where there are none the smallest
 * is 1 (notes tell). Faces are numbered as the file's elements. TSOLID_ERROR_REFUSED for volumes.
 */
TSOLID_API tsolid_status tsolid_read_iga(tsolid_context *context, const char *path,
                                         tsolid_surface **surface);
TSOLID_API void tsolid_surface_free(tsolid_surface *surface);
TSOLID_API void tsolid_surface_get(const tsolid_surface *surface, tsolid_surface_view *view);
/* Point and derivatives of a face: rows of 3: x (order 0); x, x_u, x_v (order 1). */
TSOLID_API tsolid_status tsolid_surface_evaluate(tsolid_context *context,
                                                 const tsolid_surface *surface, int face, double u,
                                                 double v, int order, double *out);

/* A boundary as read from .tsb, or patches of a surface: `input` points into the handle. */
typedef struct tsolid_boundary_file tsolid_boundary_file;

/* The surface as exact B-spline patches, as few as rectangles of faces allow; no patch is less than
 * C^1 inside. TSOLID_OK for open surfaces, too. */
TSOLID_API tsolid_status tsolid_surface_patches(tsolid_context *context,
                                                const tsolid_surface *surface,
                                                tsolid_boundary_file **patches);

/* ---- the input boundary --------------------------------------------------------------------- */

/* A side or patch given as Bezier elements, blind to the spline technology behind it. Element e is
 * the box [box[4e], box[4e+1]] x [box[4e+2], box[4e+3]] of (s,t); its functions are function[k],
 * k = function_start[e] .. function_start[e+1]-1, each with (degree[0]+1)*(degree[1]+1) Bernstein
 * coefficients, s fastest, at coefficient[k*(degree[0]+1)*(degree[1]+1)]. The boxes tile the unit
 * square. */
typedef struct tsolid_bezier_side {
  int degree[2];
  int n_elements;
  const double *box;
  const int *function_start;
  const int *function;
  const double *coefficient;
} tsolid_bezier_side;

/* A T-spline patch: function k is N_k(u) M_k(v), B-splines with the local knots
 * knots[d][k*(degree[d]+2)] .. knots[d][k*(degree[d]+2) + degree[d]+1], on domain[0] <= u <=
 * domain[1], domain[2] <= v <= domain[3], which knots may lie outside of. Its control point is row
 * point[k] of the input's points. The surface is sum P_k N_k M_k in homogeneous points: the sum of
 * the functions need not be one. */
typedef struct tsolid_tspline {
  int degree[2];
  int n_functions;
  const int *point;
  const double *knots[2];
  double domain[4];
} tsolid_tspline;

/* A patch, in one of three forms. As a NURBS surface
 *   S(u,v) = sum_ij w_ij P_ij N_i(u) M_j(v) / sum_ij w_ij N_i(u) M_j(v),
 * clamped at both ends of both directions; control point (i, j) is row i + n_control[0]*j. As a
 * T-spline, or as Bezier elements: their functions are rows of the input's points, and the same row
 * in two patches is one function that lives on both; all from `degree` to `weights` is unused. */
typedef struct tsolid_patch {
  int degree[2];                    /* 1..25 */
  int n_control[2];                 /* >= degree + 1 */
  const double *knots[2];           /* n_control + degree + 1 each, non-decreasing */
  const double *points;             /* Euclidean, n_control[0]*n_control[1] rows of 3 */
  const double *weights;            /* positive, or NULL for all one */
  const char *name;                 /* how findings call it ("Face3"); NULL: "patch k" */
  const char *border_name[4];       /* v low, u high, v high, u low ("Edge7"); NULL allowed */
  const char *corner_name[4];       /* (u,v) = 00, 10, 11, 01 ("Vertex2"); NULL allowed */
  double border_tolerance[4];       /* B-rep tolerance of each border; 0: the option's */
  const tsolid_tspline *tspline;    /* NULL: not this form */
  const tsolid_bezier_side *bezier; /* the same */
  int fixed; /* not 0: where borders are snapped together, this patch's control points stand: it is
                shared with another part (see tsolid_assembly_boundary_input) */
} tsolid_patch;

/* Border border[0] of patch[0] and border[1] of patch[1], where the surface is meant to be smooth:
 * all functions agree across it up to derivatives of this order in the patches' own parameters.
 * Verified, and refused where it does not hold; it changes nothing. */
typedef struct tsolid_smooth_seam {
  int patch[2], border[2];
  int order; /* >= 1 */
} tsolid_smooth_seam;

typedef struct tsolid_bezier_boundary {
  int n_functions;
  const double *points; /* homogeneous control points, n_functions rows of 4 */
  tsolid_bezier_side side[6];
} tsolid_bezier_boundary;

typedef struct tsolid_boundary_input { /* one of the three */
  int n_patches;
  const tsolid_patch *patches;
  const tsolid_bezier_boundary *bezier;
  const tsolid_surface *surface; /* closed; is cut into six sides along isolines */
  int n_points;                  /* of T-spline and Bezier patches */
  const double *points;          /* homogeneous, rows of 4 */
  int n_smooth;
  const tsolid_smooth_seam *smooth;
} tsolid_boundary_input;

typedef struct tsolid_boundary_options { /* all zero = default */
  double tolerance;                      /* B-rep tolerance, absolute; 0: 1e-7 */
  int refine_knots;      /* halve every knot span of the sides so often (exact), 0..6 */
  int raise_degree;      /* raise every side's degree by so much (exact) */
  int n_corners;         /* 8, or 0: */
  const double *corners; /* the vertices that must be the cube's corners, rows of 3, in any order:
                            TSOLID_ERROR_REFUSED where another vertex is one. Patches only */
} tsolid_boundary_options;

/* The requirement of Zhang, Wang, Hughes (2012), section 2, checked. Filled as far as the check
 * got, also when it fails; each violation is a finding in the context. */
typedef struct tsolid_requirement {
  int satisfied;
  int closed, connected, genus;       /* genus -1: not known */
  int n_patches, n_vertices, n_edges; /* of the complex of patches, or pieces of cut ones */
  int n_extraordinary;                /* vertices of a valence other than 4 */
  int n_violations;
  double corner[8][3];     /* in the canonical numbering, when satisfied */
  int side_grid[6][2];     /* patches along (s, t) of each side, when satisfied */
  char corner_name[8][64]; /* the least by bytes of the names that patches have for the corner,
                              cut off after a whole UTF-8 character; "": none. Not in .tsolid */
} tsolid_requirement;

/* What was changed, exactly or within the tolerance, before the construction. */
typedef struct tsolid_preparation {
  double snap[12];         /* largest distance a control point of the isoline was moved */
  double snap_inside[6];   /* the same for patch borders inside a side */
  double weight_factor[6]; /* of all factors that weights of the side's patches were
                              multiplied by, the corners of bilinear ones included, the one
                              farthest from 1 as a ratio; 1: none, or Moebius changes only */
  double knot_merge;       /* largest change of a knot, relative to its range */
  int n_knots_inserted;    /* into rows of functions along seams, and knot lines across patches */
  int n_degrees_raised;    /* patch directions whose degree was raised */
  int refine_knots, raise_degree; /* asked for by options */
  int n_bilinear_factors; /* patches multiplied by a positive bilinear function of (u,v), which
                             raises degrees by one and changes neither surface nor parameters */
  int n_moebius;          /* patch directions whose parameter t became c t/(c t + 1 - t), which
                             changes knots and weights but not the surface; the parameter that
                             most patches around the part share stands, the others are changed */
  int n_cut_patches;  /* input patches that were cut along isolines, exactly, because a corner of
                         another lay inside a border of theirs (T-vertex), or a cut ended there */
  int n_cuts;         /* those isolines, counted by patch. The surface is unchanged; functions
                         are C^0 across a cut through a NURBS patch */
  int n_knots_merged; /* knots that were changed by up to knot_merge */
} tsolid_preparation;

/* Where a piece of input patch k lies, the part `domain` = (u0, u1, v0, v1) of the patch's own
 * parameters: (s,t) of side = affine or projective image of (u,v).
 * p = (u - domain[0])/(domain[1]-domain[0]), q likewise with domain[2..3]; then, where moebius is
 * not 1, p = moebius[0] p / (moebius[0] p + (1 - p)), q likewise; flip[0]: p = 1-p, flip[1]: q =
 * 1-q; swap: exchange p and q *after* flipping; s = box[0] + p (box[1]-box[0]), t = box[2] + q
 * (box[3]-box[2]). */
typedef struct tsolid_placement {
  int side;
  int swap, flip[2];
  double box[4];
  double domain[4];
  double moebius[2]; /* 1: affine */
} tsolid_placement;

typedef struct tsolid_boundary tsolid_boundary;

/* Orients, places, checks and prepares (DESIGN: the input boundary). requirement may be NULL.
 * TSOLID_ERROR_INPUT for malformed patches, TSOLID_ERROR_REFUSED when the requirement does not
 * hold, or when a side folds over itself: where its two tangents are parallel inside it no solid is
 * valid (the singular corners that the certificate names are no such places). */
TSOLID_API tsolid_status tsolid_boundary_create(tsolid_context *context,
                                                const tsolid_boundary_input *input,
                                                const tsolid_boundary_options *options,
                                                tsolid_requirement *requirement,
                                                tsolid_boundary **boundary);
TSOLID_API void tsolid_boundary_free(tsolid_boundary *boundary);

/* A view of the boundary in canonical position, valid as long as the handle. */
TSOLID_API void tsolid_boundary_view(const tsolid_boundary *boundary, tsolid_bezier_boundary *view);
TSOLID_API void tsolid_boundary_requirement(const tsolid_boundary *boundary,
                                            tsolid_requirement *requirement);
TSOLID_API void tsolid_boundary_preparation(const tsolid_boundary *boundary,
                                            tsolid_preparation *preparation);
/* Pieces of input patch k: 1 unless it was cut, then the cells of a grid, along u first. 0 when the
 * boundary was not made of patches in this process (the file formats keep no input numbering:
 * results do not depend on it). */
TSOLID_API int tsolid_boundary_n_placements(const tsolid_boundary *boundary, int k);
/* Placement of piece i of input patch k; TSOLID_ERROR_ARGUMENT when there is none. */
TSOLID_API tsolid_status tsolid_boundary_placement(const tsolid_boundary *boundary, int k, int i,
                                                   tsolid_placement *placement);
/* The larger of the bounding-box diagonal and the largest |coordinate| of the control points. */
TSOLID_API double tsolid_boundary_scale(const tsolid_boundary *boundary);

/* ---- planar faces --------------------------------------------------------------------------- */

/* A clamped NURBS curve: sum w_i P_i N_i(t) / sum w_i N_i(t). */
typedef struct tsolid_curve {
  int degree;            /* 1..25 */
  int n_control;         /* >= degree + 1 */
  const double *knots;   /* n_control + degree + 1, non-decreasing */
  const double *points;  /* Euclidean, rows of 3 */
  const double *weights; /* positive, or NULL for all one */
  const char *name;      /* how findings call it ("Edge7"); NULL: "border v low" */
} tsolid_curve;

typedef enum tsolid_coons_repair {
  TSOLID_REPAIR_AUTOMATIC = 0, /* when the plain patch folds, or is much worse than its borders */
  TSOLID_REPAIR_NEVER,
  TSOLID_REPAIR_ALWAYS
} tsolid_coons_repair;

typedef struct tsolid_coons_options { /* all zero = default */
  double tolerance;                   /* of corners and plane, absolute; 0: 1e-7 */
  double normal[3];                   /* of the plane, of either sign; all zero: fitted */
  const char *name;                   /* how findings call the face ("Face3"); NULL: "the face" */
  const char *corner_name[4];         /* (u,v) = 00, 10, 11, 01 ("Vertex2"); NULL allowed */
  int repair;                         /* tsolid_coons_repair */
} tsolid_coons_options;

/* Filled as far as the work got, also when it fails. */
typedef struct tsolid_coons_report {
  double origin[3], normal[3]; /* the plane; the unit normal is that of u x v */
  double plane_distance;       /* of the borders' control points from the plane, the largest */
  double corner_gap;           /* largest distance of two borders at their common corner */
  double knot_merge;           /* largest change of a knot, relative to its range */
  double weight_factor[4];     /* that the weights of each border were multiplied by */
  int linear_border;           /* the border multiplied by a linear function as well; -1: none */
  double linear_factor[2];     /* its values at both ends */
  int n_degrees_raised;        /* of borders, so that opposite ones agree */
  int n_knots_inserted;        /* into borders, for the same reason */
  int weights_replaced;        /* 1: Coons weights inside would not have been positive enough */
  int repaired;                /* 1: control points inside were moved from where Coons has them */
  int n_inside_degrees;        /* degrees raised, and knot lines inserted, for the repair */
  int n_inside_knots;
  double start_worst, worst; /* sampled scaled Jacobian without and with the repair, singular
                                corners left out; NaN: not known */
  double bound;              /* no patch with these borders has a better worst scaled Jacobian */
  double worst_point[3];
  double area; /* enclosed by the borders */
  int n_elements, depth;
  int n_singular; /* corners where the borders are tangent, so that det J = 0 */
  double singular[4][3];
} tsolid_coons_report;

/* A planar patch over four border curves in the order v low, u high, v high, u low, each running in
 * the direction of u or v: their bilinearly blended Coons patch in homogeneous coordinates,
 *
 *     X(u,v) = (1-v) X_0(u) + v X_2(u) + (1-u) X_3(v) + u X_1(v) - bilinear(corners),
 *
 * or, where that folds, the same borders with other control points inside the plane. Its borders
 * are the given curves: the very control points where degree and knots of opposite ones agree, else
 * raised and refined to what both have. Weights are multiplied by constants, so that they agree at
 * the corners. It is proved one-to-one: det J > 0 but at singular corners, and a border that does
 * not meet itself. */
typedef struct tsolid_coons tsolid_coons;

/* report may be NULL. TSOLID_ERROR_INPUT for malformed curves; TSOLID_ERROR_REFUSED when the
 * borders do not meet, lie in no plane, cross, leave no room at a corner, or when no patch was
 * found that could be proved not to fold. */
TSOLID_API tsolid_status tsolid_coons_create(tsolid_context *context, const tsolid_curve border[4],
                                             const tsolid_coons_options *options,
                                             tsolid_coons_report *report, tsolid_coons **coons);
TSOLID_API void tsolid_coons_free(tsolid_coons *coons);
/* The patch, with the names it was given, as an input of tsolid_boundary_create; valid as long as
 * the handle. */
TSOLID_API void tsolid_coons_get(const tsolid_coons *coons, tsolid_patch *patch);

/* ---- T-mesh ---------------------------------------------------------------------------------- */

typedef struct tsolid_tmesh tsolid_tmesh;

typedef struct tsolid_tmesh_options { /* all zero = default */
  int min_cells;                      /* at least so many core cells per axis; 0: 3 */
  int isotropic; /* 1: every split of the octree halves all three axes, as in the paper; 0: levels
                    and balance per axis */
  int analysis_suitable_off; /* 1: no closure. The functions then need not sum to one: the solid is
                                their rational combination, which normalises them; the defect before
                                that is in the report */
  int sharp_core; /* 1: the functions are C^0 across all of the core surface, so that they can
                     follow a map with a crease there; 0: C^2 away from the core's edges */
} tsolid_tmesh_options;

typedef struct tsolid_tmesh_view {
  int n_planes[3]; /* index planes per axis, zero-interval ones included */
  const double *plane_value[3];
  int core_plane[3][2]; /* plane index of the core's low and high surface */
  int n_cells;
  const int *cell; /* n_cells rows of lo[3], hi[3] plane indices */
  const int *cell_block;
  double arm_height[6]; /* R of each arm */
  int n_nodes, n_partial_extraordinary, n_extraordinary;
} tsolid_tmesh_view;

TSOLID_API tsolid_status tsolid_tmesh_create(tsolid_context *context,
                                             const tsolid_boundary *boundary,
                                             const tsolid_tmesh_options *options,
                                             tsolid_tmesh **tmesh);
TSOLID_API void tsolid_tmesh_free(tsolid_tmesh *tmesh);
TSOLID_API void tsolid_tmesh_get(const tsolid_tmesh *tmesh, tsolid_tmesh_view *view);

/* ---- the space: blending functions and their Bezier extraction --------------------------------
 */

/* Functions are numbered: inner functions first, then the layer R- (one per surface function), then
 * the boundary layer R (one per surface function, in the boundary's numbering; never moved). */
typedef struct tsolid_space tsolid_space;

typedef struct tsolid_space_view {
  int n_functions, n_inner, n_surface; /* n_functions = n_inner + 2 n_surface */
  int n_elements;
  const int *element_block;
  const int *element_degree; /* n_elements rows of 3 */
  const double *element_box; /* n_elements rows of lo[3], hi[3] in cross coordinates */
} tsolid_space_view;

/* Keeps references to boundary and tmesh. */
TSOLID_API tsolid_status tsolid_space_create(tsolid_context *context,
                                             const tsolid_boundary *boundary,
                                             const tsolid_tmesh *tmesh, tsolid_space **space);
TSOLID_API void tsolid_space_free(tsolid_space *space);
TSOLID_API void tsolid_space_get(const tsolid_space *space, tsolid_space_view *view);
TSOLID_API const tsolid_boundary *tsolid_space_boundary(const tsolid_space *space);
TSOLID_API const tsolid_tmesh *tsolid_space_tmesh(const tsolid_space *space);

/* The functions that are not zero on an element, and their Bernstein coefficients.
 * *n receives their number; function: *n ids; coefficient: *n rows of
 * (d0+1)(d1+1)(d2+1), u[0] fastest. Either array may be NULL; capacity in functions. */
TSOLID_API tsolid_status tsolid_space_extraction(tsolid_context *context, const tsolid_space *space,
                                                 int element, int capacity, int *n, int *function,
                                                 double *coefficient);

/* ---- the solid --------------------------------------------------------------------------------
 */

typedef struct tsolid_solid tsolid_solid;

typedef struct tsolid_solid_options { /* all zero = default */
  int effort;                         /* 0: default, 1: the start only, 2: quick, 3: thorough */
} tsolid_solid_options;

/* Positive inner weights and a smooth start: the cross is laid into a cube, the cube into the part
 * by the transfinite (Coons) map of the six sides. */
TSOLID_API tsolid_status tsolid_solid_create(tsolid_context *context, const tsolid_space *space,
                                             tsolid_solid **solid);
/* Untangles and improves; boundary control points and all weights stay bit for bit. */
TSOLID_API tsolid_status tsolid_solid_optimise(tsolid_context *context, const tsolid_solid *start,
                                               const tsolid_solid_options *options,
                                               tsolid_solid **solid);
/* A solid with given homogeneous control points, n_functions rows of 4; the boundary layer must be
 * the boundary's own, bit for bit (TSOLID_ERROR_INPUT else). */
TSOLID_API tsolid_status tsolid_solid_from_control(tsolid_context *context,
                                                   const tsolid_space *space, const double *control,
                                                   tsolid_solid **solid);
TSOLID_API void tsolid_solid_free(tsolid_solid *solid);
TSOLID_API const tsolid_space *tsolid_solid_space(const tsolid_solid *solid);
/* Homogeneous control points, n_functions rows of 4. */
TSOLID_API const double *tsolid_solid_control(const tsolid_solid *solid);

/* Homogeneous Bezier control points of an element: (d0+1)(d1+1)(d2+1) rows of 4, u[0] fastest. */
TSOLID_API tsolid_status tsolid_solid_bezier(tsolid_context *context, const tsolid_solid *solid,
                                             int element, double *points);

/* Value and derivatives at cross coordinates u in a block. order 0, 1 or 2; out: rows of 3:
 * x; x_0, x_1, x_2; x_00, x_11, x_22, x_12, x_02, x_01 (1, 4 or 10 rows). On an element border the
 * element with the larger coordinates is taken, except at the block's upper ends. */
TSOLID_API tsolid_status tsolid_solid_evaluate(tsolid_context *context, const tsolid_solid *solid,
                                               int block, const double u[3], int order,
                                               double *out);
/* The cross coordinates of a boundary point: returns the block (1 + side) and u. */
TSOLID_API int tsolid_solid_boundary_point(const tsolid_solid *solid, int side, double s, double t,
                                           double u[3]);
/* Point inversion: the block and u with |x(u) - point| <= tolerance (0: 1e-10 * scale).
 * *found = 0 when the point lies outside; *distance is the distance that remains. */
TSOLID_API tsolid_status tsolid_solid_invert(tsolid_context *context, const tsolid_solid *solid,
                                             const double point[3], double tolerance, int *found,
                                             int *block, double u[3], double *distance);

/* ---- certificate -------------------------------------------------------------------------------
 */

typedef enum tsolid_verdict {
  TSOLID_POSITIVE = 0, /* proved: det J > 0 on the whole element */
  TSOLID_NOT_POSITIVE, /* disproved: a point is given */
  TSOLID_UNDECIDED     /* neither, at the depth limit */
} tsolid_verdict;

typedef struct tsolid_certificate_options { /* all zero = default */
  int max_depth;                            /* bisections per element, 0: 24 */
} tsolid_certificate_options;

typedef struct tsolid_certificate {
  tsolid_verdict verdict; /* of the whole: the worst of the elements */
  int n_elements, n_positive, n_not_positive, n_undecided;
  int n_singular; /* corners where the input itself has det J = 0, named in findings */
  double singular[8][3];
  int depth;             /* deepest subdivision used */
  int element;           /* the element that decided a verdict other than positive, else -1 */
  double u[3], point[3]; /* a place in it; where det J <= 0 if not positive */
  double smallest_bound; /* smallest proved lower bound of det J / (product of mean edge lengths) */
} tsolid_certificate;

/* The numerator det[X, X_0, X_1, X_2] of det J in Bernstein form, subdivided until every
 * coefficient is above its own round-off bound. Sound: never positive where an exact evaluation is
 * not. element_verdict (n_elements entries) may be NULL. */
TSOLID_API tsolid_status tsolid_certify(tsolid_context *context, const tsolid_solid *solid,
                                        const tsolid_certificate_options *options,
                                        tsolid_certificate *certificate, int *element_verdict);

/* The same for one rational Bezier element: degree[3], homogeneous points, u[0] fastest. */
TSOLID_API tsolid_status tsolid_certify_element(tsolid_context *context, const int degree[3],
                                                const double *points,
                                                const tsolid_certificate_options *options,
                                                tsolid_certificate *certificate);

/* ---- quality -----------------------------------------------------------------------------------
 */

/* Scaled Jacobian det J / (|J_0| |J_1| |J_2|) at Gauss points, corners and a 7^3 grid per element.
 */
typedef struct tsolid_quality {
  double worst, mean, best;
  int worst_element;
  double worst_u[3], worst_point[3];
  double start_worst; /* of the start; NaN when not known */
  double bound;       /* no solid over this boundary has a better worst scaled Jacobian */
  double bound_point[3];
  double ratio; /* worst / bound */
} tsolid_quality;

TSOLID_API tsolid_status tsolid_quality_measure(tsolid_context *context, const tsolid_solid *solid,
                                                tsolid_quality *quality);

/* ---- the conformity report ---------------------------------------------------------------------
 */

typedef struct tsolid_basis_report {
  double sum_defect;       /* largest |sum of all functions - 1|, before normalisation */
  double input_sum_defect; /* the same of the input's own functions on the boundary: what even an
                              analysis-suitable T-mesh cannot make good */
  double smallest_value;   /* smallest Bernstein coefficient of a function: >= 0 */
  int rank_measured;       /* 0: skipped, too large (see max_rank_functions) */
  double
      inner_eigenvalue; /* smallest of the diagonally scaled mass matrix of the inner functions */
  double surface_eigenvalue;               /* the same for the surface functions on the boundary */
  double inner_roundoff, surface_roundoff; /* 100 n eps */
  double diagonal_jump; /* largest jump of any function across the 12 diagonals */
  double core_jump;     /* ... and across the 6 core faces */
} tsolid_basis_report;

typedef struct tsolid_continuity_report {
  double area[4];        /* interior element faces with measured order C^-1, C^0, C^1, >= C^2, in
                            physical area */
  int n_faces;           /* interior faces measured */
  int n_below_expected;  /* faces smoother in theory than in measurement: must be 0 */
  double largest_excess; /* largest jump, relative to its allowance, among orders that must match */
} tsolid_continuity_report;

typedef struct tsolid_conformity_report {
  int n_samples;
  double distance; /* largest distance of boundary and solid at equal parameters, two evaluators */
  double scale;
  int control_identical; /* boundary layer of the solid == prepared boundary, bit for bit */
  double volume;         /* quadrature of det J over the elements */
  double flux;           /* surface flux integral over the boundary's Bezier elements */
} tsolid_conformity_report;

typedef struct tsolid_statistics { /* table 1 of Zhang, Wang, Hughes (2012) */
  int input_nodes, input_elements;
  int tmesh_nodes, interior_extraordinary_nodes, partial_extraordinary_nodes;
  int core_cells, n_functions, n_inner, bezier_elements;
  int core_cells_of_level[24]; /* level: how often the core was split for a cell, along the
                                  axis with most splits */
  int analysis_suitable;       /* 1: the T-mesh was closed */
  int tmesh_cells, tmesh_cells_before_closure; /* zero-interval ones included */
} tsolid_statistics;

typedef struct tsolid_timing { /* seconds; NaN: not run */
  double boundary, tmesh, space, start, optimise, certify, report, total;
  double peak_memory_mib;
} tsolid_timing;

typedef struct tsolid_report {
  tsolid_requirement requirement;
  tsolid_preparation preparation;
  tsolid_statistics statistics;
  tsolid_conformity_report conformity;
  tsolid_basis_report basis;
  tsolid_continuity_report continuity;
  tsolid_certificate certificate;
  tsolid_quality quality;
  tsolid_timing timing;
} tsolid_report;

typedef struct tsolid_report_options { /* all zero = default */
  int max_rank_functions; /* measure ranks up to so many functions; 0: 20000, -1: never */
} tsolid_report_options;

/* Measures everything anew from the solid alone (times: only its own). */
TSOLID_API tsolid_status tsolid_report_measure(tsolid_context *context, const tsolid_solid *solid,
                                               const tsolid_report_options *options,
                                               tsolid_report *report);
/* The report, and the context's findings, as one JSON document (resources/report.schema.json), to
 * be freed by tsolid_release. */
TSOLID_API tsolid_status tsolid_report_json(tsolid_context *context, const tsolid_report *report,
                                            char **json);
/* ---- files --------------------------------------------------------------------------------------
 */

TSOLID_API tsolid_status tsolid_read_tsb(tsolid_context *context, const char *path,
                                         tsolid_boundary_file **file);
TSOLID_API const tsolid_boundary_input *
tsolid_boundary_file_input(const tsolid_boundary_file *file);
TSOLID_API void tsolid_boundary_file_free(tsolid_boundary_file *file);
TSOLID_API tsolid_status tsolid_write_tsb(tsolid_context *context,
                                          const tsolid_boundary_input *input, const char *path);

/* The result, loss-free; reads back bit-identical. Written beside `path`, then renamed. */
TSOLID_API tsolid_status tsolid_write_tsolid(tsolid_context *context, const tsolid_solid *solid,
                                             const char *path);
TSOLID_API tsolid_status tsolid_read_tsolid(tsolid_context *context, const char *path,
                                            tsolid_solid **solid);
/* A picture of the T-mesh in parametric space: the core's cells by level from outside, the whole
 * with an octant cut out, the section at half height; T-junctions as dots. */
TSOLID_API tsolid_status tsolid_write_svg(tsolid_context *context, const tsolid_space *space,
                                          const char *path);
/* Rational Bezier hexahedra (VTK cell 79) with the scaled Jacobian per element. */
TSOLID_API tsolid_status tsolid_write_vtu(tsolid_context *context, const tsolid_solid *solid,
                                          const char *path);

#ifdef __cplusplus
}
#endif

#include "tsolid_assembly.h"

#include "tsolid_analysis.h"
#endif
