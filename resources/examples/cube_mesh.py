# SPDX-License-Identifier: LGPL-2.1-or-later
"""T-spline surfaces on the six sides of a cube, in plain numpy: bicubic, with T-junctions.

A mesh lives in index space: axis a has the lines 0 .. n[a], line i at the value lines[a][i]
(repeated values: multiple knots); lines 0 and n[a] are where the cube ends. A side is 2 * axis +
end with parameters along its other two axes in increasing order, and is cut by the segments of
lines that are present on it. Segments of the twelve isolines always are. Knots run on across the
isolines, so the surface is smooth there but where lines are repeated.

    sharp isoline              smooth isoline           a line that ends: T-junction
    | | |    three lines,      |    |    |  one line    |    |    |
    | | |    one value         |    |    |              |    +----|
    | | |                      |    |    |              |    |    |

Each vertex carries a control point; its function is a product of two cubic B-splines whose knots
are what rays from the vertex meet first and second (a segment touched counts). At a star (a corner
of the cube where three smooth isolines meet) three faces meet: the surface has there the mean of
its three face points. The first intervals around a star must be equal, so that all else is what
the local knots say.
"""
import json
from fractions import Fraction

import numpy as np

from .splines import blossom_row

CORNERS = [(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)]


def side_axes(side):
    return [a for a in range(3) if a != side // 2]


class CubeMesh:
    """lines: three non-decreasing sequences of values. present(axis, i, point): is line i of the
    axis there? point: the middle of a segment, in values; asked on the inside of the sides only."""

    def __init__(self, lines, present=lambda axis, i, point: True):
        self.lines = [[float(v) for v in row] for row in lines]
        self.n = [len(row) - 1 for row in self.lines]
        self.segments = [self._segments(side, present) for side in range(6)]
        self._collect_vertices()
        self._trace_faces()
        self.functions = [self._pieces(v) for v in self.vertices]
        self.points = np.zeros((len(self.vertices), 3))

    # ---- the mesh --------------------------------------------------------------------------------

    def _segments(self, side, present):
        """[0][i, j]: along line i of the first axis, from line j to j + 1; [1][i, j] the other."""
        p, q = side_axes(side)
        fixed = self.lines[side // 2][-1 if side % 2 else 0]
        first = np.ones((self.n[p] + 1, self.n[q]), bool)
        second = np.ones((self.n[p], self.n[q] + 1), bool)
        for axis, along, out in ((p, q, first), (q, p, second.T)):
            middle = (np.array(self.lines[along][1:]) + self.lines[along][:-1]) / 2
            for i in range(1, self.n[axis]):
                for j in range(self.n[along]):
                    point = [0.0] * 3
                    point[side // 2], point[axis], point[along] = (
                        fixed, self.lines[axis][i], middle[j])
                    out[i, j] = present(axis, i, point)
        return first, second

    def sides_at(self, vertex):
        """The sides that hold an index point: one, two on an isoline, three at a corner."""
        return [2 * a + e for a in range(3) for e in (0, 1) if vertex[a] == e * self.n[a]]

    def on_side(self, side, vertex):
        p, q = side_axes(side)
        return vertex[p], vertex[q]

    def from_side(self, side, i, j):
        vertex = [side % 2 * self.n[side // 2]] * 3
        for axis, index in zip(side_axes(side), (i, j)):
            vertex[axis] = index
        return tuple(vertex)

    def _touching(self, side, direction, i, j):
        """Segments of lines of the direction that hold the point: their two places."""
        segments = self.segments[side][direction]
        if direction == 0:
            return [0 <= k < segments.shape[1] and segments[i, k] for k in (j - 1, j)]
        return [0 <= k < segments.shape[0] and segments[k, j] for k in (i - 1, i)]

    def _collect_vertices(self):
        found = set()
        for side in range(6):
            p, q = side_axes(side)
            for i in range(self.n[p] + 1):
                for j in range(self.n[q] + 1):
                    ends = [self._touching(side, d, i, j) for d in (0, 1)]
                    if any(ends[0]) and any(ends[1]):
                        found.add(self.from_side(side, i, j))
                        if 0 < i < self.n[p] and 0 < j < self.n[q] and sum(map(sum, ends)) < 3:
                            raise ValueError("a line ends in nothing at %s" % str((side, i, j)))
        self.vertices = sorted(found)
        self.number = {v: k for k, v in enumerate(self.vertices)}

    def _trace_faces(self):
        """faces: (side, i0, i1, j0, j1), the rectangles without segments inside."""
        self.faces = []
        for side in range(6):
            first, second = self.segments[side]
            taken = np.zeros((second.shape[0], first.shape[1]), bool)
            for i in range(taken.shape[0]):
                for j in range(taken.shape[1]):
                    if taken[i, j]:
                        continue
                    i1, j1 = i + 1, j + 1
                    while not first[i1, j]:
                        i1 += 1
                    while not second[i, j1]:
                        j1 += 1
                    whole = (not taken[i:i1, j:j1].any() and first[i, j:j1].all()
                             and first[i1, j:j1].all() and second[i:i1, j].all()
                             and second[i:i1, j1].all() and not first[i + 1:i1, j:j1].any()
                             and not second[i:i1, j + 1:j1].any())
                    if not whole:
                        raise ValueError("no rectangle at %s" % str((side, i, j)))
                    taken[i:i1, j:j1] = True
                    self.faces.append((side, i, i1, j, j1))

    def face_box(self, face):
        side, i0, i1, j0, j1 = face
        p, q = side_axes(side)
        return (self.lines[p][i0], self.lines[p][i1], self.lines[q][j0], self.lines[q][j1])

    def loop(self, face):
        """The vertices round a face, seen from outside counter-clockwise, and which are corners."""
        side, i0, i1, j0, j1 = face
        around = ([(i, j0) for i in range(i0, i1)] + [(i1, j) for j in range(j0, j1)]
                  + [(i, j1) for i in range(i1, i0, -1)] + [(i0, j) for j in range(j1, j0, -1)])
        around = [x for x in around if self.from_side(side, *x) in self.number]
        if (side % 2 == 0) != (side // 2 == 1):
            around = around[:1] + around[:0:-1]
        corners = [x[0] in (i0, i1) and x[1] in (j0, j1) for x in around]
        return [self.number[self.from_side(side, *x)] for x in around], corners

    def is_star(self, vertex):
        """A corner of the cube whose three first faces are no slits."""
        if len(self.sides_at(vertex)) < 3:
            return False
        return all(self.first_interval(vertex, a) > 0 for a in range(3))

    def first_interval(self, corner, axis):
        """From a corner to the first line of the axis that both sides have there."""
        step = 1 if corner[axis] == 0 else -1
        vertex = list(corner)
        while True:
            vertex[axis] += step
            if tuple(vertex) in self.number:
                return abs(self.lines[axis][vertex[axis]] - self.lines[axis][corner[axis]])

    # ---- functions -------------------------------------------------------------------------------

    def _ray(self, side, vertex, axis, sign):
        """How far the two values are that a ray along the axis meets."""
        position, met, gone = list(vertex), [], 0.0
        while len(met) < 2:
            if position[axis] == (self.n[axis] if sign > 0 else 0):
                turned = side // 2
                if met and len(self.sides_at(position)) == 3:  # the isoline ends: as far again
                    met.append(2 * met[-1])
                    break
                side, axis, sign = (2 * axis + (sign > 0), turned,
                                    -1 if position[turned] else 1)
            before = self.lines[axis][position[axis]]
            position[axis] += sign
            gone += abs(self.lines[axis][position[axis]] - before)
            if self._meets(side, position, axis):
                met.append(gone)
        return met

    def _meets(self, side, position, axis):
        if len(self.sides_at(position)) > 1:
            ends_here = position[axis] in (0, self.n[axis])
            return ends_here or tuple(position) in self.number
        p, q = side_axes(side)
        return any(self._touching(side, 0 if axis == p else 1, position[p], position[q]))

    def _pieces(self, vertex):
        """(side, knots, knots): the function as products on sides, in the sides' own values.

        Sides beyond an isoline get the knots folded over it; where the vertex lies on an isoline,
        each of its sides knows its own knots."""
        pieces, own = [], self.sides_at(vertex)
        for side in own:
            knots = []
            for axis in side_axes(side):
                here = self.lines[axis][vertex[axis]]
                low, high = (self._ray(side, vertex, axis, s) for s in (-1, 1))
                knots.append((here - low[1], here - low[0], here, here + high[0], here + high[1]))
            pieces.append((side, knots[0], knots[1]))
            for beyond, folded in self._folded(side, knots):
                if beyond not in own:
                    pieces.append((beyond, folded[0], folded[1]))
        return pieces

    def _folded(self, side, knots):
        """Pieces over the four neighbours of a side that the support reaches."""
        axes, normal = side_axes(side), side // 2
        for k, axis in enumerate(axes):
            for end in (0, 1):
                border = self.lines[axis][-1 if end else 0]
                away = [(t - border) if end else (border - t) for t in knots[k]]
                if max(away) <= 0:
                    continue
                start = self.lines[normal][-1 if side % 2 else 0]
                turned = sorted(start - x if side % 2 else start + x for x in away)
                by_axis = {normal: tuple(turned), axes[1 - k]: knots[1 - k]}
                beyond = 2 * axis + end
                yield beyond, [by_axis[a] for a in side_axes(beyond)]

    def anchor(self, k):
        """Where function k is centred (Greville): a point of the cube's surface, in values."""
        side, first, second = self.functions[k][0]
        place = [sum(first[1:4]) / 3, sum(second[1:4]) / 3]
        return self.fold(side, place)

    def fold(self, side, place):
        """A point of a side's plane, perhaps beyond one isoline, as a point of the surface."""
        point = [0.0] * 3
        normal = side // 2
        point[normal] = self.lines[normal][-1 if side % 2 else 0]
        for axis, value in zip(side_axes(side), place):
            low, high = self.lines[axis][0], self.lines[axis][-1]
            point[axis] = min(max(value, low), high)
            point[normal] += (-1 if side % 2 else 1) * abs(value - point[axis])
        return point

    def unit(self, point):
        """In the unit cube instead of in values."""
        return [(x - row[0]) / (row[-1] - row[0]) for x, row in zip(point, self.lines)]

    # ---- Bezier elements -------------------------------------------------------------------------

    def extraction(self):
        """Per side: [(box, {function: 4 x 4 coefficients})], first parameter first index."""
        by_side = [[] for _ in range(6)]
        for k, pieces in enumerate(self.functions):
            for side, first, second in pieces:
                by_side[side].append((k, first, second))
        sides, boxes = [[] for _ in range(6)], [self.face_box(f) for f in self.faces]
        for face, box in zip(self.faces, boxes):
            if box[0] < box[1] and box[2] < box[3]:
                here = [p for p in by_side[face[0]]
                        if p[1][0] < box[1] and p[1][4] > box[0]
                        and p[2][0] < box[3] and p[2][4] > box[2]]
                sides[face[0]] += self._elements(box, here)
        self._set_stars(sides)
        return sides

    @staticmethod
    def _elements(box, pieces):
        cuts = []
        for d in (0, 1):
            low, high = box[2 * d], box[2 * d + 1]
            inner = {t for p in pieces for t in p[1 + d] if low < t < high}
            cuts.append(sorted(inner | {low, high}))
        out = []
        for a, b in zip(cuts[0], cuts[0][1:]):
            for c, d in zip(cuts[1], cuts[1][1:]):
                functions = {}
                for k, first, second in pieces:
                    net = np.outer(bernstein(first, a, b), bernstein(second, c, d))
                    if net.any():
                        functions[k] = functions.get(k, 0) + net
                out.append(((a, b, c, d), functions))
        return out

    def _set_stars(self, sides):
        for corner in CORNERS:
            vertex = tuple(c * n for c, n in zip(corner, self.n))
            if not self.is_star(vertex):
                continue
            fans = []
            for side in self.sides_at(vertex):
                p, q = side_axes(side)
                at = [0 if corner[a] == 0 else 1 for a in (p, q)]
                ends = [self.lines[a][-1 if corner[a] else 0] for a in (p, q)]
                element = next(e for e in sides[side]
                               if e[0][at[0]] == ends[0] and e[0][2 + at[1]] == ends[1])
                fans.append((element[1], tuple(3 * x for x in at), tuple(1 + x for x in at)))
            users = sorted({k for functions, _, _ in fans for k in functions})
            for k in users:
                mean = sum(f[k][face] if k in f else 0.0 for f, _, face in fans) / 3
                for functions, place, _ in fans:
                    if mean or k in functions:
                        functions.setdefault(k, np.zeros((4, 4)))[place] = mean

    # ---- geometry --------------------------------------------------------------------------------

    def collocation(self, points):
        """Values of all functions (columns) at (side, x, y) (rows): by local knots, no stars."""
        matrix = np.zeros((len(points), len(self.vertices)))
        rows = [[r for r, p in enumerate(points) if p[0] == side] for side in range(6)]
        for k, pieces in enumerate(self.functions):
            for side, first, second in pieces:
                for r in rows[side]:
                    _, x, y = points[r]
                    if first[0] <= x <= first[4] and second[0] <= y <= second[4]:
                        matrix[r, k] += cubic(first, x) * cubic(second, y)
        return matrix

    def describe_bezier(self):
        """The surface as an entry "bezier" of a .tsb file."""
        sides = []
        for side, elements in enumerate(self.extraction()):
            p, q = side_axes(side)
            entry = []
            for box, functions in elements:
                unit = [self._unit(a, x) for a, x in zip((p, p, q, q), box)]
                entry.append({"box": unit, "functions": sorted(functions), "coefficients":
                              [functions[k].T.reshape(-1).tolist() for k in sorted(functions)]})
            sides.append({"degree": [3, 3], "elements": entry})
        return {"points": self._rows(), "sides": sides}

    def describe_patches(self):
        """The surface as T-spline patches, for meshes without stars: points and patches."""
        patches = []
        for side in range(6):
            p, q = side_axes(side)
            domain = [self.lines[a][k] for a in (p, q) for k in (0, -1)]
            functions = [{"point": k, "knots": [list(first), list(second)]}
                         for k, pieces in enumerate(self.functions)
                         for at, first, second in pieces
                         if at == side and first[0] < domain[1] and first[4] > domain[0]
                         and second[0] < domain[3] and second[4] > domain[2]]
            patches.append({"name": "Face%d" % (side + 1), "tspline": {
                "degree": [3, 3], "domain": domain, "functions": functions}})
        return {"points": self._rows(), "patches": patches}

    def _rows(self):
        return np.concatenate([self.points, np.ones((len(self.points), 1))], axis=1).tolist()

    def _unit(self, axis, value):
        low, high = self.lines[axis][0], self.lines[axis][-1]
        return 1.0 if value == high else (value - low) / (high - low)


# ---- one cubic B-spline -------------------------------------------------------------------------


def cubic(knots, x):
    """Its value, continuous from the left at its end."""
    value = [1.0 if (a <= x < b) or (x == b == knots[4] and a < b) else 0.0
             for a, b in zip(knots, knots[1:])]
    for d in (1, 2, 3):
        value = [((x - knots[i]) / (knots[i + d] - knots[i]) * value[i]
                  if knots[i + d] > knots[i] else 0.0)
                 + ((knots[i + d + 1] - x) / (knots[i + d + 1] - knots[i + 1]) * value[i + 1]
                    if knots[i + d + 1] > knots[i + 1] else 0.0)
                 for i in range(4 - d)]
    return value[0]


_known = {}


def bernstein(knots, a, b):
    """Its four Bernstein coefficients on [a, b], on which it must be one polynomial."""
    if knots[0] >= b or knots[4] <= a:
        return np.zeros(4)
    key = tuple(t - knots[0] for t in knots[1:]) + (a - knots[0], b - knots[0])
    if key not in _known:
        t = [Fraction(x) for x in (0.0,) + key]
        around = [t[0] - k for k in (3, 2, 1)] + t[:5] + [t[4] + k for k in (1, 2, 3)]
        span = max(i for i in range(len(around) - 1) if around[i] <= t[5] < around[i + 1])
        _known[key] = np.array([float(blossom_row(around, 3, span, [t[5]] * (3 - j) + [t[6]] * j)
                                      .get(3, 0)) for j in range(4)])
    return _known[key]


# ---- files --------------------------------------------------------------------------------------


def write_model(mesh, path, carrier):
    """carrier: "tsm"; "patches": .tsb of T-spline patches; "elements": .tsb of Bezier elements."""
    if carrier == "tsm":
        write_tsm(mesh, path)
        return
    content = ({"bezier": mesh.describe_bezier()} if carrier == "elements"
               else mesh.describe_patches())
    with open(path, "w", encoding="utf-8") as out:
        json.dump(dict({"format": "tsolid boundary", "version": 1}, **content), out)
        out.write("\n")


def write_tsm(mesh, path):
    """Half-edges, knot intervals, control points; multiple knots are edges of interval 0."""
    links, edges, of_pair = [], [], {}
    loops = [mesh.loop(face) for face in mesh.faces]
    start = []
    for f, (loop, corners) in enumerate(loops):
        first = corners.index(True)
        loop, corners = loop[first:] + loop[:first], corners[first:] + corners[:first]
        start.append(len(links))
        n = len(loop)
        for k in range(n):
            of_pair[loop[k], loop[(k + 1) % n]] = len(links)
            links.append([start[f] + (k - 1) % n, start[f] + (k + 1) % n, -1, loop[k], f, -1,
                          0 if corners[k] else 1])
    for (a, b), link in of_pair.items():
        links[link][2] = of_pair[b, a]
        if links[link][5] < 0:
            links[link][5] = links[of_pair[b, a]][5] = len(edges)
            ends = [mesh.vertices[v] for v in (a, b)]
            edges.append((link, sum(abs(row[i] - row[j])
                                    for row, i, j in zip(mesh.lines, *ends))))
    leaving = {}
    for k, link in enumerate(links):
        leaving.setdefault(link[3], k)
    lines = ["#TS0200", "", "degree 3", "cap-type 1", "star-smoothness 0",
             "units 0.001 millimeters", "force-bezier-end-conditions 1"]
    lines += ["f %d 0" % k for k in start]
    lines += ["e %d %.17g" % e for e in edges]
    lines += ["v %d NORTH" % leaving[v] for v in range(len(mesh.vertices))]
    lines += ["l " + " ".join(map(str, link)) for link in links]
    lines += ["0g %.17g %.17g %.17g 1" % tuple(p) for p in mesh.points]
    lines += ["", "tol 1e-05", "ver 904"]
    with open(path, "w", encoding="utf-8") as out:
        out.write("\n".join(lines) + "\n")
