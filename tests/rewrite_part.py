# SPDX-License-Identifier: LGPL-2.1-or-later
"""Ways to write the same part down differently.

Each returns a Rewritten: new patches and, for each, the old patch it shows and the parameters of
the old one that belong to the new one's. `motion` moves the old point to the new one.
"""
import os
import subprocess
import sys
from itertools import permutations, product

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "resources"))

from examples.splines import (Patch, insert_patch_knots, raise_patch, read_tsb,  # noqa: E402
                              write_tsb)


def keep(u, v):
    return u, v


class Rewritten:
    def __init__(self, patches, source=None, back=None, motion=None):
        self.patches = patches
        self.source = list(range(len(patches))) if source is None else source
        self.back = [keep] * len(patches) if back is None else back
        self.motion = motion or (np.eye(3), np.zeros(3))

    def largest_difference(self, originals, draw, count=50):
        """Over random parameters of all patches; NaN when anything is not a number."""
        worst = [0.0]
        for patch, source, back in zip(self.patches, self.source, self.back):
            (u0, u1), (v0, v1) = patch.domain()
            u = np.array([u0, u1] + [draw.uniform(u0, u1) for _ in range(count)])
            v = np.array([v1, v0] + [draw.uniform(v0, v1) for _ in range(count)])
            old = originals[source]
            bounds = old.domain()
            a, b = (np.clip(x, *limit) for x, limit in zip(back(u, v), bounds))
            expected = old.evaluate(a, b) @ self.motion[0].T + self.motion[1]
            worst.append(np.abs(patch.evaluate(u, v) - expected).max())
        return float(np.max(worst))


def reversed_knots(knots):
    """Run backwards over the same interval; exact where both ends are small binary numbers."""
    return tuple((knots[0] + knots[-1]) - k for k in reversed(knots))


def reoriented(patch, swap, flip):
    """Flips u, flips v, then exchanges them; and the way back of parameters."""
    points, weights, knots = patch.points, patch.weights, list(patch.knots)
    for direction in range(2):
        if flip[direction]:
            points = np.flip(points, direction)
            weights = None if weights is None else np.flip(weights, direction)
            knots[direction] = reversed_knots(knots[direction])
    degree, domain = patch.degree, patch.domain()
    if swap:
        points = points.transpose(1, 0, 2)
        weights = None if weights is None else weights.T
        knots, degree = knots[::-1], degree[::-1]

    def back(u, v):
        if swap:
            u, v = v, u
        return tuple(sum(ends) - x if turned else x
                     for x, turned, ends in zip((u, v), flip, domain))

    return Patch(degree, knots, points, weights, patch.name), back


def shuffled(patches, draw):
    """Every patch in a random one of its eight orientations, patches in random order."""
    order = list(range(len(patches)))
    draw.shuffle(order)
    turned = [reoriented(patches[k], draw.random() < 0.5,
                         [draw.random() < 0.5, draw.random() < 0.5]) for k in order]
    return Rewritten([p for p, _ in turned], order, [b for _, b in turned])


def cube_symmetries():
    """All 48: axis a of the new cube is axis `axes[a]` of the old one, reversed where `turned`."""
    return list(product(permutations(range(3)), product((False, True), repeat=3)))


def relabelled(patches, symmetry):
    """Six patches in the order x low, x high, y low ... seen from a relabelled cube."""
    axes, turned = symmetry
    new, source, back = [], [], []
    for axis, end in product(range(3), range(2)):
        old_axis, old_end = axes[axis], end ^ turned[axis]
        new_axes = [a for a in range(3) if a != axis]  # of u and v of the new patch
        old_axes = [a for a in range(3) if a != old_axis]
        swap = axes[new_axes[0]] != old_axes[0]
        flip = [turned[axes.index(a)] for a in old_axes]
        patch, way = reoriented(patches[2 * old_axis + old_end], swap, flip)
        new.append(patch)
        source.append(2 * old_axis + old_end)
        back.append(way)
    return Rewritten(new, source, back)


def rescaled(patches, choose):
    """Knots mapped to factor * knot + shift; choose() gives (factor, shift) per direction."""
    new, back = [], []
    for patch in patches:
        maps = [choose(), choose()]
        knots = [[f * k + c for k in row] for (f, c), row in zip(maps, patch.knots)]
        new.append(Patch(patch.degree, knots, patch.points, patch.weights, patch.name))
        back.append(lambda u, v, maps=maps: tuple((x - c) / f for x, (f, c) in zip((u, v), maps)))
    return Rewritten(new, back=back)


def rescaled_at_random(patches, draw):
    def choose():
        factor = 10 ** draw.uniform(-3, 3)
        return factor, factor * draw.uniform(-5, 5)

    return rescaled(patches, choose)


def rescaled_by_two(patches, draw):
    """By powers of two: exact, so not one bit of the result may change."""
    return rescaled(patches, lambda: (2.0 ** draw.randint(-6, 6), 0.0))


def one_side_raised(patches, index, direction, raised=1):
    new = list(patches)
    new[index] = raise_patch(patches[index], direction, raised)
    return Rewritten(new)


def one_side_refined(patches, index, direction, values):
    new = list(patches)
    new[index] = insert_patch_knots(patches[index], direction, values)
    return Rewritten(new)


def one_side_reweighted(patches, index, factor):
    """A constant factor on all weights of a patch: the same surface."""
    new = list(patches)
    old = patches[index]
    weights = np.ones(old.points.shape[:2]) if old.weights is None else old.weights
    new[index] = Patch(old.degree, old.knots, old.points, factor * weights, old.name)
    return Rewritten(new)


def moved(patches, draw):
    """A random rotation (by a unit quaternion) and a shift of some hundred millimetres."""
    q = np.array([draw.gauss(0, 1) for _ in range(4)])
    a, b, c, d = q / np.linalg.norm(q)
    rotation = np.array([[1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
                         [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
                         [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)]])
    shift = np.array([draw.uniform(-300, 300) for _ in range(3)])
    new = []
    for p in patches:
        # componentwise, in one order for every shape: shared rows stay shared
        points = sum(p.points[..., k, None] * rotation[:, k] for k in range(3)) + shift
        new.append(Patch(p.degree, p.knots, points, p.weights, p.name))
    return Rewritten(new, motion=(rotation, shift))


def through_step(patches, folder):
    """Out to STEP and in again by FreeCAD; faces come back in any order and orientation."""
    path = os.path.join(folder, "part.tsb")
    write_tsb(patches, path)
    code = ("import os, sys; sys.path.insert(0, os.environ['TSOLID_EXAMPLES']); "
            "from examples.shapes import round_trip; round_trip(os.environ['TSOLID_EXAMPLE'])")
    environment = dict(os.environ, TSOLID_EXAMPLES=os.path.join(ROOT, "resources"),
                       TSOLID_EXAMPLE=path)
    run = subprocess.run([os.environ.get("TSOLID_FREECADCMD", "freecadcmd"), "-c", code],
                         env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                         stderr=subprocess.STDOUT)
    if run.returncode != 0:
        raise RuntimeError(run.stdout.decode("utf-8", "replace"))
    back = read_tsb(path + ".back")
    return Rewritten(back, *matched(back, patches))


def matched(new, old):
    """For each new patch the old one and the orientation under which their corners agree."""
    source, back = [], []
    for patch in new:
        candidates = []
        for k, other in enumerate(old):
            for swap, flip_u, flip_v in product((False, True), repeat=3):
                turned, way = reoriented(other, swap, (flip_u, flip_v))
                gap = max(np.abs(turned.points[i, j] - patch.points[i, j]).max()
                          for i in (0, -1) for j in (0, -1))
                candidates.append((gap, k, swap, (flip_u, flip_v), way))
        _, k, swap, flip, way = min(candidates, key=lambda c: c[:4])
        turned, _ = reoriented(old[k], swap, flip)

        def parameters(u, v, way=way, here=patch.domain(), there=turned.domain()):
            mapped = [b0 + (x - a0) / (a1 - a0) * (b1 - b0)
                      for x, (a0, a1), (b0, b1) in zip((u, v), here, there)]
            return way(*mapped)

        source.append(k)
        back.append(parameters)
    return source, back
