# SPDX-License-Identifier: LGPL-2.1-or-later
"""The panel to look inside a solid: what is shown, what colours say, and two sliders."""

import FreeCAD
import FreeCADGui as Gui
from PySide import QtCore, QtGui
from PySide.QtCore import QT_TRANSLATE_NOOP

from . import actions, panels, runner, view
from .runner import line_of, tr


class Legend(QtGui.QWidget):
    """What the colours mean: a scale, or patches with names."""

    def __init__(self):
        super().__init__()
        self.setObjectName("legend")
        self.setMinimumHeight(44)
        self.scale, self.names = None, []

    def show_scale(self, low, high, below=None):
        """A continuous scale from low to high; below: (text, colour) of what lies under it."""
        self.scale, self.names = (low, high), [below] if below else []
        self.setMinimumHeight(64 if below else 44)
        self.update()

    def show_names(self, names):
        """[(text, colour)]"""
        self.scale, self.names = None, names
        self.setMinimumHeight(20 * max(1, len(names)) + 4)
        self.update()

    def paintEvent(self, event):
        painter = QtGui.QPainter(self)
        painter.setPen(self.palette().color(QtGui.QPalette.WindowText))
        if self.scale is None:
            for k, (text, colour) in enumerate(self.names):
                self._patch(painter, 2, 4 + 20 * k, text, colour)
        else:
            self._scale(painter)
        painter.end()

    def _patch(self, painter, x, y, text, colour):
        painter.fillRect(x, y, 16, 14, QtGui.QColor.fromRgbF(*[float(c) for c in colour]))
        painter.drawText(x + 22, y + 12, text)

    def _scale(self, painter):
        from . import tessellate

        left, width = 2, max(40, self.width() - 6)
        gradient = QtGui.QLinearGradient(left, 0, left + width, 0)
        for k, colour in enumerate(tessellate.SCALE):
            rgb = QtGui.QColor.fromRgbF(*[float(c) for c in colour])
            gradient.setColorAt(k / (len(tessellate.SCALE) - 1), rgb)
        painter.fillRect(left, 4, width, 16, QtGui.QBrush(gradient))
        low, high = self.scale
        flags = QtCore.Qt.AlignVCenter
        for k in range(3):
            value = "%.3g" % (low + (high - low) * k / 2)
            align = (QtCore.Qt.AlignLeft, QtCore.Qt.AlignHCenter, QtCore.Qt.AlignRight)[k]
            painter.drawText(QtCore.QRect(left, 20, width, 20), align | flags, value)
        if self.names:
            self._patch(painter, 2, 44, *self.names[0])


class InsidePanel(panels.Panel):
    title = QT_TRANSLATE_NOOP("tsolid", "Look inside")
    icon = "tsolid_inside"

    def make(self):
        self.vobj = self.obj.ViewObject
        self.proxy = view.proxy_of(self.obj)
        self.picker = None
        self._choices()
        self._sliders()
        self.facts = QtGui.QTableWidget(0, 2)
        self.facts.setObjectName("facts")
        self.facts.setHorizontalHeaderLabels([tr("Element"), tr("Click one in the view")])
        self.facts.horizontalHeader().setStretchLastSection(True)
        self.facts.verticalHeader().hide()
        self.facts.setMinimumWidth(0)
        panels.narrow(self.facts)
        self.facts.setEditTriggers(QtGui.QAbstractItemView.NoEditTriggers)
        self.layout.addWidget(self.facts)
        self.add_buttons(("whole", tr("Show the whole part"), self.whole))
        Gui.Selection.clearSelection()  # its green would hide the colours
        mode = str(self.vobj.DisplayMode)
        self.change(mode=mode if mode in actions.MODES[1:] else "Elements")
        self.read()
        self._pick()

    # ---- widgets ----

    def _choices(self):
        form = QtGui.QFormLayout()
        self.mode, self.colour = QtGui.QComboBox(), QtGui.QComboBox()
        self.mode.setObjectName("mode")
        self.colour.setObjectName("colour")
        modes = (tr("Solid"), tr("Hex blocks"), tr("T-mesh"), tr("Control net"), tr("Parts"))
        for name, mode in zip(modes, actions.MODES):
            self.mode.addItem(name, mode)
        colours = (tr("Scaled Jacobian"), tr("Continuity"), tr("Element size"), tr("Parts"),
                   tr("Result"))
        for name, colour in zip(colours, actions.COLOURS):
            self.colour.addItem(name, colour)
        self.mode.activated.connect(lambda k: self.change(mode=self.mode.itemData(k)))
        self.colour.activated.connect(lambda k: self.change(colour=self.colour.itemData(k)))
        panels.narrow(self.mode)
        panels.narrow(self.colour)
        form.addRow(tr("Show"), self.mode)
        form.addRow(tr("Colours"), self.colour)
        self.layout.addLayout(form)
        self.legend = Legend()
        self.layout.addWidget(self.legend)
        self.borders = panels.narrow(QtGui.QCheckBox(tr("Borders of the hex blocks")))
        self.borders.setObjectName("borders")
        self.borders.toggled.connect(lambda on: setattr(self.vobj, "ShowBorders", on))
        self.layout.addWidget(self.borders)

    def _sliders(self):
        form = QtGui.QFormLayout()
        self.peel = self._slider("peel", 1, self._peel_moved)
        self.axis = QtGui.QComboBox()
        self.axis.setObjectName("axis")
        self.axis.addItems(["X", "Y", "Z"])
        self.axis.activated.connect(lambda k: self.change(cut=self.cut()))
        self.share = self._slider("cut", 100, self._cut_moved)
        row = QtGui.QHBoxLayout()
        row.addWidget(self.axis)
        row.addWidget(self.share)
        form.addRow(tr("Peel off layers"), self.peel)
        form.addRow(tr("Cut open across"), row)
        self.along = panels.narrow(QtGui.QCheckBox(tr("Cut along the blocks")))
        self.along.setObjectName("along")
        self.along.toggled.connect(lambda on: self.change(along_blocks=on))
        form.addRow(self.along)
        self.layout.addLayout(form)

    def _slider(self, name, most, moved):
        slider = QtGui.QSlider(QtCore.Qt.Horizontal)
        slider.setObjectName(name)
        slider.setRange(0, most)
        slider.setTickPosition(QtGui.QSlider.TicksBelow)
        slider.setTickInterval(max(1, most // 10))
        slider.valueChanged.connect(moved)
        slider.sliderReleased.connect(self._released)
        return slider

    # ---- to the object and back ----

    def read(self):
        """The widgets as the object has it."""
        vobj = self.vobj
        for widget in (self.peel, self.share, self.axis, self.along, self.borders):
            widget.blockSignals(True)
        if self.proxy.look is not None:
            self.peel.setRange(0, self.proxy.look.n_layers - 1)
        self.peel.setValue(vobj.Peel)
        self.share.setValue(round(100 * vobj.CutShare))
        self.axis.setCurrentIndex("XYZ".index(str(vobj.CutAxis)))
        self.borders.setChecked(vobj.ShowBorders)
        self.along.setChecked(vobj.CutAlongBlocks)
        for widget in (self.peel, self.share, self.axis, self.along, self.borders):
            widget.blockSignals(False)
        self.mode.setCurrentIndex(actions.MODES.index(self._mode()))
        self.colour.setCurrentIndex(actions.COLOURS.index(str(vobj.ColourBy)))
        self._show_legend()

    def _mode(self):
        Gui.Selection.clearSelection()  # its green would hide the colours
        mode = str(self.vobj.DisplayMode)
        return mode if mode in actions.MODES else actions.MODES[0]

    def cut(self):
        return self.axis.currentIndex(), self.share.value() / 100.0

    def change(self, **what):
        """One line for the console, executed."""
        if self.alive():
            runner.execute(line_of("look_inside", self.obj, **what))
            self.proxy.ensure()
            self.read()

    def _peel_moved(self, value):
        if self.peel.isSliderDown():
            self.vobj.Peel = value  # the line follows when the slider is let go
        else:
            self.change(peel=value)

    def _cut_moved(self, value):
        if self.share.isSliderDown():
            self.vobj.CutAxis = "XYZ"[self.axis.currentIndex()]
            self.vobj.CutShare = value / 100.0
        else:
            self.change(cut=self.cut())

    def _released(self):
        self.change(peel=self.peel.value(), cut=self.cut())

    def whole(self):
        self.change(peel=0, cut=(self.axis.currentIndex(), 1.0))

    def _show_legend(self):
        from . import tessellate

        by = "Parts" if self._mode() == "Parts" else str(self.vobj.ColourBy)
        if self._mode() in ("T-mesh", "Control net"):
            by = "Parts"
        if self._mode() == "Solid" or self.proxy.look is None:
            self.legend.show_names([])
        elif by == "Scaled Jacobian":
            self.legend.show_scale(0.0, 1.0, (tr("folded"), tessellate.FOLDED))
        elif by == "Element size":
            self.legend.show_scale(*self.proxy.look.size_range())
        elif by == "Result":
            if self.proxy.look.result is None:
                self.legend.show_names([(tr("none"), tessellate.ORDER_COLOURS[tessellate.OUTSIDE])])
            else:
                self.legend.show_scale(*self.proxy.look.result_range)
        elif by == "Continuity":
            self.legend.show_names(list(zip(tessellate.ORDER_NAMES, tessellate.ORDER_COLOURS)))
        else:
            self.legend.show_names(list(zip(tessellate.PART_NAMES, tessellate.PART_COLOURS)))

    # ---- picking ----

    def _pick(self):
        from pivy import coin

        current = view.active_view()
        if current is not None:
            kind = coin.SoMouseButtonEvent.getClassTypeId()
            self.picker = (current, kind, current.addEventCallbackPivy(kind, self._clicked))

    def _clicked(self, node):
        from pivy import coin

        event = node.getEvent()
        if event.getButton() != coin.SoMouseButtonEvent.BUTTON1 or not self.alive():
            return
        if event.getState() != coin.SoMouseButtonEvent.DOWN or self.proxy.scenes is None:
            return
        picked = node.getPickedPoint()
        if picked is not None:
            element = self.proxy.scenes.element_of(picked)
            if element is not None:
                self.show_facts(element)

    def show_facts(self, element):
        facts = self.proxy.look.facts(element)
        self.facts.setRowCount(len(facts))
        for k, (what, value) in enumerate(facts):
            if isinstance(value, tuple):
                value = "(%s)" % ", ".join("%.5g" % x for x in value)
            elif isinstance(value, float):
                value = "%.6g" % value
            self.facts.setItem(k, 0, QtGui.QTableWidgetItem(tr(what)))
            self.facts.setItem(k, 1, QtGui.QTableWidgetItem(str(value)))
        self.facts.resizeColumnToContents(0)
        self.proxy.mark(element)

    def tidy(self):
        if self.picker is not None:
            current, kind, function = self.picker
            try:
                current.removeEventCallbackPivy(kind, function)
            except (RuntimeError, ReferenceError):  # the view is gone, and the callback with it
                pass
            self.picker = None
        if FreeCAD.GuiUp and self.alive():
            self.proxy.mark(None)
