#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Ruled faces take over their neighbours' parameters: follow_cases.py inside FreeCADCmd."""

import shutil
import sys
import unittest

import binding_parts
from binding_parts import run_in_freecad


class Follow(unittest.TestCase):
    def test_cases(self):
        code, text = run_in_freecad("follow_cases.py")
        self.assertRegex(text, "7 passed, 0 failed", text)
        self.assertEqual(code, 0, text)


if __name__ == "__main__":
    if not shutil.which(binding_parts.FREECAD):
        print("skipped: FreeCADCmd was not found")
        sys.exit(77)
    sys.exit(binding_parts.run(sys.modules[__name__]))
