# SPDX-License-Identifier: LGPL-2.1-or-later
"""Run by FreeCAD at its start when it has a window: the workbench and its preferences page.

Nothing heavy is imported here; the library is not looked for before the first command.
"""

import FreeCADGui as Gui

from . import next_to_fem, places

TOOLBAR = (
    "Tsolid_Check",
    "Tsolid_Build",
    "Tsolid_Rebuild",
    "Tsolid_LookInside",
    "Tsolid_Report",
    "Tsolid_HexBlocks",
    "Tsolid_Assembly",
)


class TsolidWorkbench(Gui.Workbench):
    """Check, build and look inside solid T-splines."""

    MenuText = "tsolid"
    ToolTip = "Hex blocks with watertight borders from a part's spline faces"
    Icon = places.icon("tsolid")

    def GetClassName(self):
        return "Gui::PythonWorkbench"

    def Initialize(self):
        from PySide.QtCore import QT_TRANSLATE_NOOP

        from . import commands

        commands.register()
        title = QT_TRANSLATE_NOOP("Workbench", "Solid T-spline")
        self.appendToolbar(title, list(TOOLBAR))
        self.appendMenu(title, list(TOOLBAR) + ["Separator", "Tsolid_Export"])
        examples = QT_TRANSLATE_NOOP("Workbench", "Example parts")
        self.appendMenu([title, examples], commands.example_names())
        self.appendMenu("&Help", ["Tsolid_Manual"])

    def ContextMenu(self, recipient):
        self.appendContextMenu("", list(TOOLBAR))


Gui.addIconPath(places.ICONS)
Gui.addLanguagePath(places.TRANSLATIONS)
Gui.updateLocale()
Gui.addPreferencePage(places.resource("preferences.ui"), "tsolid")
Gui.addWorkbench(TsolidWorkbench())
next_to_fem.watch()
