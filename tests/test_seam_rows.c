/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Knots that one side of a seam brings: they reach the functions along that seam alone, the surface
 * and the sum of the functions stay, and nothing depends on how the part is given. */
#include "boundary_checks.h"

/* A box with straight edges and bumps on its faces, across them so that none folds: sides may have
 * any knots of their own. */
static void map_bumped(const double u[3], double point[3], double *weight) {
  int inside = 0;
  for (int c = 0; c < 3; c++) {
    point[c] = (3.0 - c) * u[c] - 0.5;
    inside += u[c] > 0.0 && u[c] < 1.0;
  }
  *weight = 1.0;
  for (int c = 0; inside == 2 && c < 3; c++)
    if (u[c] == 0.0 || u[c] == 1.0)
      point[c] += 0.1 * sin(5.0 * u[(c + 1) % 3] + 3.0 * u[(c + 2) % 3]);
}

typedef struct side_spec {
  int degree[2], n_inner[2];
  double inner[2][80];
} side_spec;

/* Patch of a side from knots of its own. */
static void make_own_patch(const side_spec *spec, int side, tsolid_patch *patch) {
  int a = side >> 1, d[2] = {a == 0 ? 1 : 0, a == 2 ? 1 : 2};
  double *knots[2];
  memset(patch, 0, sizeof *patch);
  for (int k = 0; k < 2; k++) {
    int p = spec->degree[k], n = 0;
    knots[k] = part_doubles((size_t)(2 * p + 2 + spec->n_inner[k]));
    for (int i = 0; i <= p; i++)
      knots[k][n++] = 0.0;
    for (int i = 0; i < spec->n_inner[k]; i++)
      knots[k][n++] = spec->inner[k][i];
    for (int i = 0; i <= p; i++)
      knots[k][n++] = 1.0;
    patch->degree[k] = p;
    patch->n_control[k] = n - p - 1;
    patch->knots[k] = knots[k];
  }
  double *points = part_doubles(3 * (size_t)patch->n_control[0] * (size_t)patch->n_control[1]);
  size_t row = 0;
  for (int v = 0; v < patch->n_control[1]; v++)
    for (int u = 0; u < patch->n_control[0]; u++, row++) {
      double x[3], weight;
      x[a] = side & 1;
      x[d[0]] = greville(knots[0], patch->degree[0], u);
      x[d[1]] = greville(knots[1], patch->degree[1], v);
      map_bumped(x, points + 3 * row, &weight);
    }
  patch->points = points;
}

static part make_own_part(const side_spec spec[6]) {
  part p = {6, calloc(6, sizeof *p.patch)};
  for (int side = 0; side < 6; side++)
    make_own_patch(&spec[side], side, &p.patch[side]);
  return p;
}

static void check_own_part(tsolid_context *context, const part *p, double allowed) {
  tsolid_boundary *boundary = create(context, p, NULL);
  if (boundary) {
    CHECK(tsi_boundary_validate(context, boundary) == TSOLID_OK);
    CHECK_NEAR(measure_distance(p, boundary), 0.0, allowed);
    CHECK_NEAR(sum_defect(boundary), 0.0, 4e-15);
  }
  check_orientations(context, p);
  check_shuffles(context, p, 3, allowed);
  tsolid_boundary_free(boundary);
}

/* ---- counts ------------------------------------------------------------------------------------
 */

static void uniform_side(side_spec *spec, int n_spans) {
  *spec = (side_spec){.degree = {3, 3}, .n_inner = {n_spans - 1, n_spans - 1}};
  for (int d = 0; d < 2; d++)
    for (int i = 1; i < n_spans; i++)
      spec->inner[d][i - 1] = (double)i / n_spans;
}

/* One side of 64 x 64 spans among five of 2 x 2: the fine knots reach the first row of functions
 * of its neighbours and nothing else. Each neighbour has 5 x 5 functions, five of which lie on the
 * seam; the fine side's 4 x 66 border functions are those of the seams. */
static void test_one_fine_side(tsolid_context *context) {
  for (int fine = 0; fine < 6; fine++) {
    side_spec spec[6];
    for (int i = 0; i < 6; i++)
      uniform_side(&spec[i], i == fine ? 64 : 2);
    part p = make_own_part(spec);
    tsolid_boundary *boundary = create(context, &p, NULL);
    int rest = 3 * 16 + 25; /* rings of 16 functions above the seams, and the far side */
    if (boundary) {
      CHECK(boundary->n_functions == 67 * 67 + rest);
      CHECK_NEAR(sum_defect(boundary), 0.0, 4e-15);
      CHECK_NEAR(measure_distance(&p, boundary), 0.0, 1e-15);
      /* 62 knots per neighbour */
      CHECK(boundary->preparation.n_knots_inserted == 4 * 62);
      if (fine == 0)
        printf("one side of 64 x 64 spans, five of 2 x 2: %d surface functions, 67 x 67 = %d\n",
               boundary->n_functions, 67 * 67);
    }
    tsolid_boundary_free(boundary);
    part_free(&p);
  }
}

/* Fine sides that meet at a corner of a coarse one: both rows of it need a new first knot there,
 * which one knot line across the coarse side allows. */
static void test_two_fine_sides(tsolid_context *context) {
  side_spec spec[6];
  for (int i = 0; i < 6; i++)
    uniform_side(&spec[i], i == 0 || i == 2 ? 16 : 2);
  part p = make_own_part(spec);
  tsolid_boundary *boundary = create(context, &p, NULL);
  if (boundary) {
    CHECK(boundary->n_functions < 2 * 19 * 19 + 150);
    CHECK(boundary->n_functions > 2 * 19 * 19 - 19);
    printf("two sides of 16 x 16 spans, four of 2 x 2: %d surface functions\n",
           boundary->n_functions);
  }
  check_own_part(context, &p, 1e-15);
  tsolid_boundary_free(boundary);
  part_free(&p);
}

/* ---- any knots ---------------------------------------------------------------------------------
 */

static int compare_knots(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Random degrees, numbers and multiplicities, every knot on a grid of sixteenths so that sides
 * share some of them. */
static void random_side(side_spec *spec) {
  for (int d = 0; d < 2; d++) {
    int p = spec->degree[d] = 1 + random_below(5), n = 0;
    int n_distinct = random_below(5);
    for (int i = 0; i < n_distinct; i++) {
      double x = (1 + random_below(15)) / 16.0;
      int multiplicity = 1 + random_below(p), seen = 0;
      for (int k = 0; k < n; k++)
        seen |= spec->inner[d][k] == x;
      for (int m = 0; m < multiplicity && !seen; m++)
        spec->inner[d][n++] = x;
    }
    qsort(spec->inner[d], (size_t)n, sizeof(double), compare_knots);
    spec->n_inner[d] = n;
  }
}

static void test_random(tsolid_context *context) {
  for (int round = 0; round < 12; round++) {
    side_spec spec[6];
    for (int i = 0; i < 6; i++)
      random_side(&spec[i]);
    part p = make_own_part(spec);
    check_own_part(context, &p, 1e-14);
    part_free(&p);
  }
}

/* One knot more in every row of the patch along `along`, by Boehm's rule; a copy of the patch takes
 * its place. */
static void insert_knot(tsolid_patch *patch, int along, double x) {
  int p = patch->degree[along], n = patch->n_control[along], span = p;
  const double *knots = patch->knots[along];
  while (knots[span + 1] <= x)
    span++;
  for (int i = 0; i < n + p + 1; i++)
    if (knots[i] == x)
      return;
  int size[2] = {patch->n_control[0], patch->n_control[1]}, old[2] = {size[0], size[1]};
  size[along]++;
  double *fine = part_doubles((size_t)(n + p + 2));
  double *points = part_doubles(3 * (size_t)size[0] * (size_t)size[1]);
  for (int i = 0; i < n + p + 2; i++)
    fine[i] = i <= span ? knots[i] : i == span + 1 ? x : knots[i - 1];
  for (int j = 0; j < size[1]; j++)
    for (int i = 0; i < size[0]; i++) {
      int m = along ? j : i;
      double a = m <= span - p ? 1.0 : m > span ? 0.0 : (x - knots[m]) / (knots[m + p] - knots[m]);
      for (int c = 0; c < 3; c++) {
        int low = along ? i + old[0] * (m - 1) : m - 1 + old[0] * j;
        int high = along ? i + old[0] * m : m + old[0] * j;
        points[3 * (i + size[0] * j) + c] =
            (a > 0.0 ? a * patch->points[3 * high + c] : 0.0) +
            (a < 1.0 ? (1.0 - a) * patch->points[3 * low + c] : 0.0);
      }
    }
  free((void *)(size_t)patch->knots[along]);
  free((void *)(size_t)patch->points);
  patch->knots[along] = fine;
  patch->points = points;
  patch->n_control[along]++;
}

/* Strips too: seams inside the sides, knot lines that only one patch has. */
static void test_strips(tsolid_context *context) {
  static const axis_spec axes[3] = {{2, {{3, 2, {0.3, 0.6}}, {3, 1, {0.55}}}},
                                    {2, {{2, 0, {0}}, {2, 2, {0.1, 0.3}}}},
                                    {2, {{3, 1, {0.5}}, {3, 0, {0}}}}};
  for (int round = 0; round < 8; round++) {
    part p = make_part(axes, map_bumped, 0), finer = {p.n, calloc((size_t)p.n, sizeof *p.patch)};
    tsolid_boundary *coarse = create(context, &p, NULL);
    for (int k = 0; k < p.n; k++)
      finer.patch[k] = reorient_patch(&p.patch[k], 0, 0, 0);
    for (int n = 0; n < 1 + round / 2; n++) { /* insert a knot line into some patches */
      int k = random_below(p.n);
      insert_knot(&finer.patch[k], random_below(2), (1 + random_below(15)) / 16.0);
    }
    tsolid_boundary *boundary = create(context, &finer, NULL);
    if (boundary && coarse) {
      CHECK_NEAR(measure_distance(&finer, boundary), 0.0, 2e-15);
      CHECK_NEAR(sum_defect(boundary), 0.0, 4e-15);
      CHECK(boundary->n_functions > coarse->n_functions);
    }
    check_shuffles(context, &finer, 3, 2e-15);
    tsolid_boundary_free(boundary);
    tsolid_boundary_free(coarse);
    part_free(&finer);
    part_free(&p);
  }
}

static void test_memory(void) {
  side_spec spec[6];
  for (int i = 0; i < 6; i++)
    uniform_side(&spec[i], i == 0 || i == 2 ? 5 : 2);
  part p = make_own_part(spec);
  tsolid_boundary_input input = {.n_patches = p.n, .patches = p.patch};
  check_failing_memory(&input);
  part_free(&p);
}

int main(void) {
  tsolid_context *context = new_context();
  test_one_fine_side(context);
  test_two_fine_sides(context);
  test_random(context);
  test_strips(context);
  test_memory();
  tsolid_context_free(context);
  return check_done();
}
