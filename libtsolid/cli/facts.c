/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The report for people: the verdict first, then one paragraph of facts per part of the report. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli.h"

static void print_title(const char *title) {
  printf("%-14s", title);
}

static double largest(const double *value, int n) {
  double most = 0;
  for (int k = 0; k < n; k++)
    most = fmax(most, fabs(value[k]));
  return most;
}

static void print_point(const double point[3]) {
  printf("(%.6g, %.6g, %.6g)", point[0], point[1], point[2]);
}

int cli_verdict_code(const tsolid_certificate *certificate) {
  return certificate->verdict == TSOLID_POSITIVE ? CLI_PROVED : CLI_NOT_PROVED;
}

static void print_verdict(const tsolid_certificate *c) {
  print_title("Verdict");
  switch (c->verdict) {
  case TSOLID_POSITIVE:
    printf("valid: det J > 0 is proved on all %d Bezier elements\n", c->n_elements);
    break;
  case TSOLID_NOT_POSITIVE:
    printf("NOT VALID: det J <= 0 at ");
    print_point(c->point);
    printf(" in Bezier element %d\n", c->element);
    break;
  case TSOLID_UNDECIDED:
    printf("NOT PROVED: undecided on %d of %d Bezier elements, near ", c->n_undecided,
           c->n_elements);
    print_point(c->point);
    printf("\n");
    break;
  }
  for (int k = 0; k < c->n_singular && k < 8; k++) {
    print_title("");
    printf("but for the corner ");
    print_point(c->singular[k]);
    printf(", where the input itself is singular\n");
  }
}

void cli_print_requirement(const tsolid_requirement *r) {
  print_title("Requirement");
  printf("%s: %s, %s, ", r->satisfied ? "satisfied" : "NOT SATISFIED",
         r->closed ? "closed" : "not closed", r->connected ? "connected" : "not connected");
  printf(r->genus < 0 ? "genus not known\n" : "genus %d\n", r->genus);
  if (r->n_patches > 0) {
    print_title("");
    printf("%d patches, %d edges, %d vertices, %d of them extraordinary\n", r->n_patches,
           r->n_edges, r->n_vertices, r->n_extraordinary);
  }
  if (r->satisfied && r->corner_name[0][0]) {
    print_title("");
    printf("corners");
    for (int k = 0; k < 8; k++)
      printf("%s %s", k ? "," : "", r->corner_name[k][0] ? r->corner_name[k] : "(no name)");
    printf("\n");
  }
  if (!r->satisfied) {
    print_title("");
    printf("%d violation%s\n", r->n_violations, r->n_violations == 1 ? "" : "s");
  }
}

void cli_print_preparation(const tsolid_preparation *p) {
  double snap = fmax(largest(p->snap, 12), largest(p->snap_inside, 6)), factor = 1;
  for (int k = 0; k < 6; k++)
    if (fabs(log(p->weight_factor[k])) > fabs(log(factor)))
      factor = p->weight_factor[k];
  print_title("Preparation");
  if (snap > 0)
    printf("borders snapped by up to %.3g\n", snap);
  else
    printf("exact: no control point was moved\n");
  print_title("");
  printf("%d knots inserted, %d degrees raised, %d knots merged within %.3g of their range\n",
         p->n_knots_inserted, p->n_degrees_raised, p->n_knots_merged, p->knot_merge);
  if (factor > 1 || factor < 1) {
    print_title("");
    printf("weights multiplied by up to %.3g, on %d patches by a bilinear function: exact\n",
           factor, p->n_bilinear_factors);
  }
  if (p->n_moebius > 0) {
    print_title("");
    printf("parameters changed projectively in %d patch directions: exact\n", p->n_moebius);
  }
  if (p->n_cut_patches > 0) {
    print_title("");
    printf("%d patches cut along %d isolines at vertices of neighbours: exact, C^0 there\n",
           p->n_cut_patches, p->n_cuts);
  }
  if (p->refine_knots > 0 || p->raise_degree > 0) {
    print_title("");
    printf("refined as asked for: spans halved %d times, degrees raised by %d\n", p->refine_knots,
           p->raise_degree);
  }
}

static void print_statistics(const tsolid_statistics *s) {
  print_title("Statistics");
  printf("input: %d control points, %d Bezier elements\n", s->input_nodes, s->input_elements);
  print_title("");
  printf("T-mesh: %d nodes, %d interior extraordinary, %d partial extraordinary\n", s->tmesh_nodes,
         s->interior_extraordinary_nodes, s->partial_extraordinary_nodes);
  print_title("");
  printf("core: %d cells; by level", s->core_cells);
  for (int k = 0; k < 24; k++)
    if (s->core_cells_of_level[k])
      printf(" %d: %d", k, s->core_cells_of_level[k]);
  printf("\n");
  print_title("");
  if (s->analysis_suitable)
    printf("analysis-suitable: the closure added %d cells to %d\n",
           s->tmesh_cells - s->tmesh_cells_before_closure, s->tmesh_cells_before_closure);
  else
    printf("not closed: a rational T-spline, its functions need not sum to 1\n");
  print_title("");
  printf("solid: %d functions (%d inner), %d Bezier elements\n", s->n_functions, s->n_inner,
         s->bezier_elements);
}

static void print_certificate(const tsolid_certificate *c) {
  print_title("Certificate");
  printf("%d positive, %d not positive, %d undecided; deepest subdivision %d\n", c->n_positive,
         c->n_not_positive, c->n_undecided, c->depth);
  print_title("");
  printf("smallest proved bound %.6g of the product of mean edge lengths\n", c->smallest_bound);
}

static void print_quality(const tsolid_quality *q) {
  print_title("Quality");
  printf("scaled Jacobian: worst %.6g at ", q->worst);
  print_point(q->worst_point);
  printf("\n");
  print_title("");
  printf("mean %.6g, best %.6g", q->mean, q->best);
  if (!isnan(q->start_worst))
    printf("; worst of the start %.6g", q->start_worst);
  printf("\n");
  print_title("");
  printf("ratio %.4g to the input's own bound %.6g at ", q->ratio, q->bound);
  print_point(q->bound_point);
  printf("\n");
}

static void print_basis(const tsolid_basis_report *b) {
  print_title("Basis");
  printf("sum one within %.3g (of which the input's own: %.3g), smallest coefficient %.3g\n",
         b->sum_defect, b->input_sum_defect, b->smallest_value);
  print_title("");
  if (b->rank_measured)
    printf("smallest eigenvalues: inner %.3g (round-off %.3g), surface %.3g (round-off %.3g)\n",
           b->inner_eigenvalue, b->inner_roundoff, b->surface_eigenvalue, b->surface_roundoff);
  else
    printf("ranks not measured: too many functions\n");
  print_title("");
  printf("largest jumps: diagonals %.3g, core surface %.3g\n", b->diagonal_jump, b->core_jump);
}

static void print_continuity(const tsolid_continuity_report *c) {
  print_title("Continuity");
  printf("areas: C^-1 %.6g, C^0 %.6g, C^1 %.6g, C^2 or more %.6g\n", c->area[0], c->area[1],
         c->area[2], c->area[3]);
  print_title("");
  printf("%d of %d interior faces below the expected order\n", c->n_below_expected, c->n_faces);
}

static void print_conformity(const tsolid_conformity_report *c) {
  print_title("Conformity");
  printf("distance to the boundary %.3g at %d points (scale %.6g)\n", c->distance, c->n_samples,
         c->scale);
  print_title("");
  printf("boundary control points %s\n",
         c->control_identical ? "identical, bit for bit" : "NOT identical");
  print_title("Volume");
  printf("%.15g by quadrature, %.15g by flux, relative difference %.3g\n", c->volume, c->flux,
         fabs(c->volume - c->flux) / fabs(c->flux));
}

static void print_timing(const tsolid_timing *t) {
  const struct {
    const char *name;
    double seconds;
  } stage[] = {{"boundary", t->boundary}, {"T-mesh", t->tmesh},      {"space", t->space},
               {"start", t->start},       {"optimise", t->optimise}, {"certify", t->certify},
               {"report", t->report},     {"total", t->total}};
  const char *separator = "";
  print_title("Timing");
  for (size_t k = 0; k < sizeof stage / sizeof *stage; k++) {
    if (isnan(stage[k].seconds))
      continue;
    printf("%s%s %.3f s", separator, stage[k].name, stage[k].seconds);
    separator = ", ";
  }
  if (!isnan(t->peak_memory_mib))
    printf("%speak memory %.0f MiB", separator, t->peak_memory_mib);
  printf("\n");
}

void cli_print_report(const tsolid_report *report) {
  print_verdict(&report->certificate);
  cli_print_requirement(&report->requirement);
  cli_print_preparation(&report->preparation);
  print_statistics(&report->statistics);
  print_certificate(&report->certificate);
  print_quality(&report->quality);
  print_basis(&report->basis);
  print_continuity(&report->continuity);
  print_conformity(&report->conformity);
  print_timing(&report->timing);
}

int cli_write_text(const char *text, const char *path) {
  int to_stdout = strcmp(path, "-") == 0;
  FILE *file = to_stdout ? stdout : fopen(path, "wx");
  int written = file && fprintf(file, "%s\n", text) >= 0 && fflush(file) == 0;
  if (file && !to_stdout && fclose(file) != 0)
    written = 0;
  if (!written)
    cli_error("Cannot write the report");
  return written;
}

int cli_write_json(tsolid_context *context, const tsolid_report *report, const char *path) {
  char *json = NULL;
  if (tsolid_report_json(context, report, &json) != TSOLID_OK)
    return 0; /* its finding tells */
  int written = cli_write_text(json, path);
  tsolid_release(context, json);
  return written;
}
