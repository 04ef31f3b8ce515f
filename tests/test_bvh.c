/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The bounding volume hierarchy against loops over all boxes. */
#include "check.h"

#include <stdlib.h>

#include "bvh.h"

static unsigned state = 1;

static double random_unit(void) {
  state = state * 1664525u + 1013904223u;
  return (double)(state >> 8) / (1 << 24);
}

/* Coordinates on a coarse grid: equal centres, touching and flat boxes abound. */
static void make_boxes(int n, int grid, double *box) {
  for (int i = 0; i < n; i++)
    for (int d = 0; d < 3; d++) {
      double lo = floor(random_unit() * grid) / grid;
      box[6 * i + d] = lo;
      box[6 * i + d + 3] = lo + floor(random_unit() * 3.0) / grid;
    }
}

static int mark(void *data, int item) {
  ((int *)data)[item]++;
  return 0;
}

static int meets(const double *a, const double *b, double margin) {
  for (int d = 0; d < 3; d++)
    if (a[d] - margin > b[d + 3] || b[d] > a[d + 3] + margin)
      return 0;
  return 1;
}

static void check_overlaps(const struct tsi_bvh *bvh, int n, const double *box, int grid) {
  int *count = calloc((size_t)n + 1, sizeof *count), right = 1;
  for (int query = 0; query < 50; query++) {
    double q[6], margin = query % 3 == 0 ? 0.5 / grid : 0.0;
    make_boxes(1, grid, q);
    memset(count, 0, (size_t)n * sizeof *count);
    tsi_bvh_overlapping(bvh, q, margin, mark, count);
    for (int i = 0; i < n; i++)
      right &= count[i] == meets(box + 6 * i, q, margin);
    memset(count, 0, (size_t)n * sizeof *count);
    tsi_bvh_containing(bvh, q, margin, mark, count);
    double point[6] = {q[0], q[1], q[2], q[0], q[1], q[2]};
    for (int i = 0; i < n; i++)
      right &= count[i] == meets(box + 6 * i, point, margin);
  }
  CHECK(right);
  free(count);
}

static double distance2(const double *box, const double *p) {
  double sum = 0.0;
  for (int d = 0; d < 3; d++) {
    double out = p[d] < box[d] ? box[d] - p[d] : p[d] > box[d + 3] ? p[d] - box[d + 3] : 0.0;
    sum += out * out;
  }
  return sum;
}

typedef struct nearest {
  double best;
  int item, visits;
} nearest;

static double approach(void *data, int item, double d2) {
  nearest *n = data;
  n->visits++;
  if (d2 < n->best) {
    n->best = d2;
    n->item = item;
  }
  return n->best;
}

static void check_nearest(const struct tsi_bvh *bvh, int n, const double *box, int grid) {
  int right = 1;
  long visits = 0;
  for (int query = 0; query < 50; query++) {
    double p[3] = {3.0 * random_unit() - 1.0, 3.0 * random_unit() - 1.0, 3.0 * random_unit() - 1.0};
    double best = (double)INFINITY;
    nearest found = {.best = (double)INFINITY, .item = -1};
    for (int i = 0; i < n; i++)
      best = fmin(best, distance2(box + 6 * i, p));
    tsi_bvh_nearest(bvh, p, (double)INFINITY, approach, &found);
    right &= found.best == best && (n == 0 || distance2(box + 6 * found.item, p) == best);
    visits += found.visits;
  }
  CHECK(right);
  if (n >= 1000 && grid > 8)
    CHECK(visits < 50L * n / 20); /* it does not look at everything */
}

static int stop_at_third(void *data, int item) {
  (void)item;
  return ++*(int *)data == 3 ? 42 : 0;
}

static void check_stop(const struct tsi_bvh *bvh) {
  double all[6] = {-9, -9, -9, 9, 9, 9};
  int count = 0;
  CHECK(tsi_bvh_overlapping(bvh, all, 0.0, stop_at_third, &count) == 42);
  CHECK(count == 3);
}

/* The same boxes in any number make the same visits in the same order. */
typedef struct order {
  int n, item[4096];
} order;

static int note(void *data, int item) {
  order *o = data;
  o->item[o->n++] = item;
  return 0;
}

int main(void) {
  static const int sizes[] = {0, 1, 2, 4, 5, 9, 33, 1000, 4000};
  tsi_allocator allocator = {NULL, NULL, NULL};
  static order first, second;
  for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
    for (int grid = 1; grid <= 64; grid *= 8) {
      int n = sizes[k];
      double *box = calloc(6 * (size_t)n + 1, sizeof *box), all[6] = {-9, -9, -9, 9, 9, 9};
      make_boxes(n, grid, box);
      struct tsi_bvh *bvh = tsi_bvh_create(&allocator, n, box);
      struct tsi_bvh *again = tsi_bvh_create(&allocator, n, box);
      if (CHECK(bvh != NULL && again != NULL)) {
        check_overlaps(bvh, n, box, grid);
        check_nearest(bvh, n, box, grid);
        if (n >= 3)
          check_stop(bvh);
        first.n = second.n = 0;
        tsi_bvh_overlapping(bvh, all, 0.0, note, &first);
        tsi_bvh_overlapping(again, all, 0.0, note, &second);
        CHECK(first.n == n && memcmp(&first, &second, sizeof first) == 0);
      }
      tsi_bvh_free(bvh);
      tsi_bvh_free(again);
      free(box);
    }
  CHECK(tsi_bvh_create(&allocator, -1, NULL) == NULL);
  return check_done();
}
