/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The .tsolid container, version 4. Everything is little-endian; u32 and u64 are unsigned, f64 is
 * an IEEE 754 double by its bits. All counts stand before what they count.
 *
 *   file    = magic (8 bytes), u32 version, section * 11
 *   section = tag (4 bytes), u64 length of the payload, payload, u32 CRC-32 of all that
 *
 * The sections, in this order and each exactly filled:
 *
 *   FUNC    u32 n, f64 point[n][4]: the boundary's control points (w x, w y, w z, w)
 *   SIDE    six times: u32 degree[2], u32 grid[2], u32 n_elements, f64 box[n_elements][4],
 *           u32 function_start[n_elements + 1], u32 function[n], f64 coefficient[n][order]
 *           with n = function_start[n_elements], order = (degree[0]+1)(degree[1]+1)
 *   FACT    the requirement (without names of corners, which are the input's) and the preparation,
 *           field by field in the order of tsolid.h; version 1 ends before n_bilinear_factors,
 *           n_moebius (both 0), versions 2 and 3 before n_cut_patches and on (all 0)
 *   MESH    u32 n_lines[3], f64 line[n_lines] of each axis, u32 n_boxes, u32 box[n_boxes][6],
 *           f64 arm_height[6], u32 flags, u32 level[n_boxes]; versions 1 and 2 end after arm_height
 *           (0, levels by width); flags: 1 no closure, 2 sharp core surface (not in version 3)
 *   CTRL    u32 n, f64 control[n][4]: inner functions, then the layer R-; the layer R is FUNC
 *   INFO    f64 start_worst
 *
 * Nothing derived is stored: T-mesh, space and extraction are built anew from these. So equal
 * solids are equal files, and a reader cannot be told two stories. */
#ifndef TSI_TSOLID_FORMAT_H
#define TSI_TSOLID_FORMAT_H

#define TSI_TSOLID_MAGIC "\x89TSOL\r\n\x1a" /* breaks visibly when taken for text */

enum { TSI_TSOLID_MAGIC_SIZE = 8, TSI_TSOLID_VERSION = 4, TSI_TSOLID_SECTION_FRAME = 16 };

#endif
