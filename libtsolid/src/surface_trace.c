/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Isolines of a surface: straight on from a star.
 *
 * At a vertex an isoline that comes along link l turns by the angles of the faces on its left,
 * a quarter turn for a corner and a half for a vertex in the middle of a side:
 *
 *            n = next(l)
 *            ^  .               a corner: next(opposite(n)) is straight on, if it is a corner
 *       left |  . the next      of its own face; else the isoline ends on the side of this face
 *     ---l-->+------>           (the stem of a T-junction) and cuts it
 *
 * The metric of knot intervals is flat, so a cut runs straight to the opposite side of the face,
 * at the same distance from the corner; there it meets a vertex or splits an edge. Every step can
 * be traced back, so two isolines never join; they meet in a star or cross. */
#include "surface_cube.h"

static const char stage[] = "boundary";

/* ---- room -------------------------------------------------------------------------------------
 */

/* Makes room for `n` more items of an array of `used`; 0: no memory. */
static int reserve(tsi_arena *arena, void **array, int used, int more, int *room, size_t size) {
  if (used + more <= *room)
    return 1;
  int larger = *room + *room / 2 + more + 16;
  void *moved = tsi_arena_new(arena, (size_t)larger, size);
  if (!moved)
    return 0;
  if (used > 0)
    memcpy(moved, *array, (size_t)used * size);
  *array = moved;
  *room = larger;
  return 1;
}

/* What one cut adds at most: a vertex, two edges, four links, a face. */
static int reserve_cut(tsi_cutting *cut) {
  void *link = cut->link, *face = cut->face, *length = cut->length, *edge = cut->edge_isoline;
  void *vertex = cut->vertex_isoline, *star = cut->vertex_star;
  int edges = cut->edge_room, vertices = cut->vertex_room;
  int made =
      reserve(cut->arena, &link, cut->n_links, 4, &cut->link_room, sizeof *cut->link) &&
      reserve(cut->arena, &face, cut->n_faces, 1, &cut->face_room, sizeof *cut->face) &&
      reserve(cut->arena, &length, cut->n_edges, 2, &edges, sizeof *cut->length) &&
      reserve(cut->arena, &edge, cut->n_edges, 2, &cut->edge_room, sizeof *cut->edge_isoline) &&
      reserve(cut->arena, &star, cut->n_vertices, 1, &vertices, sizeof *cut->vertex_star) &&
      reserve(cut->arena, &vertex, cut->n_vertices, 1, &cut->vertex_room,
              sizeof *cut->vertex_isoline);
  cut->link = link;
  cut->face = face;
  cut->length = length;
  cut->edge_isoline = edge;
  cut->vertex_isoline = vertex;
  cut->vertex_star = star;
  return made;
}

/* ---- splitting --------------------------------------------------------------------------------
 */

/* Splits the edge of link k at `end` before its destination. Returns the link from the new vertex
 * on. */
static int split_edge(tsi_cutting *cut, int k, tsi_sum end) {
  tsi_link *link = cut->link;
  int o = link[k].opposite, w = cut->n_vertices++, e = cut->n_edges++;
  int k2 = cut->n_links, o2 = cut->n_links + 1;
  cut->n_links += 2;
  link[k2] = (tsi_link){k, link[k].next, o, w, link[k].face, e, 1};
  link[o2] = (tsi_link){o, link[o].next, k, w, link[o].face, link[k].edge, 1};
  link[link[k].next].prev = k2;
  link[link[o].next].prev = o2;
  link[k].next = k2;
  link[o].next = o2;
  link[k].opposite = o2;
  link[o].opposite = k2;
  link[o].edge = e;
  cut->length[e] = end;
  cut->length[link[k].edge] = tsi_sum_subtract(cut->length[link[k].edge], end);
  cut->edge_isoline[e] = cut->vertex_isoline[w] = cut->vertex_star[w] = 0;
  return k2;
}

/* Which side of its face (0: along u at v0, then counter-clockwise) link m lies on, and how far its
 * origin is from where that side begins. */
static int find_side(const tsi_cutting *cut, int m, tsi_sum *distance) {
  const tsi_link *link = cut->link;
  int number = 0;
  *distance = tsi_sum_of(0.0);
  for (int k = cut->face[link[m].face].first; k != m; k = link[k].next) {
    *distance = tsi_sum_add(*distance, cut->length[link[k].edge]);
    if (!link[link[k].next].straight) {
      number++;
      *distance = tsi_sum_of(0.0);
    }
  }
  return number;
}

/* Cuts the face of m and q from the origin of m to that of q on the opposite side; returns the link
 * along the cut. `number`, `distance`: find_side(m). */
static int split_face(tsi_cutting *cut, int m, int q, int number, tsi_sum distance,
                      tsi_sum length) {
  tsi_link *link = cut->link;
  int f = link[m].face, g = cut->n_faces++, e = cut->n_edges++;
  int c = cut->n_links, d = cut->n_links + 1;
  cut->n_links += 2;
  int before_m = link[m].prev, before_q = link[q].prev;
  link[c] = (tsi_link){before_m, q, d, link[m].vertex, f, e, 0};
  link[d] = (tsi_link){before_q, m, c, link[q].vertex, f, e, 0};
  link[before_m].next = c;
  link[q].prev = c;
  link[before_q].next = d;
  link[m].prev = d;
  link[m].straight = link[q].straight = 0;
  cut->length[e] = length;
  cut->edge_isoline[e] = 0;
  /* the part of larger u or v is the new face; c has it on its left on sides 2 and 3 */
  tsi_cut_face *low = &cut->face[f], *high = &cut->face[g];
  int axis = number & 1, left_is_high = number >= 2;
  tsi_sum at = left_is_high ? tsi_sum_subtract(low->box[2 * axis + 1], distance)
                            : tsi_sum_add(low->box[2 * axis], distance);
  *high = *low;
  low->box[2 * axis + 1] = high->box[2 * axis] = at;
  high->first = number == 0 ? m : number == 1 ? d : number == 2 ? q : c;
  int k = left_is_high ? c : d;
  do {
    link[k].face = g;
    k = link[k].next;
  } while (k != (left_is_high ? c : d));
  return c;
}

/* ---- messages ---------------------------------------------------------------------------------
 */

static tsolid_status refuse_ray(tsi_cutting *cut, int ray, const char *what) {
  char name[TSI_RAY_NAME_SIZE];
  tsolid_finding finding = tsi_cutting_finding(cut, cut->star[cut->ray[ray].star]);
  return tsi_report(cut->context, &finding, "The isoline that %s %s", tsi_ray_name(cut, ray, name),
                    what);
}

static tsolid_status refuse_crossing(tsi_cutting *cut, int ray, int other, int vertex) {
  char name[TSI_RAY_NAME_SIZE], other_name[TSI_RAY_NAME_SIZE];
  tsolid_finding finding = tsi_cutting_finding(cut, cut->star[cut->ray[ray].star]);
  tsi_ray_name(cut, ray, name);
  tsi_ray_name(cut, other, other_name);
  if (vertex >= 0 && vertex < cut->surface->n_vertices) {
    finding = tsi_cutting_finding(cut, vertex);
    int record = tsi_vertex_number(cut->surface, vertex);
    if (ray == other)
      return tsi_report(cut->context, &finding, "The isoline that %s crosses itself at vertex %d",
                        name, record);
    return tsi_report(cut->context, &finding,
                      "The isoline that %s crosses the one that %s at vertex %d", name, other_name,
                      record);
  }
  if (ray == other)
    return tsi_report(cut->context, &finding, "The isoline that %s crosses itself", name);
  return tsi_report(cut->context, &finding, "The isoline that %s crosses the one that %s", name,
                    other_name);
}

/* ---- steps ------------------------------------------------------------------------------------
 */

/* Runs through the face of m, from the origin of m, which lies inside a side, to the opposite side.
 * *out: the link along the cut. */
static tsolid_status cross_face(tsi_cutting *cut, int ray, int m, int *out) {
  if (!reserve_cut(cut))
    return tsi_no_memory(cut->context, stage);
  tsi_link *link = cut->link;
  tsi_sum distance, width, at = tsi_sum_of(0.0), across = tsi_sum_of(0.0);
  int number = find_side(cut, m, &distance), k = m;
  width = distance;
  do { /* to the end of this side */
    width = tsi_sum_add(width, cut->length[link[k].edge]);
    k = link[k].next;
  } while (link[k].straight);
  do { /* along the side to the right, which is as long as the cut */
    across = tsi_sum_add(across, cut->length[link[k].edge]);
    k = link[k].next;
  } while (link[k].straight);
  while (link[link[k].next].straight)
    k = link[k].next; /* the opposite side, from its end back */
  double tolerance = tsi_same_position * width.high;
  if (!(distance.high > tolerance) || !(width.high - distance.high > tolerance))
    return refuse_ray(cut, ray, "meets a T-junction on a side without length, or too near its end");
  for (;; k = link[k].prev) {
    tsi_sum end = tsi_sum_add(at, cut->length[link[k].edge]);
    double beyond = tsi_sum_subtract(end, distance).high;
    if (fabs(beyond) <= tolerance && link[k].straight)
      break;
    if (beyond > tolerance) {
      int other = cut->edge_isoline[link[k].edge];
      if (other)
        return refuse_crossing(cut, ray, other - 1, -1);
      k = split_edge(cut, k, tsi_sum_subtract(distance, at));
      break;
    }
    if (!link[k].straight) /* the sums of opposite sides differ */
      return refuse_ray(cut, ray, "runs through a face whose knot intervals do not agree");
    at = end;
  }
  *out = split_face(cut, m, k, number, distance, across);
  return TSOLID_OK;
}

/* The link straight on from the destination of l, which is no star. */
static tsolid_status go_on(tsi_cutting *cut, int ray, int l, int *out) {
  const tsi_link *link = cut->link;
  int n = link[l].next;
  *out = n;
  if (link[n].straight)
    return TSOLID_OK;
  int m = link[link[n].opposite].next;
  *out = m;
  return link[m].straight ? cross_face(cut, ray, m, out) : TSOLID_OK;
}

static int find_ray(const tsi_cutting *cut, int start) {
  for (int r = 0; r < TSI_N_RAYS; r++)
    if (cut->ray[r].start == start)
      return r;
  return -1;
}

static tsolid_status trace_ray(tsi_cutting *cut, int r) {
  tsi_ray *ray = &cut->ray[r];
  int l = ray->start;
  ray->length = tsi_sum_of(0.0);
  for (;;) {
    int e = cut->link[l].edge, v;
    if (cut->edge_isoline[e])
      return refuse_crossing(cut, r, cut->edge_isoline[e] - 1, cut->link[l].vertex);
    cut->edge_isoline[e] = r + 1;
    ray->length = tsi_sum_add(ray->length, cut->length[e]);
    v = cut->link[cut->link[l].opposite].vertex;
    if (cut->vertex_star[v])
      break;
    if (cut->vertex_isoline[v])
      return refuse_crossing(cut, r, cut->vertex_isoline[v] - 1, v);
    cut->vertex_isoline[v] = r + 1;
    if (cut->n_edges > 16 * (cut->surface->n_edges + 64))
      return refuse_ray(cut, r, "never ends: it winds through the faces without meeting a star");
    tsolid_status status = go_on(cut, r, l, &l);
    if (status)
      return status;
  }
  int other = find_ray(cut, cut->link[l].opposite);
  if (other < 0)
    return tsi_fail(cut->context, TSOLID_ERROR_INTERNAL, stage, "An isoline misses its star");
  if (cut->ray[other].star == ray->star)
    return refuse_ray(cut, r, "comes back to this vertex");
  ray->partner = other;
  cut->ray[other].partner = r;
  cut->ray[other].length = ray->length;
  if (!(ray->length.high > 0.0))
    return refuse_ray(cut, r, "has length zero: all its knot intervals are zero");
  return TSOLID_OK;
}

tsolid_status tsi_cutting_trace(tsi_cutting *cut) {
  tsolid_status status = TSOLID_OK;
  for (int r = 0; r < TSI_N_RAYS; r++)
    cut->ray[r].partner = -1;
  for (int r = 0; !status && r < TSI_N_RAYS; r++)
    if (cut->ray[r].partner < 0)
      status = trace_ray(cut, r);
  for (int r = 0; !status && r < TSI_N_RAYS; r++) {
    /* the link that brings this ray to its other star */
    int last = cut->link[cut->ray[cut->ray[r].partner].start].opposite;
    cut->ray[r].next = find_ray(cut, cut->link[last].next);
    if (cut->ray[r].next < 0)
      status = tsi_fail(cut->context, TSOLID_ERROR_INTERNAL, stage, "A star lost a ray");
  }
  return status;
}
