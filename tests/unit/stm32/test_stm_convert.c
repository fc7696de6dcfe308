// SPDX-License-Identifier: Apache-2.0
// Conversions of the port for the NUCLEO-H743ZI2: nearest code, clamped, never wrapping.
#include "board_config.h"
#include "fixture_random.h"
#include "stm_convert.h"
#include "unity.h"
#include <math.h> // fabsl

static const int32_t full[] = {65537,           BOARD_U_FULL_NM,         BOARD_X_FULL_NM,
                               BOARD_Z_FULL_NM, BOARD_SPINDLE_FULL_MRPM, 64 * 345000};
enum { n_full = sizeof full / sizeof full[0] };

static fixture_random_t dice;

void setUp(void)
{
    dice.state = 743;
}

static int32_t any(void)
{
    return (int32_t)fixture_random_u32(&dice);
}

/// And it never falls where the value rises.
static void test_code_is_the_nearest_one(void)
{
    for (uint32_t i = 0; i < 100000u; i++) {
        const int32_t at_10v = full[i % n_full];
        const int32_t codes_q32 = BOARD_CODES_Q32(at_10v);
        const int32_t value = any() % at_10v;
        const long double exact = 32768.0L * value / at_10v;
        const int32_t code = stm_code16(value, codes_q32);
        // half a code, and what the rounded factor makes of 32 768 codes
        TEST_ASSERT_TRUE(fabsl(code - exact) <= 0.5L + 0.07L || code == INT16_MAX);
        const int32_t other = any();
        TEST_ASSERT_TRUE(other < value ? stm_code16(other, codes_q32) <= code
                                       : stm_code16(other, codes_q32) >= code);
    }
}

static void test_code_is_clamped_at_both_ends(void)
{
    for (uint32_t i = 0; i < n_full; i++) {
        const int32_t codes_q32 = BOARD_CODES_Q32(full[i]);
        TEST_ASSERT_EQUAL_INT32(0, stm_code16(0, codes_q32));
        TEST_ASSERT_EQUAL_INT32(INT16_MAX, stm_code16(full[i], codes_q32));
        TEST_ASSERT_EQUAL_INT32(INT16_MIN, stm_code16(-full[i], codes_q32));
        TEST_ASSERT_EQUAL_INT32(INT16_MAX, stm_code16(INT32_MAX, codes_q32));
        TEST_ASSERT_EQUAL_INT32(INT16_MIN, stm_code16(INT32_MIN, codes_q32));
    }
}

static void test_internal_code_has_its_zero_in_the_middle(void)
{
    const int32_t codes_q32 = BOARD_CODES_Q32(BOARD_U_FULL_NM);
    TEST_ASSERT_EQUAL_UINT32(10528, BOARD_CODE_PM(345000)); // [uN] of a force: a 32768th
    TEST_ASSERT_EQUAL_UINT32(2048, stm_code12(0, codes_q32));
    TEST_ASSERT_EQUAL_UINT32(3072, stm_code12(BOARD_U_FULL_NM / 2, codes_q32));
    TEST_ASSERT_EQUAL_UINT32(4095, stm_code12(INT32_MAX, codes_q32));
    TEST_ASSERT_EQUAL_UINT32(0, stm_code12(INT32_MIN, codes_q32));
}

static void test_counts_become_nanometres(void)
{
    const int32_t nm_q16 = BOARD_NM_Q16(BOARD_U_COUNT_PM);
    TEST_ASSERT_EQUAL_INT32(0, stm_counts_nm(0, nm_q16));
    TEST_ASSERT_EQUAL_INT32(100000, stm_counts_nm(1000, nm_q16));
    TEST_ASSERT_EQUAL_INT32(-100000, stm_counts_nm(-1000, nm_q16));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, stm_counts_nm(INT32_MAX, nm_q16));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, stm_counts_nm(INT32_MIN, nm_q16));
    TEST_ASSERT_EQUAL_INT32(1235, stm_counts_nm(10, BOARD_NM_Q16(123456)));
}

static void test_step_is_the_nearest_one_and_reads_back_exactly(void)
{
    static const int32_t step_pm[] = {4000, BOARD_X_STEP_PM, BOARD_Z_STEP_PM, 123457, 10000000};
    for (uint32_t i = 0; i < 100000u; i++) {
        const int32_t pm = step_pm[i % 5u];
        const int32_t value = any();
        const int32_t steps = stm_steps(value, BOARD_STEPS_Q32(pm));
        const long double exact = 1000.0L * value / pm;
        // half a step, and what the rounded factor makes of two metres
        TEST_ASSERT_TRUE(fabsl(steps - exact) <= 0.5L + 0.26L);
        if (pm % 1000 == 0 && value > -1000000000 && value < 1000000000) {
            const int32_t back_nm = stm_counts_nm(steps, BOARD_NM_Q16(pm));
            TEST_ASSERT_EQUAL_INT32(steps, stm_steps(back_nm, BOARD_STEPS_Q32(pm)));
        }
    }
    TEST_ASSERT_EQUAL_INT32(0, stm_steps(INT32_MAX, BOARD_STEPS_Q32(0))); // no step output
}

static void test_counter_of_16_bits_is_continued(void)
{
    int32_t exact = 0;
    int32_t counts = 0;
    for (uint32_t i = 0; i < 100000u; i++) {
        exact += any() % 32767 / (i % 2u == 0u ? 1 : 1000);
        counts = stm_extend(counts, (uint32_t)exact & 0xFFFFu);
        TEST_ASSERT_EQUAL_INT32(exact, counts);
    }
    TEST_ASSERT_EQUAL_INT32(32767, stm_extend(0, 32767));
    TEST_ASSERT_EQUAL_INT32(-32768, stm_extend(0, 32768));
}
