/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Sources: W. Boehm, Inserting new knots into B-spline curves (1980); H. Prautzsch, Degree
 * elevation of B-spline curves (1984). */
#include "internal.h"

#include "bspline.h"

double tsi_knot_normalise(double low, double high, double knot) {
  double below = knot - low, above = high - knot;
  if (below == above)
    return 0.5;
  double x = (below < above ? below : above) / (high - low);
  return below < above ? 1.0 - (1.0 - x) : 1.0 - x;
}

void tsi_knots_normalise(int n_knots, const double *knots, double *normal) {
  double first = knots[0], last = knots[n_knots - 1];
  for (int i = 0; i < n_knots; i++)
    normal[i] = tsi_knot_normalise(first, last, knots[i]);
}

void tsi_knots_reverse(int n_knots, double *knots) {
  for (int i = 0, j = n_knots - 1; i <= j; i++, j--) {
    double low = knots[i], high = knots[j];
    knots[i] = 1.0 - high;
    knots[j] = 1.0 - low;
  }
}

int tsi_knots_raise(int degree, int n, const double *knots, double *raised) {
  int n_knots = n + degree + 1, k = 0;
  for (int i = 0; i < n_knots; i++) {
    if (raised)
      raised[k] = knots[i];
    k++;
    if (i + 1 == n_knots || knots[i + 1] != knots[i]) {
      if (raised)
        raised[k] = knots[i];
      k++;
    }
  }
  return k - (degree + 1) - 1;
}

int tsi_bspline_span(int degree, int n, const double *knots, double x) {
  if (x >= knots[n]) {
    int i = n - 1;
    while (i > degree && knots[i] == knots[i + 1])
      i--;
    return i;
  }
  int low = degree, high = n;
  while (high - low > 1) {
    int middle = low + (high - low) / 2;
    if (x < knots[middle])
      high = middle;
    else
      low = middle;
  }
  return low;
}

/* Functions of `degree` on span i at x; knots far enough on both sides. */
static void raise_basis(int degree, int i, const double *knots, double x, double *value) {
  value[0] = 1.0;
  for (int p = 1; p <= degree; p++) {
    double saved = 0.0;
    for (int j = 0; j < p; j++) {
      double right = knots[i + 1 + j], left = knots[i + 1 + j - p];
      double part = value[j] / (right - left);
      value[j] = saved + (right - x) * part;
      saved = (x - left) * part;
    }
    value[p] = saved;
  }
}

int tsi_bspline_basis(int degree, int n, const double *knots, double x, double *value,
                      double *derivative) {
  int i = tsi_bspline_span(degree, n, knots, x);
  if (derivative) {
    double lower[TSI_MAX_ORDER];
    raise_basis(degree - 1, i, knots, x, lower);
    double saved = 0.0;
    for (int j = 0; j < degree; j++) {
      double part = degree * lower[j] / (knots[i + 1 + j] - knots[i + 1 + j - degree]);
      derivative[j] = saved - part;
      saved = part;
    }
    derivative[degree] = saved;
  }
  raise_basis(degree, i, knots, x, value);
  return i - degree;
}

void tsi_bspline_insert(int degree, int n, const double *knots, int n_to, const double *to,
                        int n_components, double *points) {
  size_t row = (size_t)n_components, bytes = row * sizeof *points;
  int p = degree, i = n + p, k = n_to + p; /* last old and new knot not yet dealt with */
  while (k > i) {
    if (to[k] == knots[i]) {
      if (i > p)
        memmove(points + (size_t)(k - p - 1) * row, points + (size_t)(i - p - 1) * row, bytes);
      i--;
      k--;
      continue;
    }
    /* to[k] is new: the p points to its right are cut back, a new one enters on their left */
    double x = to[k];
    memcpy(points + (size_t)(k - p - 1) * row, points + (size_t)(k - p) * row, bytes);
    for (int l = 1; l <= p; l++) {
      double *left = points + (size_t)(k - p + l - 1) * row, *right = left + row;
      double a = to[k + l] - x;
      if (a == 0.0) {
        memcpy(left, right, bytes);
        continue;
      }
      a /= to[k + l] - knots[i - p + l];
      for (size_t c = 0; c < row; c++)
        left[c] = right[c] + a * (left[c] - right[c]);
    }
    k--;
  }
}

size_t tsi_bspline_raise_work(int degree, int n_to, int n_components) {
  return 2 * (size_t)n_to * (size_t)n_components + (size_t)n_to + (size_t)degree + 3;
}

/* Refines to the knots `to` without every q-th inner one, starting with number `left_out`. */
static void refine_without(int degree, int n, const double *knots, int n_to, const double *to,
                           int left_out, int n_components, const double *from, double *refined,
                           double *vector) {
  int q = degree + 1, n_inner = n_to + q - 1, count = 0; /* knots of `to` but the outermost */
  vector[count++] = to[0];
  for (int j = 0; j < n_inner; j++)
    if (j % q != left_out)
      vector[count++] = to[1 + j];
  vector[count++] = to[n_to + q];
  memcpy(refined, from, (size_t)n * (size_t)n_components * sizeof *refined);
  tsi_bspline_insert(degree, n, knots, count - degree - 1, vector, n_components, refined);
}

void tsi_bspline_raise(int degree, int n, const double *knots, int n_to, const double *to,
                       int n_components, const double *from, double *target, double *work) {
  int q = degree + 1;
  size_t row = (size_t)n_components, size = (size_t)n_to * row;
  double *sum = work, *refined = work + size, *vector = refined + size;
  memset(sum, 0, size * sizeof *sum);
  for (int i = 0; i < q; i++) {
    refine_without(degree, n, knots, n_to, to, i, n_components, from, refined, vector);
    for (int j = 0; j < n_to; j++) {
      const double *in = refined + (size_t)(j - (j + q - 1 - i) / q) * row;
      double *base = target + (size_t)j * row, *out = sum + (size_t)j * row;
      for (size_t c = 0; c < row; c++)
        if (i == 0)
          base[c] = in[c];
        else
          out[c] += in[c] - base[c];
    }
  }
  for (size_t c = 0; c < size; c++)
    target[c] += sum[c] / q;
}

void tsi_bspline_multiply(int degree, int n, const double *knots, double low, double high, int n_to,
                          const double *to, int n_components, const double *from, double *target,
                          double *work) {
  int q = degree + 1;
  size_t row = (size_t)n_components, size = (size_t)n_to * row;
  double *refined = work + size, *vector = refined + size;
  memset(target, 0, size * sizeof *target);
  for (int i = 0; i < q; i++) {
    refine_without(degree, n, knots, n_to, to, i, n_components, from, refined, vector);
    for (int j = 0; j < n_to; j++) {
      const double *in = refined + (size_t)(j - (j + q - 1 - i) / q) * row;
      double x = to[1 + j + (i + q - j % q) % q], factor = (1.0 - x) * low + x * high;
      for (size_t c = 0; c < row; c++)
        target[(size_t)j * row + c] += factor * in[c];
    }
  }
  for (size_t c = 0; c < size; c++)
    target[c] /= q;
}

static double map_knot(double x, double c) {
  double y = x / (x + c * (1.0 - x));
  return 1.0 - (1.0 - y);
}

int tsi_knots_moebius(int degree, int n, double c, double *knots) {
  for (int i = degree + 1; i < n; i++) {
    double x = map_knot(knots[i], c);
    if (x == 0.0 || x == 1.0 || (i + degree < n && x == map_knot(knots[i + degree], c)))
      return 0;
  }
  for (int i = 0; i < n + degree + 1; i++)
    knots[i] = map_knot(knots[i], c);
  return 1;
}
