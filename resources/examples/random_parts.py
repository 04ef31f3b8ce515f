# SPDX-License-Identifier: LGPL-2.1-or-later
"""Random parts from a seed: every one is the boundary of a map of the cube that is one to one.

Sizes, degrees 1 to 9, knots, weights and shape are drawn; the shape is then weakened until the
map's hexahedra are well away from folding, so that a good solid exists.
"""
import random
from math import cos, exp, pi, sin

import numpy as np

from .splines import (clamped_knots, control_volume, insert_patch_knots, raise_patch,
                      smallest_scaled_jacobian)

DEFAULT_SEED = "tsolid-1"


def random_knots(draw, degree):
    """Clamped, up to four inner values, multiplicities up to the degree."""
    budget = draw.randint(0, 4 if degree < 5 else 2)
    inner = []
    for _ in range(budget):
        value = round(draw.uniform(0.08, 0.92), draw.choice((1, 2, 6)))
        if all(abs(value - k) > 0.04 for k in inner):
            repeat = 1 if draw.random() < 0.7 else draw.randint(1, degree)
            inner += [value] * repeat
    return clamped_knots(degree, sorted(inner))


def random_degree(draw):
    return draw.choice((1, 2, 2, 3, 3, 3, 4, 4, 5, 6, 7, 8, 9))


class Shape:
    """A smooth map of the unit cube: waves, taper, twist and bend of a box, all times strength."""

    def __init__(self, draw):
        longest = 10 ** draw.uniform(1.3, 2.3)
        self.size = [longest * draw.choice((1.0, draw.uniform(0.1, 1.0))) for _ in range(3)]
        self.waves = [(axis, draw.uniform(-0.16, 0.16), [draw.uniform(-1.4, 1.4) for _ in range(3)],
                       draw.uniform(0, 2 * pi)) for axis in range(3) for _ in range(2)]
        self.taper = draw.uniform(-0.6, 0.6)
        self.twist = draw.uniform(-1.2, 1.2)
        self.bend = draw.choice((0.0, draw.uniform(-2.0, 2.0)))
        self.weight_waves = [(draw.uniform(-0.5, 0.5), [draw.uniform(-2, 2) for _ in range(3)])
                             for _ in range(2)]

    def point(self, strength, x, y, z):
        p = [x - 0.5, y - 0.5, z - 0.5]
        unit = list(p)
        for axis, height, direction, phase in self.waves:
            unit[axis] += strength * height * sin(
                pi * sum(d * c for d, c in zip(direction, p)) + phase)
        a, b, c = (s * u for s, u in zip(self.size, unit))
        shrink = 1 + strength * self.taper * p[2]
        turn = strength * self.twist * p[2]
        a, b = (shrink * (a * cos(turn) - b * sin(turn)), shrink * (a * sin(turn) + b * cos(turn)))
        angle = strength * self.bend
        if abs(angle) > 1e-3:  # the z axis becomes an arc in the x, z plane
            radius = self.size[2] / angle
            a, c = radius - (radius - a) * cos(c / radius), (radius - a) * sin(c / radius)
        return [a, b, c]

    def weight(self, x, y, z):
        return exp(sum(h * sin(d[0] * x + d[1] * y + d[2] * z) for h, d in self.weight_waves))


def refine_some_faces(draw, faces, strength):
    """Gives some faces degrees, knots and inner shape of their own; their edges stay."""
    for index, face in enumerate(faces):
        if draw.random() < 0.6:
            direction = draw.randint(0, 1)
            if draw.random() < 0.5 and face.degree[direction] < 9:
                most = min(2, 9 - face.degree[direction])
                face = raise_patch(face, direction, draw.randint(1, most))
            else:
                face = insert_patch_knots(face, direction, [round(draw.uniform(0.1, 0.9), 3)])
            along = (face.points[-1, 0] - face.points[0, 0], face.points[0, -1] - face.points[0, 0])
            normal = np.cross(*along)
            height = 0.12 * min(np.linalg.norm(a) for a in along) * draw.uniform(-1, 1)
            face.points[1:-1, 1:-1] += strength * height * normal / np.linalg.norm(normal)
        faces[index] = face
    return faces


def solid_grid(volume, faces, count=17):
    """Points of a solid over `faces`: the volume, blended into the faces that were changed."""
    g = np.linspace(0, 1, count)
    grid = volume.evaluate(g, g, g)
    fade = [(1 - g) ** 2, g ** 2]
    u, v = (a.ravel() for a in np.meshgrid(g, g, indexing="ij"))
    for index, face in enumerate(faces):
        axis, end = divmod(index, 2)
        surface = face.evaluate(u, v).reshape(count, count, 3)
        change = surface - np.take(grid, -1 if end else 0, axis=axis)
        shape = [1, 1, 1, 1]
        shape[axis] = count
        grid = grid + np.expand_dims(change, axis) * fade[end].reshape(shape)
    return grid


def random_part(seed, index):
    """Part `index` of a seed: the patches of a solid whose hexahedra keep a drawn quality."""
    draw = random.Random("%s/%d" % (seed, index))
    shape = Shape(draw)
    degree = [random_degree(draw) for _ in range(3)]
    knots = [random_knots(draw, p) for p in degree]
    rational, own = draw.random() < 0.5, draw.random() < 0.4
    wanted = draw.choice((0.2, 0.35, 0.5))
    detail, strength = draw.getrandbits(64), 1.0
    while True:
        volume = control_volume(lambda x, y, z: shape.point(strength, x, y, z), degree, knots,
                                shape.weight if rational else None)
        faces = volume.faces()
        if own:
            faces = refine_some_faces(random.Random(detail), faces, strength)
        if smallest_scaled_jacobian(solid_grid(volume, faces)) >= wanted:
            return faces
        strength *= 0.85
