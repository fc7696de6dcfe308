// SPDX-License-Identifier: Apache-2.0
// Learning: its setup from parameters and table, and the hand-over to the interrupt.
#include "cam_machine_inner.h"
#include "cam_fix.h"      // CAM_TURN_Q32
#include "cam_build.h"    // cam_build_speed_q32
#include "cam_eval.h"     // cam_eval_profile
#include "cam_feasible.h" // cam_feasible_demands, cam_gains_bound
#include "hal/hal.h"      // hal_measures_u
#include <stddef.h>       // NULL
#include <string.h>       // memcmp

_Static_assert(sizeof(cam_ilc_t) + sizeof(cam_turn_bins_t) + 2u * sizeof(cam_learned_t) <= 8704u,
               "RAM of learning: state, bins of two turns, and what is in force in two halves");

/// The learned change of a drive constant may reach the configured value plus this.
enum { spare_ticks_q16 = 4 << 16, spare_ticks2_q16 = 16 << 16 };

/// Encoder counts in step with the ticks imitate a ripple of at most 1 count / feigned_part.
enum { feigned_part = 4 };

/// [nm] A deeper cut counts as one of 10 mm.
enum { most_depth_nm = 10000000 };

static int32_t q16_of_ppm(int32_t ppm)
{
    return (int32_t)((int64_t)ppm * 65536 / 1000000);
}

static int32_t ticks_q16(const cam_machine_t *m, int64_t ns)
{
    return cam_sat_i32(ns * m->tick_hz / 1000000 * 65536 / 1000);
}

static int32_t ticks2_q16(const cam_machine_t *m, int64_t us2)
{
    return cam_sat_i32(us2 * m->tick_hz / 1000 * m->tick_hz / 1000 * 8192 / 125000);
}

/// Below twice the second harmonic of the turn a position loop hardly follows a correction of it.
static bool is_loop_slow(const cam_machine_t *m)
{
    const cam_config_t *cfg = cam_machine_newest_config(m);
    const int64_t mrpm = cam_abs_i64(cfg->play.spindle_mrpm);
    return cfg->force.is_used && (int64_t)m->params.servo_crossover_hz * 60000 < 4 * mrpm;
}

static cam_ilc_reason_t asked_of(const cam_machine_t *m)
{
    if (m->params.learn_harmonics == 0) {
        return cam_ilc_not_asked;
    }
    if (!hal_measures_u()) {
        return cam_ilc_not_measured;
    }
    if (!m->has_table) {
        return cam_ilc_no_table;
    }
    if (m->table.speed.knots != NULL) {
        return cam_ilc_modulated;
    }
    if (is_loop_slow(m)) {
        return cam_ilc_slow_loop;
    }
    return m->table.n_lobes > 0u ? cam_ilc_lobes : cam_ilc_all;
}

/// @return whether a table has bands with sections of their own. A round band shows nothing of U's
///         drive, so that the cut learns nothing of it then.
static bool has_bands(const cam_machine_t *m)
{
    return m->has_table && m->table.has_stations && m->table.n_lobes == 0u;
}

/// @return the encoder's error A sin(angle - phase) in the cutting direction: -j A e^(-j phase)
static cam_complex_t eccentricity(const cam_machine_t *m)
{
    const int64_t size_q32 = m->params.eccentricity_nturn * CAM_TURN_Q32 / 1000000000;
    const int64_t sense = m->has_table ? m->table.direction : 1;
    const int64_t phase_q32 = sense * m->params.eccentricity_udeg * CAM_TURN_Q32 / 360000000;
    const cam_complex_t at_0 = {.im = -(int32_t)size_q32};
    return cam_harmonics_rotated(at_0, 1, 0u - (uint32_t)(uint64_t)phase_q32);
}

typedef struct {
    int32_t least_q16, most_q16;
} range_t;

/// @param bound_q16  gain bound: sum of the configured value and the change stays within it
static range_t range_of(int64_t configured_q16, int64_t bound_q16, int64_t spare_q16)
{
    return (range_t){
        .least_q16 = cam_sat_i32(cam_clamp_i64(-bound_q16 - configured_q16, -spare_q16, 0)),
        .most_q16 = cam_sat_i32(cam_clamp_i64(bound_q16 - configured_q16, 0, spare_q16)),
    };
}

/// @return [ticks / 2^16] learned change of k1
static range_t k1_range(const cam_machine_t *m)
{
    const cam_params_t *p = &m->params;
    const int64_t bound_ns = cam_gains_bound(p, cam_param_k1_ns, m->tick_hz);
    const int64_t lag_q16 = ticks_q16(m, (int64_t)p->k1_ns + p->lead_ns);
    return range_of(ticks_q16(m, p->k1_ns), ticks_q16(m, bound_ns), lag_q16 + spare_ticks_q16);
}

/// @return [ticks^2 / 2^16] learned change of k2
static range_t k2_range(const cam_machine_t *m)
{
    const int64_t bound_us2 = cam_gains_bound(&m->params, cam_param_k2_us2, m->tick_hz);
    const int64_t k2_q16 = ticks2_q16(m, m->params.k2_us2);
    // A loop of its own lags by the force that a wrong mass lacks, over the gain: here half the
    // mass
    const cam_servo_config_t *servo = &cam_machine_newest_config(m)->force.servo;
    const int64_t mass_q16 =
        servo->kp_q18 > 0 ? ((int64_t)servo->mass_q14 << 19) / servo->kp_q18 : 0;
    return range_of(k2_q16, ticks2_q16(m, bound_us2), k2_q16 + spare_ticks2_q16 + mass_q16);
}

/// @return turns averaged for the ripple, at least two: the blend to a new mean takes one
///         turn, so that with one it would never end
static uint32_t ripple_turns(const cam_machine_t *m)
{
    const bool is_asked = m->has_table && m->table.speed.knots == NULL;
    const uint32_t turns = is_asked ? (uint32_t)m->params.ripple_turns : 0u;
    return turns == 1u ? 2u : turns;
}

/// @return [nm] depth of cut where U is 0, at the height of the last turn; the blank is a cylinder
static int32_t depth_nm(const cam_machine_t *m)
{
    const cam_table_t *t = &m->table;
    if (!m->has_table || t->n_lobes > 0u) {
        return 0;
    }
    const cam_value_t x = cam_eval_profile(&t->x, m->ilc.z_nm);
    const int64_t x_nm = ((int64_t)x.y >> t->x.frac_bits) + t->x.value_offset;
    const int64_t depth = (int64_t)t->depth_nm + t->x_max_nm - t->u_min_nm - x_nm;
    return (int32_t)cam_clamp_i64(depth, 0, most_depth_nm);
}

uint32_t cam_machine_ripple_from_mrpm(const cam_params_t *params)
{
    return (uint32_t)params->observer_bandwidth_mHz * 60u / 32u;
}

static cam_ilc_setup_t setup_of(const cam_machine_t *m)
{
    const cam_params_t *p = &m->params;
    const int32_t most_probe_nm = cam_param_info(cam_param_probe_nm)->max;
    const int64_t part_q16 = ticks_q16(m, (int64_t)p->lead_ns + p->u_scale_latency_ns) & 0xFFFF;
    const range_t k1 = k1_range(m);
    const range_t k2 = k2_range(m);
    return (cam_ilc_setup_t){
        .reason = asked_of(m),
        .n_harmonics = (uint32_t)p->learn_harmonics,
        .gain_q16 = q16_of_ppm(p->learn_gain_ppm),
        .cut_gain_q16 = has_bands(m) ? 0 : q16_of_ppm(p->learn_cut_gain_ppm),
        // at least three steps of the scale, within the range of the parameter
        .probe_q6 = cam_clamp_i32(3 * p->u_scale_nm, p->probe_nm, most_probe_nm) * 64,
        .ripple_turns = ripple_turns(m),
        .ripple_from_q32 = cam_build_speed_q32(cam_machine_ripple_from_mrpm(p), m->tick_hz),
        .scale_nm = p->u_scale_nm,
        .least_ripple_q32 =
            hal_has_edge_time() ? 0 : (int32_t)(CAM_TURN_Q32 / p->counts_per_turn / feigned_part),
        .count_urad = 6283185 / p->counts_per_turn,
        .most_q6 = cam_ilc_most_nm * 64,
        .k1_q16 = ticks_q16(m, p->k1_ns),
        .k2_q16 = ticks2_q16(m, p->k2_us2),
        .k1_least_q16 = k1.least_q16,
        .k1_most_q16 = k1.most_q16,
        .k2_least_q16 = k2.least_q16,
        .k2_most_q16 = k2.most_q16,
        .friction_q6 = p->u_friction_nm * 64,
        .depth_nm = depth_nm(m),
        .between_q16 = (int32_t)(part_q16 * (65536 - part_q16) >> 17),
        .eccentricity = eccentricity(m),
    };
}

void cam_machine_unlearn(cam_machine_t *m, cam_param_id_t id)
{
    if (cam_param_has(id, cam_flag_unlearn)) {
        cam_ilc_forget(&m->ilc);
    }
    if (cam_param_has(id, cam_flag_ripple)) {
        m->ilc.blending |= cam_ilc_blend_ripple;
    }
}

static bool is_same(const cam_learned_t *a, const cam_learned_t *b)
{
    return a->k1_q16 == b->k1_q16 && a->k2_q16 == b->k2_q16 && a->friction_q6 == b->friction_q6 &&
           a->chip_q32 == b->chip_q32 && a->chip_q6 == b->chip_q6 &&
           memcmp(a->c, b->c, sizeof a->c) == 0 && memcmp(a->d, b->d, sizeof a->d) == 0 &&
           memcmp(a->dm, b->dm, sizeof a->dm) == 0;
}

/// @return [r/min / 1000] speed of the last turn, the highest one before the first
static uint64_t turning_mrpm(const cam_machine_t *m)
{
    const uint64_t mrpm = (uint64_t)m->ilc.turn_speed_q32 * m->tick_hz * 60000u >> 32;
    return mrpm > 0u ? mrpm : m->limit_mrpm;
}

/// Margins of U's limits in a cut with the learned constants. The learned friction does not count:
/// where U turns back it changes its sign.
typedef struct {
    uint64_t acceleration_mm_per_s2;
    int64_t stroke_nm; ///< below 0: the constants alone exceed it
} spare_t;

/// @param mrpm       [r/min / 1000]
/// @param wanted_nm  [nm] the margin of the stroke is exact only below this value
static spare_t spare_of(const cam_machine_t *m, const cam_ilc_setup_t *setup, uint32_t mrpm,
                        int64_t wanted_nm)
{
    const cam_ilc_status_t learned = cam_ilc_status(&m->ilc, setup, m->tick_hz);
    cam_params_t p = m->params;
    const int64_t k2_us2 = (int64_t)p.k2_us2 + learned.k2_us2;
    p.k1_ns = cam_sat_i32(cam_abs_i64((int64_t)p.k1_ns + learned.k1_ns));
    p.k2_us2 = cam_sat_i32(k2_us2 > 0 ? k2_us2 : 0);
    p.u_stroke_nm = cam_sat_i32(cam_clamp_i64(p.u_stroke_nm - 2 * wanted_nm, 0, INT32_MAX));
    cam_demands_t axes;
    (void)cam_feasible_demands(&m->table, &p, mrpm, m->tick_hz, &axes);
    spare_t spare = {.stroke_nm = m->params.u_stroke_nm / 2};
    for (uint32_t i = 0; i < (uint32_t)cam_n_demands; i++) {
        const cam_demand_t *u = &axes.of[i];
        const int64_t needed = (int64_t)cam_smaller_i64((int64_t)u->needed, INT32_MAX);
        if (u->err == cam_err_u_acceleration) {
            const int64_t left = u->limit - needed;
            spare.acceleration_mm_per_s2 = (uint64_t)(u->limit / 16 + (left > 0 ? left : 0));
            spare.stroke_nm -= k2_us2 < 0 ? -k2_us2 * needed / 1000000 : 0;
        } else if (u->err == cam_err_u_command) {
            spare.stroke_nm -= needed;
        }
    }
    return spare;
}

/// Fit what is learned into the stroke of U while it plays the table.
/// @return [mm/s2] the spare acceleration
static uint64_t fit_stroke(cam_machine_t *m, const cam_ilc_setup_t *setup, cam_state_t state)
{
    const uint32_t mrpm = (uint32_t)turning_mrpm(m);
    const cam_table_t *t = &m->table;
    const int64_t most_nm = t->u_max_nm > -t->u_min_nm ? t->u_max_nm : -(int64_t)t->u_min_nm;
    const int64_t deep_nm = setup->depth_nm + most_nm * m->params.amplitude_ppm / 1000000;
    const int64_t wanted_nm = cam_ilc_wanted_nm(&m->ilc, deep_nm);
    spare_t spare = spare_of(m, setup, mrpm, wanted_nm);
    if (state == cam_state_rehearsing || state == cam_state_cutting) {
        while (spare.stroke_nm < 0 && cam_ilc_shrink(&m->ilc)) {
            spare = spare_of(m, setup, mrpm, wanted_nm);
        }
        cam_ilc_fit(&m->ilc, cam_clamp_i64(spare.stroke_nm, 0, INT32_MAX), deep_nm);
    }
    return spare.acceleration_mm_per_s2;
}

/// A step a of the learned angle makes the observer's speed waver by 2 d w a, d = 0.7: by 0.2 %
/// where a is 0.002 / (2 d w) of the speed.
/// @return [turn / 2^23] that step, at least 1
static int32_t observer_step_q23(const cam_machine_t *m)
{
    const uint64_t step = turning_mrpm(m) * 32u / (uint32_t)m->params.observer_bandwidth_mHz;
    return step < INT16_MAX ? (int32_t)step + 1 : INT16_MAX;
}

/// A step of the learned angle moves U's set-point by as much as the slope makes of it, in one
/// tick. It may take half of the spare acceleration.
/// @return [turn / 2^23] that step, at least 1
static int32_t angle_step_q23(const cam_machine_t *m, uint64_t spare_mm_per_s2)
{
    const uint64_t hz = m->tick_hz;
    const uint64_t slope_nm =
        cam_scaled_up_u64(m->table.u1_peak_nm_per_rad, (uint64_t)m->params.amplitude_ppm, 1000000) +
        1u;
    // a radian is 2^23 / 2 pi units, of which the factor is half
    const uint64_t step = spare_mm_per_s2 * 667544u / hz * 1000000u / hz / slope_nm;
    return step < INT16_MAX ? (int32_t)step + 1 : INT16_MAX;
}

void cam_machine_ilc_poll(cam_machine_t *m, cam_state_t state, bool is_u_moving)
{
    const cam_params_t *p = &m->params;
    cam_turn_bins_t *bins = &m->core->bins;
    const uint32_t at_q8 = atomic_load_explicit(&bins->at_q8, memory_order_relaxed);
    const bool is_off = p->learn_harmonics == 0 && p->ripple_turns == 0 && cam_ilc_is_idle(&m->ilc);
    if (is_off || !cam_ilc_is_due(&m->ilc, state, at_q8)) {
        return;
    }
    cam_ilc_setup_t setup = setup_of(m);
    setup.is_u_moving = is_u_moving;
    cam_ilc_poll(&m->ilc, &setup, state, bins);
    const bool is_blending = cam_ilc_is_blending(&m->ilc, at_q8);
    cam_config_t *copy = is_blending ? cam_config_copy(&m->core->config) : NULL;
    if (copy != NULL) {
        setup.observer_step_q23 = observer_step_q23(m);
        setup.angle_step_q23 = INT16_MAX;
        if (m->has_table) {
            setup.angle_step_q23 = angle_step_q23(m, fit_stroke(m, &setup, state));
        }
        cam_ilc_blend(&m->ilc, &setup, at_q8, &copy->learned);
        if (!is_same(&copy->learned, &cam_machine_newest_config(m)->learned)) {
            cam_machine_offer_copy(m);
        }
    }
}

cam_ilc_status_t cam_machine_learning(const cam_machine_t *m)
{
    const cam_ilc_setup_t setup = setup_of(m);
    return cam_ilc_status(&m->ilc, &setup, m->tick_hz);
}

cam_err_t cam_machine_set_learned(cam_machine_t *m, uint32_t index, int32_t value)
{
    const cam_state_t state = cam_machine_status(m).state;
    if (index >= cam_ilc_n_values) {
        return cam_err_param_id;
    }
    if (state != cam_state_off && state != cam_state_ready) {
        return cam_err_param_state;
    }
    const bool is_k1 = index == (uint32_t)cam_ilc_value_k1;
    const bool is_k2 = index == (uint32_t)cam_ilc_value_k2;
    const range_t range = is_k1   ? k1_range(m)
                          : is_k2 ? k2_range(m)
                                  : (range_t){INT32_MIN, INT32_MAX};
    const bool is_good = cam_is_between(value, range.least_q16, range.most_q16) &&
                         cam_ilc_set(&m->ilc, index, value);
    return is_good ? cam_ok : cam_err_param_range;
}
