# SPDX-License-Identifier: LGPL-2.1-or-later
"""Picking vertices of a part in the 3D view that have to be corners of the cube."""

import re

import FreeCADGui as Gui
from PySide import QtGui

from . import panels
from .runner import tr

MOST = 8
_VERTEX = re.compile(r"(?:^|\.)(Vertex\d+)$")


class CornerPicker(QtGui.QGroupBox):
    """While "Pick" is on, a click on a vertex of the part takes it, a second click gives it back.

    names: what is picked; use(): called when the user wants the check to use it.
    """

    def __init__(self, obj, use):
        super().__init__(tr("Corners"))
        self.setObjectName("corners")
        self.obj, self.names = obj, []
        self.watching = False
        layout = QtGui.QVBoxLayout(self)
        self.text = panels.narrow(QtGui.QLabel())
        self.text.setObjectName("picked")
        self.text.setWordWrap(True)
        layout.addWidget(self.text)
        row = QtGui.QHBoxLayout()
        self.pick = self._button("pick", tr("Pick"), self.watch)
        self.pick.setCheckable(True)
        self.pick.setToolTip(tr("Click vertices of the part in the view: up to eight corners"))
        self.use = self._button("use_corners", tr("Check with these"), lambda: use())
        self.clear = self._button("clear_corners", tr("Automatic"), lambda: self._cleared(use))
        for button in (self.pick, self.use, self.clear):
            row.addWidget(button)
        layout.addLayout(row)
        self._show()

    def _button(self, name, text, clicked):
        button = panels.narrow(QtGui.QPushButton(text))
        button.setObjectName(name)
        button.clicked.connect(clicked)
        return button

    def watch(self, on):
        if on and not self.watching:
            Gui.Selection.clearSelection()
            Gui.Selection.addObserver(self)
        elif self.watching and not on:
            Gui.Selection.removeObserver(self)
        self.watching = bool(on)
        self._show()

    def stop(self):
        """The panel is closing."""
        if self.watching:
            self.watching = False
            Gui.Selection.removeObserver(self)

    def addSelection(self, doc, obj, sub, point):
        """Called by FreeCAD for every click that selects something."""
        found = _VERTEX.search(sub)
        path = [obj] + sub.split(".")[:-1]
        if not found or doc != self.obj.Document.Name or self.obj.Name not in path:
            return
        name = found.group(1)
        if name in self.names:
            self.names.remove(name)
        elif len(self.names) < MOST:
            self.names.append(name)
        self._show()

    def _cleared(self, use):
        self.names = []
        self._show()
        use()

    def _show(self):
        if self.names:
            text = tr("%d of 8 picked: %s") % (len(self.names), ", ".join(self.names))
        elif self.watching:
            text = tr("Click the vertices that have to be corners.")
        else:
            text = tr("Chosen automatically.")
        self.text.setText(text)
        self.use.setEnabled(bool(self.names))
        self.clear.setEnabled(bool(self.names))
