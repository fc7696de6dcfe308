// SPDX-License-Identifier: Apache-2.0
/// cam_learning: iterative learning control of U, and learning of the spindle's ripple.
///
///     turn closed by the interrupt -> harmonics -> probing, layers 1 and 2, ripple -> target
///     -> blending in
///
/// A rehearsal settles, learns the drive's constants (layer 1), probes U's response at every
/// harmonic, then removes the remaining error (layer 2). The cut continues both with a small
/// learning gain. Learned values are kept between parts and can be read and set by index.
///
/// Read phases and reasons first, then status, values and settings, and the functions from
/// cam_ilc_poll() on; cam_ilc_t with its parts is the state. cam_learning_inner.h has the steps.
/// Equations and stability: MATHS.md (140) .. (146). Context of all functions: slow side, one
/// caller.
#ifndef CAM_LEARNING_H
#define CAM_LEARNING_H

#include "cam_record.h" // cam_turn_bins_t, cam_learned_t
#include "cam_state.h"  // cam_state_t
#include <stdbool.h>    // bool
#include <stddef.h>     // NULL
#include <stdint.h>     // int16_t, int32_t, uint32_t

/// Largest number of harmonics that are learned; the mean is one more.
enum { cam_ilc_harmonics = 16, cam_ilc_terms = cam_ilc_harmonics + 1 };

/// [nm] Limit of the sum of all corrections, within the range of a table's point; and of the
/// friction.
enum { cam_ilc_most_nm = 30000 };

typedef enum {
    cam_ilc_off,      ///< cam_ilc_reason_t says why
    cam_ilc_waiting,  ///< for a rehearsal, or for turns in which nothing moves
    cam_ilc_settling, ///< rehearsal: the first whole turns
    cam_ilc_drive,    ///< rehearsal: layer 1, the drive's constants
    cam_ilc_probing,  ///< rehearsal: U's response at each harmonic
    cam_ilc_shape,    ///< rehearsal: layers 1 and 2
    cam_ilc_cutting,  ///< in the cut: both with small gains
    cam_ilc_frozen,   ///< learned values stay in force until the new speed is steady
    cam_ilc_n_phases
} cam_ilc_phase_t;

/// Why learning is off or incomplete.
typedef enum {
    cam_ilc_all,          ///< learning is complete
    cam_ilc_not_asked,    ///< learn_harmonics is 0, or no gain is set
    cam_ilc_not_measured, ///< the port does not measure U
    cam_ilc_no_table,     ///< no table is in use
    cam_ilc_modulated,    ///< the table modulates the speed of the spindle
    cam_ilc_slow_turn,    ///< a turn has more ticks than the bins can sum
    cam_ilc_fast_turn,    ///< a turn has too few ticks for one harmonic
    cam_ilc_lobes,        ///< on a shaft with lobes only the drive's constants are learned
    cam_ilc_diverged,     ///< layer 1 has stopped, with its best constants in force
    cam_ilc_rippled,      ///< the ripple of the spindle is compensated for in part only
    cam_ilc_limited,      ///< a correction has reached its limit, or the end of U's stroke
    cam_ilc_slow_loop,    ///< U's loop crosses over below twice the second harmonic of the turn
    cam_ilc_n_reasons
} cam_ilc_reason_t;

typedef struct {
    cam_ilc_phase_t phase;
    cam_ilc_reason_t reason;
    uint32_t n_turns;             ///< turns used since the rehearsal began
    uint32_t n_harmonics;         ///< learned besides the mean, 0 .. 16
    uint32_t masked;              ///< bit k: harmonic k is not learned
    int32_t k1_ns;                ///< added to the parameter k1_ns
    int32_t k2_us2;               ///< added to the parameter k2_us2
    int32_t friction_nm;          ///< added to the parameter u_friction_nm
    int32_t chip_nm_per_mm2;      ///< deflection of U by a chip of 1 mm2, as its depth changes
    int32_t chip_mean_nm_per_mm2; ///< by its mean, which a loop with an integral removes
    uint32_t error_nm;       ///< rms of the last turn's error in the harmonics that are learned
    uint32_t begin_error_nm; ///< ... before learning
    uint32_t correction_nm;  ///< sum of the magnitudes of the correction
    uint32_t speed_mrpm;     ///< [r/min / 1000] speed of the learning, 0: never
    uint32_t ripple_turns;   ///< turns in the mean of the ripple in force
    uint32_t ripple_nturn;   ///< [turn / 10^9] sum of its amplitudes
} cam_ilc_status_t;

/// A complex number in fixed point. Of a transfer function of U, a gain, 2^12 is 1.
typedef struct {
    int32_t re, im;
} cam_complex_t;

/// Constants of U's drive, or their changes.
typedef struct {
    int32_t k1_q16;      ///< [ticks]
    int32_t k2_q16;      ///< [ticks^2]
    int32_t friction_q6; ///< [nm / 64]
    int32_t chip_q32;    ///< [1] U's deflection at 1/4 mm of feed, as a share of the depth
} cam_drive_t;

typedef struct {
    cam_complex_t correction_q6; ///< [nm / 64] in force: Re(c e^(jk theta)) is added to the command
    cam_complex_t gain;          ///< response of U to it, as probed; 0: not probed
    uint32_t best_q6;            ///< [nm / 64] smallest error so far
    cam_complex_t ripple;        ///< [turn / 2^32] of the spindle's angle
    bool is_masked;
} cam_ilc_harmonic_t;

/// Index of the learned values: speed [turn / 2^32 per tick], k1 [ticks / 2^16],
/// k2 [ticks^2 / 2^16], masks with bit 30 for "probed", phase [turn / 2^32]; then for k = 0 .. 16
/// real and imaginary part of the correction [nm / 64] and of U's response [1 / 4096], for
/// k = 1 .. 16 of the ripple that the encoder shows [turn / 2^23]; the friction [nm / 64];
/// U's deflection by the chip at 1/4 mm of feed, as a share of the depth of cut [2^-32], and the
/// same of their means.
enum {
    cam_ilc_value_speed,
    cam_ilc_value_k1,
    cam_ilc_value_k2,
    cam_ilc_value_masked,
    cam_ilc_value_phase,
    cam_ilc_value_correction,
    cam_ilc_value_gain = cam_ilc_value_correction + 2 * cam_ilc_terms,
    cam_ilc_value_ripple = cam_ilc_value_gain + 2 * cam_ilc_terms,
    cam_ilc_value_friction = cam_ilc_value_ripple + 2 * cam_ilc_harmonics,
    cam_ilc_value_chip,
    cam_ilc_value_chip_mean,
    cam_ilc_n_values
};

/// Settings of learning from parameters, table and machine; set up for each call.
typedef struct {
    cam_ilc_reason_t reason;        ///< cam_ilc_lobes, or why U is not learned
    uint32_t n_harmonics;           ///< 0 .. 16
    int32_t gain_q16, cut_gain_q16; ///< learning gain of rehearsal and cut
    int32_t probe_q6;               ///< [nm / 64]
    uint32_t ripple_turns;          ///< 0: the ripple is not learned
    int32_t scale_nm;               ///< [nm] quantum of U's scale
    int32_t least_ripple_q32; ///< [turn / 2^32] smallest order of the ripple above the quantisation
    int32_t count_urad;       ///< [urad] a count of the encoder
    int32_t most_q6;          ///< [nm / 64] limit of the sum of the corrections
    int32_t k1_q16, k2_q16;   ///< configured constants of the drive, in ticks
    int32_t k1_least_q16, k1_most_q16; ///< limits of the learned change of k1
    int32_t k2_least_q16, k2_most_q16; ///< ... of k2
    int32_t friction_q6;               ///< [nm / 64] configured one
    int32_t depth_nm;                  ///< [nm] of the cut where U is 0, on a cylindrical blank
    int32_t between_q16;        ///< [ticks^2] f (1 - f) / 2: the due time is f between two ticks
    bool is_u_moving;           ///< U moves: while not cutting its constants stay
    int32_t angle_step_q23;     ///< [turn / 2^23] largest step of an angle that U can follow, >= 1
    int32_t ripple_from_q32;    ///< [turn / 2^32 per tick] speed from which the ripple is learned
    int32_t observer_step_q23;  ///< ... by which the observed speed wavers by 0.2 % at most, >= 1
    cam_complex_t eccentricity; ///< [turn / 2^32] order 1 of the encoder's own error
} cam_ilc_setup_t;

/// Sums of layer 1 over the harmonics of a turn.
typedef struct {
    double error1, weight1, error2, weight2;
    double error0, weight0;   ///< of the chip's force
    double error_f, weight_f; ///< of the friction
} cam_drive_sums_t;

/// Correction of U's command, made by cam_harmonic_correction_forget().
typedef struct {
    cam_complex_t c_q6[cam_ilc_terms];    ///< [nm / 64] the correction
    cam_complex_t kept_q6[cam_ilc_terms]; ///< [nm / 64] correction of the smallest error; while
                                          ///< probing the error without a probe; in whole nm
    uint32_t best_q6[cam_ilc_terms];      ///< [nm / 64] the smallest error, UINT32_MAX: none
    uint32_t last_q6[cam_ilc_terms];      ///< [nm / 64] last error, UINT32_MAX: of a new cause
    cam_complex_t gain[cam_ilc_terms];    ///< response G of U
    uint8_t n_halved[cam_ilc_terms];      ///< times that mu was halved
    uint32_t masked;                      ///< bit k
    bool is_probed;
} cam_harmonic_correction_t;

/// Ripple of the spindle; zero-initialised has learned nothing.
typedef struct {
    cam_complex_t sum[cam_ilc_harmonics]; ///< [turn / 2^32] of orders 1 .. 16, over n turns
    cam_complex_t
        mean[cam_ilc_harmonics]; ///< [turn / 2^23] ripple in force, as the encoder shows it
    int32_t first_q36;           ///< [turn / 2^36 per tick] speed of the first turn of the sum
    int32_t last_q36;            ///< ... and of the last one
    uint32_t n;                  ///< turns in the sum
    uint32_t n_mean;             ///< turns in the mean, 0: none
} cam_ripple_t;

/// Learned values that are blended in.
enum {
    cam_ilc_blend_drive = 1,
    cam_ilc_blend_correction = 2,
    cam_ilc_blend_ripple = 4,
    cam_ilc_blend_all = 7
};

/// State; kept between parts.
typedef struct {
    cam_harmonic_correction_t correction;
    cam_ripple_t ripple;
    cam_drive_sums_t sums;  ///< of the turn being processed
    uint64_t square;        ///< [(nm / 64)^2] sum of that turn's squared errors over the harmonics
    uint64_t last_square;   ///< ... of the turn before
    uint64_t calm_square;   ///< ... at which a pause of layer 1 ends
    uint64_t best_square;   ///< ... smallest since layer 1 started
    cam_turn_bin_t *bin;    ///< the turn being processed; NULL: none
    uint32_t begun_nm;      ///< [nm] rms error before learning
    uint32_t error_nm;      ///< [nm] of the last turn
    double speed_nm;        ///< [nm per tick] sum of w_k |U_k|
    double acceleration_nm; ///< [nm per tick^2] sum of w_k^2 |U_k|
    uint32_t largest;       ///< [nm / 64] largest k |U_k| of the last turn
    uint32_t larger;        ///< ... of this turn so far
    int64_t set_square;     ///< [nm^2] sum of |U_k|^2 less the mean square of the whole motion
    uint32_t trusted;       ///< [nm / 64] largest k |U_k| to which the guard's best applies
    uint32_t floor_q6;      ///< [nm / 64] 3 sigma of the scale in a harmonic of this turn
    uint32_t room_q6;       ///< [nm / 64] by which corrections may still grow in this turn
    cam_drive_t drive;      ///< added to the configured constants
    cam_drive_t best;       ///< ... those with the smallest error
    int32_t chip_mean_q32;  ///< [1] mean deflection by the chip, a share of the mean depth
    int32_t mean_nm;        ///< [nm] mean of the set-point in the last turn that was learned from
    int32_t chip_most_q32;  ///< [1] limit of the shares in force
    int32_t feed_now_nm;    ///< [nm] present feed per turn, 0 outside the cut
    int32_t chip_feed_nm;   ///< [nm] feed for which both are in force
    int32_t speed_q32;      ///< [turn / 2^32 per tick] speed of the learning, 0: never
    int32_t turn_speed_q32; ///< ... of the turn being processed
    int32_t scale_q30;      ///< [1] amplitude of that turn
    uint32_t phase_q32;     ///< [turn / 2^32] by which the correction is rotated
    uint32_t turn;          ///< its number, modulo 2^24
    uint32_t good_from;     ///< number of the first turn that may be learned from
    uint32_t n_turns;       ///< used for learning since the rehearsal began
    int32_t feed_nm;        ///< [nm] of the last turn
    bool is_feed_rising, is_feed_falling; ///< from the turn before it
    int32_t z_nm;                         ///< [nm] height at its end
    uint8_t k;                            ///< next harmonic
    uint8_t n_orders;                     ///< ... that the last steady turn resolved
    uint8_t n_steps;                      ///< steps of this phase
    bool is_paused;                       ///< layer 1, because of a disturbance
    bool is_level;                        ///< the amplitude stood still in the turn
    bool is_limited;  ///< a learned value has reached a limit, in the last turn or the cut
    uint8_t n_halved; ///< times that the guard halved the gain of layer 1
    cam_ilc_phase_t phase;
    cam_state_t state;
    cam_ilc_reason_t hindrance; ///< of the last turn
    bool is_counted;            ///< this turn is used to learn U
    int32_t true_q36; ///< [turn / 2^36 per tick] its speed if it is used for the ripple, else 0
    uint32_t at_q8;   ///< [turn / 256] position at the last call of cam_ilc_poll()
    uint8_t blending; ///< cam_ilc_blend_*: learned values not completely in force
    uint32_t blend_from_q8; ///< [turn / 256] earliest time of the next step of points
} cam_ilc_t;

void cam_ilc_init(cam_ilc_t *t);

/// One piece of work: follow the state, fetch a turn from the interrupt or process one harmonic.
/// @param bins  of the interrupt
void cam_ilc_poll(cam_ilc_t *t, const cam_ilc_setup_t *setup, cam_state_t state,
                  cam_turn_bins_t *bins);

/// @param at_q8  [turn / 256] position of the spindle, which the interrupt writes once per plan
/// @return       whether cam_ilc_poll() or cam_ilc_blend() may have something to do
static inline bool cam_ilc_is_due(const cam_ilc_t *t, cam_state_t state, uint32_t at_q8)
{
    return t->bin != NULL || t->blending != 0u || t->state != state || t->at_q8 != at_q8;
}

/// @return whether nothing is blended in, and nothing learned depends on the feed
static inline bool cam_ilc_is_idle(const cam_ilc_t *t)
{
    return t->blending == 0u && t->drive.chip_q32 == 0 && t->chip_mean_q32 == 0;
}

/// @return whether cam_ilc_blend() has something to do. Points are computed at most 25 times a
///         turn, which bounds the processor load of learning.
bool cam_ilc_is_blending(const cam_ilc_t *t, uint32_t at_q8);

/// Blend one step from the values in force to the learned values. A step moves each point of the
/// correction, and the command through the constants, by at most 1000 nm (50 nm in the cut), and
/// each angle by at most 100 urad (10 urad in the cut) and by what U can follow.
void cam_ilc_blend(cam_ilc_t *t, const cam_ilc_setup_t *setup, uint32_t at_q8, cam_learned_t *in);

/// Reduce the learned k1 and k2 by an eighth, because U's command would leave its stroke.
/// @return whether there is more to reduce
bool cam_ilc_shrink(cam_ilc_t *t);

/// @param deep_nm  [nm] largest depth of cut
/// @return [nm] stroke of U that the corrections want, while the feed grows by a quarter
int64_t cam_ilc_wanted_nm(const cam_ilc_t *t, int64_t deep_nm);

/// Scale the corrections down to what U's stroke leaves beside its set-point and feed-forward, and
/// limit that of the chip to the rest.
/// @param spare_nm  [nm] what the stroke leaves, at least 0
/// @param deep_nm   [nm] largest depth of cut
void cam_ilc_fit(cam_ilc_t *t, int64_t spare_nm, int64_t deep_nm);

/// Discard what was learned of U, because its configuration has changed; the ripple stays.
void cam_ilc_forget(cam_ilc_t *t);

cam_ilc_status_t cam_ilc_status(const cam_ilc_t *t, const cam_ilc_setup_t *setup, uint32_t tick_hz);

/// @param k  0 .. cam_ilc_harmonics; all 0 beyond
cam_ilc_harmonic_t cam_ilc_harmonic(const cam_ilc_t *t, uint32_t k);

/// @param index  cam_ilc_value_*
/// @return       learned value, 0 beyond the last; set: whether index and value are in range
int32_t cam_ilc_get(const cam_ilc_t *t, uint32_t index);
bool cam_ilc_set(cam_ilc_t *t, uint32_t index, int32_t value);

/// @return c e^(jk angle), relative error up to 8e-5
cam_complex_t cam_harmonics_rotated(cam_complex_t c, uint32_t k, uint32_t angle_q32);

#endif
