# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads extraction operators as `tsolid export X.tsolid --extraction FILE` writes them.

    solid = read("part.tsolidx")
    x = point(solid, element=0, t=(0.5, 0.5, 0.5))      # t in [0,1]^3 of the element

One little-endian file: 8 bytes, 4 counts, then the arrays in the order below; integers of 64 bits.
Coefficients of a function on an element run with t[0] fastest.
"""

from math import comb
from types import SimpleNamespace

import numpy


def read(path):
    with open(path, "rb") as stream:
        data = stream.read()
    if data[:8] != b"tsolidE1":
        raise ValueError("%s holds no extraction operators" % path)
    n, m, k, c = (int(x) for x in numpy.frombuffer(data, "<i8", 4, 8))
    shapes = {"control": (n, 4), "block": (m,), "box": (m, 6), "degree": (m, 3)}
    shapes.update({"function_start": (m + 1,), "function": (k,), "coefficient": (c,)})
    out, at = SimpleNamespace(n_functions=n, n_elements=m), 40
    for name, shape in shapes.items():
        kind = "<f8" if name in ("control", "box", "coefficient") else "<i8"
        setattr(out, name, numpy.frombuffer(data, kind, int(numpy.prod(shape)), at).reshape(shape))
        at += 8 * int(numpy.prod(shape))
    width = (out.degree + 1).prod(axis=1) * numpy.diff(out.function_start)
    out.coefficient_start = numpy.concatenate(([0], numpy.cumsum(width)))
    return out


def element(solid, e):
    """Functions on an element, and their Bernstein coefficients as rows."""
    functions = solid.function[solid.function_start[e] : solid.function_start[e + 1]]
    rows = solid.coefficient[solid.coefficient_start[e] : solid.coefficient_start[e + 1]]
    return functions, rows.reshape(len(functions), -1)


def point(solid, e, t):
    functions, rows = element(solid, e)
    values = numpy.ones(1)
    for p, x in zip(solid.degree[e], t):
        p = int(p)
        line = [comb(p, i) * x**i * (1 - x) ** (p - i) for i in range(p + 1)]
        values = numpy.multiply.outer(line, values).ravel()
    h = (rows @ values) @ solid.control[functions]
    return h[:3] / h[3]
