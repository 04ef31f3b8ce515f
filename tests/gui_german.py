# SPDX-License-Identifier: LGPL-2.1-or-later
"""In a window in German whose library is missing; started by test_gui.py."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import FreeCAD as App  # noqa: E402
import FreeCADGui as Gui  # noqa: E402

import gui_harness as h  # noqa: E402


def translated():
    action = h.tool_button("Tsolid_Check").defaultAction()
    assert action.text().replace("&", "") == "Prüfen", action.text()
    titles = [a.text().replace("&", "") for a in h.window().menuBar().actions()]
    assert "Volumen-T-Spline" in titles, titles
    from freecad.tsolid import panels, rows

    tree = panels.Results(lambda row: None)
    need = {"closed": True, "connected": True, "genus": 0, "n_patches": 6, "n_edges": 12,
            "n_vertices": 8, "n_violations": 1}
    tree.fill(rows._requirement(need))
    top = tree.topLevelItem(0)
    assert (top.text(0), top.text(4)) == ("Wasserdicht und wie ein Würfel", "abgelehnt")
    assert top.child(0).text(0) == "wasserdicht: jede Kante hat zwei Flächen"


def library_missing():
    """One dialog that says what to do; nothing else."""
    doc = App.newDocument("X")
    doc.addObject("Part::Box", "Box")
    doc.recompute()
    texts = []

    def read(box):
        assert box.objectName() == "tsolid_library_missing"
        texts.append(box.text() + box.informativeText())
        h.screen("library_missing")
        box.accept()

    with h.answering(read):
        h.click(h.tool_button("Tsolid_Check"))
    h.pump(0.2)
    assert len(set(texts)) == 1, texts
    assert "no_such_library.so" in texts[0] and "cmake --install" in texts[0], texts
    assert h.panel() is None


def activate():
    Gui.activateWorkbench("TsolidWorkbench")
    h.pump(0.5)


if os.environ.get("TSOLID_GUI_RESULT"):
    h.run((translated, library_missing), activate)
