/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Reads a solid from .tsolid (tsolid_format.h). The checksums find accidents; against intent every
 * count is checked before it is used, and what the later stages rely on is checked by them. */
#include <limits.h>
#include <zlib.h>

#include "file_io.h"
#include "tmesh.h"
#include "tsolid_format.h"

static const char stage[] = "read";
static const size_t max_file_size = (size_t)1 << 32;

/* One cursor for the file and for the payload of the section that is being read. */
typedef struct reader {
  tsolid_context *context;
  const char *path;
  const unsigned char *at, *section_end, *end;
  char tag[5];
  int version;
  tsolid_status status;
} reader;

/* The first failure counts. Returns 0. */
static int fail(reader *r, const char *what) {
  if (r->status == TSOLID_OK)
    r->status = tsi_fail(r->context, TSOLID_ERROR_INPUT, stage, "File '%s'%s%s: %s", r->path,
                         r->tag[0] ? ", section " : "", r->tag, what);
  return 0;
}

static int fail_memory(reader *r) {
  if (r->status == TSOLID_OK)
    r->status = tsi_no_memory(r->context, stage);
  return 0;
}

/* ---- decoding ----------------------------------------------------------------------------------
 */

static uint64_t decode(const unsigned char *bytes, int size) {
  uint64_t value = 0;
  for (int k = size - 1; k >= 0; k--)
    value = value << 8 | bytes[k];
  return value;
}

static size_t bytes_left(const reader *r) {
  return (size_t)(r->section_end - r->at);
}

static int need(reader *r, size_t n, size_t size) {
  return r->status == TSOLID_OK &&
         (n <= bytes_left(r) / size || fail(r, "it is shorter than its counts say"));
}

static int get_ints(reader *r, size_t n, int low, int high, int *value) {
  if (!need(r, n, 4))
    return 0;
  for (size_t k = 0; k < n; k++, r->at += 4) {
    uint64_t bits = decode(r->at, 4);
    int64_t number = bits > INT32_MAX ? (int64_t)bits - ((int64_t)1 << 32) : (int64_t)bits;
    if (number < low || number > high)
      return fail(r, "a whole number is out of range");
    value[k] = (int)number;
  }
  return 1;
}

static int get_doubles(reader *r, size_t n, double *value) {
  if (!need(r, n, 8))
    return 0;
  for (size_t k = 0; k < n; k++, r->at += 8) {
    uint64_t bits = decode(r->at, 8);
    memcpy(&value[k], &bits, sizeof bits);
    if (!isfinite(value[k]))
      return fail(r, "a number is not finite");
  }
  return 1;
}

/* A new array; only to be called after need() has bounded n by the file's own size. */
static void *make(reader *r, size_t n, size_t size) {
  void *memory = tsi_new(&r->context->allocator, n, size);
  if (!memory)
    fail_memory(r);
  return memory;
}

static int make_doubles(reader *r, size_t n, double **value) {
  return need(r, n, 8) && (*value = make(r, n, sizeof **value)) && get_doubles(r, n, *value);
}

static int make_ints(reader *r, size_t n, int low, int high, int **value) {
  return need(r, n, 4) && (*value = make(r, n, sizeof **value)) &&
         get_ints(r, n, low, high, *value);
}

/* ---- sections ----------------------------------------------------------------------------------
 */

static uint32_t checksum(const unsigned char *bytes, size_t size) {
  return (uint32_t)crc32_z(crc32(0, NULL, 0), bytes, size);
}

/* Moves behind one section after a look at its frame: damage is found before anything is built. */
static int skip_section(reader *r, const char *tag) {
  memcpy(r->tag, tag, 4);
  const unsigned char *begin = r->at;
  size_t left = (size_t)(r->end - begin);
  if (left < TSI_TSOLID_SECTION_FRAME)
    return fail(r, "the file ends before it");
  if (memcmp(begin, tag, 4) != 0)
    return fail(r, "another section stands in its place");
  uint64_t length = decode(begin + 4, 8);
  if (length > left - TSI_TSOLID_SECTION_FRAME)
    return fail(r, "the file ends within it");
  size_t covered = 12 + (size_t)length;
  if (checksum(begin, covered) != decode(begin + covered, 4))
    return fail(r, "its checksum is wrong: the file is damaged");
  r->at = begin + covered + 4;
  r->tag[0] = 0;
  return 1;
}

static int check_sections(reader *r) {
  static const char *const tags[] = {"FUNC", "SIDE", "SIDE", "SIDE", "SIDE", "SIDE",
                                     "SIDE", "FACT", "MESH", "CTRL", "INFO"};
  const unsigned char *first = r->at;
  for (size_t k = 0; k < sizeof tags / sizeof *tags; k++)
    if (!skip_section(r, tags[k]))
      return 0;
  if (r->at != r->end)
    return fail(r, "something follows the last section");
  r->at = first;
  return 1;
}

/* After check_sections: the caller asks for the tags in the same order. */
static int begin_section(reader *r, const char *tag) {
  if (r->status != TSOLID_OK)
    return 0;
  memcpy(r->tag, tag, 4);
  size_t length = (size_t)decode(r->at + 4, 8);
  r->at += 12;
  r->section_end = r->at + length;
  return 1;
}

static int end_section(reader *r) {
  if (r->status != TSOLID_OK)
    return 0;
  if (r->at != r->section_end)
    return fail(r, "it is longer than its counts say");
  r->at += 4;
  r->tag[0] = 0;
  return 1;
}

static int read_header(reader *r) {
  if (r->end - r->at < TSI_TSOLID_MAGIC_SIZE + 4 ||
      memcmp(r->at, TSI_TSOLID_MAGIC, TSI_TSOLID_MAGIC_SIZE) != 0)
    return fail(r, "this is no .tsolid file");
  uint64_t version = decode(r->at + TSI_TSOLID_MAGIC_SIZE, 4);
  if (version < 1 || version > TSI_TSOLID_VERSION)
    return fail(r, version > TSI_TSOLID_VERSION ? "it was written by a newer version"
                                                : "its version is not known");
  r->version = (int)version;
  r->at += TSI_TSOLID_MAGIC_SIZE + 4;
  return 1;
}

static tsolid_boundary *read_functions(reader *r) {
  int n;
  if (!begin_section(r, "FUNC") || !get_ints(r, 1, 1, TSI_MAX_COUNT, &n) || !need(r, (size_t)n, 32))
    return NULL;
  tsolid_boundary *boundary = tsi_boundary_new(r->context, n);
  if (!boundary)
    fail_memory(r);
  else if (get_doubles(r, 4 * (size_t)n, boundary->points))
    end_section(r);
  return boundary;
}

static int read_function_starts(reader *r, tsi_side *side) {
  size_t n_elements = (size_t)side->n_elements;
  if (!make_ints(r, n_elements + 1, 0, TSI_MAX_COUNT, &side->function_start))
    return 0;
  if (side->function_start[0] != 0)
    return fail(r, "the functions do not start at 0");
  for (size_t e = 0; e < n_elements; e++)
    if (side->function_start[e + 1] < side->function_start[e])
      return fail(r, "an element has a negative number of functions");
  return 1;
}

static int read_side(reader *r, int n_functions, tsi_side *side) {
  if (!begin_section(r, "SIDE") || !get_ints(r, 2, 1, TSI_MAX_DEGREE, side->degree) ||
      !get_ints(r, 2, 1, TSI_MAX_COUNT, side->grid) ||
      !get_ints(r, 1, 1, TSI_MAX_COUNT, &side->n_elements))
    return 0;
  size_t order = (size_t)(side->degree[0] + 1) * (size_t)(side->degree[1] + 1);
  if (!make_doubles(r, 4 * (size_t)side->n_elements, &side->box) || !read_function_starts(r, side))
    return 0;
  size_t n = (size_t)side->function_start[side->n_elements];
  return make_ints(r, n, 0, n_functions - 1, &side->function) &&
         make_doubles(r, n * order, &side->coefficient) && end_section(r);
}

static int read_facts(reader *r, tsolid_requirement *q, tsolid_preparation *p) {
  int counts[9], changes[9] = {0}, n_changes = r->version == 1 ? 4 : r->version < 4 ? 6 : 9;
  if (!begin_section(r, "FACT") || !get_ints(r, 9, -1, TSI_MAX_COUNT, counts) ||
      !get_doubles(r, 24, &q->corner[0][0]) ||
      !get_ints(r, 12, 0, TSI_MAX_COUNT, &q->side_grid[0][0]) || !get_doubles(r, 12, p->snap) ||
      !get_doubles(r, 6, p->snap_inside) || !get_doubles(r, 6, p->weight_factor) ||
      !get_doubles(r, 1, &p->knot_merge) ||
      !get_ints(r, (size_t)n_changes, 0, TSI_MAX_COUNT, changes))
    return 0;
  if (counts[0] != 1)
    return fail(r, "the boundary does not satisfy the requirement");
  q->satisfied = counts[0];
  q->closed = counts[1];
  q->connected = counts[2];
  q->genus = counts[3];
  q->n_patches = counts[4];
  q->n_vertices = counts[5];
  q->n_edges = counts[6];
  q->n_extraordinary = counts[7];
  q->n_violations = counts[8];
  p->n_knots_inserted = changes[0];
  p->n_degrees_raised = changes[1];
  p->refine_knots = changes[2];
  p->raise_degree = changes[3];
  p->n_bilinear_factors = changes[4];
  p->n_moebius = changes[5];
  p->n_cut_patches = changes[6];
  p->n_cuts = changes[7];
  p->n_knots_merged = changes[8];
  return end_section(r);
}

static tsolid_tmesh *read_mesh(reader *r) {
  int n_lines[3], n_boxes, *box = NULL, *level = NULL, flags = 0;
  double *line[3] = {NULL, NULL, NULL}, arm_height[6];
  tsolid_tmesh *tmesh = NULL;
  int read = begin_section(r, "MESH") && get_ints(r, 3, 2, TSI_MAX_COUNT, n_lines);
  for (int a = 0; a < 3; a++)
    read = read && make_doubles(r, (size_t)n_lines[a], &line[a]);
  read = read && get_ints(r, 1, 1, TSI_MAX_COUNT, &n_boxes) &&
         make_ints(r, 6 * (size_t)n_boxes, 0, TSI_MAX_COUNT, &box) &&
         get_doubles(r, 6, arm_height) &&
         (r->version < 3 || (get_ints(r, 1, 0, r->version < 4 ? 1 : TSI_TMESH_ALL_FLAGS, &flags) &&
                             make_ints(r, (size_t)n_boxes, 0, TSI_MAX_LEVELS - 1, &level))) &&
         end_section(r);
  if (read)
    r->status = tsi_tmesh_from_boxes(r->context, n_lines, (const double *const *)line, n_boxes, box,
                                     arm_height, flags, &tmesh);
  if (tmesh && level)
    r->status = tsi_tmesh_set_levels(r->context, tmesh, level);
  for (int a = 0; a < 3; a++)
    tsi_delete(&r->context->allocator, line[a]);
  tsi_delete(&r->context->allocator, box);
  tsi_delete(&r->context->allocator, level);
  return tmesh;
}

/* Control points of all functions: those of the file, then the boundary's own. */
static double *read_control(reader *r, const tsolid_space *space) {
  int n;
  double *control = NULL;
  size_t n_free = (size_t)space->n_inner + (size_t)space->n_surface;
  if (!begin_section(r, "CTRL") || !get_ints(r, 1, 1, TSI_MAX_COUNT, &n))
    return NULL;
  if ((size_t)n != n_free) {
    fail(r, "the number of control points is not that of the functions");
    return NULL;
  }
  if (need(r, (size_t)n, 32))
    control = make(r, n_free + (size_t)space->n_surface, 4 * sizeof *control);
  if (!control || !get_doubles(r, 4 * n_free, control) || !end_section(r)) {
    tsi_delete(&r->context->allocator, control);
    return NULL;
  }
  memcpy(control + 4 * n_free, space->boundary->points,
         4 * (size_t)space->n_surface * sizeof *control);
  return control;
}

/* The only number that may be NaN: nobody measured it. */
static int read_info(reader *r, double *start_worst) {
  if (!begin_section(r, "INFO") || !need(r, 1, 8))
    return 0;
  uint64_t bits = decode(r->at, 8);
  memcpy(start_worst, &bits, sizeof bits);
  r->at += 8;
  return end_section(r);
}

/* ---- driver ------------------------------------------------------------------------------------
 */

static int read_boundary(reader *r, tsolid_boundary **boundary) {
  *boundary = read_functions(r);
  for (int k = 0; k < 6 && r->status == TSOLID_OK; k++)
    read_side(r, (*boundary)->n_functions, &(*boundary)->side[k]);
  if (r->status == TSOLID_OK)
    read_facts(r, &(*boundary)->requirement, &(*boundary)->preparation);
  if (r->status == TSOLID_OK)
    r->status = tsi_boundary_validate(r->context, *boundary);
  if (r->status == TSOLID_OK)
    (*boundary)->scale = tsi_boundary_find_scale(*boundary);
  return r->status == TSOLID_OK;
}

static int read_solid(reader *r, const tsolid_space *space, tsolid_solid **solid) {
  double start_worst = 0, *control = read_control(r, space);
  if (control && read_info(r, &start_worst))
    r->status = tsolid_solid_from_control(r->context, space, control, solid);
  tsi_delete(&r->context->allocator, control);
  if (r->status == TSOLID_OK)
    (*solid)->start_worst = start_worst;
  return r->status == TSOLID_OK;
}

tsolid_status tsolid_read_tsolid(tsolid_context *context, const char *path, tsolid_solid **solid) {
  char *bytes = NULL;
  size_t size = 0;
  tsolid_boundary *boundary = NULL;
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  reader r = {.context = context, .path = path};
  if (solid)
    *solid = NULL;
  if (!context || !path || !solid)
    return TSOLID_ERROR_ARGUMENT;
  r.status = tsi_file_read(context, stage, path, max_file_size, &bytes, &size);
  if (r.status != TSOLID_OK)
    return r.status;
  r.at = (const unsigned char *)bytes;
  r.end = r.section_end = r.at + size;
  if (!read_header(&r) || !check_sections(&r) || !read_boundary(&r, &boundary))
    goto done;
  tmesh = read_mesh(&r);
  if (!tmesh || r.status != TSOLID_OK)
    goto done;
  r.status = tsolid_space_create(context, boundary, tmesh, &space);
  if (r.status != TSOLID_OK)
    goto done;
  read_solid(&r, space, solid);
done:
  tsi_delete(&context->allocator, bytes);
  tsolid_boundary_free(boundary);
  tsolid_tmesh_free(tmesh);
  tsolid_space_free(space);
  return r.status;
}
