#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Poisson's equation with a smooth solution on the wavy cube, before and after an exact refinement
of the input: the error falls with order 3.5 in L2 and 2.7 in energy at least.

Elasticity is in long_convergence.py. The right-hand side, the boundary values and the
errors come from galerkin_parts.py, only the matrix from the library."""

import math
import sys
import unittest

import binding_parts
import galerkin_parts

L2_ORDER, ENERGY_ORDER = 3.5, 2.7


def orders(name, make, levels):
    """log2 of the ratios of errors from one refinement to the next."""
    errors = []
    for level in levels:
        galerkin = galerkin_parts.Galerkin(galerkin_parts.build(name, level), extra=1)
        errors.append(galerkin_parts.relative_errors(galerkin, make))
        print(
            "%s, %s, %d refinements, %d functions: L2 %.3e, energy %.3e"
            % ((name, make.__name__, level, galerkin.n) + errors[-1]),
            flush=True,
        )
    return [[math.log2(a / b) for a, b in zip(x, y)] for x, y in zip(errors, errors[1:])]


class Convergence(unittest.TestCase):
    problem = galerkin_parts.Poisson

    def test_wavy_cube(self):
        ((l2, energy),) = orders("wavy_cube", self.problem, (0, 1))
        print("orders: L2 %.2f, energy %.2f" % (l2, energy))
        self.assertGreaterEqual(l2, L2_ORDER)
        self.assertGreaterEqual(energy, ENERGY_ORDER)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
