/* SPDX-License-Identifier: LGPL-2.1-or-later
 * One mesh of an assembly: parts share all nodes of their contacts and only those, no face is left
 * half between two parts, the volume is the parts', and what cannot be done is refused by name. */
#include "check.h"

#include "assembly_parts.h"
#include "counted_memory.h"
#include "hex_assembly.h"
#include "hex_checks.h"

static scene s;

typedef struct built {
  tsolid_assembly *joined;
  const tsolid_solid *solid[MOST_PARTS];
  tsolid_assembly_view view;
} built;

static built b;

static void show_findings(tsolid_context *context) {
  for (int k = 0; k < tsolid_context_n_findings(context); k++)
    fprintf(stderr, "  %s\n", tsolid_context_finding(context, k)->text);
}

static tsolid_solid *build_part(tsolid_context *context, const tsolid_assembly *assembly, int k) {
  const tsolid_boundary_input *input = tsolid_assembly_boundary_input(assembly, k);
  tsolid_boundary *boundary = NULL;
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_solid *solid = NULL;
  CHECK(input && tsolid_boundary_create(context, input, NULL, NULL, &boundary) == TSOLID_OK &&
        tsolid_tmesh_create(context, boundary, NULL, &tmesh) == TSOLID_OK &&
        tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK &&
        tsolid_solid_create(context, space, &solid) == TSOLID_OK);
  tsolid_space_free(space);
  tsolid_tmesh_free(tmesh);
  tsolid_boundary_free(boundary);
  return solid;
}

/* Solids of the scene's parts, joined. */
static void build(tsolid_context *context) {
  tsolid_assembly *assembly = NULL;
  CHECK(tsolid_assembly_create(context, &s.input, NULL, &assembly) == TSOLID_OK);
  tsolid_assembly_get(assembly, &b.view);
  for (int k = 0; k < b.view.n_parts; k++) {
    int first = b.view.part[k].copy_of;
    b.solid[k] = first == k ? build_part(context, assembly, k) : b.solid[first];
  }
  CHECK(tsolid_assembly_join(context, assembly, b.view.n_parts, b.solid, &b.joined) == TSOLID_OK);
  tsolid_assembly_get(b.joined, &b.view);
  tsolid_assembly_free(assembly);
}

static void release(void) {
  for (int k = 0; k < b.view.n_parts; k++)
    if (b.view.part[k].copy_of == k)
      tsolid_solid_free((tsolid_solid *)(size_t)b.solid[k]);
  tsolid_assembly_free(b.joined);
  scene_free(&s);
}

static tsolid_hex *mesh(tsolid_context *context, const tsolid_hex_part *own,
                        const tsolid_hex_options *options, tsolid_hex_view *v) {
  tsolid_hex *hex = NULL;
  if (!CHECK(tsolid_hex_assembly_create(context, b.joined, b.view.n_parts, b.solid, own, options,
                                        &hex) == TSOLID_OK))
    show_findings(context);
  if (hex)
    tsolid_hex_get(hex, v);
  return hex;
}

/* ---- what holds --------------------------------------------------------------------------------
 */

static int compare_x(const void *p, const void *q) {
  const double *x = *(const double *const *)p, *y = *(const double *const *)q;
  return (x[0] > y[0]) - (x[0] < y[0]);
}

/* Pairs of nodes nearer than 1e-7, by coordinates alone. */
static long count_twins(const tsolid_hex_view *v) {
  const double **at = malloc((size_t)v->n_nodes * sizeof *at);
  long n = 0;
  for (int k = 0; k < v->n_nodes; k++)
    at[k] = v->nodes + 3 * (size_t)k;
  qsort((void *)at, (size_t)v->n_nodes, sizeof *at, compare_x);
  for (int i = 0; i < v->n_nodes; i++)
    for (int j = i + 1; j < v->n_nodes && at[j][0] < at[i][0] + 1e-7; j++)
      n += fabs(at[j][1] - at[i][1]) < 1e-7 && fabs(at[j][2] - at[i][2]) < 1e-7;
  free((void *)at);
  return n;
}

static int part_of(const tsolid_hex_view *v, int element) {
  int p = 0;
  while (element >= v->part_start[p + 1])
    p++;
  return p;
}

/* Names of regions: the part's own before the underscore; and a contact's two parts. */
static void check_names(const tsolid_hex_view *v) {
  for (int r = 0; r < v->n_regions; r++) {
    CHECK(v->region_start[r + 1] > v->region_start[r]);
    for (int k = v->region_start[r]; k < v->region_start[r + 1]; k++) {
      const char *own = v->part_name[part_of(v, v->region_face[2 * k])], *name = v->region_name[r];
      name += is_contact(v, r) ? 8 : 0;
      CHECK(strncmp(name, own, strlen(own)) == 0 && name[strlen(own)] == '_');
    }
  }
}

/* A bonded assembly; the volume's error is at most `error` of it. Returns the volume. */
static double check_whole(tsolid_context *context, const tsolid_hex_options *options,
                          double error) {
  tsolid_hex_view v;
  int n_findings = tsolid_context_n_findings(context);
  tsolid_hex *hex = mesh(context, NULL, options, &v);
  double volume = NAN;
  if (hex) {
    CHECK(tsolid_context_n_findings(context) == n_findings);
    CHECK(v.n_parts == b.view.n_parts && v.part_start[v.n_parts] == v.n_elements && v.proved);
    CHECK(v.worst > 0.0 && v.n_shared > 0);
    check_topology(&v);
    check_names(&v);
    CHECK(count_twins(&v) == 0);
    volume = mesh_volume(&v);
    CHECK_NEAR(volume, b.view.volume, error * b.view.volume);
  }
  tsolid_hex_free(hex);
  return volume;
}

/* ---- assemblies --------------------------------------------------------------------------------
 */

static void check_orientations(tsolid_context *context) {
  for (int code = 0; code < 8; code++) {
    block x = plain_block(0, 0, 0, 0.07, 3, 2), y = plain_block(1, 0, 0, 0.07, 3, 2);
    part second = make_block(&y);
    scene_add_block(&s, &x);
    scene_add(&s, turn_part(&second, code));
    part_free(&second);
    build(context);
    for (int order = 1; order <= 2; order++) {
      tsolid_hex_options options = {.order = order, .size = 0.3};
      check_whole(context, &options, order == 1 ? 1e-2 : 1e-4);
    }
    release();
  }
}

/* Eight blocks around a hole, and a T of seven. */
static void check_blocks(tsolid_context *context) {
  static const int place[2][8][2] = {
      {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}},
      {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {2, 1}, {2, 2}, {0, 0}}};
  for (int shape = 0; shape < 2; shape++) {
    for (int k = 0; k < 8 - shape; k++) {
      block x = plain_block(place[shape][k][0], place[shape][k][1], 0, 0.06, 3, 1);
      x.rational = shape;
      part own = make_block(&x);
      scene_add(&s, turn_part(&own, k));
      part_free(&own);
    }
    build(context);
    tsolid_hex_options options = {.order = 2, .size = 0.5, .grading = 0.5};
    check_whole(context, &options, 1e-3);
    release();
  }
}

/* Bricks that cover parts of each other, and edges where up to five of them meet. */
static void check_walls(tsolid_context *context) {
  static const double shift[3][2] = {{0.5, 0.0}, {0.5, 0.25}, {1.0 / 3, 0.0}};
  for (int kind = 0; kind < 3; kind++) {
    int n = kind == 0 ? 4 : 2;
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < (kind ? 2 : 3); j++)
        for (int i = 0; i < n; i++) {
          block x = plain_block(i + (k & 1) * shift[kind][0], j + (k & 1) * shift[kind][1], k, 0.0,
                                1 + kind % 2, 0);
          part own = make_block(&x);
          scene_add(&s, turn_part(&own, (i + 3 * j + 5 * k) % 8));
          part_free(&own);
        }
    build(context);
    for (int order = 1; order <= 2; order++) {
      tsolid_hex_options options = {.order = order, .size = 0.6};
      check_whole(context, &options, 1e-12);
    }
    release();
  }
}

/* Other knots and degrees on both sides: the same surface after exact refinement. */
static void check_other_functions(tsolid_context *context) {
  for (int kind = 0; kind < 2; kind++) {
    block x = plain_block(0, 0, 0, 0.0, 3, 2), y = plain_block(1, 0, 0, 0.0, 2, 1);
    for (int d = 0; d < 3; d++)
      y.axis[d] = plain_axis(d + 1, kind ? 2 - d : d);
    scene_add_block(&s, &x);
    scene_add_block(&s, &y);
    build(context);
    tsolid_hex_options options = {.order = 2, .size = 0.3};
    check_whole(context, &options, 1e-12);
    release();
  }
}

/* One part in six places, each turned about z by a right angle more. */
static void check_copies(tsolid_context *context) {
  static double placement[6][12];
  block x = plain_block(0, 0, 0, 0.0, 2, 1);
  scene_add_block(&s, &x);
  for (int k = 0; k < 6; k++) {
    static const int cosine[4] = {1, 0, -1, 0}, sine[4] = {0, 1, 0, -1};
    int c = cosine[k % 4], n = sine[k % 4];
    double m[12] = {c, -n, 0, 100.1 + k - 0.5 * c + 0.5 * n, n, c, 0, -0.5 * n - 0.5 * c, 0,
                    0, 1,  0};
    memcpy(placement[k], m, sizeof m);
    s.member[k] = s.member[0];
    s.member[k].placement = placement[k];
    s.member[k].name = "cube";
  }
  s.input.n_parts = 6;
  build(context);
  tsolid_hex_options options = {.order = 2, .size = 0.4};
  check_whole(context, &options, 1e-12);
  tsolid_hex_view v;
  tsolid_hex *hex = mesh(context, NULL, &options, &v);
  if (hex) {
    CHECK(strcmp(v.part_name[0], "cube") == 0 && strcmp(v.part_name[5], "cube_6") == 0);
    double least = INFINITY, most = -INFINITY;
    for (int k = 0; k < v.n_nodes; k++) {
      least = fmin(least, v.nodes[3 * k]);
      most = fmax(most, v.nodes[3 * k]);
    }
    CHECK_NEAR(least, 99.6, 1e-12);
    CHECK_NEAR(most, 105.6, 1e-12);
  }
  tsolid_hex_free(hex);
  release();
}

/* A gap: nodes of their own, a warning, and everything else as before. */
static void check_open(tsolid_context *context) {
  double by[3] = {1e-3, 0, 0};
  block x = plain_block(0, 0, 0, 0.0, 2, 1), y = plain_block(1, 0, 0, 0.0, 2, 1);
  part second = make_block(&y);
  shift_part(&second, by);
  scene_add_block(&s, &x);
  scene_add(&s, second);
  build(context);
  tsolid_hex_view v;
  int n = tsolid_context_n_findings(context);
  tsolid_hex_options options = {.size = 0.5};
  tsolid_hex *hex = mesh(context, NULL, &options, &v);
  CHECK(hex && v.n_shared == 0 && tsolid_context_n_findings(context) == n + 1);
  if (hex) {
    check_topology(&v);
    CHECK_NEAR(mesh_volume(&v), 2.0, 1e-12);
  }
  tsolid_hex_free(hex);
  release();
}

/* ---- divisions ---------------------------------------------------------------------------------
 */

static void expect_refusal(tsolid_context *context, const tsolid_hex_part *own,
                           const tsolid_hex_options *options, const char *first,
                           const char *second) {
  tsolid_hex *hex = NULL;
  tsolid_context_clear(context);
  CHECK(tsolid_hex_assembly_create(context, b.joined, b.view.n_parts, b.solid, own, options,
                                   &hex) == TSOLID_ERROR_REFUSED);
  CHECK(hex == NULL);
  if (CHECK(tsolid_context_n_findings(context) == 1)) {
    const char *text = tsolid_context_finding(context, 0)->text;
    CHECK(strstr(text, first) && strstr(text, second));
  }
}

/* The axis of the part's own cube that lies along the block's axis d. */
static int axis_of(int k, int d) {
  tsolid_placement place;
  const tsolid_boundary *boundary = tsolid_space_boundary(tsolid_solid_space(b.solid[k]));
  CHECK(tsolid_boundary_placement(boundary, 2 * d, 0, &place) == TSOLID_OK);
  return place.side / 2;
}

static void tell_divisions(tsolid_hex_part *own, int k, int x, int y, int z, int layers) {
  own[k].divisions[axis_of(k, 0)] = x;
  own[k].divisions[axis_of(k, 1)] = y;
  own[k].divisions[axis_of(k, 2)] = z;
  own[k].divisions[3] = layers;
}

/* Two in a row along x: what one is told across it the other has. */
static void check_divisions(tsolid_context *context) {
  block x = plain_block(0, 0, 0, 0.0, 2, 1), y = plain_block(1, 0, 0, 0.0, 2, 1);
  scene_add_block(&s, &x);
  scene_add_block(&s, &y);
  s.member[0].name = "left";
  s.member[1].name = "right";
  build(context);
  tsolid_hex_options options = {.size = 0.5};
  tsolid_hex_part own[2] = {{.n_regions = 0}};
  tell_divisions(own, 0, 3, 5, 0, 2);
  tell_divisions(own, 1, 4, 5, 7, 1);
  tsolid_hex_view v;
  tsolid_hex *hex = mesh(context, own, &options, &v);
  if (hex) { /* cells: the core and its six arms */
    CHECK(v.part_start[1] == 3 * 5 * 7 + 2 * 2 * (3 * 5 + 5 * 7 + 7 * 3));
    CHECK(v.n_elements - v.part_start[1] == 4 * 5 * 7 + 2 * (4 * 5 + 5 * 7 + 7 * 4));
    CHECK(v.n_shared == 6 * 8);
    check_topology(&v);
  }
  tsolid_hex_free(hex);
  own[1].divisions[axis_of(1, 1)] = 6;
  expect_refusal(context, own, &options, "left", "right");
  own[1].divisions[axis_of(1, 1)] = 2000000000;
  expect_refusal(context, own, &options, "right", "too many");
  own[1].divisions[axis_of(1, 1)] = 0;
  options.max_elements = 50;
  expect_refusal(context, own, &options, "elements", "larger size");
  options.max_elements = 0;
  const tsolid_solid *kept = b.solid[1];
  b.solid[1] = NULL;
  expect_refusal(context, own, &options, "no solid", "right");
  b.solid[1] = kept;
  own[0].n_regions = -1;
  tsolid_hex *none = NULL;
  CHECK(tsolid_hex_assembly_create(context, b.joined, 2, b.solid, own, &options, &none) ==
        TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_hex_assembly_create(context, b.joined, 1, b.solid, NULL, &options, &none) ==
        TSOLID_ERROR_ARGUMENT);
  CHECK(none == NULL);
  release();
}

/* Bricks on a long one: its divisions are those of the bricks together. */
static void check_sums(tsolid_context *context) {
  block x = plain_block(0, 0, 0, 0.0, 1, 0), y = plain_block(0, 0, 1, 0.0, 1, 0),
        z = plain_block(1, 0, 1, 0.0, 1, 0);
  x.high[0] = 2.0;
  scene_add_block(&s, &x);
  scene_add_block(&s, &y);
  scene_add_block(&s, &z);
  s.member[0].name = "base";
  s.member[1].name = "small";
  s.member[2].name = "other";
  build(context);
  tsolid_hex_options options = {.size = 0.5};
  tsolid_hex_part own[3] = {{.n_regions = 0}};
  tell_divisions(own, 0, 9, 2, 2, 1);
  tell_divisions(own, 1, 0, 0, 2, 1);
  tell_divisions(own, 2, 4, 0, 2, 1);
  tsolid_hex_view v;
  tsolid_hex *hex = mesh(context, own, &options, &v);
  if (hex) { /* 5 + 4 */
    CHECK(v.part_start[2] - v.part_start[1] == 5 * 2 * 2 + 2 * (10 + 4 + 10));
    CHECK(v.n_shared == 6 * 3 + 5 * 3 + 2 * 3);
    check_topology(&v);
    CHECK(count_twins(&v) == 0);
  }
  tsolid_hex_free(hex);
  own[1].divisions[axis_of(1, 0)] = 6;
  expect_refusal(context, own, &options, "base", "Divisions contradict");
  release();
}

/* Bonds that no parts could have: lines that return to ever new places, or to ever nearer ones. */
static void check_endless(tsolid_context *context) {
  block x = plain_block(0, 0, 0, 0.0, 1, 0), y = plain_block(1, 0, 0, 0.0, 1, 0);
  scene_add_block(&s, &x);
  scene_add_block(&s, &y);
  build(context);
  const double g = 0.6180339887498949;
  tsi_hex_member member[2] = {{.name = "one", .solid = b.solid[0], .options = {.size = 0.5}},
                              {.name = "two", .solid = b.solid[1], .options = {.size = 0.5}}};
  tsi_bond straight = {.part = {0, 1}, .axis = {{1, 2}, {1, 2}}, .to = {{1, 1}, {1, 1}}};
  tsi_bond turned[3] = {straight, straight, straight}, tapered[2] = {straight, straight};
  turned[1].to[0][0] = turned[2].from[0][0] = 1.0 - g;
  turned[1].from[1][0] = turned[2].to[1][0] = g;
  turned[2].to[0][0] = 1.0;
  turned[2].from[1][0] = 0.0;
  tapered[1].from[1][0] = 0.1;
  tapered[1].to[1][0] = 0.6;
  for (int kind = 0; kind < 3; kind++) {
    tsi_arena arena = tsi_arena_create(context);
    tsolid_context_clear(context);
    tsolid_status status = tsi_hex_assembly_lines(
        context, &arena, 2, member, kind == 2 ? 1 : 3 - kind, kind == 0 ? turned : tapered);
    CHECK(status == (kind == 2 ? TSOLID_OK : TSOLID_ERROR_REFUSED));
    if (kind < 2 && CHECK(tsolid_context_n_findings(context) == 1))
      CHECK(strstr(tsolid_context_finding(context, 0)->text, kind ? "apart" : "without end"));
    tsi_arena_free(&arena);
  }
  /* turned about: the lines of both are symmetric, and the same */
  tsi_bond back[2] = {straight, straight};
  back[1].from[1][0] = 1.0;
  back[1].to[1][0] = 0.0;
  tsi_arena arena = tsi_arena_create(context);
  CHECK(tsi_hex_assembly_lines(context, &arena, 2, member, 2, back) == TSOLID_OK);
  for (int k = 0; k <= member[0].lines.n[1]; k++) {
    CHECK(member[0].lines.x[1][k] == member[1].lines.x[1][k]);
    CHECK_NEAR(member[0].lines.x[1][k] + member[0].lines.x[1][member[0].lines.n[1] - k], 1.0,
               1e-15);
  }
  tsi_arena_free(&arena);
  release();
}

/* Every allocation fails once; and the bits are the same with three threads. */
static void check_memory(void) {
  meter m = {.limit = (size_t)1 << 40, .countdown = -1};
  tsolid_context *context = new_counted_context(&m);
  block x = plain_block(0, 0, 0, 0.05, 1, 0), y = plain_block(1, 0, 0, 0.05, 1, 0);
  scene_add_block(&s, &x);
  scene_add_block(&s, &y);
  build(context);
  tsolid_hex_options options = {.order = 2, .size = 1.0};
  tsolid_hex *hex = NULL;
  int failures = 0, done = 0;
  size_t before = 0;
  for (long k = 0; !done && k < 20000; k++) {
    m.countdown = k;
    tsolid_status status =
        tsolid_hex_assembly_create(context, b.joined, 2, b.solid, NULL, &options, &hex);
    m.countdown = -1;
    tsolid_context_clear(context);
    done = status == TSOLID_OK;
    failures += !done;
    if (k == 0) /* the list of findings stays */
      before = m.live;
    if (!done && !CHECK(status == TSOLID_ERROR_MEMORY && hex == NULL && m.live <= before)) {
      printf("allocation %ld: status %d, %zu bytes live, %zu before\n", k, status, m.live, before);
      break;
    }
  }
  CHECK(failures > 50);
  if (!CHECK(done)) {
    release();
    tsolid_context_free(context);
    return;
  }
  tsolid_hex_view v, w;
  tsolid_hex_get(hex, &v);
  tsolid_context *three = NULL;
  tsolid_hex *other = NULL;
  tsolid_context_options with = {.n_threads = 3};
  CHECK(tsolid_context_create(&with, &three) == TSOLID_OK);
  CHECK(tsolid_hex_assembly_create(three, b.joined, 2, b.solid, NULL, &options, &other) ==
        TSOLID_OK);
  tsolid_hex_get(other, &w);
  CHECK(v.n_nodes == w.n_nodes &&
        memcmp(v.nodes, w.nodes, 3 * (size_t)v.n_nodes * sizeof *v.nodes) == 0);
  tsolid_hex_free(other);
  tsolid_hex_free(hex);
  tsolid_context_free(three);
  release();
  tsolid_context_free(context);
}

int main(void) {
  tsolid_context *context = NULL;
  tsolid_context_options options = {.n_threads = 1};
  CHECK(tsolid_context_create(&options, &context) == TSOLID_OK);
  check_orientations(context);
  check_blocks(context);
  check_walls(context);
  check_other_functions(context);
  check_copies(context);
  check_open(context);
  check_divisions(context);
  check_sums(context);
  check_endless(context);
  tsolid_context_free(context);
  check_memory();
  return check_done();
}
