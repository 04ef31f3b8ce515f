/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Files: what is written reads back bit for bit, in any locale; what is malformed is refused with
 * its place; what fails leaves the disk and the memory as they were. */
#define _XOPEN_SOURCE 700
#include <dirent.h>
#include <locale.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "check.h"
#include "file_io.h"
#include "tsolid_format.h"

static char folder[64];

static const char *in_folder(const char *name) {
  static char path[4][512];
  static int next;
  char *p = path[next++ % 4];
  snprintf(p, sizeof path[0], "%s/%s", folder, name);
  return p;
}

static int count_files(void) {
  int n = 0;
  DIR *directory = opendir(folder);
  for (struct dirent *entry; directory && (entry = readdir(directory));)
    n += entry->d_name[0] != '.';
  closedir(directory);
  return n;
}

static void write_bytes(const char *path, const void *bytes, size_t size) {
  FILE *file = fopen(path, "wb");
  CHECK(file && fwrite(bytes, 1, size, file) == size);
  if (file)
    fclose(file);
}

static char *read_bytes(const char *path, size_t *size) {
  FILE *file = fopen(path, "rb");
  char *bytes = NULL;
  *size = 0;
  if (file) {
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    bytes = malloc(*size + 1);
    if (fread(bytes, 1, *size, file) != *size)
      *size = 0;
    bytes[*size] = 0;
    fclose(file);
  }
  return bytes;
}

static int same_bytes(const char *a, const char *b) {
  size_t n, m;
  char *p = read_bytes(a, &n), *q = read_bytes(b, &m);
  int same = p && q && n > 0 && n == m && memcmp(p, q, n) == 0;
  free(p);
  free(q);
  return same;
}

static const char *last_text(const tsolid_context *context) {
  int n = tsolid_context_n_findings(context);
  return n ? tsolid_context_finding(context, n - 1)->text : "";
}

/* ---- numbers ------------------------------------------------------------------------------ */

static uint64_t random_state = 1;

static uint64_t next_random(void) { /* xorshift64* (Vigna 2016) */
  random_state ^= random_state >> 12;
  random_state ^= random_state << 25;
  random_state ^= random_state >> 27;
  return random_state * 2685821657736338717u;
}

/* Any finite double, all exponents alike. */
static double random_double(void) {
  for (;;) {
    uint64_t bits = next_random();
    double value;
    memcpy(&value, &bits, sizeof value);
    if (isfinite(value))
      return value;
  }
}

static void test_numbers(void) {
  static const double hard[] = {0.0,
                                -0.0,
                                0.1,
                                1.0 / 3.0,
                                5e-324,
                                2.2250738585072011e-308,
                                1.7976931348623157e308,
                                9007199254740993.0,
                                1e23,
                                -123456.789};
  char text[TSI_NUMBER_SIZE];
  const char *end;
  int n_wrong = 0;
  for (size_t k = 0; k < 20000; k++) {
    double value = k < sizeof hard / sizeof *hard ? hard[k] : random_double();
    size_t length = tsi_number_print(value, text);
    double back = tsi_number_parse(text, &end);
    n_wrong += memcmp(&back, &value, sizeof back) != 0 || end != text + length ||
               strchr(text, ',') != NULL || length != strlen(text);
  }
  CHECK(n_wrong == 0);
  tsi_number_print(0.1, text);
  CHECK(strcmp(text, "0.1") == 0);
}

/* ---- .tsb: round trips -------------------------------------------------------------------------
 */

enum { N_HARD = 12 };

/* A patch whose numbers are as hard to print as any; that it is no surface is not the files'
 * business. */
static void test_tsb_patches(tsolid_context *context) {
  double number[2][40], weight[N_HARD], knot[2][8];
  for (int k = 0; k < 40; k++) {
    number[0][k] = random_double();
    number[1][k] = random_double();
  }
  for (int k = 0; k < N_HARD; k++)
    weight[k] = random_double();
  for (int k = 0; k < 8; k++) {
    knot[0][k] = k / 7.0;
    knot[1][k] = random_double();
  }
  tsolid_patch patch[2] = {{.degree = {2, 1},
                            .n_control = {4, 3},
                            .knots = {knot[0], knot[1]},
                            .points = number[0],
                            .weights = weight,
                            .name = "a \"b\"\\c\n\t\x01 \xc3\xa4 \xf0\x9f\x98\x80",
                            .border_name = {"E1", NULL, "E 3", "E4"},
                            .border_tolerance = {0, 1e-5, 0.1, 3}},
                           {.degree = {1, 2},
                            .n_control = {3, 4},
                            .knots = {knot[1], knot[0]},
                            .points = number[1],
                            .corner_name = {"V1", "V2", "V3", "V4"}}};
  tsolid_boundary_input input = {.n_patches = 2, .patches = patch};
  tsolid_boundary_file *file;
  CHECK(tsolid_write_tsb(context, &input, in_folder("a.tsb")) == TSOLID_OK);
  CHECK(tsolid_read_tsb(context, in_folder("a.tsb"), &file) == TSOLID_OK);
  if (!file)
    return;
  const tsolid_boundary_input *read = tsolid_boundary_file_input(file);
  CHECK(read->n_patches == 2 && !read->bezier);
  const tsolid_patch *p = read->patches;
  CHECK(memcmp(p[0].points, number[0], 36 * sizeof(double)) == 0);
  CHECK(memcmp(p[1].points, number[1], 36 * sizeof(double)) == 0);
  CHECK(memcmp(p[0].weights, weight, sizeof weight) == 0 && !p[1].weights);
  CHECK(memcmp(p[0].knots[0], knot[0], 7 * sizeof(double)) == 0);
  CHECK(memcmp(p[0].knots[1], knot[1], 5 * sizeof(double)) == 0);
  CHECK(strcmp(p[0].name, patch[0].name) == 0 && !p[1].name);
  CHECK(!p[0].border_name[1] && strcmp(p[0].border_name[2], "E 3") == 0 && !p[0].corner_name[0]);
  CHECK(strcmp(p[1].corner_name[3], "V4") == 0 && !p[1].border_name[0]);
  CHECK(p[0].border_tolerance[2] == 0.1 && p[1].border_tolerance[0] == 0);
  CHECK(tsolid_write_tsb(context, read, in_folder("b.tsb")) == TSOLID_OK);
  CHECK(same_bytes(in_folder("a.tsb"), in_folder("b.tsb")));
  tsolid_boundary_file_free(file);
}

/* Six sides of 1, 2, ... 6 elements with 1, 2, ... functions, degrees 1 x 2. */
static void test_tsb_bezier(tsolid_context *context) {
  static double points[7 * 4], box[6 * 4], coefficient[21 * 6];
  static int start[7], function[21];
  for (int k = 0; k < 21 * 6; k++)
    coefficient[k] = random_double();
  for (int k = 0; k < 28; k++)
    points[k] = random_double();
  for (int k = 0; k < 24; k++)
    box[k] = random_double();
  for (int e = 0; e < 6; e++)
    start[e + 1] = start[e] + e + 1;
  for (int k = 0; k < 21; k++)
    function[k] = k % 7;
  tsolid_bezier_boundary bezier = {.n_functions = 7, .points = points};
  for (int k = 0; k < 6; k++)
    bezier.side[k] = (tsolid_bezier_side){.degree = {1, 2},
                                          .n_elements = k + 1,
                                          .box = box,
                                          .function_start = start,
                                          .function = function,
                                          .coefficient = coefficient};
  tsolid_boundary_input input = {.bezier = &bezier};
  tsolid_boundary_file *file;
  CHECK(tsolid_write_tsb(context, &input, in_folder("a.tsb")) == TSOLID_OK);
  CHECK(tsolid_read_tsb(context, in_folder("a.tsb"), &file) == TSOLID_OK);
  if (!file)
    return;
  const tsolid_bezier_boundary *b = tsolid_boundary_file_input(file)->bezier;
  CHECK(b->n_functions == 7 && memcmp(b->points, points, sizeof points) == 0);
  for (int k = 0; k < 6; k++) {
    const tsolid_bezier_side *side = &b->side[k];
    size_t n = (size_t)start[k + 1];
    CHECK(side->n_elements == k + 1 && side->degree[0] == 1 && side->degree[1] == 2);
    CHECK(memcmp(side->box, box, 32 * (size_t)(k + 1)) == 0);
    CHECK(memcmp(side->function_start, start, sizeof(int) * (size_t)(k + 2)) == 0);
    CHECK(memcmp(side->function, function, sizeof(int) * n) == 0);
    CHECK(memcmp(side->coefficient, coefficient, sizeof(double) * 6 * n) == 0);
  }
  tsolid_boundary_file_free(file);
}

/* The document's tolerance reaches the borders that have none of their own. */
static void test_tsb_tolerance(tsolid_context *context) {
  static const char text[] =
      "\xEF\xBB\xBF{\"patches\": [{\"points\": [[0,0,0],[1,0,0],[0,1,0],[1,1,0]],\r\n"
      "\"n_control\":[2,2], \"degree\":[1,1.0], \"knots\":[[0,0,1,1],[0,0,1E0,10e-1]],"
      "\"border_tolerance\": [0, 2, 0, 3]}], \"tolerance\": 0.5,"
      "\"version\": 1, \"format\": \"tsolid boundary\"}\n";
  tsolid_boundary_file *file;
  write_bytes(in_folder("t.tsb"), text, sizeof text - 1);
  CHECK(tsolid_read_tsb(context, in_folder("t.tsb"), &file) == TSOLID_OK);
  if (!file)
    return;
  const double *tolerance = tsolid_boundary_file_input(file)->patches[0].border_tolerance;
  CHECK(tolerance[0] == 0.5 && tolerance[1] == 2 && tolerance[2] == 0.5 && tolerance[3] == 3);
  tsolid_boundary_file_free(file);
}

/* ---- .tsb: malformed ---------------------------------------------------------------------------
 */

#define HEAD "{\"format\": \"tsolid boundary\", \"version\": 1,\n"
#define PATCH(degree, n, knots, points, more)                                                      \
  HEAD "\"patches\": [{\"degree\": " degree ", \"n_control\": " n ", \"knots\": " knots            \
       ",\n\"points\": " points more "}]}"
#define KNOTS "[[0,0,1,1],[0,0,1,1]]"
#define POINTS "[[0,0,0],[1,0,0],[0,1,0],[1,1,0]]"
#define GOOD PATCH("[1,1]", "[2,2]", KNOTS, POINTS, "")
#define SIDE(degree, functions, coefficients)                                                      \
  "{\"degree\": " degree ", \"elements\": [{\"box\": [0,1,0,1], \"functions\": " functions         \
  ", \"coefficients\": " coefficients "}]}"
#define SIDE_OK SIDE("[1,1]", "[0]", "[[1,1,1,1]]")
#define BEZIER(side)                                                                               \
  HEAD "\"bezier\": {\"points\": [[0,0,0,1]], \"sides\": [" side "," SIDE_OK "," SIDE_OK           \
       "," SIDE_OK "," SIDE_OK "," SIDE_OK "]}}"

static void test_tsb_malformed(tsolid_context *context) {
  /* the text, its place, what the message must say */
  static const struct {
    const char *text;
    int line;
    const char *says;
  } bad[] = {
      {"", 1, "end of the file"},
      {"\n\n\"tsolid boundary\"", 3, "expected an object, found a string"},
      {"[]", 1, "expected an object, found a list"},
      {"\x89TSOL", 1, "byte 0x89"},
      {"{\"format\": \"other\"}", 1, "format: the format is not"},
      {HEAD "\"version\": 1}", 2, "version: this key stands here twice"},
      {"{\"format\": \"tsolid boundary\", \"version\": 2}", 1, "version 2 is not known"},
      {"{\"version\": 1}", 1, "'format' is missing"},
      {HEAD "\"comment\": 1}", 2, "comment: unknown key"},
      {HEAD "\"\\u0070atches\": []}", 2, "unknown key"},
      {HEAD "\"patches\": []}", 2, "empty"},
      {HEAD "\"tolerance\": 1}", 2, "exactly one of"},
      {HEAD "\"tolerance\": 0, \"patches\": []}", 2, "positive"},
      {HEAD "\"tolerance\": 1, \"bezier\": {\"points\": [[0,0,0,1]], \"sides\": [" SIDE_OK
            "," SIDE_OK "," SIDE_OK "," SIDE_OK "," SIDE_OK "," SIDE_OK "]}}",
       2, "no meaning"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"weights\": [1,1,1,NaN]"), 3,
       "patches[0].weights[3]: expected a number"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"weights\": [1,1,1,-Infinity]"), 3, "malformed"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"weights\": [1,1,1,null]"), 3, "a word"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"weights\": [1,1,1]"), 3,
       "expected 4 weights, found 3"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"name\": 7"), 3, "expected a string"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"name\": \"a\nb\""), 3, "control character"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"name\": \"\xff\""), 3, "not UTF-8"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"name\": \"\xc0\x80\""), 3, "not UTF-8"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"name\": \"\xed\xa0\x80\""), 3, "not UTF-8"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"name\": \"\\u0000\""), 3, "malformed escape"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"name\": \"\\ud800x\""), 3, "malformed escape"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"name\": \"\\q\""), 3, "malformed escape"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"border_names\": [\"a\"]"), 3, "4 names"},
      {PATCH("[1,1]", "[2,2]", KNOTS, POINTS, ", \"border_tolerance\": [0,0,0,-1]"), 3, "negative"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0],[1,1]]", ""), 3,
       "points[3]: expected 3 numbers, found 2"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0]]", ""), 3, "expected 4 points"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0],[1,1,1e999]]", ""), 3,
       "points[3][2]: number out of range"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0],[1,1,0x1]]", ""), 3, "malformed"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0],[1,1,01]]", ""), 3, "malformed"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0],[1,1,1.]]", ""), 3, "malformed"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0],[1,1,1e]]", ""), 3, "malformed"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0],[1,1,-]]", ""), 3, "malformed"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0],[1,1,+1]]", ""), 3, "found '+'"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0],[1,1,1,5]]", ""), 3, "found 4"},
      {PATCH("[1,1]", "[2,2]", KNOTS, "[[0,0,0],[1,0,0],[0,1,0],[1,1,1],]", ""), 3, "found ']'"},
      {PATCH("[1,1]", "[2,2]", "[[0,0,1,1]]", POINTS, ""), 2, "2 knot vectors, found 1"},
      {PATCH("[1,1]", "[2,2]", "[[0,0,1,1],[0,1]]", POINTS, ""), 3, "expected 4 knots"},
      {PATCH("[1,26]", "[2,2]", KNOTS, POINTS, ""), 2, "degree[1]: 26 is not between 1 and 25"},
      {PATCH("[1,0]", "[2,2]", KNOTS, POINTS, ""), 2, "degree[1]: 0 is not"},
      {PATCH("[1,1.5]", "[2,2]", KNOTS, POINTS, ""), 2, "whole number"},
      {PATCH("[1,1]", "[-2,2]", KNOTS, POINTS, ""), 2, "n_control[0]: -2 is not"},
      {PATCH("[1,1]", "[2147483648,2]", KNOTS, POINTS, ""), 2, "n_control[0]"},
      {PATCH("[1,1]", "[1e300,2]", KNOTS, POINTS, ""), 2, "n_control[0]"},
      {PATCH("[1,1]", "[268435456,268435456]", KNOTS, POINTS, ""), 3, "knots"},
      {PATCH("[2,1]", "[2,2]", KNOTS, POINTS, ""), 3, "at least 3 control points"},
      {HEAD "\"patches\": [{\"degree\": [1,1]}]}", 2, "'n_control' is missing"},
      {HEAD "\"patches\": [[[[[[[[[[[[[[[[[[[[[[[[[[[[", 2, "expected an object, found a list"},
      {GOOD "\n\n{}", 5, "expected the end of the file"},
      {GOOD "\n,", 4, "expected the end of the file"},
      {BEZIER(SIDE("[1,1]", "[0]", "[[1,1,1]]")), 2, "need 4 coefficients per function, not 3"},
      {BEZIER(SIDE("[1,1]", "[0]", "[]")), 2, "1 functions, but 0 lists"},
      {BEZIER(SIDE("[1,1]", "[1]", "[[1,1,1,1]]")), 2, "function 1 of only 1 points"},
      {BEZIER(SIDE("[1,1]", "[-1]", "[[1,1,1,1]]")), 2, "-1 is not between"},
      {BEZIER(SIDE("[1,1]", "[0,0]", "[[1,1,1,1],[1,1,1]]")), 2, "coefficients[1]"},
      {BEZIER("{\"degree\": [1,1], \"elements\": []}"), 2, "no elements"},
      {BEZIER(SIDE_OK "," SIDE_OK), 2, "expected 6 sides, found more"},
  };
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
    tsolid_boundary_file *file = (tsolid_boundary_file *)folder;
    tsolid_context_clear(context);
    write_bytes(in_folder("x.tsb"), bad[k].text, strlen(bad[k].text));
    int passed = CHECK(tsolid_read_tsb(context, in_folder("x.tsb"), &file) == TSOLID_ERROR_INPUT);
    passed &= CHECK(!file && tsolid_context_n_findings(context) == 1);
    const tsolid_finding *finding = tsolid_context_finding(context, 0);
    passed &= CHECK(finding && finding->entity == TSOLID_ENTITY_LINE &&
                    finding->index[0] == bad[k].line && strstr(finding->text, bad[k].says));
    if (!passed)
      fprintf(stderr, "    case %zu, '%s', line %d: %s\n", k, bad[k].says, bad[k].line,
              last_text(context));
  }
}

/* Every prefix of a good file is malformed, and none makes the reader look beyond its end. */
static void test_tsb_truncated(tsolid_context *context) {
  static const char *const whole[] = {GOOD, BEZIER(SIDE_OK)};
  int n_accepted = 0;
  for (int k = 0; k < 2; k++)
    for (size_t n = 0; n < strlen(whole[k]); n++) {
      tsolid_boundary_file *file;
      tsolid_context_clear(context);
      write_bytes(in_folder("x.tsb"), whole[k], n);
      n_accepted += tsolid_read_tsb(context, in_folder("x.tsb"), &file) != TSOLID_ERROR_INPUT;
    }
  CHECK(n_accepted == 0);
  tsolid_context_clear(context);
}

/* What cannot be written is no file: numbers that are none, names that are no text. */
static void test_tsb_refuses_to_write(tsolid_context *context) {
  double number[12] = {0}, knot[4] = {0, 0, 1, 1};
  tsolid_patch patch = {
      .degree = {1, 1}, .n_control = {2, 2}, .knots = {knot, knot}, .points = number};
  tsolid_boundary_input input = {.n_patches = 1, .patches = &patch};
  const char *path = in_folder("bad.tsb");
  int n_files = count_files();
  number[7] = NAN;
  CHECK(tsolid_write_tsb(context, &input, path) == TSOLID_ERROR_INPUT);
  number[7] = -INFINITY;
  CHECK(tsolid_write_tsb(context, &input, path) == TSOLID_ERROR_INPUT);
  number[7] = 0;
  patch.name = "\xff";
  CHECK(tsolid_write_tsb(context, &input, path) == TSOLID_ERROR_INPUT);
  patch.name = NULL;
  patch.n_control[0] = 1;
  CHECK(tsolid_write_tsb(context, &input, path) == TSOLID_ERROR_ARGUMENT);
  patch.n_control[0] = 2;
  input.n_patches = 0;
  CHECK(tsolid_write_tsb(context, &input, path) == TSOLID_ERROR_ARGUMENT);
  CHECK(count_files() == n_files);
  tsolid_context_clear(context);
}

/* ---- the operating system says no --------------------------------------------------------------
 */

static void check_refused(tsolid_context *context, const tsolid_boundary_input *input,
                          const char *path, const char *says) {
  tsolid_context_clear(context);
  CHECK(tsolid_write_tsb(context, input, path) == TSOLID_ERROR_IO);
  if (!CHECK(strstr(last_text(context), says) && strstr(last_text(context), path)))
    fprintf(stderr, "    %s\n", last_text(context));
}

/* A file size limit stands in for a full disk: it works for root, too. */
static void test_full_disk(tsolid_context *context, const tsolid_boundary_input *input) {
  struct rlimit old, small;
  const char *path = in_folder("kept.tsb");
  int n_files;
  size_t size;
  CHECK(getrlimit(RLIMIT_FSIZE, &old) == 0);
  write_bytes(path, "kept", 4);
  n_files = count_files();
  signal(SIGXFSZ, SIG_IGN);
  small = (struct rlimit){.rlim_cur = 100, .rlim_max = old.rlim_max};
  CHECK(setrlimit(RLIMIT_FSIZE, &small) == 0);
  check_refused(context, input, path, "File too large");
  CHECK(setrlimit(RLIMIT_FSIZE, &old) == 0);
  char *bytes = read_bytes(path, &size);
  CHECK(bytes && strcmp(bytes, "kept") == 0);
  CHECK(count_files() == n_files);
  free(bytes);
}

static void test_operating_system(tsolid_context *context) {
  double number[12] = {0}, knot[4] = {0, 0, 1, 1};
  tsolid_patch patch = {
      .degree = {1, 1}, .n_control = {2, 2}, .knots = {knot, knot}, .points = number};
  tsolid_boundary_input input = {.n_patches = 1, .patches = &patch};
  tsolid_boundary_file *file;
  check_refused(context, &input, folder, "a directory");
  check_refused(context, &input, "/dev/null", "not a regular file");
  check_refused(context, &input, in_folder("none/x.tsb"), "No such file");
  check_refused(context, &input, "", "No such file");
  write_bytes(in_folder("file"), "x", 1);
  check_refused(context, &input, in_folder("file/x.tsb"), "Not a directory");
  if (geteuid() != 0) {
    chmod(in_folder("file"), 0444);
    check_refused(context, &input, in_folder("file"), "Permission denied");
  } else {
    printf("skipped: a write-protected file, because root may write it\n");
  }
  test_full_disk(context, &input);
  CHECK(tsolid_read_tsb(context, folder, &file) == TSOLID_ERROR_IO && !file);
  CHECK(strstr(last_text(context), "a directory") != NULL);
  CHECK(tsolid_read_tsb(context, in_folder("none"), &file) == TSOLID_ERROR_IO && !file);
  CHECK(strstr(last_text(context), "No such file") != NULL);
  /* A link stays one, and what it points to is replaced. */
  CHECK(symlink("linked.tsb", in_folder("link.tsb")) == 0);
  write_bytes(in_folder("linked.tsb"), "old", 3);
  CHECK(tsolid_write_tsb(context, &input, in_folder("link.tsb")) == TSOLID_OK);
  struct stat about;
  CHECK(lstat(in_folder("link.tsb"), &about) == 0 && S_ISLNK(about.st_mode));
  CHECK(tsolid_read_tsb(context, in_folder("linked.tsb"), &file) == TSOLID_OK);
  tsolid_boundary_file_free(file);
  tsolid_context_clear(context);
}

/* ---- solids ------------------------------------------------------------------------------------
 */

/* Control points out of the blue: files know no geometry. */
static tsolid_solid *fill_solid(tsolid_context *context, const tsolid_space *space) {
  size_t n_free = (size_t)space->n_inner + (size_t)space->n_surface;
  double *control = malloc(4 * (n_free + (size_t)space->n_surface) * sizeof *control);
  tsolid_solid *solid = NULL;
  for (size_t k = 0; k < 4 * n_free; k++) {
    double unit = (double)(next_random() >> 11) / 9007199254740992.0;
    control[k] = k % 4 == 3 ? 0.5 + unit : 2 * unit - 1;
  }
  memcpy(control + 4 * n_free, space->boundary->points,
         4 * (size_t)space->n_surface * sizeof *control);
  CHECK(tsolid_solid_from_control(context, space, control, &solid) == TSOLID_OK);
  free(control);
  return solid;
}

static tsolid_solid *make_solid(tsolid_context *context, const char *example) {
  char path[1024];
  const char *root = getenv("TSOLID_SOURCE_DIR");
  tsolid_boundary_file *file = NULL;
  tsolid_boundary *boundary = NULL;
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_solid *solid = NULL;
  snprintf(path, sizeof path, "%s/resources/examples/%s.tsb", root ? root : ".", example);
  if (tsolid_read_tsb(context, path, &file) == TSOLID_OK &&
      tsolid_boundary_create(context, tsolid_boundary_file_input(file), NULL, NULL, &boundary) ==
          TSOLID_OK &&
      tsolid_tmesh_create(context, boundary, NULL, &tmesh) == TSOLID_OK &&
      tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK)
    solid = fill_solid(context, space);
  if (!CHECK(solid != NULL))
    fprintf(stderr, "    %s\n", last_text(context));
  tsolid_boundary_file_free(file);
  tsolid_boundary_free(boundary);
  tsolid_tmesh_free(tmesh);
  tsolid_space_free(space);
  return solid;
}

/* What is read is what was written, down to the struct's last field. */
static void compare_solids(const tsolid_solid *a, const tsolid_solid *b) {
  const tsolid_space *s = a->space, *t = b->space;
  const tsolid_boundary *p = s->boundary, *q = t->boundary;
  size_t n = (size_t)s->n_inner + 2 * (size_t)s->n_surface;
  CHECK(s->n_inner == t->n_inner && s->n_surface == t->n_surface);
  CHECK(memcmp(a->control, b->control, 4 * n * sizeof(double)) == 0);
  CHECK(a->constant_weight == b->constant_weight);
  CHECK(memcmp(&a->start_worst, &b->start_worst, sizeof(double)) == 0);
  CHECK(memcmp(&p->requirement, &q->requirement, sizeof p->requirement) == 0);
  CHECK(memcmp(&p->preparation, &q->preparation, sizeof p->preparation) == 0);
  CHECK(p->scale == q->scale && p->scale > 0);
  CHECK(s->n_elements == t->n_elements);
  CHECK(memcmp(s->element_box, t->element_box, 6 * (size_t)s->n_elements * sizeof(double)) == 0);
  CHECK(memcmp(s->tmesh->arm_height, t->tmesh->arm_height, sizeof t->tmesh->arm_height) == 0);
  CHECK(s->tmesh->n_cells == t->tmesh->n_cells && s->tmesh->n_nodes == t->tmesh->n_nodes);
  for (int k = 0; k < 6; k++) {
    const tsi_side *f = &p->side[k], *g = &q->side[k];
    size_t order = (size_t)(f->degree[0] + 1) * (size_t)(f->degree[1] + 1);
    CHECK(f->n_elements == g->n_elements && memcmp(f->degree, g->degree, sizeof f->degree) == 0 &&
          memcmp(f->grid, g->grid, sizeof f->grid) == 0);
    CHECK(memcmp(f->coefficient, g->coefficient,
                 (size_t)f->function_start[f->n_elements] * order * sizeof(double)) == 0);
  }
}

static void test_tsolid(tsolid_context *context, tsolid_solid *solid, const char *example) {
  tsolid_solid *read = NULL;
  solid->start_worst = example[0] == 'b' ? (double)NAN : 0.25;
  CHECK(tsolid_write_tsolid(context, solid, in_folder("a.tsolid")) == TSOLID_OK);
  if (!CHECK(tsolid_read_tsolid(context, in_folder("a.tsolid"), &read) == TSOLID_OK)) {
    fprintf(stderr, "    %s: %s\n", example, last_text(context));
    return;
  }
  compare_solids(solid, read);
  CHECK(tsolid_write_tsolid(context, read, in_folder("b.tsolid")) == TSOLID_OK);
  CHECK(same_bytes(in_folder("a.tsolid"), in_folder("b.tsolid")));
  CHECK(tsolid_write_vtu(context, solid, in_folder("a.vtu")) == TSOLID_OK);
  CHECK(tsolid_write_vtu(context, read, in_folder("b.vtu")) == TSOLID_OK);
  CHECK(same_bytes(in_folder("a.vtu"), in_folder("b.vtu")));
  tsolid_solid_free(read);
}

/* Refused, whichever byte is damaged and wherever the file ends or goes on. */
static void test_tsolid_damaged(tsolid_context *context, const tsolid_solid *solid) {
  size_t size;
  int n_accepted = 0;
  tsolid_solid *read;
  CHECK(tsolid_write_tsolid(context, solid, in_folder("a.tsolid")) == TSOLID_OK);
  char *bytes = read_bytes(in_folder("a.tsolid"), &size);
  for (size_t k = 0; bytes && k <= 2 * size; k++) {
    size_t step = k < 200 || size < 4000 ? 1 : 37, at = k % (size + 1), length = size;
    char kept = bytes[at];
    if (k <= size)
      bytes[at] = (char)(kept ^ (1 << k % 8)); /* byte `size` is one too many */
    else
      length = at;
    write_bytes(in_folder("x.tsolid"), bytes, k == size ? size + 1 : length);
    bytes[at] = kept;
    tsolid_context_clear(context);
    tsolid_status status = tsolid_read_tsolid(context, in_folder("x.tsolid"), &read);
    n_accepted += status != TSOLID_ERROR_INPUT || read != NULL;
    k += step - 1;
  }
  CHECK(bytes && n_accepted == 0);
  free(bytes);
  tsolid_context_clear(context);
}

static uint32_t get_u32(const unsigned char *b) {
  return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static void put_u32(unsigned char *b, uint32_t value) {
  for (int k = 0; k < 4; k++)
    b[k] = (unsigned char)(value >> 8 * k);
}

/* A file with right checksums and wrong content: section `tag` gets `value` at `offset`. */
static tsolid_status read_forged(tsolid_context *context, const char *tag, size_t offset,
                                 uint32_t value) {
  size_t size;
  tsolid_solid *read = NULL;
  unsigned char *b = (unsigned char *)read_bytes(in_folder("a.tsolid"), &size);
  size_t at = TSI_TSOLID_MAGIC_SIZE + 4;
  while (at < size && memcmp(b + at, tag, 4) != 0)
    at += TSI_TSOLID_SECTION_FRAME + get_u32(b + at + 4);
  if (CHECK(at < size)) {
    size_t length = get_u32(b + at + 4);
    put_u32(b + at + 12 + offset, value);
    put_u32(b + at + 12 + length, (uint32_t)crc32(0, b + at, (uInt)(12 + length)));
  }
  write_bytes(in_folder("x.tsolid"), b, size);
  free(b);
  tsolid_context_clear(context);
  tsolid_status status = tsolid_read_tsolid(context, in_folder("x.tsolid"), &read);
  CHECK(status == TSOLID_OK || !read);
  tsolid_solid_free(read);
  return status;
}

static void test_tsolid_forged(tsolid_context *context, const tsolid_solid *solid) {
  static const uint32_t counts[] = {0, 1, 2, 0x7fffffff, 0x80000000, 0xffffffff, 1u << 28};
  CHECK(tsolid_write_tsolid(context, solid, in_folder("a.tsolid")) == TSOLID_OK);
  CHECK(read_forged(context, "INFO", 4, 0) == TSOLID_OK);
  for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
    CHECK(read_forged(context, "FUNC", 0, counts[k]) == TSOLID_ERROR_INPUT);
    CHECK(read_forged(context, "CTRL", 0, counts[k]) == TSOLID_ERROR_INPUT);
    CHECK(read_forged(context, "SIDE", 0, counts[k] + 3) == TSOLID_ERROR_INPUT); /* degree */
    CHECK(read_forged(context, "SIDE", 16, counts[k] + 3) == TSOLID_ERROR_INPUT);
    CHECK(read_forged(context, "MESH", 0, counts[k]) == TSOLID_ERROR_INPUT);
  }
  CHECK(read_forged(context, "FUNC", 4 + 4, 0x7ff80000) == TSOLID_ERROR_INPUT);      /* NaN */
  CHECK(read_forged(context, "FUNC", 4 + 24 + 4, 0xbff00000) == TSOLID_ERROR_INPUT); /* w < 0 */
  CHECK(read_forged(context, "CTRL", 4 + 24 + 4, 0xbff00000) == TSOLID_ERROR_INPUT);
  CHECK(read_forged(context, "CTRL", 4 + 4, 0x7ff00000) == TSOLID_ERROR_INPUT);
  CHECK(read_forged(context, "FACT", 0, 0) == TSOLID_ERROR_INPUT); /* requirement not satisfied */
  tsolid_context_clear(context);
}

/* Takes the last n bytes of a section's payload away; returns the new size of the file. */
static size_t shorten_section(unsigned char *b, size_t size, const char *tag, size_t n) {
  size_t at = TSI_TSOLID_MAGIC_SIZE + 4;
  while (memcmp(b + at, tag, 4) != 0)
    at += TSI_TSOLID_SECTION_FRAME + get_u32(b + at + 4);
  size_t length = get_u32(b + at + 4) - n, rest = at + 12 + length + n + 4;
  put_u32(b + at + 4, (uint32_t)length);
  put_u32(b + at + 12 + length, (uint32_t)crc32(0, b + at, (uInt)(12 + length)));
  memmove(b + rest - n, b + rest, size - rest);
  return size - n;
}

/* Version 3 lacks the last three of the facts, version 2 also what follows the mesh's arm heights,
 * version 1 two more of the facts: all are read, and only under their own number. */
static void test_tsolid_versions(tsolid_context *context, const tsolid_solid *solid) {
  size_t size;
  CHECK(tsolid_write_tsolid(context, solid, in_folder("a.tsolid")) == TSOLID_OK);
  unsigned char *b = (unsigned char *)read_bytes(in_folder("a.tsolid"), &size);
  int n_boxes = solid->space->tmesh->n_boxes;
  for (uint32_t layout = 4; layout > 0; layout--) {
    if (layout < 4)
      size = shorten_section(b, size, layout == 2 ? "MESH" : "FACT",
                             layout == 2   ? 4 + 4 * (size_t)n_boxes
                             : layout == 3 ? 12
                                           : 8);
    for (uint32_t version = 0; version < 6; version++) {
      tsolid_solid *read = NULL;
      put_u32(b + TSI_TSOLID_MAGIC_SIZE, version);
      write_bytes(in_folder("x.tsolid"), b, size);
      tsolid_context_clear(context);
      CHECK((tsolid_read_tsolid(context, in_folder("x.tsolid"), &read) == TSOLID_OK) ==
            (version == layout));
      if (CHECK((read != NULL) == (version == layout)) && read) {
        CHECK(tsolid_write_tsolid(context, read, in_folder("y.tsolid")) == TSOLID_OK);
        /* old files lack the levels: only picture and report show them */
        CHECK(layout < 3 || same_bytes(in_folder("a.tsolid"), in_folder("y.tsolid")));
        CHECK(read->space->n_inner == solid->space->n_inner);
        CHECK(memcmp(read->control, solid->control, 32 * (size_t)solid->space->n_inner) == 0);
      }
      tsolid_solid_free(read);
    }
  }
  free(b);
  tsolid_context_clear(context);
}

/* ---- cancel and memory -------------------------------------------------------------------------
 */

typedef struct countdown {
  long left, n_live;
} countdown;

static int cancel_at(void *data, const char *stage, double fraction) {
  (void)stage;
  CHECK(fraction >= 0 && fraction <= 1);
  return --((countdown *)data)->left == 0;
}

static void *fail_at(void *data, size_t size) {
  countdown *c = data;
  if (--c->left == 0)
    return NULL;
  void *memory = malloc(size);
  c->n_live += memory != NULL;
  return memory;
}

static void release(void *data, void *memory) {
  ((countdown *)data)->n_live--;
  free(memory);
}

typedef struct task {
  const tsolid_boundary_input *input;
  const tsolid_solid *solid;
  const tsolid_report *report;
} task;

typedef tsolid_status (*task_fn)(tsolid_context *context, const task *t);

static tsolid_status do_write_tsb(tsolid_context *context, const task *t) {
  return tsolid_write_tsb(context, t->input, in_folder("m.tsb"));
}

static tsolid_status do_read_tsb(tsolid_context *context, const task *t) {
  tsolid_boundary_file *file;
  (void)t;
  tsolid_status status = tsolid_read_tsb(context, in_folder("good.tsb"), &file);
  CHECK(!file == (status != TSOLID_OK));
  tsolid_boundary_file_free(file);
  return status;
}

static tsolid_status do_write_tsolid(tsolid_context *context, const task *t) {
  return tsolid_write_tsolid(context, t->solid, in_folder("m.tsolid"));
}

static tsolid_status do_read_tsolid(tsolid_context *context, const task *t) {
  tsolid_solid *solid;
  (void)t;
  tsolid_status status = tsolid_read_tsolid(context, in_folder("good.tsolid"), &solid);
  CHECK(!solid == (status != TSOLID_OK));
  tsolid_solid_free(solid);
  return status;
}

static tsolid_status do_write_vtu(tsolid_context *context, const task *t) {
  return tsolid_write_vtu(context, t->solid, in_folder("m.vtu"));
}

static tsolid_status do_report_json(tsolid_context *context, const task *t) {
  char *json;
  tsolid_status status = tsolid_report_json(context, t->report, &json);
  CHECK(!json == (status != TSOLID_OK));
  tsolid_release(context, json);
  return status;
}

/* Fails allocation 1, 2, ... until one run needs fewer; each time a status, no file, no leak. */
static void fail_each_allocation(task_fn run, const task *t) {
  int n_files = count_files();
  for (long k = 1; k < 1000000; k += k < 400 ? 1 : 1 + k / 50) {
    countdown c = {.left = k + 1}; /* the first is the context itself */
    tsolid_context_options options = {
        .allocate = fail_at, .release = release, .allocator_data = &c, .n_threads = 1};
    tsolid_context *context;
    CHECK(tsolid_context_create(&options, &context) == TSOLID_OK);
    tsolid_status status = run(context, t);
    tsolid_context_free(context);
    CHECK(c.n_live == 0);
    if (c.left > 0) { /* it never failed: the task is done */
      CHECK(status == TSOLID_OK && k > 1);
      return;
    }
    if (!CHECK(status == TSOLID_ERROR_MEMORY))
      return;
    CHECK(count_files() == n_files);
  }
  CHECK(0);
}

/* Cancels at progress call 1, 2, ...; nothing may stand on the disk. */
static void cancel_each_call(task_fn run, const task *t) {
  int n_files = count_files();
  for (long k = 1; k < 100000; k++) {
    countdown c = {.left = k};
    tsolid_context_options options = {.progress = cancel_at, .progress_data = &c, .n_threads = 1};
    tsolid_context *context;
    CHECK(tsolid_context_create(&options, &context) == TSOLID_OK);
    tsolid_status status = run(context, t);
    tsolid_context_free(context);
    if (c.left > 0) {
      CHECK(status == TSOLID_OK && k > 1);
      return;
    }
    CHECK(status == TSOLID_ERROR_CANCELLED);
    CHECK(count_files() == n_files);
  }
}

static void remove_written(void) {
  static const char *const names[] = {"m.tsb", "m.tsolid", "m.vtu"};
  for (int k = 0; k < 3; k++)
    unlink(in_folder(names[k]));
}

static void test_failures(const task *t) {
  static const task_fn all[] = {do_write_tsb,   do_read_tsb,  do_write_tsolid,
                                do_read_tsolid, do_write_vtu, do_report_json};
  for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
    fail_each_allocation(all[k], t);
    remove_written();
  }
  cancel_each_call(do_write_tsolid, t);
  remove_written();
  cancel_each_call(do_write_vtu, t);
  remove_written();
  cancel_each_call(do_read_tsolid, t);
}

/* ---- locale ------------------------------------------------------------------------------------
 */

/* Every text format once more where the decimal point is a comma: the same bytes. */
static void test_locale(tsolid_context *context, const tsolid_solid *solid,
                        const tsolid_report *report) {
  static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"};
  tsolid_boundary_file *file = NULL;
  char *plain = NULL, *foreign = NULL;
  int found = 0;
  CHECK(tsolid_report_json(context, report, &plain) == TSOLID_OK);
  CHECK(tsolid_write_vtu(context, solid, in_folder("a.vtu")) == TSOLID_OK);
  for (size_t k = 0; k < 3 && !found; k++)
    found = setlocale(LC_ALL, names[k]) != NULL;
  if (!found) {
    printf("skipped: locale test, because no locale with a decimal comma is installed\n");
  } else {
    CHECK(strcmp(localeconv()->decimal_point, ",") == 0);
    test_numbers();
    CHECK(tsolid_read_tsb(context, in_folder("good.tsb"), &file) == TSOLID_OK);
    CHECK(tsolid_write_tsb(context, tsolid_boundary_file_input(file), in_folder("c.tsb")) ==
          TSOLID_OK);
    CHECK(same_bytes(in_folder("good.tsb"), in_folder("c.tsb")));
    CHECK(tsolid_report_json(context, report, &foreign) == TSOLID_OK);
    CHECK(plain && foreign && strcmp(plain, foreign) == 0);
    CHECK(tsolid_write_vtu(context, solid, in_folder("b.vtu")) == TSOLID_OK);
    CHECK(same_bytes(in_folder("a.vtu"), in_folder("b.vtu")));
    CHECK(strcmp(localeconv()->decimal_point, ",") == 0); /* the caller's locale is his */
  }
  setlocale(LC_ALL, "C");
  tsolid_boundary_file_free(file);
  tsolid_release(context, plain);
  tsolid_release(context, foreign);
}

/* ---- report ------------------------------------------------------------------------------------
 */

static void test_report(tsolid_context *context, tsolid_report *report) {
  char *json = NULL;
  report->timing.optimise = NAN;
  report->quality.worst = 1.0 / 3.0;
  report->quality.start_worst = INFINITY;
  report->certificate.verdict = TSOLID_UNDECIDED;
  CHECK(tsolid_report_json(context, report, &json) == TSOLID_OK);
  CHECK(json && strstr(json, "\"optimise\":\tnull") && strstr(json, "\"start_worst\":\tnull"));
  CHECK(json && strstr(json, "\"worst\":\t0.333333333333333") != NULL);
  CHECK(json && strstr(json, "\"verdict\":\t\"undecided\"") != NULL);
  tsolid_release(context, json);
  CHECK(tsolid_report_json(context, NULL, &json) == TSOLID_ERROR_ARGUMENT && !json);
}

static void remove_folder(void) {
  DIR *directory = opendir(folder);
  for (struct dirent *entry; directory && (entry = readdir(directory));)
    if (entry->d_name[0] != '.')
      unlink(in_folder(entry->d_name));
  closedir(directory);
  rmdir(folder);
}

static void test_solids(tsolid_context *context, tsolid_report *report) {
  static const char *const examples[] = {"mixed_sides", "sphere", "box"};
  tsolid_solid *solid = NULL;
  for (size_t k = 0; k < 3; k++) {
    tsolid_solid_free(solid);
    solid = make_solid(context, examples[k]);
    if (!solid)
      return;
    test_tsolid(context, solid, examples[k]);
  }
  test_tsolid_damaged(context, solid);
  test_tsolid_forged(context, solid);
  test_tsolid_versions(context, solid);
  test_locale(context, solid, report);
  tsolid_boundary_file *file;
  CHECK(tsolid_write_tsolid(context, solid, in_folder("good.tsolid")) == TSOLID_OK);
  CHECK(tsolid_read_tsb(context, in_folder("good.tsb"), &file) == TSOLID_OK);
  task t = {tsolid_boundary_file_input(file), solid, report};
  test_failures(&t);
  tsolid_boundary_file_free(file);
  tsolid_solid_free(solid);
}

int main(void) {
  tsolid_context *context;
  tsolid_report report;
  const char *base = getenv("TMPDIR");
  tsolid_context_options options = {.n_threads = 1};
  memset(&report, 0, sizeof report);
  snprintf(folder, sizeof folder, "%.40s/tsolid.XXXXXX", base ? base : "/tmp");
  if (!CHECK(mkdtemp(folder)) || !CHECK(tsolid_context_create(&options, &context) == TSOLID_OK))
    return check_done();
  test_numbers();
  test_tsb_patches(context);
  rename(in_folder("a.tsb"), in_folder("good.tsb"));
  test_tsb_bezier(context);
  test_tsb_tolerance(context);
  test_tsb_malformed(context);
  test_tsb_truncated(context);
  test_tsb_refuses_to_write(context);
  test_operating_system(context);
  test_report(context, &report);
  test_solids(context, &report);
  tsolid_context_free(context);
  remove_folder();
  return check_done();
}
