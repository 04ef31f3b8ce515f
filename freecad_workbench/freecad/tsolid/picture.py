# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pictures of a solid, without a display: from outside, and cut open.

Element faces are evaluated from their rational Bezier nets, cut into triangles and drawn into a
depth buffer, so what is hidden is hidden to the pixel. Element borders are drawn where a face's
own parameters are 0 or 1. Colour is the scaled Jacobian at the point seen. Needs numpy and, for
the legend and the file, matplotlib (Agg).
"""

import itertools
import math

import numpy as np

from . import binding

BACKGROUND = np.array([1.0, 1.0, 1.0])
LINE_COLOUR = np.array([0.10, 0.12, 0.16])
OVERSAMPLING = 2
CHUNK = 20000  # triangles drawn at once


# ---- what is seen --------------------------------------------------------------------------------


class Elements:
    """Boxes, degrees and homogeneous Bezier nets of a solid's elements."""

    def __init__(self, block, degree, box, net):
        self.block = np.asarray(block, int)
        self.degree = np.asarray(degree, int).reshape(-1, 3)
        self.box = np.asarray(box, float).reshape(-1, 2, 3)
        self.net = net  # per element an array [k2, k1, k0, (wx, wy, wz, w)]

    @classmethod
    def of(cls, context, solid):
        space = solid.space
        degree = np.array(space.element_degrees).reshape(-1, 3)
        box = np.array(space.element_boxes).reshape(-1, 2, 3)
        net = []
        for element, (d0, d1, d2) in enumerate(degree):
            flat = np.array(solid.bezier(context, element))
            net.append(flat.reshape(d2 + 1, d1 + 1, d0 + 1, 4))
        return cls(space.element_blocks, degree, box, net)

    def __len__(self):
        return len(self.net)

    def radius(self):
        """The arms' heights R, by block (the core's is 0)."""
        height = np.zeros(7)
        for side in range(6):
            boxes = self.box[self.block == side + 1]
            axis = side // 2
            if len(boxes):
                reach = boxes[:, 1, axis].max() - 1 if side % 2 else -boxes[:, 0, axis].min()
                height[side + 1] = reach
        return height


def face_key(elements, height, element, axis, end):
    """The same for the two faces that meet: also across a diagonal, where two arms' coordinates
    differ (see tsolid.h). Numbers are rounded only to compare them."""
    box = elements.box[element]
    block = elements.block[element]
    place = box[end, axis]
    span = [(box[0, a], box[1, a]) for a in range(3)]
    span[axis] = (place, place)
    if block > 0:
        arm_axis, arm_end = divmod(block - 1, 2)
        if axis != arm_axis and place in (0.0, 1.0):
            lo, hi = span[arm_axis]
            rho = (lo - 1, hi - 1) if arm_end else (-hi, -lo)
            rho = tuple(r / height[block] for r in rho)
            ends = {arm_axis: arm_end, axis: int(place)}
            other = 3 - arm_axis - axis
            return ("diagonal", tuple(sorted(ends.items())), _rounded(rho), _rounded(span[other]))
    return (axis,) + tuple(_rounded(s) for s in span)


def _rounded(pair):
    return tuple(round(float(x) * 1e9) for x in pair)


def visible_faces(elements, kept):
    """Faces (element, axis, end) of the kept elements that no other kept element shares."""
    height = elements.radius()
    faces = {}
    for element in np.flatnonzero(kept):
        for axis, end in itertools.product(range(3), range(2)):
            key = face_key(elements, height, element, axis, end)
            faces.setdefault(key, []).append((element, axis, end))
    return [users[0] for users in faces.values() if len(users) == 1]


def octant(elements, corner):
    """Elements beyond the middle on the three axes, towards a corner of the cube (as bits)."""
    chosen = np.ones(len(elements), bool)
    core = elements.box[elements.block == 0]
    for axis in range(3):
        planes = np.unique(core[:, :, axis])
        inner = planes[(planes > 0) & (planes < 1)]
        high = corner >> axis & 1
        # The plane nearest the middle; of two the one that opens more.
        if len(inner):
            best = min(inner, key=lambda x: (round(abs(x - 0.5), 9), x if high else -x))
        else:
            best = 0.5
        if high:
            chosen &= elements.box[:, 0, axis] >= best - 1e-12
        else:
            chosen &= elements.box[:, 1, axis] <= best + 1e-12
    return chosen


# ---- evaluation ----------------------------------------------------------------------------------


def bernstein(degree, x):
    """Values and first derivatives, each [len(x), degree + 1]."""
    x = np.asarray(x, float)[:, None]

    def values(p):
        k = np.arange(p + 1)
        binomial = np.array([math.comb(p, int(i)) for i in k], float)
        return binomial * x**k * (1 - x) ** (p - k)

    value = values(degree)
    derivative = np.zeros_like(value)
    if degree > 0:
        lower = degree * values(degree - 1)
        derivative[:, 1:] += lower
        derivative[:, :-1] -= lower
    return value, derivative


class Mesh:
    """Triangles with, per vertex: place, normal, scaled Jacobian, parameters in its face."""

    def __init__(self, n):
        self.n = n  # intervals per face and direction
        self.point, self.normal, self.jacobian = [], [], []
        self.on_cut = []  # per face

    def add(self, point, normal, jacobian, on_cut):
        self.point.append(point.reshape(-1, 3))
        self.normal.append(normal.reshape(-1, 3))
        self.jacobian.append(jacobian.reshape(-1))
        self.on_cut.append(on_cut)

    def close(self):
        n = self.n
        for name in ("point", "normal", "jacobian", "on_cut"):
            setattr(self, name, np.concatenate(getattr(self, name)))
        n_faces = len(self.on_cut)
        j, i = np.divmod(np.arange((n + 1) ** 2), n + 1)
        self.parameter = np.tile(np.stack([i, j], 1) / n, (n_faces, 1))
        j, i = np.divmod(np.arange(n * n), n)
        a = j * (n + 1) + i
        quad = np.stack([a, a + 1, a + n + 2, a, a + n + 2, a + n + 1], 1).reshape(-1, 3)
        shift = np.arange(n_faces)[:, None, None] * (n + 1) ** 2
        self.triangle = (quad[None] + shift).reshape(-1, 3)
        self.on_cut = np.repeat(self.on_cut, len(quad))
        return self


def unit_vectors(vectors):
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


def face_values(nets, axis, end, n):
    """Points, normals and scaled Jacobians of one face of elements of the same degrees, on a grid
    [element, second parameter, first parameter]."""
    grid = np.linspace(0, 1, n + 1)
    basis = []
    for a in range(3):
        degree = nets.shape[3 - a] - 1
        basis.append(bernstein(degree, [float(end)] if a == axis else grid))

    def combine(derived):
        b0, b1, b2 = (basis[a][1 if a == derived else 0] for a in range(3))
        result = np.einsum("ekjic,zk->ezjic", nets, b2)
        result = np.einsum("ezjic,yj->ezyic", result, b1)
        return np.squeeze(np.einsum("ezyic,xi->ezyxc", result, b0), axis=3 - axis)

    value = combine(None)
    weight = value[..., 3:]
    point = value[..., :3] / weight
    tangent = []
    for a in range(3):
        derivative = combine(a)
        tangent.append((derivative[..., :3] - point * derivative[..., 3:]) / weight)
    normal = np.cross(tangent[(axis + 1) % 3], tangent[(axis + 2) % 3])
    unit = [unit_vectors(t) for t in tangent]
    jacobian = np.einsum("...i,...i->...", unit[0], np.cross(unit[1], unit[2]))
    return point, unit_vectors(normal) * (1 if end else -1), jacobian


def tessellate(elements, kept, n=None):
    """The visible faces of the kept elements as a Mesh."""
    faces = visible_faces(elements, kept)
    height = elements.radius()
    if n is None:
        n = int(min(24, max(4, math.sqrt(40000 / max(1, len(faces))))))
    groups = {}
    for element, axis, end in faces:
        key = (tuple(elements.degree[element]), axis, end)
        groups.setdefault(key, []).append(element)
    mesh = Mesh(n)
    for (_, axis, end), members in sorted(groups.items()):
        outside = []
        for element in members:
            block = elements.block[element]
            reach = 1 + height[block] if end else -height[block]
            is_arm = block == 1 + 2 * axis + end
            outside.append(is_arm and abs(elements.box[element, end, axis] - reach) < 1e-9)
        nets = np.stack([elements.net[element] for element in members])
        mesh.add(*face_values(nets, axis, end, n), ~np.array(outside))
    return mesh.close()


# ---- camera and depth buffer ---------------------------------------------------------------------


class Camera:
    """A parallel view along `towards` (from the part to the eye), z up."""

    def __init__(self, towards):
        self.eye = unit_vectors(np.array(towards, float))
        self.right = unit_vectors(np.cross([0.0, 0.0, 1.0], self.eye))
        self.up = np.cross(self.eye, self.right)
        self.frame = np.stack([self.right, self.up, self.eye], 1)
        self.scale, self.shift = 1.0, np.zeros(2)

    def fit(self, points, width, height, margin=0.04):
        flat = points @ self.frame[:, :2]
        low, high = flat.min(0), flat.max(0)
        room = np.array([width, height]) * (1 - 2 * margin)
        self.scale = float(np.min(room / np.maximum(high - low, 1e-300)))
        self.shift = np.array([width, height]) / 2 - self.scale * (low + high) / 2
        return self

    def project(self, points):
        """Pixels x (right), y (up), depth (towards the eye)."""
        seen = points @ self.frame
        seen *= self.scale
        seen[:, :2] += self.shift
        return seen


class Raster:
    """Per pixel the nearest triangle (-1: none) and the barycentric coordinates there."""

    def __init__(self, width, height):
        self.width, self.height = width, height
        self.depth = np.full(width * height, -np.inf)
        self.triangle = np.full(width * height, -1)
        self.weight = np.zeros((width * height, 3))

    def draw(self, seen, triangle, which):
        """Draws the triangles with the numbers `which`."""
        for start in range(0, len(which), CHUNK):
            some = which[start:start + CHUNK]
            self._draw_some(some, seen[triangle[some]])

    def _draw_some(self, number, corner):
        row, y = _expand(*self._rows(corner))
        first, last = _spans(corner[row], y + 0.5)
        first, last = np.maximum(first, 0), np.minimum(last, self.width - 1)
        pair, x = _expand(first, last)
        row, y = row[pair], y[pair]
        weight = _barycentric(corner[row], x + 0.5, y + 0.5)
        depth = np.einsum("ni,ni->n", weight, corner[row, :, 2])
        pixel = y * self.width + x
        nearer = np.flatnonzero(depth > self.depth[pixel])
        order = nearer[np.argsort(depth[nearer], kind="stable")]
        # Of repeated pixels the last, that is the nearest, stays.
        self.depth[pixel[order]] = depth[order]
        self.triangle[pixel[order]] = number[row[order]]
        self.weight[pixel[order]] = weight[order]

    def _rows(self, corner):
        """First and last row of pixels whose middle a triangle reaches."""
        low = np.ceil(corner[:, :, 1].min(1) - 0.5).astype(int)
        high = np.floor(corner[:, :, 1].max(1) - 0.5).astype(int)
        return np.maximum(low, 0), np.minimum(high, self.height - 1)


def _expand(first, last):
    """All (k, i) with first[k] <= i <= last[k], as two arrays."""
    count = np.maximum(last - first + 1, 0)
    k = np.repeat(np.arange(len(count)), count)
    start = np.cumsum(count) - count
    return k, np.arange(len(k)) - start[k] + first[k]


def _spans(corner, y):
    """First and last pixel of the triangles [n, corner, xyz] on the lines y[n]. Pixels belong to
    the triangle whose half-open span holds their middle: neighbours leave no gap."""
    low, high = np.full(len(y), np.inf), np.full(len(y), -np.inf)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        p, q = corner[:, a], corner[:, b]
        swap = (p[:, 1] > q[:, 1])[:, None]
        p, q = np.where(swap, q, p), np.where(swap, p, q)
        crosses = (p[:, 1] <= y) & (q[:, 1] > y)
        rise = np.where(crosses, q[:, 1] - p[:, 1], 1)
        x = p[:, 0] + (y - p[:, 1]) / rise * (q[:, 0] - p[:, 0])
        low = np.where(crosses, np.minimum(low, x), low)
        high = np.where(crosses, np.maximum(high, x), high)
    empty = low > high
    low[empty], high[empty] = 0, 0
    return np.ceil(low - 0.5).astype(int), np.ceil(high - 0.5).astype(int) - 1


def _barycentric(corner, x, y):
    a = corner[:, 0, :2]
    b, c = corner[:, 1, :2] - a, corner[:, 2, :2] - a
    x, y = x - a[:, 0], y - a[:, 1]
    area = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    area = np.where(area == 0, 1e-300, area)
    wb = np.clip((x * c[:, 1] - y * c[:, 0]) / area, 0, 1)
    wc = np.clip((y * b[:, 0] - x * b[:, 1]) / area, 0, 1 - wb)
    return np.stack([1 - wb - wc, wb, wc], 1)


def _facing(mesh, camera):
    """Triangles not turned away; all of them where an element is inverted."""
    if mesh.jacobian.min() <= 0:
        return np.arange(len(mesh.triangle))
    return np.flatnonzero((mesh.normal @ camera.eye)[mesh.triangle].max(1) > -1e-6)


def _line_strength(seen, mesh, index, weight, width):
    """How much of each pixel a border of its element covers, 0..1. Parameters are linear on a
    triangle: distance in pixels = parameter / |its gradient on the screen|."""
    corner = seen[mesh.triangle[index]][:, :, :2]
    parameter = mesh.parameter[mesh.triangle[index]]
    e1, e2 = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
    area = np.where(area == 0, 1e-300, area)
    strength = np.zeros(len(index))
    for k in range(2):
        p1 = parameter[:, 1, k] - parameter[:, 0, k]
        p2 = parameter[:, 2, k] - parameter[:, 0, k]
        gx = (p1 * e2[:, 1] - p2 * e1[:, 1]) / area
        gy = (p2 * e1[:, 0] - p1 * e2[:, 0]) / area
        slope = np.hypot(gx, gy)
        value = np.einsum("ni,ni->n", weight, parameter[:, :, k])
        distance = np.minimum(value, 1 - value) / np.maximum(slope, 1e-300)
        # Where elements are only a few pixels wide, thinner lines keep the colour readable.
        wide = np.clip(1 / np.maximum(slope, 1e-300) / (8 * width), 0, 1)
        strength = np.maximum(strength, np.clip(width / 2 + 0.5 - distance, 0, 1) * wide)
    return strength


def render(mesh, camera, width, height, colour_of, line_width=1.1):
    """An image [height, width, rgb], top row first, and the share of pixels that show the cut."""
    factor = OVERSAMPLING
    camera.fit(mesh.point, width * factor, height * factor)
    seen = camera.project(mesh.point)
    raster = Raster(width * factor, height * factor)
    raster.draw(seen, mesh.triangle, _facing(mesh, camera))
    pixel = np.flatnonzero(raster.triangle >= 0)
    index, weight = raster.triangle[pixel], raster.weight[pixel]

    def interpolate(values):
        return np.einsum("ni,ni...->n...", weight, values[mesh.triangle[index]])

    normal = unit_vectors(interpolate(mesh.normal)) @ camera.frame
    normal *= np.where(normal[:, 2:] < 0, -1, 1)
    key_light = unit_vectors(np.array([-0.35, 0.65, 0.70]))
    light = 0.60 + 0.18 * normal[:, 2] + 0.24 * np.clip(normal @ key_light, 0, 1)
    colour = colour_of(interpolate(mesh.jacobian)) * light[:, None]
    line = _line_strength(seen, mesh, index, weight, line_width * factor)[:, None] * 0.85
    image = np.tile(BACKGROUND, (raster.width * raster.height, 1))
    image[pixel] = colour * (1 - line) + LINE_COLOUR * line
    image = image.reshape(height, factor, width, factor, 3).mean((1, 3))
    return np.clip(image[::-1], 0, 1), float(mesh.on_cut[index].sum()) / raster.triangle.size


# ---- choice of view ------------------------------------------------------------------------------


def _share(mesh, towards, only_cut):
    """The share of a small picture that the part, or its cut, fills."""
    camera = Camera(towards).fit(mesh.point, 160, 120)
    raster = Raster(160, 120)
    raster.draw(camera.project(mesh.point), mesh.triangle, _facing(mesh, camera))
    index = raster.triangle[raster.triangle >= 0]
    return (mesh.on_cut[index].sum() if only_cut else len(index)) / raster.triangle.size


_AROUND = ((1.0, -1.35), (1.35, 1.0), (-1.0, 1.35), (-1.35, -1.0))
VIEWS = [(x, y, z) for z in (0.8, 1.6) for x, y in _AROUND]


def choose_view(elements):
    """(direction to the eye, corner whose octant is taken out): what shows most of the cut."""
    best = (-1.0, VIEWS[0], 7)
    for corner in range(8):
        removed = octant(elements, corner)
        if removed.all() or not removed.any():
            continue
        mesh = tessellate(elements, ~removed, n=3)
        for view in VIEWS:
            share = _share(mesh, view, True)
            if share > best[0] * 1.02:
                best = (share, view, corner)
    return best[1], best[2]


# ---- files ---------------------------------------------------------------------------------------


def _colours():
    import matplotlib

    colours = matplotlib.colormaps["viridis"].with_extremes(under="#d62728")
    return colours, lambda values: colours(np.where(values > 0, values, -1.0))[..., :3]


def _draw_axes(figure, camera):
    """The world's axes in the lower left corner."""
    axes = figure.add_axes([0.01, 0.01, 0.12, 0.16])
    axes.set_xlim(-1.25, 1.25)
    axes.set_ylim(-1.25, 1.25)
    axes.set_aspect("equal")
    axes.axis("off")
    for axis, colour in enumerate(("#b22222", "#228b22", "#1f4fb2")):
        tip = camera.frame[axis, :2] * 0.9
        arrow = dict(arrowstyle="-|>", color=colour, lw=1.4, shrinkA=0, shrinkB=0)
        axes.annotate("", xy=tip, xytext=(0, 0), arrowprops=arrow)
        length = np.linalg.norm(tip)
        place = tip * (1 + 0.28 / length) if length > 0.15 else tip + 0.25
        axes.text(*place, "xyz"[axis], color=colour, ha="center", va="center", fontsize=9)


def draw(path, elements, view, corner=None, size=(1200, 840)):
    """Writes a PNG (a path or a binary file); corner: the octant to take out, None: none."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    kept = np.ones(len(elements), bool) if corner is None else ~octant(elements, corner)
    colours, colour_of = _colours()
    camera = Camera(view)
    picture_width = int(size[0] * 0.88)
    image, _ = render(tessellate(elements, kept), camera, picture_width, size[1], colour_of)
    figure = Figure(figsize=(size[0] / 150, size[1] / 150), dpi=150, facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.add_axes([0, 0, picture_width / size[0], 1])
    axes.imshow(image, interpolation="none", aspect="auto")
    axes.axis("off")
    _draw_axes(figure, camera)
    scale = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(0, 1), colours)
    legend = figure.colorbar(scale, cax=figure.add_axes([0.895, 0.14, 0.022, 0.72]), extend="min")
    legend.set_label("scaled Jacobian (red: not positive)", fontsize=8)
    legend.ax.tick_params(labelsize=8)
    figure.savefig(path, format="png", metadata={"Software": None})


def picture(path, solid, cut=True, context=None, size=(1200, 840)):
    """A PNG of the solid, cut open or from outside."""
    elements = Elements.of(context or binding.Context(), solid)
    view, corner = choose_view(elements)
    draw(path, elements, view, corner if cut else None, size)
