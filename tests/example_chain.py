# SPDX-License-Identifier: LGPL-2.1-or-later
"""A part through the whole chain by the command, and everything checked on what came out.

What the command says about itself is checked against the part as given: points by the splines of
resources/examples on the original patches, volume by the flux through them.
"""
import json
import os
import random
import subprocess
import tempfile
import time
import unittest

import numpy as np

import binding_parts
from binding_parts import binding
from rewrite_part import moved, one_side_raised, rescaled_at_random, shuffled, through_step

from examples.splines import Patch, write_tsb

DISTANCE, SUM, VOLUME = 1e-12, 1e-12, 1e-12
POINTS_PER_FACE = 1000

# Their sides meet in the same curves, raised and refined apart: rows may differ by round-off.
OWN_SIDES = {"mixed_sides"}


def command_path():
    given = os.environ.get("TSOLID_COMMAND")
    return given or os.path.join(os.path.dirname(binding_parts.library_path()), "tsolid")


def run_command(*arguments):
    """Exit code, what it said, seconds."""
    start = time.perf_counter()
    run = subprocess.run([command_path()] + list(arguments), stdin=subprocess.DEVNULL,
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    seconds = time.perf_counter() - start
    return run.returncode, run.stdout.decode("utf-8", "replace"), seconds


def scale_of(patches):
    return scale_of_points(np.concatenate([p.homogeneous().reshape(-1, 4) for p in patches]))


def scale_of_points(homogeneous):
    """The larger of the bounding box's diagonal and the largest coordinate."""
    points = homogeneous[:, :3] / homogeneous[:, 3:]
    return max(np.linalg.norm(points.max(axis=0) - points.min(axis=0)), np.abs(points).max())


def outward(placement):
    """+1 where S_u x S_v of a patch points out of the solid, from where it lies on the cube."""
    axis, end = divmod(placement.side, 2)
    sign = (1 if end else -1) * (-1 if axis == 1 else 1)
    return sign * (-1) ** (bool(placement.swap) + bool(placement.flip[0]) + bool(placement.flip[1]))


def volume_within(patches, placements):
    """By the flux of x/3 through the patches as given; about their middle, against cancellation.

    placements: all pieces of each patch.
    """
    middle = np.mean([p.points.mean(axis=(0, 1)) for p in patches], axis=0)
    total = 0.0
    for patch, placement in zip(patches, placements):
        shifted = Patch(patch.degree, patch.knots, patch.points - middle, patch.weights)
        total += outward(placement[0]) * shifted.flux()
    return total


class Chain:
    """One part, built: its files, the report, and what an independent look at them shows."""

    def __init__(self, patches, folder, name, *options):
        self.patches, self.name = patches, name
        self.given = os.path.join(folder, name + ".tsb")
        self.path = os.path.join(folder, name + ".tsolid")
        self.report_path = os.path.join(folder, name + ".json")
        self.vtu_path = os.path.join(folder, name + ".vtu")
        write_tsb(patches, self.given)
        self.code, self.text, self.seconds = run_command(
            "build", self.given, "-o", self.path, "--report", self.report_path,
            "--vtu", self.vtu_path, *options)
        self.report = None
        if self.code != 1:
            with open(self.report_path, encoding="utf-8") as source:
                self.report = json.load(source)

    def read_back(self):
        """The solid from its file alone; the prepared boundary and placements from the part."""
        self.context = binding.Context()
        self.solid = binding.Solid.read(self.context, self.path)
        self.prepared = binding.Boundary.from_file(self.context, self.given)
        self.placements = [self.prepared.placements(k) for k in range(len(self.patches))]

    def declared(self, side):
        """How far the report says control points of a side were moved."""
        preparation = self.report["preparation"]
        moves = [preparation["snap_inside"][side]]
        axis, end = divmod(side, 2)
        for isoline in range(12):
            along, ends = divmod(isoline, 4)
            others = [a for a in range(3) if a != along]
            if axis != along and (ends >> others.index(axis) & 1) == end:
                moves.append(preparation["snap"][isoline])
        return max(moves)

    def distance(self, solid, count=POINTS_PER_FACE, seed=0):
        """Largest distance beyond what is declared, at random points of the faces as given."""
        draw = random.Random("%s/%d" % (self.name, seed))
        worst = 0.0
        for patch, placements in zip(self.patches, self.placements):
            declared = max(self.declared(place.side) for place in placements)
            (u0, u1), (v0, v1) = patch.domain()
            u = [u0, u1, u0, u1] + [draw.uniform(u0, u1) for _ in range(count - 4)]
            v = [v0, v0, v1, v1] + [draw.uniform(v0, v1) for _ in range(count - 4)]
            expected = patch.evaluate(u, v)
            found = np.empty_like(expected)
            for k, (a, b) in enumerate(zip(u, v)):
                block, place = solid.boundary_point(*placements.locate(a, b))
                found[k] = solid.evaluate(self.context, block, place)[0]
            away = np.linalg.norm(found - expected, axis=1).max()
            worst = np.fmax(worst, away - declared) if away == away else np.inf
        return float(worst)

    def failures(self, least_ratio=0.5, snapped=False, n_singular=0):
        """All that is not as it must be, as a list of sentences; n_singular: corners of the input
        where no solid has det J > 0, so that quality says nothing."""
        if self.code != 0:
            return ["exit code %d: %s" % (self.code, self.text.strip()[-600:])]
        self.read_back()
        scale, r = scale_of(self.patches), self.report
        basis, continuity, conformity = r["basis"], r["continuity"], r["conformity"]
        certificate, quality, preparation = r["certificate"], r["quality"], r["preparation"]
        prepared_scale = scale_of_points(np.array(self.prepared.points))
        distance = self.distance(self.solid)
        volume = volume_within(self.patches, self.placements)
        n_surface = self.solid.space.n_surface
        layer = self.solid.control.tobytes()[-32 * n_surface:]
        largest_snap = max(preparation["snap"] + preparation["snap_inside"])
        facts = [
            (distance <= DISTANCE * scale, "distance %g at scale %g" % (distance, scale)),
            (abs(conformity["scale"] / prepared_scale - 1) < 1e-12,
             "scale %g" % conformity["scale"]),
            (snapped or largest_snap == 0, "snapped by %g" % largest_snap),
            (largest_snap <= 1e-7, "snapped by %g, beyond the tolerance" % largest_snap),
            (conformity["control_identical"] is True, "boundary control points not identical"),
            (layer == self.prepared.points.tobytes(), "boundary layer is not the boundary"),
            (basis["sum_defect"] <= SUM, "sum defect %g" % basis["sum_defect"]),
            (basis["smallest_value"] >= 0, "negative function %g" % basis["smallest_value"]),
            (basis["rank_measured"] is True, "ranks not measured"),
            (basis["inner_eigenvalue"] > basis["inner_roundoff"] > 0, "inner functions dependent"),
            (basis["surface_eigenvalue"] > basis["surface_roundoff"] > 0,
             "surface functions dependent"),
            (basis["diagonal_jump"] <= 1e-12, "jump %g on a diagonal" % basis["diagonal_jump"]),
            (basis["core_jump"] <= 1e-12, "jump %g on the core" % basis["core_jump"]),
            (continuity["n_faces"] > 0, "no faces measured"),
            (continuity["n_below_expected"] == 0, "%d faces below the expected order"
             % continuity["n_below_expected"]),
            (continuity["area"][0] == 0, "torn area %g" % continuity["area"][0]),
            (certificate["verdict"] == "positive", "certificate " + certificate["verdict"]),
            (certificate["n_positive"] == r["statistics"]["bezier_elements"],
             "%d elements proved positive" % certificate["n_positive"]),
            (certificate["n_singular"] == n_singular == len(certificate["singular"]),
             "%d singular corners" % certificate["n_singular"]),
            (n_singular or quality["worst"] > 0, "worst scaled Jacobian %g" % quality["worst"]),
            (n_singular or quality["ratio"] >= least_ratio, "ratio %.3f to bound %.3f, worst at %s"
             % (quality["ratio"], quality["bound"], quality["worst_point"])),
            (quality["worst"] <= quality["bound"] * (1 + 1e-9) + 1e-13, "better than the bound"),
            (abs(conformity["volume"] - volume) <= VOLUME * abs(volume),
             "volume %.15g, flux %.15g" % (conformity["volume"], volume)),
        ]
        return [text for holds, text in facts if not holds]

    def row(self):
        """A line of the table."""
        if self.report is None:
            return "%-24s exit code %d" % (self.name, self.code)
        r = self.report
        return "%-24s %6d %6d %7.3f %9.4f %6.3f %7.2f  %s" % (
            self.name, r["statistics"]["n_functions"], r["statistics"]["bezier_elements"],
            r["quality"]["bound"], r["quality"]["worst"], r["quality"]["ratio"], self.seconds,
            r["certificate"]["verdict"])


HEADING = "%-24s %6s %6s %7s %9s %6s %7s  %s" % (
    "part", "funcs", "elems", "bound", "worst J", "ratio", "seconds", "certificate")


def rewritings(patches, folder, seed, step=True):
    """(word, patches) of the re-writings that a part must go through."""
    draw = random.Random(seed)
    ways = [("shuffled", shuffled(patches, draw)),
            ("knots", rescaled_at_random(patches, draw)),
            ("raised", one_side_raised(patches, draw.randrange(len(patches)), draw.randrange(2))),
            ("moved", moved(patches, draw))]
    if step:
        ways.append(("step", through_step(patches, folder)))
    return [(word, way.patches) for word, way in ways]


def files_of(chain):
    """The bytes that may not depend on anything but the part; the report without its times."""
    report = {k: v for k, v in chain.report.items() if k != "timing"}
    with open(chain.path, "rb") as solid, open(chain.vtu_path, "rb") as vtu:
        return solid.read(), vtu.read(), json.dumps(report)


class ChainCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name

    def chain(self, patches, name, *options, **expected):
        """Builds, prints its line of the table, and checks everything."""
        chain = Chain(patches, self.folder, name, *options)
        print(chain.row(), flush=True)
        self.assertEqual(chain.failures(**expected), [])
        return chain
