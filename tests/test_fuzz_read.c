/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Mutated .tsb and .tsolid files, thousands of them: a status and no crash (the sanitizers look
 * on), memory in proportion to the file, and whatever is accepted is written back the same.
 *
 *   test_fuzz_read [count [seed]]
 *
 * With -DTSOLID_LIBFUZZER and clang -fsanitize=fuzzer the same checks run under libFuzzer. */
#define _XOPEN_SOURCE 700
#include <stdlib.h>
#include <unistd.h>
#include <zlib.h>

#include "check.h"
#include "counted_memory.h"
#include "internal.h"
#include "tsolid_format.h"

enum { MAX_FILE = 1 << 20 };

static char path_in[80], path_out[80], path_again[80];

/* ---- one file ----------------------------------------------------------------------------------
 */

static int store(const char *path, const unsigned char *bytes, size_t size) {
  FILE *file = fopen(path, "wb");
  int stored = file && fwrite(bytes, 1, size, file) == size;
  return file && fclose(file) == 0 && stored;
}

static size_t load(const char *path, unsigned char *bytes) {
  FILE *file = fopen(path, "rb");
  size_t size = file ? fread(bytes, 1, MAX_FILE, file) : 0;
  if (file)
    fclose(file);
  return size;
}

static int same_files(const char *a, const char *b) {
  static unsigned char p[MAX_FILE], q[MAX_FILE];
  size_t n = load(a, p);
  return n > 0 && n == load(b, q) && memcmp(p, q, n) == 0;
}

/* A refusal names its reason. */
static int explained(tsolid_context *context, tsolid_status status) {
  int n = tsolid_context_n_findings(context);
  return status == TSOLID_OK || (n > 0 && tsolid_context_finding(context, n - 1)->status == status);
}

/* Returns whether the file was accepted. */
static int try_tsb(size_t size) {
  meter m = {.limit = (size_t)1 << 30, .countdown = -1};
  tsolid_context *context = new_counted_context(&m);
  tsolid_boundary_file *file, *again = NULL;
  tsolid_boundary *boundary = NULL;
  tsolid_status status = tsolid_read_tsb(context, path_in, &file);
  CHECK(status == TSOLID_OK || status == TSOLID_ERROR_INPUT);
  CHECK(!file == (status != TSOLID_OK) && explained(context, status));
  CHECK(m.peak < 64 * size + 65536);
  if (file) {
    CHECK(tsolid_write_tsb(context, tsolid_boundary_file_input(file), path_out) == TSOLID_OK);
    CHECK(tsolid_read_tsb(context, path_out, &again) == TSOLID_OK);
    CHECK(again &&
          tsolid_write_tsb(context, tsolid_boundary_file_input(again), path_again) == TSOLID_OK);
    CHECK(same_files(path_out, path_again));
    /* What has the right form may still be any nonsense: the next stage gets it, too. */
    status =
        tsolid_boundary_create(context, tsolid_boundary_file_input(file), NULL, NULL, &boundary);
    CHECK(!boundary == (status != TSOLID_OK) && explained(context, status));
    CHECK(status == TSOLID_OK || status == TSOLID_ERROR_INPUT || status == TSOLID_ERROR_REFUSED);
  }
  int accepted = file != NULL;
  tsolid_boundary_free(boundary);
  tsolid_boundary_file_free(file);
  tsolid_boundary_file_free(again);
  tsolid_context_free(context);
  CHECK(m.live == 0);
  return accepted;
}

static int try_tsolid(void) {
  meter m = {.limit = (size_t)1 << 28, .countdown = -1};
  tsolid_context *context = new_counted_context(&m);
  tsolid_solid *solid = NULL;
  tsolid_status status = tsolid_read_tsolid(context, path_in, &solid);
  CHECK(!solid == (status != TSOLID_OK) && explained(context, status));
  if (!CHECK(status == TSOLID_OK || status == TSOLID_ERROR_INPUT ||
             status == TSOLID_ERROR_REFUSED || status == TSOLID_ERROR_MEMORY))
    fprintf(stderr, "    status %d\n", (int)status);
  if (solid) {
    CHECK(tsolid_write_tsolid(context, solid, path_out) == TSOLID_OK);
    CHECK(same_files(path_in, path_out));
  }
  tsolid_solid_free(solid);
  tsolid_context_free(context);
  CHECK(m.live == 0);
  return status == TSOLID_OK;
}

static int try_file(const unsigned char *bytes, size_t size) {
  if (!CHECK(store(path_in, bytes, size)))
    return 0;
  int is_solid = size >= TSI_TSOLID_MAGIC_SIZE && bytes[0] == 0x89;
  return is_solid ? try_tsolid() : try_tsb(size);
}

static int choose_paths(void) {
  const char *base = getenv("TMPDIR");
  char folder[64];
  snprintf(folder, sizeof folder, "%.40s/tsolid.XXXXXX", base ? base : "/tmp");
  if (!mkdtemp(folder))
    return 0;
  snprintf(path_in, sizeof path_in, "%s/in", folder);
  snprintf(path_out, sizeof path_out, "%s/out", folder);
  snprintf(path_again, sizeof path_again, "%s/again", folder);
  return 1;
}

#ifdef TSOLID_LIBFUZZER

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
  if (!path_in[0] && !choose_paths())
    abort();
  if (size < MAX_FILE)
    try_file(bytes, size);
  if (check_n_failed)
    abort();
  return 0;
}

#else

/* ---- mutation ----------------------------------------------------------------------------------
 */

static uint64_t random_state;

static size_t below(size_t n) { /* xorshift64* (Vigna 2016); n > 0 */
  random_state ^= random_state >> 12;
  random_state ^= random_state << 25;
  random_state ^= random_state >> 27;
  return (size_t)((random_state * 2685821657736338717u >> 16) % n);
}

typedef struct buffer {
  unsigned char bytes[MAX_FILE];
  size_t size;
} buffer;

static void replace(buffer *b, size_t at, size_t length, const void *with, size_t n) {
  if (b->size - length + n > MAX_FILE)
    return;
  memmove(b->bytes + at + n, b->bytes + at + length, b->size - at - length);
  memcpy(b->bytes + at, with, n);
  b->size = b->size - length + n;
}

/* Bytes anywhere: flipped, set, cut out, doubled, cut off. */
static void mutate_bytes(buffer *b) {
  static unsigned char piece[256];
  size_t at = below(b->size), n = 1 + below(below(16) ? 16 : 256);
  n = n < b->size - at ? n : b->size - at;
  switch (below(5)) {
  case 0:
    b->bytes[at] ^= (unsigned char)(1 << below(8));
    break;
  case 1:
    b->bytes[at] = (unsigned char)below(256);
    break;
  case 2:
    replace(b, at, n, "", 0);
    break;
  case 3:
    memcpy(piece, b->bytes + at, n);
    replace(b, below(b->size), 0, piece, n);
    break;
  default:
    if (below(8) == 0)
      b->size = at;
    break;
  }
}

static int in_token(unsigned char c) {
  return c > ' ' && !strchr("[]{}:,\"", c);
}

/* A token of the text: changed for another one, removed, or doubled. */
static void mutate_token(buffer *b) {
  static const char *const other[] = {
      "0",    "-1",   "1",     "2",     "0.5",  "1e308", "-1e308", "1e-320",  "1e999",
      "25",   "26",   "null",  "true",  "NaN",  "[",     "]",      "{",       "}",
      ",",    ":",    "\"\"",  "\"a\"", "[]",   "{}",    "-0",     "1e",      "268435456",
      "1e20", "\"\\", "\\u00", "-",     "[[[[", "0x10",  "1,5",    "Infinity"};
  size_t at = below(b->size), end;
  while (at > 0 && in_token(b->bytes[at - 1]))
    at--;
  for (end = at; end < b->size && in_token(b->bytes[end]);)
    end++;
  end += end == at; /* one of the punctuation marks */
  const char *with = other[below(sizeof other / sizeof *other)];
  if (below(8) == 0)
    replace(b, at, end - at, "", 0);
  else
    replace(b, at, end - at, with, strlen(with));
}

static size_t get_length(const unsigned char *section) {
  size_t length = 0;
  for (int k = 7; k >= 0; k--)
    length = length << 8 | section[4 + k];
  return length;
}

/* A whole number or a double of the container gets a value that asks for trouble. */
static void mutate_word(buffer *b) {
  static const uint64_t words[] = {0,          1,        2,          3,    25,     26, 0x7fffffff,
                                   0xffffffff, 1u << 28, 0x80000000, 1000, 0xfff0, 40, 41};
  static const double doubles[] = {0.0, 1.0, -1.0, 0.5, 1e308, 1e-308, 2.0, -0.0};
  size_t size = below(2) ? 4 : 8, at = 12 + below(b->size);
  uint64_t word = words[below(sizeof words / sizeof *words)];
  if (size == 8)
    memcpy(&word, &doubles[below(sizeof doubles / sizeof *doubles)], sizeof word);
  for (size_t k = 0; k < size && at + k < b->size; k++)
    b->bytes[at + k] = (unsigned char)(word >> 8 * k);
}

/* Right checksums, so that the content is looked at. */
static void repair(buffer *b) {
  size_t at = TSI_TSOLID_MAGIC_SIZE + 4;
  while (b->size >= TSI_TSOLID_SECTION_FRAME && at <= b->size - TSI_TSOLID_SECTION_FRAME) {
    size_t length = get_length(b->bytes + at);
    if (length > b->size - at - TSI_TSOLID_SECTION_FRAME)
      return;
    uLong crc = crc32(0, b->bytes + at, (uInt)(length + 12));
    for (int k = 0; k < 4; k++)
      b->bytes[at + 12 + length + (size_t)k] = (unsigned char)(crc >> 8 * k);
    at += length + TSI_TSOLID_SECTION_FRAME;
  }
}

static void mutate(buffer *b, int is_solid) {
  for (size_t k = 1 + below(3); k > 0 && b->size > 0; k--) {
    if (is_solid && below(4))
      mutate_word(b);
    else if (!is_solid && below(2))
      mutate_token(b);
    else
      mutate_bytes(b);
  }
  if (is_solid && below(8))
    repair(b);
}

/* ---- seeds -------------------------------------------------------------------------------------
 */

/* A solid with all free control points in one place: files know no geometry. */
static tsolid_solid *make_solid(tsolid_context *context, const tsolid_boundary *boundary) {
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_solid *solid = NULL;
  if (tsolid_tmesh_create(context, boundary, NULL, &tmesh) == TSOLID_OK &&
      tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK) {
    size_t n_free = (size_t)space->n_inner + (size_t)space->n_surface;
    double *control = calloc(n_free + (size_t)space->n_surface, 4 * sizeof *control);
    for (size_t k = 0; k < n_free; k++)
      control[4 * k + 3] = 1;
    memcpy(control + 4 * n_free, boundary->points, 4 * (size_t)space->n_surface * sizeof *control);
    tsolid_solid_from_control(context, space, control, &solid);
    free(control);
  }
  tsolid_tmesh_free(tmesh);
  tsolid_space_free(space);
  return solid;
}

/* The first patch as a T-spline, the second as Bezier elements, both on points of their own. */
static size_t make_mixed_seed(tsolid_context *context, const tsolid_boundary_input *input,
                              const tsolid_boundary *boundary, unsigned char *bytes) {
  enum { MOST = 64 };
  double points[8 * MOST], knots[2][MOST * 8];
  int point[MOST], function[MOST], n = 0;
  tsolid_patch patch[6];
  tsolid_bezier_boundary view;
  tsolid_placement place;
  memcpy(patch, input->patches, sizeof patch);
  tsolid_boundary_view(boundary, &view);
  tsolid_tspline t = {.degree = {patch[0].degree[0], patch[0].degree[1]},
                      .n_functions = patch[0].n_control[0] * patch[0].n_control[1],
                      .point = point,
                      .knots = {knots[0], knots[1]},
                      .domain = {patch[0].knots[0][0], patch[0].knots[0][patch[0].n_control[0]],
                                 patch[0].knots[1][0], patch[0].knots[1][patch[0].n_control[1]]}};
  if (!CHECK(t.n_functions <= MOST / 2 && t.degree[0] <= 6 && t.degree[1] <= 6))
    return 0;
  for (int i = 0; i < t.n_functions; i++, n++) {
    double w = patch[0].weights ? patch[0].weights[i] : 1.0;
    int at[2] = {i % patch[0].n_control[0], i / patch[0].n_control[0]};
    for (int d = 0; d < 2; d++) {
      size_t width = (size_t)t.degree[d] + 2;
      memcpy(knots[d] + (size_t)i * width, patch[0].knots[d] + at[d], width * sizeof(double));
    }
    for (int c = 0; c < 3; c++)
      points[4 * n + c] = w * patch[0].points[3 * i + c];
    points[4 * n + 3] = w;
    point[i] = n;
  }
  CHECK(tsolid_boundary_placement(boundary, 1, 0, &place) == TSOLID_OK);
  tsolid_bezier_side side = view.side[place.side];
  if (!CHECK(side.n_elements == 1 && side.function_start[1] <= MOST / 2))
    return 0;
  for (int i = 0; i < side.function_start[1]; i++) {
    memcpy(points + 4 * n, view.points + 4 * side.function[i], 4 * sizeof *points);
    function[i] = n++;
  }
  side.function = function;
  memset(&patch[0], 0, sizeof patch[0]);
  memset(&patch[1], 0, sizeof patch[1]);
  patch[0].tspline = &t;
  patch[1].bezier = &side;
  tsolid_boundary_input mixed = {.n_patches = 6, .patches = patch, .n_points = n, .points = points};
  CHECK(input->n_patches == 6 && tsolid_write_tsb(context, &mixed, path_in) == TSOLID_OK);
  return load(path_in, bytes);
}

/* Four seeds: patches, the same as Bezier elements, a solid, patches of all kinds. */
static int make_seeds(buffer *seed) {
  char path[1024];
  const char *root = getenv("TSOLID_SOURCE_DIR");
  tsolid_context *context = NULL;
  tsolid_boundary_file *file = NULL;
  tsolid_boundary *boundary = NULL;
  tsolid_solid *solid = NULL;
  tsolid_bezier_boundary view;
  snprintf(path, sizeof path, "%s/resources/examples/box.tsb", root ? root : ".");
  seed[0].size = load(path, seed[0].bytes);
  CHECK(tsolid_context_create(NULL, &context) == TSOLID_OK);
  CHECK(tsolid_read_tsb(context, path, &file) == TSOLID_OK);
  if (file)
    tsolid_boundary_create(context, tsolid_boundary_file_input(file), NULL, NULL, &boundary);
  if (CHECK(boundary != NULL)) {
    tsolid_boundary_view(boundary, &view);
    tsolid_boundary_input input = {.bezier = &view};
    CHECK(tsolid_write_tsb(context, &input, path_in) == TSOLID_OK);
    seed[1].size = load(path_in, seed[1].bytes);
    seed[3].size =
        make_mixed_seed(context, tsolid_boundary_file_input(file), boundary, seed[3].bytes);
    solid = make_solid(context, boundary);
  }
  if (CHECK(solid != NULL)) {
    CHECK(tsolid_write_tsolid(context, solid, path_in) == TSOLID_OK);
    seed[2].size = load(path_in, seed[2].bytes);
  }
  tsolid_solid_free(solid);
  tsolid_boundary_free(boundary);
  tsolid_boundary_file_free(file);
  tsolid_context_free(context);
  return seed[0].size && seed[1].size && seed[2].size && seed[3].size;
}

int main(int argc, char **argv) {
  static buffer seed[4], changed;
  long count = argc > 1 ? atol(argv[1]) : 1500, n_accepted[4] = {0, 0, 0, 0};
  random_state = (argc > 2 ? strtoull(argv[2], NULL, 10) : 1) * 0x9e3779b97f4a7c15u | 1;
  if (!CHECK(choose_paths()) || !CHECK(make_seeds(seed)))
    return check_done();
  for (int k = 0; k < 4; k++)
    CHECK(try_file(seed[k].bytes, seed[k].size));
  for (long k = 0; k < count && check_n_failed == 0; k++) {
    int which = (int)(k % 4);
    changed = seed[which];
    mutate(&changed, which == 2);
    n_accepted[which] += try_file(changed.bytes, changed.size);
  }
  printf("%ld files; accepted: %ld of patches, %ld of elements, %ld solids, %ld mixed\n", count,
         n_accepted[0], n_accepted[1], n_accepted[2], n_accepted[3]);
  if (check_n_failed) {
    printf("the file is kept: %s\n", path_in);
    return check_done();
  }
  unlink(path_in);
  unlink(path_out);
  unlink(path_again);
  *strrchr(path_in, '/') = 0;
  rmdir(path_in);
  return check_done();
}

#endif
