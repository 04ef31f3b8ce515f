/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Named regions of the boundary, from a text file: one a line, NAME SIDE S0 S1 T0 T1, where SIDE is
 * x_low, x_high, ... z_high; '#' begins a comment. Lines of one name are pieces of one region.
 * Without a file: the six sides. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static const char *const side_name[6] = {"x_low", "x_high", "y_low", "y_high", "z_low", "z_high"};

enum { LINE_SIZE = 512 };

/* Names become parts of file names. */
static int good_name(const char *name) {
  static const char allowed[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  return strlen(name) == strspn(name, allowed);
}

static int good_box(const double box[4]) {
  return box[0] >= 0 && box[0] < box[1] && box[1] <= 1 && box[2] >= 0 && box[2] < box[3] &&
         box[3] <= 1;
}

static int add_region(cli_regions *regions, const char *name, int side, const double box[4]) {
  tsolid_region *grown =
      realloc(regions->region, ((size_t)regions->n + 1) * sizeof *regions->region);
  char *copy = malloc(strlen(name) + 1);
  if (grown)
    regions->region = grown;
  if (!grown || !copy) {
    free(copy);
    cli_error("Out of memory");
    return 0;
  }
  strcpy(copy, name);
  tsolid_region *region = &regions->region[regions->n++];
  *region = (tsolid_region){.name = copy, .side = side};
  memcpy(region->box, box, sizeof region->box);
  return 1;
}

static int add_line(cli_regions *regions, const char *path, int number, char *line) {
  char name[LINE_SIZE], side[LINE_SIZE], more[2];
  double box[4];
  line[strcspn(line, "#")] = 0;
  int n = sscanf(line, "%s %s %lf %lf %lf %lf %1s", name, side, &box[0], &box[1], &box[2], &box[3],
                 more);
  if (n <= 0)
    return 1;
  int which = 0;
  while (n > 1 && which < 6 && strcmp(side, side_name[which]) != 0)
    which++;
  if (n != 6 || which == 6 || !good_box(box)) {
    cli_error("Line %d of '%s' is not NAME SIDE S0 S1 T0 T1 with x_low to z_high for SIDE and "
              "numbers from 0 to 1",
              number, path);
    return 0;
  }
  if (!good_name(name) || strlen(name) > CLI_NAME_SIZE / 2) {
    cli_error("Line %d of '%s': a name has at most %d letters, digits, '_' and '-', unlike '%s'",
              number, path, CLI_NAME_SIZE / 2, name);
    return 0;
  }
  return add_region(regions, name, which, box);
}

static int read_file(cli_regions *regions, const char *path) {
  char line[LINE_SIZE];
  FILE *file = fopen(path, "r");
  int ok = file != NULL;
  if (!ok)
    cli_error("Cannot read '%s'", path);
  for (int number = 1; ok && fgets(line, sizeof line, file); number++) {
    ok = strchr(line, '\n') || feof(file) ? add_line(regions, path, number, line) : 0;
    if (!ok && !strchr(line, '\n') && !feof(file))
      cli_error("Line %d of '%s' is too long", number, path);
  }
  if (ok && ferror(file)) {
    cli_error("Cannot read '%s'", path);
    ok = 0;
  }
  if (ok && regions->n == 0) {
    cli_error("'%s' names no region", path);
    ok = 0;
  }
  if (file)
    fclose(file);
  return ok;
}

int cli_regions_read(cli_regions *regions, const char *path) {
  static const double whole[4] = {0, 1, 0, 1};
  memset(regions, 0, sizeof *regions);
  if (path)
    return read_file(regions, path);
  for (int side = 0; side < 6; side++)
    if (!add_region(regions, side_name[side], side, whole))
      return 0;
  return 1;
}

void cli_regions_free(cli_regions *regions) {
  for (int k = 0; k < regions->n; k++)
    free((char *)regions->region[k].name);
  free(regions->region);
  memset(regions, 0, sizeof *regions);
}
