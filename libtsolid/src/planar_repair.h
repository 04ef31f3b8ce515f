/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Quality of a planar patch, and control points inside it that make it better. */
#ifndef TSI_PLANAR_REPAIR_H
#define TSI_PLANAR_REPAIR_H

#include "coons.h"

/* Smallest sampled scaled Jacobian; without the points at singular corners and, where all others
 * are positive and there are other spans, without the spans there. */
typedef struct tsi_planar_quality {
  double worst;
  double u[2];
} tsi_planar_quality;

/* singular: bits of corners, as for tsi_planar_certify. */
tsolid_status tsi_planar_measure(tsolid_context *context, const tsi_planar *patch, int singular,
                                 tsi_planar_quality *quality);

/* Moves points inside; the sampled quality is not worse than before. Stops early at `goal`. round:
 * so many more points per span are looked at. */
tsolid_status tsi_planar_improve(tsolid_context *context, tsi_planar *patch, int singular,
                                 double goal, int round);

#endif
