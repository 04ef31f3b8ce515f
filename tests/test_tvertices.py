#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Faces with corners inside their neighbours' borders, by the command and by the binding: the
whole chain, names of corners, corners that the caller gives, T-meshes as B-spline faces."""
import os
import random
import sys
import tempfile
import unittest

import numpy as np

import binding_parts
import example_chain
from binding_parts import binding, library
from example_chain import ChainCase
from freecad.tsolid.surface import Surface
from rewrite_part import shuffled

from examples.cube_mesh import write_tsm
from examples.models import MODELS
from examples.parts import PARTS, wavy_cube
from examples.splines import half_patch, insert_patch_knots


def cut(patch, direction, value):
    """Both parts of a patch on the sides of an isoline."""
    missing = patch.degree[direction] - patch.knots[direction].count(value)
    fine = insert_patch_knots(patch, direction, (value,) * missing)
    return half_patch(fine, direction, False), half_patch(fine, direction, True)


def part_of(patch, u, v):
    """The part of a patch between two isolines of each direction."""
    for direction, (low, high) in enumerate((u, v)):
        first, last = patch.domain()[direction]
        if low > first:
            patch = cut(patch, direction, low)[1]
        if high < last:
            patch = cut(patch, direction, high)[0]
    return patch


def pinwheel(patch, x=(0.25, 0.75), y=(0.375, 0.625)):
    """Five parts, four around one in the middle: no isoline goes through."""
    boxes = [((0, x[1]), (0, y[0])), ((x[1], 1), (0, y[1])), ((x[0], 1), (y[1], 1)),
             ((0, x[0]), (y[0], 1)), (x, y)]
    return [part_of(patch, u, v) for u, v in boxes]


def bricks(patch):
    """Two rows of two and three, joints staggered."""
    low, high = cut(patch, 1, 0.5)
    first, rest = cut(high, 0, 0.25)
    return list(cut(low, 0, 0.5)) + [first] + list(cut(rest, 0, 0.75))


def named(patches):
    for k, patch in enumerate(patches):
        patch.name = "Face%d" % (k + 1)
    return patches


def pinwheel_part():
    """A wavy cube with a pinwheel on one side, one over two faces on another."""
    faces = wavy_cube(2)
    return named(pinwheel(faces[5]) + list(cut(faces[3], 0, 0.5625)) + faces[:3] + faces[4:5])


def brick_part():
    faces = PARTS["twisted_bar"]()
    return named(bricks(faces[1]) + bricks(faces[2]) + [faces[0]] + faces[3:])


def patches_of(given):
    """For the binding."""
    out = []
    for patch in given:
        points = patch.points.transpose(1, 0, 2).reshape(-1, 3)
        weights = None if patch.weights is None else patch.weights.T.ravel()
        out.append(binding.Patch(patch.degree, patch.points.shape[:2], patch.knots, points, weights,
                                 name=patch.name or ""))
    return out


class ChainTest(ChainCase):
    def test_parts(self):
        print("\n" + example_chain.HEADING)
        for name, make, n_cut in (("pinwheel", pinwheel_part, 11), ("bricks", brick_part, 13)):
            with self.subTest(name):
                chain = self.chain(make(), name, snapped=True)
                preparation = chain.report["preparation"]
                self.assertGreater(preparation["n_cut_patches"], 5)
                self.assertGreaterEqual(preparation["n_cuts"], preparation["n_cut_patches"])
                self.assertLessEqual(preparation["n_cut_patches"], n_cut)
                self.assertIn("patches cut along", chain.text)
                self.assertLess(max(preparation["snap"] + preparation["snap_inside"]), 1e-12)
                words = [f["text"] for f in chain.report["findings"]]
                self.assertTrue(any("Face" in w and " is cut at " in w for w in words))

    def test_same_file_in_any_order(self):
        patches = pinwheel_part()
        one = self.chain(patches, "as_given", "--effort", "none", snapped=True, least_ratio=0)
        again = self.chain(shuffled(patches, random.Random(3)).patches, "shuffled", "--effort",
                           "none", snapped=True, least_ratio=0)
        self.assertEqual(*(open(c.path, "rb").read() for c in (one, again)))


class BindingTest(unittest.TestCase):
    def setUp(self):
        self.context = binding.Context(library=library.load(binding_parts.library_path()))

    def test_pieces(self):
        given = pinwheel_part()
        boundary = binding.Boundary.create(self.context, patches_of(given))
        total = 0
        for k, patch in enumerate(given):
            places = boundary.placements(k)
            total += len(places)
            (u0, u1), (v0, v1) = patch.domain()
            area = sum((p.domain[1] - p.domain[0]) * (p.domain[3] - p.domain[2]) for p in places)
            self.assertAlmostEqual(area, (u1 - u0) * (v1 - v0), delta=1e-13)
            for u, v in ((u0, v0), (u1, v1), (0.5 * u0 + 0.5 * u1, v1)):
                side, s, t = places.locate(u, v)
                self.assertIn(side, {p.side for p in places})
                self.assertTrue(0 <= s <= 1 and 0 <= t <= 1)
        self.assertEqual(total, boundary.requirement["n_patches"])
        grid = boundary.requirement["side_grid"]
        self.assertEqual(total, sum(n * m for n, m in grid))

    def corners(self, patches):
        return binding.Boundary.create(self.context, patches).requirement["corner"]

    def test_given_corners(self):
        patches = patches_of(pinwheel_part())
        corners = self.corners(patches)
        for way in (corners, corners[::-1]):
            boundary = binding.Boundary.create(self.context, patches, corners=way)
            self.assertEqual(boundary.requirement["corner"], corners)
        wrong = [list(p) for p in corners]
        wrong[3][0] += 1e-3
        twice = corners[:7] + corners[:1]
        for points, words in ((wrong, "has none there"), (twice, "is there too")):
            with self.assertRaises(binding.Refused) as caught:
                binding.Boundary.create(self.context, patches, corners=points)
            self.assertIn(words, str(caught.exception))
        for points in (corners[:7], [[float("nan")] * 3] * 8):
            with self.assertRaises(binding.TsolidError) as caught:
                binding.Boundary.create(self.context, patches, corners=points)
            self.assertNotIsInstance(caught.exception, binding.Refused)

    def test_names_of_corners(self):
        """The least name of a corner; a long one is cut off between characters."""
        patches = patches_of(wavy_cube(1))
        points = self.corners(patches)
        self.assertEqual(binding.Boundary.create(self.context, patches).requirement["corner_name"],
                         [""] * 8)
        long_name = "a" + 40 * "\u00e9"
        for patch in patches:
            n, m = patch.n_control
            own = [patch.points[i] for i in (0, n - 1, n * m - 1, n * (m - 1))]
            ids = [min(range(8), key=lambda k: np.linalg.norm(np.subtract(points[k], p)))
                   for p in own]
            patch.corner_names = [long_name if k == 5 else "Vertex%d" % (k + 1) for k in ids]
        boundary = binding.Boundary.create(self.context, patches)
        want = ["Vertex%d" % (k + 1) for k in range(8)]
        want[5] = "a" + 31 * "\u00e9"
        self.assertEqual(boundary.requirement["corner_name"], want)

    def test_faces_of_t_meshes(self):
        """B-spline faces of T-meshes meet in T-vertices: the same surface as the T-mesh itself."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for name in ("boat", "blade_tspline"):
            path = os.path.join(folder.name, name + ".tsm")
            write_tsm(MODELS[name](), path)
            surface = Surface.read(self.context, path)
            boundary = binding.Boundary.create(self.context, surface.patches(self.context))
            self.assertGreater(boundary.preparation["n_cuts"], 0)
            moved = boundary.preparation["snap"] + boundary.preparation["snap_inside"]
            self.assertLess(max(moved), 1e-14 * boundary.scale)
            whole = binding.Boundary.from_surface(self.context, surface)
            for one, other in zip(boundary.requirement["corner"], whole.requirement["corner"]):
                self.assertLess(np.linalg.norm(np.subtract(one, other)), 1e-14 * whole.scale)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
