/* SPDX-License-Identifier: LGPL-2.1-or-later
 * tsolid export --matrices: the discrete problem as files in a folder, with an index (index.json)
 * that says what is in which and how it is numbered. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static const char *const kind_name[] = {"mass", "laplace", "elasticity"};
static const char *const ending[] = {".mtx", ".petsc"};

enum { N_KINDS = 3, MARKET = 0, PETSC = 1 };

/* What the index says of the numbering; the same words as in the manual. */
static const char *const numbering[] = {
    "Functions are counted from 0: inner functions, then one layer below the boundary, then the "
    "boundary layer, n_surface functions each in the last two. Only the boundary layer is not zero "
    "on the boundary, and there it is the part's own functions.",
    "A scalar solution is the sum of c_A R_A, R_A = w_A N_A / sum of w_B N_B.",
    "Row 3 A + i of the elasticity matrix belongs to component i (x, y, z) of function A.",
    "MatrixMarket files count from 1 and hold the lower triangle; PETSc files count from 0 and "
    "hold all entries.",
    "control.mtx: a row x, y, z, w per function, the Euclidean control point and its weight. "
    "points.petsc: x, y, z of function 0, of function 1, ...; these are also the coefficients of "
    "the functions x, y and z on the solid.",
    "load: the integral of every function over the face; times a traction it is a right-hand side.",
    "functions: those that do not vanish on the face, counted from 0, a Dirichlet set; the .petsc "
    "file is an IS.",
};

typedef struct writer {
  const cli_matrices *job;
  tsolid_context *context;
  const tsolid_solid *solid;
  cli_folder *folder;
  FILE *index;
  int n_functions, n_inner, n_surface;
} writer;

/* The file NAME.mtx or NAME.petsc in the folder; NULL after an error. */
static const char *file_for(const writer *w, const char *name, int format) {
  char text[2 * CLI_NAME_SIZE];
  snprintf(text, sizeof text, "%s%s", name, ending[format]);
  return cli_folder_file(w->folder, text);
}

static int wanted(const writer *w, int format) {
  return w->job->format == 2 || w->job->format == format;
}

static void put_files(const writer *w, const char *name) {
  const char *between = "";
  fprintf(w->index, "[");
  for (int format = MARKET; format <= PETSC; format++)
    if (wanted(w, format)) {
      fprintf(w->index, "%s\"%s%s\"", between, name, ending[format]);
      between = ", ";
    }
  fprintf(w->index, "]");
}

static tsolid_status write_vector(const writer *w, const char *name, int n, const double *value) {
  tsolid_status status = TSOLID_OK;
  for (int format = MARKET; format <= PETSC && !status; format++) {
    if (!wanted(w, format))
      continue;
    const char *path = file_for(w, name, format);
    if (!path)
      return TSOLID_ERROR_IO;
    status = format == MARKET ? tsolid_write_vector_market(w->context, n, value, path)
                              : tsolid_write_vector_petsc(w->context, n, value, path);
  }
  return status;
}

/* ---- matrices ----------------------------------------------------------------------------------
 */

static tsolid_status write_matrix(const writer *w, int kind) {
  tsolid_matrix *matrix = NULL;
  tsolid_status status =
      tsolid_matrix_create(w->context, w->solid, (tsolid_matrix_kind)kind,
                           kind == TSOLID_ELASTICITY ? &w->job->material : NULL, &matrix);
  for (int format = MARKET; format <= PETSC && !status; format++) {
    if (!wanted(w, format))
      continue;
    const char *path = file_for(w, kind_name[kind], format);
    if (!path)
      status = TSOLID_ERROR_IO;
    else
      status = format == MARKET ? tsolid_write_matrix_market(w->context, matrix, path)
                                : tsolid_write_petsc(w->context, matrix, path);
  }
  if (!status) {
    tsolid_matrix_view view;
    tsolid_matrix_get(matrix, &view);
    fprintf(w->index, "\n    \"%s\": {\"rows\": %d, \"entries\": %zu, \"files\": ", kind_name[kind],
            view.n_rows, view.row_start[view.n_rows]);
    put_files(w, kind_name[kind]);
    fprintf(w->index, "}");
  }
  tsolid_matrix_free(matrix);
  return status;
}

static tsolid_status write_matrices(const writer *w) {
  tsolid_status status = TSOLID_OK;
  const char *between = "";
  fprintf(w->index, "  \"matrices\": {");
  for (int kind = 0; kind < N_KINDS && !status; kind++)
    if (w->job->kinds & 1 << kind) {
      fprintf(w->index, "%s", between);
      status = write_matrix(w, kind);
      between = ",";
    }
  fprintf(w->index, "\n  },\n");
  if (w->job->kinds & 1 << TSOLID_ELASTICITY)
    fprintf(w->index, "  \"material\": {\"young\": %.17g, \"poisson\": %.17g},\n",
            w->job->material.young, w->job->material.poisson);
  return status;
}

static tsolid_status write_control(const writer *w) {
  const double *h = tsolid_solid_control(w->solid);
  size_t n = (size_t)w->n_functions;
  double *rows = malloc(4 * n * sizeof *rows);
  if (!rows)
    return TSOLID_ERROR_MEMORY;
  tsolid_status status = TSOLID_OK;
  for (size_t k = 0; k < 4 * n; k++)
    rows[k] = k % 4 == 3 ? h[k] : h[k] / h[k | 3];
  if (wanted(w, MARKET)) {
    const char *path = file_for(w, "control", MARKET);
    status = path ? tsolid_write_table_market(w->context, w->n_functions, 4, rows, path)
                  : TSOLID_ERROR_IO;
    fprintf(w->index, "  \"control\": \"control.mtx\",\n");
  }
  if (!status && wanted(w, PETSC)) {
    for (size_t k = 0; k < 3 * n; k++)
      rows[k] = rows[k / 3 * 4 + k % 3];
    const char *path = file_for(w, "points", PETSC);
    status = path ? tsolid_write_vector_petsc(w->context, 3 * w->n_functions, rows, path)
                  : TSOLID_ERROR_IO;
    fprintf(w->index, "  \"points\": \"points.petsc\",\n");
  }
  free(rows);
  return status;
}

/* ---- faces -------------------------------------------------------------------------------------
 */

/* Room for all functions: loads of a piece and of the face; 1 where a function is in the set. */
typedef struct scratch {
  double *piece, *load;
  int *function, *in_set;
} scratch;

/* Adds a piece of a face: its loads, and the functions that do not vanish on it. */
static tsolid_status add_piece(const writer *w, const tsolid_region *region, scratch *s) {
  int n = 0;
  tsolid_status status = tsolid_face_load(w->context, w->solid, region, s->piece);
  if (!status)
    status = tsolid_face_functions(w->context, w->solid, region, w->n_surface, &n, s->function);
  for (int k = 0; k < w->n_functions && !status; k++)
    s->load[k] += s->piece[k];
  for (int k = 0; k < n; k++)
    s->in_set[s->function[k]] = 1;
  return status;
}

static tsolid_status write_load(const writer *w, const char *name, const double *load) {
  double area = 0.0;
  for (int k = 0; k < w->n_functions; k++)
    area += load[k];
  fprintf(w->index, "],\n     \"area\": %.17g, \"load\": ", area);
  put_files(w, name);
  return write_vector(w, name, w->n_functions, load);
}

static tsolid_status write_set(const writer *w, const char *name, scratch *s) {
  int n = 0;
  tsolid_status status = TSOLID_OK;
  for (int k = w->n_functions - w->n_surface; k < w->n_functions; k++)
    if (s->in_set[k])
      s->function[n++] = k;
  if (wanted(w, PETSC)) {
    const char *path = file_for(w, name, PETSC);
    status = path ? tsolid_write_set_petsc(w->context, n, s->function, path) : TSOLID_ERROR_IO;
    fprintf(w->index, ",\n     \"functions_file\": \"%s%s\"", name, ending[PETSC]);
  }
  fprintf(w->index, ",\n     \"functions\": [");
  for (int k = 0; k < n; k++)
    fprintf(w->index, "%s%d", k ? ", " : "", s->function[k]);
  fprintf(w->index, "]}");
  return status;
}

/* The face that region `first` is the first piece of. */
static tsolid_status write_face(const writer *w, int first, scratch *s) {
  const tsolid_region *region = w->job->regions.region;
  tsolid_status status = TSOLID_OK;
  char name[CLI_NAME_SIZE];
  memset(s->load, 0, (size_t)w->n_functions * sizeof *s->load);
  memset(s->in_set, 0, (size_t)w->n_functions * sizeof *s->in_set);
  fprintf(w->index, "%s\n    {\"name\": \"%s\", \"pieces\": [", first ? "," : "",
          region[first].name);
  for (int k = first; k < w->job->regions.n && !status; k++) {
    const double *box = region[k].box;
    if (strcmp(region[k].name, region[first].name) != 0)
      continue;
    status = add_piece(w, &region[k], s);
    fprintf(w->index, "%s{\"side\": %d, \"box\": [%.17g, %.17g, %.17g, %.17g]}",
            k > first ? ", " : "", region[k].side, box[0], box[1], box[2], box[3]);
  }
  snprintf(name, sizeof name, "load_%.*s", CLI_NAME_SIZE / 2, region[first].name);
  if (!status)
    status = write_load(w, name, s->load);
  snprintf(name, sizeof name, "functions_%.*s", CLI_NAME_SIZE / 2, region[first].name);
  return status ? status : write_set(w, name, s);
}

static int is_first(const cli_regions *regions, int k) {
  for (int m = 0; m < k; m++)
    if (strcmp(regions->region[m].name, regions->region[k].name) == 0)
      return 0;
  return 1;
}

static tsolid_status write_faces(const writer *w) {
  size_t n = (size_t)w->n_functions;
  scratch s = {malloc(n * sizeof *s.piece), malloc(n * sizeof *s.load),
               malloc(n * sizeof *s.function), malloc(n * sizeof *s.in_set)};
  tsolid_status status =
      s.piece && s.load && s.function && s.in_set ? TSOLID_OK : TSOLID_ERROR_MEMORY;
  fprintf(w->index, "  \"faces\": [");
  for (int k = 0; k < w->job->regions.n && !status; k++)
    if (is_first(&w->job->regions, k))
      status = write_face(w, k, &s);
  fprintf(w->index, "\n  ]\n");
  free(s.piece);
  free(s.load);
  free(s.function);
  free(s.in_set);
  return status;
}

/* ---- the whole ---------------------------------------------------------------------------------
 */

static void write_numbering(const writer *w) {
  int n = (int)(sizeof numbering / sizeof *numbering);
  fprintf(w->index,
          "{\n  \"format\": \"tsolid matrices\", \"version\": 1,\n"
          "  \"proved\": %s,\n"
          "  \"n_functions\": %d, \"n_inner\": %d, \"n_surface\": %d,\n  \"numbering\": [",
          w->job->proved ? "true" : "false", w->n_functions, w->n_inner, w->n_surface);
  for (int k = 0; k < n; k++)
    fprintf(w->index, "%s\n    \"%s\"", k ? "," : "", numbering[k]);
  fprintf(w->index, "\n  ],\n");
}

/* The index is named last, so that it is moved last: where it is, all is. */
tsolid_status cli_matrices_write(const cli_matrices *job, tsolid_context *context,
                                 const tsolid_solid *solid, cli_folder *folder) {
  tsolid_space_view view;
  tsolid_space_get(tsolid_solid_space(solid), &view);
  writer w = {.job = job,
              .context = context,
              .solid = solid,
              .folder = folder,
              .n_functions = view.n_functions,
              .n_inner = view.n_inner,
              .n_surface = view.n_surface};
  w.index = tmpfile();
  if (!w.index) {
    cli_error("Cannot write a temporary file");
    return TSOLID_ERROR_IO;
  }
  write_numbering(&w);
  tsolid_status status = write_matrices(&w);
  if (!status)
    status = write_control(&w);
  if (!status)
    status = write_faces(&w);
  fprintf(w.index, "}\n");
  if (status == TSOLID_ERROR_MEMORY)
    cli_error("Out of memory");
  if (!status && !cli_folder_copy(folder, "index.json", w.index))
    status = TSOLID_ERROR_IO;
  fclose(w.index);
  return status;
}

int cli_matrices_kinds(cli_matrices *job, const char *text) {
  job->kinds = job->material.young > 0 ? 7 : 3;
  if (text)
    job->kinds = 0;
  while (text && *text) {
    size_t n = strcspn(text, ",");
    int kind = 0;
    while (kind < N_KINDS && (strlen(kind_name[kind]) != n || strncmp(text, kind_name[kind], n)))
      kind++;
    if (kind == N_KINDS) {
      cli_error("--kinds takes mass, laplace and elasticity with commas between, not '%s'", text);
      return 0;
    }
    job->kinds |= 1 << kind;
    text += n + (text[n] == ',');
  }
  if (job->kinds & 1 << TSOLID_ELASTICITY && !(job->material.young > 0)) {
    cli_error("The elasticity matrix needs a material: --young E, and --poisson NU unless it is 0");
    return 0;
  }
  return 1;
}
