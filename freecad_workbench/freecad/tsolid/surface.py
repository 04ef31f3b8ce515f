# SPDX-License-Identifier: LGPL-2.1-or-later
"""T-spline surfaces of the library; like binding.py without FreeCAD.

    surface = Surface.read(context, "part.tsm")
    surface.facts()
    patches = surface.patches(context)
    boundary = Boundary.from_surface(context, surface)
"""

import os
from ctypes import byref, c_double, c_void_p

from . import binding, header

COUNTS = (
    "faces",
    "edges",
    "vertices",
    "points",
    "t_junctions",
    "boundary_loops",
    "boundary_edges",
    "parts",
    "elements",
)


class Surface(binding._Handle):
    """A T-spline surface, open or closed: .tsm, or Bezier elements as .iga."""

    _free = "tsolid_surface_free"

    @classmethod
    def read(cls, context, path):
        """A file that begins with #TS is .tsm, any other is taken for .iga."""
        with open(path, "rb") as stream:
            begin = stream.read(8)
        name = "tsolid_read_tsm" if b"#TS" in begin else "tsolid_read_iga"
        handle = c_void_p()
        context.call(name, os.fsencode(path), byref(handle))
        return cls(context, handle)

    def __init__(self, context, handle):
        super().__init__(context, handle)
        self._view = header.SurfaceView()
        self.library.tsolid_surface_get(handle, byref(self._view))

    def facts(self):
        """Counts, the extraordinary vertices as pairs (number, valence), the defect of the sum."""
        v = self._view
        facts = {name: getattr(v, "n_" + name) for name in COUNTS}
        stars = range(v.n_extraordinary)
        facts["extraordinary"] = [(v.extraordinary[k], v.valence[k]) for k in stars]
        facts["sum_defect"] = v.sum_defect
        return facts

    @property
    def points(self):
        """Homogeneous control points, rows of 4."""
        return binding._view(self._view.points, self, "d", self._view.n_points, 4)

    @property
    def face_sizes(self):
        """Per face the lengths of its u and v in knot units."""
        return binding._view(self._view.face_size, self, "d", self._view.n_faces, 2)

    def elements(self, face):
        """The Bezier elements of a face; boxes (u0, u1, v0, v1) in the face's own u and v."""
        v, out = self._view, []
        n = (v.degree + 1) ** 2
        for e in range(v.element_start[face], v.element_start[face + 1]):
            entries = range(v.function_start[e], v.function_start[e + 1])
            out.append(
                binding.BezierElement(
                    tuple(v.box[4 * e : 4 * e + 4]),
                    [v.function[k] for k in entries],
                    [v.coefficient[n * k : n * k + n] for k in entries],
                )
            )
        return out

    def evaluate(self, context, face, u, v, order=0):
        """Rows of 3: the point; with order 1 also its derivatives by u and v."""
        out = (c_double * 9)()
        context.call("tsolid_surface_evaluate", self.handle, face, u, v, order, out)
        return [tuple(out[3 * k : 3 * k + 3]) for k in range(3 if order else 1)]

    def patches(self, context):
        """The surface as exact B-spline patches."""
        handle = c_void_p()
        context.call("tsolid_surface_patches", self.handle, byref(handle))
        return binding.BoundaryFile(context, handle).patches()

    def write_tsm(self, context, path):
        context.call("tsolid_write_tsm", self.handle, os.fsencode(path))
