#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Orders as in test_convergence.py, of linear elasticity, and of Poisson's equation over three
levels of the sphere (15,000 functions)."""

import sys

import binding_parts
import galerkin_parts
import test_convergence


class Elasticity(test_convergence.Convergence):
    problem = galerkin_parts.Elasticity


class ThreeLevels(test_convergence.Convergence):
    test_wavy_cube = None

    def test_sphere(self):
        self.check("sphere", (0, 1, 2))


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
