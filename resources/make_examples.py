#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes the example parts as .tsb files and, through FreeCAD, as STEP and BREP.

    make_examples.py [--out DIR] [--part NAME]... [--random N] [--seed S] [--step]

Without --part all named parts are written; --random N adds N random parts of the seed, which is
printed. --step needs FreeCAD (the command freecadcmd, or what TSOLID_FREECADCMD names).
"""
import argparse
import json
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)

from examples.parts import PARTS  # noqa: E402
from examples.random_parts import DEFAULT_SEED, random_part  # noqa: E402
from examples.splines import write_tsb  # noqa: E402

# FreeCAD's own options would swallow ours: they travel in the environment.
LAUNCH = ("import json,os,sys; sys.path.insert(0, os.environ['TSOLID_EXAMPLES']); "
          "from examples.shapes import run; run(json.loads(os.environ['TSOLID_EXAMPLE_JOBS']))")


def write_shapes(paths):
    """Has FreeCAD turn .tsb files into .step and .brep beside them."""
    environment = dict(os.environ, TSOLID_EXAMPLES=HERE, TSOLID_EXAMPLE_JOBS=json.dumps(paths))
    command = [os.environ.get("TSOLID_FREECADCMD", "freecadcmd"), "-c", LAUNCH]
    return subprocess.run(command, env=environment, stdin=subprocess.DEVNULL).returncode


def main():
    parser = argparse.ArgumentParser(description="Writes the example parts.")
    parser.add_argument("--out", default=os.path.join(HERE, "examples"))
    parser.add_argument("--part", action="append", choices=sorted(PARTS), default=[])
    parser.add_argument("--random", type=int, default=0, metavar="N")
    parser.add_argument("--seed", default=DEFAULT_SEED)
    parser.add_argument("--step", action="store_true")
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    jobs = [(name, PARTS[name]) for name in options.part or ([] if options.random else PARTS)]
    if options.random:
        print("seed %s" % options.seed)
    jobs += [("random_%02d" % k, lambda k=k: random_part(options.seed, k))
             for k in range(options.random)]
    paths = []
    for name, make in jobs:
        paths.append(os.path.join(options.out, name + ".tsb"))
        write_tsb(make(), paths[-1])
        print(paths[-1])
    return write_shapes(paths) if options.step else 0


if __name__ == "__main__":
    sys.exit(main())
