# SPDX-License-Identifier: LGPL-2.1-or-later
"""Small parts of every kind, built with FreeCAD's own tools, each with the verdict it must get.

TAKEN: name -> function that makes the shape. REFUSED: name -> (function, words): regular
expressions that the refusal has to hold, the place among them. GAPS: parts whose edges and surfaces
differ, by FreeCAD's own making, so far that it shows in the volume. Runs inside FreeCADCmd.
"""

import math

import FreeCAD
import Part
from FreeCAD import Matrix, Placement, Rotation, Vector

X, Y, Z = Vector(1, 0, 0), Vector(0, 1, 0), Vector(0, 0, 1)
ORIGIN = Vector(0, 0, 0)


def polygon(*points):
    return Part.makePolygon([Vector(*p) for p in points + points[:1]])


def prism(*points, height=5.0):
    return Part.Face(polygon(*points)).extrude(Vector(0, 0, height))


def box(x=10, y=20, z=30):
    return Part.makeBox(x, y, z)


def arc(a, b, c):
    return Part.Arc(Vector(*a), Vector(*b), Vector(*c)).toShape()


def line(a, b):
    return Part.LineSegment(Vector(*a), Vector(*b)).toShape()


def spline(*points):
    curve = Part.BSplineCurve()
    curve.interpolate([Vector(*p) for p in points])
    return curve.toShape()


def solid_of_document(make):
    """The shape of the object that make(document) returns."""
    document = FreeCAD.newDocument("Kinds")
    try:
        made = make(document)
        document.recompute()
        return Part.getShape(made).copy()
    finally:
        FreeCAD.closeDocument(document.Name)


# ---- taken -----------------------------------------------------------------------------------


def wavy_box():
    """Four sides with curved edges between planes: every face is planar."""
    low = Part.Wire([
        spline((0, 0, 0), (4, -1, 0), (7, 1, 0), (10, 0, 0)),
        line((10, 0, 0), (10, 8, 0)),
        spline((10, 8, 0), (6, 9, 0), (3, 7.5, 0), (0, 8, 0)),
        line((0, 8, 0), (0, 0, 0)),
    ])
    return Part.Face(low).extrude(Vector(1, 2, 6))


def loft_of_squares():
    low = polygon((0, 0, 0), (10, 0, 0), (10, 8, 0), (0, 8, 0))
    high = polygon((2, 1, 9), (9, 2, 9), (8, 7, 9), (1, 6, 9))
    return Part.makeLoft([low, high], True, True)


def loft_of_profiles():
    """Through three profiles with curved sides: B-spline walls."""

    def profile(z, s):
        return Part.Wire([
            spline((0, 0, z), (5, -s, z), (10, 0, z)), line((10, 0, z), (10, 8, z)),
            spline((10, 8, z), (5, 8 + s, z), (0, 8, z)), line((0, 8, z), (0, 0, z)),
        ])

    return Part.makeLoft([profile(0, 1), profile(5, 1.5), profile(9, 0.5)], True, False)


def pad():
    """A PartDesign body: a pad on a sketch with one curved side, and a chamfer."""

    def make(document):
        body = document.addObject("PartDesign::Body", "Body")
        sketch = body.newObject("Sketcher::SketchObject", "Sketch")
        sketch.addGeometry(Part.LineSegment(Vector(0, 0, 0), Vector(12, 0, 0)))
        sketch.addGeometry(Part.LineSegment(Vector(12, 0, 0), Vector(12, 7, 0)))
        sketch.addGeometry(Part.ArcOfCircle(Part.Circle(Vector(6, 2.5, 0), Z, 7.5),
                                            math.atan2(4.5, 6), math.pi - math.atan2(4.5, 6)))
        sketch.addGeometry(Part.LineSegment(Vector(0, 7, 0), Vector(0, 0, 0)))
        feature = body.newObject("PartDesign::Pad", "Pad")
        feature.Profile = sketch
        feature.Length = 5
        body.Placement = Placement(Vector(3, 4, 5), Rotation(Vector(1, 1, 0), 30))
        return body

    return solid_of_document(make)


def link_in_a_part():
    """A link to a box inside a moved App::Part."""

    def make(document):
        part = document.addObject("App::Part", "Part")
        block = document.addObject("Part::Box", "Box")
        link = document.addObject("App::Link", "Link")
        link.LinkedObject = block
        link.Placement = Placement(Vector(30, 0, 0), Rotation(Z, 20))
        part.addObject(link)
        part.Placement = Placement(Vector(0, 5, 0), Rotation(X, 40))
        return part

    return solid_of_document(make)


def mirrored():
    def make(document):
        source = document.addObject("Part::Feature", "Source")
        source.Shape = quarter_cylinder()
        mirror = document.addObject("Part::Mirroring", "Mirror")
        mirror.Source, mirror.Normal, mirror.Base = source, Vector(1, 2, 0), Vector(3, 0, 0)
        return mirror

    return solid_of_document(make)


def scaled():
    """Scaled unevenly, as Draft.scale does it: a cylinder becomes an elliptic bar."""
    matrix = Matrix()
    matrix.scale(2.0, 1.0, 0.5)
    return Part.makeCylinder(3, 10).transformGeometry(matrix)


def bent_bar():
    """A disc swept along an arc: part of a torus."""
    path = Part.Wire(arc((0, 0, 0), (10 - 10 * math.cos(0.7), 0, 10 * math.sin(0.7)), (10, 0, 10)))
    disc = Part.Wire(Part.makeCircle(2, ORIGIN, Z))
    return path.makePipeShell([disc], True, True)


def swept_round_bar(frenet=False):
    """A disc along a curve with bends in two planes. Frenet's frame turns by a right angle within a
    diameter where the one bend ends and the other begins, and the wall with it."""
    path = Part.Wire(spline((0, 0, 0), (0, 5, 10), (0, 0, 20), (5, 0, 30)))
    return path.makePipeShell([Part.Wire(Part.makeCircle(2, ORIGIN, Z))], True, frenet)


def swept_too_tightly():
    """A disc along an arc whose radius is less than its own."""
    path = Part.Wire(spline((0, 0, 0), (0, 8, 8), (0, 0, 16), (0, -8, 24)))
    return path.makePipeShell([Part.Wire(Part.makeCircle(2, ORIGIN, Z))], True, True)


def _ellipse(a, b, z):
    return Part.Wire(Part.Ellipse(Vector(0, 0, z), a, b).toShape())


def ellipse_to_circle():
    """Ruled: OCC writes the wall as a polynomial that is 1e-9 away from the edges."""
    circle = Part.Wire(Part.makeCircle(2, Vector(0, 0, 10)))
    return Part.makeLoft([_ellipse(5, 3, 0), circle], True, True)


def loft_of_ellipses():
    """A wall that closes smoothly, but for a billionth of a degree."""
    return Part.makeLoft([_ellipse(5, 3, 0), _ellipse(4, 2, 5), _ellipse(6, 3, 10)], True)


def quarter_cylinder():
    return Part.makeCylinder(3, 10, ORIGIN, Z, 90)


def slot():
    wire = Part.Wire([line((0, 0, 0), (10, 0, 0)), arc((10, 0, 0), (13, 3, 0), (10, 6, 0)),
                      line((10, 6, 0), (0, 6, 0)), arc((0, 6, 0), (-3, 3, 0), (0, 0, 0))])
    return Part.Face(wire).extrude(Vector(0, 0, 4))


def leaf():
    """A prism over two arcs: two corners to be added."""
    low, high = arc((0, 0, 0), (5, -2, 0), (10, 0, 0)), arc((10, 0, 0), (5, 2, 0), (0, 0, 0))
    wire = Part.Wire([low, high])
    return Part.Face(wire).extrude(Vector(0, 0, 4))


def domed(ends=1):
    bar = Part.makeCylinder(3, 10).fuse(Part.makeSphere(3, Vector(0, 0, 10)))
    return (bar.fuse(Part.makeSphere(3)) if ends == 2 else bar).removeSplitter()


def revolved(angle):
    return Part.Face(polygon((5, 0, 0), (9, 0, 1), (8, 0, 6), (5, 0, 5))).revolve(ORIGIN, Z, angle)


def revolved_spline():
    wire = Part.Wire([spline((5, 0, 0), (7, 0, 1), (9, 0, 0)), line((9, 0, 0), (9, 0, 5)),
                      line((9, 0, 5), (5, 0, 5)), line((5, 0, 5), (5, 0, 0))])
    return Part.Face(wire).revolve(ORIGIN, Z, 100)


def sliced():
    """A box of two halves that kept the line between them: ten faces."""
    low, high = box(), Part.makeBox(10, 20, 12, Vector(0, 0, 30))
    return low.fuse(high)


def cut_obliquely():
    return box().cut(Part.makeBox(40, 60, 40, Vector(-5, -20, 24), Vector(0.3, 0.2, 1)))


def chamfered():
    block = box()
    return block.makeChamfer(3, block.Edges[:1])


def filleted(count=1):
    block = box()
    return block.makeFillet(2, block.Edges[:count])


def cut_circle(*degrees):
    """A hemisphere whose circle has vertices at these angles, too."""
    points = [Vector(3 * math.cos(a), 3 * math.sin(a), 0) for a in map(math.radians, degrees)]
    half = Part.makeSphere(3, ORIGIN, Z, 0, 90, 360)
    return half.generalFuse([Part.Vertex(p) for p in points])[0].Solids[0]


def rounded_bar():
    bar = Part.makeCylinder(4, 12)
    return bar.makeFillet(1, [e for e in bar.Edges if e.Closed])


def iso_trimmed():
    """A block whose top is a piece of a larger B-spline surface."""
    curve = spline((-5, 0, 8), (0, 0, 10), (6, 0, 9), (15, 0, 11))
    top = curve.extrude(Vector(0, 20, 0))
    tall = Part.makeBox(10, 8, 30, Vector(0, 4, 0))
    pieces = tall.generalFuse([top])[0]
    return min(pieces.Solids, key=lambda s: s.CenterOfMass.z)


def extruded_parabola():
    curve = Part.Parabola(Vector(0, 0, 0), Vector(0, 1, 0), Z)
    edge = Part.Edge(curve, -4.0, 4.0)
    a, b = edge.valueAt(-4.0), edge.valueAt(4.0)
    high = max(a.x, a.y, b.x, b.y) + 3
    wire = Part.Wire([edge] + [Part.makeLine(p, q) for p, q in (
        (b, Vector(b.x, b.y, 0) + _away(a, b, high)),
        (b + _away(a, b, high), a + _away(a, b, high)),
        (a + _away(a, b, high), a))])
    return Part.Face(wire).extrude(Vector(0, 0, 3))


def _away(a, b, high):
    """From the ends of an arc away from its middle."""
    middle = (a + b) * 0.5
    return middle.normalize() * high


def pyramid_frustum():
    """A frustum of a pyramid: four planes, no right angle."""
    return Part.makeLoft([polygon((0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)),
                          polygon((3, 3, 6), (6, 3, 6), (6, 6, 6), (3, 6, 6))], True, True)


TAKEN = {
    "box": box,
    "cut obliquely": cut_obliquely,
    "frustum of a pyramid": pyramid_frustum,
    "wavy extrusion": wavy_box,
    "extruded parabola": extruded_parabola,
    "loft of squares": loft_of_squares,
    "loft of profiles": loft_of_profiles,
    "PartDesign pad": pad,
    "link in a part": link_in_a_part,
    "mirrored": mirrored,
    "scaled": scaled,
    "compound of one": lambda: Part.makeCompound([box()]),
    "sliced": sliced,
    "chamfered": chamfered,
    "filleted": filleted,
    "L": lambda: prism((0, 0, 0), (10, 0, 0), (10, 4, 0), (4, 4, 0), (4, 10, 0), (0, 10, 0)),
    "pentagon": lambda: prism((0, 0, 0), (10, 0, 0), (12, 5, 0), (5, 12, 0), (0, 10, 0)),
    "hexagon": lambda: prism(*[(9 * math.cos(k * math.pi / 3), 9 * math.sin(k * math.pi / 3), 0)
                               for k in range(6)]),
    "cylinder": lambda: Part.makeCylinder(3, 10),
    "cone frustum": lambda: Part.makeCone(3, 1, 10),
    "half cylinder": lambda: Part.makeCylinder(3, 10, ORIGIN, Z, 180),
    "half cylinder, cut": lambda: Part.makeCylinder(3, 10).cut(box(20, 20, 20).translated(
        Vector(-10, 0, -1))),
    "quarter cylinder": quarter_cylinder,
    "half tube, cut on the seam": lambda: tube().common(Part.makeBox(9, 20, 9, Vector(0, -10, 0))),
    "slot": slot,
    "leaf": leaf,
    "bent bar": bent_bar,
    "half ring": lambda: Part.makeTorus(10, 2, ORIGIN, Z, -180, 180, 180),
    "swept round bar": swept_round_bar,
    "rounded bar": rounded_bar,
    "lens": lambda: Part.makeSphere(5).common(Part.makeSphere(8, Vector(0, 0, 10))),
    "flat lens": lambda: Part.makeSphere(10).common(
        Part.makeBox(30, 30, 30, Vector(-15, -15, 8))),
    "far from the origin": lambda: Part.makeCylinder(3, 10, Vector(1e5, 2e5, -3e5),
                                                     Vector(1, 2, 3)),
    "ellipse to circle": ellipse_to_circle,
    "loft of ellipses": loft_of_ellipses,
    "domed bar": domed,
    "capsule": lambda: domed(2),
    "hemisphere": lambda: Part.makeSphere(3, ORIGIN, Z, 0, 90, 360),
    "hemisphere of splines": lambda: Part.makeSphere(3, ORIGIN, Z, 0, 90, 360).toNurbs(),
    "hemisphere, its circle cut": lambda: cut_circle(40, 90, 130),
    "zone of a sphere": lambda: Part.makeSphere(5, ORIGIN, Z, -30, 40, 360),
    "revolved": lambda: revolved(120),
    "revolved spline": revolved_spline,
    "isoparametric trim": iso_trimmed,
}


# A fuse's edges are up to 4e-7 beside the surfaces.
GAPS = {"ellipse to circle": 1e-8, "far from the origin": 1e-9, "isoparametric trim": 1e-7}


# ---- refused ---------------------------------------------------------------------------------


def tube():
    return Part.makeCylinder(5, 9).cut(Part.makeCylinder(3, 9))


def steinmetz():
    other = Part.makeCylinder(4, 40, Vector(-20, 0, 10), X)
    return Part.makeCylinder(5, 20).common(other)


def hollow():
    return box().cut(Part.makeBox(4, 4, 4, Vector(3, 3, 3)))


def fillet_corner():
    block = box()
    corner = [e for e in block.Edges if any(v.Point.Length < 1e-9 for v in e.Vertexes)]
    return block.makeFillet(2, corner)


def pyramid():
    base = [(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)]
    tip = (4.5, 4.5, 8)
    faces = [Part.Face(polygon(*base))]
    faces += [Part.Face(polygon(a, b, tip)) for a, b in zip(base, base[1:] + base[:1])]
    return Part.makeSolid(Part.makeShell(faces))


def tetrahedron():
    points = [(0, 0, 0), (9, 0, 0), (0, 9, 0), (0, 0, 9)]
    faces = [Part.Face(polygon(*[points[i] for i in t]))
             for t in ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3))]
    return Part.makeSolid(Part.makeShell(faces))


def octahedron():
    ends = [(5, 0, 0), (0, 5, 0), (-5, 0, 0), (0, -5, 0)]
    faces = [Part.Face(polygon(a, b, (0, 0, z)))
             for z in (6, -6) for a, b in zip(ends, ends[1:] + ends[:1])]
    return Part.makeSolid(Part.makeShell(faces))


def rough():
    """A small step on a box whose vertices are known to a tenth of a millimetre only."""
    shape = prism((0, 0, 0), (10, 0, 0), (10, 6, 0), (9.95, 6, 0), (9.95, 9, 0), (0, 9, 0))
    shape.fixTolerance(0.1)
    return shape


def sliver():
    """A sheet of one and a half nanometres."""
    return prism((0, 0, 0), (10, 0, 0), (10, 1.5e-6, 0), (0, 1.5e-6, 0))


REFUSED = {
    "sphere": (lambda: Part.makeSphere(3), ["Face1, Vertex1", "pole", "a cut with the plane"]),
    "torus": (lambda: Part.makeTorus(9, 2), ["hole through", r"a cut with the plane [xy] = 0"]),
    "tube": (tube, ["hole through", r"a cut with the plane [xy] = 0"]),
    "bored": (lambda: box().cut(Part.makeCylinder(2, 40, Vector(5, 10, -5))),
              ["Face3, Face5: ", "1 hole through"]),
    "ring of boxes": (lambda: box(9, 9, 3).cut(Part.makeBox(3, 3, 9, Vector(3, 3, -1))),
                      ["hole through"]),
    "boss": (lambda: box().fuse(Part.makeCylinder(2, 9, Vector(5, 10, 30))), ["inner border"]),
    "pocket": (lambda: box().cut(Part.makeBox(4, 4, 4, Vector(3, 3, 28))), ["inner border"]),
    "cone": (lambda: Part.makeCone(3, 0, 5), ["Face1, Vertex1", "pole"]),
    "octant": (lambda: Part.makeSphere(3, ORIGIN, Z, 0, 90, 90), ["Face1, Vertex1", "pole"]),
    "wedge": (lambda: prism((0, 0, 0), (10, 0, 0), (0, 10, 0)), [r"Face\d", "three edges", "four"]),
    "tetrahedron": (tetrahedron, [r"Face\d", "three edges"]),
    "pyramid": (pyramid, [r"Face\d", "three edges"]),
    "octahedron": (octahedron, [r"Face\d", "three edges"]),
    "fillet corner": (fillet_corner, [r"Face\d+, Vertex\d+: ", "pole"]),
    "all edges rounded": (lambda: filleted(12), [r"Face\d+, Vertex\d+", "pole"]),
    "crossed fillets": (lambda: filleted(2),
                        [r"Face\d+, Edge\d+", "isoparametric", r"by 1\.41"]),
    "Steinmetz solid": (steinmetz, [r"Face\d, Edge\d", "isoparametric"]),
    "two solids": (lambda: Part.makeCompound([box(), box().translated(Vector(50, 0, 0))]),
                   ["Solid1, Solid2", "assembly"]),
    "shell": (lambda: box().Shells[0], ["not a solid"]),
    "open": (lambda: Part.makeSolid(Part.makeShell(box().Faces[:5])), [r"Edge\d", "open"]),
    "hollow": (hollow, ["void"]),
    "rough": (rough, [r"Edge\d+: the edge is not longer than the tolerance",
                      r"measured 0\.05, allowed 0\.2"]),
    "sliver": (sliver, [r"Face\d: the face is a sliver", r"measured 1\.5e-06"]),
    "turned too fast": (lambda: swept_round_bar(True), [r"Face1: The face folds over itself"]),
    "bent too tightly": (swept_too_tightly, [r"Face1: The face folds over itself"]),
    "wire": (lambda: polygon((0, 0, 0), (9, 0, 0), (0, 9, 0)), ["no faces"]),
}
