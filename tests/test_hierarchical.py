#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Hierarchical B-splines as the boundary of a solid: functions that sum to one, and not."""
import sys

import binding_parts
from hierarchical_parts import HierarchicalCase


class SmallTest(HierarchicalCase):
    def test_truncated_quadratic(self):
        self.check(2, 4, 2, True, False)

    def test_plain_sum_is_not_one(self):
        self.check(2, 4, 2, False, True)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
