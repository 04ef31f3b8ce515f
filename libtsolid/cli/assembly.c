/* SPDX-License-Identifier: LGPL-2.1-or-later
 * tsolid assembly: the contacts of several boundaries. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static const char help[] =
    "tsolid assembly A.tsb B.tsb ... [options]\n"
    "\n"
    "Finds which faces of which parts are the same surface, how far others are apart, and "
    "clashes.\n"
    "Exit code 0: watertight; 2: gaps or clashes; 1: a part could not be read or done.\n"
    "\n"
    "  --check-only        the contacts of the parts as they are, nothing is built\n"
    "  -o, --output DIR    the solids: one A.tsolid per part, all at the end; copies have one\n"
    "  --effort E          default, none, quick or thorough: as in tsolid build\n"
    "  --gap D             seek near contacts up to D apart (default: a hundredth of the smaller\n"
    "                      part's diagonal)\n"
    "  --report FILE       the report as JSON\n"
    "  --tolerance T       tolerance of borders for which the files name none (default 1e-7)\n"
    "\n"
    "  --inp FILE          hexahedra of all parts for CalculiX and Abaqus, with common nodes "
    "where\n"
    "                      parts touch; a set per part and per free face, PART_FACE\n"
    "  --hex-vtu FILE      the same hexahedra for VTK and ParaView\n"
    "  --size H            wanted edge length (default: a twentieth of the largest part's "
    "diagonal)\n"
    "  --order N           1 (default): 8 nodes per element, C3D8; 2: 20 nodes, C3D20\n"
    "  --grading G         thickness of the outermost layer over the innermost (default 1)\n"
    "  --max-elements N    refuse to make more (default 2000000)\n"
    "  --force             also of solids that are not proved valid; the files then say so\n";

enum { TARGET_REPORT, TARGET_INP, TARGET_HEX_VTU, N_TARGETS };

typedef struct job {
  int n_files, check_only, n_threads, effort;
  const char *path_of_folder;
  cli_folder folder;
  const char **file, *path[N_TARGETS];
  tsolid_assembly_options options;
  tsolid_hex_options hex;
  cli_target target[N_TARGETS];
  tsolid_context *context;
  cli_input *input;
  tsolid_part *part;
  char (*name)[256];
  tsolid_assembly *assembly, *joined;
  const tsolid_solid **solid; /* per part; copies have their prototype's */
  int n_unread, n_unproved;
} job;

static const char *const effort_names[] = {"default", "none", "quick", "thorough", NULL};

static int parse(job *j, int argc, char **argv) {
  const cli_option table[] = {
      {"--check-only", CLI_FLAG, &j->check_only, 0, 0, NULL},
      {"-o", CLI_TEXT, &j->path_of_folder, 0, 0, NULL},
      {"--output", CLI_TEXT, &j->path_of_folder, 0, 0, NULL},
      {"--effort", CLI_CHOICE, &j->effort, 0, 0, effort_names},
      {"--threads", CLI_COUNT, &j->n_threads, 0, 256, NULL},
      {"--gap", CLI_NUMBER, &j->options.gap, 0, 0, NULL},
      {"--report", CLI_TEXT, &j->path[TARGET_REPORT], 0, 0, NULL},
      {"--tolerance", CLI_NUMBER, &j->options.tolerance, 0, 0, NULL},
      {"--inp", CLI_TEXT, &j->path[TARGET_INP], 0, 0, NULL},
      {"--hex-vtu", CLI_TEXT, &j->path[TARGET_HEX_VTU], 0, 0, NULL},
      {"--size", CLI_NUMBER, &j->hex.size, 0, 0, NULL},
      {"--order", CLI_COUNT, &j->hex.order, 1, 2, NULL},
      {"--grading", CLI_NUMBER, &j->hex.grading, 0, 0, NULL},
      {"--max-elements", CLI_COUNT, &j->hex.max_elements, 1, 100000000, NULL},
      {"--force", CLI_FLAG, &j->hex.allow_unproved, 0, 0, NULL},
      {NULL, CLI_TEXT, NULL, 0, 0, NULL}};
  return cli_parse_many(argc, argv, help, table, argc, j->file, &j->n_files);
}

/* "wheel" of "parts/wheel.tsb". */
static void name_after(const char *path, char name[256]) {
  const char *slash = strrchr(path, '/');
  snprintf(name, 256, "%.255s", slash ? slash + 1 : path);
  char *dot = strrchr(name, '.');
  if (dot && dot != name)
    *dot = 0;
}

/* One name per file: a second wheel.tsb, from elsewhere, is wheel_2. */
static void name_part(job *j, int k) {
  char plain[256];
  int again = 1;
  name_after(j->file[k], plain);
  snprintf(j->name[k], sizeof j->name[k], "%s", plain);
  for (int i = 0; i < k; i++)
    if (strcmp(j->name[i], j->name[k]) == 0 && strcmp(j->file[i], j->file[k]) != 0) {
      snprintf(j->name[k], sizeof j->name[k], "%.240s_%d", plain, ++again);
      i = -1;
    }
}

/* A file that is given again is a copy of the first. */
static int find_same(const job *j, int k) {
  for (int i = 0; i < k; i++)
    if (strcmp(j->file[i], j->file[k]) == 0)
      return i;
  return k;
}

/* Parts that cannot be read stay without input; the library says that of them, too. */
static tsolid_status read_parts(job *j) {
  for (int k = 0; k < j->n_files; k++) {
    int same = find_same(j, k);
    tsolid_status status = TSOLID_OK;
    if (same == k)
      status = cli_input_read(j->context, j->file[k], &j->input[k]);
    if (status == TSOLID_ERROR_MEMORY || status == TSOLID_ERROR_CANCELLED)
      return status;
    j->n_unread += status != TSOLID_OK;
    name_part(j, k);
    j->part[k] = (tsolid_part){.name = j->name[k], .boundary = &j->input[same].boundary};
  }
  return TSOLID_OK;
}

static tsolid_status match(job *j) {
  tsolid_assembly_input input = {.n_parts = j->n_files, .parts = j->part};
  tsolid_status status = read_parts(j);
  if (status == TSOLID_OK)
    status = tsolid_assembly_create(j->context, &input, &j->options, &j->assembly);
  return status;
}

/* ---- the solids --------------------------------------------------------------------------------
 */

static tsolid_status build_solid(job *j, const tsolid_boundary_input *input, tsolid_solid **solid) {
  tsolid_boundary_options boundary_options = {.tolerance = j->options.tolerance};
  tsolid_solid_options solid_options = {.effort = j->effort};
  tsolid_boundary *boundary = NULL;
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_solid *start = NULL;
  tsolid_status status =
      tsolid_boundary_create(j->context, input, &boundary_options, NULL, &boundary);
  if (status == TSOLID_OK)
    status = tsolid_tmesh_create(j->context, boundary, NULL, &tmesh);
  if (status == TSOLID_OK)
    status = tsolid_space_create(j->context, boundary, tmesh, &space);
  if (status == TSOLID_OK)
    status = tsolid_solid_create(j->context, space, &start);
  if (status == TSOLID_OK)
    status = tsolid_solid_optimise(j->context, start, &solid_options, solid);
  tsolid_solid_free(start);
  tsolid_space_free(space);
  tsolid_tmesh_free(tmesh);
  tsolid_boundary_free(boundary);
  return status;
}

/* Beside the folder: nothing is in it before all is done. */
static tsolid_status write_solid(job *j, const char *name, const tsolid_solid *solid) {
  char file[256 + 8];
  if (!j->path_of_folder)
    return TSOLID_OK;
  snprintf(file, sizeof file, "%.255s.tsolid", name);
  const char *path = cli_folder_file(&j->folder, file);
  return path ? tsolid_write_tsolid(j->context, solid, path) : TSOLID_ERROR_IO;
}

/* One solid per prototype; a part that fails is told and left out. */
static tsolid_status build_part(job *j, const tsolid_assembly_view *view, int k) {
  const tsolid_part_facts *facts = &view->part[k];
  tsolid_certificate certificate;
  tsolid_solid *solid = NULL;
  if (facts->status != TSOLID_OK)
    return TSOLID_OK;
  if (facts->copy_of != k) {
    j->solid[k] = j->solid[facts->copy_of];
    return TSOLID_OK;
  }
  const tsolid_boundary_input *input = tsolid_assembly_boundary_input(j->assembly, k);
  tsolid_status status = build_solid(j, input ? input : j->part[k].boundary, &solid);
  if (status == TSOLID_OK)
    status = tsolid_certify(j->context, solid, NULL, &certificate, NULL);
  if (status == TSOLID_OK) {
    j->n_unproved += certificate.verdict != TSOLID_POSITIVE;
    if (certificate.verdict != TSOLID_POSITIVE)
      printf("Not proved    %s\n", facts->name);
    status = write_solid(j, facts->name, solid);
  }
  if (status == TSOLID_OK) {
    j->solid[k] = solid;
    return status;
  }
  tsolid_solid_free(solid);
  if (status == TSOLID_ERROR_MEMORY || status == TSOLID_ERROR_CANCELLED ||
      status == TSOLID_ERROR_IO)
    return status;
  cli_error("No solid of %s; the other parts are done", facts->name);
  return TSOLID_OK;
}

static tsolid_status build(job *j) {
  tsolid_assembly_view view;
  tsolid_status status = TSOLID_OK;
  tsolid_assembly_get(j->assembly, &view);
  for (int k = 0; status == TSOLID_OK && k < j->n_files; k++)
    status = build_part(j, &view, k);
  if (status == TSOLID_OK)
    status = tsolid_assembly_join(j->context, j->assembly, j->n_files, j->solid, &j->joined);
  return status;
}

static void free_solids(job *j) {
  for (int k = 0; k < j->n_files; k++) {
    int first = 1;
    for (int i = 0; i < k; i++)
      first = first && j->solid[i] != j->solid[k];
    if (first)
      tsolid_solid_free((tsolid_solid *)(uintptr_t)j->solid[k]);
  }
}

/* ---- driver ------------------------------------------------------------------------------------
 */

/* The report and the solids: all of them at the end. */
static tsolid_status write_outputs(job *j) {
  char *json = NULL;
  cli_target *target = &j->target[TARGET_REPORT];
  tsolid_status status = TSOLID_OK;
  if (target->path)
    status = tsolid_assembly_json(j->context, j->joined ? j->joined : j->assembly, &json);
  if (status == TSOLID_OK && json && !cli_write_text(json, target->staged))
    status = TSOLID_ERROR_IO;
  if (status == TSOLID_OK && j->folder.path && !cli_folder_commit(&j->folder))
    status = TSOLID_ERROR_IO;
  if (status == TSOLID_OK && json && !cli_targets_commit(target, 1))
    status = TSOLID_ERROR_IO;
  cli_targets_discard(target, 1);
  tsolid_release(j->context, json);
  return status;
}

static int wants_mesh(const job *j) {
  return j->path[TARGET_INP] || j->path[TARGET_HEX_VTU];
}

static tsolid_status write_mesh(job *j) {
  cli_target *inp = &j->target[TARGET_INP], *vtu = &j->target[TARGET_HEX_VTU];
  tsolid_status status =
      cli_mesh_assembly(j->context, j->joined, j->n_files, j->part, j->solid, &j->hex,
                        inp->path ? inp->staged : NULL, vtu->path ? vtu->staged : NULL);
  if (status == TSOLID_OK && !cli_targets_commit(inp, 2))
    status = TSOLID_ERROR_IO;
  cli_targets_discard(inp, 2);
  return status;
}

static int verdict_code(const tsolid_assembly_view *view) {
  switch (view->verdict) {
  case TSOLID_ASSEMBLY_WATERTIGHT:
    return CLI_PROVED;
  case TSOLID_ASSEMBLY_INCOMPLETE:
    return CLI_FAILED;
  default:
    return CLI_NOT_PROVED;
  }
}

static int run(job *j) {
  int code = CLI_FAILED;
  tsolid_assembly_view view;
  tsolid_status status = match(j);
  if (status == TSOLID_OK && !j->check_only)
    status = build(j);
  if (status == TSOLID_OK) {
    tsolid_assembly_get(j->joined ? j->joined : j->assembly, &view);
    code = verdict_code(&view);
    if (code == CLI_PROVED && j->n_unproved)
      code = CLI_NOT_PROVED;
    status = write_outputs(j);
  }
  if (status == TSOLID_OK)
    cli_print_assembly(&view);
  if (status == TSOLID_OK && wants_mesh(j))
    status = write_mesh(j);
  tsolid_assembly_free(j->joined);
  tsolid_assembly_free(j->assembly);
  free_solids(j);
  for (int k = 0; k < j->n_files; k++)
    cli_input_free(&j->input[k]);
  fflush(stdout);
  return cli_close(j->context, status, code);
}

/* Before hours are spent on their content. */
static int open_outputs(job *j) {
  if (!cli_targets_open(j->target, j->path, N_TARGETS, NULL))
    return 0;
  return !j->path_of_folder || j->check_only || cli_folder_open(&j->folder, j->path_of_folder);
}

int cli_assembly(int argc, char **argv) {
  job j = {.n_files = 0};
  size_t room = (size_t)argc;
  int code = CLI_FAILED;
  j.file = calloc(room, sizeof *j.file);
  j.input = calloc(room, sizeof *j.input);
  j.part = calloc(room, sizeof *j.part);
  j.name = calloc(room, sizeof *j.name);
  j.solid = calloc(room, sizeof *j.solid);
  if (!j.solid || !j.file || !j.input || !j.part || !j.name)
    cli_error("Out of memory");
  else
    code = parse(&j, argc, argv);
  if (code < 0 && j.check_only && wants_mesh(&j))
    code = cli_error("--check-only builds nothing to be meshed: leave it out or --inp, --hex-vtu");
  if (code < 0) {
    code = CLI_FAILED;
    if (open_outputs(&j)) {
      j.context = cli_open(j.n_threads);
      if (j.context)
        code = run(&j);
    }
    cli_folder_close(&j.folder);
  }
  free((void *)j.solid);
  free(j.name);
  free(j.part);
  free(j.input);
  free((void *)j.file);
  return code;
}
