/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The slow checker of Bezier sides: for untrusted files, for input that comes as Bezier elements,
 * and for the tests. */
#include <stdio.h>
#include <stdlib.h>

#include "bernstein.h"
#include "boundary.h"

static const char stage[] = "boundary";

static const double coefficient_agreement = 1e-12;
/* Inside a side a jump of this size is a tear, not the round-off of a file. */
static const double tear = 1e-9;
static const double largest_coordinate = 1e120, largest_weight = 1e60;

static tsolid_finding side_finding(tsolid_entity entity, int a, int b) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
  finding.entity = entity;
  finding.index[0] = a;
  finding.index[1] = b;
  return finding;
}

/* ---- points -----------------------------------------------------------------------------------
 */

tsolid_status tsi_points_check(tsolid_context *context, int n, const double *points) {
  if (n < 1 || n > TSI_MAX_COUNT / 16 || !points)
    return tsi_fail(context, TSOLID_ERROR_INPUT, stage, "A boundary of %d functions is none", n);
  for (int i = 0; i < n; i++) {
    const double *h = points + 4 * (size_t)i;
    tsolid_finding finding = side_finding(TSOLID_ENTITY_FUNCTION, i, 0);
    for (int c = 0; c < 3; c++)
      if (!(fabs(h[c]) <= largest_coordinate))
        return tsi_report(context, &finding, "Control point %d is not finite or too large", i);
    finding.measured = h[3];
    finding.allowed = 0.0;
    if (!(h[3] > 0.0) || !(h[3] <= largest_weight) || !(h[3] >= 1.0 / largest_weight))
      return tsi_report(context, &finding,
                        "The weight of control point %d is %g, it must be positive and finite", i,
                        h[3]);
  }
  return TSOLID_OK;
}

/* ---- elements ---------------------------------------------------------------------------------
 */

static tsolid_status check_sizes(tsolid_context *context, const tsi_side_label *of, int n_functions,
                                 const tsi_side *side) {
  tsolid_finding finding = side_finding(of->entity, of->index, 0);
  for (int d = 0; d < 2; d++)
    if (side->degree[d] < 1 || side->degree[d] > TSI_MAX_DEGREE)
      return tsi_report(context, &finding, "%s has degree %d, not one of 1 to %d", of->text,
                        side->degree[d], (int)TSI_MAX_DEGREE);
  if (side->n_elements < 1 || side->n_elements > TSI_MAX_COUNT / 16)
    return tsi_report(context, &finding, "%s has %d elements", of->text, side->n_elements);
  if (!side->box || !side->function_start || !side->function || !side->coefficient)
    return tsi_report(context, &finding, "%s has no boxes, functions or coefficients", of->text);
  double width = (side->degree[0] + 1.0) * (side->degree[1] + 1.0);
  if (side->function_start[0] != 0)
    return tsi_report(context, &finding, "The functions of %s do not start at 0", of->text);
  for (int e = 0; e < side->n_elements; e++) {
    int first = side->function_start[e], end = side->function_start[e + 1];
    if (end <= first || end - first > n_functions || end * width > TSI_MAX_COUNT)
      return tsi_report(context, &finding,
                        "Element %d of %s has functions %d to %d, which cannot be", e, of->text,
                        first, end);
  }
  return TSOLID_OK;
}

/* last_use[f] = the element, numbered through all sides from 1, that named f last. */
static tsolid_status check_functions(tsolid_context *context, const tsi_side_label *of,
                                     int n_functions, const tsi_side *side, int first_element,
                                     int *last_use) {
  size_t width = (size_t)(side->degree[0] + 1) * (size_t)(side->degree[1] + 1);
  for (int e = 0; e < side->n_elements; e++) {
    tsolid_finding finding = side_finding(TSOLID_ENTITY_ELEMENT, of->index, e);
    int first = side->function_start[e], end = side->function_start[e + 1];
    for (int k = first; k < end; k++) {
      int f = side->function[k];
      if (f < 0 || f >= n_functions)
        return tsi_report(context, &finding, "Element %d of %s names function %d of %d", e,
                          of->text, f, n_functions);
      if (last_use[f] == first_element + e)
        return tsi_report(context, &finding, "Element %d of %s names function %d twice", e,
                          of->text, f);
      last_use[f] = first_element + e;
    }
    for (size_t i = 0; i < width; i++) {
      double sum = 0.0;
      for (int k = first; k < end; k++) {
        double c = side->coefficient[(size_t)k * width + i];
        if (!(c >= 0.0) || !(c <= 1e6))
          return tsi_report(context, &finding,
                            "Function %d has the coefficient %g on element %d of %s; they "
                            "must not be negative",
                            side->function[k], c, e, of->text);
        sum += c;
      }
      if (!(sum > 1e-6))
        return tsi_report(context, &finding, "All functions vanish in a part of element %d of %s",
                          e, of->text);
    }
  }
  return TSOLID_OK;
}

typedef struct box_corner {
  double s, t;
  int sign;
} box_corner;

static int compare_box_corners(const void *a, const void *b) {
  const box_corner *p = a, *q = b;
  if (p->s != q->s)
    return p->s < q->s ? -1 : 1;
  return (p->t > q->t) - (p->t < q->t);
}

/* Boxes tile the unit square when the mixed difference of their cover count, +1 and -1 at their
 * corners, cancels everywhere but at the corners of the square: exact, no epsilon. */
static tsolid_status check_tiling(tsolid_context *context, tsi_arena *arena,
                                  const tsi_side_label *of, const tsi_side *side) {
  size_t n = 4 * (size_t)side->n_elements;
  box_corner *corner = tsi_arena_new(arena, n, sizeof *corner);
  if (!corner)
    return tsi_no_memory(context, stage);
  for (int e = 0; e < side->n_elements; e++) {
    const double *box = side->box + 4 * (size_t)e;
    tsolid_finding finding = side_finding(TSOLID_ENTITY_ELEMENT, of->index, e);
    for (int d = 0; d < 2; d++)
      if (!(0.0 <= box[2 * d] && box[2 * d] < box[2 * d + 1] && box[2 * d + 1] <= 1.0))
        return tsi_report(context, &finding, "Element %d of %s is no box inside the unit square", e,
                          of->text);
    for (int k = 0; k < 4; k++)
      corner[4 * e + k] = (box_corner){box[k & 1], box[2 + (k >> 1)], (k == 0 || k == 3) ? 1 : -1};
  }
  qsort(corner, n, sizeof *corner, compare_box_corners);
  for (size_t first = 0, end; first < n; first = end) {
    double s = corner[first].s, t = corner[first].t;
    int sum = 0, is_corner = (s == 0.0 || s == 1.0) && (t == 0.0 || t == 1.0);
    for (end = first; end < n && corner[end].s == s && corner[end].t == t; end++)
      sum += corner[end].sign;
    if (sum == (is_corner ? (s == t ? 1 : -1) : 0))
      continue;
    tsolid_finding finding = side_finding(of->entity, of->index, 0);
    return tsi_report(context, &finding,
                      "The elements of %s do not tile the unit square: gap or overlap at "
                      "(%.17g, %.17g)",
                      of->text, s, t);
  }
  return TSOLID_OK;
}

tsolid_status tsi_side_check(tsolid_context *context, tsi_arena *arena, const tsi_side_label *of,
                             int n_functions, const tsi_side *side, int first_element,
                             int *last_use) {
  tsolid_status status = check_sizes(context, of, n_functions, side);
  if (!status)
    status = check_functions(context, of, n_functions, side, first_element, last_use);
  if (!status)
    status = check_tiling(context, arena, of, side);
  return status;
}

/* ---- isolines ---------------------------------------------------------------------------------
 */

/* The elements of a side along one of its borders, sorted; see list_border. */
typedef struct border_piece {
  double low, high;
  int element;
} border_piece;

typedef struct border {
  const tsi_side *side;
  int number, along, end, n;
  border_piece *piece;
} border;

static int compare_pieces(const void *a, const void *b) {
  const border_piece *p = a, *q = b;
  return (p->low > q->low) - (p->low < q->low);
}

static int list_border(tsi_arena *arena, border *b) {
  b->n = 0;
  b->piece = tsi_arena_new(arena, (size_t)b->side->n_elements, sizeof *b->piece);
  if (!b->piece)
    return 0;
  for (int e = 0; e < b->side->n_elements; e++) {
    const double *box = b->side->box + 4 * (size_t)e;
    if (box[2 * (1 - b->along) + b->end] == (double)b->end)
      b->piece[b->n++] = (border_piece){box[2 * b->along], box[2 * b->along + 1], e};
  }
  qsort(b->piece, (size_t)b->n, sizeof *b->piece, compare_pieces);
  return 1;
}

/* Coefficients of entry k on the border, restricted to [low, high], at `degree`. */
static void border_row(const border *b, const border_piece *piece, int k, double low, double high,
                       int degree, double *row) {
  const tsi_side *side = b->side;
  size_t n0 = (size_t)side->degree[0] + 1, n1 = (size_t)side->degree[1] + 1;
  size_t step = b->along ? n0 : 1, fixed = 0;
  if (b->end)
    fixed = b->along ? n0 - 1 : n0 * (n1 - 1);
  double own[TSI_MAX_ORDER];
  int p = side->degree[b->along];
  for (int i = 0; i <= p; i++)
    own[i] = side->coefficient[(size_t)k * n0 * n1 + fixed + step * (size_t)i];
  double width = piece->high - piece->low;
  tsi_bernstein_restrict(p, (low - piece->low) / width,
                         high == piece->high ? 1.0 : (high - piece->low) / width, own, 1);
  tsi_bernstein_raise(p, degree, 1, own, row);
}

static double row_difference(int degree, const double *a, const double *b) {
  double largest = 0.0;
  for (int i = 0; i <= degree; i++)
    largest = fmax(largest, fabs(a[i] - (b ? b[i] : 0.0)));
  return largest;
}

/* Largest difference of two sides' functions on one interval. entry[f]: 1 + entry of f in a. */
static double compare_interval(const border b[2], const border_piece *piece[2], int *entry) {
  double low = fmax(piece[0]->low, piece[1]->low), high = fmin(piece[0]->high, piece[1]->high);
  double row[2][TSI_MAX_ORDER], largest = 0.0;
  int degree = b[0].side->degree[b[0].along], other = b[1].side->degree[b[1].along];
  degree = other > degree ? other : degree;
  const int *start[2] = {b[0].side->function_start + piece[0]->element,
                         b[1].side->function_start + piece[1]->element};
  for (int k = start[0][0]; k < start[0][1]; k++)
    entry[b[0].side->function[k]] = k + 1;
  for (int k = start[1][0]; k < start[1][1]; k++) {
    int *found = &entry[b[1].side->function[k]];
    border_row(&b[1], piece[1], k, low, high, degree, row[1]);
    if (*found)
      border_row(&b[0], piece[0], *found - 1, low, high, degree, row[0]);
    largest = fmax(largest, row_difference(degree, row[1], *found ? row[0] : NULL));
    *found = 0;
  }
  for (int k = start[0][0]; k < start[0][1]; k++) /* what the other side does not know */
    if (entry[b[0].side->function[k]]) {
      entry[b[0].side->function[k]] = 0;
      border_row(&b[0], piece[0], k, low, high, degree, row[0]);
      largest = fmax(largest, row_difference(degree, row[0], NULL));
    }
  return largest;
}

/* An edge of an element on a line of one parameter. */
typedef struct inner_edge {
  double line;
  border_piece piece;
} inner_edge;

static int compare_edges(const void *a, const void *b) {
  const inner_edge *p = a, *q = b;
  if (p->line != q->line)
    return p->line < q->line ? -1 : 1;
  return (p->piece.low > q->piece.low) - (p->piece.low < q->piece.low);
}

static tsolid_status refuse_tear(tsolid_context *context, const tsi_side_label *of, int d,
                                 const inner_edge *edge, double difference) {
  tsolid_finding finding = side_finding(of->entity, of->index, 0);
  double along = 0.5 * (edge->piece.low + edge->piece.high);
  finding.measured = difference;
  finding.allowed = tear;
  return tsi_report(context, &finding,
                    "The functions of %s jump by %.3g between elements near (%.6g, %.6g): the "
                    "surface is torn there",
                    of->text, difference, d ? along : edge->line, d ? edge->line : along);
}

/* All functions are continuous from element to element across lines of constant parameter d. */
static tsolid_status check_lines(tsolid_context *context, tsi_arena *arena,
                                 const tsi_side_label *of, const tsi_side *side, int d,
                                 int *entry) {
  size_t n = (size_t)side->n_elements;
  border b[2] = {{.side = side, .along = 1 - d, .end = 1}, {.side = side, .along = 1 - d}};
  inner_edge *edge[2];
  for (int k = 0; k < 2; k++) {
    edge[k] = tsi_arena_new(arena, n, sizeof *edge[k]);
    if (!edge[k])
      return tsi_no_memory(context, stage);
    for (size_t e = 0; e < n; e++) {
      const double *box = side->box + 4 * e;
      edge[k][e] =
          (inner_edge){box[2 * d + (k ? 0 : 1)], {box[2 * (1 - d)], box[2 * (1 - d) + 1], (int)e}};
    }
    qsort(edge[k], n, sizeof *edge[k], compare_edges);
  }
  for (size_t i = 0, j = 0; i < n && j < n;) {
    const inner_edge *p = &edge[0][i], *q = &edge[1][j];
    if (p->line != q->line || p->piece.high <= q->piece.low || q->piece.high <= p->piece.low) {
      int first = p->line != q->line ? p->line < q->line : p->piece.high <= q->piece.low;
      if (first)
        i++;
      else
        j++;
      continue;
    }
    const border_piece *piece[2] = {&p->piece, &q->piece};
    double difference = compare_interval(b, piece, entry);
    if (!(difference <= tear))
      return refuse_tear(context, of, d, p, difference);
    double ends[2] = {piece[0]->high, piece[1]->high};
    if (ends[0] <= ends[1])
      i++;
    if (ends[1] <= ends[0])
      j++;
  }
  return TSOLID_OK;
}

tsolid_status tsi_side_check_tears(tsolid_context *context, tsi_arena *arena,
                                   const tsi_side_label *of, const tsi_side *side, int *entry) {
  tsolid_status status = check_lines(context, arena, of, side, 0, entry);
  return status ? status : check_lines(context, arena, of, side, 1, entry);
}

static tsolid_status check_isoline(tsolid_context *context, tsi_arena *arena, int isoline,
                                   const tsi_side side[6], int *entry) {
  int axis = isoline / 4, end[2] = {isoline & 1, isoline >> 1 & 1};
  int other[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
  border b[2];
  for (int k = 0; k < 2; k++) {
    int number = 2 * other[k] + end[k];
    b[k] = (border){&side[number], number, tsi_side_t(number) == axis, end[1 - k], 0, NULL};
    if (!list_border(arena, &b[k]))
      return tsi_no_memory(context, stage);
  }
  for (int i = 0, j = 0; i < b[0].n && j < b[1].n;) {
    const border_piece *piece[2] = {&b[0].piece[i], &b[1].piece[j]};
    double difference = compare_interval(b, piece, entry);
    if (!(difference <= coefficient_agreement)) {
      tsolid_finding finding = side_finding(TSOLID_ENTITY_ISOLINE, isoline, 0);
      finding.measured = difference;
      finding.allowed = coefficient_agreement;
      return tsi_report(context, &finding,
                        "Sides %d and %d have different functions on isoline %d between %.6g and "
                        "%.6g: coefficients differ by %.3g",
                        b[0].number, b[1].number, isoline, fmax(piece[0]->low, piece[1]->low),
                        fmin(piece[0]->high, piece[1]->high), difference);
    }
    i += piece[0]->high <= piece[1]->high;
    j += piece[1]->high <= piece[0]->high;
  }
  return TSOLID_OK;
}

/* ---- the driver --------------------------------------------------------------------------------
 */

tsolid_status tsi_sides_check(tsolid_context *context, int n_functions, const double *points,
                              const tsi_side side[6], int with_isolines) {
  tsi_arena arena = tsi_arena_create(context);
  int *mark = NULL, first_element = 1;
  tsolid_status status = TSOLID_OK;
  if (n_functions < 8)
    status = tsi_fail(context, TSOLID_ERROR_INPUT, stage, "A boundary of %d functions is none",
                      n_functions);
  if (!status)
    status = tsi_points_check(context, n_functions, points);
  if (status)
    goto done;
  mark = tsi_arena_new(&arena, (size_t)n_functions, sizeof *mark);
  if (!mark) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  for (int i = 0; i < 6; i++) {
    tsi_side_label label = {.entity = TSOLID_ENTITY_SIDE, .index = i};
    snprintf(label.text, sizeof label.text, "side %d", i);
    status = tsi_side_check(context, &arena, &label, n_functions, &side[i], first_element, mark);
    if (status)
      goto done;
    first_element += side[i].n_elements;
  }
  for (int i = 0; i < n_functions; i++)
    if (!mark[i]) {
      tsolid_finding finding = side_finding(TSOLID_ENTITY_FUNCTION, i, 0);
      status = tsi_report(context, &finding, "Function %d is on no element", i);
      goto done;
    }
  memset(mark, 0, (size_t)n_functions * sizeof *mark);
  for (int i = 0; !status && i < 6; i++) {
    tsi_side_label label = {.entity = TSOLID_ENTITY_SIDE, .index = i};
    snprintf(label.text, sizeof label.text, "side %d", i);
    status = tsi_side_check_tears(context, &arena, &label, &side[i], mark);
  }
  for (int i = 0; with_isolines && !status && i < 12; i++)
    status = check_isoline(context, &arena, i, side, mark);
done:
  tsi_arena_free(&arena);
  return status;
}

tsolid_status tsi_boundary_validate(tsolid_context *context, const tsolid_boundary *boundary) {
  return tsi_sides_check(context, boundary->n_functions, boundary->points, boundary->side, 1);
}
