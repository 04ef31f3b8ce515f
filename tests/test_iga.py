#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Six B-spline sides as .iga, which holds neither knots nor neighbours, become the solid of the
same body: positions and points against de Boor's values."""
import os
import sys
import tempfile
import unittest

import numpy as np

import binding_parts
from binding_parts import binding
from example_chain import run_command
from iga_parts import Axis, Body, write_iga

from freecad.tsolid.surface import Surface


def bend(x, y, z):
    """Euclidean control points and weights of a lopsided, bent block."""
    return (
        2.0 * x + 0.2 * y * z,
        1.5 * y + 0.15 * x * x,
        z + 0.2 * x * y,
        1.0 + 0.25 * x * y - 0.2 * z * x,
    )


def straight(x, y, z):
    return 2.0 * x, 1.5 * y, z, 1.0


SMOOTH = (Axis(3, (0.3, 0.4, 0.75)), Axis(3, (0.2, 0.6)), Axis(3, (0.5,)))
MIXED = (Axis(2, (0.25, 0.6)), Axis(3, (0.35,)), Axis(2, (0.5, 0.8)))
# a double knot in a quadratic direction: C^0 there, nothing joins the intervals on its two sides
CREASED = (Axis(2, (0.25, 0.5, 0.5, 0.6)), Axis(2, (0.35,)), Axis(2, (0.5,)))


def element_point(boundary, side, element, u, v):
    p, q = boundary.side_degree(side)
    bu, bv = ([_bernstein(d, k, x) for k in range(d + 1)] for d, x in ((p, u), (q, v)))
    weight = np.outer(bv, bu).ravel()
    points = np.array(boundary.points)
    h = sum(
        float(np.dot(weight, row)) * points[f]
        for f, row in zip(element.functions, element.coefficients)
    )
    return h[:3] / h[3]


def _bernstein(degree, k, x):
    binomial = 1
    for i in range(k):
        binomial = binomial * (degree - i) // (i + 1)
    return binomial * x**k * (1 - x) ** (degree - k)


class Iga(unittest.TestCase):
    def setUp(self):
        self.context = binding.Context(library=binding_parts.library.load(
            binding_parts.library_path()))
        self.folder = tempfile.TemporaryDirectory()
        self.path = os.path.join(self.folder.name, "body.iga")

    def tearDown(self):
        self.folder.cleanup()

    def texts(self):
        return [f.text for f in self.context.findings()]

    def boundary(self):
        surface = Surface.read(self.context, self.path)
        return surface, binding.Boundary.from_surface(self.context, surface)

    def match(self, body, boundary):
        """Which parameters of the body belong to a side's (s, t): by the cube's corners."""
        corner = boundary.requirement["corner"]
        back = {}
        for c in range(8):
            bits = [c >> k & 1 for k in range(3)]
            back[tuple(bits)] = body.point(4 + bits[2], bits[0], bits[1])
        place = []
        for c in range(8):
            found = [b for b, x in back.items() if np.allclose(x, corner[c], atol=1e-9)]
            self.assertEqual(len(found), 1)
            place.append(np.array(found[0], dtype=float))
        return place

    def check_points(self, body, boundary, tolerance):
        place = self.match(body, boundary)
        worst = 0.0
        for side in range(6):
            axis, end = divmod(side, 2)
            across = [k for k in range(3) if k != axis]
            for element in boundary.elements(side):
                for u, v in ((0.0, 0.0), (1.0, 1.0), (0.5, 0.5), (0.3, 0.9)):
                    x = np.zeros(3)
                    x[axis] = end
                    x[across[0]] = element.box[0] + u * (element.box[1] - element.box[0])
                    x[across[1]] = element.box[2] + v * (element.box[3] - element.box[2])
                    # the cube's corners lie at corners of the body's, so this is affine
                    own = place[0] + sum(x[k] * (place[1 << k] - place[0]) for k in range(3))
                    normal = int(np.flatnonzero(place[1 << axis] - place[0])[0])
                    own_side = 2 * normal + int(round(own[normal]))
                    s, t = (min(max(own[k], 0.0), 1.0) for k in range(3) if k != normal)
                    apart = body.point(own_side, s, t) - element_point(
                        boundary, side, element, u, v)
                    worst = max(worst, float(np.linalg.norm(apart)))
        self.assertLess(worst, tolerance)

    def test_intervals_are_found_again(self):
        for axes, raised in ((SMOOTH, 0), (SMOOTH, 1), (MIXED, 0), (MIXED, 2)):
            for seed in (1, 2):
                body = Body(axes, bend)
                written = write_iga(self.path, body, seed, raised)
                surface, boundary = self.boundary()
                facts = surface.facts()
                self.assertEqual(facts["faces"], len(written))
                self.assertEqual(facts["vertices"] - facts["edges"] + facts["faces"], 2)
                self.assertEqual(facts["t_junctions"], 0)
                self.assertEqual(len(facts["extraordinary"]), 8)
                self.assertLess(facts["sum_defect"], 1e-14)
                self.check_points(body, boundary, 1e-10)

    def test_t_junctions(self):
        for cut in (0.5, 0.4, 1.0 / 3.0):
            for seed in range(4):
                body = Body(SMOOTH if seed % 2 else MIXED, bend)
                written = write_iga(self.path, body, seed, seed % 2, cut)
                surface, boundary = self.boundary()
                facts = surface.facts()
                self.assertEqual(facts["faces"], len(written))
                self.assertEqual(facts["vertices"] - facts["edges"] + facts["faces"], 2)
                self.assertGreater(facts["t_junctions"], 0)
                self.check_points(body, boundary, 1e-10)

    def test_creases_take_unit_intervals(self):
        body = Body(CREASED, bend)
        write_iga(self.path, body)
        surface, boundary = self.boundary()
        note = [t for t in self.texts() if "no knot intervals" in t]
        self.assertEqual(len(note), 1)
        self.assertIn("in the 4 groups", note[0])  # x left and right of the crease, y, z
        lines = set()
        for side in range(6):
            for element in boundary.elements(side):
                lines.update(element.box)
        # left of the crease 0.25 and 0.25: 1, 1; right 0.1 and 0.4: 1, 4
        for want in (1.0 / 7.0, 2.0 / 7.0, 3.0 / 7.0):
            near = min(min(abs(x - want), abs(1 - x - want)) for x in lines)
            self.assertLess(near, 1e-10)

    def test_numbering_does_not_matter(self):
        """The same file written in another order and other frames: the same boundary, up to
        round-off of the intervals found."""
        body = Body(SMOOTH, bend)
        results = []
        for seed in (5, 6, 7):
            write_iga(self.path, body, seed)
            results.append(self.boundary()[1])
        for other in results[1:]:
            np.testing.assert_array_equal(np.array(results[0].points), np.array(other.points))
            for side in range(6):
                pairs = zip(results[0].elements(side), other.elements(side))
                for a, b in pairs:
                    np.testing.assert_allclose(a.box, b.box, atol=1e-11)
                    self.assertEqual(list(a.functions), list(b.functions))

    def test_a_solid(self):
        body = Body((Axis(2, (0.4,)), Axis(2, ()), Axis(3, ())), bend)
        write_iga(self.path, body, 3, 1, 0.5)
        out = os.path.join(self.folder.name, "body.tsolid")
        code, said, _ = run_command("build", self.path, "-o", out)
        self.assertEqual(code, 0, said)
        solid = binding.Solid.read(self.context, out)
        certificate = binding.Certificate.of(self.context, solid)
        self.assertEqual(certificate.verdict, 0)
        # volume of the body's B-splines' convex shape: control points of the boundary are the
        # file's, bit for bit up to their order
        kept = {tuple(row) for row in np.array(solid.boundary.points)}
        weights = body.points[:, 3:]
        given = np.concatenate([body.points[:, :3] * weights, weights], axis=1)
        self.assertEqual(kept, {tuple(row) for row in given})

    def test_refusals(self):
        body = Body(SMOOTH, straight)
        write_iga(self.path, body, kind="volume")
        with self.assertRaisesRegex(binding.Refused, "only plane and surface"):
            Surface.read(self.context, self.path)
        write_iga(self.path, body)
        with open(self.path, encoding="ascii") as stream:
            text = stream.read()
        # without one element the surface is open
        begin = text.index("belem")
        end = text.index("belem", begin + 1)
        less = text[:begin] + text[end:]
        n = text.count("belem")
        with open(self.path, "w", encoding="ascii") as out:
            out.write(less.replace("elemN %d" % n, "elemN %d" % (n - 1)))
        surface = Surface.read(self.context, self.path)
        self.assertEqual(surface.facts()["boundary_loops"], 1)
        with self.assertRaisesRegex(binding.Refused, "open: 1 boundary loop"):
            binding.Boundary.from_surface(self.context, surface)
        # an element twice
        with open(self.path, "w", encoding="ascii") as out:
            out.write((text[:end] + text[begin:]).replace("elemN %d" % n, "elemN %d" % (n + 1)))
        with self.assertRaisesRegex(binding.Refused, "share one edge"):
            Surface.read(self.context, self.path)
        # cut off anywhere: never a surface
        for at in range(100, text.index("set"), 997):
            with open(self.path, "w", encoding="ascii") as out:
                out.write(text[:at])
            with self.assertRaises(binding.TsolidError):
                Surface.read(self.context, self.path)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
