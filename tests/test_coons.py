#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Planar patches through the binding: borders kept, refusals named, a part closed with them."""

import math
import sys
import unittest

import binding_parts
from binding_parts import binding, library

from freecad.tsolid import coons

WAVE = (0.0, 0.4, -0.3, 0.2, 0.0)
QUARTIC = (0.0,) * 5 + (1.0,) * 5


def line(a, b, name=""):
    return coons.Curve(1, (0.0, 0.0, 1.0, 1.0), (a, b), name=name)


def turn(p, x):
    """A rotation that no coordinate plane survives."""
    c, s = math.cos(p), math.sin(p)
    x = (x[0], c * x[1] - s * x[2], s * x[1] + c * x[2])
    return (c * x[0] - s * x[2] + 40.0, x[1] - 70.0, s * x[0] + c * x[2] + 9.0)


class Coons(unittest.TestCase):
    def setUp(self):
        self.context = binding.Context(library=library.load(binding_parts.library_path()))

    def square(self, place=lambda x: x, points=WAVE):
        bottom = [place((i / 4.0, y, 0.0)) for i, y in enumerate(points)]
        a, b, c, d = (place((x, y, 0.0)) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
        return (
            coons.Curve(4, QUARTIC, bottom, name="Edge1"),
            line(b, c, "Edge2"),
            line(d, c, "Edge3"),
            line(a, d, "Edge4"),
        )

    def test_borders_are_the_curves(self):
        for place in (lambda x: x, lambda x: turn(0.7, x)):
            curves = self.square(place)
            patch, report = coons.patch(self.context, curves, name="Face5")
            n = patch.n_control[0]
            self.assertEqual((patch.degree, n), ((4, 1), 5))
            self.assertEqual(patch.points[:n], curves[0].points)
            self.assertEqual(patch.points[n - 1 :: n], curves[1].points)
            self.assertEqual(patch.points[0::n], curves[3].points)
            self.assertEqual(patch.knots[0], QUARTIC)
            self.assertIsNone(patch.weights)
            self.assertEqual(patch.name, "Face5")
            self.assertEqual(patch.border_names, ("Edge1", "Edge2", "Edge3", "Edge4"))
            self.assertAlmostEqual(report["area"], 1.0 - sum(WAVE) / 5.0, 13)
            self.assertLess(report["plane_distance"], 1e-13)

    def test_refusals(self):
        curves = list(self.square())
        curves[2] = line((0.0, 1.0, 0.5), (1.0, 1.0, 0.0), "Edge3")
        with self.assertRaises(binding.Refused) as caught:
            coons.patch(self.context, curves)
        self.assertIn("Edge3 and Edge4 do not meet", str(caught.exception))
        self.assertAlmostEqual(caught.exception.report["corner_gap"], 0.5)
        curves = list(self.square(points=(0.0, 0.4, -0.3, 0.2, 0.0)))
        curves[0].points[2] = (0.5, 0.1, 0.01)
        with self.assertRaises(binding.Refused) as caught:
            coons.patch(self.context, curves, name="Face5", normal=(0, 0, -2))
        self.assertIn("Face5 is not planar: Edge1", str(caught.exception))
        self.assertIsNotNone(caught.exception.findings[0].point)
        with self.assertRaises(ValueError):
            coons.patch(self.context, curves[:3])
        with self.assertRaises(ValueError):
            coons.Curve(2, (0, 0, 1, 1), ((0, 0, 0), (1, 0, 0)))

    def test_a_bar_with_made_caps(self):
        """A sheet bent along a wave, its two ends made of its borders: a solid."""
        patches = []
        sides = self.square()
        loop = [[(p[0], p[1]) for p in side.points] for side in sides]
        for k, side in enumerate(sides):
            points = [(x, y, float(z)) for z in (0, 2) for x, y in loop[k]]
            degree = (side.degree, 1)
            patches.append(
                binding.Patch(degree, (side.degree + 1, 2), (side.knots, (0, 0, 1, 1)), points)
            )
        for z in (0.0, 2.0):
            curves = [
                coons.Curve(s.degree, s.knots, [(p[0], p[1], z) for p in s.points]) for s in sides
            ]
            patches.append(coons.patch(self.context, curves)[0])
        boundary = binding.Boundary.create(self.context, patches)
        self.assertTrue(boundary.requirement["satisfied"])
        self.assertEqual(max(boundary.preparation["snap"]), 0.0)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
