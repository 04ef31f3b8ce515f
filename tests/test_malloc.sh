#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# Every allocation fails once, whoever asks for it: the command, the library, the C library, cJSON,
# CXSparse, liblbfgs, OpenMP. Then: a status and a message and nothing written, or the full result;
# never a crash. Quick: every STRIDE-th allocation of the longer runs; long_malloc.sh: all.
. "${TSOLID_SOURCE_DIR:?}/tests/check.sh"
stride=${TSOLID_TEST_STRIDE:-13}
: "${TSOLID_COMMAND:?}" "${TSOLID_FAILING_MALLOC:?}"
part=$TSOLID_SOURCE_DIR/resources/examples/box.tsb
solid=$work/box.tsolid

# with_failure K COMMAND...: runs it with allocation K failing; K = 0: none. LD_PRELOAD is a list
# with blanks: a name that is looked up, not a path.
with_failure() {
  k=$1
  shift
  env LD_PRELOAD="$(basename "$TSOLID_FAILING_MALLOC")" \
    LD_LIBRARY_PATH="$(dirname "$TSOLID_FAILING_MALLOC")" TSOLID_FAIL_AT="$k" \
    TSOLID_FAIL_COUNT="$work/count" "$@"
}

# Nothing but the result, and that whole; or a message and nothing at all.
judge() { # exit code, directory, reference file or ""
  case $1 in
    0) [ -z "$3" ] || { cmp "$2/out" "$3" && [ "$(ls -A "$2")" = out ]; } ;;
    1) [ -s "$work/errors" ] && [ -z "$(ls -A "$2")" ] ;;
    *) return 1 ;;
  esac
}

# every STEP REFERENCE COMMAND...: the command writes $into/out when it has a reference.
every() {
  step=$1
  reference=$2
  shift 2
  into=$work/into
  rm -rf "$into"
  mkdir "$into"
  with_failure 0 "$@" >"$work/output" 2>"$work/errors"
  check "without a failure" judge $? "$into" "$reference"
  n=$(cat "$work/count")
  check "counts allocations" test "$n" -gt 50
  fails=0
  k=1
  while [ "$k" -le "$n" ]; do
    rm -rf "$into"
    mkdir "$into"
    with_failure "$k" "$@" >"$work/output" 2>"$work/errors"
    code=$?
    [ "$code" -eq 0 ] || fails=$((fails + 1))
    check "allocation $k of $n, exit code $code" judge "$code" "$into" "$reference"
    k=$((k + step))
  done
  check "the failures arrive" test "$((2 * fails * step))" -gt "$n"
}

set -- --threads 1
check "build" "$TSOLID_COMMAND" build "$@" --effort none "$part" -o "$solid"
check "export" "$TSOLID_COMMAND" export "$solid" --vtu "$work/box.vtu"
into=$work/into
every 1 "" "$TSOLID_COMMAND" check "$part"
every 1 "$work/box.vtu" "$TSOLID_COMMAND" export "$solid" --vtu "$into/out"
every "$stride" "" "$TSOLID_COMMAND" report "$solid"
every "$stride" "$solid" "$TSOLID_COMMAND" build "$@" --effort none "$part" -o "$into/out"
check "build, improved" "$TSOLID_COMMAND" build "$@" --effort quick "$part" -o "$work/quick"
every "$((4 * stride))" "$work/quick" \
  "$TSOLID_COMMAND" build "$@" --effort quick "$part" -o "$into/out"
check_done
