/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Patches in canonical position made to fit: belts, snapping.
 *
 * A *strip* is the interval of an axis that one patch covers; the *belt* of a strip is the closed
 * band of patches, on the four sides that carry the axis, that must share degree and knots along
 * it. Everything is visited in canonical order. */
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

static int n_knots_of(const tsi_patch *patch, int along) {
  return patch->n[along] + patch->degree[along] + 1;
}

static int belt_agrees(const tsi_shell *shell, const belt *b) {
  const tsi_patch *first = &shell->patch[b->patch[0]];
  int a0 = b->along[0];
  for (int k = 1; k < b->n; k++) {
    const tsi_patch *patch = &shell->patch[b->patch[k]];
    int a = b->along[k];
    if (patch->degree[a] != first->degree[a0] || patch->n[a] != first->n[a0] ||
        memcmp(patch->knots[a], first->knots[a0], (size_t)n_knots_of(patch, a) * sizeof(double)) !=
            0)
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
  for (int k = 0; k < b->n; k++)
    n += (size_t)n_knots_of(&shell->patch[b->patch[k]], b->along[k]);
  double *all = tsi_arena_new(arena, n, sizeof *all);
  if (!all)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < b->n; k++) {
    const tsi_patch *patch = &shell->patch[b->patch[k]];
    int a = b->along[k];
    memcpy(all + count, patch->knots[a], (size_t)n_knots_of(patch, a) * sizeof *all);
    count += (size_t)n_knots_of(patch, a);
  }
  qsort(all, n, sizeof *all, compare_doubles);
  for (int k = 0; k < b->n; k++) {
    tsi_patch *patch = &shell->patch[b->patch[k]];
    int a = b->along[k], n_knots = n_knots_of(patch, a);
    size_t at = 0, least = 0; /* all[least] begins the chain of all[at] */
    for (int i = 0; i < n_knots; i++) {
      double x = patch->knots[a][i];
      while (all[at] < x) {
        at++;
        if (all[at] - all[at - 1] > knot_resolution)
          least = at;
      }
      preparation->knot_merge = max_of(preparation->knot_merge, x - all[least]);
      patch->knots[a][i] = all[least];
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

/* Least common refinement: the distinct knots of all patches, each as often as the patch needs it
 * most once its degree is `degree`. Returns the number of knots; `to` has room for them. */
static int unite_knots(const tsi_shell *shell, const belt *b, int degree, int capacity, double *to,
                       int *cursor) {
  int n_to = 0;
  memset(cursor, 0, (size_t)b->n * sizeof *cursor);
  for (;;) {
    double x = INFINITY;
    int multiplicity = 0;
    for (int k = 0; k < b->n; k++) {
      const tsi_patch *patch = &shell->patch[b->patch[k]];
      if (cursor[k] < n_knots_of(patch, b->along[k]))
        x = fmin(x, patch->knots[b->along[k]][cursor[k]]);
    }
    if (isinf(x))
      return n_to;
    for (int k = 0; k < b->n; k++) {
      const tsi_patch *patch = &shell->patch[b->patch[k]];
      int a = b->along[k], n = n_knots_of(patch, a);
      if (cursor[k] >= n || patch->knots[a][cursor[k]] != x)
        continue;
      int own = count_equal(n, patch->knots[a], cursor[k]);
      cursor[k] += own;
      own += degree - patch->degree[a];
      multiplicity = own > multiplicity ? own : multiplicity;
    }
    for (int m = 0; m < multiplicity && n_to < capacity; m++)
      to[n_to++] = x;
  }
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
  int k = shell->place[b->patch[0]]->facet;
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = TSOLID_ENTITY_PATCH;
  finding.index[0] = k;
  return tsi_report(context, &finding, "The faces around the part with %s: %s",
                    tsi_name_patch(shell->facet[k].name, k, name), why);
}

/* Refines every patch of the belt to the knots `to` at `degree`, and counts what that took: of
 * the knots only the first n_united, before spans were halved. */
static tsolid_status refine_belt(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                 const belt *b, int degree, int belt_degree, int n_united, int n_to,
                                 const double *to, tsolid_preparation *preparation) {
  for (int k = 0; k < b->n; k++) {
    tsi_patch *patch = &shell->patch[b->patch[k]];
    int a = b->along[k], raise = degree - patch->degree[a], n_knots = n_knots_of(patch, a);
    if ((double)patch->n[1 - a] * n_to > TSI_MAX_COUNT / 16)
      return refuse_belt(context, shell, b, "they need too many control points together");
    int n_distinct = 0;
    for (int i = 0; i < n_knots; i += count_equal(n_knots, patch->knots[a], i))
      n_distinct++;
    preparation->n_knots_inserted += n_united - (n_knots + raise * n_distinct);
    preparation->n_degrees_raised += patch->degree[a] < belt_degree;
    if (!tsi_patch_refine(arena, patch, a, raise, n_to - degree - 1, to))
      return tsi_no_memory(context, stage);
  }
  return TSOLID_OK;
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
    int d = shell->patch[b->patch[k]].degree[b->along[k]];
    belt_degree = d > belt_degree ? d : belt_degree;
  }
  int degree = belt_degree + options->raise_degree;
  if (degree > TSI_MAX_DEGREE)
    return refuse_belt(context, shell, b, "the degree would rise above 25");
  double room = 1.0;
  for (int k = 0; k < b->n; k++) {
    const tsi_patch *patch = &shell->patch[b->patch[k]];
    int a = b->along[k];
    room += (double)n_knots_of(patch, a) * (degree + 1 - patch->degree[a]);
  }
  room *= (double)(1 << options->refine_knots);
  if (room > TSI_MAX_COUNT / 16)
    return refuse_belt(context, shell, b, "they need too many knots together");
  double *to = tsi_arena_new(arena, (size_t)room, sizeof *to);
  double *work = tsi_arena_new(arena, (size_t)room, sizeof *work);
  int *cursor = tsi_arena_new(arena, (size_t)b->n, sizeof *cursor);
  if (!to || !work || !cursor)
    return tsi_no_memory(context, stage);
  int n_united = unite_knots(shell, b, degree, (int)room, to, cursor);
  for (int i = degree + 1; i < n_united - degree - 1; i++)
    if (count_equal(n_united, to, i) > degree)
      return refuse_belt(context, shell, b,
                         "knots closer than 1e-11 of the range would tear the surface as one");
  int n_to = halve_spans(n_united, to, options->refine_knots, work);
  return refine_belt(context, arena, shell, b, degree, belt_degree, n_united, n_to, to,
                     preparation);
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
  tsi_seam_project(tsi_seam_point(shell, s, 0, m), finding.point);
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
  int at = 0;
  for (int m = 0; m < tsi_seam_count(shell, s, 0); m++) {
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

static double snap_points(const tsi_shell *shell, const tsi_seam *s, int first, int end) {
  int order = compare_rows(shell, s, first, end);
  double moved = 0.0;
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

/* Corner control points of all patches before snapping: 4 per patch, rows of 4. */
static double *copy_corners(tsi_arena *arena, const tsi_shell *shell) {
  double *corner = tsi_arena_new(arena, 16 * (size_t)shell->first[6], sizeof *corner);
  for (int p = 0; corner && p < shell->first[6]; p++) {
    const tsi_patch *patch = &shell->patch[p];
    for (int k = 0; k < 4; k++) {
      size_t i = k & 1 ? (size_t)patch->n[0] - 1 : 0, j = k & 2 ? (size_t)patch->n[1] - 1 : 0;
      memcpy(corner + 16 * p + 4 * k, patch->control + 4 * (i + (size_t)patch->n[0] * j),
             4 * sizeof *corner);
    }
  }
  return corner;
}

tsolid_status tsi_shell_snap(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                             tsolid_preparation *preparation) {
  int n;
  tsi_seam *list = tsi_seams_list(arena, shell, &n);
  double *corner = copy_corners(arena, shell);
  if (!list || !corner)
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
    double moved = snap_points(shell, &list[i], 1, tsi_seam_count(shell, &list[i], 0) - 1);
    record_move(&list[i], moved, preparation);
  }
  for (int changed = 1; changed;) { /* the least candidate goes round each vertex */
    changed = 0;
    for (int i = 0; i < n; i++)
      for (int k = 0; k < 2; k++) {
        int m = k ? tsi_seam_count(shell, &list[i], 0) - 1 : 0;
        changed |= compare_rows(shell, &list[i], m, m + 1) != 0;
        snap_points(shell, &list[i], m, m + 1);
      }
  }
  for (int i = 0; i < n; i++)
    for (int k = 0; k < 4; k++) {
      const tsi_seam *s = &list[i];
      int which = k & 1, high = k >> 1, at = tsi_seam_corner(s, which, high);
      int m = high ? tsi_seam_count(shell, s, 0) - 1 : 0;
      record_move(s,
                  tsi_seam_distance(corner + 16 * s->row[which].patch + 4 * at,
                                    tsi_seam_point(shell, s, which, m)),
                  preparation);
    }
  return TSOLID_OK;
}
