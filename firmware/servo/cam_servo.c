// SPDX-License-Identifier: Apache-2.0
#include "cam_servo.h"
#include "cam_fix.h" // cam_clamp_i32, cam_is_within, cam_mulhi, cam_sat_add, ..

/// Limits act on the high words of sums: a comparison of 64 bits takes three times as long. A
/// limited result lies within the last 2^18 of the limit.
/// @return floor(v / 2^18), limited to -2^28 .. 2^28 - 1
/*@ assigns \result \from v_q24;
    ensures word: -0x10000000 <= \result < 0x10000000;
*/
static int32_t force_q6(int64_t v_q24)
{
    const uint32_t high =
        (uint32_t)cam_clamp_i32((int32_t)(v_q24 >> 32), -(1 << 14), (1 << 14) - 1);
    return (int32_t)(high << 14 | (uint32_t)(uint64_t)v_q24 >> 18);
}

/// The set-point at the instant of the reading, MATHS.md (233), minus the reading. A change of the
/// acceleration beyond 2^27 wraps.
/// @return [nm / 64]
static int32_t error_q6(const cam_servo_ahead_t *by, const cam_servo_input_t *in, int32_t last_q10)
{
    const int32_t jerk_q14 = cam_wrap_times(cam_wrap_sub(in->acc_q10, last_q10), 16);
    const int32_t acc_q10 = cam_mulhi_add(in->acc_q10, jerk_q14, by->third_q28);
    const int64_t more_q26 =
        (int64_t)in->vel_q10 * by->steps_q16 + (int64_t)acc_q10 * by->half_square_q16;
    const uint32_t high =
        (uint32_t)cam_clamp_i32((int32_t)(more_q26 >> 32), -(1 << 19), (1 << 19) - 1);
    const int32_t more_q6 = (int32_t)(high << 12 | (uint32_t)(uint64_t)more_q26 >> 20);
    return cam_sat_add(cam_sat_sub(in->set_q6, in->actual_q6), more_q6);
}

/// MATHS.md (234). @return [mN / 64]
static int32_t pi_lead_q6(cam_servo_t *s, const cam_servo_config_t *cfg, int32_t off_q6,
                          int64_t sum_q38)
{
    const int32_t change_q6 = cam_sat_sub(off_q6, s->error_q6);
    const int64_t lead_q24 = (int64_t)cfg->pole_q18 * s->lead_q6 + (int64_t)cfg->kd_q18 * change_q6;
    s->error_q6 = off_q6;
    s->lead_q6 = force_q6(lead_q24);
    return force_q6((int64_t)cfg->kp_q18 * off_q6 + lead_q24 + (sum_q38 >> 14));
}

/// MATHS.md (235), transposed. @return [mN / 64] below 2^30
/*@ requires valid: \valid(s) && \valid_read(by);
    requires force: -0x10000000 <= x_q6 < 0x10000000;
    assigns \result, s->first_q36, s->second_q36 \from *s, *by, x_q6;
    ensures word: -0x40000000 <= \result < 0x40000000;
    ensures first: -0x4000000000000000 <= s->first_q36 <= 0x4000000000000000;
    ensures second: -0x1400000000000000 <= s->second_q36 <= 0x1400000000000000;
*/
static int32_t notched_q6(cam_servo_t *s, const cam_servo_notch_t *by, int32_t x_q6)
{
    const int64_t y_q36 = (int64_t)by->b0_q30 * x_q6 + s->first_q36;
    //@ assert sign: y_q36 < 0 || y_q36 >= 0;
    const uint32_t high =
        (uint32_t)cam_clamp_i32((int32_t)(y_q36 >> 32), -(1 << 28), (1 << 28) - 1);
    const int32_t y_q6 = (int32_t)(high << 2 | (uint32_t)(uint64_t)y_q36 >> 30);
    const uint32_t rest_q36 = (uint32_t)(uint64_t)y_q36 & 0x3FFFFFFFu;
    s->first_q36 = (int64_t)by->b1_q30 * (x_q6 - y_q6) + s->second_q36 + rest_q36;
    s->second_q36 = (int64_t)by->b2_q30 * x_q6 + (int64_t)by->minus_a2_q30 * y_q6;
    return y_q6;
}

/// MATHS.md (236); the friction is that of cam_axis_command.c: in full from 4 nm per step on.
/// @return [mN / 64]
static int32_t feed_forward_force_q6(const cam_servo_config_t *cfg, const cam_servo_input_t *in)
{
    const int32_t sense_q12 = cam_clamp_i32(in->vel_q10, -4096, 4095);
    return force_q6((int64_t)cfg->mass_q14 * in->acc_q10 + (int64_t)cfg->drag_q14 * in->vel_q10 +
                    (int64_t)cfg->stiffness_q18 * in->set_q6 +
                    (int64_t)cfg->friction_q12 * sense_q12);
}

/// @return [mN / 64] a force within what the motor may have
static int32_t possible_q6(const cam_servo_t *s, const cam_servo_config_t *cfg, int32_t wanted_q6)
{
    const int32_t motor_q6 = s->is_hot ? cfg->continuous_q6 : cfg->limit_q6;
    const int32_t most_q6 = s->most_q6 != 0 && s->most_q6 < motor_q6 ? s->most_q6 : motor_q6;
    return cam_clamp_i32(wanted_q6, -most_q6, most_q6);
}

/// @return [mN / 64] the same, within the largest change of a step
static int32_t limited_q6(const cam_servo_t *s, const cam_servo_config_t *cfg, int32_t wanted_q6)
{
    const int32_t within_q6 = possible_q6(s, cfg, wanted_q6);
    return cam_clamp_i32(within_q6, s->force_q6 - cfg->rate_q6, s->force_q6 + cfg->rate_q6);
}

/// The thermal model, MATHS.md (237).
/*@ requires valid: \valid(s) && \valid_read(cfg);
    assigns s->heat_q54, s->is_hot \from *s, *cfg;
    ensures heat: -0x400000000000000 <= s->heat_q54 <= 0x4400000000000000;
    ensures flag: s->is_hot == 0 || s->is_hot == 1;
*/
static void heat(cam_servo_t *s, const cam_servo_config_t *cfg)
{
    const int32_t share_q11 =
        cam_clamp_i32(cam_mulhi(s->force_q6, cfg->per_continuous), -(1 << 15), (1 << 15) - 1);
    const int32_t heat_q22 = (int32_t)(s->heat_q54 >> 32);
    const int32_t more_q22 = share_q11 * share_q11 - heat_q22;
    s->heat_q54 += (int64_t)more_q22 * cfg->cooling_q32;
    s->is_hot = heat_q22 >= (s->is_hot ? cam_servo_cold_q22 : cam_servo_hot_q22);
}

/// Accept the integral unless it would push further into a limit.
/// @param cut_q6  what the limits took from the force
/*@ requires valid: \valid(s);
    assigns s->sum_q38, s->is_limited \from *s, sum_q38, cut_q6;
    ensures sum: -0x1000000000000000 <= s->sum_q38 < 0x1000000000000000;
    ensures flag: s->is_limited == 0 || s->is_limited == 1;
*/
static void integrate(cam_servo_t *s, int64_t sum_q38, int32_t cut_q6)
{
    const bool is_winding = cut_q6 != 0 && (cut_q6 ^ s->error_q6) >= 0;
    const int32_t sum_q6 = (int32_t)(sum_q38 >> 32);
    if (!is_winding && cam_is_within(sum_q6, cam_servo_most_q6)) {
        s->sum_q38 = sum_q38;
    }
    s->is_limited = cut_q6 != 0;
}

int32_t cam_servo_step_isr(cam_servo_t *s, const cam_servo_config_t *cfg,
                           const cam_servo_input_t *in)
{
    const int32_t off_q6 = error_q6(&cfg->ahead, in, s->acc_q10);
    const int64_t sum_q38 = s->sum_q38 + (int64_t)cfg->ki_q32 * off_q6;
    const int32_t back_q6 = notched_q6(s, &cfg->notch, pi_lead_q6(s, cfg, off_q6, sum_q38));
    const int32_t wanted_q6 = cam_sat_add(back_q6 + feed_forward_force_q6(cfg, in), in->push_q6);
    s->force_q6 = limited_q6(s, cfg, wanted_q6);
    s->acc_q10 = in->acc_q10;
    integrate(s, sum_q38, cam_sat_sub(wanted_q6, s->force_q6));
    heat(s, cfg);
    return s->force_q6;
}

void cam_servo_start_isr(cam_servo_t *s, const cam_servo_config_t *cfg, const cam_servo_input_t *in)
{
    s->sum_q38 = 0;
    s->error_q6 = error_q6(&cfg->ahead, in, in->acc_q10);
    s->acc_q10 = in->acc_q10;
    s->lead_q6 = 0;
    s->first_q36 = 0;
    s->second_q36 = 0;
    s->force_q6 = 0;
    s->is_limited = false;
}

int32_t cam_servo_push_isr(cam_servo_t *s, const cam_servo_config_t *cfg, int32_t wanted_q6)
{
    s->force_q6 = possible_q6(s, cfg, wanted_q6);
    s->is_limited = false;
    heat(s, cfg);
    return s->force_q6;
}

void cam_servo_rest_isr(cam_servo_t *s, const cam_servo_config_t *cfg)
{
    s->force_q6 = 0;
    s->is_limited = false;
    heat(s, cfg);
}
