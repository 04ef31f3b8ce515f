# SPDX-License-Identifier: LGPL-2.1-or-later
"""From a shell with its corners chosen to named patches: the last step of the intake.

    shape -> Shell (intake_shell) -> missing corners (intake_cuts) -> cells (intake_cells)
          -> corners of free faces (intake_corners) -> nets (intake_fill, intake_caps) -> patches
"""

import collections
import random

import FreeCAD

from . import coons, intake_caps, intake_corners, intake_cuts, intake_fill, intake_lenses
from .binding import Refused
from .header import Status
from .intake_cells import cells_of
from .intake_exact import is_clamped
from .intake_refuse import error, note, refuse
from .intake_shell import CAP, PLANAR, RIGID, TOLERANCE, Shell
from .nurbs import net_of_patch
from .occ_spline import surface_of_net


N_SAMPLES = 1000
SEED = 20120713

Taken = collections.namedtuple("Taken", "shell patches owners deviations findings followers")
Taken.__doc__ = """patches[i] is part of shell.faces[owners[i]], deviations[k] how far the patches
of face k are from its surface as read; followers: numbers of faces with others' parameters."""


# ---- names -----------------------------------------------------------------------------------


def _names(shell, cell):
    edges = {e.number: e for e in shell.edges}
    borders, tolerances = [], []
    for side in cell.sides:
        own = []
        for arc in side:
            if isinstance(arc.key[0], int) and edges[arc.key[0]] not in own:
                own.append(edges[arc.key[0]])
        borders.append(", ".join(e.name for e in own))
        tolerances.append(max([TOLERANCE] + [e.tolerance for e in own]))
    return {
        "name": cell.face.name,
        "border_names": borders,
        "corner_names": [n.name for n in cell.corners],
        "border_tolerance": tolerances,
    }


# ---- free cells ------------------------------------------------------------------------------


def _curve(row):
    weights = [p[3] for p in row.points]
    points = [[c / p[3] for c in p[:3]] for p in row.points]
    if all(w == weights[0] for w in weights):
        weights = None
    return coons.Curve(row.degree, row.knots, points, weights)


def _planar_patch(context, rows, face, corners):
    """The rows' patch in their plane, and the report of how it was made."""
    names = [n.name for n in corners]
    curves = [_curve(row) for row in rows]
    tolerance = max([TOLERANCE] + [e.tolerance for e, _ in face.loop])
    made = coons.patch(context, curves, tolerance=tolerance, name=face.name, corner_names=names)
    return made


def _free_patch(context, filler, cell, positions):
    cell.sides = filler.free_sides(cell, positions)
    cap = cell.face.kind == CAP
    rows = filler.free_rows(cell, plain=cap)
    patch, report = _planar_patch(context, rows, cell.face, cell.corners)
    if cap:
        patch = intake_caps.lifted(cell.face, net_of_patch(patch)).patch()
    return patch, report


def _five_patches(context, cells):
    rows = [cell.face.rim.row(*cell.corners[3:1:-1]) for cell in cells[:4]]
    ring, inner = intake_caps.five_nets(cells[0].face, rows)
    around = [inner[0], inner[1], inner[2].reversed(), inner[3].reversed()]
    square, report = _planar_patch(context, around, cells[0].face, cells[4].corners)
    nets = ring + [intake_caps.lifted(cells[0].face, net_of_patch(square))]
    return [net.patch() for net in nets], report


# ---- all -------------------------------------------------------------------------------------


def distance_from_surface(surface, net, equal=None):
    """Largest distance of a net from a surface, at N_SAMPLES points: at equal parameters, or from
    the foot. As default splines at equal ones (a projection on one of high degree takes long)."""
    if equal is None:
        equal = type(surface).__name__ == "BSplineSurface"
    numbers = random.Random(SEED)
    u0, u1, v0, v1 = net.box
    own, worst = surface_of_net(net), 0.0
    for _ in range(N_SAMPLES):
        place = numbers.uniform(u0, u1), numbers.uniform(v0, v1)
        point = own.value(*place)
        foot = place if equal else surface.parameter(point)
        worst = max(worst, (surface.value(*foot) - point).Length)
    return worst


def _deviation(face, filler):
    """How far a face's net, or the sphere that it is taken for, is from the surface as read."""
    if face.kind == CAP:
        return face.ball.deviation
    if face.kind != RIGID:
        return 0.0  # planar faces are measured when they are filled
    if face.number in filler.leaders:
        return _from_foot(face, filler.faces[face.number])
    if face.type == "BSplineSurface" and is_clamped(face.surface):
        return 0.0
    return distance_from_surface(face.surface, filler.faces[face.number])


def _from_foot(face, net):
    return distance_from_surface(face.surface, net, equal=False)


def _from_plane(face, patch):
    """How far a planar face's patch leaves its plane, as its neighbours' borders do that it has
    taken over: the control points bound it."""
    plane = face.face.findPlane(TOLERANCE)
    if plane is None:  # off by more, but within the edges' tolerance
        return _from_foot(face, net_of_patch(patch))
    away = (FreeCAD.Vector(*p) - plane.Position for p in patch.points)
    return max(abs(x.dot(plane.Axis)) for x in away)


def _renamed(patch, names):
    patch.name = names["name"]
    for key in ("border_names", "corner_names", "border_tolerance"):
        setattr(patch, key, tuple(names[key]))
    return patch


def _given_nodes(shell, names):
    by_name = {n.name: n for n in shell.nodes if n.name}
    unknown = [x for x in names if x not in by_name]
    if unknown:
        refuse(", ".join(unknown), "the part has no such vertex")
    return [by_name[x] for x in names]


def take(shape, context, corners=(), tell=None):
    """The shape's faces as patches; raises Refused."""
    shell = Shell(shape, tell)
    problems = [
        error("%s, %s" % (f.name, where) if where else f.name, text, point=point)
        for f in shell.faces
        for where, text, point in f.problems
    ]
    if problems:
        raise Refused(Status.ERROR_REFUSED, problems)
    intake_cuts.complete(shell)
    cells = intake_lenses.split(shell, cells_of(shell))
    findings, positions = _choose(shell, cells, corners)
    filler = intake_fill.Filler(shell, cells, _from_foot)
    deviations = [_deviation(face, filler) for face in shell.faces]
    off = [
        error(face.name, "%s has no exact B-spline form: re-writing it changes it" % face.type,
              measured=far, allowed=TOLERANCE)
        for face, far in zip(shell.faces, deviations)
        if not far <= TOLERANCE
    ]
    if off:
        raise Refused(Status.ERROR_REFUSED, off)
    patches, owners = _fill(shell, cells, positions, filler, context, findings)
    for k, patch in zip(owners, patches):
        if shell.faces[k].kind == PLANAR:
            deviations[k] = _from_plane(shell.faces[k], patch)
    findings += [_follows(shell, n, names) for n, names in sorted(filler.leaders.items())]
    return Taken(shell, patches, owners, deviations, findings, set(filler.leaders))


def _follows(shell, number, names):
    text = "takes over the parameters of %s, which are others on the edges that they share"
    return note(shell.faces[number - 1].name, text % ", ".join(names))


def _choose(shell, cells, corners):
    """Corners of the free cells, and what there is to say about the choice."""
    try:
        found, complete = intake_corners.choices(cells, _given_nodes(shell, corners))
    except intake_corners.NoCube as reason:
        refuse(*reason.args)
    if not found:
        return [], {}
    best, findings = found[0], []
    if len(found) > 1 or not complete:
        names = ", ".join(map(repr, best.corners))
        more = "" if complete else "at least "
        text = "the part has %s%d possible cubes; taken: %s" % (more, len(found), names)
        findings.append(note("", text))
    return findings, best.positions


def _fill(shell, cells, positions, filler, context, findings):
    patches, owners = [], []
    five = collections.defaultdict(list)
    for index, cell in enumerate(cells):
        face = cell.face
        if face.kind == RIGID:
            made = [filler.rigid_net(cell).patch()]
        elif index in positions:
            patch, report = _free_patch(context, filler, cell, positions[index])
            made = [patch]
            findings += _of_report(face, report)
        else:
            five[face.number].append(cell)
            if len(five[face.number]) < 5:
                continue
            made, _ = _five_patches(context, five[face.number])
            for own, patch in zip(five[face.number], made):
                _renamed(patch, _names(shell, own))
        if len(made) == 1:
            _renamed(made[0], _names(shell, cell))
        patches += made
        owners += [face.number - 1] * len(made)
    return patches, owners


def _of_report(face, report):
    if face.kind == PLANAR and report["repaired"]:
        return [note(face.name, "inner control points were set, in the plane, so that the face "
                                "does not fold")]
    return []
