#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Every example part through STEP and the launcher, as it is and re-written."""

import glob
import json
import os
import shutil
import sys
import tempfile
import unittest

import binding_parts
from binding_parts import ROOT, run_in_freecad
from test_freecad import launch

SEED = os.environ.get("TSOLID_SEED", "20120713")
PARTS = sorted(
    os.path.basename(path)[: -len(".tsb")]
    for path in glob.glob(os.path.join(ROOT, "resources", "examples", "*.tsb"))
)


class Examples(unittest.TestCase):
    """Positive, exact, and of the right volume, face by face of the file as read."""

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = holder.name

    def build(self, name, kind):
        step, out = (os.path.join(self.folder, x) for x in (name + ".step", "out"))
        code, text = run_in_freecad("freecad_maker.py", kind, step)
        self.assertEqual(code, 0, text)
        code, text, errors = launch("build", step, "--out", out)
        self.assertEqual((code, errors), (0, ""), text)
        with open(os.path.join(out, "report.json"), encoding="utf-8") as stream:
            report = json.load(stream)
        with open(os.path.join(out, name + ".tsolid"), "rb") as stream:
            data = stream.read()
        shutil.rmtree(out)
        return report, data

    def check(self, name, kind):
        report, _ = self.build(name, kind)
        quality, scale = report["quality"], report["conformity"]["scale"]
        far = max(row["distance"] for row in report["exactness"])
        print(
            "%-32s worst %.4f, bound %.4f, ratio %.3f, distance / scale %.1e, volume %.1e, %.1f s"
            % (
                kind,
                quality["worst"],
                quality["bound"],
                quality["ratio"],
                far / scale,
                report["volume"]["relative_difference"],
                report["timing"]["total"],
            ),
            flush=True,
        )
        self.assertEqual(report["verdict"], "positive")
        for row in report["exactness"]:
            self.assertLessEqual(row["distance"], 1e-12 * scale + row["declared"], row)
            self.assertLessEqual(row["declared"], 2e-11 * scale, row)  # what STEP rounds away
        self.assertLessEqual(report["volume"]["relative_difference"], 1e-12)
        self.assertGreaterEqual(quality["ratio"], 0.5)

    def test_as_they_are(self):
        for name in PARTS:
            with self.subTest(name):
                self.check(name, "example:" + name)

    def test_rewritten(self):
        print("seed %s" % SEED)
        for name in PARTS:
            with self.subTest(name):
                self.check(name, "example:%s:%s" % (name, SEED))


if __name__ == "__main__":
    if not shutil.which(binding_parts.FREECAD):
        print("skipped: FreeCADCmd was not found")
        sys.exit(77)
    sys.exit(binding_parts.run(sys.modules[__name__]))
