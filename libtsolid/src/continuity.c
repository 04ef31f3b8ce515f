/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Measured against expected smoothness of the homogeneous map on every interior element face.
 *
 * In the Bernstein form of degree p on an interval of width h the k-th derivative at an end needs
 * the k+1 layers of control points next to it, so a face's jets are three small nets; they are
 * compared at Gauss points, enough of them to tell any two polynomials of the degree apart. A jump
 * counts when it is larger than RELATIVE times the size of that derivative plus the round-off that
 * its difference formula makes of the control points. */
#include "bernstein.h"
#include "conform.h"
#include "evaluate.h"
#include "quadrature.h"

#include <stdlib.h>

#ifdef _OPENMP
#include <omp.h>
#endif

enum { N_JETS = 3, BAND_CELLS = 3, MAX_POINTS = TSI_MAX_ORDER * TSI_MAX_ORDER };

#define RELATIVE 1e-9
#define ROUNDOFF (64.0 * 0x1p-52)

static const char *const STAGE = "report";

/* ---- jets --------------------------------------------------------------------------------------
 */

/* One side of a face: jets[k] are homogeneous k-th normal derivatives at the points. */
typedef struct face_side {
  double jet[N_JETS][MAX_POINTS][4];
  double tangent[2][MAX_POINTS][4]; /* along p and q */
  double noise[N_JETS][2];          /* round-off of coordinates, of weights */
} face_side;

typedef struct workspace {
  face_side side[2];
  double layer[N_JETS][MAX_POINTS][4];
  double half[MAX_POINTS][4], half_slope[MAX_POINTS][4];
  double basis[2][2][MAX_POINTS]; /* direction, value and slope, [point][function] */
} workspace;

/* The grid of a face: Gauss points in p and q. */
typedef struct face_grid {
  int n[2];
  double node[2][TSI_MAX_ORDER], weight[2][TSI_MAX_ORDER];
} face_grid;

typedef struct measurement {
  const tsolid_solid *solid;
  const double *net; /* of all elements, relative to the centre */
  double coordinate_size, weight_size;
  int n_lines[6][2]; /* lines of the sides' Bezier elements, ascending */
  double *line[6][2];
  int widest[6][2]; /* core lines that the widest cell at a side spans, along s and t */
} measurement;

/* k-th normal derivative = factor[k] * k-th difference of the layers, counted inwards. */
static void derivative_factors(int degree, int end, double width, double factor[N_JETS]) {
  factor[0] = 1.0;
  factor[1] = (end ? 1.0 : -1.0) * degree / width;
  factor[2] = (double)degree * (degree - 1.0) / (width * width);
}

/* Nets of the jets on the face; n points along each of the two directions. */
static void take_layers(const measurement *m, const tsi_face *face, int k, int n[2],
                        double factor[N_JETS], workspace *w) {
  const tsi_element *e = &m->solid->space->element[face->element[k]];
  const double *net = m->net + 4 * m->solid->space->bezier_start[face->element[k]];
  int axis = face->axis[k], stride[3] = {1, e->degree[0] + 1, 0};
  stride[2] = stride[1] * (e->degree[1] + 1);
  n[0] = e->degree[face->along[k][0]] + 1;
  n[1] = e->degree[face->along[k][1]] + 1;
  derivative_factors(e->degree[axis], face->end[k], e->box[axis + 3] - e->box[axis], factor);
  int inwards = face->end[k] ? -stride[axis] : stride[axis];
  int first = face->end[k] ? e->degree[axis] * stride[axis] : 0;
  for (int j = 0; j < n[1]; j++)
    for (int i = 0; i < n[0]; i++) {
      int at = first + i * stride[face->along[k][0]] + j * stride[face->along[k][1]];
      for (int c = 0; c < 4; c++) {
        double a = net[4 * at + c], b = net[4 * (at + inwards) + c];
        double d = net[4 * (at + 2 * inwards) + c];
        w->layer[0][i + n[0] * j][c] = a;
        w->layer[1][i + n[0] * j][c] = factor[1] * (a - b);
        w->layer[2][i + n[0] * j][c] = factor[2] * ((a - b) - (b - d));
      }
    }
}

/* Bernstein values and slopes (by p, q) of element k's two face directions at the grid. */
static void tabulate(const measurement *m, const tsi_face *face, int k, const int n[2],
                     const face_grid *grid, workspace *w) {
  const tsi_element *e = &m->solid->space->element[face->element[k]];
  double x[3], value[2 * TSI_MAX_ORDER];
  for (int d = 0; d < 2; d++) {
    int axis = face->along[k][d];
    double slope = (d == 0 ? face->scale[k] : 1.0) / (e->box[axis + 3] - e->box[axis]);
    for (int i = 0; i < grid->n[d]; i++) {
      double p = d == 0 ? grid->node[0][i] : face->box[0],
             q = d == 0 ? face->box[2] : grid->node[1][i];
      tsi_face_local(m->solid->space, face, k, p, q, x);
      tsi_bernstein_derivatives(n[d] - 1, x[axis], 1, value);
      for (int f = 0; f < n[d]; f++) {
        w->basis[d][0][i * n[d] + f] = value[f];
        w->basis[d][1][i * n[d] + f] = slope * value[n[d] + f];
      }
    }
  }
}

/* out[i + rows*j] = sum_f basis[j][f] in[i + rows*f] for rows of 4. */
static void contract(int rows, int n, int points, const double *basis, double (*in)[4],
                     double (*out)[4]) {
  for (int j = 0; j < points; j++)
    for (int i = 0; i < rows; i++)
      for (int c = 0; c < 4; c++) {
        double sum = 0.0;
        for (int f = 0; f < n; f++)
          sum += basis[j * n + f] * in[i + rows * f][c];
        out[i + rows * j][c] = sum;
      }
}

/* The same along the first index: out[j + points*i] from in[f + n*i]. */
static void contract_first(int rows, int n, int points, const double *basis, double (*in)[4],
                           double (*out)[4]) {
  for (int i = 0; i < rows; i++)
    for (int j = 0; j < points; j++)
      for (int c = 0; c < 4; c++) {
        double sum = 0.0;
        for (int f = 0; f < n; f++)
          sum += basis[j * n + f] * in[f + n * i][c];
        out[j + points * i][c] = sum;
      }
}

static void fill_side(const measurement *m, const tsi_face *face, int k, const face_grid *grid,
                      workspace *w) {
  int n[2];
  double factor[N_JETS];
  face_side *side = &w->side[k];
  take_layers(m, face, k, n, factor, w);
  tabulate(m, face, k, n, grid, w);
  for (int jet = 0; jet < N_JETS; jet++) {
    contract_first(n[1], n[0], grid->n[0], w->basis[0][0], w->layer[jet], w->half);
    contract(grid->n[0], n[1], grid->n[1], w->basis[1][0], w->half, side->jet[jet]);
    double amplification = fabs(factor[jet]) * (double)(1 << jet);
    side->noise[jet][0] = ROUNDOFF * amplification * m->coordinate_size;
    side->noise[jet][1] = ROUNDOFF * amplification * m->weight_size;
  }
  contract_first(n[1], n[0], grid->n[0], w->basis[0][1], w->layer[0], w->half_slope);
  contract(grid->n[0], n[1], grid->n[1], w->basis[1][0], w->half_slope, side->tangent[0]);
  contract_first(n[1], n[0], grid->n[0], w->basis[0][0], w->layer[0], w->half);
  contract(grid->n[0], n[1], grid->n[1], w->basis[1][1], w->half, side->tangent[1]);
}

static void choose_grid(const tsolid_space *space, const tsi_face *face, face_grid *grid) {
  for (int d = 0; d < 2; d++) {
    int a = space->element[face->element[0]].degree[face->along[0][d]];
    int b = space->element[face->element[1]].degree[face->along[1][d]];
    double lo = face->box[2 * d], width = face->box[2 * d + 1] - lo;
    grid->n[d] = (a > b ? a : b) + 1;
    tsi_gauss(grid->n[d], grid->node[d], grid->weight[d]);
    for (int i = 0; i < grid->n[d]; i++) {
      grid->node[d][i] = lo + width * grid->node[d][i];
      grid->weight[d][i] *= width;
    }
  }
}

/* ---- measured order and area -------------------------------------------------------------------
 */

/* Largest jump of a derivative relative to its allowance, coordinates and weight apart. */
static double relative_jump(const workspace *w, int jet, int n_points) {
  double jump[2] = {0.0, 0.0}, size[2] = {0.0, 0.0}, worst = 0.0;
  for (int i = 0; i < n_points; i++)
    for (int c = 0; c < 4; c++) {
      double a = w->side[0].jet[jet][i][c], b = w->side[1].jet[jet][i][c];
      int group = c == 3;
      jump[group] = fmax(jump[group], fabs(a - b));
      size[group] = fmax(size[group], fmax(fabs(a), fabs(b)));
    }
  for (int group = 0; group < 2; group++) {
    double allowed =
        RELATIVE * size[group] + w->side[0].noise[jet][group] + w->side[1].noise[jet][group];
    worst = fmax(worst, jump[group] / allowed);
  }
  return worst;
}

static double face_area(const workspace *w, const face_grid *grid) {
  double area = 0.0;
  for (int i = 0; i < grid->n[0] * grid->n[1]; i++) {
    const double *x = w->side[0].jet[0][i];
    double t[2][3];
    for (int d = 0; d < 2; d++)
      for (int c = 0; c < 3; c++)
        t[d][c] = (w->side[0].tangent[d][i][c] - w->side[0].tangent[d][i][3] * x[c] / x[3]) / x[3];
    double normal[3] = {t[0][1] * t[1][2] - t[0][2] * t[1][1],
                        t[0][2] * t[1][0] - t[0][0] * t[1][2],
                        t[0][0] * t[1][1] - t[0][1] * t[1][0]};
    area += grid->weight[0][i % grid->n[0]] * grid->weight[1][i / grid->n[0]] *
            sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  }
  return area;
}

/* ---- expected order ----------------------------------------------------------------------------
 */

static int is_line(const measurement *m, int side, int d, double value) {
  int lo = 0, hi = m->n_lines[side][d] - 1;
  const double *line = m->line[side][d];
  while (lo <= hi) {
    int middle = lo + (hi - lo) / 2;
    if (line[middle] == value)
      return 1;
    if (line[middle] < value)
      lo = middle + 1;
    else
      hi = middle - 1;
  }
  return 0;
}

/* Normal derivatives of one surface function at a point of an edge of its lateral cell (direction d
 * is normal to the edge; the point has Bernstein values `along` in the other one). */
static void edge_jets(const tsi_lateral *lateral, const double *coefficient, int d, int end,
                      const double *along, double jet[N_JETS]) {
  int p = lateral->degree[d], other = lateral->degree[1 - d];
  int stride[2] = {1, lateral->degree[0] + 1};
  double factor[N_JETS], layer[N_JETS] = {0.0, 0.0, 0.0};
  derivative_factors(p, end, lateral->box[2 * d + 1] - lateral->box[2 * d], factor);
  for (int k = 0; k < N_JETS; k++) {
    int row = end ? p - k : k;
    for (int i = 0; i <= other; i++)
      layer[k] += along[i] * coefficient[row * stride[d] + i * stride[1 - d]];
  }
  jet[0] = layer[0];
  jet[1] = factor[1] * (layer[0] - layer[1]);
  jet[2] = factor[2] * ((layer[0] - layer[1]) - (layer[1] - layer[2]));
}

static const double *lateral_coefficients(const tsolid_space *space, const tsi_lateral *l, int f) {
  size_t size = (size_t)(l->degree[0] + 1) * (size_t)(l->degree[1] + 1);
  return space->lateral_coefficient + l->coefficient_first + size * (size_t)(f - l->function_first);
}

/* Adds the jets of one function, absent on a side = zero there, to the running jumps and sizes. */
static void compare_function(const tsolid_space *space, const tsi_lateral *const l[2],
                             const int f[2], int d, double along[2][TSI_MAX_ORDER],
                             double jump[N_JETS], double size[N_JETS]) {
  double jet[2][N_JETS] = {{0.0}};
  for (int k = 0; k < 2; k++)
    if (f[k] >= 0)
      edge_jets(l[k], lateral_coefficients(space, l[k], f[k]), d, k == 0, along[k], jet[k]);
  for (int k = 0; k < N_JETS; k++) {
    jump[k] = fmax(jump[k], fabs(jet[0][k] - jet[1][k]));
    size[k] = fmax(size[k], fmax(fabs(jet[0][k]), fabs(jet[1][k])));
  }
}

/* Both cells' functions ascend: a merge. */
static void compare_functions(const tsolid_space *space, const tsi_lateral *const l[2], int d,
                              double along[2][TSI_MAX_ORDER], double jump[N_JETS],
                              double size[N_JETS]) {
  int i = l[0]->function_first, j = l[1]->function_first;
  while (i < l[0]->function_end || j < l[1]->function_end) {
    int a = i < l[0]->function_end ? space->lateral_function[i] : INT32_MAX;
    int b = j < l[1]->function_end ? space->lateral_function[j] : INT32_MAX;
    int f[2] = {a <= b ? i++ : -1, b <= a ? j++ : -1};
    compare_function(space, l, f, d, along, jump, size);
  }
}

/* Continuity of the input's functions across a line, at most 2; direction d is normal to it. */
static int input_order(const tsolid_space *space, const tsi_face *face, int d) {
  const tsi_lateral *l[2];
  double jump[N_JETS] = {0.0, 0.0, 0.0}, size[N_JETS] = {0.0, 0.0, 0.0};
  double along[2][TSI_MAX_ORDER], lo = -1.0, hi = 2.0;
  for (int k = 0; k < 2; k++) {
    l[k] = &space->lateral[space->element[face->element[k]].lateral];
    lo = fmax(lo, l[k]->box[2 * (1 - d)]);
    hi = fmin(hi, l[k]->box[2 * (1 - d) + 1]);
  }
  int n = l[0]->degree[1 - d] + 1;
  for (int i = 0; i < n; i++) {
    double value = lo + (hi - lo) * (i + 0.5) / n;
    for (int k = 0; k < 2; k++) {
      const double *box = l[k]->box + 2 * (1 - d);
      tsi_bernstein(l[k]->degree[1 - d], (value - box[0]) / (box[1] - box[0]), along[k]);
    }
    compare_functions(space, l, d, along, jump, size);
  }
  int order = -1;
  for (int k = 0; k < N_JETS && order == k - 1; k++) {
    double allowed = RELATIVE * size[k];
    for (int e = 0; e < 2; e++) {
      double factor[N_JETS];
      derivative_factors(l[e]->degree[d], 0, l[e]->box[2 * d + 1] - l[e]->box[2 * d], factor);
      allowed += ROUNDOFF * fabs(factor[k]) * (double)(1 << k);
    }
    order = jump[k] <= allowed ? k : order;
  }
  return order;
}

/* Is the face farther than BAND_CELLS cells from the edges of the core, in both directions? */
static int beyond_bands(const measurement *m, const tsi_face *face, int side) {
  const tsolid_tmesh *tmesh = m->solid->space->tmesh;
  for (int d = 0; d < 2; d++) {
    int axis = d == 0 ? tsi_side_s(side) : tsi_side_t(side), band = BAND_CELLS * m->widest[side][d];
    int last = tmesh->n_lines[axis] - 1;
    if (band > last || face->box[2 * d] < tmesh->line[axis][band] ||
        face->box[2 * d + 1] > tmesh->line[axis][last - band])
      return 0;
  }
  return 1;
}

static int expected_order(const measurement *m, const tsi_face *face) {
  const tsi_element *low = &m->solid->space->element[face->element[0]];
  const tsi_element *high = &m->solid->space->element[face->element[1]];
  if (face->kind == TSI_FACE_DIAGONAL)
    return 0;
  if (face->kind == TSI_FACE_CORE && m->solid->space->tmesh->flags & TSI_TMESH_SHARP_CORE)
    return 0;
  if (face->kind == TSI_FACE_CORE)
    return beyond_bands(m, face, (low->block > 0 ? low->block : high->block) - 1) ? 2 : 0;
  int side = low->block - 1, axis = face->axis[0];
  if (low->block == 0 || axis == tsi_side_axis(side))
    return 2;
  int d = axis == tsi_side_s(side) ? 0 : 1;
  return is_line(m, side, d, low->box[axis + 3]) ? input_order(m->solid->space, face, d) : 2;
}

/* ---- preparation -------------------------------------------------------------------------------
 */

static int compare_double(const void *a, const void *b) {
  double p = *(const double *)a, q = *(const double *)b;
  return (p > q) - (p < q);
}

static int find_lines(const tsolid_boundary *boundary, tsi_arena *arena, measurement *m) {
  for (int k = 0; k < 12; k++) {
    const tsi_side *side = &boundary->side[k / 2];
    int d = k % 2, n = 2 * side->n_elements, unique = 0;
    double *line = tsi_arena_new(arena, (size_t)n, sizeof *line);
    if (!line)
      return 0;
    for (int i = 0; i < n; i++)
      line[i] = side->box[4 * (i / 2) + 2 * d + i % 2];
    qsort(line, (size_t)n, sizeof *line, compare_double);
    for (int i = 0; i < n; i++)
      if (i == 0 || line[i] != line[unique - 1])
        line[unique++] = line[i];
    m->line[k / 2][d] = line;
    m->n_lines[k / 2][d] = unique;
  }
  return 1;
}

/* Where cells differ in size, bands are counted in the widest that lie at the side: on the safe
 * side, less is promised. */
static void find_widest_cells(const tsolid_tmesh *tmesh, measurement *m) {
  for (int side = 0; side < 6; side++) {
    int axis = tsi_side_axis(side), along[2] = {tsi_side_s(side), tsi_side_t(side)};
    int surface = side & 1 ? tmesh->n_lines[axis] - 1 : 0;
    m->widest[side][0] = m->widest[side][1] = 1;
    for (int b = 0; b < tmesh->n_boxes; b++) {
      const int *box = tmesh->box + 6 * (size_t)b;
      if (box[axis + 3 * (side & 1)] != surface)
        continue;
      for (int d = 0; d < 2; d++) {
        int width = box[along[d] + 3] - box[along[d]];
        m->widest[side][d] = width > m->widest[side][d] ? width : m->widest[side][d];
      }
    }
  }
}

/* Nets relative to the centre of the boundary's control points, so that a part far from the origin
 * has the derivatives that it would have at home. */
static int make_nets(const tsolid_solid *solid, tsi_arena *arena, measurement *m) {
  const tsolid_space *space = solid->space;
  size_t n = (size_t)space->n_inner + 2 * (size_t)space->n_surface;
  double *control = tsi_arena_new(arena, n, 4 * sizeof *control);
  double *net = tsi_arena_new(arena, space->bezier_start[space->n_elements], 4 * sizeof *net);
  double low[3], high[3];
  if (!control || !net)
    return 0;
  for (int c = 0; c < 3; c++) {
    low[c] = (double)INFINITY;
    high[c] = -(double)INFINITY;
    for (size_t i = n - (size_t)space->n_surface; i < n; i++) {
      double x = solid->control[4 * i + (size_t)c] / solid->control[4 * i + 3];
      low[c] = fmin(low[c], x);
      high[c] = fmax(high[c], x);
    }
  }
  for (size_t i = 0; i < n; i++) {
    const double *from = solid->control + 4 * i;
    control[4 * i + 3] = from[3];
    m->weight_size = fmax(m->weight_size, from[3]);
    for (size_t c = 0; c < 3; c++) {
      control[4 * i + c] = from[c] - from[3] * (0.5 * (low[c] + high[c]));
      m->coordinate_size = fmax(m->coordinate_size, fabs(from[c]));
    }
  }
  for (int e = 0; e < space->n_elements; e++)
    tsi_element_net(space, control, 4, e, net + 4 * space->bezier_start[e]);
  m->net = net;
  return 1;
}

/* ---- driver ------------------------------------------------------------------------------------
 */

typedef struct face_result {
  int order, expected;
  double area, excess;
} face_result;

static face_result measure_face(const measurement *m, const tsi_face *face, workspace *w) {
  face_result result = {.order = -1, .expected = expected_order(m, face)};
  face_grid grid;
  choose_grid(m->solid->space, face, &grid);
  for (int k = 0; k < 2; k++)
    fill_side(m, face, k, &grid, w);
  int last =
      face->kind == TSI_FACE_DIAGONAL ? 0 : N_JETS - 1; /* normals differ across a diagonal */
  for (int jet = 0; jet <= last; jet++) {
    double excess = relative_jump(w, jet, grid.n[0] * grid.n[1]);
    if (excess <= 1.0 && result.order == jet - 1)
      result.order = jet;
    if (jet <= result.expected)
      result.excess = fmax(result.excess, excess);
  }
  result.area = face_area(w, &grid);
  return result;
}

static void measure_faces(const measurement *m, int n_threads, int n_faces, const tsi_face *face,
                          workspace *w, face_result *result) {
#ifdef _OPENMP
#pragma omp parallel for num_threads(n_threads) schedule(dynamic, 16)
#endif
  for (int i = 0; i < n_faces; i++) {
#ifdef _OPENMP
    workspace *own = w + omp_get_thread_num();
#else
    workspace *own = w;
#endif
    result[i] = measure_face(m, &face[i], own);
  }
  (void)n_threads;
}

static void summarise(int n_faces, const face_result *result, int *order, int *expected,
                      tsolid_continuity_report *report) {
  tsi_sum area[4] = {{0.0, 0.0}};
  *report = (tsolid_continuity_report){.n_faces = n_faces};
  for (int i = 0; i < n_faces; i++) {
    tsi_sum_add(&area[result[i].order + 1], result[i].area);
    report->n_below_expected += result[i].order < result[i].expected;
    report->largest_excess = fmax(report->largest_excess, result[i].excess);
    if (order)
      order[i] = result[i].order;
    if (expected)
      expected[i] = result[i].expected;
  }
  for (int k = 0; k < 4; k++)
    report->area[k] = tsi_sum_get(&area[k]);
}

tsolid_status tsi_continuity_measure(tsolid_context *context, const tsolid_solid *solid,
                                     int n_faces, const tsi_face *face, int *order, int *expected,
                                     tsolid_continuity_report *report) {
  tsi_arena arena = tsi_arena_create(context);
  tsolid_status status = TSOLID_ERROR_MEMORY;
  measurement m = {.solid = solid};
  workspace *w = tsi_arena_new(&arena, (size_t)context->n_threads, sizeof *w);
  face_result *result = tsi_arena_new(&arena, (size_t)n_faces, sizeof *result);
  if (!w || !result || !find_lines(solid->space->boundary, &arena, &m) ||
      !make_nets(solid, &arena, &m))
    goto done;
  find_widest_cells(solid->space->tmesh, &m);
  measure_faces(&m, context->n_threads, n_faces, face, w, result);
  summarise(n_faces, result, order, expected, report);
  status = TSOLID_OK;
done:
  tsi_arena_free(&arena);
  return status == TSOLID_OK ? status : tsi_no_memory(context, STAGE);
}
