// SPDX-License-Identifier: Apache-2.0
#include "cam_scope.h"

enum { most_every = 1000000 };

/// Set at the start: set-point, command and measured U.
#define FIRST_SIGNALS                                                                              \
    (UINT32_C(1) << cam_scope_u_set_q6 | UINT32_C(1) << cam_scope_u_command_nm |                   \
     UINT32_C(1) << cam_scope_u_actual_nm)

#define ALL_SIGNALS (UINT32_MAX >> (32u - (uint32_t)cam_scope_n_signals))

void cam_scope_init(cam_scope_t *s, hal_memory_t memory, uint32_t tick_hz)
{
    *s = (cam_scope_t){
        .words = memory.words,
        .n_words = memory.n_words,
        .tick_hz = tick_hz,
        .signals = FIRST_SIGNALS,
        .every = 1,
        .from_state = -1,
    };
}

const char *cam_scope_signal_name(uint32_t signal)
{
#define SIGNAL_NAME(name, value, what) #name,
    static const char *const names[cam_scope_n_signals] = {CAM_SCOPE_SIGNALS(SIGNAL_NAME)};
    return signal < cam_scope_n_signals ? names[signal] : "?";
}

// Fields

cam_err_t cam_scope_set(cam_scope_t *s, uint32_t field, int32_t value)
{
    switch (field) {
    case cam_scope_field_signals:
        if (value == 0 || ((uint32_t)value & ~ALL_SIGNALS) != 0u) {
            return cam_err_scope_range;
        }
        s->signals = (uint32_t)value;
        return cam_ok;
    case cam_scope_field_every:
        if (value < 1 || value > most_every) {
            return cam_err_scope_range;
        }
        s->every = (uint32_t)value;
        return cam_ok;
    case cam_scope_field_rows:
        if (value < 0) {
            return cam_err_scope_range;
        }
        s->rows = (uint32_t)value;
        return cam_ok;
    case cam_scope_field_from_state:
        if (value < -1 || value >= (int32_t)cam_n_states) {
            return cam_err_scope_range;
        }
        s->from_state = value;
        return cam_ok;
    default:
        return cam_err_scope_field;
    }
}

cam_err_t cam_scope_get(const cam_scope_t *s, uint32_t field, int32_t *value)
{
    const bool is_there = s->phase != cam_scope_idle;
    const int32_t values[cam_scope_n_fields] = {
        [cam_scope_field_signals] = (int32_t)(is_there ? s->taken : s->signals),
        [cam_scope_field_every] = (int32_t)(is_there ? s->step : s->every),
        [cam_scope_field_rows] = (int32_t)s->rows,
        [cam_scope_field_from_state] = s->from_state,
        [cam_scope_field_phase] = (int32_t)s->phase,
        [cam_scope_field_end] = (int32_t)s->end,
        [cam_scope_field_n_rows] = (int32_t)s->n_rows,
        [cam_scope_field_n_signals] = (int32_t)s->n_signals,
        [cam_scope_field_first_tick] = (int32_t)s->first_tick,
        [cam_scope_field_n_lost] = (int32_t)s->n_lost,
        [cam_scope_field_number] = (int32_t)s->number,
        [cam_scope_field_tick_hz] = (int32_t)s->tick_hz,
        [cam_scope_field_n_words] = (int32_t)s->n_words,
        [cam_scope_field_n_wave] = (int32_t)s->n_wave,
    };
    *value = field < cam_scope_n_fields ? values[field] : 0;
    return field < cam_scope_n_fields ? cam_ok : cam_err_scope_field;
}

// Recording

static uint32_t count_bits(uint32_t bits)
{
    uint32_t n = 0;
    for (uint32_t left = bits; left != 0u; left &= left - 1u) {
        n++;
    }
    return n;
}

cam_err_t cam_scope_start(cam_scope_t *s, uint32_t tick)
{
    const uint32_t n_signals = count_bits(s->signals);
    const uint32_t room = s->n_words - s->n_wave;
    const uint32_t fitting = n_signals > 0u ? room / n_signals : 0u;
    if (fitting == 0u) {
        return cam_err_scope_memory;
    }
    s->taken = s->signals;
    s->step = s->every;
    s->in_state = s->from_state;
    s->n_signals = n_signals;
    s->most_rows = s->rows != 0u && s->rows < fitting ? s->rows : fitting;
    s->n_rows = 0;
    s->n_lost = 0;
    s->not_before = tick;
    s->first_tick = tick;
    s->number++;
    s->end = cam_scope_open;
    s->phase = cam_scope_armed;
    return cam_ok;
}

static void end_by(cam_scope_t *s, cam_scope_end_t end)
{
    s->phase = cam_scope_done;
    s->end = end;
}

void cam_scope_stop(cam_scope_t *s)
{
    if (cam_scope_is_on(s)) {
        end_by(s, cam_scope_stopped);
    }
}

void cam_scope_reserve(cam_scope_t *s, uint32_t n_wave)
{
    s->phase = cam_scope_idle;
    s->end = cam_scope_open;
    s->n_rows = 0;
    s->n_wave = n_wave;
}

static int32_t value_of(const cam_tick_record_t *r, uint32_t signal)
{
    switch (signal) {
#define SIGNAL_VALUE(name, value, what)                                                            \
    case cam_scope_##name:                                                                         \
        return (int32_t)(value);
        CAM_SCOPE_SIGNALS(SIGNAL_VALUE)
#undef SIGNAL_VALUE
    default:
        return 0;
    }
}

static void keep_row(cam_scope_t *s, const cam_tick_record_t *r)
{
    int32_t *word = &s->words[s->n_wave + s->n_rows * s->n_signals];
    for (uint32_t i = 0; i < (uint32_t)cam_scope_n_signals; i++) {
        if ((s->taken >> i & 1u) != 0u) {
            *word = value_of(r, i);
            word++;
        }
    }
    s->n_rows++;
    if (s->n_rows == s->most_rows) {
        end_by(s, cam_scope_full);
    }
}

/// The first tick of a recording, or the next one of it.
static void take_in_state(cam_scope_t *s, const cam_tick_record_t *r)
{
    if (s->phase == cam_scope_armed) {
        s->phase = cam_scope_recording;
        s->first_tick = r->tick;
    } else if (r->tick - s->last_tick != 1u) {
        s->n_lost = r->tick - s->last_tick - 1u;
        end_by(s, cam_scope_gap);
        return;
    } else {
        // the tick behind the last one
    }
    s->last_tick = r->tick;
    if ((r->tick - s->first_tick) % s->step == 0u) {
        keep_row(s, r);
    }
}

void cam_scope_take(cam_scope_t *s, const cam_tick_record_t *r)
{
    const bool is_old = (int32_t)(r->tick - s->not_before) < 0;
    if (!cam_scope_is_on(s) || is_old) {
        return;
    }
    if (s->in_state < 0 || (int32_t)r->want.state == s->in_state) {
        take_in_state(s, r);
    } else if (s->phase == cam_scope_recording) {
        end_by(s, cam_scope_state_left);
    } else {
        // still waiting for the state
    }
}

void cam_scope_poll(cam_scope_t *s, cam_trace_t *trace)
{
    cam_tick_record_t record;
    for (uint32_t i = 0; i < (uint32_t)cam_trace_capacity && cam_scope_is_on(s); i++) {
        if (!cam_trace_pop(trace, &record)) {
            return;
        }
        cam_scope_take(s, &record);
    }
}
