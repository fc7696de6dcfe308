// SPDX-License-Identifier: Apache-2.0
/// cam_recorder: records signals of the ticks: scope and black box.
///
/// The slow side reads the records of the trace ring (cam_tick.h), so the interrupt does nothing
/// for them; cam_machine.h is the only reader. The scope records by command, the black box is a
/// recording of the scope that a fault triggers. Context of all functions: slow side.
#ifndef CAM_RECORDER_H
#define CAM_RECORDER_H

#include "cam_err.h"    // CAM_MUST_USE
#include "cam_record.h" // cam_tick_record_t
#include "cam_state.h"  // cam_state_t
#include "hal/hal.h"    // hal_memory_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint8_t, uint32_t

/// Scope: selected signals at tick rate, in the memory that the port provides.
///
///     set signals, every, rows, trigger -> start -> armed -> recording -> done -> read the rows
///
/// A row holds the selected signals of one tick as int32, in the order of the list; rows are
/// `every` ticks apart.
///
/// Armed, the recorder evaluates the trigger in every tick and keeps the last `before` rows in a
/// ring; after an early trigger there are fewer (`n_before`). From the tick of the trigger it
/// records the other `rows` less `before` rows. It ends when they are complete, when the selected
/// state is left, by a stop, or at a gap: the main loop was more than cam_trace_capacity ticks late
/// and a record is lost. The rows before the gap are continuous. A gap before the trigger empties
/// the ring. Works in all states.

// clang-format off
/// Signals: X(name, value of the record r, what). The name ends in the unit; the value is an int32
/// or the bits of an uint32. The number of a signal is part of the CAN protocol.
#define CAM_SCOPE_SIGNALS(X) \
    X(tick,          r->tick,                              "number of the tick, wraps") \
    X(state,         r->want.state,                        "cam_state_t") \
    X(u_set_q6,      r->want.u_set_q6,                     "set-point of U, nm / 64") \
    X(u_due_q6,      r->want.u_due_q6,                     "position at which U is due in this tick, nm / 64") \
    X(u_command_nm,  r->out[hal_axis_u].pos_nm,            "command of U, with feed-forward") \
    X(u_actual_nm,   r->in.actual_nm[hal_axis_u],          "measured U") \
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
    X(x_command_nm,  r->out[hal_axis_x].pos_nm,            "command of X") \
    X(x_actual_nm,   r->in.actual_nm[hal_axis_x],          "measured X") \
    X(z_command_nm,  r->out[hal_axis_z].pos_nm,            "command of Z") \
    X(z_actual_nm,   r->in.actual_nm[hal_axis_z],          "measured Z") \
    X(z_nm,          r->want.z_nm,                         "height in the table") \
    X(swing_q32,     r->in.swing_q32,                      "measured swing of the tool, turn / 2^32") \
    X(spindle_mrpm,  r->want.spindle_mrpm,                 "set-point of the spindle, signed") \
    X(faults,        r->want.faults,                       "latched, a bit each") \
    X(inputs,        r->in.inputs,                         "hal_in_*") \
    X(outputs,       r->want.outputs,                      "hal_out_*") \
    X(config,        r->config,                            "generation of the configuration in force") \
    X(u_force_q6,    r->force_q6,                          "force of U, mN / 64; 0 where U takes positions")

/// Fields of a recording: X(name, can be set, value, what). The value is an int32 or the bits of an
/// uint32.
#define CAM_SCOPE_FIELDS(X) \
    X(signals,      true,  reported_plan(s)->signals,       "bit i: signal i is recorded") \
    X(every,        true,  reported_plan(s)->every,         "ticks from row to row, 1 .. 1000000") \
    X(rows,         true,  s->set.rows,                     "requested rows; 0: as many as fit") \
    X(from_state,   true,  s->set.from_state,               "record in this state only; -1: in all states") \
    X(phase,        false, s->phase,                        "cam_scope_phase_t") \
    X(end,          false, s->end,                          "cam_scope_end_t") \
    X(n_rows,       false, s->ring.n_rows,                  "recorded rows") \
    X(n_signals,    false, s->n_signals,                    "words of a row") \
    X(first_tick,   false, s->ring.first_tick,              "tick of the first row") \
    X(n_lost,       false, s->ring.n_lost,                  "records lost in the gap at the end; 0: none") \
    X(number,       false, s->number,                       "recordings since the start, with this one") \
    X(tick_hz,      false, s->tick_hz,                      "tick rate") \
    X(n_words,      false, s->n_words,                      "words of the memory") \
    X(n_wave,       false, s->n_wave,                       "words of the wave at its start") \
    X(excited,      false, 0,                               "cam_excited_t: result of the last excitation") \
    X(place_nm,     true,  0,                               "position of U about which a wave is played") \
    X(n_fall,       false, 0,                               "ticks at the end of an excitation over which its gain falls") \
    X(before,       true,  s->set.before,                   "requested rows before the trigger, fewer than rows") \
    X(trigger,      true,  s->set.trigger.kind,             "cam_trigger_kind_t") \
    X(watched,      true,  s->set.trigger.signal,           "signal of the trigger level") \
    X(level,        true,  s->set.trigger.level,            "of the trigger, cam_trigger_t") \
    X(edge,         true,  s->set.trigger.falls ? 1 : 0,    "0: rising, 1: falling") \
    X(use,          false, s->use,                          "cam_scope_use_t: owner of the recording") \
    X(n_before,     false, s->ring.n_before,                "recorded rows before the trigger") \
    X(trigger_tick, false, s->ring.trigger_tick,            "tick in which the trigger fired") \
    X(faults,       false, s->ring.faults,                  "faults latched in that tick, a bit each") \
    X(wave_unit,    true,  0,                               "of the samples of a wave: 0 nm, 1 mN of force")
// clang-format on

typedef enum {
#define CAM_SCOPE_SIGNAL_ID(name, value, what) cam_scope_##name,
    CAM_SCOPE_SIGNALS(CAM_SCOPE_SIGNAL_ID)
#undef CAM_SCOPE_SIGNAL_ID
        cam_scope_n_signals
} cam_scope_signal_t;

_Static_assert(cam_scope_n_signals <= 32, "a set of signals is one word");

typedef enum {
#define CAM_SCOPE_FIELD_ID(name, is_set, value, what) cam_scope_field_##name,
    CAM_SCOPE_FIELDS(CAM_SCOPE_FIELD_ID)
#undef CAM_SCOPE_FIELD_ID
        cam_scope_n_fields
} cam_scope_field_t;

typedef enum {
    cam_scope_idle,
    cam_scope_armed, ///< waiting for the state or the trigger
    cam_scope_recording,
    cam_scope_done,
} cam_scope_phase_t;

/// Why a recording ended.
typedef enum {
    cam_scope_open,       ///< it has not ended
    cam_scope_full,       ///< all rows are recorded
    cam_scope_stopped,    ///< by command
    cam_scope_state_left, ///< the selected state was left
    cam_scope_gap,        ///< a record was lost
} cam_scope_end_t;

typedef enum {
    cam_scope_nobody,
    cam_scope_user, ///< by command, or of an excitation
    cam_scope_box,  ///< the black box
} cam_scope_use_t;

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

/// A trigger. It compares a value with that of the previous tick and fires when its condition
/// becomes true.
typedef struct {
    cam_trigger_kind_t kind;
    uint32_t signal; ///< cam_scope_signal_t, of kind level
    int32_t level;   ///< in the unit of the value
    bool falls;      ///< level, angle: fires on falling values, else on rising ones
} cam_trigger_t;

/// Value of the trigger in the previous tick, if there was one.
typedef struct {
    bool is_there;
    int32_t value;
} cam_trigger_last_t;

typedef struct {
    uint32_t signals;   ///< bit i is signal i
    uint32_t every;     ///< [ticks] from row to row
    uint32_t rows;      ///< requested; 0: as many as fit
    uint32_t before;    ///< [rows] of them before the trigger
    int32_t from_state; ///< cam_state_t to record in, or -1
    cam_trigger_t trigger;
} cam_scope_plan_t;

typedef struct {
    uint32_t most_rows;    ///< that fit
    uint32_t oldest;       ///< index of the first row
    uint32_t n_rows;       ///< recorded
    uint32_t n_before;     ///< of these before the trigger
    uint32_t first_tick;   ///< of the first row
    uint32_t trigger_tick; ///< tick in which the trigger fired
    uint32_t faults;       ///< latched in that tick
    uint32_t n_lost;       ///< [records]
} cam_scope_ring_t;

/// State; made by cam_scope_init().
typedef struct {
    int32_t *words;        ///< of the whole memory
    uint32_t n_words;      ///< [words]
    uint32_t n_wave;       ///< [words] of the wave at the start
    uint32_t tick_hz;      ///< [Hz]
    cam_scope_plan_t set;  ///< for the next recordings
    cam_scope_plan_t plan; ///< of this recording
    cam_scope_use_t use;
    cam_scope_phase_t phase;
    cam_scope_end_t end;
    uint32_t at;                        ///< [words] start of the ring
    cam_scope_ring_t ring;              ///< in order without a trigger
    uint32_t n_signals;                 ///< [words] of a row
    uint8_t order[cam_scope_n_signals]; ///< the signals of a row
    uint32_t to_row;                    ///< [ticks] to the next row
    uint32_t start_tick;                ///< earlier records are ignored
    uint32_t last_tick;                 ///< newest, if there is a last value
    cam_trigger_last_t last;            ///< value of the trigger
    uint32_t number;                    ///< of recordings since the start
} cam_scope_t;

typedef struct {
    const uint8_t *bytes;
    uint32_t n;
} cam_scope_span_t;

/// Initialise without a recording; selected are set-point, command and measured U in every tick.
void cam_scope_init(cam_scope_t *s, hal_memory_t memory, uint32_t tick_hz);

/// Set a field for the next recordings.
/// @return cam_ok, cam_err_scope_field (unknown or read-only), cam_err_scope_range
CAM_MUST_USE cam_err_t cam_scope_set(cam_scope_t *s, uint32_t field, int32_t value);

/// Read a field; `signals` and `every` are those of the present recording, if there is one.
/// `excited`, `place_nm`, `wave_unit` and `n_fall` belong to cam_machine.h and read as 0 here.
/// @return cam_ok, cam_err_scope_field
CAM_MUST_USE cam_err_t cam_scope_get(const cam_scope_t *s, uint32_t field, int32_t *value);

/// Start a recording; the previous one is lost.
/// @param head  [words] to leave free before the rows
/// @param tick  newest tick, the first that is recorded
/// @return      cam_ok, cam_err_scope_memory (no row fits), cam_err_scope_before (no row remains
///              after the trigger)
CAM_MUST_USE cam_err_t cam_scope_begin(cam_scope_t *s, const cam_scope_plan_t *plan,
                                       cam_scope_use_t use, uint32_t head, uint32_t tick);

void cam_scope_stop(cam_scope_t *s);

/// Reserve words at the start of the memory for a wave. The recording is lost.
void cam_scope_reserve(cam_scope_t *s, uint32_t n_wave);

/// Process a record, in the order of the ticks.
void cam_scope_take(cam_scope_t *s, const cam_tick_record_t *r);

static inline bool cam_scope_is_on(const cam_scope_t *s)
{
    return s->phase == cam_scope_armed || s->phase == cam_scope_recording;
}

/// @param last  value of the previous tick; without one only the kinds now and time fire
/// @param now   value of this tick; kind time: ticks since the start
/// @return      whether the trigger fires in this tick
bool cam_trigger_fires(const cam_trigger_t *t, cam_trigger_last_t last, int32_t now);

uint32_t cam_scope_count(uint32_t signals);

/// @return [words]
static inline uint32_t cam_scope_n_recorded(const cam_scope_t *s)
{
    return s->ring.n_rows * s->n_signals;
}

/// Words are in memory as they are sent, the lowest byte first.
/// @param offset  [bytes] in the recording, below its end
/// @param n       [bytes] requested, not beyond its end
/// @return        the bytes from there, as many of n as are contiguous
cam_scope_span_t cam_scope_span(const cam_scope_t *s, uint32_t offset, uint32_t n);

/// @return name of a signal with its unit as the last word, static; "?" if unknown
const char *cam_scope_signal_name(uint32_t signal);

/// Black box: a recording that the controller always runs and that a fault triggers.
///
/// While the recorder is free, its ring holds the signals CAM_BLACKBOX_SIGNALS of the last
/// cam_blackbox_before_ms. A fault triggers it; the recording ends cam_blackbox_after_ms later and
/// stays, with a head before its rows so that the port can keep it over a restart
/// (hal_scope_keep()). Rows are as many ticks apart as the memory requires.

/// [ms] recorded before and after the fault.
enum { cam_blackbox_before_ms = 500, cam_blackbox_after_ms = 20 };

/// Recorded signals; 375 kB at 20 kHz.
#define CAM_BLACKBOX_SIGNALS                                                                       \
    (UINT32_C(1) << cam_scope_state | UINT32_C(1) << cam_scope_u_due_q6 |                          \
     UINT32_C(1) << cam_scope_u_command_nm | UINT32_C(1) << cam_scope_u_actual_nm |                \
     UINT32_C(1) << cam_scope_angle_q32 | UINT32_C(1) << cam_scope_speed_q32 |                     \
     UINT32_C(1) << cam_scope_z_nm | UINT32_C(1) << cam_scope_faults |                             \
     UINT32_C(1) << cam_scope_inputs)

/// Start the black box. @return cam_ok, cam_err_scope_memory
CAM_MUST_USE cam_err_t cam_blackbox_begin(cam_scope_t *s, uint32_t tick);

/// @return whether it holds the recording of a fault that nobody has released
static inline bool cam_blackbox_is_unread(const cam_scope_t *s)
{
    return s->use == cam_scope_box && s->phase == cam_scope_done;
}

/// Have the port keep a finished recording.
void cam_blackbox_keep(const cam_scope_t *s);

/// Restore a recording that the port has kept over a restart; one whose head does not match the
/// memory or the tick rate is ignored.
/// @param n_kept  [words] at the start of the memory
/// @return        whether a recording was restored
bool cam_blackbox_restore(cam_scope_t *s, uint32_t n_kept);

#endif
