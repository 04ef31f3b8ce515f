# SPDX-License-Identifier: LGPL-2.1-or-later
"""Closed parts from surfaces that others published, with FreeCAD's own operations; see the tests'
`Shared` class. Runs inside FreeCADCmd.

The files are not part of this project: they are looked for in ../shared/data beside the checkout.
"""

import os

import Part
from FreeCAD import Vector

import binding_parts

DATA = os.path.join(os.path.dirname(binding_parts.ROOT), "shared", "data")


def read(name):
    shape = Part.Shape()
    shape.read(os.path.join(DATA, name))
    return shape


def _solid(faces):
    shell = Part.makeShell(faces)
    solid = Part.makeSolid(shell)
    if solid.Volume < 0:
        solid.reverse()
    return solid


def _lid(edges):
    """A planar face over edges, and straight lines where they do not meet."""
    first, second = edges
    a, b = (first.valueAt(t) for t in first.ParameterRange)
    c, d = (second.valueAt(t) for t in second.ParameterRange)
    if (a - c).Length > (a - d).Length:
        c, d = d, c
    sides = [Part.makeLine(p, q) for p, q in ((b, d), (c, a))]
    return Part.Face(Part.Wire([first, sides[0], second, sides[1]]))


def hull():
    """A ship's hull: the skin of one side without its stem, stern and keel, its mirror image, a
    planar deck and bottom, and a transom ruled between the sides at each end."""
    surface = read("wigley_hull.step").Faces[0].Surface
    half = surface.toShape(0.1, 0.9, 0.0, 0.92)
    other = half.mirror(Vector(0, 0, 0), Vector(0, 1, 0))
    rest = []
    for edge in half.Faces[0].Edges:
        image = edge.mirror(Vector(0, 0, 0), Vector(0, 1, 0)).Edges[0]
        level = edge.BoundBox.ZLength < 1e-9
        rest.append(_lid([edge, image]) if level else Part.makeRuledSurface(edge, image))
    return _solid(half.Faces + other.Faces + rest)
