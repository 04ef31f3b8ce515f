/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Inside or outside of a part, by parity: a ray from the point crosses a closed surface an odd
 * number of times if and only if the point is inside.
 *
 * The surface is that of the grids' triangles, off by at most `bend`; nearer points are decided by
 * callers with the normal at their foot. Rays run along the axes of a frame that is turned by fixed
 * odd angles, so that they do not meet edges of parts that stand square; two that disagree are
 * settled by a third (borders of neighbouring grids leave cracks of the size of `bend`). */
#include "assembly.h"
#include "bvh.h"

static const char stage[] = "assembly";

/* A rotation: rows of odd numbers, orthonormal. */
static void turn(const double x[3], double y[3]) {
  static const double a = 0.36, b = 0.48, c = 0.8; /* a^2 + b^2 + c^2 = 1 */
  static const double s = 0.6, t = 0.8;
  double p[3] = {s * x[0] + t * x[1], -t * x[0] + s * x[1], x[2]};
  double q[3] = {a * p[0] + b * p[1] + c * p[2], -0.8 * p[0] + 0.6 * p[1],
                 -0.48 * p[0] - 0.64 * p[1] + 0.6 * p[2]};
  static const double u = 0.28, v = 0.96;
  y[0] = u * q[0] + v * q[2];
  y[1] = q[1];
  y[2] = -v * q[0] + u * q[2];
}

static int add_triangles(const tsi_skin *skin, int first, int *triangle) {
  int n0 = skin->n_grid[0], n = 0;
  for (int j = 0; j + 1 < skin->n_grid[1]; j++)
    for (int i = 0; i + 1 < n0; i++) {
      int k = first + i + n0 * j;
      int corner[6] = {k, k + 1, k + n0, k + 1, k + n0 + 1, k + n0};
      memcpy(triangle + 3 * n, corner, sizeof corner);
      n += 2;
    }
  return n;
}

static void box_triangle(const tsi_member *part, int k, double box[6]) {
  for (int d = 0; d < 3; d++) {
    double x = part->turned[part->triangle[3 * k]][d];
    double y = part->turned[part->triangle[3 * k + 1]][d];
    double z = part->turned[part->triangle[3 * k + 2]][d];
    box[d] = fmin(x, fmin(y, z));
    box[3 + d] = fmax(x, fmax(y, z));
  }
}

tsolid_status tsi_inside_create(tsolid_context *context, tsolid_assembly *assembly, int number) {
  tsi_member *part = &assembly->part[number];
  tsi_arena *arena = &assembly->arena, work = tsi_arena_create(context);
  size_t n_points = 0, n_triangles = 0;
  for (int k = part->first; k < part->end; k++) {
    size_t n0 = (size_t)assembly->skin[k].n_grid[0], n1 = (size_t)assembly->skin[k].n_grid[1];
    n_points += n0 * n1;
    n_triangles += 2 * (n0 - 1) * (n1 - 1);
  }
  if (n_triangles > TSI_MAX_COUNT / 8)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage, "%s has too many spans", part->name);
  part->turned = tsi_arena_new(arena, n_points, sizeof *part->turned);
  part->triangle = tsi_arena_new(arena, n_triangles, 3 * sizeof *part->triangle);
  double *box = tsi_arena_new(&work, n_triangles, 6 * sizeof *box);
  tsolid_status status = TSOLID_OK;
  int first = 0;
  if (!part->turned || !part->triangle || !box) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  for (int k = part->first; k < part->end; k++) {
    const tsi_skin *skin = &assembly->skin[k];
    int count = skin->n_grid[0] * skin->n_grid[1];
    part->n_triangles += add_triangles(skin, first, part->triangle + 3 * part->n_triangles);
    for (int i = 0; i < count; i++)
      turn(skin->grid[i], part->turned[first + i]);
    first += count;
  }
  for (int k = 0; k < part->n_triangles; k++)
    box_triangle(part, k, box + 6 * k);
  part->bvh = tsi_bvh_create(&assembly->allocator, part->n_triangles, box);
  if (!part->bvh)
    status = tsi_no_memory(context, stage);
done:
  tsi_arena_free(&work);
  return status;
}

typedef struct ray {
  const tsi_member *part;
  double from[3];
  int axis, crossings;
} ray;

/* Twice the area of (a, b, x) across the ray; the same but for the sign when a and b change
 * places, so that a ray crosses one of two triangles at their common edge, never both or none. */
static double side_of(const double *a, const double *b, const double *x, int p, int q) {
  int swap = a[p] > b[p] || (a[p] == b[p] && a[q] > b[q]);
  const double *m = swap ? b : a, *n = swap ? a : b;
  double twice = (n[p] - m[p]) * (x[q] - m[q]) - (n[q] - m[q]) * (x[p] - m[p]);
  return swap ? -twice : twice;
}

static int cross(void *data, int item) {
  ray *r = data;
  int p = (r->axis + 1) % 3, q = (r->axis + 2) % 3;
  const double *v[3];
  double weight[3], height = 0.0, sum;
  for (int k = 0; k < 3; k++)
    v[k] = r->part->turned[r->part->triangle[3 * item + k]];
  for (int k = 0; k < 3; k++)
    weight[k] = side_of(v[(k + 1) % 3], v[(k + 2) % 3], r->from, p, q);
  int positive = weight[0] >= 0.0;
  if ((weight[1] >= 0.0) != positive || (weight[2] >= 0.0) != positive)
    return 0;
  sum = weight[0] + weight[1] + weight[2];
  if (sum == 0.0)
    return 0;
  for (int k = 0; k < 3; k++)
    height += weight[k] / sum * v[k][r->axis];
  r->crossings += height > r->from[r->axis];
  return 0;
}

static int is_odd(const tsi_member *part, const double from[3], int axis) {
  ray r = {.part = part, .from = {from[0], from[1], from[2]}, .axis = axis};
  double box[6] = {from[0], from[1], from[2], from[0], from[1], from[2]};
  box[3 + axis] = INFINITY;
  tsi_bvh_overlapping(part->bvh, box, 0.0, cross, &r);
  return r.crossings & 1;
}

int tsi_inside(const tsi_member *part, const double x[3]) {
  double from[3];
  for (int c = 0; c < 3; c++)
    if (x[c] < part->box[c] || x[c] > part->box[3 + c])
      return 0;
  turn(x, from);
  int first = is_odd(part, from, 0), second = is_odd(part, from, 1);
  return first == second ? first : is_odd(part, from, 2);
}
