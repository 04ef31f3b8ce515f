# SPDX-License-Identifier: LGPL-2.1-or-later
"""The document object SolidTSpline: the part's solid, the solid T-spline, and its report.

The Shape is the closed solid made of the input's very faces. The solid T-spline itself is the file
property SolidFile, byte for byte what was built; a recompute never builds, only build() does.
This class's path (freecad.tsolid.document.SolidTSpline) is stored in documents: it never moves.
"""

import json
import os
import tempfile
import time

import FreeCAD
import Part

from . import api, binding, convert, fingerprint

VERSION = 4  # of the object's properties; onDocumentRestored migrates older ones

_PROPERTIES = (
    # type, name, group, description, read-only
    ("App::PropertyLink", "Source", "Input", "The part whose faces bound the solid", False),
    ("App::PropertyInteger", "RefineKnots", "Options", "Halve every knot span so often", False),
    ("App::PropertyInteger", "RaiseDegree", "Options", "Raise the sides' degree by so much", False),
    ("App::PropertyInteger", "MinCells", "Options", "Cells per axis inside, at least", False),
    ("App::PropertyEnumeration", "Octree", "Options", "Levels per axis, or as in the paper", False),
    ("App::PropertyBool", "AnalysisSuitable", "Options", "Functions that sum to one", False),
    ("App::PropertyEnumeration", "Effort", "Options", "How hard to smooth the elements", False),
    ("App::PropertyFloat", "Tolerance", "Options", "Of edges without their own; 0: 1e-7", False),
    ("App::PropertyStringList", "Corners", "Options",
     "Vertices that have to be corners of the cube: Vertex1, ...; empty: chosen", False),
    ("App::PropertyString", "Verdict", "Result", "Is det J > 0 proved everywhere?", True),
    ("App::PropertyEnumeration", "Status", "Result", "Does the solid belong to its source?", True),
    ("App::PropertyString", "Reason", "Result", "Why the solid is out of date or failed", True),
    ("App::PropertyString", "Report", "Result", "The conformity report (JSON)", True),
    ("App::PropertyFileIncluded", "SolidFile", "Result", "The solid T-spline (.tsolid)", True),
    ("App::PropertyFloatList", "SourceState", "Result", "What the source was like", True),
    ("App::PropertyString", "BuiltOptions", "Result", "Options of the build (JSON)", True),
    ("App::PropertyInteger", "Version", "Result", "Version of this object's properties", True),
)
_HIDDEN = ("SourceState", "BuiltOptions", "Report")

NOT_BUILT, CURRENT, OUTDATED, FAILED = STATUSES = ("not built", "built", "out of date", "failed")


class SolidTSpline:
    """Proxy of the document object; holds no data of its own."""

    Type = "tsolid::SolidTSpline"

    def __init__(self, obj):
        obj.Proxy = self
        self.add_properties(obj)
        obj.Version = VERSION

    def add_properties(self, obj):
        """Adds what is missing, so that objects of older versions get it on restore."""
        for kind, name, group, description, read_only in _PROPERTIES:
            if name in obj.PropertiesList:
                continue
            obj.addProperty(kind, name, group, description)
            if name == "Effort":
                obj.Effort = list(api.EFFORTS)
            elif name == "Octree":
                obj.Octree = list(api.OCTREES)
            elif name == "AnalysisSuitable":
                obj.AnalysisSuitable = True
            elif name == "Status":
                obj.Status = list(STATUSES)
        for kind, name, group, description, read_only in _PROPERTIES:
            if read_only:
                obj.setEditorMode(name, 2 if name in _HIDDEN else 1)

    def onDocumentRestored(self, obj):
        self.add_properties(obj)
        if obj.Version < VERSION:
            self.migrate(obj)
        _add_view(obj)

    def migrate(self, obj):
        """What older versions did not store. Their source's state is not known, so the first
        recompute after a change of it calls the solid out of date."""
        if obj.Version < 2 and obj.SolidFile:
            obj.Status = CURRENT
            report = report_of(obj) or {}
            obj.BuiltOptions = json.dumps(report.get("options", {}))
        if obj.Version < 4 and obj.BuiltOptions:  # built before there was a choice
            built = dict(api.Options().as_dict(), **json.loads(obj.BuiltOptions))
            obj.BuiltOptions = json.dumps(built)
        obj.Version = VERSION

    def execute(self, obj):
        """Only looks whether the solid still belongs to its source and options: long work in a
        recompute would punish every edit."""
        refresh_status(obj)

    def onChanged(self, obj, name):
        pass

    # FreeCAD 0.20 calls the one pair, later versions the other
    def dumps(self):
        return None

    def loads(self, state):
        return None

    def __getstate__(self):
        return None

    def __setstate__(self, state):
        return None


def create(source=None, document=None, name="SolidTSpline"):
    """An empty SolidTSpline object; rebuild() fills it."""
    document = document or getattr(source, "Document", None) or FreeCAD.ActiveDocument
    obj = document.addObject("Part::FeaturePython", name)
    SolidTSpline(obj)
    obj.Source = source
    _add_view(obj)
    return obj


def _add_view(obj):
    """Where there is a window; objects made without one get theirs when they are restored."""
    if getattr(FreeCAD, "GuiUp", False):
        from . import view

        view.add_to(obj)


def options_of(obj, threads=0):
    return api.Options(
        refine_knots=obj.RefineKnots,
        raise_degree=obj.RaiseDegree,
        min_cells=obj.MinCells,
        octree=str(obj.Octree),
        analysis_suitable=obj.AnalysisSuitable,
        effort=str(obj.Effort),
        threads=threads,
        tolerance=obj.Tolerance,
        corners=list(obj.Corners),
    )


def set_options(obj, options):
    obj.RefineKnots = options.refine_knots
    obj.RaiseDegree = options.raise_degree
    obj.MinCells = options.min_cells
    obj.Octree = options.octree
    obj.AnalysisSuitable = options.analysis_suitable
    obj.Effort = options.effort
    obj.Tolerance = options.tolerance
    obj.Corners = list(options.corners)


def rebuild(obj, progress=None, threads=0):
    """Builds from the object's Source and stores the result when there is one."""
    result = api.build(obj.Source, options_of(obj, threads), progress)
    if result.solid is not None:
        store(obj, result)
    return result


class Prepared:
    """What store() puts into an object, made ready in any thread."""

    def __init__(self, result):
        self.shape = result.shape.copy()
        if not self.shape.isClosed() or not self.shape.isValid():
            raise ValueError("the faces do not make a closed valid solid")
        self.shape = Part.Shape(self.shape)
        self.report = json.dumps(result.report, allow_nan=False)
        self.verdict = result.verdict
        self.options = json.dumps(result.options.as_dict())
        self.tsolid = result.tsolid
        self.state = getattr(result, "source_state", None)
        self.original = None  # the source's shape as it was when the build began
        self.look = None  # what the 3D view needs
        self.shown_in = 0.0  # seconds that FreeCAD itself took to take the shape and draw it
        self.shown_in_cpu = 0.0


def prepare(result):
    return Prepared(result)


def store(obj, result):
    """Puts a BuildResult into the object: shape, file, report, verdict and status."""
    ready = getattr(result, "prepared", None) or prepare(result)
    if ready.state is None:
        ready.state = state_of(obj.Source)
    set_file(obj, ready.tsolid)
    start, cpu = time.perf_counter(), time.thread_time()
    obj.Shape = ready.shape
    ready.shown_in = time.perf_counter() - start
    ready.shown_in_cpu = time.thread_time() - cpu
    obj.Report = ready.report
    obj.Verdict = ready.verdict
    obj.BuiltOptions = ready.options
    obj.SourceState = ready.state
    _set_status(obj, CURRENT, "")
    if ready.original is None or not convert.shape_of(obj.Source).isEqual(ready.original):
        refresh_status(obj)  # the source may have changed meanwhile
    _show(obj, ready.look)
    if not obj.Source or not obj.Source.State or "Touched" not in obj.Source.State:
        obj.purgeTouched()


def _show(obj, look):
    proxy = getattr(getattr(obj, "ViewObject", None), "Proxy", None)
    if look is not None and proxy is not None:
        proxy.take(look)


def set_file(obj, data):
    """FreeCAD copies the file into the document."""
    with tempfile.TemporaryDirectory(prefix="tsolid-") as folder:
        path = os.path.join(folder, "solid.tsolid")
        with open(path, "wb") as stream:
            stream.write(data)
        obj.SolidFile = path


# ---- does the solid still belong to its source? --------------------------------------------------


def state_of(source):
    """The fingerprint of a source's shape; [] when there is none."""
    return fingerprint.of_shape(None if source is None else convert.shape_of(source))


def why_outdated(obj):
    """What has changed since the build, in words; "" when nothing has."""
    if not obj.SolidFile:
        return ""
    if obj.BuiltOptions:
        # options that did not exist when it was built had their defaults
        built = dict(api.Options().as_dict(), **json.loads(obj.BuiltOptions))
        if built != options_of(obj).as_dict():
            return "the options have changed since"
    if obj.Source is None:
        return "the part that it was made of is gone" if obj.SourceState else ""
    if not fingerprint.same(list(obj.SourceState), state_of(obj.Source)):
        return "%s has changed since" % obj.Source.Label
    return ""


def refresh_status(obj):
    """Marks the object as out of date, or as good again after an undo."""
    if not obj.SolidFile:
        return
    reason = why_outdated(obj)
    if reason:
        _set_status(obj, OUTDATED, reason)
    elif str(obj.Status) == OUTDATED:
        _set_status(obj, CURRENT, "")


def set_failed(obj, reason):
    """Keeps what was built before, if anything, and why the last build failed."""
    _set_status(obj, FAILED, reason)


def _set_status(obj, status, reason):
    """The reason is also the tree's description and tool tip, unless the user wrote one."""
    if obj.Label2 in ("", obj.Reason) and obj.Label2 != reason:
        obj.Label2 = reason
    if str(obj.Status) != status:
        obj.Status = status
    if obj.Reason != reason:
        obj.Reason = reason


def reason_of(result):
    """Why a part was refused, in one line."""
    errors = [f for f in result.findings if f.severity == binding.Severity.ERROR]
    if not errors:
        return "refused"
    more = "" if len(errors) == 1 else " (and %d more)" % (len(errors) - 1)
    return api.visible(str(errors[0])) + more


def status_text(obj):
    """The state of the object in one line, for the tree and the status bar."""
    status = str(obj.Status)
    if status == CURRENT:
        return "proved valid" if obj.Verdict == "positive" else obj.Verdict or "not measured"
    if status == OUTDATED:
        return "out of date: %s; rebuild it" % obj.Reason
    if status == FAILED:
        return "failed: %s" % obj.Reason
    return status


# ---- what is stored ------------------------------------------------------------------------------


def report_of(obj):
    """The stored report as a dict; None before the first build."""
    return json.loads(obj.Report) if obj.Report else None


def tsolid_of(obj):
    """The stored .tsolid bytes; None before the first build."""
    if not obj.SolidFile:
        return None
    with open(obj.SolidFile, "rb") as stream:
        return stream.read()


def solid_of(obj, context=None):
    """The solid T-spline as stored in the document; None before the first build."""
    data = tsolid_of(obj)
    return None if data is None else api.read_tsolid(context or binding.Context(), data)


def measure(obj, progress=None):
    """Measures a solid that came without a report, and stores that; gives the report."""
    context = binding.Context(progress)
    solid = solid_of(obj, context)
    if solid is None:
        raise ValueError("%s has not been built yet" % obj.Label)
    report = api.report_of_solid(context, solid, obj.Label)
    obj.Report = json.dumps(report, allow_nan=False)
    obj.Verdict = report["verdict"]
    return report


def is_solid_tspline(obj):
    return getattr(getattr(obj, "Proxy", None), "Type", "") == SolidTSpline.Type
