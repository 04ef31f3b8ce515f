#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The picture of the T-mesh: well-formed, every T-junction of the three visible sides is there
once, the cells in it fill the shapes they should, and the legend's counts are the report's."""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from example_chain import command_path  # noqa: E402

from examples.parts import wavy_cube  # noqa: E402
from examples.splines import write_tsb  # noqa: E402

SVG = "{http://www.w3.org/2000/svg}"
SPANS = 6
SIZE = 23000.0  # of the cube's edges in the picture


def area(path):
    points = [tuple(map(float, p.split())) for p in re.findall(r"[ML](-?\d+ -?\d+)", path)]
    return abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(points, points[1:] + points[:1]))) / 2


class PictureTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        names = ("p.tsb", "p.tsolid", "p.json", "p.svg", "q.svg")
        part, solid, report, picture, again = (os.path.join(cls.folder.name, n) for n in names)
        write_tsb(wavy_cube(SPANS), part)
        subprocess.run([command_path(), "build", part, "-o", solid, "--report", report, "--effort",
                        "none"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for path in (picture, again):
            subprocess.run([command_path(), "export", solid, "--tmesh", path], check=True)
        with open(report, encoding="utf-8") as source:
            cls.statistics = json.load(source)["statistics"]
        cls.panels = ElementTree.parse(picture).getroot().findall(SVG + "g")
        cls.bytes = []
        for path in (picture, again):
            with open(path, "rb") as source:
                cls.bytes.append(source.read())

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def filled(self, panel):
        paths = self.panels[panel].iter(SVG + "path")
        return sum(area(p.get("d")) for p in paths if p.get("fill") != "none")

    def test_same_bytes(self):
        self.assertEqual(*self.bytes)

    def test_junctions(self):
        # per face (n+1)^2 corners but the four of the cube
        dots = [len(list(panel.iter(SVG + "circle"))) for panel in self.panels[:3]]
        self.assertEqual(dots[0], 3 * ((SPANS + 1) ** 2 - 4))
        # without the quarter above the cut: lines 4 to n of 7 in both directions, one is a corner
        self.assertEqual(dots[1], 3 * ((SPANS + 1) ** 2 - 4 - (3 * 3 - 1)))
        self.assertEqual(dots[2], 4 * (SPANS - 1))

    def test_areas(self):
        hexagon = 3.0 * SIZE ** 2 * 0.8660254  # three rhombs of side SIZE
        self.assertAlmostEqual(self.filled(0) / hexagon, 1.0, delta=2e-3)
        self.assertAlmostEqual(self.filled(1) / hexagon, 1.0, delta=2e-3)
        self.assertAlmostEqual(self.filled(2) / (1.6 * SIZE) ** 2, 1.0, delta=2e-3)

    def test_legend(self):
        text = " ".join(t.text for t in self.panels[3].iter(SVG + "text"))
        shown = {int(a): int(b) for a, b in re.findall(r"level (\d+): (\d+)", text)}
        levels = self.statistics["core_cells_of_level"]
        self.assertEqual({k: n for k, n in enumerate(levels) if k in shown}, shown)
        self.assertEqual(sum(shown.values()), self.statistics["core_cells"])


if __name__ == "__main__":
    result = unittest.main(exit=False).result
    bad = len(result.failures) + len(result.errors)
    print("%d passed, %d failed" % (result.testsRun - bad, bad))
    sys.exit(1 if bad else 0)
