/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Counting checks for the C tests: a failed check prints its place and the test goes on. */
#ifndef TSOLID_TEST_CHECK_H
#define TSOLID_TEST_CHECK_H

#include <math.h>
#include <stdio.h>

static long check_n_passed, check_n_failed;

#define CHECK(condition) check_that((condition) != 0, #condition, __FILE__, __LINE__)
#define CHECK_NEAR(a, b, tolerance)                                                                \
  check_near((a), (b), (tolerance), #a " = " #b, __FILE__, __LINE__)

static inline int check_that(int passed, const char *text, const char *file, int line) {
  if (passed) {
    check_n_passed++;
  } else if (check_n_failed++ < 50) {
    fprintf(stderr, "%s:%d: failed: %s\n", file, line, text);
  }
  return passed;
}

/* NaN on either side fails. */
static inline int check_near(double a, double b, double tolerance, const char *text,
                             const char *file, int line) {
  int passed = fabs(a - b) <= tolerance;
  if (!check_that(passed, text, file, line) && check_n_failed <= 50)
    fprintf(stderr, "    %.17g against %.17g, differ by %.3g, allowed %.3g\n", a, b, fabs(a - b),
            tolerance);
  return passed;
}

static inline int check_done(void) {
  printf("%ld passed, %ld failed\n", check_n_passed, check_n_failed);
  return check_n_failed != 0 || check_n_passed == 0;
}

#endif
