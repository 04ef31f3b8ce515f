#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Poisson's equation with a smooth solution, before and after an exact refinement of the input.

The error falls with order 3.5 in L2 and 2.7 in energy at least: on the wavy cube, whose surface
decides, by the spans of its sides; on the sphere of six patches, whose inside decides, with a sharp
core surface and the start's map, by the cells across the part.

Each layer has two cells whatever the refinement. So n cells in the core are n + 4 across, and the
levels of 4, 8, 16 divide a cell's size by 1.5 and 1.67, not by 2: counted by level the orders on
the sphere are 3.2, 3.1 in L2 and 2.4, 2.2 in energy.

Elasticity and the third level are in long_convergence.py. The right-hand side, the boundary
values and the errors come from galerkin_parts.py, only the matrix from the library."""

import sys
import unittest

import binding_parts
import galerkin_parts
import numpy

NONE = 1  # the effort: the start's map, which has no more kinks than the functions
L2_ORDER, ENERGY_ORDER = 3.5, 2.7


def build(name, level):
    """A solid, and how many cells are across it. On the sphere as many cells inside as spans on the
    sides; one and two quartic spans per face are too coarse for the solution on the surface."""
    if name == "sphere":
        n = 4 << level
        return galerkin_parts.build(name, level + 2, NONE, n, sharp_core=True), n + 4
    return galerkin_parts.build(name, level), 1 << level


def orders(name, make, levels):
    """(L2, energy) of the last pair of levels and of a straight line through all."""
    cells, errors = [], []
    for level in levels:
        solid, across = build(name, level)
        galerkin = galerkin_parts.Galerkin(solid, extra=1)
        cells.append(across)
        errors.append(galerkin_parts.relative_errors(galerkin, make))
        print(
            "%s, %s, level %d, %d functions: L2 %.3e, energy %.3e"
            % ((name, make.__name__, level, galerkin.n) + errors[-1]),
            flush=True,
        )
    x, y = numpy.log(cells), -numpy.log(errors)
    return (y[-1] - y[-2]) / (x[-1] - x[-2]), numpy.polyfit(x, y, 1)[0]


class Convergence(unittest.TestCase):
    problem = galerkin_parts.Poisson

    def check(self, name, levels):
        pair, line = orders(name, self.problem, levels)
        print("orders, L2 and energy: last pair %.2f %.2f, line %.2f %.2f" % (*pair, *line))
        for found in (pair, line):
            self.assertGreaterEqual(found[0], L2_ORDER)
            self.assertGreaterEqual(found[1], ENERGY_ORDER)

    def test_wavy_cube(self):
        self.check("wavy_cube", (0, 1))

    def test_sphere(self):
        self.check("sphere", (0, 1))


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
