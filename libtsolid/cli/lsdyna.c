/* SPDX-License-Identifier: LGPL-2.1-or-later
 * tsolid export --lsdyna: an include deck of LS-DYNA round a BEXT file: the elements
 * (*IGA_INCLUDE_BEZIER: file; type 1, part, dimension), part, section and material. Fields are ten
 * columns wide. Loads, constraints and control cards are the user's. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "cli.h"

enum { SPLINE_SOLID = 201 }; /* the element formulation of spline solids */

int cli_lsdyna_write(const char *path, const char *bext, const tsolid_material *material,
                     double density, int proved) {
  const char *slash = strrchr(bext, '/');
  FILE *file = fopen(path, "w");
  if (!file) {
    cli_error("Cannot write '%s': %s", path, strerror(errno));
    return 0;
  }
  fprintf(file, "*KEYWORD\n*TITLE\nsolid T-spline, made by tsolid %s\n", tsolid_version());
  if (!proved)
    fprintf(file, "$ The solid is NOT proved valid: det J > 0 is not certain.\n");
  fprintf(file, "*IGA_INCLUDE_BEZIER\n%s\n$ filetype       pid       dim\n%10d%10d%10d\n",
          slash ? slash + 1 : bext, 1, 1, 3);
  fprintf(file, "*PART\nsolid T-spline\n$      pid     secid       mid\n%10d%10d%10d\n", 1, 1, 1);
  fprintf(file, "*SECTION_SOLID\n$    secid    elform\n%10d%10d\n", 1, SPLINE_SOLID);
  fprintf(file,
          "*MAT_ELASTIC\n$      mid        ro         e        pr\n%10d%10.4g%10.4g%10.4g\n*END\n",
          1, density, material->young, material->poisson);
  int ok = !ferror(file);
  if (fclose(file) != 0 || !ok) {
    cli_error("Cannot write '%s'", path);
    return 0;
  }
  return 1;
}
