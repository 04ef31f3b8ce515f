/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Sides that are no tensor grids: the traces of truncated hierarchical B-splines on a cube.
 *
 * Level l has n << l spans per axis; region l, a box of cells of level l - 1, is where level l is
 * taken. A function of level l is active when its support lies in region l but not in region l + 1;
 * expressed on finer levels, it loses what active functions there do (truncation): so the functions
 * are non-negative, independent and sum to one. They are C^0 at the isolines. */
#ifndef TSOLID_TEST_LOCAL_PART_H
#define TSOLID_TEST_LOCAL_PART_H

#include "cube_part.h"

enum { LOCAL_LEVELS = 7, LOCAL_MOST = 80 };

typedef struct local_region {
  int lo[3], hi[3];
} local_region;

typedef struct local_entry {
  int element, function;
  size_t coefficient;
} local_entry;

typedef struct local_part {
  int degree, n, n_levels;
  local_region region[LOCAL_LEVELS]; /* region[0] is not looked at */
  double *knot[LOCAL_LEVELS];
  double *finer[LOCAL_LEVELS]; /* m_l x m_(l+1): level l by level l + 1 */
  int *id[LOCAL_LEVELS];
  int n_functions;
  double *points;
  tsolid_bezier_boundary boundary;
  /* the side being made */
  int side, n_entries, capacity;
  local_entry *entry;
  double *coefficient;
} local_part;

static inline int local_spans(const local_part *p, int level) {
  return p->n << level;
}

static inline int local_count(const local_part *p, int level) {
  return local_spans(p, level) + p->degree;
}

/* Breaks that are not uniform, the same for all levels. */
static inline double local_break(const local_part *p, int level, int i) {
  double x = (double)i / local_spans(p, level);
  return i == 0 || i == local_spans(p, level) ? x : x + 0.15 * x * (1.0 - x);
}

/* Boehm's insertion of the middle of every span, on the rows of the identity. */
static inline void local_refine(local_part *p, int level) {
  int m = local_count(p, level), fine = local_count(p, level + 1), q = p->degree;
  double *knot = calloc((size_t)(fine + q + 1), sizeof *knot);
  double *a = calloc((size_t)(m * fine), sizeof *a);
  memcpy(knot, p->knot[level], (size_t)(m + q + 1) * sizeof *knot);
  for (int i = 0; i < m; i++)
    a[i * fine + i] = 1.0;
  for (int span = 0, n = m; span < local_spans(p, level); span++, n++) {
    double x = local_break(p, level + 1, 2 * span + 1);
    int at = q;
    while (knot[at + 1] <= x)
      at++;
    for (int i = 0; i < m; i++) {
      double *row = a + i * fine;
      for (int j = n; j > at - q; j--) {
        double f = j <= at ? (x - knot[j]) / (knot[j + q] - knot[j]) : 0.0;
        row[j] = f * row[j] + (1.0 - f) * row[j - 1];
      }
    }
    memmove(knot + at + 2, knot + at + 1, (size_t)(n + q - at) * sizeof *knot);
    knot[at + 1] = x;
  }
  free(knot);
  p->finer[level] = a;
}

/* Does the support of a function lie in the region of a level (its own or the next)? */
static inline int local_inside(const local_part *p, int level, const int i[3], int region) {
  for (int d = 0; d < 3; d++) {
    int low = i[d] - p->degree < 0 ? 0 : i[d] - p->degree;
    int high = i[d] + 1 > local_spans(p, level) ? local_spans(p, level) : i[d] + 1;
    int step = region == level ? 2 : 1; /* the region is in cells of the level below */
    if (region >= p->n_levels || low < step * p->region[region].lo[d] ||
        high > step * p->region[region].hi[d])
      return 0;
  }
  return 1;
}

static inline int local_active(const local_part *p, int level, const int i[3]) {
  return (level == 0 || local_inside(p, level, i, level)) && !local_inside(p, level, i, level + 1);
}

/* Is a cell of a level taken at this level? */
static inline int local_cell(const local_part *p, int level, const int c[3]) {
  int own = 1, finer = level + 1 < p->n_levels;
  for (int d = 0; d < 3; d++) {
    own &= level == 0 || (c[d] >= 2 * p->region[level].lo[d] && c[d] < 2 * p->region[level].hi[d]);
    if (level + 1 < p->n_levels)
      finer &= c[d] >= p->region[level + 1].lo[d] && c[d] < p->region[level + 1].hi[d];
  }
  return own && !finer;
}

static inline void local_number(local_part *p, cube_map map) {
  for (int pass = 0; pass < 2; pass++) {
    p->n_functions = 0;
    for (int l = 0; l < p->n_levels; l++) {
      int m = local_count(p, l);
      for (int g = 0; g < m * m * m; g++) {
        int i[3] = {g % m, g / m % m, g / (m * m)}, on = 0;
        for (int d = 0; d < 3; d++)
          on |= i[d] == 0 || i[d] == m - 1;
        if (!on || !local_active(p, l, i))
          continue;
        p->id[l][g] = p->n_functions;
        double x[4] = {0.0, 0.0, 0.0, 1.0};
        for (int d = 0; d < 3; d++)
          for (int k = 1; k <= p->degree; k++)
            x[d] += p->knot[l][i[d] + k] / p->degree;
        if (map)
          map(x);
        for (int c = 0; c < 4 && pass; c++)
          p->points[4 * p->n_functions + c] = c < 3 ? x[c] * x[3] : x[3];
        p->n_functions++;
      }
    }
    if (!pass)
      p->points = calloc((size_t)p->n_functions, 4 * sizeof *p->points);
  }
}

static inline void local_place(const local_part *p, int level, int j, int k, int i[3]) {
  i[p->side / 2] = p->side & 1 ? local_count(p, level) - 1 : 0;
  i[tsi_side_s(p->side)] = j;
  i[tsi_side_t(p->side)] = k;
}

/* Bernstein coefficients of sum c_jk N_j N_k on a cell of a level, if not all are zero. */
static inline void local_add(local_part *p, int level, int element, int s, int t, int function,
                             const double *c) {
  int q = p->degree, n = q + 1, m = local_count(p, level), any = 0;
  double row[2][TSI_MAX_ORDER][TSI_MAX_ORDER];
  for (int j = 0; j <= q; j++)
    for (int k = 0; k <= q; k++)
      any |= c[s + j + m * (t + k)] != 0.0;
  if (!any)
    return;
  if (p->n_entries == p->capacity) {
    p->capacity = p->capacity ? 2 * p->capacity : 1024;
    p->entry = realloc(p->entry, (size_t)p->capacity * sizeof *p->entry);
    p->coefficient =
        realloc(p->coefficient, (size_t)p->capacity * (size_t)(n * n) * sizeof *p->coefficient);
  }
  double *out = p->coefficient + (size_t)p->n_entries * (size_t)(n * n);
  memset(out, 0, (size_t)(n * n) * sizeof *out);
  for (int j = 0; j <= q; j++) {
    tsi_bspline_bernstein(q, p->knot[level] + s + j, local_break(p, level, s),
                          local_break(p, level, s + 1), row[0][j]);
    tsi_bspline_bernstein(q, p->knot[level] + t + j, local_break(p, level, t),
                          local_break(p, level, t + 1), row[1][j]);
  }
  for (int j = 0; j <= q; j++)
    for (int k = 0; k <= q; k++)
      for (int b = 0; b < n * n; b++)
        out[b] += c[s + j + m * (t + k)] * row[0][j][b % n] * row[1][k][b / n];
  p->entry[p->n_entries] = (local_entry){element, function, (size_t)p->n_entries};
  p->n_entries++;
}

/* Follows one function through its level and the finer ones; element: number of every cell. */
static inline void local_follow(local_part *p, int level, int j, int k, int function,
                                int *const element[LOCAL_LEVELS]) {
  static double c[LOCAL_MOST * LOCAL_MOST], half[LOCAL_MOST * LOCAL_MOST];
  int m = local_count(p, level), q = p->degree;
  int low[2] = {j, k}, high[2] = {j, k}; /* range of coefficients that are not zero */
  memset(c, 0, sizeof c);
  c[j + m * k] = 1.0;
  for (int l = level;; l++) {
    int n = local_spans(p, l), place[3];
    for (int t = low[1] - q < 0 ? 0 : low[1] - q; t <= high[1] && t < n; t++)
      for (int s = low[0] - q < 0 ? 0 : low[0] - q; s <= high[0] && s < n; s++)
        if (element[l][s + n * t] >= 0)
          local_add(p, l, element[l][s + n * t], s, t, function, c);
    if (l + 1 == p->n_levels)
      return;
    const double *a = p->finer[l];
    int fine = local_count(p, l + 1), from[2], to[2];
    for (int d = 0; d < 2; d++) {
      from[d] = 2 * low[d] - q - 1 < 0 ? 0 : 2 * low[d] - q - 1;
      to[d] = 2 * high[d] + 2 > fine - 1 ? fine - 1 : 2 * high[d] + 2;
    }
    memset(half, 0, sizeof half);
    for (int b = low[1]; b <= high[1]; b++)
      for (int x = low[0]; x <= high[0]; x++)
        for (int y = from[0]; y <= to[0]; y++)
          half[y + fine * b] += a[x * fine + y] * c[x + m * b];
    memset(c, 0, sizeof c);
    for (int b = low[1]; b <= high[1]; b++)
      for (int z = from[1]; z <= to[1]; z++)
        for (int y = from[0]; y <= to[0]; y++)
          c[y + fine * z] += a[b * fine + z] * half[y + fine * b];
    m = fine;
    for (int z = from[1]; z <= to[1]; z++)
      for (int y = from[0]; y <= to[0]; y++) {
        local_place(p, l + 1, y, z, place);
        if (local_inside(p, l + 1, place, l + 1))
          c[y + m * z] = 0.0;
      }
    memcpy(low, from, sizeof low);
    memcpy(high, to, sizeof high);
  }
}

static inline int local_compare(const void *a, const void *b) {
  const local_entry *x = a, *y = b;
  if (x->element != y->element)
    return x->element < y->element ? -1 : 1;
  return (x->function > y->function) - (x->function < y->function);
}

/* Numbers the cells that are elements of the side; their boxes. */
static inline double *local_elements(const local_part *p, int *element[LOCAL_LEVELS], int *count) {
  double *box = NULL;
  int total = 0;
  for (int l = 0; l < p->n_levels; l++) {
    int n = local_spans(p, l), c[3];
    element[l] = calloc((size_t)(n * n), sizeof *element[l]);
    box = realloc(box, (size_t)(total + n * n) * 4 * sizeof *box);
    for (int g = 0; g < n * n; g++) {
      c[p->side / 2] = p->side & 1 ? n - 1 : 0;
      c[tsi_side_s(p->side)] = g % n;
      c[tsi_side_t(p->side)] = g / n;
      element[l][g] = local_cell(p, l, c) ? total : -1;
      if (element[l][g] < 0)
        continue;
      for (int k = 0; k < 4; k++)
        box[4 * total + k] = local_break(p, l, (k < 2 ? g % n : g / n) + k % 2);
      total++;
    }
  }
  *count = total;
  return box;
}

static inline void local_fill_side(local_part *p, int side) {
  int *element[LOCAL_LEVELS], n_elements, q = p->degree;
  size_t width = (size_t)(q + 1) * (size_t)(q + 1);
  p->side = side;
  p->n_entries = 0;
  double *box = local_elements(p, element, &n_elements);
  for (int l = 0; l < p->n_levels; l++) {
    int m = local_count(p, l), i[3];
    for (int g = 0; g < m * m; g++) {
      local_place(p, l, g % m, g / m, i);
      if (local_active(p, l, i))
        local_follow(p, l, g % m, g / m, p->id[l][i[0] + m * (i[1] + m * i[2])], element);
    }
    free(element[l]);
  }
  for (int l = 0; l < p->n_levels; l++)
    element[l] = NULL;
  qsort(p->entry, (size_t)p->n_entries, sizeof *p->entry, local_compare);
  int *start = calloc((size_t)n_elements + 1, sizeof *start);
  int *function = calloc((size_t)p->n_entries, sizeof *function);
  double *coefficient = calloc((size_t)p->n_entries * width, sizeof *coefficient);
  for (int k = 0; k < p->n_entries; k++) {
    start[p->entry[k].element + 1] = k + 1;
    function[k] = p->entry[k].function;
    memcpy(coefficient + (size_t)k * width, p->coefficient + p->entry[k].coefficient * width,
           width * sizeof *coefficient);
  }
  p->boundary.side[side] =
      (tsolid_bezier_side){{q, q}, n_elements, box, start, function, coefficient};
}

/* region[1] .. region[n_levels - 1]; (n << levels) + degree must stay below LOCAL_MOST. */
static inline local_part local_part_create(int degree, int n, int n_levels,
                                           const local_region *region, cube_map map) {
  local_part p = {.degree = degree, .n = n, .n_levels = n_levels};
  for (int l = 0; l < n_levels; l++) {
    int m = local_count(&p, l);
    p.region[l] = region[l];
    p.knot[l] = calloc((size_t)(m + degree + 1), sizeof(double));
    for (int i = 0; i < m + degree + 1; i++) {
      int at = i - degree < 0 ? 0 : i - degree;
      p.knot[l][i] = local_break(&p, l, at > local_spans(&p, l) ? local_spans(&p, l) : at);
    }
    p.id[l] = calloc((size_t)(m * m) * (size_t)m, sizeof(int));
  }
  for (int l = 0; l + 1 < n_levels; l++)
    local_refine(&p, l);
  local_number(&p, map);
  p.boundary.n_functions = p.n_functions;
  p.boundary.points = p.points;
  for (int side = 0; side < 6; side++)
    local_fill_side(&p, side);
  return p;
}

static inline void local_part_free(local_part *p) {
  for (int side = 0; side < 6; side++) {
    const tsolid_bezier_side *s = &p->boundary.side[side];
    const void *owned[] = {s->box, s->function_start, s->function, s->coefficient};
    for (int k = 0; k < 4; k++)
      free((void *)(uintptr_t)owned[k]);
  }
  for (int l = 0; l < p->n_levels; l++) {
    free(p->knot[l]);
    free(p->id[l]);
    free(p->finer[l]);
  }
  free(p->points);
  free(p->entry);
  free(p->coefficient);
}

#endif
