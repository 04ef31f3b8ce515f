/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Locally optimal conjugate gradients (Knyazev, 2001) for the smallest eigenvalue. Mass matrices
 * are well conditioned whatever their size, so blocks of strongly coupled unknowns precondition
 * well: some 100 steps for cubics in 3D. Where the sparse Cholesky factor is cheap, or the degree
 * is high, the factor itself is the preconditioner and a few steps do. Ordering and analysis are
 * CXSparse's; the numeric part is here because a pivot that is not positive is an answer, not a
 * failure. */
#include "rank.h"

#include <stdlib.h>
#include <suitesparse/cs.h>

static const char *const STAGE = "report";

enum { BLOCK_SIZE = 128, MAX_STEPS = 500, REFRESH_STEPS = 20 };

/* Flops up to which the sparse factor is preferred: about a tenth of a second. */
#define DIRECT_FLOPS 1.5e8
/* The residual, relative to the eigenvalue, at which it is settled to about three digits. */
#define SETTLED 1e-2

/* ---- assembly ----------------------------------------------------------------------------------
 */

typedef struct transpose {
  size_t *start; /* per unknown */
  int *element, *local;
} transpose;

static int make_transpose(const tsi_element_sum *sum, tsi_arena *arena, transpose *t) {
  size_t total = sum->start[sum->n_elements];
  t->start = tsi_arena_new(arena, (size_t)sum->n + 2, sizeof *t->start);
  t->element = tsi_arena_new(arena, total, sizeof *t->element);
  t->local = tsi_arena_new(arena, total, sizeof *t->local);
  if (!t->start || !t->element || !t->local)
    return 0;
  size_t *fill = t->start + 1; /* shifted by one: ends up as the starts */
  for (size_t i = 0; i < total; i++)
    fill[sum->unknown[i] + 1]++;
  for (int i = 0; i < sum->n; i++)
    fill[i + 1] += fill[i];
  for (int e = 0; e < sum->n_elements; e++)
    for (size_t i = sum->start[e]; i < sum->start[e + 1]; i++) {
      size_t at = fill[sum->unknown[i]]++;
      t->element[at] = e;
      t->local[at] = (int)(i - sum->start[e]);
    }
  return 1;
}

static int compare_int(const void *a, const void *b) {
  int p = *(const int *)a, q = *(const int *)b;
  return (p > q) - (p < q);
}

typedef struct row_work {
  int *mark; /* last row that touched a column, plus one */
  int *touched;
  double *sum, *local;
} row_work;

/* Columns of row i into work->touched, ascending; their number. */
static int find_columns(const tsi_element_sum *sum, const transpose *t, int i, row_work *work) {
  int n = 0;
  for (size_t k = t->start[i]; k < t->start[i + 1]; k++) {
    int e = t->element[k];
    for (size_t at = sum->start[e]; at < sum->start[e + 1]; at++) {
      int j = sum->unknown[at];
      if (work->mark[j] != i + 1) {
        work->mark[j] = i + 1;
        work->touched[n++] = j;
      }
    }
  }
  qsort(work->touched, (size_t)n, sizeof *work->touched, compare_int);
  return n;
}

static void fill_row(const tsi_element_sum *sum, const transpose *t, int i, row_work *work,
                     tsi_symmetric *matrix) {
  for (size_t k = matrix->start[i]; k < matrix->start[i + 1]; k++)
    work->sum[matrix->column[k]] = 0.0;
  for (size_t k = t->start[i]; k < t->start[i + 1]; k++) {
    int e = t->element[k];
    sum->row(sum->data, e, t->local[k], work->local);
    for (size_t at = sum->start[e]; at < sum->start[e + 1]; at++)
      work->sum[sum->unknown[at]] += work->local[at - sum->start[e]];
  }
  for (size_t k = matrix->start[i]; k < matrix->start[i + 1]; k++)
    matrix->value[k] = work->sum[matrix->column[k]];
}

tsolid_status tsi_symmetric_assemble(tsolid_context *context, const tsi_element_sum *sum,
                                     tsi_arena *arena, tsi_symmetric *matrix) {
  tsolid_status status = TSOLID_ERROR_MEMORY;
  tsi_arena temporary = tsi_arena_create(context);
  size_t n = (size_t)sum->n, largest = 0;
  transpose t;
  for (int e = 0; e < sum->n_elements; e++)
    largest =
        sum->start[e + 1] - sum->start[e] > largest ? sum->start[e + 1] - sum->start[e] : largest;
  row_work work = {.mark = tsi_arena_new(&temporary, n, sizeof(int)),
                   .touched = tsi_arena_new(&temporary, n, sizeof(int)),
                   .sum = tsi_arena_new(&temporary, n, sizeof(double)),
                   .local = tsi_arena_new(&temporary, largest, sizeof(double))};
  *matrix = (tsi_symmetric){.n = sum->n, .start = tsi_arena_new(arena, n + 1, sizeof(size_t))};
  if (!work.mark || !work.touched || !work.sum || !work.local || !matrix->start ||
      !make_transpose(sum, &temporary, &t))
    goto done;
  for (int i = 0; i < sum->n; i++)
    matrix->start[i + 1] = matrix->start[i] + (size_t)find_columns(sum, &t, i, &work);
  matrix->column = tsi_arena_new(arena, matrix->start[n], sizeof(int));
  matrix->value = tsi_arena_new(arena, matrix->start[n], sizeof(double));
  if (!matrix->column || !matrix->value)
    goto done;
  memset(work.mark, 0, n * sizeof *work.mark);
  for (int i = 0; i < sum->n; i++) {
    int count = find_columns(sum, &t, i, &work);
    memcpy(matrix->column + matrix->start[i], work.touched, (size_t)count * sizeof(int));
    fill_row(sum, &t, i, &work, matrix);
  }
  status = TSOLID_OK;
done:
  tsi_arena_free(&temporary);
  return status == TSOLID_OK ? status : tsi_no_memory(context, STAGE);
}

/* ---- vectors -----------------------------------------------------------------------------------
 */

static double dot(int n, const double *a, const double *b) {
  enum { CHUNK = 256 };
  double total = 0.0;
  for (int first = 0; first < n; first += CHUNK) {
    int end = n - first < CHUNK ? n : first + CHUNK;
    double sum = 0.0;
    for (int i = first; i < end; i++)
      sum += a[i] * b[i];
    total += sum;
  }
  return total;
}

static void add_scaled(int n, double factor, const double *x, double *y) {
  for (int i = 0; i < n; i++)
    y[i] += factor * x[i];
}

static void scale_vector(int n, double factor, double *x) {
  for (int i = 0; i < n; i++)
    x[i] *= factor;
}

static void multiply(const tsi_symmetric *m, int n_threads, const double *x, double *y) {
  (void)n_threads; /* rows do not depend on each other, nor on who computes them */
#ifdef _OPENMP
#pragma omp parallel for num_threads(n_threads) schedule(static) if (m->n > 1000)
#endif
  for (int i = 0; i < m->n; i++) {
    double sum = 0.0;
    for (size_t k = m->start[i]; k < m->start[i + 1]; k++)
      sum += m->value[k] * x[m->column[k]];
    y[i] = sum;
  }
}

/* ---- the sparse factor -------------------------------------------------------------------------
 */

typedef struct factor {
  int n;
  cs_dis *symbolic; /* malloc'ed by CXSparse */
  double flops;
  size_t *start; /* columns of L, the diagonal first */
  int *row;
  double *value, *work;
} factor;

/* Lower triangle by rows == upper triangle by columns: what CXSparse takes for symmetric. */
static int analyse(const tsi_symmetric *m, tsi_arena *arena, cs_di *upper, factor *f) {
  size_t n = (size_t)m->n, count = 0;
  upper->p = tsi_arena_new(arena, n + 1, sizeof(int));
  upper->i = tsi_arena_new(arena, m->start[n], sizeof(int));
  upper->x = tsi_arena_new(arena, m->start[n], sizeof(double));
  if (!upper->p || !upper->i || !upper->x || m->start[n] > TSI_MAX_COUNT)
    return 0;
  for (int j = 0; j < m->n; j++) {
    for (size_t k = m->start[j]; k < m->start[j + 1] && m->column[k] <= j; k++, count++) {
      upper->i[count] = m->column[k];
      upper->x[count] = m->value[k];
    }
    upper->p[j + 1] = (int)count;
  }
  upper->n = upper->m = f->n = m->n;
  upper->nzmax = (int)count;
  upper->nz = -1;
  f->symbolic = cs_di_schol(1, upper);
  f->flops = 0.0;
  for (int i = 0; f->symbolic && i < m->n; i++) {
    double length = (double)f->symbolic->cp[i + 1] - (double)f->symbolic->cp[i];
    f->flops += length * length;
  }
  return f->symbolic != NULL;
}

/* Row k of L by a sparse triangular solve (Davis, Direct methods for sparse linear systems, 4.8).
 * Returns the pivot, of which the square root is the diagonal. */
static double factor_row(factor *f, const cs_di *c, int k, int *stack, int *mark, size_t *fill) {
  int top = cs_di_ereach(c, k, f->symbolic->parent, stack, mark);
  double *x = f->work;
  x[k] = 0.0;
  for (int p = c->p[k]; p < c->p[k + 1]; p++)
    if (c->i[p] <= k)
      x[c->i[p]] = c->x[p];
  double pivot = x[k];
  x[k] = 0.0;
  for (; top < f->n; top++) {
    int i = stack[top];
    double value = x[i] / f->value[f->start[i]];
    x[i] = 0.0;
    for (size_t p = f->start[i] + 1; p < fill[i]; p++)
      x[f->row[p]] -= f->value[p] * value;
    pivot -= value * value;
    f->row[fill[i]] = k;
    f->value[fill[i]++] = value;
  }
  return pivot;
}

/* *positive = 0 when a pivot is not. 0: no memory. */
static int factorise(factor *f, const cs_di *upper, tsi_arena *arena, int *positive) {
  size_t n = (size_t)f->n, size = 0;
  cs_di *c = cs_di_symperm(upper, f->symbolic->pinv, 1);
  f->start = tsi_arena_new(arena, n + 1, sizeof *f->start);
  size_t *fill = tsi_arena_new(arena, n, sizeof *fill);
  int *stack = tsi_arena_new(arena, n, sizeof *stack),
      *mark = tsi_arena_new(arena, n, sizeof *mark);
  f->work = tsi_arena_new(arena, n, sizeof *f->work);
  int complete = c && f->start && fill && stack && mark && f->work;
  for (size_t i = 0; complete && i < n; i++) {
    f->start[i] = fill[i] = size;
    size += (size_t)(f->symbolic->cp[i + 1] - f->symbolic->cp[i]);
  }
  if (complete) {
    f->start[n] = size;
    f->row = tsi_arena_new(arena, size, sizeof *f->row);
    f->value = tsi_arena_new(arena, size, sizeof *f->value);
    complete = f->row && f->value;
  }
  *positive = 1;
  for (int k = 0; complete && *positive && k < f->n; k++) {
    double pivot = factor_row(f, c, k, stack, mark, fill);
    *positive = pivot > 0.0;
    f->row[fill[k]] = k;
    f->value[fill[k]++] = sqrt(fmax(pivot, 0.0));
  }
  cs_di_spfree(c);
  return complete;
}

static void solve_factor(const factor *f, const double *b, double *out) {
  double *x = f->work;
  for (int i = 0; i < f->n; i++)
    x[f->symbolic->pinv[i]] = b[i];
  for (int j = 0; j < f->n; j++) {
    x[j] /= f->value[f->start[j]];
    for (size_t p = f->start[j] + 1; p < f->start[j + 1]; p++)
      x[f->row[p]] -= f->value[p] * x[j];
  }
  for (int j = f->n - 1; j >= 0; j--) {
    for (size_t p = f->start[j] + 1; p < f->start[j + 1]; p++)
      x[j] -= f->value[p] * x[f->row[p]];
    x[j] /= f->value[f->start[j]];
  }
  for (int i = 0; i < f->n; i++)
    out[i] = x[f->symbolic->pinv[i]];
}

/* ---- blocks ------------------------------------------------------------------------------------
 */

typedef struct blocks {
  int n_blocks;
  int *start, *unknown; /* block b: unknown[start[b] .. start[b+1]-1] */
  double *factor;       /* BLOCK_SIZE^2 per block: L by rows */
} blocks;

/* Grows each block by the free unknown that is coupled most strongly to what is in it already. */
static int choose_blocks(const tsi_symmetric *m, tsi_arena *arena, blocks *b) {
  size_t n = (size_t)m->n;
  int *taken = tsi_arena_new(arena, n, sizeof *taken),
      *near = tsi_arena_new(arena, n, sizeof *near);
  double *coupling = tsi_arena_new(arena, n, sizeof *coupling);
  b->start = tsi_arena_new(arena, n + 1, sizeof *b->start);
  b->unknown = tsi_arena_new(arena, n, sizeof *b->unknown);
  if (!taken || !near || !coupling || !b->start || !b->unknown)
    return 0;
  int count = 0;
  for (int seed = 0; seed < m->n; seed++) {
    if (taken[seed])
      continue;
    int n_near = 0, next = seed;
    b->start[b->n_blocks++] = count;
    while (next >= 0 && count - b->start[b->n_blocks - 1] < BLOCK_SIZE) {
      b->unknown[count++] = next;
      taken[next] = 1;
      for (size_t k = m->start[next]; k < m->start[next + 1]; k++) {
        int j = m->column[k];
        if (coupling[j] == 0.0)
          near[n_near++] = j;
        coupling[j] += fabs(m->value[k]) + 1e-300; /* never back to zero: listed once */
      }
      next = -1;
      for (int k = 0; k < n_near; k++)
        if (!taken[near[k]] && (next < 0 || coupling[near[k]] > coupling[next]))
          next = near[k];
    }
    for (int k = 0; k < n_near; k++)
      coupling[near[k]] = 0.0;
  }
  b->start[b->n_blocks] = count;
  return 1;
}

/* 0: a pivot is not positive. */
static int factor_block(int n, double *a) {
  for (int i = 0; i < n; i++) {
    double *row = a + (size_t)i * BLOCK_SIZE;
    for (int j = 0; j < i; j++) {
      const double *other = a + (size_t)j * BLOCK_SIZE;
      row[j] = (row[j] - dot(j, row, other)) / other[j];
    }
    double pivot = row[i] - dot(i, row, row);
    if (!(pivot > 0.0))
      return 0;
    row[i] = sqrt(pivot);
  }
  return 1;
}

/* *positive = 0 when a diagonal block is not positive definite. 0: no memory. */
static int factor_blocks(const tsi_symmetric *m, tsi_arena *arena, blocks *b, int *positive) {
  int *position = tsi_arena_new(arena, (size_t)m->n, sizeof *position);
  if (!position || !choose_blocks(m, arena, b))
    return 0;
  size_t size = (size_t)BLOCK_SIZE * BLOCK_SIZE;
  b->factor = tsi_arena_new(arena, (size_t)b->n_blocks, size * sizeof *b->factor);
  if (!b->factor)
    return 0;
  memset(position, -1, (size_t)m->n * sizeof *position);
  *positive = 1;
  for (int k = 0; k < b->n_blocks && *positive; k++) {
    double *a = b->factor + (size_t)k * size;
    int n = b->start[k + 1] - b->start[k];
    const int *unknown = b->unknown + b->start[k];
    for (int i = 0; i < n; i++)
      position[unknown[i]] = i;
    for (int i = 0; i < n; i++)
      for (size_t p = m->start[unknown[i]]; p < m->start[unknown[i] + 1]; p++)
        if (position[m->column[p]] >= 0)
          a[(size_t)i * BLOCK_SIZE + (size_t)position[m->column[p]]] = m->value[p];
    for (int i = 0; i < n; i++)
      position[unknown[i]] = -1;
    *positive = factor_block(n, a);
  }
  return 1;
}

static void solve_blocks(const blocks *b, const double *in, double *out) {
  double x[BLOCK_SIZE];
  for (int k = 0; k < b->n_blocks; k++) {
    const double *a = b->factor + (size_t)k * BLOCK_SIZE * BLOCK_SIZE;
    const int *unknown = b->unknown + b->start[k];
    int n = b->start[k + 1] - b->start[k];
    for (int i = 0; i < n; i++)
      x[i] = (in[unknown[i]] - dot(i, a + (size_t)i * BLOCK_SIZE, x)) /
             a[(size_t)i * BLOCK_SIZE + (size_t)i];
    for (int i = n - 1; i >= 0; i--) {
      x[i] /= a[(size_t)i * BLOCK_SIZE + (size_t)i];
      for (int j = 0; j < i; j++)
        x[j] -= a[(size_t)i * BLOCK_SIZE + (size_t)j] * x[i];
      out[unknown[i]] = x[i];
    }
  }
}

/* ---- locally optimal conjugate gradients -------------------------------------------------------
 */

/* The eigenvector of the smallest eigenvalue of a symmetric n x n matrix, n <= 3, by Jacobi
 * rotations; returns the eigenvalue. */
static double smallest_of_small(int n, double a[3][3], double vector[3]) {
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int sweep = 0; sweep < 30; sweep++)
    for (int p = 0; p < n; p++)
      for (int q = p + 1; q < n; q++) {
        if (a[p][q] == 0.0)
          continue;
        double theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
        double t = (theta >= 0.0 ? 1.0 : -1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
        double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
        for (int k = 0; k < n; k++) {
          double x = a[k][p], y = a[k][q];
          a[k][p] = c * x - s * y;
          a[k][q] = s * x + c * y;
        }
        for (int k = 0; k < n; k++) {
          double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y;
          a[q][k] = s * x + c * y;
          x = v[k][p];
          y = v[k][q];
          v[k][p] = c * x - s * y;
          v[k][q] = s * x + c * y;
        }
        a[p][q] = a[q][p] = 0.0;
      }
  int least = 0;
  for (int k = 1; k < n; k++)
    if (a[k][k] < a[least][least])
      least = k;
  for (int k = 0; k < n; k++)
    vector[k] = v[k][least];
  return a[least][least];
}

typedef struct eigen_search {
  const tsi_symmetric *matrix;
  int n_threads;
  const factor *factor; /* one of the two */
  const blocks *blocks;
  double *vector[3],
      *image[3]; /* x, the preconditioned residual, the last direction; M times them */
  double *residual;
  double eigenvalue, residual_norm;
} eigen_search;

/* Makes vector k of unit length and orthogonal to those before it; 0: nothing is left of it. */
static int orthonormalise(eigen_search *s, int k) {
  int n = s->matrix->n;
  for (int twice = 0; twice < 2; twice++) {
    double before = sqrt(dot(n, s->vector[k], s->vector[k]));
    if (!(before > 0.0) || !isfinite(before))
      return 0;
    scale_vector(n, 1.0 / before, s->vector[k]);
    scale_vector(n, 1.0 / before, s->image[k]);
    for (int j = 0; j < k; j++) {
      double c = -dot(n, s->vector[j], s->vector[k]);
      add_scaled(n, c, s->vector[j], s->vector[k]);
      add_scaled(n, c, s->image[j], s->image[k]);
    }
  }
  double rest = sqrt(dot(n, s->vector[k], s->vector[k]));
  if (!(rest > 1e-8))
    return 0;
  scale_vector(n, 1.0 / rest, s->vector[k]);
  scale_vector(n, 1.0 / rest, s->image[k]);
  return 1;
}

static void start_search(eigen_search *s) {
  uint64_t state = 1;
  for (int i = 0; i < s->matrix->n; i++) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    s->vector[0][i] = (double)(state >> 11) * 0x1p-53 - 0.5;
  }
}

static void refresh(eigen_search *s) {
  int n = s->matrix->n;
  scale_vector(n, 1.0 / sqrt(dot(n, s->vector[0], s->vector[0])), s->vector[0]);
  multiply(s->matrix, s->n_threads, s->vector[0], s->image[0]);
}

static void find_residual(eigen_search *s) {
  int n = s->matrix->n;
  s->eigenvalue = dot(n, s->vector[0], s->image[0]);
  memcpy(s->residual, s->image[0], (size_t)n * sizeof *s->residual);
  add_scaled(n, -s->eigenvalue, s->vector[0], s->residual);
  s->residual_norm = sqrt(dot(n, s->residual, s->residual));
}

/* Replaces x by the best combination of x, w and p, and p by its part in w and p. */
static void combine(eigen_search *s, int n_vectors) {
  int n = s->matrix->n;
  double a[3][3], c[3];
  for (int i = 0; i < n_vectors; i++)
    for (int j = 0; j <= i; j++)
      a[i][j] = a[j][i] = dot(n, s->vector[i], s->image[j]);
  smallest_of_small(n_vectors, a, c);
  double **sets[2] = {s->vector, s->image};
  for (int set = 0; set < 2; set++) {
    double *x = sets[set][0], *w = sets[set][1], *p = sets[set][2];
    for (int i = 0; i < n; i++) {
      double direction = c[1] * w[i] + (n_vectors > 2 ? c[2] * p[i] : 0.0);
      x[i] = c[0] * x[i] + direction;
      p[i] = direction;
    }
  }
}

/* 1: settled. */
static int search_eigenvalue(eigen_search *s, int max_steps) {
  int n = s->matrix->n, have_direction = 0;
  double noise = 10.0 * n * 0x1p-52;
  start_search(s);
  for (int step = 0; step < max_steps; step++) {
    if (step % REFRESH_STEPS == 0)
      refresh(s);
    find_residual(s);
    if (s->residual_norm <= SETTLED * s->eigenvalue || s->eigenvalue <= noise)
      return 1;
    if (s->factor)
      solve_factor(s->factor, s->residual, s->vector[1]);
    else
      solve_blocks(s->blocks, s->residual, s->vector[1]);
    multiply(s->matrix, s->n_threads, s->vector[1], s->image[1]);
    if (!orthonormalise(s, 1))
      return s->residual_norm <= noise;
    int n_vectors = have_direction && orthonormalise(s, 2) ? 3 : 2;
    combine(s, n_vectors);
    have_direction = 1;
  }
  return 0;
}

/* ---- driver ------------------------------------------------------------------------------------
 */

/* 0: a diagonal entry is not positive. */
static int scale_to_unit_diagonal(tsi_symmetric *m, double *factor_of) {
  for (int i = 0; i < m->n; i++) {
    double diagonal = 0.0;
    for (size_t k = m->start[i]; k < m->start[i + 1]; k++)
      if (m->column[k] == i)
        diagonal = m->value[k];
    if (!(diagonal > 0.0))
      return 0;
    factor_of[i] = 1.0 / sqrt(diagonal);
  }
  for (int i = 0; i < m->n; i++)
    for (size_t k = m->start[i]; k < m->start[i + 1]; k++)
      m->value[k] *= factor_of[i] * factor_of[m->column[k]];
  return 1;
}

static int reserve_vectors(eigen_search *s, tsi_arena *arena) {
  size_t n = (size_t)s->matrix->n;
  s->residual = tsi_arena_new(arena, n, sizeof(double));
  int complete = s->residual != NULL;
  for (int k = 0; k < 3; k++) {
    s->vector[k] = tsi_arena_new(arena, n, sizeof(double));
    s->image[k] = tsi_arena_new(arena, n, sizeof(double));
    complete = complete && s->vector[k] && s->image[k];
  }
  return complete;
}

/* The eigenvalue with the sparse factor as preconditioner. 0: no memory. */
static int search_directly(eigen_search *s, factor *f, const cs_di *upper, tsi_arena *arena,
                           int *settled, double *eigenvalue) {
  int positive;
  if (!factorise(f, upper, arena, &positive))
    return 0;
  *settled = 1;
  if (!positive)
    return 1;
  s->factor = f;
  *settled = search_eigenvalue(s, MAX_STEPS);
  *eigenvalue = fmax(s->eigenvalue, 0.0);
  return 1;
}

static int search_iteratively(eigen_search *s, blocks *b, tsi_arena *arena, int *settled,
                              double *eigenvalue) {
  int positive;
  if (!factor_blocks(s->matrix, arena, b, &positive))
    return 0;
  *settled = 1;
  if (!positive)
    return 1;
  s->blocks = b;
  *settled = search_eigenvalue(s, MAX_STEPS);
  *eigenvalue = fmax(s->eigenvalue, 0.0);
  return 1;
}

tsolid_status tsi_smallest_eigenvalue(tsolid_context *context, tsi_symmetric *matrix,
                                      tsi_eigen_method method, double *eigenvalue) {
  tsi_arena arena = tsi_arena_create(context);
  eigen_search s = {.matrix = matrix, .n_threads = context->n_threads};
  factor f = {.n = matrix->n};
  blocks b = {.n_blocks = 0};
  cs_di upper;
  int settled = 0;
  *eigenvalue = 0.0;
  int complete = reserve_vectors(&s, &arena);
  if (!complete || matrix->n == 0 || !scale_to_unit_diagonal(matrix, s.residual))
    goto done;
  complete = analyse(matrix, &arena, &upper, &f);
  int direct = method == TSI_EIGEN_DIRECT || (method == TSI_EIGEN_AUTO && f.flops <= DIRECT_FLOPS);
  if (complete && !direct)
    complete = search_iteratively(&s, &b, &arena, &settled, eigenvalue);
  if (complete && !settled && method != TSI_EIGEN_ITERATIVE)
    complete = search_directly(&s, &f, &upper, &arena, &settled, eigenvalue);
done:
  cs_di_sfree(f.symbolic);
  tsi_arena_free(&arena);
  return complete ? TSOLID_OK : tsi_no_memory(context, STAGE);
}
