/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Bezier elements that know nothing of their neighbours become a T-mesh. */
#ifndef TSI_SURFACE_GRAPH_H
#define TSI_SURFACE_GRAPH_H

#include "surface.h"

typedef struct tsi_graph_facts {
  int n_strips;    /* of elements side by side: their widths are one number each */
  int n_inferred;  /* strips whose width is a neighbour's times a ratio that the functions have */
  int n_conflicts; /* ratios that disagree with others, not used */
} tsi_graph_facts;

/* `surface` has faces of one element each: n_faces, degree, function_start, function (ascending in
 * each element), coefficient, points. Fills links, vertices, edges, intervals, element_start and
 * boxes, and exchanges u and v of elements that show the other side than the first of their part.
 * TSOLID_ERROR_REFUSED where the elements join to no surface. */
tsolid_status tsi_surface_connect(tsolid_context *context, tsolid_surface *surface,
                                  tsi_graph_facts *facts);

#endif
