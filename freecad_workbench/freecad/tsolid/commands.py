# SPDX-License-Identifier: LGPL-2.1-or-later
"""The buttons: each looks at the selection, says in one sentence what is wrong with it, or opens
its panel.
"""

import FreeCAD
import FreeCADGui as Gui
from PySide import QtGui
from PySide.QtCore import QT_TRANSLATE_NOOP

from . import api, binding, convert, document, fem, files, members, runner
from .runner import say, tr

# ---- what is selected ----------------------------------------------------------------------------


class Unfit(Exception):
    """The selection is not what the button needs; the text is a sentence for the user."""


def selected():
    """The objects selected in the active document."""
    doc = FreeCAD.ActiveDocument
    return Gui.Selection.getSelection(doc.Name) if doc is not None else []


def _candidates(test):
    return [o for o in FreeCAD.ActiveDocument.Objects if test(o)] if FreeCAD.ActiveDocument else []


def _the_one(test, nothing, several):
    """The selected object; where nothing is selected, the only one in the document that fits."""
    found = selected()
    if not found:
        fitting = _candidates(test)
        if len(fitting) == 1:
            return fitting[0]
        raise Unfit(nothing)
    if len(found) > 1:
        raise Unfit(several % len(found))
    return found[0]


def _is_solid_part(obj):
    if document.is_solid_tspline(obj):
        return False
    shape = getattr(obj, "Shape", None)
    return bool(getattr(shape, "Solids", ())) and not _used_by_a_shape(obj)


def _used_by_a_shape(obj):
    return any(getattr(getattr(o, "Shape", None), "Solids", ()) for o in obj.InList)


def the_part():
    """The part to check or to build; raises Unfit."""
    obj = _the_one(
        _is_solid_part,
        tr("Select the part first: one solid, in the tree or in the view."),
        tr("Select one part only: %d objects are selected."),
    )
    _refuse_other_kinds(obj)
    return obj


def _refuse_other_kinds(obj):
    label = api.visible(obj.Label)
    if obj.isDerivedFrom("Sketcher::SketchObject"):
        raise Unfit(tr("%s is a sketch: select the solid that is made of it.") % label)
    if obj.isDerivedFrom("Mesh::Feature") or obj.isDerivedFrom("Fem::FemMeshObject"):
        raise Unfit(tr("%s is a mesh: a solid with spline faces is needed.") % label)
    if not hasattr(obj, "Shape") and not obj.isDerivedFrom("App::Part"):
        raise Unfit(tr("%s has no shape: select a solid.") % label)
    if convert.shape_of(obj).isNull():
        raise Unfit(tr("%s is empty: recompute it or select a solid.") % label)


def the_tspline():
    """The SolidTSpline to look at; raises Unfit. Of a part, the one that was built from it."""
    obj = _the_one(
        document.is_solid_tspline,
        tr("Select a solid T-spline first; Build makes one of a part."),
        tr("Select one object only: %d are selected."),
    )
    if document.is_solid_tspline(obj):
        return obj
    built = [o for o in obj.InList if document.is_solid_tspline(o)]
    if len(built) == 1:
        return built[0]
    raise Unfit(tr("%s is not a solid T-spline: Build makes one of it.") % api.visible(obj.Label))


def the_solid_or_mesh():
    """What is to be meshed: a SolidTSpline, or hex blocks to be made anew; raises Unfit."""
    found = selected()
    if len(found) == 1 and fem.is_hex_blocks(found[0]):
        if found[0].Solid is None:
            raise Unfit(tr("The solid that %s was made of is gone.") % api.visible(found[0].Label))
        return found[0]
    return _built(the_tspline())


def the_assembly():
    """(objects, whole): two objects or more that are selected, one container, or, with nothing
    selected, all of the document; raises Unfit."""
    doc, found = FreeCAD.ActiveDocument, selected()
    objects = found or (members.top_objects(doc) if doc is not None else [])
    parts = members.of_objects(objects)
    if len(parts) < 2:
        raise Unfit(
            tr("An assembly has two solids or more: %d found. Select them, or nothing to take all.")
            % len(parts))
    return objects, not found


def _built(obj):
    if not obj.SolidFile:
        raise Unfit(tr("%s has not been built yet: rebuild it.") % api.visible(obj.Label))
    return obj


# ---- panels --------------------------------------------------------------------------------------


def _open_panel(make):
    """Opens a task panel; one of ours that has nothing to do is closed for it."""
    from . import panels

    if Gui.Control.activeDialog():
        ours = panels.Panel.current
        if ours is None or not ours.is_open() or not ours.reject():
            raise Unfit(tr("Finish what is open in the task panel first."))
    panel = make()
    Gui.Control.showDialog(panel)
    return panel


def check(obj):
    """One solid as a part, several together as an assembly."""
    from . import assembly_panel, panels

    if len(convert.shape_of(obj).Solids) > 1:
        return _open_panel(lambda: assembly_panel.AssemblyPanel([obj], False))
    return _open_panel(lambda: panels.CheckPanel(obj))


def build(obj):
    from . import panels

    return _open_panel(lambda: panels.BuildPanel(obj))


def report(obj):
    from . import panels

    return _open_panel(lambda: panels.ReportPanel(_built(obj)))


def mesh(obj):
    from . import mesh_panel

    return _open_panel(lambda: mesh_panel.MeshPanel(obj))


def check_assembly():
    from . import assembly_panel

    objects, whole = the_assembly()
    return _open_panel(lambda: assembly_panel.AssemblyPanel(objects, whole))


def look_inside(obj):
    from . import inside

    try:
        _open_panel(lambda: inside.InsidePanel(_built(obj)))
    except Unfit as problem:
        say(str(problem))
    return True


# ---- commands ------------------------------------------------------------------------------------


class Command:
    """A button. run() raises Unfit when it cannot."""

    def __init__(self, name, icon, text, tip, keys, run, needs_document=True):
        self.name, self.icon = name, icon
        self.text, self.tip, self.keys = text, tip, keys
        self.run, self.needs_document = run, needs_document

    def GetResources(self):
        out = {"Pixmap": self.icon, "MenuText": self.text, "ToolTip": self.tip}
        if self.keys:
            out["Accel"] = self.keys
        return out

    def IsActive(self):
        return FreeCAD.ActiveDocument is not None or not self.needs_document

    def Activated(self, index=0):
        try:
            binding.load()
            self.run()
        except Unfit as problem:
            say(str(problem))
        except binding.LibraryError as problem:
            _library_missing(problem)
        except (files.FileError, binding.TsolidError, ValueError, OSError) as problem:
            say(runner.sentence_of(problem))


def _library_missing(problem):
    """The one message box of this workbench: nothing can be done without the library."""
    box = QtGui.QMessageBox(Gui.getMainWindow())
    box.setObjectName("tsolid_library_missing")
    box.setIcon(QtGui.QMessageBox.Warning)
    box.setWindowTitle("tsolid")
    box.setText(str(problem))
    box.setInformativeText(
        tr(
            "The add-on works with a library written in C, which must be of the same version. "
            "In the folder of tsolid's sources, run\n\n"
            "    cmake -S . -B build && cmake --build build\n"
            '    cmake --install build --component addon --prefix "%s"\n\n'
            "and start FreeCAD again."
        )
        % (FreeCAD.getUserAppDataDir() + "Mod")
    )
    box.exec_()


def _export():
    from . import panels

    obj = _built(the_tspline())
    panel = _open_panel(lambda: panels.ReportPanel(obj))
    panel.export()


def _rebuild():
    obj = the_tspline()
    if obj.Source is None:
        raise Unfit(tr("%s has no part to be rebuilt from.") % api.visible(obj.Label))
    panel = build(obj)
    panel.build()


def _look():
    look_inside(the_tspline())


def _manual():
    from . import manual

    manual.show()


def _commands():
    return (
        Command(
            "Tsolid_Check", "tsolid_check",
            QT_TRANSLATE_NOOP("Tsolid_Check", "Check"),
            QT_TRANSLATE_NOOP("Tsolid_Check", "Can the part become hex blocks, and where not?"),
            "T, C", lambda: check(the_part()),
        ),
        Command(
            "Tsolid_Build", "tsolid_build",
            QT_TRANSLATE_NOOP("Tsolid_Build", "Build"),
            QT_TRANSLATE_NOOP(
                "Tsolid_Build", "Fill the part with hex blocks whose borders are its own faces"
            ),
            "T, B", lambda: build(the_part()),
        ),
        Command(
            "Tsolid_Rebuild", "tsolid_rebuild",
            QT_TRANSLATE_NOOP("Tsolid_Rebuild", "Rebuild"),
            QT_TRANSLATE_NOOP("Tsolid_Rebuild", "Build again after the part has changed"),
            "T, R", _rebuild,
        ),
        Command(
            "Tsolid_LookInside", "tsolid_inside",
            QT_TRANSLATE_NOOP("Tsolid_LookInside", "Look inside"),
            QT_TRANSLATE_NOOP("Tsolid_LookInside", "Cut open, peel and colour the hex blocks"),
            "T, I", _look,
        ),
        Command(
            "Tsolid_Report", "tsolid_report",
            QT_TRANSLATE_NOOP("Tsolid_Report", "Report"),
            QT_TRANSLATE_NOOP("Tsolid_Report", "What was proved and measured, face by face"),
            "T, P", lambda: report(the_tspline()),
        ),
        Command(
            "Tsolid_HexBlocks", "tsolid_mesh",
            QT_TRANSLATE_NOOP("Tsolid_HexBlocks", "Mesh with hex blocks"),
            QT_TRANSLATE_NOOP(
                "Tsolid_HexBlocks", "Hexahedra for FEM: conforming, with nodes on the part's faces"
            ),
            "T, H", lambda: mesh(the_solid_or_mesh()),
        ),
        Command(
            "Tsolid_Assembly", "tsolid_assembly",
            QT_TRANSLATE_NOOP("Tsolid_Assembly", "Check assembly"),
            QT_TRANSLATE_NOOP(
                "Tsolid_Assembly", "Watertight contacts, gaps and clashes between parts"
            ),
            "T, A", check_assembly,
        ),
        Command(
            "Tsolid_Export", "tsolid_export",
            QT_TRANSLATE_NOOP("Tsolid_Export", "Export..."),
            QT_TRANSLATE_NOOP("Tsolid_Export", "Write the report or the solid to a file"),
            "", _export,
        ),
        Command(
            "Tsolid_Manual", "tsolid_manual",
            QT_TRANSLATE_NOOP("Tsolid_Manual", "Solid T-spline manual"),
            QT_TRANSLATE_NOOP("Tsolid_Manual", "How to use this workbench, with pictures"),
            "", _manual, False,
        ),
    )


def _example_command(name):
    title = name.replace("_", " ").capitalize()

    def run():
        runner.execute("import freecad.tsolid as ts; ts.open_example(%r)" % name)

    tip = QT_TRANSLATE_NOOP("Tsolid_Example", "Open this example part in a new document")
    return Command("Tsolid_Example_" + name, "tsolid_example", title, tip, "", run, False)


def example_names():
    """Names of the commands that open example parts."""
    return ["Tsolid_Example_" + name for name in files.example_names()]


def register():
    for command in _commands() + tuple(_example_command(n) for n in files.example_names()):
        Gui.addCommand(command.name, command)
