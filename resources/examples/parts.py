# SPDX-License-Identifier: LGPL-2.1-or-later
"""The named example parts: each function returns the NURBS patches of one part, in mm."""
from math import atan, cos, pi, radians, sin, sqrt

import numpy as np

from .splines import (Patch, Volume, clamped_knots, insert_patch_knots, interpolated_volume,
                      raise_patch, split_faces, uniform_knots)


def box():
    """60 x 40 x 30, bilinear faces."""
    knots = [uniform_knots(1, 1)] * 3
    control = [[[[60.0 * x, 40.0 * y, 30.0 * z] for z in (0, 1)] for y in (0, 1)] for x in (0, 1)]
    return Volume((1, 1, 1), knots, control).faces()


def twisted_bar():
    """A bar of 24 x 16 x 120 whose section turns by a quarter over the length."""

    def point(x, y, z):
        a, b, turn = 24 * (x - 0.5), 16 * (y - 0.5), 0.5 * pi * z
        return [a * cos(turn) - b * sin(turn), a * sin(turn) + b * cos(turn), 120 * z]

    degree = (1, 1, 3)
    return interpolated_volume(point, degree, [uniform_knots(p, n)
                                               for p, n in zip(degree, (1, 1, 5))]).faces()


def blade_point(x, y, z):
    """A point of a ship propeller's blade, 300 mm in diameter: radius, chord, thickness are the
    axes.

    Sections with parabolic camber and a thickness that stays finite at both edges are wrapped on
    cylinders at the pitch of their radius, with skew and rake."""
    tip_radius, root = 150.0, 0.25
    radius = tip_radius * (root + (0.95 - root) * x)
    f = radius / tip_radius
    chord = 95 * sqrt(1.0 - 0.75 * f ** 4) * (0.55 + 0.9 * f - 0.35 * f * f)
    along = y - 0.5
    camber = 0.035 * chord * (1 - 4 * along * along)
    # thick in the middle, 1.6 mm at leading and trailing edge, thinner towards the tip
    thick = (17.0 - 12.5 * x) * (1 - 4 * along * along) ** 0.75 + 1.6
    normal = camber + thick * (z - 0.5)
    pitch_angle = atan(300.0 * (0.85 + 0.3 * f - 0.15 * f * f) / (2 * pi * radius))
    skew = radians(18.0) * x * x
    arc = chord * along * cos(pitch_angle) - normal * sin(pitch_angle)
    axial = chord * along * sin(pitch_angle) + normal * cos(pitch_angle) - 12.0 * x
    angle = arc / radius + skew
    return [axial, radius * sin(angle), radius * cos(angle)]


def propeller_blade():
    """The blade by linear patches across its thickness, cubic along it."""
    knots = [uniform_knots(3, 4), clamped_knots(3, [0.12, 0.3, 0.5, 0.7, 0.88]),
             uniform_knots(1, 1)]
    return interpolated_volume(blade_point, (3, 3, 1), knots).faces()


def wavy_cube(spans=6):
    """A 50 mm cube with waves of two periods on all faces; `spans` knot spans per direction."""

    def point(x, y, z):
        a, b, c = 2 * pi * x, 2 * pi * y, 2 * pi * z
        return [50 * x + 2.2 * sin(2 * b) * cos(c) + 1.2 * sin(c + 1),
                50 * y + 2.0 * sin(c + 0.5) * cos(a) + 1.4 * sin(2 * a),
                50 * z + 2.4 * cos(a) * sin(b + 0.3) + 1.0 * cos(2 * b)]

    return interpolated_volume(point, (3, 3, 3), [uniform_knots(3, spans)] * 3).faces()


def bulged_section(half, opening):
    """Homogeneous 3 x 3 net of a square bulged by four circular arcs of `opening` radians.

    The exact conic: the middle control point lies where the end tangents meet, with the weight
    cos(opening / 2)."""
    w = cos(opening / 2)
    reach = half * (1 + np.tan(opening / 2))
    net = np.zeros((3, 3, 3))  # x, y, weight
    for i, a in enumerate((-1, 0, 1)):
        for j, b in enumerate((-1, 0, 1)):
            weight = w ** ((a == 0) + (b == 0))
            x = a * (reach if b == 0 else half)
            y = b * (reach if a == 0 else half)
            net[i, j] = [x * weight, y * weight, weight]
    return net


def elbow():
    """A bend of 270 degrees at a radius of 60 with a bulged square section: exact arcs."""
    net = bulged_section(14.0, radians(45))
    control = np.zeros((7, 3, 3, 4))
    cosine = [1, 1, 0, -1, -1, -1, 0]
    sine = [0, 1, 1, 1, 0, -1, -1]
    for k in range(7):
        turn_weight = sqrt(0.5) if k % 2 else 1.0
        for i in range(3):
            for j in range(3):
                x, y, w = net[i, j]
                radius = 60.0 * w + x
                control[k, i, j] = [turn_weight * radius * cosine[k],
                                    turn_weight * radius * sine[k], turn_weight * y,
                                    turn_weight * w]
    turn = (0.0,) * 3 + (1 / 3,) * 2 + (2 / 3,) * 2 + (1.0,) * 3
    return Volume((2, 2, 2), (turn, uniform_knots(2, 1), uniform_knots(2, 1)), control).faces()


def thin_plate():
    """A curved panel of 200 x 150 x 2: thickness to length 1:100."""

    def point(x, y, z):
        a, b = 200 * (x - 0.5), 150 * (y - 0.5)
        height = 18 * (1 - (a / 100) ** 2) + 7 * (b / 75) ** 2 * (a / 100) + 4 * sin(pi * (x + y))
        slope_a = -18 * 2 * a / 1e4 + 7 * (b / 75) ** 2 / 100 + 4 * pi / 200 * cos(pi * (x + y))
        slope_b = 7 * 2 * b / 75 ** 2 * (a / 100) + 4 * pi / 150 * cos(pi * (x + y))
        normal = np.array([-slope_a, -slope_b, 1.0])
        offset = (2 * (z - 0.5)) * normal / np.linalg.norm(normal)
        return [a + offset[0], b + offset[1], height + offset[2]]

    knots = [uniform_knots(3, 5), uniform_knots(3, 4), uniform_knots(1, 1)]
    return interpolated_volume(point, (3, 3, 1), knots).faces()


def wedge():
    """A chisel of 70 x 40 with edges of 30 and 45 degrees and slightly hollow flanks."""
    bottom, top, height = (0.0, 70.0), (20.0, 70.0 - 20.0 * sqrt(3.0)), 20.0

    def point(x, y, z):
        low, high = (b + (t - b) * z for b, t in zip(bottom, top))
        hollow = 6 * z * (1 - z) * sin(pi * y)
        return [low + (high - low) * x + hollow * (0.4 - x), 40 * y,
                height * z + 1.5 * x * (1 - x) * (2 * z - 1)]

    knots = [uniform_knots(2, 2), uniform_knots(3, 3), uniform_knots(2, 1)]
    return interpolated_volume(point, (2, 3, 2), knots).faces()


def product(a, b):
    """Bernstein coefficients of the product of two biquadratics given as 3 x 3 nets."""
    binomial2, binomial4 = (1, 2, 1), (1, 4, 6, 4, 1)
    out = np.zeros((5, 5))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                for m in range(3):
                    out[i + k, j + m] += (binomial2[i] * binomial2[j] * binomial2[k] * binomial2[m]
                                          * a[i, j] * b[k, m])
    return out / np.outer(binomial4, binomial4)


def sphere_cap():
    """A rational biquartic patch on the unit sphere, over the cube's face z = 1.

    Seen from the south pole the four great circles through the face's corners become circles
    around (-1, 0) and its like, radius sqrt 2; between the corners they turn by 30 degrees. A
    biquadratic rational patch (X : Y : W) fills the region between those arcs, and the inverse
    projection (2XW, 2YW, W^2 - X^2 - Y^2) / (W^2 + X^2 + Y^2) lifts it to the sphere."""
    corner, w = 1 / (sqrt(3.0) + 1), cos(radians(15))
    middle = 2 * sqrt(3.0) - 3
    x, weight = np.zeros((3, 3)), np.zeros((3, 3))
    for i, a in enumerate((-1, 0, 1)):
        for j, b in enumerate((-1, 0, 1)):
            weight[i, j] = w ** ((a == 0) + (b == 0))
            x[i, j] = a * weight[i, j] * (middle if b == 0 else corner)
    y = x.T
    squares = product(x, x) + product(y, y)
    net = np.stack([2 * product(x, weight), 2 * product(y, weight),
                    product(weight, weight) - squares, product(weight, weight) + squares], axis=2)
    # the same symmetries in floating point as on paper: so the rotated patches share their rows
    net = symmetric_cap(net)
    net[..., :3] /= net[..., 3:]
    edge = 0.5 * (net[-1, :, 0] + net[-1, :, 2])
    net[-1, :, 0] = net[-1, :, 2] = net[:, -1, 1] = net[:, -1, 2] = edge
    net[0, :, 0] = net[:, 0, 1] = -edge
    net[0, :, 2] = net[:, 0, 2] = edge
    for i in (0, -1):
        for j in (0, -1):
            net[i, j, :3] = [-edge[0] if i == 0 else edge[0], -edge[0] if j == 0 else edge[0],
                             edge[0]]
    return net


def symmetric_cap(net):
    """The mean over the eight symmetries of the square."""
    total = np.zeros_like(net)
    for flip_x in (1, -1):
        for flip_y in (1, -1):
            image = net[::flip_x, ::flip_y] * np.array([flip_x, flip_y, 1, 1])
            total += image + image.transpose(1, 0, 2)[..., [1, 0, 2, 3]]
    return total / 8


def sphere():
    """A ball of radius 25: six rational biquartic patches that lie on the sphere exactly."""
    net = sphere_cap()
    knots = [uniform_knots(4, 1)] * 2
    patches = []
    for axis in range(3):
        for end in range(2):
            turned = [(axis + 1) % 3, (axis + 2) % 3, axis]
            points = np.zeros((5, 5, 3))
            for k, target in enumerate(turned):
                points[..., target] = 25.0 * net[..., k] * (-1 if k == 2 and not end else 1)
            patches.append(Patch((4, 4), knots, points, net[..., 3],
                                 "Face%d" % (1 + 2 * axis + end)))
    return patches


def mixed_sides():
    """A block whose opposite sides differ in degrees and knots; its edges are the same curves.

    Every side starts from one block with edges of degree two, is refined exactly, each in its own
    way, and then gets a shape of its own inside."""

    def point(x, y, z):
        return [55 * x + 5 * y * (1 - y) + 4 * z, 45 * y + 6 * x * (1 - x) - 3 * z * (1 - z),
                40 * z + 5 * x * (1 - x) + 4 * y]

    faces = interpolated_volume(point, (2, 2, 2), [uniform_knots(2, 1)] * 3).faces()
    ways = [([3, 0], [(0.5,), ()]), ([0, 1], [(0.25, 0.7), (0.5, 0.5)]), ([1, 1], [(), (0.4,)]),
            ([0, 2], [(0.3, 0.6, 0.8), ()]), ([2, 0], [(), (0.2, 0.5)]), ([1, 4], [(0.5,), ()])]
    out = []
    for face, (raises, inserts), bump in zip(faces, ways, (2.5, -2.0, 3.0, -2.5, 2.0, -3.0)):
        for direction in range(2):
            if inserts[direction]:
                face = insert_patch_knots(face, direction, inserts[direction])
            if raises[direction]:
                face = raise_patch(face, direction, raises[direction])
        normal = np.cross(face.points[-1, 0] - face.points[0, 0],
                          face.points[0, -1] - face.points[0, 0])
        face.points[1:-1, 1:-1] += bump * normal / np.linalg.norm(normal)
        out.append(face)
    return out


def grid24():
    """A smooth block of 24 patches, 2 x 2 on each side, cut at different parameters per axis."""

    def point(x, y, z):
        turn = 0.5 * (z - 0.5)
        a = 60 * (x - 0.5) * (1 - 0.2 * z) + 4 * sin(pi * y)
        b = 50 * (y - 0.5) * (1 - 0.15 * z) + 3 * sin(pi * x) * z
        return [a * cos(turn) - b * sin(turn), a * sin(turn) + b * cos(turn),
                45 * z + 5 * cos(pi * x) * sin(pi * y)]

    volume = interpolated_volume(point, (3, 3, 3), [uniform_knots(3, 2), uniform_knots(3, 3),
                                                    uniform_knots(3, 2)])
    return split_faces(volume, (0.5, 0.4, 0.625))


def round_bar():
    """A bar of 20 x 60 with a round section: at the corners of its ends the sides are tangent.

    No solid has det J > 0 there; so it is not among the parts that everything is asked of."""
    net = bulged_section(10 * sqrt(0.5), radians(90))
    knots = (uniform_knots(2, 1), uniform_knots(2, 1), uniform_knots(3, 1))
    control = [[[[x, y, 60 * r * w, w] for r in (0, 1 / 3, 2 / 3, 1)] for x, y, w in row]
               for row in net.tolist()]
    return Volume((2, 2, 3), knots, control).faces()


PARTS = {"box": box, "twisted_bar": twisted_bar, "propeller_blade": propeller_blade,
         "wavy_cube": wavy_cube, "elbow": elbow, "thin_plate": thin_plate, "wedge": wedge,
         "sphere": sphere, "mixed_sides": mixed_sides, "grid24": grid24}
