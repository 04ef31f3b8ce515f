/* SPDX-License-Identifier: LGPL-2.1-or-later
 * BEXT 2.0: what is written reads back bit for bit, rational or not; equal vectors are stored once;
 * a foreign file reads and its circle is round; malformed files are refused with their line. */
#include "check.h"

#include "cube_part.h"
#include "evaluate.h"
#include "parts.h"

static const cube_axis MIXED[3] = {{3, 2, 1}, {2, 2, 1}, {1, 3, 1}};

enum { MAX_FUNCTIONS = 4096 };

static tsolid_context *new_context(void) {
  tsolid_context *context = NULL;
  CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK);
  return context;
}

/* ---- there and back ----------------------------------------------------------------------------
 */

/* Element e of the space among those of the file: elements are grouped, their order kept. The key
 * is the first function's coefficients: compare all candidates. */
static int same_element(tsolid_context *context, const tsolid_space *space, int e,
                        const tsolid_bext_view *v, int file_element) {
  static int function[MAX_FUNCTIONS];
  static double coefficient[MAX_FUNCTIONS * 64];
  const int *degree = v->degree + 3 * file_element;
  int n = 0, width = (degree[0] + 1) * (degree[1] + 1) * (degree[2] + 1);
  int first = v->function_start[file_element];
  if (memcmp(degree, space->element[e].degree, 3 * sizeof *degree) != 0 ||
      tsolid_space_extraction(context, space, e, MAX_FUNCTIONS, &n, function, coefficient))
    return 0;
  int n_different = 0;
  for (int k = 0; k < n; k++) {
    double sum[64 * 4] = {0.0};
    int again = 0, at = first;
    for (int m = 0; m < n; m++) {
      again += function[m] == function[k] && m < k;
      for (int i = 0; function[m] == function[k] && i < width; i++)
        sum[i] += coefficient[m * width + i];
    }
    n_different += !again;
    while (at < v->function_start[file_element + 1] && v->function[at] != function[k])
      at++;
    if (at == v->function_start[file_element + 1] ||
        memcmp(sum, v->coefficient + v->vector_start[v->vector[at]], (size_t)width * sizeof *sum) !=
            0)
      return 0;
  }
  return n_different == v->function_start[file_element + 1] - first;
}

static void check_round_trip(tsolid_context *context, const tsolid_solid *solid, int rational) {
  const tsolid_space *space = tsolid_solid_space(solid);
  int n = space->n_inner + 2 * space->n_surface, n_found = 0;
  tsolid_bext *bext = NULL;
  tsolid_bext_view v;
  CHECK(tsolid_write_bext(context, solid, "test.bxt") == TSOLID_OK);
  if (!CHECK(tsolid_read_bext(context, "test.bxt", &bext) == TSOLID_OK))
    return;
  tsolid_bext_get(bext, &v);
  CHECK(v.n_nodes == n && v.n_elements == space->n_elements && v.rational == rational);
  CHECK(memcmp(v.control, tsolid_solid_control(solid), 4 * (size_t)n * sizeof(double)) == 0);
  unsigned char *taken = calloc((size_t)v.n_elements, 1);
  for (int e = 0; e < v.n_elements; e++)
    for (int f = 0; f < v.n_elements; f++)
      if (!taken[f] && same_element(context, space, e, &v, f)) {
        taken[f] = 1;
        n_found++;
        break;
      }
  CHECK(n_found == v.n_elements);
  for (int e = 0; e < v.n_elements; e++) /* libMesh wants ascending nodes */
    for (int k = v.function_start[e] + 1; k < v.function_start[e + 1]; k++)
      n_found -= v.function[k] <= v.function[k - 1];
  CHECK(n_found == v.n_elements);
  CHECK(v.n_vectors < v.function_start[v.n_elements]);
  printf("%d elements, %d entries, %d different vectors\n", v.n_elements,
         v.function_start[v.n_elements], v.n_vectors);
  free(taken);
  tsolid_bext_free(bext);
}

static void test_round_trip(tsolid_context *context) {
  static const cube_map map[] = {cube_wave, cube_rational};
  for (int k = 0; k < 2; k++) {
    cube_solid s;
    tsolid_solid *solid = NULL;
    if (CHECK(cube_solid_create(context, MIXED, map[k], 0, 0.0, &s)) &&
        CHECK(tsolid_solid_create(context, s.space, &solid) == TSOLID_OK))
      check_round_trip(context, solid, k);
    tsolid_solid_free(solid);
    cube_solid_free(&s);
  }
}

/* ---- a cylinder's radius -----------------------------------------------------------------------
 */

/* Largest |radius - 1| on faces of the file's elements whose corners lie on the radius. */
static double worst_radius(const tsolid_bext_view *v) {
  double worst = 0.0;
  for (int e = 0; e < v->n_elements; e++) {
    const int *degree = v->degree + 3 * e;
    int n[3] = {degree[0] + 1, degree[1] + 1, degree[2] + 1};
    double *net = calloc((size_t)(n[0] * n[1] * n[2]), 4 * sizeof *net);
    for (int k = v->function_start[e]; k < v->function_start[e + 1]; k++)
      for (int i = 0; i < n[0] * n[1] * n[2]; i++)
        for (int c = 0; c < 4; c++)
          net[4 * i + c] += v->coefficient[v->vector_start[v->vector[k]] + i] *
                            v->control[4 * v->function[k] + c];
    for (int axis = 0; axis < 3; axis++)
      for (int end = 0; end < 2; end++) {
        double h[4], r[9], x[3];
        int on = 1;
        for (int k = 0; k < 9; k++) {
          x[axis] = end;
          x[(axis + 1) % 3] = 0.5 * (k % 3);
          x[(axis + 2) % 3] = 0.5 * (k / 3);
          tsi_bezier_evaluate(degree, net, 4, x, 0, h);
          r[k] = hypot(h[0] / h[3], h[1] / h[3]);
          on = on && fabs(r[k] - 1.0) < 1e-6;
        }
        for (int k = 0; on && k < 9; k++)
          worst = fmax(worst, fabs(r[k] - 1.0));
      }
    free(net);
  }
  return worst;
}

static void test_cylinder(tsolid_context *context) {
  part_net net;
  tsolid_bext *bext = NULL;
  tsolid_bext_view v;
  part_cylinder(&net);
  tsolid_solid *solid = part_solid(context, &net);
  if (CHECK(solid != NULL) && CHECK(tsolid_write_bext(context, solid, "test.bxt") == TSOLID_OK) &&
      CHECK(tsolid_read_bext(context, "test.bxt", &bext) == TSOLID_OK)) {
    tsolid_bext_get(bext, &v);
    double worst = worst_radius(&v);
    printf("radius of a written rational cylinder: off by %.3g\n", worst);
    CHECK(worst > 0.0 && worst < 1e-13);
  }
  tsolid_bext_free(bext);
  tsolid_solid_free(solid);
}

/* ---- malformed files ---------------------------------------------------------------------------
 */

static const char good[] =
    "B E X T 2.0\n$ a comment\n1 8 1 8 0\n"
    "0 0 0 1\n1 0 0 1\n0 1 0 1\n1 1 0 1\n0 0 1 1\n1 0 1 1\n0 1 1 1\n1 1 1 1\n"
    "1\n1 1 8 8 1 1 1\n1 2 3 4 5 6 7 8\n1 2 3 4 5 6 7 8\n1 0\n8 8\n"
    "1 0 0 0 0 0 0 0\n0 1 0 0 0 0 0 0\n0 0 1 0 0 0 0 0\n0 0 0 1 0 0 0 0\n"
    "0 0 0 0 1 0 0 0\n0 0 0 0 0 1 0 0\n0 0 0 0 0 0 1 0\n0 0 0 0 0 0 0 1\n";

static tsolid_status read_text(tsolid_context *context, const char *text, size_t n) {
  tsolid_bext *bext = NULL;
  FILE *file = fopen("test.bxt", "wb");
  fwrite(text, 1, n, file);
  fclose(file);
  tsolid_status status = tsolid_read_bext(context, "test.bxt", &bext);
  CHECK((bext != NULL) == (status == TSOLID_OK));
  tsolid_bext_free(bext);
  return status;
}

static void test_malformed(tsolid_context *context) {
  static const char *const change[][2] = {{"2.0", "1.0"},
                                          {"B E X T", "{\"a\""},
                                          {"1 8 1 8 0", "1 0 1 8 0"},
                                          {"1 8 1 8 0", "1 9 1 8 0"},
                                          {"1 8 1 8 0", "1 200000000 1 8 0"},
                                          {"1 8 1 8 0", "1 8 2 8 0"},
                                          {"1 8 1 8 0", "1 8 1 9 0"},
                                          {"0 0 0 1\n", "0 0 0 -1\n"},
                                          {"0 0 0 1\n", "0 0 nan 1\n"},
                                          {"0 0 0 1\n", "0 0 inf 1\n"},
                                          {"0 0 0 1\n", "0 0 x 1\n"},
                                          {"1 1 8 8 1 1 1", "0 1 8 8 1 1 1"},
                                          {"1 1 8 8 1 1 1", "1 1 8 7 1 1 1"},
                                          {"1 1 8 8 1 1 1", "1 1 8 8 1 1 99"},
                                          {"1 1 8 8 1 1 1", "1 1 8 8 2 1 1"},
                                          {"7 8\n1 2", "7 9\n1 2"},
                                          {"7 8\n1 0\n", "7 0\n1 0\n"},
                                          {"1 0\n8 8\n", "1 1\n8 8\n"},
                                          {"8 8\n1 0", "8 7\n1 0"},
                                          {"8 8\n1 0", "7 8\n1 0"},
                                          {"8 8\n1 0", "8 200000000\n1 0"}};
  CHECK(read_text(context, good, sizeof good - 1) == TSOLID_OK);
  for (size_t n = 0; n + 2 < sizeof good - 1; n++) /* the last digit may be half of a number */
    CHECK(read_text(context, good, n) == TSOLID_ERROR_INPUT);
  for (size_t k = 0; k < sizeof change / sizeof *change; k++) {
    char text[2 * sizeof good];
    const char *at = strstr(good, change[k][0]);
    if (!CHECK(at != NULL))
      continue;
    int n = snprintf(text, sizeof text, "%.*s%s%s", (int)(at - good), good, change[k][1],
                     at + strlen(change[k][0]));
    if (!CHECK(read_text(context, text, (size_t)n) == TSOLID_ERROR_INPUT))
      fprintf(stderr, "    %s for %s\n", change[k][1], change[k][0]);
  }
  const tsolid_finding *finding = tsolid_context_finding(context, 0);
  CHECK(tsolid_context_n_findings(context) > 100 && finding->entity == TSOLID_ENTITY_LINE);
  tsolid_context_clear(context);
}

/* A file of libMesh's, where it is at hand. */
static void test_foreign(tsolid_context *context) {
  const char *source = getenv("TSOLID_SOURCE_DIR");
  char path[4096];
  tsolid_bext *bext = NULL;
  tsolid_bext_view v;
  snprintf(path, sizeof path, "%s/../shared/data/PressurizedCyl3d_Patch1_8Elem.bxt",
           source ? source : ".");
  FILE *file = fopen(path, "rb");
  if (!file) {
    printf("skipped: no %s\n", path);
    return;
  }
  fclose(file);
  if (!CHECK(tsolid_read_bext(context, path, &bext) == TSOLID_OK))
    return;
  tsolid_bext_get(bext, &v);
  CHECK(v.n_nodes == 64 && v.n_elements == 8 && v.n_vectors == 160 && v.rational);
  double worst = worst_radius(&v);
  printf("radius of libMesh's cylinder: off by %.3g\n", worst);
  CHECK(worst > 0.0 && worst < 1e-13);
  tsolid_bext_free(bext);
}

int main(void) {
  tsolid_context *context = new_context();
  test_round_trip(context);
  test_cylinder(context);
  test_malformed(context);
  test_foreign(context);
  CHECK(tsolid_read_bext(context, "no such file", &(tsolid_bext *){NULL}) == TSOLID_ERROR_IO);

  remove("test.bxt");
  tsolid_context_free(context);
  return check_done();
}
