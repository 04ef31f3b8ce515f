# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the buttons do, for scripts: each button leaves the line that calls one of these.

    import freecad.tsolid as ts
    ts.check(App.ActiveDocument.Box)                    # can it become hex blocks, and where not?
    result = ts.build(App.ActiveDocument.Box)           # adds an object SolidTSpline
    ts.rebuild(App.ActiveDocument.SolidTSpline)         # after the part has changed
    ts.look_inside(App.ActiveDocument.SolidTSpline, mode="Elements", peel=1)
    ts.report(App.ActiveDocument.SolidTSpline)          # the report as a dict
    ts.export(App.ActiveDocument.SolidTSpline, "part.html")
    ts.check_assembly(App.ActiveDocument)               # do the parts touch without gaps?
    ts.open_example("wavy_cube")

In a window the long work runs in a thread before the line is executed, and the line only takes
what is ready (see Job); in a macro or without a window the same line does the work itself.
"""

import contextlib

import FreeCAD

from . import api, binding, convert, document, fingerprint
from .header import Severity

# ---- long work ---------------------------------------------------------------------------------


class Job:
    """One check or build of a document object, to be run in any thread.

    Made in the main thread, where it takes a copy of the shape: the user may go on editing.
    """

    def __init__(self, kind, given, options=None):
        self.kind = kind
        self.given = given
        self.options = options if options is not None else api.Options()
        source = source_of(given)
        if source is None:
            raise ValueError("%s has no part to work on: its source is gone" % _label(given))
        self.name = _label(source)
        self.original = convert.shape_of(source)
        self.shape = self.original.copy()
        self.notes = api.notes_of(source)
        self.meshes = _meshes_of(given)
        self.result = None

    def run(self, progress=None):
        """The work itself; touches no document."""
        self._tell(progress, "shape", 0.0)
        state = fingerprint.of_shape(self.shape)
        work = api.check if self.kind == "check" else api.build
        self.result = self._work_on_shape(work, progress)
        self.result.source_state = state
        if self.kind == "check":
            self.result.shape = self.shape
        if self.kind != "check" and self.result.solid is not None:
            self._tell(progress, "view", 0.0)
            self.result.prepared = document.prepare(self.result)
            self.result.prepared.original = self.original
            self.result.prepared.look = _look(self.result.solid)
            self.result.prepared.meshes = [self._mesh(*m) for m in self.meshes]
        return self

    def _mesh(self, name, options):
        """(name, fem.Meshed) of hex blocks that are replaced with the solid; (name, None) when the
        new solid refuses, which a finding tells."""
        from . import fem

        built = self.result
        try:
            regions = fem.regions_of(built.report)
            return name, fem.meshed(binding.Context(), built.solid, regions, built.tsolid, options)
        except binding.TsolidError as error:
            text = "the mesh %s stays that of the solid before: %s" % (name, error)
            built.findings.append(binding.finding(Severity.WARNING, "mesh", name, text))
            return name, None

    def _work_on_shape(self, work, progress):
        try:
            part = api.Part.of(
                self.shape, lambda f: self._tell(progress, "shape", f), self.options.corners
            )
        except binding.Refused as error:
            kind = api.CheckResult if work is api.check else api.BuildResult
            return kind(self.name, error.findings, {})
        part.name = self.name
        part.notes = self.notes + part.notes
        return work(part, self.options, progress)

    @staticmethod
    def _tell(progress, stage, fraction):
        if progress is not None and progress(stage, fraction):
            raise binding.Cancelled(binding.Status.ERROR_CANCELLED, [])

    def fits(self, kind, given, options):
        return (
            self.kind == kind
            and self.given is given
            and self.options.as_dict() == options.as_dict()
        )


def _meshes_of(given):
    """[(name, options)] of the hex blocks that were made of a SolidTSpline."""
    if not document.is_solid_tspline(given) or not given.InList:
        return []
    from . import fem

    return [(m.Name, fem.options_of(m)) for m in fem.meshes_of(given)]


def _look(solid):
    """What the 3D view needs, made here so that the window need not wait; None without one."""
    if not getattr(FreeCAD, "GuiUp", False):
        return None
    from . import view

    return view.look_of(solid)


_ready = []


@contextlib.contextmanager
def ready(job):
    """While this lasts, the call that the job stands for takes its result instead of working."""
    _ready.append(job)
    try:
        yield
    finally:
        _ready.remove(job)


def ready_result(kind, given, options):
    """What a job has made ready; None when there is none that fits."""
    return next((job.result for job in _ready if job.fits(kind, given, options)), None)


def _result(kind, given, options, progress):
    found = ready_result(kind, given, options)
    return Job(kind, given, options).run(progress).result if found is None else found


def _label(obj):
    return getattr(obj, "Label", "") or "part"


def is_document_object(given):
    return hasattr(given, "Document") and hasattr(given, "Shape")


def source_of(given):
    """The part behind a document object: the source of a SolidTSpline, else itself."""
    if document.is_solid_tspline(given):
        return given.Source
    return given


# ---- the buttons ---------------------------------------------------------------------------------


def check(given, options=None, progress=None, **keywords):
    """Can the part become a solid T-spline, and where not? Gives an api.CheckResult.

    given: a document object, a shape, or an api.Part.
    """
    options = api.options_from(options, keywords)
    if is_document_object(given):
        return _result("check", given, options, progress)
    return api.check(given, options, progress)


def check_assembly(given, gap=None, progress=None):
    """Which faces of which parts touch, how far others are apart, clashes. Gives an
    assemblies.AssemblyResult.

    given: a document (all its solids), an object, a list of objects, or a shape. gap: how far apart
    faces may be to be told; None: a hundredth of the smaller part.
    """
    from . import assemblies, members

    if hasattr(given, "Solids"):
        return assemblies.check(given, gap, progress=progress)
    if hasattr(given, "addObject") and hasattr(given, "Objects"):
        given = members.top_objects(given)
    return assemblies.check_objects(given if isinstance(given, (list, tuple)) else [given], gap,
                                    progress)


def build_assembly(given, options=None, gap=None, progress=None, **keywords):
    """Checks an assembly and builds all its parts, so that contacts stay exact; changes no
    document. Gives an assemblies.AssemblyResult with `built`."""
    from . import assemblies

    return assemblies.build(given, api.options_from(options, keywords), gap, progress)


def build(given, options=None, progress=None, **keywords):
    """Builds, proves and measures; gives an api.BuildResult.

    Of a document object the result is put into its document as a new SolidTSpline (result.object;
    None when the part is refused); a SolidTSpline is rebuilt. A shape only gives the result.
    """
    if document.is_solid_tspline(given):
        if options is not None or keywords:
            document.set_options(given, api.options_from(options, keywords))
        return rebuild(given, progress)
    options = api.options_from(options, keywords)
    if not is_document_object(given):
        return api.build(given, options, progress)
    result = _result("build", given, options, progress)
    result.object = None
    if result.solid is not None:
        with transaction(given.Document, "Build solid T-spline"):
            obj = document.create(given, given.Document)
            obj.Label = "%s (hex blocks)" % given.Label
            document.set_options(obj, result.options)
            document.store(obj, result)
            given.Visibility = False  # the same faces, which would cover the solid's
        result.object = obj
    return result


def rebuild(obj, progress=None):
    """Builds a SolidTSpline anew from its source; a refusal is kept as the object's state."""
    if obj.Source is None:
        return _lost_source(obj)
    result = _result("rebuild", obj, document.options_of(obj), progress)
    with transaction(obj.Document, "Rebuild solid T-spline"):
        if result.solid is not None:
            document.store(obj, result)
        else:
            document.set_failed(obj, document.reason_of(result))
    if result.solid is not None:
        _replace_meshes(obj, result)
    result.object = obj
    return result


def _replace_meshes(obj, result):
    """Outside the transaction: FreeCAD's undo does not bring a mesh back. After an undo they are
    out of date, as they should be."""
    for name, ready in result.prepared.meshes:
        found = obj.Document.getObject(name)
        if ready is not None and found is not None:
            from . import fem

            fem.put(found, ready)


def _lost_source(obj):
    text = "the part that it was made of is gone"
    finding = binding.finding(binding.Severity.ERROR, "shape", "", text)
    result = api.BuildResult(obj.Label, [finding], {})
    result.object = obj
    with transaction(obj.Document, "Rebuild solid T-spline"):
        document.set_failed(obj, text)
    return result


@contextlib.contextmanager
def transaction(doc, name):
    """One step of undo, taken back when an exception passes."""
    doc.openTransaction(name)
    try:
        yield
    except BaseException:
        doc.abortTransaction()
        raise
    doc.commitTransaction()


def report(obj):
    """The conformity report of a SolidTSpline as a dict; measured now when it was only imported."""
    if not document.is_solid_tspline(obj):
        raise ValueError("%s is not a solid T-spline: build one first" % _label(obj))
    found = document.report_of(obj)
    return found if found is not None else document.measure(obj)


MODES = ("Solid", "Elements", "T-mesh", "Control net", "Parts")
COLOURS = ("Scaled Jacobian", "Continuity", "Element size", "Parts", "Result")


def look_inside(obj, mode=None, colour=None, peel=None, cut=None, along_blocks=None):
    """Sets how a SolidTSpline is shown. Without a window nothing happens.

    mode: one of MODES; colour: one of COLOURS; peel: layers of elements to take off from outside;
    cut: None, or (axis 0..2, share 0..1): what lies beyond that share of the part is hidden;
    along_blocks: whole elements are taken off instead of being cut by a plane.
    """
    if not document.is_solid_tspline(obj):
        raise ValueError("%s is not a solid T-spline: build one first" % _label(obj))
    if mode not in (None,) + MODES or colour not in (None,) + COLOURS:
        raise ValueError("mode is one of %s, colour one of %s" % (MODES, COLOURS))
    view = getattr(obj, "ViewObject", None)
    if view is None:
        return
    if colour is not None:
        view.ColourBy = colour
    if peel is not None:
        view.Peel = int(peel)
    if cut is not None:
        view.CutAxis = "XYZ"[cut[0]]
        view.CutShare = float(cut[1])
    if along_blocks is not None:
        view.CutAlongBlocks = bool(along_blocks)
    if mode is not None:
        view.DisplayMode = mode


def export(obj, path):
    """Writes .html, .json, .csv (the report), .tsolid, .vtu (with the result, if there is one),
    .tsb (the faces) or .regions (where they lie: for tsolid export), by the ending."""
    from . import files

    files.write(obj, path)


def example_names():
    """The example parts that come with this package."""
    from . import files

    return files.example_names()


def open_example(name):
    """A new document with an example part; gives the part."""
    from . import files

    return files.open_example(name)
