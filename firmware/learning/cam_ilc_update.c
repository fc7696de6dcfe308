// SPDX-License-Identifier: Apache-2.0
#include "cam_learning_inner.h"
#include "cam_doubles.h" // cam_limit, cam_nearest, cam_root
#include "cam_fix.h"     // cam_abs_i64

enum {
    ticks_per_order = 24,      ///< smallest period of a harmonic that is learned
    least_ticks_per_order = 9, ///< ... of an oval, whose harmonics are the first two
    oval_orders = 2,
    widest_gap = 8,            ///< [bins] from a tick to the next: a turn has at least 16 to 18
    rough_steps = 16,          ///< turns with the larger gain after the feed has changed
    rough_part = 64,           ///< the feed changes by more than this part
    even_part = 128,           ///< the spindle accelerates by more than this part per turn
    uniform_part = 1024,       ///< ... for the ripple, which a run-up would imitate
    least_scale_q30 = 1 << 27, ///< an eighth of the amplitude
    friction_part = 128, ///< U hardly moves in a harmonic whose speed is this part of the largest
    least_floors = 64,   ///< least motion of U, in noise floors of its scale
    frozen_percent = 2,  ///< largest deviation of the speed from that of the learning
    agreeing_turns = 2,  ///< after which learning goes on at another speed
    mode_part = 4, ///< responses at neighbouring harmonics that differ by this part show a mode
};

/// 3 / sqrt(12) sqrt(2), in 1 / 64: MATHS.md (148).
#define FLOOR_Q6 78.0

void cam_ilc_update_phase(cam_ilc_t *t, cam_ilc_phase_t phase)
{
    t->phase = phase;
    t->n_steps = 0;
}

void cam_ilc_update_restart_guards(cam_ilc_t *t)
{
    cam_harmonic_correction_restart_guard(&t->correction);
    t->best_square = UINT64_MAX;
    t->last_square = UINT64_MAX;
    t->is_paused = false;
    t->trusted = 0;
    t->n_halved = 0;
}

bool cam_ilc_update_is_other_speed(const cam_ilc_t *t, int32_t speed_q32)
{
    const int64_t off_q32 = cam_abs_i64((int64_t)speed_q32 - t->speed_q32);
    return off_q32 * 100 > (int64_t)t->speed_q32 * frozen_percent;
}

/// Convert the probed responses to another speed. Their ratio to the response of the drive's
/// constants is a function of the frequency, interpolated between the harmonics of the old speed.
/// Where it changes by more than a quarter, by a mode, the harmonic is masked.
static void adapt_responses(cam_ilc_t *t, const cam_ilc_setup_t *s, int32_t speed_q32)
{
    const int32_t k1_q16 = s->k1_q16 + t->drive.k1_q16;
    const int32_t k2_q16 = s->k2_q16 + t->drive.k2_q16;
    const cam_complex_t one = {.re = cam_gain_one_q12};
    cam_complex_t *gain = t->correction.gain;
    cam_complex_t ratio[cam_ilc_terms];
    for (uint32_t k = 1; k <= t->n_orders; k++) {
        const cam_complex_t model = cam_drive_gain(k, t->speed_q32, k1_q16, k2_q16);
        ratio[k] = cam_gain_ratio(gain[k], model);
    }
    for (uint32_t k = 1; k <= t->n_orders && t->n_orders > 1u; k++) {
        const int64_t place_q8 = (int64_t)k * speed_q32 * 256 / t->speed_q32;
        const int64_t within_q8 = cam_clamp_i64(place_q8, 256, (int64_t)t->n_orders * 256 - 1);
        const cam_complex_t a = ratio[within_q8 >> 8];
        const cam_complex_t by = cam_complex_sub(ratio[(within_q8 >> 8) + 1], a);
        const int64_t part_q8 = within_q8 & 255;
        const cam_complex_t between = {.re = a.re + (int32_t)(by.re * part_q8 / 256),
                                       .im = a.im + (int32_t)(by.im * part_q8 / 256)};
        const bool is_mode = cam_complex_square(by) * mode_part * mode_part > cam_complex_square(a);
        t->correction.masked |= is_mode ? UINT32_C(1) << k : 0u;
        const cam_complex_t model = cam_drive_gain(k, speed_q32, k1_q16, k2_q16);
        gain[k] = cam_gain_ratio(cam_gain_of(between, model), one);
    }
}

/// At another speed than that of the learning a cut stops learning until two turns agree, and then
/// continues from the values in force.
/// @param is_even  the spindle does not accelerate
static void follow_speed(cam_ilc_t *t, const cam_ilc_setup_t *s, int32_t speed_q32, bool is_even)
{
    const bool is_other = t->correction.is_probed && cam_ilc_update_is_other_speed(t, speed_q32);
    const bool is_frozen = t->phase == cam_ilc_frozen;
    if (is_other && is_frozen) {
        t->n_steps = (uint8_t)(is_even ? t->n_steps + 1u : 0u);
        if (t->n_steps >= agreeing_turns) {
            adapt_responses(t, s, speed_q32);
            t->speed_q32 = speed_q32;
            cam_ilc_update_restart_guards(t);
            cam_ilc_update_phase(t, cam_ilc_cutting);
        }
    } else if (is_other ? t->phase == cam_ilc_cutting : is_frozen) {
        cam_ilc_update_phase(t, is_other ? cam_ilc_frozen : cam_ilc_cutting);
    }
}

/// Interpolate the empty bins between two bins with ticks, n bins apart.
static void interpolate(cam_turn_bin_t *bin, uint32_t from, uint32_t n)
{
    const cam_turn_bin_t a = bin[from % cam_turn_bins_n];
    const cam_turn_bin_t b = bin[(from + n) % cam_turn_bins_n];
    for (uint32_t i = 1; i < n; i++) {
        cam_turn_bin_t *between = &bin[(from + i) % cam_turn_bins_n];
        between->error_q6 = (int32_t)(a.error_q6 + ((int64_t)b.error_q6 - a.error_q6) * i / n);
        between->u_nm = (int32_t)(a.u_nm + ((int64_t)b.u_nm - a.u_nm) * i / n);
    }
}

/// Fill the empty bins of a turn of few ticks, MATHS.md (190).
/// @return whether all gaps are narrow enough
static bool fill_gaps(cam_turn_bin_t *bin)
{
    uint32_t last = 0;
    while (last < cam_turn_bins_n && bin[last].n == 0) {
        last++;
    }
    const uint32_t end = last + cam_turn_bins_n;
    bool is_narrow = end < 2u * cam_turn_bins_n;
    for (uint32_t i = last + 1u; is_narrow && i <= end; i++) {
        if (bin[i % cam_turn_bins_n].n > 0) {
            is_narrow = i - last <= widest_gap;
            interpolate(bin, last, i - last);
            last = i;
        }
    }
    return is_narrow;
}

/// Convert sums to means. @return ticks of the turn, 0 when they are too few
static uint32_t take_means(cam_turn_bin_t *bin, bool *is_full)
{
    uint32_t n_ticks = 0;
    *is_full = true;
    for (uint32_t i = 0; i < cam_turn_bins_n; i++) {
        const int32_t n = bin[i].n;
        if (n > 0) {
            bin[i].error_q6 /= n;
            bin[i].u_nm /= n;
            n_ticks += (uint32_t)n;
        } else {
            *is_full = false;
        }
    }
    return *is_full || fill_gaps(bin) ? n_ticks : 0u;
}

/// @return harmonics that a turn of so many ticks resolves; an oval needs fewer ticks for its two
static uint32_t orders_of(uint32_t n_ticks)
{
    const uint32_t n = n_ticks / ticks_per_order;
    const uint32_t least = n_ticks / least_ticks_per_order;
    return n >= oval_orders ? n : least < oval_orders ? least : oval_orders;
}

/// Rotate the correction with the phase that the operator has set.
static void follow_phase(cam_ilc_t *t, uint32_t phase_q32)
{
    const uint32_t by_q32 = phase_q32 - t->phase_q32;
    if (cam_abs_i64((int32_t)by_q32) >= 1 << 20) {
        cam_harmonic_correction_rotate(&t->correction, 0u - by_q32);
        t->phase_q32 = phase_q32;
        t->blending |= cam_ilc_blend_correction;
    }
}

/// @return whether learning is active and U has settled since the last step
static bool is_learning(const cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    return cam_ilc_is_asked(s) && t->phase >= cam_ilc_settling && t->phase <= cam_ilc_cutting &&
           t->blending == 0u && ((t->turn - t->good_from) & CAM_ILC_TURNS) < CAM_ILC_TURNS / 2u;
}

static int32_t of_amplitude(const cam_ilc_t *t, double value)
{
    return cam_nearest(cam_limit(value * 0x1p30 / t->scale_q30, 0x1p29));
}

/// @return [nm / 64] 3 sigma of a harmonic's noise from scale and encoder counts, at least 1 nm
static uint32_t floor_q6(const cam_ilc_t *t, const cam_ilc_setup_t *s, uint32_t n_ticks)
{
    const double quantum_nm = s->scale_nm + t->largest / 64.0 * s->count_urad * 1e-6;
    return (uint32_t)of_amplitude(t, FLOOR_Q6 * quantum_nm / cam_root(n_ticks) + 64.0);
}

uint32_t cam_ilc_update_guarded_q6(const cam_ilc_t *t)
{
    const bool is_cutting = t->phase == cam_ilc_cutting;
    const uint32_t part_q6 = t->begun_nm * 64u / (is_cutting ? 16u : 1024u);
    return part_q6 > t->floor_q6 ? part_q6 : t->floor_q6;
}

static cam_ilc_reason_t hindrance_of(const cam_ilc_t *t, bool is_still, uint32_t n_ticks,
                                     const cam_turn_t *turn)
{
    if (turn->is_steady && turn->speed_q32 <= cam_turn_bins_least_q32) {
        return cam_ilc_slow_turn;
    }
    if (is_still && n_ticks == 0u) {
        return cam_ilc_fast_turn;
    }
    return t->n_halved >= cam_ilc_update_most_halved ? cam_ilc_diverged : cam_ilc_all;
}

/// Restart the count of steps when a changing feed changes the cutting force.
static void follow_feed(cam_ilc_t *t, const cam_turn_t *turn)
{
    const int32_t feed_nm = turn->z_end_nm - turn->z_begin_nm;
    const int64_t change_nm = cam_abs_i64(feed_nm) - cam_abs_i64(t->feed_nm);
    const bool is_other = cam_abs_i64(change_nm) * rough_part > cam_abs_i64(feed_nm);
    t->is_feed_rising = is_other && change_nm > 0;
    t->is_feed_falling = is_other && change_nm < 0;
    if (t->phase == cam_ilc_cutting && is_other) {
        t->n_steps = 0;
        cam_ilc_update_restart_guards(t);
    }
    t->feed_nm = feed_nm;
    t->z_nm = turn->z_end_nm;
}

/// @return [nm^2] mean square of the set-point about its mean: half the sum of its |U_k|^2
static int64_t motion_square(const cam_turn_bin_t *bin)
{
    int64_t mean_nm = 0;
    int64_t sum = 0;
    for (uint32_t i = 0; i < cam_turn_bins_n; i++) {
        mean_nm += bin[i].u_nm;
    }
    mean_nm /= cam_turn_bins_n;
    for (uint32_t i = 0; i < cam_turn_bins_n; i++) {
        sum += (bin[i].u_nm - mean_nm) * (bin[i].u_nm - mean_nm);
    }
    return sum / cam_turn_bins_n;
}

bool cam_ilc_update_is_for_drive(const cam_ilc_t *t)
{
    return t->set_square >= 0 && t->larger / least_floors > t->floor_q6;
}

/// @return the sense of a motion from one bin to the next; what moves by less than 4 nm stands
static int32_t sense_of(int32_t by_nm)
{
    return (by_nm > 3 ? 1 : 0) - (by_nm < -3 ? 1 : 0);
}

/// Replace the numbers of ticks by the sense in which U moves, the mean of both sides of a bin.
static void mark_sense(cam_turn_bin_t *bin)
{
    int32_t before = sense_of(bin[0].u_nm - bin[cam_turn_bins_n - 1].u_nm);
    for (uint32_t i = 0; i < cam_turn_bins_n; i++) {
        const int32_t after = sense_of(bin[(i + 1u) % cam_turn_bins_n].u_nm - bin[i].u_nm);
        bin[i].n = (before + after) * (1 << 19);
        before = after;
    }
}

void cam_ilc_update_begin(cam_ilc_t *t, const cam_ilc_setup_t *s, const cam_turn_t *turn)
{
    // While the amplitude rises the drive is learned, if it is not known.
    const bool is_rising = turn->scale_q30 > t->scale_q30 && !t->correction.is_probed;
    const bool is_for_drive =
        is_rising && (t->phase == cam_ilc_settling || t->phase == cam_ilc_drive);
    const bool is_still = turn->is_steady && turn->state == t->state &&
                          turn->scale_q30 >= least_scale_q30 && (turn->is_level || is_for_drive) &&
                          turn->speed_q32 > cam_turn_bins_least_q32;
    const int64_t change_q32 = (int64_t)turn->speed_q32 - t->turn_speed_q32;
    const bool is_even = cam_abs_i64(change_q32) * even_part < turn->speed_q32;
    follow_feed(t, turn);
    t->turn = turn->turn;
    t->is_level = turn->is_level;
    t->turn_speed_q32 = turn->speed_q32;
    t->scale_q30 = turn->scale_q30;
    t->k = 0;
    follow_phase(t, (uint32_t)turn->phase_q32);
    follow_speed(t, s, turn->speed_q32, is_even);
    bool is_full = false;
    const bool is_slow = turn->speed_q32 <= cam_turn_bins_least_q32;
    const uint32_t n_ticks = is_slow ? 0u : take_means(t->bin, &is_full);
    const uint32_t n_orders = orders_of(n_ticks);
    if (is_still) {
        t->n_orders = (uint8_t)(n_orders < s->n_harmonics ? n_orders : s->n_harmonics);
    }
    // The ripple needs no motion of U.
    const bool is_synced = turn->state != cam_state_off && turn->state != cam_state_homing &&
                           turn->state != cam_state_fault; // there the spindle brakes
    const bool is_uniform = cam_abs_i64(change_q32) * uniform_part < turn->speed_q32;
    if (!is_uniform) { // the drift of a mean is that of successive turns
        cam_ripple_drop(&t->ripple);
    }
    const bool has_ripple = is_full && is_uniform && turn->speed_q32 >= s->ripple_from_q32 &&
                            is_synced && n_ticks > 0u && s->ripple_turns > 0u;
    const int32_t every = (int32_t)turn->skip + 1;
    t->true_q36 = has_ripple ? cam_ripple_deviate(t->bin) / every : 0;
    const cam_ilc_reason_t hindrance = hindrance_of(t, is_still, n_ticks, turn);
    if (turn->is_steady || hindrance != cam_ilc_all) { // else that of the last steady turn
        t->hindrance = hindrance;
    }
    t->is_counted = is_still && t->n_orders > 0u && is_even && is_learning(t, s);
    if (t->is_counted) {
        t->square = 0;
        t->larger = 0;
        t->speed_nm = 0.0;
        t->acceleration_nm = 0.0;
        t->sums = (cam_drive_sums_t){0};
        t->set_square = -motion_square(t->bin);
        const uint32_t sum_q6 = cam_harmonic_correction_sum_q6(&t->correction);
        const uint32_t most_q6 = (uint32_t)s->most_q6;
        t->room_q6 = most_q6 > sum_q6 ? most_q6 - sum_q6 : 0u;
        t->floor_q6 = floor_q6(t, s, n_ticks);
        mark_sense(t->bin);
    }
}

/// @return a times a factor, at full amplitude
static cam_complex_t at_full(const cam_ilc_t *t, cam_complex_t a, double factor)
{
    return (cam_complex_t){.re = of_amplitude(t, a.re * factor),
                           .im = of_amplitude(t, a.im * factor)};
}

/// @return the error less that of the interpolation between two ticks, MATHS.md (145)
static cam_complex_t without_interpolation(const cam_ilc_t *t, const cam_ilc_setup_t *s,
                                           cam_complex_t error, cam_complex_t set)
{
    const double w = cam_drive_omega(t->k, t->turn_speed_q32);
    const double part = w * w * s->between_q16 * 0x1p-16;
    return (cam_complex_t){.re = error.re + cam_nearest(set.re * part),
                           .im = error.im + cam_nearest(set.im * part)};
}

static void update_layer1(cam_ilc_t *t, const cam_ilc_setup_t *s, cam_complex_t error,
                          cam_complex_t set, cam_complex_t raw)
{
    const uint32_t size = cam_complex_size(set) * t->k;
    const double speed_nm = size / 64.0 * cam_drive_omega(1, t->turn_speed_q32);
    t->larger = size > t->larger ? size : t->larger;
    t->speed_nm += speed_nm;
    t->acceleration_nm += speed_nm * cam_drive_omega(t->k, t->turn_speed_q32);
    // Use the response from the constants: in the probe U may have hardly moved, or stuck.
    const cam_complex_t gain = cam_drive_gain(t->k, t->turn_speed_q32, s->k1_q16 + t->drive.k1_q16,
                                              s->k2_q16 + t->drive.k2_q16);
    if (cam_complex_square(gain) >= (UINT32_C(1) << 24) / 25u) { // at least a fifth
        cam_drive_add(&t->sums, t->k, error, set, gain);
        if (size < t->largest / friction_part) {
            const cam_complex_t sense = cam_harmonics_of(&t->bin->n, cam_ilc_words_per_bin, t->k);
            cam_friction_add(&t->sums, raw, sense, gain);
        }
    }
}

bool cam_ilc_update_is_rough(const cam_ilc_t *t)
{
    return t->n_steps < rough_steps && !t->is_paused && cam_ilc_chip_is_cut(t);
}

int32_t cam_ilc_update_gain_q16(const cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    const bool is_settled = t->n_steps >= rough_steps || s->cut_gain_q16 == 0;
    const bool is_in_cut = t->phase == cam_ilc_cutting;
    return is_in_cut && is_settled ? s->cut_gain_q16 : s->gain_q16;
}

/// @return [2^-16] learning gain of layer 2: half on the large harmonics, on which layer 1 acts as
///         well; three quarters on the mean, which has no phase
static int32_t layer2_gain_q16(const cam_ilc_t *t, const cam_ilc_setup_t *s, cam_complex_t set)
{
    const int32_t gain_q16 = cam_ilc_update_gain_q16(t, s);
    if (t->k == 0u) {
        return gain_q16 > 0 ? 3 << 14 : 0;
    }
    const bool is_large = cam_complex_size(set) * t->k >= t->largest / 8u;
    if (is_large && cam_ilc_update_is_rough(t)) { // the change is the chip's
        return 0;
    }
    return is_large && !t->is_paused ? gain_q16 / 2 : gain_q16;
}

static void update_layer2(cam_ilc_t *t, const cam_ilc_setup_t *s, cam_complex_t error,
                          cam_complex_t set)
{
    if (t->phase == cam_ilc_probing) {
        cam_harmonic_correction_probe(&t->correction, t->n_steps, t->k, error);
        return;
    }
    const bool is_cut = t->phase == cam_ilc_cutting;
    if (t->k == 0u && t->is_feed_rising && cam_ilc_chip_is_cut(t)) {
        cam_ilc_chip_step_mean(t, error.re, s->depth_nm, layer2_gain_q16(t, s, set));
        t->blending |= cam_ilc_blend_drive;
        return;
    }
    if (t->correction.is_probed && (is_cut || t->phase == cam_ilc_shape)) {
        const bool is_calm =
            cam_harmonic_correction_learn(&t->correction, t->k, error, cam_ilc_update_guarded_q6(t),
                                          layer2_gain_q16(t, s, set), &t->room_q6);
        if (is_cut && is_calm) {
            cam_harmonic_correction_age(&t->correction, t->k);
        }
        t->blending |= cam_ilc_blend_correction;
    }
}

void cam_ilc_update_harmonic(cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    const cam_complex_t raw = cam_harmonics_of(&t->bin->error_q6, cam_ilc_words_per_bin, t->k);
    const cam_complex_t set_nm = cam_harmonics_of(&t->bin->u_nm, cam_ilc_words_per_bin, t->k);
    const cam_complex_t set = at_full(t, set_nm, 64.0);
    const cam_complex_t error = without_interpolation(t, s, at_full(t, raw, 1.0), set);
    t->mean_nm = t->k == 0u ? set_nm.re : t->mean_nm;
    t->square += cam_complex_square(error) >> (t->k > 0u ? 1u : 0u);
    if (t->k > 0u) {
        t->set_square += (int64_t)cam_complex_square(set_nm);
        update_layer1(t, s, error, set, raw);
    }
    update_layer2(t, s, error, set);
}
