/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Files: read as a whole with a limit; written beside the target, synced, then renamed. */
#define _XOPEN_SOURCE 700
#include <errno.h>
#include <fcntl.h>
#include <float.h>
#include <limits.h>
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "file_io.h"

/* ---- numbers ----------------------------------------------------------------------------------
 */

/* The decimal point belongs to the thread's locale, which is the caller's: borrow the C locale for
 * the one call. */
static locale_t enter_c_locale(locale_t *c) {
  *c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  return *c ? uselocale(*c) : (locale_t)0;
}

static void leave_c_locale(locale_t c, locale_t previous) {
  if (!c)
    return;
  uselocale(previous);
  freelocale(c);
}

size_t tsi_number_print(double value, char text[TSI_NUMBER_SIZE]) {
  char digits[TSI_NUMBER_SIZE] = "";
  locale_t c, previous = enter_c_locale(&c);
  int length = 0;
  for (int n_digits = 15; n_digits <= 17; n_digits++) {
    length = snprintf(digits, sizeof digits, "%.*g", n_digits, value);
    double back = strtod(digits, NULL);
    if (memcmp(&back, &value, sizeof back) == 0)
      break;
  }
  leave_c_locale(c, previous);
  memcpy(text, digits, sizeof digits);
  return (size_t)length;
}

size_t tsi_number_print_within(double value, size_t room, char text[TSI_NUMBER_SIZE]) {
  size_t length = tsi_number_print(value, text);
  locale_t c, previous = enter_c_locale(&c);
  for (int n_digits = 16; length > room && n_digits > 0; n_digits--)
    length = (size_t)snprintf(text, TSI_NUMBER_SIZE, "%.*g", n_digits, value);
  leave_c_locale(c, previous);
  return length;
}

size_t tsi_number_print_long(long double value, char text[TSI_LONG_NUMBER_SIZE]) {
  locale_t c, previous = enter_c_locale(&c);
  int length = snprintf(text, TSI_LONG_NUMBER_SIZE, "%.*Lg", LDBL_DECIMAL_DIG, value);
  leave_c_locale(c, previous);
  return (size_t)length;
}

long double tsi_number_parse_long(const char *text, const char **end) {
  locale_t c, previous = enter_c_locale(&c);
  char *stop = NULL;
  long double value = strtold(text, &stop);
  leave_c_locale(c, previous);
  *end = stop;
  return value;
}

double tsi_number_parse(const char *text, const char **end) {
  locale_t c, previous = enter_c_locale(&c);
  char *stop = NULL;
  double value = strtod(text, &stop);
  leave_c_locale(c, previous);
  *end = stop;
  return value;
}

/* ---- reading ----------------------------------------------------------------------------------
 */

static tsolid_status fail_errno(tsolid_context *context, const char *stage, const char *verb,
                                const char *path, int error) {
  char reason[256];
  if (strerror_r(error, reason, sizeof reason) != 0)
    snprintf(reason, sizeof reason, "error %d", error);
  return tsi_fail(context, TSOLID_ERROR_IO, stage, "Cannot %s '%s': %s", verb, path, reason);
}

static tsolid_status fail_not_regular(tsolid_context *context, const char *stage, const char *verb,
                                      const char *path, mode_t mode) {
  return tsi_fail(context, TSOLID_ERROR_IO, stage, "Cannot %s '%s': it is %s", verb, path,
                  S_ISDIR(mode) ? "a directory" : "not a regular file");
}

/* Reads up to `size` bytes (the file may have shrunk since); returns 0 or errno. */
static int read_all(int descriptor, char *bytes, size_t *size) {
  size_t n = 0;
  while (n < *size) {
    ssize_t got = read(descriptor, bytes + n, *size - n);
    if (got < 0 && errno == EINTR)
      continue;
    if (got < 0)
      return errno;
    if (got == 0)
      break;
    n += (size_t)got;
  }
  *size = n;
  return 0;
}

tsolid_status tsi_file_read(tsolid_context *context, const char *stage, const char *path,
                            size_t limit, char **bytes, size_t *size) {
  tsolid_status status = TSOLID_OK;
  int descriptor = -1, error = 0;
  char *read = NULL;
  struct stat about;
  *bytes = NULL;
  *size = 0;
  /* Before open: opening a pipe would wait for a writer. */
  if (stat(path, &about) != 0)
    return fail_errno(context, stage, "read", path, errno);
  if (!S_ISREG(about.st_mode))
    return fail_not_regular(context, stage, "read", path, about.st_mode);
  if (about.st_size < 0 || (unsigned long long)about.st_size > limit)
    return tsi_fail(context, TSOLID_ERROR_INPUT, stage,
                    "File '%s' has %lld bytes, more than the %zu that are read", path,
                    (long long)about.st_size, limit);
  size_t n = (size_t)about.st_size;
  descriptor = open(path, O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    status = fail_errno(context, stage, "read", path, errno);
    goto done;
  }
  read = tsi_new(&context->allocator, n + 1, 1);
  if (!read) {
    status = tsi_no_memory(context, stage);
    goto done;
  }
  error = read_all(descriptor, read, &n);
  if (error) {
    status = fail_errno(context, stage, "read", path, error);
    goto done;
  }
  read[n] = 0;
  *bytes = read;
  *size = n;
  read = NULL;
done:
  if (descriptor >= 0)
    close(descriptor);
  tsi_delete(&context->allocator, read);
  return status;
}

/* ---- writing ----------------------------------------------------------------------------------
 */

static void output_fail(tsi_output *output, int error) {
  if (output->status == TSOLID_OK)
    output->status = fail_errno(output->context, output->stage, "write", output->path, error);
}

static char *copy_text(tsolid_context *context, const char *text, size_t room) {
  size_t length = strlen(text);
  char *copy = tsi_new(&context->allocator, length + room + 1, 1);
  if (copy)
    memcpy(copy, text, length);
  return copy;
}

/* Where the file shall stand in the end. An existing target must be one that may be replaced:
 * renaming onto a device or a write-protected file would succeed where writing would not. */
static tsolid_status find_target(tsi_output *output) {
  struct stat about;
  char resolved[PATH_MAX];
  const char *target = output->path;
  if (stat(output->path, &about) == 0) {
    if (!S_ISREG(about.st_mode))
      return fail_not_regular(output->context, output->stage, "write", output->path, about.st_mode);
    if (access(output->path, W_OK) != 0)
      return fail_errno(output->context, output->stage, "write", output->path, errno);
    if (realpath(output->path, resolved))
      target = resolved;
  } else if (errno != ENOENT || !output->path[0]) {
    return fail_errno(output->context, output->stage, "write", output->path, errno);
  }
  output->target = copy_text(output->context, target, 0);
  output->beside = copy_text(output->context, target, 32);
  return output->target && output->beside ? TSOLID_OK
                                          : tsi_no_memory(output->context, output->stage);
}

/* A name that nobody uses, in the same directory so that rename is atomic. */
static void create_beside(tsi_output *output) {
  size_t length = strlen(output->target);
  for (int k = 0; k < 1000 && output->descriptor < 0; k++) {
    snprintf(output->beside + length, 32, ".part%d", k);
    output->descriptor = open(output->beside, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (output->descriptor < 0 && errno != EEXIST)
      break;
  }
  if (output->descriptor < 0)
    output_fail(output, errno);
}

tsolid_status tsi_output_open(tsi_output *output, tsolid_context *context, const char *stage,
                              const char *path) {
  *output = (tsi_output){.context = context, .stage = stage, .path = path, .descriptor = -1};
  output->status = find_target(output);
  if (output->status == TSOLID_OK) {
    output->buffer = tsi_new(&context->allocator, TSI_OUTPUT_BUFFER, 1);
    if (!output->buffer)
      output->status = tsi_no_memory(context, stage);
  }
  if (output->status == TSOLID_OK)
    create_beside(output);
  return output->status;
}

static void flush_output(tsi_output *output) {
  size_t n = 0;
  while (output->status == TSOLID_OK && n < output->used) {
    ssize_t put = write(output->descriptor, output->buffer + n, output->used - n);
    if (put > 0)
      n += (size_t)put;
    else if (put == 0 || errno != EINTR)
      output_fail(output, put == 0 ? ENOSPC : errno);
  }
  output->used = 0;
}

void tsi_output_add(tsi_output *output, const void *bytes, size_t size) {
  const char *from = bytes;
  while (output->status == TSOLID_OK && size > 0) {
    size_t room = TSI_OUTPUT_BUFFER - output->used, part = size < room ? size : room;
    memcpy(output->buffer + output->used, from, part);
    output->used += part;
    from += part;
    size -= part;
    if (output->used == TSI_OUTPUT_BUFFER)
      flush_output(output);
  }
}

void tsi_output_text(tsi_output *output, const char *text) {
  tsi_output_add(output, text, strlen(text));
}

void tsi_output_integer(tsi_output *output, long long value) {
  char text[TSI_NUMBER_SIZE];
  snprintf(text, sizeof text, "%lld", value);
  tsi_output_text(output, text);
}

void tsi_output_number(tsi_output *output, double value) {
  char text[TSI_NUMBER_SIZE];
  if (output->status != TSOLID_OK)
    return;
  if (isfinite(value))
    tsi_output_add(output, text, tsi_number_print(value, text));
  else
    output->status = tsi_fail(output->context, TSOLID_ERROR_INPUT, output->stage,
                              "Cannot write '%s': a number is not finite", output->path);
}

/* After rename the directory holds the news; a file system that cannot sync one is no error. */
static void sync_directory(const tsi_output *output) {
  char *slash = strrchr(output->beside, '/');
  if (slash)
    slash[slash == output->beside] = 0;
  int directory = open(slash ? output->beside : ".", O_RDONLY | O_CLOEXEC);
  if (directory < 0)
    return;
  fsync(directory);
  close(directory);
}

tsolid_status tsi_output_close(tsi_output *output, tsolid_status status) {
  if (output->status == TSOLID_OK)
    output->status = status;
  if (output->descriptor >= 0) {
    flush_output(output);
    if (output->status == TSOLID_OK && fsync(output->descriptor) != 0)
      output_fail(output, errno);
    if (close(output->descriptor) != 0)
      output_fail(output, errno);
    if (output->status == TSOLID_OK && rename(output->beside, output->target) != 0)
      output_fail(output, errno);
    if (output->status != TSOLID_OK)
      unlink(output->beside);
    else
      sync_directory(output);
  }
  tsi_delete(&output->context->allocator, output->buffer);
  tsi_delete(&output->context->allocator, output->beside);
  tsi_delete(&output->context->allocator, output->target);
  output->buffer = output->beside = output->target = NULL;
  output->descriptor = -1;
  return output->status;
}
