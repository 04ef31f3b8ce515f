/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Divisions of the classes of intervals of an assembly, where parts are told how many they have.
 *
 * An axis that is told N asks that the divisions of its intervals' classes sum up to N. Axes are
 * done one after the other, always the one with the fewest classes left open, and each gives its
 * open classes what they get: one each, and each further one where the pieces are longest. A sum
 * that cannot be reached contradicts the axes that have settled the other classes: one of them is
 * named. Classes of no such axis keep what they want. */
#include "hex_assembly.h"

static const char stage[] = "hexahedra";

static int told(const tsi_hex_member *member, int axis) {
  return member[axis / 3].options.divisions[axis % 3];
}

/* Sum of the settled classes and number of open intervals; *by: an axis that settled one. */
static int look_at(const tsi_hex_classes *c, int axis, const int *settled_by, double *sum,
                   int *by) {
  int open = 0;
  *sum = 0.0;
  *by = -1;
  for (int i = c->interval_start[axis]; i < c->interval_start[axis + 1]; i++) {
    int k = c->of[i];
    if (settled_by[k] < 0) {
      open++;
      continue;
    }
    *sum += c->pieces[k];
    *by = *by < 0 || settled_by[k] < *by ? settled_by[k] : *by;
  }
  return open;
}

static tsolid_status refuse(tsolid_context *context, const tsi_hex_member *member, int axis,
                            double sum, int by) {
  const tsi_hex_member *part = &member[axis / 3];
  int d = axis % 3;
  if (by >= 0)
    return tsi_fail(
        context, TSOLID_ERROR_REFUSED, stage,
        "Divisions contradict: %s is to have %d along %c, but %d along %c of %s lead to "
        "%.0f there",
        part->name, told(member, axis), 'x' + d, told(member, by), 'x' + by % 3,
        member[by / 3].name, sum);
  return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                  "%d divisions along %c of %s do not do: borders of faces and of its neighbours "
                  "divide it in %.0f or more",
                  told(member, axis), 'x' + d, part->name, sum);
}

/* How many intervals of the axis are of the class of its interval i. */
static int count_class(const tsi_hex_classes *c, int axis, int i) {
  int n = 0;
  for (int m = c->interval_start[axis]; m < c->interval_start[axis + 1]; m++)
    n += c->of[m] == c->of[i];
  return n;
}

static tsolid_status settle(tsolid_context *context, const tsi_hex_member *member,
                            tsi_hex_classes *c, int axis, int *settled_by) {
  double sum;
  int by, open = look_at(c, axis, settled_by, &sum, &by), first = c->interval_start[axis],
          end = c->interval_start[axis + 1];
  double left = told(member, axis) - sum - open;
  if (left < 0.0 || (open == 0 && left > 0.0))
    return refuse(context, member, axis, sum + open, by);
  for (int i = first; i < end; i++)
    if (settled_by[c->of[i]] < 0)
      c->pieces[c->of[i]] = 1.0;
  while (left > 0.0) {
    int best = -1;
    for (int i = first; i < end; i++) {
      int k = c->of[i];
      if (settled_by[k] < 0 && count_class(c, axis, i) <= left &&
          (best < 0 ||
           c->length[k] / c->pieces[k] > c->length[c->of[best]] / c->pieces[c->of[best]]))
        best = i;
    }
    if (best < 0)
      return refuse(context, member, axis, told(member, axis) - left, by);
    c->pieces[c->of[best]] += 1.0;
    left -= count_class(c, axis, best);
  }
  for (int i = first; i < end; i++)
    if (settled_by[c->of[i]] < 0)
      settled_by[c->of[i]] = axis;
  return TSOLID_OK;
}

tsolid_status tsi_hex_divide(tsolid_context *context, tsi_arena *arena,
                             const tsi_hex_member *member, tsi_hex_classes *c) {
  int *settled_by = tsi_arena_new(arena, (size_t)c->n_classes, sizeof *settled_by);
  unsigned char *done = tsi_arena_new(arena, (size_t)c->n_axes, 1);
  if (!settled_by || !done)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < c->n_classes; k++)
    settled_by[k] = -1;
  for (;;) {
    int best = -1, fewest = 0, by;
    double sum;
    for (int a = 0; a < c->n_axes; a++) {
      if (done[a] || !told(member, a))
        continue;
      int open = look_at(c, a, settled_by, &sum, &by);
      if (best < 0 || open < fewest) {
        best = a;
        fewest = open;
      }
    }
    if (best < 0)
      return TSOLID_OK;
    done[best] = 1;
    tsolid_status status = settle(context, member, c, best, settled_by);
    if (!status)
      status = tsi_progress(context, stage, 0.2);
    if (status)
      return status;
  }
}
