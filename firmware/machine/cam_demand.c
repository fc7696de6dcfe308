// SPDX-License-Identifier: Apache-2.0
#include "cam_demand.h"
#include "cam_feed.h" // cam_feed_ramp_q32
#include "cam_fix.h"  // cam_abs_i64
#include "cam_plan.h" // cam_plan_ticks
#include <stdbool.h>  // bool
#include <stddef.h>   // size_t

/// The ISR's arithmetic holds up to 16 knots per tick; half of that leaves room for overspeed.
enum { max_knots_per_tick = 8 };
/// A quarter turn per tick is the observer's limit; an eighth leaves room.
enum { min_ticks_per_turn = 8 };

/// [um/s] nothing feeds faster.
enum { max_z_um_per_s = 6553400 };

static int64_t smaller(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static uint64_t greater(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

static uint64_t divided_up(uint64_t a, uint64_t b)
{
    return (a + b - 1u) / b;
}

/// [mrad/s] of [r/min / 1000]: 2 pi / 60, rounded up.
static uint64_t angular_mrad_s(uint64_t mrpm)
{
    return divided_up(mrpm * 104719756u, UINT64_C(1000000000));
}

/// @return a peak at the amplitude, rounded up
static uint64_t at_amplitude(const cam_cut_t *c, uint64_t peak)
{
    return divided_up(peak * (uint32_t)c->p->amplitude_ppm, 1000000);
}

static cam_demand_t spindle_demand(const cam_cut_t *c)
{
    const int64_t limit = smaller(c->p->spindle_limit_mrpm, c->t->limit_spindle_mrpm);
    return (cam_demand_t){cam_err_spindle_speed, limit, c->peak_mrpm};
}

/// r r' omega^2 in mrad/s2; without modulation nothing is needed.
static cam_demand_t spindle_acceleration_demand(const cam_cut_t *c)
{
    const uint64_t omega_mrad_s = angular_mrad_s(c->mean_mrpm);
    const uint64_t omega2 = divided_up(omega_mrad_s * omega_mrad_s, 1000);
    return (cam_demand_t){cam_err_spindle_acceleration, c->p->spindle_acceleration_mrad_per_s2,
                          divided_up(omega2 * c->t->spindle_peak_ppm, 1000000)};
}

static cam_demand_t tick_demand(const cam_cut_t *c)
{
    const uint64_t knots = UINT64_C(1) << (c->t->u.log2_knots + c->t->u.log2_repeat);
    const uint64_t by_knots = (uint64_t)c->tick_hz * max_knots_per_tick * 60000u / knots;
    const uint64_t by_turn = (uint64_t)c->tick_hz * 60000u / min_ticks_per_turn;
    return (cam_demand_t){cam_err_tick_rate, (int64_t)(by_knots < by_turn ? by_knots : by_turn),
                          c->peak_mrpm};
}

static cam_demand_t feed_demand(const cam_cut_t *c)
{
    const int64_t span_nm = (int64_t)c->t->z_last_nm - c->t->z_first_nm;
    return (cam_demand_t){cam_err_feed, span_nm, c->p->z_is_measured != 0 ? 0u : c->feed_nm};
}

/// Of a ring-helix that Z is geared along.
static bool has_rings(const cam_cut_t *c)
{
    return c->t->is_ring_helix && c->p->z_is_measured == 0;
}

/// Between the ramps.
static uint64_t ring_um_per_s(const cam_cut_t *c)
{
    const uint32_t ramp_q32 = cam_feed_ramp_q32((uint32_t)c->feed_nm, c->peak_mrpm,
                                                (uint32_t)c->p->z_acceleration_mm_per_s2);
    return cam_feed_speed_um_per_s((uint32_t)c->feed_nm, c->peak_mrpm, ramp_q32);
}

static uint64_t z_um_per_s(const cam_cut_t *c)
{
    return has_rings(c) ? ring_um_per_s(c) : divided_up(c->feed_nm * c->peak_mrpm, 60000000);
}

/// feed * (turns per second)^2 / ramp in mm/s2, in whole r/min. A ramp is not longer than the feed.
/// Of rings the least that any ramp needs: theirs are as short as the limit allows.
static uint64_t z_mm_per_s2(const cam_cut_t *c)
{
    if (has_rings(c)) {
        return cam_feed_least_acceleration((uint32_t)c->feed_nm, c->peak_mrpm);
    }
    const uint64_t turns = (uint64_t)c->p->feed_ramp_turns;
    const uint64_t span_nm = (uint64_t)((int64_t)c->t->z_last_nm - c->t->z_first_nm);
    const uint64_t rpm = divided_up(c->peak_mrpm, 1000);
    const uint64_t per = turns * c->feed_nm <= span_nm
                             ? UINT64_C(3600000000) * turns
                             : UINT64_C(3600000000) * span_nm / c->feed_nm;
    return divided_up(c->feed_nm * rpm * rpm, per);
}

/// Others move a measured Z as fast as they like.
static cam_demand_t z_speed_demand(const cam_cut_t *c)
{
    const int64_t limit = c->p->z_is_measured != 0 ? INT32_MAX : c->p->z_speed_um_per_s;
    return (cam_demand_t){cam_err_z_speed, limit, z_um_per_s(c)};
}

static cam_demand_t z_acceleration_demand(const cam_cut_t *c)
{
    return (cam_demand_t){cam_err_z_acceleration, c->p->z_acceleration_mm_per_s2,
                          c->p->z_is_measured != 0 ? 0u : z_mm_per_s2(c)};
}

/// What the axes do while Z feeds. A measured Z is not accelerated by this controller.
static uint64_t z_feeding_mm_per_s2(const cam_cut_t *c)
{
    return has_rings(c)               ? (uint64_t)c->p->z_acceleration_mm_per_s2
           : c->p->z_is_measured != 0 ? 0u
                                      : z_mm_per_s2(c);
}

/// What the feed adds to the motion of an axis, in thousands of the unit of its channel: of u um.
typedef struct {
    uint64_t speed;         ///< [1/s]
    uint64_t speed_per_rad; ///< [1/s/rad]
    uint64_t acceleration;  ///< [1/s2]
} drift_t;

/// Slices pass at the speed of Z over their spacing. Where they change the rate jumps, which takes
/// one set-point; while Z accelerates it rises.
/// @param set_point_hz  [1/s] of the axis
static drift_t drift(const cam_cut_t *c, const cam_channel_t *ch, const cam_change_t *change,
                     uint32_t set_point_hz)
{
    const uint64_t spacing_nm = ch->span_nm / (ch->n_slices - 1u);
    const uint64_t v_um_per_s = (uint64_t)smaller((int64_t)z_um_per_s(c), max_z_um_per_s);
    const uint64_t a_mm_per_s2 = (uint64_t)smaller((int64_t)z_feeding_mm_per_s2(c), 1000000);
    const uint64_t rate_uHz = divided_up(v_um_per_s * 1000000000u, spacing_nm);
    const uint64_t rise_mHz_per_s = divided_up(a_mm_per_s2 * 1000000000u, spacing_nm);
    const uint64_t jump = divided_up(change->kink * rate_uHz, 1000000) * set_point_hz;
    return (drift_t){
        .speed = divided_up(change->most * rate_uHz, 1000000000),
        .speed_per_rad = divided_up(change->per_rad * divided_up(rate_uHz, 1000), 1000000),
        .acceleration = divided_up(jump + divided_up(change->most * rise_mHz_per_s, 1000), 1000),
    };
}

/// @return [1/s2] what a drift adds to an acceleration: a rate that differs over the angle, too
static uint64_t drift_acceleration(const cam_cut_t *c, const drift_t *d)
{
    const uint64_t omega_crad_s = divided_up(angular_mrad_s(c->peak_mrpm), 10);
    return divided_up(2u * d->speed_per_rad * omega_crad_s, 100) + d->acceleration;
}

static drift_t u_drift(const cam_cut_t *c)
{
    return drift(c, &c->t->u, &c->t->u_change, c->tick_hz);
}

/// A cam's retract begins at its highest point.
static cam_demand_t stroke_demand(const cam_cut_t *c)
{
    const cam_table_t *t = c->t;
    const cam_params_t *p = c->p;
    const int64_t half_nm = smaller(p->u_stroke_nm, t->limit_u_stroke_nm) / 2;
    const int64_t high_nm = ((int64_t)t->u_max_nm * p->amplitude_ppm + 999999) / 1000000;
    const int64_t least_nm = (int64_t)t->u_min_nm * p->amplitude_ppm / 1000000;
    const int64_t low_nm = t->angle.knots != NULL ? -(smaller(least_nm, 0) + p->u_retract_nm)
                                                  : -smaller(least_nm, p->u_retract_nm);
    const int64_t needed = low_nm > high_nm ? low_nm : high_nm;
    return (cam_demand_t){cam_err_u_stroke, half_nm, (uint64_t)(needed > 0 ? needed : 0)};
}

/// f'' with what the envelope adds while engaging, whose smooth step e rises over t turns: the
/// largest of e f'' + 2 e' f' + e'' f at 0.7, 0.8 and 0.9 of it (between them it is 1 % more at
/// most), or f'' itself, which is more from about three turns on.
/// @param f, f1, f2  largest magnitudes of f, f', f''; f' and f'' below 2^33
static uint64_t engaging(const cam_params_t *p, uint64_t f, uint64_t f1, uint64_t f2)
{
    static const struct {
        uint32_t e_ppm, e1_ppm, e2_ppm; // e, 2 e' / 2 pi, e'' / (2 pi)^2
    } at[] = {{836920, 421124, 127665}, {942080, 244462, 145903}, {991440, 77349, 109427}};
    const uint64_t turns = (uint64_t)smaller(p->engage_turns, p->disengage_turns);
    uint64_t most = f2;
    for (size_t i = 0; i < sizeof at / sizeof at[0]; i++) {
        const uint64_t sum =
            (f2 * at[i].e_ppm + f1 * at[i].e1_ppm / turns + f * at[i].e2_ppm / (turns * turns)) /
            990000u;
        most = sum > most && turns < 3u ? sum : most;
    }
    return most;
}

/// u' omega in um/s, and what the feed adds.
static cam_demand_t u_speed_demand(const cam_cut_t *c)
{
    const int64_t limit = smaller(c->p->u_speed_um_per_s, c->t->limit_u_speed_um_s);
    const uint64_t u1 = at_amplitude(c, c->t->u1_peak_nm_per_rad);
    const uint64_t turning = divided_up(u1 * angular_mrad_s(c->mean_mrpm), 1000000);
    return (cam_demand_t){cam_err_u_speed, limit, turning + at_amplitude(c, u_drift(c).speed)};
}

/// u'' omega^2 in mm/s2, and what the feed adds.
static cam_demand_t u_acceleration_demand(const cam_cut_t *c)
{
    const cam_table_t *t = c->t;
    const int64_t limit = smaller(c->p->u_acceleration_mm_per_s2, t->limit_u_acceleration_mm_s2);
    const uint64_t u =
        greater((uint64_t)cam_abs_i64(t->u_min_nm), (uint64_t)cam_abs_i64(t->u_max_nm));
    const uint64_t most = engaging(c->p, u, t->u1_peak_nm_per_rad, t->u2_peak_nm_per_rad2);
    const uint64_t omega_mrad_s = angular_mrad_s(c->mean_mrpm);
    const uint64_t omega2 = divided_up(omega_mrad_s * omega_mrad_s, 10000); // 0.01 rad2/s2
    const uint64_t turning = divided_up(at_amplitude(c, most) * omega2, 100000000);
    const drift_t d = u_drift(c);
    const uint64_t feeding = divided_up(drift_acceleration(c, &d), 1000);
    return (cam_demand_t){cam_err_u_acceleration, limit, turning + at_amplitude(c, feeding)};
}

/// Of a skirt the amplitude is a trim; a cam loses lift by less than all of it.
static cam_demand_t amplitude_demand(const cam_cut_t *c)
{
    const uint32_t whole_ppm = 1000000;
    return (cam_demand_t){cam_err_cam_amplitude, c->p->amplitude_ppm,
                          c->t->angle.knots != NULL ? whole_ppm : 0u};
}

/// A tool that has to swing and does not would leave another cam: no speed helps.
static cam_demand_t swing_demand(const cam_cut_t *c)
{
    const bool is_missing = c->t->is_swung && c->p->swing_speed_mdeg_per_s == 0;
    return (cam_demand_t){cam_err_swing_axis, 0, is_missing ? 1u : 0u};
}

static cam_demand_t swing_range_demand(const cam_cut_t *c)
{
    return (cam_demand_t){cam_err_swing_range, c->p->swing_range_mdeg,
                          at_amplitude(c, c->t->swing.most_mdeg)};
}

/// @return [degrees / 1000] of thousands of 2^-26 turn, 0.2 % more at most
static uint64_t mdeg_of(uint64_t thousands)
{
    return divided_up(thousands * 43u, 8);
}

/// The swing gets a set-point from every plan.
static drift_t swing_drift(const cam_cut_t *c)
{
    const uint32_t set_point_hz = c->tick_hz / (uint32_t)cam_plan_ticks(c->tick_hz) + 1u;
    return drift(c, &c->t->angle, &c->t->swing_change, set_point_hz);
}

/// @return [degrees / 1000 / rad] bound of swing' r
static uint64_t swing_first(const cam_table_t *t)
{
    const uint64_t ratio_q20 = t->ratio_max_q20;
    return ((t->swing.first_mdeg_per_rad * ratio_q20) >> 20) + 1u;
}

/// @return [degrees / 1000 / rad2] bound of swing'' r^2 + swing' r r'
static uint64_t swing_second(const cam_table_t *t)
{
    const uint64_t ratio_q20 = t->ratio_max_q20;
    const uint64_t bend = (((t->swing.second_mdeg_per_rad2 * ratio_q20) >> 20) * ratio_q20) >> 20;
    return bend + (uint64_t)t->swing.first_mdeg_per_rad * t->spindle_peak_ppm / 1000000u + 1u;
}

/// swing' omega in degrees / 1000 per second, and what the feed adds.
static cam_demand_t swing_speed_demand(const cam_cut_t *c)
{
    const int64_t limit = c->p->swing_speed_mdeg_per_s;
    if (!c->t->is_swung) {
        return (cam_demand_t){cam_err_swing_speed, limit, 0};
    }
    const uint64_t first = at_amplitude(c, swing_first(c->t));
    const uint64_t turning = divided_up(first * angular_mrad_s(c->mean_mrpm), 1000);
    const uint64_t feeding = at_amplitude(c, mdeg_of(swing_drift(c).speed));
    return (cam_demand_t){cam_err_swing_speed, limit, turning + feeding};
}

/// swing'' omega^2 in degrees per second squared, and what the feed adds.
static cam_demand_t swing_acceleration_demand(const cam_cut_t *c)
{
    const cam_table_t *t = c->t;
    const int64_t limit = c->p->swing_acceleration_deg_per_s2;
    if (!t->is_swung) {
        return (cam_demand_t){cam_err_swing_acceleration, limit, 0};
    }
    const uint64_t second =
        at_amplitude(c, engaging(c->p, t->swing.most_mdeg, swing_first(t), swing_second(t)));
    const uint64_t omega_mrad_s = angular_mrad_s(c->mean_mrpm);
    const uint64_t omega2 = divided_up(omega_mrad_s * omega_mrad_s, 1000); // 0.001 rad2/s2
    const bool is_any = omega2 < (uint64_t)INT64_MAX / greater(second, 1); // else beyond all limits
    const uint64_t turning = is_any ? divided_up(second * omega2, 1000000) : INT64_MAX;
    const drift_t d = swing_drift(c);
    const uint64_t feeding = divided_up(mdeg_of(drift_acceleration(c, &d)), 1000);
    return (cam_demand_t){cam_err_swing_acceleration, limit, turning + at_amplitude(c, feeding)};
}

static uint64_t clearance_nm(const cam_cut_t *c)
{
    return (uint64_t)c->p->x_clearance_nm + (uint64_t)cam_table_rise_nm(c->t);
}

/// X leaves its clearance c by the smooth step over t turns: 15/8 c n / t at n turns per second.
static uint64_t x_clear_um_per_s(const cam_cut_t *c)
{
    const uint64_t turns = (uint64_t)smaller(c->p->engage_turns, c->p->disengage_turns);
    return (clearance_nm(c) * 15u / 8u + 1u) * c->peak_mrpm / (turns * 60000000u) + 1u;
}

/// ... and 5.774 c (n / t)^2, in whole r/min.
static uint64_t x_clear_mm_per_s2(const cam_cut_t *c)
{
    const uint64_t turns = (uint64_t)smaller(c->p->engage_turns, c->p->disengage_turns);
    const uint64_t rpm = divided_up(c->peak_mrpm, 1000);
    const uint64_t way = (clearance_nm(c) + 1u) * rpm * rpm;
    return (way / (3600u * turns * turns) + 1u) / 173180u + 1u;
}

/// Z stands while X does that, then X follows the barrel: its slope times the speed of Z.
static cam_demand_t x_speed_demand(const cam_cut_t *c)
{
    const uint64_t barrel = z_um_per_s(c) * c->t->x_slope_ppm / 1000000u + 1u;
    return (cam_demand_t){cam_err_x_speed, c->p->x_speed_um_per_s,
                          greater(barrel, x_clear_um_per_s(c))};
}

/// Its bend times the square of Z's speed, and its slope times Z's acceleration.
static cam_demand_t x_acceleration_demand(const cam_cut_t *c)
{
    const int64_t v_um_per_s = smaller((int64_t)z_um_per_s(c), max_z_um_per_s);
    const uint64_t v_tenth_mm = (uint64_t)v_um_per_s / 100u + 1u;
    const uint64_t bend = v_tenth_mm * v_tenth_mm * c->t->x_bend_ppm_per_m / 100000000000u;
    const uint64_t along = z_feeding_mm_per_s2(c) * c->t->x_slope_ppm / 1000000u;
    return (cam_demand_t){cam_err_x_acceleration, c->p->x_acceleration_mm_per_s2,
                          greater(bend + along + 1u, x_clear_mm_per_s2(c))};
}

cam_demand_t cam_demand_first_exceeded(const cam_cut_t *c)
{
    const cam_demand_t demands[] = {
        amplitude_demand(c),
        swing_demand(c),
        swing_range_demand(c),
        swing_speed_demand(c),
        swing_acceleration_demand(c),
        spindle_demand(c),
        stroke_demand(c),
        u_speed_demand(c),
        u_acceleration_demand(c),
        feed_demand(c),
        z_speed_demand(c),
        z_acceleration_demand(c),
        tick_demand(c),
        spindle_acceleration_demand(c),
        x_speed_demand(c),
        x_acceleration_demand(c),
    };
    for (size_t i = 0; i < sizeof demands / sizeof demands[0]; i++) {
        if (demands[i].needed > (uint64_t)demands[i].limit) {
            return demands[i];
        }
    }
    return (cam_demand_t){.err = cam_ok};
}
