/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The context: findings, progress, cancel; version and struct sizes for bindings. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef _OPENMP
#include <omp.h>
#endif

#include "internal.h"

enum { MAX_THREADS = 256, MAX_FINDINGS = 10000 };

const char *tsolid_version(void) {
  return TSOLID_VERSION;
}

int tsolid_abi(void) {
  return TSOLID_ABI;
}

size_t tsolid_struct_size(const char *name) {
#define ROW(type)                                                                                  \
  { #type, sizeof(type) }
  static const struct {
    const char *name;
    size_t size;
  } table[] = {
      ROW(tsolid_finding),
      ROW(tsolid_context_options),
      ROW(tsolid_surface_view),
      ROW(tsolid_tspline),
      ROW(tsolid_patch),
      ROW(tsolid_smooth_seam),
      ROW(tsolid_bezier_side),
      ROW(tsolid_bezier_boundary),
      ROW(tsolid_boundary_input),
      ROW(tsolid_boundary_options),
      ROW(tsolid_requirement),
      ROW(tsolid_preparation),
      ROW(tsolid_placement),
      ROW(tsolid_curve),
      ROW(tsolid_coons_options),
      ROW(tsolid_coons_report),
      ROW(tsolid_tmesh_options),
      ROW(tsolid_tmesh_view),
      ROW(tsolid_space_view),
      ROW(tsolid_solid_options),
      ROW(tsolid_certificate_options),
      ROW(tsolid_certificate),
      ROW(tsolid_quality),
      ROW(tsolid_basis_report),
      ROW(tsolid_continuity_report),
      ROW(tsolid_conformity_report),
      ROW(tsolid_statistics),
      ROW(tsolid_timing),
      ROW(tsolid_report),
      ROW(tsolid_report_options),
      ROW(tsolid_part),
      ROW(tsolid_assembly_input),
      ROW(tsolid_assembly_options),
      ROW(tsolid_interface),
      ROW(tsolid_clash),
      ROW(tsolid_part_facts),
      ROW(tsolid_free_face),
      ROW(tsolid_assembly_view),
      ROW(tsolid_region),
      ROW(tsolid_hex_options),
      ROW(tsolid_hex_part),
      ROW(tsolid_hex_view),
      ROW(tsolid_field),
      ROW(tsolid_bext_options),
      ROW(tsolid_bext_view),
      ROW(tsolid_material),
      ROW(tsolid_matrix_view),
  };
#undef ROW
  for (size_t i = 0; name && i < sizeof table / sizeof *table; i++)
    if (strcmp(name, table[i].name) == 0)
      return table[i].size;
  return 0;
}

static int resolve_threads(int asked) {
#ifdef _OPENMP
  int n = asked > 0 ? asked : omp_get_num_procs();
#else
  int n = 1;
  (void)asked;
#endif
  return n < 1 ? 1 : n > MAX_THREADS ? MAX_THREADS : n;
}

tsolid_status tsolid_context_create(const tsolid_context_options *options,
                                    tsolid_context **context) {
  static const tsolid_context_options defaults;
  if (!context)
    return TSOLID_ERROR_ARGUMENT;
  *context = NULL;
  if (!options)
    options = &defaults;
  if (!options->allocate != !options->release)
    return TSOLID_ERROR_ARGUMENT;
  tsi_allocator allocator = {options->allocate, options->release, options->allocator_data};
  tsolid_context *c = tsi_new(&allocator, 1, sizeof *c);
  if (!c)
    return TSOLID_ERROR_MEMORY;
  c->allocator = allocator;
  c->progress = options->progress;
  c->progress_data = options->progress_data;
  c->n_threads = resolve_threads(options->n_threads);
  *context = c;
  return TSOLID_OK;
}

void tsi_findings_truncate(tsolid_context *context, int n) {
  for (int i = n; i < context->n_findings; i++)
    tsi_delete(&context->allocator, (void *)(uintptr_t)context->finding[i].text);
  context->n_findings = n;
}

void tsolid_context_clear(tsolid_context *context) {
  if (context)
    tsi_findings_truncate(context, 0);
}

void tsolid_context_free(tsolid_context *context) {
  if (!context)
    return;
  tsolid_context_clear(context);
  tsi_allocator allocator = context->allocator;
  tsi_delete(&allocator, context->finding);
  tsi_delete(&allocator, context);
}

int tsolid_context_n_findings(const tsolid_context *context) {
  return context ? context->n_findings : 0;
}

const tsolid_finding *tsolid_context_finding(const tsolid_context *context, int i) {
  return context && i >= 0 && i < context->n_findings ? &context->finding[i] : NULL;
}

void tsolid_release(tsolid_context *context, void *memory) {
  if (context)
    tsi_delete(&context->allocator, memory);
}

static int reserve_finding(tsolid_context *context) {
  if (context->n_findings >= MAX_FINDINGS)
    return 0;
  if (context->n_findings < context->finding_capacity)
    return 1;
  int capacity = context->finding_capacity ? 2 * context->finding_capacity : 16;
  tsolid_finding *grown = tsi_new(&context->allocator, (size_t)capacity, sizeof *grown);
  if (!grown)
    return 0;
  if (context->n_findings)
    memcpy(grown, context->finding, (size_t)context->n_findings * sizeof *grown);
  tsi_delete(&context->allocator, context->finding);
  context->finding = grown;
  context->finding_capacity = capacity;
  return 1;
}

/* A finding that cannot be stored for lack of memory is dropped: the status still tells. */
static void add_finding(tsolid_context *context, const tsolid_finding *finding, const char *format,
                        va_list arguments) {
  char text[1024];
  vsnprintf(text, sizeof text, format, arguments);
  if (!reserve_finding(context))
    return;
  size_t length = strlen(text);
  char *copy = tsi_new(&context->allocator, length + 1, 1);
  if (!copy)
    return;
  memcpy(copy, text, length);
  tsolid_finding *slot = &context->finding[context->n_findings++];
  *slot = *finding;
  slot->text = copy;
}

tsolid_finding tsi_finding(tsolid_severity severity, tsolid_status status, const char *stage) {
  return (tsolid_finding){.severity = severity,
                          .status = status,
                          .stage = stage,
                          .measured = (double)NAN,
                          .allowed = (double)NAN};
}

tsolid_status tsi_fail(tsolid_context *context, tsolid_status status, const char *stage,
                       const char *format, ...) {
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, status, stage);
  va_list arguments;
  va_start(arguments, format);
  add_finding(context, &finding, format, arguments);
  va_end(arguments);
  return status;
}

tsolid_status tsi_report(tsolid_context *context, const tsolid_finding *finding, const char *format,
                         ...) {
  va_list arguments;
  va_start(arguments, format);
  add_finding(context, finding, format, arguments);
  va_end(arguments);
  return finding->status;
}

tsolid_status tsi_no_memory(tsolid_context *context, const char *stage) {
  return tsi_fail(context, TSOLID_ERROR_MEMORY, stage, "Out of memory");
}

tsolid_status tsi_progress(tsolid_context *context, const char *stage, double fraction) {
  if (context->progress && context->progress(context->progress_data, stage, fraction))
    return tsi_fail(context, TSOLID_ERROR_CANCELLED, stage, "Cancelled");
  return TSOLID_OK;
}
