#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tsolid assembly on the example assemblies, as they are and written otherwise; and the binding."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from math import cos, pi, sin

import binding_parts
from assembly_cases import (COMMAND, EXPECTED, KINDS, AssemblyCase, as_one_kind, as_they_are,
                            write_parts, written_otherwise)
from binding_parts import binding
from rewrite_part import reoriented, shuffled

from examples.assemblies import ASSEMBLIES, UNIT, curved_block
from examples.cube_mesh import CubeMesh
from examples.splines import control_volume, uniform_knots
from freecad.tsolid.assembly import Assembly


class AssemblyTest(AssemblyCase):
    def test_examples(self):
        self.assertEqual(set(EXPECTED), set(ASSEMBLIES))
        for name, make in ASSEMBLIES.items():
            self.check(name, make(), as_they_are)

    def test_examples_written_otherwise(self):
        """Verdicts, contacts and volumes stay; what was exact is apart at rounding level."""
        draw = random.Random(5)
        for name, make in ASSEMBLIES.items():
            if name == "array":
                continue  # a hundred files: long_assembly.py has them
            report = self.check(name, written_otherwise(make(), draw), as_one_kind)
            for contact in report["interfaces"]:
                if contact["kind"] in KINDS[:3]:
                    self.assertLess(contact["deviation"], 1e-11 * UNIT, name)

    def test_written_otherwise_and_built(self):
        draw = random.Random(17)
        for name in ("pair", "pair_refined", "ring", "bridge"):
            self.check_built(name, written_otherwise(ASSEMBLIES[name](), draw))

    def test_eight_orientations(self):
        """Two cubes with a wavy face in common: the code is that of the second one's patch."""
        left, right = (ASSEMBLIES["pair"]()[name] for name in ("left", "right"))
        codes = set()
        for k in range(8):
            turned = [reoriented(p, k & 4, (k & 1, k & 2))[0] for p in right]
            report = self.report_of({"left": left, "right": turned})
            self.assertEqual(report["verdict"], "watertight")
            self.assertEqual([c["kind"] for c in report["interfaces"]], ["exact"])
            self.assertEqual(report["interfaces"][0]["deviation"], 0)
            codes.add(report["interfaces"][0]["code"])
        self.assertEqual(codes, set(range(8)))

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

    def test_a_part_that_touches_itself(self):
        """A bar bent until its ends meet; one whose end stands on its own side, next to which it
        has a border in common with that side; and one that stays open."""
        def bent(angle):
            def point(u, v, w):
                radius = 10 + 4 * v
                return [radius * cos(angle * u), radius * sin(angle * u), 4 * w]

            knots = [uniform_knots(2, n) for n in (12, 1, 1)]
            return control_volume(point, (2, 2, 2), knots).faces()

        def hook(end):
            outer = [(0, 0), (60, 0), (60, 50), (20, 50), (20, end)]
            inner = [(0, 10), (50, 10), (50, 40), (30, 40), (30, end)]

            def point(u, v, w):
                k = min(int(4 * u), 3)
                (x0, z0), (x1, z1) = ([a + (4 * u - k) * (b - a) for a, b in zip(*row[k:k + 2])]
                                      for row in (outer, inner))
                return [x0 + v * (x1 - x0), 10 * w, z0 + v * (z1 - z0)]

            knots = [uniform_knots(1, n) for n in (32, 1, 1)]
            return control_volume(point, (1, 1, 1), knots).faces()

        for part, clashes in ((bent(2 * pi), ["self"]), (bent(1.9 * pi), []),
                              (hook(10), ["self"]), (hook(11), [])):
            path = self.write({"bar": part})
            run = self.run_command("--check-only", "--report", "report.json", *path)
            report = self.read_report(os.path.join(self.folder, "report.json"), run)
            self.assertEqual([c["kind"] for c in report["clashes"]], clashes)
            self.assertEqual(run.returncode, 2 if clashes else 0)
            self.assertEqual("bar touches itself near" in run.stderr, bool(clashes), run.stderr)

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

    def test_construction(self):
        draw = random.Random(11)
        for name in ("pair_refined", "ring", "propeller", "propeller_tspline"):
            parts = {part: patches if isinstance(patches, CubeMesh)
                     else shuffled(patches, draw).patches
                     for part, patches in ASSEMBLIES[name]().items()}
            run, report = self.build(parts)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
            self.assertEqual(len(report["interfaces"]), sum(EXPECTED[name][1].values()))
            for contact in report["interfaces"]:
                self.assertTrue(contact["same_functions"] and contact["same_bits"], contact)
                self.assertEqual(contact["gap_after"], 0)
                self.assertLess(contact["ulp_after"], 32)
                if name != "propeller_tspline":
                    inside = [-1, 0 if contact["kind"] == "partial" else -1]
                    self.assertEqual(sorted(contact["continuity"]), inside, contact)
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

    def test_all_solids_or_none(self):
        """Nothing is in the folder before all is done, whenever the run is interrupted."""
        paths = self.write(ASSEMBLIES["tee"]())
        out = os.path.join(self.folder, "out")
        command = [COMMAND, "assembly", "-o", out, "--report", "r.json", "--effort", "none"]
        complete = sorted(os.path.basename(p).replace(".tsb", ".tsolid") for p in paths)
        before, codes = sorted(os.listdir(self.folder)), []
        for wait in (0.0, 0.05, 0.2, 0.5, 1.0):
            process = subprocess.Popen(command + paths, cwd=self.folder,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(wait)
            process.send_signal(signal.SIGINT)
            codes.append(process.wait(timeout=300))
            if codes[-1] in (0, 2):
                self.assertEqual(sorted(os.listdir(out)), complete)
                shutil.rmtree(out)
                os.unlink(os.path.join(self.folder, "r.json"))
            self.assertEqual(sorted(os.listdir(self.folder)), before)
        self.assertTrue([c for c in codes if c not in (0, 2)], codes)
        run = self.run_command("-o", out, "--effort", "none", *paths)
        self.assertIn(run.returncode, (0, 2))
        self.assertEqual(sorted(os.listdir(out)), complete)
        run = self.run_command("-o", paths[0], *paths)
        self.assertEqual((run.returncode, run.stdout), (1, ""))
        self.assertIn("it is not a folder", run.stderr)

    def test_two_files_of_one_name(self):
        folder = os.path.join(self.folder, "other")
        os.mkdir(folder)
        pair = ASSEMBLIES["pair"]()
        paths = (write_parts({"part": pair["left"]}, self.folder)
                 + write_parts({"part": pair["right"]}, folder))
        run = self.run_command("--effort", "none", "-o", "out", *paths)
        self.assertIn("1 exact", run.stdout)
        self.assertEqual(sorted(os.listdir(os.path.join(self.folder, "out"))),
                         ["part.tsolid", "part_2.tsolid"])

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
        turns = ((-1, 1, 1), (25.4, 25.4, 25.4), (1, 1, 1.001), (0, 1, 1), (float("nan"), 1, 1))
        for scale in turns:  # mirrored, in inches, stretched, flat, not a number
            for k in range(3):
                places[2][5 * k] = scale[k]
            with self.assertRaisesRegex(binding.TsolidError, "^The placement of a2 "):
                Assembly.create(context, parts)


def binding_patch(patch):
    n, m = patch.points.shape[:2]
    points = [tuple(patch.points[i, j]) for j in range(m) for i in range(n)]
    return binding.Patch(patch.degree, (n, m), patch.knots, points, name=patch.name or "")


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
