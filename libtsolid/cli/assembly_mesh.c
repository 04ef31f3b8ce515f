/* SPDX-License-Identifier: LGPL-2.1-or-later
 * One mesh of an assembly: hexahedra that share their nodes where parts touch. */
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"

enum { FACE_SIZE = 16 };

/* The pieces of all patches of one part, called as the patches are or Face1, Face2, ... */
typedef struct part_regions {
  int n;
  tsolid_region *region;
  char (*face)[FACE_SIZE];
} part_regions;

static int name_regions(const tsolid_boundary_input *input, const tsolid_solid *solid,
                        part_regions *to) {
  const tsolid_boundary *boundary = tsolid_space_boundary(tsolid_solid_space(solid));
  int n = 0, n_patches = input->surface || input->bezier ? 0 : input->n_patches;
  for (int k = 0; k < n_patches; k++)
    n += tsolid_boundary_n_placements(boundary, k);
  to->region = calloc((size_t)n + 1, sizeof *to->region);
  to->face = calloc((size_t)n_patches + 1, sizeof *to->face);
  if (!to->region || !to->face)
    return 0;
  for (int k = 0; k < n_patches; k++) {
    snprintf(to->face[k], FACE_SIZE, "Face%d", k + 1);
    for (int i = 0; i < tsolid_boundary_n_placements(boundary, k); i++) {
      tsolid_placement place;
      if (tsolid_boundary_placement(boundary, k, i, &place) != TSOLID_OK)
        continue;
      tsolid_region *region = &to->region[to->n++];
      region->name = input->patches[k].name ? input->patches[k].name : to->face[k];
      region->side = place.side;
      for (int d = 0; d < 4; d++)
        region->box[d] = place.box[d];
    }
  }
  return 1;
}

static void print_mesh(const tsolid_hex *hex) {
  tsolid_hex_view view;
  tsolid_hex_get(hex, &view);
  printf("Hexahedra     %d with %d nodes each in %d parts, %d nodes, %d more shared\n"
         "              smallest scaled Jacobian %.6g\n",
         view.n_elements, view.nodes_per_element, view.n_parts, view.n_nodes, view.n_shared,
         view.worst);
}

tsolid_status cli_mesh_assembly(tsolid_context *context, const tsolid_assembly *assembly, int n,
                                const tsolid_part *part, const tsolid_solid *const *solid,
                                const tsolid_hex_options *options, const char *inp,
                                const char *vtu) {
  part_regions *regions = calloc((size_t)n, sizeof *regions);
  tsolid_hex_part *own = calloc((size_t)n, sizeof *own);
  tsolid_hex *hex = NULL;
  tsolid_status status = regions && own ? TSOLID_OK : TSOLID_ERROR_MEMORY;
  for (int k = 0; k < n && !status; k++) {
    if (!solid[k])
      continue;
    if (!name_regions(part[k].boundary, solid[k], &regions[k]))
      status = TSOLID_ERROR_MEMORY;
    own[k].n_regions = regions[k].n;
    own[k].regions = regions[k].region;
  }
  if (status)
    cli_error("Out of memory");
  else
    status = tsolid_hex_assembly_create(context, assembly, n, solid, own, options, &hex);
  if (!status && inp)
    status = tsolid_write_inp(context, hex, inp);
  if (!status && vtu)
    status = tsolid_write_hex_vtu(context, hex, vtu);
  if (!status)
    print_mesh(hex);
  tsolid_hex_free(hex);
  for (int k = 0; regions && k < n; k++) {
    free(regions[k].region);
    free(regions[k].face);
  }
  free(regions);
  free(own);
  return status;
}
