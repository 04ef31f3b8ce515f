/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Bezier nets of elements.
 *
 *   net[i + n0 (j + n1 k)] = sum_f a_f[i] b_f[j] c_f[k] P_f  +  surface layers (arms)
 *
 * Entries are sorted by their rows of axis 2, then 1, then 0, so the sum factorises: over equal
 * (c, b) first, over equal c next. An arm's inner part is summed as a tricubic and raised to the
 * arm's lateral degrees. All coefficients are >= 0. */
#include "net.h"
#include "bernstein.h"

enum {
  N = TSI_INNER_DEGREE + 1,
  MAX_C = TSI_NET_COMPONENTS,
  MAX_LATERAL = TSI_MAX_ORDER * TSI_MAX_ORDER
};

/* y += a x, rows of n. */
static inline void add_scaled(double *y, double a, const double *x, int n) {
  for (int i = 0; i < n; i++)
    y[i] += a * x[i];
}

/* The tricubic part of the inner functions, 64 rows. */
static void inner_net(const tsolid_space *space, const double *control, int nc, int element,
                      double *net) {
  size_t at = space->inner_start[element], end = space->inner_start[element + 1];
  const int(*row)[3] = (const int(*)[3])space->inner_row;
  memset(net, 0, (size_t)(N * N * N * nc) * sizeof *net);
  while (at < end) {
    double plane[N * N * MAX_C] = {0};
    int r2 = row[at][2];
    while (at < end && row[at][2] == r2) {
      double line[N * MAX_C] = {0};
      int r1 = row[at][1];
      for (; at < end && row[at][2] == r2 && row[at][1] == r1; at++) {
        const double *a = space->row + 4 * (size_t)row[at][0];
        const double *p = control + (size_t)space->inner_function[at] * (size_t)nc;
        for (int i = 0; i < N; i++)
          add_scaled(line + i * nc, a[i], p, nc);
      }
      const double *b = space->row + 4 * (size_t)r1;
      for (int j = 0; j < N; j++)
        add_scaled(plane + j * N * nc, b[j], line, N * nc);
    }
    const double *c = space->row + 4 * (size_t)r2;
    for (int k = 0; k < N; k++)
      add_scaled(net + k * N * N * nc, c[k], plane, N * N * nc);
  }
}

void tsi_lateral_net(const tsolid_space *space, const double *layer, int n_components, int lateral,
                     double *net) {
  const tsi_lateral *l = &space->lateral[lateral];
  int size = (l->degree[0] + 1) * (l->degree[1] + 1);
  memset(net, 0, (size_t)size * (size_t)n_components * sizeof *net);
  const double *coefficient = space->lateral_coefficient + l->coefficient_first;
  for (int f = l->function_first; f < l->function_end; f++, coefficient += size) {
    const double *p = layer + (size_t)space->lateral_function[f] * (size_t)n_components;
    for (int i = 0; i < size; i++)
      add_scaled(net + i * n_components, coefficient[i], p, n_components);
  }
}

/* Strides, in points of the element's net, of the lateral directions and of the radial one. */
typedef struct arm_layout {
  int n_s, n_t, stride_s, stride_t, stride_r;
} arm_layout;

static arm_layout layout_of(const tsi_element *e) {
  int side = e->block - 1,
      stride[3] = {1, e->degree[0] + 1, (e->degree[0] + 1) * (e->degree[1] + 1)};
  int s = tsi_side_s(side), t = tsi_side_t(side);
  return (arm_layout){e->degree[s] + 1, e->degree[t] + 1, stride[s], stride[t],
                      stride[tsi_side_axis(side)]};
}

/* net += radial row x lateral net. */
static void add_layer(const arm_layout *g, const double *radial, const double *lateral, int nc,
                      double *net) {
  for (int k = 0; k < N; k++)
    for (int t = 0; t < g->n_t; t++)
      for (int s = 0; s < g->n_s; s++)
        add_scaled(net + (s * g->stride_s + t * g->stride_t + k * g->stride_r) * nc, radial[k],
                   lateral + (s + t * g->n_s) * nc, nc);
}

/* Along one axis: out[r][i] = sum_j m[i][j] in[r][j], or transposed, for rows of `inner` values
 * inside and `outer` copies outside; m has (to + 1) x 4 entries. */
static void raise_axis(const double *m, int to, int transpose, int inner, int outer,
                       const double *in, double *out) {
  int n_in = transpose ? to + 1 : N, n_out = transpose ? N : to + 1;
  memset(out, 0, (size_t)(n_out * inner * outer) * sizeof *out);
  for (int r = 0; r < outer; r++)
    for (int i = 0; i < n_out; i++)
      for (int j = 0; j < n_in; j++)
        add_scaled(out + (r * n_out + i) * inner, transpose ? m[j * N + i] : m[i * N + j],
                   in + (r * n_in + j) * inner, inner);
}

/* Raises the tricubic part of an arm along its two lateral axes, or gathers, transposed, from the
 * wide net to the tricubic one. `from` is left as it was; work: two nets. */
static void raise_net(const tsolid_space *space, const tsi_element *e, int nc, int transpose,
                      const double *from, double *target) {
  enum { MAX_NET = TSI_MAX_ORDER * TSI_MAX_ORDER * N * MAX_C };
  double work[2][MAX_NET];
  const double *in = from;
  int n[3], last = -1, which = 0;
  for (int a = 0; a < 3; a++) {
    n[a] = transpose ? e->degree[a] + 1 : N;
    if (e->degree[a] != TSI_INNER_DEGREE)
      last = a;
  }
  for (int a = 0; a <= last; a++) {
    if (e->degree[a] == TSI_INNER_DEGREE)
      continue;
    int inner = nc, outer = 1;
    for (int b = 0; b < 3; b++)
      if (b != a)
        *(b < a ? &inner : &outer) *= n[b];
    double *out = a == last ? target : work[which];
    raise_axis(space->raise[e->degree[a]], e->degree[a], transpose, inner, outer, in, out);
    n[a] = transpose ? N : e->degree[a] + 1;
    in = out;
    which = 1 - which;
  }
}

static int is_cubic(const tsi_element *e) {
  return e->degree[0] == TSI_INNER_DEGREE && e->degree[1] == TSI_INNER_DEGREE &&
         e->degree[2] == TSI_INNER_DEGREE;
}

void tsi_element_net_from(const tsolid_space *space, const double *control, int n_components,
                          const double *lateral_minus, const double *lateral_outer, int element,
                          double *net) {
  const tsi_element *e = &space->element[element];
  if (is_cubic(e)) {
    inner_net(space, control, n_components, element, net);
  } else {
    double cubic[N * N * N * MAX_C];
    inner_net(space, control, n_components, element, cubic);
    raise_net(space, e, n_components, 0, cubic, net);
  }
  if (e->block == 0)
    return;
  arm_layout g = layout_of(e);
  if (e->radial[0] >= 0)
    add_layer(&g, space->row + 4 * (size_t)e->radial[0], lateral_minus, n_components, net);
  if (e->radial[1] >= 0)
    add_layer(&g, space->row + 4 * (size_t)e->radial[1], lateral_outer, n_components, net);
}

void tsi_element_net(const tsolid_space *space, const double *control, int n_components,
                     int element, double *net) {
  const tsi_element *e = &space->element[element];
  double minus[MAX_LATERAL * MAX_C], outer[MAX_LATERAL * MAX_C];
  size_t nc = (size_t)n_components, first = (size_t)space->n_inner * nc;
  if (e->block > 0) {
    tsi_lateral_net(space, control + first, n_components, e->lateral, minus);
    tsi_lateral_net(space, control + first + (size_t)space->n_surface * nc, n_components,
                    e->lateral, outer);
  }
  tsi_element_net_from(space, control, n_components, minus, outer, element, net);
}

/* ---- transpose
 * -------------------------------------------------------------------------------------- */

/* target[i] = sum_k row[k] from[k * n + i], i < n. */
static inline void contract(const double *row, const double *from, int n, double *target) {
  for (int i = 0; i < n; i++)
    target[i] = row[0] * from[i];
  for (int k = 1; k < N; k++)
    add_scaled(target, row[k], from + k * n, n);
}

static void inner_net_transpose(const tsolid_space *space, int nc, int element, const double *net,
                                double *entry) {
  size_t first = space->inner_start[element], end = space->inner_start[element + 1], at = first;
  const int(*row)[3] = (const int(*)[3])space->inner_row;
  while (at < end) {
    double plane[N * N * MAX_C];
    int r2 = row[at][2];
    contract(space->row + 4 * (size_t)r2, net, N * N * nc, plane);
    while (at < end && row[at][2] == r2) {
      double line[N * MAX_C];
      int r1 = row[at][1];
      contract(space->row + 4 * (size_t)r1, plane, N * nc, line);
      for (; at < end && row[at][2] == r2 && row[at][1] == r1; at++)
        contract(space->row + 4 * (size_t)row[at][0], line, nc, entry + (at - first) * (size_t)nc);
    }
  }
}

static void layer_transpose(const arm_layout *g, const double *radial, int nc, const double *net,
                            double *lateral) {
  memset(lateral, 0, (size_t)(g->n_s * g->n_t * nc) * sizeof *lateral);
  for (int k = 0; k < N; k++)
    for (int t = 0; t < g->n_t; t++)
      for (int s = 0; s < g->n_s; s++)
        add_scaled(lateral + (s + t * g->n_s) * nc, radial[k],
                   net + (s * g->stride_s + t * g->stride_t + k * g->stride_r) * nc, nc);
}

void tsi_element_net_transpose(const tsolid_space *space, int n_components, int element,
                               const double *net_gradient, double *entry_gradient,
                               double *lateral_gradient) {
  const tsi_element *e = &space->element[element];
  if (is_cubic(e)) {
    inner_net_transpose(space, n_components, element, net_gradient, entry_gradient);
  } else {
    double cubic[N * N * N * MAX_C];
    raise_net(space, e, n_components, 1, net_gradient, cubic);
    inner_net_transpose(space, n_components, element, cubic, entry_gradient);
  }
  if (e->block == 0)
    return;
  arm_layout g = layout_of(e);
  static const double none[N];
  layer_transpose(&g, e->radial[0] >= 0 ? space->row + 4 * (size_t)e->radial[0] : none,
                  n_components, net_gradient, lateral_gradient);
}
