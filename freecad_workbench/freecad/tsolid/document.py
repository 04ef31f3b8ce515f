# SPDX-License-Identifier: LGPL-2.1-or-later
"""The document object SolidTSpline: the part's solid, the solid T-spline, and its report.

The Shape is the closed solid made of the input's very faces. The solid T-spline itself is the file
property SolidFile, byte for byte what was built; a recompute never builds, only build() does.
This class's path (freecad.tsolid.document.SolidTSpline) is stored in documents: it never moves.
"""

import json
import os
import tempfile

import FreeCAD
import Part

from . import api, binding

VERSION = 1  # of the object's properties; onDocumentRestored migrates older ones

_PROPERTIES = (
    # type, name, group, description, read-only
    ("App::PropertyLink", "Source", "Input", "The part whose faces bound the solid", False),
    ("App::PropertyInteger", "RefineKnots", "Options", "Halve every knot span so often", False),
    ("App::PropertyInteger", "RaiseDegree", "Options", "Raise the sides' degree by so much", False),
    ("App::PropertyInteger", "MinCells", "Options", "Cells per axis inside, at least", False),
    ("App::PropertyEnumeration", "Effort", "Options", "How hard to smooth the elements", False),
    ("App::PropertyFloat", "Tolerance", "Options", "Of edges without their own; 0: 1e-7", False),
    ("App::PropertyString", "Verdict", "Result", "Is det J > 0 proved everywhere?", True),
    ("App::PropertyString", "Report", "Result", "The conformity report (JSON)", True),
    ("App::PropertyFileIncluded", "SolidFile", "Result", "The solid T-spline (.tsolid)", True),
    ("App::PropertyInteger", "Version", "Result", "Version of this object's properties", True),
)


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
        for kind, name, group, description, read_only in _PROPERTIES:
            if read_only:
                obj.setEditorMode(name, 1)

    def onDocumentRestored(self, obj):
        self.add_properties(obj)
        if obj.Version < VERSION:
            obj.Version = VERSION

    def execute(self, obj):
        """Nothing: long work in a recompute would punish every edit."""

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
    return obj


def options_of(obj, threads=0):
    return api.Options(
        refine_knots=obj.RefineKnots,
        raise_degree=obj.RaiseDegree,
        min_cells=obj.MinCells,
        effort=str(obj.Effort),
        threads=threads,
        tolerance=obj.Tolerance,
    )


def set_options(obj, options):
    obj.RefineKnots = options.refine_knots
    obj.RaiseDegree = options.raise_degree
    obj.MinCells = options.min_cells
    obj.Effort = options.effort
    obj.Tolerance = options.tolerance


def rebuild(obj, progress=None, threads=0):
    """Builds from the object's Source and stores the result when there is one."""
    result = api.build(obj.Source, options_of(obj, threads), progress)
    if result.solid is not None:
        store(obj, result)
    return result


def store(obj, result):
    """Puts a BuildResult into the object: shape, file, report and verdict."""
    shape = result.shape.copy()
    if not shape.isClosed() or not shape.isValid():
        raise ValueError("the faces do not make a closed valid solid")
    with tempfile.TemporaryDirectory(prefix="tsolid-") as folder:
        path = os.path.join(folder, "solid.tsolid")
        with open(path, "wb") as stream:
            stream.write(result.tsolid)
        obj.SolidFile = path  # FreeCAD copies it into the document
    obj.Shape = Part.Shape(shape)
    obj.Report = json.dumps(result.report, allow_nan=False)
    obj.Verdict = result.verdict


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


def is_solid_tspline(obj):
    return getattr(getattr(obj, "Proxy", None), "Type", "") == SolidTSpline.Type
