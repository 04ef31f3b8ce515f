#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes the models that stand for the paper's table 1: T-spline boundaries with T-junctions.

    make_models.py [--out DIR] [--model NAME]... [--carrier tsm|patches|elements]

As .tsm (half-edges) or as .tsb (T-spline patches, Bezier elements, NURBS patches), whichever fits
the model; --carrier asks for one.
"""
import argparse
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)

from examples.cube_mesh import write_model  # noqa: E402
from examples.models import CARRIERS, MODELS, blade_nurbs, file_of  # noqa: E402
from examples.splines import write_tsb  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description="Writes the models of table 1.")
    parser.add_argument("--out", default=".")
    names = sorted(MODELS) + ["blade_nurbs"]
    parser.add_argument("--model", action="append", choices=names, default=[])
    parser.add_argument("--carrier", choices=("tsm", "patches", "elements"))
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    for name in options.model or names:
        if name == "blade_nurbs":
            path = os.path.join(options.out, name + ".tsb")
            write_tsb(blade_nurbs(), path)
        else:
            carrier = options.carrier or CARRIERS[name]
            path = os.path.join(options.out, file_of(name, carrier))
            write_model(MODELS[name](), path, carrier)
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
