# SPDX-License-Identifier: LGPL-2.1-or-later
"""What analysis takes from a solid: hexahedra, matrices, loads, Bezier extraction; no FreeCAD.

    mesh = HexMesh.create(context, solid, size=2.0, order=2)
    stiffness = Matrix.create(context, solid, MatrixKind.ELASTICITY, young=210e3, poisson=0.3)
    load = face_load(context, solid, side=5)
"""

import os
from array import array
from ctypes import POINTER, byref, c_double, c_int, c_void_p, cast

from . import header
from .binding import _doubles, _Handle, _view
from .header import MatrixKind  # noqa: F401  (part of this module's face)


def _region_structs(regions):
    structs = (header.RegionStruct * max(1, len(regions)))()
    for struct, (name, side, box) in zip(structs, regions):
        struct.name, struct.side = name.encode("utf-8"), side
        struct.box[:] = box
    return structs


class HexMesh(_Handle):
    """Conforming hexahedra of a solid. regions: (name, side, (s0, s1, t0, t1)) per named part of
    the boundary; without, the six sides."""

    _free = "tsolid_hex_free"

    @classmethod
    def create(
        cls,
        context,
        solid,
        order=1,
        size=0.0,
        divisions=(0, 0, 0, 0),
        grading=0.0,
        max_elements=0,
        allow_unproved=False,
        regions=(),
    ):
        structs = _region_structs(regions)
        options = header.HexOptions(
            order=order,
            size=size,
            divisions=(c_int * 4)(*divisions),
            grading=grading,
            max_elements=max_elements,
            allow_unproved=bool(allow_unproved),
            n_regions=len(regions),
            regions=structs,
        )
        handle = c_void_p()
        context.call("tsolid_hex_create", solid.handle, byref(options), byref(handle))
        return cls(context, handle)

    @classmethod
    def of_assembly(
        cls,
        context,
        joined,
        solids,
        order=1,
        size=0.0,
        grading=0.0,
        max_elements=0,
        allow_unproved=False,
        divisions=(),
        regions=(),
    ):
        """One mesh of an Assembly as `joined` with a Solid per part gave it: parts share their
        nodes where they touch. divisions, regions: () or a sequence of them per part, as in create.
        """
        if len(divisions) not in (0, len(solids)) or len(regions) not in (0, len(solids)):
            raise ValueError("divisions and regions are one per part: %d" % len(solids))
        structs = (header.HexPart * max(1, len(solids)))()
        for struct, own in zip(structs, divisions):
            struct.divisions[:] = own
        for struct, own in zip(structs, regions):
            struct.n_regions, struct.regions = len(own), _region_structs(own)
        options = header.HexOptions(
            order=order,
            size=size,
            grading=grading,
            max_elements=max_elements,
            allow_unproved=bool(allow_unproved),
        )
        handles = (c_void_p * max(1, len(solids)))(*[s.handle if s else None for s in solids])
        handle = c_void_p()
        context.call(
            "tsolid_hex_assembly_create",
            joined.handle,
            len(solids),
            handles,
            structs,
            byref(options),
            byref(handle),
        )
        return cls(context, handle)

    @property
    def parts(self):
        """name: range of elements, of an assembly; {} of one solid."""
        view = self._get()
        start = view.part_start[: view.n_parts + 1] if view.n_parts else []
        names = [name.decode("utf-8", "replace") for name in view.part_name[: view.n_parts]]
        return {name: range(start[k], start[k + 1]) for k, name in enumerate(names)}

    @property
    def n_shared(self):
        """Nodes that the parts' own meshes have more."""
        return self._get().n_shared

    def _get(self):
        view = header.HexView()
        self.library.tsolid_hex_get(self.handle, byref(view))
        return view

    @property
    def order(self):
        return self._get().order

    @property
    def worst(self):
        """The smallest scaled Jacobian."""
        return self._get().worst

    @property
    def proved(self):
        return bool(self._get().proved)

    @property
    def divisions(self):
        return tuple(self._get().divisions)

    @property
    def nodes(self):
        """Rows of 3."""
        view = self._get()
        return _view(view.nodes, self, "d", view.n_nodes, 3)

    @property
    def elements(self):
        """Rows of 8 or 20 nodes, zero-based, in the order of Abaqus."""
        view = self._get()
        return _view(view.element, self, "i", view.n_elements, view.nodes_per_element)

    @property
    def regions(self):
        """name: rows of (element, face 0..5)."""
        view = self._get()
        start = view.region_start[: view.n_regions + 1]
        names = [name.decode("utf-8", "replace") for name in view.region_name[: view.n_regions]]
        faces = _view(view.region_face, self, "i", start[-1], 2)
        return {name: faces[start[k] : start[k + 1]] for k, name in enumerate(names)}

    def write_inp(self, context, path):
        context.call("tsolid_write_inp", self.handle, os.fsencode(path))

    def write_vtu(self, context, path):
        context.call("tsolid_write_hex_vtu", self.handle, os.fsencode(path))


class Matrix(_Handle):
    """A symmetric sparse matrix of the solid's functions in compressed rows."""

    _free = "tsolid_matrix_free"

    @classmethod
    def create(cls, context, solid, kind, young=1.0, poisson=0.0):
        material = header.Material(young, poisson)
        handle = c_void_p()
        context.call(
            "tsolid_matrix_create", solid.handle, int(kind), byref(material), byref(handle)
        )
        return cls(context, handle)

    def _get(self):
        view = header.MatrixView()
        self.library.tsolid_matrix_get(self.handle, byref(view))
        return view

    @property
    def n_rows(self):
        return self._get().n_rows

    def arrays(self):
        """row_start, column, value; scipy.sparse.csr_matrix takes (value, column, row_start)."""
        view = self._get()
        n = view.row_start[view.n_rows]
        return (
            _view(view.row_start, self, "Q", view.n_rows + 1),
            _view(view.column, self, "i", n),
            _view(view.value, self, "d", n),
        )

    def write_market(self, context, path):
        context.call("tsolid_write_matrix_market", self.handle, os.fsencode(path))

    def write_petsc(self, context, path):
        context.call("tsolid_write_petsc", self.handle, os.fsencode(path))


def face_load(context, solid, side, box=(0.0, 1.0, 0.0, 1.0)):
    """Integrals of all functions over a box (s0, s1, t0, t1) of a side."""
    load = (c_double * solid.space.n_functions)()
    region = header.RegionStruct(None, side, (c_double * 4)(*box))
    context.call("tsolid_face_load", solid.handle, byref(region), load)
    return array("d", load)


def face_functions(context, solid, side, box=(0.0, 1.0, 0.0, 1.0)):
    """The functions that do not vanish on a box of a side: what a Dirichlet condition sets."""
    region = header.RegionStruct(None, side, (c_double * 4)(*box))
    n = c_int()
    context.call("tsolid_face_functions", solid.handle, byref(region), 0, byref(n), None)
    out = (c_int * max(1, n.value))()
    context.call("tsolid_face_functions", solid.handle, byref(region), n.value, byref(n), out)
    return list(out[: n.value])


def read_table(context, path):
    """n_rows, n_columns and the numbers, row by row, of a MatrixMarket table or a PETSc vector."""
    rows, columns, value = c_int(), c_int(), POINTER(c_double)()
    context.call(
        "tsolid_read_table", os.fsencode(path), byref(rows), byref(columns), byref(value)
    )
    numbers = array("d", value[: rows.value * columns.value])
    context.library.tsolid_release(context.handle, value)
    return rows.value, columns.value, numbers


def write_table(context, n_columns, rows, path):
    """A table, given row by row as numbers or rows of numbers, as dense MatrixMarket."""
    memory, n = _doubles(rows)
    context.call(
        "tsolid_write_table_market", n // n_columns, n_columns, memory, os.fsencode(path)
    )


class Bext(_Handle):
    """Bezier extraction as BEXT 2.0 has it."""

    _free = "tsolid_bext_free"

    @classmethod
    def read(cls, context, path):
        handle = c_void_p()
        context.call("tsolid_read_bext", os.fsencode(path), byref(handle))
        return cls(context, handle)

    def view(self):
        """The library's struct tsolid_bext_view; valid as long as this object."""
        view = header.BextView()
        self.library.tsolid_bext_get(self.handle, byref(view))
        return view


def write_bext(context, solid, path):
    context.call("tsolid_write_bext", solid.handle, os.fsencode(path))


def write_bext_sets(context, solid, path, regions=(), allow_unproved=False):
    """With regions as side sets; raises binding.Refused for a solid that is not proved valid."""
    options = header.BextOptions(len(regions), _region_structs(regions), bool(allow_unproved))
    context.call("tsolid_write_bext_sets", solid.handle, byref(options), os.fsencode(path))


def write_extraction(context, solid, path):
    """Extraction operators as one plain binary file."""
    context.call("tsolid_write_extraction", solid.handle, os.fsencode(path))


def write_vtu_fields(context, solid, path, fields):
    """fields: {name: coefficients}, one number or a row of three per function of the solid."""
    n, keep = solid.space.n_functions, []
    structs = (header.FieldStruct * max(1, len(fields)))()
    for struct, (name, coefficients) in zip(structs, fields.items()):
        memory, count = _doubles(coefficients)
        if count not in (n, 3 * n):
            raise ValueError("field %s: %d numbers for %d functions" % (name, count, n))
        keep.append(memory)
        struct.name, struct.n_components = name.encode("utf-8"), count // n
        struct.coefficient = cast(memory, POINTER(c_double))
    path = os.fsencode(path)
    context.call("tsolid_write_vtu_fields", solid.handle, len(fields), structs, path)
