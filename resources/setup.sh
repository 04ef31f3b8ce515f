# SPDX-License-Identifier: LGPL-2.1-or-later
# Shell functions shared by resources/demo.sh and tests/run.sh; to be sourced by a POSIX shell.
# The caller sets `root` to the absolute path of the checkout.
# shellcheck shell=sh

# setup_list SECTION...: the lines "package use use ..." of these sections, without comments.
setup_list() {
  awk -v wanted=" $* " '
    { sub(/#.*/, "") }
    /^\[/ { section = $0; gsub(/[][ \t]/, "", section); next }
    NF && index(wanted, " " section " ") { $1 = $1; print }' "$root/resources/packages.txt"
}

setup_missing_packages() {
  setup_list "$@" | while read -r package rest; do
    state=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) || state=none
    [ "$state" = installed ] || echo "$package"
  done
}

# Compiles the source text on stdin with the options given; true when that works.
setup_compiles() {
  compiler=$1
  shift
  "$compiler" -x c - -o /dev/null "$@" >/dev/null 2>&1
}

# True when the use (see packages.txt) is there.
setup_works() {
  kind=${1%%:*}
  name=${1#*:}
  case $kind in
    command) command -v "$name" >/dev/null 2>&1 ;;
    header) echo "#include <$name>" | setup_compiles gcc -fsyntax-only ;;
    library)
      case $name in
        *:*) echo 'int main(void) { return 0; }' | setup_compiles "${name#*:}" "-l${name%%:*}" ;;
        *) echo 'int main(void) { return 0; }' | setup_compiles gcc "-l$name" ;;
      esac ;;
    python) /usr/bin/python3 -c "import $name" >/dev/null 2>&1 ;;
    locale) locale -a 2>/dev/null | grep -qix "$name" ;;
    *) return 1 ;;
  esac
}

setup_missing_uses() {
  setup_list "$@" | while read -r package uses; do
    for use in $uses; do
      setup_works "$use" || echo "$use (Debian package $package)"
    done
  done
}

# As root, directly; else through sudo, which may ask for a password only at a terminal.
setup_as_root() {
  if [ "$(id -u)" = 0 ]; then
    "$@"
  elif [ -t 0 ]; then
    sudo "$@"
  else
    sudo -n "$@"
  fi
}

setup_apt() {
  command -v apt-get >/dev/null 2>&1 || return 1
  [ "$(id -u)" = 0 ] || command -v sudo >/dev/null 2>&1 || return 1
  echo "Installing: $*" >&2
  setup_as_root apt-get -q -o DPkg::Lock::Timeout=300 update >&2 ||
    echo "apt-get update failed; trying with the package lists that are here" >&2
  setup_as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 \
    install --no-install-recommends "$@" >&2
}

# setup_need SECTION...: installs what is missing, or names it and leaves with 1. Asks neither apt
# nor the network when everything is there.
setup_need() {
  if command -v dpkg-query >/dev/null 2>&1; then
    packages=$(setup_missing_packages "$@")
    [ -n "$packages" ] || return 0
    # shellcheck disable=SC2086
    if setup_apt $packages; then
      return 0
    fi
  fi
  uses=$(setup_missing_uses "$@")
  [ -n "$uses" ] || return 0
  {
    echo "Missing, and not to be installed from here (that takes apt and root or sudo):"
    echo "$uses" | sed 's/^/  /'
  } >&2
  exit 1
}

# setup_build TARGET...: configures and builds in $root/build; without a target, everything. A build
# directory that was made for a checkout elsewhere (a copied folder) is made anew.
setup_build() {
  build=$root/build
  if [ -f "$build/CMakeCache.txt" ] &&
    ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$build/CMakeCache.txt"; then
    rm -rf "$build"
  fi
  cmake -G Ninja -S "$root" -B "$build" -DCMAKE_C_COMPILER=gcc -DCMAKE_BUILD_TYPE=Release \
    >/dev/null || return 1
  echo "Building in $build"
  cmake --build "$build" ${1:+--target} "$@" -- --quiet
}
