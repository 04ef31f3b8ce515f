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


def _without_needless_knots(surface, tolerance=1e-4):
    """FreeCAD's removal of knots, each within the tolerance."""
    for direction, count in (("U", surface.NbUKnots), ("V", surface.NbVKnots)):
        remove = getattr(surface, "remove%sKnot" % direction)
        for index in range(count - 1, 1, -1):
            remove(index, 0, tolerance)
    return surface


def blade(thinned=True):
    """The middle of a propeller's blade between its two skins, 80 % of the chord and 65 % of the
    span, closed by four faces ruled between the skins' isolines. The skins meet in sharp edges and
    their parameters drift apart at the tip, so the rims are left away. They are interpolations with
    knots as near as 1e-7 to each other: thinned removes those that change less than a tenth of a
    micrometre."""
    box = (0.1, 0.9, 0.2, 0.85)
    skins = [read("blade_%s.iges" % name).Faces[0].Surface for name in ("upper", "lower")]
    faces = []
    for surface in skins:
        surface.segment(*box)
        if thinned:
            _without_needless_knots(surface)
        faces.append(surface.toShape().Faces[0])
    for name, at in (("vIso", box[2]), ("uIso", box[1]), ("vIso", box[3]), ("uIso", box[0])):
        lines = [getattr(surface, name)(at).toShape() for surface in skins]
        faces += Part.makeRuledSurface(*lines).Faces
    compound = Part.makeCompound(faces)
    compound.sewShape()
    return _solid(compound.Shells[0].Faces)
