/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The diagonal of a stiffness matrix, to scale the unknowns of a descent. */
#include "precondition.h"
#include "bernstein.h"

/* Integrals over [0,1] of the square of a cubic with Bernstein coefficients c, and of its slope. */
static void square_integrals(const double c[4], double *square, double *slope) {
  double sum = 0.0, sum_slope = 0.0, d[3] = {c[1] - c[0], c[2] - c[1], c[3] - c[2]};
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 4; k++)
      sum += c[i] * c[k] * tsi_binomial(3, i) * tsi_binomial(3, k) / tsi_binomial(6, i + k);
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++)
      sum_slope += d[i] * d[k] * tsi_binomial(2, i) * tsi_binomial(2, k) / tsi_binomial(4, i + k);
  *square = sum / 7.0;
  *slope = 9.0 * sum_slope / 5.0;
}

int tsi_stiffness_diagonal(const tsolid_space *space, const tsi_allocator *allocator,
                           const double *control, const double (*factor)[3], double *diagonal) {
  double(*integral)[2] = tsi_new(allocator, (size_t)space->n_rows, sizeof *integral);
  if (!integral)
    return 0;
  for (int r = 0; r < space->n_rows; r++)
    square_integrals(space->row + 4 * (size_t)r, &integral[r][0], &integral[r][1]);
  for (int e = 0; e < space->n_elements; e++) {
    const tsi_element *el = &space->element[e];
    for (size_t i = space->inner_start[e]; i < space->inner_start[e + 1]; i++)
      for (int a = 0; a < 3; a++) {
        double part = factor[e][a];
        for (int b = 0; b < 3; b++)
          part *= integral[space->inner_row[i][b]][a == b];
        diagonal[space->inner_function[i]] += part;
      }
    if (el->radial[0] < 0)
      continue;
    const tsi_lateral *l = &space->lateral[el->lateral];
    int side = el->block - 1, size = (l->degree[0] + 1) * (l->degree[1] + 1);
    const double *c = space->lateral_coefficient + l->coefficient_first;
    const double *radial = integral[el->radial[0]];
    double lateral = factor[e][tsi_side_s(side)] + factor[e][tsi_side_t(side)];
    for (int f = l->function_first; f < l->function_end; f++, c += size) {
      double square = 0.0;
      for (int i = 0; i < size; i++)
        square += c[i] * c[i] / size;
      diagonal[space->n_inner + space->lateral_function[f]] +=
          square * (radial[1] * factor[e][tsi_side_axis(side)] + 4.0 * radial[0] * lateral);
    }
  }
  tsi_delete(allocator, integral);
  for (int f = 0; f < space->n_inner + space->n_surface; f++)
    diagonal[f] *= control[4 * (size_t)f + 3] * control[4 * (size_t)f + 3];
  return 1;
}
