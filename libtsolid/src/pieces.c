/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Patches cut along isolines, exactly.
 *
 * NURBS: the knot x is inserted until it stands `degree` times; the surface then interpolates a row
 * of control points there, and each side of it, its end knots once more, is a NURBS patch of its
 * own. T-splines: a piece is the same functions on a part of the domain, knots affinely changed.
 * Bezier elements: boxes cut, coefficients restricted. In both the pieces share their functions, so
 * that the surface stays as smooth across the cut as it was, as far as strips can have the widths
 * of the parameters; across cuts through NURBS patches functions are C^0: a neighbour with a corner
 * there has clamped functions, which the functions along their common border must equal.
 *
 * Cutting is arithmetic, so it is done in the orientation of tsi_split_patch and the pieces are
 * turned back, which moves values only: the input's own orientation does not show in the bits. */
#include <stdio.h>
#include <stdlib.h>

#include "bernstein.h"
#include "bspline.h"
#include "split.h"

static const char stage[] = "boundary";

/* ---- one patch ---------------------------------------------------------------------------------
 */

/* The knots with each cut `degree` times. Returns their number. */
static int unite_cuts(const tsi_patch *patch, int along, const tsi_cuts *cuts, double *to) {
  int degree = patch->degree[along], n_knots = patch->n[along] + degree + 1, n = 0, i = 0;
  for (int c = 0; c < cuts->n; c++) {
    double x = cuts->cut[c].x;
    int count = 0;
    for (; i < n_knots && patch->knots[along][i] <= x; i++) {
      count += patch->knots[along][i] == x;
      to[n++] = patch->knots[along][i];
    }
    for (; count < degree; count++)
      to[n++] = x;
  }
  for (; i < n_knots; i++)
    to[n++] = patch->knots[along][i];
  return n;
}

/* Rows first .. end - 1 of a refined patch as a patch: knots first + 1 .. end + degree - 1, the end
 * ones once more. */
static int take_rows(tsi_arena *arena, const tsi_patch *from, int along, int first, int end,
                     tsi_patch *to) {
  int degree = from->degree[along], n = end - first;
  size_t n0 = (size_t)from->n[0];
  *to = *from;
  to->n[along] = n;
  to->knots[along] = tsi_arena_new(arena, (size_t)(n + degree + 1), sizeof(double));
  to->control = tsi_arena_new(arena, (size_t)to->n[0] * (size_t)to->n[1], 4 * sizeof(double));
  if (!to->knots[along] || !to->control)
    return 0;
  double *knots = to->knots[along];
  memcpy(knots + 1, from->knots[along] + first + 1, (size_t)(n + degree - 1) * sizeof *knots);
  knots[0] = knots[1];
  knots[n + degree] = knots[n + degree - 1];
  tsi_knots_normalise(n + degree + 1, knots, knots);
  for (int j = 0; j < to->n[1]; j++) {
    size_t row = along ? n0 * (size_t)(first + j) : (size_t)first + n0 * (size_t)j;
    memcpy(to->control + 4 * (size_t)to->n[0] * (size_t)j, from->control + 4 * row,
           4 * (size_t)to->n[0] * sizeof(double));
  }
  return 1;
}

/* cuts->n + 1 pieces. */
static int cut_patch(tsi_arena *arena, const tsi_patch *from, int along, const tsi_cuts *cuts,
                     tsi_patch *out) {
  int degree = from->degree[along], n_knots = from->n[along] + degree + 1;
  double *to = tsi_arena_new(arena, (size_t)(n_knots + degree * cuts->n), sizeof *to);
  if (!to)
    return 0;
  tsi_patch fine = *from;
  int n_to = unite_cuts(from, along, cuts, to) - degree - 1;
  if (!tsi_patch_refine(arena, &fine, along, 0, n_to, to))
    return 0;
  for (int c = 0, first = 0; c <= cuts->n; c++) {
    int last = n_to - 1;
    if (c < cuts->n)
      for (last = first; to[last + 1] != cuts->cut[c].x;)
        last++;
    if (!take_rows(arena, &fine, along, first, last + 1, &out[c]))
      return 0;
    first = last;
  }
  return 1;
}

/* The part of [low, high] of a box side, on that interval as [0,1]. */
static void restrict_interval(const double from[2], double low, double high, double to[2]) {
  double a = (from[0] - low) / (high - low), b = (from[1] - low) / (high - low);
  to[0] = from[0] <= low ? 0.0 : 1.0 - (1.0 - a);
  to[1] = from[1] >= high ? 1.0 : 1.0 - (1.0 - b);
}

static void restrict_coefficients(const int degree[2], const double *box, const double *part,
                                  double *coefficient) {
  for (int d = 0; d < 2; d++) {
    double low = box[2 * d], width = box[2 * d + 1] - low;
    double a = part[2 * d] <= low ? 0.0 : (part[2 * d] - low) / width;
    double b = part[2 * d + 1] >= box[2 * d + 1] ? 1.0 : (part[2 * d + 1] - low) / width;
    int n_rows = degree[1 - d] + 1, step = d ? degree[0] + 1 : 1, stride = d ? 1 : degree[0] + 1;
    for (int k = 0; k < n_rows; k++)
      tsi_bernstein_restrict(degree[d], a, b, coefficient + stride * k, step);
  }
}

/* The elements in `part` of the unit square. */
static int cut_elements(tsi_arena *arena, const tsi_side *from, const double part[4],
                        tsi_side *to) {
  size_t width = (size_t)(from->degree[0] + 1) * (size_t)(from->degree[1] + 1), entry = 0;
  size_t n_entries = (size_t)from->function_start[from->n_elements];
  *to = (tsi_side){.degree = {from->degree[0], from->degree[1]}, .grid = {1, 1}};
  to->box = tsi_arena_new(arena, (size_t)from->n_elements, 4 * sizeof *to->box);
  to->function_start = tsi_arena_new(arena, (size_t)from->n_elements + 1, sizeof(int));
  to->function = tsi_arena_new(arena, n_entries, sizeof *to->function);
  to->coefficient = tsi_arena_new(arena, n_entries * width, sizeof *to->coefficient);
  if (!to->box || !to->function_start || !to->function || !to->coefficient)
    return 0;
  for (int e = 0; e < from->n_elements; e++) {
    const double *box = from->box + 4 * (size_t)e;
    if (box[1] <= part[0] || box[0] >= part[1] || box[3] <= part[2] || box[2] >= part[3])
      continue;
    for (int k = from->function_start[e]; k < from->function_start[e + 1]; k++, entry++) {
      to->function[entry] = from->function[k];
      memcpy(to->coefficient + entry * width, from->coefficient + (size_t)k * width,
             width * sizeof *to->coefficient);
      restrict_coefficients(from->degree, box, part, to->coefficient + entry * width);
    }
    for (int d = 0; d < 2; d++)
      restrict_interval(box + 2 * d, part[2 * d], part[2 * d + 1],
                        to->box + 4 * (size_t)to->n_elements + 2 * d);
    to->function_start[++to->n_elements] = (int)entry;
  }
  return 1;
}

/* The functions that do not vanish on `part`. */
static int cut_tspline(tsi_arena *arena, const tsi_tspline *from, const double part[4],
                       tsi_tspline *to) {
  *to = (tsi_tspline){.degree = {from->degree[0], from->degree[1]}};
  to->blend = tsi_arena_new(arena, (size_t)from->n, sizeof *to->blend);
  for (int d = 0; d < 2; d++)
    to->knots[d] =
        tsi_arena_new(arena, (size_t)from->n * (size_t)(from->degree[d] + 2), sizeof(double));
  if (!to->blend || !to->knots[0] || !to->knots[1])
    return 0;
  for (int b = 0; b < from->n; b++) {
    int inside = 1;
    for (int d = 0; d < 2; d++) {
      const double *knot = from->knots[d] + from->blend[b].knot[d];
      inside &= knot[0] < part[2 * d + 1] && knot[from->degree[d] + 1] > part[2 * d];
    }
    if (!inside)
      continue;
    for (int d = 0; d < 2; d++) {
      const double *knot = from->knots[d] + from->blend[b].knot[d];
      double low = part[2 * d], width = part[2 * d + 1] - low;
      to->blend[to->n].knot[d] = to->n_knots[d];
      for (int k = 0; k < from->degree[d] + 2; k++) {
        double x = knot[k] == part[2 * d + 1] ? 1.0 : (knot[k] - low) / width;
        to->knots[d][to->n_knots[d]++] = 1.0 - (1.0 - x);
      }
    }
    to->blend[to->n++].point = from->blend[b].point;
  }
  return tsi_tspline_find_rows(arena, to);
}

/* ---- the list ----------------------------------------------------------------------------------
 */

typedef struct piece_maker {
  tsolid_context *context;
  tsi_arena *arena;
  const tsolid_boundary_input *input;
  const tsi_patch_list *from;
  const double *origin;
  double tolerance; /* of the cuts, as borders */
  tsi_patch_list *to;
} piece_maker;

int tsi_patch_list_create(tsi_arena *arena, int n, tsi_patch_list *list) {
  *list = (tsi_patch_list){.n = n,
                           .patch = tsi_arena_new(arena, (size_t)n, sizeof *list->patch),
                           .tspline = tsi_arena_new(arena, (size_t)n, sizeof *list->tspline),
                           .elements = tsi_arena_new(arena, (size_t)n, sizeof *list->elements),
                           .facet = tsi_arena_new(arena, (size_t)n, sizeof *list->facet),
                           .domain = tsi_arena_new(arena, (size_t)n, sizeof *list->domain)};
  return list->patch && list->tspline && list->elements && list->facet && list->domain;
}

/* Ends of interval i of the cuts. */
static void find_part(const tsi_cuts *cuts, int i, double part[2]) {
  part[0] = i ? cuts->cut[i - 1].x : 0.0;
  part[1] = i < cuts->n ? cuts->cut[i].x : 1.0;
}

static double own_parameter(const double domain[2], double x) {
  return x == 0.0 ? domain[0] : x == 1.0 ? domain[1] : domain[0] + x * (domain[1] - domain[0]);
}

/* "the cut at u = 0.5" */
static const char *name_cut(tsi_arena *arena, int d, double x) {
  char *text = tsi_arena_new(arena, TSI_NAME_SIZE, 1);
  if (text)
    snprintf(text, TSI_NAME_SIZE, "the cut at %c = %.9g", 'u' + d, x);
  return text;
}

/* Names and tolerances, and the corners that are the patch's own. */
static int name_piece(const piece_maker *m, const tsi_facet *source, int piece,
                      const double whole[4]) {
  tsi_facet *facet = &m->to->facet[piece];
  const double *domain = m->to->domain[piece];
  static const int end_of_border[4] = {2, 1, 3, 0}; /* v low, u high, v high, u low */
  facet->patch = source->patch;
  facet->fixed = source->fixed;
  facet->name = source->name;
  for (int b = 0; b < 4; b++) {
    int end = end_of_border[b], u = b == 1 || b == 2, v = 2 + (b >= 2);
    facet->is_cut[b] = domain[end] != whole[end];
    facet->tolerance[b] = facet->is_cut[b] ? m->tolerance : source->tolerance[b];
    facet->border_name[b] =
        facet->is_cut[b] ? name_cut(m->arena, end >> 1, domain[end]) : source->border_name[b];
    facet->is_inner[b] = domain[u] != whole[u] || domain[v] != whole[v];
    if (facet->is_cut[b] && !facet->border_name[b])
      return 0;
    if (facet->is_inner[b])
      continue;
    facet->corner_name[b] = source->corner_name[b];
    memcpy(facet->corner[b], source->corner[b], sizeof facet->corner[b]);
  }
  return 1;
}

static tsolid_status measure_piece(const piece_maker *m, int number, int piece) {
  const tsi_facet *source = &m->from->facet[number];
  tsi_patch_list *to = m->to;
  tsolid_status status = TSOLID_OK;
  if (to->patch[piece].n[0])
    tsi_facet_measure(&to->patch[piece], m->origin, &to->facet[piece]);
  else
    status = tsi_side_measure(m->context, m->input->points, &to->elements[piece], m->origin,
                              &to->facet[piece]);
  if (!status && !name_piece(m, source, piece, m->from->domain[number]))
    status = tsi_no_memory(m->context, stage);
  return status;
}

/* Piece (i, j) of the oriented form, turned back, is entry `piece` of the list. */
static tsolid_status make_form_piece(const piece_maker *m, const tsi_split_patch *split,
                                     const tsi_tspline *tspline, const double part[4],
                                     const tsi_place *back, int piece) {
  char name[TSI_NAME_SIZE];
  const tsi_facet *source = &m->from->facet[split->number];
  tsi_tspline own;
  tsi_side elements;
  if (!tspline->n) {
    if (!cut_elements(m->arena, &split->elements, part, &elements))
      return tsi_no_memory(m->context, stage);
    return tsi_side_move(m->context, m->arena, &elements, back, &m->to->elements[piece]);
  }
  if (!cut_tspline(m->arena, tspline, part, &own) ||
      !tsi_tspline_orient(m->arena, &own, back->flip, back->swap, &m->to->tspline[piece]))
    return tsi_no_memory(m->context, stage);
  return tsi_tspline_elements(m->context, m->arena, &m->to->tspline[piece],
                              m->to->tspline[piece].degree, tsi_name_facet(source, name),
                              &m->to->elements[piece]);
}

static tsolid_status make_nurbs_pieces(const piece_maker *m, const tsi_split_patch *split,
                                       tsi_patch *piece) {
  int n_u = split->cuts[0].n + 1, n_v = split->cuts[1].n + 1;
  tsi_patch *column = tsi_arena_new(m->arena, (size_t)n_u, sizeof *column);
  if (!column || !cut_patch(m->arena, &split->patch, 0, &split->cuts[0], column))
    return tsi_no_memory(m->context, stage);
  for (int i = 0; i < n_u; i++)
    if (!cut_patch(m->arena, &column[i], 1, &split->cuts[1], piece + (size_t)i * (size_t)n_v))
      return tsi_no_memory(m->context, stage);
  return TSOLID_OK;
}

/* All pieces of one patch, from entry `first` of the list on. */
static tsolid_status make_pieces(const piece_maker *m, const tsi_split_patch *split, int first) {
  int k = split->number, n[2] = {split->cuts[0].n + 1, split->cuts[1].n + 1};
  int swap = split->place.swap, own_n[2] = {n[swap], n[1 - swap]};
  const int *flip = split->place.flip;
  tsi_place back = {.swap = swap, .flip = {flip[swap], flip[1 - swap]}};
  tsi_tspline tspline = {.n = 0};
  tsi_patch *nurbs = NULL;
  tsolid_status status = TSOLID_OK;
  if (split->patch.n[0]) {
    nurbs = tsi_arena_new(m->arena, (size_t)n[0] * (size_t)n[1], sizeof *nurbs);
    status = nurbs ? make_nurbs_pieces(m, split, nurbs) : tsi_no_memory(m->context, stage);
  } else if (m->from->tspline[k].n &&
             !tsi_tspline_orient(m->arena, &m->from->tspline[k], flip, swap, &tspline)) {
    status = tsi_no_memory(m->context, stage);
  }
  for (int i = 0; i < n[0]; i++)
    for (int j = 0; !status && j < n[1]; j++) {
      int at[2] = {swap ? j : i, swap ? i : j}; /* in the input's orientation */
      double part[4];
      find_part(&split->cuts[0], i, part);
      find_part(&split->cuts[1], j, part + 2);
      for (int d = 0; d < 2; d++)
        at[d] = flip[d] ? own_n[d] - 1 - at[d] : at[d];
      int piece = first + at[0] + own_n[0] * at[1];
      for (int d = 0; d < 2; d++) {
        const double *x = part + 2 * (swap ? 1 - d : d), *whole = m->from->domain[k] + 2 * d;
        m->to->domain[piece][2 * d] = own_parameter(whole, flip[d] ? 1.0 - x[1] : x[0]);
        m->to->domain[piece][2 * d + 1] = own_parameter(whole, flip[d] ? 1.0 - x[0] : x[1]);
      }
      if (!nurbs)
        status = make_form_piece(m, split, &tspline, part, &back, piece);
      else if (!tsi_patch_orient(m->arena, &nurbs[(size_t)i * (size_t)n[1] + (size_t)j], back.flip,
                                 back.swap, &m->to->patch[piece]))
        status = tsi_no_memory(m->context, stage);
      if (!status)
        status = measure_piece(m, k, piece);
    }
  return status;
}

static void copy_patch(const tsi_patch_list *from, int k, tsi_patch_list *to, int piece) {
  to->patch[piece] = from->patch[k];
  to->tspline[piece] = from->tspline[k];
  to->elements[piece] = from->elements[k];
  to->facet[piece] = from->facet[k];
  memcpy(to->domain[piece], from->domain[k], sizeof to->domain[piece]);
}

tsolid_status tsi_pieces_make(tsolid_context *context, tsi_arena *arena,
                              const tsolid_boundary_input *input, double tolerance,
                              const double origin[3], const tsi_split_patch *split,
                              tsi_patch_list *list) {
  tsi_patch_list to;
  piece_maker m = {context, arena, input, list, origin, tolerance, &to};
  const tsi_split_patch **of = tsi_arena_new(arena, (size_t)list->n, sizeof *of);
  size_t n = 0;
  for (int k = 0; k < list->n; k++)
    n += (size_t)(split[k].cuts[0].n + 1) * (size_t)(split[k].cuts[1].n + 1);
  if (!of || !tsi_patch_list_create(arena, (int)n, &to))
    return tsi_no_memory(context, stage);
  for (int k = 0; k < list->n; k++)
    of[split[k].number] = &split[k];
  tsolid_status status = TSOLID_OK;
  for (int k = 0, first = 0; !status && k < list->n; k++) {
    int count = (of[k]->cuts[0].n + 1) * (of[k]->cuts[1].n + 1);
    if (count == 1)
      copy_patch(list, k, &to, first);
    else
      status = make_pieces(&m, of[k], first);
    first += count;
  }
  *list = to;
  return status;
}
