/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Energies of the Jacobian, E(P) = sum over elements and quadrature points of a density, with their
 * gradients: what the optimisation minimises and measures. */
#ifndef TSI_KERNEL_H
#define TSI_KERNEL_H

#include "internal.h"

enum { TSI_KERNEL_MAX_POINTS = TSI_MAX_ORDER };

/* How the points of an element are chosen. */
typedef enum tsi_rule {
  TSI_LOBATTO, /* min(q + 1, 6) Gauss-Lobatto points: the corners are among them */
  TSI_GRID     /* 7 equidistant points, the corners among them; weights 1/7 */
} tsi_rule;

/* Jacobians at n points: j[3*c + a][point] = d x_c / d xi_a, xi in the element's own [0,1]^3;
 * weight[point] sums to 1. Adds to *energy and sets g = d energy / d j (same layout). The arrays
 * have `stride` points per row. */
typedef void (*tsi_density)(const void *data, int element, int n, int stride, const double *weight,
                            const double *j, double *energy, double *g);

typedef struct tsi_kernel tsi_kernel;

/* Keeps pointers to the space and to `control`'s weights (homogeneous rows of 4, all functions). */
tsolid_status tsi_kernel_create(tsolid_context *context, const tsolid_space *space,
                                const double *control, tsi_rule rule, tsi_kernel **kernel);
void tsi_kernel_free(tsi_kernel *kernel); /* NULL allowed */

/* Points of an element per direction; the first direction runs fastest. */
void tsi_kernel_points(const tsi_kernel *kernel, int element, int n[3]);

/* position: Euclidean, rows of 3 for all functions. gradient: rows of 3 for the free ones (inner,
 * R-), or NULL. Elements with active[e] == 0 are left out (NULL: none are). element_energy (one per
 * element, 0 where left out) may be NULL. The same bits for every number of threads. */
void tsi_kernel_energy(tsi_kernel *kernel, const double *position, tsi_density density,
                       const void *data, const unsigned char *active, double *energy,
                       double *gradient, double *element_energy);

#endif
