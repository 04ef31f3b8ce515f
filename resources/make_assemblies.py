#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes the example assemblies: one folder each, with one .tsb file per part.

    make_assemblies.py --out DIR [--assembly NAME]...

Without --assembly all of them are written.
"""
import argparse
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)

from examples.assemblies import ASSEMBLIES  # noqa: E402
from examples.cube_mesh import CubeMesh, write_model  # noqa: E402
from examples.splines import write_tsb  # noqa: E402


def write(part, path):
    if isinstance(part, CubeMesh):
        write_model(part, path, "patches")
    else:
        write_tsb(part, path)


def main():
    parser = argparse.ArgumentParser(description="Writes the example assemblies.")
    parser.add_argument("--out", required=True)
    parser.add_argument("--assembly", action="append", choices=sorted(ASSEMBLIES), default=[])
    options = parser.parse_args()
    for name in options.assembly or ASSEMBLIES:
        folder = os.path.join(options.out, name)
        os.makedirs(folder, exist_ok=True)
        for part, patches in ASSEMBLIES[name]().items():
            write(patches, os.path.join(folder, part + ".tsb"))
        print(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
