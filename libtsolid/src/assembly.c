/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The assembly handle, and the way from parts to contacts, clashes and the verdict. The driver
 * stands last.
 *
 * Candidates are pairs of patches whose boxes meet within the search distance: n log n by the tree
 * over all boxes. A pair is matched first (exact, geometric, partial), and measured where it does
 * not match (coincident, near). A near pair counts only when nothing lies between: no part holds
 * the point half way where both are nearest. */
#include <stdlib.h>

#include "assembly.h"
#include "bvh.h"

static const char stage[] = "assembly";

static const double default_tolerance = 1e-7;
static const double default_gap = 0.01; /* of the smaller part's diagonal */

/* ---- the handle --------------------------------------------------------------------------------
 */

void tsolid_assembly_free(tsolid_assembly *assembly) {
  if (!assembly)
    return;
  tsi_allocator allocator = assembly->allocator;
  for (int k = 0; k < assembly->n_parts; k++)
    tsi_bvh_free(assembly->part[k].bvh);
  tsi_bvh_free(assembly->bvh);
  tsi_arena_free(&assembly->arena);
  tsi_delete(&allocator, assembly);
}

void tsolid_assembly_get(const tsolid_assembly *assembly, tsolid_assembly_view *view) {
  *view = assembly->view;
}

const tsolid_boundary_input *tsolid_assembly_boundary_input(const tsolid_assembly *assembly,
                                                            int part) {
  if (!assembly || part < 0 || part >= assembly->n_parts || !assembly->prepared)
    return NULL;
  const tsolid_boundary_input *input = &assembly->prepared[assembly->part[part].prototype];
  return input->patches ? input : NULL;
}

int tsi_share_frame(const tsolid_assembly *assembly, const tsolid_interface *view) {
  const tsi_member *a = &assembly->part[view->part[0]], *b = &assembly->part[view->part[1]];
  return a->prototype == view->part[0] && b->prototype == view->part[1] &&
         memcmp(a->placement, b->placement, sizeof a->placement) == 0;
}

int tsi_is_watertight(const tsolid_interface *view) {
  return view->kind <= TSOLID_CONTACT_PARTIAL && !view->same_side;
}

int tsi_in_box(const double box[6], const double x[3], double margin) {
  for (int c = 0; c < 3; c++)
    if (x[c] < box[c] - margin || x[c] > box[3 + c] + margin)
      return 0;
  return 1;
}

void tsi_place_point(const double m[12], double x[3]) {
  double y[3];
  for (int c = 0; c < 3; c++)
    y[c] = m[4 * c] * x[0] + m[4 * c + 1] * x[1] + m[4 * c + 2] * x[2] + m[4 * c + 3];
  memcpy(x, y, sizeof y);
}

/* ---- pairs -------------------------------------------------------------------------------------
 */

typedef struct pair_search {
  tsolid_context *context;
  tsolid_assembly *assembly;
  int a, n, capacity;
  int *list;
} pair_search;

static int add_pair(void *data, int b) {
  pair_search *s = data;
  if (b <= s->a)
    return 0;
  if (s->n == s->capacity)
    return 1;
  s->list[s->n++] = b;
  return 0;
}

static int compare_ints(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

static double find_reach(const tsolid_assembly *assembly, int a, int b) {
  const tsi_member *p = &assembly->part[assembly->skin[a].part];
  const tsi_member *q = &assembly->part[assembly->skin[b].part];
  return assembly->gap > 0.0 ? assembly->gap : default_gap * fmin(p->size, q->size);
}

/* Outward normals agree, from the orientation code and both sides' own. */
static int is_same_side(const tsolid_assembly *assembly, const tsi_contact *contact) {
  int code = contact->view.code, odd = (code ^ code >> 1 ^ code >> 2) & 1;
  int a = assembly->skin[contact->skin[0]].outward, b = assembly->skin[contact->skin[1]].outward;
  return a != 0 && a == (odd ? -b : b);
}

typedef struct holder {
  const tsolid_assembly *assembly;
  const double *point;
  int held;
} holder;

static int test_holder(void *data, int item) {
  holder *h = data;
  const tsi_member *part = &h->assembly->part[h->assembly->skin[item].part];
  h->held |= tsi_inside(part, h->point);
  return h->held;
}

/* A part that holds x, among those with a patch near x. */
static int is_held(const tsolid_assembly *assembly, const double x[3], double reach) {
  holder h = {assembly, x, 0};
  tsi_bvh_containing(assembly->bvh, x, reach, test_holder, &h);
  return h.held;
}

/* Both are nearer than they look: through a thin part, or one of them. */
static int is_hidden(const tsolid_assembly *assembly, tsi_contact *contact, double reach) {
  tsolid_interface *view = &contact->view;
  const tsi_member *part[2] = {&assembly->part[view->part[0]], &assembly->part[view->part[1]]};
  double bend = fmax(part[0]->bend, part[1]->bend);
  if (view->depth > 2.0 * bend &&
      !(tsi_inside(part[0], contact->deepest) && tsi_inside(part[1], contact->deepest)))
    return 1;
  return view->depth == 0.0 && view->smallest_gap > 2.0 * bend &&
         is_held(assembly, contact->middle, reach);
}

static tsolid_status store_contact(tsolid_context *context, tsolid_assembly *assembly,
                                   const tsi_contact *contact) {
  if (assembly->n_contacts == assembly->contact_capacity) {
    int capacity = 2 * assembly->contact_capacity + 64;
    tsi_contact *grown = tsi_arena_new(&assembly->arena, (size_t)capacity, sizeof *grown);
    if (!grown)
      return tsi_no_memory(context, stage);
    if (assembly->n_contacts)
      memcpy(grown, assembly->contact, (size_t)assembly->n_contacts * sizeof *grown);
    assembly->contact = grown;
    assembly->contact_capacity = capacity;
  }
  assembly->contact[assembly->n_contacts++] = *contact;
  return TSOLID_OK;
}

static tsolid_status store_match(tsolid_context *context, tsolid_assembly *assembly,
                                 tsi_contact *contact) {
  double uv[2];
  contact->view.same_side = is_same_side(assembly, contact);
  contact->view.gap = contact->view.deviation;
  tsi_contact_map(&contact->view, 0, 0.5, 0.5, uv);
  tsi_skin_point(&assembly->skin[contact->skin[0]], uv[0], uv[1], contact->view.point);
  return store_contact(context, assembly, contact);
}

static tsolid_status test_skins(tsolid_context *context, tsolid_assembly *assembly, int a, int b) {
  tsi_contact contact[TSI_MOST_RECTANGLES];
  int n_found = 0, same_part = assembly->skin[a].part == assembly->skin[b].part;
  double reach = find_reach(assembly, a, b);
  tsolid_status status = tsi_match_skins(context, assembly, a, b, contact, &n_found);
  for (int k = 0; !status && k < n_found; k++)
    status = store_match(context, assembly, &contact[k]);
  if (status || n_found || same_part)
    return status;
  tsi_measure_gap(assembly, a, b, reach, contact, &n_found);
  if (!n_found || is_hidden(assembly, contact, reach))
    return TSOLID_OK;
  return store_contact(context, assembly, contact);
}

static tsolid_status find_contacts(tsolid_context *context, tsolid_assembly *assembly) {
  pair_search s = {.context = context, .assembly = assembly, .capacity = assembly->n_skins};
  tsi_arena work = tsi_arena_create(context);
  s.list = tsi_arena_new(&work, (size_t)assembly->n_skins, sizeof *s.list);
  tsolid_status status = s.list ? TSOLID_OK : tsi_no_memory(context, stage);
  for (s.a = 0; !status && s.a < assembly->n_skins; s.a++) {
    const tsi_skin *skin = &assembly->skin[s.a];
    double size = assembly->part[skin->part].size;
    double reach = assembly->gap > 0.0 ? assembly->gap : default_gap * size;
    s.n = 0;
    tsi_bvh_overlapping(assembly->bvh, skin->box, fmax(reach, skin->tolerance), add_pair, &s);
    qsort(s.list, (size_t)s.n, sizeof *s.list, compare_ints);
    for (int k = 0; !status && k < s.n; k++)
      status = test_skins(context, assembly, s.a, s.list[k]);
    if (!status && s.a % 64 == 0)
      status = tsi_progress(context, stage, 0.4 + 0.3 * s.a / assembly->n_skins);
  }
  tsi_arena_free(&work);
  return status;
}

/* ---- driver ------------------------------------------------------------------------------------
 */

/* The middle of everything: fluxes about it cancel least. */
static void find_origin(tsolid_assembly *assembly) {
  double box[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
  double least = INFINITY, most = 0.0;
  for (int k = 0; k < assembly->n_parts; k++) {
    const tsi_member *part = &assembly->part[k];
    if (part->status)
      continue;
    for (int c = 0; c < 3; c++) {
      box[c] = fmin(box[c], part->box[c]);
      box[3 + c] = fmax(box[3 + c], part->box[3 + c]);
      assembly->scale = fmax(assembly->scale, fmax(fabs(part->box[c]), fabs(part->box[3 + c])));
    }
    least = fmin(least, part->size);
    most = fmax(most, part->size);
  }
  for (int c = 0; c < 3 && most > 0.0; c++)
    assembly->origin[c] = box[c] + 0.5 * (box[3 + c] - box[c]);
}

/* Parts of which one is a thousand times another: millimetres beside metres? */
static void warn_of_units(tsolid_context *context, const tsolid_assembly *assembly) {
  int small = -1, large = -1;
  for (int k = 0; k < assembly->n_parts; k++) {
    if (assembly->part[k].status)
      continue;
    if (small < 0 || assembly->part[k].size < assembly->part[small].size)
      small = k;
    if (large < 0 || assembly->part[k].size > assembly->part[large].size)
      large = k;
  }
  if (small < 0 || assembly->part[large].size < 500.0 * assembly->part[small].size)
    return;
  tsolid_finding finding = tsi_finding(TSOLID_WARNING, TSOLID_OK, stage);
  finding.measured = assembly->part[large].size / assembly->part[small].size;
  tsi_report(context, &finding, "%s is %.4g times as large as %s: are their units the same?",
             assembly->part[large].name, finding.measured, assembly->part[small].name);
}

static void tell_clashes(tsolid_context *context, const tsolid_assembly *assembly) {
  for (int k = 0; k < assembly->view.n_clashes; k++) {
    const tsolid_clash *c = &assembly->view.clash[k];
    const char *a = assembly->part[c->part[0]].name, *b = assembly->part[c->part[1]].name;
    tsolid_finding finding = tsi_finding(TSOLID_WARNING, TSOLID_OK, stage);
    finding.has_point = 1;
    finding.measured = c->depth;
    memcpy(finding.point, c->point, sizeof finding.point);
    if (c->kind == TSOLID_CLASH_SELF)
      tsi_report(context, &finding, "%s touches itself near (%.6g, %.6g, %.6g)", a, c->point[0],
                 c->point[1], c->point[2]);
    else if (c->kind == TSOLID_CLASH_TWICE)
      tsi_report(context, &finding, "%s and %s are the same part twice in the same place", a, b);
    else if (c->kind == TSOLID_CLASH_INSIDE)
      tsi_report(context, &finding, "%s lies inside %s, %.3g deep near (%.6g, %.6g, %.6g)", a, b,
                 c->depth, c->point[0], c->point[1], c->point[2]);
    else
      tsi_report(context, &finding, "%s and %s overlap by %.3g near (%.6g, %.6g, %.6g)", a, b,
                 c->depth, c->point[0], c->point[1], c->point[2]);
  }
}

static tsolid_status check_arguments(tsolid_context *context, const tsolid_assembly_input *input,
                                     const tsolid_assembly_options *options) {
  if (!input || input->n_parts < 1 || input->n_parts > TSI_MAX_COUNT / 256 || !input->parts)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "There are no parts, or too many");
  if (!(options->tolerance >= 0.0) || !isfinite(options->tolerance) || !(options->gap >= 0.0) ||
      !isfinite(options->gap))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "Tolerance (%g) and gap (%g) must be finite and not negative",
                    options->tolerance, options->gap);
  return TSOLID_OK;
}

tsolid_status tsolid_assembly_create(tsolid_context *context, const tsolid_assembly_input *input,
                                     const tsolid_assembly_options *options,
                                     tsolid_assembly **assembly) {
  static const tsolid_assembly_options defaults;
  if (assembly)
    *assembly = NULL;
  if (!context || !assembly)
    return TSOLID_ERROR_ARGUMENT;
  if (!options)
    options = &defaults;
  tsolid_assembly *made = NULL;
  tsolid_status status = check_arguments(context, input, options);
  if (!status)
    status = tsi_progress(context, stage, 0.0);
  if (status)
    goto done;
  made = tsi_new(&context->allocator, 1, sizeof *made);
  if (!made) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  made->allocator = context->allocator;
  made->arena = (tsi_arena){.allocator = &made->allocator};
  made->tolerance = options->tolerance > 0.0 ? options->tolerance : default_tolerance;
  made->gap = options->gap;
  status = tsi_assembly_read(context, made, input);
  if (status)
    goto done;
  find_origin(made);
  warn_of_units(context, made);
  status = tsi_assembly_orient(context, made);
  if (!status)
    status = find_contacts(context, made);
  if (!status)
    status = tsi_assembly_find_clashes(context, made);
  if (!status)
    status = tsi_assembly_total(context, made);
  if (!status)
    status = tsi_assembly_prepare(context, made);
  if (!status) {
    tell_clashes(context, made);
    status = tsi_progress(context, stage, 1.0);
  }
done:
  if (status)
    tsolid_assembly_free(made);
  else
    *assembly = made;
  return status;
}
