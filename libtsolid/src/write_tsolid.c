/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Writes a solid as .tsolid (tsolid_format.h). */
#include <zlib.h>

#include "file_io.h"
#include "tmesh.h"
#include "tsolid_format.h"

static const char stage[] = "write";

/* A section is streamed: its length is known beforehand, its checksum grows along. */
typedef struct writer {
  tsi_output out;
  uLong crc;
  uint64_t left; /* payload bytes still to come: 0 at the end, or the length was wrong */
} writer;

/* ---- encoding ----------------------------------------------------------------------------------
 */

static void put_bytes(writer *w, const unsigned char *bytes, size_t size) {
  w->crc = crc32(w->crc, bytes, (uInt)size);
  tsi_output_add(&w->out, bytes, size);
}

static void encode(uint64_t value, int size, unsigned char *bytes) {
  for (int k = 0; k < size; k++)
    bytes[k] = (unsigned char)(value >> 8 * k & 255);
}

static void put_u32(writer *w, uint32_t value) {
  unsigned char bytes[4];
  encode(value, 4, bytes);
  put_bytes(w, bytes, sizeof bytes);
  w->left -= sizeof bytes;
}

static void put_int(writer *w, int value) {
  put_u32(w, (uint32_t)value);
}

static void put_ints(writer *w, const int *value, size_t n) {
  for (size_t k = 0; k < n; k++)
    put_int(w, value[k]);
}

static void put_doubles(writer *w, const double *value, size_t n) {
  for (size_t k = 0; k < n; k++) {
    unsigned char bytes[8];
    uint64_t bits;
    memcpy(&bits, &value[k], sizeof bits);
    encode(bits, 8, bytes);
    put_bytes(w, bytes, sizeof bytes);
    w->left -= sizeof bytes;
  }
}

static void begin_section(writer *w, const char *tag, uint64_t length) {
  unsigned char bytes[8];
  w->crc = crc32(0, NULL, 0);
  put_bytes(w, (const unsigned char *)tag, 4);
  encode(length, 8, bytes);
  put_bytes(w, bytes, sizeof bytes);
  w->left = length;
}

static void end_section(writer *w) {
  if (w->left != 0 && w->out.status == TSOLID_OK)
    w->out.status = tsi_fail(w->out.context, TSOLID_ERROR_INTERNAL, stage,
                             "A section of '%s' has another length than announced", w->out.path);
  w->left = 4;
  put_u32(w, (uint32_t)w->crc);
}

/* ---- sections ----------------------------------------------------------------------------------
 */

static void put_rows_of_4(writer *w, const char *tag, const double *row, size_t n) {
  begin_section(w, tag, 4 + 32 * (uint64_t)n);
  put_u32(w, (uint32_t)n);
  put_doubles(w, row, 4 * n);
  end_section(w);
}

static void put_side(writer *w, const tsi_side *side) {
  size_t order = (size_t)(side->degree[0] + 1) * (size_t)(side->degree[1] + 1);
  size_t n_elements = (size_t)side->n_elements, n = (size_t)side->function_start[n_elements];
  begin_section(w, "SIDE", 20 + 32 * n_elements + 4 * (n_elements + 1) + n * (4 + 8 * order));
  put_ints(w, side->degree, 2);
  put_ints(w, side->grid, 2);
  put_int(w, side->n_elements);
  put_doubles(w, side->box, 4 * n_elements);
  put_ints(w, side->function_start, n_elements + 1);
  put_ints(w, side->function, n);
  put_doubles(w, side->coefficient, n * order);
  end_section(w);
}

static void put_facts(writer *w, const tsolid_requirement *r, const tsolid_preparation *p) {
  int counts[9] = {r->satisfied,  r->closed,  r->connected,       r->genus,       r->n_patches,
                   r->n_vertices, r->n_edges, r->n_extraordinary, r->n_violations};
  int changes[9] = {p->n_knots_inserted,   p->n_degrees_raised, p->refine_knots,  p->raise_degree,
                    p->n_bilinear_factors, p->n_moebius,        p->n_cut_patches, p->n_cuts,
                    p->n_knots_merged};
  begin_section(w, "FACT", 4 * (9 + 12 + 9) + 8 * (24 + 12 + 6 + 6 + 1));
  put_ints(w, counts, 9);
  put_doubles(w, &r->corner[0][0], 24);
  put_ints(w, &r->side_grid[0][0], 12);
  put_doubles(w, p->snap, 12);
  put_doubles(w, p->snap_inside, 6);
  put_doubles(w, p->weight_factor, 6);
  put_doubles(w, &p->knot_merge, 1);
  put_ints(w, changes, 9);
  end_section(w);
}

static void put_mesh(writer *w, const tsolid_tmesh *tmesh) {
  uint64_t n_lines = 0, n_boxes = (uint64_t)tmesh->n_boxes;
  for (int a = 0; a < 3; a++)
    n_lines += (uint64_t)tmesh->n_lines[a];
  begin_section(w, "MESH", 12 + 8 * n_lines + 4 + 24 * n_boxes + 48 + 4 + 4 * n_boxes);
  put_ints(w, tmesh->n_lines, 3);
  for (int a = 0; a < 3; a++)
    put_doubles(w, tmesh->line[a], (size_t)tmesh->n_lines[a]);
  put_int(w, tmesh->n_boxes);
  put_ints(w, tmesh->box, 6 * (size_t)tmesh->n_boxes);
  put_doubles(w, tmesh->arm_height, 6);
  put_int(w, tmesh->flags);
  for (int b = 0; b < tmesh->n_boxes; b++)
    put_int(w, tsi_box_level(tmesh, b));
  end_section(w);
}

static void put_solid(writer *w, const tsolid_solid *solid) {
  const tsolid_space *space = solid->space;
  const tsolid_boundary *boundary = space->boundary;
  put_bytes(w, (const unsigned char *)TSI_TSOLID_MAGIC, TSI_TSOLID_MAGIC_SIZE);
  put_u32(w, TSI_TSOLID_VERSION);
  put_rows_of_4(w, "FUNC", boundary->points, (size_t)boundary->n_functions);
  for (int k = 0; k < 6; k++)
    put_side(w, &boundary->side[k]);
  put_facts(w, &boundary->requirement, &boundary->preparation);
  put_mesh(w, space->tmesh);
  put_rows_of_4(w, "CTRL", solid->control, (size_t)space->n_inner + (size_t)space->n_surface);
  begin_section(w, "INFO", 8);
  put_doubles(w, &solid->start_worst, 1);
  end_section(w);
}

tsolid_status tsolid_write_tsolid(tsolid_context *context, const tsolid_solid *solid,
                                  const char *path) {
  writer w = {.crc = 0};
  tsolid_status status = TSOLID_OK;
  if (!context || !solid || !path)
    return TSOLID_ERROR_ARGUMENT;
  if (tsi_output_open(&w.out, context, stage, path) == TSOLID_OK) {
    put_solid(&w, solid);
    status = tsi_progress(context, stage, 1.0);
  }
  return tsi_output_close(&w.out, status);
}
