/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Rational functions R_A = w_A N_A / W of a solid in physical space, with W = sum of w_A N_A:
 *
 *     d R_A / d u = w_A (d N_A / d u - N_A (d W / d u) / W) / W,   grad R_A = J^-T d R_A / d u. */
#include <stdlib.h>

#include "evaluate.h"
#include "matrix.h"

static int compare_ints(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

int tsi_most_functions(const tsolid_space *space) {
  size_t most = 1;
  for (int e = 0; e < space->n_elements; e++) {
    size_t n = space->inner_start[e + 1] - space->inner_start[e];
    if (space->element[e].lateral >= 0) {
      const tsi_lateral *lateral = &space->lateral[space->element[e].lateral];
      n += 2 * (size_t)(lateral->function_end - lateral->function_first);
    }
    most = n > most ? n : most;
  }
  return (int)most;
}

int tsi_element_function_list(const tsolid_space *space, int element, int *function) {
  const tsi_element *e = &space->element[element];
  int n = 0, kept = 0;
  for (size_t i = space->inner_start[element]; i < space->inner_start[element + 1]; i++)
    function[n++] = space->inner_function[i];
  for (int layer = 0; e->lateral >= 0 && layer < 2; layer++) {
    const tsi_lateral *lateral = &space->lateral[e->lateral];
    for (int i = lateral->function_first; i < lateral->function_end && e->radial[layer] >= 0; i++)
      function[n++] = space->n_inner + layer * space->n_surface + space->lateral_function[i];
  }
  qsort(function, (size_t)n, sizeof *function, compare_ints);
  for (int k = 0; k < n; k++)
    if (kept == 0 || function[k] != function[kept - 1])
      function[kept++] = function[k];
  return kept;
}

static void add_value(void *data, int function, const double *value) {
  tsi_rational *r = data;
  int low = 0, high = r->n - 1;
  while (low < high) {
    int middle = (low + high) / 2;
    if (r->function[middle] < function)
      low = middle + 1;
    else
      high = middle;
  }
  for (int d = 0; d < 4; d++)
    r->value[d][low] += value[d];
}

/* Rows of the inverse transposed: g[d] . v = derivative by x_d of what has derivatives v by u. */
static void invert(double jacobian[3][3], double determinant, double inverse[3][3]) {
  for (int d = 0; d < 3; d++)
    for (int a = 0; a < 3; a++) {
      const double *p = jacobian[(a + 1) % 3], *q = jacobian[(a + 2) % 3];
      int i = (d + 1) % 3, j = (d + 2) % 3;
      inverse[d][a] = (p[i] * q[j] - p[j] * q[i]) / determinant;
    }
}

static void set_area(double jacobian[3][3], int axis, double area[3]) {
  const double *p = jacobian[(axis + 1) % 3], *q = jacobian[(axis + 2) % 3];
  for (int d = 0; d < 3; d++)
    area[d] = p[(d + 1) % 3] * q[(d + 2) % 3] - p[(d + 2) % 3] * q[(d + 1) % 3];
}

void tsi_rational_at(const tsolid_solid *solid, int element, const double x[3], int axis,
                     tsi_rational *r) {
  double h[4][4] = {{0.0}}, euclidean[12], jacobian[3][3], inverse[3][3];
  for (int d = 0; d < 4; d++)
    memset(r->value[d], 0, (size_t)r->n * sizeof(double));
  tsi_element_functions(solid->space, element, x, 1, add_value, r);
  for (int k = 0; k < r->n; k++) {
    const double *control = solid->control + 4 * (size_t)r->function[k];
    for (int d = 0; d < 4; d++)
      for (int c = 0; c < 4; c++)
        h[d][c] += r->value[d][k] * control[c];
  }
  tsi_project(1, h[0], euclidean);
  memcpy(jacobian, euclidean + 3, sizeof jacobian); /* row a: derivatives by u[a] */
  r->volume = tsi_det3(jacobian[0], jacobian[1], jacobian[2]);
  invert(jacobian, r->volume, inverse);
  if (axis >= 0)
    set_area(jacobian, axis, r->area);
  for (int k = 0; k < r->n; k++) {
    double w = solid->control[4 * (size_t)r->function[k] + 3] / h[0][3], v[4];
    for (int d = 0; d < 4; d++)
      v[d] = w * (r->value[d][k] - (d ? r->value[0][k] * h[d][3] / h[0][3] : 0.0));
    r->value[0][k] = v[0];
    for (int d = 0; d < 3; d++)
      r->value[1 + d][k] = inverse[d][0] * v[1] + inverse[d][1] * v[2] + inverse[d][2] * v[3];
  }
}
