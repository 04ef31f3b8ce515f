# SPDX-License-Identifier: LGPL-2.1-or-later
"""Patches as OCC's B-spline surfaces, and solids made of such faces."""

import FreeCAD
import Part

from .binding import Patch, Refused, finding
from .header import Severity, Status


def patch_of_surface(surface, **names):
    """Knots, control points and weights of a clamped B-spline surface."""
    poles = surface.getPoles()
    n, m = len(poles), len(poles[0])
    weights = None
    if surface.isURational() or surface.isVRational():
        rows = surface.getWeights()
        weights = [rows[i][j] for j in range(m) for i in range(n)]
    points = [(poles[i][j].x, poles[i][j].y, poles[i][j].z) for j in range(m) for i in range(n)]
    degree = (surface.UDegree, surface.VDegree)
    knots = (surface.UKnotSequence, surface.VKnotSequence)
    return Patch(degree, (n, m), knots, points, weights, **names)


def surface_of_net(net):
    return surface_of_patch(net.patch())


def _distinct(knots):
    values, counts = [], []
    for knot in knots:
        if values and knot == values[-1]:
            counts[-1] += 1
        else:
            values.append(knot)
            counts.append(1)
    return values, counts


def surface_of_patch(patch):
    """The patch as a Part.BSplineSurface."""
    n, m = patch.n_control
    poles = [[FreeCAD.Vector(*patch.points[i + n * j]) for j in range(m)] for i in range(n)]
    (u, u_counts), (v, v_counts) = _distinct(patch.knots[0]), _distinct(patch.knots[1])
    arguments = [poles, u_counts, v_counts, u, v, False, False, patch.degree[0], patch.degree[1]]
    if patch.weights is not None:
        arguments.append([[patch.weights[i + n * j] for j in range(m)] for i in range(n)])
    surface = Part.BSplineSurface()
    surface.buildFromPolesMultsKnots(*arguments)
    return surface


def patches_of_boundary(boundary):
    """The boundary's Bezier elements as patches of one span each."""
    points = boundary.points
    out = []
    for side in range(6):
        degree = boundary.side_degree(side)
        size = (degree[0] + 1) * (degree[1] + 1)
        for element in boundary.elements(side):
            net = [[0.0] * 4 for _ in range(size)]
            for function, row in zip(element.functions, element.coefficients):
                point = [points[function, d] for d in range(4)]
                for net_row, c in zip(net, row):
                    for d in range(4):
                        net_row[d] += c * point[d]
            out.append(_bezier_patch(degree, net, "side %d" % side))
    return out


def _bezier_patch(degree, net, name):
    knots = [[0.0] * (p + 1) + [1.0] * (p + 1) for p in degree]
    points = [(x / w, y / w, z / w) for x, y, z, w in net]
    weights = [row[3] for row in net]
    same = all(w == weights[0] for w in weights)
    n_control = (degree[0] + 1, degree[1] + 1)
    return Patch(degree, n_control, knots, points, None if same else weights, name=name)


def solid_of_faces(faces):
    """A closed valid solid made of loose faces; Refused when they do not close."""
    compound = Part.makeCompound(faces)
    compound.sewShape(1e-6)  # OCC takes 1e-6 whatever is said here
    if len(compound.Shells) != 1 or not compound.Shells[0].isClosed():
        text = "the patches do not close to one shell"
        raise Refused(Status.ERROR_REFUSED, [finding(Severity.ERROR, "shape", "", text)])
    solid = Part.makeSolid(compound.Shells[0])
    if solid.Volume < 0:
        solid.reverse()
    return solid


def solid_of_patches(patches):
    return solid_of_faces([surface_of_patch(p).toShape() for p in patches])
