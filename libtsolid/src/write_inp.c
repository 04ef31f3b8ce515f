/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Hexahedra as an input deck of CalculiX and Abaqus.
 *
 * Keywords *NODE, *ELEMENT, *NSET, *SURFACE; at most 16 numbers on a line, numbering from 1. Names
 * of sets: letters, digits, '_' and '-' stay, everything else becomes '_'; 80 characters at most.
 */
#include "file_io.h"
#include "hex.h"

static const char stage[] = "export";

enum { NUMBERS_PER_LINE = 15, NAME_SIZE = 80, FIELD_SIZE = 20 };

static void put_name(tsi_output *out, const char *name) {
  char text[NAME_SIZE + 1];
  size_t n = 0;
  for (; name[n] && n < NAME_SIZE; n++) {
    char c = name[n];
    int keep = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
               c == '_' || c == '-';
    text[n] = keep ? c : '_';
  }
  tsi_output_add(out, text, n);
}

static void put_nodes(tsi_output *out, const tsolid_hex *hex) {
  char text[TSI_NUMBER_SIZE];
  tsi_output_text(out, "*NODE, NSET=Nall\n");
  for (int k = 0; k < hex->n_nodes; k++) {
    tsi_output_integer(out, k + 1);
    for (int c = 0; c < 3; c++) {
      tsi_output_text(out, ", ");
      double x = hex->nodes[3 * (size_t)k + (size_t)c];
      tsi_output_add(out, text, tsi_number_print_within(x, FIELD_SIZE, text));
    }
    tsi_output_text(out, "\n");
  }
}

/* A comma at a line's end tells that the record goes on. */
static void put_elements(tsi_output *out, const tsolid_hex *hex) {
  int width = tsi_hex_width(hex->order);
  tsi_output_text(out, hex->order == 2 ? "*ELEMENT, TYPE=C3D20, ELSET=Eall\n"
                                       : "*ELEMENT, TYPE=C3D8, ELSET=Eall\n");
  for (int e = 0; e < hex->n_elements; e++) {
    tsi_output_integer(out, e + 1);
    for (int m = 0; m < width; m++) {
      tsi_output_text(out, m == NUMBERS_PER_LINE ? ",\n" : ", ");
      tsi_output_integer(out, hex->element[(size_t)e * (size_t)width + (size_t)m] + 1);
    }
    tsi_output_text(out, "\n");
  }
}

/* Elements of a part follow each other. */
static void put_parts(tsi_output *out, const tsolid_hex *hex) {
  for (int k = 0; k < hex->n_parts; k++) {
    tsi_output_text(out, "*ELSET, ELSET=");
    put_name(out, hex->part_name[k]);
    tsi_output_text(out, ", GENERATE\n");
    tsi_output_integer(out, hex->part_start[k] + 1);
    tsi_output_text(out, ", ");
    tsi_output_integer(out, hex->part_start[k + 1]);
    tsi_output_text(out, "\n");
  }
}

const signed char tsi_hex_face_nodes[6][8] = {
    {0, 3, 2, 1, 11, 10, 9, 8},  {4, 5, 6, 7, 12, 13, 14, 15}, {0, 1, 5, 4, 8, 17, 12, 16},
    {1, 2, 6, 5, 9, 18, 13, 17}, {2, 3, 7, 6, 10, 19, 14, 18}, {3, 0, 4, 7, 11, 16, 15, 19}};

static void put_region(tsi_output *out, const tsolid_hex *hex, int region, unsigned char *mark) {
  int width = tsi_hex_width(hex->order), on_line = 0;
  memset(mark, 0, (size_t)hex->n_nodes);
  tsi_output_text(out, "*SURFACE, TYPE=ELEMENT, NAME=");
  put_name(out, hex->region_name[region]);
  tsi_output_text(out, "\n");
  for (int k = hex->region_start[region]; k < hex->region_start[region + 1]; k++) {
    int element = hex->region_face[2 * k], face = hex->region_face[2 * k + 1];
    tsi_output_integer(out, element + 1);
    tsi_output_text(out, ", S");
    tsi_output_integer(out, face + 1);
    tsi_output_text(out, "\n");
    for (int m = 0; m < (hex->order == 2 ? 8 : 4); m++)
      mark[hex->element[(size_t)element * (size_t)width + (size_t)tsi_hex_face_nodes[face][m]]] = 1;
  }
  tsi_output_text(out, "*NSET, NSET=");
  put_name(out, hex->region_name[region]);
  tsi_output_text(out, "\n");
  for (int k = 0; k < hex->n_nodes; k++)
    if (mark[k]) {
      if (on_line)
        tsi_output_text(out, on_line % NUMBERS_PER_LINE == 0 ? ",\n" : ", ");
      tsi_output_integer(out, k + 1);
      on_line++;
    }
  tsi_output_text(out, "\n");
}

tsolid_status tsolid_write_inp(tsolid_context *context, const tsolid_hex *hex, const char *path) {
  tsi_output out;
  tsolid_status status = TSOLID_OK;
  if (!context || !hex || !path)
    return TSOLID_ERROR_ARGUMENT;
  tsi_arena arena = tsi_arena_create(context);
  unsigned char *mark = tsi_arena_new(&arena, (size_t)hex->n_nodes, 1);
  if (!mark) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  if (tsi_output_open(&out, context, stage, path) == TSOLID_OK) {
    tsi_output_text(&out,
                    "** Hexahedra from a solid T-spline, made by tsolid " TSOLID_VERSION "\n");
    if (!hex->proved)
      tsi_output_text(&out, "** The solid is NOT proved valid: det J > 0 is not certain.\n");
    put_nodes(&out, hex);
    put_elements(&out, hex);
    put_parts(&out, hex);
    for (int k = 0; k < hex->n_regions && out.status == TSOLID_OK; k++) {
      put_region(&out, hex, k, mark);
      status = tsi_progress(context, stage, (k + 1.0) / hex->n_regions);
      if (status)
        break;
    }
  }
  status = tsi_output_close(&out, status);
done:
  tsi_arena_free(&arena);
  return status;
}
