# SPDX-License-Identifier: LGPL-2.1-or-later
"""The FreeCAD side of the example parts: NURBS patches to a closed valid solid, STEP and BREP."""
import sys
import traceback

import FreeCAD
import Part

from .splines import Patch, read_tsb, write_tsb


def surface(patch):
    """The patch as a Part.BSplineSurface with the same poles, weights and knots."""
    distinct, counts = [], []
    for knots in patch.knots:
        distinct.append(sorted(set(knots)))
        counts.append([knots.count(k) for k in distinct[-1]])
    poles = [[FreeCAD.Vector(*p) for p in row] for row in patch.points.tolist()]
    result = Part.BSplineSurface()
    arguments = [poles, counts[0], counts[1], distinct[0], distinct[1], False, False,
                 patch.degree[0], patch.degree[1]]
    if patch.weights is not None:
        arguments.append(patch.weights.tolist())
    result.buildFromPolesMultsKnots(*arguments)
    return result


def solid(patches):
    """The closed solid between the patches; ValueError when they do not close."""
    compound = Part.makeCompound([surface(p).toShape() for p in patches])
    compound.sewShape(1e-6)
    if len(compound.Shells) != 1 or not compound.Shells[0].isClosed():
        raise ValueError("the patches do not close")
    result = Part.makeSolid(compound.Shells[0])
    if result.Volume < 0:
        result.reverse()
    vertices = len(result.Faces) + 2  # Euler, all faces four-sided
    if not result.isValid() or len(result.Faces) != len(patches) or \
            len(result.Edges) != 2 * len(patches) or len(result.Vertexes) != vertices:
        raise ValueError("not a valid solid of %d faces, %d edges and %d vertices"
                         % (len(patches), 2 * len(patches), vertices))
    return result


def write(path):
    """path.tsb to path.step and path.brep; the STEP file must come back as the same solid."""
    stem = path[:-len(".tsb")]
    part = solid(read_tsb(path))
    part.exportBrep(stem + ".brep")
    part.exportStep(stem + ".step")
    back = Part.Shape()
    back.read(stem + ".step")
    if len(back.Solids) != 1 or len(back.Faces) != len(part.Faces) or not back.isValid():
        raise ValueError("%s.step does not read back as the same solid" % stem)


def run(paths):
    """All jobs; ends FreeCAD with exit code 0 or 1."""
    try:
        for path in paths:
            write(path)
    except Exception:
        traceback.print_exc()
        sys.exit(1)
    sys.exit(0)


def patch_of(face):
    """The surface of an untrimmed B-spline face as a Patch."""
    s = face.Surface
    knots = [[k for k, c in zip(values, counts) for _ in range(c)]
             for values, counts in ((s.getUKnots(), s.getUMultiplicities()),
                                    (s.getVKnots(), s.getVMultiplicities()))]
    points = [[list(p) for p in row] for row in s.getPoles()]
    rational = s.isURational() or s.isVRational()
    return Patch((s.UDegree, s.VDegree), knots, points, s.getWeights() if rational else None)


def round_trip(path):
    """path to a STEP file and that to path.back; ends FreeCAD with exit code 0 or 1."""
    try:
        solid(read_tsb(path)).exportStep(path + ".step")
        back = Part.Shape()
        back.read(path + ".step")
        write_tsb([patch_of(f) for f in back.Faces], path + ".back")
    except Exception:
        traceback.print_exc()
        sys.exit(1)
    sys.exit(0)
