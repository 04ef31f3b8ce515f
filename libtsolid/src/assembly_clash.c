/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Parts that share volume.
 *
 * What contacts tell: patches that coincide with the same normal, and patches that face each other
 * from inside. Beyond that every patch of a part is sampled on a grid with 16 cells a side, borders
 * included, and each point that lies in the other part's box is tested by parity, then measured
 * against that part's surface: a point is inside if it is farther from the surface than the
 * triangles are and the parity is odd, or nearer and behind the normal at its foot. So a clash that
 * is reported is there; what fits between the samples is missed. */
#include "assembly.h"
#include "bvh.h"

static const char stage[] = "assembly";

enum { N_GRID = 17 };

typedef struct probe {
  double distance, point[3];
  int patch, n_inside, n_outside;
} probe;

typedef struct clash_search {
  tsolid_context *context;
  tsolid_assembly *assembly;
  int a, n_found;
  const int *start, *list; /* contacts by their first part */
  tsolid_clash *clash;     /* NULL: count only */
  tsolid_status status;
} clash_search;

static double box_distance(const double box[6], const double x[3]) {
  double sum = 0.0;
  for (int c = 0; c < 3; c++) {
    double d = fmax(fmax(box[c] - x[c], x[c] - box[3 + c]), 0.0);
    sum += d * d;
  }
  return sqrt(sum);
}

/* Distance to the surface of a part; *behind: x lies against the normal at the foot. */
static double find_surface(const tsolid_assembly *assembly, const tsi_member *part,
                           const double x[3], int *behind) {
  double best = INFINITY;
  *behind = 0;
  for (int k = part->first; k < part->end; k++) {
    const tsi_skin *skin = &assembly->skin[k];
    double y[3], normal[3], dot = 0.0;
    tsi_foot foot;
    if (box_distance(skin->box, x) >= best)
      continue;
    tsi_foot_find(skin, x, NULL, &foot);
    if (foot.distance >= best)
      continue;
    best = foot.distance;
    if (tsi_skin_normal(skin, foot.uv[0], foot.uv[1], y, normal))
      for (int c = 0; c < 3; c++)
        dot += (x[c] - y[c]) * normal[c];
    *behind = skin->outward != 0 && dot < 0.0;
  }
  return best;
}

static void probe_skin(const tsolid_assembly *assembly, int k, const tsi_member *other,
                       double tolerance, probe *found) {
  const tsi_skin *skin = &assembly->skin[k];
  for (int i = 0; i < N_GRID * N_GRID; i++) {
    double x[3];
    int behind;
    tsi_skin_point(skin, (double)(i % N_GRID) / (N_GRID - 1), (double)(i / N_GRID) / (N_GRID - 1),
                   x);
    if (!tsi_in_box(other->box, x, tolerance))
      found->n_outside++;
    if (!tsi_in_box(other->box, x, -tolerance))
      continue;
    int inside = tsi_inside(other, x);
    if (!inside) {
      if (!found->n_outside)
        found->n_outside += find_surface(assembly, other, x, &behind) > tolerance + other->bend;
      continue;
    }
    double distance = find_surface(assembly, other, x, &behind);
    if (distance <= tolerance || (distance <= 2.0 * other->bend && !behind))
      continue;
    found->n_inside++;
    if (distance > found->distance) {
      found->distance = distance;
      found->patch = skin->number;
      memcpy(found->point, x, sizeof found->point);
    }
  }
}

/* The skin lies on the other part's surface: a whole contact of both. */
static int lies_on(const clash_search *s, int k, int other) {
  for (int i = s->start[s->a]; i < s->start[s->a + 1]; i++) {
    const tsi_contact *contact = &s->assembly->contact[s->list[i]];
    for (int side = 0; side < 2; side++)
      if (contact->skin[side] == k && contact->view.part[1 - side] == other &&
          contact->view.kind <= TSOLID_CONTACT_GEOMETRIC)
        return 1;
  }
  return 0;
}

/* Samples of part a inside part b; one of the two is s->a. */
static void probe_part(const clash_search *s, int a, int b, double tolerance, probe *found) {
  const tsolid_assembly *assembly = s->assembly;
  const tsi_member *part = &assembly->part[a], *other = &assembly->part[b];
  *found = (probe){.patch = -1};
  for (int k = part->first; k < part->end; k++) {
    const double *box = assembly->skin[k].box;
    int apart = 0;
    for (int c = 0; c < 3; c++)
      apart |= box[c] > other->box[3 + c] - tolerance || box[3 + c] < other->box[c] + tolerance;
    if (apart)
      found->n_outside++;
    else if (!lies_on(s, k, b))
      probe_skin(assembly, k, other, tolerance, found);
  }
}

/* ---- pairs of parts ----------------------------------------------------------------------------
 */

typedef struct pair_facts {
  int n_same_side; /* whole patches */
  double depth, point[3];
  int patch[2];
} pair_facts;

static void read_contacts(const clash_search *s, int b, pair_facts *facts) {
  *facts = (pair_facts){.patch = {-1, -1}};
  for (int i = s->start[s->a]; i < s->start[s->a + 1]; i++) {
    const tsolid_interface *view = &s->assembly->contact[s->list[i]].view;
    if (view->part[0] + view->part[1] - s->a != b || view->part[0] == view->part[1])
      continue;
    double depth = view->same_side ? 0.0 : view->depth;
    if (view->same_side)
      facts->n_same_side += view->kind <= TSOLID_CONTACT_GEOMETRIC;
    if (!(view->same_side || depth > 0.0) || (facts->patch[0] >= 0 && depth <= facts->depth))
      continue;
    int swap = view->part[0] != s->a;
    facts->depth = depth;
    facts->patch[0] = view->patch[swap];
    facts->patch[1] = view->patch[!swap];
    memcpy(facts->point, view->point, sizeof facts->point);
  }
}

static int test_pair(void *data, int b) {
  clash_search *s = data;
  tsolid_assembly *assembly = s->assembly;
  const tsi_member *part[2] = {&assembly->part[s->a], &assembly->part[b]};
  probe found[2];
  pair_facts facts;
  if (b <= s->a || part[1]->status)
    return 0;
  read_contacts(s, b, &facts);
  tsolid_clash clash = {.part = {s->a, b},
                        .patch = {facts.patch[0], facts.patch[1]},
                        .depth = facts.depth,
                        .point = {facts.point[0], facts.point[1], facts.point[2]}};
  int n = part[0]->n_patches;
  if (facts.n_same_side == n && n == part[1]->n_patches) {
    clash.kind = TSOLID_CLASH_TWICE;
    s->clash[s->n_found++] = clash;
    return 0;
  }
  probe_part(s, s->a, b, assembly->tolerance, &found[0]);
  probe_part(s, b, s->a, assembly->tolerance, &found[1]);
  for (int k = 0; k < 2; k++)
    if (found[k].n_inside && found[k].distance > clash.depth) {
      clash.depth = found[k].distance;
      clash.patch[k] = found[k].patch;
      clash.patch[1 - k] = -1;
      memcpy(clash.point, found[k].point, sizeof clash.point);
    }
  for (int k = 0; k < 2; k++)
    if (found[k].n_inside && !found[k].n_outside) {
      clash.kind = TSOLID_CLASH_INSIDE;
      clash.part[0] = k ? b : s->a;
      clash.part[1] = k ? s->a : b;
      clash.patch[0] = found[k].patch;
      clash.patch[1] = -1;
    }
  if (facts.patch[0] >= 0 || found[0].n_inside || found[1].n_inside)
    s->clash[s->n_found++] = clash;
  return 0;
}

/* At most so many clashes with one part are told; room is made before. */
static int count_pair(void *data, int b) {
  clash_search *s = data;
  s->n_found += b > s->a;
  return 0;
}

/* Contacts by both of their parts. */
static int index_by_part(tsi_arena *arena, const tsolid_assembly *assembly, int **start,
                         int **list) {
  int n = assembly->n_parts;
  *start = tsi_arena_new(arena, (size_t)n + 2, sizeof **start);
  *list = tsi_arena_new(arena, 2 * (size_t)assembly->n_contacts, sizeof **list);
  if (!*start || !*list)
    return 0;
  for (int k = 0; k < 2 * assembly->n_contacts; k++)
    (*start)[assembly->contact[k / 2].view.part[k % 2] + 2]++;
  for (int k = 0; k < n; k++)
    (*start)[k + 2] += (*start)[k + 1];
  for (int k = 0; k < 2 * assembly->n_contacts; k++)
    (*list)[(*start)[assembly->contact[k / 2].view.part[k % 2] + 1]++] = k / 2;
  return 1;
}

static struct tsi_bvh *index_boxes(tsi_arena *arena, const tsolid_assembly *assembly) {
  double *box = tsi_arena_new(arena, (size_t)assembly->n_parts, 6 * sizeof *box);
  for (int k = 0; box && k < assembly->n_parts; k++) {
    const tsi_member *part = &assembly->part[k];
    for (int c = 0; c < 6; c++)
      box[6 * k + c] = part->status ? INFINITY : part->box[c];
  }
  return box ? tsi_bvh_create(&assembly->allocator, assembly->n_parts, box) : NULL;
}

static int count_self(const tsolid_assembly *assembly) {
  int n = 0;
  for (int k = 0; k < assembly->n_contacts; k++)
    n += assembly->contact[k].view.part[0] == assembly->contact[k].view.part[1];
  return n;
}

static int list_self(const tsolid_assembly *assembly, tsolid_clash *clash) {
  int n = 0;
  for (int k = 0; k < assembly->n_contacts; k++) {
    const tsolid_interface *view = &assembly->contact[k].view;
    if (view->part[0] != view->part[1])
      continue;
    clash[n] = (tsolid_clash){.kind = TSOLID_CLASH_SELF,
                              .part = {view->part[0], view->part[1]},
                              .patch = {view->patch[0], view->patch[1]}};
    memcpy(clash[n++].point, view->point, sizeof clash->point);
  }
  return n;
}

tsolid_status tsi_assembly_find_clashes(tsolid_context *context, tsolid_assembly *assembly) {
  tsi_arena work = tsi_arena_create(context);
  int *start = NULL, *list = NULL, n_self = count_self(assembly);
  clash_search s = {.context = context, .assembly = assembly};
  tsolid_status status = TSOLID_OK;
  struct tsi_bvh *bvh = index_boxes(&work, assembly);
  if (!bvh || !index_by_part(&work, assembly, &start, &list))
    status = tsi_no_memory(context, stage);
  s.start = start;
  s.list = list;
  for (s.a = 0; !status && s.a < assembly->n_parts; s.a++)
    if (!assembly->part[s.a].status)
      tsi_bvh_overlapping(bvh, assembly->part[s.a].box, 0.0, count_pair, &s);
  if (!status) {
    s.clash = tsi_arena_new(&assembly->arena, (size_t)s.n_found + (size_t)n_self, sizeof *s.clash);
    if (!s.clash)
      status = tsi_no_memory(context, stage);
  }
  s.n_found = status ? 0 : list_self(assembly, s.clash);
  for (s.a = 0; !status && s.a < assembly->n_parts; s.a++) {
    if (!assembly->part[s.a].status)
      tsi_bvh_overlapping(bvh, assembly->part[s.a].box, 0.0, test_pair, &s);
    status = tsi_progress(context, stage, 0.7 + 0.3 * s.a / assembly->n_parts);
  }
  assembly->view.n_clashes = s.n_found;
  assembly->view.clash = s.clash;
  tsi_bvh_free(bvh);
  tsi_arena_free(&work);
  return status;
}
