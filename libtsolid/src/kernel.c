/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Energies of the Jacobian by sum factorisation.
 *
 * Per element: Bezier net of w P -> derivatives at the points (three contractions, each of which
 * turns the slowest index into the fastest, so that after three of them the order is the old one)
 * -> x_a = X_a / W - X W_a / W^2 -> density -> the same steps transposed. Elements are independent
 * and run in parallel; the sums over elements are taken afterwards in a fixed order. */
#include "kernel.h"
#include "bernstein.h"
#include "net.h"
#include "quadrature.h"

#ifdef _OPENMP
#include <omp.h>
#endif

static const char *const STAGE = "solid";

enum { GRID_POINTS = 7, MAX_LOBATTO = 6, ELEMENTS_PER_THREAD = 256, MAX_P = TSI_KERNEL_MAX_POINTS };

/* A sum of the functions that differs from 1 by less is 1, and round-off. */
static const double UNIT_SUM = 1e-12;

/* Basis of one degree at the points of the rule: row k holds B_k, or B_k', at all points. */
typedef struct basis_table {
  int n_points;
  double weight[MAX_P];
  double value[TSI_MAX_ORDER * MAX_P], slope[TSI_MAX_ORDER * MAX_P];
  double value_t[TSI_MAX_ORDER * MAX_P], slope_t[TSI_MAX_ORDER * MAX_P]; /* transposed */
} basis_table;

struct tsi_kernel {
  tsi_allocator allocator;
  const tsolid_space *space;
  int n_threads, n_free;
  const double *control; /* for the weights, column 3 */
  int rational;
  basis_table *table[TSI_MAX_ORDER];     /* by degree, where used */
  int max_points;                        /* of an element */
  size_t workspace;                      /* doubles per thread */
  double *work;                          /* n_threads * workspace */
  double *weighted;                      /* w P of all functions, rows of 3 */
  int outer_known;                       /* lateral_outer belongs to weighted's boundary layer */
  double *lateral_minus, *lateral_outer; /* nets of the lateral cells, rows of 3 */
  size_t *lateral_start;                 /* points */
  double *lateral_gradient;              /* per arm element, points of its lateral net, rows of 3 */
  size_t *element_lateral;               /* where element e's part of it starts */
  double *entry_gradient;                /* per entry, rows of 3 */
  double *energy;                        /* per element */
  double *w_value;          /* rational: 1/W and W_a/W per point: rows of 4 per element */
  size_t *point_start;      /* per element: first of its points in w_value */
  int *chain_start, *chain; /* arm elements by lateral cell */
};

/* ---- tables
 * ------------------------------------------------------------------------------------------ */

static void choose_points(int degree, tsi_rule rule, basis_table *table, double *x) {
  if (rule == TSI_GRID) {
    table->n_points = GRID_POINTS;
    for (int i = 0; i < GRID_POINTS; i++) {
      x[i] = (double)i / (GRID_POINTS - 1);
      table->weight[i] = 1.0 / GRID_POINTS;
    }
    return;
  }
  table->n_points = degree + 1;
  if (table->n_points > MAX_LOBATTO)
    table->n_points = MAX_LOBATTO;
  tsi_gauss_lobatto(table->n_points, x, table->weight);
}

static void fill_table(int degree, tsi_rule rule, basis_table *table) {
  double x[MAX_P], row[2 * TSI_MAX_ORDER];
  int n = degree + 1;
  choose_points(degree, rule, table, x);
  int m = table->n_points;
  for (int q = 0; q < m; q++) {
    tsi_bernstein_derivatives(degree, x[q], 1, row);
    for (int k = 0; k < n; k++) {
      table->value[k * m + q] = table->value_t[q * n + k] = row[k];
      table->slope[k * m + q] = table->slope_t[q * n + k] = row[n + k];
    }
  }
}

/* ---- contractions
 * --------------------------------------------------------------------------------------- */

/* out[r][q] (+)= sum_k in[k][r] b[k][q], k < n, r < rest, q < m. */
static inline void rotate_any(int n, int rest, int m, const double *restrict in,
                              const double *restrict b, double *restrict out) {
  for (int r = 0; r < rest; r++) {
    double *o = out + (ptrdiff_t)r * m;
    for (int q = 0; q < m; q++)
      o[q] = in[r] * b[q];
    for (int k = 1; k < n; k++) {
      double x = in[(ptrdiff_t)k * rest + r];
      for (int q = 0; q < m; q++)
        o[q] += x * b[(ptrdiff_t)k * m + q];
    }
  }
}

/* The same with constant bounds, which the compiler unrolls: nearly all elements are tricubic. */
static void rotate(int n, int rest, int m, const double *restrict in, const double *restrict b,
                   double *restrict out) {
  if (n == 4 && m == 4 && rest == 16)
    rotate_any(4, 16, 4, in, b, out);
  else
    rotate_any(n, rest, m, in, b, out);
}

static void add_to(double *restrict y, const double *restrict x, int n) {
  for (int i = 0; i < n; i++)
    y[i] += x[i];
}

/* What an element needs for its contractions. */
typedef struct shape {
  int n[3], m[3];
  int n_net, n_points, stride;
  const basis_table *table[3];
} shape;

static shape shape_of(const tsi_kernel *kernel, int element) {
  const tsi_element *e = &kernel->space->element[element];
  shape s;
  s.n_net = s.n_points = 1;
  for (int a = 0; a < 3; a++) {
    s.table[a] = kernel->table[e->degree[a]];
    s.n[a] = e->degree[a] + 1;
    s.m[a] = s.table[a]->n_points;
    s.n_net *= s.n[a];
    s.n_points *= s.m[a];
  }
  s.stride = kernel->max_points;
  return s;
}

void tsi_kernel_points(const tsi_kernel *kernel, int element, int n[3]) {
  for (int a = 0; a < 3; a++)
    n[a] = kernel->table[kernel->space->element[element].degree[a]]->n_points;
}

/* Values (if value is not NULL) and the three derivatives of one scalar net at the points.
 * The net is [k][j][i]; after the rotations the points are [q2][q1][q0] again. */
static void differentiate(const shape *s, const double *net, double *work, double *value,
                          double *d0, double *d1, double *d2) {
  int n0 = s->n[0], n1 = s->n[1], n2 = s->n[2], m0 = s->m[0], m1 = s->m[1], m2 = s->m[2];
  const basis_table *const *t = s->table;
  double *v = work, *z = v + n0 * n1 * m2, *vb = z + n0 * n1 * m2, *vd = vb + n0 * m2 * m1,
         *zb = vd + n0 * m2 * m1;
  rotate(n2, n1 * n0, m2, net, t[2]->value, v); /* [j][i][q2] */
  rotate(n2, n1 * n0, m2, net, t[2]->slope, z);
  rotate(n1, n0 * m2, m1, v, t[1]->value, vb); /* [i][q2][q1] */
  rotate(n1, n0 * m2, m1, v, t[1]->slope, vd);
  rotate(n1, n0 * m2, m1, z, t[1]->value, zb);
  if (value)
    rotate(n0, m2 * m1, m0, vb, t[0]->value, value); /* [q2][q1][q0] */
  rotate(n0, m2 * m1, m0, vb, t[0]->slope, d0);
  rotate(n0, m2 * m1, m0, vd, t[0]->value, d1);
  rotate(n0, m2 * m1, m0, zb, t[0]->value, d2);
}

/* The transpose: from gradients at the points to the gradient of the net. The points are contracted
 * in the order q2, q1, q0, so that again each step takes the slowest index. */
static void differentiate_transpose(const shape *s, const double *value, const double *d0,
                                    const double *d1, const double *d2, double *work, double *net) {
  int n0 = s->n[0], n1 = s->n[1], n2 = s->n[2], m0 = s->m[0], m1 = s->m[1], m2 = s->m[2];
  const basis_table *const *t = s->table;
  int plane = m1 * m0 * n2, line = m0 * n2 * n1;
  double *a = work, *b = a + plane, *c = b + plane, *u = c + plane, *w = u + line, *x = w + line;
  (void)m2;
  rotate(m2, m1 * m0, n2, d0, t[2]->value_t, a); /* [q1][q0][k] */
  rotate(m2, m1 * m0, n2, d1, t[2]->value_t, b);
  rotate(m2, m1 * m0, n2, d2, t[2]->slope_t, c);
  if (value) { /* joins d2's path, whose later factors are values too */
    rotate(m2, m1 * m0, n2, value, t[2]->value_t, x);
    add_to(c, x, plane);
  }
  rotate(m1, m0 * n2, n1, b, t[1]->slope_t, u); /* [q0][k][j] */
  rotate(m1, m0 * n2, n1, c, t[1]->value_t, w);
  add_to(u, w, line);
  rotate(m1, m0 * n2, n1, a, t[1]->value_t, w);
  rotate(m0, n2 * n1, n0, u, t[0]->value_t, net); /* [k][j][i] */
  rotate(m0, n2 * n1, n0, w, t[0]->slope_t, x);
  add_to(net, x, s->n_net);
}

/* ---- one element
 * ------------------------------------------------------------------------------------------ */

static void point_weights(const shape *s, double *weight) {
  for (int k = 0; k < s->m[2]; k++)
    for (int j = 0; j < s->m[1]; j++)
      for (int i = 0; i < s->m[0]; i++)
        *weight++ = s->table[0]->weight[i] * s->table[1]->weight[j] * s->table[2]->weight[k];
}

/* Quotient rule at the points, in place: j = X_a / W - X W_a / W^2 per component. */
static void divide_by_weight(const shape *s, const double *w, const double *value, double *j0,
                             double *j1, double *j2) {
  for (int q = 0; q < s->n_points; q++) {
    const double *p = w + 4 * q; /* 1/W, W_0/W, W_1/W, W_2/W */
    double x = value[q];
    j0[q] = (j0[q] - x * p[1]) * p[0];
    j1[q] = (j1[q] - x * p[2]) * p[0];
    j2[q] = (j2[q] - x * p[3]) * p[0];
  }
}

static void divide_by_weight_transpose(const shape *s, const double *w, double *value, double *g0,
                                       double *g1, double *g2) {
  for (int q = 0; q < s->n_points; q++) {
    const double *p = w + 4 * q;
    g0[q] *= p[0];
    g1[q] *= p[0];
    g2[q] *= p[0];
    value[q] = -(g0[q] * p[1] + g1[q] * p[2] + g2[q] * p[3]);
  }
}

static void element_energy(const tsi_kernel *kernel, int e, tsi_density density, const void *data,
                           double *work, int with_gradient) {
  const tsolid_space *space = kernel->space;
  shape s = shape_of(kernel, e);
  size_t stride = (size_t)s.stride;
  double *j = work, *g = j + 9 * stride, *value = g + 9 * stride, *weight = value + 3 * stride;
  double *net = weight + stride, *scalar = net + 3 * s.n_net, *scratch = scalar + s.n_net;
  int lateral = space->element[e].lateral;
  const double *minus = NULL, *outer = NULL;
  if (lateral >= 0) {
    minus = kernel->lateral_minus + 3 * kernel->lateral_start[lateral];
    outer = kernel->lateral_outer + 3 * kernel->lateral_start[lateral];
  }
  const double *w = kernel->rational ? kernel->w_value + 4 * kernel->point_start[e] : NULL;
  tsi_element_net_from(space, kernel->weighted, 3, minus, outer, e, net);
  for (int c = 0; c < 3; c++) {
    double *jc = j + 3 * (size_t)c * stride, *vc = w ? value + (size_t)c * stride : NULL;
    for (int i = 0; i < s.n_net; i++)
      scalar[i] = net[3 * i + c];
    differentiate(&s, scalar, scratch, vc, jc, jc + stride, jc + 2 * stride);
    if (w)
      divide_by_weight(&s, w, vc, jc, jc + stride, jc + 2 * stride);
  }
  point_weights(&s, weight);
  kernel->energy[e] = 0.0;
  density(data, e, s.n_points, s.stride, weight, j, &kernel->energy[e], g);
  if (!with_gradient)
    return;
  for (int c = 0; c < 3; c++) {
    double *gc = g + 3 * (size_t)c * stride, *vc = w ? value + (size_t)c * stride : NULL;
    if (w)
      divide_by_weight_transpose(&s, w, vc, gc, gc + stride, gc + 2 * stride);
    differentiate_transpose(&s, vc, gc, gc + stride, gc + 2 * stride, scratch, scalar);
    for (int i = 0; i < s.n_net; i++)
      net[3 * i + c] = scalar[i];
  }
  tsi_element_net_transpose(space, 3, e, net, kernel->entry_gradient + 3 * space->inner_start[e],
                            lateral >= 0 ? kernel->lateral_gradient + 3 * kernel->element_lateral[e]
                                         : NULL);
}

/* ---- sums over elements
 * ------------------------------------------------------------------------------------ */

static void gather_inner(const tsi_kernel *kernel, const unsigned char *active, double *gradient) {
  const tsolid_space *space = kernel->space;
#pragma omp parallel for schedule(static) num_threads(kernel->n_threads)
  for (int f = 0; f < space->n_inner; f++) {
    double sum[3] = {0.0, 0.0, 0.0}, w = kernel->control[4 * (size_t)f + 3];
    for (size_t i = space->use_start[f]; i < space->use_start[f + 1]; i++) {
      if (active && !active[space->use_element[i]])
        continue;
      const double *g = kernel->entry_gradient + 3 * space->use_entry[i];
      for (int c = 0; c < 3; c++)
        sum[c] += g[c];
    }
    for (int c = 0; c < 3; c++)
      gradient[3 * (size_t)f + (size_t)c] = w * sum[c];
  }
}

/* Per lateral cell: sum over its elements, then to the surface functions of layer R-. */
static void gather_lateral(const tsi_kernel *kernel, const unsigned char *active,
                           double *gradient) {
  const tsolid_space *space = kernel->space;
  double sum[3 * TSI_MAX_ORDER * TSI_MAX_ORDER];
  double *minus = gradient + 3 * (size_t)space->n_inner;
  memset(minus, 0, 3 * (size_t)space->n_surface * sizeof *minus);
  for (int l = 0; l < space->n_laterals; l++) {
    const tsi_lateral *lateral = &space->lateral[l];
    int size = (lateral->degree[0] + 1) * (lateral->degree[1] + 1);
    memset(sum, 0, 3 * (size_t)size * sizeof *sum);
    for (int i = kernel->chain_start[l]; i < kernel->chain_start[l + 1]; i++)
      if (!active || active[kernel->chain[i]])
        add_to(sum, kernel->lateral_gradient + 3 * kernel->element_lateral[kernel->chain[i]],
               3 * size);
    const double *coefficient = space->lateral_coefficient + lateral->coefficient_first;
    for (int f = lateral->function_first; f < lateral->function_end; f++, coefficient += size) {
      double *target = minus + 3 * (size_t)space->lateral_function[f];
      double w = kernel->control[4 * (size_t)(space->n_inner + space->lateral_function[f]) + 3];
      for (int i = 0; i < size; i++)
        for (int c = 0; c < 3; c++)
          target[c] += w * coefficient[i] * sum[3 * i + c];
    }
  }
}

static void make_nets(tsi_kernel *kernel, const double *position) {
  const tsolid_space *space = kernel->space;
  int n = space->n_inner + 2 * space->n_surface;
  const double *minus = kernel->weighted + 3 * (size_t)space->n_inner;
  const double *outer = minus + 3 * (size_t)space->n_surface;
  int first_call = !kernel->outer_known;
  for (int f = 0; f < n; f++)
    for (int c = 0; c < 3; c++) {
      double x = kernel->control[4 * (size_t)f + 3] * position[3 * f + c];
      kernel->outer_known &= f < kernel->n_free || kernel->weighted[3 * f + c] == x;
      kernel->weighted[3 * f + c] = x;
    }
  int stale = first_call || !kernel->outer_known; /* the boundary layer hardly ever moves */
#pragma omp parallel for schedule(static) num_threads(kernel->n_threads)
  for (int l = 0; l < space->n_laterals; l++) {
    size_t at = 3 * kernel->lateral_start[l];
    tsi_lateral_net(space, minus, 3, l, kernel->lateral_minus + at);
    if (stale)
      tsi_lateral_net(space, outer, 3, l, kernel->lateral_outer + at);
  }
  kernel->outer_known = 1;
}

static int thread_number(void) {
#ifdef _OPENMP
  return omp_get_thread_num();
#else
  return 0;
#endif
}

void tsi_kernel_energy(tsi_kernel *kernel, const double *position, tsi_density density,
                       const void *data, const unsigned char *active, double *energy,
                       double *gradient, double *element_energies) {
  int n = kernel->space->n_elements;
  make_nets(kernel, position);
#pragma omp parallel for schedule(dynamic, 16) num_threads(kernel->n_threads)
  for (int e = 0; e < n; e++) {
    kernel->energy[e] = 0.0;
    if (!active || active[e])
      element_energy(kernel, e, density, data,
                     kernel->work + (size_t)thread_number() * kernel->workspace, gradient != NULL);
  }
  *energy = 0.0;
  for (int e = 0; e < n; e++) {
    *energy += kernel->energy[e];
    if (element_energies)
      element_energies[e] = kernel->energy[e];
  }
  if (gradient) {
    gather_inner(kernel, active, gradient);
    gather_lateral(kernel, active, gradient);
  }
}

/* ---- creation
 * -------------------------------------------------------------------------------------------------
 */

static int make_tables(tsi_kernel *k, tsi_rule rule) {
  for (int e = 0; e < k->space->n_elements; e++)
    for (int a = 0; a < 3; a++) {
      int degree = k->space->element[e].degree[a];
      if (k->table[degree])
        continue;
      k->table[degree] = tsi_new(&k->allocator, 1, sizeof(basis_table));
      if (!k->table[degree])
        return 0;
      fill_table(degree, rule, k->table[degree]);
    }
  return 1;
}

/* Largest sizes, and where each element's parts of the shared arrays start. */
static int lay_out(tsi_kernel *k) {
  const tsolid_space *space = k->space;
  size_t n = (size_t)space->n_elements, n_net = 0, span = 0, points = 0, lateral = 0;
  k->point_start = tsi_new(&k->allocator, n + 1, sizeof(size_t));
  k->element_lateral = tsi_new(&k->allocator, n + 1, sizeof(size_t));
  k->lateral_start = tsi_new(&k->allocator, (size_t)space->n_laterals + 1, sizeof(size_t));
  k->chain_start = tsi_new(&k->allocator, (size_t)space->n_laterals + 2, sizeof(int));
  k->chain = tsi_new(&k->allocator, n, sizeof(int));
  if (!k->point_start || !k->element_lateral || !k->lateral_start || !k->chain_start || !k->chain)
    return 0;
  for (int l = 0; l < space->n_laterals; l++)
    k->lateral_start[l + 1] = k->lateral_start[l] + (size_t)(space->lateral[l].degree[0] + 1) *
                                                        (size_t)(space->lateral[l].degree[1] + 1);
  for (size_t e = 0; e < n; e++) {
    shape s = shape_of(k, (int)e);
    int l = space->element[e].lateral;
    size_t longest = 1;
    for (int a = 0; a < 3; a++)
      longest *= (size_t)(s.n[a] > s.m[a] ? s.n[a] : s.m[a]);
    k->point_start[e] = points;
    k->element_lateral[e] = lateral;
    points += (size_t)s.n_points;
    if (l >= 0) {
      lateral += k->lateral_start[l + 1] - k->lateral_start[l];
      k->chain_start[l + 2]++;
    }
    n_net = (size_t)s.n_net > n_net ? (size_t)s.n_net : n_net;
    span = longest > span ? longest : span;
    k->max_points = s.n_points > k->max_points ? s.n_points : k->max_points;
  }
  k->point_start[n] = points;
  k->element_lateral[n] = lateral;
  for (int l = 0; l < space->n_laterals; l++)
    k->chain_start[l + 2] += k->chain_start[l + 1];
  for (int e = 0; e < space->n_elements; e++)
    if (space->element[e].lateral >= 0)
      k->chain[k->chain_start[space->element[e].lateral + 1]++] = e;
  k->workspace = 22 * (size_t)k->max_points + 4 * n_net + 6 * span + 64;
  return 1;
}

static int make_room(tsi_kernel *k) {
  const tsolid_space *space = k->space;
  size_t n_all = (size_t)space->n_inner + 2 * (size_t)space->n_surface;
  size_t n_lateral = 3 * k->lateral_start[space->n_laterals];
  k->work = tsi_new(&k->allocator, (size_t)k->n_threads * k->workspace, sizeof(double));
  k->weighted = tsi_new(&k->allocator, n_all, 3 * sizeof(double));
  k->lateral_minus = tsi_new(&k->allocator, n_lateral, sizeof(double));
  k->lateral_outer = tsi_new(&k->allocator, n_lateral, sizeof(double));
  k->lateral_gradient =
      tsi_new(&k->allocator, 3 * k->element_lateral[space->n_elements], sizeof(double));
  k->entry_gradient =
      tsi_new(&k->allocator, 3 * space->inner_start[space->n_elements], sizeof(double));
  k->energy = tsi_new(&k->allocator, (size_t)space->n_elements, sizeof(double));
  return k->work && k->weighted && k->lateral_minus && k->lateral_outer && k->lateral_gradient &&
         k->entry_gradient && k->energy;
}

/* W = 1 up to round-off: all weights are 1, and the functions sum to 1. */
static int is_polynomial(const tsi_kernel *k, const double *weight, size_t n) {
  for (size_t f = 0; f < n; f++)
    if (weight[f] != 1.0)
      return 0;
  for (int e = 0; e < k->space->n_elements; e++) {
    shape s = shape_of(k, e);
    tsi_element_net(k->space, weight, 1, e, k->work);
    for (int i = 0; i < s.n_net; i++)
      if (fabs(k->work[i] - 1.0) > UNIT_SUM)
        return 0;
  }
  return 1;
}

/* 1/W and W_a/W at all points, once: the weights do not move. */
static int tabulate_weights(tsi_kernel *k) {
  const tsolid_space *space = k->space;
  size_t n_all = (size_t)space->n_inner + 2 * (size_t)space->n_surface;
  double *weight = tsi_new(&k->allocator, n_all, sizeof *weight);
  for (size_t f = 0; weight && f < n_all; f++)
    weight[f] = k->control[4 * f + 3];
  k->rational = weight && !is_polynomial(k, weight, n_all);
  if (!k->rational) {
    tsi_delete(&k->allocator, weight);
    return weight != NULL;
  }
  k->w_value = tsi_new(&k->allocator, 4 * k->point_start[space->n_elements], sizeof(double));
  for (int e = 0; weight && k->w_value && e < space->n_elements; e++) {
    shape s = shape_of(k, e);
    double *value = k->work, *d = value + k->max_points, *net = d + 3 * (size_t)k->max_points;
    double *at = k->w_value + 4 * k->point_start[e];
    tsi_element_net(space, weight, 1, e, net);
    differentiate(&s, net, net + s.n_net, value, d, d + k->max_points, d + 2 * k->max_points);
    for (int q = 0; q < s.n_points; q++, at += 4) {
      at[0] = 1.0 / value[q];
      for (int a = 0; a < 3; a++)
        at[1 + a] = d[(size_t)a * (size_t)k->max_points + (size_t)q] / value[q];
    }
  }
  int complete = weight && k->w_value;
  tsi_delete(&k->allocator, weight);
  return complete;
}

tsolid_status tsi_kernel_create(tsolid_context *context, const tsolid_space *space,
                                const double *control, tsi_rule rule, tsi_kernel **kernel) {
  *kernel = NULL;
  tsi_kernel *k = tsi_new(&context->allocator, 1, sizeof *k);
  if (!k)
    return tsi_no_memory(context, STAGE);
  k->allocator = context->allocator;
  k->space = space;
  k->n_threads =
      space->n_elements / ELEMENTS_PER_THREAD + 1; /* a small part is done sooner alone */
  if (k->n_threads > context->n_threads)
    k->n_threads = context->n_threads;
  k->n_free = space->n_inner + space->n_surface;
  k->control = control;
  if (!make_tables(k, rule) || !lay_out(k) || !make_room(k) || !tabulate_weights(k)) {
    tsi_kernel_free(k);
    return tsi_no_memory(context, STAGE);
  }
  *kernel = k;
  return TSOLID_OK;
}

void tsi_kernel_free(tsi_kernel *kernel) {
  if (!kernel)
    return;
  tsi_allocator allocator = kernel->allocator;
  for (int d = 0; d < TSI_MAX_ORDER; d++)
    tsi_delete(&allocator, kernel->table[d]);
  void *owned[] = {kernel->work,
                   kernel->weighted,
                   kernel->lateral_minus,
                   kernel->lateral_outer,
                   kernel->lateral_start,
                   kernel->lateral_gradient,
                   kernel->element_lateral,
                   kernel->entry_gradient,
                   kernel->energy,
                   kernel->w_value,
                   kernel->point_start,
                   kernel->chain_start,
                   kernel->chain};
  for (size_t i = 0; i < sizeof owned / sizeof *owned; i++)
    tsi_delete(&allocator, owned[i]);
  tsi_delete(&allocator, kernel);
}
