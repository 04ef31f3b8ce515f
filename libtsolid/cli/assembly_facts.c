/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The report of an assembly for people: the verdict, then tables. */
#include <math.h>
#include <stdio.h>

#include "cli.h"

static const char *const kind_name[] = {"exact", "geometric", "partial", "coincident", "near"};

static void print_verdict(const tsolid_assembly_view *v) {
  printf("Verdict       ");
  switch (v->verdict) {
  case TSOLID_ASSEMBLY_WATERTIGHT:
    printf(v->n_interfaces ? "watertight: every contact is exact\n"
                           : "no parts touch: nothing leaks, nothing holds\n");
    break;
  case TSOLID_ASSEMBLY_GAPS:
    printf("NOT WATERTIGHT: gaps of up to %.6g\n", v->gap);
    break;
  case TSOLID_ASSEMBLY_CLASHES:
    printf("CLASHES: %d\n", v->n_clashes);
    break;
  case TSOLID_ASSEMBLY_INCOMPLETE:
    printf("INCOMPLETE: not all parts could be done\n");
    break;
  }
}

static void print_interface(const tsolid_assembly_view *v, const tsolid_interface *s) {
  printf("  %-10s  %s %d - %s %d", kind_name[s->kind], v->part[s->part[0]].name, s->patch[0],
         v->part[s->part[1]].name, s->patch[1]);
  if (s->same_side)
    printf(", normals agree");
  if (s->kind >= TSOLID_CONTACT_COINCIDENT)
    printf(", gap %.6g to %.6g", s->smallest_gap, s->gap);
  else
    printf(", apart %.3g", s->deviation);
  if (s->depth > 0.0)
    printf(", %.6g inside", s->depth);
  if (s->same_functions >= 0)
    printf(s->same_functions ? ", same functions" : ", other functions");
  if (s->same_bits == 1)
    printf(" bit for bit");
  for (int side = 0; side < 2; side++)
    if (s->continuity[side] >= 0)
      printf(", C^%d at its border in %s", s->continuity[side], v->part[s->part[side]].name);
  if (!isnan(s->gap_after))
    printf(", after %.3g (%.0f ulp)", s->gap_after, s->ulp_after);
  printf("\n");
}

static void print_clash(const tsolid_assembly_view *v, const tsolid_clash *c) {
  static const char *const text[] = {"overlaps", "lies inside", "is the same as", "touches"};
  printf("  %s %s %s", v->part[c->part[0]].name, text[c->kind],
         c->kind == TSOLID_CLASH_SELF ? "itself" : v->part[c->part[1]].name);
  if (c->depth > 0.0)
    printf(", by %.6g near (%.6g, %.6g, %.6g)", c->depth, c->point[0], c->point[1], c->point[2]);
  printf("\n");
}

void cli_print_assembly(const tsolid_assembly_view *v) {
  print_verdict(v);
  printf("Parts         %d with %d faces, in %d group%s\n", v->n_parts, v->n_patches, v->n_groups,
         v->n_groups == 1 ? "" : "s");
  printf("Contacts      %d", v->n_interfaces);
  for (int k = 0; k < 5; k++)
    if (v->n_of_kind[k])
      printf(", %d %s", v->n_of_kind[k], kind_name[k]);
  printf("\n");
  for (int k = 0; k < v->n_interfaces; k++)
    print_interface(v, &v->interface[k]);
  printf("Clashes       %d\n", v->n_clashes);
  for (int k = 0; k < v->n_clashes; k++)
    print_clash(v, &v->clash[k]);
  printf("Free faces    %d\n", v->n_free);
  printf(
      "Volume        %.15g of the parts, %.15g within the free faces, relative difference %.3g\n",
      v->volume, v->volume_inside, fabs(v->volume - v->volume_inside) / fabs(v->volume));
}
