#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sharp isolines and corners in .tsm, as edges of interval 0: the same boundary as by T-spline
patches and by Bezier elements, and as an evaluator that is not the library's has it; which surface
results round stars, and what is refused."""
import os
import random
import shutil
import sys
import tempfile
import unittest

import numpy as np

import binding_parts
from binding_parts import binding, library
from freecad.tsolid.surface import Surface
from model_chain import ModelChain

from examples.cube_mesh import CubeMesh, write_model, write_tsm
from examples.models import MODELS, mouse_shape, set_points, sharp
from tsm_surface import TsmSurface

ROUND_OFF = 1e-14


def sharp_foot():
    """Sharp along four isolines only: at four corners two sharp ones meet a smooth one."""
    lines = [sharp(range(5)), sharp(range(6)), [0.0] + list(range(6))]

    def present(axis, i, point):
        return axis == 2 or 0 < lines[axis][i] < lines[axis][-1] or point[2] == 0

    return set_points(CubeMesh(lines, present), mouse_shape)


MESHES = dict({name: MODELS[name] for name in ("mouse", "boat", "blade_tspline")},
              sharp_foot=sharp_foot)
SMOOTH_CORNERS = {"mouse": 4, "boat": 0, "blade_tspline": 0, "sharp_foot": 4}
OTHER_CARRIERS = {"mouse": ("elements",), "boat": ("elements", "patches"),
                  "blade_tspline": ("elements", "patches"), "sharp_foot": ("elements",)}


def functions_by_point(boundary, side):
    """{box of an element: {control point: 4 x 4 coefficients, s first}}."""
    points = [tuple(row) for row in boundary.points.tolist()]
    assert len(set(points)) == len(points)
    return {tuple(e.box): {points[f]: np.array(c).reshape(4, 4).T
                           for f, c in zip(e.functions, e.coefficients)}
            for e in boundary.elements(side)}


def turned(elements, way):
    """With s and t exchanged and reversed."""
    swap, flip = way & 1, (way >> 1 & 1, way >> 2 & 1)
    out = {}
    for box, nets in elements.items():
        ranges = [(1 - box[2 * d + 1], 1 - box[2 * d]) if flip[d] else box[2 * d:2 * d + 2]
                  for d in (0, 1)]
        ranges = ranges[::-1] if swap else ranges
        turned_nets = {}
        for point, net in nets.items():
            net = net[::-1 if flip[0] else 1, ::-1 if flip[1] else 1]
            turned_nets[point] = net.T if swap else net
        out[tuple(ranges[0] + ranges[1])] = turned_nets
    return out


def apart(one, other):
    """Largest difference of boxes and coefficients; infinite where elements have no partner."""
    worst, nothing = 0.0, np.zeros((4, 4))
    if len(one) != len(other):
        return np.inf
    for (box, nets), (box2, nets2) in zip(sorted(one.items()), sorted(other.items())):
        worst = max(worst, np.abs(np.subtract(box, box2)).max())
        if worst > 1e-9:
            return np.inf
        for point in set(nets) | set(nets2):
            gap = nets.get(point, nothing) - nets2.get(point, nothing)
            worst = max(worst, np.abs(gap).max())
    return worst


class SharpTest(unittest.TestCase):
    made = {}

    def meshes(self):
        """All of them with their names, made once."""
        for name, make in MESHES.items():
            if name not in self.made:
                self.made[name] = make()
            yield name, self.made[name]

    def setUp(self):
        self.context = binding.Context(library=library.load(binding_parts.library_path()))
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def read(self, mesh):
        write_tsm(mesh, self.path("part.tsm"))
        return Surface.read(self.context, self.path("part.tsm"))

    def notes(self):
        return [f for f in self.context.findings() if "template" in f.text]

    def test_same_boundary_as_other_carriers(self):
        for name, mesh in self.meshes():
            mine = binding.Boundary.from_surface(self.context, self.read(mesh))
            self.assertEqual(mine.requirement["satisfied"], 1)
            for carrier in OTHER_CARRIERS[name]:
                with self.subTest("%s as %s" % (name, carrier)):
                    write_model(mesh, self.path("part.tsb"), carrier)
                    other = binding.Boundary.from_file(self.context, self.path("part.tsb"))
                    self.check_same(mine, other)

    def check_same(self, mine, other):
        self.assertEqual(sorted(mine.points.tolist()), sorted(other.points.tolist()))
        theirs = [functions_by_point(other, side) for side in range(6)]
        for side in range(6):
            elements = functions_by_point(mine, side)
            best = min(apart(turned(elements, way), their) for their in theirs
                       for way in range(8))
            self.assertLess(best, ROUND_OFF)

    def test_same_surface_as_the_twin(self):
        """At random points and at the corners of all faces."""
        for name, mesh in self.meshes():
            with self.subTest(name):
                surface, draw = self.read(mesh), random.Random(name)
                with open(self.path("part.tsm"), encoding="utf-8") as source:
                    twin = TsmSurface(source.read())
                self.assertLess(surface.facts()["sum_defect"], 1e-14)
                scale, checked = np.abs(twin.points[:, :3]).max(), 0
                for face, (w, h) in enumerate(surface.face_sizes.tolist()):
                    if not (w > 0 and h > 0):
                        continue
                    inside = [(w * draw.random(), h * draw.random()) for _ in range(2)]
                    for u, v in [(0, 0), (w, 0), (w, h), (0, h)] + inside:
                        mine = surface.evaluate(self.context, face, u, v)[0]
                        gap = np.abs(np.subtract(mine, twin.on_face(face, u, v)[:3])).max()
                        self.assertLess(gap, ROUND_OFF * scale)
                        checked += 1
                self.assertGreater(checked, 300)

    def test_sharp_corners_are_control_points(self):
        for name, mesh in self.meshes():
            with self.subTest(name):
                boundary = binding.Boundary.from_surface(self.context, self.read(mesh))
                given = {tuple(p) for p in mesh.points.tolist()}
                hits = sum(tuple(c) in given for c in boundary.requirement["corner"])
                self.assertEqual(hits, 8 - SMOOTH_CORNERS[name])

    def test_smooth_stars_are_noted_and_sharp_ones_not(self):
        for name, mesh in self.meshes():
            with self.subTest(name):
                self.context.clear()
                surface, n = self.read(mesh), SMOOTH_CORNERS[name]
                notes = self.notes()
                self.assertEqual(len(notes), 1 if n else 0)
                if n:
                    stars = [s for s, _ in surface.facts()["extraordinary"]]
                    named = [int(w.strip(",")) for w in notes[0].text.split("(")[0].split()
                             if w.strip(",").isdigit()]
                    self.assertEqual(len(named), n)
                    self.assertLessEqual(set(named), set(stars))
                    self.assertIn("(three edges each)", notes[0].text)
                    self.assertIn("within one ring of faces", notes[0].text)
                    self.assertEqual(notes[0].severity, binding.Severity.NOTE)

    def test_no_note_for_patches_and_elements(self):
        for carrier in ("elements", "patches"):
            write_model(MODELS["boat"](), self.path("part.tsb"), carrier)
            binding.Boundary.from_file(self.context, self.path("part.tsb"))
        self.assertEqual(self.notes(), [])

    def check_refused(self, mesh, words):
        with self.assertRaises(binding.Refused) as caught:
            self.read(mesh)
        self.assertRegex(str(caught.exception), words)

    def test_half_sharp_corners_are_refused(self):
        """Knots doubled along one axis or two: at every corner some edges have interval 0."""
        n = range(6)
        even = [0.0, 0.0, 1.0, 2.0, 3.0, 3.0]
        for doubled, zero in ((1, 1), (2, 2)):
            lines = [even if a < doubled else [float(k) for k in n] for a in range(3)]
            self.check_refused(set_points(CubeMesh(lines), mouse_shape),
                               r"Vertex \d+ is half sharp: %d of its 3 edges" % zero)

    def test_slits_near_smooth_stars_are_refused(self):
        lines = [[0.0, 1.0, 1.0, 2.0, 3.0, 4.0]] + [[float(k) for k in range(6)]] * 2
        self.check_refused(set_points(CubeMesh(lines), mouse_shape),
                           r"Face \d+ has no area, too near to a star that is not sharp")

    def test_built_from_half_edges(self):
        """Without optimisation; with it and the others: long_models.py."""
        chain = ModelChain("mouse", self.folder.name, "--effort", "none", carrier="tsm")
        self.assertEqual(chain.failures(0.05), [])
        self.assertEqual(chain.text.count("note: Round vertices"), 1)
        noted = [f["text"] for f in chain.report["findings"] if f["severity"] == "note"]
        self.assertEqual(sum(text.startswith("Round vertices") for text in noted), 1)

    @unittest.skipUnless(shutil.which(binding_parts.FREECAD), "FreeCADCmd was not found")
    def test_freecad_passes_the_note_on(self):
        self.read(MODELS["mouse"]())
        (note,) = self.notes()
        code, text = binding_parts.run_in_freecad("freecad_notes.py", self.path("part.tsm"))
        self.assertEqual(code, 0, text)
        self.assertIn("kept: " + note.text, text)
        self.assertIn("found: " + note.text, text)
        self.assertIn("by a button: " + note.text, text)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
