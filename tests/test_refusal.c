/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Parts that must be refused, each with its reason, its place and the user's own names. */
#include "check.h"
#include "internal.h"
#include "boundary_parts.h"

static tsolid_context *context;
static tsolid_requirement requirement;

/* ---- parts -------------------------------------------------------------------------------------
 */

static const double line_knots[4] = {0, 0, 1, 1};

static void add_patch(part *p, const double corner[4][3]) { /* 00, 10, 01, 11 */
  double *points = part_doubles(12), *u = part_doubles(4), *v = part_doubles(4);
  memcpy(points, corner, 12 * sizeof(double));
  memcpy(u, line_knots, sizeof line_knots);
  memcpy(v, line_knots, sizeof line_knots);
  p->patch = realloc(p->patch, (size_t)(p->n + 1) * sizeof *p->patch);
  p->patch[p->n++] =
      (tsolid_patch){.degree = {1, 1}, .n_control = {2, 2}, .knots = {u, v}, .points = points};
}

/* The boundary of a heap of unit cubes, one bilinear patch per square. */
static part make_cubes(int n, const int cell[][3]) {
  part p = {0, NULL};
  for (int k = 0; k < n; k++)
    for (int side = 0; side < 6; side++) {
      int a = side >> 1, s = (a + 1) % 3, t = (a + 2) % 3, covered = 0, next[3];
      memcpy(next, cell[k], sizeof next);
      next[a] += side & 1 ? 1 : -1;
      for (int j = 0; j < n; j++)
        covered |= memcmp(next, cell[j], sizeof next) == 0;
      if (covered)
        continue;
      double corner[4][3];
      for (int i = 0; i < 4; i++) {
        corner[i][a] = cell[k][a] + (side & 1);
        corner[i][s] = cell[k][s] + (i & 1);
        corner[i][t] = cell[k][t] + (i >> 1);
      }
      add_patch(&p, (const double(*)[3])corner);
    }
  return p;
}

static part make_box(void) {
  static const int cell[1][3] = {{0, 0, 0}};
  static const char *const face[6] = {"Face1", "Face2", "Face3", "Face4", "Face5", "Face6"};
  part p = make_cubes(1, cell);
  for (int k = 0; k < 6; k++)
    p.patch[k].name = face[k];
  return p;
}

static double *points_of(part *p, int k) {
  return (double *)(size_t)p->patch[k].points;
}

static void remove_patch(part *p, int k) {
  part gone = {1, malloc(sizeof *gone.patch)};
  gone.patch[0] = p->patch[k];
  p->patch[k] = p->patch[--p->n];
  part_free(&gone);
}

/* A tensor grid of n x m bilinear patches on a closed surface given by two angles. */
static part make_angles(int n, int m, void (*map)(double, double, double *)) {
  part p = {0, NULL};
  const double turn = 2.0 * 3.14159265358979323846;
  for (int j = 0; j < m; j++)
    for (int i = 0; i < n; i++) {
      double corner[4][3];
      for (int k = 0; k < 4; k++)
        map(turn * (i + (k & 1)) / n, turn * (j + (k >> 1)) / m, corner[k]);
      add_patch(&p, (const double(*)[3])corner);
    }
  return p;
}

static void map_torus(double u, double v, double x[3]) {
  x[0] = (3.0 + cos(v)) * cos(u);
  x[1] = (3.0 + cos(v)) * sin(u);
  x[2] = sin(v);
}

static void map_klein(double u, double v, double x[3]) {
  double w = v + 3.14159265358979323846 / 8.0,
         r = 3.0 + cos(u / 2.0) * sin(w) - sin(u / 2.0) * sin(2.0 * w);
  x[0] = r * cos(u);
  x[1] = r * sin(u);
  x[2] = sin(u / 2.0) * sin(w) + cos(u / 2.0) * sin(2.0 * w);
}

/* A closed wall as one periodic face, which has a seam. */
static part make_tube(void) {
  static const double ring[6][2] = {{1, 0}, {1, 2}, {-2, 2}, {-2, -2}, {1, -2}, {1, 0}};
  static const double knots[9] = {0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1};
  part p = {0, NULL};
  double *points = part_doubles(36), *u = part_doubles(9), *v = part_doubles(4);
  memcpy(u, knots, sizeof knots);
  memcpy(v, line_knots, sizeof line_knots);
  for (int i = 0; i < 12; i++) {
    points[3 * i] = ring[i % 6][0];
    points[3 * i + 1] = ring[i % 6][1];
    points[3 * i + 2] = i / 6;
  }
  p.patch = malloc(sizeof *p.patch);
  p.patch[p.n++] =
      (tsolid_patch){.degree = {2, 1}, .n_control = {6, 2}, .knots = {u, v}, .points = points};
  return p;
}

/* ---- expectations ------------------------------------------------------------------------------
 */

static int finding_holds(const char *text) {
  for (int i = 0; i < tsolid_context_n_findings(context); i++)
    if (strstr(tsolid_context_finding(context, i)->text, text))
      return 1;
  return 0;
}

static tsolid_status try_part(const part *p) {
  tsolid_boundary *boundary = NULL;
  tsolid_boundary_input input = {.n_patches = p->n, .patches = p->patch};
  tsolid_context_clear(context);
  tsolid_status status = tsolid_boundary_create(context, &input, NULL, &requirement, &boundary);
  CHECK((status == TSOLID_OK) == (boundary != NULL));
  CHECK((status == TSOLID_OK) == (tsolid_context_n_findings(context) == 0));
  tsolid_boundary_free(boundary);
  return status;
}

static void expect(part *p, tsolid_status status, const char *text) {
  tsolid_status found = try_part(p);
  if (!CHECK(found == status) || !CHECK(finding_holds(text))) {
    fprintf(stderr, "    status %d; '%s' is not in:\n", (int)found, text);
    for (int i = 0; i < tsolid_context_n_findings(context); i++)
      fprintf(stderr, "      %s\n", tsolid_context_finding(context, i)->text);
  }
  if (found == TSOLID_ERROR_REFUSED)
    CHECK(requirement.n_violations > 0 && !requirement.satisfied);
}

static void expect_refused(part p, const char *text) {
  expect(&p, TSOLID_ERROR_REFUSED, text);
  part_free(&p);
}

/* ---- shells that are no cube --------------------------------------------------------------------
 */

static void test_open(void) {
  part p = make_box();
  remove_patch(&p, 2);
  expect(&p, TSOLID_ERROR_REFUSED, "is free");
  CHECK(finding_holds("not closed: 4 of their 20 borders"));
  CHECK(finding_holds("of Face1") && finding_holds("of Face6") && !finding_holds("of Face4"));
  CHECK(!requirement.closed && requirement.n_patches == 5 && requirement.genus == -1);
  CHECK(requirement.n_vertices == 8 && requirement.n_edges == 12 && requirement.n_violations == 4);
  part_free(&p);
  p = make_box(); /* seven faces: one flies beside the box */
  double corner[4][3] = {{5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {6, 1, 0}};
  add_patch(&p, (const double(*)[3])corner);
  expect(&p, TSOLID_ERROR_REFUSED, "of patch 6 is free");
  part_free(&p);
}

static void test_cubes(void) {
  static const int two[2][3] = {{0, 0, 0}, {0, 0, 1}};
  part p = make_cubes(2, two); /* a regular grid on four sides: taken */
  CHECK(try_part(&p) == TSOLID_OK);
  CHECK(requirement.satisfied && requirement.n_patches == 10 && requirement.n_vertices == 12);
  double wall[4][3] = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
  add_patch(&p, (const double(*)[3])wall);
  expect_refused(p, "is shared by 3 faces");
  static const int ell[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  p = make_cubes(3, ell);
  expect(&p, TSOLID_ERROR_REFUSED, "12 extraordinary vertices, 10 of them with three faces");
  CHECK(finding_holds("at (1, 1, 0) belongs to 5 faces"));
  CHECK(requirement.closed && requirement.connected && requirement.genus == 0);
  part_free(&p);
  static const int ring[8][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0},
                                 {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}};
  p = make_cubes(8, ring);
  expect(&p, TSOLID_ERROR_REFUSED, "genus 1");
  CHECK(requirement.genus == 1);
  part_free(&p);
  static const int apart[2][3] = {{0, 0, 0}, {4, 0, 0}};
  expect_refused(make_cubes(2, apart), "2 separate shells");
  CHECK(requirement.closed && !requirement.connected);
  static const int at_edge[2][3] = {{0, 0, 0}, {1, 1, 0}};
  expect_refused(make_cubes(2, at_edge), "is shared by 4 faces");
  static const int at_vertex[8][3] = {{0, 0, 0},  {-1, 0, 0}, {-1, 0, 1}, {-1, 0, 2},
                                      {-1, 1, 2}, {0, 1, 2},  {1, 1, 2},  {1, 1, 1}};
  expect_refused(make_cubes(8, at_vertex), "touches itself at (1, 1, 1)");
}

/* A heap of cubes is a cube in our sense exactly when it is a box: every reflex edge makes a vertex
 * of more than four faces. All heaps within 2 x 2 x 2, and random ones within 3 x 3 x 2. */
static int is_box(int n, const int cell[][3]) {
  int low[3] = {9, 9, 9}, high[3] = {-9, -9, -9};
  for (int k = 0; k < n; k++)
    for (int c = 0; c < 3; c++) {
      low[c] = cell[k][c] < low[c] ? cell[k][c] : low[c];
      high[c] = cell[k][c] > high[c] ? cell[k][c] : high[c];
    }
  return n == (high[0] - low[0] + 1) * (high[1] - low[1] + 1) * (high[2] - low[2] + 1);
}

static void check_heap(const int size[3], long mask) {
  int cell[18][3], n = 0;
  for (int i = 0; i < size[0] * size[1] * size[2]; i++)
    if (mask >> i & 1) {
      cell[n][0] = i % size[0];
      cell[n][1] = i / size[0] % size[1];
      cell[n++][2] = i / size[0] / size[1];
    }
  part p = make_cubes(n, (const int(*)[3])cell);
  tsolid_status status = try_part(&p);
  CHECK(status == (is_box(n, (const int(*)[3])cell) ? TSOLID_OK : TSOLID_ERROR_REFUSED));
  CHECK(requirement.satisfied == (status == TSOLID_OK));
  part_free(&p);
}

static void test_heaps(void) {
  static const int two[3] = {2, 2, 2}, three[3] = {3, 3, 2};
  for (long mask = 1; mask < 256; mask++)
    check_heap(two, mask);
  for (int i = 0; i < 300; i++)
    check_heap(three, 1 + random_below((1 << 18) - 1));
}

/* Eight vertices of three faces and all others of four, but the isolines cross in the middle of the
 * cube's faces: only the graph tells it from a cube. */
static void test_rhombic_dodecahedron(void) {
  part p = {0, NULL};
  for (int axis = 0; axis < 3; axis++)
    for (int k = 0; k < 4; k++) {
      int a = (axis + 1) % 3, b = (axis + 2) % 3;
      double corner[4][3] = {{0.0}};
      double sa = k & 1 ? 1.0 : -1.0, sb = k >> 1 ? 1.0 : -1.0;
      corner[0][a] = 2.0 * sa;
      corner[3][b] = 2.0 * sb;
      for (int i = 1; i < 3; i++) {
        corner[i][a] = sa;
        corner[i][b] = sb;
        corner[i][axis] = i == 1 ? -1.0 : 1.0;
      }
      add_patch(&p, (const double(*)[3])corner);
    }
  expect(&p, TSOLID_ERROR_REFUSED, "like the edges of a cube");
  CHECK(requirement.n_extraordinary == 8 && requirement.genus == 0);
  part_free(&p);
}

static void test_closed_surfaces(void) {
  expect_refused(make_angles(5, 4, map_torus), "genus 1");
  expect_refused(make_angles(5, 8, map_klein), "only one side");
  expect_refused(make_tube(), "periodic face has to be cut");
  expect_refused(make_angles(1, 1, map_torus), "is a pole"); /* all corners are one point */
  part p = {0, NULL};
  double corner[4][3] = {{0, 0, 0}, {1, 0, 0.5}, {0, 1, 0.5}, {1, 1, 0}};
  add_patch(&p, (const double(*)[3])corner);
  add_patch(&p, (const double(*)[3])corner);
  expect_refused(p, "patch 1 is a duplicate of patch 0");
}

/* ---- faces that are none ------------------------------------------------------------------------
 */

static void test_faces(void) {
  static const char *const edges[4] = {"Edge1", "Edge2", "Edge3", "Edge4"};
  part p = make_box();
  double *x = points_of(&p, 4); /* z low: close one of its borders */
  memcpy(x + 3, x, 3 * sizeof *x);
  p.patch[4].border_name[0] = edges[2];
  expect_refused(p, "Edge3 of Face5 is a pole");
  p = make_box();
  x = points_of(&p, 1);
  for (int i = 0; i < 4; i++) { /* its corners on one line */
    static const double at[4] = {0.0, 1.0, 2.0, 3.5};
    x[3 * i] = x[3 * i + 1] = x[3 * i + 2] = at[i];
  }
  expect_refused(p, "Face2 has no area");
  p = make_box();
  part twin = copy_part(&p);
  add_patch(&p, (const double(*)[3])(const void *)twin.patch[3].points);
  p.patch[6].name = "Face7";
  part_free(&twin);
  expect_refused(p, "Face7 is a duplicate of Face4");
}

/* ---- borders that do not fit
 * --------------------------------------------------------------------- */

static const axis_spec cubic[3] = {
    {1, {{3, 1, {0.5}}}}, {1, {{3, 1, {0.5}}}}, {1, {{3, 1, {0.5}}}}};

static void map_unit(const double u[3], double point[3], double *weight) {
  memcpy(point, u, 3 * sizeof *point);
  *weight = 1.0 + u[0] * u[1] + 0.5 * u[2];
}

/* The lowest row in v of patch k moves at its control point i. */
static void move_border_point(part *p, int k, int i, int axis, double by) {
  points_of(p, k)[3 * i + axis] += by;
}

static void test_gaps(void) {
  part p = make_box();
  double *x = points_of(&p, 5); /* z high, lifted as a whole */
  for (int i = 0; i < 4; i++)
    x[3 * i + 2] += 1e-3;
  expect(&p, TSOLID_ERROR_REFUSED, "differ by 0.001, more than the tolerance of 1e-07");
  CHECK(finding_holds("Face6") && finding_holds("not closed"));
  int n_measured = 0;
  for (int i = 0; i < tsolid_context_n_findings(context); i++) {
    const tsolid_finding *f = tsolid_context_finding(context, i);
    if (fabs(f->measured - 1e-3) < 1e-12 && f->allowed == 1e-7 && f->has_point)
      n_measured++;
  }
  CHECK(n_measured == 8);
  part_free(&p);
  p = make_part(cubic, map_unit, 0); /* ends fit, the middle does not */
  p.patch[4].name = "Face5";
  p.patch[4].border_name[0] = "Edge9";
  move_border_point(&p, 4, 2, 2, 1e-4);
  /* the middle function of five is 1/2 where it is largest */
  expect(&p, TSOLID_ERROR_REFUSED, "differ by 5e-05, more than the tolerance of 1e-07");
  CHECK(finding_holds("Edge9 of Face5") && finding_holds("near (0.5, 0, 5e-05): they run apart"));
  p.patch[4].border_tolerance[0] = 2e-4; /* the B-rep allows it */
  CHECK(try_part(&p) == TSOLID_OK);
  p.patch[4].border_tolerance[0] = 0.0;
  p.patch[4].border_tolerance[1] = 2e-4; /* another edge's tolerance does not */
  CHECK(try_part(&p) == TSOLID_ERROR_REFUSED);
  part_free(&p);
  p = make_part(cubic, map_unit, 0); /* the same line at another speed: 0.005 at the middle */
  p.patch[4].name = "Face5";
  move_border_point(&p, 4, 2, 0, 0.01);
  expect(&p, TSOLID_ERROR_REFUSED,
         "border 0 of Face5 and border 0 of patch 2 run along one curve with different parameters: "
         "up to 0.005 apart at equal ones");
  CHECK(fabs(tsolid_context_finding(context, 0)->measured - 0.005) < 1e-12);
  part_free(&p);
  p = make_part(cubic, map_unit, 1); /* likewise, by one weight of a straight border */
  ((double *)(size_t)p.patch[4].weights)[2] *= 1.001;
  expect_refused(p, "run along one curve with different parameters");
}

static void test_t_vertex(void) { /* off the edges that it should lie on */
  part p = make_box();
  remove_patch(&p, 5);
  double left[4][3] = {{0, 0, 1}, {0.5, -0.001, 1}, {0, 1, 1}, {0.5, 1.001, 1}};
  double right[4][3] = {{0.5, -0.001, 1}, {1, 0, 1}, {0.5, 1.001, 1}, {1, 1, 1}};
  add_patch(&p, (const double(*)[3])left);
  add_patch(&p, (const double(*)[3])right);
  expect(&p, TSOLID_ERROR_REFUSED, "is met by two neighbours near (0.5, -0.001, 1)");
  CHECK(finding_holds("farther from it than the tolerance of 1e-07"));
  part_free(&p);
}

/* ---- malformed
 * ----------------------------------------------------------------------------------- */

static void test_malformed(void) {
  part p = make_part(cubic, map_unit, 1);
  p.patch[2].name = "Face3\nwith a break";
  double *weight = (double *)(size_t)p.patch[2].weights, *x = points_of(&p, 2), kept = *weight;
  static const double wrong[4] = {-1.0, 0.0, (double)NAN, (double)INFINITY};
  for (int i = 0; i < 4; i++) {
    *weight = wrong[i];
    expect(&p, TSOLID_ERROR_INPUT, "Face3 with a break: the weight of control point (0, 0)");
    *weight = kept;
  }
  for (int i = 2; i < 4; i++) {
    x[4] = wrong[i];
    expect(&p, TSOLID_ERROR_INPUT, "Face3 with a break: control point (1, 0) is not finite");
    x[4] = 0.0;
  }
  part_free(&p);
}

static void test_arguments(void) {
  part p = make_box();
  tsolid_bezier_boundary bezier;
  memset(&bezier, 0, sizeof bezier);
  tsolid_boundary *boundary = NULL;
  tsolid_boundary_input good = {.n_patches = p.n, .patches = p.patch}, input = good;
  const tsolid_boundary_options options[6] = {{.tolerance = -1.0},  {.tolerance = (double)NAN},
                                              {.refine_knots = -1}, {.refine_knots = 7},
                                              {.raise_degree = -1}, {.raise_degree = 25}};
  for (int i = 0; i < 6; i++)
    CHECK(tsolid_boundary_create(context, &input, &options[i], NULL, &boundary) ==
              TSOLID_ERROR_ARGUMENT &&
          !boundary);
  input.bezier = &bezier;
  CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_ERROR_ARGUMENT);
  input.patches = NULL;
  CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_ERROR_INPUT);
  input = good;
  input.n_patches = 0;
  CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_boundary_create(context, NULL, NULL, NULL, &boundary) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_boundary_create(NULL, &good, NULL, NULL, &boundary) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_boundary_create(context, &good, NULL, NULL, NULL) == TSOLID_ERROR_ARGUMENT);
  tsolid_boundary_options most = {.raise_degree = 24};
  CHECK(tsolid_boundary_create(context, &good, &most, NULL, &boundary) == TSOLID_OK);
  CHECK(boundary && tsi_boundary_validate(context, boundary) == TSOLID_OK);
  tsolid_boundary_free(boundary);
  part_free(&p);
}

int main(void) {
  if (tsolid_context_create(NULL, &context))
    return 1;
  test_open();
  test_cubes();
  test_heaps();
  test_rhombic_dodecahedron();
  test_closed_surfaces();
  test_faces();
  test_gaps();
  test_t_vertex();
  test_malformed();
  test_arguments();
  tsolid_context_free(context);
  return check_done();
}
