# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs inside a FreeCAD with a window: drives what is visible by mouse and keys, like a user.

Cases are functions without arguments; their outcome goes to the file TSOLID_GUI_RESULT, since
FreeCAD's own output is full of other things.
"""

import contextlib
import gc
import json
import os
import sys
import time
import traceback

import FreeCAD as App
import FreeCADGui as Gui
from PySide import QtCore, QtGui

try:
    from PySide2.QtTest import QTest
except ImportError:
    from PySide6.QtTest import QTest

PANELS = ("CheckPanel", "BuildPanel", "ReportPanel", "InsidePanel", "MeshPanel",
          "AssemblyPanel")
RESULT = os.environ["TSOLID_GUI_RESULT"]
PICTURES = os.environ.get("TSOLID_GUI_PICTURES", "")


def pump(seconds):
    """Lets the event loop run."""
    end = time.monotonic() + seconds
    while True:
        QtGui.QApplication.processEvents()
        if time.monotonic() >= end:
            return
        time.sleep(0.005)


def until(condition, seconds=120.0, what="the condition"):
    """Lets the event loop run until the condition holds; it must, in that time."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("waited %g s in vain for %s" % (seconds, what))
        QtGui.QApplication.processEvents()
        time.sleep(0.005)


def window():
    return Gui.getMainWindow()


def widgets(kind, name=None):
    """Visible widgets of the main window and of dialogs."""
    found = []
    for top in QtGui.QApplication.topLevelWidgets():
        found += [w for w in [top] + top.findChildren(kind) if isinstance(w, kind)]
    return [w for w in found if _is_shown(w, name)]


def _is_shown(widget, name):
    try:
        return name in (None, widget.objectName()) and widget.isVisible()
    except RuntimeError:  # a wrapper outlives the widget that it belonged to
        return False


def panel():
    """The task panel that is open; None when there is none."""
    found = [w for n in PANELS for w in widgets(QtGui.QWidget, n)]
    return found[-1] if found else None


def part(name, kind=QtGui.QWidget):
    """A visible widget of the open panel, which must be there."""
    current = panel()
    assert current is not None, "no panel is open"
    found = [w for w in current.findChildren(kind, name) if w.isVisible()]
    assert found, "the panel shows no %s" % name
    return found[0]


def shown(name):
    current = panel()
    return current is not None and any(w.isVisible() for w in current.findChildren(
        QtGui.QWidget, name))


def click(widget):
    # FreeCAD enables its buttons some time after what they depend on
    until(lambda: widget.isVisible() and widget.isEnabled(), 10,
          "%s to be clickable" % widget.objectName())
    place = widget.rect().center()
    if isinstance(widget, QtGui.QCheckBox):  # Qt 6 hears the box and its text only
        place.setX(10)
    QTest.mouseClick(widget, QtCore.Qt.LeftButton, QtCore.Qt.NoModifier, place)
    pump(0.05)


def tool_button(command):
    """The button of a command in a visible tool bar."""
    for button in widgets(QtGui.QToolButton):
        action = button.defaultAction()
        if action is not None and action.objectName() == command:
            return button
    raise AssertionError("no visible button for %s" % command)


def choose(combo, index):
    """An entry of a combo box, by keys."""
    combo.setFocus()
    for _ in range(combo.count()):
        QTest.keyClick(combo, QtCore.Qt.Key_Up)
    for _ in range(index):
        QTest.keyClick(combo, QtCore.Qt.Key_Down)
    pump(0.05)
    assert combo.currentIndex() == index


def close_panel():
    """By the Close button of the task panel."""
    for button in widgets(QtGui.QPushButton):
        if button.text().replace("&", "") == "Close" and panel() is not None:
            click(button)
            return


def task_panel_object():
    from freecad.tsolid import panels

    return panels.Panel.current


def status_bar():
    return window().statusBar().currentMessage()


def report_view():
    dock = window().findChild(QtGui.QDockWidget, "Report view")
    return dock.findChild(QtGui.QTextEdit).toPlainText()


def console():
    dock = window().findChild(QtGui.QDockWidget, "Python console")
    return dock.findChild(QtGui.QPlainTextEdit).toPlainText()


def select(obj, *sub):
    Gui.Selection.clearSelection()
    Gui.Selection.addSelection(obj.Document.Name, obj.Name, *sub)
    pump(0.05)


def finished():
    """The panel's work is done: its verdict is there."""
    return shown("verdict") and not task_panel_object().runner.running


def example(name):
    import freecad.tsolid as ts

    obj = ts.open_example(name)
    pump(0.3)
    return obj


def viewport():
    """The widget that the 3D view is drawn on."""
    view = window().findChild(QtGui.QMdiArea).activeSubWindow()
    for widget in view.findChildren(QtGui.QWidget):
        if "QOpenGLWidget" in widget.metaObject().className() or widget.metaObject().className() \
                in ("SIM::Coin3D::Quarter::QuarterWidget", "Gui::View3DInventorViewer"):
            last = widget
    return getattr(last, "viewport", lambda: last)()


def picture(name):
    """The 3D view from a fixed direction, to be compared with its reference by who started us."""
    view = Gui.ActiveDocument.ActiveView
    view.setCameraOrientation(App.Rotation(0.424708, 0.17592, 0.339851, 0.820473))
    view.fitAll()
    pump(0.2)
    if PICTURES:
        view.saveImage(os.path.join(PICTURES, name + ".png"), 480, 360, "White")


def screen(name):
    """The whole screen, for the manual and for a person to look at."""
    if PICTURES:
        pump(0.3)
        shot = QtGui.QApplication.primaryScreen().grabWindow(0)
        shot.save(os.path.join(PICTURES, "screen_" + name + ".png"))


@contextlib.contextmanager
def answering(act):
    """Meanwhile calls act(dialog) while a modal dialog is open, again and again; whatever act
    does, the dialog gets Escape in the end: a test must not wait for ever."""
    timer = QtCore.QTimer()
    rounds = []

    def look():
        dialog = QtGui.QApplication.activeModalWidget()
        if dialog is None:
            return
        rounds.append(0)
        try:
            act(dialog)
        except RuntimeError:  # a wrapper outlives the widget that it belonged to
            pass
        if len(rounds) > 20:
            QTest.keyClick(QtGui.QApplication.activeModalWidget() or dialog, QtCore.Qt.Key_Escape)

    timer.timeout.connect(look)
    timer.start(300)
    try:
        yield
    finally:
        timer.stop()


def close_documents():
    if panel() is not None:
        Gui.Control.closeDialog()
        pump(0.05)
    for name in list(App.listDocuments()):
        App.closeDocument(name)
    pump(0.1)


def run(cases, before=None):
    """Runs all cases when FreeCAD is up, writes their outcome and leaves."""

    def go():
        outcome = {}
        try:
            window().setGeometry(0, 0, 1400, 900)
            window().findChild(QtGui.QDockWidget, "Report view").setVisible(True)
            pump(0.2)
            if before is not None:
                before()
            wanted = os.environ.get("TSOLID_GUI_CASES", "").split()
            for case in cases:
                if wanted and case.__name__ not in wanted:
                    continue
                outcome[case.__name__] = one(case)
        except BaseException:
            outcome["harness"] = traceback.format_exc()
        with open(RESULT, "w", encoding="utf-8") as stream:
            json.dump({"cases": outcome, "report view": report_view(),
                       "version": App.Version()[:2]}, stream)
        sys.stderr.flush()
        os._exit(0)

    QtCore.QTimer.singleShot(1000, go)


def one(case):
    """"" when the case passed, else why not."""
    problem = ""
    start = time.monotonic()
    try:
        case()
    except BaseException:
        problem = traceback.format_exc()
        screen("failed_" + case.__name__)
    try:
        close_documents()
    except BaseException:
        problem += traceback.format_exc()
    gc.collect()  # wrappers of widgets that are gone
    sys.stderr.write("%s: %.1f s%s\n" % (case.__name__, time.monotonic() - start,
                                         " FAILED" if problem else ""))
    return problem
