# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs inside FreeCADCmd: freecad_facts.py WHAT ANSWER.json FILE... answers one question."""

import json
import os
import sys

import binding_parts

binding_parts.join_freecad()

import FreeCAD  # noqa: E402
import Part  # noqa: E402

from freecad.tsolid import api, document  # noqa: E402


def of_document(path):
    """What a reopened document holds."""
    (obj,) = (o for o in FreeCAD.openDocument(path).Objects if document.is_solid_tspline(o))
    return {
        "label": obj.Label,
        "report": document.report_of(obj),
        "tsolid": document.tsolid_of(obj).hex(),
        "closed": obj.Shape.isClosed(),
        "valid": obj.Shape.isValid(),
        "type": obj.Shape.ShapeType,
        "faces": len(obj.Shape.Faces),
    }


def of_conformity(step, tsolid):
    """The faces of a STEP file against a .tsolid file alone."""
    shape = Part.Shape()
    shape.read(step)
    with open(tsolid, "rb") as stream:
        rows, same = api.verify(shape, stream.read())
    return {"rows": rows, "same": same}


if __name__ == "__main__":
    what, answer = sys.argv[1:3]
    facts = {"document": of_document, "conformity": of_conformity}[what](*sys.argv[3:])
    with open(answer, "w", encoding="utf-8") as stream:
        json.dump(facts, stream)
    os._exit(binding_parts.EXIT_BASE)
