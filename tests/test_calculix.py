#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""CalculiX reads the hexahedra and computes with them what theory says.

Constant stress on bent parts, a cantilever against Timoshenko's beam, the lowest frequencies of a
bar, and a propeller blade that runs to the end."""

import math
import os
import re
import subprocess
import sys
import tempfile
import unittest

import numpy

import binding_parts
from binding_parts import binding

sys.path.insert(0, os.path.join(binding_parts.ROOT, "resources"))
from examples.assemblies import ASSEMBLIES  # noqa: E402
from examples.splines import write_tsb  # noqa: E402
from freecad.tsolid import analysis  # noqa: E402
from freecad.tsolid.assembly import Assembly  # noqa: E402

E, NU, DENSITY = 210e3, 0.3, 7.85e-9  # steel in N, mm, tonnes


def build(patches):
    context = binding.Context()
    boundary = binding.Boundary.create(context, patches)
    space = binding.Space.create(context, boundary, binding.TMesh.create(context, boundary))
    return binding.Solid.create(context, space).optimised(context)


def bar(length, height, width):
    """Its length runs along the cube's second axis: corner 0 is followed by the least neighbour."""
    return binding_parts.cube(lambda x, y, z: (length * x, width * y, height * z))


def example(name):
    return binding_parts.read_example(name)


def stress_of_strain(strain):
    shear = E / (2 * (1 + NU))
    volume = E * NU / ((1 + NU) * (1 - 2 * NU)) * numpy.trace(strain)
    return 2 * shear * strain + volume * numpy.eye(3)


class Deck:
    """One run of CalculiX in a folder of its own."""

    def __init__(self, folder, mesh, regions, context):
        self.folder = folder
        mesh.write_inp(context, os.path.join(folder, "mesh.inp"))
        self.nodes = numpy.array(mesh.nodes)
        self.lines = [
            "*INCLUDE, INPUT=mesh.inp",
            "*MATERIAL, NAME=STEEL",
            "*ELASTIC",
            "%g, %g" % (E, NU),
            "*DENSITY",
            "%g" % DENSITY,
            "*SOLID SECTION, ELSET=Eall, MATERIAL=STEEL",
        ]

    def run(self, *lines):
        with open(os.path.join(self.folder, "job.inp"), "w") as stream:
            stream.write("\n".join(self.lines + list(lines)) + "\n")
        run = subprocess.run(
            ["ccx", "-i", "job"],
            cwd=self.folder,
            env=dict(os.environ, OMP_NUM_THREADS="1", CCX_NPROC_STIFFNESS="1"),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        text = run.stdout.decode("utf-8", "replace")
        if run.returncode or "Job finished" not in text or "ERROR" in text:
            raise AssertionError("CalculiX failed:\n" + text[-2000:])
        with open(os.path.join(self.folder, "job.dat")) as stream:
            return stream.read()


def table(text, heading):
    """The rows of numbers below a heading of the .dat file."""
    rows = []
    for line in text[text.index(heading) :].splitlines()[1:]:
        words = line.split()
        if not words:
            if rows:
                break
            continue
        try:
            rows.append([float(w) for w in words])
        except ValueError:
            break
    return numpy.array(rows)


class CalculixTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = holder.name

    def deck(self, patches, **options):
        self.context = binding.Context()
        self.solid = build(patches)
        self.mesh = analysis.HexMesh.create(self.context, self.solid, **options)
        self.assertTrue(self.mesh.proved)
        self.assertGreater(self.mesh.worst, 0)
        return Deck(self.folder, self.mesh, self.mesh.regions, self.context)

    def assembly_deck(self, parts, **options):
        """Of parts by their names, bonded where they touch."""
        self.context = binding.Context()
        paths = [os.path.join(self.folder, name + ".tsb") for name in parts]
        for path, patches in zip(paths, parts.values()):
            write_tsb(patches, path)
        assembly = Assembly.create(self.context, list(zip(parts, paths)))
        solids = []
        for k in range(len(parts)):
            boundary = assembly.boundary(self.context, k)
            tmesh = binding.TMesh.create(self.context, boundary)
            space = binding.Space.create(self.context, boundary, tmesh)
            solids.append(binding.Solid.create(self.context, space).optimised(self.context))
        joined = assembly.joined(self.context, solids)
        self.mesh = analysis.HexMesh.of_assembly(self.context, joined, solids, **options)
        self.assertTrue(self.mesh.proved)
        self.assertGreater(self.mesh.worst, 0)
        self.assertGreater(self.mesh.n_shared, 0)
        self.assertEqual(list(self.mesh.parts), list(parts))
        return Deck(self.folder, self.mesh, self.mesh.regions, self.context)

    def face_nodes(self, name):
        """Nodes (from 1) of a set as the deck has it."""
        with open(os.path.join(self.folder, "mesh.inp")) as stream:
            text = stream.read()
        block = re.search(r"\*NSET, NSET=%s\n([^*]*)" % name, text).group(1)
        return [int(w) for w in block.replace(",", " ").split()]

    def test_constant_stress(self):
        gradient = 1e-3 * numpy.array([[1.0, 0.4, -0.2], [0.1, -0.7, 0.3], [0.5, 0.2, 0.6]])
        stress = stress_of_strain(0.5 * (gradient + gradient.T))
        wanted = [stress[i, i] for i in range(3)] + [stress[0, 1], stress[0, 2], stress[1, 2]]
        for name, order in (("wavy_cube", 1), ("elbow", 2), ("sphere", 2), ("wedge", 1)):
            with self.subTest(name=name, order=order):
                deck = self.deck(example(name), order=order, divisions=(3, 3, 4, 2))
                self.check_patch_test(name, deck, gradient, stress, wanted)

    def test_constant_stress_across_contacts(self):
        """Only the free surface is held: inside, the parts hold each other by common nodes."""
        gradient = 1e-3 * numpy.array([[1.0, 0.4, -0.2], [0.1, -0.7, 0.3], [0.5, 0.2, 0.6]])
        stress = stress_of_strain(0.5 * (gradient + gradient.T))
        wanted = [stress[i, i] for i in range(3)] + [stress[0, 1], stress[0, 2], stress[1, 2]]
        for name, order in (("pair", 1), ("pair", 2), ("pair_refined", 2)):
            with self.subTest(name=name, order=order):
                deck = self.assembly_deck(ASSEMBLIES[name](), order=order, size=7.0)
                self.assertTrue(any(r.startswith("contact_") for r in self.mesh.regions))
                self.check_patch_test(name, deck, gradient, stress, wanted)

    def check_patch_test(self, name, deck, gradient, stress, wanted):
        free = [r for r in self.mesh.regions if not r.startswith("contact_")]
        outer = sorted({n for side in free for n in self.face_nodes(side)})
        inner = len(deck.nodes) - len(outer)
        self.assertGreater(inner, 50)
        lines = ["*STEP", "*STATIC", "*BOUNDARY"]
        for node in outer:
            u = gradient @ deck.nodes[node - 1]
            lines += ["%d, %d, %d, %.12e" % (node, d + 1, d + 1, u[d]) for d in range(3)]
        lines += ["*NODE PRINT, NSET=Nall", "U", "*EL PRINT, ELSET=Eall", "S", "*END STEP"]
        data = deck.run(*lines)
        moved = table(data, "displacements")
        self.assertEqual(len(moved), len(deck.nodes))
        exact = deck.nodes @ gradient.T
        error = abs(moved[:, 1:] - exact).max() / abs(exact).max()
        found = table(data, "stresses")[:, 2:8]
        error_s = abs(found - wanted).max() / abs(stress).max()
        print("%s: displacement %.2g, stress %.2g" % (name, error, error_s))
        self.assertLess(error, 1e-6)
        self.assertLess(error_s, 1e-6)

    def test_cantilever(self):
        length, height, width, force = 100.0, 10.0, 8.0, 500.0
        deck = self.deck(bar(length, height, width), order=2, divisions=(2, 12, 2, 1))
        pressure = force / (height * width)
        names = self.side_names(deck)
        fixed, loaded = self.face_nodes(names["x_low"]), names["x_high"]
        lines = ["*STEP", "*STATIC", "*BOUNDARY"]
        lines += ["%d, 1, 3" % n for n in fixed]
        # a shear force as consistent nodal loads of the end face
        loads = self.face_loads(deck, loaded)
        lines += ["*CLOAD"] + ["%d, 3, %.12e" % (n + 1, -pressure * f) for n, f in loads.items()]
        lines += ["*NODE PRINT, NSET=%s" % loaded, "U", "*END STEP"]
        self.assertAlmostEqual(sum(loads.values()), height * width, delta=1e-9 * height * width)
        moved = table(deck.run(*lines), "displacements")[:, 3].mean()
        inertia = width * height**3 / 12
        shear = E / (2 * (1 + NU))
        beam = force * length**3 / (3 * E * inertia)
        beam += force * length / (5.0 / 6.0 * shear * width * height)
        print("cantilever: %.6g, beam theory %.6g, ratio %.4f" % (-moved, beam, -moved / beam))
        self.assertLess(abs(-moved / beam - 1), 0.02)

    def side_names(self, deck):
        """The regions at the ends of the bar along x, whatever the canonical position is."""
        names = {}
        for name in self.mesh.regions:
            x = deck.nodes[[n - 1 for n in self.face_nodes(name)], 0]
            if x.max() - x.min() < 1e-9:
                names["x_high" if x.mean() > 1 else "x_low"] = name
        return names

    def face_loads(self, deck, name):
        """Areas that belong to the nodes of a flat rectangular face of 20-node elements."""
        corner = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1))
        corner += ((1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
        mid = {(0, 1): 8, (1, 2): 9, (2, 3): 10, (0, 3): 11, (4, 5): 12, (5, 6): 13, (6, 7): 14}
        mid.update({(4, 7): 15, (0, 4): 16, (1, 5): 17, (2, 6): 18, (3, 7): 19})
        elements, loads = numpy.array(self.mesh.elements), {}
        s, weight = numpy.polynomial.legendre.leggauss(4)
        for element, face in numpy.array(self.mesh.regions[name]):
            at = corner[face]
            ids = [elements[element][k] for k in at]
            pairs = [tuple(sorted((at[k], at[(k + 1) % 4]))) for k in range(4)]
            ids += [elements[element][mid[pair]] for pair in pairs]
            points = deck.nodes[ids]
            for i in range(4):
                for j in range(4):
                    n, ds, dt = quadratic_shape(s[i], s[j])
                    area = numpy.linalg.norm(numpy.cross(ds @ points, dt @ points))
                    for k, node in enumerate(ids):
                        loads[node] = loads.get(node, 0) + weight[i] * weight[j] * n[k] * area
        return loads

    def test_frequencies(self):
        length, height, width = 200.0, 5.0, 8.0
        deck = self.deck(bar(length, height, width), order=2, divisions=(2, 24, 2, 1))
        fixed = self.face_nodes(self.side_names(deck)["x_low"])
        lines = ["*BOUNDARY"] + ["%d, 1, 3" % n for n in fixed]
        data = deck.run(*lines, "*STEP", "*FREQUENCY", "3", "*END STEP")
        found = table(data, "E I G E N V A L U E   O U T P U T")
        if not len(found):
            found = table(data, "(RAD/TIME)")
        omega = found[:3, 2]
        stiffness = math.sqrt(E / (12 * DENSITY)) / length**2  # of Euler and Bernoulli's beam
        wanted = sorted(k**2 * h * stiffness for k in (1.87510407, 4.69409113) for h in (5.0, 8.0))
        for k in range(3):
            print("frequency %d: %.6g, beam theory %.6g" % (k + 1, omega[k], wanted[k]))
            self.assertLess(abs(omega[k] / wanted[k] - 1), 0.01)

    def test_a_blade_runs_to_the_end(self):
        deck = self.deck(example("propeller_blade"), order=2, size=8.0)
        fixed = self.face_nodes("x_low")
        lines = ["*BOUNDARY"] + ["%d, 1, 3" % n for n in fixed]
        lines += ["*STEP", "*STATIC", "*DSLOAD", "x_high, P, 1.0"]
        lines += ["*NODE PRINT, NSET=Nall", "U", "*END STEP"]
        moved = table(deck.run(*lines), "displacements")
        self.assertEqual(len(moved), len(deck.nodes))
        self.assertTrue(0 < abs(moved[:, 1:]).max() < 1e6)

    def test_the_propeller_runs_to_the_end(self):
        """Shaft held at both ends, pressure on one blade; no tie constraint in the deck."""
        deck = self.assembly_deck(ASSEMBLIES["propeller"](), order=2, size=12.0)
        moved_at = {}
        free = [r for r in self.mesh.regions if r.startswith("shaft_")]
        by_x = sorted(free, key=lambda r: deck.nodes[[n - 1 for n in self.face_nodes(r)], 0].mean())
        fixed = self.face_nodes(by_x[0])
        lines = ["*BOUNDARY"] + ["%d, 1, 3" % n for n in fixed]
        loaded = [r for r in self.mesh.regions if r.startswith("blade1_")]
        lines += ["*STEP", "*STATIC", "*DSLOAD", "%s, P, 0.1" % loaded[0]]
        lines += ["*NODE PRINT, NSET=Nall", "U", "*END STEP"]
        with open(os.path.join(self.folder, "mesh.inp")) as stream:
            text = stream.read()
        self.assertNotIn("*TIE", text.upper() + "\n".join(lines).upper())
        moved = table(deck.run(*lines), "displacements")
        self.assertEqual(len(moved), len(deck.nodes))
        for name, part in self.mesh.parts.items():
            nodes = numpy.unique(numpy.array(self.mesh.elements)[part.start : part.stop])
            moved_at[name] = abs(moved[nodes, 1:]).max()
        print("propeller: largest displacements %s" % moved_at)
        self.assertTrue(all(0 < d < 1e6 for d in moved_at.values()))


def quadratic_shape(s, t):
    """The eight functions of a serendipity quadrilateral and their derivatives."""
    n, ds, dt = numpy.zeros(8), numpy.zeros(8), numpy.zeros(8)
    for k, (a, b) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1))):
        f, g, h = 1 + a * s, 1 + b * t, a * s + b * t - 1
        n[k], ds[k], dt[k] = f * g * h / 4, (a * g * h + f * g * a) / 4, (b * f * h + f * g * b) / 4
    for k, sign in ((4, -1), (6, 1)):
        along, across = 1 - s * s, 1 + sign * t
        n[k], ds[k], dt[k] = along * across / 2, -s * across, sign * along / 2
    for k, sign in ((5, 1), (7, -1)):
        along, across = 1 - t * t, 1 + sign * s
        n[k], ds[k], dt[k] = along * across / 2, sign * along / 2, -t * across
    return n, ds, dt


if __name__ == "__main__":
    sys.exit(binding_parts.run(sys.modules[__name__]))
