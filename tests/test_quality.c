/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Quality: the input's own bound against searches over directions and known corners; samples
 * against evaluation point by point. */
#include "boundary_bound.h"
#include "check.h"
#include "evaluate.h"
#include "parts.h"
#include "quadrature.h"

static uint64_t state = 777;

static double uniform(void) { /* in [-1, 1) */
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) * 0x1p-52 - 1.0;
}

/* ---- hulls
 * ------------------------------------------------------------------------------------------ */

/* min over n_i . d for a unit vector d. */
static double least_dot(int n, const double (*v)[3], const double d[3]) {
  double least = INFINITY, length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  for (int i = 0; i < n; i++)
    least = fmin(least, (v[i][0] * d[0] + v[i][1] * d[1] + v[i][2] * d[2]) / length);
  return least;
}

/* Smallest norm in the hull by a search over barycentric coordinates that halves its step; `at`
 * receives the point. */
static double nearest_in_hull(int n, const double (*v)[3], double at[3]) {
  double weight[3] = {1.0, 0.0, 0.0}, best = INFINITY;
  for (double step = 0.5; step > 1e-12; step *= 0.7)
    for (int trial = 0; trial < 60; trial++) {
      double w[3], sum = 0.0, p[3] = {0.0, 0.0, 0.0};
      for (int i = 0; i < n; i++) {
        w[i] = fmax(0.0, weight[i] + (trial ? step * uniform() : 0.0));
        sum += w[i];
      }
      for (int i = 0; i < n; i++)
        for (int c = 0; c < 3; c++)
          p[c] += sum > 0.0 ? w[i] / sum * v[i][c] : 1e9;
      double norm = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
      if (norm >= best)
        continue;
      best = norm;
      for (int c = 0; c < 3; c++) {
        at[c] = p[c];
        weight[c] = c < n ? w[c] / sum : 0.0;
      }
    }
  return best;
}

static void test_hull_distance(void) {
  const double cube[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  CHECK_NEAR(tsi_hull_distance(1, cube), 1.0, 1e-15);
  CHECK_NEAR(tsi_hull_distance(2, cube), sqrt(0.5), 1e-15);
  CHECK_NEAR(tsi_hull_distance(3, cube), sqrt(1.0 / 3.0), 1e-15);
  const double line[3][3] = {{1, -1, 0}, {1, 3, 0}, {1, 1, 0}}; /* foot inside, collinear */
  CHECK_NEAR(tsi_hull_distance(3, line), 1.0, 1e-15);
  const double same[3][3] = {{0, 0, 2}, {0, 0, 2}, {0, 0, 2}};
  CHECK_NEAR(tsi_hull_distance(3, same), 2.0, 1e-15);
  const double around[3][3] = {{1, 0, 0}, {-0.5, 0.8, 0}, {-0.5, -0.8, 0}};
  CHECK_NEAR(tsi_hull_distance(3, around), 0.0, 1e-15);
  const double opposite[2][3] = {{0, 1, 0}, {0, -2, 0}};
  CHECK_NEAR(tsi_hull_distance(2, opposite), 0.0, 1e-15);
  for (int trial = 0; trial < 60; trial++) {
    double v[3][3];
    for (int i = 0; i < 9; i++)
      v[i / 3][i % 3] = uniform() + (trial % 3 == 0);
    int n = 1 + trial % 3;
    double distance = tsi_hull_distance(n, (const double(*)[3])v);
    double at[3] = {0.0, 0.0, 0.0};
    double nearest = nearest_in_hull(n, (const double(*)[3])v, at);
    CHECK(nearest >= distance - 1e-14);
    CHECK_NEAR(nearest, distance, 1e-6);
    /* the minimax: the direction of the nearest point reaches the distance, no other passes it */
    if (distance > 1e-2)
      CHECK_NEAR(least_dot(n, (const double(*)[3])v, at), distance, 1e-3);
    for (int other = 0; other < 50; other++) {
      const double d[3] = {uniform(), uniform(), uniform()};
      CHECK(least_dot(n, (const double(*)[3])v, d) <= distance + 1e-14);
    }
  }
}

/* ---- bounds
 * ----------------------------------------------------------------------------------------- */

static void bound_of(tsolid_context *context, const part_net *net, double expected,
                     double tolerance) {
  tsolid_boundary *boundary = part_boundary(context, net);
  double bound = -1.0, point[3];
  if (CHECK(boundary != NULL)) {
    CHECK(tsi_boundary_bound(context, boundary, &bound, point) == TSOLID_OK);
    CHECK_NEAR(bound, expected, tolerance);
  }
  tsolid_boundary_free(boundary);
}

/* A parallelepiped with edge vectors t[3]: all of it is known at its eight corners, where the
 * normals of the low sides are products of unit vectors with signs. */
static double slanted_bound(const double t[3][3]) {
  double worst = INFINITY;
  for (int corner = 0; corner < 8; corner++) {
    double unit[3][3], n[3][3];
    for (int i = 0; i < 3; i++) {
      double length = sqrt(t[i][0] * t[i][0] + t[i][1] * t[i][1] + t[i][2] * t[i][2]);
      for (int c = 0; c < 3; c++)
        unit[i][c] = (corner >> i & 1 ? -1.0 : 1.0) * t[i][c] / length;
    }
    double sign = tsi_det3(unit[0], unit[1], unit[2]) > 0.0 ? 1.0 : -1.0;
    for (int i = 0; i < 3; i++) {
      const double *a = unit[(i + 1) % 3], *b = unit[(i + 2) % 3];
      n[i][0] = sign * (a[1] * b[2] - a[2] * b[1]);
      n[i][1] = sign * (a[2] * b[0] - a[0] * b[2]);
      n[i][2] = sign * (a[0] * b[1] - a[1] * b[0]);
    }
    worst = fmin(worst, tsi_hull_distance(3, (const double(*)[3])n));
  }
  return worst;
}

static void test_known_bounds(tsolid_context *context) {
  part_net net;
  part_identity(&net, 1, 1, 1);
  bound_of(context, &net, sqrt(1.0 / 3.0), 1e-14);
  part_identity(&net, 3, 2, 4);
  bound_of(context, &net, sqrt(1.0 / 3.0), 1e-14);
  for (int trial = 0; trial < 10; trial++) {
    double t[3][3];
    part_net slanted;
    part_identity(&net, 2, 1, 3);
    slanted = net;
    for (int i = 0; i < 9; i++)
      t[i / 3][i % 3] = (i % 4 == 0 ? 1.0 : 0.0) + 0.4 * uniform();
    for (int k = 0; k < 3 * 2 * 4; k++)
      for (int c = 0; c < 3; c++)
        slanted.point[k][c] =
            net.point[k][0] * t[0][c] + net.point[k][1] * t[1][c] + net.point[k][2] * t[2][c];
    bound_of(context, &slanted, slanted_bound((const double(*)[3])t), 1e-13);
  }
  part_cylinder(&net); /* four smooth corners: no solid is regular there */
  bound_of(context, &net, 0.0, 0.0);
}

/* Corners of the cylinder: the cap's normal is none, the sides' are radial; a right angle between
 * cap and sides everywhere else. */
static void test_corner_of_cylinder(tsolid_context *context) {
  part_net net;
  part_cylinder(&net);
  tsolid_boundary *boundary = part_boundary(context, &net);
  if (!CHECK(boundary != NULL))
    return;
  for (int corner = 0; corner < 8; corner++) {
    tsi_corner c;
    int n_singular = 0;
    tsi_corner_measure(boundary, corner, &c);
    for (int axis = 0; axis < 3; axis++) {
      n_singular += c.singular[axis];
      if (c.singular[axis])
        continue;
      double inward = 0.0; /* along the radius, to the axis of the cylinder */
      for (int d = 0; d < 3; d++)
        inward -= c.normal[axis][d] * (fabs(fabs(c.point[d]) - 1.0) < 1e-9 ? 0.0 : c.point[d]);
      CHECK_NEAR(inward, 1.0, 1e-14);
    }
    CHECK(n_singular == 1);
    CHECK(c.bound <= TSI_SINGULAR_TOLERANCE);
  }
  tsolid_boundary_free(boundary);
}

/* A ball-like part: edges leave each corner in the plane across its direction, at 120 degrees. Its
 * corners have sqrt(3)/2, so the core corners' 4/(3 sqrt 3) is the bound, and the point is there.
 */
static void make_ball(part_net *net) {
  part_identity(net, 3, 3, 3);
  for (int k = 0; k < 64; k++) {
    const int i[3] = {k % 4, k / 4 % 4, k / 16};
    double corner[3], along = 0.0;
    for (int d = 0; d < 3; d++)
      corner[d] = i[d] < 2 ? -1.0 : 1.0;
    for (int d = 0; d < 3; d++)
      net->point[k][d] = corner[d];
    for (int d = 0; d < 3; d++) {
      if (i[d] == 0 || i[d] == 3)
        continue;
      /* -corner_d e_d, projected to the plane across `corner` */
      for (int c = 0; c < 3; c++)
        along = -corner[d] * ((c == d) - corner[c] * corner[d] / 3.0),
        net->point[k][c] += 0.7 * along;
    }
  }
}

static void test_bound_of_core_corner(tsolid_context *context) {
  part_net net;
  tsolid_quality q;
  make_ball(&net);
  tsolid_boundary *boundary = part_boundary(context, &net);
  tsi_corner c;
  if (!CHECK(boundary != NULL))
    return;
  for (int corner = 0; corner < 8; corner++) {
    tsi_corner_measure(boundary, corner, &c);
    CHECK_NEAR(c.bound, sqrt(0.75), 1e-14);
    CHECK(!c.singular[0] && !c.singular[1] && !c.singular[2]); /* coplanar tangents are no harm */
  }
  tsolid_boundary_free(boundary);
  tsolid_solid *solid = part_solid(context, &net);
  if (!CHECK(solid != NULL))
    return;
  CHECK(tsolid_quality_measure(context, solid, &q) == TSOLID_OK);
  CHECK_NEAR(q.bound, 4.0 / (3.0 * sqrt(3.0)), 1e-15);
  double u[3] = {0.0, 0.0, 0.0}, x[3];
  CHECK(tsolid_solid_evaluate(context, solid, 0, u, 0, x) == TSOLID_OK);
  for (int d = 0; d < 3; d++)
    CHECK_NEAR(q.bound_point[d], x[d], 1e-14);
  CHECK(q.worst <= q.bound);
  tsolid_solid_free(solid);
}

/* ---- samples
 * ------------------------------------------------------------------------------------------ */

static double scaled_jacobian(tsolid_context *context, const tsolid_solid *solid, int block,
                              const double u[3]) {
  double x[12], length = 1.0;
  CHECK(tsolid_solid_evaluate(context, solid, block, u, 1, x) == TSOLID_OK);
  for (int d = 3; d < 12; d += 3)
    length *= sqrt(x[d] * x[d] + x[d + 1] * x[d + 1] + x[d + 2] * x[d + 2]);
  return tsi_det3(x + 3, x + 6, x + 9) / length;
}

/* The same samples by tsolid_solid_evaluate, a hair inside the element, since on a border it may
 * take the neighbour. */
static void check_samples(tsolid_context *context, const tsolid_solid *solid,
                          const tsolid_quality *q) {
  const tsolid_space *space = solid->space;
  double worst = INFINITY, best = -INFINITY, sum = 0.0, node[26], weight[26], x[3][40];
  for (int e = 0; e < space->n_elements; e++) {
    const tsi_element *element = &space->element[e];
    int n[3];
    for (int d = 0; d < 3; d++) {
      n[d] = 7 + element->degree[d] + 1;
      tsi_gauss(element->degree[d] + 1, node, weight);
      for (int i = 0; i < n[d]; i++)
        x[d][i] = i < 7 ? 1e-12 + (1.0 - 2e-12) * i / 6.0 : node[i - 7];
    }
    for (int k = 0; k < n[2]; k++)
      for (int j = 0; j < n[1]; j++)
        for (int i = 0; i < n[0]; i++) {
          if ((i < 7) != (j < 7) || (i < 7) != (k < 7))
            continue;
          const double local[3] = {x[0][i], x[1][j], x[2][k]};
          double u[3];
          for (int d = 0; d < 3; d++)
            u[d] = element->box[d] + local[d] * (element->box[3 + d] - element->box[d]);
          double value = scaled_jacobian(context, solid, element->block, u);
          worst = fmin(worst, value);
          best = fmax(best, value);
          sum += i < 7 ? value : 0.0;
        }
  }
  CHECK_NEAR(q->worst, worst, 1e-9);
  CHECK_NEAR(q->best, best, 1e-9);
  CHECK_NEAR(q->mean, sum / (343.0 * space->n_elements), 1e-9);
}

static void random_net(part_net *net, int d0, int d1, int d2, double amount) {
  part_identity(net, d0, d1, d2);
  for (int k = 0; k < (d0 + 1) * (d1 + 1) * (d2 + 1); k++)
    for (int c = 0; c < 3; c++)
      net->point[k][c] += amount * uniform();
}

/* The same control points moved by 2^10: the samples stay. */
static void check_far_away(tsolid_context *context, const tsolid_solid *solid,
                           const tsolid_quality *q) {
  tsolid_solid moved = *solid;
  tsolid_quality far;
  size_t n = (size_t)solid->space->n_inner + 2 * (size_t)solid->space->n_surface;
  moved.control = malloc(4 * n * sizeof *moved.control);
  if (!CHECK(moved.control != NULL))
    return;
  for (size_t k = 0; k < 4 * n; k++)
    moved.control[k] = solid->control[k] + (k % 4 < 3 ? 1024.0 * solid->control[k - k % 4 + 3] : 0);
  CHECK(tsolid_quality_measure(context, &moved, &far) == TSOLID_OK);
  CHECK_NEAR(far.worst, q->worst, 1e-9);
  CHECK_NEAR(far.mean, q->mean, 1e-9);
  free(moved.control);
}

static void test_samples_and_bound(tsolid_context *context) {
  static const int degree[4][3] = {{3, 3, 3}, {2, 3, 4}, {5, 1, 2}, {3, 3, 3}};
  for (int trial = 0; trial < 4; trial++) {
    part_net net;
    tsolid_quality q;
    random_net(&net, degree[trial][0], degree[trial][1], degree[trial][2], 0.04);
    if (trial == 3)
      part_cylinder(&net);
    tsolid_solid *solid = part_solid(context, &net);
    if (!CHECK(solid != NULL))
      return;
    CHECK(tsolid_quality_measure(context, solid, &q) == TSOLID_OK);
    check_samples(context, solid, &q);
    int block = solid->space->element[q.worst_element].block;
    double x[3];
    CHECK(tsolid_solid_evaluate(context, solid, block, q.worst_u, 0, x) == TSOLID_OK);
    for (int d = 0; d < 3; d++)
      CHECK_NEAR(q.worst_point[d], x[d], 1e-12);
    CHECK(q.worst <= q.bound + 1e-12 && q.mean < 1.0 && q.best <= 1.0 + 1e-14);
    CHECK(trial == 3 ? q.ratio == 0.0 : fabs(q.ratio * q.bound - q.worst) < 1e-15);
    check_far_away(context, solid, &q);
    tsolid_solid_free(solid);
  }
}

static int cancel(void *data, const char *stage, double fraction) {
  (void)stage;
  (void)fraction;
  return *(int *)data;
}

static void test_threads_cancel_arguments(void) {
  part_net net;
  tsolid_quality q[2];
  int asked = 0;
  random_net(&net, 4, 3, 2, 0.03);
  for (int t = 0; t < 2; t++) {
    tsolid_context *context;
    tsolid_context_options options = {
        .n_threads = 1 + 2 * t, .progress = cancel, .progress_data = &asked};
    asked = 0;
    CHECK(tsolid_context_create(&options, &context) == TSOLID_OK);
    tsolid_solid *solid = part_solid(context, &net);
    if (!CHECK(solid != NULL))
      return;
    memset(&q[t], 0, sizeof q[t]);
    CHECK(tsolid_quality_measure(context, solid, &q[t]) == TSOLID_OK);
    tsolid_quality untouched = q[t];
    asked = 1;
    CHECK(tsolid_quality_measure(context, solid, &untouched) == TSOLID_ERROR_CANCELLED);
    CHECK(memcmp(&untouched, &q[t], sizeof untouched) == 0);
    asked = 0;
    CHECK(tsolid_quality_measure(context, NULL, &untouched) == TSOLID_ERROR_ARGUMENT);
    CHECK(tsolid_quality_measure(context, solid, NULL) == TSOLID_ERROR_ARGUMENT);
    tsolid_solid_free(solid);
    tsolid_context_free(context);
  }
  CHECK(q[0].worst == q[1].worst && q[0].mean == q[1].mean && q[0].best == q[1].best);
  CHECK(q[0].worst_element == q[1].worst_element && q[0].bound == q[1].bound);
  CHECK(memcmp(q[0].worst_u, q[1].worst_u, sizeof q[0].worst_u) == 0);
}

int main(void) {
  tsolid_context *context;
  const tsolid_context_options options = {.n_threads = 1};
  if (tsolid_context_create(&options, &context) != TSOLID_OK)
    return 1;
  test_hull_distance();
  test_known_bounds(context);
  test_corner_of_cylinder(context);
  test_bound_of_core_corner(context);
  test_samples_and_bound(context);
  test_threads_cancel_arguments();
  tsolid_context_free(context);
  return check_done();
}
