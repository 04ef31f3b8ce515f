/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Knots of a T-mesh as its vertices see them, and what the steps of the basis share. */
#ifndef TSI_SURFACE_RAYS_H
#define TSI_SURFACE_RAYS_H

#include "surface.h"

/* How functions behave at a vertex.
 *   regular  four quadrants, fewer on the border; lines cross it straight
 *   corner   all its edges are creases: each face ends there by itself
 *   sharp    not four quadrants, but all its edges have interval 0: rays end there, and the surface
 *            has the vertex's own control point
 *   star     everything else */
typedef enum tsi_vertex_kind { TSI_REGULAR, TSI_CORNER, TSI_SHARP, TSI_STAR } tsi_vertex_kind;

typedef struct tsi_mesh {
  tsolid_context *context;
  const tsolid_surface *surface;
  int *side;     /* per link with a face: 0..3, the side of the face that it is on */
  double *at;    /* per link: distance of its origin from the start of that side */
  double *size;  /* per face: u, v */
  char *kind;    /* per vertex: tsi_vertex_kind */
  char *natural; /* per edge: functions end there with the natural end condition */
} tsi_mesh;

/* Where a ray goes on. */
typedef struct tsi_way {
  enum { TSI_OUTSIDE, TSI_ALONG, TSI_ACROSS } kind;
  int link;      /* along: the link; across: the link of the face at which the ray enters it */
  double offset; /* across: how far from the link's origin */
} tsi_way;

/* Knots in one direction, as distances from the vertex. */
typedef struct tsi_half {
  double knot[2];
  double stop;     /* functions are cut off there with value zero (natural end); else infinite */
  int own_natural; /* the vertex itself is on a natural end in this direction's cross line */
} tsi_half;

tsolid_status tsi_mesh_create(tsolid_context *context, tsi_arena *arena,
                              const tsolid_surface *surface, tsi_mesh *mesh);

/* From link a outgoing at a vertex n quadrants counterclockwise, 0 <= n <= 4. */
tsi_way tsi_turn(const tsolid_surface *surface, int a, int n);

/* The way in compass direction d at a regular vertex. */
tsi_way tsi_vertex_way(const tsolid_surface *surface, int vertex, int d);

/* Knots in compass direction d for the control point i to the east and j to the north of a regular
 * vertex's primary one. */
tsi_half tsi_mesh_half(const tsi_mesh *mesh, int vertex, int d, int i, int j);

/* Knots along an edge from a corner or a sharp vertex. */
tsi_half tsi_mesh_corner_half(const tsi_mesh *mesh, int link);

static inline int tsi_destination(const tsolid_surface *s, int link) {
  return s->link[s->link[link].next].vertex;
}

/* Replaces what the local knots cannot give by the rule for stars (surface_star.c), on nets of
 * single elements of the faces near stars. */
typedef struct tsi_net {
  int n, capacity;
  int *function;
  double (*coefficient)[16];
} tsi_net;

/* near[f]: 2 a face at a star, 1 a face that touches one of these, else 0. */
tsolid_status tsi_star_faces(const tsi_mesh *mesh, tsi_arena *arena, char **near);
/* Notes which surface results round stars: one for all that are alike. After the elements. */
tsolid_status tsi_star_notes(const tsi_mesh *mesh, tsi_arena *arena);
/* net[f] of faces with near[f] = 1 holds their own functions; fills net[f] of those at stars and
 * replaces what faces share with them. */
tsolid_status tsi_star_nets(const tsi_mesh *mesh, tsi_arena *arena, const char *near, tsi_net *net);
int tsi_net_add(tsi_arena *arena, tsi_net *net, int function, int index, double c);
/* "T-junction at vertex k is too near to the star at vertex m". */
tsolid_status tsi_star_refuse(const tsi_mesh *mesh, tsi_arena *arena, int face);

/* The primary control point of a vertex. */
int tsi_primary_point(const tsolid_surface *surface, int vertex);

#endif
