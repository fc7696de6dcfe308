// SPDX-License-Identifier: Apache-2.0
/// cam_machine: the slow side's view of the controller: table, parameters, commands, status.
///
/// A command is checked here against the last status, posted to the interrupt and carried out at
/// the next tick; cam_machine_status() tells the outcome. Parameters and table are gathered here
/// and handed to the interrupt as one configuration (cam_config.h), so the interrupt never sees
/// half a change. All functions: slow side, one caller.
#ifndef CAM_MACHINE_H
#define CAM_MACHINE_H

#include "cam_err.h"      // cam_err_t
#include "cam_feasible.h" // cam_feasibility_t
#include "cam_param.h"    // cam_params_t
#include "cam_table.h"    // cam_table_t
#include "cam_tick.h"     // cam_t, cam_status_t
#include <stdbool.h>      // bool

/// The slow side's state.
typedef struct {
    cam_t *core;         ///< the interrupt's side
    cam_params_t params; ///< as last set
    cam_table_t table;   ///< valid when has_table
    bool has_table;
    uint32_t tick_hz, clock_hz; ///< from the port
    uint32_t generation;        ///< of the configuration
    uint32_t n_requests;        ///< serial number of the last request
    bool homes_again;           ///< enable as soon as off
    uint32_t scrub_at;          ///< [bytes] progress of the background check
    uint32_t scrub_crc;
} cam_machine_t;

/// Bring controller and slow side into state off. Call before the tick starts.
/// @param core     the interrupt's state, zeroed here
/// @param tick_hz  [Hz] 500 .. 100 000, as hal_tick_hz()
/// @param clock_hz [Hz] as hal_clock_hz()
void cam_machine_init(cam_machine_t *m, cam_t *core, uint32_t tick_hz, uint32_t clock_hz);

/// Check an image and take it into use.
/// @return cam_ok, an image error, cam_err_state when not off or ready, cam_err_busy. The old table
///         stays in force on error, unless it is the image at this very address that is bad: then
///         it is damaged, as if cam_machine_poll() had found it.
CAM_MUST_USE cam_err_t cam_machine_select_table(cam_machine_t *m, const void *image, size_t size);

/// Set a parameter. While engaging, cutting or disengaging only phase_udeg and amplitude_ppm may
/// change; both are ramped. In state off everything may; in ready all but the encoder's, the
/// feed-forward of U and whether Z is measured, and what they lead to must be feasible: the spindle
/// turns.
/// @return cam_ok, cam_err_param_id, _range, _state, _tick, cam_err_busy, or a feasibility error
/// for an
///         amplitude that the running speed does not allow
CAM_MUST_USE cam_err_t cam_machine_set_param(cam_machine_t *m, cam_param_id_t id, int32_t value);

/// Judge a speed for the selected table and the present parameters.
/// @param speed_mrpm  [r/min / 1000] 0: the speed that start would use
/// @return            err = cam_err_no_table when none is selected
cam_feasibility_t cam_machine_feasibility(const cam_machine_t *m, uint32_t speed_mrpm);

/// off -> homing. @return cam_ok, cam_err_state, _busy, _no_table, _estop, _drive, _u_place or a
/// feasibility error
CAM_MUST_USE cam_err_t cam_machine_enable(cam_machine_t *m);

/// off -> homing as cam_machine_enable(); ready -> off -> homing: find the index anew. What refuses
/// the enable then leaves the machine off.
/// @return as cam_machine_enable(), cam_machine_disable()
CAM_MUST_USE cam_err_t cam_machine_home(cam_machine_t *m);

/// @return cam_ok when another table may be written and selected: off, and nothing is on its way to
///         the interrupt; cam_err_state, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_may_exchange(const cam_machine_t *m);

/// homing, ready -> off. @return cam_ok, cam_err_state, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_disable(cam_machine_t *m);

/// ready -> engaging -> cutting -> disengaging -> ready, refused before motion when infeasible.
/// @return cam_ok, cam_err_state, _busy, or a feasibility error (numbers:
/// cam_machine_feasibility())
CAM_MUST_USE cam_err_t cam_machine_start(cam_machine_t *m);

/// engaging, cutting -> disengaging, from the approach -> ready. @return cam_ok, cam_err_state,
/// cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_stop(cam_machine_t *m);

/// fault -> off, when the retract has ended. @return cam_ok, cam_err_state, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_reset(cam_machine_t *m);

/// @return a consistent copy of what the interrupt published last
cam_status_t cam_machine_status(const cam_machine_t *m);

/// Background work: one kilobyte of the continuous table check per call. A damaged table becomes
/// the fault `table`. Call from the main loop.
void cam_machine_poll(cam_machine_t *m);

#endif
