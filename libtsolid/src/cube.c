/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Isolines, sides, canonical position. Words (slot, dart): see complex.h. */
#include "complex.h"
#include "patch.h"

static const char stage[] = "boundary";

/* ---- sides -------------------------------------------------------------------------------- */

typedef struct cube_side {
  int dart[4];   /* first darts of its isolines, in the order around the side */
  int vertex[4]; /* their origins */
} cube_side;

static tsolid_status refuse_graph(tsi_complex *c, int dart) {
  const double *point = c->point[tsi_dart_origin(c, dart)];
  tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_PATCH, dart / 4, 0);
  tsi_set_point(&finding, point);
  return tsi_report(c->context, &finding,
                    "The isolines from the eight extraordinary vertices do not join them like the "
                    "edges of a cube; the first that fails starts at (%.6g, %.6g, %.6g)",
                    point[0], point[1], point[2]);
}

/* The last dart of the isoline that starts with `dart`: straight on to an extraordinary vertex. A
 * straight walk is a permutation of darts, so one that starts outside a cycle does end. */
static int trace_isoline(const tsi_complex *c, int dart) {
  for (int i = 0; i < 4 * c->n && c->valence[tsi_dart_end(c, dart)] == 4; i++)
    dart = tsi_dart_straight(c, dart);
  return dart;
}

static tsolid_status find_sides(tsi_complex *c, cube_side side[6]) {
  int n_sides = 0;
  unsigned char *seen = tsi_arena_new(c->arena, (size_t)(4 * c->n), 1);
  if (!seen)
    return tsi_no_memory(c->context, stage);
  for (int first = 0; first < 4 * c->n; first++) {
    if (seen[first] || c->valence[tsi_dart_origin(c, first)] == 4)
      continue;
    if (n_sides == 6)
      return refuse_graph(c, first);
    int dart = first;
    for (int i = 0; i < 4; i++) {
      if (seen[dart])
        return refuse_graph(c, dart);
      seen[dart] = 1;
      side[n_sides].dart[i] = dart;
      side[n_sides].vertex[i] = tsi_dart_origin(c, dart);
      dart = tsi_dart_next(c, trace_isoline(c, dart));
    }
    if (dart != first)
      return refuse_graph(c, first);
    n_sides++;
  }
  return n_sides == 6 ? TSOLID_OK : refuse_graph(c, 0);
}

/* Ranks of the vertices' coordinates: equal for neighbours closer than 1e-9 of the extent, so that
 * the canonical position does not hang on the last bits of a coordinate. */
static void rank_corners(const tsi_complex *c, const int vertex[8], int rank[8][3]) {
  double extent = 0.0;
  for (int i = 0; i < 8; i++)
    extent = fmax(extent, tsi_distance(c->point[vertex[i]], c->point[vertex[0]]));
  for (int k = 0; k < 3; k++) {
    int order[8];
    for (int i = 0; i < 8; i++) {
      int j = i;
      for (; j > 0 && c->point[vertex[order[j - 1]]][k] > c->point[vertex[i]][k]; j--)
        order[j] = order[j - 1];
      order[j] = i;
    }
    for (int i = 0, r = 0; i < 8; i++) {
      if (i && c->point[vertex[order[i]]][k] - c->point[vertex[order[i - 1]]][k] > 1e-9 * extent)
        r++;
      rank[order[i]][k] = r;
    }
  }
}

static int is_before(const tsi_complex *c, const int vertex[8], int rank[8][3], int a, int b) {
  for (int k = 0; k < 3; k++)
    if (rank[a][k] != rank[b][k])
      return rank[a][k] < rank[b][k];
  return tsi_compare_points(c->point[vertex[a]], c->point[vertex[b]]) < 0;
}

/* Sides around vertex v: the one that leaves it along the axis of `dart`. */
static int side_from(const cube_side side[6], int from, int to, int *at) {
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 4; j++)
      if (side[i].vertex[j] == from && side[i].vertex[(j + 1) % 4] == to) {
        *at = j;
        return i;
      }
  return -1;
}

/* Vertices of corners 0, 1, 2, 4: seen from outside, the axes leave corner 0 clockwise, so that the
 * side that leaves it along x comes back along z, z along y, y along x. */
static void choose_axes(const tsi_complex *c, const cube_side side[6], int corner[8]) {
  int vertex[8], rank[8][3], n = 0;
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 4; j++) {
      int known = 0;
      for (int m = 0; m < n; m++)
        known |= vertex[m] == side[i].vertex[j];
      if (!known)
        vertex[n++] = side[i].vertex[j];
    }
  rank_corners(c, vertex, rank);
  int least = 0, best = -1;
  for (int i = 1; i < 8; i++)
    if (is_before(c, vertex, rank, i, least))
      least = i;
  corner[0] = vertex[least];
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 4; j++)
      for (int m = 0; m < 8 && side[i].vertex[j] == corner[0]; m++)
        if (vertex[m] == side[i].vertex[(j + 1) % 4] &&
            (best < 0 || is_before(c, vertex, rank, m, best)))
          best = m;
  corner[1] = vertex[best];
  int j = 0, i = side_from(side, corner[0], corner[1], &j);
  corner[4] = side[i].vertex[(j + 3) % 4];
  corner[5] = side[i].vertex[(j + 2) % 4];
  i = side_from(side, corner[0], corner[4], &j);
  corner[2] = i < 0 ? -1 : side[i].vertex[(j + 3) % 4];
  corner[6] = i < 0 ? -1 : side[i].vertex[(j + 2) % 4];
  i = side_from(side, corner[0], corner[2], &j);
  corner[3] = i < 0 ? -1 : side[i].vertex[(j + 2) % 4];
  i = side_from(side, corner[3], corner[2], &j);
  corner[7] = i < 0 ? -1 : side[i].vertex[(j + 3) % 4];
}

static int label_of(const int corner[8], int vertex) {
  for (int i = 0; i < 8; i++)
    if (corner[i] == vertex)
      return i;
  return -1;
}

/* Which side of the cube is this, and where in it does corner (s,t) = (0,0) stand? -1: none. */
static int identify_side(const cube_side *side, const int corner[8], int *at) {
  int all = 7, any = 0, label[4];
  for (int j = 0; j < 4; j++) {
    label[j] = label_of(corner, side->vertex[j]);
    if (label[j] < 0)
      return -1;
    all &= label[j];
    any |= label[j];
  }
  for (int j = 0; j < 4; j++) {
    int step = label[j] ^ label[(j + 1) % 4];
    if (step != 1 && step != 2 && step != 4)
      return -1;
    if (label[j] == all)
      *at = j;
  }
  for (int axis = 0; axis < 3; axis++) {
    if (all == 1 << axis && any == 7)
      return 2 * axis + 1;
    if (all == 0 && any == 7 - (1 << axis))
      return 2 * axis;
  }
  return -1;
}

/* The facets of a side, row by row, from the dart that leaves (0,0) counter-clockwise. */
static tsolid_status lay_out_side(tsi_complex *c, int number, int dart, int first_axis,
                                  unsigned char *used, tsi_cube *cube) {
  int s = tsi_side_s(number), t = tsi_side_t(number), second_axis = s + t - first_axis;
  int n_row = 1, n_rows = 1;
  for (int d = dart; c->valence[tsi_dart_end(c, d)] == 4 && n_row <= c->n;
       d = tsi_dart_straight(c, d))
    n_row++;
  for (int d = tsi_dart_next(c, tsi_dart_next(c, dart));
       c->valence[tsi_dart_end(c, d)] == 4 && n_rows <= c->n;
       d = tsi_dart_next(c, tsi_dart_next(c, c->mate[d])))
    n_rows++;
  int n[3] = {0, 0, 0};
  n[first_axis] = n_row;
  n[second_axis] = n_rows;
  if ((double)n_row * n_rows > c->n)
    return refuse_graph(c, dart);
  for (int d = 0; d < 2; d++) {
    int axis = d ? t : s;
    if (cube->n_strips[axis] && cube->n_strips[axis] != n[axis])
      return refuse_graph(c, dart);
    cube->n_strips[axis] = n[axis];
  }
  tsi_place *place = tsi_arena_new(c->arena, (size_t)n_row * (size_t)n_rows, sizeof *place);
  if (!place)
    return tsi_no_memory(c->context, stage);
  for (int r = 0; r < n_rows; r++) {
    int d = dart;
    for (int k = 0; k < n_row; k++) {
      int i = first_axis == s ? k : r, j = first_axis == s ? r : k,
          natural = tsi_dart_origin_corner(c, d) % 4;
      if (used[d / 4]++)
        return refuse_graph(c, d);
      int along_u = d % 4 == 0 || d % 4 == 2;
      place[i + n[s] * j] = (tsi_place){.facet = d / 4,
                                        .swap = along_u == (first_axis == t),
                                        .flip = {natural == 1 || natural == 2, natural >= 2}};
      if (k + 1 < n_row)
        d = tsi_dart_straight(c, d);
    }
    if (r + 1 < n_rows)
      dart = c->mate[tsi_dart_next(c, tsi_dart_next(c, dart))];
  }
  cube->place[number] = place;
  return TSOLID_OK;
}

/* The least name of each corner, cut off before the character that has no room. */
static void name_corners(const tsi_complex *c, const int corner[8]) {
  enum { SIZE = sizeof c->requirement->corner_name[0] };
  for (int slot = 0; slot < 4 * c->n; slot++) {
    const char *name = c->facet[slot / 4].corner_name[slot % 4];
    int i = name && *name ? label_of(corner, c->vertex[slot]) : -1;
    if (i < 0)
      continue;
    char *to = c->requirement->corner_name[i], text[SIZE] = "", line[TSI_NAME_SIZE];
    size_t n = strlen(tsi_name_patch(name, 0, line));
    if (n >= SIZE)
      for (n = SIZE - 1; n > 0 && ((unsigned char)line[n] & 0xC0) == 0x80;)
        n--;
    memcpy(text, line, n);
    if (!*to || strcmp(text, to) < 0)
      memcpy(to, text, SIZE);
  }
}

static tsolid_status place_cube(tsi_complex *c, const cube_side side[6], tsi_cube *cube) {
  int corner[8], n_used = 0;
  unsigned char *used = tsi_arena_new(c->arena, (size_t)c->n, 1);
  if (!used)
    return tsi_no_memory(c->context, stage);
  choose_axes(c, side, corner);
  for (int i = 0; i < 6; i++) {
    int at = 0, number = identify_side(&side[i], corner, &at);
    if (number < 0 || cube->place[number])
      return refuse_graph(c, side[i].dart[0]);
    int step =
        label_of(corner, side[i].vertex[at]) ^ label_of(corner, side[i].vertex[(at + 1) % 4]);
    tsolid_status status = lay_out_side(c, number, side[i].dart[at],
                                        step == 1   ? 0
                                        : step == 2 ? 1
                                                    : 2,
                                        used, cube);
    if (status)
      return status;
  }
  for (int k = 0; k < c->n; k++)
    n_used += used[k];
  if (n_used != c->n)
    return refuse_graph(c, side[0].dart[0]);
  for (int i = 0; i < 8; i++)
    memcpy(c->requirement->corner[i], c->point[corner[i]], sizeof *c->requirement->corner);
  name_corners(c, corner);
  for (int i = 0; i < 6; i++) {
    c->requirement->side_grid[i][0] = cube->n_strips[tsi_side_s(i)];
    c->requirement->side_grid[i][1] = cube->n_strips[tsi_side_t(i)];
  }
  c->requirement->satisfied = 1;
  return TSOLID_OK;
}

tsolid_status tsi_cube_find(tsolid_context *context, tsi_arena *arena, int n,
                            const tsi_facet *facet, tsolid_requirement *requirement,
                            tsi_cube *cube) {
  static const tsi_cube no_cube;
  tsi_complex c = {
      .context = context, .arena = arena, .requirement = requirement, .n = n, .facet = facet};
  cube_side side[6];
  *cube = no_cube;
  memset(requirement, 0, sizeof *requirement);
  requirement->genus = -1;
  requirement->n_patches = n;
  tsolid_status status = tsi_complex_check_facets(&c);
  if (!status)
    status = tsi_complex_find_vertices(&c);
  if (!status)
    status = tsi_complex_find_duplicates(&c);
  if (!status)
    status = tsi_complex_match_borders(&c);
  if (!status)
    status = tsi_complex_check_closed(&c);
  if (!status)
    status = tsi_complex_orient(&c);
  if (!status)
    status = tsi_complex_check_fans(&c);
  if (!status)
    status = tsi_complex_check_genus(&c);
  if (!status)
    status = tsi_complex_check_valences(&c);
  if (!status)
    status = tsi_complex_orient_outward(&c);
  if (!status)
    status = find_sides(&c, side);
  if (!status)
    status = place_cube(&c, side, cube);
  return status;
}
