# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the Python tests share: where things are, a cube of patches, FreeCAD, a runner."""

import glob
import os
import struct
import subprocess
import sys
import unittest
import zlib

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PACKAGE = os.path.join(ROOT, "freecad_workbench")
FREECAD = os.environ.get("TSOLID_FREECADCMD", "freecadcmd")
LAUNCHER = os.path.join(ROOT, "freecad_workbench", "bin", "tsolid-freecad")
EXIT_BASE = 40  # exit codes of what runs inside FreeCADCmd; it has 0 and 1 for ends of its own
SKIPPED = 77  # the exit code that CTest shows as such
sys.path.insert(0, PACKAGE)


def join_freecad():
    """Makes FreeCAD's own package `freecad` find ours: it was imported before our path was set."""
    import freecad

    path = os.path.join(PACKAGE, "freecad")
    if path not in freecad.__path__:
        freecad.__path__.insert(0, path)


if "FreeCAD" in sys.modules:
    join_freecad()

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


def read_example(name):
    """The patches of an example part."""
    path = os.path.join(ROOT, "resources", "examples", name + ".tsb")
    return binding.BoundaryFile.read(binding.Context(), path).patches()


def with_moved_point(data, distance):
    """.tsolid bytes whose first boundary control point is moved along x; checksum put right."""
    start = 8 + 4  # magic, version
    tag, length = data[start : start + 4], struct.unpack_from("<Q", data, start + 4)[0]
    if tag != b"FUNC":
        raise ValueError("the first section is %r" % tag)
    section = bytearray(data[start : start + 12 + length])
    wx, _, _, w = struct.unpack_from("<4d", section, 12 + 4)
    struct.pack_into("<d", section, 12 + 4, wx + w * distance)
    end = start + len(section) + 4
    return data[:start] + bytes(section) + struct.pack("<I", zlib.crc32(section)) + data[end:]


def run_in_freecad(script, *arguments, **environment):
    """Runs a Python file inside FreeCADCmd, once; returns the exit code (less EXIT_BASE) and text.

    FreeCADCmd gives 0 after an exception and opens files named in its arguments, so everything
    travels in the environment, and only codes from EXIT_BASE on come from the script.
    """
    code = (
        "import os, sys, runpy; sys.argv = os.environ['TSOLID_TEST_ARGUMENTS'].split(chr(0x1f)); "
        "sys.path.insert(0, os.path.dirname(sys.argv[0])); "
        "runpy.run_path(sys.argv[0], run_name='__main__')"
    )
    words = [os.path.join(ROOT, "tests", script)] + list(arguments)
    environment = dict(
        os.environ,
        TSOLID_TEST_ARGUMENTS="\x1f".join(words),
        TSOLID_LIBRARY=library_path(),
        PYTHONDONTWRITEBYTECODE="1",
        **environment
    )
    run = subprocess.run(
        [FREECAD, "-c", code],
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    return run.returncode - EXIT_BASE, run.stdout.decode("utf-8", "replace")


def launch(*arguments, cwd=None, **environment):
    """Runs the launcher: exit code, stdout, stderr."""
    given = {"TSOLID_LIBRARY": library_path()}
    given.update(environment)
    run = subprocess.run(
        [LAUNCHER] + list(arguments),
        cwd=cwd,
        env=dict(os.environ, **given),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    return run.returncode, run.stdout.decode(), run.stderr.decode()


def run(module):
    """Runs a module's tests; prints `N passed, N failed` and returns the exit code: 1 also when
    there are none, SKIPPED when all were skipped."""
    suite = unittest.defaultTestLoader.loadTestsFromModule(module)
    pattern = sys.argv[1] if len(sys.argv) > 1 else ""
    chosen = unittest.TestSuite(t for s in suite for t in s if pattern in t.id())
    result = unittest.TextTestRunner(verbosity=2).run(chosen)
    broken = [getattr(t, "test_case", t).id() for t, _ in result.failures + result.errors]
    bad = len(set(broken))  # a test with several bad subtests is one bad test
    skipped = "" if not result.skipped else ", %d skipped" % len(result.skipped)
    passed = max(0, result.testsRun - bad - len(result.skipped))
    print("%d passed, %d failed%s" % (passed, bad, skipped))
    if bad or not result.testsRun:
        return 1
    return 0 if passed else SKIPPED
