/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Planar patches over four borders: the borders stay, the plane stays, the area is that of Green's
 * theorem, what folds is repaired or refused, and what is called positive is. */
#include <stdlib.h>

#include "check.h"
#include "coons.h"
#include "coons_parts.h"
#include "counted_memory.h"

static unsigned long long state = 2024;

static double random_unit(void) {
  state = state * 6364136223846793005ULL + 1442695040888963407ULL;
  return (double)(state >> 11) / 9007199254740992.0;
}

static int random_int(int low, int high) {
  return low + (int)(random_unit() * (high - low + 1));
}

typedef struct made {
  tsolid_status status;
  tsolid_coons *coons; /* NULL: refused */
  tsolid_coons_report report;
  tsolid_patch patch;
  tsi_patch read;
} made;

static made make(tsolid_context *context, tsi_arena *arena, const flat_loop *loop,
                 const tsolid_coons_options *options) {
  made m;
  tsolid_curve border[4];
  for (int k = 0; k < 4; k++)
    border[k] = flat_view(&loop->border[k]);
  memset(&m, 0, sizeof m);
  tsolid_context_clear(context);
  m.status = tsolid_coons_create(context, border, options, &m.report, &m.coons);
  CHECK((m.status == TSOLID_OK) == (m.coons != NULL));
  if (m.coons) {
    tsolid_coons_get(m.coons, &m.patch);
    CHECK(tsi_patch_vet(context, &m.patch, 0) == TSOLID_OK);
    CHECK(tsi_patch_read(arena, &m.patch, &m.read));
  }
  return m;
}

/* ---- identities --------------------------------------------------------------------------------
 */

/* Border k of the patch at t of the curve's own range. */
static void evaluate_border(const made *m, int k, double t, double x[3]) {
  double h[4], u = k == 1 ? 1.0 : k == 3 ? 0.0 : t, v = k == 0 ? 0.0 : k == 2 ? 1.0 : t;
  tsi_patch_evaluate(&m->read, u, v, h, NULL);
  for (int c = 0; c < 3; c++)
    x[c] = h[c] / h[3];
}

/* Bits of row k of the patch and of the curve agree: points, knots, ratios of weights. */
static int same_bits(const made *m, const flat_loop *loop, int k) {
  const flat_curve *c = &loop->border[k];
  int d = k & 1, n = m->patch.n_control[d];
  size_t n0 = (size_t)m->patch.n_control[0], stride = d ? n0 : 1;
  size_t first = k == 1 ? n0 - 1 : k == 2 ? n0 * (size_t)(m->patch.n_control[1] - 1) : 0;
  int same = m->patch.degree[d] == c->degree && n == c->n;
  for (int i = 0; same && i < n; i++)
    same = memcmp(m->patch.points + 3 * (first + stride * (size_t)i), c->point[i],
                  3 * sizeof(double)) == 0;
  double factor = m->report.weight_factor[k];
  for (int i = 1; same && i + 1 < n; i++)
    same = fabs((m->patch.weights ? m->patch.weights[first + stride * (size_t)i] : 1.0) /
                    (factor * c->weight[i]) -
                1.0) <= (m->report.linear_border < 0 ? 0.0 : 1e-15);
  return same;
}

static double find_scale(const flat_loop *loop) {
  double scale = 0.0;
  for (int k = 0; k < 4; k++)
    for (int i = 0; i < 3 * loop->border[k].n; i++)
      scale = fmax(scale, fabs(loop->border[k].point[i / 3][i % 3]));
  return scale;
}

static void check_plane(const made *m, double scale) {
  const double *o = m->report.origin, *n = m->report.normal;
  double worst = 0.0;
  for (int i = 0; i < m->patch.n_control[0] * m->patch.n_control[1]; i++) {
    const double *x = m->patch.points + 3 * (ptrdiff_t)i;
    worst = fmax(worst, fabs((x[0] - o[0]) * n[0] + (x[1] - o[1]) * n[1] + (x[2] - o[2]) * n[2]));
  }
  CHECK_NEAR(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1.0, 1e-15);
  CHECK_NEAR(worst, 0.0, m->report.plane_distance + 4e-16 * scale);
}

/* Everything that holds of any patch that is not refused. */
static void check_identities(const made *m, const flat_loop *loop) {
  double scale = find_scale(loop), green[3], own[3], size;
  flat_green_area(loop, m->report.origin, green);
  flat_patch_area(&m->read, own);
  size = hypot(hypot(green[0], green[1]), green[2]);
  for (int c = 0; c < 3; c++) {
    CHECK_NEAR(own[c], green[c], 1e-13 * size + 1e-15 * scale * sqrt(size));
    CHECK_NEAR(m->report.normal[c], green[c] / size, 1e-12 + 1e-14 * scale / sqrt(size));
  }
  CHECK_NEAR(m->report.area, size, 1e-13 * size + 1e-15 * scale * sqrt(size));
  check_plane(m, scale);
  for (int k = 0; k < 4; k++) {
    const flat_curve *c = &loop->border[k];
    double low = c->knots[0], high = c->knots[c->n];
    for (int i = 0; i <= 60; i++) {
      double t = i / 60.0, x[3], y[3], dy[3];
      evaluate_border(m, k, t, x);
      flat_evaluate(c, low + t * (high - low), y, dy);
      CHECK_NEAR(hypot(hypot(x[0] - y[0], x[1] - y[1]), x[2] - y[2]), 0.0, 2e-14 * scale);
    }
  }
}

/* det J > 0 at n x n points of every span, ends left out where `inner`. */
static double sample_worst(const tsi_patch *p, const double normal[3], int n) {
  double worst = INFINITY;
  for (int t = p->degree[1]; t < p->n[1]; t++)
    for (int s = p->degree[0]; s < p->n[0]; s++) {
      double du = p->knots[0][s + 1] - p->knots[0][s], dv = p->knots[1][t + 1] - p->knots[1][t];
      for (int q = 0; q < n * n && du > 0.0 && dv > 0.0; q++) {
        double h[4], d[2][4], e[2][3], det = 0.0;
        tsi_patch_evaluate(p, p->knots[0][s] + (q % n + 0.5) / n * du,
                           p->knots[1][t] + (q / n + 0.5) / n * dv, h, d);
        for (int k = 0; k < 6; k++)
          e[k / 3][k % 3] = (d[k / 3][k % 3] - h[k % 3] / h[3] * d[k / 3][3]) / h[3];
        for (int k = 0; k < 3; k++)
          det += normal[k] *
                 (e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3]);
        worst = fmin(worst, det);
      }
    }
  return worst;
}

/* ---- random regions ----------------------------------------------------------------------------
 */

/* A curve near the segment a b: random degree, knots up to C^0, weights, and a wave across. */
static flat_curve random_curve(const double a[2], const double b[2], int rational) {
  flat_curve c = {.degree = random_int(1, 5)};
  int spans = random_int(1, 4), k = c.degree + 1;
  double at = 0.0, start = 10.0 * random_unit() - 5.0, stretch = exp(4.0 * random_unit() - 2.0);
  for (int s = 1; s < spans; s++) {
    int times = random_int(1, c.degree);
    at += 0.3 + random_unit();
    for (int m = 0; m < times; m++)
      c.knots[k++] = at;
  }
  at += 0.3 + random_unit();
  c.n = k;
  for (int i = 0; i <= c.degree; i++)
    c.knots[c.n + i] = at;
  for (int i = 0; i < c.n; i++) {
    double greville = 0.0, wave = i == 0 || i == c.n - 1 ? 0.0 : 0.1 * (random_unit() - 0.5);
    for (int m = 1; m <= c.degree; m++)
      greville += c.knots[i + m] / (c.degree * at);
    for (int x = 0; x < 2; x++)
      c.point[i][x] = i == 0 ? a[x]
                      : i == c.n - 1
                          ? b[x]
                          : a[x] + greville * (b[x] - a[x]) + wave * (b[1 - x] - a[1 - x]);
    c.weight[i] = rational ? exp(0.3 * (random_unit() - 0.5)) : 1.0;
  }
  for (int i = 0; i < c.n + c.degree + 1; i++)
    c.knots[i] = start + stretch * c.knots[i];
  return c;
}

static flat_loop random_loop(int rational) {
  double corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int i = 0; i < 8; i++)
    corner[i / 2][i % 2] += 0.3 * (random_unit() - 0.5);
  return (flat_loop){
      {random_curve(corner[0], corner[1], rational), random_curve(corner[1], corner[2], rational),
       random_curve(corner[3], corner[2], rational), random_curve(corner[0], corner[3], rational)}};
}

static void test_random(tsolid_context *context) {
  static const double place[3][4] = {{0, 0, 0, 1}, {3, -7, 2, 5}, {4e5, -3e5, 7e5, 1}};
  int n_ok = 0, n_linear = 0, n_same = 0;
  for (int i = 0; i < 40; i++) {
    tsi_arena arena = tsi_arena_create(context);
    flat_loop loop = random_loop(i % 2);
    const double *at = place[i / 2 % 3];
    if (i % 5)
      flat_move(&loop, at, at[3]);
    if (i % 3 == 0)
      loop = flat_mirror(&loop);
    made m = make(context, &arena, &loop, NULL);
    if (m.coons) {
      n_ok++;
      n_linear += m.report.linear_border >= 0;
      check_identities(&m, &loop);
      CHECK(m.report.worst > 0.0 && m.report.worst <= m.report.bound + 1e-12);
      CHECK(sample_worst(&m.read, m.report.normal, 8) > 0.0);
      for (int k = 0; k < 4; k++) {
        const flat_curve *a = &loop.border[k], *b = &loop.border[k ^ 2];
        if (a->degree >= b->degree && a->n - a->degree == 1 && b->n - b->degree == 1 &&
            m.report.linear_border != k && !m.report.repaired && m.patch.degree[k & 1] == a->degree)
          n_same += CHECK(same_bits(&m, &loop, k));
      }
    }
    tsolid_coons_free(m.coons);
    tsi_arena_free(&arena);
  }
  CHECK(n_ok >= 36);
  CHECK(n_linear >= 10);
  CHECK(n_same >= 5);
}

/* ---- arcs --------------------------------------------------------------------------------------
 */

static flat_loop circle(double radius) {
  const double p = 0.25 * flat_pi;
  return (flat_loop){{flat_arc(radius, -3 * p, -p), flat_arc(radius, -p, p),
                      flat_arc(radius, 3 * p, p), flat_arc(radius, 5 * p, 3 * p)}};
}

static flat_loop half_disc(double radius) {
  const double p = flat_pi / 3.0;
  return (flat_loop){{FLAT_LINE(-radius, 0, radius, 0), flat_arc(radius, 0, p),
                      flat_arc(radius, 2 * p, p), flat_arc(radius, 3 * p, 2 * p)}};
}

static flat_loop sector(double radius, double angle) {
  double c = radius * cos(angle), s = radius * sin(angle);
  return (flat_loop){{FLAT_LINE(0, 0, radius, 0), flat_arc(radius, 0, 0.5 * angle),
                      flat_arc(radius, angle, 0.5 * angle), FLAT_LINE(0, 0, c, s)}};
}

static void expect_arc(tsolid_context *context, const flat_loop *flat, double area,
                       int n_singular) {
  static const double origin[3] = {5, -3, 8}, none[3] = {0, 0, 0};
  for (int moved = 0; moved < 4; moved++) {
    tsi_arena arena = tsi_arena_create(context);
    flat_loop loop = moved & 1 ? flat_mirror(flat) : *flat;
    flat_move(&loop, moved & 2 ? origin : none, 1.0);
    made m = make(context, &arena, &loop, NULL);
    if (CHECK(m.coons)) {
      check_identities(&m, &loop);
      CHECK_NEAR(m.report.area, area, 1e-13 * area);
      CHECK(m.report.n_singular == n_singular);
      CHECK(tsolid_context_n_findings(context) == n_singular);
      CHECK(m.report.repaired == 0);
      CHECK(sample_worst(&m.read, m.report.normal, 30) > 0.0);
      for (int k = 0; k < m.report.n_singular; k++) { /* it is a point of the patch */
        double near = INFINITY;
        for (int c = 0; c < 4; c++) {
          double x[3];
          const double *s = m.report.singular[k];
          evaluate_border(&m, c & 2, c & 1, x);
          near = fmin(near, hypot(hypot(x[0] - s[0], x[1] - s[1]), x[2] - s[2]));
        }
        CHECK_NEAR(near, 0.0, 1e-15);
      }
    }
    tsolid_coons_free(m.coons);
    tsi_arena_free(&arena);
  }
}

static void test_arcs(tsolid_context *context) {
  flat_loop loop = circle(2.0);
  expect_arc(context, &loop, 4.0 * flat_pi, 4);
  loop = half_disc(3.0);
  expect_arc(context, &loop, 4.5 * flat_pi, 2);
  for (int k = 1; k < 6; k++) {
    loop = sector(1.5, k * flat_pi / 6.0);
    expect_arc(context, &loop, 0.5 * 2.25 * k * flat_pi / 6.0, 1);
  }
}

/* Far from the origin round-off bends the corners of a disc by so much as its size tells, to either
 * side: they are singular all the same. Near it, or bent by more, they are what they are. */
static void test_far_disc(tsolid_context *context) {
  static const double far[3] = {1e5, 2e5, -3e5}, none[3] = {0, 0, 0};
  static const struct {
    double bend;
    int is_far, taken;
  } cases[] = {{0.0, 1, 1}, {0.0, 0, 1}, {1e-9, 0, 0}, {1e-6, 1, 0}, {1e-6, 0, 0}};
  for (int k = 0; k < 5; k++) {
    tsi_arena arena = tsi_arena_create(context);
    flat_loop loop = circle(3.0);
    loop.border[0].point[1][1] -= 3.0 * cases[k].bend;
    flat_move(&loop, cases[k].is_far ? far : none, 1.0);
    made m = make(context, &arena, &loop, NULL);
    CHECK((m.coons != NULL) == cases[k].taken);
    if (m.coons) {
      CHECK(m.report.n_singular == 4);
      CHECK(sample_worst(&m.read, m.report.normal, 30) > 0.0);
    }
    tsolid_coons_free(m.coons);
    tsi_arena_free(&arena);
  }
}

/* ---- repair ------------------------------------------------------------------------------------
 */

static flat_loop ell(void) {
  return (flat_loop){{FLAT_LINE(0, 0, 2, 0), FLAT_LINE(2, 0, 2, 1),
                      FLAT_LINE(0, 2, 1, 2, 1, 1, 2, 1), FLAT_LINE(0, 0, 0, 2)}};
}

/* A square with a mushroom cut out from below, its cap wider than its stem by `overhang` on each
 * side: under the cap the plain patch runs the wrong way. */
static flat_loop mushroom(double overhang) {
  static const double knots[13] = {0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 8, 8};
  static const double y[5] = {0, 0, 0.35, 0.35, 0.7};
  flat_loop loop = {
      {FLAT_LINE(0, 0, 1, 0), FLAT_LINE(1, 0, 1, 1), FLAT_LINE(0, 1, 1, 1), FLAT_LINE(0, 0, 0, 1)}};
  flat_curve *c = &loop.border[0];
  const double x[5] = {0.0, 0.42, 0.42, 0.42 - overhang, 0.42 - overhang};
  c->degree = 2;
  c->n = 10;
  memcpy(c->knots, knots, sizeof knots);
  for (int i = 0; i < 10; i++) {
    c->point[i][0] = i < 5 ? x[i] : 1.0 - x[9 - i];
    c->point[i][1] = y[i < 5 ? i : 9 - i];
    c->weight[i] = 1.0;
  }
  return loop;
}

static void test_repair(tsolid_context *context) {
  const flat_loop flat[3] = {ell(), mushroom(0.1), mushroom(0.2)};
  for (int i = 0; i < 6; i++) {
    tsi_arena arena = tsi_arena_create(context);
    static const double origin[3] = {-100, 20, 3};
    flat_loop loop = i & 1 ? flat_mirror(&flat[i / 2]) : flat[i / 2];
    flat_move(&loop, origin, 10.0);
    const tsolid_coons_options never = {.repair = TSOLID_REPAIR_NEVER};
    made plain = make(context, &arena, &loop, &never);
    CHECK(plain.status == TSOLID_ERROR_REFUSED && plain.report.start_worst < 0.0);
    const tsolid_finding *finding = tsolid_context_finding(context, 0);
    CHECK(finding && strstr(finding->text, "folds near") && finding->has_point);
    made m = make(context, &arena, &loop, NULL);
    if (CHECK(m.coons)) {
      check_identities(&m, &loop);
      CHECK(m.report.repaired && m.report.worst > 0.2 * m.report.bound);
      CHECK(m.report.start_worst == plain.report.start_worst);
      CHECK(sample_worst(&m.read, m.report.normal, 25) > 0.0);
    }
    made again = make(context, &arena, &loop, NULL);
    CHECK(again.coons && m.coons && memcmp(&again.report, &m.report, sizeof m.report) == 0);
    tsolid_coons_free(again.coons);
    tsolid_coons_free(m.coons);
    tsi_arena_free(&arena);
  }
}

/* ---- refusals ----------------------------------------------------------------------------------
 */

static void expect_refused(tsolid_context *context, const flat_loop *loop, tsolid_status status,
                           const char *text) {
  tsi_arena arena = tsi_arena_create(context);
  made m = make(context, &arena, loop, NULL);
  const tsolid_finding *finding = tsolid_context_finding(context, 0);
  CHECK(m.status == status && finding && finding->status == status);
  if (!CHECK(finding && strstr(finding->text, text)))
    fprintf(stderr, "    '%s' is not in: %s\n", text, finding ? finding->text : "nothing");
  CHECK(tsolid_context_n_findings(context) == 1);
  tsolid_coons_free(m.coons);
  tsi_arena_free(&arena);
}

static void test_refusals(tsolid_context *context) {
  flat_loop good = circle(1.0), bad = good;
  bad.border[1].point[2][0] += 1e-6;
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "do not meet at (u,v) = (1,1)");
  bad = good;
  bad.border[2].point[1][2] += 1e-6;
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "is not planar: border v high");
  bad = (flat_loop){
      {FLAT_LINE(0, 0, 1, 0), FLAT_LINE(1, 0, 2, 0), FLAT_LINE(3, 0, 2, 0), FLAT_LINE(0, 0, 3, 0)}};
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "enclose no area");
  bad = (flat_loop){{FLAT_LINE(0, 0, 3, -2), FLAT_LINE(3, -2, 0, 3), FLAT_LINE(-3, -2, 0, 3),
                     FLAT_LINE(0, 0, -3, -2)}};
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "an angle of 247.38 degrees at its corner");
  bad = (flat_loop){
      {FLAT_LINE(1, 1, 1, 1), FLAT_LINE(1, 1, 1, 1), FLAT_LINE(1, 1, 1, 1), FLAT_LINE(1, 1, 1, 1)}};
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "are one point");
  bad = (flat_loop){{FLAT_LINE(0, 0, 0, 0, 1, 0), FLAT_LINE(1, 0, 1, 1), FLAT_LINE(0, 1, 1, 1),
                     FLAT_LINE(0, 0, 0, 1)}};
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "has no direction at its corner (0,0)");
  bad = (flat_loop){{FLAT_LINE(0, 0, 0.7, 0, 0.3, 0, 1, 0), FLAT_LINE(1, 0, 1, 1),
                     FLAT_LINE(0, 1, 1, 1), FLAT_LINE(0, 0, 0, 1)}};
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "turns back on itself");
}

/* Borders that cross, touch, or run round twice: each but the second bounds a patch that is locally
 * one-to-one along its border. */
static void test_meetings(tsolid_context *context) {
  flat_loop bad = {{FLAT_LINE(0, 0, 1, 0), FLAT_LINE(1, 0, 1, 1),
                    FLAT_LINE(0, 1, 0.45, -0.1, 0.55, -0.1, 1, 1), FLAT_LINE(0, 0, 0, 1)}};
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "border v low and border v high of the face");
  bad.border[2] = FLAT_LINE(0, 1, 0.5, 0, 1, 1);
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "cross or touch near (0.5,");
  bad.border[2] = FLAT_LINE(0, 1, 0.5, 1e-9, 1, 1);
  tsi_arena arena = tsi_arena_create(context);
  made m = make(context, &arena, &bad, NULL);
  CHECK(m.coons && sample_worst(&m.read, m.report.normal, 8) > 0.0);
  tsolid_coons_free(m.coons);
  tsi_arena_free(&arena);
  bad.border[2] = FLAT_LINE(0, 1, 0.6, 0.6, 0.6, 0.8, 0.4, 0.6, 1, 1);
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "border v high of the face meets itself");
  /* a strip of constant width along a spiral of 1.2 turns without a pitch */
  enum { N = 25 };
  double xy[2][2 * N];
  for (int i = 0; i < 2 * N; i++) {
    double angle = 1.2 * 2.0 * flat_pi * (i % N) / (N - 1), r = i < N ? 2.0 : 1.0;
    xy[i / N][2 * (i % N)] = r * cos(angle);
    xy[i / N][2 * (i % N) + 1] = r * sin(angle);
  }
  const double *o = xy[0], *i = xy[1];
  bad = (flat_loop){{flat_polyline(N, o),
                     FLAT_LINE(o[2 * N - 2], o[2 * N - 1], i[2 * N - 2], i[2 * N - 1]),
                     flat_polyline(N, i), FLAT_LINE(o[0], o[1], i[0], i[1])}};
  expect_refused(context, &bad, TSOLID_ERROR_REFUSED, "near (");
  CHECK(!strstr(tsolid_context_finding(context, 0)->text, "folds"));
}

static void test_malformed(tsolid_context *context) {
  flat_loop good = circle(1.0), bad;
  static const int degree[4] = {0, -1, 26, 1 << 30};
  for (int i = 0; i < 4; i++) {
    bad = good;
    bad.border[3].degree = degree[i];
    expect_refused(context, &bad, TSOLID_ERROR_INPUT, "not one of 1 to 25");
  }
  static const int count[4] = {0, 2, -5, 0x7fffffff};
  for (int i = 0; i < 4; i++) {
    bad = good;
    bad.border[i].n = count[i];
    tsolid_curve border[4];
    for (int k = 0; k < 4; k++)
      border[k] = flat_view(&bad.border[k]);
    tsolid_coons *coons = NULL;
    tsolid_context_clear(context);
    CHECK(tsolid_coons_create(context, border, NULL, NULL, &coons) == TSOLID_ERROR_INPUT && !coons);
    CHECK(strstr(tsolid_context_finding(context, 0)->text, "control points, not"));
  }
  static const struct {
    int knot;
    double value;
    const char *text;
  } knots[] = {{2, (double)NAN, "not a finite number"},
               {0, -(double)INFINITY, "not a finite"},
               {4, 0.5, "decreases"},
               {1, 0.5, "decreases"},
               {2, 0.5, "not clamped"},
               {5, 2.0, "not clamped"}};
  for (size_t i = 0; i < sizeof knots / sizeof *knots; i++) {
    bad = good;
    bad.border[1].knots[knots[i].knot] = knots[i].value;
    expect_refused(context, &bad, TSOLID_ERROR_INPUT, knots[i].text);
  }
  bad = good;
  bad.border[2].weight[1] = -1.0;
  expect_refused(context, &bad, TSOLID_ERROR_INPUT, "the weight of control point 1 is -1");
  bad = good;
  bad.border[0].point[1][2] = (double)NAN;
  expect_refused(context, &bad, TSOLID_ERROR_INPUT, "control point 1 is not finite");
  bad = (flat_loop){{FLAT_LINE(0, 0, 0.5, 0.1, 1, 0), FLAT_LINE(1, 0, 1, 1), FLAT_LINE(0, 1, 1, 1),
                     FLAT_LINE(0, 0, 0, 1)}};
  bad.border[0].knots[2] = 1e-12;
  expect_refused(context, &bad, TSOLID_ERROR_INPUT, "too near to it");
}

/* Loops with a few numbers overwritten: refused, or a patch that keeps every promise. */
static void test_mutations(tsolid_context *context) {
  static const double odd[12] = {0.0,   -1.0, 1e-12, 1.0 + 1e-12, 1e99, 1e-49,
                                 -1e30, 1e49, 0.5,   0.25,        2.0,  1e9};
  int n_status[TSOLID_ERROR_INTERNAL + 1] = {0};
  for (int k = 0; k < 60; k++) {
    tsi_arena arena = tsi_arena_create(context);
    flat_loop loop = k % 3 == 0 ? circle(1.0) : k % 3 == 1 ? ell() : random_loop(1);
    for (int m = random_int(1, 2); m > 0; m--) {
      flat_curve *c = &loop.border[random_int(0, 3)];
      double value = odd[random_int(0, 11)];
      int what = random_int(0, 3), i = random_int(0, c->n - 1);
      if (what == 0)
        c->knots[random_int(0, c->n + c->degree)] = value;
      else if (what == 1)
        c->weight[i] = value;
      else
        c->point[i][random_int(0, 2)] = value;
    }
    made m = make(context, &arena, &loop, NULL);
    n_status[m.status]++;
    CHECK(m.status == TSOLID_OK || m.status == TSOLID_ERROR_INPUT ||
          m.status == TSOLID_ERROR_REFUSED);
    CHECK(m.status == TSOLID_OK || tsolid_context_n_findings(context) == 1);
    if (m.coons)
      CHECK(sample_worst(&m.read, m.report.normal, 7) > 0.0);
    tsolid_coons_free(m.coons);
    tsi_arena_free(&arena);
  }
  CHECK(n_status[TSOLID_OK] > 2 && n_status[TSOLID_ERROR_INPUT] > 10 &&
        n_status[TSOLID_ERROR_REFUSED] > 10);
}

static void test_arguments(tsolid_context *context) {
  flat_loop loop = circle(1.0);
  tsolid_curve border[4];
  for (int k = 0; k < 4; k++)
    border[k] = flat_view(&loop.border[k]);
  const tsolid_coons_options bad[4] = {{.tolerance = -1.0},
                                       {.tolerance = (double)NAN},
                                       {.normal = {0.0, (double)INFINITY, 0.0}},
                                       {.repair = 3}};
  tsolid_coons *coons = NULL;
  CHECK(tsolid_coons_create(NULL, border, NULL, NULL, &coons) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_coons_create(context, NULL, NULL, NULL, &coons) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_coons_create(context, border, NULL, NULL, NULL) == TSOLID_ERROR_ARGUMENT);
  for (int i = 0; i < 4; i++)
    CHECK(tsolid_coons_create(context, border, &bad[i], NULL, &coons) == TSOLID_ERROR_ARGUMENT &&
          !coons);
  const tsolid_coons_options named = {.name = "Face3", .corner_name = {"V1", "V2", "V3", "V4"}};
  CHECK(tsolid_coons_create(context, border, &named, NULL, &coons) == TSOLID_OK);
  tsolid_patch patch;
  tsolid_coons_get(coons, &patch);
  CHECK(strcmp(patch.name, "Face3") == 0 && strcmp(patch.corner_name[2], "V3") == 0);
  CHECK(!patch.border_name[0] && patch.border_tolerance[1] == 1e-7);
  tsolid_coons_free(coons);
  tsolid_coons_free(NULL);
}

/* Every allocation fails once: a status, nothing leaks. */
static void test_memory(void) {
  flat_loop loop = ell();
  tsolid_curve border[4];
  for (int k = 0; k < 4; k++)
    border[k] = flat_view(&loop.border[k]);
  meter m = {.limit = (size_t)1 << 30, .countdown = -1};
  tsolid_context *context = new_counted_context(&m);
  size_t before = m.live;
  tsolid_status status = TSOLID_ERROR_MEMORY;
  int n_failed = 0;
  for (long k = 0; status == TSOLID_ERROR_MEMORY && k < 5000; k++) {
    tsolid_coons *coons = NULL;
    m.countdown = k;
    status = tsolid_coons_create(context, border, NULL, NULL, &coons);
    m.countdown = -1;
    CHECK((status == TSOLID_OK) == (coons != NULL));
    n_failed += status == TSOLID_ERROR_MEMORY;
    tsolid_coons_free(coons);
    tsolid_context_clear(context);
  }
  CHECK(status == TSOLID_OK && n_failed > 100);
  CHECK(m.live <= before + 16 * sizeof(tsolid_finding));
  tsolid_context_free(context);
  CHECK(m.live == 0);
}

/* ---- soundness ---------------------------------------------------------------------------------
 */

/* N / W^3 at u, in long double, by de Boor's functions. */
static double determinant(const tsi_planar *p, const double u[2]) {
  double value[2][TSI_MAX_ORDER], slope[2][TSI_MAX_ORDER];
  long double h[3][3] = {{0.0L}};
  int first[2];
  for (int d = 0; d < 2; d++)
    first[d] = tsi_bspline_basis(p->degree[d], p->n[d], p->knots[d], u[d], value[d], slope[d]);
  for (int j = 0; j <= p->degree[1]; j++)
    for (int i = 0; i <= p->degree[0]; i++) {
      size_t row = (size_t)(first[0] + i) + (size_t)p->n[0] * (size_t)(first[1] + j);
      const long double f[3] = {(long double)value[0][i] * value[1][j],
                                (long double)slope[0][i] * value[1][j],
                                (long double)value[0][i] * slope[1][j]};
      const long double w = p->weight[row],
                        x[3] = {w * p->point[2 * row], w * p->point[2 * row + 1], w};
      for (int d = 0; d < 3; d++)
        for (int c = 0; c < 3; c++)
          h[d][c] += f[d] * x[c];
    }
  long double det = h[0][0] * (h[1][1] * h[2][2] - h[1][2] * h[2][1]) -
                    h[0][1] * (h[1][0] * h[2][2] - h[1][2] * h[2][0]) +
                    h[0][2] * (h[1][0] * h[2][1] - h[1][1] * h[2][0]);
  return (double)(det / (h[0][2] * h[0][2] * h[0][2]));
}

/* The least determinant at u, seen from all sides: derivatives may jump there. */
static double least_beside(const tsi_planar *p, const double u[2]) {
  double least = INFINITY;
  for (int k = 0; k < 4; k++) {
    double at[2] = {fmin(fmax(u[0] + (k & 1 ? 1e-13 : -1e-13), 0.0), 1.0),
                    fmin(fmax(u[1] + (k & 2 ? 1e-13 : -1e-13), 0.0), 1.0)};
    least = fmin(least, determinant(p, at));
  }
  return least;
}

typedef struct net {
  tsi_planar planar;
  double knots[2][16], point[128], weight[64];
} net;

static void random_net(net *n, int rational) {
  tsi_planar *p = &n->planar;
  for (int d = 0; d < 2; d++) {
    int q = p->degree[d] = random_int(1, 4), spans = random_int(1, 3);
    p->n[d] = q + spans;
    p->knots[d] = n->knots[d];
    for (int i = 0; i < p->n[d] + q + 1; i++)
      n->knots[d][i] = i <= q ? 0.0 : i >= p->n[d] ? 1.0 : (i - q) / (double)spans;
  }
  p->point = n->point;
  p->weight = n->weight;
  for (int i = 0; i < p->n[0] * p->n[1]; i++) {
    p->point[2 * i] = i % p->n[0] / (p->n[0] - 1.0) + 0.1 * (random_unit() - 0.5) / p->n[0];
    p->point[2 * i + 1] = i / p->n[0] / (p->n[1] - 1.0) + 0.1 * (random_unit() - 0.5) / p->n[1];
    p->weight[i] = rational ? exp(random_unit() - 0.5) : 1.0;
  }
}

/* A control point is pushed until the patch just folds: the verdict must change where the sampled
 * minimum changes its sign, and may be open only in between. */
static void test_soundness(tsolid_context *context) {
  int n_verdict[3] = {0, 0, 0};
  for (int k = 0; k < 30; k++) {
    net n;
    random_net(&n, k % 2);
    tsi_planar *p = &n.planar;
    int moved = random_int(0, p->n[0] * p->n[1] - 1);
    double angle = 2.0 * flat_pi * random_unit(), low = 0.0, high = 3.0;
    double at[2] = {p->point[2 * moved], p->point[2 * moved + 1]};
    for (int step = 0; step < 30; step++) {
      double middle = 0.5 * (low + high), worst = INFINITY;
      tsi_planar_outcome outcome;
      p->point[2 * moved] = at[0] + middle * cos(angle);
      p->point[2 * moved + 1] = at[1] + middle * sin(angle);
      CHECK(tsi_planar_certify(context, p, 0, 0.0, &outcome) == TSOLID_OK);
      for (int q = 0; q < 33 * 33; q++)
        worst = fmin(worst, determinant(p, (double[2]){q % 33 / 32.0, q / 33 / 32.0}));
      n_verdict[outcome.verdict]++;
      if (outcome.verdict == TSOLID_POSITIVE)
        CHECK(worst > 0.0);
      if (outcome.verdict == TSOLID_NOT_POSITIVE)
        CHECK(least_beside(p, outcome.u) <= 1e-11);
      if (outcome.verdict == TSOLID_UNDECIDED)
        CHECK(fabs(least_beside(p, outcome.u)) <= 2e-3); /* parts of 2^-14 are left */
      if (outcome.verdict == TSOLID_POSITIVE)
        low = middle;
      else
        high = middle;
    }
  }
  CHECK(n_verdict[TSOLID_POSITIVE] > 150 && n_verdict[TSOLID_NOT_POSITIVE] > 150);
  CHECK(n_verdict[TSOLID_UNDECIDED] < 150);
}

/* ---- prisms ------------------------------------------------------------------------------------
 */

/* Two caps made of the loop at two heights, and the four ruled faces between them, each with the
 * weights of its curve times a factor of its own. */
typedef struct prism {
  tsolid_patch patch[6];
  tsolid_coons *cap[2];
  double points[4][6 * FLAT_MAX_CONTROL], weights[4][2 * FLAT_MAX_CONTROL];
} prism;

static const double rising[4] = {0.0, 0.0, 1.0, 1.0};

static void make_prism(tsolid_context *context, tsi_arena *arena, const flat_loop *loop,
                       prism *out) {
  static const double factor[4] = {1.0, 3.0, 0.25, 2.0};
  memset(out, 0, sizeof *out);
  for (int end = 0; end < 2; end++) {
    flat_loop at = *loop;
    for (int k = 0; k < 4; k++)
      for (int i = 0; i < at.border[k].n; i++)
        at.border[k].point[i][2] = end;
    made m = make(context, arena, &at, NULL);
    if (CHECK(m.coons))
      out->patch[end] = m.patch;
    out->cap[end] = m.coons;
  }
  for (int k = 0; k < 4; k++) {
    const flat_curve *c = &loop->border[k];
    out->patch[2 + k] = (tsolid_patch){.degree = {c->degree, 1},
                                       .n_control = {c->n, 2},
                                       .knots = {c->knots, rising},
                                       .points = out->points[k],
                                       .weights = out->weights[k]};
    for (int i = 0; i < 2 * c->n; i++) {
      memcpy(out->points[k] + 3 * (ptrdiff_t)i, c->point[i % c->n], 2 * sizeof(double));
      out->points[k][3 * i + 2] = i >= c->n;
      out->weights[k][i] = factor[k] * c->weight[i % c->n];
    }
  }
}

/* The solid of a prism: its volume by the boundary's flux is the area; proved valid at the end. */
static void expect_prism(tsolid_context *context, const flat_loop *loop, int n_bilinear,
                         double area) {
  static prism p;
  tsi_arena arena = tsi_arena_create(context);
  tsolid_boundary *boundary = NULL;
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_solid *start = NULL, *solid = NULL;
  tsolid_certificate certificate;
  tsolid_report report;
  tsolid_preparation preparation;
  const tsolid_solid_options quick = {.effort = 2};
  make_prism(context, &arena, loop, &p);
  tsolid_boundary_input input = {.n_patches = 6, .patches = p.patch};
  if (CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_OK)) {
    tsolid_boundary_preparation(boundary, &preparation);
    CHECK((preparation.n_bilinear_factors > 0) == (n_bilinear > 0));
    for (int k = 0; k < 12; k++)
      CHECK_NEAR(preparation.snap[k], 0.0, 1e-13);
    CHECK(tsolid_tmesh_create(context, boundary, NULL, &tmesh) == TSOLID_OK &&
          tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK &&
          tsolid_solid_create(context, space, &start) == TSOLID_OK &&
          tsolid_solid_optimise(context, start, &quick, &solid) == TSOLID_OK &&
          tsolid_certify(context, solid, NULL, &certificate, NULL) == TSOLID_OK &&
          tsolid_report_measure(context, solid, NULL, &report) == TSOLID_OK);
    CHECK(solid && certificate.verdict == TSOLID_POSITIVE);
    CHECK(solid && fabs(report.conformity.flux / area - 1.0) <= 1e-9);
  } else {
    for (int i = 0; i < tsolid_context_n_findings(context); i++)
      fprintf(stderr, "    %s\n", tsolid_context_finding(context, i)->text);
  }
  tsolid_solid_free(solid);
  tsolid_solid_free(start);
  tsolid_space_free(space);
  tsolid_tmesh_free(tmesh);
  tsolid_boundary_free(boundary);
  for (int end = 0; end < 2; end++)
    tsolid_coons_free(p.cap[end]);
  tsi_arena_free(&arena);
}

static void test_prisms(tsolid_context *context) {
  flat_loop loop = circle(1.0);
  expect_prism(context, &loop, 0, flat_pi);
  loop = ell();
  expect_prism(context, &loop, 0, 3.0);
  for (int k = 0; k < 4; k++) { /* weights that no constants close */
    static const double end[4] = {1.7, 0.6, 2.0, 1.3}, origin[3] = {0.0, 0.0, 0.0};
    double area[3];
    loop = circle(1.0);
    for (int b = 0; b < 4; b++) { /* flatter conics, with ends of unequal weights */
      flat_curve *c = &loop.border[(b + k) % 4];
      c->point[1][0] *= 0.85;
      c->point[1][1] *= 0.85;
      c->weight[1] *= end[b];
      c->weight[2] *= end[b] * end[b];
    }
    tsi_arena arena = tsi_arena_create(context);
    made m = make(context, &arena, &loop, NULL);
    CHECK(m.coons && m.report.linear_border == 0 && m.report.n_singular == 0);
    CHECK(m.coons && m.patch.degree[0] == 3 && m.patch.degree[1] == 2);
    tsolid_coons_free(m.coons);
    tsi_arena_free(&arena);
    flat_green_area(&loop, origin, area);
    if (k < 2)
      expect_prism(context, &loop, 1, area[2]);
  }
}

/* The border of the least degree is the one that is multiplied, whatever its number. */
static void test_linear_factor(tsolid_context *context) {
  flat_loop loop;
  for (int k = 0; k < 4; k++) {
    static const int turned[4][4] = {{0, 1, 2, 3}, {3, 0, 1, 2}, {2, 3, 0, 1}, {1, 2, 3, 0}};
    static const double bow[3][3][2] = {
        {{1, 0}, {1.2, 0.5}, {1, 1}}, {{0, 1}, {0.5, 1.2}, {1, 1}}, {{0, 0}, {-0.2, 0.5}, {0, 1}}};
    flat_loop flat = circle(1.0);
    flat.border[0] = FLAT_LINE(0, 0, 1, 0);
    for (int i = 0; i < 9; i++)
      memcpy(flat.border[1 + i / 3].point[i % 3], bow[i / 3][i % 3], 2 * sizeof(double));
    flat.border[2].weight[0] = 4.0;
    for (int b = 0; b < 4; b++) { /* the loop begins at another corner */
      loop.border[b] = flat.border[turned[k][b]];
      if ((b < 2) != (turned[k][b] < 2))
        flat_reverse(&loop.border[b]);
    }
    double area[3];
    static const double origin[3] = {0.0, 0.0, 0.0};
    tsi_arena arena = tsi_arena_create(context);
    made m = make(context, &arena, &loop, NULL);
    if (CHECK(m.coons)) {
      CHECK(turned[k][m.report.linear_border] == 0 &&
            m.patch.degree[m.report.linear_border & 1] == 2);
      check_identities(&m, &loop);
    }
    tsolid_coons_free(m.coons);
    tsi_arena_free(&arena);
    flat_green_area(&loop, origin, area);
    if (k == 1)
      expect_prism(context, &loop, 1, area[2]);
  }
}

int main(void) {
  tsolid_context *context = NULL;
  if (tsolid_context_create(NULL, &context))
    return 1;
  test_random(context);
  test_arcs(context);
  test_far_disc(context);
  test_repair(context);
  test_prisms(context);
  test_linear_factor(context);
  test_refusals(context);
  test_meetings(context);
  test_malformed(context);
  test_mutations(context);
  test_arguments(context);
  test_memory();
  test_soundness(context);
  tsolid_context_free(context);
  return check_done();
}
