# SPDX-License-Identifier: LGPL-2.1-or-later
"""For FreeCAD's own test framework: FreeCAD -t freecad.tsolid.unit_tests"""

import os
import tempfile
import unittest

import FreeCAD
import Part

import freecad.tsolid as ts

from . import document, files, fingerprint


class Scripts(unittest.TestCase):
    """The functions behind the buttons, on a box."""

    def setUp(self):
        self.doc = FreeCAD.newDocument("TsolidTest")
        self.addCleanup(lambda: FreeCAD.closeDocument(self.doc.Name))
        self.box = self.doc.addObject("Part::Box", "Box")
        self.doc.recompute()

    def build(self):
        return ts.build(self.box, effort="none").object

    def test_check(self):
        self.assertTrue(ts.check(self.box).satisfied)
        sphere = self.doc.addObject("Part::Sphere", "Sphere")
        self.doc.recompute()
        result = ts.check(sphere)
        self.assertFalse(result.satisfied)
        self.assertTrue(result.rows())

    def test_build_adds_an_object(self):
        obj = self.build()
        self.assertEqual((obj.Source, obj.Verdict), (self.box, "positive"))
        self.assertEqual(str(obj.Status), document.CURRENT)
        self.assertAlmostEqual(ts.report(obj)["conformity"]["volume"], 1000.0, places=9)

    def test_a_change_is_noticed_and_never_built(self):
        obj = self.build()
        before = document.tsolid_of(obj)
        self.box.Length = 11
        self.doc.recompute()
        self.assertEqual(str(obj.Status), document.OUTDATED)
        self.assertIn("Box", obj.Reason)
        self.assertEqual(document.tsolid_of(obj), before)
        self.box.Length = 10
        self.doc.recompute()
        self.assertEqual(str(obj.Status), document.CURRENT)
        obj.MinCells = 5
        self.doc.recompute()
        self.assertEqual(str(obj.Status), document.OUTDATED)
        ts.rebuild(obj)
        self.assertEqual(str(obj.Status), document.CURRENT)
        self.assertNotEqual(document.tsolid_of(obj), before)

    def test_a_refused_rebuild_keeps_the_solid(self):
        obj = self.build()
        before = document.tsolid_of(obj)
        sphere = self.doc.addObject("Part::Sphere", "Sphere")
        obj.Source = sphere
        self.doc.recompute()
        self.assertIsNone(ts.rebuild(obj).solid)
        self.assertEqual(str(obj.Status), document.FAILED)
        self.assertTrue(obj.Reason)
        self.assertEqual(document.tsolid_of(obj), before)

    def test_the_source_is_deleted(self):
        obj = self.build()
        self.doc.removeObject("Box")
        self.doc.recompute()
        self.assertEqual(str(obj.Status), document.OUTDATED)
        self.assertIsNone(ts.rebuild(obj).solid)

    def test_a_refused_part_leaves_no_object(self):
        sphere = self.doc.addObject("Part::Sphere", "Sphere")
        self.doc.recompute()
        before = len(self.doc.Objects)
        result = ts.build(sphere)
        self.assertIsNone(result.object)
        self.assertEqual(len(self.doc.Objects), before)

    def test_formats(self):
        obj = self.build()
        with tempfile.TemporaryDirectory() as folder:
            for ending in ("tsolid", "vtu", "json", "csv", "html"):
                path = os.path.join(folder, "a." + ending)
                ts.export(obj, path)
                self.assertGreater(os.path.getsize(path), 100, ending)
            ts.export(self.box, os.path.join(folder, "b.tsb"))
            self.assertEqual(len(os.listdir(folder)), 6)
            again = files.insert(os.path.join(folder, "a.tsolid"), self.doc.Name)
            self.assertEqual(document.tsolid_of(again), document.tsolid_of(obj))
            self.assertEqual(ts.report(again)["verdict"], "positive")
            part = files.insert(os.path.join(folder, "b.tsb"), self.doc.Name)
            self.assertAlmostEqual(part.Shape.Volume, 1000.0, places=9)
            for name in (os.path.join(folder, "none", "a.csv"), os.path.join(folder, "a.xyz")):
                with self.assertRaises(files.FileError):
                    ts.export(obj, name)


class Fingerprints(unittest.TestCase):
    def test_what_is_the_same_and_what_not(self):
        shape = Part.makeBox(10, 20, 30).cleaned().toNurbs()
        print_of = fingerprint.of_shape(shape)
        self.assertTrue(fingerprint.same(print_of, fingerprint.of_shape(shape.copy())))
        near = [x * (1 + 4e-16) for x in print_of[5:]]
        self.assertTrue(fingerprint.same(print_of, print_of[:5] + near))
        moved = shape.copy()
        moved.translate(FreeCAD.Vector(1e-6, 0, 0))
        self.assertFalse(fingerprint.same(print_of, fingerprint.of_shape(moved)))
        other = Part.makeBox(10, 20, 30.000001)
        box = fingerprint.of_shape(Part.makeBox(10, 20, 30))
        self.assertFalse(fingerprint.same(box, fingerprint.of_shape(other)))
        self.assertFalse(fingerprint.same([], []))
