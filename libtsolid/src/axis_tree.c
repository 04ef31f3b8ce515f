/* SPDX-License-Identifier: LGPL-2.1-or-later
 * One binary tree of values per axis, from the T-junctions of the four sides that carry it.
 *
 * Source: Zhang, Wang, Hughes (2012), section 3: the T-junctions are the corners of the sides'
 * Bezier elements, and an interval is split at the T-junction value nearest its middle. One tree
 * per axis, not one per cell, so that neighbours split at the same place. Values much closer than
 * their neighbours are taken together: inner lines are free (conformity does not depend on them),
 * and two planes 1e-12 apart would give slopes of 1e12. */
#include "axis_tree.h"

#include <stdlib.h>

/* Two values closer than this fraction of the wider neighbouring gap become one. */
static const double MERGE_FRACTION = 1.0 / 20.0;

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* All element borders of the four sides along `axis`; *n of them. */
static double *collect_values(const tsolid_boundary *boundary, int axis, tsi_arena *arena, int *n) {
  size_t room = 0, count = 0;
  for (int side = 0; side < 6; side++)
    if (tsi_side_axis(side) != axis)
      room += 2 * (size_t)boundary->side[side].n_elements;
  double *value = tsi_arena_new(arena, room, sizeof *value);
  for (int side = 0; side < 6 && value; side++) {
    if (tsi_side_axis(side) == axis)
      continue;
    const tsi_side *s = &boundary->side[side];
    size_t first = tsi_side_s(side) == axis ? 0 : 2;
    for (size_t e = 0; e < (size_t)s->n_elements; e++) {
      value[count++] = s->box[4 * e + first];
      value[count++] = s->box[4 * e + first + 1];
    }
  }
  *n = (int)count;
  return value;
}

/* The values and both ends, ascending and distinct; *n_lines of them. */
static double *sort_lines(int n, const double *value, tsi_arena *arena, int *n_lines) {
  size_t count = 2 + (size_t)n, unique = 1;
  double *line = tsi_arena_new(arena, count, sizeof *line);
  if (!line)
    return NULL;
  line[1] = 1.0;
  if (n)
    memcpy(line + 2, value, (size_t)n * sizeof *line);
  qsort(line, count, sizeof *line, compare_doubles);
  for (size_t i = 1; i < count; i++)
    if (line[i] > line[unique - 1])
      line[unique++] = line[i];
  *n_lines = (int)unique;
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

/* Splits the interval between values `first` and `last` down to neighbours; returns the node. */
static int grow_tree(tsi_axis_tree *tree, int first, int last, int level) {
  int node = tree->n_nodes++;
  tree->node[node] = (tsi_interval){first, last, level, {-1, -1}};
  if (last - first < 2)
    return node;
  double middle = 0.5 * (tree->value[first] + tree->value[last]);
  int nearest = first + 1;
  for (int i = first + 2; i < last; i++)
    if (fabs(tree->value[i] - middle) < fabs(tree->value[nearest] - middle))
      nearest = i;
  int low = grow_tree(tree, first, nearest, level + 1);
  int high = grow_tree(tree, nearest, last, level + 1);
  tree->node[node].child[0] = low;
  tree->node[node].child[1] = high;
  return node;
}

int tsi_axis_tree_from_values(int n_values, const double *values, int min_cells, tsi_arena *arena,
                              tsi_axis_tree *tree) {
  int n;
  double *found = sort_lines(n_values, values, arena, &n);
  if (!found)
    return 0;
  n = merge_lines(found, n);
  tree->value = tsi_arena_new(arena, (size_t)n + 2 * (size_t)min_cells + 2, sizeof(double));
  if (!tree->value)
    return 0;
  memcpy(tree->value, found, (size_t)n * sizeof *found);
  if (n == 2) { /* nothing inside: equal parts */
    for (int i = 0; i <= min_cells; i++)
      tree->value[i] = (double)i / min_cells;
    n = min_cells + 1;
  }
  tree->n_values = split_widest(tree->value, n, min_cells, n, found);
  tree->node = tsi_arena_new(arena, 2 * (size_t)tree->n_values, sizeof *tree->node);
  if (!tree->node)
    return 0;
  tree->n_nodes = 0;
  grow_tree(tree, 0, tree->n_values - 1, 0);
  return 1;
}

int tsi_axis_tree_create(const tsolid_boundary *boundary, int axis, int min_cells, tsi_arena *arena,
                         tsi_axis_tree *tree) {
  int n;
  double *value = collect_values(boundary, axis, arena, &n);
  return value && tsi_axis_tree_from_values(n, value, min_cells, arena, tree);
}

int tsi_interval_has_middle(const tsi_axis_tree *tree, int node) {
  const tsi_interval *i = &tree->node[node];
  return tree->value[i->last] - tree->value[i->first] > 1e-6;
}

int tsi_axis_tree_halve(tsi_axis_tree *tree, const unsigned char *marked, tsi_arena *arena) {
  int n_marked = 0, n = 0, old_nodes = tree->n_nodes;
  for (int i = 0; i < old_nodes; i++)
    n_marked += marked[i];
  size_t n_values = (size_t)tree->n_values;
  double *value = tsi_arena_new(arena, n_values + (size_t)n_marked, sizeof *value);
  int *moved = tsi_arena_new(arena, n_values, sizeof *moved); /* old value number -> new one */
  unsigned char *halved = tsi_arena_new(arena, n_values, 1);  /* the gap above a value */
  tsi_interval *node = tsi_arena_new(arena, (size_t)old_nodes + 2 * (size_t)n_marked, sizeof *node);
  if (!value || !moved || !halved || !node)
    return 0;
  for (int i = 0; i < old_nodes; i++)
    if (marked[i])
      halved[tree->node[i].first] = 1;
  for (int v = 0; v < tree->n_values; v++) {
    moved[v] = n;
    value[n++] = tree->value[v];
    if (halved[v])
      value[n++] = 0.5 * (tree->value[v] + tree->value[v + 1]);
  }
  memcpy(node, tree->node, (size_t)old_nodes * sizeof *node);
  for (int i = 0; i < old_nodes; i++) {
    node[i].first = moved[node[i].first];
    node[i].last = moved[node[i].last];
    for (int half = 0; marked[i] && half < 2; half++) {
      int first = node[i].first + half, child = tree->n_nodes++;
      node[child] = (tsi_interval){first, first + 1, node[i].level + 1, {-1, -1}};
      node[i].child[half] = child;
    }
  }
  tree->value = value;
  tree->n_values = n;
  tree->node = node;
  return 1;
}

int tsi_axis_tree_nearest(const tsi_axis_tree *tree, double x) {
  int low = 0, high = tree->n_values - 1;
  while (high - low > 1) {
    int middle = low + (high - low) / 2;
    if (tree->value[middle] <= x)
      low = middle;
    else
      high = middle;
  }
  return x - tree->value[low] <= tree->value[high] - x ? low : high;
}
