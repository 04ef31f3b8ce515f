/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Polynomials are reproduced: with coefficients from polar forms (blossoms) at the interior local
 * knots, the functions sum to every monomial u0^i u1^j u2^k, exponents up to 3, in the core; in an
 * arm to those whose lateral part the input's functions contain. One wrong local knot breaks it.
 *
 * The blossom of u^k in degree p at x_1 .. x_p is e_k(x) / C(p, k), e_k the elementary symmetric
 * polynomial; at p - i ends lo and i ends hi it is Bernstein coefficient i on [lo, hi].
 *
 * Source: L. Ramshaw (1989), Blossoms are polar forms. */
#include "check.h"

#include "cube_part.h"

enum { N_POWERS = 4, N_MONOMIALS = N_POWERS * N_POWERS * N_POWERS };

static const double TOLERANCE = 1e-11;
static const double SIZE[3] = {3.0, 2.0,
                               1.5}; /* no two axes alike: the canonical position is one */

/* value[k] = blossom of u^k, k < N_POWERS; 0 where k > degree. */
static void blossoms(int degree, const double *at, double value[N_POWERS]) {
  double e[N_POWERS] = {1.0, 0.0, 0.0, 0.0};
  for (int i = 0; i < degree; i++)
    for (int k = N_POWERS - 1; k > 0; k--)
      e[k] += e[k - 1] * at[i];
  for (int k = 0; k < N_POWERS; k++)
    value[k] = k <= degree ? e[k] / tsi_binomial(degree, k) : 0.0;
}

/* ---- a box with known knots --------------------------------------------------------------------
 */

typedef struct fixture {
  cube_axis axis[3];
  double *knot[3];         /* of the input, per axis of the world */
  int world[3], mirror[3]; /* of the canonical axes */
  int (*place)[3];         /* per surface function: its indices along the axes of the world */
  tsolid_boundary *boundary;
  tsolid_tmesh *tmesh;
  tsolid_space *space;
} fixture;

static void scale_box(double p[4]) {
  for (int d = 0; d < 3; d++)
    p[d] *= SIZE[d];
}

/* Which axis of the world a canonical one is, and whether it runs against it. */
static void find_axes(fixture *f) {
  tsolid_requirement r;
  tsolid_boundary_requirement(f->boundary, &r);
  for (int a = 0; a < 3; a++) {
    f->world[a] = -1;
    for (int d = 0; d < 3; d++) {
      double step = r.corner[1 << a][d] - r.corner[0][d];
      if (fabs(step) < 0.5)
        continue;
      CHECK(f->world[a] < 0);
      f->world[a] = d;
      f->mirror[a] = step < 0.0;
    }
    CHECK(f->world[a] >= 0);
  }
}

/* The indices of every surface function from its control point, a Greville point. */
static void find_places(fixture *f) {
  int n = f->boundary->n_functions;
  f->place = calloc((size_t)n, sizeof *f->place);
  for (int i = 0; i < n; i++)
    for (int d = 0; d < 3; d++) {
      const double *p = f->boundary->points + 4 * i;
      int found = 0, degree = f->axis[d].degree;
      for (int k = 0; k < cube_n_functions(&f->axis[d]); k++) {
        double greville = 0.0;
        for (int j = 1; j <= degree; j++)
          greville += f->knot[d][k + j] / degree;
        if (fabs(greville - p[d] / SIZE[d]) < 1e-9) {
          f->place[i][d] = k;
          found++;
        }
      }
      CHECK(found == 1);
    }
}

static void fixture_free(fixture *f) {
  for (int d = 0; d < 3; d++)
    free(f->knot[d]);
  free(f->place);
  tsolid_space_free(f->space);
  tsolid_tmesh_free(f->tmesh);
  tsolid_boundary_free(f->boundary);
}

/* n cells per axis of uneven widths under arms of uneven heights; n[0] = 0: the library's own. */
static tsolid_status make_tmesh(tsolid_context *context, fixture *f, const int n[3]) {
  static const double height[6] = {0.5, 0.3, 0.4, 0.45, 0.25, 0.6};
  if (n[0] == 0)
    return tsolid_tmesh_create(context, f->boundary, NULL, &f->tmesh);
  double line[3][8];
  const double *lines[3] = {line[0], line[1], line[2]};
  int n_lines[3], box[7 * 7 * 7 * 6], n_boxes = n[0] * n[1] * n[2];
  for (int a = 0; a < 3; a++) {
    n_lines[a] = n[a] + 1;
    for (int i = 0; i <= n[a]; i++)
      line[a][i] = i == n[a] ? 1.0 : (i + 0.3 * sin(2.0 * i + a) * (i > 0)) / n[a];
  }
  for (int b = 0; b < n_boxes; b++) {
    int lo[3] = {b % n[0], b / n[0] % n[1], b / (n[0] * n[1])};
    for (int i = 0; i < 6; i++)
      box[6 * b + i] = lo[i % 3] + i / 3;
  }
  return tsi_tmesh_from_boxes(context, n_lines, lines, n_boxes, box, height, 0, &f->tmesh);
}

static int fixture_create(tsolid_context *context, const cube_axis axis[3], const int n_cells[3],
                          fixture *f) {
  cube_part part = cube_part_create(axis, scale_box);
  tsolid_boundary_input input = {.bezier = &part.boundary};
  *f = (fixture){.space = NULL};
  for (int d = 0; d < 3; d++) {
    f->axis[d] = axis[d];
    f->knot[d] = calloc((size_t)(part.n[d] + axis[d].degree + 1), sizeof(double));
    cube_knots(&axis[d], f->knot[d]);
  }
  int made =
      CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &f->boundary) == TSOLID_OK) &&
      CHECK(make_tmesh(context, f, n_cells) == TSOLID_OK) &&
      CHECK(tsolid_space_create(context, f->boundary, f->tmesh, &f->space) == TSOLID_OK);
  cube_part_free(&part);
  if (made) {
    find_axes(f);
    find_places(f);
  }
  return made;
}

/* ---- coefficients ------------------------------------------------------------------------------
 */

/* The piece of an inner function that lives in the block: glued ones have one per arm. */
static const tsi_piece *piece_in(const tsolid_space *space, int function, int block) {
  const tsi_piece *found = NULL;
  int n = 0;
  for (int i = space->piece_start[function]; i < space->piece_start[function + 1]; i++)
    if (space->piece[i].block < 0 || space->piece[i].block == block) {
      found = &space->piece[i];
      n++;
    }
  if (n != 1) /* counted only where it fails: there are many */
    CHECK(n == 1);
  return found;
}

static void inner_factors(const fixture *f, int function, int block, double factor[3][N_POWERS]) {
  const tsi_piece *piece = piece_in(f->space, function, block);
  memset(factor, 0, 3 * sizeof *factor);
  for (int a = 0; a < 3 && piece; a++) {
    double at[3];
    for (int k = 0; k < 3; k++)
      at[k] = f->tmesh->plane_value[a][piece->knot[a][k + 1]];
    blossoms(3, at, factor[a]);
  }
}

/* Lateral: the input's own knots; radial: r1, R, R for the layer R- and R, R, R for R. */
static void surface_factors(const fixture *f, int function, int outer, int block,
                            double factor[3][N_POWERS]) {
  int side = block - 1;
  for (int a = 0; a < 3; a++) {
    double at[TSI_MAX_DEGREE], height = f->tmesh->arm_height[side];
    if (a == tsi_side_axis(side)) {
      for (int k = 0; k < 3; k++) {
        double r = k == 0 && !outer ? 0.5 * height : height;
        at[k] = side & 1 ? 1.0 + r : -r;
      }
      blossoms(3, at, factor[a]);
      continue;
    }
    int d = f->world[a], degree = f->axis[d].degree;
    for (int k = 0; k < degree; k++) {
      double x = f->knot[d][f->place[function][d] + 1 + k];
      at[k] = f->mirror[a] ? 1.0 - x : x;
    }
    blossoms(degree, at, factor[a]);
  }
}

static void factors_of(const fixture *f, int function, int block, double factor[3][N_POWERS]) {
  int surface = function - f->space->n_inner;
  if (surface < 0)
    inner_factors(f, function, block, factor);
  else
    surface_factors(f, surface % f->space->n_surface, surface >= f->space->n_surface, block,
                    factor);
}

/* ---- sums on an element ------------------------------------------------------------------------
 */

/* Exponents that all functions on the block contain. */
static void highest_powers(const fixture *f, int block, int power[3]) {
  for (int a = 0; a < 3; a++) {
    int degree = f->axis[f->world[a]].degree, radial = block > 0 && tsi_side_axis(block - 1) == a;
    power[a] = block == 0 || radial || degree > 3 ? 3 : degree;
  }
}

/* Largest deviation of sum_A lambda_A N_A from the monomials, in Bernstein coefficients. */
static double element_error(tsolid_context *context, const fixture *f, int e, long *n_compared) {
  enum { MAX_FUNCTIONS = 300, MAX_SIZE = 4 * 6 * 6 };
  static double coefficient[MAX_FUNCTIONS * MAX_SIZE], sum[N_MONOMIALS][MAX_SIZE];
  const tsi_element *element = &f->space->element[e];
  const int *degree = element->degree;
  int function[MAX_FUNCTIONS], n, power[3];
  int size = (degree[0] + 1) * (degree[1] + 1) * (degree[2] + 1);
  double bernstein[3][6][N_POWERS], error = 0.0;
  if (!CHECK(size <= MAX_SIZE) ||
      !CHECK(tsolid_space_extraction(context, f->space, e, MAX_FUNCTIONS, &n, function,
                                     coefficient) == TSOLID_OK))
    return (double)INFINITY;
  memset(sum, 0, sizeof sum);
  highest_powers(f, element->block, power);
  for (int i = 0; i < n; i++) {
    double factor[3][N_POWERS];
    factors_of(f, function[i], element->block, factor);
    for (int m = 0; m < N_MONOMIALS; m++) {
      double lambda = factor[0][m % 4] * factor[1][m / 4 % 4] * factor[2][m / 16];
      for (int k = 0; lambda != 0.0 && k < size; k++)
        sum[m][k] += lambda * coefficient[i * size + k];
    }
  }
  for (int a = 0; a < 3; a++)
    for (int i = 0; i <= degree[a]; i++) {
      double at[5];
      for (int k = 0; k < degree[a]; k++)
        at[k] = element->box[k < i ? a + 3 : a];
      blossoms(degree[a], at, bernstein[a][i]);
    }
  for (int m = 0; m < N_MONOMIALS; m++) {
    int p[3] = {m % 4, m / 4 % 4, m / 16}, n0 = degree[0] + 1, n1 = degree[1] + 1;
    if (p[0] > power[0] || p[1] > power[1] || p[2] > power[2])
      continue;
    for (int k = 0; k < size; k++, ++*n_compared) {
      double expected = bernstein[0][k % n0][p[0]] * bernstein[1][k / n0 % n1][p[1]] *
                        bernstein[2][k / (n0 * n1)][p[2]];
      error = fmax(error, fabs(sum[m][k] - expected));
    }
  }
  return error;
}

static double largest_error(tsolid_context *context, const fixture *f) {
  double error = 0.0;
  long n = 0;
  for (int e = 0; e < f->space->n_elements; e++)
    error = fmax(error, element_error(context, f, e, &n));
  CHECK(n >= 8L * f->space->n_elements);
  return error;
}

/* ---- tests -------------------------------------------------------------------------------------
 */

static void check_case(tsolid_context *context, const cube_axis axis[3], const int n_cells[3]) {
  fixture f;
  if (fixture_create(context, axis, n_cells, &f) &&
      !CHECK_NEAR(largest_error(context, &f), 0.0, TOLERANCE))
    fprintf(stderr, "    degrees %d %d %d, cells %d %d %d\n", axis[0].degree, axis[1].degree,
            axis[2].degree, n_cells[0], n_cells[1], n_cells[2]);
  fixture_free(&f);
}

/* Another plane in place of one interior local knot: the measurement must see each. */
static void test_wrong_knot(tsolid_context *context) {
  static const cube_axis axis[3] = {{2, 2, 1}, {3, 1, 1}, {3, 1, 1}};
  static const int n_cells[3] = {2, 1, 1};
  fixture f;
  if (fixture_create(context, axis, n_cells, &f)) {
    const tsolid_space *space = f.space;
    int n_pieces = space->piece_start[space->n_inner], n_tried = 0;
    for (int i = 0; i < 9 * n_pieces; i += 37) {
      int a = i % 3, *knot = &space->piece[i / 9].knot[a][1 + i / 3 % 3], kept = *knot;
      const double *value = f.tmesh->plane_value[a];
      for (*knot = 0; value[*knot] == value[kept];)
        ++*knot;
      n_tried++;
      CHECK(largest_error(context, &f) > 1e-4);
      *knot = kept;
    }
    CHECK(n_tried > 20);
    CHECK_NEAR(largest_error(context, &f), 0.0, TOLERANCE);
  }
  fixture_free(&f);
}

int main(void) {
  tsolid_context *context;
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  for (int p = 1; p <= 5; p++) { /* core cells that have nothing to do with the input's spans */
    cube_axis axis[3] = {{p, 2, 1}, {p, 1, 1}, {p, 3, 1 + p / 2}};
    check_case(context, axis, (int[3]){1 + p % 4, 1 + (p + 1) % 4, 1 + (p + 2) % 3});
  }
  for (int n = 1; n <= 4; n++) {
    cube_axis axis[3] = {{1 + n % 4, n, 1}, {3, 2, 1 + n % 3}, {2, n, 2}};
    check_case(context, axis, (int[3]){n, n, n});
  }
  cube_axis mixed[3] = {{5, 2, 4}, {1, 3, 1}, {4, 1, 1}},
            long_one[3] = {{3, 7, 1}, {3, 1, 1}, {2, 1, 1}};
  check_case(context, mixed, (int[3]){4, 1, 2});
  check_case(context, mixed, (int[3]){0, 0, 0});
  check_case(context, long_one, (int[3]){7, 1, 1});
  check_case(context, long_one, (int[3]){0, 0, 0});
  test_wrong_knot(context);
  tsolid_context_free(context);
  return check_done();
}
