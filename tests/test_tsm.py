#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""T-spline surfaces from .tsm: against a slow evaluator of its own (tsm_plane.py), against exact
knot insertion, at ends, creases and stars; files out and in; bad files."""

import os
import random
import re
import subprocess
import sys
import tempfile
import time
import unittest

import binding_parts
import tsm_plane
from binding_parts import ROOT, binding, library
from freecad.tsolid.surface import Surface
from tsm_plane import Mesh, PlaneSurface, bspline

DATA = os.path.join(os.path.dirname(ROOT), "shared", "data")


def sample(name):
    path = os.path.join(DATA, name)
    if not os.path.exists(path):
        raise unittest.SkipTest("%s is not there" % path)
    return path


def blossom(knots, span, x):
    """{i: value} of the polynomials of all cubic B-splines on [knots[span], knots[span+1]]."""
    found = {}
    for i in range(span - 3, span + 1):
        d = [1.0 if k == i else 0.0 for k in range(span - 3, span + 1)]
        for r in range(1, 4):
            for j in range(3, r - 1, -1):
                low, high = knots[span - 3 + j], knots[span + j - r + 1]
                t = (x[r - 1] - low) / (high - low)
                d[j] = (1 - t) * d[j - 1] + t * d[j]
        found[i] = d[3]
    return found


def refined(knots, local):
    """How the function with these local knots takes its coefficient from the coarse ones."""
    for a in (2, 1, 3, 0):
        if local[a + 1] > local[a]:
            middle = 0.5 * (local[a] + local[a + 1])
            break
    span = max(k for k in range(3, len(knots) - 4) if knots[k] <= middle)
    return blossom(knots, span, local[1:4])


def tensor_point(knots, net, x, y):
    out = [0.0] * 3
    for (i, j), c in net.items():
        value = bspline(knots[0][i : i + 5], x)
        value = value and value * bspline(knots[1][j : j + 5], y)
        out = [w + value * z for w, z in zip(out, c)]
    return out


def distance(a, b):
    return max(abs(x - y) for x, y in zip(a, b))


class SurfaceTest(unittest.TestCase):
    def setUp(self):
        self.context = binding.Context(library=library.load(binding_parts.library_path()))
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name="part.tsm"):
        return os.path.join(self.folder.name, name)

    def load(self, text, name="part.tsm"):
        data = text if isinstance(text, bytes) else text.encode()
        with open(self.path(name), "wb") as stream:
            stream.write(data)
        return Surface.read(self.context, self.path(name))

    def compare(self, surface, twin, rng, per_face=4, sums=True):
        """At random points of every face; returns the largest distance relative to the size."""
        scale = max(abs(c) for p in twin.grips.values() for c in p)
        worst = 0.0
        for number, face in enumerate(sorted(twin.faces)):
            size = surface.face_sizes[number, 0], surface.face_sizes[number, 1]
            for _ in range(per_face):
                u, v = (s * rng.uniform(0.01, 0.99) for s in size)
                mine = surface.evaluate(self.context, number, u, v)[0]
                worst = max(worst, distance(mine, twin.point(face, u, v)) / scale)
        return worst


class SamplesTest(SurfaceTest):
    def check_sample(self, name):
        path = sample(name)
        with open(path, "rb") as stream:
            text = stream.read().decode("latin-1")
        surface, twin = Surface.read(self.context, path), PlaneSurface(text)
        self.assertLess(self.compare(surface, twin, random.Random(1)), 1e-14)
        with self.assertRaises(binding.Refused) as caught:
            binding.Boundary.from_surface(self.context, surface)
        self.assertIn("open", str(caught.exception))
        self.assertEqual(caught.exception.requirement["closed"], 0)
        return surface

    def test_simple(self):
        surface = self.check_sample("simple.tsm")
        facts = surface.facts()
        counts = [facts[n] for n in ("faces", "t_junctions", "boundary_loops", "points")]
        self.assertEqual(counts, [3, 1, 1, 23])
        self.assertLess(facts["sum_defect"], 1e-15)

    def test_simple_against_knot_insertion(self):
        """Control abscissae are the Greville points 0, 5, 15, 25, 30. Above the T-junction the two
        upper rows have four points: cubics without an inner knot, so that inserting it gives the
        full 5 x 5 net of a B-spline surface, which is the surface."""
        surface = Surface.read(self.context, sample("simple.tsm"))
        with open(sample("simple.tsm"), encoding="utf-8") as stream:
            twin = PlaneSurface(stream.read())
        knots = [0.0] * 4 + [0.5] + [1.0] * 4
        greville = [30 * sum(knots[i + 1 : i + 4]) / 3 for i in range(5)]
        net = {}
        for point in twin.grips.values():
            near = [min(range(5), key=lambda k: abs(greville[k] - c)) for c in point[:2]]
            self.assertLess(distance([greville[k] for k in near], point), 1e-12)
            net[tuple(near)] = point[:3]
        missing = {(i, j) for i in range(5) for j in range(5)} - set(net)
        self.assertEqual(missing, {(2, 3), (2, 4)})
        for j in (3, 4):
            b = [net[i, j] for i in (0, 1, 3, 4)]
            for i in (1, 2, 3):
                net[i, j] = tuple((x + y) / 2 for x, y in zip(b[i - 1], b[i]))
        rng = random.Random(2)
        for face in sorted(twin.faces):
            for _ in range(20):
                u, v = (s * rng.random() for s in surface.face_sizes.tolist()[face])
                x, y = self.simple_parameters(twin, face, u, v)
                want = [0.0] * 3
                for (i, j), c in net.items():
                    value = bspline(knots[i : i + 5], x) * bspline(knots[j : j + 5], y)
                    want = [w + value * z for w, z in zip(want, c)]
                got = surface.evaluate(self.context, face, u, v)[0]
                self.assertLess(distance(got, want), 1e-13)

    @staticmethod
    def simple_parameters(twin, face, u, v):
        """From a face to the whole square, by the positions of its corners' control points."""
        k, (x, y) = twin.frame[face]
        c, s = tsm_plane.TURN[k]
        at = (x + c * u - s * v, y + s * u + c * v)
        corners = {}
        for vertex, place in twin.place.items():
            px, py = twin.grips[twin.block[vertex][0, 0]][:2]
            if px in (0, 30) and py in (0, 30):
                corners[px / 30, py / 30] = place
        origin, ex, ey = (corners[c] for c in ((0, 0), (1, 0), (0, 1)))
        d = [at[n] - origin[n] for n in (0, 1)]
        return (
            sum(d[n] * (ex[n] - origin[n]) for n in (0, 1)),
            sum(d[n] * (ey[n] - origin[n]) for n in (0, 1)),
        )

    def test_mouse(self):
        facts = self.check_sample("mouse.tsm").facts()
        self.assertEqual((facts["faces"], facts["t_junctions"]), (12, 6))

    def test_gearbox(self):
        facts = self.check_sample("gearbox2-9.tsm").facts()
        self.assertEqual((facts["faces"], facts["t_junctions"]), (94, 56))

    def test_round_trip(self):
        for name in ("simple", "mouse", "gearbox2-9", "closed_box"):
            surface = Surface.read(self.context, sample(name + ".tsm"))
            again = check_round_trip(self, surface)
            mine, given = (numbers_of(p) for p in (again, sample(name + ".tsm")))
            self.assertEqual(mine, given)

    def test_closed_box_becomes_a_solid(self):
        surface = Surface.read(self.context, sample("closed_box.tsm"))
        facts = surface.facts()
        self.assertEqual([x[1] for x in facts["extraordinary"]], [3] * 8)
        boundary = binding.Boundary.from_surface(self.context, surface)
        self.assertEqual(boundary.requirement["satisfied"], 1)
        self.assertEqual(boundary.requirement["n_patches"], 28)
        space = binding.Space.create(
            self.context, boundary, binding.TMesh.create(self.context, boundary)
        )
        solid = binding.Solid.create(self.context, space).optimised(self.context)
        certificate = binding.Certificate.of(self.context, solid)
        self.assertEqual(certificate.verdict, binding.Verdict.POSITIVE)


def numbers_of(path):
    """The records of a file as words and numbers, without comments."""
    found = []
    with open(path, "rb") as stream:
        for line in stream.read().decode("latin-1").splitlines():
            words = line.split("#")[0].split()
            if words and (found or words[0] != "units"):
                rest = [float(w) if re.match(r"^[-+\d.]", w) else w for w in words[1:]]
                found.append(words[:1] + rest)
    return [row for row in found if row[0] in ("f", "e", "v", "l", "ec", "0m", "0g")]


def check_round_trip(test, surface):
    first, second = test.path("first.tsm"), test.path("second.tsm")
    surface.write_tsm(test.context, first)
    again = Surface.read(test.context, first)
    again.write_tsm(test.context, second)
    with open(first, "rb") as a, open(second, "rb") as b:
        test.assertEqual(a.read(), b.read())
    test.assertEqual(again.points.tolist(), surface.points.tolist())
    test.assertEqual(again.facts(), surface.facts())
    for face in range(surface.facts()["faces"]):
        test.assertEqual(again.elements(face), surface.elements(face))
    return first


class GeneratedTest(SurfaceTest):
    """Open T-meshes made here."""

    @staticmethod
    def values(rng, n):
        out = [0.0]
        for _ in range(n):
            out.append(out[-1] + rng.choice((0.25, 0.5, 1.0, rng.uniform(0.2, 2.0))))
        return out

    @staticmethod
    def random_point(rng):
        points = {}

        def place(p, i, j):
            key = (p, i, j)
            if key not in points:
                points[key] = tuple(rng.uniform(-3, 3) for _ in range(3)) + (rng.uniform(0.5, 2),)
            return points[key]

        return place

    @staticmethod
    def split(rng, boxes, axes, count):
        boxes = list(boxes)
        for _ in range(count):
            k, axis = rng.randrange(len(boxes)), rng.choice(axes)
            b = boxes[k]
            low, high = b[2 * axis], b[2 * axis + 1]
            if high - low > 1:
                at = rng.randrange(low + 1, high)
                first, second = list(b), list(b)
                first[2 * axis + 1] = second[2 * axis] = at
                boxes[k] = tuple(first)
                boxes.append(tuple(second))
        return boxes

    def test_any_t_mesh(self):
        """Any tiling by boxes, analysis-suitable or not, rational, against the slow evaluator."""
        n_bad = 0
        for seed in range(25):
            rng = random.Random(seed)
            values = [self.values(rng, rng.randrange(2, 9)) for _ in (0, 1)]
            boxes = self.split(rng, [(0, len(values[0]) - 1, 0, len(values[1]) - 1)], (0, 1), 14)
            text = Mesh(values, boxes).text(self.random_point(rng), shuffle=rng.randrange)
            surface, twin = self.load(text), PlaneSurface(text)
            self.assertLess(self.compare(surface, twin, rng, 3), 1e-13, seed)
            largest = max(
                abs(twin.sum(f, *(0.37 * s for s in surface.face_sizes.tolist()[f])) - 1)
                for f in twin.faces
            )
            self.assertLessEqual(largest, surface.facts()["sum_defect"] + 1e-14)
            n_bad += surface.facts()["sum_defect"] > 1e-6
            check_round_trip(self, surface)
            self.check_patches(surface)
        self.assertGreater(n_bad, 3)  # both kinds came along
        self.assertLess(n_bad, 25)

    def check_patches(self, surface):
        """The patches cover the parameters of all faces, and their corners are corners of elements
        (the library itself compares every patch with the elements that it is made of)."""
        patches = surface.patches(self.context)
        self.assertLessEqual(len(patches), surface.facts()["elements"])
        area = sum(a * b for a, b in surface.face_sizes.tolist())
        lengths = [[k[-1] - k[0] for k in p.knots] for p in patches]
        mine = sum(a * b for a, b in lengths)
        self.assertAlmostEqual(area, mine, delta=1e-9 * area)
        corners = [c for p in patches for c in (p.points[0], p.points[-1])]
        own = []
        for face in range(surface.facts()["faces"]):
            for e in surface.elements(face):
                for u in e.box[:2]:
                    for v in e.box[2:]:
                        own.append(surface.evaluate(self.context, face, u, v)[0])
        for c in corners:
            self.assertLess(min(distance(c, x) for x in own), 1e-11)

    def test_knots_inserted_exactly(self):
        """A coarse tensor product surface with partial lines inserted: nothing moves."""
        counts = [self.check_insertion(random.Random(100 + seed)) for seed in range(12)]
        self.assertLess(sum(c[0] for c in counts), sum(c[1] for c in counts))

    def check_insertion(self, rng):
        axis = rng.randrange(2)  # lines across this axis are inserted
        coarse = [self.values(rng, rng.randrange(1, 4)) for _ in (0, 1)]
        fine = [list(c) for c in coarse]
        for a, b in zip(coarse[axis], coarse[axis][1:]):
            fine[axis] += [a + (b - a) * t for t in (0.25, 0.5, 0.75)]
        fine[axis].sort()
        step = [4 if d == axis else 1 for d in (0, 1)]
        boxes = []
        for i in range(len(coarse[0]) - 1):
            for j in range(len(coarse[1]) - 1):
                box = (i * step[0], (i + 1) * step[0], j * step[1], (j + 1) * step[1])
                boxes += self.split(rng, [box], (axis,), rng.randrange(4))
        knots = [[c[0]] * 3 + c + [c[-1]] * 3 for c in coarse]
        net = {
            (i, j): [sum(knots[0][i + 1 : i + 4]) / 3, sum(knots[1][j + 1 : j + 4]) / 3]
            + [rng.uniform(-2, 2)]
            for i in range(len(knots[0]) - 4)
            for j in range(len(knots[1]) - 4)
        }
        mesh = Mesh(fine, boxes)
        twin = PlaneSurface(mesh.text(lambda p, i, j: (0, 0, 0, 1)))
        coefficient = {}
        for grip, local, _ in twin.functions:
            a, b = refined(knots[0], local[0]), refined(knots[1], local[1])
            coefficient[grip] = tuple(
                sum(x * y * net[i, j][d] for i, x in a.items() for j, y in b.items())
                for d in range(3)
            )
        order = iter(sorted(coefficient))
        surface = self.load(mesh.text(lambda p, i, j: coefficient[next(order)] + (1,)))
        self.assertLess(surface.facts()["sum_defect"], 1e-14)
        for face, box in enumerate(boxes):
            for _ in range(3):
                u, v = (rng.random() * s for s in surface.face_sizes.tolist()[face])
                x, y = fine[0][box[0]] + u, fine[1][box[2]] + v
                got = surface.evaluate(self.context, face, u, v)[0]
                self.assertLess(distance(got, tensor_point(knots, net, x, y)), 2e-14)
        self.check_patches(surface)
        patches = surface.patches(self.context)
        for patch in patches:  # x and y are the parameters
            n = patch.n_control
            own = {(k % n[0], k // n[0]): p for k, p in enumerate(patch.points)}
            for _ in range(10):
                x, y = (rng.uniform(k[0], k[-1]) for k in patch.knots)
                got = tensor_point(patch.knots, own, x, y)
                self.assertIsNone(patch.weights)
                self.assertLess(distance(got, tensor_point(knots, net, *got[:2])), 1e-12)
        return len(patches), len(boxes)

    def natural(self, values, net):
        """Bezier-free ends: the control net mirrored beyond the border, knots too."""
        knots, n = [], [len(v) for v in values]
        for v in values:
            low = [2 * v[0] - v[min(k, len(v) - 1)] for k in (3, 2, 1)]
            high = [2 * v[-1] - v[max(-1 - k, -len(v))] for k in (1, 2, 3)]
            knots.append(low + v + high)
        full = {}
        for i in range(-1, n[0] + 1):
            for j in range(-1, n[1] + 1):
                full[i, j] = self.mirrored(net, n, i, j)

        def point(x, y):
            out = [0.0] * 3
            for (i, j), c in full.items():
                tx, ty = knots[0][i + 1 : i + 6], knots[1][j + 1 : j + 6]
                value = bspline(tx, x) * bspline(ty, y)
                out = [o + value * z for o, z in zip(out, c)]
            return out

        return point

    def mirrored(self, net, n, i, j):
        if i in (-1, n[0]):
            edge, inner = (0, 1) if i < 0 else (n[0] - 1, n[0] - 2)
            a, b = self.mirrored(net, n, edge, j), self.mirrored(net, n, inner, j)
            return [2 * x - y for x, y in zip(a, b)]
        if j in (-1, n[1]):
            edge, inner = (0, 1) if j < 0 else (n[1] - 1, n[1] - 2)
            return [2 * x - y for x, y in zip(net[i, edge], net[i, inner])]
        return net[i, j]

    def grid(self, values):
        n = [len(v) - 1 for v in values]
        return [(i, i + 1, j, j + 1) for i in range(n[0]) for j in range(n[1])]

    def test_natural_ends(self):
        """No further control points at the border: the net mirrored at it."""
        for seed in range(6):
            rng = random.Random(seed)
            values = [self.values(rng, rng.randrange(2, 6)) for _ in (0, 1)]
            net = {
                (i, j): [rng.uniform(-2, 2) for _ in range(3)]
                for i in range(len(values[0]))
                for j in range(len(values[1]))
            }
            mesh = Mesh(values, self.grid(values))
            surface = self.load(mesh.text(lambda p, i, j: tuple(net[p]) + (1,), ends=False))
            self.assertLess(surface.facts()["sum_defect"], 1e-14)
            point = self.natural(values, net)
            for face, box in enumerate(mesh.boxes):
                u, v = (rng.random() * s for s in surface.face_sizes.tolist()[face])
                want = point(values[0][box[0]] + u, values[1][box[2]] + v)
                got = surface.evaluate(self.context, face, u, v)[0]
                self.assertLess(distance(got, want), 1e-13)
            corner = surface.evaluate(self.context, 0, 0.0, 0.0)[0]
            self.assertLess(distance(corner, net[0, 0]), 1e-14)

    def test_crease(self):
        """A line of end conditions: both parts are as if alone."""
        rng = random.Random(5)
        values = [[0.0, 1.0, 1.5, 3.5, 4.0], [0.0, 2.0, 3.0, 3.5]]
        net = {
            (i, j): [rng.uniform(-2, 2) for _ in range(3)] for i in range(5) for j in range(4)
        }
        mesh = Mesh(values, self.grid(values))
        creases = [((2, j), (2, j + 1)) for j in range(3)]
        text = mesh.text(lambda p, i, j: tuple(net[p]) + (1,), ends=False, creases=creases)
        surface = self.load(text)
        low = self.natural([values[0][:3], values[1]], net)
        high_net = {(i - 2, j): c for (i, j), c in net.items() if i >= 2}
        high = self.natural([values[0][2:], values[1]], high_net)
        for face, box in enumerate(mesh.boxes):
            for _ in range(5):
                u, v = (rng.random() * s for s in surface.face_sizes.tolist()[face])
                x, y = values[0][box[0]] + u, values[1][box[2]] + v
                want = (low if box[0] < 2 else high)(x, y)
                got = surface.evaluate(self.context, face, u, v)[0]
                self.assertLess(distance(got, want), 1e-13)


class StarTest(SurfaceTest):
    """Boxes of quads with eight stars."""

    def box(self, n, widths, rng=None):
        vertices, quads = tsm_plane.box_quads(n)

        def interval(p, q):
            a, b = vertices[p], vertices[q]
            axis = next(d for d in range(3) if a[d] != b[d])
            return widths[axis][min(a[axis], b[axis])]

        points = [[sum(widths[d][: p[d]]) for d in range(3)] for p in vertices]
        if rng:
            points = [[c + rng.uniform(-0.1, 0.1) for c in p] for p in points]
        return self.load(tsm_plane.quad_file(points, quads, interval)), vertices, quads, points

    def test_tensor_where_no_star_is(self):
        """It is the B-spline of its net but for as many rings of faces round stars as the note
        says: one where the intervals of their edges are equal, else two."""
        for rings in (1, 2):
            rng = random.Random(3)
            widths = [[rng.uniform(0.5, 2) for _ in range(7)] for _ in range(3)]
            if rings == 1:
                widths = [[1.0] + w[1:6] + [1.0] for w in widths]
            self.context.clear()
            box = self.box((7, 7, 7), widths, rng)
            worst = self.from_tensor(box, widths, rng)
            self.assertLess(max(worst[rings:]), 1e-13)
            if rings == 2:
                self.assertGreater(worst[1], 1e-5)
            (note,) = self.context.findings()
            self.assertEqual(note.severity, binding.Severity.NOTE)
            named = r"Round vertices( \d+,){6} \d+ and \d+ \(three edges each\)"
            self.assertRegex(note.text, named)
            self.assertIn("within %s of faces" % ("one ring", "two rings")[rings - 1], note.text)

    def from_tensor(self, box, widths, rng):
        """Largest distance from the B-spline, by rings round the nearest star."""
        surface, vertices, quads, points = box
        at = {v: p for v, p in zip(vertices, points)}
        knots = [[sum(w[:k]) for k in range(8)] for w in widths]
        worst = [0.0] * 4
        for face, quad in enumerate(quads):
            corner = [vertices[k] for k in quad]
            axis = next(d for d in range(3) if len({c[d] for c in corner}) == 1)
            a, b = (d for d in range(3) if d != axis)
            i, j = (min(c[d] for c in corner) for d in (a, b))
            if {i, j} <= {0, 6}:
                continue
            size = surface.face_sizes.tolist()[face]
            u, v = (s * rng.random() for s in size)
            x = [c for c in self.bilinear(corner, knots, u / size[0], v / size[1])]
            inwards = 1 if corner[0][axis] == 0 else -1
            beyond = widths[axis][::inwards][:3]
            want = [0.0] * 3
            for k in range(i - 1, i + 3):
                for m in range(j - 1, j + 3):
                    p = [0, 0, 0]
                    p[a], p[b] = min(max(k, 0), 7), min(max(m, 0), 7)
                    p[axis] = corner[0][axis] + inwards * (abs(p[a] - k) + abs(p[b] - m))
                    value = self.local(knots[a], k, x[a], beyond)
                    value *= self.local(knots[b], m, x[b], beyond)
                    want = [w + value * c for w, c in zip(want, at[tuple(p)])]
            got = surface.evaluate(self.context, face, u, v)[0]
            ring = max(min(k, 6 - k) for k in (i, j))
            worst[ring] = max(worst[ring], distance(got, want))
        return worst

    @staticmethod
    def bilinear(corner, knots, s, t):
        weights = ((1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t)
        return [sum(w * knots[d][c[d]] for w, c in zip(weights, corner)) for d in range(3)]

    @staticmethod
    def local(line, k, x, beyond):
        """beyond: three intervals of the sides across, from the isoline on."""
        steps = [sum(beyond[:n]) for n in (1, 2, 3)]
        wide = [line[0] - s for s in steps[::-1]] + line + [line[-1] + s for s in steps]
        return bspline(wide[k + 1 : k + 6], x)

    def test_star_points_by_hand(self):
        """Equal intervals: the star's point is the mean of three face points (4, 2, 2, 1) / 9."""
        surface, vertices, quads, points = self.box((2, 3, 4), [[1.0] * 2, [1.0] * 3, [1.0] * 4])
        n_stars = 0
        for face, quad in enumerate(quads):
            for k in range(4):
                around = [q for q in quads if quad[k] in q]
                if len(around) != 3:
                    continue
                want = [0.0] * 3
                for q in around:
                    m = q.index(quad[k])
                    for step, weight in ((0, 4), (1, 2), (2, 1), (3, 2)):
                        p = points[q[(m + step) % 4]]
                        want = [w + weight / 27 * c for w, c in zip(want, p)]
                u, v = ((0, 0), (1, 0), (1, 1), (0, 1))[k]
                got = surface.evaluate(self.context, face, u, v)[0]
                self.assertLess(distance(got, want), 1e-14)
                n_stars += 1
        self.assertEqual(n_stars, 24)

    def test_stars_hold_together(self):
        """Unequal intervals, noisy points: one point on every edge from both sides, one tangent
        plane at every star, sum one."""
        rng = random.Random(8)
        for n in ((1, 1, 1), (1, 2, 1), (2, 2, 2), (3, 1, 4)):
            widths = [[rng.uniform(0.3, 3) for _ in range(k)] for k in n]
            surface, _, quads, _ = self.box(n, widths, rng)
            self.assertLess(surface.facts()["sum_defect"], 1e-14)
            self.assertEqual(len(surface.facts()["extraordinary"]), 8)
            seen, normals = {}, {}
            for face, quad in enumerate(quads):
                size = surface.face_sizes.tolist()[face]
                for k in range(4):
                    p, q = quad[k], quad[(k + 1) % 4]
                    for t in (0.0, 0.25, 0.5, 0.9):
                        at = t if p < q else 1 - t
                        u, v = ((at, 0), (1, at), (1 - at, 1), (0, 1 - at))[k]
                        x = self.context, face, u * size[0], v * size[1], 1
                        point, du, dv = surface.evaluate(*x)
                        key = (min(p, q), max(p, q), t)
                        if key in seen:
                            self.assertLess(distance(point, seen[key]), 1e-13)
                        seen[key] = point
                        if len([f for f in quads if p in f]) == 3 and at == 0:
                            normal = [
                                du[(d + 1) % 3] * dv[(d + 2) % 3]
                                - du[(d + 2) % 3] * dv[(d + 1) % 3]
                                for d in range(3)
                            ]
                            length = sum(c * c for c in normal) ** 0.5
                            normals.setdefault(p, []).append([c / length for c in normal])
            for found in normals.values():
                self.assertGreaterEqual(len(found), 1)
                for normal in found:
                    self.assertLess(distance(normal, found[0]), 1e-9)

    def test_smoothness_round_stars(self):
        """Across edges with an end at a star C^0; C^2 across those opposite it; farther out C^1,
        and C^2 where the intervals of the spokes are equal. By derivatives from both sides."""
        rng = random.Random(4)
        for equal in (True, False):
            widths = [[1.0 if equal else rng.uniform(0.4, 2) for _ in range(4)] for _ in range(3)]
            surface, _, quads, _ = self.box((4, 4, 4), widths, rng)
            valence = {p: len([q for q in quads if p in q]) for q in quads for p in q}
            worst = {}
            owner = {
                (q[k], q[(k + 1) % 4]): (f, k) for f, q in enumerate(quads) for k in range(4)
            }
            for (p, q), (f, k) in owner.items():
                g, m = owner[q, p]
                at_star = 3 in (valence[p], valence[q])
                touching = any(valence[x] == 3 for x in quads[f] + quads[g])
                for t in (0.1, 0.5, 0.8):
                    a, b = self.across(surface, f, k, t), self.across(surface, g, m, 1 - t)
                    for order in (1, 2):
                        sign = 1 if order == 2 else -1
                        jump = distance(a[order], [sign * c for c in b[order]])
                        key = (at_star, touching, order)
                        worst[key] = max(worst.get(key, 0.0), jump)
            self.assertGreater(worst[True, True, 1], 1e-3)
            for key in ((False, True, 1), (False, True, 2), (False, False, 1)):
                self.assertLess(worst[key], 1e-10, key)
            if equal:
                self.assertLess(worst[False, False, 2], 1e-10)

    @staticmethod
    def across(surface, face, side, t):
        """Point, first and second derivative inwards at t along a side, from the Bezier points."""
        (element,) = surface.elements(face)
        points, size = surface.points, surface.face_sizes[face, 1 - side % 2]
        out = []
        for order, weights in enumerate(([1], [-3, 3], [6, -12, 6])):
            total = [0.0] * 3
            for r, weight in enumerate(weights):
                for a in range(4):
                    i, j = ((a, r), (3 - r, a), (3 - a, 3 - r), (r, 3 - a))[side]
                    b = (1, 3, 3, 1)[a] * t**a * (1 - t) ** (3 - a) * weight / size**order
                    for f, c in zip(element.functions, element.coefficients):
                        for d in range(3):
                            total[d] += b * c[i + 4 * j] * points[f, d]
            out.append(total)
        return out

    def test_findings_name_vertices(self):
        """A note about one star, and a refusal that a vertex is the place of."""
        values = [[0.0, 1.0, 2.0], [0.0, 1.0, 2.0]]
        boxes = [(0, 1, 0, 1), (1, 2, 0, 1), (0, 1, 1, 2)]
        text = Mesh(values, boxes).text(lambda p, i, j: (p[0], p[1], p[0] * p[1], 1), ends=False)
        surface = self.load(text)
        (note,) = self.context.findings()
        self.assertEqual(note.entity, binding.Entity.ENTITY_SURFACE_VERTEX)
        self.assertEqual(note.where, "vertex %d" % note.index[0])
        self.assertIn("Round vertex %d (four edges)" % note.index[0], note.text)
        self.assertIn("within one ring", note.text)
        with self.assertRaises(binding.Refused) as caught:
            binding.Boundary.from_surface(self.context, surface)
        (finding,) = caught.exception.findings
        self.assertEqual(finding.entity, binding.Entity.ENTITY_SURFACE_VERTEX)
        self.assertEqual(finding.where, "vertex %d" % finding.index[0])
        corners = [surface.evaluate(self.context, 0, u, v)[0] for u in (0, 1) for v in (0, 1)]
        self.assertIn(note.point, [tuple(c) for c in corners])

    def test_t_junction_too_near_is_refused_by_name(self):
        """A quad cut in two: near a corner it is refused, far from all eight it is taken."""
        vertices, quads = tsm_plane.box_quads((9, 9, 9))
        taken = refused = 0
        for face in range(0, len(quads) // 2, 7):
            points, cut, joints = tsm_plane.split_quad([list(p) for p in vertices], quads, face)

            def interval(p, q, points=points):
                return sum(abs(x - y) for x, y in zip(points[p], points[q]))

            corner = [vertices[k] for k in quads[face]]
            axis = next(d for d in range(3) if len({c[d] for c in corner}) == 1)
            depth = min(
                max(min(c[d], 9 - c[d]) for d in range(3) if d != axis) for c in corner
            )
            try:
                surface = self.load(tsm_plane.quad_file(points, cut, interval, joints))
            except binding.TsolidError as error:
                self.assertRegex(
                    str(error), r"T-junction at vertex (729|\d+) is too near to the star at vertex"
                )
                refused += 1
                self.assertLess(depth, 4)
            else:
                self.assertLess(surface.facts()["sum_defect"], 1e-14)
                self.assertEqual(surface.facts()["t_junctions"], 2)
                taken += 1
        self.assertGreater(taken, 0)
        self.assertGreater(refused, 0)


class BadTest(SurfaceTest):
    def good(self):
        values = [[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0]]
        boxes = [(0, 3, 0, 1), (0, 1, 1, 2), (1, 2, 1, 2), (2, 3, 1, 2)]
        return Mesh(values, boxes).text(lambda p, i, j: (p[0], p[1], 0, 1))

    def check_refused(self, text, words):
        with self.assertRaises(binding.TsolidError) as caught:
            self.load(text)
        self.assertRegex(str(caught.exception), words)

    def change(self, kind, number, column, value):
        lines, n = self.good().split("\n"), -1
        for k, line in enumerate(lines):
            words = line.split()
            if words and words[0] == kind:
                n += 1
                if n == number:
                    words[column] = value
                    lines[k] = " ".join(words)
        return "\n".join(lines)

    def test_bad_records(self):
        cases = (
            (("e", 1, 2, "-1"), r"Edge 1 \(line \d+\).*negative"),
            (("e", 1, 2, "nan"), "not a number"),
            (("e", 1, 2, "1e999"), "too large"),
            (("e", 1, 2, "1.5"), r"Face \d+.*opposite sides"),
            (("l", 2, 1, "9999"), r"line \d+: a number of a record that does not exist"),
            (("l", 2, 2, "2"), r"Link \d+ \(line \d+\)"),
            (("l", 2, 3, "2"), r"Link \d+ \(line \d+\).*opposite"),
            (("l", 2, 4, "0"), r"Link \d+|Vertex \d+"),
            (("l", 2, 5, "3"), r"Link \d+ .*different faces"),
            (("l", 1, 7, "1"), r"Face 0 \(line \d+\) has less than four"),
            (("l", 0, 7, "7"), "out of range"),
            (("f", 1, 1, "0"), r"Face 1 \(line \d+\) names a link of another face"),
            (("v", 1, 1, "0"), r"Vertex 1 \(line \d+\) names a link that starts elsewhere"),
            (("v", 1, 2, "UP"), "not one of NORTH"),
            (("0g", 3, 4, "0"), "weight"),
            (("0g", 3, 1, "inf"), "not a number"),
            (("degree", 0, 1, "2"), "degree 2"),
            (("0m", 2, 2, "77"), r"line \d+"),
        )
        self.load(self.good())
        for change, words in cases:
            with self.subTest(change):
                self.check_refused(self.change(*change), words)

    def test_intervals_too_different(self):
        """Refused where positions could not be told apart; up to there the sum stays one."""
        for small, words in ((1e-5, None), (1e-9, r"edges \d+ and \d+")):
            values = [[0.0] + [small * k for k in range(1, 20)] + [1.0, 2.0], [0.0, small, 1.0]]
            boxes = [(i, i + 1, j, j + 1) for i in range(21) for j in range(2)]
            text = Mesh(values, boxes).text(lambda p, i, j: (p[0], p[1], 0, 1))
            if words:
                self.check_refused(text, words)
            else:
                self.assertLess(self.load(text).facts()["sum_defect"], 1e-9)

    def test_bad_files(self):
        good = self.good()
        self.check_refused(good.replace("#TS0200", "TS"), "line 1")
        self.check_refused("#TS0200\n", "degree")
        self.check_refused("#TS0200\ndegree 3\n", "no faces")
        self.check_refused(re.sub(r"(?m)^l 0.*$", "l", good), "deleted")
        self.check_refused(re.sub(r"(?m)^0m cg.*\n", "", good), "stands in no cg record")
        self.check_refused(re.sub(r"(?m)^0m gvp.*\n", "", good, 1), "not as long as")
        lines = good.split("\n")
        for length in range(0, len(lines), 3):
            text = "\n".join(lines[:length])
            if "0g" in text and text.count("\n0g") == good.count("\n0g"):
                continue
            self.check_refused(text, ".")

    def test_harmless_variety(self):
        good = self.good()
        want = self.load(good)
        odd = b"#TS0200 \xd7\xa2\xca\xcd\r\n" + b"".join(
            line.encode() + b"  # \xff\xfe comment\r\n\r\n" for line in good.split("\n")[1:]
        )
        got = self.load(odd)
        self.assertEqual(got.points.tolist(), want.points.tolist())
        self.assertEqual(got.facts(), want.facts())
        check_round_trip(self, got)
        slots = re.sub(r"(?m)^(f 0 0)$", r"\1", good)
        shifted = self.load(slots + "f\ne\nv\nl\n0g\n0m gv -1\n")
        self.assertEqual(shifted.facts(), want.facts())
        check_round_trip(self, shifted)

    def test_zero_bytes(self):
        """One in a line that is kept as text does not cut off what follows when written."""
        good = self.good()
        for word, rest in ((b"units", b" 1 meters"), (b"cap-type", b" 1"), (b"tol", b" 1e-05")):
            with self.subTest(word):
                text = good.encode().replace(b"\n" + word + b" ", b"\n" + word + b"\0 ")
                self.assertIn(b"\0", text)
                self.load(text).write_tsm(self.context, self.path("out.tsm"))
                with open(self.path("out.tsm"), "rb") as stream:
                    written = stream.read()
                self.assertNotIn(b"\0", written)
                self.assertIn(b"\n" + word + b" " + rest + b"\n", written)
                for line in (b"cap-type", b"star-smoothness 0", b"units", b"tol", b"ver 904"):
                    self.assertIn(b"\n" + line, written)
                self.load(written)

    def test_a_million_records(self):
        """Large and sound, then cyclic: seconds, not minutes."""
        n = 200
        values = [[float(k) for k in range(n + 1)]] * 2
        boxes = [(i, i + 1, j, j + 1) for i in range(n) for j in range(n)]
        text = Mesh(values, boxes).text(lambda p, i, j: (p[0] + i / 3, p[1] + j / 3, 0, 1))
        self.assertGreater(text.count("\n"), 300000)
        begun = time.time()
        surface = self.load(text)
        self.assertLess(time.time() - begun, 60)
        self.assertLess(surface.facts()["sum_defect"], 1e-12)
        begun = time.time()
        self.check_refused("#TS0200\ndegree 3\n" + "l 0 0 0 0 0 0 0\n" * 1000000, ".")
        self.check_refused("#TS0200\ndegree 3\nf 0 0\n" + "f\n" * 1000000, ".")
        self.assertLess(time.time() - begun, 60)


class CommandTest(SurfaceTest):
    def run_command(self, *arguments):
        given = os.environ.get("TSOLID_COMMAND")
        command = given or os.path.join(os.path.dirname(binding_parts.library_path()), "tsolid")
        return subprocess.run(
            [command] + list(arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def test_check_and_convert(self):
        values = [[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0]]
        boxes = [(0, 3, 0, 1), (0, 1, 1, 2), (1, 2, 1, 2), (2, 3, 1, 2)]
        surface = self.load(Mesh(values, boxes).text(lambda p, i, j: (p[0], p[1], 0, 1)))
        run = self.run_command("check", self.path())
        self.assertEqual(run.returncode, 1)
        self.assertIn("open: 1 boundary loop of 8 edges", run.stdout)
        self.assertIn("2 T-junctions", run.stdout)
        self.assertIn("open", run.stderr)
        run = self.run_command("convert", self.path(), self.path("out.tsb"))
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        patches = binding.BoundaryFile.read(self.context, self.path("out.tsb")).patches()
        mine = surface.patches(self.context)
        self.assertEqual([p.points for p in patches], [p.points for p in mine])
        run = self.run_command("convert", self.path(), self.path("out.tsm"))
        self.assertEqual(run.returncode, 0)
        again = Surface.read(self.context, self.path("out.tsm"))
        self.assertEqual(again.points.tolist(), surface.points.tolist())
        run = self.run_command("convert", self.path(), self.path("out.txt"))
        self.assertEqual(run.returncode, 1)
        self.assertFalse(os.path.exists(self.path("out.txt")))


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
