/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Bezier elements of a T-spline patch.
 *
 * The knots of all functions make a grid; a grid line is *covered* over a cell of the other
 * direction when a function that lives there has a knot on it. Boxes are cut along covered lines
 * until none runs through them, first those that are covered across the whole box: so a knot line
 * of few functions reaches as far as these and, where it ends inside a box, to the end of it. */
#include <stdlib.h>

#include "bernstein.h"
#include "tspline.h"

static const char stage[] = "boundary";

typedef struct knot_grid {
  int n[2]; /* lines, 0 and 1 included */
  double *value[2];
  int *line[2];    /* of knot k of the patch; knots outside [0,1] lie on its ends */
  int *covered[2]; /* [line * n[other] + cell]: covered cells before this one */
} knot_grid;

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static int find_line(int n, const double *value, double x) {
  int low = 0, high = n - 1;
  while (low < high) {
    int middle = low + (high - low + 1) / 2;
    if (value[middle] <= x)
      low = middle;
    else
      high = middle - 1;
  }
  return low;
}

/* The distinct knots in [0,1], and where each knot of the patch lies among them. */
static int list_lines(tsi_arena *arena, const tsi_tspline *t, int d, knot_grid *g) {
  size_t n_knots = (size_t)t->n_knots[d];
  double *value = tsi_arena_new(arena, n_knots + 2, sizeof *value);
  g->line[d] = tsi_arena_new(arena, n_knots, sizeof *g->line[d]);
  if (!value || !g->line[d])
    return 0;
  int n = 0, count = 1;
  for (size_t k = 0; k < n_knots; k++)
    if (t->knots[d][k] > 0.0 && t->knots[d][k] < 1.0)
      value[n++] = t->knots[d][k];
  value[n++] = 0.0;
  value[n++] = 1.0;
  qsort(value, (size_t)n, sizeof *value, compare_doubles);
  for (int i = 1; i < n; i++)
    if (value[i] != value[count - 1])
      value[count++] = value[i];
  g->n[d] = count;
  g->value[d] = value;
  for (size_t k = 0; k < n_knots; k++)
    g->line[d][k] = find_line(count, value, t->knots[d][k]);
  return 1;
}

/* Lines of a function's support in direction d. */
static void find_support(const tsi_tspline *t, const knot_grid *g, int blend, int d, int *low,
                         int *high) {
  const int *line = g->line[d] + t->blend[blend].knot[d];
  *low = line[0];
  *high = line[t->degree[d] + 1];
}

static void cover_lines(const tsi_tspline *t, knot_grid *g, int d) {
  size_t stride = (size_t)g->n[1 - d];
  int *covered = g->covered[d];
  for (int b = 0; b < t->n; b++) {
    int low, high;
    const int *line = g->line[d] + t->blend[b].knot[d];
    find_support(t, g, b, 1 - d, &low, &high);
    for (int i = 0; low < high && i < t->degree[d] + 2; i++) {
      if (i && line[i] == line[i - 1])
        continue;
      covered[(size_t)line[i] * stride + (size_t)low]++;
      covered[(size_t)line[i] * stride + (size_t)high]--;
    }
  }
  for (int l = 0; l < g->n[d]; l++) { /* differences to numbers to sums of ones */
    int *row = covered + (size_t)l * stride, depth = 0, sum = 0;
    for (size_t cell = 0; cell < stride; cell++) {
      depth += row[cell];
      row[cell] = sum;
      sum += depth > 0;
    }
  }
}

/* The best line to cut the box along, in units of the grid: the most covered one, of several the
 * one nearest to the middle. 0: none runs through it. */
static int find_cut(const knot_grid *g, const int box[4], int *direction, int *at) {
  int found = 0, best_off = 0;
  double best = 0.0;
  for (int d = 0; d < 2; d++) {
    const int *along = box + 2 * (1 - d);
    size_t stride = (size_t)g->n[1 - d];
    for (int l = box[2 * d] + 1; l < box[2 * d + 1]; l++) {
      const int *row = g->covered[d] + (size_t)l * stride;
      double part = (double)(row[along[1]] - row[along[0]]) / (along[1] - along[0]);
      int off = abs(2 * l - box[2 * d] - box[2 * d + 1]);
      if (!(part > 0.0) || part < best || (part == best && found && off >= best_off))
        continue;
      found = 1;
      best = part;
      best_off = off;
      *direction = d;
      *at = l;
    }
  }
  return found;
}

/* Cuts the whole patch into boxes; box: room for one per cell of the grid, rows of 4. Returns how
 * many. Boxes not looked at yet stand behind those that are done, from the far end. */
static size_t cut_boxes(const knot_grid *g, size_t capacity, int (*box)[4]) {
  size_t n = 0, waiting = capacity - 1;
  int whole[4] = {0, g->n[0] - 1, 0, g->n[1] - 1}, d = 0, at = 0;
  memcpy(box[waiting], whole, sizeof whole);
  while (waiting < capacity) {
    int *top = box[waiting];
    if (find_cut(g, top, &d, &at)) {
      memcpy(box[waiting - 1], top, sizeof whole);
      top[2 * d] = at;
      box[--waiting][2 * d + 1] = at;
    } else {
      memmove(box[n++], top, sizeof whole);
      waiting++;
    }
  }
  return n;
}

/* Calls for every (element, function) pair, functions in order: counts into start[e + 1], or
 * enters into `function` from start[e] on, which it moves. */
static void visit_pairs(const tsi_tspline *t, const knot_grid *g, const int *element_of_cell,
                        int *last, int *start, int *function) {
  for (int b = 0; b < t->n; b++) {
    int low[2], high[2];
    for (int d = 0; d < 2; d++)
      find_support(t, g, b, d, &low[d], &high[d]);
    for (int j = low[1]; j < high[1]; j++)
      for (int i = low[0]; i < high[0]; i++) {
        int e = element_of_cell[(size_t)i + (size_t)(g->n[0] - 1) * (size_t)j];
        if (last[e] == b)
          continue;
        last[e] = b;
        if (function)
          function[start[e]++] = b;
        else
          start[e + 1]++;
      }
  }
}

static void fill_coefficients(const tsi_tspline *t, int blend, const double box[4],
                              const int degree[2], double *coefficient) {
  double own[TSI_MAX_ORDER], row[2][TSI_MAX_ORDER];
  for (int d = 0; d < 2; d++) {
    tsi_bspline_bernstein(t->degree[d], t->knots[d] + t->blend[blend].knot[d], box[2 * d],
                          box[2 * d + 1], own);
    tsi_bernstein_raise(t->degree[d], degree[d], 1, own, row[d]);
  }
  for (int b = 0; b <= degree[1]; b++)
    for (int a = 0; a <= degree[0]; a++)
      *coefficient++ = row[0][a] * row[1][b];
}

static tsolid_status refuse_size(tsolid_context *context, const char *name) {
  return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "%s has too many knots or functions", name);
}

/* Boxes, and which functions live on each. */
static tsolid_status find_elements(tsolid_context *context, tsi_arena *arena, const tsi_tspline *t,
                                   const knot_grid *g, const char *name, size_t width,
                                   tsi_side *elements) {
  size_t n_cells = (size_t)(g->n[0] - 1) * (size_t)(g->n[1] - 1);
  int(*box)[4] = tsi_arena_new(arena, n_cells + 1, sizeof *box);
  int *element_of_cell = tsi_arena_new(arena, n_cells, sizeof *element_of_cell);
  if (!box || !element_of_cell)
    return tsi_no_memory(context, stage);
  size_t n = cut_boxes(g, n_cells + 1, box);
  elements->n_elements = (int)n;
  elements->box = tsi_arena_new(arena, n, 4 * sizeof *elements->box);
  elements->function_start = tsi_arena_new(arena, n + 1, sizeof *elements->function_start);
  int *last = tsi_arena_new(arena, n, sizeof *last);
  if (!elements->box || !elements->function_start || !last)
    return tsi_no_memory(context, stage);
  for (size_t e = 0; e < n; e++) {
    for (int k = 0; k < 4; k++)
      elements->box[4 * e + (size_t)k] = g->value[k / 2][box[e][k]];
    for (int j = box[e][2]; j < box[e][3]; j++)
      for (int i = box[e][0]; i < box[e][1]; i++)
        element_of_cell[(size_t)i + (size_t)(g->n[0] - 1) * (size_t)j] = (int)e;
    last[e] = -1;
  }
  visit_pairs(t, g, element_of_cell, last, elements->function_start, NULL);
  double entries = 0.0;
  for (size_t e = 0; e < n; e++) {
    entries += elements->function_start[e + 1];
    if (entries * (double)width > TSI_MAX_COUNT)
      return refuse_size(context, name);
    elements->function_start[e + 1] += elements->function_start[e];
    last[e] = -1;
  }
  elements->function = tsi_arena_new(arena, (size_t)entries, sizeof *elements->function);
  if (!elements->function)
    return tsi_no_memory(context, stage);
  visit_pairs(t, g, element_of_cell, last, elements->function_start, elements->function);
  memmove(elements->function_start + 1, elements->function_start, n * sizeof(int));
  elements->function_start[0] = 0;
  return TSOLID_OK;
}

tsolid_status tsi_tspline_elements(tsolid_context *context, tsi_arena *arena,
                                   const tsi_tspline *tspline, const int degree[2],
                                   const char *name, tsi_side *elements) {
  tsi_arena own = tsi_arena_create(context);
  tsolid_status status = TSOLID_OK;
  knot_grid g = {{0, 0}, {NULL, NULL}, {NULL, NULL}, {NULL, NULL}};
  size_t width = (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1), n_entries;
  *elements = (tsi_side){.degree = {degree[0], degree[1]}, .grid = {1, 1}};
  if (!list_lines(&own, tspline, 0, &g) || !list_lines(&own, tspline, 1, &g)) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  if ((double)g.n[0] * g.n[1] > TSI_MAX_COUNT / 16) {
    status = refuse_size(context, name);
    goto done;
  }
  for (int d = 0; d < 2; d++) {
    g.covered[d] = tsi_arena_new(&own, (size_t)g.n[0] * (size_t)g.n[1], sizeof *g.covered[d]);
    if (!g.covered[d]) {
      status = tsi_no_memory(context, stage);
      goto done;
    }
    cover_lines(tspline, &g, d);
  }
  status = find_elements(context, arena, tspline, &g, name, width, elements);
  if (status)
    goto done;
  n_entries = (size_t)elements->function_start[elements->n_elements];
  elements->coefficient = tsi_arena_new(arena, n_entries * width, sizeof *elements->coefficient);
  if (!elements->coefficient) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  for (int e = 0; e < elements->n_elements; e++)
    for (int k = elements->function_start[e]; k < elements->function_start[e + 1]; k++) {
      int blend = elements->function[k];
      fill_coefficients(tspline, blend, elements->box + 4 * (size_t)e, degree,
                        elements->coefficient + (size_t)k * width);
      elements->function[k] = tspline->blend[blend].point;
    }
done:
  tsi_arena_free(&own);
  return status;
}
