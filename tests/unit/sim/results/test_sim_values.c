// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): open_memstream
/// Columns of an output as numbers are those that a reader of the text gets.
#include "sim_out.h"
#include "unity.h"
#include <stdlib.h> // strtod, free

static sim_out_t out;
static sim_values_t values;

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
