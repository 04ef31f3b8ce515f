/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Conforming hexahedra from a solid: a grid on the seven blocks of the cross.
 *
 * The lattice of the core has N_x x N_y x N_z points; each layer over it repeats the points of the
 * core's surface. An arm's points are those of its side of that surface, so two arms that meet in a
 * diagonal share theirs, and nothing hangs. Quadratic elements use the lattice of half the step,
 * without the points where more than one of the three indices is odd. */
#include <stdlib.h>

#include "boundary.h"
#include "evaluate.h"
#include "hex.h"

static const char stage[] = "hexahedra";

enum { N_CORNERS = 8, CHUNK = 4096, DEFAULT_MAX_ELEMENTS = 2000000 };

/* Corners and mids of a hexahedron in halves of its edges, in the order of Abaqus. */
static const int node_place[20][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2},
                                      {2, 0, 2}, {2, 2, 2}, {0, 2, 2}, {1, 0, 0}, {2, 1, 0},
                                      {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2}, {1, 2, 2},
                                      {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}};

/* S1..S6 as 0..5 by axis and end. */
static const int face_number[3][2] = {{5, 3}, {2, 4}, {0, 1}};

typedef struct lattice {
  const tsolid_solid *solid;
  const tsi_hex_lines *lines;
  size_t n[3], n_core, n_surface, n_layers; /* points; layers of points beyond the core surface */
  int *node;                                /* of a lattice point, -1: unused */
} lattice;

/* ---- regions -----------------------------------------------------------------------------------
 */

static const tsolid_region side_region[6] = {
    {"x_low", 0, {0, 1, 0, 1}},  {"x_high", 1, {0, 1, 0, 1}}, {"y_low", 2, {0, 1, 0, 1}},
    {"y_high", 3, {0, 1, 0, 1}}, {"z_low", 4, {0, 1, 0, 1}},  {"z_high", 5, {0, 1, 0, 1}}};

static tsolid_status check_regions(tsolid_context *context, int n, const tsolid_region *region) {
  for (int k = 0; k < n; k++) {
    const double *box = region[k].box;
    int good = region[k].side >= 0 && region[k].side < 6;
    for (int d = 0; good && d < 2; d++)
      good = box[2 * d] >= 0.0 && box[2 * d] < box[2 * d + 1] && box[2 * d + 1] <= 1.0;
    if (!good || !region[k].name || !*region[k].name)
      return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                      "Region %d has no name or is no box on a side", k);
  }
  return TSOLID_OK;
}

typedef struct named_region {
  const char *name;
  int region;
} named_region;

static int compare_names(const void *a, const void *b) {
  const named_region *p = a, *q = b;
  int order = strcmp(p->name, q->name);
  return order ? order : (p->region > q->region) - (p->region < q->region);
}

/* Boxes of one name are one region: set_of[k] of box k, numbered by first appearance. */
static tsolid_status copy_names(tsolid_context *context, tsi_arena *arena, int n,
                                const tsolid_region *region, int *set_of, tsolid_hex *hex) {
  size_t length = 0;
  named_region *list = tsi_arena_new(arena, (size_t)n, sizeof *list);
  for (int k = 0; list && k < n; k++) {
    length += strlen(region[k].name) + 1;
    list[k] = (named_region){region[k].name, k};
  }
  hex->names = tsi_new(&context->allocator, length, 1);
  hex->region_name = tsi_new(&context->allocator, (size_t)n, sizeof *hex->region_name);
  if (!list || !hex->names || !hex->region_name)
    return tsi_no_memory(context, stage);
  qsort(list, (size_t)n, sizeof *list, compare_names);
  for (int k = 0; k < n; k++) { /* the first box of the name, then its number */
    int same = k && strcmp(list[k].name, list[k - 1].name) == 0;
    set_of[list[k].region] = same ? set_of[list[k - 1].region] : list[k].region;
  }
  length = 0;
  for (int k = 0; k < n; k++) {
    if (set_of[k] != k) {
      set_of[k] = set_of[set_of[k]];
      continue;
    }
    size_t size = strlen(region[k].name) + 1;
    memcpy(hex->names + length, region[k].name, size);
    hex->region_name[hex->n_regions] = hex->names + length;
    set_of[k] = hex->n_regions++;
    length += size;
  }
  return TSOLID_OK;
}

static int region_of(int n, const tsolid_region *region, int side, double s, double t) {
  for (int k = 0; k < n; k++) {
    const double *box = region[k].box;
    if (region[k].side == side && box[0] < s && s < box[1] && box[2] < t && t < box[3])
      return k;
  }
  return -1;
}

/* Calls visit for every boundary quadrilateral: lattice cell (i, j) of a side. Elements are
 * numbered core first, then the arms by side, each layer by layer outwards. */
typedef struct quad {
  int side, i, j, element;
} quad;

int tsi_hex_first_outer(const tsi_hex_lines *lines, int side) {
  const int *n = lines->n;
  int first = n[0] * n[1] * n[2];
  for (int k = 0; k < side; k++)
    first += n[3] * n[tsi_side_s(k)] * n[tsi_side_t(k)];
  return first + (n[3] - 1) * n[tsi_side_s(side)] * n[tsi_side_t(side)];
}

static tsolid_status assign_faces(tsolid_context *context, tsi_arena *arena,
                                  const tsi_hex_lines *lines, int n_boxes,
                                  const tsolid_region *region, const int *set_of, tsolid_hex *hex) {
  int n_regions = hex->n_regions, n_quads = 0, order = lines->order;
  for (int side = 0; side < 6; side++)
    n_quads += lines->n[tsi_side_s(side)] * lines->n[tsi_side_t(side)];
  hex->region_start =
      tsi_new(&context->allocator, (size_t)n_regions + 1, sizeof *hex->region_start);
  hex->region_face = tsi_new(&context->allocator, (size_t)n_quads, 2 * sizeof *hex->region_face);
  int *of = tsi_arena_new(arena, (size_t)n_quads, sizeof *of);
  int *face = tsi_arena_new(arena, (size_t)n_quads, 2 * sizeof *face);
  int *next = tsi_arena_new(arena, (size_t)n_regions + 1, sizeof *next);
  if (!hex->region_start || !hex->region_face || !of || !face || !next)
    return tsi_no_memory(context, stage);
  int q = 0;
  for (int side = 0; side < 6; side++) {
    const double *s = lines->x[tsi_side_s(side)], *t = lines->x[tsi_side_t(side)];
    int element = tsi_hex_first_outer(lines, side);
    for (int j = 0; j < lines->n[tsi_side_t(side)]; j++)
      for (int i = 0; i < lines->n[tsi_side_s(side)]; i++, q++) {
        of[q] = region_of(n_boxes, region, side, 0.5 * (s[order * i] + s[order * (i + 1)]),
                          0.5 * (t[order * j] + t[order * (j + 1)]));
        of[q] = of[q] >= 0 ? set_of[of[q]] : -1;
        face[2 * q] = element++;
        face[2 * q + 1] = face_number[tsi_side_axis(side)][side & 1];
        if (of[q] >= 0)
          hex->region_start[of[q] + 1]++;
      }
  }
  for (int k = 0; k < n_regions; k++) {
    hex->region_start[k + 1] += hex->region_start[k];
    next[k] = hex->region_start[k];
  }
  for (int k = 0; k < n_quads; k++)
    if (of[k] >= 0)
      memcpy(hex->region_face + 2 * next[of[k]]++, face + 2 * k, 2 * sizeof *face);
  return TSOLID_OK;
}

/* ---- elements ----------------------------------------------------------------------------------
 */

/* The lattice point at (i, j, k) of the core or, with layer > 0, of a layer over its surface. */
static size_t lattice_point(const lattice *l, const size_t x[3], size_t layer) {
  if (layer == 0)
    return x[0] + l->n[0] * (x[1] + l->n[1] * x[2]);
  return l->n_core + (layer - 1) * l->n_surface + tsi_lattice_id(l->n, x);
}

/* Corner (0,0,0) of the cell at `low`; in an arm (side >= 0) cell `layer` counts outwards. */
static void put_element(const lattice *l, const int low[3], int side, int layer, int *element) {
  int order = l->lines->order, step = 2 / order, axis = side >= 0 ? tsi_side_axis(side) : -1;
  for (int m = 0; m < tsi_hex_width(order); m++) {
    size_t x[3], out = 0;
    for (int d = 0; d < 3; d++)
      x[d] = (size_t)(order * low[d] + node_place[m][d] / step);
    if (side >= 0) {
      int up = node_place[m][axis] / step;
      out = (size_t)(order * layer + (side & 1 ? up : order - up));
      x[axis] = side & 1 ? l->n[axis] - 1 : 0;
    }
    element[m] = l->node[lattice_point(l, x, out)];
  }
}

static void put_elements(const lattice *l, tsolid_hex *hex) {
  const int *n = l->lines->n;
  int *element = hex->element, width = tsi_hex_width(hex->order);
  for (int k = 0; k < n[2]; k++)
    for (int j = 0; j < n[1]; j++)
      for (int i = 0; i < n[0]; i++, element += width)
        put_element(l, (const int[3]){i, j, k}, -1, 0, element);
  for (int side = 0; side < 6; side++)
    for (int layer = 0; layer < n[3]; layer++)
      for (int j = 0; j < n[tsi_side_t(side)]; j++)
        for (int i = 0; i < n[tsi_side_s(side)]; i++, element += width) {
          int low[3] = {0};
          low[tsi_side_s(side)] = i;
          low[tsi_side_t(side)] = j;
          put_element(l, low, side, layer, element);
        }
}

/* ---- nodes -------------------------------------------------------------------------------------
 */

/* Where a node lies in the cross. A mid node is put on its line where it is equally far from both
 * ends: at the middle of the parameters it can lie beyond the quarter points, where a quadratic
 * element folds. */
typedef struct place {
  int block, axis; /* the axis of the line a mid node lies on, -1: a corner node */
  double u[3];
  double range[2]; /* of u[axis] at the ends */
  int end[2];      /* lattice points, then nodes */
} place;

enum { HALVING_STEPS = 12 };

/* The coordinate of a layer along the axis of its side. */
static double layer_coordinate(const lattice *l, int side, size_t layer) {
  double outer[3], height = l->solid->space->tmesh->arm_height[side] * l->lines->x[3][layer];
  if (layer < l->n_layers)
    return side & 1 ? 1.0 + height : -height;
  tsolid_solid_boundary_point(l->solid, side, 0.0, 0.0, outer);
  return outer[tsi_side_axis(side)];
}

/* The side of the core's surface that the lattice point lies on, the least if several; or -1. */
static int surface_side(const lattice *l, const size_t x[3]) {
  for (int d = 0; d < 3; d++)
    if (x[d] == 0 || x[d] == l->n[d] - 1)
      return 2 * d + (x[d] != 0);
  return -1;
}

static void place_node(const lattice *l, const size_t x[3], size_t layer, int side, place *p) {
  const tsi_hex_lines *lines = l->lines;
  int normal = side >= 0 ? tsi_side_axis(side) : -1, quadratic = lines->order == 2;
  p->block = layer > 0 ? 1 + side : 0;
  p->axis = -1;
  for (int d = 0; d < 3; d++)
    p->u[d] = lines->x[d][x[d]];
  if (layer > 0)
    p->u[normal] = layer_coordinate(l, side, layer);
  for (int d = 0; quadratic && d < 3; d++)
    for (int k = 0; (x[d] & 1) && k < 2; k++) {
      size_t end[3] = {x[0], x[1], x[2]};
      end[d] = k ? x[d] + 1 : x[d] - 1;
      p->axis = d;
      p->range[k] = lines->x[d][end[d]];
      p->end[k] = (int)lattice_point(l, end, layer);
    }
  for (int k = 0; quadratic && (layer & 1) && k < 2; k++) {
    size_t end = k ? layer + 1 : layer - 1;
    p->axis = normal;
    p->range[k] = layer_coordinate(l, side, end);
    p->end[k] = (int)lattice_point(l, x, end);
  }
}

/* Numbers the points of one layer that elements use. Arms that share a point give it the same place
 * in the part: the one with the least side counts. */
static void number_layer(lattice *l, size_t layer, place *where, int *n_nodes) {
  int quadratic = l->lines->order == 2;
  size_t x[3];
  for (x[2] = 0; x[2] < l->n[2]; x[2]++)
    for (x[1] = 0; x[1] < l->n[1]; x[1]++)
      for (x[0] = 0; x[0] < l->n[0]; x[0]++) {
        int side = surface_side(l, x);
        size_t n_odd = (x[0] & 1) + (x[1] & 1) + (x[2] & 1) + (layer & 1);
        if ((quadratic && n_odd > 1) || (layer > 0 && side < 0))
          continue;
        place_node(l, x, layer, side, &where[*n_nodes]);
        l->node[lattice_point(l, x, layer)] = (*n_nodes)++;
      }
}

static double square_distance(const double a[3], const double b[3]) {
  double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

/* Halves the line of a mid node between its ends; corner nodes are there already. */
static int halve_line(const tsolid_solid *solid, const place *p, double *nodes, int node) {
  const double *a = nodes + 3 * (size_t)p->end[0], *b = nodes + 3 * (size_t)p->end[1];
  double *x = nodes + 3 * (size_t)node, low = 0.0, high = 1.0;
  for (int k = 0; k < HALVING_STEPS; k++) {
    double u[3] = {p->u[0], p->u[1], p->u[2]}, middle = 0.5 * (low + high);
    u[p->axis] = p->range[0] + middle * (p->range[1] - p->range[0]);
    if (!tsi_solid_point(solid, p->block, u, 0, x))
      return 0;
    if (square_distance(x, a) < square_distance(x, b))
      low = middle;
    else
      high = middle;
  }
  return 1;
}

static tsolid_status evaluate_nodes(tsolid_context *context, const lattice *l, const place *where,
                                    int mids, tsolid_hex *hex) {
  for (int first = 0; first < hex->n_nodes; first += CHUNK) {
    int end = hex->n_nodes - first < CHUNK ? hex->n_nodes : first + CHUNK, failed = 0;
    tsolid_status status = tsi_progress(context, stage, (double)first / hex->n_nodes);
    if (status)
      return status;
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 64) num_threads(context->n_threads) reduction(+ : failed)
#endif
    for (int k = first; k < end; k++) {
      const place *p = &where[k];
      if (mids && p->axis >= 0)
        failed += !halve_line(l->solid, p, hex->nodes, k);
      else if (!mids && p->axis < 0)
        failed += !tsi_solid_point(l->solid, p->block, p->u, 0, hex->nodes + 3 * (size_t)k);
    }
    if (failed)
      return tsi_fail(context, TSOLID_ERROR_INTERNAL, stage, "%d nodes lie in no element", failed);
  }
  return TSOLID_OK;
}

/* ---- the driver --------------------------------------------------------------------------------
 */

tsolid_status tsi_hex_check_options(tsolid_context *context, tsolid_hex_options *options) {
  int good = options->order >= 0 && options->order <= 2 && options->size >= 0.0 &&
             isfinite(options->size) && options->max_elements >= 0 && options->n_regions >= 0 &&
             options->grading >= 0.0 && (options->n_regions == 0 || options->regions);
  for (int d = 0; d < 4; d++)
    good = good && options->divisions[d] >= 0;
  if (!good)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "Order is 1 or 2; size, grading and divisions are not negative");
  if (options->grading > 0.0 && !(options->grading >= 1e-3 && options->grading <= 1e3))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "The grading %g is not in 0.001 to 1000",
                    options->grading);
  if (!options->n_regions) {
    options->n_regions = 6;
    options->regions = side_region;
  }
  return check_regions(context, options->n_regions, options->regions);
}

tsolid_status tsi_hex_check_proof(tsolid_context *context, const tsolid_solid *solid,
                                  const tsolid_hex_options *options, int *proved) {
  tsolid_certificate certificate;
  tsolid_status status = tsolid_certify(context, solid, NULL, &certificate, NULL);
  if (status)
    return status;
  *proved = certificate.verdict == TSOLID_POSITIVE;
  if (*proved || options->allow_unproved)
    return TSOLID_OK;
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.has_point = 1;
  memcpy(finding.point, certificate.point, sizeof finding.point);
  return tsi_report(context, &finding,
                    "The solid is not proved valid near (%g, %g, %g): no hexahedra are made of it "
                    "unless that is asked for",
                    certificate.point[0], certificate.point[1], certificate.point[2]);
}

static tsolid_status count_mesh(tsolid_context *context, const tsi_hex_lines *lines,
                                int max_elements, lattice *l, tsolid_hex *hex) {
  const int *n = lines->n;
  double x = n[0], y = n[1], z = n[2], most = max_elements ? max_elements : DEFAULT_MAX_ELEMENTS;
  double elements = x * y * z + 2.0 * n[3] * (x * y + y * z + z * x);
  if (!(elements <= most))
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                    "%d x %d x %d divisions with %d layers are %.0f elements, more than %.0f: take "
                    "a larger size",
                    n[0], n[1], n[2], n[3], elements, most);
  for (int d = 0; d < 3; d++)
    l->n[d] = (size_t)(lines->order * n[d] + 1);
  l->n_core = l->n[0] * l->n[1] * l->n[2];
  l->n_surface = (size_t)tsi_lattice_count(l->n);
  l->n_layers = (size_t)(lines->order * n[3]);
  if ((double)l->n_core + (double)l->n_surface * (double)l->n_layers > TSI_MAX_COUNT)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "The mesh has too many nodes");
  hex->order = lines->order;
  memcpy(hex->divisions, n, sizeof hex->divisions);
  hex->n_elements = (int)elements;
  return TSOLID_OK;
}

static tsolid_status fill_mesh(tsolid_context *context, tsi_arena *arena, lattice *l,
                               tsolid_hex *hex) {
  size_t n_points = l->n_core + l->n_surface * l->n_layers;
  size_t width = (size_t)tsi_hex_width(hex->order);
  l->node = tsi_arena_new(arena, n_points, sizeof *l->node);
  place *where = tsi_arena_new(arena, n_points, sizeof *where);
  if (!l->node || !where)
    return tsi_no_memory(context, stage);
  memset(l->node, -1, n_points * sizeof *l->node);
  for (size_t layer = 0; layer <= l->n_layers; layer++)
    number_layer(l, layer, where, &hex->n_nodes);
  hex->nodes = tsi_new(&context->allocator, (size_t)hex->n_nodes, 3 * sizeof *hex->nodes);
  hex->element =
      tsi_new(&context->allocator, (size_t)hex->n_elements, width * sizeof *hex->element);
  if (!hex->nodes || !hex->element)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < hex->n_nodes; k++)
    for (int i = 0; where[k].axis >= 0 && i < 2; i++)
      where[k].end[i] = l->node[where[k].end[i]];
  put_elements(l, hex);
  tsolid_status status = evaluate_nodes(context, l, where, 0, hex);
  if (!status && hex->order == 2)
    status = evaluate_nodes(context, l, where, 1, hex);
  return status;
}

tsolid_status tsi_hex_check_quality(tsolid_context *context, tsolid_hex *hex) {
  tsi_hex_measure(hex);
  if (hex->worst > 0.0)
    return TSOLID_OK;
  const int *node = hex->element + (size_t)hex->worst_element * (size_t)tsi_hex_width(hex->order);
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.has_point = 1;
  finding.measured = hex->worst;
  finding.allowed = 0.0;
  memcpy(finding.point, hex->nodes + 3 * (size_t)node[0], sizeof finding.point);
  return tsi_report(context, &finding,
                    "A hexahedron near (%g, %g, %g) folds (scaled Jacobian %.3g): the solid bends "
                    "more than so few elements can follow, take a smaller size",
                    finding.point[0], finding.point[1], finding.point[2], hex->worst);
}

tsolid_hex *tsi_hex_new(tsolid_context *context) {
  tsolid_hex *hex = tsi_new(&context->allocator, 1, sizeof *hex);
  if (hex) {
    hex->allocator = context->allocator;
    hex->references = 1;
  }
  return hex;
}

tsolid_status tsi_hex_build(tsolid_context *context, tsi_arena *arena, const tsolid_solid *solid,
                            const tsolid_hex_options *options, const tsi_hex_lines *lines,
                            int **surface, tsolid_hex **result) {
  int n_regions = options->n_regions;
  const tsolid_region *region = options->regions;
  lattice l = {.solid = solid, .lines = lines};
  tsolid_hex *hex = tsi_hex_new(context);
  int *set_of = tsi_arena_new(arena, (size_t)n_regions, sizeof *set_of);
  tsolid_status status = hex && set_of ? TSOLID_OK : tsi_no_memory(context, stage);
  if (!status)
    status = count_mesh(context, lines, options->max_elements, &l, hex);
  if (!status)
    status = copy_names(context, arena, n_regions, region, set_of, hex);
  if (!status)
    status = fill_mesh(context, arena, &l, hex);
  if (!status)
    status = assign_faces(context, arena, lines, n_regions, region, set_of, hex);
  if (!status && surface)
    *surface = l.node + l.n_core + (l.n_layers - 1) * l.n_surface;
  if (status)
    tsolid_hex_free(hex);
  else
    *result = hex;
  return status;
}

tsolid_status tsolid_hex_create(tsolid_context *context, const tsolid_solid *solid,
                                const tsolid_hex_options *options, tsolid_hex **result) {
  if (!context || !result)
    return TSOLID_ERROR_ARGUMENT;
  *result = NULL;
  if (!solid)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "The solid is NULL");
  tsolid_hex_options given = {0};
  if (options)
    given = *options;
  tsi_arena arena = tsi_arena_create(context);
  tsi_hex_lines lines = {0};
  tsolid_hex *hex = NULL;
  int proved = 0;
  tsolid_status status = tsi_hex_check_options(context, &given);
  if (!status)
    status = tsi_hex_check_proof(context, solid, &given, &proved);
  for (int d = 0; d < 4 && !status; d++)
    status = tsi_hex_axis_lines(context, &arena, solid, &given, d, &lines);
  if (!status)
    status = tsi_hex_build(context, &arena, solid, &given, &lines, NULL, &hex);
  if (status)
    goto done;
  hex->proved = proved;
  status = tsi_hex_check_quality(context, hex);
done:
  tsi_arena_free(&arena);
  if (status)
    tsolid_hex_free(hex);
  else
    *result = hex;
  return status;
}

void tsolid_hex_free(tsolid_hex *hex) {
  if (!hex || --hex->references > 0)
    return;
  tsi_allocator allocator = hex->allocator;
  tsi_delete(&allocator, hex->nodes);
  tsi_delete(&allocator, hex->element);
  tsi_delete(&allocator, hex->names);
  tsi_delete(&allocator, (void *)(uintptr_t)hex->region_name);
  tsi_delete(&allocator, hex->region_start);
  tsi_delete(&allocator, hex->region_face);
  tsi_delete(&allocator, hex->part_start);
  tsi_delete(&allocator, hex->part_names);
  tsi_delete(&allocator, (void *)(uintptr_t)hex->part_name);
  tsi_delete(&allocator, hex);
}

void tsolid_hex_get(const tsolid_hex *hex, tsolid_hex_view *view) {
  *view = (tsolid_hex_view){.order = hex->order,
                            .n_nodes = hex->n_nodes,
                            .nodes = hex->nodes,
                            .n_elements = hex->n_elements,
                            .nodes_per_element = tsi_hex_width(hex->order),
                            .element = hex->element,
                            .n_regions = hex->n_regions,
                            .region_name = hex->region_name,
                            .region_start = hex->region_start,
                            .region_face = hex->region_face,
                            .worst = hex->worst,
                            .worst_element = hex->worst_element,
                            .proved = hex->proved,
                            .n_parts = hex->n_parts,
                            .part_name = hex->part_name,
                            .part_start = hex->part_start,
                            .n_shared = hex->n_shared};
  memcpy(view->divisions, hex->divisions, sizeof view->divisions);
}
