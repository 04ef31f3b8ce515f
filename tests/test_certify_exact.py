#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The certificate of one element against exact rational arithmetic.

Whatever the floating-point code says, N = -det[X, X_0, X_1, X_2] is evaluated here in integers: a
positive verdict must not meet a point with N <= 0, a point given with a negative one must have
N <= 0, and good elements must be found positive. Elements are random, folded by very little,
tangent at corners, far from the origin, of wild weights; each family is searched for the place
where the verdict flips, since a wrong error bound shows there first."""

import ctypes
import itertools
import math
import random
import sys
import unittest
from fractions import Fraction

import binding_parts

POSITIVE, NOT_POSITIVE, UNDECIDED = range(3)
DEGREES = [(3, 3, 3), (5, 4, 3), (1, 2, 9), (3, 6, 6), (1, 1, 1)]
SEED = 20240229


class Options(ctypes.Structure):
    _fields_ = [("max_depth", ctypes.c_int)]


class Certificate(ctypes.Structure):
    _fields_ = (
        [(n, ctypes.c_int) for n in ("verdict", "n_elements", "n_positive", "n_not_positive")]
        + [("n_undecided", ctypes.c_int), ("n_singular", ctypes.c_int)]
        + [("singular", ctypes.c_double * 24), ("depth", ctypes.c_int), ("element", ctypes.c_int)]
        + [("u", ctypes.c_double * 3), ("point", ctypes.c_double * 3)]
        + [("smallest_bound", ctypes.c_double)]
    )


class Library:
    def __init__(self):
        self.lib = ctypes.CDLL(binding_parts.library_path())
        self.lib.tsolid_struct_size.restype = ctypes.c_size_t
        if self.lib.tsolid_struct_size(b"tsolid_certificate") != ctypes.sizeof(Certificate):
            raise AssertionError("struct tsolid_certificate has changed")
        self.context = ctypes.c_void_p()
        if self.lib.tsolid_context_create(None, ctypes.byref(self.context)):
            raise AssertionError("no context")

    def status(self, degree, points, depth=0):
        flat = [c for p in points for c in p]
        result = Certificate()
        status = self.lib.tsolid_certify_element(
            self.context,
            (ctypes.c_int * 3)(*degree),
            (ctypes.c_double * len(flat))(*flat),
            ctypes.byref(Options(depth)),
            ctypes.byref(result),
        )
        return status, result

    def certify(self, degree, points, depth=0):
        status, result = self.status(degree, points, depth)
        if status:
            raise AssertionError("status %d" % status)
        return result


LIBRARY = Library()

# ---- exact arithmetic ----------------------------------------------------------------------------


def det(rows):
    """Of integers or fractions, by minors along the first row."""
    if len(rows) == 1:
        return rows[0][0]
    return sum(
        (-1) ** j * rows[0][j] * det([r[:j] + r[j + 1 :] for r in rows[1:]])
        for j in range(len(rows))
        if rows[0][j]
    )


def integers(points):
    """Control points times one power of two, exactly integers."""
    scale = max(Fraction(c).denominator for p in points for c in p)
    return [[int(Fraction(c) * scale) for c in p] for p in points]


def bernstein(degree, x):
    """Values and derivatives over degree, as integers: both times denominator^degree."""
    a, b = x.numerator, x.denominator - x.numerator
    value = [math.comb(degree, i) * a**i * b ** (degree - i) for i in range(degree + 1)]
    low = [math.comb(degree - 1, i) * a**i * b ** (degree - 1 - i) for i in range(degree)] + [0]
    slope = [x.denominator * ((low[i - 1] if i else 0) - low[i]) for i in range(degree + 1)]
    return value, slope


def contract(rows, basis, n):
    """rows[i + n k] -> sum_i basis[i] rows[i + n k], rows being lists of 4."""
    return [
        [sum(basis[i] * rows[k + i][c] for i in range(n)) for c in range(4)]
        for k in range(0, len(rows), n)
    ]


class Exact:
    """Sign and value of N of an element at rational points."""

    def __init__(self, degree, points):
        self.degree, self.points = degree, integers(points)

    def lines(self, x):
        n = self.degree[0] + 1
        return [contract(self.points, b, n) for b in bernstein(self.degree[0], x)]

    def planes(self, lines, y):
        n = self.degree[1] + 1
        value, slope = bernstein(self.degree[1], y)
        rows = zip((lines[0], lines[1], lines[0]), (value, value, slope))
        return [contract(r, b, n) for r, b in rows]

    def numerator(self, planes, z):
        n = self.degree[2] + 1
        value, slope = bernstein(self.degree[2], z)
        rows = [contract(p, value, n)[0] for p in planes] + [contract(planes[0], slope, n)[0]]
        return -det(rows)

    def at(self, u):
        x, y, z = (Fraction(t) for t in u)
        return self.numerator(self.planes(self.lines(x), y), z)

    def grid(self, axes):
        """(N, u) over a tensor grid. N at different points has different positive factors."""
        for x in axes[0]:
            lines = self.lines(x)
            for y in axes[1]:
                planes = self.planes(lines, y)
                for z in axes[2]:
                    yield self.numerator(planes, z), (x, y, z)

    def scaled(self, u):
        """N at u over a fixed denominator, as a float: comparable between points."""
        size = math.prod(Fraction(t).denominator ** (4 * q) for t, q in zip(u, self.degree))
        return Fraction(self.at(u), size)

    def negative_point(self, start=None):
        """A point with N <= 0 from a 7^3 grid, then a descent by halving steps; None: none seen."""
        sixths = [Fraction(i, 6) for i in range(7)]
        best, where = None, start
        if start is None:
            for n, u in self.grid([sixths] * 3):
                if n <= 0:
                    return u
            for u in itertools.product((Fraction(0), Fraction(1, 2), Fraction(1)), repeat=3):
                value = self.scaled(u)
                if best is None or value < best:
                    best, where = value, u
        step = Fraction(1, 4) if start is None else Fraction(1, 1 << 12)
        where = tuple(Fraction(t) for t in where)
        for _ in range(5):
            around = [[t for t in (c - step, c, c + step) if 0 <= t <= 1] for c in where]
            values = [(self.scaled(u), u) for u in itertools.product(*around)]
            value, where = min(values)
            if value <= 0:
                return where
            step /= 4
        return None


# ---- elements ------------------------------------------------------------------------------------


def identity(degree):
    return [
        [Fraction(i, degree[0]), Fraction(j, degree[1]), Fraction(k, degree[2])]
        for k in range(degree[2] + 1)
        for j in range(degree[1] + 1)
        for i in range(degree[0] + 1)
    ]


def noise(rng, degree):
    return [[rng.uniform(-1, 1) / q for q in degree] for _ in identity(degree)]


def element(degree, shift, t=1.0, weights=None, offset=0.0):
    """Homogeneous float points of identity + t shift."""
    points = []
    for k, (p, d) in enumerate(zip(identity(degree), shift)):
        w = 1.0 if weights is None else weights[k]
        points.append([w * (float(c) + t * s + offset) for c, s in zip(p, d)] + [w])
    return points


def moebius(degree, factor):
    """Weights a^i b^j c^k: the same points of a shape at other parameters."""
    return [
        factor[0] ** i * factor[1] ** j * factor[2] ** k
        for k in range(degree[2] + 1)
        for j in range(degree[1] + 1)
        for i in range(degree[0] + 1)
    ]


def weights_of(rng, degree, kind):
    n = len(identity(degree))
    if kind == "mild":
        return [rng.uniform(0.5, 2.0) for _ in range(n)]
    if kind == "wild":
        return [10.0 ** rng.uniform(-3, 3) for _ in range(n)]
    return None


class CertifyElement(unittest.TestCase):
    def check(self, degree, points, start=None):
        """Soundness of whatever verdict is given; returns it."""
        result = LIBRARY.certify(degree, points)
        exact = Exact(degree, points)
        if result.verdict == POSITIVE:
            self.assertIsNone(exact.negative_point(start))
            self.assertGreaterEqual(result.smallest_bound, 0.0)
        elif result.verdict == NOT_POSITIVE:
            self.assertLessEqual(exact.at(result.u), 0)
        return result

    def test_good_elements_are_positive(self):
        rng = random.Random(SEED)
        for degree in DEGREES + [(9, 8, 3), (2, 2, 2)]:
            for kind in (None, "mild"):
                for offset in (0.0, 1e6):
                    amount = 0.15 if kind is None else 0.05
                    shift = noise(rng, degree)
                    points = element(degree, shift, amount, weights_of(rng, degree, kind), offset)
                    if kind == "mild":  # weights that move parameters: small moves for high degree
                        w = moebius(degree, [rng.uniform(0.8, 1.25) for _ in range(3)])
                        points = element(degree, shift, amount, w, offset)
                    with self.subTest(degree=degree, kind=kind, offset=offset):
                        self.assertEqual(self.check(degree, points).verdict, POSITIVE)

    def test_high_degrees_are_decided(self):
        rng = random.Random(SEED + 1)
        degree = (25, 25, 3)
        points = element(degree, noise(rng, degree), 0.1)
        result = LIBRARY.certify(degree, points)
        self.assertEqual(result.verdict, POSITIVE)
        points[0][0] += 1.0
        result = LIBRARY.certify(degree, points)
        self.assertEqual(result.verdict, NOT_POSITIVE)
        self.assertLessEqual(Exact(degree, points).at(result.u), 0)

    def test_random_elements(self):
        rng = random.Random(SEED + 2)
        seen = [0, 0, 0]
        for trial in range(60):
            degree = DEGREES[trial % len(DEGREES)]
            weights = weights_of(rng, degree, (None, "mild", "wild")[trial % 3])
            points = element(degree, noise(rng, degree), rng.choice((0.3, 0.6, 1.0, 2.0)), weights)
            seen[self.check(degree, points).verdict] += 1
        self.assertGreater(seen[POSITIVE], 5)
        self.assertGreater(seen[NOT_POSITIVE], 5)
        self.assertEqual(seen[UNDECIDED], 0, "%s" % seen)

    def flip(self, degree, make):
        """Largest t found positive and smallest found not positive, of t in [0, 8], to the last
        bits; both verdicts are checked exactly around the point given. Returns their distance."""
        low, high = 0.0, 8.0
        start = None
        self.assertEqual(LIBRARY.certify(degree, make(low)).verdict, POSITIVE)
        top = LIBRARY.certify(degree, make(high))
        if top.verdict != NOT_POSITIVE:
            return None
        not_positive = high
        for _ in range(60):
            middle = 0.5 * (low + high)
            if middle in (low, high):
                break
            result = LIBRARY.certify(degree, make(middle))
            if result.verdict == POSITIVE:
                low = middle
            else:
                high = middle
                if result.verdict == NOT_POSITIVE:
                    not_positive, start = middle, tuple(result.u)
        self.check(degree, make(low), start)
        self.check(degree, make(not_positive), start)
        return (not_positive - low) / not_positive

    def test_where_the_verdict_flips(self):
        rng = random.Random(SEED + 3)
        gaps = []
        for trial in range(25):
            degree = DEGREES[trial % 4]
            shift = noise(rng, degree)
            offset = (0.0, 1e6)[trial // 4 % 2]
            weights = None
            if trial // 8 % 2:
                weights = moebius(degree, [rng.uniform(0.8, 1.25) for _ in range(3)])
            gap = self.flip(degree, lambda t: element(degree, shift, t, weights, offset))
            if gap is not None and offset == 0.0:
                gaps.append(gap)
        self.assertGreater(len(gaps), 10)
        # between the verdicts lies what 24 bisections leave open, not more
        self.assertLess(max(gaps), 1e-2)

    def test_folded_at_a_corner_by_very_little(self):
        """Three tangents at a corner, the third at height delta over the plane of the others."""
        rng = random.Random(SEED + 4)
        for degree in DEGREES[:4]:
            for exponent in [None] + list(range(3, 17)):
                for sign in (1, -1):
                    delta = 0.0 if exponent is None else sign * 10.0**-exponent
                    points = element(degree, noise(rng, degree), 0.0)
                    n01 = (degree[0] + 1) * (degree[1] + 1)
                    a, b = rng.uniform(0.2, 0.3), rng.uniform(0.2, 0.3)
                    points[n01][:3] = [a / degree[0], b / degree[1], delta]
                    result = self.check(degree, points)
                    with self.subTest(degree=degree, delta=delta):
                        if delta <= 0.0:
                            self.assertEqual(result.verdict, NOT_POSITIVE)
                            self.assertEqual(tuple(result.u), (0.0, 0.0, 0.0))
                        elif exponent <= 10:
                            self.assertEqual(result.verdict, POSITIVE)

    def test_folded_at_a_turned_corner(self):
        """The same where every product is rounded: only the integers know the exact sign."""
        rng = random.Random(SEED + 5)
        signs = set()
        for trial in range(60):
            degree = DEGREES[trial % 4]
            points = element(degree, noise(rng, degree), 0.05, None, rng.choice((0.0, 1e6)))
            if trial % 2:
                weights = weights_of(rng, degree, "mild")
                points = [[c * w for c in p] for p, w in zip(points, weights)]
            n0, n01 = degree[0] + 1, (degree[0] + 1) * (degree[1] + 1)
            a, b, c, e = rng.random(), rng.random(), rng.random(), rng.choice((0.0, 1e-16, -1e-15))
            for x in range(4):  # P001 = P000 + combination of the two others, up to rounding
                origin = points[0][x]
                points[n01][x] = origin * c + a * points[1][x] + b * points[n0][x] + e
            if points[n01][3] <= 0.0:
                continue
            result = self.check(degree, points)
            sign = Exact(degree, points).at((0, 0, 0))
            signs.add((sign > 0) - (sign < 0))
            if sign <= 0:
                self.assertEqual(result.verdict, NOT_POSITIVE)
        self.assertLessEqual({-1, 1}, signs)

    def test_slow_points_inside(self):
        """x = (u - c)^3 + delta u: N has a double zero, or nearly so, on a plane inside."""
        for c in (Fraction(1, 2), Fraction(1, 3), Fraction(5, 7)):
            cubic = [-(c**3), c**2 * (1 - c), -c * (1 - c) ** 2, (1 - c) ** 3]
            for delta in [0.0] + [s * 10.0**-k for k in range(2, 17, 2) for s in (1, -1)]:
                points = element((3, 3, 3), noise(random.Random(0), (3, 3, 3)), 0.0)
                for k, p in enumerate(points):
                    p[0] = float(cubic[k % 4] + Fraction(delta) * (k % 4) / 3)
                result = self.check((3, 3, 3), points, (c, Fraction(1, 3), Fraction(1, 3)))
                with self.subTest(c=c, delta=delta):
                    if delta < -1e-5:
                        self.assertEqual(result.verdict, NOT_POSITIVE)
                    if delta > 1e-3:
                        self.assertEqual(result.verdict, POSITIVE)
                    if delta == 0.0 and c == Fraction(1, 2):
                        self.assertNotEqual(result.verdict, POSITIVE)

    def test_degenerate_elements_are_never_positive(self):
        degree = (3, 3, 3)
        rng = random.Random(SEED + 6)
        good = element(degree, noise(rng, degree), 0.1)
        point = [[0.3, 0.4, 0.5, 1.0]] * 64
        flat = [p[:2] + [0.0, 1.0] for p in good]
        slanted = [p[:2] + [p[0] + p[1], 1.0] for p in good]
        collapsed = [list(good[k % 16] if k < 32 else p) for k, p in enumerate(good)]
        mirrored = [[-p[0]] + p[1:] for p in good]
        edge = [list(p) for p in good]
        for k in range(4):
            edge[k] = list(good[0])
        for name, points in (
            ("point", point),
            ("flat", flat),
            ("slanted", slanted),
            ("collapsed", collapsed),
            ("mirrored", mirrored),
            ("edge", edge),
        ):
            with self.subTest(name=name):
                self.assertEqual(self.check(degree, points).verdict, NOT_POSITIVE)

    def test_wild_weights_of_a_good_shape(self):
        """Weights w^(i+j+k) from 1e-3 to 1e3: a change of parameters, so N > 0 stays."""
        for degree in DEGREES:
            factor = [10.0 ** (6.0 / sum(degree))] * 3
            weights = [w * 1e-3 for w in moebius(degree, factor)]
            points = element(degree, noise(random.Random(1), degree), 0.0, weights)
            with self.subTest(degree=degree):
                self.assertEqual(self.check(degree, points).verdict, POSITIVE)

    def test_verdict_does_not_depend_on_units_or_numbering(self):
        rng = random.Random(SEED + 7)
        degree = (3, 4, 2)
        for amount in (0.2, 0.8, 1.5):
            for kind in (None, "mild"):
                points = element(degree, noise(rng, degree), amount, weights_of(rng, degree, kind))
                base = LIBRARY.certify(degree, points)
                for power in (-300, -40, 40, 300):
                    scale = 2.0**power
                    scaled = [[c * scale for c in p[:3]] + p[3:] for p in points]
                    other = LIBRARY.certify(degree, scaled)
                    self.assertEqual(base.verdict, other.verdict)
                    self.assertEqual(base.depth, other.depth)
                    self.assertAlmostEqual(base.smallest_bound, other.smallest_bound, 9)
                turned = [  # u[0] reversed and x mirrored
                    [-points[i + 4 * m][0]] + points[i + 4 * m][1:]
                    for m in range(15)
                    for i in (3, 2, 1, 0)
                ]
                self.assertEqual(base.verdict, LIBRARY.certify(degree, turned).verdict)

    def test_bound_is_below_every_value(self):
        """smallest_bound <= det J / (mean edge lengths) on a grid; near it for a parallelepiped."""
        rng = random.Random(SEED + 8)
        for degree in DEGREES:
            for kind in (None, "mild"):
                shift = noise(rng, degree)
                w = None if kind is None else moebius(degree, (1.2, 0.9, 1.1))
                points = element(degree, shift, 0.1, w)
                result = LIBRARY.certify(degree, points)
                self.assertEqual(result.verdict, POSITIVE)
                self.assertLessEqual(result.smallest_bound, self.least_ratio(degree, points))
        result = LIBRARY.certify((3, 3, 3), element((3, 3, 3), noise(rng, (3, 3, 3)), 0.0))
        self.assertAlmostEqual(result.smallest_bound, 1.0, 9)

    @staticmethod
    def least_ratio(degree, points):
        n = [q + 1 for q in degree]

        def at(i, j, k):
            return points[i + n[0] * (j + n[1] * k)]

        def x(i, j, k):
            point = at(i, j, k)
            return [c / point[3] for c in point[:3]]

        product = 1.0
        for axis in range(3):
            total = 0.0
            for ends in itertools.product((0, 1), repeat=2):
                index = [0, 0, 0]
                others = [a for a in range(3) if a != axis]
                for a, e in zip(others, ends):
                    index[a] = e * degree[a]
                row = []
                for m in range(n[axis]):
                    index[axis] = m
                    row.append(x(*index))
                total += sum(math.dist(a, b) for a, b in zip(row, row[1:]))
            product *= total / 4
        exact = Exact(degree, points)
        grid = [Fraction(i, 4) for i in range(5)]
        least = math.inf
        scale = max(Fraction(c).denominator for p in points for c in p)
        for u in itertools.product(grid, repeat=3):
            basis = [bernstein(q, t)[0] for q, t in zip(degree, u)]
            weight = sum(
                basis[0][i] * basis[1][j] * basis[2][k] * Fraction(at(i, j, k)[3])
                for k in range(n[2])
                for j in range(n[1])
                for i in range(n[0])
            )
            weight /= math.prod(t.denominator**q for t, q in zip(u, degree))
            # `slope` leaves out the factor q of the derivative
            value = exact.scaled(u) / scale**4 * math.prod(degree) / weight**4
            least = min(least, float(value) / product)
        return least

    def test_bad_arguments(self):
        degree = (1, 1, 1)
        points = element(degree, noise(random.Random(0), degree), 0.0)
        for value in (math.nan, math.inf, -math.inf):
            bad = [list(p) for p in points]
            bad[3][1] = value
            self.assertEqual(LIBRARY.status(degree, bad)[0], 3)
        for weight in (0.0, -1.0):
            bad = [list(p) for p in points]
            bad[5][3] = weight
            self.assertEqual(LIBRARY.certify(degree, bad).verdict, NOT_POSITIVE)
        inner = element((2, 1, 1), noise(random.Random(0), (2, 1, 1)), 0.0)
        inner[1] = [c * -0.01 for c in inner[1]]  # W > 0 still: what is not shown is not assumed
        self.assertEqual(LIBRARY.certify((2, 1, 1), inner).verdict, NOT_POSITIVE)
        self.assertEqual(LIBRARY.status((0, 1, 1), points)[0], 2)
        self.assertEqual(LIBRARY.status((26, 1, 1), points)[0], 2)
        self.assertEqual(LIBRARY.status(degree, points, -1)[0], 2)
        self.assertEqual(LIBRARY.status(degree, points, 65)[0], 2)
        huge = [[c * 1e308 for c in p[:3]] + p[3:] for p in points]
        self.assertIn(self.check(degree, huge).verdict, (POSITIVE, UNDECIDED))

    def test_less_depth_proves_less(self):
        """The verdict at depth 1 may only be weaker than that at depth 24, never another one."""
        rng = random.Random(SEED + 9)
        weaker = 0
        for trial in range(40):
            points = element((3, 3, 3), noise(rng, (3, 3, 3)), 0.9)
            short = LIBRARY.certify((3, 3, 3), points, 1)
            full = LIBRARY.certify((3, 3, 3), points)
            self.assertLessEqual(short.depth, 1)
            weaker += short.verdict == UNDECIDED
            if short.verdict != UNDECIDED:
                self.assertEqual(short.verdict, full.verdict)
        self.assertGreater(weaker, 0)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
