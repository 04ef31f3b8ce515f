/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Median splits along the axis in which the centres spread most. */
#include "bvh.h"

enum { LEAF_ITEMS = 4, MAX_DEPTH = 64 };

typedef struct node {
  double box[6];
  int first, count; /* items of the whole subtree */
  int left, right;  /* -1: a leaf */
} node;

struct tsi_bvh {
  tsi_allocator allocator;
  int n_items, n_nodes;
  node *nodes;
  int *item;   /* input numbers in tree order */
  double *box; /* n_items x 6, by input number */
};

static double centre(const struct tsi_bvh *bvh, int item, int axis) {
  const double *box = bvh->box + 6 * (size_t)item;
  return 0.5 * box[axis] + 0.5 * box[axis + 3];
}

/* A strict total order: equal centres are told apart by the item's number. */
static int comes_before(const struct tsi_bvh *bvh, int axis, int a, int b) {
  double x = centre(bvh, a, axis), y = centre(bvh, b, axis);
  return x < y || (!(y < x) && a < b);
}

static void swap_items(int *item, int i, int j) {
  int kept = item[i];
  item[i] = item[j];
  item[j] = kept;
}

/* Quickselect: afterwards item[lo..k-1] come before item[k], item[k+1..hi] after it. */
static void select_item(struct tsi_bvh *bvh, int axis, int lo, int hi, int k) {
  uint32_t random = 1;
  while (lo < hi) {
    random = random * 1664525u + 1013904223u;
    int pivot = lo + (int)(random % (uint32_t)(hi - lo + 1)), store = lo;
    swap_items(bvh->item, pivot, hi);
    for (int i = lo; i < hi; i++)
      if (comes_before(bvh, axis, bvh->item[i], bvh->item[hi]))
        swap_items(bvh->item, i, store++);
    swap_items(bvh->item, store, hi);
    if (store == k)
      return;
    if (store < k)
      lo = store + 1;
    else
      hi = store - 1;
  }
}

static void bound_items(const struct tsi_bvh *bvh, node *n) {
  for (int d = 0; d < 3; d++) {
    n->box[d] = (double)INFINITY;
    n->box[d + 3] = -(double)INFINITY;
  }
  for (int i = n->first; i < n->first + n->count; i++) {
    const double *box = bvh->box + 6 * (size_t)bvh->item[i];
    for (int d = 0; d < 3; d++) {
      n->box[d] = fmin(n->box[d], box[d]);
      n->box[d + 3] = fmax(n->box[d + 3], box[d + 3]);
    }
  }
}

static int widest_axis(const struct tsi_bvh *bvh, const node *n) {
  int axis = 0;
  double widest = -1.0;
  for (int d = 0; d < 3; d++) {
    double lo = (double)INFINITY, hi = -(double)INFINITY;
    for (int i = n->first; i < n->first + n->count; i++) {
      double c = centre(bvh, bvh->item[i], d);
      lo = fmin(lo, c);
      hi = fmax(hi, c);
    }
    if (hi - lo > widest) {
      widest = hi - lo;
      axis = d;
    }
  }
  return axis;
}

/* The subtree over item[first .. first+count-1]; depth is log2 of the number of items. */
static int build(struct tsi_bvh *bvh, int first, int count) {
  int index = bvh->n_nodes++;
  node *n = &bvh->nodes[index];
  *n = (node){.first = first, .count = count, .left = -1, .right = -1};
  bound_items(bvh, n);
  if (count <= LEAF_ITEMS)
    return index;
  int half = count / 2;
  select_item(bvh, widest_axis(bvh, n), first, first + count - 1, first + half);
  n->left = build(bvh, first, half);
  n->right = build(bvh, first + half, count - half);
  return index;
}

struct tsi_bvh *tsi_bvh_create(const tsi_allocator *allocator, int n, const double *boxes) {
  struct tsi_bvh *bvh = n < 0 ? NULL : tsi_new(allocator, 1, sizeof *bvh);
  if (!bvh)
    return NULL;
  bvh->allocator = *allocator;
  bvh->n_items = n;
  bvh->nodes = tsi_new(allocator, (size_t)n + 1, sizeof *bvh->nodes);
  bvh->item = tsi_new(allocator, (size_t)n, sizeof *bvh->item);
  bvh->box = tsi_new(allocator, (size_t)n, 6 * sizeof *bvh->box);
  if (!bvh->nodes || !bvh->item || !bvh->box) {
    tsi_bvh_free(bvh);
    return NULL;
  }
  if (n > 0)
    memcpy(bvh->box, boxes, (size_t)n * 6 * sizeof *boxes);
  for (int i = 0; i < n; i++)
    bvh->item[i] = i;
  build(bvh, 0, n);
  return bvh;
}

void tsi_bvh_free(struct tsi_bvh *bvh) {
  if (!bvh)
    return;
  tsi_allocator allocator = bvh->allocator;
  tsi_delete(&allocator, bvh->nodes);
  tsi_delete(&allocator, bvh->item);
  tsi_delete(&allocator, bvh->box);
  tsi_delete(&allocator, bvh);
}

static int boxes_meet(const double *a, const double *b, double margin) {
  for (int d = 0; d < 3; d++)
    if (!(a[d] - margin <= b[d + 3] && b[d] <= a[d + 3] + margin))
      return 0;
  return 1;
}

int tsi_bvh_overlapping(const struct tsi_bvh *bvh, const double box[6], double margin,
                        tsi_bvh_visit visit, void *data) {
  int stack[MAX_DEPTH], n_stack = 0, answer = 0;
  stack[n_stack++] = 0;
  while (n_stack > 0) {
    const node *n = &bvh->nodes[stack[--n_stack]];
    if (!boxes_meet(n->box, box, margin))
      continue;
    if (n->left >= 0) {
      stack[n_stack++] = n->right;
      stack[n_stack++] = n->left;
      continue;
    }
    for (int i = n->first; i < n->first + n->count; i++)
      if (boxes_meet(bvh->box + 6 * (size_t)bvh->item[i], box, margin)) {
        answer = visit(data, bvh->item[i]);
        if (answer)
          return answer;
      }
  }
  return answer;
}

int tsi_bvh_containing(const struct tsi_bvh *bvh, const double point[3], double margin,
                       tsi_bvh_visit visit, void *data) {
  double box[6] = {point[0], point[1], point[2], point[0], point[1], point[2]};
  return tsi_bvh_overlapping(bvh, box, margin, visit, data);
}

static double distance2_to_box(const double *box, const double point[3]) {
  double sum = 0.0;
  for (int d = 0; d < 3; d++) {
    double out = fmax(fmax(box[d] - point[d], point[d] - box[d + 3]), 0.0);
    sum += out * out;
  }
  return sum;
}

void tsi_bvh_nearest(const struct tsi_bvh *bvh, const double point[3], double bound2,
                     tsi_bvh_approach approach, void *data) {
  struct {
    int node;
    double distance2;
  } stack[MAX_DEPTH];
  int n_stack = 0;
  stack[n_stack].node = 0;
  stack[n_stack++].distance2 = 0.0;
  while (n_stack > 0 && bound2 >= 0.0) {
    n_stack--;
    const node *n = &bvh->nodes[stack[n_stack].node];
    if (stack[n_stack].distance2 > bound2)
      continue;
    if (n->left >= 0) {
      double left = distance2_to_box(bvh->nodes[n->left].box, point);
      double right = distance2_to_box(bvh->nodes[n->right].box, point);
      int left_last = left <= right; /* what is pushed last is visited first */
      stack[n_stack].node = left_last ? n->right : n->left;
      stack[n_stack++].distance2 = left_last ? right : left;
      stack[n_stack].node = left_last ? n->left : n->right;
      stack[n_stack++].distance2 = left_last ? left : right;
      continue;
    }
    for (int i = n->first; i < n->first + n->count && bound2 >= 0.0; i++) {
      double d2 = distance2_to_box(bvh->box + 6 * (size_t)bvh->item[i], point);
      if (d2 <= bound2)
        bound2 = approach(data, bvh->item[i], d2);
    }
  }
}
