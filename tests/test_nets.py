#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""nets.py tells wrong nets from those that a file merely wrote in another way."""

import math
import random
import sys
import unittest

import binding_parts
import nets
from freecad.tsolid.binding import Patch

KNOTS = ((0.0, 0.0, 0.0, 2.0, 5.0, 5.0, 5.0), (1.0, 1.0, 3.0, 3.0))  # degrees 2 and 1


def patch(seed):
    """A rational patch without any symmetry."""
    numbers = random.Random(seed)
    points = [tuple(numbers.uniform(-9, 9) for _ in range(3)) for _ in range(8)]
    weights = [numbers.uniform(0.5, 2.0) for _ in range(8)]
    return Patch((2, 1), (4, 2), KNOTS, points, weights, name="Face%d" % seed)


def changed(seed, **slots):
    made = patch(seed)
    for slot, value in slots.items():
        setattr(made, slot, value)
    return made


class Nets(unittest.TestCase):
    def setUp(self):
        self.patches = [patch(k) for k in range(3)]
        self.ours = nets.nets_of(self.patches)

    def with_first(self, first):
        return nets.difference(self.ours, nets.nets_of([first] + self.patches[1:]))

    def test_what_does_not_count(self):
        """Order, symmetries, an affine parameter, one factor of the weights."""
        for net in self.ours:
            self.assertEqual(len(net.symmetries()), 8)
            for s in net.symmetries():
                theirs = [s] + [n for n in self.ours[::-1] if n is not net]
                self.assertLess(nets.difference(self.ours, theirs), 1e-14)
        knots = [[7.0 - 2.0 * k for k in reversed(KNOTS[0])], [10.0 * k for k in KNOTS[1]]]
        weights = [3.0 * w for w in self.patches[0].weights]
        rows = [[i + 4 * j for i in reversed(range(4))] for j in range(2)]
        order = [k for row in rows for k in row]
        turned = changed(0, knots=knots, weights=[weights[k] for k in order],
                         points=[self.patches[0].points[k] for k in order])
        self.assertLess(self.with_first(turned), 1e-13)

    def test_symmetries_are_different(self):
        """Nothing is equal to its own mirror image by chance."""
        first, *others = self.ours[0].symmetries()
        for other in others:
            self.assertGreater(first.distance_as_is(other), 1e-3)

    def test_every_control_point_counts(self):
        for k in range(8):
            points = list(self.patches[0].points)
            points[k] = (points[k][0], points[k][1] + 1e-6, points[k][2])
            self.assertAlmostEqual(self.with_first(changed(0, points=points)), 1e-6, delta=1e-12)

    def test_exchanged_points_and_weights_count(self):
        points, weights = self.patches[0].points, self.patches[0].weights
        self.assertGreater(self.with_first(changed(0, points=points[1::-1] + points[2:])), 1e-3)
        for k in range(8):
            other = [w * (1.0 + 1e-6 * (i == k)) for i, w in enumerate(weights)]
            self.assertEqual(self.with_first(changed(0, weights=other)), math.inf)

    def test_knots_and_degrees_count(self):
        knots = ((0.0, 0.0, 0.0, 2.00001, 5.0, 5.0, 5.0), KNOTS[1])
        self.assertEqual(self.with_first(changed(0, knots=knots)), math.inf)
        raised = changed(0, degree=(1, 1), knots=((0.0, 0.0, 1.0, 2.0, 3.0, 3.0), KNOTS[1]))
        self.assertEqual(self.with_first(raised), math.inf)

    def test_less_is_known_far_from_the_origin(self):
        knots = ((0.0, 0.0, 0.0, 2.0 + 1e-7, 5.0, 5.0, 5.0), KNOTS[1])
        theirs = nets.nets_of([changed(0, knots=knots)] + self.patches[1:])
        for far, same in ((1.0, False), (10.0, False), (100.0, True)):
            self.assertEqual(nets.difference(self.ours, theirs, far) == 0.0, same)

    def test_every_patch_counts(self):
        self.assertEqual(nets.difference(self.ours, self.ours[:2]), math.inf)
        self.assertEqual(nets.difference(self.ours[:2], self.ours), math.inf)
        twice = [self.ours[0], self.ours[0], self.ours[2]]
        self.assertGreater(nets.difference(self.ours, twice), 1e-3)

    def test_chosen_points_inside(self):
        """Of patches so named only the border counts, and they must be so named on both sides."""
        def free(points, names=("Face0",)):
            made = Patch((2, 2), (4, 4), (KNOTS[0], KNOTS[0]), points, name="Face0")
            return nets.nets_of([made], names)

        points = [(float(i), float(j * j), 1.0 * i * j) for j in range(4) for i in range(4)]
        inside, border = list(points), list(points)
        inside[5], border[4] = (9.0, 9.0, 9.0), (9.0, 9.0, 9.0)
        self.assertEqual(nets.difference(free(points), free(inside)), 0.0)
        self.assertGreater(nets.difference(free(points), free(border)), 1.0)
        self.assertEqual(nets.difference(free(points), free(points, ())), math.inf)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
