#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""All example assemblies written otherwise: before matching, before the construction, and through
STEP into FreeCAD.

TSOLID_TEST_SEED takes another seed than the default; it is printed."""
import json
import os
import random
import sys
import tempfile

import binding_parts
from assembly_cases import EXPECTED, KINDS, OPTIONS, AssemblyCase, as_one_kind, written_otherwise
from binding_parts import launch, run_in_freecad

from examples.assemblies import ASSEMBLIES, UNIT
from examples.cube_mesh import CubeMesh

SEED = os.environ.get("TSOLID_TEST_SEED", "7")
N_TIMES = 3
PAIRS = {"bridge": 1}  # of faces: what FreeCAD's check counts
ROUNDED = 1e-10 * UNIT  # STEP has twelve digits or more of numbers up to some units


def all_written(word):
    """(name, parts) of all examples, written otherwise by a generator of their own."""
    for name, make in ASSEMBLIES.items():
        yield name, written_otherwise(make(), random.Random("%s %s %s" % (SEED, name, word)))


class LongTest(AssemblyCase):
    def test_matched(self):
        print("seed", SEED)
        for k in range(N_TIMES):
            for name, parts in all_written(k):
                with self.subTest("%s %d" % (name, k)):
                    report = self.check(name, parts, as_one_kind)
                    for contact in report["interfaces"]:
                        if contact["kind"] in KINDS[:3]:
                            self.assertLess(contact["deviation"], 1e-11 * UNIT)

    def test_built(self):
        """But for T-spline blades: theirs is the degree that they came with, so that a shaft of
        higher degree keeps functions of its own, which the report says."""
        for name, parts in all_written("built"):
            if name == "propeller_tspline":
                run, report = self.build(parts)
                self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
                self.assertEqual(report["verdict"], "watertight")
                self.assertEqual(len(report["interfaces"]), sum(EXPECTED[name][1].values()))
                for contact in report["interfaces"]:
                    self.assertIsNotNone(contact["same_functions"])
                    self.assertLess(contact["gap_after"], 1e-11 * UNIT)
                continue
            if EXPECTED[name][0] == "watertight":
                with self.subTest(name):
                    effort = "none" if len(parts) > 10 else "quick"
                    self.check_built(name, parts, "--effort", effort)

    def step(self, name, parts):
        path = os.path.join(self.folder, name + ".step")
        code, text = run_in_freecad("freecad_join.py", path, *self.write(parts))
        self.assertEqual(code, 0, text)
        return path

    def test_through_step(self):
        """What the kernel measures of the parts that it has read: the same verdicts and gaps."""
        for name, parts in all_written("step"):
            verdict, kinds, clashes, gap = EXPECTED[name]
            if any(isinstance(patches, CubeMesh) for patches in parts.values()) or name == "array":
                continue  # STEP has no T-splines; a hundred Links are in test_assembly_freecad.py
            with self.subTest(name):
                options = OPTIONS.get(name, ())
                code, good, bad = launch("assembly", "--check-only", self.step(name, parts),
                                         *options)
                if verdict == "watertight":
                    self.assertEqual((code, bad), (0, ""), good)
                    self.assertRegex(good, "Watertight: %d contacts"
                                     % PAIRS.get(name, sum(kinds.values())))
                elif verdict == "gaps":
                    self.assertEqual((code, good), (2, ""), bad)
                    told = float(bad.split("gaps of up to ")[1].split()[0].rstrip("."))
                    self.assertAlmostEqual(told / gap, 1.0, delta=0.01)
                else:
                    self.assertEqual(code, 2)
                    self.assertIn("Parts penetrate each other: %d" % len(clashes), bad)

    def test_through_step_and_built(self):
        for name, parts in all_written("step, built"):
            if name not in ("pair", "pair_refined", "ring", "tee", "propeller", "bridge"):
                continue
            with self.subTest(name), tempfile.TemporaryDirectory() as out:
                code, good, bad = launch("assembly", "--effort", "quick", "--out", out,
                                         self.step(name, parts))
                self.assertEqual(code, 0, good + bad)
                with open(os.path.join(out, "report.json"), encoding="utf-8") as stream:
                    report = json.load(stream)
                self.validator.validate(report)
                self.assertEqual(report["verdict"], "watertight")
                self.assertEqual(as_one_kind(report["totals"]), as_one_kind(EXPECTED[name][1]))
                for contact in report["interfaces"]:
                    self.assertTrue(contact["same_functions"] and contact["same_bits"], contact)
                    self.assertEqual(contact["gap_after"], 0)
                    self.assertLess(contact["deviation"], ROUNDED)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
