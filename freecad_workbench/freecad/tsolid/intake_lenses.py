# SPDX-License-Identifier: LGPL-2.1-or-later
"""Lenses and hemispheres: two free faces that share one circle and nothing else.

The circle has no corner: four are put on it a quarter turn apart, on as many of its vertices as
fit. It may be one edge or many, circles or splines; both faces take its quarters from the circle
itself, so what it is made of changes nothing. One of the faces, a cap, is laid out as five cells: a
square around the apex and a ring of four.
"""

import math

from .intake_caps import Sphere
from .intake_cells import Arc, Cell
from .intake_exact import QUARTER, trig_row
from .intake_shell import CAP, RIGID

N_LOOK = 64  # intervals of an edge in which a place on it is looked for


class Rim:
    """The circle with its four corners; both faces have it as their rim."""

    def __init__(self, shell, cap, other):
        self.centre, self.axis, self.radius = cap.ring.Center, cap.ring.Axis, cap.ring.Radius
        self.edges = [edge for edge, _ in cap.loop]
        self.tolerance = max(edge.tolerance for edge in self.edges)
        start = self._best_start(_seam_nodes(shell, (cap, other)))
        self.corners = [self._corner(shell, place) for place in self._quarters(start)]
        self._angles = {n.number: k * QUARTER for k, n in enumerate(self.corners)}
        self._four = [[*place, 1.0] for place in self._quarters(start)]

    def _quarters(self, start):
        """Four places on the circle a quarter turn apart, the first next to a point."""
        x = start - self.centre
        x = (x - self.axis * x.dot(self.axis)).normalize()
        y = self.axis.cross(x)
        return [self.centre + d * self.radius for d in (x, y, x * -1.0, y * -1.0)]

    def _nodes(self):
        return {node.number: node for edge in self.edges for _, node in edge.nodes}.values()

    def _at(self, place):
        """The vertex at a place of the circle; None where there is none."""
        best = min(self._nodes(), key=lambda node: (node.point - place).Length)
        return best if (best.point - place).Length <= self.tolerance else None

    def _best_start(self, seam):
        """The point of the vertex from which most quarters end in vertices. Of equals the one where
        a sphere's seam ends: a file may have cut the circle elsewhere. Then by coordinates."""

        def cost(node):
            fits = sum(self._at(place) is not None for place in self._quarters(node.point))
            return -fits, node.number not in seam, tuple(round(x, 9) for x in node.point)

        return min(self._nodes(), key=cost).point

    def _corner(self, shell, place):
        node = self._at(place)
        if node is None:
            node = shell.add_node(*self._on_edge(place))
        return node

    def _on_edge(self, place):
        """Edge and parameter where the circle's radius through a place crosses the edge."""
        out = place - self.centre
        ahead = self.axis.cross(out)

        def before(edge, t):
            return (edge.point(t) - self.centre).dot(ahead) < 0.0

        found = []
        for edge in self.edges:
            width = edge.last - edge.first
            ts = [edge.first + width * i / N_LOOK for i in range(N_LOOK)] + [edge.last]
            for a, b in zip(ts, ts[1:]):
                if before(edge, a) != before(edge, b):
                    t = _crossing(lambda t, e=edge: before(e, t), a, b)
                    found.append(((edge.point(t) - place).Length, edge, t))
        return min(found, key=lambda x: x[0])[1:]

    def row(self, a, b):
        """The shorter arc of the circle between two of the corners, over [0, 1]."""
        start, turn = self._angles[a.number], self._angles[b.number] - self._angles[a.number]
        end = start + math.remainder(turn, 4.0 * QUARTER)
        row = trig_row(self._four, [min(start, end), max(start, end)]).over(0.0, 1.0)
        return row if start < end else row.reversed()

    def sides(self, loop):
        """A loop's arcs from corner to corner, four lists."""
        starts = [i for i, arc in enumerate(loop) if arc.a.number in self._angles]
        loop = loop[starts[0]:] + loop[: starts[0]]
        ends = [i - starts[0] for i in starts] + [len(loop)]
        return [loop[i:j] for i, j in zip(ends, ends[1:])]


def _crossing(before, a, b):
    """Where a truth changes between two parameters."""
    start = before(a)
    while True:
        t = 0.5 * (a + b)
        if t in (a, b):
            return t
        a, b = (t, b) if before(t) == start else (a, t)


def _seam_nodes(shell, faces):
    """Numbers of the nodes where a face's seam ends."""
    seams = [shell.edge(e) for face in faces for e in face.distinct_uses()
             if not e.Degenerated and face.is_seam(e)]
    return {node.number for seam in seams for _, node in seam.nodes}


def partner(face):
    """The other free face, where two free faces share one closed line and nothing else."""
    others = {other.number: other for edge, _ in face.loop for other, _ in edge.uses
              if other is not face}
    if face.kind == RIGID or len(others) != 1:
        return None
    (other,) = others.values()
    alone = other.kind != RIGID and len(other.loop) == len(face.loop)
    return other if alone and CAP in (face.kind, other.kind) else None


def give_rims(shell):
    """Finds the lenses, and puts the corners on their circles."""
    for face in shell.faces:
        other = partner(face)
        if other is not None and face.rim is None:
            cap, beside = (face, other) if face.kind == CAP else (other, face)
            face.rim = other.rim = Rim(shell, cap, beside)


# ---- cells -------------------------------------------------------------------------------------


def split(shell, cells):
    """The cells, with five instead of the first cap of each lens."""
    out, done = [], []
    for cell in cells:
        rim = cell.face.rim
        if rim is None or cell.face.kind != CAP or rim in done:
            out.append(cell)
            continue
        done.append(rim)
        out += _five_cells(shell, cell)
    return out


def _five_cells(shell, cell):
    """Ring and square with their arcs; nets come later."""
    face, number = cell.face, cell.face.number
    sides, inner, sphere = face.rim.sides(cell.loop), [], Sphere(face)
    for side in sides:
        place = face.rim.centre + (side[0].a.point - face.rim.centre) * 0.5
        inner.append(shell.new_node(sphere.point(place)))
    cells = []
    for i, side in enumerate(sides):
        j = (i + 1) % 4
        low = Arc(("cap", number, "square", i), inner[i], inner[j])
        high = Arc(("cap", number, "radius", j), inner[j], side[-1].b)
        left = Arc(("cap", number, "radius", i), inner[i], side[0].a)
        cells.append(Cell(face, sides=[[low], [high], side, [left]]))
    square = [Arc(("cap", number, "square", i), inner[i], inner[(i + 1) % 4]) for i in range(4)]
    back = [Arc(a.key, a.b, a.a) for a in square]
    cells.append(Cell(face, sides=[[square[0]], [square[1]], [back[2]], [back[3]]]))
    return cells
