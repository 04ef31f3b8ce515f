# SPDX-License-Identifier: LGPL-2.1-or-later
"""Closed bodies of six B-spline sides as .iga: nodes shared along isolines, one Bezier element per
span or per part of one, in any frame, order and degree."""
import os
import random
import sys
from itertools import product

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "resources"))

from examples.splines import basis_matrix, greville, refinement  # noqa: E402


class Axis:
    """One direction of the body: its B-splines and where the lines of its elements are."""

    def __init__(self, degree, inner):
        self.degree = degree
        self.knots = (0.0,) * (degree + 1) + tuple(inner) + (1.0,) * (degree + 1)
        self.n = len(self.knots) - degree - 1
        self.values = sorted(set(self.knots))
        full = (0.0,) + tuple(v for v in self.values for _ in range(degree)) + (1.0,)
        matrix = refinement(self.knots, degree, full)
        self.spans = [
            matrix[degree * e : degree * e + degree + 1] for e in range(len(self.values) - 1)
        ]

    def functions(self, span):
        """Numbers of the functions on a span and their Bernstein coefficients as columns."""
        numbers = np.flatnonzero(np.abs(self.spans[span]).max(axis=0) > 0)
        return numbers, self.spans[span][:, numbers]


class Body:
    """The surface of a tensor B-spline body over three axes; `move` bends and weighs it."""

    def __init__(self, axes, move):
        self.axes = axes
        self.node = {}
        rows = []
        shape = [a.n for a in axes]
        grids = [greville(a.knots, a.degree) for a in axes]
        for i in product(*(range(n) for n in shape)):
            if any(k in (0, n - 1) for k, n in zip(i, shape)):
                self.node[i] = len(rows)
                rows.append(move(*(g[k] for g, k in zip(grids, i))))
        self.points = np.array(rows)  # x y z w, Euclidean

    def index(self, side, a, b):
        axis, end = divmod(side, 2)
        i = [a, b]
        i.insert(axis, self.axes[axis].n - 1 if end else 0)
        return self.node[tuple(i)]

    def point(self, side, s, t):
        """De Boor's value at parameters of a side: independent of elements and extraction."""
        axes = [x for k, x in enumerate(self.axes) if k != side // 2]
        n = [basis_matrix(x.knots, x.degree, np.array([p]))[0] for x, p in zip(axes, (s, t))]
        total = np.zeros(4)
        for a, b in product(np.flatnonzero(n[0]), np.flatnonzero(n[1])):
            h = self.points[self.index(side, a, b)]
            total += n[0][a] * n[1][b] * np.append(h[:3] * h[3], h[3])
        return total[:3] / total[3]

    def elements(self):
        """Per element: side, box in (s, t), node numbers and nets (s first)."""
        for side in range(6):
            s, t = (x for k, x in enumerate(self.axes) if k != side // 2)
            for i, j in product(range(len(s.spans)), range(len(t.spans))):
                (na, ca), (nb, cb) = s.functions(i), t.functions(j)
                box = (s.values[i], s.values[i + 1], t.values[j], t.values[j + 1])
                nets = {
                    self.index(side, a, b): np.outer(ca[:, k], cb[:, m])
                    for (k, a), (m, b) in product(enumerate(na), enumerate(nb))
                }
                yield side, box, nets


def restrict(rows, low, high):
    """Bernstein coefficients (first axis) on [low, high] of [0, 1], by de Casteljau."""
    rows = np.array(rows, dtype=float)
    p = len(rows) - 1
    for r in range(1, p + 1):
        rows[r:] = (1 - high) * rows[r - 1 : -1] + high * rows[r:]
    x = low / high
    for r in range(1, p + 1):
        rows[: p + 1 - r] = (1 - x) * rows[: p + 1 - r] + x * rows[1 : p + 2 - r]
    return rows


def raise_degree(rows):
    p = len(rows) - 1
    k = np.arange(p + 2).reshape((-1,) + (1,) * (rows.ndim - 1)) / (p + 1)
    pad = np.zeros((1,) + rows.shape[1:])
    return k * np.concatenate([pad, rows]) + (1 - k) * np.concatenate([rows, pad])


def split(elements, cut, chance):
    """Some elements become two, at the part `cut` of one of their directions: T-junctions."""
    for side, box, nets in elements:
        if chance.random() > 0.25:
            yield side, box, nets
            continue
        d = chance.randrange(2)
        middle = box[2 * d] + cut * (box[2 * d + 1] - box[2 * d])
        for low, high in ((0.0, cut), (cut, 1.0)):
            part = list(box)
            part[2 * d + (low == 0.0)] = middle
            halves = {
                f: np.moveaxis(restrict(np.moveaxis(net, d, 0), low, high), 0, d)
                for f, net in nets.items()
            }
            yield side, tuple(part), halves


def element_text(nets, chance, raised):
    """One element in a random frame; `raised` times a degree is raised."""
    functions = list(nets)
    chance.shuffle(functions)
    turn = chance.randrange(8)
    up = [chance.randrange(raised + 1) for _ in range(2)]
    rows, shape = [], None
    for f in functions:
        net = nets[f]
        net = net.T if turn & 4 else net
        net = net[:: -1 if turn & 1 else 1, :: -1 if turn & 2 else 1]
        for d in range(2):
            for _ in range(up[d]):
                net = np.moveaxis(raise_degree(np.moveaxis(net, d, 0)), 0, d)
        shape = net.shape
        rows.append(" ".join(repr(float(x)) for x in net.T.ravel()))
    head = "belem %d %d %d" % (len(functions), shape[0] - 1, shape[1] - 1)
    return "\n".join([head, " ".join(map(str, functions))] + rows)


def write_iga(path, body, seed=1, raised=0, cut=None, kind="surface"):
    """Returns the elements as written: (side, box) of each."""
    chance = random.Random(seed)
    elements = list(body.elements())
    if cut:
        elements = list(split(elements, cut, chance))
    chance.shuffle(elements)
    with open(path, "w", encoding="ascii") as out:
        out.write("# six sides\ntype %s\nnodeN %d\nelemN %d\n" % (
            kind, len(body.points), len(elements)))
        for row in body.points:
            out.write("node %s\n" % " ".join(repr(float(x)) for x in row))
        for _, _, nets in elements:
            out.write(element_text(nets, chance, raised) + "\n")
        out.write("set 1 side Bottom 0 LEFT\ndomain 1 2\n0\n0 1\n0 1\n")
    return [(side, box) for side, box, _ in elements]
