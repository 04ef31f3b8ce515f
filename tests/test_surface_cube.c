/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The cut of a surface into six sides: results that cannot depend on numbering, positions and
 * control points known in advance, isolines that run through faces, and every reason to refuse. */
#include "check.h"
#include "surface_parts.h"

static cells mesh;
static unsigned long long seed = 20;

/* ---- helpers ----------------------------------------------------------------------------------
 */

static tsolid_context *context;

static tsolid_status cut_surface(const cells *m, int degree, unsigned long long *number,
                                 tsolid_requirement *requirement, tsolid_boundary **boundary) {
  struct tsolid_surface surface;
  tsi_arena arena = tsi_arena_create(context);
  tsolid_bezier_boundary bezier;
  tsolid_requirement found;
  *boundary = NULL;
  surface_part_build(m, degree, number, &surface);
  tsolid_status status = tsi_surface_to_sides(context, &arena, &surface, requirement, &bezier);
  if (!status) {
    tsolid_boundary_input input = {.bezier = &bezier};
    status = tsolid_boundary_create(context, &input, NULL, &found, boundary);
  }
  tsi_arena_free(&arena);
  surface_part_free(&surface);
  return status;
}

static void print_findings(void) {
  for (int i = 0; i < tsolid_context_n_findings(context); i++)
    fprintf(stderr, "    %s\n", tsolid_context_finding(context, i)->text);
}

static int has_finding(const char *text) {
  for (int i = 0; i < tsolid_context_n_findings(context); i++)
    if (strstr(tsolid_context_finding(context, i)->text, text))
      return 1;
  return 0;
}

static int check_accepted(const cells *m, int degree, unsigned long long *number,
                          tsolid_boundary **boundary) {
  tsolid_requirement requirement;
  tsolid_context_clear(context);
  int accepted =
      CHECK(cut_surface(m, degree, number, &requirement, boundary) == TSOLID_OK && *boundary);
  if (!accepted)
    print_findings();
  CHECK(requirement.closed && requirement.connected && requirement.genus == 0);
  CHECK(requirement.n_extraordinary == 8 && requirement.n_violations == 0);
  return accepted;
}

static void check_refused(const cells *m, const char *text) {
  for (int pass = 0; pass < 4; pass++) {
    tsolid_boundary *boundary;
    tsolid_requirement requirement;
    tsolid_context_clear(context);
    CHECK(cut_surface(m, 1, pass ? &seed : NULL, &requirement, &boundary) == TSOLID_ERROR_REFUSED);
    CHECK(requirement.n_violations > 0 && boundary == NULL);
    if (!CHECK(has_finding(text)))
      print_findings();
    tsolid_boundary_free(boundary);
  }
}

/* The part's coordinate along an axis of the cube in canonical position: corner 0 is the origin,
 * its least neighbour lies on z. */
static int part_axis(int axis) {
  return (axis + 2) % 3;
}

/* Control points of the box's surface are its lattice points: at parameters (s, t) of a side the
 * point is corner 0 + (s, t) times the lengths, to the last digits. Catches wrong positions, turned
 * coefficients, exchanged functions. */
static void check_box(const tsolid_boundary *boundary, const cells *m) {
  tsolid_bezier_boundary view;
  tsolid_boundary_view(boundary, &view);
  double largest = 0.0, sum_defect = 0.0;
  for (int side = 0; side < 6; side++) {
    const tsolid_bezier_side *b = &view.side[side];
    int axis[2] = {part_axis(tsi_side_s(side)), part_axis(tsi_side_t(side))},
        across = part_axis(side / 2), n0 = b->degree[0] + 1, n1 = b->degree[1] + 1;
    for (int e = 0; e < b->n_elements; e++)
      for (int j = 0; j < n1; j++)
        for (int i = 0; i < n0; i++) {
          double h[4] = {0.0, 0.0, 0.0, 0.0}, sum = 0.0, at[2];
          for (int k = b->function_start[e]; k < b->function_start[e + 1]; k++) {
            double c = b->coefficient[(size_t)k * (size_t)(n0 * n1) + (size_t)(i + n0 * j)];
            sum += c;
            for (int d = 0; d < 4; d++)
              h[d] += c * view.points[4 * (size_t)b->function[k] + (size_t)d];
          }
          at[0] = b->box[4 * e] + (b->box[4 * e + 1] - b->box[4 * e]) * i / (n0 - 1);
          at[1] = b->box[4 * e + 2] + (b->box[4 * e + 3] - b->box[4 * e + 2]) * j / (n1 - 1);
          sum_defect = fmax(sum_defect, fabs(sum - 1.0));
          for (int d = 0; d < 2; d++)
            largest = fmax(largest, fabs(h[axis[d]] / h[3] - at[d] * m->axis_length[axis[d]]));
          double normal = side & 1 ? m->axis_length[across] : 0.0;
          largest = fmax(largest, fabs(h[across] / h[3] - normal));
        }
  }
  CHECK_NEAR(largest, 0.0, 1e-13);
  CHECK_NEAR(sum_defect, 0.0, 1e-15);
}

static int same_bytes(const void *a, const void *b, size_t n) {
  return memcmp(a, b, n) == 0;
}

static int same_boundaries(const tsolid_boundary *p, const tsolid_boundary *q) {
  tsolid_bezier_boundary a, b;
  tsolid_boundary_view(p, &a);
  tsolid_boundary_view(q, &b);
  int same =
      a.n_functions == b.n_functions && same_bytes(a.points, b.points, 32 * (size_t)a.n_functions);
  for (int i = 0; same && i < 6; i++) {
    const tsolid_bezier_side *s = &a.side[i], *t = &b.side[i];
    size_t n = (size_t)s->n_elements;
    same = s->degree[0] == t->degree[0] && s->degree[1] == t->degree[1] &&
           s->n_elements == t->n_elements && same_bytes(s->box, t->box, 32 * n) &&
           same_bytes(s->function_start, t->function_start, (n + 1) * sizeof(int));
    size_t entries = (size_t)s->function_start[n];
    size_t width = (size_t)((s->degree[0] + 1) * (s->degree[1] + 1));
    same = same && same_bytes(s->function, t->function, entries * sizeof(int)) &&
           same_bytes(s->coefficient, t->coefficient, entries * width * sizeof(double));
  }
  return same;
}

/* Lines with random intervals, some of them repeated. */
static void random_lines(const int n[3], double line[3][LINES_MAX], int with_zeros) {
  for (int a = 0; a < 3; a++) {
    line[a][0] = 0.0;
    for (int i = 0; i < n[a]; i++) {
      double width = 0.05 + surface_random_unit(&seed);
      if (with_zeros && i > 0 && i + 1 < n[a] && surface_random(&seed) % 3 == 0)
        width = 0.0;
      line[a][i + 1] = line[a][i] + width;
    }
  }
}

static void make_box(cells *m, const int n[3], double line[3][LINES_MAX], int first[6]) {
  const double *const lines[3] = {line[0], line[1], line[2]};
  cells_box(m, n, lines, first);
}

static void set_label(cells *m, int from, int to) {
  for (int c = 0; c < m->n; c++)
    if (m->cell[c].label == from)
      m->cell[c].label = to;
}

/* ---- boxes ------------------------------------------------------------------------------------
 */

static void test_box_any_numbering(void) {
  double line[3][LINES_MAX];
  int first[6];
  for (int round = 0; round < 12; round++) {
    int n[3];
    for (int a = 0; a < 3; a++)
      n[a] = 1 + (int)(surface_random(&seed) % 4);
    if (round == 0)
      n[0] = n[1] = n[2] = 1;
    random_lines(n, line, 0);
    make_box(&mesh, n, line, first);
    tsolid_boundary *plain, *shuffled;
    int degree = 1 + round % 3;
    if (!check_accepted(&mesh, degree, NULL, &plain))
      continue;
    check_box(plain, &mesh);
    for (int pass = 0; pass < 4; pass++) {
      if (check_accepted(&mesh, degree, &seed, &shuffled))
        CHECK(same_boundaries(plain, shuffled));
      tsolid_boundary_free(shuffled);
    }
    tsolid_boundary_free(plain);
  }
}

/* Bent boxes with weights: the result does not depend on numbering either. */
static void test_bent_box(void) {
  double line[3][LINES_MAX];
  int first[6], n[3] = {3, 2, 4};
  random_lines(n, line, 0);
  make_box(&mesh, n, line, first);
  for (int v = 0; v < mesh.n_vertices; v++) {
    double *h = mesh.point[v], w = 0.5 + surface_random_unit(&seed);
    for (int c = 0; c < 3; c++)
      h[c] = w * (h[c] + 0.1 * surface_random_unit(&seed));
    h[3] = w;
  }
  tsolid_boundary *plain, *shuffled;
  if (!check_accepted(&mesh, 3, NULL, &plain))
    return;
  for (int pass = 0; pass < 8; pass++) {
    if (check_accepted(&mesh, 3, &seed, &shuffled))
      CHECK(same_boundaries(plain, shuffled));
    tsolid_boundary_free(shuffled);
  }
  tsolid_boundary_free(plain);
}

/* Two or three rows of cells become one face each: T-junctions on isolines and inside sides. */
static void test_t_junctions(void) {
  double line[3][LINES_MAX];
  int first[6], n[3] = {4, 3, 5};
  for (int round = 0; round < 10; round++) {
    random_lines(n, line, 0);
    make_box(&mesh, n, line, first);
    for (int side = 0; side < 6; side++) {
      int ns = n[tsi_side_s(side)], nt = n[tsi_side_t(side)];
      for (int j = 0; j < nt; j++)
        for (int i = 0; i + 1 < ns; i++) { /* pairs along s */
          int a = first[side] + i + ns * j, b = a + 1;
          if (mesh.cell[a].label == a && mesh.cell[b].label == b && surface_random(&seed) % 3 == 0)
            set_label(&mesh, b, a);
        }
    }
    tsolid_boundary *plain, *shuffled;
    if (!check_accepted(&mesh, 1, NULL, &plain))
      continue;
    check_box(plain, &mesh);
    if (check_accepted(&mesh, 1, &seed, &shuffled)) /* frames' own sums: equal to round-off */
      check_box(shuffled, &mesh);
    tsolid_boundary_free(shuffled);
    tsolid_boundary_free(plain);
  }
}

/* ---- isolines through faces -------------------------------------------------------------------
 */

/* Joins the cells on both sides of steps first..end-1 of one isoline: a stem ends on the isoline's
 * path, which runs on through the faces. As single elements they are cut in two, and vertices of
 * the lattice on the isoline hang on the far corners. */
static void join_across(cells *m, const int n[3], const int side_first[6], int begin, int end,
                        int single) {
  for (int i = begin; i < end; i++) { /* isoline along x at y = 0, z = 0: sides 2 and 4 */
    int a = side_first[2] + i, b = side_first[4] + i;
    m->cell[b].label = m->cell[a].label;
    m->is_single[m->cell[a].label] = single;
  }
  for (int i = begin; single && i <= end; i++) {
    int x[3] = {i, 0, 0}, y[3] = {i, 1, 0}, z[3] = {i, 0, 1};
    int v = cells_lattice(n, x);
    m->hangs[v][0] = cells_lattice(n, y);
    m->hangs[v][1] = cells_lattice(n, z);
    double to_y = m->point[m->hangs[v][0]][1], to_z = m->point[m->hangs[v][1]][2];
    m->share[v] = to_z / (to_y + to_z);
  }
}

static void test_isolines_through_faces(void) {
  double line[3][LINES_MAX];
  int first[6];
  for (int round = 0; round < 12; round++) {
    int n[3] = {6, 2 + round % 2, 3}, begin = 1 + round % 3, end = begin + 1 + round % 2;
    random_lines(n, line, 0);
    make_box(&mesh, n, line, first);
    join_across(&mesh, n, first, begin, end, 0);
    tsolid_boundary *boundary;
    for (int pass = 0; pass < 3; pass++) {
      if (check_accepted(&mesh, 1 + pass, pass ? &seed : NULL, &boundary))
        check_box(boundary, &mesh);
      tsolid_boundary_free(boundary);
    }
  }
}

/* The isoline runs through elements, which are cut: the surface is a box with one edge cut off in
 * a ramp, known from the functions themselves. */
static void test_elements_cut(void) {
  double line[3][LINES_MAX];
  int first[6];
  for (int round = 0; round < 8; round++) {
    int n[3] = {6, 2, 3}, begin = 1 + round % 3, end = begin + 1 + round % 2;
    random_lines(n, line, 0);
    make_box(&mesh, n, line, first);
    join_across(&mesh, n, first, begin, end, 1);
    tsolid_boundary *boundary;
    for (int pass = 0; pass < 3; pass++) {
      if (check_accepted(&mesh, 1 + pass, pass ? &seed : NULL, &boundary)) {
        tsolid_bezier_boundary view;
        tsolid_boundary_view(boundary, &view);
        int n_elements = 0;
        for (int side = 0; side < 6; side++)
          n_elements += view.side[side].n_elements;
        CHECK(n_elements == mesh.n); /* each single element gave two again */
        /* the vertices that hang are functions of none: */
        CHECK(view.n_functions ==
              2 * (7 * 3 + 7 * 4 + 3 * 4) - 4 * (7 + 3 + 4) + 8 - (end - begin + 1));
      }
      tsolid_boundary_free(boundary);
    }
  }
}

/* ---- zero intervals ---------------------------------------------------------------------------
 */

/* Bilinear functions of both ends of a zero interval are one: else the surface would be torn. */
static void join_zero_intervals(cells *m, const int n[3], double (*line)[LINES_MAX]) {
  for (int x = 0; x <= n[0]; x++)
    for (int y = 0; y <= n[1]; y++)
      for (int z = 0; z <= n[2]; z++) {
        int at[3] = {x, y, z}, twin[3] = {x, y, z}, on = 0;
        for (int a = 0; a < 3; a++) {
          on |= at[a] == 0 || at[a] == n[a];
          while (twin[a] > 0 && line[a][twin[a]] == line[a][twin[a] - 1])
            twin[a]--;
        }
        int v = on ? cells_lattice(n, at) : -1, w = on ? cells_lattice(n, twin) : -1;
        if (v == w)
          continue;
        m->hangs[v][0] = m->hangs[v][1] = w;
        m->share[v] = 1.0;
      }
}

static void test_zero_intervals(void) {
  double line[3][LINES_MAX];
  int first[6], n[3] = {5, 4, 6};
  for (int round = 0; round < 6; round++) {
    random_lines(n, line, 1);
    make_box(&mesh, n, line, first);
    join_zero_intervals(&mesh, n, line);
    tsolid_boundary *plain, *shuffled;
    if (!check_accepted(&mesh, 1, NULL, &plain))
      continue;
    check_box(plain, &mesh);
    if (check_accepted(&mesh, 1, &seed, &shuffled))
      CHECK(same_boundaries(plain, shuffled));
    tsolid_boundary_free(shuffled);
    tsolid_boundary_free(plain);
  }
  random_lines(n, line, 0);
  for (int i = 0; i <= n[1]; i++)
    line[1][i] = 0.0;
  make_box(&mesh, n, line, first);
  check_refused(&mesh, "has length zero");
}

/* ---- refusals ---------------------------------------------------------------------------------
 */

/* The surface of a set of unit voxels, bit x + 4y + 16z. */
static void make_voxels(cells *m, unsigned long long voxels) {
  const int n[3] = {4, 4, 4};
  cells_init(m);
  m->n_vertices = 125;
  for (int axis = 0; axis < 3; axis++)
    for (int end = 0; end < 2; end++)
      for (int v = 0; v < 64; v++) {
        int at[3] = {v & 3, v >> 2 & 3, v >> 4}, to = at[axis] + (end ? 1 : -1);
        int stride = axis == 0 ? 1 : axis == 1 ? 4 : 16;
        if (!(voxels >> v & 1) ||
            (to >= 0 && to < 4 && voxels >> (v + (end ? stride : -stride)) & 1))
          continue;
        cell *c = &m->cell[m->n];
        int s = (axis + 1) % 3, t = (axis + 2) % 3;
        c->label = m->n++;
        for (int k = 0; k < 4; k++) {
          int q = end ? k : 3 - k, x[3];
          x[axis] = at[axis] + end;
          x[s] = at[s] + (q == 1 || q == 2);
          x[t] = at[t] + (q >= 2);
          c->vertex[k] = cells_lattice(n, x);
          c->length[k] = 1.0;
        }
      }
  for (int v = 0; v < 125; v++) {
    double h[4] = {v % 5, v / 5 % 5, v / 25, 1.0};
    memcpy(m->point[v], h, sizeof h);
  }
}

static unsigned long long voxel(int x, int y, int z) {
  return 1ULL << (x + 4 * y + 16 * z);
}

static void test_voxels_refused(void) {
  /* an L: ten vertices of valence three, two of five */
  make_voxels(&mesh, voxel(0, 0, 0) | voxel(1, 0, 0) | voxel(0, 1, 0));
  check_refused(&mesh, "has valence 5");
  check_refused(&mesh, "there are 10 of valence three");
  /* a ring */
  unsigned long long ring = 0;
  for (int k = 0; k < 9; k++)
    ring |= k == 4 ? 0 : voxel(k % 3, k / 3, 1);
  make_voxels(&mesh, ring);
  check_refused(&mesh, "genus 1");
  /* two cubes */
  make_voxels(&mesh, voxel(0, 0, 0) | voxel(2, 2, 2));
  check_refused(&mesh, "2 separate parts");
  /* a cube without its lid, and without two */
  make_voxels(&mesh, voxel(1, 1, 1));
  mesh.n--;
  check_refused(&mesh, "open: 1 boundary loop");
  make_voxels(&mesh, voxel(1, 1, 1) | voxel(2, 1, 1));
  int kept = 0;
  for (int c = 0; c < mesh.n; c++) /* the two ends of the bar */
    if (c != 0 && c != 1)
      mesh.cell[kept++] = mesh.cell[c];
  mesh.n = kept;
  for (int c = 0; c < mesh.n; c++)
    mesh.cell[c].label = c;
  check_refused(&mesh, "open: 2 boundary loops");
  /* all sets within 2 x 2 x 2: a status always, and a box is taken */
  for (unsigned set = 1; set < 256; set++) {
    unsigned long long voxels = 0;
    for (int k = 0; k < 8; k++)
      if (set >> k & 1)
        voxels |= voxel(k & 1, k >> 1 & 1, k >> 2);
    make_voxels(&mesh, voxels);
    int broken = 0; /* edges that four faces share are no surface */
    for (int c = 0; c < mesh.n; c++)
      for (int k = 0; k < 4; k++) {
        int twins = 0;
        for (int d = 0; d < mesh.n; d++)
          for (int e = 0; e < 4; e++)
            twins += mesh.cell[d].vertex[e] == mesh.cell[c].vertex[k] &&
                     mesh.cell[d].vertex[(e + 1) % 4] == mesh.cell[c].vertex[(k + 1) % 4];
        broken |= twins != 1;
      }
    if (broken)
      continue;
    int volume = 0;
    for (int k = 0; k < 8; k++)
      volume += (int)(set >> k & 1);
    int box = (mesh.n == 6 && volume == 1) || (mesh.n == 10 && volume == 2) ||
              (mesh.n == 16 && volume == 4) || (mesh.n == 24 && volume == 8);
    tsolid_boundary *boundary;
    tsolid_requirement requirement;
    tsolid_context_clear(context);
    tsolid_status status = cut_surface(&mesh, 1, &seed, &requirement, &boundary);
    CHECK(status == (box ? TSOLID_OK : TSOLID_ERROR_REFUSED));
    if (status && !box)
      CHECK(tsolid_context_n_findings(context) > 0);
    tsolid_boundary_free(boundary);
  }
}

/* The lid turned by `shift` vertices of its rim: eight stars always, a cube only for whole sides.
 */
static void make_twisted(cells *m, int n, int shift) {
  double line[3][LINES_MAX];
  int count[3] = {n, n, 3}, first[6], rim[4 * LINES_MAX], n_rim = 0;
  for (int a = 0; a < 3; a++)
    for (int i = 0; i <= count[a]; i++)
      line[a][i] = i;
  make_box(m, count, line, first);
  for (int i = 0; i < 4 * n; i++) {
    int along = i % n, side = i / n;
    int x[3] = {side == 0   ? along
                : side == 1 ? n
                : side == 2 ? n - along
                            : 0,
                side == 0   ? 0
                : side == 1 ? along
                : side == 2 ? n
                            : n - along,
                3};
    rim[n_rim++] = cells_lattice(count, x);
  }
  for (int c = first[5]; c < first[5] + n * n; c++)
    for (int k = 0; k < 4; k++)
      for (int i = 0; i < n_rim; i++)
        if (m->cell[c].vertex[k] == rim[i]) {
          m->cell[c].vertex[k] = rim[(i + shift) % n_rim];
          break;
        }
}

static void test_twisted(void) {
  for (int n = 2; n <= 4; n++)
    for (int shift = 0; shift < 4 * n; shift++) {
      tsolid_requirement requirement;
      struct tsolid_surface surface;
      tsi_arena arena = tsi_arena_create(context);
      tsolid_bezier_boundary bezier;
      make_twisted(&mesh, n, shift);
      surface_part_build(&mesh, 1, &seed, &surface);
      tsolid_context_clear(context);
      tsolid_status status = tsi_surface_to_sides(context, &arena, &surface, &requirement, &bezier);
      CHECK(requirement.n_extraordinary == 8);
      if (!CHECK(status == (shift % n == 0 ? TSOLID_OK : TSOLID_ERROR_REFUSED)))
        fprintf(stderr, "    n %d, shift %d\n", n, shift), print_findings();
      if (shift % n)
        CHECK(has_finding("crosses") || has_finding("comes back") || has_finding("corners"));
      tsi_arena_free(&arena);
      surface_part_free(&surface);
    }
}

/* Knot sums that do not agree are refused, round-off is not. */
static void test_sums(void) {
  double line[3][LINES_MAX];
  int first[6], n[3] = {3, 3, 3};
  random_lines(n, line, 0);
  for (int pass = 0; pass < 2; pass++) {
    struct tsolid_surface surface;
    tsi_arena arena = tsi_arena_create(context);
    tsolid_requirement requirement;
    tsolid_bezier_boundary bezier;
    make_box(&mesh, n, line, first);
    surface_part_build(&mesh, 1, NULL, &surface);
    surface.interval[7] *= pass ? 1.001 : 1.0 + 1e-15;
    tsolid_context_clear(context);
    tsolid_status status = tsi_surface_to_sides(context, &arena, &surface, &requirement, &bezier);
    CHECK(status == (pass ? TSOLID_ERROR_REFUSED : TSOLID_OK));
    CHECK(!pass || has_finding("do not close"));
    tsi_arena_free(&arena);
    surface_part_free(&surface);
  }
}

/* ---- memory -----------------------------------------------------------------------------------
 */

typedef struct failing {
  int countdown, live;
} failing;

static void *fail_allocate(void *data, size_t size) {
  failing *f = data;
  if (f->countdown-- == 0)
    return NULL;
  f->live++;
  return malloc(size);
}

static void fail_release(void *data, void *memory) {
  ((failing *)data)->live--;
  free(memory);
}

static void test_every_allocation_fails(void) {
  double line[3][LINES_MAX];
  int first[6], n[3] = {4, 2, 2}, n_memory = 0;
  random_lines(n, line, 0);
  make_box(&mesh, n, line, first);
  join_across(&mesh, n, first, 1, 3, 1);
  struct tsolid_surface surface;
  surface_part_build(&mesh, 1, &seed, &surface);
  for (int at = 0; at < 1000; at++) {
    failing f = {at, 0};
    tsolid_context_options options = {
        .allocate = fail_allocate, .release = fail_release, .allocator_data = &f, .n_threads = 1};
    tsolid_context *own = NULL;
    tsolid_requirement requirement;
    tsolid_bezier_boundary bezier;
    if (tsolid_context_create(&options, &own))
      continue;
    tsi_arena arena = tsi_arena_create(own);
    tsolid_status status = tsi_surface_to_sides(own, &arena, &surface, &requirement, &bezier);
    CHECK(status == TSOLID_OK || status == TSOLID_ERROR_MEMORY);
    n_memory += status == TSOLID_ERROR_MEMORY;
    tsi_arena_free(&arena);
    tsolid_context_free(own);
    CHECK(f.live == 0);
    if (!status)
      break;
    CHECK(at < 999);
  }
  CHECK(n_memory > 10);
  surface_part_free(&surface);
}

int main(void) {
  if (!CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  test_box_any_numbering();
  test_bent_box();
  test_t_junctions();
  test_isolines_through_faces();
  test_elements_cut();
  test_zero_intervals();
  test_voxels_refused();
  test_twisted();
  test_sums();
  test_every_allocation_fails();
  tsolid_context_free(context);
  return check_done();
}
