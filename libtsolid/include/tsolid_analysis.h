/* SPDX-License-Identifier: LGPL-2.1-or-later
 *
 * tsolid.h, continued: what is handed on to analysis: hexahedra, extraction, matrices, fields.
 * Included by tsolid.h.
 */
#ifndef TSOLID_ANALYSIS_H
#define TSOLID_ANALYSIS_H

#include "tsolid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- hexahedra for finite elements -------------------------------------------------------------
 */

/* A named part of the boundary: a box of (s,t) on one side, usually a face of the user's part
 * (tsolid_placement says where it lies). Regions do not overlap; their borders become mesh lines;
 * those of one name, pieces of one face, are one region of the mesh, at the first one's place.
 */
typedef struct tsolid_region {
  const char *name;
  int side;
  double box[4]; /* s0, s1, t0, t1 */
} tsolid_region;

typedef struct tsolid_hex_options { /* all zero = default */
  int order;                        /* 1 (default): 8 nodes, 2: 20 nodes */
  double size;        /* wanted edge length; 0: a twentieth of the diagonal of the part */
  int divisions[4];   /* along x, y, z and through the layers; 0: from the size */
  double grading;     /* thickness of the outermost layer over that of the innermost; 0: 1 */
  int max_elements;   /* more are refused; 0: 2,000,000 */
  int allow_unproved; /* nonzero: also of a solid whose certificate is not positive */
  int n_regions;      /* 0: the six sides, named x_low, x_high, y_low, ... */
  const tsolid_region *regions;
} tsolid_hex_options;

/* Conforming hexahedra: a grid on the seven blocks of the cross, mapped by the solid, without
 * hanging nodes whatever the T-mesh is. Boundary nodes lie on the part's faces, mid nodes of
 * quadratic elements on the solid's curves. */
typedef struct tsolid_hex tsolid_hex;

typedef struct tsolid_hex_view {
  int order, divisions[4];
  int n_nodes;
  const double *nodes; /* rows of 3 */
  int n_elements, nodes_per_element;
  const int *element; /* rows of nodes_per_element, zero-based, in the order of Abaqus and CalculiX:
                         bottom corners counterclockwise seen from the top, top corners; mids of the
                         bottom, of the top, of the upright edges */
  int n_regions;
  const char *const *region_name;
  const int *region_start; /* n_regions + 1 */
  const int *region_face;  /* rows of (element, face): 0..5 = S1..S6 of Abaqus, by region */
  double worst;            /* smallest scaled Jacobian: corners; order 2: 3^3 points per element */
  int worst_element;
  int proved;  /* the certificate of the solid was positive; of an assembly: of all of them */
  int n_parts; /* of an assembly; 0: of one solid, then part_start is NULL */
  const char *const *part_name; /* distinct, letters of either case the same */
  const int *part_start;        /* part k has the elements part_start[k] .. part_start[k+1]-1 */
  int n_shared;                 /* nodes of the parts' own meshes less n_nodes */
} tsolid_hex_view;

/* TSOLID_ERROR_REFUSED when the solid is not proved valid (unless allowed), when a hexahedron folds
 * or when there would be too many. */
TSOLID_API tsolid_status tsolid_hex_create(tsolid_context *context, const tsolid_solid *solid,
                                           const tsolid_hex_options *options, tsolid_hex **hex);

/* What is a part's own in the mesh of an assembly. */
typedef struct tsolid_hex_part { /* all zero = default */
  int divisions[4];              /* as in the options */
  int n_regions;                 /* in the part's own sides; the mesh calls them PART_NAME */
  const tsolid_region *regions;
} tsolid_hex_part;

/* One mesh of an assembly that is joined, solid[k] of part k as given to tsolid_assembly_join, in
 * its place. Parts share the nodes of every exact, geometric and partial contact where both have
 * the same functions; a warning tells of contacts that are not bonded so. Divisions go through the
 * contacts from part to part: the borders of faces and contacts are lines in all parts that they
 * reach, and between them the largest wanted number of divisions counts. Regions: the free faces
 * of parts, those without any left out; and for each bonded pair the faces of the first part there,
 * called contact_PART_PART. options->size 0: a twentieth of the largest part's diagonal;
 * max_elements of all parts; divisions and regions are those of part[k], not of the options.
 * part == NULL: all default. TSOLID_ERROR_REFUSED as for one solid, for a part without a solid, for
 * divisions that contradict each other and for lines that multiply without end. */
TSOLID_API tsolid_status tsolid_hex_assembly_create(tsolid_context *context,
                                                    const tsolid_assembly *assembly, int n_parts,
                                                    const tsolid_solid *const *solid,
                                                    const tsolid_hex_part *part,
                                                    const tsolid_hex_options *options,
                                                    tsolid_hex **hex);
TSOLID_API void tsolid_hex_free(tsolid_hex *hex);
TSOLID_API void tsolid_hex_get(const tsolid_hex *hex, tsolid_hex_view *view);

/* ---- results and meshes as files ----------------------------------------------------------------
 */

/* A result on the solid: sum of c_A R_A, c_A = row A of `coefficient`, n_functions rows of
 * n_components (1 or 3). */
typedef struct tsolid_field {
  const char *name;
  int n_components;
  const double *coefficient;
} tsolid_field;

/* The same with fields as point data; VTK's rational interpolation of them is the field itself. */
TSOLID_API tsolid_status tsolid_write_vtu_fields(tsolid_context *context, const tsolid_solid *solid,
                                                 int n_fields, const tsolid_field *field,
                                                 const char *path);

/* The mesh as an input deck of CalculiX and Abaqus: nodes, elements (C3D8 or C3D20), and for each
 * region a node set and an element-face surface of its name. */
TSOLID_API tsolid_status tsolid_write_inp(tsolid_context *context, const tsolid_hex *hex,
                                          const char *path);
/* The mesh for VTK and ParaView: hexahedra, and behind them a quadrilateral per face of a region;
 * cell data Region (0, or the region from 1), field data RegionNames. */
TSOLID_API tsolid_status tsolid_write_hex_vtu(tsolid_context *context, const tsolid_hex *hex,
                                              const char *path);

/* ---- Bezier extraction for other codes
 * ---------------------------------------------------------- */

/* BEXT 2.0 text: nodes, one per function, Euclidean with weight; elements with their nodes and a
 * coefficient vector each, equal vectors stored once. */
TSOLID_API tsolid_status tsolid_write_bext(tsolid_context *context, const tsolid_solid *solid,
                                           const char *path);

typedef struct tsolid_bext_options { /* all zero = default */
  int n_regions;                     /* side sets: regions made of whole faces of elements */
  const tsolid_region *regions;
  int allow_unproved; /* nonzero: also a solid whose certificate is not positive; the file says so
                       */
} tsolid_bext_options;

/* The same with side sets, as comments behind the last block: the format has no place for them. */
TSOLID_API tsolid_status tsolid_write_bext_sets(tsolid_context *context, const tsolid_solid *solid,
                                                const tsolid_bext_options *options,
                                                const char *path);

/* Extraction operators as one plain binary file; write_extraction.c describes it, readers of it in
 * C and Python are among the examples. */
TSOLID_API tsolid_status tsolid_write_extraction(tsolid_context *context, const tsolid_solid *solid,
                                                 const char *path);

/* Trivariate Bezier extraction as BEXT 2.0 has it, of whatever origin. Element e has the functions
 * function[k], k = function_start[e] .. function_start[e+1]-1, whose Bernstein coefficients, u[0]
 * fastest, are coefficient[vector_start[vector[k]]] and on. Its homogeneous Bezier points are the
 * sums of coefficients times control. */
typedef struct tsolid_bext tsolid_bext;

typedef struct tsolid_bext_view {
  int patch, rational;
  int n_nodes;
  const double *nodes;   /* x, y, z, w: Euclidean, as in the file */
  const double *control; /* wx, wy, wz, w */
  int n_elements;
  const int *degree; /* n_elements rows of 3 */
  const int *function_start;
  const int *function;
  const int *vector;
  int n_vectors;
  const int *vector_start; /* n_vectors + 1 */
  const double *coefficient;
} tsolid_bext_view;

TSOLID_API tsolid_status tsolid_read_bext(tsolid_context *context, const char *path,
                                          tsolid_bext **bext);
TSOLID_API void tsolid_bext_free(tsolid_bext *bext);
TSOLID_API void tsolid_bext_get(const tsolid_bext *bext, tsolid_bext_view *view);

/* ---- matrices for analysis ---------------------------------------------------------------------
 */

typedef enum tsolid_matrix_kind {
  TSOLID_MASS = 0,  /* integral of R_A R_B */
  TSOLID_LAPLACE,   /* integral of grad R_A . grad R_B */
  TSOLID_ELASTICITY /* linear elasticity, isotropic; row 3 A + i is component i of function A */
} tsolid_matrix_kind;

typedef struct tsolid_material {
  double young, poisson; /* young > 0, -1 < poisson < 0.5 */
} tsolid_material;

/* Symmetric, all entries stored: row i has the columns column[k], ascending, with value[k],
 * k = row_start[i] .. row_start[i+1]-1. */
typedef struct tsolid_matrix tsolid_matrix;

typedef struct tsolid_matrix_view {
  int n_rows, n_components; /* rows = functions * components */
  const size_t *row_start;
  const int *column;
  const double *value;
} tsolid_matrix_view;

/* Of the solid's rational functions R_A = w_A N_A / sum of w_B N_B, in the numbering of the space.
 * material: for elasticity only; NULL: young 1, poisson 0. */
TSOLID_API tsolid_status tsolid_matrix_create(tsolid_context *context, const tsolid_solid *solid,
                                              tsolid_matrix_kind kind,
                                              const tsolid_material *material,
                                              tsolid_matrix **matrix);
TSOLID_API void tsolid_matrix_free(tsolid_matrix *matrix);
TSOLID_API void tsolid_matrix_get(const tsolid_matrix *matrix, tsolid_matrix_view *view);

/* load[A] = integral of R_A over a region of the boundary (its name is not used), n_functions
 * numbers; times a traction it is the right-hand side. */
TSOLID_API tsolid_status tsolid_face_load(tsolid_context *context, const tsolid_solid *solid,
                                          const tsolid_region *region, double *load);

/* The Dirichlet set of a region: the functions of the boundary layer that do not vanish on it,
 * ascending. On the region the solution is sum of c_A R_A over these alone; c_A = f(P_A), P_A the
 * Euclidean control points, gives a linear f exactly, anything else takes a projection. *n receives
 * their number; function may be NULL, else it has room for `capacity` numbers. */
TSOLID_API tsolid_status tsolid_face_functions(tsolid_context *context, const tsolid_solid *solid,
                                               const tsolid_region *region, int capacity, int *n,
                                               int *function);

/* MatrixMarket (coordinate, symmetric: the lower triangle, counted from 1) and PETSc's binary form
 * (MATAIJ, all entries; 32 bit indices). A vector: n numbers, as a dense array or as Vec. */
TSOLID_API tsolid_status tsolid_write_matrix_market(tsolid_context *context,
                                                    const tsolid_matrix *matrix, const char *path);
TSOLID_API tsolid_status tsolid_write_petsc(tsolid_context *context, const tsolid_matrix *matrix,
                                            const char *path);
TSOLID_API tsolid_status tsolid_write_vector_market(tsolid_context *context, int n,
                                                    const double *value, const char *path);
TSOLID_API tsolid_status tsolid_write_vector_petsc(tsolid_context *context, int n,
                                                   const double *value, const char *path);
/* A dense MatrixMarket table; `value` holds it row by row (the file, column by column). */
TSOLID_API tsolid_status tsolid_write_table_market(tsolid_context *context, int n_rows,
                                                   int n_columns, const double *value,
                                                   const char *path);
/* A set of indices, counted from 0, in PETSc's binary form (IS). */
TSOLID_API tsolid_status tsolid_write_set_petsc(tsolid_context *context, int n, const int *index,
                                                const char *path);
/* Such a table, or a PETSc vector (one column): *value, row by row, to be freed by tsolid_release.
 */
TSOLID_API tsolid_status tsolid_read_table(tsolid_context *context, const char *path, int *n_rows,
                                           int *n_columns, double **value);

#ifdef __cplusplus
}
#endif
#endif
