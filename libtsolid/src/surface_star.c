/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The surface round stars: vertices where not four quadrants meet, corners of the open border with
 * three or more faces, ends and bends of creases.
 *
 * A face at a star with corners V_00 V_10 V_11 V_01 and knot intervals h (along u) and k has four
 * face points, its inner Bezier points,
 *
 *   f(a,b) = sum over i, j of p_a(i) q_b(j) V_ij,           a, b in {0, 1},
 *   p_0 = (h + h+, h-) / (h- + h + h+),  p_1 = (h+, h- + h) / (h- + h + h+),  q alike with k,
 *
 * where h- and h+ are the intervals of the faces across u = 0 and u = h (h itself across a natural
 * end). A Bezier point on an edge is the mean of the two face points beside it with weights 1 /
 * (the interval of their own face across the edge); the one at a vertex is the mean of the face
 * points round it with weights 1 / (product of the face's intervals). Natural ends and creases: the
 * points on the edge are those of the B-spline curve of its own two control points; the point at a
 * vertex where two such edges meet is the mean of their nearest points with weights 1 / interval,
 * and where three or more meet, or at the corner of one face, the control point itself.
 *
 * On a grid all this is the bicubic B-spline, C^2. Round a star it is one polynomial per face: C^0
 * along the spokes, with one tangent plane at a star of valence three (all first Bezier points of
 * the fan are in the plane of its three face points), C^2 across the edges opposite the star, and
 * beyond them C^2 where the intervals of the spokes are equal; else C^1 along the first edge that
 * carries a spoke on. It is the template of zero-interval spokes of Zhang, Wang and Hughes (2012)
 * with the template's control points put at these means; written as functions of the input's own
 * control points, all of them >= 0 with sum one.
 *
 * Sharp vertices, where all edges have interval 0, are none of these: surface_rays.c.
 *
 * A modeller has a rule of its own there. This surface differs from the modeller's within one ring
 * of faces round the star vertex, two rings where the intervals of the spokes differ; outside, the
 * Bezier points are those of the B-spline that the mesh is there. */
#include <stdio.h>

#include "surface_cube.h"
#include "surface_rays.h"

static const char stage[] = "surface";
static const double agreement = 1e-9; /* of knot intervals */

enum { MAX_NAMED = 12 };

/* Places among 16 Bezier points, u fastest: of corner c; of the face point beside it; of the edge
 * points on side c, near its start and near its end. */
static const int corner_place[4] = {0, 3, 15, 12};
static const int inner_place[4] = {5, 6, 10, 9};
static const int edge_place[4][2] = {{1, 2}, {7, 11}, {14, 13}, {8, 4}};

int tsi_net_add(tsi_arena *arena, tsi_net *net, int function, int index, double c) {
  int k = 0;
  while (k < net->n && net->function[k] != function)
    k++;
  if (k == net->n && k == net->capacity) {
    int capacity = 2 * net->capacity + 16;
    int *functions = tsi_arena_new(arena, (size_t)capacity, sizeof *functions);
    double(*grown)[16] = tsi_arena_new(arena, (size_t)capacity, sizeof *grown);
    if (!functions || !grown)
      return 0;
    if (k > 0) {
      memcpy(functions, net->function, (size_t)k * sizeof *functions);
      memcpy(grown, net->coefficient, (size_t)k * sizeof *grown);
    }
    net->function = functions;
    net->coefficient = grown;
    net->capacity = capacity;
  }
  if (k == net->n) {
    net->function[net->n++] = function;
    memset(net->coefficient[k], 0, sizeof net->coefficient[k]);
  }
  net->coefficient[k][index] += c;
  return 1;
}

/* ---- which faces -------------------------------------------------------------------------------
 */

/* Marks all faces round the vertices of the faces that have `from`. */
static void mark_touching(const tsolid_surface *s, char *near, char from, char with) {
  for (int f = 0; f < s->n_faces; f++) {
    if (near[f] != from)
      continue;
    int i = s->face_link[f];
    do {
      int k = i;
      do {
        int g = s->link[k].face;
        if (g >= 0 && !near[g])
          near[g] = with;
        k = s->link[s->link[k].prev].opposite;
      } while (k != i);
      i = s->link[i].next;
    } while (i != s->face_link[f]);
  }
}

/* The T-junction nearest to a face and the nearest star, in steps along links, for the message. */
tsolid_status tsi_star_refuse(const tsi_mesh *m, tsi_arena *arena, int face) {
  const tsolid_surface *s = m->surface;
  int *queue = tsi_arena_new(arena, (size_t)s->n_vertices, sizeof *queue), n = 0;
  char *seen = tsi_arena_new(arena, (size_t)s->n_vertices, 1);
  int star = -1, junction = -1;
  if (!queue || !seen)
    return tsi_no_memory(m->context, stage);
  int i = s->face_link[face];
  do {
    if (!seen[s->link[i].vertex]++)
      queue[n++] = s->link[i].vertex;
    i = s->link[i].next;
  } while (i != s->face_link[face]);
  for (int k = 0; k < n && (star < 0 || junction < 0); k++) {
    int v = queue[k], first = s->vertex_link[v];
    if (star < 0 && m->kind[v] == TSI_STAR)
      star = v;
    i = first;
    do {
      int w = tsi_destination(s, i);
      if (junction < 0 && s->link[i].straight)
        junction = v;
      if (!seen[w]++)
        queue[n++] = w;
      i = s->link[s->link[i].prev].opposite;
    } while (i != first);
  }
  if (star < 0 || junction < 0)
    return tsi_fail(m->context, TSOLID_ERROR_REFUSED, stage,
                    "Face %d: a star is too near to lines that end", s->face_record[face]);
  return tsi_fail(
      m->context, TSOLID_ERROR_REFUSED, stage,
      "T-junction at vertex %d is too near to the star at vertex %d: it must be neither "
      "on nor cut into the faces that touch those of the star",
      s->vertex_record[junction], s->vertex_record[star]);
}

/* Edges at a vertex with and without a knot interval. */
static int count_edges(const tsolid_surface *s, int vertex, int *n_zero) {
  int n = 0, i = s->vertex_link[vertex];
  *n_zero = 0;
  do {
    n++;
    *n_zero += !(s->interval[s->link[i].edge] > 0.0);
    i = s->link[s->link[i].prev].opposite;
  } while (i != s->vertex_link[vertex]);
  return n;
}

static tsolid_status refuse_slit(const tsi_mesh *m, int face) {
  const tsolid_surface *s = m->surface;
  int i = s->face_link[face];
  do {
    int vertex = s->link[i].vertex, n_zero, n = count_edges(s, vertex, &n_zero);
    if (m->kind[vertex] == TSI_STAR && n_zero > 0)
      return tsi_fail(m->context, TSOLID_ERROR_REFUSED, stage,
                      "Vertex %d is half sharp: %d of its %d edges have the knot interval 0, it "
                      "must be all or none",
                      s->vertex_record[vertex], n_zero, n);
    i = s->link[i].next;
  } while (i != s->face_link[face]);
  return tsi_fail(m->context, TSOLID_ERROR_REFUSED, stage,
                  "Face %d has no area, too near to a star that is not sharp",
                  s->face_record[face]);
}

tsolid_status tsi_star_faces(const tsi_mesh *m, tsi_arena *arena, char **out) {
  const tsolid_surface *s = m->surface;
  char *near = tsi_arena_new(arena, (size_t)s->n_faces, 1);
  *out = near;
  if (!near)
    return tsi_no_memory(m->context, stage);
  for (int i = 0; i < s->n_links; i++)
    if (s->link[i].face >= 0 && m->kind[s->link[i].vertex] == TSI_STAR)
      near[s->link[i].face] = 2;
  mark_touching(s, near, 2, 1);
  for (int f = 0; f < s->n_faces; f++) {
    const double *size = m->size + 2 * (size_t)f;
    if (!near[f])
      continue;
    int i = s->face_link[f];
    do {
      const int *extra = s->tsm.extra[s->link[i].vertex];
      if (s->link[i].straight)
        return tsi_star_refuse(m, arena, f);
      if (near[f] == 2 && extra[0] + extra[1] + extra[2] + extra[3] > 0)
        return tsi_fail(m->context, TSOLID_ERROR_REFUSED, stage,
                        "Face %d: multiple knots at vertex %d are too near to a star",
                        s->face_record[f], s->vertex_record[s->link[i].vertex]);
      i = s->link[i].next;
    } while (i != s->face_link[f]);
    if (!(size[0] > 0.0) || !(size[1] > 0.0))
      return refuse_slit(m, f);
  }
  return TSOLID_OK;
}

/* Rings of faces round a star where another rule may give another surface. */
static int count_rings(const tsolid_surface *s, int vertex) {
  int i = s->vertex_link[vertex];
  double least = INFINITY, most = 0.0;
  do {
    least = fmin(least, s->interval[s->link[i].edge]);
    most = fmax(most, s->interval[s->link[i].edge]);
    i = s->link[s->link[i].prev].opposite;
  } while (i != s->vertex_link[vertex]);
  return most - least <= agreement * most ? 1 : 2;
}

typedef struct star_facts {
  int vertex, n_edges, n_rings, noted;
} star_facts;

/* One note for all stars like number k, which is the first such. */
static void note_alike(const tsi_mesh *m, star_facts *star, int n_stars, int k) {
  static const char *const numbers[] = {"no", "one", "two", "three", "four", "five", "six"};
  char names[16 * MAX_NAMED] = "", edges[32];
  const star_facts like = star[k];
  int n = 0, last = k;
  for (int i = k; i < n_stars; i++)
    if (star[i].n_edges == like.n_edges && star[i].n_rings == like.n_rings) {
      last = i;
      n++;
    }
  for (int i = k, named = 0; i < n_stars; i++) {
    if (star[i].n_edges != like.n_edges || star[i].n_rings != like.n_rings)
      continue;
    star[i].noted = 1;
    size_t used = strlen(names);
    if (named < MAX_NAMED)
      snprintf(names + used, sizeof names - used, "%s%d",
               named == 0  ? ""
               : i == last ? " and "
                           : ", ",
               m->surface->vertex_record[star[i].vertex]);
    named++;
  }
  if (n > MAX_NAMED) {
    size_t used = strlen(names);
    snprintf(names + used, sizeof names - used, " and %d more", n - MAX_NAMED);
  }
  snprintf(edges, sizeof edges, "%d", like.n_edges);
  tsolid_finding note = tsi_finding(TSOLID_NOTE, TSOLID_OK, stage);
  if (n == 1) {
    note.entity = TSOLID_ENTITY_SURFACE_VERTEX;
    note.index[0] = m->surface->vertex_record[like.vertex];
    note.has_point = tsi_surface_vertex_point(m->surface, like.vertex, note.point);
  }
  tsi_report(m->context, &note,
             "Round %s %s (%s edges%s) the surface is the template's, whose edges there have knot "
             "intervals of zero: it may differ from the modeller's own within %s of faces",
             n == 1 ? "vertex" : "vertices", names,
             like.n_edges <= 6 ? numbers[like.n_edges] : edges, n == 1 ? "" : " each",
             like.n_rings == 1 ? "one ring" : "two rings");
}

tsolid_status tsi_star_notes(const tsi_mesh *m, tsi_arena *arena) {
  const tsolid_surface *s = m->surface;
  int n_stars = 0, n_zero;
  for (int v = 0; v < s->n_vertices; v++)
    n_stars += m->kind[v] == TSI_STAR;
  star_facts *star = tsi_arena_new(arena, (size_t)n_stars, sizeof *star);
  if (!star)
    return tsi_no_memory(m->context, stage);
  n_stars = 0;
  for (int v = 0; v < s->n_vertices; v++)
    if (m->kind[v] == TSI_STAR)
      star[n_stars++] = (star_facts){v, count_edges(s, v, &n_zero), count_rings(s, v), 0};
  for (int k = 0; k < n_stars; k++)
    if (!star[k].noted)
      note_alike(m, star, n_stars, k);
  return TSOLID_OK;
}

/* ---- points ------------------------------------------------------------------------------------
 */

typedef struct stars {
  const tsi_mesh *m;
  tsi_arena *arena;
  const char *near;
  tsi_net *net;
  int failed; /* out of memory */
} stars;

/* Length of a face perpendicular to a side. */
static double width_across(const tsi_mesh *m, int face, int side) {
  return m->size[2 * (size_t)face + 1 - (size_t)(side & 1)];
}

/* The interval beyond the side that a link is, all of it. */
static double width_beyond(const tsi_mesh *m, int link) {
  const tsolid_surface *s = m->surface;
  int other = s->link[link].opposite;
  if (m->natural[s->link[link].edge] || s->link[other].face < 0)
    return width_across(m, s->link[link].face, m->side[link]);
  return width_across(m, s->link[other].face, m->side[other]);
}

static void clear_point(stars *x, int face, int place) {
  tsi_net *net = &x->net[face];
  for (int k = 0; k < net->n; k++)
    net->coefficient[k][place] = 0.0;
}

static void add_function(stars *x, int face, int place, int point, double c) {
  if (!tsi_net_add(x->arena, &x->net[face], point, place, c))
    x->failed = 1;
}

/* Adds c times a Bezier point of face g to one of face f; never the same point. */
static void add_point(stars *x, int face, int place, int other, int from, double c) {
  for (int k = 0; k < x->net[other].n; k++) {
    double value = x->net[other].coefficient[k][from];
    if (value > 0.0)
      add_function(x, face, place, x->net[other].function[k], c * value);
  }
}

/* Links of the sides of a face without T-junctions. */
static void side_links(const tsolid_surface *s, int face, int link[4]) {
  link[0] = s->face_link[face];
  for (int k = 1; k < 4; k++)
    link[k] = s->link[link[k - 1]].next;
}

static void make_face_points(stars *x, int face) {
  const tsi_mesh *m = x->m;
  const double *size = m->size + 2 * (size_t)face;
  int link[4];
  double p[2][2][2]; /* axis, a, end */
  side_links(m->surface, face, link);
  for (int axis = 0; axis < 2; axis++) {
    double h = size[axis], before = width_beyond(m, link[axis ? 0 : 3]);
    double after = width_beyond(m, link[axis ? 2 : 1]), sum = before + h + after;
    p[axis][0][0] = (h + after) / sum;
    p[axis][0][1] = before / sum;
    p[axis][1][0] = after / sum;
    p[axis][1][1] = (before + h) / sum;
  }
  for (int c = 0; c < 4; c++) {
    int a = c == 1 || c == 2, b = c >= 2;
    for (int k = 0; k < 4; k++) {
      int i = k == 1 || k == 2, j = k >= 2;
      add_function(x, face, inner_place[c],
                   tsi_primary_point(m->surface, m->surface->link[link[k]].vertex),
                   p[0][a][i] * p[1][b][j]);
    }
  }
}

/* Points on a natural end, of the face's own curve there, times c; end 0 near the link's origin. */
static void add_curve_point(stars *x, int face, int place, int link, int end, double c) {
  const tsi_mesh *m = x->m;
  const tsolid_surface *s = m->surface;
  double h = s->interval[s->link[link].edge];
  double before = width_beyond(m, s->link[link].prev), after = width_beyond(m, s->link[link].next);
  double far = (end ? after : before) / (before + h + after);
  int near_vertex = end ? tsi_destination(s, link) : s->link[link].vertex;
  int far_vertex = end ? s->link[link].vertex : tsi_destination(s, link);
  double sum = before + h + after, near_part = (h + (end ? before : after)) / sum;
  add_function(x, face, place, tsi_primary_point(s, near_vertex), c * near_part);
  add_function(x, face, place, tsi_primary_point(s, far_vertex), c * far);
}

/* Both points on an edge, for the faces on both sides. */
static void make_edge_points(stars *x, int link) {
  const tsi_mesh *m = x->m;
  const tsolid_surface *s = m->surface;
  int other = s->link[link].opposite, f = s->link[link].face, g = s->link[other].face;
  int natural = m->natural[s->link[link].edge];
  for (int end = 0; end < 2; end++) {
    int faces[2] = {f, g}, links[2] = {link, other};
    for (int to = 0; to < 2; to++) {
      if (faces[to] < 0)
        continue;
      int place = edge_place[m->side[links[to]]][to ? 1 - end : end];
      double weight[2] = {1.0, 0.0}, sum = 0.0;
      clear_point(x, faces[to], place);
      for (int k = 0; k < 2; k++) {
        weight[k] = faces[k] < 0 ? 0.0
                    : natural    ? 1.0
                                 : 1.0 / width_across(m, faces[k], m->side[links[k]]);
        sum += weight[k];
      }
      for (int k = 0; k < 2; k++) {
        int here = k ? 1 - end : end;
        if (faces[k] < 0)
          continue;
        if (natural)
          add_curve_point(x, faces[to], place, links[k], here, weight[k] / sum);
        else
          add_point(x, faces[to], place, faces[k], inner_place[(m->side[links[k]] + here) % 4],
                    weight[k] / sum);
      }
    }
  }
}

/* The point at the origin of `link`, for the faces round it. */
static void make_vertex_point(stars *x, int link) {
  const tsi_mesh *m = x->m;
  const tsolid_surface *s = m->surface;
  int n_natural = 0, n_faces = 0, i = link;
  double sum = 0.0;
  do {
    const tsi_link *l = &s->link[i];
    n_natural += m->natural[l->edge];
    n_faces += l->face >= 0;
    i = s->link[l->prev].opposite;
  } while (i != link);
  int mode = n_natural > 2 || (n_natural == 2 && n_faces == 1) ? 2 : n_natural == 2;
  do {
    const tsi_link *l = &s->link[i];
    const double *size = m->size + 2 * (size_t)(l->face < 0 ? 0 : l->face);
    if (mode == 0)
      sum += l->face < 0 ? 0.0 : 1.0 / (size[0] * size[1]);
    else if (m->natural[l->edge])
      sum += 1.0 / s->interval[l->edge];
    i = s->link[l->prev].opposite;
  } while (i != link);
  do { /* to every face */
    int to = s->link[i].face, k = i;
    int place = to < 0 ? 0 : corner_place[m->side[i]];
    if (to >= 0) {
      clear_point(x, to, place);
      if (mode == 2)
        add_function(x, to, place, tsi_primary_point(s, s->link[link].vertex), 1.0);
    }
    if (to >= 0 && mode < 2)
      do { /* from every face, or along every natural edge */
        const tsi_link *l = &s->link[k];
        if (mode == 0 && l->face >= 0) {
          const double *size = m->size + 2 * (size_t)l->face;
          add_point(x, to, place, l->face, inner_place[m->side[k]],
                    1.0 / (size[0] * size[1]) / sum);
        }
        if (mode == 1 && m->natural[l->edge]) {
          int b = l->opposite, on_left = l->face >= 0;
          int f = on_left ? l->face : s->link[b].face;
          int from = on_left ? edge_place[m->side[k]][0] : edge_place[m->side[b]][1];
          add_point(x, to, place, f, from, 1.0 / s->interval[l->edge] / sum);
        }
        k = s->link[l->prev].opposite;
      } while (k != i);
    i = s->link[s->link[i].prev].opposite;
  } while (i != link);
}

tsolid_status tsi_star_nets(const tsi_mesh *m, tsi_arena *arena, const char *near, tsi_net *net) {
  const tsolid_surface *s = m->surface;
  stars x = {.m = m, .arena = arena, .near = near, .net = net};
  for (int f = 0; f < s->n_faces; f++)
    if (near[f] == 2)
      make_face_points(&x, f);
  for (int f = 0; f < s->n_faces; f++) {
    int link[4];
    if (near[f] != 2)
      continue;
    side_links(s, f, link);
    for (int k = 0; k < 4; k++)
      make_edge_points(&x, link[k]);
  }
  for (int f = 0; f < s->n_faces; f++) {
    int link[4];
    if (near[f] != 2)
      continue;
    side_links(s, f, link);
    for (int k = 0; k < 4; k++)
      make_vertex_point(&x, link[k]);
  }
  return x.failed ? tsi_no_memory(m->context, stage) : TSOLID_OK;
}
