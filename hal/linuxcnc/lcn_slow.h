// SPDX-License-Identifier: Apache-2.0
/// lcn_slow: the main loop of the firmware as a function of a slow HAL thread: table, parameters,
/// commands from pins, status to pins.
///
/// LinuxCNC runs all its threads on one processor and the faster preempt the slower, as the
/// firmware expects of interrupt and main loop. Only lcn_slow_load(), called while the component is
/// loaded, allocates memory and opens a file; later the thread of lcn_reload.h does.
#ifndef LCN_SLOW_H
#define LCN_SLOW_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t

/// Command pins: levels, as set by M64 and M65, and trims that are added to parameters.
typedef struct {
    bool enables; ///< rising: acknowledge a fault, home U, enable, find the index; falling: disable
    bool starts;  ///< rising: cut one pass; falling: end it
    bool reloads; ///< rising: use the present content of the table file, in off and ready
    bool records; ///< rising: record; falling: end (lcn_record.h)
    int32_t x_trim_nm;  ///< [nm]
    int32_t phase_udeg; ///< [degree / 10^6]
} lcn_commands_t;

/// Status pins.
typedef struct {
    int32_t error;        ///< last refusal, cam_err_t; 0: the last command was accepted
    uint32_t state;       ///< cam_state_t
    bool is_ready;        ///< start is accepted
    bool is_homed;        ///< the position of U is known
    bool is_reloading;    ///< a reload is not yet done or refused
    bool is_recording;    ///< a recording is not yet finished
    uint32_t faults;      ///< latched
    uint32_t n_late;      ///< late ticks
    double turns;         ///< [turn] master position
    double rpm;           ///< [r/min] speed of the spindle
    int32_t u_nm;         ///< [nm] measured U, from its home
    int32_t following_nm; ///< [nm] measured U minus its commanded position
    uint32_t learned_nm;  ///< [nm] rms error of the last turn used for learning
} lcn_status_t;

/// Initialise the firmware, after lcn_port_init().
/// @param tick_hz     [Hz] as in lcn_setup_t
/// @param recordings  as in lcn_record_begin()
void lcn_slow_init(uint32_t tick_hz, const char *recordings);

/// Read and select a table; errors are printed. Context: while the component is loaded, before the
/// threads run.
/// @param path  .camtab file
/// @return      false if the table cannot be used
bool lcn_slow_load(const char *path);

/// One round of the main loop: apply parameters, execute commands, learn.
/// @param values    HAL parameters, in the order of cam_param.h; a refused one is reset, so
///                  that it and the trim together are the value in use
/// @param period_ns [ns] period of the slow thread
void lcn_slow_poll(volatile int32_t *values, const lcn_commands_t *commands, int32_t period_ns);

/// @return number of parameters
int32_t lcn_slow_n_params(void);

/// @return name of a parameter, with the unit as its last word; index as in cam_param.h
const char *lcn_slow_param_name(int32_t index);

/// @return initial HAL value: the value in use, but 0 for the observer bandwidth, which is then
///         derived from the speed in state off, MATHS.md (188)
int32_t lcn_slow_default(int32_t index);

/// @return value in use
int32_t lcn_slow_param(int32_t index);

/// @return [counts] per turn of the encoder, value in use. Context: any thread
int32_t lcn_slow_turn_counts(void);

/// @return status of the machine. Context: slow thread
lcn_status_t lcn_slow_status(void);

#endif
