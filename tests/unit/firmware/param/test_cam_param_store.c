// SPDX-License-Identifier: Apache-2.0
// Parameters as kept text: what an older, a newer and a damaged text says to this image.
#include "cam_param.h"
#include "cam_table.h" // cam_crc32
#include "unity.h"
#include <stdio.h>  // snprintf
#include <string.h> // strlen

static char text[2 * cam_param_store_most_bytes];
static cam_params_t params;

void setUp(void)
{
    params = cam_param_defaults();
}

static cam_param_store_found_t read_text(uint32_t n)
{
    const hal_params_t kept = {.bytes = text, .size = n};
    return cam_param_store_read(&kept, &params);
}

/// Read lines with a right checksum behind them.
static cam_param_store_found_t read_lines(const char *lines)
{
    const uint32_t crc = cam_crc32(0, lines, strlen(lines));
    const int n = snprintf(text, sizeof text, "%scrc32 = %u\n", lines, (unsigned)crc);
    return read_text((uint32_t)n);
}

static void test_read_what_was_written_is_the_same(void)
{
    for (uint32_t id = 0; id < cam_n_params; id++) {
        const cam_param_info_t *info = cam_param_info((cam_param_id_t)id);
        TEST_ASSERT_LESS_THAN_size_t(cam_param_store_name_bytes, strlen(info->name));
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&params, (cam_param_id_t)id,
                                                    id % 2u == 0u ? info->min : info->max));
    }
    const cam_params_t before = params;
    const uint32_t n = cam_param_store_write(text, &params, 4000000000u);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(cam_param_store_most_bytes, n);
    params = cam_param_defaults();
    const cam_param_store_found_t found = read_text(n);
    TEST_ASSERT_EQUAL_INT(cam_ok, found.err);
    TEST_ASSERT_EQUAL_UINT32(4000000000u, found.version);
    TEST_ASSERT_EQUAL_UINT32(0, found.n_unknown + found.n_unfit + found.n_missing);
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    TEST_ASSERT_EQUAL_STRING_LEN("# camturn parameters", text, 20);
}

/// Nothing, anything, and a text of which a bit is flipped or the end is missing change nothing.
static void test_read_a_damaged_text_leaves_the_parameters(void)
{
    const cam_params_t before = params;
    const hal_params_t torn = {.is_damaged = true};
    TEST_ASSERT_EQUAL_INT(cam_err_params_none, read_text(0).err);
    TEST_ASSERT_EQUAL_INT(cam_err_params_damaged, cam_param_store_read(&torn, &params).err);
    for (int i = 0; i < 2; i++) {
        memset(text, i == 0 ? 0xFF : '\n', 300);
        TEST_ASSERT_EQUAL_INT(cam_err_params_damaged, read_text(300).err);
    }
    TEST_ASSERT_EQUAL_INT(cam_err_params_damaged, read_lines("x").err); // xcrc32
    cam_params_t other = params;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&other, cam_param_lead_ns, 12345));
    const uint32_t n = cam_param_store_write(text, &other, 3);
    for (uint32_t i = 0; i < n - 1u; i += 7u) {
        text[i] = (char)(text[i] ^ 1 << i % 7u);
        TEST_ASSERT_EQUAL_INT(cam_err_params_damaged, read_text(n).err);
        text[i] = (char)(text[i] ^ 1 << i % 7u);
    }
    for (uint32_t i = 1; i < n - 1u; i += 11u) {
        TEST_ASSERT_EQUAL_INT(cam_err_params_damaged, read_text(i).err);
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    TEST_ASSERT_EQUAL_INT(cam_ok, read_text(n).err);
    TEST_ASSERT_EQUAL_INT32(12345, params.lead_ns);
}

/// An image with other parameters takes what it knows and counts the rest, retired parameters
/// apart: they hide no unknown one.
static void test_read_a_text_of_another_image_takes_what_it_knows(void)
{
    const cam_param_store_found_t found =
        read_lines("# of an older image\n"
                   "version = 9\n"
                   "k1_ns = 77\n"
                   "k1_ns > 78\n"
                   "switch_1_per_turn = 2\n"
                   "switch_8_z_high_nm = -1000000000\n"
                   "gone_since_a_long_time_with_a_very_long_name = 4\n"
                   "switches = -2\n"
                   "lead_ns = 2000000000\n"
                   "encoder_sign = 0\n"
                   "phase_udeg = -9999999999\n"
                   "no value\n"
                   "x_trim_nm = \n"
                   "x_trim_nm = -5\n");
    TEST_ASSERT_EQUAL_INT(cam_ok, found.err);
    TEST_ASSERT_EQUAL_UINT32(9, found.version);
    TEST_ASSERT_EQUAL_UINT32(2, found.n_retired);
    TEST_ASSERT_EQUAL_UINT32(2, found.n_unknown);
    TEST_ASSERT_EQUAL_STRING("gone_since_a_long_time_with_a_very_long", found.unknown);
    TEST_ASSERT_EQUAL_UINT32(3, found.n_unfit);
    TEST_ASSERT_EQUAL_INT(cam_param_lead_ns, found.unfit);
    TEST_ASSERT_EQUAL_UINT32(cam_n_params - 5u, found.n_missing);
    TEST_ASSERT_EQUAL_INT(cam_param_counts_per_turn, found.missing);
    TEST_ASSERT_EQUAL_INT32(77, params.k1_ns);
    TEST_ASSERT_EQUAL_INT32(-5, params.x_trim_nm);
    TEST_ASSERT_EQUAL_INT32(cam_param_defaults().lead_ns, params.lead_ns);
    TEST_ASSERT_EQUAL_INT32(1, params.encoder_sign);
}

static void test_checksum_differs_by_every_parameter(void)
{
    const uint32_t before = cam_param_store_checksum(&params);
    for (uint32_t id = 0; id < cam_n_params; id++) {
        cam_params_t other = params;
        const cam_param_info_t *info = cam_param_info((cam_param_id_t)id);
        const int32_t old = cam_param_get(&params, (cam_param_id_t)id);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&other, (cam_param_id_t)id,
                                                    old == info->max ? info->min : info->max));
        TEST_ASSERT_TRUE(before != cam_param_store_checksum(&other));
    }
    TEST_ASSERT_EQUAL_UINT32(before, cam_param_store_checksum(&params));
}

static void test_no_sense_is_zero(void)
{
    static const cam_param_id_t sense[] = {cam_param_encoder_sign, cam_param_u_home_sense,
                                           cam_param_x_home_sense, cam_param_z_home_sense};
    cam_params_t p = cam_param_defaults();
    for (int i = 0; i < 4; i++) {
        TEST_ASSERT_EQUAL_INT(cam_err_param_range, cam_param_set(&p, sense[i], 0));
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&p, sense[i], -1));
    }
}

static void test_numbers_are_decimal(void)
{
    static const int64_t numbers[] = {0, 9, -10, INT64_MAX, INT64_MIN};
    for (uint32_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        char expected[32];
        char buffer[cam_text_number_bytes];
        (void)snprintf(expected, sizeof expected, "%lld", (long long)numbers[i]);
        TEST_ASSERT_EQUAL_STRING(expected, cam_text_number(buffer, numbers[i]));
    }
}
