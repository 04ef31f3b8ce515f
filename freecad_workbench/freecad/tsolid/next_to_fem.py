# SPDX-License-Identifier: LGPL-2.1-or-later
"""Puts "Mesh with hex blocks" into the Mesh menu and tool bar of FreeCAD's FEM workbench.

FreeCAD builds both anew whenever that workbench is activated, so this is done every time.
"""

import FreeCADGui as Gui
from PySide import QtCore, QtGui

NAME = "Tsolid_HexBlocks"
NEIGHBOUR = "FEM_MeshGmshFromShape"


def watch():
    Gui.getMainWindow().workbenchActivated.connect(_activated)


def _activated(name):
    if name == "FemWorkbench":
        QtCore.QTimer.singleShot(0, insert)


def insert():
    """Behind the Gmsh command, wherever that stands."""
    from . import commands

    if NAME not in Gui.listCommands():
        commands.register()
    action = _action()
    window = Gui.getMainWindow()
    places = window.findChildren(QtGui.QToolBar) + window.menuBar().findChildren(QtGui.QMenu)
    for place in places:
        actions = place.actions()
        names = [a.objectName() for a in actions]
        if action is None or NEIGHBOUR not in names or NAME in names:
            continue
        rest = actions[names.index(NEIGHBOUR) + 1:]
        if rest:
            place.insertAction(rest[0], action)
        else:
            place.addAction(action)


def _action():
    """The command's QAction; None when FreeCAD has not made it."""
    found = Gui.Command.get(NAME)
    made = found.getAction() if found is not None else []
    return made[0] if made else None
