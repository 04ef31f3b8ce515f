#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# How the source reads, as far as tools can tell: clang-format, flake8, licence lines, lengths.
. "${TSOLID_SOURCE_DIR:?}/tests/check.sh"
cd "$TSOLID_SOURCE_DIR" || exit 1

find libtsolid tests -name '*.[ch]' | sort >"$work/c"
find freecad_workbench resources tests -name '*.py' | sort >"$work/python"
find tests resources freecad_workbench -name '*.sh' | sort >"$work/shell"
check "C files found" grep -q context.c "$work/c"
check "Python files found" grep -q binding.py "$work/python"
check "clang-format" xargs -d '\n' clang-format --dry-run -Werror <"$work/c"
check "flake8" xargs -d '\n' /usr/bin/python3 -m flake8 <"$work/python"
cat "$work/c" "$work/python" "$work/shell" >"$work/all"
while read -r file; do
  head -n 3 "$file" >"$work/top"
  check "licence line of $file" grep -q "SPDX-License-Identifier: LGPL-2.1-or-later" "$work/top"
  check "$file has at most 900 lines" test "$(wc -l <"$file")" -le 900
done <"$work/all"
while read -r file; do
  check "shell syntax" sh -n "$file"
done <"$work/shell"
check_done
