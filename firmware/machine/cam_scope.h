// SPDX-License-Identifier: Apache-2.0
/// cam_scope: recorder of chosen signals at tick rate, in the memory that the port gives.
///
///     set signals, every, rows -> start -> (from_state) -> recording -> done -> read the words
///
/// The slow side takes the records of the trace ring (cam_trace.h), so that the interrupt pays
/// nothing. It is the only reader of the ring: whoever wants the records as well takes them
/// himself and hands them on by cam_scope_take(). A row holds the chosen signals of one tick as
/// int32, in the order of the list; rows are `every` ticks apart. A recording ends when the rows
/// that were asked for are there, when the memory is full, when the state that it waited for is
/// left, by a stop, or at a gap: then the main loop came more than cam_trace_capacity ticks late, a
/// record was lost, and what is there is without gaps but not whole.
///
/// Triggers are conditions of take(): `from_state` is the only one so far. Works in all states.
/// Context: slow side.
#ifndef CAM_SCOPE_H
#define CAM_SCOPE_H

#include "cam_err.h"    // CAM_MUST_USE
#include "cam_record.h" // cam_tick_record_t
#include "cam_trace.h"  // cam_trace_t
#include "hal/hal.h"    // hal_memory_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t

// clang-format off
/// Signals: X(name, value of the record r, what). The name ends in the unit, the value is an int32
/// or an uint32 with the same bits; the number of a signal is part of the CAN protocol.
#define CAM_SCOPE_SIGNALS(X) \
    X(tick,          r->tick,                              "number of the tick, wraps") \
    X(state,         r->want.state,                        "cam_state_t") \
    X(u_set_q6,      r->want.u_set_q6,                     "set-point of U, nm / 64") \
    X(u_due_q6,      r->want.u_due_q6,                     "where U should be in this tick, nm / 64") \
    X(u_command_nm,  r->out[hal_axis_u].pos_nm,            "U as written, feed-forward included") \
    X(u_actual_nm,   r->in.actual_nm[hal_axis_u],          "U as measured") \
    X(u_vel_q10,     r->out[hal_axis_u].vel_q10,           "speed of U's set-point, nm / 1024 per tick") \
    X(u_acc_q10,     r->out[hal_axis_u].acc_q10,           "its acceleration, nm / 1024 per tick^2") \
    X(turn,          (uint64_t)r->angle.pos_q32 >> 32,     "whole turns of the master position") \
    X(angle_q32,     (uint64_t)r->angle.pos_q32,           "angle in the sense of cutting, turn / 2^32") \
    X(speed_q32,     r->angle.speed_q32,                   "turn / 2^32 per tick") \
    X(counts,        r->in.encoder.counts,                 "of the spindle's encoder, wraps") \
    X(index_counts,  r->in.encoder.index_counts,           "counts at the last index edge") \
    X(n_index,       r->in.encoder.n_index,                "index edges") \
    X(edge_clock,    r->in.encoder.edge_clock,             "time of the last count edge, 1 / clock rate") \
    X(clock,         r->in.clock,                          "time of the tick, 1 / clock rate") \
    X(x_command_nm,  r->out[hal_axis_x].pos_nm,            "X as written") \
    X(x_actual_nm,   r->in.actual_nm[hal_axis_x],          "X as measured") \
    X(z_command_nm,  r->out[hal_axis_z].pos_nm,            "Z as written") \
    X(z_actual_nm,   r->in.actual_nm[hal_axis_z],          "Z as measured") \
    X(z_nm,          r->want.z_nm,                         "height that is played") \
    X(swing_q32,     r->in.swing_q32,                      "swing of the tool as measured, turn / 2^32") \
    X(spindle_mrpm,  r->want.spindle_mrpm,                 "set-point of the spindle, signed") \
    X(faults,        r->want.faults,                       "latched, a bit each") \
    X(inputs,        r->in.inputs,                         "hal_in_*") \
    X(outputs,       r->want.outputs,                      "hal_out_*") \
    X(config,        r->config,                            "generation of the configuration in force")

/// What is set and told of a recording: X(name, may it be set, what).
#define CAM_SCOPE_FIELDS(X) \
    X(signals,    true,  "bit i: signal i is recorded") \
    X(every,      true,  "ticks from row to row, 1 .. 1000000") \
    X(rows,       true,  "rows that are wanted; 0: as many as fit") \
    X(from_state, true,  "record while the state is this one; -1: whatever the state") \
    X(phase,      false, "cam_scope_phase_t") \
    X(end,        false, "cam_scope_end_t") \
    X(n_rows,     false, "rows that are there") \
    X(n_signals,  false, "words of a row") \
    X(first_tick, false, "tick of the first row") \
    X(n_lost,     false, "records that the gap at the end has lost; 0: the recording is whole") \
    X(number,     false, "recordings begun since the start, this one included") \
    X(tick_hz,    false, "rate of the ticks") \
    X(n_words,    false, "words of the memory") \
    X(n_wave,     false, "words at its begin that hold a wave") \
    X(excited,    false, "cam_excited_t: what came of the last excitation") \
    X(place_nm,   true,  "place of U about which a wave is played") \
    X(n_fall,     false, "ticks at the end of an excitation in which its gain falls")
// clang-format on

/// Number of a signal.
typedef enum {
#define CAM_SCOPE_SIGNAL_ID(name, value, what) cam_scope_##name,
    CAM_SCOPE_SIGNALS(CAM_SCOPE_SIGNAL_ID)
#undef CAM_SCOPE_SIGNAL_ID
        cam_scope_n_signals
} cam_scope_signal_t;

_Static_assert(cam_scope_n_signals <= 32, "a set of signals is one word");

/// Number of a field.
typedef enum {
#define CAM_SCOPE_FIELD_ID(name, is_set, what) cam_scope_field_##name,
    CAM_SCOPE_FIELDS(CAM_SCOPE_FIELD_ID)
#undef CAM_SCOPE_FIELD_ID
        cam_scope_n_fields
} cam_scope_field_t;

/// What the recorder does.
typedef enum {
    cam_scope_idle,
    cam_scope_armed, ///< waits for the state
    cam_scope_recording,
    cam_scope_done,
} cam_scope_phase_t;

/// Why a recording ended.
typedef enum {
    cam_scope_open,       ///< it has not
    cam_scope_full,       ///< the rows are there, or the memory is full
    cam_scope_stopped,    ///< by command
    cam_scope_state_left, ///< the state that it waited for was left
    cam_scope_gap,        ///< a record was lost
} cam_scope_end_t;

/// State; made by cam_scope_init().
typedef struct {
    int32_t *words;      ///< of the whole memory
    uint32_t n_words;    ///< [words]
    uint32_t n_wave;     ///< [words] at the begin that the rows leave alone
    uint32_t tick_hz;    ///< [Hz]
    uint32_t signals;    ///< set: bit i is signal i
    uint32_t every;      ///< set [ticks]
    uint32_t rows;       ///< set; 0: as many as fit
    int32_t from_state;  ///< set: cam_state_t, or -1
    uint32_t taken;      ///< signals of this recording
    uint32_t step;       ///< [ticks] of this recording
    int32_t in_state;    ///< of this recording
    uint32_t most_rows;  ///< of this recording
    uint32_t n_signals;  ///< [words] of a row
    uint32_t n_rows;     ///< that are there
    uint32_t not_before; ///< [ticks] records of before the start are passed over
    uint32_t first_tick; ///< of the first row
    uint32_t last_tick;  ///< taken last
    uint32_t n_lost;     ///< [records]
    uint32_t number;     ///< recordings begun
    cam_scope_phase_t phase;
    cam_scope_end_t end;
} cam_scope_t;

/// Begin without a recording; set are set-point, command and measured U, every tick.
void cam_scope_init(cam_scope_t *s, hal_memory_t memory, uint32_t tick_hz);

/// Set a field for the recordings to come.
/// @return cam_ok, cam_err_scope_field (no such field, or none that can be set),
/// cam_err_scope_range
CAM_MUST_USE cam_err_t cam_scope_set(cam_scope_t *s, uint32_t field, int32_t value);

/// Read a field; `signals` and `every` are those of the recording that is there, if one is.
/// `excited`, `place_nm` and `n_fall` are those of cam_machine_identify.h and read as 0 here.
/// @return cam_ok, cam_err_scope_field
CAM_MUST_USE cam_err_t cam_scope_get(const cam_scope_t *s, uint32_t field, int32_t *value);

/// Begin a recording; what was recorded before is lost.
/// @param tick  newest tick, from which on it is recorded
/// @return      cam_ok, cam_err_scope_memory (not even one row fits)
CAM_MUST_USE cam_err_t cam_scope_start(cam_scope_t *s, uint32_t tick);

/// End the recording, if there is one.
void cam_scope_stop(cam_scope_t *s);

/// Keep n words at the begin of the memory for a wave. The recording that is there is lost.
void cam_scope_reserve(cam_scope_t *s, uint32_t n_wave);

/// Take a record, in the order of the ticks.
void cam_scope_take(cam_scope_t *s, const cam_tick_record_t *r);

/// Take all records of the ring, while a recording waits for them; else they stay.
/// Context: to be called at least every cam_trace_capacity / 2 ticks.
void cam_scope_poll(cam_scope_t *s, cam_trace_t *trace);

/// @return whether a recording waits for records
static inline bool cam_scope_is_on(const cam_scope_t *s)
{
    return s->phase == cam_scope_armed || s->phase == cam_scope_recording;
}

/// @return words of the rows that are there, row by row
static inline uint32_t cam_scope_n_recorded(const cam_scope_t *s)
{
    return s->n_rows * s->n_signals;
}

/// @return first word of the recording
static inline const int32_t *cam_scope_recorded(const cam_scope_t *s)
{
    return &s->words[s->n_wave];
}

/// @return name of a signal with its unit as the last word, static; "?" for a foreign number
const char *cam_scope_signal_name(uint32_t signal);

#endif
