/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The certificate: products with their error bounds, declared errors of control points, solids. The
 * verdicts themselves are compared with exact arithmetic in test_certify_exact.py. */
#include "certify.h"

#include "bernstein.h"
#include "bernstein_product.h"
#include "check.h"
#include "evaluate.h"
#include "exact.h"
#include "parts.h"

static uint64_t state = 12345;

static double uniform(void) { /* in [-1, 1) */
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) * 0x1p-52 - 1.0;
}

/* ---- products
 * ------------------------------------------------------------------------------------ */

enum { MAX_SIZE = 4096 };

static tsi_product random_product(int n0, int n1, int n2, double *pair) {
  tsi_product a = {{n0, n1, n2}, 0.0, pair};
  for (size_t k = 0; k < tsi_product_size(&a); k++) {
    pair[2 * k] = uniform();
    pair[2 * k + 1] = fabs(pair[2 * k]);
  }
  return a;
}

/* Unscaled value at x. */
static long double value_at(const tsi_product *a, const double x[3], int magnitude) {
  double b[3][128];
  long double sum = 0.0L;
  for (int d = 0; d < 3; d++)
    tsi_bernstein(a->n[d] - 1, x[d], b[d]);
  for (int k = 0; k < a->n[2]; k++)
    for (int j = 0; j < a->n[1]; j++)
      for (int i = 0; i < a->n[0]; i++)
        sum += (long double)b[0][i] * b[1][j] * b[2][k] *
               a->pair[2 * (i + a->n[0] * (j + a->n[1] * k)) + magnitude];
  return sum;
}

/* Convolution in long double; also: the bound must not be millions of times the error. */
static void test_product_against_long_double(int na, int nb) {
  static double pa[2 * MAX_SIZE], pb[2 * MAX_SIZE], pc[2 * MAX_SIZE];
  tsi_product a = random_product(na, nb, 3, pa), b = random_product(nb, 2, na, pb);
  tsi_product c = {{0, 0, 0}, 0.0, pc};
  tsi_product_clear(&c, &a, &b);
  tsi_product_add(&c, -1.0, &a, &b);
  tsi_product_close(&c, 1, &a, &b);
  double most = 0.0;
  for (int k = 0; k < c.n[2]; k++)
    for (int j = 0; j < c.n[1]; j++)
      for (int i = 0; i < c.n[0]; i++) {
        long double sum = 0.0L;
        for (int z = 0; z < a.n[2]; z++)
          for (int y = 0; y < a.n[1]; y++)
            for (int x = 0; x < a.n[0]; x++) {
              if (i - x < 0 || i - x >= b.n[0] || j - y < 0 || j - y >= b.n[1] || k - z < 0 ||
                  k - z >= b.n[2])
                continue;
              sum -= (long double)pa[2 * (x + a.n[0] * (y + a.n[1] * z))] *
                     pb[2 * (i - x + b.n[0] * (j - y + b.n[1] * (k - z)))];
            }
        const double *v = pc + 2 * (i + c.n[0] * (j + c.n[1] * k));
        double error = (double)fabsl(v[0] - sum), bound = c.delta * TSI_MAGNITUDE_SLACK * v[1];
        CHECK(error <= bound);
        most = fmax(most, bound > 0.0 ? error / bound : 0.0);
      }
  CHECK(most > 1e-4);
}

/* The scaled product, unscaled, is the product of the values; both halves take over its values. */
static void test_product_values_and_bisection(void) {
  static double pa[2 * MAX_SIZE], pb[2 * MAX_SIZE], pc[2 * MAX_SIZE], pd[2 * MAX_SIZE];
  tsi_product a = random_product(4, 3, 2, pa), b = random_product(3, 5, 4, pb);
  tsi_product c = {{0, 0, 0}, 0.0, pc}, high = {{0, 0, 0}, 0.0, pd};
  tsi_product_clear(&c, &a, &b);
  tsi_product_add(&c, 1.0, &a, &b);
  tsi_product_close(&c, 1, &a, &b);
  tsi_product_unscale(&a);
  tsi_product_unscale(&b);
  tsi_product_unscale(&c);
  const double x[3] = {0.3, 0.85, 0.125};
  double value = (double)value_at(&c, x, 0);
  CHECK_NEAR(value, (double)(value_at(&a, x, 0) * value_at(&b, x, 0)), 1e-13);
  double at[3] = {0.3, 0.85, 0.125};
  for (int axis = 0; axis < 3; axis++) {
    double before = c.delta, magnitude = (double)value_at(&c, at, 1);
    tsi_product_bisect(&c, &high, axis);
    CHECK(c.delta > before && high.delta == c.delta);
    if (at[axis] > 0.5)
      memcpy(pc, pd, 2 * tsi_product_size(&c) * sizeof *pc);
    at[axis] = 2.0 * at[axis] - (at[axis] > 0.5);
    CHECK_NEAR((double)value_at(&c, at, 0), value, 1e-13);
    CHECK_NEAR((double)value_at(&c, at, 1), magnitude, 1e-13 * magnitude);
  }
}

/* det of a matrix that is singular but for one entry, which is `step` off: step times a minor. */
static void test_exact_determinant(void) {
  for (int trial = 0; trial < 200; trial++) {
    double m[4][4];
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 4; j++)
        m[i][j] = (trial % 2 ? 1e6 : 0.0) + uniform();
    memcpy(m[3], m[0], sizeof m[3]);
    const double *rows[4] = {m[0], m[1], m[2], m[3]};
    CHECK(tsi_exact_det4(rows) == 0);
    int up = trial % 3 != 0;
    m[3][3] = nextafter(m[0][3], up ? INFINITY : -INFINITY);
    double minor = tsi_det3(m[0], m[1], m[2]);
    if (fabs(minor) > (trial % 2 ? 1e-2 : 1e-10))
      CHECK(tsi_exact_det4(rows) == ((minor > 0.0) == up ? 1 : -1));
  }
  double tiny[4] = {1e-90, 0.0, 0.0, 0.0}, one[4] = {0.0, 1.0, 0.0, 0.0};
  double two[4] = {0.0, 0.0, 1.0, 0.0}, three[4] = {0.0, 0.0, 0.0, 1.0};
  const double *rows[4] = {tiny, one, two, three};
  CHECK(tsi_exact_det4(rows) == 2);
  tiny[0] = -1.0;
  CHECK(tsi_exact_det4(rows) == -1);
  tiny[0] = (double)NAN;
  CHECK(tsi_exact_det4(rows) == 2);
}

/* ---- declared errors
 * ------------------------------------------------------------------------------ */

/* Homogeneous points of the identity moved by t * shift. */
static void moved(int q, double t, const double *shift, const double *weight, double *points) {
  for (int k = 0, row = 0; k <= q; k++)
    for (int j = 0; j <= q; j++)
      for (int i = 0; i <= q; i++, row++) {
        const int index[3] = {i, j, k};
        for (int c = 0; c < 3; c++)
          points[4 * row + c] = weight[row] * ((double)index[c] / q + t * shift[3 * row + c] / q);
        points[4 * row + 3] = weight[row];
      }
}

/* The largest t in [0, 4] found positive by bisection is put into *low, the next into *high. */
static void find_flip(tsi_certifier *c, tsi_certify_task *task, int q, const double *shift,
                      const double *weight, double *points, double *low, double *high) {
  tsi_certify_outcome outcome;
  *low = 0.0;
  *high = 4.0;
  for (int step = 0; step < 40; step++) {
    double t = 0.5 * (*low + *high);
    moved(q, t, shift, weight, points);
    tsi_certify_run(c, task, &outcome);
    if (outcome.verdict == TSOLID_POSITIVE)
      *low = t;
    else if (outcome.verdict == TSOLID_NOT_POSITIVE)
      *high = t;
    else
      break;
  }
}

/* Points off by up to e from a non-positive element, declared so, are never positive; points of a
 * good element still are. form 0: W = 1, 1: rational, 2: weights off by e taken for constant. */
static void test_declared_errors(tsolid_context *context, int form, double e) {
  enum { Q = 3, N = (Q + 1) * (Q + 1) * (Q + 1) };
  double points[4 * N], copy[4 * N], shift[3 * N], weight[N];
  const int degree[3] = {Q, Q, Q};
  tsi_arena arena = tsi_arena_create(context);
  tsi_certify_size size = {0, 0, 0};
  tsi_certify_size_include(&size, degree);
  tsi_certifier *c = tsi_certifier_create(&arena, &size, 24);
  if (!CHECK(c != NULL))
    return;
  int flips = 0;
  for (int trial = 0; trial < 6; trial++) {
    for (int k = 0; k < 3 * N; k++)
      shift[k] = uniform();
    for (int k = 0; k < N; k++)
      weight[k] = form == 0 ? 1.0 : form == 1 ? 1.0 + 0.1 * uniform() : 1.0 + e * uniform();
    tsi_certify_task exact = {{Q, Q, Q}, points, {0.0}, form == 0, 0, 24};
    double low, high;
    find_flip(c, &exact, Q, shift, weight, points, &low, &high);
    tsi_certify_task task = {{Q, Q, Q}, copy, {e, e, e, e}, form != 1, 0, 24};
    for (int d = 0; form == 2 && d < 3; d++)
      task.error[d] = 4.0 * e; /* |x| < 3 times the weights' error */
    tsi_certify_outcome outcome;
    for (int sample = 0; sample < 6; sample++) {
      moved(Q, high, shift, weight, points);
      for (int k = 0; k < 4 * N; k++)
        copy[k] = points[k] + (k % 4 < 3 || form == 1 ? e * uniform() : 0.0);
      tsi_certify_run(c, &task, &outcome);
      CHECK(outcome.verdict != TSOLID_POSITIVE);
      /* without the declaration some of them are */
      memset(task.error, 0, sizeof task.error);
      tsi_certify_run(c, &task, &outcome);
      flips += outcome.verdict == TSOLID_POSITIVE;
      for (int d = 0; d < 4; d++)
        task.error[d] = form == 2 && d < 3 ? 4.0 * e : e;
    }
    moved(Q, 0.2 * low, shift, weight, copy);
    tsi_certify_run(c, &task, &outcome);
    CHECK(outcome.verdict == TSOLID_POSITIVE);
  }
  CHECK(flips > 0);
  tsi_arena_free(&arena);
}

/* ---- solids
 * ---------------------------------------------------------------------------------------- */

/* A solid with the same space whose control point `k` is moved by `by` along axis 0. */
static tsolid_solid *with_moved(tsolid_context *context, const tsolid_solid *solid, int k,
                                double by) {
  const tsolid_space *space = tsolid_solid_space(solid);
  tsolid_space_view view;
  tsolid_space_get(space, &view);
  size_t n = 4 * (size_t)view.n_functions;
  double *control = malloc(n * sizeof *control);
  tsolid_solid *result = NULL;
  if (control) {
    memcpy(control, tsolid_solid_control(solid), n * sizeof *control);
    control[4 * (size_t)k] += by;
    CHECK(tsolid_solid_from_control(context, space, control, &result) == TSOLID_OK);
  }
  free(control);
  return result;
}

static double jacobian_at(tsolid_context *context, const tsolid_solid *solid, int element,
                          const double u[3]) {
  double x[12];
  int block = solid->space->element[element].block;
  CHECK(tsolid_solid_evaluate(context, solid, block, u, 1, x) == TSOLID_OK);
  return tsi_det3(x + 3, x + 6, x + 9);
}

/* Every verdict against that on the element's own net, and counts against verdicts. */
static void check_elements(tsolid_context *context, const tsolid_solid *solid,
                           const tsolid_certificate *whole, const int *verdict) {
  int count[3] = {0, 0, 0};
  for (int e = 0; e < whole->n_elements; e++) {
    static double points[4 * PART_MAX_POINTS];
    tsolid_certificate one;
    const int *degree = solid->space->element[e].degree;
    CHECK(tsolid_solid_bezier(context, solid, e, points) == TSOLID_OK);
    CHECK(tsolid_certify_element(context, degree, points, NULL, &one) == TSOLID_OK);
    if (whole->n_singular == 0)
      CHECK((int)one.verdict == verdict[e]);
    count[verdict[e]]++;
  }
  CHECK(count[TSOLID_POSITIVE] == whole->n_positive);
  CHECK(count[TSOLID_NOT_POSITIVE] == whole->n_not_positive);
  CHECK(count[TSOLID_UNDECIDED] == whole->n_undecided);
}

static void test_good_and_folded_solid(tsolid_context *context, double offset) {
  static int verdict[100000];
  part_net net;
  part_identity(&net, 3, 3, 3);
  for (int k = 0; k < 64; k++)
    for (int c = 0; c < 3; c++)
      net.point[k][c] += 0.03 * uniform() + offset;
  tsolid_solid *solid = part_solid(context, &net);
  tsolid_certificate good, bad;
  if (!CHECK(solid != NULL))
    return;
  CHECK(tsolid_certify(context, solid, NULL, &good, verdict) == TSOLID_OK);
  CHECK(good.verdict == TSOLID_POSITIVE && good.element == -1 && good.n_singular == 0);
  CHECK(good.smallest_bound > 0.0 && good.n_positive == good.n_elements);
  check_elements(context, solid, &good, verdict);
  /* its function carries points of the solid out of the boundary, which stays: a fold */
  tsolid_solid *folded = with_moved(context, solid, 0, 10.0);
  if (CHECK(folded != NULL)) {
    CHECK(tsolid_certify(context, folded, NULL, &bad, verdict) == TSOLID_OK);
    CHECK(bad.verdict == TSOLID_NOT_POSITIVE && bad.n_not_positive > 0);
    CHECK(bad.element >= 0 && verdict[bad.element >= 0 ? bad.element : 0] == TSOLID_NOT_POSITIVE);
    if (bad.element >= 0)
      CHECK(jacobian_at(context, folded, bad.element, bad.u) <= 1e-12);
    check_elements(context, folded, &bad, verdict);
    int n = tsolid_context_n_findings(context);
    const tsolid_finding *last = tsolid_context_finding(context, n - 1);
    CHECK(n > 0 && last->entity == TSOLID_ENTITY_ELEMENT && last->index[0] == bad.element);
  }
  tsolid_solid_free(folded);
  tsolid_solid_free(solid);
}

/* The caps' four corners are singular by the input, and by nothing else. */
static void test_singular_corners(tsolid_context *context) {
  part_net net;
  tsolid_certificate certificate;
  static int verdict[100000];
  part_cylinder(&net);
  tsolid_solid *solid = part_solid(context, &net);
  if (!CHECK(solid != NULL))
    return;
  tsolid_context_clear(context);
  CHECK(tsolid_certify(context, solid, NULL, &certificate, verdict) == TSOLID_OK);
  CHECK(certificate.verdict == TSOLID_POSITIVE && certificate.n_singular == 8);
  CHECK(certificate.smallest_bound == 0.0);
  int named = 0;
  for (int i = 0; i < tsolid_context_n_findings(context); i++)
    named += tsolid_context_finding(context, i)->entity == TSOLID_ENTITY_CORNER;
  CHECK(named == 8);
  for (int i = 0; i < certificate.n_singular; i++) {
    CHECK_NEAR(fabs(certificate.singular[i][0]), sqrt(0.5), 1e-15);
    CHECK_NEAR(fabs(certificate.singular[i][2]), 1.0, 1e-15);
  }
  /* without the exemption their elements cannot be proved */
  int open = 0;
  for (int e = 0; e < certificate.n_elements; e++) {
    double points[4 * PART_MAX_POINTS];
    tsolid_certificate one;
    tsolid_certificate_options options = {6};
    CHECK(tsolid_solid_bezier(context, solid, e, points) == TSOLID_OK);
    CHECK(tsolid_certify_element(context, solid->space->element[e].degree, points, &options,
                                 &one) == TSOLID_OK);
    open += one.verdict != TSOLID_POSITIVE;
  }
  CHECK(open > 0 && open <= 8);
  tsolid_solid_free(solid);
}

/* Only a corner is exempt, not an edge: a lens, where two sides meet at angle zero. */
static void test_cusped_edge_is_not_exempt(tsolid_context *context) {
  part_net net;
  tsolid_certificate certificate;
  part_identity(&net, 3, 3, 3);
  for (int k = 0; k < 64; k++)
    if (k % 4 == 1 && k / 4 % 4 == 0) /* side y = 0 leaves the edge x = y = 0 along side x = 0 */
      net.point[k][0] = 0.0, net.point[k][1] = 1.0 / 3.0;
  tsolid_solid *solid = part_solid(context, &net);
  if (!CHECK(solid != NULL))
    return;
  CHECK(tsolid_certify(context, solid, NULL, &certificate, NULL) == TSOLID_OK);
  CHECK(certificate.verdict != TSOLID_POSITIVE);
  tsolid_solid_free(solid);
}

static int cancel(void *data, const char *stage, double fraction) {
  (void)stage;
  (void)fraction;
  return *(int *)data;
}

static void test_threads_cancel_arguments(void) {
  part_net net;
  tsolid_certificate one[2];
  static int verdict[2][100000];
  int asked = 0;
  part_identity(&net, 4, 2, 3);
  for (int t = 0; t < 2; t++) {
    tsolid_context *context;
    tsolid_context_options options = {
        .n_threads = 1 + 2 * t, .progress = cancel, .progress_data = &asked};
    asked = 0;
    CHECK(tsolid_context_create(&options, &context) == TSOLID_OK);
    tsolid_solid *solid = part_solid(context, &net);
    tsolid_solid *folded = solid ? with_moved(context, solid, 3, 0.4) : NULL;
    if (!CHECK(folded != NULL))
      return;
    memset(&one[t], 0, sizeof one[t]);
    CHECK(tsolid_certify(context, folded, NULL, &one[t], verdict[t]) == TSOLID_OK);
    tsolid_certificate untouched = one[t];
    asked = 1;
    CHECK(tsolid_certify(context, folded, NULL, &untouched, NULL) == TSOLID_ERROR_CANCELLED);
    CHECK(memcmp(&untouched, &one[t], sizeof untouched) == 0);
    asked = 0;
    CHECK(tsolid_certify(context, NULL, NULL, &untouched, NULL) == TSOLID_ERROR_ARGUMENT);
    CHECK(tsolid_certify(context, folded, NULL, NULL, NULL) == TSOLID_ERROR_ARGUMENT);
    tsolid_certificate_options deep = {65};
    CHECK(tsolid_certify(context, folded, &deep, &untouched, NULL) == TSOLID_ERROR_ARGUMENT);
    tsolid_solid_free(folded);
    tsolid_solid_free(solid);
    tsolid_context_free(context);
  }
  CHECK(memcmp(&one[0], &one[1], sizeof one[0]) == 0);
  CHECK(memcmp(verdict[0], verdict[1], (size_t)one[0].n_elements * sizeof(int)) == 0);
}

int main(void) {
  tsolid_context *context;
  const tsolid_context_options options = {.n_threads = 1};
  if (tsolid_context_create(&options, &context) != TSOLID_OK)
    return 1;
  test_product_against_long_double(4, 3);
  test_product_against_long_double(9, 5);
  test_product_values_and_bisection();
  test_exact_determinant();
  for (int form = 0; form < 3; form++) {
    test_declared_errors(context, form, 1e-6);
    test_declared_errors(context, form, 1e-10);
  }
  test_good_and_folded_solid(context, 0.0);
  test_good_and_folded_solid(context, 1e6);
  test_singular_corners(context);
  test_cusped_edge_is_not_exempt(context);
  test_threads_cancel_arguments();
  tsolid_context_free(context);
  return check_done();
}
