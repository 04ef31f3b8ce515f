# SPDX-License-Identifier: LGPL-2.1-or-later
"""How a SolidTSpline looks in the tree and in the 3D view.

This class's path (freecad.tsolid.view.SolidTSplineView) is stored in documents: it never moves.
"""

import contextlib
import weakref

import FreeCAD
import FreeCADGui as Gui

from . import actions, api, binding, document, places, results

SOLID, ELEMENTS, TMESH, CONTROL, PARTS = actions.MODES
_OWN = (ELEMENTS, TMESH, CONTROL, PARTS)

_PROPERTIES = (
    # type, name, description
    ("App::PropertyEnumeration", "ColourBy", "What the colours of the elements say"),
    ("App::PropertyInteger", "Peel", "Layers of elements taken off from outside"),
    ("App::PropertyEnumeration", "CutAxis", "Across which axis the solid is cut open"),
    ("App::PropertyFloat", "CutShare", "Elements beyond this share of the part are hidden"),
    ("App::PropertyBool", "CutAlongBlocks", "Take whole elements off instead of cutting them"),
    ("App::PropertyBool", "ShowBorders", "Draw the borders of the elements"),
)

_ICONS = {
    document.NOT_BUILT: "tsolid_object_empty",
    document.OUTDATED: "tsolid_object_old",
    document.FAILED: "tsolid_object_failed",
}


class SolidTSplineView:
    """Proxy of the view provider; the elements are read from the document when first shown."""

    def __init__(self, vobj):
        self._start()
        vobj.Proxy = self
        self.add_properties(vobj)

    def _start(self):
        self.look = None  # a tessellate.Look of the stored solid
        self.loading = None  # a runner.Loading that makes it
        self.shown_file = None
        self.shown_result = None  # the look that has got the object's result
        self.scenes = None
        self.mode = SOLID

    def add_properties(self, vobj):
        for kind, name, description in _PROPERTIES:
            if name in vobj.PropertiesList:
                if name == "ColourBy":  # documents of older versions know fewer
                    _extend_choices(vobj)
                continue
            vobj.addProperty(kind, name, "Look inside", description)
            if name == "ColourBy":
                vobj.ColourBy = list(actions.COLOURS)
            elif name == "CutAxis":
                vobj.CutAxis = ["X", "Y", "Z"]
            elif name == "CutShare":
                vobj.CutShare = 1.0
            elif name == "ShowBorders":
                vobj.ShowBorders = True

    # ---- what FreeCAD calls ----

    def attach(self, vobj):
        self._start()
        self.vobj = vobj
        self.obj = vobj.Object
        self.document = vobj.Object.Document.Name
        _Closing.watch(self)
        self.add_properties(vobj)
        from pivy import coin

        self.roots = {}
        for mode in _OWN:
            self.roots[mode] = coin.SoSeparator()
            vobj.addDisplayMode(self.roots[mode], mode)

    def getIcon(self):
        obj = getattr(self, "obj", None)
        if obj is None or "Status" not in obj.PropertiesList:
            return places.icon("tsolid_object")
        name = _ICONS.get(str(obj.Status))
        if name is None:
            name = "tsolid_object_proved" if obj.Verdict == "positive" else "tsolid_object"
        return places.icon(name)

    def getDisplayModes(self, vobj):
        return list(actions.MODES)

    def getDefaultDisplayMode(self):
        return SOLID

    def setDisplayMode(self, mode):
        self.mode = mode
        if mode in _OWN:
            self._soon()
            return mode
        return "Flat Lines" if mode == SOLID else mode

    def updateData(self, obj, name):
        if name == "SolidFile":
            self._forget()
            if self.mode in _OWN:
                self._soon()
        elif name == "ResultValues":
            self.shown_result = None
            self.recolour()
            self.refresh()
        elif name in ("Status", "Verdict", "Reason"):
            self.vobj.signalChangeIcon()

    def onChanged(self, vobj, name):
        if getattr(self, "scenes", None) is None:
            return
        if name == "ColourBy":
            self.recolour()
            self.refresh()
        elif name in ("Peel", "CutAxis", "CutShare", "CutAlongBlocks"):
            self.refresh()
        elif name == "ShowBorders":
            self.scenes.show_lines(vobj.ShowBorders)

    def claimChildren(self):
        obj = getattr(self, "obj", None)
        source = getattr(obj, "Source", None)
        return [source] if source is not None else []

    def doubleClicked(self, vobj):
        from . import commands

        return commands.look_inside(vobj.Object)

    def setEdit(self, vobj, mode=0):
        return False  # there is nothing to edit that the panels do not offer

    def unsetEdit(self, vobj, mode=0):
        return False

    def onDelete(self, vobj, names):
        self._start()
        return True

    def dumps(self):
        return None

    def loads(self, state):
        return None

    def __getstate__(self):
        return None

    def __setstate__(self, state):
        return None

    # ---- what is shown ----

    def take(self, look):
        """A Look that a build has made ready, of the solid that the object holds now."""
        self._forget()
        self.look = look
        self.shown_file = None
        if self.mode in _OWN:
            self.show()

    def _forget(self):
        """What was made of another solid, or is about to be."""
        self.look = None
        if self.loading is not None:
            self.loading.drop()
            self.loading = None

    def ensure(self):
        """The look and its nodes, made now when there are none; False before the first build."""
        if self.look is None:
            with wait_cursor():
                if self.loading is not None:
                    self.loading.finish()
                else:
                    self.look = look_of(document.solid_of(self.obj))
                    self.shown_file = None
        if self.look is not None and self.shown_file is not self.look:
            self._make_scenes()
        return self.look is not None

    def _make_scenes(self):
        from . import scenes

        self.scenes = scenes.Scenes(self.look, self.obj, self.roots)
        self.scenes.show_lines(self.vobj.ShowBorders)
        self.shown_file = self.look

    def show(self):
        if not self.ensure():
            return
        self.recolour()
        self.refresh()

    def recolour(self):
        if self.look is None or self.scenes is None:
            return
        by = "Parts" if self.mode == PARTS else str(self.vobj.ColourBy)
        anew = by == "Result" and self.shown_result is not self.look
        if anew:
            results.colour(self.look, self.obj)
            self.shown_result = self.look
        self.scenes.recolour(self.look, by, anew)

    def refresh(self):
        """One step of a slider."""
        if self.look is None or self.scenes is None:
            return
        vobj = self.vobj
        axis, share = "XYZ".index(str(vobj.CutAxis)), float(vobj.CutShare)
        if self.mode in (ELEMENTS, PARTS) and share < 1.0 and not vobj.CutAlongBlocks:
            self.scenes.refresh_cut(self.look, self.look.kept(int(vobj.Peel)), axis, share)
        else:
            kept = self.look.kept(int(vobj.Peel), axis, share)
            self.scenes.refresh(self.look, kept, self.mode)

    def mark(self, element):
        """Outlines one element; None: none."""
        if self.scenes is not None:
            outline = None if element is None else self.look.outline(element)
            self.scenes.mark.show(outline)

    def _soon(self):
        """After FreeCAD has finished what it does: reading a document is not held up."""
        from PySide import QtCore

        QtCore.QTimer.singleShot(0, self._now)

    def _now(self):
        try:
            if self.mode not in _OWN or not self.obj.SolidFile:
                return
            if self.look is not None:
                self.show()
            elif self.loading is None:
                self._load()
        except ReferenceError:  # the object was deleted meanwhile
            pass
        except (OSError,) + _FAILURES as error:
            _warn(error)

    def _load(self):
        """Makes the look in a thread: opening a document with a large solid does not wait."""
        from . import runner

        data = document.tsolid_of(self.obj)

        def work(progress):
            return look_of(api.read_tsolid(binding.Context(progress), data), progress)

        self.loading = runner.Loading(work, self.obj, self._loaded, self._not_loaded).start()

    def _loaded(self, look):
        self.loading = None
        try:
            if self.look is None:
                self.take(look)
        except ReferenceError:  # the object was deleted meanwhile
            pass
        except _FAILURES as error:
            _warn(error)

    def _not_loaded(self, error):
        self.loading = None
        _warn(error)


def _extend_choices(vobj):
    if list(vobj.getEnumerationsOfProperty("ColourBy") or ()) != list(actions.COLOURS):
        chosen = str(vobj.ColourBy)
        vobj.ColourBy = list(actions.COLOURS)
        vobj.ColourBy = chosen


class _Closing:
    """FreeCAD never lets go of the proxies of objects that were read from a file (seen in 0.20):
    when their document is closed, they at least let go of what they show."""

    _observer = None
    _views = weakref.WeakSet()

    @classmethod
    def watch(cls, proxy):
        cls._views.add(proxy)
        if cls._observer is None:
            cls._observer = cls()
            FreeCAD.addDocumentObserver(cls._observer)

    def slotDeletedDocument(self, doc):
        for proxy in list(self._views):
            if proxy.document == doc.Name:
                proxy._forget()
                proxy._start()
                proxy.roots = {}
                self._views.discard(proxy)


_FAILURES = (binding.TsolidError, binding.LibraryError, ImportError)


def _warn(error):
    FreeCAD.Console.PrintWarning("tsolid: the elements cannot be shown: %s\n" % error)


@contextlib.contextmanager
def wait_cursor():
    from PySide import QtCore, QtGui

    QtGui.QApplication.setOverrideCursor(QtCore.Qt.WaitCursor)
    try:
        yield
    finally:
        QtGui.QApplication.restoreOverrideCursor()


def deviation():
    group = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Mod/tsolid")
    return group.GetFloat("Deviation", 1e-3)


def look_of(solid, progress=None):
    """The tessellate.Look of a solid; None for None. In any thread."""
    if solid is None:
        return None
    from . import picture, tessellate

    elements = picture.Elements.of(binding.Context(progress), solid)
    look = tessellate.Look(elements, deviation())
    look.solid = solid
    return look


def add_to(obj):
    """Gives a document object its view provider, where there is a window."""
    if not FreeCAD.GuiUp or obj.ViewObject is None:
        return
    if not isinstance(obj.ViewObject.Proxy, SolidTSplineView):
        SolidTSplineView(obj.ViewObject)
        obj.ViewObject.DisplayMode = SOLID
        if "SelectionStyle" in obj.ViewObject.PropertiesList:
            obj.ViewObject.SelectionStyle = "BoundBox"  # the colours stay as they are


def proxy_of(obj):
    """The view proxy of an object; None without a window."""
    proxy = getattr(getattr(obj, "ViewObject", None), "Proxy", None)
    return proxy if isinstance(proxy, SolidTSplineView) else None


def active_view():
    """The active 3D view; None when there is none."""
    view = Gui.ActiveDocument.ActiveView if Gui.ActiveDocument else None
    return view if hasattr(view, "getSceneGraph") else None
