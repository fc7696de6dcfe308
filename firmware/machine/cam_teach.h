// SPDX-License-Identifier: Apache-2.0
/// cam_teach: the slow side of learning: what the drive of U and the spindle do otherwise than
/// configured, learned turn by turn and handed to the interrupt in small steps.
///
///     turn closed by the interrupt -> harmonics -> probe, layers, ripple -> target -> walk -> hand
///     over
///
/// A rehearsal settles, learns the drive's constants (layer 1), measures how U answers at every
/// harmonic (probe), and then removes what is left (layer 2). The cut goes on with both at a small
/// gain. What was learned stays between parts, and can be read and set by index. Equations and
/// their stability: MATHS.md (140) .. (147). Context of all functions: slow side, one caller.
#ifndef CAM_TEACH_H
#define CAM_TEACH_H

#include "cam_complex.h" // cam_complex_t, cam_gain_t
#include "cam_err.h"     // cam_err_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t, uint32_t

/// Harmonics of a turn that are learned, at most; the mean is one more.
enum { cam_teach_harmonics = 16, cam_teach_terms = cam_teach_harmonics + 1 };

/// What learning does at present.
typedef enum {
    cam_teach_off,      ///< cam_teach_reason_t says why
    cam_teach_waiting,  ///< for a rehearsal, or for turns in which nothing moves
    cam_teach_settling, ///< rehearsal: the first whole turns
    cam_teach_drive,    ///< rehearsal: layer 1, the drive's constants
    cam_teach_probing,  ///< rehearsal: U's answer at each harmonic
    cam_teach_shape,    ///< rehearsal: layers 1 and 2
    cam_teach_cutting,  ///< in the cut: both with small gains
    cam_teach_frozen,   ///< learned values are in force and stay, for the speed is another
    cam_teach_n_phases
} cam_teach_phase_t;

/// Why nothing, or not everything, is learned.
typedef enum {
    cam_teach_all,          ///< nothing hinders
    cam_teach_not_asked,    ///< learn_harmonics is 0, or no gain is set
    cam_teach_not_measured, ///< the port does not measure U
    cam_teach_no_table,     ///< none is in use
    cam_teach_modulated,    ///< the table modulates the speed of the spindle
    cam_teach_slow_turn,    ///< a turn has more ticks than the interrupt gathers
    cam_teach_fast_turn,    ///< a turn has too few ticks for one harmonic
    cam_teach_lobes,        ///< of a shaft with lobes only the drive's constants are learned
    cam_teach_diverged,     ///< layer 1 was given up, and its best is in force
    cam_teach_n_reasons
} cam_teach_reason_t;

/// What is to be known of the learning as a whole.
typedef struct {
    cam_teach_phase_t phase;
    cam_teach_reason_t reason;
    uint32_t n_turns;        ///< turns used since the rehearsal began
    uint32_t n_harmonics;    ///< learned besides the mean, 0 .. 16
    uint32_t masked;         ///< bit k: harmonic k is left as it is
    int32_t k1_ns;           ///< added to the parameter k1_ns
    int32_t k2_us2;          ///< added to the parameter k2_us2
    uint32_t error_nm;       ///< rms of the last turn's error in the harmonics that are learned
    uint32_t begin_error_nm; ///< ... before anything was learned
    uint32_t correction_nm;  ///< sum of the magnitudes of the correction
    uint32_t speed_mrpm;     ///< [r/min / 1000] at which was learned, 0: never
    uint32_t ripple_turns;   ///< turns that the ripple in force is the mean of
    uint32_t ripple_nturn;   ///< [turn / 10^9] sum of its amplitudes
    uint32_t scale_nturn;    ///< [turn / 10^9] what of order 1 stayed between two speeds, which is
                             ///< the encoder's: for the parameter eccentricity_nturn; 0: not known
    int32_t scale_udeg;      ///< its phase, for eccentricity_udeg
} cam_teach_status_t;

/// What is known of a harmonic.
typedef struct {
    cam_complex_t correction_q6; ///< [nm / 64] in force: Re(c e^(jk theta)) is added to the command
    cam_gain_t gain;             ///< answer of U to it, as probed; 0: not probed
    cam_complex_t error_q6;      ///< [nm / 64] of the last turn
    uint32_t best_q6;            ///< [nm / 64] smallest error so far
    cam_complex_t ripple;        ///< [turn / 2^32] of the spindle's angle
    bool is_masked;
} cam_teach_harmonic_t;

/// Values that make up all that was learned, in their order: speed [turn / 2^32 per tick], k1
/// [ticks / 2^16], k2 [ticks^2 / 2^16], masks, then for k = 0 .. 16 the parts of the correction
/// [nm / 64], of U's answer [1 / 4096], and for k = 1 .. 16 those of the ripple [turn / 2^32].
enum {
    cam_teach_value_speed,
    cam_teach_value_k1,
    cam_teach_value_k2,
    cam_teach_value_masked,
    cam_teach_value_correction,
    cam_teach_value_gain = cam_teach_value_correction + 2 * cam_teach_terms,
    cam_teach_value_ripple = cam_teach_value_gain + 2 * cam_teach_terms,
    cam_teach_n_values = cam_teach_value_ripple + 2 * cam_teach_harmonics
};

/// @return a name without blanks, "off"
const char *cam_teach_phase_name(cam_teach_phase_t phase);

/// @return a name without blanks, "not_asked"
const char *cam_teach_reason_name(cam_teach_reason_t reason);

#endif
