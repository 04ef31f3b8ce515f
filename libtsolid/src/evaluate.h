/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Values and derivatives, of functions and of Bezier nets. Rows of derivatives are, up to the
 * order asked for: value; d0, d1, d2; d00, d11, d22, d12, d02, d01 (1, 4 or 10 rows). */
#ifndef TSI_EVALUATE_H
#define TSI_EVALUATE_H

#include "internal.h"

enum { TSI_N_DERIVATIVES = 10 };

/* 1, 4 or 10. */
static inline int tsi_n_derivatives(int order) {
  return order == 0 ? 1 : order == 1 ? 4 : TSI_N_DERIVATIVES;
}

/* The range of cross coordinates of a block: lo[3], hi[3]. */
void tsi_block_range(const tsolid_tmesh *tmesh, int block, double range[6]);

/* The element of `block` that holds u: half-open boxes, closed at the block's upper ends; -1: none.
 */
int tsi_space_locate(const tsolid_space *space, int block, const double u[3]);

/* Local coordinates in [0,1]^3 of u in an element. */
void tsi_element_local(const tsi_element *element, const double u[3], double x[3]);

/* Calls visit once for every function entry of the element (the same function may come again: its
 * values add up) with value[0..n_derivatives-1] at local x, derivatives by cross coordinates. */
typedef void (*tsi_function_visit)(void *data, int function, const double *value);
void tsi_element_functions(const tsolid_space *space, int element, const double x[3], int order,
                           tsi_function_visit visit, void *data);

/* A Bezier net of any degree at local x, derivatives by local coordinates; rows of n_components
 * (<= 4). */
void tsi_bezier_evaluate(const int degree[3], const double *net, int n_components,
                         const double x[3], int order, double *out);

/* tsolid_solid_evaluate without findings, for threads; 0: u lies outside the block. */
int tsi_solid_point(const tsolid_solid *solid, int block, const double u[3], int order,
                    double *out);

/* Euclidean rows of 3 from homogeneous rows of 4. */
void tsi_project(int order, const double *homogeneous, double *euclidean);

static inline double tsi_det3(const double a[3], const double b[3], const double c[3]) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}

#endif
