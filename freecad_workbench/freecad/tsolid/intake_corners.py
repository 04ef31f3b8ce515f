# SPDX-License-Identifier: LGPL-2.1-or-later
"""Which vertices become the eight corners of the cube.

Every cell has at each of its vertices a type: 1, a corner of its rectangle, or 2, straight through.
Rigid cells have theirs; a free face takes four of its vertices as corners. The surface is a cube's,
cut into rectangles, when

    at each vertex the types sum to 4 (a regular point: two lines cross, or one ends on another, or
    one passes), but at exactly eight, the cube's corners, where three corners meet;
    the three lines that leave each of the eight run straight on to another of the eight.

A vertex of three cells has at most one 2 (with it the sum is 4, without it a corner), of two cells
only 2, of four only 1; this forces most types. What is left is searched in full, within a bound.
Choices are ranked by the squares of the differences of interior angles from 90 and 180 degrees,
then by how unequal opposite borders are, then by the corners' coordinates: the same for the same
part whatever the order of its faces.
"""

import collections
import itertools
import math

from .intake_cells import uses
from .intake_cuts import corners_of

MAX_STEPS = 200000  # of the search
MAX_KEPT = 512  # choices that are looked at more closely
SMALL = math.radians(1.0)  # no corner of a rectangle is sharper than this
RIGHT, STRAIGHT = math.pi / 2, math.pi
UNWANTED = 100.0  # more than all angles of a face together

Choice = collections.namedtuple("Choice", "cost corners positions")
Choice.__doc__ = """cost: (angles, balance, coordinates); corners: the eight nodes; positions: free
cell -> where in its loop its four corners are."""


class NoCube(Exception):
    """args: (where, text): why no choice of corners makes a cube."""


class _Free:
    """A free cell: its vertices' angles, the candidates for its corners, cheapest first."""

    def __init__(self, index, cell):
        self.index, self.cell = index, cell
        self.corners = corners_of(cell.face)
        self.lengths = _lengths(cell)
        self.options = []

    def prepare(self, kinds, given):
        """All choices of four vertices that the vertices allow: (cost, positions)."""
        n = len(self.corners)
        forced = [i for i in range(n) if self._must(i, kinds) == 1]
        free = [i for i in range(n) if self._must(i, kinds) == 0 and self._may(i)]
        forced += [i for i in free if self.corners[i].node in given]
        free = [i for i in free if i not in forced]
        if len(forced) > 4:
            raise NoCube(self.cell.face.name, self._too_many(forced))
        for more in itertools.combinations(free, 4 - len(forced)):
            positions = tuple(sorted(forced + list(more)))
            self.options.append((self._cost(positions), positions))
        if not self.options:
            raise NoCube(self.cell.face.name, self._too_few(forced, free))
        self.options.sort()

    def _must(self, i, kinds):
        """1 or 2 where the other cells leave no choice, else 0."""
        here = kinds[self.corners[i].node.number]
        others = list(here)
        others.remove((self.index, 0))
        if len(here) == 2:
            return 2
        if len(here) == 4 or any(kind == 2 for _, kind in others):
            return 1
        return 0

    def _may(self, i):
        return SMALL < self.corners[i].angle < STRAIGHT + SMALL

    def _too_many(self, forced):
        names = ", ".join(repr(self.corners[i].node) for i in forced)
        return ("%d vertices of the face (%s) would have to be corners; a side of the cube has "
                "four" % (len(forced), names))

    def _too_few(self, forced, free):
        edges = len({e.number for e, _ in self.cell.face.loop})
        n = len(forced) + len(free)
        words = ("no", "one", "two", "three", "four", "five", "six")
        edge = words[edges] if edges < len(words) else str(edges)
        text = "the face is bounded by %s edge%s" % (edge, "" if edges == 1 else "s")
        if n != edges:
            corner = words[n] if n < len(words) else str(n)
            text += ", and %s of its vertices can be a corner" % corner
        return text + "; a side of the cube needs four"

    def _cost(self, positions):
        angles = sum(
            (c.angle - (RIGHT if i in positions else STRAIGHT)) ** 2
            for i, c in enumerate(self.corners)
        )
        angles += UNWANTED * sum(self.corners[i].nearly_smooth for i in positions)
        sides = self.side_lengths(positions)
        balance = sum(abs(math.log(sides[k] / sides[k + 2])) for k in (0, 1))
        return (round(angles, 9), round(balance, 9))

    def side_lengths(self, positions):
        n = len(self.lengths)
        out = []
        for a, b in zip(positions, positions[1:] + positions[:1]):
            out.append(sum(self.lengths[i % n] for i in range(a, b if b > a else b + n)))
        return out


def _lengths(cell):
    """Length of every arc of a free cell."""
    out = []
    for arc in cell.loop:
        edge, i = _edge_of(cell, arc.key)
        a, b = edge.nodes[i][0], edge.nodes[i + 1][0]
        points = [edge.point(a + (b - a) * k / 16.0) for k in range(17)]
        out.append(sum((q - p).Length for p, q in zip(points, points[1:])))
    return out


def _edge_of(cell, key):
    return next(e for e, _ in cell.face.loop if e.number == key[0]), key[1]


# ---- the search ----------------------------------------------------------------------------------


def choices(cells, given=()):
    """All choices that make a cube, best first, and whether the search was complete.

    given: nodes that have to be among the corners. Raises NoCube.
    """
    kinds = uses(cells)
    _check_vertices(cells, kinds)
    free = [_Free(i, c) for i, c in enumerate(cells) if c.sides is None]
    if not free:
        return [], True
    for item in free:
        item.prepare(kinds, set(given))
    free.sort(key=lambda f: (len(f.options), f.cell.face.number))
    search = _Search(cells, kinds, free)
    search.run()
    found = [c for c in search.found if all(n in c.corners for n in given)]
    if not found:
        raise NoCube("", _why_none(cells, kinds, given, bool(search.found)))
    found.sort(key=lambda c: c.cost)
    return found, search.complete


def _why_none(cells, kinds, given, others):
    if given and others:
        return "no cube has these corners: %s" % ", ".join(map(repr, given))
    return (
        "no choice of eight vertices as corners makes the faces the six sides of a cube: the lines "
        "between them do not meet"
    )


def _check_vertices(cells, kinds):
    for number in sorted(kinds):
        here = kinds[number]
        if len(here) <= 4:
            continue
        node = next(n for c, _ in here for n in cells[c].nodes() if n.number == number)
        raise NoCube(repr(node), "%d faces meet in this vertex; at most four can" % len(here))


class _Search:
    """Depth first over the free cells, each with its cheapest candidates first."""

    def __init__(self, cells, kinds, free):
        self.cells, self.kinds, self.free = cells, kinds, free
        self.steps, self.complete, self.found = 0, True, []
        self.straight = {  # nodes of three cells that already have their 2
            n for n, here in kinds.items() if len(here) == 3 and any(k == 2 for _, k in here)
        }
        self.chosen = []

    def run(self, depth=0):
        if depth == len(self.free):
            self._take()
            return
        item = self.free[depth]
        for cost, positions in item.options:
            self.steps += 1
            if self.steps > MAX_STEPS or len(self.found) >= MAX_KEPT:
                self.complete = False
                return
            through = {
                c.node.number
                for i, c in enumerate(item.corners)
                if i not in positions and len(self.kinds[c.node.number]) == 3
            }
            if through & self.straight:
                continue
            self.straight |= through
            self.chosen.append((item, cost, positions))
            self.run(depth + 1)
            self.chosen.pop()
            self.straight -= through

    def _take(self):
        corners = []
        for cell in self.cells:
            for node in cell.nodes():
                if len(self.kinds[node.number]) == 3 and node.number not in self.straight:
                    if node not in corners:
                        corners.append(node)
        positions = {item.index: places for item, _, places in self.chosen}
        if len(corners) != 8 or not lines_meet(self.cells, positions, corners):
            return
        places = tuple(sorted(tuple(round(x, 9) for x in n.point) for n in corners))
        angles = sum(cost[0] for _, cost, _ in self.chosen)
        balance = sum(cost[1] for _, cost, _ in self.chosen)
        cost = (round(angles, 6), round(balance, 6), places)
        corners.sort(key=lambda n: n.number)
        self.found.append(Choice(cost, corners, positions))


# ---- the twelve lines ------------------------------------------------------------------------


def _sectors(cells, positions):
    """Per node: what lies between two arcs there: (key, key, type, free)."""
    out = collections.defaultdict(list)
    for c, cell in enumerate(cells):
        loop = cell.loop
        ends = set(positions.get(c, ()))
        if cell.sides is not None:
            at, ends = 0, set()
            for side in cell.sides:
                ends.add(at)
                at += len(side)
        for i, arc in enumerate(loop):
            kind = 1 if i in ends else 2
            out[arc.a.number].append((loop[i - 1].key, arc.key, kind, cell.sides is None))
    return out


def _straight_on(sectors, key):
    """The arc that continues one straight: two quarter turns on. None where the line meets a
    border from the side; the second answer tells whether that is a free face's."""
    for first, second, kind, free in sectors:
        if key not in (first, second):
            continue
        beside = second if first == key else first
        if kind == 2:
            return beside, free
        for other in sectors:
            if other[:2] == (first, second) or beside not in other[:2]:
                continue
            beyond = other[1] if other[0] == beside else other[0]
            if other[2] == 1:
                return beyond, other[3]
            across = other[3]
            return None, across
    return None, True


def lines_meet(cells, positions, corners):
    """Do the lines from the corners run straight to other corners?

    A line that meets a rigid face from the side goes on across it; where it arrives is left to the
    library. On a free face it would arrive anywhere: such a choice is none.
    """
    ends = {}
    for cell in cells:
        for arc in cell.loop:
            ends[arc.key] = (arc.a, arc.b)
    sectors = _sectors(cells, positions)
    numbers = {n.number for n in corners}
    for corner in corners:
        for first, second, _, _ in sectors[corner.number]:
            for key in (first, second):
                if not _reaches(key, corner, ends, sectors, numbers):
                    return False
    return True


def _reaches(key, start, ends, sectors, numbers):
    node = start
    for _ in range(len(ends)):
        a, b = ends[key]
        node = b if a is node else a
        if node.number in numbers:
            return True
        key, free = _straight_on(sectors[node.number], key)
        if key is None:
            return not free
    return False
