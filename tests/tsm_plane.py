# SPDX-License-Identifier: LGPL-2.1-or-later
"""Open .tsm surfaces without stars, evaluated slowly and on their own terms; and open test meshes.

The faces are unfolded into a plane. Lines are segments there; multiple knots are copies of them at
infinitesimal distance, so that all coordinates are pairs (value, offset), compared as such. A ray
meets every segment that it touches; points follow by the recursion of Cox and de Boor.

    surface = PlaneSurface(text)
    surface.point(face, u, v), surface.sum(face, u, v)
    text = Mesh(values, boxes).text(place)     an open T-mesh, with Bezier ends or without
"""

import collections

TURN = ((1, 0), (0, 1), (-1, 0), (0, -1))
COMPASS = {"EAST": 0, "NORTH": 1, "WEST": 2, "SOUTH": 3}
SAME = 1e-9  # positions are sums of decimal intervals


def bspline(t, x):
    """The cubic B-spline of five knots; at its end continuous from inside where it can be."""

    def value(i, p):
        if p == 0:
            return 1.0 if t[i] <= x < t[i + 1] else 0.0
        total = 0.0
        if t[i + p] > t[i]:
            total += (x - t[i]) / (t[i + p] - t[i]) * value(i, p - 1)
        if t[i + p + 1] > t[i + 1]:
            total += (t[i + p + 1] - x) / (t[i + p + 1] - t[i + 1]) * value(i + 1, p - 1)
        return total

    return value(0, 3)


class PlaneSurface:
    def __init__(self, text):
        self._read(text)
        self._unfold()
        self._find_segments()
        self.functions = []
        for vertex in self.vertices:
            self._add_functions(vertex)

    # ---- the file --------------------------------------------------------------------------------

    def _read(self, text):
        rows = collections.defaultdict(list)
        for line in text.replace("\r\n", "\n").split("\n"):
            words = line.split("#")[0].split()
            if words:
                rows[words[0]].append(words[1:])
        self.links = {i: list(map(int, w)) for i, w in enumerate(rows["l"]) if w}
        self.interval = {i: float(w[1]) for i, w in enumerate(rows["e"]) if w}
        self.faces = {i: int(w[0]) for i, w in enumerate(rows["f"]) if w}
        self.vertices = {i: (int(w[0]), COMPASS[w[1]]) for i, w in enumerate(rows["v"]) if w}
        self.grips = {i: tuple(map(float, w)) for i, w in enumerate(rows["0g"]) if w}
        maps = [w for w in rows["0m"] if w[0] in ("gvp", "gv")]
        self.extra = {v: (0, 0, 0, 0) for v in self.vertices}
        self.block = {}
        if not maps:
            self.block = {v: {(0, 0): v} for v in self.vertices}
        for grip, (kind, vertex) in enumerate(maps):
            if kind == "gvp":
                self.block[int(vertex)] = {(0, 0): grip}
        for words in rows["0m"]:
            if words[0] == "cg":
                self._read_block(list(map(int, words[1:])))

    def _read_block(self, numbers):
        vertex, counts, grips = numbers[0], numbers[2:6], iter(numbers[6:])
        wedge = (1, 2, 3, 0)  # north, west, south, east
        for k in range(4):
            (ax, ay), (bx, by) = TURN[wedge[k]], TURN[wedge[(k + 1) % 4]]
            for r in range(1, counts[k] + 1):
                for c in range(counts[(k + 1) % 4] + 1):
                    self.block[vertex][r * ax + c * bx, r * ay + c * by] = next(grips)
        self.extra[vertex] = tuple(counts[wedge.index(d)] for d in range(4))

    # ---- into the plane --------------------------------------------------------------------------

    def _unfold(self):
        """direction and start of every link of a face, in one plane."""
        self.where, self.box, self.turn = {}, {}, {}
        first = min(self.faces)
        queue = [(self.faces[first], 0, (0.0, 0.0))]
        self.frame = {}
        while queue:
            link, k, at = queue.pop(0)
            face = self.links[link][4]
            if face in self.box:
                continue
            loop, i = [], link
            while True:
                loop.append(i)
                i = self.links[i][1]
                if i == link:
                    break
            direction, corners = k, []
            for n, i in enumerate(loop):
                if n and self.links[i][6] == 0:
                    direction = (direction + 1) % 4
                step = self.interval[self.links[i][5]]
                self.where[i] = (direction, at)
                if i == self.faces[face]:
                    self.frame[face] = (direction, at)
                corners.append(at)
                at = (at[0] + step * TURN[direction][0], at[1] + step * TURN[direction][1])
                other = self.links[i][2]
                if self.links[other][4] >= 0:
                    queue.append((other, (direction + 2) % 4, at))
            xs, ys = [c[0] for c in corners], [c[1] for c in corners]
            self.box[face] = (min(xs), max(xs), min(ys), max(ys))
        for link, (_, opposite) in ((i, (0, m[2])) for i, m in self.links.items() if m[4] < 0):
            direction, at = self.where[opposite]
            step = self.interval[self.links[link][5]]
            x, y = TURN[direction]
            self.where[link] = ((direction + 2) % 4, (at[0] + step * x, at[1] + step * y))

    def _turned(self, vertex, values):
        """From compass directions to those of the plane."""
        link, compass = self.vertices[vertex]
        shift = (self.where[link][0] - compass) % 4
        return tuple(values[(d - shift) % 4] for d in range(4)), shift

    def _find_segments(self):
        """(axis, position, low, high): a line across `axis` = position, with offsets."""
        self.place, self.extras, self.shift, self.segments = {}, {}, {}, ([], [])
        for vertex, (link, _) in self.vertices.items():
            self.place[vertex] = self.where[link][1]
            self.extras[vertex], self.shift[vertex] = self._turned(vertex, self.extra[vertex])
        for vertex, at in self.place.items():
            e = self.extras[vertex]
            for axis in (0, 1):
                low, high = (at[1 - axis], -e[3 - axis]), (at[1 - axis], e[1 - axis])
                for k in range(-e[2 + axis], e[axis] + 1):
                    self.segments[axis].append(((at[axis], k), low, high))
        for link, (direction, at) in self.where.items():
            if direction > 1:
                continue
            p, q = self.links[link][3], self.links[self.links[link][1]][3]
            axis = 1 - direction  # the line is across this axis
            ends = (self.extras[p], self.extras[q])
            below = min(e[2 + axis] for e in ends)
            above = min(e[axis] for e in ends)
            start, step = at[1 - axis], self.interval[self.links[link][5]]
            for k in range(-below, above + 1):
                self.segments[axis].append(((at[axis], k), (start, 0), (start + step, 0)))

    def _inside(self, x, y):
        return any(
            b[0] - SAME <= x <= b[1] + SAME and b[2] - SAME <= y <= b[3] + SAME
            for b in self.box.values()
        )

    # ---- functions -------------------------------------------------------------------------------

    @staticmethod
    def _compare(a, b):
        if abs(a[0] - b[0]) > SAME:
            return -1 if a[0] < b[0] else 1
        return (a[1] > b[1]) - (a[1] < b[1])

    def _knots(self, axis, sign, at, row):
        """Two knots from `at` = (value, offset) along axis and sign, at `row` of the other axis."""
        hits = []
        for position, low, high in self.segments[axis]:
            ahead = self._compare(position, at) * sign > 0
            if ahead and self._compare(low, row) <= 0 <= self._compare(high, row):
                if not any(self._compare(position, h) == 0 for h in hits):
                    hits.append(position)
        hits.sort(key=lambda h: (round(h[0] / SAME) * sign, h[1] * sign))
        out, here = [], at[0]
        for h in hits:
            middle = [0.0, 0.0]
            middle[axis], middle[1 - axis] = 0.5 * (here + h[0]), row[0]
            if abs(h[0] - here) > SAME and not self._inside(*middle):
                break
            here = h[0]
            out.append(here)
        return (out + [here, here])[:2]

    def _add_functions(self, vertex):
        x, y = self.place[vertex]
        for offset, grip in self.block[vertex].items():
            if grip < 0 or grip not in self.grips:
                continue
            c, s = TURN[self.shift[vertex]]
            i, j = c * offset[0] - s * offset[1], s * offset[0] + c * offset[1]
            knots = []
            for axis, at, row in ((0, (x, i), (y, j)), (1, (y, j), (x, i))):
                low = self._knots(axis, -1, at, row)
                knots.append(low[::-1] + [at[0]] + self._knots(axis, 1, at, row))
            self.functions.append((grip, knots, self._reach(vertex, knots)))

    def _reach(self, vertex, knots):
        """The faces that the support reaches from the vertex, over edges inside it."""
        (x0, x1), (y0, y1) = (knots[0][0], knots[0][4]), (knots[1][0], knots[1][4])
        x, y = self.place[vertex]

        def meets(b):
            wide = min(b[1], x1) - max(b[0], x0) > SAME
            return wide and min(b[3], y1) - max(b[2], y0) > SAME

        def holds(b):
            return b[0] - SAME <= x <= b[1] + SAME and b[2] - SAME <= y <= b[3] + SAME

        own = {m[4] for m in self.links.values() if m[3] == vertex and m[4] >= 0}
        reached = {f for f in own if holds(self.box[f]) and meets(self.box[f])}
        stack = list(reached)
        while stack:
            face = stack.pop()
            for m in self.links.values():
                other = self.links[m[2]][4]
                if m[4] != face or other < 0 or other in reached or not meets(self.box[other]):
                    continue
                direction, (ax, ay) = self.where[self.links[m[2]][2]]
                step = self.interval[m[5]]
                ends = (ax, ax + step * TURN[direction][0], ay, ay + step * TURN[direction][1])
                low = (min(ends[:2]), min(ends[2:]))
                high = (max(ends[:2]), max(ends[2:]))
                axis = direction % 2
                limit = ((x0, x1), (y0, y1))[axis]
                if min(high[axis], limit[1]) - max(low[axis], limit[0]) > SAME:
                    reached.add(other)
                    stack.append(other)
        return reached

    # ---- evaluation ------------------------------------------------------------------------------

    def values(self, face, u, v):
        """{grip: value} at (u, v) of a face, 0 < u, v < its size."""
        k, (x, y) = self.frame[face]
        c, s = TURN[k]
        x, y = x + c * u - s * v, y + s * u + c * v
        found = {}
        for grip, (tx, ty), faces in self.functions:
            if face in faces:
                value = bspline(tx, x) * bspline(ty, y)
                if value:
                    found[grip] = value
        return found

    def sum(self, face, u, v):
        return sum(self.values(face, u, v).values())

    def point(self, face, u, v):
        h = [0.0] * 4
        for grip, value in self.values(face, u, v).items():
            x, y, z, w = self.grips[grip]
            for d, c in enumerate((x * w, y * w, z * w, w)):
                h[d] += value * c
        return tuple(c / h[3] for c in h[:3])


# ---- test meshes ---------------------------------------------------------------------------------


class Mesh:
    """Boxes between the values of two axes, as a .tsm with Bezier ends.

    boxes: (i0, i1, j0, j1) in indices of the values, tiling the rectangle."""

    def __init__(self, values, boxes):
        self.values, self.boxes = values, boxes
        self.size = [len(v) - 1 for v in values]
        points = {p for b in boxes for p in self.corners(b)}
        self.vertices = sorted(points)
        self.number = {p: k for k, p in enumerate(self.vertices)}
        self.links, self.edges, self.first = [], [], []
        self._link()

    @staticmethod
    def corners(b):
        return ((b[0], b[2]), (b[1], b[2]), (b[1], b[3]), (b[0], b[3]))

    def _loop(self, b):
        """Vertices round a box with the flag of a T-junction."""
        loop = []
        for k in range(4):
            p, q = self.corners(b)[k], self.corners(b)[(k + 1) % 4]
            step = tuple((q[d] > p[d]) - (q[d] < p[d]) for d in (0, 1))
            at, flag = p, 0
            while at != q:
                if at in self.number:
                    loop.append((at, flag))
                    flag = 1
                at = (at[0] + step[0], at[1] + step[1])
        return loop

    def _link(self):
        index = {}
        for face, b in enumerate(self.boxes):
            loop, start = self._loop(b), len(self.links)
            self.first.append(start)
            n = len(loop)
            for k, (p, flag) in enumerate(loop):
                index[p, loop[(k + 1) % n][0]] = start + k
                self.links.append(
                    [start + (k - 1) % n, start + (k + 1) % n, -1, self.number[p], face, -1, flag]
                )
        outer = [(p, q) for p, q in index if (q, p) not in index]
        for p, q in outer:
            index[q, p] = len(self.links)
            self.links.append([-1, -1, -1, self.number[q], -1, -1, 0])
        leaving = {q: index[q, p] for p, q in outer}
        for p, q in outer:
            i = index[q, p]
            self.links[i][1] = leaving[p]
            self.links[leaving[p]][0] = i
        for (p, q), i in sorted(index.items(), key=lambda item: item[1]):
            self.links[i][2] = index[q, p]
            if self.links[i][5] < 0:
                edge = len(self.edges)
                axis = 0 if p[1] == q[1] else 1
                self.edges.append((i, abs(self.values[axis][q[axis]] - self.values[axis][p[axis]])))
                self.links[i][5] = self.links[index[q, p]][5] = edge
        self.index, self.leaving = index, collections.defaultdict(list)
        for p, q in index:
            self.leaving[p].append(q)

    def extra(self, p):
        """Further control points east, north, west, south."""
        return (
            int(p[0] == 0),
            int(p[1] == 0),
            int(p[0] == self.size[0]),
            int(p[1] == self.size[1]),
        )

    def text(self, place, ends=True, shuffle=None, creases=()):
        """place(p, i, j): the control point (x, y, z, w) i and j steps from vertex p.

        creases: edges as pairs of vertices."""
        compass = ("EAST", "NORTH", "WEST", "SOUTH")
        out = ["#TS0200", "", "degree 3", "cap-type 1", "star-smoothness 0", "units 1 meters"]
        out += ["f %d 0" % k for k in self.first]
        out += ["e %d %.17g" % e for e in self.edges]
        grips, blocks = [], []
        for p in self.vertices:
            leaving = self.leaving[p]
            q = leaving[shuffle(len(leaving)) if shuffle else 0]
            d = 0 if q[0] > p[0] else 2 if q[0] < p[0] else 1 if q[1] > p[1] else 3
            out.append("v %d %s" % (self.index[p, q], compass[d]))
            e = self.extra(p) if ends else (0, 0, 0, 0)
            block, wedge = [], (1, 2, 3, 0)
            grips.append(("gvp", self.number[p], place(p, 0, 0)))
            for k in range(4):
                (ax, ay), (bx, by) = TURN[wedge[k]], TURN[wedge[(k + 1) % 4]]
                for r in range(1, e[wedge[k]] + 1):
                    for c in range(e[wedge[(k + 1) % 4]] + 1):
                        i, j = r * ax + c * bx, r * ay + c * by
                        block.append(len(grips))
                        grips.append(("gv", self.number[p], place(p, i, j)))
            if block:
                counts = [e[w] for w in wedge]
                row = [self.number[p], 4] + counts + block
                blocks.append("0m cg " + " ".join(map(str, row)))
        out += ["l " + " ".join(map(str, m)) for m in self.links]
        out += ["ec %d 0" % self.links[self.index[c]][5] for c in creases]
        if ends:
            out.append("0m odd-grip-map")
            out += ["0m %s %d" % g[:2] for g in grips] + blocks
        out += ["0g " + " ".join("%.17g" % c for c in g[2]) for g in grips]
        return "\n".join(out + ["", "tol 1e-05", "ver 904", ""])


def quad_file(points, quads, interval, joints=()):
    """A closed surface of quads (vertices counterclockwise from outside).

    interval(p, q): that of the edge between two vertices; joints: (face, vertex) for vertices on
    the side of a face, which stand in its list, too."""
    links, index, edges, leaving, first = [], {}, [], {}, []
    for face, quad in enumerate(quads):
        start, n = len(links), len(quad)
        first.append(start)
        for k in range(n):
            index[quad[k], quad[(k + 1) % n]] = start + k
            leaving[quad[k]] = start + k
            near = [start + (k + step) % n for step in (-1, 1)]
            links.append(near + [-1, quad[k], face, -1, int((face, quad[k]) in joints)])
    for (p, q), i in index.items():
        links[i][2] = index[q, p]
        if p < q:
            links[i][5] = links[index[q, p]][5] = len(edges)
            edges.append((i, interval(p, q)))
    out = ["#TS0200", "degree 3", "cap-type G1CAPS", "units 1 meters"]
    out += ["f %d 0" % k for k in first]
    out += ["e %d %.17g" % e for e in edges]
    out += ["v %d NORTH" % leaving[k] for k in range(len(points))]
    out += ["l " + " ".join(map(str, m)) for m in links]
    out += ["0g %.17g %.17g %.17g 1" % tuple(p) for p in points]
    return "\n".join(out + [""])


def box_quads(n):
    """Vertices (i, j, k) on the surface of a box of n[0] x n[1] x n[2] cells, and its quads."""
    number, quads = {}, []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, n[axis]):
            for i in range(n[a]):
                for j in range(n[b]):
                    quad = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        p = [0, 0, 0]
                        p[axis], p[a], p[b] = end, i + di, j + dj
                        quad.append(number.setdefault(tuple(p), len(number)))
                    quads.append(quad if end else quad[::-1])
    return sorted(number, key=number.get), quads


def split_quad(points, quads, face):
    """The quad cut in two across its first side; the sides beside it get a T-junction each."""
    a, b, c, d = quads[face]
    e, f = len(points), len(points) + 1
    for p, q in ((a, b), (c, d)):
        points = points + [[(x + y) / 2 for x, y in zip(points[p], points[q])]]
    quads = [list(q) for q in quads] + [[e, b, c, f]]
    quads[face] = [a, e, f, d]
    joints = []
    for k, quad in enumerate(quads[:-1]):
        for p, q, new in ((b, a, e), (d, c, f)):
            for m in range(len(quad)):
                if k != face and quad[m] == p and quad[(m + 1) % len(quad)] == q:
                    quad.insert(m + 1, new)
                    joints.append((k, new))
                    break
    return points, quads, joints
