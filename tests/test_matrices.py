#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Matrices and loads: volumes, areas, rigid motions, the linear patch test, files, threads."""

import math
import os
import struct
import sys
import tempfile
import unittest

import numpy
import scipy.io
import scipy.sparse
import scipy.sparse.linalg

import binding_parts
from binding_parts import binding, header

from freecad.tsolid import analysis  # noqa: E402
from freecad.tsolid.header import MatrixKind  # noqa: E402

YOUNG, POISSON = 3.0, 0.3


def solid_of(patches):
    context = binding.Context()
    boundary = binding.Boundary.create(context, patches)
    space = binding.Space.create(context, boundary, binding.TMesh.create(context, boundary))
    return binding.Solid.create(context, space).optimised(context)


def sparse(matrix):
    start, column, value = (numpy.array(x) for x in matrix.arrays())
    shape = (matrix.n_rows, matrix.n_rows)
    return scipy.sparse.csr_matrix((value, column, start.astype(numpy.int64)), shape=shape)


def read_petsc(path):
    with open(path, "rb") as stream:
        data = stream.read()
    kind, rows, columns, n = struct.unpack_from(">4i", data)
    per_row = numpy.frombuffer(data, ">i4", rows, 16)
    column = numpy.frombuffer(data, ">i4", n, 16 + 4 * rows)
    value = numpy.frombuffer(data, ">f8", n, 16 + 4 * rows + 4 * n)
    start = numpy.concatenate(([0], numpy.cumsum(per_row)))
    assert kind == 1211216 and len(data) == 16 + 4 * rows + 12 * n
    return scipy.sparse.csr_matrix((value.astype(float), column, start), shape=(rows, columns))


class MatrixTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.context = binding.Context()
        cls.parts = {n: solid_of(binding_parts.read_example(n)) for n in ("sphere", "wedge")}
        cls.parts["box"] = solid_of(binding_parts.cube(lambda x, y, z: (2 * x, 3 * y, 5 * z)))

    def matrix(self, solid, kind):
        return analysis.Matrix.create(self.context, solid, kind, YOUNG, POISSON)

    def points(self, solid):
        control = numpy.array(solid.control)
        return control[:, :3] / control[:, 3:]

    def volume(self, solid):
        return binding.Report.measure(self.context, solid).struct.conformity.volume

    def test_constants_and_coordinates(self):
        """x = sum of P_A R_A: so mass gives the volume and moments, Laplace the volume again."""
        for name, solid in self.parts.items():
            x, volume = self.points(solid), self.volume(solid)
            one = numpy.ones(len(x))
            mass, laplace = (sparse(self.matrix(solid, k)) for k in (0, 1))
            exact = 1e-9 if name == "sphere" else 1e-12  # rational: by quadrature
            self.assertAlmostEqual(one @ mass @ one / volume, 1, delta=exact)
            self.assertLess(abs(laplace @ one).max(), 1e-13 * abs(laplace).max() * 100)
            gram = x.T @ (laplace @ x) / volume
            self.assertLess(abs(gram - numpy.eye(3)).max(), exact, name)
            self.assertGreater(mass.diagonal().min(), 0)

    def test_rigid_motions_and_stretches(self):
        for name, solid in self.parts.items():
            x, volume = self.points(solid), self.volume(solid)
            stiffness = sparse(self.matrix(solid, MatrixKind.ELASTICITY))
            self.assertLess(abs(stiffness - stiffness.T).max(), 1e-14 * abs(stiffness).max())
            scale = abs(stiffness).max() * abs(x).max()
            for axis in range(3):
                turned = numpy.zeros_like(x)
                turned[:, (axis + 1) % 3] = -x[:, (axis + 2) % 3]
                turned[:, (axis + 2) % 3] = x[:, (axis + 1) % 3]
                moved = numpy.zeros_like(x)
                moved[:, axis] = 1
                self.assertLess(abs(stiffness @ turned.ravel()).max(), 1e-12 * scale, name)
                self.assertLess(abs(stiffness @ moved.ravel()).max(), 1e-12 * scale, name)
                stretched = numpy.zeros_like(x)
                stretched[:, axis] = x[:, axis]
                energy = stretched.ravel() @ stiffness @ stretched.ravel()
                modulus = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
                exact = 1e-9 if name == "sphere" else 1e-12
                self.assertAlmostEqual(energy / (modulus * volume), 1, delta=exact)

    def test_linear_patch_test(self):
        for name, solid in self.parts.items():
            x = self.points(solid)
            inner = numpy.arange(len(x) - solid.space.n_surface)
            outer = numpy.arange(len(inner), len(x))
            laplace = sparse(self.matrix(solid, MatrixKind.LAPLACE))
            given = x @ numpy.array([0.3, -1.1, 0.7]) + 2.0
            right = -laplace[inner][:, outer] @ given[outer]
            found = scipy.sparse.linalg.spsolve(laplace[inner][:, inner].tocsc(), right)
            error = abs(found - given[inner]).max() / abs(given).max()
            print("%s: linear patch test %.2g" % (name, error))
            self.assertLess(error, 1e-9)

    def test_elastic_patch_test(self):
        """A linear displacement given on the boundary is found inside."""
        gradient = numpy.array([[1.0, 0.4, -0.2], [0.1, -0.7, 0.3], [0.5, 0.2, 0.6]])
        for name, solid in self.parts.items():
            given = self.points(solid) @ gradient.T + numpy.array([1.0, 2.0, 3.0])
            n = 3 * (len(given) - solid.space.n_surface)
            stiffness = sparse(self.matrix(solid, MatrixKind.ELASTICITY))
            right = -stiffness[:n, n:] @ given.ravel()[n:]
            found = scipy.sparse.linalg.spsolve(stiffness[:n, :n].tocsc(), right)
            error = abs(found - given.ravel()[:n]).max() / abs(given).max()
            print("%s: elastic patch test %.2g" % (name, error))
            self.assertLess(error, 1e-9)

    def test_loads(self):
        box = self.parts["box"]
        areas = sorted(sum(analysis.face_load(self.context, box, k)) for k in range(6))
        numpy.testing.assert_allclose(areas, [6, 6, 10, 10, 15, 15], rtol=1e-13)
        part = sum(analysis.face_load(self.context, box, 2, (0.25, 1.0, 0.1, 0.6)))
        whole = sum(analysis.face_load(self.context, box, 2))
        self.assertAlmostEqual(part / whole, 0.375, delta=1e-13)
        ball = self.parts["sphere"]
        radius = numpy.linalg.norm(ball.boundary.requirement["corner"][0])
        x = self.points(ball)
        for side in range(6):
            load = numpy.array(analysis.face_load(self.context, ball, side))
            self.assertAlmostEqual(load.sum() / (4 * math.pi * radius**2 / 6), 1, delta=1e-9)
            self.assertEqual(abs(load[: len(x) - ball.space.n_surface]).max(), 0)

    def test_files(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "m")
            for kind in MatrixKind:
                matrix = self.matrix(self.parts["wedge"], kind)
                want = sparse(matrix)
                matrix.write_market(self.context, path + ".mtx")
                matrix.write_petsc(self.context, path + ".petsc")
                self.assertEqual(abs(read_petsc(path + ".petsc") - want).max(), 0)
                lower = scipy.sparse.tril(want)
                full = lower + scipy.sparse.tril(want, -1).T
                self.assertEqual(abs(scipy.io.mmread(path + ".mtx") - full).max(), 0)

    def test_threads(self):
        solid = self.parts["wedge"]
        for kind in MatrixKind:
            values = []
            for threads in (1, 3):
                context = binding.Context(threads=threads)
                matrix = analysis.Matrix.create(context, solid, kind, YOUNG, POISSON)
                values.append(matrix.arrays()[2].tobytes())
            self.assertEqual(*values)

    def test_bad_material(self):
        bad = ((0, 0.3), (-1, 0.3), (1, 0.5), (1, -1), (math.nan, 0), (1, math.nan))
        for young, poisson in bad:
            with self.assertRaises(binding.TsolidError) as caught:
                analysis.Matrix.create(self.context, self.parts["box"], 2, young, poisson)
            self.assertEqual(caught.exception.status, header.Status.ERROR_ARGUMENT)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
