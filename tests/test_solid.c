/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Weights and control points: positive weights inside whatever the boundary's, an optimisation that
 * leaves what is given, does not lose what the start had and gives up cleanly: out of memory,
 * cancelled, or without a solution. */
#include "check.h"

#include "cube_part.h"
#include "parts.h"

static const cube_axis ONE[3] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
static const cube_axis SMALL[3] = {{2, 1, 1}, {3, 2, 1}, {1, 1, 1}};
static const cube_axis MIXED[3] = {{3, 2, 1}, {2, 2, 1}, {1, 3, 1}};

static tsolid_context *new_context(const tsolid_context_options *options) {
  tsolid_context *context = NULL;
  CHECK(tsolid_context_create(options, &context) == TSOLID_OK);
  return context;
}

static const double *boundary_layer(const tsolid_solid *solid) {
  return solid->control + 4 * (size_t)(solid->space->n_inner + solid->space->n_surface);
}

/* ---- weights -----------------------------------------------------------------------------------
 */

static double random_scale; /* of the weights that follow */

static void random_weight(double p[4]) {
  static unsigned state = 5;
  cube_wave(p);
  p[3] = random_scale * pow(100.0, cube_noise(&state));
  if (cube_noise(&state) < 0.0) /* half of them at the ends of the range */
    p[3] = random_scale * (cube_noise(&state) < 0.0 ? 0.1 : 10.0);
}

static void constant_weight(double p[4]) {
  cube_wave(p);
  p[3] = random_scale;
}

static int start_of(tsolid_context *context, const cube_axis axis[3], cube_map map, int n_cells,
                    cube_solid *s, tsolid_solid **start) {
  *start = NULL;
  return CHECK(cube_solid_create(context, axis, map, n_cells, 0.0, s)) &&
         CHECK(tsolid_solid_create(context, s->space, start) == TSOLID_OK);
}

static void test_constant_weights(tsolid_context *context) {
  static const double value[] = {1.0, 0.7, 1e-3, 3e5};
  for (int k = 0; k < 4; k++) {
    cube_solid s;
    tsolid_solid *start;
    random_scale = value[k];
    if (start_of(context, MIXED, constant_weight, 0, &s, &start)) {
      const double *control = tsolid_solid_control(start), given = boundary_layer(start)[3];
      int n = s.space->n_inner + 2 * s.space->n_surface, n_other = 0;
      for (int f = 0; f < n; f++)
        n_other += control[4 * f + 3] != given;
      CHECK(n_other == 0);
      CHECK_NEAR(given, value[k], 1e-15 * value[k]);
      CHECK(start->constant_weight);
    }
    tsolid_solid_free(start);
    cube_solid_free(&s);
  }
}

/* Positive, inside the boundary's range, and each inner weight away from its ends: an average. */
static void check_weight_range(const tsolid_solid *start) {
  const tsolid_space *space = start->space;
  const double *control = start->control, *given = space->boundary->points;
  double low = (double)INFINITY, high = 0.0;
  int n_outside = 0, n_at_end = 0, n_copied = 0;
  for (int i = 0; i < space->n_surface; i++) {
    low = fmin(low, given[4 * i + 3]);
    high = fmax(high, given[4 * i + 3]);
  }
  CHECK_NEAR(high / low, 100.0, 1e-9);
  for (int f = 0; f < space->n_inner; f++) {
    double w = control[4 * f + 3];
    n_outside += !(w >= low && w <= high);
    n_at_end += w == low || w == high;
  }
  for (int i = 0; i < space->n_surface; i++)
    for (int layer = 0; layer < 2; layer++)
      n_copied +=
          control[4 * (space->n_inner + layer * space->n_surface + i) + 3] == given[4 * i + 3];
  CHECK(n_outside == 0);
  CHECK(n_at_end == 0);
  CHECK(n_copied == 2 * space->n_surface);
  CHECK(!start->constant_weight);
}

/* Four times the weights give four times the weights, to the bit, and the same positions. */
static void check_weight_scale(tsolid_context *context, const tsolid_solid *start) {
  tsolid_boundary *boundary = (tsolid_boundary *)(uintptr_t)start->space->boundary;
  size_t n = 4 * (size_t)(start->space->n_inner + 2 * start->space->n_surface), n_other = 0;
  tsolid_solid *scaled = NULL;
  for (int i = 0; i < 4 * boundary->n_functions; i++)
    boundary->points[i] *= 4.0;
  if (CHECK(tsolid_solid_create(context, start->space, &scaled) == TSOLID_OK))
    for (size_t i = 0; i < n; i++)
      n_other += scaled->control[i] != 4.0 * start->control[i];
  CHECK(n_other == 0);
  for (int i = 0; i < 4 * boundary->n_functions; i++)
    boundary->points[i] *= 0.25;
  tsolid_solid_free(scaled);
}

static void test_random_weights(tsolid_context *context) {
  static const cube_axis fine[3] = {{3, 5, 1}, {4, 3, 2}, {2, 1, 1}};
  for (int k = 0; k < 6; k++) {
    cube_solid s;
    tsolid_solid *start;
    random_scale = k < 2 ? 1.0 : 0.3 * k;
    if (start_of(context, k % 2 ? fine : MIXED, random_weight, 0, &s, &start)) {
      check_weight_range(start);
      check_weight_scale(context, start);
    }
    tsolid_solid_free(start);
    cube_solid_free(&s);
  }
}

/* ---- what an optimisation keeps ----------------------------------------------------------------
 */

static double worst_of(tsolid_context *context, const tsolid_solid *solid) {
  tsolid_quality quality = {.worst = (double)NAN};
  CHECK(tsolid_quality_measure(context, solid, &quality) == TSOLID_OK);
  return quality.worst;
}

static tsolid_verdict verdict_of(tsolid_context *context, const tsolid_solid *solid) {
  tsolid_certificate certificate = {.verdict = TSOLID_UNDECIDED};
  CHECK(tsolid_certify(context, solid, NULL, &certificate, NULL) == TSOLID_OK);
  return certificate.verdict;
}

/* Returns what effort `effort` makes of the start, after the checks that hold for any start. */
static tsolid_solid *check_optimised(tsolid_context *context, const tsolid_solid *start,
                                     int effort) {
  const tsolid_solid_options options = {.effort = effort};
  tsolid_solid *solid = NULL;
  size_t n_free = (size_t)(start->space->n_inner + start->space->n_surface);
  size_t n_surface = (size_t)start->space->n_surface, n_other = 0, size = 4 * (n_free + n_surface);
  double *before = malloc(size * sizeof *before);
  memcpy(before, start->control, size * sizeof *before);
  if (CHECK(tsolid_solid_optimise(context, start, &options, &solid) == TSOLID_OK)) {
    for (size_t f = 0; f < n_free + n_surface; f++)
      n_other += solid->control[4 * f + 3] != start->control[4 * f + 3];
    CHECK(n_other == 0);
    CHECK(memcmp(boundary_layer(solid), start->space->boundary->points,
                 4 * n_surface * sizeof(double)) == 0);
    double worst = worst_of(context, start), after = worst_of(context, solid);
    CHECK(!(worst > 0.0) || after >= worst * (1.0 - 1e-9));
    if (verdict_of(context, start) == TSOLID_POSITIVE)
      CHECK(verdict_of(context, solid) == TSOLID_POSITIVE);
  }
  CHECK(memcmp(before, start->control, size * sizeof *before) == 0); /* the start is untouched */
  free(before);
  return solid;
}

/* effort 1 is the start, but for the round-off of a shift to the centre and back. */
static void check_start_only(const tsolid_solid *start, const tsolid_solid *solid) {
  double scale = tsolid_boundary_scale(start->space->boundary), error = 0.0;
  for (int i = 0; i < 4 * (start->space->n_inner + 2 * start->space->n_surface); i++)
    error = fmax(error, fabs(solid->control[i] - start->control[i]) / start->control[i | 3]);
  CHECK_NEAR(error, 0.0, 8 * 0x1p-52 * scale);
}

/* From the library's own start, valid in the first two cases; all efforts on one of them. */
static void test_efforts(tsolid_context *context) {
  static const cube_map map[] = {cube_wave, cube_rational, random_weight};
  random_scale = 1.0;
  for (int k = 0; k < 3; k++) {
    cube_solid s;
    tsolid_solid *start, *solid;
    if (start_of(context, SMALL, map[k], 1, &s, &start))
      for (int effort = k == 1 ? 0 : 2; effort <= (k == 1 ? 3 : 2); effort++) {
        solid = check_optimised(context, start, effort);
        if (solid && effort == 1)
          check_start_only(start, solid);
        else if (solid && k < 2)
          CHECK(verdict_of(context, solid) == TSOLID_POSITIVE);
        tsolid_solid_free(solid);
      }
    tsolid_solid_free(start);
    cube_solid_free(&s);
  }
}

/* From points thrown about: folded all over. */
static void test_untangling(tsolid_context *context) {
  cube_solid s;
  tsolid_solid *solid = NULL;
  if (CHECK(cube_solid_create(context, SMALL, cube_wave, 1, 0.3, &s))) {
    CHECK(worst_of(context, s.solid) < -0.1);
    solid = check_optimised(context, s.solid, 0);
    CHECK(solid && verdict_of(context, solid) == TSOLID_POSITIVE);
  }
  tsolid_solid_free(solid);
  cube_solid_free(&s);
}

/* The start over the net's faces, with n_cells cells across z; NULL when anything failed. */
static tsolid_solid *net_start(tsolid_context *context, const part_net *net, int n_cells) {
  static const double third[4] = {0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0}, whole[2] = {0.0, 1.0};
  static const double height[6] = {0.7, 0.7, 0.7, 0.7, 0.7, 0.7};
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_solid *solid = NULL;
  tsolid_boundary *boundary = part_boundary(context, net);
  tsolid_requirement r;
  int box[9 * 6], n[3], n_boxes = n_cells * n_cells;
  const double *line[3];
  if (!CHECK(boundary != NULL))
    return NULL;
  tsolid_boundary_requirement(boundary, &r);
  for (int a = 0; a < 3; a++) {
    n[a] = fabs(r.corner[1 << a][2] - r.corner[0][2]) > 1.0 ? 1 : n_cells;
    line[a] = n[a] == 3 ? third : whole;
  }
  for (int b = 0; b < n_boxes; b++) {
    int lo[3] = {b % n[0], b / n[0] % n[1], b / (n[0] * n[1])};
    for (int i = 0; i < 6; i++)
      box[6 * b + i] = lo[i % 3] + i / 3;
  }
  CHECK(tsi_tmesh_from_boxes(context, (int[3]){n[0] + 1, n[1] + 1, n[2] + 1}, line, n_boxes, box,
                             height, 0, &tmesh) == TSOLID_OK &&
        tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK &&
        tsolid_solid_create(context, space, &solid) == TSOLID_OK);
  tsolid_space_free(space);
  tsolid_tmesh_free(tmesh);
  tsolid_boundary_free(boundary);
  return solid;
}

/* A round bar: det J is zero at eight corners of the input itself, and the rest must not be lost.
 */
static void test_singular(tsolid_context *context) {
  part_net net;
  part_cylinder(&net);
  tsolid_solid *start = net_start(context, &net, 3);
  if (start) {
    CHECK(verdict_of(context, start) == TSOLID_POSITIVE);
    tsolid_solid_free(check_optimised(context, start, 2));
  }
  tsolid_solid_free(start);
}

/* The top dives through the bottom: in the middle the boundary winds the other way round, so that
 * no map has det J > 0 everywhere. Nothing can be proved, in any round, and it ends. */
static void test_impossible(tsolid_context *context) {
  part_net net;
  part_identity(&net, 2, 2, 2);
  net.point[part_index(&net, (int[3]){1, 1, 2})][2] = -5.0;
  tsolid_solid *start = net_start(context, &net, 1);
  if (start) {
    tsolid_solid *solid = check_optimised(context, start, 2);
    CHECK(solid && verdict_of(context, solid) != TSOLID_POSITIVE);
    tsolid_solid_free(solid);
  }
  tsolid_solid_free(start);
}

static void test_arguments(tsolid_context *context) {
  cube_solid s;
  tsolid_solid *solid = NULL;
  if (CHECK(cube_solid_create(context, ONE, cube_wave, 1, 0.0, &s)))
    for (int k = 0; k < 2; k++) {
      const tsolid_solid_options options = {.effort = k ? 4 : -1};
      CHECK(tsolid_solid_optimise(context, s.solid, &options, &solid) == TSOLID_ERROR_ARGUMENT);
      CHECK(!solid);
    }
  CHECK(tsolid_solid_optimise(context, NULL, NULL, &solid) == TSOLID_ERROR_ARGUMENT && !solid);
  CHECK(tsolid_solid_create(context, NULL, &solid) == TSOLID_ERROR_ARGUMENT && !solid);
  cube_solid_free(&s);
}

/* ---- giving up ---------------------------------------------------------------------------------
 */

typedef struct counting {
  long n_requests, fail_at, n_live;
  int n_calls, cancel_at;
  double sum; /* of the control points of the result */
} counting;

static void *count_allocate(void *data, size_t size) {
  counting *c = data;
  if (++c->n_requests == c->fail_at)
    return NULL;
  void *memory = malloc(size);
  c->n_live += memory != NULL;
  return memory;
}

static void count_release(void *data, void *memory) {
  ((counting *)data)->n_live--;
  free(memory);
}

static int count_progress(void *data, const char *stage, double fraction) {
  counting *c = data;
  CHECK(stage && fraction >= 0.0 && fraction <= 1.0);
  return ++c->n_calls == c->cancel_at;
}

/* The part of one run that can fail: space or start in, solid out. */
typedef tsolid_status (*attempt)(tsolid_context *context, const tsolid_space *space,
                                 const tsolid_solid *start, tsolid_solid **solid);

static tsolid_status create(tsolid_context *context, const tsolid_space *space,
                            const tsolid_solid *start, tsolid_solid **solid) {
  (void)start;
  return tsolid_solid_create(context, space, solid);
}

static tsolid_status optimise(tsolid_context *context, const tsolid_space *space,
                              const tsolid_solid *start, tsolid_solid **solid) {
  const tsolid_solid_options quick = {.effort = 2};
  (void)space;
  return tsolid_solid_optimise(context, start, &quick, solid);
}

/* Runs it with the failure that `c` asks for; checks that nothing is left behind. */
static tsolid_status run_attempt(attempt try, const cube_solid *s, counting *c) {
  tsolid_context_options options = {.allocate = count_allocate,
                                    .release = count_release,
                                    .allocator_data = c,
                                    .progress = count_progress,
                                    .progress_data = c,
                                    .n_threads = 1};
  tsolid_context *context = NULL;
  tsolid_solid *solid = NULL;
  tsolid_status status = tsolid_context_create(&options, &context);
  if (status == TSOLID_OK)
    status = try(context, s->space, s->solid, &solid);
  CHECK((status == TSOLID_OK) == (solid != NULL));
  if (status == TSOLID_ERROR_CANCELLED)
    CHECK(tsolid_context_n_findings(context) > 0);
  c->sum = 0.0;
  for (int i = 0; solid && i < 4 * (s->space->n_inner + s->space->n_surface); i++)
    c->sum += i % 7 * solid->control[i];
  tsolid_context_free(context);
  tsolid_solid_free(solid); /* outlives its context */
  CHECK(c->n_live == 0);
  CHECK(s->space->references == 2 && s->solid->references == 1); /* the fixture's own */
  return status;
}

/* Fails one request per run, in at most n_runs runs. Without room for a finding only the finding is
 * lost: notes of the proof on the way, which nobody sees. */
static void check_failing_memory(attempt try, const cube_solid *s, int n_lost_allowed, int n_runs) {
  counting whole = {.n_requests = 0};
  int n_lost = 0;
  CHECK(run_attempt(try, s, &whole) == TSOLID_OK);
  CHECK(whole.n_requests > 20);
  for (long k = 1; k <= whole.n_requests; k += 1 + whole.n_requests / n_runs) {
    counting c = {.fail_at = k};
    tsolid_status status = run_attempt(try, s, &c);
    CHECK(status == TSOLID_ERROR_MEMORY || (status == TSOLID_OK && c.sum == whole.sum));
    n_lost += status == TSOLID_OK;
  }
  CHECK(n_lost <= n_lost_allowed);
}

static void check_cancelling(attempt try, const cube_solid *s, int n_runs) {
  counting whole = {.n_requests = 0};
  CHECK(run_attempt(try, s, &whole) == TSOLID_OK);
  CHECK(whole.n_calls > 0);
  for (int k = 1; k <= whole.n_calls; k += 1 + whole.n_calls / n_runs) {
    counting c = {.cancel_at = k};
    CHECK(run_attempt(try, s, &c) == TSOLID_ERROR_CANCELLED);
    CHECK(c.n_calls == k); /* no call after the one that cancels */
  }
}

static void test_giving_up(tsolid_context *context) {
  enum { EACH = 10000, MANY = 15, SOME = 6 };
  cube_solid tame, wild; /* the wild one is proved only after some rounds */
  random_scale = 1.0;
  if (CHECK(cube_solid_create(context, ONE, cube_rational, 1, 0.0, &tame)) &&
      CHECK(cube_solid_create(context, ONE, random_weight, 1, 0.02, &wild))) {
    check_failing_memory(create, &wild, 0, EACH);
    check_cancelling(create, &wild, EACH);
    check_failing_memory(optimise, &tame, 0, MANY);
    check_cancelling(optimise, &tame, EACH);
    check_failing_memory(optimise, &wild, 4, SOME);
    check_cancelling(optimise, &wild, SOME);
  }
  cube_solid_free(&tame);
  cube_solid_free(&wild);
}

int main(void) {
  tsolid_context *context = new_context(NULL);
  test_constant_weights(context);
  test_random_weights(context);
  test_efforts(context);
  test_untangling(context);
  test_singular(context);
  test_impossible(context);
  test_arguments(context);
  test_giving_up(context);
  tsolid_context_free(context);
  return check_done();
}
