/* SPDX-License-Identifier: LGPL-2.1-or-later
 * T-spline patches and patches of Bezier elements as input. Known surfaces: NURBS patches rewritten
 * as T-splines by exact insertion, row by row (functions that sum to one) or function by function
 * (functions that need not). They must come back as the same surface, whatever the order, the
 * orientation and the mixture, and from a file bit for bit. */
#include <unistd.h>

#include "boundary_checks.h"
#include "conform.h"

/* ---- T-splines of known surfaces ---------------------------------------------------------------
 */

enum { MAX_FUNCTIONS = 4000, MAX_LOCAL = 28 };

typedef struct function {
  double knot[2][MAX_LOCAL], h[4];
} function;

/* A patch being rewritten. */
typedef struct net {
  int degree[2], n;
  function *list;
} net;

static void homogeneous(const tsolid_patch *patch, int i, double h[4]) {
  double w = patch->weights ? patch->weights[i] : 1.0;
  for (int c = 0; c < 3; c++)
    h[c] = w * patch->points[3 * i + c];
  h[3] = w;
}

/* One knot more in a row of homogeneous points, by Boehm's rule. */
static void insert_into_row(int p, int *n, double *knots, double (*h)[4], double x) {
  int span = p;
  while (knots[span + 1] <= x)
    span++;
  for (int m = *n; m > span - p; m--) {
    double a = m > span ? 0.0 : (x - knots[m]) / (knots[m + p] - knots[m]);
    for (int c = 0; c < 4; c++)
      h[m][c] = (a > 0.0 ? a * h[m][c] : 0.0) + (1.0 - a) * h[m - 1][c];
  }
  for (int i = *n + p + 1; i > span + 1; i--)
    knots[i] = knots[i - 1];
  knots[span + 1] = x;
  ++*n;
}

/* Every inner row of functions along u gets up to `most` knots of its own, in the inner spans. */
static net rewrite_rows(const tsolid_patch *patch, int most) {
  net out = {{patch->degree[0], patch->degree[1]}, 0, calloc(MAX_FUNCTIONS, sizeof(function))};
  int p = patch->degree[0], q = patch->degree[1], n0 = patch->n_control[0];
  for (int j = 0; j < patch->n_control[1]; j++) {
    double knots[200], h[200][4];
    int n = n0;
    memcpy(knots, patch->knots[0], (size_t)(n0 + p + 1) * sizeof(double));
    for (int i = 0; i < n0; i++)
      homogeneous(patch, i + n0 * j, h[i]);
    double low = patch->knots[0][p + 1], high = patch->knots[0][n0 - 1];
    for (int k = 0; low < high && j > 0 && j + 1 < patch->n_control[1] && k < most; k++) {
      double x = (1 + random_below(63)) / 64.0;
      int seen = 0;
      for (int i = 0; i < n + p + 1; i++)
        seen |= knots[i] == x;
      if (x > low && x < high && !seen && random_below(2))
        insert_into_row(p, &n, knots, h, x);
    }
    for (int i = 0; i < n; i++) {
      function *f = &out.list[out.n++];
      memcpy(f->knot[0], knots + i, (size_t)(p + 2) * sizeof(double));
      memcpy(f->knot[1], patch->knots[1] + j, (size_t)(q + 2) * sizeof(double));
      memcpy(f->h, h[i], sizeof f->h);
    }
  }
  return out;
}

static int touches_border(const function *f, const int degree[2]) {
  for (int d = 0; d < 2; d++)
    if (f->knot[d][degree[d]] == 0.0 || f->knot[d][1] == 1.0)
      return 1;
  return 0;
}

/* N = a N_1 + b N_2: function k in two, whose points take the factors a and b. */
static void split_function(net *of, int k, int d, double x) {
  function *f = &of->list[k], *g = &of->list[of->n];
  int p = of->degree[d], at = 0;
  double fine[MAX_LOCAL];
  for (int i = 0; i < p + 2; i++) {
    if (at == i && f->knot[d][i] > x)
      fine[at++] = x;
    fine[at++] = f->knot[d][i];
  }
  double a = x >= f->knot[d][p] ? 1.0 : (x - f->knot[d][0]) / (f->knot[d][p] - f->knot[d][0]);
  double b =
      x <= f->knot[d][1] ? 1.0 : (f->knot[d][p + 1] - x) / (f->knot[d][p + 1] - f->knot[d][1]);
  *g = *f;
  memcpy(f->knot[d], fine, (size_t)(p + 2) * sizeof(double));
  memcpy(g->knot[d], fine + 1, (size_t)(p + 2) * sizeof(double));
  for (int c = 0; c < 4; c++) {
    f->h[c] *= a;
    g->h[c] *= b;
  }
  of->n++;
}

static void split_some(net *of, int n) {
  for (int i = 0; i < n; i++) {
    int k = random_below(of->n), d = random_below(2), p = of->degree[d], inside = 0;
    const function *f = &of->list[k];
    double x = (1 + random_below(63)) / 64.0;
    for (int m = 0; m < p + 2; m++)
      inside |= f->knot[d][m] == x;
    if (!inside && x > f->knot[d][0] && x < f->knot[d][p + 1] && !touches_border(f, of->degree))
      split_function(of, k, d, x);
  }
}

/* ---- inputs ------------------------------------------------------------------------------------
 */

/* An input that owns all it points to. */
typedef struct mixture {
  tsolid_patch patch[64];
  tsolid_tspline tspline[64];
  tsolid_bezier_side bezier[64];
  tsolid_smooth_seam smooth[4];
  int n, n_points;
  double *points;
} mixture;

static tsolid_boundary_input input_of(const mixture *m) {
  return (tsolid_boundary_input){.n_patches = m->n,
                                 .patches = m->patch,
                                 .n_points = m->n_points,
                                 .points = m->n_points ? m->points : NULL};
}

static mixture new_mixture(void) {
  return (mixture){.points = part_doubles(4 * MAX_FUNCTIONS * 8)};
}

static void free_mixture(mixture *m) {
  for (int k = 0; k < m->n; k++) {
    for (int d = 0; d < 2; d++) {
      free((void *)(size_t)m->patch[k].knots[d]);
      free((void *)(size_t)m->tspline[k].knots[d]);
    }
    free((void *)(size_t)m->patch[k].points);
    free((void *)(size_t)m->patch[k].weights);
    free((void *)(size_t)m->tspline[k].point);
  }
  free(m->points);
}

static void add_nurbs(mixture *m, const tsolid_patch *patch, int flip_u, int flip_v, int swap) {
  m->patch[m->n++] = reorient_patch(patch, flip_u, flip_v, swap);
}

/* The functions in random order, reversed and exchanged, on the domain [-1, 3] x [2, 4]. */
static void add_tspline(mixture *m, const net *from, const int flip[2], int swap, int shuffle) {
  int n = from->n, *order = malloc((size_t)n * sizeof *order),
      *point = calloc((size_t)n, sizeof(int));
  double *knots[2];
  tsolid_tspline *t = &m->tspline[m->n];
  static const double start[2] = {-1.0, 2.0}, width[2] = {4.0, 2.0};
  *t = (tsolid_tspline){.n_functions = n, .domain = {-1.0, 3.0, 2.0, 4.0}};
  for (int i = 0; i < n; i++)
    order[i] = i;
  for (int i = n - 1; shuffle && i > 0; i--) {
    int j = random_below(i + 1), kept = order[i];
    order[i] = order[j];
    order[j] = kept;
  }
  for (int d = 0; d < 2; d++) {
    int e = swap ? 1 - d : d, p = from->degree[d];
    t->degree[e] = p;
    knots[e] = part_doubles((size_t)n * (size_t)(p + 2));
    for (int i = 0; i < n; i++)
      for (int k = 0; k < p + 2; k++) {
        double x = from->list[order[i]].knot[d][flip[d] ? p + 1 - k : k];
        knots[e][i * (p + 2) + k] = start[e] + width[e] * (flip[d] ? 1.0 - x : x);
      }
    t->knots[e] = knots[e];
  }
  for (int i = 0; i < n; i++) {
    point[i] = m->n_points;
    memcpy(m->points + 4 * m->n_points++, from->list[order[i]].h, 4 * sizeof(double));
  }
  t->point = point;
  free(order);
  m->patch[m->n] = (tsolid_patch){.tspline = t};
  m->n++;
}

/* The addresses inside m are of its own arrays. */
static void settle(mixture *m) {
  for (int k = 0; k < m->n; k++) {
    if (m->patch[k].tspline)
      m->patch[k].tspline = &m->tspline[k];
    if (m->patch[k].bezier)
      m->patch[k].bezier = &m->bezier[k];
  }
}

static tsolid_boundary *create_mixture(tsolid_context *context, const mixture *m) {
  tsolid_boundary *boundary = NULL;
  tsolid_boundary_input input = input_of(m);
  tsolid_context_clear(context);
  if (!CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) == TSOLID_OK))
    for (int i = 0; i < tsolid_context_n_findings(context); i++)
      fprintf(stderr, "    %s\n", tsolid_context_finding(context, i)->text);
  return boundary;
}

/* Largest distance of the surface from the original patches. source[k]: the original of patch k,
 * turned as flip and swap say. */
static double mixture_distance(const mixture *m, const tsolid_boundary *boundary,
                               const tsolid_patch *const *source) {
  tsolid_bezier_boundary view;
  double worst = 0.0;
  tsolid_boundary_view(boundary, &view);
  for (int k = 0; k < m->n; k++) {
    tsolid_placement place;
    CHECK(tsolid_boundary_placement(boundary, k, 0, &place) == TSOLID_OK);
    for (int i = 0; i < 60; i++) {
      double p = i < 4 ? i & 1 : random_unit(), q = i < 4 ? i >> 1 : random_unit(), x[3],
             y[3] = {0.0};
      double a = place.flip[0] ? 1.0 - p : p, b = place.flip[1] ? 1.0 - q : q;
      double s = place.box[0] + (place.swap ? b : a) * (place.box[1] - place.box[0]);
      double t = place.box[2] + (place.swap ? a : b) * (place.box[3] - place.box[2]);
      evaluate_patch(source[k], p, q, x);
      CHECK(evaluate_boundary(&view, place.side, fmin(s, 1.0), fmin(t, 1.0), y));
      worst = fmax(worst, hypot(hypot(x[0] - y[0], x[1] - y[1]), x[2] - y[2]));
    }
  }
  return worst / tsolid_boundary_scale(boundary);
}

/* What the solid's report says of the sums: the input's own defect, and nothing beyond it. */
static void check_report(tsolid_context *context, const tsolid_boundary *boundary) {
  tsolid_tmesh *tmesh = NULL;
  tsolid_space *space = NULL;
  tsolid_basis_report r;
  if (CHECK(tsolid_tmesh_create(context, boundary, NULL, &tmesh) == TSOLID_OK) &&
      CHECK(tsolid_space_create(context, boundary, tmesh, &space) == TSOLID_OK) &&
      CHECK(tsi_basis_measure(context, space, 0, NULL, -1, &r) == TSOLID_OK)) {
    CHECK_NEAR(r.input_sum_defect, sum_defect(boundary), 0.0);
    CHECK(r.sum_defect <= r.input_sum_defect + 1e-12); /* finer elements: closer bounds */
    CHECK((r.sum_defect > 0.01) == (r.input_sum_defect > 0.01));
  }
  tsolid_space_free(space);
  tsolid_tmesh_free(tmesh);
}

/* Written as given, and as the Bezier sides that it became: the same boundary again. */
static void check_file(tsolid_context *context, const mixture *m, const tsolid_boundary *boundary) {
  char path[64];
  snprintf(path, sizeof path, "test_tspline_input_%ld.tsb", (long)getpid());
  for (int round = 0; round < 2; round++) {
    tsolid_bezier_boundary view;
    tsolid_boundary_file *file = NULL;
    tsolid_boundary *again = NULL;
    tsolid_boundary_input input = input_of(m);
    tsolid_boundary_view(boundary, &view);
    if (round)
      input = (tsolid_boundary_input){.bezier = &view};
    CHECK(tsolid_write_tsb(context, &input, path) == TSOLID_OK);
    CHECK(tsolid_read_tsb(context, path, &file) == TSOLID_OK);
    if (file)
      CHECK(tsolid_boundary_create(context, tsolid_boundary_file_input(file), NULL, NULL, &again) ==
            TSOLID_OK);
    CHECK(again && same_boundaries(boundary, again));
    if (!round)
      CHECK(again && same_records(boundary, again));
    tsolid_boundary_free(again);
    tsolid_boundary_file_free(file);
  }
  remove(path);
}

/* A knot line more, in every row. */
static void insert_line(tsolid_patch *patch, int along, double x) {
  int p = patch->degree[along], n[2] = {patch->n_control[0], patch->n_control[1]}, to[2];
  for (int i = 0; i < n[along] + p + 1; i++)
    if (patch->knots[along][i] == x)
      return;
  memcpy(to, n, sizeof to);
  to[along]++;
  double *knots = part_doubles((size_t)(n[along] + p + 2));
  double *points = part_doubles(3 * (size_t)to[0] * (size_t)to[1]);
  double *weights = patch->weights ? part_doubles((size_t)to[0] * (size_t)to[1]) : NULL;
  for (int j = 0; j < n[1 - along]; j++) {
    double h[200][4];
    int count = n[along];
    memcpy(knots, patch->knots[along], (size_t)(count + p + 1) * sizeof *knots);
    for (int i = 0; i < count; i++)
      homogeneous(patch, along ? j + n[0] * i : i + n[0] * j, h[i]);
    insert_into_row(p, &count, knots, h, x);
    for (int i = 0; i < count; i++) {
      int at = along ? j + to[0] * i : i + to[0] * j;
      for (int c = 0; c < 3; c++)
        points[3 * at + c] = h[i][c] / h[i][3];
      if (weights)
        weights[at] = h[i][3];
    }
  }
  free((void *)(size_t)patch->knots[along]);
  free((void *)(size_t)patch->points);
  free((void *)(size_t)patch->weights);
  patch->knots[along] = knots;
  patch->points = points;
  patch->weights = weights;
  patch->n_control[along]++;
}

/* ---- rewritten parts ---------------------------------------------------------------------------
 */

static void map_wavy(const double u[3], double point[3], double *weight) {
  point[0] = 3.0 * u[0] + 0.2 * sin(3.0 * u[1] + u[2]);
  point[1] = 2.0 * u[1] + 0.15 * cos(2.0 * u[0] - u[2]) + 0.3 * u[0];
  point[2] = 1.5 * u[2] + 0.2 * sin(2.0 * u[0] + 2.0 * u[1]) - 4.0;
  *weight = 1.0 + 0.5 * u[0] + 0.25 * u[1] * u[2];
}

static void random_axes(axis_spec axes[3], int n_strips) {
  for (int a = 0; a < 3; a++) {
    axes[a].n_strips = n_strips;
    for (int i = 0; i < n_strips; i++) {
      strip *s = &axes[a].strip[i];
      s->degree = 1 + random_below(5);
      s->n_inner = 2 + random_below(3);
      for (int k = 0; k < s->n_inner; k++)
        s->inner[k] = (k + 1.0) / (s->n_inner + 1 <= 4 ? 4 : 8);
    }
  }
}

/* kind: 0 rows, 1 functions too, 2 every other patch left as NURBS. */
static void check_rewritten(tsolid_context *context, const part *p, int kind) {
  net list[64];
  for (int k = 0; k < p->n; k++) {
    list[k] = rewrite_rows(&p->patch[k], 3);
    if (kind == 1)
      split_some(&list[k], 12);
  }
  tsolid_boundary *first = NULL;
  for (int round = 0; round < 4; round++) {
    mixture m = new_mixture();
    part turned = {p->n, calloc((size_t)p->n, sizeof *turned.patch)};
    const tsolid_patch *source[64];
    int start = round ? random_below(p->n) : 0;
    for (int i = 0; i < p->n; i++) {
      int k = (i + start) % p->n, swap = round && random_below(2);
      int flip[2] = {round && random_below(2), round && random_below(2)};
      turned.patch[i] = reorient_patch(&p->patch[k], flip[0], flip[1], swap);
      source[i] = &turned.patch[i];
      if (kind == 2 && k % 2)
        add_nurbs(&m, &p->patch[k], flip[0], flip[1], swap);
      else
        add_tspline(&m, &list[k], flip, swap, round > 0);
    }
    settle(&m);
    tsolid_boundary *boundary = create_mixture(context, &m);
    if (boundary) {
      CHECK(tsi_boundary_validate(context, boundary) == TSOLID_OK);
      CHECK_NEAR(mixture_distance(&m, boundary, source), 0.0, 5e-15);
      if (kind == 1)
        CHECK(sum_defect(boundary) > 0.01);
      else
        CHECK_NEAR(sum_defect(boundary), 0.0, 4e-15);
      if (!round)
        check_report(context, boundary);
      if (round)
        CHECK(same_boundaries(first, boundary));
      if (round < 2)
        check_file(context, &m, boundary);
    }
    if (round)
      tsolid_boundary_free(boundary);
    else
      first = boundary;
    free_mixture(&m);
    part_free(&turned);
  }
  tsolid_boundary_free(first);
  for (int k = 0; k < p->n; k++)
    free(list[k].list);
}

static void test_rewritten(tsolid_context *context) {
  for (int round = 0; round < 12; round++) {
    axis_spec axes[3];
    random_axes(axes, 1 + round % 4 / 3);
    part p = make_part(axes, map_wavy, round % 2);
    check_rewritten(context, &p, round % 3);
    part_free(&p);
  }
}

/* ---- knots that only a neighbour has -----------------------------------------------------------
 */

/* Every other patch stays NURBS and gets knot lines in its inner spans; the rows of the T-splines
 * beside it must take them. */
static void test_finer_neighbours(tsolid_context *context) {
  for (int round = 0; round < 8; round++) {
    axis_spec axes[3];
    random_axes(axes, 1);
    for (int a = 0; a < 3; a++)
      axes[a].strip[0].n_inner = 3;
    for (int a = 0; a < 3; a++)
      for (int k = 0; k < 3; k++)
        axes[a].strip[0].inner[k] = (k + 1) / 4.0;
    part p = make_part(axes, map_wavy, round % 2);
    mixture m = new_mixture();
    const tsolid_patch *source[6];
    static const int flip[2] = {0, 0};
    int n_tspline = 0;
    for (int k = 0; k < 6; k++) {
      source[k] = &p.patch[k];
      if (k >> 1 == round % 3) {
        add_nurbs(&m, &p.patch[k], 0, 0, 0);
        for (int i = 0; i < 4; i++)
          insert_line(&m.patch[k], random_below(2), 0.25 + (1 + random_below(31)) / 64.0);
        continue;
      }
      net list = rewrite_rows(&p.patch[k], 2);
      n_tspline += list.n;
      add_tspline(&m, &list, flip, 0, 1);
      free(list.list);
    }
    settle(&m);
    tsolid_boundary *boundary = create_mixture(context, &m);
    if (boundary) {
      CHECK(tsi_boundary_validate(context, boundary) == TSOLID_OK);
      CHECK_NEAR(mixture_distance(&m, boundary, source), 0.0, 5e-15);
      CHECK_NEAR(sum_defect(boundary), 0.0, 4e-15);
      CHECK(boundary->preparation.n_knots_inserted > 0 && n_tspline > 0);
      check_file(context, &m, boundary);
    }
    tsolid_boundary_free(boundary);
    free_mixture(&m);
    part_free(&p);
  }
}

/* ---- Bezier patches ----------------------------------------------------------------------------
 */

/* Sides of a boundary as patches of Bezier elements beside the NURBS patches of the others: that is
 * the same boundary, unless one of its points was moved. */
static tsolid_status mix_bezier(tsolid_context *context, const part *p, const tsolid_boundary *from,
                                int kinds, double moved, tsolid_boundary **boundary) {
  mixture m = new_mixture();
  tsolid_bezier_boundary view;
  int *number = malloc((size_t)from->n_functions * sizeof *number);
  int *of_side[6] = {NULL, NULL, NULL, NULL, NULL, NULL};
  tsolid_boundary_view(from, &view);
  for (int i = 0; i < from->n_functions; i++)
    number[i] = -1;
  for (int k = 0; k < 6; k++) {
    tsolid_placement place;
    CHECK(tsolid_boundary_placement(from, k, 0, &place) == TSOLID_OK);
    if (!(kinds >> k & 1)) {
      add_nurbs(&m, &p->patch[k], 0, 0, 0);
      continue;
    }
    tsolid_bezier_side *side = &m.bezier[m.n];
    *side = view.side[place.side];
    int n = side->function_start[side->n_elements];
    of_side[k] = malloc((size_t)n * sizeof(int));
    for (int i = 0; i < n; i++) {
      int f = side->function[i];
      if (number[f] < 0) {
        memcpy(m.points + 4 * m.n_points, view.points + 4 * f, 4 * sizeof(double));
        number[f] = m.n_points++;
      }
      of_side[k][i] = number[f];
    }
    side->function = of_side[k];
    m.patch[m.n++] = (tsolid_patch){.bezier = side, .name = "Face1"};
  }
  if (m.n_points)
    m.points[0] += moved;
  tsolid_boundary_input input = input_of(&m);
  tsolid_status status = tsolid_boundary_create(context, &input, NULL, NULL, boundary);
  if (!status && moved == 0.0)
    check_file(context, &m, *boundary);
  for (int k = 0; k < 6; k++)
    free(of_side[k]);
  free(number);
  free_mixture(&m);
  return status;
}

static void test_bezier_patches(tsolid_context *context) {
  for (int round = 0; round < 10; round++) {
    axis_spec axes[3];
    random_axes(axes, 1);
    part p = make_part(axes, map_wavy, round % 2);
    tsolid_boundary *from = create(context, &p, NULL), *boundary = NULL;
    int kinds = round == 0 ? 63 : 1 + random_below(62);
    tsolid_context_clear(context);
    CHECK(from && mix_bezier(context, &p, from, kinds, 0.0, &boundary) == TSOLID_OK);
    for (int i = 0; i < tsolid_context_n_findings(context); i++)
      fprintf(stderr, "    %s\n", tsolid_context_finding(context, i)->text);
    CHECK(boundary && same_boundaries(from, boundary));
    tsolid_boundary_free(boundary);
    tsolid_boundary_free(from);
    part_free(&p);
  }
}

/* ---- functions on two patches ------------------------------------------------------------------
 */

/* The belt of a part along x cut in two at x = c, its four sides each two T-splines of the same
 * functions: nothing is inserted, the patches are smooth across the cut. */
static void cut_belt(const part *p, double c, mixture *m) {
  for (int side = 0; side < 6; side++) {
    const tsolid_patch *patch = &p->patch[side];
    int first = m->n_points, n0 = patch->n_control[0], n = n0 * patch->n_control[1];
    if (side < 2) {
      add_nurbs(m, patch, 0, 0, 0);
      continue;
    }
    for (int i = 0; i < n; i++)
      homogeneous(patch, i, m->points + 4 * m->n_points++);
    for (int half = 0; half < 2; half++) {
      tsolid_tspline *t = &m->tspline[m->n];
      int *point = calloc((size_t)n, sizeof *point), count = 0;
      double *knots[2];
      for (int d = 0; d < 2; d++)
        t->knots[d] = knots[d] = part_doubles((size_t)n * (size_t)(patch->degree[d] + 2));
      for (int i = 0; i < n; i++) {
        const double *u = patch->knots[0] + i % n0, *v = patch->knots[1] + i / n0;
        int p0 = patch->degree[0] + 2, p1 = patch->degree[1] + 2;
        if (half ? !(u[p0 - 1] > c) : !(u[0] < c))
          continue;
        memcpy(knots[0] + count * p0, u, (size_t)p0 * sizeof *u);
        memcpy(knots[1] + count * p1, v, (size_t)p1 * sizeof *v);
        point[count++] = first + i;
      }
      t->point = point;
      t->n_functions = count;
      for (int d = 0; d < 2; d++)
        t->degree[d] = patch->degree[d];
      t->domain[0] = half ? c : 0.0;
      t->domain[1] = half ? 1.0 : c;
      t->domain[2] = 0.0;
      t->domain[3] = 1.0;
      m->patch[m->n++] = (tsolid_patch){.tspline = t};
    }
  }
  settle(m);
}

/* The ends of the belt keep one patch each. */
static void test_smooth(tsolid_context *context) {
  static const axis_spec axes[3] = {
      {1, {{3, 3, {0.25, 0.5, 0.75}}}}, {1, {{2, 1, {0.5}}}}, {1, {{4, 2, {0.25, 0.5}}}}};
  for (int round = 0; round < 4; round++) {
    part p = make_part(axes, map_wavy, round % 2);
    double c = round < 2 ? 0.5 : 0.375; /* a knot, and none */
    tsolid_boundary *whole = create(context, &p, NULL);
    mixture m = new_mixture();
    cut_belt(&p, c, &m);
    CHECK(m.n == 10);
    tsolid_boundary *boundary = create_mixture(context, &m);
    if (boundary && whole) {
      CHECK(tsi_boundary_validate(context, boundary) == TSOLID_OK);
      CHECK(boundary->n_functions == whole->n_functions);
      CHECK(boundary->preparation.n_knots_inserted == 0);
      CHECK_NEAR(sum_defect(boundary), 0.0, 4e-15);
      if (round < 2) {
        CHECK(same_boundaries(whole, boundary));
        check_file(context, &m, boundary);
      }
    }
    for (int order = 1; order <= 4; order++) {
      tsolid_boundary_input input = input_of(&m);
      tsolid_boundary *checked = NULL;
      m.smooth[0] = (tsolid_smooth_seam){{2, 3}, {1, 3}, order};
      input.n_smooth = 1;
      input.smooth = m.smooth;
      tsolid_context_clear(context);
      tsolid_status status = tsolid_boundary_create(context, &input, NULL, NULL, &checked);
      /* C^2 at a simple knot of degree 3, one polynomial elsewhere */
      int expected = round < 2 ? order <= 2 : 1;
      CHECK(status == (expected ? TSOLID_OK : TSOLID_ERROR_REFUSED));
      const tsolid_finding *finding = tsolid_context_finding(context, 0);
      CHECK(expected || (finding && strstr(finding->text, "derivatives of order 3 jump")));
      CHECK(!expected || same_boundaries(boundary, checked));
      tsolid_boundary_free(checked);
    }
    tsolid_boundary_free(boundary);
    tsolid_boundary_free(whole);
    free_mixture(&m);
    part_free(&p);
  }
}

/* ---- refusals ----------------------------------------------------------------------------------
 */

static void expect_refusal(tsolid_context *context, const mixture *m, const char *text) {
  tsolid_boundary *boundary = NULL;
  tsolid_boundary_input input = input_of(m);
  tsolid_context_clear(context);
  CHECK(tsolid_boundary_create(context, &input, NULL, NULL, &boundary) != TSOLID_OK && !boundary);
  const tsolid_finding *finding = tsolid_context_finding(context, 0);
  if (!CHECK(finding && strstr(finding->text, text)))
    fprintf(stderr, "    '%s' is not in: %s\n", text, finding ? finding->text : "nothing");
}

static void test_refused(tsolid_context *context) {
  static const axis_spec axes[3] = {{1, {{3, 1, {0.5}}}}, {1, {{2, 1, {0.5}}}}, {1, {{2, 0, {0}}}}};
  static const int flip[2] = {0, 0};
  part p = make_part(axes, map_wavy, 1);
  mixture m = new_mixture();
  for (int k = 0; k < 6; k++) {
    net list = rewrite_rows(&p.patch[k], 0);
    add_tspline(&m, &list, flip, 0, 0);
    free(list.list);
  }
  settle(&m);
  tsolid_boundary_free(create_mixture(context, &m));
  tsolid_tspline *t = &m.tspline[3];
  double *u = (double *)(size_t)t->knots[0], *v = (double *)(size_t)t->knots[1];
  int *point = (int *)(size_t)t->point;
#define SPOIL(type, place, value, text)                                                            \
  do {                                                                                             \
    type kept = (place);                                                                           \
    (place) = (value);                                                                             \
    expect_refusal(context, &m, text);                                                             \
    (place) = kept;                                                                                \
  } while (0)
  SPOIL(double, u[0], (double)NAN, "not finite");
  SPOIL(double, u[0], u[4] + 1.0, "decrease");
  SPOIL(double, v[3], (double)INFINITY, "not finite");
  SPOIL(int, point[2], -1, "names point");
  SPOIL(int, point[2], m.n_points, "names point");
  SPOIL(int, point[2], point[3], "is of no function");
  SPOIL(double, t->domain[1], t->domain[0], "domain");
  SPOIL(double, t->domain[0], (double)NAN, "domain");
  SPOIL(double, t->domain[1], 50.0, "vanish");
  SPOIL(int, t->degree[0], 26, "degree");
  SPOIL(int, t->n_functions, 3, "functions");
  SPOIL(int, t->n_functions, t->n_functions - 1, "vanish");
  SPOIL(double, m.points[3], 0.0, "weight");
  SPOIL(double, m.points[5], (double)NAN, "not finite");
  SPOIL(double, m.points[4 * point[0]], m.points[4 * point[0]] + 1.0, "");
  SPOIL(int, m.n_points, 0, "points");
  SPOIL(const tsolid_bezier_side *, m.patch[0].bezier, &m.bezier[0], "both");
#undef SPOIL
  tsolid_boundary_options options = {.refine_knots = 1};
  tsolid_boundary_input input = input_of(&m);
  tsolid_boundary *boundary = NULL;
  CHECK(tsolid_boundary_create(context, &input, &options, NULL, &boundary) ==
        TSOLID_ERROR_ARGUMENT);
  check_failing_memory(&input);
  tsolid_context_clear(context);
  tsolid_boundary *from = create(context, &p, NULL);
  CHECK(from && mix_bezier(context, &p, from, 21, 1e-3, &boundary) == TSOLID_ERROR_REFUSED);
  tsolid_boundary_free(from);
  free_mixture(&m);
  part_free(&p);
}

int main(void) {
  tsolid_context *context = new_context();
  test_rewritten(context);
  test_finer_neighbours(context);
  test_bezier_patches(context);
  test_smooth(context);
  test_refused(context);
  tsolid_context_free(context);
  return check_done();
}
