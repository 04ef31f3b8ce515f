#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Bad parts and files: exit code 1, a clear sentence with the place, nothing written."""
import os
import re
import subprocess
import sys
import tempfile
import unittest

import bad_parts
import binding_parts
from example_chain import command_path

from examples.parts import PARTS
from examples.splines import write_tsb


class BadInputTest(unittest.TestCase):
    def setUp(self):
        base = tempfile.TemporaryDirectory()
        self.addCleanup(base.cleanup)
        self.folder = os.path.join(base.name, "a b\nc")
        os.mkdir(self.folder)
        self.target = os.path.join(self.folder, "target.tsolid")
        with open(self.target, "wb") as target:
            target.write(b"keep me")

    def run_command(self, *arguments):
        run = subprocess.run([command_path()] + list(arguments), stdin=subprocess.DEVNULL,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=60)
        return run.returncode, run.stdout, run.stderr.decode("utf-8", "surrogateescape")

    def refuse(self, path, words):
        """Both commands refuse, say why, and leave the folder as it was."""
        before = sorted(os.listdir(self.folder))
        for command in (["check", path], ["build", path, "-o", self.target, "--vtu",
                                          os.path.join(self.folder, "x.vtu")]):
            code, out, said = self.run_command(*command)
            self.assertEqual(code, 1, said)
            lines = [line for line in said.splitlines() if line.startswith("error: ")]
            self.assertGreaterEqual(len(lines), 1, said)
            self.assertLess(len(said.splitlines()), 40, said)
            for line in lines:
                self.assertRegex(line, r"[A-Za-z]{3,}( \S+){2,}")
                self.assertNotRegex(line, r"(?i)internal|defect|0x[0-9a-f]{6}")
            for word in words:
                self.assertRegex(said, word)
        self.assertEqual(sorted(os.listdir(self.folder)), before)
        with open(self.target, "rb") as target:
            self.assertEqual(target.read(), b"keep me")
        return said

    def refuse_data(self, data, words):
        path = os.path.join(self.folder, "part.tsb")
        with open(path, "wb") as target:
            target.write(data)
        return self.refuse(path, words)

    def test_parts(self):
        path = os.path.join(self.folder, "part.tsb")
        for name, (patches, words) in bad_parts.PARTS.items():
            with self.subTest(name):
                write_tsb(patches, path)
                said = self.refuse(path, words)
                if os.environ.get("TSOLID_TEST_VERBOSE"):
                    print("%s\n%s" % (name, said))

    def test_gap_is_measured(self):
        path = os.path.join(self.folder, "part.tsb")
        for distance in (1e-2, 1e-5):
            write_tsb(bad_parts.edge_moved(distance), path)
            said = self.refuse(path, ["Face3"])
            numbers = [float(x) for x in re.findall(r"\d\.?\d*(?:e[-+]\d+)?", said)]
            # the curve moves by less than its control point, but by a good part of it
            self.assertTrue(any(0.3 * distance < x <= 1.001 * distance for x in numbers), said)

    def test_within_tolerance_is_taken(self):
        path = os.path.join(self.folder, "part.tsb")
        write_tsb(bad_parts.edge_moved(5e-8), path)
        self.assertEqual(self.run_command("check", path)[0], 0)

    def test_files(self):
        for name, (data, words) in bad_parts.FILES.items():
            with self.subTest(name):
                said = self.refuse_data(data, words)
                if os.environ.get("TSOLID_TEST_VERBOSE"):
                    print("%s\n%s" % (name, said))

    def test_truncated_files(self):
        for data in bad_parts.truncated(311):
            with self.subTest(len(data)):
                self.refuse_data(data, [])

    def test_truncated_and_altered_solids(self):
        part, solid = (os.path.join(self.folder, n) for n in ("part.tsb", "part.tsolid"))
        write_tsb(PARTS["box"](), part)
        self.assertNotEqual(self.run_command("build", part, "-o", solid, "--effort", "none")[0], 1)
        with open(solid, "rb") as source:
            data = source.read()
        cases = [data[:k] for k in range(0, len(data), len(data) // 17)]
        cases += [data + b"\0", data[::-1], b"{}"]
        cases += [data[:k] + bytes([data[k] ^ 4]) + data[k + 1:]
                  for k in range(3, len(data), len(data) // 19)]
        picture = os.path.join(self.folder, "x.vtu")
        for k, case in enumerate(cases):
            with open(solid, "wb") as target:
                target.write(case)
            with self.subTest(k):
                for command in (["report", solid], ["export", solid, "--vtu", picture]):
                    code, out, said = self.run_command(*command)
                    self.assertEqual((code, out), (1, b""), said)
                    self.assertRegex(said, "^error: ")
        self.assertFalse(os.path.exists(picture))

    def test_odd_names(self):
        """Blanks, newlines and bytes that are no text in file names; what is there is built."""
        for name in (b"two words.tsb", b"two\nlines.tsb", b"\xff\xfe.tsb", b"-o", b"%s%n.tsb"):
            path = os.path.join(os.fsencode(self.folder), name)
            write_tsb(PARTS["box"](), path)
            with self.subTest(name):
                code, _, said = self.run_command(b"check", path)
                self.assertEqual(code, 0, said)
                code, _, said = self.run_command(b"build", path, b"--effort", b"none", b"-o",
                                                 path + b".tsolid")
                self.assertEqual(code, 0, said)
                self.assertTrue(os.path.getsize(path + b".tsolid") > 1000)
                self.assertEqual(self.run_command(b"check", path + b".missing")[0], 1)

    def test_odd_face_names(self):
        """A face's name may hold anything; the message stays on its line."""
        patches = bad_parts.edge_moved(1.0)
        for patch in patches:
            patch.name = "a\nerror: b \x1b[31m\u20ac %s"
        path = os.path.join(self.folder, "part.tsb")
        write_tsb(patches, path)
        said = self.refuse(path, ["\u20ac %s"])
        self.assertNotIn("\x1b", said)
        self.assertNotIn("\nerror: b", said)

    def test_folded_part_is_never_proved(self):
        """Faces that cross: well-formed, and a solid of positive Jacobian does not exist."""
        patches = PARTS["box"]()
        for patch in patches:
            x = patch.points[..., 0]
            patch.points[..., 0] = (x - 30) * (1 - patch.points[..., 2] / 15)
        path = os.path.join(self.folder, "part.tsb")
        write_tsb(patches, path)
        code, _, said = self.run_command("build", path, "--effort", "quick", "-o",
                                         os.path.join(self.folder, "folded.tsolid"))
        self.assertIn(code, (1, 2), said)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
