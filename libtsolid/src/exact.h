/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Signs of determinants of doubles, exactly. */
#ifndef TSI_EXACT_H
#define TSI_EXACT_H

/* Sign (-1, 0, 1) of the determinant of the matrix with the given rows, without any error; 2 when
 * the numbers span too many binary orders for that (products could underflow) or are not finite. */
int tsi_exact_det4(const double *const row[4]);

#endif
