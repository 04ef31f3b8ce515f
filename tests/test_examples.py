#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Every example part through the whole chain; the long version is long_examples.py."""
import os
import random
import sys

import numpy as np

import binding_parts
import example_chain
from binding_parts import binding
from example_chain import OWN_SIDES, Chain, ChainCase, files_of
from rewrite_part import (cube_symmetries, relabelled, rescaled_by_two, shuffled)

from examples.parts import PARTS, round_bar
from examples.random_parts import DEFAULT_SEED, random_part


class ChainTest(ChainCase):
    def test_named_parts(self):
        print("\n" + example_chain.HEADING)
        for name, make in PARTS.items():
            with self.subTest(name):
                self.chain(make(), name, snapped=name in OWN_SIDES)

    def test_first_random_parts(self):
        print("\nseed %s\n%s" % (DEFAULT_SEED, example_chain.HEADING))
        for k in range(3):
            with self.subTest(k):
                self.chain(random_part(DEFAULT_SEED, k), "random_%02d" % k, snapped=True)

    def test_rewritten(self):
        print("\n" + example_chain.HEADING)
        for name in ("wedge", "grid24"):
            for word, patches in example_chain.rewritings(PARTS[name](), self.folder, name):
                with self.subTest("%s %s" % (name, word)):
                    self.chain(patches, "%s_%s" % (name, word), "--effort", "quick", snapped=True,
                               least_ratio=0.3)

    def test_mirrored(self):
        """Another part, the mirror image: as good as the first."""
        patches = PARTS["wedge"]()
        for patch in patches:
            patch.points[..., 0] *= -1
        self.chain(patches, "mirrored", "--effort", "quick", least_ratio=0.3)

    def test_tangent_corners_are_named(self):
        """Proved but for eight corners, and these are the right ones."""
        chain = self.chain(round_bar(), "round_bar", "--effort", "quick", n_singular=8)
        for point in chain.report["certificate"]["singular"]:
            self.assertAlmostEqual(np.hypot(point[0], point[1]), 10.0, delta=1e-12)
            self.assertAlmostEqual(abs(point[0]), abs(point[1]), delta=1e-12)
            self.assertIn(round(point[2], 9), (0.0, 60.0))

    def test_moved_control_point_is_found(self):
        """One stored control point moved by 1e-9 of the scale: no longer conformal."""
        chain = Chain(PARTS["wedge"](), self.folder, "to_move", "--effort", "none")
        chain.read_back()
        allowed = example_chain.DISTANCE * example_chain.scale_of(chain.patches)
        self.assertLess(chain.distance(chain.solid), allowed)
        with open(chain.path, "rb") as source:
            data = binding_parts.with_moved_point(
                source.read(), 1e-9 * example_chain.scale_of(chain.patches))
        path = os.path.join(self.folder, "moved.tsolid")
        with open(path, "wb") as target:
            target.write(data)
        self.assertGreater(chain.distance(binding.Solid.read(chain.context, path)), allowed)

    def test_48_orientations_and_shuffles(self):
        for name in ("mixed_sides", "box"):
            patches, draw = PARTS[name](), random.Random(name)
            ways = [relabelled(patches, s) for s in cube_symmetries()[:: 1 if name == "box" else 6]]
            ways += [shuffled(patches, draw) for _ in range(3)] + [rescaled_by_two(patches, draw)]
            first = None
            for k, way in enumerate(ways):
                chain = Chain(way.patches, self.folder, "turned", "--effort", "none")
                first = first or files_of(chain)
                with self.subTest("%s %d" % (name, k)):
                    for here, there in zip(files_of(chain), first):
                        self.assertTrue(here == there)

    def test_threads(self):
        for name in ("twisted_bar", "elbow"):
            runs = [files_of(Chain(PARTS[name](), self.folder, "threads", "--effort", "quick",
                                   "--threads", str(n))) for n in (1, 2, 3)]
            with self.subTest(name):
                self.assertTrue(runs[0] == runs[1] == runs[2])


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
