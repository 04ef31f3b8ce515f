# SPDX-License-Identifier: LGPL-2.1-or-later
"""The example assemblies, what is expected of them, ways to write them otherwise, and the command
run on them."""
import json
import os
import subprocess
import tempfile
import unittest

import jsonschema

import binding_parts
from binding_parts import ROOT
from rewrite_part import moved, rescaled_at_random, shuffled

from examples.assemblies import UNIT
from examples.cube_mesh import CubeMesh, write_model
from examples.splines import Patch, raise_patch, write_tsb

COMMAND = os.environ.get("TSOLID_COMMAND") or os.path.join(
    os.path.dirname(binding_parts.library_path()), "tsolid")

# verdict, contacts by kind, clashes by kind, gap
EXPECTED = {
    "pair": ("watertight", {"exact": 1}, [], 0),
    "pair_refined": ("watertight", {"geometric": 1}, [], 0),
    "pair_gap_1e-6": ("gaps", {"near": 1}, [], 1e-6),
    "pair_gap_1e-3": ("gaps", {"near": 1}, [], 1e-3),
    "pair_gap_0.1": ("gaps", {"near": 1}, [], 0.1),
    "pair_gap_1": ("gaps", {"near": 1}, [], 1.0),
    "pair_overlapping": ("clashes", {}, ["overlap"], 0),
    "pair_rotated": ("gaps", {"near": 1}, [], 0.0017453283658983088 * UNIT),
    "propeller": ("watertight", {"partial": 2}, [], 0),
    "propeller_tspline": ("watertight", {"partial": 2}, [], 0),
    "ring": ("watertight", {"partial": 4}, [], 0),
    "tee": ("watertight", {"exact": 6}, [], 0),
    "wall": ("watertight", {"exact": 51, "partial": 42}, [], 0),
    "bridge": ("watertight", {"partial": 2}, [], 0),
    "array": ("watertight", {"exact": 180}, [], 0),
}
OPTIONS = {"pair_gap_1": ("--gap", "2")}  # a hundredth of a part is less
KINDS = ("exact", "geometric", "partial", "coincident", "near")
EXIT = {"watertight": 0, "gaps": 2, "clashes": 2, "incomplete": 1}
SCHEMA = os.path.join(ROOT, "resources", "assembly.schema.json")


def as_they_are(totals):
    return {kind: totals.get(kind, 0) for kind in KINDS}


def as_one_kind(totals):
    """Exact and geometric contacts are told apart by how they are written alone."""
    count = as_they_are(totals)
    return dict(count, exact=0, geometric=count["exact"] + count["geometric"])


def moved_back(patches, rotation, shift):
    """Componentwise, in one order for every shape, as rewrite_part does it."""
    return [Patch(p.degree, p.knots,
                  sum((p.points - shift)[..., k, None] * rotation.T[:, k] for k in range(3)),
                  p.weights, p.name) for p in patches]


def moved_and_back(parts, draw):
    """All parts by one random motion and back: each point off by some units of the last place."""
    state = draw.getstate()
    for name, patches in parts.items():
        draw.setstate(state)
        there = moved(patches, draw)
        yield name, moved_back(there.patches, *there.motion)


def written_otherwise(parts, draw, raised=1):
    """Every patch in one of its eight orientations, patches and parts in another order, knots over
    other ranges, moved and moved back; the first part's degrees are raised in one direction. Parts
    that are T-splines stay as they are."""
    plain = {name: patches for name, patches in parts.items() if not isinstance(patches, CubeMesh)}
    back = dict(moved_and_back(plain, draw))
    for k, (name, patches) in enumerate(back.items()):
        patches = rescaled_at_random(shuffled(patches, draw).patches, draw).patches
        if k == 0 and raised:
            patches = [raise_patch(p, draw.randrange(2)) for p in patches]
        back[name] = patches
    out = list(dict(parts, **back).items())
    draw.shuffle(out)
    return dict(out)


def write_parts(parts, folder):
    paths = []
    for name, patches in parts.items():
        paths.append(os.path.join(folder, name + ".tsb"))
        if isinstance(patches, CubeMesh):
            write_model(patches, paths[-1], "patches")
        else:
            write_tsb(patches, paths[-1])
    return paths


class AssemblyCase(unittest.TestCase):
    def setUp(self):
        base = tempfile.TemporaryDirectory()
        self.addCleanup(base.cleanup)
        self.folder = base.name
        with open(SCHEMA, encoding="utf-8") as stream:
            self.validator = jsonschema.Draft7Validator(json.load(stream))

    def run_command(self, *arguments, **environment):
        return subprocess.run([COMMAND, "assembly"] + list(arguments), cwd=self.folder,
                              env=dict(os.environ, **environment), stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=1200)

    def write(self, parts):
        return write_parts(parts, self.folder)

    def read_report(self, path, run):
        self.assertTrue(os.path.exists(path), run.stderr)
        with open(path, encoding="utf-8") as stream:
            report = json.load(stream)
        os.unlink(path)
        self.validator.validate(report)
        return report

    def report_of(self, parts, *options):
        path = os.path.join(self.folder, "report.json")
        run = self.run_command("--check-only", "--report", path, *options, *self.write(parts))
        report = self.read_report(path, run)
        self.assertEqual(run.returncode, EXIT[report["verdict"]], run.stdout)
        return report

    def check(self, name, parts, alike):
        """The verdict, contacts, clashes, gap, and that volumes add up."""
        verdict, kinds, clashes, gap = EXPECTED[name]
        report = self.report_of(parts, *OPTIONS.get(name, ()))
        totals = report["totals"]
        self.assertEqual(report["verdict"], verdict, name)
        self.assertEqual(alike(totals), alike(kinds), name)
        self.assertEqual([clash["kind"] for clash in report["clashes"]], clashes, name)
        largest = max([c["gap"] for c in report["interfaces"]] or [0])
        self.assertAlmostEqual(largest, gap, delta=max(0.01 * gap, 1e-12 * UNIT * 10))
        self.check_volume(name, report)
        return report

    def check_volume(self, name, report):
        totals = report["totals"]
        if report["verdict"] != "watertight":
            return
        off = abs(totals["volume"] - totals["volume_inside"]) / totals["volume"]
        print("%-20s volume %.15g, within the free faces: relative difference %.1e"
              % (name, totals["volume"], off))
        self.assertLess(off, 1e-12, name)
        self.assertEqual(totals["n_groups"], 1, name)

    def build(self, parts, *options):
        path = os.path.join(self.folder, "report.json")
        if "--effort" not in options:
            options = ("--effort", "quick") + options
        run = self.run_command("--report", path, "-o", self.folder, *options, *self.write(parts))
        return run, self.read_report(path, run)

    def check_built(self, name, parts, *options):
        """Both sides of every contact have the same functions and control points, bit for bit."""
        run, report = self.build(parts, *options)
        self.assertIn(run.returncode, (0, 2) if "none" in options else (0,),
                      run.stdout + run.stderr)
        self.assertEqual(report["verdict"], "watertight", name)
        self.assertEqual(len(report["interfaces"]), sum(EXPECTED[name][1].values()))
        for contact in report["interfaces"]:
            self.assertTrue(contact["same_functions"] and contact["same_bits"], contact)
            self.assertEqual(contact["gap_after"], 0)
            self.assertLess(contact["ulp_after"], 32)
