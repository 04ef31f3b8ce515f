# SPDX-License-Identifier: LGPL-2.1-or-later
"""One planar cut that would make acceptable parts of a refused one, as a suggestion.

Tried are planes through the middle of the part and through the axes of its round faces, along the
coordinate planes and across and along the axes. A plane is suggested when both sides of it are
single solids that the intake takes. Everything is bounded: part, number of planes, time.
"""

import time

import FreeCAD
import Part

from . import binding, intake_patches
from .binding import finding
from .header import Severity
from .intake_refuse import problems_of

STAGE = "suggestion"
SECONDS = 2.0
MAX_FACES = 40
_NEAR = 1e-6


class Plane:
    """All x with normal . x = distance."""

    def __init__(self, normal, point):
        self.normal = normal / normal.Length
        self.distance = self.normal.dot(point)

    def same(self, other):
        cosine = self.normal.dot(other.normal)
        far = abs(self.distance - cosine * other.distance)
        return abs(cosine) > 1.0 - 1e-9 and far <= _NEAR * (1.0 + abs(self.distance))

    def __str__(self):
        n, d = self.normal, self.distance + 0.0
        for name, x in zip("xyz", (n.x, n.y, n.z)):
            if abs(abs(x) - 1.0) < 1e-12:
                return "%s = %.6g" % (name, d / x + 0.0)
        return "%.6g x %+.6g y %+.6g z = %.6g" % (n.x, n.y, n.z, d)


def _planes(shape):
    """Candidates, the middle of the part first, without repetitions."""
    axes = [FreeCAD.Vector(*v) for v in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    out = [Plane(a, shape.BoundBox.Center) for a in axes]
    for face in shape.Faces:
        surface = face.Surface
        if not hasattr(surface, "Center") and not hasattr(surface, "Apex"):
            continue
        point = surface.Center if hasattr(surface, "Center") else surface.Apex
        axis = getattr(surface, "Axis", axes[2])
        beside = min(axes, key=lambda a: abs(a.dot(axis)))
        first = axis.cross(beside)
        out += [Plane(n, point) for n in (first, axis.cross(first), axis)]
    kept = []
    for plane in out:
        if not any(plane.same(other) for other in kept):
            kept.append(plane)
    return kept


def _half(shape, plane):
    """A box on one side of the plane, larger than the part."""
    size = 4.0 * shape.BoundBox.DiagonalLength
    centre = shape.BoundBox.Center
    foot = centre + plane.normal * (plane.distance - plane.normal.dot(centre))
    box = Part.makeBox(size, size, size, FreeCAD.Vector(-size / 2, -size / 2, 0))
    turn = FreeCAD.Rotation(FreeCAD.Vector(0, 0, 1), plane.normal)
    box.Placement = FreeCAD.Placement(foot, turn)
    return box


def _is_taken(shape, context):
    if len(shape.Solids) != 1 or problems_of(shape.Solids[0]):
        return False
    try:
        taken = intake_patches.take(shape.Solids[0], context)
        binding.Boundary.create(context, taken.patches)
    except binding.TsolidError:
        return False
    return True


def _works(shape, plane):
    box = _half(shape, plane)
    parts = (shape.common(box), shape.cut(box))
    if any(part.isNull() or not part.Solids for part in parts):
        return False
    context = binding.Context()
    return all(_is_taken(part, context) for part in parts)


def findings(shape):
    """A note with a plane, or nothing; never raises."""
    end = time.monotonic() + SECONDS
    try:
        if len(shape.Solids) != 1 or not 0 < len(shape.Faces) <= MAX_FACES:
            return []
        solid = shape.Solids[0]
        if not solid.isClosed() or len(solid.Shells) != 1:
            return []
        for plane in _planes(solid):
            if time.monotonic() > end:
                break
            if _works(solid, plane):
                text = "a cut with the plane %s would make two parts that can be taken" % plane
                return [finding(Severity.NOTE, STAGE, "", text)]
    except (Part.OCCError, ValueError, RuntimeError, TypeError, IndexError, ZeroDivisionError):
        pass  # it was only a suggestion
    return []
