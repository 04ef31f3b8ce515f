#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Results on solids inside FreeCADCmd: result_cases.py."""

import sys
import unittest

import binding_parts
from binding_parts import run_in_freecad


class Inside(unittest.TestCase):
    def test_results(self):
        code, text = run_in_freecad("result_cases.py", "")
        self.assertRegex(text, r"[1-9]\d* passed, 0 failed", text)
        self.assertEqual(code, 0, text)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
