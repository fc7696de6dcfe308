// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): open_memstream
// Numbers written by the simulator are those of printf, also where its buffer is full; columns of
// an output as numbers are those that a reader of the text gets.
#include "sim_out.h"
#include "unity.h"
#include <inttypes.h> // PRId64
#include <stdio.h>    // fprintf, open_memstream
#include <stdlib.h>   // free, strtod

enum { n_lines = 20000 };

static sim_out_t out;
static sim_values_t values;

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

/// Write a header and a row with a column of every kind.
static void write_row(sim_out_t *o, double real)
{
    sim_out_text(o, "a,b,c,d,e\n");
    sim_out_integer(o, -7);
    sim_out_real_column(o, real, 9);
    sim_out_decimal_column(o, 123, 2);
    sim_out_word_column(o, "cutting", 4);
    sim_out_hex_column(o, 0x1fu, 4);
    sim_out_char(o, '\n');
}

static void test_columns_are_numbers(void)
{
    sim_out_open_values(&out, "test", &values);
    write_row(&out, 0.25);
    TEST_ASSERT_EQUAL_STRING("a,b,c,d,e", values.header);
    TEST_ASSERT_EQUAL_size_t(5, values.n);
    const double expected[] = {-7.0, 0.25, 1.23, 4.0, 31.0};
    for (int i = 0; i < 5; i++) {
        TEST_ASSERT_TRUE(values.value[i] == expected[i]);
    }
    common_error_t e;
    TEST_ASSERT_TRUE(sim_out_publish_all(&out, 1, &e));
    sim_values_free(&values);
}

/// Awkward numbers, as text and as values: strtod() of the text is the value to the last bit.
static void test_numbers_are_those_of_the_text(void)
{
    for (int i = -2000; i < 2000; i++) {
        const double real = i * 0.0173700001 + 1e-9 * i * i;
        char *text = NULL;
        size_t size = 0;
        common_error_t e;
        sim_out_open_stream(&out, "text", open_memstream(&text, &size));
        sim_out_real(&out, real, i & 7);
        TEST_ASSERT_TRUE(sim_out_finish(&out, &e));
        sim_out_open_values(&out, "test", &values);
        sim_out_text(&out, "a\n");
        sim_out_real(&out, real, i & 7);
        TEST_ASSERT_TRUE_MESSAGE(values.value[0] == strtod(text, NULL), text);
        sim_values_free(&values);
        free(text);
    }
}

/// More than the first room holds.
static void test_many_rows_are_kept(void)
{
    sim_out_open_values(&out, "test", &values);
    sim_out_text(&out, "a\n");
    for (int i = 0; i < 100000; i++) {
        sim_out_integer(&out, i);
        sim_out_char(&out, '\n');
    }
    TEST_ASSERT_FALSE(values.is_lost);
    TEST_ASSERT_EQUAL_size_t(100000, values.n);
    TEST_ASSERT_TRUE(values.value[99999] == 99999.0);
    sim_values_free(&values);
}
