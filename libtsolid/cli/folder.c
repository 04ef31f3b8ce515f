/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Several output files in a folder: written in one beside it, moved when all are there. */
#define _XOPEN_SOURCE 700
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli.h"

static int fail(const cli_folder *folder, const char *reason) {
  cli_error("Cannot write into the folder '%s': %s", folder->path, reason);
  return 0;
}

/* Joins into folder->file; 0: too long. */
static int join(cli_folder *folder, const char *directory, const char *name, char *to) {
  int n = snprintf(to, CLI_PATH_SIZE, "%s/%s", directory, name);
  return n > 0 && n < CLI_PATH_SIZE ? 1 : fail(folder, strerror(ENAMETOOLONG));
}

int cli_folder_open(cli_folder *folder, const char *path) {
  struct stat about;
  size_t n = strlen(path);
  memset(folder, 0, sizeof *folder);
  folder->path = path;
  while (n > 1 && path[n - 1] == '/')
    n--;
  if (n + 32 > CLI_PATH_SIZE)
    return fail(folder, strerror(ENAMETOOLONG));
  if (stat(path, &about) == 0) {
    if (!S_ISDIR(about.st_mode))
      return fail(folder, "it is not a folder");
    if (access(path, W_OK | X_OK) != 0)
      return fail(folder, strerror(errno));
  } else if (errno != ENOENT) {
    return fail(folder, strerror(errno));
  }
  snprintf(folder->staged, CLI_PATH_SIZE, "%.*s.%ld.new", (int)n, path, (long)getpid());
  if (mkdir(folder->staged, 0777) != 0) {
    folder->staged[0] = 0;
    return fail(folder, strerror(errno));
  }
  return 1;
}

const char *cli_folder_file(cli_folder *folder, const char *name) {
  if (strlen(name) >= CLI_NAME_SIZE) {
    fail(folder, strerror(ENAMETOOLONG));
    return NULL;
  }
  if (folder->n == folder->capacity) {
    int capacity = 2 * folder->capacity + 16;
    void *grown = realloc(folder->name, (size_t)capacity * sizeof *folder->name);
    if (!grown) {
      fail(folder, strerror(ENOMEM));
      return NULL;
    }
    folder->name = grown;
    folder->capacity = capacity;
  }
  if (!join(folder, folder->staged, name, folder->file))
    return NULL;
  snprintf(folder->name[folder->n++], CLI_NAME_SIZE, "%s", name);
  return folder->file;
}

int cli_folder_copy(cli_folder *folder, const char *name, FILE *from) {
  char buffer[4096];
  size_t n;
  const char *path = cli_folder_file(folder, name);
  FILE *to = path ? fopen(path, "wb") : NULL;
  if (!to)
    return path ? fail(folder, strerror(errno)) : 0;
  rewind(from);
  while ((n = fread(buffer, 1, sizeof buffer, from)) > 0)
    fwrite(buffer, 1, n, to);
  int ok = !ferror(from) && !ferror(to);
  return fclose(to) == 0 && ok ? 1 : fail(folder, "not everything could be written");
}

int cli_folder_commit(cli_folder *folder) {
  char target[CLI_PATH_SIZE];
  if (mkdir(folder->path, 0777) != 0 && errno != EEXIST)
    return fail(folder, strerror(errno));
  for (int k = 0; k < folder->n; k++) {
    if (!join(folder, folder->staged, folder->name[k], folder->file) ||
        !join(folder, folder->path, folder->name[k], target))
      return 0;
    if (rename(folder->file, target) != 0)
      return fail(folder, strerror(errno));
  }
  folder->n = 0;
  return 1;
}

void cli_folder_close(cli_folder *folder) {
  for (int k = 0; k < folder->n; k++)
    if (join(folder, folder->staged, folder->name[k], folder->file))
      unlink(folder->file);
  if (folder->staged[0])
    rmdir(folder->staged);
  free(folder->name);
  memset(folder, 0, sizeof *folder);
}
