#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Table 1 of Zhang, Wang, Hughes, Conformal solid T-spline construction from boundary T-spline
representations: our models beside the paper's.

    table1.py [--model NAME]... [--effort E] [--threads N] [--check] [--keep DIR] [--picture PNG]

Builds every model with the command that TSOLID_COMMAND names, or that of the newest build tree;
--check also compares the solids with the surfaces and lists all that is not as it must be;
--picture draws all solids, from outside and cut open (needs matplotlib).
"""
import argparse
import os
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

from binding_parts import binding  # noqa: E402
from model_chain import HEADING, PAPER, build, row  # noqa: E402

VIEWS = {"mouse": (1.0, -1.35, 0.8), "boat": (1.0, -0.9, 0.7), "blade_nurbs": (1.0, -0.4, 0.3),
         "blade_tspline": (-1.0, 1.2, 0.3), "shaft": (0.7, -1.2, 0.6), "bunny": (1.0, -1.1, 0.45)}
SIZE = (400, 310)


def draw(solids, path):
    """Pairs of pictures, outside and cut open, two models to a row."""
    from freecad.tsolid import picture
    from matplotlib import colormaps
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    colours = colormaps["viridis"].with_extremes(under="#d62728")
    rows = (len(solids) + 1) // 2
    figure = Figure(figsize=(4 * SIZE[0] / 100, rows * SIZE[1] / 100), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    for k, (name, solid) in enumerate(solids):
        elements = picture.Elements.of(binding.Context(), solid)
        view, corner = picture.choose_view(elements)
        whole = picture.tessellate(elements, np.ones(len(elements), bool))
        opened = picture.tessellate(elements, ~picture.octant(elements, corner))
        for column, (mesh, towards) in enumerate(((whole, VIEWS[name]), (opened, view))):
            image, _ = picture.render(mesh, picture.Camera(towards), *SIZE,
                                      lambda j: colours(np.where(j > 0, j, -1.0))[..., :3])
            axes = figure.add_axes([(k % 2 * 2 + column) / 4, 1 - (k // 2 + 1) / rows,
                                    1 / 4, 1 / rows])
            axes.imshow(image)
            axes.axis("off")
    figure.canvas.draw()
    Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3]).quantize(96).save(
        path, optimize=True)


def main():
    parser = argparse.ArgumentParser(description="Our table 1; see the top of the file.")
    parser.add_argument("--model", action="append", choices=sorted(PAPER), default=[])
    parser.add_argument("--effort", default="default")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--keep", metavar="DIR", help="where the files are to stay")
    parser.add_argument("--picture", metavar="PNG")
    options = parser.parse_args()
    words = ("--effort", options.effort, "--threads", str(options.threads))
    bad, solids = 0, []
    print("ours (the paper's)\n" + HEADING)
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or temporary
        os.makedirs(folder, exist_ok=True)
        for name in options.model or PAPER:
            chain = build(name, folder, *words)
            if chain.report is None:
                print("%-14s %s" % (name, chain.text.strip()))
                bad += 1
                continue
            print(row(name, chain.report, chain.seconds), flush=True)
            if options.picture:
                solids.append((name, binding.Solid.read(binding.Context(), chain.path)))
            for text in chain.failures(0.0) if options.check else ():
                print("%-14s %s" % ("", text))
                bad += 1
    if options.picture:
        draw(solids, options.picture)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
