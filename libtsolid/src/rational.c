/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Rational functions R_A = w_A N_A / W of a solid in physical space, with W = sum of w_A N_A:
 *
 *     d R_A / d u = w_A (d N_A / d u - N_A (d W / d u) / W) / W,   grad R_A = J^-T d R_A / d u.
 *
 * On a tensor grid of points the values of an inner function are products of three lines, those of
 * a surface function products of a lateral table and a radial line (sum factorisation). */
#include <stdlib.h>

#include "bernstein.h"
#include "evaluate.h"
#include "matrix.h"

/* A function of one direction at the grid's points: values, then derivatives by u. */
typedef double line[2][TSI_RATIONAL_POINTS];

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

int tsi_rational_new(tsi_arena *arena, int most, int most_points, tsi_rational *r) {
  r->function = tsi_arena_new(arena, (size_t)most, sizeof *r->function);
  r->table = tsi_arena_new(arena, (size_t)most * (size_t)most_points, 4 * sizeof *r->table);
  return r->function && r->table;
}

/* ---- the table ---------------------------------------------------------------------------------
 */

static int find_function(const tsi_rational *r, int function) {
  int low = 0, high = r->n - 1;
  while (low < high) {
    int middle = (low + high) / 2;
    if (r->function[middle] < function)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/* Bernstein values at the points of direction d: [point][value, slope by u][k]. */
static void fill_basis(const tsi_rational *r, const tsi_element *e, int d, int degree,
                       double *basis) {
  double width = e->box[d + 3] - e->box[d];
  for (int x = 0; x < r->n_points[d]; x++, basis += 2 * (degree + 1)) {
    tsi_bernstein_derivatives(degree, r->x[d][x], 1, basis);
    for (int k = 0; k <= degree; k++)
      basis[degree + 1 + k] /= width;
  }
}

static void fill_line(int n_points, const double *basis, const double *row, line to) {
  for (int x = 0; x < n_points; x++)
    for (int o = 0; o < 2; o++) {
      const double *b = basis + 4 * (2 * x + o);
      to[o][x] = b[0] * row[0] + b[1] * row[1] + b[2] * row[2] + b[3] * row[3];
    }
}

static void add_inner(const tsolid_space *space, int element, double *basis[3], tsi_rational *r) {
  const int *n = r->n_points;
  size_t stride = (size_t)r->n;
  line f[3];
  for (size_t i = space->inner_start[element]; i < space->inner_start[element + 1]; i++) {
    double *to = r->table + find_function(r, space->inner_function[i]);
    for (int d = 0; d < 3; d++)
      fill_line(n[d], basis[d], space->row + 4 * (size_t)space->inner_row[i][d], f[d]);
    for (int z = 0; z < n[2]; z++)
      for (int y = 0; y < n[1]; y++) {
        double yz = f[1][0][y] * f[2][0][z], dyz = f[1][1][y] * f[2][0][z],
               ydz = f[1][0][y] * f[2][1][z];
        for (int x = 0; x < n[0]; x++, to += 4 * stride) {
          to[0] += f[0][0][x] * yz;
          to[stride] += f[0][1][x] * yz;
          to[2 * stride] += f[0][0][x] * dyz;
          to[3 * stride] += f[0][0][x] * ydz;
        }
      }
  }
}

/* One surface function at the lateral grid: f, f_s, f_t at [i + n_s j]. */
static void fill_lateral(const tsi_rational *r, const tsi_lateral *lateral, const int along[2],
                         const double *coefficient, const double *s, const double *t,
                         double (*f)[3]) {
  int p = lateral->degree[0] + 1, q = lateral->degree[1] + 1;
  int n_s = r->n_points[along[0]], n_t = r->n_points[along[1]];
  for (int i = 0; i < n_s; i++) {
    double column[2][TSI_MAX_ORDER] = {{0.0}}; /* value and s-slope, by t coefficient */
    for (int b = 0; b < q; b++)
      for (int a = 0; a < p; a++) {
        column[0][b] += s[2 * p * i + a] * coefficient[a + p * b];
        column[1][b] += s[2 * p * i + p + a] * coefficient[a + p * b];
      }
    for (int j = 0; j < n_t; j++) {
      double *to = f[i + n_s * j];
      to[0] = to[1] = to[2] = 0.0;
      for (int b = 0; b < q; b++) {
        to[0] += column[0][b] * t[2 * q * j + b];
        to[1] += column[1][b] * t[2 * q * j + b];
        to[2] += column[0][b] * t[2 * q * j + q + b];
      }
    }
  }
}

/* Adds f times a radial line; the grid is the element's. */
static void add_product(const tsi_rational *r, const int along[2], int axis, double (*f)[3],
                        line radial, double *to) {
  size_t stride = (size_t)r->n;
  int at[3];
  for (at[2] = 0; at[2] < r->n_points[2]; at[2]++)
    for (at[1] = 0; at[1] < r->n_points[1]; at[1]++)
      for (at[0] = 0; at[0] < r->n_points[0]; at[0]++, to += 4 * stride) {
        const double *g = f[at[along[0]] + r->n_points[along[0]] * at[along[1]]];
        to[0] += g[0] * radial[0][at[axis]];
        to[(size_t)(1 + along[0]) * stride] += g[1] * radial[0][at[axis]];
        to[(size_t)(1 + along[1]) * stride] += g[2] * radial[0][at[axis]];
        to[(size_t)(1 + axis) * stride] += g[0] * radial[1][at[axis]];
      }
}

static void add_surface(const tsolid_space *space, const tsi_element *e, double *basis[3],
                        tsi_rational *r) {
  const tsi_lateral *lateral = &space->lateral[e->lateral];
  int axis = tsi_side_axis(lateral->side);
  int along[2] = {tsi_side_s(lateral->side), tsi_side_t(lateral->side)};
  double s[2 * TSI_MAX_ORDER * TSI_RATIONAL_POINTS], t[2 * TSI_MAX_ORDER * TSI_RATIONAL_POINTS];
  double f[TSI_RATIONAL_POINTS * TSI_RATIONAL_POINTS][3];
  line radial[2];
  size_t width = (size_t)(lateral->degree[0] + 1) * (size_t)(lateral->degree[1] + 1);
  const double *coefficient = space->lateral_coefficient + lateral->coefficient_first;
  fill_basis(r, e, along[0], lateral->degree[0], s);
  fill_basis(r, e, along[1], lateral->degree[1], t);
  for (int layer = 0; layer < 2; layer++)
    if (e->radial[layer] >= 0)
      fill_line(r->n_points[axis], basis[axis], space->row + 4 * (size_t)e->radial[layer],
                radial[layer]);
  for (int i = lateral->function_first; i < lateral->function_end; i++, coefficient += width) {
    fill_lateral(r, lateral, along, coefficient, s, t, f);
    for (int layer = 0; layer < 2; layer++) {
      int id = space->n_inner + layer * space->n_surface + space->lateral_function[i];
      if (e->radial[layer] >= 0)
        add_product(r, along, axis, f, radial[layer], r->table + find_function(r, id));
    }
  }
}

void tsi_rational_fill(const tsolid_space *space, int element, tsi_rational *r) {
  const tsi_element *e = &space->element[element];
  double cubic[3][2 * 4 * TSI_RATIONAL_POINTS], *basis[3] = {cubic[0], cubic[1], cubic[2]};
  size_t n_points = (size_t)r->n_points[0] * (size_t)r->n_points[1] * (size_t)r->n_points[2];
  memset(r->table, 0, 4 * n_points * (size_t)r->n * sizeof *r->table);
  for (int d = 0; d < 3; d++)
    fill_basis(r, e, d, TSI_INNER_DEGREE, basis[d]);
  add_inner(space, element, basis, r);
  if (e->lateral >= 0)
    add_surface(space, e, basis, r);
}

/* ---- a point -----------------------------------------------------------------------------------
 */

/* g[d] . v = derivative by x_d of what has derivatives v by u. */
static void invert(double jacobian[3][3], double determinant, double inverse[3][3]) {
  for (int d = 0; d < 3; d++)
    for (int a = 0; a < 3; a++) {
      const double *p = jacobian[(a + 1) % 3], *q = jacobian[(a + 2) % 3];
      int i = (d + 1) % 3, j = (d + 2) % 3;
      inverse[d][a] = (p[i] * q[j] - p[j] * q[i]) / determinant;
    }
}

void tsi_rational_at(const tsolid_solid *solid, tsi_rational *r, int point) {
  double h[4][4] = {{0.0}}, euclidean[12], inverse[3][3];
  for (int d = 0; d < 4; d++) {
    r->value[d] = r->table + (size_t)(4 * point + d) * (size_t)r->n;
    for (int k = 0; k < r->n; k++)
      for (int c = 0; c < 4; c++)
        h[d][c] += r->value[d][k] * solid->control[4 * (size_t)r->function[k] + (size_t)c];
  }
  tsi_project(1, h[0], euclidean);
  memcpy(r->jacobian, euclidean + 3, sizeof r->jacobian);
  r->volume = tsi_det3(r->jacobian[0], r->jacobian[1], r->jacobian[2]);
  invert(r->jacobian, r->volume, inverse);
  for (int k = 0; k < r->n; k++) {
    double w = solid->control[4 * (size_t)r->function[k] + 3] / h[0][3], v[4];
    for (int d = 0; d < 4; d++)
      v[d] = w * (r->value[d][k] - (d ? r->value[0][k] * h[d][3] / h[0][3] : 0.0));
    r->value[0][k] = v[0];
    for (int d = 0; d < 3; d++)
      r->value[1 + d][k] = inverse[d][0] * v[1] + inverse[d][1] * v[2] + inverse[d][2] * v[3];
  }
}
