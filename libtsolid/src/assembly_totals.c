/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Free faces, volumes, groups, and the verdict.
 *
 * A patch is cut by the borders of all contacts on it into rectangles; those that no contact covers
 * are free. The flux of (x - origin)/3 through all patches of a part is its volume; that through
 * the free rectangles of all parts is the volume they enclose together: equal when every contact
 * is watertight, since the fluxes of both sides of a contact cancel. Both sums are taken by Gauss
 * quadrature span by span, exact for polynomials. */
#include <stdlib.h>

#include "assembly.h"
#include "quadrature.h"

static const char stage[] = "assembly";

/* ---- quadrature --------------------------------------------------------------------------------
 */

static int is_rational(const tsi_patch *patch) {
  size_t n = (size_t)patch->n[0] * (size_t)patch->n[1];
  for (size_t i = 1; i < n; i++)
    if (patch->control[4 * i + 3] != patch->control[3])
      return 1;
  return 0;
}

/* Flux and area of the span [lo, hi]. */
static void add_span(const tsi_patch *patch, const double span[4], const double origin[3],
                     const int n[2], double x[2][TSI_MAX_GAUSS], double w[2][TSI_MAX_GAUSS],
                     tsi_sum *area, tsi_sum *flux) {
  for (int j = 0; j < n[1]; j++)
    for (int i = 0; i < n[0]; i++) {
      double p[3], normal[3], dot = 0.0;
      double u = span[0] + x[0][i] * (span[1] - span[0]);
      double v = span[2] + x[1][j] * (span[3] - span[2]);
      double weight = w[0][i] * w[1][j] * (span[1] - span[0]) * (span[3] - span[2]);
      tsi_patch_normal(patch, u, v, p, normal);
      for (int c = 0; c < 3; c++)
        dot += (p[c] - origin[c]) * normal[c];
      tsi_sum_add(area, weight * hypot(hypot(normal[0], normal[1]), normal[2]));
      tsi_sum_add(flux, weight * dot / 3.0);
    }
}

/* Over a rectangle, span by span; flux by the patch's own normal. */
static void measure_box(const tsi_patch *patch, const double box[4], const double origin[3],
                        double *area, double *flux) {
  double x[2][TSI_MAX_GAUSS], w[2][TSI_MAX_GAUSS];
  int n[2], rational = is_rational(patch);
  tsi_sum sum[2] = {{0.0, 0.0}, {0.0, 0.0}};
  for (int d = 0; d < 2; d++) {
    n[d] = 3 * patch->degree[d] / 2 + 2;
    if (rational) /* converges geometrically */
      n[d] += 14;
    n[d] = n[d] > TSI_MAX_GAUSS ? TSI_MAX_GAUSS : n[d];
    tsi_gauss(n[d], x[d], w[d]);
  }
  for (int j = patch->degree[1]; j < patch->n[1]; j++)
    for (int i = patch->degree[0]; i < patch->n[0]; i++) {
      double span[4] = {fmax(box[0], patch->knots[0][i]), fmin(box[1], patch->knots[0][i + 1]),
                        fmax(box[2], patch->knots[1][j]), fmin(box[3], patch->knots[1][j + 1])};
      if (span[0] < span[1] && span[2] < span[3])
        add_span(patch, span, origin, n, x, w, &sum[0], &sum[1]);
    }
  *area = tsi_sum_get(&sum[0]);
  *flux = tsi_sum_get(&sum[1]);
}

/* ---- free rectangles ---------------------------------------------------------------------------
 */

/* Contacts by skin: entries start[k] .. start[k+1]-1 of list, 2 * contact + side. */
typedef struct contact_index {
  int *start, *list;
} contact_index;

static int index_contacts(tsi_arena *arena, const tsolid_assembly *assembly, contact_index *index) {
  int n = assembly->n_skins;
  index->start = tsi_arena_new(arena, (size_t)n + 2, sizeof *index->start);
  index->list = tsi_arena_new(arena, 2 * (size_t)assembly->n_contacts, sizeof *index->list);
  if (!index->start || !index->list)
    return 0;
  for (int k = 0; k < 2 * assembly->n_contacts; k++)
    index->start[assembly->contact[k / 2].skin[k % 2] + 2]++;
  for (int k = 0; k < n; k++)
    index->start[k + 2] += index->start[k + 1];
  for (int k = 0; k < 2 * assembly->n_contacts; k++)
    index->list[index->start[assembly->contact[k / 2].skin[k % 2] + 1]++] = k;
  return 1;
}

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Free area and flux of skin k; `line` has room for all borders. */
static void measure_free(const tsolid_assembly *assembly, const contact_index *index, int k,
                         double *line[2], double *area, double *flux) {
  const tsi_skin *skin = &assembly->skin[k];
  int n[2] = {0, 0};
  tsi_sum sum[2] = {{0.0, 0.0}, {0.0, 0.0}};
  for (int d = 0; d < 2; d++) {
    line[d][n[d]++] = 0.0;
    line[d][n[d]++] = 1.0;
    for (int i = index->start[k]; i < index->start[k + 1]; i++) {
      const tsi_contact *contact = &assembly->contact[index->list[i] / 2];
      if (!tsi_is_watertight(&contact->view))
        continue;
      line[d][n[d]++] = contact->view.box[index->list[i] % 2][2 * d];
      line[d][n[d]++] = contact->view.box[index->list[i] % 2][2 * d + 1];
    }
    qsort(line[d], (size_t)n[d], sizeof(double), compare_doubles);
  }
  for (int j = 0; j + 1 < n[1]; j++)
    for (int i = 0; i + 1 < n[0]; i++) {
      double box[4] = {line[0][i], line[0][i + 1], line[1][j], line[1][j + 1]}, part[2];
      double middle[2] = {0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3])};
      int covered = !(box[0] < box[1] - 1e-11) || !(box[2] < box[3] - 1e-11);
      for (int m = index->start[k]; m < index->start[k + 1] && !covered; m++) {
        const tsi_contact *contact = &assembly->contact[index->list[m] / 2];
        const double *c = contact->view.box[index->list[m] % 2];
        covered = tsi_is_watertight(&contact->view) && middle[0] > c[0] && middle[0] < c[1] &&
                  middle[1] > c[2] && middle[1] < c[3];
      }
      if (covered)
        continue;
      measure_box(&skin->patch, box, assembly->origin, &part[0], &part[1]);
      tsi_sum_add(&sum[0], part[0]);
      tsi_sum_add(&sum[1], part[1]);
    }
  *area = tsi_sum_get(&sum[0]);
  *flux = tsi_sum_get(&sum[1]) * (skin->outward < 0 ? -1.0 : 1.0);
}

static tsolid_status find_free(tsolid_context *context, tsolid_assembly *assembly,
                               tsolid_part_facts *facts, tsolid_assembly_view *view) {
  tsi_arena work = tsi_arena_create(context);
  contact_index index;
  double *line[2];
  tsi_sum total[2] = {{0.0, 0.0}, {0.0, 0.0}};
  size_t room = 2 * (size_t)assembly->n_contacts + 2;
  static const double whole[4] = {0.0, 1.0, 0.0, 1.0};
  line[0] = tsi_arena_new(&work, room, sizeof(double));
  line[1] = tsi_arena_new(&work, room, sizeof(double));
  tsolid_free_face *face = tsi_arena_new(&assembly->arena, (size_t)assembly->n_skins, sizeof *face);
  int n = 0, done = line[0] && line[1] && face && index_contacts(&work, assembly, &index);
  for (int k = 0; done && k < assembly->n_skins; k++) {
    tsi_skin *skin = &assembly->skin[k];
    tsolid_part_facts *part = &facts[skin->part];
    double area, flux, sign = skin->outward < 0 ? -1.0 : 1.0;
    measure_box(&skin->patch, whole, assembly->origin, &skin->area, &skin->flux);
    skin->flux *= sign;
    measure_free(assembly, &index, k, line, &area, &flux);
    part->volume += skin->flux;
    part->area += skin->area;
    tsi_sum_add(&total[0], skin->flux);
    tsi_sum_add(&total[1], flux);
    if (area <= 1e-9 * skin->area)
      continue;
    part->n_free++;
    face[n++] = (tsolid_free_face){skin->part, skin->number, area, area / skin->area};
  }
  tsi_arena_free(&work);
  view->n_free = n;
  view->free_face = face;
  view->volume = tsi_sum_get(&total[0]);
  view->volume_inside = tsi_sum_get(&total[1]);
  return done ? TSOLID_OK : tsi_no_memory(context, stage);
}

/* ---- groups and verdict ------------------------------------------------------------------------
 */

static int find_root(int *parent, int i) {
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}

static tsolid_status count_groups(tsolid_context *context, const tsolid_assembly *assembly,
                                  int *n_groups) {
  tsi_arena work = tsi_arena_create(context);
  int *parent = tsi_arena_new(&work, (size_t)assembly->n_parts, sizeof *parent);
  *n_groups = 0;
  if (!parent)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < assembly->n_parts; k++)
    parent[k] = k;
  for (int k = 0; k < assembly->n_contacts; k++)
    if (tsi_is_watertight(&assembly->contact[k].view))
      parent[find_root(parent, assembly->contact[k].view.part[0])] =
          find_root(parent, assembly->contact[k].view.part[1]);
  for (int k = 0; k < assembly->n_parts; k++)
    *n_groups += parent[k] == k && !assembly->part[k].status;
  tsi_arena_free(&work);
  return TSOLID_OK;
}

static void judge(const tsolid_assembly *assembly, tsolid_assembly_view *view) {
  view->verdict = TSOLID_ASSEMBLY_WATERTIGHT;
  if (view->n_of_kind[TSOLID_CONTACT_COINCIDENT] || view->n_of_kind[TSOLID_CONTACT_NEAR])
    view->verdict = TSOLID_ASSEMBLY_GAPS;
  if (view->n_clashes)
    view->verdict = TSOLID_ASSEMBLY_CLASHES;
  for (int k = 0; k < assembly->n_parts; k++)
    if (assembly->part[k].status)
      view->verdict = TSOLID_ASSEMBLY_INCOMPLETE;
}

tsolid_status tsi_assembly_total(tsolid_context *context, tsolid_assembly *assembly) {
  tsolid_assembly_view *view = &assembly->view;
  size_t n_parts = (size_t)assembly->n_parts, n = (size_t)assembly->n_contacts;
  tsolid_part_facts *facts = tsi_arena_new(&assembly->arena, n_parts, sizeof *facts);
  tsolid_interface *list = tsi_arena_new(&assembly->arena, n, sizeof *list);
  if (!facts || !list)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < assembly->n_parts; k++) {
    const tsi_member *part = &assembly->part[k];
    facts[k] = (tsolid_part_facts){.name = part->name,
                                   .status = part->status,
                                   .n_patches = part->n_patches,
                                   .copy_of = part->prototype,
                                   .closed = part->closed};
  }
  memset(view->n_of_kind, 0, sizeof view->n_of_kind);
  view->gap = 0.0;
  for (size_t k = 0; k < n; k++) {
    tsi_contact *contact = &assembly->contact[k];
    double flux;
    measure_box(&assembly->skin[contact->skin[0]].patch, contact->view.box[0], assembly->origin,
                &contact->view.area, &flux);
    list[k] = contact->view;
    view->n_of_kind[list[k].kind]++;
    view->gap = fmax(view->gap, list[k].gap);
    facts[list[k].part[0]].n_interfaces++;
    if (list[k].part[1] != list[k].part[0])
      facts[list[k].part[1]].n_interfaces++;
  }
  view->n_parts = assembly->n_parts;
  view->n_patches = assembly->n_skins;
  view->part = facts;
  view->n_interfaces = (int)n;
  view->interface = list;
  tsolid_status status = find_free(context, assembly, facts, view);
  if (!status)
    status = count_groups(context, assembly, &view->n_groups);
  if (!status)
    judge(assembly, view);
  return status;
}
