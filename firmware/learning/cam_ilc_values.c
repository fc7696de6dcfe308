// SPDX-License-Identifier: Apache-2.0
// What was learned, as others see and set it.
#include "cam_ilc.h"
#include "cam_fix.h" // cam_clamp_i32

/// What hinders the whole comes before what hinders a part.
static cam_ilc_reason_t hindered_by(const cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    return !cam_ilc_is_asked(s) || t->hindrance == (uint8_t)cam_ilc_all
               ? s->reason
               : (cam_ilc_reason_t)t->hindrance;
}

static uint32_t nturn_of(uint32_t turn_q32)
{
    return (uint32_t)((uint64_t)turn_q32 * 1000000000u >> 32);
}

/// @return [turn / 10^9] sum of the amplitudes of the ripple in force
static uint32_t ripple_nturn(const cam_ilc_t *t)
{
    uint32_t sum_q32 = 0;
    for (uint32_t k = 1; k <= cam_ilc_harmonics; k++) {
        sum_q32 += cam_complex_size(cam_ripple_order(&t->ripple, k));
    }
    return nturn_of(sum_q32);
}

cam_ilc_status_t cam_ilc_status(const cam_ilc_t *t, const cam_ilc_setup_t *setup, uint32_t tick_hz)
{
    const int64_t hz = tick_hz;
    return (cam_ilc_status_t){
        .phase = cam_ilc_is_asked(setup) ? (cam_ilc_phase_t)t->phase : cam_ilc_off,
        .reason = hindered_by(t, setup),
        .n_turns = t->n_turns,
        .n_harmonics = t->n_orders,
        .masked = t->correction.masked,
        .k1_ns = cam_sat_i32((int64_t)t->k1_q16 * 1000000000 / hz >> 16),
        .k2_us2 = cam_sat_i32(((int64_t)t->k2_q16 * 1000000 / hz) * 1000000 / hz >> 16),
        .error_nm = t->error_nm,
        .begin_error_nm = t->begun_nm,
        .correction_nm = cam_harmonic_correction_sum_q6(&t->correction) >> 6,
        .speed_mrpm = (uint32_t)((int64_t)t->speed_q32 * hz * 60000 >> 32),
        .ripple_turns = t->ripple.n_mean,
        .ripple_nturn = ripple_nturn(t),
        .scale_re_q32 = t->ripple.scale.re,
        .scale_im_q32 = t->ripple.scale.im,
    };
}

cam_ilc_harmonic_t cam_ilc_harmonic(const cam_ilc_t *t, uint32_t k)
{
    if (k >= cam_ilc_terms) {
        return (cam_ilc_harmonic_t){0};
    }
    const cam_complex_t none = {0};
    return (cam_ilc_harmonic_t){
        .correction_q6 = t->correction.c_q6[k],
        .gain = t->correction.gain[k],
        .best_q6 = t->correction.best_q6[k],
        .ripple = k > 0u ? cam_ripple_order(&t->ripple, k) : none,
        .is_masked = (t->correction.masked >> k & 1u) != 0u,
    };
}

/// Bit of the masks that says that the answers of U are known.
#define IS_PROBED (INT32_C(1) << 30)

static bool is_within(int32_t value, int32_t most)
{
    return value >= -most && value <= most;
}

int32_t cam_ilc_get(const cam_ilc_t *t, uint32_t index)
{
    const uint32_t i = index - cam_ilc_value_correction;
    const uint32_t j = index - cam_ilc_value_gain;
    const uint32_t l = index - cam_ilc_value_ripple;
    switch (index) {
    case cam_ilc_value_speed:
        return t->speed_q32;
    case cam_ilc_value_k1:
        return t->k1_q16;
    case cam_ilc_value_k2:
        return t->k2_q16;
    case cam_ilc_value_masked:
        return (int32_t)t->correction.masked | (t->correction.is_probed ? IS_PROBED : 0);
    case cam_ilc_value_phase:
        return (int32_t)t->phase_q32;
    default:
        break;
    }
    if (index < cam_ilc_value_gain) {
        const cam_complex_t c = t->correction.c_q6[i / 2u];
        return i % 2u == 0u ? c.re : c.im;
    }
    if (index < cam_ilc_value_ripple) {
        const cam_gain_t g = t->correction.gain[j / 2u];
        return j % 2u == 0u ? g.re_q12 : g.im_q12;
    }
    if (index < cam_ilc_n_values) {
        return l % 2u == 0u ? t->ripple.mean[l / 2u].re : t->ripple.mean[l / 2u].im;
    }
    return 0;
}

static bool set_one(cam_ilc_t *t, uint32_t index, int32_t value)
{
    const int32_t most_q16 = 1 << 30;
    switch (index) {
    case cam_ilc_value_speed:
        t->speed_q32 = value;
        return is_within(value, 1 << 26) && value >= 0;
    case cam_ilc_value_k1:
        t->k1_q16 = value;
        return is_within(value, most_q16);
    case cam_ilc_value_k2:
        t->k2_q16 = value;
        return is_within(value, most_q16);
    case cam_ilc_value_masked:
        t->correction.masked = (uint32_t)value & ((UINT32_C(1) << cam_ilc_terms) - 1u);
        t->correction.is_probed = (value & IS_PROBED) != 0;
        return value == cam_ilc_get(t, index);
    default:
        t->phase_q32 = (uint32_t)value;
        return true;
    }
}

static bool set_in_tables(cam_ilc_t *t, uint32_t index, int32_t value)
{
    const uint32_t i = index - cam_ilc_value_correction;
    const uint32_t j = index - cam_ilc_value_gain;
    const uint32_t l = index - cam_ilc_value_ripple;
    const int16_t narrow = (int16_t)cam_clamp_i32(value, INT16_MIN, INT16_MAX);
    if (index < cam_ilc_value_gain) {
        cam_complex_t *c = &t->correction.c_q6[i / 2u];
        *(i % 2u == 0u ? &c->re : &c->im) = value;
        return is_within(value, cam_ilc_most_nm * 64);
    }
    if (index < cam_ilc_value_ripple) {
        cam_gain_t *g = &t->correction.gain[j / 2u];
        *(j % 2u == 0u ? &g->re_q12 : &g->im_q12) = narrow;
        return narrow == value;
    }
    *(l % 2u == 0u ? &t->ripple.mean[l / 2u].re : &t->ripple.mean[l / 2u].im) = narrow;
    return is_within(value, cam_ripple_most);
}

bool cam_ilc_set(cam_ilc_t *t, uint32_t index, int32_t value)
{
    if (index >= cam_ilc_n_values) {
        return false;
    }
    const int32_t before = cam_ilc_get(t, index);
    const bool is_table = index >= cam_ilc_value_correction;
    const bool is_good = is_table ? set_in_tables(t, index, value) : set_one(t, index, value);
    if (!is_good) {
        (void)(is_table ? set_in_tables(t, index, before) : set_one(t, index, before));
    } else if (index >= cam_ilc_value_ripple && t->ripple.n_mean == 0u) {
        t->ripple.n_mean = 1u;
    }
    t->blending = cam_ilc_blend_all;
    return is_good;
}

const char *cam_ilc_phase_name(cam_ilc_phase_t phase)
{
    static const char *const names[cam_ilc_n_phases] = {"off",     "waiting", "settling", "drive",
                                                        "probing", "shape",   "cutting",  "frozen"};
    return (unsigned)phase < cam_ilc_n_phases ? names[phase] : "?";
}

const char *cam_ilc_reason_name(cam_ilc_reason_t reason)
{
    static const char *const names[cam_ilc_n_reasons] = {"all",       "not_asked", "not_measured",
                                                         "no_table",  "modulated", "slow_turn",
                                                         "fast_turn", "lobes",     "diverged"};
    return (unsigned)reason < cam_ilc_n_reasons ? names[reason] : "?";
}
