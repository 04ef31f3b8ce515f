# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs inside FreeCADCmd: freecad_maker.py KIND PATH makes a file to read, good or bad."""

import os
import shutil
import sys
import tempfile

import binding_parts

binding_parts.join_freecad()

import FreeCAD  # noqa: E402
import Part  # noqa: E402
from FreeCAD import Vector  # noqa: E402

from freecad.tsolid import binding, convert  # noqa: E402

BOX = Part.makeBox(10, 20, 30)


def wavy(x, y, z):
    return 10 * x + y * z, 12 * y - 0.5 * x * z, 8 * z + 0.7 * x * y


def box_patches():
    return binding_parts.cube(lambda x, y, z: (10 * x, 20 * y, 30 * z))


def solid_of(patches):
    return convert.solid_of_patches(patches)


def seven():
    """A box whose top is two faces: seven faces, and no grid of them is a cube's side."""
    low, high = Part.makeBox(10, 20, 30), None
    faces = [f for f in low.Faces if f.CenterOfMass.z < 29.9]
    high = [Part.makePlane(4, 20, Vector(0, 0, 30)), Part.makePlane(6, 20, Vector(4, 0, 30))]
    return Part.makeSolid(Part.makeShell(faces + high))


SHAPES = {
    "box": lambda: BOX,
    "wavy": lambda: solid_of(binding_parts.cube(wavy)),
    "shell": lambda: BOX.Shells[0],
    "open": lambda: Part.makeShell(BOX.Faces[:5]),
    "five": lambda: Part.makeSolid(Part.makeShell(BOX.Faces[:5])),
    "seven": seven,
    "bored": lambda: BOX.cut(Part.makeCylinder(2, 40, Vector(5, 10, -5))),
    "torus": lambda: Part.makeTorus(9, 2),
    "sphere": lambda: Part.makeSphere(5),
    "cylinder": lambda: Part.makeCylinder(2, 9),
    "trimmed": lambda: BOX.cut(Part.makeBox(40, 40, 40, Vector(5, 0, 25), Vector(1, 0, 1))),
    "two": lambda: Part.makeCompound([BOX, Part.makeBox(1, 1, 1, Vector(50, 0, 0))]),
    "none": lambda: Part.makeLine(Vector(0, 0, 0), Vector(1, 0, 0)),
}


def bad_patches(kind):
    patches = box_patches()
    top = patches[5]
    if kind == "gap":
        top.points[0] = (0.0, 0.0, 30.001)
    elif kind == "nan":
        top.points[0] = (0.0, float("nan"), 30.0)
    elif kind == "infinite":
        top.points[0] = (0.0, float("inf"), 30.0)
    elif kind == "negative weight":
        top.weights = [1.0, 1.0, -1.0, 1.0]
    elif kind == "zero weight":
        top.weights = [1.0, 0.0, 1.0, 1.0]
    elif kind == "no area":
        top.points = [top.points[0]] * 4
    elif kind == "duplicate":
        patches.append(box_patches()[5])
        patches[-1].name = "Face7"
    elif kind == "pole":
        for patch in patches:
            patch.points = [(0.0, y, 30.0) if z == 30.0 else (x, y, z) for x, y, z in patch.points]
    return patches


def write_document(kind, path):
    doc = FreeCAD.newDocument("Made")
    shape = SHAPES[kind]()
    for number, part in enumerate(shape.Solids or [shape]):
        doc.addObject("Part::Feature", "Part%d" % number).Shape = part
    doc.saveAs(path)


def write_patches(kind, path):
    """Text, not the library's writer: that one would rightly refuse NaN."""
    import json

    patches = []
    for patch in box_patches() if kind in SHAPES else bad_patches(kind):
        row = {slot: getattr(patch, slot) for slot in binding.Patch.__slots__}
        patches.append({k: v for k, v in row.items() if v is not None})
    text = json.dumps({"format": "tsolid boundary", "version": 1, "patches": patches})
    with open(path, "w", encoding="utf-8") as stream:
        stream.write(text.replace("NaN", "1e999999").replace("Infinity", "1e999999"))


def write(kind, path):
    suffix = os.path.splitext(path)[1].lower()
    if suffix == ".fcstd":
        write_document(kind, path)
    elif suffix == ".tsb":
        write_patches(kind, path)
    else:
        shape = SHAPES[kind]()
        export = {".step": shape.exportStep, ".brep": shape.exportBrep, ".igs": shape.exportIges}
        export[suffix](path)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:  # exporters stumble over odd names
        plain = os.path.join(folder, "plain" + os.path.splitext(sys.argv[2])[1])
        write(sys.argv[1], plain)
        shutil.move(plain, sys.argv[2])
    os._exit(binding_parts.EXIT_BASE)
