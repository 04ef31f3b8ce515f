/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The loop of the four borders is proved not to meet itself.
 *
 * A map of the square with det J > 0 that is one-to-one on the border is one-to-one (its degree
 * over a point is the border's winding number, 0 or 1). Without this a patch may lie twice over a
 * part of the plane and be positive everywhere.
 *
 * The borders are cut into rational Bezier pieces, in the order of the loop. With positive weights
 * a piece lies in the box of its control points, and its tangents are positive combinations of the
 * legs of its control polygon. So
 *
 *     two pieces do not meet when their boxes are apart;
 *     a piece, or two that follow each other, are one simple arc when all legs have a positive
 *     product with one direction.
 *
 * What is neither is bisected. A meeting is what is left where the pieces are as small as
 * round-off.
 *
 * Source: as usual for curve intersection by subdivision (G. Farin, Curves and Surfaces for CAGD,
 * 2002, chapter 13); the criterion for neighbours is ours. */
#include <stdlib.h>

#include "bspline.h"
#include "coons.h"

enum { MAX_DEPTH = 90 };

/* Boxes nearer than this part of the face are not apart; pieces as small are not cut further. */
static const double resolution = 1e-13;
static const double MAX_TESTS = 2e6;

typedef struct piece {
  int degree, border, order;  /* order: in the loop */
  double h[TSI_MAX_ORDER][3]; /* (w x, w y, w) */
  double low[2], high[2];
} piece;

typedef struct loop {
  tsi_coons_work *work;
  piece *piece;
  int n;
  double margin, tests;
  int met[2];      /* borders */
  double place[2]; /* where they meet */
  int open;        /* 1: not decided there */
} loop;

/* ---- pieces ------------------------------------------------------------------------------------
 */

static void find_box(piece *p) {
  for (int d = 0; d < 2; d++) {
    p->low[d] = INFINITY;
    p->high[d] = -INFINITY;
    for (int i = 0; i <= p->degree; i++) {
      double x = p->h[i][d] / p->h[i][2];
      p->low[d] = fmin(p->low[d], x);
      p->high[d] = fmax(p->high[d], x);
    }
  }
}

static void bisect(const piece *p, piece half[2]) {
  half[0] = half[1] = *p;
  double(*right)[3] = half[1].h;
  for (int r = 1; r <= p->degree; r++) {
    for (int i = 0; i <= p->degree - r; i++)
      for (int c = 0; c < 3; c++)
        right[i][c] = 0.5 * (right[i][c] + right[i + 1][c]);
    memcpy(half[0].h[r], right[0], sizeof right[0]);
  }
  find_box(&half[0]);
  find_box(&half[1]);
}

static int are_apart(const loop *l, const piece *a, const piece *b) {
  for (int d = 0; d < 2; d++)
    if (a->low[d] > b->high[d] + l->margin || b->low[d] > a->high[d] + l->margin)
      return 1;
  return 0;
}

static double extent(const piece *p) {
  return fmax(p->high[0] - p->low[0], p->high[1] - p->low[1]);
}

/* Unit leg i; 0: none. */
static int find_leg(const piece *p, int i, double leg[2]) {
  for (int c = 0; c < 2; c++)
    leg[c] = p->h[i + 1][c] / p->h[i + 1][2] - p->h[i][c] / p->h[i][2];
  double length = hypot(leg[0], leg[1]);
  if (!(length > 0.0))
    return 0;
  leg[0] /= length;
  leg[1] /= length;
  return 1;
}

/* Whether all legs of both (b may be NULL) lie on one side. */
static int is_one_arc(const piece *a, const piece *b) {
  const piece *both[2] = {a, b};
  double sum[2] = {0.0, 0.0}, leg[2];
  for (int k = 0; k < 2 && both[k]; k++)
    for (int i = 0; i < both[k]->degree; i++)
      if (find_leg(both[k], i, leg)) {
        sum[0] += leg[0];
        sum[1] += leg[1];
      }
  double length = hypot(sum[0], sum[1]);
  for (int k = 0; k < 2 && both[k]; k++)
    for (int i = 0; i < both[k]->degree; i++)
      if (find_leg(both[k], i, leg) && !(leg[0] * sum[0] + leg[1] * sum[1] > 1e-10 * length))
        return 0;
  return length > 0.0;
}

/* ---- tests -------------------------------------------------------------------------------------
 */

static int note_meeting(loop *l, const piece *a, const piece *b, int open) {
  l->met[0] = a->border < b->border ? a->border : b->border;
  l->met[1] = a->border < b->border ? b->border : a->border;
  l->open = open;
  for (int d = 0; d < 2; d++)
    l->place[d] = 0.5 * (fmax(a->low[d], b->low[d]) + fmin(a->high[d], b->high[d]));
  return 0;
}

/* 1: they do not meet, but where b begins at the end of a when it `follows`. */
static int test_pair(loop *l, const piece *a, const piece *b, int follows, int depth) {
  if (are_apart(l, a, b) || (follows && is_one_arc(a, b)))
    return 1;
  l->tests += 1.0;
  int small = extent(a) <= l->margin && extent(b) <= l->margin;
  if (small || depth >= MAX_DEPTH || l->tests > MAX_TESTS)
    return follows && small ? 1 : note_meeting(l, a, b, !small);
  piece half[2];
  if (extent(a) >= extent(b)) {
    bisect(a, half);
    return test_pair(l, &half[0], b, 0, depth + 1) && test_pair(l, &half[1], b, follows, depth + 1);
  }
  bisect(b, half);
  return test_pair(l, a, &half[0], follows, depth + 1) && test_pair(l, a, &half[1], 0, depth + 1);
}

static int test_piece(loop *l, const piece *a, int depth) {
  if (is_one_arc(a, NULL))
    return 1;
  l->tests += 1.0;
  if (extent(a) <= l->margin)
    return 1;
  if (depth >= MAX_DEPTH || l->tests > MAX_TESTS)
    return note_meeting(l, a, a, 1);
  piece half[2];
  bisect(a, half);
  return test_piece(l, &half[0], depth + 1) && test_piece(l, &half[1], depth + 1) &&
         test_pair(l, &half[0], &half[1], 1, depth + 1);
}

/* ---- the loop ----------------------------------------------------------------------------------
 */

static int count_spans(const tsi_patch *c) {
  int count = 0;
  for (int s = c->degree[0]; s < c->n[0]; s++)
    count += c->knots[0][s] < c->knots[0][s + 1];
  return count;
}

/* Bezier pieces of one border, reversed where the loop runs against it. */
static int cut_border(tsi_arena *arena, const tsi_coons_work *w, int k, piece *to, int first) {
  const tsi_patch *c = &w->border[k].curve;
  int p = c->degree[0], n_spans = count_spans(c), n_to = n_spans * p + 1, count = 0;
  double *h = tsi_arena_new(arena, (size_t)n_to, 3 * sizeof *h);
  double *knots = tsi_arena_new(arena, (size_t)(n_to + p + 1), sizeof *knots);
  if (!h || !knots)
    return 0;
  for (int i = 0; i < c->n[0] + p + 1; i++) {
    double x = c->knots[0][i];
    if (i == 0 || x > c->knots[0][i - 1])
      for (int m = 0; m < p + (x == 0.0 || x == 1.0); m++)
        knots[count++] = x;
  }
  for (int i = 0; i < c->n[0]; i++) {
    double flat[2], weight = c->control[4 * i + 3];
    tsi_frame_flatten(&w->frame, w->border[k].point + 3 * (ptrdiff_t)i, flat);
    h[3 * i] = weight * flat[0];
    h[3 * i + 1] = weight * flat[1];
    h[3 * i + 2] = weight;
  }
  tsi_bspline_insert(p, c->n[0], c->knots[0], n_to, knots, 3, h);
  for (int s = 0; s < n_spans; s++) {
    int back = k >= 2;
    piece *at = &to[back ? n_spans - 1 - s : s];
    at->degree = p;
    at->border = k;
    at->order = first + (back ? n_spans - 1 - s : s);
    for (int i = 0; i <= p; i++)
      memcpy(at->h[back ? p - i : i], h + 3 * (ptrdiff_t)(s * p + i), sizeof at->h[i]);
    find_box(at);
  }
  return 1;
}

static int compare_low(const void *a, const void *b) {
  const piece *p = *(const piece *const *)a, *q = *(const piece *const *)b;
  if (p->low[0] != q->low[0])
    return p->low[0] < q->low[0] ? -1 : 1;
  return (p->order > q->order) - (p->order < q->order);
}

/* All pairs whose boxes overlap along the first axis, by a sweep. */
static int test_loop(loop *l, const piece **sorted) {
  for (int i = 0; i < l->n; i++)
    sorted[i] = &l->piece[i];
  qsort(sorted, (size_t)l->n, sizeof *sorted, compare_low);
  for (int i = 0; i < l->n; i++)
    if (!test_piece(l, &l->piece[i], 0))
      return 0;
  for (int i = 0; i < l->n; i++)
    for (int j = i + 1; j < l->n && sorted[j]->low[0] <= sorted[i]->high[0] + l->margin; j++) {
      const piece *a = sorted[i], *b = sorted[j];
      int follows = (a->order + 1) % l->n == b->order, leads = (b->order + 1) % l->n == a->order;
      if (!(leads ? test_pair(l, b, a, 1, 0) : test_pair(l, a, b, follows, 0)))
        return 0;
    }
  return 1;
}

static tsolid_status refuse_meeting(const loop *l) {
  tsi_coons_work *w = l->work;
  double x[3];
  tsi_frame_place(&w->frame, l->place, x);
  tsolid_finding finding = tsi_coons_finding(x);
  const char *a = w->border[l->met[0]].name, *b = w->border[l->met[1]].name;
  if (l->open)
    return tsi_report(w->context, &finding,
                      "%s cannot be proved to have a border that does not meet itself: %s and %s "
                      "are close near (%.6g, %.6g, %.6g)",
                      w->name, a, b, x[0], x[1], x[2]);
  if (l->met[0] == l->met[1])
    return tsi_report(w->context, &finding, "%s of %s meets itself near (%.6g, %.6g, %.6g)", a,
                      w->name, x[0], x[1], x[2]);
  return tsi_report(w->context, &finding, "%s and %s of %s cross or touch near (%.6g, %.6g, %.6g)",
                    a, b, w->name, x[0], x[1], x[2]);
}

tsolid_status tsi_coons_check_loop(tsi_coons_work *w) {
  tsi_arena arena = tsi_arena_create(w->context);
  loop l = {.work = w, .margin = resolution * w->frame.size};
  int first[5] = {0};
  for (int k = 0; k < 4; k++)
    first[k + 1] = first[k] + count_spans(&w->border[k].curve);
  l.n = first[4];
  l.piece = tsi_arena_new(&arena, (size_t)l.n, sizeof *l.piece);
  const piece **sorted = tsi_arena_new(&arena, (size_t)l.n, sizeof *sorted);
  int ok = l.piece && sorted;
  /* in the order of the loop: v low, u high, then v high and u low backwards */
  for (int k = 0; ok && k < 4; k++)
    ok = cut_border(&arena, w, k, l.piece + first[k], first[k]);
  tsolid_status status = TSOLID_OK;
  if (!ok)
    status = tsi_no_memory(w->context, TSI_COONS_STAGE);
  else if (!test_loop(&l, sorted))
    status = refuse_meeting(&l);
  tsi_arena_free(&arena);
  return status;
}
