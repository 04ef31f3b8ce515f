#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# The C tests, and the command with bad input, once more: compiled by clang, under the address, leak
# and undefined behaviour sanitizers.
. "${TSOLID_SOURCE_DIR:?}/tests/check.sh"
build=$TSOLID_BUILD_DIR/sanitized
check "configure" cmake -G Ninja -S "$TSOLID_SOURCE_DIR" -B "$build" -DCMAKE_C_COMPILER=clang \
  -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTSOLID_SANITIZE=ON
check "build" cmake --build "$build" -- --quiet
[ "$failed" -eq 0 ] || check_done
cd "$build" || exit 1
check "C tests" ctest -j "$(nproc)" --output-on-failure --no-tests=error -L '^c$' -LE long
check "bad input" env TSOLID_COMMAND="$build/tsolid" \
  /usr/bin/python3 "$TSOLID_SOURCE_DIR/tests/test_bad_input.py"
check_done
