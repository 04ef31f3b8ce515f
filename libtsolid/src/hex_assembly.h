/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The steps from an assembly to one mesh, private to the stage:
 *
 *     bonds (assembly_join.c) -> lines of all parts -> a mesh per part -> nodes shared */
#ifndef TSI_HEX_ASSEMBLY_H
#define TSI_HEX_ASSEMBLY_H

#include "assembly.h"
#include "hex.h"

typedef struct tsi_hex_member {
  const char *name;
  const tsolid_solid *solid;
  tsolid_hex_options options; /* size > 0; divisions and regions of the part */
  tsi_hex_lines lines;
} tsi_hex_member;

/* Lines of all parts that agree on all bonds. */
tsolid_status tsi_hex_assembly_lines(tsolid_context *context, tsi_arena *arena, int n_parts,
                                     tsi_hex_member *member, int n_bonds, const tsi_bond *bond);

/* hex_assembly_divide.c. Intervals that are to be divided alike: a class. */
typedef struct tsi_hex_classes {
  int n_axes;            /* 3 * part + axis */
  int *interval_start;   /* n_axes + 1 */
  int *of;               /* class of an interval */
  unsigned char *turned; /* the interval runs against its class */
  int n_classes;
  unsigned char *mirrored; /* the class is glued to itself the other way round */
  double *length;          /* the longest of its intervals' longest lines */
  double *pieces;          /* wanted; then taken */
} tsi_hex_classes;

/* Divisions of all classes from what is wanted and what parts are told to have. */
tsolid_status tsi_hex_divide(tsolid_context *context, tsi_arena *arena,
                             const tsi_hex_member *member, tsi_hex_classes *classes);

#endif
