#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes the models that stand for the paper's table 1: T-spline boundaries with T-junctions.

    make_models.py [--out DIR] [--model NAME]...

Each as .tsm (half-edges, multiple knots as edges of interval 0) and as .tsb (its Bezier elements);
the blade of NURBS as a .tsb of six patches.
"""
import argparse
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)

from examples.cube_mesh import write_bezier_tsb, write_tsm  # noqa: E402
from examples.models import MODELS, blade_nurbs  # noqa: E402
from examples.splines import write_tsb  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description="Writes the models of table 1.")
    parser.add_argument("--out", default=".")
    names = sorted(MODELS) + ["blade_nurbs"]
    parser.add_argument("--model", action="append", choices=names, default=[])
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    for name in options.model or names:
        path = os.path.join(options.out, name)
        if name == "blade_nurbs":
            write_tsb(blade_nurbs(), path + ".tsb")
        else:
            mesh = MODELS[name]()
            write_tsm(mesh, path + ".tsm")
            write_bezier_tsb(mesh, path + ".tsb")
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
