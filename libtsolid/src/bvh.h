/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A bounding volume hierarchy over axis-aligned boxes, immutable after creation. */
#ifndef TSI_BVH_H
#define TSI_BVH_H

#include "internal.h"

struct tsi_bvh;

/* A tree over n >= 0 boxes, n rows of lo[3], hi[3] (copied). O(n log n), the same tree for the same
 * boxes. NULL: no memory. */
struct tsi_bvh *tsi_bvh_create(const tsi_allocator *allocator, int n, const double *boxes);
void tsi_bvh_free(struct tsi_bvh *bvh); /* NULL allowed */

/* Called for a box that was found; a value other than 0 ends the search. */
typedef int (*tsi_bvh_visit)(void *data, int item);

/* Visits every item whose box, closed and widened by `margin`, meets the box (lo[3], hi[3]).
 * Returns the visitor's last value. */
int tsi_bvh_overlapping(const struct tsi_bvh *bvh, const double box[6], double margin,
                        tsi_bvh_visit visit, void *data);
/* The same for a point. */
int tsi_bvh_containing(const struct tsi_bvh *bvh, const double point[3], double margin,
                       tsi_bvh_visit visit, void *data);

/* Called with an item and the squared distance of its box; returns the new bound. */
typedef double (*tsi_bvh_approach)(void *data, int item, double distance2);

/* Visits items whose boxes are not farther from the point than the bound (squared distances), the
 * nearer subtree first. The bound starts as `bound2` and is what the visitor returned last: a
 * negative one ends the search. */
void tsi_bvh_nearest(const struct tsi_bvh *bvh, const double point[3], double bound2,
                     tsi_bvh_approach approach, void *data);

#endif
