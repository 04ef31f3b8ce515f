/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Command line options: "--name VALUE" or "--name=VALUE", in any order; "--" ends them. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static int store_count(const cli_option *option, const char *text) {
  char *end;
  errno = 0;
  long value = strtol(text, &end, 10);
  if (end == text || *end || errno || value < option->low || value > option->high) {
    cli_error("%s takes a whole number from %d to %d, not '%s'", option->name, option->low,
              option->high, text);
    return 0;
  }
  *(int *)option->value = (int)value;
  return 1;
}

/* The locale stays "C": nothing here calls setlocale. */
static int store_number(const cli_option *option, const char *text) {
  char *end;
  double value = strtod(text, &end);
  int positive = option->kind == CLI_NUMBER;
  if (end == text || *end || !isfinite(value) || (positive && value <= 0)) {
    cli_error("%s takes a %snumber, not '%s'", option->name, positive ? "positive " : "", text);
    return 0;
  }
  *(double *)option->value = value;
  return 1;
}

static int store_choice(const cli_option *option, const char *text) {
  for (int k = 0; option->choice[k]; k++)
    if (strcmp(option->choice[k], text) == 0) {
      *(int *)option->value = k;
      return 1;
    }
  fprintf(stderr, "error: %s takes", option->name);
  for (int k = 0; option->choice[k]; k++)
    fprintf(stderr, "%s %s", k == 0 ? "" : option->choice[k + 1] ? "," : " or", option->choice[k]);
  fprintf(stderr, ", not '%s'\n", text);
  return 0;
}

static int store(const cli_option *option, const char *text) {
  switch (option->kind) {
  case CLI_COUNT:
    return store_count(option, text);
  case CLI_NUMBER:
  case CLI_REAL:
    return store_number(option, text);
  case CLI_CHOICE:
    return store_choice(option, text);
  case CLI_FIELD:
    return cli_fields_add(option->value, text);
  case CLI_TEXT:
  case CLI_FLAG:
    break;
  }
  if (!*text) {
    cli_error("%s takes a file name, not an empty text", option->name);
    return 0;
  }
  *(const char **)option->value = text;
  return 1;
}

static const cli_option *find_option(const cli_option *options, const char *text, size_t length) {
  for (; options->name; options++)
    if (strlen(options->name) == length && strncmp(options->name, text, length) == 0)
      return options;
  return NULL;
}

/* The option argv[*k] with its value; moves *k to the last argument used. */
static int parse_option(int argc, char **argv, int *k, const cli_option *options) {
  const char *text = argv[*k], *equals = text[1] == '-' ? strchr(text, '=') : NULL;
  size_t length = equals ? (size_t)(equals - text) : strlen(text);
  const cli_option *option = find_option(options, text, length);
  if (!option) {
    cli_error("Unknown option '%s'; see 'tsolid %s --help'", text, argv[0]);
    return 0;
  }
  if (option->kind == CLI_FLAG) {
    if (equals)
      cli_error("%s takes no value", option->name);
    *(int *)option->value = 1;
    return !equals;
  }
  if (equals)
    return store(option, equals + 1);
  if (*k + 1 >= argc) {
    cli_error("%s needs a value", option->name);
    return 0;
  }
  return store(option, argv[++*k]);
}

/* n_files: at most so many, and unless `many` just so many. */
static int parse(int argc, char **argv, const char *help, const cli_option *options, int n_files,
                 int many, const char **file, int *n_found) {
  int only_files = 0, n = 0;
  for (int k = 0; k < n_files; k++)
    file[k] = NULL;
  for (int k = 1; k < argc; k++) {
    const char *text = argv[k];
    if (!only_files && (strcmp(text, "--help") == 0 || strcmp(text, "-h") == 0)) {
      fputs(help, stdout);
      return 0;
    }
    if (!only_files && strcmp(text, "--") == 0) {
      only_files = 1;
    } else if (!only_files && text[0] == '-' && text[1]) {
      if (!parse_option(argc, argv, &k, options))
        return CLI_FAILED;
    } else if (n == n_files) {
      return n_files == 1 ? cli_error("One file at a time: '%s' and '%s'", file[0], text)
                          : cli_error("Two files at a time, and then '%s'", text);
    } else {
      file[n++] = text;
    }
  }
  *n_found = n;
  if (n == 0)
    return cli_error("Which file? See 'tsolid %s --help'", argv[0]);
  return many || n == n_files ? -1 : cli_error("Where to? See 'tsolid %s --help'", argv[0]);
}

int cli_parse(int argc, char **argv, const char *help, const cli_option *options,
              const char **file) {
  int n;
  return parse(argc, argv, help, options, 1, 0, file, &n);
}

int cli_parse_two(int argc, char **argv, const char *help, const cli_option *options,
                  const char *file[2]) {
  int n;
  return parse(argc, argv, help, options, 2, 0, file, &n);
}

int cli_parse_many(int argc, char **argv, const char *help, const cli_option *options, int room,
                   const char **file, int *n_files) {
  return parse(argc, argv, help, options, room, 1, file, n_files);
}
