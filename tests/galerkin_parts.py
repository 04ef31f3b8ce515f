# SPDX-License-Identifier: LGPL-2.1-or-later
"""Galerkin's method on a solid with numpy alone, from its extraction operators: integrals of given
functions, projections onto the boundary, errors. Independent of the library's quadrature."""

import math
import os
import tempfile

import binding_parts
import numpy
import scipy.sparse
import scipy.sparse.linalg
import rewrite_part  # noqa: F401  (puts resources on the path)
from binding_parts import binding

from examples import read_extraction
from freecad.tsolid import analysis

SIDES = range(6)


def build(name, refine=0, effort=0, min_cells=0, sharp_core=False):
    context = binding.Context()
    patches = binding_parts.read_example(name)
    boundary = binding.Boundary.create(context, patches, refine_knots=refine)
    tmesh = binding.TMesh.create(context, boundary, min_cells, sharp_core=sharp_core)
    space = binding.Space.create(context, boundary, tmesh)
    return binding.Solid.create(context, space).optimised(context, effort)


def sparse(matrix):
    start, column, value = (numpy.array(x) for x in matrix.arrays())
    shape = (matrix.n_rows, matrix.n_rows)
    return scipy.sparse.csr_matrix((value, column, start.astype(numpy.int64)), shape=shape)


def bernstein(degree, x):
    """Values and derivatives at x in [0, 1]: arrays [point, index]."""
    x = numpy.asarray(x)[:, None]

    def values(p):
        k = numpy.arange(p + 1)
        return numpy.array([math.comb(p, i) for i in k]) * x**k * (1 - x) ** (p - k)

    below = numpy.pad(values(degree - 1), ((0, 0), (1, 1)))
    return values(degree), degree * (below[:, :-1] - below[:, 1:])


class Points:
    """The functions of one element at points: ids, values [q, A], gradients [q, A, 3] in space,
    x [q, 3] and the weights of an integral over the element or over its outer face."""

    def __init__(self, ids, values, gradients, x, weights):
        self.ids, self.values, self.gradients = ids, values, gradients
        self.x, self.weights = x, weights


class Galerkin:
    def __init__(self, solid, extra=3):
        self.solid, self.extra, self._tables = solid, extra, {}
        self.context = binding.Context()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "x")
            analysis.write_extraction(self.context, solid, path)
            self.data = read_extraction.read(path)
        self.n = self.data.n_functions
        first = self.n - solid.space.n_surface
        self.inner, self.outer = numpy.arange(first), numpy.arange(first, self.n)

    def _table(self, degree, face):
        """Bernstein values and derivatives [4, q, i] with u[0] fastest, and weights; cached."""
        key = tuple(degree) + (face,)
        if key not in self._tables:
            lines, weights = [], numpy.ones(1)
            for axis in range(3):
                x, w = numpy.polynomial.legendre.leggauss(int(degree[axis]) + self.extra)
                x, w = (x + 1) / 2, w / 2
                if face is not None and axis == face // 2:
                    x, w = numpy.array([float(face % 2)]), numpy.ones(1)
                lines.append(bernstein(int(degree[axis]), x))
                weights = numpy.multiply.outer(w, weights).ravel()
            rows = []
            for order in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)):
                a, b, c = (lines[k][order[k]] for k in range(3))
                rows.append(numpy.kron(c, numpy.kron(b, a)))
            self._tables[key] = numpy.array(rows), weights
        return self._tables[key]

    def _points(self, e, face=None):
        data = self.data
        table, weights = self._table(data.degree[e], face)
        ids, rows = read_extraction.element(data, e)
        size = data.box[e, 3:] - data.box[e, :3]
        n = table @ rows.T  # [4, q, A]
        n[1:] /= size[:, None, None]
        control = data.control[ids]
        h = n @ control  # [4, q, 4]
        w = h[:, :, 3]
        x = h[0, :, :3] / w[0][:, None]
        jacobian = (h[1:, :, :3] - x * w[1:, :, None]) / w[0][:, None]  # [a, q, c]
        jacobian = jacobian.transpose(1, 0, 2)
        values = n[0] * control[:, 3] / w[0][:, None]
        slopes = (n[1:] * control[:, 3] - values * w[1:, :, None]) / w[0][:, None]
        gradients = numpy.einsum("qca,aqk->qkc", numpy.linalg.inv(jacobian), slopes)
        if face is None:
            measure = numpy.linalg.det(jacobian) * size.prod()
        else:
            a, b = (k for k in range(3) if k != face // 2)
            measure = numpy.linalg.norm(numpy.cross(jacobian[:, a], jacobian[:, b]), axis=1)
            measure = measure * size[a] * size[b]
        return Points(ids, values, gradients, x, weights * measure)

    def elements(self):
        return (self._points(e) for e in range(self.data.n_elements))

    def faces(self):
        """The outer faces of the boundary's elements."""
        for side in SIDES:
            axis, high = divmod(side, 2)
            arm = numpy.flatnonzero(self.data.block == 1 + side)
            ends = self.data.box[arm, axis + 3 * high]
            end = ends.max() if high else ends.min()
            for e in arm[ends == end]:
                yield self._points(e, side)

    def load(self, f):
        """Integrals of f R_A; f(x) returns [q] or [q, 3]."""
        out = None
        for p in self.elements():
            part = p.values.T @ (f(p.x).T * p.weights).T
            if out is None:
                out = numpy.zeros((self.n,) + part.shape[1:])
            out[p.ids] += part
        return out

    def boundary_values(self, u):
        """The L2 projection of u onto the functions of the boundary."""
        first, n = len(self.inner), len(self.outer)
        rows, columns, values, right = [], [], [], None
        for p in self.faces():
            keep = p.ids >= first
            ids, v = p.ids[keep] - first, p.values[:, keep]
            part = v.T @ (u(p.x).T * p.weights).T
            if right is None:
                right = numpy.zeros((n,) + part.shape[1:])
            right[ids] += part
            rows.append(numpy.repeat(ids, len(ids)))
            columns.append(numpy.tile(ids, len(ids)))
            values.append((v.T @ (v * p.weights[:, None])).ravel())
        rows, columns, values = (numpy.concatenate(x) for x in (rows, columns, values))
        mass = scipy.sparse.csc_matrix((values, (rows, columns)), shape=(n, n))
        return scipy.sparse.linalg.splu(mass).solve(right)

    def errors(self, coefficients, u, gradient, energy):
        """L2 norms of the error and of u, and the same of energy(gradient)."""
        sums = numpy.zeros(4)
        for p in self.elements():
            c = coefficients[p.ids]
            value, slope = u(p.x), gradient(p.x)
            found = p.values @ c
            rate = numpy.einsum("qac,a...->q...c", p.gradients, c)
            square = (lambda v: v**2) if value.ndim == 1 else (lambda v: (v**2).sum(axis=1))
            parts = (square(found - value), square(value), energy(rate - slope), energy(slope))
            sums += [p.weights @ part for part in parts]
        return numpy.sqrt(sums)


# ---- problems with a known solution ------------------------------------------------------------


class Wave:
    """sin(a x + d) sin(b y + e) sin(c z + f) in coordinates from the part's middle, in units of its
    half size: derivatives of any order."""

    def __init__(self, middle, unit, rates, phases):
        self.middle, self.unit = middle, unit
        self.rates, self.phases = numpy.array(rates) / unit, numpy.array(phases)

    def __call__(self, x, *order):
        count = numpy.array([order.count(k) for k in range(3)])
        angle = (x - self.middle) * self.rates + self.phases + count * math.pi / 2
        return (numpy.sin(angle) * self.rates**count).prod(axis=1)


class Poisson:
    kind = 1

    def __init__(self, middle, unit):
        self.w = Wave(middle, unit, (1.3, 0.9, 1.1), (0.2, 1.4, 0.6))

    def u(self, x):
        return self.w(x)

    def gradient(self, x):
        return numpy.stack([self.w(x, k) for k in range(3)], axis=1)

    def source(self, x):
        return -sum(self.w(x, k, k) for k in range(3))

    @staticmethod
    def energy(gradient):
        return (gradient**2).sum(axis=1)


class Elasticity:
    kind = 2
    young, poisson = 1.0, 0.3

    def __init__(self, middle, unit):
        rates = ((1.3, 0.9, 1.1), (0.8, 1.2, 0.7), (1.0, 1.1, 1.2))
        phases = ((0.2, 1.4, 0.6), (1.1, 0.1, 0.9), (0.7, 0.5, 1.3))
        self.w = [Wave(middle, unit, r, p) for r, p in zip(rates, phases)]
        self.lam = self.young * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))
        self.mu = self.young / (2 * (1 + self.poisson))

    def u(self, x):
        return numpy.stack([w(x) for w in self.w], axis=1)

    def gradient(self, x):
        rows = [numpy.stack([w(x, k) for k in range(3)], axis=1) for w in self.w]
        return numpy.stack(rows, axis=1)

    def source(self, x):
        columns = []
        for i in range(3):
            bulk = sum(self.w[j](x, i, j) for j in range(3))
            shear = sum(self.w[i](x, k, k) for k in range(3))
            columns.append(-(self.lam + self.mu) * bulk - self.mu * shear)
        return numpy.stack(columns, axis=1)

    def energy(self, gradient):
        strain = (gradient + gradient.transpose(0, 2, 1)) / 2
        trace = numpy.trace(strain, axis1=1, axis2=2)
        return self.lam * trace**2 + 2 * self.mu * (strain**2).sum(axis=(1, 2))


def solve(galerkin, problem):
    """Coefficients [A] or [A, 3] with the boundary values of problem.u and its source."""
    matrix = analysis.Matrix.create(
        galerkin.context,
        galerkin.solid,
        problem.kind,
        getattr(problem, "young", 1.0),
        getattr(problem, "poisson", 0.0),
    )
    k = sparse(matrix)
    right = galerkin.load(problem.source)
    out = numpy.zeros_like(right)
    out[galerkin.outer] = galerkin.boundary_values(problem.u)
    width = out[0].size
    free = numpy.arange(width * len(galerkin.inner))
    residual = right.ravel() - k @ out.ravel()
    diagonal = scipy.sparse.diags(1 / k.diagonal()[free])
    x, info = scipy.sparse.linalg.cg(
        k[free][:, free], residual[free], tol=1e-12, atol=0, maxiter=20000, M=diagonal
    )
    if info:
        raise AssertionError("conjugate gradients did not converge: %d" % info)
    out.ravel()[free] += x
    return out


def relative_errors(galerkin, make):
    """(L2, energy) relative to the solution's own norms."""
    control = galerkin.data.control[galerkin.outer]
    points = control[:, :3] / control[:, 3:]
    low, high = points.min(axis=0), points.max(axis=0)
    problem = make((low + high) / 2, (high - low).max() / 2)
    found = solve(galerkin, problem)
    l2, size, energy, whole = galerkin.errors(found, problem.u, problem.gradient, problem.energy)
    return l2 / size, energy / whole
