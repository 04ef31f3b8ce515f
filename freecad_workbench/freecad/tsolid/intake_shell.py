# SPDX-License-Identifier: LGPL-2.1-or-later
"""The faces, edges and vertices of a solid as the rest of the intake works with them.

A Face is "rigid": its surface's parameters make it a rectangle, each edge lies along one of the
rectangle's borders, and it can only be cut along isolines; or "free": a planar face with any edges
or a cap cut from a sphere by one circle, which can be filled between any four of its vertices.
Nodes are FreeCAD's vertices and those that cuts add on edges; an Edge keeps its nodes in order, so
an arc (the part of an edge between two nodes that follow each other) is a pair (edge, index).
"""

import math

import FreeCAD
import Part

from .intake_exact import NoForm, is_trig, surface_net
from .intake_spheres import ball_of, ring_of, through, true_circle

TOLERANCE = 1e-7  # OCC's own confusion distance; edges may carry more
ROUND = math.pi / 12  # files keep ten digits of angles; parts have round ones
N_LINE = 32  # intervals in which a trim is compared with an isoline

RIGID, PLANAR, CAP = "rigid", "planar", "cap"
_POLE = (
    "a border of the face shrinks to a single point (a pole), so it has less than four sides; "
    "missing are corners where three edges meet"
)
BORDERS = ("v low", "u high", "v high", "u low")


class Node:
    """A vertex: FreeCAD's (name "Vertex3") or added by a cut (name "")."""

    def __init__(self, number, point, name=""):
        self.number, self.point, self.name = number, point, name

    def __repr__(self):
        return self.name or "(%.6g, %.6g, %.6g)" % tuple(self.point)


class Edge:
    """An edge with its nodes along the curve's parameter."""

    def __init__(self, number, edge, first, last):
        self.number, self.name, self.edge = number, "Edge%d" % number, edge
        self.curve, self._replaced = edge.Curve, False
        self.first, self.last = edge.ParameterRange
        self.nodes = [(self.first, first), (self.last, last)]
        self.uses = []  # (face, border or -1): one entry per use
        self.tolerance = max(TOLERANCE, edge.Tolerance)

    @property
    def closed(self):
        return self.nodes[0][1] is self.nodes[-1][1]

    def replace(self, curve):
        """Takes a Part.Circle of the same parameter, within the tolerance, for the edge's own."""
        self.curve, self._replaced = curve, True

    def point(self, t):
        return self.curve.value(t) if self._replaced else self.edge.valueAt(t)

    def derivative(self, t):
        """By the parameter."""
        if self._replaced:
            return FreeCAD.Vector(*self.curve.tangent(t)[0]) * self.curve.Radius
        return self.edge.derivative1At(t)

    def knots(self):
        """Where pieces of the curve end, from first to last."""
        knots = self.curve.getKnots() if hasattr(self.curve, "getKnots") else ()
        return [self.first] + [k for k in knots if self.first < k < self.last] + [self.last]

    def tangent(self, t):
        """Unit tangent; from a short chord where the derivative vanishes."""
        d = self.derivative(t)
        if d.Length <= 1e-12 * max(1.0, self.edge.Length) / (self.last - self.first):
            step = 1e-4 * (self.last - self.first)
            step = step if t + step <= self.last else -step
            d = (self.point(t + step) - self.point(t)) * (1.0 if step > 0 else -1.0)
        return d.normalize()

    def arcs(self, forward=True):
        """Indices of its arcs with their ends, in the edge's direction or against it."""
        out = [(i, a[1], b[1]) for i, (a, b) in enumerate(zip(self.nodes, self.nodes[1:]))]
        return out if forward else [(i, b, a) for i, a, b in reversed(out)]

    def node_at(self, t):
        """The node at a parameter, as far as the tolerance tells; None where there is none."""
        place = self.point(t)
        for at, node in self.nodes:
            width = abs(at - t) / (self.last - self.first)
            if width < 0.25 and (self.point(at) - place).Length <= self.tolerance:
                return node
        return None


class Face:
    """One face of the input; see above. box and borders belong to rigid faces, loop to free ones.

    borders[k]: (edge, forward) in the direction of the border's parameter; loop: the same once
    around. cuts[axis]: parameters where isolines cut the face. problems: (where, text, point).
    """

    def __init__(self, number, face):
        self.number, self.name, self.face = number, "Face%d" % number, face
        self.surface = face.Surface
        self.type = type(self.surface).__name__
        self.kind = RIGID
        self.box = tuple(face.ParameterRange)
        self.borders = ([], [], [], [])
        self.loop = []
        self.ball = self.ring = None  # of a cap: its sphere, and the circle that it ends in
        self.rim = None  # of a lens: intake_lenses.Rim
        self.cuts = ([], [])
        self.inner = {}  # nodes where cuts cross
        self.snap = 0.0  # how far an edge is from the isoline that it is taken for
        self.problems = []
        self.uses = uses_of(face.OuterWire)
        self._curves, self._rows, self._longest = {}, {}, {}

    @property
    def sign(self):
        return -1 if self.face.Orientation == "Reversed" else 1

    def problem(self, where, text, point=None):
        self.problems.append((where, text, point))

    def pcurve(self, edge):
        """The edge's curve in the surface's parameters: curve, first, last. Asked for the edge as
        this face uses it: its orientation tells which side of a closed surface is meant."""
        if edge.number not in self._curves:
            own = next(e for e in self.uses if e.isSame(edge.edge))
            given = self.face.curveOnSurface(own)
            if given is not None:
                given = (_Shifted(given[0], self._shift(*given[:3])),) + tuple(given[1:])
            self._curves[edge.number] = given
        return self._curves[edge.number]

    def _shift(self, curve, first, last):
        """Whole periods that bring a curve into the face's box: an edge on the seam of a closed
        surface has a curve on either side of it, and the wrong one may be given."""
        p = curve.value(0.5 * (first + last))
        out = []
        for axis, x in enumerate((p.x, p.y)):
            low, high = (self.box[:2], self.box[2:])[axis]
            step = _period(self.surface, axis)
            shifts = (0.0, step, -step) if step else (0.0,)
            far = {s: max(low - (x + s), x + s - high, 0.0) for s in shifts}
            best = min(shifts, key=far.get)
            out.append(best if far[best] < far[0.0] - 1e-6 * (high - low) else 0.0)
        return out

    def distance_of_edge(self, edge, n=64):
        """Largest distance of an edge's own curve from what this face has there."""
        curve, first, last = self.pcurve(edge)[:3]
        worst = 0.0
        for i in range(n + 1):
            p = curve.value(first + (last - first) * i / n)
            at = edge.first + (edge.last - edge.first) * i / n
            worst = max(worst, (self.surface.value(p.x, p.y) - edge.point(at)).Length)
        return worst + self.snap

    def is_seam(self, occ):
        """Does the face use this edge twice? (Edge.isSeam is true also of half a tube's.)"""
        return sum(e.isSame(occ) for e in self.uses) > 1

    def distinct_uses(self):
        out = []
        for edge in self.uses:
            if not any(edge.isSame(e) for e in out):
                out.append(edge)
        return out

    def blur(self, axis, tolerance=TOLERANCE):
        """How much of a parameter is nothing: by rounding, or as isolines so near to each other
        have no points that are further apart than a tolerance."""
        low, high = (self.box[:2], self.box[2:])[axis]
        if axis not in self._longest:
            self._longest[axis] = _longest_line(self.surface, self.box, axis)
        share = tolerance / max(self._longest[axis], tolerance)
        return max(1e-9, min(share, 1e-3)) * (high - low)

    def parameter_on(self, k, edge, t):
        """Where on border k, as a parameter of the surface, the edge's point t lies."""
        curve = self.pcurve(edge)[0]
        p = curve.value(t)
        low, high = (self.box[:2], self.box[2:])[k % 2]
        value = min(max((p.x, p.y)[k % 2], low), high)
        blur = self.blur(k % 2, edge.tolerance)
        return next((x for x in (low, high) if abs(x - value) <= blur), value)

    def border_tangent(self, k, edge, t):
        """Unit tangent of a rigid face's border k, in the direction of its parameter, at an end t
        of an edge: where the surface has a kink there, the one on the edge's side."""
        row = self._border_row(k)
        if row is None:
            return edge.tangent(t)
        here, there = (self.parameter_on(k, edge, x) for x in (t, edge.first + edge.last - t))
        points = row.segment(*sorted((here, there))).points
        a, b = points[:2] if here < there else points[-2:]
        return FreeCAD.Vector(*(y / b[3] - x / a[3] for x, y in zip(a[:3], b[:3]))).normalize()

    def _border_row(self, k):
        """Border k as a B-spline, None where there is no formula for it."""
        if k not in self._rows:
            try:
                self._rows[k] = surface_net(self.surface, self.box).border(k)
            except NoForm:
                self._rows[k] = None
        return self._rows[k]

    def along(self, k):
        """The border's edges with their ranges on it: (edge, forward, low, high) ascending."""
        out = []
        for edge, _ in self.borders[k]:
            a, b = (self.parameter_on(k, edge, t) for t in (edge.first, edge.last))
            out.append((edge, a < b, min(a, b), max(a, b)))
        return sorted(out, key=lambda x: x[2])

    def stops(self, k):
        """The border's nodes: (parameter, node) ascending, both corners included."""
        out = []
        for edge, forward, _, _ in self.along(k):
            row = [(self.parameter_on(k, edge, t), node) for t, node in edge.nodes]
            row = row if forward else row[::-1]
            out += row[1:] if out else row
        return out


class _Shifted:
    """A curve in the parameter plane, moved."""

    def __init__(self, curve, shift):
        self._curve, self._by = curve, FreeCAD.Base.Vector2d(*shift)

    def value(self, t):
        return self._curve.value(t) + self._by


def _longest_line(surface, box, axis, n=8):
    """About how long an isoline gets, counted as if it were as fast everywhere as in its fastest
    part."""
    steps = [[low + (high - low) * i / n for i in range(n + 1)] for low, high in (box[:2], box[2:])]
    longest = 0.0
    for x in steps[1 - axis]:
        line = [surface.value(*((t, x) if axis == 0 else (x, t))) for t in steps[axis]]
        longest = max([longest] + [(q - p).Length for p, q in zip(line, line[1:])])
    return n * longest


def _period(surface, axis):
    """After how much of a parameter a closed surface repeats, or comes back; 0: it does not."""
    if is_trig(surface, axis):
        return 2.0 * math.pi
    if isinstance(surface, Part.BSplineSurface):
        closed = (surface.isUClosed, surface.isVClosed)[axis]()
        bounds = surface.bounds()
        return bounds[2 * axis + 1] - bounds[2 * axis] if closed else 0.0
    return 0.0


def uses_of(wire):
    """The edges of a wire as often as it has them, in their orientations: a seam twice, which
    FreeCAD lists twice up to 0.21, and once from 1.0 on. A walk along the wire passes it twice."""
    edges = [e for e in wire.childShapes() if e.ShapeType == "Edge"]
    walk = wire.OrderedEdges
    once = [e for e in edges if sum(map(e.isSame, edges)) < sum(map(e.isSame, walk))]
    return edges + [e.reversed() for e in once]


# ---- reading ---------------------------------------------------------------------------------


class Shell:
    """All faces of a solid, with shared edges and nodes."""

    def __init__(self, shape, tell=None):
        self.shape = shape
        self._edge_pool, self._vertex_pool = {}, {}
        self.nodes = []
        for number, vertex in enumerate(shape.Vertexes, 1):
            node = self.new_node(vertex.Point, "Vertex%d" % number)
            self._vertex_pool.setdefault(vertex.hashCode(), []).append((vertex, node))
        self.edges = []
        for number, edge in enumerate(shape.Edges, 1):
            item = None
            if not edge.Degenerated:
                item = Edge(number, edge, *self._ends(edge))
                self.edges.append(item)
            self._edge_pool.setdefault(edge.hashCode(), []).append((edge, item))
        self.faces = []
        for number, face in enumerate(shape.Faces, 1):
            if tell is not None:
                tell((number - 1) / len(shape.Faces))
            self.faces.append(_read_face(Face(number, face), self))

    def new_node(self, point, name=""):
        self.nodes.append(Node(len(self.nodes), point, name))
        return self.nodes[-1]

    def add_node(self, edge, t):
        """The node at a parameter of an edge, made where there is none."""
        node = edge.node_at(t)
        if node is None:
            node = self.new_node(edge.point(t))
            edge.nodes.append((t, node))
            edge.nodes.sort(key=lambda x: x[0])
        return node

    def _ends(self, edge):
        return [self.node(v) for v in (edge.firstVertex(False), edge.lastVertex(False))]

    def node(self, vertex):
        return _found(self._vertex_pool, vertex)

    def edge(self, edge):
        return _found(self._edge_pool, edge)


def _found(pool, item):
    for known, value in pool.get(item.hashCode(), ()):
        if known.isSame(item):
            return value
    return None


def _read_face(face, shell):
    """Sorts a face into rigid, planar or cap, and its edges into borders or a loop."""
    if len(face.face.Wires) != 1:
        holes = len(face.face.Wires) - 1
        text = (
            "the face has %d inner border%s (a boss, a pocket or a bore); a side of the cube has "
            "only the outer one: split the part there" % (holes, "" if holes == 1 else "s")
        )
        face.problem("", text, face.face.CenterOfMass)
        return face
    if face.face.Area <= 0.0:
        face.problem("", "the face has no area")
        return face
    if isinstance(face.surface, Part.Plane):
        face.kind = PLANAR
    elif isinstance(face.surface, Part.Sphere) and _is_cap(face, shell):
        face.kind = CAP
    else:
        _place_all(face, shell)
        if face.problems:
            _free(face, shell)
    if face.kind != RIGID:
        face.loop = _loop(face, shell)
        for edge, _ in face.loop:
            edge.uses.append((face, -1))
    return face


def _free(face, shell):
    """A face that is no rectangle may yet be a plane, or a sphere's cap, written in another way."""
    if any("isoparametric" in text for _, text, _ in face.problems) and _is_flat(face):
        face.kind = PLANAR
    elif _is_cap(face, shell):
        face.kind = CAP
    else:
        return
    face.problems, face.borders, face.snap = [], ([], [], [], []), 0.0
    for edge in shell.edges:
        edge.uses = [(other, k) for other, k in edge.uses if other is not face]


def _is_flat(face):
    return face.face.findPlane(TOLERANCE) is not None


def _loop(face, shell):
    """The outer wire's edges once around, without seams and poles, each with its direction."""
    left = _outline(face, shell)
    if len(left) == 1:
        return [(left[0], True)]
    loop = [(left[0], True)]
    end = left.pop(0).nodes[-1][1]
    while left:
        for k, edge in enumerate(left):
            if edge.nodes[0][1] is end or edge.nodes[-1][1] is end:
                forward = edge.nodes[0][1] is end
                loop.append((left.pop(k), forward))
                end = edge.nodes[-1 if forward else 0][1]
                break
        else:
            face.problem("", "the face's edges do not close to one loop")
            break
    return loop


def _outline(face, shell):
    edges = [e for e in face.distinct_uses() if not e.Degenerated and not face.is_seam(e)]
    return [shell.edge(e) for e in edges]


def _is_cap(face, shell):
    """Is this the part of a sphere on one side of one circle?"""
    outer = _outline(face, shell)
    if not outer:
        return False
    for edge in outer:
        _make_true(face, edge)
    face.ring = ring_of(outer)
    face.ball = ball_of(face.surface, face.box) if face.ring is not None else None
    if face.ball is None:
        return False
    face.ball = through(face.ball, face.ring)
    return True


def _make_true(face, edge):
    circle = true_circle(face, edge)
    if circle is not None:
        edge.replace(circle)


# ---- rigid faces -----------------------------------------------------------------------------


def _place_all(face, shell):
    """Finds for each edge of a rigid face the border along which it runs."""
    _snap_to_knots(face)
    for occ in face.distinct_uses():
        edge = shell.edge(occ)
        if edge is None:
            vertex = occ.Vertexes[0]
            where = shell.node(vertex).name
            face.problem(where, _POLE, vertex.Point)
        elif face.is_seam(occ):
            _place_seam(face, edge)
        else:
            _place(face, edge)
    if not face.problems:
        _tighten(face)
        _order_borders(face)
    if not face.problems and not all(face.borders):
        face.problem("", "a border of the face has no edge")


def knots_of(surface):
    """Where the surface's own spans end, in u and v."""
    if isinstance(surface, Part.BSplineSurface):
        return surface.getUKnots(), surface.getVKnots()
    basis = getattr(surface, "BasisCurve", None)
    knots = basis.getKnots() if isinstance(basis, Part.BSplineCurve) else []
    return ([], knots) if isinstance(surface, Part.SurfaceOfRevolution) else (knots, [])


def _snap_to_knots(face):
    """The face's parameter range, brought to knots that are the same place: else a span as narrow
    as what a file format rounds away would be left."""
    surface = face.surface
    knots, box = knots_of(surface), list(face.box)
    for i in range(4):
        if is_trig(surface, i // 2):
            round_angle = ROUND * round(box[i] / ROUND)
            if abs(round_angle - box[i]) <= 1e-8:
                box[i] = round_angle
    for i in range(4):
        if not knots[i // 2]:
            continue
        near = min(knots[i // 2], key=lambda k: abs(k - box[i]))
        other = 0.5 * (face.box[2] + face.box[3] if i < 2 else face.box[0] + face.box[1])
        places = [surface.value(*((x, other) if i < 2 else (other, x))) for x in (near, box[i])]
        width = face.box[2 * (i // 2) + 1] - face.box[2 * (i // 2)]
        if abs(near - box[i]) <= 1e-3 * width and (places[0] - places[1]).Length <= TOLERANCE:
            box[i] = near
    face.box = tuple(box)


def _trim_points(face, edge):
    given = face.pcurve(edge)
    if given is None:
        return None
    curve, first, last = given[:3]
    return [curve.value(first + (last - first) * i / N_LINE) for i in range(N_LINE + 1)]


def _distance_from_isoline(face, points, k):
    """Largest distance in space of a trim from border k of the box."""
    value = (face.box[2], face.box[1], face.box[3], face.box[0])[k]
    worst = 0.0
    for p in points:
        on = (p.x, value) if k % 2 == 0 else (value, p.y)
        worst = max(worst, (face.surface.value(p.x, p.y) - face.surface.value(*on)).Length)
    return worst


def _place(face, edge):
    points = _trim_points(face, edge)
    middle = edge.point(0.5 * (edge.first + edge.last))
    if points is None:
        face.problem(edge.name, "the edge has no curve on the surface", middle)
        return
    runs = (max(p.x for p in points) - min(p.x for p in points),
            max(p.y for p in points) - min(p.y for p in points))
    size = (face.box[1] - face.box[0], face.box[3] - face.box[2])
    axis = 0 if runs[0] / size[0] >= runs[1] / size[1] else 1
    far = {k: _distance_from_isoline(face, points, k) for k in (axis, axis + 2)}
    best = min(far, key=far.get)
    if far[best] <= edge.tolerance:
        _make_true(face, edge)
        face.borders[best].append((edge, True))
        face.snap = max(face.snap, far[best])
        edge.uses.append((face, best))
        return
    away = _bend(face, points, axis)
    if away <= edge.tolerance:
        text = "the face is not a rectangle of its surface's isoparametric lines: one runs inside"
    else:
        text = ("trimmed along a curve that is not an isoparametric line (it leaves the nearest one"
                " by %.3g)" % away)
    face.problem(edge.name, text, middle)


def _bend(face, points, axis):
    """How far a trim is from being any isoline at all: from the one through its middle."""
    values = sorted((p.y if axis == 0 else p.x) for p in points)
    value, worst = values[len(values) // 2], 0.0
    for p in points:
        on = (p.x, value) if axis == 0 else (value, p.y)
        worst = max(worst, (face.surface.value(p.x, p.y) - face.surface.value(*on)).Length)
    return worst


def _place_seam(face, edge):
    """A seam is two opposite borders at once, a whole turn apart, whatever a file left of that."""
    points = _trim_points(face, edge)
    if points is None:
        face.problem(edge.name, "the edge has no curve on the surface")
        return
    across_u = abs(points[0].x - points[-1].x) < abs(points[0].y - points[-1].y)
    axis = 0 if across_u else 1
    if is_trig(face.surface, axis):
        box = list(face.box)
        box[2 * axis + 1] = box[2 * axis] + 2.0 * math.pi
        face.box = tuple(box)
    for k in (1, 3) if across_u else (0, 2):
        face.borders[k].append((edge, True))
        edge.uses.append((face, k))


def _tighten(face):
    """The box of a face as its edges have it: OCC's own may be wider by the tolerance."""
    box = list(face.box)
    for k in range(4):
        at, axis = (2, 1, 3, 0)[k], 1 - k % 2
        values = []
        for edge, _ in face.borders[k]:
            curve = face.pcurve(edge)[0]
            if not face.is_seam(edge.edge):
                points = [curve.value(t) for t in (edge.first, edge.last)]
                values += [(p.x, p.y)[axis] for p in points]
        if values:
            box[at] = math.fsum(values) / len(values)
    face.box = tuple(box)
    _snap_to_knots(face)


def _order_borders(face):
    for k in range(4):
        ordered = [(edge, forward) for edge, forward, _, _ in face.along(k)]
        face.borders[k][:] = ordered
    for k in range(4):
        if not face.borders[k]:
            continue
        low, high = (face.box[:2], face.box[2:])[k % 2]
        spans = face.along(k)
        reach = spans[0][2] - low + high - spans[-1][3]
        if reach > 1e-6 * (high - low):
            face.problem("", "its border (%s) is not covered by edges" % BORDERS[k])


def near(face, axis, a, b):
    """Are two parameters one, but for rounding and for what a file left of the coordinates?"""
    return abs(a - b) <= face.blur(axis)


def arcs_of(face):
    """The loop's arcs: (edge, index, forward, from, to)."""
    return [
        (edge, i, forward, a, b)
        for edge, forward in face.loop
        for i, a, b in edge.arcs(forward)
    ]
