# SPDX-License-Identifier: LGPL-2.1-or-later
"""Spheres and circles that a file has written as something else.

IGES knows no spheres: FreeCAD reads them as surfaces of revolution, other programs write rational
splines; and the circles between them come back as splines near them. A surface is a sphere when all
its points have one distance from one point; how far they do not is measured and declared.
"""

import collections
import math

import FreeCAD
import Part

from .intake_exact import is_trig

N_FIT, N_VERIFY = 8, 24  # intervals per direction
TOLERANCE = 1e-7

Ball = collections.namedtuple("Ball", "centre radius deviation")
Ball.__doc__ = "deviation: the largest distance of the surface as read from this sphere."

Ring = collections.namedtuple("Ring", "Center Axis Radius")
Ring.__doc__ = "A circle without a parameter, with Part.Circle's names."


def ball_of(surface, box):
    """The sphere that the surface is within TOLERANCE over a box of its parameters; None."""
    if isinstance(surface, Part.Sphere):
        return Ball(surface.Center, surface.Radius, 0.0)
    fitted = _fit(_grid(surface, box, N_FIT))
    if fitted is None:
        return None
    centre, radius = fitted
    far = (abs((p - centre).Length - radius) for p in _grid(surface, box, N_VERIFY))
    deviation = max(far)
    return Ball(centre, radius, deviation) if deviation <= TOLERANCE else None


def through(ball, ring):
    """The sphere next to a ball that passes through a circle, if the ball does within TOLERANCE:
    what is laid between the two has one border then, not two that a file's last digits part."""
    height = (ball.centre - ring.Center).dot(ring.Axis)
    centre = ring.Center + ring.Axis * height
    radius = math.hypot(height, ring.Radius)
    moved = (centre - ball.centre).Length + abs(radius - ball.radius)
    return Ball(centre, radius, ball.deviation + moved) if moved <= TOLERANCE else ball


def _grid(surface, box, n):
    u0, u1, v0, v1 = box
    return [surface.value(u0 + (u1 - u0) * i / n, v0 + (v1 - v0) * j / n)
            for i in range(n + 1) for j in range(n + 1)]


def _fit(points):
    """Centre and radius by least squares: first of |x|^2, then twice of |x - centre|."""
    n = len(points)
    middle = FreeCAD.Vector(*(math.fsum(row) / n for row in zip(*points)))
    size = max((p - middle).Length for p in points)
    if not size > 0.0:
        return None
    local = [(p - middle) * (1.0 / size) for p in points]
    found = _least_squares([(2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0, p.dot(p)) for p in local])
    if found is None:
        return None
    centre = FreeCAD.Vector(*found[:3])
    square = found[3] + centre.dot(centre)
    if not 0.0 < square < 1e8:  # flatter than a ten thousandth: a plane as likely
        return None
    radius = math.sqrt(square)
    for _ in range(2):
        rows = []
        for p in local:
            away = p - centre
            normal = away * (1.0 / away.Length)
            rows.append((normal.x, normal.y, normal.z, 1.0, away.Length - radius))
        step = _least_squares(rows)
        if step is None:
            return None
        centre, radius = centre + FreeCAD.Vector(*step[:3]), radius + step[3]
    return middle + centre * size, radius * size


def _least_squares(rows):
    """The four unknowns of rows (a, b, c, d, right side), by modified Gram-Schmidt."""
    columns = [list(column) for column in zip(*rows)]
    factors = [[0.0] * 5 for _ in range(4)]
    for k in range(4):
        length = math.sqrt(math.fsum(x * x for x in columns[k]))
        if not length > 1e-9:
            return None
        unit = [x / length for x in columns[k]]
        factors[k][k] = length
        for m in range(k + 1, 5):
            f = math.fsum(x * y for x, y in zip(unit, columns[m]))
            factors[k][m] = f
            columns[m] = [y - f * x for x, y in zip(unit, columns[m])]
    out = [0.0] * 4
    for k in reversed(range(4)):
        rest = math.fsum(factors[k][m] * out[m] for m in range(k + 1, 4))
        out[k] = (factors[k][4] - rest) / factors[k][k]
    return out


# ---- circles -----------------------------------------------------------------------------------


def ring_of(edges):
    """The circle that edges go round once, all of them within their tolerance; None."""
    curve = edges[0].curve
    if isinstance(curve, Part.Circle):
        ring = Ring(curve.Center, curve.Axis, curve.Radius)
    else:
        ring = _ring_through(edges)
    if ring is None:
        return None
    around = math.fsum(e.edge.Length for e in edges) / ring.Radius
    fits = all(_distance(e, ring) <= e.tolerance for e in edges)
    return ring if fits and abs(around - 2.0 * math.pi) < 1e-5 else None


def _ring_through(edges):
    points = [e.point(e.first + (e.last - e.first) * t) for e in edges for t in (0.1, 0.4, 0.7)]
    a, b, c = points[0], points[len(points) // 3], points[2 * len(points) // 3]
    if (b - a).cross(c - a).Length <= 1e-9 * (b - a).Length * (c - a).Length:
        return None
    circle = Part.Circle(a, b, c)
    return Ring(circle.Center, circle.Axis, circle.Radius)


def _distance(edge, ring, n=32):
    worst = 0.0
    for i in range(n + 1):
        away = edge.point(edge.first + (edge.last - edge.first) * i / n) - ring.Center
        height = away.dot(ring.Axis)
        worst = max(worst, abs(height), abs((away - ring.Axis * height).Length - ring.Radius))
    return worst


def true_circle(face, edge, n=16):
    """The circle, with the edge's own parameter, that a spline along a circle of the face's surface
    stands for; None where the edge is none or leaves it by more than its tolerance."""
    if isinstance(edge.curve, Part.Circle) or face.pcurve(edge) is None:
        return None
    curve, first, last = face.pcurve(edge)[:3]
    a, b = curve.value(first), curve.value(last)
    speed = ((b.x - a.x) / (last - first), (b.y - a.y) / (last - first))
    axis = 0 if abs(speed[0]) > abs(speed[1]) else 1
    if abs(abs(speed[axis]) - 1.0) > 1e-9 or not is_trig(face.surface, axis):
        return None
    sign = round(speed[axis])
    along, across = ((a.x, a.y), (a.y, a.x))[axis]
    line = (face.surface.vIso, face.surface.uIso)[axis](across)
    circle = _from(getattr(line, "Circle", line), along - sign * first, sign)
    if circle is None:
        return None
    ts = [first + (last - first) * i / n for i in range(n + 1)]
    far = max((circle.value(t) - edge.point(t)).Length for t in ts)
    return circle if far <= edge.tolerance else None


def _from(circle, turn, sign):
    """A circle whose parameter t is turn + sign t of the given one; None where that is none."""
    if not isinstance(circle, Part.Circle):
        return None
    start, ahead = (circle.value(turn + sign * t) - circle.Center for t in (0.0, 0.5 * math.pi))
    out = Part.Circle(circle.Center, start.cross(ahead), circle.Radius)
    out.XAxis = start
    return out
