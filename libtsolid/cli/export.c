/* SPDX-License-Identifier: LGPL-2.1-or-later
 * tsolid export: a solid in other programs' formats. */
#include <stdio.h>

#include "cli.h"

static const char help[] =
    "tsolid export IN.tsolid FORMAT FILE [FORMAT FILE ...] [options]\n"
    "\n"
    "  --vtu FILE         rational Bezier hexahedra for VTK and ParaView, with the block and the\n"
    "                     scaled Jacobian of every element\n"
    "  --field NAME=FILE  with it: a result, one or three coefficients per function of the solid,\n"
    "                     as a dense MatrixMarket table or a PETSc vector; any number of times\n"
    "  --tmesh FILE       a picture (SVG) of the T-mesh in parametric space: levels, layers,\n"
    "                     T-junctions\n"
    "  --inp FILE         conforming hexahedra for CalculiX and Abaqus, with node sets and "
    "surfaces\n"
    "                     x_low, x_high, y_low, ... for the six sides\n"
    "  --hex-vtu FILE     the same hexahedra for VTK and ParaView\n"
    "  --bext FILE        Bezier extraction for isogeometric codes (BEXT 2.0 text)\n"
    "  --lsdyna FILE      a deck of LS-DYNA that includes it; with --young, --poisson, --density\n"
    "  --extraction FILE  extraction operators as plain numbers (readers in resources/examples)\n"
    "  --matrices FOLDER  mass, Laplace and elasticity matrices, loads and Dirichlet sets of the\n"
    "                     faces; index.json there tells what is what and how it is numbered\n"
    "\n"
    "  --regions FILE     named parts of the boundary instead of the six sides, one a line:\n"
    "                     NAME SIDE S0 S1 T0 T1, with x_low ... z_high for SIDE\n"
    "  --force            also from a solid that is not proved valid; the file then says so\n"
    "\n"
    "Mesh options:\n"
    "  --size H           wanted edge length (default: a twentieth of the part's diagonal)\n"
    "  --order N          1 (default): 8 nodes per element, C3D8; 2: 20 nodes, C3D20\n"
    "  --divisions X,Y,Z,L  along the axes of the cube that the part is laid into, and through\n"
    "                     the layers; 0: from the size\n"
    "  --grading G        thickness of the outermost layer over the innermost (default 1)\n"
    "  --max-elements N   refuse to make more (default 2000000)\n"
    "\n"
    "Matrix options:\n"
    "  --young E, --poisson NU, --density RO  the material (NU: default 0, RO: 1)\n"
    "  --kinds LIST       of mass,laplace,elasticity (default: all; elasticity with --young only)\n"
    "  --format F         market (default), petsc or both\n";

enum {
  TARGET_VTU,
  TARGET_BEXT,
  TARGET_TMESH,
  TARGET_INP,
  TARGET_HEX_VTU,
  TARGET_EXTRACTION,
  TARGET_LSDYNA,
  N_TARGETS
};

typedef struct job {
  const char *input, *path[N_TARGETS], *divisions, *regions, *matrices, *kinds;
  tsolid_hex_options hex;
  cli_matrices matrix;
  double density;
  cli_fields fields;
  cli_target target[N_TARGETS];
  cli_folder folder;
  tsolid_context *context;
  tsolid_solid *solid;
} job;

/* "10,10,0,3"; 0 after saying what is wrong. */
static int parse_divisions(job *j) {
  int *n = j->hex.divisions, used = 0;
  if (!j->divisions)
    return 1;
  if (sscanf(j->divisions, "%9d,%9d,%9d,%9d%n", &n[0], &n[1], &n[2], &n[3], &used) == 4 &&
      !j->divisions[used] && n[0] >= 0 && n[1] >= 0 && n[2] >= 0 && n[3] >= 0)
    return 1;
  cli_error("--divisions takes four whole numbers such as 10,10,20,3, not '%s'", j->divisions);
  return 0;
}

static tsolid_status write_mesh(job *j) {
  tsolid_hex *hex = NULL;
  tsolid_hex_view view;
  tsolid_status status = tsolid_hex_create(j->context, j->solid, &j->hex, &hex);
  if (status == TSOLID_OK && j->path[TARGET_INP])
    status = tsolid_write_inp(j->context, hex, j->target[TARGET_INP].staged);
  if (status == TSOLID_OK && j->path[TARGET_HEX_VTU])
    status = tsolid_write_hex_vtu(j->context, hex, j->target[TARGET_HEX_VTU].staged);
  if (status == TSOLID_OK) {
    tsolid_hex_get(hex, &view);
    printf("Hexahedra     %d with %d nodes each, %d nodes; %d x %d x %d divisions, %d layers\n"
           "              smallest scaled Jacobian %.6g\n",
           view.n_elements, view.nodes_per_element, view.n_nodes, view.divisions[0],
           view.divisions[1], view.divisions[2], view.divisions[3], view.worst);
  }
  tsolid_hex_free(hex);
  return status;
}

/* Whether det J > 0 is proved; refuses if not, unless forced. */
static tsolid_status prove(job *j) {
  tsolid_certificate certificate;
  tsolid_status status = tsolid_certify(j->context, j->solid, NULL, &certificate, NULL);
  j->matrix.proved = certificate.verdict == TSOLID_POSITIVE;
  if (status || j->matrix.proved || j->hex.allow_unproved)
    return status;
  cli_error("The solid is not proved valid: det J > 0 is %s near (%g, %g, %g); --force writes it "
            "all the same",
            certificate.verdict == TSOLID_NOT_POSITIVE ? "false" : "undecided",
            certificate.point[0], certificate.point[1], certificate.point[2]);
  return TSOLID_ERROR_REFUSED;
}

static tsolid_status write_vtu(job *j) {
  tsolid_status status = cli_fields_read(&j->fields, j->context, j->solid);
  return status ? status
                : tsolid_write_vtu_fields(j->context, j->solid, j->fields.n, j->fields.field,
                                          j->target[TARGET_VTU].staged);
}

static tsolid_status write_bext(job *j) {
  tsolid_bext_options options = {.n_regions = j->matrix.regions.n,
                                 .regions = j->matrix.regions.region,
                                 .allow_unproved = j->hex.allow_unproved};
  return tsolid_write_bext_sets(j->context, j->solid, &options, j->target[TARGET_BEXT].staged);
}

static tsolid_status write_matrices(job *j) {
  if (!cli_folder_open(&j->folder, j->matrices))
    return TSOLID_ERROR_IO;
  return cli_matrices_write(&j->matrix, j->context, j->solid, &j->folder);
}

/* What is for analysis by the functions themselves: of a proved solid, unless forced. */
static tsolid_status write_splines(job *j) {
  if (!j->path[TARGET_BEXT] && !j->path[TARGET_EXTRACTION] && !j->matrices)
    return TSOLID_OK;
  tsolid_status status = prove(j);
  if (status == TSOLID_OK && j->path[TARGET_BEXT])
    status = write_bext(j);
  if (status == TSOLID_OK && j->path[TARGET_LSDYNA] &&
      !cli_lsdyna_write(j->target[TARGET_LSDYNA].staged, j->path[TARGET_BEXT], &j->matrix.material,
                        j->density, j->matrix.proved))
    status = TSOLID_ERROR_IO;
  if (status == TSOLID_OK && j->path[TARGET_EXTRACTION])
    status = tsolid_write_extraction(j->context, j->solid, j->target[TARGET_EXTRACTION].staged);
  return status == TSOLID_OK && j->matrices ? write_matrices(j) : status;
}

static tsolid_status write_all(job *j) {
  tsolid_status status = tsolid_read_tsolid(j->context, j->input, &j->solid);
  if (status == TSOLID_OK && j->path[TARGET_VTU])
    status = write_vtu(j);
  if (status == TSOLID_OK && j->path[TARGET_TMESH])
    status =
        tsolid_write_svg(j->context, tsolid_solid_space(j->solid), j->target[TARGET_TMESH].staged);
  if (status == TSOLID_OK && (j->path[TARGET_INP] || j->path[TARGET_HEX_VTU]))
    status = write_mesh(j);
  if (status == TSOLID_OK)
    status = write_splines(j);
  if (status == TSOLID_OK && cli_interrupted())
    status = TSOLID_ERROR_CANCELLED;
  if (status == TSOLID_OK && !cli_targets_commit(j->target, N_TARGETS))
    status = TSOLID_ERROR_IO;
  if (status == TSOLID_OK && j->matrices && !cli_folder_commit(&j->folder))
    status = TSOLID_ERROR_IO;
  cli_targets_discard(j->target, N_TARGETS);
  return status;
}

/* What can be said before the solid is read; 0 after an error. */
static int prepare(job *j) {
  int any = j->matrices != NULL;
  for (int k = 0; k < N_TARGETS; k++)
    any = any || j->path[k];
  if (!any) {
    cli_error("Where to? --vtu, --bext, --tmesh, --inp FILE or --matrices FOLDER is missing");
    return 0;
  }
  if (j->fields.n && !j->path[TARGET_VTU]) {
    cli_error("--field goes into a --vtu FILE, which is missing");
    return 0;
  }
  if (j->path[TARGET_LSDYNA] && !(j->path[TARGET_BEXT] && j->matrix.material.young > 0)) {
    cli_error("--lsdyna needs %s", j->path[TARGET_BEXT] ? "a material: --young E is missing"
                                                        : "the --bext FILE that it includes");
    return 0;
  }
  if (j->matrices && !cli_matrices_kinds(&j->matrix, j->kinds))
    return 0;
  if (!parse_divisions(j) || !cli_regions_read(&j->matrix.regions, j->regions))
    return 0;
  j->hex.n_regions = j->regions ? j->matrix.regions.n : 0;
  j->hex.regions = j->matrix.regions.region;
  return cli_targets_open(j->target, j->path, N_TARGETS, j->input);
}

int cli_export(int argc, char **argv) {
  static const char *const formats[] = {"market", "petsc", "both", NULL};
  job j = {.hex = {.order = 1}, .density = 1.0};
  const cli_option table[] = {
      {"--vtu", CLI_TEXT, &j.path[TARGET_VTU], 0, 0, NULL},
      {"--bext", CLI_TEXT, &j.path[TARGET_BEXT], 0, 0, NULL},
      {"--tmesh", CLI_TEXT, &j.path[TARGET_TMESH], 0, 0, NULL},
      {"--inp", CLI_TEXT, &j.path[TARGET_INP], 0, 0, NULL},
      {"--hex-vtu", CLI_TEXT, &j.path[TARGET_HEX_VTU], 0, 0, NULL},
      {"--extraction", CLI_TEXT, &j.path[TARGET_EXTRACTION], 0, 0, NULL},
      {"--lsdyna", CLI_TEXT, &j.path[TARGET_LSDYNA], 0, 0, NULL},
      {"--field", CLI_FIELD, &j.fields, 0, 0, NULL},
      {"--matrices", CLI_TEXT, &j.matrices, 0, 0, NULL},
      {"--regions", CLI_TEXT, &j.regions, 0, 0, NULL},
      {"--size", CLI_NUMBER, &j.hex.size, 0, 0, NULL},
      {"--order", CLI_COUNT, &j.hex.order, 1, 2, NULL},
      {"--divisions", CLI_TEXT, &j.divisions, 0, 0, NULL},
      {"--grading", CLI_NUMBER, &j.hex.grading, 0, 0, NULL},
      {"--max-elements", CLI_COUNT, &j.hex.max_elements, 1, 100000000, NULL},
      {"--young", CLI_NUMBER, &j.matrix.material.young, 0, 0, NULL},
      {"--poisson", CLI_REAL, &j.matrix.material.poisson, 0, 0, NULL},
      {"--density", CLI_NUMBER, &j.density, 0, 0, NULL},
      {"--kinds", CLI_TEXT, &j.kinds, 0, 0, NULL},
      {"--format", CLI_CHOICE, &j.matrix.format, 0, 0, formats},
      {"--force", CLI_FLAG, &j.hex.allow_unproved, 0, 0, NULL},
      {NULL, CLI_TEXT, NULL, 0, 0, NULL}};
  int code = cli_parse(argc, argv, help, table, &j.input);
  if (code >= 0)
    return code;
  j.context = prepare(&j) ? cli_open(0) : NULL;
  if (!j.context) {
    cli_regions_free(&j.matrix.regions);
    return CLI_FAILED;
  }
  tsolid_status status = write_all(&j);
  cli_folder_close(&j.folder);
  cli_fields_free(&j.fields, j.context);
  cli_regions_free(&j.matrix.regions);
  tsolid_solid_free(j.solid);
  return cli_close(j.context, status, CLI_PROVED);
}
