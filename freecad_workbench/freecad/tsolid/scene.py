# SPDX-License-Identifier: LGPL-2.1-or-later
"""Coin nodes that show a tessellate.Look: elements, T-mesh, control points, one element marked.

Arrays go into Coin's fields as one block of memory: number by number would take a hundred times
as long, and a slider step has 25 milliseconds.
"""

import ctypes

import numpy as np
from pivy import coin

LINE = (0.13, 0.15, 0.20)
PLAIN = (0.88, 0.89, 0.91)
MARK = (1.0, 0.20, 0.10)
CONTROL_COLOURS = ((0.93, 0.50, 0.69), (0.36, 0.58, 0.88), (0.86, 0.62, 0.10))


def fill(field, array):
    """Sets all values of a multiple-value field from a contiguous array."""
    array = np.ascontiguousarray(array)
    field.setNum(len(array))
    if not len(array):
        return
    memory = field.startEditing()
    ctypes.memmove(int(getattr(memory, "this", memory)), array.ctypes.data, array.nbytes)
    field.finishEditing()


def _line_style(width, colour):
    style = coin.SoDrawStyle()
    style.lineWidth = width
    base = coin.SoBaseColor()
    base.rgb = colour
    light = coin.SoLightModel()
    light.model = coin.SoLightModel.BASE_COLOR
    binding = coin.SoMaterialBinding()
    binding.value = coin.SoMaterialBinding.OVERALL
    return [light, style, binding, base]


def _separator(*nodes):
    out = coin.SoSeparator()
    for node in nodes:
        out.addChild(node)
    return out


class _PickedScene:
    """Coloured faces with their borders; a picked face tells its element."""

    owners_per_element = 1  # entries of `owner` count so many for each element

    def show_lines(self, on):
        self.line_switch.whichChild = coin.SO_SWITCH_ALL if on else coin.SO_SWITCH_NONE

    def element_of(self, picked):
        """The element of a picked point; None when it is none of these faces."""
        detail = picked.getDetail()
        if detail is None or not detail.isOfType(coin.SoFaceDetail.getClassTypeId()):
            return None
        if picked.getPath().getTail() != self.faces:
            return None
        face = coin.cast(detail, "SoFaceDetail").getFaceIndex()
        if not 0 <= face < len(self.owner):
            return None
        return int(self.owner[face]) // self.owners_per_element


class ElementScene(_PickedScene):
    """The faces of the kept elements with their borders."""

    owners_per_element = 6  # half-faces

    def __init__(self):
        self.coordinates = coin.SoCoordinate3()
        self.normals = coin.SoNormal()
        self.colours = coin.SoPackedColor()
        self.faces = coin.SoIndexedFaceSet()
        self.lines = coin.SoIndexedLineSet()
        self.line_switch = coin.SoSwitch()
        self.line_switch.whichChild = coin.SO_SWITCH_ALL
        self.clip = coin.SoClipPlane()
        self.clip.on = False
        self.root = _separator(self.clip, self.coordinates, self._face_part(), self._line_part())
        self.plain_root = self._plain_faces()
        self.owner = np.zeros(0, int)  # half-face of each quad

    @staticmethod
    def _hints():
        hints = coin.SoShapeHints()
        hints.vertexOrdering = coin.SoShapeHints.COUNTERCLOCKWISE
        hints.shapeType = coin.SoShapeHints.UNKNOWN_SHAPE_TYPE
        offset = coin.SoPolygonOffset()
        offset.factor, offset.units = 1.0, 1.0
        return hints, offset

    def _plain_faces(self):
        """The same faces in one colour."""
        material = coin.SoMaterial()
        material.diffuseColor = PLAIN
        one = coin.SoMaterialBinding()
        one.value = coin.SoMaterialBinding.OVERALL
        normal_binding = coin.SoNormalBinding()
        normal_binding.value = coin.SoNormalBinding.PER_VERTEX_INDEXED
        return _separator(*self._hints(), material, one, self.coordinates, self.normals,
                          normal_binding, self.faces)

    def _face_part(self):
        hints, offset = self._hints()
        colour_binding = coin.SoMaterialBinding()
        colour_binding.value = coin.SoMaterialBinding.PER_VERTEX_INDEXED
        normal_binding = coin.SoNormalBinding()
        normal_binding.value = coin.SoNormalBinding.PER_VERTEX_INDEXED
        return _separator(
            hints, offset, self.normals, normal_binding, self.colours, colour_binding, self.faces
        )

    def _line_part(self):
        self.line_switch.addChild(_separator(*_line_style(1.0, LINE), self.lines))
        pick = coin.SoPickStyle()
        pick.style = coin.SoPickStyle.UNPICKABLE
        return _separator(pick, self.line_switch)

    def set_geometry(self, look):
        fill(self.faces.coordIndex, np.zeros(0, np.int32))
        fill(self.lines.coordIndex, np.zeros(0, np.int32))
        fill(self.coordinates.point, look.point)
        fill(self.normals.vector, look.normal)

    def clip_at(self, axis, place):
        """Only what lies on the low side of a plane is drawn; None: everything."""
        self.clip.on = place is not None
        if place is not None:
            normal = [0.0, 0.0, 0.0]
            normal[axis] = -1.0
            self.clip.plane = coin.SbPlane(coin.SbVec3f(*normal), -place)

    def set_colours(self, packed):
        fill(self.colours.orderedRGBA, packed)

    def show(self, look, kept):
        """One step of a slider."""
        quads, lines, self.owner = look.indices(look.seen(kept))
        fill(self.faces.coordIndex, quads)
        fill(self.lines.coordIndex, lines)


class SectionScene(_PickedScene):
    """Where a plane cuts the elements."""

    def __init__(self):
        self.coordinates, self.ends = coin.SoCoordinate3(), coin.SoCoordinate3()
        self.colours = coin.SoPackedColor()
        self.faces = coin.SoFaceSet()
        self.lines = coin.SoLineSet()
        self.line_switch = coin.SoSwitch()
        self.normal = coin.SoNormal()
        hints = coin.SoShapeHints()
        hints.vertexOrdering = coin.SoShapeHints.UNKNOWN_ORDERING
        offset = coin.SoPolygonOffset()
        offset.factor, offset.units = 1.0, 1.0
        normal_binding = coin.SoNormalBinding()
        normal_binding.value = coin.SoNormalBinding.OVERALL
        colour_binding = coin.SoMaterialBinding()
        colour_binding.value = coin.SoMaterialBinding.PER_VERTEX
        pick = coin.SoPickStyle()
        pick.style = coin.SoPickStyle.UNPICKABLE
        self.line_switch.addChild(_separator(pick, *_line_style(1.0, LINE), self.ends, self.lines))
        self.root = _separator(
            _separator(hints, offset, self.normal, normal_binding, self.coordinates, self.colours,
                       colour_binding, self.faces),
            self.line_switch,
        )
        self.owner = np.zeros(0, int)  # element of each triangle
        self.hide()

    def hide(self):
        self.owner = np.zeros(0, int)
        fill(self.faces.numVertices, np.zeros(1, np.int32))
        fill(self.lines.numVertices, np.zeros(1, np.int32))

    def show(self, axis, triangles, packed, owner, segments):
        if not len(owner):
            self.hide()
            return
        normal = np.zeros((1, 3), np.float32)
        normal[0, axis] = 1.0
        fill(self.normal.vector, normal)
        fill(self.coordinates.point, triangles.reshape(-1, 3).astype(np.float32))
        fill(self.colours.orderedRGBA, packed)
        fill(self.faces.numVertices, np.full(len(owner), 3, np.int32))
        fill(self.ends.point, segments.reshape(-1, 3).astype(np.float32))
        fill(self.lines.numVertices, np.full(len(segments), 2, np.int32))
        self.owner = owner


class LineScene:
    """Lines with a colour per vertex: the T-mesh."""

    def __init__(self, width=1.5):
        self.coordinates = coin.SoCoordinate3()
        self.colours = coin.SoPackedColor()
        self.lines = coin.SoIndexedLineSet()
        style = _line_style(width, LINE)[:2]
        binding = coin.SoMaterialBinding()
        binding.value = coin.SoMaterialBinding.PER_VERTEX_INDEXED
        self.root = _separator(*style, self.coordinates, self.colours, binding, self.lines)

    def set_geometry(self, points, colours):
        fill(self.lines.coordIndex, np.zeros(0, np.int32))
        fill(self.coordinates.point, points)
        fill(self.colours.orderedRGBA, colours)

    def show(self, index):
        fill(self.lines.coordIndex, index)


class PointScene:
    """Points of one size with a colour each: the control points."""

    def __init__(self, size=5.0):
        self.coordinates = coin.SoCoordinate3()
        self.colours = coin.SoPackedColor()
        self.points = coin.SoPointSet()
        light = coin.SoLightModel()
        light.model = coin.SoLightModel.BASE_COLOR
        style = coin.SoDrawStyle()
        style.pointSize = size
        binding = coin.SoMaterialBinding()
        binding.value = coin.SoMaterialBinding.PER_VERTEX
        self.root = _separator(light, style, self.coordinates, self.colours, binding, self.points)

    def set_geometry(self, points, colours):
        fill(self.coordinates.point, points)
        fill(self.colours.orderedRGBA, colours)
        self.points.numPoints = len(points)


class MarkScene:
    """The outline of one element, drawn over everything."""

    def __init__(self):
        self.coordinates = coin.SoCoordinate3()
        self.lines = coin.SoLineSet()
        buffer = coin.SoDepthBuffer()
        buffer.test = False
        pick = coin.SoPickStyle()
        pick.style = coin.SoPickStyle.UNPICKABLE
        self.root = _separator(pick, buffer, *_line_style(3.0, MARK), self.coordinates, self.lines)

    def show(self, outline):
        """outline: [edge, point, 3]; None: nothing."""
        if outline is None:
            fill(self.lines.numVertices, np.zeros(1, np.int32))
            return
        fill(self.coordinates.point, outline.reshape(-1, 3).astype(np.float32))
        fill(self.lines.numVertices, np.full(len(outline), outline.shape[1], np.int32))
