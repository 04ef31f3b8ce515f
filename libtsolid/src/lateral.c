/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Lateral cells: what the elements of an arm that stand above each other share, namely the surface
 * functions on their (s,t) box, in Bernstein form of the arm's lateral degrees. */
#include "bernstein.h"
#include "extract.h"

#include <stdlib.h>

static const char *const STAGE = "space";

static int compare_places(const tsi_lateral_request *p, const tsi_lateral_request *q) {
  if (p->side != q->side)
    return p->side < q->side ? -1 : 1;
  if (p->side_element != q->side_element)
    return p->side_element < q->side_element ? -1 : 1;
  for (int i = 0; i < 4; i++)
    if (p->box[i] != q->box[i])
      return p->box[i] < q->box[i] ? -1 : 1;
  return 0;
}

static int compare_requests(const void *a, const void *b) {
  const tsi_lateral_request *p = a, *q = b;
  int order = compare_places(p, q);
  return order ? order : (p->element > q->element) - (p->element < q->element);
}

static int inner_or(int degree) {
  return degree > TSI_INNER_DEGREE ? degree : TSI_INNER_DEGREE;
}

/* Restricts a function's coefficients to the box and raises them to the lateral degrees. */
static void restrict_and_raise(const tsi_side *side, const double *from, const double element[4],
                               const double box[4], const int degree[2], double *target) {
  double work[TSI_MAX_ORDER * TSI_MAX_ORDER], wide[TSI_MAX_ORDER * TSI_MAX_ORDER];
  int p = side->degree[0], q = side->degree[1], n = p + 1, m = degree[0] + 1;
  memcpy(work, from, (size_t)(n * (q + 1)) * sizeof *work);
  double ds = element[1] - element[0], dt = element[3] - element[2];
  double s0 = (box[0] - element[0]) / ds, s1 = (box[1] - element[0]) / ds;
  double t0 = (box[2] - element[2]) / dt, t1 = (box[3] - element[2]) / dt;
  for (int j = 0; j <= q; j++)
    tsi_bernstein_restrict(p, s0, s1, work + j * n, 1);
  for (int i = 0; i <= p; i++)
    tsi_bernstein_restrict(q, t0, t1, work + i, n);
  for (int j = 0; j <= q; j++)
    tsi_bernstein_raise(p, degree[0], 1, work + j * n, wide + j * m);
  tsi_bernstein_raise(q, degree[1], m, wide, target);
}

/* One function of a side element: its id and which row of coefficients it has. */
typedef struct ranked {
  int function, entry;
} ranked;

static int compare_ranked(const void *a, const void *b) {
  const ranked *p = a, *q = b;
  return (p->function > q->function) - (p->function < q->function);
}

static void fill_lateral(tsolid_space *space, const tsi_lateral_request *r, tsi_lateral *l,
                         ranked *work) {
  const tsi_side *side = &space->boundary->side[r->side];
  size_t from_size = (size_t)(side->degree[0] + 1) * (size_t)(side->degree[1] + 1);
  size_t size = (size_t)(l->degree[0] + 1) * (size_t)(l->degree[1] + 1);
  int first = side->function_start[r->side_element];
  int n = side->function_start[r->side_element + 1] - first;
  for (int i = 0; i < n; i++)
    work[i] = (ranked){side->function[first + i], first + i};
  qsort(work, (size_t)n, sizeof *work, compare_ranked);
  for (int i = 0; i < n; i++) {
    space->lateral_function[l->function_first + i] = work[i].function;
    restrict_and_raise(side, side->coefficient + (size_t)work[i].entry * from_size,
                       side->box + 4 * (size_t)r->side_element, r->box, l->degree,
                       space->lateral_coefficient + l->coefficient_first + (size_t)i * size);
  }
}

/* Sizes of all lateral cells; returns the number of functions of the largest. */
static int lay_out(tsolid_space *space, int n_requests, const tsi_lateral_request *request,
                   size_t *n_functions, size_t *n_coefficients) {
  int largest = 0;
  *n_functions = *n_coefficients = 0;
  for (int i = 0; i < n_requests; i++) {
    const tsi_lateral_request *r = &request[i];
    if (i == 0 || compare_places(r, r - 1) != 0) {
      const tsi_side *side = &space->boundary->side[r->side];
      tsi_lateral *l = &space->lateral[space->n_laterals++];
      int n = side->function_start[r->side_element + 1] - side->function_start[r->side_element];
      *l = (tsi_lateral){.side = r->side,
                         .degree = {inner_or(side->degree[0]), inner_or(side->degree[1])},
                         .function_first = (int)*n_functions,
                         .function_end = (int)*n_functions + n,
                         .coefficient_first = *n_coefficients};
      memcpy(l->box, r->box, sizeof l->box);
      *n_functions += (size_t)n;
      *n_coefficients += (size_t)n * (size_t)(l->degree[0] + 1) * (size_t)(l->degree[1] + 1);
      largest = n > largest ? n : largest;
    }
    space->element[r->element].lateral = space->n_laterals - 1;
  }
  return largest;
}

tsolid_status tsi_laterals_create(tsolid_context *context, tsolid_space *space, int n_requests,
                                  tsi_lateral_request *request) {
  size_t n_functions, n_coefficients;
  if (n_requests)
    qsort(request, (size_t)n_requests, sizeof *request, compare_requests);
  space->lateral = tsi_new(&space->allocator, (size_t)n_requests, sizeof *space->lateral);
  if (!space->lateral)
    return tsi_no_memory(context, STAGE);
  int largest = lay_out(space, n_requests, request, &n_functions, &n_coefficients);
  if (n_functions > TSI_MAX_COUNT)
    return tsi_no_memory(context, STAGE);
  space->lateral_function = tsi_new(&space->allocator, n_functions, sizeof(int));
  space->lateral_coefficient = tsi_new(&space->allocator, n_coefficients, sizeof(double));
  ranked *work = tsi_new(&space->allocator, (size_t)largest, sizeof *work);
  int complete = space->lateral_function && space->lateral_coefficient && work;
  int at = -1;
  for (int i = 0; complete && i < n_requests; i++)
    if (i == 0 || compare_places(&request[i], &request[i - 1]) != 0)
      fill_lateral(space, &request[i], &space->lateral[++at], work);
  tsi_delete(&space->allocator, work);
  return complete ? TSOLID_OK : tsi_no_memory(context, STAGE);
}
