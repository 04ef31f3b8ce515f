# SPDX-License-Identifier: LGPL-2.1-or-later
"""Contacts between the solids of an assembly as FreeCAD's own kernel sees them: faces that lie on
each other, gaps, and solids that penetrate each other. Works on any solids, also on those that are
no solid T-splines' business.

A pair of faces is judged at points of both: a grid inside and points on all edges. Those that
stand over the other face, no farther from it than `reach`, are its contact; their largest distance
is the gap.
What is smaller than the grid is not seen. Penetration is a common volume, by a boolean operation.
"""

import math

import Part

KINDS = ("contact", "partial contact", "near contact", "clash")
CONTACT, PARTIAL, NEAR, CLASH = KINDS
GRID = 7  # points per direction inside a face, and per edge
TOLERANCE = 1e-7
BESIDE = 1.001  # a little beside a face that is not parallel still counts as over it


class Contact:
    """Two faces of two members (numbers from 0), or, faces None, two members that penetrate each
    other. gap: largest distance of the points in contact; least: the smallest; place: where the
    gap is largest; covered: shares of both faces' points that are in contact; volume: common."""

    def __init__(self, kind, members, faces, gap, least, place, covered, volume=0.0):
        self.kind, self.members, self.faces = kind, members, faces
        self.gap, self.least, self.place = gap, least, place
        self.covered, self.volume = covered, volume


class _Face:
    def __init__(self, face):
        self.face = face
        self.box = face.BoundBox
        self.tolerance = max([TOLERANCE, face.Tolerance] + [e.Tolerance for e in face.Edges])
        self.points, self.inner = _points(face)


def _points(face):
    """Points on the edges and inside; and how many of them are inside (they stand first)."""
    u0, u1, v0, v1 = face.ParameterRange
    inside = []
    for i in range(GRID):
        for j in range(GRID):
            u = u0 + (u1 - u0) * (i + 0.5) / GRID
            v = v0 + (v1 - v0) * (j + 0.5) / GRID
            if face.isPartOfDomain(u, v):
                inside.append((u, v))
    points = [face.valueAt(u, v) for u, v in inside]
    for edge in face.Edges:
        if not edge.Degenerated:
            first, last = edge.ParameterRange
            points += [edge.valueAt(first + (last - first) * k / (GRID - 1.0)) for k in range(GRID)]
    return points, len(inside)


def _distance(face, point):
    """The distance of a point from a face that it stands over; inf when it stands beside it, that
    is, when its foot is on the border and the way there is no normal."""
    try:
        u, v = face.Surface.parameter(point)
        way = point - face.Surface.value(u, v)
        if not face.isPartOfDomain(u, v):
            foot = Part.Vertex(point).distToShape(face)[1][0][1]
            way = point - foot
            u, v = face.Surface.parameter(foot)
        distance = way.Length
        if distance <= TOLERANCE:
            return distance
        along = abs(way.dot(face.normalAt(u, v)))
    except (Part.OCCError, RuntimeError):
        return math.inf
    return distance if distance <= BESIDE * along else math.inf


def _touching(points, face, reach):
    """(distance, point) of the points that lie within reach of a face."""
    box = face.box
    grown = (box.XMin - reach, box.XMax + reach, box.YMin - reach, box.YMax + reach,
             box.ZMin - reach, box.ZMax + reach)
    out = []
    for p in points:
        if (grown[0] <= p.x <= grown[1] and grown[2] <= p.y <= grown[3]
                and grown[4] <= p.z <= grown[5]):
            distance = _distance(face.face, p)
            if distance <= reach:
                out.append((distance, p))
    return out


def _boxes_meet(a, b, reach):
    return (a.XMin <= b.XMax + reach and b.XMin <= a.XMax + reach
            and a.YMin <= b.YMax + reach and b.YMin <= a.YMax + reach
            and a.ZMin <= b.ZMax + reach and b.ZMin <= a.ZMax + reach)


def candidate_pairs(boxes, reach):
    """Pairs of boxes that are no farther apart than reach, found along the longest axis."""
    low = [(b.XMin, b.YMin, b.ZMin) for b in boxes]
    high = [(b.XMax, b.YMax, b.ZMax) for b in boxes]
    spread = [max((p[a] for p in low), default=0) - min((p[a] for p in low), default=0)
              for a in range(3)]
    axis = spread.index(max(spread))
    order = sorted(range(len(boxes)), key=lambda k: low[k][axis])
    open_, pairs = [], []
    for k in order:
        open_ = [m for m in open_ if high[m][axis] + reach >= low[k][axis]]
        pairs += [(min(k, m), max(k, m)) for m in open_ if _boxes_meet(boxes[k], boxes[m], reach)]
        open_.append(k)
    return sorted(pairs)


def _judge(members, faces, a, b, reach):
    """The contact of two faces; None when they only meet along edges or not at all."""
    of_a = _touching(a.points[: a.inner], b, reach)
    of_b = _touching(b.points[: b.inner], a, reach)
    if not of_a and not of_b or not _opposite(a, b, of_a, of_b):
        return None
    covered = (len(of_a) / max(1, a.inner), len(of_b) / max(1, b.inner))
    found = of_a + of_b + _touching(a.points[a.inner:], b, reach)
    found += _touching(b.points[b.inner:], a, reach)
    gap, place = max(found, key=lambda x: x[0])
    least = min(found, key=lambda x: x[0])[0]
    kind = NEAR
    if gap <= max(a.tolerance, b.tolerance):
        kind = CONTACT if min(covered) == 1.0 else PARTIAL
    return Contact(kind, members, faces, gap, least, tuple(place), covered)


def _opposite(a, b, of_a, of_b):
    """Faces that look at each other, not past each other as two walls that meet in an edge do."""
    face, other, point = (a.face, b.face, of_a[0][1]) if of_a else (b.face, a.face, of_b[0][1])
    normals = []
    for f in (face, other):
        u, v = f.Surface.parameter(point)
        normals.append(f.normalAt(u, v))
    return normals[0].dot(normals[1]) < -math.cos(math.radians(60.0))


def _common(first, second):
    """The volume that two solids share, and a point of it."""
    try:
        shared = first.common(second)
    except (Part.OCCError, RuntimeError):
        return 0.0, None
    solids = [s for s in shared.Solids if s.Volume > 0.0]
    if not solids:
        return 0.0, None
    largest = max(solids, key=lambda s: s.Volume)
    return sum(s.Volume for s in solids), tuple(largest.CenterOfMass)


def smallest_size(shapes):
    """The bounding-box diagonal of the smallest shape."""
    return min((s.BoundBox.DiagonalLength for s in shapes), default=0.0)


def find(shapes, gap=None, progress=None):
    """All contacts between the shapes of an assembly. gap: how far apart faces may be to be near
    contacts; None: a hundredth of the smaller part's diagonal, for each pair.

    progress(fraction) may raise to stop.
    """
    largest = max((s.BoundBox.DiagonalLength for s in shapes), default=0.0)
    reach = 0.01 * largest if gap is None else gap
    pairs = candidate_pairs([s.BoundBox for s in shapes], reach)
    faces, out = {}, []
    for n, (i, j) in enumerate(pairs):
        if progress is not None:
            progress(n / len(pairs))
        own = 0.01 * smallest_size((shapes[i], shapes[j])) if gap is None else gap
        for k in (i, j):
            if k not in faces:
                faces[k] = [_Face(f) for f in shapes[k].Faces]
        found = _of_pair((i, j), faces[i], faces[j], max(own, TOLERANCE))
        clash = _clash((i, j), shapes[i], shapes[j], found)
        out += [clash] if clash is not None else found
    return out


def _of_pair(members, first, second, reach):
    found = []
    for i, a in enumerate(first):
        for j, b in enumerate(second):
            if _boxes_meet(a.box, b.box, reach):
                contact = _judge(members, (i, j), a, b, reach)
                if contact is not None:
                    found.append(contact)
    return found


def _clash(members, a, b, found):
    """A common volume that is more than what the tolerances of faces in contact explain."""
    box = a.BoundBox.intersected(b.BoundBox)
    if not box.isValid() or min(box.XLength, box.YLength, box.ZLength) <= TOLERANCE:
        return None
    volume, place = _common(a, b)
    thin = 10.0 * TOLERANCE * min(a.Area, b.Area)
    if volume <= max(thin, 1e-12 * min(a.Volume, b.Volume)):
        return None
    return Contact(CLASH, members, None, 0.0, 0.0, place, (0.0, 0.0), volume)
