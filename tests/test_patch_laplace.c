/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Laplace patch test on physical solids: -div grad u = 0 with linear boundary data has the linear
 * function itself as Galerkin solution. It holds only if the rational basis w_A N_A / W contains
 * linear functions of the physical point, is continuous across every diagonal and core face, and
 * the geometry is what the control points say. Made with the public API alone, as a user would. */
#include "check.h"

#include "cube_part.h"
#include "quadrature.h"

enum { MAX_FUNCTIONS = 160, MAX_NET = 4 * 6 * 6, MAX_DEGREE = 6 };

/* B_k(x) of degree p and its derivative, by recursion in p. */
static void bernstein_row(int p, double x, double value[MAX_DEGREE], double slope[MAX_DEGREE]) {
  memset(value, 0, MAX_DEGREE * sizeof *value);
  memset(slope, 0, MAX_DEGREE * sizeof *slope);
  value[0] = 1.0;
  for (int q = 1; q <= p; q++) {
    for (int k = 0; k <= q; k++)
      slope[k] = q * ((k > 0 ? value[k - 1] : 0.0) - (k < q ? value[k] : 0.0));
    for (int k = q; k >= 0; k--)
      value[k] = (1.0 - x) * (k < q ? value[k] : 0.0) + x * (k > 0 ? value[k - 1] : 0.0);
  }
}

/* One element: its functions, their Bernstein coefficients and weights, its homogeneous net. */
typedef struct element_basis {
  int degree[3], size, n, function[MAX_FUNCTIONS];
  double coefficient[MAX_FUNCTIONS * MAX_NET], weight[MAX_FUNCTIONS], net[4 * MAX_NET];
} element_basis;

static int read_element(tsolid_context *context, const tsolid_solid *solid, int e,
                        element_basis *b) {
  tsolid_space_view view;
  tsolid_space_get(tsolid_solid_space(solid), &view);
  b->size = 1;
  for (int a = 0; a < 3; a++) {
    b->degree[a] = view.element_degree[3 * e + a];
    b->size *= b->degree[a] + 1;
  }
  if (!CHECK(b->size <= MAX_NET) ||
      !CHECK(tsolid_space_extraction(context, tsolid_solid_space(solid), e, MAX_FUNCTIONS, &b->n,
                                     b->function, b->coefficient) == TSOLID_OK) ||
      !CHECK(tsolid_solid_bezier(context, solid, e, b->net) == TSOLID_OK))
    return 0;
  for (int i = 0; i < b->n; i++)
    b->weight[i] = tsolid_solid_control(solid)[4 * b->function[i] + 3];
  return 1;
}

/* The rational basis at xi: value[i], physical gradient[i], the point, and det J (0: no gradient).
 */
typedef struct basis_point {
  double value[MAX_FUNCTIONS], gradient[MAX_FUNCTIONS][3], x[3], det;
} basis_point;

/* Rows: value and three derivatives of the Bernstein polynomials of the element. */
static void tensor_rows(const int degree[3], const double xi[3], double row[4][MAX_NET]) {
  double v[3][MAX_DEGREE], d[3][MAX_DEGREE];
  int at = 0;
  for (int a = 0; a < 3; a++)
    bernstein_row(degree[a], xi[a], v[a], d[a]);
  for (int k = 0; k <= degree[2]; k++)
    for (int j = 0; j <= degree[1]; j++)
      for (int i = 0; i <= degree[0]; i++, at++) {
        row[0][at] = v[0][i] * v[1][j] * v[2][k];
        row[1][at] = d[0][i] * v[1][j] * v[2][k];
        row[2][at] = v[0][i] * d[1][j] * v[2][k];
        row[3][at] = v[0][i] * v[1][j] * d[2][k];
      }
}

/* cofactor[c][a] / det = d xi_a / d x_c for the Jacobian j[c][a] = d x_c / d xi_a. */
static double cofactors(double j[3][3], double cofactor[3][3]) {
  for (int c = 0; c < 3; c++)
    for (int a = 0; a < 3; a++)
      cofactor[c][a] = j[(c + 1) % 3][(a + 1) % 3] * j[(c + 2) % 3][(a + 2) % 3] -
                       j[(c + 1) % 3][(a + 2) % 3] * j[(c + 2) % 3][(a + 1) % 3];
  return j[0][0] * cofactor[0][0] + j[0][1] * cofactor[0][1] + j[0][2] * cofactor[0][2];
}

static void evaluate_basis(const element_basis *b, const double xi[3], basis_point *p) {
  double row[4][MAX_NET], h[4][4] = {{0}}, j[3][3], cofactor[3][3];
  tensor_rows(b->degree, xi, row);
  for (int r = 0; r < 4; r++)
    for (int k = 0; k < b->size; k++)
      for (int c = 0; c < 4; c++)
        h[r][c] += row[r][k] * b->net[4 * k + c];
  double w = h[0][3];
  for (int c = 0; c < 3; c++) {
    p->x[c] = h[0][c] / w;
    for (int a = 0; a < 3; a++)
      j[c][a] = (h[a + 1][c] - p->x[c] * h[a + 1][3]) / w;
  }
  p->det = cofactors(j, cofactor);
  for (int i = 0; i < b->n; i++) {
    double n[4] = {0.0, 0.0, 0.0, 0.0}, slope[3];
    for (int r = 0; r < 4; r++)
      for (int k = 0; k < b->size; k++)
        n[r] += row[r][k] * b->coefficient[i * b->size + k];
    p->value[i] = b->weight[i] * n[0] / w;
    for (int a = 0; a < 3; a++)
      slope[a] = b->weight[i] * (n[a + 1] - n[0] * h[a + 1][3] / w) / w;
    for (int c = 0; c < 3; c++)
      p->gradient[i][c] =
          (cofactor[c][0] * slope[0] + cofactor[c][1] * slope[1] + cofactor[c][2] * slope[2]) /
          p->det;
  }
}

/* ---- the discrete problem ----------------------------------------------------------------------
 */

/* matrix (n x n) += integral of grad . grad over the element by n_points^3 Gauss points; 0: the
 * Jacobian is not positive there. */
static int add_element(const element_basis *b, int n_points, int n, double *matrix) {
  double node[TSI_MAX_GAUSS], weight[TSI_MAX_GAUSS];
  basis_point p;
  tsi_gauss(n_points, node, weight);
  for (int q = 0; q < n_points * n_points * n_points; q++) {
    int at[3] = {q % n_points, q / n_points % n_points, q / (n_points * n_points)};
    evaluate_basis(b, (double[3]){node[at[0]], node[at[1]], node[at[2]]}, &p);
    if (!(p.det > 0.0))
      return 0;
    double measure = p.det * weight[at[0]] * weight[at[1]] * weight[at[2]];
    for (int i = 0; i < b->n; i++) {
      const double *g = p.gradient[i];
      double *row = matrix + (ptrdiff_t)b->function[i] * n;
      for (int k = 0; k < b->n; k++)
        row[b->function[k]] +=
            measure * (g[0] * p.gradient[k][0] + g[1] * p.gradient[k][1] + g[2] * p.gradient[k][2]);
    }
  }
  return 1;
}

/* Cholesky's factor of the leading n x n block, rows of `stride`, in place; 0: not positive. */
static int factorise(int n, int stride, double *a) {
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) {
      const double *x = a + (ptrdiff_t)i * stride, *y = a + (ptrdiff_t)j * stride;
      double sum = x[j];
      for (int k = 0; k < j; k++)
        sum -= x[k] * y[k];
      if (i == j && !(sum > 0.0))
        return 0;
      a[(ptrdiff_t)i * stride + j] = i == j ? sqrt(sum) : sum / y[j];
    }
  return 1;
}

static void substitute(int n, int stride, const double *a, double *x) {
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < i; k++)
      x[i] -= a[(ptrdiff_t)i * stride + k] * x[k];
    x[i] /= a[(ptrdiff_t)i * stride + i];
  }
  for (int i = n - 1; i >= 0; i--) {
    for (int k = i + 1; k < n; k++)
      x[i] -= a[(ptrdiff_t)k * stride + i] * x[k];
    x[i] /= a[(ptrdiff_t)i * stride + i];
  }
}

/* Free coefficients for the data of the boundary layer: `u` holds it in entries n_free .. n-1. The
 * factor fills the lower triangle of the free block; the right-hand side needs free rows of bound
 * columns only. */
static void solve(int n, int n_free, const double *matrix, double *u) {
  for (int i = 0; i < n_free; i++) {
    u[i] = 0.0;
    for (int k = n_free; k < n; k++)
      u[i] -= matrix[(ptrdiff_t)i * n + k] * u[k];
  }
  substitute(n_free, n, matrix, u);
}

/* ---- the test ----------------------------------------------------------------------------------
 */

/* Largest |u - linear| at random points of every element; the linear function is x[component]. */
static double solution_error(tsolid_context *context, const tsolid_solid *solid, const double *u,
                             int component, unsigned *seed) {
  static element_basis b;
  static basis_point p;
  tsolid_space_view view;
  double error = 0.0;
  tsolid_space_get(tsolid_solid_space(solid), &view);
  for (int e = 0; e < view.n_elements && read_element(context, solid, e, &b); e++)
    for (int k = 0; k < 4; k++) {
      double xi[3], at[3], x[3], sum = 0.0;
      const double *box = view.element_box + 6 * e;
      for (int a = 0; a < 3; a++) {
        xi[a] = 0.5 + cube_noise(seed);
        at[a] = box[a] + xi[a] * (box[a + 3] - box[a]);
      }
      evaluate_basis(&b, xi, &p);
      for (int i = 0; i < b.n; i++)
        sum += u[b.function[i]] * p.value[i];
      CHECK(tsolid_solid_evaluate(context, solid, view.element_block[e], at, 0, x) == TSOLID_OK);
      error = fmax(error, fabs(sum - x[component]));
    }
  return error;
}

/* Row sums: constants have no gradient. Largest, relative to the largest entry. */
static double constants_error(int n, const double *matrix) {
  double most = 0.0, largest = 0.0;
  for (int i = 0; i < n; i++) {
    double sum = 0.0;
    for (int k = 0; k < n; k++) {
      sum += matrix[(ptrdiff_t)i * n + k];
      largest = fmax(largest, fabs(matrix[(ptrdiff_t)i * n + k]));
    }
    most = fmax(most, fabs(sum));
  }
  return most / largest;
}

static void check_patch(tsolid_context *context, const tsolid_solid *solid, int n_points) {
  static element_basis b;
  tsolid_space_view view;
  tsolid_space_get(tsolid_solid_space(solid), &view);
  int n = view.n_functions, n_free = n - view.n_surface, complete = 1;
  double *matrix = calloc((size_t)n * (size_t)n, sizeof *matrix);
  double *u = calloc((size_t)n, sizeof *u);
  const double *control = tsolid_solid_control(solid);
  double size = tsolid_boundary_scale(tsolid_space_boundary(tsolid_solid_space(solid)));
  unsigned seed = 11;
  for (int e = 0; e < view.n_elements && complete; e++)
    complete = read_element(context, solid, e, &b) && CHECK(add_element(&b, n_points, n, matrix));
  if (complete)
    CHECK_NEAR(constants_error(n, matrix), 0.0, 1e-12);
  if (complete && CHECK(factorise(n_free, n, matrix)))
    for (int c = 0; c < 3; c++) {
      for (int f = n_free; f < n; f++)
        u[f] = control[4 * f + c] / control[4 * f + 3];
      solve(n, n_free, matrix, u);
      CHECK_NEAR(solution_error(context, solid, u, c, &seed), 0.0, 1e-9 * size);
      u[n_free / 2] += 1e-3 * size; /* the measurement sees one coefficient */
      CHECK(solution_error(context, solid, u, c, &seed) > 1e-7 * size);
    }
  free(matrix);
  free(u);
}

/* ---- parts -------------------------------------------------------------------------------------
 */

/* A quarter of a ring with square section: exact arcs of weights 1, cos 45, 1 along x. */
static void quarter_ring(double p[4]) {
  static const double corner[3][2] = {{0.0, 1.0}, {1.0, 1.0}, {1.0, 0.0}};
  int i = (int)floor(2.0 * p[0] + 0.5);
  double radius = 1.0 + p[1];
  p[0] = radius * corner[i][0];
  p[1] = radius * corner[i][1];
  p[3] = i == 1 ? sqrt(0.5) : 1.0;
}

static void check_part(tsolid_context *context, const cube_axis axis[3], cube_map map, int n_cells,
                       int n_points) {
  cube_solid s;
  tsolid_solid *start = NULL, *solid = NULL;
  const tsolid_solid_options quick = {.effort = 2};
  tsolid_certificate certificate;
  if (CHECK(cube_solid_create(context, axis, map, n_cells, 0.0, &s)) &&
      CHECK(tsolid_solid_create(context, s.space, &start) == TSOLID_OK) &&
      CHECK(tsolid_solid_optimise(context, start, &quick, &solid) == TSOLID_OK) &&
      CHECK(tsolid_certify(context, solid, NULL, &certificate, NULL) == TSOLID_OK) &&
      CHECK(certificate.verdict == TSOLID_POSITIVE))
    check_patch(context, solid, n_points);
  tsolid_solid_free(solid);
  tsolid_solid_free(start);
  cube_solid_free(&s);
}

int main(void) {
  tsolid_context *context;
  static const cube_axis cubic[3] = {{3, 2, 1}, {3, 1, 1}, {2, 2, 2}};
  static const cube_axis mixed[3] = {{4, 1, 1}, {1, 1, 1}, {2, 2, 1}};
  static const cube_axis ring[3] = {{2, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  check_part(context, cubic, cube_wave, 1, 5); /* 5 points: exact to degree 9 >= 3 * 3 - 1 */
  check_part(context, mixed, cube_wave, 2, 6);
  check_part(context, cubic, cube_rational, 1, 9);
  check_part(context, ring, quarter_ring, 1, 9);
  tsolid_context_free(context);
  return check_done();
}
