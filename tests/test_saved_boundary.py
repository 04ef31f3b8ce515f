#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A boundary of whatever kind, saved as .tsb in the form that the library holds, is taken up again
bit for bit: the solid made of it is the same file. Only what a solid keeps of how the input was
(section FACT: patches counted, knots inserted) is the saved file's own."""
import ctypes
import os
import struct
import sys
import tempfile
import unittest

import binding_parts
from binding_parts import binding, header, library
from freecad.tsolid.surface import Surface
from iga_parts import Axis, Body, write_iga

from examples.cube_mesh import CubeMesh, write_model
from examples.models import MODELS, ball, set_points


def smooth_body():
    """Smooth all over, with T-junctions in the middle of two sides; no spacing is a power of two's
    part, so that nothing is exact by luck."""
    lines = [[k * 0.3 for k in range(10)], [k * 0.3 for k in range(9)], [k * 0.3 for k in range(8)]]
    lines[0] = sorted(lines[0] + [1.1])

    def present(axis, i, point):
        return axis != 0 or lines[0][i] != 1.1 or (point[2] > 1.9 and 0.9 < point[1] < 1.5)

    return set_points(CubeMesh(lines, present), ball)


def bend(x, y, z):
    return [x + 0.1 * y * y, y + 0.07 * z * x, z + 0.05 * x, 1.0 + 0.2 * x * y]


def sections(data):
    """Of a .tsolid file: [tag, payload]."""
    out, at = [], 8 + 4  # magic, version
    while at < len(data):
        size = struct.unpack_from("<Q", data, at + 4)[0]
        out.append((data[at:at + 4], data[at + 12:at + 12 + size]))
        at += 12 + size + 4
    return out


CORNERS = slice(9 * 4, 9 * 4 + 24 * 8)  # of the cube, in section FACT


class SavedTest(unittest.TestCase):
    def setUp(self):
        self.context = binding.Context(library=library.load(binding_parts.library_path()))
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def content(self, name):
        with open(self.path(name), "rb") as source:
            return source.read()

    def save(self, boundary, name):
        view = header.BezierBoundary()
        self.context.library.tsolid_boundary_view(boundary.handle, ctypes.byref(view))
        given = header.BoundaryInput(bezier=ctypes.pointer(view))
        self.context.call("tsolid_write_tsb", ctypes.byref(given), os.fsencode(self.path(name)))

    def solid(self, boundary, name):
        mesh = binding.TMesh.create(self.context, boundary)
        space = binding.Space.create(self.context, boundary, mesh)
        binding.Solid.create(self.context, space).write(self.context, self.path(name))

    def check(self, boundary, same_facts=False):
        self.assertEqual(boundary.requirement["satisfied"], 1)
        self.save(boundary, "saved.tsb")
        again = binding.Boundary.from_file(self.context, self.path("saved.tsb"))
        self.save(again, "again.tsb")
        self.assertEqual(self.content("again.tsb"), self.content("saved.tsb"))
        self.solid(boundary, "first.tsolid")
        self.solid(again, "second.tsolid")
        pairs = list(zip(sections(self.content("first.tsolid")),
                         sections(self.content("second.tsolid"))))
        self.assertEqual(len(pairs), 11)
        for (tag, first), (tag2, second) in pairs:
            self.assertEqual(tag, tag2)
            chosen = CORNERS if tag == b"FACT" and not same_facts else slice(None)
            self.assertTrue(first[chosen] == second[chosen] and first[chosen], tag)
        if same_facts:
            self.assertEqual(self.content("second.tsolid"), self.content("first.tsolid"))

    def check_surface(self, name):
        surface = Surface.read(self.context, self.path(name))
        self.check(binding.Boundary.from_surface(self.context, surface))

    def test_half_edges(self):
        for name, mesh in (("mouse", MODELS["mouse"]()), ("smooth", smooth_body())):
            with self.subTest(name):
                write_model(mesh, self.path(name + ".tsm"), "tsm")
                self.check_surface(name + ".tsm")

    def test_extracted_elements(self):
        for cut in (None, 0.5):
            with self.subTest(cut):
                body = Body((Axis(3, (0.3, 0.45)), Axis(2, (0.7,)), Axis(3, ())), bend)
                write_iga(self.path("body.iga"), body, 3, 1, cut)
                self.check_surface("body.iga")

    def test_t_spline_patches_and_elements(self):
        for name, carrier in (("blade_tspline", "patches"), ("mouse", "elements")):
            with self.subTest(name):
                write_model(MODELS[name](), self.path("part.tsb"), carrier)
                self.check(binding.Boundary.from_file(self.context, self.path("part.tsb")),
                           same_facts=True)

    def test_nurbs_patches(self):
        for name in ("elbow", "mixed_sides", "propeller_blade"):
            with self.subTest(name):
                path = os.path.join(binding_parts.ROOT, "resources", "examples", name + ".tsb")
                self.check(binding.Boundary.from_file(self.context, path))

    def test_another_boundary_is_another_file(self):
        """The comparison sees the last bit of one control point."""
        write_model(smooth_body(), self.path("body.tsm"), "tsm")
        surface = Surface.read(self.context, self.path("body.tsm"))
        self.solid(binding.Boundary.from_surface(self.context, surface), "first.tsolid")
        mesh = smooth_body()
        mesh.points[7, 1] *= 1 + 2.3e-16
        write_model(mesh, self.path("body.tsm"), "tsm")
        surface = Surface.read(self.context, self.path("body.tsm"))
        self.solid(binding.Boundary.from_surface(self.context, surface), "second.tsolid")
        self.assertNotEqual(self.content("second.tsolid"), self.content("first.tsolid"))


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
