# SPDX-License-Identifier: LGPL-2.1-or-later
"""Where the package's own files are."""

import os

_RESOURCES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "resources")
ICONS = os.path.join(_RESOURCES, "icons")
TRANSLATIONS = os.path.join(_RESOURCES, "translations")
EXAMPLES = os.path.join(_RESOURCES, "examples")


def resource(*names):
    return os.path.join(_RESOURCES, *names)


def icon(name):
    return os.path.join(ICONS, name + ".svg")
