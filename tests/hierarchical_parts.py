# SPDX-License-Identifier: LGPL-2.1-or-later
"""A boundary technology that the library has never heard of: hierarchical B-splines, truncated and
not, on the surface of a cube-like part, refined locally across isolines. It arrives as Bezier
elements in .tsb and must become a proved solid with that surface (HierarchicalCase.check).

The splines are those of a volume N_a(x) N_b(y) N_c(z), restricted to the surface of the cube: level
l has twice the spans of level l-1, and a function lives on all sides that its place in the lattice
touches. Functions are kept as coefficients of the finest level, whose values come from the de Boor
recursion below; nothing is the library's."""
import itertools
import json
import os
import subprocess
import tempfile
import unittest

import numpy as np

from binding_parts import binding

COMMAND = os.environ.get("TSOLID_COMMAND", "tsolid")


# ---- univariate B-splines ------------------------------------------------------------------------

def clamped(degree, n_spans):
    inner = [i / n_spans for i in range(1, n_spans)]
    return np.array([0.0] * (degree + 1) + inner + [1.0] * (degree + 1))


def values(degree, knots, x):
    """All functions at x, by the recursion; the last span is closed."""
    n = len(knots) - 1
    last = max(i for i in range(n) if knots[i] < knots[i + 1])
    out = [float(knots[i] <= x < knots[i + 1] or (i == last and x == knots[-1])) for i in range(n)]
    for p in range(1, degree + 1):
        for i in range(n - p):
            left, right = knots[i + p] - knots[i], knots[i + p + 1] - knots[i + 1]
            a = (x - knots[i]) / left * out[i] if left > 0 else 0.0
            b = (knots[i + p + 1] - x) / right * out[i + 1] if right > 0 else 0.0
            out[i] = a + b
    return np.array(out[: n - degree])


def two_scale(degree, n_spans):
    """Rows: the functions of n_spans in terms of those of 2 n_spans, by Boehm's rule."""
    knots = list(clamped(degree, n_spans))
    matrix = np.eye(n_spans + degree)
    for i in range(n_spans):
        x = (2 * i + 1) / (2 * n_spans)
        span = max(k for k in range(len(knots) - degree - 1) if knots[k] <= x)
        n = matrix.shape[1]
        step = np.zeros((n, n + 1))
        for m in range(n + 1):
            if m <= span - degree:
                step[m, m] = 1.0
            elif m > span:
                step[m - 1, m] = 1.0
            else:
                a = (x - knots[m]) / (knots[m + degree] - knots[m])
                step[m, m] += a
                step[m - 1, m] += 1.0 - a
        matrix = matrix @ step
        knots.insert(span + 1, x)
    return matrix


# ---- the hierarchy -------------------------------------------------------------------------------

SIDE_AXES = [(1, 2), (1, 2), (0, 2), (0, 2), (0, 1), (0, 1)]


def refined(level, side, s, t):
    """Whether the point (s,t) of a side lies in the region of `level`: boxes round an isoline, a
    corner and a place inside a side, given in space so that they cross isolines alike."""
    x = [0.0] * 3
    x[side // 2] = float(side % 2)
    x[SIDE_AXES[side][0]], x[SIDE_AXES[side][1]] = s, t
    boxes = {1: [((0.25, -1, -1), (1.1, 0.5, 0.5)), ((-1, 0.5, 0.5), (0.5, 1.1, 1.1)),
                 ((0.9, 0.0, 0.25), (1.1, 1.0, 1.0))],
             2: [((0.5, -1, -1), (1.1, 0.25, 0.25)), ((0.9, 0.25, 0.5), (1.1, 0.75, 1.0))]}
    return any(all(lo[c] < x[c] < hi[c] for c in range(3)) for lo, hi in boxes[level])


class Hierarchy:
    """functions: (lattice coefficients of the finest level, Greville point); cells per side."""

    def __init__(self, degree, n_spans, n_levels, truncated):
        self.degree, self.n_levels = degree, n_levels
        self.spans = [n_spans << level for level in range(n_levels)]
        self.knots = [clamped(degree, n) for n in self.spans]
        self.steps = [two_scale(degree, n) for n in self.spans[:-1]]
        self.functions, self.points = [], []
        active = [self.active(level) for level in range(n_levels)]
        for level in range(n_levels):
            n = self.spans[level] + degree
            for place in zip(*np.nonzero(active[level])):
                lattice = np.zeros((n, n, n))
                lattice[place] = 1.0
                for step, finer in zip(self.steps[level:], active[level + 1:]):
                    lattice = np.einsum("abc,ai,bj,ck->ijk", lattice, step, step, step,
                                        optimize=True)
                    if truncated:
                        lattice = np.where(finer, 0.0, lattice)
                self.functions.append(lattice)
                self.points.append(self.greville(level, place))

    def greville(self, level, place):
        knots = self.knots[level]
        return [sum(knots[i + 1:i + self.degree + 1]) / self.degree for i in place]

    def cells_of(self, level, i, j, side):
        """Middles of the cells of a side that N_i(s) N_j(t) of a level does not vanish on."""
        knots, p, n = self.knots[level], self.degree, self.spans[level]
        for a, b in itertools.product(range(n), range(n)):
            lo, hi = a / n, (a + 1) / n
            if not (knots[i] < hi and lo < knots[i + p + 1]):
                continue
            if not (knots[j] < (b + 1) / n and b / n < knots[j + p + 1]):
                continue
            yield side, (lo + hi) / 2, (b + 0.5) / n

    def cells(self, level, place):
        """Middles of the cells of all sides in the support of a lattice function."""
        n = self.spans[level] + self.degree
        for side in range(6):
            if place[side // 2] == (n - 1 if side % 2 else 0):
                s, t = SIDE_AXES[side]
                yield from self.cells_of(level, place[s], place[t], side)

    def active(self, level):
        n = self.spans[level] + self.degree
        out = np.zeros((n, n, n), bool)
        for place in itertools.product(range(n), repeat=3):
            if not any(c in (0, n - 1) for c in place):
                continue
            cells = list(self.cells(level, place))
            mine = level == 0 or all(refined(level, *c) for c in cells)
            finer = level + 1 < self.n_levels and all(refined(level + 1, *c) for c in cells)
            out[place] = mine and not finer
        return out

    def leaves(self, side):
        """Boxes of the side's elements: cells of the level that their middle is refined to."""
        for level in range(self.n_levels):
            n = self.spans[level]
            for j, i in itertools.product(range(n), range(n)):
                s, t = (i + 0.5) / n, (j + 0.5) / n
                mine = level == 0 or refined(level, side, s, t)
                finer = level + 1 < self.n_levels and refined(level + 1, side, s, t)
                if mine and not finer:
                    yield [i / n, (i + 1) / n, j / n, (j + 1) / n]

    def trace(self, lattice, side):
        """Coefficients on a side of the finest level, axes (s, t)."""
        return np.take(lattice, -1 if side % 2 else 0, axis=side // 2)

    def basis(self, side, s, t):
        """The values of all functions."""
        row = values(self.degree, self.knots[-1], s)
        column = values(self.degree, self.knots[-1], t)
        return np.array([row @ self.trace(f, side) @ column for f in self.functions])


def part_points(points, weights, rng):
    """Homogeneous control points: a bent box with bumps of every level."""
    x = np.array(points)
    bent = np.stack([3 * x[:, 0] + 0.3 * np.sin(2 * x[:, 1] + x[:, 2]),
                     2 * x[:, 1] + 0.2 * np.cos(2 * x[:, 0]),
                     1.5 * x[:, 2] + 0.25 * np.sin(2 * x[:, 0] + x[:, 1])], axis=1)
    bent += 0.02 * (rng.random(bent.shape) - 0.5)
    w = 1.0 + 0.5 * rng.random(len(x)) if weights else np.ones(len(x))
    return np.column_stack([bent * w[:, None], w])


def to_bernstein(degree):
    """Values at equal steps, ends included, to Bernstein coefficients."""
    x = np.linspace(0, 1, degree + 1)
    rows = [values(degree, clamped(degree, 1), v) for v in x]
    return np.linalg.inv(np.array(rows))


def elements_of(h, side):
    inverse, p = to_bernstein(h.degree), h.degree
    traces = np.array([h.trace(f, side) for f in h.functions])
    for box in h.leaves(side):
        s = [values(p, h.knots[-1], x) for x in np.linspace(box[0], box[1], p + 1)]
        t = [values(p, h.knots[-1], x) for x in np.linspace(box[2], box[3], p + 1)]
        net = np.einsum("ai,fij,bj->fba", np.array(s), traces, np.array(t))
        net = np.einsum("kb,fba,la->fkl", inverse, net, inverse).reshape(len(net), -1)
        net[np.abs(net) < 1e-13] = 0.0
        live = [f for f in range(len(net)) if net[f].any()]
        yield {"box": box, "functions": live, "coefficients": [net[f].tolist() for f in live]}


def write(path, h, points):
    """Gives the number of elements, and how far the functions' sum is from one: over all Bernstein
    coefficients."""
    sides = [{"degree": [h.degree] * 2, "elements": list(elements_of(h, side))}
             for side in range(6)]
    document = {"format": "tsolid boundary", "version": 1,
                "bezier": {"points": points.tolist(), "sides": sides}}
    with open(path, "w") as out:
        json.dump(document, out)
    elements = [element for side in sides for element in side["elements"]]
    sums = [np.sum(element["coefficients"], axis=0) for element in elements]
    return len(elements), max(np.abs(s - 1.0).max() for s in sums)


# ---- the chain -----------------------------------------------------------------------------------

def cube_map(given, found):
    """Where corner 0 of the library's cube, and the ends of its axes, lie in ours."""
    def nearest(point):
        gaps = [np.linalg.norm(np.array(g) - point) for g in given]
        assert min(gaps) < 1e-9, min(gaps)
        k = int(np.argmin(gaps))
        return np.array([k & 1, k >> 1 & 1, k >> 2], float)
    origin = nearest(np.array(found[0]))
    return origin, [nearest(np.array(found[1 << a])) - origin for a in range(3)]


class HierarchicalCase(unittest.TestCase):
    def surface(self, h, points, side, s, t):
        x = h.basis(side, s, t) @ points
        return x[:3] / x[3]

    def check_conform(self, h, points, path, rng):
        context = binding.Context()
        solid = binding.Solid.read(context, path)
        given = [self.surface(h, points, 4 + (k >> 2), float(k & 1), float(k >> 1 & 1))
                 for k in range(8)]
        origin, axes = cube_map(given, [list(c) for c in solid.boundary.requirement["corner"]])
        worst = 0.0
        for side in range(6):
            for s, t in [(0.0, 0.0), (0.5, 0.25), (1.0, 1.0)] + rng.random((40, 2)).tolist():
                x = np.zeros(3)
                x[side // 2] = side % 2
                x[SIDE_AXES[side][0]], x[SIDE_AXES[side][1]] = s, t
                y = [float((x - origin) @ a) for a in axes]
                axis = next(a for a in range(3) if axes[a][side // 2])
                other = [b for b in range(3) if b != axis]
                theirs = 2 * axis + round(y[axis])
                block, u = solid.boundary_point(theirs, y[other[0]], y[other[1]])
                got = np.array(solid.evaluate(context, block, u)).ravel()[:3]
                worst = max(worst, np.linalg.norm(got - self.surface(h, points, side, s, t)))
        return worst / solid.boundary.scale

    def check(self, degree, n_spans, n_levels, truncated, weights):
        rng = np.random.default_rng(7)
        h = Hierarchy(degree, n_spans, n_levels, truncated)
        points = part_points(h.points, weights, rng)
        with tempfile.TemporaryDirectory() as folder:
            tsb, solid = os.path.join(folder, "part.tsb"), os.path.join(folder, "part.tsolid")
            n_elements, defect = write(tsb, h, points)
            sums = [abs(h.basis(side, s, t).sum() - 1.0)
                    for side in range(6) for s, t in rng.random((10, 2))]
            facts = os.path.join(folder, "report.json")
            done = subprocess.run([COMMAND, "build", tsb, "-o", solid, "--report", facts],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            with open(facts) as file:
                report = json.load(file)
            self.assertEqual(report["certificate"]["verdict"], "positive")
            self.assertEqual(report["statistics"]["input_nodes"], len(h.functions))
            self.assertEqual(report["statistics"]["input_elements"], n_elements)
            distance = self.check_conform(h, points, solid, rng)
            print("degree %d, %d levels, %s%s: %d functions, %d elements, distance %.2g, sum of "
                  "the input's functions off by %.2g, reported %.2g, quality %.3f"
                  % (degree, n_levels, "truncated" if truncated else "plain",
                     ", rational" if weights else "", len(h.functions), n_elements, distance,
                     defect, report["basis"]["sum_defect"], report["quality"]["worst"]))
            self.assertLess(distance, 1e-12)
            self.check_sums(report["basis"], max(sums), defect, truncated)

    def check_sums(self, basis, sampled, defect, truncated):
        """The report's defect is the input's own, which the written coefficients tell as well."""
        self.assertLessEqual(sampled, defect + 1e-13)
        self.assertAlmostEqual(basis["input_sum_defect"], defect, delta=1e-13)
        self.assertLessEqual(basis["sum_defect"], basis["input_sum_defect"] + 1e-12)
        self.assertGreaterEqual(basis["sum_defect"], sampled - 1e-12)
        if truncated:
            self.assertLess(defect, 1e-13)
        else:
            self.assertGreater(sampled, 0.05)
