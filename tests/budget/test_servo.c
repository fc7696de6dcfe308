// SPDX-License-Identifier: Apache-2.0
// Instructions of the position loop of a force drive.
#include "budget.h"
#include "budget_count.h"
#include "fixture_servo.h"
#include <stdbool.h>
#include <stdio.h>

/// Steps that follow, that are limited, hot and reversed.
static void test_step_fits_its_budget(void)
{
    static cam_servo_t servo;
    cam_params_t params = bench_params;
    params.servo_force_rate_n_per_ms = 2000;
    params.servo_continuous_mn = 114000;
    params.servo_thermal_ms = 500;
    const cam_servo_config_t c = bench_config(&params);
    uint32_t most = 0;
    uint32_t least = UINT32_MAX;
    bool was_hot = false;
    cam_servo_input_t in = {.set_q6 = 0};
    cam_servo_start_isr(&servo, &c, &in);
    budget_count_start();
    for (int32_t i = 0; i < 40000; i++) {
        in.set_q6 = (i % 400 - 200) * 1000;
        in.vel_q10 = i % 400 < 200 ? 16000 : -16000;
        in.acc_q10 = i % 3 * 1000;
        in.actual_q6 = in.set_q6 + (i % 1000) * (i < 20000 ? 1000 : -3);
        const uint32_t from = budget_count();
        (void)cam_servo_step_isr(&servo, &c, &in);
        const uint32_t n = budget_instructions(from, budget_count());
        most = n > most ? n : most;
        was_hot = was_hot || servo.is_hot;
        least = n < least ? n : least;
    }
    printf("figure servo_step %lu\nfigure servo_step_least %lu\n", (unsigned long)most,
           (unsigned long)least);
    TEST_ASSERT_TRUE(was_hot);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(budget_servo_step, most);
}
