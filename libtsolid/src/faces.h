/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The interior element faces of the cross: where two elements meet in a rectangle. */
#ifndef TSI_FACES_H
#define TSI_FACES_H

#include "internal.h"

typedef enum tsi_face_kind {
  TSI_FACE_BLOCK,   /* two elements of one block */
  TSI_FACE_CORE,    /* an element of the core and one of an arm */
  TSI_FACE_DIAGONAL /* elements of two arms, glued by rho = r / R */
} tsi_face_kind;

/* The rectangle box = (p0, p1, q0, q1) of face coordinates (p, q). On the face, element k has
 * u[axis[k]] at its low (end 0) or high (end 1) border, u[along[k][0]] = offset[k] + scale[k] p and
 * u[along[k][1]] = q. Off diagonals p and q are cross coordinates (offset 0, scale 1); on them
 * p = rho. */
typedef struct tsi_face {
  tsi_face_kind kind;
  int element[2], axis[2], end[2], along[2][2];
  double offset[2], scale[2];
  double box[4];
} tsi_face;

/* All of them, in an order that depends on the space alone; in the arena. */
tsolid_status tsi_faces_create(tsolid_context *context, const tsolid_space *space, tsi_arena *arena,
                               int *n, tsi_face **face);

/* Local coordinates in element k of face coordinates (p, q). */
void tsi_face_local(const tsolid_space *space, const tsi_face *face, int k, double p, double q,
                    double x[3]);

#endif
