#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""VTK reads the .vtu and evaluates the same points as plain Bernstein sums of the Bezier nets."""

import os
import random
import sys
import tempfile
import unittest
from math import comb

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

import binding_parts
from binding_parts import ROOT, binding

from freecad.tsolid import analysis  # noqa: E402

BEZIER_HEXAHEDRON = 79
VTK_MAX_DEGREE = 10  # of VTK 9.1's own evaluation; the file may hold more


def bernstein(degree, x):
    n = degree
    return numpy.array([comb(n, k) * x**k * (1 - x) ** (n - k) for k in range(n + 1)])


def bernstein_derivative(degree, x):
    below = numpy.concatenate(([0.0], bernstein(degree - 1, x), [0.0]))
    return degree * (below[:-1] - below[1:])


class Part:
    """A solid over an example part, with random inner control points and weights."""

    def __init__(self, name, **preparation):
        self.context = binding.Context(threads=1)
        source = os.path.join(ROOT, "resources", "examples", name + ".tsb")
        boundary = binding.Boundary.from_file(self.context, source, **preparation)
        tmesh = binding.TMesh.create(self.context, boundary)
        space = binding.Space.create(self.context, boundary, tmesh)
        free = space.n_functions - space.n_surface
        rng = random.Random(name)
        control = []
        for _ in range(free):
            w = rng.uniform(0.2, 5)
            control += [w * rng.uniform(-30, 30) for _ in range(3)] + [w]
        points = boundary.points
        control += [points[i, c] for i in range(space.n_surface) for c in range(4)]
        self.solid = binding.Solid.from_control(self.context, space, control)
        self.degrees = numpy.array(space.element_degrees).reshape(-1, 3)
        self.blocks = list(space.element_blocks)

    def write(self, folder, name="part.vtu"):
        path = os.path.join(folder, name)
        self.solid.write_vtu(self.context, path)
        return path

    def net(self, element):
        """Homogeneous, indexed [k, j, i]."""
        p, q, r = self.degrees[element]
        return numpy.array(self.solid.bezier(self.context, element)).reshape(r + 1, q + 1, p + 1, 4)


def contract(net, rows):
    for row in reversed(rows):
        net = numpy.tensordot(row, net, (0, 0))
    return net


def evaluate(net, degree, u):
    h = contract(net, [bernstein(d, x) for d, x in zip(degree, u)])
    return h[:3] / h[3]


def scaled_jacobian(net, degree, u):
    values = [bernstein(d, x) for d, x in zip(degree, u)]
    h = contract(net, values)
    columns = []
    for a in range(3):
        rows = list(values)
        rows[a] = bernstein_derivative(degree[a], u[a])
        d = contract(net, rows)
        columns.append(d[:3] / h[3] - h[:3] * d[3] / h[3] ** 2)
    return numpy.linalg.det(columns) / numpy.prod([numpy.linalg.norm(c) for c in columns])


def read_grid(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    if reader.GetErrorCode():
        raise AssertionError("VTK cannot read it")
    grid = reader.GetOutput()
    grid.reader = reader
    return grid


def vtk_evaluate(cell, u):
    x = [0.0] * 3
    cell.EvaluateLocation(mutable(0), u, x, [0.0] * cell.GetNumberOfPoints())
    return numpy.array(x)


class VtuTest(unittest.TestCase):
    def check_part(self, part):
        rng = random.Random(1)
        with tempfile.TemporaryDirectory() as folder:
            grid = read_grid(part.write(folder))
        n = len(part.degrees)
        self.assertEqual(grid.GetNumberOfCells(), n)
        cells = grid.GetCellData()
        jacobian = vtk_to_numpy(cells.GetArray("ScaledJacobian"))
        self.assertEqual(list(vtk_to_numpy(cells.GetArray("Block"))), part.blocks)
        degrees = vtk_to_numpy(cells.GetHigherOrderDegrees())
        self.assertTrue(numpy.array_equal(degrees, part.degrees))
        self.assertIsNotNone(grid.GetPointData().GetRationalWeights())
        chosen = sorted(set([0, n - 1] + rng.sample(range(n), min(n, 40))))
        for element in chosen:
            self.assertEqual(grid.GetCellType(element), BEZIER_HEXAHEDRON)
            self.check_element(part, grid, element, rng, jacobian[element])

    def check_element(self, part, grid, element, rng, jacobian):
        net, degree = part.net(element), part.degrees[element]
        cell = grid.GetCell(element)
        scale = numpy.abs(net[..., :3] / net[..., 3:]).max()
        self.assertEqual(cell.GetNumberOfPoints(), numpy.prod(degree + 1))
        if max(degree) <= VTK_MAX_DEGREE:
            for _ in range(4):
                u = [rng.random() for _ in range(3)]
                distance = abs(vtk_evaluate(cell, u) - evaluate(net, degree, u)).max()
                self.assertLess(distance, 1e-12 * scale)
        third = [k / 3 for k in range(4)]
        grid4 = [(x, y, z) for x in third for y in third for z in third]
        worst = min(scaled_jacobian(net, degree, u) for u in grid4)
        self.assertAlmostEqual(jacobian, worst, delta=1e-9)

    def test_mixed_degrees(self):
        self.check_part(Part("mixed_sides"))

    def test_rational(self):
        self.check_part(Part("sphere"))

    def test_highest_degree_that_vtk_evaluates(self):
        self.check_part(Part("box", raise_degree=9))

    def test_degree_beyond_vtk(self):
        self.check_part(Part("box", raise_degree=12))

    def check_fields(self, part):
        """What VTK interpolates is sum of c_A R_A, from the space's own extraction."""
        n, rng = part.solid.space.n_functions, random.Random(2)
        scalar = [rng.uniform(-1, 1) for _ in range(n)]
        vector = [[rng.uniform(-1, 1) for _ in range(3)] for _ in range(n)]
        fields = {"temperature": scalar, 'u <"&> ü': vector}
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "part.vtu")
            analysis.write_vtu_fields(part.context, part.solid, path, fields)
            grid = read_grid(path)
        data = [vtk_to_numpy(grid.GetPointData().GetArray(name)) for name in fields]
        self.assertEqual(data[1].shape, (grid.GetNumberOfPoints(), 3))
        control = numpy.array(part.solid.control)
        for element in rng.sample(range(len(part.degrees)), 20):
            ids, rows = part.solid.space.extraction(part.context, element)
            cell = grid.GetCell(element)
            points = [cell.GetPointId(k) for k in range(cell.GetNumberOfPoints())]
            u = [rng.random() for _ in range(3)]
            weights = [0.0] * len(points)
            cell.EvaluateLocation(mutable(0), u, [0.0] * 3, weights)
            b = [bernstein(d, x) for d, x in zip(part.degrees[element], u)]
            b = numpy.multiply.outer(b[2], numpy.multiply.outer(b[1], b[0])).ravel()
            r = numpy.array(rows) @ b * control[ids, 3]
            for values, c in zip(data, (numpy.array(scalar), numpy.array(vector))):
                wanted = r @ c[ids] / r.sum()
                self.assertLess(abs(weights @ values[points] - wanted).max(), 1e-12)

    def test_fields(self):
        self.check_fields(Part("sphere"))
        self.check_fields(Part("mixed_sides"))

    def test_bad_fields(self):
        part = Part("box")
        n = part.solid.space.n_functions
        good, nan = [1.0] * n, [1.0] * (n - 1) + [float("nan")]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "part.vtu")
            for fields in ({"": good}, {"a\nb": good}, {"RationalWeights": good}, {"a": nan}):
                with self.assertRaises(binding.TsolidError):
                    analysis.write_vtu_fields(part.context, part.solid, path, fields)
            with self.assertRaises(ValueError):
                analysis.write_vtu_fields(part.context, part.solid, path, {"a": good[1:]})
            self.assertEqual(os.listdir(folder), [])

    def test_a_wrong_weight_is_seen(self):
        """The comparison above is no tautology: it fails on the polynomial part alone."""
        part = Part("sphere")
        with tempfile.TemporaryDirectory() as folder:
            grid = read_grid(part.write(folder))
        net, u = part.net(3), [0.3, 0.6, 0.2]
        flat = net / net[..., 3:]
        distance = abs(vtk_evaluate(grid.GetCell(3), u) - evaluate(flat, part.degrees[3], u)).max()
        self.assertGreater(distance, 1e-3)

    def test_bytes_are_the_same_every_time(self):
        part = Part("box")
        with tempfile.TemporaryDirectory() as folder:
            written = []
            for name in ("a.vtu", "b.vtu"):
                with open(part.write(folder, name), "rb") as stream:
                    written.append(stream.read())
        self.assertEqual(written[0], written[1])


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
