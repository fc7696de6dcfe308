// SPDX-License-Identifier: Apache-2.0
#include "cam_build_inner.h"
#include "cam_fix.h"      // CAM_TWO_PI_Q24, cam_clamp_i64
#include "cam_feasible.h" // cam_servo_setup
#include "hal/hal.h"      // hal_takes_force
#include <stdbool.h>      // bool

enum {
    observer_hz = 300, ///< bandwidth of the observer, at most a twentieth of the tick rate
    still_hz = 2000,   ///< half a millisecond
    scale_steps = 4,   ///< deviation that is accepted at least
    runaway_most_nm = 50000,
};

/// @return [nm / 64] accepted deviation of U from its observer; by default that which an unknown
///         force as large as the force limit causes, which U could not hold
static int32_t runaway_q6(const cam_params_t *p, const cam_force_config_t *c)
{
    const int64_t own_q6 = (int64_t)p->servo_force_limit_mn * 64 * c->motion_q24 / c->vel_q24;
    const int64_t least_q6 = (int64_t)p->u_scale_nm * scale_steps * 64;
    const int64_t most_q6 = (int64_t)runaway_most_nm * 64;
    const bool is_set = p->servo_runaway_nm > 0;
    return is_set ? p->servo_runaway_nm * 64 : (int32_t)cam_clamp_i64(own_q6, least_q6, most_q6);
}

/// @return [mN / 64] force under which a standing reading is frozen: twice the friction, and what
///         deviates U by a quarter of runaway_q6, or moves it by a step of the scale and back while
///         the reading may stand, less the delay
static int32_t moving_q6(const cam_params_t *p, const cam_force_config_t *c, uint32_t tick_hz)
{
    const int64_t delay_ns = (int64_t)p->servo_force_delay_ns + p->u_scale_latency_ns;
    const int64_t n = cam_clamp_i64(c->still_ticks - delay_ns * tick_hz / 1000000000, 1, INT32_MAX);
    const int64_t step_q30 = (int64_t)p->u_scale_nm << 33; // 8 steps
    const int64_t back_q6 = step_q30 / (n * n * c->motion_q24);
    const int64_t share_q6 = (int64_t)c->runaway_q6 / 4 * c->vel_q24 / c->motion_q24;
    const int64_t most_q6 = back_q6 > share_q6 ? back_q6 : share_q6;
    return cam_sat_i32(most_q6 + 2 * (int64_t)p->servo_friction_mn * 64);
}

cam_refusal_t cam_build_force(cam_force_config_t *c, const cam_params_t *params, uint32_t tick_hz)
{
    const cam_params_t *p = params;
    const int64_t tick2 = (int64_t)tick_hz * tick_hz;
    *c = (cam_force_config_t){.is_used = hal_takes_force()};
    const cam_refusal_t refusal = cam_servo_setup(params, tick_hz, &c->servo);
    if (!c->is_used || refusal.err != cam_ok) {
        return refusal;
    }
    const int64_t hz = cam_clamp_i64(observer_hz, 1, tick_hz / 20);
    const int64_t omega_q24 = cam_units_scale(hz, CAM_TWO_PI_Q24, tick_hz);
    // 1 mN accelerates 1 g by 10^9 nm/s^2; forces are in mN / 64, which the observer shifts out
    const int64_t motion_q24 =
        cam_units_scale(INT64_C(1000000000) << 24, 1, tick2 * p->servo_mass_g);
    // half of the greatest deceleration, twice
    const int64_t braking_nm =
        cam_units_scale(p->servo_force_limit_mn, INT64_C(1000000000), tick2 * p->servo_mass_g);
    c->motion_q24 = cam_sat_i32(motion_q24); // cut where there is no loop
    c->pos_q18 = (int32_t)(omega_q24 >> 5);
    c->vel_q24 = (int32_t)((omega_q24 * omega_q24) >> 24);
    c->runaway_q6 = runaway_q6(p, c);
    c->still_ticks = tick_hz / still_hz;
    c->moving_q6 = moving_q6(p, c, tick_hz);
    c->braking_nm = (int32_t)cam_clamp_i64(braking_nm, 1, INT32_MAX);
    c->limited_ticks = (uint32_t)cam_units_scale(p->servo_limited_ms, tick_hz, 1000);
    return refusal;
}
