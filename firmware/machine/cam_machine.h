// SPDX-License-Identifier: Apache-2.0
/// cam_machine: slow side of the controller: table, parameters, commands, status.
///
/// A command is checked against the last status, posted to the interrupt and carried out in the
/// next tick. cam_ok means posted; cam_machine_status() shows the outcome. Parameters and table go
/// to the interrupt as one configuration (cam_config.h), so the interrupt never sees half a change.
/// Until the interrupt has taken a command or configuration, the next is refused with cam_err_busy.
///
/// The functions stand in the order of use: start of the controller with cam_machine_poll(), table
/// and parameters, the commands of a cut, passes and progress, rights, jogging and homing, the
/// recorder, excitation of U, learning. All functions: slow side, one caller.
#ifndef CAM_MACHINE_H
#define CAM_MACHINE_H

#include "cam_err.h"      // cam_err_t, cam_verdict_t
#include "cam_learning.h" // cam_ilc_t, cam_ilc_status_t
#include "cam_param.h"    // cam_params_t, cam_param_store_found_t, cam_refusal_t, cam_rights_t
#include "cam_record.h"   // cam_tick_record_t
#include "cam_recorder.h" // cam_scope_t
#include "cam_table.h"    // cam_table_t
#include "cam_tick.h"     // cam_t, cam_status_t
#include "hal/hal.h"      // hal_axis_t, hal_n_axes
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t
#include <stdint.h>       // int32_t, int64_t, uint8_t, uint32_t

/// Fields of a refusal, by their number in get_refusal.
typedef enum {
    cam_refusal_result,
    cam_refusal_needed,
    cam_refusal_limit,
    cam_refusal_highest_mrpm,
    cam_refusal_largest_feed_nm,
    cam_refusal_pass,
    cam_refusal_parameter,
    cam_n_refusals
} cam_refusal_field_t;

/// Kept parameters compared with those in force.
typedef enum {
    cam_kept_none,    ///< none are kept
    cam_kept_same,    ///< equal
    cam_kept_changed, ///< different
    cam_kept_damaged, ///< unusable: power-on uses the defaults
} cam_kept_t;

/// Result of the last excitation. The numbers are part of the CAN protocol.
typedef enum {
    cam_excited_never,
    cam_excited_runs,
    cam_excited_done,    ///< played to its end
    cam_excited_stopped, ///< by stop or disable
    cam_excited_silent,  ///< stopped for lack of a sign of life
    cam_excited_fault,   ///< stopped by a fault, or refused by the interrupt
} cam_excited_t;

typedef enum {
    cam_identify_none,
    cam_identify_offered,   ///< the interrupt has not yet taken the wave
    cam_identify_requested, ///< the interrupt has not yet started
    cam_identify_runs,
    cam_identify_ends, ///< the configuration without the wave is not yet offered
} cam_identify_phase_t;

/// State of the excitation of U; zero-initialised: no wave.
typedef struct {
    uint32_t n_bytes;  ///< [bytes] announced size of the download
    uint32_t received; ///< [bytes]
    bool is_open;      ///< blocks are accepted
    uint32_t n;        ///< [samples] of the complete wave; 0: none
    int32_t place_nm;  ///< [nm] U's mean position
    bool is_force;     ///< the samples are forces
    uint32_t n_fall;   ///< [ticks] in which the gain falls at the end
    cam_identify_phase_t phase;
    cam_excited_t excited;
    int32_t following_nm; ///< [nm] limit of the following error, restored at the end
    uint32_t alive_tick;  ///< [tick] of the last sign of life
    bool disables;        ///< disable the drives at the end
} cam_identify_t;

/// Completed and remaining turns of a pass: of the rehearsal, if any, and of the cut with engaging
/// and disengaging, without the approach to the start. The feed override is included as planned; a
/// hold counts as if resumed at once.
typedef struct {
    bool has_end;      ///< false: only stop ends the pass, or no table is selected
    int64_t left_q32;  ///< [turn] to the end of the pass, or length of the next one
    int64_t whole_q32; ///< [turn] completed and remaining
    uint32_t mrpm;     ///< [r/min / 1000] mean spindle set-point with its override
} cam_progress_t;

/// State of the acknowledge button. The numbers are part of the CAN protocol.
typedef enum {
    cam_button_needed, ///< must be pressed before enable
    cam_button_given,  ///< pressed
    cam_button_none,   ///< the port has none, so enable is refused
    cam_button_waived, ///< waived by the port's builder
} cam_button_t;

typedef struct {
    uint32_t commander; ///< sender number; 0: none
    uint32_t n_take_overs, n_losses;
    cam_level_t level;
    uint32_t level_left_s; ///< [s] until locked again; 0: locked
    cam_button_t button;
    uint32_t button_left_s; ///< [s] left for enable; 0: no time limit
} cam_rights_status_t;

/// Homes and their orders; zero-initialised: no order, no home.
typedef struct {
    uint32_t serial;             ///< of the newest order
    uint32_t n_found;            ///< homings applied to the configuration in force
    bool has_searched_u;         ///< a search of U's home was ordered since the start
    uint32_t known;              ///< one bit per axis: homed since the start
    int32_t home_nm[hal_n_axes]; ///< [nm] the home, in port coordinates
} cam_offsets_t;

/// State of the slow side. The room remote may also use rights and scope, and read
/// has_table, table, params, staged, version, checksum, pass, n_parts, is_held, tick_hz,
/// refusal, kept, identify.received and ilc.
typedef struct {
    cam_t *core;                  ///< state of the interrupt
    cam_params_t params;          ///< as last set
    uint32_t version;             ///< of params: rises from that of the kept ones on
    uint32_t checksum;            ///< of params (cam_param_store_checksum())
    cam_param_store_found_t kept; ///< kept parameters; .err also covers their hand-over
    uint32_t kept_checksum;       ///< of the kept parameters, when kept.err is cam_ok
    cam_params_t staged;          ///< staged parameters
    uint32_t staged_version;      ///< version when staging began; UINT32_MAX: nothing staged
    cam_refusal_t refusal;        ///< of the last refusal with numbers or a parameter
    cam_table_t table;            ///< valid when has_table
    bool has_table;               ///< a valid table is in use
    uint32_t tick_hz, clock_hz;   ///< from the port
    uint32_t generation;          ///< number of the newest configuration
    uint32_t n_requests;          ///< serial number of the last request
    bool homes_again;             ///< enable when the state is off
    uint32_t pass;                ///< current pass, or the next one that start cuts; from 0
    bool is_in_pass;              ///< start was accepted and the end of the pass not yet seen
    bool is_cut_short;            ///< stopped early: start repeats the pass
    bool is_unsteady;             ///< the last start ended because the spindle was not steady
    uint32_t n_parts;             ///< completed parts
    bool is_held;                 ///< feed hold
    bool is_rate_due;             ///< a change of the hold is not yet handed over
    uint32_t limit_mrpm;          ///< [r/min / 1000] overspeed of the newest configuration
    uint32_t n_checked;           ///< [bytes] progress of the background check of the table
    uint32_t checked_crc;         ///< CRC-32 of the bytes so far
    cam_scope_t scope;            ///< recorder
    bool has_box;                 ///< the idle recorder works as black box
    bool is_box_kept;             ///< the completed black box was handed to the port
    cam_identify_t identify;      ///< excitation of U
    cam_ilc_t ilc;                ///< learning
    cam_offsets_t offsets;        ///< offsets and homes
    cam_rights_t rights;          ///< rights to command and to change limits
    bool is_stop_due;             ///< command was lost: stop the motion
} cam_machine_t;

/// @return why `err` was returned: m->refusal if it is of that error, else the error alone
static inline cam_refusal_t cam_machine_refusal(const cam_machine_t *m, cam_err_t err)
{
    return m->refusal.err == err ? m->refusal : cam_refusal_of(err, cam_n_params, 0, 0);
}

/// Initialize interrupt and slow side, state off. Call before the tick starts.
/// @param core     state of the interrupt, zeroed here
/// @param tick_hz  [Hz] result of hal_tick_hz(), 500 .. 100 000
/// @param clock_hz [Hz] result of hal_clock_hz()
void cam_machine_init(cam_machine_t *m, cam_t *core, uint32_t tick_hz, uint32_t clock_hz);

/// Background work of the main loop: all polls, the continuous check of the table, one kilobyte per
/// call, the second half of cam_machine_home() and the step to the next pass. A damaged table is no
/// longer used and raises the fault `table`.
void cam_machine_poll(cam_machine_t *m);

/// @return a consistent copy of the status that the interrupt published last
cam_status_t cam_machine_status(const cam_machine_t *m);

/// @return cam_ok when another table may be written and selected: in off and ready, where no tick
///         reads a table, once the interrupt has taken all commands and configurations; else
///         cam_err_state, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_may_exchange(const cam_machine_t *m);

/// Check an image as cam_machine_select_table() does, without using it.
CAM_MUST_USE cam_err_t cam_machine_check_table(cam_machine_t *m, const void *image, size_t size);

/// Check an image and use it as the table.
/// @param size  [bytes] of the image
/// @return cam_ok; an error of the image or of cam_build_config(); cam_err_state when neither off
///         nor ready; in ready also a feasibility error, or cam_err_table_sense for the other sense
///         of rotation; cam_err_busy. On error the old table stays in force, unless the bad image
///         has overwritten it: that counts as damage found by cam_machine_poll()
/// Context: takes as long as cam_table_check().
CAM_MUST_USE cam_err_t cam_machine_select_table(cam_machine_t *m, const void *image, size_t size);

/// Set a parameter. Changes allowed by state:
/// - off: all
/// - ready, manual: all but those of the encoder and z_is_measured; feed-forward and limits of U
///   only while U is at rest. In ready the result must be feasible
/// - during a pass: phase_udeg, amplitude_ppm, x_trim_nm, feed_override_ppm, spindle_override_ppm,
///   all of them ramped; the result must be feasible
/// - other states: none
///
/// Refusals with numbers or a parameter are in m->refusal; others leave it unchanged:
/// cam_machine_refusal() distinguishes them.
/// @return cam_ok, cam_err_param_id, _range, _state, cam_err_hard_limit, cam_err_trim_limit,
///         cam_err_busy, cam_err_travel, cam_err_u_place when U is outside of the new stroke,
///         cam_err_locked, cam_err_lock_none, a feasibility error, or an error of
///         cam_build_config()
CAM_MUST_USE cam_err_t cam_machine_set_param(cam_machine_t *m, cam_param_id_t id, int32_t value);

/// Start staging with a copy of the parameters in force.
void cam_machine_stage_begin(cam_machine_t *m);

/// Set a staged parameter. It takes effect with cam_machine_stage_commit().
/// @return cam_ok, cam_err_params_begin, cam_err_param_id, cam_err_param_range, cam_err_hard_limit
CAM_MUST_USE cam_err_t cam_machine_stage(cam_machine_t *m, cam_param_id_t id, int32_t value);

/// Apply all staged parameters in the same tick, or none of them.
/// @return as cam_machine_set_param(); cam_err_params_begin; cam_err_params_stale when a parameter
///         was set since staging began. cam_ok and cam_err_params_stale end the staging
CAM_MUST_USE cam_err_t cam_machine_stage_commit(cam_machine_t *m);

/// Store the parameters in force in the port's memory.
/// @return cam_ok, cam_err_state when not off, cam_err_busy, cam_err_params_keep; cam_err_locked,
///         cam_err_lock_none where limits or constants differ from the kept ones
/// Context: takes as long as hal_params_keep().
CAM_MUST_USE cam_err_t cam_machine_save_params(cam_machine_t *m);

/// Apply the defaults of this port. The kept parameters do not change.
/// @return as cam_machine_set_param()
CAM_MUST_USE cam_err_t cam_machine_restore_defaults(cam_machine_t *m);

/// Apply the kept parameters.
/// @return as cam_machine_set_param(), cam_err_params_none, cam_err_params_damaged
CAM_MUST_USE cam_err_t cam_machine_revert_params(cam_machine_t *m);

/// @return whether the parameters in force are kept
cam_kept_t cam_machine_params_kept(const cam_machine_t *m);

/// @return [r/min / 1000] highest speed feasible for all passes; 0: none
uint32_t cam_machine_highest_mrpm(const cam_machine_t *m);

/// Check all passes, each at its own speed, with the details of cam_feasible() of the first
/// infeasible one; where there is none, of the pass that start cuts next.
/// @return err = cam_err_no_table and only the speed when no table is selected
cam_refusal_t cam_machine_feasibility(const cam_machine_t *m);

/// Enable the drives and search the index: off -> homing.
/// @return cam_ok, cam_err_state, _busy, _no_table, _estop, _drive, _bus, _servo_none, _u_place,
///         _not_homed, _travel, cam_err_acknowledge, cam_err_acknowledge_none,
///         or a feasibility error
CAM_MUST_USE cam_err_t cam_machine_enable(cam_machine_t *m);

/// Repeat the index search: in off as cam_machine_enable(); in ready -> off -> homing, where
/// cam_machine_poll() enables again. If enable is refused, the machine stays off.
/// @return as cam_machine_enable() in off, as cam_machine_disable() in ready
CAM_MUST_USE cam_err_t cam_machine_home(cam_machine_t *m);

/// Disable the drives: homing, ready -> off; manual -> off when the axes are at rest.
/// @return cam_ok, cam_err_state, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_disable(cam_machine_t *m);

/// Cut one pass: ready -> engaging -> cutting -> disengaging -> ready. The next start cuts the next
/// pass, after the last one the first. A pass that ended in a stop or a fault is repeated. Refused
/// if any pass is infeasible. The cut begins once the spindle turns steadily (cam_steady_t); if it
/// does not within a hundred times stopped_ms, the approach ends as by stop, and is_unsteady is
/// set.
/// @return cam_ok, cam_err_state, _busy (also while the spindle is faster than the pass allows),
///         _not_homed, _travel, or a feasibility error (cam_machine_feasibility())
CAM_MUST_USE cam_err_t cam_machine_start(cam_machine_t *m);

/// End the cut early: engaging, cutting, holding -> disengaging; during the approach -> ready. In
/// manual, brake the axes.
/// @return cam_ok, cam_err_state, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_stop(cam_machine_t *m);

/// Hold the feed: Z stops within its ramp on a whole turn, a ring-helix where the next ring begins,
/// while U and X continue; the state is then holding. In rehearsing and engaging, the hold takes
/// effect where the feed would begin. Within the ramp at the end of the part, the feed continues to
/// the end. The hold ends with the cut.
/// @return cam_ok, cam_err_state, cam_err_override_measured
CAM_MUST_USE cam_err_t cam_machine_hold(cam_machine_t *m);

/// Resume the feed on a whole turn.
/// @return cam_ok, or cam_err_state when nothing is held
CAM_MUST_USE cam_err_t cam_machine_resume(cam_machine_t *m);

/// Acknowledge a fault: fault -> off, after the retract has ended.
/// @return cam_ok, cam_err_state, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_reset(cam_machine_t *m);

/// Passes. A pass has a feed, a speed and an allowance, which offsets X. The parameters feed_nm and
/// spindle_mrpm, where set, override those of all passes; x_trim_nm is added to the allowance. A
/// table without passes counts as one pass with the values of its header. Source: MATHS.md (105).

/// @return number of passes, at least 1, even without a table (NULL)
uint32_t cam_pass_count(const cam_table_t *table);

/// @param i  pass, below cam_pass_count()
/// @return   parameters of the pass; the swing's speed is 0 on a machine without swing axis
cam_params_t cam_pass_params(const cam_params_t *params, const cam_table_t *table, uint32_t i);

/// @return the first pass of a part: the one set by the parameter `pass`, else 0
uint32_t cam_pass_first(const cam_params_t *params, const cam_table_t *table);

/// Set the part counter.
/// @return cam_ok, or cam_err_param_range when below 0
CAM_MUST_USE cam_err_t cam_machine_set_parts(cam_machine_t *m, int32_t n);

/// @return progress of the pass in the newest tick
cam_progress_t cam_progress(const cam_machine_t *m);

/// Release command. A lost or released command stops the motion as cam_machine_stop() does.
void cam_machine_release_command(cam_machine_t *m);

/// Sign of life of the commander of an excitation, a step or a homing. A jog is renewed by the next
/// jog command.
void cam_machine_keep_alive(cam_machine_t *m);

cam_rights_status_t cam_machine_rights(const cam_machine_t *m, const cam_status_t *status);

/// Jogging: commands of the state manual.
///
///     manual -> jog, jog, ..; step; home; zero -> disable
///
/// The spindle stands still, and one axis at a time moves by order (cam_plan.h). An order expires
/// after cam_jog_patience_ms, and the interrupt brakes the axis. A repeated jog command renews a
/// jog, cam_machine_keep_alive() a step or a homing.
enum { cam_jog_patience_ms = 250 };

/// Enable the drives: off -> manual. No table is needed.
/// @return cam_ok, cam_err_state, _busy, _estop, _drive, _bus, _servo_none, _u_place, _acknowledge,
///         _acknowledge_none
CAM_MUST_USE cam_err_t cam_machine_manual(cam_machine_t *m);

/// Move an axis until the order expires, or to the limit of its travel.
/// @param um_per_s  [um/s] signed; 0 brakes
/// @return          cam_ok, cam_err_state, _busy, _hand_axis, _hand_moves during a step or homing;
///                  _hand_speed with the limit [um/s]
cam_verdict_t cam_machine_jog(cam_machine_t *m, hal_axis_t axis, int32_t um_per_s);

/// Move an axis by a distance, at its highest jog speed.
/// @param nm  [nm] signed
/// @return    cam_ok, cam_err_state, _busy, _hand_axis, _hand_moves; _travel with the limit [nm] in
///            machine coordinates
cam_verdict_t cam_machine_step(cam_machine_t *m, hal_axis_t axis, int32_t nm);

/// Home an axis by the method in its parameters.
/// @return cam_ok, cam_err_state, _busy, _hand_axis, _hand_moves, _home_none
CAM_MUST_USE cam_err_t cam_machine_home_axis(cam_machine_t *m, hal_axis_t axis);

/// Set the datum from the tool's position. Nothing moves. In off, manual and ready.
/// @param axis  X or Z
/// @param nm    [nm] X: diameter that the tip touches at U's present position; Z: height
/// @return      cam_ok with the datum [nm]; cam_err_hand_axis, _hand_moves, _not_homed, _busy,
///              _param_state; _param_range with the datum in force
cam_verdict_t cam_machine_zero(cam_machine_t *m, hal_axis_t axis, int32_t nm);

/// @return [nm] the position of an axis, in machine coordinates
int32_t cam_machine_position_nm(const cam_machine_t *m, hal_axis_t axis);

/// @return [nm] port coordinate of the part's zero, saturated; 0 for U
int32_t cam_offsets_origin_nm(const cam_offsets_t *h, const cam_params_t *params, hal_axis_t axis);

/// @return whether the position of an axis is known: homed, or no homing needed
bool cam_offsets_is_known(const cam_params_t *params, const cam_status_t *status, hal_axis_t axis);

/// Recorder and its memory.
///
///     free -> black box: once cam_machine_blackbox() was called
///     black box -> recording, wave: by command, unless the box holds a fault
///     black box with a fault: stays, through faults and restarts, until cam_machine_release()
///     recording, wave -> black box: by cam_machine_release(), or cam_scope_patience_s after its
///     end
///
/// A command discards the black box, but is refused with cam_err_scope_unread when the box holds a
/// fault. An excitation discards a finished recording, but is refused with cam_err_scope_on during
/// one.

/// [s] until the black box replaces a finished recording that nobody releases.
enum { cam_scope_patience_s = 600 };

/// Use the recorder as black box, starting with the box saved by the port. Not for a loop that
/// reads the trace ring itself.
void cam_machine_blackbox(cam_machine_t *m);

/// Start a recording; replaces a running one. @return as cam_scope_begin();
/// cam_err_scope_unread; cam_err_state during an excitation
CAM_MUST_USE cam_err_t cam_machine_scope_start(cam_machine_t *m);

/// Stop the commanded recording. The black box continues.
void cam_machine_scope_stop(cam_machine_t *m);

/// Discard recording, wave or the box of a fault: the black box starts again.
/// @return cam_ok, or cam_err_state during an excitation
CAM_MUST_USE cam_err_t cam_machine_release(cam_machine_t *m);

/// Set a field of the recorder. @return as cam_scope_set()
CAM_MUST_USE cam_err_t cam_machine_scope_set(cam_machine_t *m, uint32_t field, int32_t value);

/// Read a field of the recorder. @return as cam_scope_get()
CAM_MUST_USE cam_err_t cam_machine_scope_get(const cam_machine_t *m, uint32_t field,
                                             int32_t *value);

/// Excitation of U by a downloaded wave, for identification.
///
///     wave_begin -> wave_block, .. -> wave_end -> excite, keep_alive, .. -> state ready again
///
/// The samples are int32 [nm], one per tick, of one period, or [mN] of force where the field
/// wave_unit is set to 1 after wave_begin. They occupy the start of the recorder's memory, so that
/// a new wave discards the recording. Before it starts, an excitation is checked for length,
/// stroke, speed and acceleration, with the wrap and the fade, and for half the clearance between
/// tool and work. The recorder records it, with the columns set before, from the first tick of the
/// state identifying to the last.
///
/// A wave of force is added to the force of U's position loop, which stays closed. At a crossover
/// of 1 Hz U moves as the wave alone would move it; with the loop of the cut the wave measures that
/// loop. The wave must stay within the force limit, the position about which it plays within the
/// stroke, and X clear of all of U's travel; a following error of that travel is accepted, and the
/// supervision of the force continues. The record shows the force of a sample in the next tick. At
/// its end the force drops to 0 at once, and the usual limit of the following error applies again.
///
/// Without a sign of life for cam_identify_patience_ms U is brought to rest; stop and disable do
/// the same, and disable then disables the drives. The wave has no feed-forward, so the guard
/// allows a following error of its limit plus the largest sample, or that of a motion by time if
/// that is larger.
enum { cam_identify_patience_ms = 500 };

/// Begin the download of a wave. The present wave and recording are lost.
/// @param n_bytes  [bytes] a multiple of 4
/// @return         cam_ok; cam_err_state, cam_err_busy while an excitation runs; cam_err_scope_on,
///                 cam_err_scope_unread; cam_err_wave_length;
///                 cam_err_scope_memory (more than half of it)
CAM_MUST_USE cam_err_t cam_machine_wave_begin(cam_machine_t *m, uint32_t n_bytes);

/// Store the next bytes. Accepts a repetition of bytes already received.
/// @param n  [bytes] a multiple of 4
/// @return   cam_ok; cam_err_download_order: continue at m->identify.received;
///           cam_err_download_room: beyond the announced size
CAM_MUST_USE cam_err_t cam_machine_wave_block(cam_machine_t *m, uint32_t offset,
                                              const uint8_t *bytes, uint32_t n);

/// End the download.
/// @param crc  CRC-32 of all bytes
/// @return     cam_ok: the wave can be played; cam_err_download_order, _short: the download may
///             continue; cam_err_download_crc: it must start again
CAM_MUST_USE cam_err_t cam_machine_wave_end(cam_machine_t *m, uint32_t crc);

/// Play the wave: ready -> identifying -> ready.
/// @param n_periods   at full gain, at least 1; fade and periods take a minute at most
/// @param fade_ticks  [ticks] of the rise, and of the fall, 16 .. 65535
/// @return            cam_ok, cam_err_state, _busy, _wave_none, _scope_memory, _scope_unread,
///                    or with the demand: cam_err_wave_stroke [nm], _wave_speed [um/s],
///                    _wave_acceleration [mm/s2], _wave_force [mN], _wave_clear with the required
///                    X [nm]
cam_verdict_t cam_machine_excite(cam_machine_t *m, uint32_t n_periods, uint32_t fade_ticks);

/// One step of learning: take a turn from the interrupt, process one harmonic, or blend the values
/// in force one step towards the learned ones. Part of cam_machine_poll(). Must run at least a
/// hundred times per spindle turn, so a main loop slower than that calls it in addition.
/// @param state        of the status
/// @param is_u_moving  the status has no is_u_at_rest
void cam_machine_ilc_poll(cam_machine_t *m, cam_state_t state, bool is_u_moving);

cam_ilc_status_t cam_machine_learning(const cam_machine_t *m);

/// Restore a value of cam_ilc_get(), in off and ready. The interrupt gets the change in steps.
/// @return cam_ok, cam_err_param_id, cam_err_param_range, or cam_err_param_state
CAM_MUST_USE cam_err_t cam_machine_set_learned(cam_machine_t *m, uint32_t index, int32_t value);

#endif
