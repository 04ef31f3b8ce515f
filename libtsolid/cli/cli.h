/* SPDX-License-Identifier: LGPL-2.1-or-later
 * What the subcommands of `tsolid` share. They use the public library only. */
#ifndef TSOLID_CLI_H
#define TSOLID_CLI_H

#include <stdio.h>

#include "tsolid.h"

/* Exit codes; after a signal 128 + its number. */
enum { CLI_PROVED = 0, CLI_FAILED = 1, CLI_NOT_PROVED = 2 };

/* ---- subcommands: argv[0] is the subcommand's name ---------------------------------------------
 */

int cli_check(int argc, char **argv);
int cli_build(int argc, char **argv);
int cli_report(int argc, char **argv);
int cli_export(int argc, char **argv);
int cli_convert(int argc, char **argv);
int cli_assembly(int argc, char **argv);

/* ---- options -----------------------------------------------------------------------------------
 */

typedef enum cli_kind {
  CLI_TEXT,
  CLI_COUNT,
  CLI_NUMBER, /* positive */
  CLI_REAL,   /* any */
  CLI_CHOICE,
  CLI_FLAG,
  CLI_FIELD /* to a cli_fields, as often as it is given */
} cli_kind;

typedef struct cli_option {
  const char *name; /* "--threads"; NULL ends a table */
  cli_kind kind;
  void *value;               /* const char *, int, double, double, int, int (1: given), ... */
  int low, high;             /* of a count */
  const char *const *choice; /* names, NULL ends them; the value is the index */
} cli_option;

/* Reads options and the one file name (cli_parse_two: two of them). Returns -1 to go on, else the
 * exit code: help was asked for and printed, or the arguments were wrong and that was said. */
int cli_parse(int argc, char **argv, const char *help, const cli_option *options,
              const char **file);
int cli_parse_two(int argc, char **argv, const char *help, const cli_option *options,
                  const char *file[2]);
/* One file or more; `file` has room for all of them. */
int cli_parse_many(int argc, char **argv, const char *help, const cli_option *options, int room,
                   const char **file, int *n_files);

/* ---- a session: context, progress, signals -----------------------------------------------------
 */

/* Catches SIGINT and SIGTERM from now on. NULL: no memory, and that was said. */
tsolid_context *cli_open(int n_threads);
/* Prints the findings, frees the context and returns the exit code: `code` unless a signal came
 * before the end or status tells of a failure. */
int cli_close(tsolid_context *context, tsolid_status status, int code);
int cli_interrupted(void);
/* "error: ..." on stderr; returns CLI_FAILED. */
int cli_error(const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 1, 2)))
#endif
    ;
double cli_seconds(void); /* a monotonic clock */
double cli_peak_memory_mib(void);

/* ---- input files -------------------------------------------------------------------------------
 */

/* A boundary from .tsb (file), .tsm or .iga (surface), told apart by their content. */
typedef struct cli_input {
  tsolid_boundary_file *file;
  tsolid_surface *surface;
  tsolid_boundary_input boundary; /* points into one of the two */
} cli_input;

/* To be freed in any case. */
tsolid_status cli_input_read(tsolid_context *context, const char *path, cli_input *input);
void cli_input_free(cli_input *input);
void cli_print_surface(const tsolid_surface *surface); /* nothing for NULL */

/* ---- output files: all of them or none ---------------------------------------------------------
 */

enum { CLI_PATH_SIZE = 4096 + 64 };

typedef struct cli_target {
  const char *path; /* as given; NULL: not asked for */
  char target[CLI_PATH_SIZE], staged[CLI_PATH_SIZE];
} cli_target;

/* Looks whether the files can be written before hours are spent on their content, and chooses
 * `staged`, the names to write under. None may be the file `input`, none another one. path[k] NULL:
 * not asked for. Returns 0 after an error. */
int cli_targets_open(cli_target *target, const char *const *path, int n, const char *input);
/* Renames all staged files to their targets, or removes them. Returns 0 after an error. */
int cli_targets_commit(cli_target *target, int n);
void cli_targets_discard(cli_target *target, int n);

/* ---- output folders: all of their files or none ------------------------------------------------
 */

enum { CLI_NAME_SIZE = 128 };

typedef struct cli_folder {
  const char *path;           /* as given */
  char staged[CLI_PATH_SIZE]; /* a folder beside it */
  char file[CLI_PATH_SIZE];
  char (*name)[CLI_NAME_SIZE];
  int n, capacity;
} cli_folder;

/* Makes the staged folder; the one asked for may be there, other files in it stay. Returns 0 after
 * an error. To be closed in any case. */
int cli_folder_open(cli_folder *folder, const char *path);
/* The path to write the file `name` under, until the next call; NULL after an error. */
const char *cli_folder_file(cli_folder *folder, const char *name);
/* The whole of an open file as `name`; 0 after an error. */
int cli_folder_copy(cli_folder *folder, const char *name, FILE *from);
/* Moves all files, in the order they were named. Returns 0 after an error. */
int cli_folder_commit(cli_folder *folder);
/* Removes what was not moved. */
void cli_folder_close(cli_folder *folder);

/* ---- parts of the boundary with names ----------------------------------------------------------
 */

typedef struct cli_regions {
  int n;
  tsolid_region *region;
} cli_regions;

/* From a file, or the six sides for NULL; 0 after an error. To be freed in any case. */
int cli_regions_read(cli_regions *regions, const char *path);
void cli_regions_free(cli_regions *regions);

/* ---- matrices ----------------------------------------------------------------------------------
 */

typedef struct cli_matrices {
  int kinds;  /* bits 1 << tsolid_matrix_kind */
  int format; /* 0: MatrixMarket, 1: PETSc, 2: both */
  tsolid_material material;
  cli_regions regions;
  int proved; /* goes into the index */
} cli_matrices;

/* Sets kinds from "mass,laplace" or, for NULL, from what there is a material for; 0 after an error.
 */
int cli_matrices_kinds(cli_matrices *job, const char *text);
tsolid_status cli_matrices_write(const cli_matrices *job, tsolid_context *context,
                                 const tsolid_solid *solid, cli_folder *folder);

/* 0 after an error. `bext` is the file the deck includes, from the same folder. */
int cli_lsdyna_write(const char *path, const char *bext, const tsolid_material *material,
                     double density, int proved);

/* ---- fields ------------------------------------------------------------------------------------
 */

enum { CLI_MAX_FIELDS = 64 };

typedef struct cli_fields { /* all zero: none */
  int n;
  const char *given[CLI_MAX_FIELDS]; /* "NAME=FILE" */
  char *name[CLI_MAX_FIELDS];
  double *value[CLI_MAX_FIELDS];
  tsolid_field field[CLI_MAX_FIELDS];
} cli_fields;

int cli_fields_add(cli_fields *fields, const char *text); /* 0 after an error */
tsolid_status cli_fields_read(cli_fields *fields, tsolid_context *context,
                              const tsolid_solid *solid);
void cli_fields_free(cli_fields *fields, tsolid_context *context);

/* ---- a mesh of an assembly
 * ---------------------------------------------------------------------- */

/* Files `inp` and `vtu`, or NULL; `part` as the assembly was made of, solid[k] of part[k]. */
tsolid_status cli_mesh_assembly(tsolid_context *context, const tsolid_assembly *assembly, int n,
                                const tsolid_part *part, const tsolid_solid *const *solid,
                                const tsolid_hex_options *options, const char *inp,
                                const char *vtu);

/* ---- facts -------------------------------------------------------------------------------------
 */

void cli_print_requirement(const tsolid_requirement *requirement);
void cli_print_preparation(const tsolid_preparation *preparation);
void cli_print_report(const tsolid_report *report);
int cli_verdict_code(const tsolid_certificate *certificate);
/* The report as JSON into a file that is written as it is named; "-" is stdout. Returns 0 after an
 * error. */
int cli_write_json(tsolid_context *context, const tsolid_report *report, const char *path);
int cli_write_text(const char *text, const char *path); /* the same for a text */
void cli_print_assembly(const tsolid_assembly_view *view);

#endif
