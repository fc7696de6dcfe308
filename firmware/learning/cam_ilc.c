// SPDX-License-Identifier: Apache-2.0
#include "cam_learning_inner.h"
#include "cam_doubles.h" // cam_nearest, cam_root
#include "cam_fix.h"     // cam_abs_i64
#include <stddef.h>      // NULL
#include <string.h>      // memset

enum {
    drive_steps = 5,          ///< of layer 1 before probing
    most_share_q32 = 1 << 29, ///< [1] of the share against the chip, an eighth
    most_probe_q6 = 5000 * 64 ///< [nm / 64] largest probe, that of the parameter
};

void cam_ilc_init(cam_ilc_t *t)
{
    (void)memset(t, 0, sizeof *t);
    cam_harmonic_correction_forget(&t->correction);
    t->state = cam_state_off;
    t->chip_most_q32 = most_share_q32;
}

void cam_ilc_forget(cam_ilc_t *t)
{
    const bool is_learned = t->speed_q32 != 0 || t->drive.k1_q16 != 0 || t->drive.k2_q16 != 0 ||
                            t->drive.friction_q6 != 0 || t->drive.chip_q32 != 0 ||
                            t->chip_mean_q32 != 0;
    cam_harmonic_correction_forget(&t->correction);
    t->drive = (cam_drive_t){0};
    t->chip_mean_q32 = 0;
    t->is_limited = false;
    t->speed_q32 = 0;
    t->blending |= is_learned ? cam_ilc_blend_drive | cam_ilc_blend_correction : 0u;
}

static void follow_state(cam_ilc_t *t, cam_state_t state)
{
    if (t->state == state) {
        return;
    }
    if (t->phase == cam_ilc_probing) { // interrupted: discard the probe
        cam_harmonic_correction_forget(&t->correction);
        t->blending |= cam_ilc_blend_correction;
    }
    t->state = state;
    const bool is_rehearsal = state == cam_state_rehearsing;
    const bool is_cut = state == cam_state_cutting;
    cam_ilc_update_phase(t, is_rehearsal ? cam_ilc_settling
                            : is_cut     ? cam_ilc_cutting
                                         : cam_ilc_waiting);
    t->n_turns = is_rehearsal ? 0u : t->n_turns;
    t->is_limited = t->is_limited && !is_cut;
    if (is_rehearsal || is_cut) {
        cam_ilc_update_restart_guards(t);
    }
    if (state == cam_state_fault) { // restore the best values
        cam_harmonic_correction_restore(&t->correction);
        if (t->best_square != UINT64_MAX) {
            t->drive = t->best;
        }
        t->blending |= cam_ilc_blend_drive | cam_ilc_blend_correction;
    }
}

/// Guard of layer 1: an error 1.5 times the smallest restores the best constants.
/// @return whether the error is small enough to learn from
static bool is_drive_error_good(cam_ilc_t *t)
{
    if (t->square < t->best_square) {
        t->best_square = t->square;
        t->best = t->drive;
    }
    const uint64_t floor_q6 = cam_ilc_update_guarded_q6(t);
    const uint64_t least = floor_q6 * floor_q6 * 16u;
    const uint64_t best = t->best_square > least ? t->best_square : least;
    if (t->square / 9u <= best / 4u) {
        return true;
    }
    t->drive = t->best;
    t->n_halved++;
    return false;
}

static void step_drive(cam_ilc_t *t, const cam_ilc_setup_t *s, int32_t gain_q16)
{
    cam_ilc_chip_follow_gap(t);
    if (t->is_paused || !cam_ilc_update_is_for_drive(t)) {
        return;
    }
    if (t->larger / 5u > t->trusted / 4u) { // the error has grown with the motion
        cam_ilc_update_restart_guards(t);
        t->trusted = t->larger;
    }
    if (t->n_halved >= cam_ilc_update_most_halved) {
        return;
    }
    if (!t->is_level || is_drive_error_good(t)) { // errors of other amplitudes do not compare
        const cam_drive_t by = cam_drive_solve(&t->sums, t->turn_speed_q32);
        const int32_t gain = gain_q16 >> t->n_halved;
        const int64_t k1 = (int64_t)by.k1_q16 * gain >> 16;
        const bool is_chip = cam_ilc_chip_is_cut(t);
        if (is_chip) { // at one speed chip and acceleration cannot be distinguished
            cam_ilc_chip_step(t, by.chip_q32, gain);
        }
        const int64_t k2 = is_chip ? 0 : (int64_t)by.k2_q16 * gain >> 16;
        t->drive.k1_q16 =
            (int32_t)cam_clamp_i64(t->drive.k1_q16 + k1, s->k1_least_q16, s->k1_most_q16);
        t->drive.k2_q16 =
            (int32_t)cam_clamp_i64(t->drive.k2_q16 + k2, s->k2_least_q16, s->k2_most_q16);
        const int64_t friction = (int64_t)by.friction_q6 * gain >> 16;
        t->drive.friction_q6 =
            (int32_t)cam_clamp_i64(t->drive.friction_q6 + friction, -(int64_t)s->friction_q6,
                                   INT64_C(64) * cam_ilc_most_nm);
    }
    t->blending |= cam_ilc_blend_drive;
}

/// First turn of a rehearsal. At another speed the correction does not apply.
static void begin_rehearsal(cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    const bool is_other = cam_ilc_update_is_other_speed(t, t->turn_speed_q32);
    const bool was_probed = t->correction.is_probed;
    t->speed_q32 = t->turn_speed_q32;
    if (is_other) {
        cam_harmonic_correction_forget(&t->correction);
        t->blending |= cam_ilc_blend_correction;
        if (was_probed) {
            return;
        }
    }
    t->begun_nm = t->error_nm;
    cam_ilc_update_phase(t, t->correction.is_probed ? cam_ilc_shape : cam_ilc_drive);
    step_drive(t, s, s->gain_q16);
}

/// @return [nm / 64] size of the next probe: half the usual one, the usual one, then each 2.5 times
///         as large as the last one, as long as harmonics are masked; 0 ends the probing
static int32_t next_probe_q6(const cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    int32_t size_q6 = t->n_steps == 1u ? s->probe_q6 / 2 : s->probe_q6;
    for (uint32_t i = 2; i < t->n_steps; i++) {
        const bool is_largest = size_q6 > most_probe_q6 / 3 * 2; // the next would hardly be larger
        if (t->correction.masked == 0u || is_largest) {
            return 0;
        }
        size_q6 = cam_clamp_i32(size_q6 / 2 * 5, 0, most_probe_q6);
    }
    return size_q6;
}

static void step_probe(cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    t->n_steps++;
    const int32_t size_q6 = next_probe_q6(t, s);
    const uint32_t which = t->n_steps > 2u ? t->correction.masked : UINT32_MAX;
    cam_harmonic_correction_set_probe(&t->correction, size_q6, t->n_orders, which);
    t->blending |= cam_ilc_blend_correction;
    if (size_q6 == 0) {
        t->correction.is_probed = true;
        cam_ilc_update_restart_guards(t);
        cam_ilc_update_phase(t, cam_ilc_shape);
    }
}

/// Complete a turn that is used to learn U.
static void step(cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    t->is_limited = t->is_limited && t->phase == cam_ilc_cutting;
    t->error_nm = (uint32_t)(cam_root((double)t->square) / 64.0);
    t->largest = t->larger;
    t->n_turns++;
    switch (t->phase) {
    case cam_ilc_settling:
        begin_rehearsal(t, s);
        break;
    case cam_ilc_drive:
        step_drive(t, s, s->gain_q16);
        t->n_steps = (uint8_t)(t->n_steps + (t->is_level ? 1u : 0u));
        if (t->n_steps >= drive_steps && s->reason == cam_ilc_all) {
            cam_ilc_update_phase(t, cam_ilc_probing);
        }
        break;
    case cam_ilc_probing:
        step_probe(t, s);
        break;
    case cam_ilc_shape:
        step_drive(t, s, s->gain_q16 / 2);
        break;
    case cam_ilc_cutting:
        step_drive(t, s,
                   cam_ilc_update_gain_q16(t, s) /
                       (t->correction.is_probed && !cam_ilc_update_is_rough(t) ? 2 : 1));
        t->n_steps = (uint8_t)(t->n_steps < UINT8_MAX ? t->n_steps + 1u : UINT8_MAX);
        t->best_square += t->best_square < UINT64_MAX / 2u ? t->best_square >> 4 : 0u;
        break;
    default: // nothing is learned
        break;
    }
}

bool cam_ilc_shrink(cam_ilc_t *t)
{
    t->is_limited = true;
    t->drive.k1_q16 = t->drive.k1_q16 / 8 * 7;
    t->drive.k2_q16 = t->drive.k2_q16 / 8 * 7;
    return t->drive.k1_q16 != 0 || t->drive.k2_q16 != 0;
}

/// @return [nm] rounded up
static int64_t correction_nm(const cam_ilc_t *t)
{
    return (int64_t)(cam_harmonic_correction_sum_q6(&t->correction) >> 6) + 1;
}

int64_t cam_ilc_wanted_nm(const cam_ilc_t *t, int64_t deep_nm)
{
    const int64_t feed_nm = (int64_t)t->feed_now_nm / 4 * 5;
    const int64_t share_q32 = cam_abs_i64(t->drive.chip_q32) * feed_nm / cam_ilc_chip_feed_nm;
    const int64_t within_q32 = cam_clamp_i64(share_q32, 0, most_share_q32);
    return correction_nm(t) + (within_q32 * deep_nm >> 32);
}

void cam_ilc_fit(cam_ilc_t *t, int64_t spare_nm, int64_t deep_nm)
{
    const int64_t sum_nm = correction_nm(t);
    if (sum_nm > spare_nm) {
        cam_harmonic_correction_scale(&t->correction, (uint32_t)((spare_nm << 16) / sum_nm));
        t->is_limited = true;
    }
    const int64_t rest_nm = cam_clamp_i64(spare_nm - sum_nm, 0, INT32_MAX);
    const int64_t most_q32 = (rest_nm << 32) / (deep_nm + 1);
    t->chip_most_q32 = (int32_t)cam_clamp_i64(most_q32, 0, most_share_q32);
}

static void take_turn(cam_ilc_t *t, const cam_ilc_setup_t *s, cam_turn_bins_t *bins)
{
    cam_turn_t turn;
    if (cam_turn_bins_take(bins, &turn) == NULL) {
        return;
    }
    t->bin = &bins->bin[(turn.turn & 1u) != 0u ? cam_turn_bins_n : 0];
    cam_ilc_update_begin(t, s, &turn);
    if (!t->is_counted && t->true_q36 == 0) {
        t->bin = NULL;
        (void)cam_turn_bins_release(bins);
    }
}

static void take_harmonic(cam_ilc_t *t, const cam_ilc_setup_t *s, cam_turn_bins_t *bins)
{
    const uint32_t at_q8 = atomic_load_explicit(&bins->at_q8, memory_order_acquire);
    const bool is_late = ((at_q8 >> 8) & CAM_ILC_TURNS) != ((t->turn + 1u) & CAM_ILC_TURNS);
    if (is_late) { // the interrupt overwrites the bins
        t->bin = NULL;
        cam_ripple_drop(&t->ripple);
        return;
    }
    if (t->is_counted && t->k <= t->n_orders) {
        cam_ilc_update_harmonic(t, s);
    }
    if (t->true_q36 > 0 && t->k > 0u) {
        cam_ripple_add(&t->ripple, t->k,
                       cam_harmonics_of(&t->bin->angle_q24, cam_ilc_words_per_bin, t->k));
    }
    t->k++;
    if (t->k < cam_ilc_terms) {
        return;
    }
    t->bin = NULL; // the turn is complete
    (void)cam_turn_bins_release(bins);
    if (t->is_counted) {
        step(t, s);
    }
    if (t->true_q36 > 0 &&
        cam_ripple_close(&t->ripple, s->ripple_turns, s->least_ripple_q32, t->true_q36)) {
        t->blending |= cam_ilc_blend_ripple;
    }
}

void cam_ilc_poll(cam_ilc_t *t, const cam_ilc_setup_t *setup, cam_state_t state,
                  cam_turn_bins_t *bins)
{
    t->at_q8 = atomic_load_explicit(&bins->at_q8, memory_order_relaxed);
    follow_state(t, state);
    cam_ilc_chip_follow(t, state, bins);
    if (t->bin != NULL) {
        take_harmonic(t, setup, bins);
    } else {
        take_turn(t, setup, bins);
    }
}

static int32_t nm_per_mm2(int32_t share_q32)
{
    return cam_nearest(share_q32 * 0x1p-32 * (1e12 / cam_ilc_chip_feed_nm));
}

cam_ilc_status_t cam_ilc_status(const cam_ilc_t *t, const cam_ilc_setup_t *setup, uint32_t tick_hz)
{
    const uint32_t ripple_q23 = cam_ripple_sum(&t->ripple);
    const cam_ilc_reason_t limit = t->is_limited                             ? cam_ilc_limited
                                   : ripple_q23 >= (uint32_t)cam_ripple_most ? cam_ilc_rippled
                                                                             : cam_ilc_all;
    const cam_ilc_reason_t hindrance = t->hindrance == cam_ilc_all ? limit : t->hindrance;
    const bool is_of_setup = !cam_ilc_is_asked(setup) || hindrance == cam_ilc_all;
    return (cam_ilc_status_t){
        .phase = cam_ilc_is_asked(setup) ? t->phase : cam_ilc_off,
        .reason = is_of_setup ? setup->reason : hindrance,
        .n_turns = t->n_turns,
        .n_harmonics = t->n_orders,
        .masked = t->correction.masked,
        .k1_ns = cam_nearest(t->drive.k1_q16 * 0x1p-16 * 1e9 / tick_hz),
        .friction_nm = t->drive.friction_q6 / 64,
        .chip_nm_per_mm2 = nm_per_mm2(t->drive.chip_q32),
        .chip_mean_nm_per_mm2 = nm_per_mm2(t->chip_mean_q32),
        .k2_us2 = cam_nearest(t->drive.k2_q16 * 0x1p-16 * 1e12 / tick_hz / tick_hz),
        .error_nm = t->error_nm,
        .begin_error_nm = t->begun_nm,
        .correction_nm = cam_harmonic_correction_sum_q6(&t->correction) >> 6,
        .speed_mrpm = (uint32_t)(t->speed_q32 * 0x1p-32 * tick_hz * 60000.0),
        .ripple_turns = t->ripple.n_mean,
        .ripple_nturn = (uint32_t)(ripple_q23 * 0x1p-23 * 1e9),
    };
}

cam_ilc_harmonic_t cam_ilc_harmonic(const cam_ilc_t *t, uint32_t k)
{
    if (k >= cam_ilc_terms) {
        return (cam_ilc_harmonic_t){0};
    }
    return (cam_ilc_harmonic_t){
        .correction_q6 = t->correction.c_q6[k],
        .gain = t->correction.gain[k],
        .best_q6 = t->correction.best_q6[k],
        .ripple = k > 0u ? cam_ripple_order(&t->ripple, k) : (cam_complex_t){0},
        .is_masked = (t->correction.masked >> k & 1u) != 0u,
    };
}
