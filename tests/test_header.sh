#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# The public header stands alone, in C11 and in C++; its functions have C linkage; every function
# that it declares is exported by the library.
. "${TSOLID_SOURCE_DIR:?}/tests/check.sh"
header=$TSOLID_SOURCE_DIR/libtsolid/include
strict="-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror"

cat >"$work/alone.c" <<'END'
#include <tsolid.h>
#include <tsolid.h>
int main(void) { return tsolid_abi() == TSOLID_ABI ? 0 : 1; }
END
cp "$work/alone.c" "$work/alone.cpp"
library=$(dirname "$TSOLID_LIBRARY")
for compiler in "gcc -std=c11" "clang -std=c11" "gcc -std=c2x"; do
  check "$compiler" $compiler $strict -I "$header" -c "$work/alone.c" -o "$work/alone.o"
done
for standard in c++11 c++17 c++20; do
  check "g++ $standard" g++ -std=$standard $strict -Wold-style-cast -I "$header" \
    "$work/alone.cpp" -o "$work/alone" -L "$library" -ltsolid
  check "run $standard" env LD_LIBRARY_PATH="$library" "$work/alone"
done

# Declared = exported. The preprocessor drops comments and macros.
gcc -E -P -I "$header" "$work/alone.c" | tr '\n' ' ' | grep -o 'tsolid_[a-z0-9_]* *(' |
  grep -v '_fn' | tr -d ' (' | grep -v '^tsolid_abi$' | sort -u >"$work/declared"
echo tsolid_abi >>"$work/declared"
sort -o "$work/declared" "$work/declared"
nm -D --defined-only "$TSOLID_LIBRARY" | awk '{print $3}' | sort >"$work/exported"
check "more than 40 functions found" test "$(wc -l <"$work/declared")" -gt 40
check "declared = exported" diff "$work/declared" "$work/exported"
check_done
