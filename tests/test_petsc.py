#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The PETSc example, unchanged on one and on two processes, against a direct solution by scipy; its
result on the solid as VTK reads it. Skipped where petsc4py or mpirun are missing."""

import glob
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import binding_parts
import numpy
import scipy.sparse.linalg
from binding_parts import ROOT, binding
from example_chain import command_path

from freecad.tsolid import analysis

COMMAND = os.path.abspath(command_path())
# Debian's module is found without the development files only when told where it is.
PLACES = sorted(glob.glob("/usr/lib/petscdir/petsc*/*-real"))
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", TSOLID_COMMAND=COMMAND)
if PLACES:
    ENVIRONMENT.setdefault("PETSC_DIR", PLACES[-1])
YOUNG, POISSON, TRACTION = 210e3, 0.3, (1.0, 2.0, -5.0)


def has_petsc():
    line = ["/usr/bin/python3", "-c", "import petsc4py"]
    return subprocess.run(line, env=ENVIRONMENT, stderr=subprocess.DEVNULL).returncode == 0


@unittest.skipUnless(has_petsc(), "petsc4py is missing")
@unittest.skipUnless(shutil.which("mpirun"), "mpirun is missing")
class PetscTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.context = binding.Context()
        patches = binding_parts.read_example("elbow")
        boundary = binding.Boundary.create(cls.context, patches)
        space = binding.Space.create(
            cls.context, boundary, binding.TMesh.create(cls.context, boundary)
        )
        cls.solid = binding.Solid.create(cls.context, space).optimised(cls.context)
        cls.solid.write(cls.context, cls.path("elbow.tsolid"))
        words = "export elbow.tsolid --matrices m --format petsc".split()
        material = ["--young", str(YOUNG), "--poisson", str(POISSON)]
        subprocess.run([COMMAND] + words + material, cwd=cls.holder.name, check=True)

    @classmethod
    def path(cls, name):
        return os.path.join(cls.holder.name, name)

    def run_example(self, n, *words, code=0):
        script = os.path.join(ROOT, "resources", "examples", "solve_petsc.py")
        line = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(n)]
        run = subprocess.run(
            line + ["/usr/bin/python3", script, "m"] + list(words),
            cwd=self.holder.name,
            env=ENVIRONMENT,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            universal_newlines=True,
        )
        self.assertEqual(run.returncode != 0, code != 0, run.stdout)
        print(run.stdout.strip())
        return run.stdout

    def read(self, name):
        return numpy.array(analysis.read_table(self.context, self.path(name))[2])

    def direct(self, kind, loaded, traction, fixed):
        matrix = analysis.Matrix.create(self.context, self.solid, kind, YOUNG, POISSON)
        start, column, value = (numpy.array(x) for x in matrix.arrays())
        k = scipy.sparse.csr_matrix((value, column, start.astype(numpy.int64))).tocsc()
        width = len(traction)
        load = numpy.array(analysis.face_load(self.context, self.solid, loaded))
        right = numpy.outer(load, traction).ravel()
        functions = numpy.array(analysis.face_functions(self.context, self.solid, fixed))
        rows = (width * functions[:, None] + numpy.arange(width)).ravel()
        free = numpy.setdiff1d(numpy.arange(len(right)), rows)
        out = numpy.zeros(len(right))
        out[free] = scipy.sparse.linalg.spsolve(k[free][:, free], right[free])
        return out

    def test_elasticity(self):
        words = ["--fixed", "x_low", "--load", "x_high"] + [str(t) for t in TRACTION]
        vtu = ["--solid", "elbow.tsolid", "--vtu", "elbow.vtu"]
        found = []
        for n in (1, 2):
            text = self.run_example(n, *words, *vtu, "--out", "u%d.petsc" % n)
            self.assertIn("%d processes" % n, text)
            found.append(self.read("u%d.petsc" % n))
        scale = abs(found[0]).max()
        print("1 and 2 processes differ by %.2g" % (abs(found[0] - found[1]).max() / scale))
        self.assertLess(abs(found[0] - found[1]).max(), 1e-10 * scale)
        wanted = self.direct(2, 1, TRACTION, 0)
        self.assertLess(abs(found[0] - wanted).max(), 1e-8 * scale)
        self.check_vtu(found[1].reshape(-1, 3))

    def check_vtu(self, wanted):
        """The displacement of a corner of the solid is its function's coefficient."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(self.path("elbow.vtu"))
        reader.Update()
        grid = reader.GetOutput()
        points = vtk_to_numpy(grid.GetPoints().GetData())
        moved = vtk_to_numpy(grid.GetPointData().GetArray("displacement"))
        control = numpy.array(self.solid.control)
        for corner in self.solid.boundary.requirement["corner"]:
            at = numpy.linalg.norm(points - corner, axis=1).argmin()
            function = numpy.linalg.norm(control[:, :3] / control[:, 3:] - corner, axis=1).argmin()
            self.assertLess(abs(moved[at] - wanted[function]).max(), 1e-12 * abs(wanted).max())

    def test_heat(self):
        words = ["--kind", "laplace", "--fixed", "x_low", "--load", "x_high", "2.5"]
        self.run_example(2, *words, "--out", "t.petsc", "-pc_type", "jacobi")
        wanted = self.direct(1, 1, (2.5,), 0)
        self.assertLess(abs(self.read("t.petsc") - wanted).max(), 1e-9 * abs(wanted).max())

    def test_wrong_arguments(self):
        text = self.run_example(1, "--fixed", "nowhere", "--out", "no.petsc", code=1)
        self.assertIn("--fixed takes one of x_low", text)
        self.assertFalse(os.path.exists(self.path("no.petsc")))


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
