/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The frame of VTK's XML files of unstructured grids. */
#include <stdio.h>

#include "vtu.h"

/* ---- base64 ------------------------------------------------------------------------------------
 */

void tsi_vtu_flush(tsi_vtu *vtu) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const unsigned char *b = vtu->pending;
  if (vtu->n_pending == 0)
    return;
  for (int k = vtu->n_pending; k < 3; k++)
    vtu->pending[k] = 0;
  char text[4] = {digits[b[0] >> 2], digits[(b[0] & 3) << 4 | b[1] >> 4],
                  digits[(b[1] & 15) << 2 | b[2] >> 6], digits[b[2] & 63]};
  for (int k = vtu->n_pending + 1; k < 4; k++)
    text[k] = '=';
  tsi_output_add(&vtu->out, text, 4);
  vtu->n_pending = 0;
}

void tsi_vtu_word(tsi_vtu *vtu, uint64_t value, int size) {
  for (int k = 0; k < size; k++) {
    vtu->pending[vtu->n_pending++] = (unsigned char)(value >> 8 * k & 255);
    if (vtu->n_pending == 3)
      tsi_vtu_flush(vtu);
  }
}

void tsi_vtu_double(tsi_vtu *vtu, double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  tsi_vtu_word(vtu, bits, 8);
}

/* ---- the frame ---------------------------------------------------------------------------------
 */

static uint64_t array_bytes(const tsi_vtu_array *array, uint64_t n_tuples) {
  return (uint64_t)array->size * (uint64_t)array->n_components * n_tuples;
}

static uint64_t base64_length(uint64_t bytes) {
  return (bytes + 2) / 3 * 4;
}

void tsi_vtu_text(tsi_vtu *vtu, const char *text) {
  for (; *text; text++) {
    const char *escape = NULL;
    switch (*text) {
    case '&':
      escape = "&amp;";
      break;
    case '<':
      escape = "&lt;";
      break;
    case '>':
      escape = "&gt;";
      break;
    case '"':
      escape = "&quot;";
      break;
    default:
      break;
    }
    if (escape)
      tsi_output_text(&vtu->out, escape);
    else
      tsi_output_add(&vtu->out, text, 1);
  }
}

void tsi_vtu_head(tsi_vtu *vtu) {
  tsi_output_text(&vtu->out, "<?xml version=\"1.0\"?>\n"
                             "<VTKFile type=\"UnstructuredGrid\" version=\"2.2\" "
                             "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
                             " <UnstructuredGrid>\n");
}

void tsi_vtu_piece(tsi_vtu *vtu, uint64_t n_points, uint64_t n_cells) {
  tsi_output *out = &vtu->out;
  tsi_output_text(out, "  <Piece NumberOfPoints=\"");
  tsi_output_integer(out, (long long)n_points);
  tsi_output_text(out, "\" NumberOfCells=\"");
  tsi_output_integer(out, (long long)n_cells);
  tsi_output_text(out, "\">\n");
}

void tsi_vtu_declare(tsi_vtu *vtu, const tsi_vtu_array *array, uint64_t n_tuples) {
  char text[128];
  snprintf(text, sizeof text, "    <DataArray type=\"%s\" Name=\"", array->type);
  tsi_output_text(&vtu->out, text);
  tsi_vtu_text(vtu, array->name);
  snprintf(text, sizeof text,
           "\" NumberOfComponents=\"%d\" format=\"appended\" offset=\"%llu\"/>\n",
           array->n_components, (unsigned long long)vtu->offset);
  tsi_output_text(&vtu->out, text);
  vtu->offset += base64_length(8) + base64_length(array_bytes(array, n_tuples));
}

void tsi_vtu_data(tsi_vtu *vtu) {
  tsi_output_text(&vtu->out, "  </Piece>\n </UnstructuredGrid>\n"
                             " <AppendedData encoding=\"base64\">\n_");
}

void tsi_vtu_begin(tsi_vtu *vtu, const tsi_vtu_array *array, uint64_t n_tuples) {
  tsi_vtu_word(vtu, array_bytes(array, n_tuples), 8);
  tsi_vtu_flush(vtu); /* the length is a base64 text of its own */
}

void tsi_vtu_end(tsi_vtu *vtu) {
  tsi_output_text(&vtu->out, "\n </AppendedData>\n</VTKFile>\n");
}
