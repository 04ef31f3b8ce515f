# SPDX-License-Identifier: LGPL-2.1-or-later
# Counting checks for the shell tests; to be sourced. The environment is set by ctest
# (tests/CMakeLists.txt). `work` is an empty directory with a blank in its name, removed at the end.
# shellcheck shell=sh
set -u
: "${TSOLID_SOURCE_DIR:?run this through ctest, e.g. sh tests/run.sh -R NAME}"
: "${TSOLID_BUILD_DIR:?}"
passed=0
failed=0
check_base=$(mktemp -d) || exit 1
trap 'rm -rf "$check_base"' EXIT
trap 'exit 130' INT TERM
work="$check_base/with blank"
mkdir "$work"

# check TEXT COMMAND...: the command must succeed; what it prints is shown when it does not.
check() {
  check_text=$1
  shift
  if "$@" >"$check_base/output" 2>&1; then
    passed=$((passed + 1))
  else
    failed=$((failed + 1))
    echo "failed: $check_text: $*" >&2
    tail -n 60 "$check_base/output" >&2
  fi
}

# check_fails TEXT COMMAND...: the command must fail, by an exit code and not by a signal.
check_fails() {
  check_text=$1
  shift
  "$@" >"$check_base/output" 2>&1
  check_code=$?
  if [ "$check_code" -ge 1 ] && [ "$check_code" -lt 126 ]; then
    passed=$((passed + 1))
  else
    failed=$((failed + 1))
    echo "failed: $check_text: exit code $check_code from: $*" >&2
    tail -n 60 "$check_base/output" >&2
  fi
}

check_done() {
  echo "$passed passed, $failed failed"
  [ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
  exit $?
}
