#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Linear elasticity with a smooth solution on the wavy cube: orders as in test_convergence.py."""

import sys

import binding_parts
import galerkin_parts
import test_convergence


class Elasticity(test_convergence.Convergence):
    problem = galerkin_parts.Elasticity


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
