// SPDX-License-Identifier: Apache-2.0
/// fixture_rig: an ideal machine around hal/host: the spindle follows its set-point on a ramp, axes
/// reach their set-points within one tick. Every fault is caused by the test itself.
#ifndef FIXTURE_RIG_H
#define FIXTURE_RIG_H

#include "cam/cam_machine.h" // cam_machine_t
#include "fixture_encoder.h" // fixture_encoder_t
#include "fixture_image.h"   // fixture_image_t
#include <stdbool.h>         // bool
#include <stdint.h>          // int32_t

typedef struct {
    cam_machine_t machine;
    fixture_encoder_t encoder;
    fixture_image_t image;
    double rpm;             ///< in the raw sense of counts
    double ramp_rpm;        ///< change of rpm per tick
    void (*isr)(void);      ///< called instead of cam_isr(), when not NULL
    bool is_spindle_held;   ///< rpm stays as the test sets it
    bool is_z_held;         ///< measured Z stays as the test sets it
    int32_t u_error_nm;     ///< added to the measured U
    bool is_swing_held;     ///< measured swing stays as the test sets it
    uint32_t n_swing;       ///< set-points of the swing that were seen
    cam_tick_record_t last; ///< what the newest tick did
    cam_tick_record_t *log; ///< every record, when not NULL
    uint32_t n_log, log_capacity;
} fixture_rig_t;

/// Reset everything; select the part's table; lead of one tick, which is exact for ideal axes.
void fixture_rig_init(fixture_rig_t *rig, const fixture_part_t *part, uint32_t tick_hz);

/// Let ticks pass.
void fixture_rig_tick(fixture_rig_t *rig);
void fixture_rig_ticks(fixture_rig_t *rig, uint32_t n);

/// Tick until a state is reached. @return ticks that passed, n_max when it was not reached
uint32_t fixture_rig_until(fixture_rig_t *rig, cam_state_t state, uint32_t n_max);

/// From off into a state by the commands of an operator. @return true when it is reached
bool fixture_rig_bring(fixture_rig_t *rig, cam_state_t state);

/// Set a parameter, waiting until it is taken.
cam_err_t fixture_rig_set(fixture_rig_t *rig, cam_param_id_t id, int32_t value);

/// @return the newest status
cam_status_t fixture_rig_status(const fixture_rig_t *rig);

#endif
