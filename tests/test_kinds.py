#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Parts of all kinds from FreeCAD's own tools: taken or refused as they must be."""

import shutil
import sys
import unittest

import binding_parts
from binding_parts import run_in_freecad


class Kinds(unittest.TestCase):
    """kind_cases.py, class by class, inside FreeCADCmd."""

    def cases(self, name):
        code, text = run_in_freecad("kind_cases.py", "." + name + ".")
        self.assertRegex(text, r"[1-9]\d* passed, 0 failed", text)
        self.assertEqual(code, 0, text)

    def test_verdicts(self):
        self.cases("Verdicts")

    def test_corners(self):
        self.cases("Corners")

    def test_building(self):
        self.cases("Building")


if __name__ == "__main__":
    if not shutil.which(binding_parts.FREECAD):
        print("skipped: FreeCADCmd was not found")
        sys.exit(77)
    sys.exit(binding_parts.run(sys.modules[__name__]))
