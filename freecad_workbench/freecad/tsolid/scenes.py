# SPDX-License-Identifier: LGPL-2.1-or-later
"""The nodes of one SolidTSpline, one root per display mode."""

import numpy as np

from . import scene, section, tessellate

ELEMENTS, TMESH, CONTROL, PARTS = "Elements", "T-mesh", "Control net", "Parts"


class Scenes:
    def __init__(self, look, obj, roots):
        self.elements = scene.ElementScene()
        self.elements.set_geometry(look)
        self.lines = scene.LineScene()
        self.points = scene.PointScene()
        self.net = scene.LineScene(1.0)
        self.section = scene.SectionScene()
        self.grids = None  # section.Grids, when first cut
        self.mark = scene.MarkScene()
        self.mark.show(None)
        self.tmesh = None  # tessellate.Lines, when first shown
        self.control = None
        self.by = None
        self.roots = roots
        children = {
            ELEMENTS: (self.elements.root, self.section.root, self.mark.root),
            PARTS: (self.elements.root, self.section.root, self.mark.root),
            TMESH: (self.lines.root,),
            CONTROL: (self.elements.plain_root, self.net.root, self.points.root),
        }
        for mode, nodes in children.items():
            roots[mode].removeAllChildren()
            for node in nodes:
                roots[mode].addChild(node)

    def recolour(self, look, by, anew=False):
        if by != self.by or anew:
            self.elements.set_colours(look.colours(by))
            self.by = by

    def show_lines(self, on):
        self.elements.show_lines(on)
        self.section.show_lines(on)

    def element_of(self, picked):
        """The element of a picked point; None when it is none of these faces."""
        element = self.elements.element_of(picked)
        return self.section.element_of(picked) if element is None else element

    def refresh_cut(self, look, deep, axis, share):
        """The elements in `deep`, cut by a plane."""
        if self.grids is None:
            self.grids = section.Grids(look)
        place = look.low[axis] + share * (look.high[axis] - look.low[axis])
        self.elements.clip_at(axis, place)
        self.elements.show(look, deep & self.grids.touches(axis, place))
        values = self.grids.result() if self.by == "Result" else None
        triangles, values, owner, segments = self.grids.cut(deep, axis, place, values)
        packed = section.colours(look, self.by, values, owner)
        self.section.show(axis, triangles, packed, owner, segments)

    def refresh(self, look, kept, mode):
        self.section.hide()
        self.elements.clip_at(0, None)
        if mode == TMESH:
            self._ensure_tmesh(look)
            self.lines.show(self.tmesh.indices(kept))
        elif mode == CONTROL:
            self._ensure_control(look)
            self.elements.show(look, kept)
            self.net.show(self.control.indices(look.seen(kept)))
        else:
            self.elements.show(look, kept)

    def _ensure_tmesh(self, look):
        if self.tmesh is None:
            self.tmesh = tessellate.Lines(look, look.solid.tmesh)
            self.lines.set_geometry(self.tmesh.point, self.tmesh.colours(look))

    def _ensure_control(self, look):
        if self.control is None:
            self.control = tessellate.ControlNet(look)
            space = look.solid.space
            control = np.array(look.solid.control).reshape(-1, 4)
            kind = np.zeros(len(control), int)
            kind[space.n_inner:] = 1
            kind[space.n_inner + space.n_surface:] = 2
            colours = tessellate.packed(np.array(scene.CONTROL_COLOURS)[kind])
            points = (control[:, :3] / control[:, 3:]).astype(np.float32)
            self.points.set_geometry(points, colours)
            self.net.set_geometry(self.control.point, self.control.colours(look))
