#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The report page and its pictures: what is seen is what is nearest, the page stands alone, and
its verdict follows the numbers."""

import base64
import copy
import io
import os
import re
import sys
import tempfile
import unittest
from html.parser import HTMLParser

import numpy as np

import binding_parts
from freecad.tsolid import binding, picture, report_html


def affine_elements(boxes, matrix):
    """Tricubic core elements whose map is x = matrix u."""
    nets = []
    for box in boxes:
        low, high = np.array(box[:3], float), np.array(box[3:], float)
        net = np.ones((4, 4, 4, 4))
        for k in np.ndindex(4, 4, 4):
            net[k][:3] = matrix @ (low + (high - low) * np.array(k[::-1]) / 3)
        nets.append(net)
    rows = [[box[:3], box[3:]] for box in boxes]
    return picture.Elements([0] * len(boxes), [[3, 3, 3]] * len(boxes), rows, nets)


class Camera(unittest.TestCase):
    def test_nearest_of_random_triangles(self):
        """The depth buffer against a loop over all pixels and triangles."""
        numbers = np.random.default_rng(4)
        n, width, height = 40, 31, 23
        seen = numbers.uniform(-5, 35, (3 * n, 3))
        triangle = np.arange(3 * n).reshape(n, 3)
        raster = picture.Raster(width, height)
        raster.draw(seen, triangle, np.arange(n))
        n_seen = 0
        for y in range(height):
            for x in range(width):
                depth, nearest = -np.inf, -1
                for k in range(n):
                    a, b, c = seen[triangle[k]]
                    edges = np.array([[b[0] - a[0], c[0] - a[0]], [b[1] - a[1], c[1] - a[1]]])
                    wb, wc = np.linalg.solve(edges, [x + 0.5 - a[0], y + 0.5 - a[1]])
                    z = a[2] + wb * (b[2] - a[2]) + wc * (c[2] - a[2])
                    if min(wb, wc, 1 - wb - wc) >= 0 and z > depth:
                        depth, nearest = z, k
                self.assertEqual(raster.triangle[y * width + x], nearest)
                if nearest >= 0:
                    n_seen += 1
                    self.assertAlmostEqual(raster.depth[y * width + x], depth, 9)
        self.assertGreater(n_seen, 300)

    def test_neighbours_leave_no_gap(self):
        """A square cut into triangles in many ways: every pixel drawn, and drawn once."""
        grid = np.stack(np.meshgrid(np.linspace(2.3, 27.9, 9), np.linspace(1.7, 17.1, 9)), -1)
        grid[1:-1, 1:-1] += np.random.default_rng(1).uniform(-0.7, 0.7, (7, 7, 2))
        seen = np.concatenate([grid.reshape(-1, 2), np.zeros((81, 1))], 1)
        drawn = np.zeros(30 * 20, int)
        for j in range(8):
            for i in range(8):
                a = 9 * j + i
                for three in ((a, a + 1, a + 10), (a, a + 10, a + 9)):
                    raster = picture.Raster(30, 20)
                    raster.draw(seen, np.array([three]), np.array([0]))
                    drawn += raster.triangle >= 0
        inside = np.zeros((20, 30), int)
        inside[2:17, 2:28] = 1
        inside[:, 2:28] *= (np.arange(2, 28) + 0.5 > 2.3) & (np.arange(2, 28) + 0.5 < 27.9)
        np.testing.assert_array_equal(drawn.reshape(20, 30), inside)


class Faces(unittest.TestCase):
    def test_scaled_jacobian_of_a_sheared_block(self):
        matrix = np.array([[2.0, 1.0, 0.3], [0.0, 1.5, -0.2], [0.0, 0.0, 0.7]])
        elements = affine_elements([(0, 0, 0, 1, 1, 1)], matrix)
        mesh = picture.tessellate(elements, np.ones(1, bool), 3)
        want = np.linalg.det(matrix) / np.prod(np.linalg.norm(matrix, axis=0))
        np.testing.assert_allclose(mesh.jacobian, want, rtol=1e-13)
        # Normals point out of the block, and points lie on it.
        outward = (mesh.point - matrix @ [0.5, 0.5, 0.5]) * mesh.normal
        self.assertGreater(outward.sum(1).min(), 0)
        local = np.linalg.solve(matrix, mesh.point.T).T
        self.assertLess(np.abs(np.abs(local - 0.5).max(1) - 0.5).max(), 1e-13)

    def test_faces_between_elements_are_not_seen(self):
        boxes = [(i, j, k, i + 1, j + 1, k + 1)
                 for i in range(3) for j in range(2) for k in range(2)]
        elements = affine_elements(boxes, np.eye(3))
        self.assertEqual(len(picture.visible_faces(elements, np.ones(12, bool))), 2 * (6 + 6 + 4))


class OfSolids(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.context = binding.Context()
        path = os.path.join(binding_parts.ROOT, "resources", "examples", "sphere.tsb")
        source = binding.BoundaryFile.read(cls.context, path)
        boundary = binding.Boundary.from_file(cls.context, source)
        tmesh = binding.TMesh.create(cls.context, boundary)
        space = binding.Space.create(cls.context, boundary, tmesh)
        cls.solid = binding.Solid.create(cls.context, space)
        cls.elements = picture.Elements.of(cls.context, cls.solid)
        cls.report = binding.Report.measure(cls.context, cls.solid).facts()

    def test_only_the_boundary_is_seen_from_outside(self):
        """Faces shared across the core's surface and, in other coordinates, the diagonals."""
        everything = np.ones(len(self.elements), bool)
        faces = picture.visible_faces(self.elements, everything)
        n_outer = sum(len(list(self.solid.boundary.elements(side))) for side in range(6))
        self.assertGreaterEqual(len(faces), n_outer)
        mesh = picture.tessellate(self.elements, everything, 4)
        self.assertFalse(mesh.on_cut.any())
        radius = np.linalg.norm(mesh.point - mesh.point.mean(0), axis=1)
        self.assertLess(np.ptp(radius) / radius.max(), 1e-12)

    def test_cut_opens_the_chosen_octant(self):
        view, corner = picture.choose_view(self.elements)
        removed = picture.octant(self.elements, corner)
        self.assertTrue(0 < removed.sum() < len(self.elements) / 2)
        mesh = picture.tessellate(self.elements, ~removed, 4)
        self.assertTrue(mesh.on_cut.any() and not mesh.on_cut.all())

        def shades(values):
            return np.ones((len(values), 3))

        _, share = picture.render(mesh, picture.Camera(view), 200, 150, shades)
        self.assertGreater(share, 0.1)
        behind = picture.Camera(-np.array(view))
        _, hidden = picture.render(mesh, behind, 200, 150, shades)
        self.assertLess(hidden, 0.01)

    def test_png(self):
        memory = io.BytesIO()
        picture.draw(memory, self.elements, (1, -1.35, 0.8), 5, (400, 280))
        self.assertEqual(memory.getvalue()[:8], b"\x89PNG\r\n\x1a\n")
        again = io.BytesIO()
        picture.draw(again, self.elements, (1, -1.35, 0.8), 5, (400, 280))
        self.assertEqual(memory.getvalue(), again.getvalue())

    # ---- the page

    def test_page_stands_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "with blank.html")
            report_html.write_html(path, self.report, self.solid, "A <b> & 'part'", self.context)
            self.assertEqual(os.listdir(folder), ["with blank.html"])
            with open(path, encoding="utf-8") as file:
                text = file.read()
        reader = Reader()
        reader.feed(text)
        reader.close()
        self.assertEqual(reader.open, [])
        self.assertEqual(reader.unbalanced, [])
        self.assertEqual(len(reader.images), 2)
        for source in reader.images:
            kind, _, data = source.partition(",")
            self.assertEqual(kind, "data:image/png;base64")
            self.assertEqual(base64.b64decode(data, validate=True)[:4], b"\x89PNG")
        self.assertEqual(reader.elsewhere, [])
        self.assertNotIn("url(", text)
        self.assertIn("A <b> & 'part'", "".join(reader.text))
        self.assertEqual(len(set(reader.images)), 2)

    def test_no_file_is_left_when_it_cannot_be_written(self):
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, "taken"))
            with self.assertRaises(OSError):
                report_html.write_html(
                    os.path.join(folder, "taken"), self.report, self.solid, "", self.context)
            self.assertEqual(os.listdir(folder), ["taken"])


class Verdict(unittest.TestCase):
    """The words follow the numbers: every spoilt number is noticed."""

    @classmethod
    def setUpClass(cls):
        OfSolids.setUpClass()
        cls.good = OfSolids.report
        cls.good["exactness"] = [{
            "face": "Face<3>", "kind": "BSplineSurface", "samples": 1000,
            "distance": 1e-15, "allowed": 1e-12, "declared": 0.0, "conversion": 0.0,
            "point": [0, 0, 0], "satisfied": True,
            "pieces": [{"side": 0, "box": [0, 1, 0, 1]}]}]
        cls.good["volume"] = {"quadrature": 1.0, "flux": 1.0, "relative_difference": 0.0,
                              "declared": 0.0,
                              "allowed": 1e-12, "satisfied": True}
        cls.good["verdict"] = "positive"

    def page(self, *changes):
        report = copy.deepcopy(self.good)
        for *keys, last, value in changes:
            part = report
            for key in keys:
                part = part[key]
            part[last] = value
        text = report_html.page(report, "", "part")
        kind = re.search(r'class="verdict (\w+)"', text).group(1)
        return kind, text

    def test_good(self):
        kind, text = self.page()
        self.assertEqual(report_html.shortcomings(self.good), [])
        self.assertEqual(kind, "good")
        self.assertIn("%.3g" % self.good["quality"]["worst"], text)
        self.assertIn("Face&lt;3&gt;", text)

    def test_each_fault_is_noticed(self):
        faults = (
            ("requirement", "satisfied", False),
            ("certificate", "verdict", "not positive"),
            ("conformity", "control_identical", False),
            ("exactness", 0, "satisfied", False),
            ("volume", "satisfied", False),
            ("basis", "inner_eigenvalue", 1e-17),
            ("basis", "surface_eigenvalue", None),
            ("continuity", "n_below_expected", 3),
            ("verdict", "volume differs"),
        )
        for fault in faults:
            kind, text = self.page(fault)
            self.assertEqual(kind, "bad", fault)
            self.assertNotIn("Valid:", text)

    def test_undecided_is_neither(self):
        kind, text = self.page(("certificate", "verdict", "undecided"), ("verdict", "undecided"))
        self.assertEqual(kind, "unsure")
        self.assertIn("not proved", text)
        kind, _ = self.page(("certificate", "verdict", "undecided"), ("volume", "satisfied", False))
        self.assertEqual(kind, "bad")

    def test_changes_are_declared(self):
        _, text = self.page()
        self.assertIn("Nothing was changed", text)
        _, text = self.page(("preparation", "snap", 7, 1.25e-8))
        self.assertNotIn("Nothing was changed", text)
        self.assertIn("1.25e-08", text)

    def test_numbers_that_are_missing(self):
        """null for a number, and a report of the command: without the CAD side's parts."""
        for key in ("exactness", "volume", "verdict"):
            self.assertIn(key, self.good)
        report = {k: v for k, v in self.good.items() if k not in ("exactness", "volume", "verdict")}
        report = copy.deepcopy(report)
        for group in ("quality", "conformity", "timing", "continuity"):
            for key, value in report[group].items():
                if isinstance(value, float):
                    report[group][key] = None
        report["continuity"]["area"] = [None] * 4
        self.assertIn("not measured", report_html.page(report, "", ""))


class Reader(HTMLParser):
    """What a page holds, and whether its tags fit."""

    VOID = {"meta", "img", "br"}

    def __init__(self):
        super().__init__()
        self.open, self.unbalanced, self.images, self.elsewhere, self.text = [], [], [], [], []

    def handle_starttag(self, tag, attrs):
        if tag not in self.VOID:
            self.open.append(tag)
        for name, value in attrs:
            if tag == "img" and name == "src":
                self.images.append(value)
            elif name in ("src", "href", "srcset", "action") or tag in ("script", "link"):
                self.elsewhere.append((tag, name, value))

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.unbalanced.append(tag)

    def handle_data(self, data):
        self.text.append(data)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
