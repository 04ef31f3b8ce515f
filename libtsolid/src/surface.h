/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A spline surface on an unstructured T-mesh, as .tsm and .iga hold it: links (half-edges), knot
 * intervals, control points, and the Bezier elements of every face.
 *
 *          next
 *     o<---------o      A link runs along an edge with its face on the left and starts at
 *     |   face   ^      `vertex`. Opposite links share their edge. A link of an open border has
 *     |          | link face -1. Corners of a face are the origins of those of its links that are
 *     v          |      not straight: always four.
 *     o--------->o
 *          prev
 *
 * The frame of face f: u runs along face_link[f] (which starts at a corner), v to the left of it,
 * both in knot units from 0; the intervals along opposite sides of a face have the same sum. */
#ifndef TSI_SURFACE_H
#define TSI_SURFACE_H

#include "internal.h"

typedef struct tsi_link {
  int prev, next, opposite;
  int vertex; /* its origin */
  int face;   /* -1: open border */
  int edge;
  int straight; /* its origin is no corner of its face: a T-junction */
} tsi_link;

/* Compass directions at a vertex, counterclockwise. */
enum { TSI_EAST, TSI_NORTH, TSI_WEST, TSI_SOUTH };

/* What .tsm has beyond the T-mesh. Records are numbers in the file; deleted ones leave gaps, which
 * are kept. */
typedef struct tsi_tsm {
  int present; /* 0: the surface does not come from .tsm, nothing of this is set */
  int n_face_records, n_edge_records, n_vertex_records, n_link_records, n_point_records;
  int *edge_record, *link_record, *point_record;
  int *link_flag;
  int *compass;       /* per vertex: direction of vertex_link */
  int *condition;     /* per edge: the code of its end condition, -1: none */
  int has_map;        /* 0: control point i is that of vertex i */
  int (*extra)[4];    /* per vertex: further control points in each compass direction */
  size_t *grip_start; /* n_vertices + 1 */
  int *grip;    /* per vertex: rows from south to north of points from west to east; -1: none */
  double *xyzw; /* n_points x 4 as in the file: Euclidean and weight */
  char *head, *tail; /* lines before and after the records, without comments */
} tsi_tsm;

struct tsolid_surface {
  tsi_allocator allocator;
  int references;
  tsi_arena arena; /* all arrays below */
  int n_links, n_faces, n_edges, n_vertices;
  tsi_link *link;
  int *face_link, *edge_link, *vertex_link; /* vertex_link starts at the vertex */
  double *interval;                         /* n_edges, >= 0 */
  int *face_record, *vertex_record;         /* how messages call them: numbers in the file */
  int n_points;
  double *points; /* homogeneous, n_points x 4: one per function */

  /* Bezier elements of face f: element_start[f] .. element_start[f+1]-1. */
  int degree; /* in both directions of all elements */
  int *element_start;
  double *box;         /* (u0, u1, v0, v1) in the face's frame */
  int *function_start; /* of element e, as in tsolid_bezier_side */
  int *function;
  double *coefficient; /* (degree+1)^2 per function, u fastest */

  tsi_tsm tsm;

  /* Counted by tsi_surface_finish. */
  int n_t_junctions, n_boundary_loops, n_boundary_edges, n_parts, n_extraordinary;
  int *extraordinary, *valence; /* interior stars: vertex record, number of edges */
  double *face_size;            /* n_faces x (u, v) */
  double sum_defect;            /* largest |sum of the functions - 1| over all Bernstein points */
};

/* An empty surface whose arena is ready; NULL: no memory. Freed by tsolid_surface_free. */
tsolid_surface *tsi_surface_new(tsolid_context *context);
void tsi_surface_retain(const tsolid_surface *surface);

/* Lines of a text file that records came from, for messages; NULL where there are none. */
typedef struct tsi_surface_lines {
  const int *face, *edge, *vertex, *link;
} tsi_surface_lines;

/* Every invariant of links, faces, edges, vertices and intervals; the first one that is broken is
 * reported with its record. Not the elements. */
tsolid_status tsi_surface_check(tsolid_context *context, const tsolid_surface *surface,
                                const tsi_surface_lines *lines);

/* Lengths along u and v of a face. */
void tsi_face_lengths(const tsolid_surface *surface, int face, double length[2]);

/* Quadrants that faces take up round a vertex: a corner one, a T-junction two. *border: the link
 * of the open border that starts here, or -1. */
int tsi_vertex_quadrants(const tsolid_surface *surface, int vertex, int *border);

/* Interior vertices where not four quadrants meet. */
int tsi_vertex_is_star(const tsolid_surface *surface, int vertex);

/* The steps that end every reader, in this order: points and elements are checked, vertices, loops
 * and parts are counted. */
tsolid_status tsi_surface_finish(tsolid_context *context, tsolid_surface *surface);

/* Fills the Bezier elements of a surface that came from .tsm (surface_basis.c). */
tsolid_status tsi_surface_basis(tsolid_context *context, tsolid_surface *surface);

/* Cuts a closed surface along its twelve isolines into six sides. Fills *requirement as far as it
 * gets; TSOLID_ERROR_REFUSED with the reason and the place where there is no cube. The arrays of
 * *boundary are the arena's. */
tsolid_status tsi_surface_to_sides(tsolid_context *context, tsi_arena *arena,
                                   const tsolid_surface *surface, tsolid_requirement *requirement,
                                   tsolid_bezier_boundary *boundary);

#endif
