/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Private to the cut of a surface into six sides: the T-mesh while isolines cut its faces.
 *
 * Positions are sums of knot intervals along paths. Paths of any order must give one number, so
 * sums carry twice a double's digits and are rounded once, at the end. */
#ifndef TSI_SURFACE_CUBE_H
#define TSI_SURFACE_CUBE_H

#include "surface.h"

/* high + low, |low| <= ulp(high)/2. */
typedef struct tsi_sum {
  double high, low;
} tsi_sum;

static inline tsi_sum tsi_sum_of(double x) {
  return (tsi_sum){x, 0.0};
}

/* Knuth's exact addition of two doubles. */
static inline tsi_sum tsi_sum_exact(double a, double b) {
  double high = a + b, part = high - a;
  return (tsi_sum){high, (a - (high - part)) + (b - part)};
}

static inline tsi_sum tsi_sum_add(tsi_sum a, tsi_sum b) {
  tsi_sum sum = tsi_sum_exact(a.high, b.high), rest = tsi_sum_exact(a.low, b.low);
  sum = tsi_sum_exact(sum.high, sum.low + rest.high);
  return tsi_sum_exact(sum.high, sum.low + rest.low);
}

static inline tsi_sum tsi_sum_subtract(tsi_sum a, tsi_sum b) {
  return tsi_sum_add(a, (tsi_sum){-b.high, -b.low});
}

/* Two positions are one when they differ by no more than this part of the length they lie on: knot
 * sums of decimal files agree to about 1e-15. */
static const double tsi_same_position = 1e-9;

/* A face, or the part of one that isolines have left. */
typedef struct tsi_cut_face {
  int first;      /* the link that runs along u from the corner (u0, v0) */
  int whole;      /* face of the surface */
  tsi_sum box[4]; /* u0, u1, v0, v1 in the frame of the whole face */
} tsi_cut_face;

/* A ray is an isoline seen from one of its two ends: ray 3k+i leaves star k. */
enum { TSI_N_STARS = 8, TSI_N_RAYS = 24 };

typedef struct tsi_ray {
  int star;    /* 0..7 */
  int start;   /* link */
  int partner; /* the ray at the other end, -1: not traced */
  int next;    /* the ray that follows with the same side on its left */
  int axis;    /* of the cube */
  tsi_sum length;
} tsi_ray;

typedef struct tsi_cutting {
  tsolid_context *context;
  tsi_arena *arena;
  const struct tsolid_surface *surface;
  int n_links, n_faces, n_edges, n_vertices;
  int link_room, face_room, edge_room, vertex_room;
  tsi_link *link;
  tsi_cut_face *face;
  tsi_sum *length;     /* per edge */
  int *edge_isoline;   /* per edge: 1 + ray that came along, 0: none */
  int *vertex_isoline; /* per vertex: the same for vertices between stars */
  int *vertex_star;    /* per vertex: 1 + star, 0: none */
  int star[TSI_N_STARS];
  tsi_ray ray[TSI_N_RAYS];
  int corner[TSI_N_STARS]; /* of the cube, per star */
  int side_ray[6];         /* a ray with the side on its left, at its corner of least bits */
  int n_cuts;
} tsi_cutting;

static inline int tsi_vertex_number(const struct tsolid_surface *s, int vertex) {
  return s->vertex_record ? s->vertex_record[vertex] : vertex;
}

/* The point of the surface at a vertex; 0: none of its faces has elements there. */
int tsi_surface_vertex_point(const struct tsolid_surface *surface, int vertex, double point[3]);
/* A finding at a vertex: refused. */
tsolid_finding tsi_cutting_finding(const tsi_cutting *cut, int vertex);
/* "the isoline that leaves vertex 3 towards vertex 8" */
enum { TSI_RAY_NAME_SIZE = 96 };
const char *tsi_ray_name(const tsi_cutting *cut, int ray, char text[TSI_RAY_NAME_SIZE]);

/* Follows all rays and splits the faces they run through. cut->ray: star, start given; partner and
 * length set. */
tsolid_status tsi_cutting_trace(tsi_cutting *cut);

/* Six sides from a traced surface whose rays have axes and whose stars have corners. */
tsolid_status tsi_cutting_sides(tsi_cutting *cut, tsolid_bezier_boundary *boundary);

#endif
