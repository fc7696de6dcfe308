// SPDX-License-Identifier: Apache-2.0
/// cam_plan: plans ahead what changes slowly in a cut, every n-th tick, and moves the axes by hand.
///
/// n = max(1, round(cam_plan_period_us * tick rate)): 8 ticks at 20 kHz, every tick at 1 kHz. A
/// plan reads the record of its tick and writes the increments (cam_motion_t) used from the next
/// tick up to the next plan: heights and envelopes, X and Z, U's amplitude and height, the swing,
/// the speed of the spindle, the state, and the faults that may wait for a plan (z_range, swing).
/// It plans for the instant of the next plan, so X, Z and U's envelope move linearly from plan to
/// plan and are exact there; in between the error is at most their second derivative times T^2 / 8,
/// T the period of the plan.
///
/// The plan runs after the outputs of its tick are written, so they never wait for it.
///
/// Read cam_plan_isr() with its state first: before a cut it waits for a steady spindle, in it the
/// feed moves Z, and between the lobes of a shaft U rests. Jogging is the plan of the state manual,
/// and the button at the machine is checked in all states. cam_plan_inner.h has the parts of a
/// plan. Context: ISR, constant time in each state, unless noted.
#ifndef CAM_PLAN_H
#define CAM_PLAN_H

#include "cam_config.h" // cam_play_config_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include "hal/hal.h"    // hal_axis_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, int64_t, uint32_t

/// Keeps the error between plans and the load small: README.md, "Two rates".
enum { cam_plan_period_us = 400 };

/// @return [ticks] from plan to plan, at least 1. Context: slow side.
static inline int32_t cam_plan_ticks(uint32_t tick_hz)
{
    const uint32_t ticks = (tick_hz * (uint32_t)cam_plan_period_us + 500000u) / 1000000u;
    return ticks > 1u ? (int32_t)ticks : 1;
}

/// Waiting for a steady spindle before a cut or its rehearsal. Turns are timed from the approach
/// on. The cut begins when the axes are at their start and enough successive turns agree in their
/// mean speed, MATHS.md (230). A spindle that was steady all along delays the start by two turns at
/// most, less the time of the approach. Zero-initialised: no turn has begun.
typedef struct {
    int64_t from_q32;      ///< [turn] master position where the present turn began
    uint32_t ticks;        ///< [ticks] since then; 0: none has begun
    uint32_t last_q24;     ///< [turn / 2^24] length of the last turn: up to a plan more than one
    uint32_t last_ticks;   ///< [ticks] its duration
    uint32_t n_turns;      ///< turns since the approach began
    uint32_t n_agreeing;   ///< successive turns that agreed with the one before
    uint32_t waited_ticks; ///< [ticks] for which the axes have been at their start
} cam_steady_t;

/// The feed over the turns of a cut, with override and hold.
///
/// The feed rate, 1 as programmed, ramps by 1 per `feed_ramp_turns` turns: from rest to the
/// override, from one override to the next, and to rest for the end, a hold or a stop. Ramps never
/// overlap, so Z never accelerates more than in the plain cut, whatever the override; only a stop
/// brakes within `stop_ramp_q32`. A change of the rate
///
///     from .. to    rate -> to_rate     parabola of what is fed
///     .. brake      to_rate             straight line
///     brake .. end  to_rate -> 0        parabola
///
/// is scheduled at master positions that are not yet commanded. The feed at any position follows
/// exactly from these numbers alone. A new rate waits until a ramp has ended, but a hold is
/// scheduled at once and brakes after the ramp; the ramp at the end of the part is final. The feed
/// comes to rest at a whole turn.
///
/// A ring-helix has no other rate than its own: it rests at the begin of a ring, for whole turns,
/// and continues with that ring. Source: MATHS.md (175) .. (177).
typedef struct {
    int64_t from_q32, to_q32;    ///< [turn] master positions of the change of rate; rings: begin of
                                 ///< the first ring, and end of the rest
    int64_t fed_q32, fed_to_q32; ///< [turn] feed at these
    int64_t brake_q32, end_q32;  ///< [turn] master positions at which the feed brakes and rests
    int64_t fed_end_q32;         ///< [turn] feed at the end
    int32_t rate_q30;            ///< [1] before the change
    int32_t to_rate_q30;         ///< [1] after it
    uint32_t per_brake_q31;      ///< [1/turn] fall of the rate in the brake
    int32_t requested_q30;       ///< [1] last request carried out
    bool is_held;                ///< the rest is a hold, not the end of the part
} cam_feed_motion_t;

/// The lobe of a shaft, and a smoothed height. Zero-initialised: a table without lobes.
typedef struct {
    uint32_t i_lobe;    ///< current lobe
    uint32_t phase_q32; ///< [turn / 2^32] its phase, part of that of cam_motion_t; 0 without lobes
    int64_t z_q8;       ///< [nm / 256] smoothed height of a measured Z
    int64_t speed_q8;   ///< [nm / 256 per plan] its speed
} cam_shaft_t;

/// State; zero-initialised: before the first cut.
typedef struct {
    int64_t engage_at_q32;         ///< [turn] master position where the envelope starts to rise
    int64_t feed_at_q32;           ///< ... where Z starts
    int64_t disengage_at_q32;      ///< ... where the envelope starts to fall
    int32_t measured_nm;           ///< [nm] Z of the last plan
    int32_t amplitude_q30;         ///< [1] ramped
    int32_t ratio_q28;             ///< [1] speed ratio at the end of the last plan
    int32_t x_trim_q4;             ///< [nm / 16] ramped
    int32_t spindle_rate_q30;      ///< [1] override of the spindle, ramped
    bool is_rehearsal;             ///< a rehearsal is scheduled, not the cut
    bool is_stopped;               ///< stopped: no cut follows the rehearsal
    cam_feed_motion_t feed_motion; ///< feed of the cut
    cam_shaft_t shaft;             ///< current lobe
    cam_steady_t steady;           ///< wait for a steady spindle
} cam_plan_t;

/// One plan, constant time in each state.
/// @param r  record of the tick, complete
/// @param m  increments, replaced from the next tick on
void cam_plan_isr(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                  cam_motion_t *m);

/// Shares of lift and speed ratio.
typedef struct {
    int32_t lift_q30;  ///< [1 / 2^30] of the lift
    int32_t ratio_q30; ///< [1 / 2^30] of the ratio's distance from 1
} cam_share_t;

/// Share the lift of U and the speed ratio between two lobes of a shaft (cam_plan_inner.h).
/// @param change_q31  [1 / 2^31] of cam_lobes_change_q31()
/// @param has_speed   the table has a speed channel
cam_share_t cam_shaft_share(int32_t change_q31, bool has_speed);

/// Jog, step and homing: the plan of the state manual.
///
/// One axis follows the order of the configuration (cam_config.h), all others brake and stop.
/// When an order ends, is stopped or expires, its axis brakes gently. Expiry is checked here, by
/// the tick, so an axis stops even if the slow side hangs, MATHS.md (171).
///
/// Homing, MATHS.md (172):
///
///     here                                                  home is the present position
///     search --switch--> release --no switch--> done        home is where it left the switch, or
///                                --> index --index--> done  the first index after that
///
/// If the axis is already on the switch, homing begins with release. A phase that finds nothing
/// within the travel of the order ends it without a home. U, whose travel is its stroke: the search
/// first sets U's position to an end of its stroke, and the home finally sets it to its value.
///
/// A U that takes forces may have a stop instead of a switch, MATHS.md (173). The stop is found,
/// and is the home, when the force is at the limit of the order and U has stood within 1 um for 20
/// ms. U has left it when it is 10 um back and within its stroke. The force stays limited until a
/// home is found or the drives are disabled, because an order that ends earlier may leave U on its
/// stop. Zero-initialised: no order, nothing homed.
typedef struct {
    uint32_t serial; ///< of the last order begun
    cam_jog_phase_t phase;
    cam_jog_end_t end; ///< of that order
    hal_axis_t axis;
    int64_t target_q10;           ///< [nm / 1024] where the phase ends
    int32_t stood_nm;             ///< [nm] U at its stop, or when it last moved
    uint32_t n_still;             ///< [plans] for which it has stood there since
    uint32_t homed;               ///< bit of an axis: its home is known
    uint32_t n_found;             ///< homes found since start
    int32_t found_nm[hal_n_axes]; ///< [nm] port position of the axis at its home
} cam_jog_t;

/// One plan of the state manual; ends the state when a disable was requested and all axes rest.
/// @param m  increments, replaced from the next tick on; U's origin shifted
/// Context: ISR; constant time in each phase.
void cam_jog_isr(cam_jog_t *h, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                 cam_motion_t *m);

/// One plan of any other state: orders are discarded, and homes are forgotten while the drives are
/// not ready. Context: ISR, constant time.
void cam_jog_idle_isr(cam_jog_t *h, const cam_play_config_t *cfg, const cam_tick_record_t *r);

/// The acknowledge button: nothing moves before somebody presses a button at the machine.
///
/// After power-on, an emergency stop or a fault the drives can be enabled (enable, home, manual)
/// only after a press of the input acknowledge: released for a while, pressed for 0.05 to 2 s,
/// released, all in the state off with the emergency-stop chain closed. Earlier presses do not
/// count. A stuck button is pressed too long; levels count when stable for 20 ms. Enable must
/// follow within 60 s, and after each disable again within 60 s.
///
///     needed --released 50 ms--> armed --pressed--> pressed --released, 50 ms .. 2 s--> given
///                                  ^---- too short ----'                                  |
///     needed <------------------------ pressed too long, or 60 s --------------------------
///     given --enable, manual--> used --off--> given
///     any --fault, chain open, even for one tick--> needed
///
/// The plan checks the button, so the interrupt refuses by itself; the slow side only explains.
typedef enum {
    cam_acknowledge_needed,  ///< the button must be released first
    cam_acknowledge_armed,   ///< released, waiting for the press
    cam_acknowledge_pressed, ///< pressed
    cam_acknowledge_given,   ///< pressed and released; waiting for enable
    cam_acknowledge_used,    ///< enabled
} cam_acknowledge_phase_t;

/// State; zero-initialised: power-on.
typedef struct {
    cam_acknowledge_phase_t phase;
    bool is_pressed;  ///< debounced input
    uint32_t n_other; ///< [plans] for which the input has differed from it
    uint32_t n_plans; ///< [plans] since is_pressed or the phase changed
} cam_acknowledge_t;

/// Check the button, once per plan. Writes m->is_acknowledged.
void cam_acknowledge_isr(cam_acknowledge_t *a, const cam_acknowledge_config_t *cfg,
                         const cam_tick_record_t *r, cam_motion_t *m);

/// @return [plans] left for enable; 0 unless the phase is given. Context: slow side.
uint32_t cam_acknowledge_left(const cam_acknowledge_t *a, const cam_acknowledge_config_t *cfg);

#endif
