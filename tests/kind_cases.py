# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests that run inside FreeCADCmd (started by test_kinds.py and long_kinds.py): parts of all kinds
from freecad_kinds.py, their verdicts, their solids, and the same through files."""

import math
import os
import re
import sys
import tempfile
import unittest

import binding_parts

binding_parts.join_freecad()

import FreeCAD  # noqa: E402
import Part  # noqa: E402

import nets  # noqa: E402
import shared_parts  # noqa: E402

from freecad.tsolid import api, binding, convert, sewing  # noqa: E402
from freecad_kinds import GAPS, REFUSED, TAKEN, chamfered, cut_circle  # noqa: E402

# FreeCAD's IGES reader gives no face for an extruded parabola.
LOST_BY_IGES = ("extruded parabola",)
# Opposite edges get knots that differ in the tenth digit: one net has one more span, hardly wide.
SPLIT_BY_IGES = ("scaled",)
# one of each way in which faces are taken
QUICK = ("cut obliquely", "quarter cylinder", "hemisphere", "mirrored", "L", "bent bar", "lens",
         "far from the origin")


def corner_points(patch):
    n, m = patch.n_control
    return [patch.points[i + n * j] for i in (0, n - 1) for j in (0, m - 1)]


class Verdicts(unittest.TestCase):
    """Every kind gets the verdict beside it; the refused ones with the reason and the place."""

    def test_refused(self):
        self.assertGreaterEqual(len(REFUSED), 20)
        for name, (make, words) in REFUSED.items():
            with self.subTest(name):
                result = api.check(make())
                self.assertFalse(result.satisfied)
                for word in words:
                    self.assertRegex(result.text(), word)

    def test_taken(self):
        self.assertGreaterEqual(len(TAKEN), 20)
        for name, make in TAKEN.items():
            with self.subTest(name):
                result = api.check(make())
                self.assertTrue(result.satisfied, result.text())


class Corners(unittest.TestCase):
    """The choice of eight vertices: told, the same for the same part, and the caller's if given."""

    def chosen(self, shape, corners=()):
        _, notes = convert.sources_of_shape(shape, corners=corners)
        told = [n.text for n in notes if "possible cube" in n.text]
        return told[0] if told else ""

    def test_more_than_one_cube_is_told(self):
        text = self.chosen(chamfered())
        self.assertRegex(text, r"the part has 5 possible cubes; taken: Vertex\d+(, Vertex\d+){7}$")
        self.assertEqual(self.chosen(TAKEN["box"]()), "")

    def test_choice_does_not_depend_on_the_order_of_faces(self):
        """Nor on their orientation: the same solid from shuffled faces has the same corners."""
        shape = chamfered()
        again = Part.makeSolid(Part.makeShell(shape.Faces[::-1]))
        places = []
        for solid in (shape, again):
            names = re.findall(r"Vertex\d+", self.chosen(solid))
            self.assertEqual(len(names), 8)
            points = [solid.getElement(name).Point for name in names]
            places.append(sorted(tuple(round(x, 9) for x in p) for p in points))
        self.assertEqual(places[0], places[1])

    def test_given_corners_are_taken(self):
        shape = chamfered()
        first = set(re.findall(r"Vertex\d+", self.chosen(shape)))
        other = next("Vertex%d" % k for k in range(1, 11) if "Vertex%d" % k not in first)
        text = self.chosen(shape, [other])
        self.assertRegex(text, "the part has 4 possible cubes")
        taken = re.findall(r"Vertex\d+", text)
        self.assertIn(other, taken)
        self.assertEqual(self.chosen(shape, taken), "")  # no choice is left
        result = api.build(shape, effort="quick", corners=[other])
        self.assertTrue(result.proved, result.text())
        corners = result.boundary.requirement["corner"]
        want = shape.getElement(other).Point
        far = min(max(abs(a - b) for a, b in zip(want, c)) for c in corners)
        self.assertLess(far, 1e-9)

    def test_vertices_of_a_circle_are_taken_where_they_fit(self):
        """Corners a quarter turn apart, on two of the vertices at 0, 40, 90, 130 and 275 degrees
        if they can be; where none fits, one stays where the sphere's seam ends."""
        for degrees, first in (((40, 90, 130), 0), ((40, 130, 275), 40), ((50, 100, 275), 0)):
            sources, _ = convert.sources_of_shape(cut_circle(*degrees))
            flat = next(s for s in sources if len(s.patches) == 1)
            found = [math.degrees(math.atan2(p[1], p[0])) for p in corner_points(flat.patches[0])]
            want = [first + 90.0 * k for k in range(4)]
            far = [min(abs(math.remainder(a - b, 360.0)) for b in want) for a in found]
            self.assertLess(max(far), 1e-6)
            named = [name for name in flat.patches[0].corner_names if name]
            self.assertEqual(len(named), sum(a % 360 in (0,) + degrees for a in want))

    def test_far_from_the_origin_as_at_the_origin(self):
        """A cylinder a hundred thousand times its size away has the same layout."""
        patches = []
        for base in (FreeCAD.Vector(), FreeCAD.Vector(1e5, 2e5, -3e5)):
            shape = Part.makeCylinder(3, 10, base, FreeCAD.Vector(1, 2, 3))
            sources, _ = convert.sources_of_shape(shape)
            patches.append([p for s in sources for p in s.patches])
            for patch in patches[-1]:
                patch.points = [FreeCAD.Vector(*p) - base for p in patch.points]
        self.assertEqual(len(patches[0]), 6)
        self.assertLess(nets.difference(*map(nets.nets_of, patches)), 1e-9)

    def test_impossible_corners_are_refused(self):
        shape = chamfered()
        five = "5 vertices of the face .* would have to be corners; a side of the cube has four"
        for corners, words in ((["Vertex99"], "no such vertex"),
                               (self.five_of_one_face(shape), five)):
            with self.assertRaises(binding.Refused) as caught:
                self.chosen(shape, corners)
            self.assertRegex(str(caught.exception), words)

    def five_of_one_face(self, shape):
        """All vertices of a pentagon: four can be corners."""
        face = next(f for f in shape.Faces if len(f.Vertexes) == 5)
        return ["Vertex%d" % k for k, v in enumerate(shape.Vertexes, 1)
                if any(v.isSame(w) for w in face.Vertexes)]


class Building(unittest.TestCase):
    """Taken kinds become solids with a positive certificate, exact and of the right volume."""

    names = QUICK

    def test_solids(self):
        self.assertGreater(len(self.names), 0)
        for name in self.names:
            with self.subTest(name):
                self.check(TAKEN[name](), GAPS.get(name, 2e-13))

    def check(self, shape, gap=2e-13):
        """gap: the most that may be declared of the volume."""
        result = api.build(shape, effort="quick")
        self.assertEqual(result.verdict, "positive", result.text())
        report = result.report
        faces = [row["face"] for row in report["exactness"]]
        self.assertEqual(faces, ["Face%d" % (k + 1) for k in range(len(shape.Faces))])
        scale = report["conformity"]["scale"]
        for row in report["exactness"]:
            self.assertEqual(row["samples"], 1000)
            self.assertLessEqual(row["declared"], 1e-11 * scale, row)
            self.assertLessEqual(row["distance"], 1e-12 * scale + row["declared"], row)
        volume = report["volume"]
        self.assertLessEqual(volume["declared"], gap)
        self.assertLessEqual(volume["relative_difference"], 1e-12 + volume["declared"])
        # OCC's own volume is no evidence, but it is not far off (0.9 % on a tube of one face)
        self.assertAlmostEqual(report["volume"]["quadrature"] / shape.Volume, 1.0, delta=1e-2)


class AllSolids(Building):
    names = tuple(TAKEN)


class Shared(Building):
    """Parts made of published skins, when ../shared/data is there."""

    test_solids = None

    def setUp(self):
        if not os.path.exists(shared_parts.DATA):
            self.skipTest("%s is not there" % shared_parts.DATA)

    def test_hull(self):
        self.check(shared_parts.hull())

    def test_blade(self):
        self.check(shared_parts.blade())

    def test_blade_as_published(self):
        """420 spans along each skin, most on other places than the other skin's: taken."""
        shape = shared_parts.blade(thinned=False)
        result = api.check(shape)
        self.assertTrue(result.satisfied, result.text())
        sources, _ = convert.sources_of_shape(shape)
        self.assertEqual([s.deviation for s in sources], [0.0] * 6)


class RoundTrips(unittest.TestCase):
    """The same verdict and the same nets through files, but for the digits that they keep."""

    # of the scale: FreeCAD writes twelve digits into STEP, ten into IGES, and there splines within
    # 1e-5 of circles, by which corners on edges are found
    DIGITS = {"brep": 1e-13, "step": 2e-12, "igs": 1e-8}

    def read_back(self, shape, suffix):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "part." + suffix)
            {"brep": shape.exportBrep, "step": shape.exportStep, "igs": shape.exportIges}[suffix](
                path)
            back = Part.Shape()
            back.read(path)
        return back

    def nets(self, shape):
        """All nets. Of faces that got control points of the library's own choice, the result of an
        optimisation, only the borders are compared."""
        sources, notes = convert.sources_of_shape(shape)
        chosen = {n.where for n in notes if "inner control points" in n.text}
        return nets.nets_of([p for s in sources for p in s.patches], chosen)

    def compare(self, shape, back, suffix):
        result = api.check(back)
        self.assertTrue(result.satisfied, result.text())
        scale = convert.scale_of_shape(shape)
        far = nets.difference(self.nets(shape), self.nets(back),
                              scale / shape.BoundBox.DiagonalLength)
        self.assertLessEqual(far, self.DIGITS[suffix] * scale)

    def test_brep(self):
        for name, make in TAKEN.items():
            with self.subTest(name):
                shape = make()
                self.compare(shape, self.read_back(shape, "brep"), "brep")

    def test_step(self):
        for name, make in TAKEN.items():
            with self.subTest(name):
                shape = make()
                self.compare(shape, self.read_back(shape, "step"), "step")

    def test_iges(self):
        for name, make in TAKEN.items():
            with self.subTest(name):
                shape = make()
                loose = self.read_back(shape, "igs")
                back, notes = sewing.sewn(loose)
                if name in LOST_BY_IGES:
                    self.assertLess(len(loose.Faces), len(shape.Faces))
                    self.assertEqual(notes, [])
                    continue
                self.assertEqual(len(notes), 1)
                self.assertLessEqual(notes[0].measured, 1e-6)
                if name in SPLIT_BY_IGES:
                    self.assertTrue(api.check(back).satisfied)
                    continue
                self.compare(shape, back, "igs")


class ThroughIges(unittest.TestCase):
    """Parts of ten digits, read back and built: what they lack is declared."""

    names = ("cylinder", "wavy extrusion", "hemisphere", "lens", "capsule", "scaled", "slot",
             "far from the origin")

    def check(self, name):
        loose = RoundTrips.read_back(self, TAKEN[name](), "igs")
        result = api.build(sewing.sewn(loose)[0], effort="quick")
        self.assertEqual(result.verdict, "positive", result.text())
        report = result.report
        for row in report["exactness"]:
            self.assertLessEqual(row["distance"], row["allowed"], row)
            self.assertLessEqual(row["declared"], 1e-8 * report["conformity"]["scale"], row)

    def test_solids(self):
        for name in self.names:
            with self.subTest(name):
                self.check(name)


if __name__ == "__main__":
    code = binding_parts.run(sys.modules[__name__])
    sys.stdout.flush()
    os._exit(binding_parts.EXIT_BASE + code)
