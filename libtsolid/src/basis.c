/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Are the functions a basis? The sum and the sign are read off Bernstein coefficients, traces are
 * compared function by function, and ranks are the smallest eigenvalues of two mass matrices:
 * restricted to r = R only the layer R is left, then the first r-derivative there leaves the layer
 * R- with the same surface functions, and what vanishes with both are the inner functions. */
#include "bernstein.h"
#include "conform.h"
#include "evaluate.h"

#ifdef _OPENMP
#include <omp.h>
#endif

enum { MAX_RANK_FUNCTIONS = 20000 };

static const char *const STAGE = "report";

/* ---- sum and sign ------------------------------------------------------------------------------
 */

static int element_size(const tsi_element *element) {
  return (element->degree[0] + 1) * (element->degree[1] + 1) * (element->degree[2] + 1);
}

/* The net of all ones is the sum of all functions in Bernstein form. */
static tsolid_status measure_sum(tsolid_context *context, const tsolid_space *space,
                                 double *defect) {
  tsi_arena arena = tsi_arena_create(context);
  size_t n = (size_t)space->n_inner + 2 * (size_t)space->n_surface, largest = 0;
  for (int e = 0; e < space->n_elements; e++) {
    size_t size = (size_t)element_size(&space->element[e]);
    largest = size > largest ? size : largest;
  }
  double *one = tsi_arena_new(&arena, n, sizeof *one);
  double *net = tsi_arena_new(&arena, largest, sizeof *net);
  *defect = 0.0;
  for (size_t i = 0; one && i < n; i++)
    one[i] = 1.0;
  for (int e = 0; one && net && e < space->n_elements; e++) {
    tsi_element_net(space, one, 1, e, net);
    for (int k = 0; k < element_size(&space->element[e]); k++)
      *defect = fmax(*defect, fabs(net[k] - 1.0));
  }
  tsolid_status status = one && net ? TSOLID_OK : tsi_no_memory(context, STAGE);
  tsi_arena_free(&arena);
  return status;
}

/* The surface is what the input says: a sum of its own functions other than one stays. */
static double measure_input_sum(const tsolid_boundary *boundary) {
  double defect = 0.0;
  for (int i = 0; i < 6; i++) {
    const tsi_side *side = &boundary->side[i];
    size_t width = (size_t)(side->degree[0] + 1) * (size_t)(side->degree[1] + 1);
    for (int e = 0; e < side->n_elements; e++)
      for (size_t c = 0; c < width; c++) {
        double sum = 0.0;
        for (int k = side->function_start[e]; k < side->function_start[e + 1]; k++)
          sum += side->coefficient[(size_t)k * width + c];
        defect = fmax(defect, fabs(sum - 1.0));
      }
  }
  return defect;
}

static void widen(const double *value, size_t n, double range[2]) {
  for (size_t i = 0; i < n; i++) {
    range[0] = fmin(range[0], value[i]);
    range[1] = fmax(range[1], value[i]);
  }
}

static double smallest_product(const double a[2], const double b[2]) {
  return fmin(fmin(a[0] * b[0], a[0] * b[1]), fmin(a[1] * b[0], a[1] * b[1]));
}

static double largest_product(const double a[2], const double b[2]) {
  return fmax(fmax(a[0] * b[0], a[0] * b[1]), fmax(a[1] * b[0], a[1] * b[1]));
}

static void row_range(const tsolid_space *space, int row, double range[2]) {
  const double *value = space->row + 4 * (size_t)row;
  range[0] = range[1] = value[0];
  widen(value, 4, range);
}

static double smallest_inner(const tsolid_space *space, size_t entry) {
  double range[3][2], plane[2];
  for (int d = 0; d < 3; d++)
    row_range(space, space->inner_row[entry][d], range[d]);
  plane[0] = smallest_product(range[0], range[1]);
  plane[1] = largest_product(range[0], range[1]);
  return smallest_product(plane, range[2]);
}

static double smallest_surface(const tsolid_space *space, const tsi_element *element) {
  const tsi_lateral *lateral = &space->lateral[element->lateral];
  size_t n = (size_t)(lateral->degree[0] + 1) * (size_t)(lateral->degree[1] + 1) *
             (size_t)(lateral->function_end - lateral->function_first);
  const double *coefficient = space->lateral_coefficient + lateral->coefficient_first;
  double smallest = (double)INFINITY;
  for (int layer = 0; layer < 2 && n > 0; layer++)
    if (element->radial[layer] >= 0) {
      double radial[2], range[2] = {coefficient[0], coefficient[0]};
      row_range(space, element->radial[layer], radial);
      widen(coefficient, n, range);
      smallest = fmin(smallest, smallest_product(radial, range));
    }
  return smallest;
}

static double measure_sign(const tsolid_space *space) {
  double smallest = (double)INFINITY;
  for (int e = 0; e < space->n_elements; e++) {
    for (size_t i = space->inner_start[e]; i < space->inner_start[e + 1]; i++)
      smallest = fmin(smallest, smallest_inner(space, i));
    if (space->element[e].lateral >= 0)
      smallest = fmin(smallest, smallest_surface(space, &space->element[e]));
  }
  return smallest;
}

/* ---- traces ------------------------------------------------------------------------------------
 */

typedef struct trace {
  double *difference; /* per function, zero between points */
  int *touched;
  int n_touched;
  double sign;
} trace;

static void add_trace(void *data, int function, const double *value) {
  trace *t = data;
  if (t->difference[function] == 0.0)
    t->touched[t->n_touched++] = function;
  t->difference[function] += t->sign * value[0];
}

static int points_along(const tsolid_space *space, const tsi_face *face, int k) {
  int a = space->element[face->element[0]].degree[face->along[0][k]];
  int b = space->element[face->element[1]].degree[face->along[1][k]];
  return (a > b ? a : b) + 1;
}

/* Largest difference of any function's two traces: enough points to see every polynomial. */
static double face_jump(const tsolid_space *space, const tsi_face *face, trace *t) {
  int n = points_along(space, face, 0), m = points_along(space, face, 1);
  double jump = 0.0;
  for (int i = 0; i < n * m; i++) {
    double a = (double)(i % n) / (n - 1), b = (double)(i / n) / (m - 1), x[3];
    double p = (1.0 - a) * face->box[0] + a * face->box[1];
    double q = (1.0 - b) * face->box[2] + b * face->box[3];
    t->n_touched = 0;
    for (int k = 0; k < 2; k++) {
      t->sign = k ? -1.0 : 1.0;
      tsi_face_local(space, face, k, p, q, x);
      tsi_element_functions(space, face->element[k], x, 0, add_trace, t);
    }
    for (int j = 0; j < t->n_touched; j++) {
      jump = fmax(jump, fabs(t->difference[t->touched[j]]));
      t->difference[t->touched[j]] = 0.0;
    }
  }
  return jump;
}

/* A difference that cancels to zero half-way is listed again: at most once per visit. */
static size_t most_visits(const tsolid_space *space) {
  size_t most = 0;
  for (int e = 0; e < space->n_elements; e++) {
    size_t n = space->inner_start[e + 1] - space->inner_start[e];
    if (space->element[e].lateral >= 0) {
      const tsi_lateral *lateral = &space->lateral[space->element[e].lateral];
      n += 2 * (size_t)(lateral->function_end - lateral->function_first);
    }
    most = n > most ? n : most;
  }
  return 2 * most;
}

static tsolid_status measure_jumps(tsolid_context *context, const tsolid_space *space, int n_faces,
                                   const tsi_face *face, tsolid_basis_report *report) {
  tsi_arena arena = tsi_arena_create(context);
  size_t n = (size_t)space->n_inner + 2 * (size_t)space->n_surface, visits = most_visits(space);
  size_t n_threads = (size_t)context->n_threads;
  double *difference = tsi_arena_new(&arena, n_threads, n * sizeof *difference);
  int *touched = tsi_arena_new(&arena, n_threads, visits * sizeof *touched);
  double *jump = tsi_arena_new(&arena, (size_t)n_faces, sizeof *jump);
  int complete = difference && touched && jump;
#ifdef _OPENMP
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 16) if (complete)
#endif
  for (int i = 0; i < n_faces; i++) {
    if (!complete || face[i].kind == TSI_FACE_BLOCK)
      continue;
#ifdef _OPENMP
    size_t thread = (size_t)omp_get_thread_num();
#else
    size_t thread = 0;
#endif
    trace t = {.difference = difference + thread * n, .touched = touched + thread * visits};
    jump[i] = face_jump(space, &face[i], &t);
  }
  report->diagonal_jump = report->core_jump = 0.0;
  for (int i = 0; complete && i < n_faces; i++) {
    double *largest = face[i].kind == TSI_FACE_CORE ? &report->core_jump : &report->diagonal_jump;
    *largest = fmax(*largest, jump[i]);
  }
  tsi_arena_free(&arena);
  return complete ? TSOLID_OK : tsi_no_memory(context, STAGE);
}

/* ---- mass of the inner functions ---------------------------------------------------------------
 */

/* Per element and direction: the inner products of the distinct rows, so that an entry of the mass
 * matrix is three factors. */
typedef struct gram {
  const tsolid_space *space;
  unsigned char (*local)[3]; /* per entry: which of the element's distinct rows */
  size_t (*table_start)[3];  /* per element */
  int (*n_distinct)[3];
  double *table;
} gram;

/* Integrals of B_i B_j over [0,1]. */
static void bernstein_gram(int degree, double *g) {
  for (int i = 0; i <= degree; i++)
    for (int j = 0; j <= degree; j++)
      g[i * (degree + 1) + j] = tsi_binomial(degree, i) * tsi_binomial(degree, j) /
                                (tsi_binomial(2 * degree, i + j) * (2.0 * degree + 1.0));
}

enum { MAX_DISTINCT = 255 };

/* Numbers the distinct rows of an element's direction; their number, or -1: too many. */
static int number_rows(gram *g, int element, int direction, int row[MAX_DISTINCT]) {
  int n = 0;
  const tsolid_space *space = g->space;
  for (size_t i = space->inner_start[element]; i < space->inner_start[element + 1]; i++) {
    int k = 0;
    while (k < n && row[k] != space->inner_row[i][direction])
      k++;
    if (k == MAX_DISTINCT)
      return -1;
    row[k] = space->inner_row[i][direction];
    n = k == n ? n + 1 : n;
    g->local[i][direction] = (unsigned char)k;
  }
  return n;
}

static double row_product(const double *a, const double *b, const double gram4[16], double width) {
  double sum = 0.0;
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++)
      sum += a[i] * gram4[4 * i + j] * b[j];
  return width * sum;
}

static tsolid_status make_gram(tsolid_context *context, const tsolid_space *space, tsi_arena *arena,
                               gram *g) {
  double gram4[16];
  int row[MAX_DISTINCT];
  size_t n = (size_t)space->n_elements, size = 0;
  *g = (gram){.space = space,
              .local = tsi_arena_new(arena, space->inner_start[n], sizeof *g->local),
              .table_start = tsi_arena_new(arena, n, sizeof *g->table_start),
              .n_distinct = tsi_arena_new(arena, n, sizeof *g->n_distinct)};
  if (!g->local || !g->table_start || !g->n_distinct)
    return tsi_no_memory(context, STAGE);
  bernstein_gram(TSI_INNER_DEGREE, gram4);
  for (int pass = 0; pass < 2; pass++) {
    for (int i = 0; i < 3 * space->n_elements; i++) {
      int e = i / 3, d = i % 3, count = number_rows(g, e, d, row);
      if (count < 0)
        return tsi_fail(context, TSOLID_ERROR_INTERNAL, STAGE,
                        "Element %d has more than %d rows in one direction", e, MAX_DISTINCT);
      const double *box = space->element[e].box;
      if (pass == 0) {
        g->table_start[e][d] = size;
        g->n_distinct[e][d] = count;
        size += (size_t)count * (size_t)count;
      }
      for (int k = 0; pass == 1 && k < count * count; k++)
        g->table[g->table_start[e][d] + (size_t)k] =
            row_product(space->row + 4 * (size_t)row[k / count],
                        space->row + 4 * (size_t)row[k % count], gram4, box[d + 3] - box[d]);
    }
    if (pass == 0)
      g->table = tsi_arena_new(arena, size, sizeof *g->table);
    if (!g->table)
      return tsi_no_memory(context, STAGE);
  }
  return TSOLID_OK;
}

static void inner_mass_row(const void *data, int element, int a, double *out) {
  const gram *g = data;
  size_t first = g->space->inner_start[element], end = g->space->inner_start[element + 1];
  const double *line[3];
  for (int d = 0; d < 3; d++)
    line[d] = g->table + g->table_start[element][d] +
              (size_t)g->local[first + (size_t)a][d] * (size_t)g->n_distinct[element][d];
  for (size_t i = first; i < end; i++)
    *out++ = line[0][g->local[i][0]] * line[1][g->local[i][1]] * line[2][g->local[i][2]];
}

tsolid_status tsi_mass_inner(tsolid_context *context, const tsolid_space *space, tsi_arena *arena,
                             tsi_symmetric *matrix) {
  tsi_arena temporary = tsi_arena_create(context);
  gram g;
  tsolid_status status = make_gram(context, space, &temporary, &g);
  if (status == TSOLID_OK) {
    tsi_element_sum sum = {.n = space->n_inner,
                           .n_elements = space->n_elements,
                           .start = space->inner_start,
                           .unknown = space->inner_function,
                           .row = inner_mass_row,
                           .data = &g};
    status = tsi_symmetric_assemble(context, &sum, arena, matrix);
  }
  tsi_arena_free(&temporary);
  return status;
}

/* ---- mass of the surface functions -------------------------------------------------------------
 */

/* The six sides' elements in one numbering. */
typedef struct surface_elements {
  const tsolid_boundary *boundary;
  int n;
  int *side, *element;
  size_t *start;
  int *function;
  double gram[6][2][TSI_MAX_ORDER * TSI_MAX_ORDER];
} surface_elements;

static int number_surface_elements(const tsolid_boundary *boundary, tsi_arena *arena,
                                   surface_elements *s) {
  size_t n_elements = 0, n_functions = 0;
  s->boundary = boundary;
  for (int k = 0; k < 6; k++) {
    n_elements += (size_t)boundary->side[k].n_elements;
    n_functions += (size_t)boundary->side[k].function_start[boundary->side[k].n_elements];
  }
  s->side = tsi_arena_new(arena, n_elements, sizeof *s->side);
  s->element = tsi_arena_new(arena, n_elements, sizeof *s->element);
  s->start = tsi_arena_new(arena, n_elements + 1, sizeof *s->start);
  s->function = tsi_arena_new(arena, n_functions, sizeof *s->function);
  if (!s->side || !s->element || !s->start || !s->function)
    return 0;
  for (int k = 0; k < 6; k++) {
    const tsi_side *side = &boundary->side[k];
    for (int d = 0; d < 2; d++)
      bernstein_gram(side->degree[d], s->gram[k][d]);
    for (int e = 0; e < side->n_elements; e++, s->n++) {
      size_t n = (size_t)(side->function_start[e + 1] - side->function_start[e]);
      s->side[s->n] = k;
      s->element[s->n] = e;
      s->start[s->n + 1] = s->start[s->n] + n;
      memcpy(s->function + s->start[s->n], side->function + side->function_start[e],
             n * sizeof *s->function);
    }
  }
  return 1;
}

/* out = (G_s x G_t) coefficient, s fastest. */
static void apply_gram(const int degree[2], double (*table)[TSI_MAX_ORDER * TSI_MAX_ORDER],
                       const double *coefficient, double *out) {
  int n = degree[0] + 1, m = degree[1] + 1;
  double work[TSI_MAX_ORDER * TSI_MAX_ORDER];
  for (int j = 0; j < m; j++)
    for (int i = 0; i < n; i++) {
      double sum = 0.0;
      for (int k = 0; k < n; k++)
        sum += table[0][i * n + k] * coefficient[k + n * j];
      work[i + n * j] = sum;
    }
  for (int j = 0; j < m; j++)
    for (int i = 0; i < n; i++) {
      double sum = 0.0;
      for (int k = 0; k < m; k++)
        sum += table[1][j * m + k] * work[i + n * k];
      out[i + n * j] = sum;
    }
}

static void surface_mass_row(const void *data, int element, int a, double *out) {
  surface_elements *s = (surface_elements *)(uintptr_t)data;
  int k = s->side[element], e = s->element[element];
  const tsi_side *side = &s->boundary->side[k];
  size_t size = (size_t)(side->degree[0] + 1) * (size_t)(side->degree[1] + 1);
  const double *box = side->box + 4 * (size_t)e;
  const double *coefficient = side->coefficient + (size_t)side->function_start[e] * size;
  double weighted[TSI_MAX_ORDER * TSI_MAX_ORDER], area = (box[1] - box[0]) * (box[3] - box[2]);
  apply_gram(side->degree, s->gram[k], coefficient + (size_t)a * size, weighted);
  for (int b = 0; b < side->function_start[e + 1] - side->function_start[e]; b++) {
    double sum = 0.0;
    for (size_t i = 0; i < size; i++)
      sum += weighted[i] * coefficient[(size_t)b * size + i];
    out[b] = area * sum;
  }
}

tsolid_status tsi_mass_surface(tsolid_context *context, const tsolid_boundary *boundary,
                               tsi_arena *arena, tsi_symmetric *matrix) {
  tsi_arena temporary = tsi_arena_create(context);
  tsolid_status status = TSOLID_OK;
  surface_elements *s = tsi_arena_new(&temporary, 1, sizeof *s);
  if (!s || !number_surface_elements(boundary, &temporary, s)) {
    status = tsi_no_memory(context, STAGE);
    goto done;
  }
  tsi_element_sum sum = {.n = boundary->n_functions,
                         .n_elements = s->n,
                         .start = s->start,
                         .unknown = s->function,
                         .row = surface_mass_row,
                         .data = s};
  status = tsi_symmetric_assemble(context, &sum, arena, matrix);
done:
  tsi_arena_free(&temporary);
  return status;
}

/* ---- ranks and driver --------------------------------------------------------------------------
 */

/* The inner functions are cubic: iterative. On the surface the condition grows with the degree but
 * factors stay small: direct. */
static tsolid_status measure_ranks(tsolid_context *context, const tsolid_space *space,
                                   tsolid_basis_report *report) {
  tsi_arena arena = tsi_arena_create(context);
  tsi_symmetric mass;
  tsolid_status status = tsi_mass_inner(context, space, &arena, &mass);
  if (status == TSOLID_OK)
    status = tsi_smallest_eigenvalue(context, &mass, TSI_EIGEN_AUTO, &report->inner_eigenvalue);
  if (status == TSOLID_OK)
    status = tsi_mass_surface(context, space->boundary, &arena, &mass);
  if (status == TSOLID_OK)
    status = tsi_smallest_eigenvalue(context, &mass, TSI_EIGEN_DIRECT, &report->surface_eigenvalue);
  report->inner_roundoff = 100.0 * space->n_inner * 0x1p-52;
  report->surface_roundoff = 100.0 * space->n_surface * 0x1p-52;
  report->rank_measured = status == TSOLID_OK;
  tsi_arena_free(&arena);
  return status;
}

tsolid_status tsi_basis_measure(tsolid_context *context, const tsolid_space *space, int n_faces,
                                const tsi_face *face, int max_rank_functions,
                                tsolid_basis_report *report) {
  int limit = max_rank_functions == 0 ? MAX_RANK_FUNCTIONS : max_rank_functions;
  *report = (tsolid_basis_report){.inner_eigenvalue = (double)NAN,
                                  .surface_eigenvalue = (double)NAN,
                                  .inner_roundoff = (double)NAN,
                                  .surface_roundoff = (double)NAN};
  tsolid_status status = measure_sum(context, space, &report->sum_defect);
  report->input_sum_defect = measure_input_sum(space->boundary);
  report->smallest_value = measure_sign(space);
  if (status == TSOLID_OK)
    status = measure_jumps(context, space, n_faces, face, report);
  if (status == TSOLID_OK && space->n_inner <= limit && space->n_surface <= limit)
    status = measure_ranks(context, space, report);
  return status;
}
