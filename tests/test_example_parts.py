#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The example parts are what they claim to be, and so are their re-writings."""
import glob
import os
import random
import shutil
import subprocess
import sys
import tempfile
import unittest
from fractions import Fraction

import numpy as np

import binding_parts
import rewrite_part
from rewrite_part import ROOT

from examples.parts import PARTS
from examples.random_parts import DEFAULT_SEED, random_part
from examples.splines import (basis_matrix, clamped_knots, raised_knots, read_tsb,
                              refinement, smallest_scaled_jacobian, write_tsb)

# Their sides share curves, not rows of control points.
OWN_SIDES = {"mixed_sides"}

needs_freecad = unittest.skipUnless(shutil.which(binding_parts.FREECAD), "FreeCADCmd is missing")


def borders(patch):
    rows = patch.homogeneous()
    return [rows[:, 0], rows[-1, :], rows[:, -1], rows[0, :]]


def row_key(row):
    """One key for a row of control points and its reverse: bytes, so equal means bit for bit."""
    row = row + 0.0  # -0.0 is 0.0
    return min(np.ascontiguousarray(row).tobytes(), np.ascontiguousarray(row[::-1]).tobytes())


def complex_counts(patches):
    vertices = {(p.points[i, j] + 0.0).tobytes() for p in patches for i in (0, -1) for j in (0, -1)}
    seen = {}
    for p in patches:
        for row in borders(p):
            seen[row_key(row)] = seen.get(row_key(row), 0) + 1
    return len(vertices), len(seen), set(seen.values())


def exact_sum(knots, degree, x):
    """B-spline values at x by the recursive definition in rationals: the slow twin."""
    knots = [Fraction(k) for k in knots]
    x = Fraction(x)

    def value(i, p):
        if p == 0:
            return int(knots[i] <= x < knots[i + 1])
        total = Fraction(0)
        if knots[i + p] > knots[i]:
            total += (x - knots[i]) / (knots[i + p] - knots[i]) * value(i, p - 1)
        if knots[i + p + 1] > knots[i + 1]:
            share = (knots[i + p + 1] - x) / (knots[i + p + 1] - knots[i + 1])
            total += share * value(i + 1, p - 1)
        return total

    return [value(i, degree) for i in range(len(knots) - degree - 1)]


class SplineTest(unittest.TestCase):
    def test_basis_against_the_definition(self):
        for degree in range(1, 8):
            for repeat in range(1, degree + 1):
                knots = clamped_knots(degree, [0.3] * repeat + [0.75])
                for x in (0.0, 0.125, 0.3, 0.5, 0.75, 0.999):
                    expected = [float(v) for v in exact_sum(knots, degree, x)]
                    got = basis_matrix(knots, degree, [x])[0]
                    self.assertLess(np.abs(got - expected).max(), 1e-14)

    def test_refinement_keeps_the_curve(self):
        draw = random.Random(1)
        for degree in range(1, 10):
            knots = clamped_knots(degree, [0.25] * draw.randint(1, degree) + [0.6])
            new = tuple(sorted(raised_knots(knots, degree, 2) + (0.1, 0.6, 0.9)))
            matrix = refinement(knots, degree, new, 2)
            x = np.linspace(0, 1, 41)
            difference = basis_matrix(new, degree + 2, x) @ matrix - basis_matrix(knots, degree, x)
            self.assertLess(np.abs(difference).max(), 2e-15 * len(new))
            self.assertLess(np.abs(matrix.sum(axis=1) - 1).max(), 1e-15 * len(new))

    def test_derivatives_and_flux(self):
        patch = PARTS["sphere"]()[5]
        h = 1e-6
        u, v = np.array([0.3, 0.6]), np.array([0.2, 0.7])
        _, s_u, s_v = patch.derivatives(u, v)
        for i in range(2):
            for slopes, du, dv in ((s_u, h, 0), (s_v, 0, h)):
                ends = [patch.evaluate([u[i] + k * du], [v[i] + k * dv])[0] for k in (1, -1)]
                self.assertLess(np.abs((ends[0] - ends[1]) / (2 * h) - slopes[i, i]).max(), 1e-7)
        # a sixth of the ball's volume
        self.assertAlmostEqual(abs(patch.flux()) / (4 * np.pi * 25 ** 3 / 18), 1.0, delta=1e-14)


class PartsTest(unittest.TestCase):
    def test_closed_with_shared_rows(self):
        for name, make in PARTS.items():
            patches = make()
            if name in OWN_SIDES:
                continue
            with self.subTest(name):
                vertices, edges, uses = complex_counts(patches)
                self.assertEqual((vertices, edges, uses),
                                 (len(patches) + 2, 2 * len(patches), {2}))

    def test_own_sides_share_curves(self):
        patches = PARTS["mixed_sides"]()
        self.assertGreater(len({p.degree for p in patches}), 3)
        g = np.linspace(0, 1, 33)
        low, high = np.zeros(33), np.ones(33)
        curves = []
        for p in patches:
            for u, v in ((g, low), (g, high), (low, g), (high, g)):
                x = p.evaluate(u, v)
                curves.append(x if tuple(x[0]) < tuple(x[-1]) else x[::-1])
        used = [sum(np.abs(a - b).max() < 1e-13 for b in curves) for a in curves]
        self.assertEqual((len(curves), set(used)), (24, {2}))

    def test_sphere_is_exact(self):
        g = np.linspace(0, 1, 33)
        u, v = (a.ravel() for a in np.meshgrid(g, g))
        for patch in PARTS["sphere"]():
            self.assertEqual(patch.degree, (4, 4))
            self.assertGreater(patch.weights.min(), 0)
            distance = np.linalg.norm(patch.evaluate(u, v), axis=1)
            self.assertLess(np.abs(distance / 25 - 1).max(), 2e-15)

    def test_elbow_has_exact_arcs(self):
        caps = [p for p in PARTS["elbow"]() if p.points.shape[:2] == (3, 3)]
        self.assertEqual(len(caps), 2)
        bore = 14 / np.sin(np.radians(22.5))
        for cap in caps:  # all points of a border at one distance from its arc's centre
            g = np.linspace(0, 1, 17)
            x = cap.evaluate(g, np.zeros(17))
            middle = cap.evaluate([0.5], [0.0])[0]
            inward = cap.evaluate([0.5], [0.5])[0] - middle
            centre = middle + bore * inward / np.linalg.norm(inward)
            self.assertLess(np.abs(np.linalg.norm(x - centre, axis=1) - bore).max(), 1e-13 * 74)

    def test_plate_is_one_to_hundred(self):
        patches = PARTS["thin_plate"]()
        g = np.linspace(0, 1, 9)
        u, v = (a.ravel() for a in np.meshgrid(g, g))
        faces = [p.evaluate(u, v) for p in patches[4:]]
        thickness = np.linalg.norm(faces[1] - faces[0], axis=1)
        self.assertLess(np.abs(thickness - 2).max(), 0.05)

    def test_wedge_is_sharp(self):
        """The angle between the tangents of cap borders at the sharp corners."""
        angles = []
        for patch in PARTS["wedge"]()[2:4]:
            for i in (0, 1):
                for j in (0, 1):
                    _, a, b = patch.derivatives([float(i)], [float(j)])
                    a, b = (d[0, 0] / np.linalg.norm(d) for d in (a, b))
                    angles.append(np.degrees(np.arccos(a @ b * (1 - 2 * i) * (1 - 2 * j))))
        self.assertLess(min(angles), 36)

    def test_committed_files_are_current(self):
        committed = glob.glob(os.path.join(ROOT, "resources", "examples", "*.tsb"))
        self.assertEqual({os.path.basename(p) for p in committed},
                         {name + ".tsb" for name in PARTS})
        for path in committed:
            for old, new in zip(read_tsb(path), PARTS[os.path.basename(path)[:-4]]()):
                self.assertEqual((old.degree, old.name), (new.degree, new.name))
                # another libm may round otherwise in the last place
                self.assertLess(np.abs(old.points - new.points).max(), 1e-12)
                self.assertLess(max(np.abs(np.subtract(a, b)).max()
                                    for a, b in zip(old.knots, new.knots)), 1e-15)

    def test_random_parts(self):
        degrees, rational, own = set(), 0, 0
        for k in range(12):
            patches = random_part(DEFAULT_SEED, k)
            again = random_part(DEFAULT_SEED, k)
            degrees |= {d for p in patches for d in p.degree}
            rational += patches[0].weights is not None
            for p, q in zip(patches, again):
                self.assertEqual(p.describe(), q.describe())
            vertices, edges, uses = complex_counts(patches)
            self.assertEqual(vertices, 8)
            if (edges, uses) != (12, {2}):
                own += 1
        self.assertGreater(len(degrees), 5)
        self.assertTrue(0 < rational < 12 and 0 < own < 12)

    def test_quality_sees_a_fold(self):
        g = np.linspace(0, 1, 4)
        grid = np.stack(np.meshgrid(g, g, g, indexing="ij"), axis=3)
        self.assertAlmostEqual(smallest_scaled_jacobian(grid), 1.0)
        grid[1, 1, 1] += 0.5
        self.assertLess(smallest_scaled_jacobian(grid), 0)

    def test_file_round_trip(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "part.tsb")
            for name in ("elbow", "mixed_sides"):
                patches = PARTS[name]()
                write_tsb(patches, path)
                self.assertEqual([p.describe() for p in read_tsb(path)],
                                 [p.describe() for p in patches])


class RewriteTest(unittest.TestCase):
    """Each re-writing is the same point set at mapped parameters."""

    def check(self, rewritten, patches, allowed=1e-13):
        scale = max(np.abs(p.points).max() for p in patches + rewritten.patches)
        difference = rewritten.largest_difference(patches, random.Random(7))
        self.assertLess(difference, allowed * scale)
        self.assertEqual(sorted(rewritten.source), list(range(len(patches))))

    def test_exact_ones(self):
        for name in ("elbow", "mixed_sides", "grid24"):
            patches = PARTS[name]()
            draw = random.Random(name)
            with self.subTest(name):
                self.check(rewrite_part.shuffled(patches, draw), patches)
                self.check(rewrite_part.rescaled_at_random(patches, draw), patches)
                self.check(rewrite_part.rescaled_by_two(patches, draw), patches)
                self.check(rewrite_part.moved(patches, draw), patches)
                self.check(rewrite_part.one_side_raised(patches, 1, 0, 2), patches)
                self.check(rewrite_part.one_side_refined(patches, 2, 1, (0.23, 0.77)), patches)
                self.check(rewrite_part.one_side_reweighted(patches, 3, 1.7), patches)

    def test_moved_rows_stay_shared(self):
        patches = PARTS["elbow"]()
        rewritten = rewrite_part.moved(patches, random.Random(3))
        self.assertEqual(complex_counts(rewritten.patches), (8, 12, {2}))

    def test_48_relabellings(self):
        patches = PARTS["wedge"]()
        symmetries = rewrite_part.cube_symmetries()
        orders = set()
        for symmetry in symmetries:
            rewritten = rewrite_part.relabelled(patches, symmetry)
            self.check(rewritten, patches)
            orders.add(tuple(p.points.tobytes() for p in rewritten.patches))
            # one corner of the new cube, seen from three of its faces
            corners = [p.points[0, 0].tobytes() for p in rewritten.patches[::2]]
            self.assertEqual(len(set(corners)), 1)
        self.assertEqual((len(symmetries), len(orders)), (48, 48))

    @needs_freecad
    def test_through_step(self):
        for name in ("elbow", "mixed_sides", "grid24"):
            patches = PARTS[name]()
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                # STEP files carry 12 digits
                self.check(rewrite_part.through_step(patches, folder), patches, 5e-12)


class ScriptTest(unittest.TestCase):
    def run_script(self, *arguments, **environment):
        script = os.path.join(ROOT, "resources", "make_examples.py")
        run = subprocess.run([sys.executable, script] + list(arguments), stdin=subprocess.DEVNULL,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                             env=dict(os.environ, **environment))
        return run.returncode, run.stdout.decode("utf-8", "replace")

    def test_chosen_parts_and_random_ones(self):
        with tempfile.TemporaryDirectory() as folder:
            code, said = self.run_script("--out", folder, "--part", "box", "--random", "2",
                                         "--seed", "five")
            self.assertEqual((code, sorted(os.listdir(folder))),
                             (0, ["box.tsb", "random_00.tsb", "random_01.tsb"]))
            self.assertIn("seed five", said)
            self.assertNotEqual(random_part("five", 0)[0].describe(),
                                random_part(DEFAULT_SEED, 0)[0].describe())

    @needs_freecad
    def test_step(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = os.path.join(folder, "two words\nand a line")
            code, said = self.run_script("--out", folder, "--part", "elbow", "--step")
            self.assertEqual(code, 0, said)
            self.assertEqual(sorted(os.listdir(folder)), ["elbow.brep", "elbow.step", "elbow.tsb"])
            with open(os.path.join(folder, "elbow.step"), encoding="utf-8") as source:
                text = source.read()
            self.assertEqual(text.count("ADVANCED_FACE("), 6)
            self.assertEqual(text.count("MANIFOLD_SOLID_BREP("), 1)

    @needs_freecad
    def test_what_does_not_close_is_an_error(self):
        patches = PARTS["box"]()
        patches[0].points[0, 0, 0] += 1.0
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(RuntimeError, "do not close"):
                rewrite_part.through_step(patches, folder)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
