#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""All example parts and 50 random ones, each also in every re-writing; 48 orientations, threads.

TSOLID_TEST_SEED takes another seed than the default; it is printed."""
import os
import random
import sys

import binding_parts
import example_chain
from example_chain import OWN_SIDES, Chain, ChainCase, files_of
from rewrite_part import cube_symmetries, relabelled, shuffled

from examples.parts import PARTS
from examples.random_parts import DEFAULT_SEED, random_part

SEED = os.environ.get("TSOLID_TEST_SEED", DEFAULT_SEED)
N_RANDOM = 50


class LongTest(ChainCase):
    def in_all_writings(self, name, patches, snapped):
        with self.subTest(name):
            self.chain(patches, name, snapped=snapped)
        for word, written in example_chain.rewritings(patches, self.folder, name):
            with self.subTest("%s %s" % (name, word)):
                self.chain(written, "%s_%s" % (name, word), snapped=True)

    def test_all_named_parts(self):
        print("\n" + example_chain.HEADING)
        for name, make in PARTS.items():
            self.in_all_writings(name, make(), name in OWN_SIDES)

    def test_all_random_parts(self):
        print("\nseed %s\n%s" % (SEED, example_chain.HEADING))
        for k in range(N_RANDOM):
            self.in_all_writings("random_%02d" % k, random_part(SEED, k), True)

    def test_bits_at_full_effort(self):
        for name in ("wedge", "sphere", "mixed_sides"):
            patches, draw = PARTS[name](), random.Random(name)
            ways = [relabelled(patches, s) for s in cube_symmetries()]
            ways += [shuffled(patches, draw) for _ in range(10)]
            effort = "none" if name == "mixed_sides" else "default"
            first = files_of(Chain(patches, self.folder, "turned", "--effort", effort))
            for k, way in enumerate(ways):
                threads = str(1 + k % 3)
                chain = Chain(way.patches, self.folder, "turned", "--effort", effort,
                              "--threads", threads)
                with self.subTest("%s %d" % (name, k)):
                    for here, there in zip(files_of(chain), first):
                        self.assertTrue(here == there)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
