# SPDX-License-Identifier: LGPL-2.1-or-later
"""The cells of a shell: the four-sided parts of its rigid faces, and its free faces whole.

A cell is known by its arcs once around; a rigid cell has its four corners, a free one gets them
from intake_corners.py.
"""

import collections

from .intake_shell import RIGID, arcs_of, near

Arc = collections.namedtuple("Arc", "key a b")
Arc.__doc__ = """A piece of a border: key (edge number, index) or ("cut", ...); nodes a to b."""


class Cell:
    """sides[k]: the arcs along border k in its parameter's direction (rigid), or loop: all arcs
    once around (free); sides of a free cell come with its corners."""

    def __init__(self, face, box=None, sides=None, loop=None):
        self.face, self.box, self.sides = face, box, sides
        if loop is None:
            back = [[Arc(x.key, x.b, x.a) for x in reversed(side)] for side in sides]
            loop = sides[0] + sides[1] + back[2] + back[3]
        self.loop = loop

    @property
    def corners(self):
        """(u, v) = 00, 10, 11, 01."""
        s = self.sides
        return (s[0][0].a, s[0][-1].b, s[2][-1].b, s[2][0].a)

    def nodes(self):
        return [arc.a for arc in self.loop]


def border_arcs(face, k):
    """(low, high, Arc) along an outer border, ascending."""
    out = []
    for edge, forward, _, _ in face.along(k):
        for i, a, b in edge.arcs(forward):
            t = [face.parameter_on(k, edge, edge.nodes[j][0]) for j in (i, i + 1)]
            out.append((min(t), max(t), Arc((edge.number, i), a, b)))
    return out


def _stop_near(face, k, value):
    return min(face.stops(k), key=lambda s: abs(s[0] - value))[1]


def _grid_nodes(face, shell, stops):
    """Nodes of the lines that cut a rigid face, at (i, j); those inside are made once."""
    nodes = {}
    n, m = len(stops[0]) - 1, len(stops[1]) - 1
    for i, u in enumerate(stops[0]):
        for j, v in enumerate(stops[1]):
            if j in (0, m):
                nodes[i, j] = _stop_near(face, 0 if j == 0 else 2, u)
            elif i in (0, n):
                nodes[i, j] = _stop_near(face, 3 if i == 0 else 1, v)
            else:
                if (u, v) not in face.inner:
                    face.inner[u, v] = shell.new_node(face.surface.value(u, v))
                nodes[i, j] = face.inner[u, v]
    return nodes


def rigid_cells(face, shell):
    """The rectangles between the lines that cut a rigid face."""
    stops = [
        [face.box[2 * axis]] + list(face.cuts[axis]) + [face.box[2 * axis + 1]] for axis in (0, 1)
    ]
    nodes = _grid_nodes(face, shell, stops)
    outer = [border_arcs(face, k) for k in range(4)]
    n, m = len(stops[0]) - 1, len(stops[1]) - 1

    def side(k, i, j):
        """Border k of the cell (i, j)."""
        axis = k % 2
        line = (j, i + 1, j + 1, i)[k]  # which line across it lies on
        at = (i, j)[axis]
        if line == 0 or line == (m, n)[axis]:
            low, high = stops[axis][at], stops[axis][at + 1]
            return _inside(face, axis, outer[k], low, high)
        ends = ((at, line), (at + 1, line)) if axis == 0 else ((line, at), (line, at + 1))
        key = ("cut", face.number, axis, line, at)
        return [Arc(key, nodes[ends[0]], nodes[ends[1]])]

    return [
        Cell(
            face,
            (stops[0][i], stops[0][i + 1], stops[1][j], stops[1][j + 1]),
            [side(k, i, j) for k in range(4)],
        )
        for j in range(m)
        for i in range(n)
    ]


def _inside(face, axis, arcs, low, high):
    """The arcs between two parameters, whose ends may differ from them by rounding."""
    return [
        arc
        for lo, hi, arc in arcs
        if (lo >= low or near(face, axis, lo, low)) and (hi <= high or near(face, axis, hi, high))
    ]


def cells_of(shell):
    """All cells, in the order of the faces."""
    out = []
    for face in shell.faces:
        if face.kind == RIGID:
            out += rigid_cells(face, shell)
        else:
            loop = [Arc((edge.number, i), a, b) for edge, i, _, a, b in arcs_of(face)]
            out.append(Cell(face, loop=loop))
    return out


def uses(cells):
    """Per node number: what every cell has there: (cell index, 1 corner, 2 straight, 0 free)."""
    out = collections.defaultdict(list)
    for c, cell in enumerate(cells):
        if cell.sides is None:
            for node in cell.nodes():
                out[node.number].append((c, 0))
            continue
        for side in cell.sides:
            for arc in side[1:]:
                out[arc.a.number].append((c, 2))
        for node in cell.corners:
            out[node.number].append((c, 1))
    return out
