# SPDX-License-Identifier: LGPL-2.1-or-later
"""File, Open/Import/Export of FreeCAD for our formats, and the example parts."""

import os
import re

import FreeCAD
import Part

from . import api, binding, convert, document, places, results, rows
from .surface import Surface


class FileError(Exception):
    """One sentence for the user."""


# ---- FreeCAD's entries -----------------------------------------------------------------------

_builtin_open = open


def open(path):  # the name that FreeCAD calls
    """File, Open: a new document."""
    doc = FreeCAD.newDocument(_base(path))
    try:
        insert(path, doc.Name)
    except BaseException:
        FreeCAD.closeDocument(doc.Name)
        raise
    return doc


def insert(path, name):
    """File, Import: into the document of that name."""
    doc = FreeCAD.getDocument(name)
    readers = {
        ".tsb": _read_tsb,
        ".tsolid": _read_tsolid,
        ".tsm": _read_surface,
        ".iga": _read_surface,
    }
    suffix = os.path.splitext(path)[1].lower()
    if suffix not in readers:
        raise FileError("%s: only %s files are read here" % (path, ", ".join(sorted(readers))))
    doc.openTransaction("Import")
    try:
        obj = readers[suffix](path, doc)
    except BaseException as error:
        doc.abortTransaction()
        if isinstance(error, (binding.TsolidError, binding.LibraryError)):
            raise FileError("%s: %s" % (path, error)) from None
        raise
    doc.commitTransaction()
    doc.recompute()
    _look_at(obj)
    return obj


def export(objects, path):
    """File, Export: one object."""
    objects = [getattr(o, "Object", o) for o in objects]
    if len(objects) != 1:
        raise FileError("select one object to export: %d are selected" % len(objects))
    write(objects[0], path)


def _base(path):
    return os.path.splitext(os.path.basename(path))[0]


def _read_tsb(path, doc):
    """Exact B-spline faces, as a solid where they close, else as a shell or as they are."""
    given = api.Part.read_tsb(path)
    patches = given.patches
    if given.file is not None:
        boundary = given.boundary(binding.Context(), api.Options())
        patches = convert.patches_of_boundary(boundary)
    return _add_part(patches, path, doc)


def _read_surface(path, doc):
    """A T-spline surface or Bezier elements: exact B-spline faces. What the reader has to say about
    the surface, as how it is round stars, stays with the object."""
    context = binding.Context()
    obj = _add_part(Surface.read(context, path).patches(context), path, doc)
    notes = [str(f) for f in context.findings()]
    if notes:
        obj.addProperty("App::PropertyStringList", "Notes", "Surface", "What was found on reading")
        obj.Notes = notes
        obj.setEditorMode("Notes", 1)
        FreeCAD.Console.PrintMessage("".join("%s: %s\n" % (obj.Label, n) for n in notes))
    return obj


def _add_part(patches, path, doc):
    obj = doc.addObject("Part::Feature", _base(path))
    obj.Label = _base(path)
    obj.Shape = shape_of_patches(patches)
    return obj


def shape_of_patches(patches):
    """A solid of the patches, or an open shell, or loose faces."""
    faces = [convert.surface_of_patch(p).toShape() for p in patches]
    try:
        return convert.solid_of_faces(faces)
    except binding.Refused:
        compound = Part.makeCompound(faces)
        compound.sewShape(1e-6)
        return compound.Shells[0] if len(compound.Shells) == 1 else Part.makeCompound(faces)


def _read_tsolid(path, doc):
    """A SolidTSpline without a source; it is measured when its report is asked for."""
    context = binding.Context()
    solid = binding.Solid.read(context, path)
    shape = convert.solid_of_patches(convert.patches_of_boundary(solid.boundary))
    obj = document.create(None, doc)
    obj.Label = _base(path)
    with _builtin_open(path, "rb") as stream:
        document.set_file(obj, stream.read())
    obj.Shape = shape
    obj.Status = document.CURRENT
    obj.purgeTouched()
    return obj


def _look_at(obj):
    if getattr(FreeCAD, "GuiUp", False):
        import FreeCADGui as Gui

        view = Gui.ActiveDocument.ActiveView if Gui.ActiveDocument is not None else None
        if hasattr(view, "viewIsometric"):
            view.viewIsometric()
            Gui.SendMsgToActiveView("ViewFit")


# ---- writing ---------------------------------------------------------------------------------


def write(obj, path):
    """One object into one file, by the ending."""
    suffix = os.path.splitext(path)[1].lower()
    writers = {
        ".tsolid": _write_tsolid,
        ".vtu": _write_vtu,
        ".tsb": _write_tsb,
        ".regions": _write_regions,
        ".html": _write_html,
        ".json": _write_json,
        ".csv": _write_csv,
    }
    if suffix not in writers:
        endings = ", ".join(sorted(writers))
        raise FileError("%s: the ending says the format, one of %s" % (path, endings))
    try:
        writers[suffix](obj, path)
    except OSError as error:
        raise FileError("%s cannot be written: %s" % (path, error.strerror)) from None


def _built(obj):
    if not document.is_solid_tspline(obj):
        raise FileError("%s is not a solid T-spline: build one first" % obj.Label)
    data = document.tsolid_of(obj)
    if data is None:
        raise FileError("%s has not been built yet" % obj.Label)
    return data


def _write_bytes(path, data):
    def write_beside(beside):
        with _builtin_open(beside, "wb") as stream:
            stream.write(data)

    api.write_beside(path, write_beside)


def _write_tsolid(obj, path):
    _write_bytes(path, _built(obj))


def _write_vtu(obj, path):
    _built(obj)
    results.write_vtu(obj, path)


def _write_regions(obj, path):
    """Where the part's faces lie on the solid's sides, for `tsolid export --regions`."""
    from . import fem

    _built(obj)
    lines = []
    for face, number, box in fem.regions_of(_report(obj)):
        side = "%s_%s" % ("xyz"[number // 2], "high" if number % 2 else "low")
        name = re.sub("[^A-Za-z0-9_-]", "_", face)
        lines.append(" ".join([name, side] + ["%.17g" % x for x in box]) + "\n")
    _write_bytes(path, "".join(lines).encode())


def _write_tsb(obj, path):
    shape = getattr(obj, "Shape", None)
    try:
        patches = api.Part.of(shape).patches
        binding.write_tsb(binding.Context(), patches, path)
    except binding.TsolidError as error:
        raise FileError("%s: %s" % (obj.Label, error)) from None


def _write_html(obj, path):
    from . import report_html

    _built(obj)
    report = _report(obj)
    report_html.write_html(path, report, document.solid_of(obj), obj.Label)


def _report(obj):
    found = document.report_of(obj)
    return found if found is not None else document.measure(obj)


def _write_json(obj, path):
    _built(obj)
    _write_bytes(path, api.report_json(_report(obj)).encode())


def _write_csv(obj, path):
    _built(obj)
    _write_bytes(path, rows.csv_text(rows.of_report(_report(obj))).encode())


def write_check(result, path):
    """The rows of a check of a part or an assembly, by the ending: .html, .json or .csv."""
    suffix = os.path.splitext(path)[1].lower()
    groups, headline = rows.of_result(result)
    if suffix == ".csv":
        data = rows.csv_text(groups)
    elif suffix == ".json":
        data = api.report_json(result.as_dict())
    elif suffix == ".html":
        from . import report_html

        data = report_html.check_page(result, groups, headline)
    else:
        raise FileError("%s: the ending says the format, one of .csv, .html, .json" % path)
    try:
        _write_bytes(path, data.encode("utf-8", "backslashreplace"))
    except OSError as error:
        raise FileError("%s cannot be written: %s" % (path, error.strerror)) from None


# ---- example parts ---------------------------------------------------------------------------


def _examples_folder():
    """Beside the package when it is installed, at the top of a checkout else."""
    if os.path.isdir(places.EXAMPLES):
        return places.EXAMPLES
    top = os.path.dirname(os.path.abspath(__file__))
    for _ in range(3):
        top = os.path.dirname(top)
    return os.path.join(top, "resources", "examples")


def example_names():
    folder = _examples_folder()
    found = os.listdir(folder) if os.path.isdir(folder) else []
    return sorted(_base(n) for n in found if n.endswith(".tsb"))


def open_example(name):
    if name not in example_names():
        raise FileError("there is no example part %s" % name)
    doc = open(os.path.join(_examples_folder(), name + ".tsb"))
    return doc.Objects[0]
