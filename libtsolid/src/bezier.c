/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Six Bezier sides in any numbering and orientation, brought to canonical position. */
#include "boundary.h"
#include "vector.h"

static const char stage[] = "boundary";

/* Element e of a side as a patch on [0,1]^2; `net` and `knots` have room for the largest. */
static void make_patch(const tsi_side *side, const double *points, int e, double *knots,
                       double *net, tsi_patch *patch) {
  size_t width = 1;
  for (int d = 0; d < 2; d++) {
    int n = side->degree[d] + 1;
    patch->degree[d] = side->degree[d];
    patch->n[d] = n;
    patch->knots[d] = knots + d * 2 * TSI_MAX_ORDER;
    for (int i = 0; i < 2 * n; i++)
      patch->knots[d][i] = i < n ? 0.0 : 1.0;
    width *= (size_t)n;
  }
  patch->control = net;
  memset(net, 0, 4 * width * sizeof *net);
  for (int k = side->function_start[e]; k < side->function_start[e + 1]; k++) {
    const double *c = side->coefficient + (size_t)k * width;
    const double *point = points + 4 * (size_t)side->function[k];
    for (size_t i = 0; i < 4 * width; i++)
      net[i] += c[i / 4] * point[i % 4];
  }
}

typedef struct side_points {
  const tsi_side *side;
  const double *points;
  double knots[4 * TSI_MAX_ORDER], net[4 * TSI_MAX_ORDER * TSI_MAX_ORDER];
} side_points;

static void evaluate_side(side_points *from, double s, double t, double x[3]) {
  const tsi_side *side = from->side;
  double h[4] = {0.0, 0.0, 0.0, 1.0};
  for (int e = 0; e < side->n_elements; e++) {
    const double *box = side->box + 4 * (size_t)e;
    if (!(box[0] <= s && s <= box[1] && box[2] <= t && t <= box[3]))
      continue;
    tsi_patch patch;
    make_patch(side, from->points, e, from->knots, from->net, &patch);
    tsi_patch_evaluate(&patch, (s - box[0]) / (box[1] - box[0]), (t - box[2]) / (box[3] - box[2]),
                       h, NULL);
    break;
  }
  tsi_project_point(h, x);
}

static void evaluate_border(side_points *from, int b, double x, double point[3]) {
  double uv[2];
  tsi_border_point(b, x, uv);
  evaluate_side(from, uv[0], uv[1], point);
}

static void measure_facet(side_points *from, const double origin[3], tsi_facet *facet) {
  enum { N_STEPS = 16 };
  for (int b = 0; b < 4; b++) {
    double previous[3], point[3];
    for (int i = 0; i <= N_STEPS; i++) {
      evaluate_border(from, b, (double)i / N_STEPS, point);
      if (i == 0)
        memcpy(facet->corner[b], point, sizeof point);
      else
        facet->length[b] += tsi_distance(point, previous);
      if (i % 4 == 0 && i > 0 && i < N_STEPS)
        memcpy(facet->sample[b][i / 4 - 1], point, sizeof point);
      memcpy(previous, point, sizeof point);
    }
  }
  evaluate_side(from, 0.5, 0.5, facet->centre);
  for (int e = 0; e < from->side->n_elements; e++) {
    tsi_patch patch;
    double area, flux;
    make_patch(from->side, from->points, e, from->knots, from->net, &patch);
    tsi_patch_measure(&patch, origin, &area, &flux);
    facet->area += area;
    facet->flux += flux;
  }
}

tsolid_status tsi_side_measure(tsolid_context *context, const double *points, const tsi_side *side,
                               const double origin[3], tsi_facet *facet) {
  tsi_arena arena = tsi_arena_create(context);
  side_points *from = tsi_arena_new(&arena, 1, sizeof *from);
  tsolid_status status = from ? TSOLID_OK : tsi_no_memory(context, stage);
  if (from) {
    from->side = side;
    from->points = points;
    measure_facet(from, origin, facet);
  }
  tsi_arena_free(&arena);
  return status;
}

static tsolid_status make_facets(tsolid_context *context, int n_functions, const double *points,
                                 const tsi_side side[6], double tolerance, tsi_facet facet[6]) {
  static const char *const name[6] = {"side 0", "side 1", "side 2", "side 3", "side 4", "side 5"};
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  double middle[3];
  for (size_t i = 0; i < (size_t)n_functions; i++)
    for (size_t c = 0; c < 3; c++) {
      low[c] = fmin(low[c], points[4 * i + c] / points[4 * i + 3]);
      high[c] = fmax(high[c], points[4 * i + c] / points[4 * i + 3]);
    }
  for (int c = 0; c < 3; c++)
    middle[c] = low[c] + 0.5 * (high[c] - low[c]);
  tsolid_status status = TSOLID_OK;
  for (int i = 0; !status && i < 6; i++) {
    status = tsi_side_measure(context, points, &side[i], middle, &facet[i]);
    facet[i].name = name[i];
    facet[i].patch = i;
    for (int b = 0; b < 4; b++)
      facet[i].tolerance[b] = tolerance;
  }
  return status;
}

/* Parameters are kept as multiples of 2^-53, on which 1 - x is exact. */
static void flip_interval(int flip, const double from[2], double to[2]) {
  double low = 1.0 - (1.0 - from[0]), high = 1.0 - (1.0 - from[1]);
  to[0] = flip ? 1.0 - high : low;
  to[1] = flip ? 1.0 - low : high;
}

tsolid_status tsi_side_move(tsolid_context *context, tsi_arena *arena, const tsi_side *from,
                            const tsi_place *place, tsi_side *to) {
  size_t n = (size_t)from->n_elements, n_entries = (size_t)from->function_start[n];
  size_t n0 = (size_t)from->degree[0] + 1, n1 = (size_t)from->degree[1] + 1, width = n0 * n1;
  *to = *from;
  to->grid[0] = to->grid[1] = 1;
  for (int d = 0; d < 2; d++)
    to->degree[place->swap ? 1 - d : d] = from->degree[d];
  to->box = tsi_arena_new(arena, n, 4 * sizeof *to->box);
  to->coefficient = tsi_arena_new(arena, n_entries * width, sizeof *to->coefficient);
  if (!to->box || !to->coefficient)
    return tsi_no_memory(context, stage);
  for (size_t e = 0; e < n; e++)
    for (int d = 0; d < 2; d++)
      flip_interval(place->flip[d], from->box + 4 * e + 2 * d,
                    to->box + 4 * e + 2 * (place->swap ? 1 - d : d));
  for (size_t k = 0; k < n_entries; k++)
    for (size_t j = 0; j < n1; j++)
      for (size_t i = 0; i < n0; i++) {
        size_t u = place->flip[0] ? n0 - 1 - i : i, v = place->flip[1] ? n1 - 1 - j : j;
        to->coefficient[k * width + (place->swap ? v + n1 * u : u + n0 * v)] =
            from->coefficient[k * width + i + n0 * j];
      }
  return TSOLID_OK;
}

tsolid_status tsi_draft_from_bezier(tsolid_context *context, tsi_arena *arena,
                                    const tsolid_bezier_boundary *input, double tolerance,
                                    tsolid_requirement *requirement, tsi_draft *draft) {
  tsi_side side[6];
  tsi_facet facet[6];
  tsi_cube cube;
  memset(facet, 0, sizeof facet);
  for (int i = 0; i < 6; i++) {
    const tsolid_bezier_side *from = &input->side[i];
    side[i] = (tsi_side){.degree = {from->degree[0], from->degree[1]},
                         .n_elements = from->n_elements,
                         .box = (double *)(uintptr_t)from->box,
                         .function_start = (int *)(uintptr_t)from->function_start,
                         .function = (int *)(uintptr_t)from->function,
                         .coefficient = (double *)(uintptr_t)from->coefficient};
  }
  tsolid_status status = tsi_sides_check(context, input->n_functions, input->points, side, 0);
  if (!status)
    status = make_facets(context, input->n_functions, input->points, side, tolerance, facet);
  if (!status)
    status = tsi_cube_find(context, arena, 6, facet, requirement, &cube);
  if (status)
    return status;
  size_t n = 4 * (size_t)input->n_functions;
  draft->n_functions = input->n_functions;
  draft->points = tsi_arena_new(arena, n, sizeof *draft->points);
  if (!draft->points)
    return tsi_no_memory(context, stage);
  for (size_t i = 0; i < n; i++)
    draft->points[i] = input->points[i] + 0.0;
  for (int i = 0; !status && i < 6; i++)
    status =
        tsi_side_move(context, arena, &side[cube.place[i]->facet], cube.place[i], &draft->side[i]);
  if (!status)
    status = tsi_sides_check(context, draft->n_functions, draft->points, draft->side, 1);
  return status;
}
