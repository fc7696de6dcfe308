// SPDX-License-Identifier: Apache-2.0
#include "cam_build_inner.h"
#include "cam_fix.h"   // cam_clamp_i64
#include "cam_units.h" // cam_units_turn_of_udeg
#include <stdbool.h>   // bool

enum { turn_udeg = 360000000, quarter = 4, half_tick_q16 = 32768 };

/// The parameters of one output, in the order of their list.
enum {
    per_turn,
    on_udeg,
    off_udeg,
    hysteresis_udeg,
    dead_time_ns,
    z_low_nm,
    z_high_nm,
    sense_of_turning,
    n_fields,
};

_Static_assert((int)cam_param_switch_1_per_turn + (int)sense_of_turning ==
                       (int)cam_param_switch_1_sense &&
                   (int)cam_param_switch_8_per_turn - (int)cam_param_switch_1_per_turn ==
                       7 * (int)n_fields,
               "parameters are contiguous per output, and outputs are contiguous");

static int32_t field(const cam_params_t *p, uint32_t output, int32_t which)
{
    const int32_t id =
        (int32_t)cam_param_switch_1_per_turn + (int32_t)output * (int32_t)n_fields + which;
    return cam_param_get(p, (cam_param_id_t)id);
}

/// @return [turn / 2^32] of an angle of 0 .. 2^32 turns in micro-degrees
static int64_t turn_q32(int64_t udeg)
{
    return cam_units_scale(udeg, CAM_TURN_Q32 / 64, turn_udeg / 64);
}

static cam_switch_config_t window(const cam_params_t *p, uint32_t i, int32_t sense,
                                  uint32_t tick_hz)
{
    const int32_t n = field(p, i, per_turn);
    const int64_t signed_udeg = (int64_t)field(p, i, off_udeg) - field(p, i, on_udeg);
    const int64_t width_udeg = signed_udeg < 0 ? signed_udeg + turn_udeg : signed_udeg;
    const int64_t width_q32 = cam_clamp_i64(n * turn_q32(width_udeg), 0, UINT32_MAX);
    // Where the interrupt's angle falls as the drawing's rises, the window begins at its other end.
    const int32_t first_udeg = field(p, i, sense > 0 ? on_udeg : off_udeg);
    const int64_t first_q32 = sense * turn_q32((int64_t)first_udeg + turn_udeg);
    const int64_t most_q32 = n > 0 ? width_q32 / n / quarter : 0;
    const int64_t hysteresis_q32 =
        cam_clamp_i64(turn_q32(field(p, i, hysteresis_udeg)), 0, most_q32);
    const int32_t low_nm = field(p, i, z_low_nm);
    const int32_t high_nm = field(p, i, z_high_nm);
    return (cam_switch_config_t){
        .per_turn = (uint32_t)n,
        .from_q32 = (uint32_t)(uint64_t)(n * first_q32),
        .width_q32 = (uint32_t)width_q32,
        .hysteresis_q32 = (uint32_t)hysteresis_q32,
        .ahead_q16 = cam_units_ticks_of_ns(field(p, i, dead_time_ns), tick_hz) + half_tick_q16,
        .is_anywhere = low_nm == high_nm,
        .z_low_nm = low_nm,
        .z_high_nm = high_nm,
        .sense = field(p, i, sense_of_turning),
    };
}

cam_switches_config_t cam_windows_build(const cam_params_t *params, int32_t sense, uint32_t tick_hz)
{
    cam_switches_config_t c = {0};
    for (uint32_t i = 0; i < (uint32_t)cam_n_switches; i++) {
        if (field(params, i, per_turn) > 0) {
            c.each[i] = window(params, i, sense, tick_hz);
            c.n = i + 1u;
        }
    }
    return c;
}
