# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs inside FreeCADCmd: freecad_join.py OUT.step A.tsb ... makes one STEP file of the parts;
freecad_join.py OUT.FCStd SHAPE makes a document of one of the trees below."""

import os
import sys

import binding_parts

binding_parts.join_freecad()

import FreeCAD  # noqa: E402
import Part  # noqa: E402
from FreeCAD import Placement, Rotation, Vector  # noqa: E402

from freecad.tsolid import api, convert  # noqa: E402


def step(path, files):
    solids = [convert.solid_of_patches(api.Part.read_tsb(f).patches) for f in files]
    Part.makeCompound(solids).exportStep(path)


def copies(doc):
    """A row of a hundred Links to one box in a moved container, each turned on its neighbour."""
    box = doc.addObject("Part::Box", "Brick")
    outer = doc.addObject("App::Part", "Row")
    outer.Placement = Placement(Vector(3, 4, 5), Rotation(Vector(1, 1, 0), 30))
    outer.addObject(box)
    for k in range(1, 100):
        link = doc.addObject("App::Link", "Copy")
        link.LinkedObject = box
        link.LinkPlacement = Placement(Vector(10 * k, 0, 0), Rotation())
        outer.addObject(link)


def mixed(doc):
    """Two boxes that touch, and a sphere on one of them, which cannot become hex blocks."""
    doc.addObject("Part::Box", "Left")
    doc.addObject("Part::Box", "Right").Placement.Base = Vector(10, 0, 0)
    ball = doc.addObject("Part::Sphere", "Ball")
    ball.Placement.Base = Vector(25, 5, 5)


def one(doc):
    doc.addObject("Part::Box", "Only")


def fcstd(path, name):
    doc = FreeCAD.newDocument("Join")
    {"copies": copies, "mixed": mixed, "one": one}[name](doc)
    doc.recompute()
    doc.saveAs(path)


if __name__ == "__main__":
    if sys.argv[1].endswith(".step"):
        step(sys.argv[1], sys.argv[2:])
    else:
        fcstd(sys.argv[1], sys.argv[2])
    os._exit(binding_parts.EXIT_BASE)
