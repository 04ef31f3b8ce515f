/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The input's own bound on the scaled Jacobian.
 *
 * At a boundary point let n_i be the product of the unit tangents along s and t of the one, two or
 * three sides that meet there, pointing inward. An element of the arm over side i has these
 * tangents and a third unit vector d, the direction of r, so its scaled Jacobian there is n_i . d.
 * On an isoline the two arms, at a corner the three, share d: they are glued along the diagonal.
 * Hence no solid with these layers is better at this point than
 *
 *     max over |d| = 1 of min_i n_i . d = distance of the origin from the convex hull of the n_i
 *
 * (minimax: min over the hull and max over the ball exchange), and no solid is valid at a point
 * where the hull contains the origin. A flat side has 1, a right-angled edge 1/sqrt 2, the corner
 * of a cube 1/sqrt 3 (tests/test_quality.c). The bound is taken at points: corners, 25 per common
 * span of the two sides of an isoline, a 7 x 7 grid and (p+1)(q+1) Gauss points per Bezier element
 * of a side. */
#include "boundary_bound.h"

#include <stdlib.h>

#include "evaluate.h"
#include "quadrature.h"
#include "vector.h"

enum { ISOLINE_SAMPLES = 25, GRID = 7 };

/* ---- hulls -------------------------------------------------------------------------------------
 */

static void subtract(const double a[3], const double b[3], double c[3]) {
  for (int i = 0; i < 3; i++)
    c[i] = a[i] - b[i];
}

static double norm(const double a[3]) {
  return sqrt(tsi_dot3(a, a));
}

static double segment_distance(const double a[3], const double b[3]) {
  double d[3], p[3];
  subtract(b, a, d);
  double length = tsi_dot3(d, d), t = length > 0.0 ? -tsi_dot3(a, d) / length : 0.0;
  t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
  for (int i = 0; i < 3; i++)
    p[i] = (1.0 - t) * a[i] + t * b[i];
  return norm(p);
}

/* The foot of the origin on the plane, where it lies inside; else one of the borders is nearest. */
static double triangle_distance(const double (*v)[3]) {
  double distance = segment_distance(v[0], v[1]), ab[3], ac[3], n[3];
  distance = fmin(distance, segment_distance(v[1], v[2]));
  distance = fmin(distance, segment_distance(v[2], v[0]));
  subtract(v[1], v[0], ab);
  subtract(v[2], v[0], ac);
  tsi_cross3(ab, ac, n);
  double area = tsi_dot3(n, n);
  if (!(area > 0.0))
    return distance;
  int inside = 1;
  for (int i = 0; i < 3; i++) {
    double edge[3], m[3];
    subtract(v[(i + 1) % 3], v[i], edge);
    tsi_cross3(edge, v[i], m); /* -edge x (0 - v): hence <= */
    inside = inside && tsi_dot3(m, n) <= 0.0;
  }
  return inside ? fmin(distance, fabs(tsi_dot3(v[0], n)) / sqrt(area)) : distance;
}

double tsi_hull_distance(int n, const double (*vector)[3]) {
  return n == 1   ? norm(vector[0])
         : n == 2 ? segment_distance(vector[0], vector[1])
                  : triangle_distance(vector);
}

/* ---- tangents of a side -------------------------------------------------------------------------
 */

void tsi_net_load(const tsolid_boundary *boundary, int side, int element, tsi_patch_net *net) {
  const tsi_side *s = &boundary->side[side];
  size_t n = (size_t)(s->degree[0] + 1) * (size_t)(s->degree[1] + 1);
  net->side = side;
  net->degree[0] = s->degree[0];
  net->degree[1] = s->degree[1];
  net->degree[2] = 0;
  memset(net->point, 0, 4 * n * sizeof *net->point);
  for (int f = s->function_start[element]; f < s->function_start[element + 1]; f++)
    for (size_t k = 0; k < n; k++)
      for (int c = 0; c < 4; c++)
        net->point[4 * k + (size_t)c] += s->coefficient[(size_t)f * n + k] *
                                         boundary->points[4 * (size_t)s->function[f] + (size_t)c];
  net->size = 0.0;
  for (int c = 0; c < 3; c++) {
    double low = INFINITY, high = -INFINITY;
    for (size_t k = 0; k < n; k++) {
      double x = net->point[4 * k + (size_t)c] / net->point[4 * k + 3];
      low = fmin(low, x);
      high = fmax(high, x);
    }
    net->size = fmax(net->size, high - low);
  }
}

/* Normalises; a tangent that is short beside the element is none. */
static void make_unit(double v[3], double size) {
  double length = norm(v);
  int none = !(length > TSI_SINGULAR_TOLERANCE * size);
  for (int i = 0; i < 3; i++)
    v[i] = none ? 0.0 : v[i] / length;
}

double tsi_net_normal(const tsi_patch_net *net, double x, double y, double point[3],
                      double normal[3]) {
  double h[16], e[12];
  const double local[3] = {x, y, 0.0};
  tsi_bezier_evaluate(net->degree, net->point, 4, local, 1, h);
  tsi_project(1, h, e);
  double leg = fmin(norm(e + 3) / net->degree[0], norm(e + 6) / net->degree[1]);
  make_unit(e + 3, net->size);
  make_unit(e + 6, net->size);
  tsi_cross3(e + 3, e + 6, normal);
  int turned = (tsi_side_axis(net->side) == 1) != (net->side & 1);
  for (int i = 0; i < 3; i++) {
    point[i] = e[i];
    normal[i] = turned ? -normal[i] : normal[i];
  }
  return leg;
}

/* ---- corners ------------------------------------------------------------------------------------
 */

static int element_at(const tsi_side *side, double s, double t) {
  for (int e = 0; e < side->n_elements; e++) {
    const double *b = side->box + 4 * (size_t)e;
    if (b[0] <= s && s <= b[1] && b[2] <= t && t <= b[3])
      return e;
  }
  return -1;
}

static void find_singular(tsi_corner *c) {
  int any = 0;
  for (int i = 0; i < 3; i++) {
    double sine = norm(c->normal[i]);
    c->singular[i] = sine <= c->tolerance;
    any |= c->singular[i];
    c->sine = fmax(c->sine, c->singular[i] ? sine : 0.0);
  }
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3;
    double sine = segment_distance(c->normal[i], c->normal[j]);
    if (c->singular[i] || c->singular[j] || sine > c->tolerance)
      continue;
    c->singular[i] = c->singular[j] = any = 1;
    c->sine = fmax(c->sine, sine);
  }
  if (!any && c->bound <= c->tolerance) {
    c->singular[0] = c->singular[1] = c->singular[2] = 1;
    c->sine = c->bound;
  }
}

void tsi_corner_measure(const tsolid_boundary *boundary, int corner, tsi_corner *result) {
  double leg = INFINITY;
  memset(result, 0, sizeof *result);
  for (int axis = 0; axis < 3; axis++) {
    int side = 2 * axis + (corner >> axis & 1);
    double s = corner >> tsi_side_s(side) & 1, t = corner >> tsi_side_t(side) & 1;
    int e = element_at(&boundary->side[side], s, t);
    if (e < 0)
      continue;
    tsi_patch_net net;
    tsi_net_load(boundary, side, e, &net);
    leg = fmin(leg, tsi_net_normal(&net, s, t, result->point, result->normal[axis]));
  }
  result->tolerance = tsi_singular_tolerance(boundary->scale, leg);
  result->bound = tsi_hull_distance(3, (const double(*)[3])result->normal);
  find_singular(result);
}

int tsi_singular_corners(const tsolid_space *space, const tsi_corner corners[8], int element) {
  const tsi_element *e = &space->element[element];
  int bits = 0;
  if (e->block == 0)
    return 0;
  int side = e->block - 1, axis = tsi_side_axis(side), end = side & 1;
  double height = space->tmesh->arm_height[side];
  double outer = end ? 1.0 + height : -height;
  for (int corner = 0; corner < 8; corner++) {
    int touches = (corner >> axis & 1) == end;
    for (int d = 0; d < 3; d++) {
      int upper = corner >> d & 1;
      double u = e->box[upper ? 3 + d : d];
      touches = touches && (d == axis ? fabs(u - outer) <= 1e-9 * height : u == (double)upper);
    }
    if (touches && corners[corner].singular[axis])
      bits |= 1 << corner;
  }
  return bits;
}

/* ---- the smallest bound
 * -------------------------------------------------------------------------- */

typedef struct best {
  double bound, point[3];
} best;

static void take(best *b, double bound, const double point[3]) {
  if (!(bound >= b->bound)) {
    b->bound = bound;
    memcpy(b->point, point, sizeof b->point);
  }
}

static void bound_side(const tsolid_boundary *boundary, int side, best *b) {
  const tsi_side *s = &boundary->side[side];
  double node[2][GRID + TSI_MAX_ORDER], weight[TSI_MAX_ORDER], point[3], normal[3];
  int n[2];
  for (int d = 0; d < 2; d++) {
    for (int i = 0; i < GRID; i++)
      node[d][i] = (double)i / (GRID - 1);
    tsi_gauss(s->degree[d] + 1, node[d] + GRID, weight);
    n[d] = GRID + s->degree[d] + 1;
  }
  tsi_patch_net net;
  for (int e = 0; e < s->n_elements; e++) {
    tsi_net_load(boundary, side, e, &net);
    for (int j = 0; j < n[1]; j++)
      for (int i = 0; i < n[0]; i++) {
        if ((i < GRID) != (j < GRID))
          continue;
        tsi_net_normal(&net, node[0][i], node[1][j], point, normal);
        take(b, norm(normal), point);
      }
  }
}

/* An element of a side along an isoline. */
typedef struct border_element {
  double lo, hi;
  int element;
} border_element;

static int compare_borders(const void *a, const void *b) {
  const border_element *x = a, *y = b;
  return x->lo < y->lo ? -1 : x->lo > y->lo;
}

/* Elements of `side` along the isoline of `axis` where the other parameter is `end`, ascending. */
static int collect_border(const tsi_side *s, int side, int axis, int end, border_element *list) {
  int along = tsi_side_s(side) == axis ? 0 : 1, n = 0;
  for (int e = 0; e < s->n_elements; e++) {
    const double *b = s->box + 4 * (size_t)e, *across = b + 2 * (1 - along);
    if (end ? across[1] >= 1.0 : across[0] <= 0.0)
      list[n++] = (border_element){b[2 * along], b[2 * along + 1], e};
  }
  qsort(list, (size_t)n, sizeof *list, compare_borders);
  return n;
}

/* n of one side at parameter u of the isoline, from the given element. */
static void border_normal(const tsi_patch_net *net, const border_element *b, int axis, int end,
                          double u, double point[3], double normal[3]) {
  double x = (u - b->lo) / (b->hi - b->lo), y = (double)end;
  x = x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x;
  if (tsi_side_s(net->side) == axis)
    tsi_net_normal(net, x, y, point, normal);
  else
    tsi_net_normal(net, y, x, point, normal);
}

static void bound_isoline(const tsolid_boundary *boundary, int isoline, border_element *list[2],
                          best *b) {
  int axis = isoline / 4, n[2], at[2] = {0, 0}, end[2], side[2];
  int other[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
  tsi_patch_net net[2];
  for (int i = 0; i < 2; i++) {
    side[i] = 2 * other[i] + (isoline >> i & 1);
    end[i] = isoline >> (1 - i) & 1; /* on this side the isoline lies at the other axis' end */
    n[i] = collect_border(&boundary->side[side[i]], side[i], axis, end[i], list[i]);
    if (n[i] > 0)
      tsi_net_load(boundary, side[i], list[i][0].element, &net[i]);
  }
  while (at[0] < n[0] && at[1] < n[1]) {
    const border_element *e[2] = {&list[0][at[0]], &list[1][at[1]]};
    double lo = fmax(e[0]->lo, e[1]->lo), hi = fmin(e[0]->hi, e[1]->hi);
    double point[3], normal[2][3];
    for (int k = 0; lo < hi && k < ISOLINE_SAMPLES; k++) {
      double u = lo + (hi - lo) * k / (ISOLINE_SAMPLES - 1);
      for (int i = 0; i < 2; i++)
        border_normal(&net[i], e[i], axis, end[i], u, point, normal[i]);
      take(b, tsi_hull_distance(2, (const double(*)[3])normal), point);
    }
    int step[2] = {e[0]->hi <= e[1]->hi, e[1]->hi <= e[0]->hi};
    for (int i = 0; i < 2; i++)
      if (step[i] && ++at[i] < n[i])
        tsi_net_load(boundary, side[i], list[i][at[i]].element, &net[i]);
  }
}

tsolid_status tsi_boundary_bound(tsolid_context *context, const tsolid_boundary *boundary,
                                 double *bound, double point[3]) {
  best b = {INFINITY, {0.0, 0.0, 0.0}};
  double tolerance = TSI_SINGULAR_TOLERANCE;
  tsolid_status status = TSOLID_OK;
  tsi_arena arena = tsi_arena_create(context);
  size_t most = 0;
  for (int side = 0; side < 6; side++)
    if ((size_t)boundary->side[side].n_elements > most)
      most = (size_t)boundary->side[side].n_elements;
  border_element *list[2] = {tsi_arena_new(&arena, most, sizeof **list),
                             tsi_arena_new(&arena, most, sizeof **list)};
  if (!list[0] || !list[1]) {
    status = tsi_no_memory(context, "quality");
    goto done;
  }
  for (int corner = 0; corner < 8; corner++) {
    tsi_corner c;
    tsi_corner_measure(boundary, corner, &c);
    take(&b, c.bound, c.point);
    tolerance = fmax(tolerance, c.tolerance);
  }
  for (int isoline = 0; isoline < 12; isoline++)
    bound_isoline(boundary, isoline, list, &b);
  for (int side = 0; side < 6; side++)
    bound_side(boundary, side, &b);
  *bound = b.bound > tolerance ? b.bound : 0.0;
  memcpy(point, b.point, sizeof b.point);
done:
  tsi_arena_free(&arena);
  return status;
}
