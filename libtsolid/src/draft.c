/* SPDX-License-Identifier: LGPL-2.1-or-later
 * From prepared patches to six sides of Bezier elements. Functions are the control points: those of
 * both sides of a seam that stand at the same place of a row are one. */
#include <stdlib.h>

#include "bernstein.h"
#include "seams.h"

static const char stage[] = "boundary";

/* ---- strip widths -----------------------------------------------------------------------------
 */

static double add_polygon(const tsi_row *row, double length) {
  const double *previous = NULL;
  for (int m = 0; m < row->n; m++) {
    const double *h = tsi_row_point(row, m);
    if (previous)
      length += hypot(
          hypot(h[0] / h[3] - previous[0] / previous[3], h[1] / h[3] - previous[1] / previous[3]),
          h[2] / h[3] - previous[2] / previous[3]);
    previous = h;
  }
  return length;
}

typedef struct border_length {
  double low, length;
} border_length;

static int compare_lengths(const void *a, const void *b) {
  const border_length *p = a, *q = b;
  return (p->low > q->low) - (p->low < q->low);
}

/* Length of the Bezier polygons along a border that is no row, summed in the order of the border;
 * NaN for want of memory. */
static double measure_elements(const tsi_shell *shell, tsi_arena *arena, int p, int along,
                               int end) {
  const tsi_side *e = &shell->elements[p];
  size_t n0 = (size_t)e->degree[0] + 1, width = n0 * ((size_t)e->degree[1] + 1);
  size_t step = along ? n0 : 1, fixed = !end ? 0 : along ? n0 - 1 : width - n0;
  border_length *list = tsi_arena_new(arena, (size_t)e->n_elements, sizeof *list);
  int n = 0;
  for (int i = 0; list && i < e->n_elements; i++) {
    double h[TSI_MAX_ORDER][4] = {{0.0}};
    if (e->box[4 * (size_t)i + (size_t)(2 * (1 - along) + end)] != (double)end)
      continue;
    for (int k = e->function_start[i]; k < e->function_start[i + 1]; k++)
      for (int m = 0; m <= e->degree[along]; m++)
        for (int c = 0; c < 4; c++)
          h[m][c] += e->coefficient[(size_t)k * width + fixed + step * (size_t)m] *
                     shell->control[4 * (size_t)e->function[k] + (size_t)c];
    list[n] = (border_length){e->box[4 * (size_t)i + (size_t)(2 * along)], 0.0};
    for (int m = 1; m <= e->degree[along]; m++)
      list[n].length += tsi_seam_distance(h[m - 1], h[m]);
    n++;
  }
  if (!list)
    return NAN;
  qsort(list, (size_t)n, sizeof *list, compare_lengths);
  double length = 0.0;
  for (int i = 0; i < n; i++)
    length += list[i].length;
  return (double)(float)length; /* rounded: functions come in any order */
}

/* Lengths of both border polygons of a patch along a direction. */
static double measure_borders(const tsi_shell *shell, tsi_arena *arena, int p, int along) {
  double length = 0.0;
  for (int end = 0; end < 2; end++) {
    tsi_seam s = {.row = {{p, along, end}}};
    tsi_row row = tsi_seam_row(shell, &s, 0);
    length =
        row.n ? add_polygon(&row, length) : length + measure_elements(shell, arena, p, along, end);
  }
  return length;
}

static double measure_strip(const tsi_shell *shell, tsi_arena *arena, int axis, int strip) {
  double length = 0.0;
  for (int side = 0; side < 6; side++) {
    int s = tsi_side_s(side), t = tsi_side_t(side);
    if (s != axis && t != axis)
      continue;
    int along = t == axis;
    for (int k = 0; k < shell->n_strips[along ? s : t]; k++) {
      int i = along ? k : strip, j = along ? strip : k;
      length +=
          measure_borders(shell, arena, shell->first[side] + i + shell->n_strips[s] * j, along);
    }
  }
  return length;
}

/* A seam inside a side that the surface is smooth across: one side is no row, so that functions
 * live on both, or the input says so. */
static int is_smooth(const tsi_shell *shell, const tsi_seam *s,
                     const tsolid_boundary_input *input) {
  int facet[2];
  for (int k = 0; k < 2; k++)
    facet[k] = shell->facet[shell->place[s->row[k].patch]->facet].patch;
  int smooth = !tsi_seam_has_rows(shell, s);
  for (int i = 0; i < input->n_smooth; i++) {
    const tsolid_smooth_seam *seam = &input->smooth[i];
    for (int k = 0; k < 2; k++)
      smooth |= seam->patch[k] == facet[0] && seam->patch[1 - k] == facet[1] &&
                seam->border[k] == tsi_seam_border(shell, s, 0) &&
                seam->border[1 - k] == tsi_seam_border(shell, s, 1);
  }
  return smooth;
}

static double domain_width(const tsi_shell *shell, const tsi_seam *s, int which) {
  const tsi_place *place = shell->place[s->row[which].patch];
  int across = 1 - s->row[which].along;
  const double *domain = shell->domain[place->facet] + 2 * (place->swap ? 1 - across : across);
  return domain[1] - domain[0];
}

/* ratio[i]: width of strip i + 1 to that of strip i where smooth seams ask for one; 0: they do not,
 * NaN: they disagree. */
static void find_width_ratios(const tsi_shell *shell, int n, const tsi_seam *list,
                              const tsolid_boundary_input *input, int axis, double *ratio) {
  for (int i = 0; i < n; i++) {
    const tsi_seam *s = &list[i];
    if (s->isoline >= 0 || !is_smooth(shell, s, input))
      continue;
    int along = s->row[0].along, at = s->row[0].patch - shell->first[s->side];
    int n_s = shell->n_strips[tsi_side_s(s->side)], strip = along ? at % n_s : at / n_s;
    if ((along ? tsi_side_s(s->side) : tsi_side_t(s->side)) != axis)
      continue;
    double own = domain_width(shell, s, 1) / domain_width(shell, s, 0);
    ratio[strip] = ratio[strip] == 0.0 || fabs(ratio[strip] / own - 1.0) <= 1e-9 ? own : NAN;
  }
}

/* Strips that smooth seams join share their length by the widths of their parameters. */
static void join_strips(int n, const double *ratio, double *width) {
  for (int first = 0, end; first < n; first = end) {
    double total = width[first], sum = 1.0, part = 1.0;
    for (end = first + 1; end < n && ratio[end - 1] > 0.0; end++) {
      total += width[end];
      part *= ratio[end - 1];
      sum += part;
    }
    if (end == first + 1)
      continue;
    part = 1.0;
    for (int i = first; i < end; i++) {
      width[i] = total * part / sum;
      part *= i + 1 < end ? ratio[i] : 1.0;
    }
  }
}

/* line[axis]: where strips begin and end in [0,1], by their mean length. */
static tsolid_status place_strips(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                  int n_seams, const tsi_seam *list,
                                  const tsolid_boundary_input *input) {
  for (int axis = 0; axis < 3; axis++) {
    int n = shell->n_strips[axis];
    double *line = tsi_arena_new(arena, (size_t)n + 1, sizeof *line);
    double *width = tsi_arena_new(arena, (size_t)n, sizeof *width);
    double *ratio = tsi_arena_new(arena, (size_t)n, sizeof *ratio);
    if (!line || !width || !ratio)
      return tsi_no_memory(context, stage);
    shell->line[axis] = line;
    for (int i = 0; i < n; i++)
      width[i] = n == 1 ? 1.0 : measure_strip(shell, arena, axis, i);
    find_width_ratios(shell, n_seams, list, input, axis, ratio);
    join_strips(n, ratio, width);
    for (int i = 0; i < n; i++)
      line[i + 1] = line[i] + width[i];
    double total = line[n];
    if (isnan(total))
      return tsi_no_memory(context, stage);
    for (int i = 1; i < n; i++) {
      line[i] = 1.0 - (1.0 - line[i] / total);
      if (!(line[i] > line[i - 1]) || !(line[i] < 1.0))
        return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                        "The faces of a side differ in length beyond all measure");
    }
    line[n] = 1.0;
  }
  return TSOLID_OK;
}

/* ---- the lattice of patches -------------------------------------------------------------------
 */

/* Consecutive numbers for the surface points: the bottom, the top, then the rings between. */
size_t tsi_lattice_id(const size_t n[3], const size_t x[3]) {
  size_t layer = n[0] * n[1], ring = 2 * (n[0] + n[1]) - 4, at;
  if (x[2] == 0)
    return x[0] + n[0] * x[1];
  if (x[2] == n[2] - 1)
    return layer + x[0] + n[0] * x[1];
  if (x[1] == 0)
    at = x[0];
  else if (x[1] == n[1] - 1)
    at = n[0] + x[0];
  else
    at = 2 * n[0] + (x[0] == 0 ? 0 : n[1] - 2) + x[1] - 1;
  return 2 * layer + (x[2] - 1) * ring + at;
}

double tsi_lattice_count(const size_t n[3]) {
  double x = (double)n[0], y = (double)n[1], z = (double)n[2];
  return 2.0 * x * y + (z - 2.0) * (2.0 * (x + y) - 4.0);
}

/* ---- elements of the patches ------------------------------------------------------------------
 */

/* The largest degree along an axis of all patches on the four sides that carry it. */
static int find_degree(const tsi_shell *shell, int axis) {
  int degree = 1;
  for (int side = 0; side < 6; side++) {
    if (tsi_side_axis(side) == axis)
      continue;
    int along = tsi_side_t(side) == axis;
    for (int p = shell->first[side]; p < shell->first[side + 1]; p++) {
      int own =
          shell->tspline[p].n ? shell->tspline[p].degree[along] : shell->elements[p].degree[along];
      degree = own > degree ? own : degree;
    }
  }
  return degree;
}

/* Coefficients raised to `degree`; all else is `from`'s own. */
static int raise_elements(tsi_arena *arena, const tsi_side *from, const int degree[2],
                          tsi_side *to) {
  int n0 = from->degree[0] + 1, n1 = from->degree[1] + 1, m0 = degree[0] + 1, m1 = degree[1] + 1;
  size_t n = (size_t)from->function_start[from->n_elements];
  double wide[TSI_MAX_ORDER * TSI_MAX_ORDER];
  *to = *from;
  if (n0 == m0 && n1 == m1)
    return 1;
  to->degree[0] = degree[0];
  to->degree[1] = degree[1];
  to->coefficient = tsi_arena_new(arena, n * (size_t)(m0 * m1), sizeof *to->coefficient);
  for (size_t k = 0; to->coefficient && k < n; k++) {
    const double *own = from->coefficient + k * (size_t)(n0 * n1);
    for (int j = 0; j < n1; j++)
      tsi_bernstein_raise(n0 - 1, degree[0], 1, own + j * n0, wide + j * m0);
    tsi_bernstein_raise(n1 - 1, degree[1], m0, wide, to->coefficient + k * (size_t)(m0 * m1));
  }
  return to->coefficient != NULL;
}

static tsolid_status build_elements(tsolid_context *context, tsi_arena *arena, tsi_shell *shell) {
  int axis_degree[3];
  for (int axis = 0; axis < 3; axis++)
    axis_degree[axis] = find_degree(shell, axis);
  for (int side = 0; side < 6; side++) {
    int degree[2] = {axis_degree[tsi_side_s(side)], axis_degree[tsi_side_t(side)]};
    for (int p = shell->first[side]; p < shell->first[side + 1]; p++) {
      char name[TSI_NAME_SIZE];
      const tsi_facet *facet = &shell->facet[shell->place[p]->facet];
      tsolid_status status = TSOLID_OK;
      if (shell->tspline[p].n)
        status = tsi_tspline_elements(context, arena, &shell->tspline[p], degree,
                                      tsi_name_facet(facet, name), &shell->elements[p]);
      else if (!raise_elements(arena, &shell->elements[p], degree, &shell->elements[p]))
        status = tsi_no_memory(context, stage);
      if (status)
        return status;
    }
  }
  return TSOLID_OK;
}

/* ---- functions --------------------------------------------------------------------------------
 */

int tsi_find_function(int *parent, int i) {
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}

void tsi_join_functions(int *parent, int a, int b) {
  a = tsi_find_function(parent, a);
  b = tsi_find_function(parent, b);
  if (a != b)
    parent[a > b ? a : b] = a > b ? b : a;
}

static int compare_points(const double a[4], const double b[4]) {
  for (int c = 0; c < 4; c++)
    if (a[c] != b[c])
      return a[c] < b[c] ? -1 : 1;
  return 0;
}

/* number[row of shell->control]: of the function, -1 where there is none. */
static tsolid_status number_functions(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                                      int *parent, int *number, tsi_draft *draft) {
  int n = 0;
  for (int i = 0; i < shell->n_control; i++)
    number[i] = -1;
  for (int p = 0; p < shell->first[6]; p++) {
    const tsi_side *e = &shell->elements[p];
    for (int k = 0; k < e->function_start[e->n_elements]; k++) {
      int root = tsi_find_function(parent, e->function[k]);
      if (number[root] < 0)
        number[root] = n++;
    }
  }
  if (n > TSI_MAX_COUNT / 16)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "The boundary has too many functions");
  draft->n_functions = n;
  draft->points = tsi_arena_new(arena, (size_t)n, 4 * sizeof *draft->points);
  if (!draft->points)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < shell->n_control; i++) { /* of several the least */
    const double *own = shell->control + 4 * (size_t)i;
    int root = tsi_find_function(parent, i);
    double *to = draft->points + 4 * (size_t)(number[root] >= 0 ? number[root] : 0);
    if (number[root] >= 0 && (root == i || compare_points(own, to) < 0))
      memcpy(to, own, 4 * sizeof *to);
  }
  for (int i = 0; i < shell->n_control; i++)
    number[i] = number[tsi_find_function(parent, i)];
  return TSOLID_OK;
}

/* ---- sides ------------------------------------------------------------------------------------
 */

typedef struct side_builder {
  const tsi_shell *shell;
  const int *number;
  int *entry_of; /* per function: entry on the element, 1 + entry */
  int side, n_elements, n_entries;
} side_builder;

static tsolid_status allocate_side(tsolid_context *context, tsi_arena *arena,
                                   const tsi_shell *shell, int number, tsi_side *side) {
  double n_elements = 0.0, n_entries = 0.0;
  for (int p = shell->first[number]; p < shell->first[number + 1]; p++) {
    const tsi_side *e = &shell->elements[p];
    side->degree[0] = e->degree[0];
    side->degree[1] = e->degree[1];
    n_elements += e->n_elements;
    n_entries += e->function_start[e->n_elements];
  }
  size_t width = (size_t)(side->degree[0] + 1) * (size_t)(side->degree[1] + 1);
  if (n_entries * (double)width > TSI_MAX_COUNT || n_elements > TSI_MAX_COUNT / 16)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "Side %d is too large", number);
  side->n_elements = (int)n_elements;
  side->grid[0] = shell->n_strips[tsi_side_s(number)];
  side->grid[1] = shell->n_strips[tsi_side_t(number)];
  side->box = tsi_arena_new(arena, (size_t)n_elements, 4 * sizeof *side->box);
  side->function_start = tsi_arena_new(arena, (size_t)n_elements + 1, sizeof *side->function_start);
  side->function = tsi_arena_new(arena, (size_t)n_entries, sizeof *side->function);
  side->coefficient = tsi_arena_new(arena, (size_t)n_entries * width, sizeof *side->coefficient);
  if (!side->box || !side->function_start || !side->function || !side->coefficient)
    return tsi_no_memory(context, stage);
  return TSOLID_OK;
}

/* The functions of one element; entries of one function add up. */
static void add_entries(side_builder *b, const tsi_side *from, int element, tsi_side *to) {
  size_t width = (size_t)(to->degree[0] + 1) * (size_t)(to->degree[1] + 1);
  int first = b->n_entries;
  for (int k = from->function_start[element]; k < from->function_start[element + 1]; k++) {
    const double *own = from->coefficient + (size_t)k * width;
    int f = b->number[from->function[k]], seen = b->entry_of[f];
    double *target = to->coefficient + (size_t)(seen ? seen - 1 : b->n_entries) * width;
    if (!seen) {
      to->function[b->n_entries++] = f;
      b->entry_of[f] = b->n_entries;
      memcpy(target, own, width * sizeof *own);
    }
    for (size_t i = 0; seen && i < width; i++)
      target[i] += own[i];
  }
  for (int k = first; k < b->n_entries; k++)
    b->entry_of[to->function[k]] = 0;
}

static tsolid_status add_patch(tsolid_context *context, side_builder *b, int p, tsi_side *to) {
  const tsi_side *from = &b->shell->elements[p];
  int s = tsi_side_s(b->side), t = tsi_side_t(b->side), at = p - b->shell->first[b->side];
  const double *line[2] = {b->shell->line[s] + at % b->shell->n_strips[s],
                           b->shell->line[t] + at / b->shell->n_strips[s]};
  for (int e = 0; e < from->n_elements; e++) {
    double *box = to->box + 4 * (size_t)b->n_elements;
    for (int k = 0; k < 4; k++) {
      const double *l = line[k / 2];
      double x = from->box[4 * (size_t)e + (size_t)k];
      box[k] = x == 1.0 ? l[1] : 1.0 - (1.0 - (l[0] + x * (l[1] - l[0])));
    } /* see tsi_knots_normalise */
    if (!(box[0] < box[1]) || !(box[2] < box[3]))
      return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                      "The knots of a face lie too close together to be told apart");
    add_entries(b, from, e, to);
    to->function_start[++b->n_elements] = b->n_entries;
  }
  return TSOLID_OK;
}

tsolid_status tsi_shell_draft(tsolid_context *context, tsi_arena *arena, tsi_shell *shell,
                              const tsolid_boundary_input *input, tsolid_preparation *preparation,
                              tsi_draft *draft) {
  int n_seams;
  tsi_seam *list = tsi_seams_list(arena, shell, &n_seams);
  int *parent = tsi_arena_new(arena, (size_t)shell->n_control, sizeof *parent);
  int *number = tsi_arena_new(arena, (size_t)shell->n_control, sizeof *number);
  int *entry_of = tsi_arena_new(arena, (size_t)shell->n_control, sizeof *entry_of);
  if (!list || !parent || !number || !entry_of)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < shell->n_control; i++)
    parent[i] = i;
  tsolid_status status = build_elements(context, arena, shell);
  if (!status)
    status = place_strips(context, arena, shell, n_seams, list, input);
  for (int i = 0; !status && i < n_seams; i++) {
    tsi_row row[2] = {tsi_seam_row(shell, &list[i], 0), tsi_seam_row(shell, &list[i], 1)};
    for (int m = 0; row[0].n && m < row[1].n; m++)
      tsi_join_functions(parent, row[0].at[m], row[1].at[m]);
  }
  if (!status)
    status = tsi_shell_match_functions(context, arena, shell, parent, preparation);
  if (!status && input->n_smooth)
    status = tsi_shell_check_smooth(context, arena, shell, input, parent);
  if (!status)
    status = number_functions(context, arena, shell, parent, number, draft);
  for (int side = 0; !status && side < 6; side++) {
    side_builder b = {shell, number, entry_of, side, 0, 0};
    status = allocate_side(context, arena, shell, side, &draft->side[side]);
    for (int p = shell->first[side]; !status && p < shell->first[side + 1]; p++)
      status = add_patch(context, &b, p, &draft->side[side]);
  }
  return status;
}
