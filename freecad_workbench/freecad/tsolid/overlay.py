# SPDX-License-Identifier: LGPL-2.1-or-later
"""What a check found, drawn over the part in the 3D view: six sides in six colours, twelve
isolines, eight corners, and a mark at every violation. Nothing of it is in the document.
"""

import numpy as np
import Part
from pivy import coin

from . import picture, scene

SIDE_COLOURS = ((0.85, 0.33, 0.25), (0.95, 0.65, 0.30), (0.30, 0.62, 0.35), (0.62, 0.80, 0.38),
                (0.25, 0.42, 0.78), (0.45, 0.72, 0.92))
STEPS = 12
CORNER = (0.05, 0.05, 0.08)
BAD = (0.93, 0.10, 0.10)


def _patch_grids(boundary, side):
    """Points of each Bezier element of a side on a grid, [element, t, s, 3], and its boxes."""
    control = np.array(boundary.points).reshape(-1, 4)
    p, q = boundary.side_degree(side)
    grid = np.linspace(0, 1, STEPS + 1)
    bs, bt = picture.bernstein(p, grid)[0], picture.bernstein(q, grid)[0]
    out, boxes = [], []
    for element in boundary.elements(side):
        rows = np.array([np.asarray(r) for r in element.coefficients])
        net = np.einsum("fk,fc->kc", rows, control[np.asarray(element.functions)])
        net = net.reshape(q + 1, p + 1, 4)
        value = np.einsum("jic,yj,xi->yxc", net, bt, bs)
        out.append(value[..., :3] / value[..., 3:])
        boxes.append(element.box)
    return np.array(out), np.array(boxes)


def _points(points, colour, size):
    coordinates = coin.SoCoordinate3()
    scene.fill(coordinates.point, np.array(points, np.float32).reshape(-1, 3))
    style = coin.SoDrawStyle()
    style.pointSize = size
    drawn = coin.SoPointSet()
    drawn.numPoints = len(points)
    part = _plain(colour)
    if colour == BAD:  # a violation inside or behind is to be seen as well
        buffer = coin.SoDepthBuffer()
        buffer.test = False
        part.addChild(buffer)
    for node in (style, coordinates, drawn):
        part.addChild(node)
    return part


def _plain(colour):
    light = coin.SoLightModel()
    light.model = coin.SoLightModel.BASE_COLOR
    base = coin.SoBaseColor()
    base.rgb = colour
    part = coin.SoSeparator()
    part.addChild(light)
    part.addChild(base)
    return part


def _offset(factor):
    node = coin.SoPolygonOffset()
    node.factor, node.units = factor, 2.0 * factor
    return node


class Drawn:
    """Something drawn into one view that cannot be picked; remove() takes all of it away."""

    def __init__(self, view, name):
        self.graph = view.getSceneGraph()
        self.root = coin.SoSeparator()
        self.root.setName(name)
        pick = coin.SoPickStyle()
        pick.style = coin.SoPickStyle.UNPICKABLE
        self.root.addChild(pick)
        self.graph.addChild(self.root)

    def remove(self):
        if self.root is not None:
            self.graph.removeChild(self.root)
            self.root = None


class Overlay(Drawn):
    """The cube that a check has found in a part, or why there is none."""

    def __init__(self, view, obj, result):
        super().__init__(view, "TsolidCheck")
        self.root.addChild(_placement(obj))
        self.n_sides = self.n_isolines = self.n_corners = self.n_marks = 0
        if result.satisfied:
            for side in range(6):
                self._side(result.boundary, side)
            self.root.addChild(_points(result.requirement["corner"], CORNER, 9.0))
            self.n_corners = 8
        marks = violation_points(result)
        if marks:
            self.root.addChild(_points(marks, BAD, 13.0))
            self.n_marks = len(marks)

    def _side(self, boundary, side):
        grids, boxes = _patch_grids(boundary, side)
        if not len(grids):
            return
        self._faces(grids, SIDE_COLOURS[side])
        for edge, axis, place in ((0, 2, 0.0), (-1, 3, 1.0)):
            self._isoline(grids[boxes[:, axis] == place][:, edge])
        for edge, axis, place in ((0, 0, 0.0), (-1, 1, 1.0)):
            self._isoline(grids[boxes[:, axis] == place][:, :, edge])
        self.n_sides += 1

    def _faces(self, grids, colour):
        n = STEPS
        j, i = np.divmod(np.arange(n * n), n)
        a = j * (n + 1) + i
        quad = np.stack([a, a + 1, a + n + 2, a + n + 1], 1)
        shift = (n + 1) ** 2 * np.arange(len(grids))[:, None, None]
        index = np.full((len(grids), n * n, 5), -1, np.int32)
        index[:, :, :4] = quad + shift
        coordinates = coin.SoCoordinate3()
        scene.fill(coordinates.point, grids.reshape(-1, 3).astype(np.float32))
        faces = coin.SoIndexedFaceSet()
        scene.fill(faces.coordIndex, index.reshape(-1))
        material = coin.SoMaterial()
        material.diffuseColor = colour
        hints = coin.SoShapeHints()
        hints.vertexOrdering = coin.SoShapeHints.COUNTERCLOCKWISE
        hints.shapeType = coin.SoShapeHints.UNKNOWN_SHAPE_TYPE
        hints.creaseAngle = 0.6
        part = coin.SoSeparator()
        for node in (_offset(-1.0), hints, material, coordinates, faces):
            part.addChild(node)
        self.root.addChild(part)

    def _isoline(self, lines):
        """lines: [element, point, 3]. Each isoline is drawn by both its sides."""
        if not len(lines):
            return
        coordinates = coin.SoCoordinate3()
        scene.fill(coordinates.point, lines.reshape(-1, 3).astype(np.float32))
        drawn = coin.SoLineSet()
        scene.fill(drawn.numVertices, np.full(len(lines), lines.shape[1], np.int32))
        style = coin.SoDrawStyle()
        style.lineWidth = 4.0
        part = _plain(CORNER)
        for node in (style, coordinates, drawn):
            part.addChild(node)
        self.root.addChild(part)
        self.n_isolines += 0.5


class Points(Drawn):
    """Red points in the coordinates of the document."""

    def __init__(self, view, points):
        super().__init__(view, "TsolidPoints")
        self.root.addChild(_points(points, BAD, 13.0))
        self.n_points = len(points)


class Wires(Drawn):
    """Lines over a part: points, and rows of indices that end with -1."""

    def __init__(self, view, obj, points, index):
        super().__init__(view, "TsolidWires")
        self.n_lines = int((index < 0).sum())
        coordinates = coin.SoCoordinate3()
        scene.fill(coordinates.point, points)
        lines = coin.SoIndexedLineSet()
        scene.fill(lines.coordIndex, index)
        part = _plain(CORNER)
        for node in (_placement(obj), _offset(-1.0), coordinates, lines):
            part.addChild(node)
        self.root.addChild(part)


def _placement(obj):
    """From the coordinates of the object's shape to those of the view."""
    outer = obj.getGlobalPlacement().multiply(obj.Placement.inverse())
    node = coin.SoTransform()
    node.translation = tuple(outer.Base)
    node.rotation.setValue(coin.SbRotation(*outer.Rotation.Q))
    return node


def violation_points(result):
    """A place for every finding that refuses the part: its own, or those of what it names."""
    out = []
    for f in result.findings:
        if f.severity.name == "ERROR":
            if f.point:
                out.append(f.point)
                continue
            places = [place_of(result.shape, name) for name in sub_elements(f.where)]
            out += [p for p in places if p is not None]
    return out


def sub_elements(where):
    """FreeCAD's names in a finding's place: "Face3, Edge7" gives both."""
    words = where.replace(",", " ").split()
    return [w for w in words if w.rstrip("0123456789") in ("Face", "Edge", "Vertex", "Solid")]


def place_of(shape, where):
    """A point of the last-named sub-shape; None when there is none."""
    if shape is None:
        return None
    for name in reversed(sub_elements(where)):
        try:
            found = shape.getElement(name)
        except Exception:  # OCC has no exception of its own for a wrong name
            continue
        if name.startswith("Vertex"):
            return tuple(found.Point)
        if name.startswith("Edge"):
            return tuple(found.valueAt(sum(found.ParameterRange) / 2))
        if name.startswith("Face"):
            u0, u1, v0, v1 = found.ParameterRange
            middle = found.Surface.value((u0 + u1) / 2, (v0 + v1) / 2)
            return tuple(Part.Vertex(middle).distToShape(found)[1][0][1])  # beside a hole in it
        return tuple(found.BoundBox.Center)
    return None


def zoom_to(view, point, size):
    """Moves the camera to look at a point, with so much around it, from where it looks now."""
    camera = view.getCameraNode()
    direction = camera.orientation.getValue().multVec(coin.SbVec3f(0, 0, -1))
    distance = max(camera.focalDistance.getValue(), 2 * size)
    camera.position = coin.SbVec3f(*point) - direction * distance
    camera.focalDistance = distance
    if hasattr(camera, "height"):
        camera.height = size
