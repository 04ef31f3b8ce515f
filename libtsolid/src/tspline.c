/* SPDX-License-Identifier: LGPL-2.1-or-later
 * T-spline patches: rows of functions along borders.
 *
 * Let M_0 = [0,...,0,t_1] be the function across a border that does not vanish on it. Where the
 * functions that do not vanish on the border are N_i(s) M_0(t), inserting knots into them alone,
 *
 *     sum_i c_i N_i(s) M_0(t) = sum_j c'_j N'_j(s) M_0(t),
 *
 * is univariate knot insertion in homogeneous points: exact, and all other functions stay. Sum one
 * and independence stay too: restricted to the border the N'_j are independent, and they are the
 * only ones there. A function N'_j only needs those N_i to have one M that it is a part of. */
#include <stdlib.h>

#include "bspline.h"
#include "tspline.h"

/* ---- tensor products ---------------------------------------------------------------------------
 */

static int new_row(tsi_arena *arena, int n, int degree, tsi_tspline_row *row) {
  row->n = n;
  row->knots = tsi_arena_new(arena, (size_t)(n + degree + 1), sizeof *row->knots);
  row->blend = tsi_arena_new(arena, (size_t)n, sizeof *row->blend);
  row->point = tsi_arena_new(arena, (size_t)n, sizeof *row->point);
  return row->knots && row->blend && row->point;
}

int tsi_tspline_from_patch(tsi_arena *arena, const tsi_patch *patch, int first_point,
                           tsi_tspline *tspline) {
  int n0 = patch->n[0], n1 = patch->n[1];
  *tspline = (tsi_tspline){.degree = {patch->degree[0], patch->degree[1]}, .n = n0 * n1};
  tspline->blend = tsi_arena_new(arena, (size_t)tspline->n, sizeof *tspline->blend);
  if (!tspline->blend)
    return 0;
  for (int j = 0; j < n1; j++)
    for (int i = 0; i < n0; i++)
      tspline->blend[i + n0 * j] = (tsi_blend){{i, j}, first_point + i + n0 * j};
  for (int d = 0; d < 2; d++) {
    tspline->knots[d] = patch->knots[d];
    tspline->n_knots[d] = patch->n[d] + patch->degree[d] + 1;
    for (int end = 0; end < 2; end++) {
      tsi_tspline_row *row = &tspline->row[d][end];
      int start = !end ? 0 : d ? n0 - 1 : n0 * (n1 - 1);
      if (!new_row(arena, patch->n[d], patch->degree[d], row))
        return 0;
      memcpy(row->knots, patch->knots[d], (size_t)tspline->n_knots[d] * sizeof *row->knots);
      for (int m = 0; m < row->n; m++) {
        row->blend[m] = start + (d ? n0 * m : m);
        row->point[m] = first_point + row->blend[m];
      }
    }
  }
  return 1;
}

/* ---- finding rows ------------------------------------------------------------------------------
 */

static const double *local_knots(const tsi_tspline *tspline, int blend, int d) {
  return tspline->knots[d] + tspline->blend[blend].knot[d];
}

/* The function's value at an end of [0,1]: 0 when it vanishes there, 1 when it is one there, -1
 * for anything between. */
static int value_at_end(int degree, const double *knot, int end) {
  double x = end;
  int count = 0;
  for (int i = 0; i < degree + 2; i++)
    count += knot[i] == x;
  if (count > degree)
    return knot[end ? 0 : degree + 1] != x;
  return knot[0] < x && x < knot[degree + 1] ? -1 : 0;
}

typedef struct sorted_blend {
  const double *knot;
  int n, blend;
} sorted_blend;

static int compare_vectors(int n, const double *a, const double *b) {
  for (int i = 0; i < n; i++)
    if (a[i] != b[i])
      return a[i] < b[i] ? -1 : 1;
  return 0;
}

static int compare_blends(const void *a, const void *b) {
  const sorted_blend *p = a, *q = b;
  int order = compare_vectors(p->n, p->knot, q->knot);
  return order ? order : (p->blend > q->blend) - (p->blend < q->blend);
}

/* Whether local vectors in order are the windows of one clamped knot vector on [0,1]. */
static int is_clamped(int degree, int n, const sorted_blend *list) {
  if (n < degree + 1 || list[0].knot[degree] != 0.0 || list[0].knot[0] != 0.0 ||
      list[n - 1].knot[1] != 1.0 || list[n - 1].knot[degree + 1] != 1.0)
    return 0;
  for (int m = 1; m < n; m++)
    if (compare_vectors(degree + 1, list[m].knot, list[m - 1].knot + 1) != 0)
      return 0;
  return 1;
}

static int find_row(tsi_arena *arena, tsi_tspline *tspline, int along, int end,
                    sorted_blend *list) {
  tsi_tspline_row *row = &tspline->row[along][end];
  int p = tspline->degree[along], n = 0;
  memset(row, 0, sizeof *row);
  for (int b = 0; b < tspline->n; b++) {
    int value = value_at_end(tspline->degree[1 - along], local_knots(tspline, b, 1 - along), end);
    if (value == 0)
      continue;
    if (value < 0)
      return 1;
    list[n++] = (sorted_blend){local_knots(tspline, b, along), p + 2, b};
  }
  if (!n)
    return 1;
  qsort(list, (size_t)n, sizeof *list, compare_blends);
  if (!is_clamped(p, n, list))
    return 1;
  if (!new_row(arena, n, p, row))
    return 0;
  for (int m = 0; m < n; m++) {
    row->blend[m] = list[m].blend;
    row->point[m] = tspline->blend[list[m].blend].point;
    row->knots[m] = list[m].knot[0];
  }
  memcpy(row->knots + n, list[n - 1].knot + 1, (size_t)(p + 1) * sizeof *row->knots);
  return 1;
}

int tsi_tspline_find_rows(tsi_arena *arena, tsi_tspline *tspline) {
  sorted_blend *list = tsi_arena_new(arena, (size_t)tspline->n, sizeof *list);
  if (!list)
    return 0;
  for (int along = 0; along < 2; along++)
    for (int end = 0; end < 2; end++)
      if (!find_row(arena, tspline, along, end, list))
        return 0;
  return 1;
}

int tsi_tspline_orient(tsi_arena *arena, const tsi_tspline *from, const int flip[2], int swap,
                       tsi_tspline *tspline) {
  *tspline = (tsi_tspline){.n = from->n};
  tspline->blend = tsi_arena_new(arena, (size_t)from->n, sizeof *tspline->blend);
  if (!tspline->blend)
    return 0;
  for (int d = 0; d < 2; d++) {
    int e = swap ? 1 - d : d, n = from->n_knots[d], p = from->degree[d];
    tspline->degree[e] = p;
    tspline->n_knots[e] = n;
    tspline->knots[e] = tsi_arena_new(arena, (size_t)n, sizeof *tspline->knots[e]);
    if (!tspline->knots[e])
      return 0;
    memcpy(tspline->knots[e], from->knots[d], (size_t)n * sizeof *tspline->knots[e]);
    if (flip[d])
      tsi_knots_reverse(n, tspline->knots[e]);
    for (int b = 0; b < from->n; b++) {
      int at = from->blend[b].knot[d];
      tspline->blend[b].knot[e] = flip[d] ? n - at - (p + 2) : at;
      tspline->blend[b].point = from->blend[b].point;
    }
  }
  return tsi_tspline_find_rows(arena, tspline);
}

/* ---- refining rows -----------------------------------------------------------------------------
 */

/* Whether the B-spline with local knots `fine` has a positive part in the one with local knots
 * `coarse`, whose refinement has the knots of both: a window of that vector. */
static int is_part(int degree, const double *fine, const double *coarse) {
  double low = coarse[0], high = coarse[degree + 1];
  int n_low = 0, n_high = 0;
  if (fine[0] < low || fine[degree + 1] > high)
    return 0;
  for (int i = 0; i < degree + 2; i++) {
    n_low += (coarse[i] == low) - (fine[i] == low);
    n_high += (coarse[i] == high) - (fine[i] == high);
  }
  return n_low >= 0 && n_high >= 0;
}

/* The old function with the local knots `fine`, from *m on, or -1. Both stand in order. */
static int find_same(const tsi_tspline_row *row, int degree, const double *fine, int *m) {
  while (*m < row->n && compare_vectors(degree + 2, row->knots + *m, fine) < 0)
    ++*m;
  return *m < row->n && compare_vectors(degree + 2, row->knots + *m, fine) == 0 ? *m : -1;
}

int tsi_tspline_count_new(const tsi_tspline *tspline, int along, int end, int n, const double *to) {
  const tsi_tspline_row *row = &tspline->row[along][end];
  int count = 0, m = 0;
  for (int j = 1; j + 1 < n; j++)
    count += find_same(row, tspline->degree[along], to + j, &m) < 0;
  return count;
}

/* Where the functions across begin whose parts make fine function `to`, or -1 when they differ. */
static int find_across(const tsi_tspline *tspline, int along, int end, const double *to) {
  const tsi_tspline_row *row = &tspline->row[along][end];
  int across = 1 - along, found = -1;
  for (int m = 0; m < row->n; m++) {
    int at = tspline->blend[row->blend[m]].knot[across];
    if (!is_part(tspline->degree[along], to, row->knots + m) || at == found)
      continue;
    if (found >= 0 && compare_vectors(tspline->degree[across] + 2, tspline->knots[across] + at,
                                      tspline->knots[across] + found) != 0)
      return -1;
    found = at;
  }
  return found;
}

/* Appends the knots `to` to the pool; returns where they start, or -1. */
static int append_knots(tsi_arena *arena, tsi_tspline *tspline, int d, int n, const double *to) {
  int start = tspline->n_knots[d];
  if (start > TSI_MAX_COUNT - n)
    return -1;
  double *knots = tsi_arena_new(arena, (size_t)(start + n), sizeof *knots);
  if (!knots)
    return -1;
  memcpy(knots, tspline->knots[d], (size_t)start * sizeof *knots);
  memcpy(knots + start, to, (size_t)n * sizeof *knots);
  tspline->knots[d] = knots;
  tspline->n_knots[d] = start + n;
  return start;
}

int tsi_tspline_refine_row(tsi_arena *arena, tsi_tspline *tspline, int along, int end, int n,
                           const double *to, int first_point) {
  tsi_tspline_row old = tspline->row[along][end], *row = &tspline->row[along][end];
  int p = tspline->degree[along], m = 0, used = 0;
  for (int j = 1; j + 1 < n; j++)
    if (find_same(&old, p, to + j, &m) < 0 && find_across(tspline, along, end, to + j) < 0)
      return -1;
  int start = append_knots(arena, tspline, along, n + p + 1, to);
  tsi_blend *blend = tsi_arena_new(arena, (size_t)(tspline->n + n), sizeof *blend);
  unsigned char *dropped = tsi_arena_new(arena, (size_t)tspline->n, 1);
  int *number = tsi_arena_new(arena, (size_t)tspline->n, sizeof *number);
  if (start < 0 || !blend || !dropped || !number || !new_row(arena, n, p, row))
    return 0;
  memcpy(row->knots, to, (size_t)(n + p + 1) * sizeof *to);
  for (int i = 1; i + 1 < old.n; i++)
    dropped[old.blend[i]] = 1;
  m = 0;
  for (int j = 1; j + 1 < n; j++) { /* kept ones by their old number, new ones as -1 */
    int same = find_same(&old, p, to + j, &m);
    row->blend[j] = same < 0 ? -1 : old.blend[same];
    if (same >= 0)
      dropped[old.blend[same]] = 0;
  }
  row->blend[0] = old.blend[0];
  row->blend[n - 1] = old.blend[old.n - 1];
  int count = 0;
  for (int b = 0; b < tspline->n; b++)
    if (!dropped[b]) {
      number[b] = count;
      blend[count++] = tspline->blend[b];
    }
  blend[number[row->blend[0]]].knot[along] = start;
  blend[number[row->blend[n - 1]]].knot[along] = start + n - 1;
  *row = (tsi_tspline_row){n, row->knots, row->blend, row->point};
  tsi_tspline_row fine = *row;
  *row = old; /* find_across reads the old row and the old functions */
  for (int j = 0; j < n; j++) {
    if (fine.blend[j] >= 0) {
      fine.blend[j] = number[fine.blend[j]];
    } else {
      blend[count].knot[along] = start + j;
      blend[count].knot[1 - along] = find_across(tspline, along, end, to + j);
      blend[count].point = first_point + used++;
      fine.blend[j] = count++;
    }
    fine.point[j] = blend[fine.blend[j]].point;
  }
  *row = fine;
  for (int a = 0; a < 2; a++)
    for (int e = 0; e < 2; e++)
      for (int i = 0; (a != along || e != end) && i < tspline->row[a][e].n; i++)
        tspline->row[a][e].blend[i] = number[tspline->row[a][e].blend[i]];
  tspline->blend = blend;
  tspline->n = count;
  return 1;
}

/* ---- back to tensor products -------------------------------------------------------------------
 */

/* The local knots on [0,1]: one that lies outside of p equal ones on the end makes no difference
 * inside. 0: others do. */
static int clamp_local(const double *local, int degree, double *to) {
  for (int i = 0; i < degree + 2; i++)
    to[i] = local[i] < 0.0 ? 0.0 : local[i] > 1.0 ? 1.0 : local[i];
  return (local[0] >= 0.0 || (local[1] == 0.0 && local[degree] == 0.0)) &&
         (local[degree + 1] <= 1.0 || (local[1] == 1.0 && local[degree] == 1.0));
}

/* Adds the local knots, all of one length, unless they are there. Returns their number then. */
static int add_vector(int n, int width, double *list, const double *local) {
  for (int i = 0; i < n; i++)
    if (memcmp(list + width * i, local, (size_t)width * sizeof *local) == 0)
      return n;
  memcpy(list + width * n, local, (size_t)width * sizeof *local);
  return n + 1;
}

/* The function of the clamped knots that has these local ones, or -1. */
static int find_place(int n, int degree, const double *knots, const double *local) {
  for (int i = 0; i < n; i++)
    if (memcmp(knots + i, local, (size_t)(degree + 2) * sizeof *local) == 0)
      return i;
  return -1;
}

/* The one knot vector whose functions are the distinct ones of direction d. 1, 0, -1 as below. */
static int find_clamped(tsi_arena *arena, const tsi_tspline *tspline, int d, tsi_patch *patch) {
  enum { MOST = 512 };
  int degree = tspline->degree[d], width = degree + 2, n = 0, at = 0, next;
  double local[TSI_MAX_DEGREE + 2];
  double *list = tsi_arena_new(arena, MOST * (size_t)width, sizeof *list);
  double *knots = tsi_arena_new(arena, MOST + (size_t)width, sizeof *knots);
  if (!list || !knots)
    return 0;
  for (int k = 0; k < tspline->n; k++) {
    if (n == MOST || !clamp_local(local_knots(tspline, k, d), degree, local))
      return -1;
    n = add_vector(n, width, list, local);
  }
  for (int i = 0; i < n; i++) /* the first starts with degree + 1 zeros */
    at = list[width * i + degree] == 0.0 ? i : at;
  memcpy(knots, list + width * at, (size_t)width * sizeof *knots);
  for (int i = 1; i < n; i++, at = next) {
    next = -1;
    for (int k = 0; k < n && next < 0; k++)
      if (k != at &&
          memcmp(list + width * k, list + width * at + 1, (size_t)(width - 1) * sizeof *list) == 0)
        next = k;
    if (next < 0)
      return -1;
    knots[i + width - 1] = list[width * next + width - 1];
  }
  patch->degree[d] = degree;
  patch->n[d] = n;
  patch->knots[d] = knots;
  return knots[0] == 0.0 && knots[degree] == 0.0 && knots[n] == 1.0 && knots[n + degree] == 1.0
             ? 1
             : -1;
}

int tsi_tspline_to_patch(tsi_arena *arena, const tsi_tspline *tspline, const double *control,
                         tsi_patch *patch) {
  double local[2][TSI_MAX_DEGREE + 2];
  for (int d = 0; d < 2; d++) {
    int found = find_clamped(arena, tspline, d, patch);
    if (found <= 0)
      return found;
  }
  if ((double)patch->n[0] * patch->n[1] != (double)tspline->n)
    return -1;
  unsigned char *seen = tsi_arena_new(arena, (size_t)tspline->n, 1);
  patch->control = tsi_arena_new(arena, (size_t)tspline->n, 4 * sizeof *patch->control);
  if (!seen || !patch->control)
    return 0;
  for (int k = 0; k < tspline->n; k++) {
    int i[2];
    for (int d = 0; d < 2; d++) {
      clamp_local(local_knots(tspline, k, d), patch->degree[d], local[d]);
      i[d] = find_place(patch->n[d], patch->degree[d], patch->knots[d], local[d]);
      if (i[d] < 0)
        return -1;
    }
    size_t at = (size_t)i[0] + (size_t)patch->n[0] * (size_t)i[1];
    if (seen[at]++)
      return -1;
    memcpy(patch->control + 4 * at, control + 4 * (size_t)tspline->blend[k].point,
           4 * sizeof *control);
  }
  return 1;
}
