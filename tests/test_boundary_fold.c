/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Sides that fold over themselves are refused at the right place, and no others: random bicubic
 * sides against a slow twin that looks for the zeros of the product of tangents by pattern search
 * from every minimum of a fine grid. */
#include "boundary_parts.h"
#include "check.h"

enum { GRID = 120, MAX_ZEROS = 64, N_RANDOM = 120 };

static void identity(const double u[3], double point[3], double *weight) {
  memcpy(point, u, 3 * sizeof *point);
  *weight = 1.0;
}

/* A half round bar of 170 degrees in one element, and a strong twist. */
static void bent(const double u[3], double point[3], double *weight) {
  double a = 2.9 * u[0], r = 0.4 + u[1], twist = 0.3 * u[2];
  point[0] = r * cos(a) - twist * u[1];
  point[1] = r * sin(a) + twist * u[0];
  point[2] = 2.0 * u[2];
  *weight = 1.0;
}

static part cube_of(part_map map, int degree) {
  const axis_spec axis[3] = {
      {1, {{degree, 0, {0}}}}, {1, {{degree, 0, {0}}}}, {1, {{degree, 0, {0}}}}};
  return make_part(axis, map, 0);
}

/* ---- the twin ----------------------------------------------------------------------------------
 */

/* Point, and the sine of the angle of the tangents, of a bicubic Bezier patch. */
static double sine_at(const tsolid_patch *patch, double s, double t, double point[3]) {
  double b[2][4], d[2][4], x[3][3] = {{0.0}}, n[3], length[2] = {0.0, 0.0};
  const double u[2] = {s, t};
  for (int k = 0; k < 2; k++) {
    double v = u[k], w = 1.0 - v;
    const double value[4] = {w * w * w, 3.0 * v * w * w, 3.0 * v * v * w, v * v * v};
    const double slope[4] = {-3.0 * w * w, 3.0 * w * (w - 2.0 * v), 3.0 * v * (2.0 * w - v),
                             3.0 * v * v};
    memcpy(b[k], value, sizeof value);
    memcpy(d[k], slope, sizeof slope);
  }
  for (int k = 0; k < 16; k++)
    for (int c = 0; c < 3; c++) {
      double p = patch->points[3 * k + c];
      x[0][c] += b[0][k % 4] * b[1][k / 4] * p;
      x[1][c] += d[0][k % 4] * b[1][k / 4] * p;
      x[2][c] += b[0][k % 4] * d[1][k / 4] * p;
    }
  for (int c = 0; c < 3; c++) {
    int e = (c + 1) % 3, f = (c + 2) % 3;
    n[c] = x[1][e] * x[2][f] - x[1][f] * x[2][e];
    length[0] += x[1][c] * x[1][c];
    length[1] += x[2][c] * x[2][c];
  }
  memcpy(point, x[0], sizeof x[0]);
  return sqrt((n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / (length[0] * length[1]));
}

static double descend(const tsolid_patch *patch, double s, double t, double point[3]) {
  double best = sine_at(patch, s, t, point), trial[3];
  for (double step = 1.0 / GRID; step > 1e-12;) {
    double from = best, a = s, b = t;
    for (int k = 0; k < 9; k++) {
      double x = fmin(fmax(a + step * (k % 3 - 1), 0.0), 1.0);
      double y = fmin(fmax(b + step * (k / 3 - 1), 0.0), 1.0), value = sine_at(patch, x, y, trial);
      if (value < best) {
        best = value;
        s = x;
        t = y;
        memcpy(point, trial, sizeof trial);
      }
    }
    step = best < from ? step : 0.5 * step;
  }
  return best;
}

static double grid_sine[GRID + 1][GRID + 1];

/* No neighbour is lower. */
static int is_lowest(int i, int j) {
  for (int y = j > 0 ? j - 1 : 0; y <= j + 1 && y <= GRID; y++)
    for (int x = i > 0 ? i - 1 : 0; x <= i + 1 && x <= GRID; x++)
      if (grid_sine[y][x] < grid_sine[j][i])
        return 0;
  return 1;
}

/* Points where the tangents are parallel; *least: the smallest sine that is no zero. */
static int find_zeros(const tsolid_patch *patch, double zero[MAX_ZEROS][3], double *least) {
  double point[3];
  int n = 0;
  *least = 1.0;
  for (int j = 0; j <= GRID; j++)
    for (int i = 0; i <= GRID; i++)
      grid_sine[j][i] = sine_at(patch, (double)i / GRID, (double)j / GRID, point);
  for (int j = 0; j <= GRID; j++)
    for (int i = 0; i <= GRID; i++) {
      if (!is_lowest(i, j))
        continue;
      double sine = descend(patch, (double)i / GRID, (double)j / GRID, point);
      if (sine < 1e-8 && n < MAX_ZEROS)
        memcpy(zero[n++], point, sizeof point);
      else if (sine < *least)
        *least = sine;
    }
  return n;
}

/* ---- tests
 * -------------------------------------------------------------------------------------- */

/* The status of the part's boundary; *found: the refusal, when there is one. */
static tsolid_status check_part(const part *p, tsolid_finding *found) {
  tsolid_context *context = NULL;
  tsolid_boundary *boundary = NULL;
  tsolid_requirement requirement;
  tsolid_boundary_input input = {.n_patches = p->n, .patches = p->patch};
  tsolid_context_create(NULL, &context);
  tsolid_status status = tsolid_boundary_create(context, &input, NULL, &requirement, &boundary);
  for (int i = 0; i < tsolid_context_n_findings(context); i++)
    if (tsolid_context_finding(context, i)->severity == TSOLID_ERROR)
      *found = *tsolid_context_finding(context, i);
  found->text = NULL; /* the context's */
  CHECK(requirement.satisfied == (status == TSOLID_OK));
  CHECK((boundary != NULL) == (status == TSOLID_OK));
  tsolid_boundary_free(boundary);
  tsolid_context_free(context);
  return status;
}

static double *inner_point(part *p, int patch, int i, int j) {
  return (double *)(size_t)p->patch[patch].points + 3 * (i + 4 * j);
}

/* Inner control points anywhere: the verdict is the twin's, the place one of the twin's. */
static void test_random(void) {
  int n_folded = 0, n_whole = 0;
  for (int k = 0; k < N_RANDOM; k++) {
    part p = cube_of(identity, 3);
    double zero[MAX_ZEROS][3], least, size = 0.5 + 2.5 * random_unit(), nearest = INFINITY;
    int patch = k % 6;
    for (int i = 0; i < 4; i++)
      for (int c = 0; c < 3; c++)
        inner_point(&p, patch, 1 + i % 2, 1 + i / 2)[c] += size * (random_unit() - 0.5);
    int n = find_zeros(&p.patch[patch], zero, &least);
    tsolid_finding found = {.severity = TSOLID_NOTE};
    tsolid_status status = check_part(&p, &found);
    part_free(&p);
    if (n == 0 && least < 0.01)
      continue; /* the twin may have missed one */
    CHECK(status == (n ? TSOLID_ERROR_REFUSED : TSOLID_OK));
    n_folded += n > 0;
    n_whole += n == 0;
    for (int i = 0; i < n; i++) {
      double d = 0.0;
      for (int c = 0; c < 3; c++)
        d += (found.point[c] - zero[i][c]) * (found.point[c] - zero[i][c]);
      nearest = fmin(nearest, sqrt(d));
    }
    if (n && status) {
      CHECK(nearest < 1e-3);
      CHECK(found.entity == TSOLID_ENTITY_PATCH && found.index[0] == patch && found.has_point);
    }
  }
  CHECK(n_folded >= N_RANDOM / 8);
  CHECK(n_whole >= N_RANDOM / 8);
}

/* A plane side that turns back across whole curves. */
static void test_turned_back(void) {
  part p = cube_of(identity, 3);
  for (int j = 1; j < 3; j++) {
    inner_point(&p, 4, 1, j)[0] = 1.6;
    inner_point(&p, 4, 2, j)[0] = -0.6;
  }
  tsolid_finding found = {.severity = TSOLID_NOTE};
  CHECK(check_part(&p, &found) == TSOLID_ERROR_REFUSED);
  CHECK(found.index[0] == 4);
  part_free(&p);
}

/* Sides whose normals turn far inside one element are none of this. */
static void test_bent(void) {
  for (int degree = 2; degree <= 7; degree += 5) {
    part p = cube_of(bent, degree);
    tsolid_finding found = {.severity = TSOLID_NOTE};
    CHECK(check_part(&p, &found) == TSOLID_OK);
    part_free(&p);
  }
}

int main(void) {
  test_random();
  test_turned_back();
  test_bent();
  return check_done();
}
