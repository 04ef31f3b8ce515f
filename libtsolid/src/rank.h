/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The smallest eigenvalue of a sparse symmetric non-negative matrix. */
#ifndef TSI_RANK_H
#define TSI_RANK_H

#include "internal.h"

/* All entries, not a triangle; columns ascend within a row. */
typedef struct tsi_symmetric {
  int n;
  size_t *start; /* n + 1 */
  int *column;
  double *value;
} tsi_symmetric;

/* Supplies a matrix as a sum over elements: element e holds unknowns unknown[start[e] ..
 * start[e+1]-1], each once; row() writes the local matrix's row a. row() may be called by several
 * threads at once. */
typedef struct tsi_element_sum {
  int n, n_elements;
  const size_t *start;
  const int *unknown;
  void (*row)(const void *data, int element, int a, double *out);
  const void *data;
} tsi_element_sum;

tsolid_status tsi_symmetric_assemble(tsolid_context *context, const tsi_element_sum *sum,
                                     tsi_arena *arena, tsi_symmetric *matrix);

/* How tsi_smallest_eigenvalue works: directly where the factor is cheap, else iteratively. */
typedef enum tsi_eigen_method {
  TSI_EIGEN_AUTO = 0,
  TSI_EIGEN_DIRECT,
  TSI_EIGEN_ITERATIVE
} tsi_eigen_method;

/* Scales the matrix to unit diagonal, in place, and finds its smallest eigenvalue to three digits;
 * 0 when it is not positive definite in double precision. */
tsolid_status tsi_smallest_eigenvalue(tsolid_context *context, tsi_symmetric *matrix,
                                      tsi_eigen_method method, double *eigenvalue);

#endif
