#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The models that stand for table 1 of the paper: sizes, shape of the meshes, one of them built.
All of them, built: long_models.py."""
import os
import random
import sys

import numpy as np

import binding_parts
from binding_parts import binding
from example_chain import DISTANCE, SUM, ChainCase
from model_chain import HEADING, PAPER, ModelChain, row, surface_of

from tsm_surface import cubic

from examples import models
from examples.cube_mesh import CubeMesh, bernstein
from examples.models import MODELS


class ModelTest(ChainCase):
    made = {}

    def model(self, name):
        """The mesh and the twin's surface, made once."""
        if name not in self.made:
            mesh = MODELS[name]()
            self.made[name] = mesh, surface_of(mesh, self.folder, name)[1]
        return self.made[name]

    def test_sizes_are_the_papers(self):
        """Nodes and elements within a fifth; elements counted by their area."""
        for name in MODELS:
            with self.subTest(name):
                mesh, _ = self.model(name)
                elements = [box for side in mesh.extraction() for box, _ in side]
                area = sum((b[1] - b[0]) * (b[3] - b[2]) for b in elements)
                size = [row[-1] - row[0] for row in mesh.lines]
                whole = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0])
                self.assertAlmostEqual(area / whole, 1, delta=1e-12)
                for ours, theirs in zip((len(mesh.vertices), len(elements)), PAPER[name]):
                    self.assertLessEqual(abs(ours / theirs - 1), 0.2)
        patches = models.blade_nurbs()
        spans = [np.subtract(p.points.shape[:2], 3) for p in patches]
        self.assertEqual(sum(a * b for a, b in spans), PAPER["blade_nurbs"][1])

    def test_meshes_have_t_junctions_away_from_stars(self):
        for name in MODELS:
            with self.subTest(name):
                _, surface = self.model(name)
                joints = [surface.origin[k] for k, s in enumerate(surface.straight) if s]
                self.assertGreater(len(joints), 0)
                self.assertEqual(len(surface.stars), 8)
                self.assertEqual(len(surface.sides), 6)
                self.assertTrue(set(joints).isdisjoint(surface.stars))

    def test_functions_sum_to_one(self):
        """By the twin: Cox-de Boor on knots found by walking, at points of every face."""
        for name in MODELS:
            with self.subTest(name):
                (_, surface), draw = self.model(name), random.Random(name)
                for face, (w, h) in enumerate(surface.size):
                    if w > 0 and h > 0:
                        weight = surface.on_face(face, w * draw.random(), h * draw.random())[3]
                        self.assertLessEqual(abs(weight - 1), SUM)

    def test_twin_on_nurbs(self):
        """The twin surface of the blade's grid is the blade of NURBS patches."""
        patches = models.blade_nurbs()
        mesh = CubeMesh([models.sharp(row) for row in models.BLADE])
        for k, vertex in enumerate(mesh.vertices):
            side = mesh.sides_at(vertex)[0]
            mesh.points[k] = patches[side].points[mesh.on_side(side, vertex)]
        surface, draw = surface_of(mesh, self.folder, "grid")[1], random.Random(2)
        numbers = {f: n for n, f in enumerate(mesh.faces)}
        for face in mesh.faces:
            u0, u1, v0, v1 = mesh.face_box(face)
            if u0 < u1 and v0 < v1:
                a, b = draw.random(), draw.random()
                expected = patches[face[0]].evaluate([u0 + a * (u1 - u0)], [v0 + b * (v1 - v0)])
                # the frame of a face starts at its low corner; seen from outside it may be turned
                outward = (face[0] % 2 == 0) == (face[0] // 2 == 1)
                place = (a * (u1 - u0), b * (v1 - v0))
                found = surface.on_face(numbers[face], *(place if outward else place[::-1]))
                self.assertLessEqual(np.abs(found[:3] - expected).max(), 1e-12 * 150)

    def test_mouse_is_sharp_below_and_smooth_above(self):
        mesh, surface = self.model("mouse")
        bottom, near_stars, elsewhere = [], [], []
        for link, edge in enumerate(surface.edge):
            if not surface.is_isoline[edge] or surface.length(link) == 0:
                continue
            ends = (surface.origin[link], surface.origin[surface.next[link]])
            height = [mesh.lines[2][mesh.vertices[v][2]] for v in ends]
            if max(height) == 0:
                bottom.append(surface.angle_across(link))
            elif min(height) >= 3:
                at_star = set(ends) & set(surface.stars)
                (near_stars if at_star else elsewhere).append(surface.angle_across(link))
        self.assertGreater(min(bottom), 0.8)
        self.assertLess(max(elsewhere), 1e-5)
        self.assertLess(max(near_stars), 0.02)  # spokes are C^0

    def test_coefficients(self):
        """Bernstein coefficients give the values of Cox and de Boor, multiple knots included."""
        draw = random.Random(5)
        for _ in range(200):
            knots = sorted(draw.randrange(6) / 4 for _ in range(5))
            ends = sorted(set(knots))
            for a, b in zip(ends, ends[1:]):
                c, x = bernstein(knots, a, b), draw.uniform(a, b)
                t = (x - a) / (b - a)
                value = sum(c[k] * (1, 3, 3, 1)[k] * t ** k * (1 - t) ** (3 - k)
                            for k in range(4))
                self.assertAlmostEqual(value, cubic(knots, x), delta=1e-14)

    def test_mouse_built(self):
        print("\n" + HEADING)
        chain = ModelChain("mouse", self.folder, "--effort", "quick")
        self.assertEqual(chain.failures(0.3), [])
        print(row("mouse", chain.report, chain.seconds), flush=True)

    def test_every_carrier_is_conformal(self):
        """As half-edges and as T-spline patches; no proof is asked for here. As Bezier elements:
        the mouse."""
        for name, carrier in (("shaft", "tsm"), ("blade_tspline", "patches")):
            with self.subTest("%s as %s" % (name, carrier)):
                chain = ModelChain(name, self.folder, "--effort", "none", carrier=carrier)
                self.assertIn(chain.code, (0, 2), chain.text)
                self.assertLess(chain.distance(chain.read_back(), 100)[0],
                                DISTANCE * chain.scale())

    def test_moved_control_point_is_found(self):
        chain = ModelChain("mouse", self.folder, "--effort", "none")
        allowed = DISTANCE * chain.scale()
        self.assertLess(chain.distance(chain.read_back(), 300)[0], allowed)
        with open(chain.path, "rb") as source:
            data = binding_parts.with_moved_point(source.read(), 1e-9 * chain.scale())
        path = os.path.join(self.folder, "moved.tsolid")
        with open(path, "wb") as target:
            target.write(data)
        self.assertGreater(chain.distance(binding.Solid.read(chain.context, path), 300)[0],
                           allowed)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
