// SPDX-License-Identifier: Apache-2.0
#include "cam_build_inner.h"
#include "cam_doubles.h"  // cam_nearest
#include "cam_feasible.h" // cam_servo_setup
#include "cam_fix.h"      // cam_clamp_i64, cam_sat_add, cam_sat_i32
#include "hal/hal.h"      // hal_takes_force

enum {
    observer_hz = 300, ///< bandwidth of the observer, at most a twentieth of the tick rate
    scale_steps = 4,   ///< deviation that is accepted at least
    least_unseen_nm = 100,
    least_still_ticks = 3,
    least_held_m_per_s2 = 5, ///< by friction
    unknown_m_per_s2 = 12,   ///< where no friction is stated
    blind_ms = 5,            ///< longest push outwards of a U with a frozen scale
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

/// When a reading that stands is frozen. Friction may hold a change of the force by twice itself,
/// and a tenth more if it is stated too small.
static void build_frozen(cam_force_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const double nm_per_tick2 = 1e9 / ((double)tick_hz * (double)tick_hz); // by 1 m/s2
    const double stated_m_per_s2 = 2.2 * p->servo_friction_mn / p->servo_mass_g;
    const double least_m_per_s2 = p->servo_friction_mn > 0 ? least_held_m_per_s2 : unknown_m_per_s2;
    const double held = stated_m_per_s2 > least_m_per_s2 ? stated_m_per_s2 : least_m_per_s2;
    const int64_t delay_ns = (int64_t)p->servo_force_delay_ns + p->u_scale_latency_ns;
    c->held_q10 = cam_nearest(held * nm_per_tick2 * 1024.0);
    c->blind_ticks = (uint32_t)cam_units_scale(blind_ms, tick_hz, 1000);
    c->quantum_q10 = p->u_scale_nm * 1024;
    c->still_ticks = least_still_ticks + (uint32_t)((delay_ns * tick_hz + 999999999) / 1000000000);
    c->unseen_nm = scale_steps * p->u_scale_nm + least_unseen_nm;
}

cam_refusal_t cam_build_force(cam_force_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const int64_t tick2 = (int64_t)tick_hz * tick_hz;
    *c = (cam_force_config_t){.is_used = hal_takes_force()};
    const cam_refusal_t refusal = cam_servo_setup(p, tick_hz, &c->servo);
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
    build_frozen(c, p, tick_hz);
    c->braking_nm = (int32_t)cam_clamp_i64(braking_nm, 1, INT32_MAX);
    c->limited_ticks = (uint32_t)cam_units_scale(p->servo_limited_ms, tick_hz, 1000);
    return refusal;
}

void cam_build_force_limits(cam_config_t *config, const cam_params_t *params)
{
    cam_force_config_t *c = &config->force;
    c->travel_nm = params->u_stroke_nm / 2 + config->guard.approach_nm;
    c->push_speed_q10 = config->play.approach[hal_axis_u].speed_q10;
    c->most_excess_q10 = cam_sat_add(c->push_speed_q10, config->guard.u.speed_q10);
}
