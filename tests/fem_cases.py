# SPDX-License-Identifier: LGPL-2.1-or-later
"""Hex blocks in FreeCAD's documents and FEM workbench; runs inside FreeCADCmd (test_fem.py)."""

import os
import sys
import tempfile
import unittest

import binding_parts
import FreeCAD
import Part
from FreeCAD import Vector

from freecad.tsolid import actions, api, document, fem

LENGTH, HEIGHT, WIDTH, FORCE = 100.0, 10.0, 8.0, 500.0
E_MODULE, POISSON = 210e3, 0.3


def solid_in_document(shape, **options):
    doc = FreeCAD.newDocument()
    source = doc.addObject("Part::Feature", "Source")
    source.Shape = shape
    solid = document.create(source)
    document.set_options(solid, api.Options(**options))
    result = document.rebuild(solid)
    return doc, source, solid, result


class HexBlocks(unittest.TestCase):
    def setUp(self):
        self.addCleanup(lambda: [FreeCAD.closeDocument(n) for n in list(FreeCAD.listDocuments())])

    def test_groups_are_the_faces(self):
        """FreeCAD's own search of the nodes on a face finds those of the group, and no others."""
        shape = Part.makeBox(LENGTH, WIDTH, HEIGHT)
        doc, source, solid, result = solid_in_document(shape)
        for order in (1, 2):
            mesh = fem.mesh_with_hex_blocks(solid, size=4.0, order=order)
            groups = {mesh.FemMesh.getGroupName(g): g for g in mesh.FemMesh.Groups}
            for k, face in enumerate(shape.Faces):
                name = "Face%d" % (k + 1)
                found = mesh.FemMesh.getNodesByFace(face)
                inside = mesh.FemMesh.getGroupElements(groups[name + "_nodes"])
                self.assertEqual(sorted(found), sorted(inside), name)
                self.assertGreater(len(found), 3)
                self.assertGreater(len(mesh.FemMesh.getGroupElements(groups[name])), 0)
            self.assertEqual(mesh.FemMesh.HexaCount, mesh.FemMesh.VolumeCount)

    def test_several_faces_on_a_side(self):
        patches = binding_parts.read_example("grid24")
        result = api.build(api.Part.of_patches(patches))
        mesh = fem.hex_mesh(result, size=8.0)
        self.assertEqual(len(mesh.regions), 24)
        self.assertTrue(all(len(faces) for faces in mesh.regions.values()))
        names = {row["face"] for row in result.report["exactness"]}
        self.assertEqual(set(mesh.regions), names)

    def test_assembly_shares_nodes(self):
        """Two boxes on a wider one, one of them a placed copy: one mesh, a group per part."""
        doc = FreeCAD.newDocument()
        base = doc.addObject("Part::Feature", "Base")
        base.Shape = Part.makeBox(20, 10, 5)
        first = doc.addObject("Part::Feature", "First")
        first.Shape = Part.makeBox(5, 10, 8, Vector(0, 0, 5))
        copy = doc.addObject("App::Link", "Copy")
        copy.LinkedObject = first
        copy.Placement = FreeCAD.Placement(Vector(15, 0, 0), FreeCAD.Rotation())
        doc.recompute()
        result = actions.build_assembly(doc, effort="none")
        self.assertTrue(result.watertight, result.text())
        box = FreeCAD.newDocument().addObject("Fem::FemAnalysis", "Analysis")
        out = fem.mesh_of_assembly(result, size=2.5, order=2, container=box)
        self.assertIn(out, box.Group)
        mesh = out.FemMesh
        names = [mesh.getGroupName(g) for g in mesh.Groups]
        volumes = [g for g in mesh.Groups if mesh.getGroupElementType(g) == "Volume"]
        self.assertEqual(len(volumes), 3, names)
        self.assertEqual(sum(len(mesh.getGroupElements(g)) for g in volumes), mesh.HexaCount)
        points = [tuple(round(x, 6) for x in p) for p in mesh.Nodes.values()]
        self.assertEqual(len(set(points)), len(points))
        box = FreeCAD.BoundBox(*[f(p[k] for p in points) for f in (min, max) for k in range(3)])
        self.assertLess(max(abs(a - b) for a, b in zip(
            (box.XMin, box.YMin, box.ZMin, box.XMax, box.YMax, box.ZMax),
            (0, 0, 0, 20, 10, 13))), 1e-9)
        result = actions.check_assembly(doc)
        with self.assertRaises(ValueError):
            fem.mesh_of_assembly(result)

    def test_out_of_date_and_meshed_anew(self):
        doc, source, solid, result = solid_in_document(Part.makeBox(3, 4, 5), effort="none")
        mesh = fem.mesh_with_hex_blocks(solid, size=1.0)
        self.assertTrue(fem.is_hex_blocks(mesh) and not fem.is_hex_blocks(solid))
        self.assertFalse(fem.is_out_of_date(mesh))
        source.Shape = Part.makeBox(3, 4, 6)
        document.rebuild(solid)
        self.assertTrue(fem.is_out_of_date(mesh))
        before = mesh.FemMesh.NodeCount
        fem.mesh_anew(mesh)
        self.assertFalse(fem.is_out_of_date(mesh))
        self.assertGreater(mesh.FemMesh.NodeCount, before)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "mesh.FCStd")
            doc.saveAs(path)
            count, name = mesh.FemMesh.NodeCount, mesh.Name
            FreeCAD.closeDocument(doc.Name)
            again = FreeCAD.openDocument(path).getObject(name)
            self.assertEqual(again.FemMesh.NodeCount, count)
            self.assertFalse(fem.is_out_of_date(again))

    def test_replaced_when_the_solid_is_rebuilt(self):
        doc, source, solid, result = solid_in_document(Part.makeBox(3, 4, 5), effort="none")
        mesh = fem.mesh_with_hex_blocks(solid, size=1.0, order=2)
        source.Shape = Part.makeBox(3, 4, 9)
        count = mesh.FemMesh.NodeCount
        actions.rebuild(solid)
        self.assertFalse(fem.is_out_of_date(mesh))
        self.assertGreater(mesh.FemMesh.NodeCount, count)
        self.assertAlmostEqual(mesh.FemMesh.BoundBox.ZMax, 9.0, 12)
        count = mesh.FemMesh.NodeCount
        fem.mesh_anew(mesh, order=1)
        self.assertEqual(mesh.Order, 1)
        self.assertLess(mesh.FemMesh.NodeCount, count)
        with self.assertRaises(ValueError):
            fem.mesh_with_hex_blocks(source)

    def test_unv_and_med_read_back(self):
        """Node by node: every element of the file has its nodes at the same places in the same
        order, and names are kept; and .unv and .med of the internal order mean no fold: written as
        .inp from what was read, every Jacobian at the corners is positive."""
        import Fem

        doc, source, solid, result = solid_in_document(Part.makeBox(3, 4, 5), effort="none")
        for order in (1, 2):
            mesh = fem.mesh_with_hex_blocks(solid, size=1.5, order=order).FemMesh
            for ending in ("unv", "med"):
                with tempfile.TemporaryDirectory() as folder:
                    path = os.path.join(folder, "mesh." + ending)
                    mesh.write(path)
                    again = Fem.read(path)
                    self.assertEqual(again.NodeCount, mesh.NodeCount)
                    self.assertEqual(again.HexaCount, mesh.HexaCount)
                    self.assertEqual(self.places(again), self.places(mesh), ending)
                    names = {again.getGroupName(g) for g in again.Groups}
                    self.assertTrue({"Face%d" % (k + 1) for k in range(6)} <= names, ending)
                    again.writeABAQUS(os.path.join(folder, "mesh.inp"), 1, False)
                    self.assertGreater(self.worst_corner(os.path.join(folder, "mesh.inp")), 0)

    @staticmethod
    def places(mesh):
        at = {k: tuple(round(x, 9) for x in v) for k, v in mesh.Nodes.items()}
        return sorted(tuple(at[n] for n in mesh.getElementNodes(v)) for v in mesh.Volumes)

    @staticmethod
    def worst_corner(path):
        """The smallest scaled Jacobian at the corners of a deck's hexahedra."""
        nodes, elements, reading, held = {}, [], "", []
        with open(path) as stream:
            for line in stream:
                line = line.strip()
                if line.startswith("*"):
                    reading = line.lower()
                    continue
                words = held + [w for w in line.split(",") if w.strip()]
                held = words if line.endswith(",") else []
                if held or not words:
                    continue
                if reading.startswith("*node"):
                    nodes[int(words[0])] = Vector(*[float(w) for w in words[1:4]])
                elif "c3d8" in reading or "c3d20" in reading:
                    elements.append([int(w) for w in words[1:9]])
        worst = 1.0
        around = ((1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2))
        around += ((6, 4, 3),)
        for element in elements:
            x = [nodes[n] for n in element]
            for k, (a, b, c) in enumerate(around):
                p, q, r = ((x[m] - x[k]).normalize() for m in (a, b, c))
                worst = min(worst, p.cross(q).dot(r))
        if not elements:
            raise AssertionError("no hexahedra in " + path)
        return worst

    def test_what_an_analysis_lacks(self):
        """A material, a solver, CalculiX itself: one sentence each, and none when all is there."""
        import ObjectsFem

        doc = FreeCAD.newDocument()
        analysis = ObjectsFem.makeAnalysis(doc, "Analysis")
        words = " ".join(fem.lacks(analysis))
        self.assertIn("has no material", words)
        self.assertIn("has no solver", words)
        group = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Mod/Fem/Ccx")
        before = group.GetString("ccxBinaryPath", "")
        self.addCleanup(group.SetString, "ccxBinaryPath", before)
        group.SetString("ccxBinaryPath", "/no/such/ccx")
        self.assertIn("CalculiX (ccx) was not found", " ".join(fem.lacks(analysis)))
        group.SetString("ccxBinaryPath", sys.executable)  # some program that is there
        analysis.addObject(ObjectsFem.makeMaterialSolid(doc, "Material"))
        analysis.addObject(ObjectsFem.makeSolverCalculixCcxTools(doc, "Solver"))
        self.assertEqual(fem.lacks(analysis), [])

    def test_nothing_to_mesh(self):
        doc = FreeCAD.newDocument()
        with self.assertRaises(ValueError):
            fem.hex_mesh(document.create(document=doc))

    def test_cantilever_through_the_fem_workbench(self):
        import ObjectsFem
        from femtools import ccxtools

        doc, source, solid, result = solid_in_document(Part.makeBox(LENGTH, WIDTH, HEIGHT))
        at = {}
        for k, face in enumerate(source.Shape.Faces):
            if face.BoundBox.XLength < 1e-9:
                at["fixed" if face.CenterOfMass.x < 1 else "loaded"] = "Face%d" % (k + 1)
        analysis = ObjectsFem.makeAnalysis(doc, "Analysis")
        solver = ObjectsFem.makeSolverCalculixCcxTools(doc, "Solver")
        solver.GeometricalNonlinearity, solver.MatrixSolverType = "linear", "default"
        material = ObjectsFem.makeMaterialSolid(doc, "Material")
        values = material.Material
        values.update(
            {"Name": "Steel", "YoungsModulus": "%g MPa" % E_MODULE, "PoissonRatio": str(POISSON)}
        )
        material.Material = values
        fixed = ObjectsFem.makeConstraintFixed(doc, "Fixed")
        fixed.References = [(source, at["fixed"])]
        force = ObjectsFem.makeConstraintForce(doc, "Force")
        force.References = [(source, at["loaded"])]
        force.Force = FORCE
        vertical = [e for e in source.Shape.Edges if e.BoundBox.ZLength > 1][0]
        number = [k for k, e in enumerate(source.Shape.Edges) if e.isSame(vertical)][0] + 1
        force.Direction = (source, ["Edge%d" % number])
        for obj in (solver, material, fixed, force):
            analysis.addObject(obj)
        fem.mesh_with_hex_blocks(solid, size=5.0, order=2, container=analysis)
        doc.recompute()
        with tempfile.TemporaryDirectory() as folder:
            run = ccxtools.FemToolsCcx(analysis, solver, test_mode=False)
            run.update_objects()
            run.setup_working_dir(folder)
            run.setup_ccx()
            self.assertEqual(run.check_prerequisites(), "")
            run.purge_results()
            run.write_inp_file()
            run.ccx_run()
            run.load_results()
        results = [o for o in analysis.Group if o.isDerivedFrom("Fem::FemResultObject")]
        self.assertEqual(len(results), 1)
        moved = max(v.Length for v in results[0].DisplacementVectors)
        inertia = WIDTH * HEIGHT**3 / 12
        shear = E_MODULE / (2 * (1 + POISSON))
        beam = FORCE * LENGTH**3 / (3 * E_MODULE * inertia)
        beam += FORCE * LENGTH / (5.0 / 6.0 * shear * WIDTH * HEIGHT)
        print("moved %.6g, beam theory %.6g" % (moved, beam))
        self.assertLess(abs(moved / beam - 1), 0.02)
        self.assertIsInstance(results[0].DisplacementVectors[0], Vector)


if __name__ == "__main__":
    code = binding_parts.run(sys.modules[__name__])
    sys.stdout.flush()
    os._exit(binding_parts.EXIT_BASE + code)
