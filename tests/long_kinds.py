#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""All kinds of parts built, and all of them through BREP, STEP and IGES."""

import shutil
import sys
import unittest

import binding_parts
from binding_parts import run_in_freecad
from test_kinds import Kinds as Quick


class AllKinds(unittest.TestCase):
    cases = Quick.cases

    def test_solids(self):
        self.cases("AllSolids")

    def test_shared(self):
        code, text = run_in_freecad("kind_cases.py", ".Shared.")
        if code == binding_parts.SKIPPED:
            self.skipTest("no ../shared/data")
        self.assertRegex(text, "3 passed, 0 failed", text)
        self.assertEqual(code, 0, text)

    def test_round_trips(self):
        self.cases("RoundTrips")

    def test_through_iges(self):
        self.cases("ThroughIges")


del Quick

if __name__ == "__main__":
    if not shutil.which(binding_parts.FREECAD):
        print("skipped: FreeCADCmd was not found")
        sys.exit(77)
    sys.exit(binding_parts.run(sys.modules[__name__]))
