/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Contacts that are not exact: how far two patches are apart.
 *
 * The gap over a point x of the smaller patch is its distance d(x) to the other one (its foot).
 * The patches face each other where the normals are opposite and x lies over the other patch, not
 * beside it. Where the four corners are near those of the other, the whole patch counts, also what
 * juts out: then the largest d is the (one-sided) Hausdorff distance, and both sides are asked.
 *
 * d is sampled on a grid and its largest and smallest value refined by a compass search from the
 * best sample: steps in eight directions that are halved when none is better. d is as smooth as the
 * patches, so that the value converges with the square of the step. */
#include "assembly.h"

enum { N_GRID = 9, HALVINGS = 26 };

static const double facing = 0.7;   /* cosine */
static const double tangent = 0.05; /* of a displacement that is normal */

typedef struct sample {
  double uv[2], foot[2];
  double distance, signed_distance; /* of the foot over the patch; negative: inside */
  double point[3], middle[3];       /* half way to the foot */
  int over, opposite;
} sample;

typedef struct sampler {
  const tsi_skin *a, *b;
  double tolerance;
  int whole, largest;
} sampler;

static void take_sample(const sampler *s, double u, double v, const double *near, sample *out) {
  double n[2][3], y[3], d[3], across = 0.0;
  tsi_foot foot;
  out->uv[0] = u;
  out->uv[1] = v;
  int regular = tsi_skin_normal(s->a, u, v, out->point, n[0]);
  tsi_foot_find(s->b, out->point, near, &foot);
  memcpy(out->foot, foot.uv, sizeof out->foot);
  out->distance = foot.distance;
  regular &= tsi_skin_normal(s->b, foot.uv[0], foot.uv[1], y, n[1]);
  for (int c = 0; c < 3; c++)
    d[c] = foot.point[c] - out->point[c];
  for (int c = 0; c < 3; c++)
    out->middle[c] = out->point[c] + 0.5 * d[c];
  double cosine = tsi_dot3(n[0], n[1]), along = tsi_dot3(d, n[1]);
  for (int c = 0; c < 3; c++)
    across += (d[c] - along * n[1][c]) * (d[c] - along * n[1][c]);
  out->opposite = s->a->outward == 0 || s->b->outward == 0 || cosine < 0.0;
  out->over = regular && fabs(cosine) > facing &&
              sqrt(across) <= tangent * foot.distance + s->tolerance &&
              (out->opposite || foot.distance <= s->tolerance);
  out->signed_distance = copysign(foot.distance, tsi_dot3(d, n[0]));
}

/* Without a foot: not over the other patch, whatever its foot is. */
static int is_beside(const sampler *s, double u, double v) {
  double x[3], normal[3], outside = 0.0;
  const tsi_skin *b = s->b;
  if (!tsi_skin_normal(s->a, u, v, x, normal))
    return 0;
  double cosine = tsi_dot3(normal, b->mean), angle = acos(fmin(fabs(cosine), 1.0));
  if (angle - b->cone > acos(facing))
    return 1;
  for (int c = 0; c < 3; c++)
    outside = fmax(outside, fmax(b->box[c] - x[c], x[c] - b->box[3 + c]));
  return s->a->outward != 0 && b->outward != 0 && acos(fmin(cosine, 1.0)) + b->cone < 1.5 &&
         outside > s->tolerance;
}

static double value_of(const sampler *s, const sample *x) {
  if (!s->whole && !x->over)
    return -INFINITY;
  return s->largest ? x->distance : -x->distance;
}

/* Compass search from *best. */
static void refine(const sampler *s, sample *best) {
  double step = 1.0 / N_GRID;
  for (int k = 0; k < HALVINGS;) {
    int moved = 0;
    for (int i = 0; i < 9 && !moved; i++) {
      sample next;
      double u = fmin(fmax(best->uv[0] + step * (i % 3 - 1), 0.0), 1.0);
      double v = fmin(fmax(best->uv[1] + step * (i / 3 - 1), 0.0), 1.0);
      if (i == 4 || (u == best->uv[0] && v == best->uv[1]))
        continue;
      take_sample(s, u, v, best->foot, &next);
      if (value_of(s, &next) > value_of(s, best)) {
        *best = next;
        moved = 1;
      }
    }
    if (!moved) {
      step *= 0.5;
      k++;
    }
  }
}

typedef struct survey {
  int n_over, n_near, n_touch, n_same; /* samples over the other; nearer than reach; touching */
  sample most, least, deepest;
} survey;

static void take_survey(sampler *s, double reach, survey *found) {
  *found = (survey){.most = {.distance = -1.0}, .least = {.distance = INFINITY}};
  for (int j = 0; j < N_GRID; j++)
    for (int i = 0; i < N_GRID; i++) {
      sample x;
      /* in the middles of cells, or from border to border */
      double u = s->whole ? (double)i / (N_GRID - 1) : (i + 0.5) / N_GRID;
      double v = s->whole ? (double)j / (N_GRID - 1) : (j + 0.5) / N_GRID;
      if (!s->whole && is_beside(s, u, v))
        continue;
      take_sample(s, u, v, NULL, &x);
      found->n_over += x.over;
      if (!(x.over || s->whole) || x.distance > reach)
        continue;
      found->n_near += x.over;
      found->n_touch += x.over && x.distance <= s->tolerance;
      found->n_same += x.over && !x.opposite;
      if (x.distance > found->most.distance)
        found->most = x;
      if (x.distance < found->least.distance)
        found->least = x;
      if (x.over && x.opposite &&
          -x.signed_distance > fmax(found->deepest.distance, s->tolerance)) {
        found->deepest = x;
        found->deepest.distance = -x.signed_distance;
      }
    }
}

/* Whether any of the samples may lie within reach at all: boxes, then the coarse grid. */
static int may_meet(const tsi_skin *a, const tsi_skin *b, double reach) {
  int wide = 0;
  for (int c = 0; c < 3; c++) {
    double low = fmax(a->box[c], b->box[c]), high = fmin(a->box[3 + c], b->box[3 + c]);
    if (low > high + reach)
      return 0;
    wide += high + reach > low;
  }
  return wide == 3;
}

static int corners_near(const tsi_skin *a, const tsi_skin *b, double reach) {
  int used[4] = {0, 0, 0, 0};
  for (int k = 0; k < 4; k++) {
    int best = -1;
    for (int m = 0; m < 4; m++) {
      double d = tsi_distance(a->corner[k], b->corner[m]);
      if (!used[m] && d <= reach && best < 0)
        best = m;
    }
    if (best < 0)
      return 0;
    used[best] = 1;
  }
  return 1;
}

/* The smaller one is sampled, and for whole patches the larger one as well. */
void tsi_measure_gap(const tsolid_assembly *assembly, int a, int b, double reach,
                     tsi_contact *contact, int *found) {
  const tsi_skin *p = &assembly->skin[a], *q = &assembly->skin[b];
  tsolid_interface *view = &contact->view;
  *found = 0;
  if (!may_meet(p, q, reach) || tsi_skin_angle(p, q) > acos(facing))
    return;
  int swap = p->area > q->area, whole = corners_near(p, q, 2.0 * reach);
  double tolerance = fmax(p->tolerance, q->tolerance);
  sampler s = {swap ? q : p, swap ? p : q, tolerance, whole, 1};
  survey found_by[2];
  take_survey(&s, reach, &found_by[0]);
  if (found_by[0].n_near == 0 || found_by[0].n_near < 9 * found_by[0].n_over / 10)
    return;
  for (int side = 0; side < 1 + whole; side++) {
    if (side) {
      const tsi_skin *other = s.a;
      s.a = s.b;
      s.b = other;
      take_survey(&s, reach, &found_by[1]);
    }
    sample most = found_by[side].most, least = found_by[side].least;
    if (most.distance < 0.0)
      continue;
    s.largest = 1;
    refine(&s, &most);
    if (side == 0 || most.distance > view->gap) {
      view->gap = most.distance;
      memcpy(view->point, most.point, sizeof view->point);
    }
    s.largest = 0;
    refine(&s, &least);
    if (side == 0 || least.distance < view->smallest_gap)
      memcpy(contact->middle, least.middle, sizeof contact->middle);
    if (found_by[side].deepest.distance > view->depth)
      memcpy(contact->deepest, found_by[side].deepest.middle, sizeof contact->deepest);
    view->smallest_gap = side ? fmin(view->smallest_gap, least.distance) : least.distance;
    view->depth = fmax(view->depth, found_by[side].deepest.distance);
  }
  view->same_side = 2 * found_by[0].n_same > found_by[0].n_near;
  view->kind = view->gap <= tolerance ? TSOLID_CONTACT_COINCIDENT : TSOLID_CONTACT_NEAR;
  *found = 1;
}
