/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Writes a T-spline surface as .tsm, with the record numbers that it was read with: reading the
 * file again gives the same surface, bit for bit. */
#include "file_io.h"
#include "surface.h"

static const char stage[] = "write";

/* A record's first word; before it bare words for the deleted numbers since the last record. */
static void begin(tsi_output *out, const char *word, int *n_written, int record) {
  for (; *n_written < record; ++*n_written) {
    tsi_output_text(out, word);
    tsi_output_text(out, "\n");
  }
  tsi_output_text(out, word);
  ++*n_written;
}

static void end(tsi_output *out, const char *word, int n_written, int n_records) {
  for (; n_written < n_records; n_written++) {
    tsi_output_text(out, word);
    tsi_output_text(out, "\n");
  }
}

static void add_integer(tsi_output *out, int value) {
  tsi_output_text(out, " ");
  tsi_output_integer(out, value);
}

static void add_number(tsi_output *out, double value) {
  tsi_output_text(out, " ");
  tsi_output_number(out, value);
}

static int record_or_none(const int *record, int index) {
  return index < 0 ? -1 : record[index];
}

static void write_mesh(tsi_output *out, const tsolid_surface *s) {
  static const char *const compass[] = {" EAST\n", " NORTH\n", " WEST\n", " SOUTH\n"};
  const tsi_tsm *t = &s->tsm;
  int n = 0;
  for (int i = 0; i < s->n_faces; i++) {
    begin(out, "f", &n, s->face_record[i]);
    add_integer(out, t->link_record[s->face_link[i]]);
    tsi_output_text(out, " 0\n");
  }
  end(out, "f", n, t->n_face_records);
  n = 0;
  for (int i = 0; i < s->n_edges; i++) {
    begin(out, "e", &n, t->edge_record[i]);
    add_integer(out, t->link_record[s->edge_link[i]]);
    add_number(out, s->interval[i]);
    tsi_output_text(out, "\n");
  }
  end(out, "e", n, t->n_edge_records);
  n = 0;
  for (int i = 0; i < s->n_vertices; i++) {
    begin(out, "v", &n, s->vertex_record[i]);
    add_integer(out, t->link_record[s->vertex_link[i]]);
    tsi_output_text(out, compass[t->compass[i]]);
  }
  end(out, "v", n, t->n_vertex_records);
  n = 0;
  for (int i = 0; i < s->n_links; i++) {
    const tsi_link *l = &s->link[i];
    begin(out, "l", &n, t->link_record[i]);
    add_integer(out, t->link_record[l->prev]);
    add_integer(out, t->link_record[l->next]);
    add_integer(out, t->link_record[l->opposite]);
    add_integer(out, s->vertex_record[l->vertex]);
    add_integer(out, record_or_none(s->face_record, l->face));
    add_integer(out, t->edge_record[l->edge]);
    add_integer(out, t->link_flag[i]);
    tsi_output_text(out, "\n");
  }
  end(out, "l", n, t->n_link_records);
  for (int i = 0; i < s->n_edges; i++)
    if (t->condition[i] >= 0) {
      tsi_output_text(out, "ec");
      add_integer(out, t->edge_record[i]);
      add_integer(out, t->condition[i]);
      tsi_output_text(out, "\n");
    }
}

/* owner[p]: the vertex of point p, or -1 - vertex of a further one. */
static void find_owners(const tsolid_surface *s, int *owner) {
  for (int v = 0; v < s->n_vertices; v++) {
    const int *extra = s->tsm.extra[v];
    size_t first = s->tsm.grip_start[v], width = (size_t)(1 + extra[TSI_EAST] + extra[TSI_WEST]);
    size_t primary = first + (size_t)extra[TSI_WEST] + width * (size_t)extra[TSI_SOUTH];
    for (size_t k = first; k < s->tsm.grip_start[v + 1]; k++)
      if (s->tsm.grip[k] >= 0)
        owner[s->tsm.grip[k]] = k == primary ? v : -1 - v;
  }
}

static void write_placement(tsi_output *out, const tsolid_surface *s, int v) {
  static const int direction[4] = {TSI_NORTH, TSI_WEST, TSI_SOUTH, TSI_EAST};
  static const int east[4] = {1, 0, -1, 0}, north[4] = {0, 1, 0, -1};
  const int *extra = s->tsm.extra[v];
  int width = 1 + extra[TSI_EAST] + extra[TSI_WEST];
  const int *primary =
      s->tsm.grip + s->tsm.grip_start[v] + extra[TSI_WEST] + width * extra[TSI_SOUTH];
  if (s->tsm.grip_start[v + 1] - s->tsm.grip_start[v] == 1)
    return;
  tsi_output_text(out, "0m cg");
  add_integer(out, s->vertex_record[v]);
  tsi_output_text(out, " 4");
  for (int k = 0; k < 4; k++)
    add_integer(out, extra[direction[k]]);
  for (int k = 0; k < 4; k++) {
    int a = direction[k], b = direction[(k + 1) % 4];
    for (int n = 1; n <= extra[a]; n++)
      for (int m = 0; m <= extra[b]; m++) {
        int point = primary[n * east[a] + m * east[b] + width * (n * north[a] + m * north[b])];
        add_integer(out, record_or_none(s->tsm.point_record, point));
      }
  }
  tsi_output_text(out, "\n");
}

static void write_points(tsi_output *out, const tsolid_surface *s, const int *owner) {
  const tsi_tsm *t = &s->tsm;
  int n = 0;
  if (t->has_map) {
    tsi_output_text(out, "0m odd-grip-map\n");
    for (int p = 0; p < s->n_points; p++) {
      for (; n < t->point_record[p]; n++)
        tsi_output_text(out, "0m gv -1\n");
      tsi_output_text(out, owner[p] >= 0 ? "0m gvp" : "0m gv");
      add_integer(out, s->vertex_record[owner[p] >= 0 ? owner[p] : -1 - owner[p]]);
      tsi_output_text(out, "\n");
      n++;
    }
    for (; n < t->n_point_records; n++)
      tsi_output_text(out, "0m gv -1\n");
    for (int v = 0; v < s->n_vertices; v++)
      write_placement(out, s, v);
  }
  n = 0;
  for (int p = 0; p < s->n_points; p++) {
    begin(out, "0g", &n, t->point_record[p]);
    for (size_t d = 0; d < 4; d++)
      add_number(out, t->xyzw[4 * (size_t)p + d]);
    tsi_output_text(out, "\n");
  }
  end(out, "0g", n, t->n_point_records);
}

tsolid_status tsolid_write_tsm(tsolid_context *context, const tsolid_surface *surface,
                               const char *path) {
  tsi_output out;
  if (!context || !surface || !path)
    return TSOLID_ERROR_ARGUMENT;
  if (!surface->tsm.present)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                    "The surface did not come from .tsm: it has no knot intervals to write");
  int *owner = tsi_new(&context->allocator, (size_t)surface->n_points, sizeof *owner);
  if (!owner)
    return tsi_no_memory(context, stage);
  find_owners(surface, owner);
  tsolid_status status = tsi_output_open(&out, context, stage, path);
  if (!status) {
    tsi_output_text(&out, "#TS0200\n\n");
    tsi_output_text(&out, surface->tsm.head);
    write_mesh(&out, surface);
    write_points(&out, surface, owner);
    tsi_output_text(&out, surface->tsm.tail);
  }
  status = tsi_output_close(&out, status);
  tsi_delete(&context->allocator, owner);
  return status;
}
