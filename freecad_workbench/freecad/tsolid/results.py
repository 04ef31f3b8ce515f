# SPDX-License-Identifier: LGPL-2.1-or-later
"""Results of an analysis on a SolidTSpline: a temperature, a displacement, given as one or three
coefficients per function of the solid, kept in the document, shown as colours, written as .vtu.

    import freecad.tsolid as ts
    from freecad.tsolid import results
    results.read(obj, "displacement.petsc")          # or a dense MatrixMarket table
    results.put(obj, "temperature", coefficients)
    ts.look_inside(obj, mode="Elements", colour="Result")
    results.write_vtu(obj, "part.vtu")

The functions are those of `tsolid export --matrices`. A result belongs to the very solid that it
was computed on: after a rebuild there is none.
"""

import hashlib
import math
import os
import tempfile

from . import analysis, binding, document

_PROPERTIES = (
    ("App::PropertyString", "ResultName", "What was computed"),
    ("App::PropertyInteger", "ResultComponents", "1: a number, 3: a vector"),
    ("App::PropertyFloatList", "ResultValues", "Coefficients of the solid's functions"),
    ("App::PropertyString", "ResultOf", "Check sum of the solid that it was computed on"),
)


def put(obj, name, coefficients):
    """Keeps a result with the object; ValueError when it does not fit the solid."""
    solid = document.solid_of(obj)
    if solid is None:
        raise ValueError("%s has not been built yet" % obj.Label)
    values, n = [], solid.space.n_functions
    for row in coefficients:
        try:
            values.extend(float(x) for x in row)
        except TypeError:
            values.append(float(row))
    if len(values) not in (n, 3 * n):
        raise ValueError(
            "%d numbers; the solid has %d functions, so %d or %d are expected"
            % (len(values), n, n, 3 * n)
        )
    if not all(math.isfinite(x) for x in values):
        raise ValueError("a coefficient is not finite")
    for kind, property_name, description in _PROPERTIES:
        if property_name not in obj.PropertiesList:
            obj.addProperty(kind, property_name, "Analysis", description)
            obj.setEditorMode(property_name, 1 if property_name == "ResultName" else 2)
    obj.ResultName, obj.ResultComponents = name, len(values) // n
    obj.ResultOf = _check_sum(obj)
    obj.ResultValues = values  # last: the view looks when these change


def read(obj, path, name=None):
    """The same from a file: a dense MatrixMarket table or a PETSc vector."""
    _, _, values = analysis.read_table(binding.Context(), path)
    put(obj, name or os.path.splitext(os.path.basename(path))[0], values)


def clear(obj):
    if "ResultValues" in obj.PropertiesList:
        obj.ResultName, obj.ResultOf = "", ""
        obj.ResultValues = []


def of(obj):
    """(name, components, coefficients) of the result; None without one, or when the solid has
    changed since."""
    if "ResultValues" not in obj.PropertiesList or not obj.ResultOf:
        return None
    if obj.ResultOf != _check_sum(obj):
        return None
    return obj.ResultName, obj.ResultComponents, list(obj.ResultValues)


def write_vtu(obj, path):
    """The solid for VTK and ParaView, with the result as point data."""
    context = binding.Context()
    found = of(obj)
    fields = {found[0]: found[2]} if found else {}
    analysis.write_vtu_fields(context, document.solid_of(obj, context), path, fields)


def nets(solid, coefficients, components):
    """Per element Bezier coefficients of the result times weight: arrays [k2, k1, k0, component].
    Divided by the weights of the geometry's nets, and only at points, they are the result."""
    import numpy as np

    context = binding.Context()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "x")
        analysis.write_extraction(context, solid, path)
        data = np.memmap(path, np.uint8, "r")
        out = _nets(data, np.asarray(coefficients, float).reshape(-1, components))
        del data
    return out


def _nets(data, coefficients):
    """See write_extraction.c for the file."""
    import numpy as np

    at = 8

    def take(kind, n):
        nonlocal at
        part = np.frombuffer(data, kind, int(n), at)
        at += 8 * int(n)
        return part

    n_functions, n_elements, n_entries, n_rows = take("<i8", 4)
    weighted = coefficients * take("<f8", 4 * n_functions).reshape(-1, 4)[:, 3:]
    at += 8 * int(7 * n_elements)  # blocks and boxes
    degree = take("<i8", 3 * n_elements).reshape(-1, 3)
    start = take("<i8", n_elements + 1)
    function, rows = take("<i8", n_entries), take("<f8", n_rows)
    out, first = [], 0
    for e in range(n_elements):
        d0, d1, d2 = degree[e] + 1
        ids = function[start[e] : start[e + 1]]
        width = int(d0 * d1 * d2)
        row = rows[first : first + width * len(ids)].reshape(len(ids), width)
        first += row.size
        out.append((row.T @ weighted[ids]).reshape(d2, d1, d0, -1))
    return out


def colour(look, obj):
    """Gives the object's result to a tessellate.Look; none when there is none."""
    found = of(obj)
    if found is None:
        look.set_result("", None)
    else:
        look.set_result(found[0], nets(look.solid, found[2], found[1]))


def _check_sum(obj):
    return hashlib.sha256(document.tsolid_of(obj) or b"").hexdigest()
