# SPDX-License-Identifier: LGPL-2.1-or-later
"""Evidence by another evaluator: the CAD kernel's own surfaces against the solid.

Nothing here uses the library's boundary evaluation: points and derivatives come from OCC, and the
solid is one that was read back from its .tsolid bytes.
"""

import math
import random

import FreeCAD
import Part

from .binding import Cancelled
from .header import Status
from .intake_patches import N_SAMPLES, SEED
from .intake_shell import CAP, PLANAR, knots_of

_RELATIVE = 1e-12  # of the scale
_ROUND_OFF = 2.0**-53


def tell(context, fraction):
    """To the context's progress callback, if there is one; raises Cancelled when it asks for it."""
    progress = getattr(context, "_progress", None)
    if progress is not None and progress("evidence", fraction):
        raise Cancelled(Status.ERROR_CANCELLED, [])


def declared_of_side(preparation, side):
    """The largest distance that preparation moved anything on a side of the cube."""
    axis, end = divmod(side, 2)
    worst = preparation["snap_inside"][side]
    for isoline in range(12):
        along, ends = divmod(isoline, 4)
        if along == axis:
            continue
        others = [a for a in range(3) if a != along]
        if (ends >> others.index(axis)) & 1 == end:
            worst = max(worst, preparation["snap"][isoline])
    return worst


def _steepest(patch, axis):
    """A bound of |dS| over a unit of the parameter's range: the derivative's control points."""
    n, m = patch.n_control
    p, knots = patch.degree[axis], patch.knots[axis]
    step, count = (1, n) if axis == 0 else (n, m)
    worst = 0.0
    for k in range(n * m):
        i = k % n if axis == 0 else k // n
        if i + 1 < count:
            width = knots[i + p + 1] - knots[i + 1]
            worst = max(worst, p * math.dist(patch.points[k], patch.points[k + step]) / width)
    if patch.weights is not None:
        worst *= (max(patch.weights) / min(patch.weights)) ** 2
    return worst * (knots[-1] - knots[0])


def declared_of_knots(preparation, patch):
    """How far merging knots may move the patch: file formats round them.

    Each of the p + 1 knots that matter at a point moves it by at most its own shift times the
    steepest |S_u| / p.
    """
    shift = preparation["knot_merge"]
    return sum(shift * (p + 1) / p * _steepest(patch, a) for a, p in enumerate(patch.degree))


class _Measure:
    """Distance of points from a face as read."""

    def __init__(self, source):
        self.source = source
        self.surface = source.surface
        self.far = max(source.deviation, 1e-7)

    def of(self, u, v, got):
        """u, v: the patch's own parameters; got: the solid's point there."""
        point = FreeCAD.Vector(*got)
        if self.source.is_spline or self.source.face is None:
            return (self.surface.value(u, v) - point).Length
        return max(self._from_surface(point), self._outside(point))

    def _from_surface(self, point):
        return (self.surface.value(*self.surface.parameter(point)) - point).Length

    def _outside(self, point):
        """0 inside the face; points that parameters do not show to be inside are measured."""
        face = self.source.face
        if face.isPartOfDomain(*self.surface.parameter(point)):
            return 0.0
        return Part.Vertex(point).distToShape(face)[0]


def _samples(source, numbers):
    """N_SAMPLES of (patch number, u, v), the patches in turn."""
    boxes = [(p.knots[0][0], p.knots[0][-1], p.knots[1][0], p.knots[1][-1])
             for p in source.patches]
    for k in range(N_SAMPLES):
        i = k % len(boxes)
        u0, u1, v0, v1 = boxes[i]
        yield i, numbers.uniform(u0, u1), numbers.uniform(v0, v1)


def _place(placements, u, v):
    """The placement whose part of the patch holds (u, v)."""
    def outside(p):
        a, b, c, d = p.domain
        return max(a - u, u - b, c - v, v - d)

    return min(placements, key=outside)


def exactness_of_face(context, source, placements, solid, numbers):
    """Largest distance of a face as read from the solid, at N_SAMPLES points, and where.

    placements[i]: where the pieces of the face's patch i lie. B-spline faces are compared at equal
    parameters; others as sets of points: the solid's point from the surface, and from the face
    where it does not lie inside.
    """
    measure = _Measure(source)
    worst, place = 0.0, None
    for i, u, v in _samples(source, numbers):
        piece = _place(placements[i], u, v)
        block, cross = solid.boundary_point(piece.side, *piece.map(u, v))
        (got,) = solid.evaluate(context, block, cross)
        far = measure.of(u, v, got)
        if far > worst or place is None:
            worst, place = far, got
    return worst, place


def exactness(context, sources, boundary, solid):
    """One row per face of the input: distance, allowed, and what the allowance is made of.

    boundary: made of the faces in this process (it knows where each face lies on the cube);
    solid: read from its file.
    """
    scale = boundary.scale
    preparation = boundary.preparation
    rows, first = [], 0
    for k, source in enumerate(sources):
        tell(context, k / len(sources))
        numbered = range(first, first + len(source.patches))
        first += len(source.patches)
        placements = [boundary.placements(i) for i in numbered]
        pieces = [p for row in placements for p in row]
        numbers = random.Random("%d %s" % (SEED, source.name))
        worst, place = exactness_of_face(context, source, placements, solid, numbers)
        declared = max(declared_of_side(preparation, p.side) for p in pieces)
        declared += max(declared_of_knots(preparation, p) for p in source.patches)
        if source.deviation > _RELATIVE * scale:
            declared += source.deviation
        allowed = _RELATIVE * scale + declared
        rows.append(
            {
                "face": source.name,
                "pieces": [{"side": p.side, "box": list(p.box)} for p in pieces],
                "kind": source.kind,
                "samples": N_SAMPLES,
                "distance": worst,
                "allowed": allowed,
                "declared": declared,
                "conversion": source.deviation,
                "point": list(place),
                "satisfied": worst <= allowed,
            }
        )
    return rows


# ---- volume ----------------------------------------------------------------------------------


def gauss(n):
    """Nodes and weights of the Gauss-Legendre rule with n points on [0, 1]."""
    nodes, weights = [], []
    for i in range(n):
        x = math.cos(math.pi * (i + 0.75) / (n + 0.5))
        for _ in range(100):
            p, q = 1.0, 0.0
            for k in range(1, n + 1):
                p, q = ((2 * k - 1) * x * p - (k - 1) * q) / k, p
            slope = n * (x * p - q) / (x * x - 1.0)
            step = p / slope
            x -= step
            if abs(step) < 1e-16:
                break
        nodes.append(0.5 * (1.0 - x))
        weights.append(1.0 / ((1.0 - x * x) * slope * slope))
    return nodes, weights


def _flux_on(surface, box, centre, rule):
    u0, u1, v0, v1 = box
    nodes, weights = rule
    terms = []
    for x, a in zip(nodes, weights):
        u = u0 + (u1 - u0) * x
        for y, b in zip(nodes, weights):
            v = v0 + (v1 - v0) * y
            normal = surface.getDN(u, v, 1, 0).cross(surface.getDN(u, v, 0, 1))
            terms.append(a * b * (surface.value(u, v) - centre).dot(normal))
    return (u1 - u0) * (v1 - v0) * math.fsum(terms)


def _flux_converged(surface, box, centre, size, depth):
    """A rational span: two rules must agree, else it is cut in four."""
    rough = _flux_on(surface, box, centre, _rule(16))
    fine = _flux_on(surface, box, centre, _rule(22))
    if abs(fine - rough) <= 1e-15 * size or depth == 0:
        return fine
    u0, u1, v0, v1 = box
    u, v = 0.5 * (u0 + u1), 0.5 * (v0 + v1)
    quarters = ((u0, u, v0, v), (u, u1, v0, v), (u0, u, v, v1), (u, u1, v, v1))
    return math.fsum(_flux_converged(surface, q, centre, size, depth - 1) for q in quarters)


_rules = {}


def _rule(n):
    if n not in _rules:
        _rules[n] = gauss(n)
    return _rules[n]


def _distinct(knots):
    return sorted(set(knots))


def sign_on_cube(placement):
    """+1 where S_u x S_v points out of the solid, -1 where into it, from where the patch lies."""
    axis, end = divmod(placement.side, 2)
    outward = 1 if end else -1
    right_handed = -1 if axis == 1 else 1  # (y, z), (x, z), (x, y) against x, y, z
    turned = (placement.flip[0] + placement.flip[1] + placement.swap) % 2
    return outward * right_handed * (-1 if turned else 1)


def _line_integral(edge, centre, normal, a, b, size, depth):
    """(x - centre) x dx . normal along an edge; two rules must agree, else it is cut in two."""

    def rule(n):
        nodes, weights = _rule(n)
        terms = []
        for x, w in zip(nodes, weights):
            t = a + (b - a) * x
            terms.append(w * (edge.point(t) - centre).cross(edge.derivative(t)).dot(normal))
        return (b - a) * math.fsum(terms)

    rough, fine = rule(16), rule(22)
    if abs(fine - rough) <= 1e-15 * size or depth == 0:
        return fine
    m = 0.5 * (a + b)
    return math.fsum(
        _line_integral(edge, centre, normal, *ends, size, depth - 1) for ends in ((a, m), (m, b))
    )


def area_by_edges(loop, centre, normal):
    """Area of a planar face from its edges alone, by Green's formula. loop: (edge, forward)."""
    terms = []
    for edge, forward in loop:
        size, knots = edge.edge.BoundBox.DiagonalLength ** 2, edge.knots()
        for a, b in zip(knots, knots[1:]):
            own = _line_integral(edge, centre, normal, a, b, size, 6)
            terms.append(own if forward else -own)
    return 0.5 * abs(math.fsum(terms))


def _outward(source, normal):
    """The unit normal of a free face turned out of the solid."""
    u, v = 0.5 * (source.box[0] + source.box[1]), 0.5 * (source.box[2] + source.box[3])
    own = source.surface.getDN(u, v, 1, 0).cross(source.surface.getDN(u, v, 0, 1))
    return normal * (source.sign if own.dot(normal) > 0.0 else -source.sign)


def _flux_of_plane(source, centre):
    plane = source.face.findPlane(1e-7)
    normal = _outward(source, plane.Axis)
    area = area_by_edges(source.loop, source.face.Vertexes[0].Point, normal)
    return area * (plane.Position - centre).dot(normal)


def _flux_of_cap(source, centre):
    """Of a sphere's part on one side of a circle: R times its area, and the circle's own area
    for the distance between the sphere's centre and ours."""
    cap = source.cap
    height = cap.radius - (cap.centre - cap.middle).dot(cap.d)
    own = cap.radius * 2.0 * math.pi * cap.radius * height
    moved = (cap.middle - centre).dot(cap.d) * math.pi * height * (2.0 * cap.radius - height)
    u, v = 0.5 * (source.box[0] + source.box[1]), 0.5 * (source.box[2] + source.box[3])
    normal = source.surface.getDN(u, v, 1, 0).cross(source.surface.getDN(u, v, 0, 1))
    outward = 1 if normal.dot(source.surface.value(u, v) - cap.middle) > 0.0 else -1
    return outward * source.sign * (own + moved)


def _spans(source, axis):
    """Where the spans of a face end, in its surface's parameters."""
    if not source.follows:
        return _distinct(k for p in source.patches for k in p.knots[axis])
    low, high = source.box[2 * axis : 2 * axis + 2]
    return [low] + [k for k in knots_of(source.surface)[axis] if low < k < high] + [high]


def _flux_of_spans(source, centre, size):
    us, vs = (_spans(source, axis) for axis in (0, 1))
    exact = source.is_spline and all(p.weights is None for p in source.patches)
    points = max(d for p in source.patches for d in p.degree) * 3 // 2 + 1
    terms = []
    for u0, u1 in zip(us, us[1:]):
        for v0, v1 in zip(vs, vs[1:]):
            box = (u0, u1, v0, v1)
            if exact:
                terms.append(_flux_on(source.surface, box, centre, _rule(points)))
            else:
                terms.append(_flux_converged(source.surface, box, centre, size, 3))
    return math.fsum(terms)


def volume_declared(sources, rows, centre, scale):
    """What the declared distances may change of the volume: each over its face's area; of a planar
    face or a cap the change of its area by its borders, times its distance; and the round-off of
    the coordinates themselves over all faces."""
    terms = []
    for source, row in zip(sources, rows):
        if source.face is None:
            continue
        area = source.face.Area
        terms.append(area * (row["declared"] + 2.0 * _ROUND_OFF * scale))
        if source.edge_area > 0.0:
            terms.append(source.edge_area * _distance_from(source, centre) / 3.0)
    return math.fsum(terms)


def _distance_from(source, centre):
    if source.way == PLANAR:
        plane = source.face.findPlane(1e-7)
        return abs((plane.Position - centre).dot(plane.Axis))
    return (source.cap.middle - centre).Length + source.cap.radius


def volume_by_flux(sources, signs, centre, size, context=None):
    """Volume as a third of the flux of x - centre through the faces as read.

    B-spline faces span by span: polynomial spans without error (the integrand has degree 3p - 1 per
    direction), rational ones and other surfaces until two rules agree to 1e-15 of `size`. Planar
    faces by Green's formula along their edges, caps of spheres in closed form.
    """
    terms = []
    for source, sign in zip(sources, signs):
        tell(context, 1.0)
        if source.way == PLANAR:
            terms.append(_flux_of_plane(source, centre))
        elif source.way == CAP:
            terms.append(_flux_of_cap(source, centre))
        else:
            terms.append(sign * _flux_of_spans(source, centre, size))
    return math.fsum(terms) / 3.0
