# SPDX-License-Identifier: LGPL-2.1-or-later
"""Inside FreeCADCmd: a .tsm imported and checked; prints the notes kept and what is found."""
import os
import sys

import binding_parts

binding_parts.join_freecad()
import FreeCAD  # noqa: E402
from freecad.tsolid import actions, api, files  # noqa: E402

if __name__ == "__main__":
    files.open(sys.argv[1])
    obj = FreeCAD.ActiveDocument.Objects[0]
    print("kept:", *getattr(obj, "Notes", ()))
    print("found:", *(f.text for f in api.check(obj).findings))
    print("by a button:", *(f.text for f in actions.Job("check", obj).run().result.findings),
          flush=True)
    os._exit(binding_parts.EXIT_BASE)
