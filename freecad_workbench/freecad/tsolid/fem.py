# SPDX-License-Identifier: LGPL-2.1-or-later
"""Hex blocks: conforming hexahedra of a solid for FreeCAD's FEM workbench and CalculiX.

    import freecad.tsolid as ts
    result = ts.build(App.ActiveDocument.Box)
    mesh = ts.hex_mesh(result, size=2.0, order=2)       # analysis.HexMesh: nodes, elements, regions
    mesh.write_inp(binding.Context(), "box.inp")
    obj = ts.mesh_with_hex_blocks(App.ActiveDocument.SolidTSpline, size=2.0)

Groups of the mesh are called as the part's faces are: Face1, Face2, ...
"""

import hashlib
import shutil

import FreeCAD

from . import actions, analysis, api, binding, document

# FreeCAD's order of the nodes of a hexahedron, from that of Abaqus; see feminout/importInpMesh.
_FREECAD_ORDER = (5, 6, 7, 4, 1, 2, 3, 0, 13, 14, 15, 12, 9, 10, 11, 8, 17, 18, 19, 16)
# Corners of S1..S6 and, from 4 on, the mids between them, in the order of Abaqus; outward normals.
FACES = (
    (0, 3, 2, 1, 11, 10, 9, 8),
    (4, 5, 6, 7, 12, 13, 14, 15),
    (0, 1, 5, 4, 8, 17, 12, 16),
    (1, 2, 6, 5, 9, 18, 13, 17),
    (2, 3, 7, 6, 10, 19, 14, 18),
    (3, 0, 4, 7, 11, 16, 15, 19),
)

_PROPERTIES = (
    ("App::PropertyLink", "Solid", "Hex blocks", "The SolidTSpline that is meshed"),
    ("App::PropertyLength", "Size", "Hex blocks", "Wanted edge length; 0: a 20th of the part"),
    ("App::PropertyInteger", "Order", "Hex blocks", "1: 8 nodes per element, 2: 20 nodes"),
    ("App::PropertyFloat", "Grading", "Hex blocks", "Outermost layer's thickness over innermost"),
    ("App::PropertyString", "MadeFrom", "Hex blocks", "Check sum of the solid that was meshed"),
)


DEFAULTS = {"size": 0.0, "order": 1, "grading": 1.0}


def regions_of(report):
    """(name, side, box) of every piece of the part's faces, from the report; () without faces.

    Pieces of one name become one region of the mesh.
    """
    return tuple(
        (row["face"], piece["side"], piece["box"])
        for row in (report["exactness"] if report else ())
        for piece in pieces_of(row)
    )


def pieces_of(row):
    """Where a face lies: reports of older documents know one place only."""
    return row.get("pieces") or [{"side": row["side"], "box": row["box"]}]


def hex_mesh(given, progress=None, **options):
    """Hexahedra of a BuildResult or a SolidTSpline object; options: see analysis.HexMesh.create.

    Raises binding.Refused: the solid is not proved valid, a hexahedron folds, or too many.
    """
    context = binding.Context(progress)
    if document.is_solid_tspline(given):
        solid, report = document.solid_of(given, context), document.report_of(given)
    else:
        solid, report = given.solid, given.report
    if solid is None:
        raise ValueError("there is no solid to mesh: build it first")
    return analysis.HexMesh.create(context, solid, regions=regions_of(report), **options)


def hex_mesh_of_assembly(result, progress=None, **options):
    """One analysis.HexMesh of all parts of a built assemblies.AssemblyResult, in their places;
    parts share their nodes where they touch. options: see HexMesh.of_assembly."""
    if result.joined is None:
        raise ValueError("there are no solids to mesh: build the assembly first")
    regions = [regions_of(result.built[part.first].report) for part in result.parts]
    return analysis.HexMesh.of_assembly(
        binding.Context(progress), result.joined, result.made, regions=regions, **options)


def mesh_of_assembly(result, size=0.0, order=1, container=None, progress=None, **options):
    """A FemMeshObject of all parts of a built assembly, in an analysis or the active document:
    a group of volumes per part, groups of faces and nodes called PART_FACE. No tie is needed."""
    mesh = hex_mesh_of_assembly(result, progress, size=float(size), order=order, **options)
    doc = container.Document if container is not None else FreeCAD.ActiveDocument
    if doc is None:
        raise ValueError("there is no document to put the mesh into")
    with actions.transaction(doc, "Mesh an assembly with hex blocks"):
        fem = doc.addObject("Fem::FemMeshObject", "Assembly_HexBlocks")
        fem.Label = result.name + " hex blocks"
        fem.FemMesh = fem_mesh(mesh)
        if container is not None:
            container.addObject(fem)
    return fem


def fem_mesh(mesh):
    """The hexahedra as Fem.FemMesh, with a group of faces and one of nodes per region, and one of
    volumes per part of an assembly."""
    import Fem

    out = Fem.FemMesh()
    for k, point in enumerate(mesh.nodes.tolist()):
        out.addNode(point[0], point[1], point[2], k + 1)
    elements = mesh.elements.tolist()
    width = len(elements[0])
    order = _FREECAD_ORDER[:width]
    for k, nodes in enumerate(elements):
        out.addVolume([nodes[m] + 1 for m in order], k + 1)
    for name, part in mesh.parts.items():
        out.addGroupElements(out.addGroup(name, "Volume"), [k + 1 for k in part])
    n_corners = 8 if width == 20 else 4
    number = len(elements)
    for name, faces in mesh.regions.items():
        ids, touched = [], set()
        for element, face in faces.tolist():
            nodes = [elements[element][m] + 1 for m in FACES[face][:n_corners]]
            number += 1
            out.addFace(nodes, number)
            ids.append(number)
            touched.update(nodes)
        out.addGroupElements(out.addGroup(name, "Face"), ids)
        out.addGroupElements(out.addGroup(name + "_nodes", "Node"), sorted(touched))
    return out


# ---- long work -------------------------------------------------------------------------------


class Meshed:
    """A mesh, the same for FreeCAD, and the check sum of the solid that it was made of."""

    def __init__(self, mesh, made_from):
        self.mesh, self.made_from = mesh, made_from
        self.fem_mesh = fem_mesh(mesh)


class MeshJob:
    """The hex blocks of one SolidTSpline, to be made in any thread; compare actions.Job."""

    def __init__(self, solid, options):
        self.given, self.options = solid, dict(DEFAULTS, **options)
        self.data = document.tsolid_of(solid)
        if self.data is None:
            raise ValueError("there is no solid to mesh: build %s first" % solid.Label)
        self.regions = regions_of(document.report_of(solid))
        self.result = None

    def fits(self, kind, given, options):
        return kind == "mesh" and self.given is given and self.options == options

    def run(self, progress=None):
        if self.result is None:
            context = binding.Context(progress)
            solid = api.read_tsolid(context, self.data)
            self.result = meshed(context, solid, self.regions, self.data, self.options)
        return self


def meshed(context, solid, regions, data, options):
    """Meshed of a solid whose .tsolid bytes are `data`."""
    mesh = analysis.HexMesh.create(context, solid, regions=regions, **options)
    return Meshed(mesh, _check_sum(data))


# ---- in the document -------------------------------------------------------------------------


def mesh_with_hex_blocks(solid, size=0.0, order=1, grading=1.0, container=None):
    """A FemMeshObject of a SolidTSpline object, in its document and, if given, in an analysis."""
    if not document.is_solid_tspline(solid):
        raise ValueError("%s is not a solid T-spline: build one first" % solid.Label)
    ready = _meshed_now(solid, {"size": float(size), "order": order, "grading": float(grading)})
    with actions.transaction(solid.Document, "Mesh with hex blocks"):
        fem = solid.Document.addObject("Fem::FemMeshObject", solid.Name + "_HexBlocks")
        fem.Label = solid.Label + " hex blocks"
        for kind, name, group, description in _PROPERTIES:
            fem.addProperty(kind, name, group, description)
        fem.setEditorMode("MadeFrom", 2)
        fem.Solid, fem.Size, fem.Order, fem.Grading = solid, size, order, grading
        put(fem, ready)
        if container is not None:
            container.addObject(fem)
    return fem


def mesh_anew(fem, progress=None, **options):
    """Meshes anew with the object's options, or with new ones; nothing changes when that is
    refused. Gives the analysis.HexMesh.

    Not a step of undo: FreeCAD's undo takes back all properties of a mesh but the mesh itself."""
    if fem.Solid is None:
        raise ValueError("the solid that %s was made of is gone" % fem.Label)
    options = dict(options_of(fem), **options)
    ready = _meshed_now(fem.Solid, options, progress)
    fem.Size, fem.Order, fem.Grading = (options[k] for k in ("size", "order", "grading"))
    put(fem, ready)
    return ready.mesh


def _meshed_now(solid, options, progress=None):
    found = actions.ready_result("mesh", solid, options)
    return MeshJob(solid, options).run(progress).result if found is None else found


def put(fem, ready):
    fem.FemMesh = ready.fem_mesh
    fem.MadeFrom = ready.made_from


def lacks(container):
    """What an analysis with hex blocks still needs before CalculiX can solve it, in sentences."""
    out = []
    kinds = [getattr(getattr(o, "Proxy", None), "Type", "") for o in container.Group]
    if not any(o.isDerivedFrom("App::MaterialObject") or kind.startswith("Fem::Material")
               for o, kind in zip(container.Group, kinds)):
        out.append("%s has no material: add one before solving." % container.Label)
    if not any(o.isDerivedFrom("Fem::FemSolverObject") for o in container.Group):
        out.append("%s has no solver: add CalculiX before solving." % container.Label)
    if not has_calculix():
        out.append(
            "CalculiX (ccx) was not found: install it, or set its path in FEM's preferences.")
    return out


def has_calculix():
    group = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Mod/Fem/Ccx")
    path = group.GetString("ccxBinaryPath", "")
    return shutil.which(path or "ccx") is not None


def options_of(fem):
    size = fem.Size.Value if hasattr(fem.Size, "Value") else float(fem.Size)
    return {"size": size, "order": fem.Order, "grading": fem.Grading}


def meshes_of(solid):
    """The hex blocks that were made of a SolidTSpline object."""
    return [o for o in solid.InList if is_hex_blocks(o)]


def is_out_of_date(fem):
    """The solid was rebuilt after it was meshed."""
    return fem.MadeFrom != _check_sum(document.tsolid_of(fem.Solid))


def is_hex_blocks(obj):
    return getattr(obj, "TypeId", "") == "Fem::FemMeshObject" and "MadeFrom" in obj.PropertiesList


def _check_sum(data):
    return hashlib.sha256(data or b"").hexdigest()
