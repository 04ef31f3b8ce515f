/* SPDX-License-Identifier: LGPL-2.1-or-later
 * tsolid assembly: the contacts of several boundaries. */
#include <math.h>
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
    "  --gap D             seek near contacts up to D apart (default: a hundredth of the smaller\n"
    "                      part's diagonal)\n"
    "  --report FILE       the report as JSON\n"
    "  --tolerance T       tolerance of borders for which the files name none (default 1e-7)\n";

enum { TARGET_REPORT, N_TARGETS };

typedef struct job {
  int n_files, check_only;
  const char **file, *path[N_TARGETS];
  tsolid_assembly_options options;
  cli_target target[N_TARGETS];
  tsolid_context *context;
  cli_input *input;
  tsolid_part *part;
  char (*name)[256];
  tsolid_assembly *assembly;
  int n_unread;
} job;

static int parse(job *j, int argc, char **argv) {
  const cli_option table[] = {{"--check-only", CLI_FLAG, &j->check_only, 0, 0, NULL},
                              {"--gap", CLI_NUMBER, &j->options.gap, 0, 0, NULL},
                              {"--report", CLI_TEXT, &j->path[TARGET_REPORT], 0, 0, NULL},
                              {"--tolerance", CLI_NUMBER, &j->options.tolerance, 0, 0, NULL},
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
    name_after(j->file[k], j->name[k]);
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

static tsolid_status write_report(job *j) {
  char *json = NULL;
  cli_target *target = &j->target[TARGET_REPORT];
  if (!target->path)
    return TSOLID_OK;
  tsolid_status status = tsolid_assembly_json(j->context, j->assembly, &json);
  if (status == TSOLID_OK &&
      (!cli_write_text(json, target->staged) || !cli_targets_commit(target, 1)))
    status = TSOLID_ERROR_IO;
  cli_targets_discard(target, 1);
  tsolid_release(j->context, json);
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
  if (status == TSOLID_OK) {
    tsolid_assembly_get(j->assembly, &view);
    code = verdict_code(&view);
    status = write_report(j);
  }
  if (status == TSOLID_OK)
    cli_print_assembly(&view);
  tsolid_assembly_free(j->assembly);
  for (int k = 0; k < j->n_files; k++)
    cli_input_free(&j->input[k]);
  fflush(stdout);
  return cli_close(j->context, status, code);
}

int cli_assembly(int argc, char **argv) {
  job j = {.n_files = 0};
  size_t room = (size_t)argc;
  int code = CLI_FAILED;
  j.file = calloc(room, sizeof *j.file);
  j.input = calloc(room, sizeof *j.input);
  j.part = calloc(room, sizeof *j.part);
  j.name = calloc(room, sizeof *j.name);
  if (!j.file || !j.input || !j.part || !j.name)
    cli_error("Out of memory");
  else
    code = parse(&j, argc, argv);
  if (code < 0) {
    code = CLI_FAILED;
    if (cli_targets_open(j.target, j.path, N_TARGETS, NULL)) {
      j.context = cli_open(0);
      if (j.context)
        code = run(&j);
    }
  }
  free(j.name);
  free(j.part);
  free(j.input);
  free((void *)j.file);
  return code;
}
