// SPDX-License-Identifier: Apache-2.0
/// cam_spindle: from encoder counts and index to master position and speed.
///
/// Counts are carried to a binary angle exactly (any counts per turn, no drift), half a count is
/// added to centre the quantisation, and a second-order tracking observer turns the stairs into
/// angle and speed between counts. Speed and position are positive in the sense of cutting.
///
/// A tick that comes off its time by more than a sixteenth of a period is taken at its time stamp,
/// so a late tick costs no angle.
///
/// Errors of the observer, MATHS.md (52), (53), with bandwidth f_o (poles near w_o = 2 pi f_o):
///   constant speed           mean 0; quantisation ripple below half a count
///   constant acceleration    angle lags by (1 - 2 w_o T) acceleration / w_o^2, T one tick,
///                            for the part of it that nobody told
///   speed ripple at f        (1 - 2 w_o T) f^2 / (f^2 + f_o^2) of the angle ripple is missed
/// Context: ISR unless noted.
#ifndef CAM_SPINDLE_H
#define CAM_SPINDLE_H

#include "cam_state.h" // cam_sense_t
#include <stdbool.h>   // bool
#include <stdint.h>    // int32_t, int64_t

/// Configuration, made by cam_config_build().
typedef struct {
    uint32_t sign_mask;               ///< 0, or ~0 when counts fall while cutting
    int32_t counts_per_turn;          ///< 64 .. 2^24
    uint32_t turn_per_count_q32;      ///< [turn / 2^32 per count] whole part of 2^32 / counts
    uint32_t turn_per_count_fraction; ///< ... and 2^32 times what is left
    uint32_t centre_q32;              ///< [turn / 2^32] offset of the index and half a count
    int32_t kp_q31;                   ///< observer gain of the position per tick
    int32_t ki_q32;                   ///< ... of the speed, below 1/2
    int32_t index_tolerance;          ///< [counts]
    int32_t index_overdue;            ///< [counts] travel without an index edge that is too far
    int32_t jump_window;              ///< [counts]
    int32_t max_counts;               ///< [counts / tick] a quarter turn
    uint32_t tick_clocks;             ///< [1 / clock_hz] period
    uint32_t early_clocks;            ///< [1 / clock_hz] shortest period that counts as on time
    uint32_t on_time_clocks;          ///< [1 / clock_hz] width of what counts as on time
    uint32_t late_clocks;             ///< [1 / clock_hz] a longer period is a fault
    uint32_t most_clocks;             ///< [1 / clock_hz] a longer period counts as this one
    uint32_t ticks_per_clock_q27;     ///< [ticks per unit of the time stamp]
    uint32_t off_time_told;           ///< CAM_ANGLE_BUSY when tasks are put off by such ticks, or 0
} cam_spindle_config_t;

/// What an index edge still waits for: one step in every other tick, in between it rests.
enum {
    cam_edge_none,
    cam_edge_to_take = 1,    ///< the way since
    cam_edge_to_measure = 3, ///< its distance to the one before; the first edge tells the angle
    cam_edge_to_add = 5,     ///< that distance
    cam_edge_to_compare = 7, ///< it with whole turns
    cam_edge_to_judge = 9,   ///< what is left: lost counts
    cam_edge_steps
};

/// State. Zero-initialised is: not started.
typedef struct {
    bool is_started;
    bool is_synced;
    uint32_t clock;        ///< time stamp of the last tick
    uint32_t counts;       ///< [counts] of the last tick, in the sense of cutting
    uint32_t n_index;      ///< of the last tick
    uint32_t index_counts; ///< [counts] of the last edge, in the sense of cutting
    uint32_t edge;         ///< [counts] the last edge as it was read, then in the sense of cutting
    uint8_t edge_step;     ///< cam_edge_* of the last edge
    int32_t edge_distance; ///< [counts] to the one before
    int32_t index_error;   ///< [counts] sum of deviations since the first edge
    int32_t since_index;   ///< [counts] travel since the last edge
    int32_t in_turn;       ///< [counts] 0 .. counts_per_turn - 1 since the index
    bool is_off_time;      ///< the last tick came visibly off its time
    uint32_t max_period;   ///< [1 / clock_hz] longest distance of two ticks
    uint32_t n_late;       ///< ticks beyond late_clocks
    int64_t pos_q32;       ///< [turn, Q32.32] observer
    int64_t speed_q64;     ///< [turn / 2^64 per tick] observer
} cam_spindle_t;

/// In cam_angle_t.faults, not a fault: this tick had more to do than usual, so others may wait.
/// Only at rates of 5 kHz and more.
#define CAM_ANGLE_BUSY (UINT32_C(1) << 30)
_Static_assert(cam_n_faults <= 30, "a bit is left");

/// What the room knows of the spindle after this step.
typedef struct {
    int64_t pos_q32;   ///< [turn, Q32.32] master position at the instant of sensing
    int32_t speed_q32; ///< [turn / 2^32 per tick]
    bool is_off_time;  ///< this tick or the last one came visibly off its time
    bool is_synced;    ///< the angle is known
    uint32_t faults;   ///< late_tick, encoder_jump, lost_counts, index_missing, or CAM_ANGLE_BUSY
} cam_angle_t;

/// @param ticks_q16  [ticks / 2^16] 0 .. 2^31 - 1
/// @return           [turn, Q32.32] master position after some ticks at this speed
static inline int64_t cam_angle_ahead(const cam_angle_t *angle, int32_t ticks_q16)
{
    return angle->pos_q32 + (((int64_t)angle->speed_q32 * ticks_q16) >> 16);
}

/// Take one reading.
/// @param s    state
/// @param cfg  configuration; after a change of it the angle must be forgotten
/// @param in   what this tick sensed
/// @param alpha_q40  [turn / 2^40 per tick^2] acceleration that the spindle was told since the last
///             tick, 0 at uniform speed: known, it causes no lag
/// @param angle      result
/// Constant time.
CAM_STAGE void cam_spindle_step_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                                    const cam_sense_t *in, int32_t alpha_q40, cam_angle_t *angle);

/// Forget the index; counts, angle observer and speed go on.
void cam_spindle_forget_isr(cam_spindle_t *s);

#endif
