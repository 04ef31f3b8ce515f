/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Writes a solid as rational Bezier hexahedra for VTK and ParaView.
 *
 * What readers insist on: cell type 79 with the points in VTK's order; a file version of at least
 * 2.1, below which VTK swaps edges; weights and degrees not only named but declared as the active
 * attributes RationalWeights and HigherOrderDegrees. Each cell has points of its own, Euclidean.
 *
 * A field f = sum of c_A R_A is on an element (sum of f_i w_i B_i) / (sum of w_i B_i) with the
 * weights w_i of the geometry: the Bezier coefficients f_i are those of sum of c_A w_A N_A, divided
 * by w_i. VTK's rational interpolation of f_i is then f itself, as for the points. */
#include "bernstein.h"
#include "vtu.h"

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

static const tsi_vtu_array arrays[N_ARRAYS] = {{"RationalWeights", "Float64", 8, 1},
                                               {"HigherOrderDegrees", "Int32", 4, 3},
                                               {"Block", "Int32", 4, 1},
                                               {"ScaledJacobian", "Float64", 8, 1},
                                               {"Points", "Float64", 8, 3},
                                               {"connectivity", "Int64", 8, 1},
                                               {"offsets", "Int64", 8, 1},
                                               {"types", "UInt8", 1, 1}};

typedef struct writer {
  tsi_vtu vtu;
  const tsolid_solid *solid;
  uint64_t n_points;
  int n_fields;
  const tsolid_field *field;
  double **weighted; /* coefficients times weights, of each field */
  double *net;       /* scratch: one element, and reordered */
  double *reordered;
  double *plane;
} writer;

/* One tuple per point (else per cell). */
static int of_points(array_id id) {
  return id == ARRAY_WEIGHTS || id == ARRAY_POINTS || id == ARRAY_CONNECTIVITY;
}

/* The rows of n numbers of a net in VTK's order. */
static void reorder(const int degree[3], const double *row, int n, double *to) {
  for (int k = 0; k <= degree[2]; k++)
    for (int j = 0; j <= degree[1]; j++)
      for (int i = 0; i <= degree[0]; i++, row += n)
        memcpy(to + (size_t)n * (size_t)vtk_index(degree, i, j, k), row, (size_t)n * sizeof *to);
}

/* The element's control points (x, y, z, w) in VTK's order. */
static const double *load_cell(writer *w, int element) {
  const int *degree = w->solid->space->element[element].degree;
  tsi_element_net(w->solid->space, w->solid->control, 4, element, w->net);
  reorder(degree, w->net, 4, w->reordered);
  for (size_t k = 0; k < count_points(degree); k++)
    for (size_t c = 0; c < 3; c++)
      w->reordered[4 * k + c] /= w->reordered[4 * k + 3];
  return w->reordered;
}

static void put_cell(writer *w, array_id id, int element, uint64_t first, uint64_t n) {
  const tsi_element *e = &w->solid->space->element[element];
  const double *points = id == ARRAY_WEIGHTS || id == ARRAY_POINTS ? load_cell(w, element) : NULL;
  switch (id) {
  case ARRAY_WEIGHTS:
    for (uint64_t k = 0; k < n; k++)
      tsi_vtu_double(&w->vtu, points[4 * k + 3]);
    break;
  case ARRAY_POINTS:
    for (uint64_t k = 0; k < 3 * n; k++)
      tsi_vtu_double(&w->vtu, points[4 * (k / 3) + k % 3]);
    break;
  case ARRAY_DEGREES:
    for (int a = 0; a < 3; a++)
      tsi_vtu_word(&w->vtu, (uint64_t)e->degree[a], 4);
    break;
  case ARRAY_BLOCK:
    tsi_vtu_word(&w->vtu, (uint64_t)e->block, 4);
    break;
  case ARRAY_JACOBIAN:
    tsi_element_net(w->solid->space, w->solid->control, 4, element, w->net);
    tsi_vtu_double(&w->vtu, worst_jacobian(e->degree, w->net, w->plane));
    break;
  case ARRAY_CONNECTIVITY:
    for (uint64_t k = 0; k < n; k++)
      tsi_vtu_word(&w->vtu, first + k, 8);
    break;
  case ARRAY_OFFSETS:
    tsi_vtu_word(&w->vtu, first + n, 8);
    break;
  default:
    tsi_vtu_word(&w->vtu, BEZIER_HEXAHEDRON, 1);
    break;
  }
}

static tsolid_status tell(writer *w, int done, int element) {
  if (element % 256 != 0)
    return TSOLID_OK;
  double fraction = done + element / (double)w->solid->space->n_elements;
  return tsi_progress(w->vtu.out.context, stage, fraction / (N_ARRAYS + w->n_fields));
}

static tsolid_status put_array(writer *w, array_id id) {
  const tsolid_space *space = w->solid->space;
  uint64_t first = 0;
  tsolid_status status = TSOLID_OK;
  tsi_vtu_begin(&w->vtu, &arrays[id], of_points(id) ? w->n_points : (uint64_t)space->n_elements);
  for (int e = 0; e < space->n_elements && !w->vtu.out.status && !status; e++) {
    uint64_t n = count_points(space->element[e].degree);
    put_cell(w, id, e, first, n);
    first += n;
    status = tell(w, (int)id + (id > ARRAY_WEIGHTS ? w->n_fields : 0), e);
  }
  tsi_vtu_flush(&w->vtu);
  return status;
}

/* ---- fields ------------------------------------------------------------------------------------
 */

static tsi_vtu_array field_form(const tsolid_field *field) {
  return (tsi_vtu_array){field->name, "Float64", 8, field->n_components};
}

static tsolid_status put_field(writer *w, int k) {
  const tsolid_space *space = w->solid->space;
  tsi_vtu_array form = field_form(&w->field[k]);
  size_t c = (size_t)form.n_components;
  tsolid_status status = TSOLID_OK;
  tsi_vtu_begin(&w->vtu, &form, w->n_points);
  for (int e = 0; e < space->n_elements && !w->vtu.out.status && !status; e++) {
    const int *degree = space->element[e].degree;
    const double *points = load_cell(w, e);
    double *values = w->net + 4 * count_points(degree),
           *ordered = values + c * count_points(degree);
    tsi_element_net(space, w->weighted[k], form.n_components, e, values);
    reorder(degree, values, form.n_components, ordered);
    for (size_t i = 0; i < c * count_points(degree); i++)
      tsi_vtu_double(&w->vtu, ordered[i] / points[4 * (i / c) + 3]);
    status = tell(w, 1 + k, e);
  }
  tsi_vtu_flush(&w->vtu);
  return status;
}

static int bad_name(const char *name) {
  if (!name || !*name)
    return 1;
  for (; *name; name++)
    if ((unsigned char)*name < ' ')
      return 1;
  return 0;
}

static tsolid_status check_fields(tsolid_context *context, const tsolid_solid *solid, int n_fields,
                                  const tsolid_field *field) {
  size_t n = (size_t)solid->space->n_inner + 2 * (size_t)solid->space->n_surface;
  for (int k = 0; k < n_fields; k++) {
    const tsolid_field *f = &field[k];
    int taken = bad_name(f->name) || strcmp(f->name, arrays[ARRAY_WEIGHTS].name) == 0;
    for (int m = 0; m < k && !taken; m++)
      taken = strcmp(f->name, field[m].name) == 0;
    if (taken)
      return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                      "Field %d needs a name of its own, without control characters", k);
    if ((f->n_components != 1 && f->n_components != 3) || !f->coefficient)
      return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                      "Field '%s' needs coefficients with 1 or 3 components", f->name);
    for (size_t i = 0; i < n * (size_t)f->n_components; i++)
      if (!isfinite(f->coefficient[i]))
        return tsi_fail(context, TSOLID_ERROR_INPUT, stage,
                        "Field '%s': a coefficient of function %zu is not finite", f->name,
                        i / (size_t)f->n_components);
  }
  return TSOLID_OK;
}

/* Coefficients times weights of all fields. */
static int weigh_fields(tsi_arena *arena, writer *w) {
  size_t n = (size_t)w->solid->space->n_inner + 2 * (size_t)w->solid->space->n_surface;
  w->weighted = tsi_arena_new(arena, (size_t)w->n_fields, sizeof *w->weighted);
  for (int k = 0; w->weighted && k < w->n_fields; k++) {
    size_t c = (size_t)w->field[k].n_components;
    w->weighted[k] = tsi_arena_new(arena, n, c * sizeof(double));
    if (!w->weighted[k])
      return 0;
    for (size_t i = 0; i < c * n; i++)
      w->weighted[k][i] = w->field[k].coefficient[i] * w->solid->control[4 * (i / c) + 3];
  }
  return w->weighted != NULL;
}

/* ---- the document ------------------------------------------------------------------------------
 */

static void put_head(writer *w) {
  tsi_output *out = &w->vtu.out;
  uint64_t n_cells = (uint64_t)w->solid->space->n_elements;
  tsi_vtu_head(&w->vtu);
  tsi_vtu_piece(&w->vtu, w->n_points, n_cells);
  tsi_output_text(out, "   <PointData RationalWeights=\"RationalWeights\">\n");
  tsi_vtu_declare(&w->vtu, &arrays[ARRAY_WEIGHTS], w->n_points);
  for (int k = 0; k < w->n_fields; k++) {
    tsi_vtu_array form = field_form(&w->field[k]);
    tsi_vtu_declare(&w->vtu, &form, w->n_points);
  }
  tsi_output_text(out, "   </PointData>\n   <CellData HigherOrderDegrees=\"HigherOrderDegrees\" "
                       "Scalars=\"ScaledJacobian\">\n");
  for (int id = ARRAY_DEGREES; id <= ARRAY_JACOBIAN; id++)
    tsi_vtu_declare(&w->vtu, &arrays[id], n_cells);
  tsi_output_text(out, "   </CellData>\n   <Points>\n");
  tsi_vtu_declare(&w->vtu, &arrays[ARRAY_POINTS], w->n_points);
  tsi_output_text(out, "   </Points>\n   <Cells>\n");
  tsi_vtu_declare(&w->vtu, &arrays[ARRAY_CONNECTIVITY], w->n_points);
  tsi_vtu_declare(&w->vtu, &arrays[ARRAY_OFFSETS], n_cells);
  tsi_vtu_declare(&w->vtu, &arrays[ARRAY_TYPES], n_cells);
  tsi_output_text(out, "   </Cells>\n");
  tsi_vtu_data(&w->vtu);
}

static tsolid_status put_document(writer *w) {
  const tsolid_space *space = w->solid->space;
  for (int e = 0; e < space->n_elements; e++)
    w->n_points += count_points(space->element[e].degree);
  put_head(w);
  tsolid_status status = put_array(w, ARRAY_WEIGHTS);
  for (int k = 0; k < w->n_fields && !status; k++)
    status = put_field(w, k);
  for (int id = ARRAY_DEGREES; id < N_ARRAYS && !status; id++)
    status = put_array(w, (array_id)id);
  tsi_vtu_end(&w->vtu);
  return status;
}

tsolid_status tsolid_write_vtu_fields(tsolid_context *context, const tsolid_solid *solid,
                                      int n_fields, const tsolid_field *field, const char *path) {
  size_t n_max = 1;
  if (!context || !solid || !path || n_fields < 0 || (n_fields > 0 && !field))
    return TSOLID_ERROR_ARGUMENT;
  writer w = {.solid = solid, .n_fields = n_fields, .field = field};
  tsi_arena arena = tsi_arena_create(context);
  tsolid_status status = check_fields(context, solid, n_fields, field);
  if (status)
    goto done;
  for (int e = 0; e < solid->space->n_elements; e++) {
    size_t n = count_points(solid->space->element[e].degree);
    n_max = n > n_max ? n : n_max;
  }
  w.net = tsi_arena_new(&arena, n_max, (4 + 2 * 3) * sizeof *w.net); /* and a field's, twice */
  w.reordered = tsi_arena_new(&arena, n_max, 4 * sizeof *w.reordered);
  w.plane = tsi_arena_new(&arena, n_max, 4 * sizeof *w.plane); /* twice a net without one degree */
  if (!w.net || !w.reordered || !w.plane || !weigh_fields(&arena, &w)) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  if (tsi_output_open(&w.vtu.out, context, stage, path) == TSOLID_OK)
    status = put_document(&w);
  status = tsi_output_close(&w.vtu.out, status);
done:
  tsi_arena_free(&arena);
  return status;
}

tsolid_status tsolid_write_vtu(tsolid_context *context, const tsolid_solid *solid,
                               const char *path) {
  return tsolid_write_vtu_fields(context, solid, 0, NULL, path);
}
