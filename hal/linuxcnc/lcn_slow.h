// SPDX-License-Identifier: Apache-2.0
/// lcn_slow: the main loop of the firmware as a function of a slow HAL thread: table, parameters,
/// the commands that pins give, and the status that pins show.
///
/// LinuxCNC runs all its threads on one processor, the slower ones interrupted by the faster ones,
/// which is what the firmware expects of interrupt and main loop. Nothing here allocates memory or
/// opens a file but lcn_slow_load(), which is called while the component is loaded.
#ifndef LCN_SLOW_H
#define LCN_SLOW_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t

/// What pins command. Levels, as M64 and M65 give them.
typedef struct {
    bool enables; ///< rising: acknowledge a fault, enable the drives, home; falling: disable
    bool starts;  ///< rising: cut one pass; falling: end it
} lcn_commands_t;

/// What pins show.
typedef struct {
    int32_t error;        ///< the last refusal, a cam_err_t; 0: the last command was accepted
    uint32_t state;       ///< cam_state_t
    bool is_ready;        ///< start is accepted
    uint32_t faults;      ///< latched
    uint32_t n_late;      ///< ticks that came too late
    double turns;         ///< [turn] master position
    double rpm;           ///< [r/min] speed of the spindle
    int32_t following_nm; ///< [nm] measured U less where it should be
    uint32_t learned_nm;  ///< [nm] rms error of the last turn that was learned from
} lcn_status_t;

/// Bring the firmware up. @param tick_hz  [Hz] as in lcn_setup_t, which the port holds already
void lcn_slow_init(uint32_t tick_hz);

/// Read a table and take it into use; a refusal is said in one line. Context: while the component
/// is loaded, before the threads run.
/// @param path  of a .camtab file
/// @return      false when the table cannot be used
bool lcn_slow_load(const char *path);

/// One round of the main loop: take over parameters, carry out commands, learn.
/// @param values    the parameters, in their order, as HAL shows them; one that is refused is set
///                  back to what is in force
/// @param period_ns [ns] of the slow thread
void lcn_slow_poll(volatile int32_t *values, const lcn_commands_t *commands, int32_t period_ns);

/// @return number of parameters
int32_t lcn_slow_n_params(void);

/// @return name of a parameter, with the unit as its last word; index as in cam_param.h
const char *lcn_slow_param_name(int32_t index);

/// @return what HAL shows of a parameter at the start: what is in force, and 0 of the observer's
///         bandwidth, which is then derived from the speed in state off, MATHS.md (188)
int32_t lcn_slow_default(int32_t index);

/// @return what is in force of a parameter
int32_t lcn_slow_param(int32_t index);

/// @return [counts] per turn of the encoder that are in force. Context: any thread
int32_t lcn_slow_turn_counts(void);

/// @return what is known of the machine. Context: slow thread
lcn_status_t lcn_slow_status(void);

#endif
