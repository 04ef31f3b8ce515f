/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Reads T-spline surfaces from .tsm (Rhino T-Splines, Fusion 360). One record per line, its first
 * word the kind; the N-th record of a kind is number N, a bare word is a deleted number.
 *
 *   f link flag | e link interval | v link NORTH|WEST|SOUTH|EAST
 *   l previous next opposite vertex face edge flag     a link and the vertex where it starts
 *   ec edge code                                       an end condition
 *   0m odd-grip-map | gvp vertex | gv vertex | cg vertex 4 S.. G..     control points of vertices
 *   0g x y z w                                         a control point
 *
 * What else there is (units, selections of an editor, symmetry) is kept as it stands. */
#include <limits.h>

#include "file_io.h"
#include "surface.h"

static const char stage[] = "read";
static const size_t max_file_size = (size_t)1 << 30;

enum { MAX_EXTRA = 3 }; /* multiplicity that a vertex may add in one direction */

typedef enum keyword { F, E, V, L, G, GVP, GV, CG, EC, N_KEYWORDS } keyword;

typedef struct text_line {
  const char *at, *end; /* without comment and white space at the end */
  int number;
} text_line;

/* Numbers of the file, deleted ones included, to indices of the surface, and back. */
typedef struct numbering {
  int n_records, n;
  int *index;  /* per record, -1: deleted */
  int *record; /* per index */
  int *line;   /* per index */
} numbering;

typedef struct reader {
  tsolid_context *context;
  tsi_arena scratch;
  tsolid_surface *surface;
  const char *path, *text, *text_end;
  int n[N_KEYWORDS]; /* records, deleted ones included */
  int n_done[N_KEYWORDS];
  numbering face, edge, vertex, link, point;
  int *grip_vertex; /* per point record: vertex index; -1: none */
  char *grip_is_primary, *grip_is_placed;
  text_line *placement; /* what stands behind "0m cg" */
  int n_placements, has_degree;
  size_t head_size, tail_size;
  tsolid_status status;
} reader;

/* ---- lines and words ---------------------------------------------------------------------------
 */

static int is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == 0;
}

/* The line at *at (of at most `end`), and *at moved behind it. */
static text_line next_line(const char **at, const char *end, int number) {
  text_line line = {.at = *at, .number = number};
  const char *c = *at, *comment = NULL;
  while (c < end && *c != '\n' && *c != '\r') {
    if (*c == '#' && !comment)
      comment = c;
    c++;
  }
  line.end = comment ? comment : c;
  if (c < end)
    c += c[0] == '\r' && c + 1 < end && c[1] == '\n' ? 2 : 1;
  *at = c;
  while (line.at < line.end && is_blank(*line.at))
    line.at++;
  while (line.at < line.end && is_blank(line.end[-1]))
    line.end--;
  return line;
}

/* The next word; length 0 at the end of the line. */
static size_t next_word(text_line *line, const char **word) {
  while (line->at < line->end && is_blank(*line->at))
    line->at++;
  *word = line->at;
  while (line->at < line->end && !is_blank(*line->at))
    line->at++;
  return (size_t)(line->at - *word);
}

static int word_is(const char *word, size_t length, const char *text) {
  return strlen(text) == length && memcmp(word, text, length) == 0;
}

static int fail(reader *r, const text_line *line, const char *text) {
  if (r->status)
    return 0;
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
  finding.entity = TSOLID_ENTITY_LINE;
  finding.index[0] = line->number;
  r->status = tsi_report(r->context, &finding, "%s, line %d: %s", r->path, line->number, text);
  return 0;
}

static int fail_memory(reader *r) {
  if (!r->status)
    r->status = tsi_no_memory(r->context, stage);
  return 0;
}

static int read_integer(reader *r, text_line *line, int low, int high, int *value) {
  const char *word;
  size_t length = next_word(line, &word), k = length && word[0] == '-';
  long long x = 0;
  if (length == 0)
    return fail(r, line, "a number is missing");
  if (k == length || length > 11)
    return fail(r, line, "not a whole number that can be");
  for (; k < length; k++) {
    if (word[k] < '0' || word[k] > '9')
      return fail(r, line, "not a whole number");
    x = 10 * x + (word[k] - '0');
  }
  x = word[0] == '-' ? -x : x;
  if (x < low || x > high)
    return fail(r, line, "a number of a record that does not exist, or out of range");
  *value = (int)x;
  return 1;
}

static int read_number(reader *r, text_line *line, double *value) {
  const char *word, *end;
  size_t length = next_word(line, &word);
  if (length == 0)
    return fail(r, line, "a number is missing");
  for (size_t k = 0; k < length; k++)
    if (!strchr("+-.0123456789eE", word[k]) || !word[k])
      return fail(r, line, "not a number");
  *value = tsi_number_parse(word, &end);
  if (end != word + length)
    return fail(r, line, "not a number");
  return isfinite(*value) || fail(r, line, "a number is too large");
}

static int read_end(reader *r, const text_line *line) {
  return line->at >= line->end || fail(r, line, "more words than the record has");
}

/* ---- the first pass: counts --------------------------------------------------------------------
 */

/* The kind of a line, its first word (or two) taken; -1: another one, left whole. */
static int read_keyword(text_line *line) {
  static const char *const name[] = {"f", "e", "v", "l", "0g"};
  text_line rest = *line;
  const char *word;
  size_t length = next_word(&rest, &word);
  int found = -1;
  for (int k = F; k <= G; k++)
    if (word_is(word, length, name[k]))
      found = k;
  if (word_is(word, length, "ec"))
    found = EC;
  if (word_is(word, length, "0m")) {
    length = next_word(&rest, &word);
    found = word_is(word, length, "gvp")  ? GVP
            : word_is(word, length, "gv") ? GV
            : word_is(word, length, "cg") ? CG
                                          : -1;
    if (word_is(word, length, "odd-grip-map"))
      found = N_KEYWORDS; /* nothing to read */
  }
  if (found >= 0)
    *line = rest;
  return found;
}

static int check_head_line(reader *r, text_line line) {
  const char *word;
  size_t length = next_word(&line, &word);
  int degree;
  if (!word_is(word, length, "degree"))
    return 1;
  if (!read_integer(r, &line, 0, 1000, &degree))
    return 0;
  r->has_degree = 1;
  if (degree == 3)
    return 1;
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_REFUSED, stage);
  finding.entity = TSOLID_ENTITY_LINE;
  finding.index[0] = line.number;
  r->status = tsi_report(r->context, &finding,
                         "%s, line %d: T-splines of degree %d are not taken, only of degree 3",
                         r->path, line.number, degree);
  return 0;
}

static const char *skip_title(reader *r, int *number) {
  const char *at = r->text;
  if (r->text_end - at >= 3 && memcmp(at, "\xef\xbb\xbf", 3) == 0)
    at += 3;
  text_line title = {.at = at, .end = r->text_end, .number = 1};
  *number = 1;
  if (r->text_end - at < 4 || memcmp(at, "#TS0", 4) != 0) {
    fail(r, &title, "the file does not begin with #TS0200: it is no .tsm");
    return NULL;
  }
  next_line(&at, r->text_end, 1);
  return at;
}

static int count_records(reader *r) {
  int number, begun = 0;
  const char *at = skip_title(r, &number);
  while (at && at < r->text_end) {
    text_line line = next_line(&at, r->text_end, ++number);
    size_t size = (size_t)(line.end - line.at) + 1;
    int kind = read_keyword(&line);
    if (kind < 0) {
      *(begun ? &r->tail_size : &r->head_size) += size;
      if (!check_head_line(r, line))
        return 0;
      continue;
    }
    begun = 1;
    if (kind < N_KEYWORDS && ++r->n[kind] > TSI_MAX_COUNT)
      return fail(r, &line, "too many records");
  }
  if (at && !r->has_degree) {
    text_line line = {.number = number};
    return fail(r, &line, "the file ends without naming a degree");
  }
  return at != NULL;
}

/* ---- the second pass: records ------------------------------------------------------------------
 */

static int make_numbering(reader *r, numbering *of, int n_records) {
  of->n_records = n_records;
  of->index = tsi_arena_new(&r->scratch, (size_t)n_records, sizeof *of->index);
  of->record = tsi_arena_new(&r->surface->arena, (size_t)n_records, sizeof *of->record);
  of->line = tsi_arena_new(&r->scratch, (size_t)n_records, sizeof *of->line);
  return (of->index && of->record && of->line) || fail_memory(r);
}

static int allocate(reader *r) {
  tsolid_surface *s = r->surface;
  tsi_arena *a = &s->arena;
  size_t n_f = (size_t)r->n[F], n_e = (size_t)r->n[E], n_v = (size_t)r->n[V];
  size_t n_l = (size_t)r->n[L], n_g = (size_t)r->n[G];
  if (!make_numbering(r, &r->face, r->n[F]) || !make_numbering(r, &r->edge, r->n[E]) ||
      !make_numbering(r, &r->vertex, r->n[V]) || !make_numbering(r, &r->link, r->n[L]) ||
      !make_numbering(r, &r->point, r->n[G]))
    return 0;
  s->face_link = tsi_arena_new(a, n_f, sizeof *s->face_link);
  s->edge_link = tsi_arena_new(a, n_e, sizeof *s->edge_link);
  s->interval = tsi_arena_new(a, n_e, sizeof *s->interval);
  s->tsm.condition = tsi_arena_new(a, n_e, sizeof *s->tsm.condition);
  s->vertex_link = tsi_arena_new(a, n_v, sizeof *s->vertex_link);
  s->tsm.compass = tsi_arena_new(a, n_v, sizeof *s->tsm.compass);
  s->tsm.extra = tsi_arena_new(a, n_v, sizeof *s->tsm.extra);
  s->tsm.grip_start = tsi_arena_new(a, n_v + 1, sizeof *s->tsm.grip_start);
  s->link = tsi_arena_new(a, n_l, sizeof *s->link);
  s->tsm.link_flag = tsi_arena_new(a, n_l, sizeof *s->tsm.link_flag);
  s->points = tsi_arena_new(a, n_g, 4 * sizeof *s->points);
  s->tsm.xyzw = tsi_arena_new(a, n_g, 4 * sizeof *s->tsm.xyzw);
  s->tsm.head = tsi_arena_new(a, r->head_size + 1, 1);
  s->tsm.tail = tsi_arena_new(a, r->tail_size + 1, 1);
  r->grip_vertex = tsi_arena_new(&r->scratch, n_g, sizeof *r->grip_vertex);
  r->grip_is_primary = tsi_arena_new(&r->scratch, n_g, 1);
  r->grip_is_placed = tsi_arena_new(&r->scratch, n_g, 1);
  r->placement = tsi_arena_new(&r->scratch, (size_t)r->n[CG], sizeof *r->placement);
  if (!s->face_link || !s->edge_link || !s->interval || !s->tsm.condition || !s->vertex_link ||
      !s->tsm.compass || !s->tsm.extra || !s->tsm.grip_start || !s->link || !s->tsm.link_flag ||
      !s->points || !s->tsm.xyzw || !s->tsm.head || !s->tsm.tail || !r->grip_vertex ||
      !r->grip_is_primary || !r->grip_is_placed || !r->placement)
    return fail_memory(r);
  for (size_t k = 0; k < n_e; k++)
    s->tsm.condition[k] = -1;
  r->head_size = r->tail_size = 0;
  return 1;
}

/* Numbers the next record; returns its index, or -1 for a deleted one: nothing behind the word. */
static int number_record(numbering *of, int *n_done, const text_line *line) {
  int record = (*n_done)++;
  if (line->at >= line->end) {
    of->index[record] = -1;
    return -1;
  }
  of->index[record] = of->n;
  of->record[of->n] = record;
  of->line[of->n] = line->number;
  return of->n++;
}

static int read_face(reader *r, text_line *line) {
  int f = number_record(&r->face, &r->n_done[F], line), flag;
  if (f < 0)
    return 1;
  if (!read_integer(r, line, 0, r->n[L] - 1, &r->surface->face_link[f]))
    return 0;
  if (line->at < line->end && !read_integer(r, line, INT_MIN, INT_MAX, &flag))
    return 0;
  return read_end(r, line);
}

static int read_edge(reader *r, text_line *line) {
  int e = number_record(&r->edge, &r->n_done[E], line);
  return e < 0 || (read_integer(r, line, 0, r->n[L] - 1, &r->surface->edge_link[e]) &&
                   read_number(r, line, &r->surface->interval[e]) && read_end(r, line));
}

static int read_vertex(reader *r, text_line *line) {
  static const char *const compass[] = {"EAST", "NORTH", "WEST", "SOUTH"};
  int v = number_record(&r->vertex, &r->n_done[V], line);
  if (v < 0)
    return 1;
  if (!read_integer(r, line, 0, r->n[L] - 1, &r->surface->vertex_link[v]))
    return 0;
  const char *word;
  size_t length = next_word(line, &word);
  for (int d = 0; d < 4; d++)
    if (word_is(word, length, compass[d])) {
      r->surface->tsm.compass[v] = d;
      return read_end(r, line);
    }
  return fail(r, line, "not one of NORTH, WEST, SOUTH, EAST");
}

static int read_link(reader *r, text_line *line) {
  int i = number_record(&r->link, &r->n_done[L], line), n = r->n[L] - 1;
  if (i < 0)
    return 1;
  tsi_link *l = &r->surface->link[i];
  int *flag = &r->surface->tsm.link_flag[i];
  if (!read_integer(r, line, 0, n, &l->prev) || !read_integer(r, line, 0, n, &l->next) ||
      !read_integer(r, line, 0, n, &l->opposite) ||
      !read_integer(r, line, 0, r->n[V] - 1, &l->vertex) ||
      !read_integer(r, line, -1, r->n[F] - 1, &l->face) ||
      !read_integer(r, line, 0, r->n[E] - 1, &l->edge) || !read_integer(r, line, 0, 2, flag))
    return 0;
  if (l->face >= 0 && *flag == 2)
    return fail(r, line, "the flag of a link with a face is 0 or 1");
  l->straight = l->face >= 0 && *flag == 1;
  return read_end(r, line);
}

static int read_point(reader *r, text_line *line) {
  int p = number_record(&r->point, &r->n_done[G], line);
  if (p < 0)
    return 1;
  double *x = r->surface->tsm.xyzw + 4 * (size_t)p;
  for (int d = 0; d < 4; d++)
    if (!read_number(r, line, &x[d]))
      return 0;
  if (!(x[3] > 0.0))
    return fail(r, line, "the weight of a control point must be positive");
  for (int d = 0; d < 3; d++)
    r->surface->points[4 * (size_t)p + (size_t)d] = x[d] * x[3];
  r->surface->points[4 * (size_t)p + 3] = x[3];
  return read_end(r, line);
}

/* "0m gvp v", "0m gv v": the next control point's vertex. Vertices were counted, not yet numbered:
 * their records stand here for now. */
static int read_grip(reader *r, text_line *line, int is_primary) {
  int record = r->n_done[GVP]++, vertex;
  if (record >= r->n[G])
    return fail(r, line, "the map has more control points than there are 0g records");
  if (!read_integer(r, line, is_primary ? 0 : -1, r->n[V] - 1, &vertex))
    return 0;
  r->grip_vertex[record] = vertex;
  r->grip_is_primary[record] = (char)is_primary;
  return read_end(r, line);
}

static int read_condition(reader *r, text_line *line) {
  int record, code = 0;
  if (line->at >= line->end)
    return 1; /* deleted */
  if (!read_integer(r, line, 0, r->n[E] - 1, &record))
    return 0;
  if (line->at < line->end && !read_integer(r, line, 0, INT_MAX, &code))
    return 0;
  int e = record < r->n_done[E] ? r->edge.index[record] : -1;
  if (e < 0)
    return fail(r, line, "an end condition of an edge that does not exist");
  r->surface->tsm.condition[e] = code;
  return read_end(r, line);
}

static void keep_line(char *to, size_t *size, const text_line *line) {
  size_t n = (size_t)(line->end - line->at);
  if (n == 0)
    return;
  for (size_t k = 0; k < n; k++)
    to[*size + k] = line->at[k] ? line->at[k] : ' '; /* the text ends with a zero byte */
  to[*size + n] = '\n';
  *size += n + 1;
}

static int read_records(reader *r) {
  int number, begun = 0;
  const char *at = skip_title(r, &number);
  while (at && at < r->text_end && !r->status) {
    text_line line = next_line(&at, r->text_end, ++number), whole = line;
    int kind = read_keyword(&line);
    begun = begun || kind >= 0;
    switch (kind) {
    case F:
      read_face(r, &line);
      break;
    case E:
      read_edge(r, &line);
      break;
    case V:
      read_vertex(r, &line);
      break;
    case L:
      read_link(r, &line);
      break;
    case G:
      read_point(r, &line);
      break;
    case GVP:
    case GV:
      read_grip(r, &line, kind == GVP);
      break;
    case CG:
      r->placement[r->n_placements++] = line;
      break;
    case EC:
      read_condition(r, &line);
      break;
    case N_KEYWORDS:
      break;
    default:
      if (begun)
        keep_line(r->surface->tsm.tail, &r->tail_size, &whole);
      else
        keep_line(r->surface->tsm.head, &r->head_size, &whole);
    }
  }
  return !r->status;
}

/* ---- from records to indices -------------------------------------------------------------------
 */

static int fail_record(reader *r, const char *kind, const numbering *of, int i, const char *text) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, stage);
  finding.entity = TSOLID_ENTITY_LINE;
  finding.index[0] = of->line[i];
  if (!r->status)
    r->status = tsi_report(r->context, &finding, "%s, line %d: %s %d %s", r->path, of->line[i],
                           kind, of->record[i], text);
  return 0;
}

static int renumber(int *value, const numbering *by) {
  if (*value >= 0)
    *value = by->index[*value];
  else
    return 1;
  return *value >= 0;
}

static int renumber_all(reader *r) {
  tsolid_surface *s = r->surface;
  static const char deleted[] = "names a record that is deleted";
  s->n_faces = r->face.n;
  s->n_edges = r->edge.n;
  s->n_vertices = r->vertex.n;
  s->n_links = r->link.n;
  s->n_points = r->point.n;
  for (int i = 0; i < s->n_links; i++) {
    tsi_link *l = &s->link[i];
    if (!renumber(&l->prev, &r->link) || !renumber(&l->next, &r->link) ||
        !renumber(&l->opposite, &r->link) || !renumber(&l->vertex, &r->vertex) ||
        !renumber(&l->face, &r->face) || !renumber(&l->edge, &r->edge))
      return fail_record(r, "l", &r->link, i, deleted);
  }
  for (int i = 0; i < s->n_faces; i++) {
    if (!renumber(&s->face_link[i], &r->link))
      return fail_record(r, "f", &r->face, i, deleted);
    for (int n = 0; n < s->n_links && s->link[s->face_link[i]].straight; n++)
      s->face_link[i] = s->link[s->face_link[i]].next; /* a corner to start from */
  }
  for (int i = 0; i < s->n_edges; i++)
    if (!renumber(&s->edge_link[i], &r->link))
      return fail_record(r, "e", &r->edge, i, deleted);
  for (int i = 0; i < s->n_vertices; i++)
    if (!renumber(&s->vertex_link[i], &r->link))
      return fail_record(r, "v", &r->vertex, i, deleted);
  s->face_record = r->face.record;
  s->vertex_record = r->vertex.record;
  s->tsm.edge_record = r->edge.record;
  s->tsm.link_record = r->link.record;
  s->tsm.point_record = r->point.record;
  s->tsm.n_face_records = r->n[F];
  s->tsm.n_edge_records = r->n[E];
  s->tsm.n_vertex_records = r->n[V];
  s->tsm.n_link_records = r->n[L];
  s->tsm.n_point_records = r->n[G];
  s->tsm.present = 1;
  return 1;
}

/* ---- control points of vertices ----------------------------------------------------------------
 */

/* "0m cg v 4 S_north S_west S_south S_east": a first look for the sizes. */
static int read_extra(reader *r, text_line *line, int *vertex) {
  static const int direction[4] = {TSI_NORTH, TSI_WEST, TSI_SOUTH, TSI_EAST};
  int n;
  if (!read_integer(r, line, 0, r->n[V] - 1, vertex))
    return 0;
  *vertex = r->vertex.index[*vertex];
  if (*vertex < 0)
    return fail(r, line, "control points of a vertex that is deleted");
  if (!read_integer(r, line, 0, INT_MAX, &n))
    return 0;
  if (n != 4)
    return fail(r, line, "only control points in four directions are known");
  for (int k = 0; k < 4; k++)
    if (!read_integer(r, line, 0, MAX_EXTRA, &r->surface->tsm.extra[*vertex][direction[k]]))
      return 0;
  return 1;
}

/* Place in the vertex's block of the point i to the east and j to the north of the primary one. */
static size_t block_index(const tsolid_surface *s, int vertex, int i, int j) {
  const int *extra = s->tsm.extra[vertex];
  int width = 1 + extra[TSI_EAST] + extra[TSI_WEST];
  return s->tsm.grip_start[vertex] + (size_t)(i + extra[TSI_WEST]) +
         (size_t)width * (size_t)(j + extra[TSI_SOUTH]);
}

/* The wedges north to west, west to south, ..: in each, r steps along the first direction and c
 * along the second. */
static int read_wedges(reader *r, text_line *line, int vertex) {
  static const int direction[4] = {TSI_NORTH, TSI_WEST, TSI_SOUTH, TSI_EAST};
  static const int east[4] = {1, 0, -1, 0}, north[4] = {0, 1, 0, -1};
  const int *extra = r->surface->tsm.extra[vertex];
  for (int k = 0; k < 4; k++) {
    int a = direction[k], b = direction[(k + 1) % 4];
    for (int n = 1; n <= extra[a]; n++)
      for (int m = 0; m <= extra[b]; m++) {
        int grip;
        if (!read_integer(r, line, -1, r->n[G] - 1, &grip))
          return 0;
        if (grip < 0)
          continue;
        int point = r->point.index[grip];
        if (point < 0 || r->grip_vertex[grip] != r->vertex.record[vertex] ||
            r->grip_is_primary[grip])
          return fail(r, line, "a control point that is not a further one of this vertex");
        if (r->grip_is_placed[grip])
          return fail(r, line, "a control point that stands in two places");
        r->grip_is_placed[grip] = 1;
        size_t at =
            block_index(r->surface, vertex, n * east[a] + m * east[b], n * north[a] + m * north[b]);
        r->surface->tsm.grip[at] = point;
      }
  }
  return read_end(r, line);
}

static int size_blocks(reader *r) {
  tsolid_surface *s = r->surface;
  char *seen = tsi_arena_new(&r->scratch, (size_t)s->n_vertices, 1);
  if (!seen)
    return fail_memory(r);
  for (int k = 0; k < r->n_placements; k++) {
    text_line line = r->placement[k];
    int vertex;
    if (!read_extra(r, &line, &vertex))
      return 0;
    if (seen[vertex]++)
      return fail_record(r, "v", &r->vertex, vertex, "has two cg records");
  }
  for (int v = 0; v < s->n_vertices; v++) {
    const int *extra = s->tsm.extra[v];
    s->tsm.grip_start[v + 1] = s->tsm.grip_start[v] + (size_t)(1 + extra[0] + extra[2]) *
                                                          (size_t)(1 + extra[1] + extra[3]);
  }
  size_t n = s->tsm.grip_start[s->n_vertices];
  s->tsm.grip = tsi_arena_new(&s->arena, n, sizeof *s->tsm.grip);
  if (!s->tsm.grip)
    return fail_memory(r);
  for (size_t k = 0; k < n; k++)
    s->tsm.grip[k] = -1;
  return 1;
}

static int place_primary(reader *r) {
  tsolid_surface *s = r->surface;
  for (int grip = 0; grip < r->n[G]; grip++) {
    int point = r->point.index[grip], vertex = r->grip_vertex[grip];
    if (vertex >= 0)
      vertex = r->vertex.index[vertex];
    if (point < 0 && (vertex < 0 || !r->grip_is_primary[grip]))
      continue;
    if (point >= 0 && vertex < 0)
      return fail_record(r, "0g", &r->point, point, "belongs to no vertex");
    if (!r->grip_is_primary[grip])
      continue;
    size_t at = block_index(s, vertex, 0, 0);
    if (s->tsm.grip[at] >= 0)
      return fail_record(r, "v", &r->vertex, vertex, "has two primary control points");
    s->tsm.grip[at] = point;
  }
  for (int v = 0; v < s->n_vertices; v++)
    if (s->tsm.grip[block_index(s, v, 0, 0)] < 0)
      return fail_record(r, "v", &r->vertex, v, "has no control point");
  return 1;
}

/* Without a map control point i is that of vertex i. */
static int make_map(reader *r) {
  text_line line = {.number = 1};
  if (r->n_done[GVP] == 0 && r->n_placements == 0) {
    if (r->n[G] != r->n[V])
      return fail(r, &line, "without a map there must be one 0g record per v record");
    for (int k = 0; k < r->n[G]; k++) {
      r->grip_vertex[k] = k;
      r->grip_is_primary[k] = 1;
    }
    for (int k = 0; k < r->n[G]; k++)
      if (r->vertex.index[k] < 0 && r->point.index[k] < 0)
        r->grip_vertex[k] = -1;
    return 1;
  }
  if (r->n_done[GVP] != r->n[G])
    return fail(r, &line, "the map of control points is not as long as the list of 0g records");
  r->surface->tsm.has_map = 1;
  return 1;
}

static int place_points(reader *r) {
  if (!make_map(r) || !size_blocks(r) || !place_primary(r))
    return 0;
  for (int k = 0; k < r->n_placements; k++) {
    text_line line = r->placement[k];
    int vertex;
    if (!read_extra(r, &line, &vertex) || !read_wedges(r, &line, vertex))
      return 0;
  }
  for (int grip = 0; grip < r->n[G]; grip++)
    if (r->point.index[grip] >= 0 && !r->grip_is_primary[grip] && !r->grip_is_placed[grip])
      return fail_record(r, "0g", &r->point, r->point.index[grip], "stands in no cg record");
  return 1;
}

/* ---- the driver --------------------------------------------------------------------------------
 */

static tsolid_status read_surface(reader *r) {
  if (!count_records(r) || !allocate(r) || !read_records(r) || !renumber_all(r))
    return r->status;
  tsi_surface_lines lines = {
      .face = r->face.line, .edge = r->edge.line, .vertex = r->vertex.line, .link = r->link.line};
  tsolid_status status = tsi_surface_check(r->context, r->surface, &lines);
  if (!status && !place_points(r))
    status = r->status;
  if (!status)
    status = tsi_surface_basis(r->context, r->surface);
  if (!status)
    status = tsi_surface_finish(r->context, r->surface);
  return status;
}

tsolid_status tsolid_read_tsm(tsolid_context *context, const char *path, tsolid_surface **surface) {
  tsolid_status status = TSOLID_OK;
  char *text = NULL;
  size_t size = 0;
  reader r = {.context = context, .path = path};
  if (surface)
    *surface = NULL;
  if (!context || !path || !surface)
    return TSOLID_ERROR_ARGUMENT;
  r.scratch = tsi_arena_create(context);
  status = tsi_file_read(context, stage, path, max_file_size, &text, &size);
  if (status)
    goto done;
  r.text = text;
  r.text_end = text + size;
  r.surface = tsi_surface_new(context);
  status = r.surface ? read_surface(&r) : tsi_no_memory(context, stage);
  if (status)
    goto done;
  *surface = r.surface;
  r.surface = NULL;
done:
  tsi_arena_free(&r.scratch);
  tsi_delete(&context->allocator, text);
  tsolid_surface_free(r.surface);
  return status;
}
