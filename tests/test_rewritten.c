/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Patches whose weights or parameters were rewritten so that the surface is the same: bilinear
 * factors, Moebius changes, both and constants; and what looks like one but is none. */
#include "boundary_checks.h"
#include "patch.h"

static const axis_spec wavy_axes[3] = {
    {1, {{3, 3, {0.25, 0.3, 0.7}}}}, {1, {{2, 1, {0.4}}}}, {1, {{4, 4, {0.2, 0.5, 0.5, 0.9}}}}};

static const axis_spec grid_axes[3] = {{2, {{3, 2, {0.3, 0.6}}, {2, 1, {0.55}}}},
                                       {2, {{2, 0, {0}}, {2, 2, {0.1, 0.3}}}},
                                       {2, {{1, 1, {0.5}}, {3, 0, {0}}}}};

static const axis_spec sector_axes[3] = {
    {1, {{2, 0, {0}}}}, {1, {{1, 0, {0}}}}, {1, {{2, 0, {0}}}}};

static void map_wavy(const double u[3], double point[3], double *weight) {
  point[0] = 3.0 * u[0] + 0.2 * sin(3.0 * u[1] + u[2]);
  point[1] = 2.0 * u[1] + 0.15 * cos(2.0 * u[0] - u[2]) + 0.3 * u[0];
  point[2] = 1.5 * u[2] + 0.2 * sin(2.0 * u[0] + 2.0 * u[1]) - 4.0;
  *weight = 1.0 + 0.5 * u[0] + 0.25 * u[1] * u[2];
}

/* A quarter of a thick ring, bent once more: exact arcs in x and in z. */
static void map_sector(const double u[3], double point[3], double *weight) {
  double r = 2.0 + u[1], a[2] = {u[0]<0.75, u[0]> 0.25}, b[2] = {u[2]<0.75, u[2]> 0.25};
  point[0] = r * a[0] * (4.0 + b[1]);
  point[1] = r * a[1] * (4.0 + b[1]);
  point[2] = 3.0 * b[1] + r * (1.0 - b[0]);
  *weight = (a[0] * a[1] > 0.0 ? sqrt(0.5) : 1.0) * (b[0] * b[1] > 0.0 ? sqrt(0.5) : 1.0);
}

static part make_kind(int kind) {
  return kind == 0   ? make_part(sector_axes, map_sector, 1)
         : kind == 1 ? make_part(wavy_axes, map_wavy, 1)
                     : make_part(grid_axes, map_wavy, 1);
}

/* ---- rewriting ---------------------------------------------------------------------------------
 */

typedef struct change {
  double corner[4]; /* bilinear factor, once more for each of n_factors */
  int n_factors;
  double c[2]; /* parameters u, v become those of u = c t/(c t + 1 - t) */
} change;

/* Rewrites the patch, and checks against de Boor's algorithm that its surface stays. */
static void rewrite(tsolid_context *context, tsolid_patch *patch, const change *how) {
  tsi_arena arena = tsi_arena_create(context);
  tsi_patch own;
  tsolid_patch old = *patch;
  int n_raised;
  CHECK(tsi_patch_read(&arena, patch, &own));
  for (int i = 0; i < how->n_factors; i++)
    CHECK(tsi_patch_multiply(&arena, &own, how->corner, &n_raised));
  for (int d = 0; d < 2; d++)
    if (how->c[d] > 0.0)
      CHECK(tsi_patch_reparametrise(&own, d, how->c[d]));
  size_t n = (size_t)own.n[0] * (size_t)own.n[1];
  double *points = part_doubles(3 * n), *weights = part_doubles(n);
  for (size_t i = 0; i < n; i++) {
    weights[i] = own.control[4 * i + 3];
    for (size_t k = 0; k < 3; k++)
      points[3 * i + k] = own.control[4 * i + k] / weights[i];
  }
  for (int d = 0; d < 2; d++) {
    size_t n_knots = (size_t)(own.n[d] + own.degree[d] + 1);
    double *knots = part_doubles(n_knots);
    memcpy(knots, own.knots[d], n_knots * sizeof *knots);
    patch->knots[d] = knots;
    patch->degree[d] = own.degree[d];
    patch->n_control[d] = own.n[d];
  }
  patch->points = points;
  patch->weights = weights;
  double worst = 0.0;
  for (int i = 0; i < 40; i++) {
    double t[2] = {random_unit(), random_unit()}, u[2], x[3], y[3];
    for (int d = 0; d < 2; d++)
      u[d] = how->c[d] > 0.0 ? how->c[d] * t[d] / (how->c[d] * t[d] + 1.0 - t[d]) : t[d];
    evaluate_patch(patch, t[0], t[1], x);
    evaluate_patch(&old, u[0], u[1], y);
    worst = fmax(worst, hypot(hypot(x[0] - y[0], x[1] - y[1]), x[2] - y[2]));
  }
  CHECK_NEAR(worst, 0.0, 1e-13);
  part gone = {1, malloc(sizeof old)};
  gone.patch[0] = old;
  part_free(&gone);
  tsi_arena_free(&arena);
}

static void scale_weights(part *p) {
  for (int k = 0; k < p->n; k++)
    for (int i = 0; i < p->patch[k].n_control[0] * p->patch[k].n_control[1]; i++)
      ((double *)(size_t)p->patch[k].weights)[i] *= 0.3 + 0.7 * (k % 6);
}

/* ---- taken -------------------------------------------------------------------------------------
 */

/* The boundary of a rewritten part: sound, at every parameter where the part was given. */
static void check_taken(tsolid_context *context, const part *p, int n_bilinear, int n_moebius) {
  tsolid_boundary *boundary = create(context, p, NULL);
  if (!boundary)
    return;
  CHECK(tsi_boundary_validate(context, boundary) == TSOLID_OK);
  CHECK_NEAR(measure_distance(p, boundary), 0.0, 1e-13);
  CHECK_NEAR(largest_snap(boundary) / tsolid_boundary_scale(boundary), 0.0, 1e-14);
  CHECK_NEAR(boundary->preparation.knot_merge, 0.0, 4e-15);
  CHECK((boundary->preparation.n_bilinear_factors > 0) == (n_bilinear > 0));
  CHECK(boundary->preparation.n_moebius == n_moebius);
  int n_changed = 0;
  for (int k = 0; k < p->n; k++)
    n_changed +=
        (boundary->placement[k].moebius[0] != 1.0) + (boundary->placement[k].moebius[1] != 1.0);
  CHECK(n_changed == n_moebius);
  for (int i = 0; i < boundary->n_functions; i++)
    CHECK(boundary->points[4 * i + 3] > 0.02 && boundary->points[4 * i + 3] < 50.0);
  tsolid_boundary_free(boundary);
}

static void test_bilinear(tsolid_context *context) {
  static const change how[4] = {{{1.3, 0.7, 2.1, 0.9}, 1, {0, 0}},
                                {{1.0, 2.0, 1.0, 2.0}, 1, {0, 0}}, /* along u alone */
                                {{1.5, 1.5, 0.8, 0.8}, 1, {0, 0}}, /* along v alone */
                                {{0.5, 1.0, 1.0, 2.0}, 1, {0, 0}}};
  for (int kind = 0; kind < 3; kind++)
    for (int k = 0; k < 6; k++) {
      part p = make_kind(kind);
      int at = kind == 2 ? 4 * k + k % 4 : k;
      rewrite(context, &p.patch[at], &how[k % 4]);
      check_taken(context, &p, 1, 0);
      if (k % 2 == 0) { /* the opposite side as well, and a constant on each */
        rewrite(context, &p.patch[kind == 2 ? 4 * k + 4 + k % 4 : k + 1], &how[(k + 1) % 4]);
        check_taken(context, &p, 1, 0);
        scale_weights(&p);
        check_taken(context, &p, 1, 0);
      }
      part_free(&p);
    }
}

/* A factor on one side takes one degree on every axis, not one more for each belt that it meets. */
static void test_degrees(tsolid_context *context) {
  static const change how = {{1.3, 0.7, 2.1, 0.9}, 1, {0, 0}};
  part p = make_kind(0);
  tsolid_boundary *plain = create(context, &p, NULL);
  rewrite(context, &p.patch[2], &how);
  tsolid_boundary *boundary = create(context, &p, NULL);
  for (int side = 0; boundary && plain && side < 6; side++)
    for (int d = 0; d < 2; d++)
      CHECK(boundary->side[side].degree[d] == plain->side[side].degree[d] + 1);
  CHECK(boundary && boundary->preparation.n_bilinear_factors >= 4);
  CHECK(boundary && boundary->preparation.n_knots_inserted == 0);
  tsolid_boundary_free(plain);
  tsolid_boundary_free(boundary);
  part_free(&p);
}

static void test_moebius(tsolid_context *context) {
  static const double constant[5] = {0.4, 1.7, 3.0, 1.001, 6.0};
  for (int kind = 0; kind < 3; kind++)
    for (int k = 0; k < 5; k++)
      for (int d = 0; d < 2; d++) {
        part p = make_kind(kind);
        change how = {.c = {d ? 0.0 : constant[k], d ? constant[k] : 0.0}};
        rewrite(context, &p.patch[k], &how);
        check_taken(context, &p, 0, 1);
        rewrite(context, &p.patch[k], &how); /* c twice is c^2: still that one patch */
        if (constant[k] < 3.0)
          check_taken(context, &p, 0, 1);
        part_free(&p);
      }
}

/* The parameter that most patches of a belt share stands. */
static void test_majority(tsolid_context *context) {
  part p = make_kind(1);
  change along_x = {.c = {1.9, 0.0}};
  rewrite(context, &p.patch[2], &along_x); /* sides 2, 3 carry x as s, 4, 5 as well */
  rewrite(context, &p.patch[3], &along_x);
  rewrite(context, &p.patch[5], &along_x);
  tsolid_boundary *boundary = create(context, &p, NULL);
  if (boundary) {
    CHECK(boundary->preparation.n_moebius == 1);
    CHECK(boundary->placement[2].moebius[0] == 1.0 && boundary->placement[5].moebius[0] == 1.0);
    CHECK(boundary->placement[4].moebius[0] != 1.0 || boundary->placement[4].moebius[1] != 1.0);
    CHECK_NEAR(measure_distance(&p, boundary), 0.0, 1e-13);
  }
  tsolid_boundary_free(boundary);
  part_free(&p);
}

static void test_combined(tsolid_context *context) {
  static const change first = {{1.3, 0.7, 2.1, 0.9}, 1, {1.6, 0.0}},
                      second = {{0.8, 1.2, 1.1, 1.4}, 1, {0.7, 2.2}}, third = {{0}, 0, {0.0, 0.6}};
  for (int kind = 0; kind < 2; kind++) {
    part p = make_kind(kind);
    rewrite(context, &p.patch[2], &first);
    rewrite(context, &p.patch[3], &second);
    rewrite(context, &p.patch[5], &third);
    scale_weights(&p);
    tsolid_boundary *boundary = create(context, &p, NULL);
    CHECK(boundary && boundary->preparation.n_moebius == 4);
    CHECK(boundary && boundary->preparation.n_bilinear_factors > 0);
    tsolid_boundary_free(boundary);
    check_orientations(context, &p);
    check_shuffles(context, &p, 16, 1e-13);
    if (kind == 0) {
      tsolid_boundary_input input = {.n_patches = p.n, .patches = p.patch};
      check_failing_memory(&input);
    }
    part_free(&p);
  }
}

/* Options refine once, not once more for every factor. */
static void test_options(tsolid_context *context) {
  static const change how = {{1.3, 0.7, 2.1, 0.9}, 1, {1.6, 0.0}};
  tsolid_boundary_options options = {.refine_knots = 1, .raise_degree = 1};
  part p = make_kind(0);
  rewrite(context, &p.patch[4], &how);
  tsolid_boundary *boundary = create(context, &p, &options), *plain = create(context, &p, NULL);
  for (int side = 0; boundary && plain && side < 6; side++) {
    CHECK(boundary->side[side].n_elements == 4 * plain->side[side].n_elements);
    CHECK(boundary->side[side].degree[0] == plain->side[side].degree[0] + 1);
  }
  if (boundary)
    CHECK_NEAR(measure_distance(&p, boundary), 0.0, 1e-13);
  tsolid_boundary_free(boundary);
  tsolid_boundary_free(plain);
  part_free(&p);
}

/* ---- refused -----------------------------------------------------------------------------------
 */

static void expect_refused(tsolid_context *context, const part *p, const char *text) {
  tsolid_boundary *boundary = NULL;
  tsolid_requirement requirement;
  tsolid_boundary_input input = {.n_patches = p->n, .patches = p->patch};
  tsolid_context_clear(context);
  CHECK(tsolid_boundary_create(context, &input, NULL, &requirement, &boundary) ==
            TSOLID_ERROR_REFUSED &&
        !boundary && !requirement.satisfied && requirement.n_violations > 0);
  const tsolid_finding *finding = tsolid_context_finding(context, 0);
  if (!CHECK(finding && strstr(finding->text, text)))
    fprintf(stderr, "    '%s' is not in: %s\n", text, finding ? finding->text : "nothing");
  CHECK(finding && finding->measured > finding->allowed &&
        (finding->has_point || finding->entity != TSOLID_ENTITY_NONE));
  tsolid_context_clear(context);
}

static void test_refused(tsolid_context *context) {
  static const change square = {{1.0, 2.0, 1.5, 1.2}, 2, {0, 0}},
                      one = {{1.3, 0.7, 2.1, 0.9}, 1, {0, 0}},
                      other = {{0.8, 1.9, 0.7, 1.1}, 1, {0, 0}};
  for (int kind = 0; kind < 2; kind++) {
    part p = make_kind(kind);
    p.patch[2].name = "Face3";
    p.patch[4].name = "Face5";
    rewrite(context, &p.patch[2], &square); /* no bilinear factor undoes a square */
    expect_refused(context, &p, "no factor that is bilinear on each face");
    part_free(&p);
    p = make_kind(kind); /* two neighbours with factors of their own */
    rewrite(context, &p.patch[2], &one);
    rewrite(context, &p.patch[4], &other);
    expect_refused(context, &p, "The weights of ");
    part_free(&p);
  }
}

/* One border of a face in another projective parameter, the opposite one not: no change of the
 * whole face can serve both. */
static void test_half_moebius(tsolid_context *context) {
  part p = make_kind(0);
  tsolid_patch *patch = &p.patch[2]; /* degree 2 along x and z, one span */
  patch->name = "Face3";
  double *weights = (double *)(size_t)patch->weights;
  for (int i = 0; i < 9; i++) /* none on u low and v high, 1.8 and 1.8^2 ... on the other two */
    weights[i] *= pow(1.8, i % 3 * 0.5 * (2 - i / 3));
  expect_refused(context, &p, "Face3");
  tsolid_boundary *boundary = NULL;
  tsolid_boundary_input input = {.n_patches = p.n, .patches = p.patch};
  CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_ERROR_REFUSED);
  CHECK(strstr(tsolid_context_finding(context, 0)->text, "one curve with different parameters"));
  tsolid_context_clear(context);
  part_free(&p);
  p = make_kind(0); /* so far away that knots and weights would suffer */
  change how = {.c = {1e7, 0.0}};
  tsi_arena arena = tsi_arena_create(context);
  tsi_patch own;
  CHECK(tsi_patch_read(&arena, &p.patch[2], &own));
  CHECK(!tsi_patch_reparametrise(&own, 0, how.c[0]));
  CHECK(own.control[4] == p.patch[2].weights[1] * p.patch[2].points[3]);
  tsi_arena_free(&arena);
  part_free(&p);
}

int main(void) {
  tsolid_context *context = new_context();
  test_bilinear(context);
  test_degrees(context);
  test_moebius(context);
  test_majority(context);
  test_combined(context);
  test_options(context);
  test_refused(context);
  test_half_moebius(context);
  tsolid_context_free(context);
  return check_done();
}
