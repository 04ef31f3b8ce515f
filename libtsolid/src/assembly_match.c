/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Contacts that are exact: two patches, or rectangles of them, that are one surface.
 *
 * Where all four corners of a patch coincide with those of the other in one of the eight
 * orientations, both are brought to common degrees and knots (exact) and compared control point by
 * control point: equal nets are equal surfaces, and the largest distance of control points bounds
 * the largest distance of points at equal parameters. Where that fails, one side's parameters are
 * changed by the Moebius maps that take the middles of its borders to those of the other, which
 * multiplies weights and nothing else, and compared once more.
 *
 * Else both may overlap in a rectangle. Its borders are borders of one or the other, so those of b
 * that run on a must be isolines there: the feet of their samples tell where, and the feet of the
 * rectangle's corners tell the rectangle of b. Feet only propose: what decides is the comparison of
 * both restricted patches, as above.
 *
 * And two patches may touch in several rectangles (a bridge's underside and the ground), with
 * borders inside both: then these run along knots of one of them. Its spans, cut at the isolines
 * above, lie on the other patch or do not; those that do are gathered into rectangles, each of
 * which is matched as before. */
#include <stdlib.h>

#include "assembly.h"
#include "bspline.h"

static const char stage[] = "assembly";

/* Knots of two sides closer than this are one knot. */
static const double knot_resolution = 1e-11;
static const double weight_resolution = 1e-9;
static const double straightness = 1e-5; /* spread of the feet of an isoline */

enum { N_SAMPLES = 33, MOST_CUTS = 4, MOST_CELLS = 4096, N_STEPS = 8 };

int tsi_patch_turn(tsi_arena *arena, const tsi_patch *from, int code, tsi_patch *patch) {
  int flip[2] = {code & 1, code >> 1 & 1};
  return tsi_patch_orient(arena, from, flip, code >> 2, patch);
}

/* ---- common refinement -------------------------------------------------------------------------
 */

static int count_equal(int n, const double *knots, int i) {
  int count = 1;
  while (i + count < n && knots[i + count] == knots[i])
    count++;
  return count;
}

/* The knots with every distinct one `raise` times more. */
static int raise_knots(int n, const double *knots, int raise, double *to) {
  int n_to = 0;
  for (int i = 0, same; i < n; i += same) {
    same = count_equal(n, knots, i);
    for (int k = 0; k < same + raise; k++)
      to[n_to++] = knots[i];
  }
  return n_to;
}

/* Moves b's knots that are nearly a's onto them. */
static void merge_knots(const tsi_patch *a, tsi_patch *b, int d) {
  int n = a->n[d] + a->degree[d] + 1, m = b->n[d] + b->degree[d] + 1, i = 0;
  for (int k = 0; k < m; k++) {
    while (i + 1 < n &&
           fabs(a->knots[d][i + 1] - b->knots[d][k]) <= fabs(a->knots[d][i] - b->knots[d][k]))
      i++;
    if (fabs(a->knots[d][i] - b->knots[d][k]) <= knot_resolution)
      b->knots[d][k] = a->knots[d][i];
  }
}

static int unite(int n, const double *x, int m, const double *y, double *to) {
  int i = 0, j = 0, count = 0;
  while (i < n || j < m) {
    double p = i < n ? x[i] : INFINITY, q = j < m ? y[j] : INFINITY;
    to[count++] = p < q ? p : q;
    i += p <= q;
    j += q <= p;
  }
  return count;
}

/* 1: done, 0: no memory, -1: too large or torn. */
static int refine_both(tsi_arena *arena, tsi_patch *patch[2], int d) {
  int degree =
      patch[0]->degree[d] > patch[1]->degree[d] ? patch[0]->degree[d] : patch[1]->degree[d];
  double *raised[2], *to;
  int n[2], room = 0;
  merge_knots(patch[0], patch[1], d);
  for (int k = 0; k < 2; k++) {
    int own = patch[k]->n[d] + patch[k]->degree[d] + 1, raise = degree - patch[k]->degree[d];
    raised[k] = tsi_arena_new(arena, (size_t)own * (size_t)(raise + 1), sizeof(double));
    if (!raised[k])
      return 0;
    n[k] = raise_knots(own, patch[k]->knots[d], raise, raised[k]);
    room += n[k];
  }
  to = tsi_arena_new(arena, (size_t)room, sizeof *to);
  if (!to)
    return 0;
  int count = unite(n[0], raised[0], n[1], raised[1], to);
  for (int i = degree + 1; i < count - degree - 1; i++)
    if (to[i] == to[i + degree])
      return -1;
  if ((double)count * patch[0]->n[1 - d] > 1e6 || (double)count * patch[1]->n[1 - d] > 1e6)
    return -1;
  for (int k = 0; k < 2; k++)
    if (!tsi_patch_refine(arena, patch[k], d, degree - patch[k]->degree[d], count - degree - 1, to))
      return 0;
  return 1;
}

/* Arrays of its own. */
static int copy_patch(tsi_arena *arena, const tsi_patch *from, tsi_patch *to) {
  return tsi_patch_turn(arena, from, 0, to);
}

/* ---- comparison --------------------------------------------------------------------------------
 */

static int same_knots(const tsi_patch *a, const tsi_patch *b) {
  for (int d = 0; d < 2; d++) {
    if (a->degree[d] != b->degree[d] || a->n[d] != b->n[d])
      return 0;
    for (int i = 0; i < a->n[d] + a->degree[d] + 1; i++)
      if (fabs(a->knots[d][i] - b->knots[d][i]) > knot_resolution)
        return 0;
  }
  return 1;
}

/* Largest distance of control points; infinite where weights have no common factor. */
static double compare_nets(const tsi_patch *a, const tsi_patch *b) {
  size_t n = (size_t)a->n[0] * (size_t)a->n[1];
  double most = 0.0, factor = a->control[3] / b->control[3];
  for (size_t i = 0; i < n; i++) {
    const double *p = a->control + 4 * i, *q = b->control + 4 * i;
    double x[3], y[3];
    if (fabs(q[3] * factor / p[3] - 1.0) > weight_resolution)
      return INFINITY;
    tsi_project_point(p, x);
    tsi_project_point(q, y);
    most = fmax(most, tsi_distance(x, y));
  }
  return most;
}

/* Parameter of b's border d at the middle of a's, by bisection-free search: the foot on an isoline
 * of a net is found on samples, then by golden section. */
static double find_middle(const tsi_patch *a, const tsi_patch *b, int d, int end) {
  double h[4], x[3], y[3], low = 0.0, high = 1.0;
  double at[2];
  at[d] = 0.5;
  at[1 - d] = end;
  tsi_patch_point(a, at[0], at[1], x);
  double best = INFINITY, middle = 0.5;
  for (int i = 0; i <= 16; i++) {
    at[d] = i / 16.0;
    tsi_patch_point(b, at[0], at[1], y);
    if (tsi_distance(x, y) < best) {
      best = tsi_distance(x, y);
      middle = at[d];
    }
  }
  low = fmax(0.0, middle - 1.0 / 16);
  high = fmin(1.0, middle + 1.0 / 16);
  for (int step = 0; step < 60; step++) { /* the sign of (y - x) . y' */
    double slope[2][4], dot = 0.0;
    at[d] = 0.5 * (low + high);
    tsi_patch_evaluate(b, at[0], at[1], h, slope);
    for (int c = 0; c < 3; c++) {
      double s = h[c] / h[3];
      dot += (s - x[c]) * (slope[d][c] - s * slope[d][3]);
    }
    if (dot > 0.0)
      high = at[d];
    else
      low = at[d];
  }
  return 0.5 * (low + high);
}

typedef struct comparison {
  int exact; /* without refinement */
  double deviation, moebius[2];
} comparison;

/* Compares a with b, both over [0,1]^2 and alike oriented. *found: they are one surface. */
static int compare_patches(tsi_arena *arena, const tsi_patch *a, const tsi_patch *b,
                           double tolerance, comparison *result, int *found) {
  tsi_patch copy[2], *both[2] = {&copy[0], &copy[1]};
  *found = 0;
  for (int attempt = 0; attempt < 2 && !*found; attempt++) {
    int done = 1;
    *result = (comparison){.deviation = INFINITY, .moebius = {1.0, 1.0}};
    if (!copy_patch(arena, a, both[0]) || !copy_patch(arena, b, both[1]))
      return 0;
    for (int d = 0; attempt && d < 2; d++) {
      double middle = find_middle(a, b, d, 0), c = middle / (1.0 - middle);
      if (!(c > 1e-6 && c < 1e6))
        return 1;
      if (fabs(c - 1.0) > 1e-12 && tsi_patch_reparametrise(both[1], d, c))
        result->moebius[d] = c;
    }
    if (attempt && result->moebius[0] == 1.0 && result->moebius[1] == 1.0)
      return 1;
    if (!attempt && same_knots(both[0], both[1])) {
      result->exact = 1;
      result->deviation = compare_nets(both[0], both[1]);
    } else {
      for (int d = 0; done > 0 && d < 2; d++)
        done = refine_both(arena, both, d);
      if (done > 0)
        result->deviation = compare_nets(both[0], both[1]);
    }
    if (!done)
      return 0;
    *found = result->deviation <= tolerance;
  }
  return 1;
}

/* ---- orientations ------------------------------------------------------------------------------
 */

void tsi_contact_map(const tsolid_interface *contact, int side, double s, double t, double uv[2]) {
  double x[2] = {s, t};
  if (side) {
    if (contact->code & 4) {
      x[0] = t;
      x[1] = s;
    }
    for (int d = 0; d < 2; d++) {
      double c = contact->moebius[d];
      if (contact->code >> d & 1)
        x[d] = 1.0 - x[d];
      if (c > 1.0 || c < 1.0)
        x[d] = c * x[d] / (c * x[d] + (1.0 - x[d]));
    }
  }
  for (int d = 0; d < 2; d++)
    uv[d] = contact->box[side][2 * d] +
            x[d] * (contact->box[side][2 * d + 1] - contact->box[side][2 * d]);
}

/* Corners (s,t) = 00, 10, 11, 01 of the turned patch, as corners of the patch itself. */
static int turned_corner(int code, int k) {
  int s = k == 1 || k == 2, t = k >= 2, u = code & 4 ? t : s, v = code & 4 ? s : t;
  u ^= code & 1;
  v ^= code >> 1 & 1;
  return v ? (u ? 2 : 3) : u;
}

static int corners_fit(double a[4][3], double b[4][3], int code, double tolerance) {
  for (int k = 0; k < 4; k++)
    if (!(tsi_distance(a[k], b[turned_corner(code, k)]) <= tolerance))
      return 0;
  return 1;
}

static void find_corners(const tsi_patch *patch, double corner[4][3]) {
  size_t n0 = (size_t)patch->n[0], n = n0 * (size_t)patch->n[1];
  size_t at[4] = {0, n0 - 1, n - 1, n - n0};
  for (int k = 0; k < 4; k++)
    tsi_project_point(patch->control + 4 * at[k], corner[k]);
}

/* a and b whole, in the first orientation that makes them one surface. 0: no memory. */
static int match_whole(tsi_arena *arena, const tsi_patch *a, const tsi_patch *b, double tolerance,
                       tsi_contact *contact, int *found) {
  double corner[2][4][3];
  find_corners(a, corner[0]);
  find_corners(b, corner[1]);
  *found = 0;
  for (int code = 0; code < 8 && !*found; code++) {
    tsi_patch turned;
    comparison result = {.exact = 0};
    if (!corners_fit(corner[0], corner[1], code, tolerance))
      continue;
    if (!tsi_patch_turn(arena, b, code, &turned) ||
        !compare_patches(arena, a, &turned, tolerance, &result, found))
      return 0;
    if (!*found)
      continue;
    contact->view.code = code;
    contact->view.deviation = result.deviation;
    contact->view.kind = result.exact ? TSOLID_CONTACT_EXACT : TSOLID_CONTACT_GEOMETRIC;
    for (int d = 0; d < 2; d++) { /* from the turned patch's directions to b's own */
      double c = result.moebius[code & 4 ? 1 - d : d];
      contact->view.moebius[d] = code >> d & 1 ? 1.0 / c : c;
    }
  }
  return 1;
}

/* ---- rectangles --------------------------------------------------------------------------------
 */

/* The knots of direction d with both ends of the interval `degree` times. NULL: no memory. */
static double *knots_with_ends(tsi_arena *arena, const tsi_patch *patch, int d, const double end[2],
                               int *n_knots) {
  int p = patch->degree[d], n = patch->n[d] + p + 1, count = 0, k = 0;
  double *to = tsi_arena_new(arena, (size_t)(n + 2 * p), sizeof *to);
  for (int i = 0; to && i < n; i++) {
    for (; k < 2 && end[k] <= patch->knots[d][i]; k++) {
      int has = 0;
      while (i + has < n && patch->knots[d][i + has] == end[k])
        has++;
      for (; has < p && end[k] > 0.0 && end[k] < 1.0; has++)
        to[count++] = end[k];
    }
    to[count++] = patch->knots[d][i];
  }
  *n_knots = count;
  return to;
}

/* Between two knots of multiplicity `degree`: control points first .. last stay. */
static int cut_out(tsi_arena *arena, tsi_patch *patch, int d, int first, int last,
                   const double end[2]) {
  int p = patch->degree[d], n[2] = {patch->n[0], patch->n[1]};
  n[d] = last - first + 1;
  double *knots = tsi_arena_new(arena, (size_t)(n[d] + p + 1), sizeof *knots);
  double *control = tsi_arena_new(arena, (size_t)n[0] * (size_t)n[1], 4 * sizeof *control);
  if (!knots || !control)
    return 0;
  for (int i = 0; i < n[d] + p + 1; i++)
    knots[i] = i <= p      ? 0.0
               : i >= n[d] ? 1.0
                           : (patch->knots[d][first + i] - end[0]) / (end[1] - end[0]);
  for (int j = 0; j < n[1]; j++)
    for (int i = 0; i < n[0]; i++) {
      int u = d ? i : first + i, v = d ? first + j : j;
      memcpy(control + 4 * ((size_t)i + (size_t)n[0] * (size_t)j),
             patch->control + 4 * ((size_t)u + (size_t)patch->n[0] * (size_t)v),
             4 * sizeof *control);
    }
  patch->n[d] = n[d];
  patch->knots[d] = knots;
  patch->control = control;
  return 1;
}

int tsi_patch_restrict(tsi_arena *arena, const tsi_patch *from, const double box[4],
                       tsi_patch *patch) {
  if (!copy_patch(arena, from, patch))
    return 0;
  for (int d = 0; d < 2; d++) {
    const double *end = box + 2 * d;
    int p = patch->degree[d], n_knots, first = 0, last;
    if (end[0] == 0.0 && end[1] == 1.0)
      continue;
    double *to = knots_with_ends(arena, patch, d, end, &n_knots);
    if (!to || !tsi_patch_refine(arena, patch, d, 0, n_knots - p - 1, to))
      return 0;
    while (to[first + 1] < end[0])
      first++;
    for (last = first; last + 1 < patch->n[d] && to[last + 1] < end[1];)
      last++;
    if (!cut_out(arena, patch, d, first, last, end))
      return 0;
  }
  return 1;
}

/* A clean number where one is near: both sides of a cut should say the same. */
static double tidy(double x) {
  double fine = ldexp(round(ldexp(x, 20)), -20);
  return fabs(x - fine) < 1e-10 ? fine : x;
}

/* Samples of border e of b that lie on a between parameters low and high: bounds of their feet.
 * Returns how many; *first and *last are the interval in which samples were in a's box. */
static int sample_border(const tsi_skin *a, const tsi_skin *b, int e, double tolerance,
                         double interval[2], double low[2], double high[2]) {
  int n = 0;
  double begin = interval[0], width = interval[1] - interval[0], seen[2] = {2.0, -1.0};
  for (int d = 0; d < 2; d++) {
    low[d] = 2.0;
    high[d] = -1.0;
  }
  for (int i = 0; i < N_SAMPLES; i++) {
    double x = begin + width * i / (N_SAMPLES - 1), uv[2], point[3];
    tsi_foot foot;
    tsi_border_point(e, x, uv);
    tsi_skin_point(b, uv[0], uv[1], point);
    if (!tsi_in_box(a->box, point, tolerance))
      continue;
    seen[0] = fmin(seen[0], x - width / (N_SAMPLES - 1));
    seen[1] = fmax(seen[1], x + width / (N_SAMPLES - 1));
    tsi_foot_find(a, point, NULL, &foot);
    if (foot.distance > tolerance)
      continue;
    n++;
    for (int d = 0; d < 2; d++) {
      low[d] = fmin(low[d], foot.uv[d]);
      high[d] = fmax(high[d], foot.uv[d]);
    }
  }
  interval[0] = fmax(interval[0], seen[0]);
  interval[1] = fmin(interval[1], seen[1]);
  return n;
}

typedef struct cuts {
  int n[2];
  double at[2][MOST_CUTS];
} cuts;

/* Isolines of a that borders of b run along. */
static void find_cuts(const tsi_skin *a, const tsi_skin *b, double tolerance, cuts *cut) {
  cut->n[0] = cut->n[1] = 0;
  for (int e = 0; e < 4; e++) {
    double interval[2] = {0.0, 1.0}, low[2], high[2];
    int n = 0;
    for (int round = 0; round < 3 && n < 3 && interval[0] < interval[1]; round++)
      n = sample_border(a, b, e, tolerance, interval, low, high);
    if (n < 2)
      continue;
    for (int d = 0; d < 2; d++) {
      double at = tidy(0.5 * (low[d] + high[d]));
      if (high[d] - low[d] > straightness || high[1 - d] - low[1 - d] <= straightness ||
          at < straightness || at > 1.0 - straightness || cut->n[d] == MOST_CUTS)
        continue;
      cut->at[d][cut->n[d]++] = at;
    }
  }
  for (int d = 0; d < 2; d++) { /* at most two differ */
    if (cut->n[d] < 2)
      continue;
    double *x = cut->at[d], least = x[0], most = x[0];
    for (int i = 1; i < cut->n[d]; i++) {
      least = fmin(least, x[i]);
      most = fmax(most, x[i]);
    }
    cut->n[d] = most - least > straightness ? 2 : 1;
    x[0] = least;
    x[1] = most;
  }
}

/* The intervals that cuts leave to choose from. */
static int list_intervals(int n, const double *at, double interval[2][2]) {
  interval[0][0] = n == 2 ? at[0] : 0.0;
  interval[0][1] = n == 2 ? at[1] : n == 1 ? at[0] : 1.0;
  interval[1][0] = n == 1 ? at[0] : 0.0;
  interval[1][1] = 1.0;
  return n == 1 ? 2 : 1;
}

/* The foot of a rectangle's corner. `walk`: along the way from the middle, so that it is on the
 * same sheet where b passes there twice (the border that b has in common with a, say). */
static void find_corner_foot(const tsi_skin *a, const tsi_skin *b, const double box[4], int k,
                             int walk, tsi_foot *foot) {
  double x[3], end[2] = {box[k == 1 || k == 2], box[2 + (k >= 2)]};
  double middle[2] = {0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3])};
  for (int i = walk ? 0 : N_STEPS; i <= N_STEPS; i++) {
    double at = (double)i / N_STEPS;
    tsi_skin_point(a, middle[0] + at * (end[0] - middle[0]), middle[1] + at * (end[1] - middle[1]),
                   x);
    double near[2] = {foot->uv[0], foot->uv[1]};
    tsi_foot_find(b, x, walk && i ? near : NULL, foot);
  }
}

/* The rectangle of b with the same corners. */
static int find_box_by(const tsi_skin *a, const tsi_skin *b, const double box[4], double tolerance,
                       int walk, double other[4]) {
  double uv[4][2];
  for (int k = 0; k < 4; k++) {
    tsi_foot foot = {.distance = 0.0};
    find_corner_foot(a, b, box, k, walk, &foot);
    if (foot.distance > tolerance)
      return 0;
    memcpy(uv[k], foot.uv, sizeof uv[k]);
  }
  for (int d = 0; d < 2; d++) {
    double low = fmin(fmin(uv[0][d], uv[1][d]), fmin(uv[2][d], uv[3][d]));
    double high = fmax(fmax(uv[0][d], uv[1][d]), fmax(uv[2][d], uv[3][d]));
    int n_low = 0, n_high = 0;
    for (int k = 0; k < 4; k++) {
      n_low += uv[k][d] <= low + straightness;
      n_high += uv[k][d] >= high - straightness;
    }
    if (n_low != 2 || n_high != 2)
      return 0;
    other[2 * d] = low < straightness ? 0.0 : tidy(low);
    other[2 * d + 1] = high > 1.0 - straightness ? 1.0 : tidy(high);
  }
  return 1;
}

static int find_other_box(const tsi_skin *a, const tsi_skin *b, const double box[4],
                          double tolerance, double other[4]) {
  return find_box_by(a, b, box, tolerance, 0, other) || find_box_by(a, b, box, tolerance, 1, other);
}

/* On a knot of the patch where one is near. */
static void snap_box(const tsi_patch *patch, double box[4]) {
  for (int k = 0; k < 4; k++)
    for (int i = 0; i < patch->n[k / 2] + patch->degree[k / 2] + 1; i++)
      if (fabs(patch->knots[k / 2][i] - box[k]) <= knot_resolution)
        box[k] = patch->knots[k / 2][i];
}

static int match_boxes(tsi_arena *arena, const tsi_skin *a, const tsi_skin *b, double box[2][4],
                       double tolerance, tsi_contact *contact, int *found) {
  tsi_patch part[2];
  const tsi_skin *skin[2] = {a, b};
  for (int k = 0; k < 2; k++)
    if (!tsi_patch_restrict(arena, &skin[k]->patch, box[k], &part[k]))
      return 0;
  if (!match_whole(arena, &part[0], &part[1], tolerance, contact, found))
    return 0;
  if (*found) {
    contact->view.kind = TSOLID_CONTACT_PARTIAL;
    memcpy(contact->view.box, box, sizeof contact->view.box);
  }
  return 1;
}

static int match_part(tsi_arena *arena, const tsi_skin *a, const tsi_skin *b, double tolerance,
                      tsi_contact *contact, int *found) {
  cuts cut;
  double choice[2][2][2];
  int n[2];
  find_cuts(a, b, tolerance, &cut);
  for (int d = 0; d < 2; d++)
    n[d] = list_intervals(cut.n[d], cut.at[d], choice[d]);
  for (int k = 0; k < n[0] * n[1] && !*found; k++) {
    const double *u = choice[0][k % n[0]], *v = choice[1][k / n[0]];
    double box[2][4] = {{u[0], u[1], v[0], v[1]}, {0.0, 0.0, 0.0, 0.0}}, x[3];
    tsi_foot foot;
    tsi_skin_point(a, 0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]), x);
    if (!tsi_in_box(b->box, x, tolerance))
      continue;
    tsi_foot_find(b, x, NULL, &foot);
    if (foot.distance > tolerance || !find_other_box(a, b, box[0], tolerance, box[1]))
      continue;
    snap_box(&a->patch, box[0]);
    snap_box(&b->patch, box[1]);
    if (!match_boxes(arena, a, b, box, tolerance, contact, found))
      return 0;
  }
  return 1;
}

/* ---- several rectangles ------------------------------------------------------------------------
 */

typedef struct cell_grid {
  int n[2]; /* cells */
  double *line[2];
  unsigned char *on;
} cell_grid;

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* The patch's knots and the cuts, each once. 0: no memory. */
static int list_lines(tsi_arena *arena, const tsi_patch *patch, int d, const cuts *cut,
                      cell_grid *grid) {
  int n = patch->n[d] + patch->degree[d] + 1, m = 0;
  double *line = tsi_arena_new(arena, (size_t)(n + cut->n[d]), sizeof *line);
  if (!line)
    return 0;
  memcpy(line, patch->knots[d], (size_t)n * sizeof *line);
  memcpy(line + n, cut->at[d], (size_t)cut->n[d] * sizeof *line);
  n += cut->n[d];
  qsort(line, (size_t)n, sizeof *line, compare_doubles);
  for (int i = 0; i < n; i++)
    if (m == 0 || line[i] - line[m - 1] > knot_resolution)
      line[m++] = line[i];
  line[m - 1] = 1.0;
  grid->line[d] = line;
  grid->n[d] = m - 1;
  return 1;
}

/* By nine points, the middle first. */
static int cell_lies_on(const tsi_skin *from, const tsi_skin *to, const double cell[4],
                        double tolerance) {
  static const double at[3] = {0.5, 0.05, 0.95};
  for (int k = 0; k < 9; k++) {
    double x[3];
    tsi_foot foot;
    tsi_skin_point(from, cell[0] + at[k % 3] * (cell[1] - cell[0]),
                   cell[2] + at[k / 3] * (cell[3] - cell[2]), x);
    if (!tsi_in_box(to->box, x, tolerance))
      return 0;
    tsi_foot_find(to, x, NULL, &foot);
    if (foot.distance > tolerance)
      return 0;
  }
  return 1;
}

/* 0: no memory. grid->on NULL: too many cells. */
static int find_cells(tsi_arena *arena, const tsi_skin *from, const tsi_skin *to, double tolerance,
                      cell_grid *grid) {
  cuts cut;
  find_cuts(from, to, tolerance, &cut);
  grid->on = NULL;
  for (int d = 0; d < 2; d++)
    if (!list_lines(arena, &from->patch, d, &cut, grid))
      return 0;
  if ((double)grid->n[0] * grid->n[1] > MOST_CELLS)
    return 1;
  grid->on = tsi_arena_new(arena, (size_t)grid->n[0] * (size_t)grid->n[1], 1);
  for (int k = 0; grid->on && k < grid->n[0] * grid->n[1]; k++) {
    const double *u = grid->line[0] + k % grid->n[0], *v = grid->line[1] + k / grid->n[0];
    double cell[4] = {u[0], u[1], v[0], v[1]};
    grid->on[k] = (unsigned char)cell_lies_on(from, to, cell, tolerance);
  }
  return grid->on != NULL;
}

/* Takes a rectangle of cells that lie on the other patch, as long as it can be, then as wide. */
static int take_rectangle(cell_grid *grid, double box[4]) {
  int first = 0, n0 = grid->n[0], n1 = grid->n[1], n = n0 * n1, wide = 1, high = 1, full = 1;
  while (first < n && !grid->on[first])
    first++;
  if (first == n)
    return 0;
  int i = first % n0, j = first / n0;
  while (i + wide < n0 && grid->on[first + wide])
    wide++;
  while (full && j + high < n1) {
    for (int k = 0; k < wide; k++)
      full &= grid->on[first + high * n0 + k];
    high += full;
  }
  for (int k = 0; k < wide * high; k++)
    grid->on[first + k / wide * n0 + k % wide] = 0;
  box[0] = grid->line[0][i];
  box[1] = grid->line[0][i + wide];
  box[2] = grid->line[1][j];
  box[3] = grid->line[1][j + high];
  return 1;
}

/* Rectangles of a, else of b. 0: no memory. */
static int match_pieces(tsi_arena *arena, const tsi_skin *a, const tsi_skin *b, double tolerance,
                        tsi_contact *contact, int *n_found) {
  tsi_contact plain = contact[0];
  for (int side = 0; side < 2 && !*n_found; side++) {
    const tsi_skin *from = side ? b : a, *to = side ? a : b;
    cell_grid grid;
    double box[2][4];
    if (!find_cells(arena, from, to, tolerance, &grid))
      return 0;
    while (*n_found < TSI_MOST_RECTANGLES && grid.on && take_rectangle(&grid, box[side])) {
      int found = 0;
      if (!find_other_box(from, to, box[side], tolerance, box[1 - side]))
        continue;
      snap_box(&to->patch, box[1 - side]);
      contact[*n_found] = plain;
      if (!match_boxes(arena, a, b, box, tolerance, &contact[*n_found], &found))
        return 0;
      *n_found += found;
    }
  }
  return 1;
}

/* ---- driver ------------------------------------------------------------------------------------
 */

/* A contact has an area: the boxes meet in more than a line. */
static int boxes_meet(const tsi_skin *a, const tsi_skin *b, double tolerance) {
  int wide = 0;
  for (int c = 0; c < 3; c++) {
    double low = fmax(a->box[c], b->box[c]), high = fmin(a->box[3 + c], b->box[3 + c]);
    if (low > high + tolerance)
      return 0;
    wide += high - low > 4.0 * tolerance;
  }
  return wide >= 2;
}

tsolid_status tsi_match_skins(tsolid_context *context, const tsolid_assembly *assembly, int a,
                              int b, tsi_contact *contact, int *n_found) {
  const tsi_skin *p = &assembly->skin[a], *q = &assembly->skin[b];
  double tolerance = fmax(p->tolerance, q->tolerance);
  tsi_arena work = tsi_arena_create(context);
  *contact = (tsi_contact){.skin = {a, b}};
  contact->view = (tsolid_interface){.part = {p->part, q->part},
                                     .patch = {p->number, q->number},
                                     .box = {{0.0, 1.0, 0.0, 1.0}, {0.0, 1.0, 0.0, 1.0}},
                                     .moebius = {1.0, 1.0},
                                     .deviation = (double)NAN,
                                     .same_functions = -1,
                                     .same_bits = -1,
                                     .gap_after = (double)NAN,
                                     .ulp_after = (double)NAN,
                                     .continuity = {-1, -1}};
  *n_found = 0;
  if (!boxes_meet(p, q, tolerance))
    return TSOLID_OK;
  int done = match_whole(&work, &p->patch, &q->patch, tolerance, contact, n_found);
  if (done && !*n_found && tsi_skin_angle(p, q) == 0.0) {
    done = match_part(&work, p, q, tolerance, contact, n_found);
    if (done && !*n_found)
      done = match_pieces(&work, p, q, tolerance, contact, n_found);
  }
  tsi_arena_free(&work);
  return done ? TSOLID_OK : tsi_no_memory(context, stage);
}
