#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# test_malloc.sh with every allocation of every run.
TSOLID_TEST_STRIDE=1
export TSOLID_TEST_STRIDE
exec sh "${TSOLID_SOURCE_DIR:?}/tests/test_malloc.sh"
