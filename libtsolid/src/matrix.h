/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Sparse matrices of a solid's functions, in compressed rows. */
#ifndef TSI_MATRIX_H
#define TSI_MATRIX_H

#include "internal.h"

/* Most points per direction: (3 * 25 + 1) / 2. */
enum { TSI_RATIONAL_POINTS = 38 };

struct tsolid_matrix {
  tsi_allocator allocator;
  int references;
  int n_rows, n_components; /* rows of functions times components */
  size_t *row_start;
  int *column; /* ascending within a row */
  double *value;
};

/* The rational functions R = w N / W of one element at a tensor grid of local points. */
typedef struct tsi_rational {
  int n; /* functions, numbers ascending */
  int *function;
  int n_points[3]; /* per direction, u[0] fastest */
  double x[3][TSI_RATIONAL_POINTS];
  double *table; /* N and its derivatives by u: [point][4][n] */

  /* at the point chosen last */
  double *value[4];      /* R and its derivatives by x, y, z */
  double volume;         /* det of d x / d u */
  double jacobian[3][3]; /* row a: derivatives of x by u[a] */
} tsi_rational;

/* Numbers of the functions on an element, ascending; returns how many. */
int tsi_element_function_list(const tsolid_space *space, int element, int *function);
/* Most functions on any element, counted with repetitions. */
int tsi_most_functions(const tsolid_space *space);

/* Room for `most` functions at most_points points; 0: no memory. */
int tsi_rational_new(tsi_arena *arena, int most, int most_points, tsi_rational *r);
/* Fills the table; n, function, n_points and x are set. */
void tsi_rational_fill(const tsolid_space *space, int element, tsi_rational *r);
/* Chooses a point: sets value, volume and jacobian, once per fill and point. */
void tsi_rational_at(const tsolid_solid *solid, tsi_rational *r, int point);

#endif
