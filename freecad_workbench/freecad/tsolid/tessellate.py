# SPDX-License-Identifier: LGPL-2.1-or-later
"""A solid's elements as triangle and line arrays for a 3D view, cut into what a slider needs.

Every face of every element ("half-face") is evaluated once, on a grid as fine as its curvature
asks for, exact on its corners. Which elements are kept changes with every step of a slider; then a
half-face is seen when its element is kept and its neighbour is not, and one step is a choice of
rows from index arrays made before. Needs numpy; no FreeCAD, no Coin.
"""

import itertools

import numpy as np

from . import binding, picture

DEVIATION = 1e-3  # of the part's size: how far a drawn face may be from the true one
STEPS = (2, 4, 8)  # intervals per face and direction
MAX_QUADS = 600000
EDGE_STEPS = 6  # intervals of a line of the T-mesh
SMOOTH = 1e-7  # relative jump of a derivative that counts as none

CORE, FIRST, SECOND = 0, 1, 2
PART_NAMES = ("core", "first layer", "second layer")
PART_COLOURS = ((0.93, 0.50, 0.69), (0.36, 0.58, 0.88), (0.98, 0.80, 0.30))
ORDER_NAMES = ("torn", "continuous (C0)", "tangent (C1)", "curvature (C2)", "outside")
ORDER_COLOURS = ((0.84, 0.15, 0.16), (0.95, 0.60, 0.20), (0.55, 0.78, 0.35), (0.16, 0.52, 0.56),
                 (0.80, 0.82, 0.86))
OUTSIDE = 4
FOLDED = (0.84, 0.15, 0.16)
SCALE = np.array(((0.27, 0.06, 0.36), (0.22, 0.31, 0.55), (0.13, 0.55, 0.55), (0.42, 0.76, 0.37),
                  (0.98, 0.91, 0.25)))


def colour_scale(share):
    """Colours of numbers in [0, 1]: dark violet to yellow, readable in grey too."""
    x = np.clip(np.asarray(share, float), 0, 1) * (len(SCALE) - 1)
    low = np.minimum(x.astype(int), len(SCALE) - 2)
    t = (x - low)[..., None]
    return SCALE[low] * (1 - t) + SCALE[low + 1] * t


def packed(colours):
    """Red, green, blue in [0, 1] as 0xrrggbbff."""
    byte = np.clip(np.rint(np.asarray(colours) * 255), 0, 255).astype(np.uint32)
    return byte[..., 0] << 24 | byte[..., 1] << 16 | byte[..., 2] << 8 | np.uint32(255)


# ---- half-faces ----------------------------------------------------------------------------------


class Faces:
    """All half-faces: number 6 e + 2 axis + end. twin is the half-face on the other side: -1 where
    there is none, or where several smaller ones meet it."""

    def __init__(self, elements):
        n = len(elements)
        height = elements.radius()
        self.element = np.repeat(np.arange(n), 6)
        self.twin = np.full(6 * n, -1)
        self.outside = np.zeros(6 * n, bool)
        users = {}
        for element, axis, end in itertools.product(range(n), range(3), range(2)):
            number = 6 * element + 2 * axis + end
            block = elements.block[element]
            if block == 1 + 2 * axis + end:
                reach = 1 + height[block] if end else -height[block]
                self.outside[number] = abs(elements.box[element, end, axis] - reach) < 1e-9
            key = picture.face_key(elements, height, element, axis, end)
            users.setdefault(key, []).append(number)
        for pair in users.values():
            if len(pair) == 2:
                self.twin[pair[0]], self.twin[pair[1]] = pair[1], pair[0]
        self._join_hanging(elements)

    def _join_hanging(self, elements):
        """Pairs (element, element) that meet in half-faces of different size."""
        loose = np.flatnonzero((self.twin < 0) & ~self.outside)
        groups = {}
        for number in loose:
            element, axis, end = number // 6, number % 6 // 2, number % 2
            place = round(float(elements.box[element, end, axis]) * 1e9)
            groups.setdefault((axis, place), ([], []))[end].append(element)
        pairs = []
        for (axis, _), (low, high) in groups.items():
            if low and high:
                a, b = np.array(low), np.array(high)
                meet = np.ones((len(a), len(b)), bool)
                for other in (k for k in range(3) if k != axis):
                    lo, hi = elements.box[:, 0, other], elements.box[:, 1, other]
                    meet &= np.minimum(hi[a][:, None], hi[b]) - np.maximum(lo[a][:, None], lo[b]) \
                        > 1e-12
                rows, columns = np.nonzero(meet)
                pairs.append(np.stack([a[rows], b[columns]], 1))
        self.hanging = np.concatenate(pairs) if pairs else np.zeros((0, 2), int)

    def neighbours(self):
        """Pairs of elements that share a face or a part of one."""
        paired = np.flatnonzero(self.twin >= 0)
        pairs = np.stack([self.element[paired], self.element[self.twin[paired]]], 1)
        return np.concatenate([pairs, self.hanging, self.hanging[:, ::-1]])


def depths(n, faces):
    """How many elements lie between each element and the outside: 0 for those that touch it."""
    depth = np.full(n, -1)
    depth[np.unique(faces.element[faces.outside])] = 0
    pairs = faces.neighbours()
    step = 0
    while (depth < 0).any():
        reached = pairs[(depth[pairs[:, 0]] == step) & (depth[pairs[:, 1]] < 0), 1]
        if not len(reached):
            depth[depth < 0] = step + 1  # not reached at all: cannot be, and must not hang
            break
        step += 1
        depth[reached] = step
    return depth


def parts(elements):
    """CORE, FIRST or SECOND layer, per element: an arm is split halfway."""
    height = elements.radius()
    out = np.zeros(len(elements), int)
    for side in range(6):
        mine = np.flatnonzero(elements.block == side + 1)
        axis = side // 2
        middle = elements.box[mine][:, :, axis].mean(1)
        radius = middle - 1 if side % 2 else -middle
        out[mine] = np.where(radius > height[side + 1] / 2, SECOND, FIRST)
    return out


# ---- how fine ------------------------------------------------------------------------------------


def _bend(nets, axis, end):
    """How far each face of a group is from the polygon of its corner lines, at most, in one
    direction: from second differences of the control points."""
    points = nets[..., :3] / nets[..., 3:]
    face = points[(slice(None),) * (3 - axis) + (-1 if end else 0,)]
    bend = np.zeros(len(nets))
    for direction in (1, 2):
        p = face.shape[direction] - 1
        if p > 1:
            second = np.diff(face, 2, axis=direction)
            largest = np.sqrt((second**2).sum(-1)).max((1, 2))
            bend = np.maximum(bend, largest * p * (p - 1) / 8)
    return bend


def _steps(bend, allowed):
    wanted = np.sqrt(bend / max(allowed, 1e-300))
    return np.array(STEPS)[np.minimum(np.searchsorted(STEPS, wanted), len(STEPS) - 1)]


# ---- smoothness ----------------------------------------------------------------------------------


def _across(nets, axis, end, width):
    """Value and first two derivatives across a face, homogeneous, on a grid of it:
    [element, order, places, 4]."""
    grid = np.array((0.0, 0.31, 0.5, 0.77, 1.0))
    moved = np.moveaxis(nets, 3 - axis, 1)
    degree = moved.shape[1] - 1
    take = (-1, -2, -3) if end else (0, 1, 2)
    sign = 1.0 if end else -1.0
    lateral = [picture.bernstein(moved.shape[k] - 1, grid)[0] for k in (2, 3)]

    def on_grid(values):
        return np.einsum("ejic,yj,xi->eyxc", values, *lateral).reshape(len(nets), -1, 4)

    p = [on_grid(moved[:, take[k]]) for k in range(min(3, degree + 1))]
    h = width[:, None, None]
    zero = np.zeros_like(p[0])
    first = sign * degree * (p[0] - p[1]) / h
    second = degree * (degree - 1) * (p[0] - 2 * p[1] + p[2]) / h**2 if degree > 1 else zero
    return np.stack([p[0], first, second], 1)


def orders(elements, faces, groups):
    """Smoothness across each half-face: 0 torn, 1 C0, 2 C1, 3 C2 or more; OUTSIDE."""
    n = 6 * len(elements)
    out = np.where(faces.outside, OUTSIDE, 1)
    values = np.zeros((n, 3, 25, 4))
    for (_, axis, end), members, nets in groups:
        width = elements.box[members, 1, axis] - elements.box[members, 0, axis]
        values[6 * members + 2 * axis + end] = _across(nets, axis, end, width)
    a = np.flatnonzero(faces.twin >= 0)
    b = faces.twin[a]
    straight = (a % 6) // 2 == (b % 6) // 2
    straight &= a % 2 != b % 2
    a, b = a[straight], b[straight]
    jump = np.abs(values[a] - values[b]).max((2, 3))
    size = np.maximum(np.abs(values[a]).max((2, 3)), np.abs(values[b]).max((2, 3)))
    size[:, 2] = np.maximum(size[:, 2], size[:, 1])
    smooth = jump <= SMOOTH * size
    out[a] = np.where(smooth[:, 0], np.where(smooth[:, 1], np.where(smooth[:, 2], 3, 2), 1), 0)
    return out


# ---- volume --------------------------------------------------------------------------------------


def points_and_tangents(nets, grid):
    """Points of elements of one degree, and their three derivatives, on grid x grid x grid.

    nets: homogeneous Bezier nets [element, k, j, i, 4]; the results are [element, z, y, x, 3].
    """
    basis = [picture.bernstein(nets.shape[3 - a] - 1, grid) for a in range(3)]

    def at(derived):
        b = [basis[a][1 if a == derived else 0] for a in range(3)]
        step = np.einsum("ekjic,xi->ekjxc", nets, b[0])
        step = np.einsum("ekjxc,yj->ekyxc", step, b[1])
        return np.einsum("ekyxc,zk->ezyxc", step, b[2])

    value = at(None)
    point = value[..., :3] / value[..., 3:]
    derivatives = [at(a) for a in range(3)]
    return point, [(d[..., :3] - point * d[..., 3:]) / value[..., 3:] for d in derivatives]


def volumes(groups_by_degree, n):
    """Volume of each element by Gauss quadrature (exact enough to colour by)."""
    out = np.zeros(n)
    x, w = np.polynomial.legendre.leggauss(5)
    x, w = (x + 1) / 2, w / 2
    for members, nets in groups_by_degree:
        _, tangent = points_and_tangents(nets, x)
        det = np.einsum("...i,...i->...", tangent[0], np.cross(tangent[1], tangent[2]))
        out[members] = np.einsum("ezyx,z,y,x->e", det, w, w, w)
    return out


# ---- all of it -----------------------------------------------------------------------------------


def face_field(nets, axis, end, n):
    """Values on the grid of picture.face_values, of nets with any number of components."""
    grid = np.linspace(0, 1, n + 1)
    b = [picture.bernstein(nets.shape[3 - a] - 1, [float(end)] if a == axis else grid)[0]
         for a in range(3)]
    result = np.einsum("ekjic,zk->ezjic", nets, b[2])
    result = np.einsum("ezjic,yj->ezyic", result, b[1])
    return np.squeeze(np.einsum("ezyic,xi->ezyxc", result, b[0]), axis=3 - axis)


def volume_field(nets, grid):
    """Values on grid x grid x grid: [element, z, y, x, component]."""
    b = [picture.bernstein(nets.shape[3 - a] - 1, grid)[0] for a in range(3)]
    result = np.einsum("ekjic,xi->ekjxc", nets, b[0])
    result = np.einsum("ekjxc,yj->ekyxc", result, b[1])
    return np.einsum("ekyxc,zk->ezyxc", result, b[2])


def size_of(values):
    """A number as it is, the length of a vector; the last one is the weight."""
    field = values[..., :-1] / values[..., -1:]
    return field[..., 0] if field.shape[-1] == 1 else np.sqrt((field**2).sum(-1))


class Rows:
    """Half-faces drawn with the same number of intervals, as rows of indices; quads turn left as
    seen from outside their element."""

    STOP = -(1 << 40)  # becomes Coin's -1, whatever is added to it

    def __init__(self, n, number, start):
        self.number = number  # of the half-faces
        axis, end = number % 6 // 2, number % 2
        j, i = np.divmod(np.arange(n * n), n)
        a = j * (n + 1) + i
        stop = np.full_like(a, self.STOP)
        left = np.stack([a, a + 1, a + n + 2, a + n + 1, stop], 1).reshape(-1)
        right = np.stack([a, a + n + 1, a + n + 2, a + 1, stop], 1).reshape(-1)
        # The grid's axes are the other two in increasing order: x and z, not z and x, over y.
        turns_left = (axis == 1) ^ (end == 1)
        quad = np.where(turns_left[:, None], left, right)
        k = np.arange(n + 1)
        stop = np.array([self.STOP])
        line = np.concatenate([k, stop, k * (n + 1), stop, k * (n + 1) + n, stop,
                               k + n * (n + 1), stop])
        self.quads = np.maximum(start[:, None] + quad, -1).astype(np.int32)
        self.lines = np.maximum(start[:, None] + line, -1).astype(np.int32)


class Look:
    """Everything that the 3D view shows of one solid."""

    def __init__(self, elements, deviation=DEVIATION):
        self.elements = elements
        self.faces = Faces(elements)
        self.n = len(elements)
        self.depth = depths(self.n, self.faces)
        self.part = parts(elements)
        groups = self._groups()
        self.order = orders(elements, self.faces, groups)
        self.volume = volumes(self.degree_groups(), self.n)
        corner = np.stack([self._corner(c) for c in range(8)], 1)
        self.corner = corner
        self.centre = corner.mean(1)
        self.low, self.high = corner.min((0, 1)), corner.max((0, 1))
        self.size = float(np.linalg.norm(self.high - self.low))
        self.edge_length = self._edge_lengths()
        self._evaluate(groups, deviation * self.size)
        self._jacobian_range()

    # numbers of elements with equal degrees, and their nets

    def degree_groups(self):
        kinds, which = np.unique(self.elements.degree, axis=0, return_inverse=True)
        which = which.reshape(-1)
        out = []
        for k in range(len(kinds)):
            members = np.flatnonzero(which == k)
            out.append((members, np.stack([self.elements.net[e] for e in members])))
        return out

    def _groups(self):
        out = []
        for members, nets in self.degree_groups():
            degree = tuple(self.elements.degree[members[0]])
            for axis, end in itertools.product(range(3), range(2)):
                out.append(((degree, axis, end), members, nets))
        return out

    def _corner(self, c):
        pick = tuple(-1 if c >> a & 1 else 0 for a in (2, 1, 0))
        rows = np.array([net[pick] for net in self.elements.net])
        return rows[:, :3] / rows[:, 3:]

    def _edge_lengths(self):
        pairs = [(c, c | 1 << a) for a in range(3) for c in range(8) if not c >> a & 1]
        gaps = [np.linalg.norm(self.corner[:, a] - self.corner[:, b], axis=1) for a, b in pairs]
        return np.mean(gaps, 0)

    def _evaluate(self, groups, allowed):
        numbers, steps, keep = [], [], []
        for (_, axis, end), members, nets in groups:
            numbers.append(6 * members + 2 * axis + end)
            steps.append(_steps(_bend(nets, axis, end), allowed))
        most = sum(int((s.astype(np.int64) ** 2).sum()) for s in steps)
        if most > MAX_QUADS:
            steps = [np.minimum(s, 4) if most < 4 * MAX_QUADS else np.full_like(s, 2)
                     for s in steps]
        points, normals, jacobians, starts, total, plan = [], [], [], {}, 0, []
        for ((_, axis, end), members, nets), number, step in zip(groups, numbers, steps):
            for n in STEPS:
                some = np.flatnonzero(step == n)
                if not len(some):
                    continue
                p, q, j = picture.face_values(nets[some], axis, end, n)
                plan.append((axis, end, members[some], n))
                points.append(p.reshape(-1, 3))
                normals.append(q.reshape(-1, 3))
                jacobians.append(j.reshape(-1))
                size = (n + 1) ** 2
                first = total + size * np.arange(len(some))
                starts.setdefault(n, []).append((number[some], first))
                keep.append((np.repeat(number[some], size)))
                total += size * len(some)
        self.plan = plan
        self.point = np.concatenate(points).astype(np.float32)
        self.normal = np.concatenate(normals).astype(np.float32)
        self.jacobian = np.concatenate(jacobians)
        self.half_face = np.concatenate(keep)  # of each vertex
        self.rows = []
        for n, lists in sorted(starts.items()):
            number = np.concatenate([a for a, _ in lists])
            start = np.concatenate([b for _, b in lists])
            self.rows.append(Rows(n, number, start))

    def _jacobian_range(self):
        element = self.faces.element[self.half_face]
        self.lowest = np.full(self.n, np.inf)
        self.highest = np.full(self.n, -np.inf)
        np.minimum.at(self.lowest, element, self.jacobian)
        np.maximum.at(self.highest, element, self.jacobian)

    # ---- a result ----

    result = None  # numbers at the vertices; a vector's length
    result_name = ""
    result_nets = None
    result_range = (0.0, 1.0)

    def set_result(self, name, nets):
        """nets: see results.nets; None: no result."""
        self.result_name, self.result, self.result_nets = name, None, None
        if nets is None:
            return
        self.result_nets = [np.concatenate([f, g[..., 3:]], -1)
                            for f, g in zip(nets, self.elements.net)]
        parts = []
        for axis, end, members, n in self.plan:
            group = np.stack([self.result_nets[e] for e in members])
            parts.append(size_of(face_field(group, axis, end, n)).reshape(-1))
        self.result = np.concatenate(parts)
        self.result_range = float(self.result.min()), float(self.result.max())

    def result_colours(self, values):
        if self.result is None:
            return np.tile(ORDER_COLOURS[OUTSIDE], (len(values), 1))
        low, high = self.result_range
        return colour_scale((values - low) / max(high - low, 1e-300))

    # ---- what a slider step asks for ----

    @property
    def n_layers(self):
        return int(self.depth.max()) + 1

    def kept(self, peel=0, axis=None, share=1.0):
        """Elements that remain: deeper than `peel` layers, and with their middle on the low side
        of a plane across `axis` at that share of the part."""
        kept = self.depth >= peel
        if axis is not None and share < 1.0:
            place = self.low[axis] + share * (self.high[axis] - self.low[axis])
            kept &= self.centre[:, axis] <= place
        return kept

    def seen(self, kept):
        """Which half-faces are seen, given the elements that remain."""
        mine = kept[self.faces.element]
        twin = self.faces.twin
        other = np.where(twin >= 0, kept[self.faces.element[twin]], False)
        return mine & ~other

    def indices(self, seen):
        """Quad indices, line indices and, per quad, its half-face."""
        quads, lines, owner = [], [], []
        for rows in self.rows:
            some = seen[rows.number]
            chosen = rows.quads[some]
            quads.append(chosen.reshape(-1))
            lines.append(rows.lines[some].reshape(-1))
            owner.append(np.repeat(rows.number[some], chosen.shape[1] // 5))
        return np.concatenate(quads), np.concatenate(lines), np.concatenate(owner)

    # ---- colours ----

    def colours(self, by):
        """Per vertex, packed; by: one of actions.COLOURS."""
        element = self.faces.element[self.half_face]
        if by == "Scaled Jacobian":
            rgb = colour_scale(self.jacobian)
            rgb[self.jacobian <= 0] = FOLDED
        elif by == "Continuity":
            rgb = np.array(ORDER_COLOURS)[self.order[self.half_face]]
        elif by == "Element size":
            low, high = self.size_range()
            rgb = colour_scale((np.cbrt(np.abs(self.volume)) - low) / max(high - low, 1e-300))
            rgb = rgb[element]
        elif by == "Parts":
            rgb = np.array(PART_COLOURS)[self.part[element]]
        elif by == "Result":
            rgb = self.result_colours(self.half_face if self.result is None else self.result)
        else:
            raise ValueError("no such colouring: %s" % by)
        return packed(rgb)

    def size_range(self):
        sizes = np.cbrt(np.abs(self.volume))
        return float(sizes.min()), float(sizes.max())

    # ---- facts ----

    def facts(self, element):
        """What is known of one element: (what, value) rows."""
        e = int(element)
        block = int(self.elements.block[e])
        where = PART_NAMES[self.part[e]]
        if block:
            where += ", over side " + binding.SIDE_NAMES[block - 1]
        return [
            ("element", e),
            ("part", where),
            ("layers above it", int(self.depth[e])),
            ("scaled Jacobian, lowest", float(self.lowest[e])),
            ("scaled Jacobian, highest", float(self.highest[e])),
            ("volume", float(self.volume[e])),
            ("mean edge length", float(self.edge_length[e])),
            ("degrees", " x ".join(str(int(d)) for d in self.elements.degree[e])),
            ("middle", tuple(float(x) for x in self.centre[e])),
            ("least smooth face inside", self._least_smooth(e)),
        ]

    def _least_smooth(self, e):
        inside = self.order[6 * e:6 * e + 6]
        inside = inside[inside != OUTSIDE]
        return ORDER_NAMES[inside.min()] if len(inside) else ORDER_NAMES[OUTSIDE]

    def outline(self, element):
        """The twelve edges of an element as a polyline list [12, m, 3]."""
        net = self.elements.net[int(element)]
        return np.stack([edge_points(net[None], *k)[0] for k in edges()])


def edges():
    """The twelve edges of a box: (axis along, end of the next axis, end of the one after)."""
    return list(itertools.product(range(3), range(2), range(2)))


def edge_points(nets, axis, first, second, n=EDGE_STEPS):
    """Points of one edge of elements of equal degrees: [element, n + 1, 3]."""
    pick = [slice(None)] * 5
    others = [(axis + 1) % 3, (axis + 2) % 3]
    for other, end in zip(others, (first, second)):
        pick[3 - other] = -1 if end else 0
    line = nets[tuple(pick)]
    values = np.einsum("eic,xi->exc", line,
                       picture.bernstein(line.shape[1] - 1, np.linspace(0, 1, n + 1))[0])
    return values[..., :3] / values[..., 3:]


class Lines:
    """Edges of the T-mesh's cells: point array, and per element rows of indices."""

    def __init__(self, look, tmesh):
        elements = look.elements
        on_cell = _on_cell_edges(elements, tmesh)
        points, index, owner, total = [], [], [], 0
        size = EDGE_STEPS + 1
        for members, nets in look.degree_groups():
            for k, edge in enumerate(edges()):
                some = np.flatnonzero(on_cell[members, k])
                if not len(some):
                    continue
                points.append(edge_points(nets[some], *edge).reshape(-1, 3))
                row = total + size * np.arange(len(some))[:, None] + np.arange(size)
                stop = np.full((len(some), 1), -1)
                index.append(np.concatenate([row, stop], 1))
                owner.append(members[some])
                total += size * len(some)
        self.point = np.concatenate(points).astype(np.float32)
        self.index = np.concatenate(index).astype(np.int32)
        self.owner = np.concatenate(owner)

    def indices(self, kept):
        return self.index[kept[self.owner]].reshape(-1)

    def colours(self, look):
        return packed(np.array(PART_COLOURS)[look.part[np.repeat(self.owner, EDGE_STEPS + 1)]])


def _on_cell_edges(elements, tmesh):
    """Which of an element's twelve edges lie on edges of its cell: [element, 12]."""
    cells = np.array(tmesh.cells).reshape(-1, 2, 3)
    blocks = np.array(tmesh.cell_blocks)
    value = [np.array(tmesh.plane_values(a)) for a in range(3)]
    box = np.stack([value[a][cells[:, :, a]] for a in range(3)], 2)
    cell = np.zeros(len(elements), int)
    middle = elements.box.mean(1)
    for block in range(7):
        mine = np.flatnonzero(elements.block == block)
        theirs = np.flatnonzero(blocks == block)
        for start in range(0, len(mine), 256):
            some = mine[start:start + 256]
            inside = (middle[some][:, None] > box[theirs, 0]) & (
                middle[some][:, None] < box[theirs, 1])
            cell[some] = theirs[np.argmax(inside.all(2), 1)]
    at_end = np.abs(elements.box - box[cell]) < 1e-12  # [element, end, axis]
    out = np.zeros((len(elements), 12), bool)
    for k, (axis, first, second) in enumerate(edges()):
        out[:, k] = at_end[:, first, (axis + 1) % 3] & at_end[:, second, (axis + 2) % 3]
    return out


class ControlNet:
    """Straight lines between the Bezier control points of each half-face."""

    def __init__(self, look):
        points, total = [], 0
        self.rows = []  # (half-faces, their rows of indices)
        for (_, axis, end), members, nets in look._groups():
            face = np.take(nets, -1 if end else 0, axis=3 - axis)
            n, m = face.shape[1:3]
            number = np.arange(n * m).reshape(n, m)
            pairs = [np.stack([a.reshape(-1), b.reshape(-1), np.full(a.size, Rows.STOP)], 1)
                     for a, b in ((number[:-1], number[1:]), (number[:, :-1], number[:, 1:]))]
            pairs = np.concatenate(pairs).reshape(-1)
            start = total + n * m * np.arange(len(members))
            index = np.maximum(start[:, None] + pairs, -1).astype(np.int32)
            self.rows.append((6 * members + 2 * axis + end, index))
            points.append((face[..., :3] / face[..., 3:]).reshape(-1, 3))
            total += n * m * len(members)
        self.point = np.concatenate(points).astype(np.float32)

    def indices(self, seen):
        return np.concatenate([index[seen[number]].reshape(-1) for number, index in self.rows])

    def colours(self, look):
        return packed(np.tile((0.25, 0.28, 0.33), (len(self.point), 1)))
