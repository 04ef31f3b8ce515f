/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Several output files as one: written under other names, renamed when all are there. */
#define _XOPEN_SOURCE 700
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli.h"

static int fail(const cli_target *target, const char *reason) {
  cli_error("Cannot write '%s': %s", target->path, reason);
  return 0;
}

static int same_file(const struct stat *a, const char *path) {
  struct stat b;
  return path && stat(path, &b) == 0 && a->st_dev == b.st_dev && a->st_ino == b.st_ino;
}

/* An existing target must be a file that may be changed; renaming would not ask. */
static int check_existing(cli_target *target, const struct stat *about, const char *input) {
  char resolved[PATH_MAX];
  if (S_ISDIR(about->st_mode))
    return fail(target, "it is a directory");
  if (!S_ISREG(about->st_mode))
    return fail(target, "it is not a regular file");
  if (same_file(about, input))
    return fail(target, "it is the input");
  if (access(target->path, W_OK) != 0)
    return fail(target, strerror(errno));
  if (!realpath(target->path, resolved))
    return fail(target, strerror(errno));
  snprintf(target->target, CLI_PATH_SIZE, "%s", resolved);
  return 1;
}

/* A new target: its directory must take it, and gets one name however it was spelt. */
static int check_directory(cli_target *target) {
  char directory[PATH_MAX], resolved[PATH_MAX];
  const char *path = target->path, *slash = strrchr(path, '/');
  const char *name = slash ? slash + 1 : path;
  size_t length = slash ? (size_t)(name - path) : 1;
  memcpy(directory, slash ? path : ".", length);
  directory[length] = 0;
  if (!realpath(directory, resolved) || access(resolved, W_OK | X_OK) != 0)
    return fail(target, strerror(errno));
  size_t n = strlen(resolved), m = strlen(name) + 1;
  if (n + 1 + m > PATH_MAX)
    return fail(target, strerror(ENAMETOOLONG));
  memcpy(target->target, resolved, n);
  target->target[n] = '/';
  memcpy(target->target + n + 1, name, m);
  return 1;
}

static int open_target(cli_target *target, const char *path, const char *input) {
  struct stat about;
  target->path = path;
  target->staged[0] = 0;
  if (strlen(path) >= PATH_MAX)
    return fail(target, strerror(ENAMETOOLONG));
  if (stat(path, &about) == 0) {
    if (!check_existing(target, &about, input))
      return 0;
  } else if (errno != ENOENT) {
    return fail(target, strerror(errno));
  } else if (!check_directory(target)) {
    return 0;
  }
  snprintf(target->staged, CLI_PATH_SIZE, "%.4096s.%ld.new", target->target, (long)getpid());
  return 1;
}

static int same_target(const cli_target *a, const cli_target *b) {
  struct stat about;
  int same = strcmp(a->target, b->target) == 0 ||
             (stat(a->target, &about) == 0 && same_file(&about, b->target));
  if (same)
    cli_error("'%s' is asked for twice", b->path);
  return same;
}

int cli_targets_open(cli_target *target, const char *const *path, int n, const char *input) {
  for (int k = 0; k < n; k++) {
    if (!path[k])
      continue;
    if (!open_target(&target[k], path[k], input))
      return 0;
    for (int m = 0; m < k; m++)
      if (path[m] && same_target(&target[m], &target[k]))
        return 0;
  }
  return 1;
}

int cli_targets_commit(cli_target *target, int n) {
  for (int k = 0; k < n; k++) {
    if (!target[k].path)
      continue;
    if (rename(target[k].staged, target[k].target) != 0)
      return fail(&target[k], strerror(errno));
    target[k].staged[0] = 0;
  }
  return 1;
}

void cli_targets_discard(cli_target *target, int n) {
  for (int k = 0; k < n; k++)
    if (target[k].path && target[k].staged[0])
      unlink(target[k].staged);
}
