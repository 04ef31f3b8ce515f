#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# Installs what is missing, builds, and runs the tests: the quick ones, with --all every one.
#   sh tests/run.sh [--all] [ctest options, e.g. -R NAME]
set -u
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd -P) || exit 1
. "$root/resources/setup.sh"

case ${1-} in
  -h | --help)
    sed -n '3,4s/^# //p' "$0"
    exit 0 ;;
  --all) shift ;;
  *) set -- -LE long "$@" ;;
esac

setup_need build freecad tests
setup_build || exit 1
cd "$root/build" && exec ctest -j "$(nproc)" --output-on-failure "$@"
