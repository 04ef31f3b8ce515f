# SPDX-License-Identifier: LGPL-2.1-or-later
"""Ruled faces that take over their neighbours' parameters.

Two faces may share a curve but not its parameter: C(u) = c(s) with u = phi(s). Where phi is affine
or a Moebius change the library needs no help. Where it is not, one face has to be written in the
other's parameter, and that is exact for a face of straight lines x(u, v) = (1 - v) P(u) + v Q(u):

    along P and Q: if Q = g P + d, as in extrusions, cylinders, cones and frusta of any profile, the
    neighbour's c(s) = P(phi(s)) gives the other side, g c(s) + d (homogeneous: g X + W d, W);
    along the lines: if P and Q have the same weights, a neighbour's line with the homogeneous
    points (X, W) has w = (X / W - P) . (Q - P) / |Q - P|^2 of the way behind it at t, and the face
    is (W - W1) P + W1 Q with W1 = w W.

Faces that are not ruled lead; a ruled face follows those that lead already, then leads itself. What
follows is the same set of points: the caller measures it against the surface as read.
"""

import collections
import math

from .intake_cells import border_arcs
from .intake_shell import TOLERANCE
from .nurbs import Net, Row, joined

ALONG = ((0, 2), (3, 1))  # the borders that run in u: v low, v high; in v: u low, u high
_PLACES = [k / 8.0 for k in range(9)]
_ALIKE = 1e-13  # relative: points that one factor or one image makes equal

Piece = collections.namedtuple("Piece", "ends row leader span")
Piece.__doc__ = """An arc of a border: its ends as parameters of the face, the curve that it is to
have over [0, 1], the (face, border) that this is taken from, and the ends as parameters there."""


# ---- comparing curves ----------------------------------------------------------------------------


def find_on(row, place, n=32):
    """The parameter of the row's point next to a place, to rounding."""
    ends = [row.first + (row.last - row.first) * i / n for i in range(n + 1)]
    far = [math.dist(row.place(t), place) for t in ends]
    i = min(range(n + 1), key=far.__getitem__)
    a, b = ends[max(i - 1, 0)], ends[min(i + 1, n)]
    for _ in range(40):
        s, t = a + (b - a) / 3.0, b - (b - a) / 3.0
        if math.dist(row.place(s), place) <= math.dist(row.place(t), place):
            b = t
        else:
            a = s
    return _polished(row, place, 0.5 * (a + b))


def _polished(row, place, t):
    """Newton's method for (x(t) - place) . x' = 0 with a short chord for x': comparing distances
    alone ends at the square root of the rounding."""
    for _ in range(4):
        h = 1e-6 * (row.last - row.first)
        a, b = max(row.first, t - h), min(row.last, t + h)
        chord = [(y - x) / (b - a) for x, y in zip(row.place(a), row.place(b))]
        gap = [x - y for x, y in zip(place, row.place(t))]
        square = sum(x * x for x in chord)
        if square <= 0.0:
            break
        step = sum(x * y for x, y in zip(gap, chord)) / square
        t = min(max(t + step, row.first), row.last)
    return t


def same_parameter(p, q, allowed):
    """Do two curves over [0, 1] agree at equal parameters, or after a Moebius change?"""
    if p.degree == q.degree and p.knots == q.knots:
        c = q.points[0][3] / p.points[0][3]
        if all(math.dist([c * x for x in a], b) <= _ALIKE * math.dist(b, [0.0] * 4)
               for a, b in zip(p.points, q.points)):
            return True
    places = [p.place(t) for t in _PLACES]
    if all(math.dist(x, q.place(t)) <= allowed for t, x in zip(_PLACES, places)):
        return True
    middle = find_on(q, p.place(0.5))
    if not 0.0 < middle < 1.0:
        return False
    c = middle / (1.0 - middle)
    changed = (q.place(c * t / (1.0 + (c - 1.0) * t)) for t in _PLACES)
    return all(math.dist(x, y) <= allowed for x, y in zip(places, changed))


# ---- ruled nets ----------------------------------------------------------------------------------


def ruled_axes(net):
    """The directions in which a net has straight lines of two control points."""
    sizes = (len(net.points), len(net.points[0]))
    return [a for a in (0, 1) if net.degree[a] == 1 and sizes[a] == 2]


def _image(p, q):
    """g, d with q = g p + d for two rows of control points with the same weights, else None."""
    weight = q.points[0][3] / p.points[0][3]
    if any(abs(b[3] - weight * a[3]) > _ALIKE * b[3] for a, b in zip(p.points, q.points)):
        return None
    a = [[c / x[3] for c in x[:3]] for x in p.points]
    b = [[c / x[3] for c in x[:3]] for x in q.points]
    n = len(a)
    middle = [[math.fsum(x[c] for x in points) / n for c in range(3)] for points in (a, b)]
    up = math.fsum((x[c] - middle[0][c]) * (y[c] - middle[1][c])
                   for x, y in zip(a, b) for c in range(3))
    down = math.fsum((x[c] - middle[0][c]) ** 2 for x in a for c in range(3))
    g = up / down
    d = [y - g * x for x, y in zip(*middle)]
    size = max(abs(c) for x in a + b for c in x)
    for x, y in zip(a, b):
        if math.dist([g * c + e for c, e in zip(x, d)], y) > _ALIKE * size:
            return None
    return weight, g, d


def _image_of(image, row):
    weight, g, d = image
    return row.moved(
        lambda x: [weight * (g * c + e * x[3]) for c, e in zip(x, d)] + [weight * x[3]]
    )


def _inverse(image):
    weight, g, d = image
    return 1.0 / weight, 1.0 / g, [-c / g for c in d]


def with_profile(net, axis, rows):
    """The net with other curves in direction axis: rows for its low and its high border, or None
    where the other's image will do. None where there is none."""
    image = _image(*(net.border(k) for k in ALONG[axis]))
    first, second = rows
    if None in rows and (image is None or image[1] == 0.0):
        return None
    if first is None:
        first = _image_of(_inverse(image), second)
    if second is None:
        second = _image_of(image, first)
    if (first.degree, first.knots) != (second.degree, second.knots):
        return None
    lines = [[list(x), list(y)] for x, y in zip(first.points, second.points)]
    degree, knots = list(net.degree), list(net.knots)
    degree[axis], knots[axis] = first.degree, first.knots
    return Net(degree, knots, lines if axis == 0 else list(map(list, zip(*lines))))


def with_lines(net, axis, rows):
    """The net with another parameter on its straight lines, which run in direction axis: that of
    the first of two rows that is there. None where weights differ between the lines' ends."""
    at, row = (0, rows[0]) if rows[0] else (-1, rows[1])
    low, high = (_fours(long) for long in net.along(axis).points)
    weight = high[0][3] / low[0][3]
    if any(abs(b[3] - weight * a[3]) > _ALIKE * b[3] for a, b in zip(low, high)):
        return None
    high = [[c / weight for c in b] for b in high]
    start, end = ([c / x[3] for c in x[:3]] for x in (low[at], high[at]))
    way = [b - a for a, b in zip(start, end)]
    square = sum(c * c for c in way)
    points = []
    for x in row.points:
        behind = sum((c - a * x[3]) * b for c, a, b in zip(x, start, way)) / square
        points.append([(x[3] - behind) * a + behind * b
                       for pair in zip(low, high) for a, b in zip(*pair)])
    return net.replaced(axis, Row(row.degree, row.knots, points))


def _fours(flat):
    return [flat[i : i + 4] for i in range(0, len(flat), 4)]


# ---- one after the other -------------------------------------------------------------------------


def follow(shell, nets, row, deviation, moved):
    """Writes ruled faces in the parameters of their neighbours, where those are others.

    nets: face number -> Net over the face's box, replaced where a face follows; row(face, k, key,
    a, b): the curve of an arc on border k as nets and moved are now; deviation(face, net): the
    largest distance of a net from the face's surface; moved: gets (number, axis) -> function from
    the surface's parameter to the net's. Returns number -> names of the faces that a face follows.
    """
    return _Follower(shell, nets, row, deviation, moved).leaders


class _Follower:
    def __init__(self, shell, nets, row, deviation, moved):
        self.faces = {f.number: f for f in shell.faces if f.number in nets}
        self.edges = {e.number: e for e in shell.edges}
        self.nets, self.row, self.deviation = nets, row, deviation
        self.moved, self.leaders = moved, {}
        ruled = [n for n in sorted(nets) if ruled_axes(nets[n])]
        self.settled = set(nets) - set(ruled)
        self._run(collections.deque(sorted(self.settled)), collections.deque(ruled))

    def _run(self, queue, ruled):
        while queue or ruled:
            if not queue:  # nobody is left to follow: the next one leads
                queue.append(ruled.popleft())
                if queue[0] in self.settled:
                    queue.clear()
                    continue
                self.settled.add(queue[0])
            for number in self._neighbours(queue.popleft()):
                if number not in self.settled and self._follow(self.faces[number]):
                    self.settled.add(number)
                    queue.append(number)

    def _neighbours(self, number):
        """Ruled ones, that can follow."""
        return sorted({
            other.number for border in self.faces[number].borders for edge, _ in border
            for other, _ in edge.uses
            if other.number in self.nets and ruled_axes(self.nets[other.number])
        })

    # ---- one face ----

    def _follow(self, face):
        """Writes a ruled face in the parameters of its settled neighbours, where they are others
        than its own and it can be."""
        ruled, done = ruled_axes(self.nets[face.number]), False
        for axis in (0, 1):
            pieces = [self._pieces(face, k) for k in ALONG[axis]]
            if not any(pieces):
                continue
            rows = [_row_of_pieces(p) if p else None for p in pieces]
            ways = [with_profile] if 1 - axis in ruled else []
            ways += [with_lines] if axis in ruled else []
            for way in ways:
                net = way(self.nets[face.number], axis, rows)
                if net is not None and self.deviation(face, net) <= TOLERANCE:
                    self._take(face, axis, net, pieces)
                    done = True
                    break
        return done

    def _pieces(self, face, k):
        """The arcs of a border, those with another parameter as their settled neighbours have
        them; None where all agree."""
        out, led = [], False
        for low, high, arc in border_arcs(face, k):
            mine = self.row(face, k, *arc)
            piece = Piece((low, high), mine, (face, k), (low, high))
            for other, j in self.edges[arc.key[0]].uses:
                if other is face or other.number not in self.settled:
                    continue
                theirs = self.row(other, j, *arc)
                allowed = self.edges[arc.key[0]].tolerance
                if not same_parameter(mine, theirs, allowed):
                    span = _span(self.edges[arc.key[0]], other, j, arc)
                    piece, led = Piece((low, high), theirs, (other, j), span), True
            out.append(piece)
        return out if led else None

    def _take(self, face, axis, net, pieces):
        own = next(self.nets[face.number].border(k) for k, p in zip(ALONG[axis], pieces) if p)
        row = next(net.border(k) for k, p in zip(ALONG[axis], pieces) if p)
        known = [pair for p in pieces if p for pair in _stops(p)]
        self.moved[face.number, axis] = _Moved(own, row, known, face.blur(axis))
        self.nets[face.number] = net
        leaders = self.leaders.setdefault(face.number, [])
        leaders += [x.leader[0].name for p in pieces if p for x in p
                    if x.leader[0] is not face and x.leader[0].name not in leaders]


class _Moved:
    """From a face's own parameter to the one that it has taken over: known pairs, and elsewhere the
    place on the curve."""

    def __init__(self, own, row, known, blur):
        self.own, self.row, self.known, self.blur = own, row, known, blur

    def __call__(self, value):
        for old, new in self.known:
            if abs(old - value) <= self.blur:
                return new
        new = find_on(self.row, self.own.place(value))
        self.known.append((value, new))
        return new


def _span(edge, other, j, arc):
    """The arc's ends as parameters of another face's border j, a's first."""
    i = arc.key[1]
    ends = [(edge.nodes[m][1], other.parameter_on(j, edge, edge.nodes[m][0])) for m in (i, i + 1)]
    return tuple(t for _, t in (ends if ends[0][0] is arc.a else ends[::-1]))


def _breaks(pieces):
    """Where the pieces end in the new parameter: as before where the leader changes, in between as
    the leader has it."""
    out, start = [pieces[0].ends[0]], 0
    for i, piece in enumerate(pieces):
        if i + 1 < len(pieces) and pieces[i + 1].leader == piece.leader:
            continue
        group = pieces[start : i + 1]
        (low, high), (a, b) = (
            (getattr(group[0], name)[0], getattr(group[-1], name)[1]) for name in ("ends", "span")
        )
        out += [low + (high - low) * ((p.span[1] - a) / (b - a)) for p in group[:-1]] + [high]
        start = i + 1
    return out


def _row_of_pieces(pieces):
    return joined([p.row for p in pieces], _breaks(pieces))


def _stops(pieces):
    old = [pieces[0].ends[0]] + [p.ends[1] for p in pieces]
    return list(zip(old, _breaks(pieces)))
