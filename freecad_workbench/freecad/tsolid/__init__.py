# SPDX-License-Identifier: LGPL-2.1-or-later
"""tsolid for FreeCAD: hex blocks with watertight, conformal borders from a part's spline faces.

    import freecad.tsolid as ts
    result = ts.check(shape)      # can it become a solid, and where not?
    result = ts.build(shape)      # build it, prove it, measure it

The functions, one per button, with an example each: actions.py. Only these need FreeCAD; header,
library and binding do not.
"""

_API = {
    "check": "actions",
    "check_assembly": "actions",
    "build_assembly": "actions",
    "build": "actions",
    "rebuild": "actions",
    "report": "actions",
    "look_inside": "actions",
    "export": "actions",
    "example_names": "actions",
    "open_example": "actions",
    "Options": "api",
    "CheckResult": "api",
    "BuildResult": "api",
    "create": "document",
    "hex_mesh": "fem",
    "mesh_with_hex_blocks": "fem",
    "hex_mesh_of_assembly": "fem",
    "mesh_of_assembly": "fem",
    "mesh_anew": "fem",
}

__all__ = sorted(_API)


def __getattr__(name):
    if name not in _API:
        raise AttributeError("module %r has no attribute %r" % (__name__, name))
    import importlib

    return getattr(importlib.import_module("." + _API[name], __name__), name)
