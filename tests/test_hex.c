/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Hexahedra: every inner face belongs to two elements and every outer one to one region, boundary
 * nodes lie on the boundary, volumes converge to the solid's, borders of regions are mesh lines,
 * the bits do not depend on threads, and what cannot be meshed is refused. */
#include "check.h"

#include "conform.h"
#include "cube_part.h"
#include "hex_checks.h"
#include "parts.h"

static const cube_axis MIXED[3] = {{3, 2, 1}, {2, 2, 1}, {1, 3, 1}};

static tsolid_context *new_context(int n_threads) {
  tsolid_context_options options = {.n_threads = n_threads};
  tsolid_context *context = NULL;
  CHECK(tsolid_context_create(&options, &context) == TSOLID_OK);
  return context;
}

/* ---- geometry ----------------------------------------------------------------------------------
 */

/* Nodes of the outer faces lie on the boundary: point inversion finds them at r = R. */
static void check_boundary_nodes(tsolid_context *context, const tsolid_solid *solid,
                                 const tsolid_hex_view *v) {
  double scale = tsolid_boundary_scale(tsolid_space_boundary(tsolid_solid_space(solid)));
  long n_off = 0;
  for (int k = 0; k < v->region_start[v->n_regions]; k += 7)
    for (int m = 0; m < 4; m++) {
      const int *e = v->element + (size_t)v->region_face[2 * k] * (size_t)v->nodes_per_element;
      const double *point = v->nodes + 3 * (size_t)e[face_corner[v->region_face[2 * k + 1]][m]];
      int found = 0, block = 0;
      double u[3], distance = INFINITY;
      tsolid_status status =
          tsolid_solid_invert(context, solid, point, 1e-9 * scale, &found, &block, u, &distance);
      int axis = tsi_side_axis(block - 1), side = block - 1;
      double end[3];
      n_off += status || !found || block == 0 || distance > 1e-9 * scale;
      if (block > 0) {
        tsolid_solid_boundary_point(solid, side, 0.5, 0.5, end);
        n_off += fabs(u[axis] - end[axis]) > 1e-6;
      }
    }
  CHECK(n_off == 0);
}

static void check_counts(const tsolid_hex_view *v, long n_outer) {
  int x = v->divisions[0], y = v->divisions[1], z = v->divisions[2], r = v->divisions[3];
  CHECK(v->n_elements == x * y * z + 2 * r * (x * y + y * z + z * x));
  CHECK(n_outer == 2 * (x * y + y * z + z * x));
  CHECK(n_outer == v->region_start[v->n_regions]);
}

static double volume_of(tsolid_context *context, const tsolid_solid *solid, int order, int n) {
  tsolid_hex_options options = {.order = order, .divisions = {n, n, n, n / 2}};
  tsolid_hex_view view;
  tsolid_hex *hex = NULL;
  double volume = NAN;
  if (CHECK(tsolid_hex_create(context, solid, &options, &hex) == TSOLID_OK)) {
    tsolid_hex_get(hex, &view);
    CHECK(view.order == order && view.proved && view.worst > 0.0);
    check_counts(&view, check_topology(&view));
    check_boundary_nodes(context, solid, &view);
    volume = mesh_volume(&view);
  }
  tsolid_hex_free(hex);
  return volume;
}

static void test_convergence(tsolid_context *context, const tsolid_solid *solid) {
  static const double least_order[3] = {0.0, 1.8, 3.5};
  tsolid_conformity_report conformity;
  if (!CHECK(tsi_conformity_measure(context, solid, &conformity) == TSOLID_OK))
    return;
  for (int order = 1; order <= 2; order++) {
    double error[3];
    for (int k = 0; k < 3; k++)
      error[k] = fabs(volume_of(context, solid, order, 6 << k) / conformity.volume - 1.0);
    printf("order %d: relative errors of the volume %.3g %.3g %.3g\n", order, error[0], error[1],
           error[2]);
    CHECK(log2(error[1] / error[2]) > least_order[order]);
    CHECK(error[2] < 5e-3);
  }
}

/* ---- options -----------------------------------------------------------------------------------
 */

static void test_regions(tsolid_context *context, const tsolid_solid *solid) {
  static const tsolid_region region[] = {{"left", 5, {0.0, 0.3, 0.0, 1.0}},
                                         {"right", 5, {0.3, 1.0, 0.0, 1.0}},
                                         {"f", 0, {0, 1, 0, 1}}};
  tsolid_hex_options options = {
      .divisions = {5, 3, 4, 2}, .grading = 0.5, .n_regions = 3, .regions = region};
  tsolid_hex_view v;
  tsolid_hex *hex = NULL;
  if (!CHECK(tsolid_hex_create(context, solid, &options, &hex) == TSOLID_OK))
    return;
  tsolid_hex_get(hex, &v);
  CHECK(v.n_regions == 3 && strcmp(v.region_name[1], "right") == 0);
  int left = v.region_start[1], right = v.region_start[2] - left;
  CHECK(left > 0 && right > 0 && left + right == 15 && left % 3 == 0);
  CHECK(v.region_start[3] - v.region_start[2] == 12);
  tsolid_hex_free(hex);
  static const tsolid_region pieces[] = {{"face", 5, {0.3, 1.0, 0.0, 1.0}},
                                         {"f", 0, {0, 1, 0, 1}},
                                         {"face", 5, {0.0, 0.3, 0.0, 1.0}},
                                         {"f", 2, {0, 1, 0, 1}}};
  options.regions = pieces; /* of one name: one region */
  options.n_regions = 4;
  if (CHECK(tsolid_hex_create(context, solid, &options, &hex) == TSOLID_OK)) {
    tsolid_hex_get(hex, &v);
    CHECK(v.n_regions == 2 && strcmp(v.region_name[0], "face") == 0);
    CHECK(strcmp(v.region_name[1], "f") == 0 && v.region_start[1] == 15);
    CHECK(v.region_start[2] - v.region_start[1] == 12 + 20);
    tsolid_hex_free(hex);
  }
  options.regions = region;
  options.n_regions = 3;
  options.divisions[0] = 1;
  CHECK(tsolid_hex_create(context, solid, &options, &hex) == TSOLID_ERROR_REFUSED && !hex);
}

static void test_refusals(tsolid_context *context, const tsolid_solid *solid) {
  static const tsolid_region bad[] = {{"a", 6, {0, 1, 0, 1}},
                                      {"a", 0, {0.5, 0.5, 0, 1}},
                                      {"a", 0, {0, 1, 0, NAN}},
                                      {"", 0, {0, 1, 0, 1}},
                                      {NULL, 0, {0, 1, 0, 1}}};
  tsolid_hex *hex = NULL;
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
    tsolid_hex_options options = {.n_regions = 1, .regions = &bad[k]};
    CHECK(tsolid_hex_create(context, solid, &options, &hex) == TSOLID_ERROR_ARGUMENT && !hex);
  }
  tsolid_hex_options wrong[] = {
      {.order = 3}, {.size = -1.0}, {.size = NAN}, {.grading = 1e9}, {.divisions = {-1, 0, 0, 0}}};
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++)
    CHECK(tsolid_hex_create(context, solid, &wrong[k], &hex) == TSOLID_ERROR_ARGUMENT && !hex);
  tsolid_hex_options many[] = {
      {.size = 1e-9}, {.size = 1e-3}, {.divisions = {999, 999, 9, 9}}, {.max_elements = 10}};
  for (size_t k = 0; k < sizeof many / sizeof *many; k++)
    CHECK(tsolid_hex_create(context, solid, &many[k], &hex) == TSOLID_ERROR_REFUSED && !hex);
  CHECK(tsolid_hex_create(context, NULL, NULL, &hex) == TSOLID_ERROR_ARGUMENT);
  tsolid_hex_free(NULL);
}

/* An inner control point thrown far out: the certificate is lost. */
static void test_not_proved(tsolid_context *context, const tsolid_solid *solid) {
  const tsolid_space *space = tsolid_solid_space(solid);
  size_t n = 4 * (size_t)(space->n_inner + 2 * space->n_surface);
  double *control = malloc(n * sizeof *control);
  tsolid_solid *broken = NULL;
  tsolid_hex *hex = NULL;
  tsolid_hex_options options = {.allow_unproved = 1};
  memcpy(control, tsolid_solid_control(solid), n * sizeof *control);
  for (size_t k = 0; k < 4 * (size_t)space->n_inner; k += 40)
    control[k] += 50.0;
  if (CHECK(tsolid_solid_from_control(context, space, control, &broken) == TSOLID_OK)) {
    CHECK(tsolid_hex_create(context, broken, NULL, &hex) == TSOLID_ERROR_REFUSED && !hex);
    CHECK(tsolid_hex_create(context, broken, &options, &hex) == TSOLID_ERROR_REFUSED && !hex);
  }
  tsolid_solid_free(broken);
  free(control);
}

static void test_threads(const tsolid_solid *solid) {
  tsolid_hex_options options = {.order = 2, .divisions = {4, 5, 6, 3}, .grading = 0.4};
  tsolid_hex_view v[2];
  tsolid_hex *hex[2] = {NULL, NULL};
  for (int k = 0; k < 2; k++) {
    tsolid_context *context = new_context(1 + 2 * k);
    CHECK(tsolid_hex_create(context, solid, &options, &hex[k]) == TSOLID_OK);
    tsolid_context_free(context);
  }
  if (hex[0] && hex[1]) {
    tsolid_hex_get(hex[0], &v[0]);
    tsolid_hex_get(hex[1], &v[1]);
    CHECK(v[0].n_nodes == v[1].n_nodes);
    CHECK(memcmp(v[0].nodes, v[1].nodes, 3 * (size_t)v[0].n_nodes * sizeof(double)) == 0);
  }
  tsolid_hex_free(hex[0]);
  tsolid_hex_free(hex[1]);
}

int main(void) {
  tsolid_context *context = new_context(0);
  cube_solid s;
  tsolid_solid *start = NULL, *solid = NULL;
  if (CHECK(cube_solid_create(context, MIXED, cube_wave, 0, 0.0, &s)) &&
      CHECK(tsolid_solid_create(context, s.space, &start) == TSOLID_OK) &&
      CHECK(tsolid_solid_optimise(context, start, NULL, &solid) == TSOLID_OK)) {
    test_convergence(context, solid);
    test_regions(context, solid);
    test_refusals(context, solid);
    test_not_proved(context, solid);
    test_threads(solid);
  }
  tsolid_solid_free(solid);
  tsolid_solid_free(start);
  cube_solid_free(&s);
  tsolid_context_free(context);
  return check_done();
}
