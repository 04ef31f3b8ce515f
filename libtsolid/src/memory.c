/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Allocation through the context's allocator, with overflow checks, and arenas for temporaries. */
#include <stdlib.h>

#include "internal.h"

typedef struct tsi_arena_block {
  struct tsi_arena_block *previous;
  max_align_t data[];
} tsi_arena_block;

void *tsi_new(const tsi_allocator *allocator, size_t n, size_t size) {
  if (size != 0 && n > (SIZE_MAX / 2) / size)
    return NULL;
  size_t bytes = n * size;
  if (bytes == 0)
    bytes = 1;
  if (!allocator->allocate)
    return calloc(bytes, 1);
  void *memory = allocator->allocate(allocator->data, bytes);
  if (memory)
    memset(memory, 0, bytes);
  return memory;
}

void tsi_delete(const tsi_allocator *allocator, void *memory) {
  if (!memory)
    return;
  if (allocator->release)
    allocator->release(allocator->data, memory);
  else
    free(memory);
}

tsi_arena tsi_arena_create(tsolid_context *context) {
  return (tsi_arena){.allocator = &context->allocator, .last = NULL};
}

void *tsi_arena_new(tsi_arena *arena, size_t n, size_t size) {
  if (size != 0 && n > (SIZE_MAX / 4) / size)
    return NULL;
  tsi_arena_block *block = tsi_new(arena->allocator, 1, sizeof *block + n * size);
  if (!block)
    return NULL;
  block->previous = arena->last;
  arena->last = block;
  return block->data;
}

void tsi_arena_free(tsi_arena *arena) {
  while (arena->last) {
    tsi_arena_block *previous = arena->last->previous;
    tsi_delete(arena->allocator, arena->last);
    arena->last = previous;
  }
}
