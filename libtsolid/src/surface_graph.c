/* SPDX-License-Identifier: LGPL-2.1-or-later
 * From Bezier elements to a T-mesh, by the functions on them alone.
 *
 * Vertices: corners where all functions have the same values are one. Edges: two sides of elements
 * that leave a vertex together carry the same functions; where one is longer,
 *
 *       long side    o-----------------------o
 *       short sides  o--------o--------------o      row_short(x) = row_long(lambda x)
 *
 * lambda is the ratio of the rows' first derivatives at the vertex, and the end of the short side
 * is a T-junction of the long one's element.
 *
 * Knot intervals: along a common edge both elements have the same length. Across it a function
 * that is C^1 there has D_left / h_left = -D_right / h_right, D the derivatives away from the edge
 * in the elements' own [0,1]: the ratio of h, where all functions agree on one. */
#include <stdlib.h>

#include "bernstein.h"
#include "surface_graph.h"

static const char stage[] = "surface";

/* Coefficients are printed with 15 to 17 digits after some arithmetic of the file's author. */
static const double same_coefficient = 1e-9;
/* Derivatives of functions that are C^1 agree so well, relative to the largest. */
static const double same_derivative = 1e-8;
static const double same_ratio = 1e-6;
static const double shortest_part = 1e-6;

enum { MAX_MEETING = 64, N_ROUNDED_BITS = 40 };

/* A part of an element's side b, which runs counter-clockwise from corner b to corner b+1
 * (corners 00, 10, 11, 01); low, high in the side's own [0,1] in that direction. */
typedef struct segment {
  int element, side;
  double low, high;
  int vertex[2];
  int partner; /* -1: none */
  int along;   /* 1: the partner has the same direction, so one of the elements is mirrored */
  int next;    /* part of the same side, -1: last */
  int link;
} segment;

/* An end of a segment without partner, in a list per vertex. */
typedef struct open_end {
  int segment, end, next;
} open_end;

typedef struct graph {
  tsolid_context *context;
  tsi_arena *arena;
  tsolid_surface *surface;
  int *vertex; /* per corner 4e + c */
  segment *segment;
  int n_segments;
  int *first_open; /* per vertex */
  open_end *open;
  int n_open;
  int *n_meeting;         /* ends per vertex at the start */
  int *queue, *is_queued; /* vertices where segments may find partners */
  size_t n_queue, queue_first, queue_room;
  int *mirrored;  /* per element: 1 + mirrored, 0: not reached */
  double *row[2]; /* functions of two elements along an edge */
} graph;

static double round_ratio(double x) {
  double unit = ldexp(1.0, N_ROUNDED_BITS);
  return x > 1.0 / 1024.0 && x < 1024.0 ? floor(x * unit + 0.5) / unit : x;
}

static size_t net_size(const tsolid_surface *s) {
  return (size_t)(s->degree + 1) * (size_t)(s->degree + 1);
}

static tsolid_finding element_finding(const graph *g, int element) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = TSOLID_ENTITY_ELEMENT;
  finding.index[0] = g->surface->face_record ? g->surface->face_record[element] : element;
  return finding;
}

/* ---- corners become vertices ------------------------------------------------------------------
 */

static size_t corner_index(const tsolid_surface *s, int corner) {
  size_t p = (size_t)s->degree;
  return (corner == 1 || corner == 2 ? p : 0) + (corner >= 2 ? p * (p + 1) : 0);
}

static double corner_value(const tsolid_surface *s, int k, int corner) {
  return s->coefficient[(size_t)k * net_size(s) + corner_index(s, corner)];
}

static int count_functions(const tsolid_surface *s, int element) {
  return s->function_start[element + 1] - s->function_start[element];
}

static int same_corners(const tsolid_surface *s, int a, int b) {
  int i = s->function_start[a / 4], end_i = s->function_start[a / 4 + 1];
  int j = s->function_start[b / 4], end_j = s->function_start[b / 4 + 1];
  while (i < end_i || j < end_j) {
    int take_i = j == end_j || (i < end_i && s->function[i] <= s->function[j]);
    int take_j = i == end_i || (j < end_j && s->function[j] <= s->function[i]);
    double x = take_i ? corner_value(s, i, a % 4) : 0.0,
           y = take_j ? corner_value(s, j, b % 4) : 0.0;
    if (!(fabs(x - y) <= same_coefficient))
      return 0;
    i += take_i;
    j += take_j;
  }
  return 1;
}

/* A number in [-1, 1] for a function: corners with the same functions have nearly the same sum. */
static double hash_function(int function) {
  uint64_t x = (uint64_t)function + 0x9e3779b97f4a7c15u;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  x ^= x >> 31;
  return (double)(x >> 11) * 0x1p-52 - 1.0;
}

typedef struct corner_key {
  double sum;
  int corner;
} corner_key;

static int compare_keys(const void *a, const void *b) {
  const corner_key *p = a, *q = b;
  if (p->sum != q->sum)
    return p->sum < q->sum ? -1 : 1;
  return (p->corner > q->corner) - (p->corner < q->corner);
}

static tsolid_status glue_corners(graph *g) {
  const tsolid_surface *s = g->surface;
  const double window = 1e-7;
  size_t n = 4 * (size_t)s->n_faces, n_kept = 0, work = 0;
  size_t n_entries = (size_t)s->function_start[s->n_faces];
  corner_key *key = tsi_arena_new(g->arena, n, sizeof *key);
  corner_key *kept = tsi_arena_new(g->arena, n, sizeof *kept);
  g->vertex = tsi_arena_new(g->arena, n, sizeof *g->vertex);
  if (!key || !kept || !g->vertex)
    return tsi_no_memory(g->context, stage);
  for (size_t c = 0; c < n; c++) {
    key[c].corner = (int)c;
    for (int k = s->function_start[c / 4]; k < s->function_start[c / 4 + 1]; k++)
      key[c].sum += hash_function(s->function[k]) * corner_value(s, k, (int)c % 4);
  }
  qsort(key, n, sizeof *key, compare_keys);
  for (size_t i = 0; i < n; i++) {
    int corner = key[i].corner, found = -1;
    for (size_t j = n_kept; j-- > 0 && key[i].sum - kept[j].sum <= window && found < 0;) {
      work += (size_t)(count_functions(s, corner / 4) + count_functions(s, kept[j].corner / 4));
      if (same_corners(s, corner, kept[j].corner))
        found = kept[j].corner;
      if (work > 400 * n_entries + 1000000) { /* one comparison a corner is the rule */
        tsolid_finding finding = element_finding(g, corner / 4);
        return tsi_report(g->context, &finding,
                          "Too many corners of elements nearly coincide, at element %d",
                          finding.index[0]);
      }
    }
    if (found < 0)
      kept[n_kept++] = key[i];
    g->vertex[corner] = found < 0 ? corner : found;
  }
  return TSOLID_OK;
}

/* ---- rows of functions along segments ---------------------------------------------------------
 */

/* Coefficients of entry k along a side, counter-clockwise, `inner` rows away from the edge. */
static void side_row(const tsolid_surface *s, int k, int side, int inner, double *row) {
  ptrdiff_t p = s->degree, n = p + 1;
  ptrdiff_t start = side == 0 ? 0 : side == 1 ? p : side == 2 ? p + n * p : n * p;
  ptrdiff_t step = side == 0 ? 1 : side == 1 ? n : side == 2 ? -1 : -n;
  ptrdiff_t in = side == 0 ? n : side == 1 ? -1 : side == 2 ? -n : 1;
  const double *c = s->coefficient + (size_t)k * net_size(s);
  for (ptrdiff_t i = 0; i <= p; i++)
    row[i] = c[start + step * i + in * inner];
}

static void reverse_row(int degree, double *row) {
  for (int i = 0; 2 * i < degree; i++) {
    double swap = row[i];
    row[i] = row[degree - i];
    row[degree - i] = swap;
  }
}

/* Rows of all functions of a segment, from its end `end` on; derivative: into the element. */
static void segment_rows(const graph *g, const segment *a, int end, int derivative, double *rows) {
  const tsolid_surface *s = g->surface;
  int p = s->degree, first = s->function_start[a->element];
  for (int k = first; k < s->function_start[a->element + 1]; k++) {
    double *row = rows + (size_t)(k - first) * (size_t)(p + 1), inner[TSI_MAX_ORDER];
    side_row(s, k, a->side, 0, row);
    if (derivative) {
      side_row(s, k, a->side, 1, inner);
      for (int i = 0; i <= p; i++)
        row[i] = p * (inner[i] - row[i]);
    }
    tsi_bernstein_restrict(p, a->low, a->high, row, 1);
    if (end == 1)
      reverse_row(p, row);
  }
}

typedef struct products {
  double aa, ab, bb;
} products;

/* Walks the functions of two segments side by side. With `weight` the largest
 * |row_a - weight * row_b|; without it the products of their rows, or of their first differences.
 */
static double compare_rows(const graph *g, const segment *a, const segment *b, const double *weight,
                           int differences, products *sums) {
  static const double zero[TSI_MAX_ORDER];
  const tsolid_surface *s = g->surface;
  int p = s->degree, i = s->function_start[a->element], end_i = s->function_start[a->element + 1];
  int j = s->function_start[b->element], end_j = s->function_start[b->element + 1];
  const double *row_a = g->row[0], *row_b = g->row[1];
  double largest = 0.0;
  *sums = (products){0.0, 0.0, 0.0};
  while (i < end_i || j < end_j) {
    int take_i = j == end_j || (i < end_i && s->function[i] <= s->function[j]);
    int take_j = i == end_i || (j < end_j && s->function[j] <= s->function[i]);
    const double *x = take_i ? row_a : zero, *y = take_j ? row_b : zero;
    for (int c = 0; c <= p; c++) {
      if (weight) {
        largest = fmax(largest, fabs(x[c] - *weight * y[c]));
        continue;
      }
      if (differences && c > 0)
        break;
      double u = differences ? x[1] - x[0] : x[c], v = differences ? y[1] - y[0] : y[c];
      sums->aa += u * u;
      sums->ab += u * v;
      sums->bb += v * v;
    }
    row_a += take_i ? p + 1 : 0;
    row_b += take_j ? p + 1 : 0;
    i += take_i;
    j += take_j;
  }
  return largest;
}

static void restrict_rows(const graph *g, const segment *a, double part, double *rows) {
  const tsolid_surface *s = g->surface;
  int n = count_functions(s, a->element);
  for (int k = 0; k < n; k++)
    tsi_bernstein_restrict(s->degree, 0.0, part, rows + (size_t)k * (size_t)(s->degree + 1), 1);
}

/* How much longer a is than b when both leave a vertex along one curve, from their ends end_a and
 * end_b on (1: equally long, 1/3: b goes on); 0: they part. */
static double compare_segments(const graph *g, const segment *a, int end_a, const segment *b,
                               int end_b) {
  static const double one = 1.0;
  products sums;
  double ratio = 1.0;
  segment_rows(g, a, end_a, 0, g->row[0]);
  segment_rows(g, b, end_b, 0, g->row[1]);
  if (a->vertex[1 - end_a] != b->vertex[1 - end_b]) {
    compare_rows(g, a, b, NULL, 1, &sums);
    if (!(sums.ab > 0.0) || !(sums.aa > 0.0) || !(sums.bb > 0.0))
      return 0.0;
    if (!(sums.ab * sums.ab >= (1.0 - same_ratio) * sums.aa * sums.bb))
      return 0.0;
    double part = round_ratio(sums.aa <= sums.bb ? sums.ab / sums.bb : sums.ab / sums.aa);
    if (!(part >= shortest_part) || !(part <= 1.0 - shortest_part))
      return 0.0;
    if (sums.aa <= sums.bb)
      restrict_rows(g, b, part, g->row[1]);
    else
      restrict_rows(g, a, part, g->row[0]);
    ratio = sums.aa <= sums.bb ? part : 1.0 / part;
  }
  return compare_rows(g, a, b, &one, 0, &sums) <= same_coefficient ? ratio : 0.0;
}

/* ---- segments find their partners -------------------------------------------------------------
 */

/* Ends at one vertex never become more: a split at an end's far vertex uses up one there. */
static void add_open(graph *g, int at, int end) {
  int v = g->segment[at].vertex[end];
  g->open[g->n_open] = (open_end){at, end, g->first_open[v]};
  g->first_open[v] = g->n_open++;
  if (!g->is_queued[v]) {
    g->is_queued[v] = 1;
    g->queue[(g->queue_first + g->n_queue++) % g->queue_room] = v;
  }
}

static void remove_open(graph *g, int at, int end) {
  int *link = &g->first_open[g->segment[at].vertex[end]];
  while (*link >= 0 && (g->open[*link].segment != at || g->open[*link].end != end))
    link = &g->open[*link].next;
  if (*link >= 0)
    *link = g->open[*link].next;
}

/* Cuts `part` of a segment off at its end `end`, up to `vertex`, and returns it; the rest stays
 * open. The list of the side keeps its order. */
static int split_segment(graph *g, int at, int end, double part, int vertex) {
  int added = g->n_segments++, rest = end == 0 ? added : at;
  segment *a = &g->segment[at], *b = &g->segment[added];
  double cut = end == 0 ? a->low + part * (a->high - a->low) : a->high - part * (a->high - a->low);
  remove_open(g, at, 0);
  remove_open(g, at, 1);
  *b = *a;
  a->high = b->low = cut;
  a->vertex[1] = b->vertex[0] = vertex;
  a->next = added;
  add_open(g, rest, 0);
  add_open(g, rest, 1);
  return end == 0 ? at : added;
}

static void join_segments(graph *g, int a, int end_a, int b, int end_b) {
  for (int end = 0; end < 2; end++) {
    remove_open(g, a, end);
    remove_open(g, b, end);
  }
  g->segment[a].partner = b;
  g->segment[b].partner = a;
  g->segment[a].along = g->segment[b].along = end_a == end_b;
}

static tsolid_status refuse_three(graph *g, int a, int b, int c) {
  tsolid_finding finding = element_finding(g, g->segment[a].element);
  const int *record = g->surface->face_record;
  int e[3] = {g->segment[a].element, g->segment[b].element, g->segment[c].element};
  for (int i = 0; record && i < 3; i++)
    e[i] = record[e[i]];
  return tsi_report(g->context, &finding, "Elements %d, %d and %d share one edge", e[0], e[1],
                    e[2]);
}

static tsolid_status match_at(graph *g, int v) {
  open_end list[MAX_MEETING];
  int n = 0;
  for (int k = g->first_open[v]; k >= 0; k = g->open[k].next)
    list[n++] = g->open[k];
  for (int i = 0; i < n; i++) {
    int found = -1, a = list[i].segment, end = list[i].end;
    double ratio = 0.0;
    for (int j = 0; a >= 0 && j < n; j++) {
      int b = list[j].segment;
      if (b < 0 || a == b ||
          (g->segment[a].element == g->segment[b].element &&
           g->segment[a].side == g->segment[b].side))
        continue;
      double r = compare_segments(g, &g->segment[a], end, &g->segment[b], list[j].end);
      if (!(r > 0.0))
        continue;
      if (found >= 0)
        return refuse_three(g, a, list[found].segment, b);
      found = j;
      ratio = r;
    }
    if (found < 0)
      continue;
    int b = list[found].segment, end_b = list[found].end;
    list[i].segment = list[found].segment = -1;
    if (ratio < 1.0)
      b = split_segment(g, b, end_b, ratio, g->segment[a].vertex[1 - end]);
    else if (ratio > 1.0)
      a = split_segment(g, a, end, 1.0 / ratio, g->segment[b].vertex[1 - end_b]);
    join_segments(g, a, end, b, end_b);
  }
  return TSOLID_OK;
}

static tsolid_status start_segments(graph *g) {
  const tsolid_surface *s = g->surface;
  size_t n = 4 * (size_t)s->n_faces, widest = 1;
  for (int e = 0; e < s->n_faces; e++) {
    size_t k = (size_t)count_functions(s, e);
    widest = k > widest ? k : widest;
  }
  /* a split uses up a segment without partner: at most n of them, with two ends added each */
  g->segment = tsi_arena_new(g->arena, 2 * n, sizeof *g->segment);
  g->open = tsi_arena_new(g->arena, 4 * n, sizeof *g->open);
  g->first_open = tsi_arena_new(g->arena, n, sizeof *g->first_open);
  g->is_queued = tsi_arena_new(g->arena, n, sizeof *g->is_queued);
  g->n_meeting = tsi_arena_new(g->arena, n, sizeof *g->n_meeting);
  g->queue = tsi_arena_new(g->arena, n, sizeof *g->queue);
  g->queue_room = n;
  for (int i = 0; i < 2; i++)
    g->row[i] = tsi_arena_new(g->arena, widest * (size_t)(s->degree + 1), sizeof(double));
  if (!g->segment || !g->open || !g->first_open || !g->is_queued || !g->queue || !g->n_meeting ||
      !g->row[0] || !g->row[1])
    return tsi_no_memory(g->context, stage);
  for (size_t v = 0; v < n; v++)
    g->first_open[v] = -1;
  for (int i = 0; i < (int)n; i++) {
    int from = g->vertex[i], to = g->vertex[i / 4 * 4 + (i + 1) % 4];
    if (from == to) {
      tsolid_finding finding = element_finding(g, i / 4);
      return tsi_report(g->context, &finding,
                        "Side %d of element %d begins and ends at the same point", i % 4,
                        finding.index[0]);
    }
    g->segment[i] = (segment){.element = i / 4,
                              .side = i % 4,
                              .high = 1.0,
                              .vertex = {from, to},
                              .partner = -1,
                              .next = -1};
  }
  g->n_segments = (int)n;
  for (int i = 0; i < (int)n; i++)
    for (int end = 0; end < 2; end++) {
      int *count = &g->n_meeting[g->segment[i].vertex[end]];
      if (++*count > MAX_MEETING) {
        tsolid_finding finding = element_finding(g, i / 4);
        return tsi_report(g->context, &finding,
                          "More than %d elements meet at a corner of element %d", MAX_MEETING / 2,
                          finding.index[0]);
      }
      add_open(g, i, end);
    }
  return TSOLID_OK;
}

static tsolid_status match_segments(graph *g) {
  tsolid_status status = start_segments(g);
  while (!status && g->n_queue > 0) {
    int v = g->queue[g->queue_first];
    g->queue_first = (g->queue_first + 1) % g->queue_room;
    g->n_queue--;
    g->is_queued[v] = 0;
    status = match_at(g, v);
  }
  return status;
}

/* ---- orientation ------------------------------------------------------------------------------
 */

static tsolid_status orient(graph *g) {
  int n = g->surface->n_faces, *stack = tsi_arena_new(g->arena, (size_t)n, sizeof *stack);
  g->mirrored = tsi_arena_new(g->arena, (size_t)n, sizeof *g->mirrored);
  if (!stack || !g->mirrored)
    return tsi_no_memory(g->context, stage);
  for (int first = 0; first < n; first++) {
    int n_stack = 0;
    if (g->mirrored[first])
      continue;
    g->mirrored[first] = 1;
    stack[n_stack++] = first;
    while (n_stack > 0) {
      int e = stack[--n_stack];
      for (int side = 0; side < 4; side++)
        for (int k = 4 * e + side; k >= 0; k = g->segment[k].next) {
          const segment *a = &g->segment[k];
          if (a->partner < 0)
            continue;
          int other = g->segment[a->partner].element, want = 1 + ((g->mirrored[e] - 1) ^ a->along);
          if (!g->mirrored[other]) {
            g->mirrored[other] = want;
            stack[n_stack++] = other;
          } else if (g->mirrored[other] != want) {
            tsolid_finding finding = element_finding(g, e);
            return tsi_report(g->context, &finding,
                              "The surface has only one side: element %d shows both",
                              finding.index[0]);
          }
        }
    }
  }
  return TSOLID_OK;
}

/* ---- links ------------------------------------------------------------------------------------
 */

static void transpose_element(tsolid_surface *s, int e) {
  int n = s->degree + 1;
  for (int k = s->function_start[e]; k < s->function_start[e + 1]; k++) {
    double *c = s->coefficient + (size_t)k * net_size(s);
    for (int j = 0; j < n; j++)
      for (int i = 0; i < j; i++) {
        double swap = c[i + n * j];
        c[i + n * j] = c[j + n * i];
        c[j + n * i] = swap;
      }
  }
}

/* Appends the link of segment k to the loop that begins with link `first`. */
static void append_link(graph *g, int k, int straight, int first) {
  tsolid_surface *s = g->surface;
  int l = s->n_links++;
  s->link[l] =
      (tsi_link){.prev = l - 1, .next = first, .face = g->segment[k].element, .straight = straight};
  if (l > first) {
    s->link[l - 1].next = l;
    s->link[first].prev = l;
  } else {
    s->link[l].prev = l;
  }
  g->segment[k].link = l;
}

static void append_side(graph *g, int e, int side, int first) {
  int mirrored = g->mirrored[e] - 1, k = 4 * e + side, straight = 0;
  if (mirrored) { /* backwards */
    int reversed = -1;
    while (k >= 0) {
      int next = g->segment[k].next;
      g->segment[k].next = reversed;
      reversed = k;
      k = next;
    }
    k = reversed;
  }
  for (; k >= 0; k = g->segment[k].next) {
    append_link(g, k, straight, first);
    straight = 1;
  }
}

static tsolid_status make_links(graph *g) {
  tsolid_surface *s = g->surface;
  size_t n = 2 * (size_t)g->n_segments;
  s->link = tsi_arena_new(&s->arena, n, sizeof *s->link);
  s->face_link = tsi_arena_new(&s->arena, (size_t)s->n_faces, sizeof *s->face_link);
  s->edge_link = tsi_arena_new(&s->arena, n, sizeof *s->edge_link);
  s->vertex_link = tsi_arena_new(&s->arena, n, sizeof *s->vertex_link);
  s->interval = tsi_arena_new(&s->arena, n, sizeof *s->interval);
  if (!s->link || !s->face_link || !s->edge_link || !s->vertex_link || !s->interval)
    return tsi_no_memory(g->context, stage);
  s->n_links = 0;
  for (int e = 0; e < s->n_faces; e++) {
    int first = s->n_links, mirrored = g->mirrored[e] - 1;
    s->face_link[e] = first;
    for (int side = 0; side < 4; side++)
      append_side(g, e, mirrored ? 3 - side : side, first);
  }
  int n_inner = s->n_links;
  for (int k = 0; k < g->n_segments; k++) {
    int l = g->segment[k].link, partner = g->segment[k].partner, o;
    if (partner >= 0 && partner < k)
      continue;
    o = partner < 0 ? s->n_links++ : g->segment[partner].link;
    if (partner < 0)
      s->link[o] = (tsi_link){.face = -1};
    s->link[l].opposite = o;
    s->link[o].opposite = l;
    s->edge_link[s->n_edges] = l;
    s->link[l].edge = s->link[o].edge = s->n_edges++;
  }
  for (int o = n_inner; o < s->n_links; o++) { /* round the open border's vertices */
    int k = s->link[o].opposite;
    do
      k = s->link[s->link[k].prev].opposite;
    while (s->link[k].face >= 0);
    s->link[o].next = k;
    s->link[k].prev = o;
  }
  for (int l = 0; l < s->n_links; l++)
    s->link[l].vertex = -1;
  for (int l = 0; l < s->n_links; l++) { /* a vertex is a fan of links */
    if (s->link[l].vertex >= 0)
      continue;
    s->vertex_link[s->n_vertices] = l;
    for (int k = l; s->link[k].vertex < 0; k = s->link[s->link[k].prev].opposite)
      s->link[k].vertex = s->n_vertices;
    s->n_vertices++;
  }
  return TSOLID_OK;
}

/* ---- knot intervals ---------------------------------------------------------------------------
 */

/* Unknown 2e + d: the width of element e along its own u or v, as a multiple of its root's. */
typedef struct widths {
  int *parent;
  double *ratio;
} widths;

static int find_width(widths *w, int i, double *ratio) {
  int root = i;
  double whole = 1.0;
  while (w->parent[root] != root) {
    whole *= w->ratio[root];
    root = w->parent[root];
  }
  *ratio = whole;
  while (w->parent[i] != i) { /* compress */
    int next = w->parent[i];
    double own = w->ratio[i];
    w->parent[i] = root;
    w->ratio[i] = whole;
    whole /= own;
    i = next;
  }
  return root;
}

/* width a = factor * width b. Returns 1: new, 0: known, -1: against what is known. */
static int relate(widths *w, int a, int b, double factor, double tolerance) {
  double ra, rb;
  int i = find_width(w, a, &ra), j = find_width(w, b, &rb);
  if (i == j)
    return fabs(ra - factor * rb) <= tolerance * ra ? 0 : -1;
  if (i < j) {
    w->parent[j] = i;
    w->ratio[j] = ra / (factor * rb);
  } else {
    w->parent[i] = j;
    w->ratio[i] = factor * rb / ra;
  }
  return 1;
}

static int width_along(const segment *a) {
  return 2 * a->element + (a->side & 1);
}

static int width_across(const segment *a) {
  return 2 * a->element + 1 - (a->side & 1);
}

static tsolid_status relate_along(graph *g, widths *w, int *n_strips) {
  for (int k = 0; k < g->n_segments; k++) {
    const segment *a = &g->segment[k], *b = g->segment + a->partner;
    if (a->partner < k)
      continue;
    int known = relate(w, width_along(a), width_along(b), (b->high - b->low) / (a->high - a->low),
                       same_coefficient);
    *n_strips -= known == 1;
    if (known < 0) {
      tsolid_finding finding = element_finding(g, a->element);
      return tsi_report(g->context, &finding,
                        "There are no knot intervals for these elements: a strip of them comes "
                        "back to element %d with another width",
                        finding.index[0]);
    }
  }
  return TSOLID_OK;
}

/* The ratio width_across(a) / width_across(b) if all functions are C^1 across; else 0. */
static double find_ratio(graph *g, const segment *a, const segment *b) {
  products sums;
  segment_rows(g, a, 0, 1, g->row[0]);
  segment_rows(g, b, a->along ? 0 : 1, 1, g->row[1]);
  compare_rows(g, a, b, NULL, 0, &sums);
  double weight = sums.ab / sums.bb; /* D_a = weight D_b: weight = -h_a / h_b */
  if (!(weight < 0.0) || !(sums.aa > 0.0) || !isfinite(weight))
    return 0.0;
  double difference = compare_rows(g, a, b, &weight, 0, &sums), largest = 0.0;
  size_t n = (size_t)count_functions(g->surface, a->element) * (size_t)(g->surface->degree + 1);
  for (size_t i = 0; i < n; i++)
    largest = fmax(largest, fabs(g->row[0][i]));
  return difference <= same_derivative * largest ? round_ratio(-weight) : 0.0;
}

static void relate_across(graph *g, widths *w, tsi_graph_facts *facts) {
  for (int k = 0; k < g->n_segments; k++) {
    const segment *a = &g->segment[k];
    if (a->partner < k)
      continue;
    double ratio = find_ratio(g, a, &g->segment[a->partner]);
    if (!(ratio > 0.0))
      continue;
    int known =
        relate(w, width_across(a), width_across(&g->segment[a->partner]), ratio, same_ratio);
    facts->n_inferred += known == 1;
    facts->n_conflicts += known < 0;
  }
}

static tsolid_status infer_intervals(graph *g, tsi_graph_facts *facts) {
  tsolid_surface *s = g->surface;
  size_t n = 2 * (size_t)s->n_faces;
  widths w = {tsi_arena_new(g->arena, n, sizeof *w.parent),
              tsi_arena_new(g->arena, n, sizeof *w.ratio)};
  double *smallest = tsi_arena_new(g->arena, n, sizeof *smallest);
  if (!w.parent || !w.ratio || !smallest)
    return tsi_no_memory(g->context, stage);
  *facts = (tsi_graph_facts){.n_strips = (int)n};
  for (int i = 0; i < (int)n; i++) {
    w.parent[i] = i;
    w.ratio[i] = 1.0;
    smallest[i] = INFINITY;
  }
  tsolid_status status = relate_along(g, &w, &facts->n_strips);
  if (status)
    return status;
  relate_across(g, &w, facts);
  for (int i = 0; i < (int)n; i++) {
    double ratio;
    int root = find_width(&w, i, &ratio);
    smallest[root] = fmin(smallest[root], ratio);
  }
  for (int k = 0; k < g->n_segments; k++) { /* a whole side rather than a part of the longer one */
    const segment *a = &g->segment[k];
    if (a->partner >= 0 && a->high - a->low < 1.0)
      continue;
    double ratio;
    int root = find_width(&w, width_along(a), &ratio);
    s->interval[s->link[a->link].edge] = ratio / smallest[root] * (a->high - a->low);
  }
  for (int k = 0; k < g->n_segments; k++) {
    const segment *a = &g->segment[k];
    double *interval = &s->interval[s->link[a->link].edge], ratio;
    int root = find_width(&w, width_along(a), &ratio);
    if (*interval == 0.0)
      *interval = ratio / smallest[root] * (a->high - a->low);
  }
  return TSOLID_OK;
}

/* ---- the driver -------------------------------------------------------------------------------
 */

static tsolid_status make_boxes(graph *g) {
  tsolid_surface *s = g->surface;
  size_t n = (size_t)s->n_faces;
  s->element_start = tsi_arena_new(&s->arena, n + 1, sizeof *s->element_start);
  s->box = tsi_arena_new(&s->arena, n, 4 * sizeof *s->box);
  if (!s->element_start || !s->box)
    return tsi_no_memory(g->context, stage);
  for (int f = 0; f < s->n_faces; f++) {
    double length[2];
    tsi_face_lengths(s, f, length);
    s->box[4 * (size_t)f + 1] = length[0];
    s->box[4 * (size_t)f + 3] = length[1];
    s->element_start[f + 1] = f + 1;
  }
  return TSOLID_OK;
}

tsolid_status tsi_surface_connect(tsolid_context *context, tsolid_surface *surface,
                                  tsi_graph_facts *facts) {
  tsi_arena arena = tsi_arena_create(context);
  graph g = {.context = context, .arena = &arena, .surface = surface};
  tsolid_status status = glue_corners(&g);
  if (!status)
    status = match_segments(&g);
  if (!status)
    status = orient(&g);
  if (!status)
    status = make_links(&g);
  if (!status)
    status = infer_intervals(&g, facts);
  for (int e = 0; !status && e < surface->n_faces; e++)
    if (g.mirrored[e] == 2)
      transpose_element(surface, e);
  if (!status)
    status = tsi_surface_check(context, surface, NULL);
  if (!status)
    status = make_boxes(&g);
  tsi_arena_free(&arena);
  return status;
}
