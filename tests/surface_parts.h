/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Surfaces made in code: quadrilateral cells on anything, joined into faces by labels, numbered by
 * chance. Bilinear functions, one per vertex of the cells but where a vertex hangs on others,
 * written in any degree. Shares nothing with the library but the struct it fills. */
#ifndef TSOLID_TEST_SURFACE_PARTS_H
#define TSOLID_TEST_SURFACE_PARTS_H

#include <stdlib.h>
#include <string.h>

#include "surface.h"

enum { CELLS_MAX = 4096, VERTICES_MAX = 4096, LINES_MAX = 24 };

/* Corner i of a cell to corner i+1 is its edge i; counter-clockwise seen from outside. */
typedef struct cell {
  int vertex[4];
  double length[4];
  int label; /* cells of one label are one face */
} cell;

typedef struct cells {
  int n, n_vertices;
  cell cell[CELLS_MAX];
  double point[VERTICES_MAX][4]; /* homogeneous */
  /* a vertex that hangs between two others: share of the first */
  int hangs[VERTICES_MAX][2];
  double share[VERTICES_MAX];
  int is_single[CELLS_MAX]; /* per label: the face is one element */
  double axis_length[3];
} cells;

static inline unsigned long long surface_random(unsigned long long *seed) {
  *seed = *seed * 6364136223846793005ULL + 1442695040888963407ULL;
  return *seed >> 33;
}

static inline double surface_random_unit(unsigned long long *seed) {
  return ((double)surface_random(seed) + 0.5) / 0x1p31;
}

/* ---- cells ------------------------------------------------------------------------------------
 */

static inline void cells_init(cells *m) {
  memset(m, 0, sizeof *m);
  memset(m->hangs, 0xff, sizeof m->hangs);
}

static inline int cells_lattice(const int n[3], const int x[3]) {
  return x[0] + (n[0] + 1) * (x[1] + (n[1] + 1) * x[2]);
}

/* The surface of a box of n cells whose lines are at line[axis][0..n]. Vertices are the points of
 * the lattice (most of them on no cell). Cell (i, j) of a side is at side_first[side] + i + n_s*j.
 */
static inline void cells_box(cells *m, const int n[3], const double *const line[3],
                             int side_first[6]) {
  cells_init(m);
  m->n_vertices = (n[0] + 1) * (n[1] + 1) * (n[2] + 1);
  for (int a = 0; a < 3; a++)
    m->axis_length[a] = line[a][n[a]] - line[a][0];
  int x[3];
  for (x[2] = 0; x[2] <= n[2]; x[2]++)
    for (x[1] = 0; x[1] <= n[1]; x[1]++)
      for (x[0] = 0; x[0] <= n[0]; x[0]++) {
        double *h = m->point[cells_lattice(n, x)];
        for (int c = 0; c < 3; c++)
          h[c] = line[c][x[c]];
        h[3] = 1.0;
      }
  for (int side = 0; side < 6; side++) {
    int a = side / 2, s = a == 0 ? 1 : 0, t = a == 2 ? 1 : 2;
    int outward = (a == 1) != (side & 1); /* s x t points outward */
    side_first[side] = m->n;
    for (int j = 0; j < n[t]; j++)
      for (int i = 0; i < n[s]; i++) {
        cell *c = &m->cell[m->n];
        c->label = m->n++;
        for (int k = 0; k < 4; k++) {
          int q = outward ? k : 3 - k; /* corner 00, 10, 11, 01 */
          x[a] = side & 1 ? n[a] : 0;
          x[s] = i + (q == 1 || q == 2);
          x[t] = j + (q >= 2);
          c->vertex[k] = cells_lattice(n, x);
          /* edge k runs from corner q to the next in this order */
          int along_s = k % 2 == 0;
          c->length[k] = along_s ? line[s][i + 1] - line[s][i] : line[t][j + 1] - line[t][j];
        }
      }
  }
}

/* Which cell has the edge from b to a; *edge its number there. -1: none. */
static inline int cells_across(const cells *m, int a, int b, int *edge) {
  for (int c = 0; c < m->n; c++)
    for (int k = 0; k < 4; k++)
      if (m->cell[c].vertex[k] == b && m->cell[c].vertex[(k + 1) % 4] == a) {
        *edge = k;
        return c;
      }
  return -1;
}

/* ---- the surface ------------------------------------------------------------------------------
 */

typedef struct builder {
  const cells *m;
  int across[CELLS_MAX][4], across_edge[CELLS_MAX][4];
  int n_boundary[VERTICES_MAX]; /* edges between faces that start here */
  int is_corner[VERTICES_MAX];
  int link_of[CELLS_MAX][4]; /* link that begins with this edge of a cell; -1 */
  /* numbers in the surface, -1: none */
  int face_of[CELLS_MAX], vertex_of[VERTICES_MAX], function_of[VERTICES_MAX];
  /* links: 4 cell + edge where it begins, and where its opposite does (-1: open); its number */
  int n_inner, begin[4 * CELLS_MAX], twin[4 * CELLS_MAX], number[8 * CELLS_MAX];
  int end_vertex[4 * CELLS_MAX], open_of[VERTICES_MAX], edge_order[4 * CELLS_MAX];
  double length[4 * CELLS_MAX];
  int order[8 * CELLS_MAX], done[CELLS_MAX];
  int n_elements, n_entries;
} builder;

static inline int builder_is_border(const builder *b, int c, int k) {
  int o = b->across[c][k];
  return o < 0 || b->m->cell[o].label != b->m->cell[c].label;
}

/* The next edge of the face's border; *straight: the vertex between lies inside a side. */
static inline void builder_next(const builder *b, int *c, int *k, int *straight) {
  int crossed = 0;
  *k = (*k + 1) % 4;
  while (!builder_is_border(b, *c, *k)) {
    int o = b->across[*c][*k], e = b->across_edge[*c][*k];
    *c = o;
    *k = (e + 1) % 4;
    crossed++;
  }
  *straight = crossed == 1;
}

typedef struct weighted {
  int function;
  double value;
} weighted;

/* The functions that are not zero at a vertex; returns how many (at most 16). */
static inline int vertex_functions(const cells *m, int v, double factor, weighted *list, int n) {
  if (m->hangs[v][0] >= 0) {
    n = vertex_functions(m, m->hangs[v][0], factor * m->share[v], list, n);
    return vertex_functions(m, m->hangs[v][1], factor * (1.0 - m->share[v]), list, n);
  }
  for (int i = 0; i < n; i++)
    if (list[i].function == v) {
      list[i].value += factor;
      return n;
    }
  list[n] = (weighted){v, factor};
  return n + 1;
}

static inline void shuffle(int *order, int n, unsigned long long *seed) {
  for (int i = 0; i < n; i++)
    order[i] = i;
  for (int i = n - 1; seed && i > 0; i--) {
    int j = (int)(surface_random(seed) % (unsigned)(i + 1)), swap = order[i];
    order[i] = order[j];
    order[j] = swap;
  }
}

static inline void *part_new(size_t n, size_t size) {
  void *p = calloc(n ? n : 1, size);
  if (!p)
    abort();
  return p;
}

/* Adds the bilinear element with these four corner vertices (00, 10, 11, 01) on a box. */
static inline void add_element(struct tsolid_surface *s, builder *b, const int corner[4],
                               const double box[4]) {
  weighted list[4][16];
  int count[4], p = s->degree;
  memcpy(s->box + 4 * b->n_elements, box, 4 * sizeof *box);
  for (int q = 0; q < 4; q++)
    count[q] = vertex_functions(b->m, corner[q], 1.0, list[q], 0);
  int first = b->n_entries;
  for (int q = 0; q < 4; q++)
    for (int i = 0; i < count[q]; i++) {
      int f = b->function_of[list[q][i].function], k = first;
      while (k < b->n_entries && s->function[k] != f)
        k++;
      if (k == b->n_entries)
        s->function[b->n_entries++] = f;
      double *c = s->coefficient + (size_t)k * (size_t)((p + 1) * (p + 1));
      for (int j = 0; j <= p; j++)
        for (int h = 0; h <= p; h++) {
          int right = q == 1 || q == 2, top = q >= 2;
          double u = right ? (double)h / p : (double)(p - h) / p;
          double v = top ? (double)j / p : (double)(p - j) / p;
          c[h + (p + 1) * j] += list[q][i].value * (u * v);
        }
    }
  s->function_start[++b->n_elements] = b->n_entries;
}

/* Elements of the cells of one face, by walking from cell to cell in the face's frame. */
static inline void add_cells(struct tsolid_surface *s, builder *b, int c, int k, double u,
                             double v) {
  const cell *at = &b->m->cell[c];
  double w = at->length[k], h = at->length[(k + 1) % 4], box[4] = {u, u + w, v, v + h};
  int corner[4];
  b->done[c] = 1;
  for (int q = 0; q < 4; q++)
    corner[q] = at->vertex[(k + q) % 4];
  add_element(s, b, corner, box);
  for (int q = 0; q < 4; q++) {
    int edge = (k + q) % 4, o = b->across[c][edge];
    if (builder_is_border(b, c, edge) || b->done[o])
      continue;
    /* the edge of the neighbour that runs along u at its low v */
    int e = b->across_edge[c][edge], bottom = q == 0 ? e + 2 : q == 1 ? e + 1 : q == 2 ? e : e + 3;
    bottom %= 4;
    double ow = b->m->cell[o].length[bottom], oh = b->m->cell[o].length[(bottom + 1) % 4];
    add_cells(s, b, o, bottom,
              q == 1   ? u + w
              : q == 3 ? u - ow
                       : u,
              q == 2   ? v + h
              : q == 0 ? v - oh
                       : v);
  }
}

static inline void surface_part_free(struct tsolid_surface *s) {
  free(s->link);
  free(s->face_link);
  free(s->edge_link);
  free(s->vertex_link);
  free(s->interval);
  free(s->face_record);
  free(s->vertex_record);
  free(s->points);
  free(s->element_start);
  free(s->box);
  free(s->function_start);
  free(s->function);
  free(s->coefficient);
}

/* Which edges of cells lie between faces, and where these have corners. */
static inline void find_borders(builder *b) {
  const cells *m = b->m;
  int straight;
  for (int c = 0; c < m->n; c++)
    for (int k = 0; k < 4; k++)
      b->across[c][k] = cells_across(m, m->cell[c].vertex[k], m->cell[c].vertex[(k + 1) % 4],
                                     &b->across_edge[c][k]);
  for (int c = 0; c < m->n; c++)
    for (int k = 0; k < 4; k++)
      if (builder_is_border(b, c, k)) {
        int d = c, e = k;
        b->n_boundary[m->cell[c].vertex[k]]++;
        if (b->across[c][k] < 0)
          b->n_boundary[m->cell[c].vertex[(k + 1) % 4]] += 3; /* keep all of an open border */
        builder_next(b, &d, &e, &straight);
        if (!straight)
          b->is_corner[m->cell[d].vertex[e]] = 1;
      }
}

static inline void number_faces(builder *b, struct tsolid_surface *s, unsigned long long *seed) {
  memset(b->face_of, 0xff, sizeof b->face_of);
  for (int c = 0; c < b->m->n; c++)
    if (b->face_of[b->m->cell[c].label] < 0)
      b->face_of[b->m->cell[c].label] = s->n_faces++;
  shuffle(b->order, s->n_faces, seed);
  s->face_record = part_new((size_t)s->n_faces, sizeof(int));
  for (int i = 0; i < CELLS_MAX; i++)
    if (b->face_of[i] >= 0) {
      b->face_of[i] = b->order[b->face_of[i]];
      s->face_record[b->face_of[i]] = 1000 + i;
    }
}

static inline void number_vertices(builder *b, struct tsolid_surface *s, unsigned long long *seed) {
  const cells *m = b->m;
  for (int v = 0; v < m->n_vertices; v++) {
    b->vertex_of[v] = b->n_boundary[v] >= 3 || b->is_corner[v] ? s->n_vertices++ : -1;
    b->function_of[v] = m->hangs[v][0] < 0 ? s->n_points++ : -1;
  }
  shuffle(b->order, s->n_vertices, seed);
  s->vertex_record = part_new((size_t)s->n_vertices, sizeof(int));
  for (int v = 0; v < m->n_vertices; v++)
    if (b->vertex_of[v] >= 0) {
      b->vertex_of[v] = b->order[b->vertex_of[v]];
      s->vertex_record[b->vertex_of[v]] = v;
    }
  shuffle(b->order, s->n_points, seed);
  s->points = part_new(4 * (size_t)s->n_points, sizeof(double));
  for (int v = 0; v < m->n_vertices; v++)
    if (b->function_of[v] >= 0) {
      b->function_of[v] = b->order[b->function_of[v]];
      memcpy(s->points + 4 * b->function_of[v], m->point[v], 4 * sizeof(double));
    }
}

/* Links of faces come first in `begin`, then open ones; `number` says what they are called. */
static inline void number_links(builder *b, struct tsolid_surface *s, unsigned long long *seed) {
  const cells *m = b->m;
  for (int c = 0; c < m->n; c++)
    for (int k = 0; k < 4; k++) {
      b->link_of[c][k] = -1;
      if (builder_is_border(b, c, k) && b->vertex_of[m->cell[c].vertex[k]] >= 0) {
        b->link_of[c][k] = b->n_inner;
        b->begin[b->n_inner++] = 4 * c + k;
      }
    }
  s->n_links = b->n_inner;
  for (int i = 0; i < b->n_inner; i++)
    s->n_links += b->across[b->begin[i] / 4][b->begin[i] % 4] < 0;
  s->n_edges = s->n_links / 2;
  shuffle(b->number, s->n_links, seed);
  shuffle(b->edge_order, s->n_edges, seed);
  s->link = part_new((size_t)s->n_links, sizeof *s->link);
  s->face_link = part_new((size_t)s->n_faces, sizeof(int));
  s->edge_link = part_new((size_t)s->n_edges, sizeof(int));
  s->vertex_link = part_new((size_t)s->n_vertices, sizeof(int));
  s->interval = part_new((size_t)s->n_edges, sizeof(double));
}

/* Loops of the faces; length and far end of every link. */
static inline void follow_borders(builder *b, struct tsolid_surface *s) {
  const cells *m = b->m;
  for (int i = 0; i < b->n_inner; i++) {
    int c = b->begin[i] / 4, k = b->begin[i] % 4, straight;
    tsi_link *l = &s->link[b->number[i]];
    l->vertex = b->vertex_of[m->cell[c].vertex[k]];
    l->face = b->face_of[m->cell[c].label];
    do { /* to the next vertex that is one */
      b->length[i] += m->cell[c].length[k];
      b->twin[i] = b->across[c][k] < 0 ? -1 : 4 * b->across[c][k] + b->across_edge[c][k];
      builder_next(b, &c, &k, &straight);
    } while (b->link_of[c][k] < 0);
    int next = b->number[b->link_of[c][k]];
    b->end_vertex[i] = b->vertex_of[m->cell[c].vertex[k]];
    l->next = next;
    s->link[next].prev = b->number[i];
    s->link[next].straight = straight;
  }
}

static inline void join_links(builder *b, struct tsolid_surface *s) {
  int next_open = b->n_inner, n_edges = 0;
  for (int i = 0; i < b->n_inner; i++) {
    int o = b->twin[i] < 0 ? next_open++ : b->link_of[b->twin[i] / 4][b->twin[i] % 4];
    tsi_link *l = &s->link[b->number[i]], *opposite = &s->link[b->number[o]];
    l->opposite = b->number[o];
    if (b->twin[i] < 0) {
      *opposite = (tsi_link){.opposite = b->number[i], .vertex = b->end_vertex[i], .face = -1};
      b->open_of[b->end_vertex[i]] = b->number[o];
    }
    if (b->twin[i] < 0 || o > i) {
      int e = b->edge_order[n_edges++];
      l->edge = opposite->edge = e;
      s->interval[e] = b->length[i];
      s->edge_link[e] = b->number[i];
    }
  }
  for (int i = 0; i < b->n_inner; i++)
    if (b->twin[i] < 0) { /* the open link that starts where this one begins comes next */
      const tsi_link *l = &s->link[b->number[i]];
      int next = b->open_of[l->vertex];
      s->link[l->opposite].next = next;
      s->link[next].prev = l->opposite;
    }
  for (int i = 0; i < s->n_links; i++)
    s->vertex_link[s->link[i].vertex] = i;
}

/* The whole face as one element, in the frame of edge k of cell c. */
static inline void add_single(struct tsolid_surface *s, builder *b, int c, int k) {
  double side[4] = {0.0, 0.0, 0.0, 0.0}, box[4] = {0.0, 0.0, 0.0, 0.0};
  int corner[4] = {b->m->cell[c].vertex[k]}, q = 0, straight;
  while (q < 4) {
    side[q] += b->m->cell[c].length[k];
    builder_next(b, &c, &k, &straight);
    if (!straight && ++q < 4)
      corner[q] = b->m->cell[c].vertex[k];
  }
  box[1] = side[0];
  box[3] = side[1];
  add_element(s, b, corner, box);
}

/* A frame for every face, and its elements. */
static inline void add_faces(builder *b, struct tsolid_surface *s, unsigned long long *seed) {
  size_t n = (size_t)b->m->n, width = (size_t)((s->degree + 1) * (s->degree + 1));
  s->element_start = part_new((size_t)s->n_faces + 1, sizeof(int));
  s->box = part_new(n, 4 * sizeof(double));
  s->function_start = part_new(n + 1, sizeof(int));
  s->function = part_new(n * 64, sizeof(int));
  s->coefficient = part_new(n * 64 * width, sizeof(double));
  for (int f = 0; f < s->n_faces; f++) {
    int candidate[4] = {0}, n_candidates = 0;
    for (int i = 0; i < b->n_inner; i++)
      if (s->link[b->number[i]].face == f && !s->link[b->number[i]].straight && n_candidates < 4)
        candidate[n_candidates++] = i;
    int start = candidate[seed ? surface_random(seed) % 4 : 0];
    int c = b->begin[start] / 4, k = b->begin[start] % 4;
    s->face_link[f] = b->number[start];
    if (b->m->is_single[b->m->cell[c].label])
      add_single(s, b, c, k);
    else
      add_cells(s, b, c, k, 0.0, 0.0);
    s->element_start[f + 1] = b->n_elements;
  }
}

/* Fills *s; seed NULL: plain order. Records are 1000 + label for faces, the cells' vertex for
 * vertices. */
static inline void surface_part_build(const cells *m, int degree, unsigned long long *seed,
                                      struct tsolid_surface *s) {
  builder *b = part_new(1, sizeof *b);
  memset(s, 0, sizeof *s);
  b->m = m;
  s->degree = degree;
  find_borders(b);
  number_faces(b, s, seed);
  number_vertices(b, s, seed);
  number_links(b, s, seed);
  follow_borders(b, s);
  join_links(b, s);
  add_faces(b, s, seed);
  free(b);
}

#endif
