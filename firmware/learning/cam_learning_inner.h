// SPDX-License-Identifier: Apache-2.0
/// cam_learning_inner: the steps of learning, private to this room.
///
/// From the bottom up: complex numbers, harmonics of a turn, the update of the drive's
/// constants (layer 1), of the correction at each harmonic (layer 2), of the chip's force and of
/// the ripple; then the update of a turn, which uses all of them. Context of all functions:
/// slow side.
#ifndef CAM_LEARNING_INNER_H
#define CAM_LEARNING_INNER_H

#include "cam_doubles.h"  // cam_nearest, cam_root, CAM_PI
#include "cam_fix.h"      // cam_sat_i32
#include "cam_learning.h" // cam_ilc_t, cam_complex_t
#include "cam_record.h"   // cam_turn_bin_t, cam_turn_t, cam_learned_t
#include "cam_state.h"    // cam_state_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int16_t, int32_t, int64_t, uint32_t, uint64_t

/// Complex numbers. Source: MATHS.md (140).

enum { cam_gain_one_q12 = 1 << 12 };

/// The parts of sums and differences must fit int32.
static inline cam_complex_t cam_complex_add(cam_complex_t a, cam_complex_t b)
{
    return (cam_complex_t){.re = a.re + b.re, .im = a.im + b.im};
}

static inline cam_complex_t cam_complex_sub(cam_complex_t a, cam_complex_t b)
{
    return (cam_complex_t){.re = a.re - b.re, .im = a.im - b.im};
}

static inline uint64_t cam_complex_square(cam_complex_t a)
{
    return (uint64_t)((int64_t)a.re * a.re) + (uint64_t)((int64_t)a.im * a.im);
}

/// @return |a|, rounded down, at most 3 037 000 499
static inline uint32_t cam_complex_size(cam_complex_t a)
{
    return (uint32_t)cam_root((double)cam_complex_square(a));
}

/// @return a g, saturated
static inline cam_complex_t cam_gain_of(cam_complex_t a, cam_complex_t g)
{
    return (cam_complex_t){
        .re = cam_sat_i32(((int64_t)a.re * g.re - (int64_t)a.im * g.im) >> 12),
        .im = cam_sat_i32(((int64_t)a.re * g.im + (int64_t)a.im * g.re) >> 12),
    };
}

/// @return (re + j im) / by as a transfer function, limited to +-7.99; 0 when by is 0
static inline cam_complex_t cam_gain_divided(double re, double im, double by)
{
    const double unit = by > 0.0 ? cam_gain_one_q12 / by : 0.0;
    return (cam_complex_t){.re = cam_nearest(cam_limit(re * unit, INT16_MAX)),
                           .im = cam_nearest(cam_limit(im * unit, INT16_MAX))};
}

/// @return a / b, likewise
static inline cam_complex_t cam_gain_ratio(cam_complex_t a, cam_complex_t b)
{
    return cam_gain_divided((double)a.re * b.re + (double)a.im * b.im,
                            (double)a.im * b.re - (double)a.re * b.im,
                            (double)cam_complex_square(b));
}

/// Harmonics of the bins of a turn, and points of a turn from harmonics.
///
///     c_k  = (2 / 128) sum m_i e^(-jk theta_i)   theta_i the middle of bin i; c_0 is the mean
///     f(i) = Re sum c_k e^(jk 2 pi i / 256)      i = 0 .. 256, c_0 real
///
/// Both use the same 256 angles, so angles are exact. Source: MATHS.md (140).

/// @return cosine and sine of 2 pi step / 256
int32_t cam_cos_q24(uint32_t step);
int32_t cam_sin_q24(uint32_t step);

/// @param mean    of the first of 128 bins
/// @param stride  [words] from a bin to the next
/// @return        harmonic k, 0 .. 63, in the unit of the means, rounded, saturated
cam_complex_t cam_harmonics_of(const int32_t *mean, uint32_t stride, uint32_t k);

/// Move the points of a turn towards a sum of harmonics, each by at most one step.
/// @param point  258 of them, changed in place, the last two equal to the first two
/// @param c      harmonics 0 .. 16, parts within +-2^23, the sum of their magnitudes below 2^24
/// @param down   1 .. 24; a point is the sum / 2^down, within +-32767
/// @param most   largest change of a point, above 0
/// @return       whether all points have reached their targets
bool cam_harmonics_slew(int16_t *point, const cam_complex_t *c, uint32_t down, int32_t most);

/// Layer 1: update of the drive's constants from the error of a turn. With the error E_k and
/// the set-point U_k of harmonic k, and U's response G_k to a correction according to the
/// constants:
///     E_k / (U_k G_k) = j w_k dk1 - w_k^2 dk2, weighted least squares over all k
/// Source: MATHS.md (141) .. (144).

/// @return [rad per tick] angular frequency of harmonic k
static inline double cam_drive_omega(uint32_t k, int32_t speed_q32)
{
    return 2.0 * CAM_PI * k * speed_q32 * 0x1p-32;
}

/// @param speed_q32  [turn / 2^32 per tick], above 0
/// @return           U's response at harmonic k by the constants, 1 / (1 + j w k1 - w^2 k2)
cam_complex_t cam_drive_gain(uint32_t k, int32_t speed_q32, int32_t k1_q16, int32_t k2_q16);

/// @param error, set  [nm / 64] error and set-point of harmonic k, 1 .. 16
void cam_drive_add(cam_drive_sums_t *sums, uint32_t k, cam_complex_t error, cam_complex_t set,
                   cam_complex_t gain);

/// Add a harmonic in which U hardly moves to the sums of the friction.
/// @param error_q6   [nm / 64] not divided by the amplitude
/// @param sense_q20  harmonic of the sense in which U moves, 2^20 is 1
void cam_friction_add(cam_drive_sums_t *sums, cam_complex_t error_q6, cam_complex_t sense_q20,
                      cam_complex_t gain);

/// @return change of the constants that removes the error of the turn in a linear drive
cam_drive_t cam_drive_solve(const cam_drive_sums_t *sums, int32_t speed_q32);

/// Layer 2: correction of U's command over the spindle's angle, one harmonic at a time.
///
/// Two probes of different size give U's response G to a correction. A harmonic at which U responds
/// weakly or not in proportion is masked, until a larger probe agrees with the one before. Then c
/// <- c + mu E / G. For each harmonic but the mean, the smallest error is kept with its correction;
/// an error 1.5 times as large, and above the noise floor, restores that correction and halves mu,
/// and the fourth time masks the harmonic. The correction is for full amplitude. Source: MATHS.md
/// (142) .. (144).

void cam_harmonic_correction_forget(cam_harmonic_correction_t *s);

/// Forget the smallest errors, because the cutting conditions have changed.
void cam_harmonic_correction_restart_guard(cam_harmonic_correction_t *s);

/// Replace the correction by a probe, p e^(j pi k^2 / n) at harmonic k: its crest factor is low.
/// @param size_q6  [nm / 64] p; 0 ends the probe
/// @param n        harmonics, 1 .. 16
/// @param which    bit k: harmonic k is probed
void cam_harmonic_correction_set_probe(cam_harmonic_correction_t *s, int32_t size_q6, uint32_t n,
                                       uint32_t which);

/// @param stage  0: no probe, 1: first probe, 2: second probe, which masks; later ones unmask
/// @param error_q6  [nm / 64] of harmonic k at full amplitude
void cam_harmonic_correction_probe(cam_harmonic_correction_t *s, uint32_t stage, uint32_t k,
                                   cam_complex_t error_q6);

/// @param error_q6  [nm / 64] at full amplitude
/// @param floor_q6  [nm / 64] noise floor of the scale
/// @param mu_q16    learning gain, 0 .. 2^16
/// @param room_q6   [nm / 64] by which the sum of sizes may still grow; a change that does not
///                  fit is scaled down. What it uses is subtracted
/// @return whether the error has not grown since the last turn
bool cam_harmonic_correction_learn(cam_harmonic_correction_t *s, uint32_t k, cam_complex_t error_q6,
                                   uint32_t floor_q6, int32_t mu_q16, uint32_t *room_q6);

/// Raise the smallest error by a sixteenth: in the cut the conditions drift. Not for an error that
/// grows, because learning may diverge.
void cam_harmonic_correction_age(cam_harmonic_correction_t *s, uint32_t k);

/// @param part_q16  0 .. 2^16
void cam_harmonic_correction_scale(cam_harmonic_correction_t *s, uint32_t part_q16);

/// Take back the correction of the smallest error.
void cam_harmonic_correction_restore(cam_harmonic_correction_t *s);

uint32_t cam_harmonic_correction_sum_q6(const cam_harmonic_correction_t *s);

void cam_harmonic_correction_rotate(cam_harmonic_correction_t *s, uint32_t angle_q32);

/// Chip: feed-forward of the chip's radial force, learned in the cut.
///
///     added to U's command = feed (A (u - m) + B (D + m))
///
/// On a cylindrical blank the depth of cut is D + u: u is U's set-point, m its mean, D the depth
/// where it is 0. The rehearsal has no chip, so what differs in the cut is the chip's. Where U is a
/// spring, A and B are the same; a position loop with an integral leaves less of the mean, so B is
/// limited to 0 .. A. Source: MATHS.md (149).

/// [nm] Feed to which the learned deflection by the chip refers.
enum { cam_ilc_chip_feed_nm = 250000 };

/// @return whether the turn being processed has a chip to learn from: it is cut after a rehearsal,
///         with a feed of at least 1.5 um that does not fall
bool cam_ilc_chip_is_cut(const cam_ilc_t *t);

/// Learn A. @param share_q32  [1] the error of the turn as a share of the set-point
void cam_ilc_chip_step(cam_ilc_t *t, int32_t share_q32, int32_t gain_q16);

/// Learn B.
/// @param error_q6  [nm / 64] mean error of the turn
/// @param depth_nm  [nm] D
void cam_ilc_chip_step_mean(cam_ilc_t *t, int32_t error_q6, int32_t depth_nm, int32_t gain_q16);

/// Notice gaps in the material, once per turn that is learned from: in the cut an error that
/// doubles in a turn, which learning cannot do, is not the drive's. Layer 1 pauses until layer 2
/// has removed it.
void cam_ilc_chip_follow_gap(cam_ilc_t *t);

void cam_ilc_chip_follow(cam_ilc_t *t, cam_state_t state, const cam_turn_bins_t *bins);

/// @return whether the feed differs from that for which A and B are in force
bool cam_ilc_chip_is_due(const cam_ilc_t *t);

/// Move the values in force towards those of the present feed.
/// @param depth_nm  [nm] D
/// @param most_nm   largest change of U's command
/// @return          whether they have reached them
bool cam_ilc_chip_blend(cam_ilc_t *t, int32_t depth_nm, int32_t most_nm, cam_learned_t *in);

/// Ripple: deviation of the spindle from uniform rotation, learned over its angle.
///
/// The deviation of a turn is the measured angle minus that of a uniform rotation of the same
/// duration, by the ticks in each bin. The mean over several turns is the ripple that the
/// encoder shows, its own eccentricity included, which is a parameter. Nothing is fed back.
/// Source: MATHS.md (146).

/// [turn / 2^32] in a unit of the interrupt's tables, 2^-23 turn: 2^9.
enum { cam_ripple_down = 9 };

/// [turn / 2^23] limit of the sum of the orders' sizes: 12 mrad.
enum { cam_ripple_most = INT16_MAX / 2 };

/// Convert the sums of angle of a turn to the deviation from uniform rotation, in place.
/// @param bin  128 bins of a turn, each with its sum of angle_q24 and n; angle becomes the
///             deviation in turn / 2^32, less a constant
/// @return     [turn / 2^36 per tick] mean speed; 0 where a bin is empty or the deviation is too
///             large: the turn must be discarded
int32_t cam_ripple_deviate(cam_turn_bin_t *bin);

void cam_ripple_add(cam_ripple_t *r, uint32_t k, cam_complex_t angle_q32);

/// Complete a turn. The drift of the speed from the first to the last turn of a mean is subtracted.
/// @param n_turns    turns in a mean
/// @param least_q32  [turn / 2^32] an order up to this size counts as 0
/// @param speed_q36  result of cam_ripple_deviate()
/// @return whether there is a new mean
bool cam_ripple_close(cam_ripple_t *r, uint32_t n_turns, int32_t least_q32, int32_t speed_q36);

void cam_ripple_drop(cam_ripple_t *r);

/// @return [turn / 2^32] order k of the mean
cam_complex_t cam_ripple_order(const cam_ripple_t *r, uint32_t k);

/// @return [turn / 2^23] sum of the orders' sizes; beyond cam_ripple_most all are scaled down to it
///         before they act
uint32_t cam_ripple_sum(const cam_ripple_t *r);

/// Update of one turn, harmonic by harmonic.

/// @return whether U is learned: completely, or with lobes the drive's constants
static inline bool cam_ilc_is_asked(const cam_ilc_setup_t *setup)
{
    return setup->reason == cam_ilc_all || setup->reason == cam_ilc_lobes;
}

enum {
    cam_ilc_update_most_halved = 4, ///< halvings of the gain after which layer 1 stops
    cam_ilc_words_per_bin = sizeof(cam_turn_bin_t) / sizeof(int32_t),
};

#define CAM_ILC_TURNS UINT32_C(0xFFFFFF) ///< turns are numbered modulo 2^24

void cam_ilc_update_phase(cam_ilc_t *t, cam_ilc_phase_t phase);

void cam_ilc_update_restart_guards(cam_ilc_t *t);

/// @return whether a speed differs from that of the learning by more than 2 %
bool cam_ilc_update_is_other_speed(const cam_ilc_t *t, int32_t speed_q32);

/// @return [nm / 64] error of a harmonic below which the guard does not compare: 3 sigma, or 1/1024
///         of the initial error, in the cut 1/16, where the cutting conditions drift
uint32_t cam_ilc_update_guarded_q6(const cam_ilc_t *t);

/// @return [2^-16] learning gain: the rehearsal's, also in the cut until some turns after the feed
///         has changed; then the cut's, in the whole cut where that is 0
int32_t cam_ilc_update_gain_q16(const cam_ilc_t *t, const cam_ilc_setup_t *s);

/// @return whether the turn is cut with a chip while its feed changes, or soon after
bool cam_ilc_update_is_rough(const cam_ilc_t *t);

/// @return whether layer 1 may learn from a turn: the learned harmonics hold most of U's motion, so
///         that the rest stays observed, and the motion is large for the scale
bool cam_ilc_update_is_for_drive(const cam_ilc_t *t);

/// Classify the turn in t->bin and convert its sums to means; then learn from each harmonic t->k.
void cam_ilc_update_begin(cam_ilc_t *t, const cam_ilc_setup_t *s, const cam_turn_t *turn);
void cam_ilc_update_harmonic(cam_ilc_t *t, const cam_ilc_setup_t *s);

/// Move a value towards its target by at most `most`. @return whether it has reached it
bool cam_ilc_slew(int32_t *value, int64_t target, int64_t most);

#endif
