// SPDX-License-Identifier: Apache-2.0
// Parts of the position loop and of U's command, whose bounds single intervals do not show: sums
// are split by their sign and at their limits, the heat also where it begins to fall.
#include "cam_axis_command.c" // NOLINT: its functions are static
#include "cam_servo.c"        // NOLINT: likewise
#include "ranges_config.h"    // Q30
#include "world.h"

static void show_heat(int64_t low_q54, int64_t high_q54)
{
    cam_servo_t *s = &c.force.servo;
    s->heat_q54 = any(low_q54, high_q54);
    s->force_q6 = any(0, cam_servo_most_q6);
    heat(s, &cfg->force.servo);
    s->heat_q54 = any(low_q54, high_q54);
    s->force_q6 = any(-cam_servo_most_q6, -1);
    heat(s, &cfg->force.servo);
}

static void show_sum(int64_t low, int64_t high)
{
    (void)force_q6(any(low, high));
    integrate(&c.force.servo, any(low, high), any(INT32_MIN, INT32_MAX));
}

void main(void)
{
    const int64_t limit = INT64_C(1) << 60;
    make_world();
    show_sum(INT64_MIN, -limit - 1);
    show_sum(-limit, -1);
    show_sum(0, limit - 1);
    show_sum(limit, INT64_MAX);
    show_heat(-(Q30 << 28), -1);
    show_heat(0, (Q30 << 32) - 1);
    show_heat(Q30 << 32, (Q30 << 32) + (Q30 << 2) - 1);
    show_heat((Q30 << 32) + (Q30 << 2), (Q30 << 32) + (Q30 << 28));
    (void)notched_q6(&c.force.servo, &cfg->force.servo.notch, any(-(1 << 28), (1 << 28) - 1));
    (void)feed_forward_q6(&cfg->command.in_cut, &c.motion.axis[hal_axis_u]);
    Frama_C_show_each_end();
}
