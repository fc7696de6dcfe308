// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): open_memstream
// Numbers written by the simulator are those of printf, also where its buffer is full.
#include "sim_out.h"
#include "unity.h"
#include <inttypes.h> // PRId64
#include <stdio.h>    // fprintf, open_memstream
#include <stdlib.h>   // free

enum { n_lines = 20000 };

static sim_out_t out;

/// @return a number of 1 to 19 digits, of either sign
static int64_t number(int i)
{
    static const int64_t special[] = {0, 1, -1, 9, 10, -10, 99, 100, INT64_MAX, INT64_MIN + 1};
    uint64_t v = (uint64_t)i * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    v >>= 1 + i % 61;
    return i < 10 ? special[i] : i % 2 == 0 ? (int64_t)v : -(int64_t)v;
}

/// Print a number of 10^-decimals without the simulator.
static void print(FILE *stream, int64_t value, int decimals)
{
    int64_t unit = 1;
    for (int i = 0; i < decimals; i++) {
        unit *= 10;
    }
    const int64_t size = value < 0 ? -value : value;
    (void)fprintf(stream, "%s%" PRId64, value < 0 ? "-" : "", size / unit);
    if (decimals > 0) {
        (void)fprintf(stream, ".%0*" PRId64, decimals, size % unit);
    }
    (void)fputc('\n', stream);
}

static void test_numbers_are_those_of_printf(void)
{
    char *text[2];
    size_t size[2];
    FILE *theirs = open_memstream(&text[0], &size[0]);
    FILE *ours = open_memstream(&text[1], &size[1]);
    common_error_t e;
    sim_out_open_stream(&out, "test", ours);
    for (int i = 0; i < n_lines; i++) {
        print(theirs, number(i), i % 10);
        sim_out_decimal(&out, number(i), i % 10);
        sim_out_char(&out, '\n');
    }
    (void)fclose(theirs);
    TEST_ASSERT_TRUE(sim_out_finish(&out, &e));
    TEST_ASSERT_TRUE(size[0] > 3u * sim_out_buffer);
    TEST_ASSERT_EQUAL_STRING(text[0], text[1]);
    free(text[0]);
    free(text[1]);
}
