/* SPDX-License-Identifier: LGPL-2.1-or-later
 * From prepared patches to Bezier elements. The surface functions are the surface points of a
 * lattice N_x x N_y x N_z of univariate functions: along an axis the strips join C^0, neighbours
 * share the function at their common end. */
#include "bernstein.h"
#include "boundary.h"
#include "bspline.h"

static const char stage[] = "boundary";

/* All univariate functions of one axis in Bernstein form of one degree. */
typedef struct axis_basis {
  int degree, n_functions, n_elements;
  double *value;      /* n_elements + 1 */
  int *first, *count; /* per element: functions first .. first+count-1 */
  size_t *start;      /* per element: rows of degree+1 coefficients in `coefficient` */
  double *coefficient;
} axis_basis;

/* Any patch of a strip's belt, and its direction. */
static const tsi_patch *patch_of_strip(const tsi_shell *shell, int axis, int strip, int *along) {
  int side = axis == 0 ? 2 : 0, s = tsi_side_s(side);
  *along = tsi_side_t(side) == axis;
  return &shell->patch[shell->first[side] + (*along ? shell->n_strips[s] * strip : strip)];
}

/* ---- strip widths -----------------------------------------------------------------------------
 */

/* Lengths of both border polygons of a patch along a direction. */
static double measure_borders(const tsi_patch *patch, int along) {
  double length = 0.0;
  size_t n0 = (size_t)patch->n[0];
  for (int end = 0; end < 2; end++) {
    size_t fixed = end ? (size_t)patch->n[1 - along] - 1 : 0;
    const double *previous = NULL;
    for (size_t m = 0; m < (size_t)patch->n[along]; m++) {
      const double *h = patch->control + 4 * (along ? fixed + n0 * m : m + n0 * fixed);
      if (previous)
        length += hypot(
            hypot(h[0] / h[3] - previous[0] / previous[3], h[1] / h[3] - previous[1] / previous[3]),
            h[2] / h[3] - previous[2] / previous[3]);
      previous = h;
    }
  }
  return length;
}

static double measure_strip(const tsi_shell *shell, int axis, int strip) {
  double length = 0.0;
  for (int side = 0; side < 6; side++) {
    int s = tsi_side_s(side), t = tsi_side_t(side);
    if (s != axis && t != axis)
      continue;
    int along = t == axis;
    for (int k = 0; k < shell->n_strips[along ? s : t]; k++) {
      int i = along ? k : strip, j = along ? strip : k;
      length +=
          measure_borders(&shell->patch[shell->first[side] + i + shell->n_strips[s] * j], along);
    }
  }
  return length;
}

/* line[axis]: where strips begin and end in [0,1], by their mean length. */
static tsolid_status place_strips(tsolid_context *context, tsi_arena *arena, tsi_shell *shell) {
  for (int axis = 0; axis < 3; axis++) {
    int n = shell->n_strips[axis];
    double *line = tsi_arena_new(arena, (size_t)n + 1, sizeof *line);
    if (!line)
      return tsi_no_memory(context, stage);
    shell->line[axis] = line;
    for (int i = 0; i < n; i++)
      line[i + 1] = line[i] + (n == 1 ? 1.0 : measure_strip(shell, axis, i));
    double total = line[n];
    for (int i = 1; i < n; i++) {
      line[i] = 1.0 - (1.0 - line[i] / total);
      if (!(line[i] > line[i - 1]) || !(line[i] < 1.0))
        return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                        "The faces of a side differ in length beyond all measure");
    }
    line[n] = 1.0;
  }
  return TSOLID_OK;
}

/* ---- univariate functions ---------------------------------------------------------------------
 */

static void count_axis(const tsi_shell *shell, int axis, axis_basis *b, size_t *n_rows) {
  b->degree = b->n_elements = 0;
  b->n_functions = 1;
  *n_rows = 0;
  for (int strip = 0; strip < shell->n_strips[axis]; strip++) {
    int along;
    const tsi_patch *patch = patch_of_strip(shell, axis, strip, &along);
    int p = patch->degree[along];
    b->degree = p > b->degree ? p : b->degree;
    b->n_functions += patch->n[along] - 1;
    for (int i = p; i < patch->n[along]; i++)
      if (patch->knots[along][i] < patch->knots[along][i + 1]) {
        b->n_elements++;
        *n_rows += (size_t)p + 1;
      }
  }
}

static tsolid_status build_axis(tsolid_context *context, tsi_arena *arena, const tsi_shell *shell,
                                int axis, axis_basis *b) {
  size_t n_rows, row = 0;
  count_axis(shell, axis, b, &n_rows);
  size_t n = (size_t)b->n_elements, width = (size_t)b->degree + 1;
  b->value = tsi_arena_new(arena, n + 1, sizeof *b->value);
  b->first = tsi_arena_new(arena, n, sizeof *b->first);
  b->count = tsi_arena_new(arena, n, sizeof *b->count);
  b->start = tsi_arena_new(arena, n, sizeof *b->start);
  b->coefficient = tsi_arena_new(arena, n_rows * width, sizeof *b->coefficient);
  if (!b->value || !b->first || !b->count || !b->start || !b->coefficient)
    return tsi_no_memory(context, stage);
  int e = 0, offset = 0;
  for (int strip = 0; strip < shell->n_strips[axis]; strip++) {
    int along;
    const tsi_patch *patch = patch_of_strip(shell, axis, strip, &along);
    const double *knots = patch->knots[along];
    double low = shell->line[axis][strip], high = shell->line[axis][strip + 1];
    int p = patch->degree[along];
    for (int i = p; i < patch->n[along]; i++) {
      if (!(knots[i] < knots[i + 1]))
        continue;
      b->value[e] = 1.0 - (1.0 - (low + knots[i] * (high - low))); /* see tsi_knots_normalise */
      b->first[e] = offset + i - p;
      b->count[e] = p + 1;
      b->start[e++] = row;
      for (int k = i - p; k <= i; k++) {
        double own[TSI_MAX_ORDER];
        tsi_bspline_bernstein(p, knots + k, knots[i], knots[i + 1], own);
        tsi_bernstein_raise(p, b->degree, 1, own, b->coefficient + row++ * width);
      }
    }
    offset += patch->n[along] - 1;
  }
  b->value[e] = 1.0;
  for (int i = 0; i < e; i++)
    if (!(b->value[i] < b->value[i + 1]))
      return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                      "The knots of a face lie too close together to be told apart");
  return TSOLID_OK;
}

/* ---- the surface of the lattice ---------------------------------------------------------------
 */

/* Consecutive numbers for the surface points: the bottom, the top, then the rings between. */
size_t tsi_lattice_id(const size_t n[3], const size_t x[3]) {
  size_t layer = n[0] * n[1], ring = 2 * (n[0] + n[1]) - 4, at;
  if (x[2] == 0)
    return x[0] + n[0] * x[1];
  if (x[2] == n[2] - 1)
    return layer + x[0] + n[0] * x[1];
  if (x[1] == 0)
    at = x[0];
  else if (x[1] == n[1] - 1)
    at = n[0] + x[0];
  else
    at = 2 * n[0] + (x[0] == 0 ? 0 : n[1] - 2) + x[1] - 1;
  return 2 * layer + (x[2] - 1) * ring + at;
}

double tsi_lattice_count(const size_t n[3]) {
  double x = (double)n[0], y = (double)n[1], z = (double)n[2];
  return 2.0 * x * y + (z - 2.0) * (2.0 * (x + y) - 4.0);
}

static size_t side_id(int side, const axis_basis basis[3], size_t i, size_t j) {
  size_t n[3], x[3];
  for (int a = 0; a < 3; a++)
    n[a] = (size_t)basis[a].n_functions;
  x[tsi_side_axis(side)] = side & 1 ? n[tsi_side_axis(side)] - 1 : 0;
  x[tsi_side_s(side)] = i;
  x[tsi_side_t(side)] = j;
  return tsi_lattice_id(n, x);
}

static void collect_points(const tsi_shell *shell, const axis_basis basis[3], tsi_draft *draft) {
  for (int side = 0; side < 6; side++) {
    int n_s = shell->n_strips[tsi_side_s(side)], n_t = shell->n_strips[tsi_side_t(side)];
    size_t at_t = 0;
    for (int j = 0; j < n_t; j++) {
      size_t at_s = 0;
      const tsi_patch *patch = shell->patch + shell->first[side] + n_s * j;
      for (int i = 0; i < n_s; i++, patch++) {
        size_t n0 = (size_t)patch->n[0], n1 = (size_t)patch->n[1];
        for (size_t v = 0; v < n1; v++)
          for (size_t u = 0; u < n0; u++)
            memcpy(draft->points + 4 * side_id(side, basis, at_s + u, at_t + v),
                   patch->control + 4 * (u + n0 * v), 4 * sizeof *draft->points);
        at_s += n0 - 1;
        if (i + 1 == n_s)
          at_t += n1 - 1;
      }
    }
  }
}

static void fill_element(int side, const axis_basis basis[3], int es, int et, int *function,
                         double *coefficient) {
  const axis_basis *s = &basis[tsi_side_s(side)], *t = &basis[tsi_side_t(side)];
  size_t ds = (size_t)s->degree + 1, dt = (size_t)t->degree + 1;
  for (int j = 0; j < t->count[et]; j++)
    for (int i = 0; i < s->count[es]; i++) {
      const double *cs = s->coefficient + (s->start[es] + (size_t)i) * ds;
      const double *ct = t->coefficient + (t->start[et] + (size_t)j) * dt;
      *function++ =
          (int)side_id(side, basis, (size_t)(s->first[es] + i), (size_t)(t->first[et] + j));
      for (size_t b = 0; b < dt; b++)
        for (size_t a = 0; a < ds; a++)
          *coefficient++ = cs[a] * ct[b];
    }
}

static tsolid_status build_side(tsolid_context *context, tsi_arena *arena, const tsi_shell *shell,
                                const axis_basis basis[3], int number, tsi_side *side) {
  const axis_basis *s = &basis[tsi_side_s(number)], *t = &basis[tsi_side_t(number)];
  size_t width = (size_t)(s->degree + 1) * (size_t)(t->degree + 1);
  double n_entries = 0.0, n_elements = (double)s->n_elements * t->n_elements;
  for (int j = 0; j < t->n_elements; j++)
    for (int i = 0; i < s->n_elements; i++)
      n_entries += (double)s->count[i] * t->count[j];
  if (n_entries * (double)width > TSI_MAX_COUNT || n_elements > TSI_MAX_COUNT / 16)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "Side %d is too large", number);
  side->degree[0] = s->degree;
  side->degree[1] = t->degree;
  side->n_elements = (int)n_elements;
  side->grid[0] = shell->n_strips[tsi_side_s(number)];
  side->grid[1] = shell->n_strips[tsi_side_t(number)];
  side->box = tsi_arena_new(arena, (size_t)n_elements, 4 * sizeof *side->box);
  side->function_start = tsi_arena_new(arena, (size_t)n_elements + 1, sizeof *side->function_start);
  side->function = tsi_arena_new(arena, (size_t)n_entries, sizeof *side->function);
  side->coefficient = tsi_arena_new(arena, (size_t)n_entries * width, sizeof *side->coefficient);
  if (!side->box || !side->function_start || !side->function || !side->coefficient)
    return tsi_no_memory(context, stage);
  int e = 0, entry = 0;
  for (int j = 0; j < t->n_elements; j++)
    for (int i = 0; i < s->n_elements; i++, e++) {
      double box[4] = {s->value[i], s->value[i + 1], t->value[j], t->value[j + 1]};
      memcpy(side->box + 4 * e, box, sizeof box);
      fill_element(number, basis, i, j, side->function + entry,
                   side->coefficient + (size_t)entry * width);
      entry += s->count[i] * t->count[j];
      side->function_start[e + 1] = entry;
    }
  return TSOLID_OK;
}

tsolid_status tsi_shell_draft(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                              tsi_draft *draft) {
  axis_basis basis[3];
  tsolid_status status = place_strips(context, arena, shell);
  for (int axis = 0; !status && axis < 3; axis++)
    status = build_axis(context, arena, shell, axis, &basis[axis]);
  if (status)
    return status;
  size_t n_lattice[3];
  for (int a = 0; a < 3; a++)
    n_lattice[a] = (size_t)basis[a].n_functions;
  double n = tsi_lattice_count(n_lattice);
  if (n > TSI_MAX_COUNT / 16)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "The boundary has too many functions");
  draft->n_functions = (int)n;
  draft->points = tsi_arena_new(arena, (size_t)n, 4 * sizeof *draft->points);
  if (!draft->points)
    return tsi_no_memory(context, stage);
  collect_points(shell, basis, draft);
  for (int side = 0; !status && side < 6; side++)
    status = build_side(context, arena, shell, basis, side, &draft->side[side]);
  return status;
}
