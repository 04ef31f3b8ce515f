/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Writes hexahedra for VTK and ParaView: cells 12 (VTK_HEXAHEDRON) or 25 (VTK_QUADRATIC_HEXAHEDRON)
 * with the nodes in the order of Abaqus, which is VTK's; behind them a quadrilateral (9, or 23 with
 * mid nodes) for every face of every region. Cell data Region: 0 for hexahedra, k for the faces of
 * region k, counted from 1; field data RegionNames has the names. Of an assembly also cell data
 * Part, counted from 1, and PartNames. */
#include "hex.h"
#include "vtu.h"

static const char stage[] = "export";

enum { HEXAHEDRON = 12, QUADRATIC_HEXAHEDRON = 25, QUAD = 9, QUADRATIC_QUAD = 23 };

typedef enum array_id {
  ARRAY_REGION,
  ARRAY_PART, /* of an assembly only */
  ARRAY_POINTS,
  ARRAY_CONNECTIVITY,
  ARRAY_OFFSETS,
  ARRAY_TYPES,
  N_ARRAYS
} array_id;

static const tsi_vtu_array arrays[N_ARRAYS] = {
    {"Region", "Int32", 4, 1},       {"Part", "Int32", 4, 1},    {"Points", "Float64", 8, 3},
    {"connectivity", "Int64", 8, 1}, {"offsets", "Int64", 8, 1}, {"types", "UInt8", 1, 1}};

typedef struct writer {
  tsi_vtu vtu;
  const tsolid_hex *hex;
  int width, face_width; /* nodes of a hexahedron and of a face */
  uint64_t n_faces, n_cells, n_tuples[N_ARRAYS];
} writer;

static void put_regions(writer *w) {
  const tsolid_hex *hex = w->hex;
  for (int e = 0; e < hex->n_elements; e++)
    tsi_vtu_word(&w->vtu, 0, 4);
  for (int r = 0; r < hex->n_regions; r++)
    for (int k = hex->region_start[r]; k < hex->region_start[r + 1]; k++)
      tsi_vtu_word(&w->vtu, (uint64_t)r + 1, 4);
}

static void put_parts(writer *w) {
  const tsolid_hex *hex = w->hex;
  for (int p = 0; p < hex->n_parts; p++)
    for (int e = hex->part_start[p]; e < hex->part_start[p + 1]; e++)
      tsi_vtu_word(&w->vtu, (uint64_t)p + 1, 4);
  for (size_t k = 0; k < w->n_faces; k++) {
    int element = hex->region_face[2 * k], low = 0, high = hex->n_parts - 1;
    while (low < high) {
      int middle = (low + high) / 2;
      if (element < hex->part_start[middle + 1])
        high = middle;
      else
        low = middle + 1;
    }
    tsi_vtu_word(&w->vtu, (uint64_t)low + 1, 4);
  }
}

static void put_connectivity(writer *w) {
  const tsolid_hex *hex = w->hex;
  size_t width = (size_t)w->width;
  for (size_t k = 0; k < (size_t)hex->n_elements * width; k++)
    tsi_vtu_word(&w->vtu, (uint64_t)hex->element[k], 8);
  for (size_t k = 0; k < w->n_faces; k++) {
    const int *element = hex->element + (size_t)hex->region_face[2 * k] * width;
    const signed char *node = tsi_hex_face_nodes[hex->region_face[2 * k + 1]];
    for (int m = 0; m < w->face_width; m++)
      tsi_vtu_word(&w->vtu, (uint64_t)element[node[m]], 8);
  }
}

static void put_cells(writer *w, array_id id) {
  uint64_t n = (uint64_t)w->hex->n_elements, at = 0;
  int quadratic = w->hex->order == 2;
  for (uint64_t k = 0; k < w->n_cells; k++) {
    at += (uint64_t)(k < n ? w->width : w->face_width);
    int type = k < n ? (quadratic ? QUADRATIC_HEXAHEDRON : HEXAHEDRON)
                     : (quadratic ? QUADRATIC_QUAD : QUAD);
    if (id == ARRAY_OFFSETS)
      tsi_vtu_word(&w->vtu, at, 8);
    else
      tsi_vtu_word(&w->vtu, (uint64_t)type, 1);
  }
}

static void put_array(writer *w, array_id id) {
  tsi_vtu_begin(&w->vtu, &arrays[id], w->n_tuples[id]);
  switch (id) {
  case ARRAY_REGION:
    put_regions(w);
    break;
  case ARRAY_PART:
    put_parts(w);
    break;
  case ARRAY_POINTS:
    for (size_t k = 0; k < 3 * (size_t)w->hex->n_nodes; k++)
      tsi_vtu_double(&w->vtu, w->hex->nodes[k]);
    break;
  case ARRAY_CONNECTIVITY:
    put_connectivity(w);
    break;
  default:
    put_cells(w, id);
    break;
  }
  tsi_vtu_flush(&w->vtu);
}

/* Characters as numbers, each name ended by a zero: how VTK writes texts. */
static void put_names(writer *w, const char *title, int n, const char *const *name) {
  tsi_output *out = &w->vtu.out;
  tsi_output_text(out, "    <Array type=\"String\" Name=\"");
  tsi_output_text(out, title);
  tsi_output_text(out, "\" NumberOfTuples=\"");
  tsi_output_integer(out, n);
  tsi_output_text(out, "\" format=\"ascii\">\n");
  for (int r = 0; r < n; r++) {
    for (const char *c = name[r]; *c; c++) {
      tsi_output_integer(out, (unsigned char)*c);
      tsi_output_text(out, " ");
    }
    tsi_output_text(out, "0\n");
  }
  tsi_output_text(out, "    </Array>\n");
}

static void put_head(writer *w) {
  tsi_output *out = &w->vtu.out;
  tsi_vtu_head(&w->vtu);
  if (!w->hex->proved)
    tsi_output_text(out, "  <!-- The solid is NOT proved valid: det J > 0 is not certain. -->\n");
  tsi_output_text(out, "  <FieldData>\n");
  put_names(w, "RegionNames", w->hex->n_regions, w->hex->region_name);
  if (w->hex->n_parts)
    put_names(w, "PartNames", w->hex->n_parts, w->hex->part_name);
  tsi_output_text(out, "  </FieldData>\n");
  tsi_vtu_piece(&w->vtu, w->n_tuples[ARRAY_POINTS], w->n_cells);
  tsi_output_text(out, "   <CellData Scalars=\"Region\">\n");
  tsi_vtu_declare(&w->vtu, &arrays[ARRAY_REGION], w->n_tuples[ARRAY_REGION]);
  if (w->hex->n_parts)
    tsi_vtu_declare(&w->vtu, &arrays[ARRAY_PART], w->n_tuples[ARRAY_PART]);
  tsi_output_text(out, "   </CellData>\n   <Points>\n");
  tsi_vtu_declare(&w->vtu, &arrays[ARRAY_POINTS], w->n_tuples[ARRAY_POINTS]);
  tsi_output_text(out, "   </Points>\n   <Cells>\n");
  for (int id = ARRAY_CONNECTIVITY; id < N_ARRAYS; id++)
    tsi_vtu_declare(&w->vtu, &arrays[id], w->n_tuples[id]);
  tsi_output_text(out, "   </Cells>\n");
}

static tsolid_status put_document(writer *w) {
  const tsolid_hex *hex = w->hex;
  tsolid_status status = TSOLID_OK;
  w->n_faces = (uint64_t)hex->region_start[hex->n_regions];
  w->n_cells = (uint64_t)hex->n_elements + w->n_faces;
  for (int id = 0; id < N_ARRAYS; id++)
    w->n_tuples[id] = w->n_cells;
  w->n_tuples[ARRAY_POINTS] = (uint64_t)hex->n_nodes;
  w->n_tuples[ARRAY_CONNECTIVITY] =
      (uint64_t)hex->n_elements * (uint64_t)w->width + w->n_faces * (uint64_t)w->face_width;
  put_head(w);
  tsi_vtu_data(&w->vtu);
  for (int id = 0; id < N_ARRAYS && !status; id++) {
    if (id != ARRAY_PART || hex->n_parts)
      put_array(w, (array_id)id);
    status = tsi_progress(w->vtu.out.context, stage, (id + 1.0) / N_ARRAYS);
  }
  tsi_vtu_end(&w->vtu);
  return status;
}

tsolid_status tsolid_write_hex_vtu(tsolid_context *context, const tsolid_hex *hex,
                                   const char *path) {
  tsolid_status status = TSOLID_OK;
  if (!context || !hex || !path)
    return TSOLID_ERROR_ARGUMENT;
  writer w = {.hex = hex, .width = tsi_hex_width(hex->order)};
  w.face_width = hex->order == 2 ? 8 : 4;
  if (tsi_output_open(&w.vtu.out, context, stage, path) == TSOLID_OK)
    status = put_document(&w);
  return tsi_output_close(&w.vtu.out, status);
}
