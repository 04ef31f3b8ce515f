# SPDX-License-Identifier: LGPL-2.1-or-later
"""A part with several possible cubes in FreeCAD's window: the user picks the corners; cases of
gui_cases.py."""

import re

import FreeCAD as App
import FreeCADGui as Gui
import Part
from PySide import QtGui

import gui_harness as h
from gui_harness import choose, click, close_panel, part, pump, select, tool_button, until


def chamfered(doc):
    """A box with one chamfered edge: ten vertices of three edges each."""
    box = Part.makeBox(10, 20, 30)
    obj = doc.addObject("Part::Feature", "Chamfered")
    obj.Shape = box.makeChamfer(3, [box.Edges[0]])
    doc.recompute()
    return obj


def notes():
    tree = part("results", QtGui.QTreeWidget)
    tops = [tree.topLevelItem(k) for k in range(tree.topLevelItemCount())]
    return [top.child(k).row.what for top in tops for k in range(top.childCount())]


def cube():
    """The corners that the check has taken."""
    text = next(n for n in notes() if "possible cube" in n)
    assert int(re.search(r"has (\d+) possible", text).group(1)) > 1, text
    return set(re.findall(r"Vertex\d+", text.split("taken")[1]))


def checked():
    until(lambda: h.shown("verdict") and part("verdict").text().startswith("Yes"), 60, "the check")


def pick_corners():
    """The other vertices are picked in the view; check and build take them."""
    doc = App.newDocument("Corners")
    obj = chamfered(doc)
    select(obj)
    click(tool_button("Tsolid_Check"))
    checked()
    taken = cube()
    assert len(taken) == 8
    other = sorted({"Vertex%d" % k for k in range(1, 11)} - taken)[0]
    assert part("picked").text() == "Chosen automatically."
    click(part("pick"))
    Gui.Selection.addSelection(doc.Name, obj.Name, "Face1")  # no vertex: no corner
    Gui.Selection.addSelection(doc.Name, obj.Name, other)
    Gui.Selection.addSelection(doc.Name, obj.Name, sorted(taken)[0])
    Gui.Selection.removeSelection(doc.Name, obj.Name, sorted(taken)[0])
    Gui.Selection.addSelection(doc.Name, obj.Name, sorted(taken)[0])  # a second click
    pump(0.1)
    assert part("picked").text() == "1 of 8 picked: " + other, part("picked").text()
    click(part("use_corners"))
    until(lambda: part("use_corners").isEnabled() and part("build").isEnabled(), 60, "the check")
    again = cube()
    assert other in again and again != taken, again
    click(part("build"))
    until(lambda: h.shown("effort"), 20, "the build panel")
    choose(part("effort", QtGui.QComboBox), 1)
    click(part("start"))
    until(h.finished, what="the build")
    made = h.task_panel_object().result.object
    assert list(made.Corners) == [other] and str(made.Status) == "built", made.Reason
    close_panel()


def no_observer_is_left():
    """Closing the panel while picking ends the picking."""
    doc = App.newDocument("Corners")
    obj = chamfered(doc)
    select(obj)
    click(tool_button("Tsolid_Check"))
    checked()
    click(part("pick"))
    picker = h.task_panel_object().picker
    assert picker.watching
    close_panel()
    assert not picker.watching
    Gui.Selection.addSelection(doc.Name, obj.Name, "Vertex1")
    assert picker.names == []


CASES = (pick_corners, no_observer_is_left)
