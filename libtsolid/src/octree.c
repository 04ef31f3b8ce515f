/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The core: lines per axis from the T-junctions of the four sides that carry the axis, and core
 * cells between them.
 *
 * Source: Zhang, Wang, Hughes (2012), section 3. T-junctions are the corners of the sides' Bezier
 * elements; an interval is split at the T-junction value nearest its middle until at most one lies
 * inside. One binary tree of values per axis, so that neighbours split at the same place. The core
 * is the full tensor grid of the trees' lines. Lines much closer than their neighbours are taken
 * together: inner lines are free (conformity does not depend on them), and two planes 1e-12 apart
 * would give slopes of 1e12. */
#include "internal.h"

#include <stdlib.h>

static const char *const STAGE = "tmesh";

/* Two lines closer than this fraction of the wider neighbouring gap become one. */
static const double MERGE_FRACTION = 1.0 / 20.0;

enum { DEFAULT_MIN_CELLS = 3, MAX_MIN_CELLS = 256, MAX_CORE_CELLS = 1 << 23 };

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* All element borders of the four sides along `axis`, ascending and distinct; *n of them. */
static double *collect_lines(const tsolid_boundary *boundary, int axis, tsi_arena *arena, int *n) {
  size_t room = 2;
  for (int side = 0; side < 6; side++)
    if (tsi_side_axis(side) != axis)
      room += 2 * (size_t)boundary->side[side].n_elements;
  double *line = tsi_arena_new(arena, room, sizeof *line);
  if (!line)
    return NULL;
  size_t count = 0;
  line[count++] = 0.0;
  line[count++] = 1.0;
  for (int side = 0; side < 6; side++) {
    if (tsi_side_axis(side) == axis)
      continue;
    const tsi_side *s = &boundary->side[side];
    int first = tsi_side_s(side) == axis ? 0 : 2;
    for (int e = 0; e < s->n_elements; e++) {
      line[count++] = s->box[4 * e + first];
      line[count++] = s->box[4 * e + first + 1];
    }
  }
  qsort(line, count, sizeof *line, compare_doubles);
  size_t unique = 1;
  for (size_t i = 1; i < count; i++)
    if (line[i] > line[unique - 1])
      line[unique++] = line[i];
  *n = (int)unique;
  return line;
}

/* Takes lines together, the relatively closest pair first, until none is too close. */
static int merge_lines(double *line, int n) {
  for (;;) {
    int closest = -1;
    double smallest = MERGE_FRACTION;
    for (int i = 0; i + 1 < n; i++) {
      double before = i > 0 ? line[i] - line[i - 1] : 0.0;
      double after = i + 2 < n ? line[i + 2] - line[i + 1] : 0.0;
      double ratio = (line[i + 1] - line[i]) / fmax(before, after);
      if (n > 2 && ratio < smallest) {
        smallest = ratio;
        closest = i;
      }
    }
    if (closest < 0)
      return n;
    int gone = closest + 1 < n - 1 ? closest + 1 : closest; /* the ends 0 and 1 stay */
    memmove(line + gone, line + gone + 1, (size_t)(n - gone - 1) * sizeof *line);
    n--;
  }
}

/* The axis tree: splits the interval between positions `first` and `last` of `value` at the value
 * nearest its middle while more than one value lies inside, and marks the splits as kept. */
static void split_tree(const double *value, int first, int last, unsigned char *kept) {
  if (last - first <= 2)
    return;
  double middle = 0.5 * (value[first] + value[last]);
  int nearest = first + 1;
  for (int i = first + 2; i < last; i++)
    if (fabs(value[i] - middle) < fabs(value[nearest] - middle))
      nearest = i;
  kept[nearest] = 1;
  split_tree(value, first, nearest, kept);
  split_tree(value, nearest, last, kept);
}

/* The lines of the axis tree among n T-junction values, in place; returns their number or -1. */
static int tree_lines(double *value, int n, tsi_arena *arena) {
  unsigned char *kept = tsi_arena_new(arena, (size_t)n, 1);
  if (!kept)
    return -1;
  kept[0] = kept[n - 1] = 1;
  split_tree(value, 0, n - 1, kept);
  int count = 0;
  for (int i = 0; i < n; i++)
    if (kept[i])
      value[count++] = value[i];
  return count;
}

/* Where to split [low, high] when no T-junction asks for it: at the T-junction value nearest the
 * middle unless that is far from it. (A line that all but coincides with one of the input's would
 * cut slivers out of the arms.) */
static double split_value(double low, double high, int n_values, const double *value) {
  double middle = 0.5 * (low + high), best = middle, distance = 0.25 * (high - low);
  for (int i = 0; i < n_values; i++)
    if (fabs(value[i] - middle) < distance) {
      distance = fabs(value[i] - middle);
      best = value[i];
    }
  return best;
}

/* Splits the widest intervals, all that are equally wide at once so that symmetry stays, until
 * there are at least `cells` of them; line has room for 2 * cells + 1. */
static int split_widest(double *line, int n, int cells, int n_values, const double *value) {
  while (n - 1 < cells) {
    double widest = 0.0;
    for (int i = 0; i + 1 < n; i++)
      widest = fmax(widest, line[i + 1] - line[i]);
    for (int i = 0; i + 1 < n; i++) {
      if (line[i + 1] - line[i] < 0.99 * widest)
        continue;
      memmove(line + i + 2, line + i + 1, (size_t)(n - i - 1) * sizeof *line);
      line[i + 1] = split_value(line[i], line[i + 2], n_values, value);
      n++;
      i++;
    }
  }
  return n;
}

/* Lines of one axis; NULL: no memory. */
static double *axis_lines(const tsolid_boundary *boundary, int axis, int min_cells,
                          tsi_arena *arena, int *n) {
  int n_values;
  double *value = collect_lines(boundary, axis, arena, &n_values);
  if (!value)
    return NULL;
  n_values = merge_lines(value, n_values);
  double *line = tsi_arena_new(arena, (size_t)n_values + 2 * (size_t)min_cells + 2, sizeof *line);
  if (!line)
    return NULL;
  if (n_values == 2) { /* nothing inside: equal parts */
    for (int i = 0; i <= min_cells; i++)
      line[i] = (double)i / min_cells;
    *n = min_cells + 1;
    return line;
  }
  memcpy(line, value, (size_t)n_values * sizeof *line);
  *n = tree_lines(line, n_values, arena);
  if (*n < 0)
    return NULL;
  *n = split_widest(line, *n, min_cells, n_values, value);
  return line;
}

/* R of each arm: twice the width of the core cells next to it. */
static void choose_arm_heights(const int n_lines[3], double *const line[3], double height[6]) {
  for (int a = 0; a < 3; a++) {
    int n = n_lines[a];
    height[2 * a] = 2.0 * (line[a][1] - line[a][0]);
    height[2 * a + 1] = 2.0 * (line[a][n - 1] - line[a][n - 2]);
  }
}

static int *tensor_boxes(const int n_lines[3], int n_boxes, tsi_arena *arena) {
  int *box = tsi_arena_new(arena, 6 * (size_t)n_boxes, sizeof *box);
  int *at = box;
  if (!box)
    return NULL;
  for (int k = 0; k + 1 < n_lines[2]; k++)
    for (int j = 0; j + 1 < n_lines[1]; j++)
      for (int i = 0; i + 1 < n_lines[0]; i++) {
        int row[6] = {i, j, k, i + 1, j + 1, k + 1};
        memcpy(at, row, sizeof row);
        at += 6;
      }
  return box;
}

tsolid_status tsolid_tmesh_create(tsolid_context *context, const tsolid_boundary *boundary,
                                  const tsolid_tmesh_options *options, tsolid_tmesh **tmesh) {
  tsolid_status status = TSOLID_OK;
  if (!context || !boundary || !tmesh)
    return TSOLID_ERROR_ARGUMENT;
  *tmesh = NULL;
  int min_cells = options && options->min_cells ? options->min_cells : DEFAULT_MIN_CELLS;
  if (min_cells < 1 || min_cells > MAX_MIN_CELLS)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, STAGE,
                    "The least number of core cells per axis must be 1 to %d, not %d",
                    MAX_MIN_CELLS, min_cells);
  tsi_arena arena = tsi_arena_create(context);
  double *line[3] = {NULL, NULL, NULL};
  int n_lines[3];
  double n_cells = 1.0, height[6];
  for (int a = 0; a < 3; a++) {
    line[a] = axis_lines(boundary, a, min_cells, &arena, &n_lines[a]);
    if (!line[a]) {
      status = tsi_no_memory(context, STAGE);
      goto done;
    }
    n_cells *= n_lines[a] - 1;
  }
  if (n_cells > MAX_CORE_CELLS) {
    status = tsi_fail(context, TSOLID_ERROR_REFUSED, STAGE,
                      "The sides' knots ask for %.0f core cells, more than the %d that are taken; "
                      "give sides with fewer knots",
                      n_cells, MAX_CORE_CELLS);
    goto done;
  }
  choose_arm_heights(n_lines, line, height);
  int *box = tensor_boxes(n_lines, (int)n_cells, &arena);
  if (!box) {
    status = tsi_no_memory(context, STAGE);
    goto done;
  }
  status = tsi_tmesh_from_boxes(context, n_lines, (const double *const *)line, (int)n_cells, box,
                                height, tmesh);
done:
  tsi_arena_free(&arena);
  return status;
}
