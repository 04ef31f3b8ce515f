# SPDX-License-Identifier: LGPL-2.1-or-later
"""Splines for the example parts: NURBS patches and volumes in plain numpy.

A patch has degree (p, q), two clamped knot vectors, points (n, m, 3) and weights (n, m) or None;
a volume has three of each and homogeneous control points (n, m, l, 4). Refinements are matrices
with entries computed exactly and rounded once, applied in a fixed order: two patches that share a
row of control points share it, bit for bit, also after both were refined.
"""
import json
from fractions import Fraction

import numpy as np


class Patch:
    """One NURBS surface patch. points[i, j] belongs to N_i(u) M_j(v)."""

    def __init__(self, degree, knots, points, weights=None, name=None):
        self.degree = tuple(int(d) for d in degree)
        self.knots = tuple(tuple(float(k) for k in row) for row in knots)
        self.points = np.array(points, dtype=float)
        self.weights = None if weights is None else np.array(weights, dtype=float)
        self.name = name

    def copy(self):
        return Patch(self.degree, self.knots, self.points, self.weights, self.name)

    def homogeneous(self):
        weights = np.ones(self.points.shape[:2]) if self.weights is None else self.weights
        return np.concatenate([self.points * weights[..., None], weights[..., None]], axis=2)

    def domain(self):
        return tuple((k[p], k[-1 - p]) for k, p in zip(self.knots, self.degree))

    def evaluate(self, u, v):
        """Points S(u[k], v[k]), as rows."""
        u, v = np.asarray(u, float), np.asarray(v, float)
        a = basis_matrix(self.knots[0], self.degree[0], u)
        b = basis_matrix(self.knots[1], self.degree[1], v)
        h = np.einsum("ki,ijc,kj->kc", a, self.homogeneous(), b)
        return h[:, :3] / h[:, 3:]

    def derivatives(self, u, v):
        """S, S_u and S_v on the grid u x v, each of shape (len(u), len(v), 3)."""
        value = [basis_matrix(k, p, x) for k, p, x in zip(self.knots, self.degree, (u, v))]
        slope = [derivative_matrix(k, p, x) for k, p, x in zip(self.knots, self.degree, (u, v))]
        h, h_u, h_v = (np.einsum("ai,ijc,bj->abc", a, self.homogeneous(), b, optimize=True)
                       for a, b in ((value[0], value[1]), (slope[0], value[1]),
                                    (value[0], slope[1])))
        s = h[..., :3] / h[..., 3:]
        return s, *((d[..., :3] - s * d[..., 3:]) / h[..., 3:] for d in (h_u, h_v))

    def flux(self, n_gauss=24):
        """One third of the integral of S . (S_u x S_v): exact per knot span up to round-off."""
        nodes, factors = np.polynomial.legendre.leggauss(n_gauss)
        rules = []
        for knots in self.knots:
            spans = [(a, b) for a, b in zip(knots, knots[1:]) if a < b]
            x = np.concatenate([(a + b) / 2 + (b - a) / 2 * nodes for a, b in spans])
            w = np.concatenate([(b - a) / 2 * factors for a, b in spans])
            rules.append((x, w))
        s, s_u, s_v = self.derivatives(rules[0][0], rules[1][0])
        density = np.einsum("abc,abc->ab", s, np.cross(s_u, s_v))
        return float(rules[0][1] @ density @ rules[1][1]) / 3

    def describe(self):
        """The patch as an entry of a .tsb file."""
        n, m = self.points.shape[:2]
        entry = {} if self.name is None else {"name": self.name}
        entry.update(degree=list(self.degree), n_control=[n, m],
                     knots=[list(k) for k in self.knots],
                     points=self.points.transpose(1, 0, 2).reshape(-1, 3).tolist())
        if self.weights is not None:
            entry["weights"] = self.weights.T.reshape(-1).tolist()
        return entry


class Volume:
    """A trivariate NURBS solid; its six faces are the patches of a part."""

    def __init__(self, degree, knots, control):
        self.degree, self.knots = tuple(degree), tuple(knots)
        control = np.array(control, dtype=float)
        if control.shape[3] == 3:
            control = np.concatenate([control, np.ones(control.shape[:3] + (1,))], axis=3)
        self.control = control

    def evaluate(self, s, t, r):
        """Points on the tensor grid s x t x r."""
        a, b, c = (basis_matrix(k, p, x)
                   for k, p, x in zip(self.knots, self.degree, (s, t, r)))
        h = np.einsum("ai,bj,ck,ijkd->abcd", a, b, c, self.control, optimize=True)
        return h[..., :3] / h[..., 3:]

    def face(self, axis, end, name=None):
        others = [a for a in range(3) if a != axis]
        h = np.take(self.control, -1 if end else 0, axis=axis)
        weights = None if np.all(self.control[..., 3] == 1.0) else h[..., 3]
        points = h[..., :3] if weights is None else h[..., :3] / h[..., 3:]
        return Patch([self.degree[a] for a in others], [self.knots[a] for a in others],
                     points, weights, name)

    def faces(self):
        return [self.face(axis, end, "Face%d" % (1 + 2 * axis + end))
                for axis in range(3) for end in range(2)]

    def refined(self, axis, knots, raised=0):
        """The same volume over a finer knot vector and a degree raised by `raised`."""
        matrix = refinement(self.knots[axis], self.degree[axis], knots, raised)
        control = np.moveaxis(apply(matrix, np.moveaxis(self.control, axis, 0)), 0, axis)
        degree, all_knots = list(self.degree), list(self.knots)
        degree[axis] += raised
        all_knots[axis] = knots
        return Volume(degree, all_knots, control)


# ---- knots and functions ------------------------------------------------------------------------


def uniform_knots(degree, spans):
    return clamped_knots(degree, [i / spans for i in range(1, spans)])


def clamped_knots(degree, inner):
    return tuple([0.0] * (degree + 1) + [float(k) for k in inner] + [1.0] * (degree + 1))


def greville(knots, degree):
    n = len(knots) - degree - 1
    return np.array([sum(knots[i + 1:i + 1 + degree]) / degree for i in range(n)])


def basis_matrix(knots, degree, x):
    """Values of all functions (columns) at all parameters (rows), by the Cox-de Boor triangle."""
    knots, x = np.asarray(knots, float), np.asarray(x, float)
    n = len(knots) - degree - 1
    span = np.clip(np.searchsorted(knots, x, side="right") - 1, degree, n - 1)
    while np.any(knots[span] == knots[span + 1]):
        span = np.where(knots[span] == knots[span + 1], span - 1, span)
    value = np.zeros((len(x), degree + 1))
    value[:, 0] = 1.0
    for d in range(1, degree + 1):
        carry = np.zeros(len(x))
        for r in range(d):
            left, right = knots[span + r + 1 - d], knots[span + r + 1]
            part = value[:, r] / (right - left)
            value[:, r] = carry + (right - x) * part
            carry = (x - left) * part
        value[:, d] = carry
    full = np.zeros((len(x), n))
    for r in range(degree + 1):
        full[np.arange(len(x)), span - degree + r] = value[:, r]
    return full


def derivative_matrix(knots, degree, x):
    """First derivatives of all functions (columns) at all parameters (rows)."""
    lower = basis_matrix(knots[1:-1], degree - 1, x)
    n = len(knots) - degree - 1
    full = np.zeros((len(x), n))
    for i in range(n - 1):
        factor = degree / (knots[i + 1 + degree] - knots[i + 1])
        full[:, i] -= factor * lower[:, i]
        full[:, i + 1] += factor * lower[:, i]
    return full


# ---- exact refinement ---------------------------------------------------------------------------


def blossom_row(knots, degree, span, arguments):
    """Coefficients of the control points in the polar form of the segment `span`."""
    rows = {j: {j: Fraction(1)} for j in range(span - degree, span + 1)}
    for r, t in enumerate(arguments, start=1):
        for j in range(span, span - degree + r - 1, -1):
            low, high = knots[j], knots[j + degree + 1 - r]
            a = (t - low) / (high - low)
            row = {k: c * (1 - a) for k, c in rows[j - 1].items()}
            for k, c in rows[j].items():
                row[k] = row.get(k, 0) + c * a
            rows[j] = row
    return rows[span]


def refinement(knots, degree, new_knots, raised=0):
    """The matrix from old to new control points; `new_knots` must refine the old space."""
    old = [Fraction(k) for k in knots]
    new = [Fraction(k) for k in new_knots]
    top = degree + raised
    matrix = np.zeros((len(new) - top - 1, len(old) - degree - 1))
    for i in range(matrix.shape[0]):
        inside = next(k for k in range(i, i + top + 1) if new[k] < new[k + 1])
        span = max(k for k in range(degree, len(old) - degree - 1) if old[k] <= new[inside])
        arguments = new[i + 1:i + 1 + top]
        total = {}
        choices = list(leave_out(arguments, raised))
        for chosen in choices:
            for k, c in blossom_row(old, degree, span, chosen).items():
                total[k] = total.get(k, 0) + c
        for k, c in total.items():
            matrix[i, k] = float(c / len(choices))
    return matrix


def leave_out(arguments, count):
    """All ways to leave `count` of the arguments out."""
    if count == 0:
        yield list(arguments)
        return
    for i in range(len(arguments) - count + 1):
        for tail in leave_out(arguments[i + 1:], count - 1):
            yield list(arguments[:i]) + tail


def raised_knots(knots, degree, raised):
    distinct = sorted(set(knots))
    out = []
    for k in distinct:
        out += [k] * (min(knots.count(k), degree + 1) + raised)
    return tuple(out)


def apply(matrix, rows):
    """matrix @ rows along the first axis, summed in one fixed order whatever the shape."""
    out = np.zeros((matrix.shape[0],) + rows.shape[1:])
    column = (slice(None),) + (None,) * (rows.ndim - 1)
    for k in range(matrix.shape[1]):
        out = out + matrix[:, k][column] * rows[k][None]
    return out


def refine_patch(patch, direction, knots, raised=0):
    matrix = refinement(patch.knots[direction], patch.degree[direction], knots, raised)
    h = np.moveaxis(apply(matrix, np.moveaxis(patch.homogeneous(), direction, 0)), 0, direction)
    degree, all_knots = list(patch.degree), list(patch.knots)
    degree[direction] += raised
    all_knots[direction] = knots
    if patch.weights is None:
        return Patch(degree, all_knots, h[..., :3], None, patch.name)
    return Patch(degree, all_knots, h[..., :3] / h[..., 3:], h[..., 3], patch.name)


def raise_patch(patch, direction, raised=1):
    knots = raised_knots(patch.knots[direction], patch.degree[direction], raised)
    return refine_patch(patch, direction, knots, raised)


def insert_patch_knots(patch, direction, values):
    return refine_patch(patch, direction, tuple(sorted(patch.knots[direction] + tuple(values))))


# ---- volumes from maps --------------------------------------------------------------------------


def interpolated_volume(function, degree, knots):
    """The tensor product spline that meets `function` at all Greville points."""
    grids = [greville(k, p) for k, p in zip(knots, degree)]
    control = sample(function, grids)
    for axis in range(3):
        matrix = basis_matrix(knots[axis], degree[axis], grids[axis])
        moved = np.moveaxis(control, axis, 0)
        solved = np.linalg.solve(matrix, moved.reshape(moved.shape[0], -1)).reshape(moved.shape)
        control = np.moveaxis(solved, 0, axis)
    return Volume(degree, knots, control)


def control_volume(function, degree, knots, weight=None):
    """The volume whose control points are `function` at the Greville points."""
    grids = [greville(k, p) for k, p in zip(knots, degree)]
    points = sample(function, grids)
    if weight is None:
        return Volume(degree, knots, points)
    weights = sample(weight, grids)
    return Volume(degree, knots,
                  np.concatenate([points * weights[..., None], weights[..., None]], axis=3))


def sample(function, grids):
    return np.array([[[function(x, y, z) for z in grids[2]] for y in grids[1]] for x in grids[0]])


def split_faces(volume, cuts):
    """Each face of the volume cut into 2 x 2 patches at the parameters cuts[axis]."""
    for axis in range(3):
        p = volume.degree[axis]
        missing = p - volume.knots[axis].count(cuts[axis])
        volume = volume.refined(axis, tuple(sorted(volume.knots[axis] + (cuts[axis],) * missing)))
    patches = []
    for face in volume.faces():
        for half_u in range(2):
            for half_v in range(2):
                patches.append(half_patch(half_patch(face, 0, half_u), 1, half_v))
                patches[-1].name = "Face%d" % len(patches)
    return patches


def half_patch(patch, direction, high):
    """One half of a patch with an inner knot of full multiplicity: the only one that is."""
    knots, p = patch.knots[direction], patch.degree[direction]
    cut = next(k for k in sorted(set(knots))[1:-1] if knots.count(k) == p)
    first = knots.index(cut)
    if high:  # the halves share control point first - 1
        part, new = slice(first - 1, None), (cut,) + knots[first:]
    else:
        part, new = slice(0, first), knots[:first + p] + (cut,)
    index = [slice(None), slice(None)]
    index[direction] = part
    all_knots = list(patch.knots)
    all_knots[direction] = new
    return Patch(patch.degree, all_knots, patch.points[tuple(index)],
                 None if patch.weights is None else patch.weights[tuple(index)])


# ---- quality and files --------------------------------------------------------------------------


def smallest_scaled_jacobian(points):
    """Over all corners of the cells of a grid of points (a, b, c, 3)."""
    worst = np.inf
    low, high = slice(None, -1), slice(1, None)
    for corner in range(8):
        here = tuple(high if corner >> a & 1 else low for a in range(3))
        edges = []
        for a in range(3):
            there = list(here)
            there[a] = low if corner >> a & 1 else high
            edge = points[tuple(there)] - points[here]
            edge = edge * (-1 if corner >> a & 1 else 1)
            edges.append(edge / np.linalg.norm(edge, axis=-1, keepdims=True))
        jacobian = np.einsum("...i,...i", np.cross(edges[0], edges[1]), edges[2])
        worst = min(worst, float(jacobian.min()))
    return worst


def write_tsb(patches, path):
    """One patch per line: readable, and small differences stay small in a version history."""
    with open(path, "w", encoding="utf-8") as out:
        out.write('{"format": "tsolid boundary", "version": 1, "patches": [\n')
        out.write(",\n".join(json.dumps(p.describe()) for p in patches))
        out.write("\n]}\n")


def read_tsb(path):
    with open(path, encoding="utf-8") as source:
        document = json.load(source)
    patches = []
    for entry in document["patches"]:
        n, m = entry["n_control"]
        points = np.array(entry["points"], float).reshape(m, n, 3).transpose(1, 0, 2)
        weights = entry.get("weights")
        if weights is not None:
            weights = np.array(weights, float).reshape(m, n).T
        patches.append(Patch(entry["degree"], entry["knots"], points, weights, entry.get("name")))
    return patches
