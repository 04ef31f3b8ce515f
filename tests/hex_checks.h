/* SPDX-License-Identifier: LGPL-2.1-or-later
 * What holds of every mesh of hexahedra: inner faces belong to two elements, outer ones to one
 * region; and its volume. */
#ifndef TSOLID_TEST_HEX_CHECKS_H
#define TSOLID_TEST_HEX_CHECKS_H

#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "tsolid.h"

/* S1..S6, corners. */
static const int face_corner[6][4] = {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1},
                                      {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};

typedef struct face_key {
  int node[4]; /* ascending */
  int element, face;
} face_key;

static inline int compare_ints(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

static inline int compare_faces(const void *a, const void *b) {
  const face_key *p = a, *q = b;
  for (int k = 0; k < 4; k++)
    if (p->node[k] != q->node[k])
      return p->node[k] < q->node[k] ? -1 : 1;
  return 0;
}

static inline int is_contact(const tsolid_hex_view *v, int region) {
  return v->n_parts && strncmp(v->region_name[region], "contact_", 8) == 0;
}

/* Returns the number of outer faces. */
static inline long check_topology(const tsolid_hex_view *v) {
  size_t n = 6 * (size_t)v->n_elements;
  face_key *key = calloc(n, sizeof *key);
  unsigned char *in_region = calloc(n, 1), *used = calloc((size_t)v->n_nodes, 1);
  long n_outer = 0, n_inner = 0, n_wrong = 0, n_used = 0;
  for (size_t k = 0; k < n; k++) {
    key[k].element = (int)(k / 6);
    key[k].face = (int)(k % 6);
    for (int m = 0; m < 4; m++)
      key[k].node[m] =
          v->element[(k / 6) * (size_t)v->nodes_per_element + (size_t)face_corner[k % 6][m]];
    qsort(key[k].node, 4, sizeof(int), compare_ints);
  }
  for (int r = 0; r < v->n_regions; r++)
    for (int k = v->region_start[r]; !is_contact(v, r) && k < v->region_start[r + 1]; k++)
      in_region[6 * v->region_face[2 * k] + v->region_face[2 * k + 1]]++;
  qsort(key, n, sizeof *key, compare_faces);
  for (size_t i = 0, j; i < n; i = j) {
    for (j = i + 1; j < n && compare_faces(&key[i], &key[j]) == 0; j++) {
    }
    int listed = in_region[6 * key[i].element + key[i].face];
    n_outer += j - i == 1;
    n_inner += j - i == 2;
    n_wrong += j - i > 2 || listed != (j - i == 1);
  }
  for (size_t k = 0; k < (size_t)v->n_elements * (size_t)v->nodes_per_element; k++)
    used[v->element[k]] = 1;
  for (int k = 0; k < v->n_nodes; k++)
    n_used += used[k];
  CHECK(n_wrong == 0);
  CHECK(n_used == v->n_nodes);
  CHECK(2 * n_inner + n_outer == (long)n);
  free(used);
  free(in_region);
  free(key);
  return n_outer;
}

/* ---- geometry ----------------------------------------------------------------------------------
 */

/* Volume from the flux of x/3 through the outer faces; quadratic faces by 4 x 4 Gauss points of the
 * 8-node quadrilateral, which is exact enough to see the order. */
static inline double face_flux(const tsolid_hex_view *v, int element, int face) {
  static const double gauss[4][2] = {{0.0694318442029737, 0.1739274225687269},
                                     {0.3300094782075719, 0.3260725774312731},
                                     {0.6699905217924281, 0.3260725774312731},
                                     {0.9305681557970263, 0.1739274225687269}};
  static const int mid_of[8][8] = {{0, 8, 0, 11, 16, 0, 0, 0},  {8, 0, 9, 0, 0, 17, 0, 0},
                                   {0, 9, 0, 10, 0, 0, 18, 0},  {11, 0, 10, 0, 0, 0, 0, 19},
                                   {16, 0, 0, 0, 0, 12, 0, 15}, {0, 17, 0, 0, 12, 0, 13, 0},
                                   {0, 0, 18, 0, 0, 13, 0, 14}, {0, 0, 0, 19, 15, 0, 14, 0}};
  const int *e = v->element + (size_t)element * (size_t)v->nodes_per_element;
  const double *p[8];
  for (int k = 0; k < 4; k++) {
    int a = face_corner[face][k], b = face_corner[face][(k + 1) % 4];
    p[k] = v->nodes + 3 * (size_t)e[a];
    p[4 + k] = v->order == 2 ? v->nodes + 3 * (size_t)e[mid_of[a][b]] : NULL;
  }
  double flux = 0.0;
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++) {
      const double sign[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
      double s = 2.0 * gauss[i][0] - 1.0, t = 2.0 * gauss[j][0] - 1.0, x[3][3] = {{0.0}};
      for (int k = 0; k < 4; k++) {
        double a = sign[k][0], b = sign[k][1], f = 1.0 + a * s, g = 1.0 + b * t;
        double h = v->order == 2 ? a * s + b * t - 1.0 : 1.0, q = v->order == 2 ? 1.0 : 0.0;
        double n[3] = {0.25 * f * g * h, 0.25 * (a * g * h + q * f * g * a),
                       0.25 * (b * f * h + q * f * g * b)};
        for (int d = 0; d < 3; d++)
          for (int c = 0; c < 3; c++)
            x[d][c] += n[d] * p[k][c];
      }
      for (int k = 0; v->order == 2 && k < 4; k++) {
        double b = k == 0 || k == 3 ? -1.0 : 1.0, w = k % 2 ? t : s, other = k % 2 ? s : t;
        double value = 0.5 * (1.0 - w * w) * (1.0 + b * other), along = -w * (1.0 + b * other),
               across = 0.5 * (1.0 - w * w) * b;
        double n[3] = {value, k % 2 ? across : along, k % 2 ? along : across};
        for (int d = 0; d < 3; d++)
          for (int c = 0; c < 3; c++)
            x[d][c] += n[d] * p[4 + k][c];
      }
      double weight = 4.0 * gauss[i][1] * gauss[j][1];
      flux += weight / 3.0 *
              (x[0][0] * (x[1][1] * x[2][2] - x[1][2] * x[2][1]) +
               x[0][1] * (x[1][2] * x[2][0] - x[1][0] * x[2][2]) +
               x[0][2] * (x[1][0] * x[2][1] - x[1][1] * x[2][0]));
    }
  return -flux; /* the corners run counterclockwise seen from inside */
}

static inline double mesh_volume(const tsolid_hex_view *v) {
  double volume = 0.0;
  for (int r = 0; r < v->n_regions; r++)
    for (int k = v->region_start[r]; !is_contact(v, r) && k < v->region_start[r + 1]; k++)
      volume += face_flux(v, v->region_face[2 * k], v->region_face[2 * k + 1]);
  return volume;
}

#endif
