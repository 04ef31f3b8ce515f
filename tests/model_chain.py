# SPDX-License-Identifier: LGPL-2.1-or-later
"""A model of table 1 through the whole chain, and everything checked on what came out."""
import itertools
import json
import os
import random

import numpy as np

import binding_parts
from binding_parts import binding
from example_chain import command_path, run_command  # noqa: F401  (puts resources on the path)
from tsm_surface import TsmSurface

from examples.cube_mesh import write_bezier_tsb, write_tsm
from examples.models import MODELS

DISTANCE, SUM, POINTS_PER_SIDE = 1e-12, 1e-12, 1000


class ModelChain:
    """One model, built: its files, the report, and an independent look at them."""

    def __init__(self, name, folder, carrier, *options):
        self.name, self.mesh = name, MODELS[name]()
        tsm, self.given = (os.path.join(folder, name + e) for e in (".tsm", "." + carrier))
        write_tsm(self.mesh, tsm)
        if carrier == "tsb":
            write_bezier_tsb(self.mesh, self.given)
        with open(tsm, encoding="utf-8") as source:
            self.surface = TsmSurface(source.read())
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

    def distance(self, solid, count=POINTS_PER_SIDE):
        """Largest distance of the solid's boundary from the surface, at random points per side;
        and by how much the surface's functions miss the sum one."""
        draw, worst, missing, free = random.Random(self.name), 0.0, 0.0, set(range(6))
        for number, side in enumerate(self.surface.sides):
            at = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
            at += [(draw.random(), draw.random()) for _ in range(count - 4)]
            expected = np.array([self.surface.point(number, x * side.size[0], y * side.size[1])
                                 for x, y in at])
            missing = max(missing, np.abs(expected[:, 3] - 1).max())
            expected = expected[:, :3]

            def away(placing, some):
                return max(np.linalg.norm(self.on_solid(solid, placing, *at[k]) - expected[k])
                           for k in some)

            ways = [(s,) + w for s in free for w in itertools.product((0, 1), repeat=3)]
            placing = min(ways, key=lambda way: away(way, range(12)))
            free.discard(placing[0])
            worst = np.fmax(worst, away(placing, range(count)))
        return float(worst), float(missing)

    def on_solid(self, solid, placing, x, y):
        side, swap, flip_x, flip_y = placing
        x, y = 1 - x if flip_x else x, 1 - y if flip_y else y
        block, u = solid.boundary_point(side, *((y, x) if swap else (x, y)))
        return np.array(solid.evaluate(self.context, block, u)[0])

    def read_back(self):
        self.context = binding.Context()
        return binding.Solid.read(self.context, self.path)

    def failures(self, least_ratio):
        """All that is not as it must be, as a list of sentences."""
        if self.code != 0:
            return ["exit code %d: %s" % (self.code, self.text.strip()[-600:])]
        solid, scale, r = self.read_back(), self.scale(), self.report
        basis, continuity, conformity = r["basis"], r["continuity"], r["conformity"]
        certificate, quality, numbers = r["certificate"], r["quality"], r["statistics"]
        self.worst_distance, missing = self.distance(solid)
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


__all__ = ["ModelChain", "binding_parts", "command_path"]
