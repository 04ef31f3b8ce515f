/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The cube in a closed surface: Zhang, Wang, Hughes (2012), section 2, on a T-mesh.
 *
 * Count quarter turns round a vertex: one per corner of a face, two where the vertex lies inside
 * a face's side (a T-junction). Four are regular. By Gauss and Bonnet the turns that are missing
 * sum to eight on a sphere; the surface has a cube's shape when they sit, one each, in eight
 * vertices of valence three, and the isolines that leave those join them as a cube's edges. */
#include <stdio.h>

#include "surface_cube.h"
#include "vector.h"

static const char stage[] = "boundary";

enum { MAX_NAMED = 12 };

/* ---- places -----------------------------------------------------------------------------------
 */

/* The point of face f at its corner number (counted along its links from face_link). */
static int corner_point(const struct tsolid_surface *s, int f, int corner, double point[3]) {
  size_t n = (size_t)s->degree + 1;
  size_t at = (corner == 1 || corner == 2 ? n - 1 : 0) + (corner >= 2 ? n * (n - 1) : 0);
  int best = -1;
  for (int e = s->element_start[f]; e < s->element_start[f + 1]; e++) {
    const double *box = s->box + 4 * (size_t)e, *old = s->box + 4 * (size_t)(best < 0 ? e : best);
    if ((corner == 1 || corner == 2 ? box[1] >= old[1] : box[0] <= old[0]) &&
        (corner >= 2 ? box[3] >= old[3] : box[2] <= old[2]))
      best = e;
  }
  if (best < 0)
    return 0;
  double h[4] = {0.0, 0.0, 0.0, 0.0};
  for (int k = s->function_start[best]; k < s->function_start[best + 1]; k++)
    for (size_t c = 0; c < 4; c++)
      h[c] += s->coefficient[(size_t)k * n * n + at] * s->points[4 * (size_t)s->function[k] + c];
  tsi_project_point(h, point);
  return isfinite(point[0]) && isfinite(point[1]) && isfinite(point[2]);
}

int tsi_surface_vertex_point(const struct tsolid_surface *surface, int vertex, double point[3]) {
  const tsi_link *link = surface->link;
  int start = surface->vertex_link[vertex], k = start, n = 0;
  do {
    if (link[k].face >= 0 && !link[k].straight) {
      int corner = 0, first = surface->face_link[link[k].face];
      for (int i = first; i != k; i = link[i].next)
        corner += !link[link[i].next].straight;
      if (corner < 4 && corner_point(surface, link[k].face, corner, point))
        return 1;
    }
    k = link[link[k].opposite].next;
  } while (k != start && ++n < surface->n_links);
  return 0;
}

tsolid_finding tsi_cutting_finding(const tsi_cutting *cut, int vertex) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  if (vertex < 0 || vertex >= cut->surface->n_vertices)
    return finding;
  finding.entity = TSOLID_ENTITY_SURFACE_VERTEX;
  finding.index[0] = tsi_vertex_number(cut->surface, vertex);
  finding.has_point = tsi_surface_vertex_point(cut->surface, vertex, finding.point);
  return finding;
}

const char *tsi_ray_name(const tsi_cutting *cut, int ray, char text[TSI_RAY_NAME_SIZE]) {
  const struct tsolid_surface *s = cut->surface;
  const tsi_ray *r = &cut->ray[ray];
  int to = s->link[s->link[r->start].opposite].vertex;
  snprintf(text, TSI_RAY_NAME_SIZE, "leaves vertex %d towards vertex %d",
           tsi_vertex_number(s, cut->star[r->star]), tsi_vertex_number(s, to));
  return text;
}

/* ---- the requirement --------------------------------------------------------------------------
 */

static int find_root(int *parent, int i) {
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}

static int count_components(const struct tsolid_surface *s, int *parent) {
  int n = s->n_faces;
  for (int f = 0; f < s->n_faces; f++)
    parent[f] = f;
  for (int k = 0; k < s->n_links; k++) {
    int a = s->link[k].face, b = s->link[s->link[k].opposite].face;
    if (a < 0 || b < 0)
      continue;
    a = find_root(parent, a);
    b = find_root(parent, b);
    parent[a < b ? b : a] = a < b ? a : b;
    n -= a != b;
  }
  return n;
}

/* Boundary loops; mark: one zero per link. */
static int count_loops(const struct tsolid_surface *s, int *mark, int *vertex) {
  int n = 0;
  for (int start = 0; start < s->n_links; start++) {
    if (s->link[start].face >= 0 || mark[start])
      continue;
    if (n++ == 0)
      *vertex = s->link[start].vertex;
    for (int k = start; !mark[k]; k = s->link[k].next)
      mark[k] = 1;
  }
  return n;
}

/* Two fans of faces that touch in a vertex only. */
static tsolid_status check_fans(tsi_cutting *cut, int *mark) {
  const struct tsolid_surface *s = cut->surface;
  memset(mark, 0, (size_t)s->n_links * sizeof *mark);
  for (int v = 0; v < s->n_vertices; v++)
    for (int k = s->vertex_link[v]; !mark[k]; k = s->link[s->link[k].opposite].next)
      mark[k] = 1;
  for (int k = 0; k < s->n_links; k++)
    if (!mark[k]) {
      tsolid_finding finding = tsi_cutting_finding(cut, s->link[k].vertex);
      return tsi_report(cut->context, &finding,
                        "At vertex %d the surface touches itself: several fans of faces meet there",
                        tsi_vertex_number(s, s->link[k].vertex));
    }
  return TSOLID_OK;
}

static tsolid_status check_topology(tsi_cutting *cut, tsolid_requirement *requirement) {
  const struct tsolid_surface *s = cut->surface;
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  int *work = tsi_arena_new(cut->arena, (size_t)s->n_links + 1, sizeof *work), vertex = -1;
  if (!work)
    return tsi_no_memory(cut->context, stage);
  int n_components = count_components(s, work);
  requirement->connected = n_components == 1;
  memset(work, 0, (size_t)s->n_links * sizeof *work);
  int n_loops = count_loops(s, work, &vertex);
  requirement->closed = n_loops == 0;
  if (n_loops > 0) {
    finding = tsi_cutting_finding(cut, vertex);
    return tsi_report(cut->context, &finding, "The surface is open: %d boundary loop%s", n_loops,
                      n_loops == 1 ? "" : "s");
  }
  if (n_components != 1)
    return tsi_report(cut->context, &finding, "The surface consists of %d separate parts, not one",
                      n_components);
  tsolid_status status = check_fans(cut, work);
  if (status)
    return status;
  int euler = s->n_vertices - s->n_edges + s->n_faces;
  requirement->genus = (2 - euler) / 2;
  if (euler != 2)
    return tsi_report(cut->context, &finding, "The surface has genus %d, not zero: %d hole%s",
                      requirement->genus, requirement->genus, requirement->genus == 1 ? "" : "s");
  return TSOLID_OK;
}

/* "3, 8, 9 and 5 more" */
static void append_vertex(char *text, size_t size, int n, int record) {
  size_t used = strlen(text);
  if (n < MAX_NAMED)
    snprintf(text + used, size - used, "%s%d", n ? ", " : "", record);
}

static tsolid_status find_stars(tsi_cutting *cut, tsolid_requirement *requirement) {
  const struct tsolid_surface *s = cut->surface;
  char stars[16 * MAX_NAMED] = "";
  int n_stars = 0, n_wrong = 0;
  int *count = tsi_arena_new(cut->arena, (size_t)s->n_vertices, 2 * sizeof *count);
  if (!count)
    return tsi_no_memory(cut->context, stage);
  int *straight = count + s->n_vertices;
  for (int k = 0; k < s->n_links; k++) {
    count[s->link[k].vertex]++;
    straight[s->link[k].vertex] += s->link[k].straight;
  }
  for (int v = 0; v < s->n_vertices; v++) {
    if (count[v] + straight[v] == 4)
      continue;
    requirement->n_extraordinary++;
    if (count[v] == 3 && straight[v] == 0) {
      if (n_stars < TSI_N_STARS)
        cut->star[n_stars] = v;
      append_vertex(stars, sizeof stars, n_stars++, tsi_vertex_number(s, v));
      continue;
    }
    if (n_wrong++ >= MAX_NAMED)
      continue;
    tsolid_finding finding = tsi_cutting_finding(cut, v);
    finding.measured = count[v];
    tsi_report(cut->context, &finding, "Vertex %d has valence %d%s", tsi_vertex_number(s, v),
               count[v], straight[v] ? " though it is a T-junction" : "");
  }
  if (n_wrong == 0 && n_stars == TSI_N_STARS)
    return TSOLID_OK;
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.measured = n_stars;
  finding.allowed = TSI_N_STARS;
  if (n_wrong == 0)
    return tsi_report(cut->context, &finding,
                      "There are %d extraordinary vertices of valence three, not eight", n_stars);
  return tsi_report(cut->context, &finding,
                    "Exactly eight extraordinary vertices are needed, all of valence three; there "
                    "are %d of valence three (%s%s) and %d of other valences",
                    n_stars, n_stars ? stars : "none", n_stars > MAX_NAMED ? ", ..." : "", n_wrong);
}

/* ---- the cube's graph -------------------------------------------------------------------------
 */

static void start_rays(tsi_cutting *cut) {
  const struct tsolid_surface *s = cut->surface;
  for (int i = 0; i < TSI_N_STARS; i++) {
    int k = s->vertex_link[cut->star[i]];
    for (int j = 0; j < 3; j++) {
      cut->ray[3 * i + j] = (tsi_ray){.star = i, .start = k, .partner = -1, .axis = -1};
      k = s->link[s->link[k].opposite].next;
    }
  }
}

static tsolid_status refuse_graph(tsi_cutting *cut, const char *why) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  return tsi_report(cut->context, &finding,
                    "The isolines do not join the eight vertices of valence three as the edges of "
                    "a cube join its corners: %s",
                    why);
}

static tsolid_status check_cycles(tsi_cutting *cut) {
  for (int r = 0; r < TSI_N_RAYS; r++) {
    int n = 0, k = r;
    do {
      k = cut->ray[k].next;
      n++;
    } while (k != r && n <= TSI_N_RAYS);
    if (n == 4)
      continue;
    char name[TSI_RAY_NAME_SIZE], text[160];
    snprintf(text, sizeof text, "on the left of the isoline that %s lies a side with %d corners",
             tsi_ray_name(cut, r, name), n);
    return refuse_graph(cut, text);
  }
  return TSOLID_OK;
}

/* Opposite isolines of a side are parallel. The three rays of star 0 name the axes. */
static int spread_axes(tsi_cutting *cut) {
  for (int j = 0; j < 3; j++)
    cut->ray[j].axis = j;
  for (int changed = 1; changed;) {
    changed = 0;
    for (int r = 0; r < TSI_N_RAYS; r++) {
      if (cut->ray[r].axis < 0)
        continue;
      int parallel[2] = {cut->ray[r].partner, cut->ray[cut->ray[r].next].next};
      for (int i = 0; i < 2; i++) {
        int *axis = &cut->ray[parallel[i]].axis;
        if (*axis >= 0 && *axis != cut->ray[r].axis)
          return 0;
        changed |= *axis < 0;
        *axis = cut->ray[r].axis;
      }
    }
  }
  for (int r = 0; r < TSI_N_RAYS; r++)
    if (cut->ray[r].axis < 0 || cut->ray[r].axis == cut->ray[cut->ray[r].next].axis)
      return 0;
  return 1;
}

/* Star 0 is corner 0; an isoline changes the bit of its axis. */
static int spread_corners(tsi_cutting *cut) {
  int taken = 1, known[TSI_N_STARS] = {1};
  cut->corner[0] = 0;
  for (int pass = 0; pass < TSI_N_STARS; pass++)
    for (int r = 0; r < TSI_N_RAYS; r++) {
      const tsi_ray *ray = &cut->ray[r];
      int to = cut->ray[ray->partner].star;
      if (!known[ray->star])
        continue;
      int corner = cut->corner[ray->star] ^ 1 << ray->axis;
      if (known[to] && cut->corner[to] != corner)
        return 0;
      if (!known[to] && taken >> corner & 1)
        return 0;
      known[to] = 1;
      taken |= 1 << corner;
      cut->corner[to] = corner;
    }
  return taken == 0xff;
}

static tsolid_status find_cube(tsi_cutting *cut) {
  tsolid_status status = check_cycles(cut);
  if (status)
    return status;
  if (!spread_axes(cut) || !spread_corners(cut))
    return refuse_graph(cut, "sides that should be opposite touch");
  for (int i = 0; i < 6; i++)
    cut->side_ray[i] = -1;
  for (int r = 0; r < TSI_N_RAYS; r++) {
    int a = cut->ray[r].axis, b = cut->ray[cut->ray[r].next].axis, normal = 3 - a - b;
    int corner = cut->corner[cut->ray[r].star];
    if ((corner & (1 << a | 1 << b)) != 0)
      continue;
    int side = 2 * normal + (corner >> normal & 1);
    if (cut->side_ray[side] >= 0)
      return refuse_graph(cut, "two sides have the same corners");
    cut->side_ray[side] = r;
  }
  for (int i = 0; i < 6; i++)
    if (cut->side_ray[i] < 0)
      return refuse_graph(cut, "a side is missing");
  return TSOLID_OK;
}

/* Sums of knot intervals along parallel isolines are equal since they are in every face. */
static tsolid_status check_lengths(tsi_cutting *cut) {
  for (int axis = 0; axis < 3; axis++) {
    int shortest = -1, longest = -1;
    for (int r = 0; r < TSI_N_RAYS; r++) {
      if (cut->ray[r].axis != axis)
        continue;
      if (shortest < 0 || cut->ray[r].length.high < cut->ray[shortest].length.high)
        shortest = r;
      if (longest < 0 || cut->ray[r].length.high > cut->ray[longest].length.high)
        longest = r;
    }
    double low = cut->ray[shortest].length.high, high = cut->ray[longest].length.high;
    if (high - low <= tsi_same_position * high)
      continue;
    char name[2][TSI_RAY_NAME_SIZE];
    tsolid_finding finding = tsi_cutting_finding(cut, cut->star[cut->ray[shortest].star]);
    finding.measured = high - low;
    finding.allowed = tsi_same_position * high;
    return tsi_report(cut->context, &finding,
                      "Knot intervals do not close: they sum to %.15g along the isoline that %s "
                      "and to %.15g along the parallel one that %s",
                      low, tsi_ray_name(cut, shortest, name[0]), high,
                      tsi_ray_name(cut, longest, name[1]));
  }
  return TSOLID_OK;
}

/* ---- the driver -------------------------------------------------------------------------------
 */

static tsolid_status copy_mesh(tsi_cutting *cut) {
  const struct tsolid_surface *s = cut->surface;
  cut->n_links = cut->link_room = s->n_links;
  cut->n_faces = cut->face_room = s->n_faces;
  cut->n_edges = cut->edge_room = s->n_edges;
  cut->n_vertices = cut->vertex_room = s->n_vertices;
  size_t n_edges = (size_t)s->n_edges, n_vertices = (size_t)s->n_vertices;
  cut->link = tsi_arena_new(cut->arena, (size_t)s->n_links, sizeof *cut->link);
  cut->face = tsi_arena_new(cut->arena, (size_t)s->n_faces, sizeof *cut->face);
  cut->length = tsi_arena_new(cut->arena, n_edges, sizeof *cut->length);
  cut->edge_isoline = tsi_arena_new(cut->arena, n_edges, sizeof *cut->edge_isoline);
  cut->vertex_isoline = tsi_arena_new(cut->arena, n_vertices, sizeof *cut->vertex_isoline);
  cut->vertex_star = tsi_arena_new(cut->arena, n_vertices, sizeof *cut->vertex_star);
  if (!cut->link || !cut->face || !cut->length || !cut->edge_isoline || !cut->vertex_isoline ||
      !cut->vertex_star)
    return tsi_no_memory(cut->context, stage);
  memcpy(cut->link, s->link, (size_t)s->n_links * sizeof *cut->link);
  for (int e = 0; e < s->n_edges; e++)
    cut->length[e] = tsi_sum_of(s->interval[e]);
  for (int f = 0; f < s->n_faces; f++) {
    tsi_sum extent[2] = {tsi_sum_of(0.0), tsi_sum_of(0.0)};
    int k = s->face_link[f];
    cut->face[f].first = k;
    cut->face[f].whole = f;
    for (int side = 0; side < 2; side++)
      do {
        extent[side] = tsi_sum_add(extent[side], cut->length[s->link[k].edge]);
        k = s->link[k].next;
      } while (s->link[k].straight);
    cut->face[f].box[1] = extent[0];
    cut->face[f].box[3] = extent[1];
  }
  for (int i = 0; i < TSI_N_STARS; i++)
    cut->vertex_star[cut->star[i]] = i + 1;
  return TSOLID_OK;
}

tsolid_status tsi_surface_to_sides(tsolid_context *context, tsi_arena *arena,
                                   const struct tsolid_surface *surface,
                                   tsolid_requirement *requirement,
                                   tsolid_bezier_boundary *boundary) {
  tsi_cutting *cut = tsi_arena_new(arena, 1, sizeof *cut);
  int n_findings = context->n_findings;
  *requirement = (tsolid_requirement){.genus = -1,
                                      .n_patches = surface->n_faces,
                                      .n_vertices = surface->n_vertices,
                                      .n_edges = surface->n_edges};
  *boundary = (tsolid_bezier_boundary){.n_functions = 0};
  if (!cut)
    return tsi_no_memory(context, stage);
  cut->context = context;
  cut->arena = arena;
  cut->surface = surface;
  tsolid_status status = check_topology(cut, requirement);
  if (!status)
    status = find_stars(cut, requirement);
  if (!status)
    status = copy_mesh(cut);
  if (!status) {
    start_rays(cut);
    status = tsi_cutting_trace(cut);
  }
  if (!status)
    status = find_cube(cut);
  if (!status)
    status = check_lengths(cut);
  if (!status)
    status = tsi_cutting_sides(cut, boundary);
  if (status == TSOLID_ERROR_REFUSED)
    requirement->n_violations += context->n_findings - n_findings;
  return status;
}
