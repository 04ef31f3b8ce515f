/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The start: the cross is laid into a cube, the cube into the part.
 *
 * The first map takes the core to a smaller box inside the unit cube and the arms to the frusta
 * around it, as thick as `share` says per axis. The second is the transfinite (Coons) map of the
 * six sides S:
 *   x = U + V + W - UV - VW - UW + UVW,   U = (1-a) S_low(b,c) + a S_high(b,c), ...
 * Control points are values at Greville points: the spline then follows the map without wiggles,
 * with an error of second order.
 *
 * Where the T-mesh lets the functions crease on all of the core surface, they can do better: the
 * map is smooth block by block. Then weights are blended like positions, and the homogeneous
 * control points c are led on to the values h of the map at the same points u, c_f <- c_f + h(u_f)
 * - sum_g c_g N_g(u_f), whose matrix has, on a tensor mesh, eigenvalues in (0, 1] only: the solid
 * then differs from the map by fourth order.
 *
 * Layers as thick as their share of every axis would meet at slivers along the edges of a plate. So
 * the thickness is the same in space along all three axes: the smallest one allows.
 *
 * Source: W. Gordon, C. Hall (1973), Construction of curvilinear coordinate systems; DESIGN asks
 * for a harmonic start or an equivalent cheap smooth one: a harmonic map of the cross has zero
 * gradient at the core's edges (three right angles meet there) and starts inverted on plates and
 * bends. */
#include "transfinite.h"
#include "bernstein.h"
#include "bvh.h"
#include "evaluate.h"

static const char *const STAGE = "solid";

enum { TABLE = 5, PATH = 8 }; /* places per direction and segments of the length table */
enum { MAX_SWEEPS = 120 };
static const double FOLLOWED = 1e-13; /* of the part's size: what is left to gain */

typedef struct starter {
  const tsolid_space *space;
  struct tsi_bvh *tree[6];
  double *net[6];                 /* Bezier nets of the side's elements, homogeneous rows of 4 */
  double low[3], high[3];         /* share of each axis that an arm may take */
  double length[3][TABLE][TABLE]; /* of the line along axis a at (b, c) */
} starter;

/* ---- the sides
 * ---------------------------------------------------------------------------------------- */

typedef struct side_point {
  const tsi_side *side;
  const double *net;
  double s, t, sum[4];
} side_point;

static int evaluate_side_element(void *data, int element) {
  side_point *p = data;
  const double *box = p->side->box + 4 * (size_t)element;
  if (p->s < box[0] || p->s > box[1] || p->t < box[2] || p->t > box[3])
    return 0;
  double b[2][TSI_MAX_ORDER];
  int ns = p->side->degree[0] + 1, nt = p->side->degree[1] + 1;
  const double *net = p->net + 4 * (size_t)(ns * nt) * (size_t)element;
  tsi_bernstein(ns - 1, (p->s - box[0]) / (box[1] - box[0]), b[0]);
  tsi_bernstein(nt - 1, (p->t - box[2]) / (box[3] - box[2]), b[1]);
  for (int j = 0; j < nt; j++)
    for (int i = 0; i < ns; i++, net += 4)
      for (int c = 0; c < 4; c++)
        p->sum[c] += b[0][i] * b[1][j] * net[c];
  return 1;
}

/* A side's Euclidean point and its weight; cube holds the two lateral coordinates, up to round-off
 * in [0,1]. */
static void side_value(const starter *st, int side, const double cube[3], double x[4]) {
  side_point p = {.side = &st->space->boundary->side[side],
                  .net = st->net[side],
                  .s = fmin(fmax(cube[tsi_side_s(side)], 0.0), 1.0),
                  .t = fmin(fmax(cube[tsi_side_t(side)], 0.0), 1.0)};
  double at[3] = {p.s, p.t, 0.0};
  tsi_bvh_containing(st->tree[side], at, 0.0, evaluate_side_element, &p);
  for (int c = 0; c < 3; c++)
    x[c] = p.sum[c] / p.sum[3];
  x[3] = p.sum[3];
}

/* ---- the transfinite map
 * ---------------------------------------------------------------------------------- */

/* x += factor * (point of the boundary at cube with the axes in `ends` moved to an end each,
 * weighted linearly): the term of one, two or three projections. */
static void add_projection(const starter *st, const double cube[3], int ends, double factor,
                           double x[4]) {
  for (int corner = 0; corner < 8; corner++) {
    double q[3] = {cube[0], cube[1], cube[2]}, weight = factor, value[4];
    int side = -1;
    if (corner & ~ends)
      continue;
    for (int a = 0; a < 3; a++)
      if (ends >> a & 1) {
        int end = corner >> a & 1;
        weight *= end ? cube[a] : 1.0 - cube[a];
        q[a] = end;
        side = 2 * a + end;
      }
    if (weight == 0.0)
      continue;
    side_value(st, side, q, value);
    for (int c = 0; c < 4; c++)
      x[c] += weight * value[c];
  }
}

/* The weight is blended like the coordinates: not positive everywhere. */
static void transfinite(const starter *st, const double cube[3], double x[4]) {
  x[0] = x[1] = x[2] = x[3] = 0.0;
  for (int ends = 1; ends < 8; ends++) {
    int n = (ends & 1) + (ends >> 1 & 1) + (ends >> 2 & 1);
    add_projection(st, cube, ends, n == 2 ? -1.0 : 1.0, x);
  }
}

/* ---- the cross in the cube
 * ----------------------------------------------------------------------------------- */

static void measure_lengths(starter *st) {
  for (int a = 0; a < 3; a++)
    for (int i = 0; i < TABLE * TABLE; i++) {
      double cube[3], previous[3] = {0.0}, x[4], sum = 0.0;
      cube[(a + 1) % 3] = (double)(i % TABLE) / (TABLE - 1);
      cube[(a + 2) % 3] = (double)(i / TABLE) / (TABLE - 1);
      for (int k = 0; k <= PATH; k++) {
        cube[a] = (double)k / PATH;
        transfinite(st, cube, x);
        if (k > 0)
          sum += sqrt((x[0] - previous[0]) * (x[0] - previous[0]) +
                      (x[1] - previous[1]) * (x[1] - previous[1]) +
                      (x[2] - previous[2]) * (x[2] - previous[2]));
        memcpy(previous, x, sizeof previous);
      }
      st->length[a][i % TABLE][i / TABLE] = sum;
    }
}

/* One length per axis: no kinks where the table is read between its places. */
static void flatten_lengths(starter *st) {
  for (int a = 0; a < 3; a++) {
    double *l = &st->length[a][0][0], sum = 0.0;
    for (int i = 0; i < TABLE * TABLE; i++)
      sum += l[i];
    for (int i = 0; i < TABLE * TABLE; i++)
      l[i] = sum / (TABLE * TABLE);
  }
}

static double length_at(const starter *st, int a, const double cube[3]) {
  double f[2];
  int i[2];
  for (int k = 0; k < 2; k++) {
    double x = cube[(a + 1 + k) % 3] * (TABLE - 1);
    i[k] = (int)fmin(fmax(floor(x), 0.0), TABLE - 2);
    f[k] = x - i[k];
  }
  const double(*l)[TABLE] = st->length[a];
  return (1.0 - f[0]) * ((1.0 - f[1]) * l[i[0]][i[1]] + f[1] * l[i[0]][i[1] + 1]) +
         f[0] * ((1.0 - f[1]) * l[i[0] + 1][i[1]] + f[1] * l[i[0] + 1][i[1] + 1]);
}

/* Shares of the axes at a place of the cube: the same thickness in space along all of them. */
static void shares_at(const starter *st, const double cube[3], double low[3], double high[3]) {
  double length[3], thickness = INFINITY;
  for (int a = 0; a < 3; a++) {
    length[a] = length_at(st, a, cube);
    thickness = fmin(thickness, length[a] * fmin(st->low[a], st->high[a]));
  }
  for (int a = 0; a < 3; a++) {
    low[a] = fmin(st->low[a], thickness / fmax(length[a], 1e-300));
    high[a] = fmin(st->high[a], thickness / fmax(length[a], 1e-300));
  }
}

/* Where u of an arm (axis >= 0) or of the core lies in the cube, for given shares. */
static void place(const tsolid_tmesh *tmesh, const double u[3], const double low[3],
                  const double high[3], double cube[3]) {
  int arm = -1;
  double rho = 0.0;
  for (int a = 0; a < 3; a++)
    if (u[a] < 0.0 || u[a] > 1.0)
      arm = a;
  if (arm >= 0)
    rho = u[arm] > 1.0 ? (u[arm] - 1.0) / tmesh->arm_height[2 * arm + 1]
                       : -u[arm] / tmesh->arm_height[2 * arm];
  for (int a = 0; a < 3; a++) {
    double inside = low[a] + u[a] * (1.0 - low[a] - high[a]);
    if (a == arm)
      cube[a] = u[a] > 1.0 ? 1.0 - high[a] * (1.0 - rho) : low[a] * (1.0 - rho);
    else
      cube[a] = (1.0 - rho) * inside + rho * u[a];
  }
}

static void cross_to_part(const starter *st, const double u[3], double x[4]) {
  double cube[3], low[3], high[3];
  place(st->space->tmesh, u, st->low, st->high, cube);
  shares_at(st, cube, low, high);
  place(st->space->tmesh, u, low, high, cube);
  transfinite(st, cube, x);
}

/* ---- control points
 * ------------------------------------------------------------------------------------------ */

static void greville(const tsolid_tmesh *tmesh, const tsi_piece *piece, double u[3]) {
  for (int a = 0; a < 3; a++) {
    const double *v = tmesh->plane_value[a];
    const int *k = piece->knot[a];
    u[a] = (v[k[1]] + v[k[2]] + v[k[3]]) / 3.0;
  }
}

/* Mass and centre of every surface function per side: rows of (mass, s, t). */
static void surface_centres(const tsolid_boundary *boundary, double *centre) {
  for (int side = 0; side < 6; side++) {
    const tsi_side *s = &boundary->side[side];
    int ns = s->degree[0] + 1, nt = s->degree[1] + 1;
    for (int e = 0; e < s->n_elements; e++) {
      const double *box = s->box + 4 * (size_t)e;
      double area = (box[1] - box[0]) * (box[3] - box[2]);
      for (int k = s->function_start[e]; k < s->function_start[e + 1]; k++) {
        const double *c = s->coefficient + (size_t)k * (size_t)(ns * nt);
        double *row = centre + 3 * (6 * (size_t)s->function[k] + (size_t)side);
        for (int i = 0; i < ns * nt; i++) {
          double mass = c[i] * area;
          row[0] += mass;
          row[1] += mass * (box[0] + (box[1] - box[0]) * (i % ns) / fmax(ns - 1, 1));
          row[2] += mass * (box[2] + (box[3] - box[2]) * (i / ns) / fmax(nt - 1, 1));
        }
      }
    }
  }
}

/* Cube coordinates of a surface function: on every side that it lives on its centre of mass, and on
 * the isoline or corner where several meet. Returns the side with most of it. */
static int anchor(const double *rows, double cube[3]) {
  int best = -1;
  double fixed[3] = {-1.0, -1.0, -1.0}, sum[3] = {0}, mass[3] = {0};
  for (int side = 0; side < 6; side++) {
    const double *row = rows + 3 * side;
    if (!(row[0] > 0.0))
      continue;
    fixed[tsi_side_axis(side)] = side & 1;
    sum[tsi_side_s(side)] += row[1];
    mass[tsi_side_s(side)] += row[0];
    sum[tsi_side_t(side)] += row[2];
    mass[tsi_side_t(side)] += row[0];
    if (best < 0 || row[0] > rows[3 * best])
      best = side;
  }
  for (int a = 0; a < 3; a++)
    cube[a] = fixed[a] >= 0.0 ? fixed[a] : sum[a] / mass[a];
  return best;
}

/* Where a function of the layer R- stands: below its anchor `cube`, at the Greville depth of M_R-.
 * Returns the side. */
static int place_below(const tsolid_tmesh *tmesh, const double *rows, double cube[3], double u[3]) {
  int side = anchor(rows, cube), axis = tsi_side_axis(side), knot = side & 1 ? -3 : 2;
  memcpy(u, cube, 3 * sizeof *u);
  double r1 = tmesh->plane_value[axis][knot < 0 ? tmesh->n_planes[axis] + knot : knot];
  double end = tmesh->plane_value[axis][side & 1 ? tmesh->n_planes[axis] - 1 : 0];
  u[axis] = (r1 + 2.0 * end) / 3.0;
  return side;
}

/* P_i + (x below the anchor) - (x at the anchor). */
static void place_minus(const starter *st, int function, const double *rows, const double centre[3],
                        double position[3]) {
  double cube[3], u[3], below[4], at[4];
  place_below(st->space->tmesh, rows, cube, u);
  cross_to_part(st, u, below);
  transfinite(st, cube, at);
  const double *p = st->space->boundary->points + 4 * (size_t)function;
  for (int c = 0; c < 3; c++)
    position[c] = p[c] / p[3] + below[c] - at[c] - centre[c];
}

static void fill_nets(const tsolid_boundary *boundary, const tsi_side *s, double *net) {
  int size = (s->degree[0] + 1) * (s->degree[1] + 1);
  for (int e = 0; e < s->n_elements; e++, net += 4 * size)
    for (int k = s->function_start[e]; k < s->function_start[e + 1]; k++) {
      const double *c = s->coefficient + (size_t)k * (size_t)size;
      const double *point = boundary->points + 4 * (size_t)s->function[k];
      for (int i = 0; i < size; i++)
        for (int j = 0; j < 4; j++)
          net[4 * i + j] += c[i] * point[j];
    }
}

static int prepare(starter *st, const tsi_allocator *allocator) {
  for (int side = 0; side < 6; side++) {
    const tsi_side *s = &st->space->boundary->side[side];
    size_t size = (size_t)(s->degree[0] + 1) * (size_t)(s->degree[1] + 1);
    st->net[side] = tsi_new(allocator, (size_t)s->n_elements * size, 4 * sizeof(double));
    if (!st->net[side])
      return 0;
    fill_nets(st->space->boundary, s, st->net[side]);
    double *box = tsi_new(allocator, (size_t)s->n_elements, 6 * sizeof *box);
    for (int e = 0; box && e < s->n_elements; e++)
      for (int i = 0; i < 4; i++)
        box[6 * e + (i & 1) * 3 + i / 2] = s->box[4 * (size_t)e + (size_t)i];
    st->tree[side] = box ? tsi_bvh_create(allocator, s->n_elements, box) : NULL;
    tsi_delete(allocator, box);
    if (!st->tree[side])
      return 0;
  }
  for (int a = 0; a < 3; a++) {
    const double *r = st->space->tmesh->arm_height + 2 * a;
    st->low[a] = r[0] / (1.0 + r[0] + r[1]);
    st->high[a] = r[1] / (1.0 + r[0] + r[1]);
  }
  measure_lengths(st);
  if (st->space->tmesh->flags & TSI_TMESH_SHARP_CORE)
    flatten_lengths(st);
  return 1;
}

static void free_starter(starter *st, const tsi_allocator *allocator) {
  for (int side = 0; side < 6; side++) {
    tsi_bvh_free(st->tree[side]);
    tsi_delete(allocator, st->net[side]);
  }
}

tsolid_status tsi_transfinite_start(tsolid_context *context, const tsolid_space *space,
                                    const double centre[3], double *position) {
  starter st = {.space = space};
  tsolid_status status = TSOLID_OK;
  double *rows = tsi_new(&context->allocator, (size_t)space->n_surface, 18 * sizeof *rows);
  if (!rows || !prepare(&st, &context->allocator)) {
    status = tsi_no_memory(context, STAGE);
    goto done;
  }
  for (int f = 0; f < space->n_inner; f++) {
    double u[3], x[4];
    greville(space->tmesh, &space->piece[space->piece_start[f]], u);
    cross_to_part(&st, u, x);
    for (int c = 0; c < 3; c++)
      position[3 * (size_t)f + (size_t)c] = x[c] - centre[c];
  }
  surface_centres(space->boundary, rows);
  for (int i = 0; i < space->n_surface; i++)
    place_minus(&st, i, rows + 18 * (size_t)i, centre,
                position + 3 * ((size_t)space->n_inner + (size_t)i));
done:
  free_starter(&st, &context->allocator);
  tsi_delete(&context->allocator, rows);
  return status;
}

/* ---- following the map ------------------------------------------------------------------------
 */

/* A free function's place u in the cross, and the map's homogeneous value there. */
typedef struct follower {
  int element; /* that holds u; -1: none, the function stays as it is */
  double local[3], value[4];
} follower;

static int all_equal(const double *row, int n) {
  for (int i = 1; i < n; i++)
    if (row[4 * (size_t)i + 3] != row[3])
      return 0;
  return 1;
}

/* Homogeneous value in the core or on the boundary; `weight` > 0: of all weights, else the blended
 * one. */
static void end_value(const starter *st, const double u[3], double weight, double h[4]) {
  cross_to_part(st, u, h);
  h[3] = weight > 0.0 ? weight : h[3];
  for (int c = 0; c < 3; c++)
    h[c] *= h[3];
}

/* The map to follow: in the arms straight from the core's surface to the boundary. So it has no
 * zero Jacobian where two sides of the part join smoothly at an isoline, as the transfinite map
 * has. */
static void map_value(const starter *st, const double u[3], double weight, double h[4]) {
  const double *height = st->space->tmesh->arm_height;
  double core[3], end[3], outer[4], rho = 0.0;
  for (int a = 0; a < 3; a++) {
    core[a] = end[a] = fmin(fmax(u[a], 0.0), 1.0);
    if (u[a] < 0.0 || u[a] > 1.0) {
      rho = u[a] < 0.0 ? -u[a] / height[2 * a] : (u[a] - 1.0) / height[2 * a + 1];
      end[a] = u[a] < 0.0 ? -height[2 * a] : 1.0 + height[2 * a + 1];
    }
  }
  end_value(st, core, weight, h);
  if (rho > 0.0) {
    end_value(st, end, weight, outer);
    for (int c = 0; c < 4; c++)
      h[c] = (1.0 - rho) * h[c] + rho * outer[c];
  }
}

static void find_element(const tsolid_space *space, const double u[3], follower *f) {
  int block = 0;
  for (int a = 0; a < 3; a++)
    if (u[a] < 0.0 || u[a] > 1.0)
      block = 1 + 2 * a + (u[a] > 1.0);
  f->element = tsi_space_locate(space, block, u);
  if (f->element >= 0)
    tsi_element_local(&space->element[f->element], u, f->local);
}

/* The free functions' places, and as first control points the map's values there. */
static void find_followers(const starter *st, const double *rows, follower *follow,
                           double *control) {
  const tsolid_space *space = st->space;
  const double *points = space->boundary->points;
  double weight = all_equal(points, space->n_surface) ? points[3] : 0.0, u[3];
  for (int f = 0; f < space->n_inner; f++) {
    greville(space->tmesh, &space->piece[space->piece_start[f]], u);
    map_value(st, u, weight, follow[f].value);
    find_element(space, u, &follow[f]);
    memcpy(control + 4 * (size_t)f, follow[f].value, sizeof follow[f].value);
  }
  for (int i = 0; i < space->n_surface; i++) {
    follower *f = &follow[space->n_inner + i];
    double cube[3], end[3], at[4], *c = control + 4 * ((size_t)space->n_inner + (size_t)i);
    int side = place_below(space->tmesh, rows + 18 * (size_t)i, cube, u);
    memcpy(end, u, sizeof end);
    end[tsi_side_axis(side)] =
        side & 1 ? 1.0 + space->tmesh->arm_height[side] : -space->tmesh->arm_height[side];
    map_value(st, u, weight, f->value);
    map_value(st, end, weight, at);
    find_element(space, u, f);
    for (int k = 0; k < 4; k++)
      c[k] = points[4 * (size_t)i + (size_t)k] + f->value[k] - at[k];
    if (weight > 0.0)
      c[3] = weight;
  }
}

typedef struct follow_sum {
  const double *control;
  double sum[4];
} follow_sum;

static void add_to_sum(void *data, int function, const double *value) {
  follow_sum *s = data;
  for (int c = 0; c < 4; c++)
    s->sum[c] += value[0] * s->control[4 * (size_t)function + (size_t)c];
}

/* What is missing at every place; returns the largest. */
static double find_missing(const tsolid_space *space, const follower *follow, const double *control,
                           int n_columns, double *missing) {
  int n = space->n_inner + space->n_surface;
  double largest = 0.0;
  memset(missing, 0, (size_t)n * 4 * sizeof *missing);
  for (int f = 0; f < n; f++) {
    follow_sum s = {.control = control};
    if (follow[f].element < 0)
      continue;
    tsi_element_functions(space, follow[f].element, follow[f].local, 0, add_to_sum, &s);
    for (int c = 0; c < n_columns; c++) {
      missing[4 * (size_t)f + (size_t)c] = follow[f].value[c] - s.sum[c];
      largest = fmax(largest, fabs(missing[4 * (size_t)f + (size_t)c]));
    }
  }
  return largest;
}

/* Sweeps while they gain; 0: a weight is not positive. */
static int sweep(const tsolid_space *space, const follower *follow, double *control,
                 double *missing) {
  size_t n = (size_t)(space->n_inner + space->n_surface);
  int n_columns = all_equal(space->boundary->points, space->n_surface) ? 3 : 4;
  double last = (double)INFINITY, enough = FOLLOWED * space->boundary->scale;
  for (int k = 0; k < MAX_SWEEPS; k++) {
    double largest = find_missing(space, follow, control, n_columns, missing);
    if (!(largest < last) || largest <= enough)
      break;
    for (size_t i = 0; i < 4 * n; i++)
      control[i] += missing[i];
    last = largest;
  }
  for (size_t f = 0; f < n; f++)
    if (!(control[4 * f + 3] > 0.0))
      return 0;
  return 1;
}

tsolid_status tsi_transfinite_follow(tsolid_context *context, const tsolid_space *space,
                                     double *control) {
  starter st = {.space = space};
  tsi_arena arena = tsi_arena_create(context);
  tsolid_status status = TSOLID_OK;
  size_t n_free = (size_t)(space->n_inner + space->n_surface), m = (size_t)space->n_surface;
  follower *follow = tsi_arena_new(&arena, n_free, sizeof *follow);
  double *rows = tsi_arena_new(&arena, m, 18 * sizeof *rows);
  double *missing = tsi_arena_new(&arena, n_free, 4 * sizeof *missing);
  double *trial = tsi_arena_new(&arena, n_free + m, 4 * sizeof *trial);
  if (!follow || !rows || !missing || !trial || !prepare(&st, &context->allocator)) {
    status = tsi_no_memory(context, STAGE);
    goto done;
  }
  surface_centres(space->boundary, rows);
  find_followers(&st, rows, follow, trial);
  memcpy(trial + 4 * n_free, space->boundary->points, 4 * m * sizeof *trial);
  if (sweep(space, follow, trial, missing))
    memcpy(control, trial, 4 * n_free * sizeof *control);
done:
  free_starter(&st, &context->allocator);
  tsi_arena_free(&arena);
  return status;
}
