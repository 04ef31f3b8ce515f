/* SPDX-License-Identifier: LGPL-2.1-or-later
 * From control points to the Bezier nets of the elements, and the transpose of that map. */
#ifndef TSI_NET_H
#define TSI_NET_H

#include "internal.h"

enum { TSI_NET_COMPONENTS = 4 };

/* Net of a lateral cell from one layer's control points (rows of n_components, one per surface
 * function): (D_s+1)(D_t+1) rows, s fastest. */
void tsi_lateral_net(const tsolid_space *space, const double *layer, int n_components, int lateral,
                     double *net);

/* Like tsi_element_net, with the lateral nets of the layers R- and R given (core: ignored). */
void tsi_element_net_from(const tsolid_space *space, const double *control, int n_components,
                          const double *lateral_minus, const double *lateral_outer, int element,
                          double *net);

/* The transpose: from d/d(net) to d/d(control) per entry of the element (inner_start order, rows of
 * n_components), and per point of the lateral net of layer R- (arms only). */
void tsi_element_net_transpose(const tsolid_space *space, int n_components, int element,
                               const double *net_gradient, double *entry_gradient,
                               double *lateral_gradient);

#endif
