# SPDX-License-Identifier: LGPL-2.1-or-later
"""The six models: T-spline surfaces like a cube's, with about as many control points and Bezier
elements as the models of table 1 in Zhang, Wang, Hughes, Conformal solid T-spline construction from
boundary T-spline representations; those themselves are not published.

Each function returns a CubeMesh with its control points.
"""
from math import cos, pi, radians, sin

import numpy as np

from .cube_mesh import CubeMesh, side_axes
from .parts import blade_point
from .splines import interpolated_volume


# ---- smooth shapes: maps of space that fold nowhere ---------------------------------------------


def ball(unit):
    """From the cube to the unit ball's surface, with nearly equal angles between the lines."""
    q = np.tan((np.asarray(unit) - 0.5) * (pi / 2))
    return q / np.linalg.norm(q)


def bell(x):
    return np.exp(-x * x)


def ramp(x):
    """0 below, 1 above, smooth, never falling."""
    x = np.clip(x, 0.0, 1.0)
    return x * x * x * (10 + x * (6 * x - 15))


def stretched(point, root, towards, width, depth):
    """Pulls what lies beyond `root` out by the vector `towards`, in a tube of the width.

    det = 1 + |towards| * bell * ramp' > 0: no fold."""
    length = np.linalg.norm(towards)
    axis = np.asarray(towards) / length
    away = point - root
    height = away @ axis
    across = np.linalg.norm(away - height * axis)
    return point + np.asarray(towards) * bell(across / width) * ramp(height / depth)


def drawn_in(point, root, axis, width, share):
    """Brings what is near a line closer to it, so that more control points lie there."""
    axis = np.asarray(axis) / np.linalg.norm(axis)
    away = point - root
    across = away - (away @ axis) * axis
    return point - share * across * bell(np.linalg.norm(across) / width)


def swollen(point, centre, more, width):
    """Radii about the centre grow by the factor 1 + more * bell: rising for more < 2.2."""
    away = point - centre
    return centre + away * (1 + more * bell(np.linalg.norm(away) / width))


# ---- models -------------------------------------------------------------------------------------


def set_points(mesh, shape):
    """Control point = shape at the function's anchor: a little flatter than the shape."""
    mesh.points = np.array([shape(mesh.unit(mesh.anchor(k))) for k in range(len(mesh.vertices))])
    return mesh


def interpolate(mesh, shape):
    """The surface meets the shape at all anchors; for meshes without stars."""
    anchors = [mesh.anchor(k) for k in range(len(mesh.vertices))]
    places = []
    for vertex, anchor in zip(mesh.vertices, anchors):
        side = mesh.sides_at(vertex)[0]
        places.append((side,) + tuple(anchor[a] for a in side_axes(side)))
    values = np.array([shape(mesh.unit(a)) for a in anchors])
    mesh.points = np.linalg.solve(mesh.collocation(places), values)
    return mesh


def sharp(values):
    """Three lines at either end: the isolines across are sharp."""
    return [values[0]] + list(values) + [values[-1]]


# ---- bunny --------------------------------------------------------------------------------------


def turned(point, angle):
    """About the x axis."""
    x, y, z = point
    return np.array([x, y * cos(angle) - z * sin(angle), y * sin(angle) + z * cos(angle)])


def bunny_shape(unit):
    """The middle of the cube's top becomes the head, so that no star lies near the ears."""
    p = turned(ball(unit), radians(42))
    p = drawn_in(p, np.zeros(3), [0, -sin(radians(42)), cos(radians(42))], 0.75, 0.35)
    p = p * [0.95, 1.25, 0.9]
    p = stretched(p, np.array([0, -0.35, 0.3]), np.array([0.0, -0.5, 0.62]), 0.45, 0.6)
    p = swollen(p, np.array([0, -1.15, 1.0]), 1.3, 0.45)
    p = stretched(p, np.array([0, -1.4, 0.95]), np.array([0.0, -0.3, -0.1]), 0.35, 0.4)
    for s in (-1, 1):
        p = drawn_in(p, np.array([s * 0.30, -1.0, 1.4]), [s * 0.25, 0.35, 1], 0.28, 0.5)
    for s in (-1, 1):
        p = stretched(p, np.array([s * 0.26, -1.05, 1.3]), np.array([s * 0.3, 0.3, 1.1]),
                      0.17, 0.35)
    for s in (-1, 1):
        p = swollen(p, np.array([s * 0.5, -0.8, 2.2]), 1.5, 0.35)
    p = stretched(p, np.array([0, 0.95, -0.25]), np.array([0.0, 0.3, 0.1]), 0.25, 0.3)
    return 30.0 * p


def bunny():
    """A body with head, nose, two ears and a tail; smooth everywhere."""
    n = 12
    halves = [3.5, 4.5, 5.5, 6.5, 7.5, 8.5]
    ears = [[3.75, 4.25, 4.75, 7.25, 7.75, 8.25], [6.75, 7.25, 7.75, 8.25]]
    lines = [sorted(list(range(n + 1)) + halves + ears[0]),
             sorted(list(range(n + 1)) + halves + ears[1]), list(range(n + 2))]

    def present(axis, i, point):
        value = lines[axis][i]
        if value == int(value):
            return True
        if point[2] < n + 1:
            return False
        other = point[1 - axis]
        if value in halves:
            return (2 if axis == 0 else 3) < other < (10 if axis == 0 else 9)
        if axis == 0:
            return 6 < other < 9
        return 3.5 < other < 5 or 7 < other < 8.5

    return set_points(CubeMesh(lines, present), bunny_shape)


# ---- propeller blade ----------------------------------------------------------------------------


BLADE = ([i / 8 for i in range(9)], [i / 32 for i in (0, 2, 5, 10, 16, 22, 27, 30, 32)],
         [i / 4 for i in range(5)])


def blade_nurbs():
    """A propeller blade as six NURBS patches; a list of patches, all of one volume."""
    knots = [tuple([row[0]] * 3 + row + [row[-1]] * 3) for row in BLADE]
    return interpolated_volume(blade_point, (3, 3, 3), knots).faces()


def blade_tspline():
    """The same blade, finer along the leading edge only: lines that end before root and tip."""
    lines = [sharp(row) for row in BLADE]
    extra = 1 / 32
    lines[1] = sorted(lines[1] + [extra])

    def present(axis, i, point):
        if axis != 1 or lines[1][i] != extra:
            return True
        return point[2] in (0.0, 1.0) and BLADE[0][1] < point[0] < BLADE[0][-2]

    return interpolate(CubeMesh(lines, present), lambda unit: blade_point(*unit))


# ---- boat ---------------------------------------------------------------------------------------


def boat_shape(unit):
    """A hull of 11 m with hard chines, raked stem and sheer: x to the bow, z from keel to deck."""
    x, y, z = unit
    side = 2 * y - 1
    fore = max(0.0, (x - 0.35) / 0.65)
    beam = 0.16 + 1.46 * (1 - fore ** 2.6) * (0.82 + 0.18 * ramp(x / 0.5))
    chine = beam * (0.74 - 0.12 * fore)
    deck = 1.35 + 0.75 * x ** 2.2 + 0.06 * (1 - side * side)
    keel = 0.25 * (1 - x) ** 2 + 0.5 * fore ** 3.2 + 0.30 * abs_smooth(side) * (1 - 0.4 * fore)
    flare = z + 0.25 * fore * z * (z - 1)
    half = chine + (beam - chine) * flare + 0.10 * beam * z * (1 - z)
    return [11 * x + 0.9 * x * x * z + 0.12 * (1 - x) * side * side, half * side,
            keel + (deck - keel) * z]


def abs_smooth(x):
    return np.sqrt(x * x + 0.04) - 0.2


def boat():
    """Sharp along all twelve isolines; more water lines at the bow."""
    extra = [0.5, 1.5, 2.5]
    lines = [sharp(range(21)), sharp(range(7)), sorted(sharp(range(4)) + extra)]

    def present(axis, i, point):
        return axis != 2 or lines[2][i] not in extra or point[0] > 13

    return interpolate(CubeMesh(lines, present), boat_shape)


# ---- mouse --------------------------------------------------------------------------------------


def mouse_shape(unit):
    """Half a ball over a plan with four corners, stretched to 115 x 65 x 38 mm."""
    x, y, z = 2 * unit[0] - 1, 2 * unit[1] - 1, unit[2]
    round_off = 0.55 + 0.45 * ramp(z)
    across = round_off / 2
    p = np.array([x * np.sqrt(1 - across * y * y - z * z / 2 + across * 2 / 3 * y * y * z * z),
                  y * np.sqrt(1 - across * x * x - z * z / 2 + across * 2 / 3 * x * x * z * z),
                  z * np.sqrt(1 - x * x / 2 - y * y / 2 + x * x * y * y / 3)])
    # a flat slope to the front (x high), a hump at the palm, a waist
    height = 1.0 + 0.30 * bell((p[0] + 0.35) / 0.6) - 0.25 * p[0]
    waist = 1 - 0.13 * bell((p[0] - 0.1) / 0.35)
    return np.array([57 * p[0], 34 * p[1] * waist, 34 * p[2] * height])


def mouse():
    """Smooth on top, sharp along the bottom; the sharp corners fade out upwards, at T-junctions."""
    lines = [sharp(range(8)), sharp(range(7)), [0.0] + list(range(5))]

    def present(axis, i, point):
        value = lines[axis][i]
        return axis == 2 or 0 < value < lines[axis][-1] or point[2] < 1

    return set_points(CubeMesh(lines, present), mouse_shape)


# ---- propeller shaft ----------------------------------------------------------------------------


# along the shaft: line, place, radius; sharp rings where a line is listed with True
PROFILE = [(2, 0.0, 1.0, False), (5, 2.6, 1.0, True), (6, 2.7, 1.75, True), (8, 3.5, 1.75, True),
           (9, 3.6, 1.05, True), (11, 5.2, 1.05, True), (12, 5.3, 2.1, True),
           (16, 8.3, 2.2, True), (17, 8.7, 1.4, True), (18, 9.5, 1.3, False)]
SPANS, AROUND = 20, 5


def shaft_shape(unit):
    t = SPANS * unit[0]
    at, place, radius, _ = zip(*PROFILE)
    if t < at[0]:
        half, end, grow = 0.5 * t / at[0], 0, 1.0
    elif t > at[-1]:
        half, end, grow = 0.5 + 0.5 * (t - at[-1]) / (SPANS - at[-1]), -1, 1.6
    else:
        half, end, grow = 0.5, None, 0.0
    p = ball([half, unit[1], unit[2]])
    if end is not None:
        return 10 * np.array([place[end] + grow * radius[end] * p[0], radius[end] * p[1],
                              radius[end] * p[2]])
    here, r = np.interp(t, at, place), np.interp(t, at, radius)
    return 10 * np.array([here, r * p[1], r * p[2]])


def shaft():
    """A shaft with flange, hub and nose: smooth but for eight sharp rings; finer on the hub."""
    rings = [at for at, _, _, is_sharp in PROFILE if is_sharp]
    extra = [i + 0.5 for i in range(1, AROUND - 1)]
    round_lines = sorted(list(range(AROUND + 1)) + extra)
    lines = [sorted(list(range(SPANS + 1)) + 2 * rings), round_lines, round_lines]

    def present(axis, i, point):
        return axis == 0 or lines[axis][i] not in extra or 12 < point[0] < 16

    return set_points(CubeMesh(lines, present), shaft_shape)


MODELS = {"mouse": mouse, "boat": boat, "blade_tspline": blade_tspline, "shaft": shaft,
          "bunny": bunny}

# How each is written: half-edges; T-spline patches where all twelve isolines are sharp; and Bezier
# elements for what is both.
CARRIERS = {"mouse": "elements", "boat": "patches", "blade_tspline": "patches", "shaft": "tsm",
            "bunny": "tsm"}


def file_of(name, carrier):
    return name + (".tsm" if carrier == "tsm" else ".tsb")
