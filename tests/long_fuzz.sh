#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# The readers under mutated files for minutes, sanitized: our own mutations from three seeds, then
# clang's coverage-guided ones.
. "${TSOLID_SOURCE_DIR:?}/tests/check.sh"
build=$TSOLID_BUILD_DIR/fuzz
flags="-g -O1 -std=c11 -fopenmp -fsanitize=address,undefined -fno-sanitize-recover=all"
mkdir -p "$build"
cd "$TSOLID_SOURCE_DIR" || exit 1

# compile NAME FLAGS...
compile() {
  name=$1
  shift
  # shellcheck disable=SC2086
  clang $flags "$@" -I libtsolid/include -I libtsolid/src -I tests tests/test_fuzz_read.c \
    libtsolid/src/*.c -lcjson -lcxsparse -llbfgs -lz -lm -o "$build/$name"
}

check "compile" compile fuzz_read
for seed in 101 102 103; do
  check "10000 files from seed $seed" "$build/fuzz_read" 10000 $seed
done
check "compile for libFuzzer" compile fuzz_guided -fsanitize=fuzzer -DTSOLID_LIBFUZZER
mkdir "$work/corpus"
cp resources/examples/box.tsb resources/examples/wedge.tsb "$work/corpus"
check "coverage-guided for 5 minutes" "$build/fuzz_guided" -max_total_time=300 -max_len=20000 \
  -timeout=60 -rss_limit_mb=2048 -artifact_prefix="$build/" -print_final_stats=1 "$work/corpus"
check_done
