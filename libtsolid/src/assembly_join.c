/* SPDX-License-Identifier: LGPL-2.1-or-later
 * After the construction: what both solids have on every contact.
 *
 * The boundaries of solids are seen as Bezier elements, whatever they were made of. On a contact
 * each element of one side must have its like on the other: the same box in the contact's (s,t) and
 * the same functions, told by their Bernstein coefficients in the contact's orientation. The
 * control points of two such functions are then compared bit for bit, in one frame.
 *
 * The record of a contact is the net that the prepared inputs have there; it is kept only as the
 * truth: every control point that a solid has on the contact must be one of its points, bit for
 * bit. Both sides evaluate through it, so in one frame their points are the same bits. Contacts of
 * different frames have a net per side. Beside that the solids' own values at equal points are
 * compared, which differ by what evaluation rounds. */
#include <float.h>
#include <stdlib.h>

#include "assembly.h"
#include "bernstein.h"

static const char stage[] = "assembly";

static const double box_resolution = 1e-9;
static const double coefficient_resolution = 1e-10;

enum { N_GRID = 9 };

/* ---- the contact on one solid ------------------------------------------------------------------
 */

/* S = origin[0] + ds[0] s + dt[0] t, T likewise: one of each pair is zero. */
typedef struct chart {
  const tsolid_solid *solid;
  const tsi_side *side;
  const double *points;
  int number;    /* of the side */
  double box[4]; /* of the piece on the side */
  double origin[2], ds[2], dt[2];
} chart;

/* The charts of all pieces of one side of a contact. */
typedef struct atlas {
  int n, affine; /* not affine: charts have their solid and number alone */
  chart *chart;
  tsolid_placement *place;
  double whole[4]; /* range of the patch */
} atlas;

static void to_side(const tsolid_placement *place, const double uv[2], double st[2]) {
  double x[2] = {uv[0], uv[1]};
  for (int d = 0; d < 2; d++) {
    double m = place->moebius[d];
    if (m > 1.0 || m < 1.0)
      x[d] = m * x[d] / (m * x[d] + (1.0 - x[d]));
    if (place->flip[d])
      x[d] = 1.0 - x[d];
  }
  st[0] = place->box[0] + x[place->swap] * (place->box[1] - place->box[0]);
  st[1] = place->box[2] + x[1 - place->swap] * (place->box[3] - place->box[2]);
}

/* The piece's chart; `whole` is the range of the patch. 0: its parameters are no affine image. */
static int open_chart(const tsolid_interface *view, int side, const tsolid_solid *solid,
                      const tsolid_placement *place, const double whole[4], chart *to) {
  static const double corner[3][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  const tsolid_boundary *boundary = solid->space->boundary;
  double st[3][2];
  for (int k = 0; k < 3; k++) {
    double uv[2];
    tsi_contact_map(view, side, corner[k][0], corner[k][1], uv);
    for (int d = 0; d < 2; d++) {
      double x = whole[2 * d] + uv[d] * (whole[2 * d + 1] - whole[2 * d]);
      uv[d] = (x - place->domain[2 * d]) / (place->domain[2 * d + 1] - place->domain[2 * d]);
    }
    to_side(place, uv, st[k]);
  }
  *to = (chart){.solid = solid,
                .side = &boundary->side[place->side],
                .points = boundary->points,
                .number = place->side};
  memcpy(to->box, place->box, sizeof to->box);
  for (int d = 0; d < 2; d++) {
    to->origin[d] = st[0][d];
    to->ds[d] = st[1][d] - st[0][d];
    to->dt[d] = st[2][d] - st[0][d];
  }
  return place->moebius[0] == 1.0 && place->moebius[1] == 1.0;
}

/* All pieces; n = 0: they cannot be told. 0: no memory. */
static int open_atlas(tsi_arena *arena, const tsolid_interface *view, int side,
                      const tsolid_solid *solid, atlas *to) {
  const tsolid_boundary *boundary = solid->space->boundary;
  int k = view->patch[side], n = tsolid_boundary_n_placements(boundary, k), known = 1;
  *to = (atlas){.whole = {INFINITY, -INFINITY, INFINITY, -INFINITY}};
  to->place = tsi_arena_new(arena, (size_t)n, sizeof *to->place);
  to->chart = tsi_arena_new(arena, (size_t)n, sizeof *to->chart);
  if (!to->chart || !to->place)
    return 0;
  for (int i = 0; i < n && known; i++) {
    known = tsolid_boundary_placement(boundary, k, i, &to->place[i]) == TSOLID_OK;
    for (int d = 0; d < 4; d++)
      to->whole[d] = d & 1 ? fmax(to->whole[d], to->place[i].domain[d])
                           : fmin(to->whole[d], to->place[i].domain[d]);
  }
  to->n = known ? n : 0;
  to->affine = view->moebius[0] == 1.0 && view->moebius[1] == 1.0;
  for (int i = 0; i < to->n; i++)
    to->affine &= open_chart(view, side, solid, &to->place[i], to->whole, &to->chart[i]);
  return 1;
}

/* A box of the side in (s,t): s0, s1, t0, t1; *swap: S runs along t. */
static void pull_box(const chart *c, const double from[4], double box[4], int *swap) {
  *swap = c->ds[0] == 0.0;
  for (int k = 0; k < 2; k++) { /* direction of (s,t) */
    int d = *swap ? 1 - k : k;
    double slope = k ? c->dt[d] : c->ds[d];
    double a = (from[2 * d] - c->origin[d]) / slope, b = (from[2 * d + 1] - c->origin[d]) / slope;
    box[2 * k] = fmin(a, b);
    box[2 * k + 1] = fmax(a, b);
  }
}

/* Coefficients of entry k along s, then t. */
static void read_coefficients(const chart *c, int k, double *to) {
  int n[2] = {c->side->degree[0] + 1, c->side->degree[1] + 1}, swap = c->ds[0] == 0.0;
  int low_s = swap ? c->ds[1] < 0.0 : c->ds[0] < 0.0,
      low_t = swap ? c->dt[0] < 0.0 : c->dt[1] < 0.0;
  int n_s = n[swap], n_t = n[1 - swap];
  const double *from = c->side->coefficient + (size_t)k * (size_t)n[0] * (size_t)n[1];
  for (int j = 0; j < n_t; j++)
    for (int i = 0; i < n_s; i++) {
      int p = low_s ? n_s - 1 - i : i, q = low_t ? n_t - 1 - j : j;
      to[i + n_s * j] = swap ? from[q + n[0] * p] : from[p + n[0] * q];
    }
}

static void degrees_of(const chart *c, int degree[2]) {
  int swap = c->ds[0] == 0.0;
  degree[0] = c->side->degree[swap];
  degree[1] = c->side->degree[1 - swap];
}

/* The same polynomial of degree `to`, in place; work of the same size. */
static void raise_both(const int degree[2], const int to[2], double *coefficient, double *work) {
  for (int j = 0; j <= degree[1]; j++)
    tsi_bernstein_raise(degree[0], to[0], 1, coefficient + (degree[0] + 1) * j,
                        work + (to[0] + 1) * j);
  tsi_bernstein_raise(degree[1], to[1], to[0] + 1, work, coefficient);
}

/* The functions of an element that do not vanish on it, raised. */
typedef struct function_list {
  int n;
  const double **point;
  double *coefficient;
} function_list;

static int read_functions(tsi_arena *arena, const chart *c, int e, const int degree[2],
                          function_list *list) {
  int first = c->side->function_start[e], n = c->side->function_start[e + 1] - first, own[2];
  size_t width = (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1);
  double *work = tsi_arena_new(arena, width, sizeof *work);
  list->point = tsi_arena_new(arena, (size_t)n, sizeof *list->point);
  list->coefficient = tsi_arena_new(arena, (size_t)n * width, sizeof *list->coefficient);
  list->n = 0;
  if (!work || !list->point || !list->coefficient)
    return 0;
  degrees_of(c, own);
  for (int k = 0; k < n; k++) {
    double *to = list->coefficient + (size_t)list->n * width, most = 0.0;
    read_coefficients(c, first + k, to);
    raise_both(own, degree, to, work);
    for (size_t i = 0; i < width; i++)
      most = fmax(most, fabs(to[i]));
    if (most > 0.0)
      list->point[list->n++] = c->points + 4 * (size_t)c->side->function[first + k];
  }
  return 1;
}

/* ---- two elements ------------------------------------------------------------------------------
 */

typedef struct findings {
  int functions, bits, n; /* of elements compared */
} findings;

/* Pairs the functions of both by their coefficients. */
static void compare_functions(const function_list *a, const function_list *b, size_t width,
                              findings *found) {
  if (a->n != b->n)
    found->functions = 0;
  for (int i = 0; i < a->n && found->functions; i++) {
    int best = -1;
    for (int k = 0; k < b->n && best < 0; k++) {
      double off = 0.0;
      for (size_t m = 0; m < width && off <= coefficient_resolution; m++)
        off = fmax(off, fabs(a->coefficient[(size_t)i * width + m] -
                             b->coefficient[(size_t)k * width + m]));
      if (off <= coefficient_resolution)
        best = k;
    }
    found->functions = best >= 0;
    found->bits &= best >= 0 && memcmp(a->point[i], b->point[best], 4 * sizeof(double)) == 0;
  }
}

static int in_piece(const chart *c, double x, double y, double margin) {
  return x > c->box[0] - margin && x < c->box[1] + margin && y > c->box[2] - margin &&
         y < c->box[3] + margin;
}

/* The element at a point of the contact, and its chart. */
static int find_element(const atlas *pieces, double s, double t, const chart **of) {
  for (int k = 0; k < pieces->n; k++) {
    const chart *c = *of = &pieces->chart[k];
    double x = c->origin[0] + c->ds[0] * s + c->dt[0] * t;
    double y = c->origin[1] + c->ds[1] * s + c->dt[1] * t;
    if (!in_piece(c, x, y, 0.0))
      continue;
    for (int e = 0; e < c->side->n_elements; e++) {
      const double *box = c->side->box + 4 * (size_t)e;
      if (x > box[0] && x < box[1] && y > box[2] && y < box[3])
        return e;
    }
  }
  return -1;
}

static int compare_points(const void *a, const void *b) {
  return memcmp(a, b, 4 * sizeof(double));
}

/* Control points that are the record's, bit for bit. */
typedef struct sorted_net {
  size_t n;
  const double *point;
} sorted_net;

/* An element within the contact against its like. 0: no memory. */
static int compare_elements(tsi_arena *arena, const chart *c, int e, const atlas *other,
                            const sorted_net *net, findings *found) {
  double box[2][4];
  int swap, own[2][2], degree[2];
  function_list list[2];
  const chart *d;
  pull_box(c, c->side->box + 4 * (size_t)e, box[0], &swap);
  double s = 0.5 * (box[0][0] + box[0][1]), t = 0.5 * (box[0][2] + box[0][3]);
  if (s <= 0.0 || s >= 1.0 || t <= 0.0 || t >= 1.0)
    return 1;
  int like = find_element(other, s, t, &d);
  found->n++;
  if (like < 0) {
    found->functions = 0;
    return 1;
  }
  pull_box(d, d->side->box + 4 * (size_t)like, box[1], &swap);
  for (int k = 0; k < 4; k++)
    found->functions &= fabs(box[0][k] - box[1][k]) <= box_resolution;
  degrees_of(c, own[0]);
  degrees_of(d, own[1]);
  for (int k = 0; k < 2; k++)
    degree[k] = own[0][k] > own[1][k] ? own[0][k] : own[1][k];
  if (!read_functions(arena, c, e, degree, &list[0]) ||
      !read_functions(arena, d, like, degree, &list[1]))
    return 0;
  compare_functions(&list[0], &list[1], (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1), found);
  for (int k = 0; k < list[0].n && found->bits; k++)
    found->bits =
        bsearch(list[0].point[k], net->point, net->n, 4 * sizeof(double), compare_points) != NULL;
  return 1;
}

/* Every element of side 0. 0: no memory. */
static int compare_sides(const atlas pieces[2], const sorted_net *net, tsi_arena *arena,
                         findings *found) {
  for (int k = 0; k < pieces[0].n; k++) {
    const chart *c = &pieces[0].chart[k];
    for (int e = 0; e < c->side->n_elements && found->functions; e++) {
      const double *box = c->side->box + 4 * (size_t)e;
      if (in_piece(c, 0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3]), 0.0) &&
          !compare_elements(arena, c, e, &pieces[1], net, found))
        return 0;
    }
  }
  found->functions &= found->n > 0;
  found->bits &= found->functions;
  return 1;
}

/* ---- records -----------------------------------------------------------------------------------
 */

/* A side's net in the contact's orientation; n[0] = 0 where the part has no prepared input. */
static int read_net(const tsolid_assembly *assembly, const tsolid_interface *view, int side,
                    tsi_arena *work, tsi_arena *arena, tsi_patch *net) {
  const tsolid_boundary_input *input = tsolid_assembly_boundary_input(assembly, view->part[side]);
  tsi_patch patch, part;
  double box[4];
  net->n[0] = 0;
  if (!input)
    return 1;
  if (!tsi_patch_read(work, &input->patches[view->patch[side]], &patch))
    return 0;
  for (int k = 0; k < 4; k++) { /* the lines as they are */
    const double *knots = patch.knots[k / 2];
    box[k] = view->box[side][k];
    for (int i = 0; i < patch.n[k / 2] + patch.degree[k / 2] + 1; i++)
      if (fabs(knots[i] - view->box[side][k]) <= 1e-11)
        box[k] = knots[i];
  }
  if (!tsi_patch_restrict(work, &patch, box, &part))
    return 0;
  return tsi_patch_turn(arena, &part, side ? view->code : 0, net);
}

static void place_point(const tsi_member *part, double x[3]) {
  if (part->placed)
    tsi_place_point(part->placement, x);
}

/* ---- gaps --------------------------------------------------------------------------------------
 */

static void evaluate_record(const tsolid_assembly *assembly, int k, int side, double s, double t,
                            double x[3]) {
  const tsi_record *record = &assembly->record[k];
  tsi_patch_point(&record->net[record->net[1].n[0] ? side : 0], s, t, x);
  place_point(&assembly->part[assembly->contact[k].view.part[side]], x);
}

/* The piece at (s,t), whatever its parameters are, and (S,T) on its side. */
static int find_place(const atlas *pieces, const tsolid_interface *view, int side, double s,
                      double t, double at[2]) {
  double uv[2], piece[2], best = INFINITY;
  int found = 0;
  tsi_contact_map(view, side, s, t, uv);
  for (int i = 0; i < pieces->n; i++) {
    const tsolid_placement *place = &pieces->place[i];
    const double *domain = place->domain, *whole = pieces->whole;
    double outside = 0.0;
    for (int d = 0; d < 2; d++) {
      double x = whole[2 * d] + uv[d] * (whole[2 * d + 1] - whole[2 * d]);
      x = (x - domain[2 * d]) / (domain[2 * d + 1] - domain[2 * d]);
      piece[d] = fmin(fmax(x, 0.0), 1.0);
      outside = fmax(outside, fabs(x - piece[d]));
    }
    if (outside >= best)
      continue;
    best = outside;
    found = i;
    to_side(place, piece, at);
  }
  return found;
}

static tsolid_status evaluate_solid(tsolid_context *context, const tsolid_assembly *assembly, int k,
                                    int side, const atlas *pieces, double s, double t,
                                    double x[3]) {
  double u[3], at[2] = {0.0, 0.0};
  const chart *c = pieces->chart;
  if (!pieces->affine)
    c = &pieces->chart[find_place(pieces, &assembly->contact[k].view, side, s, t, at)];
  for (int i = 0; i < pieces->n && pieces->affine; i++) {
    c = &pieces->chart[i];
    at[0] = c->origin[0] + c->ds[0] * s + c->dt[0] * t;
    at[1] = c->origin[1] + c->ds[1] * s + c->dt[1] * t;
    if (in_piece(c, at[0], at[1], box_resolution))
      break;
  }
  int block = tsolid_solid_boundary_point(c->solid, c->number, fmin(fmax(at[0], 0.0), 1.0),
                                          fmin(fmax(at[1], 0.0), 1.0), u);
  tsolid_status status = tsolid_solid_evaluate(context, c->solid, block, u, 0, x);
  place_point(&assembly->part[assembly->contact[k].view.part[side]], x);
  return status;
}

static tsolid_status measure_gap(tsolid_context *context, const tsolid_assembly *assembly, int k,
                                 const atlas pieces[2], tsolid_interface *view) {
  double own = 0.0, largest = 0.0, recorded = 0.0;
  int has_record = view->same_bits == 1 || assembly->record[k].net[1].n[0];
  for (int i = 0; i < N_GRID * N_GRID; i++) {
    double s = (double)(i % N_GRID) / (N_GRID - 1), t = (double)(i / N_GRID) / (N_GRID - 1);
    double x[2][3], y[2][3];
    for (int side = 0; side < 2; side++) {
      tsolid_status status =
          evaluate_solid(context, assembly, k, side, &pieces[side], s, t, x[side]);
      if (status)
        return status;
      if (has_record)
        evaluate_record(assembly, k, side, s, t, y[side]);
      for (int m = 0; m < 3; m++)
        largest = fmax(largest, fabs(x[side][m]));
    }
    own = fmax(own, tsi_distance(x[0], x[1]));
    if (has_record)
      recorded = fmax(recorded, tsi_distance(y[0], y[1]));
  }
  int exponent;
  frexp(largest, &exponent);
  view->gap_after = has_record ? recorded : own;
  view->ulp_after = own / ldexp(DBL_EPSILON, exponent - 1);
  return TSOLID_OK;
}

/* ---- how smooth ---------------------------------------------------------------------------------
 */

/* Degree less multiplicity of the knot at x in [0,1]; -1 where there is none inside. */
static int order_at(const tsolid_patch *patch, int d, double x) {
  const double *knots = patch->knots[d];
  int degree = patch->degree[d], n = patch->n_control[d] + degree + 1, count = 0;
  double low = knots[0], width = knots[n - 1] - low;
  if (x <= box_resolution || x >= 1.0 - box_resolution)
    return -1;
  for (int i = 0; i < n; i++)
    count += fabs((knots[i] - low) / width - x) <= box_resolution;
  return degree - count;
}

/* Across those borders of the contact that lie inside the patch of one side. */
static int find_continuity(const tsolid_assembly *assembly, const tsolid_interface *view,
                           int side) {
  const tsolid_boundary_input *input =
      &assembly->prepared[assembly->part[view->part[side]].prototype];
  int least = -1;
  for (int i = 0; i < 4 && input->patches; i++) {
    const tsolid_patch *patch = &input->patches[view->patch[side]];
    int order = patch->tspline || patch->bezier ? -1 : order_at(patch, i / 2, view->box[side][i]);
    if (order >= 0 && (least < 0 || order < least))
      least = order;
  }
  return least;
}

/* ---- a contact ---------------------------------------------------------------------------------
 */

static tsolid_status compare_contact(tsolid_context *context, const tsolid_assembly *from,
                                     tsolid_assembly *to, int k, const atlas pieces[2],
                                     tsi_arena *work) {
  tsolid_interface *view = &to->contact[k].view;
  tsi_record *record = &to->record[k];
  int one_frame = tsi_share_frame(from, view);
  findings found = {1, one_frame, 0};
  for (int side = 0; side < 2 - one_frame; side++)
    if (!read_net(from, view, side, work, &to->arena, &record->net[side]))
      return tsi_no_memory(context, stage);
  if (one_frame && !record->net[0].n[0]) /* a part that stands as it was given */
    if (!read_net(from, view, 1, work, &to->arena, &record->net[0]))
      return tsi_no_memory(context, stage);
  size_t n = (size_t)record->net[0].n[0] * (size_t)record->net[0].n[1];
  double *sorted = tsi_arena_new(work, n, 4 * sizeof *sorted);
  if (!sorted)
    return tsi_no_memory(context, stage);
  if (n)
    memcpy(sorted, record->net[0].control, 4 * n * sizeof *sorted);
  qsort(sorted, n, 4 * sizeof *sorted, compare_points);
  sorted_net net = {n, sorted};
  if (!compare_sides(pieces, &net, work, &found))
    return tsi_no_memory(context, stage);
  view->same_functions = found.functions;
  view->same_bits = found.bits;
  for (int side = 0; side < 2; side++)
    view->continuity[side] = find_continuity(from, view, side);
  if (!found.functions || (one_frame && !found.bits))
    record->net[0].n[0] = record->net[1].n[0] = 0;
  return measure_gap(context, to, k, pieces, view);
}

static tsolid_status measure_other(tsolid_context *context, tsolid_assembly *to, int k,
                                   const atlas pieces[2]) {
  tsolid_interface *view = &to->contact[k].view;
  view->same_functions = view->same_bits = 0;
  return measure_gap(context, to, k, pieces, view);
}

static tsolid_status join_contact(tsolid_context *context, const tsolid_assembly *from,
                                  tsolid_assembly *to, int k, const tsolid_solid *const *solid) {
  const tsolid_interface *view = &to->contact[k].view;
  tsi_arena work = tsi_arena_create(context);
  atlas pieces[2] = {{.n = 0}, {.n = 0}};
  tsolid_status status = TSOLID_OK;
  int common = tsi_is_watertight(view);
  for (int side = 0; side < 2 && common && !status; side++)
    if (solid[view->part[side]] &&
        !open_atlas(&work, view, side, solid[view->part[side]], &pieces[side]))
      status = tsi_no_memory(context, stage);
  if (!status && pieces[0].n && pieces[1].n) {
    if (pieces[0].affine && pieces[1].affine)
      status = compare_contact(context, from, to, k, pieces, &work);
    else /* other parameters: other functions, and what counts is how far the values are apart */
      status = measure_other(context, to, k, pieces);
  }
  tsi_arena_free(&work);
  return status;
}

/* ---- the new handle ----------------------------------------------------------------------------
 */

static void *copy_array(tsi_arena *arena, const void *from, size_t n, size_t size) {
  void *to = tsi_arena_new(arena, n, size);
  if (to && n)
    memcpy(to, from, n * size);
  return to;
}

/* Parts, contacts and the view; no skins, no trees. */
static int copy_assembly(const tsolid_assembly *from, tsolid_assembly *to) {
  size_t n_parts = (size_t)from->n_parts, n = (size_t)from->n_contacts;
  tsi_arena *arena = &to->arena;
  to->tolerance = from->tolerance;
  to->part = tsi_arena_new(arena, n_parts, sizeof *to->part);
  to->contact = copy_array(arena, from->contact, n, sizeof *to->contact);
  to->record = tsi_arena_new(arena, n, sizeof *to->record);
  tsolid_part_facts *facts = copy_array(arena, from->view.part, n_parts, sizeof *facts);
  tsolid_interface *list = tsi_arena_new(arena, n, sizeof *list);
  to->view = from->view;
  to->view.part = facts;
  to->view.interface = list;
  to->view.clash =
      copy_array(arena, from->view.clash, (size_t)from->view.n_clashes, sizeof *to->view.clash);
  to->view.free_face = copy_array(arena, from->view.free_face, (size_t)from->view.n_free,
                                  sizeof *to->view.free_face);
  if (!to->part || !to->contact || !to->record || !facts || !list || !to->view.clash ||
      !to->view.free_face)
    return 0;
  to->n_parts = from->n_parts;
  to->n_contacts = from->n_contacts;
  for (size_t k = 0; k < n_parts; k++) {
    const tsi_member *part = &from->part[k];
    char *name = copy_array(arena, part->name, strlen(part->name) + 1, 1);
    if (!name)
      return 0;
    to->part[k] = (tsi_member){
        .name = name, .status = part->status, .prototype = part->prototype, .placed = part->placed};
    memcpy(to->part[k].placement, part->placement, sizeof part->placement);
    facts[k].name = name;
  }
  return 1;
}

tsolid_status tsolid_assembly_join(tsolid_context *context, const tsolid_assembly *assembly,
                                   int n_parts, const tsolid_solid *const *solid,
                                   tsolid_assembly **joined) {
  if (joined)
    *joined = NULL;
  if (!context || !joined)
    return TSOLID_ERROR_ARGUMENT;
  if (!assembly || !solid || n_parts != assembly->n_parts || assembly->record)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "One solid per part of an assembly that is not joined yet is expected");
  tsolid_assembly *made = tsi_new(&context->allocator, 1, sizeof *made);
  tsolid_status status = made ? TSOLID_OK : tsi_no_memory(context, stage);
  if (status)
    return status;
  made->allocator = context->allocator;
  made->arena = (tsi_arena){.allocator = &made->allocator};
  if (!copy_assembly(assembly, made))
    status = tsi_no_memory(context, stage);
  for (int k = 0; !status && k < made->n_contacts; k++) {
    status = join_contact(context, assembly, made, k, solid);
    if (!status)
      status = tsi_progress(context, "join", (k + 1.0) / made->n_contacts);
  }
  for (int k = 0; !status && k < made->n_contacts; k++)
    ((tsolid_interface *)(uintptr_t)made->view.interface)[k] = made->contact[k].view;
  for (int k = 0; !status && k < made->n_contacts; k++)
    if (made->contact[k].view.gap_after > made->tolerance &&
        made->view.verdict == TSOLID_ASSEMBLY_WATERTIGHT)
      made->view.verdict = TSOLID_ASSEMBLY_GAPS;
  for (int k = 0; !status && k < n_parts; k++)
    if (!solid[k])
      made->view.verdict = TSOLID_ASSEMBLY_INCOMPLETE;
  if (status)
    tsolid_assembly_free(made);
  else
    *joined = made;
  return status;
}

/* ---- bonds ------------------------------------------------------------------------------------
 */

/* Where a box of (s,t) lies on the side of a chart. */
static void push_box(const chart *c, const double box[4], int side, tsi_bond *bond) {
  bond->side[side] = c->number;
  for (int k = 0; k < 2; k++) {
    int d = c->ds[0] == 0.0 ? 1 - k : k;
    double slope = k ? c->dt[d] : c->ds[d];
    bond->axis[side][k] = d ? tsi_side_t(c->number) : tsi_side_s(c->number);
    bond->from[side][k] = c->origin[d] + slope * box[2 * k];
    bond->to[side][k] = c->origin[d] + slope * box[2 * k + 1];
  }
}

tsolid_status tsi_contact_bonds(tsolid_context *context, tsi_arena *arena,
                                const tsolid_assembly *assembly, int contact,
                                const tsolid_solid *const *solid, int *n, tsi_bond **bond) {
  const tsolid_interface *view = &assembly->contact[contact].view;
  atlas pieces[2];
  *n = 0;
  for (int side = 0; side < 2; side++)
    if (!open_atlas(arena, view, side, solid[view->part[side]], &pieces[side]))
      return tsi_no_memory(context, stage);
  *bond = tsi_arena_new(arena, (size_t)pieces[0].n * (size_t)pieces[1].n, sizeof **bond);
  if (!*bond)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < pieces[0].n && pieces[0].affine && pieces[1].affine; i++)
    for (int j = 0; j < pieces[1].n; j++) {
      const chart *c[2] = {&pieces[0].chart[i], &pieces[1].chart[j]};
      double box[4] = {0.0, 1.0, 0.0, 1.0}, own[4];
      int swap;
      for (int side = 0; side < 2; side++) {
        pull_box(c[side], c[side]->box, own, &swap);
        for (int k = 0; k < 4; k++)
          box[k] = k & 1 ? fmin(box[k], own[k]) : fmax(box[k], own[k]);
      }
      if (box[1] - box[0] <= box_resolution || box[3] - box[2] <= box_resolution)
        continue;
      tsi_bond *to = &(*bond)[(*n)++];
      for (int side = 0; side < 2; side++) {
        to->part[side] = view->part[side];
        push_box(c[side], box, side, to);
      }
    }
  return TSOLID_OK;
}

/* ---- evaluation --------------------------------------------------------------------------------
 */

/* (s,t) of the contact from (p,q) of one side; 0: outside. */
static int find_parameters(const tsolid_interface *view, int side, double p, double q,
                           double st[2]) {
  double x[2] = {p, q};
  for (int d = 0; d < 2; d++) {
    const double *box = view->box[side] + 2 * d;
    if (!(x[d] >= box[0] && x[d] <= box[1]))
      return 0;
    x[d] = (x[d] - box[0]) / (box[1] - box[0]);
    if (side && view->code >> d & 1)
      x[d] = 1.0 - x[d];
  }
  int swap = side && view->code & 4;
  st[0] = x[swap];
  st[1] = x[1 - swap];
  return 1;
}

tsolid_status tsolid_assembly_evaluate(tsolid_context *context, const tsolid_assembly *assembly,
                                       int interface, int side, double p, double q,
                                       double point[3]) {
  double st[2];
  if (!context || !assembly || !point || interface < 0 || interface >= assembly->n_contacts ||
      side < 0 || side > 1)
    return TSOLID_ERROR_ARGUMENT;
  if (!assembly->record || !assembly->record[interface].net[0].n[0])
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "Contact %d has no record", interface);
  if (!find_parameters(&assembly->contact[interface].view, side, p, q, st))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "(%g, %g) is not on contact %d", p, q,
                    interface);
  evaluate_record(assembly, interface, side, st[0], st[1], point);
  return TSOLID_OK;
}
