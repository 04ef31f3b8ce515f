/* SPDX-License-Identifier: LGPL-2.1-or-later
 * tsolid export: a solid in other programs' formats. */
#include <stdio.h>

#include "cli.h"

static const char help[] = "tsolid export IN.tsolid --vtu FILE\n"
                           "\n"
                           "  --vtu FILE    rational Bezier hexahedra for VTK and ParaView, with "
                           "the block and the scaled\n"
                           "                Jacobian of every element\n";

int cli_export(int argc, char **argv) {
  const char *input = NULL, *vtu = NULL;
  tsolid_solid *solid = NULL;
  cli_target target = {.path = NULL};
  const cli_option table[] = {{"--vtu", CLI_TEXT, &vtu, 0, 0, NULL},
                              {NULL, CLI_TEXT, NULL, 0, 0, NULL}};
  int code = cli_parse(argc, argv, help, table, &input);
  if (code >= 0)
    return code;
  if (!vtu)
    return cli_error("Where to? --vtu FILE is missing");
  if (!cli_target_open(&target, vtu, input))
    return CLI_FAILED;
  tsolid_context *context = cli_open(0);
  if (!context)
    return CLI_FAILED;
  tsolid_status status = tsolid_read_tsolid(context, input, &solid);
  if (status == TSOLID_OK)
    status = tsolid_write_vtu(context, solid, vtu);
  tsolid_solid_free(solid);
  return cli_close(context, status, CLI_PROVED);
}
