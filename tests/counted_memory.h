/* SPDX-License-Identifier: LGPL-2.1-or-later
 * An allocator that counts the bytes that live, has a limit and fails on demand. */
#ifndef TSOLID_TEST_COUNTED_MEMORY_H
#define TSOLID_TEST_COUNTED_MEMORY_H

#include <stddef.h>
#include <stdlib.h>

#include "check.h"
#include "tsolid.h"

typedef struct meter {
  size_t live, peak, limit;
  long countdown; /* allocations until one fails; < 0: none does */
} meter;

typedef union meter_header {
  size_t size;
  max_align_t align;
} meter_header;

static inline void *count_new(void *data, size_t size) {
  meter *m = data;
  if ((m->countdown >= 0 && m->countdown-- == 0) || size > m->limit - m->live)
    return NULL;
  meter_header *memory = malloc(sizeof *memory + size);
  if (!memory)
    return NULL;
  memory->size = size;
  m->live += size;
  m->peak = m->live > m->peak ? m->live : m->peak;
  return memory + 1;
}

static inline void count_delete(void *data, void *memory) {
  meter_header *h = (meter_header *)memory - 1;
  ((meter *)data)->live -= h->size;
  free(h);
}

/* A context of one thread whose memory the meter counts. */
static inline tsolid_context *new_counted_context(meter *m) {
  tsolid_context *context = NULL;
  tsolid_context_options options = {
      .allocate = count_new, .release = count_delete, .allocator_data = m, .n_threads = 1};
  CHECK(tsolid_context_create(&options, &context) == TSOLID_OK);
  return context;
}

#endif
