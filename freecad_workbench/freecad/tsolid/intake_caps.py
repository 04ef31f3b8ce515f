# SPDX-License-Identifier: LGPL-2.1-or-later
"""Caps cut from a sphere by one circle, as exact rational patches.

Let d point from the circle's centre C to the cap's apex, N be the sphere's point opposite to the
apex and h = d.(C - N). The stereographic projection from N takes the cap to the disc; its inverse
takes a point C + x of the disc's plane to

    N + 2 R h (h d + x) / (h^2 + x.x),

in homogeneous coordinates (X, W) with x = X / W, divided by 2 R h,

    D = (h^2 W^2 + X.X) / (2 R h),    (N D + h W^2 d + X W, D).

So a rational patch that fills the disc with degree (p, q) becomes a patch of degree (2p, 2q) that
fills the cap. On the circle D = W^2 and the point is W (C W + X, W): the border that was given, but
times its own weight. Neighbours have to be multiplied by that factor as well (it changes no point).

A cap that has no side walls beside it (a lens, a hemisphere) is laid out as five patches: a square
around the apex and a ring of four, so that the part is a cube.
"""

from .nurbs import Net, Row, binomial, net_of_grid

INNER_FACTORS = (1.0, 1.5, 2.0, 2.5, 3.0)
LEAST_WEIGHT = 0.05  # of the largest
MAX_HALVINGS = 4


def _products(p, q):
    """c[i][k]: the factor of a_i b_k in the Bezier point i + k of a product."""
    return [
        [binomial(p, i) * binomial(q, k) / binomial(p + q, i + k) for k in range(q + 1)]
        for i in range(p + 1)
    ]


def times(a, b):
    """Product of two bivariate Bezier polynomials a[i][j], b[i][j]."""
    pu, pv, qu, qv = len(a) - 1, len(a[0]) - 1, len(b) - 1, len(b[0]) - 1
    cu, cv = _products(pu, qu), _products(pv, qv)
    out = [[0.0] * (pv + qv + 1) for _ in range(pu + qu + 1)]
    for i in range(pu + 1):
        for j in range(pv + 1):
            for k in range(qu + 1):
                for m in range(qv + 1):
                    out[i + k][j + m] += cu[i][k] * cv[j][m] * a[i][j] * b[k][m]
    return out


def sum_of(*terms):
    """Sum of factor * polynomial."""
    rows = range(len(terms[0][1]))
    columns = range(len(terms[0][1][0]))
    return [[sum(f * t[i][j] for f, t in terms) for j in columns] for i in rows]


class Sphere:
    """The cap's geometry: its circle's centre; the sphere's middle and radius; d, north and h as
    above."""

    def __init__(self, face):
        self.centre, axis = face.ring.Center, face.ring.Axis
        apex = face.face.CenterOfMass - self.centre
        self.d = axis if axis.dot(apex) > 0.0 else axis * -1.0
        self.middle, self.radius = face.ball.centre, face.ball.radius
        self.north = self.middle - self.d * self.radius
        self.h = self.d.dot(self.centre - self.north)

    def point(self, place):
        """A point of the circle's plane on the sphere."""
        x = place - self.centre
        return self.north + (self.d * self.h + x) * (
            2.0 * self.radius * self.h / (self.h**2 + x.dot(x))
        )

    def lift(self, piece):
        """A Bezier patch in the circle's plane onto the sphere: piece[i][j] homogeneous."""
        c, n, d, h = self.centre, self.north, self.d, self.h
        w = [[p[3] for p in line] for line in piece]
        x = [[[p[a] - c[a] * p[3] for p in line] for line in piece] for a in range(3)]
        ww = times(w, w)
        squares = [(1.0 / (2.0 * self.radius * h), times(y, y)) for y in x]
        weight = sum_of((h / (2.0 * self.radius), ww), *squares)
        axes = [
            sum_of((n[a], weight), (h * d[a], ww), (1.0, times(x[a], w))) for a in range(3)
        ]
        return [
            [list(point) for point in zip(*lines)] for lines in zip(*axes, weight)
        ]


def lifted(face, net):
    """A Net in the plane of the cap's circle as a Net on the sphere, with positive weights.

    The lifted weights of a wide cap can turn negative inside although their function is positive.
    The weights of control points inside are free: larger ones cure that, or else smaller pieces.
    """
    sphere = Sphere(face)
    for _ in range(MAX_HALVINGS):
        for factor in INNER_FACTORS:
            made = _lifted(sphere, _with_inner_weights(net, factor))
            weights = [p[3] for line in made.points for p in line]
            if min(weights) >= LEAST_WEIGHT * max(weights):
                return made
        net = _halved(net)
    return made


def _with_inner_weights(net, factor):
    n, m = len(net.points), len(net.points[0])
    points = [
        [
            [factor * c for c in net.points[i][j]]
            if 0 < i < n - 1 and 0 < j < m - 1
            else list(net.points[i][j])
            for j in range(m)
        ]
        for i in range(n)
    ]
    return Net(net.degree, net.knots, points)


def _halved(net):
    for axis in (0, 1):
        row = net.along(axis)
        breaks = row.breaks()
        for a, b in zip(breaks, breaks[1:]):
            row = row.with_knot(0.5 * (a + b), 1)
        net = net.replaced(axis, row)
    return net


def _lifted(sphere, net):
    breaks = [sorted(set(k)) for k in net.knots]
    p, q = net.degree
    columns = net.along(0).beziers()  # per span in u: p + 1 long points
    grid = []
    for column in columns:
        lines = [[c[k : k + 4] for k in range(0, len(c), 4)] for c in column]
        strip = Net((p, q), ([0.0] * (p + 1) + [1.0] * (p + 1), net.knots[1]), lines)
        rows = strip.along(1).beziers()
        done = []
        for piece in rows:
            turned = [[c[k : k + 4] for k in range(0, len(c), 4)] for c in piece]
            done.append(sphere.lift([list(line) for line in zip(*turned)]))
        wide = [sum((d[i][1:] for d in done[1:]), list(done[0][i])) for i in range(2 * p + 1)]
        grid += wide if not grid else wide[1:]
    return net_of_grid(grid, breaks, (2 * p, 2 * q))


# ---- five patches ------------------------------------------------------------------------------


def _middle(centre, point):
    """Half-way between the centre and a homogeneous point of the circle."""
    return [0.5 * (c * point[3] + x) for c, x in zip(centre, point[:3])] + [point[3]]


def five_nets(face, rows):
    """rows: the circle's four arcs once around. The ring's four nets (u along the arc, v from the
    square outwards) and the square's, each row shared with its neighbour's as it is."""
    centre = list(Sphere(face).centre)
    inner = []
    for row in rows:
        a, b = _middle(centre, row.points[0]), _middle(centre, row.points[-1])
        line = Row(1, [row.first, row.first, row.last, row.last], [a, b])
        weights = [[p[3]] for p in row.points]
        line = _line_with_weights(line, row, weights)
        inner.append(line)
    ring = []
    for low, high in zip(inner, rows):
        points = [list(pair) for pair in zip(low.points, high.points)]
        ring.append(Net((high.degree, 1), (high.knots, [0.0, 0.0, 1.0, 1.0]), points))
    return [lifted(face, net) for net in ring], inner


def _line_with_weights(line, row, weights):
    """The straight line between a row's ends with the row's own weights and knots.

    The control points lie on the line at the places that the row's functions have with its weights
    when they are spread symmetrically: at the ends and, of a single arc, in the middle.
    """
    a, b = line.points[0], line.points[-1]
    n = len(weights) - 1
    points = []
    for i, (w,) in enumerate(weights):
        t = i / n
        points.append([w * ((1 - t) * x / a[3] + t * y / b[3]) for x, y in zip(a[:3], b[:3])] + [w])
    return Row(row.degree, row.knots, points)
