# SPDX-License-Identifier: LGPL-2.1-or-later
"""The library's objects as Python classes; no FreeCAD, nothing but the standard library.

    context = Context(progress=print)
    boundary = Boundary.from_file(context, "part.tsb")
    tmesh = TMesh.create(context, boundary)
    space = Space.create(context, boundary, tmesh)
    solid = Solid.create(context, space).optimised(context)
    certificate = Certificate.of(context, solid)

Arrays are read-only memoryviews into the library's memory; each keeps its owner alive.
"""

import collections
import ctypes
import json
import math
import os
import weakref
from array import array
from ctypes import byref, c_char_p, c_double, c_int, c_void_p

from . import header
from .header import Entity, Severity, Status, Verdict
from .library import LibraryError, load  # noqa: F401  (LibraryError is part of this module's face)

SIDE_NAMES = ("x low", "x high", "y low", "y high", "z low", "z high")
BORDER_NAMES = ("v low", "u high", "v high", "u low")
CORNER_NAMES = ("u low v low", "u high v low", "u high v high", "u low v high")

_ITEM_SIZE = {
    "d": ctypes.sizeof(c_double),
    "i": ctypes.sizeof(c_int),
    "Q": ctypes.sizeof(ctypes.c_size_t),
}


class Finding(
    collections.namedtuple(
        "Finding", "severity status stage where text point measured allowed entity index"
    )
):
    """What was found, and where. point is None or (x, y, z); measured and allowed may be None."""

    __slots__ = ()

    def as_dict(self):
        return {
            "severity": self.severity.name.lower(),
            "stage": self.stage,
            "where": self.where,
            "text": self.text,
            "point": None if self.point is None else list(self.point),
            "measured": self.measured,
            "allowed": self.allowed,
        }

    def __str__(self):
        """The text with whatever of place and numbers it does not say itself."""
        words = [self.text]
        if self.where and self.where not in self.text:
            words.insert(0, self.where + ":")
        if self.measured is not None and "%.6g" % self.measured not in self.text:
            words.append("(measured %.6g" % self.measured)
            words[-1] += ")" if self.allowed is None else ", allowed %.6g)" % self.allowed
        if self.point is not None and "at (" not in self.text:
            words.append("at (%.6g, %.6g, %.6g)" % self.point)
        return " ".join(words)


def finding(severity, stage, where, text, point=None, measured=None, allowed=None):
    """A finding of this package's own, beside those of the library."""
    status = Status.ERROR_REFUSED if severity == Severity.ERROR else Status.OK
    point = None if point is None else tuple(float(x) for x in point)
    return Finding(
        severity, status, stage, where, text, point, measured, allowed, Entity.ENTITY_NONE, (-1, -1)
    )


class TsolidError(Exception):
    """A call failed. status and findings say why."""

    def __init__(self, status, findings):
        self.status = Status(status)
        self.findings = list(findings)
        errors = [f for f in self.findings if f.severity == Severity.ERROR]
        super().__init__("; ".join(str(f) for f in errors) or self.status.name.lower())


class Refused(TsolidError):
    """The part is outside the class of parts taken. requirement holds how far the check got."""

    requirement = None


class Cancelled(TsolidError):
    """The progress callback asked to stop."""


_ERRORS = {Status.ERROR_REFUSED: Refused, Status.ERROR_CANCELLED: Cancelled}


def _number(value):
    return None if math.isnan(value) else value


def _text(value):
    return "" if value is None else value.decode("utf-8", "replace")


def as_dict(struct):
    """A ctypes struct of the header as plain dicts, lists and numbers."""
    if isinstance(struct, ctypes.Structure):
        return {name: as_dict(getattr(struct, name)) for name, *_ in struct._fields_}
    if isinstance(struct, ctypes.Array) and struct._type_ is ctypes.c_char:
        return struct.value.decode("utf-8", "replace")
    if isinstance(struct, ctypes.Array):
        return [as_dict(item) for item in struct]
    return struct


def _view(pointer, owner, item, *shape):
    """Read-only memoryview of `shape` items at `pointer`; it keeps `owner` alive."""
    count = 1
    for n in shape:
        count *= n
    if count == 0 or not pointer:
        return memoryview(array(item)).toreadonly()
    address = ctypes.cast(pointer, c_void_p).value
    memory = (ctypes.c_ubyte * (count * _ITEM_SIZE[item])).from_address(address)
    memory.owner = owner
    return memoryview(memory).cast("B").cast(item, shape=list(shape)).toreadonly()


def _doubles(values):
    """A C array of doubles from an iterable of numbers or of rows of numbers."""
    flat = array("d")
    for value in values:
        if isinstance(value, (int, float)):
            flat.append(value)
        else:
            flat.extend(value)
    n = len(flat)
    if n == 0:
        flat.append(0.0)
    return (c_double * len(flat)).from_buffer(flat), n


class Context:
    """Errors with a place, progress and cancel for a chain of calls; for one thread at a time.

    progress(stage, fraction) may return true to cancel; an exception it raises cancels too and is
    raised again when the library has returned.
    """

    def __init__(self, progress=None, threads=0, library=None):
        self.library = library or load()
        self._progress = progress
        self._raised = None
        self._patches = ()
        options = header.ContextOptions()
        options.n_threads = threads
        if progress is not None:
            reference = weakref.ref(self)
            options.progress = header.PROGRESS(lambda d, s, f: _call_progress(reference, s, f))
        self._options = options  # keeps the callback alive
        handle = c_void_p()
        status = self.library.tsolid_context_create(byref(options), byref(handle))
        if status != Status.OK:
            raise TsolidError(status, [])
        self.handle = handle
        self._finalizer = weakref.finalize(self, self.library.tsolid_context_free, handle)
        self._finalizer.atexit = False

    def call(self, name, *arguments):
        """Calls a fallible function with this context in front; raises what its status means."""
        self._raised = None
        first = self.library.tsolid_context_n_findings(self.handle)
        status = getattr(self.library, name)(self.handle, *arguments)
        raised, self._raised = self._raised, None
        if raised is not None:
            raise raised
        if status != Status.OK:
            raise _ERRORS.get(status, TsolidError)(status, self.findings()[first:])

    def findings(self):
        """All findings since the context was made or cleared."""
        n = self.library.tsolid_context_n_findings(self.handle)
        return [self._finding(i) for i in range(n)]

    def clear(self):
        self.library.tsolid_context_clear(self.handle)

    def name_by(self, patches):
        """Findings about input patches are named by these Patch objects from now on."""
        self._patches = tuple(patches)

    def _finding(self, i):
        f = self.library.tsolid_context_finding(self.handle, i).contents
        index = tuple(f.index)
        return Finding(
            Severity(f.severity),
            Status(f.status),
            _text(f.stage),
            self._where(Entity(f.entity), index),
            _text(f.text),
            tuple(f.point) if f.has_point else None,
            _number(f.measured),
            _number(f.allowed),
            Entity(f.entity),
            index,
        )

    def _where(self, entity, index):
        if entity == Entity.ENTITY_NONE:
            return ""
        if entity in (Entity.ENTITY_PATCH, Entity.ENTITY_BORDER, Entity.ENTITY_VERTEX):
            return self._where_in_patch(entity, *index)
        if entity == Entity.ENTITY_SIDE and 0 <= index[0] < 6:
            return "side %s" % SIDE_NAMES[index[0]]
        if entity == Entity.ENTITY_SURFACE_VERTEX:
            return "vertex %d" % index[0]
        return "%s %d" % (entity.name[len("ENTITY_") :].lower(), index[0])

    def _where_in_patch(self, entity, k, j):
        patch = self._patches[k] if 0 <= k < len(self._patches) else None
        name = patch.name if patch is not None and patch.name else "patch %d" % k
        if entity == Entity.ENTITY_PATCH or not 0 <= j < 4:
            return name
        border = entity == Entity.ENTITY_BORDER
        own = (patch.border_names if border else patch.corner_names) if patch is not None else None
        if own and own[j]:
            return own[j]
        return "%s, %s" % (name, (BORDER_NAMES if border else CORNER_NAMES)[j])


def _call_progress(reference, stage, fraction):
    context = reference()
    if context is None:
        return 1
    try:
        return 1 if context._progress(_text(stage), fraction) else 0
    except BaseException as error:  # nothing may pass through the C frames, not even Ctrl-C
        context._raised = error
        return 1


class _Handle:
    """A reference counted handle of the library."""

    _free = ""

    def __init__(self, context, handle):
        self.library = context.library
        self.handle = handle
        self._finalizer = weakref.finalize(self, getattr(self.library, self._free), handle)
        self._finalizer.atexit = False


class Patch:
    """A NURBS patch; see tsolid_patch. Control point (i, j) is entry i + n_control[0] * j."""

    __slots__ = (
        "degree",
        "n_control",
        "knots",
        "points",
        "weights",
        "name",
        "border_names",
        "corner_names",
        "border_tolerance",
    )

    def __init__(self, degree, n_control, knots, points, weights=None, name="", **names):
        self.degree = tuple(degree)
        self.n_control = tuple(n_control)
        self.knots = tuple(tuple(k) for k in knots)
        self.points = [tuple(p) for p in points]
        self.weights = None if weights is None else list(weights)
        self.name = name
        self.border_names = tuple(names.pop("border_names", None) or ("",) * 4)
        self.corner_names = tuple(names.pop("corner_names", None) or ("",) * 4)
        self.border_tolerance = tuple(names.pop("border_tolerance", None) or (0.0,) * 4)
        if names:
            raise TypeError("unknown argument %s" % ", ".join(sorted(names)))
        self._check_lengths()

    def _check_lengths(self):
        n = self.n_control[0] * self.n_control[1]
        knots = [self.n_control[i] + self.degree[i] + 1 for i in (0, 1)]
        if [len(k) for k in self.knots] != knots or len(self.points) != n:
            raise ValueError("%s: numbers of knots or control points do not fit" % self.name)
        if any(len(p) != 3 for p in self.points):
            raise ValueError("%s: a control point has three coordinates" % self.name)
        if self.weights is not None and len(self.weights) != n:
            raise ValueError("%s: one weight per control point" % self.name)

    def fill(self, struct, keep):
        """Fills a PatchStruct; appends to keep what must live as long."""
        for i in (0, 1):
            struct.degree[i] = self.degree[i]
            struct.n_control[i] = self.n_control[i]
            struct.knots[i] = self._array(self.knots[i], keep)
        struct.points = self._array(self.points, keep)
        if self.weights is not None:
            struct.weights = self._array(self.weights, keep)
        struct.name = self.name.encode() or None
        for k in range(4):
            struct.border_name[k] = self.border_names[k].encode() or None
            struct.corner_name[k] = self.corner_names[k].encode() or None
            struct.border_tolerance[k] = self.border_tolerance[k]

    @staticmethod
    def _array(values, keep):
        memory, _ = _doubles(values)
        keep.append(memory)
        return ctypes.cast(memory, ctypes.POINTER(c_double))

    @classmethod
    def from_struct(cls, struct):
        """A copy of what a PatchStruct of the library points to."""
        n, m = struct.n_control
        knots = [struct.knots[i][: struct.n_control[i] + struct.degree[i] + 1] for i in (0, 1)]
        flat = struct.points[: 3 * n * m]
        return cls(
            struct.degree,
            (n, m),
            knots,
            [flat[3 * i : 3 * i + 3] for i in range(n * m)],
            struct.weights[: n * m] if struct.weights else None,
            _text(struct.name),
            border_names=[_text(x) for x in struct.border_name],
            corner_names=[_text(x) for x in struct.corner_name],
            border_tolerance=list(struct.border_tolerance),
        )


class _PatchInput:
    """A BoundaryInput made of Patch objects, and the memory it points to."""

    def __init__(self, patches):
        self.keep = []
        self.structs = (header.PatchStruct * max(1, len(patches)))()
        for struct, patch in zip(self.structs, patches):
            patch.fill(struct, self.keep)
        self.input = header.BoundaryInput(len(patches), self.structs)


def write_tsb(context, patches, path):
    """Writes patches as a .tsb file."""
    holder = _PatchInput(patches)
    context.call("tsolid_write_tsb", byref(holder.input), os.fsencode(path))


class BoundaryFile(_Handle):
    """A boundary as read from .tsb, not yet checked."""

    _free = "tsolid_boundary_file_free"

    @classmethod
    def read(cls, context, path):
        handle = c_void_p()
        context.call("tsolid_read_tsb", os.fsencode(path), byref(handle))
        return cls(context, handle)

    @property
    def input(self):
        return self.library.tsolid_boundary_file_input(self.handle).contents

    def patches(self):
        """Copies of the patches; none when some are not NURBS patches: they have no mirror here."""
        given = self.input
        if given.n_points:
            return []
        return [Patch.from_struct(given.patches[k]) for k in range(given.n_patches)]


BezierElement = collections.namedtuple("BezierElement", "box functions coefficients")


class Boundary(_Handle):
    """The input boundary in canonical position."""

    _free = "tsolid_boundary_free"

    @classmethod
    def create(cls, context, patches, tolerance=0.0, refine_knots=0, raise_degree=0, corners=()):
        """From Patch objects. Raises Refused when the eight-corner requirement does not hold, or
        when the cube's corners are not the eight points `corners`, if there are any.
        """
        patches = list(patches)
        holder = _PatchInput(patches)
        context.name_by(patches)
        corners = [tuple(point) for point in corners]
        options = (tolerance, refine_knots, raise_degree, len(corners), _doubles(corners)[0])
        return cls._create(context, holder.input, options, len(patches))

    @classmethod
    def from_file(cls, context, source, tolerance=0.0, refine_knots=0, raise_degree=0):
        """From a .tsb path or a BoundaryFile."""
        if not isinstance(source, BoundaryFile):
            source = BoundaryFile.read(context, source)
        context.name_by(source.patches())
        options = (tolerance, refine_knots, raise_degree)
        return cls._create(context, source.input, options, source.input.n_patches)

    @classmethod
    def from_surface(cls, context, surface, tolerance=0.0):
        """From a closed Surface, cut into six sides along its isolines."""
        context.name_by(())
        given = header.BoundaryInput(0, None, None, surface.handle)
        return cls._create(context, given, (tolerance, 0, 0), 0)

    @classmethod
    def _create(cls, context, given, options, n_patches):
        requirement = header.Requirement()
        handle = c_void_p()
        try:
            context.call(
                "tsolid_boundary_create",
                byref(given),
                byref(header.BoundaryOptions(*options)),
                byref(requirement),
                byref(handle),
            )
        except Refused as error:
            error.requirement = as_dict(requirement)
            raise
        boundary = cls(context, handle)
        boundary.n_patches = n_patches
        return boundary

    n_patches = 0

    @property
    def scale(self):
        return self.library.tsolid_boundary_scale(self.handle)

    @property
    def requirement(self):
        struct = header.Requirement()
        self.library.tsolid_boundary_requirement(self.handle, byref(struct))
        return as_dict(struct)

    @property
    def preparation(self):
        struct = header.Preparation()
        self.library.tsolid_boundary_preparation(self.handle, byref(struct))
        return as_dict(struct)

    def _struct(self):
        struct = header.BezierBoundary()
        self.library.tsolid_boundary_view(self.handle, byref(struct))
        return struct

    @property
    def points(self):
        """Homogeneous control points, rows of 4."""
        struct = self._struct()
        return _view(struct.points, self, "d", struct.n_functions, 4)

    def side_degree(self, side):
        return tuple(self._struct().side[side].degree)

    def elements(self, side):
        """The side's Bezier elements: box, function numbers, coefficients (s fastest) of each."""
        struct = self._struct().side[side]
        n = struct.n_elements
        start = _view(struct.function_start, self, "i", n + 1)
        size = (struct.degree[0] + 1) * (struct.degree[1] + 1)
        boxes = _view(struct.box, self, "d", 4 * n)
        functions = _view(struct.function, self, "i", start[n])
        values = _view(struct.coefficient, self, "d", start[n] * size)
        for e in range(n):
            a, b = start[e], start[e + 1]
            rows = [values[k * size : (k + 1) * size] for k in range(a, b)]
            yield BezierElement(tuple(boxes[4 * e : 4 * e + 4]), functions[a:b], rows)

    def placement(self, k, i=0):
        """Where piece i of input patch k lies."""
        struct = header.Placement()
        status = self.library.tsolid_boundary_placement(self.handle, k, i, byref(struct))
        if status != Status.OK:
            raise TsolidError(status, [])
        return Placement(struct)

    def placements(self, k):
        """The pieces of input patch k: one, unless vertices of neighbours made the library cut it;
        then a grid, along u first.
        """
        count = self.library.tsolid_boundary_n_placements(self.handle, k)
        return Placements(self.placement(k, i) for i in range(max(count, 1)))


class Placements(tuple):
    """The placements of all pieces of a patch."""

    def locate(self, u, v):
        """Side and (s, t) of a point of the patch."""
        def outside(place):
            u0, u1, v0, v1 = place.domain
            return max((u0 - u) / (u1 - u0), (u - u1) / (u1 - u0), 0.0) + max(
                (v0 - v) / (v1 - v0), (v - v1) / (v1 - v0), 0.0
            )

        place = min(self, key=outside)
        return (place.side, *place.map(u, v))


class Placement:
    """Where a piece of an input patch lies on the cube: (u, v) of the patch to (s, t) of a side."""

    def __init__(self, struct):
        self.side = struct.side
        self.swap = bool(struct.swap)
        self.flip = tuple(bool(f) for f in struct.flip)
        self.box = tuple(struct.box)
        self.domain = tuple(struct.domain)
        self.moebius = tuple(struct.moebius)  # (1, 1): the map is affine

    def map(self, u, v):
        a, b, c, d = self.domain
        p, q = (u - a) / (b - a), (v - c) / (d - c)
        p, q = (
            a * x / (a * x + (1.0 - x)) if a != 1.0 else x for a, x in zip(self.moebius, (p, q))
        )
        p = 1.0 - p if self.flip[0] else p
        q = 1.0 - q if self.flip[1] else q
        if self.swap:
            p, q = q, p
        s0, s1, t0, t1 = self.box
        return s0 + p * (s1 - s0), t0 + q * (t1 - t0)


class TMesh(_Handle):
    """The T-mesh: planes and cells of core and arms."""

    _free = "tsolid_tmesh_free"

    @classmethod
    def create(cls, context, boundary, min_cells=0, isotropic=False, analysis_suitable=True,
               sharp_core=False):
        """min_cells: at least so many core cells per axis; 0: the library's default.

        isotropic: the octree halves all three axes at every split, as in the paper.
        analysis_suitable: False leaves out the closure; the solid is then a rational T-spline.
        sharp_core: functions that are only continuous across all of the core surface.
        """
        options = header.TmeshOptions(min_cells, isotropic, not analysis_suitable, sharp_core)
        handle = c_void_p()
        context.call("tsolid_tmesh_create", boundary.handle, byref(options), byref(handle))
        return cls(context, handle)

    def _struct(self):
        struct = header.TmeshView()
        self.library.tsolid_tmesh_get(self.handle, byref(struct))
        return struct

    @property
    def n_cells(self):
        return self._struct().n_cells

    @property
    def cells(self):
        """Rows of lo[3], hi[3] in plane indices."""
        struct = self._struct()
        return _view(struct.cell, self, "i", struct.n_cells, 6)

    @property
    def cell_blocks(self):
        struct = self._struct()
        return _view(struct.cell_block, self, "i", struct.n_cells)

    def plane_values(self, axis):
        struct = self._struct()
        return _view(struct.plane_value[axis], self, "d", struct.n_planes[axis])

    @property
    def statistics(self):
        struct = self._struct()
        names = ("n_cells", "n_nodes", "n_partial_extraordinary", "n_extraordinary")
        return {name: getattr(struct, name) for name in names}


class Space(_Handle):
    """Blending functions and their Bezier extraction."""

    _free = "tsolid_space_free"

    @classmethod
    def create(cls, context, boundary, tmesh):
        handle = c_void_p()
        context.call("tsolid_space_create", boundary.handle, tmesh.handle, byref(handle))
        return cls(context, handle)

    def _struct(self):
        struct = header.SpaceView()
        self.library.tsolid_space_get(self.handle, byref(struct))
        return struct

    @property
    def n_functions(self):
        return self._struct().n_functions

    @property
    def n_inner(self):
        return self._struct().n_inner

    @property
    def n_surface(self):
        return self._struct().n_surface

    @property
    def n_elements(self):
        return self._struct().n_elements

    @property
    def element_blocks(self):
        struct = self._struct()
        return _view(struct.element_block, self, "i", struct.n_elements)

    @property
    def element_degrees(self):
        struct = self._struct()
        return _view(struct.element_degree, self, "i", struct.n_elements, 3)

    @property
    def element_boxes(self):
        """Rows of lo[3], hi[3] in cross coordinates."""
        struct = self._struct()
        return _view(struct.element_box, self, "d", struct.n_elements, 6)

    def extraction(self, context, element):
        """The functions on an element, and rows of their Bernstein coefficients, u[0] fastest."""
        n = c_int()
        context.call("tsolid_space_extraction", self.handle, element, 0, byref(n), None, None)
        d = self.element_degrees[element, 0], self.element_degrees[element, 1]
        size = (d[0] + 1) * (d[1] + 1) * (self.element_degrees[element, 2] + 1)
        functions = (c_int * max(1, n.value))()
        values = (c_double * max(1, n.value * size))()
        context.call(
            "tsolid_space_extraction", self.handle, element, n.value, byref(n), functions, values
        )
        rows = [values[k * size : (k + 1) * size] for k in range(n.value)]
        return list(functions[: n.value]), rows


class Solid(_Handle):
    """The solid T-spline."""

    _free = "tsolid_solid_free"
    HARMONIC_ONLY, QUICK, THOROUGH = 1, 2, 3

    @classmethod
    def create(cls, context, space):
        """Positive inner weights and a smooth start."""
        handle = c_void_p()
        context.call("tsolid_solid_create", space.handle, byref(handle))
        return cls(context, handle)

    @classmethod
    def read(cls, context, path):
        handle = c_void_p()
        context.call("tsolid_read_tsolid", os.fsencode(path), byref(handle))
        return cls(context, handle)

    @classmethod
    def from_control(cls, context, space, control):
        """control: homogeneous control points of all functions, rows of 4."""
        memory, n = _doubles(control)
        if n != 4 * space.n_functions:
            raise ValueError("%d numbers, %d expected" % (n, 4 * space.n_functions))
        handle = c_void_p()
        context.call("tsolid_solid_from_control", space.handle, memory, byref(handle))
        return cls(context, handle)

    def optimised(self, context, effort=0):
        options = header.SolidOptions(effort)
        handle = c_void_p()
        context.call("tsolid_solid_optimise", self.handle, byref(options), byref(handle))
        return type(self)(context, handle)

    def write(self, context, path):
        context.call("tsolid_write_tsolid", self.handle, os.fsencode(path))

    def write_vtu(self, context, path):
        context.call("tsolid_write_vtu", self.handle, os.fsencode(path))

    @property
    def space(self):
        return _Borrowed(Space, self, self.library.tsolid_solid_space(self.handle)).value

    @property
    def boundary(self):
        handle = self.library.tsolid_space_boundary(self.library.tsolid_solid_space(self.handle))
        return _Borrowed(Boundary, self, handle).value

    @property
    def tmesh(self):
        handle = self.library.tsolid_space_tmesh(self.library.tsolid_solid_space(self.handle))
        return _Borrowed(TMesh, self, handle).value

    @property
    def control(self):
        """Homogeneous control points of all functions, rows of 4."""
        pointer = self.library.tsolid_solid_control(self.handle)
        return _view(pointer, self, "d", self.space.n_functions, 4)

    def bezier(self, context, element):
        """Homogeneous Bezier control points of an element as a flat array, u[0] fastest."""
        degrees = self.space.element_degrees
        n = 4
        for axis in range(3):
            n *= degrees[element, axis] + 1
        points = (c_double * n)()
        context.call("tsolid_solid_bezier", self.handle, element, points)
        return array("d", points)

    def evaluate(self, context, block, u, order=0):
        """x, and for order 1 or 2 its derivatives, as tuples in the header's order."""
        out = (c_double * 30)()
        context.call("tsolid_solid_evaluate", self.handle, block, (c_double * 3)(*u), order, out)
        rows = (1, 4, 10)[order]
        return [tuple(out[3 * k : 3 * k + 3]) for k in range(rows)]

    def boundary_point(self, side, s, t):
        """Block and cross coordinates of a boundary point."""
        u = (c_double * 3)()
        block = self.library.tsolid_solid_boundary_point(self.handle, side, s, t, u)
        return block, tuple(u)

    def invert(self, context, point, tolerance=0.0):
        """(block, u, distance) of the point, or None when it lies outside."""
        found, block, distance = c_int(), c_int(), c_double()
        u = (c_double * 3)()
        context.call(
            "tsolid_solid_invert",
            self.handle,
            (c_double * 3)(*point),
            tolerance,
            byref(found),
            byref(block),
            u,
            byref(distance),
        )
        return (block.value, tuple(u), distance.value) if found.value else None


class _Borrowed:
    """An object over a handle that another object owns and that lives as long as that."""

    def __init__(self, kind, owner, handle):
        self.value = kind.__new__(kind)
        self.value.library = owner.library
        self.value.handle = c_void_p(handle)
        self.value.owner = owner


class Certificate:
    """The proof that det J > 0, or a point where it is not."""

    def __init__(self, struct, element_verdicts):
        self.verdict = Verdict(struct.verdict)
        self.facts = as_dict(struct)
        self.element_verdicts = element_verdicts

    @classmethod
    def of(cls, context, solid, max_depth=0):
        struct = header.CertificateStruct()
        n = solid.space.n_elements
        verdicts = (c_int * max(1, n))()
        options = header.CertificateOptions(max_depth)
        context.call("tsolid_certify", solid.handle, byref(options), byref(struct), verdicts)
        return cls(struct, [Verdict(v) for v in verdicts[:n]])

    @classmethod
    def of_element(cls, context, degree, points, max_depth=0):
        """Of one rational Bezier element with homogeneous points, u[0] fastest."""
        memory, n = _doubles(points)
        if n != 4 * (degree[0] + 1) * (degree[1] + 1) * (degree[2] + 1):
            raise ValueError("number of control points does not fit the degree")
        struct = header.CertificateStruct()
        options = header.CertificateOptions(max_depth)
        degrees = (c_int * 3)(*degree)
        context.call("tsolid_certify_element", degrees, memory, byref(options), byref(struct))
        return cls(struct, [Verdict(struct.verdict)])


def measure_quality(context, solid):
    """The scaled Jacobian's worst, mean, best, and the input's own bound, as a dict."""
    struct = header.Quality()
    context.call("tsolid_quality_measure", solid.handle, byref(struct))
    return as_dict(struct)


class Report:
    """The conformity report; struct may be given times before json() or facts() is taken."""

    def __init__(self, context, struct):
        self.struct = struct
        self._context = context

    @classmethod
    def measure(cls, context, solid, max_rank_functions=0):
        struct = header.ReportStruct()
        options = header.ReportOptions(max_rank_functions)
        context.call("tsolid_report_measure", solid.handle, byref(options), byref(struct))
        return cls(context, struct)

    @property
    def verdict(self):
        return Verdict(self.struct.certificate.verdict)

    def set_times(self, **seconds):
        for name, value in seconds.items():
            setattr(self.struct.timing, name, value)

    def json(self):
        """The library's own JSON document."""
        text = c_char_p()
        self._context.call("tsolid_report_json", byref(self.struct), byref(text))
        try:
            return text.value.decode("utf-8")
        finally:
            self._context.library.tsolid_release(self._context.handle, text)

    def facts(self):
        return json.loads(self.json())
