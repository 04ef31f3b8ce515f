/* SPDX-License-Identifier: LGPL-2.1-or-later
 * tsolid build: the stages of the library in their order, timed. */
#include <math.h>
#include <stdio.h>

#include "cli.h"

static const char help[] =
    "tsolid build IN -o OUT.tsolid [options]\n"
    "\n"
    "IN: .tsb, .tsm or .iga, told apart by content.\n"
    "Builds the conformal solid T-spline, proves it valid and reports.\n"
    "Exit code 0: proved; 2: written, but not proved; 1: refused or failed, nothing written.\n"
    "\n"
    "  -o FILE             the solid (.tsolid)\n"
    "  --report FILE       the report as JSON\n"
    "  --vtu FILE          the solid for VTK and ParaView\n"
    "  --effort E          none (the start only), quick, default or thorough\n"
    "  --threads N         0 (default): all processors; results do not depend on it\n"
    "  --refine-knots K    halve every knot span of the sides K times before (exact)\n"
    "  --raise-degree K    raise the degree of the sides by K before (exact)\n"
    "  --min-cells N       at least N core cells per axis (default 3)\n"
    "  --octree O          anisotropic (default): levels per axis; isotropic: the paper's\n"
    "  --analysis-suitable A  on (default): the T-mesh is closed, so that the functions sum to 1;\n"
    "                      off: the paper's rational T-spline, fewer functions; the report has\n"
    "                      the defect of the sum before normalisation\n"
    "  --core-surface S    smooth (default): functions C^2 across it, away from the core's edges;\n"
    "                      sharp: C^0 on all of it, for full order of convergence with --effort "
    "none\n"
    "  --tolerance T       tolerance of borders for which the file names none (default 1e-7)\n";

enum { TARGET_VTU, TARGET_REPORT, TARGET_SOLID, N_TARGETS };

typedef struct job {
  const char *input, *path[N_TARGETS];
  int n_threads, effort;
  tsolid_boundary_options boundary_options;
  tsolid_tmesh_options tmesh_options;
  cli_target target[N_TARGETS];
  tsolid_context *context;
  tsolid_boundary *boundary;
  tsolid_tmesh *tmesh;
  tsolid_space *space;
  tsolid_solid *start, *solid;
  tsolid_report report;
  tsolid_timing timing;
  double begun, clock; /* of the job, of the running stage */
} job;

static const char *const effort_names[] = {"default", "none", "quick", "thorough", NULL};
static const char *const octree_names[] = {"anisotropic", "isotropic", NULL};
static const char *const core_surface_names[] = {"smooth", "sharp", NULL};
static const char *const on_off_names[] = {"on", "off", NULL};

static int parse(job *j, int argc, char **argv) {
  const cli_option table[] = {
      {"-o", CLI_TEXT, &j->path[TARGET_SOLID], 0, 0, NULL},
      {"--output", CLI_TEXT, &j->path[TARGET_SOLID], 0, 0, NULL},
      {"--report", CLI_TEXT, &j->path[TARGET_REPORT], 0, 0, NULL},
      {"--vtu", CLI_TEXT, &j->path[TARGET_VTU], 0, 0, NULL},
      {"--effort", CLI_CHOICE, &j->effort, 0, 0, effort_names},
      {"--threads", CLI_COUNT, &j->n_threads, 0, 256, NULL},
      {"--refine-knots", CLI_COUNT, &j->boundary_options.refine_knots, 0, 6, NULL},
      {"--raise-degree", CLI_COUNT, &j->boundary_options.raise_degree, 0, 24, NULL},
      {"--min-cells", CLI_COUNT, &j->tmesh_options.min_cells, 1, 256, NULL},
      {"--octree", CLI_CHOICE, &j->tmesh_options.isotropic, 0, 0, octree_names},
      {"--analysis-suitable", CLI_CHOICE, &j->tmesh_options.analysis_suitable_off, 0, 0,
       on_off_names},
      {"--core-surface", CLI_CHOICE, &j->tmesh_options.sharp_core, 0, 0, core_surface_names},
      {"--tolerance", CLI_NUMBER, &j->boundary_options.tolerance, 0, 0, NULL},
      {NULL, CLI_TEXT, NULL, 0, 0, NULL}};
  int code = cli_parse(argc, argv, help, table, &j->input);
  if (code < 0 && !j->path[TARGET_SOLID])
    return cli_error("Where to? -o OUT.tsolid is missing");
  return code;
}

static double lap(job *j) {
  double now = cli_seconds(), seconds = now - j->clock;
  j->clock = now;
  return seconds;
}

static tsolid_status make_boundary(job *j) {
  cli_input file;
  tsolid_requirement requirement = {.genus = -1};
  tsolid_status status = cli_input_read(j->context, j->input, &file);
  if (status == TSOLID_OK)
    status = tsolid_boundary_create(j->context, &file.boundary, &j->boundary_options, &requirement,
                                    &j->boundary);
  if (status == TSOLID_ERROR_REFUSED && (file.file || file.surface)) {
    cli_print_surface(file.surface);
    cli_print_requirement(&requirement);
  }
  cli_input_free(&file);
  return status;
}

static tsolid_status make_start(job *j) {
  tsolid_status status = tsolid_solid_create(j->context, j->space, &j->start);
  j->timing.start = lap(j);
  return status;
}

static tsolid_status improve(job *j) {
  tsolid_solid_options options = {.effort = j->effort};
  tsolid_status status = tsolid_solid_optimise(j->context, j->start, &options, &j->solid);
  j->timing.optimise = lap(j);
  return status;
}

static tsolid_status measure(job *j) {
  tsolid_status status = tsolid_report_measure(j->context, j->solid, NULL, &j->report);
  tsolid_timing *timing = &j->report.timing;
  timing->boundary = j->timing.boundary;
  timing->tmesh = j->timing.tmesh;
  timing->space = j->timing.space;
  timing->start = j->timing.start;
  timing->optimise = j->timing.optimise;
  timing->total = cli_seconds() - j->begun;
  timing->peak_memory_mib = cli_peak_memory_mib();
  return status;
}

/* From the file to the measured solid. */
static tsolid_status build(job *j) {
  j->begun = j->clock = cli_seconds();
  tsolid_status status = make_boundary(j);
  j->timing.boundary = lap(j);
  if (status == TSOLID_OK)
    status = tsolid_tmesh_create(j->context, j->boundary, &j->tmesh_options, &j->tmesh);
  j->timing.tmesh = lap(j);
  if (status == TSOLID_OK)
    status = tsolid_space_create(j->context, j->boundary, j->tmesh, &j->space);
  j->timing.space = lap(j);
  if (status == TSOLID_OK)
    status = make_start(j);
  if (status == TSOLID_OK)
    status = improve(j);
  if (status == TSOLID_OK)
    status = measure(j);
  return status;
}

/* Nothing stands under its own name before everything is written. */
static tsolid_status write_all(job *j) {
  cli_target *target = j->target;
  tsolid_status status = TSOLID_OK;
  if (target[TARGET_VTU].path)
    status = tsolid_write_vtu(j->context, j->solid, target[TARGET_VTU].staged);
  if (status == TSOLID_OK && target[TARGET_REPORT].path &&
      !cli_write_json(j->context, &j->report, target[TARGET_REPORT].staged))
    status = TSOLID_ERROR_IO;
  if (status == TSOLID_OK)
    status = tsolid_write_tsolid(j->context, j->solid, target[TARGET_SOLID].staged);
  if (status == TSOLID_OK && cli_interrupted())
    status = TSOLID_ERROR_CANCELLED;
  if (status == TSOLID_OK && !cli_targets_commit(target, N_TARGETS))
    status = TSOLID_ERROR_IO;
  cli_targets_discard(target, N_TARGETS);
  return status;
}

int cli_build(int argc, char **argv) {
  job j = {.input = NULL};
  int code = parse(&j, argc, argv);
  if (code >= 0)
    return code;
  if (!cli_targets_open(j.target, j.path, N_TARGETS, j.input))
    return CLI_FAILED;
  j.context = cli_open(j.n_threads);
  if (!j.context)
    return CLI_FAILED;
  tsolid_status status = build(&j);
  if (status == TSOLID_OK)
    status = write_all(&j);
  if (status == TSOLID_OK)
    cli_print_report(&j.report);
  tsolid_solid_free(j.solid);
  tsolid_solid_free(j.start);
  tsolid_space_free(j.space);
  tsolid_tmesh_free(j.tmesh);
  tsolid_boundary_free(j.boundary);
  fflush(stdout);
  return cli_close(j.context, status, cli_verdict_code(&j.report.certificate));
}
