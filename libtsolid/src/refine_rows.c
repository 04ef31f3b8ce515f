/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Seams whose sides have different knots: the union of both, inserted into the functions along the
 * seam alone (tspline.c says why that is exact).
 *
 * Two rows of a patch share the function at their common corner. Let N_0(s) M_0(t) be it, and let
 * the finer rows begin with N'_0 and M'_0. Where N'_0 = N_0 or M'_0 = M_0, all stays products: the
 * row along s becomes N'_j(s) M_0(t), the row along t N_0(s) M'_k(t), k > 0, and the corner N'_0(s)
 * M'_0(t). Where both differ, the corner would need functions of both signs. Since N_0 is told by
 * the knot nearest to the corner alone, one knot line across the patch, along whichever direction
 * has fewer functions to cross, makes them agree; the row at the other end of the line gets the
 * knot too, so this is done until nothing changes. */
#include <stdlib.h>

#include "bspline.h"
#include "seams.h"

static const char stage[] = "boundary";

int tsi_shell_add_points(tsi_arena *arena, tsi_shell *shell, int n) {
  int first = shell->n_control;
  if (n > TSI_MAX_COUNT / 4 - first)
    return -1;
  if (first + n > shell->control_capacity || !shell->control) {
    int capacity = 2 * (first + n) + 16;
    double *control = tsi_arena_new(arena, (size_t)capacity, 4 * sizeof *control);
    if (!control)
      return -1;
    if (first)
      memcpy(control, shell->control, 4 * (size_t)first * sizeof *control);
    shell->control = control;
    shell->control_capacity = capacity;
  }
  shell->n_control = first + n;
  return first;
}

/* ---- corners -----------------------------------------------------------------------------------
 */

/* The knot next to an end of a row. */
static double end_knot(const tsi_row *row, int high) {
  return row->knots[high ? row->n - 1 : row->degree + 1];
}

/* What it is once the row has the knots of both sides. */
static double united_end_knot(const tsi_shell *shell, const tsi_seam *s, int high) {
  tsi_row a = tsi_seam_row(shell, s, 0), b = tsi_seam_row(shell, s, 1);
  double x = end_knot(&a, high), y = end_knot(&b, high);
  return (x < y) == !high ? x : y;
}

/* The seam of every border: 4 per patch, [2 * along + end]. */
static int *map_seams(tsi_arena *arena, const tsi_shell *shell, int n, const tsi_seam *list) {
  int *seam_of = tsi_arena_new(arena, 4 * (size_t)shell->first[6], sizeof *seam_of);
  for (int i = 0; seam_of && i < n; i++)
    for (int k = 0; k < 2; k++)
      seam_of[4 * list[i].row[k].patch + 2 * list[i].row[k].along + list[i].row[k].end] = i;
  return seam_of;
}

static tsolid_status refuse_patch(tsolid_context *context, const tsi_shell *shell, int p,
                                  const char *why) {
  char name[TSI_NAME_SIZE];
  const tsi_facet *facet = &shell->facet[shell->place[p]->facet];
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = TSOLID_ENTITY_PATCH;
  finding.index[0] = facet->patch;
  return tsi_report(context, &finding, "%s %s", tsi_name_facet(facet, name), why);
}

/* One knot line more across a NURBS patch. */
static tsolid_status insert_line(tsolid_context *context, tsi_arena *arena, tsi_shell *shell, int p,
                                 int along, double x) {
  tsi_patch *patch = &shell->patch[p];
  int n_knots = patch->n[along] + patch->degree[along] + 1, count = 0;
  if (!patch->n[0])
    return refuse_patch(context, shell, p,
                        "is a T-spline patch that needs new knots on two borders that meet");
  if ((double)(patch->n[along] + 1) * patch->n[1 - along] > TSI_MAX_COUNT / 16)
    return refuse_patch(context, shell, p, "needs too many control points beside its neighbours");
  double *to = tsi_arena_new(arena, (size_t)n_knots + 1, sizeof *to);
  if (!to)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < n_knots; i++) {
    if (count == i && patch->knots[along][i] > x)
      to[count++] = x;
    to[count++] = patch->knots[along][i];
  }
  return tsi_patch_refine(arena, patch, along, 0, patch->n[along] + 1, to)
             ? TSOLID_OK
             : tsi_no_memory(context, stage);
}

/* One corner of a patch, bit 0: u high, bit 1: v high. *changed: a line was inserted. */
static tsolid_status settle_corner(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                   const tsi_seam *list, const int *seam_of, int p, int corner,
                                   tsolid_preparation *preparation, int *changed) {
  double own[2], united[2];
  int n[2];
  for (int along = 0; along < 2; along++) {
    int high = corner >> along & 1, end = corner >> (1 - along) & 1;
    const tsi_seam *s = &list[seam_of[4 * p + 2 * along + end]];
    if (!tsi_seam_has_rows(shell, s))
      return TSOLID_OK;
    int which = s->row[1].patch == p && s->row[1].along == along && s->row[1].end == end;
    tsi_row row = tsi_seam_row(shell, s, which);
    own[along] = end_knot(&row, high);
    united[along] = united_end_knot(shell, s, high);
    n[along] = row.n;
  }
  if (own[0] == united[0] || own[1] == united[1])
    return TSOLID_OK;
  int along = n[0] < n[1]; /* a line of constant u crosses the n[1] functions along v */
  *changed = 1;
  preparation->n_knots_inserted++;
  return insert_line(context, arena, shell, p, along, united[along]);
}

static tsolid_status settle_corners(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                    int n, const tsi_seam *list, tsolid_preparation *preparation) {
  int *seam_of = map_seams(arena, shell, n, list);
  if (!seam_of)
    return tsi_no_memory(context, stage);
  for (int changed = 1; changed;) {
    changed = 0;
    for (int p = 0; p < shell->first[6]; p++)
      for (int corner = 0; corner < 4; corner++) {
        tsolid_status status =
            settle_corner(context, arena, shell, list, seam_of, p, corner, preparation, &changed);
        if (status)
          return status;
      }
  }
  return TSOLID_OK;
}

/* ---- rows --------------------------------------------------------------------------------------
 */

/* Least common refinement of two rows of one degree: the knots of both, each as often as the row
 * has it more often. Returns the number of knots; `to` has room for all. */
static int unite_knots(const tsi_row *a, const tsi_row *b, double *to) {
  int n_a = a->n + a->degree + 1, n_b = b->n + b->degree + 1, i = 0, j = 0, n = 0;
  while (i < n_a || j < n_b) {
    double x = i < n_a ? a->knots[i] : INFINITY, y = j < n_b ? b->knots[j] : INFINITY;
    to[n++] = x < y ? x : y;
    i += x <= y;
    j += y <= x;
  }
  return n;
}

static tsolid_status refine_row(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                const tsi_seam *s, int which, int n_knots, const double *to,
                                tsolid_preparation *preparation) {
  int p = s->row[which].patch, along = s->row[which].along, end = s->row[which].end;
  tsi_tspline *tspline = &shell->tspline[p];
  tsi_row row = tsi_seam_row(shell, s, which);
  int n = n_knots - row.degree - 1;
  if (n == row.n)
    return TSOLID_OK;
  double *fine = tsi_arena_new(arena, (size_t)n, 4 * sizeof *fine);
  int n_new = tsi_tspline_count_new(tspline, along, end, n, to);
  int first = tsi_shell_add_points(arena, shell, n_new);
  if (!fine || first < 0)
    return tsi_no_memory(context, stage);
  row = tsi_seam_row(shell, s, which);
  for (int m = 0; m < row.n; m++)
    memcpy(fine + 4 * m, tsi_row_point(&row, m), 4 * sizeof *fine);
  tsi_bspline_insert(row.degree, row.n, row.knots, n, to, 4, fine);
  preparation->n_knots_inserted += n - row.n;
  int done = tsi_tspline_refine_row(arena, tspline, along, end, n, to, first);
  if (done < 0)
    return refuse_patch(context, shell, p,
                        "is a T-spline patch with knots that change along a border where its "
                        "neighbour has knots that it has not");
  if (!done)
    return tsi_no_memory(context, stage);
  row = tsi_seam_row(shell, s, which);
  for (int m = 0; m < n; m++)
    if (row.at[m] >= first)
      memcpy(shell->control + 4 * (size_t)row.at[m], fine + 4 * m, 4 * sizeof *fine);
  return TSOLID_OK;
}

static tsolid_status refine_seam(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                 const tsi_seam *s, tsolid_preparation *preparation) {
  tsi_row row[2] = {tsi_seam_row(shell, s, 0), tsi_seam_row(shell, s, 1)};
  if (!tsi_seam_has_rows(shell, s))
    return TSOLID_OK;
  if (row[0].n == row[1].n && row[0].degree == row[1].degree &&
      memcmp(row[0].knots, row[1].knots, (size_t)(row[0].n + row[0].degree + 1) * sizeof(double)) ==
          0)
    return TSOLID_OK;
  double *to =
      tsi_arena_new(arena, (size_t)(row[0].n + row[1].n + 2 * row[0].degree + 2), sizeof *to);
  if (!to)
    return tsi_no_memory(context, stage);
  int n_knots = unite_knots(&row[0], &row[1], to);
  tsolid_status status = TSOLID_OK;
  for (int k = 0; !status && k < 2; k++)
    status = refine_row(context, arena, shell, s, k, n_knots, to, preparation);
  return status;
}

static tsolid_status make_tsplines(tsolid_context *context, tsi_arena *arena, tsi_shell *shell) {
  for (int p = 0; p < shell->first[6]; p++) {
    tsi_patch *patch = &shell->patch[p];
    if (!patch->n[0])
      continue;
    int n = patch->n[0] * patch->n[1], first = tsi_shell_add_points(arena, shell, n);
    if (first < 0)
      return tsi_no_memory(context, stage);
    memcpy(shell->control + 4 * (size_t)first, patch->control, 4 * (size_t)n * sizeof(double));
    if (!tsi_tspline_from_patch(arena, patch, first, &shell->tspline[p]))
      return tsi_no_memory(context, stage);
  }
  return TSOLID_OK;
}

tsolid_status tsi_shell_refine_rows(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                    tsolid_preparation *preparation) {
  int n;
  tsi_seam *list = tsi_seams_list(arena, shell, &n);
  if (!list)
    return tsi_no_memory(context, stage);
  tsolid_status status = settle_corners(context, arena, shell, n, list, preparation);
  if (!status)
    status = make_tsplines(context, arena, shell);
  for (int i = 0; !status && i < n; i++)
    status = refine_seam(context, arena, shell, &list[i], preparation);
  return status;
}
