# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests that run inside FreeCADCmd (started by test_freecad.py): conversion, results, document."""

import itertools
import json
import math
import os
import random
import sys
import tempfile
import unittest
import zipfile

import binding_parts

binding_parts.join_freecad()

import FreeCAD  # noqa: E402
import Part  # noqa: E402
from FreeCAD import Placement, Rotation, Vector  # noqa: E402

from freecad.tsolid import (  # noqa: E402
    api,
    binding,
    convert,
    document,
    evidence,
    intake_exact,
    intake_patches,
    intake_shell,
    occ_spline,
)

EXAMPLES = os.path.join(binding_parts.ROOT, "resources", "examples")
BOX = Part.makeBox(10, 20, 30)
ORIGIN, UP = Vector(0, 0, 0), Vector(0, 0, 1)


def open_knots(n, degree, numbers):
    inner = sorted(numbers.uniform(0.05, 0.95) for _ in range(n - degree - 1))
    return [0.0] * (degree + 1) + inner + [1.0] * (degree + 1)


def random_patch(degree, n_control, rational, numbers):
    n, m = n_control
    points = [(i, j, numbers.uniform(-1, 1)) for j in range(m) for i in range(n)]
    weights = [numbers.uniform(0.5, 2.0) for _ in range(n * m)] if rational else None
    knots = [open_knots(k, p, numbers) for k, p in zip(n_control, degree)]
    return binding.Patch(degree, n_control, knots, points, weights)


def mixed_sides():
    """A solid whose faces have different degrees and knots, some of them rational."""
    return convert.solid_of_patches(binding_parts.read_example("mixed_sides"))


def wavy_box():
    """A solid of six bilinear faces, none of them plane."""
    patches = binding_parts.cube(
        lambda x, y, z: (10 * x + y * z, 12 * y - 0.5 * x * z, 8 * z + 0.7 * x * y)
    )
    return convert.solid_of_patches(patches)


def refusal(shape):
    try:
        convert.sources_of_shape(shape)
    except binding.Refused as error:
        return error.findings
    return None


class Conversion(unittest.TestCase):
    """Shapes become patches exactly, with FreeCAD's names."""

    def test_round_trip_is_bit_identical(self):
        numbers = random.Random(1)
        for p, q in itertools.product(range(1, 10), repeat=2):
            for rational in (False, True):
                size = (p + numbers.randint(1, 4), q + numbers.randint(1, 4))
                patch = random_patch((p, q), size, rational, numbers)
                back = convert.patch_of_surface(convert.surface_of_patch(patch))
                for slot in ("degree", "n_control", "knots", "points", "weights"):
                    self.assertEqual(getattr(patch, slot), getattr(back, slot), (p, q, slot))

    def test_degree_25(self):
        patch = random_patch((25, 2), (26, 3), True, random.Random(2))
        back = convert.patch_of_surface(convert.surface_of_patch(patch))
        self.assertEqual(back.points, patch.points)

    def named_edges_run_along_their_borders(self, shape):
        """The independent check of all names: points of the patch border lie on the named edge."""
        sources, _ = convert.sources_of_shape(shape)
        names = ["Face%d" % (k + 1) for k in range(len(shape.Faces))]
        self.assertEqual([s.name for s in sources], names)
        for number, source in enumerate(sources):
            surface = convert.surface_of_patch(source.patch)
            u0, u1, v0, v1 = surface.bounds()
            low, high = ((u0, v0), (u1, v0)), ((u0, v1), (u1, v1))
            ends = [low, (low[1], high[1]), high, (low[0], high[0])]
            for name, (a, b) in zip(source.patch.border_names, ends):
                self.assertTrue(name, source.name)
                for x in (0.0, 0.3, 0.5, 1.0):
                    point = surface.value(*(s + (t - s) * x for s, t in zip(a, b)))
                    edges = [shape.getElement(n) for n in name.split(", ")]
                    far = min(Part.Vertex(point).distToShape(e)[0] for e in edges)
                    self.assertLess(far, 1e-7, (source.name, name))
            corners = ((u0, v0), (u1, v0), (u1, v1), (u0, v1))
            for name, at in zip(source.patch.corner_names, corners):
                far = (shape.getElement(name).Point - surface.value(*at)).Length
                self.assertLess(far, 1e-7, (source.name, name))
            face = shape.Faces[number]
            for _ in range(20):
                at = [a + (b - a) * random.random() for a, b in ((u0, u1), (v0, v1))]
                far = Part.Vertex(surface.value(*at)).distToShape(face)[0]
                self.assertLess(far, 1e-7, source.name)
        return sources

    def test_names_box(self):
        for source in self.named_edges_run_along_their_borders(BOX):
            self.assertEqual(source.kind, "Plane")

    def test_names_moved_box(self):
        shape = BOX.copy()
        shape.Placement = Placement(Vector(100, -20, 7), Rotation(Vector(1, 2, 3), 33))
        for source in self.named_edges_run_along_their_borders(shape):
            self.assertLess(source.deviation, 1e-12 * convert.scale_of_shape(shape))

    def test_names_reversed_compound_and_grid(self):
        solid = wavy_box()
        grid = convert.solid_of_patches(binding_parts.read_example("grid24"))
        for shape in (solid, solid.reversed(), Part.makeCompound([solid]), mixed_sides(), grid):
            for source in self.named_edges_run_along_their_borders(shape):
                self.assertEqual(source.deviation, 0.0)

    def test_signs_follow_the_normal(self):
        for shape in (BOX, wavy_box()):  # star-shaped about their centre
            centre = shape.BoundBox.Center
            for source in convert.sources_of_shape(shape)[0]:
                u, v = sum(source.box[:2]) / 2, sum(source.box[2:]) / 2
                normal = source.surface.getDN(u, v, 1, 0).cross(source.surface.getDN(u, v, 0, 1))
                outward = normal.dot(source.surface.value(u, v) - centre) * source.sign
                self.assertGreater(outward, 0.0, source.name)

    def test_isoparametric_trim_is_cut_exactly(self):
        """A box whose top is a piece of a larger, periodic or not, surface."""
        numbers = random.Random(3)
        patch = random_patch((3, 2), (9, 7), True, numbers)
        surface = convert.surface_of_patch(patch)
        face = surface.toShape(0.213, 0.87, 0.1, 0.6)
        segment, box = self.trimmed(face)
        self.assertEqual(box, (0.213, 0.87, 0.1, 0.6))
        for _ in range(200):
            u, v = numbers.uniform(0.213, 0.87), numbers.uniform(0.1, 0.6)
            self.assertLess((segment.value(u, v) - surface.value(u, v)).Length, 1e-14 * 10)
        self.assertEqual(segment.bounds(), box)

    def trimmed(self, shape):
        """The surface of the one face of a shape on the rectangle that its edges bound."""
        (face,) = intake_shell.Shell(shape).faces
        self.assertEqual((face.problems, face.kind), ([], intake_shell.RIGID))
        self.assertTrue(all(face.borders))
        net = intake_exact.surface_net(face.surface, face.box)
        return occ_spline.surface_of_net(net), face.box

    def test_periodic_but_cut(self):
        points = [[Vector(5 * math.cos(a), 4 * math.sin(a), z) for z in (0, 5, 10)]
                  for a in (i * math.pi / 4 for i in range(8))]
        surface = Part.BSplineSurface()
        surface.buildFromPolesMultsKnots(
            points, [1] * 9, [3, 3], [float(i) for i in range(9)], [0.0, 1.0], True, False, 3, 2
        )
        for low, high in ((1.0, 5.0), (0.5, 3.25), (6.5, 9.25)):
            segment, box = self.trimmed(surface.toShape(low, high, 0.0, 1.0))
            self.assertFalse(segment.isUPeriodic())
            self.assertTrue(intake_exact.is_clamped(segment))
            self.assertAlmostEqual(box[1] - box[0], high - low, 12)
            for i in range(101):
                u = box[0] + (box[1] - box[0]) * i / 100
                far = (segment.value(u, 0.3) - surface.value(u, 0.3)).Length
                self.assertLess(far, 1e-13)

    def test_trim_that_is_almost_isoparametric(self):
        surface = convert.surface_of_patch(random_patch((3, 3), (6, 6), False, random.Random(4)))
        for lift, taken in ((0.0, True), (1e-9, True), (1e-5, False), (0.05, False)):
            corners = [(0.2, 0.1), (0.9, 0.1 + lift), (0.9, 0.6), (0.2, 0.6)]
            edges = [
                Part.Geom2d.Line2dSegment(FreeCAD.Base.Vector2d(*a), FreeCAD.Base.Vector2d(*b))
                .toShape(surface)
                for a, b in zip(corners, corners[1:] + corners[:1])
            ]
            face = Part.Face(surface, Part.Wire(edges))
            face.validate()
            (read,) = intake_shell.Shell(face).faces
            self.assertEqual(read.problems == [], taken, lift)

    def test_conversion_is_measured(self):
        """A converted surface that is off is seen: the deviation is measured, not assumed."""
        cylinder = Part.makeCylinder(5, 10, ORIGIN, UP, 90)
        face = next(f for f in cylinder.Faces if isinstance(f.Surface, Part.Cylinder))
        net = intake_exact.surface_net(face.Surface, face.ParameterRange)
        far = intake_patches.distance_from_surface(face.Surface, net)
        self.assertLess(far, 1e-13)
        net.points[1][0][0] += 1e-6
        far = intake_patches.distance_from_surface(face.Surface, net)
        self.assertGreater(far, 1e-8)

    def test_approximate_conversion_is_refused(self):
        """An offset surface is no B-spline; what toNurbs() makes of it is off, and seen to be."""
        surface = convert.surface_of_patch(random_patch((2, 2), (5, 5), False, random.Random(5)))
        face = Part.OffsetSurface(surface, 1.0).toShape()
        with self.assertRaises(binding.Refused) as caught:
            intake_patches.take(face, binding.Context())
        (refused,) = caught.exception.findings
        self.assertEqual(refused.where, "Face1")
        self.assertGreater(refused.measured, refused.allowed)


class Refusals(unittest.TestCase):
    """Everything that is not taken is named, with the reason and the place."""

    def refused(self, shape, *words):
        findings = refusal(shape)
        self.assertIsNotNone(findings, words)
        text = "\n".join(str(f) for f in findings)
        for word in words:
            self.assertIn(word, text)
        return findings

    def test_not_a_solid(self):
        self.refused(Part.Shape(), "empty")
        self.refused(BOX.Edges[0], "not a solid")
        self.refused(BOX.Shells[0], "not a solid but a closed surface")
        self.refused(BOX.Faces[0], "open along this edge", "Edge1", "Edge4")

    def test_open_shell_names_exactly_its_free_edges(self):
        shell = Part.makeShell(BOX.Faces[:5])
        findings = self.refused(shell, "open along this edge")
        free = {f.where for f in findings}
        missing = BOX.Faces[5]
        for number, edge in enumerate(shell.Edges, 1):
            on = edge.distToShape(missing)[0] < 1e-9 and all(
                Part.Vertex(v.Point).distToShape(missing)[0] < 1e-9 for v in edge.Vertexes
            )
            self.assertEqual("Edge%d" % number in free, on, number)

    def test_several_solids_and_loose_faces(self):
        other = Part.makeBox(1, 1, 1, Vector(50, 0, 0))
        self.refused(Part.makeCompound([BOX, other]), "2 solids", "Solid2")
        self.refused(Part.makeCompound([BOX, other.Faces[0]]), "do not belong")

    def test_loose_faces(self):
        """As IGES gives them: one sentence on what to do, or the places where they are open."""
        (only,) = self.refused(Part.makeCompound(BOX.Faces), "6 loose faces", "sew them first")
        self.assertEqual(only.where, "")
        missing = self.refused(Part.makeCompound(BOX.Faces[:5]), "5 loose faces do not close")
        self.assertEqual(len(missing), 4)
        for f in missing:
            self.assertLess(Part.Vertex(*f.point).distToShape(BOX.Faces[5])[0], 1e-9)
        beside = BOX.translated(Vector(BOX.BoundBox.XLength, 0, 0))
        (only,) = self.refused(Part.makeCompound(BOX.Faces + beside.Faces), "lie on one another")
        self.assertEqual(only.where, "Face2, Face7")

    def test_void(self):
        self.refused(BOX.cut(Part.makeBox(1, 1, 1, Vector(4, 4, 4))), "void")

    def test_poles(self):
        self.refused(Part.makeSphere(5), "Face1, Vertex1", "Face1, Vertex2", "(a pole)")
        self.refused(Part.makeCone(3, 0, 4), "Face1, Vertex1", "(a pole)")

    def test_holes(self):
        bored = BOX.cut(Part.makeCylinder(2, 40, Vector(5, 10, -5)))
        self.refused(bored, "1 hole through it", "genus 1", "plane")
        self.refused(Part.makeTorus(9, 2), "1 hole through it")
        boss = BOX.fuse(Part.makeCylinder(2, 9, Vector(5, 10, 30)))
        self.refused(boss, "inner border")

    def test_trimmed_along_a_curve(self):
        """With the distance from the nearest isoline: 2 * (1 - sqrt(1/2)) on each side."""
        cut = BOX.makeFillet(2, [BOX.Edges[0], BOX.Edges[1]])
        findings = self.refused(cut, "not an isoparametric line", "by 1.41")
        for f in findings:  # the place is on the edge that is named
            edge = cut.getElement(f.where.split(", ")[1])
            self.assertLess(Part.Vertex(Vector(*f.point)).distToShape(edge)[0], 1e-7)

    def test_check_gives_rows_instead_of_raising(self):
        result = api.check(Part.makeSphere(5))
        self.assertFalse(result.satisfied)
        refused = [r for r in result.rows() if r["verdict"] == "refused"]
        (suggestion,) = [r for r in result.rows() if r["verdict"] != "refused"]
        self.assertTrue(refused)
        self.assertRegex(suggestion["what"], "a cut with the plane [xyz] = 0")
        self.assertIn("Vertex2", result.text())
        self.assertEqual(api.build(Part.makeSphere(5)).exit_code, 1)

    def test_a_gap_is_named_with_its_size(self):
        """One corner of one face 1e-3 off: more than the edges' tolerance."""
        patches = binding_parts.cube()
        patches[5].points[0] = (0.0, 0.0, 1.001)
        result = api.check(api.Part.of_patches(patches))
        self.assertFalse(result.satisfied)
        sized = [f for f in result.findings if f.measured is not None and f.point is not None]
        self.assertTrue(sized, result.text())
        self.assertTrue(any(abs(f.measured - 1e-3) < 1e-4 for f in sized), result.text())


class Evidence(unittest.TestCase):
    def test_gauss(self):
        for n in (1, 2, 5, 16, 22, 38):
            nodes, weights = evidence.gauss(n)
            for k in range(2 * n):
                got = math.fsum(w * x**k for x, w in zip(nodes, weights))
                self.assertAlmostEqual(got, 1.0 / (k + 1), delta=4e-15)

    def test_flux_of_known_volumes(self):
        sources, _ = convert.sources_of_shape(BOX)
        signs = [s.sign for s in sources]
        volume = evidence.volume_by_flux(sources, signs, Vector(1, 2, 3), 6000.0)
        self.assertAlmostEqual(volume / 6000.0, 1.0, delta=1e-14)

    def test_flux_of_a_rational_sphere(self):
        patches = binding_parts.read_example("sphere")
        sources = [convert.source_of_patch(p, k) for k, p in enumerate(patches)]
        boundary = binding.Boundary.create(binding.Context(), patches)
        signs = [evidence.sign_on_cube(boundary.placement(k)) for k in range(len(patches))]
        volume = evidence.volume_by_flux(sources, signs, Vector(0, 0, 0), 1.0)
        radius = Vector(*patches[0].points[0]).Length
        self.assertAlmostEqual(volume / (4 * math.pi / 3 * radius**3), 1.0, delta=1e-13)

    def test_sign_on_cube_agrees_with_the_faces(self):
        solid = wavy_box()
        sources, _ = convert.sources_of_shape(solid)
        boundary = binding.Boundary.create(binding.Context(), [s.patch for s in sources])
        signs = [evidence.sign_on_cube(boundary.placement(k)) for k in range(6)]
        self.assertEqual(signs, [s.sign for s in sources])


class Building(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.solid = wavy_box()
        cls.result = api.build(cls.solid)

    def test_facts(self):
        self.check_facts(self.solid, self.result)

    def test_facts_of_mixed_sides(self):
        solid = mixed_sides()
        self.check_facts(solid, api.build(solid, effort="none"))

    def check_facts(self, solid, result):
        report = result.report
        self.assertEqual(result.verdict, "positive", result.text())
        self.assertEqual(result.exit_code, 0)
        faces = [row["face"] for row in report["exactness"]]
        self.assertEqual(faces, ["Face%d" % k for k in range(1, 7)])
        scale = report["conformity"]["scale"]
        points = [v.Point for v in solid.Vertexes]
        self.assertGreaterEqual(scale, max((a - b).Length for a in points for b in points))
        for row in report["exactness"]:
            self.assertEqual(row["samples"], 1000)
            self.assertLessEqual(row["declared"], 1e-13 * scale)
            self.assertLessEqual(row["distance"], 1e-12 * scale + row["declared"])
        self.assertLessEqual(report["volume"]["relative_difference"], 1e-12)
        json.loads(api.report_json(report))

    def test_shape_is_made_of_the_very_faces(self):
        self.assertEqual(len(self.result.shape.Faces), 6)
        for mine, given in zip(self.result.shape.Faces, self.solid.Faces):
            self.assertTrue(mine.isSame(given))

    def test_threads_do_not_matter(self):
        self.assertEqual(api.build(self.solid, threads=1).tsolid, self.result.tsolid)
        self.assertEqual(api.build(self.solid, threads=2).tsolid, self.result.tsolid)

    def test_document_object_or_shape(self):
        doc = FreeCAD.newDocument("Given")
        try:
            obj = doc.addObject("Part::Feature", "Mixed")
            obj.Shape = self.solid
            self.assertEqual(api.build(obj).tsolid, self.result.tsolid)
            self.assertEqual(api.check(obj).name, "Mixed")
        finally:
            FreeCAD.closeDocument(doc.Name)

    def test_options(self):
        refined = api.build(self.solid, refine_knots=1, raise_degree=1, min_cells=4, effort="quick")
        self.assertEqual(refined.exit_code, 0, refined.text())
        more = refined.report["statistics"]["input_nodes"]
        self.assertGreater(more, self.result.report["statistics"]["input_nodes"])
        with self.assertRaises(ValueError):
            api.build(self.solid, effort="great")
        with self.assertRaises(ValueError):
            api.build(self.solid, octree="round")
        with self.assertRaises(TypeError):
            api.build(self.solid, api.Options(), threads=1)

    def test_octree_and_closure(self):
        """One fine face: the T-mesh has levels, so the options make a difference."""
        patches, cells, open_defect = binding_parts.cube(), {}, 0.0
        knots = [0.0] + [i / 16 for i in range(17)] + [1.0]
        points = [(0.0, i / 16, j / 16) for j in range(17) for i in range(17)]
        patches[0] = binding.Patch((1, 1), (17, 17), (knots, knots), points)
        for octree, closed in itertools.product(api.OCTREES, (True, False)):
            result = api.build(api.Part.of_patches(patches), octree=octree,
                               analysis_suitable=closed, effort="none")
            self.assertEqual(result.exit_code, 0, result.text())
            statistics, basis = result.report["statistics"], result.report["basis"]
            self.assertEqual(statistics["analysis_suitable"], closed)
            if closed:
                self.assertLess(basis["sum_defect"], 1e-12)
            open_defect = max(open_defect, basis["sum_defect"])
            self.assertLess(basis["input_sum_defect"], 1e-12)
            self.assertEqual(result.report["options"]["octree"], octree)
            cells[octree, closed] = statistics["tmesh_cells"]
        self.assertGreater(cells["anisotropic", True], cells["anisotropic", False])
        self.assertGreater(open_defect, 1e-3)
        self.assertNotEqual(cells["isotropic", False], cells["anisotropic", False])

    def test_verify_sees_a_moved_control_point(self):
        rows, same = api.verify(self.solid, self.result.tsolid)
        self.assertTrue(same)
        self.assertTrue(all(r["satisfied"] for r in rows))
        scale = convert.scale_of_shape(self.solid)
        moved = binding_parts.with_moved_point(self.result.tsolid, 1e-9 * scale)
        rows, same = api.verify(self.solid, moved)
        self.assertFalse(same)
        self.assertFalse(all(r["satisfied"] for r in rows))

    def test_cancel_and_exceptions(self):
        with self.assertRaises(binding.Cancelled):
            api.build(self.solid, progress=lambda stage, fraction: True)

        def raising(stage, fraction):
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            api.build(self.solid, progress=raising)

    def test_every_single_progress_call_can_cancel(self):
        calls = []
        api.build(self.solid, progress=lambda s, f: bool(calls.append(s)))
        for stop in range(0, len(calls), max(1, len(calls) // 12)):
            left = [stop]

            def progress(stage, fraction, left=left):
                left[0] -= 1
                return left[0] < 0

            with self.assertRaises(binding.Cancelled):
                api.build(self.solid, progress=progress)

    def test_unwritable(self):
        with self.assertRaises(OSError):
            self.result.write("/nonexistent/x.tsolid")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "x.tsolid")
            self.result.write(path)
            with open(path, "rb") as stream:
                self.assertEqual(stream.read(), self.result.tsolid)
            self.assertEqual(os.listdir(folder), ["x.tsolid"])


class Documents(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.doc = FreeCAD.newDocument("Test")
        self.addCleanup(lambda: FreeCAD.closeDocument(self.doc.Name))
        self.source = self.doc.addObject("Part::Feature", "Wavy")
        self.source.Shape = wavy_box()

    def reopened(self):
        path = os.path.join(self.folder.name, "a.FCStd")
        self.doc.saveAs(path)
        FreeCAD.closeDocument(self.doc.Name)
        self.doc = FreeCAD.openDocument(path)
        return path

    def test_stored_and_restored(self):
        obj = document.create(self.source)
        result = document.rebuild(obj)
        self.assertEqual(obj.Verdict, "positive")
        report = document.report_of(obj)
        path = self.reopened()
        obj = self.doc.getObject("SolidTSpline")
        self.assertIsInstance(obj.Proxy, document.SolidTSpline)
        self.assertTrue(document.is_solid_tspline(obj))
        self.assertEqual(document.report_of(obj), report)
        self.assertEqual(document.tsolid_of(obj), result.tsolid)
        self.assertTrue(obj.Shape.isClosed() and obj.Shape.isValid())
        self.assertEqual((obj.Shape.ShapeType, len(obj.Shape.Faces)), ("Solid", 6))
        rows, same = api.verify(self.source_shape(), document.tsolid_of(obj))
        self.assertTrue(same or all(r["satisfied"] for r in rows))
        with zipfile.ZipFile(path) as archive:
            names = [n for n in archive.namelist() if n.endswith(".tsolid")]
            self.assertEqual([archive.read(n) for n in names], [result.tsolid])
        solid = document.solid_of(obj)
        self.assertEqual(solid.control.tolist(), result.solid.control.tolist())

    @staticmethod
    def source_shape():
        return wavy_box()

    def test_recompute_never_builds(self):
        obj = document.create(self.source)
        document.rebuild(obj)
        before = document.tsolid_of(obj)
        self.source.Shape = BOX
        self.doc.recompute()
        self.assertEqual(document.tsolid_of(obj), before)
        self.assertFalse(obj.Shape.isNull())

    def test_refusal_leaves_the_object_as_it_was(self):
        obj = document.create(self.source)
        document.rebuild(obj)
        before = (document.tsolid_of(obj), obj.Report, obj.Verdict)
        self.source.Shape = Part.makeSphere(3)
        self.assertIsNone(document.rebuild(obj).solid)
        self.assertEqual((document.tsolid_of(obj), obj.Report, obj.Verdict), before)

    def test_objects_of_an_older_version_get_what_they_lack(self):
        obj = document.create(self.source)
        obj.RefineKnots = 1
        for name in ("MinCells", "Octree", "AnalysisSuitable", "Corners"):
            obj.removeProperty(name)
        obj.Version = 0
        self.reopened()
        obj = self.doc.getObject("SolidTSpline")
        self.assertEqual((obj.MinCells, obj.Version, obj.RefineKnots), (0, document.VERSION, 1))
        self.assertEqual((str(obj.Octree), obj.AnalysisSuitable), ("anisotropic", True))
        self.assertEqual(obj.Corners, [])

    def test_a_solid_built_before_the_octree_could_be_chosen_is_current(self):
        obj = document.create(self.source)
        document.rebuild(obj)
        built = json.loads(obj.BuiltOptions)
        for name in ("Octree", "AnalysisSuitable", "Corners"):
            obj.removeProperty(name)
        newer = ("octree", "analysis_suitable", "corners")
        obj.BuiltOptions = json.dumps({k: v for k, v in built.items() if k not in newer})
        obj.Version = 2
        self.reopened()
        obj = self.doc.getObject("SolidTSpline")
        self.doc.recompute()
        self.assertEqual((json.loads(obj.BuiltOptions), obj.Version), (built, document.VERSION))
        self.assertEqual(str(obj.Status), document.CURRENT)
        obj.AnalysisSuitable = False
        self.doc.recompute()
        self.assertEqual(str(obj.Status), document.OUTDATED)

    def test_octree_options_are_the_objects_own(self):
        obj = document.create(self.source)
        obj.Octree, obj.AnalysisSuitable = "isotropic", False
        options = document.options_of(obj)
        self.assertEqual((options.octree, options.analysis_suitable), ("isotropic", False))
        other = document.create(self.source)
        document.set_options(other, options)
        self.assertEqual(document.options_of(other).as_dict(), options.as_dict())

    def test_two_objects_keep_their_own_files(self):
        other = self.doc.addObject("Part::Feature", "Box")
        other.Shape = BOX
        want = []
        for source in (self.source, other):
            obj = document.create(source)
            want.append(document.rebuild(obj).tsolid)
        self.assertNotEqual(*want)
        self.reopened()
        objs = [o for o in self.doc.Objects if document.is_solid_tspline(o)]
        self.assertEqual([document.tsolid_of(o) for o in objs], want)


if __name__ == "__main__":
    code = binding_parts.run(sys.modules[__name__])
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(binding_parts.EXIT_BASE + code)
