/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include "bspline.h"
#include "seams.h"

static const tsi_facet *facet_of(const tsi_shell *shell, int p) {
  return &shell->facet[shell->place[p]->facet];
}

/* ---- the list ----------------------------------------------------------------------------------
 */

/* See tsolid_placement for the order of flip and swap. */
int tsi_seam_border(const tsi_shell *shell, const tsi_seam *s, int which) {
  const tsi_place *place = shell->place[s->row[which].patch];
  int along = place->swap ? 1 - s->row[which].along : s->row[which].along;
  int end = s->row[which].end ^ place->flip[1 - along];
  return along == 0 ? (end ? 2 : 0) : (end ? 1 : 3);
}

static int inner_seams(const tsi_shell *shell, int side, tsi_seam *out) {
  int n_s = shell->n_strips[tsi_side_s(side)], n_t = shell->n_strips[tsi_side_t(side)], n = 0;
  for (int j = 0; j < n_t; j++)
    for (int i = 0; i < n_s; i++) {
      int p = shell->first[side] + i + n_s * j;
      if (i + 1 < n_s)
        out[n++] = (tsi_seam){{{p, 1, 1}, {p + 1, 1, 0}}, -1, side};
      if (j + 1 < n_t)
        out[n++] = (tsi_seam){{{p, 0, 1}, {p + n_s, 0, 0}}, -1, side};
    }
  return n;
}

static int isoline_seams(const tsi_shell *shell, int isoline, tsi_seam *out) {
  int axis = isoline / 4, end[2] = {isoline & 1, isoline >> 1 & 1};
  int other[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
  for (int strip = 0; strip < shell->n_strips[axis]; strip++) {
    tsi_seam s = {.isoline = isoline, .side = -1};
    for (int k = 0; k < 2; k++) {
      int side = 2 * other[k] + end[k], across = other[1 - k];
      int along = tsi_side_t(side) == axis, at = end[1 - k] ? shell->n_strips[across] - 1 : 0;
      int i = along ? at : strip, j = along ? strip : at;
      s.row[k].patch = shell->first[side] + i + shell->n_strips[tsi_side_s(side)] * j;
      s.row[k].along = along;
      s.row[k].end = end[1 - k];
    }
    out[strip] = s;
  }
  return shell->n_strips[axis];
}

tsi_seam *tsi_seams_list(tsi_arena *arena, const tsi_shell *shell, int *n) {
  tsi_seam *list = tsi_arena_new(arena, 2 * (size_t)shell->first[6], sizeof *list);
  *n = 0;
  for (int i = 0; list && i < 12; i++)
    *n += isoline_seams(shell, i, list + *n);
  for (int i = 0; list && i < 6; i++)
    *n += inner_seams(shell, i, list + *n);
  return list;
}

/* ---- rows -------------------------------------------------------------------------------------
 */

tsi_row tsi_seam_row(const tsi_shell *shell, const tsi_seam *s, int which) {
  int p = s->row[which].patch, along = s->row[which].along, end = s->row[which].end;
  const tsi_tspline *tspline = &shell->tspline[p];
  const tsi_patch *patch = &shell->patch[p];
  if (tspline->n) {
    const tsi_tspline_row *row = &tspline->row[along][end];
    return (tsi_row){.degree = tspline->degree[along],
                     .n = row->n,
                     .knots = row->knots,
                     .point = shell->control,
                     .at = row->point};
  }
  if (!patch->n[0])
    return (tsi_row){.n = 0};
  size_t n0 = (size_t)patch->n[0], fixed = end ? (size_t)patch->n[1 - along] - 1 : 0;
  return (tsi_row){.degree = patch->degree[along],
                   .n = patch->n[along],
                   .knots = patch->knots[along],
                   .point = patch->control + 4 * fixed * (along ? 1 : n0),
                   .step = along ? 4 * n0 : 4};
}

double *tsi_row_point(const tsi_row *row, int m) {
  return row->point + (row->at ? 4 * (size_t)row->at[m] : row->step * (size_t)m);
}

int tsi_seam_has_rows(const tsi_shell *shell, const tsi_seam *s) {
  return tsi_seam_row(shell, s, 0).n && tsi_seam_row(shell, s, 1).n;
}

double *tsi_seam_point(const tsi_shell *shell, const tsi_seam *s, int which, int m) {
  tsi_row row = tsi_seam_row(shell, s, which);
  return tsi_row_point(&row, m);
}

int tsi_seam_count(const tsi_shell *shell, const tsi_seam *s, int which) {
  return tsi_seam_row(shell, s, which).n;
}

int tsi_seam_corner(const tsi_seam *s, int which, int high) {
  int end = s->row[which].end;
  return s->row[which].along ? end + 2 * high : high + 2 * end;
}

void tsi_row_evaluate(const tsi_row *row, double t, double point[4], double *derivative) {
  double value[TSI_MAX_ORDER], slope[TSI_MAX_ORDER];
  int first =
      tsi_bspline_basis(row->degree, row->n, row->knots, t, value, derivative ? slope : NULL);
  memset(point, 0, 4 * sizeof *point);
  if (derivative)
    memset(derivative, 0, 4 * sizeof *derivative);
  for (int i = 0; i <= row->degree; i++) {
    const double *at = tsi_row_point(row, first + i);
    for (int c = 0; c < 4; c++) {
      point[c] += value[i] * at[c];
      if (derivative)
        derivative[c] += slope[i] * at[c];
    }
  }
}

int tsi_row_samples(const tsi_row *row, double *sample) {
  int per_span = 2 * row->degree + 2, n = 0; /* two rational curves meet at most 2p times */
  for (int i = row->degree; i < row->n; i++) {
    double low = row->knots[i], width = row->knots[i + 1] - low;
    if (!(width > 0.0))
      continue;
    for (int k = 0; k < per_span; k++, n++)
      if (sample)
        sample[n] = low + width * k / per_span;
  }
  if (sample)
    sample[n] = 1.0;
  return n + 1;
}

double tsi_seam_distance(const double a[4], const double b[4]) {
  double x[3], y[3];
  tsi_project_point(a, x);
  tsi_project_point(b, y);
  return tsi_distance(x, y);
}

/* ---- names and tolerances ---------------------------------------------------------------------
 */

double tsi_seam_tolerance(const tsi_shell *shell, const tsi_seam *s) {
  double tolerance = 0.0;
  for (int k = 0; k < 2; k++) {
    double own = facet_of(shell, s->row[k].patch)->tolerance[tsi_seam_border(shell, s, k)];
    tolerance = own > tolerance ? own : tolerance;
  }
  return tolerance;
}

void tsi_seam_name(const tsi_shell *shell, const tsi_seam *s, char text[2][TSI_BORDER_NAME_SIZE],
                   tsolid_finding *finding) {
  for (int k = 0; k < 2; k++) {
    int p = s->row[k].patch, b = tsi_seam_border(shell, s, k);
    const tsi_facet *facet = facet_of(shell, p);
    tsi_name_border(facet, b, text[k]);
    if (k == 0) {
      finding->entity = facet->is_cut[b] ? TSOLID_ENTITY_PATCH : TSOLID_ENTITY_BORDER;
      finding->index[0] = facet->patch;
      finding->index[1] = facet->is_cut[b] ? 0 : b;
    }
  }
}

/* ---- ratios -----------------------------------------------------------------------------------
 */

int tsi_ratios_create(tsi_arena *arena, int n, tsi_ratios *ratios) {
  ratios->parent = tsi_arena_new(arena, (size_t)n, sizeof *ratios->parent);
  ratios->log_ratio = tsi_arena_new(arena, (size_t)n, sizeof *ratios->log_ratio);
  for (int i = 0; ratios->parent && i < n; i++)
    ratios->parent[i] = i;
  return ratios->parent && ratios->log_ratio;
}

int tsi_ratios_find(tsi_ratios *ratios, int i, double *log_ratio) {
  int root = i;
  double sum = 0.0;
  for (; ratios->parent[root] != root; root = ratios->parent[root])
    sum += ratios->log_ratio[root];
  *log_ratio = sum;
  while (ratios->parent[i] != i) { /* shorten the path */
    int next = ratios->parent[i];
    double own = ratios->log_ratio[i];
    ratios->parent[i] = root;
    ratios->log_ratio[i] = sum;
    sum -= own;
    i = next;
  }
  return root;
}

void tsi_ratios_join(tsi_ratios *ratios, int i, int j, double log_ratio) {
  double log_i, log_j;
  int a = tsi_ratios_find(ratios, i, &log_i), b = tsi_ratios_find(ratios, j, &log_j);
  if (a == b)
    return;
  ratios->parent[b] = a;
  ratios->log_ratio[b] = log_i + log_ratio - log_j;
}
