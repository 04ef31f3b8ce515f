# SPDX-License-Identifier: LGPL-2.1-or-later
"""A solid cut by a plane: the section's triangles and the borders of the blocks on it.

Every element is sampled once on a grid, exactly; a grid cell is taken as six tetrahedra round its
diagonal (the same diagonal on a face that two cells share), and a plane cuts a tetrahedron in a
triangle or in two. Needs numpy; no FreeCAD, no Coin.
"""

import itertools

import numpy as np

from . import picture, tessellate

N = 3  # intervals of the grid per direction
SIZE = N + 1


def _number(i, j, k):
    return i + SIZE * (j + SIZE * k)


def _tetrahedra():
    """Rows of 4 grid points, for all cells of one element: [cell, 6, 4]."""
    rows = []
    for k, j, i in itertools.product(range(N), repeat=3):
        for order in itertools.permutations(range(3)):
            place = [i, j, k]
            row = [_number(*place)]
            for axis in order:
                place[axis] += 1
                row.append(_number(*place))
            rows.append(row)
    return np.array(rows).reshape(-1, 6, 4)


def _face_triangles():
    """Rows of 3 grid points: the six faces of one element, [quad, 2, 3]."""
    rows = []
    for axis, end in itertools.product(range(3), (0, N)):
        a, b = [x for x in range(3) if x != axis]
        for i, j in itertools.product(range(N), repeat=2):
            def at(p, q):
                place = [0, 0, 0]
                place[axis], place[a], place[b] = end, i + p, j + q
                return _number(*place)

            rows += [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(0, 1), at(1, 1)]]
    return np.array(rows).reshape(-1, 2, 3)


def _corners_of(rows):
    """The distinct grid points of each cell."""
    return np.array([sorted(set(row)) for row in rows.reshape(len(rows), -1).tolist()])


TETRAHEDRA = _tetrahedra()
TRIANGLES = _face_triangles()
TETRAHEDRON_CORNERS, TRIANGLE_CORNERS = _corners_of(TETRAHEDRA), _corners_of(TRIANGLES)


class Grids:
    """Points [element, grid point, 3] and scaled Jacobians [element, grid point] of all elements,
    and each element's extent."""

    def __init__(self, look):
        self.look = look
        self.point = np.empty((look.n, SIZE**3, 3), np.float32)
        self.jacobian = np.empty((look.n, SIZE**3), np.float32)
        for members, nets in look.degree_groups():
            point, jacobian = _values(nets)
            self.point[members] = point.reshape(len(members), -1, 3)
            self.jacobian[members] = jacobian.reshape(len(members), -1)
        self.low, self.high = self.point.min(1), self.point.max(1)
        self.nets, self.value = None, np.zeros(self.jacobian.shape, np.float32)

    def result(self):
        """The look's result at the grid points; made anew when it is another one."""
        if self.look.result_nets is not self.nets:
            self.nets = self.look.result_nets
            self.value = np.zeros(self.jacobian.shape, np.float32)
            for members, _ in self.look.degree_groups() if self.nets is not None else ():
                group = np.stack([self.nets[e] for e in members])
                field = tessellate.volume_field(group, np.linspace(0, 1, SIZE))
                self.value[members] = tessellate.size_of(field).reshape(len(members), -1)
        return self.value

    def touches(self, axis, place):
        """Elements of which something lies on the low side of the plane."""
        return self.low[:, axis] < place

    def cut(self, kept, axis, place, values=None):
        """(points of triangles, their values, element of each triangle, points of segments) on the
        plane where coordinate `axis` is `place`; values at grid points, None: Jacobians."""
        values = self.jacobian if values is None else values
        mine = np.flatnonzero(
            kept & (self.low[:, axis] < place) & (self.high[:, axis] > place))
        height = self.point[mine, :, axis] - np.float32(place)
        points = self.point[mine]
        data = np.concatenate([points, values[mine][..., None]], 2)
        triangles, owner = _cut_tetrahedra(height, data)
        segments = _cut_triangles(height, points)
        triangles[..., axis] = place
        segments[..., axis] = place
        return triangles[..., :3], triangles[..., 3], mine[owner], segments


def _values(nets):
    point, tangent = tessellate.points_and_tangents(nets, np.linspace(0, 1, SIZE))
    tangent = [picture.unit_vectors(t) for t in tangent]
    return point, np.einsum("...i,...i->...", tangent[0], np.cross(tangent[1], tangent[2]))


def _crossing(height, data, a, b):
    """Data where the lines between grid points a and b cross the plane."""
    ha, hb = np.take(height, a), np.take(height, b)
    t = (ha / (ha - hb))[:, None]
    start = np.take(data, a, axis=0)
    return start + t * (np.take(data, b, axis=0) - start)


def _sorted_rows(height, rows):
    """(element, corners with those below the plane first, how many are below) of all shapes that
    the plane cuts; rows: [cell, shape, corner]. Cells are sorted out before their shapes are."""
    below = height <= 0
    corners = TETRAHEDRON_CORNERS if rows is TETRAHEDRA else TRIANGLE_CORNERS
    some = below[:, corners]
    element, cell = np.nonzero(some.any(2) & ~some.all(2))
    corner = rows[cell].reshape(-1, rows.shape[2])
    element = np.repeat(element, rows.shape[1])
    low = below[element[:, None], corner]
    count = low.sum(1)
    cut = np.flatnonzero((count > 0) & (count < rows.shape[2]))
    order = np.argsort(~low[cut], axis=1, kind="stable")
    return element[cut], np.take_along_axis(corner[cut], order, 1), count[cut]


def _single_and_others(corner, count):
    """The corner that is alone on its side of the plane, and the rest."""
    alone_below = count == 1
    single = np.where(alone_below, corner[:, 0], corner[:, -1])
    return single, np.where(alone_below[:, None], corner[:, 1:], corner[:, :-1])


def _cut_tetrahedra(height, data):
    element, corner, count = _sorted_rows(height, TETRAHEDRA)
    corner += element[:, None] * SIZE**3
    height, data = height.reshape(-1), data.reshape(-1, data.shape[2])
    two = count == 2
    single, others = _single_and_others(corner[~two], count[~two])
    ends = [_crossing(height, data, single, others[:, k]) for k in range(3)]
    c = corner[two]
    p, q, r, s = (_crossing(height, data, c[:, a], c[:, b])
                  for a, b in ((0, 2), (0, 3), (1, 3), (1, 2)))
    out = [np.stack(ends, 1), np.stack((p, q, r), 1), np.stack((p, r, s), 1)]
    owner = [element[~two], element[two], element[two]]
    return np.concatenate(out), np.concatenate(owner)


def _cut_triangles(height, points):
    element, corner, count = _sorted_rows(height, TRIANGLES)
    corner += element[:, None] * SIZE**3
    height, points = height.reshape(-1), points.reshape(-1, 3)
    single, others = _single_and_others(corner, count)
    return np.stack([_crossing(height, points, single, others[:, k]) for k in (0, 1)], 1)


_TABLE = tessellate.packed(tessellate.colour_scale(np.linspace(0, 1, 1024)))


def colours(look, by, jacobian, owner):
    """Packed colours per corner of the section's triangles; jacobian: the values of the cut."""
    if by == "Scaled Jacobian":
        jacobian = jacobian.reshape(-1)
        out = _TABLE[(np.clip(jacobian, 0, 1) * (len(_TABLE) - 1)).astype(np.int32)]
        out[jacobian <= 0] = tessellate.packed(tessellate.FOLDED)
        return out
    if by == "Result":
        return tessellate.packed(look.result_colours(jacobian.reshape(-1)))
    if by == "Element size":
        low, high = look.size_range()
        sizes = np.cbrt(np.abs(look.volume[owner]))
        rgb = tessellate.colour_scale((sizes - low) / max(high - low, 1e-300))
    elif by == "Parts":
        rgb = np.array(tessellate.PART_COLOURS)[look.part[owner]]
    else:
        rgb = np.tile(tessellate.ORDER_COLOURS[tessellate.OUTSIDE], (len(owner), 1))
    return np.repeat(tessellate.packed(rgb), 3)
