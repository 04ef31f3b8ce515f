/* SPDX-License-Identifier: LGPL-2.1-or-later
 * tsolid check: the requirement, and what would be changed before the construction. */
#include <stdio.h>

#include "cli.h"

static const char help[] =
    "tsolid check IN [--tolerance T]\n"
    "\n"
    "IN: .tsb, .tsm or .iga, told apart by content.\n"
    "Says whether the boundary is one that a solid T-spline can be built on: closed, connected,\n"
    "of genus zero, with exactly eight extraordinary vertices that twelve isolines join like the\n"
    "edges of a cube. Exit code 0: yes, 1: no, with the reasons.\n"
    "\n"
    "  --tolerance T   tolerance of borders for which the file names none (default 1e-7)\n";

int cli_check(int argc, char **argv) {
  const char *input = NULL;
  tsolid_boundary_options options = {.tolerance = 0};
  tsolid_requirement requirement = {.genus = -1};
  tsolid_preparation preparation;
  cli_input file;
  tsolid_boundary *boundary = NULL;
  const cli_option table[] = {{"--tolerance", CLI_NUMBER, &options.tolerance, 0, 0, NULL},
                              {NULL, CLI_TEXT, NULL, 0, 0, NULL}};
  int code = cli_parse(argc, argv, help, table, &input);
  if (code >= 0)
    return code;
  tsolid_context *context = cli_open(0);
  if (!context)
    return CLI_FAILED;
  tsolid_status status = cli_input_read(context, input, &file);
  if (status == TSOLID_OK) {
    cli_print_surface(file.surface);
    status = tsolid_boundary_create(context, &file.boundary, &options, &requirement, &boundary);
    if (status == TSOLID_OK || status == TSOLID_ERROR_REFUSED)
      cli_print_requirement(&requirement);
  }
  if (status == TSOLID_OK) {
    tsolid_boundary_preparation(boundary, &preparation);
    cli_print_preparation(&preparation);
  }
  tsolid_boundary_free(boundary);
  cli_input_free(&file);
  fflush(stdout);
  return cli_close(context, status, CLI_PROVED);
}
