# SPDX-License-Identifier: LGPL-2.1-or-later
"""A few numbers by which a changed shape is told from one that was only saved and read again.

A document gives a shape back with its numbers off by a few units in the last place, so a hash of
its bytes would call every reopened part changed. These are sums of all its coordinates with fixed
irregular factors instead: they hardly move then, but do when one control point moves by 1e-9 of
the part's size.
"""

import math

N_SUMS = 4
RELATIVE = 1e-11  # of the sum of all magnitudes: a million times what a document's round trip costs


def _factors():
    """An endless sequence of fixed numbers between 1/2 and 1, without a pattern."""
    state = 20120713
    while True:
        state = (1103515245 * state + 12345) % (1 << 31)
        yield 0.5 + state / (1 << 32)


def _numbers_of_surface(face):
    surface = face.Surface
    u0, u1, v0, v1 = face.ParameterRange
    yield from (u0, u1, v0, v1)
    if hasattr(surface, "getPoles"):
        for row in surface.getPoles():
            for p in row:
                yield from p
        for row in surface.getWeights():
            yield from row
        for knots in ("UKnotSequence", "VKnotSequence"):
            yield from getattr(surface, knots, ())
        return
    for i in range(3):
        for j in range(3):
            yield from surface.value(u0 + i * (u1 - u0) / 2, v0 + j * (v1 - v0) / 2)


def _numbers_of_edge(edge):
    if edge.Degenerated:
        return
    first, last = edge.ParameterRange
    yield edge.Tolerance
    for i in range(5):
        yield from edge.valueAt(first + i * (last - first) / 4)


def _numbers(shape):
    for face in shape.Faces:
        yield from _numbers_of_surface(face)
    for edge in shape.Edges:
        yield from _numbers_of_edge(edge)


def of_shape(shape):
    """The shape's fingerprint as a list of floats; [] for none."""
    if shape is None or shape.isNull():
        return []
    sums = [0.0] * N_SUMS
    size = 0.0
    factors = _factors()
    count = 0
    for number in _numbers(shape):
        count += 1
        if abs(number) > 1e100:  # "infinite" parameters of planes
            continue
        size += abs(number)
        for k in range(N_SUMS):
            sums[k] += next(factors) * number
    kinds = (len(shape.Solids), len(shape.Faces), len(shape.Edges), len(shape.Vertexes), count)
    return [float(n) for n in kinds] + [size] + sums


def same(a, b):
    """Do two fingerprints belong to the same shape?"""
    if len(a) != len(b) or len(a) < 6 or list(a[:5]) != list(b[:5]):
        return False
    allowed = RELATIVE * max(a[5], b[5])
    return all(math.isfinite(y) and abs(x - y) <= allowed for x, y in zip(a[5:], b[5:]))
