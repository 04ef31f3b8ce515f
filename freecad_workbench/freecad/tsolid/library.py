# SPDX-License-Identifier: LGPL-2.1-or-later
"""Find the tsolid library and vet it before the first call.

Searched in this order, and the first file that exists is taken or refused, never passed over:

1. the path given to load(), or the environment variable TSOLID_LIBRARY;
2. beside this package (in this directory or its lib/ subdirectory);
3. the path that the installation wrote into the text file library_path beside this module;
4. whatever the system loader finds.
"""

import ctypes
import ctypes.util
import os
import sys

from . import header

_HERE = os.path.dirname(os.path.abspath(__file__))


class LibraryError(Exception):
    """The library is missing or wrong; the text is one sentence for the user."""


def _file_names():
    if sys.platform == "win32":
        return ("tsolid.dll", "libtsolid.dll")
    if sys.platform == "darwin":
        return ("libtsolid.dylib", "libtsolid.%d.dylib" % header.ABI)
    return ("libtsolid.so.%d" % header.ABI, "libtsolid.so")


def _configured():
    try:
        with open(os.path.join(_HERE, "library_path"), encoding="utf-8") as stream:
            return stream.read().strip()
    except OSError:
        return ""


def _from_loader():
    for name in _file_names():
        try:
            return ctypes.CDLL(name), name
        except OSError:
            pass
    name = ctypes.util.find_library("tsolid")
    return (_open(name), name) if name else (None, None)


def _open(path):
    try:
        return ctypes.CDLL(path)
    except OSError as error:
        raise LibraryError("The tsolid library %s cannot be loaded: %s." % (path, error)) from None


def find(path=None):
    """The library as ctypes opened it, and its path; vetted by nobody yet."""
    path = path or os.environ.get("TSOLID_LIBRARY")
    if path:
        if not os.path.isfile(path):
            raise LibraryError("The tsolid library %s does not exist." % path)
        return _open(os.path.abspath(path)), os.path.abspath(path)
    candidates = [os.path.join(_HERE, d, n) for d in ("", "lib") for n in _file_names()]
    configured = _configured()
    if configured:
        candidates.append(os.path.join(_HERE, configured))
    for candidate in candidates:
        if os.path.isfile(candidate):
            return _open(candidate), candidate
    library, name = _from_loader()
    if library is None:
        raise LibraryError(
            "The tsolid library (%s) was not found: install it, or set TSOLID_LIBRARY to its path."
            % _file_names()[0]
        )
    return library, name


def _symbol(library, name, where):
    try:
        return getattr(library, name)
    except AttributeError:
        raise LibraryError(
            "%s is not a tsolid library of version %s: it has no %s."
            % (where, header.VERSION, name)
        ) from None


def declare(library, where):
    """Sets the prototypes of all functions, checking that each one exists."""
    for name, (result, arguments) in header.FUNCTIONS.items():
        function = _symbol(library, name, where)
        function.restype = result
        function.argtypes = arguments


def vet(library, where):
    """Raises LibraryError unless the ABI number and every struct's size are those of header.py."""
    abi = _symbol(library, "tsolid_abi", where)
    abi.restype, abi.argtypes = ctypes.c_int, []
    if abi() != header.ABI:
        raise LibraryError(
            "The tsolid library %s has ABI number %d, but this package needs %d: install matching "
            "versions." % (where, abi(), header.ABI)
        )
    declare(library, where)
    for name, struct in header.STRUCTS.items():
        size = library.tsolid_struct_size(name.encode())
        if size != ctypes.sizeof(struct):
            raise LibraryError(
                "The tsolid library %s has a %s of %d bytes, but this package expects %d: install "
                "matching versions." % (where, name, size, ctypes.sizeof(struct))
            )


_loaded = None


def load(path=None):
    """The vetted library; found once per process unless a path is given."""
    global _loaded
    if path is None and _loaded is not None:
        return _loaded
    library, where = find(path)
    vet(library, where)
    library.tsolid_path = where
    if path is None:
        _loaded = library
    return library
