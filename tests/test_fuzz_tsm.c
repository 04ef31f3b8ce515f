/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Mutated .tsm files: a status and no crash (the sanitizers look on), memory in proportion to the
 * file, what is accepted is written back the same and evaluates; and every allocation fails once.
 *
 *   test_fuzz_tsm [count [seed]] */
#define _XOPEN_SOURCE 700
#include <stdlib.h>
#include <unistd.h>

#include "check.h"
#include "counted_memory.h"
#include "surface.h"

enum { MAX_FILE = 1 << 16, N_SEEDS = 3 };

static char path_in[80], path_out[80], path_again[80];

/* ---- files -------------------------------------------------------------------------------------
 */

typedef struct buffer {
  char bytes[MAX_FILE];
  size_t size;
} buffer;

static int store(const char *path, const buffer *b) {
  FILE *file = fopen(path, "wb");
  int stored = file && fwrite(b->bytes, 1, b->size, file) == b->size;
  return file && fclose(file) == 0 && stored;
}

static int load(const char *path, buffer *b) {
  FILE *file = fopen(path, "rb");
  b->size = file ? fread(b->bytes, 1, MAX_FILE, file) : 0;
  if (file)
    fclose(file);
  return b->size > 0 && b->size < MAX_FILE;
}

static int same_files(const char *a, const char *b) {
  static buffer p, q;
  return load(a, &p) && load(b, &q) && p.size == q.size && memcmp(p.bytes, q.bytes, p.size) == 0;
}

static int choose_paths(void) {
  const char *base = getenv("TMPDIR");
  char folder[64];
  snprintf(folder, sizeof folder, "%.40s/tsolid.XXXXXX", base ? base : "/tmp");
  if (!mkdtemp(folder))
    return 0;
  snprintf(path_in, sizeof path_in, "%s/in.tsm", folder);
  snprintf(path_out, sizeof path_out, "%s/out.tsm", folder);
  snprintf(path_again, sizeof path_again, "%s/again.tsm", folder);
  return 1;
}

/* ---- one file ----------------------------------------------------------------------------------
 */

static int explained(tsolid_context *context, tsolid_status status) {
  int n = tsolid_context_n_findings(context);
  return status == TSOLID_OK || (n > 0 && tsolid_context_finding(context, n - 1)->status == status);
}

static void use_surface(tsolid_context *context, const tsolid_surface *surface) {
  tsolid_surface *again = NULL;
  tsolid_boundary_file *patches = NULL;
  tsolid_boundary *boundary = NULL;
  double x[9];
  for (int f = 0; f < surface->n_faces; f++) {
    const double *size = surface->face_size + 2 * (size_t)f;
    if (surface->element_start[f] == surface->element_start[f + 1])
      continue;
    CHECK(tsolid_surface_evaluate(context, surface, f, 0.3 * size[0], size[1], 1, x) == TSOLID_OK);
    for (int k = 0; k < 3; k++)
      CHECK(isfinite(x[k]));
  }
  CHECK(tsolid_write_tsm(context, surface, path_out) == TSOLID_OK);
  CHECK(tsolid_read_tsm(context, path_out, &again) == TSOLID_OK);
  CHECK(again && tsolid_write_tsm(context, again, path_again) == TSOLID_OK);
  CHECK(same_files(path_out, path_again));
  CHECK(tsolid_surface_patches(context, surface, &patches) == TSOLID_OK && patches);
  tsolid_boundary_input input = {.surface = surface};
  tsolid_status status = tsolid_boundary_create(context, &input, NULL, NULL, &boundary);
  CHECK(!boundary == (status != TSOLID_OK) && explained(context, status));
  CHECK(status == TSOLID_OK || status == TSOLID_ERROR_REFUSED || status == TSOLID_ERROR_INPUT);
  tsolid_boundary_free(boundary);
  tsolid_boundary_file_free(patches);
  tsolid_surface_free(again);
}

/* Returns whether the file was accepted. */
static int try_file(const buffer *b) {
  meter m = {.limit = (size_t)1 << 30, .countdown = -1};
  tsolid_context *context = new_counted_context(&m);
  tsolid_surface *surface = NULL;
  if (!CHECK(store(path_in, b)))
    return 0;
  tsolid_status status = tsolid_read_tsm(context, path_in, &surface);
  CHECK(!surface == (status != TSOLID_OK) && explained(context, status));
  CHECK(status == TSOLID_OK || status == TSOLID_ERROR_INPUT || status == TSOLID_ERROR_REFUSED);
  CHECK(m.peak < 1000 * b->size + ((size_t)1 << 20));
  int accepted = surface != NULL;
  if (surface)
    use_surface(context, surface);
  tsolid_surface_free(surface);
  tsolid_context_free(context);
  CHECK(m.live == 0);
  return accepted;
}

/* Every allocation of reading, patches and writing fails once. */
static void starve(const buffer *b) {
  CHECK(store(path_in, b));
  for (long n = 0; n < 100000; n++) {
    meter m = {.limit = (size_t)1 << 30, .countdown = -1};
    tsolid_context *context = new_counted_context(&m);
    tsolid_surface *surface = NULL;
    tsolid_boundary_file *patches = NULL;
    m.countdown = n;
    tsolid_status status = tsolid_read_tsm(context, path_in, &surface);
    CHECK(!surface == (status != TSOLID_OK));
    if (!status)
      status = tsolid_surface_patches(context, surface, &patches);
    if (!status)
      status = tsolid_write_tsm(context, surface, path_out);
    CHECK(status == TSOLID_OK || status == TSOLID_ERROR_MEMORY);
    int done = m.countdown >= 0;
    tsolid_boundary_file_free(patches);
    tsolid_surface_free(surface);
    tsolid_context_free(context);
    CHECK(m.live == 0);
    if (done) {
      CHECK(status == TSOLID_OK);
      return;
    }
  }
}

/* ---- mutation ----------------------------------------------------------------------------------
 */

static uint64_t random_state;

static size_t below(size_t n) { /* xorshift64* (Vigna 2016); n > 0 */
  random_state ^= random_state >> 12;
  random_state ^= random_state << 25;
  random_state ^= random_state >> 27;
  return (size_t)((random_state * 2685821657736338717u >> 16) % n);
}

static void replace(buffer *b, size_t at, size_t length, const void *with, size_t n) {
  if (b->size - length + n >= MAX_FILE)
    return;
  memmove(b->bytes + at + n, b->bytes + at + length, b->size - at - length);
  memcpy(b->bytes + at, with, n);
  b->size = b->size - length + n;
}

static void mutate_bytes(buffer *b) {
  static char piece[256];
  size_t at = below(b->size), n = 1 + below(below(16) ? 16 : 256);
  n = n < b->size - at ? n : b->size - at;
  switch (below(5)) {
  case 0:
    b->bytes[at] = (char)(b->bytes[at] ^ 1 << below(7));
    break;
  case 1:
    b->bytes[at] = (char)below(256);
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
  }
}

static int in_word(char c) {
  return c != ' ' && c != '\n' && c != '\r';
}

/* A word becomes another one, small numbers before all: they name other records. */
static void mutate_word(buffer *b) {
  static const char *const other[] = {
      "0",   "1",           "2",   "3",    "4",  "5",  "6",  "7",    "8",     "12",    "-1",
      "0.5", "0",           "1e9", "1e-9", "-0", "9",  "20", "EAST", "f",     "0m gv", "l",
      "nan", "99999999999", "#",   "\n",   "e",  "0g", "ec", "2",    "1e300", "WEST"};
  size_t at = below(b->size), end;
  while (at > 0 && in_word(b->bytes[at - 1]))
    at--;
  for (end = at; end < b->size && in_word(b->bytes[end]);)
    end++;
  const char *with = other[below(sizeof other / sizeof *other)];
  replace(b, at, end - at, with, below(8) ? strlen(with) : 0);
}

/* One interval in all the records that have it: often a sound mesh again. */
static void mutate_intervals(buffer *b) {
  static const char *const other[] = {"0", "0.25", "3", "1e-12", "1e12"};
  const char *with = other[below(5)];
  for (size_t at = 0; at + 4 < b->size; at++)
    if (b->bytes[at] == '\n' && b->bytes[at + 1] == 'e' && b->bytes[at + 2] == ' ' && below(3)) {
      size_t first = at + 3, end;
      while (first < b->size && in_word(b->bytes[first]))
        first++;
      for (end = ++first; end < b->size && in_word(b->bytes[end]);)
        end++;
      if (first < b->size && end <= b->size)
        replace(b, first, end - first, with, strlen(with));
    }
}

static void mutate(buffer *b) {
  if (below(16) == 0)
    mutate_intervals(b);
  for (size_t k = 1 + below(3); k > 0 && b->size > 0; k--) {
    if (below(3))
      mutate_word(b);
    else
      mutate_bytes(b);
  }
}

/* ---- seeds -------------------------------------------------------------------------------------
 */

static void add(buffer *b, const char *text) {
  size_t n = strlen(text);
  if (b->size + n < MAX_FILE) {
    memcpy(b->bytes + b->size, text, n);
    b->size += n;
  }
}

/* One face of a strip of n with a T-junction between each two over one wide face. */
static void make_open(buffer *b, int n, int ends) {
  char line[128];
  int n_links = 4 * n + n + 3, outer = n_links, k = 0;
  add(b, "#TS0200\ndegree 3\nunits 1 meters\n");
  /* vertices: 0 .. n below the strip (0 and n corners of the wide face), n+1 .. 2n+1 above it,
   * 2n+2, 2n+3 the lower corners of the wide face. Links of small face i: 4i + (low, right, top,
   * left); of the wide face from 4n on: bottom, right, n parts of the top, left. */
  for (int i = 0; i < n; i++) {
    snprintf(line, sizeof line, "f %d 0\n", 4 * i);
    add(b, line);
  }
  snprintf(line, sizeof line, "f %d 0\n", 4 * n);
  add(b, line);
  /* edges: low i, top i, upright 0 .. n, bottom, right, left of the wide face */
  for (int i = 0; i < n; i++) {
    snprintf(line, sizeof line, "e %d 0.5\n", 4 * i);
    add(b, line);
  }
  for (int i = 0; i < n; i++) {
    snprintf(line, sizeof line, "e %d 0.5\n", 4 * i + 2);
    add(b, line);
  }
  for (int i = 0; i <= n; i++) {
    snprintf(line, sizeof line, "e %d 1\n", i < n ? 4 * i + 3 : 4 * n - 3);
    add(b, line);
  }
  snprintf(line, sizeof line, "e %d %g\ne %d 1\ne %d 1\n", 4 * n, 0.5 * n, 4 * n + 1, 5 * n + 2);
  add(b, line);
  for (int i = 0; i <= n; i++) {
    snprintf(line, sizeof line, "v %d %s\n", i < n ? 4 * i : 4 * n - 3, i < n ? "EAST" : "NORTH");
    add(b, line);
  }
  for (int i = 0; i <= n; i++) {
    snprintf(line, sizeof line, "v %d %s\n", i == 0 ? 3 : 4 * i - 2, i == 0 ? "SOUTH" : "WEST");
    add(b, line);
  }
  snprintf(line, sizeof line, "v %d EAST\nv %d NORTH\n", 4 * n, 4 * n + 1);
  add(b, line);
  /* border links, against the clock seen from outside: top of the small faces from the right, ...
   * numbered outer + 0: left of small 0; +1: left of wide; +2: bottom; +3: right of wide; +4: right
   * of the last small; +5 + i: top of small i */
  for (int i = 0; i < n; i++) {
    int low = 4 * n + 2 + (n - 1 - i), first = 4 * i;
    snprintf(line, sizeof line, "l %d %d %d %d %d %d 0\n", first + 3, first + 1, low, i, i, i);
    add(b, line);
    snprintf(line, sizeof line, "l %d %d %d %d %d %d 0\n", first, first + 2,
             i + 1 < n ? first + 7 : outer + 4, i + 1, i, 2 * n + i + 1);
    add(b, line);
    snprintf(line, sizeof line, "l %d %d %d %d %d %d 0\n", first + 1, first + 3, outer + 5 + i,
             n + 2 + i, i, n + i);
    add(b, line);
    snprintf(line, sizeof line, "l %d %d %d %d %d %d 0\n", first + 2, first,
             i > 0 ? first - 3 : outer, n + 1 + i, i, 2 * n + i);
    add(b, line);
  }
  snprintf(line, sizeof line, "l %d %d %d %d %d %d 0\n", 5 * n + 2, 4 * n + 1, outer + 2, 2 * n + 2,
           n, 3 * n + 1);
  add(b, line);
  snprintf(line, sizeof line, "l %d %d %d %d %d %d 0\n", 4 * n, 4 * n + 2, outer + 3, 2 * n + 3, n,
           3 * n + 2);
  add(b, line);
  for (int i = n - 1; i >= 0; i--) {
    int at = 4 * n + 2 + (n - 1 - i);
    snprintf(line, sizeof line, "l %d %d %d %d %d %d %d\n", at - 1, at + 1, 4 * i, i + 1, n, i,
             i + 1 < n);
    add(b, line);
  }
  snprintf(line, sizeof line, "l %d %d %d 0 %d %d 0\n", 5 * n + 1, 4 * n, outer + 1, n, 3 * n + 3);
  add(b, line);
  const int top = outer + 5;
  const int link[5][5] = {{outer + 1, top, 3, 0, 2 * n},
                          {outer + 2, outer, 5 * n + 2, 2 * n + 2, 3 * n + 3},
                          {outer + 3, outer + 1, 4 * n, 2 * n + 3, 3 * n + 1},
                          {outer + 4, outer + 2, 4 * n + 1, n, 3 * n + 2},
                          {top + n - 1, outer + 3, 4 * n - 3, 2 * n + 1, 3 * n}};
  for (k = 0; k < 5; k++) {
    snprintf(line, sizeof line, "l %d %d %d %d -1 %d 1\n", link[k][0], link[k][1], link[k][2],
             link[k][3], link[k][4]);
    add(b, line);
  }
  for (k = 0; k < n; k++) {
    snprintf(line, sizeof line, "l %d %d %d %d -1 %d 1\n", k > 0 ? top + k - 1 : outer,
             k + 1 < n ? top + k + 1 : outer + 4, 4 * k + 2, n + 1 + k, n + k);
    add(b, line);
  }
  if (ends)
    add(b, "0m odd-grip-map\n");
  for (k = 0; ends && k < 2 * n + 4; k++) {
    snprintf(line, sizeof line, "0m gvp %d\n", k);
    add(b, line);
  }
  if (ends) { /* one more control point inwards at the lower left corner, in each direction */
    snprintf(line, sizeof line, "0m gv %d\n0m gv %d\n0m gv %d\n0m cg %d 4 1 0 0 1 %d %d %d\n",
             2 * n + 2, 2 * n + 2, 2 * n + 2, 2 * n + 2, 2 * n + 4, 2 * n + 5, 2 * n + 6);
    add(b, line);
  }
  for (k = 0; k < 2 * n + 4 + (ends ? 3 : 0); k++) {
    snprintf(line, sizeof line, "0g %d %d %g 1\n", k % (n + 1), k / (n + 1), 0.1 * (k % 3));
    add(b, line);
  }
  add(b, "tol 1e-05\n");
}

/* The cube of six faces: eight stars. */
static void make_cube(buffer *b) {
  static const int quad[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                 {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  char line[128];
  int n_edges = 0, edge[24], opposite[24], start[8];
  add(b, "#TS0200\ndegree 3\n");
  for (int f = 0; f < 6; f++) {
    snprintf(line, sizeof line, "f %d 0\n", 4 * f);
    add(b, line);
  }
  for (int i = 0; i < 24; i++) {
    int p = quad[i / 4][i % 4], q = quad[i / 4][(i + 1) % 4];
    start[p] = i;
    for (int k = 0; k < 24; k++)
      if (quad[k / 4][k % 4] == q && quad[k / 4][(k + 1) % 4] == p) {
        opposite[i] = k;
        edge[i] = k < i ? edge[k] : n_edges;
        if (k > i) {
          n_edges++;
          snprintf(line, sizeof line, "e %d 1\n", i);
          add(b, line);
        }
      }
  }
  for (int v = 0; v < 8; v++) {
    snprintf(line, sizeof line, "v %d NORTH\n", start[v]);
    add(b, line);
  }
  for (int i = 0; i < 24; i++) {
    int first = i - i % 4;
    snprintf(line, sizeof line, "l %d %d %d %d %d %d 0\n", first + (i + 3) % 4, first + (i + 1) % 4,
             opposite[i], quad[i / 4][i % 4], i / 4, edge[i]);
    add(b, line);
  }
  for (int v = 0; v < 8; v++) {
    snprintf(line, sizeof line, "0g %d %d %d 1\n", v & 1, v >> 1 & 1, v >> 2);
    add(b, line);
  }
}

int main(int argc, char **argv) {
  static buffer seed[N_SEEDS], changed;
  long count = argc > 1 ? atol(argv[1]) : 3000, n_accepted = 0;
  random_state = (argc > 2 ? strtoull(argv[2], NULL, 10) : 1) * 0x9e3779b97f4a7c15u | 1;
  if (!CHECK(choose_paths()))
    return check_done();
  make_open(&seed[0], 3, 0);
  make_open(&seed[1], 4, 1);
  make_cube(&seed[2]);
  for (int k = 0; k < N_SEEDS; k++)
    CHECK(try_file(&seed[k]));
  for (int k = 0; k < N_SEEDS; k++)
    starve(&seed[k]);
  for (long k = 0; k < count && check_n_failed == 0; k++) {
    changed = seed[k % N_SEEDS];
    mutate(&changed);
    n_accepted += try_file(&changed);
  }
  printf("%ld files, %ld accepted\n", count, n_accepted);
  CHECK(n_accepted > count / 50);
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
