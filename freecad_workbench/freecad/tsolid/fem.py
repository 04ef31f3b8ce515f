# SPDX-License-Identifier: LGPL-2.1-or-later
"""Hex blocks: conforming hexahedra of a solid for FreeCAD's FEM workbench and CalculiX.

    import freecad.tsolid as ts
    result = ts.build(App.ActiveDocument.Box)
    mesh = ts.hex_mesh(result, size=2.0, order=2)       # analysis.HexMesh: nodes, elements, regions
    mesh.write_inp(binding.Context(), "box.inp")
    obj = ts.mesh_with_hex_blocks(App.ActiveDocument.SolidTSpline, size=2.0)

Groups of the mesh are called as the part's faces are: Face1, Face2, ...
"""

from . import analysis, binding, document

# FreeCAD's order of the nodes of a hexahedron, from that of Abaqus; see feminout/importInpMesh.
_FREECAD_ORDER = (5, 6, 7, 4, 1, 2, 3, 0, 13, 14, 15, 12, 9, 10, 11, 8, 17, 18, 19, 16)
# Corners of S1..S6 and, from 4 on, the mids between them, in the order of Abaqus; outward normals.
_FACES = (
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


def regions_of(report):
    """(name, side, box) of every face of the part, from the report; () without faces."""
    return tuple((row["face"], row["side"], row["box"]) for row in report["exactness"])


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


def fem_mesh(mesh):
    """The hexahedra as Fem.FemMesh, with a group of faces and one of nodes per region."""
    import Fem

    out = Fem.FemMesh()
    for k, point in enumerate(mesh.nodes.tolist()):
        out.addNode(point[0], point[1], point[2], k + 1)
    elements = mesh.elements.tolist()
    width = len(elements[0])
    order = _FREECAD_ORDER[:width]
    for k, nodes in enumerate(elements):
        out.addVolume([nodes[m] + 1 for m in order], k + 1)
    n_corners = 8 if width == 20 else 4
    number = len(elements)
    for name, faces in mesh.regions.items():
        ids, touched = [], set()
        for element, face in faces.tolist():
            nodes = [elements[element][m] + 1 for m in _FACES[face][:n_corners]]
            number += 1
            out.addFace(nodes, number)
            ids.append(number)
            touched.update(nodes)
        out.addGroupElements(out.addGroup(name, "Face"), ids)
        out.addGroupElements(out.addGroup(name + "_nodes", "Node"), sorted(touched))
    return out


# ---- in the document -------------------------------------------------------------------------


def mesh_with_hex_blocks(solid, size=0.0, order=1, grading=1.0, container=None):
    """A FemMeshObject of a SolidTSpline object, in its document and, if given, in an analysis."""
    fem = solid.Document.addObject("Fem::FemMeshObject", solid.Name + "_HexBlocks")
    fem.Label = solid.Label + " hex blocks"
    for kind, name, group, description in _PROPERTIES:
        fem.addProperty(kind, name, group, description)
    fem.Solid, fem.Size, fem.Order, fem.Grading = solid, size, order, grading
    remesh(fem)
    if container is not None:
        container.addObject(fem)
    return fem


def remesh(fem, progress=None):
    """Meshes anew with the object's options; nothing changes when that is refused."""
    size = fem.Size.Value if hasattr(fem.Size, "Value") else float(fem.Size)
    mesh = hex_mesh(fem.Solid, progress, size=size, order=fem.Order, grading=fem.Grading)
    fem.FemMesh = fem_mesh(mesh)
    fem.MadeFrom = _check_sum(fem.Solid)
    return mesh


def is_out_of_date(fem):
    """The solid was rebuilt after it was meshed."""
    return fem.MadeFrom != _check_sum(fem.Solid)


def is_hex_blocks(obj):
    return getattr(obj, "TypeId", "") == "Fem::FemMeshObject" and "MadeFrom" in obj.PropertiesList


def _check_sum(solid):
    import hashlib

    return hashlib.sha256(document.tsolid_of(solid) or b"").hexdigest()
