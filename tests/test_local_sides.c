/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Sides that are no tensor grids, with functions that the library has never heard of: truncated
 * hierarchical B-splines refined towards a corner, and functions that live on several sides. The
 * whole chain is asked: octree, space, start, optimisation, report, file. */
#include "check.h"

#include "conform.h"
#include "local_part.h"
#include "octree_rules.h"

/* ---- functions across isolines ------------------------------------------------------------------
 */

/* Function `gone` becomes half of each of two others on one side: where it stands, they grow. */
static tsolid_bezier_side spread_function(const tsolid_bezier_side *side, int gone,
                                          const int heir[2]) {
  size_t width = (size_t)(side->degree[0] + 1) * (size_t)(side->degree[1] + 1);
  size_t most = 2 * (size_t)side->function_start[side->n_elements];
  int *start = calloc((size_t)side->n_elements + 1, sizeof *start), n = 0;
  int *function = calloc(most, sizeof *function);
  double *coefficient = calloc(most * width, sizeof *coefficient);
  for (int e = 0; e < side->n_elements; e++) {
    int first = n;
    for (int k = side->function_start[e]; k < side->function_start[e + 1]; k++)
      for (int way = 0; way < (side->function[k] == gone ? 2 : 1); way++) {
        int f = side->function[k] == gone ? heir[way] : side->function[k], at = first;
        while (at < n && function[at] != f)
          at++;
        n += at == n;
        function[at] = f;
        for (size_t i = 0; i < width; i++)
          coefficient[(size_t)at * width + i] +=
              (side->function[k] == gone ? 0.5 : 1.0) * side->coefficient[(size_t)k * width + i];
      }
    start[e + 1] = n;
  }
  double *box = calloc(4 * (size_t)side->n_elements, sizeof *box);
  memcpy(box, side->box, 4 * (size_t)side->n_elements * sizeof *box);
  return (tsolid_bezier_side){
      {side->degree[0], side->degree[1]}, side->n_elements, box, start, function, coefficient};
}

static void free_side(const tsolid_bezier_side *s) {
  const void *owned[] = {s->box, s->function_start, s->function, s->coefficient};
  for (int k = 0; k < 4; k++)
    free((void *)(uintptr_t)owned[k]);
}

/* Takes function `gone` out of the boundary; its neighbours on the two sides share it. */
static void spread(tsolid_bezier_boundary *b, int gone, int first, int second) {
  const int heir[2] = {first, second};
  for (int side = 0; side < 6; side++) {
    tsolid_bezier_side spread = spread_function(&b->side[side], gone, heir);
    free_side(&b->side[side]);
    b->side[side] = spread;
    for (int k = 0; k < spread.function_start[spread.n_elements]; k++)
      ((int *)(uintptr_t)spread.function)[k] -= spread.function[k] > gone;
  }
  double *points = (double *)(uintptr_t)b->points;
  memmove(points + 4 * gone, points + 4 * (gone + 1),
          4 * (size_t)(b->n_functions - gone - 1) * sizeof *points);
  b->n_functions--;
}

static int place_id(const cube_part *part, int i, int j, int k) {
  return part->id[i + part->n[0] * (j + part->n[1] * k)];
}

/* The isolines along z of a tensor cube, but for their ends: functions of both sides instead. */
static cube_part smooth_part(void) {
  static const cube_axis axis[3] = {{3, 3, 1}, {2, 4, 1}, {3, 5, 1}};
  cube_part part = cube_part_create(axis, cube_wave);
  for (int corner = 0; corner < 4; corner++) {
    int i = corner & 1 ? part.n[0] - 1 : 0, j = corner & 2 ? part.n[1] - 1 : 0;
    int inside_i = corner & 1 ? i - 1 : 1, inside_j = corner & 2 ? j - 1 : 1;
    for (int k = 2; k < part.n[2] - 2; k++) {
      int gone = place_id(&part, i, j, k);
      spread(&part.boundary, gone, place_id(&part, inside_i, j, k),
             place_id(&part, i, inside_j, k));
      for (int g = 0; g < part.n[0] * part.n[1] * part.n[2]; g++)
        part.id[g] = part.id[g] == gone ? -1 : part.id[g] - (part.id[g] > gone);
    }
  }
  return part;
}

/* ---- the whole chain
 * ---------------------------------------------------------------------------------- */

static void check_report(const tsolid_report *r) {
  CHECK_NEAR(r->basis.sum_defect, 0.0, 1e-12);
  CHECK_NEAR(r->basis.diagonal_jump, 0.0, 1e-12);
  CHECK_NEAR(r->basis.core_jump, 0.0, 1e-12);
  CHECK(r->basis.smallest_value >= 0.0);
  CHECK(r->basis.rank_measured);
  CHECK(r->basis.inner_eigenvalue > r->basis.inner_roundoff);
  CHECK(r->basis.surface_eigenvalue > r->basis.surface_roundoff);
  CHECK(r->conformity.control_identical);
  CHECK_NEAR(r->conformity.distance, 0.0, 1e-12 * r->conformity.scale);
  CHECK_NEAR(r->conformity.volume, r->conformity.flux, 1e-12 * fabs(r->conformity.flux));
  CHECK(r->continuity.n_below_expected == 0);
  CHECK(r->certificate.verdict == TSOLID_POSITIVE);
  CHECK(r->quality.worst > 0.0 && r->quality.worst <= r->quality.bound + 1e-9);
  CHECK(r->statistics.interior_extraordinary_nodes == 8);
}

static void check_chain(tsolid_context *context, const tsolid_bezier_boundary *bezier,
                        int min_cells) {
  tsolid_boundary_input input = {.bezier = bezier};
  tsolid_tmesh_options tmesh_options = {.min_cells = min_cells};
  tsolid_solid_options effort = {.effort = 2};
  tsolid_boundary *boundary = NULL;
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_solid *start = NULL, *solid = NULL;
  tsolid_report report;
  if (CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_OK) &&
      CHECK(tsolid_tmesh_create(context, boundary, &tmesh_options, &tmesh) == TSOLID_OK) &&
      CHECK(tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK) &&
      CHECK(tsolid_solid_create(context, space, &start) == TSOLID_OK) &&
      CHECK(tsolid_solid_optimise(context, start, &effort, &solid) == TSOLID_OK) &&
      CHECK(tsolid_report_measure(context, solid, NULL, &report) == TSOLID_OK)) {
    check_rule(tmesh, boundary);
    check_balance(context, tmesh, boundary, min_cells);
    check_report(&report);
  }
  tsolid_solid_free(solid);
  tsolid_solid_free(start);
  tsolid_space_free(space);
  tsolid_tmesh_free(tmesh);
  tsolid_boundary_free(boundary);
}

/* Refined towards a corner, twice, by boxes of unequal sides. */
static void test_corner(tsolid_context *context) {
  static const local_region region[2][3] = {
      {{{0}, {0}}, {{0, 0, 0}, {3, 2, 2}}, {{0, 0, 0}, {3, 4, 3}}},
      {{{0}, {0}}, {{1, 2, 0}, {4, 4, 3}}, {{5, 4, 0}, {8, 7, 3}}}};
  for (int k = 0; k < 2; k++) {
    local_part part = local_part_create(2 + k, 4, 3, region[k], k ? cube_rational : cube_wave);
    int n = part.boundary.side[k].n_elements;
    CHECK(n > 16 && n % 3 == 1 && n < 256); /* no tensor grid */
    check_chain(context, &part.boundary, 1 + 2 * k);
    local_part_free(&part);
  }
}

static void test_across(tsolid_context *context) {
  cube_part part = smooth_part();
  int all = part.n[0] * part.n[1] * part.n[2];
  int inside = (part.n[0] - 2) * (part.n[1] - 2) * (part.n[2] - 2);
  CHECK(part.boundary.n_functions == all - inside - 4 * (part.n[2] - 4));
  check_chain(context, &part.boundary, 3);
  cube_part_free(&part);
}

int main(void) {
  tsolid_context *context;
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  test_corner(context);
  test_across(context);
  tsolid_context_free(context);
  return check_done();
}
