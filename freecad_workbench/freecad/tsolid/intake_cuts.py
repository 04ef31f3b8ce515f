# SPDX-License-Identifier: LGPL-2.1-or-later
"""Missing corners: vertices added on curved edges, and the isolines that start there.

A disc has no corners, a half disc two, a sector three. A free face that lacks corners gets them on
its curved edges, such that the borders turn by equal angles; the rigid face on the other side is
cut along the isoline from there, and the next one, until the line ends on a free face (which has
its corner there then: both caps of a bar are cut by the same four lines) or in a vertex.
"""

import math

from . import intake_lenses
from .intake_cells import cells_of, uses
from .intake_exact import is_trig
from .intake_shell import PLANAR, RIGID, arcs_of, near

FLAT = math.radians(10.0)  # a straight border's vertex turning by less is no corner
CURVED = math.radians(5.0)  # an edge turning by less is taken for straight
# Two curves that only nearly pass into each other (arcs after a file format, say) make a bad
# corner: one of 180 degrees and a little more cannot be filled. A point inside a smooth curve can.
# Where edges meet, round-off alone would tell the two apart, and differently after a file; only the
# begin of a closed arc is surely smooth. TANGENT is the library's TSI_SINGULAR_TOLERANCE, and as
# there grows with what some roundings of coordinates do to the direction of a short leg.
TANGENT, NEARLY = 1e-12, 1e-5
ROUNDINGS = 32.0 * 2.0**-53
N_TURN = 256  # tangents per edge by which its turning is measured


# ---- lines across rigid faces ------------------------------------------------------------------


def edge_at(face, k, value):
    """The edge of border k, and its parameter, where the border's parameter is `value`."""
    spans = face.along(k)
    edge, forward, low, high = min(spans, key=lambda s: max(s[2] - value, value - s[3], 0.0))
    a, b = edge.first, edge.last
    for t in (a, b):
        if abs(face.parameter_on(k, edge, t) - value) <= 1e-12 * (high - low):
            return edge, t
    for _ in range(200):
        t = 0.5 * (a + b)
        if t in (a, b):
            break
        if (face.parameter_on(k, edge, t) < value) == forward:
            a = t
        else:
            b = t
    return edge, _better(face, k, edge, value, a, b)


def _better(face, k, edge, value, a, b):
    """Of two neighbouring numbers the one closer to the value; a quarter turn stays one."""
    return min((a, b), key=lambda t: abs(face.parameter_on(k, edge, t) - value))


def cut_from(shell, edge, t):
    """Adds a vertex on an edge, and the isolines that start there; they end on free faces."""
    left = [(edge, t)]
    while left:
        edge, t = left.pop()
        shell.add_node(edge, t)
        for face, k in list(edge.uses):
            if face.kind != RIGID:
                continue
            value, axis = face.parameter_on(k, edge, t), k % 2
            ends = (face.box[:2], face.box[2:])[axis]
            if any(near(face, axis, value, x) for x in list(ends) + face.cuts[axis]):
                continue
            face.cuts[axis].append(value)
            face.cuts[axis].sort()
            left.append(edge_at(face, (k + 2) % 4, value))


# ---- how borders turn ----------------------------------------------------------------------------


def tangents(edge, a, b):
    return [edge.tangent(a + (b - a) * i / N_TURN) for i in range(N_TURN + 1)]


def turning(edge, a, b):
    """The angle by which the tangent turns, and its sum up to each of N_TURN + 1 points."""
    sums, last = [0.0], None
    for d in tangents(edge, a, b):
        if last is not None:
            sums.append(sums[-1] + math.atan2(last.cross(d).Length, last.dot(d)))
        last = d
    return sums


class Corner:
    """A vertex of a free face's loop: the interior angle, and whether its edges are curved.
    surely: where it looks smooth it is; error: by how much round-off may turn the tangents."""

    def __init__(self, node, angle, curved, surely, error):
        self.node, self.angle, self.curved = node, angle, curved
        bend = abs(angle - math.pi)
        self.nearly_smooth = bend < NEARLY and (not surely or bend > max(TANGENT, error))


def plane_normal(face):
    """Unit normal of a free face's plane (a cap's: of its circle), of either sign."""
    if face.kind == PLANAR and hasattr(face.surface, "Axis"):
        return face.surface.Axis
    if face.kind == PLANAR:
        return face.face.findPlane(1e-7).Axis
    return face.ring.Axis


def loop_points(face, n=24):
    """Points once around the loop."""
    out = []
    for edge, forward in face.loop:
        row = [edge.point(edge.first + (edge.last - edge.first) * i / n) for i in range(n)]
        if not forward:
            row = [edge.point(edge.last + (edge.first - edge.last) * i / n) for i in range(n)]
        out += row
    return out


def make_counterclockwise(face):
    """Turns the loop so that the face lies to its left, seen against plane_normal()."""
    normal, points = plane_normal(face), loop_points(face)
    base = points[0]
    area = sum((p - base).cross(q - base).dot(normal) for p, q in zip(points[1:], points[2:]))
    if area < 0.0:
        face.loop = [(edge, not forward) for edge, forward in reversed(face.loop)]


def _ends(arc):
    edge, i, forward = arc[:3]
    t = (edge.nodes[i][0], edge.nodes[i + 1][0])
    return t if forward else t[::-1]


def corners_of(face):
    """The loop's vertices with their interior angles, each at the begin of its arc."""
    normal, out = plane_normal(face), []
    arcs = arcs_of(face)
    round_off = ROUNDINGS * max(abs(c) for p in loop_points(face) for c in p)
    for before, after in zip(arcs[-1:] + arcs[:-1], arcs):
        come = _tangent(before[0], _ends(before)[1]) * (1.0 if before[2] else -1.0)
        go = _tangent(after[0], _ends(after)[0]) * (1.0 if after[2] else -1.0)
        bend = math.atan2(come.cross(go).dot(normal), come.dot(go))
        curved = any(turning(e, e.first, e.last)[-1] > CURVED for e in (before[0], after[0]))
        inside = before[0] is after[0] and _ends(before)[1] == _ends(after)[0]
        surely = inside or (before[0] is after[0] and _is_arc(before[0]))
        leg = min(_leg(before), _leg(after))
        out.append(Corner(after[3], math.pi - bend, curved, surely, round_off / leg))
    return out


def _leg(arc):
    """How far an arc gets from its begin: no less than its first control point."""
    a, b = _ends(arc)
    start = arc[0].point(a)
    return max((arc[0].point(a + (b - a) * t) - start).Length for t in (0.25, 0.5, 0.75, 1.0))


def _tangent(edge, t):
    """Unit tangent of an edge as a free face gets it: at its ends that of the border of the rigid
    face on the other side, which may leave the edge's own curve within the tolerance."""
    d = edge.tangent(t)
    if t in (edge.first, edge.last):
        for face, k in edge.uses:
            if face.kind == RIGID:
                own = face.border_tangent(k, edge, t)
                return own * (1.0 if own.dot(d) > 0.0 else -1.0)
    return d


def _is_arc(edge):
    """Do all rigid faces that run along this edge turn around there?"""
    return all(is_trig(face.surface, k % 2) for face, k in edge.uses if face.kind == RIGID)


# ---- adding corners ------------------------------------------------------------------------------


def _is_corner(uses, cell, corner):
    """Can this vertex be a corner of the free cell, as the other cells are now?"""
    if corner.angle >= math.pi - FLAT and not corner.curved:
        return False
    if corner.angle > math.pi + FLAT:
        return False
    if corner.nearly_smooth:
        return False
    others = [kind for c, kind in uses[corner.node.number] if c != cell]
    return 2 not in others and len(others) >= 2


def _stretches(face, corners, chosen):
    """The loop cut at the chosen vertices: lists of arcs."""
    arcs = arcs_of(face)
    if not chosen:
        return [arcs]
    start = next(i for i, c in enumerate(corners) if c.node in chosen)
    out = []
    for arc in arcs[start:] + arcs[:start]:
        if arc[3] in chosen:
            out.append([])
        out[-1].append(arc)
    return out


def _can_be_cut(arc, face):
    return any(other is not face and other.kind == RIGID for other, _ in arc[0].uses)


def _runs(stretch, face, closed):
    """The parts of a stretch where rigid neighbours can be cut."""
    able = [_can_be_cut(arc, face) for arc in stretch]
    if closed and not all(able):  # begin behind an arc that cannot
        k = able.index(False) + 1
        stretch, able = stretch[k:] + stretch[:k], able[k:] + able[:k]
    out = [[]]
    for arc, can in zip(stretch, able):
        if can:
            out[-1].append(arc)
        else:
            out.append([])
    return [run for run in out if run]


def _turning_of(stretch):
    return sum(turning(arc[0], *sorted(_ends(arc)))[-1] for arc in stretch)


def _places(stretch, count):
    """Edge and parameter of `count` points that part a stretch's turning into equal pieces."""
    profile, total = [], 0.0  # (turning so far, edge, t)
    for arc in stretch:
        a, b = _ends(arc)
        sums = turning(arc[0], a, b)
        profile += [(total + s, arc[0], a + (b - a) * i / N_TURN) for i, s in enumerate(sums)]
        total += sums[-1]
    out = []
    for k in range(1, count + 1):
        want = total * k / (count + 1.0)
        i = next(i for i, p in enumerate(profile) if p[0] >= want - 1e-9 * total)
        (s1, edge, t1) = profile[i]
        t = t1
        if abs(s1 - want) > 1e-9 * total and i > 0 and profile[i - 1][1] is edge:
            s0, _, t0 = profile[i - 1]
            t = _turned_by(edge, t0, t1, want - s0)
        out.append((edge, t))
    return out


def _turned_by(edge, a, b, angle):
    """Where between two parameters the tangent has turned by an angle since the first."""
    start, ends = edge.tangent(a), (a, b)
    for _ in range(60):
        t = 0.5 * (ends[0] + ends[1])
        if t in ends:
            break
        d = edge.tangent(t)
        before = math.atan2(start.cross(d).Length, start.dot(d)) < angle
        ends = (t, ends[1]) if before else (ends[0], t)
    return 0.5 * (ends[0] + ends[1])


def add_corners(shell, face):
    """Gives a free face the corners that it lacks, where a rigid neighbour can be cut."""
    cells = cells_of(shell)
    cell = next(i for i, c in enumerate(cells) if c.face is face)
    at, corners = uses(cells), corners_of(face)
    chosen = [c.node for c in corners if _is_corner(at, cell, c)]
    lacking = 4 - len(chosen)
    if lacking <= 0:
        return
    stretches = [run for s in _stretches(face, corners, chosen)
                 for run in _runs(s, face, not chosen)]
    stretches = [(s, _turning_of(s)) for s in stretches]
    stretches = [(s, angle) for s, angle in stretches if angle > CURVED]
    if not stretches:
        return
    counts = _share([angle for _, angle in stretches], lacking)
    closed = not chosen and len(stretches[0][0]) == len(corners)
    for (stretch, _), count in zip(stretches, counts):
        places = _places(stretch, count)
        if closed:  # no vertex to start from: as far as can be from the one that is none
            places = _places(stretch, 2 * count - 1)[::2]
        for edge, t in places:
            cut_from(shell, edge, t)


def complete(shell):
    """Adds corners to all free faces that lack them, in the order of the faces."""
    for face in shell.faces:
        if face.kind != RIGID:
            make_counterclockwise(face)
    intake_lenses.give_rims(shell)
    for face in shell.faces:
        if face.kind != RIGID and face.rim is None:
            add_corners(shell, face)


def _share(angles, n):
    """How many of n points each stretch gets, so that the largest angle left is small."""
    counts = [0] * len(angles)
    for _ in range(n):
        best = max(range(len(counts)), key=lambda i: (angles[i] / (counts[i] + 1), -i))
        counts[best] += 1
    return counts


# ---- where arcs end ----------------------------------------------------------------------------


def spread_breaks(shell):
    """breaks[face][axis]: parameters at which arcs have to end so that neighbours agree.

    A rational arc is parameterised by its own ends, so two faces that share a circle must end
    their arcs in the same points; what ends on one border ends on the opposite one too.
    """
    breaks = {f.number: (set(), set()) for f in shell.faces if f.kind == RIGID}
    left = []
    for face in shell.faces:
        if face.kind == RIGID:
            for axis in (0, 1):
                left += [(face, axis, v) for k in (axis, axis + 2) for v, _ in face.stops(k)]
                left += [(face, axis, v) for v in face.cuts[axis]]
    while left:
        face, axis, value = left.pop()
        known = breaks[face.number][axis]
        if any(near(face, axis, value, x) for x in known):
            continue
        known.add(value)
        if not is_trig(face.surface, axis):
            continue
        for k in (axis, axis + 2):
            edge, t = edge_at(face, k, value)
            for other, k2 in edge.uses:
                if other.kind == RIGID and is_trig(other.surface, k2 % 2):
                    left.append((other, k2 % 2, other.parameter_on(k2, edge, t)))
    return breaks
