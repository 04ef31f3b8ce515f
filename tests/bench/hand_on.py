#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Seconds and peak memory of what hands a solid on: hexahedra and matrices, by size.

    hand_on.py [--hexes N]... [--functions N]... [--threads N]

Default: 10^4, 10^5, 10^6 hexahedra of the wavy cube; 10^3, 10^4, 10^5 functions (of wavy cubes with
more and more spans) for the mass, Laplace and elasticity matrices. Not a test: nothing is judged.
Each line is a process of its own: seconds by the clock, seconds of all processors together, the
process's largest memory less that before the step, and microseconds of processors per hexahedron or
per Bezier element of the solid, of which larger solids have more for each function.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

import example_chain  # noqa: E402,F401  (puts resources on the path)
from binding_parts import binding  # noqa: E402

from examples.parts import wavy_cube  # noqa: E402
from examples.splines import write_tsb  # noqa: E402
from freecad.tsolid import analysis  # noqa: E402

KINDS = ("mass", "laplace", "elasticity")
SPANS = {1000: 3, 10000: 18, 100000: 64}


def mebibytes():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def build(spans, path, threads):
    """The start only: what is measured does not depend on the quality of the elements."""
    context = binding.Context(threads=threads)
    write_tsb(wavy_cube(spans), path + ".tsb")
    boundary = binding.Boundary.from_file(context, path + ".tsb")
    space = binding.Space.create(context, boundary, binding.TMesh.create(context, boundary))
    binding.Solid.create(context, space).write(context, path)


def step(what, size, path, threads):
    """One measurement, in a process of its own; prints its line."""
    context = binding.Context(threads=threads)
    solid = binding.Solid.read(context, path)
    before, start, busy = mebibytes(), time.perf_counter(), time.process_time()
    if what == "hexes":
        n = max(2, round((size / 2.5) ** (1 / 3)))  # the core and two layers of n / 4 on six sides
        options = {"divisions": (n, n, n, n // 4), "max_elements": 10 * size}
        mesh = analysis.HexMesh.create(context, solid, allow_unproved=True, **options)
        count, entries = len(mesh.elements), len(mesh.nodes)
    else:
        matrix = analysis.Matrix.create(context, solid, KINDS.index(what), 210e3, 0.3)
        count, entries = solid.space.n_functions, len(matrix.arrays()[1])
    seconds, memory = time.perf_counter() - start, mebibytes() - before
    busy, elements = time.process_time() - busy, solid.space.n_elements
    each = count if what == "hexes" else elements
    print(
        "%-12s %10d %10d %12d %9.2f %9.2f %9.0f %12.1f"
        % (what, count, elements, entries, seconds, busy, memory, 1e6 * busy / each),
        flush=True,
    )


def run(what, size, path, threads):
    line = [sys.executable, os.path.abspath(__file__), "--step", what, str(size), path]
    subprocess.run(["sh", "-c", '"$@"; exit $?', "sh"] + line + ["--threads", str(threads)])


def main():
    parser = argparse.ArgumentParser(description="Times what hands a solid on.")
    parser.add_argument("--hexes", action="append", type=int, default=[])
    parser.add_argument("--functions", action="append", type=int, default=[], choices=SPANS)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--step", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.step:
        what, size, path = options.step
        return step(what, int(size), path, options.threads)
    everything = not options.hexes and not options.functions
    print("%-12s %10s %10s %12s %9s %9s %9s %12s" % (
        "what", "count", "elements", "nodes, nnz", "seconds", "processor", "MiB", "us each"))
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "x.tsolid")
        for size in options.hexes or ([10**4, 10**5, 10**6] if everything else []):
            build(6, path, options.threads)
            run("hexes", size, path, options.threads)
        for size in options.functions or (SPANS if everything else []):
            build(SPANS[size], path, options.threads)
            for kind in KINDS:
                run(kind, size, path, options.threads)


if __name__ == "__main__":
    sys.exit(main())
