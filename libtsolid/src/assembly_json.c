/* SPDX-License-Identifier: LGPL-2.1-or-later
 * An assembly's report as one JSON document (resources/assembly.schema.json). Keys are the names of
 * the structs' fields; parts are named by their names. */
#include "json_writer.h"

static const char *const kind_text[] = {"exact", "geometric", "partial", "coincident", "near"};
static const char *const clash_text[] = {"overlap", "inside", "twice", "self"};
static const char *const verdict_text[] = {"watertight", "gaps", "clashes", "incomplete"};

typedef struct writing {
  tsi_doc *w;
  tsolid_context *context;
  const tsolid_assembly_view *view;
} writing;

static void put_pair(const writing *to, cJSON *o, const int part[2], const int patch[2]) {
  cJSON *parts = cJSON_CreateArray();
  double number[2] = {patch[0], patch[1]};
  for (int k = 0; k < 2; k++)
    tsi_doc_append(to->w, parts, tsi_doc_text(to->context, to->view->part[part[k]].name));
  tsi_doc_add(to->w, o, "parts", parts);
  tsi_doc_add_numbers(to->w, o, "patches", number, 2);
}

/* Yes, no, or not known. */
static void put_known(const writing *to, cJSON *o, const char *key, int value) {
  tsi_doc_add(to->w, o, key, value < 0 ? cJSON_CreateNull() : cJSON_CreateBool(value));
}

static cJSON *new_interface(const writing *to, const tsolid_interface *s) {
  cJSON *o = cJSON_CreateObject();
  tsi_doc *w = to->w;
  tsi_doc_add_text(w, o, "kind", kind_text[s->kind]);
  put_pair(to, o, s->part, s->patch);
  tsi_doc_add_flag(w, o, "same_side", s->same_side);
  tsi_doc_add_number(w, o, "code", s->code);
  tsi_doc_add_numbers(w, o, "box", s->box[0], 4);
  tsi_doc_add_numbers(w, o, "other_box", s->box[1], 4);
  tsi_doc_add_numbers(w, o, "moebius", s->moebius, 2);
  tsi_doc_add_number(w, o, "deviation", s->deviation);
  tsi_doc_add_number(w, o, "gap", s->gap);
  tsi_doc_add_number(w, o, "smallest_gap", s->smallest_gap);
  tsi_doc_add_number(w, o, "depth", s->depth);
  tsi_doc_add_numbers(w, o, "point", s->point, 3);
  tsi_doc_add_number(w, o, "area", s->area);
  put_known(to, o, "same_functions", s->same_functions);
  put_known(to, o, "same_bits", s->same_bits);
  tsi_doc_add_number(w, o, "gap_after", s->gap_after);
  tsi_doc_add_number(w, o, "ulp_after", s->ulp_after);
  double continuity[2] = {s->continuity[0], s->continuity[1]};
  tsi_doc_add_numbers(w, o, "continuity", continuity, 2);
  return o;
}

static cJSON *new_part(const writing *to, const tsolid_part_facts *s) {
  cJSON *o = cJSON_CreateObject();
  tsi_doc *w = to->w;
  tsi_doc_add(w, o, "name", tsi_doc_text(to->context, s->name));
  tsi_doc_add_flag(w, o, "read", s->status == TSOLID_OK);
  tsi_doc_add_number(w, o, "n_patches", s->n_patches);
  tsi_doc_add_number(w, o, "n_free", s->n_free);
  tsi_doc_add_number(w, o, "n_interfaces", s->n_interfaces);
  tsi_doc_add(w, o, "copy_of", tsi_doc_text(to->context, to->view->part[s->copy_of].name));
  tsi_doc_add_flag(w, o, "closed", s->closed);
  tsi_doc_add_number(w, o, "volume", s->volume);
  tsi_doc_add_number(w, o, "area", s->area);
  return o;
}

static cJSON *new_clash(const writing *to, const tsolid_clash *s) {
  cJSON *o = cJSON_CreateObject();
  tsi_doc_add_text(to->w, o, "kind", clash_text[s->kind]);
  put_pair(to, o, s->part, s->patch);
  tsi_doc_add_number(to->w, o, "depth", s->depth);
  tsi_doc_add_numbers(to->w, o, "point", s->point, 3);
  return o;
}

static cJSON *new_free_face(const writing *to, const tsolid_free_face *s) {
  cJSON *o = cJSON_CreateObject();
  tsi_doc_add(to->w, o, "part", tsi_doc_text(to->context, to->view->part[s->part].name));
  tsi_doc_add_number(to->w, o, "patch", s->patch);
  tsi_doc_add_number(to->w, o, "area", s->area);
  tsi_doc_add_number(to->w, o, "fraction", s->fraction);
  return o;
}

static void put_totals(const writing *to, cJSON *root) {
  const tsolid_assembly_view *view = to->view;
  cJSON *o = tsi_doc_add_object(to->w, root, "totals");
  for (int k = 0; k < 5; k++)
    tsi_doc_add_number(to->w, o, kind_text[k], view->n_of_kind[k]);
  tsi_doc_add_number(to->w, o, "n_patches", view->n_patches);
  tsi_doc_add_number(to->w, o, "n_groups", view->n_groups);
  tsi_doc_add_number(to->w, o, "gap", view->gap);
  tsi_doc_add_number(to->w, o, "volume", view->volume);
  tsi_doc_add_number(to->w, o, "volume_inside", view->volume_inside);
}

tsolid_status tsolid_assembly_json(tsolid_context *context, const tsolid_assembly *assembly,
                                   char **json) {
  tsi_doc w = {0};
  tsolid_assembly_view view;
  if (json)
    *json = NULL;
  if (!context || !assembly || !json)
    return TSOLID_ERROR_ARGUMENT;
  tsolid_assembly_get(assembly, &view);
  writing to = {&w, context, &view};
  cJSON *root = cJSON_CreateObject();
  cJSON *part = cJSON_CreateArray(), *interface = cJSON_CreateArray();
  cJSON *clash = cJSON_CreateArray(), *free_face = cJSON_CreateArray();
  tsi_doc_add_text(&w, root, "format", "tsolid assembly report");
  tsi_doc_add_number(&w, root, "version", 1);
  tsi_doc_add_text(&w, root, "verdict", verdict_text[view.verdict]);
  put_totals(&to, root);
  for (int k = 0; k < view.n_parts; k++)
    tsi_doc_append(&w, part, new_part(&to, &view.part[k]));
  for (int k = 0; k < view.n_interfaces; k++)
    tsi_doc_append(&w, interface, new_interface(&to, &view.interface[k]));
  for (int k = 0; k < view.n_clashes; k++)
    tsi_doc_append(&w, clash, new_clash(&to, &view.clash[k]));
  for (int k = 0; k < view.n_free; k++)
    tsi_doc_append(&w, free_face, new_free_face(&to, &view.free_face[k]));
  tsi_doc_add(&w, root, "parts", part);
  tsi_doc_add(&w, root, "interfaces", interface);
  tsi_doc_add(&w, root, "clashes", clash);
  tsi_doc_add(&w, root, "free_faces", free_face);
  tsi_doc_add_findings(&w, root, context);
  return tsi_doc_finish(&w, context, root, json);
}
