/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Conjugate gradients on matrix-free operators.
 *
 * Source: M. Hestenes, E. Stiefel (1952); preconditioned form as in Y. Saad (2003), algorithm 9.1.
 */
#include "solve.h"

double tsi_dot(int n, const double *x, const double *y) {
  enum { CHUNK = 256 };
  double total = 0.0;
  for (int first = 0; first < n; first += CHUNK) {
    int end = first + CHUNK < n ? first + CHUNK : n;
    double part = 0.0;
    for (int i = first; i < end; i++)
      part += x[i] * y[i];
    total += part;
  }
  return total;
}

tsolid_status tsi_conjugate_gradients(tsolid_context *context, const char *stage, int n,
                                      tsi_apply apply, void *data, const double *diagonal,
                                      const double *b, double reduction, int max_steps, double *x,
                                      int *steps) {
  tsi_arena arena = tsi_arena_create(context);
  tsolid_status status = TSOLID_OK;
  double *r = tsi_arena_new(&arena, (size_t)n, sizeof *r);
  double *z = tsi_arena_new(&arena, (size_t)n, sizeof *z);
  double *p = tsi_arena_new(&arena, (size_t)n, sizeof *p);
  double *q = tsi_arena_new(&arena, (size_t)n, sizeof *q);
  *steps = 0;
  if (!r || !z || !p || !q) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  apply(data, x, q);
  for (int i = 0; i < n; i++)
    r[i] = b[i] - q[i];
  double rho = 0.0, goal = 0.0;
  for (int step = 0; step <= max_steps; step++) {
    for (int i = 0; i < n; i++)
      z[i] = r[i] / diagonal[i];
    double next = tsi_dot(n, r, z);
    if (step == 0)
      goal = next * reduction * reduction;
    if (!(next > goal) || step == max_steps)
      break;
    double beta = step == 0 ? 0.0 : next / rho;
    rho = next;
    for (int i = 0; i < n; i++)
      p[i] = z[i] + beta * p[i];
    apply(data, p, q);
    double curvature = tsi_dot(n, p, q);
    if (!(curvature > 0.0)) /* round-off has the last word: this is as good as it gets */
      break;
    double alpha = rho / curvature;
    for (int i = 0; i < n; i++) {
      x[i] += alpha * p[i];
      r[i] -= alpha * q[i];
    }
    *steps = step + 1;
    if (step % 16 == 0 && (status = tsi_progress(context, stage, 0.0)) != TSOLID_OK)
      goto done;
  }
done:
  tsi_arena_free(&arena);
  return status;
}
