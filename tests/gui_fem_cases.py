# SPDX-License-Identifier: LGPL-2.1-or-later
"""Hex blocks for FEM in FreeCAD's window: the panel, and the FEM workbench; cases of gui_cases.py.
"""

import os
import shutil
import sys
import tempfile

import FreeCAD as App
import FreeCADGui as Gui
from PySide import QtGui

import gui_harness as h
from gui_harness import QTest, choose, click, close_panel, part, pump, select, tool_button, until


def beam(doc):
    """A box of 40 x 8 x 10 and its solid T-spline."""
    import freecad.tsolid as ts

    obj = doc.addObject("Part::Box", "Beam")
    obj.Length, obj.Width, obj.Height = 40, 8, 10
    doc.recompute()
    made = ts.build(obj, effort="none").object
    Gui.ActiveDocument.ActiveView.viewIsometric()
    Gui.SendMsgToActiveView("ViewFit")
    pump(0.1)
    return obj, made


def write(widget, text):
    widget.selectAll()
    QTest.keyClicks(widget, text)


def says(words):
    until(lambda: h.shown("verdict") and words in part("verdict").text(), 60, words)


def wires():
    graph = Gui.ActiveDocument.ActiveView.getSceneGraph()
    return [c for c in graph.getChildren() if str(c.getName()) == "TsolidWires"]


def mesh_with_hex_blocks():
    """Preview, mesh, mesh anew with other options; undo takes each back."""
    doc = App.newDocument("Mesh")
    obj, made = beam(doc)
    select(made)
    click(tool_button("Tsolid_HexBlocks"))
    size = part("size", QtGui.QLineEdit)
    write(size, "much")
    click(part("mesh"))
    says("much is not a number")
    write(size, "2,5")
    choose(part("order", QtGui.QComboBox), 1)
    click(part("preview"))
    says("Preview: ")
    assert len(wires()) == 1 and len(doc.Objects) == 2
    h.screen("mesh_preview")
    click(part("mesh"))
    says("Meshed: ")
    assert not wires() and len(doc.Objects) == 3
    mesh = next(o for o in doc.Objects if o.TypeId == "Fem::FemMeshObject")
    text = "%d hexahedra, %d nodes" % (mesh.FemMesh.HexaCount, mesh.FemMesh.NodeCount)
    assert text in part("verdict").text(), (text, part("verdict").text())
    assert (mesh.Solid, mesh.Size.Value, mesh.Order) == (made, 2.5, 2)
    close_panel()
    count = mesh.FemMesh.NodeCount
    select(mesh)
    click(tool_button("Tsolid_HexBlocks"))
    write(part("size", QtGui.QLineEdit), "5")
    click(part("mesh"))
    says("Meshed: ")
    close_panel()
    assert len(doc.Objects) == 3 and mesh.FemMesh.NodeCount < count
    assert (mesh.Size.Value, mesh.Order) == (5.0, 2)
    doc.undo()  # meshing anew is no step of undo: see fem.mesh_anew
    assert len(doc.Objects) == 2


def mesh_follows_the_solid():
    """Replaced when the solid is rebuilt; out of date, and said so, when that is undone."""
    from freecad.tsolid import fem
    import freecad.tsolid as ts

    doc = App.newDocument("Mesh")
    obj, made = beam(doc)
    mesh = ts.mesh_with_hex_blocks(made, size=4.0)
    obj.Length = 60
    doc.recompute()
    select(made)
    click(tool_button("Tsolid_Rebuild"))
    until(h.finished, what="the rebuild")
    close_panel()
    assert abs(mesh.FemMesh.BoundBox.XMax - 60.0) < 1e-9 and not fem.is_out_of_date(mesh)
    doc.undo()
    assert fem.is_out_of_date(mesh)
    select(mesh)
    click(tool_button("Tsolid_HexBlocks"))
    says("Out of date")
    click(part("mesh"))
    says("Meshed: ")
    assert abs(mesh.FemMesh.BoundBox.XMax - 40.0) < 1e-9 and not fem.is_out_of_date(mesh)


def mesh_refused():
    """Too many hexahedra, a solid that is gone, a part without a solid: one sentence each."""
    doc = App.newDocument("Mesh")
    obj, made = beam(doc)
    select(made)
    click(tool_button("Tsolid_HexBlocks"))
    write(part("size", QtGui.QLineEdit), "0.01")
    click(part("mesh"))
    until(lambda: h.shown("verdict"), 60, "the refusal")
    assert "take a larger size" in part("verdict").text(), part("verdict").text()
    assert len(doc.Objects) == 2
    doc.removeObject(made.Name)
    click(part("mesh"))
    says("gone")
    close_panel()
    select(obj)
    h.window().statusBar().clearMessage()
    click(tool_button("Tsolid_HexBlocks"))
    assert "is not a solid T-spline" in h.status_bar(), h.status_bar()


def result_as_colours():
    """A result on the solid, here the height, is coloured on the surface and in the cut; a rebuild
    takes it away."""
    from freecad.tsolid import document, results

    doc = App.newDocument("Result")
    obj, made = beam(doc)
    solid = document.solid_of(made)
    control = [solid.control[k, d] for k in range(solid.space.n_functions) for d in (2, 3)]
    heights = [z / w for z, w in zip(control[::2], control[1::2])]
    results.put(made, "height", heights)
    select(made)
    click(tool_button("Tsolid_LookInside"))
    colour = part("colour", QtGui.QComboBox)
    names = [colour.itemText(k) for k in range(colour.count())]
    choose(colour, names.index("Result"))
    view = made.ViewObject
    assert str(view.ColourBy) == "Result"
    legend = part("legend")
    assert legend.scale is not None, "no scale"
    low, high = legend.scale
    assert abs(low) < 1e-9 and abs(high - 10.0) < 1e-9, legend.scale
    h.picture("colour_Result")
    close_panel()
    obj.Height = 12
    doc.recompute()
    select(made)
    click(tool_button("Tsolid_Rebuild"))
    until(h.finished, what="the rebuild")
    close_panel()
    assert results.of(made) is None


def names_in(place):
    return [a.objectName() for a in place.actions()]


def solved_in_the_fem_workbench():
    """From the FEM workbench's own tool bar into an analysis, solved by CalculiX, shown."""
    try:
        Gui.activateWorkbench("FemWorkbench")
        pump(0.5)
        _meshed_and_solved()
    finally:
        Gui.activateWorkbench("TsolidWorkbench")
        pump(0.3)


def _meshed_and_solved():
    doc = App.newDocument("Fem")
    obj, made = beam(doc)
    window = h.window()
    bars = [b for b in window.findChildren(QtGui.QToolBar)
            if b.isVisible() and "FEM_MeshGmshFromShape" in names_in(b)]
    menus = [m for m in window.menuBar().findChildren(QtGui.QMenu)
             if "FEM_MeshGmshFromShape" in names_in(m)]
    assert bars and menus
    for place in bars + menus:
        names = names_in(place)
        here = names.index("FEM_MeshGmshFromShape")
        assert names[here + 1] == "Tsolid_HexBlocks" and names.count("Tsolid_HexBlocks") == 1
    Gui.runCommand("FEM_Analysis", 0)
    pump(0.3)
    analysis = doc.findObjects("Fem::FemAnalysis")[0]
    action = bars[0].actions()[names_in(bars[0]).index("Tsolid_HexBlocks")]
    select(made)
    click(bars[0].widgetForAction(action))
    write(part("size", QtGui.QLineEdit), "4")
    choose(part("order", QtGui.QComboBox), 1)
    click(part("mesh"))
    says("Meshed: ")
    lacking = part("lacks", QtGui.QLabel).text()
    close_panel()
    mesh = doc.findObjects("Fem::FemMeshObject")[0]
    assert mesh in analysis.Group
    assert "has no material" in lacking, lacking
    load(doc, analysis, obj)
    if shutil.which("ccx") is not None:
        solve(doc, analysis)
    else:
        sys.stderr.write("not solved: there is no ccx\n")


def load(doc, analysis, obj):
    """Steel, held at one end, 1 kN on the other."""
    import ObjectsFem

    at = {}
    for k, face in enumerate(obj.Shape.Faces):
        if face.BoundBox.XLength < 1e-9:
            at["fixed" if face.CenterOfMass.x < 1 else "loaded"] = "Face%d" % (k + 1)
    material = ObjectsFem.makeMaterialSolid(doc, "Material")
    values = material.Material
    values.update({"Name": "Steel", "YoungsModulus": "210000 MPa", "PoissonRatio": "0.3"})
    material.Material = values
    fixed = ObjectsFem.makeConstraintFixed(doc, "Fixed")
    fixed.References = [(obj, at["fixed"])]
    force = ObjectsFem.makeConstraintForce(doc, "Force")
    force.References = [(obj, at["loaded"])]
    try:
        force.Force = "1000 N"
    except TypeError:  # FreeCAD 0.20: a number of newtons
        force.Force = 1000.0
    force.Direction = (obj, [at["loaded"]])
    for found in (material, fixed, force):
        analysis.addObject(found)


def solve(doc, analysis):
    """By the tools that FreeCAD's own panel calls; the bar is stretched as by hand: 1 kN on
    80 mm^2 of steel over 40 mm."""
    import ObjectsFem
    from femtools import ccxtools

    # FreeCAD before 1.1 gives an analysis its solver, and spells it otherwise
    make = getattr(ObjectsFem, "makeSolverCalculiXCcxTools", None)
    solver = (make or ObjectsFem.makeSolverCalculixCcxTools)(doc)
    analysis.addObject(solver)
    solver.GeometricalNonlinearity, solver.MatrixSolverType = "linear", "default"
    with tempfile.TemporaryDirectory() as folder:
        run = ccxtools.FemToolsCcx(analysis, solver, test_mode=False)
        run.update_objects()
        run.setup_working_dir(folder)
        run.setup_ccx()
        assert run.check_prerequisites() == "", run.check_prerequisites()
        run.write_inp_file()
        assert os.path.exists(run.inp_file_name)
        run.ccx_run()
        run.load_results()
    pump(0.3)
    result = next(o for o in analysis.Group if o.isDerivedFrom("Fem::FemResultObject"))
    far = max(abs(v.x) for v in result.DisplacementVectors)
    by_hand = 1000.0 * 40 / (80 * 210000.0)
    assert abs(far - by_hand) < 0.03 * by_hand, (far, by_hand)
    mesh = next(o for o in doc.Objects if o.TypeId == "Fem::FemMeshObject" and o.Solid)
    mesh.ViewObject.setNodeDisplacementByVectors(result.NodeNumbers, result.DisplacementVectors)
    mesh.ViewObject.applyDisplacement(1000.0)
    pump(0.3)
    h.screen("fem_result")


CASES = (
    mesh_with_hex_blocks, mesh_follows_the_solid, mesh_refused, result_as_colours,
    solved_in_the_fem_workbench,
)
