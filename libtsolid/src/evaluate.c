/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Points, derivatives and extraction rows of the rational T-spline solid. */
#include "evaluate.h"

#include "bernstein.h"
#include "bvh.h"

/* u may leave its block by round-off of the caller's arithmetic. */
#define OUTSIDE_TOLERANCE 1e-12

/* The multi-index of each derivative row. */
static const int derivative_order[TSI_N_DERIVATIVES][3] = {
    {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0},
    {0, 2, 0}, {0, 0, 2}, {0, 1, 1}, {1, 0, 1}, {1, 1, 0}};

void tsi_block_range(const tsolid_tmesh *tmesh, int block, double range[6]) {
  for (int d = 0; d < 3; d++) {
    range[d] = 0.0;
    range[d + 3] = 1.0;
  }
  if (block == 0)
    return;
  int side = block - 1, axis = tsi_side_axis(side), last = tmesh->n_planes[axis] - 1;
  range[axis] = side & 1 ? 1.0 : tmesh->plane_value[axis][0];
  range[axis + 3] = side & 1 ? tmesh->plane_value[axis][last] : 0.0;
}

/* ---- location ----------------------------------------------------------------------------------
 */

typedef struct location {
  const tsolid_space *space;
  int block, element;
  double u[3], range[6];
} location;

static int visit_element(void *data, int item) {
  location *found = data;
  const tsi_element *element = &found->space->element[item];
  if (element->block != found->block)
    return 0;
  for (int d = 0; d < 3; d++) {
    double lo = element->box[d], hi = element->box[d + 3], u = found->u[d];
    if (!(lo <= u && (u < hi || (u == hi && hi == found->range[d + 3]))))
      return 0;
  }
  found->element = item;
  return 1;
}

int tsi_space_locate(const tsolid_space *space, int block, const double u[3]) {
  location found = {.space = space, .block = block, .element = -1};
  memcpy(found.u, u, sizeof found.u);
  tsi_block_range(space->tmesh, block, found.range);
  tsi_bvh_containing(space->locate, u, 0.0, visit_element, &found);
  return found.element;
}

void tsi_element_local(const tsi_element *element, const double u[3], double x[3]) {
  for (int d = 0; d < 3; d++) {
    double lo = element->box[d], hi = element->box[d + 3];
    double local = (u[d] - lo) / (hi - lo);
    x[d] = u[d] == hi ? 1.0 : fmin(fmax(local, 0.0), 1.0);
  }
}

/* ---- functions ---------------------------------------------------------------------------------
 */

/* Cubic Bernstein values and derivatives of one direction, by cross coordinates. */
typedef double cubic_basis[3][4];

static void fill_basis(int degree, double x, int order, double width, double *value) {
  tsi_bernstein_derivatives(degree, x, order, value);
  double factor = 1.0;
  for (int d = 1; d <= order; d++) {
    factor /= width;
    for (int k = 0; k <= degree; k++)
      value[d * (degree + 1) + k] *= factor;
  }
}

static double dot4(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

static void multiply_out(double line[3][3], int order, double *value) {
  for (int k = 0; k < tsi_n_derivatives(order); k++) {
    const int *o = derivative_order[k];
    value[k] = line[0][o[0]] * line[1][o[1]] * line[2][o[2]];
  }
}

static void visit_inner(const tsolid_space *space, int element, double basis[3][3][4], int order,
                        tsi_function_visit visit, void *data) {
  double line[3][3], value[TSI_N_DERIVATIVES];
  for (size_t i = space->inner_start[element]; i < space->inner_start[element + 1]; i++) {
    for (int d = 0; d < 3; d++)
      for (int o = 0; o <= order; o++)
        line[d][o] = dot4(space->row + 4 * (size_t)space->inner_row[i][d], basis[d][o]);
    multiply_out(line, order, value);
    visit(data, space->inner_function[i], value);
  }
}

/* Lateral derivatives f[i][j] = d^(i+j) / ds^i dt^j of one surface function, i + j <= order. */
static void lateral_derivatives(const int degree[2], const double *coefficient, const double *s,
                                const double *t, int order, double f[3][3]) {
  for (int i = 0; i <= order; i++)
    for (int j = 0; i + j <= order; j++) {
      double sum = 0.0;
      for (int b = 0; b <= degree[1]; b++) {
        double along = 0.0;
        for (int a = 0; a <= degree[0]; a++)
          along += coefficient[a + (degree[0] + 1) * b] * s[i * (degree[0] + 1) + a];
        sum += along * t[j * (degree[1] + 1) + b];
      }
      f[i][j] = sum;
    }
}

static void visit_surface(const tsolid_space *space, const tsi_element *element, const double x[3],
                          double basis[3][3][4], int order, tsi_function_visit visit, void *data) {
  const tsi_lateral *lateral = &space->lateral[element->lateral];
  int axis = tsi_side_axis(lateral->side),
      along[2] = {tsi_side_s(lateral->side), tsi_side_t(lateral->side)};
  double line[2][3 * TSI_MAX_ORDER], radial[2][3] = {{0}}, f[3][3], value[TSI_N_DERIVATIVES];
  for (int k = 0; k < 2; k++)
    fill_basis(lateral->degree[k], x[along[k]], order,
               element->box[along[k] + 3] - element->box[along[k]], line[k]);
  for (int layer = 0; layer < 2; layer++)
    for (int o = 0; o <= order && element->radial[layer] >= 0; o++)
      radial[layer][o] = dot4(space->row + 4 * (size_t)element->radial[layer], basis[axis][o]);
  size_t stride = (size_t)(lateral->degree[0] + 1) * (size_t)(lateral->degree[1] + 1);
  const double *coefficient = space->lateral_coefficient + lateral->coefficient_first;
  for (int i = lateral->function_first; i < lateral->function_end; i++, coefficient += stride) {
    lateral_derivatives(lateral->degree, coefficient, line[0], line[1], order, f);
    for (int layer = 0; layer < 2; layer++) {
      if (element->radial[layer] < 0)
        continue;
      for (int k = 0; k < tsi_n_derivatives(order); k++) {
        const int *o = derivative_order[k];
        value[k] = f[o[along[0]]][o[along[1]]] * radial[layer][o[axis]];
      }
      visit(data, space->n_inner + layer * space->n_surface + space->lateral_function[i], value);
    }
  }
}

void tsi_element_functions(const tsolid_space *space, int element, const double x[3], int order,
                           tsi_function_visit visit, void *data) {
  const tsi_element *e = &space->element[element];
  cubic_basis basis[3];
  for (int d = 0; d < 3; d++)
    fill_basis(TSI_INNER_DEGREE, x[d], order, e->box[d + 3] - e->box[d], basis[d][0]);
  visit_inner(space, element, basis, order, visit, data);
  if (e->lateral >= 0)
    visit_surface(space, e, x, basis, order, visit, data);
}

/* ---- Bezier nets -------------------------------------------------------------------------------
 */

/* Contracts the net along u[0] for each needed derivative of it, then u[1], then u[2]. */
void tsi_bezier_evaluate(const int degree[3], const double *net, int n_components,
                         const double x[3], int order, double *out) {
  double basis[3][3 * TSI_MAX_ORDER];
  int n[3], n_rows = tsi_n_derivatives(order);
  for (int d = 0; d < 3; d++) {
    n[d] = degree[d] + 1;
    tsi_bernstein_derivatives(degree[d], x[d], order, basis[d]);
  }
  memset(out, 0, (size_t)(n_rows * n_components) * sizeof *out);
  for (int k = 0; k < n[2]; k++) {
    double plane[3][3][4] = {{{0.0}}}; /* by derivative along u[0] and u[1] */
    for (int j = 0; j < n[1]; j++) {
      double line[3][4] = {{0.0}};
      const double *row = net + (size_t)n_components * (size_t)n[0] * (size_t)(j + n[1] * k);
      for (int i = 0; i < n[0]; i++)
        for (int a = 0; a <= order; a++)
          for (int c = 0; c < n_components; c++)
            line[a][c] += basis[0][a * n[0] + i] * row[i * n_components + c];
      for (int a = 0; a <= order; a++)
        for (int b = 0; a + b <= order; b++)
          for (int c = 0; c < n_components; c++)
            plane[a][b][c] += basis[1][b * n[1] + j] * line[a][c];
    }
    for (int row = 0; row < n_rows; row++) {
      const int *o = derivative_order[row];
      for (int c = 0; c < n_components; c++)
        out[row * n_components + c] += basis[2][o[2] * n[2] + k] * plane[o[0]][o[1]][c];
    }
  }
}

/* (X / w)_ij = (X_ij - w_i x_j - w_j x_i - w_ij x) / w */
void tsi_project(int order, const double *homogeneous, double *euclidean) {
  static const int pair[6][2] = {{1, 1}, {2, 2}, {3, 3}, {2, 3}, {1, 3}, {1, 2}};
  const double(*h)[4] = (const double(*)[4])homogeneous;
  double(*x)[3] = (double(*)[3])euclidean;
  for (int row = 0; row < tsi_n_derivatives(order); row++)
    for (int c = 0; c < 3; c++) {
      double value = h[row][c];
      if (row > 0)
        value -= h[row][3] * x[0][c];
      if (row > 3) {
        const int *p = pair[row - 4];
        value -= h[p[0]][3] * x[p[1]][c] + h[p[1]][3] * x[p[0]][c];
      }
      x[row][c] = value / h[0][3];
    }
}

/* ---- public ------------------------------------------------------------------------------------
 */

tsolid_status tsolid_solid_bezier(tsolid_context *context, const tsolid_solid *solid, int element,
                                  double *points) {
  if (!context)
    return TSOLID_ERROR_ARGUMENT;
  if (!solid || !points || element < 0 || element >= solid->space->n_elements)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, "solid", "No element %d", element);
  tsi_element_net(solid->space, solid->control, 4, element, points);
  return TSOLID_OK;
}

typedef struct combination {
  const double *control;
  int n_rows;
  double sum[TSI_N_DERIVATIVES][4];
} combination;

static void add_function(void *data, int function, const double *value) {
  combination *point = data;
  const double *control = point->control + 4 * (size_t)function;
  for (int row = 0; row < point->n_rows; row++)
    for (int c = 0; c < 4; c++)
      point->sum[row][c] += value[row] * control[c];
}

/* Moves u into the block when it is outside by round-off only; 0: it is not. */
static int clamp_to_block(const tsolid_space *space, int block, const double u[3],
                          double inside[3]) {
  double range[6];
  tsi_block_range(space->tmesh, block, range);
  for (int d = 0; d < 3; d++) {
    if (!(u[d] >= range[d] - OUTSIDE_TOLERANCE && u[d] <= range[d + 3] + OUTSIDE_TOLERANCE))
      return 0;
    inside[d] = fmin(fmax(u[d], range[d]), range[d + 3]);
  }
  return 1;
}

int tsi_solid_point(const tsolid_solid *solid, int block, const double u[3], int order,
                    double *out) {
  double inside[3], x[3];
  if (!clamp_to_block(solid->space, block, u, inside))
    return 0;
  int element = tsi_space_locate(solid->space, block, inside);
  if (element < 0)
    return 0;
  tsi_element_local(&solid->space->element[element], inside, x);
  combination point = {.control = solid->control, .n_rows = tsi_n_derivatives(order)};
  memset(point.sum, 0, sizeof point.sum);
  tsi_element_functions(solid->space, element, x, order, add_function, &point);
  tsi_project(order, point.sum[0], out);
  return 1;
}

tsolid_status tsolid_solid_evaluate(tsolid_context *context, const tsolid_solid *solid, int block,
                                    const double u[3], int order, double *out) {
  if (!context)
    return TSOLID_ERROR_ARGUMENT;
  if (!solid || !u || !out || block < 0 || block > 6 || order < 0 || order > 2)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, "solid", "No block %d or no order %d", block,
                    order);
  if (!tsi_solid_point(solid, block, u, order, out))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, "solid",
                    "The coordinates (%g, %g, %g) are not in block %d", u[0], u[1], u[2], block);
  return TSOLID_OK;
}

int tsolid_solid_boundary_point(const tsolid_solid *solid, int side, double s, double t,
                                double u[3]) {
  double range[6];
  int axis = tsi_side_axis(side);
  tsi_block_range(solid->space->tmesh, 1 + side, range);
  u[axis] = side & 1 ? range[axis + 3] : range[axis];
  u[tsi_side_s(side)] = s;
  u[tsi_side_t(side)] = t;
  return 1 + side;
}

/* ---- extraction --------------------------------------------------------------------------------
 */

/* The product of three rows, each raised from cubic to the element's degree. */
static void add_inner_coefficients(const tsolid_space *space, const tsi_element *element,
                                   size_t entry, double *coefficient) {
  double line[3][TSI_MAX_ORDER];
  const int *degree = element->degree;
  for (int d = 0; d < 3; d++)
    tsi_bernstein_raise(TSI_INNER_DEGREE, degree[d], 1,
                        space->row + 4 * (size_t)space->inner_row[entry][d], line[d]);
  for (int k = 0; k <= degree[2]; k++)
    for (int j = 0; j <= degree[1]; j++)
      for (int i = 0; i <= degree[0]; i++)
        *coefficient++ += line[0][i] * line[1][j] * line[2][k];
}

static void add_surface_coefficients(const tsolid_space *space, const tsi_element *element,
                                     int index, int layer, double *coefficient) {
  const tsi_lateral *lateral = &space->lateral[element->lateral];
  int axis = tsi_side_axis(lateral->side), s = tsi_side_s(lateral->side),
      t = tsi_side_t(lateral->side);
  size_t stride = (size_t)(lateral->degree[0] + 1) * (size_t)(lateral->degree[1] + 1);
  const double *side_coefficient = space->lateral_coefficient + lateral->coefficient_first +
                                   stride * (size_t)(index - lateral->function_first);
  const double *radial = space->row + 4 * (size_t)element->radial[layer];
  int i[3];
  for (i[2] = 0; i[2] <= element->degree[2]; i[2]++)
    for (i[1] = 0; i[1] <= element->degree[1]; i[1]++)
      for (i[0] = 0; i[0] <= element->degree[0]; i[0]++)
        *coefficient++ +=
            side_coefficient[i[s] + (lateral->degree[0] + 1) * i[t]] * radial[i[axis]];
}

static int count_functions(const tsolid_space *space, int element) {
  const tsi_element *e = &space->element[element];
  size_t n = space->inner_start[element + 1] - space->inner_start[element];
  if (e->lateral >= 0) {
    const tsi_lateral *lateral = &space->lateral[e->lateral];
    int layers = (e->radial[0] >= 0) + (e->radial[1] >= 0);
    n += (size_t)layers * (size_t)(lateral->function_end - lateral->function_first);
  }
  return (int)n;
}

/* One step of the output: function numbers and, where wanted, zeroed coefficients. */
static double *begin_function(int id, int *n, size_t stride, int *function, double *coefficient) {
  double *out = coefficient ? coefficient + (size_t)*n * stride : NULL;
  if (out)
    memset(out, 0, stride * sizeof *out);
  if (function)
    function[*n] = id;
  (*n)++;
  return out;
}

static void write_extraction(const tsolid_space *space, int element, int *function,
                             double *coefficient) {
  const tsi_element *e = &space->element[element];
  size_t stride =
      (size_t)(e->degree[0] + 1) * (size_t)(e->degree[1] + 1) * (size_t)(e->degree[2] + 1);
  int n = 0;
  double *out = NULL;
  for (size_t i = space->inner_start[element]; i < space->inner_start[element + 1]; i++) {
    out = begin_function(space->inner_function[i], &n, stride, function, coefficient);
    if (out)
      add_inner_coefficients(space, e, i, out);
  }
  for (int layer = 0; layer < 2 && e->lateral >= 0; layer++) {
    const tsi_lateral *lateral = &space->lateral[e->lateral];
    for (int i = lateral->function_first; i < lateral->function_end && e->radial[layer] >= 0; i++) {
      int id = space->n_inner + layer * space->n_surface + space->lateral_function[i];
      out = begin_function(id, &n, stride, function, coefficient);
      if (out)
        add_surface_coefficients(space, e, i, layer, out);
    }
  }
}

tsolid_status tsolid_space_extraction(tsolid_context *context, const tsolid_space *space,
                                      int element, int capacity, int *n, int *function,
                                      double *coefficient) {
  if (!context)
    return TSOLID_ERROR_ARGUMENT;
  if (!space || !n || element < 0 || element >= space->n_elements)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, "space", "No element %d", element);
  *n = count_functions(space, element);
  if (!function && !coefficient)
    return TSOLID_OK;
  if (capacity < *n)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, "space",
                    "Room for %d functions where element %d has %d", capacity, element, *n);
  write_extraction(space, element, function, coefficient);
  return TSOLID_OK;
}
