#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# The installed tree: complete, movable, and enough to build and run a user's program with
# pkg-config and with the CMake package; the build tree and the checkout are out of sight.
. "${TSOLID_SOURCE_DIR:?}/tests/check.sh"
example=$TSOLID_SOURCE_DIR/tests/install_example
version=$(sed -n 's/^#define TSOLID_VERSION "\(.*\)"/\1/p' \
  "$TSOLID_SOURCE_DIR/libtsolid/include/tsolid.h")
unset LD_LIBRARY_PATH PKG_CONFIG_PATH CMAKE_PREFIX_PATH PYTHONPATH

check "install" cmake --install "$TSOLID_BUILD_DIR" --prefix "$work/first"
mv "$work/first" "$work/installed"
installed=$work/installed
find "$installed" -name libtsolid.so -print >"$work/found"
check "one library" test "$(wc -l <"$work/found")" = 1
lib=$(dirname "$(head -n 1 "$work/found")")
check "header" test -f "$installed/include/tsolid.h"
check "only the public headers" test "$(find "$installed" -name '*.h' | wc -l)" = 3
check "the command's version" sh -c '"$1" --version | grep -F "$2"' - \
  "$installed/bin/tsolid" "$version"
check "the command uses the installed library" sh -c 'ldd "$1" | grep -F "$2"' - \
  "$installed/bin/tsolid" "$installed"
check "FreeCAD package" test -f \
  "$installed/share/freecad/Mod/tsolid/freecad_workbench/freecad/tsolid/__init__.py"
check "its version is the header's" grep -qF "<version>$version</version>" \
  "$installed/share/freecad/Mod/tsolid/package.xml"
check "no trace of the build's places" sh -c '! grep -rlF -e "$2" -e "$3" "$1"' - "$installed" \
  "$TSOLID_SOURCE_DIR" "$TSOLID_BUILD_DIR"

# pkg-config prints a blank in a path as "\ ".
PKG_CONFIG_PATH=$lib/pkgconfig
export PKG_CONFIG_PATH
check "pkg-config version" test "$(pkg-config --modversion tsolid)" = "$version"
eval "set -- $(pkg-config --cflags --libs tsolid)"
check "build by pkg-config" gcc -std=c11 -o "$work/by_pkg_config" "$example/example.c" "$@" -lm
check "run" env LD_LIBRARY_PATH="$lib" "$work/by_pkg_config"

check "configure by CMake" cmake -G Ninja -S "$example" -B "$work/cmake" \
  -DCMAKE_PREFIX_PATH="$installed" -DWANTED_VERSION="${version%.*}"
check "build by CMake" cmake --build "$work/cmake"
check "run" "$work/cmake/example"
check_fails "another version is refused" cmake -G Ninja -S "$example" -B "$work/other" \
  -DCMAKE_PREFIX_PATH="$installed" -DWANTED_VERSION=9.0
check_done
