/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Which side of a patch is the outside of its part.
 *
 * Two borders with the same ends and the same middle, within their tolerance, are a seam. Along a
 * seam of two patches that are oriented alike the border is walked in opposite directions, so the
 * orientation of one goes on to the other; where all borders of a connected set are seams, the set
 * is closed, and its normals point outward when the flux of x through it is positive. Else (parts
 * that are open or whose borders meet in pieces) both points near the middle of each patch are
 * tested by parity. */
#include <stdlib.h>

#include "assembly.h"
#include "bvh.h"

static const char stage[] = "assembly";

enum { POLE = -2, N_SAMPLES = 5 };

typedef struct border_points {
  double point[N_SAMPLES][3]; /* at 0, 1/4, 1/2, 3/4, 1 */
} border_points;

typedef struct seam_search {
  const tsi_skin *skin;
  const border_points *border;
  int first, slot, best, reversed;
  double best_distance;
} seam_search;

/* Mean distance of the samples, the other walked backwards or not; infinite: ends apart. */
static double compare_borders(const border_points *a, const border_points *b, int reversed,
                              double tolerance) {
  double sum = 0.0;
  for (int i = 0; i < N_SAMPLES; i++) {
    double d = tsi_distance(a->point[i], b->point[reversed ? N_SAMPLES - 1 - i : i]);
    if ((i == 0 || i == N_SAMPLES - 1) && d > tolerance)
      return INFINITY;
    sum += d;
  }
  return sum;
}

static int visit_border(void *data, int item) {
  seam_search *s = data;
  if (item == s->slot)
    return 0;
  double tolerance =
      fmax(s->skin[s->first + s->slot / 4].tolerance, s->skin[s->first + item / 4].tolerance);
  for (int reversed = 1; reversed >= 0; reversed--) {
    double d = compare_borders(&s->border[s->slot], &s->border[item], reversed, tolerance);
    if (d < s->best_distance) {
      s->best_distance = d;
      s->best = item;
      s->reversed = reversed;
    }
  }
  return 0;
}

static double length_of(const border_points *b) {
  double length = 0.0;
  for (int i = 1; i < N_SAMPLES; i++)
    length += tsi_distance(b->point[i], b->point[i - 1]);
  return length;
}

static struct tsi_bvh *sample_borders(const tsolid_assembly *assembly, const tsi_member *part,
                                      border_points *border, double *box) {
  for (int k = 0; k < 4 * (part->end - part->first); k++) {
    const tsi_skin *skin = &assembly->skin[part->first + k / 4];
    for (int i = 0; i < N_SAMPLES; i++) {
      double uv[2];
      tsi_border_point(k % 4, 0.25 * i, uv);
      tsi_skin_point(skin, uv[0], uv[1], border[k].point[i]);
    }
    for (int c = 0; c < 3; c++) { /* the middle of both ends is found from either side */
      double middle = 0.5 * (border[k].point[0][c] + border[k].point[N_SAMPLES - 1][c]);
      box[6 * k + c] = middle - skin->tolerance;
      box[6 * k + 3 + c] = middle + skin->tolerance;
    }
  }
  return tsi_bvh_create(&assembly->allocator, 4 * (part->end - part->first), box);
}

/* Fills mate of the part's skins and walk[slot]: the mate is walked the other way. */
static tsolid_status find_seams(tsolid_context *context, tsolid_assembly *assembly,
                                tsi_member *part, unsigned char *walk) {
  int n = 4 * (part->end - part->first);
  tsi_arena work = tsi_arena_create(context);
  border_points *border = tsi_arena_new(&work, (size_t)n, sizeof *border);
  double *box = tsi_arena_new(&work, (size_t)n, 6 * sizeof *box);
  int *best = tsi_arena_new(&work, (size_t)n, sizeof *best);
  struct tsi_bvh *bvh = border && box && best ? sample_borders(assembly, part, border, box) : NULL;
  tsolid_status status = bvh ? TSOLID_OK : tsi_no_memory(context, stage);
  for (int k = 0; !status && k < n; k++) {
    seam_search s = {.skin = assembly->skin,
                     .border = border,
                     .first = part->first,
                     .slot = k,
                     .best = -1,
                     .best_distance = 0.25 * length_of(&border[k])};
    if (length_of(&border[k]) <= assembly->skin[part->first + k / 4].tolerance)
      s.best = POLE;
    else
      tsi_bvh_overlapping(bvh, box + 6 * k, 0.0, visit_border, &s);
    best[k] = s.best;
    walk[k] = (unsigned char)s.reversed;
  }
  part->closed = 1;
  for (int k = 0; !status && k < n; k++) {
    int mutual = best[k] == POLE || (best[k] >= 0 && best[best[k]] == k);
    int *mate = &assembly->skin[part->first + k / 4].mate[k % 4];
    *mate = best[k] == POLE ? POLE : mutual ? 4 * part->first + best[k] : -1;
    part->closed &= mutual;
  }
  tsi_bvh_free(bvh);
  tsi_arena_free(&work);
  return status;
}

/* ---- normals -----------------------------------------------------------------------------------
 */

/* Orients what hangs together with skin `seed` like it; returns whether that is closed and of one
 * orientation. member lists it. */
static int spread(tsolid_assembly *assembly, const tsi_member *part, const unsigned char *walk,
                  int seed, int *member, int *n_members) {
  int closed = 1;
  *n_members = 0;
  assembly->skin[seed].outward = 1;
  member[(*n_members)++] = seed;
  for (int i = 0; i < *n_members; i++) {
    const tsi_skin *skin = &assembly->skin[member[i]];
    for (int b = 0; b < 4; b++) {
      int mate = skin->mate[b];
      if (mate < 0) {
        closed &= mate == POLE;
        continue;
      }
      int alike = walk[4 * (member[i] - part->first) + b];
      int expected = alike ? skin->outward : -skin->outward;
      tsi_skin *other = &assembly->skin[mate / 4];
      if (other->outward == 0) {
        other->outward = expected;
        member[(*n_members)++] = mate / 4;
      } else {
        closed &= other->outward == expected;
      }
    }
  }
  return closed;
}

/* The normal's side by the parity of both points beside a point of the patch. */
static int test_side(const tsi_member *part, tsi_skin *skin) {
  static const double place[5][2] = {{0.5, 0.5}, {0.3, 0.6}, {0.7, 0.4}, {0.45, 0.2}, {0.6, 0.8}};
  skin->outward = 0;
  for (int k = 0; k < 5; k++) {
    double x[3], normal[3], both[2][3];
    if (!tsi_skin_normal(skin, place[k][0], place[k][1], x, normal))
      continue;
    for (int step = 0; step < 3; step++) {
      static const double factor[3] = {4.0, 1.5, 16.0};
      double h = fmax(factor[step] * skin->bend, 1e-4 * factor[step] * skin->size);
      for (int c = 0; c < 3; c++) {
        both[0][c] = x[c] + h * normal[c];
        both[1][c] = x[c] - h * normal[c];
      }
      int out = tsi_inside(part, both[0]), in = tsi_inside(part, both[1]);
      if (in != out)
        return in ? 1 : -1;
    }
  }
  return 0;
}

static void orient_part(tsolid_assembly *assembly, const tsi_member *part,
                        const unsigned char *walk, int *member) {
  for (int seed = part->first; seed < part->end; seed++) {
    int n_members;
    double flux = 0.0;
    if (assembly->skin[seed].outward)
      continue;
    int closed = spread(assembly, part, walk, seed, member, &n_members);
    for (int i = 0; i < n_members; i++)
      flux += assembly->skin[member[i]].outward * assembly->skin[member[i]].flux;
    for (int i = 0; i < n_members; i++) {
      tsi_skin *skin = &assembly->skin[member[i]];
      if (flux < 0.0)
        skin->outward = -skin->outward;
      if (!closed)
        skin->outward = 2; /* to be tested below: 0 means not yet visited */
    }
  }
  for (int k = part->first; k < part->end; k++) {
    tsi_skin *skin = &assembly->skin[k];
    if (skin->outward == 2)
      skin->outward = test_side(part, skin);
    for (int c = 0; c < 3 && skin->outward < 0; c++)
      skin->mean[c] = -skin->mean[c];
    if (skin->outward < 0)
      skin->flux = -skin->flux;
  }
}

tsolid_status tsi_assembly_orient(tsolid_context *context, tsolid_assembly *assembly) {
  tsi_arena work = tsi_arena_create(context);
  unsigned char *walk = tsi_arena_new(&work, (size_t)assembly->n_skins, 4);
  int *member = tsi_arena_new(&work, (size_t)assembly->n_skins, sizeof *member);
  tsolid_status status = walk && member ? TSOLID_OK : tsi_no_memory(context, stage);
  for (int k = 0; !status && k < assembly->n_skins; k++) {
    tsi_skin *skin = &assembly->skin[k];
    tsi_patch_measure(&skin->patch, assembly->origin, &skin->area, &skin->flux);
  }
  for (int p = 0; !status && p < assembly->n_parts; p++) {
    tsi_member *part = &assembly->part[p];
    if (part->first == part->end)
      continue;
    status = find_seams(context, assembly, part, walk);
    if (!status)
      status = tsi_inside_create(context, assembly, p);
    if (!status)
      orient_part(assembly, part, walk, member);
  }
  tsi_arena_free(&work);
  return status;
}
