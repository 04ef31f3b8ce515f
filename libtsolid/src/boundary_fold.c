/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Sides that fold over themselves.
 *
 * On a side x(s,t) let c = x_s x x_t. At a point of the boundary det J is c . x_r, so where c = 0
 * inside a side no solid is valid. Surfaces of CAD systems have such places where a section that is
 * swept along a curve turns too fast, or a bend is tighter than the section: pinch points, around
 * which c turns once (Whitney's cross-cap), or curves across which c turns back.
 *
 * Both are found by the same descent: a cell of a Bezier element, of whose corners two have c more
 * than a right angle apart, is quartered. c is a smooth function on the element; if two places have
 * opposite c however small the cell, then c = 0 in it. Cells where c has no direction beyond
 * round-off tell nothing: these are the singular corners that the certificate names. An element is
 * passed over when the cone of all its net's legs along s and that of those along t have no line in
 * common. */
#include "boundary_fold.h"
#include "boundary_bound.h"
#include "vector.h"

static const char stage[] = "boundary";

enum { BASE_DEPTH = 3, MAX_DEPTH = 14, MAX_CELLS = 2000 };

/* Relative: of less the corners are not exact far from the origin (see boundary_bound.h). */
static const double NO_DIRECTION = 1e-6;

typedef struct cell {
  double x, y;
  int depth;
} cell;

/* ---- elements that cannot fold
 * -------------------------------------------------------------------------------------------- */

typedef struct cone {
  double axis[3], cosine; /* of the half angle */
} cone;

static int make_unit(double v[3]) {
  double length = sqrt(tsi_dot3(v, v));
  for (int c = 0; c < 3 && length > 0.0; c++)
    v[c] /= length;
  return length > 0.0;
}

/* The unit leg from a control point to the next one in direction d. */
static int leg_of(const tsi_patch_net *net, int i, int j, int d, double leg[3]) {
  size_t n = (size_t)net->degree[0] + 1, k = (size_t)i + n * (size_t)j, next = k + (d ? n : 1);
  for (size_t c = 0; c < 3; c++)
    leg[c] = net->point[4 * next + c] / net->point[4 * next + 3] -
             net->point[4 * k + c] / net->point[4 * k + 3];
  return make_unit(leg);
}

/* 0: a leg has no length, or they go all ways. */
static int make_cone(const tsi_patch_net *net, int d, cone *legs) {
  double leg[3];
  *legs = (cone){.cosine = 1.0};
  for (int pass = 0; pass < 2; pass++) {
    for (int j = 0; j <= net->degree[1] - d; j++)
      for (int i = 0; i <= net->degree[0] - (1 - d); i++) {
        if (!leg_of(net, i, j, d, leg))
          return 0;
        for (int c = 0; c < 3 && pass == 0; c++)
          legs->axis[c] += leg[c];
        if (pass == 1)
          legs->cosine = fmin(legs->cosine, tsi_dot3(legs->axis, leg));
      }
    if (pass == 0 && !make_unit(legs->axis))
      return 0;
  }
  return legs->cosine > 0.0;
}

static int cannot_fold(const tsi_patch_net *net) {
  cone legs[2];
  if (!make_cone(net, 0, &legs[0]) || !make_cone(net, 1, &legs[1]))
    return 0;
  double between = acos(fmin(fabs(tsi_dot3(legs[0].axis, legs[1].axis)), 1.0));
  return acos(fmin(legs[0].cosine, 1.0)) + acos(fmin(legs[1].cosine, 1.0)) < between;
}

/* ---- the descent
 * ---------------------------------------------------------------------------------------------- */

static int turns_back(const tsi_patch_net *net, const cell *at, double size) {
  double point[3], normal[4][3];
  for (int k = 0; k < 4; k++) {
    tsi_net_normal(net, at->x + size * (k & 1), at->y + size * (k >> 1), point, normal[k]);
    for (int i = 0; i < k; i++)
      if (tsi_dot3(normal[k], normal[k]) > NO_DIRECTION * NO_DIRECTION &&
          tsi_dot3(normal[i], normal[i]) > NO_DIRECTION * NO_DIRECTION &&
          tsi_dot3(normal[k], normal[i]) < 0.0)
        return 1;
  }
  return 0;
}

/* Whether the element folds, and the lower corner of a cell where it does. */
static int folds(const tsi_patch_net *net, double local[2]) {
  cell stack[3 * MAX_DEPTH + 4] = {{0.0, 0.0, 0}};
  int n = 1;
  for (int n_cells = 0; n > 0 && n_cells < MAX_CELLS; n_cells++) {
    cell at = stack[--n];
    double size = ldexp(1.0, -at.depth);
    if (at.depth >= BASE_DEPTH && !turns_back(net, &at, size))
      continue;
    if (at.depth == MAX_DEPTH) {
      local[0] = at.x;
      local[1] = at.y;
      return 1;
    }
    for (int k = 3; k >= 0; k--)
      stack[n++] = (cell){at.x + 0.5 * size * (k & 1), at.y + 0.5 * size * (k >> 1), at.depth + 1};
  }
  return 0;
}

/* ---- findings
 * -------------------------------------------------------------------------------------------------
 */

/* The input patch that has this place of a side; -1: it is not known. */
static int patch_at(const tsolid_boundary *boundary, int side, double s, double t) {
  for (int k = 0; k < boundary->n_patches; k++)
    for (int i = boundary->placement_start[k]; i < boundary->placement_start[k + 1]; i++) {
      const tsolid_placement *p = &boundary->placement[i];
      if (p->side == side && s >= p->box[0] && s <= p->box[1] && t >= p->box[2] && t <= p->box[3])
        return k;
    }
  return -1;
}

static tsolid_status refuse(tsolid_context *context, const tsolid_boundary *boundary, int side,
                            int element, const tsi_patch_net *net, const double local[2]) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  const double *box = boundary->side[side].box + 4 * (size_t)element;
  double normal[3];
  int patch = patch_at(boundary, side, box[0] + local[0] * (box[1] - box[0]),
                       box[2] + local[1] * (box[3] - box[2]));
  finding.entity = patch < 0 ? TSOLID_ENTITY_SIDE : TSOLID_ENTITY_PATCH;
  finding.index[0] = patch < 0 ? side : patch;
  finding.has_point = 1;
  tsi_net_normal(net, local[0], local[1], finding.point, normal);
  return tsi_report(context, &finding,
                    "The face folds over itself here, so that no solid with it is valid: a section "
                    "that turns too fast along its path, or a bend that is tighter than the "
                    "section, makes such faces");
}

tsolid_status tsi_boundary_check_folds(tsolid_context *context, const tsolid_boundary *boundary) {
  tsolid_status status = TSOLID_OK;
  for (int side = 0; side < 6; side++)
    for (int e = 0; e < boundary->side[side].n_elements; e++) {
      tsi_patch_net net;
      double local[2];
      tsi_net_load(boundary, side, e, &net);
      if (cannot_fold(&net) || !folds(&net, local))
        continue;
      status = refuse(context, boundary, side, e, &net, local);
      break; /* one place a side */
    }
  return status;
}
