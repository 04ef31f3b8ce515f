#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# What the shared library shows and takes: exports tsolid_* only; of SuiteSparse takes CXSparse
# (LGPL) only, never the GPL parts; is linked with what it uses and nothing else; never ends the
# process, prints, or reads the environment or the locale.
. "${TSOLID_SOURCE_DIR:?}/tests/check.sh"
nm -D --defined-only "$TSOLID_LIBRARY" | awk '{print $3}' >"$work/exported"
nm -D --undefined-only "$TSOLID_LIBRARY" | awk '{print $2}' | sed 's/@.*//' >"$work/imported"
objdump -p "$TSOLID_LIBRARY" | awk '$1 == "NEEDED" {print $2}' | sort >"$work/needed"
objdump -p "$TSOLID_LIBRARY" | awk '$1 == "SONAME" {print $2}' >"$work/soname"
abi=$(sed -n 's/^#define TSOLID_ABI //p' "$TSOLID_SOURCE_DIR/libtsolid/include/tsolid.h")

none() { ! grep -E "$1" "$2"; }

check "exports something" grep -qx tsolid_version "$work/exported"
check "exports tsolid_* only" none '^([^t]|t[^s]|ts[^o]|tso[^l]|tsol[^i]|tsoli[^d]|tsolid[^_])' \
  "$work/exported"
check "no GPL part of SuiteSparse" none \
  '^(cholmod|umfpack|SuiteSparseQR|spqr|klu|btf|amd|camd|colamd|ccolamd|ldl|rbio|GrB)_' \
  "$work/imported"
check "imports of CXSparse" grep -q '^cs_' "$work/imported"
check "never ends the process" none '^(abort|exit|_exit|quick_exit|raise|kill|__assert_fail)$' \
  "$work/imported"
check "never prints" none '^(printf|puts|putchar|perror|stdout|stderr|__printf_chk)$' \
  "$work/imported"
check "reads no environment" none '^(getenv|secure_getenv|setenv|putenv|environ)$' "$work/imported"
check "sets no locale and no signal" none '^(setlocale|signal|sigaction)$' "$work/imported"
check "SONAME" grep -qx "libtsolid.so.$abi" "$work/soname"

# Exactly these, by name without version.
sed 's/\.so.*//' "$work/needed" | grep -v '^ld-linux' >"$work/needed_names"
printf '%s\n' libc libcjson libcxsparse libgomp liblbfgs libm libz | sort >"$work/wanted_names"
check "linked with what it uses" diff "$work/wanted_names" "$work/needed_names"
LC_ALL=C ldd -u "$TSOLID_LIBRARY" >"$work/unused" 2>&1
check "no unused library" none '/' "$work/unused"
check_done
