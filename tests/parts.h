/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Small parts for C tests, made in memory: the six faces of a trivariate Bezier net. */
#ifndef TSOLID_TEST_PARTS_H
#define TSOLID_TEST_PARTS_H

#include <stdlib.h>
#include <string.h>

#include "internal.h"

enum { PART_MAX_ORDER = 6, PART_MAX_POINTS = PART_MAX_ORDER * PART_MAX_ORDER * PART_MAX_ORDER };

/* Euclidean points and weights, u[0] fastest; only those on the faces matter. */
typedef struct part_net {
  int degree[3];
  double point[PART_MAX_POINTS][3], weight[PART_MAX_POINTS];
} part_net;

static inline size_t part_index(const part_net *net, const int i[3]) {
  return (size_t)(i[0] + (net->degree[0] + 1) * (i[1] + (net->degree[1] + 1) * i[2]));
}

/* The unit cube. */
static inline void part_identity(part_net *net, int d0, int d1, int d2) {
  int i[3];
  net->degree[0] = d0;
  net->degree[1] = d1;
  net->degree[2] = d2;
  for (i[2] = 0; i[2] <= d2; i[2]++)
    for (i[1] = 0; i[1] <= d1; i[1]++)
      for (i[0] = 0; i[0] <= d0; i[0]++) {
        size_t k = part_index(net, i);
        net->weight[k] = 1.0;
        for (int c = 0; c < 3; c++)
          net->point[k][c] = (double)i[c] / net->degree[c];
      }
}

/* A cylinder of radius 1 along z, height 2: discs of degree (2, 2) with tangent isolines at their
 * four corners, where the caps have det J = 0. */
static inline void part_cylinder(part_net *net) {
  const double h = sqrt(0.5), at[3] = {-h, 0.0, h};
  int i[3];
  part_identity(net, 2, 2, 1);
  for (i[2] = 0; i[2] < 2; i[2]++)
    for (i[1] = 0; i[1] < 3; i[1]++)
      for (i[0] = 0; i[0] < 3; i[0]++) {
        size_t k = part_index(net, i);
        int edge = (i[0] == 1) != (i[1] == 1);
        double out = edge ? 2.0 : 1.0;
        net->point[k][0] = at[i[0]] * out;
        net->point[k][1] = at[i[1]] * out;
        net->point[k][2] = 2.0 * i[2] - 1.0;
        net->weight[k] = edge ? h : 1.0;
      }
}

/* The boundary of the net's six faces; NULL when refused. */
static inline tsolid_boundary *part_boundary(tsolid_context *context, const part_net *net) {
  static double points[6][PART_MAX_ORDER * PART_MAX_ORDER * 3];
  static double weights[6][PART_MAX_ORDER * PART_MAX_ORDER], knots[6][2][2 * PART_MAX_ORDER];
  tsolid_patch patch[6];
  tsolid_boundary *boundary = NULL;
  memset(patch, 0, sizeof patch);
  for (int side = 0; side < 6; side++) {
    int a = tsi_side_axis(side), axis[2] = {tsi_side_s(side), tsi_side_t(side)}, i[3], n = 0;
    for (int d = 0; d < 2; d++) {
      int q = net->degree[axis[d]];
      patch[side].degree[d] = q;
      patch[side].n_control[d] = q + 1;
      for (int k = 0; k < 2 * q + 2; k++)
        knots[side][d][k] = k > q;
      patch[side].knots[d] = knots[side][d];
    }
    i[a] = side & 1 ? net->degree[a] : 0;
    for (i[axis[1]] = 0; i[axis[1]] <= net->degree[axis[1]]; i[axis[1]]++)
      for (i[axis[0]] = 0; i[axis[0]] <= net->degree[axis[0]]; i[axis[0]]++, n++) {
        size_t k = part_index(net, i);
        memcpy(points[side] + 3 * n, net->point[k], sizeof net->point[k]);
        weights[side][n] = net->weight[k];
      }
    patch[side].points = points[side];
    patch[side].weights = weights[side];
  }
  tsolid_boundary_input input = {.n_patches = 6, .patches = patch};
  (void)tsolid_boundary_create(context, &input, NULL, NULL, &boundary);
  return boundary;
}

/* The start over the net's faces; NULL when anything failed. */
static inline tsolid_solid *part_solid(tsolid_context *context, const part_net *net) {
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_solid *solid = NULL;
  tsolid_boundary *boundary = part_boundary(context, net);
  if (boundary && tsolid_tmesh_create(context, boundary, NULL, &tmesh) == TSOLID_OK &&
      tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK)
    (void)tsolid_solid_create(context, space, &solid);
  tsolid_space_free(space);
  tsolid_tmesh_free(tmesh);
  tsolid_boundary_free(boundary);
  return solid;
}

#endif
