/* SPDX-License-Identifier: LGPL-2.1-or-later
 * .iga: surfaces of known shape, written element by element in any frame, order and degree, are
 * found again; surfaces that are none, malformed and mutated files are refused with a reason, in
 * memory that the file's size bounds. */
#define _XOPEN_SOURCE 700
#include <unistd.h>

#include "check.h"
#include "counted_memory.h"
#include "surface_parts.h"

static tsolid_context *context;
static cells mesh;
static unsigned long long seed = 7;
static char path[80];

/* ---- writing ----------------------------------------------------------------------------------
 */

/* Bernstein coefficients one degree up, along rows (step 1) or columns. */
static void raise_once(double *net, int degree[2], int d) {
  double old[64];
  int p = degree[d], n0 = degree[0] + 1, n1 = degree[1] + 1, m0 = n0 + (d == 0);
  memcpy(old, net, sizeof old);
  degree[d]++;
  for (int j = 0; j < n1 + (d == 1); j++)
    for (int i = 0; i < m0; i++) {
      int k = d == 0 ? i : j;
      double a = (double)k / (p + 1), low = 0.0, high = 0.0;
      if (k > 0)
        low = d == 0 ? old[i - 1 + n0 * j] : old[i + n0 * (j - 1)];
      if (k <= p)
        high = old[i + n0 * j];
      net[i + m0 * j] = a * low + (1.0 - a) * high;
    }
}

/* One element in a random frame (mirrored ones included) with functions in random order, raised by
 * up to `raise` in each direction. */
static void write_element(FILE *file, const struct tsolid_surface *s, int e, int raise) {
  int first = s->function_start[e], k = s->function_start[e + 1] - first, order[64];
  int p = s->degree, turn = (int)(surface_random(&seed) % 8), up[2];
  shuffle(order, k, &seed);
  for (int d = 0; d < 2; d++)
    up[d] = raise > 0 ? (int)(surface_random(&seed) % (unsigned)(raise + 1)) : 0;
  fprintf(file, "belem %d %d %d # element %d\n", k, p + up[0], p + up[1], e);
  for (int i = 0; i < k; i++)
    fprintf(file, "%d%s", s->function[first + order[i]], i + 1 < k ? " " : "\n");
  for (int i = 0; i < k; i++) {
    const double *c = s->coefficient + (size_t)((first + order[i]) * (p + 1) * (p + 1));
    double net[64] = {0.0};
    int degree[2] = {p, p};
    for (int y = 0; y <= p; y++)
      for (int x = 0; x <= p; x++) {
        int u = turn & 1 ? p - x : x, v = turn & 2 ? p - y : y;
        net[x + (p + 1) * y] = turn & 4 ? c[v + (p + 1) * u] : c[u + (p + 1) * v];
      }
    for (int d = 0; d < 2; d++)
      for (int n = 0; n < up[d]; n++)
        raise_once(net, degree, d);
    for (int n = 0; n < (degree[0] + 1) * (degree[1] + 1); n++)
      fprintf(file, "%.17g ", net[n]);
    fputc('\n', file);
  }
}

static FILE *open_file(int n_nodes, int n_elements) {
  FILE *file = fopen(path, "w");
  if (!file)
    abort();
  fprintf(file, "# a comment\ntype surface\n\nnodeN %d\nelemN %d\n", n_nodes, n_elements);
  return file;
}

static void write_surface(const struct tsolid_surface *s, int raise) {
  int n_elements = s->element_start[s->n_faces];
  FILE *file = open_file(s->n_points, n_elements);
  for (int i = 0; i < s->n_points; i++) {
    const double *h = s->points + 4 * i;
    fprintf(file, "%s %.17g %.17g %.17g %.17g\n", i % 2 ? "gnode" : "node", h[0] / h[3],
            h[1] / h[3], h[2] / h[3], h[3]);
  }
  for (int e = 0; e < n_elements; e++)
    write_element(file, s, e, raise);
  fprintf(file, "set 2 side Top 0 LEFT 1 RIGHT\ndomain 1 4\n0\n1 2 3 4\n0 1 2 3\n");
  fclose(file);
}

/* Cells as they are, one bilinear element each. */
static void write_cells(const cells *m) {
  FILE *file = open_file(m->n_vertices, m->n);
  for (int v = 0; v < m->n_vertices; v++)
    fprintf(file, "node %d %d %d 1\n", v % 7, v / 7, v % 3);
  for (int c = 0; c < m->n; c++) {
    const int *v = m->cell[c].vertex;
    fprintf(file, "belem 4 1 1\n%d %d %d %d\n1 0 0 0\n0 1 0 0\n0 0 0 1\n0 0 1 0\n", v[0], v[1],
            v[2], v[3]);
  }
  fclose(file);
}

static void write_text(const char *text) {
  FILE *file = fopen(path, "w");
  if (!file)
    abort();
  fputs(text, file);
  fclose(file);
}

/* ---- reading ----------------------------------------------------------------------------------
 */

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

static tsolid_surface *read_back(void) {
  tsolid_surface *surface = NULL;
  tsolid_context_clear(context);
  if (!CHECK(tsolid_read_iga(context, path, &surface) == TSOLID_OK))
    print_findings();
  return surface;
}

static void check_refused(tsolid_status want, const char *text) {
  tsolid_surface *surface = NULL;
  tsolid_context_clear(context);
  tsolid_status status = tsolid_read_iga(context, path, &surface);
  CHECK(surface == NULL);
  if (!CHECK(status == want) || !CHECK(has_finding(text))) {
    fprintf(stderr, "    status %d, wanted '%s'\n", (int)status, text);
    print_findings();
  }
}

static tsolid_status to_boundary(const tsolid_surface *surface, tsolid_boundary **boundary) {
  tsi_arena arena = tsi_arena_create(context);
  tsolid_requirement requirement;
  tsolid_bezier_boundary bezier;
  *boundary = NULL;
  tsolid_status status = tsi_surface_to_sides(context, &arena, surface, &requirement, &bezier);
  if (!status) {
    tsolid_boundary_input input = {.bezier = &bezier};
    status = tsolid_boundary_create(context, &input, NULL, NULL, boundary);
  }
  tsi_arena_free(&arena);
  return status;
}

/* ---- shapes -----------------------------------------------------------------------------------
 */

/* A box of random cells; pairs of neighbours in a side may be one element: vertices between hang.
 */
static void make_box(int with_pairs) {
  double line[3][LINES_MAX];
  int first[6], n[3];
  for (int a = 0; a < 3; a++) {
    n[a] = 2 + (int)(surface_random(&seed) % 3);
    line[a][0] = 0.0;
    for (int i = 0; i < n[a]; i++)
      line[a][i + 1] = line[a][i] + 0.25 * (double)(1 + surface_random(&seed) % 4);
  }
  const double *const lines[3] = {line[0], line[1], line[2]};
  cells_box(&mesh, n, lines, first);
  for (int side = 0; with_pairs && side < 6; side++) {
    int s = tsi_side_s(side), t = tsi_side_t(side), ns = n[s],
        i = (int)(surface_random(&seed) % (unsigned)(ns - 1));
    /* all of column pairs i, i+1 but the first and last row: long elements side by side */
    for (int j = 1; j + 1 < n[t]; j++) {
      int a = first[side] + i + ns * j;
      mesh.cell[a + 1].label = a;
      mesh.is_single[a] = 1;
    }
    for (int j = 1; n[t] > 2 && j < n[t]; j++) { /* the vertices between them hang */
      int x[3], y[3], z[3];
      x[side / 2] = side & 1 ? n[side / 2] : 0;
      x[t] = j;
      x[s] = i + 1;
      memcpy(y, x, sizeof y);
      memcpy(z, x, sizeof z);
      y[s] = i;
      z[s] = i + 2;
      int v = cells_lattice(n, x);
      mesh.hangs[v][0] = cells_lattice(n, y);
      mesh.hangs[v][1] = cells_lattice(n, z);
      mesh.share[v] = (line[s][i + 2] - line[s][i + 1]) / (line[s][i + 2] - line[s][i]);
    }
  }
}

/* The point of element e of s, at the middle and at a corner of its own frame. */
static void element_point(const struct tsolid_surface *s, int e, double u, double v, double x[3]) {
  double h[4] = {0.0, 0.0, 0.0, 0.0};
  for (int k = s->function_start[e]; k < s->function_start[e + 1]; k++) {
    const double *c = s->coefficient + 4 * k;
    double value =
        (1 - u) * (1 - v) * c[0] + u * (1 - v) * c[1] + (1 - u) * v * c[2] + u * v * c[3];
    for (int d = 0; d < 4; d++)
      h[d] += value * s->points[4 * s->function[k] + d];
  }
  for (int d = 0; d < 3; d++)
    x[d] = h[d] / h[3];
}

static void test_boxes(void) {
  for (int round = 0; round < 16; round++) {
    struct tsolid_surface made;
    make_box(round % 2);
    surface_part_build(&mesh, 1, &seed, &made);
    write_surface(&made, round % 3);
    tsolid_surface *surface = read_back();
    if (!surface) {
      surface_part_free(&made);
      continue;
    }
    tsolid_surface_view view;
    tsolid_surface_get(surface, &view);
    int n_t = 0;
    for (int i = 0; i < made.n_links; i++)
      n_t += made.link[i].straight;
    CHECK(view.n_faces == made.n_faces && view.n_edges == made.n_edges);
    CHECK(view.n_vertices == made.n_vertices && view.n_t_junctions == n_t);
    CHECK(view.n_boundary_loops == 0 && view.n_parts == 1 && view.n_extraordinary == 8);
    CHECK(view.sum_defect < 1e-15);
    double largest = 0.0;
    for (int f = 0; f < made.n_faces; f++) {
      double x[3], y[3];
      const double *size = view.face_size + 2 * f;
      CHECK(tsolid_surface_evaluate(context, surface, f, 0.5 * size[0], 0.5 * size[1], 0, x) ==
            TSOLID_OK);
      element_point(&made, f, 0.5, 0.5, y);
      for (int d = 0; d < 3; d++)
        largest = fmax(largest, fabs(x[d] - y[d]));
    }
    CHECK_NEAR(largest, 0.0, 1e-14);
    tsolid_boundary *boundary;
    if (!CHECK(to_boundary(surface, &boundary) == TSOLID_OK))
      print_findings();
    tsolid_boundary_free(boundary);
    tsolid_surface_free(surface);
    surface_part_free(&made);
  }
}

/* Two rows of elements whose ends lie inside each other's sides. */
static void test_interleaved(void) {
  static const double low[] = {0.0, 0.25, 0.375, 1.0}, high[] = {0.0, 0.625, 0.75, 1.0};
  FILE *file = open_file(6, 6);
  for (int i = 0; i < 6; i++)
    fprintf(file, "node %d %g 0 1\n", i % 2, 0.5 * (i / 2));
  for (int row = 0; row < 2; row++)
    for (int i = 0; i < 3; i++) {
      const double *x = row ? high : low;
      int f = 2 * row;
      fprintf(file, "belem 4 1 1\n%d %d %d %d\n", f, f + 1, f + 2, f + 3);
      fprintf(file, "%.17g %.17g 0 0\n%.17g %.17g 0 0\n", 1 - x[i], 1 - x[i + 1], x[i], x[i + 1]);
      fprintf(file, "0 0 %.17g %.17g\n0 0 %.17g %.17g\n", 1 - x[i], 1 - x[i + 1], x[i], x[i + 1]);
    }
  fclose(file);
  tsolid_surface *surface = read_back();
  if (!surface)
    return;
  tsolid_surface_view view;
  tsolid_surface_get(surface, &view);
  CHECK(view.n_faces == 6 && view.n_t_junctions == 4 && view.n_boundary_loops == 1);
  CHECK(view.n_vertices == 14 && view.n_edges == 19);
  /* widths are as x says, since functions are smooth along the rows */
  double want[6] = {0.25, 0.125, 0.625, 0.625, 0.125, 0.25};
  for (int f = 0; f < 6; f++)
    CHECK_NEAR(view.face_size[2 * f], want[f] / 0.125, 1e-11);
  tsolid_surface_free(surface);
}

/* ---- what is no surface, or none that is taken ------------------------------------------------
 */

static void test_no_surfaces(void) {
  /* three quadrilaterals on one edge */
  cells_init(&mesh);
  mesh.n = 3;
  mesh.n_vertices = 8;
  for (int c = 0; c < 3; c++)
    mesh.cell[c] = (cell){.vertex = {0, 1, 2 + 2 * c, 3 + 2 * c}};
  write_cells(&mesh);
  check_refused(TSOLID_ERROR_REFUSED, "share one edge");
  /* a Moebius band of five */
  cells_init(&mesh);
  mesh.n = 5;
  mesh.n_vertices = 10;
  for (int c = 0; c < 5; c++) {
    int next = c + 1, turn = next == 5;
    next %= 5;
    mesh.cell[c] = (cell){.vertex = {2 * c, 2 * next + turn, 2 * next + 1 - turn, 2 * c + 1}};
  }
  write_cells(&mesh);
  check_refused(TSOLID_ERROR_REFUSED, "only one side");
  /* the same without the turn is a ring with two borders */
  mesh.cell[4] = (cell){.vertex = {8, 0, 1, 9}};
  write_cells(&mesh);
  tsolid_surface *surface = read_back();
  tsolid_boundary *boundary;
  if (surface) {
    CHECK(to_boundary(surface, &boundary) == TSOLID_ERROR_REFUSED);
    CHECK(has_finding("open: 2 boundary loops"));
  }
  tsolid_surface_free(surface);
  /* a pole */
  cells_init(&mesh);
  mesh.n = 1;
  mesh.n_vertices = 3;
  mesh.cell[0] = (cell){.vertex = {0, 1, 2, 2}};
  FILE *file = open_file(3, 1);
  fprintf(
      file,
      "node 0 0 0 1\nnode 1 0 0 1\nnode 0 1 0 1\nbelem 3 1 1\n0 1 2\n1 0 0 0\n0 1 0 0\n0 0 1 1\n");
  fclose(file);
  check_refused(TSOLID_ERROR_REFUSED, "begins and ends at the same point");
  /* forty sheets on one point */
  cells_init(&mesh);
  mesh.n = 40;
  mesh.n_vertices = 121;
  for (int c = 0; c < 40; c++)
    mesh.cell[c] = (cell){.vertex = {0, 1 + 3 * c, 2 + 3 * c, 3 + 3 * c}};
  write_cells(&mesh);
  check_refused(TSOLID_ERROR_REFUSED, "More than 32 elements");
  /* two squares that touch in a corner are two parts with a border each */
  mesh.n = 2;
  mesh.n_vertices = 7;
  write_cells(&mesh);
  surface = read_back();
  if (surface) {
    tsolid_surface_view view;
    tsolid_surface_get(surface, &view);
    CHECK(view.n_parts == 2 && view.n_boundary_loops == 2 && view.n_vertices == 8);
  }
  tsolid_surface_free(surface);
}

static void test_malformed(void) {
  static const struct {
    const char *body, *text;
    tsolid_status status;
  } cases[] = {
      {"", "no 'type'", TSOLID_ERROR_INPUT},
      {"type volume\n", "only plane and surface", TSOLID_ERROR_REFUSED},
      {"type thickened_surface\n", "only plane and surface", TSOLID_ERROR_REFUSED},
      {"type soup\n", "Line 1: expected 'plane'", TSOLID_ERROR_INPUT},
      {"type plane\n", "no 'nodeN'", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nnodeN 1\n", "Line 3: the number is given a second",
       TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1000000\n", "Line 2: the file is too short", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN -4\n", "Line 2: nodeN is '-4'", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 99999999999999999999\n", "Line 2: nodeN is", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 0\n", "Line 3: elemN is '0'", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN x\n", "Line 2: expected nodeN, found 'x'", TSOLID_ERROR_INPUT},
      {"type plane\nnode 0 0 0 1\n", "'nodeN' is missing", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 nan 1\n", "Line 4: expected a finite number",
       TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 1e999 1\n", "Line 4: expected a finite number",
       TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 0\n", "Line 4: the weight", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\nnode 0 0 0 1\n", "Line 5: there are more nodes",
       TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0\nbelem 1 1 1\n", "found 'belem'",
       TSOLID_ERROR_INPUT},
      {"type plane\nbelem 1 1 1\n", "is missing before the first element", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\nbelem 1 0 1\n", "Line 5: the degree is '0'",
       TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\nbelem 2 1 1\n", "number of functions is '2'",
       TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\nbelem 1 26 1\n", "the degree is '26'",
       TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\nbelem 1 25 25\n0\n", "Line 5: the file is too",
       TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\nbelem 1 1 1\n1\n1 1 1 1\n",
       "Line 6: the function is '1'", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 2\nelemN 1\nnode 0 0 0 1\nnode 0 0 0 1\nbelem 2 1 1\n1 1\n1 1 1 1\n0 0 0 "
       "0\n",
       "names a function twice", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\nbelem 1 1 1\n0\n1 1 1 2\n",
       "Line 5: the functions of element 0 sum to 2", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\nbelem 1 1 1\n0\n1 1 1\n", "the end of the file",
       TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\n", "1 of 1 nodes and 0 of 1 elements",
       TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\n7\n", "found '7'", TSOLID_ERROR_INPUT},
      {"type plane\nnodeN 1\nelemN 1\nnode 0 0 0 1\nsets\n", "found 'sets'", TSOLID_ERROR_INPUT},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    write_text(cases[i].body);
    check_refused(cases[i].status, cases[i].text);
  }
  tsolid_surface *surface = NULL;
  CHECK(tsolid_read_iga(context, "/nonexistent/x.iga", &surface) == TSOLID_ERROR_IO);
  CHECK(tsolid_read_iga(context, NULL, &surface) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_read_iga(context, path, NULL) == TSOLID_ERROR_ARGUMENT);
}

/* ---- memory and mutations ---------------------------------------------------------------------
 */

/* Everything that a reader of unknown files does with one; returns the reader's status. */
static tsolid_status try_file(meter *m, size_t size) {
  tsolid_context *own = NULL;
  tsolid_context_options options = {
      .allocate = count_new, .release = count_delete, .allocator_data = m, .n_threads = 1};
  tsolid_surface *surface = NULL;
  if (tsolid_context_create(&options, &own))
    return TSOLID_ERROR_MEMORY;
  tsolid_status status = tsolid_read_iga(own, path, &surface);
  int n = tsolid_context_n_findings(own);
  CHECK(!surface == (status != TSOLID_OK));
  CHECK(status == TSOLID_OK || status == TSOLID_ERROR_INPUT || status == TSOLID_ERROR_REFUSED ||
        (status == TSOLID_ERROR_MEMORY && m->countdown < 0));
  if (status == TSOLID_ERROR_INPUT || status == TSOLID_ERROR_REFUSED)
    CHECK(n > 0 && tsolid_context_finding(own, n - 1)->status == status);
  if (size > 0)
    CHECK(m->peak < 100 * size + 65536);
  if (surface) {
    tsi_arena arena = tsi_arena_create(own);
    tsolid_requirement requirement;
    tsolid_bezier_boundary bezier;
    tsolid_boundary *boundary = NULL;
    tsolid_status cut = tsi_surface_to_sides(own, &arena, surface, &requirement, &bezier);
    CHECK(cut != TSOLID_ERROR_INTERNAL);
    tsolid_boundary_input input = {.bezier = &bezier};
    if (!cut)
      cut = tsolid_boundary_create(own, &input, NULL, NULL, &boundary);
    CHECK(cut != TSOLID_ERROR_INTERNAL && !boundary == (cut != TSOLID_OK));
    tsolid_boundary_free(boundary);
    tsi_arena_free(&arena);
  }
  tsolid_surface_free(surface);
  tsolid_context_free(own);
  CHECK(m->live == 0);
  return status;
}

static char *load(size_t *size) {
  FILE *file = fopen(path, "r");
  char *text = part_new(1 << 20, 1);
  *size = file ? fread(text, 1, (1 << 20) - 4096, file) : 0;
  if (file)
    fclose(file);
  return text;
}

static void store(const char *text, size_t size) {
  FILE *file = fopen(path, "w");
  if (!file || fwrite(text, 1, size, file) != size)
    abort();
  fclose(file);
}

static void make_sample(int raise) {
  struct tsolid_surface made;
  do
    make_box(1);
  while (mesh.n > 30);
  surface_part_build(&mesh, 1, &seed, &made);
  write_surface(&made, raise);
  surface_part_free(&made);
}

static void test_every_allocation_fails(void) {
  int n_memory = 0;
  make_sample(1);
  for (long at = 0; at < 1000; at++) {
    meter m = {.limit = (size_t)1 << 30, .countdown = at};
    tsolid_status status = try_file(&m, 0);
    n_memory += status == TSOLID_ERROR_MEMORY;
    if (m.countdown >= 0)
      break; /* never reached: all went well */
  }
  CHECK(n_memory > 20);
}

static void test_mutations(int count) {
  static const char *const words[] = {"belem", "node", "-1", "0", "1e300",      "nan",   "4",
                                      "0.5",   "#",    "\n", "3", "2147483648", "domain"};
  int n_read = 0;
  for (int round = 0; round < count; round++) {
    if (round % 50 == 0)
      make_sample(round % 100 ? 1 : 0);
    size_t size;
    static char *text, kept[1 << 20];
    static size_t kept_size;
    text = load(&size);
    if (round % 50 == 0) {
      memcpy(kept, text, size);
      kept_size = size;
    }
    memcpy(text, kept, kept_size);
    size = kept_size;
    for (int n = 1 + (int)(surface_random(&seed) % 2); n > 0; n--) {
      size_t at = (size_t)surface_random(&seed) % size, kind = (size_t)surface_random(&seed) % 5;
      if (kind == 0) {
        text[at] = (char)surface_random(&seed);
      } else if (kind == 1) {
        size = at + 1;
      } else if (kind == 2) { /* a digit */
        while (at + 1 < size && (text[at] < '0' || text[at] > '9'))
          at++;
        text[at] = (char)('0' + surface_random(&seed) % 10);
      } else { /* a word */
        while (at > 0 && text[at] != ' ' && text[at] != '\n')
          at--;
        const char *word = words[(size_t)surface_random(&seed) % (sizeof words / sizeof *words)];
        size_t end = at + 1, length = strlen(word);
        while (end < size && text[end] != ' ' && text[end] != '\n')
          end++;
        memmove(text + at + 1 + length, text + end, size - end);
        memcpy(text + at + 1, word, length);
        size = at + 1 + length + size - end;
      }
    }
    store(text, size);
    free(text);
    meter m = {.limit = (size_t)1 << 30, .countdown = -1};
    n_read += try_file(&m, size) == TSOLID_OK;
  }
  CHECK(n_read > 0 && n_read < count);
}

/* Many records: time near linear, memory bounded. */
static void test_many(int n) {
  FILE *file = open_file((n + 1) * (n + 1), n * n);
  for (int i = 0; i < (n + 1) * (n + 1); i++)
    fprintf(file, "node %d %d 0 1\n", i % (n + 1), i / (n + 1));
  for (int i = 0; i < n * n; i++) {
    int a = i % n + (n + 1) * (i / n);
    fprintf(file, "belem 4 1 1\n%d %d %d %d\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", a, a + 1,
            a + n + 1, a + n + 2);
  }
  long size = ftell(file);
  fclose(file);
  meter m = {.limit = (size_t)1 << 30, .countdown = -1};
  CHECK(try_file(&m, (size_t)size) == TSOLID_OK);
  printf("# %d elements: %ld bytes, peak %zu\n", n * n, size, m.peak);
}

/* ---- real files -------------------------------------------------------------------------------
 */

static void test_samples(void) {
  static const char *const name[] = {"square_structured.iga", "square_unstructured.iga"};
  const char *source = getenv("TSOLID_SOURCE_DIR");
  for (int i = 0; i < 2; i++) {
    char sample[512];
    snprintf(sample, sizeof sample, "%s/../shared/data/%s", source ? source : ".", name[i]);
    if (access(sample, R_OK)) {
      printf("# skipped: no %s\n", sample);
      continue;
    }
    tsolid_surface *surface = NULL;
    tsolid_boundary *boundary;
    tsolid_surface_view view;
    tsolid_context_clear(context);
    if (!CHECK(tsolid_read_iga(context, sample, &surface) == TSOLID_OK)) {
      print_findings();
      continue;
    }
    tsolid_surface_get(surface, &view);
    CHECK(view.n_faces == (i ? 112 : 4) && view.n_t_junctions == 0);
    CHECK(view.n_vertices - view.n_edges + view.n_faces == 1);
    CHECK(view.n_extraordinary == (i ? 2 : 0));
    CHECK_NEAR(view.sum_defect, i ? 1.0 / 192.0 : 0.0, 1e-12);
    CHECK(has_finding("no knot intervals"));
    CHECK(!i == !has_finding("raised to degree 4"));
    /* the unit square: its area by Gauss points, and its interval widths, which are all equal */
    double area = 0.0;
    static const double gauss[] = {0.069431844202973713, 0.33000947820757187, 0.66999052179242813,
                                   0.93056815579702629};
    static const double weight[] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                    0.17392742256872693};
    for (int f = 0; f < view.n_faces; f++) {
      const double *size = view.face_size + 2 * f;
      CHECK_NEAR(size[0], 1.0, 0.0);
      CHECK_NEAR(size[1], 1.0, 0.0);
      for (int j = 0; j < 16; j++) {
        double x[9];
        CHECK(tsolid_surface_evaluate(context, surface, f, gauss[j % 4], gauss[j / 4], 1, x) ==
              TSOLID_OK);
        area += weight[j % 4] * weight[j / 4] * (x[3] * x[7] - x[4] * x[6]);
      }
    }
    CHECK_NEAR(area, 1.0, i ? 1e-7 : 1e-14); /* rational where the sum is not 1 */
    printf("# %s: area %.9f\n", name[i], area);
    CHECK(to_boundary(surface, &boundary) == TSOLID_ERROR_REFUSED && !boundary);
    CHECK(has_finding("open: 1 boundary loop"));
    tsolid_surface_free(surface);
  }
}

int main(int argc, char **argv) {
  char folder[64];
  const char *base = getenv("TMPDIR");
  snprintf(folder, sizeof folder, "%.40s/tsolid.XXXXXX", base ? base : "/tmp");
  if (!CHECK(mkdtemp(folder) != NULL) || !CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK))
    return check_done();
  snprintf(path, sizeof path, "%s/x.iga", folder);
  test_boxes();
  test_interleaved();
  test_no_surfaces();
  test_malformed();
  test_every_allocation_fails();
  test_mutations(argc > 1 ? atoi(argv[1]) : 400);
  test_many(argc > 2 ? atoi(argv[2]) : 60);
  test_samples();
  tsolid_context_free(context);
  unlink(path);
  rmdir(folder);
  return check_done();
}
