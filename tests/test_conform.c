/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Conformity: known volumes, volume against flux, distance to the input, and that a control point
 * moved by 1e-9 of the part's size is noticed; the report as a whole. */
#include "check.h"

#include "cube_part.h"
#include "quadrature.h"

/* ---- quadrature --------------------------------------------------------------------------------
 */

/* n points are exact to degree 2n - 1 and no further. */
static void check_rules(void) {
  double node[TSI_MAX_GAUSS], weight[TSI_MAX_GAUSS];
  for (int n = 1; n <= TSI_MAX_GAUSS; n++) {
    tsi_gauss(n, node, weight);
    for (int k = 0; k <= 2 * n; k++) {
      double sum = 0.0, exact = 1.0 / (k + 1);
      for (int i = 0; i < n; i++)
        sum += weight[i] * pow(node[i], k);
      if (k < 2 * n)
        CHECK_NEAR(sum, exact, 4e-15);
      else if (n <= 8)
        CHECK(fabs(sum - exact) > 1e-12);
    }
    for (int i = 1; i < n; i++)
      CHECK(node[i - 1] < node[i] && node[i - 1] > 0.0 && node[i] < 1.0);
  }
}

/* A sum that plain addition gets wrong. */
static void check_sum(void) {
  tsi_sum sum = {0.0, 0.0};
  tsi_sum_add(&sum, 1.0);
  tsi_sum_add(&sum, 1e100);
  tsi_sum_add(&sum, 1.0);
  tsi_sum_add(&sum, -1e100);
  CHECK(tsi_sum_get(&sum) == 2.0);
}

/* ---- parts of known volume ---------------------------------------------------------------------
 */

static void brick(double p[4]) {
  p[0] = 5.0 * p[0] - 70.0;
  p[1] = 0.02 * p[1] + 31.0;
  p[2] = 3.0 * p[2];
}

/* Weights alone: faces stay flat and isolines straight, whatever the parameters do. */
static void weighted_brick(double p[4]) {
  double x = p[0], y = p[1], z = p[2];
  p[3] = 1.0 + 0.6 * sin(5.0 * x + 3.0 * y - 4.0 * z);
  p[0] = 2.0 * x;
  p[1] = y;
  p[2] = 3.0 * z;
}

/* A shear by a quadratic: a polynomial of degree 2 along x, volume unchanged. */
static void sheared(double p[4]) {
  p[2] += p[0] * p[0] + 0.3 * p[1];
}

static void far_away(double p[4]) {
  cube_rational(p);
  p[0] += 3e3;
  p[1] -= 2e3;
}

static void check_part(tsolid_context *context, const cube_axis axis[3], cube_map map,
                       double volume) {
  cube_solid s;
  tsolid_conformity_report r;
  if (CHECK(cube_solid_create(context, axis, map, 0, 0.0, &s)) &&
      CHECK(tsi_conformity_measure(context, s.solid, &r) == TSOLID_OK)) {
    CHECK(r.control_identical);
    CHECK(r.n_samples == 6000);
    CHECK(r.scale == s.boundary->scale);
    CHECK_NEAR(r.distance, 0.0, 1e-14 * r.scale);
    CHECK(r.volume > 0.0);
    CHECK_NEAR(r.volume, r.flux, 1e-12 * r.flux);
    if (volume > 0.0)
      CHECK_NEAR(r.volume, volume, 1e-12 * volume);
  }
  cube_solid_free(&s);
}

/* The volume is that of the boundary wherever the inner points are: also in folded solids. */
static void check_scattered(tsolid_context *context, const cube_axis axis[3]) {
  cube_solid smooth, scattered;
  tsolid_conformity_report a, b;
  if (CHECK(cube_solid_create(context, axis, cube_wave, 0, 0.0, &smooth)) &&
      CHECK(tsi_conformity_measure(context, smooth.solid, &a) == TSOLID_OK))
    for (int k = 0; k < 2; k++) {
      if (CHECK(cube_solid_create(context, axis, cube_wave, k ? 5 : 0, 0.03, &scattered)) &&
          CHECK(tsi_conformity_measure(context, scattered.solid, &b) == TSOLID_OK)) {
        CHECK(b.flux == a.flux);
        CHECK_NEAR(b.volume, a.flux, 1e-12 * a.flux);
      }
      cube_solid_free(&scattered);
    }
  cube_solid_free(&smooth);
}

/* ---- what is broken on purpose -----------------------------------------------------------------
 */

/* Every boundary control point in turn, by 1e-9 of the scale. */
static void check_moved(tsolid_context *context, const cube_axis axis[3]) {
  cube_solid s;
  if (!CHECK(cube_solid_create(context, axis, cube_rational, 0, 0.0, &s)))
    return;
  int first = s.space->n_inner + s.space->n_surface, noticed = 1, identical = 0;
  for (int i = 0; i < s.space->n_surface; i += 1 + s.space->n_surface / 12) {
    tsolid_conformity_report r;
    double *x = &s.solid->control[4 * (first + i) + i % 3], kept = *x;
    *x += 1e-9 * s.boundary->scale;
    CHECK(tsi_conformity_measure(context, s.solid, &r) == TSOLID_OK);
    noticed &= r.distance > 1e-12 * r.scale;
    identical |= r.control_identical;
    *x = nextafter(kept, 2.0 * kept + 1.0);
    CHECK(tsi_conformity_measure(context, s.solid, &r) == TSOLID_OK);
    identical |= r.control_identical;
    *x = kept;
  }
  CHECK(noticed);
  CHECK(!identical);
  cube_solid_free(&s);
}

/* A NaN is not a small distance. */
static void check_nan(tsolid_context *context) {
  cube_axis axis[3] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  cube_solid s;
  tsolid_conformity_report r;
  if (CHECK(cube_solid_create(context, axis, NULL, 0, 0.0, &s))) {
    s.solid->control[4 * (s.space->n_inner + s.space->n_surface)] = (double)NAN;
    CHECK(tsi_conformity_measure(context, s.solid, &r) == TSOLID_OK);
    CHECK(!(r.distance <= 1.0));
    CHECK(!(fabs(r.volume - r.flux) <= 1.0));
  }
  cube_solid_free(&s);
}

/* ---- the report --------------------------------------------------------------------------------
 */

static int measure_report(const tsolid_solid *solid, int n_threads, tsolid_report *report) {
  tsolid_context_options options = {.n_threads = n_threads};
  tsolid_context *context;
  tsolid_report_options choice = {.max_rank_functions = 0};
  if (!CHECK(tsolid_context_create(&options, &context) == TSOLID_OK))
    return 0;
  int done = CHECK(tsolid_report_measure(context, solid, &choice, report) == TSOLID_OK);
  tsolid_context_free(context);
  return done;
}

static void check_report(tsolid_context *context) {
  cube_axis axis[3] = {{3, 3, 1}, {2, 2, 1}, {3, 2, 1}};
  cube_solid s;
  tsolid_report one, three;
  if (CHECK(cube_solid_create(context, axis, cube_wave, 0, 0.0, &s)) &&
      measure_report(s.solid, 1, &one) && measure_report(s.solid, 3, &three)) {
    CHECK(one.statistics.input_nodes == s.boundary->n_functions);
    CHECK(one.statistics.input_elements == 2 * (3 * 2 + 3 * 2 + 2 * 2));
    CHECK(one.statistics.interior_extraordinary_nodes == 8);
    CHECK(one.statistics.n_functions == s.space->n_inner + 2 * s.boundary->n_functions);
    CHECK(one.statistics.bezier_elements == s.space->n_elements);
    CHECK(one.statistics.core_cells == s.tmesh->n_boxes);
    int cells = 0; /* 12 (n - 1) + 8 for n cells per axis */
    for (int d = 0; d < 3; d++)
      cells += 4 * (s.tmesh->n_lines[d] - 2);
    CHECK(one.statistics.partial_extraordinary_nodes == cells + 8);
    CHECK(one.requirement.satisfied);
    CHECK(one.certificate.n_elements == s.space->n_elements);
    CHECK(one.certificate.verdict == TSOLID_POSITIVE && one.quality.worst > 0.0);
    CHECK(one.quality.worst == three.quality.worst);
    CHECK(isnan(one.timing.total) && one.timing.report >= 0.0 && one.timing.certify >= 0.0);
    CHECK(one.conformity.volume == three.conformity.volume);
    CHECK(one.conformity.flux == three.conformity.flux);
    CHECK(one.conformity.distance == three.conformity.distance);
    CHECK(one.basis.inner_eigenvalue == three.basis.inner_eigenvalue);
    CHECK(one.continuity.area[1] == three.continuity.area[1]);
    CHECK(one.continuity.n_below_expected == 0);
    CHECK(one.basis.sum_defect < 1e-12);
  }
  CHECK(tsolid_report_measure(context, NULL, NULL, &one) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_report_measure(NULL, s.solid, NULL, &one) == TSOLID_ERROR_ARGUMENT);
  cube_solid_free(&s);
}

/* Cancelled at every progress call: nothing is written, nothing leaks. */
typedef struct stopper {
  int calls, stop_at;
} stopper;

static int stop(void *data, const char *stage, double fraction) {
  stopper *s = data;
  (void)stage;
  (void)fraction;
  return s->calls++ == s->stop_at;
}

static void check_cancel(const tsolid_solid *solid) {
  tsolid_status status = TSOLID_ERROR_CANCELLED;
  for (int at = 0; status != TSOLID_OK && at < 1000; at++) {
    stopper s = {.stop_at = at};
    tsolid_context_options options = {.progress = stop, .progress_data = &s};
    tsolid_context *context;
    tsolid_report report;
    memset(&report, 77, sizeof report);
    tsolid_report untouched = report;
    if (!CHECK(tsolid_context_create(&options, &context) == TSOLID_OK))
      return;
    status = tsolid_report_measure(context, solid, NULL, &report);
    if (status != TSOLID_OK) {
      CHECK(status == TSOLID_ERROR_CANCELLED);
      CHECK(memcmp(&report, &untouched, sizeof report) == 0);
      int last = tsolid_context_n_findings(context) - 1;
      CHECK(last >= 0 && tsolid_context_finding(context, last)->status == TSOLID_ERROR_CANCELLED);
    } else {
      CHECK(at > 4);
    }
    tsolid_context_free(context);
  }
}

/* Every allocation fails once: out of memory is said, and all memory comes back. */
typedef struct failing {
  long calls, fail_at, alive;
} failing;

static void *failing_allocate(void *data, size_t size) {
  failing *f = data;
  if (f->calls++ == f->fail_at)
    return NULL;
  f->alive++;
  return malloc(size);
}

static void failing_release(void *data, void *memory) {
  ((failing *)data)->alive--;
  free(memory);
}

static void check_memory(const tsolid_solid *solid) {
  tsolid_status status = TSOLID_ERROR_MEMORY;
  for (long at = 0; status != TSOLID_OK && at < 100000; at++) {
    failing f = {.fail_at = at};
    tsolid_context_options options = {.allocate = failing_allocate,
                                      .release = failing_release,
                                      .allocator_data = &f,
                                      .n_threads = 2};
    tsolid_context *context;
    tsolid_report report;
    double out[30], u[3] = {0.3, 0.4, 0.5};
    status = tsolid_context_create(&options, &context);
    if (status == TSOLID_OK)
      status = tsolid_solid_evaluate(context, solid, 0, u, 2, out);
    int found, block;
    double distance;
    if (status == TSOLID_OK)
      status = tsolid_solid_invert(context, solid, out, 0.0, &found, &block, u, &distance);
    if (status == TSOLID_OK)
      status = tsolid_report_measure(context, solid, NULL, &report);
    CHECK(status == TSOLID_OK || status == TSOLID_ERROR_MEMORY);
    tsolid_context_free(context);
    CHECK(f.alive == 0);
    CHECK(status != TSOLID_OK || at > 20);
  }
}

static void check_interruptions(tsolid_context *context) {
  cube_axis axis[3] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  cube_solid s;
  if (CHECK(cube_solid_create(context, axis, NULL, 0, 0.0, &s))) {
    check_cancel(s.solid);
    check_memory(s.solid);
  }
  cube_solid_free(&s);
}

int main(void) {
  static const cube_axis linear[3] = {{1, 1, 1}, {1, 2, 1}, {1, 3, 1}};
  static const cube_axis cubic[3] = {{3, 4, 1}, {3, 3, 2}, {3, 2, 1}};
  static const cube_axis mixed[3] = {{2, 3, 1}, {5, 1, 1}, {4, 2, 2}};
  static const cube_axis high[3] = {{9, 1, 1}, {7, 2, 1}, {1, 4, 1}};
  tsolid_context *context;
  check_rules();
  check_sum();
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  check_part(context, linear, NULL, 1.0);
  check_part(context, linear, brick, 0.3);
  check_part(context, cubic, brick, 0.3);
  check_part(context, high, brick, 0.3);
  check_part(context, linear, weighted_brick, 6.0);
  check_part(context, cubic, weighted_brick, 6.0);
  check_part(context, mixed, weighted_brick, 6.0);
  check_part(context, mixed, sheared, 1.0);
  check_part(context, cubic, cube_wave, 0.0);
  check_part(context, high, cube_wave, 0.0);
  check_part(context, mixed, cube_rational, 0.0);
  check_part(context, high, cube_rational, 0.0);
  check_part(context, cubic, far_away, 0.0);
  check_scattered(context, cubic);
  check_scattered(context, mixed);
  check_moved(context, linear);
  check_moved(context, mixed);
  check_nan(context);
  check_report(context);
  check_interruptions(context);
  tsolid_context_free(context);
  return check_done();
}
