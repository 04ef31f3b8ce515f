#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""How soon a build in FreeCAD can be cancelled: the longest time between two calls of progress, in
which nothing asks for it, for every example part, and where.

    cancel.py [NAME]...

Not a test: nothing is judged. Run it on an idle machine.
"""

import os
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


class Longest:
    def __init__(self):
        self.last = time.perf_counter()
        self.before = "start"
        self.gaps = []

    def __call__(self, stage, fraction):
        now = time.perf_counter()
        place = "%s %d %%" % (stage, 100 * fraction)
        self.gaps.append((now - self.last, self.before, place))
        self.last, self.before = now, place
        return False


def inside(names):
    """In FreeCADCmd."""
    import binding_parts

    binding_parts.join_freecad()
    import FreeCAD

    from freecad.tsolid import actions, files

    for name in names or files.example_names():
        doc = FreeCAD.newDocument("X")
        files.insert(os.path.join(files._examples_folder(), name + ".tsb"), doc.Name)
        longest = Longest()
        start = time.perf_counter()
        result = actions.Job("build", doc.Objects[0]).run(longest).result
        longest("end", 1.0)
        total = time.perf_counter() - start
        seconds, before, place = max(longest.gaps)
        print("%-18s %-10s %7.1f s, longest step %6.3f s: %s to %s"
              % (name, result.verdict, total, seconds, before, place), flush=True)
        FreeCAD.closeDocument(doc.Name)


def main():
    import binding_parts

    code, text = binding_parts.run_in_freecad(
        os.path.join("bench", "cancel.py"), *sys.argv[1:], TSOLID_BENCH_INSIDE="1")
    print("\n".join(line for line in text.splitlines() if "longest step" in line))
    return 0 if code == 0 else 1


if __name__ == "__main__":
    if os.environ.get("TSOLID_BENCH_INSIDE"):
        inside(sys.argv[1:])
        sys.stdout.flush()
        os._exit(40)
    sys.exit(main())
