# SPDX-License-Identifier: LGPL-2.1-or-later
"""Nets of all cells: rigid ones from their surfaces, free ones between their borders.

A free face takes each piece of its border from the rigid cell on the other side, control points,
weights and all, so that both agree as curves over their parameter; where two free faces meet, both
take the edge's own curve.
"""

from . import nurbs
from .intake_cuts import spread_breaks
from .intake_exact import NoForm, converted_net, curve_row, surface_net
from .intake_follow import follow
from .intake_refuse import refuse
from .intake_shell import CAP, RIGID, near

MAX_DEGREE = 25


class Filler:
    """Nets and border rows of the cells, made once. deviation: see follow()."""

    def __init__(self, shell, cells, deviation):
        self.shell, self.cells = shell, cells
        self.edges = {e.number: e for e in shell.edges}
        self.breaks = spread_breaks(shell)
        self.faces = {}  # nets of whole rigid faces
        self.moved = {}  # (number, axis) -> from the surface's parameter to the net's
        self.rigid = {}  # arc key -> (cell, border)
        for cell in cells:
            if cell.face.kind == RIGID:
                self.faces[cell.face.number] = None
                for k, side in enumerate(cell.sides):
                    for arc in side:
                        self.rigid.setdefault(arc.key, []).append((cell, k))
        for number in self.faces:
            face = shell.faces[number - 1]
            self.faces[number] = _net_of(face, self.breaks[number])
        self.leaders = follow(shell, self.faces, self._row_of_rigid, deviation, self.moved)
        self.factors = _factors(self)

    # ---- rows ----

    def plain_row(self, key, a, b):
        """The arc's homogeneous curve from node a to node b, over [0, 1], no cap's factor in it."""
        for cell, k in self.rigid.get(key, ()):
            return self._row_of_rigid(cell.face, k, key, a, b)
        edge = self.edges[key[0]]
        (t0, first), (t1, last) = edge.nodes[key[1]], edge.nodes[key[1] + 1]
        row = curve_row(edge.curve, t0, t1).over(0.0, 1.0)
        return row if first is a and (last is b) else row.reversed()

    def _row_of_rigid(self, face, k, key, a, b):
        return self._row_between(face, k, *self._range(face, k, key, a, b))

    def _range(self, face, k, key, a, b):
        """The parameters on a rigid face's border where the arc begins and ends."""
        edge = self.edges[key[0]]
        ends = [(self._snapped(face, k % 2, face.parameter_on(k, edge, t)), node)
                for t, node in edge.nodes[key[1] : key[1] + 2]]
        ends.sort(key=lambda end: end[0])
        if a is not b and ends[0][1] is not a:
            ends.reverse()
        return ends[0][0], ends[1][0]

    def _row_between(self, face, k, start, end):
        row = self.faces[face.number].border(k).segment(*sorted((start, end))).over(0.0, 1.0)
        return row if start < end else row.reversed()

    def _snapped(self, face, axis, t):
        """The very number of an end or a break that t is but for rounding, as a parameter of the
        face's net."""
        ends = (face.box[:2], face.box[2:])[axis]
        for value in ends + tuple(sorted(self.breaks[face.number][axis])):
            if near(face, axis, value, t):
                t = value
                break
        moved = self.moved.get((face.number, axis))
        return moved(t) if moved else t

    def row(self, key, a, b):
        row = self.plain_row(key, a, b)
        factor = self.factors.get(key)
        if factor is None:
            return row
        start, weights = factor
        return row.times(weights if start is a else weights.reversed())

    # ---- nets ----

    def rigid_net(self, cell):
        face = cell.face
        box = [self._snapped(face, i // 2, x) for i, x in enumerate(cell.box)]
        net = self.faces[face.number].segment(box)
        for k in (0, 1):
            factor = self.factors.get(cell.sides[k if k else 0][0].key)
            if len(cell.sides[k]) == 1 and factor is not None:
                start, weights = factor
                weights = weights if start is cell.sides[k][0].a else weights.reversed()
                knots = net.knots[k]
                net = net.times(k, weights.over(knots[0], knots[-1]))
        return net

    def free_sides(self, cell, positions):
        """A free cell's four sides, as lists of arcs in the direction of u or v.

        The first corner is the one with the least coordinates, wherever the loop begins.
        """
        n, loop = len(cell.loop), cell.loop
        places = [tuple(round(x, 9) for x in loop[i].a.point) for i in positions]
        k = places.index(min(places))
        positions = positions[k:] + positions[:k]
        sides = []
        for a, b in zip(positions, positions[1:] + positions[:1]):
            sides.append([loop[i % n] for i in range(a, b if b > a else b + n)])
        turned = [[type(x)(x.key, x.b, x.a) for x in reversed(s)] for s in sides[2:]]
        return sides[:2] + turned

    def _side_rows(self, side, take):
        """A side's curves: one for all arcs that follow each other on one border of a rigid face,
        in that face's own parameter, whatever edges the border is made of."""
        out, runs = [], []
        for arc in side:
            run = self._run(arc)
            if run and runs and runs[-1] and run[:2] == runs[-1][:2] and run[2] == runs[-1][3]:
                runs[-1] = runs[-1][:3] + run[3:]
                out[-1] = self._row_between(*runs[-1])
                continue
            runs.append(run)
            out.append(take(*arc))
        return out

    def _run(self, arc):
        """(face, border, parameters of begin and end) of an arc of a rigid face; None where there
        is none, or where its row is multiplied by a cap's factor."""
        for cell, k in self.rigid.get(arc.key, ()):
            if arc.key not in self.factors:
                return (cell.face, k) + self._range(cell.face, k, *arc)
        return None

    def free_rows(self, cell, plain=False):
        """The four borders as curves over [0, 1]: v low, u high, v high, u low."""
        if cell.face.rim is not None:
            rows = [[_rim_row(cell.face.rim, side, plain)] for side in cell.sides]
        else:
            take = self.plain_row if plain else self.row
            rows = [self._side_rows(side, take) for side in cell.sides]
        out = [None] * 4
        for k in (0, 1):
            spans = [_relative([_length(r) for r in rows[i]]) for i in (k, k + 2)]
            if len(spans[0]) == len(spans[1]):
                both = [0.5 * (x + y) for x, y in zip(*spans)]
                spans = [both, both]
            out[k], out[k + 2] = (nurbs.joined(rows[i], s) for i, s in zip((k, k + 2), spans))
        return out


def _net_of(face, breaks):
    """A rigid face's net over its box; OCC's form where we have no formula, to be measured."""
    try:
        try:
            net = surface_net(face.surface, face.box, breaks)
        except NoForm:
            net = converted_net(face.face, face.box)
    except NoForm as reason:
        refuse(face.name, "%s cannot be re-written as a B-spline (%s)" % (face.type, reason))
    if max(net.degree) > MAX_DEGREE:
        refuse(face.name, "degree above %d" % MAX_DEGREE)
    return net


def _rim_row(rim, side, plain):
    row = rim.row(side[0].a, side[-1].b)
    return row if plain else row.times(row.weights())


def _length(row, n=16):
    places = [row.place(row.first + (row.last - row.first) * i / n) for i in range(n + 1)]
    return sum(
        sum((x - y) ** 2 for x, y in zip(p, q)) ** 0.5 for p, q in zip(places, places[1:])
    )


def _relative(lengths):
    total, out = sum(lengths), [0.0]
    for x in lengths:
        out.append(out[-1] + x / total)
    out[-1] = 1.0
    return out


# ---- factors of caps -------------------------------------------------------------------------


def _factors(filler):
    """Arc key -> (node, weights from there): what a cap multiplies its neighbours' rows by, handed
    on across them to the next. A rim's two faces know it themselves."""
    found, left = {}, []
    for cell in filler.cells:
        if cell.face.kind != CAP or cell.face.rim is not None:
            continue
        for key, a, b in cell.loop:
            if isinstance(key[0], int) and key not in found:
                weights = filler.plain_row(key, a, b).weights()
                values = [p[0] for p in weights.points]
                if max(values) - min(values) > 1e-14 * max(values):
                    left.append((key, a, weights))
    while left:
        key, node, weights = left.pop()
        if key in found:
            continue
        found[key] = (node, weights)
        for cell, k in filler.rigid.get(key, ()):
            here, there = cell.sides[k], cell.sides[(k + 2) % 4]
            if len(here) == 1 and len(there) == 1:
                start = there[0].a if here[0].a is node else there[0].b
                left.append((there[0].key, start, weights))
    return found
