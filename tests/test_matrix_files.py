#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tsolid export --matrices: the folder alone, without the library, is enough to solve a problem.

Dirichlet sets against loads (functions are not negative: the load of one vanishes exactly where the
function does), a linear solution from the files, regions, refusals, nothing half written."""

import json
import math
import os
import struct
import subprocess
import sys
import tempfile
import unittest

import numpy
import scipy.io
import scipy.sparse.linalg

import binding_parts
from binding_parts import binding
from example_chain import command_path

from freecad.tsolid import analysis  # noqa: E402

COMMAND = os.path.abspath(command_path())
REGIONS = "# name side box\nroot x_low 0 1 0 1\nhalf-face z_high 0 0.5 0.0 1.0 # half\n"


def solid_of(name, **options):
    context = binding.Context()
    boundary = binding.Boundary.create(context, binding_parts.read_example(name), **options)
    space = binding.Space.create(context, boundary, binding.TMesh.create(context, boundary))
    return binding.Solid.create(context, space).optimised(context)


def read_set(path):
    with open(path, "rb") as stream:
        data = stream.read()
    kind, n = struct.unpack_from(">2i", data)
    assert kind == 1211218 and len(data) == 8 + 4 * n
    return list(struct.unpack_from(">%di" % n, data, 8))


def read_petsc_vector(path):
    with open(path, "rb") as stream:
        data = stream.read()
    kind, n = struct.unpack_from(">2i", data)
    assert kind == 1211214 and len(data) == 8 + 8 * n
    return numpy.frombuffer(data, ">f8", n, 8)


class FolderTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.context = binding.Context()
        cls.solids = {name: solid_of(name) for name in ("wedge", "sphere")}
        for name, solid in cls.solids.items():
            solid.write(cls.context, cls.path(name + ".tsolid"))

    @classmethod
    def path(cls, *words):
        return os.path.join(cls.holder.name, *words)

    def run_command(self, *words):
        return subprocess.run(
            [COMMAND, "export"] + list(words),
            cwd=self.holder.name,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
        )

    def export(self, name, folder, *options, said=""):
        run = self.run_command(name + ".tsolid", "--matrices", folder, *options)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertRegex(run.stderr, "^%s$" % said)
        with open(self.path(folder, "index.json"), encoding="utf-8") as stream:
            return json.load(stream)

    def read(self, folder, name):
        return scipy.io.mmread(self.path(folder, name))

    def check_refused(self, words, *arguments):
        before = sorted(os.listdir(self.holder.name))
        run = self.run_command(*arguments)
        self.assertEqual(run.returncode, 1)
        self.assertIn(words, run.stderr)
        self.assertEqual(run.stderr.count("error:"), 1, run.stderr)
        self.assertEqual(sorted(os.listdir(self.holder.name)), before)

    def test_a_problem_from_the_files_alone(self):
        """Laplace with linear data on all faces."""
        for name in ("wedge", "sphere"):
            index = self.export(name, name + "_m")
            self.assertEqual((index["format"], index["version"]), ("tsolid matrices", 1))
            self.assertIs(index["proved"], True)
            self.assertEqual(sorted(index["matrices"]), ["laplace", "mass"])
            files = {"index.json", "control.mtx", "mass.mtx", "laplace.mtx"}
            files |= {f for face in index["faces"] for f in face["load"]}
            self.assertEqual(set(os.listdir(self.path(name + "_m"))), files)
            laplace = self.read(name + "_m", "laplace.mtx").tocsr()
            control = self.read(name + "_m", "control.mtx")
            exact = control[:, :3] @ numpy.array([0.3, -1.1, 0.7]) + 2.0
            fixed = sorted({f for face in index["faces"] for f in face["functions"]})
            n_inside = index["n_functions"] - index["n_surface"]
            self.assertEqual(fixed, list(range(n_inside, index["n_functions"])))
            free = numpy.arange(n_inside)
            right = -laplace[free][:, fixed] @ exact[fixed]
            found = scipy.sparse.linalg.spsolve(laplace[free][:, free].tocsc(), right)
            self.assertLess(abs(found - exact[free]).max() / abs(exact).max(), 1e-9)

    def test_dirichlet_sets_are_where_loads_are(self):
        boxes = [(0.0, 1.0, 0.0, 1.0), (0.0, 0.5, 0.25, 1.0), (0.3, 0.31, 0.7, 0.8)]
        for name, solid in self.solids.items():
            seen = set()
            for side in range(6):
                for box in boxes:
                    load = numpy.array(analysis.face_load(self.context, solid, side, box))
                    found = analysis.face_functions(self.context, solid, side, box)
                    self.assertGreaterEqual(load.min(), 0)
                    self.assertEqual(found, list(numpy.flatnonzero(load)))
                    seen.update(found if box is boxes[0] else ())
            n = solid.space.n_functions
            self.assertEqual(seen, set(range(n - solid.space.n_surface, n)))

    def test_petsc_and_market_say_the_same(self):
        words = ("--format", "both", "--young", "3", "--poisson=-0.2", "--regions", "r.txt")
        with open(self.path("r.txt"), "w") as stream:
            stream.write(REGIONS)
        index = self.export("sphere", "both", *words)
        self.assertEqual(index["material"], {"young": 3.0, "poisson": -0.2})
        solid = self.solids["sphere"]
        matrix = analysis.Matrix.create(self.context, solid, 2, 3.0, -0.2)
        start, column, value = (numpy.array(x) for x in matrix.arrays())
        want = scipy.sparse.csr_matrix((value, column, start.astype(numpy.int64)))
        lower = scipy.sparse.tril(want)
        full = lower + scipy.sparse.tril(want, -1).T
        self.assertEqual(abs(self.read("both", "elasticity.mtx") - full).max(), 0)
        matrix.write_petsc(self.context, self.path("e.petsc"))
        with open(self.path("e.petsc"), "rb") as one:
            with open(self.path("both", "elasticity.petsc"), "rb") as two:
                self.assertEqual(one.read(), two.read())
        root, half = index["faces"]
        self.assertEqual((root["name"], half["name"]), ("root", "half-face"))
        self.assertEqual(root["pieces"], [{"side": 0, "box": [0.0, 1.0, 0.0, 1.0]}])
        self.assertEqual(half["pieces"], [{"side": 5, "box": [0.0, 0.5, 0.0, 1.0]}])
        whole = sum(analysis.face_load(self.context, solid, 5))
        self.assertAlmostEqual(half["area"] / whole, 0.5, delta=1e-9)  # symmetry of the sphere
        for face in (root, half):
            self.assertEqual(read_set(self.path("both", face["functions_file"])), face["functions"])
            text, binary = (self.path("both", f) for f in face["load"])
            load = read_petsc_vector(binary)
            self.assertTrue(numpy.array_equal(scipy.io.mmread(text).ravel(), load))
            self.assertAlmostEqual(math.fsum(load) / face["area"], 1, delta=1e-14)
        points = read_petsc_vector(self.path("both", "points.petsc")).reshape(-1, 3)
        control = numpy.array(solid.control)
        self.assertTrue(numpy.array_equal(points, control[:, :3] / control[:, 3:]))
        table = self.read("both", "control.mtx")
        self.assertTrue(numpy.array_equal(table, numpy.column_stack([points, control[:, 3]])))

    def test_a_face_in_pieces(self):
        """Lines of one name: loads add up, sets unite."""
        with open(self.path("p.txt"), "w") as stream:
            stream.write("a x_low 0 1 0 1\nb z_high 0 1 0 1\na y_low 0 1 0 0.5\n")
        index = self.export("wedge", "pieces", "--kinds", "mass", "--regions", "p.txt")
        a, b = index["faces"]
        self.assertEqual((a["name"], b["name"], len(a["pieces"])), ("a", "b", 2))
        solid, boxes = self.solids["wedge"], ((0, (0, 1, 0, 1)), (2, (0, 1, 0, 0.5)))
        loads = [analysis.face_load(self.context, solid, *box) for box in boxes]
        found = self.read("pieces", "load_a.mtx").ravel()
        self.assertTrue(numpy.array_equal(found, numpy.sum(loads, axis=0)))
        sets = [analysis.face_functions(self.context, solid, *box) for box in boxes]
        self.assertEqual(a["functions"], sorted(set(sets[0]) | set(sets[1])))

    def test_tables_read_back(self):
        rows = [(1.5, -2.0, 1e300), (0.1, 5e-324, 7.0)]
        path = self.path("table.mtx")
        analysis.write_table(self.context, 3, rows, path)
        self.assertTrue(numpy.array_equal(scipy.io.mmread(path), rows))
        n, m, values = analysis.read_table(self.context, path)
        self.assertEqual((n, m, list(values)), (2, 3, [x for row in rows for x in row]))
        scipy.io.mmwrite(path, numpy.array(rows), comment="of another writer")
        self.assertEqual(analysis.read_table(self.context, path), (n, m, values))
        with open(self.path("v.petsc"), "wb") as stream:
            stream.write(struct.pack(">2i2d", 1211214, 2, 0.25, -3.0))
        read = analysis.read_table(self.context, self.path("v.petsc"))
        self.assertEqual((read[0], read[1], list(read[2])), (2, 1, [0.25, -3.0]))

    def test_bad_tables(self):
        good = b"%%MatrixMarket matrix array real general\n% x\n2 1\n1\n2\n"
        self.check_table(good, None)
        for old, new in (
            (b"array", b"coordinate"),
            (b"general", b"symmetric"),
            (b"2 1", b"3 1"),
            (b"2 1", b"1 1"),
            (b"2 1", b"200000000 100"),
            (b"2 1", b"2 0"),
            (b"2 1", b"-2 1"),
            (b"\n2\n", b"\nnan\n"),
            (b"\n2\n", b"\n2x\n"),
        ):
            self.check_table(good.replace(old, new, 1), binding.header.Status.ERROR_INPUT)
        for n in range(len(good) - 2):
            self.check_table(good[:n], binding.header.Status.ERROR_INPUT)
        petsc = struct.pack(">2i2d", 1211214, 2, 0.25, -3.0)
        for bad in (petsc[:-1], petsc + b"x", struct.pack(">2i2d", 1211214, 2, math.inf, 0)):
            self.check_table(bad, binding.header.Status.ERROR_INPUT)

    def check_table(self, data, status):
        with open(self.path("bad.mtx"), "wb") as stream:
            stream.write(data)
        try:
            analysis.read_table(self.context, self.path("bad.mtx"))
            found = None
        except binding.TsolidError as error:
            found = error.status
        self.assertEqual(found, status, data)

    def test_refused(self):
        """One sentence each."""

        def regions(text):
            with open(self.path("bad.txt"), "w") as stream:
                stream.write(text)
            return ("wedge.tsolid", "--matrices", "no", "--regions", "bad.txt")

        regions("")
        start = ("wedge.tsolid", "--matrices", "no")
        self.check_refused("needs a material", *start, "--kinds", "mass,elasticity")
        self.check_refused("not 'mess'", *start, "--kinds", "mess")
        self.check_refused("Poisson's ratio 0.5", *start, "--young", "1", "--poisson", "0.5")
        self.check_refused("not a folder", "wedge.tsolid", "--matrices", "wedge.tsolid")
        self.check_refused("No such file", "wedge.tsolid", "--matrices", "none/no")
        for text, words in (
            ("", "names no region"),
            ("a x_low 0 1 0\n", "Line 1"),
            ("a side 0 1 0 1\n", "Line 1"),
            ("\n../b x_low 0 1 0 1\n", "Line 2"),
            ("a x_low 0.5 0.5 0 1\n", "Line 1"),
            ("a x_low nan 1 0 1\n", "Line 1"),
            ("a x_low 0 1 0 1 7\n", "Line 1"),
            ("a" * 600, "too long"),
        ):
            self.check_refused(words, *regions(text))

    def test_not_proved(self):
        """Refused; when forced, the index says so. A corner is pushed in: inverted there."""
        patches = binding_parts.cube(lambda *x: (0.2, 0.2, 0.2) if x == (1, 1, 1) else x)
        boundary = binding.Boundary.create(self.context, patches)
        tmesh = binding.TMesh.create(self.context, boundary)
        space = binding.Space.create(self.context, boundary, tmesh)
        binding.Solid.create(self.context, space).write(self.context, self.path("dent.tsolid"))
        self.check_refused("not proved valid", "dent.tsolid", "--matrices", "no")
        index = self.export("dent", "dent_m", "--force", said="warning: det J is not positive.*\n")
        self.assertIs(index["proved"], False)

    def test_fields_by_the_command(self):
        """Coefficients in, the field at VTK's corner points out: x is a field like any other."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

        control = numpy.array(self.solids["sphere"].control)
        points = control[:, :3] / control[:, 3:]
        analysis.write_table(self.context, 3, points.tolist(), self.path("x.mtx"))
        with open(self.path("y.petsc"), "wb") as stream:
            stream.write(struct.pack(">2i", 1211214, len(points)))
            stream.write(points[:, 1].astype(">f8").tobytes())
        words = ("sphere.tsolid", "--vtu", "f.vtu", "--field", "place=x.mtx", "--field=y=y.petsc")
        run = self.run_command(*words)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(self.path("f.vtu"))
        reader.Update()
        grid = reader.GetOutput()
        at = vtk_to_numpy(grid.GetPoints().GetData())
        place, y = (vtk_to_numpy(grid.GetPointData().GetArray(n)) for n in ("place", "y"))
        self.assertLess(abs(place - at).max(), 1e-12 * abs(at).max())
        self.assertLess(abs(y - at[:, 1]).max(), 1e-12 * abs(at).max())
        start = ("sphere.tsolid", "--vtu", "no.vtu", "--field")
        self.check_refused("takes NAME=FILE", *start, "y.petsc")
        self.check_refused("takes NAME=FILE", *start, "=y.petsc")
        self.check_refused("which is missing", start[0], "--bext", "b", "--field", "y=y.petsc")
        self.check_refused("No such file", *start, "y=no.petsc")
        self.check_refused("needs a name of its own", *start, "y=y.petsc", words[-1])
        analysis.write_table(self.context, 1, [1.0, 2.0], self.path("short.mtx"))
        self.check_refused("has 2 numbers; the solid has", *start, "y=short.mtx")

    def test_files_of_others_stay(self):
        os.mkdir(self.path("used"))
        with open(self.path("used", "mine.txt"), "w") as stream:
            stream.write("mine")
        for _ in range(2):
            self.export("wedge", "used", "--kinds", "mass")
        self.assertIn("mine.txt", os.listdir(self.path("used")))


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
