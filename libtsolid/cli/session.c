/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Context, progress on a terminal, signals, findings, clocks. */
#define _XOPEN_SOURCE 700
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "cli.h"

static volatile sig_atomic_t caught_signal;
static int n_errors; /* that were told */

static struct {
  int on_terminal, percent;
  char stage[32];
} shown;

/* The library looks at every progress call and unwinds, so that nothing is left behind. */
static void catch_signal(int number) {
  caught_signal = number;
}

int cli_interrupted(void) {
  return caught_signal != 0;
}

static void clear_progress(void) {
  if (shown.on_terminal && shown.stage[0])
    fputs("\r\033[K", stderr);
  shown.stage[0] = 0;
}

static int show_progress(void *data, const char *stage, double fraction) {
  int percent = (int)(100 * fraction);
  (void)data;
  if (shown.on_terminal && (percent != shown.percent || strcmp(stage, shown.stage) != 0)) {
    snprintf(shown.stage, sizeof shown.stage, "%s", stage);
    shown.percent = percent;
    fprintf(stderr, "\r\033[K%s %d %%", stage, percent);
    fflush(stderr);
  }
  return cli_interrupted();
}

tsolid_context *cli_open(int n_threads) {
  struct sigaction action = {.sa_handler = catch_signal};
  tsolid_context_options options = {.progress = show_progress, .n_threads = n_threads};
  tsolid_context *context;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, NULL);
  sigaction(SIGTERM, &action, NULL);
  shown.on_terminal = isatty(STDERR_FILENO);
  if (tsolid_context_create(&options, &context) != TSOLID_OK)
    cli_error("Out of memory");
  return context;
}

int cli_error(const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  n_errors++;
  clear_progress();
  fputs("error: ", stderr);
  vfprintf(stderr, format, arguments);
  fputc('\n', stderr);
  va_end(arguments);
  return CLI_FAILED;
}

/* Names in findings come from files: a newline in one must not look like another finding. */
static void print_line(const char *text) {
  for (; *text; text++)
    if ((unsigned char)*text < 0x20 || *text == 0x7f)
      fprintf(stderr, "\\x%02x", (unsigned)*text);
    else
      fputc(*text, stderr);
  fputc('\n', stderr);
}

static void print_findings(const tsolid_context *context) {
  static const char *const severity[] = {"note: ", "warning: ", "error: "};
  for (int k = 0; k < tsolid_context_n_findings(context); k++) {
    const tsolid_finding *finding = tsolid_context_finding(context, k);
    n_errors += finding->severity == TSOLID_ERROR;
    fputs(severity[finding->severity], stderr);
    print_line(finding->text);
  }
}

static const char *status_text(tsolid_status status) {
  switch (status) {
  case TSOLID_ERROR_MEMORY:
    return "Out of memory";
  case TSOLID_ERROR_ARGUMENT:
    return "A function was called wrongly: please report this";
  case TSOLID_ERROR_INPUT:
    return "The input is malformed";
  case TSOLID_ERROR_REFUSED:
    return "The part is outside the class that is taken";
  case TSOLID_ERROR_IO:
    return "A file operation failed";
  case TSOLID_ERROR_CANCELLED:
    return "Cancelled";
  case TSOLID_ERROR_NUMERIC:
    return "A solver did not reach its goal";
  default:
    return "An invariant broke: please report this";
  }
}

int cli_close(tsolid_context *context, tsolid_status status, int code) {
  clear_progress();
  print_findings(context);
  tsolid_context_free(context);
  if (status == TSOLID_ERROR_CANCELLED && cli_interrupted())
    return 128 + (int)caught_signal;
  if (status == TSOLID_OK)
    return code;
  if (n_errors == 0)
    cli_error("%s", status_text(status));
  return CLI_FAILED;
}

double cli_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double cli_peak_memory_mib(void) {
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return (double)usage.ru_maxrss / 1024;
}
