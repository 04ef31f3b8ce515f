/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A surface as few exact B-spline patches.
 *
 * Faces that meet along whole sides are gathered to rectangles of faces, as large as they grow; the
 * Bezier elements of a rectangle, cut along common lines, are one piecewise polynomial in
 * homogeneous coordinates. It is smooth across its inner lines as far as its Bezier points say:
 *   not C^1   the rectangle is divided there
 *   C^k       a knot of multiplicity degree - k
 * Its control points are blossoms, P_i = f(t_i+1, .., t_i+p), of the piece with the longest of the
 * spans between these knots. The patch is converted back and compared; one that does not come back
 * within round-off keeps knots of full multiplicity. */
#include <stdlib.h>

#include "bernstein.h"
#include "boundary_file.h"
#include "patch.h"
#include "surface.h"

static const char stage[] = "surface";
static const double same_line = 1e-9;   /* relative to the length of a cell */
static const double same_point = 1e-13; /* relative to the largest homogeneous coordinate */

/* A rectangle of faces: cell (i, j) is cell[i + n[0]*j], the first link of its bottom side. */
typedef struct block {
  int n[2];
  int *cell;
} block;

typedef struct maker {
  tsolid_context *context;
  const tsolid_surface *s;
  tsi_arena *arena; /* temporary */
  tsolid_boundary_file *file;
  char *used; /* per face */
  double scale;
  tsolid_patch *patch;
  int n_patches;
  block rectangle;
  int *spare; /* as large as rectangle.cell */
} maker;

/* A piecewise polynomial on a grid of lines: Bezier points, (p (n-1) + 1) per direction. */
typedef struct grid {
  int n_lines[2];
  double *line[2];
  size_t width; /* points per row */
  double *point;
} grid;

/* ---- rectangles of faces -----------------------------------------------------------------------
 */

/* First link of the side that follows that of `first`, itself the first of its side. *n: links on
 * the side of `first`. */
static int next_side(const tsolid_surface *s, int first, int *n) {
  int i = s->link[first].next;
  for (*n = 1; s->link[i].straight; i = s->link[i].next)
    ++*n;
  return i;
}

static int turn_cell(const tsolid_surface *s, int cell, int quarters) {
  int n;
  for (int k = 0; k < quarters; k++)
    cell = next_side(s, cell, &n);
  return cell;
}

/* The cell across the right side, if the two share all of it; else -1. */
static int right_of(const tsolid_surface *s, int cell) {
  int n, right = turn_cell(s, cell, 1);
  next_side(s, right, &n);
  int other = s->link[right].opposite;
  if (n != 1 || s->link[other].face < 0 || s->link[other].straight)
    return -1;
  int bottom = next_side(s, other, &n);
  return n == 1 ? bottom : -1;
}

static int above(const tsolid_surface *s, int cell) {
  int right = right_of(s, turn_cell(s, cell, 1));
  return right < 0 ? -1 : turn_cell(s, right, 3);
}

/* Adds the column on the right if all its cells are free and in order. */
static int grow_right(maker *m) {
  const tsolid_surface *s = m->s;
  block *b = &m->rectangle;
  int w = b->n[0], h = b->n[1];
  for (int j = 0; j < h; j++) {
    int cell = right_of(s, b->cell[w - 1 + w * j]);
    if (cell < 0 || m->used[s->link[cell].face] || (j > 0 && above(s, m->spare[j - 1]) != cell))
      return 0;
    for (int k = 0; k < j; k++)
      if (s->link[m->spare[k]].face == s->link[cell].face)
        return 0;
    m->spare[j] = cell;
  }
  for (int j = 0; j < h; j++)
    m->used[s->link[m->spare[j]].face] = 1;
  for (int j = h - 1; j >= 0; j--) {
    b->cell[w + (w + 1) * j] = m->spare[j];
    memmove(b->cell + (w + 1) * j, b->cell + w * j, (size_t)w * sizeof *b->cell);
  }
  b->n[0]++;
  return 1;
}

/* Turns the rectangle clockwise, so that what was above is on the right. */
static void turn_block(maker *m) {
  block *b = &m->rectangle;
  int w = b->n[0], h = b->n[1];
  for (int j = 0; j < h; j++)
    for (int i = 0; i < w; i++)
      m->spare[j + h * (w - 1 - i)] = turn_cell(m->s, b->cell[i + w * j], 1);
  memcpy(b->cell, m->spare, (size_t)w * (size_t)h * sizeof *b->cell);
  b->n[0] = h;
  b->n[1] = w;
}

static void grow(maker *m, int face) {
  m->rectangle.n[0] = m->rectangle.n[1] = 1;
  m->rectangle.cell[0] = m->s->face_link[face];
  m->used[face] = 1;
  for (int k = 0; k < 4; k++) {
    while (grow_right(m))
      ;
    turn_block(m);
  }
}

/* ---- the piecewise polynomial of a rectangle ---------------------------------------------------
 */

/* Side of the face that a cell's bottom is, 0..3. */
static int side_of(const tsolid_surface *s, int cell) {
  int n, side = 0, i = s->face_link[s->link[cell].face];
  for (; i != cell; i = next_side(s, i, &n))
    side++;
  return side;
}

/* A point of a cell's frame in its face's. */
static void to_face(const double size[2], int side, double x, double y, double uv[2]) {
  uv[0] = side == 0 ? x : side == 1 ? size[0] - y : side == 2 ? size[0] - x : y;
  uv[1] = side == 0 ? y : side == 1 ? x : side == 2 ? size[1] - y : size[1] - x;
}

static int compare_numbers(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Lines of the strip k of an axis: those of all its cells, from 0 to its length. */
static int strip_lines(const maker *m, int axis, int k, double *line, double *length) {
  const block *b = &m->rectangle;
  const tsolid_surface *s = m->s;
  int n = 0, n_kept = 0;
  *length = -1.0;
  for (int j = 0; j < b->n[1 - axis]; j++) {
    int cell = axis ? b->cell[j + b->n[0] * k] : b->cell[k + b->n[0] * j];
    int face = s->link[cell].face, side = side_of(s, cell), own = (axis + side) & 1;
    const double *size = s->face_size + 2 * (size_t)face;
    int reversed = axis ? side == 1 || side == 2 : side >= 2;
    if (*length < 0.0)
      *length = size[own];
    for (int e = s->element_start[face]; e < s->element_start[face + 1]; e++)
      for (int h = 0; h < 2; h++) {
        double x = s->box[4 * (size_t)e + (size_t)(2 * own + h)];
        line[n++] = reversed ? size[own] - x : x;
      }
  }
  qsort(line, (size_t)n, sizeof *line, compare_numbers);
  for (int i = 0; i < n; i++)
    if (n_kept == 0 || line[i] > line[n_kept - 1] + same_line * *length)
      line[n_kept++] = line[i];
  return n_kept;
}

/* Homogeneous Bezier points of a face on the box (u0, u1, v0, v1), which lies in one element; 0: in
 * none. */
static int face_net(const tsolid_surface *s, int face, const double box[4], double *net) {
  size_t n = (size_t)s->degree + 1;
  double u = 0.5 * (box[0] + box[1]), v = 0.5 * (box[2] + box[3]);
  for (int e = s->element_start[face]; e < s->element_start[face + 1]; e++) {
    const double *own = s->box + 4 * (size_t)e;
    if (!(own[0] < u && u < own[1] && own[2] < v && v < own[3]))
      continue;
    memset(net, 0, 4 * n * n * sizeof *net);
    for (int k = s->function_start[e]; k < s->function_start[e + 1]; k++)
      for (size_t i = 0; i < n * n; i++)
        for (size_t d = 0; d < 4; d++)
          net[4 * i + d] +=
              s->coefficient[(size_t)k * n * n + i] * s->points[4 * (size_t)s->function[k] + d];
    double at[4];
    for (int d = 0; d < 4; d++) {
      double low = own[d & 2], width = own[(d & 2) + 1] - low;
      at[d] = fmin(fmax((box[d] - low) / width, 0.0), 1.0);
      if (at[d] < same_line || at[d] > 1.0 - same_line)
        at[d] = at[d] < 0.5 ? 0.0 : 1.0;
    }
    for (size_t k = 0; k < n; k++)
      for (size_t d = 0; d < 4; d++) {
        if (at[0] > 0.0 || at[1] < 1.0)
          tsi_bernstein_restrict(s->degree, at[0], at[1], net + 4 * n * k + d, 4);
      }
    for (size_t k = 0; k < n; k++)
      for (size_t d = 0; d < 4; d++) {
        if (at[2] > 0.0 || at[3] < 1.0)
          tsi_bernstein_restrict(s->degree, at[2], at[3], net + 4 * k + d, (int)(4 * n));
      }
    return 1;
  }
  return 0;
}

/* Index in a face's net of point (a, b) of a cell's. */
static size_t turned(int side, size_t p, size_t a, size_t b) {
  size_t i = side == 0 ? a : side == 1 ? p - b : side == 2 ? p - a : b;
  size_t j = side == 0 ? b : side == 1 ? a : side == 2 ? p - b : p - a;
  return i + (p + 1) * j;
}

static int is_same(const maker *m, const double *a, const double *b) {
  for (int d = 0; d < 4; d++)
    if (fabs(a[d] - b[d]) > same_point * m->scale)
      return 0;
  return 1;
}

/* Puts one piece into the grid; 0: it does not meet its neighbours, or there is none. */
static int put_piece(maker *m, grid *g, const double *net, int side, int i, int j) {
  size_t p = (size_t)m->s->degree;
  int whole = 1;
  for (size_t b = 0; b <= p; b++)
    for (size_t a = 0; a <= p; a++) {
      double *to = g->point + 4 * ((size_t)i * p + a + g->width * ((size_t)j * p + b));
      const double *from = net + 4 * turned(side, p, a, b);
      if ((a == 0 && i > 0) || (b == 0 && j > 0))
        whole = whole && is_same(m, to, from);
      else
        memcpy(to, from, 4 * sizeof *to);
    }
  return whole;
}

/* Lines of all strips of an axis one behind the other; strip[k]: where the lines of k begin. */
static int gather_lines(maker *m, int axis, grid *g, int **strip) {
  const block *b = &m->rectangle;
  const tsolid_surface *s = m->s;
  int n_strips = b->n[axis], most = 2, total = 1;
  for (int k = 0; k < b->n[0] * b->n[1]; k++) {
    int f = s->link[b->cell[k]].face;
    most += 2 * (s->element_start[f + 1] - s->element_start[f]);
  }
  *strip = tsi_arena_new(m->arena, (size_t)n_strips + 1, sizeof **strip);
  double *scratch = tsi_arena_new(m->arena, (size_t)most, sizeof *scratch), length, at = 0.0;
  g->line[axis] = tsi_arena_new(m->arena, (size_t)most, sizeof **g->line);
  if (!*strip || !scratch || !g->line[axis])
    return 0;
  for (int k = 0; k < n_strips; k++) {
    int n = strip_lines(m, axis, k, scratch, &length);
    for (int i = 1; i < n; i++)
      g->line[axis][total++] = at + (i == n - 1 ? length : scratch[i]);
    at += length;
    (*strip)[k + 1] = total - 1;
  }
  g->n_lines[axis] = total;
  return 1;
}

/* 1: made; 0: the pieces of the rectangle do not fit; -1: no memory. */
static int make_grid(maker *m, grid *g) {
  const tsolid_surface *s = m->s;
  const block *b = &m->rectangle;
  size_t p = (size_t)s->degree;
  int *strip[2], fits = 1;
  double net[4 * TSI_MAX_ORDER * TSI_MAX_ORDER];
  if (!gather_lines(m, 0, g, &strip[0]) || !gather_lines(m, 1, g, &strip[1]))
    return -1;
  g->width = (size_t)(g->n_lines[0] - 1) * p + 1;
  size_t height = (size_t)(g->n_lines[1] - 1) * p + 1;
  g->point = tsi_arena_new(m->arena, g->width * height, 4 * sizeof *g->point);
  if (!g->point)
    return -1;
  for (int j = 0; j < g->n_lines[1] - 1; j++)
    for (int i = 0, cj = 0, ci = 0; i < g->n_lines[0] - 1; i++) {
      while (i >= strip[0][ci + 1])
        ci++;
      while (j >= strip[1][cj + 1])
        cj++;
      int cell = b->cell[ci + b->n[0] * cj], side = side_of(s, cell);
      int face = s->link[cell].face;
      double x0 = g->line[0][strip[0][ci]], y0 = g->line[1][strip[1][cj]], low[2], high[2];
      const double *size = s->face_size + 2 * (size_t)face;
      to_face(size, side, g->line[0][i] - x0, g->line[1][j] - y0, low);
      to_face(size, side, g->line[0][i + 1] - x0, g->line[1][j + 1] - y0, high);
      double box[4] = {fmin(low[0], high[0]), fmax(low[0], high[0]), fmin(low[1], high[1]),
                       fmax(low[1], high[1])};
      fits = fits && face_net(s, face, box, net) && put_piece(m, g, net, side, i, j);
    }
  return fits;
}

/* ---- smoothness --------------------------------------------------------------------------------
 */

/* Largest k <= degree - 1 so that the grid is C^k across line i of an axis. */
static int find_smoothness(const maker *m, const grid *g, int axis, int i) {
  int p = m->s->degree;
  size_t step = axis ? g->width : 1, across = axis ? 1 : g->width;
  size_t n_rows = axis ? g->width : (size_t)(g->n_lines[1] - 1) * (size_t)p + 1;
  const double *line = g->line[axis];
  double left = line[i] - line[i - 1], right = line[i + 1] - line[i], least = fmin(left, right);
  for (int k = 1; k < p; k++)
    for (size_t row = 0; row < n_rows; row++)
      for (size_t d = 0; d < 4; d++) {
        const double *middle = g->point + 4 * (row * across + (size_t)(i * p) * step) + d;
        double a = 0.0, b = 0.0;
        for (int c = 0; c <= k; c++) {
          double binomial = tsi_binomial(k, c) * (c & 1 ? -1.0 : 1.0);
          a += binomial * *(middle - 4 * (size_t)c * step);
          b += binomial * middle[4 * (size_t)c * step] * (k & 1 ? -1.0 : 1.0);
        }
        a *= pow(least / left, k);
        b *= pow(least / right, k);
        if (fabs(a - b) > same_point * m->scale * (1 << k))
          return k - 1;
      }
  return p - 1;
}

/* ---- to B-splines ------------------------------------------------------------------------------
 */

typedef struct basis {
  int n_control;
  double *knot; /* n_control + degree + 1 */
  int *line_of; /* per knot: its line */
} basis;

/* Knots over lines first .. last of an axis with the multiplicities degree - smooth. */
static int make_basis(maker *m, const grid *g, int axis, int first, int last, const int *smooth,
                      basis *b) {
  int p = m->s->degree, n = 0;
  size_t most = (size_t)(last - first + 1) * (size_t)(p + 1);
  b->knot = tsi_arena_new(&m->file->arena, most, sizeof *b->knot);
  b->line_of = tsi_arena_new(m->arena, most, sizeof *b->line_of);
  if (!b->knot || !b->line_of)
    return 0;
  for (int i = first; i <= last; i++) {
    int multiplicity = i == first || i == last ? p + 1 : p - (smooth ? smooth[i] : 0);
    for (; multiplicity > 0; multiplicity--) {
      b->knot[n] = g->line[axis][i] - g->line[axis][first];
      b->line_of[n++] = i;
    }
  }
  b->n_control = n - p - 1;
  return 1;
}

/* f(x_1, .., x_p) of the Bezier points at `from`, 4 numbers each, `step` apart, on [low, high]. */
static void take_blossom(int p, const double *from, size_t step, double low, double high,
                         const double *x, double out[4]) {
  double c[4 * TSI_MAX_ORDER];
  for (int i = 0; i <= p; i++)
    memcpy(c + 4 * i, from + 4 * step * (size_t)i, 4 * sizeof *c);
  for (int r = 1; r <= p; r++) {
    double t = (x[r - 1] - low) / (high - low);
    for (int i = 0; i <= p - r; i++)
      for (int d = 0; d < 4; d++)
        c[4 * i + d] = t == 0.0   ? c[4 * i + d]
                       : t == 1.0 ? c[4 * i + 4 + d]
                                  : (1.0 - t) * c[4 * i + d] + t * c[4 * i + 4 + d];
  }
  memcpy(out, c, 4 * sizeof *out);
}

/* Control points along one axis for one row of Bezier points that starts at line `first`. */
static void convert_row(const maker *m, const basis *b, int first, int last, const double *from,
                        size_t step, double *to, size_t to_step) {
  int p = m->s->degree;
  for (int c = 0; c < b->n_control; c++) {
    const double *x = b->knot + c + 1;
    int low = b->line_of[c + 1], high = b->line_of[c + p], best = low < last ? low : last - 1;
    double longest = -1.0, ends[2] = {0.0, 0.0};
    for (int i = c; i <= c + p; i++) { /* spans between the knots, or next to a single one */
      int line = b->line_of[i];
      if (b->line_of[i + 1] == line || (low < high && (line < low || line >= high)))
        continue;
      if (b->knot[i + 1] - b->knot[i] > longest) {
        longest = b->knot[i + 1] - b->knot[i];
        best = line;
        ends[0] = b->knot[i];
        ends[1] = b->knot[i + 1];
      }
    }
    take_blossom(p, from + 4 * step * (size_t)((best - first) * p), step, ends[0], ends[1], x,
                 to + 4 * to_step * (size_t)c);
  }
}

/* Whether the B-spline gives the grid back. */
static int comes_back(const maker *m, const grid *g, const int range[4], const basis b[2],
                      const double *control) {
  int p = m->s->degree;
  tsi_patch patch = {.degree = {p, p},
                     .n = {b[0].n_control, b[1].n_control},
                     .knots = {b[0].knot, b[1].knot},
                     .control = (double *)(uintptr_t)control};
  double net[2][TSI_MAX_ORDER];
  for (int j = range[2]; j < range[3]; j++)
    for (int i = range[0]; i < range[1]; i++)
      for (int k = 0; k < (p + 1) * (p + 1); k++) {
        double x = (0.5 + k % (p + 1)) / (p + 1), y = (0.5 + k / (p + 1)) / (p + 1);
        double point[4], h[4] = {0.0, 0.0, 0.0, 0.0};
        const double *lu = g->line[0], *lv = g->line[1];
        tsi_patch_evaluate(&patch, lu[i] - lu[range[0]] + x * (lu[i + 1] - lu[i]),
                           lv[j] - lv[range[2]] + y * (lv[j + 1] - lv[j]), point, NULL);
        tsi_bernstein(p, x, net[0]);
        tsi_bernstein(p, y, net[1]);
        for (size_t r = 0; r < (size_t)((p + 1) * (p + 1)); r++) {
          size_t a = r % (size_t)(p + 1), c = r / (size_t)(p + 1);
          const double *from =
              g->point + 4 * ((size_t)(i * p) + a + g->width * ((size_t)(j * p) + c));
          for (int d = 0; d < 4; d++)
            h[d] += net[0][a] * net[1][c] * from[d];
        }
        for (int d = 0; d < 4; d++)
          if (fabs(h[d] - point[d]) > 4.0 * same_point * m->scale)
            return 0;
      }
  return 1;
}

/* ---- patches -----------------------------------------------------------------------------------
 */

/* Euclidean points; weights only where they say something. */
static int set_points(maker *m, tsolid_patch *patch, const double *control) {
  size_t n = (size_t)patch->n_control[0] * (size_t)patch->n_control[1];
  double *points = tsi_arena_new(&m->file->arena, n, 3 * sizeof *points), *weights = NULL;
  int rational = 0;
  if (!points)
    return 0;
  for (size_t k = 0; k < n; k++) {
    rational |= fabs(control[4 * k + 3] - 1.0) > same_point;
    for (size_t d = 0; d < 3; d++)
      points[3 * k + d] = control[4 * k + d] / control[4 * k + 3];
  }
  if (rational) {
    weights = tsi_arena_new(&m->file->arena, n, sizeof *weights);
    if (!weights)
      return 0;
    for (size_t k = 0; k < n; k++)
      weights[k] = control[4 * k + 3];
  }
  patch->points = points;
  patch->weights = weights;
  return 1;
}

/* One patch on lines range[0..1] x range[2..3] of the grid; smooth NULL: full multiplicity.
 * 1: made, 0: does not come back, -1: no memory. */
static int convert(maker *m, const grid *g, const int range[4], int *const smooth[2],
                   tsolid_patch *patch) {
  basis b[2];
  size_t p = (size_t)m->s->degree;
  for (int d = 0; d < 2; d++)
    if (!make_basis(m, g, d, range[2 * d], range[2 * d + 1], smooth ? smooth[d] : NULL, &b[d]))
      return -1;
  size_t n0 = (size_t)b[0].n_control, n1 = (size_t)b[1].n_control;
  size_t height = (size_t)(range[3] - range[2]) * p + 1;
  double *half = tsi_arena_new(m->arena, n0 * height, 4 * sizeof *half);
  double *control = tsi_arena_new(m->arena, n0 * n1, 4 * sizeof *control);
  if (!half || !control)
    return -1;
  for (size_t j = 0; j < height; j++)
    convert_row(m, &b[0], range[0], range[1],
                g->point + 4 * ((size_t)range[0] * p + g->width * ((size_t)range[2] * p + j)), 1,
                half + 4 * n0 * j, 1);
  for (size_t i = 0; i < n0; i++)
    convert_row(m, &b[1], range[2], range[3], half + 4 * i, n0, control + 4 * i, n0);
  if (smooth) {
    for (size_t k = 0; k < n0 * n1; k++)
      if (!(control[4 * k + 3] > 0.0))
        return 0;
    if (!comes_back(m, g, range, b, control))
      return 0;
  }
  *patch = (tsolid_patch){.degree = {(int)p, (int)p},
                          .n_control = {b[0].n_control, b[1].n_control},
                          .knots = {b[0].knot, b[1].knot}};
  return set_points(m, patch, control) ? 1 : -1;
}

static int add_patch(maker *m, const grid *g, const int range[4], int *const smooth[2]) {
  tsolid_patch *patch = &m->patch[m->n_patches];
  int made = convert(m, g, range, smooth, patch);
  if (made == 0)
    made = convert(m, g, range, NULL, patch);
  m->n_patches += made == 1;
  return made == 1;
}

/* All patches of the rectangle: it is divided where it is only C^0. */
static int add_patches(maker *m, const grid *g) {
  int *smooth[2], range[4];
  for (int d = 0; d < 2; d++) {
    smooth[d] = tsi_arena_new(m->arena, (size_t)g->n_lines[d], sizeof **smooth);
    if (!smooth[d])
      return 0;
    for (int i = 1; i + 1 < g->n_lines[d]; i++)
      smooth[d][i] = find_smoothness(m, g, d, i);
  }
  for (range[2] = 0; range[2] + 1 < g->n_lines[1]; range[2] = range[3]) {
    for (range[3] = range[2] + 1; range[3] + 1 < g->n_lines[1] && smooth[1][range[3]] > 0;)
      range[3]++;
    for (range[0] = 0; range[0] + 1 < g->n_lines[0]; range[0] = range[1]) {
      for (range[1] = range[0] + 1; range[1] + 1 < g->n_lines[0] && smooth[0][range[1]] > 0;)
        range[1]++;
      if (!add_patch(m, g, range, smooth))
        return 0;
    }
  }
  return 1;
}

/* The faces of a rectangle whose pieces do not fit, one by one. */
static int add_single(maker *m) {
  int n = m->rectangle.n[0] * m->rectangle.n[1];
  int *cells = tsi_arena_new(m->arena, (size_t)n, sizeof *cells);
  if (!cells)
    return 0;
  memcpy(cells, m->rectangle.cell, (size_t)n * sizeof *cells);
  m->rectangle.n[0] = m->rectangle.n[1] = 1;
  for (int k = 0; k < n; k++) {
    grid g;
    m->rectangle.cell[0] = cells[k];
    int made = make_grid(m, &g);
    if (made == 0) {
      tsi_fail(m->context, TSOLID_ERROR_INTERNAL, stage,
               "The elements of face %d do not fit together", m->s->link[cells[k]].face);
      return -1;
    }
    if (made < 0 || !add_patches(m, &g))
      return 0;
  }
  return 1;
}

static int has_area(const tsolid_surface *s, int face) {
  return s->element_start[face] < s->element_start[face + 1];
}

static int make_patches(maker *m) {
  const tsolid_surface *s = m->s;
  for (int f = 0; f < s->n_faces; f++)
    m->used[f] = !has_area(s, f);
  for (int f = 0; f < s->n_faces; f++) {
    tsi_arena temporary = tsi_arena_create(m->context);
    grid g;
    int made;
    if (m->used[f])
      continue;
    m->arena = &temporary;
    grow(m, f);
    made = make_grid(m, &g);
    if (made == 0)
      made = add_single(m);
    else if (made == 1)
      made = add_patches(m, &g);
    tsi_arena_free(&temporary);
    if (made != 1)
      return made < 0 && m->context->n_findings ? -1 : 0;
  }
  return 1;
}

static double find_scale(const tsolid_surface *s) {
  double scale = 0.0;
  for (size_t k = 0; k < 4 * (size_t)s->n_points; k++)
    scale = fmax(scale, fabs(s->points[k]));
  return scale;
}

tsolid_status tsolid_surface_patches(tsolid_context *context, const tsolid_surface *surface,
                                     tsolid_boundary_file **patches) {
  if (patches)
    *patches = NULL;
  if (!context || !surface || !patches)
    return TSOLID_ERROR_ARGUMENT;
  tsolid_status status = TSOLID_OK;
  tsi_arena arena = tsi_arena_create(context);
  size_t n = (size_t)surface->n_faces, n_elements = (size_t)surface->element_start[n];
  maker m = {.context = context, .s = surface, .scale = find_scale(surface)};
  m.file = tsi_boundary_file_new(context);
  m.used = tsi_arena_new(&arena, n, 1);
  m.rectangle.cell = tsi_arena_new(&arena, n, sizeof *m.rectangle.cell);
  m.spare = tsi_arena_new(&arena, n, sizeof *m.spare);
  m.patch = m.file ? tsi_arena_new(&m.file->arena, n_elements, sizeof *m.patch) : NULL;
  int n_findings = context->n_findings;
  if (!m.used || !m.rectangle.cell || !m.spare || !m.patch || make_patches(&m) != 1) {
    status =
        context->n_findings > n_findings ? TSOLID_ERROR_INTERNAL : tsi_no_memory(context, stage);
    goto done;
  }
  m.file->input.patches = m.patch;
  m.file->input.n_patches = m.n_patches;
  *patches = m.file;
  m.file = NULL;
done:
  tsi_arena_free(&arena);
  tsolid_boundary_file_free(m.file);
  return status;
}
