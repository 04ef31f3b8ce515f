# SPDX-License-Identifier: LGPL-2.1-or-later
"""The check of an assembly in FreeCAD's window; cases of gui_cases.py."""

import os
import tempfile

import FreeCAD as App
import FreeCADGui as Gui
import Part
from PySide import QtGui

import gui_harness as h
from gui_harness import QTest, click, close_panel, part, select, tool_button, until


def box(doc, name, *place):
    obj = doc.addObject("Part::Box", name)
    obj.Placement.Base = App.Vector(*place)
    doc.recompute()
    return obj


def says(words):
    until(lambda: h.shown("verdict") and words in part("verdict").text(), 60, words)


def rows():
    tree = part("results", QtGui.QTreeWidget)
    tops = [tree.topLevelItem(k) for k in range(tree.topLevelItemCount())]
    return {top.text(0): [top.child(k) for k in range(top.childCount())] for top in tops}


def points():
    graph = Gui.ActiveDocument.ActiveView.getSceneGraph()
    return [c for c in graph.getChildren() if str(c.getName()) == "TsolidPoints"]


def selected():
    return sorted((s.ObjectName, name) for s in Gui.Selection.getSelectionEx("", 0)
                  for name in s.SubElementNames)


def check_assembly():
    """Watertight, then with a gap, then with a clash; a row selects both its faces."""
    doc = App.newDocument("Assembly")
    box(doc, "Left")
    right = box(doc, "Right", 10, 0, 0)
    Gui.ActiveDocument.ActiveView.viewIsometric()
    Gui.SendMsgToActiveView("ViewFit")
    Gui.Selection.clearSelection()
    click(tool_button("Tsolid_Assembly"))
    says("Watertight: 1 contacts, 1 of them proved")
    found = rows()
    assert list(found) == ["Conformal contact faces", "Parts", "Free faces"], list(found)
    item = found["Conformal contact faces"][0]
    assert item.text(1) == "Left Face2, Right Face1", item.text(1)
    assert not points()
    tree = part("results", QtGui.QTreeWidget)
    tree.scrollToItem(item)
    QTest.mouseClick(tree.viewport(), h.QtCore.Qt.LeftButton, h.QtCore.Qt.NoModifier,
                     tree.visualItemRect(item).topLeft() + h.QtCore.QPoint(40, 5))
    assert selected() == [("Left", "Face2"), ("Right", "Face1")], selected()
    right.Placement.Base.x = 10.05
    doc.recompute()
    click(part("start"))
    says("Not watertight: gaps of up to 0.05")
    assert "Gaps between parts" in rows() and len(points()) == 1
    h.screen("assembly_gap")
    gap = part("gap", QtGui.QLineEdit)
    gap.selectAll()
    QTest.keyClicks(gap, "0,01")
    click(part("start"))
    says("No parts touch")
    assert not points()
    right.Placement.Base.x = 9
    doc.recompute()
    click(part("start"))
    says("Parts penetrate each other: 1")
    assert len(points()) == 1 and "Clashes" in rows()
    h.screen("assembly_clash")
    with tempfile.TemporaryDirectory() as folder:
        for ending in ("html", "json", "csv"):
            path = os.path.join(folder, "out." + ending)
            _export(path)
            with open(path, encoding="utf-8") as stream:
                assert "Left" in stream.read(), ending
    click(part("copy"))
    assert "Left, Right" in QtGui.QApplication.clipboard().text()
    close_panel()
    assert not points()


def _export(path):
    def answer(dialog):
        if dialog.objectName() == "export_dialog":
            line = dialog.findChild(QtGui.QLineEdit)
            line.setText(path)
            QTest.keyClick(line, h.QtCore.Qt.Key_Return)

    with h.answering(answer):
        click(part("export"))
    h.pump(0.1)


def check_of_several_solids():
    """Check on a compsolid is the check of an assembly; on one of its solids it is not."""
    doc = App.newDocument("Several")
    halves = [Part.makeBox(10, 10, 10, App.Vector(x, 0, 0)) for x in (0, 10)]
    both = doc.addObject("Part::Feature", "Both")
    both.Shape = Part.CompSolid(halves[0].generalFuse(halves[1:])[0].Solids)
    one = doc.addObject("Part::Feature", "One")
    one.Shape = halves[0]
    doc.recompute()
    assert len(both.Shape.Solids) == 2
    select(both)
    click(tool_button("Tsolid_Check"))
    says("Watertight: 1 contacts, 1 of them proved")
    close_panel()
    select(one)
    click(tool_button("Tsolid_Check"))
    until(lambda: h.shown("verdict") and "Yes" in part("verdict").text(), 60, "one solid")
    close_panel()


def assembly_of_a_tree():
    """Parts in a moved container, one of them a Link; selected in the tree as one."""
    doc = App.newDocument("Tree")
    outer = doc.addObject("App::Part", "Outer")
    outer.Placement.Base = App.Vector(100, 0, 0)
    first = box(doc, "First")
    outer.addObject(first)
    link = doc.addObject("App::Link", "Copy")
    link.LinkedObject = first
    link.LinkPlacement = App.Placement(App.Vector(0, 10, 0), App.Rotation())
    outer.addObject(link)
    box(doc, "Alone", 0, 0, 50)
    doc.recompute()
    select(outer)
    click(tool_button("Tsolid_Assembly"))
    says("Watertight: 1 contacts, 1 of them proved")
    item = rows()["Conformal contact faces"][0]
    tree = part("results", QtGui.QTreeWidget)
    tree.setCurrentItem(item)
    assert selected() == [("Outer", "Copy.Face3"), ("Outer", "First.Face4")], selected()
    close_panel()


def bad_assembly():
    """One part only; a part deleted while the panel is open."""
    doc = App.newDocument("Bad")
    box(doc, "Left")
    h.pump(0.3)
    h.window().statusBar().clearMessage()
    Gui.Selection.clearSelection()
    click(tool_button("Tsolid_Assembly"))
    assert "two solids or more" in h.status_bar(), h.status_bar()
    right = box(doc, "Right", 10, 0, 0)
    Gui.Selection.clearSelection()
    click(tool_button("Tsolid_Assembly"))
    says("Watertight")
    item = rows()["Conformal contact faces"][0]
    doc.removeObject(right.Name)
    part("results", QtGui.QTreeWidget).setCurrentItem(item)
    click(part("start"))
    until(lambda: part("verdict").text() and "Watertight" not in part("verdict").text(), 30,
          "the refusal")
    close_panel()


CASES = (check_assembly, check_of_several_solids, assembly_of_a_tree, bad_assembly)
