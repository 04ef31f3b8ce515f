/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Common spaces: inputs for the boundary stage that have the same functions and control points on
 * both sides of every exact, geometric and partial contact, also after that stage's own work.
 *
 * The boundary stage raises degrees round belts and inserts knots into rows along seams. It leaves
 * a patch alone that has the belt's degree and all knots of its neighbours along their seams. So
 * the rules, run until nothing changes:
 *
 *   degrees  one per class of patch directions that seams and contacts join;
 *   contacts both sides have the knots of both on the rectangle, and its borders as lines of full
 *            multiplicity in a patch that goes on beyond them (the surface stays as smooth as it
 *            is there, its functions are continuous only);
 *   seams    a patch with a contact has the knots of its neighbours, as whole lines;
 *   pieces   where borders meet in pieces the same holds for their parts, and the isolines that the
 *            stage cuts patches along are lines of full multiplicity here;
 *   corners  other patches get the line that the stage would give them where both rows at a corner
 *            are refined (see refine_rows.c).
 *
 * Weights get one factor per patch from a forest over seams and contacts. Then control points that
 * stand for one function in several patches are made one: the least of them, so that the choice
 * does not depend on the order of parts; none moves by more than the tolerance, else the contact is
 * not made common. Patches with contacts are marked as fixed: others are snapped to them.
 * Copies are refined through their prototype; contacts between different places share functions,
 * not bits. Contacts with Moebius changes stay as they are: the other parameters would have to
 * go on along the whole belt of one part, and against its other contacts. */
#include <stdlib.h>

#include "assembly.h"
#include "bspline.h"
#include "seams.h"

static const char stage[] = "assembly";

static const double knot_resolution = 1e-11;
static const double weight_resolution = 1e-10;

enum { MOST_KNOTS = 4000, MOST_ROUNDS = 200, MOST_PATCHES = 1000 };

typedef struct draft_skin {
  int has_contact, refinable;
  tsi_patch patch; /* in the prototype's own frame, refined at the end */
  int degree[2], n[2], room[2];
  double *knots[2]; /* of that degree: n of them */
  double log_factor;
} draft_skin;

typedef struct spaces {
  tsolid_context *context;
  tsolid_assembly *assembly;
  tsi_arena *arena;
  draft_skin *draft; /* by skin; prototypes' only */
  int *parent;       /* of directions: 2 * skin + d */
  int changed, failed, no_memory;
  int n_pieces, piece_capacity;
  struct seam_piece *piece;
} spaces;

/* Part of a border against part of another: knots x of `from` are offset + scale x of `to`. */
typedef struct seam_piece {
  int from, to, along_from, along_to;
  double offset, scale;
} seam_piece;

/* The prototype's skin. */
static int origin_of(const tsolid_assembly *assembly, int skin) {
  const tsi_skin *s = &assembly->skin[skin];
  return assembly->part[assembly->part[s->part].prototype].first + s->number;
}

static int is_common(const tsi_contact *contact) {
  const tsolid_interface *v = &contact->view;
  return tsi_is_watertight(v) && v->part[0] != v->part[1] && v->moebius[0] == 1.0 &&
         v->moebius[1] == 1.0;
}

/* ---- seams -------------------------------------------------------------------------------------
 */

static const int low_corner[4] = {0, 1, 3, 0}, high_corner[4] = {1, 2, 2, 3};

/* Whether the parameters along both sides of a seam run against each other. */
static int is_reversed(const tsolid_assembly *assembly, int k, int border) {
  int mate = assembly->skin[k].mate[border];
  const double *low = assembly->skin[k].corner[low_corner[border]];
  const tsi_skin *other = &assembly->skin[mate / 4];
  return tsi_distance(low, other->corner[low_corner[mate % 4]]) >
         tsi_distance(low, other->corner[high_corner[mate % 4]]);
}

/* ---- degrees -----------------------------------------------------------------------------------
 */

static int find_root(int *parent, int i) {
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}

static void join(int *parent, int i, int j) {
  int a = find_root(parent, i), b = find_root(parent, j);
  parent[a > b ? a : b] = a > b ? b : a;
}

static int other_direction(const tsolid_interface *view, int d) {
  return view->code & 4 ? 1 - d : d;
}

static void find_degrees(spaces *s) {
  tsolid_assembly *assembly = s->assembly;
  int n = assembly->n_skins;
  for (int k = 0; k < 2 * n; k++)
    s->parent[k] = k;
  for (int k = 0; k < n; k++)
    for (int b = 0; b < 4; b++)
      if (assembly->skin[k].mate[b] >= 0)
        join(s->parent, 2 * k + (b & 1),
             2 * (assembly->skin[k].mate[b] / 4) + (assembly->skin[k].mate[b] & 1));
  for (int i = 0; i < s->n_pieces; i++)
    join(s->parent, 2 * s->piece[i].from + s->piece[i].along_from,
         2 * s->piece[i].to + s->piece[i].along_to);
  for (int i = 0; i < assembly->n_contacts; i++) {
    const tsi_contact *c = &assembly->contact[i];
    for (int d = 0; d < 2 && is_common(c); d++)
      join(s->parent, 2 * origin_of(assembly, c->skin[0]) + d,
           2 * origin_of(assembly, c->skin[1]) + other_direction(&c->view, d));
  }
  for (int k = 0; k < 2 * n; k++) {
    draft_skin *root = &s->draft[find_root(s->parent, k) / 2];
    int degree = s->draft[k / 2].patch.degree[k % 2], *most = &root->degree[s->parent[k] % 2];
    if (*most < degree)
      *most = degree;
  }
  for (int k = 0; k < 2 * n; k++)
    s->draft[k / 2].degree[k % 2] = s->draft[s->parent[k] / 2].degree[s->parent[k] % 2];
}

/* ---- knots -------------------------------------------------------------------------------------
 */

static int count_near(const draft_skin *draft, int d, double x, int *first) {
  int count = 0;
  *first = 0;
  while (*first < draft->n[d] && draft->knots[d][*first] < x - knot_resolution)
    (*first)++;
  while (*first + count < draft->n[d] && draft->knots[d][*first + count] <= x + knot_resolution)
    count++;
  return count;
}

/* The knot x at least `times` times; that of the patch that is near it stands for it. */
static void need_knot(spaces *s, int skin, int d, double x, int times) {
  draft_skin *draft = &s->draft[skin];
  int at, count = count_near(draft, d, x, &at);
  if (x < knot_resolution || x > 1.0 - knot_resolution || count >= times || !draft->refinable)
    return;
  int more = times - count;
  if (draft->n[d] + more > MOST_KNOTS) {
    s->failed = 1;
    return;
  }
  if (draft->n[d] + more > draft->room[d]) {
    int room = 2 * (draft->n[d] + more);
    double *grown = tsi_arena_new(s->arena, (size_t)room, sizeof *grown);
    if (!grown) {
      s->no_memory = 1;
      return;
    }
    memcpy(grown, draft->knots[d], (size_t)draft->n[d] * sizeof *grown);
    draft->knots[d] = grown;
    draft->room[d] = room;
  }
  double *knots = draft->knots[d];
  double value = count ? knots[at] : 1.0 - (1.0 - x); /* a multiple of 2^-53 */
  memmove(knots + at + more, knots + at, (size_t)(draft->n[d] - at) * sizeof *knots);
  for (int i = 0; i < more; i++)
    knots[at + i] = value;
  draft->n[d] += more;
  s->changed = 1;
}

/* All knots of `from`, through the map offset + scale * x, into `to`, within (0,1) of both. */
static void pass_knots(spaces *s, int from, int d, double offset, double scale, int to, int e) {
  const draft_skin *draft = &s->draft[from];
  for (int i = 0, same; i < draft->n[d]; i += same) {
    double x = draft->knots[d][i], y = offset + scale * x;
    for (same = 1; i + same < draft->n[d] && draft->knots[d][i + same] == x;)
      same++;
    if (x > knot_resolution && x < 1.0 - knot_resolution)
      need_knot(s, to, e, y, same < draft->degree[d] ? same : draft->degree[d]);
  }
}

/* Knots along a seam from the mate's direction. */
static void pass_seam(spaces *s, int k, int border) {
  int mate = s->assembly->skin[k].mate[border], reversed;
  if (mate < 0)
    return;
  reversed = is_reversed(s->assembly, k, border);
  pass_knots(s, mate / 4, mate & 1, reversed ? 1.0 : 0.0, reversed ? -1.0 : 1.0, k, border & 1);
}

/* Knots strictly within the rectangle go to the other side; its borders become lines. */
static void pass_contact(spaces *s, const tsi_contact *c) {
  const tsolid_interface *view = &c->view;
  int skin[2] = {origin_of(s->assembly, c->skin[0]), origin_of(s->assembly, c->skin[1])};
  for (int side = 0; side < 2; side++)
    for (int d = 0; d < 2; d++) {
      int e = other_direction(view, d), flip = view->code >> (side ? d : e) & 1;
      const double *from = view->box[side] + 2 * d, *to = view->box[1 - side] + 2 * e;
      const draft_skin *draft = &s->draft[skin[side]];
      int degree = draft->degree[d];
      for (int k = 0; k < 2; k++)
        need_knot(s, skin[side], d, from[k], degree);
      for (int i = 0, same; i < draft->n[d]; i += same) {
        double x = (draft->knots[d][i] - from[0]) / (from[1] - from[0]);
        for (same = 1; i + same < draft->n[d] && draft->knots[d][i + same] == draft->knots[d][i];)
          same++;
        if (x < knot_resolution || x > 1.0 - knot_resolution)
          continue;
        x = flip ? 1.0 - x : x;
        need_knot(s, skin[1 - side], e, to[0] + x * (to[1] - to[0]), same);
      }
    }
}

/* The knot next to an end, own and united with the mate's. */
static void find_end_knots(const spaces *s, int k, int border, int high, double *own,
                           double *united) {
  int mate = s->assembly->skin[k].mate[border], d = border & 1;
  const draft_skin *draft = &s->draft[k];
  *own = draft->knots[d][high ? draft->n[d] - draft->degree[d] - 2 : draft->degree[d] + 1];
  *united = *own;
  if (mate < 0)
    return;
  const draft_skin *other = &s->draft[mate / 4];
  int e = mate & 1, reversed = is_reversed(s->assembly, k, border), end = high ^ reversed;
  double x = other->knots[e][end ? other->n[e] - other->degree[e] - 2 : other->degree[e] + 1];
  x = reversed ? 1.0 - x : x;
  if (fabs(x - *own) > knot_resolution && (high ? x > *own : x < *own))
    *united = x;
}

/* As the boundary stage's own rule for corners. */
static void settle_corner(spaces *s, int k, int corner) {
  int u_high = corner == 1 || corner == 2, v_high = corner >= 2;
  double own[2], united[2];
  find_end_knots(s, k, v_high ? 2 : 0, u_high, &own[0], &united[0]);
  find_end_knots(s, k, u_high ? 1 : 3, v_high, &own[1], &united[1]);
  if (own[0] == united[0] || own[1] == united[1])
    return;
  const draft_skin *draft = &s->draft[k];
  int along = draft->n[0] - draft->degree[0] < draft->n[1] - draft->degree[1];
  need_knot(s, k, along, united[along], 1);
}

/* ---- borders that meet in pieces ---------------------------------------------------------------
 */

/* The parameter of x along a border of the skin; 0: x is not on it. */
static int find_on_border(const tsi_skin *skin, int border, const double x[3], double *at) {
  tsi_foot foot;
  if (!tsi_in_box(skin->box, x, skin->tolerance))
    return 0;
  tsi_foot_find(skin, x, NULL, &foot);
  double across = foot.uv[1 - (border & 1)], end = border == 1 || border == 2 ? 1.0 : 0.0;
  *at = foot.uv[border & 1];
  if (fabs(*at - ldexp(round(ldexp(*at, 20)), -20)) < 1e-10)
    *at = ldexp(round(ldexp(*at, 20)), -20);
  return foot.distance <= skin->tolerance && fabs(across - end) <= 1e-7;
}

/* The boundary stage cuts patches along isolines where others end on their borders: the same lines,
 * and where they lead, are known here before. */
static void cut_at(spaces *s, const tsi_member *part, const double x[3], int depth) {
  if (depth > 64 || s->failed || s->no_memory)
    return;
  for (int k = part->first; k < part->end; k++)
    for (int b = 0; b < 4; b++) {
      const tsi_skin *skin = &s->assembly->skin[k];
      double at, far[3], uv[2];
      int d = b & 1, first;
      if (!find_on_border(skin, b, x, &at) || at < 1e-7 || at > 1.0 - 1e-7 ||
          count_near(&s->draft[k], d, at, &first) >= s->draft[k].degree[d])
        continue;
      need_knot(s, k, d, at, s->draft[k].degree[d]);
      uv[d] = at;
      uv[1 - d] = b == 1 || b == 2 ? 0.0 : 1.0;
      tsi_skin_point(skin, uv[0], uv[1], far);
      if (s->draft[k].refinable)
        cut_at(s, part, far, depth + 1);
    }
}

static void add_piece(spaces *s, seam_piece piece) {
  if (s->n_pieces == s->piece_capacity) {
    int capacity = 2 * s->piece_capacity + 16;
    seam_piece *grown = tsi_arena_new(s->arena, (size_t)capacity, sizeof *grown);
    if (!grown) {
      s->no_memory = 1;
      return;
    }
    if (s->n_pieces)
      memcpy(grown, s->piece, (size_t)s->n_pieces * sizeof *grown);
    s->piece = grown;
    s->piece_capacity = capacity;
  }
  s->piece[s->n_pieces++] = piece;
}

/* Border c of skin m against border b of skin k, one of them within the other. */
static void find_piece(spaces *s, int k, int b, int m, int c) {
  const tsi_skin *to = &s->assembly->skin[k], *from = &s->assembly->skin[m];
  double x[2];
  if (find_on_border(to, b, from->corner[low_corner[c]], &x[0]) &&
      find_on_border(to, b, from->corner[high_corner[c]], &x[1]) && fabs(x[1] - x[0]) > 1e-7)
    add_piece(s, (seam_piece){m, k, c & 1, b & 1, x[0], x[1] - x[0]});
  else if (find_on_border(from, c, to->corner[low_corner[b]], &x[0]) &&
           find_on_border(from, c, to->corner[high_corner[b]], &x[1]) && fabs(x[1] - x[0]) > 1e-7)
    add_piece(s, (seam_piece){m, k, c & 1, b & 1, -x[0] / (x[1] - x[0]), 1.0 / (x[1] - x[0])});
}

/* Of parts whose borders do not all meet as wholes. */
static int meets_in_pieces(const spaces *s, int p) {
  return !s->assembly->part[p].closed && s->assembly->part[p].prototype == p;
}

static void find_pieces(spaces *s) {
  const tsolid_assembly *assembly = s->assembly;
  for (int p = 0; p < assembly->n_parts; p++) {
    const tsi_member *part = &assembly->part[p];
    int n = part->end - part->first;
    n = meets_in_pieces(s, p) && n <= MOST_PATCHES ? 4 * n : 0; /* every border against every one */
    for (int i = 0; i < n * n; i++) {
      int k = part->first + i / n / 4, b = i / n % 4, m = part->first + i % n / 4, c = i % 4;
      if (m != k && assembly->skin[k].mate[b] == -1 && assembly->skin[m].mate[c] == -1)
        find_piece(s, k, b, m, c);
    }
  }
}

static void cut_patches(spaces *s) {
  const tsolid_assembly *assembly = s->assembly;
  for (int p = 0; p < assembly->n_parts; p++)
    for (int k = assembly->part[p].first; meets_in_pieces(s, p) && k < assembly->part[p].end; k++)
      for (int c = 0; c < 4; c++)
        cut_at(s, &assembly->part[p], assembly->skin[k].corner[c], 0);
}

static void spread_knots(spaces *s) {
  const tsolid_assembly *assembly = s->assembly;
  s->changed = 1;
  for (int round = 0; s->changed && !s->failed && !s->no_memory; round++) {
    s->changed = 0;
    if (round == MOST_ROUNDS)
      s->failed = 1;
    for (int i = 0; i < assembly->n_contacts; i++)
      if (is_common(&assembly->contact[i]))
        pass_contact(s, &assembly->contact[i]);
    for (int i = 0; i < s->n_pieces; i++)
      if (s->draft[s->piece[i].to].has_contact)
        pass_knots(s, s->piece[i].from, s->piece[i].along_from, s->piece[i].offset,
                   s->piece[i].scale, s->piece[i].to, s->piece[i].along_to);
    for (int k = 0; k < assembly->n_skins; k++) {
      for (int b = 0; b < 4 && s->draft[k].has_contact; b++)
        pass_seam(s, k, b);
      for (int b = 0; b < 4 && !s->draft[k].has_contact && s->draft[k].refinable; b++)
        settle_corner(s, k, b);
    }
  }
}

/* ---- drafts ------------------------------------------------------------------------------------
 */

static int begin_skin(spaces *s, int k) {
  draft_skin *draft = &s->draft[k];
  const tsi_patch *patch = &draft->patch;
  for (int d = 0; d < 2; d++) {
    int n = patch->n[d] + patch->degree[d] + 1, raise = draft->degree[d] - patch->degree[d];
    if (!draft->refinable)
      raise = 0;
    draft->room[d] = n * (raise + 1) + 16;
    draft->knots[d] = tsi_arena_new(s->arena, (size_t)draft->room[d], sizeof(double));
    if (!draft->knots[d])
      return 0;
    for (int i = 0; i < n; i++) {
      int first = i == 0 || patch->knots[d][i] != patch->knots[d][i - 1];
      for (int m = 0; m < (first ? 1 + raise : 1); m++)
        draft->knots[d][draft->n[d]++] = patch->knots[d][i];
    }
    if (!draft->refinable)
      draft->degree[d] = patch->degree[d];
  }
  return 1;
}

static int refine_skin(spaces *s, int k) {
  draft_skin *draft = &s->draft[k];
  for (int d = 0; d < 2; d++) {
    int raise = draft->degree[d] - draft->patch.degree[d];
    if (draft->n[d] == draft->patch.n[d] + draft->patch.degree[d] + 1 && !raise)
      continue;
    if (!tsi_patch_refine(s->arena, &draft->patch, d, raise, draft->n[d] - draft->degree[d] - 1,
                          draft->knots[d]))
      return 0;
  }
  return 1;
}

/* ---- weights -----------------------------------------------------------------------------------
 */

/* Control points first .. last of direction d lie on [low, high]. */
static void find_range(const tsi_patch *patch, int d, double low, double high, int range[2]) {
  range[0] = 0;
  range[1] = patch->n[d] - 1;
  while (low > 0.0 && patch->knots[d][range[0] + 1] < low - knot_resolution)
    range[0]++;
  if (high < 1.0)
    for (range[1] = range[0];
         range[1] + 1 < patch->n[d] && patch->knots[d][range[1] + 1] < high - knot_resolution;)
      range[1]++;
}

/* Pairs of control points of a contact: entry i of the one is entry other[i] of the other. */
typedef struct pairing {
  int range[2][2][2]; /* side, direction */
  int n[2];           /* of side 0's directions */
} pairing;

static int pair_contact(const spaces *s, const tsi_contact *c, pairing *p) {
  for (int side = 0; side < 2; side++) {
    const tsi_patch *patch = &s->draft[origin_of(s->assembly, c->skin[side])].patch;
    for (int d = 0; d < 2; d++)
      find_range(patch, d, c->view.box[side][2 * d], c->view.box[side][2 * d + 1],
                 p->range[side][d]);
  }
  for (int d = 0; d < 2; d++) {
    int e = other_direction(&c->view, d);
    const int *a = p->range[0][d], *b = p->range[1][e];
    p->n[d] = a[1] - a[0] + 1;
    if (p->n[d] != b[1] - b[0] + 1)
      return 0;
  }
  return 1;
}

static void pair_at(const spaces *s, const tsi_contact *c, const pairing *p, int i, int j,
                    size_t at[2]) {
  int code = c->view.code, x[2] = {i, j}, y[2];
  for (int d = 0; d < 2; d++) {
    int e = other_direction(&c->view, d);
    y[e] = code >> e & 1 ? p->range[1][e][1] - x[d] : p->range[1][e][0] + x[d];
    x[d] += p->range[0][d][0];
  }
  at[0] =
      (size_t)x[0] + (size_t)s->draft[origin_of(s->assembly, c->skin[0])].patch.n[0] * (size_t)x[1];
  at[1] =
      (size_t)y[0] + (size_t)s->draft[origin_of(s->assembly, c->skin[1])].patch.n[0] * (size_t)y[1];
}

/* Control point m of a border, in the direction of its parameter. */
static size_t border_point(const tsi_patch *patch, int border, int m) {
  size_t n0 = (size_t)patch->n[0], n1 = (size_t)patch->n[1], at = (size_t)m;
  return border == 0   ? at
         : border == 1 ? n0 - 1 + n0 * at
         : border == 2 ? at + n0 * (n1 - 1)
                       : n0 * at;
}

/* Weights at one corner of a seam: this patch's over the mate's. */
static double seam_ratio(const spaces *s, int k, int border) {
  int mate = s->assembly->skin[k].mate[border], reversed = is_reversed(s->assembly, k, border);
  const tsi_patch *a = &s->draft[k].patch, *b = &s->draft[mate / 4].patch;
  int last = b->n[mate & 1] - 1;
  return a->control[4 * border_point(a, border, 0) + 3] /
         b->control[4 * border_point(b, mate % 4, reversed ? last : 0) + 3];
}

static double log_of(double ratio) {
  return fabs(ratio - 1.0) <= weight_resolution ? 0.0 : log(ratio);
}

static int match_weights(spaces *s) {
  tsolid_assembly *assembly = s->assembly;
  tsi_ratios ratios;
  pairing p;
  if (!tsi_ratios_create(s->arena, assembly->n_skins, &ratios))
    return 0;
  for (int k = 0; k < assembly->n_skins; k++)
    for (int b = 0; b < 4; b++)
      if (assembly->skin[k].mate[b] >= 0)
        tsi_ratios_join(&ratios, k, assembly->skin[k].mate[b] / 4, log_of(seam_ratio(s, k, b)));
  for (int i = 0; i < assembly->n_contacts; i++) {
    const tsi_contact *c = &assembly->contact[i];
    size_t at[2];
    if (!is_common(c) || !pair_contact(s, c, &p))
      continue;
    int a = origin_of(assembly, c->skin[0]), b = origin_of(assembly, c->skin[1]);
    pair_at(s, c, &p, 0, 0, at);
    tsi_ratios_join(&ratios, a, b,
                    log_of(s->draft[a].patch.control[4 * at[0] + 3] /
                           s->draft[b].patch.control[4 * at[1] + 3]));
  }
  for (int k = 0; k < assembly->n_skins; k++)
    tsi_ratios_find(&ratios, k, &s->draft[k].log_factor);
  return 1;
}

/* ---- common control points ---------------------------------------------------------------------
 */

typedef struct points {
  size_t *first; /* of each skin */
  double *value; /* Euclidean, and the weight: rows of 4 */
  int *parent, *best;
} points;

static int open_points(spaces *s, points *p) {
  const tsolid_assembly *assembly = s->assembly;
  size_t n = 0;
  p->first = tsi_arena_new(s->arena, (size_t)assembly->n_skins + 1, sizeof *p->first);
  if (!p->first)
    return 0;
  for (int k = 0; k < assembly->n_skins; k++) {
    p->first[k] = n;
    n += (size_t)s->draft[k].patch.n[0] * (size_t)s->draft[k].patch.n[1];
  }
  p->first[assembly->n_skins] = n;
  if (n > TSI_MAX_COUNT / 4)
    return 0;
  p->value = tsi_arena_new(s->arena, n, 4 * sizeof *p->value);
  p->parent = tsi_arena_new(s->arena, n, sizeof *p->parent);
  p->best = tsi_arena_new(s->arena, n, sizeof *p->best);
  if (!p->value || !p->parent || !p->best)
    return 0;
  for (int k = 0; k < assembly->n_skins; k++) {
    const double *h = s->draft[k].patch.control;
    double factor = exp(s->draft[k].log_factor);
    for (size_t i = p->first[k]; i < p->first[k + 1]; i++, h += 4) {
      tsi_project_point(h, p->value + 4 * i);
      p->value[4 * i + 3] = h[3] * factor;
    }
  }
  for (size_t i = 0; i < n; i++)
    p->parent[i] = p->best[i] = (int)i;
  return 1;
}

static void join_contact(const spaces *s, const points *p, const tsi_contact *c) {
  pairing pairs;
  if (!is_common(c) || !tsi_share_frame(s->assembly, &c->view) || !pair_contact(s, c, &pairs))
    return;
  for (int j = 0; j < pairs.n[1]; j++)
    for (int i = 0; i < pairs.n[0]; i++) {
      size_t at[2];
      pair_at(s, c, &pairs, i, j, at);
      join(p->parent, (int)(p->first[c->skin[0]] + at[0]), (int)(p->first[c->skin[1]] + at[1]));
    }
}

/* Rows of two patches with contacts that have the same knots along their seam. */
static void join_seam(const spaces *s, const points *p, int k, int border) {
  int mate = s->assembly->skin[k].mate[border], m = mate / 4;
  if (mate < 0 || !s->draft[k].has_contact || !s->draft[m].has_contact)
    return;
  const tsi_patch *a = &s->draft[k].patch, *b = &s->draft[m].patch;
  int d = border & 1, e = mate & 1, n = a->n[d], reversed = is_reversed(s->assembly, k, border);
  if (n != b->n[e] || a->degree[d] != b->degree[e])
    return;
  for (int i = 0; i < n; i++)
    join(p->parent, (int)(p->first[k] + border_point(a, border, i)),
         (int)(p->first[m] + border_point(b, mate % 4, reversed ? n - 1 - i : i)));
}

static int is_less(const double *a, const double *b) {
  for (int c = 0; c < 4; c++)
    if (a[c] != b[c])
      return a[c] < b[c];
  return 0;
}

/* Whether the part's points are as they were given: all of its patches must be refinable. */
static int stands(const spaces *s, int k) {
  const tsi_member *part = &s->assembly->part[s->assembly->skin[k].part];
  for (int i = part->first; i < part->end; i++)
    if (!s->draft[i].refinable)
      return 1;
  return 0;
}

/* Every group takes its least point, one of a part that stands as it is if there is any, unless
 * that is farther than the tolerance. */
static int unite_points(spaces *s, points *p) {
  const tsolid_assembly *assembly = s->assembly;
  size_t n = p->first[assembly->n_skins];
  for (int i = 0; i < assembly->n_contacts; i++)
    join_contact(s, p, &assembly->contact[i]);
  for (int k = 0; k < assembly->n_skins; k++)
    for (int b = 0; b < 4; b++)
      join_seam(s, p, k, b);
  unsigned char *stays = tsi_arena_new(s->arena, n, 1);
  if (!stays)
    return 0;
  for (int k = 0; k < assembly->n_skins; k++)
    if (s->draft[k].has_contact && stands(s, k))
      memset(stays + p->first[k], 1, p->first[k + 1] - p->first[k]);
  for (size_t i = 0; i < n; i++) {
    int *best = &p->best[find_root(p->parent, (int)i)];
    int better = is_less(p->value + 4 * i, p->value + 4 * (size_t)*best);
    if (stays[i] != stays[*best] ? stays[i] : better)
      *best = (int)i;
  }
  for (int k = 0; k < assembly->n_skins; k++)
    for (size_t i = p->first[k]; i < p->first[k + 1]; i++) {
      const double *to = p->value + 4 * (size_t)p->best[find_root(p->parent, (int)i)];
      double *own = p->value + 4 * i;
      if (to != own && tsi_distance(own, to) <= assembly->skin[k].tolerance &&
          fabs(own[3] / to[3] - 1.0) <= 1e-8)
        memcpy(own, to, 4 * sizeof *own);
    }
  return 1;
}

/* ---- inputs ------------------------------------------------------------------------------------
 */

static tsolid_status write_patch(spaces *s, const points *p, int k, tsolid_patch *to) {
  const tsi_patch *patch = &s->draft[k].patch;
  size_t n = p->first[k + 1] - p->first[k];
  double *x = tsi_arena_new(&s->assembly->arena, n, 3 * sizeof *x);
  double *w = tsi_arena_new(&s->assembly->arena, n, sizeof *w);
  int rational = 0;
  *to = s->assembly->skin[k].source;
  for (int d = 0; d < 2; d++) {
    size_t n_knots = (size_t)(patch->n[d] + patch->degree[d] + 1);
    double *knots = tsi_arena_new(&s->assembly->arena, n_knots, sizeof *knots);
    if (!knots)
      return tsi_no_memory(s->context, stage);
    memcpy(knots, patch->knots[d], n_knots * sizeof *knots);
    to->degree[d] = patch->degree[d];
    to->n_control[d] = patch->n[d];
    to->knots[d] = knots;
  }
  if (!x || !w)
    return tsi_no_memory(s->context, stage);
  for (size_t i = 0; i < n; i++) {
    const double *value = p->value + 4 * (p->first[k] + i);
    memcpy(x + 3 * i, value, 3 * sizeof *x);
    w[i] = value[3];
    rational |= w[i] != 1.0;
  }
  to->points = x;
  to->weights = rational ? w : NULL;
  to->fixed = s->draft[k].has_contact;
  return TSOLID_OK;
}

static tsolid_status write_inputs(spaces *s, const points *p) {
  tsolid_assembly *assembly = s->assembly;
  for (int k = 0; k < assembly->n_parts; k++) {
    const tsi_member *part = &assembly->part[k];
    int n = part->end - part->first, refinable = n > 0 && part->prototype == k;
    for (int i = part->first; i < part->end; i++)
      refinable = refinable && s->draft[i].refinable;
    if (!refinable)
      continue;
    tsolid_patch *patch = tsi_arena_new(&assembly->arena, (size_t)n, sizeof *patch);
    if (!patch)
      return tsi_no_memory(s->context, stage);
    for (int i = 0; i < n; i++) {
      tsolid_status status = write_patch(s, p, part->first + i, &patch[i]);
      if (status)
        return status;
    }
    assembly->prepared[k] = (tsolid_boundary_input){
        .n_patches = n, .patches = patch, .n_smooth = part->n_smooth, .smooth = part->smooth};
  }
  return TSOLID_OK;
}

/* ---- driver ------------------------------------------------------------------------------------
 */

static void begin_drafts(spaces *s) {
  tsolid_assembly *assembly = s->assembly;
  for (int k = 0; k < assembly->n_skins; k++) {
    s->draft[k].patch = assembly->skin[k].own;
    s->draft[k].refinable = assembly->skin[k].refinable;
  }
  for (int i = 0; i < assembly->n_contacts; i++)
    for (int side = 0; side < 2 && is_common(&assembly->contact[i]); side++)
      s->draft[origin_of(assembly, assembly->contact[i].skin[side])].has_contact = 1;
}

tsolid_status tsi_assembly_prepare(tsolid_context *context, tsolid_assembly *assembly) {
  tsi_arena work = tsi_arena_create(context);
  size_t n = (size_t)assembly->n_skins;
  spaces s = {.context = context, .assembly = assembly, .arena = &work};
  points p = {.first = NULL};
  int done;
  s.draft = tsi_arena_new(&work, n, sizeof *s.draft);
  s.parent = tsi_arena_new(&work, 2 * n, sizeof *s.parent);
  assembly->prepared =
      tsi_arena_new(&assembly->arena, (size_t)assembly->n_parts, sizeof *assembly->prepared);
  done = s.draft && s.parent && assembly->prepared;
  if (done) {
    begin_drafts(&s);
    find_pieces(&s);
    find_degrees(&s);
  }
  for (int k = 0; done && k < assembly->n_skins; k++)
    done = begin_skin(&s, k);
  if (done) {
    cut_patches(&s);
    spread_knots(&s);
  }
  done = done && !s.no_memory;
  for (int k = 0; done && k < assembly->n_skins; k++)
    done = refine_skin(&s, k);
  done = done && match_weights(&s) && open_points(&s, &p);
  tsolid_status status = done ? TSOLID_OK : tsi_no_memory(context, stage);
  if (!status && !unite_points(&s, &p))
    status = tsi_no_memory(context, stage);
  if (!status)
    status = write_inputs(&s, &p);
  if (!status && s.failed) {
    tsolid_finding finding = tsi_finding(TSOLID_WARNING, TSOLID_OK, stage);
    tsi_report(context, &finding,
               "Contacts ask for too many knots: not all of them get the same functions");
  }
  tsi_arena_free(&work);
  return status;
}
