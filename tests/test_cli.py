#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The tsolid command: what it prints and writes, its exit codes; failures leave nothing behind."""

import json
import math
import os
import pty
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import jsonschema

import binding_parts
from binding_parts import ROOT, binding

EXAMPLES = os.path.join(ROOT, "resources", "examples")
VERSION = re.search(
    r'TSOLID_VERSION "(.*)"',
    open(os.path.join(ROOT, "libtsolid", "include", "tsolid.h"), encoding="utf-8").read(),
).group(1)


def command_path():
    given = os.environ.get("TSOLID_COMMAND")
    return given or os.path.join(os.path.dirname(binding_parts.library_path()), "tsolid")


def schema(name):
    with open(os.path.join(ROOT, "resources", name + ".schema.json"), encoding="utf-8") as stream:
        return json.load(stream)


def example(name):
    return os.path.join(EXAMPLES, name + ".tsb")


def read(path):
    with open(path, "rb") as stream:
        return stream.read()


class CommandTest(unittest.TestCase):
    """Runs in a folder of its own, with a blank in its name."""

    def setUp(self):
        base = tempfile.TemporaryDirectory()
        self.addCleanup(base.cleanup)
        self.folder = os.path.join(base.name, "with blank")
        os.mkdir(self.folder)

    def run_command(self, *arguments, **options):
        return subprocess.run(
            [command_path()] + list(arguments),
            cwd=self.folder,
            stdin=subprocess.DEVNULL,
            stdout=options.pop("stdout", subprocess.PIPE),
            stderr=subprocess.PIPE,
            universal_newlines=True,
            timeout=300,
            **options
        )

    def check_fails(self, says, *arguments, **options):
        """Exit code 1, one-sentence errors with `says` in them, nothing new on the disk."""
        before = sorted(os.listdir(self.folder))
        run = self.run_command(*arguments, **options)
        self.assertEqual(run.returncode, 1, run.stderr)
        lines = run.stderr.splitlines()
        self.assertTrue(lines and all(re.match("(error|warning|note): ", x) for x in lines), lines)
        self.assertTrue(any(x.startswith("error: ") and says in x for x in lines), lines)
        self.assertEqual(sorted(os.listdir(self.folder)), before)
        return run

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as stream:
            stream.write(text)
        return name

    def path(self, name):
        return os.path.join(self.folder, name)

    def cube_file(self, name="cube.tsb", change=None):
        patches = binding_parts.cube()
        if change:
            change(patches)
        binding.write_tsb(binding.Context(), patches, self.path(name))
        return name


class UsageTest(CommandTest):
    def test_version_and_help(self):
        run = self.run_command("--version")
        self.assertEqual((run.returncode, run.stdout), (0, "tsolid %s\n" % VERSION))
        run = self.run_command("--help")
        self.assertEqual(run.returncode, 0)
        for name in ("check", "build", "report", "export"):
            self.assertIn("tsolid " + name, run.stdout)
            help_run = self.run_command(name, "--help")
            self.assertEqual((help_run.returncode, help_run.stderr), (0, ""))
            self.assertTrue(help_run.stdout.startswith("tsolid " + name))

    def test_every_option_is_in_the_help(self):
        for name in ("build", "export"):
            text = self.run_command(name, "--help").stdout
            with open(os.path.join(ROOT, "libtsolid", "cli", name + ".c")) as file:
                options = re.findall(r'\{"(--[a-z-]+)", CLI', file.read())
            self.assertGreater(len(options), 7)
            for option in options:
                if option != "--output":
                    self.assertRegex(text, r"(\n  |, )%s " % option)

    def test_wrong_arguments(self):
        self.assertEqual(self.run_command().returncode, 1)
        self.check_fails("Unknown command 'frob'", "frob")
        self.check_fails("Which file?", "check")
        self.check_fails("One file at a time", "check", "a", "b")
        self.check_fails("Unknown option '--frob'", "check", "--frob", "a")
        self.check_fails("Unknown option '-x'", "build", "-x", "a")
        self.check_fails("-o needs a value", "build", "a.tsb", "-o")
        self.check_fails("-o OUT.tsolid is missing", "build", example("box"))
        self.check_fails("--inp FILE or --matrices FOLDER is missing", "export", "a.tsolid")
        self.check_fails("whole number", "build", "a", "-o", "b", "--threads", "two")
        self.check_fails("from 0 to 256", "build", "a", "-o", "b", "--threads=-1")
        self.check_fails("from 0 to 6", "build", "a", "-o", "b", "--refine-knots", "7")
        self.check_fails("positive number", "check", "a", "--tolerance", "nan")
        self.check_fails("positive number", "check", "a", "--tolerance", "1e-3x")
        self.check_fails("quick or thorough", "build", "a", "-o", "b", "--effort", "much")
        self.check_fails("not an empty text", "build", "a", "-o", "")

    def test_a_name_that_looks_like_an_option(self):
        self.cube_file("--x.tsb")
        self.assertEqual(self.run_command("check", "--", "--x.tsb").returncode, 0)
        self.assertEqual(self.run_command("check", "./--x.tsb").returncode, 0)


class CheckTest(CommandTest):
    def test_good_parts(self):
        for name in ("box", "sphere", "grid24"):
            run = self.run_command("check", example(name))
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            self.assertIn("satisfied: closed, connected, genus 0", run.stdout)
            n = {"grid24": 24}.get(name, 6)
            self.assertIn("%d patches" % n, run.stdout)

    def test_tolerance(self):
        def shift(patches):
            x, y, z = patches[0].points[0]
            patches[0].points[0] = (x - 1e-3, y, z)

        self.cube_file(change=shift)
        self.check_fails("", "check", "cube.tsb")
        run = self.run_command("check", "cube.tsb", "--tolerance", "1e-2")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("snapped by up to", run.stdout)

    def test_refusal_names_the_place(self):
        self.cube_file(change=lambda patches: patches.pop())
        run = self.check_fails("", "check", "cube.tsb")
        self.assertIn("NOT SATISFIED", run.stdout)
        self.assertRegex(run.stderr, "Edge[0-9]+|Face[0-9]+")

    def test_alien_files(self):
        self.check_fails("No such file", "check", "none.tsb")
        self.check_fails("a directory", "check", ".")
        self.check_fails("line 1", "check", self.write("empty.tsb", ""))
        self.check_fails("line 2", "check", self.write("json.tsb", '{\n"a": 1}'))
        with open(example("box"), encoding="utf-8") as stream:
            self.check_fails("line", "check", self.write("cut.tsb", stream.read()[:-40]))

    def test_newlines_in_names_stay_on_one_line(self):
        def rename(patches):
            for k, patch in enumerate(patches):
                patch.name = "Face\nerror: %d" % k
                patch.border_names = ["Edge\n\x1b[31m"] * 4
            patches.pop()

        self.cube_file(change=rename)
        run = self.check_fails("", "check", "cube.tsb")
        self.assertNotIn("\x1b", run.stderr)


class BuildTest(CommandTest):
    def test_build_report_export(self):
        run = self.run_command(
            "build", example("box"), "-o", "box.tsolid", "--report", "r.json", "--vtu=box.vtu"
        )
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertEqual(sorted(os.listdir(self.folder)), ["box.tsolid", "box.vtu", "r.json"])
        lines = run.stdout.splitlines()
        self.assertTrue(lines[0].startswith("Verdict       valid: det J > 0 is proved"))
        titles = [x.split()[0] for x in lines if not x.startswith(" ")]
        self.assertEqual(
            titles,
            "Verdict Requirement Preparation Statistics Certificate Quality Basis Continuity "
            "Conformity Volume Timing".split(),
        )
        with open(self.path("r.json"), encoding="utf-8") as stream:
            report = json.load(stream)
        self.check_report(report)
        for stage in ("boundary", "tmesh", "space", "start", "optimise", "total"):
            self.assertGreaterEqual(report["timing"][stage], 0)
        self.assertGreater(report["timing"]["peak_memory_mib"], 1)
        self.check_second_process(report)

    def check_report(self, report):
        jsonschema.Draft7Validator(schema("report")).validate(report)
        self.assertEqual(report["certificate"]["verdict"], "positive")
        volume = report["conformity"]["volume"]
        self.assertTrue(math.isclose(volume, 60 * 40 * 30, rel_tol=1e-12))
        self.assertTrue(report["conformity"]["control_identical"])
        self.assertEqual(report["requirement"]["n_patches"], 6)
        self.assertEqual(len(report["requirement"]["corner"]), 8)

    def check_second_process(self, report):
        """report and export of the file give the same facts and bytes as build did."""
        run = self.run_command("report", "box.tsolid", "--json", "-", "--threads", "1")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        again = json.loads(run.stdout)
        jsonschema.Draft7Validator(schema("report")).validate(again)
        self.assertIsNone(again["timing"]["optimise"])
        del again["timing"], report["timing"]
        self.assertEqual(again, report)
        run = self.run_command("report", "box.tsolid", "--json", "again.json")
        self.assertEqual(run.returncode, 0)
        self.assertIn("Verdict", run.stdout)
        with open(self.path("again.json"), encoding="utf-8") as stream:
            from_file = json.load(stream)
        del from_file["timing"]
        self.assertEqual(from_file, report)
        run = self.run_command("export", "box.tsolid", "--bext", "box.bxt")
        self.assertEqual((run.returncode, read(self.path("box.bxt"))[:11]), (0, b"B E X T 2.0"))
        run = self.run_command("export", "box.tsolid", "--vtu", "again.vtu")
        self.assertEqual((run.returncode, run.stdout, run.stderr), (0, "", ""))
        self.assertEqual(read(self.path("again.vtu")), read(self.path("box.vtu")))

    def test_threads_change_nothing(self):
        for n in ("1", "2", "5"):
            run = self.run_command(
                "build", example("wedge"), "-o", n + ".tsolid", "--vtu", n + ".vtu", "--effort",
                "quick", "--threads", n, "--report", n + ".json",
            )
            self.assertIn(run.returncode, (0, 2), run.stderr)
        first = json.loads(read(self.path("1.json")).decode())
        del first["timing"]
        for n in ("2", "5"):
            for ending in (".tsolid", ".vtu"):
                self.assertEqual(read(self.path(n + ending)), read(self.path("1" + ending)))
            report = json.loads(read(self.path(n + ".json")).decode())
            del report["timing"]
            self.assertEqual(report, first)

    def test_not_proved(self):
        """A corner pushed in so far that the faces themselves are inverted there: code 2."""
        patches = binding_parts.cube(lambda *x: (0.2, 0.2, 0.2) if x == (1, 1, 1) else x)
        binding.write_tsb(binding.Context(), patches, self.path("dent.tsb"))
        run = self.run_command("build", "dent.tsb", "-o", "x.tsolid", "--effort", "none")
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertTrue(run.stdout.startswith("Verdict       NOT VALID: det J <= 0 at ("))
        self.assertEqual(sorted(os.listdir(self.folder)), ["dent.tsb", "x.tsolid"])
        run = self.run_command("report", "x.tsolid", "--json", "-")
        self.assertEqual(run.returncode, 2)
        self.assertEqual(json.loads(run.stdout)["certificate"]["verdict"], "not positive")
        self.assertEqual(self.run_command("export", "x.tsolid", "--vtu", "x.vtu").returncode, 0)

    def test_refinement_is_exact(self):
        volumes = []
        for extra in ([], ["--refine-knots", "1"], ["--raise-degree", "1"], ["--min-cells", "4"]):
            run = self.run_command(
                "build", example("twisted_bar"), "-o", "x.tsolid", "--effort", "none", "--report",
                "x.json", *extra
            )
            self.assertIn(run.returncode, (0, 2), run.stderr)
            report = json.loads(read(self.path("x.json")).decode())
            volumes.append(report["conformity"]["volume"])
            jsonschema.Draft7Validator(schema("report")).validate(report)
            if extra and extra[0] == "--min-cells":
                self.assertGreaterEqual(report["statistics"]["core_cells"], 64)
        for volume in volumes[1:]:
            self.assertTrue(math.isclose(volume, volumes[0], rel_tol=1e-12), volumes)

    def test_refused_parts_write_nothing(self):
        self.write("kept.tsolid", "kept")
        self.cube_file(change=lambda patches: patches.pop())
        self.check_fails("", "build", "cube.tsb", "-o", "kept.tsolid", "--vtu", "new.vtu")
        self.assertEqual(read(self.path("kept.tsolid")), b"kept")


class TargetTest(CommandTest):
    """Where the operating system refuses, it is said before the work, and nothing is touched."""

    def build(self, says, *arguments, **options):
        name = options.pop("input", example("box"))
        return self.check_fails(says, "build", name, "--effort", "none", *arguments, **options)

    def test_bad_targets(self):
        os.mkdir(self.path("folder"))
        self.build("a directory", "-o", "folder")
        self.build("No such file", "-o", "none/x.tsolid")
        self.build("not a regular file", "-o", "/dev/null")
        self.build("not a regular file", "-o", "x.tsolid", "--vtu", "/dev/full")
        self.build("a directory", "-o", "x.tsolid", "--report", "folder")
        self.build("asked for twice", "-o", "x.tsolid", "--report", "x.tsolid")
        self.build("asked for twice", "-o", "x.tsolid", "--report", "./x.tsolid")
        self.build("File name too long", "-o", "x" * 5000)
        self.build("File name too long", "-o", "x" * 300)

    def test_input_is_not_overwritten(self):
        self.cube_file()
        before = read(self.path("cube.tsb"))
        self.build("it is the input", "-o", "cube.tsb", input="cube.tsb")
        os.symlink("cube.tsb", self.path("link"))
        self.build("it is the input", "-o", "link", input="cube.tsb")
        self.assertEqual(read(self.path("cube.tsb")), before)

    @unittest.skipIf(os.geteuid() == 0, "root may write everywhere")
    def test_read_only(self):
        os.mkdir(self.path("locked"), 0o555)
        self.build("Permission denied", "-o", "locked/x.tsolid")
        os.chmod(self.path(self.write("x.tsolid", "kept")), 0o444)
        self.build("Permission denied", "-o", "x.tsolid")
        self.assertEqual(read(self.path("x.tsolid")), b"kept")

    def test_full_disk(self):
        """By a limit on the size of files; whichever of the three files does not fit."""

        def limit(size):
            def run():
                signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
                resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

            return run

        self.write("kept.tsolid", "kept")
        for size in (0, 1000, 10000, 40000):
            self.build(
                "File too large", "-o", "kept.tsolid", "--vtu", "x.vtu", "--report", "x.json",
                preexec_fn=limit(size), restore_signals=False,
            )
            self.assertEqual(read(self.path("kept.tsolid")), b"kept")

    def test_full_standard_output(self):
        with open("/dev/full", "w") as full:
            self.assertEqual(self.run_command("--help", stdout=full).returncode, 1)
            self.assertEqual(self.run_command("check", example("box"), stdout=full).returncode, 1)

    def test_damaged_solids(self):
        run = self.run_command("build", example("box"), "-o", "x.tsolid", "--effort", "none")
        self.assertEqual(run.returncode, 0)
        good = read(self.path("x.tsolid"))
        for name, data in (
            ("cut", good[:-1]), ("long", good + b"x"), ("empty", b""), ("alien", b"PK" * 99),
            ("flipped", good[:500] + bytes([good[500] ^ 1]) + good[501:]),
            ("newer", good[:8] + b"\x7f" + good[9:]),
        ):
            with open(self.path(name), "wb") as stream:
                stream.write(data)
            for arguments in (["report", name], ["export", name, "--vtu", "y.vtu"]):
                self.check_fails("File '%s'" % name, *arguments)


class SignalTest(CommandTest):
    def start(self):
        return subprocess.Popen(
            [command_path(), "build", example("elbow"), "-o", "kept.tsolid", "--vtu", "x.vtu",
             "--effort", "thorough", "--refine-knots", "1"],
            cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )

    def test_interrupt_at_any_moment(self):
        self.write("kept.tsolid", "kept")
        codes = []
        for k in range(12):
            process = self.start()
            time.sleep(0.02 + 0.07 * k)  # when, does not matter: no moment may leave anything
            process.send_signal(signal.SIGINT)
            out, error = process.communicate(timeout=120)
            codes.append(process.returncode)
            if process.returncode == 0:
                break
            self.assertEqual(out, b"")
            self.assertEqual(os.listdir(self.folder), ["kept.tsolid"])
            self.assertEqual(read(self.path("kept.tsolid")), b"kept")
        interrupted = [c for c in codes if c not in (0, 2)]
        self.assertTrue(interrupted)
        self.assertTrue(set(interrupted) <= {130, -signal.SIGINT}, codes)
        self.assertIn(130, interrupted)

    def test_progress_only_on_a_terminal(self):
        master, slave = pty.openpty()
        arguments = [command_path(), "build", example("box"), "-o", "x.tsolid", "--effort", "none"]
        process = subprocess.Popen(
            arguments, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=slave
        )
        os.close(slave)
        shown = b""
        while True:
            try:
                part = os.read(master, 4096)
            except OSError:
                break
            if not part:
                break
            shown += part
        self.assertEqual(process.wait(timeout=60), 0)
        os.close(master)
        self.assertRegex(shown, rb"\r\x1b\[K\w+ \d+ %")
        run = subprocess.run(arguments, cwd=self.folder, stdout=subprocess.DEVNULL,
                             stderr=subprocess.PIPE)
        self.assertNotIn(b"%", run.stderr)


@unittest.skipUnless(os.environ.get("TSOLID_FAILING_MALLOC"), "TSOLID_FAILING_MALLOC is not set")
class MemoryTest(CommandTest):
    """Every malloc of the process fails once, those of third-party libraries included."""

    def run_failing(self, at, *arguments):
        folder, name = os.path.split(os.environ["TSOLID_FAILING_MALLOC"])
        environment = dict(
            os.environ,
            LD_PRELOAD=name,  # its path may hold blanks, which separate names here
            LD_LIBRARY_PATH=folder,
            TSOLID_FAIL_AT=str(at),
            TSOLID_FAIL_COUNT=self.path("count"),
        )
        return self.run_command(*arguments, env=environment)

    def check_each(self, *arguments):
        self.assertEqual(self.run_failing(0, *arguments).returncode, 0)
        with open(self.path("count"), encoding="ascii") as stream:
            count = int(stream.read())
        before = sorted(os.listdir(self.folder))
        for at in sorted(set(range(1, count + 1, max(1, count // 100))) | {count - 1, count}):
            run = self.run_failing(at, *arguments)
            self.assertIn(run.returncode, (0, 1), "allocation %d: %s" % (at, run.stderr))
            if run.returncode == 1:  # libgomp knows no way but to say so and exit
                self.assertRegex(run.stderr, "^error: |libgomp: Out of memory")
            self.assertEqual(sorted(os.listdir(self.folder)), before)

    def test_check(self):
        self.check_each("check", example("box"))

    def test_report(self):
        self.run_command("build", example("box"), "-o", "x.tsolid", "--effort", "none")
        self.check_each("report", "x.tsolid", "--json", "-", "--threads", "1")


class SchemaTest(CommandTest):
    def test_examples_and_written_files_match(self):
        validator = jsonschema.Draft7Validator(schema("boundary"))
        names = [n for n in os.listdir(EXAMPLES) if n.endswith(".tsb")]
        self.assertGreater(len(names), 5)
        self.cube_file()
        for path in [os.path.join(EXAMPLES, n) for n in names] + [self.path("cube.tsb")]:
            validator.validate(json.loads(read(path).decode("utf-8")))

    def test_schema_and_reader_refuse_the_same(self):
        """A key added, dropped or of another type: neither accepts it."""
        validator = jsonschema.Draft7Validator(schema("boundary"))
        good = json.loads(read(example("sphere")).decode("utf-8"))

        def changed(change):
            document = json.loads(json.dumps(good))
            change(document)
            return document

        bad = [
            changed(lambda d: d.update(comment="x")),
            changed(lambda d: d.pop("format")),
            changed(lambda d: d.update(version=2)),
            changed(lambda d: d.update(tolerance=0)),
            changed(lambda d: d.update(patches=[])),
            changed(lambda d: d["patches"][0].update(weight=1)),
            changed(lambda d: d["patches"][0].pop("knots")),
            changed(lambda d: d["patches"][0].update(degree=[1, 26])),
            changed(lambda d: d["patches"][0].update(degree=[1.5, 2])),
            changed(lambda d: d["patches"][0].update(name=None)),
            changed(lambda d: d["patches"][0]["points"].append([1, 2])),
            changed(lambda d: d["patches"][0].update(border_names=["a"])),
        ]
        for k, document in enumerate(bad):
            self.assertFalse(validator.is_valid(document), k)
            self.check_fails("File", "check", self.write("bad.tsb", json.dumps(document)))
        self.assertTrue(validator.is_valid(good))


class LocaleTest(CommandTest):
    def test_decimal_comma(self):
        """The command never asks for the user's locale; the library's own test sets one."""
        results = []
        for locale in ("C", "de_DE.UTF-8"):
            run = self.run_command(
                "build", example("box"), "-o", "x.tsolid", "--effort", "none", "--report", "x.json",
                env=dict(os.environ, LC_ALL=locale),
            )
            self.assertEqual(run.returncode, 0)
            report = json.loads(read(self.path("x.json")).decode())
            del report["timing"]
            results.append((read(self.path("x.tsolid")), report))
        self.assertEqual(results[0], results[1])


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
