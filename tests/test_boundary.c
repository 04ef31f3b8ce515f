/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The boundary: same bytes however a part is given, same surface before and after, exact
 * preparation; Bezier sides; the slow checker. Refusals: test_refusal.c. */
#include "boundary_checks.h"

static const axis_spec plain_axes[3] = {
    {1, {{3, 3, {0.25, 0.3, 0.7}}}}, {1, {{2, 1, {0.4}}}}, {1, {{4, 4, {0.2, 0.5, 0.5, 0.9}}}}};

static const axis_spec grid_axes[3] = {{2, {{3, 2, {0.3, 0.6}}, {2, 1, {0.55}}}},
                                       {2, {{2, 0, {0}}, {2, 2, {0.1, 0.3}}}},
                                       {2, {{1, 1, {0.5}}, {3, 0, {0}}}}};

static void map_wavy(const double u[3], double point[3], double *weight) {
  point[0] = 3.0 * u[0] + 0.2 * sin(3.0 * u[1] + u[2]);
  point[1] = 2.0 * u[1] + 0.15 * cos(2.0 * u[0] - u[2]) + 0.3 * u[0];
  point[2] = 1.5 * u[2] + 0.2 * sin(2.0 * u[0] + 2.0 * u[1]) - 4.0;
  *weight = 1.0 + 0.5 * u[0] + 0.25 * u[1] * u[2];
}

static void map_box(const double u[3], double point[3], double *weight) {
  for (int c = 0; c < 3; c++)
    point[c] = (3.0 - c) * u[c] - 0.5;
  *weight = 1.0;
}

/* A box with straight edges and bumps on its faces, across them so that none folds. */
static void map_bumped(const double u[3], double point[3], double *weight) {
  int inside = 0;
  map_box(u, point, weight);
  for (int c = 0; c < 3; c++)
    inside += u[c] > 0.0 && u[c] < 1.0;
  if (inside == 2)
    for (int c = 0; c < 3; c++)
      if (u[c] == 0.0 || u[c] == 1.0)
        point[c] += 0.1 * sin(5.0 * u[(c + 1) % 3] + 3.0 * u[(c + 2) % 3]);
}

/* det J > 0: the volume between the boundary and the origin by the corners of its elements. */
static double rough_volume(const tsolid_boundary *boundary) {
  enum { N = 24 };
  tsolid_bezier_boundary view;
  double volume = 0.0;
  tsolid_boundary_view(boundary, &view);
  for (int side = 0; side < 6; side++)
    for (int j = 0; j < N; j++)
      for (int i = 0; i < N; i++) {
        double x[4][3], n[3];
        for (int k = 0; k < 4; k++)
          evaluate_boundary(&view, side, (i + (k & 1)) / (double)N, (j + (k >> 1)) / (double)N,
                            x[k]);
        for (int c = 0; c < 3; c++) {
          int a = (c + 1) % 3, b = (c + 2) % 3;
          n[c] = 0.5 * ((x[3][a] - x[0][a]) * (x[2][b] - x[1][b]) -
                        (x[3][b] - x[0][b]) * (x[2][a] - x[1][a]));
        }
        /* s, t increasing: the normal s x t points along +axis but for axis y */
        double sign = ((side & 1) ? 1.0 : -1.0) * (side >> 1 == 1 ? -1.0 : 1.0);
        for (int c = 0; c < 3; c++)
          volume += sign * n[c] * (x[0][c] + x[1][c] + x[2][c] + x[3][c]) / 12.0;
      }
  return volume;
}

/* ---- the same part, given differently ----------------------------------------------------------
 */

static void check_part(tsolid_context *context, const part *p, const axis_spec axis[3]) {
  tsolid_boundary *boundary = create(context, p, NULL);
  if (!boundary)
    return;
  CHECK(tsi_boundary_validate(context, boundary) == TSOLID_OK);
  CHECK_NEAR(measure_distance(p, boundary), 0.0, 2e-15);
  CHECK(largest_snap(boundary) == 0.0);
  CHECK(boundary->preparation.knot_merge == 0.0);
  CHECK(boundary->preparation.n_knots_inserted == 0);
  CHECK(boundary->preparation.n_degrees_raised == 0);
  const tsolid_requirement *r = &boundary->requirement;
  CHECK(r->satisfied && r->closed && r->connected && r->genus == 0 && r->n_violations == 0);
  CHECK(r->n_patches == p->n && r->n_extraordinary == 8);
  CHECK(r->n_vertices - r->n_edges + r->n_patches == 2);
  int sum = 0, expected = 0;
  for (int i = 0; i < 6; i++)
    sum += r->side_grid[i][0] * r->side_grid[i][1];
  for (int a = 0; a < 3; a++)
    expected += 2 * axis[a].n_strips * axis[(a + 1) % 3].n_strips;
  CHECK(sum == expected);
  CHECK(rough_volume(boundary) > 0.0);
  for (int i = 1; i < 8; i++) { /* corner 0 is the least, its x neighbour the least of three */
    CHECK(r->corner[0][0] <= r->corner[i][0] + 1e-9);
    if (i == 2 || i == 4)
      CHECK(r->corner[1][0] <= r->corner[i][0] + 1e-9);
  }
  tsolid_boundary_free(boundary);
}

static void test_given_differently(tsolid_context *context) {
  for (int rational = 0; rational < 2; rational++) {
    part plain = make_part(plain_axes, map_wavy, rational);
    part grid = make_part(grid_axes, map_wavy, rational);
    check_part(context, &plain, plain_axes);
    check_part(context, &grid, grid_axes);
    check_orientations(context, &plain);
    check_shuffles(context, &plain, 24, 2e-15);
    check_shuffles(context, &grid, 48, 2e-15);
    part_free(&plain);
    part_free(&grid);
  }
}

/* Where nothing needs preparation control points and knots come through bit for bit. */
static void test_untouched(tsolid_context *context) {
  part p = make_part(grid_axes, map_wavy, 0), plain = make_part(plain_axes, map_wavy, 0);
  for (int round = 0; round < 2; round++) {
    const part *from = round ? &plain : &p;
    tsolid_boundary *boundary = create(context, from, NULL);
    for (int f = 0; boundary && f < boundary->n_functions; f++) {
      const double *h = boundary->points + 4 * f;
      int found = 0;
      for (int k = 0; k < from->n && !found; k++)
        for (int i = 0; i < from->patch[k].n_control[0] * from->patch[k].n_control[1]; i++)
          found |= memcmp(h, from->patch[k].points + 3 * i, 3 * sizeof(double)) == 0;
      CHECK(found && h[3] == 1.0);
    }
    tsolid_boundary_free(boundary);
  }
  tsolid_boundary *boundary = create(context, &plain, NULL);
  for (int side = 0; boundary && side < 6; side++)
    for (int i = 0; i < 4 * boundary->side[side].n_elements; i++) {
      double x = boundary->side[side].box[i];
      int found = x == 0.0 || x == 1.0;
      for (int a = 0; a < 3; a++)
        for (int k = 0; k < plain_axes[a].strip[0].n_inner; k++) {
          double knot = 1.0 - plain_axes[a].strip[0].inner[k];
          found |= x == knot || x == 1.0 - knot;
        }
      CHECK(found);
    }
  tsolid_boundary_free(boundary);
  part_free(&p);
  part_free(&plain);
}

/* A box has many equal coordinates: the choice of corner and axes must not waver. */
static void test_symmetric(tsolid_context *context) {
  static const axis_spec axes[3] = {{1, {{1, 0, {0}}}}, {1, {{1, 0, {0}}}}, {1, {{1, 0, {0}}}}};
  part box = make_part(axes, map_box, 0);
  check_part(context, &box, axes);
  check_orientations(context, &box);
  tsolid_boundary *first = create(context, &box, NULL);
  CHECK(first && first->n_functions == 8);
  for (int k = 0; k < 6; k++) /* noise below the resolution of the choice keeps it */
    for (int i = 0; i < 12; i++)
      ((double *)(size_t)box.patch[k].points)[i] += 1e-13 * (random_unit() - 0.5);
  tsolid_boundary *noisy = create(context, &box, NULL);
  for (int i = 0; first && noisy && i < 8; i++)
    for (int c = 0; c < 3; c++)
      CHECK_NEAR(noisy->requirement.corner[i][c], first->requirement.corner[i][c], 1e-12);
  CHECK(noisy && largest_snap(noisy) > 0.0 && largest_snap(noisy) < 2e-13);
  tsolid_boundary_free(noisy);
  tsolid_boundary_free(first);
  part_free(&box);
}

/* ---- preparation -------------------------------------------------------------------------------
 */

/* Every face with degrees and knots of its own; straight edges make that one surface. */
static part make_mixed_part(int seed_degree, double shift) {
  part p = {6, calloc(6, sizeof *p.patch)};
  for (int side = 0; side < 6; side++) {
    axis_spec axes[3];
    for (int a = 0; a < 3; a++) {
      strip *s = &axes[a].strip[0];
      axes[a].n_strips = 1;
      s->degree = 1 + (seed_degree + 2 * side + 3 * a) % 9;
      s->n_inner = (side + a) % 4;
      for (int i = 0; i < s->n_inner; i++)
        s->inner[i] = (i + 1) / (double)(s->n_inner + 1) - (side == 3 && i == 0 ? shift : 0.0);
    }
    make_side_patch(axes, side, 0, 0, map_bumped, 0, &p.patch[side]);
  }
  return p;
}

static void test_mixed(tsolid_context *context) {
  for (int seed = 0; seed < 9; seed++) {
    /* knots 3e-12 apart are one knot: that moves the surface by about as much */
    double shift = seed % 3 == 2 ? 3e-12 : 0.0, allowed = shift > 0.0 ? 5e-12 : 1e-14;
    part p = make_mixed_part(seed, shift);
    tsolid_boundary *boundary = create(context, &p, NULL);
    if (boundary) {
      CHECK(tsi_boundary_validate(context, boundary) == TSOLID_OK);
      CHECK_NEAR(measure_distance(&p, boundary), 0.0, allowed);
      CHECK(boundary->preparation.n_degrees_raised > 0);
      CHECK(boundary->preparation.n_knots_inserted > 0);
      CHECK_NEAR(boundary->preparation.knot_merge, shift, 1e-15);
      CHECK((boundary->preparation.n_knots_merged > 0) == (boundary->preparation.knot_merge > 0.0));
      CHECK_NEAR(largest_snap(boundary), 0.0, allowed);
    }
    check_shuffles(context, &p, 4, allowed);
    tsolid_boundary_free(boundary);
    part_free(&p);
  }
}

static void test_options(tsolid_context *context) {
  part p = make_part(plain_axes, map_wavy, 1);
  tsolid_boundary *plain = create(context, &p, NULL);
  for (int k = 0; k < 3; k++) {
    tsolid_boundary_options options = {.refine_knots = k & 1 ? 2 : 0,
                                       .raise_degree = k > 0 ? 2 : 0};
    if (k == 0)
      options.refine_knots = 1;
    tsolid_boundary *fine = create(context, &p, &options);
    if (!fine || !plain)
      continue;
    CHECK(tsi_boundary_validate(context, fine) == TSOLID_OK);
    CHECK_NEAR(measure_distance(&p, fine), 0.0, 5e-15);
    for (int side = 0; side < 6; side++) {
      CHECK(fine->side[side].n_elements == plain->side[side].n_elements
                                               << (2 * options.refine_knots));
      CHECK(fine->side[side].degree[0] == plain->side[side].degree[0] + options.raise_degree);
    }
    CHECK(fine->preparation.refine_knots == options.refine_knots);
    CHECK(fine->preparation.n_degrees_raised == 0 && fine->preparation.n_knots_inserted == 0);
    tsolid_boundary_free(fine);
  }
  tsolid_boundary_free(plain);
  part_free(&p);
}

/* Sides scaled by constants are the same surface; without need no weight may change. */
static void test_weights(tsolid_context *context) {
  for (int grid = 0; grid < 2; grid++) {
    part p = make_part(grid ? grid_axes : plain_axes, map_wavy, 1);
    tsolid_boundary *before = create(context, &p, NULL);
    for (int i = 0; before && i < 6; i++)
      CHECK(before->preparation.weight_factor[i] == 1.0);
    for (int k = 0; k < p.n; k++)
      for (int i = 0; i < p.patch[k].n_control[0] * p.patch[k].n_control[1]; i++)
        ((double *)(size_t)p.patch[k].weights)[i] *= 0.3 + 0.7 * k;
    tsolid_boundary *boundary = create(context, &p, NULL);
    if (boundary) {
      CHECK(tsi_boundary_validate(context, boundary) == TSOLID_OK);
      CHECK_NEAR(measure_distance(&p, boundary), 0.0, 3e-15);
      CHECK_NEAR(largest_snap(boundary), 0.0, 1e-14);
      CHECK(grid || boundary->preparation.weight_factor[0] == 1.0);
      CHECK(boundary->preparation.weight_factor[5] != 1.0);
      CHECK(boundary->preparation.n_bilinear_factors == 0 && boundary->preparation.n_moebius == 0);
    }
    check_shuffles(context, &p, 8, 3e-15);
    tsolid_boundary_free(before);
    tsolid_boundary_free(boundary);
    part_free(&p);
  }
}

/* Rows that differ within the tolerance become one, and the move is told. */
static void test_snapping(tsolid_context *context) {
  part p = make_part(grid_axes, map_wavy, 0);
  for (int k = 0; k < p.n; k++)
    for (int i = 0; i < 3 * p.patch[k].n_control[0] * p.patch[k].n_control[1]; i++)
      ((double *)(size_t)p.patch[k].points)[i] += 4e-8 * (random_unit() - 0.5);
  tsolid_boundary *boundary = create(context, &p, NULL);
  if (boundary) {
    CHECK(tsi_boundary_validate(context, boundary) == TSOLID_OK);
    for (int i = 0; i < 12; i++)
      CHECK(boundary->preparation.snap[i] > 1e-9 && boundary->preparation.snap[i] < 7e-8);
    for (int i = 0; i < 6; i++)
      CHECK(boundary->preparation.snap_inside[i] > 1e-9 &&
            boundary->preparation.snap_inside[i] < 7e-8);
    double distance = measure_distance(&p, boundary) * tsolid_boundary_scale(boundary);
    CHECK(distance > 1e-9 && distance <= largest_snap(boundary) * (1.0 + 1e-6));
  }
  int order[24];
  part other = shuffle_part(&p, order);
  tsolid_boundary *shuffled = create(context, &other, NULL);
  CHECK(same_boundaries(boundary, shuffled));
  tsolid_boundary_free(shuffled);
  tsolid_boundary_free(boundary);
  part_free(&other);
  part_free(&p);
}

/* ---- Bezier sides ------------------------------------------------------------------------------
 */

typedef struct bezier_copy {
  tsolid_bezier_boundary view;
  double *points, *box[6], *coefficient[6];
  int *start[6], *function[6];
} bezier_copy;

static void free_copy(bezier_copy *c) {
  free(c->points);
  for (int i = 0; i < 6; i++) {
    free(c->box[i]);
    free(c->coefficient[i]);
    free(c->start[i]);
    free(c->function[i]);
  }
}

/* Elements and functions in random order; side reversed and exchanged as flip and swap say. */
static void copy_side_shuffled(const tsolid_bezier_side *from, const int *number, int shuffle,
                               const int flip[2], int swap, bezier_copy *c, int at) {
  int n = from->n_elements, m = from->function_start[n], entry = 0;
  int n0 = from->degree[0] + 1, n1 = from->degree[1] + 1;
  c->box[at] = part_doubles(4 * (size_t)n);
  c->coefficient[at] = part_doubles((size_t)m * (size_t)(n0 * n1));
  c->start[at] = calloc((size_t)n + 1, sizeof(int));
  c->function[at] = calloc((size_t)m, sizeof(int));
  int turn = shuffle ? random_below(n) : 0;
  for (int e = 0; e < n; e++) {
    int old = (e + turn) % n, first = from->function_start[old];
    int count = from->function_start[old + 1] - first, spin = shuffle ? random_below(count) : 0;
    for (int d = 0; d < 2; d++) {
      const double *range = from->box + 4 * old + 2 * d;
      double *to = c->box[at] + 4 * e + 2 * (swap ? 1 - d : d);
      to[0] = flip[d] ? 1.0 - range[1] : range[0];
      to[1] = flip[d] ? 1.0 - range[0] : range[1];
    }
    for (int k = 0; k < count; k++, entry++) {
      int in = first + (k + spin) % count;
      c->function[at][entry] = number[from->function[in]];
      for (int j = 0; j < n1; j++)
        for (int i = 0; i < n0; i++) {
          int u = flip[0] ? n0 - 1 - i : i, v = flip[1] ? n1 - 1 - j : j;
          c->coefficient[at][entry * n0 * n1 + (swap ? v + n1 * u : u + n0 * v)] =
              from->coefficient[in * n0 * n1 + i + n0 * j];
        }
    }
    c->start[at][e + 1] = entry;
  }
  c->view.side[at] =
      (tsolid_bezier_side){.degree = {swap ? n1 - 1 : n0 - 1, swap ? n0 - 1 : n1 - 1},
                           .n_elements = n,
                           .box = c->box[at],
                           .function_start = c->start[at],
                           .function = c->function[at],
                           .coefficient = c->coefficient[at]};
}

static void copy_bezier(const tsolid_boundary *boundary, int shuffle, bezier_copy *c) {
  tsolid_bezier_boundary view;
  tsolid_boundary_view(boundary, &view);
  memset(c, 0, sizeof *c);
  int n = view.n_functions, *number = malloc((size_t)n * sizeof *number), side[6];
  for (int i = 0; i < n; i++)
    number[i] = i;
  for (int i = 0; i < 6; i++)
    side[i] = i;
  for (int i = n - 1; shuffle && i > 0; i--) {
    int j = random_below(i + 1), swap = number[i];
    number[i] = number[j];
    number[j] = swap;
  }
  for (int i = 5; shuffle && i > 0; i--) {
    int j = random_below(i + 1), swap = side[i];
    side[i] = side[j];
    side[j] = swap;
  }
  c->points = part_doubles(4 * (size_t)n);
  for (int i = 0; i < n; i++)
    memcpy(c->points + 4 * number[i], view.points + 4 * i, 4 * sizeof(double));
  c->view.n_functions = n;
  c->view.points = c->points;
  for (int i = 0; i < 6; i++) {
    int flip[2] = {shuffle && random_below(2), shuffle && random_below(2)};
    copy_side_shuffled(&view.side[i], number, shuffle, flip, shuffle && random_below(2), c,
                       side[i]);
  }
  free(number);
}

static tsolid_status create_bezier(tsolid_context *context, const tsolid_bezier_boundary *bezier,
                                   tsolid_boundary **boundary) {
  tsolid_boundary_input input = {.bezier = bezier};
  return tsolid_boundary_create(context, &input, NULL, NULL, boundary);
}

static void test_bezier(tsolid_context *context) {
  for (int k = 0; k < 5; k++) {
    part p = k == 4 ? make_mixed_part(3, 0.0)
                    : make_part(k & 1 ? grid_axes : plain_axes, map_wavy, k >> 1);
    tsolid_boundary *boundary = create(context, &p, NULL), *again = NULL;
    tsolid_bezier_boundary view;
    tsolid_boundary_view(boundary, &view);
    CHECK(create_bezier(context, &view, &again) == TSOLID_OK);
    CHECK(same_boundaries(boundary, again));
    CHECK(again && again->requirement.satisfied && again->scale == boundary->scale);
    tsolid_placement place;
    CHECK(tsolid_boundary_placement(again, 0, 0, &place) == TSOLID_ERROR_ARGUMENT);
    tsolid_boundary_free(again);
    for (int i = 0; i < 24; i++) {
      bezier_copy c;
      copy_bezier(boundary, 1, &c);
      CHECK(create_bezier(context, &c.view, &again) == TSOLID_OK);
      CHECK(same_boundaries(boundary, again));
      tsolid_boundary_free(again);
      free_copy(&c);
    }
    tsolid_boundary_free(boundary);
    part_free(&p);
  }
}

/* ---- the slow checker --------------------------------------------------------------------------
 */

static void expect_invalid(tsolid_context *context, const tsolid_boundary *boundary,
                           const char *text) {
  tsolid_context_clear(context);
  CHECK(tsi_boundary_validate(context, boundary) == TSOLID_ERROR_INPUT);
  const tsolid_finding *finding = tsolid_context_finding(context, 0);
  if (!CHECK(finding && strstr(finding->text, text)))
    fprintf(stderr, "    '%s' is not in: %s\n", text, finding ? finding->text : "nothing");
}

static void test_validate(tsolid_context *context) {
  part p = make_part(plain_axes, map_wavy, 1);
  tsolid_boundary *b = create(context, &p, NULL);
  tsi_side *side = &b->side[3];
#define SPOIL(type, place, value, text)                                                            \
  do {                                                                                             \
    type kept = (place);                                                                           \
    (place) = (value);                                                                             \
    expect_invalid(context, b, text);                                                              \
    (place) = kept;                                                                                \
    CHECK(tsi_boundary_validate(context, b) == TSOLID_OK);                                         \
  } while (0)
  SPOIL(double, b->points[5], (double)NAN, "not finite");
  SPOIL(double, b->points[7], 0.0, "must be positive");
  SPOIL(double, b->points[7], -1.0, "must be positive");
  SPOIL(double, b->points[7], (double)INFINITY, "must be positive");
  SPOIL(int, b->n_functions, 0, "functions");
  SPOIL(int, b->n_functions, b->n_functions - 1, "names function");
  SPOIL(int, side->degree[1], 0, "degree");
  SPOIL(int, side->degree[0], 26, "degree");
  SPOIL(int, side->n_elements, 0, "elements");
  SPOIL(int, side->n_elements, side->n_elements - 1, "tile");
  SPOIL(int, side->function_start[0], 1, "start at 0");
  SPOIL(int, side->function_start[1], 0, "cannot be");
  SPOIL(int, side->function_start[1], 1 << 30, "cannot be");
  SPOIL(int, side->function[3], -1, "names function");
  SPOIL(int, side->function[3], b->n_functions, "names function");
  SPOIL(int, side->function[3], side->function[2], "twice");
  SPOIL(double, side->coefficient[3], -1e-3, "negative");
  SPOIL(double, side->coefficient[3], (double)NAN, "negative");
  SPOIL(double, side->box[1], 0.9, "tile");
  SPOIL(double, side->box[1], nextafter(side->box[1], 2.0), "tile");
  SPOIL(double, side->box[1], side->box[0], "no box");
  SPOIL(double, side->box[0], (double)NAN, "no box");
  SPOIL(double, side->box[0], -0.5, "no box");
  /* every coefficient on a border of every side belongs to an isoline */
  for (int i = 0; i < 6; i++) {
    int k = b->side[i].function_start[0];
    SPOIL(double, b->side[i].coefficient[k], b->side[i].coefficient[k] + 1e-6, "isoline");
  }
#undef SPOIL
  tsolid_boundary_free(b);
  part_free(&p);
}

/* Bezier sides whose isolines do not agree are refused, not mended. */
static void test_bezier_refused(tsolid_context *context) {
  part p = make_part(plain_axes, map_wavy, 1);
  tsolid_boundary *boundary = create(context, &p, NULL), *made = NULL;
  bezier_copy c;
  copy_bezier(boundary, 0, &c);
  c.coefficient[2][0] += 1e-9;
  c.coefficient[2][0] *= 0.999;
  CHECK(create_bezier(context, &c.view, &made) != TSOLID_OK && !made);
  free_copy(&c);
  copy_bezier(boundary, 0, &c);
  c.view.side[1] = c.view.side[0]; /* the same side twice */
  CHECK(create_bezier(context, &c.view, &made) != TSOLID_OK && !made);
  free_copy(&c);
  copy_bezier(boundary, 0, &c);
  c.view.side[4].coefficient = NULL;
  CHECK(create_bezier(context, &c.view, &made) == TSOLID_ERROR_INPUT && !made);
  free_copy(&c);
  tsolid_boundary_free(boundary);
  part_free(&p);
}

/* Bezier sides with one value spoilt: whatever is taken must pass the slow checker. */
static void test_bezier_spoilt(tsolid_context *context) {
  static const double nasty[8] = {0.0,   -1.0,   0.5,         1.0,
                                  1e300, 1e-300, (double)NAN, (double)INFINITY};
  part p = make_part(plain_axes, map_wavy, 1);
  tsolid_boundary *boundary = create(context, &p, NULL);
  int n_taken = 0, n_refused = 0;
  for (int i = 0; i < 400; i++) {
    bezier_copy c;
    tsolid_boundary *made = NULL;
    copy_bezier(boundary, 1, &c);
    int side = random_below(6), n = c.view.side[side].n_elements, m = c.start[side][n];
    double value = nasty[random_below(8)];
    switch (i % 5) {
    case 0:
      c.points[random_below(4 * c.view.n_functions)] = value;
      break;
    case 1:
      c.box[side][random_below(4 * n)] = value;
      break;
    case 2:
      c.coefficient[side][random_below(m)] = value;
      break;
    case 3:
      c.function[side][random_below(m)] = random_below(c.view.n_functions + 2) - 1;
      break;
    default:
      c.start[side][random_below(n + 1)] -= 1 + random_below(m);
    }
    tsolid_context_clear(context);
    tsolid_status status = create_bezier(context, &c.view, &made);
    CHECK((status == TSOLID_OK) == (made != NULL));
    if (made)
      CHECK(tsi_boundary_validate(context, made) == TSOLID_OK);
    else
      CHECK(tsolid_context_n_findings(context) > 0);
    n_taken += made != NULL;
    n_refused += made == NULL;
    tsolid_boundary_free(made);
    free_copy(&c);
  }
  CHECK(n_taken > 10 && n_refused > 200);
  tsolid_boundary_free(boundary);
  part_free(&p);
}

/* ---- memory and cancel -------------------------------------------------------------------------
 */

static int cancel_at(void *data, const char *stage, double fraction) {
  (void)stage;
  (void)fraction;
  return --*(int *)data == 0;
}

static void test_memory(tsolid_context *context) {
  part mixed = make_mixed_part(1, 3e-12), grid = make_part(grid_axes, map_wavy, 1);
  tsolid_boundary_input input = {.n_patches = mixed.n, .patches = mixed.patch};
  check_failing_memory(&input);
  input = (tsolid_boundary_input){.n_patches = grid.n, .patches = grid.patch};
  check_failing_memory(&input);
  tsolid_boundary *boundary = create(context, &grid, NULL);
  tsolid_bezier_boundary view;
  tsolid_boundary_view(boundary, &view);
  input = (tsolid_boundary_input){.bezier = &view};
  check_failing_memory(&input);
  tsolid_boundary_free(boundary);
  part_free(&mixed);
  part_free(&grid);
}

static void test_cancel(void) {
  part p = make_part(plain_axes, map_wavy, 0);
  tsolid_boundary_input input = {.n_patches = p.n, .patches = p.patch};
  for (int k = 1;; k++) {
    int countdown = k;
    counting c = {0, 0, 0};
    tsolid_context_options options = {.allocate = count_allocate,
                                      .release = count_release,
                                      .allocator_data = &c,
                                      .progress = cancel_at,
                                      .progress_data = &countdown};
    tsolid_context *context = NULL;
    tsolid_boundary *boundary = NULL;
    CHECK(tsolid_context_create(&options, &context) == TSOLID_OK);
    tsolid_status status = tsolid_boundary_create(context, &input, NULL, NULL, &boundary);
    tsolid_boundary_free(boundary);
    tsolid_context_free(context);
    CHECK(c.n_live == 0);
    if (status == TSOLID_OK) {
      CHECK(countdown > 0 && k > 2);
      break;
    }
    CHECK(status == TSOLID_ERROR_CANCELLED);
  }
  part_free(&p);
}

int main(void) {
  tsolid_context *context = new_context();
  test_given_differently(context);
  test_untouched(context);
  test_symmetric(context);
  test_mixed(context);
  test_options(context);
  test_weights(context);
  test_snapping(context);
  test_bezier(context);
  test_validate(context);
  test_bezier_refused(context);
  test_bezier_spoilt(context);
  test_memory(context);
  test_cancel();
  tsolid_context_free(context);
  return check_done();
}
