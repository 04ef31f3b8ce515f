# SPDX-License-Identifier: LGPL-2.1-or-later
"""CAD curves and surfaces as rational B-splines, by exact formulas of our own.

A curve C + A cos t + B sin t (circle, ellipse, and every parallel or meridian of a cylinder, cone,
sphere or torus) between a and b with m = (a + b) / 2, h = (b - a) / 2 has the homogeneous Bezier
points f(a), cos h C + A cos m + B sin m with weight cos h, and f(b). This is linear in (C, A, B),
so it works for whole rows of control points as well: a torus is a circle of circles, a surface of
revolution a circle of the control points of its meridian. C, A and B come from values of the
surface a quarter turn apart, so mirrored and scaled axes need no case of their own.

OCC's conversions are not used where there is a formula: some are approximations (Curve.toBSpline
of a circle), some break for parameter ranges across the seam. Whatever is made is compared with the
surface as read at N_SAMPLES points by the caller.
"""

import math

import Part

from . import nurbs
from .nurbs import Net, Row

QUARTER = math.pi / 2
_SLACK = 1e-4  # an arc may exceed a quarter turn, by a file's rounding: it is as exact


class NoForm(Exception):
    """No exact B-spline form is known."""


def _point(v):
    return [v.x, v.y, v.z, 1.0]


def _angles(first, last, breaks):
    """first, breaks, last, and what lies between so that no arc is longer than a quarter turn."""
    least = 1e-9 * (last - first)  # ends of edges are known to so much after a file
    stops = [first] + sorted(b for b in breaks if first + least < b < last - least) + [last]
    out = [first]
    for a, b in zip(stops, stops[1:]):
        n = max(1, math.ceil((b - a) / QUARTER - _SLACK))
        out += [a + (b - a) * k / n for k in range(1, n)] + [b]
    return out


def trig_row(four, angles):
    """The Row of C + A cos t + B sin t from its (long) points at t = 0, 90, 180, 270 degrees."""
    centre = [0.5 * (x + y) for x, y in zip(four[0], four[2])]
    cosine = [0.5 * (x - y) for x, y in zip(four[0], four[2])]
    sine = [0.5 * (x - y) for x, y in zip(four[1], four[3])]

    def point(c, t):
        a, b = math.cos(t), math.sin(t)
        return [c * x + a * y + b * z for x, y, z in zip(centre, cosine, sine)]

    points = [point(1.0, angles[0])]
    for a, b in zip(angles, angles[1:]):
        points += [point(math.cos(0.5 * (b - a)), 0.5 * (a + b)), point(1.0, b)]
    inner = [t for t in angles[1:-1] for _ in range(2)]
    return Row(2, [angles[0]] * 3 + inner + [angles[-1]] * 3, points)


# ---- curves ----------------------------------------------------------------------------------


def curve_row(curve, first, last, breaks=()):
    """The curve between two parameters, over that very range; raises NoForm."""
    if isinstance(curve, (Part.Line, Part.LineSegment)):
        return Row(1, [first, first, last, last], [_point(curve.value(t)) for t in (first, last)])
    if isinstance(curve, _CIRCLES):
        four = [_point(curve.value(k * QUARTER)) for k in range(4)]
        return trig_row(four, _angles(first, last, breaks))
    if isinstance(curve, (Part.BSplineCurve, Part.BezierCurve)):
        return _spline_row(curve, first, last)
    return _converted_row(curve, first, last)


def _spline_row(curve, first, last):
    if isinstance(curve, Part.BezierCurve):
        curve = curve.toBSpline()
    own = curve.copy()
    if own.isPeriodic():
        own.segment(first, last)
    points = [[p.x * w, p.y * w, p.z * w, w] for p, w in zip(own.getPoles(), own.getWeights())]
    row = Row(own.Degree, own.KnotSequence, points)
    if abs(row.first - first) > 0.25 * (last - first) and curve.isPeriodic():
        row = row.over(first, last)  # another period
    return row.segment(first, last)


def _converted_row(curve, first, last):
    """Parabolas, hyperbolas, offsets: OCC's form, if it is the curve."""
    try:
        made = curve.toNurbs(first, last)
    except Exception as error:  # OCC's own kinds of failure
        raise NoForm(str(error)) from None
    row = _spline_row(made, made.FirstParameter, made.LastParameter).over(first, last)
    return row


# ---- surfaces --------------------------------------------------------------------------------


def _net_of_rows(rows, degree, knots):
    """rows[j]: Rows in u with the same knots, the points of a spline in v."""
    points = [list(column) for column in zip(*(row.points for row in rows))]
    return Net((rows[0].degree, degree), (rows[0].knots, knots), points)


def _linear(profile, v0, v1):
    return _net_of_rows([profile(v0), profile(v1)], 1, [v0, v0, v1, v1])


def _circle_profile(surface, angles):
    def profile(v):
        return trig_row([_point(surface.value(k * QUARTER, v)) for k in range(4)], angles)

    return profile


def _circle_of_rows(rows, angles):
    """rows: at four angles; the spline whose lines in v are such rows and which turns in u."""
    flat = [[c for p in row.points for c in p] for row in rows]
    points = [[p[i : i + 4] for i in range(0, len(p), 4)] for p in trig_row(flat, angles).points]
    turned = trig_row([[0.0]] * 4, angles)
    return Net((2, rows[0].degree), (turned.knots, rows[0].knots), points)


def _turned(net):
    return Net(net.degree[::-1], net.knots[::-1], list(map(list, zip(*net.points))))


def _extrusion(surface, box, breaks):
    u0, u1, v0, v1 = box
    row = curve_row(surface.BasisCurve, u0, u1, breaks[0])
    start = surface.BasisCurve.value(u0)
    along = surface.value(u0, 1.0) - surface.value(u0, 0.0)
    base = surface.value(u0, 0.0) - start

    def profile(v):
        s = base + along * v
        return row.moved(lambda p: [p[0] + s.x * p[3], p[1] + s.y * p[3], p[2] + s.z * p[3], p[3]])

    return _linear(profile, v0, v1)


def _revolution(surface, box, breaks):
    u0, u1, v0, v1 = box
    rows = [curve_row(surface.uIso(k * QUARTER), v0, v1, breaks[1]) for k in range(4)]
    return _circle_of_rows(rows, _angles(u0, u1, breaks[0]))


def _spline(surface, box):
    if isinstance(surface, Part.BezierSurface):
        surface = surface.toBSpline()
    own = surface.copy()
    if own.isUPeriodic() or own.isVPeriodic() or not is_clamped(own):
        own.segment(*box)
    poles, weights = own.getPoles(), own.getWeights()
    points = [
        [[p.x * w, p.y * w, p.z * w, w] for p, w in zip(line, line_weights)]
        for line, line_weights in zip(poles, weights)
    ]
    net = Net((own.UDegree, own.VDegree), (own.UKnotSequence, own.VKnotSequence), points)
    if surface.isUPeriodic() or surface.isVPeriodic():
        net = net.over(box)  # it may have come out in another period
    return net.segment(box)


def is_clamped(surface):
    for knots, degree in (
        (surface.UKnotSequence, surface.UDegree),
        (surface.VKnotSequence, surface.VDegree),
    ):
        if knots[0] != knots[degree] or knots[-1] != knots[-1 - degree]:
            return False
    return not surface.isUPeriodic() and not surface.isVPeriodic()


def surface_net(surface, box, breaks=((), ())):
    """The surface on a box of its parameters, over that box; breaks: angles where arcs end."""
    u0, u1, v0, v1 = box
    if isinstance(surface, (Part.BSplineSurface, Part.BezierSurface)):
        return _spline(surface, box)
    if isinstance(surface, (Part.Cylinder, Part.Cone)):
        return _linear(_circle_profile(surface, _angles(u0, u1, breaks[0])), v0, v1)
    if isinstance(surface, (Part.Sphere, Part.Toroid)):
        profile = _circle_profile(surface, _angles(u0, u1, breaks[0]))
        rows = [profile(k * QUARTER) for k in range(4)]
        return _turned(_circle_of_rows(rows, _angles(v0, v1, breaks[1])))
    if isinstance(surface, Part.SurfaceOfExtrusion):
        return _extrusion(surface, box, breaks)
    if isinstance(surface, Part.SurfaceOfRevolution):
        return _revolution(surface, box, breaks)
    if isinstance(surface, Part.Plane):
        points = [[_point(surface.value(u, v)) for v in (v0, v1)] for u in (u0, u1)]
        return nurbs.Net((1, 1), ([u0, u0, u1, u1], [v0, v0, v1, v1]), points)
    raise NoForm("%s has no exact B-spline form" % type(surface).__name__)


_CIRCLES = (Part.Circle, Part.Ellipse, Part.ArcOfCircle, Part.ArcOfEllipse)
_TURNING = (Part.Cylinder, Part.Cone, Part.Sphere, Part.Toroid, Part.SurfaceOfRevolution)


def is_trig(surface, axis):
    """Do the surface's lines in this direction become rational arcs here?"""
    if axis == 1:
        if isinstance(surface, Part.SurfaceOfRevolution):
            return isinstance(surface.uIso(0.0), _CIRCLES)
        return isinstance(surface, (Part.Sphere, Part.Toroid))
    if isinstance(surface, Part.SurfaceOfExtrusion):
        return isinstance(surface.BasisCurve, _CIRCLES)
    return isinstance(surface, _TURNING)


def converted_net(face, box):
    """What OCC makes of a face whose surface has no formula here; the caller measures it."""
    try:
        # cleaned(): OCC >= 7.7 corrupts toNurbs() of a shape that carries triangles
        made = face.cleaned().toNurbs().Faces[0]
        return _spline(made.Surface, made.ParameterRange).over(box)
    except (Part.OCCError, IndexError, TypeError, ValueError) as error:
        raise NoForm(str(error)) from None
