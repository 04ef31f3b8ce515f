/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Where the mesh lines of the hexahedra lie.
 *
 * Along an axis the physical speed |x_a| is sampled on lines of the core and of the four sides that
 * carry the axis; through the layers |x_r| on lines of all six arms. The number of intervals is the
 * longest line's length over the wanted size, their positions share the mean length equally, or
 * geometrically through the layers. Borders of regions are lines: the axis is divided between
 * them. */
#include <stdlib.h>

#include "hex.h"

static const char stage[] = "hexahedra";

enum { STATIONS = 24, N_LINES = 54, LAYERS = 3 };

/* ---- hard positions ----------------------------------------------------------------------------
 */

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static tsolid_status collect_hard(tsolid_context *context, tsi_arena *arena, int axis,
                                  int n_regions, const tsolid_region *region, tsi_hex_axis *speed) {
  int n = 2, kept = 0;
  speed->hard = tsi_arena_new(arena, 2 + 2 * (size_t)n_regions, sizeof *speed->hard);
  if (!speed->hard)
    return tsi_no_memory(context, stage);
  speed->hard[1] = 1.0;
  for (int k = 0; axis < 3 && k < n_regions; k++) {
    int side = region[k].side, along = axis == tsi_side_s(side) ? 0 : 1;
    if (tsi_side_axis(side) == axis)
      continue;
    speed->hard[n++] = region[k].box[2 * along];
    speed->hard[n++] = region[k].box[2 * along + 1];
  }
  qsort(speed->hard, (size_t)n, sizeof *speed->hard, compare_doubles);
  for (int k = 0; k < n; k++)
    if (k == 0 || speed->hard[k] > speed->hard[kept - 1])
      speed->hard[kept++] = speed->hard[k];
  speed->n_hard = kept - 1;
  return TSOLID_OK;
}

/* ---- speeds ------------------------------------------------------------------------------------
 */

/* Block and coordinates of line `line` of axis d (3: through the layers) at position x. */
static int place_on_line(const tsolid_solid *solid, int d, int line, double x, double u[3]) {
  if (d == 3) {
    int side = line / 9,
        block = tsolid_solid_boundary_point(solid, side, 0.5 * (line % 3), 0.5 * (line / 3 % 3), u);
    int axis = tsi_side_axis(side);
    double core = side & 1 ? 1.0 : 0.0;
    u[axis] = core + x * (u[axis] - core);
    return block;
  }
  if (line < 9) {
    int other[2] = {d == 0 ? 1 : 0, d == 2 ? 1 : 2};
    u[d] = x;
    u[other[0]] = 0.5 * (line % 3);
    u[other[1]] = 0.5 * (line / 3);
    return 0;
  }
  int k = (line - 9) / 3, normal = (d + 1 + k / 2) % 3, side = 2 * normal + k % 2;
  double across = 0.5 * ((line - 9) % 3);
  int is_s = tsi_side_s(side) == d;
  return tsolid_solid_boundary_point(solid, side, is_s ? x : across, is_s ? across : x, u);
}

tsolid_status tsi_hex_axis_sample(tsolid_context *context, tsi_arena *arena,
                                  const tsolid_solid *solid, int d, tsi_hex_axis *speed) {
  int n_lines = d == 3 ? N_LINES : 21;
  speed->n_lines = n_lines;
  size_t n_hard = (size_t)speed->n_hard;
  speed->length = tsi_arena_new(arena, n_hard * (size_t)n_lines, sizeof *speed->length);
  speed->mean = tsi_arena_new(arena, n_hard * STATIONS, sizeof *speed->mean);
  if (!speed->length || !speed->mean)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < speed->n_hard; i++) {
    double step = (speed->hard[i + 1] - speed->hard[i]) / STATIONS;
    for (int line = 0; line < n_lines; line++)
      for (int k = 0; k < STATIONS; k++) {
        double u[3], out[12];
        int block = place_on_line(solid, d, line, speed->hard[i] + step * (k + 0.5), u);
        tsolid_status status = tsolid_solid_evaluate(context, solid, block, u, 1, out);
        if (status)
          return status;
        int axis = d == 3 ? tsi_side_axis(line / 9) : d;
        const double *v = out + 3 + 3 * axis;
        double scale = d == 3 ? solid->space->tmesh->arm_height[line / 9] : 1.0;
        double length = scale * step * sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        speed->length[i * n_lines + line] += length;
        speed->mean[i * STATIONS + k] += length / n_lines;
      }
  }
  return TSOLID_OK;
}

/* ---- divisions ---------------------------------------------------------------------------------
 */

double tsi_hex_axis_longest(const tsi_hex_axis *speed, int interval) {
  double most = 0.0;
  for (int line = 0; line < speed->n_lines; line++)
    most = fmax(most, speed->length[interval * speed->n_lines + line]);
  return most;
}

/* Divisions of each interval: from the size, or `wanted` in all, one at least, each new one where
 * the pieces are longest. */
static tsolid_status divide(tsolid_context *context, const tsi_hex_axis *speed, int d, double size,
                            int wanted, int *n_of, int *n) {
  static const char *const name[] = {"x", "y", "z", "the layers"};
  *n = 0;
  for (int i = 0; i < speed->n_hard; i++) {
    double pieces = wanted ? 1.0 : ceil(tsi_hex_axis_longest(speed, i) / size * (1.0 - 1e-9));
    if (!(pieces <= 1e6))
      return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                      "Elements of size %g along %s are too many: the part is %g long there", size,
                      name[d], tsi_hex_axis_longest(speed, i));
    n_of[i] = pieces < 1.0 ? 1 : (int)pieces;
    *n += n_of[i];
  }
  if (wanted && wanted < *n)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                    "%d divisions along %s are too few: borders of faces already divide it in %d",
                    wanted, name[d], *n);
  for (; wanted && *n < wanted; ++*n) {
    int best = 0;
    for (int i = 1; i < speed->n_hard; i++)
      if (tsi_hex_axis_longest(speed, i) / n_of[i] > tsi_hex_axis_longest(speed, best) / n_of[best])
        best = i;
    n_of[best]++;
  }
  return TSOLID_OK;
}

/* Position in interval i where the share of its mean length is reached. */
double tsi_hex_axis_position(const tsi_hex_axis *speed, int i, double share) {
  const double *mean = speed->mean + i * STATIONS;
  double low = speed->hard[i], width = speed->hard[i + 1] - low, total = 0.0, done = 0.0;
  for (int k = 0; k < STATIONS; k++)
    total += mean[k];
  if (!(total > 0.0))
    return low + share * width;
  for (int k = 0; k < STATIONS; k++) {
    if (done + mean[k] >= share * total)
      return low + width * (k + (share * total - done) / mean[k]) / STATIONS;
    done += mean[k];
  }
  return speed->hard[i + 1];
}

/* Share of the length below line k of n, thicknesses in geometric series; the last over the first
 * is `grading`. */
static double graded_share(int k, int n, double grading) {
  if (n < 2 || grading == 1.0)
    return (double)k / n;
  double ratio = pow(grading, 1.0 / (n - 1));
  return (pow(ratio, k) - 1.0) / (pow(ratio, n) - 1.0);
}

static tsolid_status place_lines(tsolid_context *context, tsi_arena *arena,
                                 const tsi_hex_axis *speed, const int *n_of, double grading, int d,
                                 tsi_hex_lines *lines) {
  int order = lines->order, at = 0;
  double *x = tsi_arena_new(arena, (size_t)(order * lines->n[d] + 1), sizeof *x);
  if (!x)
    return tsi_no_memory(context, stage);
  for (int i = 0; i < speed->n_hard; i++)
    for (int k = 0; k < n_of[i]; k++, at += order)
      x[at] = k == 0 ? speed->hard[i]
                     : tsi_hex_axis_position(speed, i,
                                             graded_share(k, n_of[i], d == 3 ? grading : 1.0));
  x[at] = 1.0;
  for (int k = 1; order == 2 && k < at; k += 2)
    x[k] = 0.5 * (x[k - 1] + x[k + 1]);
  lines->x[d] = x;
  return TSOLID_OK;
}

double tsi_hex_diagonal(const tsolid_boundary *boundary) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < (size_t)boundary->n_functions; i++)
    for (size_t c = 0; c < 3; c++) {
      double x = boundary->points[4 * i + c] / boundary->points[4 * i + 3];
      low[c] = fmin(low[c], x);
      high[c] = fmax(high[c], x);
    }
  return hypot(hypot(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
}

tsolid_status tsi_hex_axis_lines(tsolid_context *context, tsi_arena *arena,
                                 const tsolid_solid *solid, const tsolid_hex_options *options,
                                 int d, tsi_hex_lines *lines) {
  double size = options->size > 0.0 ? options->size : tsi_hex_diagonal(solid->space->boundary) / 20;
  tsi_hex_axis speed = {0};
  lines->order = options->order == 2 ? 2 : 1;
  tsolid_status status =
      collect_hard(context, arena, d, options->n_regions, options->regions, &speed);
  if (!status)
    status = tsi_hex_axis_sample(context, arena, solid, d, &speed);
  if (status)
    return status;
  int *n_of = tsi_arena_new(arena, (size_t)speed.n_hard, sizeof *n_of);
  if (!n_of)
    return tsi_no_memory(context, stage);
  status = divide(context, &speed, d, size, options->divisions[d], n_of, &lines->n[d]);
  if (!status)
    status = place_lines(context, arena, &speed, n_of,
                         options->grading > 0.0 ? options->grading : 1.0, d, lines);
  return status;
}
