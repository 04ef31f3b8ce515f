/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The Jacobian certificate of one rational Bezier element; tsolid_certify runs it over all. */
#ifndef TSI_CERTIFY_H
#define TSI_CERTIFY_H

#include "internal.h"

enum { TSI_CERTIFY_DEPTH = 24, TSI_CERTIFY_MAX_DEPTH = 64 };

/* Minus this is the bound where none could be proved: finite, so that it can be written anywhere.
 */
#define TSI_NO_BOUND 1e300

typedef struct tsi_certify_task {
  int degree[3];
  const double *points; /* homogeneous rows, u[0] fastest */
  double error[4];      /* absolute error of each component of every row; 0: exact as given */
  int constant_weight;  /* W is one constant: det of the three derivatives, see certify.c */
  int singular;         /* bits of element corners where det J = 0 by the input */
  int max_depth;
} tsi_certify_task;

typedef struct tsi_certify_outcome {
  tsolid_verdict verdict;
  int depth;
  double u[3];  /* in [0,1]^3 of the element, when not positive or undecided */
  double bound; /* lower bound of det J / (product of the mean edge lengths) */
} tsi_certify_outcome;

typedef struct tsi_certifier tsi_certifier; /* workspace, one per thread */

/* Largest array sizes over the elements that a workspace is for; start from all zero. */
typedef struct tsi_certify_size {
  size_t net, minor, jacobian;
} tsi_certify_size;

void tsi_certify_size_include(tsi_certify_size *size, const int degree[3]);

/* In the arena; NULL: no memory. */
tsi_certifier *tsi_certifier_create(tsi_arena *arena, const tsi_certify_size *size, int max_depth);

/* Points must be finite. Never fails: what cannot be decided is undecided. */
void tsi_certify_run(tsi_certifier *certifier, const tsi_certify_task *task,
                     tsi_certify_outcome *outcome);

/* The Euclidean point of a homogeneous net at u in [0,1]^3. */
void tsi_net_point(const int degree[3], const double *points, const double u[3], double point[3]);

#endif
