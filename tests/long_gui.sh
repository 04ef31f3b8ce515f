#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# The window's tests (test_gui.py) in FreeCAD 1.0 and 1.1, as Debian 13 and its testing have them, in
# folders made by mmdebstrap; the library is built there. Needs root, mmdebstrap and the network.
# TSOLID_TEST_ROOTS=DIRECTORY takes (or keeps) the folders DIRECTORY/trixie and DIRECTORY/forky.
. "${TSOLID_SOURCE_DIR:?}/tests/check.sh"

if [ "$(id -u)" != 0 ] || ! command -v mmdebstrap >/dev/null 2>&1; then
  echo "skipped: needs root and mmdebstrap"
  exit 77
fi
roots=${TSOLID_TEST_ROOTS:-$check_base}
packages=freecad,xvfb,xauth,python3-numpy,python3-matplotlib,libgl1-mesa-dri,gcc,libc6-dev,cmake
packages=$packages,ninja-build,libcjson-dev,libsuitesparse-dev,liblbfgs-dev,zlib1g-dev,python3-vtk9

# make_root RELEASE PACKAGE...
make_root() {
  [ -x "$roots/$1/usr/bin/freecad" ] && return 0
  mmdebstrap --variant=apt --aptopt='Acquire::Check-Valid-Until "false"' \
    --aptopt='Acquire::Check-Date "false"' --include="$packages,$2" "$1" "$roots/$1" \
    http://deb.debian.org/debian
}

# What is run inside: build, and the window's tests.
cat >"$check_base/inside.sh" <<'END'
set -e
cd /root
cmake -G Ninja -S tsolid -B build -DTSOLID_TESTS=OFF
ninja -C build tsolid
cd tsolid/tests
TSOLID_BUILD_DIR=/root/build python3 test_gui.py
END

# The mounts end with the name space that they are in, whatever happens.
run_inside() {
  rm -rf "$roots/$1/root/tsolid"
  mkdir -p "$roots/$1/root/tsolid"
  (cd "$TSOLID_SOURCE_DIR" && cp -r CMakeLists.txt LICENSE README.md package.xml freecad_workbench \
    libtsolid resources tests "$roots/$1/root/tsolid") || return 1
  cp "$check_base/inside.sh" "$roots/$1/root/"
  unshare --mount --propagation private sh -c \
    'mount --bind /proc "$1/proc" && mount --rbind /dev "$1/dev" &&
     exec chroot "$1" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 \
       sh /root/inside.sh' - "$roots/$1"
}

for pair in trixie:python3-pyside2.qttest forky:python3-pyside6.qttest; do
  release=${pair%%:*}
  check "a folder with Debian $release" make_root "$release" "${pair#*:}"
  check "the window's tests on Debian $release" run_inside "$release"
done
check_done
