#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws the kinds of parts of tests/freecad_kinds.py: how the README's picture of them was made.

    make_kinds.py PICTURE.png

FreeCADCmd makes the triangles, matplotlib the picture: green parts are taken, red ones refused.
"""

import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TESTS = os.path.join(ROOT, "tests")
COLUMNS, SIZE, GAP = 10, 1.05, 0.18  # GAP: of the height, for the name
LEFT_OUT = ("two solids", "shell", "open", "wire", "compound of one", "sliver", "rough", "hollow")
TRIANGLES = """
import json, os, sys
sys.path.insert(0, os.environ["KINDS_TESTS"])
import freecad_kinds as kinds
rows = []
makers = [(n, m, True) for n, m in kinds.TAKEN.items()]
makers += [(n, m[0], False) for n, m in kinds.REFUSED.items()]
for name, make, taken in makers:
    shape = make()
    points, triangles = shape.tessellate(shape.BoundBox.DiagonalLength / 400.0)
    rows.append([name, taken, [list(p) for p in points], triangles])
with open(os.environ["KINDS_OUT"], "w", encoding="utf-8") as stream:
    json.dump(rows, stream)
"""


def triangles():
    """Rows of name, taken, points, triangles."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "kinds.json")
        command = os.environ.get("TSOLID_FREECADCMD", "freecadcmd")
        subprocess.run([command, "-c", TRIANGLES], check=True, stdout=subprocess.DEVNULL,
                       env=dict(os.environ, KINDS_TESTS=TESTS, KINDS_OUT=out))
        with open(out, encoding="utf-8") as stream:
            return json.load(stream)


def draw(axes, name, taken, points, faces):
    import numpy as np
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    points = np.array(points)
    corners = points[np.array(faces)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None] + 1e-300
    light = 0.55 + 0.45 * np.abs(normals @ np.array([0.35, -0.5, 0.79]))
    colour = np.array([0.35, 0.72, 0.42] if taken else [0.85, 0.42, 0.38])
    axes.add_collection3d(Poly3DCollection(corners, facecolors=light[:, None] * colour,
                                           edgecolors="none"))
    middle, half = (points.max(0) + points.min(0)) / 2, np.ptp(points, axis=0).max() * 0.46
    for k, limits in enumerate((axes.set_xlim, axes.set_ylim, axes.set_zlim)):
        limits(middle[k] - half, middle[k] + half)
    axes.set_box_aspect((1, 1, 1))
    axes.set_axis_off()
    axes.view_init(24, -58)
    axes.set_title(name, fontsize=5.5, y=-0.13)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    rows = [row for row in triangles() if row[0] not in LEFT_OUT]
    lines = -(-len(rows) // COLUMNS)
    figure = pyplot.figure(figsize=(COLUMNS * SIZE, lines * SIZE * (1 + GAP)))
    for k, row in enumerate(rows):
        draw(figure.add_subplot(lines, COLUMNS, k + 1, projection="3d"), *row)
    figure.subplots_adjust(0, GAP / lines, 1, 1, 0, GAP)
    figure.savefig(sys.argv[1], dpi=100, pil_kwargs={"optimize": True})


if __name__ == "__main__":
    main()
