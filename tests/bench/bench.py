#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Seconds per stage, peak memory and sizes for the example parts and a scaling series.

    bench.py [--part NAME]... [--spans N]... [--effort E] [--threads N]
    bench.py --growth [--spans N]...    counts, T-mesh time and memory, 8 to 64 spans per side

Not a test: nothing is judged. TSOLID_COMMAND names the command to measure; else the one of the
newest build tree is taken. Run it on an idle machine.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

from example_chain import command_path  # noqa: E402  (its imports put resources on the path)

from examples.parts import PARTS, wavy_cube  # noqa: E402
from examples.splines import write_tsb  # noqa: E402

STAGES = ("boundary", "tmesh", "space", "start", "optimise", "certify", "report", "total")
HEADING = "%-20s %8s %8s " % ("part", "funcs", "elems") + "".join(
    "%9s" % s for s in STAGES) + "%8s %7s" % ("MiB", "worst J")


def measure(name, patches, options):
    """One build; prints its line and returns the report, or None when it was refused."""
    with tempfile.TemporaryDirectory() as folder:
        part, out, report = (os.path.join(folder, n) for n in ("p.tsb", "p.tsolid", "p.json"))
        write_tsb(patches, part)
        # by way of a shell: a process's largest memory starts with that of the one it forked from
        run = subprocess.run(["sh", "-c", '"$@"; exit $?', "sh",
                              command_path(), "build", part, "-o", out, "--report", report,
                              "--effort", options.effort, "--threads", str(options.threads)],
                             stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                             stderr=subprocess.PIPE)
        if run.returncode not in (0, 2):
            print("%-20s %s" % (name, run.stderr.decode("utf-8", "replace").strip()))
            return None
        with open(report, encoding="utf-8") as source:
            facts = json.load(source)
    times, sizes = facts["timing"], facts["statistics"]
    seconds = "".join("%9s" % ("-" if times[s] is None else "%.3f" % times[s]) for s in STAGES)
    print("%-20s %8d %8d %s%8.0f %7.3f%s"
          % (name, sizes["n_functions"], sizes["bezier_elements"], seconds,
             times["peak_memory_mib"], facts["quality"]["worst"],
             "" if run.returncode == 0 else "  not proved"), flush=True)
    return facts


def scaling(options):
    """The wavy cube with more and more spans per side; cost per Bezier element at the end."""
    cost = {}
    for n in options.spans:
        facts = measure("wavy_cube %d spans" % n, wavy_cube(n), options)
        if facts:
            elements = facts["statistics"]["bezier_elements"]
            cost[n] = {s: 1e6 * (facts["timing"][s] or 0.0) / elements for s in STAGES}
    if not cost:
        return
    print("\nmicroseconds per Bezier element, and relative to the first")
    print("%-20s %17s " % ("", "") + "".join("%9s" % s for s in STAGES))
    first = cost[min(cost)]
    for n, row in cost.items():
        print("%-20s %17s " % ("%d spans" % n, "") + "".join("%9.1f" % row[s] for s in STAGES))
        print("%-20s %17s " % ("", "") + "".join(
            "%9s" % ("x %.2f" % (row[s] / first[s]) if first[s] else "-") for s in STAGES))


def growth(options):
    """Does the octree pay: functions, and what the T-mesh costs per function; the start only."""
    options.effort = "none"
    rows = []
    for n in options.spans or [8, 16, 32, 64]:
        facts = measure("wavy_cube %d spans" % n, wavy_cube(n), options)
        if facts:
            rows.append((n, facts))
    print("\n%6s %9s %9s %9s %9s %9s %9s %9s %9s" % (
        "spans", "cells", "functions", "ratio", "closure", "tmesh s", "us/func", "total s", "MiB"))
    before = None
    for n, facts in rows:
        sizes, times = facts["statistics"], facts["timing"]
        functions = sizes["n_functions"]
        print("%6d %9d %9d %9s %9.3f %9.3f %9.1f %9.1f %9.0f" % (
            n, sizes["core_cells"], functions, "%.2f" % (functions / before) if before else "-",
            sizes["tmesh_cells"] / sizes["tmesh_cells_before_closure"], times["tmesh"],
            1e6 * times["tmesh"] / functions, times["total"], times["peak_memory_mib"]), flush=True)
        before = functions


def main():
    parser = argparse.ArgumentParser(description="Times the stages; see the top of the file.")
    parser.add_argument("--part", action="append", choices=sorted(PARTS), default=[])
    parser.add_argument("--spans", action="append", type=int, default=[])
    parser.add_argument("--growth", action="store_true")
    parser.add_argument("--effort", default="default")
    parser.add_argument("--threads", type=int, default=0)
    options = parser.parse_args()
    everything = not options.part and not options.spans
    print(HEADING)
    if options.growth:
        growth(options)
        return 0
    for name in options.part or (PARTS if everything else ()):
        measure(name, PARTS[name](), options)
    options.spans = options.spans or ([4, 8, 16] if everything else [])
    scaling(options)
    return 0


if __name__ == "__main__":
    sys.exit(main())
