/* SPDX-License-Identifier: LGPL-2.1-or-later
 * From a surface cut along its isolines to six Bezier sides.
 *
 * Each side is unfolded into the plane of knot intervals from its low corner on, x along the first
 * of its isolines, y to the left; faces and frames turn by quarters. All positions along one axis
 * of the cube, from the four sides that carry it, are gathered, those that differ by round-off
 * become one, and are scaled to [0,1]: multiples of 2^-53, on which 1 - x is exact. */
#include <stdlib.h>

#include "bernstein.h"
#include "surface_cube.h"

static const char stage[] = "boundary";

/* A position along an axis that some box or vertex has. */
typedef struct mark {
  tsi_sum at;
  double *target; /* where the result goes; NULL: a vertex, which counts more than a box */
} mark;

typedef struct mark_list {
  mark *mark;
  size_t n, room;
} mark_list;

typedef struct unfolding {
  tsi_cutting *cut;
  mark_list axis[3];
  int *link_turn;   /* per link: 1 + quarter turns from x, 0: not unfolded */
  tsi_sum *link_at; /* per link: where its origin is, x and y */
  int *queue;       /* faces of a side */
  int n_queue;
  int *function; /* new number of a function of the surface, -1: unused */
  int n_functions;
} unfolding;

static int add_mark(tsi_arena *arena, mark_list *list, tsi_sum at, double *target) {
  if (list->n == list->room) {
    size_t room = list->room + list->room / 2 + 64;
    mark *moved = tsi_arena_new(arena, room, sizeof *moved);
    if (!moved)
      return 0;
    if (list->n > 0)
      memcpy(moved, list->mark, list->n * sizeof *moved);
    list->mark = moved;
    list->room = room;
  }
  list->mark[list->n++] = (mark){at, target};
  return 1;
}

/* ---- unfolding --------------------------------------------------------------------------------
 */

static void step(tsi_sum at[2], int turn, tsi_sum length) {
  tsi_sum *x = &at[turn & 1];
  *x = turn >= 2 ? tsi_sum_subtract(*x, length) : tsi_sum_add(*x, length);
}

/* Places all links of the face of `start`, whose origin is at `at`. */
static void unfold_face(unfolding *u, int start, int turn, const tsi_sum at[2]) {
  const tsi_cutting *cut = u->cut;
  tsi_sum x[2] = {at[0], at[1]};
  int k = start;
  do {
    if (k != start && !cut->link[k].straight)
      turn = (turn + 1) & 3;
    u->link_turn[k] = 1 + turn;
    u->link_at[2 * k] = x[0];
    u->link_at[2 * k + 1] = x[1];
    step(x, turn, cut->length[cut->link[k].edge]);
    k = cut->link[k].next;
  } while (k != start);
  u->queue[u->n_queue++] = cut->link[start].face;
}

static void unfold_side(unfolding *u, int side) {
  const tsi_cutting *cut = u->cut;
  const tsi_sum zero[2] = {{0.0, 0.0}, {0.0, 0.0}};
  u->n_queue = 0;
  unfold_face(u, cut->ray[cut->side_ray[side]].start, 0, zero);
  for (int i = 0; i < u->n_queue; i++) {
    int start = cut->face[u->queue[i]].first, k = start;
    do {
      int o = cut->link[k].opposite;
      if (!cut->edge_isoline[cut->link[k].edge] && !u->link_turn[o]) {
        tsi_sum at[2] = {u->link_at[2 * k], u->link_at[2 * k + 1]};
        step(at, u->link_turn[k] - 1, cut->length[cut->link[k].edge]);
        unfold_face(u, o, (u->link_turn[k] + 1) & 3, at);
      }
      k = cut->link[k].next;
    } while (k != start);
  }
}

static int is_near(const unfolding *u, int a, const tsi_sum at[2], double tolerance) {
  return fabs(tsi_sum_subtract(u->link_at[2 * a], at[0]).high) <= tolerance &&
         fabs(tsi_sum_subtract(u->link_at[2 * a + 1], at[1]).high) <= tolerance;
}

/* Every loop and every edge closes, and the isolines are the rectangle's border. */
static tsolid_status check_unfolding(unfolding *u, int side) {
  const tsi_cutting *cut = u->cut;
  const tsi_ray *ray = &cut->ray[cut->side_ray[side]];
  double extent[2] = {ray->length.high, cut->ray[ray->next].length.high};
  double tolerance = tsi_same_position * (extent[0] + extent[1]);
  for (int i = 0; i < u->n_queue; i++) {
    const tsi_cut_face *face = &cut->face[u->queue[i]];
    int k = face->first;
    do {
      const tsi_link *link = &cut->link[k];
      int turn = u->link_turn[k] - 1, closes;
      tsi_sum at[2] = {u->link_at[2 * k], u->link_at[2 * k + 1]};
      step(at, turn, cut->length[link->edge]);
      closes = is_near(u, link->next, at, tolerance);
      if (cut->edge_isoline[link->edge]) {
        double border = turn == 1 || turn == 2 ? extent[1 - (turn & 1)] : 0.0;
        closes = closes && fabs(at[1 - (turn & 1)].high - border) <= tolerance;
      } else {
        int o = link->opposite;
        closes = closes && u->link_turn[o] && ((u->link_turn[o] - 1) ^ turn) == 2 &&
                 is_near(u, o, at, tolerance);
      }
      if (!closes) {
        tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
        finding.entity = TSOLID_ENTITY_PATCH;
        finding.index[0] =
            cut->surface->face_record ? cut->surface->face_record[face->whole] : face->whole;
        return tsi_report(cut->context, &finding,
                          "The knot intervals do not close: the faces round face %d do not lie "
                          "side by side",
                          finding.index[0]);
      }
      k = link->next;
    } while (k != face->first);
  }
  return TSOLID_OK;
}

/* ---- elements ---------------------------------------------------------------------------------
 */

/* An element of a whole face inside one part of it: what is left of it, in its own [0,1]^2. */
typedef struct clip {
  double part[4];
  int at_end[4]; /* the limit is the part's, not the element's */
} clip;

/* 0: nothing is left. */
static int clip_element(const tsi_cut_face *face, const double *box, clip *c) {
  for (int d = 0; d < 2; d++) {
    double low = box[2 * d], high = box[2 * d + 1], width = high - low;
    double from = tsi_sum_subtract(face->box[2 * d], tsi_sum_of(low)).high;
    double to = tsi_sum_subtract(tsi_sum_of(high), face->box[2 * d + 1]).high;
    double extent = tsi_sum_subtract(face->box[2 * d + 1], face->box[2 * d]).high;
    double tolerance = tsi_same_position * fmin(extent, width);
    if (!(width > 0.0) || !(width - fmax(from, 0.0) - fmax(to, 0.0) > tolerance))
      return 0;
    c->at_end[2 * d] = from >= -tolerance;
    c->at_end[2 * d + 1] = to >= -tolerance;
    c->part[2 * d] = from > tolerance ? from / width : 0.0;
    c->part[2 * d + 1] = to > tolerance ? 1.0 - to / width : 1.0;
  }
  return 1;
}

/* (i, j) along (u, v) of a frame turned by `turn` -> index along (x, y), or (y, x) if swapped. */
static size_t turned_index(size_t i, size_t j, size_t p, int turn, int swap) {
  size_t x = turn == 0 ? i : turn == 1 ? p - j : turn == 2 ? p - i : j;
  size_t y = turn == 0 ? j : turn == 1 ? i : turn == 2 ? p - j : p - i;
  return swap ? y + (p + 1) * x : x + (p + 1) * y;
}

static void copy_coefficients(const double *from, int degree, const clip *c, int turn, int swap,
                              double *to) {
  double net[TSI_MAX_ORDER * TSI_MAX_ORDER];
  size_t n = (size_t)degree + 1;
  memcpy(net, from, n * n * sizeof *net);
  for (size_t i = 0; i < n; i++)
    tsi_bernstein_restrict(degree, c->part[0], c->part[1], net + n * i, 1);
  for (size_t i = 0; i < n; i++)
    tsi_bernstein_restrict(degree, c->part[2], c->part[3], net + i, (int)n);
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < n; i++)
      to[turned_index(i, j, n - 1, turn, swap)] = net[i + n * j];
}

/* The corner of the part opposite to its first link's origin. */
static const tsi_sum *far_corner(const unfolding *u, int first) {
  int k = first;
  for (int corners = 0; corners < 2;) {
    k = u->cut->link[k].next;
    corners += !u->cut->link[k].straight;
  }
  return u->link_at + 2 * k;
}

/* Marks for the four limits of an element; `box` gets them in the side's (s, t). */
static int mark_element(unfolding *u, const tsi_cut_face *face, const double *limit, const clip *c,
                        int swap, const int side_axis[2], double *box) {
  int turn = u->link_turn[face->first] - 1;
  const tsi_sum *near_corner = u->link_at + 2 * face->first, *far = far_corner(u, face->first);
  for (int d = 0; d < 2; d++)
    for (int end = 0; end < 2; end++) {
      int along = (d + turn) & 1; /* 0: x, 1: y */
      int reversed = d == 0 ? turn >= 2 : turn == 1 || turn == 2;
      tsi_sum at = (end ? far : near_corner)[along];
      if (!c->at_end[2 * d + end]) {
        tsi_sum from = tsi_sum_subtract(tsi_sum_of(limit[2 * d + end]), face->box[2 * d]);
        at = reversed ? tsi_sum_subtract(near_corner[along], from)
                      : tsi_sum_add(near_corner[along], from);
      }
      int s = swap ? 1 - along : along;
      if (!add_mark(u->cut->arena, &u->axis[side_axis[s]], at, box + 2 * s + (end ^ reversed)))
        return 0;
    }
  return 1;
}

typedef struct side_sizes {
  size_t n_elements, n_entries;
} side_sizes;

static side_sizes count_side(const unfolding *u) {
  const struct tsolid_surface *s = u->cut->surface;
  side_sizes sizes = {0, 0};
  for (int i = 0; i < u->n_queue; i++) {
    const tsi_cut_face *face = &u->cut->face[u->queue[i]];
    for (int e = s->element_start[face->whole]; e < s->element_start[face->whole + 1]; e++) {
      clip c;
      if (!clip_element(face, s->box + 4 * (size_t)e, &c))
        continue;
      sizes.n_elements++;
      sizes.n_entries += (size_t)(s->function_start[e + 1] - s->function_start[e]);
    }
  }
  return sizes;
}

static int compare_faces(const void *a, const void *b) {
  int p = *(const int *)a, q = *(const int *)b;
  return (p > q) - (p < q);
}

static tsolid_status no_elements(tsi_cutting *cut, int side) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = TSOLID_ENTITY_SIDE;
  finding.index[0] = side;
  return tsi_report(cut->context, &finding,
                    "A side of the cube has no area: all its faces have "
                    "knot intervals of zero");
}

static tsolid_status fill_side(unfolding *u, int number, tsolid_bezier_side *side) {
  tsi_cutting *cut = u->cut;
  const struct tsolid_surface *s = cut->surface;
  size_t width = (size_t)(s->degree + 1) * (size_t)(s->degree + 1), entry = 0, element = 0;
  int axis = cut->ray[cut->side_ray[number]].axis, swap = axis != tsi_side_s(number);
  const int side_axis[2] = {tsi_side_s(number), tsi_side_t(number)};
  side_sizes sizes = count_side(u);
  if (sizes.n_elements == 0)
    return no_elements(cut, number);
  if ((double)sizes.n_entries * (double)width > TSI_MAX_COUNT)
    return tsi_fail(cut->context, TSOLID_ERROR_REFUSED, stage, "The surface is too large");
  double *box = tsi_arena_new(cut->arena, sizes.n_elements, 4 * sizeof *box);
  int *start = tsi_arena_new(cut->arena, sizes.n_elements + 1, sizeof *start);
  int *function = tsi_arena_new(cut->arena, sizes.n_entries, sizeof *function);
  double *coefficient = tsi_arena_new(cut->arena, sizes.n_entries * width, sizeof *coefficient);
  if (!box || !start || !function || !coefficient)
    return tsi_no_memory(cut->context, stage);
  *side = (tsolid_bezier_side){.degree = {s->degree, s->degree},
                               .n_elements = (int)sizes.n_elements,
                               .box = box,
                               .function_start = start,
                               .function = function,
                               .coefficient = coefficient};
  for (int i = 0; i < u->n_queue; i++) {
    const tsi_cut_face *face = &cut->face[u->queue[i]];
    int turn = u->link_turn[face->first] - 1;
    for (int e = s->element_start[face->whole]; e < s->element_start[face->whole + 1]; e++) {
      clip c;
      if (!clip_element(face, s->box + 4 * (size_t)e, &c))
        continue;
      if (!mark_element(u, face, s->box + 4 * (size_t)e, &c, swap, side_axis, box + 4 * element))
        return tsi_no_memory(cut->context, stage);
      for (int k = s->function_start[e]; k < s->function_start[e + 1]; k++, entry++) {
        int *f = &u->function[s->function[k]];
        if (*f < 0)
          *f = u->n_functions++;
        function[entry] = *f;
        copy_coefficients(s->coefficient + (size_t)k * width, s->degree, &c, turn, swap,
                          coefficient + entry * width);
      }
      start[++element] = (int)entry;
    }
  }
  return TSOLID_OK;
}

static int mark_vertices(unfolding *u, int number) {
  const tsi_cutting *cut = u->cut;
  int axis = cut->ray[cut->side_ray[number]].axis;
  int other = tsi_side_s(number) == axis ? tsi_side_t(number) : tsi_side_s(number);
  for (int i = 0; i < u->n_queue; i++) {
    int start = cut->face[u->queue[i]].first, k = start;
    do {
      if (!add_mark(cut->arena, &u->axis[axis], u->link_at[2 * k], NULL) ||
          !add_mark(cut->arena, &u->axis[other], u->link_at[2 * k + 1], NULL))
        return 0;
      k = cut->link[k].next;
    } while (k != start);
  }
  return 1;
}

/* ---- positions --------------------------------------------------------------------------------
 */

static int compare_marks(const void *a, const void *b) {
  const mark *p = a, *q = b;
  if (p->at.high != q->at.high)
    return p->at.high < q->at.high ? -1 : 1;
  return (p->at.low > q->at.low) - (p->at.low < q->at.low);
}

/* The middle of marks first..end-1, of the vertices among them if there are any: the same from
 * whichever side one counts. */
static tsi_sum find_middle(const mark *m, size_t first, size_t end) {
  const mark *low = NULL, *high = NULL;
  for (size_t i = first; i < end; i++)
    if (!m[i].target) {
      low = low ? low : &m[i];
      high = &m[i];
    }
  if (!low) {
    low = &m[first];
    high = &m[end - 1];
  }
  tsi_sum middle = tsi_sum_add(low->at, high->at);
  return (tsi_sum){0.5 * middle.high, 0.5 * middle.low};
}

/* x / length in [0,1], to the nearest multiple of 2^-53. */
static double scale_position(tsi_sum x, tsi_sum length) {
  static const double unit = 0x1p53;
  double q = x.high / length.high;
  if (!(q > 0.0))
    return 0.0;
  double c = q * length.high, split = 0x1p27 + 1.0;
  /* Dekker's exact product q * length.high = c + error */
  double qh = q * split, lh = length.high * split;
  qh = qh - (qh - q);
  lh = lh - (lh - length.high);
  double ql = q - qh, ll = length.high - lh;
  double error = ((qh * lh - c) + qh * ll + ql * lh) + ql * ll;
  double rest = ((x.high - c) - error + (x.low - q * length.low)) / length.high;
  double whole = floor(q * unit), part = (q * unit - whole) + rest * unit;
  whole += floor(part);
  part -= floor(part);
  if (part > 0.5 || (part == 0.5 && fmod(whole, 2.0) != 0.0))
    whole += 1.0;
  return fmin(whole / unit, 1.0);
}

static tsolid_status settle_axis(unfolding *u, int axis) {
  mark_list *list = &u->axis[axis];
  const mark *m = list->mark;
  double tolerance = 0.0;
  for (int r = 0; r < TSI_N_RAYS; r++)
    if (u->cut->ray[r].axis == axis)
      tolerance = fmax(tolerance, tsi_same_position * u->cut->ray[r].length.high);
  qsort(list->mark, list->n, sizeof *list->mark, compare_marks);
  tsi_sum low = tsi_sum_of(0.0), length = low;
  for (int pass = 0; pass < 2; pass++) /* the last cluster gives the length */
    for (size_t first = 0, end; first < list->n; first = end) {
      for (end = first + 1; end < list->n; end++)
        if (m[end].at.high - m[end - 1].at.high > tolerance)
          break;
      if (pass == 0 && first > 0 && end < list->n)
        continue;
      tsi_sum at = find_middle(m, first, end);
      if (pass == 0 && first == 0)
        low = at;
      if (pass == 0 && end == list->n)
        length = tsi_sum_subtract(at, low);
      double x = pass == 1 ? scale_position(tsi_sum_subtract(at, low), length) : 0.0;
      for (size_t i = first; pass == 1 && i < end; i++)
        if (m[i].target)
          *m[i].target = x;
    }
  return TSOLID_OK;
}

static tsolid_status check_boxes(tsi_cutting *cut, const tsolid_bezier_side *side, int number) {
  for (int e = 0; e < side->n_elements; e++) {
    const double *box = side->box + 4 * (size_t)e;
    if (box[0] < box[1] && box[2] < box[3])
      continue;
    tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
    finding.entity = TSOLID_ENTITY_SIDE;
    finding.index[0] = number;
    return tsi_report(cut->context, &finding,
                      "A knot interval is too small: less than %g of an isoline's length",
                      tsi_same_position);
  }
  return TSOLID_OK;
}

/* ---- the driver -------------------------------------------------------------------------------
 */

tsolid_status tsi_cutting_sides(tsi_cutting *cut, tsolid_bezier_boundary *boundary) {
  const struct tsolid_surface *s = cut->surface;
  unfolding *u = tsi_arena_new(cut->arena, 1, sizeof *u);
  if (!u)
    return tsi_no_memory(cut->context, stage);
  u->cut = cut;
  u->link_turn = tsi_arena_new(cut->arena, (size_t)cut->n_links, sizeof *u->link_turn);
  u->link_at = tsi_arena_new(cut->arena, (size_t)cut->n_links, 2 * sizeof *u->link_at);
  u->queue = tsi_arena_new(cut->arena, (size_t)cut->n_faces, sizeof *u->queue);
  u->function = tsi_arena_new(cut->arena, (size_t)s->n_points, sizeof *u->function);
  if (!u->link_turn || !u->link_at || !u->queue || !u->function)
    return tsi_no_memory(cut->context, stage);
  for (int i = 0; i < s->n_points; i++)
    u->function[i] = -1;
  tsolid_status status = TSOLID_OK;
  for (int i = 0; !status && i < 6; i++) {
    unfold_side(u, i);
    qsort(u->queue, (size_t)u->n_queue, sizeof *u->queue, compare_faces);
    status = check_unfolding(u, i);
    if (!status && !mark_vertices(u, i))
      status = tsi_no_memory(cut->context, stage);
    if (!status)
      status = fill_side(u, i, &boundary->side[i]);
  }
  for (int axis = 0; !status && axis < 3; axis++)
    status = settle_axis(u, axis);
  for (int i = 0; !status && i < 6; i++)
    status = check_boxes(cut, &boundary->side[i], i);
  if (status)
    return status;
  double *points = tsi_arena_new(cut->arena, (size_t)u->n_functions, 4 * sizeof *points);
  if (!points)
    return tsi_no_memory(cut->context, stage);
  for (int i = 0; i < s->n_points; i++)
    if (u->function[i] >= 0)
      memcpy(points + 4 * (size_t)u->function[i], s->points + 4 * (size_t)i, 4 * sizeof *points);
  boundary->n_functions = u->n_functions;
  boundary->points = points;
  return TSOLID_OK;
}
