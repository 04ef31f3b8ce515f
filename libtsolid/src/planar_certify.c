/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The Jacobian certificate of a rational patch in a plane, Bezier element by Bezier element.
 *
 * Homogeneous point X = (A, W), x = A / W in the plane, subscripts are derivatives along u[0],
 * u[1]:
 *
 *     N = det[X, X_0, X_1] = W^3 det J,                       W constant: N = det[A_0, A_1].
 *
 * As in certify.c, with X = (1-t) P + t Q for the nets P, Q of the first and last rows along t =
 * u[d], X ^ X_d = q_d P ^ (Q - P) has degree 2 (q_d - 1) in t: three 2 x 2 minors, each times a
 * component of the other derivative. N has degree 3 q_d - 2 along d and 3 q_e - 1 along e; where W
 * is constant the degrees are 2 q - 1. It is positive on an element when every Bernstein
 * coefficient is above its own error bound; else the element is bisected along the direction of the
 * larger second differences, until each part is positive, a corner of a part is below minus its
 * error bound, or depth or work is used up.
 *
 * Round-off. The error model of products is that of bernstein_product.h, the leaves are those of
 * certify.c. Here nets come from knot insertion. One step of it, right + a (left - right) with a
 * quotient a of two differences, is off by at most 12 u max|h| (three roundings in a, of which the
 * difference left - right is at most 2 max, and four of its own), and a Bezier point of a direction
 * of degree p depends on at most p (p + 1) steps one after another: p - 1 or less per knot at
 * the p + 1 spans that its ancestors reach. With E the error of the points as given,
 *
 *     e = max w (E + u max|x|) + 12 u (p (p + 1) + q (q + 1)) max |h|.
 *
 * Equal weights stay equal bit for bit; then those have no error.
 *
 * Corners of the patch where the borders are tangent are known: there the coefficient of N is zero
 * by theory, and may be as large as its error bound; all others must be positive.
 *
 * tests/test_coons.c compares with sampling at many points, and with folds about to open. */
#include "bernstein.h"
#include "bernstein_product.h"
#include "bspline.h"
#include "coons.h"

static const double DELTA = 8.0 * TSI_ROUND_OFF;
static const double UNDERFLOW_ERROR = 1e-250;

enum { MAX_DEPTH = 28, N_LEAVES = 9, MIN_BISECTIONS = 300 };

/* Coefficient operations of the bisections of one element, if that is more than the above. */
static const double MAX_WORK = 1e7;

typedef struct part {
  tsi_product n;
  double low[2], width[2], least;
  int depth;
} part;

typedef struct certifier {
  int degree[2], constant_weight;
  double error[3]; /* of the components of Bezier points */
  double *net;     /* of one element: rows of 3 */
  double *leaf[N_LEAVES];
  double *minor;
  part *stack; /* MAX_DEPTH + 2 */
  int known;   /* bits of the element's corners where N = 0 is known */
} certifier;

/* ---- Bezier nets -------------------------------------------------------------------------------
 */

/* The patch's homogeneous net with every knot standing `degree` times; rows of 3. */
typedef struct refined {
  int n[2], n_spans[2];
  double *control;
  double *start[2]; /* n_spans + 1 values */
} refined;

static int full_knots(int degree, int n, const double *knots, double *to) {
  int count = 0;
  for (int i = 0; i < n + degree + 1; i++) {
    if (i && knots[i] == knots[i - 1])
      continue;
    int end = knots[i] == knots[0] || knots[i] == knots[n];
    for (int k = 0; k < degree + end; k++)
      to[count++] = knots[i];
  }
  return count;
}

/* Inserts along direction d; the net of `from` has n[0] x n[1] rows. */
static double *insert_along(tsi_arena *arena, const tsi_planar *p, int d, const int n[2],
                            const double *from, int n_to, const double *to) {
  size_t size[2] = {(size_t)n[0], (size_t)n[1]};
  size[d] = (size_t)n_to;
  double *net = tsi_arena_new(arena, size[0] * size[1], 3 * sizeof *net);
  if (!net)
    return NULL;
  for (int j = 0; j < n[1]; j++)
    memcpy(net + 3 * size[0] * (size_t)j, from + 3 * (size_t)n[0] * (size_t)j,
           3 * (size_t)n[0] * sizeof *net);
  if (d)
    tsi_bspline_insert(p->degree[1], n[1], p->knots[1], n_to, to, 3 * n[0], net);
  else
    for (int j = 0; j < n[1]; j++)
      tsi_bspline_insert(p->degree[0], n[0], p->knots[0], n_to, to, 3,
                         net + 3 * size[0] * (size_t)j);
  return net;
}

/* Scaled by powers of two, so that no product overflows. */
static int refine(tsi_arena *arena, const tsi_planar *p, double size, double heaviest, refined *r) {
  double point_scale = tsi_unit_scale(size), weight_scale = tsi_unit_scale(heaviest);
  size_t n = (size_t)p->n[0] * (size_t)p->n[1];
  double *net = tsi_arena_new(arena, n, 3 * sizeof *net);
  if (!net)
    return 0;
  for (size_t i = 0; i < n; i++) {
    double w = weight_scale * p->weight[i];
    net[3 * i] = w * (point_scale * p->point[2 * i]);
    net[3 * i + 1] = w * (point_scale * p->point[2 * i + 1]);
    net[3 * i + 2] = w;
  }
  r->n[0] = p->n[0];
  r->n[1] = p->n[1];
  for (int d = 0; d < 2; d++) {
    int q = p->degree[d];
    size_t most = (size_t)(p->n[d] + 1) * (size_t)(q + 1);
    double *to = tsi_arena_new(arena, most, sizeof *to);
    r->start[d] = tsi_arena_new(arena, most, sizeof *to);
    if (!to || !r->start[d])
      return 0;
    int n_to = full_knots(q, p->n[d], p->knots[d], to) - q - 1;
    net = insert_along(arena, p, d, r->n, net, n_to, to);
    if (!net)
      return 0;
    r->n[d] = n_to;
    r->n_spans[d] = (n_to - 1) / q;
    for (int s = 0; s <= r->n_spans[d]; s++)
      r->start[d][s] = to[s ? s * q + 1 : 0];
  }
  r->control = net;
  return 1;
}

static void load_net(certifier *c, const refined *r, int a, int b) {
  size_t width = 3 * ((size_t)c->degree[0] + 1);
  for (int j = 0; j <= c->degree[1]; j++) {
    size_t row = (size_t)(a * c->degree[0]) + (size_t)r->n[0] * (size_t)(b * c->degree[1] + j);
    memcpy(c->net + width * (size_t)j, r->control + 3 * row, width * sizeof *c->net);
  }
}

/* ---- N in Bernstein form -----------------------------------------------------------------------
 */

static size_t net_row(const certifier *c, int i, int j) {
  return (size_t)i + ((size_t)c->degree[0] + 1) * (size_t)j;
}

/* Components of X (derivative = 0: first rows along `axis`) or X_axis, scaled, with one delta. */
static void make_leaves(const certifier *c, int n_components, int axis, int derivative,
                        double *const *pair, tsi_product *leaf) {
  int n[2] = {c->degree[0] + (axis != 0), c->degree[1] + (axis != 1)}, q = c->degree[axis];
  double largest = 0.0, largest_error = 0.0;
  for (int x = 0; x < n_components; x++)
    for (int k = 0; k < n[0] * n[1]; k++) {
      int i = k % n[0], j = k / n[0];
      double a = c->net[3 * net_row(c, i, j) + (size_t)x];
      double b = c->net[3 * net_row(c, i + (axis == 0), j + (axis == 1)) + (size_t)x];
      pair[x][2 * k] = derivative ? q * (b - a) : a;
      pair[x][2 * k + 1] = derivative ? 2.0 * q * c->error[x] : c->error[x];
      largest = fmax(largest, fabs(pair[x][2 * k]));
      largest_error = fmax(largest_error, pair[x][2 * k + 1]);
    }
  double delta = DELTA + (largest > 0.0 ? 2.0 * largest_error / largest : 0.0);
  delta = delta < 0.5 ? delta : 0.5;
  for (int x = 0; x < n_components; x++) {
    for (int k = 0; k < n[0] * n[1]; k++) {
      double *v = pair[x] + 2 * (ptrdiff_t)k;
      double binomial = tsi_binomial(n[0] - 1, k % n[0]) * tsi_binomial(n[1] - 1, k / n[0]);
      v[1] = (fabs(v[0]) + v[1] / delta) * binomial;
      v[0] *= binomial;
    }
    leaf[x] = (tsi_product){{n[0], n[1], 1}, delta, pair[x]};
  }
}

static void add_minor(tsi_product *minor, const tsi_product *a, const tsi_product *a1,
                      const tsi_product *b, const tsi_product *b1) {
  tsi_product_clear(minor, a, b1);
  tsi_product_add(minor, 1.0, a, b1);
  tsi_product_add(minor, -1.0, a1, b);
  tsi_product_close(minor, 2, a, b1);
}

static void make_jacobian(certifier *c, tsi_product *n) {
  tsi_product first[3], step[3], other[3], minor = {{0, 0, 0}, 0.0, c->minor};
  int d = c->degree[1] > c->degree[0] ? 1 : 0;
  if (c->constant_weight) {
    make_leaves(c, 2, 0, 1, c->leaf, first);
    make_leaves(c, 2, 1, 1, c->leaf + 3, step);
    add_minor(n, &first[0], &first[1], &step[0], &step[1]);
    tsi_product_unscale(n);
    return;
  }
  make_leaves(c, 3, d, 0, c->leaf, first);
  make_leaves(c, 3, d, 1, c->leaf + 3, step);
  make_leaves(c, 3, 1 - d, 1, c->leaf + 6, other);
  for (int x = 0; x < 3; x++) {
    int y = (x + 1) % 3, z = (x + 2) % 3;
    add_minor(&minor, &first[y], &first[z], &step[y], &step[z]);
    if (x == 0)
      tsi_product_clear(n, &minor, &other[x]);
    tsi_product_add(n, d ? -1.0 : 1.0, &minor, &other[x]);
  }
  tsi_product_close(n, 3, &minor, &other[0]);
  tsi_product_unscale(n);
}

/* ---- subdivision -------------------------------------------------------------------------------
 */

static double error_bound(const tsi_product *n, size_t k) {
  return n->delta * TSI_MAGNITUDE_SLACK * n->pair[2 * k + 1] + UNDERFLOW_ERROR;
}

static size_t corner_index(const tsi_product *n, int corner) {
  size_t i = corner & 1 ? (size_t)n->n[0] - 1 : 0, j = corner & 2 ? (size_t)n->n[1] - 1 : 0;
  return i + (size_t)n->n[0] * j;
}

/* The element's corner `corner`, if this part has it and N is known there. */
static int is_known(const certifier *c, const part *p, int corner) {
  for (int d = 0; d < 2; d++)
    if (corner >> d & 1 ? p->low[d] + p->width[d] != 1.0 : p->low[d] != 0.0)
      return 0;
  return c->known >> corner & 1;
}

/* Verdict on one part; `where` is the corner when not positive. */
static tsolid_verdict judge(const certifier *c, part *p, int *where) {
  const tsi_product *n = &p->n;
  size_t size = tsi_product_size(n), exempt[4];
  int n_exempt = 0;
  for (int corner = 0; corner < 4; corner++) {
    size_t k = corner_index(n, corner);
    if (is_known(c, p, corner) && fabs(n->pair[2 * k]) <= error_bound(n, k)) {
      exempt[n_exempt++] = k;
    } else if (n->pair[2 * k] + error_bound(n, k) <= 0.0) {
      *where = corner;
      return TSOLID_NOT_POSITIVE;
    }
  }
  p->least = INFINITY;
  for (size_t k = 0; k < size; k++) {
    double low = n->pair[2 * k] - error_bound(n, k);
    int skip = 0;
    for (int i = 0; i < n_exempt; i++)
      skip |= exempt[i] == k;
    if (!skip && !(low >= p->least))
      p->least = isnan(low) ? -INFINITY : low;
  }
  return p->least > 0.0 ? TSOLID_POSITIVE : TSOLID_UNDECIDED;
}

/* Largest |second difference| along a direction, times n (n - 1). */
static double variation(const tsi_product *n, int axis) {
  int stride = axis ? n->n[0] : 1, count = n->n[axis];
  double largest = 0.0;
  for (int j = 0; j < n->n[1] - (axis ? 2 : 0); j++)
    for (int i = 0; i < n->n[0] - (axis ? 0 : 2); i++) {
      const double *v = n->pair + 2 * (ptrdiff_t)(i + n->n[0] * j);
      double second = fabs((v[0] - v[2 * stride]) - (v[2 * stride] - v[4 * stride]));
      largest = second > largest ? second : largest;
    }
  return largest * (count - 1) * (count - 2);
}

static void locate(const part *p, int corner, double u[2]) {
  for (int d = 0; d < 2; d++)
    u[d] = p->low[d] + (corner < 0 ? 0.5 : (double)(corner >> d & 1)) * p->width[d];
}

static void bisect(part *p, part *upper, int axis) {
  tsi_product_bisect(&p->n, &upper->n, axis);
  p->width[axis] *= 0.5;
  p->depth++;
  memcpy(upper->low, p->low, sizeof p->low);
  memcpy(upper->width, p->width, sizeof p->width);
  upper->low[axis] += p->width[axis];
  upper->depth = p->depth;
}

/* The stack holds undecided parts, of two new ones that with the least coefficient on top. */
static tsolid_verdict subdivide(certifier *c, tsi_planar_outcome *outcome) {
  tsolid_verdict verdict = TSOLID_POSITIVE;
  int n_waiting = 1, where = -1;
  double work = 0.0, worst = INFINITY,
         one =
             (double)tsi_product_size(&c->stack->n) * (double)(c->stack->n.n[0] + c->stack->n.n[1]);
  while (n_waiting > 0) {
    part *p = &c->stack[n_waiting - 1], *q = p + 1;
    int axis = variation(&p->n, 1) > variation(&p->n, 0);
    work += (double)tsi_product_size(&p->n) * (double)p->n.n[axis];
    if (p->depth >= MAX_DEPTH || work > fmax(MAX_WORK, MIN_BISECTIONS * one)) {
      verdict = TSOLID_UNDECIDED;
      if (p->least < worst) {
        worst = p->least;
        locate(p, -1, outcome->u);
      }
      n_waiting--;
      continue;
    }
    bisect(p, q, axis);
    outcome->depth = p->depth > outcome->depth ? p->depth : outcome->depth;
    int keep[2];
    for (int i = 0; i < 2; i++) {
      tsolid_verdict part_verdict = judge(c, p + i, &where);
      keep[i] = part_verdict == TSOLID_UNDECIDED;
      if (part_verdict == TSOLID_NOT_POSITIVE) {
        locate(p + i, where, outcome->u);
        return TSOLID_NOT_POSITIVE;
      }
    }
    if (keep[1] && (!keep[0] || p->least < q->least)) {
      part swap = *p;
      *p = *q;
      *q = swap;
    }
    n_waiting += keep[0] + keep[1] - 1;
  }
  return verdict;
}

/* ---- driver ------------------------------------------------------------------------------------
 */

static int make_certifier(tsi_arena *arena, const tsi_planar *patch, double error, certifier *c,
                          refined *r) {
  double heaviest = 0.0, largest = 0.0, steps = 0.0, spread = 0.0;
  size_t net = 1, minor = 1, jacobian = 1;
  for (size_t i = 0; i < (size_t)patch->n[0] * (size_t)patch->n[1]; i++) {
    heaviest = fmax(heaviest, patch->weight[i]);
    spread = fmax(spread, fabs(patch->weight[i] - patch->weight[0]));
    for (size_t x = 0; x < 2; x++)
      largest = fmax(largest, fabs(patch->point[2 * i + x]));
  }
  if (!refine(arena, patch, largest, heaviest, r))
    return 0;
  double point_scale = tsi_unit_scale(largest);
  error *= point_scale;
  largest *= point_scale;
  heaviest *= tsi_unit_scale(heaviest);
  for (int d = 0; d < 2; d++) {
    size_t q = (size_t)patch->degree[d];
    c->degree[d] = patch->degree[d];
    steps += (double)(q * (q + 1));
    net *= q + 1;
    minor *= 2 * q + 1;
    jacobian *= 3 * q + 1;
  }
  c->constant_weight = spread == 0.0;
  c->error[0] = c->error[1] =
      heaviest * (error + TSI_ROUND_OFF * (1.0 + 12.0 * steps) * largest) * (1.0 + 0x1p-30);
  c->error[2] = c->constant_weight ? 0.0 : 12.0 * TSI_ROUND_OFF * steps * heaviest;
  c->net = tsi_arena_new(arena, net, 3 * sizeof *c->net);
  c->minor = tsi_arena_new(arena, minor, 2 * sizeof *c->minor);
  c->stack = tsi_arena_new(arena, MAX_DEPTH + 2, sizeof *c->stack);
  int ok = c->net && c->minor && c->stack;
  for (int i = 0; ok && i < N_LEAVES; i++)
    ok = (c->leaf[i] = tsi_arena_new(arena, net, 2 * sizeof(double))) != NULL;
  for (int i = 0; ok && i < MAX_DEPTH + 2; i++)
    ok = (c->stack[i].n.pair = tsi_arena_new(arena, jacobian, 2 * sizeof(double))) != NULL;
  return ok;
}

/* Bits of the element's corners, numbered by bits, that are singular corners of the patch. */
static int known_corners(const refined *r, int a, int b, int singular) {
  static const int corner[4] = {0, 1, 3, 2};
  int bits = 0;
  for (int k = 0; k < 4; k++) {
    int i = corner[k] & 1 ? r->n_spans[0] - 1 : 0, j = corner[k] & 2 ? r->n_spans[1] - 1 : 0;
    if ((singular >> k & 1) && a == i && b == j)
      bits |= 1 << corner[k];
  }
  return bits;
}

static tsolid_verdict certify_element(certifier *c, tsi_planar_outcome *outcome) {
  int where = -1;
  part *root = &c->stack[0];
  root->low[0] = root->low[1] = 0.0;
  root->width[0] = root->width[1] = 1.0;
  root->depth = 0;
  make_jacobian(c, &root->n);
  tsolid_verdict verdict = judge(c, root, &where);
  if (verdict == TSOLID_NOT_POSITIVE)
    locate(root, where, outcome->u);
  return verdict == TSOLID_UNDECIDED ? subdivide(c, outcome) : verdict;
}

tsolid_status tsi_planar_certify(tsolid_context *context, const tsi_planar *patch, int singular,
                                 double error, tsi_planar_outcome *outcome) {
  tsi_arena arena = tsi_arena_create(context);
  tsolid_status status = TSOLID_OK;
  certifier c = {.known = 0};
  refined r;
  *outcome = (tsi_planar_outcome){.verdict = TSOLID_POSITIVE};
  if (!make_certifier(&arena, patch, error, &c, &r)) {
    status = tsi_no_memory(context, TSI_COONS_STAGE);
    goto done;
  }
  outcome->n_elements = r.n_spans[0] * r.n_spans[1];
  for (int b = 0; b < r.n_spans[1] && outcome->verdict != TSOLID_NOT_POSITIVE; b++)
    for (int a = 0; a < r.n_spans[0] && outcome->verdict != TSOLID_NOT_POSITIVE; a++) {
      tsi_planar_outcome own = {.depth = outcome->depth};
      load_net(&c, &r, a, b);
      c.known = known_corners(&r, a, b, singular);
      own.verdict = certify_element(&c, &own);
      outcome->depth = own.depth > outcome->depth ? own.depth : outcome->depth;
      if (own.verdict == TSOLID_POSITIVE ||
          (own.verdict == TSOLID_UNDECIDED && outcome->verdict == TSOLID_UNDECIDED))
        continue;
      outcome->verdict = own.verdict;
      const int at[2] = {a, b};
      for (int d = 0; d < 2; d++) {
        double low = r.start[d][at[d]];
        outcome->u[d] = low + own.u[d] * (r.start[d][at[d] + 1] - low);
      }
    }
done:
  tsi_arena_free(&arena);
  return status;
}
