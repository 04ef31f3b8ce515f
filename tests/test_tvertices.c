/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Corners inside neighbours' borders: patches are cut along isolines, exactly, until there are
 * none. Told by what must not change: the surface at every parameter as given, the grid and the
 * functions that the same part has when it is cut by hand, the bits whatever the order and
 * orientation of the patches. */
#include <stdio.h>

#include "boundary_checks.h"
#include "patch.h"
#include "tvertex_parts.h"

static const axis_spec cubics[3] = {{1, {{3, 0, {0}}}}, {1, {{3, 0, {0}}}}, {1, {{3, 0, {0}}}}};
static const axis_spec mixed[3] = {{1, {{2, 0, {0}}}}, {1, {{5, 0, {0}}}}, {1, {{3, 0, {0}}}}};
static const axis_spec linear[3] = {{1, {{1, 0, {0}}}}, {1, {{1, 0, {0}}}}, {1, {{1, 0, {0}}}}};

/* Lies anyhow in space, so that no two corners share a coordinate. */
static void map_wavy(const double u[3], double x[3], double *weight) {
  double a = 2.0 * u[0] + 0.15 * sin(3.0 * u[1] + 2.0 * u[2]);
  double b = 3.0 * u[1] + 0.2 * sin(2.5 * u[2] - u[0]);
  double c = 1.5 * u[2] + 0.12 * cos(3.0 * u[0] + 2.0 * u[1]);
  x[0] = 0.8 * a - 0.5 * b + 0.1 * c + 4.0;
  x[1] = 0.5 * a + 0.8 * b - 0.2 * c - 1.0;
  x[2] = 0.02 * a + 0.3 * b + 0.97 * c;
  *weight = 1.0 + 0.4 * sin(2.0 * u[0] + 3.0 * u[1] - u[2]);
}

static void map_unit(const double u[3], double x[3], double *weight) {
  memcpy(x, u, 3 * sizeof *x);
  *weight = 1.0;
}

/* ---- dissections ------------------------------------------------------------------------------
 */

/* The largest distance of two boundaries at equal parameters. */
static double compare_surfaces(const tsolid_boundary *a, const tsolid_boundary *b, int n) {
  tsolid_bezier_boundary view[2];
  double worst = 0.0, x[3], y[3];
  tsolid_boundary_view(a, &view[0]);
  tsolid_boundary_view(b, &view[1]);
  for (int side = 0; side < 6; side++)
    for (int i = 0; i < n; i++) {
      double s = random_unit(), t = random_unit();
      if (!evaluate_boundary(&view[0], side, s, t, x) ||
          !evaluate_boundary(&view[1], side, s, t, y))
        return INFINITY;
      worst = fmax(worst, hypot(hypot(x[0] - y[0], x[1] - y[1]), x[2] - y[2]));
    }
  return worst / tsolid_boundary_scale(a);
}

/* Cut by the library and by hand: one grid, one set of functions, one surface. */
static void check_against_grid(tsolid_context *context, const part *whole, const dissection side[6],
                               const tsolid_boundary *boundary) {
  static dissection grid[6];
  close_dissections(side, grid);
  part p = make_dissected(whole, grid);
  tsolid_boundary *by_hand = create(context, &p, NULL);
  if (boundary && by_hand) {
    CHECK(memcmp(boundary->requirement.side_grid, by_hand->requirement.side_grid,
                 sizeof by_hand->requirement.side_grid) == 0);
    CHECK(boundary->requirement.n_patches == p.n && by_hand->preparation.n_cuts == 0);
    CHECK(boundary->n_functions == by_hand->n_functions);
    CHECK_NEAR(compare_surfaces(boundary, by_hand, 40), 0.0, 1e-13);
  }
  tsolid_boundary_free(by_hand);
  part_free(&p);
}

static int count_pieces(const tsolid_boundary *boundary, int n_patches) {
  int n = 0;
  for (int k = 0; k < n_patches; k++)
    n += tsolid_boundary_n_placements(boundary, k);
  return n;
}

static void check_dissected(tsolid_context *context, const part *whole, const dissection side[6],
                            int n_shuffles) {
  part p = make_dissected(whole, side);
  tsolid_boundary *boundary = create(context, &p, NULL);
  if (boundary) {
    double scale = tsolid_boundary_scale(boundary);
    CHECK(tsi_boundary_validate(context, boundary) == TSOLID_OK);
    for (int k = 0; k < p.n; k++)
      CHECK_NEAR(measure_patch_distance(&p.patch[k], k, boundary, 1000) / scale, 0.0, 1e-13);
    CHECK_NEAR(largest_snap(boundary) / scale, 0.0, 1e-13);
    CHECK_NEAR(boundary->preparation.knot_merge, 0.0, 1e-12);
    CHECK_NEAR(sum_defect(boundary), 0.0, 1e-14);
    CHECK(count_pieces(boundary, p.n) == boundary->requirement.n_patches);
  }
  check_against_grid(context, whole, side, boundary);
  tsolid_boundary_free(boundary);
  if (n_shuffles)
    check_shuffles(context, &p, n_shuffles, 1e-13);
  part_free(&p);
}

static void test_dissections(tsolid_context *context) {
  static dissection side[6];
  part bodies[3] = {make_part(cubics, map_wavy, 0), make_part(mixed, map_wavy, 1),
                    make_part(linear, map_unit, 0)};
  for (int round = 0; round < 9; round++) {
    for (int k = 0; k < 6; k++)
      random_dissection(&side[k], round / 3 ? random_below(3) : 0, random_below(2 + round / 6));
    if (round < 3) /* one pinwheel on an otherwise plain part, one cut on another side */
      for (int k = 0; k < 6; k++)
        random_dissection(&side[k], k == 3, k == 5);
    check_dissected(context, &bodies[round % 3], side, round % 3 == 2 ? 2 : 4);
  }
  for (int i = 0; i < 3; i++)
    part_free(&bodies[i]);
}

/* Each request for memory fails once; one for a note's text is lost with the note. */
static void check_memory(const part *p) {
  tsolid_boundary_input input = {.n_patches = p->n, .patches = p->patch};
  long n_refused = 0, k = 0, survived = 0;
  while (!survived && ++k < 100000) {
    counting c = {0, k, 0};
    tsolid_context_options options = {
        .allocate = count_allocate, .release = count_release, .allocator_data = &c};
    tsolid_context *context = NULL;
    tsolid_boundary *boundary = NULL;
    tsolid_status status = tsolid_context_create(&options, &context);
    if (!status)
      status = tsolid_boundary_create(context, &input, NULL, NULL, &boundary);
    CHECK(status ? status == TSOLID_ERROR_MEMORY && !boundary : boundary != NULL);
    n_refused += status == TSOLID_ERROR_MEMORY;
    survived = c.n_requests < k;
    tsolid_context_free(context);
    tsolid_boundary_free(boundary);
    CHECK(c.n_live == 0);
  }
  if (!CHECK(n_refused > 50 && k - n_refused < 20))
    fprintf(stderr, "    %ld of %ld requests\n", n_refused, k);
}

/* An L: a corner of one patch inside the border of the next, at cuts that meet in a cross. */
static void test_l_shape(tsolid_context *context) {
  static dissection side[6];
  part whole = make_part(cubics, map_wavy, 1);
  for (int k = 0; k < 6; k++)
    whole_square(&side[k]);
  cut_rectangle(&side[5], 0, 0, 0.5);
  cut_rectangle(&side[5], 1, 1, 0.25);
  part p = make_dissected(&whole, side);
  tsolid_boundary *boundary = create(context, &p, NULL);
  if (boundary) {
    /* x = 1/2 runs around through 3 whole sides, y = 1/4 through 3 and the left half of side 5 */
    CHECK(boundary->preparation.n_cuts == 7 && boundary->preparation.n_cut_patches == 6);
    CHECK(boundary->requirement.n_patches == 4 + 4 + 4 * 2);
    CHECK(tsolid_boundary_n_placements(boundary, 4) == 4);
    CHECK(tsolid_boundary_n_placements(boundary, 8) == 0);
    CHECK(tsolid_boundary_n_placements(boundary, -1) == 0);
    tsolid_placement place;
    CHECK(!tsolid_boundary_placement(boundary, 4, 1, &place));
    CHECK_NEAR(place.domain[0], 0.5, 1e-14); /* u runs first */
    CHECK_NEAR(place.domain[2], 0.0, 0.0);
    CHECK_NEAR(place.domain[3], 0.25, 1e-14);
    CHECK(tsolid_boundary_placement(boundary, 4, 4, &place) == TSOLID_ERROR_ARGUMENT);
  }
  tsolid_boundary_free(boundary);
  check_dissected(context, &whole, side, 3);
  check_memory(&p);
  part_free(&p);
  part_free(&whole);
}

/* The two halves of a patch at x of direction d, by knot insertion. */
static void halve_patch(const tsolid_patch *from, int d, double x, tsolid_patch out[2]) {
  tsolid_context *context = new_context();
  tsi_arena arena = tsi_arena_create(context);
  tsi_patch fine;
  CHECK(tsi_patch_read(&arena, from, &fine));
  int q = fine.degree[d], n = fine.n[d], n_to = 0, count = 0, row = 0;
  double *to = part_doubles((size_t)(n + 2 * q + 2));
  for (int i = 0; i < n + q + 1; i++) {
    count += fine.knots[d][i] == x;
    for (; fine.knots[d][i] > x && count < q; count++)
      to[n_to++] = x;
    to[n_to++] = fine.knots[d][i];
  }
  CHECK(tsi_patch_refine(&arena, &fine, d, 0, n_to - q - 1, to));
  free(to);
  while (fine.knots[d][row + 1] != x)
    row++;
  for (int half = 0; half < 2; half++) {
    int low = half ? row : 0, high = half ? fine.n[d] - 1 : row;
    out[half] = *from;
    out[half].n_control[d] = high - low + 1;
    for (int e = 0; e < 2; e++) {
      int size = out[half].n_control[e] + fine.degree[e] + 1;
      double *knots = part_doubles((size_t)size);
      memcpy(knots, fine.knots[e] + (e == d ? low : 0), (size_t)size * sizeof *knots);
      if (e == d)
        knots[half ? 0 : size - 1] = x;
      for (int i = 0; i < size && e == d; i++)
        knots[i] = half ? (knots[i] - x) / (1.0 - x) : knots[i] / x;
      out[half].knots[e] = knots;
    }
    int n0 = out[half].n_control[0], total = n0 * out[half].n_control[1];
    double *points = part_doubles(3 * (size_t)total), *weights = part_doubles((size_t)total);
    for (int k = 0; k < total; k++) {
      int i = k % n0 + (d ? 0 : low), j = k / n0 + (d ? low : 0);
      const double *h = fine.control + 4 * (i + fine.n[0] * j);
      for (int c = 0; c < 3; c++)
        points[3 * k + c] = h[c] / h[3];
      weights[k] = h[3];
    }
    out[half].points = points;
    out[half].weights = weights;
  }
  tsi_arena_free(&arena);
  tsolid_context_free(context);
}

/* Cut at knots of the patch, single, double and of full multiplicity, and between knots. */
static void test_knots(tsolid_context *context) {
  static const axis_spec rich[3] = {{1, {{3, 4, {0.25, 0.5, 0.5, 0.75}}}},
                                    {1, {{2, 3, {0.25, 0.25, 0.75}}}},
                                    {1, {{3, 1, {0.375}}}}};
  static const struct {
    int side, d;
    double x;
  } at[5] = {{2, 0, 0.5}, {2, 0, 0.25}, {0, 0, 0.25}, {0, 1, 0.375}, {0, 1, 0.5625}};
  for (int k = 0; k < 5; k++) {
    part p = make_part(rich, map_wavy, 1);
    tsolid_patch old = p.patch[at[k].side], half[2];
    halve_patch(&old, at[k].d, at[k].x, half);
    p.patch = realloc(p.patch, 7 * sizeof *p.patch);
    p.patch[at[k].side] = half[0];
    p.patch[p.n++] = half[1];
    tsolid_boundary *boundary = create(context, &p, NULL);
    if (boundary) {
      CHECK(boundary->preparation.n_cuts == 3);
      CHECK_NEAR(measure_distance(&p, boundary), 0.0, 1e-13);
    }
    tsolid_boundary_free(boundary);
    check_shuffles(context, &p, 3, 1e-13);
    part_free(&p);
    part_free(&(part){1, memcpy(malloc(sizeof old), &old, sizeof old)});
  }
}

/* ---- tolerances -------------------------------------------------------------------------------
 */

/* A unit box with z high cut at x = 1/2, where the cut's ends lie `out` off the edges, and z low at
 * x = 1/2 + `aside`. */
static part make_off_box(double out, double aside) {
  static dissection side[6];
  part whole = make_part(linear, map_unit, 0);
  for (int k = 0; k < 6; k++)
    whole_square(&side[k]);
  cut_rectangle(&side[5], 0, 0, 0.5);
  if (aside >= 0.0)
    cut_rectangle(&side[4], 0, 0, 0.5 + aside);
  part p = make_dissected(&whole, side);
  for (int k = 0; k < p.n; k++)
    for (int i = 0; i < 4; i++) {
      double *x = (double *)(size_t)p.patch[k].points + 3 * i;
      if (x[0] == 0.5 && x[2] == 1.0)
        x[1] += x[1] > 0.5 ? out : -out;
    }
  p.patch[2].name = "Face3";
  p.patch[2].border_name[2] = "Edge9";
  p.patch[p.n - 2].corner_name[1] = p.patch[p.n - 1].corner_name[0] = "Vertex7";
  part_free(&whole);
  return p;
}

static int findings_hold(const tsolid_context *context, const char *text) {
  for (int i = 0; i < tsolid_context_n_findings(context); i++)
    if (strstr(tsolid_context_finding(context, i)->text, text))
      return 1;
  for (int i = 0; i < tsolid_context_n_findings(context); i++)
    fprintf(stderr, "    %s\n", tsolid_context_finding(context, i)->text);
  return 0;
}

static void expect_refused(const part *p, double tolerance, const char *text) {
  tsolid_context *context = new_context();
  tsolid_boundary *boundary = NULL;
  tsolid_boundary_input input = {.n_patches = p->n, .patches = p->patch};
  tsolid_boundary_options options = {.tolerance = tolerance};
  tsolid_status status = tsolid_boundary_create(context, &input, &options, NULL, &boundary);
  CHECK(status == TSOLID_ERROR_REFUSED && !boundary);
  CHECK(findings_hold(context, text));
  tsolid_boundary_free(boundary);
  tsolid_context_free(context);
}

static void test_tolerance(tsolid_context *context) {
  static const double out[3] = {0.0, 5e-8, 9.9e-8};
  for (int i = 0; i < 3; i++)
    for (int k = -1; k < 3; k++) {
      if (k >= 0 && hypot(out[i], 0.9 * out[k]) > 1e-7)
        continue; /* the cut misses the vertex */
      part p = make_off_box(out[i], k < 0 ? -1.0 : out[k] * 0.9);
      tsolid_boundary *boundary = create(context, &p, NULL);
      if (boundary) {
        CHECK(boundary->requirement.n_patches == 10 && boundary->preparation.n_cut_patches > 1);
        CHECK(largest_snap(boundary) <= 1.5e-7);
        CHECK(measure_distance(&p, boundary) <= 1.5e-7);
      }
      tsolid_boundary_free(boundary);
      part_free(&p);
    }
  part p = make_off_box(1.1e-7, -1.0);
  expect_refused(&p, 0.0, "farther from it than the tolerance of 1e-07");
  part_free(&p);
  p = make_off_box(0.001, -1.0);
  expect_refused(&p, 0.0, "is met by two neighbours near (0.5, -0.001, 1), but their vertex there");
  part_free(&p);
}

/* Isolines too near to each other: both faces' vertices by name. */
static void test_sliver(void) {
  part p = make_off_box(0.0, 3e-7);
  expect_refused(&p, 0.0, "Face3 would be cut into a sliver 3e-07 wide at (0.5");
  expect_refused(&p, 0.0, "Vertex7");
  part_free(&p);
  p = make_off_box(0.0, 1e-9);
  expect_refused(&p, 1e-12, "sliver 1e-09 wide");
  part_free(&p);
}

static void test_note(void) {
  tsolid_context *context = new_context();
  part p = make_off_box(0.0, -1.0);
  tsolid_boundary_free(create(context, &p, NULL));
  CHECK(
      findings_hold(context, "Face3 is cut at u = 0.5, because Vertex7 lies on its border Edge9"));
  for (int i = 0; i < tsolid_context_n_findings(context); i++)
    CHECK(tsolid_context_finding(context, i)->severity == TSOLID_NOTE);
  CHECK(tsolid_context_n_findings(context) == 3); /* two beside it, one below */
  part_free(&p);
  tsolid_context_free(context);
}

/* ---- cuts that do not close -------------------------------------------------------------------
 */

/* A box with side y high of degree 2 along x, its isolines bent so that they end `drift` aside. */
static void check_spiral(double drift, const char *text) {
  static const axis_spec bent[3] = {{1, {{2, 0, {0}}}}, {1, {{1, 0, {0}}}}, {1, {{1, 0, {0}}}}};
  static dissection side[6];
  part whole = make_part(bent, map_unit, 0);
  for (int k = 0; k < 6; k++)
    whole_square(&side[k]);
  cut_rectangle(&side[5], 0, 0, 0.4);
  ((double *)(size_t)whole.patch[3].points)[3] += drift; /* middle of the border at z = 0 */
  part p = make_dissected(&whole, side);
  p.patch[3].name = "Face4";
  expect_refused(&p, 0.0, text);
  part_free(&p);
  part_free(&whole);
}

static void test_spirals(void) {
  check_spiral(0.2, "would be cut into a sliver");
  check_spiral(0.002, "do not close around the part where the faces' parameters disagree");
}

/* The parameter x of a side's patch becomes c x/(c x + 1 - x) before the others are cut: the
 * isoline through the corner is another number there, and the pieces differ from their neighbours
 * by projective changes of their own. */
static void test_moebius(tsolid_context *context) {
  static dissection side[6];
  part whole = make_part(cubics, map_wavy, 1);
  tsi_arena arena = tsi_arena_create(context);
  tsi_patch patch;
  CHECK(tsi_patch_read(&arena, &whole.patch[3], &patch) && tsi_patch_reparametrise(&patch, 0, 1.9));
  for (int i = 0; i < patch.n[0] * patch.n[1]; i++) {
    ((double *)(size_t)whole.patch[3].weights)[i] = patch.control[4 * i + 3];
    for (int c = 0; c < 3; c++)
      ((double *)(size_t)whole.patch[3].points)[3 * i + c] =
          patch.control[4 * i + c] / patch.control[4 * i + 3];
  }
  tsi_arena_free(&arena);
  for (int k = 0; k < 6; k++)
    whole_square(&side[k]);
  cut_rectangle(&side[5], 0, 0, 0.5);
  cut_rectangle(&side[5], 1, 1, 0.25);
  part p = make_dissected(&whole, side);
  tsolid_boundary *boundary = create(context, &p, NULL);
  if (boundary) {
    tsolid_placement place;
    CHECK(boundary->preparation.n_moebius > 0 && boundary->preparation.n_cuts == 7);
    CHECK(!tsolid_boundary_placement(boundary, 3, 0, &place));
    CHECK(fabs(place.domain[1] - 0.5) > 0.1);
    CHECK_NEAR(measure_distance(&p, boundary), 0.0, 1e-13);
  }
  tsolid_boundary_free(boundary);
  check_shuffles(context, &p, 2, 1e-13);
  part_free(&p);
  part_free(&whole);
}

/* ---- other forms ------------------------------------------------------------------------------
 */

/* Side z high of the cubic part, cut at x = 1/2, as one patch of two Bezier elements or as a
 * T-spline with a triple knot there: the sides y are cut, z high is to be. */
static void test_forms(tsolid_context *context) {
  static dissection side[6];
  static const double boxes[2][4] = {{0.0, 0.5, 0.0, 1.0}, {0.5, 1.0, 0.0, 1.0}};
  static double points[28 * 4], box[8], coefficient[32 * 16], knots[2][28 * 5];
  static int function[32], start[3] = {0, 16, 32}, point[28];
  part whole = make_part(cubics, map_wavy, 1);
  tsolid_patch half[2] = {sub_patch(&whole.patch[5], boxes[0]),
                          sub_patch(&whole.patch[5], boxes[1])};
  for (int h = 0; h < 2; h++)
    for (int j = 0; j < 4; j++)
      for (int i = 0; i < 4; i++) {
        int at = i + 4 * j, f = 3 * h + i + 7 * j, e = 16 * h + at;
        double w = half[h].weights[at];
        for (int c = 0; c < 3; c++)
          points[4 * f + c] = w * half[h].points[3 * at + c];
        points[4 * f + 3] = w;
        function[e] = f;
        coefficient[16 * e + at] = 1.0;
        for (int d = 0; d < 2; d++)
          for (int m = 0; m < 5; m++) {
            static const double one[8] = {0, 0, 0, 0, 1, 1, 1, 1},
                                two[11] = {0, 0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1, 1};
            knots[d][5 * f + m] = d ? one[j + m] : two[3 * h + i + m];
          }
        point[f] = f;
      }
  memcpy(box, boxes, sizeof box);
  tsolid_bezier_side elements = {.degree = {3, 3},
                                 .n_elements = 2,
                                 .box = box,
                                 .function_start = start,
                                 .function = function,
                                 .coefficient = coefficient};
  tsolid_tspline tspline = {.degree = {3, 3},
                            .n_functions = 28,
                            .point = point,
                            .knots = {knots[0], knots[1]},
                            .domain = {0.0, 1.0, 0.0, 1.0}};
  for (int k = 0; k < 6; k++)
    whole_square(&side[k]);
  cut_rectangle(&side[2], 0, 0, 0.5);
  part p = make_dissected(&whole, side);
  for (int form = 0; form < 2; form++) {
    tsolid_patch kept = p.patch[p.n - 1], *last = &p.patch[p.n - 1];
    if (form)
      last->tspline = &tspline;
    else
      last->bezier = &elements;
    tsolid_boundary_input input = {
        .n_patches = p.n, .patches = p.patch, .n_points = 28, .points = points};
    tsolid_boundary *boundary = NULL;
    CHECK(!tsolid_boundary_create(context, &input, NULL, NULL, &boundary));
    if (boundary) {
      CHECK(tsolid_boundary_n_placements(boundary, p.n - 1) == 2);
      CHECK(boundary->requirement.n_patches == 10);
      CHECK_NEAR(measure_distance(&p, boundary), 0.0, 1e-13);
      CHECK_NEAR(sum_defect(boundary), 0.0, 1e-14);
    }
    tsolid_boundary_free(boundary);
    *last = kept;
  }
  for (int h = 0; h < 2; h++) {
    free((void *)(size_t)half[h].knots[0]);
    free((void *)(size_t)half[h].knots[1]);
    free((void *)(size_t)half[h].points);
    free((void *)(size_t)half[h].weights);
  }
  part_free(&p);
  part_free(&whole);
}

int main(void) {
  tsolid_context *context = new_context();
  test_l_shape(context);
  test_dissections(context);
  test_knots(context);
  test_tolerance(context);
  test_sliver();
  test_note();
  test_spirals();
  test_moebius(context);
  test_forms(context);
  tsolid_context_free(context);
  return check_done();
}
