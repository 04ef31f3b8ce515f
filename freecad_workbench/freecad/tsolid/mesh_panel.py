# SPDX-License-Identifier: LGPL-2.1-or-later
"""The panel "Mesh with hex blocks": hexahedra of a solid T-spline for FreeCAD's FEM workbench."""

import numpy as np
from PySide import QtGui
from PySide.QtCore import QT_TRANSLATE_NOOP

from . import fem, overlay, panels, view
from .runner import line_of, reference, tr

ORDERS = (1, 2)


class MeshPanel(panels.Panel):
    """Meshes a SolidTSpline, or meshes anew when it is given hex blocks."""

    title = QT_TRANSLATE_NOOP("tsolid", "Mesh with hex blocks")
    icon = "tsolid_mesh"

    def make(self):
        self.again = fem.is_hex_blocks(self.obj)
        self.solid = self.obj.Solid if self.again else self.obj
        self.job, self.seen = None, None
        self._options()
        self.verdict = panels.Verdict()
        self.layout.addWidget(self.verdict)
        if self.again and fem.is_out_of_date(self.obj):
            self.verdict.say(tr("Out of date: the solid has been rebuilt since."), "unsure")
        self.lacks = panels.narrow(QtGui.QLabel())
        self.lacks.setObjectName("lacks")
        self.lacks.setWordWrap(True)
        self.layout.addWidget(self.lacks)
        self.buttons = self.add_buttons(
            ("preview", tr("Preview"), self.preview), ("mesh", tr("Mesh"), self.mesh)
        )
        self.buttons[1].setDefault(True)
        self.add_progress()
        self.layout.addStretch()

    def _options(self):
        form = QtGui.QFormLayout()
        self.size = QtGui.QLineEdit()
        self.size.setObjectName("size")
        self.size.setPlaceholderText(tr("a twentieth of the part"))
        self.size.setToolTip(tr("Wanted length of the hexahedra's edges, in millimetres"))
        self.order = QtGui.QComboBox()
        self.order.setObjectName("order")
        for name, order in zip((tr("8 nodes (linear)"), tr("20 nodes (quadratic)")), ORDERS):
            self.order.addItem(name, order)
        self.grading = QtGui.QDoubleSpinBox()
        self.grading.setObjectName("grading")
        self.grading.setRange(0.01, 100.0)
        self.grading.setSingleStep(0.1)
        self.grading.setToolTip(tr("Thickness of the outermost layer over that of the innermost"))
        self.analysis = QtGui.QComboBox()
        self.analysis.setObjectName("analysis")
        self.analysis.addItem(tr("none"), None)
        for found in self.obj.Document.findObjects("Fem::FemAnalysis"):
            self.analysis.addItem(found.Label, found.Name)
        self.analysis.setCurrentIndex(min(1, self.analysis.count() - 1))
        form.addRow(tr("Size"), self.size)
        form.addRow(tr("Nodes"), self.order)
        form.addRow(tr("Grading"), self.grading)
        if not self.again:
            form.addRow(tr("Into analysis"), self.analysis)
        self.layout.addLayout(form)
        given = fem.options_of(self.obj) if self.again else fem.DEFAULTS
        self.size.setText("%g" % given["size"] if given["size"] else "")
        self.order.setCurrentIndex(ORDERS.index(given["order"]))
        self.grading.setValue(given["grading"])

    def options(self):
        """As the panel has them; raises ValueError with a sentence."""
        text = self.size.text().strip().replace(",", ".")
        try:
            size = float(text) if text else 0.0
        except ValueError:
            raise ValueError(tr("%s is not a number") % text) from None
        if not 0.0 <= size < float("inf"):
            raise ValueError(tr("the size must be a positive length"))
        order = self.order.itemData(self.order.currentIndex())
        return {"size": size, "order": order, "grading": self.grading.value()}

    # ---- work ----

    def _start(self, line, on_end):
        """Runs the job of the options in the panel: the one of the preview where they are still
        the same."""
        try:
            if not self.alive() or self.solid is None:
                raise ValueError(tr("The solid is gone."))
            options = self.options()
            if self.job is None or not self.job.fits("mesh", self.solid, options):
                self.job = fem.MeshJob(self.solid, options)
        except ValueError as error:
            self.verdict.say(str(error), "bad")
            return
        for button in self.buttons:
            button.setEnabled(False)
        self.verdict.hide()
        self.run(self.job, line(options), on_end)

    def preview(self):
        """Draws the hexahedra's faces on the part and counts; the document stays as it is."""
        self._start(lambda options: "", self.previewed)

    def previewed(self, state, result, sentence):
        self._ready()
        if result is None:
            self._refused(state, sentence)
            return
        self._draw(result.mesh)
        self._count(result.mesh, tr("Preview"))

    def mesh(self):
        self._start(self._line, self.meshed)

    def _line(self, options):
        if self.again:
            return line_of("mesh_anew", self.obj, **options)
        line = line_of("mesh_with_hex_blocks", self.solid, **options)
        name = self.analysis.itemData(self.analysis.currentIndex())
        if name is not None:
            container = reference(self.obj.Document.getObject(name))
            line = "%s, container=%s)" % (line[:-1], container)
        return line

    def meshed(self, state, result, sentence):
        self._ready()
        if result is None:
            self._refused(state, sentence)
            return
        self.tidy()  # the mesh itself is seen now
        self._count(result.mesh, tr("Meshed"))
        name = self.analysis.itemData(self.analysis.currentIndex())
        container = self.obj.Document.getObject(name) if name and not self.again else None
        if container is not None:
            self.lacks.setText("\n".join(fem.lacks(container)))

    def _ready(self):
        for button in self.buttons:
            button.setEnabled(True)

    def _refused(self, state, sentence):
        self.job = None
        self.verdict.say(sentence, "unsure" if state == "cancelled" else "bad")

    def _count(self, mesh, title):
        text = tr("%s: %d hexahedra, %d nodes, worst scaled Jacobian %.3g")
        numbers = (len(mesh.elements), len(mesh.nodes), mesh.worst)
        self.verdict.say(text % ((title,) + numbers), "good")

    # ---- what is drawn ----

    def _draw(self, mesh):
        self.tidy()
        current = view.active_view()
        if current is not None:
            self.seen = overlay.Wires(current, self.solid, *outlines(mesh))

    def tidy(self):
        if self.seen is not None:
            self.seen.remove()
            self.seen = None


def outlines(mesh):
    """The borders of the hexahedra's faces on the part: points, and rows of indices that end with
    -1; through the mid nodes of quadratic ones."""
    nodes = np.asarray(mesh.nodes, np.float32)
    elements = np.asarray(mesh.elements)
    corners = np.array(fem.FACES)[:, :4]
    loop = corners[:, [0, 1, 2, 3, 0]]
    if elements.shape[1] == 20:
        loop = np.zeros((6, 9), int)
        loop[:, 0:8:2], loop[:, 1:8:2] = corners, np.array(fem.FACES)[:, 4:]
        loop[:, 8] = loop[:, 0]
    index = []
    for faces in mesh.regions.values():
        faces = np.asarray(faces)
        rows = elements[faces[:, 0][:, None], loop[faces[:, 1]]]
        index.append(np.concatenate([rows, np.full((len(rows), 1), -1)], 1))
    return nodes, np.concatenate(index).astype(np.int32).reshape(-1)
