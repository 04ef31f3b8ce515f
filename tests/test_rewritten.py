#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A sphere whose patches were rewritten, the surface being the same, through the command.

The rewriting is done here in exact rational numbers: a bilinear factor on one face, which raises
its degree, and Moebius changes of the parameters of two others.
"""

import json
import math
import os
import subprocess
import sys
import tempfile
import unittest
from fractions import Fraction

import binding_parts
from binding_parts import ROOT, binding

COMMAND = os.environ.get("TSOLID_COMMAND") or os.path.join(
    os.path.dirname(binding_parts.library_path()), "tsolid"
)


def homogeneous(patch):
    """Rows j of homogeneous control points of a patch of one span."""
    n, m = patch["n_control"]
    rows = []
    for j in range(m):
        rows.append([])
        for i in range(n):
            w = Fraction(patch["weights"][i + n * j])
            rows[j].append([w * Fraction(x) for x in patch["points"][i + n * j]] + [w])
    return rows


def transposed(rows):
    return [list(column) for column in zip(*rows)]


def times_linear(row, low, high):
    """Bernstein coefficients of the product with (1 - t) low + t high."""
    q = len(row)
    zero = [Fraction(0)] * 4
    return [
        [
            Fraction(q - i, q) * low * a + Fraction(i, q) * high * b
            for a, b in zip(row[i] if i < q else zero, row[i - 1] if i else zero)
        ]
        for i in range(q + 1)
    ]


def times_bilinear(rows, corner):
    """corner: the factor at (u, v) = 00, 10, 01, 11."""
    low = transposed([times_linear(row, corner[0], corner[1]) for row in rows])
    high = transposed([times_linear(row, corner[2], corner[3]) for row in rows])
    columns = []
    for a, b in zip(low, high):
        pairs = zip(times_linear(a, 1, 0), times_linear(b, 0, 1))
        columns.append([[x + y for x, y in zip(p, q)] for p, q in pairs])
    return transposed(columns)


def moebius(rows, c):
    """u becomes c t/(c t + 1 - t)."""
    return [[[x * c**i for x in point] for i, point in enumerate(row)] for row in rows]


def as_patch(rows, old):
    degree = [len(rows[0]) - 1, len(rows) - 1]
    flat = [point for row in rows for point in row]
    patch = dict(old)
    patch.update(
        degree=degree,
        n_control=[d + 1 for d in degree],
        knots=[[0.0] * (d + 1) + [1.0] * (d + 1) for d in degree],
        points=[[float(x / p[3]) for x in p[:3]] for p in flat],
        weights=[float(p[3]) for p in flat],
    )
    return patch


def rewritten_sphere():
    path = os.path.join(ROOT, "resources", "examples", "sphere.tsb")
    with open(path, encoding="utf-8") as stream:
        sphere = json.load(stream)
    patches = sphere["patches"]
    corner = [Fraction(x, 10) for x in (10, 17, 13, 8)]
    patches[1] = as_patch(times_bilinear(homogeneous(patches[1]), corner), patches[1])
    patches[4] = as_patch(moebius(homogeneous(patches[4]), Fraction(3, 2)), patches[4])
    turned = moebius(transposed(homogeneous(patches[5])), Fraction(4, 5))
    patches[5] = as_patch(transposed(turned), patches[5])
    return sphere


class RewrittenTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.source = os.path.join(folder.name, "in.tsb")
        self.target = os.path.join(folder.name, "out.tsolid")

    def run_command(self, *arguments):
        return subprocess.run([COMMAND, *arguments], capture_output=True, text=True, check=False)

    def write(self, part):
        with open(self.source, "w", encoding="utf-8") as stream:
            json.dump(part, stream)

    def test_builds_and_is_proved(self):
        self.write(rewritten_sphere())
        built = self.run_command("build", self.source, "-o", self.target)
        self.assertEqual(built.returncode, 0, built.stdout + built.stderr)
        self.assertIn("parameters changed projectively in 2 patch directions", built.stdout)
        report = json.loads(self.run_command("report", self.target, "--json", "-").stdout)
        self.assertEqual(report["certificate"]["verdict"], "positive")
        self.assertEqual(report["preparation"]["n_moebius"], 2)
        self.assertGreater(report["preparation"]["n_bilinear_factors"], 0)
        self.assertLess(max(report["preparation"]["snap"]), 1e-13)
        radius = math.hypot(*rewritten_sphere()["patches"][0]["points"][0])
        volume = 4.0 / 3.0 * math.pi * radius**3
        self.assertAlmostEqual(report["conformity"]["volume"] / volume, 1.0, delta=1e-12)

    def test_same_parameters_through_the_binding(self):
        """The solid's boundary at placement.map(u, v) is the patch's own point."""
        part = rewritten_sphere()
        patches = [
            binding.Patch(
                p["degree"], p["n_control"], p["knots"], p["points"], p["weights"], name=p["name"]
            )
            for p in part["patches"]
        ]
        context = binding.Context()
        boundary = binding.Boundary.create(context, patches)
        space = binding.Space.create(context, boundary, binding.TMesh.create(context, boundary))
        solid = binding.Solid.create(context, space)
        changed = 0
        for k, patch in enumerate(part["patches"]):
            place = boundary.placement(k)
            changed += sum(a != 1.0 for a in place.moebius)
            rows = homogeneous(patch)
            for u, v in ((0.5, 0.5), (0.25, 0.75), (0.125, 0.0), (1.0, 0.375)):
                h = [0.0] * 4
                p, q = patch["degree"]
                for j, row in enumerate(rows):
                    for i, point in enumerate(row):
                        b = math.comb(p, i) * u**i * (1 - u) ** (p - i)
                        b *= math.comb(q, j) * v**j * (1 - v) ** (q - j)
                        h = [x + b * float(y) for x, y in zip(h, point)]
                block, cross = solid.boundary_point(place.side, *place.map(u, v))
                got = solid.evaluate(context, block, cross)[0]
                self.assertLess(math.dist(got, [x / h[3] for x in h[:3]]), 1e-13)
        self.assertEqual(changed, 2)

    def test_square_is_refused(self):
        part = rewritten_sphere()
        corner = [Fraction(x, 10) for x in (10, 17, 13, 8)]
        again = times_bilinear(homogeneous(part["patches"][1]), corner)
        part["patches"][1] = as_patch(again, part["patches"][1])
        self.write(part)
        built = self.run_command("build", self.source, "-o", self.target)
        self.assertEqual(built.returncode, 1)
        self.assertIn("Face2", built.stderr)
        self.assertIn("do not fit", built.stderr)
        self.assertFalse(os.path.exists(self.target))


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
