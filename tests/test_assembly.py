#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tsolid assembly on the example assemblies, as they are and written otherwise; and the binding."""

import json
import os
import random
import subprocess
import sys
import tempfile
import unittest

import jsonschema

import binding_parts
from binding_parts import ROOT, binding
from rewrite_part import shuffled

from examples.assemblies import ASSEMBLIES, UNIT, curved_block, moved
from examples.cube_mesh import CubeMesh, write_model
from examples.splines import raise_patch, write_tsb
from freecad.tsolid.assembly import Assembly

COMMAND = os.environ.get("TSOLID_COMMAND") or os.path.join(
    os.path.dirname(binding_parts.library_path()), "tsolid")

# verdict, contacts by kind, clashes by kind, gap
EXPECTED = {
    "pair": ("watertight", {"exact": 1}, [], 0),
    "pair_refined": ("watertight", {"geometric": 1}, [], 0),
    "pair_gap_1e-6": ("gaps", {"near": 1}, [], 1e-6),
    "pair_gap_1e-3": ("gaps", {"near": 1}, [], 1e-3),
    "pair_gap_0.1": ("gaps", {"near": 1}, [], 0.1),
    "pair_overlapping": ("clashes", {}, ["overlap"], 0),
    "pair_rotated": ("gaps", {"near": 1}, [], 0.0017453283658983088 * UNIT),
    "propeller": ("watertight", {"partial": 2}, [], 0),
    "propeller_tspline": ("watertight", {"partial": 2}, [], 0),
    "ring": ("watertight", {"partial": 4}, [], 0),
    "tee": ("watertight", {"exact": 6}, [], 0),
    "wall": ("watertight", {"exact": 51, "partial": 42}, [], 0),
}
KINDS = ("exact", "geometric", "partial", "coincident", "near")
EXIT = {"watertight": 0, "gaps": 2, "clashes": 2, "incomplete": 1}


def as_one_kind(totals):
    """Exact and geometric contacts are told apart by how they are written alone."""
    count = {kind: totals.get(kind, 0) for kind in KINDS}
    return dict(count, exact=0, geometric=count["exact"] + count["geometric"])


class AssemblyTest(unittest.TestCase):
    def setUp(self):
        base = tempfile.TemporaryDirectory()
        self.addCleanup(base.cleanup)
        self.folder = base.name
        with open(os.path.join(ROOT, "resources", "assembly.schema.json"),
                  encoding="utf-8") as stream:
            self.validator = jsonschema.Draft7Validator(json.load(stream))

    def run_command(self, *arguments):
        return subprocess.run([COMMAND, "assembly"] + list(arguments), cwd=self.folder,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=300)

    def write(self, parts):
        paths = []
        for name, patches in parts.items():
            paths.append(os.path.join(self.folder, name + ".tsb"))
            if isinstance(patches, CubeMesh):
                write_model(patches, paths[-1], "patches")
            else:
                write_tsb(patches, paths[-1])
        return paths

    def report_of(self, parts, *options):
        path = os.path.join(self.folder, "report.json")
        run = self.run_command("--check-only", "--report", path, *options, *self.write(parts))
        self.assertTrue(os.path.exists(path), run.stderr)
        with open(path, encoding="utf-8") as stream:
            report = json.load(stream)
        self.validator.validate(report)
        self.assertEqual(run.returncode, EXIT[report["verdict"]], run.stdout)
        return report

    def check(self, name, parts, alike):
        verdict, kinds, clashes, gap = EXPECTED[name]
        report = self.report_of(parts)
        totals = report["totals"]
        self.assertEqual(report["verdict"], verdict, name)
        self.assertEqual(alike(totals), alike(kinds), name)
        self.assertEqual([clash["kind"] for clash in report["clashes"]], clashes, name)
        largest = max([c["gap"] for c in report["interfaces"]] or [0])
        self.assertAlmostEqual(largest, gap, delta=max(0.01 * gap, 1e-12 * UNIT * 10))
        if verdict == "watertight":
            self.assertLess(abs(totals["volume"] - totals["volume_inside"]),
                            1e-12 * totals["volume"])
            self.assertEqual(totals["n_groups"], 1)
        return report

    def test_examples(self):
        self.assertEqual(set(EXPECTED), set(ASSEMBLIES))
        for name, make in ASSEMBLIES.items():
            self.check(name, make(), lambda kinds: {k: kinds.get(k, 0) for k in KINDS})

    def test_examples_written_otherwise(self):
        draw = random.Random(5)
        for name, make in ASSEMBLIES.items():
            if name in ("wall", "propeller_tspline"):
                continue
            parts = {}
            for k, (part, patches) in enumerate(make().items()):
                patches = moved(moved(patches, shift=(31.7, -5, 2)), shift=(-31.7, 5, -2))
                patches = shuffled(patches, draw).patches
                if k == 0:
                    patches = [raise_patch(p, draw.randrange(2)) for p in patches]
                parts[part] = patches
            self.check(name, dict(reversed(list(parts.items()))), as_one_kind)

    def test_bad_input(self):
        part = ASSEMBLIES["pair"]()["left"]
        paths = self.write({"left": part, "same": part})
        run = self.run_command("--check-only", *paths)
        self.assertEqual(run.returncode, 2)
        self.assertIn("twice in the same place", run.stderr)
        run = self.run_command("--check-only", paths[0], paths[0])
        self.assertEqual(run.returncode, 2)
        self.assertIn("twice in the same place", run.stderr)
        broken = os.path.join(self.folder, "broken.tsb")
        with open(broken, "w", encoding="utf-8") as stream:
            stream.write("{")
        right = self.write({"right": ASSEMBLIES["pair"]()["right"]})
        run = self.run_command("--check-only", paths[0], broken, *right)
        self.assertEqual(run.returncode, 1)
        self.assertIn("broken is left out", run.stderr)
        self.assertIn("1 exact", run.stdout)
        run = self.run_command("--check-only", os.path.join(self.folder, "nowhere.tsb"))
        self.assertEqual(run.returncode, 1)

    def test_inside_and_units(self):
        outer = curved_block((0, 0, 0), (4, 4, 4))
        inner = curved_block((1.5, 1.5, 1.5), (2, 2, 2))
        report = self.report_of({"outer": outer, "inner": inner})
        self.assertEqual([c["kind"] for c in report["clashes"]], ["inside"])
        self.assertEqual(report["clashes"][0]["parts"], ["inner", "outer"])
        tiny = [p.copy() for p in outer]
        for patch in tiny:
            patch.points = patch.points / 1000.0 - 500
        report = self.report_of({"outer": outer, "tiny": tiny})
        self.assertIn("units", report["findings"][0]["text"])

    def build(self, parts, *options):
        path = os.path.join(self.folder, "report.json")
        run = self.run_command("--report", path, "-o", self.folder, "--effort", "quick", *options,
                               *self.write(parts))
        with open(path, encoding="utf-8") as stream:
            report = json.load(stream)
        self.validator.validate(report)
        return run, report

    def test_construction(self):
        draw = random.Random(11)
        for name in ("pair_refined", "ring", "propeller", "propeller_tspline"):
            parts = {part: patches if isinstance(patches, CubeMesh)
                     else shuffled(patches, draw).patches
                     for part, patches in ASSEMBLIES[name]().items()}
            run, report = self.build(parts)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
            for contact in report["interfaces"]:
                self.assertTrue(contact["same_functions"] and contact["same_bits"], contact)
                self.assertEqual(contact["gap_after"], 0)
                self.assertLess(contact["ulp_after"], 32)
            for part in parts:
                solid = os.path.join(self.folder, part + ".tsolid")
                again = subprocess.run([COMMAND, "report", solid], stdout=subprocess.DEVNULL)
                self.assertEqual(again.returncode, 0)

    def test_a_part_that_cannot_be_built(self):
        parts = ASSEMBLIES["ring"]()
        del parts["east"][1]
        run, report = self.build(parts)
        self.assertEqual(run.returncode, 1)
        self.assertEqual(report["verdict"], "incomplete")
        self.assertIn("No solid of east", run.stderr)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "west.tsolid")))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "east.tsolid")))
        known = [c["same_bits"] for c in report["interfaces"] if "east" not in c["parts"]]
        self.assertEqual(known, [True] * 2)

    def test_binding_builds(self):
        context = binding.Context()
        made = ASSEMBLIES["pair_refined"]()
        sources = [[binding_patch(p) for p in made[name]] for name in ("left", "right")]
        assembly = Assembly.create(context, list(zip(("left", "right"), sources)))
        solids = []
        for k, source in enumerate(sources):
            boundary = assembly.boundary(context, k, source)
            tmesh = binding.TMesh.create(context, boundary)
            space = binding.Space.create(context, boundary, tmesh)
            solids.append(binding.Solid.create(context, space))
        joined = assembly.joined(context, solids)
        self.assertEqual([c["same_bits"] for c in joined.interfaces], [1])
        contact = joined.interfaces[0]
        self.assertEqual(contact["code"], 0)
        for p, q in ((0, 0), (0.3, 0.7), (1, 0.1)):
            sides = [joined.evaluate(context, 0, side, p, q) for side in (0, 1)]
            self.assertEqual(sides[0], sides[1])

    def test_gap_option(self):
        parts = ASSEMBLIES["pair_gap_0.1"]()
        self.assertEqual(self.report_of(parts, "--gap", "0.01")["totals"]["near"], 0)
        self.assertEqual(self.report_of(parts, "--gap", "0.2")["totals"]["near"], 1)

    def test_binding(self):
        context = binding.Context()
        faces = [binding_patch(p) for p in ASSEMBLIES["pair_refined"]()["left"]]
        places = [[1, 0, 0, UNIT * k, 0, 1, 0, 0, 0, 0, 1, 0] for k in range(5)]
        parts = [("a%d" % k, faces, place) for k, place in enumerate(places)]
        assembly = Assembly.create(context, parts)
        self.assertEqual(assembly.verdict, 0)
        self.assertEqual([c["kind"] for c in assembly.interfaces], [0] * 4)
        self.assertEqual(assembly.view.part[4].copy_of, 0)
        self.assertEqual(len(assembly.free_faces), 22)
        self.validator.validate(json.loads(assembly.json(context)))
        places[2][0] = -1
        with self.assertRaises(binding.TsolidError):
            Assembly.create(context, parts)


def binding_patch(patch):
    n, m = patch.points.shape[:2]
    points = [tuple(patch.points[i, j]) for j in range(m) for i in range(n)]
    return binding.Patch(patch.degree, (n, m), patch.knots, points, name=patch.name or "")


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
