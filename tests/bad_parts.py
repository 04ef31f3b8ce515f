# SPDX-License-Identifier: LGPL-2.1-or-later
"""Parts and files that must be refused, each with what the refusal has to mention.

PARTS: name -> (patches, words). FILES: name -> (bytes, words). Words are regular expressions, all
of which must occur in the message.
"""
import json
import os
import random

import numpy as np

from rewrite_part import ROOT, reoriented  # puts resources on the path

from examples.parts import PARTS as GOOD
from examples.splines import Patch, clamped_knots, uniform_knots


def changed(name, index, change):
    """A good part, one patch of which went through change(patch)."""
    patches = GOOD[name]()
    patches[index] = change(patches[index]) or patches[index]
    return patches


def with_point(index, value, where=(2, 2)):
    """Coordinate y of one control point of the wavy cube's patch `index`."""

    def change(patch):
        patch.points[where][1] = value

    return changed("wavy_cube", index, change)


def with_weight(value, where=(1, 1)):
    def change(patch):
        patch.weights[where] = value

    return changed("elbow", 2, change)


def with_knots(knots):
    def change(patch):
        return Patch(patch.degree, (knots, patch.knots[1]), patch.points, None, patch.name)

    return changed("wavy_cube", 3, change)


def mapped(patches, place):
    """All control points through place(x, y, z)."""
    for patch in patches:
        patch.points = np.array([[place(*p) for p in row] for row in patch.points])
    return patches


def renamed(patches):
    for k, patch in enumerate(patches):
        patch.name = "Face%d" % (k + 1)
    return patches


def bilinear(corners):
    """A patch between four points, in the order (u,v) = 00, 10, 01, 11."""
    points = [[corners[0], corners[2]], [corners[1], corners[3]]]
    return Patch((1, 1), (uniform_knots(1, 1),) * 2, points)


def boundary_of_cells(cells):
    """The boundary of unit cubes in the grid, as bilinear patches."""
    patches = []
    for cell in cells:
        for axis in range(3):
            for end in range(2):
                beside = list(cell)
                beside[axis] += 1 if end else -1
                if tuple(beside) in cells:
                    continue
                others = [a for a in range(3) if a != axis]
                corners = []
                for b, a in ((0, 0), (0, 1), (1, 0), (1, 1)):
                    corner = [10.0 * c for c in cell]
                    corner[axis] += 10.0 * end
                    corner[others[0]] += 10.0 * a
                    corner[others[1]] += 10.0 * b
                    corners.append(corner)
                patches.append(bilinear(corners))
    return renamed(patches)


def bored_block():
    """A square frame of eight cubes: genus one, all faces four-sided."""
    return boundary_of_cells([(i, j, 0) for i in range(3) for j in range(3) if (i, j) != (1, 1)])


def torus():
    """A ring of 4 x 4 patches."""
    def point(i, j):
        a, b = 0.5 * np.pi * (i % 4), 0.5 * np.pi * (j % 4)
        radius = 30 + 10 * np.cos(b)
        return [radius * np.cos(a), radius * np.sin(a), 10 * np.sin(b)]

    return renamed([bilinear([point(i, j), point(i + 1, j), point(i, j + 1), point(i + 1, j + 1)])
                    for i in range(4) for j in range(4)])


def other_parameter():
    """A side that runs along its own edges at another speed: the same point set, not affine."""
    def change(patch):
        points = np.array([patch.points[0], 0.5 * (patch.points[0] + patch.points[1]),
                           patch.points[1]])
        return Patch((1, 1), (clamped_knots(1, [0.3]), patch.knots[1]), points, None, patch.name)

    return changed("box", 4, change)


def uneven_weights():
    """Weights of one row of a border that no factor makes agree with the neighbour's."""
    def change(patch):
        patch.weights = np.ones(patch.points.shape[:2])
        patch.weights[2, 0] = 1.5

    return changed("wavy_cube", 0, change)


def edge_moved(distance):
    def change(patch):
        patch.points[3, 0, 2] += distance

    return changed("wavy_cube", 2, change)


def without(name, *indices):
    return [p for k, p in enumerate(GOOD[name]()) if k not in indices]


def with_more(name, make):
    patches = GOOD[name]()
    return renamed(patches + make(patches))


def stray_face(patches):
    far = patches[0].copy()
    far.points += 500.0
    return [far]


def second_part(patches):
    return mapped(GOOD["box"](), lambda x, y, z: (x + 500, y, z))


def pole():
    """The edge x = 60, z = 30 of the box drawn together to a point."""
    return mapped(GOOD["box"](), lambda x, y, z: (x, 20.0 if x == 60 and z == 30 else y, z))


def face_on_a_line():
    """All four corners of the top on one line: four edges of some length, no area."""
    places = {(0, 0): 0.0, (0, 40): 10.0, (60, 0): 60.0, (60, 40): 50.0}
    return mapped(GOOD["box"](),
                  lambda x, y, z: (places[x, y], 20.0, z) if z == 30 else (x, y, z))


def turned_copy(patches):
    patch, _ = reoriented(patches[4], True, (False, True))
    return [patch]


PARTS = {
    "nan_point": (with_point(1, float("nan")), [r"patches\[1\]\.points\[20\]"]),
    "infinite_point": (with_point(1, float("inf")), [r"patches\[1\]\.points\[20\]"]),
    "huge_point": (with_point(1, 1e300), ["Face2", r"\(2, 2\)"]),
    "nan_weight": (with_weight(float("nan")), [r"patches\[2\]\.weights\[8\]"]),
    "infinite_weight": (with_weight(float("inf")), [r"patches\[2\]\.weights\[8\]"]),
    "negative_weight": (with_weight(-1.0), ["Face3", "weight"]),
    "zero_weight": (with_weight(0.0), ["Face3", "weight"]),
    "zero_weight_on_an_edge": (with_weight(0.0, (0, 1)), ["Face3", "weight"]),
    "decreasing_knots": (with_knots(clamped_knots(3, [0.2, 0.4, 0.3, 0.6, 0.8])),
                         ["Face4", "knot"]),
    "nan_knot": (with_knots(clamped_knots(3, [0.2, 0.4, float("nan"), 0.6, 0.8])),
                 [r"patches\[3\]\.knots"]),
    "not_clamped": (with_knots((0, 0, 0, 0.1) + tuple(clamped_knots(3, [.2, .4, .5, .6, .8])[4:])),
                    ["Face4", "knot"]),
    "torn_knots": (with_knots(clamped_knots(3, [0.2, 0.5, 0.5, 0.5, 0.5])), ["Face4", "knot"]),
    "empty_range": (with_knots((1.0,) * 13), ["Face4", "knot"]),
    "flat_part": (mapped(GOOD["box"](), lambda x, y, z: (x, y, 0.0)), ["Face"]),
    "zero_area_face": (mapped(GOOD["box"](), lambda x, y, z: (x if z == 0 else 30.0, y, z)),
                       ["Face"]),
    "face_on_a_line": (face_on_a_line(), ["Face6"]),
    "all_in_one_point": (mapped(GOOD["box"](), lambda x, y, z: (1.0, 2.0, 3.0)), ["Face"]),
    "pole": (pole(), ["Face"]),
    "duplicate_face": (with_more("box", lambda p: [p[2].copy()]), ["Face3", "Face7"]),
    "duplicate_turned_face": (with_more("box", turned_copy), ["Face5", "Face7"]),
    "face_twice_instead_of_another": (renamed([p.copy() for k in (0, 1, 2, 3, 4, 4)
                                               for p in [GOOD["box"]()[k]]]), ["Face"]),
    "five_faces": (without("wavy_cube", 3), ["Face", "closed"]),
    "one_face": (without("wavy_cube", 0, 1, 2, 3, 4), ["Face6", "closed"]),
    "open_grid": (without("grid24", 17), ["Face", "closed"]),
    "seven_faces": (with_more("wavy_cube", stray_face), ["Face7", "closed"]),
    "two_parts": (with_more("box", second_part), ["2 separate"]),
    "bored_block": (bored_block(), ["genus"]),
    "torus": (torus(), ["genus"]),
    "l_shape": (boundary_of_cells([(0, 0, 0), (1, 0, 0), (0, 1, 0)]), ["extraordinary"]),
    "two_cubes_at_an_edge": (boundary_of_cells([(0, 0, 0), (1, 1, 0)]), ["shared by 4"]),
    # the curves differ by 2/3 of the move: the largest value of the moved point's function
    "edge_apart": (edge_moved(1e-3), ["Face3", r"0\.000667\b", r"near \("]),
    "edge_just_apart": (edge_moved(3e-7), ["Face3"]),
    "other_parameter": (other_parameter(), ["Face5"]),
    "uneven_weights": (uneven_weights(), ["Face1"]),
}


def good_file(name="wedge"):
    path = os.path.join(ROOT, "resources", "examples", name + ".tsb")
    with open(path, "rb") as source:
        return source.read()


def altered(change):
    """A good document after change(document), as bytes."""
    document = json.loads(good_file())
    document = change(document) or document
    return json.dumps(document).encode()


def setting(key, value):
    """Sets one field of the third patch."""

    def change(document):
        document["patches"][2][key] = value

    return altered(change)


def deleting(key):
    def change(document):
        del document["patches"][2][key]

    return altered(change)


def noise(length):
    return bytes(random.Random(length).getrandbits(8) for _ in range(length))


FILES = {
    "empty": (b"", []),
    "blanks": (b" \n\t ", []),
    "one_brace": (b"{", []),
    "noise": (noise(4000), []),
    "zeros": (bytes(4000), []),
    "text": (b"This is not a part.\n", []),
    "step": (b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n", []),
    "number": (b"42", []),
    "list": (b"[]", []),
    "null": (b"null", []),
    "other_json": (b'{"a": 1}', []),
    "tail": (good_file() + b"x", []),
    "two_documents": (good_file() * 2, []),
    "nested": (b"[" * 100000, []),
    "nested_in_points": (good_file().replace(b'"points": ', b'"points": ' + b"[" * 50000, 1), []),
    "other_format": (altered(lambda d: d.update(format="tsolid report")), ["format"]),
    "other_version": (altered(lambda d: d.update(version=2)), ["version"]),
    "version_as_text": (altered(lambda d: d.update(version="1")), ["version"]),
    "no_patches": (altered(lambda d: d.update(patches=[])), ["patch"]),
    "patches_missing": (altered(lambda d: d.pop("patches") and None), []),
    "patches_a_number": (altered(lambda d: d.update(patches=6)), []),
    "patch_a_number": (altered(lambda d: d["patches"].append(3)), []),
    "degree_zero": (setting("degree", [0, 2]), ["degree"]),
    "degree_26": (setting("degree", [26, 2]), ["degree"]),
    "degree_fraction": (setting("degree", [2.5, 2]), ["degree"]),
    "degree_huge": (setting("degree", [1e300, 2]), ["degree"]),
    "degree_missing": (deleting("degree"), ["degree"]),
    "control_huge": (setting("n_control", [2 ** 31 - 1, 2 ** 31 - 1]), ["n_control"]),
    "control_overflow": (setting("n_control", [65536, 65536]), ["n_control|points|knots"]),
    "control_negative": (setting("n_control", [-4, 3]), ["n_control"]),
    "knots_short": (setting("knots", [[0, 0, 1, 1], [0, 0, 0, 1, 1, 1]]), ["knots"]),
    "knots_text": (setting("knots", "uniform"), ["knots"]),
    "points_short": (setting("points", [[0, 0, 0]]), ["points"]),
    "points_flat": (setting("points", [0.0] * 54), ["points"]),
    "points_missing": (deleting("points"), ["points"]),
    "weights_short": (setting("weights", [1.0]), ["weights"]),
    "weights_null": (setting("weights", None), ["weights"]),
    "name_a_number": (setting("name", 7), ["name"]),
    "tolerance_negative": (altered(lambda d: d.update(tolerance=-1.0)), ["tolerance"]),
    "infinite_number": (altered(lambda d: d).replace(b"70.0", b"1e999"), []),
}


def truncated(step):
    """The good file cut off at every step-th byte, and just before its end."""
    data = good_file().rstrip()
    return [data[:k] for k in list(range(0, len(data), step)) + [len(data) - 1]]
