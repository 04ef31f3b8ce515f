/* SPDX-License-Identifier: LGPL-2.1-or-later
 * T-mesh, rays and extraction: counts that theory gives, and slow twins on any set of boxes. */
#include <stdlib.h>

#include "bernstein.h"
#include "blending.h"
#include "check.h"
#include "cube_part.h"
#include "tmesh.h"

static const double HEIGHT[6] = {0.5, 0.3, 0.4, 0.4, 0.25, 0.6};

static double random_unit(void) {
  static uint64_t state = 20121;
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) * 0x1p-53;
}

/* ---- sets of boxes
 * ------------------------------------------------------------------------------------- */

typedef struct box_set {
  int n_lines[3], n, capacity, *box;
  double *line[3];
} box_set;

static void add_box(box_set *s, const int box[6]) {
  if (s->n == s->capacity) {
    s->capacity = s->capacity ? 2 * s->capacity : 64;
    s->box = realloc(s->box, (size_t)s->capacity * 6 * sizeof *s->box);
  }
  memcpy(s->box + 6 * s->n++, box, 6 * sizeof *box);
}

/* Splits the core at random places; every box is cut at one line of each axis it can be cut at with
 * probability `chance`, to `depth` levels: no balance, many T-junctions. */
static void split_box(box_set *s, const int box[6], int depth, double chance) {
  int widest = 0;
  for (int a = 1; a < 3; a++)
    if (box[a + 3] - box[a] > box[widest + 3] - box[widest])
      widest = a;
  if (depth == 0 || box[widest + 3] - box[widest] < 2 || random_unit() > chance) {
    add_box(s, box);
    return;
  }
  int cut = box[widest] + 1 + (int)(random_unit() * (box[widest + 3] - box[widest] - 1));
  int low[6], high[6];
  memcpy(low, box, sizeof low);
  memcpy(high, box, sizeof high);
  low[widest + 3] = high[widest] = cut;
  split_box(s, low, depth - 1, chance);
  split_box(s, high, depth - 1, chance);
}

static box_set make_boxes(int n, int refined) {
  box_set s = {.n = 0};
  for (int a = 0; a < 3; a++) {
    s.n_lines[a] = n + 1;
    s.line[a] = malloc((size_t)(n + 1) * sizeof(double));
    for (int i = 0; i <= n; i++)
      s.line[a][i] = i == n ? 1.0 : (i + 0.3 * sin(2.0 * i + a) * (i > 0)) / n;
  }
  if (refined) {
    split_box(&s, (int[6]){0, 0, 0, n, n, n}, 30, 0.93);
    return s;
  }
  for (int i = 0; i < n * n * n; i++) {
    int lo[3] = {i % n, i / n % n, i / (n * n)};
    add_box(&s, (int[6]){lo[0], lo[1], lo[2], lo[0] + 1, lo[1] + 1, lo[2] + 1});
  }
  return s;
}

static void free_boxes(box_set *s) {
  for (int a = 0; a < 3; a++)
    free(s->line[a]);
  free(s->box);
}

static tsolid_tmesh *mesh_of(tsolid_context *context, const box_set *s) {
  tsolid_tmesh *tmesh;
  CHECK(tsi_tmesh_from_boxes(context, s->n_lines, (const double *const *)s->line, s->n, s->box,
                             HEIGHT, 0, &tmesh) == TSOLID_OK);
  return tmesh;
}

static tsolid_space *space_of(tsolid_context *context, const tsolid_tmesh *tmesh, int degree,
                              int n_spans) {
  cube_axis axis[3] = {{degree, n_spans, 1}, {degree, n_spans, 1}, {degree, n_spans, 1}};
  cube_part part = cube_part_create(axis, NULL);
  tsolid_boundary *boundary = NULL;
  tsolid_space *space = NULL;
  tsolid_boundary_input input = {.bezier = &part.boundary};
  CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_OK);
  CHECK(tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK);
  tsolid_boundary_free(boundary);
  cube_part_free(&part);
  return space;
}

/* ---- counts
 * ---------------------------------------------------------------------------------------------- */

/* Known counts of functions for n cells per axis under n cubic spans per side. */
static void test_counts(tsolid_context *context) {
  static const int expected[] = {288, 517, 824, 1203};
  for (int n = 1; n <= 4; n++) {
    box_set boxes = make_boxes(n, 0);
    tsolid_tmesh *tmesh = mesh_of(context, &boxes);
    tsolid_space *space = space_of(context, tmesh, 3, n);
    tsolid_space_view view;
    tsolid_space_get(space, &view);
    CHECK(view.n_functions == expected[n - 1]);
    CHECK(tmesh->n_extraordinary == 8);
    CHECK(tmesh->n_partial_extraordinary == 12 * (n - 1) + 8);
    /* core, r1 and boundary surfaces: (n+1)^3 nodes, then two closed surfaces of 6 n^2 + 2 */
    CHECK(tmesh->n_nodes == (n + 1) * (n + 1) * (n + 1) + 2 * (6 * n * n + 2));
    tsolid_space_free(space);
    tsolid_tmesh_free(tmesh);
    free_boxes(&boxes);
  }
}

/* ---- rays, by brute force
 * -------------------------------------------------------------------------------------- */

static int face_holds(const int *cell, int axis, int plane, const int *node) {
  if (cell[axis] != plane && cell[axis + 3] != plane)
    return 0;
  for (int b = 0; b < 3; b++)
    if (b != axis && (node[b] < cell[b] || node[b] > cell[b + 3]))
      return 0;
  return 1;
}

static void slow_local_knots(const tsolid_tmesh *t, const int *node, int axis, int knot[5]) {
  knot[2] = node[axis];
  for (int sign = -1; sign <= 1; sign += 2) {
    int found = 0, last = node[axis];
    for (int p = node[axis] + sign; p >= 0 && p < t->n_planes[axis] && found < 2; p += sign)
      for (int c = 0; c < t->n_cells; c++)
        if (face_holds(t->cell + 6 * c, axis, p, node)) {
          knot[2 + sign * ++found] = last = p;
          break;
        }
    for (; found < 2; found++)
      knot[2 + sign * (found + 1)] = last;
  }
}

static void test_rays(tsolid_context *context) {
  for (int refined = 0; refined < 2; refined++) {
    box_set boxes = make_boxes(refined ? 6 : 3, refined);
    tsolid_tmesh *tmesh = mesh_of(context, &boxes);
    tsi_arena arena = tsi_arena_create(context);
    int n, *node, knot[5], slow[5], differ = 0;
    CHECK(tsi_tmesh_nodes(context, tmesh, &arena, &n, &node) == TSOLID_OK);
    for (int a = 0; a < 3; a++) {
      tsi_columns columns;
      CHECK(tsi_columns_create(context, tmesh, a, n, node, &arena, &columns) == TSOLID_OK);
      for (int i = 0; i < n; i++) {
        tsi_columns_local_knots(&columns, node + 3 * i, knot);
        slow_local_knots(tmesh, node + 3 * i, a, slow);
        differ += memcmp(knot, slow, sizeof knot) != 0;
      }
    }
    CHECK(n > 100);
    CHECK(differ == 0);
    tsi_arena_free(&arena);
    tsolid_tmesh_free(tmesh);
    free_boxes(&boxes);
  }
}

/* ---- extraction against de Boor
 * --------------------------------------------------------------------------------- */

/* Cubic B-spline with these knots at x, by its divided-difference recursion. */
static double slow_bspline(const double *knot, int degree, double x) {
  if (degree == 0)
    return knot[0] <= x && x < knot[1];
  double value = 0.0;
  if (knot[degree] > knot[0])
    value += (x - knot[0]) / (knot[degree] - knot[0]) * slow_bspline(knot, degree - 1, x);
  if (knot[degree + 1] > knot[1])
    value += (knot[degree + 1] - x) / (knot[degree + 1] - knot[1]) *
             slow_bspline(knot + 1, degree - 1, x);
  return value;
}

static double slow_function(const tsolid_space *s, int f, int block, const double u[3]) {
  double sum = 0.0;
  for (int p = s->piece_start[f]; p < s->piece_start[f + 1]; p++) {
    double product = s->piece[p].block < 0 || s->piece[p].block == block;
    for (int a = 0; a < 3 && product != 0.0; a++) {
      double knot[5];
      for (int k = 0; k < 5; k++)
        knot[k] = s->tmesh->plane_value[a][s->piece[p].knot[a][k]];
      product *= slow_bspline(knot, 3, u[a]);
    }
    sum += product;
  }
  return sum;
}

/* All inner functions at a point inside an element, from rows. */
static void from_rows(const tsolid_space *s, int element, const double u[3], double *value) {
  const tsi_element *e = &s->element[element];
  double b[3][4];
  for (int a = 0; a < 3; a++)
    tsi_bernstein(3, (u[a] - e->box[a]) / (e->box[a + 3] - e->box[a]), b[a]);
  for (size_t i = s->inner_start[element]; i < s->inner_start[element + 1]; i++) {
    double product = 1.0;
    for (int a = 0; a < 3; a++) {
      const double *row = s->row + 4 * s->inner_row[i][a];
      double sum = 0.0;
      for (int k = 0; k < 4; k++)
        sum += row[k] * b[a][k];
      product *= sum;
    }
    value[s->inner_function[i]] += product;
  }
}

static double element_volume(const tsi_element *e) {
  return (e->box[3] - e->box[0]) * (e->box[4] - e->box[1]) * (e->box[5] - e->box[2]);
}

static void test_extraction(tsolid_context *context) {
  for (int refined = 0; refined < 2; refined++) {
    box_set boxes = make_boxes(refined ? 6 : 2, refined);
    tsolid_tmesh *tmesh = mesh_of(context, &boxes);
    tsolid_space *space = space_of(context, tmesh, 2, 3);
    double *value = calloc((size_t)space->n_inner, sizeof *value), volume = 0.0, largest = 0.0;
    for (int e = 0; e < space->n_elements; e++) {
      const double *box = space->element[e].box;
      double u[3];
      for (int a = 0; a < 3; a++)
        u[a] = box[a] + (box[a + 3] - box[a]) * random_unit();
      memset(value, 0, (size_t)space->n_inner * sizeof *value);
      from_rows(space, e, u, value);
      for (int f = 0; f < space->n_inner; f++)
        largest =
            fmax(largest, fabs(value[f] - slow_function(space, f, space->element[e].block, u)));
      volume += element_volume(&space->element[e]);
    }
    CHECK_NEAR(largest, 0.0, 1e-13);
    double arms = 0.0;
    for (int side = 0; side < 6; side++)
      arms += HEIGHT[side];
    CHECK_NEAR(volume, 1.0 + arms, 1e-12); /* the elements tile the cross */
    CHECK(refined == 0 || boxes.n > 20);
    free(value);
    tsolid_space_free(space);
    tsolid_tmesh_free(tmesh);
    free_boxes(&boxes);
  }
}

/* ---- refusals
 * ------------------------------------------------------------------------------------------------------
 */

static void test_refusals(tsolid_context *context) {
  box_set s = make_boxes(2, 0);
  tsolid_tmesh *tmesh;
  const double *const *line = (const double *const *)s.line;
  CHECK(tsi_tmesh_from_boxes(context, s.n_lines, line, s.n - 1, s.box, HEIGHT, 0, &tmesh) ==
        TSOLID_ERROR_INPUT); /* a gap */
  CHECK(tmesh == NULL);
  s.box[3] = 2; /* overlap */
  CHECK(tsi_tmesh_from_boxes(context, s.n_lines, line, s.n, s.box, HEIGHT, 0, &tmesh) ==
        TSOLID_ERROR_INPUT);
  s.box[3] = 0; /* no box */
  CHECK(tsi_tmesh_from_boxes(context, s.n_lines, line, s.n, s.box, HEIGHT, 0, &tmesh) ==
        TSOLID_ERROR_INPUT);
  s.box[3] = 1;
  s.line[1][1] = 1.5; /* lines must ascend */
  CHECK(tsi_tmesh_from_boxes(context, s.n_lines, line, s.n, s.box, HEIGHT, 0, &tmesh) ==
        TSOLID_ERROR_INPUT);
  free_boxes(&s);
}

int main(void) {
  tsolid_context *context;
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  test_counts(context);
  test_rays(context);
  test_extraction(context);
  test_refusals(context);
  tsolid_context_free(context);
  return check_done();
}
