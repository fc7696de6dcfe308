// SPDX-License-Identifier: Apache-2.0
#include "cam_machine_inner.h"
#include "cam_fix.h" // cam_abs_i64, cam_sat_i32

static int64_t most_of(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

cam_wave_range_t cam_wave_range(const int32_t *wave_nm, uint32_t n)
{
    cam_wave_range_t range = {0};
    int64_t last_nm = wave_nm[n - 1u];
    int64_t last_step_nm = last_nm - wave_nm[n - 2u];
    for (uint32_t i = 0; i < n; i++) {
        const int64_t step_nm = wave_nm[i] - last_nm;
        range.low_nm = -most_of(-range.low_nm, -(int64_t)wave_nm[i]);
        range.high_nm = most_of(range.high_nm, wave_nm[i]);
        range.step_nm = most_of(range.step_nm, cam_abs_i64(step_nm));
        range.bend_nm = most_of(range.bend_nm, cam_abs_i64(step_nm - last_step_nm));
        last_nm = wave_nm[i];
        last_step_nm = step_nm;
    }
    return range;
}

/// A triangular speed profile covers a distance in 2 sqrt(distance / acceleration).
cam_motion_limits_t cam_wave_fade(uint32_t fade_ticks)
{
    const uint64_t ticks = fade_ticks;
    const uint64_t four_ways = (uint64_t)cam_excite_full_q30 * 4u;
    const int32_t acceleration = (int32_t)(four_ways / (ticks * ticks)) + 1;
    return (cam_motion_limits_t){
        .speed_q10 = (int32_t)(four_ways / (2u * ticks)) + acceleration,
        .acceleration_q10 = acceleration,
    };
}

uint32_t cam_wave_fall_ticks(const cam_motion_limits_t *fade)
{
    cam_axis_motion_t gain = {.pos_q10 = cam_excite_full_q30};
    uint32_t n = 0;
    while (!cam_move_profile_to_isr(&gain, fade, 0)) {
        n++;
    }
    return n;
}

/// @return [nm / 1024] a distance times share_q30 / 2^30, rounded up
static int64_t share_q10(int64_t distance_nm, int64_t share_q30)
{
    return ((distance_nm * share_q30) >> 20) + 1;
}

static cam_verdict_t refused(cam_err_t err, int64_t value)
{
    return (cam_verdict_t){.err = err, .value = cam_sat_i32(value)};
}

int64_t cam_wave_peak_nm(const cam_wave_range_t *range)
{
    return most_of(-range->low_nm, range->high_nm);
}

/// @return cam_ok, or cam_err_wave_stroke with the position farther from 0
static cam_verdict_t judge_stroke(int64_t low_nm, int64_t high_nm, const cam_config_t *cfg)
{
    const int64_t most_nm = cfg->guard.range_nm;
    if (low_nm < -most_nm || high_nm > most_nm) {
        return refused(cam_err_wave_stroke, -low_nm > high_nm ? low_nm : high_nm);
    }
    return (cam_verdict_t){.err = cam_ok};
}

cam_verdict_t cam_wave_judge(const cam_wave_range_t *range, const cam_motion_limits_t *fade,
                             bool is_force, int32_t place_nm, const cam_config_t *cfg,
                             uint32_t tick_hz)
{
    const int64_t wave_nm = cam_wave_peak_nm(range);
    if (is_force && wave_nm * 64 > cfg->force.servo.limit_q6) {
        return refused(cam_err_wave_force, wave_nm);
    }
    const cam_verdict_t stroke =
        is_force ? judge_stroke(place_nm, place_nm, cfg)
                 : judge_stroke(place_nm + range->low_nm, place_nm + range->high_nm, cfg);
    if (is_force || stroke.err != cam_ok) {
        return stroke;
    }
    const int64_t speed_q10 = range->step_nm * 1024 + share_q10(wave_nm, fade->speed_q10);
    if (speed_q10 > cfg->guard.u.speed_q10) {
        return refused(cam_err_wave_speed, (speed_q10 * tick_hz + 1023999) / 1024000);
    }
    const int64_t bend_q10 = range->bend_nm * 1024 +
                             share_q10(2 * range->step_nm, fade->speed_q10) +
                             share_q10(wave_nm, fade->acceleration_q10);
    if (bend_q10 > cfg->guard.u.acceleration_q10) {
        return refused(cam_err_wave_acceleration, bend_q10 * tick_hz / 1024000 * tick_hz / 1000);
    }
    return (cam_verdict_t){.err = cam_ok};
}
