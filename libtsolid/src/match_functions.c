/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Functions across a seam, compared by their traces: what they and their derivatives across are on
 * it, in Bernstein form on common intervals. Blind to what the patches are made of. */
#include <stdlib.h>

#include "bernstein.h"
#include "seams.h"

static const char stage[] = "boundary";

/* Traces, relative to one, and derivatives, relative to the largest, closer than this are one. */
static const double trace_agreement = 1e-11, derivative_agreement = 1e-9;
static const double weight_agreement = 1e-10;

/* ---- traces -----------------------------------------------------------------------------------
 */

/* A function on one interval of the seam. */
typedef struct trace {
  int function, interval;
  double *row; /* degree + 1 coefficients along the seam */
} trace;

/* One side of a seam: its traces by function, then interval. */
typedef struct seam_side {
  const tsi_side *elements;
  int along, end;
  double scale; /* of the parameter across, which runs from row[0]'s patch to row[1]'s */
  int n_pieces, n;
  int *piece; /* elements at the seam */
  trace *list;
} seam_side;

typedef struct seam_traces {
  int degree, n_values;
  double *value; /* ends of the intervals */
  seam_side side[2];
} seam_traces;

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static int compare_traces(const void *a, const void *b) {
  const trace *p = a, *q = b;
  if (p->function != q->function)
    return p->function < q->function ? -1 : 1;
  return (p->interval > q->interval) - (p->interval < q->interval);
}

static int list_pieces(tsi_arena *arena, seam_side *side) {
  const tsi_side *e = side->elements;
  side->piece = tsi_arena_new(arena, (size_t)e->n_elements, sizeof *side->piece);
  for (int i = 0; side->piece && i < e->n_elements; i++)
    if (e->box[4 * (size_t)i + (size_t)(2 * (1 - side->along) + side->end)] == (double)side->end)
      side->piece[side->n_pieces++] = i;
  return side->piece != NULL;
}

static int find_intervals(tsi_arena *arena, seam_traces *t) {
  size_t n = (size_t)(t->side[0].n_pieces + t->side[1].n_pieces) + 1;
  int count = 0;
  t->value = tsi_arena_new(arena, n, sizeof *t->value);
  if (!t->value)
    return 0;
  for (int k = 0; k < 2; k++)
    for (int i = 0; i < t->side[k].n_pieces; i++)
      t->value[count++] =
          t->side[k]
              .elements->box[4 * (size_t)t->side[k].piece[i] + (size_t)(2 * t->side[k].along)];
  t->value[count++] = 1.0;
  qsort(t->value, n, sizeof *t->value, compare_doubles);
  t->n_values = 1;
  for (int i = 1; i < count; i++)
    if (t->value[i] != t->value[t->n_values - 1])
      t->value[t->n_values++] = t->value[i];
  return 1;
}

/* Coefficients along the seam of derivative `order` across of entry k of element e. Returns 0 where
 * all vanish. */
static int derive_row(const seam_side *side, int e, int k, int order, double low, double high,
                      double *row) {
  const tsi_side *s = side->elements;
  int along = side->along, p = s->degree[along], q = s->degree[1 - along];
  size_t n0 = (size_t)s->degree[0] + 1, width = n0 * ((size_t)s->degree[1] + 1);
  size_t step = along ? n0 : 1, across = along ? 1 : n0;
  const double *box = s->box + 4 * (size_t)e, *c = s->coefficient + (size_t)k * width;
  double h = (box[2 * (1 - along) + 1] - box[2 * (1 - along)]) * side->scale, factor = 1.0;
  int some = 0;
  for (int d = 0; d < order; d++)
    factor *= (q - d) / h;
  for (int i = 0; i <= p; i++) {
    double difference[TSI_MAX_ORDER] = {0.0};
    int first = side->end ? q - order : 0;
    for (int j = 0; first >= 0 && j <= order && first + j <= q; j++)
      difference[j] = c[step * (size_t)i + across * (size_t)(first + j)];
    for (int d = 0; d < order; d++)
      for (int j = 0; j < order - d; j++)
        difference[j] = difference[j + 1] - difference[j];
    row[i] = order > q ? 0.0 : factor * difference[0];
    some |= row[i] != 0.0;
  }
  double start = box[2 * along], length = box[2 * along + 1] - start;
  tsi_bernstein_restrict(p, (low - start) / length,
                         high == box[2 * along + 1] ? 1.0 : (high - start) / length, row, 1);
  return some;
}

/* Traces of one element on one interval, appended; counts only while list is NULL. */
static void add_traces(const seam_traces *t, seam_side *side, int e, int interval, int order,
                       int *parent, double *rows) {
  const tsi_side *s = side->elements;
  for (int k = s->function_start[e]; k < s->function_start[e + 1]; k++) {
    double row[TSI_MAX_ORDER];
    if (!derive_row(side, e, k, order, t->value[interval], t->value[interval + 1], row))
      continue;
    if (side->list) {
      trace *to = &side->list[side->n];
      *to = (trace){tsi_find_function(parent, s->function[k]), interval,
                    rows + (size_t)side->n * (size_t)(t->degree + 1)};
      memcpy(to->row, row, (size_t)(t->degree + 1) * sizeof *row);
    }
    side->n++;
  }
}

static int list_traces(tsi_arena *arena, const seam_traces *t, seam_side *side, int order,
                       int *parent) {
  double *rows = NULL;
  for (int pass = 0; pass < 2; pass++) {
    if (pass) {
      side->list = tsi_arena_new(arena, (size_t)side->n, sizeof *side->list);
      rows = tsi_arena_new(arena, (size_t)side->n * (size_t)(t->degree + 1), sizeof *rows);
      if (!side->list || !rows)
        return 0;
      side->n = 0;
    }
    for (int i = 0; i < side->n_pieces; i++) {
      int e = side->piece[i];
      const double *range = side->elements->box + 4 * (size_t)e + 2 * side->along;
      for (int v = 0; v + 1 < t->n_values; v++)
        if (range[0] <= t->value[v] && t->value[v + 1] <= range[1])
          add_traces(t, side, e, v, order, parent, rows);
    }
  }
  qsort(side->list, (size_t)side->n, sizeof *side->list, compare_traces);
  int n = 0;
  for (int i = 0; i < side->n; i++) { /* a function that came in parts is their sum */
    if (n && compare_traces(&side->list[n - 1], &side->list[i]) == 0)
      for (int c = 0; c <= t->degree; c++)
        side->list[n - 1].row[c] += side->list[i].row[c];
    else
      side->list[n++] = side->list[i];
  }
  side->n = n;
  return 1;
}

/* Traces of derivative `order` on both sides of a seam. */
static int find_traces(tsi_arena *arena, const tsi_shell *shell, const tsi_seam *s, int order,
                       const double scale[2], int *parent, seam_traces *t) {
  *t = (seam_traces){.degree = shell->elements[s->row[0].patch].degree[s->row[0].along]};
  for (int k = 0; k < 2; k++) {
    t->side[k] = (seam_side){.elements = &shell->elements[s->row[k].patch],
                             .along = s->row[k].along,
                             .end = s->row[k].end,
                             .scale = scale[k]};
    if (!list_pieces(arena, &t->side[k]))
      return 0;
  }
  return find_intervals(arena, t) && list_traces(arena, t, &t->side[0], order, parent) &&
         list_traces(arena, t, &t->side[1], order, parent);
}

/* ---- groups -----------------------------------------------------------------------------------
 */

/* The traces first .. end-1 of one function. */
typedef struct group {
  int function, first, end;
} group;

static group *list_groups(tsi_arena *arena, const seam_side *side, int *n) {
  group *list = tsi_arena_new(arena, (size_t)side->n, sizeof *list);
  *n = 0;
  for (int i = 0; list && i < side->n; i++) {
    if (!i || side->list[i].function != side->list[i - 1].function)
      list[(*n)++] = (group){side->list[i].function, i, i};
    list[*n - 1].end = i + 1;
  }
  return list;
}

/* Largest difference of two functions' traces; an interval that one has not counts as zero. */
static double compare_groups(const seam_traces *t, const group *a, const group *b) {
  int i = a ? a->first : 0, i_end = a ? a->end : 0, j = b ? b->first : 0, j_end = b ? b->end : 0;
  double worst = 0.0;
  while (i < i_end || j < j_end) {
    const trace *p = i < i_end ? &t->side[0].list[i] : NULL;
    const trace *q = j < j_end ? &t->side[1].list[j] : NULL;
    if (p && q && p->interval != q->interval) {
      if (p->interval < q->interval)
        q = NULL;
      else
        p = NULL;
    }
    for (int c = 0; c <= t->degree; c++)
      worst = fmax(worst, fabs((p ? p->row[c] : 0.0) - (q ? q->row[c] : 0.0)));
    i += p != NULL;
    j += q != NULL;
  }
  return worst;
}

static tsolid_status refuse_function(tsolid_context *context, const tsi_shell *shell,
                                     const tsi_seam *s, int which, int function, double measured) {
  char name[2][TSI_BORDER_NAME_SIZE];
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  tsi_seam_name(shell, s, name, &finding);
  finding.has_point = 1;
  tsi_project_point(shell->control + 4 * (size_t)function, finding.point);
  finding.measured = measured;
  finding.allowed = trace_agreement;
  return tsi_report(context, &finding,
                    "%s and %s have different functions: that of the first's control point (%.6g, "
                    "%.6g, %.6g) has no like on the second",
                    name[which], name[1 - which], finding.point[0], finding.point[1],
                    finding.point[2]);
}

/* The unmatched group of side 1 with the same trace as `a` and the nearest control point. */
static int find_partner(const tsi_shell *shell, const seam_traces *t, const group *a, int n,
                        const group *list, const unsigned char *taken, double *distance) {
  const double *point = shell->control + 4 * (size_t)a->function;
  int found = -1;
  for (int j = 0; j < n; j++) {
    const double *other = shell->control + 4 * (size_t)list[j].function;
    if (taken[j] || t->side[1].list[list[j].first].interval != t->side[0].list[a->first].interval ||
        !(fabs(other[3] / point[3] - 1.0) <= weight_agreement) ||
        !(compare_groups(t, a, &list[j]) <= trace_agreement))
      continue;
    double off = tsi_seam_distance(point, other);
    if (found >= 0 && !(off < *distance))
      continue;
    found = j;
    *distance = off;
  }
  return found;
}

static void record_move(const tsi_seam *s, double moved, tsolid_preparation *preparation) {
  double *slot =
      s->isoline >= 0 ? &preparation->snap[s->isoline] : &preparation->snap_inside[s->side];
  *slot = fmax(*slot, moved);
}

static tsolid_status match_seam(tsolid_context *context, tsi_arena *arena, const tsi_shell *shell,
                                const tsi_seam *s, int *parent, tsolid_preparation *preparation) {
  static const double scale[2] = {1.0, 1.0};
  seam_traces t;
  int n[2];
  group *list[2] = {NULL, NULL};
  unsigned char *taken = NULL;
  if (find_traces(arena, shell, s, 0, scale, parent, &t)) {
    list[0] = list_groups(arena, &t.side[0], &n[0]);
    list[1] = list_groups(arena, &t.side[1], &n[1]);
    taken = list[1] ? tsi_arena_new(arena, (size_t)n[1], 1) : NULL;
  }
  if (!list[0] || !taken)
    return tsi_no_memory(context, stage);
  for (int i = 0, j = 0; i < n[0]; i++) { /* functions that live on both sides */
    while (j < n[1] && list[1][j].function < list[0][i].function)
      j++;
    if (j == n[1] || list[1][j].function != list[0][i].function)
      continue;
    double off = compare_groups(&t, &list[0][i], &list[1][j]);
    if (!(off <= trace_agreement))
      return refuse_function(context, shell, s, 0, list[0][i].function, off);
    taken[j] = 1;
    list[0][i].first = list[0][i].end;
  }
  for (int i = 0; i < n[0]; i++) {
    if (list[0][i].first == list[0][i].end)
      continue;
    double moved = 0.0;
    int j = find_partner(shell, &t, &list[0][i], n[1], list[1], taken, &moved);
    if (j < 0 || !(moved <= tsi_seam_tolerance(shell, s)))
      return refuse_function(context, shell, s, 0, list[0][i].function, j < 0 ? NAN : moved);
    taken[j] = 1;
    tsi_join_functions(parent, list[0][i].function, list[1][j].function);
    record_move(s, moved, preparation);
  }
  for (int j = 0; j < n[1]; j++)
    if (!taken[j])
      return refuse_function(context, shell, s, 1, list[1][j].function, NAN);
  return TSOLID_OK;
}

tsolid_status tsi_shell_match_functions(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                        int *parent, tsolid_preparation *preparation) {
  int n;
  tsi_seam *list = tsi_seams_list(arena, shell, &n);
  tsolid_status status = list ? TSOLID_OK : tsi_no_memory(context, stage);
  for (int i = 0; !status && i < n; i++) {
    if (tsi_seam_has_rows(shell, &list[i]))
      continue;
    tsi_arena own = tsi_arena_create(context);
    status = match_seam(context, &own, shell, &list[i], parent, preparation);
    tsi_arena_free(&own);
  }
  return status;
}

/* ---- smooth seams -----------------------------------------------------------------------------
 */

/* Widths of both patches' parameters across the seam, with the sign that makes both run from the
 * first patch to the second. */
static void find_scales(const tsi_shell *shell, const tsi_seam *s, double scale[2]) {
  for (int k = 0; k < 2; k++) {
    const tsi_place *place = shell->place[s->row[k].patch];
    int across = 1 - s->row[k].along;
    const double *domain = shell->domain[place->facet] + 2 * (place->swap ? 1 - across : across);
    scale[k] = domain[1] - domain[0];
    if (s->row[k].end == k)
      scale[k] = -scale[k];
  }
}

static tsolid_status check_order(tsolid_context *context, tsi_arena *arena, const tsi_shell *shell,
                                 const tsi_seam *s, const double scale[2], int order, int wanted,
                                 int *parent) {
  seam_traces t;
  int n[2];
  group *list[2] = {NULL, NULL};
  double largest = 0.0;
  if (find_traces(arena, shell, s, order, scale, parent, &t)) {
    list[0] = list_groups(arena, &t.side[0], &n[0]);
    list[1] = list_groups(arena, &t.side[1], &n[1]);
  }
  if (!list[0] || !list[1])
    return tsi_no_memory(context, stage);
  for (int k = 0; k < 2; k++)
    for (int i = 0; i < t.side[k].n; i++)
      for (int c = 0; c <= t.degree; c++)
        largest = fmax(largest, fabs(t.side[k].list[i].row[c]));
  for (int i = 0, j = 0; i < n[0] || j < n[1];) {
    const group *a = i < n[0] ? &list[0][i] : NULL, *b = j < n[1] ? &list[1][j] : NULL;
    if (a && b && a->function != b->function) {
      if (a->function < b->function)
        b = NULL;
      else
        a = NULL;
    }
    double off = compare_groups(&t, a, b);
    if (!(off <= derivative_agreement * largest)) {
      char name[2][TSI_BORDER_NAME_SIZE];
      int function = a ? a->function : b->function;
      tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
      tsi_seam_name(shell, s, name, &finding);
      finding.has_point = 1;
      tsi_project_point(shell->control + 4 * (size_t)function, finding.point);
      finding.measured = off / largest;
      finding.allowed = derivative_agreement;
      return tsi_report(context, &finding,
                        "%s and %s are meant to be smooth to order %d, but derivatives of order %d "
                        "jump there, by %.3g of the largest, at the function of the control point "
                        "(%.6g, %.6g, %.6g)",
                        name[0], name[1], wanted, order, finding.measured, finding.point[0],
                        finding.point[1], finding.point[2]);
    }
    i += a != NULL;
    j += b != NULL;
  }
  return TSOLID_OK;
}

static int is_side_of(const tsi_shell *shell, const tsi_seam *s, int which, int patch, int border) {
  const tsi_facet *facet = &shell->facet[shell->place[s->row[which].patch]->facet];
  int own = tsi_seam_border(shell, s, which);
  return facet->patch == patch && own == border && !facet->is_cut[own];
}

static int is_wanted(const tsi_shell *shell, const tsi_seam *s, const tsolid_smooth_seam *wanted) {
  for (int which = 0; which < 2; which++)
    if (is_side_of(shell, s, which, wanted->patch[0], wanted->border[0]) &&
        is_side_of(shell, s, 1 - which, wanted->patch[1], wanted->border[1]))
      return 1;
  return 0;
}

static tsolid_status check_seam(tsolid_context *context, const tsi_shell *shell, const tsi_seam *s,
                                int wanted, int *parent) {
  double scale[2];
  find_scales(shell, s, scale);
  for (int order = 1; order <= wanted && order <= TSI_MAX_DEGREE; order++) {
    tsi_arena own = tsi_arena_create(context);
    tsolid_status status = check_order(context, &own, shell, s, scale, order, wanted, parent);
    tsi_arena_free(&own);
    if (status)
      return status;
  }
  return TSOLID_OK;
}

tsolid_status tsi_shell_check_smooth(tsolid_context *context, tsi_arena *arena,
                                     const tsi_shell *shell, const tsolid_boundary_input *input,
                                     int *parent) {
  int n;
  tsi_seam *list = tsi_seams_list(arena, shell, &n);
  if (!list)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < input->n_smooth; i++) {
    const tsolid_smooth_seam *wanted = &input->smooth[i];
    int n_found = 0; /* several where patches are cut */
    for (int k = 0; k < n; k++) {
      if (wanted->order < 1 || !is_wanted(shell, &list[k], wanted))
        continue;
      tsolid_status status = check_seam(context, shell, &list[k], wanted->order, parent);
      if (status)
        return status;
      n_found++;
    }
    if (!n_found)
      return tsi_fail(
          context, TSOLID_ERROR_INPUT, stage,
          "Smooth seam %d: border %d of patch %d and border %d of patch %d do not meet, "
          "or the order is %d",
          i, wanted->border[0], wanted->patch[0], wanted->border[1], wanted->patch[1],
          wanted->order);
  }
  return TSOLID_OK;
}
