# SPDX-License-Identifier: LGPL-2.1-or-later
"""Several parts: what touches what, gaps, clashes. No FreeCAD import, as in binding.py."""

import ctypes
import os
from ctypes import byref, c_char_p, c_double, c_void_p

from . import header
from .binding import Boundary, BoundaryFile, Patch, _Handle, _PatchInput, as_dict


class Assembly(_Handle):
    """Contacts and clashes of several parts; see tsolid_assembly_create."""

    _free = "tsolid_assembly_free"

    @classmethod
    def create(cls, context, parts, tolerance=0.0, gap=0.0):
        """parts: (name, source) or (name, source, placement) each. source: Patch objects, a .tsb
        path, a BoundaryFile or a Surface; parts with the very same source object are copies of
        one. placement: twelve numbers, the rows of a 3 x 4 matrix."""
        parts = [tuple(part) + (None,) * (3 - len(part)) for part in parts]
        structs = (header.PartStruct * max(1, len(parts)))()
        inputs, keep = {}, []
        for struct, (name, source, placement) in zip(structs, parts):
            if id(source) not in inputs:
                inputs[id(source)] = _assembly_input(context, source, keep)
            struct.name = name.encode() or None
            struct.boundary = ctypes.pointer(inputs[id(source)])
            if placement is not None:
                if len(placement) != 12:
                    raise ValueError("%s: a placement has twelve numbers" % name)
                struct.placement = Patch._array(placement, keep)
        context.name_by(())
        handle = c_void_p()
        given = header.AssemblyInput(len(parts), structs)
        options = header.AssemblyOptions(tolerance, gap)
        context.call("tsolid_assembly_create", byref(given), byref(options), byref(handle))
        made = cls(context, handle)
        made._tolerance = tolerance
        made._keep = []
        return made

    @property
    def view(self):
        """The AssemblyView; valid as long as this object."""
        view = header.AssemblyView()
        self.library.tsolid_assembly_get(self.handle, byref(view))
        return view

    @property
    def verdict(self):
        return header.AssemblyVerdict(self.view.verdict)

    @property
    def interfaces(self):
        """Copies of the contacts as dictionaries, as in the report's names."""
        view = self.view
        return [as_dict(view.interface[k]) for k in range(view.n_interfaces)]

    @property
    def clashes(self):
        view = self.view
        return [as_dict(view.clash[k]) for k in range(view.n_clashes)]

    @property
    def free_faces(self):
        view = self.view
        return [as_dict(view.free_face[k]) for k in range(view.n_free)]

    def is_prepared(self, part):
        """Whether a part's boundary is another than that of its source."""
        return bool(self.library.tsolid_assembly_boundary_input(self.handle, part))

    def boundary(self, context, part, source=None):
        """The boundary of a part, made ready for its contacts; of the part's own source (as given
        to create) where it cannot be."""
        given = self.library.tsolid_assembly_boundary_input(self.handle, part)
        if not given:
            given = ctypes.pointer(_assembly_input(context, source, self._keep))
        options = (self._tolerance, 0, 0)
        return Boundary._create(context, given.contents, options, given.contents.n_patches)

    def joined(self, context, solids):
        """The assembly after the construction: a Solid per part, the same object for copies, None
        for parts that could not be done."""
        handles = (c_void_p * max(1, len(solids)))(*[s.handle if s else None for s in solids])
        handle = c_void_p()
        context.call("tsolid_assembly_join", self.handle, len(solids), handles, byref(handle))
        return type(self)(context, handle)

    def evaluate(self, context, interface, side, p, q):
        """A contact's point by its record, from the parameters in [0,1]^2 of one side's patch."""
        point = (c_double * 3)()
        context.call("tsolid_assembly_evaluate", self.handle, interface, side, p, q, point)
        return tuple(point)

    def json(self, context):
        """The assembly's report as a JSON document, with the context's findings."""
        text = c_char_p()
        context.call("tsolid_assembly_json", self.handle, byref(text))
        try:
            return text.value.decode()
        finally:
            self.library.tsolid_release(context.handle, text)


def _assembly_input(context, source, keep):
    """A BoundaryInput of any source; what it points to is kept in keep."""
    keep.append(source)
    if isinstance(source, (str, bytes, os.PathLike)):
        source = BoundaryFile.read(context, source)
        keep.append(source)
    if isinstance(source, BoundaryFile):
        return source.input
    if isinstance(source, _Handle):
        return header.BoundaryInput(0, None, None, source.handle)
    holder = _PatchInput(list(source))
    keep.append(holder)
    return holder.input
