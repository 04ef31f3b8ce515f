# SPDX-License-Identifier: LGPL-2.1-or-later
"""Evidence by another evaluator: the CAD kernel's own surfaces against the solid.

Nothing here uses the library's boundary evaluation: points and derivatives come from OCC, and the
solid is one that was read back from its .tsolid bytes.
"""

import math
import random

from .binding import Cancelled
from .convert import N_SAMPLES, SEED
from .header import Status

_RELATIVE = 1e-12  # of the scale


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


def exactness_of_face(context, source, placement, solid, numbers):
    """Largest distance of N_SAMPLES points of a face from the solid at the same parameters."""
    u0, u1, v0, v1 = source.box
    worst, place = 0.0, None
    for _ in range(N_SAMPLES):
        u, v = numbers.uniform(u0, u1), numbers.uniform(v0, v1)
        want = source.surface.value(u, v)
        block, cross = solid.boundary_point(placement.side, *placement.map(u, v))
        (got,) = solid.evaluate(context, block, cross)
        far = math.dist((want.x, want.y, want.z), got)
        if far > worst or place is None:
            worst, place = far, (want.x, want.y, want.z)
    return worst, place


def exactness(context, sources, boundary, solid):
    """One row per face of the input: distance, allowed, and what the allowance is made of.

    boundary: made of the faces in this process (it knows where each face lies on the cube);
    solid: read from its file.
    """
    scale = boundary.scale
    preparation = boundary.preparation
    rows = []
    for k, source in enumerate(sources):
        tell(context, k / len(sources))
        placement = boundary.placement(k)
        numbers = random.Random("%d %s" % (SEED, source.name))
        worst, place = exactness_of_face(context, source, placement, solid, numbers)
        declared = declared_of_side(preparation, placement.side)
        declared += declared_of_knots(preparation, source.patch)
        worst += source.deviation  # of the surface as read from the one that was sampled
        if source.deviation > _RELATIVE * scale:
            declared += source.deviation
        allowed = _RELATIVE * scale + declared
        rows.append(
            {
                "face": source.name,
                "side": placement.side,
                "box": list(placement.box),
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


def volume_by_flux(sources, signs, centre, size, context=None):
    """Volume as a third of the flux of x - centre through OCC's surfaces, span by span.

    Polynomial spans are integrated without error (the integrand has degree 3p - 1 per direction);
    rational ones until two rules agree to 1e-15 of `size`.
    """
    terms = []
    for source, sign in zip(sources, signs):
        tell(context, 1.0)
        patch = source.patch
        points = max(patch.degree) * 3 // 2 + 1
        us, vs = _distinct(patch.knots[0]), _distinct(patch.knots[1])
        for u0, u1 in zip(us, us[1:]):
            for v0, v1 in zip(vs, vs[1:]):
                box = (u0, u1, v0, v1)
                if patch.weights is None:
                    part = _flux_on(source.surface, box, centre, _rule(points))
                else:
                    part = _flux_converged(source.surface, box, centre, size, 3)
                terms.append(sign * part)
    return math.fsum(terms) / 3.0
