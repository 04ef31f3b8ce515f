# SPDX-License-Identifier: LGPL-2.1-or-later
"""The panel "Check assembly": contacts, gaps and clashes between the parts of a document."""

import FreeCADGui as Gui
from PySide import QtGui
from PySide.QtCore import QT_TRANSLATE_NOOP

from . import api, assemblies, members, overlay, panels, rows, runner, view
from .runner import reference, tr


class AssemblyPanel(panels.Panel):
    """Given the objects to check; the whole document when there is but one, or none, selected."""

    title = QT_TRANSLATE_NOOP("tsolid", "Check assembly")
    icon = "tsolid_assembly"

    def __init__(self, objects, whole=False):
        self.objects, self.whole = list(objects), whole
        super().__init__(self.objects[0])

    def make(self):
        self.result, self.marks, self.groups = None, None, []
        if self.whole:
            self.name.setText(self.obj.Document.Label)
        form = QtGui.QFormLayout()
        self.gap = QtGui.QLineEdit()
        self.gap.setObjectName("gap")
        self.gap.setPlaceholderText(tr("a hundredth of the smaller part"))
        self.gap.setToolTip(tr("Faces that are no farther apart are reported, in millimetres"))
        form.addRow(tr("Gaps up to"), self.gap)
        self.layout.addLayout(form)
        self.start = self.add_buttons(("start", tr("Check"), self.check))[0]
        self.start.setDefault(True)
        self.verdict = panels.Verdict()
        self.layout.addWidget(self.verdict)
        self.add_progress()
        self.add_results()
        self.buttons = self.add_buttons(
            ("copy", tr("Copy as text"), self.copy), ("export", tr("Export..."), self.export)
        )
        for button in self.buttons:
            button.setEnabled(False)
        self.check()

    def check(self):
        text = self.gap.text().strip().replace(",", ".")
        try:
            gap = float(text) if text else None
            if gap is not None and not 0.0 <= gap < float("inf"):
                raise ValueError
        except ValueError:
            self.verdict.say(tr("%s is not a length") % text, "bad")
            return
        try:
            job = assemblies.AssemblyJob(self.objects, gap)
        except (ValueError, ReferenceError, RuntimeError) as error:
            self.verdict.say(runner.sentence_of(error), "bad")
            return
        Gui.Selection.clearSelection()
        self.verdict.hide()
        self.start.setEnabled(False)
        given = reference_of(self.obj.Document, self.objects)
        words = "" if gap is None else ", gap=%r" % gap
        line = "import freecad.tsolid as ts; ts.check_assembly(%s%s)" % (given, words)
        self.run(job, line, self.done)

    def done(self, state, result, sentence):
        self.start.setEnabled(True)
        if result is None:
            self.verdict.say(sentence, "unsure" if state == "cancelled" else "bad")
            return
        self.result = result
        self.groups = rows.of_assembly(result)
        self.verdict.say(result.headline(tr), "good" if result.watertight else "bad")
        self.tree.fill(self.groups)
        for button in self.buttons:
            button.setEnabled(True)
        self.draw()

    def draw(self):
        """Red points where gaps are largest and where parts clash."""
        self.tidy()
        current = view.active_view()
        bad = [i.point for i in self.result.interfaces if not i.tight]
        bad += [c.point for c in self.result.clashes]
        bad = [tuple(p) for p in bad if p is not None]
        if bad and current is not None:
            self.marks = overlay.Points(current, bad)

    def tidy(self):
        if self.marks is not None:
            self.marks.remove()
            self.marks = None

    def go_to(self, row):
        """Selects both faces, or parts, and looks at the place."""
        self.detail.setText(api.visible(row.sentence()))
        self.detail.show()
        Gui.Selection.clearSelection()
        place = row.point
        for k, face in getattr(row, "items", ()):
            part = self.result.parts[k]
            try:
                Gui.Selection.addSelection(part.obj.Document.Name, part.obj.Name,
                                           part.below(face))
            except (ReferenceError, RuntimeError, AttributeError):  # deleted meanwhile
                continue
            if place is None and face:
                place = overlay.place_of(part.shape, face)
            elif place is None:
                place = tuple(part.shape.BoundBox.Center)
        current = view.active_view()
        if place is not None and current is not None:
            sizes = [self.result.parts[k].shape.BoundBox.DiagonalLength
                     for k, _ in getattr(row, "items", ())]
            overlay.zoom_to(current, tuple(place), 0.5 * max(sizes, default=1.0))


def reference_of(doc, objects):
    """How a line of Python calls the objects: the document when it is all of them."""
    if objects == members.top_objects(doc):
        return "App.getDocument(%r)" % str(doc.Name)
    return "[%s]" % ", ".join(reference(o) for o in objects)
