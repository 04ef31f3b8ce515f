/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The conformity report: everything measured anew from the solid alone. */
#ifdef _OPENMP
#include <omp.h>
#else
#include <time.h>
#endif

#include "conform.h"
#include "tmesh.h"

static const char *const STAGE = "report";

static double seconds_now(void) {
#ifdef _OPENMP
  return omp_get_wtime();
#else
  return (double)clock() / CLOCKS_PER_SEC;
#endif
}

/* Table 1 of Zhang, Wang, Hughes (2012). */
static tsolid_statistics count_statistics(const tsolid_space *space) {
  const tsolid_tmesh *tmesh = space->tmesh;
  tsolid_statistics count = {.input_nodes = space->n_surface,
                             .tmesh_nodes = tmesh->n_nodes,
                             .interior_extraordinary_nodes = tmesh->n_extraordinary,
                             .partial_extraordinary_nodes = tmesh->n_partial_extraordinary,
                             .core_cells = tmesh->n_boxes,
                             .n_functions = space->n_inner + 2 * space->n_surface,
                             .n_inner = space->n_inner,
                             .bezier_elements = space->n_elements};
  tsi_box_levels(tmesh, count.core_cells_of_level);
  count.analysis_suitable = !(tmesh->flags & TSI_TMESH_CLOSURE_OFF);
  count.tmesh_cells = tmesh->n_cells;
  count.tmesh_cells_before_closure = tmesh->n_cells_before_closure;
  for (int side = 0; side < 6; side++)
    count.input_elements += space->boundary->side[side].n_elements;
  return count;
}

static tsolid_timing no_timing(void) {
  double nan = (double)NAN;
  return (tsolid_timing){.boundary = nan,
                         .tmesh = nan,
                         .space = nan,
                         .start = nan,
                         .optimise = nan,
                         .certify = nan,
                         .report = nan,
                         .total = nan,
                         .peak_memory_mib = nan};
}

/* The parts that look at interior faces. */
static tsolid_status measure_faces(tsolid_context *context, const tsolid_solid *solid,
                                   const tsolid_report_options *options, tsolid_report *report) {
  tsi_arena arena = tsi_arena_create(context);
  int n_faces, limit = options ? options->max_rank_functions : 0;
  tsi_face *face;
  tsolid_status status = tsi_faces_create(context, solid->space, &arena, &n_faces, &face);
  if (status == TSOLID_OK)
    status = tsi_progress(context, STAGE, 0.3);
  if (status == TSOLID_OK)
    status = tsi_basis_measure(context, solid->space, n_faces, face, limit, &report->basis);
  if (status == TSOLID_OK)
    status = tsi_progress(context, STAGE, 0.5);
  if (status == TSOLID_OK)
    status = tsi_continuity_measure(context, solid, n_faces, face, NULL, NULL, &report->continuity);
  tsi_arena_free(&arena);
  return status;
}

static tsolid_status measure_all(tsolid_context *context, const tsolid_solid *solid,
                                 const tsolid_report_options *options, tsolid_report *report) {
  const tsolid_space *space = solid->space;
  report->requirement = space->boundary->requirement;
  report->preparation = space->boundary->preparation;
  report->statistics = count_statistics(space);
  tsolid_status status = tsi_conformity_measure(context, solid, &report->conformity);
  if (status == TSOLID_OK)
    status = tsi_progress(context, STAGE, 0.2);
  if (status == TSOLID_OK)
    status = measure_faces(context, solid, options, report);
  if (status == TSOLID_OK)
    status = tsi_progress(context, STAGE, 0.6);
  double before = seconds_now();
  if (status == TSOLID_OK)
    status = tsolid_certify(context, solid, NULL, &report->certificate, NULL);
  report->timing.certify = seconds_now() - before;
  if (status == TSOLID_OK)
    status = tsi_progress(context, STAGE, 0.8);
  if (status == TSOLID_OK)
    status = tsolid_quality_measure(context, solid, &report->quality);
  return status == TSOLID_OK ? tsi_progress(context, STAGE, 1.0) : status;
}

tsolid_status tsolid_report_measure(tsolid_context *context, const tsolid_solid *solid,
                                    const tsolid_report_options *options, tsolid_report *report) {
  if (!context)
    return TSOLID_ERROR_ARGUMENT;
  if (!solid || !report)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, STAGE, "No solid, or no report to fill");
  double before = seconds_now();
  tsolid_report measured = {.timing = no_timing()};
  tsolid_status status = measure_all(context, solid, options, &measured);
  if (status != TSOLID_OK)
    return status;
  measured.timing.report = seconds_now() - before;
  *report = measured;
  return TSOLID_OK;
}
