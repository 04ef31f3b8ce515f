# SPDX-License-Identifier: LGPL-2.1-or-later
"""The manual in a window of its own: pages and pictures of this package, nothing from elsewhere."""

import os

import FreeCAD
import FreeCADGui as Gui
from PySide import QtCore, QtGui

from . import places

_window = []


def path():
    """The manual in the user's language, else in English."""
    language = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/General").GetString("Language")
    own = {"German": "index_de.html"}.get(language)
    if own and os.path.exists(places.resource("manual", own)):
        return places.resource("manual", own)
    return places.resource("manual", "index.html")


def show():
    if not _window:
        dialog = QtGui.QDialog(Gui.getMainWindow())
        dialog.setObjectName("tsolid_manual")
        dialog.setWindowTitle(FreeCAD.Qt.translate("tsolid", "Solid T-spline manual"))
        dialog.resize(860, 760)
        browser = QtGui.QTextBrowser()
        browser.setObjectName("page")
        browser.setOpenExternalLinks(True)
        layout = QtGui.QVBoxLayout(dialog)
        layout.addWidget(browser)
        dialog.browser = browser
        _window.append(dialog)
    dialog = _window[0]
    dialog.browser.setSource(QtCore.QUrl.fromLocalFile(path()))
    dialog.show()
    dialog.raise_()
    return dialog
