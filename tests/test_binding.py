#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The ctypes binding: mirrors tsolid.h, refuses wrong libraries, keeps memory and errors."""

import ctypes
import gc
import os
import re
import subprocess
import sys
import tempfile
import unittest
from ctypes import POINTER, c_char, c_char_p, c_double, c_int, c_size_t, c_void_p

import binding_parts
from binding_parts import ROOT, binding, header, library

HEADERS = [os.path.join(ROOT, "libtsolid", "include", name)
           for name in ("tsolid.h", "tsolid_assembly.h", "tsolid_analysis.h")]


def read_header():
    text = ""
    for path in HEADERS:
        with open(path, encoding="utf-8") as stream:
            text += stream.read()
    return re.sub(r"/\*.*?\*/", " ", text, flags=re.S)


def fields_of(body):
    """(name, C type, array shape) of each field of a struct's body."""
    out = []
    for statement in filter(None, (s.strip() for s in body.split(";"))):
        head = re.match(r"((?:const\s+)?\w+)\b(.*)", statement, re.S)
        for declarator in head.group(2).split(","):
            stars = declarator.count("*")
            name = re.search(r"\w+", declarator.replace("const", " ")).group()
            shape = tuple(int(n) for n in re.findall(r"\[(\d+)\]", declarator))
            out.append((name, head.group(1).replace("const", "").strip() + "*" * stars, shape))
    return out


def ctype_of(c_type):
    """The ctypes type that a C type of the header must be mirrored by."""
    plain = {
        "int": c_int,
        "char": c_char,
        "double": c_double,
        "size_t": c_size_t,
        "void": None,
        "char*": c_char_p,
        "char**": POINTER(c_char_p),
        "void*": c_void_p,
        "int*": POINTER(c_int),
        "double*": POINTER(c_double),
        "double**": POINTER(POINTER(c_double)),
        "size_t*": POINTER(c_size_t),
    }
    if c_type in plain:
        return plain[c_type]
    base, stars = c_type.rstrip("*"), c_type.count("*")
    if base in header.CALLBACKS and stars == 0:
        return header.CALLBACKS[base]
    if base in header.ENUMS and stars == 0:
        return c_int
    if base in header.OPAQUE:
        return {1: c_void_p, 2: POINTER(c_void_p)}[stars]
    struct = header.STRUCTS[base]
    return {0: struct, 1: POINTER(struct)}[stars]


def with_shape(ctype, shape):
    for n in reversed(shape):
        ctype = ctype * n
    return ctype


class Mirror(unittest.TestCase):
    """Drift between tsolid.h and header.py."""

    text = read_header()

    def test_version_and_abi(self):
        self.assertIn('#define TSOLID_VERSION "%s"' % header.VERSION, self.text)
        self.assertRegex(self.text, r"#define TSOLID_ABI %d\b" % header.ABI)

    def test_enums(self):
        found = {}
        for body, name in re.findall(r"typedef enum \w+ \{(.*?)\} (\w+);", self.text, re.S):
            names, value = [], -1
            for item in filter(None, (x.strip() for x in body.split(","))):
                given = re.match(r"(\w+)(?:\s*=\s*(\d+))?$", item)
                value = int(given.group(2)) if given.group(2) else value + 1
                names.append((given.group(1)[len("TSOLID_") :], value))
            found[name] = names
        mine = {n: [(m.name, m.value) for m in e] for n, e in header.ENUMS.items()}
        self.assertEqual(found, mine)

    def test_structs(self):
        found = re.findall(r"typedef struct (\w+) \{(.*?)\} (\w+);", self.text, re.S)
        self.assertEqual([name for _, _, name in found], list(header.STRUCTS))
        for tag, body, name in found:
            self.assertEqual(tag, name)
            want = [(n, with_shape(ctype_of(t), shape)) for n, t, shape in fields_of(body)]
            self.assertEqual(header.STRUCTS[name]._fields_, want, name)

    def test_opaque(self):
        found = re.findall(r"typedef struct (\w+) (\w+);", self.text)
        self.assertTrue(all(a == b for a, b in found))
        self.assertEqual(tuple(a for a, _ in found), header.OPAQUE)

    def test_callbacks(self):
        found = re.findall(r"typedef (\w+ \*?)\(\*(\w+)\)\((.*?)\);", self.text, re.S)
        self.assertEqual([name for _, name, _ in found], list(header.CALLBACKS))
        for result, name, arguments in found:
            mine = header.CALLBACKS[name]
            self.assertEqual(mine._restype_, ctype_of(result.replace(" ", "")), name)
            self.assertEqual(list(mine._argtypes_), self.arguments(arguments), name)

    @staticmethod
    def arguments(text):
        if text.strip() == "void":
            return []
        out = []
        for name, c_type, shape in (fields_of(a)[0] for a in text.split(",")):
            out.append(ctype_of(c_type + "*" * len(shape)))
        return out

    def test_functions(self):
        pattern = r"TSOLID_API\s+((?:const\s+)?\w+[\s*]+)(tsolid_\w+)\((.*?)\);"
        found = re.findall(pattern, self.text, re.S)
        declared = re.findall(r"^TSOLID_API\b", self.text, re.M)  # the #define lines do not count
        self.assertEqual(len(found), len(declared))
        self.assertEqual([name for _, name, _ in found], list(header.FUNCTIONS))
        for result, name, arguments in found:
            mine = header.FUNCTIONS[name]
            c_type = result.replace("const", "").replace(" ", "").replace("\n", "")
            self.assertEqual(mine[0], ctype_of(c_type), name)
            self.assertEqual(mine[1], self.arguments(arguments), name)


class Vetting(unittest.TestCase):
    """A missing or wrong library gives one clear sentence."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def refused(self, path, words):
        with self.assertRaises(library.LibraryError) as caught:
            library.load(path)
        text = str(caught.exception)
        self.assertIn(words, text)
        self.assertNotIn("\n", text)
        return text

    def compiled(self, source):
        path = os.path.join(self.folder.name, "libfake%d.so" % len(os.listdir(self.folder.name)))
        with open(path + ".c", "w", encoding="utf-8") as stream:
            stream.write(source)
        subprocess.run(["cc", "-shared", "-fPIC", "-o", path, path + ".c"], check=True)
        return path

    def fake(self, wrong="", missing=""):
        """A library with all functions, right sizes but for `wrong`, and without `missing`."""
        rows = []
        for name, struct in header.STRUCTS.items():
            size = ctypes.sizeof(struct) + (8 if name == wrong else 0)
            rows.append('if (!strcmp(n, "%s")) return %d;' % (name, size))
        source = "#include <string.h>\nint tsolid_abi(void) { return %d; }\n" % header.ABI
        source += "size_t tsolid_struct_size(const char *n) { %s return 0; }\n" % " ".join(rows)
        for name in header.FUNCTIONS:
            if name not in ("tsolid_abi", "tsolid_struct_size", missing):
                source += "void %s(void) {}\n" % name
        return self.compiled(source)

    def test_missing(self):
        self.refused(os.path.join(self.folder.name, "none.so"), "does not exist")

    def test_not_a_library(self):
        path = os.path.join(self.folder.name, "text.so")
        with open(path, "w", encoding="utf-8") as stream:
            stream.write("text")
        self.refused(path, "cannot be loaded")

    def test_alien_library(self):
        self.refused(self.compiled("int other(void) { return 1; }"), "not a tsolid library")

    def test_other_abi(self):
        text = "int tsolid_abi(void) { return %d; }" % (header.ABI + 1)
        self.assertIn(
            str(header.ABI + 1), self.refused(self.compiled(text), "has ABI number")
        )

    def test_right_fake_is_taken(self):
        library.load(self.fake())

    def test_other_struct_size(self):
        for name in header.STRUCTS:
            self.refused(self.fake(wrong=name), name)

    def test_missing_function(self):
        self.refused(self.fake(missing="tsolid_write_vtu"), "it has no tsolid_write_vtu")

    def test_nothing_anywhere(self):
        """With no explicit path, the sentence says what to do (in a process of its own)."""
        code = (
            "import sys; sys.path.insert(0, %r); from freecad.tsolid import library\n"
            "library._HERE = '/nonexistent'; library._from_loader = lambda: (None, None)\n"
            "try: library.load()\n"
            "except library.LibraryError as e: print(e)\n" % binding_parts.PACKAGE
        )
        environment = {k: v for k, v in os.environ.items() if k != "TSOLID_LIBRARY"}
        run = subprocess.run(
            ["/usr/bin/python3", "-c", code], env=environment, capture_output=True, text=True
        )
        self.assertIn("was not found", run.stdout, run.stderr)
        self.assertIn("TSOLID_LIBRARY", run.stdout)

    def test_real_library(self):
        real = binding_parts.library_path()
        loaded = library.load(real)
        self.assertEqual(loaded.tsolid_version().decode(), header.VERSION)
        self.assertEqual(loaded.tsolid_struct_size(b"no such struct"), 0)


class Calls(unittest.TestCase):
    """Errors, callbacks and lifetimes with the real library."""

    @classmethod
    def setUpClass(cls):
        cls.real = library.load(binding_parts.library_path())

    def context(self, **options):
        return binding.Context(library=self.real, **options)

    def test_refusal_has_findings_with_names(self):
        patches = binding_parts.cube()[:5]
        context = self.context()
        with self.assertRaises(binding.Refused) as caught:
            binding.Boundary.create(context, patches)
        self.assertEqual(caught.exception.requirement["satisfied"], 0)
        places = {f.where for f in caught.exception.findings}
        # Face6 is left out: its four edges belong to one face each
        self.assertTrue(places & set(binding_parts.cube()[5].border_names), places)
        self.assertTrue(all(f.text for f in caught.exception.findings))
        self.assertEqual(len(context.findings()), len(caught.exception.findings))
        context.clear()
        self.assertEqual(context.findings(), [])

    def test_bad_numbers_are_errors_not_crashes(self):
        for place, value in (("points", float("nan")), ("weights", -1.0), ("weights", 0.0)):
            patches = binding_parts.cube()
            if place == "points":
                patches[2].points[1] = (value, 0.0, 0.0)
            else:
                patches[2].weights = [1.0] * 3 + [value]
            with self.assertRaises(binding.TsolidError) as caught:
                binding.Boundary.create(self.context(), patches)
            self.assertEqual(caught.exception.status, header.Status.ERROR_INPUT)
            self.assertIn("Face3", str(caught.exception))

    def test_wrong_lengths(self):
        with self.assertRaises(ValueError):
            binding.Patch((1, 1), (2, 2), ((0, 0, 1, 1), (0, 0, 1)), [(0, 0, 0)] * 4)
        with self.assertRaises(ValueError):
            binding.Patch((1, 1), (2, 2), ((0, 0, 1, 1),) * 2, [(0, 0, 0)] * 3)

    def solid(self, context, patches=None):
        boundary = binding.Boundary.create(context, patches or binding_parts.cube())
        space = binding.Space.create(context, boundary, binding.TMesh.create(context, boundary))
        return binding.Solid.create(context, space)

    def test_placement_maps_every_corner(self):
        """S(u,v) of each patch is the boundary's own point at the mapped (s,t)."""
        context = self.context()
        patches = binding_parts.cube(lambda x, y, z: (2 * x + 0.3 * y * z, 3 * y, z - x * y))
        boundary = binding.Boundary.create(context, patches)
        corner = boundary.requirement["corner"]
        for k, patch in enumerate(patches):
            place = boundary.placement(k)
            for (u, v), index in (((0, 0), 0), ((1, 0), 1), ((0, 1), 2), ((1, 1), 3)):
                s, t = place.map(u, v)
                axis, end = divmod(place.side, 2)
                bits = [0, 0, 0]
                others = [a for a in range(3) if a != axis]
                bits[axis], bits[others[0]], bits[others[1]] = end, round(s), round(t)
                got = corner[bits[0] + 2 * bits[1] + 4 * bits[2]]
                self.assertEqual(tuple(got), tuple(patch.points[index]))
        with self.assertRaises(binding.TsolidError):
            boundary.placement(6)

    def test_views_are_read_only_and_keep_their_owner(self):
        context = self.context()
        boundary = binding.Boundary.create(context, binding_parts.cube())
        points = boundary.points
        before = points.tolist()
        self.assertTrue(points.readonly)
        with self.assertRaises(TypeError):
            points[0, 0] = 1.0
        alive = boundary._finalizer
        del boundary, context
        gc.collect()
        self.assertTrue(alive.alive)
        self.assertEqual(points.tolist(), before)
        del points
        gc.collect()
        self.assertFalse(alive.alive)

    def test_borrowed_handles_keep_the_solid(self):
        solid = self.solid(self.context())
        alive, control = solid._finalizer, solid.boundary.points
        want = solid.control.tolist()[-len(control) :]
        del solid
        gc.collect()
        self.assertTrue(alive.alive)
        self.assertEqual(control.tolist(), want)

    def test_progress_exception_comes_back(self):
        class Mine(Exception):
            pass

        def raising(stage, fraction):
            raise Mine(stage)

        def interrupting(stage, fraction):
            raise KeyboardInterrupt

        for progress, error in ((raising, Mine), (interrupting, KeyboardInterrupt)):
            context = self.context(progress=progress)
            with self.assertRaises(error):
                self.solid(context).optimised(context)

    def test_cancel_and_progress(self):
        calls = []
        context = self.context(progress=lambda stage, fraction: calls.append((stage, fraction)))
        self.solid(context).optimised(context)
        self.assertGreater(len(calls), 3)
        self.assertTrue(all(stage and 0.0 <= f <= 1.0 for stage, f in calls), calls)
        context = self.context(progress=lambda stage, fraction: True)
        with self.assertRaises(binding.Cancelled):
            self.solid(context).optimised(context)

    def test_control_goes_in_and_out(self):
        context = self.context()
        solid = self.solid(context)
        control = solid.control.tolist()
        again = binding.Solid.from_control(context, solid.space, control)
        self.assertEqual(again.control.tolist(), control)
        control[-1][0] += 1e-9
        with self.assertRaises(binding.TsolidError):
            binding.Solid.from_control(context, solid.space, control)

    def test_evaluate_invert_extraction(self):
        context = self.context()
        solid = self.solid(context)
        u = (0.3, 0.4, 0.7)
        (x,) = solid.evaluate(context, 0, u)
        block, back, distance = solid.invert(context, x)
        self.assertEqual(block, 0)
        self.assertLess(max(abs(a - b) for a, b in zip(u, back)), 1e-8)
        self.assertIsNone(solid.invert(context, (5.0, 5.0, 5.0)))
        self.assertEqual(len(solid.evaluate(context, 0, u, 2)), 10)
        functions, rows = solid.space.extraction(context, 0)
        net = [0.0] * (4 * len(rows[0]))
        control = solid.control
        for f, row in zip(functions, rows):
            for i, c in enumerate(row):
                for d in range(4):
                    net[4 * i + d] += c * control[f, d]
        mine = solid.bezier(context, 0)
        self.assertLess(max(abs(a - b) for a, b in zip(net, mine)), 1e-14)

    def test_certificate_and_files(self):
        context = self.context()
        solid = self.solid(context).optimised(context)
        certificate = binding.Certificate.of(context, solid)
        self.assertEqual(certificate.verdict, header.Verdict.POSITIVE)
        self.assertEqual(len(certificate.element_verdicts), solid.space.n_elements)
        with tempfile.TemporaryDirectory() as folder:
            first, second = (os.path.join(folder, n) for n in ("a b\n.tsolid", "c.tsolid"))
            solid.write(context, first)
            again = binding.Solid.read(context, first)
            again.write(context, second)
            with open(first, "rb") as a, open(second, "rb") as b:
                self.assertEqual(a.read(), b.read())
            self.assertEqual(again.control.tolist(), solid.control.tolist())
            patches = binding_parts.cube()
            path = os.path.join(folder, "p.tsb")
            binding.write_tsb(context, patches, path)
            for mine, read in zip(patches, binding.BoundaryFile.read(context, path).patches()):
                for slot in binding.Patch.__slots__:
                    self.assertEqual(getattr(mine, slot), getattr(read, slot), slot)
            with self.assertRaises(binding.TsolidError):
                solid.write(context, os.path.join(folder, "none", "x.tsolid"))

    def test_inverted_element_is_refused(self):
        line = [(i & 1, (i >> 1) & 1, i >> 2) for i in range(8)]
        right = [(x, y, z, 1.0) for x, y, z in line]
        wrong = [(-x, y, z, 1.0) for x, y, z in line]
        context = self.context()
        for points, verdict in ((right, "POSITIVE"), (wrong, "NOT_POSITIVE")):
            got = binding.Certificate.of_element(context, (1, 1, 1), points).verdict
            self.assertEqual(got.name, verdict)

    def test_report(self):
        context = self.context()
        solid = self.solid(context).optimised(context)
        report = binding.Report.measure(context, solid)
        report.set_times(boundary=1.5)
        facts = report.facts()
        self.assertEqual(facts["timing"]["boundary"], 1.5)
        self.assertAlmostEqual(facts["conformity"]["volume"], 1.0, delta=1e-12)


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
