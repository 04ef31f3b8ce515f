# SPDX-License-Identifier: LGPL-2.1-or-later
"""Homogeneous B-spline curves and surfaces as plain numbers; no FreeCAD.

A Row is a clamped B-spline over points of any dimension: [w x, w y, w z, w] for a curve. A Net is
the tensor product; along each of its directions it is a Row over long points (all coordinates of a
line of control points), so that whatever is exact for a Row is so for a Net.
"""

import bisect

from .binding import Patch

NEAR = 1e-12  # of the parameter's range: closer knots are one


def _mix(a, p, b, q):
    return [a * x + b * y for x, y in zip(p, q)]


class Row:
    """A clamped B-spline curve: degree, knots with their multiplicities, points."""

    def __init__(self, degree, knots, points):
        self.degree = degree
        self.knots = [float(k) for k in knots]
        self.points = [list(p) for p in points]
        if len(self.knots) != len(self.points) + degree + 1:
            raise ValueError("numbers of knots and points do not fit")

    @classmethod
    def bezier(cls, points, first=0.0, last=1.0):
        p = len(points) - 1
        return cls(p, [first] * (p + 1) + [last] * (p + 1), points)

    @classmethod
    def of_beziers(cls, breaks, pieces):
        """Bezier pieces of one degree that meet in points, with C^0 knots between them."""
        p = len(pieces[0]) - 1
        points = [pieces[0][0]]
        for piece in pieces:
            points += piece[1:]
        inner = [b for b in breaks[1:-1] for _ in range(p)]
        return cls(p, [breaks[0]] * (p + 1) + inner + [breaks[-1]] * (p + 1), points)

    @property
    def first(self):
        return self.knots[0]

    @property
    def last(self):
        return self.knots[-1]

    def breaks(self):
        return sorted(set(self.knots))

    def reversed(self):
        ends = self.first + self.last
        knots = [ends - k for k in reversed(self.knots)]
        p = self.degree
        knots[: p + 1], knots[-p - 1 :] = [self.first] * (p + 1), [self.last] * (p + 1)
        return Row(p, knots, self.points[::-1])

    def over(self, first, last):
        """The same curve over another range."""
        p, width = self.degree, self.last - self.first
        knots = [first + (last - first) * ((k - self.first) / width) for k in self.knots]
        knots[: p + 1], knots[-p - 1 :] = [first] * (p + 1), [last] * (p + 1)
        return Row(p, knots, self.points)

    def snapped(self, t):
        """The knot that t is but for rounding, else t."""
        near = min(self.knots, key=lambda k: abs(k - t))
        return near if abs(near - t) <= NEAR * (self.last - self.first) else t

    def _insert(self, t):
        """t once more among the inner knots (Boehm)."""
        p, knots = self.degree, self.knots
        k = max(i for i in range(p, len(self.points)) if knots[i] <= t)
        points = self.points[: k - p + 1]
        for i in range(k - p + 1, k + 1):
            if knots[i + p] == knots[i]:
                points.append(self.points[i - 1])
                continue
            a = (t - knots[i]) / (knots[i + p] - knots[i])
            points.append(_mix(a, self.points[i], 1.0 - a, self.points[i - 1]))
        points += self.points[k:]
        return Row(p, knots[: k + 1] + [t] + knots[k + 1 :], points)

    def with_knot(self, t, times):
        """At least `times` knots at t."""
        row, t = self, self.snapped(t)
        if not self.first < t < self.last:
            return row
        while row.knots.count(t) < times:
            row = row._insert(t)
        return row

    def segment(self, a, b):
        """The part between two parameters."""
        a, b, p = self.snapped(a), self.snapped(b), self.degree
        row = self.with_knot(a, p).with_knot(b, p)
        start = 0 if a <= self.first else row.knots.index(a) - 1
        end = len(row.points) if b >= self.last else row.knots.index(b)
        a, b = max(a, self.first), min(b, self.last)
        inner = [k for k in row.knots if a < k < b]
        return Row(p, [a] * (p + 1) + inner + [b] * (p + 1), row.points[start:end])

    def beziers(self):
        """The Bezier points of every span between breaks()."""
        row, p = self, self.degree
        for t in self.breaks()[1:-1]:
            row = row.with_knot(t, p)
        return [row.points[i : i + p + 1] for i in range(0, len(row.points) - 1, p)]

    def raised(self, degree):
        """The same curve with a higher degree (C^0 knots)."""
        if degree == self.degree:
            return self
        pieces = self.beziers()
        for p in range(self.degree, degree):
            pieces = [_elevated(piece, p) for piece in pieces]
        return Row.of_beziers(self.breaks(), pieces)

    def value(self, t):
        """By de Boor's algorithm."""
        p, knots = self.degree, self.knots
        k = min(max(bisect.bisect_right(knots, t) - 1, p), len(self.points) - 1)
        points = self.points[k - p : k + 1]
        for r in range(1, p + 1):
            for j in range(p, r - 1, -1):
                low, high = knots[k - p + j], knots[k + 1 + j - r]
                a = (t - low) / (high - low)
                points[j] = _mix(a, points[j], 1.0 - a, points[j - 1])
        return list(points[p])

    def place(self, t):
        """The point in space of a homogeneous curve."""
        *x, w = self.value(t)
        return [c / w for c in x]

    def weights(self):
        """The last coordinate alone, as a Row."""
        return Row(self.degree, self.knots, [[p[-1]] for p in self.points])

    def times(self, factor):
        """This curve times a curve of numbers over the same range."""
        row = self
        for t in factor.breaks():
            row = row.with_knot(t, 1)
        for t in row.breaks():
            factor = factor.with_knot(t, 1)
        pieces = [_product(a, b) for a, b in zip(row.beziers(), factor.beziers())]
        return Row.of_beziers(row.breaks(), pieces)

    def moved(self, move):
        return Row(self.degree, self.knots, [move(p) for p in self.points])


def _elevated(piece, p):
    out = [piece[0]]
    for i in range(1, p + 1):
        a = i / (p + 1.0)
        out.append(_mix(a, piece[i - 1], 1.0 - a, piece[i]))
    return out + [piece[-1]]


def binomial(n, k):
    out = 1
    for i in range(k):
        out = out * (n - i) // (i + 1)
    return out


def _product(a, b):
    """Bezier points of a curve times a number's curve."""
    p, q = len(a) - 1, len(b) - 1
    out = [[0.0] * len(a[0]) for _ in range(p + q + 1)]
    for i, x in enumerate(a):
        for j, (y,) in enumerate(b):
            c = binomial(p, i) * binomial(q, j) / binomial(p + q, i + j) * y
            out[i + j] = [s + c * t for s, t in zip(out[i + j], x)]
    return out


def joined(rows, breaks):
    """Curves one behind the other, each over its part of breaks; one degree, C^0 between them."""
    p = max(row.degree for row in rows)
    knots, points = [breaks[0]] * (p + 1), []
    for row, a, b in zip(rows, breaks, breaks[1:]):
        row = row.raised(p).over(a, b)
        scale = points[-1][-1] / row.points[0][-1] if points else 1.0  # one curve, one factor
        row = row.moved(lambda x, s=scale: [s * c for c in x])
        points += row.points[1 if points else 0 :]
        knots += row.knots[p + 1 : -p - 1] + [b] * p
    return Row(p, knots + [breaks[-1]], points)


class Net:
    """A tensor product B-spline surface: points[i][j] belongs to the i-th function in u."""

    def __init__(self, degree, knots, points):
        self.degree = tuple(degree)
        self.knots = [list(map(float, k)) for k in knots]
        self.points = points

    def along(self, axis):
        """The surface as a Row in one direction."""
        lines = self.points if axis == 0 else list(map(list, zip(*self.points)))
        flat = [[c for p in line for c in p] for line in lines]
        return Row(self.degree[axis], self.knots[axis], flat)

    def replaced(self, axis, row):
        """The surface whose Row in that direction is `row`."""
        lines = [[p[i : i + 4] for i in range(0, len(p), 4)] for p in row.points]
        points = lines if axis == 0 else list(map(list, zip(*lines)))
        degree, knots = list(self.degree), list(self.knots)
        degree[axis], knots[axis] = row.degree, row.knots
        return Net(degree, knots, points)

    @property
    def box(self):
        (u, v) = self.knots
        return (u[0], u[-1], v[0], v[-1])

    def segment(self, box):
        net = self.replaced(0, self.along(0).segment(box[0], box[1]))
        return net.replaced(1, net.along(1).segment(box[2], box[3]))

    def over(self, box):
        net = self.replaced(0, self.along(0).over(box[0], box[1]))
        return net.replaced(1, net.along(1).over(box[2], box[3]))

    def times(self, axis, factor):
        return self.replaced(axis, self.along(axis).times(factor))

    def border(self, k):
        """Border k as a curve, in the direction of its parameter: v low, u high, v high, u low."""
        axis = k % 2  # the direction in which the border runs
        end = -1 if k in (1, 2) else 0
        line = [row[end] for row in self.points] if axis == 0 else self.points[end]
        return Row(self.degree[axis], self.knots[axis], line)

    def homogeneous(self, u, v):
        row = Row(self.degree[1], self.knots[1], _fours(self.along(0).value(u)))
        return row.value(v)

    def place(self, u, v):
        *x, w = self.homogeneous(u, v)
        return [c / w for c in x]

    def patch(self, **names):
        """As the library takes it; one common factor brings equal weights to one."""
        n, m = len(self.points), len(self.points[0])
        order = [self.points[i][j] for j in range(m) for i in range(n)]
        weights = [p[3] for p in order]
        points = [(p[0] / p[3], p[1] / p[3], p[2] / p[3]) for p in order]
        if all(w == weights[0] for w in weights):
            weights = None
        return Patch(self.degree, (n, m), self.knots, points, weights, **names)


def _fours(flat):
    return [flat[i : i + 4] for i in range(0, len(flat), 4)]


def net_of_grid(grid, breaks, degree):
    """A Net of Bezier pieces: grid holds the points of all pieces, shared where they meet."""
    knots = []
    for k in (0, 1):
        inner = [b for b in breaks[k][1:-1] for _ in range(degree[k])]
        low, high = breaks[k][0], breaks[k][-1]
        knots.append([low] * (degree[k] + 1) + inner + [high] * (degree[k] + 1))
    return Net(degree, knots, grid)


def net_of_patch(patch):
    n, m = patch.n_control
    weights = patch.weights or [1.0] * (n * m)
    points = []
    for i in range(n):
        line = []
        for j in range(m):
            w = weights[i + n * j]
            line.append([w * c for c in patch.points[i + n * j]] + [w])
        points.append(line)
    return Net(patch.degree, patch.knots, points)
