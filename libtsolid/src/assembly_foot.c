/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Point inversion: a nearest point S(u,v) of a patch to x, within its borders.
 *
 * Gauss-Newton on f = |S - x|^2 / 2: the step solves J^T J d = -J^T (S - x) with J = (S_u, S_v),
 * damped (Levenberg) until f falls. A parameter on its bound that would leave is held. At a foot
 * inside, S - x is normal to the surface; the convergence is linear with the ratio of distance to
 * radius of curvature, so that near contacts, which are what is asked for, take a few steps. */
#include "assembly.h"

enum { MOST_STEPS = 40, N_STARTS = 2 };

/* Residual S - x and, for d not NULL, the derivatives. Returns its square. */
static double evaluate(const tsi_skin *skin, const double x[3], const double uv[2], double r[3],
                       double d[2][3]) {
  double h[4], slope[2][4];
  tsi_patch_evaluate(&skin->patch, uv[0], uv[1], h, d ? slope : NULL);
  for (int c = 0; c < 3; c++) {
    double s = h[c] / h[3];
    r[c] = s - x[c];
    for (int k = 0; d && k < 2; k++)
      d[k][c] = (slope[k][c] - s * slope[k][3]) / h[3];
  }
  return tsi_dot3(r, r);
}

static double clamp(double x) {
  return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x;
}

/* The damped step; a parameter that would leave is held. */
static void find_step(const double uv[2], const double r[3], double d[2][3], double damping,
                      double step[2]) {
  double a = tsi_dot3(d[0], d[0]) * (1.0 + damping), b = tsi_dot3(d[0], d[1]),
         c = tsi_dot3(d[1], d[1]) * (1.0 + damping);
  double g[2] = {-tsi_dot3(d[0], r), -tsi_dot3(d[1], r)}, determinant = a * c - b * b;
  int held[2];
  for (int k = 0; k < 2; k++)
    held[k] = (uv[k] <= 0.0 && g[k] < 0.0) || (uv[k] >= 1.0 && g[k] > 0.0);
  step[0] = step[1] = 0.0;
  if (!held[0] && !held[1] && determinant > 1e-14 * a * c) {
    step[0] = (c * g[0] - b * g[1]) / determinant;
    step[1] = (a * g[1] - b * g[0]) / determinant;
    for (int k = 0; k < 2; k++) /* one bound at a time */
      if ((uv[k] <= 0.0 && step[k] < 0.0) || (uv[k] >= 1.0 && step[k] > 0.0)) {
        step[k] = 0.0;
        step[1 - k] = g[1 - k] / (k ? a : c);
      }
    return;
  }
  if (!held[0] && a > 0.0)
    step[0] = g[0] / a;
  else if (!held[1] && c > 0.0)
    step[1] = g[1] / c;
}

static void improve(const tsi_skin *skin, const double x[3], tsi_foot *foot) {
  double r[3], d[2][3], damping = 0.0, least = 1e-30 * skin->size * skin->size;
  double f = evaluate(skin, x, foot->uv, r, d);
  for (int k = 0; k < MOST_STEPS && f > least; k++) {
    double step[2], uv[2], s[3];
    find_step(foot->uv, r, d, damping, step);
    uv[0] = clamp(foot->uv[0] + step[0]);
    uv[1] = clamp(foot->uv[1] + step[1]);
    double expected = 0.0; /* decrease of f */
    for (int i = 0; i < 2; i++)
      expected -= (uv[i] - foot->uv[i]) * tsi_dot3(d[i], r);
    if (expected <= 1e-15 * f)
      break;
    double change = fabs(uv[0] - foot->uv[0]) + fabs(uv[1] - foot->uv[1]);
    if (change < 1e-15)
      break;
    double now = evaluate(skin, x, uv, s, NULL);
    if (!(now < f)) {
      if (change < 1e-12)
        break;
      damping = damping > 0.0 ? 8.0 * damping : 1e-2;
      continue;
    }
    damping = damping > 1e-3 ? 0.25 * damping : 0.0;
    memcpy(foot->uv, uv, sizeof uv);
    f = evaluate(skin, x, foot->uv, r, d);
  }
  foot->distance = sqrt(f);
  for (int c = 0; c < 3; c++)
    foot->point[c] = x[c] + r[c];
}

void tsi_foot_find(const tsi_skin *skin, const double x[3], const double *near, tsi_foot *foot) {
  double best[N_STARTS] = {INFINITY, INFINITY}, d[3];
  int at[N_STARTS] = {0, 0}, n0 = skin->n_grid[0];
  if (near) {
    foot->uv[0] = near[0];
    foot->uv[1] = near[1];
    improve(skin, x, foot);
    return;
  }
  for (int i = 0; i < n0 * skin->n_grid[1]; i++) {
    for (int c = 0; c < 3; c++)
      d[c] = skin->grid[i][c] - x[c];
    double f = tsi_dot3(d, d);
    if (f < best[0]) {
      best[1] = best[0];
      at[1] = at[0];
      best[0] = f;
      at[0] = i;
    } else if (f < best[1]) {
      best[1] = f;
      at[1] = i;
    }
  }
  foot->distance = INFINITY;
  for (int k = 0; k < N_STARTS && best[k] < INFINITY; k++) {
    tsi_foot other = {.uv = {skin->at[0][at[k] % n0], skin->at[1][at[k] / n0]}};
    improve(skin, x, &other);
    if (other.distance < foot->distance)
      *foot = other;
  }
}
