/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A border slot 4k + b is border b of facet k. Once the facets are oriented alike a slot is also a
 * dart: an edge walked with its facet on the left. */
#include <stdio.h>
#include <stdlib.h>

#include "cube.h"
#include "patch.h"

static const char stage[] = "boundary";

enum { MAX_SAME_ENDS = 16, MAX_SHOWN = 20, MAX_GAP_SEARCH = 64 };

/* Two borders with the same ends are sides of one edge when their samples are no farther apart than
 * this part of their length (the exact comparison comes later, row by row); they coincide with a
 * third when nearer than the second. */
static const double same_edge = 0.25, coincident = 1e-3;

typedef struct complex_of_facets {
  tsolid_context *context;
  tsi_arena *arena;
  tsolid_requirement *requirement;
  int n;
  const tsi_facet *facet;
  int n_vertices;
  int *vertex;            /* 4n: vertex of facet corner */
  double (*point)[3];     /* n_vertices: the least of the corner points that meet there */
  int *mate;              /* 4n: the slot across the border, or -1 */
  unsigned char *flipped; /* n: walked clockwise */
  int *valence;           /* n_vertices */
  unsigned char *shared;  /* 4n: the border belongs to three or more facets */
} complex_of_facets;

const char *tsi_name_border(const tsi_facet *facet, int k, int b, char text[TSI_BORDER_NAME_SIZE]) {
  char name[TSI_NAME_SIZE], border[TSI_NAME_SIZE];
  tsi_name_patch(facet->name, k, name);
  if (facet->border_name[b] && *facet->border_name[b])
    tsi_name_patch(facet->border_name[b], b, border);
  else
    snprintf(border, sizeof border, "border %d", b);
  snprintf(text, TSI_BORDER_NAME_SIZE, "%s of %s", border, name);
  return text;
}

static tsolid_finding violation(complex_of_facets *c, tsolid_entity entity, int k, int part) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = entity;
  finding.index[0] = k;
  finding.index[1] = part;
  c->requirement->n_violations++;
  return finding;
}

static void set_point(tsolid_finding *finding, const double point[3]) {
  finding->has_point = 1;
  memcpy(finding->point, point, 3 * sizeof *point);
}

static double measure_distance(const double a[3], const double b[3]) {
  return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

static double max_of(double a, double b) {
  return a > b ? a : b;
}

static double min_of(double a, double b) {
  return a < b ? a : b;
}

static int compare_points(const double a[3], const double b[3]) {
  for (int c = 0; c < 3; c++)
    if (a[c] != b[c])
      return a[c] < b[c] ? -1 : 1;
  return 0;
}

/* ---- facets by themselves -------------------------------------------------------------------- */

static void check_facet(complex_of_facets *c, int k) {
  const tsi_facet *facet = &c->facet[k];
  char name[TSI_NAME_SIZE], border[TSI_BORDER_NAME_SIZE];
  tsi_name_patch(facet->name, k, name);
  double longest = 0.0, tolerance = 0.0;
  int poles = 0;
  for (int b = 0; b < 4; b++) {
    tsi_name_border(facet, k, b, border);
    longest = max_of(longest, facet->length[b]);
    tolerance = max_of(tolerance, facet->tolerance[b]);
    if (facet->length[b] <= 2.0 * facet->tolerance[b]) {
      tsolid_finding finding = violation(c, TSOLID_ENTITY_BORDER, k, b);
      set_point(&finding, facet->corner[b]);
      finding.measured = facet->length[b];
      finding.allowed = 2.0 * facet->tolerance[b];
      tsi_report(c->context, &finding,
                 "%s is a pole: the border has no length (%.3g), so the face has fewer than four "
                 "borders",
                 border, facet->length[b]);
      poles++;
    } else if (measure_distance(facet->corner[b], facet->corner[(b + 1) % 4]) <=
               facet->tolerance[b]) {
      tsolid_finding finding = violation(c, TSOLID_ENTITY_BORDER, k, b);
      set_point(&finding, facet->corner[b]);
      tsi_report(c->context, &finding,
                 "%s ends where it starts: the periodic face has to be cut into pieces first",
                 border);
      poles++;
    }
  }
  if (!poles && facet->area <= tolerance * longest) {
    tsolid_finding finding = violation(c, TSOLID_ENTITY_PATCH, k, 0);
    set_point(&finding, facet->centre);
    finding.measured = facet->area;
    finding.allowed = tolerance * longest;
    tsi_report(c->context, &finding,
               "%s has no area (%.3g): two of its borders, which should be different isolines, "
               "coincide",
               name, facet->area);
  }
}

static tsolid_status refuse_violations(const complex_of_facets *c) {
  return c->requirement->n_violations ? TSOLID_ERROR_REFUSED : TSOLID_OK;
}

static tsolid_status check_facets(complex_of_facets *c) {
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
  int order = compare_points(p->cell, q->cell);
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
    if (compare_points(entry[middle].cell, cell) < 0)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

static double corner_tolerance(const complex_of_facets *c, int corner) {
  const tsi_facet *facet = &c->facet[corner / 4];
  int b = corner % 4;
  return max_of(facet->tolerance[b], facet->tolerance[(b + 3) % 4]);
}

static const double *corner_point(const complex_of_facets *c, int corner) {
  return c->facet[corner / 4].corner[corner % 4];
}

static void unite_near(const complex_of_facets *c, const cell_entry *entry, int i, int *parent) {
  for (int step = 0; step < 27; step++) {
    double cell[3] = {entry[i].cell[0] + step % 3 - 1, entry[i].cell[1] + step / 3 % 3 - 1,
                      entry[i].cell[2] + step / 9 - 1};
    int a = entry[i].corner;
    for (int j = find_cell(4 * c->n, entry, cell);
         j < 4 * c->n && compare_points(entry[j].cell, cell) == 0; j++) {
      int b = entry[j].corner;
      if (b < a && measure_distance(corner_point(c, a), corner_point(c, b)) <=
                       max_of(corner_tolerance(c, a), corner_tolerance(c, b)))
        unite(parent, a, b);
    }
  }
}

/* Facet corners within the tolerance of each other, in chains, are one vertex. Space is hashed into
 * cells of the tolerance's width, kept as a sorted list. */
static tsolid_status find_vertices(complex_of_facets *c) {
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
      if (compare_points(point, c->point[c->vertex[i]]) < 0)
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

static void make_key(const complex_of_facets *c, int k, facet_key *key) {
  key->facet = k;
  for (int i = 0; i < 4; i++) {
    int v = c->vertex[4 * k + i], j = i;
    for (; j > 0 && key->vertex[j - 1] > v; j--)
      key->vertex[j] = key->vertex[j - 1];
    key->vertex[j] = v;
  }
}

static tsolid_status find_duplicates(complex_of_facets *c) {
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
    double distance = measure_distance(c->facet[a].centre, c->facet[b].centre);
    if (distance > 10.0 * max_of(c->facet[a].tolerance[0], c->facet[b].tolerance[0]))
      continue;
    char name[2][TSI_NAME_SIZE];
    tsolid_finding finding = violation(c, TSOLID_ENTITY_PATCH, b, 0);
    set_point(&finding, c->facet[b].centre);
    tsi_report(c->context, &finding, "%s is a duplicate of %s",
               tsi_name_patch(c->facet[b].name, b, name[1]),
               tsi_name_patch(c->facet[a].name, a, name[0]));
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

static const double *border_sample(const complex_of_facets *c, int slot, int i, int backwards) {
  return c->facet[slot / 4].sample[slot % 4][backwards ? 2 - i : i];
}

/* Largest distance of the samples of two borders between the same two vertices. */
static double compare_geometry(const complex_of_facets *c, int a, int b) {
  int backwards = c->vertex[a] != c->vertex[b]; /* slot and corner indices coincide */
  double distance = 0.0;
  for (int i = 0; i < 3; i++)
    distance = max_of(
        distance, measure_distance(border_sample(c, a, i, 0), border_sample(c, b, i, backwards)));
  return distance;
}

static double border_length(const complex_of_facets *c, int slot) {
  return c->facet[slot / 4].length[slot % 4];
}

static double border_tolerance(const complex_of_facets *c, int slot) {
  return c->facet[slot / 4].tolerance[slot % 4];
}

static int borders_within(const complex_of_facets *c, int a, int b, double part) {
  double allowed = part * min_of(border_length(c, a), border_length(c, b));
  allowed = max_of(allowed, 4.0 * max_of(border_tolerance(c, a), border_tolerance(c, b)));
  return compare_geometry(c, a, b) <= allowed;
}

static void refuse_shared(complex_of_facets *c, int slot, int n) {
  char border[TSI_BORDER_NAME_SIZE];
  tsolid_finding finding = violation(c, TSOLID_ENTITY_BORDER, slot / 4, slot % 4);
  set_point(&finding, border_sample(c, slot, 1, 0));
  finding.measured = n;
  finding.allowed = 2;
  tsi_report(c->context, &finding,
             "%s is shared by %d faces instead of two: isolines coincide or there is a face too "
             "many",
             tsi_name_border(&c->facet[slot / 4], slot / 4, slot % 4, border), n);
}

/* Pairs the m borders that join the same two vertices by where they run. */
static void match_group(complex_of_facets *c, int m, const border_entry *group) {
  int reported = 0;
  for (int i = 0; i < m; i++) {
    int a = group[i].slot, n_coincident = 1, nearest = -1;
    double least = 0.0;
    for (int j = 0; j < m; j++) {
      int b = group[j].slot;
      if (j == i)
        continue;
      n_coincident += borders_within(c, a, b, coincident);
      double distance = compare_geometry(c, a, b);
      if (borders_within(c, a, b, same_edge) && (nearest < 0 || distance < least)) {
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

static tsolid_status match_borders(complex_of_facets *c) {
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
static double measure_gap(const complex_of_facets *c, int a, int b, double at[3]) {
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
      double distance = measure_distance(pa[i], pb[backwards ? 4 - i : i]);
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
  return measure_distance(x, foot);
}

/* Is vertex v, an end of another free border, inside free border a? On the polygon through its five
 * known points, which is coarse: it serves a hint, not a decision. */
static int vertex_inside(const complex_of_facets *c, int a, int v) {
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
static void report_free(complex_of_facets *c, int a, int n_free, const int *slot) {
  char name[2][TSI_BORDER_NAME_SIZE];
  tsolid_finding finding = violation(c, TSOLID_ENTITY_BORDER, a / 4, a % 4);
  set_point(&finding, border_sample(c, a, 1, 0));
  tsi_name_border(&c->facet[a / 4], a / 4, a % 4, name[0]);
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
    tsi_name_border(&c->facet[nearest / 4], nearest / 4, nearest % 4, name[1]);
    set_point(&finding, place);
    finding.measured = least;
    finding.allowed = max_of(border_tolerance(c, a), border_tolerance(c, nearest));
    tsi_report(c->context, &finding,
               "%s and %s differ by %.3g, more than the tolerance of %.3g, at (%.6g, %.6g, %.6g)",
               name[0], name[1], least, finding.allowed, place[0], place[1], place[2]);
  } else if (inside >= 0) {
    set_point(&finding, c->point[inside]);
    tsi_report(c->context, &finding,
               "%s is met by two neighbours at (%.6g, %.6g, %.6g): T-vertices between faces are "
               "not taken, the faces must form a rectangular grid on each side",
               name[0], c->point[inside][0], c->point[inside][1], c->point[inside][2]);
  } else {
    tsi_report(c->context, &finding, "%s is free: no other face has this border, the shell is open",
               name[0]);
  }
}

static tsolid_status check_closed(complex_of_facets *c) {
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
      tsolid_finding finding = violation(c, TSOLID_ENTITY_BORDER, i / 4, i % 4);
      set_point(&finding, border_sample(c, i, 1, 0));
      tsi_report(c->context, &finding,
                 "%s and %s coincide: the periodic face has to be cut into pieces first",
                 tsi_name_border(&c->facet[i / 4], i / 4, i % 4, name[0]),
                 tsi_name_border(&c->facet[i / 4], i / 4, c->mate[i] % 4, name[1]));
    }
  return refuse_violations(c);
}

/* ---- orientation ----------------------------------------------------------------------------- */

static int origin_corner(const complex_of_facets *c, int dart) {
  int b = dart % 4;
  return dart / 4 * 4 + (c->flipped[dart / 4] ? (b + 1) % 4 : b);
}

static int end_corner(const complex_of_facets *c, int dart) {
  int b = dart % 4;
  return dart / 4 * 4 + (c->flipped[dart / 4] ? b : (b + 1) % 4);
}

static int origin(const complex_of_facets *c, int dart) {
  return c->vertex[origin_corner(c, dart)];
}

static int end(const complex_of_facets *c, int dart) {
  return c->vertex[end_corner(c, dart)];
}

static int next(const complex_of_facets *c, int dart) {
  return dart / 4 * 4 + (dart + (c->flipped[dart / 4] ? 3 : 1)) % 4;
}

/* Straight on through the regular vertex at the end of `dart`. */
static int straight(const complex_of_facets *c, int dart) {
  return next(c, c->mate[next(c, dart)]);
}

/* Orients all facets like the first of their shell; counts shells. */
static tsolid_status orient_facets(complex_of_facets *c) {
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
          c->flipped[f] = origin(c, dart) == origin(c, other);
          queue[n_queue++] = f;
        } else if (origin(c, dart) == origin(c, other) && twisted < 0) {
          twisted = dart;
        }
      }
  }
  c->requirement->connected = n_shells == 1;
  if (n_shells > 1) {
    violation(c, TSOLID_ENTITY_NONE, 0, 0);
    tsi_fail(c->context, TSOLID_ERROR_REFUSED, stage,
             "The faces form %d separate shells, one is needed", n_shells);
  } else if (twisted >= 0) {
    char name[TSI_BORDER_NAME_SIZE];
    tsolid_finding finding = violation(c, TSOLID_ENTITY_BORDER, twisted / 4, twisted % 4);
    set_point(&finding, border_sample(c, twisted, 1, 0));
    tsi_report(c->context, &finding, "The shell has only one side: inside and outside meet at %s",
               tsi_name_border(&c->facet[twisted / 4], twisted / 4, twisted % 4, name));
  }
  return refuse_violations(c);
}

/* Makes all normals point outward. */
static tsolid_status orient_outward(complex_of_facets *c) {
  double volume = 0.0, area = 0.0, tolerance = 0.0;
  for (int k = 0; k < c->n; k++) {
    volume += c->flipped[k] ? -c->facet[k].flux : c->facet[k].flux;
    area += c->facet[k].area;
    for (int b = 0; b < 4; b++)
      tolerance = max_of(tolerance, c->facet[k].tolerance[b]);
  }
  if (!(fabs(volume) > tolerance * area)) {
    tsolid_finding finding = violation(c, TSOLID_ENTITY_NONE, 0, 0);
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
static tsolid_status check_fans(complex_of_facets *c) {
  unsigned char *fans = tsi_arena_new(c->arena, (size_t)c->n_vertices, 1);
  unsigned char *seen = tsi_arena_new(c->arena, (size_t)(4 * c->n), 1);
  c->valence = tsi_arena_new(c->arena, (size_t)c->n_vertices, sizeof *c->valence);
  if (!fans || !seen || !c->valence)
    return tsi_no_memory(c->context, stage);
  for (int dart = 0; dart < 4 * c->n; dart++) {
    int v = origin(c, dart);
    c->valence[v]++;
    if (seen[dart])
      continue;
    for (int d = dart; !seen[d]; d = next(c, c->mate[d]))
      seen[d] = 1;
    if (fans[v]++ != 1)
      continue;
    tsolid_finding finding =
        violation(c, TSOLID_ENTITY_VERTEX, dart / 4, origin_corner(c, dart) % 4);
    set_point(&finding, c->point[v]);
    tsi_report(c->context, &finding, "The shell touches itself at (%.6g, %.6g, %.6g)",
               c->point[v][0], c->point[v][1], c->point[v][2]);
  }
  return refuse_violations(c);
}

static tsolid_status check_genus(complex_of_facets *c) {
  tsolid_requirement *r = c->requirement;
  r->genus = (2 - (c->n_vertices - r->n_edges + c->n)) / 2;
  if (r->genus == 0)
    return TSOLID_OK;
  tsolid_finding finding = violation(c, TSOLID_ENTITY_NONE, 0, 0);
  finding.measured = r->genus;
  finding.allowed = 0;
  return tsi_report(c->context, &finding,
                    "The shell has genus %d: a part with a through hole, like a ring, is not taken",
                    r->genus);
}

static void name_vertex(const complex_of_facets *c, int v, char *text, size_t size, int *corner) {
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

static tsolid_status check_valences(complex_of_facets *c) {
  tsolid_requirement *r = c->requirement;
  int n_three = 0, shown = 0;
  for (int v = 0; v < c->n_vertices; v++) {
    r->n_extraordinary += c->valence[v] != 4;
    n_three += c->valence[v] == 3;
  }
  if (r->n_extraordinary == 8 && n_three == 8)
    return TSOLID_OK;
  tsolid_finding finding = violation(c, TSOLID_ENTITY_NONE, 0, 0);
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
    finding = violation(c, TSOLID_ENTITY_VERTEX, corner / 4, corner % 4);
    set_point(&finding, c->point[v]);
    finding.measured = c->valence[v];
    finding.allowed = 4;
    tsi_report(c->context, &finding, "%s belongs to %d faces", text, c->valence[v]);
    shown++;
  }
  return TSOLID_ERROR_REFUSED;
}

/* ---- the cube -------------------------------------------------------------------------------- */

typedef struct cube_side {
  int dart[4];   /* first darts of its isolines, in the order around the side */
  int vertex[4]; /* their origins */
} cube_side;

static tsolid_status refuse_graph(complex_of_facets *c, int dart) {
  const double *point = c->point[origin(c, dart)];
  tsolid_finding finding = violation(c, TSOLID_ENTITY_PATCH, dart / 4, 0);
  set_point(&finding, point);
  return tsi_report(c->context, &finding,
                    "The isolines from the eight extraordinary vertices do not join them like the "
                    "edges of a cube; the first that fails starts at (%.6g, %.6g, %.6g)",
                    point[0], point[1], point[2]);
}

/* The last dart of the isoline that starts with `dart`: straight on to an extraordinary vertex. A
 * straight walk is a permutation of darts, so one that starts outside a cycle does end. */
static int trace_isoline(const complex_of_facets *c, int dart) {
  for (int i = 0; i < 4 * c->n && c->valence[end(c, dart)] == 4; i++)
    dart = straight(c, dart);
  return dart;
}

static tsolid_status find_sides(complex_of_facets *c, cube_side side[6]) {
  int n_sides = 0;
  unsigned char *seen = tsi_arena_new(c->arena, (size_t)(4 * c->n), 1);
  if (!seen)
    return tsi_no_memory(c->context, stage);
  for (int first = 0; first < 4 * c->n; first++) {
    if (seen[first] || c->valence[origin(c, first)] == 4)
      continue;
    if (n_sides == 6)
      return refuse_graph(c, first);
    int dart = first;
    for (int i = 0; i < 4; i++) {
      if (seen[dart])
        return refuse_graph(c, dart);
      seen[dart] = 1;
      side[n_sides].dart[i] = dart;
      side[n_sides].vertex[i] = origin(c, dart);
      dart = next(c, trace_isoline(c, dart));
    }
    if (dart != first)
      return refuse_graph(c, first);
    n_sides++;
  }
  return n_sides == 6 ? TSOLID_OK : refuse_graph(c, 0);
}

/* Ranks of the vertices' coordinates: equal for neighbours closer than 1e-9 of the extent, so that
 * the canonical position does not hang on the last bits of a coordinate. */
static void rank_corners(const complex_of_facets *c, const int vertex[8], int rank[8][3]) {
  double extent = 0.0;
  for (int i = 0; i < 8; i++)
    extent = max_of(extent, measure_distance(c->point[vertex[i]], c->point[vertex[0]]));
  for (int k = 0; k < 3; k++) {
    int order[8];
    for (int i = 0; i < 8; i++) {
      int j = i;
      for (; j > 0 && c->point[vertex[order[j - 1]]][k] > c->point[vertex[i]][k]; j--)
        order[j] = order[j - 1];
      order[j] = i;
    }
    for (int i = 0, r = 0; i < 8; i++) {
      if (i && c->point[vertex[order[i]]][k] - c->point[vertex[order[i - 1]]][k] > 1e-9 * extent)
        r++;
      rank[order[i]][k] = r;
    }
  }
}

static int is_before(const complex_of_facets *c, const int vertex[8], int rank[8][3], int a,
                     int b) {
  for (int k = 0; k < 3; k++)
    if (rank[a][k] != rank[b][k])
      return rank[a][k] < rank[b][k];
  return compare_points(c->point[vertex[a]], c->point[vertex[b]]) < 0;
}

/* Sides around vertex v: the one that leaves it along the axis of `dart`. */
static int side_from(const cube_side side[6], int from, int to, int *at) {
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 4; j++)
      if (side[i].vertex[j] == from && side[i].vertex[(j + 1) % 4] == to) {
        *at = j;
        return i;
      }
  return -1;
}

/* Vertices of corners 0, 1, 2, 4: seen from outside, the axes leave corner 0 clockwise, so that the
 * side that leaves it along x comes back along z, z along y, y along x. */
static void choose_axes(const complex_of_facets *c, const cube_side side[6], int corner[8]) {
  int vertex[8], rank[8][3], n = 0;
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 4; j++) {
      int known = 0;
      for (int m = 0; m < n; m++)
        known |= vertex[m] == side[i].vertex[j];
      if (!known)
        vertex[n++] = side[i].vertex[j];
    }
  rank_corners(c, vertex, rank);
  int least = 0, best = -1;
  for (int i = 1; i < 8; i++)
    if (is_before(c, vertex, rank, i, least))
      least = i;
  corner[0] = vertex[least];
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 4; j++)
      for (int m = 0; m < 8 && side[i].vertex[j] == corner[0]; m++)
        if (vertex[m] == side[i].vertex[(j + 1) % 4] &&
            (best < 0 || is_before(c, vertex, rank, m, best)))
          best = m;
  corner[1] = vertex[best];
  int j = 0, i = side_from(side, corner[0], corner[1], &j);
  corner[4] = side[i].vertex[(j + 3) % 4];
  corner[5] = side[i].vertex[(j + 2) % 4];
  i = side_from(side, corner[0], corner[4], &j);
  corner[2] = i < 0 ? -1 : side[i].vertex[(j + 3) % 4];
  corner[6] = i < 0 ? -1 : side[i].vertex[(j + 2) % 4];
  i = side_from(side, corner[0], corner[2], &j);
  corner[3] = i < 0 ? -1 : side[i].vertex[(j + 2) % 4];
  i = side_from(side, corner[3], corner[2], &j);
  corner[7] = i < 0 ? -1 : side[i].vertex[(j + 3) % 4];
}

static int label_of(const int corner[8], int vertex) {
  for (int i = 0; i < 8; i++)
    if (corner[i] == vertex)
      return i;
  return -1;
}

/* Which side of the cube is this, and where in it does corner (s,t) = (0,0) stand? -1: none. */
static int identify_side(const cube_side *side, const int corner[8], int *at) {
  int all = 7, any = 0, label[4];
  for (int j = 0; j < 4; j++) {
    label[j] = label_of(corner, side->vertex[j]);
    if (label[j] < 0)
      return -1;
    all &= label[j];
    any |= label[j];
  }
  for (int j = 0; j < 4; j++) {
    int step = label[j] ^ label[(j + 1) % 4];
    if (step != 1 && step != 2 && step != 4)
      return -1;
    if (label[j] == all)
      *at = j;
  }
  for (int axis = 0; axis < 3; axis++) {
    if (all == 1 << axis && any == 7)
      return 2 * axis + 1;
    if (all == 0 && any == 7 - (1 << axis))
      return 2 * axis;
  }
  return -1;
}

/* The facets of a side, row by row, from the dart that leaves (0,0) counter-clockwise. */
static tsolid_status lay_out_side(complex_of_facets *c, int number, int dart, int first_axis,
                                  unsigned char *used, tsi_cube *cube) {
  int s = tsi_side_s(number), t = tsi_side_t(number), second_axis = s + t - first_axis;
  int n_row = 1, n_rows = 1;
  for (int d = dart; c->valence[end(c, d)] == 4 && n_row <= c->n; d = straight(c, d))
    n_row++;
  for (int d = next(c, next(c, dart)); c->valence[end(c, d)] == 4 && n_rows <= c->n;
       d = next(c, next(c, c->mate[d])))
    n_rows++;
  int n[3] = {0, 0, 0};
  n[first_axis] = n_row;
  n[second_axis] = n_rows;
  if ((double)n_row * n_rows > c->n)
    return refuse_graph(c, dart);
  for (int d = 0; d < 2; d++) {
    int axis = d ? t : s;
    if (cube->n_strips[axis] && cube->n_strips[axis] != n[axis])
      return refuse_graph(c, dart);
    cube->n_strips[axis] = n[axis];
  }
  tsi_place *place = tsi_arena_new(c->arena, (size_t)n_row * (size_t)n_rows, sizeof *place);
  if (!place)
    return tsi_no_memory(c->context, stage);
  for (int r = 0; r < n_rows; r++) {
    int d = dart;
    for (int k = 0; k < n_row; k++) {
      int i = first_axis == s ? k : r, j = first_axis == s ? r : k,
          natural = origin_corner(c, d) % 4;
      if (used[d / 4]++)
        return refuse_graph(c, d);
      int along_u = d % 4 == 0 || d % 4 == 2;
      place[i + n[s] * j] = (tsi_place){.facet = d / 4,
                                        .swap = along_u == (first_axis == t),
                                        .flip = {natural == 1 || natural == 2, natural >= 2}};
      if (k + 1 < n_row)
        d = straight(c, d);
    }
    if (r + 1 < n_rows)
      dart = c->mate[next(c, next(c, dart))];
  }
  cube->place[number] = place;
  return TSOLID_OK;
}

static tsolid_status place_cube(complex_of_facets *c, const cube_side side[6], tsi_cube *cube) {
  int corner[8], n_used = 0;
  unsigned char *used = tsi_arena_new(c->arena, (size_t)c->n, 1);
  if (!used)
    return tsi_no_memory(c->context, stage);
  choose_axes(c, side, corner);
  for (int i = 0; i < 6; i++) {
    int at = 0, number = identify_side(&side[i], corner, &at);
    if (number < 0 || cube->place[number])
      return refuse_graph(c, side[i].dart[0]);
    int step =
        label_of(corner, side[i].vertex[at]) ^ label_of(corner, side[i].vertex[(at + 1) % 4]);
    tsolid_status status = lay_out_side(c, number, side[i].dart[at],
                                        step == 1   ? 0
                                        : step == 2 ? 1
                                                    : 2,
                                        used, cube);
    if (status)
      return status;
  }
  for (int k = 0; k < c->n; k++)
    n_used += used[k];
  if (n_used != c->n)
    return refuse_graph(c, side[0].dart[0]);
  for (int i = 0; i < 8; i++)
    memcpy(c->requirement->corner[i], c->point[corner[i]], sizeof *c->requirement->corner);
  for (int i = 0; i < 6; i++) {
    c->requirement->side_grid[i][0] = cube->n_strips[tsi_side_s(i)];
    c->requirement->side_grid[i][1] = cube->n_strips[tsi_side_t(i)];
  }
  c->requirement->satisfied = 1;
  return TSOLID_OK;
}

tsolid_status tsi_cube_find(tsolid_context *context, tsi_arena *arena, int n,
                            const tsi_facet *facet, tsolid_requirement *requirement,
                            tsi_cube *cube) {
  static const tsi_cube no_cube;
  complex_of_facets c = {
      .context = context, .arena = arena, .requirement = requirement, .n = n, .facet = facet};
  cube_side side[6];
  *cube = no_cube;
  memset(requirement, 0, sizeof *requirement);
  requirement->genus = -1;
  requirement->n_patches = n;
  tsolid_status status = check_facets(&c);
  if (!status)
    status = find_vertices(&c);
  if (!status)
    status = find_duplicates(&c);
  if (!status)
    status = match_borders(&c);
  if (!status)
    status = check_closed(&c);
  if (!status)
    status = orient_facets(&c);
  if (!status)
    status = check_fans(&c);
  if (!status)
    status = check_genus(&c);
  if (!status)
    status = check_valences(&c);
  if (!status)
    status = orient_outward(&c);
  if (!status)
    status = find_sides(&c, side);
  if (!status)
    status = place_cube(&c, side, cube);
  return status;
}
