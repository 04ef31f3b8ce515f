/* SPDX-License-Identifier: LGPL-2.1-or-later
 * What the writers of .vtu share: arrays in one appended block, base64, little-endian, each a text
 * of its own behind that of its length. */
#ifndef TSI_VTU_H
#define TSI_VTU_H

#include "file_io.h"

typedef struct tsi_vtu {
  tsi_output out;
  uint64_t offset; /* of the next array in the appended block */
  unsigned char pending[3];
  int n_pending;
} tsi_vtu;

/* One array: bytes of a number, numbers of a tuple. */
typedef struct tsi_vtu_array {
  const char *name, *type;
  int size, n_components;
} tsi_vtu_array;

/* <VTKFile> and <UnstructuredGrid>; field data may follow; then <Piece>. */
void tsi_vtu_head(tsi_vtu *vtu);
void tsi_vtu_piece(tsi_vtu *vtu, uint64_t n_points, uint64_t n_cells);
/* The element <DataArray> of an array with so many tuples; data follow in the order of these. */
void tsi_vtu_declare(tsi_vtu *vtu, const tsi_vtu_array *array, uint64_t n_tuples);
/* Text with what XML wants escaped. */
void tsi_vtu_text(tsi_vtu *vtu, const char *text);
/* </Piece> to the appended block's start, and from its end. */
void tsi_vtu_data(tsi_vtu *vtu);
void tsi_vtu_end(tsi_vtu *vtu);

/* An array's data: begin, its numbers, end. */
void tsi_vtu_begin(tsi_vtu *vtu, const tsi_vtu_array *array, uint64_t n_tuples);
void tsi_vtu_word(tsi_vtu *vtu, uint64_t value, int size);
void tsi_vtu_double(tsi_vtu *vtu, double value);
void tsi_vtu_flush(tsi_vtu *vtu);

#endif
