/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Where patches are to be cut so that none has a corner of another inside its border.
 *
 * A cut always goes through the whole patch, so the pieces of a patch are a grid, told by two lists
 * of parameters, and nothing need be cut before all are known. Let P be a point that is a vertex:
 * first the corners of all patches. Every border that P lies inside of (within the tolerance; not
 * where an end of the border is P, nor a cut that is known) gets the isoline through it, which ends
 * on the opposite border in a point that is a vertex too. So one rule on a queue of points, each
 * looked up once in a tree over the borders' Bezier segments, finds T-vertices, L-shaped
 * arrangements, cuts that run around the part and cuts that meet, at near linear cost.
 *
 * The point on the border is its foot: |C(t) - P| is least, by bisection of control polygons
 * (convex hulls: nothing nearer than the tolerance is missed) and Gauss-Newton steps, which
 * converge quadratically since the distance is nearly zero. Patches are brought into an orientation
 * and an order that their points alone tell: so are the bits of the result.
 *
 * Where the borders' parameters do not agree around the part, isolines form spirals, and the cuts
 * never end: their number is limited. */
#include <stdio.h>
#include <stdlib.h>

#include "bernstein.h"
#include "bspline.h"
#include "bvh.h"
#include "complex.h"
#include "split.h"

static const char stage[] = "boundary";

enum { MAX_DEPTH = 40, NEWTON_DEPTH = 4, NEWTON_STEPS = 12, MAX_SHOWN = 6 };
static const double pieces_per_patch = 64.0, pieces_more = 4096.0;

static const double knot_resolution = 1e-11;

/* Isolines of a patch that are nearer than this, at an end, leave a sliver between them: in
 * tolerances, and as a part of the border's length. */
static const double sliver_tolerances = 10.0, sliver_part = 1e-6;

/* A Bezier segment of a border: homogeneous points from parameter `low` to `high`. */
typedef struct segment {
  int border;
  double low, high;
  const double *point;
} segment;

/* Slot 4 p + 2 along + end: direction `along` of patch p at the `end` of the other one. */
typedef struct border {
  int first, end, degree; /* its segments, from low to high */
  double tolerance, length;
} border;

/* A vertex: a corner of patch p, or where the cut at x along direction `along` ends. */
typedef struct vertex {
  double x[3], tolerance;
  int patch, corner; /* corner of the input's patch, -1: none */
} vertex;

typedef struct splitter {
  tsolid_context *context;
  tsi_arena *arena;
  const tsolid_boundary_input *input;
  const tsi_patch_list *list;
  int n;
  tsi_split_patch *patch;
  double **knots[2]; /* of each patch and direction: where a cut costs nothing, ascending */
  int *n_knots[2];
  border *border;
  int n_segments, segment_capacity;
  segment *segment;
  struct tsi_bvh *tree;
  int n_vertices, vertex_capacity;
  vertex *vertex;
  int n_found, found_capacity, failed;
  int *found;
  double n_pieces;
  int n_cuts;
} splitter;

/* Room for one more item of `size` bytes; NULL: no memory. */
static void *grow(tsi_arena *arena, void *items, int n, int *capacity, size_t size) {
  if (n < *capacity)
    return items;
  int more = n < 8 ? 16 : n > TSI_MAX_COUNT / 2 ? 0 : 2 * n;
  void *to = more ? tsi_arena_new(arena, (size_t)more, size) : NULL;
  if (to && n)
    memcpy(to, items, (size_t)n * size);
  if (to)
    *capacity = more;
  return to;
}

/* ---- canonical order ---------------------------------------------------------------------------
 */

/* The least corner becomes (0,0), the lesser of its neighbours (1,0). */
static tsi_place choose_place(const tsi_facet *facet, int number) {
  int least = 0;
  for (int c = 1; c < 4; c++)
    if (tsi_compare_points(facet->corner[c], facet->corner[least]) < 0)
      least = c;
  int along_u = least ^ 1, along_v = 3 - least; /* 00, 10, 11, 01 */
  return (tsi_place){.facet = number,
                     .swap = tsi_compare_points(facet->corner[along_v], facet->corner[along_u]) < 0,
                     .flip = {least == 1 || least == 2, least >= 2}};
}

typedef struct patch_key {
  const tsi_facet *facet;
  double corner[4][3];
  int number;
} patch_key;

static int compare_keys(const void *a, const void *b) {
  const patch_key *p = a, *q = b;
  for (int c = 0; c < 4; c++) {
    int order = tsi_compare_points(p->corner[c], q->corner[c]);
    if (order)
      return order;
  }
  int order = tsi_compare_points(p->facet->centre, q->facet->centre);
  return order ? order : (p->number > q->number) - (p->number < q->number);
}

static int compare_corners(const void *a, const void *b) {
  return tsi_compare_points(a, b);
}

static tsolid_status orient_patches(splitter *s) {
  patch_key *key = tsi_arena_new(s->arena, (size_t)s->n, sizeof *key);
  s->patch = tsi_arena_new(s->arena, (size_t)s->n, sizeof *s->patch);
  if (!key || !s->patch)
    return tsi_no_memory(s->context, stage);
  for (int k = 0; k < s->n; k++) {
    key[k] = (patch_key){.facet = &s->list->facet[k], .number = k};
    memcpy(key[k].corner, s->list->facet[k].corner, sizeof key[k].corner);
    qsort(key[k].corner, 4, sizeof key[k].corner[0], compare_corners);
  }
  qsort(key, (size_t)s->n, sizeof *key, compare_keys);
  tsolid_status status = TSOLID_OK;
  for (int i = 0; !status && i < s->n; i++) {
    int k = key[i].number;
    tsi_split_patch *p = &s->patch[i];
    p->number = k;
    p->place = choose_place(&s->list->facet[k], k);
    if (!s->list->patch[k].n[0])
      status = tsi_side_move(s->context, s->arena, &s->list->elements[k], &p->place, &p->elements);
    else if (!tsi_patch_orient(s->arena, &s->list->patch[k], p->place.flip, p->place.swap,
                               &p->patch))
      status = tsi_no_memory(s->context, stage);
  }
  return status;
}

/* Border 0..3 of the input's patch under a slot; see tsi_seam_border. */
static int own_border(const splitter *s, int slot) {
  const tsi_place *place = &s->patch[slot / 4].place;
  int along = place->swap ? 1 - slot / 2 % 2 : slot / 2 % 2;
  int end = slot % 2 ^ place->flip[1 - along];
  return along == 0 ? (end ? 2 : 0) : (end ? 1 : 3);
}

static const tsi_facet *facet_of(const splitter *s, int p) {
  return &s->list->facet[s->patch[p].number];
}

/* ---- borders -----------------------------------------------------------------------------------
 */

static int add_segment(splitter *s, int slot, double low, double high, const double *point) {
  segment *list =
      grow(s->arena, s->segment, s->n_segments, &s->segment_capacity, sizeof *s->segment);
  if (!list)
    return 0;
  s->segment = list;
  list[s->n_segments++] = (segment){slot, low, high, point};
  return 1;
}

static int add_row(splitter *s, int slot, const tsi_patch *patch) {
  int along = slot / 2 % 2, degree = patch->degree[along], n = patch->n[along], n_to = 0, count = 0;
  const double *knots = patch->knots[along];
  size_t step = along ? (size_t)patch->n[0] : 1, room = (size_t)(n + 1) * (size_t)(degree + 1);
  size_t start =
      slot % 2 ? (size_t)(patch->n[1 - along] - 1) * (along ? 1 : (size_t)patch->n[0]) : 0;
  double *to = tsi_arena_new(s->arena, room, sizeof *to);
  double *point = tsi_arena_new(s->arena, room, 4 * sizeof *point);
  if (!to || !point)
    return 0;
  for (int i = 0; i < n + degree + 1; i++) {
    to[n_to++] = knots[i];
    count = i && knots[i - 1] == knots[i] ? count + 1 : 1;
    if (i == n + degree || knots[i + 1] != knots[i])
      for (; count < degree; count++)
        to[n_to++] = knots[i];
  }
  for (int m = 0; m < n; m++)
    memcpy(point + 4 * m, patch->control + 4 * (start + step * (size_t)m), 4 * sizeof *point);
  tsi_bspline_insert(degree, n, knots, n_to - degree - 1, to, 4, point);
  for (int i = degree; i + 1 < n_to; i += degree) {
    if (to[i] == 1.0)
      break;
    if (!add_segment(s, slot, to[i], to[i + 1], point + 4 * (size_t)(i - degree)))
      return 0;
  }
  return 1;
}

static int compare_segments(const void *a, const void *b) {
  const segment *p = a, *q = b;
  return (p->low > q->low) - (p->low < q->low);
}

static int add_elements(splitter *s, int slot, const tsi_side *e) {
  int along = slot / 2 % 2, end = slot % 2, degree = e->degree[along], first = s->n_segments;
  size_t n0 = (size_t)e->degree[0] + 1, width = n0 * ((size_t)e->degree[1] + 1);
  size_t step = along ? n0 : 1, fixed = !end ? 0 : along ? n0 - 1 : width - n0;
  for (int i = 0; i < e->n_elements; i++) {
    const double *box = e->box + 4 * (size_t)i;
    if (box[2 * (1 - along) + end] != (double)end)
      continue;
    double *point = tsi_arena_new(s->arena, (size_t)degree + 1, 4 * sizeof *point);
    if (!point || !add_segment(s, slot, box[2 * along], box[2 * along + 1], point))
      return 0;
    for (int k = e->function_start[i]; k < e->function_start[i + 1]; k++)
      for (size_t m = 0; m <= (size_t)degree; m++)
        for (size_t c = 0; c < 4; c++)
          point[4 * m + c] += e->coefficient[(size_t)k * width + fixed + step * m] *
                              s->input->points[4 * (size_t)e->function[k] + c];
  }
  if (s->n_segments > first)
    qsort(s->segment + first, (size_t)(s->n_segments - first), sizeof *s->segment,
          compare_segments);
  return s->n_segments > first;
}

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static int list_knots(splitter *s, int p) {
  const tsi_split_patch *patch = &s->patch[p];
  for (int d = 0; d < 2; d++) {
    if (patch->patch.n[0]) {
      s->knots[d][p] = patch->patch.knots[d];
      s->n_knots[d][p] = patch->patch.n[d] + patch->patch.degree[d] + 1;
      continue;
    }
    int n = 2 * patch->elements.n_elements;
    double *knots = tsi_arena_new(s->arena, (size_t)n, sizeof *knots);
    if (!knots)
      return 0;
    for (int k = 0; k < n; k++)
      knots[k] = patch->elements.box[4 * (size_t)(k / 2) + (size_t)(2 * d + k % 2)];
    qsort(knots, (size_t)n, sizeof *knots, compare_doubles);
    s->knots[d][p] = knots;
    s->n_knots[d][p] = n;
  }
  return 1;
}

static void bound_segment(const splitter *s, const segment *g, double box[6]) {
  const border *b = &s->border[g->border];
  for (int c = 0; c < 3; c++) {
    box[c] = INFINITY;
    box[c + 3] = -INFINITY;
    for (int m = 0; m <= b->degree; m++) {
      double x = g->point[4 * m + c] / g->point[4 * m + 3];
      box[c] = fmin(box[c], x - b->tolerance);
      box[c + 3] = fmax(box[c + 3], x + b->tolerance);
    }
  }
}

static tsolid_status list_borders(splitter *s) {
  s->border = tsi_arena_new(s->arena, 4 * (size_t)s->n, sizeof *s->border);
  for (int d = 0; d < 2; d++) {
    s->knots[d] = tsi_arena_new(s->arena, (size_t)s->n, sizeof *s->knots[d]);
    s->n_knots[d] = tsi_arena_new(s->arena, (size_t)s->n, sizeof *s->n_knots[d]);
  }
  int done = s->border && s->knots[0] && s->knots[1] && s->n_knots[0] && s->n_knots[1];
  for (int p = 0; done && p < s->n; p++) {
    const tsi_split_patch *patch = &s->patch[p];
    done = list_knots(s, p);
    for (int slot = 4 * p; done && slot < 4 * p + 4; slot++) {
      border *b = &s->border[slot];
      int nurbs = patch->patch.n[0] > 0, own = own_border(s, slot), along = slot / 2 % 2;
      b->degree = nurbs ? patch->patch.degree[along] : patch->elements.degree[along];
      b->tolerance = facet_of(s, p)->tolerance[own];
      b->length = facet_of(s, p)->length[own];
      b->first = s->n_segments;
      done = nurbs ? add_row(s, slot, &patch->patch) : add_elements(s, slot, &patch->elements);
      b->end = s->n_segments;
    }
  }
  double *box = done ? tsi_arena_new(s->arena, (size_t)s->n_segments, 6 * sizeof *box) : NULL;
  if (!box)
    return tsi_no_memory(s->context, stage);
  for (int i = 0; i < s->n_segments; i++)
    bound_segment(s, &s->segment[i], box + 6 * (size_t)i);
  s->tree = tsi_bvh_create(&s->context->allocator, s->n_segments, box);
  return s->tree ? TSOLID_OK : tsi_no_memory(s->context, stage);
}

/* ---- points on borders ------------------------------------------------------------------------
 */

/* Point and derivative of a segment at t in [0,1], by de Casteljau. */
static void evaluate_segment(const segment *g, int degree, double t, double x[3], double dx[3]) {
  double h[TSI_MAX_ORDER][4], dw = 0.0;
  memcpy(h, g->point, (size_t)(degree + 1) * sizeof h[0]);
  for (int r = degree; r > 1; r--)
    for (int m = 0; m < r; m++)
      for (int c = 0; c < 4; c++)
        h[m][c] = (1.0 - t) * h[m][c] + t * h[m + 1][c];
  double w = (1.0 - t) * h[0][3] + t * h[1][3];
  dw = degree * (h[1][3] - h[0][3]);
  for (int c = 0; c < 3; c++) {
    x[c] = ((1.0 - t) * h[0][c] + t * h[1][c]) / w;
    dx[c] = (degree * (h[1][c] - h[0][c]) - dw * x[c]) / w;
  }
}

static void evaluate_border(const splitter *s, int slot, double t, double x[3]) {
  const border *b = &s->border[slot];
  int low = b->first, high = b->end - 1;
  double dx[3];
  while (low < high) {
    int middle = low + (high - low) / 2;
    if (t <= s->segment[middle].high)
      high = middle;
    else
      low = middle + 1;
  }
  const segment *g = &s->segment[low];
  double own = t == g->high ? 1.0 : t == g->low ? 0.0 : (t - g->low) / (g->high - g->low);
  evaluate_segment(g, b->degree, own, x, dx);
}

/* Gauss-Newton from t; returns the distance. */
static double find_foot(const segment *g, int degree, const double p[3], double *t) {
  double x[3], dx[3], best = INFINITY, at = *t;
  for (int step = 0; step < NEWTON_STEPS; step++) {
    double along = 0.0, square = 0.0;
    evaluate_segment(g, degree, at, x, dx);
    double distance = tsi_distance(x, p);
    if (!(distance < best))
      break;
    best = distance;
    *t = at;
    for (int c = 0; c < 3; c++) {
      along += (p[c] - x[c]) * dx[c];
      square += dx[c] * dx[c];
    }
    if (!(square > 0.0))
      break;
    at = fmin(fmax(at + along / square, 0.0), 1.0);
  }
  return best;
}

/* Distance of p from the box of the segment's control points between a and b. */
static double bound_distance(const segment *g, int degree, double a, double b, const double p[3]) {
  double h[TSI_MAX_ORDER][4], square = 0.0;
  memcpy(h, g->point, (size_t)(degree + 1) * sizeof h[0]);
  for (int c = 0; c < 4; c++)
    tsi_bernstein_restrict(degree, a, b, &h[0][c], 4);
  for (int c = 0; c < 3; c++) {
    double low = INFINITY, high = -INFINITY;
    for (int m = 0; m <= degree; m++) {
      low = fmin(low, h[m][c] / h[m][3]);
      high = fmax(high, h[m][c] / h[m][3]);
    }
    double away = fmax(fmax(low - p[c], p[c] - high), 0.0);
    square += away * away;
  }
  return sqrt(square);
}

/* Finds a point of the segment nearer than *best, if there is one. */
static int approach_segment(const splitter *s, const segment *g, const double p[3], double *best,
                            double *at) {
  struct {
    double a, b;
    int depth;
  } stack[MAX_DEPTH + 2] = {{0.0, 1.0, 0}};
  int degree = s->border[g->border].degree, found = 0;
  double enough = 1e-3 * *best;
  for (int n = 1; n && (!found || *best > enough);) {
    double a = stack[n - 1].a, b = stack[n - 1].b, middle = 0.5 * (a + b), t = middle;
    int depth = stack[--n].depth;
    if (bound_distance(g, degree, a, b, p) > *best)
      continue;
    double distance = depth >= NEWTON_DEPTH ? find_foot(g, degree, p, &t) : INFINITY;
    if (distance < *best || (!found && distance == *best)) {
      found = 1;
      *best = distance;
      *at = t == 1.0 ? g->high : g->low + t * (g->high - g->low);
    }
    if (depth == MAX_DEPTH)
      continue;
    stack[n].a = middle;
    stack[n].b = b;
    stack[n++].depth = depth + 1;
    stack[n].a = a;
    stack[n].b = middle;
    stack[n++].depth = depth + 1;
  }
  return found;
}

/* ---- words -------------------------------------------------------------------------------------
 */

static double own_parameter(const splitter *s, int p, int d, double x) {
  const tsi_place *place = &s->patch[p].place;
  int own = place->swap ? 1 - d : d;
  const double *domain = s->list->domain[s->patch[p].number] + 2 * own;
  return domain[0] + (place->flip[own] ? 1.0 - x : x) * (domain[1] - domain[0]);
}

/* "Vertex7", "a corner of Face2", "a cut through Face2". */
static const char *name_vertex(const splitter *s, int v, char text[TSI_BORDER_NAME_SIZE]) {
  const vertex *at = &s->vertex[v];
  const tsi_facet *facet = facet_of(s, at->patch);
  char name[TSI_NAME_SIZE];
  if (at->corner >= 0 && facet->corner_name[at->corner] && *facet->corner_name[at->corner])
    return tsi_name_patch(facet->corner_name[at->corner], 0, text);
  snprintf(text, TSI_BORDER_NAME_SIZE, "%s %s",
           at->corner >= 0 ? "a corner of" : "the end of a cut through",
           tsi_name_facet(facet, name));
  return text;
}

/* "Edge4", or "2" for want of a name. */
static void name_own_border(const splitter *s, int slot, char text[TSI_NAME_SIZE]) {
  int b = own_border(s, slot);
  const char *name = facet_of(s, slot / 4)->border_name[b];
  if (name && *name)
    tsi_name_patch(name, b, text);
  else
    snprintf(text, TSI_NAME_SIZE, "%d", b);
}

static tsolid_finding finding_at(const splitter *s, tsolid_severity severity, tsolid_status status,
                                 int p, const double x[3]) {
  tsolid_finding finding = tsi_finding(severity, status, stage);
  finding.entity = TSOLID_ENTITY_PATCH;
  finding.index[0] = facet_of(s, p)->patch;
  tsi_set_point(&finding, x);
  return finding;
}

static tsolid_status refuse_sliver(const splitter *s, int slot, int v, int other, double width,
                                   double tolerance) {
  char name[TSI_NAME_SIZE], vertex_name[2][TSI_BORDER_NAME_SIZE];
  const double *x = s->vertex[v].x;
  tsolid_finding finding = finding_at(s, TSOLID_ERROR, TSOLID_ERROR_REFUSED, slot / 4, x);
  finding.measured = width;
  finding.allowed = tolerance;
  tsi_name_facet(facet_of(s, slot / 4), name);
  name_vertex(s, v, vertex_name[0]);
  if (other >= 0)
    name_vertex(s, other, vertex_name[1]);
  else
    snprintf(vertex_name[1], sizeof vertex_name[1], "a corner of its own");
  return tsi_report(
      s->context, &finding,
      "%s would be cut into a sliver %.3g wide at (%.6g, %.6g, %.6g), by the isolines "
      "through %s and %s on its borders, which are farther apart than the tolerance "
      "of %.3g but too near to each other",
      name, width, x[0], x[1], x[2], vertex_name[0], vertex_name[1], tolerance);
}

static tsolid_status refuse_spiral(const splitter *s) {
  int most = 0, other = -1;
  char name[2][TSI_NAME_SIZE];
  for (int p = 1; p < s->n; p++)
    if (s->patch[p].cuts[0].n + s->patch[p].cuts[1].n >
        s->patch[most].cuts[0].n + s->patch[most].cuts[1].n)
      most = p;
  for (int p = 0; p < s->n; p++)
    if (p != most && (other < 0 || s->patch[p].cuts[0].n + s->patch[p].cuts[1].n >
                                       s->patch[other].cuts[0].n + s->patch[other].cuts[1].n))
      other = p;
  tsolid_finding finding =
      finding_at(s, TSOLID_ERROR, TSOLID_ERROR_REFUSED, most, facet_of(s, most)->centre);
  finding.measured = s->n_pieces;
  finding.allowed = pieces_per_patch * s->n + pieces_more;
  return tsi_report(s->context, &finding,
                    "The isolines from vertices inside borders would cut the %d faces into more "
                    "than %.0f pieces, most of them %s and %s: they do not close around the part "
                    "where the faces' parameters disagree",
                    s->n, finding.allowed, tsi_name_facet(facet_of(s, most), name[0]),
                    other < 0 ? "no other" : tsi_name_facet(facet_of(s, other), name[1]));
}

/* ---- the search --------------------------------------------------------------------------------
 */

static int add_vertex(splitter *s, const double x[3], double tolerance, int patch, int corner) {
  vertex *list = grow(s->arena, s->vertex, s->n_vertices, &s->vertex_capacity, sizeof *s->vertex);
  if (!list)
    return 0;
  s->vertex = list;
  list[s->n_vertices++] = (vertex){{x[0], x[1], x[2]}, tolerance, patch, corner};
  return 1;
}

/* The distance of two isolines on a border. */
static double measure_gap(const splitter *s, int slot, double a, double b) {
  double x[3], y[3];
  evaluate_border(s, slot, a, x);
  evaluate_border(s, slot, b, y);
  return tsi_distance(x, y);
}

/* The knot at x, or the nearest within the tolerance of the point, or x. */
static double snap_to_knot(const splitter *s, int slot, double x, const double p[3],
                           double tolerance) {
  int d = slot / 2 % 2, n = s->n_knots[d][slot / 4], low = 0, high = n - 1;
  const double *knots = s->knots[d][slot / 4];
  while (low < high) { /* the first not below x */
    int middle = low + (high - low) / 2;
    if (knots[middle] < x)
      low = middle + 1;
    else
      high = middle;
  }
  double best = x, least = tolerance;
  for (int i = low ? low - 1 : 0; i <= low; i++) {
    double at[3];
    if (fabs(knots[i] - x) <= knot_resolution)
      return knots[i];
    evaluate_border(s, slot, knots[i], at);
    double distance = tsi_distance(at, p);
    if (distance <= least) {
      least = distance;
      best = knots[i];
    }
  }
  return best;
}

/* The new cut must leave no sliver between itself and the one, or the end, at y. */
static tsolid_status check_sliver(const splitter *s, int slot, int v, double x, double y, int other,
                                  double tolerance) {
  for (int k = 0; k < 2; k++) {
    const border *b = &s->border[slot ^ k];
    double allowed = fmax(k ? b->tolerance : tolerance, b->tolerance);
    double width = measure_gap(s, slot ^ k, x, y), least = allowed;
    if (other >= 0)
      least = fmax(sliver_tolerances * allowed, sliver_part * b->length);
    if (width <= least)
      return refuse_sliver(s, slot, v, other, width, allowed);
  }
  return TSOLID_OK;
}

/* Cuts the patch of a border at x, for vertex v, unless it is. */
static tsolid_status add_cut(splitter *s, int slot, int v, double x, double tolerance) {
  tsi_split_patch *patch = &s->patch[slot / 4];
  tsi_cuts *cuts = &patch->cuts[slot / 2 % 2];
  double across = patch->cuts[1 - slot / 2 % 2].n + 1, ends[2][3], far[3];
  int at = 0;
  while (at < cuts->n && cuts->cut[at].x < x)
    at++;
  for (int i = at ? at - 1 : 0; i <= at && i < cuts->n; i++) {
    evaluate_border(s, slot, cuts->cut[i].x, far);
    if (cuts->cut[i].x == x || tsi_distance(far, s->vertex[v].x) <= tolerance)
      return TSOLID_OK;
  }
  evaluate_border(s, slot, 0.0, ends[0]);
  evaluate_border(s, slot, 1.0, ends[1]);
  for (int i = 0; i < 2; i++) { /* two corners in one place: a gap, for the complex to report */
    double least = fmax(sliver_tolerances * tolerance, sliver_part * s->border[slot].length);
    double width = tsi_distance(ends[i], s->vertex[v].x);
    if (width <= least)
      return s->vertex[v].corner >= 0 ? TSOLID_OK : refuse_sliver(s, slot, v, -1, width, tolerance);
  }
  const tsi_cut *before = at ? &cuts->cut[at - 1] : NULL;
  const tsi_cut *after = at < cuts->n ? &cuts->cut[at] : NULL;
  tsolid_status status =
      check_sliver(s, slot, v, x, before ? before->x : 0.0, before ? before->point : -1, tolerance);
  if (!status)
    status =
        check_sliver(s, slot, v, x, after ? after->x : 1.0, after ? after->point : -1, tolerance);
  if (status)
    return status;
  tsi_cut *list = grow(s->arena, cuts->cut, cuts->n, &cuts->capacity, sizeof *cuts->cut);
  if (!list)
    return tsi_no_memory(s->context, stage);
  cuts->cut = list;
  memmove(list + at + 1, list + at, (size_t)(cuts->n - at) * sizeof *list);
  list[at] = (tsi_cut){x, v, slot};
  cuts->n++;
  s->n_cuts++;
  s->n_pieces += across;
  if (s->n_pieces > pieces_per_patch * s->n + pieces_more)
    return refuse_spiral(s);
  evaluate_border(s, slot ^ 1, x, far);
  return add_vertex(s, far, s->border[slot ^ 1].tolerance, slot / 4, -1)
             ? TSOLID_OK
             : tsi_no_memory(s->context, stage);
}

static int collect(void *data, int item) {
  splitter *s = data;
  int *list = grow(s->arena, s->found, s->n_found, &s->found_capacity, sizeof *s->found);
  if (!list) {
    s->failed = 1;
    return 1;
  }
  s->found = list;
  list[s->n_found++] = item;
  return 0;
}

static int compare_ints(const void *a, const void *b) {
  int p = *(const int *)a, q = *(const int *)b;
  return (p > q) - (p < q);
}

/* The border with the found segments first .. end - 1. */
static tsolid_status visit_border(splitter *s, int v, int first, int end) {
  int slot = s->segment[s->found[first]].border, found = 0;
  const border *b = &s->border[slot];
  const double *p = s->vertex[v].x;
  double tolerance = fmax(b->tolerance, s->vertex[v].tolerance), best = tolerance, x = 0.0, at[3];
  for (int i = 0; i < 2; i++) {
    evaluate_border(s, slot, i, at);
    if (tsi_distance(at, p) <= tolerance)
      return TSOLID_OK;
  }
  for (int i = first; i < end; i++)
    found |= approach_segment(s, &s->segment[s->found[i]], p, &best, &x);
  if (!found)
    return TSOLID_OK;
  x = snap_to_knot(s, slot, 1.0 - (1.0 - x), p, tolerance);
  return x > 0.0 && x < 1.0 ? add_cut(s, slot, v, x, tolerance) : TSOLID_OK;
}

static tsolid_status visit_vertex(splitter *s, int v) {
  s->n_found = 0;
  tsi_bvh_containing(s->tree, s->vertex[v].x, s->vertex[v].tolerance, collect, s);
  if (s->failed)
    return tsi_no_memory(s->context, stage);
  if (s->n_found)
    qsort(s->found, (size_t)s->n_found, sizeof *s->found, compare_ints);
  for (int first = 0, end; first < s->n_found; first = end) {
    end = first + 1;
    while (end < s->n_found &&
           s->segment[s->found[end]].border == s->segment[s->found[first]].border)
      end++;
    tsolid_status status = visit_border(s, v, first, end);
    if (status)
      return status;
  }
  return v % 1024 ? TSOLID_OK : tsi_progress(s->context, stage, 0.1);
}

static tsolid_status find_cuts(splitter *s) {
  for (int p = 0; p < s->n; p++)
    for (int i = 0; i < 4; i++) {
      static const int corner_at[4] = {0, 1, 3, 2}; /* of bits u, v */
      const tsi_place *place = &s->patch[p].place;
      const tsi_facet *facet = facet_of(s, p);
      int bits[2] = {i & 1, i >> 1}; /* corners in canonical order */
      int u = bits[place->swap] ^ place->flip[0], w = bits[1 - place->swap] ^ place->flip[1];
      int c = corner_at[u + 2 * w];
      double tolerance = fmax(facet->tolerance[c], facet->tolerance[(c + 3) % 4]);
      if (!add_vertex(s, facet->corner[c], tolerance, p, c))
        return tsi_no_memory(s->context, stage);
    }
  s->n_pieces = s->n;
  tsolid_status status = TSOLID_OK;
  for (int v = 0; !status && v < s->n_vertices; v++)
    status = visit_vertex(s, v);
  return status;
}

/* ---- the stage ---------------------------------------------------------------------------------
 */

/* "u = 0.25, 0.5, v = 0.75": the first cuts of a patch in its own parameters. */
static void list_values(const splitter *s, int p, char *text, size_t size) {
  size_t length = 0;
  int shown = 0;
  text[0] = '\0';
  for (int own = 0; own < 2; own++) {
    int swap = s->patch[p].place.swap, d = swap ? 1 - own : own;
    const tsi_cuts *cuts = &s->patch[p].cuts[d];
    for (int i = 0; i < cuts->n && length + 32 < size; i++) {
      int k = s->patch[p].place.flip[own] ? cuts->n - 1 - i : i;
      if (++shown > MAX_SHOWN)
        continue;
      length += (size_t)snprintf(text + length, size - length, "%s%s%.9g", length ? ", " : "",
                                 i == 0 ? (own ? "v = " : "u = ") : "",
                                 own_parameter(s, p, d, cuts->cut[k].x));
    }
  }
  if (shown > MAX_SHOWN)
    snprintf(text + length, size - length, " and %d more", shown - MAX_SHOWN);
}

static tsolid_status note_cuts(const splitter *s, int p) {
  const tsi_split_patch *patch = &s->patch[p];
  const tsi_cut *first = NULL; /* found first */
  char values[32 * (MAX_SHOWN + 4)], name[TSI_NAME_SIZE], at[TSI_NAME_SIZE];
  char of[TSI_BORDER_NAME_SIZE];
  for (int d = 0; d < 2; d++)
    for (int i = 0; i < patch->cuts[d].n; i++)
      if (!first || patch->cuts[d].cut[i].point < first->point)
        first = &patch->cuts[d].cut[i];
  if (!first)
    return TSOLID_OK;
  tsolid_finding note = finding_at(s, TSOLID_NOTE, TSOLID_OK, p, s->vertex[first->point].x);
  list_values(s, p, values, sizeof values);
  name_own_border(s, first->border, at);
  int others = patch->cuts[0].n + patch->cuts[1].n > 1;
  return tsi_report(s->context, &note, "%s is cut at %s, because %s lies on its border %s%s",
                    tsi_name_facet(facet_of(s, p), name), values, name_vertex(s, first->point, of),
                    at, others ? ", and so on" : "");
}

static tsolid_status note_patches(const splitter *s, tsolid_preparation *preparation) {
  int *of = tsi_arena_new(s->arena, (size_t)s->n, sizeof *of);
  if (!of)
    return tsi_no_memory(s->context, stage);
  for (int p = 0; p < s->n; p++)
    of[s->patch[p].number] = p;
  tsolid_status status = TSOLID_OK;
  preparation->n_cuts = s->n_cuts;
  for (int k = 0; !status && k < s->n; k++) {
    int n_cuts = s->patch[of[k]].cuts[0].n + s->patch[of[k]].cuts[1].n;
    preparation->n_cut_patches += n_cuts > 0;
    status = note_cuts(s, of[k]);
  }
  return status;
}

/* Poles, closed borders and faces without area are the complex's to refuse. */
static int is_degenerate(const tsi_facet *facet) {
  double longest = 0.0, tolerance = 0.0;
  for (int b = 0; b < 4; b++) {
    longest = fmax(longest, facet->length[b]);
    tolerance = fmax(tolerance, facet->tolerance[b]);
    if (facet->length[b] <= 2.0 * facet->tolerance[b] ||
        tsi_distance(facet->corner[b], facet->corner[(b + 1) % 4]) <= facet->tolerance[b])
      return 1;
  }
  return facet->area <= tolerance * longest;
}

tsolid_status tsi_split(tsolid_context *context, tsi_arena *arena,
                        const tsolid_boundary_input *input, double tolerance,
                        const double origin[3], tsi_patch_list *list,
                        tsolid_preparation *preparation) {
  splitter s = {.context = context, .arena = arena, .input = input, .list = list, .n = list->n};
  for (int k = 0; k < list->n; k++)
    if (is_degenerate(&list->facet[k]))
      return TSOLID_OK;
  tsolid_status status = orient_patches(&s);
  if (!status)
    status = list_borders(&s);
  if (!status)
    status = find_cuts(&s);
  if (!status && s.n_cuts)
    status = note_patches(&s, preparation);
  if (!status && s.n_cuts)
    status = tsi_pieces_make(context, arena, input, tolerance, origin, s.patch, list);
  tsi_bvh_free(s.tree);
  return status;
}
