#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# Installs what is missing, builds, and turns a part into a solid T-spline through FreeCAD.
#   sh resources/demo.sh [FILE]    a STEP file of your own; without, the example propeller blade
set -u
case ${1-} in
  -h | --help)
    sed -n '3,4s/^# //p' "$0"
    exit 0 ;;
esac
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd -P) || exit 1
. "$root/resources/setup.sh"
setup_need build freecad
setup_build tsolid tsolid_command || exit 1

out=$root/build/demo
mkdir -p "$out" || exit 1
part=${1-}
if [ -z "$part" ]; then
  part=$out/propeller_blade.step
  /usr/bin/python3 "$root/resources/make_examples.py" --out "$out" --part propeller_blade --step \
    >"$out/example.log" 2>&1 || {
    cat "$out/example.log" >&2
    exit 1
  }
fi
TSOLID_LIBRARY=$root/build/libtsolid.so
export TSOLID_LIBRARY
echo "Building the solid of $part"
sh "$root/freecad_workbench/bin/tsolid-freecad" build --out "$out" "$part"
code=$?
if [ "$code" -ne 1 ] && [ "$code" -ne 130 ]; then
  echo "Open $out/report.html in a browser, the .FCStd in FreeCAD, the .vtu in ParaView."
fi
exit "$code"
