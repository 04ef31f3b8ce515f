/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Writes a boundary as .tsb (resources/boundary.schema.json); every double reads back as it was. */
#include <stdio.h>

#include "file_io.h"
#include "json_reader.h"

static const char stage[] = "write";

/* ---- checks: a caller's contract, so that no array is read beyond its end ----------------------
 */

static int patch_is_sound(const tsolid_patch *patch) {
  for (int d = 0; d < 2; d++)
    if (patch->degree[d] < 1 || patch->degree[d] > TSI_MAX_DEGREE ||
        patch->n_control[d] <= patch->degree[d] || patch->n_control[d] > TSI_MAX_COUNT ||
        !patch->knots[d])
      return 0;
  return patch->points != NULL;
}

static int side_is_sound(const tsolid_bezier_side *side, int n_functions) {
  for (int d = 0; d < 2; d++)
    if (side->degree[d] < 1 || side->degree[d] > TSI_MAX_DEGREE)
      return 0;
  if (side->n_elements < 1 || side->n_elements > TSI_MAX_COUNT || !side->box ||
      !side->function_start || !side->function || !side->coefficient ||
      side->function_start[0] != 0)
    return 0;
  for (int e = 0; e < side->n_elements; e++)
    if (side->function_start[e + 1] < side->function_start[e])
      return 0;
  for (int k = 0; k < side->function_start[side->n_elements]; k++)
    if (side->function[k] < 0 || side->function[k] >= n_functions)
      return 0;
  return 1;
}

static int tspline_is_sound(const tsolid_tspline *t, int n_points) {
  for (int d = 0; d < 2; d++)
    if (t->degree[d] < 1 || t->degree[d] > TSI_MAX_DEGREE || !t->knots[d])
      return 0;
  if (t->n_functions < 1 || t->n_functions > TSI_MAX_COUNT || !t->point)
    return 0;
  for (int k = 0; k < t->n_functions; k++)
    if (t->point[k] < 0 || t->point[k] >= n_points)
      return 0;
  return 1;
}

static int form_is_sound(const tsolid_patch *patch, int n_points) {
  if (patch->tspline && patch->bezier)
    return 0;
  return patch->tspline  ? tspline_is_sound(patch->tspline, n_points)
         : patch->bezier ? side_is_sound(patch->bezier, n_points)
                         : patch_is_sound(patch);
}

static int input_is_sound(const tsolid_boundary_input *input) {
  int n_patches = input->patches ? input->n_patches : 0;
  if (!input->bezier == (n_patches <= 0))
    return 0;
  for (int k = 0; k < n_patches; k++)
    if (!form_is_sound(&input->patches[k], input->points ? input->n_points : 0))
      return 0;
  if (input->n_points < 0 || input->n_points > TSI_MAX_COUNT ||
      (input->n_smooth > 0 && !input->smooth))
    return 0;
  if (!input->bezier)
    return 1;
  if (input->bezier->n_functions < 1 || input->bezier->n_functions > TSI_MAX_COUNT ||
      !input->bezier->points)
    return 0;
  for (int k = 0; k < 6; k++)
    if (!side_is_sound(&input->bezier->side[k], input->bezier->n_functions))
      return 0;
  return 1;
}

/* ---- values ------------------------------------------------------------------------------------
 */

static void put_numbers(tsi_output *out, const double *number, size_t n) {
  for (size_t k = 0; k < n; k++) {
    tsi_output_text(out, k ? ", " : "[");
    tsi_output_number(out, number[k]);
  }
  tsi_output_text(out, n ? "]" : "[]");
}

static void put_rows(tsi_output *out, const double *number, size_t n, size_t width,
                     const char *indent) {
  for (size_t k = 0; k < n; k++) {
    tsi_output_text(out, k ? ",\n" : "[\n");
    tsi_output_text(out, indent);
    put_numbers(out, number + k * width, width);
  }
  tsi_output_text(out, n ? "]" : "[]");
}

static void put_pair(tsi_output *out, const int pair[2]) {
  tsi_output_text(out, "[");
  tsi_output_integer(out, pair[0]);
  tsi_output_text(out, ", ");
  tsi_output_integer(out, pair[1]);
  tsi_output_text(out, "]");
}

static void put_string(tsi_output *out, const char *string) {
  tsi_output_text(out, "\"");
  while (*string && out->status == TSOLID_OK) {
    char escape[8];
    int n = tsi_utf8_length(string);
    if (n == 0) {
      out->status = tsi_fail(out->context, TSOLID_ERROR_INPUT, stage,
                             "Cannot write '%s': a name is not UTF-8", out->path);
    } else if (*string == '"' || *string == '\\') {
      tsi_output_text(out, "\\");
      tsi_output_add(out, string, 1);
    } else if ((unsigned char)*string < 0x20) {
      snprintf(escape, sizeof escape, "\\u%04x", (unsigned)*string);
      tsi_output_text(out, escape);
    } else {
      tsi_output_add(out, string, (size_t)n);
    }
    string += n;
  }
  tsi_output_text(out, "\"");
}

/* A name that is not there is written as an empty one. */
static void put_names(tsi_output *out, const char *key, const char *const name[4]) {
  if (!name[0] && !name[1] && !name[2] && !name[3])
    return;
  tsi_output_text(out, key);
  for (int k = 0; k < 4; k++) {
    tsi_output_text(out, k ? ", " : "[");
    put_string(out, name[k] ? name[k] : "");
  }
  tsi_output_text(out, "],\n");
}

/* ---- the two forms -----------------------------------------------------------------------------
 */

static void put_element(tsi_output *out, const tsolid_bezier_side *side, int element) {
  size_t order = (size_t)(side->degree[0] + 1) * (size_t)(side->degree[1] + 1);
  int first = side->function_start[element], end = side->function_start[element + 1];
  tsi_output_text(out, "    {\"box\": ");
  put_numbers(out, side->box + 4 * (size_t)element, 4);
  tsi_output_text(out, ", \"functions\": [");
  for (int k = first; k < end; k++) {
    tsi_output_text(out, k > first ? ", " : "");
    tsi_output_integer(out, side->function[k]);
  }
  tsi_output_text(out, "],\n     \"coefficients\": ");
  put_rows(out, side->coefficient + (size_t)first * order, (size_t)(end - first), order, "      ");
  tsi_output_text(out, "}");
}

static void put_elements(tsi_output *out, const tsolid_bezier_side *side) {
  tsi_output_text(out, "{\"degree\": ");
  put_pair(out, side->degree);
  tsi_output_text(out, ", \"elements\": [\n");
  for (int e = 0; e < side->n_elements; e++) {
    tsi_output_text(out, e ? ",\n" : "");
    put_element(out, side, e);
  }
  tsi_output_text(out, "]}");
}

static void put_tspline(tsi_output *out, const tsolid_tspline *t) {
  tsi_output_text(out, "{\"degree\": ");
  put_pair(out, t->degree);
  tsi_output_text(out, ", \"domain\": ");
  put_numbers(out, t->domain, 4);
  tsi_output_text(out, ", \"functions\": [");
  for (int k = 0; k < t->n_functions; k++) {
    tsi_output_text(out, k ? ",\n    {\"point\": " : "\n    {\"point\": ");
    tsi_output_integer(out, t->point[k]);
    for (int d = 0; d < 2; d++) {
      size_t n = (size_t)t->degree[d] + 2;
      tsi_output_text(out, d ? ", " : ", \"knots\": [");
      put_numbers(out, t->knots[d] + (size_t)k * n, n);
    }
    tsi_output_text(out, "]}");
  }
  tsi_output_text(out, "]}");
}

static void put_net(tsi_output *out, const tsolid_patch *patch) {
  size_t n = (size_t)patch->n_control[0] * (size_t)patch->n_control[1];
  tsi_output_text(out, "   \"degree\": ");
  put_pair(out, patch->degree);
  tsi_output_text(out, ", \"n_control\": ");
  put_pair(out, patch->n_control);
  tsi_output_text(out, ",\n");
  for (int d = 0; d < 2; d++) {
    tsi_output_text(out, d ? ",\n             " : "   \"knots\": [");
    put_numbers(out, patch->knots[d], (size_t)patch->n_control[d] + (size_t)patch->degree[d] + 1);
  }
  tsi_output_text(out, "],\n   \"points\": ");
  put_rows(out, patch->points, n, 3, "    ");
  if (patch->weights) {
    tsi_output_text(out, ",\n   \"weights\": ");
    put_numbers(out, patch->weights, n);
  }
}

static void put_patch(tsi_output *out, const tsolid_patch *patch) {
  tsi_output_text(out, "  {");
  if (patch->name) {
    tsi_output_text(out, "\"name\": ");
    put_string(out, patch->name);
    tsi_output_text(out, ",\n");
  }
  put_names(out, "   \"border_names\": ", patch->border_name);
  put_names(out, "   \"corner_names\": ", patch->corner_name);
  const double *tolerance = patch->border_tolerance;
  if (tolerance[0] != 0 || tolerance[1] != 0 || tolerance[2] != 0 || tolerance[3] != 0) {
    tsi_output_text(out, "   \"border_tolerance\": ");
    put_numbers(out, tolerance, 4);
    tsi_output_text(out, ",\n");
  }
  if (patch->tspline) {
    tsi_output_text(out, "   \"tspline\": ");
    put_tspline(out, patch->tspline);
  } else if (patch->bezier) {
    tsi_output_text(out, "   \"bezier\": ");
    put_elements(out, patch->bezier);
  } else {
    put_net(out, patch);
  }
  tsi_output_text(out, "}");
}

static void put_smooth(tsi_output *out, int n, const tsolid_smooth_seam *seam) {
  for (int k = 0; k < n; k++) {
    tsi_output_text(out, k ? ",\n  {\"patches\": " : ",\n \"smooth\": [\n  {\"patches\": ");
    put_pair(out, seam[k].patch);
    tsi_output_text(out, ", \"borders\": ");
    put_pair(out, seam[k].border);
    tsi_output_text(out, ", \"order\": ");
    tsi_output_integer(out, seam[k].order);
    tsi_output_text(out, "}");
  }
  tsi_output_text(out, n > 0 ? "]" : "");
}

static void put_bezier(tsi_output *out, const tsolid_bezier_boundary *bezier) {
  tsi_output_text(out, " \"bezier\": {\n  \"points\": ");
  put_rows(out, bezier->points, (size_t)bezier->n_functions, 4, "   ");
  tsi_output_text(out, ",\n  \"sides\": [");
  for (int k = 0; k < 6; k++) {
    tsi_output_text(out, k ? ",\n   " : "\n   ");
    put_elements(out, &bezier->side[k]);
  }
  tsi_output_text(out, "]}");
}

tsolid_status tsolid_write_tsb(tsolid_context *context, const tsolid_boundary_input *input,
                               const char *path) {
  tsi_output out;
  if (!context || !input || !path || !input_is_sound(input))
    return TSOLID_ERROR_ARGUMENT;
  if (tsi_output_open(&out, context, stage, path) == TSOLID_OK) {
    tsi_output_text(&out, "{\"format\": \"tsolid boundary\", \"version\": 1,\n");
    if (input->bezier) {
      put_bezier(&out, input->bezier);
    } else {
      if (input->n_points > 0) {
        tsi_output_text(&out, " \"points\": ");
        put_rows(&out, input->points, (size_t)input->n_points, 4, "  ");
        tsi_output_text(&out, ",\n");
      }
      tsi_output_text(&out, " \"patches\": [\n");
      for (int k = 0; k < input->n_patches; k++) {
        tsi_output_text(&out, k ? ",\n" : "");
        put_patch(&out, &input->patches[k]);
      }
      tsi_output_text(&out, "]");
      put_smooth(&out, input->n_smooth, input->smooth);
    }
    tsi_output_text(&out, "}\n");
  }
  return tsi_output_close(&out, TSOLID_OK);
}
