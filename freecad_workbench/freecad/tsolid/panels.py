# SPDX-License-Identifier: LGPL-2.1-or-later
"""Task panels. They show and ask; what is done is done by actions.py."""

import FreeCAD
import FreeCADGui as Gui
from PySide import QtCore, QtGui
from PySide.QtCore import QT_TRANSLATE_NOOP

from . import actions, api, document, files, overlay, rows, runner, view
from .runner import line_of, tr

_COLOURS = {rows.OK: "#2e7d32", rows.NOTE: "#55606e", rows.WARNING: "#b26a00", rows.BAD: "#c62828"}
_BACKGROUNDS = {"good": "#2e7d32", "unsure": "#b26a00", "bad": "#c62828", "busy": "#455a78"}


def stage_name(stage):
    """The library's stages in the user's words."""
    return {
        "": tr("Starting"),
        "shape": tr("Reading the faces"),
        "boundary": tr("Checking the faces"),
        "tmesh": tr("Laying out the hex blocks"),
        "space": tr("Making the spline functions"),
        "solid": tr("Filling the part"),
        "optimise": tr("Smoothing the hex blocks"),
        "certify": tr("Proving that nothing folds"),
        "write": tr("Storing"),
        "report": tr("Measuring"),
        "quality": tr("Measuring"),
        "evidence": tr("Comparing with the CAD faces"),
        "view": tr("Preparing the view"),
    }.get(stage, stage)


class Verdict(QtGui.QLabel):
    """One sentence on a coloured ground."""

    def __init__(self, name="verdict"):
        super().__init__()
        self.setObjectName(name)
        self.setWordWrap(True)
        self.setSizePolicy(QtGui.QSizePolicy.Ignored, QtGui.QSizePolicy.Minimum)
        self.hide()

    def say(self, text, kind):
        self.setText(text)
        self.setStyleSheet(
            "background: %s; color: white; padding: 6px; border-radius: 3px; font-weight: bold"
            % _BACKGROUNDS[kind]
        )
        self.show()


class Results(QtGui.QTreeWidget):
    """Groups of rows; clicking a row calls on_row(row)."""

    def __init__(self, on_row):
        super().__init__()
        self.setObjectName("results")
        self.setColumnCount(5)
        self.setHeaderLabels(
            [tr("What"), tr("Where"), tr("Measured"), tr("Allowed"), tr("Verdict")]
        )
        self.setAlternatingRowColors(True)
        self.setMinimumHeight(260)
        self.on_row = on_row
        self.itemClicked.connect(self._clicked)
        self.currentItemChanged.connect(lambda item, old: self._clicked(item))

    def fill(self, groups):
        self.clear()
        for group in groups:
            top = QtGui.QTreeWidgetItem([tr(group.title), "", "", "", tr(group.verdict)])
            top.setIcon(0, _spot(QtGui.QColor(_COLOURS[group.verdict]), False))
            font = top.font(0)
            font.setBold(True)
            top.setFont(0, font)
            self.addTopLevelItem(top)
            top.setFirstColumnSpanned(True)
            for row in group.rows:
                top.addChild(self._item(row))
            top.setExpanded(group.verdict == rows.BAD or len(group.rows) <= 8)
        for column in range(5):
            self.resizeColumnToContents(column)
        self.setColumnWidth(0, min(self.columnWidth(0), 150))

    def _item(self, row):
        cells = [api.visible(c) for c in row.cells()]
        cells[0], cells[-1] = tr(cells[0]), tr(cells[-1])
        item = QtGui.QTreeWidgetItem(cells)
        self._paint(item, row.verdict)
        colour = QtGui.QColor(_COLOURS[row.verdict])
        if row.side >= 0:
            colour = QtGui.QColor.fromRgbF(*overlay.SIDE_COLOURS[row.side])
        item.setIcon(0, _spot(colour, row.side >= 0))
        tip = cells[0]
        if row.point is not None:
            tip += " " + tr("at") + " (%.6g, %.6g, %.6g)" % row.point
        for column in range(5):
            item.setToolTip(column, tip)
        item.row = row
        return item

    @staticmethod
    def _paint(item, verdict):
        item.setForeground(4, QtGui.QBrush(QtGui.QColor(_COLOURS[verdict])))

    def _clicked(self, item, column=0):
        row = getattr(item, "row", None)
        if row is not None:
            self.on_row(row)


def narrow(widget):
    """Lets a widget be as narrow as the task panel is: 250 pixels on a fresh profile."""
    widget.setSizePolicy(QtGui.QSizePolicy.Ignored, widget.sizePolicy().verticalPolicy())
    return widget


def _spot(colour, square):
    """A small icon: a square in a side's colour, or a dot in a verdict's."""
    pixmap = QtGui.QPixmap(12, 12)
    pixmap.fill(QtCore.Qt.transparent)
    painter = QtGui.QPainter(pixmap)
    painter.setRenderHint(QtGui.QPainter.Antialiasing)
    painter.setPen(QtCore.Qt.NoPen)
    painter.setBrush(QtGui.QBrush(colour))
    if square:
        painter.drawRect(0, 0, 12, 12)
    else:
        painter.drawEllipse(2, 2, 8, 8)
    painter.end()
    return QtGui.QIcon(pixmap)


class Panel:
    """What all task panels have in common. FreeCAD stays usable while one is open."""

    title = ""
    icon = "tsolid"
    current = None  # the one that was opened last

    def __init__(self, obj):
        self.obj = obj
        self.document = obj.Document.Name
        self.runner = None
        self.closed = False
        self.form = QtGui.QWidget()
        self.form.setObjectName(type(self).__name__)
        self.form.setWindowTitle(tr(self.title))
        self.form.setWindowIcon(QtGui.QIcon(view.places.icon(self.icon)))
        self.layout = QtGui.QVBoxLayout(self.form)
        self.layout.setContentsMargins(4, 4, 4, 4)
        self.name = narrow(QtGui.QLabel(obj.Label))
        self.name.setObjectName("name")
        self.name.setToolTip(obj.Label)
        self.layout.addWidget(self.name)
        Panel.current = self
        self.make()

    def getStandardButtons(self):
        button = QtGui.QDialogButtonBox.Close
        try:
            return int(button)  # PySide2
        except TypeError:
            return button  # PySide6

    def isAllowedAlterSelection(self):
        return True

    def isAllowedAlterView(self):
        return True

    def isAllowedAlterDocument(self):
        return True

    def needsFullSpace(self):
        return True

    def make(self):
        pass

    def tidy(self):
        """Takes away what the panel has put into the view."""

    def reject(self):
        """While work runs, the first Close only stops it."""
        if self.runner is not None and self.runner.running:
            self.cancel()
            return False
        self.close()
        return True

    def is_open(self):
        try:
            return not self.closed and bool(self.form.objectName())
        except (RuntimeError, AttributeError):  # closed by FreeCAD, which takes the form away
            return False

    def close(self):
        self.tidy()
        self.closed = True
        if Panel.current is self:
            Panel.current = None  # it holds what it has shown
        Gui.Control.closeDialog()

    def cancel(self):
        if self.runner is not None:
            self.runner.cancel()

    def alive(self):
        """Is the object still there?"""
        try:
            return self.obj.Document is not None and bool(self.obj.Name)
        except (ReferenceError, RuntimeError):  # deleted, or only held by undo
            return False

    # ---- pieces ----

    def add_progress(self):
        self.bar = QtGui.QProgressBar()
        self.bar.setObjectName("progress")
        self.bar.setRange(0, 1000)
        self.stage = narrow(QtGui.QLabel())
        self.stage.setObjectName("stage")
        self.stop = QtGui.QPushButton(tr("Cancel"))
        self.stop.setObjectName("cancel")
        self.stop.clicked.connect(self.cancel)
        self.busy = QtGui.QWidget()
        inner = QtGui.QVBoxLayout(self.busy)
        inner.setContentsMargins(0, 0, 0, 0)
        for widget in (self.stage, self.bar, self.stop):
            inner.addWidget(widget)
        self.layout.addWidget(self.busy)
        self.busy.hide()

    def run(self, job, line, on_end):
        self.stop.setEnabled(True)
        self.busy.show()
        self.progress("", 0.0, None)

        def end(state, result, sentence):
            # in a turn of its own: first FreeCAD draws what is new
            QtCore.QTimer.singleShot(0, lambda: self._ended(on_end, state, result, sentence))

        self.runner = runner.Runner(job, line, self.progress, end).start()

    def _ended(self, on_end, state, result, sentence):
        try:
            self.busy.hide()
            on_end(state, result, sentence)
        except RuntimeError:  # the panel was closed meanwhile, and its widgets are gone
            pass

    def progress(self, stage, overall, remaining):
        text = stage_name(stage)
        if remaining is not None:
            text += ", " + tr("about %d s left") % max(1, round(remaining))
        if self.runner is not None and self.runner.task.cancelled_at is not None:
            text = tr("Stopping")
            self.stop.setEnabled(False)
        self.stage.setText(text)
        self.bar.setValue(int(1000 * overall))

    def add_buttons(self, *pairs):
        """A row of push buttons: (object name, text, function)."""
        box = QtGui.QHBoxLayout()
        made = []
        for name, text, function in pairs:
            button = QtGui.QPushButton(text)
            button.setObjectName(name)
            button.clicked.connect(function)
            box.addWidget(narrow(button))
            made.append(button)
        self.layout.addLayout(box)
        return made

    def add_results(self):
        """The table, and under it the whole sentence of the row that is chosen."""
        self.tree = Results(self.go_to)
        self.layout.addWidget(self.tree)
        self.detail = narrow(QtGui.QLabel())
        self.detail.setObjectName("detail")
        self.detail.setWordWrap(True)
        self.detail.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
        self.detail.hide()
        self.layout.addWidget(self.detail)

    def go_to(self, row):
        """Selects what a row names and looks at its place."""
        self.detail.setText(api.visible(row.sentence()))
        self.detail.show()
        if not self.alive():
            return
        target = actions.source_of(self.obj) or self.obj
        Gui.Selection.clearSelection()
        for name in overlay.sub_elements(row.where):
            Gui.Selection.addSelection(target.Document.Name, target.Name, name)
        point = row.point or overlay.place_of(target.Shape, row.where)
        current = view.active_view()
        if point is not None and current is not None:
            outer = target.getGlobalPlacement().multiply(target.Placement.inverse())
            place = outer.multVec(FreeCAD.Vector(*point))
            size = max(target.Shape.BoundBox.DiagonalLength, 1e-9)
            overlay.zoom_to(current, tuple(place), 0.35 * size)

    def copy(self):
        """All rows as text, under the panel's name and verdict."""
        text = rows.text("%s: %s" % (self.name.text(), self.verdict.text()), self.groups)
        QtGui.QApplication.clipboard().setText(text)
        runner.say(tr("Copied."))

    def export(self):
        """The rows of a check as a file."""
        path = self.ask_file([tr("Web page") + " (*.html)", "JSON (*.json)", "CSV (*.csv)"])
        if path:
            try:
                files.write_check(self.result, path)
                runner.say(tr("Written: %s") % path)
            except files.FileError as error:
                self.verdict.say(str(error), "bad")

    def ask_file(self, kinds):
        """A file name to write to; "" when the user thinks better of it."""
        dialog = QtGui.QFileDialog(self.form, tr("Export"))
        dialog.setObjectName("export_dialog")
        dialog.setAcceptMode(QtGui.QFileDialog.AcceptSave)
        dialog.setOption(QtGui.QFileDialog.DontUseNativeDialog, True)
        dialog.setNameFilters(kinds)
        dialog.setDefaultSuffix(kinds[0].split("*.")[1].rstrip(")"))
        dialog.filterSelected.connect(
            lambda text: dialog.setDefaultSuffix(text.split("*.")[1].rstrip(")"))
        )
        if not dialog.exec_():
            return ""
        return dialog.selectedFiles()[0]


# ---- check ---------------------------------------------------------------------------------------


class CheckPanel(Panel):
    title = QT_TRANSLATE_NOOP("tsolid", "Check")
    icon = "tsolid_check"

    def make(self):
        self.result = None
        self.overlay = None
        self.verdict = Verdict()
        self.layout.addWidget(self.verdict)
        self.add_progress()
        self.add_results()
        self.show_cube = narrow(QtGui.QCheckBox(tr("Draw sides and corners")))
        self.show_cube.setObjectName("show_cube")
        self.show_cube.setChecked(True)
        self.show_cube.toggled.connect(lambda on: self.draw())
        self.layout.addWidget(self.show_cube)
        from . import corner_picker

        self.picker = corner_picker.CornerPicker(self.obj, self.check)
        self.layout.addWidget(self.picker)
        self.buttons = self.add_buttons(
            ("build", tr("Build..."), self.go_on),
            ("copy", tr("Copy as text"), self.copy),
            ("export", tr("Export..."), self.export),
        )
        self.check()

    def check(self):
        """With the corners that are picked, if any."""
        if not self.alive():
            self.verdict.say(tr("The part is gone."), "bad")
            return
        for widget in self.buttons + [self.picker]:
            widget.setEnabled(False)
        Gui.Selection.clearSelection()  # its green would hide the sides' colours
        corners = list(self.picker.names)
        job = actions.Job("check", self.obj, api.Options(corners=corners))
        self.run(job, line_of("check", self.obj, corners=corners or None), self.done)

    def done(self, state, result, sentence):
        self.picker.setEnabled(True)
        if result is None:
            self.verdict.say(sentence, "unsure" if state == "cancelled" else "bad")
            return
        self.result = result
        self.groups = rows.of_check(result)
        headline = rows.headline_of_check(result, tr)
        self.verdict.say(headline, "good" if result.satisfied else "bad")
        self.tree.fill(self.groups)
        self.buttons[0].setEnabled(result.satisfied)
        self.buttons[1].setEnabled(True)
        self.buttons[2].setEnabled(True)
        self.draw()

    def draw(self):
        self.wipe()
        current = view.active_view()
        if self.result is not None and self.show_cube.isChecked() and current is not None:
            self.overlay = overlay.Overlay(current, self.obj, self.result)

    def wipe(self):
        if self.overlay is not None:
            self.overlay.remove()
            self.overlay = None

    def tidy(self):
        self.wipe()
        self.picker.stop()

    def go_on(self):
        """To the build panel of the same part."""
        self.close()
        obj, corners = self.obj, self.picker.names
        QtCore.QTimer.singleShot(0, lambda: Gui.Control.showDialog(BuildPanel(obj, corners)))


# ---- build ---------------------------------------------------------------------------------------


def preferences():
    return FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Mod/tsolid")


class BuildPanel(Panel):
    """Builds a part, or rebuilds a SolidTSpline when it is given one."""

    title = QT_TRANSLATE_NOOP("tsolid", "Build")
    icon = "tsolid_build"

    def __init__(self, obj, corners=()):
        self.corners = tuple(corners)
        super().__init__(obj)

    def make(self):
        self.again = document.is_solid_tspline(self.obj)
        self.result = None
        if self.again:
            self.form.setWindowTitle(tr("Rebuild"))
        self.verdict = Verdict()
        self.layout.addWidget(self.verdict)
        self._options()
        self.start = self.add_buttons(("start", self.form.windowTitle(), self.build))[0]
        self.start.setDefault(True)
        self.add_progress()
        self.after = self.add_buttons(
            ("inside", tr("Look inside"), lambda: self.go_on(_inside_panel)),
            ("report", tr("Report"), lambda: self.go_on(ReportPanel)),
        )
        for button in self.after:
            button.setEnabled(False)
        self.add_results()
        self.tree.hide()
        self.layout.addStretch()

    def _options(self):
        """The few options that matter."""
        self.form_options = QtGui.QGroupBox(tr("Options"))
        form = QtGui.QFormLayout(self.form_options)
        self.effort = QtGui.QComboBox()
        self.effort.setObjectName("effort")
        names = (tr("Default"), tr("None"), tr("Quick"), tr("Thorough"))
        for name, effort in zip(names, api.EFFORTS):
            self.effort.addItem(name, effort)
        self.effort.setToolTip(tr("How long to work on the shape of the hex blocks inside"))
        self.refine = QtGui.QSpinBox()
        self.refine.setObjectName("refine")
        self.refine.setRange(0, 6)
        self.refine.setToolTip(tr("Halve the spans of the faces so often: exact, more hex blocks"))
        self.cells = QtGui.QSpinBox()
        self.cells.setObjectName("cells")
        self.cells.setRange(0, 64)
        self.cells.setSpecialValueText(tr("automatic"))
        self.cells.setToolTip(tr("Hex blocks across the core of the part, at least"))
        self.tolerance = QtGui.QLineEdit()
        self.tolerance.setObjectName("tolerance")
        self.tolerance.setPlaceholderText("1e-7")
        self.tolerance.setToolTip(tr("Of edges that carry none of their own, in the part's unit"))
        form.addRow(tr("Smoothing effort"), self.effort)
        form.addRow(tr("Refine the faces"), self.refine)
        form.addRow(tr("Blocks across the core"), self.cells)
        form.addRow(tr("Tolerance of edges"), self.tolerance)
        self.layout.addWidget(self.form_options)
        if self.again:
            given = document.options_of(self.obj)
        else:
            given = api.Options()
            # the preferences page stores the number of the entry
            given.effort = api.EFFORTS[preferences().GetInt("Effort", 0) % len(api.EFFORTS)]
        self.effort.setCurrentIndex(api.EFFORTS.index(given.effort))
        self.refine.setValue(given.refine_knots)
        self.cells.setValue(given.min_cells)
        self.tolerance.setText("%g" % given.tolerance if given.tolerance else "")
        self.not_shown = {name: getattr(given, name)
                          for name in ("raise_degree", "octree", "analysis_suitable", "corners")}
        if self.corners:
            self.not_shown["corners"] = self.corners

    def options(self):
        """As the panel has them; raises ValueError with a sentence."""
        text = self.tolerance.text().strip().replace(",", ".")
        try:
            tolerance = float(text) if text else 0.0
        except ValueError:
            raise ValueError(tr("%s is not a number") % text) from None
        return api.Options(
            refine_knots=self.refine.value(),
            min_cells=self.cells.value(),
            effort=self.effort.itemData(self.effort.currentIndex()),
            tolerance=tolerance,
            threads=preferences().GetInt("Threads", 0),
            **self.not_shown,
        )

    def build(self):
        if not self.alive():
            self.verdict.say(tr("The part is gone."), "bad")
            return
        try:
            options = self.options()
            if self.again:
                self._keep_options(options)
            job = actions.Job("rebuild" if self.again else "build", self.obj, options)
        except ValueError as error:
            self.verdict.say(str(error), "bad")
            return
        self.start.setEnabled(False)
        self.form_options.setEnabled(False)
        self.verdict.hide()
        self.tree.hide()
        if self.again:
            line = line_of("rebuild", self.obj)
        else:
            default = api.Options().as_dict()
            changed = {k: v for k, v in options.as_dict().items() if v != default[k]}
            line = line_of("build", self.obj, **changed)
        self.run(job, line, self.done)

    def _keep_options(self, options):
        if options.as_dict() != document.options_of(self.obj).as_dict():
            with actions.transaction(self.obj.Document, "Options of solid T-spline"):
                document.set_options(self.obj, options)

    def done(self, state, result, sentence):
        self.start.setEnabled(True)
        self.form_options.setEnabled(True)
        if result is None:
            self.verdict.say(sentence, "unsure" if state == "cancelled" else "bad")
            return
        self.result = result
        built = result.solid is not None
        if built:
            kind = {"positive": "good", "undecided": "unsure"}.get(result.verdict, "bad")
            self.verdict.say(rows.headline_of_report(result.report, tr), kind)
            groups = rows.of_report(result.report)
            if not self.again:  # what was built is seen at once: coloured, and cut open
                show = line_of("look_inside", result.object, mode="Elements", cut=(0, 0.45))
                runner.execute(show)
        else:
            self.verdict.say(rows.headline_of_check(result, tr), "bad")
            groups = rows.of_check(result)
        self.tree.fill(groups)
        self.tree.show()
        for button in self.after:
            button.setEnabled(built)

    def go_on(self, kind):
        obj = self.result.object
        self.close()
        QtCore.QTimer.singleShot(0, lambda: Gui.Control.showDialog(kind(obj)))


def _inside_panel(obj):
    from .inside import InsidePanel

    return InsidePanel(obj)


# ---- report --------------------------------------------------------------------------------------


class ReportPanel(Panel):
    title = QT_TRANSLATE_NOOP("tsolid", "Report")
    icon = "tsolid_report"

    def make(self):
        self.verdict = Verdict()
        self.layout.addWidget(self.verdict)
        self.state = QtGui.QLabel()
        self.state.setObjectName("state")
        self.state.setWordWrap(True)
        self.layout.addWidget(self.state)
        self.add_results()
        self.add_buttons(
            ("copy", tr("Copy as text"), self.copy), ("export", tr("Export..."), self.export)
        )
        runner.execute(line_of("report", self.obj))
        self.fill()

    def fill(self):
        report = document.report_of(self.obj)
        kind = {"positive": "good", "undecided": "unsure"}.get(report["verdict"], "bad")
        self.groups = rows.of_report(report)
        self.verdict.say(rows.headline_of_report(report, tr), kind)
        self.state.setText(document.status_text(self.obj))
        self.tree.fill(self.groups)

    def export(self):
        path = self.ask_file(
            [tr("Web page") + " (*.html)", "JSON (*.json)", "CSV (*.csv)",
             tr("Solid T-spline") + " (*.tsolid)", tr("Bezier hexahedra") + " (*.vtu)"]
        )
        if path:
            try:
                with view.wait_cursor():
                    runner.execute(line_of("export", self.obj, path=path))
                runner.say(tr("Written: %s") % path)
            except Exception as error:
                self.verdict.say(runner.sentence_of(error), "bad")
