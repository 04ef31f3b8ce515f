/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Reads a boundary from .tsb (resources/boundary.schema.json). What is checked here is the form:
 * keys, counts, finite numbers; whether the knots and the patches make sense is the boundary's
 * business. */
#include <limits.h>

#include "boundary_file.h"
#include "file_io.h"
#include "json_reader.h"

static const char stage[] = "read";
static const size_t max_file_size = (size_t)1 << 30;

/* ---- growing lists -----------------------------------------------------------------------------
 */

typedef struct list {
  void *item;
  size_t n, capacity, size; /* size of an item */
} list;

typedef struct reader {
  tsi_json json;
  tsi_arena *arena; /* the file's */
  list number;      /* scratch */
  double tolerance;
} reader;

static int fail_memory(reader *r) {
  if (r->json.status == TSOLID_OK)
    r->json.status = tsi_no_memory(r->json.context, stage);
  return 0;
}

static int push(reader *r, list *to, const void *item) {
  const tsi_allocator *allocator = &r->json.context->allocator;
  if (to->n == to->capacity) {
    size_t capacity = to->capacity ? 2 * to->capacity : 64;
    void *grown = tsi_new(allocator, capacity, to->size);
    if (!grown)
      return fail_memory(r);
    if (to->n)
      memcpy(grown, to->item, to->n * to->size);
    tsi_delete(allocator, to->item);
    to->item = grown;
    to->capacity = capacity;
  }
  memcpy((char *)to->item + to->n++ * to->size, item, to->size);
  return 1;
}

/* Copies a list into the file's arena and empties it; NULL after a failure. */
static void *keep(reader *r, list *from) {
  void *kept = tsi_arena_new(r->arena, from->n, from->size);
  if (!kept) {
    fail_memory(r);
    return NULL;
  }
  if (from->n)
    memcpy(kept, from->item, from->n * from->size);
  from->n = 0;
  return kept;
}

static void drop(reader *r, list *of) {
  tsi_delete(&r->json.context->allocator, of->item);
  *of = (list){.size = of->size};
}

/* ---- values ------------------------------------------------------------------------------------
 */

/* Appends the numbers of one JSON list; returns how many, or -1. */
static long append_numbers(reader *r, list *to) {
  long n = 0;
  if (!tsi_json_enter(&r->json, '['))
    return -1;
  while (tsi_json_next(&r->json)) {
    double value;
    if (!tsi_json_number(&r->json, &value) || !push(r, to, &value))
      return -1;
    n++;
  }
  return r->json.status == TSOLID_OK ? n : -1;
}

static int append_row(reader *r, list *to, int width) {
  long n = append_numbers(r, to);
  if (n >= 0 && n != width)
    return tsi_json_fail(&r->json, "expected %d numbers, found %ld", width, n);
  return n >= 0;
}

/* Two whole numbers. */
static int read_pair(reader *r, int low, int high, int pair[2]) {
  int n = 0;
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json)) {
    if (n == 2)
      return tsi_json_fail(&r->json, "expected 2 numbers, found more");
    if (!tsi_json_integer(&r->json, low, high, &pair[n++]))
      return 0;
  }
  return n == 2 || tsi_json_fail(&r->json, "expected 2 numbers, found %d", n);
}

/* A list of numbers, kept. */
static int read_numbers(reader *r, const double **numbers, long *n) {
  r->number.n = 0;
  *n = append_numbers(r, &r->number);
  *numbers = *n >= 0 ? keep(r, &r->number) : NULL;
  return *numbers != NULL;
}

/* A list of lists of `width` numbers, kept as one array. */
static int read_rows(reader *r, int width, const double **numbers, long *n) {
  r->number.n = 0;
  *n = 0;
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json)) {
    if (!append_row(r, &r->number, width))
      return 0;
    ++*n;
  }
  *numbers = r->json.status == TSOLID_OK ? keep(r, &r->number) : NULL;
  return *numbers != NULL;
}

static int read_four_numbers(reader *r, double four[4]) {
  r->number.n = 0;
  if (!append_row(r, &r->number, 4))
    return 0;
  memcpy(four, r->number.item, 4 * sizeof *four);
  return 1;
}

/* An empty name is none. */
static int read_four_names(reader *r, const char *name[4]) {
  int n = 0;
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json)) {
    if (n == 4)
      return tsi_json_fail(&r->json, "expected 4 names, found more");
    if (!tsi_json_string(&r->json, r->arena, &name[n]))
      return 0;
    if (!name[n][0])
      name[n] = NULL;
    n++;
  }
  return n == 4 || tsi_json_fail(&r->json, "expected 4 names, found %d", n);
}

static int require_keys(reader *r, const char *const *names, unsigned required, unsigned seen) {
  for (int k = 0; names[k]; k++)
    if ((required & (1u << k)) && !(seen & (1u << k)))
      return tsi_json_fail(&r->json, "the key '%s' is missing", names[k]);
  return 1;
}

/* ---- Bezier elements ---------------------------------------------------------------------------
 */

typedef struct side_lists {
  list box, start, function, coefficient;
  long order; /* numbers per function; 0: none seen yet */
} side_lists;

static int read_functions(reader *r, side_lists *lists, long *n) {
  *n = 0;
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json)) {
    int function;
    if (!tsi_json_integer(&r->json, 0, TSI_MAX_COUNT, &function) ||
        !push(r, &lists->function, &function))
      return 0;
    ++*n;
  }
  return r->json.status == TSOLID_OK;
}

static int read_coefficients(reader *r, side_lists *lists, long *n) {
  *n = 0;
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json)) {
    long order = append_numbers(r, &lists->coefficient);
    if (order < 0)
      return 0;
    if (lists->order == 0)
      lists->order = order;
    if (order == 0 || order != lists->order)
      return tsi_json_fail(&r->json, "expected %ld coefficients, found %ld", lists->order, order);
    ++*n;
  }
  return r->json.status == TSOLID_OK;
}

static int read_element(reader *r, side_lists *lists) {
  static const char *const keys[] = {"box", "functions", "coefficients", NULL};
  unsigned seen = 0;
  long n_functions = 0, n_coefficients = 0;
  if (!tsi_json_enter(&r->json, '{'))
    return 0;
  while (tsi_json_next(&r->json)) {
    int key = tsi_json_key(&r->json, keys, &seen);
    int read = key == 0   ? append_row(r, &lists->box, 4)
               : key == 1 ? read_functions(r, lists, &n_functions)
               : key == 2 ? read_coefficients(r, lists, &n_coefficients)
                          : 0;
    if (!read)
      return 0;
  }
  if (!require_keys(r, keys, 7, seen))
    return 0;
  if (n_functions != n_coefficients)
    return tsi_json_fail(&r->json, "%ld functions, but %ld lists of coefficients", n_functions,
                         n_coefficients);
  if (lists->function.n > TSI_MAX_COUNT)
    return tsi_json_fail(&r->json, "too many functions");
  int end = (int)lists->function.n;
  return push(r, &lists->start, &end);
}

static int read_elements(reader *r, side_lists *lists) {
  int zero = 0;
  if (!tsi_json_enter(&r->json, '[') || !push(r, &lists->start, &zero))
    return 0;
  while (tsi_json_next(&r->json))
    if (!read_element(r, lists))
      return 0;
  return r->json.status == TSOLID_OK;
}

static int keep_side(reader *r, side_lists *lists, tsolid_bezier_side *side) {
  long order = (side->degree[0] + 1L) * (side->degree[1] + 1L);
  if (lists->start.n < 2)
    return tsi_json_fail(&r->json, "the side has no elements");
  if (lists->order != order)
    return tsi_json_fail(&r->json, "degrees %d and %d need %ld coefficients per function, not %ld",
                         side->degree[0], side->degree[1], order, lists->order);
  side->n_elements = (int)lists->start.n - 1;
  side->box = keep(r, &lists->box);
  side->function_start = keep(r, &lists->start);
  side->function = keep(r, &lists->function);
  side->coefficient = keep(r, &lists->coefficient);
  return r->json.status == TSOLID_OK;
}

static int read_side(reader *r, tsolid_bezier_side *side) {
  static const char *const keys[] = {"degree", "elements", NULL};
  side_lists lists = {.box = {.size = sizeof(double)},
                      .start = {.size = sizeof(int)},
                      .function = {.size = sizeof(int)},
                      .coefficient = {.size = sizeof(double)}};
  unsigned seen = 0;
  int read = tsi_json_enter(&r->json, '{');
  while (read && tsi_json_next(&r->json)) {
    int key = tsi_json_key(&r->json, keys, &seen);
    read = key == 0   ? read_pair(r, 1, TSI_MAX_DEGREE, side->degree)
           : key == 1 ? read_elements(r, &lists)
                      : 0;
  }
  read = read && r->json.status == TSOLID_OK && require_keys(r, keys, 3, seen) &&
         keep_side(r, &lists, side);
  drop(r, &lists.box);
  drop(r, &lists.start);
  drop(r, &lists.function);
  drop(r, &lists.coefficient);
  return read;
}

/* ---- T-splines --------------------------------------------------------------------------------
 */

typedef struct tspline_lists {
  list point, knots[2];
  long n_knots[2]; /* local knots per function; 0: none seen yet */
} tspline_lists;

static int read_local_knots(reader *r, tspline_lists *lists) {
  int d = 0;
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json)) {
    if (d == 2)
      return tsi_json_fail(&r->json, "expected 2 knot vectors, found more");
    long n = append_numbers(r, &lists->knots[d]);
    if (n < 0)
      return 0;
    if (lists->n_knots[d] == 0)
      lists->n_knots[d] = n;
    if (n == 0 || n != lists->n_knots[d])
      return tsi_json_fail(&r->json, "expected %ld knots, found %ld", lists->n_knots[d], n);
    d++;
  }
  return d == 2 || tsi_json_fail(&r->json, "expected 2 knot vectors, found %d", d);
}

static int read_blend(reader *r, tspline_lists *lists) {
  static const char *const keys[] = {"point", "knots", NULL};
  unsigned seen = 0;
  if (!tsi_json_enter(&r->json, '{'))
    return 0;
  while (tsi_json_next(&r->json)) {
    int key = tsi_json_key(&r->json, keys, &seen), point = 0;
    int read = key == 0 ? tsi_json_integer(&r->json, 0, TSI_MAX_COUNT, &point) &&
                              push(r, &lists->point, &point)
               : key == 1 ? read_local_knots(r, lists)
                          : 0;
    if (!read)
      return 0;
  }
  return r->json.status == TSOLID_OK && require_keys(r, keys, 3, seen);
}

static int read_blends(reader *r, tspline_lists *lists) {
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json))
    if (!read_blend(r, lists))
      return 0;
  return r->json.status == TSOLID_OK;
}

static int keep_tspline(reader *r, tspline_lists *lists, tsolid_tspline *t) {
  if (lists->point.n == 0 || lists->point.n > TSI_MAX_COUNT)
    return tsi_json_fail(&r->json, "the T-spline has no functions, or too many");
  for (int d = 0; d < 2; d++)
    if (lists->n_knots[d] != t->degree[d] + 2)
      return tsi_json_fail(&r->json, "degree %d needs %d local knots per function, not %ld",
                           t->degree[d], t->degree[d] + 2, lists->n_knots[d]);
  t->n_functions = (int)lists->point.n;
  t->point = keep(r, &lists->point);
  for (int d = 0; d < 2; d++)
    t->knots[d] = keep(r, &lists->knots[d]);
  return r->json.status == TSOLID_OK;
}

static int read_tspline(reader *r, const tsolid_tspline **kept) {
  static const char *const keys[] = {"degree", "functions", "domain", NULL};
  tspline_lists lists = {.point = {.size = sizeof(int)},
                         .knots = {{.size = sizeof(double)}, {.size = sizeof(double)}}};
  tsolid_tspline *t = tsi_arena_new(r->arena, 1, sizeof *t);
  unsigned seen = 0;
  int read = t ? tsi_json_enter(&r->json, '{') : fail_memory(r);
  while (read && tsi_json_next(&r->json)) {
    int key = tsi_json_key(&r->json, keys, &seen);
    read = key == 0   ? read_pair(r, 1, TSI_MAX_DEGREE, t->degree)
           : key == 1 ? read_blends(r, &lists)
           : key == 2 ? read_four_numbers(r, t->domain)
                      : 0;
  }
  read = read && r->json.status == TSOLID_OK && require_keys(r, keys, 7, seen) &&
         keep_tspline(r, &lists, t);
  *kept = t;
  drop(r, &lists.point);
  drop(r, &lists.knots[0]);
  drop(r, &lists.knots[1]);
  return read;
}

/* ---- patches -----------------------------------------------------------------------------------
 */

enum {
  PATCH_DEGREE,
  PATCH_N_CONTROL,
  PATCH_KNOTS,
  PATCH_POINTS,
  PATCH_NAME,
  PATCH_WEIGHTS,
  PATCH_BORDER_NAMES,
  PATCH_CORNER_NAMES,
  PATCH_BORDER_TOLERANCE,
  PATCH_TSPLINE,
  PATCH_BEZIER
};
static const char *const patch_keys[] = {
    "degree",       "n_control",        "knots",   "points", "name", "weights", "border_names",
    "corner_names", "border_tolerance", "tspline", "bezier", NULL};

/* What a patch's lists turned out to hold; compared with its degrees and counts at its end. */
typedef struct patch_counts {
  long knots[2], points, weights;
} patch_counts;

static int read_knots(reader *r, tsolid_patch *patch, patch_counts *counts) {
  int n = 0;
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json)) {
    if (n == 2)
      return tsi_json_fail(&r->json, "expected 2 knot vectors, found more");
    if (!read_numbers(r, &patch->knots[n], &counts->knots[n]))
      return 0;
    n++;
  }
  return n == 2 || tsi_json_fail(&r->json, "expected 2 knot vectors, found %d", n);
}

static int read_bezier_patch(reader *r, const tsolid_bezier_side **kept) {
  tsolid_bezier_side *side = tsi_arena_new(r->arena, 1, sizeof *side);
  *kept = side;
  return side ? read_side(r, side) : fail_memory(r);
}

static int read_patch_value(reader *r, int key, tsolid_patch *patch, patch_counts *counts) {
  switch (key) {
  case PATCH_DEGREE:
    return read_pair(r, 1, TSI_MAX_DEGREE, patch->degree);
  case PATCH_N_CONTROL:
    return read_pair(r, 2, TSI_MAX_COUNT, patch->n_control);
  case PATCH_KNOTS:
    return read_knots(r, patch, counts);
  case PATCH_POINTS:
    return read_rows(r, 3, &patch->points, &counts->points);
  case PATCH_NAME:
    return tsi_json_string(&r->json, r->arena, &patch->name);
  case PATCH_WEIGHTS:
    return read_numbers(r, &patch->weights, &counts->weights);
  case PATCH_BORDER_NAMES:
    return read_four_names(r, patch->border_name);
  case PATCH_CORNER_NAMES:
    return read_four_names(r, patch->corner_name);
  case PATCH_BORDER_TOLERANCE:
    return read_four_numbers(r, patch->border_tolerance);
  case PATCH_TSPLINE:
    return read_tspline(r, &patch->tspline);
  case PATCH_BEZIER:
    return read_bezier_patch(r, &patch->bezier);
  default:
    return 0;
  }
}

static int check_tolerance(reader *r, const tsolid_patch *patch) {
  for (int k = 0; k < 4; k++)
    if (patch->border_tolerance[k] < 0)
      return tsi_json_fail(&r->json, "border_tolerance %g is negative", patch->border_tolerance[k]);
  return 1;
}

static int check_patch(reader *r, const tsolid_patch *patch, const patch_counts *counts) {
  for (int d = 0; d < 2; d++) {
    if (patch->n_control[d] <= patch->degree[d])
      return tsi_json_fail(&r->json, "degree %d needs at least %d control points, n_control has %d",
                           patch->degree[d], patch->degree[d] + 1, patch->n_control[d]);
    long expected = (long)patch->n_control[d] + patch->degree[d] + 1;
    if (counts->knots[d] != expected)
      return tsi_json_fail(&r->json, "expected %ld knots in direction %d, found %ld", expected, d,
                           counts->knots[d]);
  }
  long long n = (long long)patch->n_control[0] * patch->n_control[1];
  if (counts->points != n)
    return tsi_json_fail(&r->json, "expected %lld points, found %ld", n, counts->points);
  if (patch->weights && counts->weights != n)
    return tsi_json_fail(&r->json, "expected %lld weights, found %ld", n, counts->weights);
  return 1;
}

/* The keys that a patch must have, and may not have, depend on its form. */
static int check_form(reader *r, const tsolid_patch *patch, const patch_counts *counts,
                      unsigned seen) {
  unsigned nurbs =
               1u << PATCH_DEGREE | 1u << PATCH_N_CONTROL | 1u << PATCH_KNOTS | 1u << PATCH_POINTS,
           other = 1u << PATCH_TSPLINE | 1u << PATCH_BEZIER;
  if (!check_tolerance(r, patch))
    return 0;
  if (!(seen & other))
    return require_keys(r, patch_keys, nurbs, seen) && check_patch(r, patch, counts);
  if ((seen & other) == other)
    return tsi_json_fail(&r->json, "a patch is not both 'tspline' and 'bezier'");
  return !(seen & (nurbs | 1u << PATCH_WEIGHTS)) ||
         tsi_json_fail(&r->json, "'%s' has no meaning beside '%s'",
                       seen & 1u << PATCH_POINTS ? "points" : "degree",
                       patch->tspline ? "tspline" : "bezier");
}

static int read_patch(reader *r, tsolid_patch *patch) {
  patch_counts counts = {{0, 0}, 0, 0};
  unsigned seen = 0;
  *patch = (tsolid_patch){.degree = {0, 0}};
  if (!tsi_json_enter(&r->json, '{'))
    return 0;
  while (tsi_json_next(&r->json)) {
    int key = tsi_json_key(&r->json, patch_keys, &seen);
    if (key < 0 || !read_patch_value(r, key, patch, &counts))
      return 0;
  }
  return r->json.status == TSOLID_OK && check_form(r, patch, &counts, seen);
}

static int read_patches(reader *r, tsolid_boundary_input *input) {
  list patches = {.size = sizeof(tsolid_patch)};
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json)) {
    tsolid_patch patch;
    if (!read_patch(r, &patch) || !push(r, &patches, &patch))
      break;
  }
  if (r->json.status == TSOLID_OK && patches.n == 0)
    tsi_json_fail(&r->json, "the list of patches is empty");
  if (r->json.status == TSOLID_OK) {
    input->n_patches = (int)patches.n;
    input->patches = keep(r, &patches);
  }
  drop(r, &patches);
  return r->json.status == TSOLID_OK;
}

/* ---- six sides ---------------------------------------------------------------------------------
 */

static int read_sides(reader *r, tsolid_bezier_side side[6]) {
  int n = 0;
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json)) {
    if (n == 6)
      return tsi_json_fail(&r->json, "expected 6 sides, found more");
    if (!read_side(r, &side[n++]))
      return 0;
  }
  return n == 6 || tsi_json_fail(&r->json, "expected 6 sides, found %d", n);
}

static int check_functions(reader *r, const tsolid_bezier_boundary *bezier) {
  for (int k = 0; k < 6; k++) {
    const tsolid_bezier_side *side = &bezier->side[k];
    for (int i = 0; i < side->function_start[side->n_elements]; i++)
      if (side->function[i] >= bezier->n_functions)
        return tsi_json_fail(&r->json, "side %d uses function %d of only %d points", k,
                             side->function[i], bezier->n_functions);
  }
  return 1;
}

static int read_bezier(reader *r, tsolid_boundary_input *input) {
  static const char *const keys[] = {"points", "sides", NULL};
  unsigned seen = 0;
  long n_points = 0;
  tsolid_bezier_boundary *bezier = tsi_arena_new(r->arena, 1, sizeof *bezier);
  if (!bezier)
    return fail_memory(r);
  if (!tsi_json_enter(&r->json, '{'))
    return 0;
  while (tsi_json_next(&r->json)) {
    int key = tsi_json_key(&r->json, keys, &seen);
    if (!(key == 0   ? read_rows(r, 4, &bezier->points, &n_points)
          : key == 1 ? read_sides(r, bezier->side)
                     : 0))
      return 0;
  }
  bezier->n_functions = (int)n_points;
  input->bezier = bezier;
  return r->json.status == TSOLID_OK && require_keys(r, keys, 3, seen) &&
         check_functions(r, bezier);
}

/* ---- smooth seams ------------------------------------------------------------------------------
 */

static int read_seam(reader *r, tsolid_smooth_seam *seam) {
  static const char *const keys[] = {"patches", "borders", "order", NULL};
  unsigned seen = 0;
  if (!tsi_json_enter(&r->json, '{'))
    return 0;
  while (tsi_json_next(&r->json)) {
    int key = tsi_json_key(&r->json, keys, &seen);
    int read = key == 0   ? read_pair(r, 0, TSI_MAX_COUNT, seam->patch)
               : key == 1 ? read_pair(r, 0, 3, seam->border)
               : key == 2 ? tsi_json_integer(&r->json, 1, TSI_MAX_DEGREE, &seam->order)
                          : 0;
    if (!read)
      return 0;
  }
  return r->json.status == TSOLID_OK && require_keys(r, keys, 7, seen);
}

static int read_smooth(reader *r, tsolid_boundary_input *input) {
  list seams = {.size = sizeof(tsolid_smooth_seam)};
  if (!tsi_json_enter(&r->json, '['))
    return 0;
  while (tsi_json_next(&r->json)) {
    tsolid_smooth_seam seam;
    if (!read_seam(r, &seam) || !push(r, &seams, &seam))
      break;
  }
  if (r->json.status == TSOLID_OK && seams.n > 0) {
    input->n_smooth = (int)seams.n;
    input->smooth = keep(r, &seams);
  }
  drop(r, &seams);
  return r->json.status == TSOLID_OK;
}

/* ---- the document ------------------------------------------------------------------------------
 */

enum { KEY_FORMAT, KEY_VERSION, KEY_TOLERANCE, KEY_PATCHES, KEY_BEZIER, KEY_POINTS, KEY_SMOOTH };
static const char *const document_keys[] = {"format", "version", "tolerance", "patches",
                                            "bezier", "points",  "smooth",    NULL};

static int read_format(reader *r) {
  const char *format;
  if (!tsi_json_string(&r->json, r->arena, &format))
    return 0;
  return strcmp(format, "tsolid boundary") == 0 ||
         tsi_json_fail(&r->json, "the format is not 'tsolid boundary'");
}

static int read_version(reader *r) {
  int version;
  if (!tsi_json_integer(&r->json, 0, INT_MAX, &version))
    return 0;
  return version == 1 || tsi_json_fail(&r->json, "version %d is not known, only 1", version);
}

static int read_tolerance(reader *r) {
  if (!tsi_json_number(&r->json, &r->tolerance))
    return 0;
  return r->tolerance > 0 || tsi_json_fail(&r->json, "the tolerance must be positive");
}

static int read_points(reader *r, tsolid_boundary_input *input) {
  long n;
  if (!read_rows(r, 4, &input->points, &n))
    return 0;
  input->n_points = (int)n;
  return n > 0 || tsi_json_fail(&r->json, "the list of points is empty");
}

/* Points and forms that need them; indices in range. */
static int check_points(reader *r, const tsolid_boundary_input *input) {
  int needed = 0;
  for (int k = 0; k < input->n_patches; k++) {
    const tsolid_patch *patch = &input->patches[k];
    const tsolid_bezier_side *side = patch->bezier;
    int n = patch->tspline ? patch->tspline->n_functions
            : side         ? side->function_start[side->n_elements]
                           : 0;
    const int *point = patch->tspline ? patch->tspline->point : side ? side->function : NULL;
    needed |= point != NULL;
    for (int i = 0; input->points && i < n; i++)
      if (point[i] >= input->n_points)
        return tsi_json_fail(&r->json, "patch %d uses point %d of only %d", k, point[i],
                             input->n_points);
  }
  if (needed && !input->points)
    return tsi_json_fail(&r->json, "the key 'points' is missing");
  if (!needed && input->points)
    return tsi_json_fail(&r->json, "'points' has no meaning without T-spline or Bezier patches");
  return !input->bezier || !input->smooth ||
         tsi_json_fail(&r->json, "'smooth' has no meaning beside 'bezier'");
}

static int read_document_value(reader *r, int key, tsolid_boundary_input *input) {
  switch (key) {
  case KEY_FORMAT:
    return read_format(r);
  case KEY_VERSION:
    return read_version(r);
  case KEY_TOLERANCE:
    return read_tolerance(r);
  case KEY_PATCHES:
    return read_patches(r, input);
  case KEY_BEZIER:
    return read_bezier(r, input);
  case KEY_POINTS:
    return read_points(r, input);
  case KEY_SMOOTH:
    return read_smooth(r, input);
  default:
    return 0;
  }
}

/* The document's tolerance is that of every border without one of its own. */
static void apply_tolerance(tsolid_boundary_input *input, double tolerance) {
  tsolid_patch *patch = (tsolid_patch *)(uintptr_t)input->patches; /* our own arena's */
  for (int k = 0; k < input->n_patches; k++)
    for (int b = 0; b < 4; b++)
      if (patch[k].border_tolerance[b] == 0)
        patch[k].border_tolerance[b] = tolerance;
}

static int read_document(reader *r, tsolid_boundary_input *input) {
  unsigned seen = 0;
  if (!tsi_json_enter(&r->json, '{'))
    return 0;
  while (tsi_json_next(&r->json)) {
    int key = tsi_json_key(&r->json, document_keys, &seen);
    if (key < 0 || !read_document_value(r, key, input))
      return 0;
  }
  if (!tsi_json_finish(&r->json) ||
      !require_keys(r, document_keys, 1u << KEY_FORMAT | 1u << KEY_VERSION, seen))
    return 0;
  if (!input->patches == !input->bezier)
    return tsi_json_fail(&r->json, "exactly one of 'patches' and 'bezier' is needed");
  if (input->bezier && r->tolerance > 0)
    return tsi_json_fail(&r->json, "'tolerance' has no meaning beside 'bezier'");
  apply_tolerance(input, r->tolerance);
  return check_points(r, input);
}

tsolid_status tsolid_read_tsb(tsolid_context *context, const char *path,
                              tsolid_boundary_file **file) {
  tsolid_status status = TSOLID_OK;
  tsolid_boundary_file *f = NULL;
  char *text = NULL;
  size_t size = 0;
  reader r = {.number = {.size = sizeof(double)}};
  if (file)
    *file = NULL;
  if (!context || !path || !file)
    return TSOLID_ERROR_ARGUMENT;
  status = tsi_file_read(context, stage, path, max_file_size, &text, &size);
  if (status != TSOLID_OK)
    goto done;
  f = tsi_boundary_file_new(context);
  if (!f) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  tsi_json_start(&r.json, context, stage, path, text, size);
  r.arena = &f->arena;
  read_document(&r, &f->input);
  drop(&r, &r.number);
  status = r.json.status;
  if (status != TSOLID_OK)
    goto done;
  *file = f;
  f = NULL;
done:
  tsi_delete(&context->allocator, text);
  tsolid_boundary_file_free(f);
  return status;
}

tsolid_boundary_file *tsi_boundary_file_new(tsolid_context *context) {
  tsolid_boundary_file *file = tsi_new(&context->allocator, 1, sizeof *file);
  if (!file)
    return NULL;
  file->allocator = context->allocator;
  file->arena.allocator = &file->allocator;
  return file;
}

const tsolid_boundary_input *tsolid_boundary_file_input(const tsolid_boundary_file *file) {
  return file ? &file->input : NULL;
}

void tsolid_boundary_file_free(tsolid_boundary_file *file) {
  if (!file)
    return;
  tsi_allocator allocator = file->allocator;
  tsi_arena_free(&file->arena);
  tsi_delete(&allocator, file);
}
