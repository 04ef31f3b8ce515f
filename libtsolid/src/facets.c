/* SPDX-License-Identifier: LGPL-2.1-or-later
 * What the check of the cube needs to know of a NURBS patch. */
#include "boundary.h"
#include "vector.h"

/* Length of the control polygon of border b. */
static double measure_border(const tsi_patch *patch, int b) {
  int along = b & 1;
  size_t n0 = (size_t)patch->n[0], n1 = (size_t)patch->n[1];
  size_t start = b == 1 ? n0 - 1 : b == 2 ? n0 * (n1 - 1) : 0, step = along ? n0 : 1;
  double length = 0.0, previous[3], point[3];
  for (size_t m = 0; m < (size_t)patch->n[along]; m++) {
    tsi_project_point(patch->control + 4 * (start + m * step), point);
    if (m)
      length += tsi_distance(point, previous);
    memcpy(previous, point, sizeof previous);
  }
  return length;
}

void tsi_facet_measure(const tsi_patch *patch, const double origin[3], tsi_facet *facet) {
  size_t n0 = (size_t)patch->n[0], n1 = (size_t)patch->n[1];
  size_t at[4] = {0, n0 - 1, n0 * n1 - 1, n0 * (n1 - 1)};
  for (int b = 0; b < 4; b++) {
    tsi_project_point(patch->control + 4 * at[b], facet->corner[b]);
    for (int i = 0; i < 3; i++) {
      double uv[2];
      tsi_border_point(b, 0.25 * (i + 1), uv);
      tsi_patch_point(patch, uv[0], uv[1], facet->sample[b][i]);
    }
    facet->length[b] = measure_border(patch, b);
  }
  tsi_patch_point(patch, 0.5, 0.5, facet->centre);
  tsi_patch_measure(patch, origin, &facet->area, &facet->flux);
}

const char *tsi_name_facet(const tsi_facet *facet, char text[TSI_NAME_SIZE]) {
  return tsi_name_patch(facet->name, facet->patch, text);
}
