/* SPDX-License-Identifier: LGPL-2.1-or-later
 * From T-mesh and control points to Bezier elements: which surface a .tsm is.
 *
 * X(u,v) = sum of w_A P_A N_A(u,v) in homogeneous form, bicubic, one function per control point.
 *
 * Away from stars N_A is the product of two cubic B-splines whose five knots are those that rays
 * from A's vertex meet (surface_rays.c). It is laid out quadrant by quadrant: from the vertex the
 * face frames are unfolded into the quadrant's plane, edge by edge, as far as the support reaches;
 * a face that the support reaches twice (round a thin body) gets both parts. Every face is cut
 * along the lines of all functions on it, so that all of them are polynomials on each element.
 *
 * Round stars (vertices where not four quadrants meet) the rule of surface_star.c holds.
 *
 * Where the T-mesh is a grid this is the B-spline surface. Where it is analysis-suitable the
 * functions sum to one; else the sum is what it is, X = (x, y, z, w) is divided by w all the same,
 * and the defect is kept (sum_defect). */
#include <stdlib.h>

#include "bernstein.h"
#include "surface_rays.h"

static const char stage[] = "surface";
static const double agreement = 1e-9;

enum { VISITS_PER_FACE = 128, SPARE_VISITS = 4096, MAX_WINDINGS = 64, MAX_CUTS = 4096 };

/* A function in one of its quadrants: x and y run from its vertex outwards. */
typedef struct quadrant {
  int point;
  double knot[2][5];
  double end[2]; /* of the support, along x and y */
  int cut_value; /* bits: 1, 2 the value at x, y = 0 is 1; 4, 8 it is 0 at the end */
} quadrant;

/* A face in a quadrant's plane: (x, y) = origin + (u, v) turned by `turn` right angles. */
typedef struct visit {
  int face, quadrant, turn;
  double origin[2];
} visit;

typedef struct list {
  void *item;
  size_t n, capacity, size;
} list;

typedef struct builder {
  tsolid_context *context;
  tsolid_surface *surface;
  tsi_arena *arena;
  tsi_mesh mesh;
  list quadrants, visits, box, function_start, function, coefficient;
  char *near;
  tsi_net *net;
  size_t *visit_start; /* visits of a face, after sorting */
  int *last_visit;     /* per face: the latest of the running quadrant, else -1 */
  list chain;          /* per visit: the previous one of the same face and quadrant */
  int *place;          /* per point: its entry in the running element, else -1 */
  tsolid_status status;
} builder;

static int push(builder *b, list *to, const void *item, size_t n) {
  const tsi_allocator *allocator = &b->context->allocator;
  if (to->n + n > to->capacity) {
    size_t capacity = 2 * to->capacity + n + 64;
    void *grown = tsi_new(allocator, capacity, to->size);
    if (!grown) {
      b->status = tsi_no_memory(b->context, stage);
      return 0;
    }
    if (to->n)
      memcpy(grown, to->item, to->n * to->size);
    tsi_delete(allocator, to->item);
    to->item = grown;
    to->capacity = capacity;
  }
  memcpy((char *)to->item + to->n * to->size, item, n * to->size);
  to->n += n;
  return 1;
}

static void drop(builder *b, list *of) {
  tsi_delete(&b->context->allocator, of->item);
  of->item = NULL;
}

/* ---- placing faces -----------------------------------------------------------------------------
 */

static void turn_vector(int turn, double x, double y, double out[2]) {
  switch (turn & 3) {
  case 0:
    out[0] = x;
    out[1] = y;
    break;
  case 1:
    out[0] = -y;
    out[1] = x;
    break;
  case 2:
    out[0] = -x;
    out[1] = -y;
    break;
  default:
    out[0] = y;
    out[1] = -x;
  }
}

/* A link's origin in its face's frame. */
static void origin_in_face(const tsi_mesh *m, int link, double uv[2]) {
  const double *size = m->size + 2 * (size_t)m->surface->link[link].face;
  double at = m->at[link];
  int side = m->side[link];
  uv[0] = side == 0 ? at : side == 1 ? size[0] : side == 2 ? size[0] - at : 0.0;
  uv[1] = side == 0 ? 0.0 : side == 1 ? at : side == 2 ? size[1] : size[1] - at;
}

/* The face of `link`, turned so, with the link's origin at (x, y). */
static visit place_face(const tsi_mesh *m, int link, int turn, const double xy[2]) {
  visit v = {.face = m->surface->link[link].face, .turn = turn & 3};
  double uv[2], turned[2];
  origin_in_face(m, link, uv);
  turn_vector(turn, uv[0], uv[1], turned);
  v.origin[0] = xy[0] - turned[0];
  v.origin[1] = xy[1] - turned[1];
  return v;
}

/* Box (x0, x1, y0, y1) of a placed rectangle (u0, u1, v0, v1). */
static void placed_box(const visit *v, const double box[4], double out[4]) {
  double a[2], b[2];
  turn_vector(v->turn, box[0], box[2], a);
  turn_vector(v->turn, box[1], box[3], b);
  for (int d = 0; d < 2; d++) {
    out[2 * d] = v->origin[d] + fmin(a[d], b[d]);
    out[2 * d + 1] = v->origin[d] + fmax(a[d], b[d]);
  }
}

/* Whether an interval reaches into [0, end], or has no length and lies in it. */
static int overlaps(double low, double high, double end) {
  double tolerance = agreement * fmin(end, high - low);
  if (high - low <= 0.0)
    return low >= -agreement * end && high <= end * (1.0 + agreement);
  return fmin(high, end) - fmax(low, 0.0) > tolerance;
}

static int is_in_support(const builder *b, const visit *v, const quadrant *q) {
  const double *size = b->mesh.size + 2 * (size_t)v->face;
  double face[4] = {0.0, size[0], 0.0, size[1]}, box[4];
  placed_box(v, face, box);
  return overlaps(box[0], box[1], q->end[0]) && overlaps(box[2], box[3], q->end[1]);
}

/* 1: the running quadrant has the face in this place; -1: it winds round the surface without end.
 */
static int was_visited(const builder *b, const visit *v) {
  const visit *all = b->visits.item;
  const int *previous = b->chain.item;
  const double *size = b->mesh.size + 2 * (size_t)v->face;
  double tolerance = 1e-6 * fmax(size[0], size[1]);
  int n = 0;
  for (int k = b->last_visit[v->face]; k >= 0; k = previous[k])
    if (all[k].turn == v->turn && fabs(all[k].origin[0] - v->origin[0]) <= tolerance &&
        fabs(all[k].origin[1] - v->origin[1]) <= tolerance)
      return 1;
    else if (++n > MAX_WINDINGS)
      return -1;
  return 0;
}

static int add_visit(builder *b, visit v, int number) {
  const quadrant *q = (const quadrant *)b->quadrants.item + number;
  size_t most = (size_t)VISITS_PER_FACE * (size_t)b->surface->n_faces + SPARE_VISITS;
  v.quadrant = number;
  if (b->near[v.face] == 2 || !is_in_support(b, &v, q))
    return 1;
  int visited = was_visited(b, &v);
  if (visited > 0)
    return 1;
  if (visited < 0 || b->visits.n > most) {
    b->status = tsi_fail(b->context, TSOLID_ERROR_REFUSED, stage,
                         "Face %d: functions overlap without measure, their knot intervals are far "
                         "larger than those of faces beside them",
                         b->surface->face_record[v.face]);
    return 0;
  }
  int here = (int)b->visits.n;
  if (!push(b, &b->visits, &v, 1) || !push(b, &b->chain, &b->last_visit[v.face], 1))
    return 0;
  b->last_visit[v.face] = here;
  return 1;
}

/* Whether faces may be unfolded over an edge: not round a sharp vertex, where all faces have a
 * corner at one place of the plane but do not fill four quadrants. */
static int is_crossed(const builder *b, int link) {
  const tsolid_surface *s = b->surface;
  return s->link[s->link[link].opposite].face >= 0 && !b->mesh.natural[s->link[link].edge] &&
         b->mesh.kind[s->link[link].vertex] != TSI_SHARP &&
         b->mesh.kind[tsi_destination(s, link)] != TSI_SHARP;
}

/* The neighbours of a visited face across its edges inside the support. */
static int visit_neighbours(builder *b, int k) {
  const tsolid_surface *s = b->surface;
  visit v = ((visit *)b->visits.item)[k];
  int first = s->face_link[v.face], i = first;
  do {
    const quadrant *q = (const quadrant *)b->quadrants.item + v.quadrant;
    int other = s->link[i].opposite, direction = v.turn + b->mesh.side[i];
    double x = s->interval[s->link[i].edge], uv[2], a[2], step[2], z[2];
    origin_in_face(&b->mesh, i, uv);
    turn_vector(v.turn, uv[0], uv[1], a);
    turn_vector(direction, x, 0.0, step);
    for (int d = 0; d < 2; d++) {
      a[d] += v.origin[d];
      z[d] = a[d] + step[d];
    }
    int along = direction & 1; /* the axis that the edge runs along */
    if (is_crossed(b, i) &&
        overlaps(fmin(a[along], z[along]), fmax(a[along], z[along]), q->end[along]) &&
        !add_visit(b, place_face(&b->mesh, other, direction + 2 - b->mesh.side[other], z),
                   v.quadrant))
      return 0;
    i = s->link[i].next;
  } while (i != first);
  return 1;
}

/* Lays a function out over one quadrant; `link` is of the quadrant's face at the vertex, its side
 * turned by `turn` from the x axis. */
static int lay_out(builder *b, quadrant *q, int link, int turn) {
  static const double zero[2] = {0.0, 0.0};
  if (!(q->end[0] > 0.0) || !(q->end[1] > 0.0))
    return 1;
  size_t first = b->visits.n;
  int number = (int)b->quadrants.n;
  if (!push(b, &b->quadrants, q, 1))
    return 0;
  if (!add_visit(b, place_face(&b->mesh, link, turn - b->mesh.side[link], zero), number))
    return 0;
  for (size_t k = first; k < b->visits.n; k++)
    if (!visit_neighbours(b, (int)k))
      return 0;
  for (size_t k = first; k < b->visits.n; k++)
    b->last_visit[((visit *)b->visits.item)[k].face] = -1;
  return 1;
}

/* ---- functions ---------------------------------------------------------------------------------
 */

/* Five knots outwards along one axis of a quadrant. */
static void set_axis(quadrant *q, int axis, const tsi_half *out, const tsi_half *back) {
  const tsi_half *mirror = out->own_natural ? out : back;
  q->knot[axis][0] = -mirror->knot[1];
  q->knot[axis][1] = -mirror->knot[0];
  q->knot[axis][2] = 0.0;
  q->knot[axis][3] = out->knot[0];
  q->knot[axis][4] = out->knot[1];
  q->end[axis] = fmin(out->knot[1], out->stop);
  q->cut_value |= out->own_natural << axis;
  if (out->stop <= out->knot[1])
    q->cut_value |= 4 << axis;
}

static int add_regular(builder *b, int vertex, int point, int i, int j) {
  const tsolid_surface *s = b->surface;
  tsi_half half[4];
  for (int d = 0; d < 4; d++)
    half[d] = tsi_mesh_half(&b->mesh, vertex, d, i, j);
  for (int d = 0; d < 4; d++) {
    quadrant q = {.point = point};
    tsi_way way = tsi_vertex_way(s, vertex, d);
    if (way.kind == TSI_OUTSIDE || s->link[way.link].face < 0)
      continue;
    set_axis(&q, 0, &half[d], &half[(d + 2) & 3]);
    set_axis(&q, 1, &half[(d + 1) & 3], &half[(d + 3) & 3]);
    if (!lay_out(b, &q, way.link, way.kind == TSI_ALONG ? 0 : 3))
      return 0;
  }
  return 1;
}

/* Each face at a corner or a sharp vertex by itself. */
static int add_corner(builder *b, int vertex) {
  const tsolid_surface *s = b->surface;
  int first = s->vertex_link[vertex], i = first;
  do {
    int left = s->link[s->link[i].prev].opposite;
    if (s->link[i].face >= 0) {
      quadrant q = {.point = tsi_primary_point(s, vertex)};
      tsi_half x = tsi_mesh_corner_half(&b->mesh, i), y = tsi_mesh_corner_half(&b->mesh, left);
      set_axis(&q, 0, &x, &x);
      set_axis(&q, 1, &y, &y);
      if (!lay_out(b, &q, i, 0))
        return 0;
    }
    i = left;
  } while (i != first);
  return 1;
}

static int add_functions(builder *b) {
  const tsolid_surface *s = b->surface;
  for (int v = 0; v < s->n_vertices; v++) {
    const int *extra = s->tsm.extra[v];
    size_t at = s->tsm.grip_start[v];
    if ((b->mesh.kind[v] == TSI_CORNER || b->mesh.kind[v] == TSI_SHARP) && !add_corner(b, v))
      return 0;
    if (b->mesh.kind[v] != TSI_REGULAR)
      continue;
    for (int j = -extra[TSI_SOUTH]; j <= extra[TSI_NORTH]; j++)
      for (int i = -extra[TSI_WEST]; i <= extra[TSI_EAST]; i++, at++)
        if (s->tsm.grip[at] >= 0 && !add_regular(b, v, s->tsm.grip[at], i, j))
          return 0;
  }
  return 1;
}

/* ---- elements ----------------------------------------------------------------------------------
 */

static int compare_numbers(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Sorts cuts and drops repeated ones; returns how many are left. */
static int tidy_cuts(double *cut, int n, double length) {
  int n_kept = 0;
  qsort(cut, (size_t)n, sizeof *cut, compare_numbers);
  for (int c = 0; c < n; c++)
    if (n_kept == 0 || cut[c] > cut[n_kept - 1] + agreement * length)
      cut[n_kept++] = cut[c];
  return n_kept;
}

/* The lines of all functions across a face, its own borders among them. */
static int find_cuts(builder *b, int face, int axis, double *cut, int *n) {
  double length = b->mesh.size[2 * (size_t)face + (size_t)axis];
  int n_cuts = 0;
  cut[n_cuts++] = 0.0;
  cut[n_cuts++] = length;
  for (size_t k = b->visit_start[face]; k < b->visit_start[face + 1]; k++) {
    const visit *v = (const visit *)b->visits.item + k;
    const quadrant *q = (const quadrant *)b->quadrants.item + v->quadrant;
    int along = (axis + v->turn) & 1, reversed = axis ? v->turn == 1 || v->turn == 2 : v->turn >= 2;
    for (int i = 2; i < 5; i++) {
      double x = q->knot[along][i] - v->origin[along];
      x = reversed ? -x : x;
      if (!(x > agreement * length) || !(x < length * (1.0 - agreement)) ||
          q->knot[along][i] > q->end[along])
        continue;
      if (n_cuts == MAX_CUTS && (n_cuts = tidy_cuts(cut, n_cuts, length)) > MAX_CUTS / 2) {
        b->status = tsi_fail(b->context, TSOLID_ERROR_REFUSED, stage,
                             "Face %d is cut by more than %d lines", b->surface->face_record[face],
                             MAX_CUTS / 2);
        return 0;
      }
      cut[n_cuts++] = x;
    }
  }
  *n = tidy_cuts(cut, n_cuts, length);
  cut[*n - 1] = length;
  return 1;
}

/* Coefficients along one axis of a quadrant on [low, high] of it. */
static void axis_coefficients(const quadrant *q, int axis, double low, double high, double c[4]) {
  double knot[5], tolerance = agreement * (high - low);
  for (int i = 0; i < 5; i++) {
    knot[i] = q->knot[axis][i];
    if (fabs(knot[i] - low) <= tolerance)
      knot[i] = low;
    if (fabs(knot[i] - high) <= tolerance)
      knot[i] = high;
  }
  tsi_bspline_bernstein(3, knot, low, high, c);
  if ((q->cut_value & 1 << axis) && fabs(low) <= tolerance)
    c[0] = 1.0;
  if ((q->cut_value & 4 << axis) && fabs(high - q->end[axis]) <= tolerance)
    c[3] = 0.0;
}

static void reverse(double c[4]) {
  for (int i = 0; i < 2; i++) {
    double x = c[i];
    c[i] = c[3 - i];
    c[3 - i] = x;
  }
}

/* The function of a visit on the box (u0, u1, v0, v1) of its face; 0: it vanishes there. */
static int box_coefficients(const builder *b, const visit *v, const double box[4], double c[16]) {
  const quadrant *q = (const quadrant *)b->quadrants.item + v->quadrant;
  double placed[4], x[4], y[4];
  placed_box(v, box, placed);
  for (int d = 0; d < 2; d++) {
    double middle = 0.5 * (placed[2 * d] + placed[2 * d + 1]);
    if (middle <= 0.0 || middle >= q->end[d])
      return 0;
  }
  axis_coefficients(q, 0, placed[0], placed[1], x);
  axis_coefficients(q, 1, placed[2], placed[3], y);
  const double *cu = v->turn & 1 ? y : x, *cv = v->turn & 1 ? x : y;
  if (v->turn >= 2)
    reverse(v->turn & 1 ? y : x);
  if (v->turn == 1 || v->turn == 2)
    reverse(v->turn & 1 ? x : y);
  int any = 0;
  for (int i = 0; i < 16; i++) {
    c[i] = cu[i % 4] * cv[i / 4];
    any |= c[i] > 0.0;
  }
  return any;
}

/* Adds one function to the running element. */
static int add_entry(builder *b, int point, const double c[16]) {
  double *all = b->coefficient.item;
  if (b->place[point] >= 0) {
    for (size_t i = 0; i < 16; i++)
      all[16 * (size_t)b->place[point] + i] += c[i];
    return 1;
  }
  b->place[point] = (int)b->function.n;
  return push(b, &b->function, &point, 1) && push(b, &b->coefficient, c, 16);
}

static int end_element(builder *b, size_t first) {
  const int *function = b->function.item;
  for (size_t k = first; k < b->function.n; k++)
    b->place[function[k]] = -1;
  if (b->function.n > TSI_MAX_COUNT / 16) {
    b->status = tsi_fail(b->context, TSOLID_ERROR_REFUSED, stage, "The surface is too large");
    return 0;
  }
  int end = (int)b->function.n;
  return push(b, &b->function_start, &end, 1);
}

static int make_element(builder *b, int face, const double box[4]) {
  double c[16];
  size_t first = b->function.n;
  if (!push(b, &b->box, box, 4))
    return 0;
  if (b->near[face]) {
    const tsi_net *net = &b->net[face];
    for (int k = 0; k < net->n; k++)
      if (!add_entry(b, net->function[k], net->coefficient[k]))
        return 0;
    return end_element(b, first);
  }
  for (size_t k = b->visit_start[face]; k < b->visit_start[face + 1]; k++) {
    const visit *v = (const visit *)b->visits.item + k;
    const quadrant *q = (const quadrant *)b->quadrants.item + v->quadrant;
    if (box_coefficients(b, v, box, c) && !add_entry(b, q->point, c))
      return 0;
  }
  return end_element(b, first);
}

/* Faces of no area have no elements. */
static int cut_face(builder *b, int face, double *cut, int n[2]) {
  const double *size = b->mesh.size + 2 * (size_t)face;
  n[0] = n[1] = 1;
  if (!(size[0] > 0.0) || !(size[1] > 0.0))
    return 1;
  return find_cuts(b, face, 0, cut, &n[0]) && find_cuts(b, face, 1, cut + MAX_CUTS, &n[1]);
}

static int make_elements(builder *b) {
  tsolid_surface *s = b->surface;
  double *cut = tsi_arena_new(b->arena, 2 * (size_t)MAX_CUTS, sizeof *cut);
  int zero = 0, n[2];
  s->element_start = tsi_arena_new(&s->arena, (size_t)s->n_faces + 1, sizeof *s->element_start);
  if (!cut || !s->element_start) {
    b->status = tsi_no_memory(b->context, stage);
    return 0;
  }
  if (!push(b, &b->function_start, &zero, 1))
    return 0;
  for (int f = 0; f < s->n_faces; f++) {
    if (!cut_face(b, f, cut, n))
      return 0;
    for (int j = 0; j + 1 < n[1]; j++)
      for (int i = 0; i + 1 < n[0]; i++) {
        double box[4] = {cut[i], cut[i + 1], cut[MAX_CUTS + j], cut[MAX_CUTS + j + 1]};
        if (!make_element(b, f, box))
          return 0;
      }
    s->element_start[f + 1] = (int)(b->box.n / 4);
  }
  return 1;
}

/* ---- faces near stars --------------------------------------------------------------------------
 */

/* Nets of the faces that touch those at stars; they must be one element each. */
static int make_nets(builder *b) {
  const tsolid_surface *s = b->surface;
  double c[16], *cut = tsi_arena_new(b->arena, 2 * (size_t)MAX_CUTS, sizeof *cut);
  int n[2];
  b->net = tsi_arena_new(b->arena, (size_t)s->n_faces, sizeof *b->net);
  if (!b->net || !cut) {
    b->status = tsi_no_memory(b->context, stage);
    return 0;
  }
  for (int f = 0; f < s->n_faces; f++) {
    if (!b->near[f])
      continue;
    if (!cut_face(b, f, cut, n))
      return 0;
    if (n[0] != 2 || n[1] != 2) {
      b->status = tsi_star_refuse(&b->mesh, b->arena, f);
      return 0;
    }
    double box[4] = {0.0, cut[1], 0.0, cut[MAX_CUTS + 1]};
    for (size_t k = b->visit_start[f]; k < b->visit_start[f + 1]; k++) {
      const visit *v = (const visit *)b->visits.item + k;
      const quadrant *q = (const quadrant *)b->quadrants.item + v->quadrant;
      if (!box_coefficients(b, v, box, c))
        continue;
      for (int i = 0; i < 16; i++)
        if (!tsi_net_add(b->arena, &b->net[f], q->point, i, c[i])) {
          b->status = tsi_no_memory(b->context, stage);
          return 0;
        }
    }
  }
  b->status = tsi_star_nets(&b->mesh, b->arena, b->near, b->net);
  return !b->status;
}

/* ---- the driver --------------------------------------------------------------------------------
 */

/* Visits face by face, in their order. */
static int sort_visits(builder *b) {
  size_t n = b->visits.n, n_faces = (size_t)b->surface->n_faces;
  visit *from = b->visits.item, *to = tsi_new(&b->context->allocator, n, sizeof *to);
  size_t *next = tsi_arena_new(b->arena, n_faces + 1, sizeof *next);
  b->visit_start = tsi_arena_new(b->arena, n_faces + 1, sizeof *b->visit_start);
  if (!to || !next || !b->visit_start) {
    tsi_delete(&b->context->allocator, to);
    b->status = tsi_no_memory(b->context, stage);
    return 0;
  }
  for (size_t k = 0; k < n; k++)
    b->visit_start[from[k].face + 1]++;
  for (size_t f = 0; f < n_faces; f++)
    next[f + 1] = b->visit_start[f + 1] += b->visit_start[f];
  for (size_t k = 0; k < n; k++)
    to[next[from[k].face]++] = from[k];
  tsi_delete(&b->context->allocator, from);
  b->visits.item = to;
  b->visits.capacity = n;
  return 1;
}

static int start(builder *b) {
  size_t n_faces = (size_t)b->surface->n_faces, n_points = (size_t)b->surface->n_points;
  b->status = tsi_mesh_create(b->context, b->arena, b->surface, &b->mesh);
  if (!b->status)
    b->status = tsi_star_faces(&b->mesh, b->arena, &b->near);
  b->last_visit = tsi_arena_new(b->arena, n_faces, sizeof *b->last_visit);
  b->place = tsi_arena_new(b->arena, n_points, sizeof *b->place);
  if (!b->status && (!b->last_visit || !b->place))
    b->status = tsi_no_memory(b->context, stage);
  for (size_t f = 0; !b->status && f < n_faces; f++)
    b->last_visit[f] = -1;
  for (size_t k = 0; !b->status && k < n_points; k++)
    b->place[k] = -1;
  return !b->status;
}

/* A list as an array of the surface. */
static void *keep(builder *b, list *of) {
  void *kept = tsi_arena_new(&b->surface->arena, of->n, of->size);
  if (!kept)
    b->status = tsi_no_memory(b->context, stage);
  else if (of->n)
    memcpy(kept, of->item, of->n * of->size);
  drop(b, of);
  return kept;
}

static void finish(builder *b) {
  tsolid_surface *s = b->surface;
  if (b->box.n == 0) {
    b->status = tsi_fail(b->context, TSOLID_ERROR_INPUT, stage, "All faces have no area");
    return;
  }
  s->degree = 3;
  s->box = keep(b, &b->box);
  s->function_start = keep(b, &b->function_start);
  s->function = keep(b, &b->function);
  s->coefficient = keep(b, &b->coefficient);
  if (!b->status)
    b->status = tsi_star_notes(&b->mesh, b->arena);
}

tsolid_status tsi_surface_basis(tsolid_context *context, tsolid_surface *surface) {
  tsi_arena arena = tsi_arena_create(context);
  builder b = {.context = context, .surface = surface, .arena = &arena};
  b.quadrants.size = sizeof(quadrant);
  b.visits.size = sizeof(visit);
  b.chain.size = b.function.size = b.function_start.size = sizeof(int);
  b.box.size = b.coefficient.size = sizeof(double);
  if (start(&b) && add_functions(&b) && sort_visits(&b) && make_nets(&b) && make_elements(&b))
    finish(&b);
  drop(&b, &b.quadrants);
  drop(&b, &b.visits);
  drop(&b, &b.chain);
  drop(&b, &b.box);
  drop(&b, &b.function_start);
  drop(&b, &b.function);
  drop(&b, &b.coefficient);
  tsi_arena_free(&arena);
  return b.status;
}
