# SPDX-License-Identifier: LGPL-2.1-or-later
"""Control nets compared as what they mean: as a set of patches, each up to the eight symmetries of
the square, an affine change of its parameters and one factor of all its weights.

A file may begin a closed edge elsewhere, order the faces anew, turn a surface's parameters: none of
that changes a patch by more than this. Everything else does, so it is a difference.
"""

import math

KNOT = 1e-9  # knots and weights: relative, of a part near the origin


class Net:
    """Degrees, knots over [0, 1], points[i][j] and weights[i][j] (largest: 1) of a patch."""

    def __init__(self, degree, knots, points, weights, free=False):
        self.degree, self.knots, self.points, self.weights = degree, knots, points, weights
        self.free = free  # points inside are the library's own choice

    @classmethod
    def of(cls, patch, free=False):
        n, m = patch.n_control
        given = patch.weights or [1.0] * (n * m)
        most = max(given)
        points = [[patch.points[i + n * j] for j in range(m)] for i in range(n)]
        weights = [[given[i + n * j] / most for j in range(m)] for i in range(n)]
        knots = [[(k - row[0]) / (row[-1] - row[0]) for k in row] for row in patch.knots]
        return cls(tuple(patch.degree), knots, points, weights, free)

    def reversed(self):
        """Against the first parameter."""
        first = [1.0 - k for k in reversed(self.knots[0])]
        return Net(self.degree, [first, self.knots[1]], self.points[::-1], self.weights[::-1],
                   self.free)

    def swapped(self):
        turned = [list(map(list, zip(*rows))) for rows in (self.points, self.weights)]
        return Net(self.degree[::-1], self.knots[::-1], *turned, free=self.free)

    def symmetries(self):
        """All eight: a quarter turn is a reversal and a swap."""
        out, net = [], self
        for _ in range(4):
            out += [net, net.swapped()]
            net = net.reversed().swapped()
        return out

    def _compared(self, rows):
        n, m = len(rows), len(rows[0])
        return [rows[i][j] for i in range(n) for j in range(m)
                if not self.free or i in (0, n - 1) or j in (0, m - 1)]

    def distance_as_is(self, other, allowed=KNOT):
        """The largest distance of two control points; inf when anything else differs, knots and
        weights by more than is allowed."""
        sizes = [(n.degree, [len(k) for k in n.knots], n.free) for n in (self, other)]
        if sizes[0] != sizes[1]:
            return math.inf
        numbers = [(a, b) for x, y in zip(self.knots, other.knots) for a, b in zip(x, y)]
        numbers += zip(self._compared(self.weights), self._compared(other.weights))
        if any(abs(a - b) > allowed for a, b in numbers):
            return math.inf
        return max(map(math.dist, self._compared(self.points), self._compared(other.points)))

    def distance(self, other, allowed=KNOT):
        return min(self.distance_as_is(s, allowed) for s in other.symmetries())


def nets_of(patches, free=()):
    """free: names of the patches with points of the library's own choice."""
    return [Net.of(p, p.name in free) for p in patches]


def difference(ours, theirs, far=1.0):
    """The largest distance of a net from its own partner in the other set; inf when the sets
    cannot be paired. Partners are far nearer than anything else, so the nearest is the one.

    far: how many times its own size a part is from the origin: so many times less is known of its
    knots and weights after a file that keeps a number of digits of its coordinates.
    """
    left, worst = list(theirs), 0.0
    for net in ours:
        if not left:
            return math.inf
        away = [net.distance(other, KNOT * far) for other in left]
        k = away.index(min(away))
        worst = max(worst, away[k])
        del left[k]
    return math.inf if left else worst
