/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The handle of a spline surface on a T-mesh: memory, every invariant of its links, counts,
 * evaluation. */
#include "bernstein.h"
#include "surface.h"

static const char stage[] = "surface";

/* Opposite sides of a face: knot intervals are decimal numbers, their sums differ by round-off. */
static const double length_agreement = 1e-9;
static const double largest_interval = 1e60, smallest_interval = 1e-60;
static const double largest_coordinate = 1e120, largest_weight = 1e60;

tsolid_surface *tsi_surface_new(tsolid_context *context) {
  tsolid_surface *surface = tsi_new(&context->allocator, 1, sizeof *surface);
  if (!surface)
    return NULL;
  surface->allocator = context->allocator;
  surface->arena.allocator = &surface->allocator;
  surface->references = 1;
  return surface;
}

void tsi_surface_retain(const tsolid_surface *surface) {
  ((tsolid_surface *)(uintptr_t)surface)->references++;
}

void tsolid_surface_free(tsolid_surface *surface) {
  if (!surface || --surface->references > 0)
    return;
  tsi_allocator allocator = surface->allocator;
  tsi_arena_free(&surface->arena);
  tsi_delete(&allocator, surface);
}

/* ---- links -------------------------------------------------------------------------------------
 */

typedef struct checker {
  tsolid_context *context;
  const tsolid_surface *surface;
  const tsi_surface_lines *lines;
} checker;

typedef enum kind { FACE, EDGE, VERTEX, LINK } kind;

/* The number of a record in the file. */
static int record_of(const checker *c, kind what, int index) {
  const tsolid_surface *s = c->surface;
  const int *record = what == FACE     ? s->face_record
                      : what == VERTEX ? s->vertex_record
                      : what == EDGE   ? s->tsm.edge_record
                                       : s->tsm.link_record;
  return record ? record[index] : index;
}

static tsolid_finding place_of(const checker *c, kind what, int index) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
  const int *line = !c->lines        ? NULL
                    : what == FACE   ? c->lines->face
                    : what == EDGE   ? c->lines->edge
                    : what == VERTEX ? c->lines->vertex
                                     : c->lines->link;
  if (line) {
    finding.entity = TSOLID_ENTITY_LINE;
    finding.index[0] = line[index];
  }
  return finding;
}

static tsolid_status fail_at(const checker *c, kind what, int index, const char *reason) {
  static const char *const name[] = {"Face", "Edge", "Vertex", "Link"};
  tsolid_finding finding = place_of(c, what, index);
  if (finding.entity == TSOLID_ENTITY_LINE)
    return tsi_report(c->context, &finding, "%s %d (line %d) %s", name[what],
                      record_of(c, what, index), finding.index[0], reason);
  return tsi_report(c->context, &finding, "%s %d %s", name[what], record_of(c, what, index),
                    reason);
}

static int in_range(int i, int n) {
  return 0 <= i && i < n;
}

static tsolid_status check_ranges(const checker *c) {
  const tsolid_surface *s = c->surface;
  for (int i = 0; i < s->n_links; i++) {
    const tsi_link *l = &s->link[i];
    if (!in_range(l->prev, s->n_links) || !in_range(l->next, s->n_links) ||
        !in_range(l->opposite, s->n_links))
      return fail_at(c, LINK, i, "names a link that does not exist");
    if (!in_range(l->vertex, s->n_vertices))
      return fail_at(c, LINK, i, "starts at a vertex that does not exist");
    if (l->face != -1 && !in_range(l->face, s->n_faces))
      return fail_at(c, LINK, i, "is of a face that does not exist");
    if (!in_range(l->edge, s->n_edges))
      return fail_at(c, LINK, i, "is on an edge that does not exist");
  }
  for (int i = 0; i < s->n_faces; i++)
    if (!in_range(s->face_link[i], s->n_links))
      return fail_at(c, FACE, i, "names a link that does not exist");
  for (int i = 0; i < s->n_edges; i++)
    if (!in_range(s->edge_link[i], s->n_links))
      return fail_at(c, EDGE, i, "names a link that does not exist");
  for (int i = 0; i < s->n_vertices; i++)
    if (!in_range(s->vertex_link[i], s->n_links))
      return fail_at(c, VERTEX, i, "names a link that does not exist");
  return TSOLID_OK;
}

/* prev and next are inverse, opposite is its own inverse; so walks along them always come back. */
static tsolid_status check_links(const checker *c) {
  const tsi_link *link = c->surface->link;
  for (int i = 0; i < c->surface->n_links; i++) {
    const tsi_link *l = &link[i];
    if (link[l->next].prev != i || link[l->prev].next != i)
      return fail_at(c, LINK, i, "is not the previous one of its next");
    if (l->opposite == i || link[l->opposite].opposite != i)
      return fail_at(c, LINK, i, "is not the opposite of its opposite");
    if (link[l->opposite].edge != l->edge)
      return fail_at(c, LINK, i, "and its opposite are on different edges");
    if (link[l->opposite].vertex != link[l->next].vertex)
      return fail_at(c, LINK, i, "does not end where its opposite starts");
    if (link[l->next].face != l->face)
      return fail_at(c, LINK, i, "and the next one are of different faces");
    if (l->face == -1 && link[l->opposite].face == -1)
      return fail_at(c, LINK, i, "and its opposite have no face");
    if (l->face == -1 && l->straight)
      return fail_at(c, LINK, i, "of the open border is a T-junction of a face");
    if (l->straight != 0 && l->straight != 1)
      return fail_at(c, LINK, i, "is neither a corner nor a T-junction of its face");
  }
  return TSOLID_OK;
}

/* ---- faces, edges, vertices --------------------------------------------------------------------
 */

static tsolid_status check_face(const checker *c, int face) {
  const tsolid_surface *s = c->surface;
  int first = s->face_link[face], side = -1;
  double length[5] = {0.0, 0.0, 0.0, 0.0, 0.0};
  if (s->link[first].face != face)
    return fail_at(c, FACE, face, "names a link of another face");
  if (s->link[first].straight)
    return fail_at(c, FACE, face, "names a link that starts at a T-junction, not at a corner");
  int i = first;
  do {
    if (!s->link[i].straight && ++side == 4)
      break;
    length[side] += s->interval[s->link[i].edge];
    i = s->link[i].next;
  } while (i != first);
  if (side != 3)
    return fail_at(c, FACE, face, side > 3 ? "has more than four corners" : "has less than four");
  for (int d = 0; d < 2; d++) {
    double a = length[d], b = length[d + 2];
    if (fabs(a - b) <= length_agreement * fmax(a, b))
      continue;
    tsolid_finding finding = place_of(c, FACE, face);
    finding.measured = fabs(a - b);
    finding.allowed = length_agreement * fmax(a, b);
    return tsi_report(c->context, &finding,
                      "Face %d: the knot intervals along opposite sides sum up to %.17g and %.17g",
                      record_of(c, FACE, face), a, b);
  }
  return TSOLID_OK;
}

static tsolid_status check_edge(const checker *c, int edge) {
  const tsolid_surface *s = c->surface;
  double x = s->interval[edge];
  if (s->link[s->edge_link[edge]].edge != edge)
    return fail_at(c, EDGE, edge, "names a link of another edge");
  if (!isfinite(x) || x < 0.0)
    return fail_at(c, EDGE, edge, "has a knot interval that is negative or not finite");
  if (x > largest_interval || (x > 0.0 && x < smallest_interval))
    return fail_at(c, EDGE, edge, "has a knot interval that is too large or too small");
  return TSOLID_OK;
}

/* Each link stands in one face's loop, each edge has two links, each vertex one fan of links. */
static tsolid_status check_counts(const checker *c, tsi_arena *arena) {
  const tsolid_surface *s = c->surface;
  char *seen = tsi_arena_new(arena, (size_t)s->n_links, 1);
  int *n_of_edge = tsi_arena_new(arena, (size_t)s->n_edges, sizeof *n_of_edge);
  if (!seen || !n_of_edge)
    return tsi_no_memory(c->context, stage);
  for (int f = 0; f < s->n_faces; f++) {
    int i = s->face_link[f];
    do
      seen[i] = 1;
    while ((i = s->link[i].next) != s->face_link[f]);
  }
  for (int i = 0; i < s->n_links; i++) {
    if (s->link[i].face >= 0 && !seen[i])
      return fail_at(c, LINK, i, "is not in the loop of its face");
    if (++n_of_edge[s->link[i].edge] > 2)
      return fail_at(c, EDGE, s->link[i].edge, "has more than two links");
  }
  memset(seen, 0, (size_t)s->n_links);
  for (int v = 0; v < s->n_vertices; v++) {
    int i = s->vertex_link[v], n_borders = 0;
    do {
      if (s->link[i].vertex != v)
        return fail_at(c, VERTEX, v, "names a link that starts elsewhere");
      seen[i] = 1;
      n_borders += s->link[i].face == -1;
      i = s->link[s->link[i].prev].opposite;
    } while (i != s->vertex_link[v]);
    if (n_borders > 1)
      return fail_at(c, VERTEX, v, "is touched by two open borders");
  }
  for (int i = 0; i < s->n_links; i++)
    if (!seen[i])
      return fail_at(c, VERTEX, s->link[i].vertex, "joins two pieces that share nothing else");
  return TSOLID_OK;
}

tsolid_status tsi_surface_check(tsolid_context *context, const tsolid_surface *surface,
                                const tsi_surface_lines *lines) {
  checker c = {context, surface, lines};
  if (surface->n_faces < 1 || surface->n_links < 4)
    return tsi_fail(context, TSOLID_ERROR_INPUT, stage, "The surface has no faces");
  tsi_arena arena = tsi_arena_create(context);
  tsolid_status status = check_ranges(&c);
  if (!status)
    status = check_links(&c);
  for (int i = 0; !status && i < surface->n_edges; i++)
    status = check_edge(&c, i);
  for (int i = 0; !status && i < surface->n_faces; i++)
    status = check_face(&c, i);
  if (!status)
    status = check_counts(&c, &arena);
  tsi_arena_free(&arena);
  return status;
}

/* ---- counts ------------------------------------------------------------------------------------
 */

void tsi_face_lengths(const tsolid_surface *surface, int face, double length[2]) {
  int i = surface->face_link[face], side = -1;
  length[0] = length[1] = 0.0;
  for (;; i = surface->link[i].next) {
    side += !surface->link[i].straight;
    if (side > 1)
      return;
    length[side] += surface->interval[surface->link[i].edge];
  }
}

int tsi_vertex_quadrants(const tsolid_surface *surface, int vertex, int *border) {
  int first = surface->vertex_link[vertex], i = first, n = 0;
  *border = -1;
  do {
    const tsi_link *l = &surface->link[i];
    if (l->face == -1)
      *border = i;
    else
      n += l->straight ? 2 : 1;
    i = surface->link[l->prev].opposite;
  } while (i != first);
  return n;
}

int tsi_vertex_is_star(const tsolid_surface *surface, int vertex) {
  int border, n = tsi_vertex_quadrants(surface, vertex, &border);
  return border < 0 && n != 4;
}

static int count_edges(const tsolid_surface *s, int vertex) {
  int first = s->vertex_link[vertex], i = first, n = 0;
  do {
    n++;
    i = s->link[s->link[i].prev].opposite;
  } while (i != first);
  return n;
}

static tsolid_status count_stars(tsolid_context *context, tsolid_surface *s) {
  int n = 0;
  for (int v = 0; v < s->n_vertices; v++)
    n += tsi_vertex_is_star(s, v);
  s->extraordinary = tsi_arena_new(&s->arena, (size_t)n, sizeof *s->extraordinary);
  s->valence = tsi_arena_new(&s->arena, (size_t)n, sizeof *s->valence);
  if (!s->extraordinary || !s->valence)
    return tsi_no_memory(context, stage);
  for (int v = 0; v < s->n_vertices; v++) {
    if (!tsi_vertex_is_star(s, v))
      continue;
    s->extraordinary[s->n_extraordinary] = s->vertex_record ? s->vertex_record[v] : v;
    s->valence[s->n_extraordinary++] = count_edges(s, v);
  }
  return TSOLID_OK;
}

/* Border loops, and parts by a walk over neighbouring faces. */
static tsolid_status count_loops(tsolid_context *context, tsi_arena *arena, tsolid_surface *s) {
  char *seen = tsi_arena_new(arena, (size_t)s->n_links, 1);
  char *reached = tsi_arena_new(arena, (size_t)s->n_faces, 1);
  int *stack = tsi_arena_new(arena, (size_t)s->n_faces, sizeof *stack), n_stack;
  if (!seen || !reached || !stack)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < s->n_links; i++) {
    s->n_boundary_edges += s->link[i].face == -1;
    if (s->link[i].face != -1 || seen[i])
      continue;
    s->n_boundary_loops++;
    for (int k = i; !seen[k]; k = s->link[k].next)
      seen[k] = 1;
  }
  for (int f = 0; f < s->n_faces; f++) {
    if (reached[f])
      continue;
    s->n_parts++;
    reached[f] = 1;
    stack[0] = f;
    for (n_stack = 1; n_stack > 0;) {
      int first = s->face_link[stack[--n_stack]], i = first;
      do {
        int g = s->link[s->link[i].opposite].face;
        if (g >= 0 && !reached[g]) {
          reached[g] = 1;
          stack[n_stack++] = g;
        }
      } while ((i = s->link[i].next) != first);
    }
  }
  return TSOLID_OK;
}

static tsolid_status check_points(tsolid_context *context, const tsolid_surface *s) {
  for (int i = 0; i < s->n_points; i++) {
    const double *h = s->points + 4 * (size_t)i;
    int record = s->tsm.point_record ? s->tsm.point_record[i] : i;
    tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
    finding.entity = TSOLID_ENTITY_FUNCTION;
    finding.index[0] = i;
    for (int d = 0; d < 3; d++)
      if (!(fabs(h[d]) <= largest_coordinate))
        return tsi_report(context, &finding, "Control point %d is not finite or too large", record);
    if (!(h[3] >= 1.0 / largest_weight) || !(h[3] <= largest_weight))
      return tsi_report(context, &finding,
                        "The weight of control point %d is %g, it must be positive and finite",
                        record, h[3]);
  }
  return TSOLID_OK;
}

static tsolid_status measure_sum(tsolid_context *context, tsolid_surface *s) {
  size_t n = (size_t)(s->degree + 1) * (size_t)(s->degree + 1);
  for (int f = 0; f < s->n_faces; f++)
    for (int e = s->element_start[f]; e < s->element_start[f + 1]; e++)
      for (size_t i = 0; i < n; i++) {
        double sum = 0.0;
        for (int k = s->function_start[e]; k < s->function_start[e + 1]; k++)
          sum += s->coefficient[(size_t)k * n + i];
        if (!(sum > 1e-6))
          return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                          "All functions vanish in a part of face %d",
                          s->face_record ? s->face_record[f] : f);
        s->sum_defect = fmax(s->sum_defect, fabs(sum - 1.0));
      }
  return TSOLID_OK;
}

tsolid_status tsi_surface_finish(tsolid_context *context, tsolid_surface *surface) {
  tsi_arena arena = tsi_arena_create(context);
  tsolid_status status = check_points(context, surface);
  if (!status)
    status = measure_sum(context, surface);
  if (!status)
    status = count_stars(context, surface);
  if (!status)
    status = count_loops(context, &arena, surface);
  for (int i = 0; i < surface->n_links; i++)
    surface->n_t_junctions += surface->link[i].straight;
  if (!status) {
    surface->face_size =
        tsi_arena_new(&surface->arena, (size_t)surface->n_faces, 2 * sizeof *surface->face_size);
    if (!surface->face_size)
      status = tsi_no_memory(context, stage);
  }
  for (int f = 0; !status && f < surface->n_faces; f++)
    tsi_face_lengths(surface, f, surface->face_size + 2 * (size_t)f);
  tsi_arena_free(&arena);
  return status;
}

/* ---- public ------------------------------------------------------------------------------------
 */

void tsolid_surface_get(const tsolid_surface *s, tsolid_surface_view *view) {
  *view = (tsolid_surface_view){.n_faces = s->n_faces,
                                .n_edges = s->n_edges,
                                .n_vertices = s->n_vertices,
                                .n_points = s->n_points,
                                .n_t_junctions = s->n_t_junctions,
                                .n_boundary_loops = s->n_boundary_loops,
                                .n_boundary_edges = s->n_boundary_edges,
                                .n_parts = s->n_parts,
                                .n_extraordinary = s->n_extraordinary,
                                .extraordinary = s->extraordinary,
                                .valence = s->valence,
                                .sum_defect = s->sum_defect,
                                .points = s->points,
                                .face_size = s->face_size,
                                .element_start = s->element_start,
                                .degree = s->degree,
                                .n_elements = s->element_start[s->n_faces],
                                .box = s->box,
                                .function_start = s->function_start,
                                .function = s->function,
                                .coefficient = s->coefficient};
}

/* The element of a face at (u, v): half-open boxes, closed at the face's upper ends; or -1. */
static int find_element(const tsolid_surface *s, int face, double u, double v) {
  const double *size = s->face_size + 2 * (size_t)face;
  for (int e = s->element_start[face]; e < s->element_start[face + 1]; e++) {
    const double *box = s->box + 4 * (size_t)e;
    if (box[0] <= u && (u < box[1] || (u == box[1] && u >= size[0])) && box[2] <= v &&
        (v < box[3] || (v == box[3] && v >= size[1])))
      return e;
  }
  return -1;
}

tsolid_status tsolid_surface_evaluate(tsolid_context *context, const tsolid_surface *surface,
                                      int face, double u, double v, int order, double *out) {
  enum { N = TSI_MAX_ORDER };
  if (!context || !surface || !out || order < 0 || order > 1 || !in_range(face, surface->n_faces))
    return context ? tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "There is no face %d", face)
                   : TSOLID_ERROR_ARGUMENT;
  const double *size = surface->face_size + 2 * (size_t)face;
  double h[3][4] = {{0.0}}, b[2][2 * N];
  int e = find_element(surface, face, fmin(fmax(u, 0.0), size[0]), fmin(fmax(v, 0.0), size[1]));
  if (e < 0 || !isfinite(u) || !isfinite(v))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "(%g, %g) is not in face %d", u, v,
                    face);
  const double *box = surface->box + 4 * (size_t)e;
  double width[2] = {box[1] - box[0], box[3] - box[2]};
  int n = surface->degree + 1;
  tsi_bernstein_derivatives(surface->degree, (u - box[0]) / width[0], 1, b[0]);
  tsi_bernstein_derivatives(surface->degree, (v - box[2]) / width[1], 1, b[1]);
  for (int k = surface->function_start[e]; k < surface->function_start[e + 1]; k++) {
    const double *c = surface->coefficient + (size_t)k * (size_t)(n * n);
    const double *point = surface->points + 4 * (size_t)surface->function[k];
    double value[3] = {0.0, 0.0, 0.0};
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) {
        value[0] += c[i + n * j] * b[0][i] * b[1][j];
        value[1] += c[i + n * j] * b[0][n + i] * b[1][j] / width[0];
        value[2] += c[i + n * j] * b[0][i] * b[1][n + j] / width[1];
      }
    for (int d = 0; d < 3; d++)
      for (int x = 0; x < 4; x++)
        h[d][x] += value[d] * point[x];
  }
  for (int x = 0; x < 3; x++)
    out[x] = h[0][x] / h[0][3];
  for (int d = 1; order == 1 && d < 3; d++)
    for (int x = 0; x < 3; x++)
      out[3 * d + x] = (h[d][x] - h[d][3] * out[x]) / h[0][3];
  return TSOLID_OK;
}
