// SPDX-License-Identifier: Apache-2.0
/// cam_trigger: trigger condition of a recording (cam_scope.h).
///
/// A trigger compares a value with that of the previous tick and fires when its condition becomes
/// true. In the first tick only those fire that need no previous value. Context: slow side.
#ifndef CAM_TRIGGER_H
#define CAM_TRIGGER_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// When a trigger fires. The number is part of the CAN protocol.
typedef enum {
    cam_trigger_now,   ///< at once
    cam_trigger_time,  ///< `level` ticks after the start
    cam_trigger_level, ///< a signal, as an int32, reaches `level`
    cam_trigger_angle, ///< the spindle's angle passes `level` [turn / 2^32]
    cam_trigger_state, ///< the state becomes `level`, a cam_state_t
    cam_trigger_fault, ///< a fault of the bits `level` is latched; 0: any fault
    cam_trigger_n
} cam_trigger_kind_t;

/// A trigger.
typedef struct {
    cam_trigger_kind_t kind;
    uint32_t signal; ///< cam_scope_signal_t, of kind level
    int32_t level;   ///< in the unit of the value
    bool falls;      ///< level, angle: fires on falling values, else on rising ones
} cam_trigger_t;

/// Value of the previous tick, if there was one.
typedef struct {
    bool is_there;
    int32_t value;
} cam_trigger_last_t;

/// @param last  of the previous tick
/// @param now   of this tick; kind time: ticks since the start
/// @return      whether the trigger fires in this tick
bool cam_trigger_fires(const cam_trigger_t *t, cam_trigger_last_t last, int32_t now);

#endif
