# SPDX-License-Identifier: LGPL-2.1-or-later
"""Run by FreeCAD at its start, with or without a window: the file types and the unit tests."""

import FreeCAD

MODULE = "freecad.tsolid.files"

FreeCAD.addImportType("Solid T-spline (*.tsolid)", MODULE)
FreeCAD.addImportType("Boundary patches for tsolid (*.tsb)", MODULE)
FreeCAD.addImportType("T-spline surface (*.tsm)", MODULE)
FreeCAD.addImportType("Bezier elements of a surface (*.iga)", MODULE)
FreeCAD.addExportType("Solid T-spline (*.tsolid)", MODULE)
FreeCAD.addExportType("Boundary patches for tsolid (*.tsb)", MODULE)
FreeCAD.addExportType("Bezier hexahedra of a solid T-spline (*.vtu)", MODULE)

FreeCAD.__unit_test__ += ["freecad.tsolid.unit_tests"]
