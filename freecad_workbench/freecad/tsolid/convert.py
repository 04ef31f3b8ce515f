# SPDX-License-Identifier: LGPL-2.1-or-later
"""From a FreeCAD shape to NURBS patches and back.

Taken: one solid whose surface is a cube's, seen as a rectangular layout of four-sided faces. Faces
trimmed along isoparametric lines are taken as they are, as exact rational patches; planar faces
with any edges, and caps of spheres, are filled between their borders; discs get the corners that
they lack, and the walls beside them are cut there. Everything else is refused with FreeCAD's names
(Face3, Edge7, Vertex2). The steps are modules of their own: see intake_patches.py.
"""

import math

import Part

from . import binding, intake_caps, intake_patches
from .binding import Refused
from .header import Severity, Status
from .intake_refuse import problems_of, the_solid
from .intake_shell import CAP, PLANAR, RIGID
from .occ_spline import (  # noqa: F401
    patch_of_surface,
    patches_of_boundary,
    solid_of_faces,
    solid_of_patches,
    surface_of_patch,
)


def shape_of(given):
    """The shape of a document object, with the placements of what it links to and holds (Link,
    App::Part); a shape stands for itself."""
    if not hasattr(given, "Document"):
        return given
    if hasattr(given, "Shape") and not given.isDerivedFrom("App::Link"):
        return given.Shape
    return Part.getShape(given)


class Source:
    """One face of the input.

    patches: what it became; surface is OCC's as read, box the range of its parameters that the face
    covers, sign -1 where the face looks against the surface's normal (0: not known), kind the
    type as read, way how it was taken (rigid, planar, cap), deviation the largest distance that
    re-writing it as B-splines caused. face: OCC's face, None where there was none. edge_area: of a
    free face, how much its area may differ from what its edges' own curves enclose, because it is
    filled between its neighbours' borders, which are that near to the edges. follows: it has its
    parameters from another face. cap: the geometry of a sphere's cap. loop: a free face's edges, as
    intake_shell.Face has them.
    """

    def __init__(self, name, patches, surface, box, sign, kind, way=RIGID, face=None, **measured):
        self.name, self.patches = name, patches
        self.surface, self.box, self.sign, self.kind = surface, box, sign, kind
        self.way, self.face = way, face
        self.deviation = measured.get("deviation", 0.0)
        self.snap = measured.get("snap", 0.0)
        self.edge_area = measured.get("edge_area", 0.0)
        self.follows = measured.get("follows", False)
        self.cap, self.loop = measured.get("cap"), measured.get("loop", ())

    @property
    def patch(self):
        return self.patches[0]

    @property
    def is_spline(self):
        """Are the patches' parameters the surface's own?"""
        return self.way == RIGID and self.kind == "BSplineSurface" and not self.follows


def sources_of_shape(shape, tell=None, corners=(), context=None):
    """The faces of the shape's one solid, in FreeCAD's order, and notes about how they were taken.

    tell(fraction), if given, is called before every face; what it raises ends the work. corners:
    names of vertices that have to be corners of the cube.
    """
    the_solid(shape)
    problems = problems_of(shape)
    if problems:
        raise Refused(Status.ERROR_REFUSED, problems)
    taken = intake_patches.take(shape, context or binding.Context(), corners, tell)
    sources = []
    for k, face in enumerate(taken.shell.faces):
        patches = [p for p, owner in zip(taken.patches, taken.owners) if owner == k]
        source = Source(
            face.name, patches, face.surface, face.box, face.sign, face.type, face.kind, face.face,
            deviation=taken.deviations[k], snap=face.snap, edge_area=_edge_area(face, taken),
            follows=face.number in taken.followers,
            loop=face.loop,
            cap=intake_caps.Sphere(face) if face.kind == CAP else None,
        )
        sources.append(source)
    notes = [_note(s, shape) for s in sources if not s.is_spline]
    least = 1e-12 * scale_of_shape(shape)
    notes += taken.findings + [_snap_note(s) for s in sources if s.snap > least]
    return sources, notes


def _edge_area(face, taken):
    """Sum over a free face's edges: distance from the border that was taken for it x length."""
    return math.fsum(
        edge.edge.Length
        * max((other.distance_of_edge(edge) + taken.deviations[other.number - 1]
               for other, _ in edge.uses if other.kind == RIGID), default=0.0)
        for edge, _ in face.loop
    )


_HOW = {
    RIGID: "re-written as a B-spline",
    PLANAR: "filled between its edges, in its plane,",
    CAP: "filled between its edges, on its sphere,",
}


def _note(source, shape):
    allowed = 1e-12 * scale_of_shape(shape)
    exact = source.deviation <= allowed
    n = len(source.patches)
    pieces = "" if n == 1 else " in %d pieces" % n
    return binding.finding(
        Severity.NOTE if exact else Severity.WARNING,
        "shape",
        source.name,
        "%s %s%s%s" % (source.kind, _HOW[source.way], pieces, " exactly" if exact else ""),
        measured=source.deviation,
        allowed=allowed,
    )


def _snap_note(source):
    text = "its edges leave the isoparametric lines, within the tolerance, by"
    return binding.finding(Severity.NOTE, "shape", source.name, text, measured=source.snap)


def scale_of_shape(shape):
    """The larger of the bounding box's diagonal and the largest |coordinate|."""
    box = shape.BoundBox
    limits = (box.XMin, box.XMax, box.YMin, box.YMax, box.ZMin, box.ZMax)
    return max([box.DiagonalLength] + [abs(x) for x in limits])


def source_of_patch(patch, number):
    """A Source of a patch that no shape stands behind, so that it can be measured like a face."""
    surface = surface_of_patch(patch)
    name = patch.name or "patch %d" % number
    return Source(name, [patch], surface, surface.bounds(), 0, "BSplineSurface")
