// SPDX-License-Identifier: Apache-2.0
// One configuration at a time reaches the interrupt; what U is commanded in it is limited.
#include "cam_build.h"
#include "cam_config.h"
#include "unity.h"
#include <math.h>
#include <string.h> // memset

static cam_config_t config;
static cam_config_bank_t bank;

void setUp(void)
{
    memset(&config, 0, sizeof config);
    memset(&bank, 0, sizeof bank);
}

static void test_bank_hands_over_one_configuration_at_a_time(void)
{
    TEST_ASSERT_NULL(cam_config_take_isr(&bank)); // nothing was offered ever
    TEST_ASSERT_EQUAL_PTR(&bank.half[0], cam_config_free_half(&bank));
    cam_config_offer(&bank);
    TEST_ASSERT_EQUAL_PTR(&bank.half[0], cam_config_take_isr(&bank));
    cam_config_t *half = cam_config_free_half(&bank);
    TEST_ASSERT_EQUAL_PTR(&bank.half[1], half);
    TEST_ASSERT_EQUAL_PTR(&bank.half[0], cam_config_take_isr(&bank)); // not offered yet
    cam_config_offer(&bank);
    TEST_ASSERT_NULL(cam_config_free_half(&bank)); // not taken yet
    TEST_ASSERT_EQUAL_PTR(half, cam_config_take_isr(&bank));
    TEST_ASSERT_EQUAL_PTR(&bank.half[0], cam_config_free_half(&bank));
}

/// Speed, acceleration and jerk of U, what the feed-forward adds, and what learned values add.
static void test_limits_of_the_command_of_u_follow_from_gains_and_limits(void)
{
    const double most_learned_nm = 1900.0; // when all learned values change at once
    for (int32_t i = 0; i < 64; i++) {
        setUp();
        cam_guard_config_t *g = &config.guard;
        g->u_vel_q6 = 64 * (1000 + 37 * i);
        g->u_acc_q6 = 64 * (50 + 3 * i);
        g->u.log2_window = (uint32_t)i % 8u;
        config.command.configured.k1_q16 = (i % 3 - 1) * 65536 * 3 + i;
        config.command.configured.k2_q16 = (i % 5 - 2) * 65536 * 2 - i;
        config.learned.k1_q16 = i % 2 == 0 ? 1000 * i : -1000 * i;
        config.learned.k2_q16 = -500 * i;
        config.command.configured.friction_q14 = 16384 * 100 * i;
        config.learned.friction_q6 = -64 * 30 * i;
        config.learned.chip_q32 = (i % 2 == 0 ? 1 : -1) * (1 << 23) * i;
        config.learned.chip_q6 = -64 * 20 * i;
        g->range_nm = 500000;
        cam_config_learn(&config);
        const double v = g->u_vel_q6 / 64.0;
        const double a = g->u_acc_q6 / 64.0;
        const double j = ldexp(2.0 * a, -(int)g->u.log2_window) + 1.0 / 1024.0;
        const cam_u_gains_t *by = &config.command.configured;
        const cam_u_gains_t *cut = &config.command.in_cut;
        TEST_ASSERT_EQUAL_INT32(by->k1_q16 + config.learned.k1_q16, cut->k1_q16);
        const double k1 = fmax(fabs(by->k1_q16 / 65536.0), fabs(cut->k1_q16 / 65536.0));
        const double k2 = fmax(fabs(by->k2_q16 / 65536.0), fabs(cut->k2_q16 / 65536.0));
        const double friction = 70.0 * i; // its sense may change in one tick
        const double chip = i / 512.0;    // of the set-point
        const double step = (1.0 + chip) * v + k1 * a + k2 * j + 2.0 * friction;
        const double change = (1.0 + chip) * a + k1 * j + 2.0 * k2 * j + 2.0 * friction;
        TEST_ASSERT_DOUBLE_WITHIN(0.6, step + most_learned_nm + 0.5, g->step_nm);
        TEST_ASSERT_DOUBLE_WITHIN(0.6, change + most_learned_nm + 0.5, g->change_nm);
        TEST_ASSERT_DOUBLE_WITHIN(0.6, step + change + most_learned_nm + 0.5, g->change_off_nm);
    }
}

static void test_limits_of_the_command_of_u_fit_their_words(void)
{
    config.guard.u_vel_q6 = INT32_MAX;
    config.guard.u_acc_q6 = INT32_MAX;
    config.command.configured.k1_q16 = 100 * 65536;
    cam_config_limit_command(&config);
    TEST_ASSERT_EQUAL_INT32(1 << 29, config.guard.step_nm);
    TEST_ASSERT_EQUAL_INT32(1 << 29, config.guard.change_nm);
    TEST_ASSERT_EQUAL_INT32(1 << 29, config.guard.change_off_nm);
}
