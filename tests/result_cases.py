# SPDX-License-Identifier: LGPL-2.1-or-later
"""Results kept with a SolidTSpline and shown as colours; runs inside FreeCADCmd (test_results.py).

The control points' coordinates are the coefficients of the functions x, y and z: a result that is
known at every point, on rational solids too."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

import binding_parts
import FreeCAD
import numpy
import Part
from binding_parts import binding

from freecad.tsolid import analysis, api, document, files, picture, results, section, tessellate


class Results(unittest.TestCase):
    def setUp(self):
        self.addCleanup(lambda: [FreeCAD.closeDocument(n) for n in list(FreeCAD.listDocuments())])
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = holder.name

    def object_of(self, name):
        self.doc = FreeCAD.newDocument()
        patches = binding_parts.read_example(name)
        result = api.build(api.Part.of_patches(patches), api.Options(effort="none"))
        obj = document.create(document=self.doc)
        document.store(obj, result)
        return obj

    @staticmethod
    def points(solid):
        control = numpy.array(solid.control)
        return control[:, :3] / control[:, 3:]

    def test_colours_are_the_field(self):
        for name in ("sphere", "mixed_sides"):
            obj = self.object_of(name)
            solid = document.solid_of(obj)
            look = tessellate.Look(picture.Elements.of(binding.Context(), solid))
            look.solid = solid
            results.colour(look, obj)
            self.assertIsNone(look.result)
            grey = look.colours("Result")
            self.assertEqual(len(numpy.unique(grey)), 1)
            for axis in range(3):
                results.put(obj, "place", self.points(solid)[:, axis])
                results.colour(look, obj)
                error = abs(look.result - look.point[:, axis]).max()
                self.assertLess(error, 1e-6 * look.size)  # points are single precision
            results.put(obj, "place", self.points(solid))
            results.colour(look, obj)
            length = numpy.linalg.norm(look.point.astype(float), axis=1)
            self.assertLess(abs(look.result - length).max(), 1e-6 * look.size)
            self.assertEqual(look.result_range, (look.result.min(), look.result.max()))
            shades = look.colours("Result")
            self.assertEqual(shades[look.result.argmin()], tessellate.packed(tessellate.SCALE[0]))
            self.assertEqual(shades[look.result.argmax()], tessellate.packed(tessellate.SCALE[-1]))

    def test_the_cut_shows_the_field(self):
        obj = self.object_of("sphere")
        solid = document.solid_of(obj)
        look = tessellate.Look(picture.Elements.of(binding.Context(), solid))
        look.solid = solid
        grids = section.Grids(look)
        results.put(obj, "y", self.points(solid)[:, 1])
        results.colour(look, obj)
        everything = numpy.ones(look.n, bool)
        triangles, values, owner, _ = grids.cut(everything, 0, 1.5, grids.result())
        self.assertGreater(len(owner), 100)
        self.assertLess(abs(values - triangles[..., 1]).max(), 1e-5 * look.size)
        packed = section.colours(look, "Result", values, owner)
        self.assertEqual(len(packed), 3 * len(owner))
        self.assertGreater(len(numpy.unique(packed)), 50)
        results.put(obj, "z", self.points(solid)[:, 2])
        results.colour(look, obj)
        values = grids.cut(everything, 0, 1.5, grids.result())[1]
        self.assertLess(abs(values - triangles[..., 2]).max(), 1e-5 * look.size)

    def test_kept_in_the_document(self):
        obj = self.object_of("box")
        solid = document.solid_of(obj)
        rows = self.points(solid)
        self.assertIsNone(results.of(obj))
        path = os.path.join(self.folder, "moved.mtx")
        analysis.write_table(binding.Context(), 3, rows.tolist(), path)
        results.read(obj, path)
        saved = os.path.join(self.folder, "x.FCStd")
        self.doc.saveAs(saved)
        name = obj.Name
        FreeCAD.closeDocument(self.doc.Name)
        again = FreeCAD.openDocument(saved).getObject(name)
        found = results.of(again)
        self.assertEqual(found[:2], ("moved", 3))
        self.assertTrue(numpy.array_equal(numpy.reshape(found[2], (-1, 3)), rows))
        results.write_vtu(again, os.path.join(self.folder, "x.vtu"))
        with open(os.path.join(self.folder, "x.vtu"), "rb") as stream:
            self.assertIn(b'Name="moved" NumberOfComponents="3"', stream.read(2000))
        other = api.build(
            api.Part.of_patches(binding_parts.read_example("box")),
            api.Options(effort="none", min_cells=4),
        )
        document.store(again, other)
        self.assertIsNone(results.of(again))  # of another solid

    def test_faces_for_the_command(self):
        """The command takes what is written of the faces, and every face has its area."""
        self.doc = FreeCAD.newDocument()
        source = self.doc.addObject("Part::Feature", "Source")
        source.Shape = Part.makeBox(3, 4, 5)
        obj = document.create(source)
        document.set_options(obj, api.Options(effort="none"))
        document.rebuild(obj)
        for ending in (".regions", ".tsolid"):
            files.write(obj, os.path.join(self.folder, "box" + ending))
        command = os.path.join(os.path.dirname(binding_parts.library_path()), "tsolid")
        words = ["export", "box.tsolid", "--matrices", "m", "--regions", "box.regions"]
        subprocess.run([command] + words + ["--kinds", "mass"], cwd=self.folder, check=True)
        with open(os.path.join(self.folder, "m", "index.json")) as stream:
            faces = {face["name"]: face["area"] for face in json.load(stream)["faces"]}
        wanted = {"Face%d" % (k + 1): face.Area for k, face in enumerate(source.Shape.Faces)}
        self.assertEqual(set(faces), set(wanted))
        for name, area in wanted.items():
            self.assertAlmostEqual(faces[name] / area, 1, delta=1e-12)

    def test_what_does_not_fit(self):
        obj = self.object_of("box")
        n = document.solid_of(obj).space.n_functions
        for bad in ([], [1.0] * (n - 1), [1.0] * (2 * n), [float("nan")] * n):
            with self.assertRaises(ValueError):
                results.put(obj, "bad", bad)
        self.assertIsNone(results.of(obj))
        results.put(obj, "good", [1.0] * n)
        self.assertEqual(results.of(obj)[:2], ("good", 1))
        results.clear(obj)
        self.assertIsNone(results.of(obj))
        with self.assertRaises(ValueError):
            results.put(document.create(document=self.doc), "empty", [1.0])


if __name__ == "__main__":
    code = binding_parts.run(sys.modules[__name__])
    sys.stdout.flush()
    os._exit(binding_parts.EXIT_BASE + code)
