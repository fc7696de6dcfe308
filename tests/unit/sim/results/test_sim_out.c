// SPDX-License-Identifier: Apache-2.0
// Text of rows is that of printf, also where the buffer is full.
#include "sim_out.h"
#include "unity.h"
#include <inttypes.h> // PRId64
#include <stdio.h>    // fprintf
#include <stdlib.h>   // calloc, free
#include <string.h>   // strlen

enum { n_lines = 2000, n_decimals = 10, n_bytes = 1 << 19 };

static const char columns[] =
    "a:0,b_um:1,c:2,d:3,e:4,f:5,g:6,h:7,i:8,j_mm:9,short:x4,long:x8,state:s";
static const char names[] = "a,b_um,c,d,e,f,g,h,i,j_mm,short,long,state\n";

static sim_out_t out;
static sim_rows_t rows;

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
    (void)fputc(',', stream);
}

/// @return the content of a file, to be freed; the file is removed
static char *content(const char *path)
{
    char *text = calloc(n_bytes, 1);
    FILE *stream = fopen(path, "rb");
    TEST_ASSERT_NOT_NULL(stream);
    TEST_ASSERT_LESS_THAN(n_bytes, fread(text, 1, n_bytes, stream));
    (void)fclose(stream);
    (void)remove(path);
    return text;
}

static void test_text_of_rows_is_that_of_printf(void)
{
    static const int state[] = {0, -1, 2, 1000}; // cam_state_t, none
    static const char *const state_name[] = {"off", "-", "ready", "-"};
    common_error_t e;
    FILE *theirs = fopen("sim_out_theirs.csv", "wb");
    TEST_ASSERT_TRUE(sim_out_open(&out, "sim_out_ours.csv", "--test", &e));
    sim_rows_open(&rows, columns);
    sim_out_header(&out, &rows);
    (void)fputs(names, theirs);
    for (int i = 0; i < n_lines; i++) {
        for (int k = 0; k < n_decimals; k++) {
            print(theirs, number(n_decimals * i + (k + i) % n_decimals), k);
            sim_rows_add(&rows, number(n_decimals * i + (k + i) % n_decimals));
        }
        const bool is_long = i % 3 == 0; // a mask beyond four digits has eight
        (void)fprintf(theirs, is_long ? "0x%08x,0x%08x,%s\n" : "0x%04x,0x%08x,%s\n",
                      is_long ? 0x10000u + (unsigned)i : (unsigned)i, (unsigned)i * 99999u,
                      state_name[i % 4]);
        sim_rows_add(&rows, is_long ? 0x10000 + i : i);
        sim_rows_add(&rows, (uint32_t)i * 99999u);
        sim_rows_add(&rows, state[i % 4]);
        if (i % 7 == 0) {
            sim_out_rows(&out, &rows);
        }
    }
    sim_out_rows(&out, &rows);
    (void)fclose(theirs);
    TEST_ASSERT_TRUE(sim_out_publish_all(&out, 1, &e));
    char *const text[] = {content("sim_out_ours.csv"), content("sim_out_theirs.csv")};
    TEST_ASSERT_TRUE(strlen(text[1]) > 3u * sim_out_buffer);
    TEST_ASSERT_EQUAL_STRING(text[1], text[0]);
    free(text[0]);
    free(text[1]);
    sim_rows_free(&rows);
}

static void test_values_are_rounded_to_the_decimals_of_their_column(void)
{
    sim_rows_open(&rows, "whole:0,fine:3,turn:9");
    for (int i = 0; i < 2; i++) {
        sim_rows_real(&rows, -1.5);
        sim_rows_real(&rows, 2.0006);
        sim_rows_real(&rows, -0.25);
    }
    const int64_t expected[] = {-1, 2001, -250000000, -1, 2001, -250000000};
    TEST_ASSERT_EQUAL_INT64_ARRAY(expected, rows.number, 6);
    sim_rows_drop(&rows);
    TEST_ASSERT_EQUAL(0, rows.n);
    sim_rows_free(&rows);
}

/// Rows that were taken do not hide that others are missing.
static void test_lost_rows_are_known_until_the_table_is_opened_again(void)
{
    sim_rows_open(&rows, columns);
    rows.is_lost = true;
    sim_rows_drop(&rows);
    TEST_ASSERT_TRUE(rows.is_lost);
    sim_rows_open(&rows, columns);
    TEST_ASSERT_FALSE(rows.is_lost);
    sim_rows_free(&rows);
}
