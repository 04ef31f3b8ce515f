/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Contacts of several parts: what is the same surface, what is apart and by how much, what
 * overlaps. Every verdict also of the same parts given otherwise. */
#include "check.h"

#include <time.h>

#include "assembly_parts.h"
#include "counted_memory.h"
#include "patch.h"

static scene s;

static void show_findings(tsolid_context *context) {
  for (int k = 0; k < tsolid_context_n_findings(context); k++)
    fprintf(stderr, "  %s\n", tsolid_context_finding(context, k)->text);
}

static tsolid_assembly *match(tsolid_context *context, double gap, tsolid_assembly_view *view) {
  tsolid_assembly *assembly = NULL;
  tsolid_assembly_options options = {.gap = gap};
  if (!CHECK(tsolid_assembly_create(context, &s.input, &options, &assembly) == TSOLID_OK))
    show_findings(context);
  if (assembly)
    tsolid_assembly_get(assembly, view);
  return assembly;
}

/* Both sides of the contact at equal (s,t): a map of its own. */
static double check_map(const tsolid_interface *c) {
  double worst = 0.0;
  for (int i = 0; i < 25; i++) {
    double st[2] = {(i % 5) / 4.0, (i / 5) / 4.0}, x[2][3];
    for (int side = 0; side < 2; side++) {
      const tsolid_patch *patch = &s.part[c->part[side]].patch[c->patch[side]];
      double p[2] = {st[0], st[1]};
      if (side && c->code & 4) {
        p[0] = st[1];
        p[1] = st[0];
      }
      for (int d = 0; d < 2; d++) {
        const double *knot = patch->knots[d];
        double low = knot[0], high = knot[patch->n_control[d] + patch->degree[d]],
               m = c->moebius[d];
        if (side && c->code >> d & 1)
          p[d] = 1.0 - p[d];
        if (side)
          p[d] = m * p[d] / (m * p[d] + 1.0 - p[d]);
        p[d] = c->box[side][2 * d] + p[d] * (c->box[side][2 * d + 1] - c->box[side][2 * d]);
        p[d] = low + p[d] * (high - low);
      }
      evaluate_patch(patch, p[0], p[1], x[side]);
    }
    worst = fmax(worst, hypot(hypot(x[0][0] - x[1][0], x[0][1] - x[1][1]), x[0][2] - x[1][2]));
  }
  return worst;
}

/* Two cubes that share one wavy face, the second in each orientation. */
static void check_orientations(tsolid_context *context, int rational) {
  for (int code = 0; code < 8; code++) {
    tsolid_assembly_view view;
    block a = plain_block(0, 0, 0, 0.07, 3, 2), b = plain_block(1, 0, 0, 0.07, 3, 2);
    a.rational = b.rational = rational;
    part second = make_block(&b);
    scene_add_block(&s, &a);
    scene_add(&s, turn_part(&second, code));
    tsolid_assembly *assembly = match(context, 0.0, &view);
    CHECK(view.n_interfaces == 1 && view.n_clashes == 0);
    if (view.n_interfaces == 1) {
      const tsolid_interface *c = view.interface;
      CHECK(c->kind == TSOLID_CONTACT_EXACT);
      CHECK(c->part[0] == 0 && c->part[1] == 1 && c->patch[0] == 1 && c->patch[1] == 0);
      CHECK(c->deviation == 0.0 && !c->same_side);
      CHECK(check_map(c) < 1e-14);
    }
    CHECK(view.verdict == TSOLID_ASSEMBLY_WATERTIGHT && view.n_free == 10);
    CHECK_NEAR(view.volume_inside, view.volume, 1e-12 * view.volume);
    tsolid_assembly_free(assembly);
    part_free(&second);
    scene_free(&s);
  }
}

/* Given otherwise: shuffled, knots in another range, moved and moved back. */
static void rewrite(scene *scene_, int k) {
  int order[64];
  double there[3] = {0.3, -7.1, 1.9}, back[3] = {-0.3, 7.1, -1.9};
  part *p = &scene_->part[k], other = shuffle_part(p, order);
  part_free(p);
  *p = other;
  shift_part(p, there);
  shift_part(p, back);
  rescale_knots(p, 3.0, 0.7 + 0.1 * k);
  scene_->boundary[k].patches = p->patch;
}

static void check_kinds(tsolid_context *context) {
  for (int again = 0; again < 2; again++) {
    tsolid_assembly_view view;
    block a = plain_block(0, 0, 0, 0.0, 2, 1), b = plain_block(1, 0, 0, 0.0, 3, 2);
    for (int d = 0; d < 3; d++) /* planar and linear: the same surface by other functions */
      b.axis[d] = plain_axis(d + 1, d);
    scene_add_block(&s, &a);
    scene_add_block(&s, &b);
    for (int k = 0; again && k < 2; k++)
      rewrite(&s, k);
    tsolid_assembly *assembly = match(context, 0.0, &view);
    CHECK(view.n_interfaces == 1 && view.n_of_kind[TSOLID_CONTACT_GEOMETRIC] == 1);
    CHECK(view.n_interfaces == 1 && view.interface[0].deviation < 1e-14 &&
          check_map(view.interface) < 1e-14);
    CHECK(view.verdict == TSOLID_ASSEMBLY_WATERTIGHT && view.n_clashes == 0);
    tsolid_assembly_free(assembly);
    scene_free(&s);
  }
}

/* A gap along x of this size is declared within one per cent. */
static void check_gaps(tsolid_context *context) {
  static const double gap[] = {1e-6, 1e-3, 1e-2};
  for (int k = 0; k < 3; k++)
    for (int wavy = 0; wavy < 2; wavy++)
      for (int again = 0; again < 2; again++) {
        tsolid_assembly_view view;
        double by[3] = {gap[k], 0, 0};
        block a = plain_block(0, 0, 0, 0.03 * wavy, 3, 2),
              b = plain_block(1, 0, 0, 0.03 * wavy, 3, 2);
        part second = make_block(&b);
        shift_part(&second, by);
        scene_add_block(&s, &a);
        scene_add(&s, second);
        for (int m = 0; again && m < 2; m++)
          rewrite(&s, m);
        tsolid_assembly *assembly = match(context, 0.0, &view);
        CHECK(view.n_of_kind[TSOLID_CONTACT_NEAR] == 1 && view.n_clashes == 0);
        if (CHECK(view.n_interfaces == 1)) {
          CHECK_NEAR(view.interface[0].gap, gap[k], 0.01 * gap[k]);
          CHECK(view.interface[0].smallest_gap <= gap[k] * (1.0 + 1e-6));
          if (!wavy)
            CHECK_NEAR(view.interface[0].smallest_gap, gap[k], 1e-6 * gap[k]);
        }
        CHECK(view.verdict == TSOLID_ASSEMBLY_GAPS);
        tsolid_assembly_free(assembly);
        scene_free(&s);
      }
}

/* Turned about the common edge: the far edge is apart by 2 sin(angle/2) in space. */
static void check_rotated(tsolid_context *context) {
  const double angle = 0.1 * 3.14159265358979323846 / 180.0, hinge[2] = {1.0, 0.0};
  for (int opened = 0; opened < 2; opened++) {
    tsolid_assembly_view view;
    block a = plain_block(0, 0, 0, 0.0, 2, 1), b = plain_block(1, 0, 0, 0.0, 2, 1);
    part second = make_block(&b);
    rotate_part(&second, hinge, opened ? -angle : angle);
    scene_add_block(&s, &a);
    scene_add(&s, second);
    tsolid_assembly *assembly = match(context, 0.0, &view);
    if (opened) {
      CHECK(view.n_interfaces == 1 && view.interface[0].kind == TSOLID_CONTACT_NEAR);
      CHECK(view.n_interfaces == 1 && view.interface[0].smallest_gap < 1e-9);
      if (view.n_interfaces == 1)
        CHECK_NEAR(view.interface[0].gap, sin(angle), 0.01 * sin(angle));
      CHECK(view.n_clashes == 0 && view.verdict == TSOLID_ASSEMBLY_GAPS);
    } else {
      CHECK(view.n_clashes == 1 && view.verdict == TSOLID_ASSEMBLY_CLASHES);
      if (view.n_clashes == 1)
        CHECK(view.clash[0].depth > 0.5 * sin(angle) && view.clash[0].depth < 1.01 * sin(angle));
    }
    tsolid_assembly_free(assembly);
    scene_free(&s);
  }
}

static void expect_clash(tsolid_context *context, tsolid_clash_kind kind, int n) {
  tsolid_assembly_view view;
  tsolid_assembly *assembly = match(context, 0.0, &view);
  CHECK(view.n_clashes == n && view.verdict == TSOLID_ASSEMBLY_CLASHES);
  if (view.n_clashes >= 1)
    CHECK(view.clash[0].kind == kind);
  tsolid_assembly_free(assembly);
  scene_free(&s);
}

static void check_clashes(tsolid_context *context) {
  for (int wavy = 0; wavy < 2; wavy++) {
    double wave = 0.05 * wavy, shift[3] = {-0.2, 0.1, 0.3};
    block a = plain_block(0, 0, 0, wave, 3, 2), b = plain_block(1, 0, 0, wave, 3, 2);
    part second = make_block(&b);
    shift_part(&second, shift);
    scene_add_block(&s, &a);
    scene_add(&s, second);
    expect_clash(context, TSOLID_CLASH_OVERLAP, 1);
    block small = a;
    for (int d = 0; d < 3; d++) {
      small.low[d] = 0.3;
      small.high[d] = 0.6;
    }
    scene_add_block(&s, &small);
    scene_add_block(&s, &a);
    expect_clash(context, TSOLID_CLASH_INSIDE, 1);
    scene_add_block(&s, &a);
    scene_add_block(&s, &a);
    expect_clash(context, TSOLID_CLASH_TWICE, 1);
    scene_add_block(&s, &a);
    scene_add_block(&s, &a);
    rewrite(&s, 1);
    expect_clash(context, TSOLID_CLASH_TWICE, 1);
  }
  /* two bars across each other: no corner of one lies in the other */
  block a = plain_block(0, 0, 0, 0.0, 1, 0), b = a;
  a.high[0] = 5.0;
  b.low[0] = 2.0;
  b.high[0] = 3.0;
  b.low[1] = -2.0;
  b.high[1] = 3.0;
  b.low[2] = 0.25;
  b.high[2] = 0.75;
  scene_add_block(&s, &a);
  scene_add_block(&s, &b);
  expect_clash(context, TSOLID_CLASH_OVERLAP, 1);
}

/* Bricks 4 x 3 x 3, every second layer shifted by half a brick along x, every second row by a
 * quarter along y: contacts that cover parts of both. */
static void build_wall(int n_x, int n_y, int n_z, double shift_x, double shift_y, double wave,
                       int degree, int n_inner) {
  for (int k = 0; k < n_z; k++)
    for (int j = 0; j < n_y; j++)
      for (int i = 0; i < n_x; i++) {
        block b =
            plain_block(i + (k & 1) * shift_x, j + (k & 1) * shift_y, k, wave, degree, n_inner);
        scene_add_block(&s, &b);
      }
}

static double overlap(double a, double b) {
  return fmax(0.0, 1.0 - fabs(a - b));
}

/* How many pairs of bricks share an area, by their boxes. */
static int count_wall_contacts(int n_x, int n_y, int n_z, double shift_x, double shift_y,
                               int *n_partial) {
  int count = 0, n = n_x * n_y * n_z;
  *n_partial = 0;
  for (int a = 0; a < n; a++)
    for (int b = a + 1; b < n; b++) {
      int ka = a / (n_x * n_y), kb = b / (n_x * n_y);
      double ax = a % n_x + (ka & 1) * shift_x, bx = b % n_x + (kb & 1) * shift_x;
      double ay = a / n_x % n_y + (ka & 1) * shift_y, by = b / n_x % n_y + (kb & 1) * shift_y;
      double x = overlap(ax, bx), y = overlap(ay, by);
      int touch = ka == kb ? (fabs(fabs(ax - bx) - 1.0) < 1e-9 && ay == by) ||
                                 (fabs(fabs(ay - by) - 1.0) < 1e-9 && ax == bx)
                           : kb == ka + 1 && x > 0.0 && y > 0.0;
      count += touch;
      *n_partial += touch && ka != kb && (x < 1.0 || y < 1.0);
    }
  return count;
}

static void check_walls(tsolid_context *context) {
  static const double shift[][2] = {{0.5, 0.0}, {0.5, 0.25}, {1.0 / 3, 0.0}};
  for (int k = 0; k < 3; k++)
    for (int again = 0; again < 2; again++) {
      tsolid_assembly_view view;
      int n_partial, n = count_wall_contacts(4, 3, 3, shift[k][0], shift[k][1], &n_partial);
      build_wall(4, 3, 3, shift[k][0], shift[k][1], 0.0, 1 + k, k);
      for (int m = 0; again && m < s.n; m++)
        rewrite(&s, m);
      tsolid_assembly *assembly = match(context, 0.0, &view);
      CHECK(view.n_interfaces == n && view.n_of_kind[TSOLID_CONTACT_PARTIAL] == n_partial);
      CHECK(view.verdict == TSOLID_ASSEMBLY_WATERTIGHT && view.n_groups == 1);
      for (int i = 0; i < view.n_interfaces; i++)
        CHECK(check_map(&view.interface[i]) < 1e-12);
      CHECK_NEAR(view.volume, 36.0, 1e-12 * 36.0);
      CHECK_NEAR(view.volume_inside, 36.0, 1e-12 * 36.0);
      tsolid_assembly_free(assembly);
      scene_free(&s);
    }
}

/* Blocks in a row, a ring, a T: matched whole, in any order. */
static void check_blocks(tsolid_context *context) {
  static const int ring[][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0},
                                {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}};
  static const int tee[][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0},
                               {4, 0, 0}, {2, 1, 0}, {2, 2, 0}};
  for (int shape = 0; shape < 2; shape++)
    for (int again = 0; again < 2; again++) {
      tsolid_assembly_view view;
      int n = shape ? 7 : 8;
      for (int k = 0; k < n; k++) {
        const int *at = shape ? tee[again ? n - 1 - k : k] : ring[again ? n - 1 - k : k];
        block b = plain_block(at[0], at[1], at[2], 0.06, 3, 1);
        b.rational = shape;
        scene_add_block(&s, &b);
        if (again)
          rewrite(&s, k);
      }
      tsolid_assembly *assembly = match(context, 0.0, &view);
      CHECK(view.n_interfaces == (shape ? 6 : 8) && view.n_clashes == 0);
      CHECK(view.n_of_kind[TSOLID_CONTACT_EXACT] == view.n_interfaces);
      CHECK(view.verdict == TSOLID_ASSEMBLY_WATERTIGHT && view.n_groups == 1);
      CHECK_NEAR(view.volume_inside, view.volume, 1e-12 * view.volume);
      tsolid_assembly_free(assembly);
      scene_free(&s);
    }
}

/* Copies of one part in a 10 x 10 array: one input, a hundred places. */
static void check_copies(tsolid_context *context) {
  static double placement[100][12];
  tsolid_assembly_view view;
  block b = plain_block(0, 0, 0, 0.0, 2, 1);
  scene_add_block(&s, &b);
  for (int k = 1; k < 100; k++) {
    s.member[k] = s.member[0];
    for (int i = 0; i < 12; i++)
      placement[k][i] = i % 5 == 0;
    placement[k][3] = k % 10;
    placement[k][7] = k / 10;
    s.member[k].placement = placement[k];
  }
  s.input.n_parts = 100;
  tsolid_assembly *assembly = match(context, 0.0, &view);
  CHECK(view.n_interfaces == 180 && view.n_of_kind[TSOLID_CONTACT_EXACT] == 180);
  CHECK(view.n_clashes == 0 && view.n_groups == 1 && view.part[57].copy_of == 0);
  CHECK_NEAR(view.volume_inside, 100.0, 1e-10);
  tsolid_assembly_free(assembly);
  placement[3][0] = -1.0;
  CHECK(tsolid_assembly_create(context, &s.input, NULL, &assembly) == TSOLID_ERROR_INPUT);
  placement[3][0] = 25.4;
  CHECK(tsolid_assembly_create(context, &s.input, NULL, &assembly) == TSOLID_ERROR_INPUT);
  CHECK(assembly == NULL);
  scene_free(&s);
}

/* ---- construction ------------------------------------------------------------------------------
 */

/* The start over a part's prepared boundary. */
static tsolid_solid *build_part(tsolid_context *context, const tsolid_assembly *assembly, int k) {
  const tsolid_boundary_input *input = tsolid_assembly_boundary_input(assembly, k);
  tsolid_boundary *boundary = NULL;
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_solid *solid = NULL;
  CHECK(input != NULL);
  if (!CHECK(tsolid_boundary_create(context, input, NULL, NULL, &boundary) == TSOLID_OK &&
             tsolid_tmesh_create(context, boundary, NULL, &tmesh) == TSOLID_OK &&
             tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK &&
             tsolid_solid_create(context, space, &solid) == TSOLID_OK))
    show_findings(context);
  tsolid_space_free(space);
  tsolid_tmesh_free(tmesh);
  tsolid_boundary_free(boundary);
  return solid;
}

/* Builds all parts: every common contact has the same functions; in one frame the same bits. */
static void check_joined(tsolid_context *context, const tsolid_assembly *assembly, int one_frame,
                         double most_ulp) {
  static const tsolid_solid *solid[MOST_PARTS];
  tsolid_assembly *joined = NULL;
  tsolid_assembly_view view;
  tsolid_assembly_get(assembly, &view);
  for (int k = 0; k < view.n_parts; k++)
    solid[k] =
        view.part[k].copy_of == k ? build_part(context, assembly, k) : solid[view.part[k].copy_of];
  CHECK(tsolid_assembly_join(context, assembly, view.n_parts, solid, &joined) == TSOLID_OK);
  int n_functions = 0, n_bits = 0;
  for (int k = 0; joined && k < view.n_interfaces; k++) {
    tsolid_assembly_get(joined, &view);
    const tsolid_interface *c = &view.interface[k];
    n_functions += c->same_functions == 1;
    n_bits += c->same_bits == 1;
    if (one_frame)
      CHECK(c->gap_after == 0.0);
    CHECK(c->ulp_after <= most_ulp);
    for (int i = 0; i < 9; i++) { /* both sides' own parameters lead to the same bits */
      double s_t[2] = {(i % 3) * 0.375, (i / 3) * 0.25}, x[2][3];
      int done = 1;
      for (int side = 0; side < 2; side++) {
        double p[2] = {s_t[0], s_t[1]};
        if (side && c->code & 4) {
          p[0] = s_t[1];
          p[1] = s_t[0];
        }
        for (int d = 0; d < 2; d++) {
          if (side && c->code >> d & 1)
            p[d] = 1.0 - p[d];
          p[d] = c->box[side][2 * d] + p[d] * (c->box[side][2 * d + 1] - c->box[side][2 * d]);
        }
        done &=
            tsolid_assembly_evaluate(context, joined, k, side, p[0], p[1], x[side]) == TSOLID_OK;
      }
      CHECK(done);
      if (done && one_frame && c->kind == TSOLID_CONTACT_EXACT)
        CHECK(memcmp(x[0], x[1], sizeof x[0]) == 0);
    }
  }
  CHECK(view.n_interfaces > 0 && n_functions == view.n_interfaces);
  if (one_frame)
    CHECK(n_bits == view.n_interfaces);
  if (n_functions != view.n_interfaces || n_bits != view.n_interfaces)
    printf("%d contacts, %d the same functions, %d the same bits\n", view.n_interfaces, n_functions,
           n_bits);
  tsolid_assembly_free(joined);
  for (int k = 0; k < view.n_parts; k++)
    if (k == 0 || solid[k] != solid[k - 1])
      tsolid_solid_free((tsolid_solid *)(size_t)solid[k]);
}

/* Neighbours' knots that differ, degrees that differ, one of the two rational: rows are refined and
 * degrees raised all over, and both sides stay one. */
static void check_construction(tsolid_context *context) {
  for (int kind = 0; kind < 6; kind++) {
    tsolid_assembly_view view;
    block a = plain_block(0, 0, 0, kind < 2 ? 0.07 : 0.0, 3, 2);
    block b = plain_block(1, 0, 0, kind < 2 ? 0.07 : 0.0, 3, 2);
    a.rational = b.rational = kind == 1;
    if (kind == 2 || kind == 3) /* other degrees and knots, shared surface plane and linear */
      for (int d = 0; d < 3; d++)
        b.axis[d] = plain_axis(d + 1, kind == 3 ? 2 - d : d);
    if (kind == 4) { /* x-knots differ: not seen on the contact */
      a.axis[0] = plain_axis(4, 3);
      b.axis[0] = plain_axis(2, 0);
    }
    scene_add_block(&s, &a);
    scene_add_block(&s, &b);
    if (kind == 5) { /* a top face with knots of its own */
      block c = plain_block(0, 0, 0, 0.0, 3, 5);
      part other = make_block(&c);
      tsolid_patch swap = s.part[0].patch[5];
      s.part[0].patch[5] = other.patch[5];
      other.patch[5] = swap;
      part_free(&other);
    }
    for (int again = 0; again < 2; again++) {
      for (int k = 0; again && k < 2; k++)
        rewrite(&s, k);
      tsolid_assembly *assembly = match(context, 0.0, &view);
      CHECK(view.n_interfaces == 1);
      check_joined(context, assembly, 1, 16.0);
      tsolid_assembly_free(assembly);
    }
    scene_free(&s);
  }
}

/* A patch of the test's own, with another parameter t that stands for c t/(c t + 1 - t). */
static void reparametrise(tsolid_context *context, tsolid_patch *patch, int along, double c) {
  tsi_arena work = tsi_arena_create(context);
  tsi_patch copy;
  CHECK(tsi_patch_read(&work, patch, &copy) && tsi_patch_reparametrise(&copy, along, c));
  int n = copy.n[0] * copy.n[1];
  double *points = (double *)(size_t)patch->points, *weights = part_doubles((size_t)n);
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < 3; k++)
      points[3 * i + k] = copy.control[4 * i + k] / copy.control[4 * i + 3];
    weights[i] = copy.control[4 * i + 3];
  }
  free((void *)(size_t)patch->weights);
  patch->weights = weights;
  memcpy((void *)(size_t)patch->knots[along], copy.knots[along],
         (size_t)(copy.n[along] + copy.degree[along] + 1) * sizeof(double));
  tsi_arena_free(&work);
}

/* The same surface by a Moebius change of its parameters: known as one surface, and watertight; the
 * functions stay two kinds, and the report says so. */
static void check_moebius(tsolid_context *context) {
  for (int d = 0; d < 2; d++) {
    tsolid_assembly_view view;
    const tsolid_solid *solid[2] = {NULL, NULL};
    tsolid_assembly *joined = NULL;
    block a = plain_block(0, 0, 0, 0.05, 3, 2), b = plain_block(1, 0, 0, 0.05, 3, 2);
    scene_add_block(&s, &a);
    scene_add_block(&s, &b);
    reparametrise(context, &s.part[1].patch[0], d, 1.75);
    tsolid_assembly *assembly = match(context, 0.0, &view);
    if (CHECK(view.n_interfaces == 1)) {
      const tsolid_interface *c = view.interface;
      CHECK(c->kind == TSOLID_CONTACT_GEOMETRIC && c->moebius[1 - d] == 1.0);
      CHECK_NEAR(fabs(log(c->moebius[d])), log(1.75), 1e-13);
      CHECK(c->deviation < 1e-13 && check_map(c) < 1e-13);
    }
    CHECK(view.verdict == TSOLID_ASSEMBLY_WATERTIGHT);
    CHECK_NEAR(view.volume_inside, view.volume, 1e-12 * view.volume);
    for (int k = 0; k < 2; k++)
      solid[k] = build_part(context, assembly, k);
    CHECK(tsolid_assembly_join(context, assembly, 2, solid, &joined) == TSOLID_OK);
    if (joined) {
      tsolid_assembly_get(joined, &view);
      CHECK(view.interface[0].same_functions == 0 && view.interface[0].same_bits == 0);
      CHECK(view.interface[0].gap_after < 1e-13 && view.verdict == TSOLID_ASSEMBLY_WATERTIGHT);
      printf("Moebius: deviation %.2e, gap after %.2e\n", view.interface[0].deviation,
             view.interface[0].gap_after);
    }
    tsolid_assembly_free(joined);
    for (int k = 0; k < 2; k++)
      tsolid_solid_free((tsolid_solid *)(size_t)solid[k]);
    tsolid_assembly_free(assembly);
    scene_free(&s);
  }
}

/* A ring and a T with shared edges and corners, a wall with partial contacts. */
static void check_built_walls(tsolid_context *context) {
  for (int kind = 0; kind < 4; kind++) {
    tsolid_assembly_view view;
    static const double shift[4][2] = {{0.0, 0.0}, {0.5, 0.0}, {0.5, 0.25}, {1.0 / 3, 0.0}};
    build_wall(2, 2, 2, shift[kind][0], shift[kind][1], kind ? 0.0 : 0.06, 2, kind & 1);
    for (int k = 0; k < s.n; k++)
      if (kind != 1)
        rewrite(&s, k);
    tsolid_assembly *assembly = match(context, 0.0, &view);
    check_joined(context, assembly, 1, 16.0);
    tsolid_assembly_free(assembly);
    scene_free(&s);
  }
}

/* Three in a row. The middle one's top and front have few knots, so that at their corners the rows
 * along both borders are refined, and a line goes across to the contact on the other end. */
static void check_corners(tsolid_context *context) {
  for (int wavy = 0; wavy < 2; wavy++) {
    tsolid_assembly_view view;
    for (int k = 0; k < 3; k++) {
      block b = plain_block(k, 0, 0, 0.05 * wavy, 3, 0);
      b.axis[1] = plain_axis(3, wavy ? 3 : k == 0 ? 4 : k == 1 ? 1 : 0);
      b.axis[2] = plain_axis(3, wavy ? 3 : k == 2 ? 3 : 0);
      scene_add_block(&s, &b);
    }
    for (int side = 0; !wavy && side < 2; side++) { /* faces with x-knots of their own */
      block b = plain_block(1, 0, 0, 0.0, 3, 2 + 3 * side);
      part other = make_block(&b);
      tsolid_patch swap = s.part[1].patch[2 + side];
      s.part[1].patch[2 + side] = other.patch[2 + side];
      other.patch[2 + side] = swap;
      part_free(&other);
    }
    tsolid_assembly *assembly = match(context, 0.0, &view);
    CHECK(view.n_interfaces == 2);
    check_joined(context, assembly, 1, 16.0);
    tsolid_assembly_free(assembly);
    scene_free(&s);
  }
}

/* A part whose top is two patches that end on a border of the contact's patch, which is cut there.
 */
static void check_pieces(tsolid_context *context) {
  tsolid_assembly_view view;
  block a = plain_block(0, 0, 0, 0.0, 3, 1), b = plain_block(1, 0, 0, 0.0, 2, 0), cut = a;
  cut.axis[1].n_strips = 2;
  cut.axis[1].strip[0] = cut.axis[1].strip[1] = (strip){.degree = 4, .n_inner = 1, .inner = {0.5}};
  part whole = make_block(&a), split = make_block(&cut);
  part mixed = {7, calloc(7, sizeof *mixed.patch)};
  for (int k = 0; k < 7; k++) {
    const tsolid_patch *from = k < 5 ? &whole.patch[k] : &split.patch[split.n - 7 + k];
    mixed.patch[k] = reorient_patch(from, k & 1, 0, k > 4);
  }
  part_free(&whole);
  part_free(&split);
  scene_add(&s, mixed);
  scene_add_block(&s, &b);
  tsolid_assembly *assembly = match(context, 0.0, &view);
  CHECK(view.n_interfaces == 1 && view.verdict == TSOLID_ASSEMBLY_WATERTIGHT);
  check_joined(context, assembly, 1, 16.0);
  tsolid_assembly_free(assembly);
  scene_free(&s);
}

/* Copies: converted once; the same functions, a few ulp. */
static void check_built_copies(tsolid_context *context) {
  static double placement[6][12];
  tsolid_assembly_view view;
  block b = plain_block(0, 0, 0, 0.0, 2, 1);
  b.axis[1] = plain_axis(3, 0);
  scene_add_block(&s, &b);
  for (int k = 1; k < 6; k++) {
    s.member[k] = s.member[0];
    for (int i = 0; i < 12; i++)
      placement[k][i] = i % 5 == 0;
    placement[k][3] = k;
    s.member[k].placement = placement[k];
  }
  s.input.n_parts = 6;
  tsolid_assembly *assembly = match(context, 0.0, &view);
  CHECK(view.n_interfaces == 5);
  check_joined(context, assembly, 0, 16.0);
  tsolid_assembly_free(assembly);
  scene_free(&s);
}

/* Many parts. The times are for the reader: tests/bench/assembly.py has them beside n log n. */
static void check_many(tsolid_context *context) {
  static const int n[3] = {25, 100, 400};
  double seconds[3];
  for (int k = 0; k < 3; k++) {
    tsolid_assembly_view view;
    build_wall(5, n[k] / 25, 5, 0.0, 0.0, 0.05, 2, 1);
    clock_t begin = clock();
    tsolid_assembly *assembly = match(context, 0.0, &view);
    seconds[k] = (double)(clock() - begin) / CLOCKS_PER_SEC;
    CHECK(view.verdict == TSOLID_ASSEMBLY_WATERTIGHT);
    CHECK(view.n_interfaces == 4 * (n[k] / 25) * 5 * 2 + 25 * (n[k] / 25 - 1));
    tsolid_assembly_free(assembly);
    scene_free(&s);
  }
  printf("25, 100, 400 parts: %.3f, %.3f, %.3f s\n", seconds[0], seconds[1], seconds[2]);
}

/* Every allocation fails once: a status, no crash, nothing left. */
static void check_memory(void) {
  meter m = {.limit = (size_t)1 << 40, .countdown = -1};
  tsolid_context *context = new_counted_context(&m);
  tsolid_assembly *assembly = NULL;
  int failures = 0, done = 0;
  block a = plain_block(0, 0, 0, 0.05, 2, 1), b = plain_block(1, 0, 0, 0.05, 3, 1),
        c = plain_block(0.5, 0, 1, 0.0, 1, 0);
  scene_add_block(&s, &a);
  scene_add_block(&s, &b);
  scene_add_block(&s, &c);
  for (long k = 0; !done && k < 20000; k++) {
    m.countdown = k;
    tsolid_status status = tsolid_assembly_create(context, &s.input, NULL, &assembly);
    m.countdown = -1;
    done = status == TSOLID_OK;
    failures += !done;
    if (!done && !CHECK(status == TSOLID_ERROR_MEMORY && assembly == NULL))
      break;
    if (!done)
      tsolid_assembly_free(assembly);
    tsolid_context_clear(context);
  }
  CHECK(done && failures > 50);
  const tsolid_solid *solid[3] = {NULL, NULL, NULL};
  for (int k = 0; k < 2; k++)
    solid[k] = build_part(context, assembly, k);
  done = 0;
  for (long k = 0; !done && k < 20000; k++) {
    tsolid_assembly *joined = NULL;
    m.countdown = k;
    tsolid_status status = tsolid_assembly_join(context, assembly, 3, solid, &joined);
    m.countdown = -1;
    done = status == TSOLID_OK;
    if (!done && !CHECK(status == TSOLID_ERROR_MEMORY && joined == NULL))
      break;
    tsolid_assembly_free(joined);
    tsolid_context_clear(context);
  }
  CHECK(done);
  for (int k = 0; k < 2; k++)
    tsolid_solid_free((tsolid_solid *)(size_t)solid[k]);
  tsolid_assembly_free(assembly);
  tsolid_context_free(context);
  CHECK(m.live == 0);
  scene_free(&s);
}

int main(void) {
  tsolid_context *context = NULL;
  CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK);
  check_orientations(context, 0);
  check_orientations(context, 1);
  check_kinds(context);
  check_gaps(context);
  check_rotated(context);
  check_clashes(context);
  check_walls(context);
  check_blocks(context);
  check_copies(context);
  check_construction(context);
  check_moebius(context);
  check_built_walls(context);
  check_corners(context);
  check_pieces(context);
  check_built_copies(context);
  check_many(context);
  check_memory();
  tsolid_context_free(context);
  return check_done();
}
