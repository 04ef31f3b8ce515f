/* SPDX-License-Identifier: LGPL-2.1-or-later
 * What hands a solid on, under failing memory and cancellation: a status, nothing leaks, no file
 * half written; and Dirichlet sets refuse arrays that are too short. */
#include <unistd.h>

#include "check.h"
#include "counted_memory.h"
#include "parts.h"

static const char path[] = "test_hand_on.out";

typedef tsolid_status (*step)(tsolid_context *context, const tsolid_solid *solid);

static tsolid_status write_fields(tsolid_context *context, const tsolid_solid *solid) {
  static double value[3 * 4096];
  tsolid_field field[2] = {{"a", 1, value}, {"b", 3, value}};
  return tsolid_write_vtu_fields(context, solid, 2, field, path);
}

static tsolid_status write_extraction(tsolid_context *context, const tsolid_solid *solid) {
  return tsolid_write_extraction(context, solid, path);
}

static tsolid_status write_sets(tsolid_context *context, const tsolid_solid *solid) {
  static const tsolid_region region = {"side", 3, {0, 1, 0, 1}};
  tsolid_bext_options options = {1, &region, 1};
  return tsolid_write_bext_sets(context, solid, &options, path);
}

static tsolid_status write_hexahedra(tsolid_context *context, const tsolid_solid *solid) {
  tsolid_hex_options options = {.order = 2, .divisions = {2, 2, 2, 1}, .allow_unproved = 1};
  tsolid_hex *hex = NULL;
  tsolid_status status = tsolid_hex_create(context, solid, &options, &hex);
  if (status == TSOLID_OK)
    status = tsolid_write_hex_vtu(context, hex, path);
  tsolid_hex_free(hex);
  return status;
}

static tsolid_status find_functions(tsolid_context *context, const tsolid_solid *solid) {
  static const tsolid_region region = {NULL, 0, {0, 0.5, 0, 1}};
  int n = 0, function[4096];
  tsolid_status status = tsolid_face_functions(context, solid, &region, 4096, &n, function);
  if (status == TSOLID_OK)
    status = tsolid_write_set_petsc(context, n, function, path);
  return status;
}

static tsolid_status copy_table(tsolid_context *context, const tsolid_solid *solid) {
  static const double value[6] = {1, 2, 3, 4, 5, 6.5};
  double *again = NULL;
  int rows = 0, columns = 0;
  (void)solid;
  tsolid_status status = tsolid_write_table_market(context, 3, 2, value, path);
  if (status == TSOLID_OK)
    status = tsolid_read_table(context, path, &rows, &columns, &again);
  if (status == TSOLID_OK)
    CHECK(rows == 3 && columns == 2 && memcmp(again, value, sizeof value) == 0);
  else
    CHECK(!again && rows == 0 && columns == 0);
  tsolid_release(context, again);
  return status;
}

/* Every allocation fails once. */
static void test_memory(tsolid_context *context, meter *m, const tsolid_solid *solid, step run) {
  size_t live = m->live;
  long n = 0;
  tsolid_status status = TSOLID_ERROR_MEMORY;
  for (; status != TSOLID_OK && n < 100000; n++) {
    tsolid_context_clear(context);
    remove(path);
    live = m->live;
    m->countdown = n;
    status = run(context, solid);
    m->countdown = -1;
    if (!CHECK(status == TSOLID_OK || status == TSOLID_ERROR_MEMORY))
      return;
    tsolid_context_clear(context);
    CHECK(m->live <= live);
  }
  CHECK(n > 1 && access(path, F_OK) == 0);
  remove(path);
}

static int stop(void *data, const char *stage, double fraction) {
  int *left = data;
  (void)stage;
  (void)fraction;
  return (*left)-- == 0;
}

/* Every point of cancellation fires once, and leaves no file. */
static void test_cancel(const tsolid_solid *solid, step run) {
  tsolid_status status = TSOLID_ERROR_CANCELLED;
  for (int k = 0; status != TSOLID_OK && k < 10000; k++) {
    int left = k;
    tsolid_context *context = NULL;
    tsolid_context_options options = {.progress = stop, .progress_data = &left, .n_threads = 1};
    CHECK(tsolid_context_create(&options, &context) == TSOLID_OK);
    status = run(context, solid);
    CHECK(status == TSOLID_OK || status == TSOLID_ERROR_CANCELLED);
    CHECK((access(path, F_OK) == 0) == (status == TSOLID_OK));
    tsolid_context_free(context);
  }
  CHECK(status == TSOLID_OK);
  remove(path);
}

static void test_arguments(tsolid_context *context, const tsolid_solid *solid) {
  tsolid_region region = {NULL, 1, {0, 1, 0, 1}};
  int n = 0, function[4];
  CHECK(tsolid_face_functions(context, solid, &region, 0, &n, NULL) == TSOLID_OK && n > 4);
  CHECK(tsolid_face_functions(context, solid, &region, 4, &n, function) == TSOLID_ERROR_ARGUMENT);
  region.side = 6;
  CHECK(tsolid_face_functions(context, solid, &region, 0, &n, NULL) == TSOLID_ERROR_ARGUMENT);
  CHECK(tsolid_face_functions(context, NULL, &region, 0, &n, NULL) == TSOLID_ERROR_ARGUMENT);
}

int main(void) {
  static const step steps[] = {write_fields,    write_extraction, write_sets,
                               write_hexahedra, find_functions,   copy_table};
  meter m = {.limit = (size_t)1 << 34, .countdown = -1};
  part_net net;
  tsolid_context *context = new_counted_context(&m);
  part_identity(&net, 2, 2, 1);
  net.weight[4] = 1.5;
  tsolid_solid *solid = part_solid(context, &net);
  if (CHECK(solid != NULL)) {
    test_arguments(context, solid);
    for (size_t k = 0; k < sizeof steps / sizeof *steps; k++) {
      test_memory(context, &m, solid, steps[k]);
      test_cancel(solid, steps[k]);
    }
  }
  tsolid_solid_free(solid);
  tsolid_context_free(context);
  CHECK(m.live == 0);
  return check_done();
}
