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

struct tsolid_surface {
  tsi_allocator allocator;
  int references;
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
};

/* Cuts a closed surface along its twelve isolines into six sides. Fills *requirement as far as it
 * gets; TSOLID_ERROR_REFUSED with the reason and the place where there is no cube. The arrays of
 * *boundary are the arena's. */
tsolid_status tsi_surface_to_sides(tsolid_context *context, tsi_arena *arena,
                                   const struct tsolid_surface *surface,
                                   tsolid_requirement *requirement,
                                   tsolid_bezier_boundary *boundary);

#endif
