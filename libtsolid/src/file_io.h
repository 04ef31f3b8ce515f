/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Whole files in, whole files out: nothing half written ever stands under the target's name. And
 * numbers as text that no locale changes. */
#ifndef TSI_FILE_IO_H
#define TSI_FILE_IO_H

#include "internal.h"

/* ---- numbers as text ------------------------------------------------------------------------- */

enum { TSI_NUMBER_SIZE = 32, TSI_LONG_NUMBER_SIZE = 48 };

/* The shortest of 15, 16 or 17 digits that reads back as the same double; finite values only.
 * Returns the length. */
size_t tsi_number_print(double value, char text[TSI_NUMBER_SIZE]);

/* The same, with as many digits only as fit into `room` >= 8 characters. */
size_t tsi_number_print_within(double value, size_t room, char text[TSI_NUMBER_SIZE]);

/* So many digits that long double reads back the same. */
size_t tsi_number_print_long(long double value, char text[TSI_LONG_NUMBER_SIZE]);

/* Reads a number with a decimal point from zero-terminated text; *end as for strtod. */
double tsi_number_parse(const char *text, const char **end);
long double tsi_number_parse_long(const char *text, const char **end);

/* ---- reading --------------------------------------------------------------------------------- */

/* The bytes of a regular file with a zero byte behind them, to be freed with tsi_delete. Files
 * above `limit` bytes are refused with TSOLID_ERROR_INPUT. */
tsolid_status tsi_file_read(tsolid_context *context, const char *stage, const char *path,
                            size_t limit, char **bytes, size_t *size);

/* ---- writing --------------------------------------------------------------------------------- */

enum { TSI_OUTPUT_BUFFER = 1 << 16 };

/* A file that is being written beside its target. Errors stick: the first one counts, later calls
 * do nothing, tsi_output_close tells. */
typedef struct tsi_output {
  tsolid_context *context;
  const char *stage;
  const char *path; /* as the caller named it */
  char *target;     /* symbolic links followed */
  char *beside;
  int descriptor;
  tsolid_status status;
  size_t used;
  char *buffer;
} tsi_output;

tsolid_status tsi_output_open(tsi_output *output, tsolid_context *context, const char *stage,
                              const char *path);
void tsi_output_add(tsi_output *output, const void *bytes, size_t size);
void tsi_output_text(tsi_output *output, const char *text);
void tsi_output_integer(tsi_output *output, long long value);
/* A number that is not finite has no form in our text files: TSOLID_ERROR_INPUT. */
void tsi_output_number(tsi_output *output, double value);

/* Renames onto the target when everything, `status` included, went well; else removes what was
 * written. Returns the first error. To be called once after every successful or failed open. */
tsolid_status tsi_output_close(tsi_output *output, tsolid_status status);

#endif
