/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A pull reader for JSON (RFC 8259), strict. */
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>

#include "file_io.h"
#include "json_reader.h"

void tsi_json_start(tsi_json *json, tsolid_context *context, const char *stage, const char *path,
                    const char *text, size_t size) {
  *json = (tsi_json){.context = context,
                     .stage = stage,
                     .path = path,
                     .text = text,
                     .end = text + size,
                     .at = text};
  if (size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0) /* byte order mark */
    json->at += 3;
}

/* ---- errors ------------------------------------------------------------------------------------
 */

static int count_line(const tsi_json *json) {
  int line = 1;
  for (const char *c = json->text; c < json->at; c++)
    line += *c == '\n' && line < INT_MAX;
  return line;
}

/* "patches[3].points[17][0]" */
static void print_place(const tsi_json *json, char *place, size_t size) {
  size_t n = 0;
  place[0] = 0;
  for (int k = 0; k < json->depth && n < size; k++) {
    int added = 0;
    if (json->step[k].index < 0)
      break;
    if (json->step[k].closing == ']')
      added = snprintf(place + n, size - n, "[%d]", json->step[k].index);
    else
      added = snprintf(place + n, size - n, "%s%s", n ? "." : "", json->step[k].key);
    n += added > 0 ? (size_t)added : 0;
  }
}

int tsi_json_fail(tsi_json *json, const char *format, ...) {
  if (json->status != TSOLID_OK)
    return 0;
  char place[256], text[256];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  print_place(json, place, sizeof place);
  tsolid_finding finding = tsi_finding(TSOLID_ERROR, TSOLID_ERROR_INPUT, json->stage);
  finding.entity = TSOLID_ENTITY_LINE;
  finding.index[0] = count_line(json);
  json->status = tsi_report(json->context, &finding, "File '%s', line %d%s%s: %s", json->path,
                            finding.index[0], place[0] ? ", " : "", place, text);
  return 0;
}

/* ---- structure ---------------------------------------------------------------------------------
 */

static char peek(tsi_json *json) {
  while (json->at < json->end &&
         (*json->at == ' ' || *json->at == '\n' || *json->at == '\r' || *json->at == '\t'))
    json->at++;
  return *json->at; /* the zero byte at the end */
}

/* What stands here, for messages. */
static const char *describe(tsi_json *json, char text[16]) {
  char c = peek(json);
  if (json->at == json->end)
    return "the end of the file";
  switch (c) {
  case '{':
    return "an object";
  case '[':
    return "a list";
  case '"':
    return "a string";
  case 't':
  case 'f':
    return "a word";
  case 'n':
  case 'N':
  case 'I':
    return "a word, not a number";
  default:
    break;
  }
  if (c == '-' || (c >= '0' && c <= '9'))
    return "a number";
  if (c > ' ' && c < 127)
    snprintf(text, 16, "'%c'", c);
  else
    snprintf(text, 16, "byte 0x%02X", (unsigned)(unsigned char)c);
  return text;
}

static int fail_expected(tsi_json *json, const char *expected) {
  char text[16];
  const char *found = describe(json, text);
  return tsi_json_fail(json, "expected %s, found %s", expected, found);
}

int tsi_json_enter(tsi_json *json, char opening) {
  if (json->status != TSOLID_OK)
    return 0;
  if (peek(json) != opening)
    return fail_expected(json, opening == '{' ? "an object" : "a list");
  if (json->depth == TSI_JSON_DEPTH)
    return tsi_json_fail(json, "nested deeper than %d", TSI_JSON_DEPTH);
  json->at++;
  json->step[json->depth].closing = opening == '{' ? '}' : ']';
  json->step[json->depth].index = -1;
  json->step[json->depth].key[0] = 0;
  json->depth++;
  return 1;
}

/* Keys are compared byte by byte: an escape in one makes it unknown. */
static int read_key(tsi_json *json) {
  char *key = json->step[json->depth - 1].key;
  key[0] = 0;
  if (peek(json) != '"')
    return fail_expected(json, "a key");
  const char *begin = ++json->at;
  while (json->at < json->end && *json->at != '"' && *json->at != '\n')
    json->at++;
  size_t length = (size_t)(json->at - begin);
  if (json->at == json->end || *json->at != '"')
    return tsi_json_fail(json, "a key has no closing quote");
  if (length >= TSI_JSON_KEY || memchr(begin, 0, length))
    return tsi_json_fail(json, "unknown key");
  memcpy(key, begin, length);
  key[length] = 0;
  json->at++;
  if (peek(json) != ':')
    return fail_expected(json, "':'");
  json->at++;
  return 1;
}

int tsi_json_next(tsi_json *json) {
  if (json->status != TSOLID_OK || json->depth == 0)
    return 0;
  int top = json->depth - 1, first = json->step[top].index < 0;
  char c = peek(json);
  if (c == json->step[top].closing) {
    json->at++;
    json->depth--;
    return 0;
  }
  if (!first) {
    if (c != ',')
      return fail_expected(json, json->step[top].closing == ']' ? "',' or ']'" : "',' or '}'");
    json->at++;
  }
  if (json->step[top].index == TSI_MAX_COUNT)
    return tsi_json_fail(json, "too many items");
  json->step[top].index++;
  return json->step[top].closing == ']' || read_key(json);
}

int tsi_json_key(tsi_json *json, const char *const *names, unsigned *seen) {
  const char *key = json->step[json->depth - 1].key;
  for (int k = 0; names[k]; k++) {
    if (strcmp(key, names[k]) != 0)
      continue;
    if (*seen & (1u << k)) {
      tsi_json_fail(json, "this key stands here twice");
      return -1;
    }
    *seen |= 1u << k;
    return k;
  }
  tsi_json_fail(json, "unknown key");
  return -1;
}

int tsi_json_finish(tsi_json *json) {
  if (json->status != TSOLID_OK)
    return 0;
  peek(json);
  return json->at == json->end || fail_expected(json, "the end of the file");
}

/* ---- numbers -----------------------------------------------------------------------------------
 */

static const char *skip_digits(const char *c) {
  while (*c >= '0' && *c <= '9')
    c++;
  return c;
}

/* The end of the number that starts at c, or NULL where the grammar of JSON sees none. */
static const char *scan_number(const char *c) {
  c += *c == '-';
  const char *digits = c;
  c = skip_digits(c);
  if (c == digits || (digits[0] == '0' && c > digits + 1))
    return NULL;
  if (*c == '.') {
    digits = c + 1;
    c = skip_digits(digits);
    if (c == digits)
      return NULL;
  }
  if (*c == 'e' || *c == 'E') {
    digits = c + 1 + (c[1] == '+' || c[1] == '-');
    c = skip_digits(digits);
    if (c == digits)
      return NULL;
  }
  return c;
}

int tsi_json_number(tsi_json *json, double *value) {
  if (json->status != TSOLID_OK)
    return 0;
  char c = peek(json);
  if (c != '-' && !(c >= '0' && c <= '9'))
    return fail_expected(json, "a number");
  const char *end = scan_number(json->at), *stop;
  if (!end)
    return tsi_json_fail(json, "malformed number");
  *value = tsi_number_parse(json->at, &stop);
  if (stop != end)
    return tsi_json_fail(json, "malformed number");
  if (!isfinite(*value))
    return tsi_json_fail(json, "number out of range");
  json->at = end;
  return 1;
}

int tsi_json_integer(tsi_json *json, int low, int high, int *value) {
  double number;
  if (!tsi_json_number(json, &number))
    return 0;
  if (number != floor(number))
    return tsi_json_fail(json, "expected a whole number, found %g", number);
  if (number < low || number > high)
    return tsi_json_fail(json, "%g is not between %d and %d", number, low, high);
  *value = (int)number;
  return 1;
}

/* ---- strings -----------------------------------------------------------------------------------
 */

/* Four hexadecimal digits, or -1. */
static long read_hex4(const char *c) {
  long code = 0;
  for (int k = 0; k < 4; k++) {
    int digit = c[k] >= '0' && c[k] <= '9'   ? c[k] - '0'
                : c[k] >= 'a' && c[k] <= 'f' ? c[k] - 'a' + 10
                : c[k] >= 'A' && c[k] <= 'F' ? c[k] - 'A' + 10
                                             : -1;
    if (digit < 0)
      return -1;
    code = 16 * code + digit;
  }
  return code;
}

static char *put_utf8(char *out, long code) {
  if (code < 0x80) {
    *out++ = (char)code;
  } else if (code < 0x800) {
    *out++ = (char)(0xC0 | code >> 6);
    *out++ = (char)(0x80 | (code & 63));
  } else if (code < 0x10000) {
    *out++ = (char)(0xE0 | code >> 12);
    *out++ = (char)(0x80 | (code >> 6 & 63));
    *out++ = (char)(0x80 | (code & 63));
  } else {
    *out++ = (char)(0xF0 | code >> 18);
    *out++ = (char)(0x80 | (code >> 12 & 63));
    *out++ = (char)(0x80 | (code >> 6 & 63));
    *out++ = (char)(0x80 | (code & 63));
  }
  return out;
}

/* \uXXXX, with its second half where it is a surrogate; *at stands behind the 'u'. */
static long read_unicode(const char **at) {
  long code = read_hex4(*at);
  if (code <= 0 || (code >= 0xDC00 && code < 0xE000))
    return -1;
  *at += 4;
  if (code < 0xD800 || code >= 0xE000)
    return code;
  if ((*at)[0] != '\\' || (*at)[1] != 'u')
    return -1;
  long low = read_hex4(*at + 2);
  if (low < 0xDC00 || low >= 0xE000)
    return -1;
  *at += 6;
  return 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
}

/* The character behind a backslash; an escape is never shorter than what it stands for. */
static char *read_escape(const char **at, char *out) {
  static const char from[] = "\"\\/bfnrt", to[] = "\"\\/\b\f\n\r\t";
  char c = *(*at)++;
  const char *found = c ? strchr(from, c) : NULL;
  if (found) {
    *out = to[found - from];
    return out + 1;
  }
  if (c != 'u')
    return NULL;
  long code = read_unicode(at);
  return code < 0 ? NULL : put_utf8(out, code);
}

/* Overlong forms and surrogates are malformed, too. */
int tsi_utf8_length(const char *c) {
  const unsigned char *b = (const unsigned char *)c;
  if (b[0] < 0x80)
    return 1;
  int n = b[0] >= 0xC2 && b[0] < 0xE0   ? 2
          : b[0] >= 0xE0 && b[0] < 0xF0 ? 3
          : b[0] >= 0xF0 && b[0] < 0xF5 ? 4
                                        : 0;
  for (int k = 1; k < n; k++)
    if ((b[k] & 0xC0) != 0x80)
      return 0;
  if ((b[0] == 0xE0 && b[1] < 0xA0) || (b[0] == 0xED && b[1] >= 0xA0) ||
      (b[0] == 0xF0 && b[1] < 0x90) || (b[0] == 0xF4 && b[1] >= 0x90))
    return 0;
  return n;
}

/* Reads on to the closing quote; `out` has room for the string as it stands in the file. */
static int decode_string(tsi_json *json, char *out) {
  for (;;) {
    char c = *json->at;
    if (json->at >= json->end)
      return tsi_json_fail(json, "a string has no closing quote");
    if (c == '"')
      break;
    if ((unsigned char)c < 0x20)
      return tsi_json_fail(json, "control character in a string");
    if (c == '\\') {
      json->at++;
      out = read_escape(&json->at, out);
      if (!out)
        return tsi_json_fail(json, "malformed escape in a string");
      continue;
    }
    int n = tsi_utf8_length(json->at);
    if (n == 0)
      return tsi_json_fail(json, "a string is not UTF-8");
    memcpy(out, json->at, (size_t)n);
    out += n;
    json->at += n;
  }
  json->at++;
  return 1;
}

int tsi_json_string(tsi_json *json, tsi_arena *arena, const char **value) {
  if (json->status != TSOLID_OK)
    return 0;
  if (peek(json) != '"')
    return fail_expected(json, "a string");
  const char *close = ++json->at;
  while (close < json->end && *close != '"')
    close += 1 + (*close == '\\' && close + 1 < json->end);
  char *out = tsi_arena_new(arena, (size_t)(close - json->at) + 1, 1);
  if (!out) {
    json->status = tsi_no_memory(json->context, json->stage);
    return 0;
  }
  *value = out;
  return decode_string(json, out);
}
