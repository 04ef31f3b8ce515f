/* SPDX-License-Identifier: LGPL-2.1-or-later
 * From parts to skins: patches of every form as NURBS patches in their places, sampled.
 *
 * The Bezier elements of a T-spline become one NURBS patch: all lines of elements are led through
 * the whole patch, with knots of full multiplicity; its control points on a cell are those of the
 * element around it, restricted (de Casteljau). That adds control points, but not one new point of
 * the surface, and the surface is all that contacts are about.
 *
 * The grid on which a patch is sampled cuts each span so that a curve of its second differences D,
 * cut into m pieces, stays within D/(8 m^2) of its chords: a 500th of the patch's size. */
#include <stdio.h>
#include <stdlib.h>

#include "assembly.h"
#include "bernstein.h"
#include "boundary.h"
#include "bspline.h"
#include "bvh.h"

static const char stage[] = "assembly";

enum { MOST_PIECES = 12, MOST_LINES = 192 };

static const double chord_distance = 2e-3; /* of a patch's size */

/* ---- names and places --------------------------------------------------------------------------
 */

static const char *copy_text(tsi_arena *arena, const char *text) {
  size_t size = strlen(text) + 1;
  char *copy = tsi_arena_new(arena, size, 1);
  if (copy)
    memcpy(copy, text, size);
  return copy;
}

static const char *name_part(tsi_arena *arena, const char *name, int k) {
  char text[TSI_NAME_SIZE];
  if (name && *name)
    return copy_text(arena, name);
  snprintf(text, sizeof text, "part %d", k);
  return copy_text(arena, text);
}

/* A rotation and a shift, within 1e-9. */
static tsolid_status vet_placement(tsolid_context *context, const tsi_member *part,
                                   const double m[12]) {
  double determinant = 0.0, worst = 0.0;
  for (int i = 0; i < 12; i++)
    if (!(fabs(m[i]) <= 1e100))
      return tsi_fail(context, TSOLID_ERROR_INPUT, stage, "The placement of %s is not finite",
                      part->name);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double dot = 0.0;
      for (int k = 0; k < 3; k++)
        dot += m[4 * i + k] * m[4 * j + k];
      worst = fmax(worst, fabs(dot - (i == j)));
    }
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    determinant += m[i] * (m[4 + j] * m[8 + k] - m[4 + k] * m[8 + j]);
  }
  if (worst <= 1e-9 && determinant < 0.0)
    return tsi_fail(context, TSOLID_ERROR_INPUT, stage, "The placement of %s is mirrored",
                    part->name);
  if (!(worst <= 1e-9))
    return tsi_fail(context, TSOLID_ERROR_INPUT, stage,
                    "The placement of %s scales or shears it: a rotation and a shift is expected",
                    part->name);
  return TSOLID_OK;
}

static void place_patch(const tsi_member *part, tsi_patch *patch) {
  size_t n = (size_t)patch->n[0] * (size_t)patch->n[1];
  const double *m = part->placement;
  for (size_t i = 0; part->placed && i < n; i++) {
    double *h = patch->control + 4 * i, x[3];
    for (size_t c = 0; c < 3; c++)
      x[c] = m[4 * c] * h[0] + m[4 * c + 1] * h[1] + m[4 * c + 2] * h[2] + m[4 * c + 3] * h[3];
    for (size_t c = 0; c < 3; c++)
      h[c] = x[c] + 0.0;
  }
}

/* ---- elements to patches -----------------------------------------------------------------------
 */

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* The lines of all elements in direction d, ascending; returns how many. */
static int list_lines(const tsi_side *side, int d, double *line) {
  int n = 0, kept = 0;
  for (int e = 0; e < side->n_elements; e++)
    for (int k = 0; k < 2; k++)
      line[n++] = side->box[4 * e + 2 * d + k];
  qsort(line, (size_t)n, sizeof *line, compare_doubles);
  for (int i = 0; i < n; i++)
    if (!kept || line[i] != line[kept - 1])
      line[kept++] = line[i];
  return kept;
}

/* Bezier net of element e, restricted to the cell. */
static void find_net(const tsi_side *side, const double *points, int e, const double cell[4],
                     double *net) {
  size_t n0 = (size_t)side->degree[0] + 1, n1 = (size_t)side->degree[1] + 1, width = n0 * n1;
  const double *box = side->box + 4 * e;
  double x[4];
  memset(net, 0, 4 * width * sizeof *net);
  for (int k = side->function_start[e]; k < side->function_start[e + 1]; k++)
    for (size_t i = 0; i < width; i++)
      for (size_t c = 0; c < 4; c++)
        net[4 * i + c] +=
            side->coefficient[(size_t)k * width + i] * points[4 * (size_t)side->function[k] + c];
  for (int k = 0; k < 4; k++)
    x[k] = (cell[k] - box[k & 2]) / (box[(k & 2) + 1] - box[k & 2]);
  for (size_t c = 0; c < 4; c++) {
    for (size_t j = 0; j < n1; j++)
      tsi_bernstein_restrict(side->degree[0], x[0], x[1], net + 4 * n0 * j + c, 4);
    for (size_t i = 0; i < n0; i++)
      tsi_bernstein_restrict(side->degree[1], x[2], x[3], net + 4 * i + c, (int)(4 * n0));
  }
}

static int fill_cells(tsi_arena *arena, const tsi_side *side, const double *points,
                      double *const line[2], tsi_patch *patch) {
  int p = side->degree[0], q = side->degree[1];
  double *net = tsi_arena_new(arena, (size_t)(p + 1) * (size_t)(q + 1), 4 * sizeof *net);
  if (!net)
    return 0;
  for (int e = 0; e < side->n_elements; e++) {
    const double *box = side->box + 4 * e;
    for (int j = 0; q * j + 1 < patch->n[1]; j++)
      for (int i = 0; p * i + 1 < patch->n[0]; i++) {
        double cell[4] = {line[0][i], line[0][i + 1], line[1][j], line[1][j + 1]};
        if (cell[0] < box[0] || cell[1] > box[1] || cell[2] < box[2] || cell[3] > box[3])
          continue;
        find_net(side, points, e, cell, net);
        for (int b = 0; b <= q; b++)
          memcpy(patch->control + 4 * ((size_t)(p * i) + (size_t)patch->n[0] * (size_t)(q * j + b)),
                 net + 4 * (p + 1) * b, 4 * (size_t)(p + 1) * sizeof *net);
      }
  }
  return 1;
}

static tsolid_status patch_from_elements(tsolid_context *context, tsi_arena *arena,
                                         const tsi_side *side, const double *points,
                                         tsi_patch *patch) {
  double *line[2];
  for (int d = 0; d < 2; d++) {
    int p = side->degree[d], count = 0;
    line[d] = tsi_arena_new(arena, 2 * (size_t)side->n_elements, sizeof(double));
    if (!line[d])
      return tsi_no_memory(context, stage);
    int n = list_lines(side, d, line[d]);
    if (n > MOST_LINES)
      return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                      "A T-spline patch has %d lines of elements, more than %d", n, MOST_LINES);
    patch->degree[d] = p;
    patch->n[d] = p * (n - 1) + 1;
    patch->knots[d] = tsi_arena_new(arena, (size_t)(patch->n[d] + p + 1), sizeof(double));
    if (!patch->knots[d])
      return tsi_no_memory(context, stage);
    for (int i = 0; i < n; i++)
      for (int k = 0; k < p + (i == 0 || i == n - 1); k++)
        patch->knots[d][count++] = line[d][i];
  }
  patch->control =
      tsi_arena_new(arena, (size_t)patch->n[0] * (size_t)patch->n[1], 4 * sizeof(double));
  if (!patch->control || !fill_cells(arena, side, points, line, patch))
    return tsi_no_memory(context, stage);
  return TSOLID_OK;
}

/* ---- the grid ----------------------------------------------------------------------------------
 */

void tsi_skin_point(const tsi_skin *skin, double u, double v, double x[3]) {
  tsi_patch_point(&skin->patch, u, v, x);
}

int tsi_skin_normal(const tsi_skin *skin, double u, double v, double x[3], double normal[3]) {
  tsi_patch_normal(&skin->patch, u, v, x, normal);
  double length = sqrt(tsi_dot3(normal, normal)) * (skin->outward < 0 ? -1.0 : 1.0);
  for (int c = 0; c < 3; c++)
    normal[c] /= length;
  return fabs(length) > 1e-14 * skin->size * skin->size;
}

double tsi_skin_angle(const tsi_skin *a, const tsi_skin *b) {
  double cosine = 0.0;
  for (int c = 0; c < 3; c++)
    cosine += a->mean[c] * b->mean[c];
  return fmax(0.0, acos(fmin(fabs(cosine), 1.0)) - a->cone - b->cone);
}

/* Largest second difference of the control points that rule a span in direction d. */
static double find_bend(const tsi_patch *patch, int d, int span) {
  double most = 0.0;
  int p = patch->degree[d], across = patch->n[1 - d];
  size_t step = d ? (size_t)patch->n[0] : 1, row = d ? 1 : (size_t)patch->n[0];
  for (int k = 0; k < across; k++)
    for (int i = span - p; i + 2 <= span; i++) {
      const double *h = patch->control + 4 * ((size_t)i * step + (size_t)k * row);
      double length = 0.0;
      for (size_t c = 0; c < 3; c++) {
        double x = h[c] / h[3] - 2.0 * h[4 * step + c] / h[4 * step + 3] +
                   h[8 * step + c] / h[8 * step + 3];
        length += x * x;
      }
      most = fmax(most, sqrt(length) * p * (p - 1));
    }
  return most;
}

static int cut_spans(tsi_arena *arena, tsi_skin *skin, int d) {
  const tsi_patch *patch = &skin->patch;
  double *at = tsi_arena_new(arena, (size_t)(patch->n[d] * MOST_PIECES) + 2, sizeof *at);
  int n = 0;
  if (!at)
    return 0;
  for (int i = patch->degree[d]; i < patch->n[d]; i++) {
    double low = patch->knots[d][i], high = patch->knots[d][i + 1];
    if (!(low < high))
      continue;
    double bend = find_bend(patch, d, i);
    int m = 1 + (int)fmin(sqrt(bend / (8.0 * chord_distance * skin->size)), MOST_PIECES - 1.0);
    for (int k = 0; k < m; k++)
      at[n++] = low + (high - low) * k / m;
  }
  at[n++] = 1.0;
  skin->at[d] = at;
  skin->n_grid[d] = n;
  return 1;
}

/* How far the middles of the grid's cells are from their corners' mean plane. */
static void measure_bend(tsi_skin *skin) {
  int n0 = skin->n_grid[0];
  skin->bend = 0.0;
  for (int j = 0; j + 1 < skin->n_grid[1]; j++)
    for (int i = 0; i + 1 < n0; i++) {
      const double *p[4] = {skin->grid[i + n0 * j], skin->grid[i + 1 + n0 * j],
                            skin->grid[i + n0 * (j + 1)], skin->grid[i + 1 + n0 * (j + 1)]};
      double x[3], twist = 0.0, off = 0.0;
      tsi_skin_point(skin, 0.5 * (skin->at[0][i] + skin->at[0][i + 1]),
                     0.5 * (skin->at[1][j] + skin->at[1][j + 1]), x);
      for (int c = 0; c < 3; c++) {
        double mean = 0.25 * (p[0][c] + p[1][c] + p[2][c] + p[3][c]);
        double t = 0.25 * (p[0][c] + p[3][c] - p[1][c] - p[2][c]);
        off += (x[c] - mean) * (x[c] - mean);
        twist += t * t;
      }
      skin->bend = fmax(skin->bend, 1.5 * (sqrt(off) + sqrt(twist)));
    }
}

/* The mean normal and the cone round it; a tenth more, for what is between the samples. */
static void find_cone(tsi_skin *skin) {
  const double pi = 3.14159265358979323846;
  int n = skin->n_grid[0] * skin->n_grid[1];
  double x[3], normal[3], length = 0.0, least = 1.0;
  skin->cone = pi;
  for (int i = 0; i < n; i++) {
    if (!tsi_skin_normal(skin, skin->at[0][i % skin->n_grid[0]], skin->at[1][i / skin->n_grid[0]],
                         x, normal))
      return;
    for (int c = 0; c < 3; c++)
      skin->mean[c] += normal[c];
  }
  for (int c = 0; c < 3; c++)
    length += skin->mean[c] * skin->mean[c];
  for (int c = 0; c < 3; c++)
    skin->mean[c] /= sqrt(length);
  for (int i = 0; i < n; i++) {
    double cosine = 0.0;
    tsi_skin_normal(skin, skin->at[0][i % skin->n_grid[0]], skin->at[1][i / skin->n_grid[0]], x,
                    normal);
    for (int c = 0; c < 3; c++)
      cosine += normal[c] * skin->mean[c];
    least = fmin(least, cosine);
  }
  if (length > 1e-12)
    skin->cone = fmin(pi, 1.25 * acos(fmax(-1.0, least)) + 0.02);
}

static int sample_skin(tsi_arena *arena, tsi_skin *skin) {
  if (!cut_spans(arena, skin, 0) || !cut_spans(arena, skin, 1))
    return 0;
  int n0 = skin->n_grid[0], n1 = skin->n_grid[1];
  skin->grid = tsi_arena_new(arena, (size_t)n0 * (size_t)n1, sizeof *skin->grid);
  if (!skin->grid)
    return 0;
  for (int j = 0; j < n1; j++)
    for (int i = 0; i < n0; i++)
      tsi_skin_point(skin, skin->at[0][i], skin->at[1][j], skin->grid[i + n0 * j]);
  measure_bend(skin);
  find_cone(skin);
  return 1;
}

/* ---- skins -------------------------------------------------------------------------------------
 */

static int finish_skin(tsi_arena *arena, const tsolid_patch *source, double tolerance,
                       tsi_skin *skin) {
  const tsi_patch *patch = &skin->patch;
  size_t n0 = (size_t)patch->n[0], n = n0 * (size_t)patch->n[1];
  size_t at[4] = {0, n0 - 1, n - 1, n - n0};
  for (int c = 0; c < 3; c++) {
    skin->box[c] = INFINITY;
    skin->box[3 + c] = -INFINITY;
  }
  for (size_t i = 0; i < n; i++)
    for (size_t c = 0; c < 3; c++) {
      double x = patch->control[4 * i + c] / patch->control[4 * i + 3];
      skin->box[c] = fmin(skin->box[c], x);
      skin->box[3 + c] = fmax(skin->box[3 + c], x);
    }
  skin->size = hypot(hypot(skin->box[3] - skin->box[0], skin->box[4] - skin->box[1]),
                     skin->box[5] - skin->box[2]);
  for (size_t k = 0; k < 4; k++) {
    tsi_project_point(patch->control + 4 * at[k], skin->corner[k]);
    skin->mate[k] = -1;
    tolerance = fmax(tolerance, source ? source->border_tolerance[k] : 0.0);
  }
  skin->tolerance = tolerance;
  if (!(skin->size > 0.0))
    skin->size = tolerance;
  char name[TSI_NAME_SIZE];
  skin->name = copy_text(arena, tsi_name_patch(source ? source->name : NULL, skin->number, name));
  return skin->name && sample_skin(arena, skin);
}

/* What findings say of the patch, and its tolerances. */
static int copy_source(tsi_arena *arena, const tsolid_patch *from, tsolid_patch *to) {
  const char **text[9] = {&to->name};
  *to = *from;
  to->points = to->weights = to->knots[0] = to->knots[1] = NULL;
  to->tspline = NULL;
  to->bezier = NULL;
  for (int k = 0; k < 4; k++) {
    text[1 + k] = &to->border_name[k];
    text[5 + k] = &to->corner_name[k];
  }
  for (int k = 0; k < 9; k++)
    if (*text[k]) {
      *text[k] = copy_text(arena, *text[k]);
      if (!*text[k])
        return 0;
    }
  return 1;
}

static tsolid_status read_skin(tsolid_context *context, tsolid_assembly *assembly, tsi_arena *work,
                               const tsolid_boundary_input *input, int k, tsi_skin *skin) {
  const tsolid_patch *source = &input->patches[k];
  tsi_side elements = {.n_elements = 0};
  tsi_tspline tspline = {.n = 0};
  tsolid_status status;
  if (source->tspline || source->bezier) {
    status = tsi_form_read(context, work, input, k, &tspline, &elements);
    int done = status ? 0 : tspline.n ? -1 : -2;
    if (done == -1)
      done = tsi_tspline_to_patch(&assembly->arena, &tspline, input->points, &skin->patch);
    if (!status && !done)
      status = tsi_no_memory(context, stage);
    if (!status && done < 0)
      status =
          patch_from_elements(context, &assembly->arena, &elements, input->points, &skin->patch);
  } else {
    skin->refinable = 1;
    status = tsi_patch_vet(context, source, k);
    if (!status && !tsi_patch_read(&assembly->arena, source, &skin->patch))
      status = tsi_no_memory(context, stage);
  }
  if (status)
    return status;
  const int flip[2] = {0, 0};
  if (!tsi_patch_orient(&assembly->arena, &skin->patch, flip, 0, &skin->own) ||
      !copy_source(&assembly->arena, source, &skin->source))
    return tsi_no_memory(context, stage);
  place_patch(&assembly->part[skin->part], &skin->patch);
  return finish_skin(&assembly->arena, source, assembly->tolerance, skin)
             ? TSOLID_OK
             : tsi_no_memory(context, stage);
}

/* ---- parts -------------------------------------------------------------------------------------
 */

/* Any input as patches: six sides become patches of elements, a surface its NURBS patches. */
typedef struct patch_source {
  tsolid_boundary_input input;
  tsolid_patch side[6];
  tsolid_boundary_file *file;
} patch_source;

static tsolid_status open_source(tsolid_context *context, const tsolid_boundary_input *from,
                                 patch_source *source) {
  tsolid_status status = TSOLID_OK;
  *source = (patch_source){.file = NULL};
  if (!from || (from->bezier != NULL) + (from->patches != NULL) + (from->surface != NULL) != 1)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "The input must be patches, Bezier sides or a surface, one of the three");
  source->input = *from;
  if (from->surface) {
    status = tsolid_surface_patches(context, from->surface, &source->file);
    if (!status)
      source->input = *tsolid_boundary_file_input(source->file);
  } else if (from->bezier) {
    for (int k = 0; k < 6; k++)
      source->side[k].bezier = &from->bezier->side[k];
    source->input = (tsolid_boundary_input){.n_patches = 6,
                                            .patches = source->side,
                                            .n_points = from->bezier->n_functions,
                                            .points = from->bezier->points};
  }
  if (!status && (source->input.n_patches < 1 || source->input.n_patches > TSI_MAX_COUNT / 64))
    status = tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage, "There are %d patches",
                      source->input.n_patches);
  if (!status && source->input.n_points)
    status = tsi_points_check(context, source->input.n_points, source->input.points);
  return status;
}

static void measure_part(tsolid_assembly *assembly, tsi_member *part) {
  for (int c = 0; c < 3; c++) {
    part->box[c] = INFINITY;
    part->box[3 + c] = -INFINITY;
  }
  for (int k = part->first; k < part->end; k++) {
    const tsi_skin *skin = &assembly->skin[k];
    for (int c = 0; c < 3; c++) {
      part->box[c] = fmin(part->box[c], skin->box[c]);
      part->box[3 + c] = fmax(part->box[3 + c], skin->box[3 + c]);
    }
    part->bend = fmax(part->bend, skin->bend);
  }
  part->size = hypot(hypot(part->box[3] - part->box[0], part->box[4] - part->box[1]),
                     part->box[5] - part->box[2]);
}

static int reserve_skins(tsolid_assembly *assembly, int n, int *capacity) {
  if (n > TSI_MAX_COUNT / 64 - assembly->n_skins)
    return 0;
  if (assembly->n_skins + n <= *capacity)
    return 1;
  *capacity = 2 * (assembly->n_skins + n);
  tsi_skin *grown = tsi_arena_new(&assembly->arena, (size_t)*capacity, sizeof *grown);
  if (!grown)
    return 0;
  if (assembly->n_skins)
    memcpy(grown, assembly->skin, (size_t)assembly->n_skins * sizeof *grown);
  assembly->skin = grown;
  return 1;
}

/* Malformed parts are left out; only memory and cancelling end the whole. */
static tsolid_status read_part(tsolid_context *context, tsolid_assembly *assembly, int k,
                               const tsolid_part *from, int *capacity) {
  tsi_member *part = &assembly->part[k];
  patch_source source;
  tsi_arena work = tsi_arena_create(context);
  tsolid_status status = open_source(context, from->boundary, &source);
  int n = status ? 0 : source.input.n_patches;
  part->first = part->end = assembly->n_skins;
  part->n_patches = n;
  if (!status && !reserve_skins(assembly, n, capacity))
    status = tsi_no_memory(context, stage);
  for (int i = 0; !status && i < n; i++) {
    tsi_skin *skin = &assembly->skin[assembly->n_skins + i];
    *skin = (tsi_skin){.part = k, .number = i};
    status = read_skin(context, assembly, &work, &source.input, i, skin);
    skin->refinable &= from->boundary->patches != NULL;
  }
  if (!status && source.input.n_smooth > 0) {
    size_t n_smooth = (size_t)source.input.n_smooth;
    part->smooth = tsi_arena_new(&assembly->arena, n_smooth, sizeof *part->smooth);
    part->n_smooth = source.input.n_smooth;
    if (part->smooth)
      memcpy(part->smooth, source.input.smooth, n_smooth * sizeof *part->smooth);
    else
      status = tsi_no_memory(context, stage);
  }
  tsi_arena_free(&work);
  tsolid_boundary_file_free(source.file);
  if (status == TSOLID_ERROR_MEMORY || status == TSOLID_ERROR_CANCELLED)
    return status;
  part->status = status;
  if (status) {
    tsi_fail(context, status, stage, "%s is left out: it cannot be read", part->name);
    return TSOLID_OK;
  }
  assembly->n_skins += n;
  part->end = assembly->n_skins;
  measure_part(assembly, part);
  return TSOLID_OK;
}

static int is_identity(const double m[12]) {
  for (int i = 0; i < 12; i++)
    if (m[i] != (i % 5 == 0 ? 1.0 : 0.0))
      return 0;
  return 1;
}

static tsolid_status begin_part(tsolid_context *context, tsolid_assembly *assembly,
                                const tsolid_assembly_input *input, int k) {
  const tsolid_part *from = &input->parts[k];
  tsi_member *part = &assembly->part[k];
  for (int i = 0; i < 12; i++)
    part->placement[i] = from->placement ? from->placement[i] : i % 5 == 0 ? 1.0 : 0.0;
  part->name = name_part(&assembly->arena, from->name, k);
  if (!part->name)
    return tsi_no_memory(context, stage);
  part->placed = !is_identity(part->placement);
  return vet_placement(context, part, part->placement);
}

static int compare_inputs(const void *a, const void *b) {
  const tsolid_part *const *p = a, *const *q = b;
  uintptr_t x = (uintptr_t)(*p)->boundary, y = (uintptr_t)(*q)->boundary;
  if (x != y)
    return x < y ? -1 : 1;
  return (*p > *q) - (*p < *q);
}

/* The first part with the same input: copies are told by the pointer alone. */
static tsolid_status find_prototypes(tsolid_context *context, tsolid_assembly *assembly,
                                     const tsolid_assembly_input *input) {
  tsi_arena work = tsi_arena_create(context);
  int n = assembly->n_parts, first = 0;
  const tsolid_part **order = tsi_arena_new(&work, (size_t)n, sizeof *order);
  if (!order)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < n; k++)
    order[k] = &input->parts[k];
  qsort(order, (size_t)n, sizeof *order, compare_inputs);
  for (int k = 0; k < n; k++) {
    if (k == 0 || order[k]->boundary != order[k - 1]->boundary)
      first = (int)(order[k] - input->parts);
    assembly->part[order[k] - input->parts].prototype = first;
  }
  tsi_arena_free(&work);
  return TSOLID_OK;
}

tsolid_status tsi_assembly_read(tsolid_context *context, tsolid_assembly *assembly,
                                const tsolid_assembly_input *input) {
  int n = input->n_parts, capacity = 0;
  assembly->part = tsi_arena_new(&assembly->arena, (size_t)n, sizeof *assembly->part);
  if (!assembly->part)
    return tsi_no_memory(context, stage);
  assembly->n_parts = n;
  tsolid_status status = find_prototypes(context, assembly, input);
  for (int k = 0; !status && k < n; k++)
    status = begin_part(context, assembly, input, k);
  for (int k = 0; !status && k < n; k++) {
    status = read_part(context, assembly, k, &input->parts[k], &capacity);
    if (!status)
      status = tsi_progress(context, stage, 0.3 * (k + 1) / n);
  }
  if (status)
    return status;
  double *box = tsi_arena_new(&assembly->arena, (size_t)assembly->n_skins, 6 * sizeof *box);
  if (!box)
    return tsi_no_memory(context, stage);
  for (int k = 0; k < assembly->n_skins; k++)
    memcpy(box + 6 * k, assembly->skin[k].box, 6 * sizeof *box);
  assembly->bvh = tsi_bvh_create(&assembly->allocator, assembly->n_skins, box);
  return assembly->bvh ? TSOLID_OK : tsi_no_memory(context, stage);
}
