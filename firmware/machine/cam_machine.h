// SPDX-License-Identifier: Apache-2.0
/// cam_machine: the slow side's view of the controller: table, parameters, commands, status.
///
/// A command is checked here against the last status, posted to the interrupt and carried out in
/// the next tick. cam_ok means that it was posted; cam_machine_status() shows the outcome.
/// Parameters and table are gathered here and handed to the interrupt as one configuration
/// (cam_config.h), so that the interrupt never sees half a change. While a posted command or a
/// configuration has not been taken, further ones are refused with cam_err_busy. All functions:
/// slow side, one caller.
#ifndef CAM_MACHINE_H
#define CAM_MACHINE_H

#include "cam_err.h"             // cam_err_t
#include "cam_feasible.h"        // cam_feasibility_t
#include "cam_offsets.h"         // cam_offsets_t
#include "cam_identify.h"        // cam_identify_t
#include "cam_param_store.h"     // cam_param_store_found_t
#include "cam_param.h"           // cam_params_t
#include "cam_rights.h"          // cam_rights_t
#include "cam_scope.h"           // cam_scope_t
#include "cam_strobe.h"          // cam_strobe_t
#include "cam_table.h"           // cam_table_t
#include "cam_ilc.h"             // cam_ilc_status_t, cam_ilc_harmonic_t
#include "cam_signature_check.h" // cam_signature_check_t
#include "cam_status.h"          // cam_t, cam_status_t
#include <stdbool.h>             // bool

/// Why a change or a command was refused, with the numbers.
typedef struct {
    cam_feasibility_t why; ///< .err is the error; of cam_err_param_tick only needed and limit hold,
                           ///< of cam_err_param_state none
    cam_param_id_t param;  ///< that may not change or does not fit the tick; cam_n_params: none
} cam_refusal_t;

/// What get_refusal tells of a refusal, by its number.
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

/// Where the parameters in force stand.
typedef enum {
    cam_kept_none,    ///< none are kept
    cam_kept_same,    ///< those in force are kept
    cam_kept_changed, ///< others are kept than those in force
    cam_kept_damaged, ///< what is kept cannot be used, so a start uses the defaults
} cam_kept_t;

/// The parameters in force, as a whole.
typedef struct {
    uint32_t version;  ///< rises with every change; that of the kept ones after a start
    uint32_t checksum; ///< cam_param_store_checksum()
    cam_kept_t kept;
} cam_params_status_t;

/// The slow side's state. Only has_table, table, trust, params, pass, n_parts, is_held, tick_hz,
/// refusal and kept are for others to read.
typedef struct {
    cam_t *core;                  ///< the interrupt's side
    cam_params_t params;          ///< as last set
    uint32_t version;             ///< of params: rises with every change
    uint32_t checksum;            ///< of params (cam_param_store_checksum())
    cam_param_store_found_t kept; ///< what the port keeps; .err is also that of handing it over
    uint32_t kept_checksum;       ///< of the kept parameters, when kept.err is cam_ok
    cam_params_t staged;          ///< parameters that are to change at once
    uint32_t staged_version;      ///< version on which those rest, UINT32_MAX when there are none
    cam_refusal_t refusal;        ///< why the last change or command was infeasible
    cam_table_t table;            ///< valid when has_table
    cam_signature_check_t signature; ///< verdict about its signature, valid when has_table
    bool has_table;                  ///< a good table is in use
    uint32_t tick_hz, clock_hz;      ///< from the port
    uint32_t generation;             ///< number of the newest configuration
    uint32_t n_requests;             ///< serial number of the last request
    bool homes_again;                ///< enable as soon as the state is off
    uint32_t pass;                   ///< the pass that is cut, or that start cuts next; from 0
    bool is_in_pass;                 ///< start was accepted, and the end of the pass not yet seen
    bool is_cut_short;               ///< stopped before its end: start cuts the same pass again
    uint32_t n_parts;                ///< parts that were cut to their end
    bool is_held;                    ///< the feed is to rest, whatever its override
    bool is_rate_due;                ///< ... and the interrupt does not know it yet
    uint32_t limit_mrpm;             ///< [r/min / 1000] overspeed of the newest configuration
    uint32_t n_checked;              ///< [bytes] progress of the background check of the table
    uint32_t checked_crc;            ///< CRC-32 of the bytes up to there
    cam_scope_t scope;               ///< recorder
    cam_strobe_t strobe;             ///< samples for a live picture
    bool has_box;                    ///< the recorder is the black box while nobody else needs it
    bool is_box_kept;                ///< the box that is done was handed to the port
    cam_identify_t identify;         ///< excitation of U
    cam_ilc_t ilc;                   ///< what was learned
    cam_offsets_t offsets;           ///< orders by hand, homes
    cam_rights_t rights;             ///< who may command, and change limits
    bool is_stop_due;                ///< command was lost: what moves by it is to stop
} cam_machine_t;

/// Bring interrupt and slow side into state off. To be called before the tick starts.
/// @param core     the interrupt's state, zeroed here
/// @param tick_hz  [Hz] result of hal_tick_hz(), 500 .. 100 000
/// @param clock_hz [Hz] result of hal_clock_hz()
void cam_machine_init(cam_machine_t *m, cam_t *core, uint32_t tick_hz, uint32_t clock_hz);

/// Check an image and take it into use.
/// @param size  [bytes] of the image and of the signature behind it
/// @return cam_ok; an image error; one of its signature; cam_err_state when neither off nor ready;
/// cam_err_table_sense
///         when ready and the table turns in the other sense; a feasibility error when ready;
///         cam_err_busy. On error the old table stays in force, unless the bad image is the one at
///         the very address of the old table: that is then treated as damaged, as if
///         cam_machine_poll() had found it.
/// Context: lasts as long as cam_signature_check_table().
CAM_MUST_USE cam_err_t cam_machine_select_table(cam_machine_t *m, const void *image, size_t size);

/// Set a parameter. In state off every parameter may change. In ready, where the spindle turns, all
/// may but those of the encoder and z_is_measured, and the result must be feasible; feed-forward
/// and limits of U may as soon as U is at rest, where the one adds nothing to the command and the
/// others are not exceeded. In the work only phase_udeg, amplitude_ppm, x_trim_nm,
/// feed_override_ppm and spindle_override_ppm may, and they are ramped. In manual the same may as
/// in ready. In the other states none may. What is refused for its numbers is in m->refusal.
/// @return cam_ok, cam_err_param_id, _range, _state, _tick, cam_err_trim_limit, cam_err_busy,
///         cam_err_u_place for a stroke within which U does not stand, cam_err_locked,
///         cam_err_lock_none (cam_rights.h), or a feasibility error, for example for an amplitude
///         that the running speed does not allow
CAM_MUST_USE cam_err_t cam_machine_set_param(cam_machine_t *m, cam_param_id_t id, int32_t value);

/// Begin to change several parameters at once: all are staged as they are in force.
void cam_machine_stage_begin(cam_machine_t *m);

/// Give a staged parameter a value. Nothing changes before cam_machine_stage_commit().
/// @return cam_ok, cam_err_params_begin, cam_err_param_id, cam_err_param_range
CAM_MUST_USE cam_err_t cam_machine_stage(cam_machine_t *m, cam_param_id_t id, int32_t value);

/// Bring all staged parameters into force in the same tick, or none of them. What differs from
/// those in force must be allowed to change in this state.
/// @return as cam_machine_set_param(); cam_err_params_begin; cam_err_params_stale when a parameter
///         was set since the begin. After cam_ok and cam_err_params_stale nothing is staged
CAM_MUST_USE cam_err_t cam_machine_stage_commit(cam_machine_t *m);

/// Have the port keep the parameters in force.
/// @return cam_ok, cam_err_state when not off, cam_err_busy, cam_err_params_keep; cam_err_locked
/// and
///         cam_err_lock_none where limits or constants differ from those that are kept
/// Context: lasts as long as hal_params_keep().
CAM_MUST_USE cam_err_t cam_machine_save_params(cam_machine_t *m);

/// Bring the defaults of this port into force; what is kept stays.
/// @return as cam_machine_set_param()
CAM_MUST_USE cam_err_t cam_machine_restore_defaults(cam_machine_t *m);

/// Bring the kept parameters into force again.
/// @return as cam_machine_set_param(), cam_err_params_none, cam_err_params_damaged
CAM_MUST_USE cam_err_t cam_machine_revert_params(cam_machine_t *m);

/// @return version and checksum of the parameters in force, and whether they are kept
cam_params_status_t cam_machine_params_status(const cam_machine_t *m);

/// Judge a speed for the selected table and the present parameters, the verdict alone: of all
/// passes, each at its own speed where none is given.
/// @param speed_mrpm  [r/min / 1000] 0: the speed that start would use
/// @return            cam_ok, a feasibility error, cam_err_no_table when none is selected
CAM_MUST_USE cam_err_t cam_machine_check_speed(const cam_machine_t *m, uint32_t speed_mrpm);

/// @return [r/min / 1000] highest speed feasible for all passes; 0 when there is none
uint32_t cam_machine_highest_mrpm(const cam_machine_t *m);

/// Judge a speed with all numbers, for a message to people (cam_feasible()): of the first pass that
/// is infeasible, or of the one that start cuts next.
/// @param speed_mrpm  [r/min / 1000] 0: the speed that start would use
/// @return            err = cam_err_no_table when none is selected, all numbers but the speed 0
cam_feasibility_t cam_machine_feasibility(const cam_machine_t *m, uint32_t speed_mrpm);

/// Enable the drives and search the index: off -> homing.
/// @return cam_ok, cam_err_state, _busy, _no_table, _estop, _drive, _bus, _u_place, _not_homed,
///         _travel (cam_machine_jog.h), cam_err_acknowledge, cam_err_acknowledge_none, or a
///         feasibility error
CAM_MUST_USE cam_err_t cam_machine_enable(cam_machine_t *m);

/// Search the index anew: in off as cam_machine_enable(); in ready -> off -> homing, where
/// cam_machine_poll() enables again. If that is refused, the machine stays off.
/// @return as cam_machine_enable() in off, as cam_machine_disable() in ready
CAM_MUST_USE cam_err_t cam_machine_home(cam_machine_t *m);

/// @return cam_ok when another table may be written and selected: the state is off or ready, in
///         which no tick reads a table, and the interrupt has taken all commands and
///         configurations; else cam_err_state, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_may_exchange(const cam_machine_t *m);

/// @return the same for parameters that are to be kept, but in off alone
CAM_MUST_USE cam_err_t cam_machine_may_keep(const cam_machine_t *m);

/// Judge an image as cam_machine_select_table() does, without taking it into use.
CAM_MUST_USE cam_err_t cam_machine_check_table(cam_machine_t *m, const void *image, size_t size);

/// Take the enable away: homing, ready -> off; manual -> off as soon as the axes rest. @return
/// cam_ok, cam_err_state, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_disable(cam_machine_t *m);

/// Cut one pass: ready -> engaging -> cutting -> disengaging -> ready. The next start cuts the next
/// pass, after the last one the first. A pass that ended in a stop or a fault is cut again. What is
/// infeasible in any pass is refused before anything moves.
/// @return cam_ok, cam_err_state, _busy (also while the spindle is faster than the pass allows), or
///         a feasibility error, whose numbers
///         cam_machine_feasibility() gives
CAM_MUST_USE cam_err_t cam_machine_start(cam_machine_t *m);

/// End the cut early: engaging, cutting, holding -> disengaging; while the axes still approach ->
/// ready. In manual brake what moves.
/// @return cam_ok, cam_err_state, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_stop(cam_machine_t *m);

/// Acknowledge a fault: fault -> off, once the retract has ended. @return cam_ok, cam_err_state,
/// cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_reset(cam_machine_t *m);

/// Begin to hand over what was learned: everything else stays as it was handed over last, and
/// nothing is judged anew. Between this and cam_machine_learn_end() no other function may be
/// called.
/// @return what is in force, to be changed in place; NULL while the interrupt has not taken the
///         last configuration
cam_learned_t *cam_machine_learn_begin(cam_machine_t *m);

/// Hand over what cam_machine_learn_begin() gave. It is in force from the next tick on, with a new
/// generation. |k1| and |k2|, with those configured, stay below 2^31.
void cam_machine_learn_end(cam_machine_t *m);

/// @return a consistent copy of the status that the interrupt published last
cam_status_t cam_machine_status(const cam_machine_t *m);

/// Background work, to be called from the main loop: one kilobyte of the continuous check of the
/// table per call, the second half of cam_machine_home(), and the step to the next pass. A table
/// found damaged is no longer used and raises the fault `table`.
void cam_machine_poll(cam_machine_t *m);

/// A parameter was set: what was learned on top of it is forgotten, or led to it. Called by
/// cam_machine_set_param().
void cam_machine_unlearn(cam_machine_t *m, cam_param_id_t id);

/// One piece of learning: takes a turn from the interrupt, treats one harmonic of it, or leads what
/// is in force one step towards what was learned. A part of cam_machine_poll(); a loop that calls
/// that one seldom calls this one more often, at least a hundred times per turn of the spindle.
/// @param state  as the status says
void cam_machine_ilc_poll(cam_machine_t *m, cam_state_t state);

/// @return what learning does, and what it has reached
cam_ilc_status_t cam_machine_learning(const cam_machine_t *m);

/// @param k  0 .. cam_ilc_harmonics, 0 is the mean
/// @return   what is known of a harmonic, all 0 beyond those
cam_ilc_harmonic_t cam_machine_harmonic(const cam_machine_t *m, uint32_t k);

/// Read one of the learned values, to keep them.
/// @param index  below cam_ilc_n_values
/// @return       cam_ok, cam_err_param_id when there is no such value
CAM_MUST_USE cam_err_t cam_machine_get_learned(const cam_machine_t *m, uint32_t index,
                                               int32_t *value);

/// Set one of the learned values, as they were kept. In the states off and ready; what changes
/// goes to the interrupt in steps.
/// @return cam_ok, cam_err_param_id, cam_err_param_range, or cam_err_param_state
CAM_MUST_USE cam_err_t cam_machine_set_learned(cam_machine_t *m, uint32_t index, int32_t value);

#endif
