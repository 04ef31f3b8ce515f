# SPDX-License-Identifier: LGPL-2.1-or-later
"""The example parts as NURBS patches; see make_examples.py."""
