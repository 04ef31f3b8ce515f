/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Assemblies: several boundaries, the contacts between them, and what both sides share.
 *
 *     parts -> skins (patches in their places, seams, outward normals)
 *           -> contacts (exact, geometric, partial; coincident, near) -> clashes -> totals
 *           -> common spaces: inputs for the boundary stage that agree on every exact contact
 *           -> after the construction: one stored net per contact, checked on both solids
 *
 * Everything is seen in world coordinates but the common spaces, which belong to a part's own
 * frame: parts that are given the same input are copies of one and are refined once. */
#ifndef TSI_ASSEMBLY_H
#define TSI_ASSEMBLY_H

#include "patch.h"
#include "vector.h"

/* A patch of a part in its place. T-splines and Bezier elements are written as one NURBS patch with
 * knots of full multiplicity at all lines of elements: the same surface. */
typedef struct tsi_skin {
  int part, number; /* of the part's input */
  int refinable;    /* given as NURBS patch */
  tsi_patch patch;
  tsi_patch own;       /* the same in the part's own frame */
  tsolid_patch source; /* names and tolerances of the input, copied */
  int n_grid[2];       /* points on the surface, at least 2 x 2, */
  double *at[2];       /* at these parameters: */
  double (*grid)[3];   /* (i, j) at i + n_grid[0] * j; triangles between them */
  double bend;         /* largest distance from the triangles to the surface, measured at middles */
  double box[6];       /* lo, hi of the control points */
  double size;         /* diagonal of the box */
  double corner[4][3]; /* (u,v) = 00, 10, 11, 01 */
  double tolerance;
  int outward;       /* 1: x_u x x_v points out of the part, -1: into it, 0: not known */
  double mean[3];    /* of the grid's normals, unit length, outward as they are, */
  double cone;       /* and the largest angle to it, with a margin; pi: not known */
  int mate[4];       /* seam: 4 * skin + border on the other side, or -1 */
  double area, flux; /* flux of (x - origin)/3, outward */
  const char *name;
} tsi_skin;

typedef struct tsi_member { /* a part */
  const char *name;
  tsolid_status status; /* of reading it; not TSOLID_OK: it has no skins */
  int first, end;       /* skins */
  int prototype;        /* the first part with the same input */
  int n_patches;
  double placement[12]; /* rows of a 3 x 4 matrix */
  int placed;           /* not the identity */
  double box[6], size, bend;
  int closed;          /* every border has its seam */
  struct tsi_bvh *bvh; /* of the triangles, in turned coordinates */
  int *triangle;       /* 3 turned points each */
  double (*turned)[3];
  int n_triangles;
  int n_smooth;
  tsolid_smooth_seam *smooth;
} tsi_member;

/* A contact of two skins, first[0] < ... as found; `view` is what the header shows. */
typedef struct tsi_contact {
  int skin[2];
  double middle[3], deepest[3]; /* half way between both, where nearest, where deepest */
  tsolid_interface view;
} tsi_contact;

/* The common net of a contact, in the contact's orientation. */
typedef struct tsi_record {
  tsi_patch net[2]; /* n[0] = 0: none; the second for contacts of different frames */
} tsi_record;

struct tsolid_assembly {
  tsi_allocator allocator;
  tsi_arena arena;       /* everything below, but for the trees */
  double tolerance, gap; /* gap 0: from the parts */
  double origin[3], scale;
  int n_parts, n_skins;
  tsi_member *part;
  tsi_skin *skin;
  struct tsi_bvh *bvh; /* over the skins' boxes */
  int n_contacts, contact_capacity;
  tsi_contact *contact;
  tsi_record *record;
  tsolid_assembly_view view;
  tsolid_boundary_input *prepared; /* per part; patches NULL: as given */
};

/* ---- assembly.c: small questions ---------------------------------------------------------------
 */

/* In one frame: both parts of a contact are their own prototypes and placed alike. */
int tsi_share_frame(const tsolid_assembly *assembly, const tsolid_interface *view);
/* Exact, geometric or partial, from opposite sides. */
int tsi_is_watertight(const tsolid_interface *view);
/* Within the box widened by the margin. */
int tsi_in_box(const double box[6], const double x[3], double margin);
/* x by the rows of a 3 x 4 matrix. */
void tsi_place_point(const double placement[12], double x[3]);

/* ---- assembly_skin.c --------------------------------------------------------------------------
 */

/* Reads all parts; a part that cannot be read keeps its status and has no skins. */
tsolid_status tsi_assembly_read(tsolid_context *context, tsolid_assembly *assembly,
                                const tsolid_assembly_input *input);
void tsi_skin_point(const tsi_skin *skin, double u, double v, double x[3]);
/* Unit normal, outward where that is known; 0: it vanishes there. */
int tsi_skin_normal(const tsi_skin *skin, double u, double v, double x[3], double normal[3]);

/* The angle between the normals' cones of two skins, as lines (0 .. pi/2); 0: they may be parallel
 * somewhere. */
double tsi_skin_angle(const tsi_skin *a, const tsi_skin *b);

/* ---- assembly_foot.c: point inversion ----------------------------------------------------------
 */

typedef struct tsi_foot {
  double uv[2], point[3], distance;
} tsi_foot;

/* A nearest point of the patch to x: from the nearest points of the grid (near == NULL) or from
 * near[2], by Gauss-Newton steps within the borders. A local minimum of the distance. */
void tsi_foot_find(const tsi_skin *skin, const double x[3], const double *near, tsi_foot *foot);

/* ---- assembly_inside.c
 * ---------------------------------------------------------------------------
 */

tsolid_status tsi_inside_create(tsolid_context *context, tsolid_assembly *assembly, int part);
/* 1: inside, 0: outside, by the parity of two or three rays through the part's triangles: right
 * where the point is farther from the surface than the triangles are. */
int tsi_inside(const tsi_member *part, const double x[3]);

/* ---- assembly_seams.c
 * ----------------------------------------------------------------------------
 */

/* Seams of every part by its borders' ends and middles, and the normals' sides. */
tsolid_status tsi_assembly_orient(tsolid_context *context, tsolid_assembly *assembly);

/* ---- assembly_match.c, assembly_gap.c: two skins -----------------------------------------------
 */

enum { TSI_MOST_RECTANGLES = 16 }; /* in which two patches touch */

/* Exact, geometric and partial contacts: fills contact[0 .. *n_found - 1], at most as many as
 * above. */
tsolid_status tsi_match_skins(tsolid_context *context, const tsolid_assembly *assembly, int a,
                              int b, tsi_contact *contact, int *n_found);
/* Coincident and near contacts by distances. */
void tsi_measure_gap(const tsolid_assembly *assembly, int a, int b, double reach,
                     tsi_contact *contact, int *found);
/* Part [p0,p1] x [q0,q1] of a patch as a patch on [0,1]^2. 0: no memory. */
int tsi_patch_restrict(tsi_arena *arena, const tsi_patch *from, const double box[4],
                       tsi_patch *patch);
/* Orientation code, bit 0: p reversed, bit 1: q reversed, bit 2: then exchanged. */
int tsi_patch_turn(tsi_arena *arena, const tsi_patch *from, int code, tsi_patch *patch);
/* (s,t) of the contact to the normalised (u,v) of one side. */
void tsi_contact_map(const tsolid_interface *contact, int side, double s, double t, double uv[2]);

/* ---- assembly_clash.c, assembly_totals.c --------------------------------------------------------
 */

tsolid_status tsi_assembly_find_clashes(tsolid_context *context, tsolid_assembly *assembly);
tsolid_status tsi_assembly_total(tsolid_context *context, tsolid_assembly *assembly);

/* ---- assembly_spaces.c, assembly_join.c ---------------------------------------------------------
 */

/* Fills assembly->prepared. */
tsolid_status tsi_assembly_prepare(tsolid_context *context, tsolid_assembly *assembly);

/* A rectangle of a side that is one of another part's: direction k of the contact (s, t) runs along
 * axis[i][k] of part[i], from from[i][k] to to[i][k], in step on both. */
typedef struct tsi_bond {
  int part[2], side[2], axis[2][2];
  double from[2][2], to[2][2];
} tsi_bond;

/* The rectangles of a contact on two solids: more than one where patches were cut, none where that
 * is not known. The list is the arena's. */
tsolid_status tsi_contact_bonds(tsolid_context *context, tsi_arena *arena,
                                const tsolid_assembly *assembly, int contact,
                                const tsolid_solid *const *solid, int *n, tsi_bond **bond);

#endif
