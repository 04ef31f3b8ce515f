/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Boundaries from files of any kind, told apart by their content. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "cli.h"

enum { MAX_LINES = 10000, LINE_SIZE = 64 };

typedef enum file_kind { KIND_TSB, KIND_TSM, KIND_IGA } file_kind;

/* The first line says it: #TS0200 in .tsm, in .iga a keyword behind comments; all else is taken for
 * .tsb, whose reader explains what is wrong. */
static file_kind find_kind(const char *path) {
  char line[LINE_SIZE];
  file_kind kind = KIND_TSB;
  int at_start = 1;
  FILE *file = fopen(path, "rb");
  if (!file)
    return kind; /* the reader tells why */
  for (int k = 0; k < MAX_LINES && fgets(line, sizeof line, file); k++) {
    const char *c = k == 0 && strncmp(line, "\xef\xbb\xbf", 3) == 0 ? line + 3 : line;
    int was_start = at_start;
    at_start = strchr(line, '\n') != NULL;
    if (k == 0 && strncmp(c, "#TS0", 4) == 0) {
      kind = KIND_TSM;
      break;
    }
    while (isspace((unsigned char)*c))
      c++;
    if (!was_start || !*c || *c == '#')
      continue;
    if (strncmp(c, "type", 4) == 0 || strncmp(c, "nodeN", 5) == 0 || strncmp(c, "elemN", 5) == 0)
      kind = KIND_IGA;
    break;
  }
  fclose(file);
  return kind;
}

tsolid_status cli_input_read(tsolid_context *context, const char *path, cli_input *input) {
  *input = (cli_input){.file = NULL};
  tsolid_status status;
  switch (find_kind(path)) {
  case KIND_TSM:
    status = tsolid_read_tsm(context, path, &input->surface);
    break;
  case KIND_IGA:
    status = tsolid_read_iga(context, path, &input->surface);
    break;
  default:
    status = tsolid_read_tsb(context, path, &input->file);
    if (status == TSOLID_OK)
      input->boundary = *tsolid_boundary_file_input(input->file);
  }
  if (input->surface)
    input->boundary.surface = input->surface;
  return status;
}

void cli_input_free(cli_input *input) {
  tsolid_boundary_file_free(input->file);
  tsolid_surface_free(input->surface);
}

void cli_print_surface(const tsolid_surface *surface) {
  tsolid_surface_view v;
  const char *separator = ": ";
  if (!surface)
    return;
  tsolid_surface_get(surface, &v);
  printf("Surface       ");
  if (v.n_boundary_loops == 0)
    printf("closed");
  else
    printf("open: %d boundary loop%s of %d edges", v.n_boundary_loops,
           v.n_boundary_loops == 1 ? "" : "s", v.n_boundary_edges);
  if (v.n_parts > 1)
    printf(", %d separate parts", v.n_parts);
  printf("\n              %d faces, %d edges, %d vertices, %d T-junctions, %d control points, "
         "%d Bezier elements\n",
         v.n_faces, v.n_edges, v.n_vertices, v.n_t_junctions, v.n_points, v.n_elements);
  printf("              %d extraordinary vertices inside", v.n_extraordinary);
  for (int k = 0; k < v.n_extraordinary && k < 12; k++) {
    printf("%s%d (valence %d)", separator, v.extraordinary[k], v.valence[k]);
    separator = ", ";
  }
  printf(v.n_extraordinary > 12 ? ", ...\n" : "\n");
  printf("              functions sum to one within %.3g\n", v.sum_defect);
}
