# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs inside FreeCADCmd: freecad_maker.py KIND PATH makes a file to read, good or bad."""

import json
import os
import random
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


SHAPES = {
    "box": lambda: BOX,
    "bar": lambda: Part.makeCylinder(3, 10),
    "wavy": lambda: solid_of(binding_parts.cube(wavy)),
    "shell": lambda: BOX.Shells[0],
    "open": lambda: Part.makeShell(BOX.Faces[:5]),
    "five": lambda: Part.makeSolid(Part.makeShell(BOX.Faces[:5])),
    "bored": lambda: BOX.cut(Part.makeCylinder(2, 40, Vector(5, 10, -5))),
    "torus": lambda: Part.makeTorus(9, 2),
    "sphere": lambda: Part.makeSphere(5),
    "tip": lambda: Part.makeCone(2, 0, 9),
    "trimmed": lambda: BOX.makeFillet(2, [BOX.Edges[0], BOX.Edges[1]]),
    "two": lambda: Part.makeCompound([BOX, Part.makeBox(1, 1, 1, Vector(50, 0, 0))]),
    "none": lambda: Part.makeLine(Vector(0, 0, 0), Vector(1, 0, 0)),
}


def turned(patch, numbers):
    """The same surface with its parameters reversed, exchanged and rescaled at random."""
    surface = convert.surface_of_patch(patch)
    if numbers.random() < 0.5:
        surface.exchangeUV()
    low, stretch = numbers.uniform(-5, 5), 10 ** numbers.uniform(-2, 2)
    knots = surface.getUKnots()
    surface.setUKnots([low + stretch * (k - knots[0]) for k in knots])
    if numbers.random() < 0.5:  # from the other end, by hand
        poles, weights = surface.getPoles()[::-1], surface.getWeights()[::-1]
        knots = surface.getUKnots()
        back = [knots[0] + knots[-1] - k for k in reversed(knots)]
        rational = surface.isURational() or surface.isVRational()
        arguments = [poles, surface.getUMultiplicities()[::-1], surface.getVMultiplicities()]
        arguments += [back, surface.getVKnots(), False, False, surface.UDegree, surface.VDegree]
        surface = Part.BSplineSurface()
        surface.buildFromPolesMultsKnots(*arguments + ([weights] if rational else []))
    return convert.patch_of_surface(surface)


def example(name, seed=""):
    """An example part; with a seed, re-written: faces turned, shuffled, and the whole moved."""
    patches = binding_parts.read_example(name)
    if not seed:
        return convert.solid_of_patches(patches)
    numbers = random.Random(seed)
    patches = [turned(p, numbers) for p in patches]
    numbers.shuffle(patches)
    solid = convert.solid_of_patches(patches)
    axis = Vector(*(numbers.gauss(0, 1) for _ in range(3)))
    solid.rotate(Vector(1, 2, 3), axis, numbers.uniform(0, 360))
    solid.translate(axis * 7)
    return solid


def shape_of(kind):
    """SHAPES[kind], or for example:NAME and example:NAME:SEED an example part."""
    words = kind.split(":")
    return example(*words[1:]) if words[0] == "example" else SHAPES[kind]()


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


def bezier_text():
    """The wavy part's boundary as Bezier elements."""
    context = binding.Context()
    boundary = binding.Boundary.create(context, binding_parts.cube(wavy), refine_knots=1)
    sides = []
    for side in range(6):
        elements = [
            {
                "box": list(e.box),
                "functions": list(e.functions),
                "coefficients": [list(row) for row in e.coefficients],
            }
            for e in boundary.elements(side)
        ]
        sides.append({"degree": list(boundary.side_degree(side)), "elements": elements})
    bezier = {"points": boundary.points.tolist(), "sides": sides}
    return json.dumps({"format": "tsolid boundary", "version": 1, "bezier": bezier})


def write_patches(kind, path):
    """Text, not the library's writer: that one would rightly refuse NaN."""
    if kind == "bezier":
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(bezier_text())
        return
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
        shape = shape_of(kind)
        export = {".step": shape.exportStep, ".brep": shape.exportBrep, ".igs": shape.exportIges}
        export[suffix](path)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:  # exporters stumble over odd names
        plain = os.path.join(folder, "plain" + os.path.splitext(sys.argv[2])[1])
        write(sys.argv[1], plain)
        shutil.move(plain, sys.argv[2])
    os._exit(binding_parts.EXIT_BASE)
