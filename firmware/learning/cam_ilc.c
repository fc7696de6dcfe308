// SPDX-License-Identifier: Apache-2.0
#include "cam_ilc.h"
#include "cam_fix.h"        // cam_abs_i64, cam_root_u64
#include "cam_harmonics.h"  // cam_harmonics_of
#include "cam_ilc_update.h" // cam_ilc_update_begin
#include <stddef.h>         // NULL
#include <string.h>         // memset

enum {
    words_per_bin = sizeof(cam_turn_bin_t) / sizeof(int32_t),
    drive_steps = 3, ///< of layer 1 before the probe
};

#define TURNS UINT32_C(0xFFFFFF) ///< turns are numbered modulo 2^24

void cam_ilc_init(cam_ilc_t *t)
{
    (void)memset(t, 0, sizeof *t);
    cam_harmonic_correction_forget(&t->correction);
    t->state = (uint8_t)cam_state_off;
}

void cam_ilc_forget(cam_ilc_t *t)
{
    const bool is_something = t->speed_q32 != 0 || t->k1_q16 != 0 || t->k2_q16 != 0;
    cam_harmonic_correction_forget(&t->correction);
    t->k1_q16 = 0;
    t->k2_q16 = 0;
    t->speed_q32 = 0;
    t->blending |= is_something ? cam_ilc_blend_drive | cam_ilc_blend_correction : 0u;
}

static void trust(cam_ilc_t *t)
{
    cam_harmonic_correction_renew(&t->correction);
    t->best_square = UINT64_MAX;
    t->trusted = 0;
    t->n_halved = 0;
}

/// A probe that was cut short leaves nothing.
static void end_probe(cam_ilc_t *t)
{
    if (t->phase == (uint8_t)cam_ilc_probing) {
        cam_harmonic_correction_forget(&t->correction);
        t->blending |= cam_ilc_blend_correction;
    }
}

/// After a fault what is in force is the best that was reached.
static void restore(cam_ilc_t *t)
{
    cam_harmonic_correction_restore(&t->correction);
    if (t->best_square != UINT64_MAX) {
        t->k1_q16 = t->best_k1_q16;
        t->k2_q16 = t->best_k2_q16;
    }
    t->blending |= cam_ilc_blend_drive | cam_ilc_blend_correction;
}

static void note_state(cam_ilc_t *t, cam_state_t state)
{
    if (t->state == (uint8_t)state) {
        return;
    }
    end_probe(t);
    t->state = (uint8_t)state;
    cam_ilc_update_phase(t, cam_ilc_waiting);
    if (state == cam_state_rehearsing) {
        cam_ilc_update_phase(t, cam_ilc_settling);
        t->n_turns = 0;
        trust(t);
    } else if (state == cam_state_cutting) {
        cam_ilc_update_phase(t, cam_ilc_cutting);
        trust(t);
    } else if (state == cam_state_fault) {
        restore(t);
    } else {
        // nothing is learned
    }
}

/// The guard of layer 1. @return whether the error is one to learn from
static bool is_drive_sound(cam_ilc_t *t)
{
    if (t->square < t->best_square) {
        t->best_square = t->square;
        t->best_k1_q16 = t->k1_q16;
        t->best_k2_q16 = t->k2_q16;
    }
    const uint64_t floor_q6 = cam_ilc_update_guarded_q6(t);
    const uint64_t least = floor_q6 * floor_q6 * 16u;
    const uint64_t best = t->best_square > least ? t->best_square : least;
    if (t->square / 9u <= best / 4u) {
        return true;
    }
    t->k1_q16 = t->best_k1_q16;
    t->k2_q16 = t->best_k2_q16;
    t->n_halved++;
    return false;
}

/// An error that grows with the shape is no worse: the guard begins anew.
static void follow_size(cam_ilc_t *t)
{
    if (t->larger / 5u > t->trusted / 4u) {
        trust(t);
        t->trusted = t->larger;
    }
}

/// Layer 1: one step of the drive's constants.
static void step_drive(cam_ilc_t *t, const cam_ilc_setup_t *s, int32_t gain_q16)
{
    if (!cam_ilc_update_is_for_drive(t)) {
        return;
    }
    follow_size(t);
    if (t->n_halved >= cam_ilc_update_most_halved) {
        return;
    }
    if (is_drive_sound(t)) {
        const cam_drive_change_t by = cam_drive_solve(&t->sums, t->turn_speed_q32);
        const int64_t k1 = (int64_t)by.k1_q16 * (gain_q16 >> t->n_halved) >> 16;
        const int64_t k2 = (int64_t)by.k2_q16 * (gain_q16 >> t->n_halved) >> 16;
        t->k1_q16 =
            (int32_t)cam_clamp_i64(t->k1_q16 + k1, -(int64_t)s->k1_most_q16, s->k1_most_q16);
        t->k2_q16 =
            (int32_t)cam_clamp_i64(t->k2_q16 + k2, -(int64_t)s->k2_most_q16, s->k2_most_q16);
    }
    t->blending |= cam_ilc_blend_drive;
}

/// The first turn of a rehearsal. At another speed nothing of the correction holds.
static void begin_rehearsal(cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    if (cam_ilc_update_is_other_speed(t, t->turn_speed_q32)) {
        const bool was_probed = t->correction.is_probed;
        cam_harmonic_correction_forget(&t->correction);
        t->blending |= cam_ilc_blend_correction;
        if (was_probed) {
            t->speed_q32 = t->turn_speed_q32;
            return;
        }
    }
    t->speed_q32 = t->turn_speed_q32;
    t->begun_nm = t->error_nm;
    cam_ilc_update_phase(t, t->correction.is_probed ? cam_ilc_shape : cam_ilc_drive);
    step_drive(t, s, s->gain_q16);
}

static void step_probe(cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    t->n_steps++;
    const int32_t size_q6 = t->n_steps == 1u ? s->probe_q6 / 2 : t->n_steps == 2u ? s->probe_q6 : 0;
    cam_harmonic_correction_play(&t->correction, size_q6, t->n_orders);
    t->blending |= cam_ilc_blend_correction;
    if (size_q6 == 0) {
        t->correction.is_probed = true;
        trust(t);
        cam_ilc_update_phase(t, cam_ilc_shape);
    }
}

/// A turn that counts is complete.
static void step(cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    t->error_nm = (uint32_t)(cam_root_u64(t->square) >> 6);
    t->largest = t->larger;
    t->n_turns++;
    switch ((cam_ilc_phase_t)t->phase) {
    case cam_ilc_settling:
        begin_rehearsal(t, s);
        break;
    case cam_ilc_drive:
        step_drive(t, s, s->gain_q16);
        t->n_steps++;
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
        step_drive(t, s, cam_ilc_update_gain_q16(t, s) / (t->correction.is_probed ? 2 : 1));
        t->n_steps = (uint8_t)(t->n_steps < UINT8_MAX ? t->n_steps + 1u : UINT8_MAX);
        t->best_square += t->best_square < UINT64_MAX / 2u ? t->best_square >> 4 : 0u;
        break;
    case cam_ilc_off:
    case cam_ilc_waiting:
    case cam_ilc_frozen:
    case cam_ilc_n_phases:
        break;
    }
}

static void finish_turn(cam_ilc_t *t, const cam_ilc_setup_t *s, cam_turn_bins_t *bins)
{
    t->bin = NULL;
    (void)cam_turn_bins_release(bins);
    if (t->is_counted) {
        step(t, s);
    }
    if (t->true_q36 > 0 &&
        cam_ripple_close(&t->ripple, s->ripple_turns, s->least_ripple_q32, t->true_q36)) {
        t->blending |= cam_ilc_blend_ripple;
    }
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

/// @return whether the interrupt has begun to write the bank again
static bool is_late(const cam_ilc_t *t, cam_turn_bins_t *bins)
{
    const uint32_t at_q8 = atomic_load_explicit(&bins->at_q8, memory_order_acquire);
    return ((at_q8 >> 8) & TURNS) != ((t->turn + 1u) & TURNS);
}

static void take_harmonic(cam_ilc_t *t, const cam_ilc_setup_t *s, cam_turn_bins_t *bins)
{
    if (is_late(t, bins)) {
        t->bin = NULL;
        cam_ripple_drop(&t->ripple);
        return;
    }
    if (t->is_counted && t->k <= t->n_orders) {
        cam_ilc_update_harmonic(t, s);
    }
    if (t->true_q36 > 0 && t->k > 0u) {
        cam_ripple_add(&t->ripple, t->k, cam_harmonics_of(&t->bin->angle_q24, words_per_bin, t->k));
    }
    t->k++;
    if (t->k >= cam_ilc_terms) {
        finish_turn(t, s, bins);
    }
}

void cam_ilc_poll(cam_ilc_t *t, const cam_ilc_setup_t *setup, cam_state_t state,
                  cam_turn_bins_t *bins)
{
    note_state(t, state);
    if (t->bin != NULL) {
        take_harmonic(t, setup, bins);
    } else {
        take_turn(t, setup, bins);
    }
}
