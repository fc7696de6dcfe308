// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible.h"
#include "cam_fix.h" // cam_clamp_i64

/// The override 1, and the smallest above 0: its reciprocal still fits a word.
enum { whole_ppm = 1000000, least_feed_ppm = 10000 };

/// @return ppm as a share of 2^n, rounded to nearest
static int64_t share(int64_t ppm, uint32_t n)
{
    return (ppm * (INT64_C(1) << n) + whole_ppm / 2) / whole_ppm;
}

int32_t cam_changes_feed_ppm(const cam_params_t *params)
{
    const int32_t asked_ppm = params->z_is_measured != 0 ? whole_ppm : params->feed_override_ppm;
    return asked_ppm < least_feed_ppm ? 0 : asked_ppm;
}

void cam_changes_build(cam_play_config_t *c, const cam_params_t *params, uint32_t tick_hz)
{
    const int64_t feed_ppm = cam_changes_feed_ppm(params);
    c->feed_rate_q30 = (int32_t)share(feed_ppm, 30);
    c->per_feed_rate_q24 =
        feed_ppm > 0 ? (int32_t)((share(whole_ppm, 24) * whole_ppm + feed_ppm / 2) / feed_ppm) : 0;

    // A step changes the speed of X at once, by no more than the acceleration of the approach.
    const int64_t trim_q4 = (int64_t)params->x_trim_rate_nm_per_s * 16;
    const int64_t most_q4 = 1 + c->approach[hal_axis_x].acceleration_q10 / 64;
    c->x_trim_q4 = params->x_trim_nm * 16;
    c->x_trim_step_q4 = (int32_t)cam_clamp_i64(trim_q4 * c->plan_ticks / tick_hz, 1, most_q4);

    // 1 mrad/s2 is 9.549297 r/min / 1000 per second.
    const int64_t most_ppm_per_s = params->spindle_acceleration_mrad_per_s2 * INT64_C(9549297) /
                                   (cam_abs_i64(c->spindle_mrpm) + 1);
    const int64_t ppm_per_s =
        cam_clamp_i64(params->spindle_override_rate_ppm_per_s, 1, most_ppm_per_s + 1);
    c->spindle_rate_q30 = (int32_t)share(params->spindle_override_ppm, 30);
    c->spindle_step_q30 = (int32_t)(share(ppm_per_s, 30) * c->plan_ticks / tick_hz) + 1;
}
