# SPDX-License-Identifier: LGPL-2.1-or-later
"""Is there one solid in the shape, bounded by one closed shell? Refusals with FreeCAD's names."""

import collections

from . import sewing
from .binding import Refused, finding
from .header import Severity, Status
from .intake_shell import uses_of


SLIVER = 20.0  # times the tolerance


def error(where, text, **numbers):
    return finding(Severity.ERROR, "shape", where, text, **numbers)


def note(where, text, **numbers):
    return finding(Severity.NOTE, "shape", where, text, **numbers)


def refuse(where, text, **numbers):
    raise Refused(Status.ERROR_REFUSED, [error(where, text, **numbers)])


class Names:
    """FreeCAD's names of the sub-shapes of a shape."""

    def __init__(self, shape):
        self._pools = {"Edge": {}, "Vertex": {}}
        self.edges = shape.Edges
        for word, items in (("Edge", self.edges), ("Vertex", shape.Vertexes)):
            for number, item in enumerate(items, 1):
                self._pools[word].setdefault(item.hashCode(), []).append((number, item))

    def of(self, word, item):
        for number, known in self._pools[word].get(item.hashCode(), ()):
            if known.isSame(item):
                return "%s%d" % (word, number)
        return ""

    def edge(self, item):
        return self.of("Edge", item)

    def vertex(self, item):
        return self.of("Vertex", item)


def _free_edges(shape, names):
    """Edges that only one face uses (once): name and a point of each."""
    count = collections.Counter()
    items = {}
    for face in shape.Faces:
        for wire in face.Wires:
            for edge in uses_of(wire):
                if not edge.Degenerated:
                    name = names.edge(edge)
                    count[name] += 1
                    items[name] = edge
    free = [n for n in items if count[n] == 1]
    return [(n, items[n].valueAt(sum(items[n].ParameterRange) / 2)) for n in free]


def the_solid(shape):
    """The one solid of a shape; Refused when there is none, more than one, or a void in it."""
    if shape is None or shape.isNull():
        refuse("", "the shape is empty")
    solids = shape.Solids
    if not solids:
        _refuse_no_solid(shape)
    if len(solids) > 1:
        parts = ", ".join("Solid%d" % (i + 1) for i in range(len(solids)))
        text = (
            "the shape holds %d solids; take one at a time, or check all together, with the faces "
            "that they share, as an assembly" % len(solids)
        )
        refuse(parts, text)
    solid = solids[0]
    loose = len(shape.Faces) - len(solid.Faces)
    if loose:
        refuse("", "%d faces of the shape do not belong to its solid" % loose)
    if len(solid.Shells) != 1:
        refuse("", "the solid has a void inside: it is bounded by %d shells" % len(solid.Shells))
    return solid


def _refuse_no_solid(shape):
    if not shape.Faces:
        refuse("", "not a solid: the shape (%s) has no faces" % shape.ShapeType)
    if len(shape.Faces) > 1 and not shape.Shells:
        raise Refused(Status.ERROR_REFUSED, _of_loose_faces(shape))
    free = _open_edges(shape)
    if not free:
        refuse(
            "",
            "not a solid but a closed surface (%s): make a solid of it first (Part, Convert to "
            "solid)" % shape.ShapeType,
        )
    raise Refused(Status.ERROR_REFUSED, free)


def _of_loose_faces(shape):
    """What can be done about faces without a shell, as IGES files give them."""
    n = len(shape.Faces)
    if sewing.sewn(shape)[0].Solids:
        text = (
            "not a solid but %d loose faces, which fit together: sew them first (Part, Shape "
            "builder: shell from faces, then solid from shell)" % n
        )
        return [error("", text)]
    twice = sewing.doubled(shape)
    if twice:
        text = "two of %d loose faces lie on one another, as of parts that touch: " % n
        return [error(twice, text + "make a solid of each part by itself")]
    text = "%d loose faces do not close to a solid when they are sewn: " % n
    words = ("they are open along an edge", "more than two meet in an edge")
    return [error("", text + words[uses > 2], point=point)
            for uses, point in sewing.faults(sewing.stitched(shape))]


def _open_edges(shape):
    text = "not a solid: the surface is open along this edge"
    return [error(name, text, point=p) for name, p in _free_edges(shape, Names(shape))]


# ---- the shape as a whole ------------------------------------------------------------------------


def genus(shape):
    """Holes through a closed shell: V - E + F = 2 - 2 g, a face with inner borders counted less."""
    edges = sum(not e.Degenerated for e in shape.Edges)
    faces = sum(2 - len(f.Wires) for f in shape.Faces)
    return 1 - (len(shape.Vertexes) - edges + faces) // 2


def _genus_problem(shape):
    n = genus(shape)
    if n <= 0:
        return []
    inner = ["Face%d" % k for k, f in enumerate(shape.Faces, 1) if len(f.Wires) > 1]
    where = ", ".join(inner) or "Face1"
    text = (
        "the part has %d hole%s through it (genus %d), a cube has none: split the part with a "
        "plane through each hole" % (n, "" if n == 1 else "s", n)
    )
    return [error(where, text)]


def _short_edges(shape):
    """Edges that are not longer than the tolerance within which their ends are known."""
    out = []
    for number, edge in enumerate(shape.Edges, 1):
        if edge.Degenerated:
            continue
        tolerance = max([edge.Tolerance] + [v.Tolerance for v in edge.Vertexes])
        length = edge.Length
        if length <= 2.0 * tolerance:
            text = (
                "the edge is not longer than the tolerance of its ends: remove it, or the small "
                "feature that it belongs to"
            )
            point = edge.valueAt(0.5 * sum(edge.ParameterRange))
            out.append(error("Edge%d" % number, text, point=point, measured=length,
                             allowed=2.0 * tolerance))
    return out


def _slivers(shape):
    """Faces that are narrower than their edges' tolerance."""
    out = []
    for number, face in enumerate(shape.Faces, 1):
        length = sum(e.Length for e in face.Edges if not e.Degenerated)
        tolerance = max([face.Tolerance] + [e.Tolerance for e in face.Edges])
        if length <= 0.0 or face.Area <= 0.0:
            continue
        width = 2.0 * face.Area / length
        if width <= SLIVER * tolerance:
            text = (
                "the face is a sliver, hardly wider than the tolerance of its edges: remove it "
                "(Part, Defeaturing) or the small feature that it belongs to"
            )
            out.append(error("Face%d" % number, text, point=face.CenterOfMass, measured=width,
                             allowed=SLIVER * tolerance))
    return out


def _invalid_faces(shape):
    out = []
    for number, face in enumerate(shape.Faces, 1):
        if not face.isValid():
            text = (
                "the face is not valid in the CAD kernel's own check (its border crosses itself, "
                "or its edges do not lie on it): repair it first (Part, Check geometry)"
            )
            out.append(error("Face%d" % number, text, point=face.CenterOfMass))
    return out


def problems_of(shape):
    """What no choice of corners could cure, each with its place."""
    missing = _open_edges(shape)
    if missing:
        return missing
    small = _short_edges(shape) + _slivers(shape)
    return small or _invalid_faces(shape) or _genus_problem(shape)
