/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Local knot vectors on a T-mesh.
 *
 * A ray from a vertex runs straight on along edges, and across faces where there is none; every
 * line that it meets is a knot. Round a vertex directions are counted in quadrants: a corner of a
 * face takes one, a T-junction on its side two.
 *
 * A vertex may have further control points: S of them in a compass direction are S more lines
 * parallel to the one through the vertex, at no distance (multiple knots). A line goes on along an
 * edge as far as both ends have it; a ray in the row of a further control point meets what crosses
 * its own row.
 *
 * At the open border, two end conditions:
 *   Bezier   where vertices have a further control point inwards: the border's knot is repeated
 *            without end, as NURBS have it;
 *   natural  where they have none: the interval before the border is mirrored beyond it, with
 *            control points mirrored at those of the border, P_-1 = 2 P_0 - P_1. The border is then
 *            the B-spline curve of its own control points and the second derivative across is
 *            zero, as at the boundary of a subdivision surface. In terms of functions: those of the
 *            border have value 1 there, the others 0; else they are what the mirrored knots give.
 * An inner edge with an end condition and no multiple knot is a crease: natural from both sides.
 *
 * Triple knots along edges, as faces of no area on both sides of a line make them, tear the surface
 * to C^0 there. Where such lines meet with other than four faces, all edges at the vertex have
 * interval 0: a sharp vertex. Rays end there, its value repeats without end, and the vertex's own
 * function is (1 - x/a)^3 (1 - y/b)^3 on each face, a and b the first intervals other than 0. A
 * line that has interval 0 from there for one knot only is sharp at the vertex and fades out. */
#include "surface_rays.h"

static const char stage[] = "surface";
static const double agreement = 1e-9; /* of positions on opposite sides, relative to their length */

/* Positions are sums of intervals: beyond this they would not be told apart within `agreement`. */
static const double largest_ratio = 1e6;

enum { MAX_STEPS = 64 };

/* ---- directions --------------------------------------------------------------------------------
 */

tsi_way tsi_turn(const tsolid_surface *s, int a, int n) {
  int i = a, left = n;
  while (left > 0 && s->link[i].face != -1) {
    int q = s->link[i].straight ? 2 : 1;
    if (q > left)
      return (tsi_way){TSI_ACROSS, i, 0.0};
    left -= q;
    i = s->link[s->link[i].prev].opposite;
  }
  if (left == 0)
    return (tsi_way){TSI_ALONG, i, 0.0};
  for (i = a, left = 4 - n; left > 0;) {
    i = s->link[s->link[i].opposite].next;
    if (s->link[i].face == -1)
      return (tsi_way){TSI_OUTSIDE, -1, 0.0};
    int q = s->link[i].straight ? 2 : 1;
    if (q > left)
      return (tsi_way){TSI_ACROSS, i, 0.0};
    left -= q;
  }
  return (tsi_way){TSI_ALONG, i, 0.0};
}

tsi_way tsi_vertex_way(const tsolid_surface *s, int vertex, int d) {
  return tsi_turn(s, s->vertex_link[vertex], (d - s->tsm.compass[vertex]) & 3);
}

/* Compass direction of a link at its regular origin. */
static int compass_of(const tsolid_surface *s, int link) {
  int vertex = s->link[link].vertex, n = 0, i = s->vertex_link[vertex];
  while (i != link && s->link[i].face != -1) {
    n += s->link[i].straight ? 2 : 1;
    i = s->link[s->link[i].prev].opposite;
  }
  if (i != link)
    for (n = 0, i = s->vertex_link[vertex]; i != link;) {
      i = s->link[s->link[i].opposite].next;
      n -= s->link[i].straight ? 2 : 1;
    }
  return (s->tsm.compass[vertex] + n) & 3;
}

int tsi_primary_point(const tsolid_surface *s, int vertex) {
  const int *extra = s->tsm.extra[vertex];
  size_t width = (size_t)(1 + extra[TSI_EAST] + extra[TSI_WEST]);
  return s->tsm
      .grip[s->tsm.grip_start[vertex] + (size_t)extra[TSI_WEST] + width * (size_t)extra[TSI_SOUTH]];
}

/* ---- lines -------------------------------------------------------------------------------------
 */

/* Further lines that go along the whole edge of a link, on its left and its right. */
static void count_lines(const tsolid_surface *s, int link, int lines[2]) {
  int b = s->link[link].opposite;
  const int *p = s->tsm.extra[s->link[link].vertex], *q = s->tsm.extra[s->link[b].vertex];
  int d = compass_of(s, link), e = compass_of(s, b); /* e looks back */
  int left[2] = {p[(d + 1) & 3], q[(e + 3) & 3]}, right[2] = {p[(d + 3) & 3], q[(e + 1) & 3]};
  lines[0] = left[0] < left[1] ? left[0] : left[1];
  lines[1] = right[0] < right[1] ? right[0] : right[1];
}

static int count_lines_across(const tsolid_surface *s, int link) {
  int lines[2];
  count_lines(s, link, lines);
  return 1 + lines[0] + lines[1];
}

/* Whether functions end at the edge with the natural condition. */
static int edge_is_natural(const tsolid_surface *s, int edge) {
  int a = s->edge_link[edge], lines[2];
  int border = s->link[a].face == -1 || s->link[s->link[a].opposite].face == -1;
  if (!border && s->tsm.condition[edge] < 0)
    return 0;
  count_lines(s, a, lines);
  return lines[0] + lines[1] < (border ? 1 : 2);
}

static int is_natural_line(const tsi_mesh *m, const tsi_way *way) {
  return way->kind == TSI_ALONG && m->natural[m->surface->link[way->link].edge];
}

static int is_crease_line(const tsi_mesh *m, const tsi_way *way) {
  const tsi_link *link = m->surface->link;
  return is_natural_line(m, way) && link[way->link].face != -1 &&
         link[link[way->link].opposite].face != -1;
}

/* ---- kinds of vertices -------------------------------------------------------------------------
 */

static tsolid_status refuse_vertex(tsolid_context *context, const tsolid_surface *s, int vertex,
                                   const char *why) {
  return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "Vertex %d: %s", s->vertex_record[vertex],
                  why);
}

/* At most triple knots inside, one more row of control points at the border. */
static tsolid_status check_multiplicity(const tsi_mesh *m, int vertex) {
  const tsolid_surface *s = m->surface;
  const int *extra = s->tsm.extra[vertex];
  if (extra[0] + extra[1] + extra[2] + extra[3] == 0)
    return TSOLID_OK;
  int border, quadrants = tsi_vertex_quadrants(s, vertex, &border);
  if (m->kind[vertex] != TSI_REGULAR || (border >= 0 && quadrants > 3))
    return refuse_vertex(m->context, s, vertex,
                         "multiple knots where not four quadrants meet are not known");
  for (int d = 0; d < 4; d++) {
    int opposite = extra[(d + 2) & 3];
    int outside = tsi_vertex_way(s, vertex, (d + 2) & 3).kind == TSI_OUTSIDE;
    if (outside && opposite > 0)
      return refuse_vertex(m->context, s, vertex, "has control points outside the border");
    if (extra[d] + opposite > (outside ? 1 : 2))
      return refuse_vertex(m->context, s, vertex,
                           "has a knot of a multiplicity that tears the surface");
  }
  return TSOLID_OK;
}

/* Whether all edges there have interval 0 and start corners of faces. */
static int is_sharp(const tsolid_surface *s, int vertex) {
  int i = s->vertex_link[vertex];
  do {
    if (s->link[i].straight || s->interval[s->link[i].edge] > 0.0)
      return 0;
    i = s->link[s->link[i].prev].opposite;
  } while (i != s->vertex_link[vertex]);
  return 1;
}

static tsi_vertex_kind find_kind(const tsi_mesh *m, int vertex) {
  const tsolid_surface *s = m->surface;
  int border, quadrants = tsi_vertex_quadrants(s, vertex, &border);
  int n_inner = 0, n_creases = 0, i = s->vertex_link[vertex];
  do {
    tsi_way way = {TSI_ALONG, i, 0.0};
    int outer = s->link[i].face == -1 || s->link[s->link[i].opposite].face == -1;
    n_inner += !outer;
    n_creases += is_crease_line(m, &way);
    i = s->link[s->link[i].prev].opposite;
  } while (i != s->vertex_link[vertex]);
  int natural_border = border >= 0 && m->natural[s->link[border].edge];
  int straight =
      border < 0 ? quadrants == 4 : quadrants <= 2 || (!natural_border && quadrants <= 3);
  if (straight && n_creases == 0)
    return TSI_REGULAR;
  if (straight && border < 0) { /* creases go straight on, both or none on each line */
    int pair[2];
    for (int d = 0; d < 2; d++) {
      tsi_way a = tsi_vertex_way(s, vertex, d), b = tsi_vertex_way(s, vertex, d + 2);
      pair[d] = is_crease_line(m, &a) == is_crease_line(m, &b);
    }
    if (pair[0] && pair[1])
      return TSI_REGULAR;
  }
  if (straight && border >= 0 && quadrants == 2 && natural_border)
    return TSI_REGULAR;
  if (border < 0 && n_creases == 0 && is_sharp(s, vertex))
    return TSI_SHARP;
  return n_creases > 0 && n_creases == n_inner ? TSI_CORNER : TSI_STAR;
}

static tsolid_status check_intervals(tsolid_context *context, const tsolid_surface *s) {
  int least = -1, most = -1;
  for (int e = 0; e < s->n_edges; e++) {
    if (!(s->interval[e] > 0.0))
      continue;
    least = least < 0 || s->interval[e] < s->interval[least] ? e : least;
    most = most < 0 || s->interval[e] > s->interval[most] ? e : most;
  }
  if (least < 0 || s->interval[most] <= largest_ratio * s->interval[least])
    return TSOLID_OK;
  return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                  "The knot intervals of edges %d and %d, %g and %g, are too different: at most %g "
                  "to 1 is taken",
                  s->tsm.edge_record[most], s->tsm.edge_record[least], s->interval[most],
                  s->interval[least], largest_ratio);
}

tsolid_status tsi_mesh_create(tsolid_context *context, tsi_arena *arena, const tsolid_surface *s,
                              tsi_mesh *m) {
  tsolid_status status = check_intervals(context, s);
  *m = (tsi_mesh){.context = context, .surface = s};
  if (status)
    return status;
  m->side = tsi_arena_new(arena, (size_t)s->n_links, sizeof *m->side);
  m->at = tsi_arena_new(arena, (size_t)s->n_links, sizeof *m->at);
  m->size = tsi_arena_new(arena, (size_t)s->n_faces, 2 * sizeof *m->size);
  m->kind = tsi_arena_new(arena, (size_t)s->n_vertices, 1);
  m->natural = tsi_arena_new(arena, (size_t)s->n_edges, 1);
  if (!m->side || !m->at || !m->size || !m->kind || !m->natural)
    return tsi_no_memory(context, stage);
  for (int f = 0; f < s->n_faces; f++) {
    int i = s->face_link[f], side = -1;
    double at = 0.0;
    tsi_face_lengths(s, f, m->size + 2 * (size_t)f);
    do {
      if (!s->link[i].straight) {
        side++;
        at = 0.0;
      }
      m->side[i] = side;
      m->at[i] = at;
      at += s->interval[s->link[i].edge];
      i = s->link[i].next;
    } while (i != s->face_link[f]);
  }
  for (int e = 0; e < s->n_edges; e++)
    m->natural[e] = (char)edge_is_natural(s, e);
  for (int v = 0; !status && v < s->n_vertices; v++) {
    m->kind[v] = (char)find_kind(m, v);
    status = check_multiplicity(m, v);
  }
  return status;
}

/* ---- rays --------------------------------------------------------------------------------------
 */

/* The next line that a ray meets: `n` knots at once, `distance` farther on. */
typedef struct meeting {
  double distance;
  int n;
  enum { GOES_ON, ENDS, ENDS_NATURAL, ENDS_AT_STAR } end; /* ENDS: the knot repeats for ever */
} meeting;

/* A ray arrives at a vertex; forward is `n` quadrants from link `from` there. */
static void arrive(const tsi_mesh *m, int from, int n, int *row, tsi_way *way, meeting *met) {
  const tsolid_surface *s = m->surface;
  int vertex = s->link[from].vertex;
  met->n = 1;
  met->end = GOES_ON;
  if (m->kind[vertex] != TSI_REGULAR) {
    met->end = m->kind[vertex] == TSI_CORNER ? ENDS_NATURAL : ENDS_AT_STAR;
    return;
  }
  const int *extra = s->tsm.extra[vertex];
  int d = (compass_of(s, from) + n) & 3;
  *way = tsi_vertex_way(s, vertex, d);
  tsi_way left = tsi_vertex_way(s, vertex, (d + 1) & 3);
  tsi_way right = tsi_vertex_way(s, vertex, (d + 3) & 3);
  if (is_crease_line(m, &left) || is_crease_line(m, &right)) {
    met->end = ENDS_NATURAL;
    return;
  }
  if (*row > extra[(d + 1) & 3])
    met->n = left.kind == TSI_ALONG ? count_lines_across(s, left.link) : 0;
  else if (-*row > extra[(d + 3) & 3])
    met->n = right.kind == TSI_ALONG ? count_lines_across(s, right.link) : 0;
  else
    met->n = 1 + extra[d] + extra[(d + 2) & 3];
  if (way->kind == TSI_OUTSIDE)
    met->end = is_natural_line(m, &left) || is_natural_line(m, &right) ? ENDS_NATURAL : ENDS;
  if (way->kind == TSI_ACROSS)
    *row = 0;
}

/* Across a face, from a place on one side to the opposite one. */
static void cross_face(const tsi_mesh *m, int *row, tsi_way *way, meeting *met) {
  const tsolid_surface *s = m->surface;
  int face = s->link[way->link].face, side = m->side[way->link], i = way->link;
  double length = m->size[2 * (size_t)face + (side & 1)];
  double at = length - (m->at[way->link] + way->offset);
  met->distance = m->size[2 * (size_t)face + 1 - (side & 1)];
  while (m->side[i] != (side + 2) % 4)
    i = s->link[i].next;
  for (; m->side[s->link[i].next] == (side + 2) % 4; i = s->link[i].next)
    if (at <= m->at[s->link[i].next] - agreement * length)
      break;
  if (fabs(at - m->at[i]) <= agreement * length) {
    arrive(m, i, 3, row, way, met);
    return;
  }
  int b = s->link[i].opposite;
  double from_end = m->at[i] + s->interval[s->link[i].edge] - at;
  *way = (tsi_way){TSI_ACROSS, b, from_end};
  met->n = count_lines_across(s, i);
  met->end = m->natural[s->link[i].edge] ? ENDS_NATURAL : s->link[b].face == -1 ? ENDS : GOES_ON;
  *row = 0;
}

static void advance(const tsi_mesh *m, int *row, tsi_way *way, meeting *met) {
  const tsolid_surface *s = m->surface;
  if (way->kind == TSI_ALONG) {
    met->distance = s->interval[s->link[way->link].edge];
    arrive(m, s->link[way->link].opposite, 2, row, way, met);
  } else {
    cross_face(m, row, way, met);
  }
}

/* Fills the knots from number n on, from where the ray is at distance 0. */
static void shoot(const tsi_mesh *m, tsi_way way, int row, int n, tsi_half *half) {
  double distance = 0.0;
  for (int step = 0; n < 2 && way.kind != TSI_OUTSIDE && step < MAX_STEPS; step++) {
    meeting met = {.distance = 0.0};
    advance(m, &row, &way, &met);
    distance += met.distance;
    for (; n < 2 && met.n > 0; met.n--)
      half->knot[n++] = distance;
    if (met.end == ENDS_NATURAL) {
      half->stop = distance;
      if (n < 2)
        half->knot[n++] = 2.0 * distance;
    }
    if (met.end != GOES_ON)
      break;
  }
  for (; n < 2; n++)
    half->knot[n] = distance;
}

tsi_half tsi_mesh_half(const tsi_mesh *m, int vertex, int d, int i, int j) {
  const tsolid_surface *s = m->surface;
  const int *extra = s->tsm.extra[vertex];
  const int offset[4] = {i, j, -i, -j}, rows[4] = {j, -i, -j, i};
  tsi_half half = {.stop = INFINITY};
  tsi_way way = tsi_vertex_way(s, vertex, d);
  tsi_way back = tsi_vertex_way(s, vertex, (d + 2) & 3);
  tsi_way left = tsi_vertex_way(s, vertex, (d + 1) & 3);
  tsi_way right = tsi_vertex_way(s, vertex, (d + 3) & 3);
  half.own_natural =
      is_crease_line(m, &left) || is_crease_line(m, &right) ||
      (back.kind == TSI_OUTSIDE && (is_natural_line(m, &left) || is_natural_line(m, &right)));
  int n = 0;
  for (int k = extra[d] - offset[d]; n < 2 && k > 0; k--)
    half.knot[n++] = 0.0;
  shoot(m, way, rows[d], n, &half);
  return half;
}

tsi_half tsi_mesh_corner_half(const tsi_mesh *m, int link) {
  int natural = m->kind[m->surface->link[link].vertex] == TSI_CORNER;
  tsi_half half = {.stop = INFINITY, .own_natural = natural};
  shoot(m, (tsi_way){TSI_ALONG, link, 0.0}, 0, 0, &half);
  return half;
}
