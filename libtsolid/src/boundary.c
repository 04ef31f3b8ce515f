/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The boundary handle, and the way from input to handle. The driver stands last. */
#include <stdlib.h>

#include "boundary.h"
#include "boundary_fold.h"
#include "complex.h"
#include "surface.h"

static const char stage[] = "boundary";

static const double default_tolerance = 1e-7;

/* ---- the handle -------------------------------------------------------------------------------
 */

tsolid_boundary *tsi_boundary_new(tsolid_context *context, int n_functions) {
  tsolid_boundary *boundary = tsi_new(&context->allocator, 1, sizeof *boundary);
  if (!boundary)
    return NULL;
  boundary->allocator = context->allocator;
  boundary->references = 1;
  boundary->n_functions = n_functions;
  boundary->points = tsi_new(&context->allocator, (size_t)n_functions, 4 * sizeof(double));
  if (!boundary->points) {
    tsi_delete(&context->allocator, boundary);
    return NULL;
  }
  return boundary;
}

void tsi_boundary_retain(const tsolid_boundary *boundary) {
  ((tsolid_boundary *)(uintptr_t)boundary)->references++;
}

void tsolid_boundary_free(tsolid_boundary *boundary) {
  if (!boundary || --boundary->references > 0)
    return;
  tsi_allocator allocator = boundary->allocator;
  for (int i = 0; i < 6; i++) {
    tsi_side *side = &boundary->side[i];
    tsi_delete(&allocator, side->box);
    tsi_delete(&allocator, side->function_start);
    tsi_delete(&allocator, side->function);
    tsi_delete(&allocator, side->coefficient);
  }
  tsi_delete(&allocator, boundary->placement_start);
  tsi_delete(&allocator, boundary->placement);
  tsi_delete(&allocator, boundary->points);
  tsi_delete(&allocator, boundary);
}

void tsolid_boundary_view(const tsolid_boundary *boundary, tsolid_bezier_boundary *view) {
  view->n_functions = boundary->n_functions;
  view->points = boundary->points;
  for (int i = 0; i < 6; i++) {
    const tsi_side *side = &boundary->side[i];
    view->side[i] = (tsolid_bezier_side){.degree = {side->degree[0], side->degree[1]},
                                         .n_elements = side->n_elements,
                                         .box = side->box,
                                         .function_start = side->function_start,
                                         .function = side->function,
                                         .coefficient = side->coefficient};
  }
}

void tsolid_boundary_requirement(const tsolid_boundary *boundary, tsolid_requirement *requirement) {
  *requirement = boundary->requirement;
}

void tsolid_boundary_preparation(const tsolid_boundary *boundary, tsolid_preparation *preparation) {
  *preparation = boundary->preparation;
}

int tsolid_boundary_n_placements(const tsolid_boundary *boundary, int k) {
  if (!boundary || k < 0 || k >= boundary->n_patches)
    return 0;
  return boundary->placement_start[k + 1] - boundary->placement_start[k];
}

tsolid_status tsolid_boundary_placement(const tsolid_boundary *boundary, int k, int i,
                                        tsolid_placement *placement) {
  if (!placement || i < 0 || i >= tsolid_boundary_n_placements(boundary, k))
    return TSOLID_ERROR_ARGUMENT;
  *placement = boundary->placement[boundary->placement_start[k] + i];
  return TSOLID_OK;
}

double tsolid_boundary_scale(const tsolid_boundary *boundary) {
  return boundary->scale;
}

/* ---- patches to facets ------------------------------------------------------------------------
 */

/* With the corners' own coordinates, bit for bit. */
static void measure_patch(const tsolid_patch *source, const tsi_patch *patch,
                          const double origin[3], tsi_facet *facet) {
  size_t n0 = (size_t)patch->n[0], n1 = (size_t)patch->n[1];
  size_t at[4] = {0, n0 - 1, n0 * n1 - 1, n0 * (n1 - 1)};
  tsi_facet_measure(patch, origin, facet);
  for (int b = 0; b < 4; b++)
    memcpy(facet->corner[b], source->points + 3 * at[b], sizeof facet->corner[b]);
}

static void name_facet(const tsolid_patch *source, int k, double tolerance, tsi_facet *facet) {
  facet->name = source->name;
  facet->patch = k;
  facet->fixed = source->fixed != 0;
  for (int b = 0; b < 4; b++) {
    facet->tolerance[b] = fmax(tolerance, source->border_tolerance[b]);
    facet->border_name[b] = source->border_name[b];
    facet->corner_name[b] = source->corner_name[b];
  }
}

static int has_form(const tsolid_patch *patch) {
  return patch->tspline || patch->bezier;
}

/* Middle of the bounding box of all control points: fluxes about it cancel least. */
static void find_middle(const tsolid_boundary_input *input, double middle[3]) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < (size_t)input->n_points; i++)
    for (size_t c = 0; c < 3; c++) {
      double x = input->points[4 * i + c] / input->points[4 * i + 3];
      low[c] = fmin(low[c], x);
      high[c] = fmax(high[c], x);
    }
  for (int k = 0; k < input->n_patches; k++) {
    const tsolid_patch *patch = &input->patches[k];
    size_t n = has_form(patch) ? 0 : (size_t)patch->n_control[0] * (size_t)patch->n_control[1];
    for (size_t i = 0; i < n; i++)
      for (size_t c = 0; c < 3; c++) {
        low[c] = fmin(low[c], patch->points[3 * i + c]);
        high[c] = fmax(high[c], patch->points[3 * i + c]);
      }
  }
  for (int c = 0; c < 3; c++)
    middle[c] = low[c] + 0.5 * (high[c] - low[c]);
}

/* ---- facets to the shell ----------------------------------------------------------------------
 */

static tsolid_status place_patch(tsolid_context *context, tsi_arena *arena,
                                 const tsi_patch_list *from, const tsi_place *place, int p,
                                 tsi_shell *shell) {
  int k = place->facet, placed = 1;
  shell->place[p] = place;
  shell->moebius[p][0] = shell->moebius[p][1] = 1.0;
  if (from->patch[k].n[0])
    placed = tsi_patch_orient(arena, &from->patch[k], place->flip, place->swap, &shell->patch[p]);
  else if (from->tspline[k].n)
    placed =
        tsi_tspline_orient(arena, &from->tspline[k], place->flip, place->swap, &shell->tspline[p]);
  else
    return tsi_side_move(context, arena, &from->elements[k], place, &shell->elements[p]);
  return placed ? TSOLID_OK : tsi_no_memory(context, stage);
}

static tsolid_status place_patches(tsolid_context *context, tsi_arena *arena, const tsi_cube *cube,
                                   const tsi_patch_list *from, const tsolid_boundary_input *input,
                                   tsi_shell *shell) {
  int n = from->n, first_point = tsi_shell_add_points(arena, shell, input->n_points);
  shell->facet = from->facet;
  shell->domain = from->domain;
  shell->patch = tsi_arena_new(arena, (size_t)n, sizeof *shell->patch);
  shell->place = tsi_arena_new(arena, (size_t)n, sizeof *shell->place);
  shell->moebius = tsi_arena_new(arena, (size_t)n, sizeof *shell->moebius);
  shell->tspline = tsi_arena_new(arena, (size_t)n, sizeof *shell->tspline);
  shell->elements = tsi_arena_new(arena, (size_t)n, sizeof *shell->elements);
  if (!shell->patch || !shell->tspline || !shell->elements || !shell->place || !shell->moebius ||
      first_point < 0)
    return tsi_no_memory(context, stage);
  for (size_t i = 0; i < 4 * (size_t)input->n_points; i++)
    shell->control[i] = input->points[i] + 0.0; /* no -0 */
  memcpy(shell->n_strips, cube->n_strips, sizeof shell->n_strips);
  int p = 0;
  for (int side = 0; side < 6; side++) {
    int count = shell->n_strips[tsi_side_s(side)] * shell->n_strips[tsi_side_t(side)];
    shell->first[side] = p;
    for (int i = 0; i < count; i++, p++) {
      tsolid_status status = place_patch(context, arena, from, &cube->place[side][i], p, shell);
      if (status)
        return status;
    }
  }
  shell->first[6] = p;
  return TSOLID_OK;
}

/* The list has the pieces of a patch side by side, so they keep their numbers. */
static tsolid_status record_placements(tsolid_context *context, const tsi_shell *shell,
                                       const tsi_patch_list *list, int n_patches,
                                       tsolid_boundary *boundary) {
  boundary->placement = tsi_new(&context->allocator, (size_t)list->n, sizeof *boundary->placement);
  boundary->placement_start = tsi_new(&context->allocator, (size_t)n_patches + 1, sizeof(int));
  if (!boundary->placement || !boundary->placement_start)
    return tsi_no_memory(context, stage);
  boundary->n_patches = n_patches;
  for (int k = 0; k < list->n; k++)
    boundary->placement_start[list->facet[k].patch + 1] = k + 1;
  for (int side = 0; side < 6; side++)
    for (int p = shell->first[side]; p < shell->first[side + 1]; p++) {
      const tsi_place *place = shell->place[p];
      tsolid_placement *out = &boundary->placement[place->facet];
      int s = tsi_side_s(side), t = tsi_side_t(side), at = p - shell->first[side];
      const double *line_s = shell->line[s] + at % shell->n_strips[s];
      const double *line_t = shell->line[t] + at / shell->n_strips[s];
      *out = (tsolid_placement){.side = side,
                                .swap = place->swap,
                                .flip = {place->flip[0], place->flip[1]},
                                .box = {line_s[0], line_s[1], line_t[0], line_t[1]}};
      memcpy(out->domain, list->domain[place->facet], sizeof out->domain);
      for (int d = 0; d < 2; d++) {
        double a = shell->moebius[p][place->swap ? 1 - d : d];
        out->moebius[d] = place->flip[d] ? 1.0 / a : a;
      }
    }
  return TSOLID_OK;
}

/* ---- draft to boundary ------------------------------------------------------------------------
 */

typedef struct element_order {
  double s0, t0;
  int element;
} element_order;

static int compare_elements(const void *a, const void *b) {
  const element_order *p = a, *q = b;
  if (p->t0 != q->t0)
    return p->t0 < q->t0 ? -1 : 1;
  if (p->s0 != q->s0)
    return p->s0 < q->s0 ? -1 : 1;
  return (p->element > q->element) - (p->element < q->element);
}

typedef struct function_order {
  const double *coefficient, *point;
  size_t n;
  int id, entry;
} function_order;

/* By coefficients, largest first, then by control point: nothing else tells functions apart. */
static int compare_functions(const void *a, const void *b) {
  const function_order *p = a, *q = b;
  for (size_t i = 0; i < p->n; i++)
    if (p->coefficient[i] != q->coefficient[i])
      return p->coefficient[i] > q->coefficient[i] ? -1 : 1;
  for (int c = 0; c < 4; c++)
    if (p->point[c] != q->point[c])
      return p->point[c] < q->point[c] ? -1 : 1;
  return (p->id > q->id) - (p->id < q->id);
}

static int compare_ids(const void *a, const void *b) {
  const function_order *p = a, *q = b;
  return (p->id > q->id) - (p->id < q->id);
}

static int allocate_side(const tsi_allocator *allocator, const tsi_side *from, tsi_side *to) {
  size_t n = (size_t)from->n_elements, entries = (size_t)from->function_start[n];
  size_t width = (size_t)(from->degree[0] + 1) * (size_t)(from->degree[1] + 1);
  memcpy(to->degree, from->degree, sizeof to->degree);
  memcpy(to->grid, from->grid, sizeof to->grid);
  to->n_elements = from->n_elements;
  to->box = tsi_new(allocator, n, 4 * sizeof *to->box);
  to->function_start = tsi_new(allocator, n + 1, sizeof *to->function_start);
  to->function = tsi_new(allocator, entries, sizeof *to->function);
  to->coefficient = tsi_new(allocator, entries * width, sizeof *to->coefficient);
  return to->box && to->function_start && to->function && to->coefficient;
}

/* Copies a side in canonical order: elements by t, then s; functions renumbered by first
 * appearance (number[] of the draft's, -1 where not yet seen), ascending within an element. */
static tsolid_status copy_side(tsolid_context *context, tsi_arena *arena, const tsi_draft *draft,
                               const tsi_side *from, int *number, int *n_numbered, tsi_side *to) {
  size_t width = (size_t)(from->degree[0] + 1) * (size_t)(from->degree[1] + 1);
  int n = from->n_elements, most = 1;
  for (int e = 0; e < n; e++) {
    int count = from->function_start[e + 1] - from->function_start[e];
    most = count > most ? count : most;
  }
  element_order *order = tsi_arena_new(arena, (size_t)n, sizeof *order);
  function_order *list = tsi_arena_new(arena, (size_t)most, sizeof *list);
  if (!order || !list || !allocate_side(&context->allocator, from, to))
    return tsi_no_memory(context, stage);
  for (int e = 0; e < n; e++)
    order[e] = (element_order){from->box[4 * e], from->box[4 * e + 2], e};
  qsort(order, (size_t)n, sizeof *order, compare_elements);
  int entry = 0;
  for (int e = 0; e < n; e++) {
    int old = order[e].element, first = from->function_start[old];
    int count = from->function_start[old + 1] - first;
    for (int k = 0; k < count; k++) {
      int id = from->function[first + k];
      list[k] = (function_order){from->coefficient + (size_t)(first + k) * width,
                                 draft->points + 4 * (size_t)id, width, id, first + k};
    }
    qsort(list, (size_t)count, sizeof *list, compare_functions);
    for (int k = 0; k < count; k++) {
      if (number[list[k].id] < 0)
        number[list[k].id] = (*n_numbered)++;
      list[k].id = number[list[k].id];
    }
    qsort(list, (size_t)count, sizeof *list, compare_ids);
    memcpy(to->box + 4 * e, from->box + 4 * old, 4 * sizeof *to->box);
    for (int k = 0; k < count; k++, entry++) {
      to->function[entry] = list[k].id;
      memcpy(to->coefficient + (size_t)entry * width, list[k].coefficient,
             width * sizeof *to->coefficient);
    }
    to->function_start[e + 1] = entry;
  }
  return TSOLID_OK;
}

double tsi_boundary_find_scale(const tsolid_boundary *boundary) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  double largest = 0.0;
  for (int i = 0; i < boundary->n_functions; i++)
    for (int c = 0; c < 3; c++) {
      double x = boundary->points[4 * (size_t)i + (size_t)c] / boundary->points[4 * (size_t)i + 3];
      low[c] = fmin(low[c], x);
      high[c] = fmax(high[c], x);
      largest = fmax(largest, fabs(x));
    }
  double diagonal = hypot(hypot(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
  return fmax(diagonal, largest);
}

/* The point of the surface at a corner of the cube, from the side z low or high. */
static void find_corner(const tsolid_boundary *boundary, int corner, double x[3]) {
  const tsi_side *side = &boundary->side[4 + (corner >> 2)];
  size_t n0 = (size_t)side->degree[0] + 1, n1 = (size_t)side->degree[1] + 1;
  size_t at = (corner & 1 ? n0 - 1 : 0) + (corner & 2 ? n0 * (n1 - 1) : 0);
  double h[4] = {0.0, 0.0, 0.0, 0.0};
  for (int e = 0; e < side->n_elements; e++) {
    const double *box = side->box + 4 * (size_t)e;
    if (box[corner & 1] != (double)(corner & 1) ||
        box[2 + (corner >> 1 & 1)] != (double)(corner >> 1 & 1))
      continue;
    for (int k = side->function_start[e]; k < side->function_start[e + 1]; k++)
      for (size_t c = 0; c < 4; c++)
        h[c] += side->coefficient[(size_t)k * n0 * n1 + at] *
                boundary->points[4 * (size_t)side->function[k] + c];
  }
  tsi_project_point(h, x);
}

static tsolid_status finish_draft(tsolid_context *context, tsi_arena *arena, const tsi_draft *draft,
                                  tsolid_boundary **out) {
  int n = draft->n_functions, n_numbered = 0;
  int *number = tsi_arena_new(arena, (size_t)n, sizeof *number);
  tsolid_boundary *boundary = tsi_boundary_new(context, n);
  *out = boundary;
  if (!number || !boundary)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < n; i++)
    number[i] = -1;
  tsolid_status status = TSOLID_OK;
  for (int i = 0; !status && i < 6; i++)
    status =
        copy_side(context, arena, draft, &draft->side[i], number, &n_numbered, &boundary->side[i]);
  for (int i = 0; !status && i < n; i++) {
    if (number[i] < 0)
      return tsi_fail(context, TSOLID_ERROR_INPUT, stage, "Function %d is on no element", i);
    memcpy(boundary->points + 4 * (size_t)number[i], draft->points + 4 * (size_t)i,
           4 * sizeof *boundary->points);
  }
  if (!status)
    boundary->scale = tsi_boundary_find_scale(boundary);
  return status;
}

/* ---- the driver --------------------------------------------------------------------------------
 */

/* All T-splines and Bezier elements take the input's points, and every point is taken. */
static tsolid_status vet_points(tsolid_context *context, tsi_arena *arena,
                                const tsolid_boundary_input *input, const tsi_patch_list *list) {
  int n = input->n_points;
  unsigned char *used = tsi_arena_new(arena, (size_t)n, 1);
  if (!used)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < list->n; k++) {
    const tsi_side *e = &list->elements[k];
    for (int i = 0; e->n_elements && i < e->function_start[e->n_elements]; i++)
      used[e->function[i]] = 1;
  }
  for (int i = 0; i < n; i++)
    if (!used[i]) {
      tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
      finding.entity = TSOLID_ENTITY_FUNCTION;
      finding.index[0] = i;
      return tsi_report(context, &finding, "Point %d is of no function of a patch", i);
    }
  return TSOLID_OK;
}

static tsolid_status read_patch(tsolid_context *context, tsi_arena *arena,
                                const tsolid_boundary_input *input, int k, tsi_patch_list *list) {
  if (has_form(&input->patches[k]))
    return tsi_form_read(context, arena, input, k, &list->tspline[k], &list->elements[k]);
  tsolid_status status = tsi_patch_vet(context, &input->patches[k], k);
  if (!status && !tsi_patch_read(arena, &input->patches[k], &list->patch[k]))
    status = tsi_no_memory(context, stage);
  return status;
}

static tsolid_status read_patches(tsolid_context *context, tsi_arena *arena,
                                  const tsolid_boundary_input *input, double tolerance,
                                  double middle[3], tsi_patch_list *list) {
  int n = input->n_patches;
  tsolid_status status = TSOLID_OK;
  if (!tsi_patch_list_create(arena, n, list))
    return tsi_no_memory(context, stage);
  if (input->n_points)
    status = tsi_points_check(context, input->n_points, input->points);
  for (int k = 0; k < n && (!status || status == TSOLID_ERROR_INPUT); k++) {
    tsolid_status own = read_patch(context, arena, input, k, list);
    status = own ? own : status;
  }
  if (!status)
    status = vet_points(context, arena, input, list);
  if (status)
    return status;
  find_middle(input, middle);
  for (int k = 0; !status && k < n; k++) {
    tsi_facet *facet = &list->facet[k];
    for (int d = 0; d < 2; d++)
      tsi_form_domain(&input->patches[k], d, list->domain[k] + 2 * d);
    if (list->patch[k].n[0])
      measure_patch(&input->patches[k], &list->patch[k], middle, facet);
    else
      status = tsi_side_measure(context, input->points, &list->elements[k], middle, facet);
    name_facet(&input->patches[k], k, tolerance, facet);
  }
  return status;
}

/* The caller's corners are the cube's. */
static tsolid_status check_corners(tsolid_context *context, const tsi_patch_list *list,
                                   const tsolid_boundary_options *options,
                                   tsolid_requirement *requirement) {
  double allowed = 0.0;
  int taken[8] = {0};
  for (int k = 0; k < list->n; k++)
    for (int b = 0; b < 4; b++)
      allowed = fmax(allowed, list->facet[k].tolerance[b]);
  for (int i = 0; i < options->n_corners; i++) {
    const double *x = options->corners + 3 * i;
    int nearest = 0;
    for (int k = 1; k < 8; k++)
      if (tsi_distance(x, requirement->corner[k]) < tsi_distance(x, requirement->corner[nearest]))
        nearest = k;
    double distance = tsi_distance(x, requirement->corner[nearest]);
    if (distance <= allowed && !taken[nearest]++)
      continue;
    const double *at = requirement->corner[nearest];
    const char *name = requirement->corner_name[nearest];
    tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
    tsi_set_point(&finding, x);
    finding.measured = distance;
    finding.allowed = allowed;
    requirement->satisfied = 0;
    requirement->n_violations++;
    return tsi_report(
        context, &finding,
        "(%.6g, %.6g, %.6g) was given as a corner of the cube, but %s: the nearest of "
        "the eight vertices with three faces is %s at (%.6g, %.6g, %.6g)",
        x[0], x[1], x[2],
        distance <= allowed ? "another point is there too" : "the cube has none there",
        *name ? name : "the one", at[0], at[1], at[2]);
  }
  return TSOLID_OK;
}

static tsolid_status create_from_patches(tsolid_context *context, tsi_arena *arena,
                                         const tsolid_boundary_input *input,
                                         const tsolid_boundary_options *options, double tolerance,
                                         tsolid_requirement *requirement,
                                         tsolid_boundary **boundary) {
  tsi_patch_list list;
  tsi_cube cube;
  tsi_shell shell = {.patch = NULL};
  tsi_draft draft = {.points = NULL};
  tsolid_preparation preparation = {.knot_merge = 0.0};
  double middle[3];
  tsolid_status status = read_patches(context, arena, input, tolerance, middle, &list);
  if (!status)
    status = tsi_split(context, arena, input, tolerance, middle, &list, &preparation);
  requirement->n_violations += status == TSOLID_ERROR_REFUSED;
  if (!status)
    status = tsi_cube_find(context, arena, list.n, list.facet, requirement, &cube);
  if (!status)
    status = check_corners(context, &list, options, requirement);
  if (!status)
    status = tsi_progress(context, stage, 0.3);
  if (!status)
    status = place_patches(context, arena, &cube, &list, input, &shell);
  int n_findings = context->n_findings;
  if (!status)
    status = tsi_shell_match_parameters(context, arena, &shell, &preparation);
  if (!status)
    status = tsi_shell_multiply_weights(context, arena, &shell, &preparation);
  if (!status)
    status = tsi_shell_unify(context, arena, &shell, options, &preparation);
  if (!status)
    status = tsi_shell_refine_rows(context, arena, &shell, &preparation);
  if (!status)
    status = tsi_shell_match_weights(context, arena, &shell, &preparation);
  if (!status)
    status = tsi_shell_snap(context, arena, &shell, &preparation);
  if (!status)
    status = tsi_shell_draft(context, arena, &shell, input, &preparation, &draft);
  if (status && requirement->satisfied) { /* borders matched, but not point by point */
    requirement->satisfied = 0;
    requirement->n_violations += context->n_findings - n_findings;
  }
  if (!status)
    status = tsi_progress(context, stage, 0.6);
  if (!status && input->n_points) /* what the input's own functions are */
    status = tsi_sides_check(context, draft.n_functions, draft.points, draft.side, 1);
  if (!status)
    status = finish_draft(context, arena, &draft, boundary);
  if (!status)
    status = record_placements(context, &shell, &list, input->n_patches, *boundary);
  if (!status)
    (*boundary)->preparation = preparation;
  return status;
}

static tsolid_status create_from_bezier(tsolid_context *context, tsi_arena *arena,
                                        const tsolid_boundary_input *input, double tolerance,
                                        tsolid_requirement *requirement,
                                        tsolid_boundary **boundary) {
  tsi_draft draft = {.points = NULL};
  tsolid_bezier_boundary cut;
  tsolid_requirement of_sides = {.genus = -1};
  const tsolid_bezier_boundary *bezier = input->surface ? &cut : input->bezier;
  tsolid_status status = TSOLID_OK;
  if (input->surface)
    status = tsi_surface_to_sides(context, arena, input->surface, requirement, &cut);
  if (!status)
    status = tsi_draft_from_bezier(context, arena, bezier, tolerance,
                                   input->surface ? &of_sides : requirement, &draft);
  if (!status)
    status = finish_draft(context, arena, &draft, boundary);
  if (!status && input->surface) { /* the counts stay those of the surface */
    requirement->satisfied = 1;
    memcpy(requirement->side_grid, of_sides.side_grid, sizeof of_sides.side_grid);
  }
  for (int i = 0; !status && i < 6; i++)
    (*boundary)->preparation.weight_factor[i] = 1.0;
  return status;
}

static tsolid_status check_forms(tsolid_context *context, const tsolid_boundary_input *input,
                                 const tsolid_boundary_options *options) {
  int n_forms = 0;
  for (int k = 0; k < input->n_patches; k++)
    n_forms += has_form(&input->patches[k]);
  if (n_forms && (options->refine_knots || options->raise_degree))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "Only NURBS patches can be refined, not T-splines or Bezier elements");
  if (!n_forms != !input->n_points || !input->n_points != !input->points || input->n_points < 0)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "There are %d points for %d T-spline or Bezier patches", input->n_points,
                    n_forms);
  if (input->n_smooth < 0 || !input->n_smooth != !input->smooth)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "There are %d smooth seams",
                    input->n_smooth);
  return TSOLID_OK;
}

static tsolid_status check_arguments(tsolid_context *context, const tsolid_boundary_input *input,
                                     const tsolid_boundary_options *options) {
  if (!input || (input->bezier != NULL) + (input->patches != NULL) + (input->surface != NULL) != 1)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "The input must be patches, Bezier sides or a surface, one of the three");
  if (input->patches && (input->n_patches < 1 || input->n_patches > TSI_MAX_COUNT / 64))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "There are %d patches",
                    input->n_patches);
  if (!(options->tolerance >= 0.0) || !isfinite(options->tolerance))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "The tolerance is %g, it must be finite and not negative", options->tolerance);
  if (options->refine_knots < 0 || options->refine_knots > 6)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "refine_knots is %d, not one of 0 to 6",
                    options->refine_knots);
  if (options->raise_degree < 0 || options->raise_degree >= TSI_MAX_DEGREE)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "raise_degree is %d, not one of 0 to %d",
                    options->raise_degree, TSI_MAX_DEGREE - 1);
  if ((options->n_corners != 0 && options->n_corners != 8) ||
      (options->n_corners && (!options->corners || !input->patches)))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "%d corners are given, eight are needed, of a boundary of patches",
                    options->n_corners);
  for (int i = 0; i < 3 * options->n_corners; i++)
    if (!isfinite(options->corners[i]))
      return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "Corner %d is not finite", i / 3);
  if (!input->patches && (options->refine_knots || options->raise_degree))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "Only NURBS patches can be refined, not Bezier elements");
  return input->patches ? check_forms(context, input, options) : TSOLID_OK;
}

tsolid_status tsolid_boundary_create(tsolid_context *context, const tsolid_boundary_input *input,
                                     const tsolid_boundary_options *options,
                                     tsolid_requirement *requirement, tsolid_boundary **boundary) {
  static const tsolid_boundary_options defaults;
  tsolid_requirement found = {.genus = -1};
  if (requirement)
    *requirement = found;
  if (boundary)
    *boundary = NULL;
  if (!context || !boundary)
    return TSOLID_ERROR_ARGUMENT;
  if (!options)
    options = &defaults;
  tsi_arena arena = tsi_arena_create(context);
  tsolid_boundary *made = NULL;
  tsolid_status status = check_arguments(context, input, options);
  if (status)
    goto done;
  status = tsi_progress(context, stage, 0.0);
  if (status)
    goto done;
  found.n_patches = input->bezier ? 6 : input->surface ? 0 : input->n_patches;
  double tolerance = options->tolerance > 0.0 ? options->tolerance : default_tolerance;
  if (!input->patches)
    status = create_from_bezier(context, &arena, input, tolerance, &found, &made);
  else
    status = create_from_patches(context, &arena, input, options, tolerance, &found, &made);
  if (status)
    goto done;
  for (int i = 0; i < 8; i++)
    find_corner(made, i, found.corner[i]);
  made->requirement = found;
  int n_findings = context->n_findings;
  status = tsi_boundary_check_folds(context, made);
  if (status) {
    found.satisfied = 0;
    found.n_violations += context->n_findings - n_findings;
  } else
    status = tsi_progress(context, stage, 1.0);
done:
  tsi_arena_free(&arena);
  if (requirement)
    *requirement = found;
  if (status)
    tsolid_boundary_free(made);
  else
    *boundary = made;
  return status;
}
