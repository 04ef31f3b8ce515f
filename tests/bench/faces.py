#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Seconds of the boundary stage for closed shells of many faces: grids, and staggered rows whose
corners lie inside their neighbours' edges.

    faces.py [--rows N]...

Not a test: nothing is judged. TSOLID_LIBRARY names the library; else the newest build's is taken.
"""
import argparse
import os
import sys
import time
from math import cos, sin

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

import binding_parts  # noqa: E402
from binding_parts import binding, library  # noqa: E402
from test_tvertices import part_of, patches_of  # noqa: E402

from examples.splines import control_volume, uniform_knots  # noqa: E402


def tube():
    """A long body with waves: one rational cubic patch on each side."""

    def point(x, y, z):
        return [20 * x + 0.1 * sin(3 * y + 2 * z), 3 * y + 0.2 * sin(2.5 * z - x),
                2 * z + 0.1 * cos(3 * x + 2 * y)]

    def weight(x, y, z):
        return 1 + 0.3 * sin(2 * x + 3 * y - z)

    return control_volume(point, (3, 3, 3), [uniform_knots(3, 1)] * 3, weight).faces()


def rows_of(face, n, staggered):
    """n rows of n parts; n + 1 in every other one when staggered."""
    parts = []
    for j in range(n):
        shift = staggered and j % 2
        ends = [0] + [(i + (0.5 if shift else 1)) / n for i in range(n if shift else n - 1)] + [1]
        row = part_of(face, (0, 1), (j / n, (j + 1) / n))
        parts += [part_of(row, pair, (j / n, (j + 1) / n)) for pair in zip(ends, ends[1:])]
    return parts


def main():
    parser = argparse.ArgumentParser(description="Times the boundary stage.")
    parser.add_argument("--rows", action="append", type=int, default=[])
    options = parser.parse_args()
    context = binding.Context(library=library.load(binding_parts.library_path()))
    print("%8s %8s %8s %10s %14s" % ("rows", "faces", "pieces", "seconds", "us per piece"))
    for staggered in (False, True):
        for n in options.rows or (3, 6, 13):
            faces = [p for k, f in enumerate(tube()) for p in rows_of(f, n, staggered and k % 2)]
            patches = patches_of(faces)
            start = time.perf_counter()
            boundary = binding.Boundary.create(context, patches)
            seconds = time.perf_counter() - start
            pieces = boundary.requirement["n_patches"]
            print("%8s %8d %8d %10.3f %14.0f" % ("%d%s" % (n, " +" if staggered else ""),
                                                 len(faces), pieces, seconds,
                                                 1e6 * seconds / pieces), flush=True)
            context.clear()
    return 0


if __name__ == "__main__":
    sys.exit(main())
