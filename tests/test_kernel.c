/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Energies of the Jacobian: their Jacobians against the evaluator, their gradients against
 * differences that are exact for a quartic energy, the nets against their transpose, the rules of
 * quadrature against monomials. */
#include "check.h"

#include "cube_part.h"
#include "kernel.h"
#include "net.h"
#include "quadrature.h"

/* ---- fixture -----------------------------------------------------------------------------------
 */

typedef struct fixture {
  tsolid_context *context;
  cube_solid s;
  int n, n_free;
  double *position, *direction, *moved, *gradient, *element_energy;
  unsigned char *active;
} fixture;

/* Inner weights like the boundary's, where those are all one number. */
static int weigh_inside(fixture *f) {
  const tsolid_space *space = f->s.space;
  double *control = calloc(4 * (size_t)f->n, sizeof *control);
  tsolid_solid *solid = NULL;
  memcpy(control, f->s.solid->control, 4 * (size_t)f->n * sizeof *control);
  for (int i = 0; i < 4 * space->n_inner; i++)
    control[i] *= space->boundary->points[3];
  int made = CHECK(tsolid_solid_from_control(f->context, space, control, &solid) == TSOLID_OK) &&
             CHECK(solid->constant_weight);
  free(control);
  if (made) {
    tsolid_solid_free(f->s.solid);
    f->s.solid = solid;
  }
  return made;
}

static int fixture_create(int n_threads, const cube_axis axis[3], cube_map map, int n_cells,
                          fixture *f) {
  tsolid_context_options options = {.n_threads = n_threads};
  double noise = map == cube_rational ? 0.02 : 0.0; /* none: the weights stay one number */
  *f = (fixture){.context = NULL};
  if (!CHECK(tsolid_context_create(&options, &f->context) == TSOLID_OK) ||
      !CHECK(cube_solid_create(f->context, axis, map, n_cells, noise, &f->s)))
    return 0;
  f->n_free = f->s.space->n_inner + f->s.space->n_surface;
  f->n = f->n_free + f->s.space->n_surface;
  if (noise == 0.0 && !weigh_inside(f))
    return 0;
  double **array[] = {&f->position, &f->direction, &f->moved, &f->gradient};
  for (int i = 0; i < 4; i++)
    *array[i] = calloc(3 * (size_t)f->n, sizeof(double));
  f->element_energy = calloc((size_t)f->s.space->n_elements, sizeof(double));
  f->active = calloc((size_t)f->s.space->n_elements, 1);
  for (int i = 0; i < 3 * f->n; i++)
    f->position[i] =
        f->s.solid->control[4 * (i / 3) + i % 3] / f->s.solid->control[4 * (i / 3) + 3];
  return 1;
}

static void fixture_free(fixture *f) {
  void *owned[] = {f->position, f->direction, f->moved, f->gradient, f->element_energy, f->active};
  for (int i = 0; i < 6; i++)
    free(owned[i]);
  cube_solid_free(&f->s);
  tsolid_context_free(f->context);
}

/* ---- densities ---------------------------------------------------------------------------------
 */

/* A quartic in J that treats no two entries alike, and elements unlike each other:
 * (sum m_i j_i)^2 + 0.3 det J + 0.05 |J|^4, times 1 + element mod 3. */
static void quartic_density(const void *data, int element, int n, int stride, const double *weight,
                            const double *j, double *energy, double *g) {
  (void)data;
  for (int q = 0; q < n; q++) {
    double f[9], linear = 0.0, square = 0.0, det = 0.0, w = weight[q] * (1 + element % 3);
    for (int i = 0; i < 9; i++) {
      f[i] = j[i * stride + q];
      linear += (i - 3.5) * f[i];
      square += f[i] * f[i];
    }
    for (int i = 0; i < 9; i++) {
      int c = i / 3, a = i % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3, a1 = (a + 1) % 3,
          a2 = (a + 2) % 3;
      double cofactor = f[3 * c1 + a1] * f[3 * c2 + a2] - f[3 * c1 + a2] * f[3 * c2 + a1];
      det += c == 0 ? f[i] * cofactor : 0.0;
      g[i * stride + q] = w * (2.0 * linear * (i - 3.5) + 0.3 * cofactor + 0.2 * square * f[i]);
    }
    *energy += w * (linear * linear + 0.3 * det + 0.05 * square * square);
  }
}

static double energy_along(fixture *f, tsi_kernel *kernel, double step,
                           const unsigned char *active) {
  double energy;
  for (int i = 0; i < 3 * f->n; i++)
    f->moved[i] = f->position[i] + step * f->direction[i];
  tsi_kernel_energy(kernel, f->moved, quartic_density, NULL, active, &energy, NULL, NULL);
  return energy;
}

/* The derivative along `direction`; the five-point formula is exact for quartics. */
static void check_slope(fixture *f, tsi_kernel *kernel, const unsigned char *active) {
  const double h = 0.25;
  double slope = 0.0, energy;
  tsi_kernel_energy(kernel, f->position, quartic_density, NULL, active, &energy, f->gradient, NULL);
  for (int i = 0; i < 3 * f->n_free; i++)
    slope += f->gradient[i] * f->direction[i];
  double near = energy_along(f, kernel, h, active) - energy_along(f, kernel, -h, active);
  double far = energy_along(f, kernel, 2 * h, active) - energy_along(f, kernel, -2 * h, active);
  CHECK_NEAR((8.0 * near - far) / (12.0 * h), slope, 1e-11 * (fabs(slope) + fabs(energy)));
}

static void check_gradient(fixture *f, tsi_rule rule) {
  tsi_kernel *kernel;
  unsigned seed = 3;
  if (!CHECK(tsi_kernel_create(f->context, f->s.space, f->s.solid->control, rule, &kernel) ==
             TSOLID_OK))
    return;
  for (int e = 0; e < f->s.space->n_elements; e++)
    f->active[e] = cube_noise(&seed) > 0.0;
  for (int k = 0; k < 14; k++) { /* everything at once, then single coordinates */
    memset(f->direction, 0, 3 * (size_t)f->n * sizeof *f->direction);
    for (int i = 0; k < 4 && i < 3 * f->n_free; i++)
      f->direction[i] = 0.1 * cube_noise(&seed);
    if (k >= 4) {
      int first = k % 2 ? f->s.space->n_inner : 0, end = k % 2 ? f->n_free : f->s.space->n_inner;
      int function = first + (int)((0.5 + cube_noise(&seed)) * (end - first));
      f->direction[3 * function + k / 2 % 3] = 1.0;
    }
    check_slope(f, kernel, NULL);
    check_slope(f, kernel, f->active);
  }
  tsi_kernel_free(kernel);
}

/* ---- energies ----------------------------------------------------------------------------------
 */

/* What is left out counts nothing; the rest adds up. */
static void check_active(fixture *f) {
  tsi_kernel *kernel;
  int n = f->s.space->n_elements;
  double whole, part, sum = 0.0, *all = calloc((size_t)n, sizeof *all);
  if (CHECK(tsi_kernel_create(f->context, f->s.space, f->s.solid->control, TSI_LOBATTO, &kernel) ==
            TSOLID_OK)) {
    for (int e = 0; e < n; e++)
      f->active[e] = e % 3 == 1;
    tsi_kernel_energy(kernel, f->position, quartic_density, NULL, NULL, &whole, NULL, all);
    tsi_kernel_energy(kernel, f->position, quartic_density, NULL, f->active, &part, NULL,
                      f->element_energy);
    for (int e = 0; e < n; e++) {
      CHECK(f->element_energy[e] == (f->active[e] ? all[e] : 0.0));
      CHECK(all[e] != 0.0);
      sum += f->element_energy[e];
      whole -= all[e];
    }
    CHECK(sum == part);
    CHECK_NEAR(whole, 0.0, 1e-11 * fabs(part));
    tsi_kernel_free(kernel);
  }
  free(all);
}

/* A kernel that has seen another boundary layer gives what a new one gives. */
static void check_moved_boundary(fixture *f) {
  tsi_kernel *used, *fresh;
  double first, last, moved, expected;
  memcpy(f->moved, f->position, 3 * (size_t)f->n * sizeof *f->moved);
  f->moved[3 * f->n_free + 4] += 0.125;
  CHECK(tsi_kernel_create(f->context, f->s.space, f->s.solid->control, TSI_GRID, &used) ==
        TSOLID_OK);
  CHECK(tsi_kernel_create(f->context, f->s.space, f->s.solid->control, TSI_GRID, &fresh) ==
        TSOLID_OK);
  if (used && fresh) {
    tsi_kernel_energy(used, f->position, quartic_density, NULL, NULL, &first, NULL, NULL);
    tsi_kernel_energy(used, f->moved, quartic_density, NULL, NULL, &moved, NULL, NULL);
    tsi_kernel_energy(used, f->position, quartic_density, NULL, NULL, &last, NULL, NULL);
    tsi_kernel_energy(fresh, f->moved, quartic_density, NULL, NULL, &expected, NULL, NULL);
    CHECK(first == last);
    CHECK(moved == expected && moved != first);
  }
  tsi_kernel_free(used);
  tsi_kernel_free(fresh);
}

/* ---- Jacobians ---------------------------------------------------------------------------------
 */

enum { GRID = 7, N_GRID = GRID * GRID * GRID };

typedef struct record {
  double *j; /* per element: 9 rows of N_GRID */
  int n_wrong;
} record;

static void record_density(const void *data, int element, int n, int stride, const double *weight,
                           const double *j, double *energy, double *g) {
  record *r = (record *)(uintptr_t)data;
  double sum = 0.0;
  (void)g;
  for (int q = 0; q < n; q++)
    sum += weight[q];
  r->n_wrong += n != N_GRID || stride < n || fabs(sum - 1.0) > 1e-14;
  for (int i = 0; i < 9 && n == N_GRID; i++)
    memcpy(r->j + ((ptrdiff_t)element * 9 + i) * N_GRID, j + (ptrdiff_t)i * stride,
           N_GRID * sizeof *j);
  *energy += 1.0;
}

/* On the grid's inner points, where no two elements meet. */
static void check_jacobians(fixture *f) {
  tsi_kernel *kernel;
  const tsolid_space *space = f->s.space;
  int n = space->n_elements;
  record r = {calloc((size_t)n * 9 * N_GRID, sizeof(double)), 0};
  double energy, error = 0.0;
  if (CHECK(tsi_kernel_create(f->context, space, f->s.solid->control, TSI_GRID, &kernel) ==
            TSOLID_OK)) {
    tsi_kernel_energy(kernel, f->position, record_density, &r, NULL, &energy, NULL, NULL);
    CHECK(energy == n && r.n_wrong == 0);
  }
  for (int e = 0; e < n; e++)
    for (int q = e % 11; q < N_GRID; q += 11) {
      int at[3] = {q % GRID, q / GRID % GRID, q / (GRID * GRID)}, inside = 1;
      const double *box = space->element[e].box;
      double u[3], x[12];
      for (int a = 0; a < 3; a++) {
        u[a] = box[a] + (box[a + 3] - box[a]) * at[a] / (GRID - 1);
        inside &= at[a] > 0 && at[a] < GRID - 1;
      }
      if (!inside)
        continue;
      CHECK(tsolid_solid_evaluate(f->context, f->s.solid, space->element[e].block, u, 1, x) ==
            TSOLID_OK);
      for (int i = 0; i < 9; i++) {
        int c = i / 3, a = i % 3;
        double expected = x[3 + 3 * a + c] * (box[a + 3] - box[a]);
        error = fmax(error, fabs(r.j[((ptrdiff_t)e * 9 + i) * N_GRID + q] - expected));
      }
    }
  CHECK_NEAR(error, 0.0, 1e-12);
  tsi_kernel_free(kernel);
  free(r.j);
}

/* ---- transpose ---------------------------------------------------------------------------------
 */

static double dot(size_t n, const double *x, const double *y) {
  double sum = 0.0;
  for (size_t i = 0; i < n; i++)
    sum += x[i] * y[i];
  return sum;
}

static double norm(size_t n, const double *x) {
  return sqrt(dot(n, x, x));
}

static void fill_noise(unsigned *seed, size_t n, double *x) {
  for (size_t i = 0; i < n; i++)
    x[i] = cube_noise(seed);
}

/* <A x, y> = <x, A^T y> for the map A from control points (inner, R-) to the net of an element. */
static void check_adjoint(const tsolid_space *space, int element, int nc, unsigned *seed) {
  enum { MAX_NET = 4 * 4 * TSI_MAX_ORDER * TSI_MAX_ORDER };
  static double net[MAX_NET], y[MAX_NET], lateral[MAX_NET], lateral_x[MAX_NET];
  size_t n_free = (size_t)(space->n_inner + space->n_surface), components = (size_t)nc;
  size_t n_entries = space->inner_start[element + 1] - space->inner_start[element];
  size_t size = components * (space->bezier_start[element + 1] - space->bezier_start[element]);
  double *x = calloc((n_free + (size_t)space->n_surface) * components, sizeof *x);
  double *entry = calloc(n_entries * components + 1, sizeof *entry), right = 0.0;
  fill_noise(seed, n_free * components, x); /* the layer R is given: zero */
  fill_noise(seed, size, y);
  tsi_element_net(space, x, nc, element, net);
  tsi_element_net_transpose(space, nc, element, y, entry, lateral);
  for (size_t i = 0; i < n_entries; i++) {
    size_t function = (size_t)space->inner_function[space->inner_start[element] + i];
    right += dot(components, x + function * components, entry + i * components);
  }
  if (space->element[element].lateral >= 0) {
    const tsi_lateral *l = &space->lateral[space->element[element].lateral];
    size_t n_lateral = components * (size_t)(l->degree[0] + 1) * (size_t)(l->degree[1] + 1);
    tsi_lateral_net(space, x + (size_t)space->n_inner * components, nc,
                    space->element[element].lateral, lateral_x);
    right += dot(n_lateral, lateral_x, lateral);
  }
  CHECK_NEAR(dot(size, net, y), right, 1e-14 * norm(size, net) * norm(size, y));
  CHECK(norm(size, net) > 0.0);
  free(x);
  free(entry);
}

static void check_adjoints(const fixture *f) {
  unsigned seed = 17;
  for (int e = 0; e < f->s.space->n_elements; e++)
    check_adjoint(f->s.space, e, 1 + e % 4, &seed);
}

/* ---- threads -----------------------------------------------------------------------------------
 */

/* Enough elements that three threads have work. */
static void test_threads(void) {
  static const cube_axis axis[3] = {{4, 3, 1}, {3, 6, 1}, {2, 2, 1}};
  double energy[2];
  fixture f[2];
  int made = 1;
  for (int k = 0; k < 2; k++) {
    tsi_kernel *kernel = NULL;
    made &= fixture_create(k ? 3 : 1, axis, cube_rational, 6, &f[k]);
    if (made && CHECK(tsi_kernel_create(f[k].context, f[k].s.space, f[k].s.solid->control,
                                        TSI_LOBATTO, &kernel) == TSOLID_OK))
      tsi_kernel_energy(kernel, f[k].position, quartic_density, NULL, NULL, &energy[k],
                        f[k].gradient, f[k].element_energy);
    tsi_kernel_free(kernel);
  }
  if (made) {
    size_t n = (size_t)f[0].s.space->n_elements;
    CHECK(n > 600);
    CHECK(energy[0] == energy[1]);
    CHECK(memcmp(f[0].element_energy, f[1].element_energy, n * sizeof(double)) == 0);
    CHECK(memcmp(f[0].gradient, f[1].gradient, 3 * (size_t)f[0].n_free * sizeof(double)) == 0);
  }
  fixture_free(&f[0]);
  fixture_free(&f[1]);
}

/* ---- quadrature --------------------------------------------------------------------------------
 */

/* Exact for x^k up to `exact`, in powers of x and of 1 - 2x; ascending, symmetric, positive. */
static void check_rule(int n, int exact, const double *node, const double *weight) {
  for (int i = 0; i < n; i++) {
    CHECK(weight[i] > 0.0 && node[i] >= 0.0 && node[i] <= 1.0);
    CHECK(i == 0 || node[i] > node[i - 1]);
    CHECK(weight[i] == weight[n - 1 - i]);
    CHECK_NEAR(node[i] + node[n - 1 - i], 1.0, 0x1p-52);
  }
  for (int k = 0; k <= exact; k++) {
    double sum = 0.0, centred = 0.0;
    for (int i = 0; i < n; i++) {
      sum += weight[i] * pow(node[i], k);
      centred += weight[i] * pow(1.0 - 2.0 * node[i], k);
    }
    CHECK_NEAR(sum, 1.0 / (k + 1), 4e-15);
    CHECK_NEAR(centred, k % 2 ? 0.0 : 1.0 / (k + 1), 4e-15);
  }
}

/* One degree more is wrong, while the error can be seen. */
static void check_not_better(int n, int degree, const double *node, const double *weight) {
  double sum = 0.0;
  for (int i = 0; i < n; i++)
    sum += weight[i] * pow(1.0 - 2.0 * node[i], degree);
  CHECK(fabs(sum - 1.0 / (degree + 1)) > 1e-9);
}

static void test_quadrature(void) {
  double node[TSI_MAX_GAUSS], weight[TSI_MAX_GAUSS];
  for (int n = 1; n <= TSI_MAX_GAUSS; n++) {
    tsi_gauss(n, node, weight);
    check_rule(n, 2 * n - 1, node, weight);
    CHECK(node[0] > 0.0);
    if (n <= 12)
      check_not_better(n, 2 * n, node, weight);
  }
  for (int n = 2; n <= TSI_MAX_GAUSS; n++) {
    tsi_gauss_lobatto(n, node, weight);
    check_rule(n, 2 * n - 3, node, weight);
    CHECK(node[0] == 0.0 && node[n - 1] == 1.0);
    if (n <= 12)
      check_not_better(n, 2 * n - 2, node, weight);
  }
}

/* What a plain sum loses. */
static void test_sum(void) {
  tsi_sum large = {0.0, 0.0}, small = {0.0, 0.0};
  tsi_sum_add(&large, 1.0);
  tsi_sum_add(&large, 0x1p80);
  tsi_sum_add(&large, 1.0);
  tsi_sum_add(&large, -0x1p80);
  CHECK(tsi_sum_get(&large) == 2.0);
  tsi_sum_add(&small, 1.0);
  for (int i = 0; i < 1024; i++)
    tsi_sum_add(&small, 0x1p-60);
  CHECK(tsi_sum_get(&small) == 1.0 + 0x1p-50);
}

/* ---- all together ------------------------------------------------------------------------------
 */

static void check_case(const cube_axis axis[3], cube_map map, int n_cells) {
  fixture f;
  if (fixture_create(1, axis, map, n_cells, &f)) {
    check_gradient(&f, TSI_LOBATTO);
    check_gradient(&f, TSI_GRID);
    check_active(&f);
    check_moved_boundary(&f);
    check_jacobians(&f);
    check_adjoints(&f);
  }
  fixture_free(&f);
}

/* All weights one number other than 1. */
static void heavy(double p[4]) {
  cube_wave(p);
  p[3] = 3.0;
}

int main(void) {
  static const cube_axis cubic[3] = {{3, 2, 1}, {3, 1, 1}, {3, 1, 1}};
  static const cube_axis mixed[3] = {{2, 2, 1}, {5, 1, 1}, {4, 1, 1}};
  static const cube_axis high[3] = {{1, 1, 1}, {9, 1, 1}, {2, 2, 2}};
  check_case(cubic, cube_wave, 1);
  check_case(mixed, cube_wave, 1);
  check_case(mixed, cube_rational, 2);
  check_case(high, cube_rational, 1);
  check_case(cubic, heavy, 1);
  test_threads();
  test_quadrature();
  test_sum();
  return check_done();
}
