#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The FreeCAD side from outside: the launcher's files and exit codes, new processes, bad input."""

import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import binding_parts
from binding_parts import LAUNCHER, ROOT, launch, run_in_freecad

SCHEMA = os.path.join(ROOT, "resources", "report.schema.json")
SHARED = os.path.join(os.path.dirname(ROOT), "shared", "data")
OUTPUTS = ("%s.FCStd", "%s.tsolid", "%s.vtu", "report.html", "report.json")
NOBODY = 65534


def outputs(name):
    return sorted(x % name if "%" in x else x for x in OUTPUTS)


class Inside(unittest.TestCase):
    """freecad_cases.py, class by class, inside FreeCADCmd."""

    def cases(self, name):
        code, text = run_in_freecad("freecad_cases.py", "." + name + ".")
        self.assertRegex(text, r"[1-9]\d* passed, 0 failed", text)
        self.assertEqual(code, 0, text)

    def test_conversion(self):
        self.cases("Conversion")

    def test_refusals(self):
        self.cases("Refusals")

    def test_evidence(self):
        self.cases("Evidence")

    def test_building(self):
        self.cases("Building")

    def test_documents(self):
        self.cases("Documents")

    def test_the_runner_sees_failures(self):
        """An error inside FreeCADCmd is not taken for success, and nothing runs twice."""
        with tempfile.TemporaryDirectory() as folder:
            script = os.path.join(folder, "raises.py")
            with open(script, "w", encoding="utf-8") as stream:
                stream.write("print('RU' + 'N', flush=True); raise ValueError('x')\n")
            code, text = run_in_freecad(script)
            self.assertNotEqual(code, 0)
            self.assertEqual(text.count("RUN"), 1, text)


class WithFolder(unittest.TestCase):
    def setUp(self):
        self.holder = tempfile.TemporaryDirectory()
        self.addCleanup(self.holder.cleanup)
        self.folder = self.holder.name

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def made(self, kind, name, **words):
        """A file that freecad_maker.py makes inside FreeCADCmd."""
        path = self.path(name)
        code, text = run_in_freecad("freecad_maker.py", kind, path)
        self.assertEqual(code, 0, text)
        return path


class Launcher(WithFolder):
    """STEP in, everything out."""

    def built(self, path, out, name):
        code, text, errors = launch("build", path, "--out", out)
        self.assertEqual((code, errors), (0, ""), text)
        self.assertEqual(sorted(os.listdir(out)), outputs(name))
        with open(os.path.join(out, "report.json"), encoding="utf-8") as stream:
            return text, json.load(stream)

    def facts(self, what, *arguments):
        """JSON that freecad_facts.py prints from inside a new FreeCADCmd process."""
        answer = self.path("answer.json")
        code, text = run_in_freecad("freecad_facts.py", what, answer, *arguments)
        self.assertEqual(code, 0, text)
        with open(answer, encoding="utf-8") as stream:
            return json.load(stream)

    def test_everything_from_a_step_file(self):
        step, out = self.made("wavy", "wavy box.step"), self.path("out put")
        text, report = self.built(step, out, "wavy box")
        self.assertIn("positive", text)
        self.assertEqual(report["verdict"], "positive")
        self.assertEqual(len(report["exactness"]), 6)
        self.check_schema(report)
        self.check_reopened(out, report)
        self.check_conformity(step, out, report)

    def check_schema(self, report):
        import jsonschema

        with open(SCHEMA, encoding="utf-8") as stream:
            jsonschema.validate(report, json.load(stream))

    def check_reopened(self, out, report):
        """A second process finds the same report and, bit for bit, the same solid."""
        facts = self.facts("document", os.path.join(out, "wavy box.FCStd"))
        self.assertEqual(facts["report"], report)
        with open(os.path.join(out, "wavy box.tsolid"), "rb") as stream:
            self.assertEqual(bytes.fromhex(facts["tsolid"]), stream.read())
        self.assertTrue(facts["closed"] and facts["valid"])
        self.assertEqual((facts["type"], facts["faces"]), ("Solid", 6))
        self.assertEqual(facts["label"], "wavy box")

    def check_conformity(self, step, out, report):
        """From the .tsolid alone in a new process; a control point 1e-9 * scale off must fail."""
        stored = os.path.join(out, "wavy box.tsolid")
        facts = self.facts("conformity", step, stored)
        self.assertTrue(facts["same"])
        self.assertEqual([r["satisfied"] for r in facts["rows"]], [True] * 6, facts)
        self.assertEqual(facts["rows"], report["exactness"])
        with open(stored, "rb") as stream:
            data = stream.read()
        moved = self.path("moved.tsolid")
        with open(moved, "wb") as stream:
            scale = report["conformity"]["scale"]
            stream.write(binding_parts.with_moved_point(data, 1e-9 * scale))
        facts = self.facts("conformity", step, moved)
        self.assertFalse(facts["same"])
        self.assertIn(False, [r["satisfied"] for r in facts["rows"]])

    def test_same_bytes_again_and_old_outputs_are_replaced(self):
        step, out = self.made("wavy", "a.step"), self.path("out")
        os.mkdir(out)
        self.built(step, out, "a")
        with open(os.path.join(out, "a.tsolid"), "rb") as stream:
            first = stream.read()
        with open(os.path.join(out, "a.tsolid"), "wb") as stream:
            stream.write(b"old")
        self.built(step, out, "a")
        with open(os.path.join(out, "a.tsolid"), "rb") as stream:
            self.assertEqual(stream.read(), first)

    def test_kinds_of_files(self):
        """The same solid through STEP, BREP, FCStd and .tsb is the same .tsolid."""
        seen = set()
        for name in ("a.brep", "b.step", "c.FCStd", "d.tsb"):
            path, out = self.made("box", name), self.path("out " + name)
            self.built(path, out, os.path.splitext(name)[0])
            with open(os.path.join(out, name.split(".")[0] + ".tsolid"), "rb") as stream:
                seen.add(stream.read())
        self.assertEqual(len(seen), 1)

    def test_bezier_elements(self):
        """A boundary of Bezier elements instead of patches: built, in a document with a solid."""
        path, out = self.made("bezier", "b.tsb"), self.path("out")
        _, report = self.built(path, out, "b")
        self.assertEqual((report["verdict"], report["exactness"]), ("positive", []))
        facts = self.facts("document", os.path.join(out, "b.FCStd"))
        self.assertTrue(facts["closed"] and facts["valid"])
        self.check_schema(report)

    def test_iges(self):
        """Loose faces are sewn, which is told; the solid is the file's to its ten digits."""
        words = r"note: %d loose faces were sewn to one solid; .* \(measured [-.e0-9]+\)"
        for kind, faces in (("box", 6), ("bar", 3)):
            path, out = self.made(kind, kind + ".igs"), self.path(kind)
            code, text, errors = launch("check", path)
            self.assertEqual((code, errors), (0, ""), text)
            self.assertRegex(text, words % faces)
            text, report = self.built(path, out, kind)
            self.assertRegex(text, words % faces)
            self.assertEqual(report["verdict"], "positive")
            self.check_schema(report)
            facts = self.facts("document", os.path.join(out, kind + ".FCStd"))
            self.assertTrue(facts["closed"] and facts["valid"])
            want = {"box": 6000.0, "bar": 90.0 * math.pi}[kind]
            self.assertAlmostEqual(report["volume"]["quadrature"] / want, 1.0, delta=1e-8)

    def test_iges_that_does_not_close(self):
        """A face is missing: where, in one sentence for each edge around it."""
        path = self.made("open", "open.igs")
        code, text, errors = launch("check", path)
        self.assertEqual((code, text), (1, ""))
        self.assertEqual(errors.count("5 loose faces do not close to a solid"), 4, errors)

    def test_check(self):
        code, text, errors = launch("check", self.made("wavy", "a.step"), cwd=self.folder)
        self.assertEqual((code, errors), (0, ""))
        self.assertIn("satisfied", text)
        self.assertEqual(sorted(os.listdir(self.folder)), ["a.step"])

    def test_names_with_blanks_newlines_and_dashes(self):
        for name in ("a  b\n c.step", "-x.step", "\u00e4 'q' \"d\" $HOME.step"):
            step, out = self.made("wavy", name), self.path("o\nut " + name)
            self.built(step, out, name[: -len(".step")])
            shutil.rmtree(out)
        code, _, errors = launch("check", "-x.step", cwd=self.folder)
        self.assertEqual(code, 1)
        self.assertEqual(launch("check", "--", "-x.step", cwd=self.folder)[0], 0, errors)

    def test_options_reach_the_library(self):
        step, out = self.made("box", "a.step"), self.path("out")
        code, _, errors = launch(
            "build", step, "--out", out, "--refine-knots", "1", "--raise-degree", "1",
            "--effort", "quick", "--min-cells", "4", "--threads", "1", "--tolerance", "1e-6",
            "--octree", "isotropic", "--analysis-suitable", "off", "--corners", "Vertex2,Vertex7",
        )
        self.assertEqual((code, errors), (0, ""))
        with open(os.path.join(out, "report.json"), encoding="utf-8") as stream:
            report = json.load(stream)
        want = {"refine_knots": 1, "raise_degree": 1, "effort": "quick", "min_cells": 4}
        want.update(octree="isotropic", analysis_suitable=False, tolerance=1e-6,
                    corners=["Vertex2", "Vertex7"])
        self.assertEqual(report["options"], want)
        self.assertFalse(report["statistics"]["analysis_suitable"])
        self.assertEqual(report["preparation"]["refine_knots"], 1)
        self.assertEqual(report["preparation"]["raise_degree"], 1)

    def test_help_and_version(self):
        self.assertIn("usage", launch("--help")[1])
        self.assertIn(binding_parts.header.VERSION, launch("--version")[1])

    @unittest.skipUnless(os.path.isdir(SHARED), "no %s" % SHARED)
    def test_parts_by_others(self):
        for name in ("duck", "wavy_cube"):
            _, report = self.built(os.path.join(SHARED, name + ".step"), self.path(name), name)
            self.assertEqual(report["verdict"], "positive")


@unittest.skipUnless("TSOLID_BUILD_DIR" in os.environ, "no TSOLID_BUILD_DIR")
class Installed(WithFolder):
    """`cmake --install` gives an add-on that finds its library by itself, also when moved."""

    def test_launcher_and_addon(self):
        prefix, moved = self.path("prefix"), self.path("mo ved")
        command = ["cmake", "--install", os.environ["TSOLID_BUILD_DIR"], "--prefix", prefix]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        os.rename(prefix, moved)
        addon = os.path.join(moved, "share", "freecad", "Mod", "tsolid")
        environment = {k: v for k, v in os.environ.items() if not k.startswith("TSOLID_LIBRARY")}
        environment.pop("PYTHONPATH", None)
        step = self.made("box", "a.step")
        launcher = os.path.join(addon, "freecad_workbench", "bin", "tsolid-freecad")
        run = subprocess.run([launcher, "check", step], env=environment, stdout=subprocess.PIPE)
        self.assertEqual(run.returncode, 0)
        self.assertIn(b"satisfied", run.stdout)
        self.check_addon(addon, environment)

    def check_addon(self, addon, environment):
        """FreeCAD itself finds the namespace package in the add-on's folder."""
        script, answer = self.path("try_addon.py"), self.path("answer")
        with open(script, "w", encoding="utf-8") as stream:
            stream.write(
                "import Part, freecad.tsolid as ts\n"
                "text = ts.check(Part.makeBox(1, 2, 3)).verdict + ' ' + ts.__file__\n"
                "open(%r, 'w').write(text)\n" % answer
            )
        command = [binding_parts.FREECAD, script, "-M", addon]  # the script first: see its parser
        nowhere = subprocess.DEVNULL
        subprocess.run(command, env=environment, stdin=nowhere, stdout=nowhere)
        with open(answer, encoding="utf-8") as stream:
            self.assertRegex(stream.read(), "^satisfied .*mo ved")


class BadInput(WithFolder):
    """One clear message with the place, exit code 1, nothing written or overwritten."""

    def refused(self, path, *words, **environment):
        out = self.path("out")
        for existing in (False, True):
            if existing:
                os.mkdir(out)
                with open(os.path.join(out, "report.json"), "w", encoding="utf-8") as stream:
                    stream.write("old")
            code, text, errors = launch("build", path, "--out", out, **environment)
            self.assertEqual((code, text), (1, ""), errors)
            for word in words:
                self.assertIn(word, errors)
            self.assertNotIn("Traceback", errors)
            self.assertNotIn("defect", errors)
            if existing:
                self.assertEqual(os.listdir(out), ["report.json"])
                with open(os.path.join(out, "report.json"), encoding="utf-8") as stream:
                    self.assertEqual(stream.read(), "old")
                shutil.rmtree(out)
            else:
                self.assertFalse(os.path.exists(out))
        return errors

    def test_parts(self):
        """Made by freecad_maker.py; each with the words that the message must hold."""
        cases = {
            "shell": ("not a solid",),
            "open": ("Edge", "open along this edge"),
            "five": ("Edge",),
            "bored": ("hole", "genus 1"),
            "torus": ("hole", "genus 1", "Face1"),
            "sphere": ("pole", "Face1, Vertex1"),
            "tip": ("pole", "Face1, Vertex"),
            "trimmed": ("Face", "Edge", "not an isoparametric line"),
            "two": ("2 solids",),
        }
        for kind, words in cases.items():
            with self.subTest(kind):
                self.refused(self.made(kind, kind + ".brep"), *words)

    def test_patches(self):
        cases = {
            "gap": ("Edge", "0.001"),
            "nan": ("patches[5].points[0]",),
            "infinite": ("patches[5].points[0]",),
            "negative weight": ("Face",),
            "zero weight": ("Face",),
            "no area": ("Face",),
            "duplicate": ("Face",),
            "pole": ("Face",),
        }
        for kind, words in cases.items():
            with self.subTest(kind):
                self.refused(self.made(kind, kind + ".tsb"), *words)

    def test_documents(self):
        self.refused(self.made("two", "two.FCStd"), "2 solids")
        self.refused(self.made("none", "none.FCStd"), "holds no solid")

    def test_several_solids_are_checked_as_an_assembly(self):
        for name in ("two.FCStd", "two.brep"):
            code, text, errors = launch("check", self.made("two", name))
            self.assertEqual((code, errors), (0, ""), text)
            self.assertIn("two: No parts touch", text)

    def write(self, name, data):
        path = self.path(name)
        with open(path, "wb") as stream:
            stream.write(data)
        return path

    def test_files(self):
        with open(self.made("wavy", "whole.step"), "rb") as stream:
            step = stream.read()
        with open(self.made("box", "whole.tsb"), "rb") as stream:
            tsb = stream.read()
        for suffix in ("step", "brep", "igs", "FCStd", "tsb"):
            wrong = {"empty": b"", "text": b"hello\n", "binary": bytes(range(256)) * 9}
            for name, data in wrong.items():
                with self.subTest(name + "." + suffix):
                    self.refused(self.write(name + "." + suffix, data))
        self.refused(self.write("half.step", step[: len(step) // 2]))
        self.refused(self.write("half.tsb", tsb[: len(tsb) // 2]))
        self.refused(self.write("alien.stl", b"solid"), "only STEP")
        self.refused(self.path("none.step"), "does not exist")
        self.refused(self.folder, "not a file")

    def test_the_input_is_never_overwritten(self):
        path = self.made("box", "a.FCStd")
        with open(path, "rb") as stream:
            before = stream.read()
        code, _, errors = launch("build", path, "--out", self.folder)
        self.assertEqual(code, 1)
        self.assertIn("would be overwritten", errors)
        with open(path, "rb") as stream:
            self.assertEqual(stream.read(), before)

    def test_targets(self):
        step = self.made("box", "a.step")
        code, _, errors = launch("build", step, "--out", self.path("no", "such"))
        self.assertEqual((code, errors.count("\n")), (1, 1), errors)
        code, _, errors = launch("build", step, "--out", step)
        self.assertEqual((code, errors.count("\n")), (1, 1), errors)
        os.makedirs(self.path("out", "a.vtu"))
        code, _, errors = launch("build", step, "--out", self.path("out"))
        self.assertEqual((code, errors.count("\n")), (1, 1), errors)
        self.assertIn("is a directory", errors)
        self.assertEqual(os.listdir(self.path("out")), ["a.vtu"])

    def test_read_only_directory(self):
        step, out = self.made("box", "a.step"), self.path("out")
        os.mkdir(out)
        os.chmod(out, 0o555)
        os.chmod(self.folder, 0o755)
        prefix = []
        if os.getuid() == 0:  # root may write everywhere
            prefix = ["setpriv", "--reuid=%d" % NOBODY, "--clear-groups"]
        with open(LAUNCHER, "rb") as script:  # the checkout itself may be closed to others
            run = subprocess.run(
                prefix + ["sh", "-s", "build", step, "--out", out],
                cwd=self.folder,
                stdin=script,
                stderr=subprocess.PIPE,
            )
        self.assertEqual(run.returncode, 1)
        self.assertIn(b"nothing can be written", run.stderr)
        os.chmod(out, 0o755)
        self.assertEqual(os.listdir(out), [])

    def test_full_directory(self):
        """Files may grow to so many blocks only, as on a full disk; nothing is left then."""
        step, out = self.made("wavy", "a.step"), self.path("out")
        os.mkdir(out)
        whole = False
        for blocks in (1, 16, 64, 256, 100000):
            run = subprocess.run(
                ["sh", "-c", "ulimit -f %d; exec \"$@\"" % blocks, "sh"]
                + [LAUNCHER, "build", step, "--out", out],
                env=dict(os.environ, TSOLID_LIBRARY=binding_parts.library_path()),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
            )
            left = sorted(os.listdir(out))
            if run.returncode == 0:
                whole = True
                self.assertEqual(left, outputs("a"))
            else:
                self.assertEqual((run.returncode, left), (1, []), run.stderr)
                self.assertTrue(run.stderr)
        self.assertTrue(whole)

    def test_library(self):
        step = self.made("box", "a.step")
        alien = self.write("alien.so", b"not a library")
        for path, words in ((self.path("none.so"), "does not exist"), (alien, "cannot be loaded")):
            errors = self.refused(step, words, TSOLID_LIBRARY=path)
            self.assertEqual(errors.count("\n"), 1, errors)

    def test_freecad(self):
        step = self.made("box", "a.step")
        for command in ("/nonexistent/freecadcmd", "false"):
            errors = self.refused(step, "FreeCAD", TSOLID_FREECADCMD=command)
            self.assertEqual(errors.count("\n"), 1, errors)
        code, _, errors = launch("check", step, PATH=self.without_freecad())
        self.assertEqual((code, errors.count("\n")), (1, 1), errors)
        self.assertIn("was not found", errors)

    def without_freecad(self):
        """A PATH with what the launcher needs and no FreeCADCmd."""
        tools = self.path("tools")
        os.mkdir(tools)
        for name in ("sh", "dirname", "readlink", "mkdir", "rm", "rmdir", "sed", "tail", "tr"):
            os.symlink(shutil.which(name), os.path.join(tools, name))
        return tools

    def test_words(self):
        for words in ((), ("check",), ("build", "--out"), ("mend", "x"), ("check", "a", "b"),
                      ("check", "--no", "a"), ("check", "--threads", "two", "a.step"),
                      ("check", "--threads", "1 2", "a.step")):
            code, text, errors = launch(*words, cwd=self.folder)
            self.assertEqual((code, text, errors.count("\n")), (1, "", 1), words)


class Interrupts(WithFolder):
    """Ctrl-C at any moment: 130, and nothing half-written."""

    def children(self, group):
        found = []
        for entry in filter(str.isdigit, os.listdir("/proc")):
            try:
                if os.getpgid(int(entry)) == group:
                    found.append(entry)
            except ProcessLookupError:
                pass
        return found

    def interrupted(self, step, out, delay):
        process = subprocess.Popen(
            [LAUNCHER, "build", step, "--out", out],
            env=dict(os.environ, TSOLID_LIBRARY=binding_parts.library_path()),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        time.sleep(delay)
        try:
            os.killpg(process.pid, signal.SIGINT)
        except ProcessLookupError:
            pass
        process.communicate(timeout=60)
        self.assertEqual(self.children(process.pid), [])
        return process.returncode

    def test_any_moment(self):
        step, out = self.made("wavy", "a.step"), self.path("out")
        start = time.perf_counter()
        self.assertEqual(launch("build", step, "--out", out)[0], 0)
        whole = time.perf_counter() - start
        shutil.rmtree(out)
        numbers = random.Random(7)
        hits = 0
        for k in range(12):
            delay = 0.02 + whole * (k + numbers.random()) / 12
            code = self.interrupted(step, out, delay)
            left = sorted(os.listdir(out)) if os.path.isdir(out) else []
            self.assertIn(left, ([], outputs("a")), (k, delay))
            if code == 130:
                hits += 1
            else:  # it was too late to interrupt
                self.assertEqual((code, left), (0, outputs("a")), (k, delay))
            shutil.rmtree(out, ignore_errors=True)
        self.assertGreaterEqual(hits, 6)


if __name__ == "__main__":
    if not shutil.which(binding_parts.FREECAD):
        print("skipped: FreeCADCmd was not found")
        sys.exit(77)
    sys.exit(binding_parts.run(sys.modules[__name__]))
