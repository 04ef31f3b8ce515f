# SPDX-License-Identifier: LGPL-2.1-or-later
"""Members and contacts of assemblies; runs inside FreeCADCmd (test_contacts.py)."""

import math
import os
import sys
import unittest

import binding_parts

binding_parts.join_freecad()

import FreeCAD as App  # noqa: E402
import Part  # noqa: E402
from FreeCAD import Placement, Rotation, Vector  # noqa: E402

from freecad.tsolid import contacts, members  # noqa: E402

BOX = Part.makeBox(10, 10, 10)


def box_at(x, y=0.0, z=0.0, size=10):
    return Part.makeBox(size, size, size, Vector(x, y, z))


class Members(unittest.TestCase):
    def setUp(self):
        self.doc = App.newDocument("Members")
        self.addCleanup(App.closeDocument, self.doc.Name)

    def box(self, name, *place):
        obj = self.doc.addObject("Part::Box", name)
        obj.Placement.Base = Vector(*place)
        return obj

    def found(self):
        """{name: (middle of the box, number of the first with this geometry)}"""
        self.doc.recompute()
        out = {}
        for k, m in enumerate(members.of_document(self.doc)):
            middle = tuple(round(x, 6) for x in m.shape.BoundBox.Center)
            self.assertNotIn(m.name, out)
            out[m.name] = (middle, m.first)
            inside = m.obj.getSubObject(m.below("Face1"))
            self.assertIsInstance(inside, Part.Face)
        return out

    def test_trees_and_links(self):
        part = self.doc.addObject("App::Part", "Outer")
        part.Placement.Base = Vector(100, 0, 0)
        inner = self.doc.addObject("App::Part", "Inner")
        inner.Placement.Base = Vector(0, 50, 0)
        box, deep = self.box("Box", 1, 2, 3), self.box("Deep")
        part.addObject(box)
        part.addObject(inner)
        inner.addObject(deep)
        link = self.doc.addObject("App::Link", "Link")
        link.LinkedObject = part
        link.LinkPlacement = Placement(Vector(0, 0, 500), Rotation())
        self.assertEqual(self.found(), {
            "Box": ((106, 7, 8), 0), "Deep": ((105, 55, 5), 1),
            "Box (2)": ((6, 7, 508), 0), "Deep (2)": ((5, 55, 505), 1),
        })

    def test_selected_below_a_container(self):
        part = self.doc.addObject("App::Part", "Outer")
        part.Placement.Base = Vector(100, 0, 0)
        box = self.box("Box", 1, 2, 3)
        part.addObject(box)
        self.doc.recompute()
        (member,) = members.of_objects([box])
        self.assertEqual((member.obj, member.below("Face2")), (part, "Box.Face2"))
        self.assertAlmostEqual(member.shape.BoundBox.XMin, 101.0, 9)

    def test_arrays_of_links(self):
        box = self.box("Box")
        for name, shown in (("Shown", True), ("Folded", False)):
            array = self.doc.addObject("App::Link", name)
            array.LinkedObject, array.ShowElement, array.ElementCount = box, shown, 2
            places = [Placement(Vector(20 * k, 0, 0), Rotation()) for k in (1, 2)]
            array.PlacementList = places
            for element, place in zip(array.ElementList, places):
                element.Placement = place
        self.assertEqual(self.found(), {
            "Box": ((5, 5, 5), 0), "Shown.0": ((25, 5, 5), 0), "Shown.1": ((45, 5, 5), 0),
            "Folded.0": ((25, 5, 5), 0), "Folded.1": ((45, 5, 5), 0),
        })

    def test_what_others_are_made_of(self):
        """Tools of a cut, features of a Body and what a mirror mirrors are not in the assembly."""
        cut = self.doc.addObject("Part::Cut", "Cut")
        cut.Base, cut.Tool = self.box("Base", 5, 0, 0), self.box("Tool")
        body = self.doc.addObject("PartDesign::Body", "Body")
        body.newObject("PartDesign::AdditiveBox", "Feature")
        mirror = self.doc.addObject("Part::Mirroring", "Mirror")
        mirror.Source = self.box("Source", 0, 0, 7)
        two = self.doc.addObject("Part::Compound", "Two")
        two.Links = [self.box("One"), self.box("Other", 0, 0, 77)]
        self.doc.addObject("Sketcher::SketchObject", "Sketch")
        group = self.doc.addObject("App::DocumentObjectGroup", "Group")
        group.addObject(self.box("Grouped"))
        found = self.found()
        self.assertEqual(sorted(found), ["Body", "Cut", "Grouped", "Mirror", "Two.1", "Two.2"])

    def test_shapes(self):
        both = Part.makeCompound([BOX, box_at(20)])
        self.assertEqual([m.name for m in members.of_shape(both)], ["Solid1", "Solid2"])
        self.assertEqual([m.name for m in members.of_shape(BOX)], ["Solid"])


class Contacts(unittest.TestCase):
    def one(self, *shapes, **options):
        found = contacts.find(shapes, **options)
        self.assertEqual(len(found), 1, [(c.kind, c.faces) for c in found])
        return found[0]

    def test_faces_on_faces(self):
        contact = self.one(BOX, box_at(10))
        self.assertEqual((contact.kind, contact.faces, contact.gap), ("contact", (1, 0), 0.0))
        contact = self.one(BOX, box_at(10, 3, 4, 1), gap=2.0)
        self.assertEqual((contact.kind, contact.gap), ("partial contact", 0.0))
        contact = self.one(BOX, box_at(10, 5))
        self.assertEqual((contact.kind, contact.gap), ("partial contact", 0.0))
        for share in contact.covered:
            self.assertAlmostEqual(share, 0.5, delta=0.1)

    def test_points_beside_a_smaller_face(self):
        """On a cylinder with a sleeve of a third round it, points beside the sleeve are within the
        reach, but not in the contact."""
        inner = Part.makeCylinder(5, 30)
        outer = Part.makeCylinder(7, 10, Vector(0, 0, 10), Vector(0, 0, 1), 120)
        sleeve = outer.cut(inner)
        contact = self.one(inner, sleeve, gap=3.0)
        self.assertEqual(contact.kind, "partial contact")
        self.assertLess(contact.gap, 1e-9)

    def test_gaps(self):
        for gap in (1e-6, 1e-3, 0.1):
            contact = self.one(BOX, box_at(10 + gap))
            self.assertEqual(contact.kind, "near contact")
            self.assertAlmostEqual(contact.gap / gap, 1.0, delta=1e-6)
            self.assertAlmostEqual(contact.least / gap, 1.0, delta=1e-6)
        self.assertEqual(contacts.find([BOX, box_at(11)]), [])
        self.assertAlmostEqual(self.one(BOX, box_at(11), gap=1.5).gap, 1.0, 12)
        self.assertEqual(contacts.find([BOX, box_at(11)], gap=0.5), [])

    def test_turned(self):
        """A tenth of a degree about an edge: the gap is largest at the opposite edge."""
        turned = box_at(10)
        turned.rotate(Vector(10, 0, 0), Vector(0, 0, 1), -0.1)
        contact = self.one(BOX, turned)
        expected = 10 * math.sin(math.radians(0.1))
        self.assertEqual(contact.kind, "near contact")
        self.assertAlmostEqual(contact.gap / expected, 1.0, delta=0.01)
        self.assertAlmostEqual(contact.place[1], 10.0, delta=0.05)
        self.assertLess(contact.least, 1e-9)

    def test_clashes(self):
        small = box_at(4, 4, 4, 1)
        for other, volume in ((box_at(9), 100.0), (small, 1.0), (BOX.copy(), 1000.0)):
            contact = self.one(BOX, other)
            self.assertEqual(contact.kind, "clash")
            self.assertAlmostEqual(contact.volume, volume, 6)
            self.assertTrue(other.isInside(Vector(*contact.place), 1e-6, True))

    def test_no_contacts(self):
        """Solids that touch in an edge or in a corner."""
        self.assertEqual(contacts.find([BOX, box_at(10, 10), box_at(-10, -10, -10)]), [])
        self.assertEqual(contacts.find([BOX]), [])
        self.assertEqual(contacts.find([]), [])

    def test_a_pin_in_a_bore(self):
        bored = BOX.cut(Part.makeCylinder(2, 10, Vector(5, 5, 0)))
        contact = self.one(bored, Part.makeCylinder(2, 10, Vector(5, 5, 0)))
        self.assertEqual(contact.kind, "contact")
        self.assertLess(contact.gap, 1e-12)
        contact = self.one(bored, Part.makeCylinder(1.95, 10, Vector(5, 5, 0)))
        self.assertEqual(contact.kind, "near contact")
        self.assertAlmostEqual(contact.gap, 0.05, 9)

    def test_a_wall(self):
        """Each brick lies on two of the row below."""
        bricks = [Part.makeBox(10, 5, 4, Vector(10 * i + 5 * (j % 2), 0, 4 * j))
                  for j in range(3) for i in range(4)]
        found = contacts.find(bricks)
        kinds = [c.kind for c in found]
        self.assertEqual(kinds.count("contact"), 3 * 3)
        self.assertEqual(kinds.count("partial contact"), 2 * 7)
        self.assertEqual(len(found), 23)

    def test_stopped(self):
        def stop(fraction):
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            contacts.find([BOX, box_at(10)], progress=stop)


if __name__ == "__main__":
    code = binding_parts.run(sys.modules[__name__])
    sys.stdout.flush()
    os._exit(binding_parts.EXIT_BASE + code)
