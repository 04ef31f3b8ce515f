#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Hierarchical B-splines as the boundary of a solid: cubic, three levels."""
import sys

import binding_parts
from hierarchical_parts import HierarchicalCase


class LargeTest(HierarchicalCase):
    def test_truncated_cubic_three_levels(self):
        self.check(3, 4, 3, True, True)

    def test_plain_cubic(self):
        self.check(3, 4, 2, False, True)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
