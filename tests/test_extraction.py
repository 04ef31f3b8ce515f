#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Extraction operators as a plain file: the example readers in Python and C find the same points as
the library evaluates; side sets of BEXT hold the faces of the boundary; the deck round it."""

import os
import re
import subprocess
import sys
import tempfile
import unittest

import binding_parts
import galerkin_parts
import numpy
import rewrite_part  # noqa: F401  (puts resources on the path)
from binding_parts import ROOT, binding
from example_chain import command_path

from examples import read_extraction
from freecad.tsolid import analysis

COMMAND = os.path.abspath(command_path())
PARTS = ("wedge", "sphere", "mixed_sides", "elbow")


def solid_of(name):
    context = binding.Context()
    boundary = binding.Boundary.create(context, binding_parts.read_example(name))
    space = binding.Space.create(context, boundary, binding.TMesh.create(context, boundary))
    return binding.Solid.create(context, space).optimised(context)


class ExtractionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.context = binding.Context()
        cls.solids = {}

    @classmethod
    def path(cls, name):
        return os.path.join(cls.holder.name, name)

    def solid(self, name):
        if name not in self.solids:
            self.solids[name] = solid_of(name)
            self.solids[name].write(self.context, self.path(name + ".tsolid"))
        return self.solids[name]

    def run_command(self, *words):
        return subprocess.run(
            [COMMAND, "export"] + list(words),
            cwd=self.holder.name,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
        )

    def test_the_reader_in_python(self):
        rng = numpy.random.RandomState(1)
        for name in PARTS:
            solid = self.solid(name)
            run = self.run_command(name + ".tsolid", "--extraction", "x")
            self.assertEqual((run.returncode, run.stdout, run.stderr), (0, "", ""))
            x = read_extraction.read(self.path("x"))
            self.assertTrue(numpy.array_equal(x.control, solid.control))
            self.assertTrue(numpy.array_equal(x.degree, solid.space.element_degrees))
            scale, worst = solid.boundary.scale, 0.0
            for e in range(x.n_elements):
                ids, rows = read_extraction.element(x, e)
                self.assertTrue((numpy.diff(ids) > 0).all())
                t = rng.rand(3)
                u = x.box[e, :3] + t * (x.box[e, 3:] - x.box[e, :3])
                wanted = solid.evaluate(self.context, int(x.block[e]), u)[0]
                worst = max(worst, abs(read_extraction.point(x, e, t) - wanted).max())
            print("%s, %d elements: distance %.2g" % (name, x.n_elements, worst / scale))
            self.assertLess(worst, 1e-14 * scale)

    def test_the_reader_in_c(self):
        source = os.path.join(ROOT, "resources", "examples", "read_extraction.c")
        flags = "-std=c11 -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror".split()
        subprocess.run(["gcc"] + flags + [source, "-o", self.path("reader")], check=True)
        for name in PARTS:
            solid = self.solid(name)
            analysis.write_extraction(self.context, solid, self.path("x"))
            run = subprocess.run([self.path("reader"), self.path("x")], stdout=subprocess.PIPE)
            self.assertEqual(run.returncode, 0)
            found = numpy.array([line.split() for line in run.stdout.splitlines()], dtype=float)
            boxes, blocks = numpy.array(solid.space.element_boxes), solid.space.element_blocks
            self.assertEqual(len(found), len(boxes))
            middles = (boxes[:, :3] + boxes[:, 3:]) / 2
            for x, u, block in zip(found, middles, blocks):
                wanted = solid.evaluate(self.context, block, u)[0]
                self.assertLess(abs(x - wanted).max(), 1e-14 * solid.boundary.scale)
        with open(self.path("x"), "rb") as stream:
            data = stream.read()
        with open(self.path("x"), "wb") as stream:
            stream.write(data[:-8])
        self.assertEqual(subprocess.run([self.path("reader"), self.path("x")]).returncode, 1)

    def test_the_readers_are_short(self):
        """What the manual promises: a reader is some thirty lines."""
        folder = os.path.join(ROOT, "resources", "examples")
        ends = {"py": ("def read(", "def element("), "c": ("static void *take", "/* B_i")}
        for ending, (start, end) in ends.items():
            with open(os.path.join(folder, "read_extraction." + ending)) as stream:
                text = stream.read()
            self.assertLess(text[text.index(start) : text.index(end)].count("\n"), 31)

    def sets_of(self, path):
        with open(path, encoding="utf-8") as stream:
            text = stream.read()
        found = {}
        for name, n, rows in re.findall(r"\$#SIDE SET (\S+) (\d+)\n((?:\$# \d+ \d+\n)*)", text):
            found[name] = [tuple(int(w) for w in row.split()[1:]) for row in rows.splitlines()]
            self.assertEqual(len(found[name]), int(n))
        return found

    def test_side_sets_of_bext(self):
        """All points of a listed element's face lie on the side that the set is of, and the sets
        together have the area of the part: none is missing."""
        for name in ("wedge", "sphere"):
            solid = self.solid(name)
            run = self.run_command(name + ".tsolid", "--bext", "part.bxt")
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            bext = analysis.Bext.read(self.context, self.path("part.bxt"))
            sets = self.sets_of(self.path("part.bxt"))
            self.assertEqual(len(sets), 6)
            view = bext.view()
            for side, rows in enumerate(sets.values()):
                area = 0.0
                for element, face in rows:
                    self.assertEqual(face, 1 + side)
                    area += self.face_area(view, element - 1, face - 1)
                whole = sum(analysis.face_load(self.context, solid, side))
                self.assertAlmostEqual(area / whole, 1, delta=1e-8)

    @staticmethod
    def face_area(view, e, face):
        degree = [view.degree[3 * e + d] for d in range(3)]
        shape = tuple(p + 1 for p in reversed(degree)) + (4,)
        width, net = (shape[0] * shape[1] * shape[2]), numpy.zeros(shape)
        for k in range(view.function_start[e], view.function_start[e + 1]):
            first = view.vector_start[view.vector[k]]
            row = numpy.array(view.coefficient[first : first + width]).reshape(shape[:3])
            control = numpy.array(view.control[4 * view.function[k] : 4 * view.function[k] + 4])
            net += row[..., None] * control
        axis, high = divmod(face, 2)
        net = numpy.take(net, -1 if high else 0, axis=2 - axis)  # rows [v, u, 4]
        x, w = numpy.polynomial.legendre.leggauss(12)
        lines = [galerkin_parts.bernstein(net.shape[d] - 1, (x + 1) / 2) for d in (0, 1)]
        h = [numpy.einsum("qi,pj,ijc->qpc", lines[0][a], lines[1][b], net)
             for a, b in ((0, 0), (1, 0), (0, 1))]
        weight = h[0][..., 3:]
        s, t = ((d[..., :3] - h[0][..., :3] / weight * d[..., 3:]) / weight for d in h[1:])
        areas = numpy.linalg.norm(numpy.cross(s, t), axis=2)
        return w @ areas @ w / 4

    def test_regions_and_the_proof(self):
        with open(self.path("r.txt"), "w") as stream:
            stream.write("whole x_low 0 1 0 1\n")
        self.solid("wedge")
        words = ("wedge.tsolid", "--bext", "r.bxt", "--regions", "r.txt")
        self.assertEqual(self.run_command(*words).returncode, 0)
        self.assertEqual(list(self.sets_of(self.path("r.bxt"))), ["whole"])
        with open(self.path("r.txt"), "w") as stream:
            stream.write("a x_low 0 1 0 1\nb z_low 0 1 0 1\na y_high 0 1 0 1\n")
        self.assertEqual(self.run_command(*words).returncode, 0)
        sets = self.sets_of(self.path("r.bxt"))
        self.assertEqual([{face for _, face in sets[name]} for name in sets], [{1, 4}, {5}])
        with open(self.path("r.txt"), "w") as stream:
            stream.write("part x_low 0 0.123 0 1\n")
        run = self.run_command(*words)
        self.assertEqual(run.returncode, 1)
        self.assertIn("border of region 'part' cuts through elements", run.stderr)
        patches = binding_parts.cube(lambda *x: (0.2, 0.2, 0.2) if x == (1, 1, 1) else x)
        boundary = binding.Boundary.create(self.context, patches)
        tmesh = binding.TMesh.create(self.context, boundary)
        space = binding.Space.create(self.context, boundary, tmesh)
        dent = binding.Solid.create(self.context, space)
        with self.assertRaises(binding.Refused):
            analysis.write_bext_sets(self.context, dent, self.path("dent.bxt"))
        self.assertFalse(os.path.exists(self.path("dent.bxt")))
        analysis.write_bext_sets(self.context, dent, self.path("dent.bxt"), allow_unproved=True)
        with open(self.path("dent.bxt")) as stream:
            self.assertIn("NOT proved", stream.read(200))
        analysis.Bext.read(self.context, self.path("dent.bxt"))

    def test_the_deck_of_ls_dyna(self):
        self.solid("wedge")
        os.makedirs(self.path("deck"), exist_ok=True)
        words = ("wedge.tsolid", "--bext", "deck/part.bxt", "--lsdyna", "deck/part.k")
        run = self.run_command(*words)
        self.assertEqual(run.returncode, 1)
        self.assertIn("--lsdyna needs a material", run.stderr)
        self.assertEqual(os.listdir(self.path("deck")), [])
        steel = ("--young", "210000", "--poisson", "0.3", "--density", "7.85e-9")
        run = self.run_command(*words, *steel)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        cards = {}
        with open(self.path("deck/part.k")) as stream:
            for line in stream:
                if line.startswith("*"):
                    name = line.strip()
                    cards[name] = []
                elif not line.startswith("$"):
                    cards[name].append(line.rstrip("\n"))
        names = ["*KEYWORD", "*TITLE", "*IGA_INCLUDE_BEZIER", "*PART", "*SECTION_SOLID"]
        self.assertEqual(list(cards), names + ["*MAT_ELASTIC", "*END"])
        file, fields = cards["*IGA_INCLUDE_BEZIER"]
        self.assertTrue(os.path.exists(self.path("deck/" + file)))
        self.assertEqual(self.fields(fields), [1, 1, 3])
        self.assertEqual(self.fields(cards["*PART"][1]), [1, 1, 1])
        self.assertEqual(self.fields(cards["*MAT_ELASTIC"][0]), [1, 7.85e-9, 210000, 0.3])

    @staticmethod
    def fields(line):
        return [float(line[k : k + 10]) for k in range(0, len(line), 10)]


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
