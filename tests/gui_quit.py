# SPDX-License-Identifier: LGPL-2.1-or-later
"""FreeCAD is closed while it builds; started by test_gui.py. It must end by itself."""

import json
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import FreeCAD as App  # noqa: E402
import FreeCADGui as Gui  # noqa: E402
from PySide import QtCore, QtGui  # noqa: E402

import gui_harness as h  # noqa: E402


def go():
    outcome = ""
    try:
        Gui.activateWorkbench("TsolidWorkbench")
        h.pump(0.5)
        doc = App.newDocument("X")
        doc.addObject("Part::Box", "Box")
        doc.recompute()
        doc.saveAs(os.path.join(os.environ["HOME"], "quit.FCStd"))
        Gui.SendMsgToActiveView("Save")  # nobody is there to be asked about changes
        h.click(h.tool_button("Tsolid_Build"))
        h.choose(h.part("effort", QtGui.QComboBox), 3)
        h.click(h.part("start"))
        runner = h.task_panel_object().runner
        h.until(lambda: runner.task.snapshot()[0] == "optimise", what="the smoothing")
        assert runner.running
    except BaseException as error:
        outcome = repr(error)
    with open(h.RESULT, "w", encoding="utf-8") as stream:
        json.dump({"cases": {"quit": outcome}, "report view": ""}, stream)
    QtCore.QTimer.singleShot(0, h.window().close)


if os.environ.get("TSOLID_GUI_RESULT"):
    QtCore.QTimer.singleShot(1000, go)
