# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests that run inside FreeCADCmd (started by test_follow.py): ruled faces take over parameters.

Every part is a block over the profile front, right, rear, left, whose front is curved, and a lid
that runs along the front's upper edge with a parameter of its own: u = s (1 + e - e s).
"""

import math
import os
import sys
import unittest

import binding_parts

binding_parts.join_freecad()

import Part  # noqa: E402
from FreeCAD import Vector  # noqa: E402

from freecad.tsolid import api, convert, intake_follow, nurbs  # noqa: E402

HEIGHT = 6.0
A, B, C, D = Vector(0, 0, 0), Vector(10, 0, 0), Vector(10, 8, 0), Vector(0, 8, 0)
UP = Vector(0, 0, HEIGHT)


# ---- another parameter -----------------------------------------------------------------------


def reparametrised(row, e):
    """A Bezier Row with u = s (1 + e - e s): twice the degree, the same points."""
    p = row.degree
    u, rest = [[0.0], [(1.0 + e) / 2], [1.0]], [[1.0], [(1.0 - e) / 2], [0.0]]
    out = [[0.0] * len(row.points[0]) for _ in range(2 * p + 1)]
    for i, point in enumerate(row.points):
        factor = [[float(math.comb(p, i))]]
        for f in [u] * i + [rest] * (p - i):
            factor = nurbs._product(factor, f)
        out = [[x + f * y for x, y in zip(o, point)] for o, (f,) in zip(out, factor)]
    return nurbs.Row.bezier(out)


def arc_row(shift=Vector(0, 0, 0), scale=1.0):
    """The front's circle from A to B as one rational parabola."""
    curve = front_arc(shift, scale)
    a, b = curve.valueAt(curve.FirstParameter), curve.valueAt(curve.LastParameter)
    middle = 0.5 * (curve.FirstParameter + curve.LastParameter)
    w = math.cos(0.5 * (curve.LastParameter - curve.FirstParameter))
    centre = curve.Curve.Center
    tip = centre + (curve.valueAt(middle) - centre) * (1.0 / w)
    return nurbs.Row.bezier([[*a, 1.0], [*(tip * w), w], [*b, 1.0]])


def front_arc(shift=Vector(0, 0, 0), scale=1.0):
    points = [p * scale + shift for p in (A, Vector(5, -2, 0), B)]
    return Part.Arc(*points).toShape()


# ---- parts -----------------------------------------------------------------------------------


def surface(rows, degree):
    """A B-spline surface through Rows in u of one degree, a Bezier curve of them in v."""
    count = len(rows[0].points)
    poles = [[Vector(*row.points[i][:3]) * (1.0 / row.points[i][3]) for row in rows]
             for i in range(count)]
    weights = [[row.points[i][3] for row in rows] for i in range(count)]
    out = Part.BSplineSurface()
    out.buildFromPolesMultsKnots(poles, [count] * 2, [degree + 1] * 2, [0, 1], [0, 1], False,
                                 False, count - 1, degree, weights)
    return out


def lid(row):
    """A doubly curved face from a front row to a wave above C and D, with the row's weights."""
    n = len(row.points) - 1
    wave = [UP + D + (C - D) * (i / n) + Vector(0, 0, 6.0 * (i / n) * (1.0 - i / n))
            for i in range(n + 1)]
    rear = nurbs.Row(n, row.knots, [[*(x * p[3]), p[3]] for x, p in zip(wave, row.points)])
    middle = [[0.5 * (x + y) for x, y in zip(p, q)] for p, q in zip(row.points, rear.points)]
    for point in middle[1:-1]:
        point[2] += 1.0 * point[3]
    return surface([row, nurbs.Row(n, row.knots, middle), rear], 2)


def planar(edge, *points):
    """A planar face over an edge and a polygon."""
    lines = [Part.makeLine(p, q) for p, q in zip(points, points[1:])]
    return Part.Face(Part.Wire(Part.__sortEdges__([edge] + lines)))


def sewn(faces):
    compound = Part.makeCompound(faces)
    compound.sewShape()
    solid = Part.makeSolid(compound.Shells[0])
    if solid.Volume < 0:
        solid.reverse()
    return solid


def block(front, foot, top, a=A, b=B, c=C):
    """front: faces; foot: the front's lower edge from a to b; top: the lid's surface."""
    left, right, rear = (top.uIso(0.0), top.uIso(1.0), top.vIso(1.0))
    faces = [planar(foot, b, c, D, a), top.toShape()] + front
    faces.append(planar(left.toShape(), UP, a, D, UP + D))
    faces.append(planar(right.toShape(), B + UP, b, c, UP + C))
    faces.append(planar(rear.toShape(), UP + D, D, c, UP + C))
    return sewn(faces)


def cylinder_front(e=0.4):
    return block(front_arc().extrude(UP).Faces, front_arc(), lid(reparametrised(arc_row(UP), e)))


def spline_front():
    """An extruded polynomial of degree 3."""
    points = [A, Vector(3, -2, 0), Vector(6, 2, 0), B]
    row = nurbs.Row.bezier([[*(p + UP), 1.0] for p in points])
    curve = Part.BezierCurve()
    curve.setPoles(points)
    foot = curve.toBSpline().toShape()
    return block(foot.extrude(UP).Faces, foot, lid(reparametrised(row, -0.5)))


def cone_front():
    """The lower arc is smaller: lines through an apex."""
    move = Vector(0, 0.8, 0)
    a, b = A * 0.9 + move, B * 0.9 + move
    cone = surface([arc_row(move, 0.9), arc_row(UP)], 1).toShape()
    top = lid(reparametrised(arc_row(UP), 0.3))
    return block(cone.Faces, front_arc(move, 0.9), top, a, b, Vector(9, 8, 0))


def storeys():
    """Two cylinders above each other: the lower one follows the upper one."""
    half = UP * 0.5
    lower = front_arc().extrude(half)
    upper = front_arc(half).extrude(half)
    return block(lower.Faces + upper.Faces, front_arc(), lid(reparametrised(arc_row(UP), 0.4)))


def line_front():
    """A doubly curved front whose upright borders are straight lines with a parameter of their
    own; on its left an extruded spline, that has to follow along its straight lines."""
    heights = (0.0, 0.7 * HEIGHT, HEIGHT)
    rows = []
    for z, bulge in zip(heights, (-2.0, -4.0, -2.0)):
        points = (A, Vector(5, bulge, 0), B)
        rows.append(nurbs.Row.bezier([[*(p + Vector(0, 0, z)), 1.0] for p in points]))
    front = surface(rows, 2)
    left = Part.BezierCurve()
    left.setPoles([A, Vector(-2, 3, 0), Vector(1, 6, 0), D])
    side = left.toBSpline().toShape()
    faces = [front.toShape()] + side.extrude(UP).Faces
    for shift in (Vector(0, 0, 0), UP):
        row = Part.BezierCurve()
        row.setPoles([p + shift for p in (A, Vector(5, -2, 0), B)])
        edges = [row.toBSpline().toShape(), side.translated(shift)]
        edges += [Part.makeLine(p + shift, q + shift) for p, q in ((B, C), (C, D))]
        faces.append(Part.Face(Part.Wire(Part.__sortEdges__(edges))))
    faces.append(planar(front.uIso(1.0).toShape(), B + UP, UP + C, C, B))
    faces.append(planar(Part.makeLine(C, D), D, UP + D, UP + C, C))
    return sewn(faces)


def two_lids():
    """A lid above and one below, whose parameters differ: the wall cannot follow both."""
    upper = lid(reparametrised(arc_row(UP), 0.4))
    lower = lid(reparametrised(arc_row(UP), -0.4))
    down = lower.toShape().translated(UP * -1.0)
    faces = [upper.toShape(), down] + front_arc().extrude(UP).Faces
    for a, b in ((upper.uIso(0.0), lower.uIso(0.0)), (upper.uIso(1.0), lower.uIso(1.0)),
                 (upper.vIso(1.0), lower.vIso(1.0))):
        high, low = a.toShape(), b.toShape().translated(UP * -1.0)
        ends = [(e.valueAt(e.FirstParameter), e.valueAt(e.LastParameter)) for e in (high, low)]
        lines = [Part.makeLine(p, q) for p, q in zip(*ends)]
        faces.append(Part.Face(Part.Wire(Part.__sortEdges__([high, low] + lines))))
    return sewn(faces)


PARTS = {  # name -> (part, type of the face that follows, how many)
    "cylinder": (cylinder_front, "Cylinder", 1),
    "extruded spline": (spline_front, "SurfaceOfExtrusion", 1),
    "cone": (cone_front, "BSplineSurface", 1),
    "storeys": (storeys, "Cylinder", 2),
    "lines": (line_front, "SurfaceOfExtrusion", 1),
}


# ---- tests -----------------------------------------------------------------------------------


class Follow(unittest.TestCase):
    def test_parts_are_proved_and_exact(self):
        for name, (make, kind, count) in PARTS.items():
            with self.subTest(name):
                shape = make()
                result = api.build(shape, effort="quick")
                self.assertEqual(result.verdict, "positive", result.text())
                led = [f for f in result.findings if "takes over the parameters" in f.text]
                self.assertEqual(len(led), count, result.text())
                faces = {"Face%d" % (k + 1): f for k, f in enumerate(shape.Faces)}
                self.assertEqual({type(faces[f.where].Surface).__name__ for f in led}, {kind})
                self.check_evidence(result.report)

    def check_evidence(self, report):
        scale = report["conformity"]["scale"]
        for row in report["exactness"]:
            self.assertEqual(row["samples"], 1000)
            self.assertLessEqual(row["distance"], 1e-13 * scale, row)
            self.assertLessEqual(row["declared"], 1e-13 * scale, row)
        self.assertLessEqual(report["volume"]["relative_difference"], 1e-13)

    def test_shared_curves_have_equal_control_points(self):
        """Of the follower and the leader, in bits: no tolerance is used up."""
        for name, (make, _, _) in PARTS.items():
            with self.subTest(name):
                sources, notes = convert.sources_of_shape(make())
                patches = {s.name: s.patch for s in sources}
                for note in (n for n in notes if "takes over" in n.text):
                    leader = note.text.split(" of ")[1].split(",")[0]
                    ours = borders(patches[note.where])
                    shared = [b for b in borders(patches[leader]) if b in ours]
                    self.assertEqual(len(shared), 1, (name, note))

    def test_equal_parameters_are_left_alone(self):
        for e, count in ((0.0, 0), (0.4, 1)):
            _, notes = convert.sources_of_shape(cylinder_front(e))
            self.assertEqual(sum("takes over" in n.text for n in notes), count)

    def test_who_cannot_follow_is_refused(self):
        result = api.check(two_lids())
        self.assertFalse(result.satisfied)
        self.assertRegex(result.text(), r"Edge\d+ of Face\d and Edge\d+ of Face\d run along one "
                                        r"curve with different parameters: up to 1\.\d+ apart")


class Curves(unittest.TestCase):
    def test_moebius_changes_are_no_other_parameter(self):
        row = arc_row()
        changed = nurbs.Row.bezier([[c * 2.0**i for c in p] for i, p in enumerate(row.points)])
        self.assertTrue(intake_follow.same_parameter(row, changed, 1e-12))
        self.assertFalse(intake_follow.same_parameter(row, reparametrised(row, 0.1), 1e-3))

    def test_reparametrised_is_the_same_curve(self):
        row = arc_row()
        other = reparametrised(row, 0.4)
        for k in range(11):
            s = k / 10.0
            far = math.dist(other.place(s), row.place(s * (1.4 - 0.4 * s)))
            self.assertLess(far, 1e-14 * 10)

    def test_find_on(self):
        row = reparametrised(arc_row(), -0.7)
        for k in range(1, 20):
            self.assertAlmostEqual(intake_follow.find_on(row, row.place(k / 20.0)), k / 20.0, 14)


def borders(patch):
    """Control points and weights of the four borders, in either direction."""
    n, m = patch.n_control
    weights = patch.weights or [1.0] * (n * m)
    rows = ([i for i in range(n)], [i + n * (m - 1) for i in range(n)],
            [n * j for j in range(m)], [n - 1 + n * j for j in range(m)])
    out = []
    for row in rows:
        line = [(patch.points[k], weights[k] / weights[row[0]]) for k in row]
        back = [(patch.points[k], weights[k] / weights[row[-1]]) for k in row[::-1]]
        out.append(tuple(min(line, back)))
    return out


if __name__ == "__main__":
    code = binding_parts.run(sys.modules[__name__])
    sys.stdout.flush()
    os._exit(binding_parts.EXIT_BASE + code)
