# SPDX-License-Identifier: LGPL-2.1-or-later
"""Loose faces, as IGES files hold them, made to solids.

The CAD kernel's own sewing makes one edge of two that run along each other within a tolerance; the
faces' surfaces stay as they are. Tried are the tolerances of the file, then a growing one for all,
up to a small part of the size, or of the coordinates where these are much larger; the first at
which everything closes and is valid is taken, if none is valid the first at which it closes.
"""

import Part

from . import binding
from .header import Severity
from .intake_shell import uses_of

SMALLEST, LARGEST = 1e-7, 1e-5  # mm; of the diagonal
DIGITS = 2e-9  # of the coordinates: as two points may differ that are written with ten digits
N_SAMPLES = 32


def sewn(shape):
    """(shape, notes): the solids that the shape's loose faces bound, and how well they fit. A
    shape with shells, and one whose faces do not close, is given back as it is, without notes.
    Faces that lie on one another would be sewn in any way, so they are not."""
    if shape is None or shape.isNull() or shape.Shells or not shape.Faces:
        return shape, []
    if doubled(shape):
        return shape, []
    best = []
    for tolerance in _tolerances(shape.BoundBox):
        solids = _closed(shape, tolerance)
        if solids and all(s.isValid() for s in solids):
            best = solids
            break
        best = best or solids
    if not best:
        return shape, []
    made = best[0] if len(best) == 1 else Part.makeCompound(best)
    return made, [_note(shape, made)]


def _tolerances(box):
    """None: those that the edges have."""
    yield None
    most = max(LARGEST * box.DiagonalLength,
               DIGITS * max(map(abs, (box.XMin, box.XMax, box.YMin, box.YMax, box.ZMin, box.ZMax))))
    tolerance = SMALLEST
    while tolerance < most:
        yield tolerance
        tolerance *= 10.0
    yield most


def _closed(shape, tolerance):
    """The solids of all faces; [] when some are left open."""
    shells = stitched(shape, tolerance).Shells
    n_faces = sum(len(s.Faces) for s in shells)
    if n_faces != len(shape.Faces) or any(not s.isClosed() or faults(s) for s in shells):
        return []
    return [_solid(_in_order(shell, shape)) for shell in shells]


def stitched(shape, tolerance=None):
    """The faces with common edges where they fit, closed or not."""
    given = shape.copy()
    if tolerance is not None:
        given.fixTolerance(tolerance)
    try:
        return Part.makeShell(given.Faces)  # sews what does not hang together
    except (Part.OCCError, ValueError, TypeError):
        return given


def _key(face):
    """By which a face is known again, to a millionth."""
    return tuple(round(x, 6) for x in tuple(face.CenterOfMass) + (face.Area,))


def doubled(shape):
    """Two faces that lie on one another, as of parts that touch: their names; None."""
    known = {}
    for k, face in enumerate(shape.Faces, 1):
        first = known.setdefault(_key(face), (k, face))
        if first[0] != k and all(_is_near(v, first[1]) for v in face.Vertexes):
            return "Face%d, Face%d" % (first[0], k)
    return None


def _is_near(vertex, face):
    return any((vertex.Point - v.Point).Length <= 1e-6 for v in face.Vertexes)


def _in_order(shell, shape):
    """The shell with its faces in the order of the file, as far as they can be told apart."""
    number = {_key(face): k for k, face in enumerate(shape.Faces)}
    places = {k: face.CenterOfMass for k, face in enumerate(shape.Faces)}

    def place(face):
        k = number.get(_key(face))
        if k is None:
            k = min(places, key=lambda i: (places[i] - face.CenterOfMass).Length)
        return k

    ordered = Part.makeShell(sorted(shell.Faces, key=place))
    return ordered if ordered.isClosed() and len(ordered.Faces) == len(shell.Faces) else shell


def _solid(shell):
    solid = Part.makeSolid(shell)
    if solid.Volume < 0.0:
        solid.reverse()
    return solid


def _note(loose, made):
    n = len(made.Solids)
    text = "%d loose faces were sewn to %s; along their edges they are apart by up to" % (
        len(loose.Faces), "one solid" if n == 1 else "%d solids" % n)
    return binding.finding(Severity.NOTE, "shape", "", text, measured=gap(made))


def _uses(shape):
    """Per edge: it, and the (edge, face) by which it is used."""
    rows, pools = [], {}
    for edge in shape.Edges:
        rows.append((edge, []))
        pools.setdefault(edge.hashCode(), []).append(rows[-1])
    for face in shape.Faces:
        for edge in (e for wire in face.Wires for e in uses_of(wire) if not e.Degenerated):
            own = next(row for known, row in pools[edge.hashCode()] if known.isSame(edge))
            own.append((edge, face))
    return [row for row in rows if not row[0].Degenerated]


def faults(shape):
    """(number of faces, point) of every edge that one face uses, or more than two."""
    rows = [(e, len(uses)) for e, uses in _uses(shape) if len(uses) != 2]
    return [(n, e.valueAt(0.5 * sum(e.ParameterRange))) for e, n in rows]


def gap(shape):
    """The largest distance, at samples, of two faces along an edge that they share."""
    pairs = [[_places(*use) for use in uses] for _, uses in _uses(shape)]
    return max(((p - q).Length for a, b in pairs for p, q in zip(a, b)), default=0.0)


def _places(edge, face):
    """Points along the edge as a face has it, by the edge's parameter."""
    given = face.curveOnSurface(edge)
    if given is None:
        first, last = edge.ParameterRange
        points = (first + (last - first) * i / N_SAMPLES for i in range(N_SAMPLES + 1))
        return [edge.valueAt(t) for t in points]
    curve, first, last = given[:3]
    out = []
    for i in range(N_SAMPLES + 1):
        p = curve.value(first + (last - first) * i / N_SAMPLES)
        out.append(face.Surface.value(p.x, p.y))
    return out
