/* What the C99 tests of the interface are written with: every check says where it failed. */
#ifndef EGOSIEVE_TESTS_TOOLS_EMBED_C_CHECK_H_
#define EGOSIEVE_TESTS_TOOLS_EMBED_C_CHECK_H_

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "egosieve/types.h"

static int failures = 0;

#define CHECK(condition)                                                   \
  do {                                                                     \
    if (!(condition)) {                                                    \
      printf("%s:%d: %s does not hold\n", __FILE__, __LINE__, #condition); \
      ++failures;                                                          \
    }                                                                      \
  } while (0)

/* The call ends with `code`; where that is an error its text holds `words`. */
#define CHECK_CALL(call, code, words)                                                          \
  do {                                                                                         \
    const egosieve_status status_ = (call);                                                    \
    if (status_ != (code) ||                                                                   \
        (status_ != EGOSIEVE_OK && strstr(egosieve_last_error(), (words)) == NULL)) {          \
      printf("%s:%d: %s gives \"%s\" (%s); expected \"%s\" with \"%s\"\n", __FILE__, __LINE__, \
             #call, egosieve_status_name(status_),                                             \
             status_ == EGOSIEVE_OK ? "" : egosieve_last_error(), egosieve_status_name(code),  \
             (words));                                                                         \
      ++failures;                                                                              \
    }                                                                                          \
  } while (0)

#define CHECK_OK(call) CHECK_CALL(call, EGOSIEVE_OK, "")

/* Packed views. */
static inline egosieve_const_array doubles(const double* data, int64_t rows, int64_t columns) {
  const egosieve_const_array array = {
      .data = data, .rows = rows, .columns = columns, .type = EGOSIEVE_FLOAT64};
  return array;
}

static inline egosieve_array floats_out(float* data, int64_t rows, int64_t columns) {
  const egosieve_array array = {
      .data = data, .rows = rows, .columns = columns, .type = EGOSIEVE_FLOAT32};
  return array;
}

static inline egosieve_array doubles_out(double* data, int64_t rows, int64_t columns) {
  const egosieve_array array = {
      .data = data, .rows = rows, .columns = columns, .type = EGOSIEVE_FLOAT64};
  return array;
}

#endif /* EGOSIEVE_TESTS_TOOLS_EMBED_C_CHECK_H_ */
