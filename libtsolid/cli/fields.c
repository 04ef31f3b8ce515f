/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Results for --vtu: "NAME=FILE", FILE a dense MatrixMarket table or a PETSc vector with one or
 * three numbers per function of the solid. */
#include <stdlib.h>
#include <string.h>

#include "cli.h"

int cli_fields_add(cli_fields *fields, const char *text) {
  const char *equals = strchr(text, '=');
  if (!equals || equals == text || !equals[1]) {
    cli_error("--field takes NAME=FILE, not '%s'", text);
    return 0;
  }
  if (fields->n == CLI_MAX_FIELDS) {
    cli_error("--field: %d fields at most", CLI_MAX_FIELDS);
    return 0;
  }
  fields->given[fields->n++] = text;
  return 1;
}

tsolid_status cli_fields_read(cli_fields *fields, tsolid_context *context,
                              const tsolid_solid *solid) {
  tsolid_space_view view;
  tsolid_space_get(tsolid_solid_space(solid), &view);
  for (int k = 0; k < fields->n; k++) {
    const char *equals = strchr(fields->given[k], '=');
    size_t length = (size_t)(equals - fields->given[k]);
    int rows = 0, columns = 0;
    tsolid_status status =
        tsolid_read_table(context, equals + 1, &rows, &columns, &fields->value[k]);
    if (status)
      return status;
    long long n = (long long)rows * columns;
    if (n != view.n_functions && n != 3LL * view.n_functions) {
      cli_error("'%s' has %lld numbers; the solid has %d functions, so %d or %d are expected",
                equals + 1, n, view.n_functions, view.n_functions, 3 * view.n_functions);
      return TSOLID_ERROR_INPUT;
    }
    fields->name[k] = malloc(length + 1);
    if (!fields->name[k])
      return TSOLID_ERROR_MEMORY;
    memcpy(fields->name[k], fields->given[k], length);
    fields->name[k][length] = 0;
    fields->field[k] =
        (tsolid_field){fields->name[k], (int)(n / view.n_functions), fields->value[k]};
  }
  return TSOLID_OK;
}

void cli_fields_free(cli_fields *fields, tsolid_context *context) {
  for (int k = 0; k < fields->n; k++) {
    free(fields->name[k]);
    tsolid_release(context, fields->value[k]);
  }
}
