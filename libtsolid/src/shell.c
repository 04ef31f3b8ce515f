/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Patches in canonical position made to fit: belts, snapping.
 *
 * A *strip* is the interval of an axis that one patch covers; the *belt* of a strip is the closed
 * band of patches, on the four sides that carry the axis, that must share the degree along it (the
 * function at the end of a border changes with the degree, and it belongs to the border across
 * too). Knots are a matter of each seam alone: see refine_rows.c. Everything is visited in
 * canonical order. */
#include <stdio.h>
#include <stdlib.h>

#include "bspline.h"
#include "seams.h"

static const char stage[] = "boundary";

/* Knots of different patches closer than this are one knot. */
static const double knot_resolution = 1e-11;

static double max_of(double a, double b) {
  return a > b ? a : b;
}

/* ---- belts ------------------------------------------------------------------------------------
 */

/* The patches of the belt of a strip, side by side; `along` is the patch direction of the axis. */
typedef struct belt {
  int n;
  int *patch, *along;
} belt;

static int list_belt(const tsi_shell *shell, int axis, int strip, belt *b) {
  b->n = 0;
  for (int side = 0; side < 6; side++) {
    int s = tsi_side_s(side), t = tsi_side_t(side);
    if (s != axis && t != axis)
      continue;
    int along = t == axis, n_across = shell->n_strips[along ? s : t];
    for (int k = 0; k < n_across; k++) {
      int i = along ? k : strip, j = along ? strip : k;
      b->patch[b->n] = shell->first[side] + i + shell->n_strips[s] * j;
      b->along[b->n++] = along;
    }
  }
  return b->n;
}

/* The knots of a patch along a direction, whatever their order; none of Bezier elements. */
static double *knots_of(const tsi_shell *shell, int p, int along, int *n) {
  const tsi_patch *patch = &shell->patch[p];
  const tsi_tspline *tspline = &shell->tspline[p];
  *n = patch->n[0] ? patch->n[along] + patch->degree[along] + 1 : tspline->n_knots[along];
  return patch->n[0] ? patch->knots[along] : tspline->knots[along];
}

static int degree_of(const tsi_shell *shell, int p, int along) {
  return shell->patch[p].n[0] ? shell->patch[p].degree[along] : shell->tspline[p].degree[along];
}

static int belt_agrees(const tsi_shell *shell, const belt *b) {
  int n_first, n;
  const double *first = knots_of(shell, b->patch[0], b->along[0], &n_first);
  for (int k = 0; k < b->n; k++) {
    int a = b->along[k];
    const double *knots = knots_of(shell, b->patch[k], a, &n);
    if (!shell->patch[b->patch[k]].n[0] ||
        degree_of(shell, b->patch[k], a) != degree_of(shell, b->patch[0], b->along[0]) ||
        n != n_first || memcmp(knots, first, (size_t)n * sizeof *knots) != 0)
      return 0;
  }
  return 1;
}

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Replaces every inner knot by the least of the belt's knots in a chain of steps below
 * knot_resolution. Patches keep their own arrays. */
static tsolid_status merge_knots(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                 const belt *b, tsolid_preparation *preparation) {
  size_t n = 0, count = 0;
  int n_knots;
  for (int k = 0; k < b->n; k++) {
    knots_of(shell, b->patch[k], b->along[k], &n_knots);
    n += (size_t)n_knots;
  }
  double *all = tsi_arena_new(arena, n, sizeof *all), *least = tsi_arena_new(arena, n, sizeof *all);
  if (!all || !least)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < b->n; k++) {
    const double *knots = knots_of(shell, b->patch[k], b->along[k], &n_knots);
    if (n_knots)
      memcpy(all + count, knots, (size_t)n_knots * sizeof *all);
    count += (size_t)n_knots;
  }
  if (!n)
    return TSOLID_OK;
  qsort(all, n, sizeof *all, compare_doubles);
  for (size_t i = 0; i < n; i++) /* where the chain of all[i] begins */
    least[i] = i && all[i] - all[i - 1] <= knot_resolution ? least[i - 1] : all[i];
  for (int k = 0; k < b->n; k++) {
    double *knots = knots_of(shell, b->patch[k], b->along[k], &n_knots);
    for (int i = 0; i < n_knots; i++) {
      const double *at = bsearch(&knots[i], all, n, sizeof *all, compare_doubles);
      double to = at ? least[at - all] : knots[i];
      preparation->knot_merge = max_of(preparation->knot_merge, knots[i] - to);
      preparation->n_knots_merged += knots[i] != to;
      knots[i] = to;
    }
  }
  return TSOLID_OK;
}

static int count_equal(int n, const double *knots, int i) {
  int count = 1;
  while (i + count < n && knots[i + count] == knots[i])
    count++;
  return count;
}

/* Halves every span `times` times. Returns the number of knots. */
static int halve_spans(int n, double *knots, int times, double *work) {
  for (int r = 0; r < times; r++) {
    int count = 0;
    for (int i = 0; i < n; i++) {
      work[count++] = knots[i];
      double middle = i + 1 < n ? knots[i] + 0.5 * (knots[i + 1] - knots[i]) : knots[i];
      if (i + 1 < n && knots[i] < middle && middle < knots[i + 1])
        work[count++] = middle;
    }
    memcpy(knots, work, (size_t)count * sizeof *knots);
    n = count;
  }
  return n;
}

static tsolid_status refuse_belt(tsolid_context *context, const tsi_shell *shell, const belt *b,
                                 const char *why) {
  char name[TSI_NAME_SIZE];
  const tsi_facet *facet = &shell->facet[shell->place[b->patch[0]]->facet];
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = TSOLID_ENTITY_PATCH;
  finding.index[0] = facet->patch;
  return tsi_report(context, &finding, "The faces around the part with %s: %s",
                    tsi_name_facet(facet, name), why);
}

/* Raises a patch to `degree` and halves its spans. */
static tsolid_status refine_patch(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                  const belt *b, int k, int degree, int times) {
  tsi_patch *patch = &shell->patch[b->patch[k]];
  int a = b->along[k], raise = degree - patch->degree[a], n_knots, n_to = 0;
  const double *knots = knots_of(shell, b->patch[k], a, &n_knots);
  double room = (double)n_knots * (raise + 1) * (1 << times);
  if (room * patch->n[1 - a] > TSI_MAX_COUNT / 16)
    return refuse_belt(context, shell, b, "they need too many control points");
  double *to = tsi_arena_new(arena, (size_t)room, sizeof *to);
  double *work = tsi_arena_new(arena, (size_t)room, sizeof *work);
  if (!to || !work)
    return tsi_no_memory(context, stage);
  for (int i = 0, same; i < n_knots; i += same) {
    same = count_equal(n_knots, knots, i);
    for (int m = 0; m < same + raise; m++)
      to[n_to++] = knots[i];
  }
  n_to = halve_spans(n_to, to, times, work);
  if (!tsi_patch_refine(arena, patch, a, raise, n_to - degree - 1, to))
    return tsi_no_memory(context, stage);
  return TSOLID_OK;
}

/* Knots that were merged may stand too often now. */
static int is_torn(const tsi_shell *shell, int p, int along) {
  const tsi_patch *patch = &shell->patch[p];
  const double *knots = patch->knots[along];
  int degree = patch->degree[along], n = patch->n[along];
  for (int i = degree + 1; i < n; i++)
    if (knots[i] == knots[i + degree] || knots[i] == 0.0 || knots[i] == 1.0)
      return 1;
  return 0;
}

static tsolid_status unify_belt(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                const belt *b, const tsolid_boundary_options *options,
                                tsolid_preparation *preparation) {
  int agrees = belt_agrees(shell, b), belt_degree = 0;
  if (agrees && !options->refine_knots && !options->raise_degree)
    return TSOLID_OK;
  tsolid_status status = agrees ? TSOLID_OK : merge_knots(context, arena, shell, b, preparation);
  if (status)
    return status;
  for (int k = 0; k < b->n; k++) {
    int d = degree_of(shell, b->patch[k], b->along[k]);
    belt_degree = d > belt_degree ? d : belt_degree;
  }
  int degree = belt_degree + options->raise_degree;
  if (degree > TSI_MAX_DEGREE)
    return refuse_belt(context, shell, b, "the degree would rise above 25");
  for (int k = 0; !status && k < b->n; k++) {
    int p = b->patch[k], a = b->along[k];
    if (shell->tspline[p].n && degree_of(shell, p, a) != degree)
      return refuse_belt(context, shell, b,
                         "their degrees differ, and that of a T-spline patch cannot be raised");
    if (shell->tspline[p].n && !tsi_tspline_find_rows(arena, &shell->tspline[p]))
      return tsi_no_memory(context, stage); /* of the merged knots */
    if (!shell->patch[p].n[0])
      continue;
    if (is_torn(shell, p, a))
      return refuse_belt(context, shell, b,
                         "knots closer than 1e-11 of the range would tear the surface as one");
    preparation->n_degrees_raised += degree_of(shell, p, a) < belt_degree;
    status = refine_patch(context, arena, shell, b, k, degree, options->refine_knots);
  }
  return status;
}

tsolid_status tsi_shell_unify(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                              const tsolid_boundary_options *options,
                              tsolid_preparation *preparation) {
  belt b;
  b.patch = tsi_arena_new(arena, (size_t)shell->first[6], sizeof *b.patch);
  b.along = tsi_arena_new(arena, (size_t)shell->first[6], sizeof *b.along);
  if (!b.patch || !b.along)
    return tsi_no_memory(context, stage);
  preparation->refine_knots = options->refine_knots;
  preparation->raise_degree = options->raise_degree;
  for (int axis = 0; axis < 3; axis++)
    for (int strip = 0; strip < shell->n_strips[axis]; strip++) {
      list_belt(shell, axis, strip, &b);
      tsolid_status status = unify_belt(context, arena, shell, &b, options, preparation);
      if (status)
        return status;
    }
  return TSOLID_OK;
}

/* ---- snapping ----------------------------------------------------------------------------------
 */

static tsolid_status refuse_gap(tsolid_context *context, const tsi_shell *shell, const tsi_seam *s,
                                int m, double distance) {
  char name[2][TSI_BORDER_NAME_SIZE];
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  tsi_seam_name(shell, s, name, &finding);
  finding.has_point = 1;
  tsi_project_point(tsi_seam_point(shell, s, 0, m), finding.point);
  finding.measured = distance;
  finding.allowed = tsi_seam_tolerance(shell, s);
  return tsi_report(context, &finding,
                    "%s and %s differ by %.3g, more than the tolerance of %.3g, near (%.6g, %.6g, "
                    "%.6g)",
                    name[0], name[1], distance, finding.allowed, finding.point[0], finding.point[1],
                    finding.point[2]);
}

static tsolid_status check_gaps(tsolid_context *context, const tsi_shell *shell,
                                const tsi_seam *s) {
  double worst = -1.0;
  int at = 0, n = tsi_seam_has_rows(shell, s) ? tsi_seam_count(shell, s, 0) : 0;
  for (int m = 0; m < n; m++) {
    double distance =
        tsi_seam_distance(tsi_seam_point(shell, s, 0, m), tsi_seam_point(shell, s, 1, m));
    if (distance > worst) {
      worst = distance;
      at = m;
    }
  }
  if (worst <= tsi_seam_tolerance(shell, s))
    return TSOLID_OK;
  return refuse_gap(context, shell, s, at, worst);
}

/* -1, 0, 1 by the first values that differ; rows of interior control points. */
static int compare_rows(const tsi_shell *shell, const tsi_seam *s, int first, int end) {
  for (int m = first; m < end; m++) {
    const double *a = tsi_seam_point(shell, s, 0, m), *b = tsi_seam_point(shell, s, 1, m);
    for (int c = 0; c < 4; c++)
      if (a[c] != b[c])
        return a[c] < b[c] ? -1 : 1;
  }
  return 0;
}

static int is_fixed(const tsi_shell *shell, const tsi_seam *s, int which) {
  return shell->facet[shell->place[s->row[which].patch]->facet].fixed;
}

/* A fixed side stands, else the least. */
static double snap_points(const tsi_shell *shell, const tsi_seam *s, int first, int end) {
  int order = compare_rows(shell, s, first, end);
  int fixed = is_fixed(shell, s, 0) - is_fixed(shell, s, 1);
  double moved = 0.0;
  if (order && fixed)
    order = -fixed;
  for (int m = first; order && m < end; m++) {
    double *a = tsi_seam_point(shell, s, 0, m), *b = tsi_seam_point(shell, s, 1, m);
    moved = max_of(moved, tsi_seam_distance(a, b));
    memcpy(order < 0 ? b : a, order < 0 ? a : b, 4 * sizeof *a);
  }
  return moved;
}

static void record_move(const tsi_seam *s, double moved, tsolid_preparation *preparation) {
  double *slot =
      s->isoline >= 0 ? &preparation->snap[s->isoline] : &preparation->snap_inside[s->side];
  *slot = max_of(*slot, moved);
}

/* The control points at both ends of both rows of every seam: 4 per seam, rows of 4. */
static double *copy_corners(tsi_arena *arena, const tsi_shell *shell, int n, const tsi_seam *list) {
  double *corner = tsi_arena_new(arena, 16 * (size_t)n, sizeof *corner);
  for (int i = 0; corner && i < n; i++)
    for (int k = 0; k < 4 && tsi_seam_has_rows(shell, &list[i]); k++) {
      int m = k >> 1 ? tsi_seam_count(shell, &list[i], k & 1) - 1 : 0;
      memcpy(corner + 16 * i + 4 * k, tsi_seam_point(shell, &list[i], k & 1, m),
             4 * sizeof *corner);
    }
  return corner;
}

/* One control point at each vertex: the least of those of fixed patches if there are any, else of
 * all. What a fixed patch has given to a corner is fixed there, too. 0: no memory. */
static int snap_vertices(tsi_arena *arena, const tsi_shell *shell, int n, const tsi_seam *list) {
  unsigned char *fixed = tsi_arena_new(arena, 4 * (size_t)shell->first[6], 1);
  if (!fixed)
    return 0;
  for (int p = 0; p < 4 * shell->first[6]; p++)
    fixed[p] = shell->facet[shell->place[p / 4]->facet].fixed != 0;
  for (int changed = 1; changed;) {
    changed = 0;
    for (int i = 0; i < n; i++)
      for (int k = 0; k < 2 && tsi_seam_has_rows(shell, &list[i]); k++) {
        const tsi_seam *s = &list[i];
        int m = k ? tsi_seam_count(shell, s, 0) - 1 : 0;
        double *point[2] = {tsi_seam_point(shell, s, 0, m), tsi_seam_point(shell, s, 1, m)};
        unsigned char *at[2];
        for (int w = 0; w < 2; w++)
          at[w] = &fixed[4 * s->row[w].patch + tsi_seam_corner(s, w, k)];
        int order = compare_rows(shell, s, m, m + 1);
        int from = *at[0] != *at[1] ? !*at[0] : order > 0;
        changed |= order != 0 || *at[0] != *at[1];
        *at[1 - from] = *at[from];
        if (order)
          memcpy(point[1 - from], point[from], 4 * sizeof(double));
      }
  }
  return 1;
}

tsolid_status tsi_shell_snap(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                             tsolid_preparation *preparation) {
  int n;
  tsi_seam *list = tsi_seams_list(arena, shell, &n);
  double *corner = list ? copy_corners(arena, shell, n, list) : NULL;
  if (!corner)
    return tsi_no_memory(context, stage);
  tsolid_status status = TSOLID_OK;
  int n_gaps = 0;
  for (int i = 0; i < n && n_gaps < 20; i++)
    if (check_gaps(context, shell, &list[i])) {
      status = TSOLID_ERROR_REFUSED;
      n_gaps++;
    }
  if (status)
    return status;
  for (int i = 0; i < n; i++) {
    if (!tsi_seam_has_rows(shell, &list[i]))
      continue;
    double moved = snap_points(shell, &list[i], 1, tsi_seam_count(shell, &list[i], 0) - 1);
    record_move(&list[i], moved, preparation);
  }
  if (!snap_vertices(arena, shell, n, list))
    return tsi_no_memory(context, stage);
  for (int i = 0; i < n; i++)
    for (int k = 0; k < 4 && tsi_seam_has_rows(shell, &list[i]); k++) {
      const tsi_seam *s = &list[i];
      int m = k >> 1 ? tsi_seam_count(shell, s, 0) - 1 : 0;
      record_move(s, tsi_seam_distance(corner + 16 * i + 4 * k, tsi_seam_point(shell, s, k & 1, m)),
                  preparation);
    }
  return TSOLID_OK;
}
