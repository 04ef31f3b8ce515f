#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""VTK reads the hexahedra: nodes, volumes, mid nodes on the right edges, faces of regions that look
outward, names of any letters."""

import os
import sys
import tempfile
import unittest

import binding_parts
import numpy
from binding_parts import binding
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from freecad.tsolid import analysis

HEXAHEDRON, QUADRATIC, QUAD, QUADRATIC_QUAD = 12, 25, 9, 23


def read_grid(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    if reader.GetErrorCode():
        raise AssertionError("VTK cannot read it")
    return reader.GetOutput()


class HexVtuTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.context = binding.Context()
        patches = binding_parts.read_example("elbow")
        boundary = binding.Boundary.create(cls.context, patches)
        tmesh = binding.TMesh.create(cls.context, boundary)
        space = binding.Space.create(cls.context, boundary, tmesh)
        cls.solid = binding.Solid.create(cls.context, space).optimised(cls.context)

    def grid(self, **options):
        mesh = analysis.HexMesh.create(self.context, self.solid, divisions=(3, 4, 5, 2), **options)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "mesh.vtu")
            mesh.write_vtu(self.context, path)
            return mesh, read_grid(path)

    def test_nodes_and_cells(self):
        for order, kind, width in ((1, HEXAHEDRON, 8), (2, QUADRATIC, 20)):
            mesh, grid = self.grid(order=order)
            self.assertTrue(numpy.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), mesh.nodes))
            region = vtk_to_numpy(grid.GetCellData().GetArray("Region"))
            elements = numpy.array(mesh.elements)
            for e in range(len(elements)):
                self.assertEqual((grid.GetCellType(e), region[e]), (kind, 0))
                cell = grid.GetCell(e)
                ids = [cell.GetPointId(k) for k in range(width)]
                self.assertEqual(ids, list(elements[e]))

    def test_vtk_sees_no_fold(self):
        """In VTK's own shape functions: every Jacobian is positive, mid nodes are the middles."""
        for order in (1, 2):
            mesh, grid = self.grid(order=order)
            for e in range(0, len(mesh.elements), 7):
                cell = grid.GetCell(e)
                n = cell.GetNumberOfPoints()
                x = numpy.array([cell.GetPoints().GetPoint(k) for k in range(n)])
                for u in numpy.random.RandomState(e).rand(5, 3):
                    slopes = [0.0] * (3 * n)
                    cell.InterpolateDerivs(u, slopes)
                    jacobian = numpy.reshape(slopes, (3, n)) @ x
                    self.assertGreater(numpy.linalg.det(jacobian), 0)
                for k in range(12 if order == 2 else 0):
                    edge = cell.GetEdge(k)
                    ends = [numpy.array(edge.GetPoints().GetPoint(m)) for m in range(3)]
                    length = numpy.linalg.norm(ends[1] - ends[0])
                    middle = numpy.linalg.norm(ends[2] - (ends[0] + ends[1]) / 2)
                    self.assertLess(middle, 0.2 * length)

    def test_regions(self):
        """Quadrilaterals look out of the part: the flux of x through them is three volumes."""
        names = ["Fläche 1", "two <&>"]
        given = [(name, side, (0.0, 1.0, 0.0, 1.0)) for side, name in enumerate(names)]
        mesh, grid = self.grid(order=2, regions=given)
        array = grid.GetFieldData().GetAbstractArray("RegionNames")
        found = [array.GetValue(k) for k in range(array.GetNumberOfValues())]
        self.assertEqual(found, names)
        for order, kind in ((1, QUAD), (2, QUADRATIC_QUAD)):
            mesh, grid = self.grid(order=order)
            region = vtk_to_numpy(grid.GetCellData().GetArray("Region"))
            n = len(mesh.elements)
            counts = [len(faces) for faces in mesh.regions.values()]
            self.assertEqual(list(numpy.bincount(region)[1:]), counts)
            flux = volume = 0.0
            for k in range(n, grid.GetNumberOfCells()):
                self.assertEqual(grid.GetCellType(k), kind)
                flux += self.flux(grid.GetCell(k))
            for k in range(n):
                volume += self.volume(grid.GetCell(k))
            self.assertAlmostEqual(flux / (3 * volume), 1, delta=1e-12)

    @staticmethod
    def gauss():
        x, w = numpy.polynomial.legendre.leggauss(5)
        return (x + 1) / 2, w / 2

    def flux(self, cell):
        total, (x, w) = 0.0, self.gauss()
        n = cell.GetNumberOfPoints()
        nodes = numpy.array([cell.GetPoints().GetPoint(k) for k in range(n)])
        for s, a in zip(x, w):
            for t, b in zip(x, w):
                at, slopes, weights = [0.0] * 3, [0.0] * (2 * n), [0.0] * n
                cell.EvaluateLocation(mutable(0), (s, t, 0.0), at, weights)
                cell.InterpolateDerivs((s, t, 0.0), slopes)
                ds, dt = numpy.reshape(slopes, (2, n)) @ nodes
                total += a * b * numpy.dot(at, numpy.cross(ds, dt))
        return total

    def volume(self, cell):
        total, (x, w) = 0.0, self.gauss()
        n = cell.GetNumberOfPoints()
        nodes = numpy.array([cell.GetPoints().GetPoint(k) for k in range(n)])
        for i, a in zip(x, w):
            for j, b in zip(x, w):
                for k, c in zip(x, w):
                    slopes = [0.0] * (3 * n)
                    cell.InterpolateDerivs((i, j, k), slopes)
                    jacobian = numpy.reshape(slopes, (3, n)) @ nodes
                    total += a * b * c * numpy.linalg.det(jacobian)
        return total


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
