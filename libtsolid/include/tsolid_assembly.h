/* SPDX-License-Identifier: LGPL-2.1-or-later
 *
 * tsolid.h, continued: several parts, and what they share. Included by tsolid.h.
 */
#ifndef TSOLID_ASSEMBLY_H
#define TSOLID_ASSEMBLY_H

#include "tsolid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- assemblies --------------------------------------------------------------------------------
 */

/* A part in its place. Parts that give the same `boundary` are copies of one: its geometry is made
 * ready once, for all of them. */
typedef struct tsolid_part {
  const char *name; /* NULL: "part k" */
  const tsolid_boundary_input *boundary;
  const double *placement; /* rows of a 3 x 4 matrix, a rotation and a shift; NULL: the identity */
} tsolid_part;

typedef struct tsolid_assembly_input {
  int n_parts;
  const tsolid_part *parts;
} tsolid_assembly_input;

typedef struct tsolid_assembly_options { /* all zero = default */
  double tolerance;                      /* B-rep tolerance, absolute; 0: 1e-7 */
  double gap; /* contacts are sought this far; 0: a hundredth of the smaller part's diagonal */
} tsolid_assembly_options;

typedef enum tsolid_contact {
  TSOLID_CONTACT_EXACT = 0,  /* the same functions and control points up to orientation, and one
                                factor on all weights */
  TSOLID_CONTACT_GEOMETRIC,  /* the same after exact refinement (degrees, knots) of both */
  TSOLID_CONTACT_PARTIAL,    /* the same on a rectangle of one or both, after that */
  TSOLID_CONTACT_COINCIDENT, /* the same points within the tolerance, but no rectangle of both, or
                                other parameters: nothing that refinement could make one */
  TSOLID_CONTACT_NEAR        /* apart by more than the tolerance, less than the gap */
} tsolid_contact;

/* Two patches that touch, or nearly. The contact's own (s,t) in [0,1]^2 are, with (p,q) in [0,1]^2
 * the patch's own parameters over its range, p = box[k][0] + s (box[k][1] - box[k][0]), q =
 * box[k][2] + t (box[k][3] - box[k][2]) for patch k = 0; for k = 1 after code: bit 2: exchange s
 * and t, then bit 0: s = 1 - s, bit 1: t = 1 - t, then where moebius[1] is not 1 the parameter x
 * stands for c x/(c x + 1 - x). Exact, geometric and partial contacts are compared control point by
 * control point: proved up to `deviation`. The others are sampled on a grid, and the largest and
 * the smallest gap refined from the best samples. */
typedef struct tsolid_interface {
  tsolid_contact kind;
  int part[2], patch[2];
  int same_side; /* the normals agree: the parts overlap there */
  int code;
  double box[2][4];
  double moebius[2];
  double deviation;         /* largest distance of control points; NaN: not compared */
  double gap, smallest_gap; /* largest and smallest distance before the construction */
  double depth;             /* largest distance that one lies inside the other */
  double point[3];          /* where the gap is largest */
  double area;
  int same_functions; /* after the construction: 1: both solids have the same functions, knots
                         and control points there; 0: they have not; -1: not known */
  int same_bits;      /* ... and the control points agree bit for bit */
  double gap_after;   /* largest distance of both solids' own values; NaN: not known */
  double ulp_after;   /* the same in units of the last place of the coordinates */
  int continuity[2];  /* after the construction: to which order the functions of either patch are
                         continuous across the contact's borders inside it (its surface stays as
                         smooth as it was); -1: no border inside, or not known */
} tsolid_interface;

typedef enum tsolid_clash_kind {
  TSOLID_CLASH_OVERLAP = 0, /* the parts share volume */
  TSOLID_CLASH_INSIDE,      /* part[0] lies inside part[1] */
  TSOLID_CLASH_TWICE,       /* the same part twice in the same place */
  TSOLID_CLASH_SELF         /* part[0] touches itself */
} tsolid_clash_kind;

/* A clash that is reported is there: its point is inside both parts, at least `depth` from the
 * surface. That there is no other is sampled only: a clash smaller than a sixteenth of a patch,
 * away from all its borders, may be missed. */
typedef struct tsolid_clash {
  tsolid_clash_kind kind;
  int part[2], patch[2]; /* patch: where it was seen, or -1 */
  double depth, point[3];
} tsolid_clash;

typedef enum tsolid_assembly_verdict {
  TSOLID_ASSEMBLY_WATERTIGHT = 0, /* all contacts are exact, geometric or partial */
  TSOLID_ASSEMBLY_GAPS,           /* some are coincident or near */
  TSOLID_ASSEMBLY_CLASHES,
  TSOLID_ASSEMBLY_INCOMPLETE /* a part could not be read, or has no solid */
} tsolid_assembly_verdict;

typedef struct tsolid_part_facts {
  const char *name;
  tsolid_status status; /* TSOLID_OK: it could be read */
  int n_patches, n_free, n_interfaces;
  int copy_of; /* the first part with the same input: itself, if none */
  int closed;  /* every border is shared by two patches */
  double volume, area;
} tsolid_part_facts;

/* A patch that is free, or what of it is. */
typedef struct tsolid_free_face {
  int part, patch;
  double area, fraction;
} tsolid_free_face;

typedef struct tsolid_assembly_view {
  int n_parts, n_patches;
  const tsolid_part_facts *part;
  int n_interfaces;
  const tsolid_interface *interface;
  int n_clashes;
  const tsolid_clash *clash;
  int n_free;
  const tsolid_free_face *free_face;
  int n_of_kind[5];     /* contacts by kind */
  int n_groups;         /* of parts that hang together by exact, geometric and partial contacts */
  double gap;           /* largest of all contacts */
  double volume;        /* sum of the parts' */
  double volume_inside; /* flux through the free faces alone */
  tsolid_assembly_verdict verdict;
} tsolid_assembly_view;

typedef struct tsolid_assembly tsolid_assembly;

/* Finds all contacts and clashes. A part that cannot be read is named in a finding and left out.
 * TSOLID_ERROR_INPUT for placements that are no rotation and shift (mirrored, scaled). */
TSOLID_API tsolid_status tsolid_assembly_create(tsolid_context *context,
                                                const tsolid_assembly_input *input,
                                                const tsolid_assembly_options *options,
                                                tsolid_assembly **assembly);
TSOLID_API void tsolid_assembly_free(tsolid_assembly *assembly);
TSOLID_API void tsolid_assembly_get(const tsolid_assembly *assembly, tsolid_assembly_view *view);
/* The boundary of a part to give to tsolid_boundary_create, made ready so that both sides of every
 * exact, geometric and partial contact end up with the same functions and, in one frame, the same
 * control points: degrees raised, knots inserted (both exact), weights scaled by constants, control
 * points moved by no more than the tolerance. Valid as long as the handle. NULL: as it was given
 * (parts with T-spline or Bezier patches, copies: their prototype's). */
TSOLID_API const tsolid_boundary_input *
tsolid_assembly_boundary_input(const tsolid_assembly *assembly, int part);
/* The same assembly after the construction: solid[k] of part k, made of its input as above; copies
 * have their prototype's (the same pointer), parts that could not be done NULL. Every common
 * contact gets a record: one stored net of control points, weights and knots that both sides refer
 * to. Fills same_functions, same_bits, gap_after, ulp_after. */
TSOLID_API tsolid_status tsolid_assembly_join(tsolid_context *context,
                                              const tsolid_assembly *assembly, int n_parts,
                                              const tsolid_solid *const *solid,
                                              tsolid_assembly **joined);
/* A contact's point by its record: (p,q) in [0,1]^2 of the patch of one side (0, 1), as in
 * tsolid_interface. In one frame both sides get the same bits at the same point of the record.
 * TSOLID_ERROR_ARGUMENT where there is no record or (p,q) is outside of the contact. */
TSOLID_API tsolid_status tsolid_assembly_evaluate(tsolid_context *context,
                                                  const tsolid_assembly *assembly, int interface,
                                                  int side, double p, double q, double point[3]);
/* The assembly's report as one JSON document (resources/assembly.schema.json), to be freed by
 * tsolid_release. */
TSOLID_API tsolid_status tsolid_assembly_json(tsolid_context *context,
                                              const tsolid_assembly *assembly, char **json);

#ifdef __cplusplus
}
#endif
#endif
