/* SPDX-License-Identifier: LGPL-2.1-or-later
 *
 * A block 2 x 1 x 1 from its six faces to a certified solid, with the installed tsolid. */
#include <math.h>
#include <stdio.h>

#include <tsolid.h>

static const double block_size[3] = {2, 1, 1};
static const double knots[4] = {0, 0, 1, 1};

/* The flat face at the low or high end of an axis, spanned by the two other axes. */
static void make_face(int axis, int end, double points[12], tsolid_patch *patch) {
  int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  for (int corner = 0; corner < 4; corner++) {
    double *point = points + 3 * corner;
    point[axis] = end * block_size[axis];
    point[u] = (corner & 1) * block_size[u];
    point[v] = (corner >> 1) * block_size[v];
  }
  *patch = (tsolid_patch){
      .degree = {1, 1}, .n_control = {2, 2}, .knots = {knots, knots}, .points = points};
}

static void print_findings(const tsolid_context *context) {
  for (int i = 0; i < tsolid_context_n_findings(context); i++) {
    const tsolid_finding *finding = tsolid_context_finding(context, i);
    printf("%s: %s\n", finding->stage, finding->text);
  }
}

/* Patches to solid; the caller frees *solid. */
static tsolid_status build(tsolid_context *context, const tsolid_boundary_input *input,
                           tsolid_solid **solid) {
  tsolid_boundary *boundary = NULL;
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_solid *start = NULL;
  tsolid_status status = tsolid_boundary_create(context, input, NULL, NULL, &boundary);
  if (!status)
    status = tsolid_tmesh_create(context, boundary, NULL, &tmesh);
  if (!status)
    status = tsolid_space_create(context, boundary, tmesh, &space);
  if (!status)
    status = tsolid_solid_create(context, space, &start);
  if (!status)
    status = tsolid_solid_optimise(context, start, NULL, solid);
  tsolid_solid_free(start);
  tsolid_space_free(space);
  tsolid_tmesh_free(tmesh);
  tsolid_boundary_free(boundary);
  return status;
}

int main(void) {
  double points[6][12];
  tsolid_patch patches[6];
  for (int face = 0; face < 6; face++)
    make_face(face / 2, face % 2, points[face], &patches[face]);
  tsolid_boundary_input input = {.n_patches = 6, .patches = patches};

  if (tsolid_abi() != TSOLID_ABI)
    return 1;
  tsolid_context *context = NULL;
  tsolid_solid *solid = NULL;
  tsolid_report report;
  if (tsolid_context_create(NULL, &context))
    return 1;
  tsolid_status status = build(context, &input, &solid);
  if (!status)
    status = tsolid_report_measure(context, solid, NULL, &report);
  print_findings(context);
  int good = !status && report.certificate.verdict == TSOLID_POSITIVE &&
             fabs(report.conformity.volume - 2) < 1e-12 && report.quality.worst > 0;
  if (!status)
    printf("tsolid %s: volume %.15g, worst scaled Jacobian %.3f\n", tsolid_version(),
           report.conformity.volume, report.quality.worst);
  tsolid_solid_free(solid);
  tsolid_context_free(context);
  return good ? 0 : 1;
}
