/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Point inversion: Levenberg-Marquardt on the elements whose control nets' boxes hold the point;
 * where that fails (or the point is outside), branch and bound on the convex hulls of sub-nets. */
#include "bernstein.h"
#include "bvh.h"
#include "evaluate.h"

enum { MAX_STEPS = 60, MAX_BISECTIONS = 60, MAX_BOXES = 4096, NEWTON_EVERY = 3 };

/* A part of an element closer than (1 - this) * the best distance so far is looked into. */
#define DISTANCE_ACCURACY 1e-3

/* ---- boxes of nets -----------------------------------------------------------------------------
 */

static int net_size(const int degree[3]) {
  return (degree[0] + 1) * (degree[1] + 1) * (degree[2] + 1);
}

static void bound_net(int n, const double *net, double box[6]) {
  for (int c = 0; c < 3; c++) {
    box[c] = (double)INFINITY;
    box[c + 3] = -(double)INFINITY;
    for (int i = 0; i < n; i++) {
      double value = net[4 * i + c] / net[4 * i + 3];
      box[c] = fmin(box[c], value);
      box[c + 3] = fmax(box[c + 3], value);
    }
  }
}

/* Points of the largest net in the space; elements of arms have lateral degree max(3, the side's).
 */
static size_t largest_net(const tsolid_space *space) {
  size_t largest = 16;
  for (int side = 0; side < 6; side++) {
    const int *degree = space->boundary->side[side].degree;
    size_t n = 1;
    for (int k = 0; k < 2; k++)
      n *= (size_t)(degree[k] > TSI_INNER_DEGREE ? degree[k] : TSI_INNER_DEGREE) + 1;
    largest = n > largest ? n : largest;
  }
  return largest * (TSI_INNER_DEGREE + 1);
}

tsolid_status tsi_solid_index(tsolid_context *context, tsolid_solid *solid) {
  const tsolid_space *space = solid->space;
  tsolid_status status = TSOLID_ERROR_MEMORY;
  double *net = tsi_new(&context->allocator, largest_net(space), 4 * sizeof *net);
  double *box = tsi_new(&context->allocator, (size_t)space->n_elements, 6 * sizeof *box);
  if (!net || !box)
    goto done;
  for (int e = 0; e < space->n_elements; e++) {
    tsi_element_net(space, solid->control, 4, e, net);
    bound_net(net_size(space->element[e].degree), net, box + 6 * (size_t)e);
  }
  struct tsi_bvh *bvh = tsi_bvh_create(&solid->allocator, space->n_elements, box);
  if (!bvh)
    goto done;
  tsi_bvh_free(solid->physical);
  solid->physical = bvh;
  status = TSOLID_OK;
done:
  tsi_delete(&context->allocator, net);
  tsi_delete(&context->allocator, box);
  return status == TSOLID_OK ? status : tsi_no_memory(context, "solid");
}

/* ---- the nearest point of one element ----------------------------------------------------------
 */

typedef struct search {
  const tsolid_solid *solid;
  double point[3], tolerance;
  double *net, *part; /* of the element looked at, and of a part of it */
  double best;        /* distance */
  int element;
  double x[3];
} search;

/* Solves the n x n (n <= 3) positive definite system in place; 0: singular. */
static int solve_small(int n, double a[3][3], double b[3]) {
  for (int k = 0; k < n; k++) {
    if (!(a[k][k] > 0.0))
      return 0;
    for (int i = k + 1; i < n; i++) {
      double factor = a[i][k] / a[k][k];
      for (int j = k; j < n; j++)
        a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (int k = n - 1; k >= 0; k--) {
    for (int j = k + 1; j < n; j++)
      b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return 1;
}

typedef struct probe {
  double x[3], distance;
  double residual[3];    /* x(u) - point */
  double jacobian[3][3]; /* row d: derivative by x[d] */
} probe;

static void probe_at(const search *s, const int degree[3], const double x[3], probe *at) {
  double homogeneous[4][4], euclidean[4][3];
  tsi_bezier_evaluate(degree, s->net, 4, x, 1, homogeneous[0]);
  tsi_project(1, homogeneous[0], euclidean[0]);
  memcpy(at->x, x, sizeof at->x);
  memcpy(at->jacobian, euclidean[1], sizeof at->jacobian);
  double sum = 0.0;
  for (int c = 0; c < 3; c++) {
    at->residual[c] = euclidean[0][c] - s->point[c];
    sum += at->residual[c] * at->residual[c];
  }
  at->distance = sqrt(sum);
}

/* A damped Gauss-Newton step in the directions that the box leaves free; 0: none. */
static int propose(const probe *at, double damping, double target[3]) {
  double a[3][3], b[3], gradient[3];
  int free_direction[3], n = 0;
  for (int d = 0; d < 3; d++) {
    gradient[d] = 0.0;
    for (int c = 0; c < 3; c++)
      gradient[d] += at->jacobian[d][c] * at->residual[c];
    if (!(at->x[d] <= 0.0 && gradient[d] >= 0.0) && !(at->x[d] >= 1.0 && gradient[d] <= 0.0))
      free_direction[n++] = d;
  }
  for (int i = 0; i < n; i++) {
    b[i] = -gradient[free_direction[i]];
    for (int j = 0; j < n; j++) {
      a[i][j] = 0.0;
      for (int c = 0; c < 3; c++)
        a[i][j] += at->jacobian[free_direction[i]][c] * at->jacobian[free_direction[j]][c];
    }
    a[i][i] *= 1.0 + damping;
  }
  if (n == 0 || !solve_small(n, a, b))
    return 0;
  memcpy(target, at->x, 3 * sizeof *target);
  int moved = 0;
  for (int i = 0; i < n; i++) {
    double *x = &target[free_direction[i]], to = fmin(fmax(*x + b[i], 0.0), 1.0);
    moved |= to != *x;
    *x = to;
  }
  return moved;
}

/* Descends from x to a local minimum of the distance; goes on to round-off when it is zero. */
static void descend(search *s, int element, const double start[3]) {
  const int *degree = s->solid->space->element[element].degree;
  probe at, next;
  double damping = 0.0, target[3];
  probe_at(s, degree, start, &at);
  for (int step = 0; step < MAX_STEPS && propose(&at, damping, target); step++) {
    probe_at(s, degree, target, &next);
    if (next.distance < at.distance) {
      int settled = at.distance > s->tolerance && next.distance > at.distance * (1.0 - 1e-12);
      at = next;
      damping = damping < 1e-6 ? 0.0 : 0.1 * damping;
      if (settled)
        break;
    } else if (at.distance <= s->tolerance || damping > 1e12) {
      break;
    } else {
      damping = damping > 0.0 ? 10.0 * damping : 1e-3;
    }
  }
  if (at.distance < s->best) {
    s->best = at.distance;
    s->element = element;
    memcpy(s->x, at.x, sizeof s->x);
  }
}

/* ---- branch and bound --------------------------------------------------------------------------
 */

static void restrict_net(const int degree[3], const double range[6], double *net) {
  int n[3] = {degree[0] + 1, degree[1] + 1, degree[2] + 1};
  int stride[3] = {1, n[0], n[0] * n[1]};
  for (int d = 0; d < 3; d++) {
    int e = (d + 1) % 3, f = (d + 2) % 3;
    for (int i = 0; i < n[e]; i++)
      for (int j = 0; j < n[f]; j++)
        for (int c = 0; c < 4; c++)
          tsi_bernstein_restrict(degree[d], range[d], range[d + 3],
                                 net + 4 * (i * stride[e] + j * stride[f]) + c, 4 * stride[d]);
  }
}

static double distance_to_box(const double box[6], const double point[3]) {
  double sum = 0.0;
  for (int d = 0; d < 3; d++) {
    double out = fmax(fmax(box[d] - point[d], point[d] - box[d + 3]), 0.0);
    sum += out * out;
  }
  return sqrt(sum);
}

/* A lower bound of the distance to the net's convex hull: to its box, or to its nearest plane
 * normal to the line from the mean control point (second order in the size of the part). */
static double distance_to_hull(int n, const double *net, const double point[3]) {
  double box[6], mean[3] = {0.0, 0.0, 0.0}, normal[3], length = 0.0;
  bound_net(n, net, box);
  for (int i = 0; i < n; i++)
    for (int c = 0; c < 3; c++)
      mean[c] += net[4 * i + c] / net[4 * i + 3] / n;
  for (int c = 0; c < 3; c++) {
    normal[c] = point[c] - mean[c];
    length += normal[c] * normal[c];
  }
  double nearest = length > 0.0 ? (double)INFINITY : 0.0;
  for (int i = 0; i < n && length > 0.0; i++) {
    double height = 0.0;
    for (int c = 0; c < 3; c++)
      height += normal[c] * (point[c] - net[4 * i + c] / net[4 * i + 3]);
    nearest = fmin(nearest, height / sqrt(length));
  }
  return fmax(nearest, distance_to_box(box, point));
}

/* The direction in which the part's control net is longest. */
static int longest_direction(const int degree[3], const double *net) {
  int n[3] = {degree[0] + 1, degree[1] + 1, degree[2] + 1};
  int stride[3] = {1, n[0], n[0] * n[1]}, longest = 0;
  double largest = -1.0;
  for (int d = 0; d < 3; d++) {
    double length2 = 0.0;
    for (int i = 0; i < net_size(degree); i++) {
      if (i / stride[d] % n[d] == degree[d])
        continue;
      const double *p = net + 4 * i, *q = p + 4 * stride[d];
      for (int c = 0; c < 3; c++) {
        double step = q[c] / q[3] - p[c] / p[3];
        length2 += step * step;
      }
    }
    length2 *= (double)degree[d] * (double)n[d]; /* (sum of steps)^2 per line, up to a constant */
    if (length2 > largest) {
      largest = length2;
      longest = d;
    }
  }
  return longest;
}

typedef struct part {
  double range[6];
  int depth;
} part;

/* Looks for a point of the element closer than the best: parts whose hulls are too far are out. */
static void search_element(search *s, int element) {
  const int *degree = s->solid->space->element[element].degree;
  size_t n = (size_t)net_size(degree);
  part stack[MAX_BISECTIONS + 2];
  int n_stack = 0;
  stack[n_stack++] = (part){.range = {0, 0, 0, 1, 1, 1}, .depth = 0};
  for (int count = 0; count < MAX_BOXES && n_stack > 0 && s->best > s->tolerance; count++) {
    part now = stack[--n_stack];
    double centre[3];
    memcpy(s->part, s->net, 4 * n * sizeof *s->part);
    restrict_net(degree, now.range, s->part);
    if (distance_to_hull((int)n, s->part, s->point) >= (1.0 - DISTANCE_ACCURACY) * s->best)
      continue;
    for (int d = 0; d < 3; d++)
      centre[d] = 0.5 * (now.range[d] + now.range[d + 3]);
    if (now.depth % NEWTON_EVERY == 0)
      descend(s, element, centre);
    if (now.depth >= MAX_BISECTIONS)
      continue;
    int d = longest_direction(degree, s->part);
    now.depth++;
    part half = now;
    half.range[d + 3] = centre[d];
    now.range[d] = centre[d];
    stack[n_stack++] = now;
    stack[n_stack++] = half;
  }
}

/* ---- driver ------------------------------------------------------------------------------------
 */

static double square_bound(const search *s) {
  if (s->best <= s->tolerance)
    return -1.0;
  double reach = (1.0 - DISTANCE_ACCURACY) * s->best;
  return reach * reach;
}

static double try_centre(void *data, int element, double distance2) {
  static const double centre[3] = {0.5, 0.5, 0.5};
  search *s = data;
  (void)distance2;
  tsi_element_net(s->solid->space, s->solid->control, 4, element, s->net);
  descend(s, element, centre);
  return s->best <= s->tolerance ? -1.0 : s->tolerance * s->tolerance;
}

static double try_parts(void *data, int element, double distance2) {
  search *s = data;
  (void)distance2;
  tsi_element_net(s->solid->space, s->solid->control, 4, element, s->net);
  search_element(s, element);
  return square_bound(s);
}

static void write_place(const search *s, int *block, double u[3]) {
  const tsi_element *element = &s->solid->space->element[s->element];
  *block = element->block;
  for (int d = 0; d < 3; d++) {
    double lo = element->box[d], hi = element->box[d + 3], x = s->x[d];
    u[d] = x >= 1.0 ? hi : fmin(fmax(lo + x * (hi - lo), lo), hi);
  }
}

tsolid_status tsolid_solid_invert(tsolid_context *context, const tsolid_solid *solid,
                                  const double point[3], double tolerance, int *found, int *block,
                                  double u[3], double *distance) {
  if (!context)
    return TSOLID_ERROR_ARGUMENT;
  if (!solid || !point || !found || !block || !u || !distance || !(tolerance >= 0.0) ||
      !isfinite(point[0]) || !isfinite(point[1]) || !isfinite(point[2]))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, "solid", "No finite point to invert");
  search s = {.solid = solid,
              .point = {point[0], point[1], point[2]},
              .tolerance = tolerance > 0.0 ? tolerance : 1e-10 * solid->space->boundary->scale,
              .best = (double)INFINITY,
              .element = -1};
  tsolid_status status = TSOLID_OK;
  size_t n = largest_net(solid->space);
  double *memory = tsi_new(&context->allocator, n, 8 * sizeof *memory);
  if (!memory) {
    status = tsi_no_memory(context, "solid");
    goto done;
  }
  s.net = memory;
  s.part = memory + 4 * n;
  tsi_bvh_nearest(solid->physical, point, s.tolerance * s.tolerance, try_centre, &s);
  if (s.best > s.tolerance)
    tsi_bvh_nearest(solid->physical, point, square_bound(&s), try_parts, &s);
  if (s.element < 0) {
    status = tsi_fail(context, TSOLID_ERROR_INTERNAL, "solid", "The solid has no elements");
    goto done;
  }
  write_place(&s, block, u);
  *distance = s.best;
  *found = s.best <= s.tolerance;
done:
  tsi_delete(&context->allocator, memory);
  return status;
}
