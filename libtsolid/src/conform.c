/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Does the solid have the input for its boundary, and does it fill it? Distance of two evaluators
 * at equal parameters; volume by det J against the flux of x/3 through the input. */
#include "conform.h"

#include "bernstein.h"
#include "evaluate.h"
#include "quadrature.h"

#ifdef _OPENMP
#include <omp.h>
#endif

enum { SAMPLES_PER_SIDE = 1000, MAX_RULE = 48, RULE_STEP = 3 };

/* Two rules that differ by less than this, relative to the integral's magnitude, have settled. */
#define SETTLED 2e-14
/* Weights of an element that vary by less, relatively, are one number (and round-off). */
#define CONSTANT_WEIGHT 1e-13

static const char *const STAGE = "report";

/* ---- the boundary's own evaluator --------------------------------------------------------------
 */

int tsi_boundary_point(const tsolid_boundary *boundary, int side_number, double s, double t,
                       double point[3]) {
  const tsi_side *side = &boundary->side[side_number];
  int p = side->degree[0], q = side->degree[1], e = 0;
  double along[TSI_MAX_ORDER], across[TSI_MAX_ORDER], sum[4] = {0.0, 0.0, 0.0, 0.0};
  for (; e < side->n_elements; e++) {
    const double *box = side->box + 4 * (size_t)e;
    if (box[0] <= s && s <= box[1] && box[2] <= t && t <= box[3])
      break;
  }
  if (e == side->n_elements)
    return 0;
  const double *box = side->box + 4 * (size_t)e;
  tsi_bernstein(p, (s - box[0]) / (box[1] - box[0]), along);
  tsi_bernstein(q, (t - box[2]) / (box[3] - box[2]), across);
  for (int k = side->function_start[e]; k < side->function_start[e + 1]; k++) {
    const double *coefficient = side->coefficient + (size_t)k * (size_t)((p + 1) * (q + 1));
    const double *control = boundary->points + 4 * (size_t)side->function[k];
    double value = 0.0;
    for (int i = 0; i < (p + 1) * (q + 1); i++)
      value += coefficient[i] * along[i % (p + 1)] * across[i / (p + 1)];
    for (int c = 0; c < 4; c++)
      sum[c] += value * control[c];
  }
  for (int c = 0; c < 3; c++)
    point[c] = sum[c] / sum[3];
  return 1;
}

static double next_random(uint64_t *state) {
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return (double)(*state >> 11) * 0x1p-53;
}

static tsolid_status measure_distance(tsolid_context *context, const tsolid_solid *solid,
                                      tsolid_conformity_report *report) {
  uint64_t state = 20120609u;
  report->n_samples = 0;
  report->distance = 0.0;
  for (int i = 0; i < 6 * SAMPLES_PER_SIDE; i++) {
    int side = i / SAMPLES_PER_SIDE;
    double s = next_random(&state), t = next_random(&state), u[3], inside[3], input[3];
    int block = tsolid_solid_boundary_point(solid, side, s, t, u);
    tsolid_status status = tsolid_solid_evaluate(context, solid, block, u, 0, inside);
    if (status != TSOLID_OK)
      return status;
    if (!tsi_boundary_point(solid->space->boundary, side, s, t, input))
      return tsi_fail(context, TSOLID_ERROR_INTERNAL, STAGE, "No element of side %d holds (%g, %g)",
                      side, s, t);
    double d[3] = {inside[0] - input[0], inside[1] - input[1], inside[2] - input[2]};
    double distance = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (distance > report->distance || isnan(distance)) /* a NaN stays */
      report->distance = distance;
    report->n_samples++;
  }
  return TSOLID_OK;
}

/* ---- integrals over nets -----------------------------------------------------------------------
 */

/* Gauss rules of 1 .. MAX_RULE points. */
typedef struct rule_table {
  double node[MAX_RULE + 1][MAX_RULE], weight[MAX_RULE + 1][MAX_RULE];
} rule_table;

/* A homogeneous net over [0,1]^3 (volume), or over [0,1]^2 with degree[2] = 0 (flux). */
typedef struct workspace {
  const rule_table *rules;
  int is_volume, degree[3];
  double net[TSI_MAX_ORDER * TSI_MAX_ORDER * (TSI_INNER_DEGREE + 1)][4];
  double basis[3][MAX_RULE][2 * TSI_MAX_ORDER]; /* values, then slopes */
  double plane[TSI_MAX_ORDER * TSI_MAX_ORDER][2][4];
  double line[TSI_MAX_ORDER][3][4];
} workspace;

/* det(x_0, x_1, x_2), or x . (x_0 x x_1) / 3, from homogeneous value and slopes. */
static double integrand(int is_volume, double jet[4][4]) {
  double x[3], d[3][3];
  for (int c = 0; c < 3; c++)
    x[c] = jet[0][c] / jet[0][3];
  for (int k = 0; k < 2 + is_volume; k++)
    for (int c = 0; c < 3; c++)
      d[k][c] = (jet[k + 1][c] - jet[k + 1][3] * x[c]) / jet[0][3];
  return is_volume ? tsi_det3(d[0], d[1], d[2]) : tsi_det3(x, d[0], d[1]) / 3.0;
}

/* plane[i + n0*j] = value and slope along u[2] at a point. */
static void contract_net(workspace *w, int point) {
  int n = (w->degree[0] + 1) * (w->degree[1] + 1), m = w->degree[2] + 1;
  for (int i = 0; i < n; i++)
    for (int slope = 0; slope < 2; slope++)
      for (int c = 0; c < 4; c++) {
        double sum = 0.0;
        for (int k = 0; k < m; k++)
          sum += w->basis[2][point][slope * m + k] * w->net[i + n * k][c];
        w->plane[i][slope][c] = sum;
      }
}

/* line[i] = value, slope along u[1], slope along u[2]. */
static void contract_plane(workspace *w, int point) {
  int n = w->degree[0] + 1, m = w->degree[1] + 1;
  const double *value = w->basis[1][point], *slope = value + m;
  for (int i = 0; i < n; i++)
    for (int c = 0; c < 4; c++) {
      double sum[3] = {0.0, 0.0, 0.0};
      for (int j = 0; j < m; j++) {
        sum[0] += value[j] * w->plane[i + n * j][0][c];
        sum[1] += slope[j] * w->plane[i + n * j][0][c];
        sum[2] += value[j] * w->plane[i + n * j][1][c];
      }
      for (int k = 0; k < 3; k++)
        w->line[i][k][c] = sum[k];
    }
}

static void contract_line(const workspace *w, int point, double jet[4][4]) {
  int n = w->degree[0] + 1;
  const double *value = w->basis[0][point], *slope = value + n;
  memset(jet, 0, 16 * sizeof jet[0][0]);
  for (int i = 0; i < n; i++)
    for (int c = 0; c < 4; c++) {
      jet[0][c] += value[i] * w->line[i][0][c];
      jet[1][c] += slope[i] * w->line[i][0][c];
      jet[2][c] += value[i] * w->line[i][1][c];
      jet[3][c] += value[i] * w->line[i][2][c];
    }
}

/* The tensor rule with n[d] points per direction; *magnitude is the integral of |integrand|. */
static double integrate(workspace *w, const int n[3], double *magnitude) {
  double jet[4][4], sum = 0.0;
  *magnitude = 0.0;
  for (int d = 0; d < 3; d++)
    for (int i = 0; i < n[d]; i++)
      tsi_bernstein_derivatives(w->degree[d], w->rules->node[n[d]][i], 1, w->basis[d][i]);
  for (int k = 0; k < n[2]; k++) {
    contract_net(w, k);
    for (int j = 0; j < n[1]; j++) {
      contract_plane(w, j);
      double weight = w->rules->weight[n[2]][k] * w->rules->weight[n[1]][j];
      for (int i = 0; i < n[0]; i++) {
        contract_line(w, i, jet);
        double part = weight * w->rules->weight[n[0]][i] * integrand(w->is_volume, jet);
        sum += part;
        *magnitude += fabs(part);
      }
    }
  }
  return sum;
}

static int is_rational(const workspace *w) {
  int n = (w->degree[0] + 1) * (w->degree[1] + 1) * (w->degree[2] + 1);
  double low = w->net[0][3], high = low;
  for (int i = 1; i < n; i++) {
    low = fmin(low, w->net[i][3]);
    high = fmax(high, w->net[i][3]);
  }
  return high - low > CONSTANT_WEIGHT * high;
}

/* Polynomial of degree 3q - 1 per direction: exact. Rational: more points until it settles. */
static double integrate_net(workspace *w) {
  int n[3], rational = is_rational(w);
  double magnitude, value;
  for (int d = 0; d < 3; d++)
    n[d] = w->degree[d] == 0 ? 1 : (3 * w->degree[d] + 1) / 2;
  value = integrate(w, n, &magnitude);
  for (int settled = !rational; !settled;) {
    int grown = 0;
    for (int d = 0; d < 3; d++) {
      int more = n[d] + RULE_STEP < MAX_RULE ? n[d] + RULE_STEP : MAX_RULE;
      grown |= w->degree[d] > 0 && more > n[d];
      n[d] = w->degree[d] > 0 ? more : 1;
    }
    double next = integrate(w, n, &magnitude);
    settled = !grown || !(fabs(next - value) > SETTLED * magnitude);
    value = next;
  }
  return value;
}

/* ---- volume and flux ---------------------------------------------------------------------------
 */

/* Homogeneous points relative to the centre of the boundary: neither integral changes, and a part
 * far from the origin loses no digits. */
static double *make_centred(const tsolid_solid *solid, tsi_arena *arena) {
  size_t n_surface = (size_t)solid->space->n_surface;
  size_t n = (size_t)solid->space->n_inner + 2 * n_surface;
  double *out = tsi_arena_new(arena, n, 4 * sizeof *out), centre[3];
  if (!out)
    return NULL;
  for (size_t c = 0; c < 3; c++) {
    double low = (double)INFINITY, high = -(double)INFINITY;
    for (size_t i = n - n_surface; i < n; i++) {
      low = fmin(low, solid->control[4 * i + c] / solid->control[4 * i + 3]);
      high = fmax(high, solid->control[4 * i + c] / solid->control[4 * i + 3]);
    }
    centre[c] = 0.5 * (low + high);
  }
  for (size_t i = 0; i < n; i++) {
    const double *from = solid->control + 4 * i;
    for (size_t c = 0; c < 3; c++)
      out[4 * i + c] = from[c] - from[3] * centre[c];
    out[4 * i + 3] = from[3];
  }
  return out;
}

static double element_volume(const tsolid_space *space, const double *control, int element,
                             workspace *w) {
  w->is_volume = 1;
  memcpy(w->degree, space->element[element].degree, sizeof w->degree);
  tsi_element_net(space, control, 4, element, w->net[0]);
  return integrate_net(w);
}

/* Outward flux of x / 3; e_s x e_t points along +x, -y, +z for sides normal to x, y, z. */
static double element_flux(const tsolid_boundary *boundary, const double *points, int number, int e,
                           workspace *w) {
  const tsi_side *side = &boundary->side[number];
  int n = (side->degree[0] + 1) * (side->degree[1] + 1);
  w->is_volume = 0;
  w->degree[0] = side->degree[0];
  w->degree[1] = side->degree[1];
  w->degree[2] = 0;
  memset(w->net, 0, (size_t)n * sizeof w->net[0]);
  for (int k = side->function_start[e]; k < side->function_start[e + 1]; k++)
    for (int i = 0; i < n; i++)
      for (int c = 0; c < 4; c++)
        w->net[i][c] += side->coefficient[(size_t)k * (size_t)n + (size_t)i] *
                        points[4 * (size_t)side->function[k] + (size_t)c];
  int outward = (tsi_side_axis(number) != 1) == (number & 1);
  return outward ? integrate_net(w) : -integrate_net(w);
}

static double sum_volume(const tsolid_space *space, const double *control, int n_threads,
                         workspace *w, double *part) {
  tsi_sum sum = {0.0, 0.0};
#ifdef _OPENMP
#pragma omp parallel for num_threads(n_threads) schedule(dynamic, 8)
#endif
  for (int e = 0; e < space->n_elements; e++) {
#ifdef _OPENMP
    workspace *own = w + omp_get_thread_num();
#else
    workspace *own = w;
#endif
    part[e] = element_volume(space, control, e, own);
  }
  (void)n_threads;
  for (int e = 0; e < space->n_elements; e++)
    tsi_sum_add(&sum, part[e]);
  return tsi_sum_get(&sum);
}

static double sum_flux(const tsolid_boundary *boundary, const double *points, workspace *w) {
  tsi_sum sum = {0.0, 0.0};
  for (int side = 0; side < 6; side++)
    for (int e = 0; e < boundary->side[side].n_elements; e++)
      tsi_sum_add(&sum, element_flux(boundary, points, side, e, w));
  return tsi_sum_get(&sum);
}

static tsolid_status measure_volume(tsolid_context *context, const tsolid_solid *solid,
                                    tsolid_conformity_report *report) {
  const tsolid_space *space = solid->space;
  tsi_arena arena = tsi_arena_create(context);
  size_t n_free = (size_t)space->n_inner + (size_t)space->n_surface;
  rule_table *rules = tsi_arena_new(&arena, 1, sizeof *rules);
  workspace *w = tsi_arena_new(&arena, (size_t)context->n_threads, sizeof *w);
  double *part = tsi_arena_new(&arena, (size_t)space->n_elements, sizeof *part);
  double *control = make_centred(solid, &arena);
  int complete = rules && w && part && control;
  if (complete) {
    for (int n = 1; n <= MAX_RULE; n++)
      tsi_gauss(n, rules->node[n], rules->weight[n]);
    for (int i = 0; i < context->n_threads; i++)
      w[i].rules = rules;
    report->volume = sum_volume(space, control, context->n_threads, w, part);
    report->flux = sum_flux(space->boundary, control + 4 * n_free, w);
  }
  tsi_arena_free(&arena);
  return complete ? TSOLID_OK : tsi_no_memory(context, STAGE);
}

/* ---- driver ------------------------------------------------------------------------------------
 */

tsolid_status tsi_conformity_measure(tsolid_context *context, const tsolid_solid *solid,
                                     tsolid_conformity_report *report) {
  const tsolid_space *space = solid->space;
  size_t n_surface = (size_t)space->n_surface, n_free = (size_t)space->n_inner + n_surface;
  *report = (tsolid_conformity_report){.scale = space->boundary->scale};
  report->control_identical = memcmp(solid->control + 4 * n_free, space->boundary->points,
                                     4 * n_surface * sizeof *solid->control) == 0;
  tsolid_status status = measure_distance(context, solid, report);
  return status == TSOLID_OK ? measure_volume(context, solid, report) : status;
}
