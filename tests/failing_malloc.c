/* SPDX-License-Identifier: LGPL-2.1-or-later
 *
 * Preloaded before a program: allocation number TSOLID_FAIL_AT (1, 2, ...; counted over malloc,
 * calloc, realloc, aligned_alloc and posix_memalign of the whole process, third-party libraries
 * included) fails, and so do all later ones when TSOLID_FAIL_ON is set. At the end the number of
 * allocations is written into the file TSOLID_FAIL_COUNT. Without TSOLID_FAIL_AT nothing fails. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void *(*real_malloc)(size_t);
static void *(*real_calloc)(size_t, size_t);
static void *(*real_realloc)(void *, size_t);
static void *(*real_aligned)(size_t, size_t);
static int (*real_memalign)(void **, size_t, size_t);
static void (*real_free)(void *);
static atomic_long n_allocations;
static long fail_at;
static int fail_on, started;

/* dlsym may allocate before the real functions are known. */
static _Alignas(64) char early[65536];
static size_t early_used;

static void *early_new(size_t size) {
  size_t start = (early_used + 63) & ~(size_t)63;
  if (size > sizeof early - start)
    return NULL;
  early_used = start + size;
  return early + start;
}

static int is_early(const void *memory) {
  return (const char *)memory >= early && (const char *)memory < early + sizeof early;
}

static void find_real(void) {
  static int finding;
  if (real_free || finding)
    return;
  finding = 1;
  *(void **)&real_malloc = dlsym(RTLD_NEXT, "malloc");
  *(void **)&real_calloc = dlsym(RTLD_NEXT, "calloc");
  *(void **)&real_realloc = dlsym(RTLD_NEXT, "realloc");
  *(void **)&real_aligned = dlsym(RTLD_NEXT, "aligned_alloc");
  *(void **)&real_memalign = dlsym(RTLD_NEXT, "posix_memalign");
  *(void **)&real_free = dlsym(RTLD_NEXT, "free");
}

/* What the loader allocates before main is not counted. */
__attribute__((constructor)) static void start(void) {
  find_real();
  const char *at = getenv("TSOLID_FAIL_AT");
  fail_at = at ? atol(at) : 0;
  fail_on = getenv("TSOLID_FAIL_ON") != NULL;
  started = 1;
}

__attribute__((destructor)) static void finish(void) {
  const char *path = getenv("TSOLID_FAIL_COUNT");
  started = 0;
  FILE *file = path ? fopen(path, "w") : NULL;
  if (!file)
    return;
  fprintf(file, "%ld\n", atomic_load(&n_allocations));
  fclose(file);
}

static int fails(void) {
  if (!started)
    return 0;
  long k = atomic_fetch_add(&n_allocations, 1) + 1;
  return fail_at > 0 && (k == fail_at || (fail_on && k > fail_at));
}

void *malloc(size_t size) {
  find_real();
  if (!real_malloc)
    return early_new(size);
  if (fails()) {
    errno = ENOMEM;
    return NULL;
  }
  return real_malloc(size);
}

void *calloc(size_t n, size_t size) {
  find_real();
  if (!real_calloc)
    return size && n > sizeof early / size ? NULL : early_new(n * size);
  if (fails()) {
    errno = ENOMEM;
    return NULL;
  }
  return real_calloc(n, size);
}

void *realloc(void *memory, size_t size) {
  find_real();
  if (!real_realloc || is_early(memory)) {
    void *copy = malloc(size);
    size_t room = is_early(memory) ? (size_t)(early + sizeof early - (char *)memory) : 0;
    if (copy && memory)
      memcpy(copy, memory, size < room ? size : room);
    return copy;
  }
  if (fails()) {
    errno = ENOMEM;
    return NULL;
  }
  return real_realloc(memory, size);
}

void *aligned_alloc(size_t alignment, size_t size) {
  find_real();
  if (!real_aligned)
    return early_new(size);
  if (fails()) {
    errno = ENOMEM;
    return NULL;
  }
  return real_aligned(alignment, size);
}

int posix_memalign(void **memory, size_t alignment, size_t size) {
  find_real();
  if (!real_memalign || fails())
    return ENOMEM;
  return real_memalign(memory, alignment, size);
}

void free(void *memory) {
  find_real();
  if (memory && real_free && !is_early(memory))
    real_free(memory);
}
