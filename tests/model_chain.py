# SPDX-License-Identifier: LGPL-2.1-or-later
"""A model of table 1 through the whole chain by the command, and everything checked on what came
out. The surface it is compared with is that of tsm_surface.py."""
import itertools
import json
import os
import random

import numpy as np

from binding_parts import binding
from example_chain import (DISTANCE, POINTS_PER_FACE, SUM, Chain, run_command)

from examples.cube_mesh import write_model, write_tsm
from examples.models import CARRIERS, MODELS, blade_nurbs, file_of
from tsm_surface import TsmSurface

# Table 1 of Y. Zhang, W. Wang, T. J. R. Hughes: Conformal solid T-spline construction from boundary
# T-spline representations. Of each model: input nodes and elements, T-mesh nodes, partial
# extraordinary nodes, Bezier elements, worst and best Jacobian, seconds.
PAPER = {"mouse": (320, 164, 1429, 44, 454, 0.09, 1.00, 1.9),
         "boat": (764, 420, 2852, 56, 1375, 0.07, 1.00, 5.2),
         "blade_nurbs": (442, 256, 1763, 44, 672, 0.02, 1.00, 3.2),
         "blade_tspline": (462, 272, 2083, 64, 1072, 0.03, 1.00, 4.8),
         "shaft": (1002, 512, 3875, 84, 1556, 0.05, 1.00, 10.3),
         "bunny": (1358, 1083, 7537, 85, 7901, 0.01, 1.00, 32.1)}


def surface_of(mesh, folder, name):
    """The mesh by way of a .tsm file: its path, and the surface as that file alone says it."""
    path = os.path.join(folder, name + ".tsm")
    write_tsm(mesh, path)
    with open(path, encoding="utf-8") as source:
        return path, TsmSurface(source.read())


class ModelChain:
    """One model, built: its files, the report, and an independent look at them."""

    def __init__(self, name, folder, *options, carrier=None):
        self.name, self.mesh = name, MODELS[name]()
        carrier = carrier or CARRIERS[name]
        _, self.surface = surface_of(self.mesh, folder, name)
        self.given = os.path.join(folder, file_of(name, carrier))
        write_model(self.mesh, self.given, carrier)
        self.path = os.path.join(folder, name + ".tsolid")
        report = os.path.join(folder, name + ".json")
        self.code, self.text, self.seconds = run_command(
            "build", self.given, "-o", self.path, "--report", report, *options)
        self.report = None
        if self.code != 1:
            with open(report, encoding="utf-8") as source:
                self.report = json.load(source)

    def scale(self):
        points = self.surface.points[:, :3]
        return max(np.linalg.norm(np.ptp(points, axis=0)), np.abs(points).max())

    def distance(self, solid, count=POINTS_PER_FACE):
        """Largest distance of the solid's boundary from the surface, at random points per side;
        and by how much the surface's functions miss the sum one."""
        draw, worst, missing, free = random.Random(self.name), 0.0, 0.0, set(range(6))
        for number, side in enumerate(self.surface.sides):
            at = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
            at += [(draw.random(), draw.random()) for _ in range(count - 4)]
            expected = np.array([self.surface.point(number, x * side.size[0], y * side.size[1])
                                 for x, y in at])
            missing = max(missing, np.abs(expected[:, 3] - 1).max())
            ways = [(s,) + w for s in free for w in itertools.product((0, 1), repeat=3)]
            few = slice(0, 12)
            placing = min(ways, key=lambda w: self.away(solid, w, at[few], expected[few]))
            free.discard(placing[0])
            worst = np.fmax(worst, self.away(solid, placing, at, expected))
        return float(worst), float(missing)

    def away(self, solid, placing, at, expected):
        found = np.array([self.on_solid(solid, placing, x, y) for x, y in at])
        return np.linalg.norm(found - expected[:, :3], axis=1).max()

    def on_solid(self, solid, placing, x, y):
        side, swap, flip_x, flip_y = placing
        x, y = 1 - x if flip_x else x, 1 - y if flip_y else y
        block, u = solid.boundary_point(side, *((y, x) if swap else (x, y)))
        return solid.evaluate(self.context, block, u)[0]

    def read_back(self):
        self.context = binding.Context()
        return binding.Solid.read(self.context, self.path)

    def failures(self, least_ratio):
        """All that is not as it must be, as a list of sentences."""
        if self.code != 0:
            return ["exit code %d: %s" % (self.code, self.text.strip()[-600:])]
        scale, r = self.scale(), self.report
        basis, continuity, conformity = r["basis"], r["continuity"], r["conformity"]
        certificate, quality, numbers = r["certificate"], r["quality"], r["statistics"]
        self.worst_distance, missing = self.distance(self.read_back())
        snapped = max(r["preparation"]["snap"] + r["preparation"]["snap_inside"])
        facts = [
            (self.worst_distance <= DISTANCE * scale,
             "distance %g at scale %g" % (self.worst_distance, scale)),
            (missing <= SUM, "the given functions' sum is off by %g" % missing),
            (r["requirement"]["satisfied"] is True, "requirement not satisfied"),
            (snapped == 0, "snapped by %g" % snapped),
            (conformity["control_identical"] is True, "boundary control points not identical"),
            (basis["sum_defect"] <= SUM, "sum defect %g" % basis["sum_defect"]),
            (basis["smallest_value"] >= 0, "negative function %g" % basis["smallest_value"]),
            (basis["rank_measured"] is True, "ranks not measured"),
            (basis["inner_eigenvalue"] > basis["inner_roundoff"] > 0, "inner functions dependent"),
            (basis["surface_eigenvalue"] > basis["surface_roundoff"] > 0,
             "surface functions dependent"),
            (max(basis["diagonal_jump"], basis["core_jump"]) <= 1e-12, "a function tears"),
            (continuity["n_faces"] > 0, "no faces measured"),
            (continuity["n_below_expected"] == 0, "%d faces below the expected order"
             % continuity["n_below_expected"]),
            (continuity["area"][0] == 0, "torn area %g" % continuity["area"][0]),
            (certificate["verdict"] == "positive", "certificate " + certificate["verdict"]),
            (certificate["n_positive"] == numbers["bezier_elements"],
             "%d elements proved positive" % certificate["n_positive"]),
            (certificate["n_singular"] == 0, "singular corners"),
            (numbers["interior_extraordinary_nodes"] == 8, "%d interior extraordinary nodes"
             % numbers["interior_extraordinary_nodes"]),
            (numbers["input_nodes"] == len(self.mesh.vertices), "%d input nodes"
             % numbers["input_nodes"]),
            (quality["worst"] > 0, "worst scaled Jacobian %g" % quality["worst"]),
            (quality["ratio"] >= least_ratio, "ratio %.3f to bound %.3f, worst at %s"
             % (quality["ratio"], quality["bound"], quality["worst_point"])),
        ]
        return [text for holds, text in facts if not holds]


class NurbsChain(Chain):
    """The blade of NURBS patches, with the checks of the other parts of patches."""

    def __init__(self, name, folder, *options):
        super().__init__(blade_nurbs(), folder, name, *options)

    def failures(self, least_ratio):
        bad = super().failures(least_ratio=least_ratio, snapped=True)
        self.worst_distance = self.distance(self.solid) if self.code == 0 else float("nan")
        return bad + ([] if self.report and
                      self.report["statistics"]["interior_extraordinary_nodes"] == 8
                      else ["not 8 interior extraordinary nodes"])


# T-mesh nodes: distinct places, and functions of the solid, which is one per node and zero-interval
# node and what the paper's numbers are near to.
HEADING = "%-14s %13s %13s %19s %13s %19s %25s %13s" % (
    "model", "nodes", "elements", "T-mesh nodes", "partial", "Bezier elements",
    "Jacobian: worst, best", "seconds")


def build(name, folder, *options):
    return (NurbsChain if name == "blade_nurbs" else ModelChain)(name, folder, *options)


def row(name, report, seconds):
    """A line of table 1: ours (the paper's)."""
    s, paper = report["statistics"], PAPER[name]

    def pair(width, form, ours, theirs, their_form=None):
        return ("%s (%s)" % (form % ours, (their_form or form) % theirs)).rjust(width)

    return " ".join([
        "%-14s" % name, pair(13, "%d", s["input_nodes"], paper[0]),
        pair(13, "%d", s["input_elements"], paper[1]),
        pair(19, "%d, %d", (s["tmesh_nodes"], s["n_functions"]), paper[2], "%d"),
        pair(13, "%d", s["partial_extraordinary_nodes"], paper[3]),
        pair(19, "%d", s["bezier_elements"], paper[4]),
        pair(25, "%.2f, %.2f", (report["quality"]["worst"], report["quality"]["best"]), paper[5:7]),
        pair(13, "%.1f", seconds, paper[7])])
