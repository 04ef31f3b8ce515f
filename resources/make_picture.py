#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Builds the solid of a .tsb part and draws it, cut open: how the README's picture was made.

    TSOLID_LIBRARY=build/libtsolid.so make_picture.py PART.tsb PICTURE.png
"""

import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "freecad_workbench"))

from freecad.tsolid import binding, picture  # noqa: E402


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    context = binding.Context()
    boundary = binding.Boundary.from_file(context, sys.argv[1])
    space = binding.Space.create(context, boundary, binding.TMesh.create(context, boundary))
    solid = binding.Solid.create(context, space).optimised(context)
    picture.picture(sys.argv[2], solid, context=context, size=(1000, 700))


if __name__ == "__main__":
    main()
