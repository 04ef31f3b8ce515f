/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Matrices and vectors as files: MatrixMarket text, and PETSc's binary form, which is big-endian:
 * class id, rows, columns, non-zeros; entries per row; columns from 0; values. A vector: class id,
 * length, values; a set of indices: class id, length, indices from 0. */
#include "file_io.h"
#include "matrix.h"

static const char stage[] = "export";

enum { MATRIX_CLASS = 1211216, VECTOR_CLASS = 1211214, SET_CLASS = 1211218, PROGRESS_ROWS = 1024 };

static void put_big(tsi_output *out, uint64_t value, int size) {
  unsigned char bytes[8];
  for (int k = 0; k < size; k++)
    bytes[k] = (unsigned char)(value >> 8 * (size - 1 - k) & 255);
  tsi_output_add(out, bytes, (size_t)size);
}

static void put_big_double(tsi_output *out, double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  put_big(out, bits, 8);
}

/* ---- text --------------------------------------------------------------------------------------
 */

static size_t count_lower(const tsolid_matrix *m) {
  size_t n = 0;
  for (int i = 0; i < m->n_rows; i++)
    for (size_t k = m->row_start[i]; k < m->row_start[i + 1]; k++)
      n += m->column[k] <= i;
  return n;
}

static tsolid_status put_market(tsi_output *out, const tsolid_matrix *m) {
  tsi_output_text(out, "%%MatrixMarket matrix coordinate real symmetric\n");
  tsi_output_integer(out, m->n_rows);
  tsi_output_text(out, " ");
  tsi_output_integer(out, m->n_rows);
  tsi_output_text(out, " ");
  tsi_output_integer(out, (long long)count_lower(m));
  tsi_output_text(out, "\n");
  for (int i = 0; i < m->n_rows && out->status == TSOLID_OK; i++) {
    for (size_t k = m->row_start[i]; k < m->row_start[i + 1] && m->column[k] <= i; k++) {
      tsi_output_integer(out, i + 1);
      tsi_output_text(out, " ");
      tsi_output_integer(out, m->column[k] + 1);
      tsi_output_text(out, " ");
      tsi_output_number(out, m->value[k]);
      tsi_output_text(out, "\n");
    }
    if (i % PROGRESS_ROWS == 0) {
      tsolid_status status = tsi_progress(out->context, stage, (double)i / m->n_rows);
      if (status)
        return status;
    }
  }
  return TSOLID_OK;
}

/* ---- binary ------------------------------------------------------------------------------------
 */

static tsolid_status put_petsc(tsi_output *out, const tsolid_matrix *m) {
  size_t n = m->row_start[m->n_rows];
  put_big(out, MATRIX_CLASS, 4);
  put_big(out, (uint64_t)m->n_rows, 4);
  put_big(out, (uint64_t)m->n_rows, 4);
  put_big(out, n, 4);
  for (int i = 0; i < m->n_rows; i++)
    put_big(out, m->row_start[i + 1] - m->row_start[i], 4);
  tsolid_status status = tsi_progress(out->context, stage, 0.1);
  for (size_t k = 0; !status && k < n; k++)
    put_big(out, (uint64_t)m->column[k], 4);
  if (!status)
    status = tsi_progress(out->context, stage, 0.4);
  for (size_t k = 0; !status && k < n; k++)
    put_big_double(out, m->value[k]);
  return status;
}

/* ---- public ------------------------------------------------------------------------------------
 */

tsolid_status tsolid_write_matrix_market(tsolid_context *context, const tsolid_matrix *matrix,
                                         const char *path) {
  tsi_output out;
  tsolid_status status = TSOLID_OK;
  if (!context || !matrix || !path)
    return TSOLID_ERROR_ARGUMENT;
  if (tsi_output_open(&out, context, stage, path) == TSOLID_OK)
    status = put_market(&out, matrix);
  return tsi_output_close(&out, status);
}

tsolid_status tsolid_write_petsc(tsolid_context *context, const tsolid_matrix *matrix,
                                 const char *path) {
  tsi_output out;
  tsolid_status status = TSOLID_OK;
  if (!context || !matrix || !path)
    return TSOLID_ERROR_ARGUMENT;
  if (matrix->row_start[matrix->n_rows] > INT32_MAX)
    return tsi_fail(context, TSOLID_ERROR_REFUSED, stage,
                    "The matrix has too many entries for PETSc's 32 bit form");
  if (tsi_output_open(&out, context, stage, path) == TSOLID_OK)
    status = put_petsc(&out, matrix);
  return tsi_output_close(&out, status);
}

tsolid_status tsolid_write_table_market(tsolid_context *context, int n_rows, int n_columns,
                                        const double *value, const char *path) {
  tsi_output out;
  if (!context || n_rows < 0 || n_columns < 0 || !value || !path)
    return TSOLID_ERROR_ARGUMENT;
  if (tsi_output_open(&out, context, stage, path) == TSOLID_OK) {
    tsi_output_text(&out, "%%MatrixMarket matrix array real general\n");
    tsi_output_integer(&out, n_rows);
    tsi_output_text(&out, " ");
    tsi_output_integer(&out, n_columns);
    tsi_output_text(&out, "\n");
    for (int j = 0; j < n_columns; j++)
      for (int i = 0; i < n_rows && out.status == TSOLID_OK; i++) {
        tsi_output_number(&out, value[(size_t)i * (size_t)n_columns + (size_t)j]);
        tsi_output_text(&out, "\n");
      }
  }
  return tsi_output_close(&out, TSOLID_OK);
}

tsolid_status tsolid_write_vector_market(tsolid_context *context, int n, const double *value,
                                         const char *path) {
  return tsolid_write_table_market(context, n, 1, value, path);
}

tsolid_status tsolid_write_vector_petsc(tsolid_context *context, int n, const double *value,
                                        const char *path) {
  tsi_output out;
  if (!context || n < 0 || !value || !path)
    return TSOLID_ERROR_ARGUMENT;
  if (tsi_output_open(&out, context, stage, path) == TSOLID_OK) {
    put_big(&out, VECTOR_CLASS, 4);
    put_big(&out, (uint64_t)n, 4);
    for (int k = 0; k < n; k++)
      put_big_double(&out, value[k]);
  }
  return tsi_output_close(&out, TSOLID_OK);
}

tsolid_status tsolid_write_set_petsc(tsolid_context *context, int n, const int *index,
                                     const char *path) {
  tsi_output out;
  if (!context || n < 0 || (n > 0 && !index) || !path)
    return TSOLID_ERROR_ARGUMENT;
  if (tsi_output_open(&out, context, stage, path) == TSOLID_OK) {
    put_big(&out, SET_CLASS, 4);
    put_big(&out, (uint64_t)n, 4);
    for (int k = 0; k < n; k++)
      put_big(&out, (uint64_t)index[k], 4);
  }
  return tsi_output_close(&out, TSOLID_OK);
}
