#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tsolid-freecad assembly: the example assemblies through STEP, documents with Links, bad input."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

import jsonschema

import binding_parts
from binding_parts import ROOT, launch, run_in_freecad

MAKE = os.path.join(ROOT, "resources", "make_assemblies.py")
SCHEMA = os.path.join(ROOT, "resources", "assembly.schema.json")


class Assemblies(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        subprocess.run([sys.executable, MAKE, "--out", cls.folder.name], check=True,
                       stdout=subprocess.DEVNULL)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def step(self, name):
        """The example assembly as one STEP file."""
        parts = self.path(name)
        files = sorted(os.path.join(parts, f) for f in os.listdir(parts) if f.endswith(".tsb"))
        code, text = run_in_freecad("freecad_join.py", self.path(name + ".step"), *files)
        self.assertEqual(code, 0, text)
        return self.path(name + ".step")

    def document(self, name):
        code, text = run_in_freecad("freecad_join.py", self.path(name + ".FCStd"), name)
        self.assertEqual(code, 0, text)
        return self.path(name + ".FCStd")

    def check(self, name, *options):
        return launch("assembly", "--check-only", self.step(name), *options)

    def build(self, path, *options):
        """(exit code, text, report)"""
        with tempfile.TemporaryDirectory() as out:
            code, good, bad = launch("assembly", "--effort", "none", "--out", out, path, *options)
            with open(os.path.join(out, "report.json"), encoding="utf-8") as stream:
                report = json.load(stream)
            with open(SCHEMA, encoding="utf-8") as stream:
                jsonschema.validate(report, json.load(stream))
            return code, good + bad, report, sorted(os.listdir(out))

    def test_check_only(self):
        """STEP keeps twelve digits; the verdicts stay."""
        for name, contacts in (("pair", 1), ("pair_refined", 1), ("ring", 4), ("tee", 6)):
            with self.subTest(name):
                code, good, bad = self.check(name)
                self.assertEqual((code, bad), (0, ""), good)
                self.assertRegex(good, "Watertight: %d contacts, %d of them" % (contacts, contacts))

    def test_gaps_as_made(self):
        for name, gap in (("pair_gap_1e-6", 1e-6), ("pair_gap_1e-3", 1e-3), ("pair_gap_0.1", 0.1)):
            with self.subTest(name):
                code, good, bad = self.check(name, "--gap", "0.5")
                self.assertEqual((code, good), (2, ""), bad)
                told = float(bad.split("gaps of up to ")[1].split()[0].rstrip("."))
                self.assertAlmostEqual(told / gap, 1.0, delta=0.01)

    def test_turned_and_overlapping(self):
        code, good, bad = self.check("pair_rotated")
        self.assertEqual(code, 2)
        self.assertIn("gaps of up to", bad)
        code, good, bad = self.check("pair_overlapping")
        self.assertEqual(code, 2)
        self.assertIn("Parts penetrate each other: 1", bad)

    def test_built(self):
        """Contacts are bit for bit after the build, also those that cover a part of a face."""
        for name, contacts, kinds in (("pair_refined", 1, {"geometric", "exact"}),
                                      ("tee", 6, {"exact"})):
            with self.subTest(name):
                code, text, report, files = self.build(self.step(name))
                self.assertEqual(code, 0, text)
                self.assertEqual(report["verdict"], "watertight")
                self.assertEqual(len(report["interfaces"]), contacts)
                self.assertLessEqual({i["kind"] for i in report["interfaces"]}, kinds)
                for interface in report["interfaces"]:
                    self.assertTrue(interface["same_functions"] and interface["same_bits"], text)
                    self.assertEqual(interface["gap_after"], 0.0)
                self.assertIn("%s.FCStd" % name, files)
                self.assertEqual(sum(f.endswith(".tsolid") for f in files),
                                 len(os.listdir(self.path(name))))

    def test_a_hundred_copies(self):
        """Built once, placed a hundred times: the same functions, a few units of the last place."""
        code, text, report, files = self.build(self.document("copies"))
        self.assertEqual(code, 0, text)
        self.assertEqual(files, ["Brick.tsolid", "copies.FCStd", "report.html", "report.json"])
        self.assertEqual(len(report["interfaces"]), 99)
        for interface in report["interfaces"]:
            self.assertTrue(interface["same_functions"])
            self.assertLess(interface["ulp_after"], 16)

    def test_a_part_that_cannot_be_done(self):
        """The others are done, the report says so, the exit code too."""
        path = self.document("mixed")
        code, good, bad = launch("assembly", "--check-only", path)
        self.assertEqual((code, bad), (0, ""))
        self.assertIn("Ball cannot become hex blocks", good)
        self.assertIn("coincident: Right Face2, Ball Face1", good)
        code, text, report, files = self.build(path)
        self.assertEqual(code, 1)
        self.assertIn("Incomplete: 1 of 3 parts have no solid", text)
        self.assertEqual(report["verdict"], "incomplete")
        self.assertEqual([f for f in files if f.endswith(".tsolid")],
                         ["Left.tsolid", "Right.tsolid"])

    def test_bad_input(self):
        path = self.document("one")
        code, good, bad = launch("assembly", path)
        self.assertEqual((code, good), (1, ""))
        self.assertIn("holds 1 solid; an assembly has two or more", bad)
        for words, sentence in (
            (("assembly", path, "--refine-knots", "1"), "an assembly is not refined"),
            (("check", path, "--gap", "1"), "belong to assembly"),
            (("build", path, "--check-only"), "belong to assembly"),
            (("assembly", "--gap", "wide", path), "has no such value"),
            (("assembly", self.path("pair/left.tsb")), "tsolid assembly"),
            (("assembly", "/nowhere.step"), "does not exist"),
        ):
            with self.subTest(words):
                code, good, bad = launch(*words, cwd=self.folder.name)
                self.assertEqual((code, good), (1, ""))
                self.assertIn(sentence, bad)
                self.assertEqual(bad.count("\n"), 1, bad)
        with tempfile.TemporaryDirectory() as out:
            os.mkdir(os.path.join(out, "report.json"))
            code, good, bad = launch("assembly", "--out", out, self.document("mixed"))
            self.assertEqual(code, 1)
            self.assertIn("is a directory", bad)
            self.assertEqual(os.listdir(out), ["report.json"])


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
