# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the Python tests share: where things are, a cube of patches, a runner with a closing line."""

import glob
import os
import sys
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PACKAGE = os.path.join(ROOT, "freecad_workbench")
sys.path.insert(0, PACKAGE)

from freecad.tsolid import binding, header, library  # noqa: E402,F401


def library_path():
    """The library under test: TSOLID_LIBRARY, or the newest build tree of this checkout."""
    given = os.environ.get("TSOLID_LIBRARY")
    if given:
        return given
    built = glob.glob(os.path.join(ROOT, "build*", "libtsolid.so"))
    if not built:
        raise unittest.SkipTest("set TSOLID_LIBRARY, or build into %s/build" % ROOT)
    return max(built, key=os.path.getmtime)


def cube(place=lambda x, y, z: (x, y, z)):
    """Six bilinear patches of the unit cube, corners moved by `place`, with names as FreeCAD's."""
    vertices, edges = [], []

    def name(pool, key, word):
        if key not in pool:
            pool.append(key)
        return "%s%d" % (word, pool.index(key) + 1)

    patches = []
    for side in range(6):
        axis, end = divmod(side, 2)
        a, b = (i for i in range(3) if i != axis)
        corners = []
        for u, v in ((0, 0), (1, 0), (0, 1), (1, 1)):
            x = [0, 0, 0]
            x[axis], x[a], x[b] = end, u, v
            corners.append(tuple(x))
        loop = [corners[i] for i in (0, 1, 3, 2)]
        borders = [frozenset((loop[i], loop[(i + 1) % 4])) for i in range(4)]
        patches.append(
            binding.Patch(
                (1, 1),
                (2, 2),
                ((0.0, 0.0, 1.0, 1.0),) * 2,
                [tuple(float(c) for c in place(*x)) for x in corners],
                name="Face%d" % (side + 1),
                border_names=[name(edges, e, "Edge") for e in borders],
                corner_names=[name(vertices, x, "Vertex") for x in loop],
            )
        )
    return patches


def run(module):
    """Runs a module's tests; prints `N passed, N failed` and returns the exit code."""
    suite = unittest.defaultTestLoader.loadTestsFromModule(module)
    pattern = sys.argv[1] if len(sys.argv) > 1 else ""
    chosen = unittest.TestSuite(t for s in suite for t in s if pattern in t.id())
    result = unittest.TextTestRunner(verbosity=2).run(chosen)
    bad = len(result.failures) + len(result.errors)
    skipped = "" if not result.skipped else ", %d skipped" % len(result.skipped)
    print("%d passed, %d failed%s" % (result.testsRun - bad - len(result.skipped), bad, skipped))
    return 1 if bad else 0
