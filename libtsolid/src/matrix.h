/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Sparse matrices of a solid's functions, in compressed rows. */
#ifndef TSI_MATRIX_H
#define TSI_MATRIX_H

#include "internal.h"

struct tsolid_matrix {
  tsi_allocator allocator;
  int references;
  int n_rows, n_components; /* rows of functions times components */
  size_t *row_start;
  int *column; /* ascending within a row */
  double *value;
};

/* The rational functions R = w N / W at one point of an element: n of them, numbers ascending. */
typedef struct tsi_rational {
  int n, capacity;
  int *function;
  double *value[4]; /* R and its derivatives by x, y, z */
  double volume;    /* det of d x / d u */
  double area[3];   /* the normal x_s x x_t of the face u[axis] = constant, see tsi_rational_at */
} tsi_rational;

/* Numbers of the functions on an element, ascending; returns how many. */
int tsi_element_function_list(const tsolid_space *space, int element, int *function);
/* Most functions on any element, counted with repetitions. */
int tsi_most_functions(const tsolid_space *space);

/* Fills values at local x of the element; r->function must hold the element's list. axis >= 0: also
 * the area vector of the surface u[axis] = constant, pointing to larger u[axis]. */
void tsi_rational_at(const tsolid_solid *solid, int element, const double x[3], int axis,
                     tsi_rational *r);

#endif
