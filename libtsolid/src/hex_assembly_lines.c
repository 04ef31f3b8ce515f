/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Mesh lines that go through all parts of an assembly.
 *
 * A bond maps a piece of an axis of one part affinely onto a piece of an axis of another, once for
 * each of its two directions. Hard positions (borders of faces and of contacts) are carried over
 * until nothing new comes: then a bond pairs the intervals between them, one by one. Paired
 * intervals form classes, over any number of parts. A class has as many divisions as the most
 * demanding of its members wants, at places that are the mean of its members' own: so both sides
 * of every bond have the same lines, and a line ends nowhere but on the outer surface. A class that
 * meets itself the other way round has its lines symmetric. */
#include <stdlib.h>

#include "hex_assembly.h"

static const char stage[] = "hexahedra";

/* Positions this near are one: bonds are known to about 1e-11. Others must not be nearer than the
 * second: lines that are led on and on toward one place end there. */
static const double position_resolution = 1e-8, least_width = 1e-6;

enum { MOST_POSITIONS = 2000 };

typedef struct hard_list {
  int n, capacity;
  double *x;
} hard_list;

/* Direction of a bond: x on axis[0] from from[0] to to[0] is from[1] to to[1] on axis[1]. */
typedef struct link {
  int axis[2];
  double from[2], to[2];
} link;

typedef struct frame {
  tsi_arena *arena;
  int n_axes, n_links;
  hard_list *hard;
  link *link;
  int *link_start, *link_of; /* by axis: 2 * link + end */
  int n_todo, todo_capacity;
  struct todo {
    int axis;
    double x;
  } * todo;
} frame;

/* ---- hard positions ----------------------------------------------------------------------------
 */

/* The position at x, or the next above it, by bisection. */
static int find_position(const hard_list *list, double x) {
  int low = 0, high = list->n;
  while (low < high) {
    int middle = (low + high) / 2;
    if (list->x[middle] < x - position_resolution)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

static int is_there(const hard_list *list, double x) {
  int k = find_position(list, x);
  return k < list->n && list->x[k] <= x + position_resolution;
}

/* 0: no memory. */
static int reserve(tsi_arena *arena, void **list, int n, int *capacity, size_t size) {
  if (n < *capacity)
    return 1;
  int more = 2 * *capacity + 8;
  void *to = tsi_arena_new(arena, (size_t)more, size);
  if (!to)
    return 0;
  if (n)
    memcpy(to, *list, (size_t)n * size);
  *list = to;
  *capacity = more;
  return 1;
}

static tsolid_status insert(tsolid_context *context, frame *f, int axis, double x) {
  hard_list *list = &f->hard[axis];
  if (is_there(list, x))
    return TSOLID_OK;
  void *values = list->x, *todo = f->todo;
  if (!reserve(f->arena, &values, list->n, &list->capacity, sizeof *list->x) ||
      !reserve(f->arena, &todo, f->n_todo, &f->todo_capacity, sizeof *f->todo))
    return tsi_no_memory(context, stage);
  list->x = values;
  f->todo = todo;
  int at = find_position(list, x);
  memmove(list->x + at + 1, list->x + at, (size_t)(list->n - at) * sizeof *list->x);
  list->x[at] = x;
  list->n++;
  f->todo[f->n_todo].axis = axis;
  f->todo[f->n_todo++].x = x;
  return TSOLID_OK;
}

static tsolid_status insert_own(tsolid_context *context, frame *f, const tsi_hex_member *member) {
  for (int axis = 0; axis < f->n_axes; axis++) {
    const tsolid_hex_options *options = &member[axis / 3].options;
    tsolid_status status = insert(context, f, axis, 0.0);
    if (!status)
      status = insert(context, f, axis, 1.0);
    for (int k = 0; k < options->n_regions && !status; k++) {
      const tsolid_region *region = &options->regions[k];
      int along = axis % 3 == tsi_side_s(region->side) ? 0 : 1;
      for (int end = 0; end < 2 && tsi_side_axis(region->side) != axis % 3 && !status; end++)
        status = insert(context, f, axis, region->box[2 * along + end]);
    }
    if (status)
      return status;
  }
  for (int k = 0; k < f->n_links; k++)
    for (int end = 0; end < 2; end++) {
      const link *l = &f->link[k];
      tsolid_status status = insert(context, f, l->axis[end], l->from[end]);
      if (!status)
        status = insert(context, f, l->axis[end], l->to[end]);
      if (status)
        return status;
    }
  return TSOLID_OK;
}

static tsolid_status carry(tsolid_context *context, frame *f, const tsi_hex_member *member) {
  while (f->n_todo) {
    struct todo now = f->todo[--f->n_todo];
    for (int k = f->link_start[now.axis]; k < f->link_start[now.axis + 1]; k++) {
      const link *l = &f->link[f->link_of[k] / 2];
      int a = f->link_of[k] % 2, b = 1 - a;
      double share = (now.x - l->from[a]) / (l->to[a] - l->from[a]);
      if (!(share > 0.0 && share < 1.0))
        continue;
      tsolid_status status =
          insert(context, f, l->axis[b], l->from[b] + share * (l->to[b] - l->from[b]));
      if (status)
        return status;
      if (f->hard[l->axis[b]].n > MOST_POSITIONS)
        return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                        "Mesh lines between %s and %s multiply without end: the contacts around "
                        "them lead every line back to another place",
                        member[l->axis[a] / 3].name, member[l->axis[b] / 3].name);
    }
  }
  return TSOLID_OK;
}

static tsolid_status check_widths(tsolid_context *context, const frame *f,
                                  const tsi_hex_member *member) {
  for (int a = 0; a < f->n_axes; a++)
    for (int i = 1; i < f->hard[a].n; i++)
      if (f->hard[a].x[i] - f->hard[a].x[i - 1] < least_width)
        return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                        "Borders of faces and contacts lead to mesh lines of %s that are only %.1e "
                        "of its length apart",
                        member[a / 3].name, f->hard[a].x[i] - f->hard[a].x[i - 1]);
  return TSOLID_OK;
}

static tsolid_status index_links(tsolid_context *context, frame *f, int n_bonds,
                                 const tsi_bond *bond) {
  f->n_links = 2 * n_bonds;
  f->link = tsi_arena_new(f->arena, (size_t)f->n_links, sizeof *f->link);
  f->link_start = tsi_arena_new(f->arena, (size_t)f->n_axes + 1, sizeof *f->link_start);
  f->link_of = tsi_arena_new(f->arena, 2 * (size_t)f->n_links, sizeof *f->link_of);
  f->hard = tsi_arena_new(f->arena, (size_t)f->n_axes, sizeof *f->hard);
  int *next = tsi_arena_new(f->arena, (size_t)f->n_axes, sizeof *next);
  if (!f->link || !f->link_start || !f->link_of || !f->hard || !next)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < f->n_links; k++)
    for (int end = 0; end < 2; end++) {
      const tsi_bond *b = &bond[k / 2];
      f->link[k].axis[end] = 3 * b->part[end] + b->axis[end][k % 2];
      f->link[k].from[end] = b->from[end][k % 2];
      f->link[k].to[end] = b->to[end][k % 2];
      f->link_start[f->link[k].axis[end] + 1]++;
    }
  for (int k = 0; k < f->n_axes; k++) {
    f->link_start[k + 1] += f->link_start[k];
    next[k] = f->link_start[k];
  }
  for (int k = 0; k < 2 * f->n_links; k++)
    f->link_of[next[f->link[k / 2].axis[k % 2]]++] = k;
  return TSOLID_OK;
}

/* ---- classes -----------------------------------------------------------------------------------
 */

typedef struct forest {
  int *parent, *size;
  unsigned char *turned; /* against the parent */
} forest;

static int find_root(const forest *f, int k, int *turned) {
  for (*turned = 0; f->parent[k] != k; k = f->parent[k])
    *turned ^= f->turned[k];
  return k;
}

/* Returns 1 where both are of one class already and lie the other way round. */
static int unite(forest *f, int a, int b, int turned) {
  int turn[2], root[2] = {find_root(f, a, &turn[0]), find_root(f, b, &turn[1])};
  turned ^= turn[0] ^ turn[1];
  if (root[0] == root[1])
    return turned;
  int from = f->size[root[0]] < f->size[root[1]] ? 0 : 1;
  f->parent[root[from]] = root[1 - from];
  f->turned[root[from]] = (unsigned char)turned;
  f->size[root[1 - from]] += f->size[root[from]];
  return 0;
}

/* Pairs the intervals along a link; *mirrored collects roots that meet themselves. */
static int pair_intervals(const frame *f, const link *l, const tsi_hex_classes *c, forest *trees,
                          unsigned char *mirrored) {
  int at[2], end[2];
  for (int k = 0; k < 2; k++) {
    const hard_list *list = &f->hard[l->axis[k]];
    at[k] = find_position(list, l->from[k]);
    end[k] = find_position(list, l->to[k]);
  }
  int n = abs(end[0] - at[0]), turned = (end[0] < at[0]) != (end[1] < at[1]), unused;
  if (n != abs(end[1] - at[1]))
    return 0;
  for (int i = 0; i < n; i++) {
    int interval[2];
    for (int k = 0; k < 2; k++)
      interval[k] = c->interval_start[l->axis[k]] + (end[k] > at[k] ? at[k] + i : at[k] - i - 1);
    if (unite(trees, interval[0], interval[1], turned))
      mirrored[find_root(trees, interval[0], &unused)] = 1;
  }
  return 1;
}

static tsolid_status make_classes(tsolid_context *context, const frame *f,
                                  const tsi_hex_member *member, tsi_hex_classes *c) {
  tsi_arena *arena = f->arena;
  c->n_axes = f->n_axes;
  c->interval_start = tsi_arena_new(arena, (size_t)f->n_axes + 1, sizeof *c->interval_start);
  if (!c->interval_start)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < f->n_axes; k++)
    c->interval_start[k + 1] = c->interval_start[k] + f->hard[k].n - 1;
  size_t n = (size_t)c->interval_start[f->n_axes];
  forest trees = {tsi_arena_new(arena, n, sizeof(int)), tsi_arena_new(arena, n, sizeof(int)),
                  tsi_arena_new(arena, n, 1)};
  unsigned char *mirrored = tsi_arena_new(arena, n, 1);
  int *class_of = tsi_arena_new(arena, n, sizeof *class_of);
  c->of = tsi_arena_new(arena, n, sizeof *c->of);
  c->turned = tsi_arena_new(arena, n, 1);
  c->mirrored = tsi_arena_new(arena, n, 1);
  c->length = tsi_arena_new(arena, n, sizeof *c->length);
  c->pieces = tsi_arena_new(arena, n, sizeof *c->pieces);
  if (!trees.parent || !trees.size || !trees.turned || !mirrored || !class_of || !c->of ||
      !c->turned || !c->mirrored || !c->length || !c->pieces)
    return tsi_no_memory(context, stage);
  for (size_t k = 0; k < n; k++) {
    trees.parent[k] = (int)k;
    trees.size[k] = 1;
  }
  for (int k = 0; k < f->n_links; k++)
    if (!pair_intervals(f, &f->link[k], c, &trees, mirrored))
      return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                      "Lines of %s and %s lie too near to each other to be told apart",
                      member[f->link[k].axis[0] / 3].name, member[f->link[k].axis[1] / 3].name);
  for (size_t k = 0; k < n; k++)
    class_of[k] = trees.parent[k] == (int)k ? c->n_classes++ : -1;
  for (size_t k = 0; k < n; k++) {
    int turned, root = find_root(&trees, (int)k, &turned);
    c->of[k] = class_of[root];
    c->turned[k] = (unsigned char)turned;
    c->mirrored[c->of[k]] |= mirrored[k]; /* of a root that may have got a parent since */
  }
  return TSOLID_OK;
}

/* ---- positions ---------------------------------------------------------------------------------
 */

/* Samples all axes and puts what each class wants. */
static tsolid_status sample_axes(tsolid_context *context, const frame *f,
                                 const tsi_hex_member *member, tsi_hex_classes *c,
                                 tsi_hex_axis *axis) {
  for (int a = 0; a < f->n_axes; a++) {
    const tsi_hex_member *part = &member[a / 3];
    axis[a].n_hard = f->hard[a].n - 1;
    axis[a].hard = f->hard[a].x;
    tsolid_status status = tsi_hex_axis_sample(context, f->arena, part->solid, a % 3, &axis[a]);
    if (!status)
      status = tsi_progress(context, stage, 0.2 * a / f->n_axes);
    if (status)
      return status;
    for (int i = 0; i < axis[a].n_hard; i++) {
      int k = c->of[c->interval_start[a] + i];
      double length = tsi_hex_axis_longest(&axis[a], i);
      double pieces = ceil(length / part->options.size * (1.0 - 1e-9));
      if (!(pieces <= 1e6))
        return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                        "Elements of size %g are too many: %s is %g long", part->options.size,
                        part->name, length);
      c->length[k] = fmax(c->length[k], length);
      c->pieces[k] = fmax(c->pieces[k], fmax(pieces, 1.0));
    }
  }
  return TSOLID_OK;
}

/* share[start[k] + i], i = 0 .. pieces: the mean of the members' own places. */
static void mean_shares(const tsi_hex_classes *c, const tsi_hex_axis *axis, const size_t *start,
                        int *n_members, double *share) {
  for (int a = 0; a < c->n_axes; a++)
    for (int i = 0; i < axis[a].n_hard; i++) {
      int at = c->interval_start[a] + i, k = c->of[at], n = (int)c->pieces[k];
      double low = axis[a].hard[i], width = axis[a].hard[i + 1] - low;
      n_members[k]++;
      for (int m = 0; m <= n; m++) {
        double own = (tsi_hex_axis_position(&axis[a], i, (double)m / n) - low) / width;
        share[start[k] + (size_t)(c->turned[at] ? n - m : m)] += c->turned[at] ? 1.0 - own : own;
      }
    }
  for (int k = 0; k < c->n_classes; k++) {
    int n = (int)c->pieces[k];
    double *x = share + start[k];
    for (int m = 0; m <= n; m++)
      x[m] /= n_members[k];
    x[0] = 0.0;
    x[n] = 1.0;
    for (int m = 0; c->mirrored[k] && 2 * m <= n; m++) {
      double mean = 0.5 * (x[m] + (1.0 - x[n - m]));
      x[m] = mean;
      x[n - m] = 1.0 - mean;
    }
  }
}

static tsolid_status place_axis(tsolid_context *context, tsi_arena *arena, const tsi_hex_classes *c,
                                const tsi_hex_axis *axis, int a, const size_t *start,
                                const double *share, tsi_hex_lines *lines) {
  int order = lines->order, at = 0;
  double n = 0.0;
  for (int i = 0; i < axis->n_hard; i++)
    n += c->pieces[c->of[c->interval_start[a] + i]];
  if (!(n <= 1e6))
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "%.0f divisions are too many", n);
  lines->n[a % 3] = (int)n;
  double *x = lines->x[a % 3] = tsi_arena_new(arena, (size_t)order * (size_t)n + 1, sizeof *x);
  if (!x)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < axis->n_hard; i++) {
    int interval = c->interval_start[a] + i, k = c->of[interval], pieces = (int)c->pieces[k];
    double low = axis->hard[i], width = axis->hard[i + 1] - low;
    for (int m = 0; m < pieces; m++, at += order) {
      const double *s = share + start[k];
      x[at] = low + width * (c->turned[interval] ? 1.0 - s[pieces - m] : s[m]);
    }
  }
  x[at] = 1.0;
  for (int k = 1; order == 2 && k < at; k += 2)
    x[k] = 0.5 * (x[k - 1] + x[k + 1]);
  return TSOLID_OK;
}

static tsolid_status place_lines(tsolid_context *context, tsi_arena *arena, int n_parts,
                                 tsi_hex_member *member, const tsi_hex_classes *c,
                                 const tsi_hex_axis *axis) {
  size_t n = 0, *start = tsi_arena_new(arena, (size_t)c->n_classes, sizeof *start);
  for (int k = 0; start && k < c->n_classes; k++) {
    start[k] = n;
    n += (size_t)c->pieces[k] + 1;
  }
  double *share = tsi_arena_new(arena, n, sizeof *share);
  int *n_members = tsi_arena_new(arena, (size_t)c->n_classes, sizeof *n_members);
  if (!start || !share || !n_members)
    return tsi_no_memory(context, stage);
  mean_shares(c, axis, start, n_members, share);
  for (int p = 0; p < n_parts; p++) {
    tsolid_status status = tsi_hex_axis_lines(context, arena, member[p].solid, &member[p].options,
                                              3, &member[p].lines);
    for (int d = 0; d < 3 && !status; d++)
      status = place_axis(context, arena, c, &axis[3 * p + d], 3 * p + d, start, share,
                          &member[p].lines);
    if (status)
      return status;
  }
  return TSOLID_OK;
}

tsolid_status tsi_hex_assembly_lines(tsolid_context *context, tsi_arena *arena, int n_parts,
                                     tsi_hex_member *member, int n_bonds, const tsi_bond *bond) {
  frame f = {.arena = arena, .n_axes = 3 * n_parts};
  tsi_hex_classes classes = {0};
  tsi_hex_axis *axis = tsi_arena_new(arena, (size_t)f.n_axes, sizeof *axis);
  tsolid_status status = axis ? TSOLID_OK : tsi_no_memory(context, stage);
  if (!status)
    status = index_links(context, &f, n_bonds, bond);
  if (!status)
    status = insert_own(context, &f, member);
  if (!status)
    status = carry(context, &f, member);
  if (!status)
    status = check_widths(context, &f, member);
  if (!status)
    status = make_classes(context, &f, member, &classes);
  if (!status)
    status = sample_axes(context, &f, member, &classes, axis);
  if (!status)
    status = tsi_hex_divide(context, arena, member, &classes);
  if (!status)
    status = place_lines(context, arena, n_parts, member, &classes, axis);
  return status;
}
