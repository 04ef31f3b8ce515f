# SPDX-License-Identifier: LGPL-2.1-or-later
"""Planar patches over four border curves; no FreeCAD, nothing but the standard library.

    patch, report = coons.patch(context, (v_low, u_high, v_high, u_low), name="Face3")
"""

import ctypes
from ctypes import byref, c_double, c_void_p

from . import header
from .binding import Patch, Refused, _doubles, _Handle, as_dict


class Curve:
    """A clamped NURBS curve; see tsolid_curve."""

    __slots__ = ("degree", "knots", "points", "weights", "name")

    def __init__(self, degree, knots, points, weights=None, name=""):
        self.degree = degree
        self.knots = tuple(knots)
        self.points = [tuple(p) for p in points]
        self.weights = None if weights is None else list(weights)
        self.name = name
        n = len(self.points)
        if len(self.knots) != n + degree + 1 or any(len(p) != 3 for p in self.points):
            raise ValueError("%s: numbers of knots or control points do not fit" % name)
        if self.weights is not None and len(self.weights) != n:
            raise ValueError("%s: one weight per control point" % name)

    def fill(self, struct, keep):
        """Fills a header.Curve; appends to keep what must live as long."""
        struct.degree = self.degree
        struct.n_control = len(self.points)
        struct.knots = _array(self.knots, keep)
        struct.points = _array(self.points, keep)
        if self.weights is not None:
            struct.weights = _array(self.weights, keep)
        struct.name = self.name.encode() or None


def _array(values, keep):
    memory, _ = _doubles(values)
    keep.append(memory)
    return ctypes.cast(memory, ctypes.POINTER(c_double))


class _Coons(_Handle):
    _free = "tsolid_coons_free"


def patch(context, borders, tolerance=0.0, normal=None, name="", corner_names=None,
          repair=header.CoonsRepair.REPAIR_AUTOMATIC):
    """A planar Patch whose borders are the four Curves: v low, u high, v high, u low.

    Each runs in the direction of u or v. Returns the patch and the report as a dict. Raises Refused
    (with .report, as far as the work got) when there is no such patch that is proved not to fold.
    """
    borders, keep = tuple(borders), []
    if len(borders) != 4:
        raise ValueError("a patch has four borders, not %d" % len(borders))
    curves = (header.Curve * 4)()
    for struct, curve in zip(curves, borders):
        curve.fill(struct, keep)
    options = header.CoonsOptions(tolerance=tolerance, repair=repair, name=name.encode() or None)
    options.normal[:] = normal or (0.0, 0.0, 0.0)
    for k, corner in enumerate(corner_names or ()):
        options.corner_name[k] = corner.encode() or None
    report, handle = header.CoonsReport(), c_void_p()
    try:
        context.call(
            "tsolid_coons_create", curves, byref(options), byref(report), byref(handle)
        )
    except Refused as error:
        error.report = as_dict(report)
        raise
    owner = _Coons(context, handle)
    struct = header.PatchStruct()
    context.library.tsolid_coons_get(owner.handle, byref(struct))
    return Patch.from_struct(struct), as_dict(report)
