# SPDX-License-Identifier: LGPL-2.1-or-later
"""The named example assemblies: each function returns the patches of its parts by their names.

Blocks are images of boxes under one wavy map, so that neighbours share their faces."""
from itertools import product
from math import cos, pi, radians, sin

import numpy as np

from .cube_mesh import CubeMesh
from .models import interpolate, sharp
from .splines import control_volume, interpolated_volume, uniform_knots

UNIT = 20.0  # mm: the edge of a block


def wavy(x, y, z, wave):
    return [UNIT * (x + wave * sin(2.1 * y + 0.9 * z)), UNIT * (y + wave * sin(1.7 * z + 1.3 * x)),
            UNIT * (z + wave * sin(1.9 * x + 1.1 * y))]


def block(low, high=None, degree=(3, 3, 3), spans=(2, 2, 2), wave=0.06):
    """The image of the box [low, high]; a unit cube if no high corner is given."""
    high = high or [x + 1 for x in low]

    def point(x, y, z):
        return wavy(*[a + u * (b - a) for a, b, u in zip(low, high, (x, y, z))], wave)

    knots = [uniform_knots(p, n) for p, n in zip(degree, spans)]
    return control_volume(point, degree, knots).faces()


def curved_block(low, high, degree=(3, 3, 3), spans=(1, 1, 1)):
    """The same under a map of quadratic polynomials: splines of any knots have it exactly, so that
    neighbours share their faces where only parts of them meet."""

    def point(u, v, w):
        x, y, z = (a + t * (b - a) for a, b, t in zip(low, high, (u, v, w)))
        return [UNIT * (x + 0.05 * y * (4 - y) + 0.03 * z * z),
                UNIT * (y + 0.04 * x * (x - 4) - 0.03 * x * z), UNIT * (z + 0.05 * x * y)]

    knots = [uniform_knots(p, n) for p, n in zip(degree, spans)]
    return interpolated_volume(point, degree, knots).faces()


def moved(patches, rotation=None, shift=(0, 0, 0)):
    out = []
    for patch in patches:
        patch = patch.copy()
        if rotation is not None:
            patch.points = patch.points @ np.asarray(rotation).T
        patch.points = patch.points + np.asarray(shift, dtype=float)
        out.append(patch)
    return out


def turned_about(patches, point, angle):
    """By an angle in degrees about the line through a point along z."""
    c, s = cos(radians(angle)), sin(radians(angle))
    back = moved(patches, shift=[-x for x in point])
    return moved(moved(back, rotation=[[c, -s, 0], [s, c, 0], [0, 0, 1]]), shift=point)


def pair():
    return {"left": block((0, 0, 0)), "right": block((1, 0, 0))}


def pair_refined():
    """The same face by other degrees and knots: planar and linear, so that both are exact."""
    return {"left": block((0, 0, 0), wave=0),
            "right": block((1, 0, 0), None, (3, 2, 1), (2, 3, 1), wave=0)}


def pair_apart(gap):
    return {"left": block((0, 0, 0), wave=0),
            "right": moved(block((1, 0, 0), wave=0), shift=(gap, 0, 0))}


def pair_overlapping():
    return {"left": block((0, 0, 0)), "right": moved(block((1, 0, 0)), shift=(-4.0, 1.0, 2.0))}


def pair_rotated():
    return {"left": block((0, 0, 0), wave=0),
            "right": turned_about(block((1, 0, 0), wave=0), (UNIT, 0, 0), -0.1)}


def ring():
    """Four bars round a square hole, each with its end on the next one's side."""
    at = {"south": ((0, 0, 0), (3, 1, 1)), "east": ((3, 0, 0), (4, 3, 1)),
          "north": ((1, 3, 0), (4, 4, 1)), "west": ((0, 1, 0), (1, 4, 1))}
    return {name: curved_block(low, high) for name, (low, high) in at.items()}


def tee():
    at = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0), (4, 0, 0), (2, 1, 0), (2, 2, 0)]
    return {"block%d" % k: block(low, spans=(1, 1, 1)) for k, low in enumerate(at)}


def bridge():
    """A deck whose underside, one face, stands on the ground at both ends: one pair of faces that
    touch in two places."""
    def deck(u, v, w):
        lift = 0.6 * sin(pi * (u - 0.3) / 0.4) if 0.3 < u < 0.7 else 0.0
        return [UNIT * (4 * u), UNIT * v, UNIT * (w + (1 - w) * lift)]

    knots = [uniform_knots(p, n) for p, n in zip((2, 1, 2), (10, 1, 1))]
    return {"ground": block((-1, -1, -1), (5, 2, 0), wave=0),
            "deck": control_volume(deck, (2, 1, 2), knots).faces()}


def array():
    """A hundred placed copies of one part: a block whose opposite faces fit each other."""
    def tile(u, v, w):
        return [UNIT * (u + 0.06 * sin(2 * pi * v)), UNIT * (v + 0.05 * sin(2 * pi * u)),
                UNIT * (w + 0.1 * u * (1 - u) * v * (1 - v))]

    knots = [uniform_knots(p, n) for p, n in zip((3, 3, 2), (4, 4, 1))]
    part = control_volume(tile, (3, 3, 2), knots).faces()
    return {"copy%d%d" % (i, j): moved(part, shift=(UNIT * i, UNIT * j, 0))
            for i, j in product(range(10), repeat=2)}


def wall():
    """Bricks 4 x 3 x 3, every second course shifted by half a brick: contacts on parts of faces."""
    return {"brick%d%d%d" % (i, j, k): curved_block((i + 0.5 * (k % 2), j, k),
                                                    (i + 0.5 * (k % 2) + 1, j + 1, k + 1),
                                                    (2, 2, 2))
            for k, j, i in product(range(3), range(3), range(4))}


# ---- propeller ----------------------------------------------------------------------------------
# Polynomials of at most the third degree in each variable: the blade's root is a rectangle of the
# shaft's surface, exactly.

ROOT = (1 / 4, 1 / 4)  # half the blade's root, as parts of the shaft's half length and half width


def shaft_surface(x, b, c):
    """x, b, c in [-1, 1]: along the shaft and across; thicker in the middle, where the hub is."""
    swell = 1 + 0.35 * (1 - x * x)
    return [80 * x, 22 * b * (1 + 0.15 * (1 - c * c)) * swell,
            22 * c * (1 + 0.15 * (1 - b * b)) * swell]


def blade_shape(u, v, w):
    """From the root (u = 0) outward; v along the chord, w through the thickness. The chord turns
    from along the shaft to across it, and the blade is swept back and thinned."""
    x, b = ROOT[0] * (2 * v - 1), ROOT[1] * (2 * w - 1)
    point = shaft_surface(x, b, 1)
    along, through = 2 * v - 1, 2 * w - 1
    return [point[0] + u * (12 * along - 14 * u), point[1] + u * (34 * along - 5 * through),
            point[2] + u * (100 - 8 * along * along)]


def propeller():
    """A shaft with a hub and two blades, which sit on rectangles of its sides."""
    def shaft_point(u, v, w):
        return shaft_surface(2 * u - 1, 2 * v - 1, 2 * w - 1)

    cubic = (3, 3, 3)
    shaft = interpolated_volume(shaft_point, cubic, [uniform_knots(3, n) for n in (4, 1, 1)])
    blade = interpolated_volume(blade_shape, cubic, [uniform_knots(3, n) for n in (2, 3, 1)])
    half_turn = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
    return {"shaft": shaft.faces(), "blade1": blade.faces(),
            "blade2": moved(blade.faces(), rotation=half_turn)}


def propeller_tspline():
    """The same with one blade as a T-spline: finer along its leading edge, not at root and tip."""
    lines = [[0, 1 / 4, 1 / 2, 3 / 4, 1], [0, 1 / 4, 1 / 2, 3 / 4, 7 / 8, 1], [0, 1 / 2, 1]]

    def present(axis, i, point):
        return axis != 1 or lines[1][i - 1] != 7 / 8 or 1 / 4 < point[0] < 3 / 4

    mesh = CubeMesh([sharp(row) for row in lines], present)
    return dict(propeller(), blade2=interpolate(
        mesh, lambda unit: [s * x for s, x in zip((1, -1, -1), blade_shape(*unit))]))


ASSEMBLIES = {
    "propeller_tspline": propeller_tspline,
    "propeller": propeller,
    "pair": pair,
    "pair_refined": pair_refined,
    "pair_gap_1e-6": lambda: pair_apart(1e-6),
    "pair_gap_1e-3": lambda: pair_apart(1e-3),
    "pair_gap_0.1": lambda: pair_apart(0.1),
    "pair_gap_1": lambda: pair_apart(1.0),
    "pair_overlapping": pair_overlapping,
    "pair_rotated": pair_rotated,
    "ring": ring,
    "tee": tee,
    "wall": wall,
    "bridge": bridge,
    "array": array,
}
