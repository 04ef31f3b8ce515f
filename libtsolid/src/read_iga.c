/* SPDX-License-Identifier: LGPL-2.1-or-later
 * .iga: control points and Bezier elements with their extraction, as the T-splines plug-in of Rhino
 * writes them. The format has neither neighbours nor knot intervals: see surface_graph.c.
 *
 *   type  plane | surface | thickened_surface | volume
 *   nodeN n, elemN m
 *   node  x y z w                                  Euclidean
 *   belem k p q
 *     k functions
 *     k rows of (p+1)(q+1) Bernstein coefficients, s fastest
 *   set ..., domain ...                            not needed
 *
 * Words and numbers are separated by blanks or line ends, '#' starts a comment. */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>

#include "bernstein.h"
#include "file_io.h"
#include "surface_graph.h"

static const char stage[] = "read";

static const size_t largest_file = (size_t)1 << 30;
/* Elements of a lower degree are raised to the highest; the coefficients grow so much at most. */
enum { MAX_GROWTH = 16 };

typedef struct list {
  void *item;
  size_t n, room, size;
} list;

typedef struct element_head {
  int degree[2], n_functions, line;
  size_t coefficient; /* its first */
} element_head;

typedef struct reader {
  tsolid_context *context;
  tsi_arena *arena;
  const char *begin, *at;
  int line;
  const char *word; /* the current one, not closed by a zero byte */
  size_t length;    /* 0: end of file */
  int word_line;
  size_t file_size;
  tsolid_status status;
  long n_nodes, n_elements; /* as declared; -1: not yet */
  int has_type;
  list node, element, function, coefficient;
  int *last_use; /* per node: 1 + the element that named it last */
} reader;

/* ---- words ------------------------------------------------------------------------------------
 */

static void next_word(reader *r) {
  const char *p = r->at;
  for (;; p++) {
    if (*p == '#')
      while (*p && *p != '\n')
        p++;
    if (*p == '\n')
      r->line++;
    else if (*p != ' ' && *p != '\t' && *p != '\r')
      break;
  }
  r->word = p;
  r->word_line = r->line;
  while (*p && *p != ' ' && *p != '\t' && *p != '\r' && *p != '\n' && *p != '#')
    p++;
  r->length = (size_t)(p - r->word);
  r->at = p;
}

static void skip_line(reader *r) {
  while (*r->at && *r->at != '\n')
    r->at++;
}

static int is_word(const reader *r, const char *text) {
  return strlen(text) == r->length && memcmp(r->word, text, r->length) == 0;
}

/* "found 'belem'", without anything that is not printable. */
static const char *show_word(const reader *r, char text[40]) {
  size_t n = r->length < 24 ? r->length : 24;
  if (n == 0)
    return "the end of the file";
  text[0] = '\'';
  for (size_t i = 0; i < n; i++)
    text[1 + i] = r->word[i] > ' ' && r->word[i] < 127 ? r->word[i] : '?';
  snprintf(text + 1 + n, 40 - 1 - n, "%s'", n < r->length ? "..." : "");
  return text;
}

static int fail(reader *r, int line, const char *text) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
  finding.entity = TSOLID_ENTITY_LINE;
  finding.index[0] = line;
  if (!r->status)
    r->status = tsi_report(r->context, &finding, "Line %d: %s", line, text);
  return 0;
}

static int fail_expected(reader *r, const char *what) {
  char text[128], word[40];
  snprintf(text, sizeof text, "expected %s, found %s", what, show_word(r, word));
  return fail(r, r->word_line, text);
}

static int fail_memory(reader *r) {
  if (!r->status)
    r->status = tsi_no_memory(r->context, stage);
  return 0;
}

static int read_number(reader *r, double *x) {
  const char *end;
  next_word(r);
  if (r->length == 0)
    return fail_expected(r, "a number");
  *x = tsi_number_parse(r->word, &end);
  if (end != r->word + r->length || !isfinite(*x))
    return fail_expected(r, "a finite number");
  return 1;
}

/* An integer of low..high; `what` names it. */
static int read_integer(reader *r, const char *what, long low, long high, long *value) {
  char *end, text[128], word[40];
  next_word(r);
  *value = strtol(r->word, &end, 10);
  if (r->length == 0 || end != r->word + r->length)
    return fail_expected(r, what);
  if (*value >= low && *value <= high)
    return 1;
  snprintf(text, sizeof text, "%s is %s, not one of %ld to %ld", what, show_word(r, word), low,
           high);
  return fail(r, r->word_line, text);
}

/* Room for n more items at the end of a list; NULL: no memory. */
static void *grow(reader *r, list *l, size_t n) {
  if (l->room - l->n < n) {
    size_t room = l->room + l->room / 2 + n + 64;
    void *moved = tsi_arena_new(r->arena, room, l->size);
    if (!moved) {
      fail_memory(r);
      return NULL;
    }
    if (l->n > 0)
      memcpy(moved, l->item, l->n * l->size);
    l->item = moved;
    l->room = room;
  }
  l->n += n;
  return (char *)l->item + (l->n - n) * l->size;
}

/* ---- records ----------------------------------------------------------------------------------
 */

static int read_type(reader *r) {
  next_word(r);
  r->has_type = 1;
  if (is_word(r, "plane") || is_word(r, "surface"))
    return 1;
  if (!is_word(r, "volume") && !is_word(r, "thickened_surface"))
    return fail_expected(r, "'plane', 'surface', 'thickened_surface' or 'volume'");
  char word[40];
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = TSOLID_ENTITY_LINE;
  finding.index[0] = r->word_line;
  r->status = tsi_report(r->context, &finding,
                         "Line %d: the file is of the type %s; only plane and surface are taken",
                         r->word_line, show_word(r, word));
  return 0;
}

/* Every record takes a certain number of bytes: what a file declares cannot exceed what it holds.
 */
static int read_count(reader *r, const char *what, size_t record_size, long *count) {
  if (*count >= 0)
    return fail(r, r->word_line, "the number is given a second time");
  if (!read_integer(r, what, 1, TSI_MAX_COUNT / 16, count))
    return 0;
  if ((size_t)*count <= r->file_size / record_size + 1)
    return 1;
  return fail(r, r->word_line, "the file is too short for so many");
}

static int read_node(reader *r) {
  if (r->n_nodes < 0)
    return fail(r, r->word_line, "'nodeN' is missing before the first node");
  if (r->node.n == (size_t)r->n_nodes)
    return fail(r, r->word_line, "there are more nodes than nodeN says");
  double *h = grow(r, &r->node, 1);
  for (int c = 0; h && c < 4; c++)
    if (!read_number(r, &h[c]))
      return 0;
  if (!h)
    return 0;
  if (!(h[3] > 0.0))
    return fail(r, r->word_line, "the weight of the node is not positive");
  for (int c = 0; c < 3; c++)
    h[c] *= h[3];
  return 1;
}

static int read_functions(reader *r, const element_head *head) {
  size_t element = r->element.n;
  if (!r->last_use)
    r->last_use = tsi_arena_new(r->arena, (size_t)r->n_nodes, sizeof *r->last_use);
  if (!r->last_use)
    return fail_memory(r);
  int *function = grow(r, &r->function, (size_t)head->n_functions);
  for (int k = 0; function && k < head->n_functions; k++) {
    long id;
    if (!read_integer(r, "the function", 0, r->n_nodes - 1, &id))
      return 0;
    if (r->last_use[id] == (int)element)
      return fail(r, r->word_line, "the element names a function twice");
    r->last_use[id] = (int)element;
    function[k] = (int)id;
  }
  return function != NULL;
}

static int read_element(reader *r) {
  element_head head = {.line = r->word_line, .coefficient = r->coefficient.n};
  long k, degree;
  if (r->n_nodes < 0 || r->n_elements < 0)
    return fail(r, r->word_line, "'nodeN' or 'elemN' is missing before the first element");
  if (r->element.n == (size_t)r->n_elements)
    return fail(r, r->word_line, "there are more elements than elemN says");
  if (!read_integer(r, "the number of functions", 1, r->n_nodes, &k))
    return 0;
  head.n_functions = (int)k;
  for (int d = 0; d < 2; d++) {
    if (!read_integer(r, "the degree", 1, TSI_MAX_DEGREE, &degree))
      return 0;
    head.degree[d] = (int)degree;
  }
  size_t width = (size_t)(head.degree[0] + 1) * (size_t)(head.degree[1] + 1);
  if ((size_t)k * (width + 1) > r->file_size - (size_t)(r->at - r->begin) ||
      (double)r->coefficient.n + (double)k * (double)width > TSI_MAX_COUNT)
    return fail(r, r->word_line, "the file is too short for so many coefficients");
  element_head *kept = grow(r, &r->element, 1);
  if (!kept)
    return 0;
  *kept = head;
  if (!read_functions(r, &head))
    return 0;
  for (long i = 0; i < k; i++) {
    double *c = grow(r, &r->coefficient, width);
    for (size_t j = 0; c && j < width; j++)
      if (!read_number(r, &c[j]))
        return 0;
    if (!c)
      return 0;
  }
  return 1;
}

static int read_records(reader *r) {
  int in_domain = 0;
  for (;;) {
    next_word(r);
    if (r->length == 0)
      break;
    int is_number = (r->word[0] >= '0' && r->word[0] <= '9') || r->word[0] == '-';
    int known = is_word(r, "type")    ? read_type(r)
                : is_word(r, "nodeN") ? read_count(r, "nodeN", 10, &r->n_nodes)
                : is_word(r, "elemN") ? read_count(r, "elemN", 16, &r->n_elements)
                : is_word(r, "node") || is_word(r, "gnode") ? read_node(r)
                : is_word(r, "belem")                       ? read_element(r)
                : is_word(r, "set") || is_word(r, "domain") ? (skip_line(r), 1)
                : is_number && in_domain                    ? 1
                                                            : -1;
    if (known == 0)
      return 0;
    if (known < 0)
      return fail_expected(r, "'node', 'belem', 'set' or 'domain'");
    if (!is_number)
      in_domain = is_word(r, "domain");
  }
  if (!r->has_type)
    return fail(r, r->word_line, "the file has no 'type'");
  if (r->n_nodes < 0 || r->n_elements < 0)
    return fail(r, r->word_line, "the file has no 'nodeN' or no 'elemN'");
  char text[128];
  snprintf(text, sizeof text, "the file ends with %zu of %ld nodes and %zu of %ld elements",
           r->node.n, r->n_nodes, r->element.n, r->n_elements);
  if (r->node.n != (size_t)r->n_nodes || r->element.n != (size_t)r->n_elements)
    return fail(r, r->word_line, text);
  return 1;
}

/* ---- the surface ------------------------------------------------------------------------------
 */

typedef struct numbered {
  int function, row;
} numbered;

static int compare_numbered(const void *a, const void *b) {
  const numbered *p = a, *q = b;
  return (p->function > q->function) - (p->function < q->function);
}

/* (p+1) x (q+1) coefficients as (d+1) x (d+1) of the same polynomial. */
static void raise_net(const int degree[2], int to, const double *from, double *target) {
  double along[TSI_MAX_ORDER * TSI_MAX_ORDER];
  int n0 = degree[0] + 1, n1 = degree[1] + 1, n = to + 1;
  for (int j = 0; j < n1; j++)
    tsi_bernstein_raise(degree[0], to, 1, from + n0 * j, along + n * j);
  tsi_bernstein_raise(degree[1], to, n, along, target);
}

/* Elements with their functions in ascending order, all of one degree. */
static tsolid_status fill_elements(reader *r, tsolid_surface *s, int *n_raised) {
  const element_head *head = r->element.item;
  const int *function = r->function.item;
  size_t n_entries = r->function.n, entry = 0;
  *n_raised = 0;
  for (size_t e = 0; e < r->element.n; e++)
    for (int d = 0; d < 2; d++)
      s->degree = head[e].degree[d] > s->degree ? head[e].degree[d] : s->degree;
  size_t width = (size_t)(s->degree + 1) * (size_t)(s->degree + 1);
  if ((double)n_entries * (double)width >
      fmin(TSI_MAX_COUNT, MAX_GROWTH * (double)r->coefficient.n))
    return tsi_fail(r->context, TSOLID_ERROR_REFUSED, stage,
                    "The elements' degrees differ too much to raise all to %d", s->degree);
  numbered *order = tsi_arena_new(r->arena, (size_t)r->n_nodes, sizeof *order);
  s->function_start = tsi_arena_new(&s->arena, r->element.n + 1, sizeof *s->function_start);
  s->function = tsi_arena_new(&s->arena, n_entries, sizeof *s->function);
  s->coefficient = tsi_arena_new(&s->arena, n_entries * width, sizeof *s->coefficient);
  if (!order || !s->function_start || !s->function || !s->coefficient)
    return tsi_no_memory(r->context, stage);
  for (size_t e = 0; e < r->element.n; e++) {
    const element_head *h = &head[e];
    const double *from = (const double *)r->coefficient.item + h->coefficient;
    size_t own = (size_t)(h->degree[0] + 1) * (size_t)(h->degree[1] + 1);
    *n_raised += h->degree[0] < s->degree || h->degree[1] < s->degree;
    for (int k = 0; k < h->n_functions; k++)
      order[k] = (numbered){*function++, k};
    qsort(order, (size_t)h->n_functions, sizeof *order, compare_numbered);
    for (int k = 0; k < h->n_functions; k++, entry++) {
      s->function[entry] = order[k].function;
      raise_net(h->degree, s->degree, from + own * (size_t)order[k].row,
                s->coefficient + width * entry);
    }
    s->function_start[e + 1] = (int)entry;
  }
  return TSOLID_OK;
}

/* Sums far from one are no partition of unity, and hide what is a vertex and what is not. */
static tsolid_status check_sums(reader *r, const tsolid_surface *s) {
  size_t width = (size_t)(s->degree + 1) * (size_t)(s->degree + 1);
  const element_head *head = r->element.item;
  for (int e = 0; e < s->n_faces; e++)
    for (size_t i = 0; i < width; i++) {
      double sum = 0.0;
      for (int k = s->function_start[e]; k < s->function_start[e + 1]; k++)
        sum += s->coefficient[(size_t)k * width + i];
      if (fabs(sum - 1.0) <= 0.5)
        continue;
      tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
      finding.entity = TSOLID_ENTITY_LINE;
      finding.index[0] = head[e].line;
      return tsi_report(r->context, &finding,
                        "Line %d: the functions of element %d sum to %g, far from 1", head[e].line,
                        e, sum);
    }
  return TSOLID_OK;
}

static void note_facts(tsolid_context *context, const tsolid_surface *s,
                       const tsi_graph_facts *facts, int n_raised) {
  tsolid_finding note = tsi_finding(TSOLID_NOTE, TSOLID_OK, stage);
  int n_free = facts->n_strips - facts->n_inferred;
  if (n_raised > 0)
    tsi_report(context, &note, "%d of %d elements were raised to degree %d", n_raised, s->n_faces,
               s->degree);
  tsi_report(context, &note,
             "The format has no knot intervals: of %d strips of elements %d have their width from "
             "the functions' derivatives, relative to a neighbour; in the %d group%s that remain "
             "the smallest is taken as 1",
             facts->n_strips, facts->n_inferred, n_free, n_free == 1 ? "" : "s");
  if (facts->n_conflicts > 0)
    tsi_report(context, &note, "At %d edges the functions ask for other knot intervals: not used",
               facts->n_conflicts);
  if (s->sum_defect > 1e-9) {
    note.measured = s->sum_defect;
    tsi_report(context, &note, "The functions sum to 1 up to %.3g only; they are kept as they are",
               s->sum_defect);
  }
}

static tsolid_status build_surface(reader *r, tsolid_surface *s) {
  tsi_graph_facts facts;
  int n_raised;
  s->n_points = (int)r->n_nodes;
  s->n_faces = (int)r->n_elements;
  s->points = tsi_arena_new(&s->arena, (size_t)s->n_points, 4 * sizeof *s->points);
  if (!s->points)
    return tsi_no_memory(r->context, stage);
  memcpy(s->points, r->node.item, (size_t)s->n_points * 4 * sizeof *s->points);
  tsolid_status status = fill_elements(r, s, &n_raised);
  if (!status)
    status = check_sums(r, s);
  if (!status)
    status = tsi_progress(r->context, stage, 0.5);
  if (!status)
    status = tsi_surface_connect(r->context, s, &facts);
  if (!status)
    status = tsi_surface_finish(r->context, s);
  if (!status)
    note_facts(r->context, s, &facts, n_raised);
  return status;
}

tsolid_status tsolid_read_iga(tsolid_context *context, const char *path, tsolid_surface **surface) {
  if (surface)
    *surface = NULL;
  if (!context || !path || !surface)
    return TSOLID_ERROR_ARGUMENT;
  tsi_arena arena = tsi_arena_create(context);
  reader r = {.context = context,
              .arena = &arena,
              .line = 1,
              .n_nodes = -1,
              .n_elements = -1,
              .node = {.size = 4 * sizeof(double)},
              .element = {.size = sizeof(element_head)},
              .function = {.size = sizeof(int)},
              .coefficient = {.size = sizeof(double)}};
  tsolid_surface *made = NULL;
  char *bytes = NULL;
  tsolid_status status = tsi_file_read(context, stage, path, largest_file, &bytes, &r.file_size);
  if (status)
    goto done;
  r.begin = r.at = bytes;
  if (!read_records(&r)) {
    status = r.status;
    goto done;
  }
  made = tsi_surface_new(context);
  status = made ? build_surface(&r, made) : tsi_no_memory(context, stage);
done:
  tsi_delete(&context->allocator, bytes);
  tsi_arena_free(&arena);
  if (status)
    tsolid_surface_free(made);
  else
    *surface = made;
  return status;
}
