/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Mass, Laplace and elasticity matrices of a solid's rational functions, and loads on its faces.
 *
 *     mass        M_AB = integral of R_A R_B
 *     Laplace     K_AB = integral of grad R_A . grad R_B
 *     elasticity  K_AiBj = integral of lambda d_i R_A d_j R_B + mu (d_j R_A d_i R_B
 *                          + delta_ij grad R_A . grad R_B)
 *     load        b_A  = integral over a region of the boundary of R_A
 *
 * by Gauss points. With constant weights the cofactors of a Jacobian of degree q times the gradient
 * of a function have degree 3 q - 1 per direction, and (3 q + 1) / 2 points integrate them exactly:
 * that is what the linear patch test needs. Rational integrands converge geometrically; q + 6
 * points leave some 1e-10 in that test on a torus of degree 2. Values at points come from the
 * separable extraction. Elements are integrated in parallel, a chunk at a time, and added one after
 * the other: the same bits for every number of threads. Row 3 A + i of the elasticity matrix is
 * component i of function A. */
#ifdef _OPENMP
#include <omp.h>
#endif

#include "matrix.h"
#include "quadrature.h"

static const char stage[] = "matrix";

enum { CHUNK = 64 };

typedef struct assembly {
  const tsolid_solid *solid;
  tsolid_matrix_kind kind;
  double lambda, mu;
  int n_functions, n_components, most;
  int *list_start, *list; /* functions of each element */
  size_t *use_start;      /* elements of each function */
  int *use;
  tsolid_matrix *matrix; /* pattern by functions first */
} assembly;

/* ---- who meets whom ----------------------------------------------------------------------------
 */

static tsolid_status list_functions(tsolid_context *context, tsi_arena *arena, assembly *a) {
  const tsolid_space *space = a->solid->space;
  size_t n = (size_t)space->n_elements, total = 0;
  int *work = tsi_arena_new(arena, (size_t)a->most, sizeof *work);
  a->list_start = tsi_arena_new(arena, n + 1, sizeof *a->list_start);
  a->use_start = tsi_arena_new(arena, (size_t)a->n_functions + 2, sizeof *a->use_start);
  if (!work || !a->list_start || !a->use_start)
    return tsi_no_memory(context, stage);
  for (int e = 0; e < space->n_elements; e++) {
    total += (size_t)tsi_element_function_list(space, e, work);
    if (total > TSI_MAX_COUNT)
      return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "The solid is too large");
    a->list_start[e + 1] = (int)total;
  }
  a->list = tsi_arena_new(arena, total, sizeof *a->list);
  a->use = tsi_arena_new(arena, total, sizeof *a->use);
  if (!a->list || !a->use)
    return tsi_no_memory(context, stage);
  for (int e = 0; e < space->n_elements; e++) {
    int count = tsi_element_function_list(space, e, work), first = a->list_start[e];
    memcpy(a->list + first, work, (size_t)count * sizeof *work);
    for (int k = 0; k < count; k++)
      a->use_start[work[k] + 2]++;
  }
  for (int f = 0; f < a->n_functions; f++)
    a->use_start[f + 2] += a->use_start[f + 1];
  for (int e = 0; e < space->n_elements; e++)
    for (int k = a->list_start[e]; k < a->list_start[e + 1]; k++)
      a->use[a->use_start[a->list[k] + 1]++] = e;
  return TSOLID_OK;
}

/* Merges the ascending lists of the function's elements into `row`; returns its length. */
static int merge_row(const assembly *a, int function, int *row, int *other) {
  int n = 0;
  for (size_t u = a->use_start[function]; u < a->use_start[function + 1]; u++) {
    const int *list = a->list + a->list_start[a->use[u]];
    int m = a->list_start[a->use[u] + 1] - a->list_start[a->use[u]], i = 0, j = 0, kept = 0;
    while (i < n || j < m) {
      int take = j == m || (i < n && row[i] <= list[j]) ? row[i] : list[j];
      i += i < n && row[i] == take;
      j += j < m && list[j] == take;
      other[kept++] = take;
    }
    n = kept;
    memcpy(row, other, (size_t)n * sizeof *row);
  }
  return n;
}

static tsolid_status make_pattern(tsolid_context *context, tsi_arena *arena, assembly *a) {
  tsolid_matrix *m = a->matrix;
  int c = a->n_components, n_rows = a->n_functions * c;
  int *row = tsi_arena_new(arena, (size_t)a->n_functions, sizeof *row);
  int *other = tsi_arena_new(arena, (size_t)a->n_functions, sizeof *other);
  m->row_start = tsi_new(&context->allocator, (size_t)n_rows + 1, sizeof *m->row_start);
  if (!row || !other || !m->row_start)
    return tsi_no_memory(context, stage);
  m->n_rows = n_rows;
  m->n_components = c;
  for (int f = 0; f < a->n_functions; f++) {
    size_t n = (size_t)merge_row(a, f, row, other) * (size_t)c;
    for (int i = 0; i < c; i++)
      m->row_start[f * c + i + 1] = m->row_start[f * c + i] + n;
  }
  m->column = tsi_new(&context->allocator, m->row_start[n_rows], sizeof *m->column);
  m->value = tsi_new(&context->allocator, m->row_start[n_rows], sizeof *m->value);
  if (!m->column || !m->value)
    return tsi_no_memory(context, stage);
  for (int f = 0; f < a->n_functions; f++) {
    int n = merge_row(a, f, row, other);
    for (int i = 0; i < c; i++)
      for (int k = 0; k < n; k++)
        for (int j = 0; j < c; j++)
          m->column[m->row_start[f * c + i] + (size_t)(k * c + j)] = row[k] * c + j;
    if (f % 1024 == 0) {
      tsolid_status status = tsi_progress(context, stage, 0.3 * f / a->n_functions);
      if (status)
        return status;
    }
  }
  return TSOLID_OK;
}

/* ---- elements ----------------------------------------------------------------------------------
 */

/* Adds one point's share to the lower triangle of the element's n x n matrices, one behind the
 * other: f f for the mass, the sum of d_i f d_i f for Laplace, all nine d_i f d_j f, by row i, for
 * elasticity. */
static void add_point(tsolid_matrix_kind kind, const tsi_rational *r, double weight, double *k) {
  size_t n = (size_t)r->n;
  int first = kind == TSOLID_MASS ? 0 : 1, last = kind == TSOLID_MASS ? 0 : 3;
  for (int i = first; i <= last; i++)
    for (int j = kind == TSOLID_ELASTICITY ? first : i; j <= last; j++) {
      double *to = kind == TSOLID_ELASTICITY ? k + (size_t)(3 * i + j - 4) * n * n : k;
      const double *f = r->value[i], *restrict g = r->value[j];
      for (size_t p = 0; p < n; p++) {
        double factor = weight * f[p], *restrict row = to + p * n;
        for (size_t q = 0; q <= p; q++)
          row[q] += factor * g[q];
      }
      if (kind != TSOLID_ELASTICITY)
        break;
    }
}

static int count_points(const tsolid_solid *solid, int degree) {
  int n = solid->constant_weight ? (3 * degree + 1) / 2 : degree + 6;
  return n < 2 ? 2 : n;
}

static void integrate_element(const assembly *a, int element, tsi_rational *r, double *k) {
  const tsi_element *e = &a->solid->space->element[element];
  double weight[3][TSI_RATIONAL_POINTS], size = 1.0;
  int c = a->n_components, first = a->list_start[element], point = 0, *n = r->n_points;
  r->n = a->list_start[element + 1] - first;
  memcpy(r->function, a->list + first, (size_t)r->n * sizeof *r->function);
  memset(k, 0, (size_t)(r->n * r->n * c * c) * sizeof *k);
  for (int d = 0; d < 3; d++) {
    n[d] = count_points(a->solid, e->degree[d]);
    tsi_gauss(n[d], r->x[d], weight[d]);
    size *= e->box[d + 3] - e->box[d];
  }
  tsi_rational_fill(a->solid->space, element, r);
  for (int z = 0; z < n[2]; z++)
    for (int y = 0; y < n[1]; y++)
      for (int x = 0; x < n[0]; x++, point++) {
        tsi_rational_at(a->solid, r, point);
        add_point(a->kind, r, weight[0][x] * weight[1][y] * weight[2][z] * size * r->volume, k);
      }
}

/* The entry (p i, q j) of an element's matrix. Of each n x n matrix the lower triangle is there;
 * the upper one of d_i f d_j f is the lower one of d_j f d_i f. */
static double element_entry(const assembly *a, size_t n, const double *k, size_t p, int i, size_t q,
                            int j) {
  size_t at = p >= q ? p * n + q : q * n + p;
  if (a->n_components == 1)
    return k[at];
  const double *ij = k + (size_t)(p >= q ? 3 * i + j : 3 * j + i) * n * n;
  const double *ji = k + (size_t)(p >= q ? 3 * j + i : 3 * i + j) * n * n;
  double value = a->lambda * ij[at] + a->mu * ji[at];
  return i == j ? value + a->mu * (k[at] + k[4 * n * n + at] + k[8 * n * n + at]) : value;
}

static void scatter(const assembly *a, int element, const double *k) {
  tsolid_matrix *m = a->matrix;
  const int *list = a->list + a->list_start[element];
  int n = a->list_start[element + 1] - a->list_start[element], c = a->n_components;
  for (int p = 0; p < n; p++)
    for (int i = 0; i < c; i++) {
      size_t at = m->row_start[list[p] * c + i];
      for (int q = 0; q < n; q++) {
        while (m->column[at] != list[q] * c)
          at += (size_t)c;
        for (int j = 0; j < c; j++)
          m->value[at + (size_t)j] += element_entry(a, (size_t)n, k, (size_t)p, i, (size_t)q, j);
      }
    }
}

/* Most points of the grid on any element. */
static int most_points(const tsolid_solid *solid) {
  int most = 1;
  for (int e = 0; e < solid->space->n_elements; e++) {
    int n = 1;
    for (int d = 0; d < 3; d++)
      n *= count_points(solid, solid->space->element[e].degree[d]);
    most = n > most ? n : most;
  }
  return most;
}

static tsolid_status integrate(tsolid_context *context, tsi_arena *arena, const assembly *a) {
  int n_elements = a->solid->space->n_elements, widest = 0, ok = 1;
  for (int e = 0; e < n_elements; e++) {
    int n = a->list_start[e + 1] - a->list_start[e];
    widest = n > widest ? n : widest;
  }
  size_t room = (size_t)widest * (size_t)widest * (size_t)(a->n_components * a->n_components);
  double *k = tsi_arena_new(arena, CHUNK * room, sizeof *k);
  tsi_rational *r = tsi_arena_new(arena, (size_t)context->n_threads, sizeof *r);
  for (int t = 0; r && ok && t < context->n_threads; t++)
    ok = tsi_rational_new(arena, a->most, most_points(a->solid), &r[t]);
  if (!k || !r || !ok)
    return tsi_no_memory(context, stage);
  for (int first = 0; first < n_elements; first += CHUNK) {
    int end = n_elements - first < CHUNK ? n_elements : first + CHUNK;
    tsolid_status status = tsi_progress(context, stage, 0.3 + 0.7 * first / n_elements);
    if (status)
      return status;
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 1) num_threads(context->n_threads)
    for (int e = first; e < end; e++)
      integrate_element(a, e, &r[omp_get_thread_num()], k + (size_t)(e - first) * room);
#else
    for (int e = first; e < end; e++)
      integrate_element(a, e, &r[0], k + (size_t)(e - first) * room);
#endif
    for (int e = first; e < end; e++)
      scatter(a, e, k + (size_t)(e - first) * room);
  }
  return TSOLID_OK;
}

/* ---- public: matrices --------------------------------------------------------------------------
 */

static tsolid_status set_material(tsolid_context *context, const tsolid_material *material,
                                  assembly *a) {
  double e = material ? material->young : 1.0, nu = material ? material->poisson : 0.0;
  if (!(e > 0.0) || !isfinite(e) || !(nu > -1.0 && nu < 0.5))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "Young's modulus %g must be positive, Poisson's ratio %g between -1 and 0.5", e,
                    nu);
  a->lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  a->mu = 0.5 * e / (1.0 + nu);
  return TSOLID_OK;
}

tsolid_status tsolid_matrix_create(tsolid_context *context, const tsolid_solid *solid,
                                   tsolid_matrix_kind kind, const tsolid_material *material,
                                   tsolid_matrix **result) {
  if (!context || !result)
    return TSOLID_ERROR_ARGUMENT;
  *result = NULL;
  if (!solid || kind < TSOLID_MASS || kind > TSOLID_ELASTICITY)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "No solid, or no matrix %d", (int)kind);
  tsi_arena arena = tsi_arena_create(context);
  assembly a = {.solid = solid, .kind = kind, .n_components = kind == TSOLID_ELASTICITY ? 3 : 1};
  a.n_functions = solid->space->n_inner + 2 * solid->space->n_surface;
  a.most = tsi_most_functions(solid->space);
  tsolid_status status = set_material(context, material, &a);
  if (status)
    goto done;
  a.matrix = tsi_new(&context->allocator, 1, sizeof *a.matrix);
  if (!a.matrix) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  a.matrix->allocator = context->allocator;
  a.matrix->references = 1;
  status = list_functions(context, &arena, &a);
  if (!status)
    status = make_pattern(context, &arena, &a);
  if (!status)
    status = integrate(context, &arena, &a);
done:
  tsi_arena_free(&arena);
  if (status)
    tsolid_matrix_free(a.matrix);
  else
    *result = a.matrix;
  return status;
}

void tsolid_matrix_free(tsolid_matrix *matrix) {
  if (!matrix || --matrix->references > 0)
    return;
  tsi_allocator allocator = matrix->allocator;
  tsi_delete(&allocator, matrix->row_start);
  tsi_delete(&allocator, matrix->column);
  tsi_delete(&allocator, matrix->value);
  tsi_delete(&allocator, matrix);
}

void tsolid_matrix_get(const tsolid_matrix *matrix, tsolid_matrix_view *view) {
  *view = (tsolid_matrix_view){.n_rows = matrix->n_rows,
                               .n_components = matrix->n_components,
                               .row_start = matrix->row_start,
                               .column = matrix->column,
                               .value = matrix->value};
}

/* ---- public: loads -----------------------------------------------------------------------------
 */

/* The part of an element's outer face that lies in the region, in local coordinates; 0: none. */
static int clip_face(const tsi_element *e, const tsolid_region *region, double low[2],
                     double high[2]) {
  int along[2] = {tsi_side_s(region->side), tsi_side_t(region->side)};
  for (int d = 0; d < 2; d++) {
    double a = e->box[along[d]], width = e->box[along[d] + 3] - a;
    low[d] = fmax(0.0, (region->box[2 * d] - a) / width);
    high[d] = fmin(1.0, (region->box[2 * d + 1] - a) / width);
    if (!(low[d] < high[d]))
      return 0;
  }
  return 1;
}

static void load_element(const tsolid_solid *solid, const tsolid_region *region, int element,
                         const double low[2], const double high[2], tsi_rational *r, double *load) {
  const tsi_element *e = &solid->space->element[element];
  int axis = tsi_side_axis(region->side), n[2];
  int along[2] = {tsi_side_s(region->side), tsi_side_t(region->side)};
  double weight[2][TSI_RATIONAL_POINTS], size = 1.0;
  for (int d = 0; d < 2; d++) {
    double *x = r->x[along[d]];
    n[d] = r->n_points[along[d]] = count_points(solid, e->degree[along[d]]);
    tsi_gauss(n[d], x, weight[d]);
    for (int i = 0; i < n[d]; i++)
      x[i] = low[d] + x[i] * (high[d] - low[d]);
    size *= (high[d] - low[d]) * (e->box[along[d] + 3] - e->box[along[d]]);
  }
  r->n = tsi_element_function_list(solid->space, element, r->function);
  r->n_points[axis] = 1;
  r->x[axis][0] = region->side & 1 ? 1.0 : 0.0;
  tsi_rational_fill(solid->space, element, r);
  for (int j = 0; j < n[1]; j++)
    for (int i = 0; i < n[0]; i++) {
      tsi_rational_at(solid, r, i + n[0] * j); /* along[0] < along[1] */
      const double *p = r->jacobian[along[0]], *q = r->jacobian[along[1]];
      double x = p[1] * q[2] - p[2] * q[1], y = p[2] * q[0] - p[0] * q[2],
             z = p[0] * q[1] - p[1] * q[0];
      double area = weight[0][i] * weight[1][j] * size * sqrt(x * x + y * y + z * z);
      for (int k = 0; k < r->n; k++)
        load[r->function[k]] += area * r->value[0][k];
    }
}

tsolid_status tsolid_face_load(tsolid_context *context, const tsolid_solid *solid,
                               const tsolid_region *region, double *load) {
  if (!context)
    return TSOLID_ERROR_ARGUMENT;
  if (!solid || !region || !load || region->side < 0 || region->side > 5)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "No solid, no region or no side");
  const tsolid_space *space = solid->space;
  tsi_arena arena = tsi_arena_create(context);
  tsi_rational r;
  tsolid_status status = TSOLID_OK;
  if (!tsi_rational_new(&arena, tsi_most_functions(space), most_points(solid), &r)) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  memset(load, 0, (size_t)(space->n_inner + 2 * space->n_surface) * sizeof *load);
  int axis = tsi_side_axis(region->side), far = region->side & 1 ? axis + 3 : axis;
  double end[3], low[2], high[2];
  tsolid_solid_boundary_point(solid, region->side, 0.0, 0.0, end);
  for (int e = 0; e < space->n_elements; e++)
    if (space->element[e].block == 1 + region->side && space->element[e].box[far] == end[axis] &&
        clip_face(&space->element[e], region, low, high))
      load_element(solid, region, e, low, high, &r, load);
done:
  tsi_arena_free(&arena);
  return status;
}
