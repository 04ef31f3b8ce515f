/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Hexahedra: every inner face belongs to two elements and every outer one to one region, boundary
 * nodes lie on the boundary, volumes converge to the solid's, borders of regions are mesh lines,
 * the bits do not depend on threads, and what cannot be meshed is refused. */
#include "check.h"

#include "conform.h"
#include "cube_part.h"
#include "parts.h"

static const cube_axis MIXED[3] = {{3, 2, 1}, {2, 2, 1}, {1, 3, 1}};

/* S1..S6, corners. */
static const int face_corner[6][4] = {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1},
                                      {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};

static tsolid_context *new_context(int n_threads) {
  tsolid_context_options options = {.n_threads = n_threads};
  tsolid_context *context = NULL;
  CHECK(tsolid_context_create(&options, &context) == TSOLID_OK);
  return context;
}

/* ---- topology ----------------------------------------------------------------------------------
 */

typedef struct face_key {
  int node[4]; /* ascending */
  int element, face;
} face_key;

static int compare_ints(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

static int compare_faces(const void *a, const void *b) {
  const face_key *p = a, *q = b;
  for (int k = 0; k < 4; k++)
    if (p->node[k] != q->node[k])
      return p->node[k] < q->node[k] ? -1 : 1;
  return 0;
}

static void check_topology(const tsolid_hex_view *v) {
  size_t n = 6 * (size_t)v->n_elements;
  face_key *key = calloc(n, sizeof *key);
  unsigned char *in_region = calloc(n, 1), *used = calloc((size_t)v->n_nodes, 1);
  long n_outer = 0, n_inner = 0, n_wrong = 0, n_used = 0;
  for (size_t k = 0; k < n; k++) {
    key[k].element = (int)(k / 6);
    key[k].face = (int)(k % 6);
    for (int m = 0; m < 4; m++)
      key[k].node[m] =
          v->element[(k / 6) * (size_t)v->nodes_per_element + (size_t)face_corner[k % 6][m]];
    qsort(key[k].node, 4, sizeof(int), compare_ints);
  }
  for (int k = 0; k < v->region_start[v->n_regions]; k++)
    in_region[6 * v->region_face[2 * k] + v->region_face[2 * k + 1]]++;
  qsort(key, n, sizeof *key, compare_faces);
  for (size_t i = 0, j; i < n; i = j) {
    for (j = i + 1; j < n && compare_faces(&key[i], &key[j]) == 0; j++) {
    }
    int listed = in_region[6 * key[i].element + key[i].face];
    n_outer += j - i == 1;
    n_inner += j - i == 2;
    n_wrong += j - i > 2 || listed != (j - i == 1);
  }
  for (size_t k = 0; k < (size_t)v->n_elements * (size_t)v->nodes_per_element; k++)
    used[v->element[k]] = 1;
  for (int k = 0; k < v->n_nodes; k++)
    n_used += used[k];
  CHECK(n_wrong == 0);
  CHECK(n_used == v->n_nodes);
  CHECK(n_outer == v->region_start[v->n_regions]);
  CHECK(2 * n_inner + n_outer == (long)n);
  int x = v->divisions[0], y = v->divisions[1], z = v->divisions[2], r = v->divisions[3];
  CHECK(v->n_elements == x * y * z + 2 * r * (x * y + y * z + z * x));
  CHECK(n_outer == 2 * (x * y + y * z + z * x));
  free(used);
  free(in_region);
  free(key);
}

/* ---- geometry ----------------------------------------------------------------------------------
 */

/* Volume from the flux of x/3 through the outer faces; quadratic faces by 4 x 4 Gauss points of the
 * 8-node quadrilateral, which is exact enough to see the order. */
static double face_flux(const tsolid_hex_view *v, int element, int face) {
  static const double gauss[4][2] = {{0.0694318442029737, 0.1739274225687269},
                                     {0.3300094782075719, 0.3260725774312731},
                                     {0.6699905217924281, 0.3260725774312731},
                                     {0.9305681557970263, 0.1739274225687269}};
  static const int mid_of[8][8] = {{0, 8, 0, 11, 16, 0, 0, 0},  {8, 0, 9, 0, 0, 17, 0, 0},
                                   {0, 9, 0, 10, 0, 0, 18, 0},  {11, 0, 10, 0, 0, 0, 0, 19},
                                   {16, 0, 0, 0, 0, 12, 0, 15}, {0, 17, 0, 0, 12, 0, 13, 0},
                                   {0, 0, 18, 0, 0, 13, 0, 14}, {0, 0, 0, 19, 15, 0, 14, 0}};
  const int *e = v->element + (size_t)element * (size_t)v->nodes_per_element;
  const double *p[8];
  for (int k = 0; k < 4; k++) {
    int a = face_corner[face][k], b = face_corner[face][(k + 1) % 4];
    p[k] = v->nodes + 3 * (size_t)e[a];
    p[4 + k] = v->order == 2 ? v->nodes + 3 * (size_t)e[mid_of[a][b]] : NULL;
  }
  double flux = 0.0;
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++) {
      const double sign[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
      double s = 2.0 * gauss[i][0] - 1.0, t = 2.0 * gauss[j][0] - 1.0, x[3][3] = {{0.0}};
      for (int k = 0; k < 4; k++) {
        double a = sign[k][0], b = sign[k][1], f = 1.0 + a * s, g = 1.0 + b * t;
        double h = v->order == 2 ? a * s + b * t - 1.0 : 1.0, q = v->order == 2 ? 1.0 : 0.0;
        double n[3] = {0.25 * f * g * h, 0.25 * (a * g * h + q * f * g * a),
                       0.25 * (b * f * h + q * f * g * b)};
        for (int d = 0; d < 3; d++)
          for (int c = 0; c < 3; c++)
            x[d][c] += n[d] * p[k][c];
      }
      for (int k = 0; v->order == 2 && k < 4; k++) {
        double b = k == 0 || k == 3 ? -1.0 : 1.0, w = k % 2 ? t : s, other = k % 2 ? s : t;
        double value = 0.5 * (1.0 - w * w) * (1.0 + b * other), along = -w * (1.0 + b * other),
               across = 0.5 * (1.0 - w * w) * b;
        double n[3] = {value, k % 2 ? across : along, k % 2 ? along : across};
        for (int d = 0; d < 3; d++)
          for (int c = 0; c < 3; c++)
            x[d][c] += n[d] * p[4 + k][c];
      }
      double weight = 4.0 * gauss[i][1] * gauss[j][1];
      flux += weight / 3.0 *
              (x[0][0] * (x[1][1] * x[2][2] - x[1][2] * x[2][1]) +
               x[0][1] * (x[1][2] * x[2][0] - x[1][0] * x[2][2]) +
               x[0][2] * (x[1][0] * x[2][1] - x[1][1] * x[2][0]));
    }
  return -flux; /* the corners run counterclockwise seen from inside */
}

static double mesh_volume(const tsolid_hex_view *v) {
  double volume = 0.0;
  for (int k = 0; k < v->region_start[v->n_regions]; k++)
    volume += face_flux(v, v->region_face[2 * k], v->region_face[2 * k + 1]);
  return volume;
}

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

static double volume_of(tsolid_context *context, const tsolid_solid *solid, int order, int n) {
  tsolid_hex_options options = {.order = order, .divisions = {n, n, n, n / 2}};
  tsolid_hex_view view;
  tsolid_hex *hex = NULL;
  double volume = NAN;
  if (CHECK(tsolid_hex_create(context, solid, &options, &hex) == TSOLID_OK)) {
    tsolid_hex_get(hex, &view);
    CHECK(view.order == order && view.proved && view.worst > 0.0);
    check_topology(&view);
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
