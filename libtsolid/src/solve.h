/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TSI_SOLVE_H
#define TSI_SOLVE_H

#include "internal.h"

/* y = A x for a symmetric positive definite A of size n. */
typedef void (*tsi_apply)(void *data, const double *x, double *y);

/* Solves A x = b by conjugate gradients preconditioned with the diagonal, from the x given, until
 * the residual in the preconditioned norm has fallen by `reduction`, at most max_steps steps.
 * *steps receives their number. Sums in a fixed order. */
tsolid_status tsi_conjugate_gradients(tsolid_context *context, const char *stage, int n,
                                      tsi_apply apply, void *data, const double *diagonal,
                                      const double *b, double reduction, int max_steps, double *x,
                                      int *steps);

/* Sum of x[i] y[i] in pairwise order of fixed chunks: the same bits everywhere. */
double tsi_dot(int n, const double *x, const double *y);

#endif
