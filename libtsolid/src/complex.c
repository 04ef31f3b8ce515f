/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stdio.h>
#include <stdlib.h>

#include "complex.h"
#include "patch.h"

static const char stage[] = "boundary";

enum { MAX_SAME_ENDS = 16, MAX_SHOWN = 20, MAX_GAP_SEARCH = 64 };

/* Two borders with the same ends are sides of one edge when their samples are no farther apart than
 * this part of their length (the exact comparison comes later, row by row); they coincide with a
 * third when nearer than the second. */
static const double same_edge = 0.25, coincident = 1e-3;

const char *tsi_name_border(const tsi_facet *facet, int b, char text[TSI_BORDER_NAME_SIZE]) {
  char name[TSI_NAME_SIZE], border[TSI_NAME_SIZE];
  tsi_name_facet(facet, name);
  if (facet->border_name[b] && *facet->border_name[b])
    tsi_name_patch(facet->border_name[b], b, border);
  else
    snprintf(border, sizeof border, "border %d", b);
  snprintf(text, TSI_BORDER_NAME_SIZE, "%s of %s", border, name);
  return text;
}

tsolid_finding tsi_violation(tsi_complex *c, tsolid_entity entity, int k, int part) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  c->requirement->n_violations++;
  finding.entity = entity;
  if (entity == TSOLID_ENTITY_NONE)
    return finding;
  const tsi_facet *facet = &c->facet[k];
  finding.index[0] = facet->patch;
  finding.index[1] = part;
  if ((entity == TSOLID_ENTITY_BORDER && facet->is_cut[part]) ||
      (entity == TSOLID_ENTITY_VERTEX && facet->is_inner[part])) {
    finding.entity = TSOLID_ENTITY_PATCH; /* the input's patch has no such part */
    finding.index[1] = 0;
  }
  return finding;
}

void tsi_set_point(tsolid_finding *finding, const double point[3]) {
  finding->has_point = 1;
  memcpy(finding->point, point, 3 * sizeof *point);
}

static double max_of(double a, double b) {
  return a > b ? a : b;
}

static double min_of(double a, double b) {
  return a < b ? a : b;
}

int tsi_compare_points(const double a[3], const double b[3]) {
  for (int c = 0; c < 3; c++)
    if (a[c] != b[c])
      return a[c] < b[c] ? -1 : 1;
  return 0;
}

/* ---- facets by themselves -------------------------------------------------------------------- */

static void check_facet(tsi_complex *c, int k) {
  const tsi_facet *facet = &c->facet[k];
  char name[TSI_NAME_SIZE], border[TSI_BORDER_NAME_SIZE];
  tsi_name_facet(facet, name);
  double longest = 0.0, tolerance = 0.0;
  int poles = 0;
  for (int b = 0; b < 4; b++) {
    tsi_name_border(facet, b, border);
    longest = max_of(longest, facet->length[b]);
    tolerance = max_of(tolerance, facet->tolerance[b]);
    if (facet->length[b] <= 2.0 * facet->tolerance[b]) {
      tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_BORDER, k, b);
      tsi_set_point(&finding, facet->corner[b]);
      finding.measured = facet->length[b];
      finding.allowed = 2.0 * facet->tolerance[b];
      tsi_report(c->context, &finding,
                 "%s is a pole: the border has no length (%.3g), so the face has fewer than four "
                 "borders",
                 border, facet->length[b]);
      poles++;
    } else if (tsi_distance(facet->corner[b], facet->corner[(b + 1) % 4]) <= facet->tolerance[b]) {
      tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_BORDER, k, b);
      tsi_set_point(&finding, facet->corner[b]);
      tsi_report(c->context, &finding,
                 "%s ends where it starts: the periodic face has to be cut into pieces first",
                 border);
      poles++;
    }
  }
  if (!poles && facet->area <= tolerance * longest) {
    tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_PATCH, k, 0);
    tsi_set_point(&finding, facet->centre);
    finding.measured = facet->area;
    finding.allowed = tolerance * longest;
    tsi_report(c->context, &finding,
               "%s has no area (%.3g): two of its borders, which should be different isolines, "
               "coincide",
               name, facet->area);
  }
}

static tsolid_status refuse_violations(const tsi_complex *c) {
  return c->requirement->n_violations ? TSOLID_ERROR_REFUSED : TSOLID_OK;
}

tsolid_status tsi_complex_check_facets(tsi_complex *c) {
  for (int k = 0; k < c->n; k++)
    check_facet(c, k);
  return refuse_violations(c);
}

/* ---- vertices -------------------------------------------------------------------------------- */

typedef struct cell_entry {
  double cell[3];
  int corner;
} cell_entry;

static int compare_cells(const void *a, const void *b) {
  const cell_entry *p = a, *q = b;
  int order = tsi_compare_points(p->cell, q->cell);
  return order ? order : (p->corner > q->corner) - (p->corner < q->corner);
}

static int find_root(int *parent, int i) {
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}

static void unite(int *parent, int i, int j) {
  i = find_root(parent, i);
  j = find_root(parent, j);
  if (i < j)
    parent[j] = i;
  else
    parent[i] = j;
}

/* First entry that is not below `cell`. */
static int find_cell(int n, const cell_entry *entry, const double cell[3]) {
  int low = 0, high = n;
  while (low < high) {
    int middle = low + (high - low) / 2;
    if (tsi_compare_points(entry[middle].cell, cell) < 0)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

static double corner_tolerance(const tsi_complex *c, int corner) {
  const tsi_facet *facet = &c->facet[corner / 4];
  int b = corner % 4;
  return max_of(facet->tolerance[b], facet->tolerance[(b + 3) % 4]);
}

static const double *corner_point(const tsi_complex *c, int corner) {
  return c->facet[corner / 4].corner[corner % 4];
}

static void unite_near(const tsi_complex *c, const cell_entry *entry, int i, int *parent) {
  for (int step = 0; step < 27; step++) {
    double cell[3] = {entry[i].cell[0] + step % 3 - 1, entry[i].cell[1] + step / 3 % 3 - 1,
                      entry[i].cell[2] + step / 9 - 1};
    int a = entry[i].corner;
    for (int j = find_cell(4 * c->n, entry, cell);
         j < 4 * c->n && tsi_compare_points(entry[j].cell, cell) == 0; j++) {
      int b = entry[j].corner;
      if (b < a && tsi_distance(corner_point(c, a), corner_point(c, b)) <=
                       max_of(corner_tolerance(c, a), corner_tolerance(c, b)))
        unite(parent, a, b);
    }
  }
}

/* Facet corners within the tolerance of each other, in chains, are one vertex. Space is hashed into
 * cells of the tolerance's width, kept as a sorted list. */
tsolid_status tsi_complex_find_vertices(tsi_complex *c) {
  int n = 4 * c->n;
  cell_entry *entry = tsi_arena_new(c->arena, (size_t)n, sizeof *entry);
  int *parent = tsi_arena_new(c->arena, (size_t)n, sizeof *parent);
  c->vertex = tsi_arena_new(c->arena, (size_t)n, sizeof *c->vertex);
  c->point = tsi_arena_new(c->arena, (size_t)n, sizeof *c->point);
  if (!entry || !parent || !c->vertex || !c->point)
    return tsi_no_memory(c->context, stage);
  double width = 0.0;
  for (int i = 0; i < n; i++)
    width = max_of(width, corner_tolerance(c, i));
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < 3; k++)
      entry[i].cell[k] = floor(corner_point(c, i)[k] / width);
    entry[i].corner = parent[i] = i;
  }
  qsort(entry, (size_t)n, sizeof *entry, compare_cells);
  for (int i = 0; i < n; i++)
    unite_near(c, entry, i, parent);
  for (int i = 0; i < n; i++) {
    int root = find_root(parent, i);
    const double *point = corner_point(c, i);
    if (root == i) {
      c->vertex[i] = c->n_vertices++;
      memcpy(c->point[c->vertex[i]], point, sizeof *c->point);
    } else {
      c->vertex[i] = c->vertex[root];
      if (tsi_compare_points(point, c->point[c->vertex[i]]) < 0)
        memcpy(c->point[c->vertex[i]], point, sizeof *c->point);
    }
  }
  c->requirement->n_vertices = c->n_vertices;
  return TSOLID_OK;
}

/* ---- duplicates ------------------------------------------------------------------------------ */

typedef struct facet_key {
  int vertex[4]; /* ascending */
  int facet;
} facet_key;

static int compare_keys(const void *a, const void *b) {
  const facet_key *p = a, *q = b;
  for (int i = 0; i < 4; i++)
    if (p->vertex[i] != q->vertex[i])
      return p->vertex[i] < q->vertex[i] ? -1 : 1;
  return (p->facet > q->facet) - (p->facet < q->facet);
}

static void make_key(const tsi_complex *c, int k, facet_key *key) {
  key->facet = k;
  for (int i = 0; i < 4; i++) {
    int v = c->vertex[4 * k + i], j = i;
    for (; j > 0 && key->vertex[j - 1] > v; j--)
      key->vertex[j] = key->vertex[j - 1];
    key->vertex[j] = v;
  }
}

tsolid_status tsi_complex_find_duplicates(tsi_complex *c) {
  facet_key *key = tsi_arena_new(c->arena, (size_t)c->n, sizeof *key);
  if (!key)
    return tsi_no_memory(c->context, stage);
  for (int k = 0; k < c->n; k++)
    make_key(c, k, &key[k]);
  qsort(key, (size_t)c->n, sizeof *key, compare_keys);
  for (int i = 1; i < c->n; i++) {
    int a = key[i - 1].facet, b = key[i].facet;
    if (memcmp(key[i - 1].vertex, key[i].vertex, sizeof key->vertex) != 0)
      continue;
    double distance = tsi_distance(c->facet[a].centre, c->facet[b].centre);
    if (distance > 10.0 * max_of(c->facet[a].tolerance[0], c->facet[b].tolerance[0]))
      continue;
    char name[2][TSI_NAME_SIZE];
    tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_PATCH, b, 0);
    tsi_set_point(&finding, c->facet[b].centre);
    tsi_report(c->context, &finding, "%s is a duplicate of %s",
               tsi_name_facet(&c->facet[b], name[1]), tsi_name_facet(&c->facet[a], name[0]));
  }
  return refuse_violations(c);
}

/* ---- borders --------------------------------------------------------------------------------- */

typedef struct border_entry {
  int low, high; /* end vertices */
  int slot;
} border_entry;

static int compare_borders(const void *a, const void *b) {
  const border_entry *p = a, *q = b;
  if (p->low != q->low)
    return p->low < q->low ? -1 : 1;
  if (p->high != q->high)
    return p->high < q->high ? -1 : 1;
  return (p->slot > q->slot) - (p->slot < q->slot);
}

static const double *border_sample(const tsi_complex *c, int slot, int i, int backwards) {
  return c->facet[slot / 4].sample[slot % 4][backwards ? 2 - i : i];
}

/* Largest distance of the samples of two borders between the same two vertices. */
static double compare_geometry(const tsi_complex *c, int a, int b) {
  int backwards = c->vertex[a] != c->vertex[b]; /* slot and corner indices coincide */
  double distance = 0.0;
  for (int i = 0; i < 3; i++)
    distance = max_of(distance,
                      tsi_distance(border_sample(c, a, i, 0), border_sample(c, b, i, backwards)));
  return distance;
}

static double border_length(const tsi_complex *c, int slot) {
  return c->facet[slot / 4].length[slot % 4];
}

static double border_tolerance(const tsi_complex *c, int slot) {
  return c->facet[slot / 4].tolerance[slot % 4];
}

static int is_within(const tsi_complex *c, int a, int b, double distance, double part) {
  double allowed = part * min_of(border_length(c, a), border_length(c, b));
  allowed = max_of(allowed, 4.0 * max_of(border_tolerance(c, a), border_tolerance(c, b)));
  return distance <= allowed;
}

static double measure_segment_distance(const double x[3], const double a[3], const double b[3]) {
  double along = 0.0, square = 0.0, foot[3];
  for (int k = 0; k < 3; k++) {
    along += (x[k] - a[k]) * (b[k] - a[k]);
    square += (b[k] - a[k]) * (b[k] - a[k]);
  }
  double t = square > 0.0 ? along / square : 0.0;
  t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
  for (int k = 0; k < 3; k++)
    foot[k] = a[k] + t * (b[k] - a[k]);
  return tsi_distance(x, foot);
}

/* Distance from a border's samples to the polygon through the known points of another. */
static double measure_aside(const tsi_complex *c, int a, int b) {
  double worst = 0.0;
  for (int i = 0; i < 3; i++) {
    const double *previous = corner_point(c, b);
    double least = INFINITY;
    for (int k = 0; k < 4; k++) {
      const double *next =
          k < 3 ? border_sample(c, b, k, 0) : corner_point(c, b / 4 * 4 + (b + 1) % 4);
      least = min_of(least, measure_segment_distance(border_sample(c, a, i, 0), previous, next));
      previous = next;
    }
    worst = max_of(worst, least);
  }
  return worst;
}

/* How far two borders between the same vertices run apart: a coarse measure, but one that another
 * parameter on one of them does not blow up. */
static double compare_courses(const tsi_complex *c, int a, int b) {
  return min_of(compare_geometry(c, a, b), max_of(measure_aside(c, a, b), measure_aside(c, b, a)));
}

static void refuse_shared(tsi_complex *c, int slot, int n) {
  char border[TSI_BORDER_NAME_SIZE];
  tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_BORDER, slot / 4, slot % 4);
  tsi_set_point(&finding, border_sample(c, slot, 1, 0));
  finding.measured = n;
  finding.allowed = 2;
  tsi_report(c->context, &finding,
             "%s is shared by %d faces instead of two: isolines coincide or there is a face too "
             "many",
             tsi_name_border(&c->facet[slot / 4], slot % 4, border), n);
}

/* Pairs the m borders that join the same two vertices by where they run. */
static void match_group(tsi_complex *c, int m, const border_entry *group) {
  int reported = 0;
  for (int i = 0; i < m; i++) {
    int a = group[i].slot, n_coincident = 1, nearest = -1;
    double least = 0.0;
    for (int j = 0; j < m; j++) {
      int b = group[j].slot;
      if (j == i)
        continue;
      n_coincident += is_within(c, a, b, compare_geometry(c, a, b), coincident);
      double distance = compare_courses(c, a, b);
      if (is_within(c, a, b, distance, same_edge) && (nearest < 0 || distance < least)) {
        nearest = b;
        least = distance;
      }
    }
    c->mate[a] = nearest;
    if (n_coincident > 2 || m > MAX_SAME_ENDS) {
      c->shared[a] = 1;
      if (!reported++)
        refuse_shared(c, a, n_coincident);
      if (m > MAX_SAME_ENDS)
        break;
    }
  }
  for (int i = 0; i < m; i++) { /* only mutual choices are edges */
    int a = group[i].slot;
    if (c->mate[a] >= 0 && c->mate[c->mate[a]] != a && !c->shared[a])
      c->mate[a] = -1;
  }
}

tsolid_status tsi_complex_match_borders(tsi_complex *c) {
  int n = 4 * c->n;
  border_entry *entry = tsi_arena_new(c->arena, (size_t)n, sizeof *entry);
  c->mate = tsi_arena_new(c->arena, (size_t)n, sizeof *c->mate);
  c->shared = tsi_arena_new(c->arena, (size_t)n, sizeof *c->shared);
  if (!entry || !c->mate || !c->shared)
    return tsi_no_memory(c->context, stage);
  for (int i = 0; i < n; i++) {
    int a = c->vertex[i], b = c->vertex[i / 4 * 4 + (i + 1) % 4];
    entry[i] = (border_entry){a < b ? a : b, a < b ? b : a, i};
    c->mate[i] = -1;
  }
  qsort(entry, (size_t)n, sizeof *entry, compare_borders);
  for (int first = 0, end; first < n; first = end) {
    for (end = first;
         end < n && entry[end].low == entry[first].low && entry[end].high == entry[first].high;)
      end++;
    match_group(c, end - first, entry + first);
  }
  return refuse_violations(c);
}

/* Greatest distance between corresponding ends and samples, the better of both directions. */
static double measure_gap(const tsi_complex *c, int a, int b, double at[3]) {
  const double *pa[5], *pb[5];
  for (int i = 0; i < 3; i++) {
    pa[i + 1] = border_sample(c, a, i, 0);
    pb[i + 1] = border_sample(c, b, i, 0);
  }
  pa[0] = corner_point(c, a);
  pb[0] = corner_point(c, b);
  pa[4] = corner_point(c, a / 4 * 4 + (a + 1) % 4);
  pb[4] = corner_point(c, b / 4 * 4 + (b + 1) % 4);
  double best = INFINITY;
  for (int backwards = 0; backwards < 2; backwards++) {
    double gap = -1.0;
    int worst = 0;
    for (int i = 0; i < 5; i++) {
      double distance = tsi_distance(pa[i], pb[backwards ? 4 - i : i]);
      if (distance > gap) {
        gap = distance;
        worst = i;
      }
    }
    if (gap < best) {
      best = gap;
      memcpy(at, pa[worst], 3 * sizeof *at);
    }
  }
  return best;
}

/* Is vertex v, an end of another free border, inside free border a? On the polygon through its five
 * known points, which is coarse: it serves a hint, not a decision. */
static int vertex_inside(const tsi_complex *c, int a, int v) {
  int from = c->vertex[a], to = c->vertex[a / 4 * 4 + (a + 1) % 4];
  if (v == from || v == to)
    return 0;
  double least = INFINITY;
  const double *previous = corner_point(c, a);
  for (int i = 0; i < 4; i++) {
    const double *next =
        i < 3 ? border_sample(c, a, i, 0) : corner_point(c, a / 4 * 4 + (a + 1) % 4);
    least = min_of(least, measure_segment_distance(c->point[v], previous, next));
    previous = next;
  }
  return least <= 0.01 * border_length(c, a);
}

/* Says what a free border looks like: one side of a gap, met by two neighbours, or just free. */
static void report_free(tsi_complex *c, int a, int n_free, const int *slot) {
  char name[2][TSI_BORDER_NAME_SIZE];
  tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_BORDER, a / 4, a % 4);
  tsi_set_point(&finding, border_sample(c, a, 1, 0));
  tsi_name_border(&c->facet[a / 4], a % 4, name[0]);
  int nearest = -1, inside = -1;
  double least = INFINITY, at[3], place[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < n_free && n_free <= MAX_GAP_SEARCH; i++) {
    int b = slot[i];
    double gap = b == a ? INFINITY : measure_gap(c, a, b, at);
    if (gap < least) {
      least = gap;
      nearest = b;
      memcpy(place, at, sizeof place);
    }
    if (vertex_inside(c, a, c->vertex[b]))
      inside = c->vertex[b];
  }
  if (nearest >= 0 && least <= 0.1 * border_length(c, a)) {
    tsi_name_border(&c->facet[nearest / 4], nearest % 4, name[1]);
    tsi_set_point(&finding, place);
    finding.measured = least;
    finding.allowed = max_of(border_tolerance(c, a), border_tolerance(c, nearest));
    tsi_report(c->context, &finding,
               "%s and %s differ by %.3g, more than the tolerance of %.3g, at (%.6g, %.6g, %.6g)",
               name[0], name[1], least, finding.allowed, place[0], place[1], place[2]);
  } else if (inside >= 0) {
    tsi_set_point(&finding, c->point[inside]);
    tsi_report(c->context, &finding,
               "%s is met by two neighbours near (%.6g, %.6g, %.6g), but their vertex there lies "
               "farther from it than the tolerance of %.3g",
               name[0], c->point[inside][0], c->point[inside][1], c->point[inside][2],
               border_tolerance(c, a));
  } else {
    tsi_report(c->context, &finding, "%s is free: no other face has this border, the shell is open",
               name[0]);
  }
}

tsolid_status tsi_complex_check_closed(tsi_complex *c) {
  int *slot = tsi_arena_new(c->arena, (size_t)(4 * c->n), sizeof *slot);
  if (!slot)
    return tsi_no_memory(c->context, stage);
  int n_free = 0;
  for (int i = 0; i < 4 * c->n; i++)
    if (c->mate[i] < 0)
      slot[n_free++] = i;
  c->requirement->n_edges = (4 * c->n - n_free) / 2 + n_free;
  c->requirement->closed = n_free == 0;
  for (int i = 0; i < n_free && i < MAX_SHOWN; i++)
    report_free(c, slot[i], n_free, slot);
  if (n_free)
    tsi_fail(c->context, TSOLID_ERROR_REFUSED, stage,
             "The shell of %d faces is not closed: %d of their %d borders have no partner", c->n,
             n_free, 4 * c->n);
  for (int i = 0; i < 4 * c->n; i++)
    if (c->mate[i] > i && c->mate[i] / 4 == i / 4) {
      char name[2][TSI_BORDER_NAME_SIZE];
      tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_BORDER, i / 4, i % 4);
      tsi_set_point(&finding, border_sample(c, i, 1, 0));
      tsi_report(c->context, &finding,
                 "%s and %s coincide: the periodic face has to be cut into pieces first",
                 tsi_name_border(&c->facet[i / 4], i % 4, name[0]),
                 tsi_name_border(&c->facet[i / 4], c->mate[i] % 4, name[1]));
    }
  return refuse_violations(c);
}

/* ---- orientation ----------------------------------------------------------------------------- */

/* Orients all facets like the first of their shell; counts shells. */
tsolid_status tsi_complex_orient(tsi_complex *c) {
  int *queue = tsi_arena_new(c->arena, (size_t)c->n, sizeof *queue);
  int *shell = tsi_arena_new(c->arena, (size_t)c->n, sizeof *shell);
  c->flipped = tsi_arena_new(c->arena, (size_t)c->n, sizeof *c->flipped);
  if (!queue || !shell || !c->flipped)
    return tsi_no_memory(c->context, stage);
  int n_shells = 0, twisted = -1;
  for (int k = 0; k < c->n; k++) {
    if (shell[k])
      continue;
    int n_queue = 0;
    queue[n_queue++] = k;
    shell[k] = ++n_shells;
    for (int i = 0; i < n_queue; i++)
      for (int b = 0; b < 4; b++) {
        int dart = 4 * queue[i] + b, other = c->mate[dart], f = other / 4;
        if (!shell[f]) {
          shell[f] = n_shells;
          c->flipped[f] = tsi_dart_origin(c, dart) == tsi_dart_origin(c, other);
          queue[n_queue++] = f;
        } else if (tsi_dart_origin(c, dart) == tsi_dart_origin(c, other) && twisted < 0) {
          twisted = dart;
        }
      }
  }
  c->requirement->connected = n_shells == 1;
  if (n_shells > 1) {
    tsi_violation(c, TSOLID_ENTITY_NONE, 0, 0);
    tsi_fail(c->context, TSOLID_ERROR_REFUSED, stage,
             "The faces form %d separate shells, one is needed", n_shells);
  } else if (twisted >= 0) {
    char name[TSI_BORDER_NAME_SIZE];
    tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_BORDER, twisted / 4, twisted % 4);
    tsi_set_point(&finding, border_sample(c, twisted, 1, 0));
    tsi_report(c->context, &finding, "The shell has only one side: inside and outside meet at %s",
               tsi_name_border(&c->facet[twisted / 4], twisted % 4, name));
  }
  return refuse_violations(c);
}

/* Makes all normals point outward. */
tsolid_status tsi_complex_orient_outward(tsi_complex *c) {
  double volume = 0.0, area = 0.0, tolerance = 0.0;
  for (int k = 0; k < c->n; k++) {
    volume += c->flipped[k] ? -c->facet[k].flux : c->facet[k].flux;
    area += c->facet[k].area;
    for (int b = 0; b < 4; b++)
      tolerance = max_of(tolerance, c->facet[k].tolerance[b]);
  }
  if (!(fabs(volume) > tolerance * area)) {
    tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_NONE, 0, 0);
    finding.measured = fabs(volume);
    finding.allowed = tolerance * area;
    return tsi_report(c->context, &finding, "The shell encloses no volume (%.3g)", fabs(volume));
  }
  for (int k = 0; volume < 0.0 && k < c->n; k++)
    c->flipped[k] = !c->flipped[k];
  return TSOLID_OK;
}

/* ---- topology -------------------------------------------------------------------------------- */

/* One closed fan of facets around every vertex, else the shell touches itself in a point. */
tsolid_status tsi_complex_check_fans(tsi_complex *c) {
  unsigned char *fans = tsi_arena_new(c->arena, (size_t)c->n_vertices, 1);
  unsigned char *seen = tsi_arena_new(c->arena, (size_t)(4 * c->n), 1);
  c->valence = tsi_arena_new(c->arena, (size_t)c->n_vertices, sizeof *c->valence);
  if (!fans || !seen || !c->valence)
    return tsi_no_memory(c->context, stage);
  for (int dart = 0; dart < 4 * c->n; dart++) {
    int v = tsi_dart_origin(c, dart);
    c->valence[v]++;
    if (seen[dart])
      continue;
    for (int d = dart; !seen[d]; d = tsi_dart_next(c, c->mate[d]))
      seen[d] = 1;
    if (fans[v]++ != 1)
      continue;
    tsolid_finding finding =
        tsi_violation(c, TSOLID_ENTITY_VERTEX, dart / 4, tsi_dart_origin_corner(c, dart) % 4);
    tsi_set_point(&finding, c->point[v]);
    tsi_report(c->context, &finding, "The shell touches itself at (%.6g, %.6g, %.6g)",
               c->point[v][0], c->point[v][1], c->point[v][2]);
  }
  return refuse_violations(c);
}

tsolid_status tsi_complex_check_genus(tsi_complex *c) {
  tsolid_requirement *r = c->requirement;
  r->genus = (2 - (c->n_vertices - r->n_edges + c->n)) / 2;
  if (r->genus == 0)
    return TSOLID_OK;
  tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_NONE, 0, 0);
  finding.measured = r->genus;
  finding.allowed = 0;
  return tsi_report(c->context, &finding,
                    "The shell has genus %d: a part with a through hole, like a ring, is not taken",
                    r->genus);
}

static void name_vertex(const tsi_complex *c, int v, char *text, size_t size, int *corner) {
  *corner = 0;
  while (c->vertex[*corner] != v)
    ++*corner;
  const char *name = c->facet[*corner / 4].corner_name[*corner % 4];
  if (name && *name)
    snprintf(text, size, "%.90s at (%.6g, %.6g, %.6g)", name, c->point[v][0], c->point[v][1],
             c->point[v][2]);
  else
    snprintf(text, size, "The vertex at (%.6g, %.6g, %.6g)", c->point[v][0], c->point[v][1],
             c->point[v][2]);
}

tsolid_status tsi_complex_check_valences(tsi_complex *c) {
  tsolid_requirement *r = c->requirement;
  int n_three = 0, shown = 0;
  for (int v = 0; v < c->n_vertices; v++) {
    r->n_extraordinary += c->valence[v] != 4;
    n_three += c->valence[v] == 3;
  }
  if (r->n_extraordinary == 8 && n_three == 8)
    return TSOLID_OK;
  tsolid_finding finding = tsi_violation(c, TSOLID_ENTITY_NONE, 0, 0);
  finding.measured = r->n_extraordinary;
  finding.allowed = 8;
  tsi_report(c->context, &finding,
             "There are %d extraordinary vertices, %d of them with three faces; exactly eight with "
             "three faces are needed, the corners of the cube",
             r->n_extraordinary, n_three);
  for (int v = 0; v < c->n_vertices && shown < MAX_SHOWN; v++) {
    if (c->valence[v] == 4 || (c->valence[v] == 3 && n_three <= 8))
      continue;
    char text[TSI_BORDER_NAME_SIZE];
    int corner;
    name_vertex(c, v, text, sizeof text, &corner);
    finding = tsi_violation(c, TSOLID_ENTITY_VERTEX, corner / 4, corner % 4);
    tsi_set_point(&finding, c->point[v]);
    finding.measured = c->valence[v];
    finding.allowed = 4;
    tsi_report(c->context, &finding, "%s belongs to %d faces", text, c->valence[v]);
    shown++;
  }
  return TSOLID_ERROR_REFUSED;
}
