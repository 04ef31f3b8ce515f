/* SPDX-License-Identifier: LGPL-2.1-or-later
 * tsolid convert: a surface in another format. */
#include <string.h>

#include "cli.h"

static const char help[] =
    "tsolid convert IN OUT\n"
    "\n"
    "Writes the T-spline surface IN (.tsm, .iga), open or closed, as OUT:\n"
    "\n"
    "  OUT.tsb   exact B-spline patches, as few as rectangles of faces allow\n"
    "  OUT.tsm   the T-spline itself, with the numbers of its records (from .tsm only)\n";

static int ends_with(const char *text, const char *end) {
  size_t n = strlen(text), m = strlen(end);
  return n >= m && strcmp(text + n - m, end) == 0;
}

static tsolid_status write_patches(tsolid_context *context, const tsolid_surface *surface,
                                   const char *path) {
  tsolid_boundary_file *patches = NULL;
  tsolid_status status = tsolid_surface_patches(context, surface, &patches);
  if (status == TSOLID_OK)
    status = tsolid_write_tsb(context, tsolid_boundary_file_input(patches), path);
  tsolid_boundary_file_free(patches);
  return status;
}

int cli_convert(int argc, char **argv) {
  const char *path[2];
  cli_input input;
  cli_target target = {.path = NULL};
  const cli_option table[] = {{NULL, CLI_TEXT, NULL, 0, 0, NULL}};
  int code = cli_parse_two(argc, argv, help, table, path);
  if (code >= 0)
    return code;
  int to_tsm = ends_with(path[1], ".tsm");
  if (!to_tsm && !ends_with(path[1], ".tsb"))
    return cli_error("'%s' should end with .tsm or .tsb", path[1]);
  if (!cli_targets_open(&target, &path[1], 1, path[0]))
    return CLI_FAILED;
  tsolid_context *context = cli_open(0);
  if (!context)
    return CLI_FAILED;
  tsolid_status status = cli_input_read(context, path[0], &input);
  if (status == TSOLID_OK && !input.surface) {
    status = TSOLID_ERROR_ARGUMENT;
    cli_error("'%s' is no surface: only .tsm and .iga are converted", path[0]);
  }
  if (status == TSOLID_OK)
    status = to_tsm ? tsolid_write_tsm(context, input.surface, target.staged)
                    : write_patches(context, input.surface, target.staged);
  if (status == TSOLID_OK && !cli_targets_commit(&target, 1))
    status = TSOLID_ERROR_IO;
  cli_targets_discard(&target, 1);
  cli_input_free(&input);
  return cli_close(context, status, CLI_PROVED);
}
