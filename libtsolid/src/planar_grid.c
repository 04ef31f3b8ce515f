/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Derivatives of a planar patch on a tensor grid of points, m Gauss-Lobatto points in each knot
 * span of either direction, and sums over them with their gradient by the control points.
 *
 * With fixed weights the map is linear in the control points. Per row of points: A = sum w P N M
 * and its derivatives by sum factorisation, first along u for all rows of control points, then
 * along v; x_d = (A_d - A W_d / W) / W. The gradient runs the same way back, transposed.
 *
 * Functions of a span are taken from inside it, so that the ends of spans are seen from both sides,
 * where derivatives jump as well. */
#include "planar_grid.h"

#include "bernstein.h"
#include "quadrature.h"

static int allocate_line(tsi_arena *arena, int n_spans, int m, int order, tsi_grid_line *line) {
  size_t n = (size_t)n_spans * (size_t)m;
  line->m = m;
  line->n_spans = n_spans;
  line->n_points = n_spans * m;
  line->order = order;
  line->first = tsi_arena_new(arena, n, sizeof *line->first);
  line->value = tsi_arena_new(arena, n * (size_t)order, sizeof *line->value);
  line->slope = tsi_arena_new(arena, n * (size_t)order, sizeof *line->slope);
  line->weight = tsi_arena_new(arena, n, sizeof *line->weight);
  line->u = tsi_arena_new(arena, n, sizeof *line->u);
  line->target = tsi_arena_new(arena, n, sizeof *line->target);
  return line->first && line->value && line->slope && line->weight && line->u && line->target;
}

static int count_spans(int degree, int n, const double *knots) {
  int count = 0;
  for (int s = degree; s < n; s++)
    count += knots[s] < knots[s + 1];
  return count;
}

static int make_line(tsi_arena *arena, const tsi_planar *p, int d, int m, tsi_grid_line *line) {
  int q = p->degree[d], at = 0;
  const double *knots = p->knots[d];
  double node[TSI_MAX_GAUSS], weight[TSI_MAX_GAUSS], function[TSI_MAX_ORDER];
  double basis[2 * TSI_MAX_ORDER];
  if (!allocate_line(arena, count_spans(q, p->n[d], knots), m, q + 1, line))
    return 0;
  tsi_gauss_lobatto(m, node, weight);
  for (int s = q; s < p->n[d]; s++) {
    double low = knots[s], width = knots[s + 1] - low;
    if (!(width > 0.0))
      continue;
    for (int i = 0; i <= q; i++) {
      tsi_bspline_bernstein(q, knots + s - q + i, low, knots[s + 1], function);
      for (int k = 0; k < m; k++) {
        double value = 0.0, slope = 0.0;
        tsi_bernstein_derivatives(q, node[k], 1, basis);
        for (int b = 0; b <= q; b++) {
          value += function[b] * basis[b];
          slope += function[b] * basis[q + 1 + b];
        }
        line->value[(at + k) * (q + 1) + i] = value;
        line->slope[(at + k) * (q + 1) + i] = slope / width;
      }
    }
    for (int k = 0; k < m; k++, at++) {
      line->first[at] = s - q;
      line->weight[at] = weight[k] / line->n_spans;
      line->u[at] = low + node[k] * width;
    }
  }
  return 1;
}

/* Contracts rows of control values along u: out[point + n_points * j]. */
static void sweep_along(const tsi_grid_line *line, const double *table, int n, int n_rows,
                        const double *in, int stride, const double *weight, double *out) {
  int order = line->order;
  for (int j = 0; j < n_rows; j++)
    for (int q = 0; q < line->n_points; q++) {
      const double *f = table + (ptrdiff_t)q * order;
      size_t row = (size_t)line->first[q] + (size_t)n * (size_t)j;
      double sum = 0.0;
      for (int i = 0; i < order; i++)
        sum += f[i] * weight[row + (size_t)i] * in[(row + (size_t)i) * (size_t)stride];
      out[(size_t)q + (size_t)line->n_points * (size_t)j] = sum;
    }
}

/* One row of points: sum of order rows of `in` by the entries of f. */
static void mix_rows(const tsi_grid_line *across, const double *table, int q, int n_points,
                     const double *in, double *restrict out) {
  const double *f = table + (ptrdiff_t)q * across->order;
  const double *restrict from = in + (size_t)across->first[q] * (size_t)n_points;
  memset(out, 0, (size_t)n_points * sizeof *out);
  for (int j = 0; j < across->order; j++, from += n_points)
    for (int k = 0; k < n_points; k++)
      out[k] += f[j] * from[k];
}

static void add_rows(const tsi_grid_line *across, const double *table, int q, int n_points,
                     const double *restrict in, double *out) {
  const double *f = table + (ptrdiff_t)q * across->order;
  double *restrict to = out + (size_t)across->first[q] * (size_t)n_points;
  for (int j = 0; j < across->order; j++, to += n_points)
    for (int k = 0; k < n_points; k++)
      to[k] += f[j] * in[k];
}

/* W and its derivatives at all points, by the same sweeps as positions. */
static void fill_weights(tsi_grid *g) {
  const tsi_planar *p = g->patch;
  const double one = 1.0;
  size_t n = (size_t)p->n[0] * (size_t)p->n[1];
  int n_u = g->line[0].n_points;
  double *value = g->stage[0], *slope = g->stage[1], *ones = g->ones;
  for (size_t i = 0; i < n; i++)
    ones[i] = one;
  sweep_along(&g->line[0], g->line[0].value, p->n[0], p->n[1], ones, 1, p->weight, value);
  sweep_along(&g->line[0], g->line[0].slope, p->n[0], p->n[1], ones, 1, p->weight, slope);
  for (int q = 0; q < g->line[1].n_points; q++) {
    size_t row = (size_t)q * (size_t)n_u;
    mix_rows(&g->line[1], g->line[1].value, q, n_u, value, g->w[0] + row);
    mix_rows(&g->line[1], g->line[1].value, q, n_u, slope, g->w[1] + row);
    mix_rows(&g->line[1], g->line[1].slope, q, n_u, value, g->w[2] + row);
  }
}

int tsi_grid_create(tsi_arena *arena, const tsi_planar *patch, int m_u, int m_v, tsi_grid *g) {
  const int m[2] = {m_u, m_v};
  *g = (tsi_grid){.patch = patch};
  for (int d = 0; d < 2; d++)
    if (!make_line(arena, patch, d, m[d], &g->line[d]))
      return 0;
  size_t n_u = (size_t)g->line[0].n_points, n_v = (size_t)g->line[1].n_points;
  g->ones = tsi_arena_new(arena, (size_t)patch->n[0] * (size_t)patch->n[1], sizeof(double));
  int ok = g->ones != NULL;
  for (int k = 0; ok && k < 4; k++) {
    g->stage[k] = tsi_arena_new(arena, n_u * (size_t)patch->n[1], sizeof(double));
    g->back[k] = tsi_arena_new(arena, n_u * (size_t)patch->n[1], sizeof(double));
    ok = g->stage[k] && g->back[k];
  }
  for (int k = 0; ok && k < 3; k++)
    ok = (g->w[k] = tsi_arena_new(arena, n_u * n_v, sizeof(double))) != NULL;
  for (int k = 0; ok && k < 6; k++)
    ok = (g->row[k] = tsi_arena_new(arena, n_u, sizeof(double))) != NULL;
  if (ok)
    fill_weights(g);
  return ok;
}

/* row[0..1] = A, row[2..3] becomes x_u, row[4..5] x_v at the row q of points. */
static void differentiate_row(tsi_grid *g, int q) {
  int n_u = g->line[0].n_points;
  const tsi_grid_line *v = &g->line[1];
  size_t at = (size_t)q * (size_t)n_u;
  const double *w = g->w[0] + at, *w_u = g->w[1] + at, *w_v = g->w[2] + at;
  for (int c = 0; c < 2; c++) {
    double *restrict a = g->row[c], *restrict a_u = g->row[2 + c], *restrict a_v = g->row[4 + c];
    mix_rows(v, v->value, q, n_u, g->stage[c], a);
    mix_rows(v, v->value, q, n_u, g->stage[2 + c], a_u);
    mix_rows(v, v->slope, q, n_u, g->stage[c], a_v);
    for (int k = 0; k < n_u; k++) {
      double x = a[k] / w[k];
      a_u[k] = (a_u[k] - x * w_u[k]) / w[k];
      a_v[k] = (a_v[k] - x * w_v[k]) / w[k];
    }
  }
}

/* Gradients by x_u and x_v in row[2..5] are added to those by the control rows. */
static void collect_row(tsi_grid *g, int q) {
  int n_u = g->line[0].n_points;
  const tsi_grid_line *v = &g->line[1];
  size_t at = (size_t)q * (size_t)n_u;
  const double *w = g->w[0] + at, *w_u = g->w[1] + at, *w_v = g->w[2] + at;
  for (int c = 0; c < 2; c++) {
    double *restrict a = g->row[c], *restrict a_u = g->row[2 + c], *restrict a_v = g->row[4 + c];
    for (int k = 0; k < n_u; k++) {
      a_u[k] /= w[k];
      a_v[k] /= w[k];
      a[k] = -(a_u[k] * w_u[k] + a_v[k] * w_v[k]) / w[k];
    }
    add_rows(v, v->value, q, n_u, a, g->back[c]);
    add_rows(v, v->value, q, n_u, a_u, g->back[2 + c]);
    add_rows(v, v->slope, q, n_u, a_v, g->back[c]);
  }
}

/* From gradients at points of the rows of control points to those by the control points. */
static void collect_gradient(const tsi_grid *g, double *gradient) {
  const tsi_planar *p = g->patch;
  const tsi_grid_line *u = &g->line[0];
  memset(gradient, 0, 2 * (size_t)p->n[0] * (size_t)p->n[1] * sizeof *gradient);
  for (int j = 0; j < p->n[1]; j++)
    for (int q = 0; q < u->n_points; q++) {
      const double *value = u->value + (ptrdiff_t)q * u->order;
      const double *slope = u->slope + (ptrdiff_t)q * u->order;
      size_t row = (size_t)u->first[q] + (size_t)p->n[0] * (size_t)j;
      size_t at = (size_t)q + (size_t)u->n_points * (size_t)j;
      for (int i = 0; i < u->order; i++, row++)
        for (size_t c = 0; c < 2; c++)
          gradient[2 * row + c] +=
              p->weight[row] * (value[i] * g->back[c][at] + slope[i] * g->back[2 + c][at]);
    }
}

double tsi_grid_sum(tsi_grid *g, const double *point, tsi_grid_density density, void *data,
                    double *gradient) {
  const tsi_planar *p = g->patch;
  const tsi_grid_line *u = &g->line[0];
  double sum = 0.0;
  for (int c = 0; c < 2; c++) {
    sweep_along(u, u->value, p->n[0], p->n[1], point + c, 2, p->weight, g->stage[c]);
    sweep_along(u, u->slope, p->n[0], p->n[1], point + c, 2, p->weight, g->stage[2 + c]);
  }
  for (int k = 0; gradient && k < 4; k++)
    memset(g->back[k], 0, (size_t)u->n_points * (size_t)p->n[1] * sizeof(double));
  for (int q = 0; q < g->line[1].n_points; q++) {
    differentiate_row(g, q);
    sum += density(data, g, q, g->row + 2);
    if (gradient)
      collect_row(g, q);
  }
  if (gradient)
    collect_gradient(g, gradient);
  return sum;
}
