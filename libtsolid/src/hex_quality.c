/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Scaled Jacobians of hexahedra as finite elements see them: trilinear elements at their corners,
 * quadratic serendipity elements at 3^3 points with the corners and the mids among them. */
#include "evaluate.h"
#include "hex.h"

/* Signs of the nodes' places, as in hex_mesh.c. */
static const signed char sign[20][3] = {
    {-1, -1, -1}, {1, -1, -1}, {1, 1, -1},  {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1},
    {-1, 1, 1},   {0, -1, -1}, {1, 0, -1},  {0, 1, -1},  {-1, 0, -1}, {0, -1, 1}, {1, 0, 1},
    {0, 1, 1},    {-1, 0, 1},  {-1, -1, 0}, {1, -1, 0},  {1, 1, 0},   {-1, 1, 0}};

/* Derivatives of shape function m at x in [-1,1]^3.
 * Corners: 8 N = (1+ax)(1+by)(1+cz), in the serendipity element times (ax + by + cz - 2).
 * Mids, where the sign is 0 in one direction: 4 N = (1-x^2)(1+by)(1+cz). */
static void shape_slopes(int order, int m, const double x[3], double slope[3]) {
  const signed char *s = sign[m];
  double f[3], g[3];
  int corner = s[0] && s[1] && s[2];
  for (int d = 0; d < 3; d++) {
    f[d] = s[d] ? 1.0 + s[d] * x[d] : 1.0 - x[d] * x[d];
    g[d] = s[d] ? s[d] : -2.0 * x[d];
  }
  double factor = corner ? 0.125 : 0.25;
  double tail = s[0] * x[0] + s[1] * x[1] + s[2] * x[2] - 2.0;
  for (int d = 0; d < 3; d++) {
    int a = (d + 1) % 3, b = (d + 2) % 3;
    slope[d] = factor * g[d] * f[a] * f[b];
    if (order == 2 && corner)
      slope[d] = slope[d] * tail + factor * f[d] * f[a] * f[b] * s[d];
  }
}

static double scaled_jacobian(int width, const double *nodes, const int *element,
                              double slope[20][3]) {
  double j[3][3] = {{0.0}}, length = 1.0;
  for (int m = 0; m < width; m++)
    for (int d = 0; d < 3; d++)
      for (int c = 0; c < 3; c++)
        j[d][c] += slope[m][d] * nodes[3 * (size_t)element[m] + (size_t)c];
  for (int d = 0; d < 3; d++)
    length *= sqrt(j[d][0] * j[d][0] + j[d][1] * j[d][1] + j[d][2] * j[d][2]);
  double value = tsi_det3(j[0], j[1], j[2]) / length;
  return isfinite(value) ? value : 0.0;
}

void tsi_hex_measure(tsolid_hex *hex) {
  int width = tsi_hex_width(hex->order), n = hex->order + 1;
  double slope[27][20][3];
  for (int k = 0; k < n * n * n; k++) {
    int step = 2 / hex->order;
    double x[3] = {k % n * step - 1.0, k / n % n * step - 1.0, (double)(k / n / n * step) - 1.0};
    for (int m = 0; m < width; m++)
      shape_slopes(hex->order, m, x, slope[k][m]);
  }
  hex->worst = INFINITY;
  for (int e = 0; e < hex->n_elements; e++) {
    const int *element = hex->element + (size_t)e * (size_t)width;
    for (int k = 0; k < n * n * n; k++) {
      double value = scaled_jacobian(width, hex->nodes, element, slope[k]);
      if (value < hex->worst) {
        hex->worst = value;
        hex->worst_element = e;
      }
    }
  }
}
