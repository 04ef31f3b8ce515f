# SPDX-License-Identifier: LGPL-2.1-or-later
"""Closed .tsm surfaces, evaluated on their own terms: neither the library nor the generators.

Bicubic. From half-edges alone: knots by walking from a vertex straight on, functions unfolded over
the faces they reach, points by the recursion of Cox and de Boor. At a star (three faces, no
T-joint) the surface has the mean of the three face points; that reaches its own three faces only.

    surface = TsmSurface(text)
    surface.sides                  six rectangles between the isolines: faces with their places
    surface.point(side, x, y)      x, y in the side's own values, from (0, 0) to its size
"""
from collections import deque

import numpy as np

TURN = ((1, 0), (0, 1), (-1, 0), (0, -1))


def rotated(k, x, y):
    c, s = TURN[k % 4]
    return c * x - s * y, s * x + c * y


class Placement:
    """A face's frame in a chart: turned by k quarters, then moved."""

    def __init__(self, k, x, y):
        self.k, self.x, self.y = k % 4, x, y

    def out(self, u, v):
        x, y = rotated(self.k, u, v)
        return x + self.x, y + self.y

    def back(self, x, y):
        return rotated(-self.k, x - self.x, y - self.y)


class Side:
    """A rectangle of faces between four isolines."""

    def __init__(self, faces, size):
        self.faces, self.size = faces, size


class TsmSurface:
    def __init__(self, text):
        self._read(text)
        self._measure_faces()
        self.stars = [v for v in range(len(self.leaving)) if self._is_star(v)]
        self._find_sides()
        self.users = [[] for _ in self.face_links]
        for vertex in range(len(self.leaving)):
            self._spread(vertex)
        self._star_points = {}

    # ---- topology --------------------------------------------------------------------------------

    def _read(self, text):
        rows = {}
        for line in text.splitlines():
            words = line.split()
            if words and not line.startswith("#"):
                rows.setdefault(words[0], []).append(words[1:])
        links = np.array([[int(x) for x in row] for row in rows["l"]])
        (self.previous, self.next, self.opposite, self.origin, self.face, self.edge,
         self.straight) = links.T.tolist()
        self.interval = [float(row[1]) for row in rows["e"]]
        self.face_links = [int(row[0]) for row in rows["f"]]
        self.leaving = [int(row[0]) for row in rows["v"]]
        homogeneous = np.array([[float(x) for x in row] for row in rows["0g"]])
        assert len(homogeneous) == len(self.leaving) and (homogeneous[:, 3] == 1).all()
        self.points = homogeneous

    def length(self, link):
        return self.interval[self.edge[link]]

    def _measure_faces(self):
        """Where each link starts in its face's frame, which way it runs, and how big faces are."""
        n = len(self.origin)
        self.start, self.way = [None] * n, [None] * n
        self.size, self.around = [], []
        for face, link in enumerate(self.face_links):
            while self.straight[link]:
                link = self.next[link]
            first, way, x, y, loop, size = link, 0, 0.0, 0.0, [], [0.0] * 4
            while not loop or link != first:
                if loop and not self.straight[link]:
                    way += 1
                self.start[link], self.way[link] = (x, y), way
                x, y = x + TURN[way][0] * self.length(link), y + TURN[way][1] * self.length(link)
                size[way] += self.length(link)
                loop.append(link)
                link = self.next[link]
                assert self.face[link] == face
            assert way == 3 and size[0] == size[2] and size[1] == size[3]
            self.around.append(loop)
            self.size.append((size[0], size[1]))

    def fan(self, vertex):
        """The links that leave a vertex, counter-clockwise, with quarters turned up to each."""
        link, quarter, out = self.leaving[vertex], 0, []
        while not out or link != out[0][0]:
            out.append((link, quarter))
            quarter += 2 if self.straight[link] else 1
            link = self.opposite[self.previous[link]]
        return out, quarter

    def _is_star(self, vertex):
        return self.fan(vertex)[1] == 3

    def _find_sides(self):
        """Isolines run from star to star; what they enclose are the sides."""
        self.is_isoline = [False] * len(self.interval)
        for star in self.stars:
            for link, _ in self.fan(star)[0]:
                while isinstance(link, int):
                    self.is_isoline[self.edge[link]] = True
                    link = self._along(link)[1]
        self.side_of = [-1] * len(self.face_links)
        self.sides = []
        for face in range(len(self.face_links)):
            if self.side_of[face] < 0:
                self._collect_side(face)

    def _collect_side(self, face):
        number, places, queue = len(self.sides), {face: Placement(0, 0.0, 0.0)}, deque([face])
        self.side_of[face] = number
        while queue:
            here = queue.popleft()
            for link in self.around[here]:
                beyond = self.face[self.opposite[link]]
                if not self.is_isoline[self.edge[link]] and self.side_of[beyond] < 0:
                    self.side_of[beyond] = number
                    places[beyond] = self._across(places[here], link)
                    queue.append(beyond)
        corners = np.array([p.out(*c) for f, p in places.items() for c in ((0, 0), self.size[f])])
        low, size = corners.min(axis=0), np.ptp(corners, axis=0)
        for p in places.values():
            p.x, p.y = p.x - low[0], p.y - low[1]
        area = sum(self.size[f][0] * self.size[f][1] for f in places)
        assert abs(size[0] * size[1] - area) < 1e-9 * area
        self.sides.append(Side(places, tuple(size)))

    def _across(self, place, link):
        """The frame of the face on the other side of a link of a placed face."""
        other = self.opposite[link]
        k = place.k + self.way[link] + 2 - self.way[other]
        end = [s + self.length(link) * t for s, t in zip(self.start[link], TURN[self.way[link]])]
        x, y = place.out(*end)
        back = rotated(k, *self.start[other])
        return Placement(k, x - back[0], y - back[1])

    # ---- knots -----------------------------------------------------------------------------------

    def _ray(self, vertex, quarter):
        """How far a ray from a vertex goes to the first and the second line that it meets.

        On the way along a link, or (link, at) inside a face: `at` behind the link's start."""
        fan, _ = self.fan(vertex)
        way = next((link for link, q in fan if q == quarter), None)
        if way is None:  # a T-joint: into the face beside which the line goes on
            way = next(link for link, q in fan if q == (quarter - 1) % 4), 0.0
        met, gone = [], 0.0
        while way is not None and len(met) < 2:
            far, way = self._inside(*way) if isinstance(way, tuple) else self._along(way)
            gone += far
            met.append(gone)
        return met if len(met) == 2 else [met[0], 2 * met[0]]

    def _along(self, link):
        """Length of a link, and how it goes on from its end; at a star it does not."""
        length, beside = self.length(link), self.next[link]
        if self.origin[beside] in self.stars:
            return length, None
        if self.straight[beside]:
            return length, beside
        beyond = self.next[self.opposite[beside]]
        return length, (beyond, 0.0) if self.straight[beyond] else beyond

    def _inside(self, link, at):
        """Through a face, away from a place on one of its links, and out of it."""
        face, way = self.face[link], self.way[link]

        def place(some):
            x, y = self.start[some]
            return (x, y, self.size[face][0] - x, self.size[face][1] - y)[way]

        here = place(link) + at
        across = [m for m in self.around[face] if self.way[m] == (way + 2) % 4]
        for m in across:
            if self.straight[m] and place(m) == here:
                return self.size[face][(way + 1) % 2], self.next[self.opposite[m]]
        m = next(m for m in across if place(m) - self.length(m) <= here <= place(m))
        behind = here - (place(m) - self.length(m))
        return self.size[face][(way + 1) % 2], (self.opposite[m], behind)

    def _spread(self, vertex):
        """Enters a vertex's function in the lists of all faces that it reaches."""
        fan, turns = self.fan(vertex)
        rays = [self._ray(vertex, q) for q in range(turns)]
        done = set()
        roots = [[(link, q)] for link, q in fan] if turns == 3 else [fan]
        own = {self.side_of[self.face[link]] for link, _ in fan}
        for root in roots:
            first = root[0][1]
            right, up, left, down = (rays[q] for q in (
                (first, (first + 1) % 3, (first + 2) % 3, (first + 2) % 3) if turns == 3
                else (0, 1, 2, 3)))
            knots = tuple((-low[1], -low[0], 0.0, high[0], high[1])
                          for low, high in ((left, right), (down, up)))
            for link, quarter in root:
                k = quarter - first - self.way[link]
                back = rotated(k, *self.start[link])
                place = Placement(k, -back[0], -back[1])
                if self.side_of[self.face[link]] not in done:
                    done.add(self.side_of[self.face[link]])
                    self._develop(vertex, self.face[link], place, knots, own)

    def _develop(self, vertex, face, place, knots, own):
        """All faces under the support, unfolded from one at the vertex: in its side, and over one
        isoline into sides that the vertex is not on."""
        home = self.side_of[face]
        seen, queue = {face}, deque([(face, place)])
        while queue:
            here, place = queue.popleft()
            self.users[here].append((vertex, place, knots))
            for link in self.around[here]:
                beyond = self.face[self.opposite[link]]
                if self.is_isoline[self.edge[link]]:
                    if self.side_of[here] != home or self.side_of[beyond] in own:
                        continue
                if beyond in seen:
                    continue
                seen.add(beyond)
                new = self._across(place, link)
                if self._overlaps(beyond, new, knots):
                    queue.append((beyond, new))

    def _overlaps(self, face, place, knots):
        ends = zip(place.out(0.0, 0.0), place.out(*self.size[face]))
        return all(max(pair) >= row[0] and min(pair) <= row[4] for pair, row in zip(ends, knots))

    # ---- points ----------------------------------------------------------------------------------

    def point(self, side, x, y):
        """(X, Y, Z, 1): the last is one where the functions' sum is."""
        for face, place in self.sides[side].faces.items():
            u, v = place.back(x, y)
            w, h = self.size[face]
            if w > 0 and h > 0 and 0 <= u <= w and 0 <= v <= h:
                return self.on_face(face, u, v)
        raise ValueError("no face there")

    def _weights(self, face, u, v):
        out = {}
        for vertex, place, knots in self.users[face]:
            x, y = place.out(u, v)
            value = cubic(knots[0], x) * cubic(knots[1], y)
            if value:
                out[vertex] = out.get(vertex, 0.0) + value
        return out

    def _sum(self, face, u, v):
        return sum(value * self.points[k] for k, value in self._weights(face, u, v).items())

    def on_face(self, face, u, v):
        result = self._sum(face, u, v)
        for link in self.around[face]:
            if self.origin[link] in self.stars:
                a, b = rotated(-self.way[link], u - self.start[link][0], v - self.start[link][1])
                w, h = self.size[face][::-1 if self.way[link] % 2 else 1]
                bump = ((1 - a / w) * (1 - b / h)) ** 3
                result = result + bump * (self._star_point(self.origin[link])
                                          - self._sum(face, *self.start[link]))
        return result

    def angle_across(self, link, step=1e-6):
        """Between the normals on the two sides of a link, in its middle."""
        normals = []
        for one in (link, self.opposite[link]):
            face, way, half = self.face[one], self.way[one], self.length(one) / 2

            def at(along, across):
                x, y = rotated(way, half + along, across)
                return self.on_face(face, self.start[one][0] + x, self.start[one][1] + y)[:3]

            normal = np.cross(at(step, 0.0) - at(-step, 0.0), at(0.0, step) - at(0.0, 0.0))
            normals.append(normal / np.linalg.norm(normal))
        return float(np.arctan2(np.linalg.norm(np.cross(*normals)), np.dot(*normals)))

    def _star_point(self, star):
        """The mean of the three face points; multiple knots round the star: its control point."""
        if star not in self._star_points:
            points = [self._face_point(link) for link, _ in self.fan(star)[0]]
            self._star_points[star] = sum(points) / 3
        return self._star_points[star]

    def _face_point(self, link):
        """Of the face of a link that leaves a star: the Bezier point inside, next to the star."""
        loop = [link]
        while len(loop) < 4:
            loop.append(self.next[loop[-1]])
        wide, high = self.length(loop[0]), self.length(loop[1])
        below, right, above, left = (self._depth(self.opposite[m]) for m in loop)
        u = np.array([wide + right, left]) / (left + wide + right)
        v = np.array([high + above, below]) / (below + high + above)
        p = [self.points[self.origin[m]] for m in loop]
        return u[0] * v[0] * p[0] + u[1] * v[0] * p[1] + u[1] * v[1] * p[2] + u[0] * v[1] * p[3]

    def _depth(self, link):
        """How far the link's face reaches away from it."""
        return self.size[self.face[link]][(self.way[link] + 1) % 2]


def cubic(knots, x):
    """The B-spline of five knots; at its last knot the limit from the left."""
    value = [1.0 if a <= x < b or (x == b == knots[4] and a < b) else 0.0
             for a, b in zip(knots, knots[1:])]
    for d in (1, 2, 3):
        for i in range(4 - d):
            left, right = knots[i + d] - knots[i], knots[i + d + 1] - knots[i + 1]
            value[i] = (((x - knots[i]) / left * value[i] if left > 0 else 0.0)
                        + ((knots[i + d + 1] - x) / right * value[i + 1] if right > 0 else 0.0))
    return value[0]
