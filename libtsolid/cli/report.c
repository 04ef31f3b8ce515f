/* SPDX-License-Identifier: LGPL-2.1-or-later
 * tsolid report: everything measured anew from the file alone. */
#include <stdio.h>
#include <string.h>

#include "cli.h"

static const char help[] =
    "tsolid report IN.tsolid [--json FILE] [--threads N]\n"
    "\n"
    "Measures a solid anew and prints the facts. Exit code 0: proved valid; 2: not proved.\n"
    "\n"
    "  --json FILE    the report as JSON; '-': on the standard output instead of the facts\n"
    "  --threads N    0 (default): all processors; results do not depend on it\n";

static tsolid_status write_json(tsolid_context *context, const tsolid_report *report,
                                cli_target *target) {
  tsolid_status status = TSOLID_OK;
  if (!cli_write_json(context, report, target->staged) || !cli_targets_commit(target, 1))
    status = TSOLID_ERROR_IO;
  cli_targets_discard(target, 1);
  return status;
}

int cli_report(int argc, char **argv) {
  const char *input = NULL, *json = NULL;
  int n_threads = 0;
  tsolid_solid *solid = NULL;
  tsolid_report report;
  cli_target target = {.path = NULL};
  const cli_option table[] = {{"--json", CLI_TEXT, &json, 0, 0, NULL},
                              {"--threads", CLI_COUNT, &n_threads, 0, 256, NULL},
                              {NULL, CLI_TEXT, NULL, 0, 0, NULL}};
  int code = cli_parse(argc, argv, help, table, &input);
  if (code >= 0)
    return code;
  int to_stdout = json && strcmp(json, "-") == 0;
  if (json && !to_stdout && !cli_targets_open(&target, &json, 1, input))
    return CLI_FAILED;
  tsolid_context *context = cli_open(n_threads);
  if (!context)
    return CLI_FAILED;
  double begin = cli_seconds();
  tsolid_status status = tsolid_read_tsolid(context, input, &solid);
  if (status == TSOLID_OK)
    status = tsolid_report_measure(context, solid, NULL, &report);
  if (status == TSOLID_OK) {
    report.timing.total = cli_seconds() - begin;
    report.timing.peak_memory_mib = cli_peak_memory_mib();
    code = cli_verdict_code(&report.certificate);
    if (to_stdout)
      status = cli_write_json(context, &report, json) ? TSOLID_OK : TSOLID_ERROR_IO;
    else if (json)
      status = write_json(context, &report, &target);
    if (status == TSOLID_OK && !to_stdout)
      cli_print_report(&report);
  }
  tsolid_solid_free(solid);
  fflush(stdout);
  return cli_close(context, status, code);
}
