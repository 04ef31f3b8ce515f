/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Writes a solid as rational Bezier hexahedra for VTK and ParaView.
 *
 * What readers insist on: cell type 79 with the points in VTK's order; a file version of at least
 * 2.1, below which VTK swaps edges; weights and degrees not only named but declared as the active
 * attributes RationalWeights and HigherOrderDegrees. Each cell has points of its own, Euclidean.
 * Arrays stand in one appended block, base64, little-endian, in the order of `arrays`. */
#include <stdio.h>

#include "bernstein.h"
#include "file_io.h"

static const char stage[] = "export";

enum { BEZIER_HEXAHEDRON = 79, GRID = 4 };

/* ---- geometry ----------------------------------------------------------------------------------
 */

/* Index of control point (i, j, k) among a cell's points, for degrees p, q, r: corners, edges,
 * faces, inside. */
static int vtk_index(const int degree[3], int i, int j, int k) {
  int p = degree[0], q = degree[1], r = degree[2];
  int ib = i == 0 || i == p, jb = j == 0 || j == q, kb = k == 0 || k == r;
  int on_borders = ib + jb + kb, offset = 8;
  if (on_borders == 3)
    return (i ? (j ? 2 : 1) : (j ? 3 : 0)) + (k ? 4 : 0);
  if (on_borders == 2) {
    if (!ib)
      return offset + (i - 1) + (j ? p + q - 2 : 0) + (k ? 2 * (p + q - 2) : 0);
    if (!jb)
      return offset + (j - 1) + (i ? p - 1 : 2 * (p - 1) + q - 1) + (k ? 2 * (p + q - 2) : 0);
    return offset + 4 * (p + q - 2) + (k - 1) + (r - 1) * (i ? (j ? 2 : 1) : (j ? 3 : 0));
  }
  offset += 4 * (p + q + r - 3);
  if (ib && on_borders == 1)
    return offset + (j - 1) + (q - 1) * (k - 1) + (i ? (q - 1) * (r - 1) : 0);
  offset += 2 * (q - 1) * (r - 1);
  if (jb && on_borders == 1)
    return offset + (i - 1) + (p - 1) * (k - 1) + (j ? (r - 1) * (p - 1) : 0);
  offset += 2 * (r - 1) * (p - 1);
  if (kb && on_borders == 1)
    return offset + (i - 1) + (p - 1) * (j - 1) + (k ? (p - 1) * (q - 1) : 0);
  offset += 2 * (p - 1) * (q - 1);
  return offset + (i - 1) + (p - 1) * ((j - 1) + (q - 1) * (k - 1));
}

static size_t count_points(const int degree[3]) {
  return (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1) * (size_t)(degree[2] + 1);
}

/* Scaled Jacobian at one point from (X, W) and its three derivatives, rows of 4. With x = X/W,
 * x_d = (X_d - x W_d) / W; the factors 1/W cancel, W > 0. */
static double scaled_jacobian(const double h[16]) {
  double d[3][3], length = 1;
  for (int a = 0; a < 3; a++) {
    double square = 0;
    for (int c = 0; c < 3; c++) {
      d[a][c] = h[4 * a + 4 + c] - h[c] / h[3] * h[4 * a + 7];
      square += d[a][c] * d[a][c];
    }
    length *= sqrt(square);
  }
  double determinant = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) +
                       d[0][1] * (d[1][2] * d[2][0] - d[1][0] * d[2][2]) +
                       d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
  return length > 0 ? determinant / length : 0;
}

/* Adds n numbers times a Bernstein value and, behind them, the first 4 times its derivative. */
static void add_derivatives(double value, double slope, int n, const double *from, double *to) {
  for (int m = 0; m < n; m++)
    to[m] += value * from[m];
  for (int m = 0; m < 4; m++)
    to[n + m] += slope * from[m];
}

/* The worst on a GRID^3 grid, borders included. Sums go direction by direction: a point carries
 * (X, W) and then its derivatives in the directions that are already done, 4 numbers each. */
static double worst_jacobian(const int degree[3], const double *net, double *plane) {
  double value[3][GRID][2 * TSI_MAX_ORDER], worst = 2;
  int n0 = degree[0] + 1, n1 = degree[1] + 1, n2 = degree[2] + 1;
  for (int a = 0; a < 3; a++)
    for (int x = 0; x < GRID; x++)
      tsi_bernstein_derivatives(degree[a], x / (double)(GRID - 1), 1, value[a][x]);
  for (int x = 0; x < GRID; x++) {
    memset(plane, 0, 8 * (size_t)(n1 * n2) * sizeof *plane);
    for (int jk = 0; jk < n1 * n2; jk++)
      for (int i = 0; i < n0; i++)
        add_derivatives(value[0][x][i], value[0][x][n0 + i], 4, net + 4 * (jk * n0 + i),
                        plane + 8 * jk);
    for (int y = 0; y < GRID; y++) {
      double line[TSI_MAX_ORDER][12] = {{0}};
      for (int k = 0; k < n2; k++)
        for (int j = 0; j < n1; j++)
          add_derivatives(value[1][y][j], value[1][y][n1 + j], 8, plane + 8 * (k * n1 + j),
                          line[k]);
      for (int z = 0; z < GRID; z++) {
        double point[16] = {0};
        for (int k = 0; k < n2; k++)
          add_derivatives(value[2][z][k], value[2][z][n2 + k], 12, line[k], point);
        worst = fmin(worst, scaled_jacobian(point));
      }
    }
  }
  return worst;
}

/* ---- base64 ------------------------------------------------------------------------------------
 */

typedef struct writer {
  tsi_output out;
  const tsolid_solid *solid;
  double *net; /* scratch: one element, and reordered */
  double *reordered;
  double *plane;
  unsigned char pending[3];
  int n_pending;
} writer;

static void flush_base64(writer *w) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const unsigned char *b = w->pending;
  if (w->n_pending == 0)
    return;
  for (int k = w->n_pending; k < 3; k++)
    w->pending[k] = 0;
  char text[4] = {digits[b[0] >> 2], digits[(b[0] & 3) << 4 | b[1] >> 4],
                  digits[(b[1] & 15) << 2 | b[2] >> 6], digits[b[2] & 63]};
  for (int k = w->n_pending + 1; k < 4; k++)
    text[k] = '=';
  tsi_output_add(&w->out, text, 4);
  w->n_pending = 0;
}

static void put_word(writer *w, uint64_t value, int size) {
  for (int k = 0; k < size; k++) {
    w->pending[w->n_pending++] = (unsigned char)(value >> 8 * k & 255);
    if (w->n_pending == 3)
      flush_base64(w);
  }
}

static void put_double(writer *w, double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  put_word(w, bits, 8);
}

/* ---- arrays ------------------------------------------------------------------------------------
 */

typedef enum array_id {
  ARRAY_WEIGHTS,
  ARRAY_DEGREES,
  ARRAY_BLOCK,
  ARRAY_JACOBIAN,
  ARRAY_POINTS,
  ARRAY_CONNECTIVITY,
  ARRAY_OFFSETS,
  ARRAY_TYPES,
  N_ARRAYS
} array_id;

typedef struct array_form {
  const char *name, *type;
  int size, n_components, of_points; /* bytes of a number; one tuple per point or per cell */
} array_form;

static const array_form arrays[N_ARRAYS] = {{"RationalWeights", "Float64", 8, 1, 1},
                                            {"HigherOrderDegrees", "Int32", 4, 3, 0},
                                            {"Block", "Int32", 4, 1, 0},
                                            {"ScaledJacobian", "Float64", 8, 1, 0},
                                            {"Points", "Float64", 8, 3, 1},
                                            {"connectivity", "Int64", 8, 1, 1},
                                            {"offsets", "Int64", 8, 1, 0},
                                            {"types", "UInt8", 1, 1, 0}};

static uint64_t array_bytes(const array_form *form, uint64_t n_points, uint64_t n_cells) {
  return (uint64_t)form->size * (uint64_t)form->n_components *
         (form->of_points ? n_points : n_cells);
}

/* The element's control points (x, y, z, w) in VTK's order. */
static const double *load_cell(writer *w, int element) {
  const tsolid_space *space = w->solid->space;
  const int *degree = space->element[element].degree;
  const double *row = w->net;
  tsi_element_net(space, w->solid->control, 4, element, w->net);
  for (int k = 0; k <= degree[2]; k++)
    for (int j = 0; j <= degree[1]; j++)
      for (int i = 0; i <= degree[0]; i++, row += 4) {
        double *to = w->reordered + 4 * (size_t)vtk_index(degree, i, j, k);
        for (int c = 0; c < 3; c++)
          to[c] = row[c] / row[3];
        to[3] = row[3];
      }
  return w->reordered;
}

static void put_cell(writer *w, array_id id, int element, uint64_t first, uint64_t n) {
  const tsi_element *e = &w->solid->space->element[element];
  const double *points = id == ARRAY_WEIGHTS || id == ARRAY_POINTS ? load_cell(w, element) : NULL;
  switch (id) {
  case ARRAY_WEIGHTS:
    for (uint64_t k = 0; k < n; k++)
      put_double(w, points[4 * k + 3]);
    break;
  case ARRAY_POINTS:
    for (uint64_t k = 0; k < 3 * n; k++)
      put_double(w, points[4 * (k / 3) + k % 3]);
    break;
  case ARRAY_DEGREES:
    for (int a = 0; a < 3; a++)
      put_word(w, (uint64_t)e->degree[a], 4);
    break;
  case ARRAY_BLOCK:
    put_word(w, (uint64_t)e->block, 4);
    break;
  case ARRAY_JACOBIAN:
    tsi_element_net(w->solid->space, w->solid->control, 4, element, w->net);
    put_double(w, worst_jacobian(e->degree, w->net, w->plane));
    break;
  case ARRAY_CONNECTIVITY:
    for (uint64_t k = 0; k < n; k++)
      put_word(w, first + k, 8);
    break;
  case ARRAY_OFFSETS:
    put_word(w, first + n, 8);
    break;
  default:
    put_word(w, BEZIER_HEXAHEDRON, 1);
    break;
  }
}

static tsolid_status put_array(writer *w, array_id id, uint64_t n_points) {
  const tsolid_space *space = w->solid->space;
  uint64_t first = 0;
  put_word(w, array_bytes(&arrays[id], n_points, (uint64_t)space->n_elements), 8);
  flush_base64(w); /* the length is a base64 text of its own */
  for (int e = 0; e < space->n_elements && w->out.status == TSOLID_OK; e++) {
    uint64_t n = count_points(space->element[e].degree);
    put_cell(w, id, e, first, n);
    first += n;
    if (e % 256 == 0) {
      double fraction = ((double)id + e / (double)space->n_elements) / N_ARRAYS;
      tsolid_status status = tsi_progress(w->out.context, stage, fraction);
      if (status != TSOLID_OK)
        return status;
    }
  }
  flush_base64(w);
  return TSOLID_OK;
}

/* ---- the document ------------------------------------------------------------------------------
 */

static uint64_t base64_length(uint64_t bytes) {
  return (bytes + 2) / 3 * 4;
}

/* Puts the element <DataArray> and moves *offset behind its data. */
static void declare(writer *w, array_id id, uint64_t n_points, uint64_t *offset) {
  const array_form *form = &arrays[id];
  char text[256];
  snprintf(text, sizeof text,
           "    <DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"appended\" "
           "offset=\"%llu\"/>\n",
           form->type, form->name, form->n_components, (unsigned long long)*offset);
  tsi_output_text(&w->out, text);
  uint64_t n_cells = (uint64_t)w->solid->space->n_elements;
  *offset += base64_length(8) + base64_length(array_bytes(form, n_points, n_cells));
}

static void put_head(writer *w, uint64_t n_points) {
  uint64_t offset = 0;
  tsi_output *out = &w->out;
  tsi_output_text(out, "<?xml version=\"1.0\"?>\n"
                       "<VTKFile type=\"UnstructuredGrid\" version=\"2.2\" "
                       "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
                       " <UnstructuredGrid>\n  <Piece NumberOfPoints=\"");
  tsi_output_integer(out, (long long)n_points);
  tsi_output_text(out, "\" NumberOfCells=\"");
  tsi_output_integer(out, w->solid->space->n_elements);
  tsi_output_text(out, "\">\n   <PointData RationalWeights=\"RationalWeights\">\n");
  declare(w, ARRAY_WEIGHTS, n_points, &offset);
  tsi_output_text(out, "   </PointData>\n   <CellData HigherOrderDegrees=\"HigherOrderDegrees\" "
                       "Scalars=\"ScaledJacobian\">\n");
  declare(w, ARRAY_DEGREES, n_points, &offset);
  declare(w, ARRAY_BLOCK, n_points, &offset);
  declare(w, ARRAY_JACOBIAN, n_points, &offset);
  tsi_output_text(out, "   </CellData>\n   <Points>\n");
  declare(w, ARRAY_POINTS, n_points, &offset);
  tsi_output_text(out, "   </Points>\n   <Cells>\n");
  declare(w, ARRAY_CONNECTIVITY, n_points, &offset);
  declare(w, ARRAY_OFFSETS, n_points, &offset);
  declare(w, ARRAY_TYPES, n_points, &offset);
  tsi_output_text(out, "   </Cells>\n  </Piece>\n </UnstructuredGrid>\n"
                       " <AppendedData encoding=\"base64\">\n_");
}

static tsolid_status put_document(writer *w) {
  const tsolid_space *space = w->solid->space;
  uint64_t n_points = 0;
  tsolid_status status = TSOLID_OK;
  for (int e = 0; e < space->n_elements; e++)
    n_points += count_points(space->element[e].degree);
  put_head(w, n_points);
  for (int id = 0; id < N_ARRAYS && status == TSOLID_OK; id++)
    status = put_array(w, (array_id)id, n_points);
  tsi_output_text(&w->out, "\n </AppendedData>\n</VTKFile>\n");
  return status;
}

tsolid_status tsolid_write_vtu(tsolid_context *context, const tsolid_solid *solid,
                               const char *path) {
  writer w = {.solid = solid};
  size_t n_max = 1;
  tsolid_status status = TSOLID_OK;
  if (!context || !solid || !path)
    return TSOLID_ERROR_ARGUMENT;
  tsi_arena arena = tsi_arena_create(context);
  for (int e = 0; e < solid->space->n_elements; e++) {
    size_t n = count_points(solid->space->element[e].degree);
    n_max = n > n_max ? n : n_max;
  }
  w.net = tsi_arena_new(&arena, n_max, 4 * sizeof *w.net);
  w.reordered = tsi_arena_new(&arena, n_max, 4 * sizeof *w.reordered);
  w.plane = tsi_arena_new(&arena, n_max, 4 * sizeof *w.plane); /* twice a net without one degree */
  if (!w.net || !w.reordered || !w.plane) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  if (tsi_output_open(&w.out, context, stage, path) == TSOLID_OK)
    status = put_document(&w);
  status = tsi_output_close(&w.out, status);
done:
  tsi_arena_free(&arena);
  return status;
}
