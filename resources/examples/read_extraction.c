/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Reads extraction operators as `tsolid export X.tsolid --extraction FILE` writes them, and prints
 * the middle of every element:   cc read_extraction.c -o read_extraction && ./read_extraction FILE
 *
 * For little-endian machines; elsewhere the bytes of every number must be turned round. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct extraction {
  int64_t n_functions, n_elements, n_entries, n_coefficients;
  double *control, *box, *coefficient; /* rows of 4, rows of 6, rows of Bernstein coefficients */
  int64_t *block, *degree, *function_start, *function;
} extraction;

static void stop(const char *why) {
  fprintf(stderr, "%s\n", why);
  exit(1);
}

static void *take(FILE *file, int64_t n) {
  void *array = malloc(8 * (size_t)n + 1);
  if (!array || fread(array, 8, (size_t)n, file) != (size_t)n)
    stop("the file ends early");
  return array;
}

static void read_extraction(FILE *file, extraction *x) {
  char magic[8];
  if (fread(magic, 1, 8, file) != 8 || memcmp(magic, "tsolidE1", 8) != 0 ||
      fread(x, 8, 4, file) != 4)
    stop("no extraction operators");
  x->control = take(file, 4 * x->n_functions);
  x->block = take(file, x->n_elements);
  x->box = take(file, 6 * x->n_elements);
  x->degree = take(file, 3 * x->n_elements);
  x->function_start = take(file, x->n_elements + 1);
  x->function = take(file, x->n_entries);
  x->coefficient = take(file, x->n_coefficients);
}

/* B_i(1/2) of degree p for i = 0 .. p. */
static void bernstein_at_half(int64_t p, double *b) {
  b[0] = 1.0;
  for (int64_t n = 1; n <= p; n++)
    for (int64_t i = n; i >= 0; i--)
      b[i] = 0.5 * ((i < n ? b[i] : 0.0) + (i > 0 ? b[i - 1] : 0.0));
}

int main(int argc, char **argv) {
  extraction x;
  FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
  if (!file)
    stop("usage: read_extraction FILE");
  read_extraction(file, &x);
  const double *row = x.coefficient;
  for (int64_t e = 0; e < x.n_elements; e++) {
    const int64_t *p = x.degree + 3 * e;
    double b[3][32], h[4] = {0};
    for (int d = 0; d < 3; d++)
      bernstein_at_half(p[d], b[d]);
    for (int64_t k = x.function_start[e]; k < x.function_start[e + 1]; k++)
      for (int64_t w = 0; w <= p[2]; w++)
        for (int64_t v = 0; v <= p[1]; v++)
          for (int64_t u = 0; u <= p[0]; u++, row++)
            for (int c = 0; c < 4; c++)
              h[c] += *row * b[0][u] * b[1][v] * b[2][w] * x.control[4 * x.function[k] + c];
    printf("%.17g %.17g %.17g\n", h[0] / h[3], h[1] / h[3], h[2] / h[3]);
  }
  return 0;
}
