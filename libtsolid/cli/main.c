/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The `tsolid` command: one file per subcommand, this one finds it. */
#include <stdio.h>
#include <string.h>

#include "cli.h"

static const char help[] =
    "tsolid: conformal solid T-splines from the spline boundary of a part\n"
    "\n"
    "  tsolid check IN                      is this a boundary that a solid can be built on?\n"
    "  tsolid build IN -o OUT.tsolid        build the solid, prove it valid, report\n"
    "  tsolid report OUT.tsolid             measure a solid anew\n"
    "  tsolid export OUT.tsolid --vtu FILE  write it for VTK and ParaView\n"
    "  tsolid convert IN.tsm OUT            a T-spline surface as .tsm, or as patches in .tsb\n"
    "  tsolid assembly A.tsb B.tsb ...      what touches what, gaps, clashes\n"
    "  tsolid COMMAND --help                options of a command\n"
    "  tsolid --version\n"
    "\n"
    "IN is a boundary: patches or Bezier elements (.tsb), a T-spline surface (.tsm), or its "
    "Bezier\n"
    "elements (.iga).\n"
    "\n"
    "Exit codes: 0 the solid is proved valid (det J > 0 everywhere but at named singular points "
    "of\n"
    "the input itself); 2 built, but not proved; 1 refused or failed, nothing was written;\n"
    "130 interrupted.\n";

static const struct {
  const char *name;
  int (*run)(int argc, char **argv);
} commands[] = {{"check", cli_check},   {"build", cli_build},     {"report", cli_report},
                {"export", cli_export}, {"convert", cli_convert}, {"assembly", cli_assembly}};

static int run(int argc, char **argv) {
  if (argc < 2) {
    fputs(help, stderr);
    return CLI_FAILED;
  }
  for (size_t k = 0; k < sizeof commands / sizeof *commands; k++)
    if (strcmp(argv[1], commands[k].name) == 0)
      return commands[k].run(argc - 1, argv + 1);
  if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
    fputs(help, stdout);
    return 0;
  }
  if (strcmp(argv[1], "--version") == 0) {
    printf("tsolid %s\n", tsolid_version());
    return 0;
  }
  return cli_error("Unknown command '%s'; 'tsolid --help' lists them", argv[1]);
}

int main(int argc, char **argv) {
  if (tsolid_abi() != TSOLID_ABI)
    return cli_error("This command needs a library of ABI %d, not %d", TSOLID_ABI, tsolid_abi());
  int code = run(argc, argv);
  if (fflush(stdout) != 0 || ferror(stdout)) {
    cli_error("Cannot write to the standard output");
    code = code == 0 ? CLI_FAILED : code;
  }
  return code;
}
