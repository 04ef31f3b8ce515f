/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The Jacobian certificate of one rational Bezier element.
 *
 * Homogeneous point X = (A, W), x = A / W, subscripts are derivatives along u[0], u[1], u[2]:
 *
 *     N = -det[X, X_0, X_1, X_2] = W^4 det J,                     W = 1: N = det[A_0, A_1, A_2].
 *
 * W > 0 because all its Bernstein coefficients are, so N and det J have one sign. N is computed as
 * a Bernstein polynomial. With X = (1-t) P + t Q for the nets P, Q of the first and last rows along
 * t = u[d], X ^ X_d = q_d P ^ (Q - P) has degree 2 (q_d - 1) in t; the Laplace expansion by the 2x2
 * minors of (P, Q - P) and (X_e, X_f) gives N with degree 4 q_d - 2 along d and 4 q - 1 along the
 * two others (one more than necessary: coefficients of a raised polynomial bound it as well).
 * Where W is constant the degrees are 3 q - 1. d is the direction of the highest degree, so N stays
 * smallest.
 *
 * N > 0 on the element if every coefficient is above its own error bound. Else the element is
 * bisected along the direction of the largest second differences, until each part is positive, or
 * a corner of a part (there a coefficient is a value) is below minus its error bound, or the depth
 * or the work is used up. The coefficients of N are bisected, not the net: this is cheaper and adds
 * less round-off, since differences of a bisected net lose a bit with each bisection.
 *
 * Round-off. The error model is in bernstein_product.h: a magnitude per coefficient and one delta
 * per polynomial. Here are its leaves. A control point component a_k as given has the absolute
 * error e_k = error[c] (the caller's; zero when the points define the element). Rational elements
 * are first translated by c near their middle, a_k' = fl(a_k - c w_k) with one rounding (fma), so
 * e_k = error[c] + |c| error[3] + u |a_k'|; det[X, X_0, X_1, X_2] is unchanged by the exact
 * translation. Where W is constant only differences of points as given enter: no translation. The
 * computed leaf coefficient v, of P or of a derivative, satisfies
 *
 *     |v - V| <= e + gamma_5 |v| <= delta m,   m = |v| + e / delta >= |V|,   8 u <= delta <= 1/2
 *
 * (five roundings: difference, degree, two binomials and their product; e = q (e_k + e_k+1) for a
 * derivative). Products meet one leaf of each direction, so the leaves of a direction share one
 * delta = 8 u + 2 max e / max |v|: an error that is small beside the largest of them leaves the
 * magnitudes nearly as they are, and directions of very different lengths do not disturb each
 * other. All is scaled by powers of two to at most one first, so nothing overflows, and what
 * may underflow in the products is below UNDERFLOW_ERROR, which is part of every error bound.
 *
 * Source: the bound by Bernstein coefficients and its refinement by subdivision are classical (e.g.
 * A. Johnen, J.-F. Remacle, C. Geuzaine, Geometrical validity of curvilinear finite elements,
 * 2013); rational numerator, error bounds and singular corners are our own.
 * tests/test_certify_exact.py compares with exact rational arithmetic. */
#include "certify.h"

#include "bernstein.h"
#include "bernstein_product.h"
#include "exact.h"

static const double DELTA = 8.0 * TSI_ROUND_OFF;
static const double UNDERFLOW_ERROR = 1e-250;

/* Coefficient operations of the bisections of one element (about a quarter of a second), or so many
 * bisections, if that is more. */
static const double MAX_WORK = 1e8;
static const double MIN_BISECTIONS = 300.0;
/* Multiplications of pairs for N itself: rational elements up to 15 x 15 x 15 or 25 x 25 x 6. */
static const double MAX_PRODUCTS = 1e10;

enum { N_MINORS = 6, N_LEAVES = 16 };

/* A part of the element: N on it and, for the bound only, W. */
typedef struct part {
  tsi_product jacobian;
  double *weight;
  double low[3], width[3];
  int depth;
  double least; /* smallest coefficient less its error bound, known corners left out */
  int has_known;
} part;

struct tsi_certifier {
  double *leaf[N_LEAVES];
  double *minor[2];
  double *net;       /* translated and scaled copy of the points */
  part *stack;       /* max_depth + 2 parts */
  int degree[3];     /* of the element at work */
  int known_corners; /* of the element, where N >= 0 is known although within its error bound */
};

/* ---- workspace --------------------------------------------------------------------------------
 */

void tsi_certify_size_include(tsi_certify_size *size, const int degree[3]) {
  size_t net = 1, minor = 1, jacobian = 1;
  for (int i = 0; i < 3; i++) {
    net *= (size_t)degree[i] + 1;
    minor *= 2 * (size_t)degree[i] + 1;
    jacobian *= 4 * (size_t)degree[i];
  }
  size->net = net > size->net ? net : size->net;
  size->minor = minor > size->minor ? minor : size->minor;
  size->jacobian = jacobian > size->jacobian ? jacobian : size->jacobian;
}

tsi_certifier *tsi_certifier_create(tsi_arena *arena, const tsi_certify_size *size, int max_depth) {
  tsi_certifier *c = tsi_arena_new(arena, 1, sizeof *c);
  if (!c)
    return NULL;
  c->net = tsi_arena_new(arena, size->net, 4 * sizeof *c->net);
  c->stack = tsi_arena_new(arena, (size_t)max_depth + 2, sizeof *c->stack);
  int ok = c->net && c->stack;
  for (int i = 0; ok && i < N_LEAVES; i++)
    ok = (c->leaf[i] = tsi_arena_new(arena, size->net, 2 * sizeof *c->leaf[i])) != NULL;
  for (int i = 0; ok && i < 2; i++)
    ok = (c->minor[i] = tsi_arena_new(arena, size->minor, 2 * sizeof *c->minor[i])) != NULL;
  for (int i = 0; ok && i < max_depth + 2; i++) {
    c->stack[i].jacobian.pair = tsi_arena_new(arena, size->jacobian, 2 * sizeof(double));
    c->stack[i].weight = tsi_arena_new(arena, size->net, sizeof(double));
    ok = c->stack[i].jacobian.pair && c->stack[i].weight;
  }
  return ok ? c : NULL;
}

/* ---- the net -----------------------------------------------------------------------------------
 */

static size_t net_size(const int degree[3]) {
  return (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1) * (size_t)(degree[2] + 1);
}

static size_t net_corner(const int degree[3], int corner) {
  size_t i = corner & 1 ? (size_t)degree[0] : 0, j = corner & 2 ? (size_t)degree[1] : 0;
  size_t k = corner & 4 ? (size_t)degree[2] : 0, n0 = (size_t)degree[0] + 1;
  return i + n0 * (j + ((size_t)degree[1] + 1) * k);
}

void tsi_net_point(const int degree[3], const double *points, const double u[3], double point[3]) {
  double value[3][TSI_MAX_ORDER], sum[4] = {0.0, 0.0, 0.0, 0.0};
  for (int i = 0; i < 3; i++)
    tsi_bernstein(degree[i], u[i], value[i]);
  for (int k = 0; k <= degree[2]; k++)
    for (int j = 0; j <= degree[1]; j++)
      for (int i = 0; i <= degree[0]; i++, points += 4)
        for (int c = 0; c < 4; c++)
          sum[c] += value[0][i] * value[1][j] * value[2][k] * points[c];
  for (int c = 0; c < 3; c++)
    point[c] = sum[c] / sum[3];
}

/* Errors of the components of a control point of the working net: e_k = absolute + relative |a_k|.
 */
typedef struct leaf_error {
  double absolute[4], relative[4];
} leaf_error;

/* Fills the working net: translated (rational elements), scaled by powers of two. */
static leaf_error prepare_net(tsi_certifier *c, const tsi_certify_task *task) {
  leaf_error error;
  size_t n = net_size(task->degree);
  double centre[3] = {0.0, 0.0, 0.0}, largest = 0.0, heaviest = 0.0;
  const double middle[3] = {0.5, 0.5, 0.5};
  if (!task->constant_weight)
    tsi_net_point(task->degree, task->points, middle, centre);
  for (int d = 0; d < 3; d++)
    if (!isfinite(centre[d]))
      centre[d] = 0.0;
  for (size_t k = 0; k < n; k++) {
    const double *from = task->points + 4 * k;
    double *to = c->net + 4 * k;
    for (int d = 0; d < 3; d++) {
      to[d] = centre[d] == 0.0 ? from[d] : fma(-centre[d], from[3], from[d]);
      largest = fmax(largest, fabs(to[d]));
    }
    to[3] = from[3];
    heaviest = fmax(heaviest, from[3]);
  }
  double scale[4];
  scale[0] = scale[1] = scale[2] = tsi_unit_scale(largest);
  scale[3] = tsi_unit_scale(heaviest);
  for (size_t k = 0; k < 4 * n; k++)
    c->net[k] *= scale[k % 4];
  for (int d = 0; d < 4; d++) {
    double moved = d < 3 ? fabs(centre[d]) * task->error[3] : 0.0;
    error.absolute[d] = (task->error[d] + moved) * scale[d] * (1.0 + 0x1p-50);
    error.relative[d] = d < 3 && centre[d] != 0.0 ? TSI_ROUND_OFF : 0.0;
  }
  return error;
}

/* ---- N in Bernstein form -----------------------------------------------------------------------
 */

/* Value and error of one coefficient of a leaf at row k of the working net: of the derivative along
 * `axis`, or with derivative = 0 the net itself. */
static inline double leaf_value(const tsi_certifier *c, const leaf_error *error, int component,
                                int axis, int derivative, size_t k, double *e) {
  const int *q = c->degree;
  size_t stride[3] = {1, (size_t)q[0] + 1, ((size_t)q[0] + 1) * ((size_t)q[1] + 1)};
  double a = c->net[4 * k + (size_t)component];
  double e0 = error->absolute[component], e1 = error->relative[component];
  *e = e0 + e1 * fabs(a);
  if (!derivative)
    return a;
  double b = c->net[4 * (k + stride[axis]) + (size_t)component];
  *e = q[axis] * (*e + e0 + e1 * fabs(b));
  return q[axis] * (b - a);
}

/* The leaves of all components of X (derivative = 0: first rows along `axis`) or X_axis, scaled,
 * with one delta. */
static void make_leaves(const tsi_certifier *c, const leaf_error *error, int n_components, int axis,
                        int derivative, double *const *pair, tsi_product *leaf) {
  const int *q = c->degree;
  double largest = 0.0, largest_error = 0.0, e;
  const int n[3] = {q[0] + (axis != 0), q[1] + (axis != 1), q[2] + (axis != 2)};
  for (int x = 0; x < n_components; x++) {
    double *to = pair[x];
    for (int k = 0; k < n[2]; k++)
      for (int j = 0; j < n[1]; j++)
        for (int i = 0; i < n[0]; i++, to += 2) {
          size_t row = (size_t)(i + (q[0] + 1) * (j + (q[1] + 1) * k));
          to[0] = leaf_value(c, error, x, axis, derivative, row, &e);
          to[1] = e;
          largest = fmax(largest, fabs(to[0]));
          largest_error = fmax(largest_error, e);
        }
  }
  double delta = DELTA + (largest > 0.0 ? 2.0 * largest_error / largest : 0.0);
  delta = delta < 0.5 ? delta : 0.5;
  for (int x = 0; x < n_components; x++) {
    double *to = pair[x];
    for (int k = 0; k < n[2]; k++)
      for (int j = 0; j < n[1]; j++)
        for (int i = 0; i < n[0]; i++, to += 2) {
          double binomial =
              tsi_binomial(n[0] - 1, i) * tsi_binomial(n[1] - 1, j) * tsi_binomial(n[2] - 1, k);
          to[1] = (fabs(to[0]) + to[1] / delta) * binomial;
          to[0] *= binomial;
        }
    leaf[x] = (tsi_product){{n[0], n[1], n[2]}, delta, pair[x]};
  }
}

/* minor = a b' - a' b. */
static tsi_product make_minor(const tsi_product *a, const tsi_product *a1, const tsi_product *b,
                              const tsi_product *b1, double *pair) {
  tsi_product minor = {{0, 0, 0}, 0.0, pair};
  tsi_product_clear(&minor, a, b1);
  tsi_product_add(&minor, 1.0, a, b1);
  tsi_product_add(&minor, -1.0, a1, b);
  tsi_product_close(&minor, 2, a, b1);
  return minor;
}

/* N = det[A_0, A_1, A_2], expanded along A_0. */
static void jacobian_of_polynomial(tsi_certifier *c, const leaf_error *error, tsi_product *n) {
  tsi_product d[3][3], minor;
  for (int i = 0; i < 3; i++)
    make_leaves(c, error, 3, i, 1, c->leaf + 3 * i, d[i]);
  for (int x = 0; x < 3; x++) {
    int y = (x + 1) % 3, z = (x + 2) % 3;
    minor = make_minor(&d[1][y], &d[1][z], &d[2][y], &d[2][z], c->minor[0]);
    if (x == 0)
      tsi_product_clear(n, &d[0][x], &minor);
    tsi_product_add(n, 1.0, &d[0][x], &minor);
  }
  tsi_product_close(n, 3, &d[0][0], &minor);
}

static int highest_direction(const int degree[3]) {
  int d = 0;
  for (int i = 1; i < 3; i++)
    if (degree[i] > degree[d])
      d = i;
  return d;
}

/* N = -det[X, X_0, X_1, X_2] by 2x2 minors; (d, e, f) is a cyclic, so even, permutation. */
static void jacobian_of_rational(tsi_certifier *c, const leaf_error *error, tsi_product *n) {
  /* components of the first minor, of its complement, sign in the Laplace expansion of -det */
  static const int row[N_MINORS][5] = {{0, 1, 2, 3, -1}, {0, 2, 1, 3, 1}, {0, 3, 1, 2, -1},
                                       {1, 2, 0, 3, -1}, {1, 3, 0, 2, 1}, {2, 3, 0, 1, -1}};
  int d = highest_direction(c->degree);
  int e = (d + 1) % 3, f = (d + 2) % 3;
  tsi_product first[4], step[4], xe[4], xf[4];
  make_leaves(c, error, 4, d, 0, c->leaf, first);
  make_leaves(c, error, 4, d, 1, c->leaf + 4, step);
  make_leaves(c, error, 4, e, 1, c->leaf + 8, xe);
  make_leaves(c, error, 4, f, 1, c->leaf + 12, xf);
  for (int m = 0; m < N_MINORS; m++) {
    int i = row[m][0], j = row[m][1], k = row[m][2], l = row[m][3];
    tsi_product p = make_minor(&first[i], &first[j], &step[i], &step[j], c->minor[0]);
    tsi_product r = make_minor(&xe[k], &xe[l], &xf[k], &xf[l], c->minor[1]);
    if (m == 0)
      tsi_product_clear(n, &p, &r);
    tsi_product_add(n, (double)row[m][4], &p, &r);
    if (m == N_MINORS - 1)
      tsi_product_close(n, N_MINORS, &p, &r);
  }
}

/* Multiplications of the last step of the above, which outweighs all before. */
static double products_needed(const tsi_certify_task *task) {
  double work = task->constant_weight ? 3.0 : 6.0;
  for (int i = 0; i < 3; i++) {
    double q = (double)task->degree[i];
    work *= task->constant_weight ? (q + 1.0) * (2.0 * q + 1.0) : (2.0 * q + 1.0) * (2.0 * q + 1.0);
  }
  return work;
}

/* ---- corners ------------------------------------------------------------------------------------
 */

/* The exact sign of N at a corner of the element, for points without error; 2: not known. There
 * N = -q_0 q_1 q_2 det[X, Y_0, Y_1, Y_2] for the rows Y_i next to it, times -1 for every direction
 * in which it is at the upper end. */
static int exact_corner_sign(const tsi_certify_task *task, int corner) {
  size_t stride[3] = {1, (size_t)task->degree[0] + 1,
                      ((size_t)task->degree[0] + 1) * ((size_t)task->degree[1] + 1)};
  size_t at = net_corner(task->degree, corner);
  const double *rows[4] = {task->points + 4 * at, NULL, NULL, NULL};
  int sign = -1;
  for (int i = 0; i < 3; i++) {
    int upper = corner >> i & 1;
    rows[1 + i] = task->points + 4 * (upper ? at - stride[i] : at + stride[i]);
    sign = upper ? -sign : sign;
  }
  int exact = tsi_exact_det4(rows);
  return exact == 2 ? 2 : sign * exact;
}

/* Index of corner `corner` of a part's coefficients. */
static size_t coefficient_corner(const tsi_product *n, int corner) {
  const int degree[3] = {n->n[0] - 1, n->n[1] - 1, n->n[2] - 1};
  return net_corner(degree, corner);
}

static double error_bound(const tsi_product *n, size_t k) {
  return n->delta * TSI_MAGNITUDE_SLACK * n->pair[2 * k + 1] + UNDERFLOW_ERROR;
}

/* The corners of the whole element that the error bound leaves open: known by the input's own
 * geometry, or by exact arithmetic. Returns a corner where N <= 0 is exact, or -1. */
static int settle_corners(tsi_certifier *c, const tsi_certify_task *task, const tsi_product *n) {
  int exact = 1;
  for (int i = 0; i < 4; i++)
    exact = exact && task->error[i] == 0.0;
  c->known_corners = 0;
  for (int corner = 0; corner < 8; corner++) {
    size_t k = coefficient_corner(n, corner);
    if (!(fabs(n->pair[2 * k]) <= error_bound(n, k)))
      continue;
    if (task->singular >> corner & 1) {
      c->known_corners |= 1 << corner;
    } else if (exact) {
      int sign = exact_corner_sign(task, corner);
      if (sign <= 0)
        return corner;
      c->known_corners |= sign == 1 ? 1 << corner : 0;
    }
  }
  return -1;
}

/* The corner of the element that is corner `corner` of this part too, if its N is settled. */
static int is_known_corner(const tsi_certifier *c, const part *p, int corner) {
  for (int i = 0; i < 3; i++)
    if (corner >> i & 1 ? p->low[i] + p->width[i] != 1.0 : p->low[i] != 0.0)
      return 0;
  return c->known_corners >> corner & 1;
}

/* ---- subdivision --------------------------------------------------------------------------------
 */

/* Smallest coefficient less its error bound; -inf where anything is not a number. */
static double least_coefficient(const tsi_product *n, int n_exempt, const size_t *exempt) {
  size_t size = tsi_product_size(n);
  double least = INFINITY;
  for (size_t k = 0; k < size; k++) {
    double low = n->pair[2 * k] - error_bound(n, k);
    if (low >= least)
      continue;
    int skip = 0;
    for (int i = 0; i < n_exempt; i++)
      skip |= exempt[i] == k;
    if (isnan(low))
      return -INFINITY;
    if (!skip)
      least = low;
  }
  return least;
}

/* Verdict on one part; `where` is the corner when not positive. */
static tsolid_verdict judge(const tsi_certifier *c, part *p, int *where) {
  const tsi_product *n = &p->jacobian;
  size_t exempt[8];
  int n_exempt = 0, bad = -1;
  for (int corner = 0; corner < 8; corner++) {
    size_t k = coefficient_corner(n, corner);
    if (is_known_corner(c, p, corner))
      exempt[n_exempt++] = k;
    else if (n->pair[2 * k] + error_bound(n, k) <= 0.0 && bad < 0)
      bad = corner;
  }
  p->has_known = n_exempt > 0;
  p->least = least_coefficient(n, n_exempt, exempt);
  if (bad >= 0) {
    *where = bad;
    return TSOLID_NOT_POSITIVE;
  }
  return p->least > 0.0 ? TSOLID_POSITIVE : TSOLID_UNDECIDED;
}

/* Largest |second difference| along a direction, times n (n - 1): how far coefficients may be from
 * values. */
static double variation(const tsi_product *n, int axis) {
  size_t stride = 1, size = tsi_product_size(n);
  for (int i = 0; i < axis; i++)
    stride *= (size_t)n->n[i];
  size_t count = (size_t)n->n[axis];
  double largest = 0.0;
  for (size_t k = 0; k < size; k++) {
    size_t i = k / stride % count;
    if (i + 2 >= count)
      continue;
    const double *v = n->pair + 2 * k;
    double second = fabs((v[0] - v[2 * stride]) - (v[2 * stride] - v[4 * stride]));
    largest = second > largest ? second : largest;
  }
  return largest * (double)(count - 1) * (double)(count - 2);
}

static int split_direction(const part *p) {
  int best = 0;
  double largest = -1.0;
  for (int i = 0; i < 3; i++) {
    double v = variation(&p->jacobian, i);
    if (v > largest) {
      largest = v;
      best = i;
    }
  }
  return best;
}

static void bisect(const tsi_certifier *c, part *p, part *upper, int axis) {
  const int n[3] = {c->degree[0] + 1, c->degree[1] + 1, c->degree[2] + 1};
  tsi_product_bisect(&p->jacobian, &upper->jacobian, axis);
  tsi_net_bisect(n, 1, p->weight, upper->weight, axis);
  p->width[axis] *= 0.5;
  p->depth++;
  memcpy(upper->low, p->low, sizeof p->low);
  memcpy(upper->width, p->width, sizeof p->width);
  upper->low[axis] += p->width[axis];
  upper->depth = p->depth;
}

/* A lower bound of N / W^4 (or of N where W is constant one) on a part, from its least N. */
static double part_bound(const tsi_certifier *c, const tsi_certify_task *task, const part *p) {
  double least = p->has_known && p->least > 0.0 ? 0.0 : p->least;
  double low = INFINITY, high = 0.0;
  for (size_t k = 0; k < net_size(c->degree); k++) {
    low = fmin(low, p->weight[k]);
    high = fmax(high, p->weight[k]);
  }
  double w = least > 0.0 ? high : low;
  double power = task->constant_weight ? w * w * w : w * w * w * w;
  return least / power * (least > 0.0 ? 1.0 - 1e-12 : 1.0 + 1e-12);
}

/* Product over the directions of the mean length of the four edges' control polygons. */
static double edge_product(const tsi_certifier *c) {
  const int *q = c->degree;
  size_t stride[3] = {1, (size_t)q[0] + 1, ((size_t)q[0] + 1) * ((size_t)q[1] + 1)};
  double product = 1.0;
  for (int axis = 0; axis < 3; axis++) {
    double length = 0.0;
    for (int corner = 0; corner < 8; corner++) {
      if (corner >> axis & 1)
        continue;
      const double *a = c->net + 4 * net_corner(q, corner);
      for (int k = 0; k < q[axis]; k++, a += 4 * stride[axis]) {
        const double *b = a + 4 * stride[axis];
        double d[3];
        for (int x = 0; x < 3; x++)
          d[x] = b[x] / b[3] - a[x] / a[3];
        length += sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      }
    }
    product *= 0.25 * length;
  }
  return product;
}

/* Where the verdict was taken: a corner of the part, or its middle (corner = -1). */
static void locate(const part *p, int corner, double u[3]) {
  for (int i = 0; i < 3; i++) {
    double t = corner < 0 ? 0.5 : (double)(corner >> i & 1);
    u[i] = p->low[i] + t * p->width[i];
  }
}

static double longest(const tsi_product *n) {
  int most = n->n[0] > n->n[1] ? n->n[0] : n->n[1];
  return (double)(n->n[2] > most ? n->n[2] : most);
}

/* The stack holds undecided parts, the least coefficient on top when a part is split: a point of
 * non-positive N is found soon. At most one part per depth waits, so max_depth + 2 are room. */
static void subdivide(tsi_certifier *c, const tsi_certify_task *task,
                      tsi_certify_outcome *outcome) {
  int n_waiting = 1, where = -1;
  double work = 0.0, worst = INFINITY, bound = INFINITY, root = part_bound(c, task, c->stack);
  double one = (double)tsi_product_size(&c->stack->jacobian) * longest(&c->stack->jacobian);
  double max_work = fmax(MAX_WORK, MIN_BISECTIONS * one);
  while (n_waiting > 0) {
    part *p = &c->stack[n_waiting - 1], *q = p + 1;
    int axis = split_direction(p);
    work += (double)tsi_product_size(&p->jacobian) * (double)p->jacobian.n[axis];
    if (p->depth >= task->max_depth || work > max_work) {
      outcome->verdict = TSOLID_UNDECIDED;
      bound = fmin(bound, part_bound(c, task, p));
      if (p->least < worst) {
        worst = p->least;
        locate(p, -1, outcome->u);
      }
      n_waiting--;
      continue;
    }
    bisect(c, p, q, axis);
    outcome->depth = p->depth > outcome->depth ? p->depth : outcome->depth;
    tsolid_verdict verdict[2];
    for (int i = 0; i < 2; i++) {
      verdict[i] = judge(c, p + i, &where);
      if (verdict[i] == TSOLID_NOT_POSITIVE) {
        outcome->verdict = TSOLID_NOT_POSITIVE;
        outcome->bound = root;
        locate(p + i, where, outcome->u);
        return;
      }
      if (verdict[i] == TSOLID_POSITIVE)
        bound = fmin(bound, part_bound(c, task, p + i));
    }
    int keep_low = verdict[0] == TSOLID_UNDECIDED, keep_high = verdict[1] == TSOLID_UNDECIDED;
    if (keep_high && (!keep_low || p->least < q->least)) {
      part swap = *p;
      *p = *q;
      *q = swap;
    }
    n_waiting += keep_low + keep_high - 1;
  }
  outcome->bound = bound;
}

/* ---- driver
 * -------------------------------------------------------------------------------------- */

static void start_root(tsi_certifier *c, const tsi_certify_task *task) {
  part *root = &c->stack[0];
  leaf_error error = prepare_net(c, task);
  if (task->constant_weight)
    jacobian_of_polynomial(c, &error, &root->jacobian);
  else
    jacobian_of_rational(c, &error, &root->jacobian);
  tsi_product_unscale(&root->jacobian);
  for (size_t k = 0; k < net_size(task->degree); k++)
    root->weight[k] = c->net[4 * k + 3];
  for (int i = 0; i < 3; i++) {
    root->low[i] = 0.0;
    root->width[i] = 1.0;
  }
  root->depth = 0;
}

/* Index of the first row whose weight is not surely positive, or the number of rows. */
static size_t find_bad_weight(const tsi_certify_task *task) {
  size_t k = 0, n = net_size(task->degree);
  while (k < n && task->points[4 * k + 3] > task->error[3])
    k++;
  return k;
}

/* The Greville point of row k. */
static void greville(const int degree[3], size_t k, double u[3]) {
  for (int i = 0; i < 3; i++) {
    size_t n = (size_t)degree[i] + 1;
    u[i] = (double)(k % n) / (double)degree[i];
    k /= n;
  }
}

void tsi_certify_run(tsi_certifier *c, const tsi_certify_task *task, tsi_certify_outcome *outcome) {
  static const tsi_certify_outcome unknown = {TSOLID_UNDECIDED, 0, {0.5, 0.5, 0.5}, -TSI_NO_BOUND};
  int where = -1;
  *outcome = unknown;
  memcpy(c->degree, task->degree, sizeof c->degree);
  size_t bad = find_bad_weight(task);
  if (bad < net_size(task->degree)) {
    outcome->verdict = TSOLID_NOT_POSITIVE;
    greville(task->degree, bad, outcome->u);
    return;
  }
  if (products_needed(task) > MAX_PRODUCTS)
    return;
  start_root(c, task);
  part *root = &c->stack[0];
  int exact_corner = settle_corners(c, task, &root->jacobian);
  outcome->verdict = judge(c, root, &where);
  outcome->bound = part_bound(c, task, root);
  if (exact_corner >= 0) {
    outcome->verdict = TSOLID_NOT_POSITIVE;
    where = exact_corner;
  }
  if (outcome->verdict == TSOLID_NOT_POSITIVE) {
    locate(root, where, outcome->u);
  } else if (outcome->verdict == TSOLID_UNDECIDED) {
    outcome->verdict = TSOLID_POSITIVE;
    subdivide(c, task, outcome);
  }
  double bound = outcome->bound / edge_product(c);
  outcome->bound = bound > -TSI_NO_BOUND && bound < INFINITY ? bound : -TSI_NO_BOUND;
}

/* ---- one element
 * --------------------------------------------------------------------------------- */

static tsolid_status check_element(tsolid_context *context, const int degree[3],
                                   const double *points,
                                   const tsolid_certificate_options *options) {
  for (int i = 0; i < 3; i++)
    if (degree[i] < 1 || degree[i] > TSI_MAX_DEGREE)
      return tsi_fail(context, TSOLID_ERROR_ARGUMENT, "certify", "degree %d is not in 1..%d",
                      degree[i], TSI_MAX_DEGREE);
  if (options && (options->max_depth < 0 || options->max_depth > TSI_CERTIFY_MAX_DEPTH))
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, "certify", "depth %d is not in 0..%d",
                    options->max_depth, TSI_CERTIFY_MAX_DEPTH);
  for (size_t k = 0; k < 4 * net_size(degree); k++)
    if (!isfinite(points[k]))
      return tsi_fail(context, TSOLID_ERROR_INPUT, "certify", "control point %zu is not finite",
                      k / 4);
  return TSOLID_OK;
}

static int has_constant_weight(const int degree[3], const double *points) {
  for (size_t k = 1; k < net_size(degree); k++)
    if (points[4 * k + 3] != points[3])
      return 0;
  return 1;
}

static void fill_certificate(const tsi_certify_task *task, const tsi_certify_outcome *outcome,
                             tsolid_certificate *certificate) {
  memset(certificate, 0, sizeof *certificate);
  certificate->verdict = outcome->verdict;
  certificate->n_elements = 1;
  certificate->n_positive = outcome->verdict == TSOLID_POSITIVE;
  certificate->n_not_positive = outcome->verdict == TSOLID_NOT_POSITIVE;
  certificate->n_undecided = outcome->verdict == TSOLID_UNDECIDED;
  certificate->depth = outcome->depth;
  certificate->smallest_bound = outcome->bound;
  certificate->element = -1;
  if (outcome->verdict == TSOLID_POSITIVE)
    return;
  certificate->element = 0;
  memcpy(certificate->u, outcome->u, sizeof certificate->u);
  tsi_net_point(task->degree, task->points, outcome->u, certificate->point);
}

tsolid_status tsolid_certify_element(tsolid_context *context, const int degree[3],
                                     const double *points,
                                     const tsolid_certificate_options *options,
                                     tsolid_certificate *certificate) {
  if (!context)
    return TSOLID_ERROR_ARGUMENT;
  if (!degree || !points || !certificate)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, "certify", "an argument is NULL");
  tsi_arena arena = tsi_arena_create(context);
  tsolid_status status = check_element(context, degree, points, options);
  if (status != TSOLID_OK)
    goto done;
  tsi_certify_task task = {{degree[0], degree[1], degree[2]}, points, {0.0}, 0, 0, 0};
  task.constant_weight = has_constant_weight(degree, points);
  task.max_depth = options && options->max_depth ? options->max_depth : TSI_CERTIFY_DEPTH;
  tsi_certify_size size = {0, 0, 0};
  tsi_certify_size_include(&size, degree);
  tsi_certifier *certifier = tsi_certifier_create(&arena, &size, task.max_depth);
  if (!certifier) {
    status = tsi_no_memory(context, "certify");
    goto done;
  }
  tsi_certify_outcome outcome;
  tsi_certify_run(certifier, &task, &outcome);
  fill_certificate(&task, &outcome, certificate);
done:
  tsi_arena_free(&arena);
  return status;
}
