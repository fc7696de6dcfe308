// SPDX-License-Identifier: Apache-2.0
#include "cam_scope.h"

enum { most_every = 1000000, word_bytes = 4 };

/// Default: set-point, command and measured U.
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
        .set = {.signals = FIRST_SIGNALS, .every = 1, .from_state = -1},
    };
}

const char *cam_scope_signal_name(uint32_t signal)
{
#define SIGNAL_NAME(name, value, what) #name,
    static const char *const names[cam_scope_n_signals] = {CAM_SCOPE_SIGNALS(SIGNAL_NAME)};
    return signal < cam_scope_n_signals ? names[signal] : "?";
}

// Fields

/// Set a field of a plan. @return whether its value is in range
static bool set_field(cam_scope_plan_t *plan, uint32_t field, int32_t value)
{
    switch (field) {
    case cam_scope_field_signals:
        plan->signals = (uint32_t)value;
        return value != 0 && ((uint32_t)value & ~ALL_SIGNALS) == 0u;
    case cam_scope_field_every:
        plan->every = (uint32_t)value;
        return value >= 1 && value <= most_every;
    case cam_scope_field_rows:
        plan->rows = (uint32_t)value;
        return value >= 0;
    case cam_scope_field_before:
        plan->before = (uint32_t)value;
        return value >= 0;
    case cam_scope_field_from_state:
        plan->from_state = value;
        return value >= -1 && value < (int32_t)cam_n_states;
    case cam_scope_field_trigger:
        plan->trigger.kind = (cam_trigger_kind_t)value;
        return value >= 0 && value < (int32_t)cam_trigger_n;
    case cam_scope_field_watched:
        plan->trigger.signal = (uint32_t)value;
        return value >= 0 && value < (int32_t)cam_scope_n_signals;
    case cam_scope_field_level:
        plan->trigger.level = value;
        return true;
    default: // the edge
        plan->trigger.falls = value != 0;
        return value == 0 || value == 1;
    }
}

cam_err_t cam_scope_set(cam_scope_t *s, uint32_t field, int32_t value)
{
#define FIELD_IS_SET(name, is_set, what) is_set,
    static const bool may_set[cam_scope_n_fields] = {CAM_SCOPE_FIELDS(FIELD_IS_SET)};
    if (field >= cam_scope_n_fields || !may_set[field] || field == cam_scope_field_place_nm) {
        return cam_err_scope_field;
    }
    cam_scope_plan_t plan = s->set;
    if (!set_field(&plan, field, value)) {
        return cam_err_scope_range;
    }
    s->set = plan;
    return cam_ok;
}

/// @return the plan whose signals are reported: of the recording if there is one to read
static const cam_scope_plan_t *reported_plan(const cam_scope_t *s)
{
    const bool is_own = s->use == cam_scope_user || s->phase == cam_scope_done;
    return s->phase != cam_scope_idle && is_own ? &s->plan : &s->set;
}

cam_err_t cam_scope_get(const cam_scope_t *s, uint32_t field, int32_t *value)
{
    const int32_t values[cam_scope_n_fields] = {
        [cam_scope_field_signals] = (int32_t)reported_plan(s)->signals,
        [cam_scope_field_every] = (int32_t)reported_plan(s)->every,
        [cam_scope_field_rows] = (int32_t)s->set.rows,
        [cam_scope_field_from_state] = s->set.from_state,
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
        [cam_scope_field_before] = (int32_t)s->set.before,
        [cam_scope_field_trigger] = (int32_t)s->set.trigger.kind,
        [cam_scope_field_watched] = (int32_t)s->set.trigger.signal,
        [cam_scope_field_level] = s->set.trigger.level,
        [cam_scope_field_edge] = s->set.trigger.falls ? 1 : 0,
        [cam_scope_field_use] = (int32_t)s->use,
        [cam_scope_field_n_before] = (int32_t)s->n_before,
        [cam_scope_field_trigger_tick] = (int32_t)s->trigger_tick,
        [cam_scope_field_faults] = (int32_t)s->faults,
    };
    *value = field < cam_scope_n_fields ? values[field] : 0;
    return field < cam_scope_n_fields ? cam_ok : cam_err_scope_field;
}

// Begin and end

uint32_t cam_scope_count(uint32_t signals)
{
    uint32_t n = 0;
    for (uint32_t left = signals; left != 0u; left &= left - 1u) {
        n++;
    }
    return n;
}

static void clear_rows(cam_scope_t *s)
{
    s->oldest = 0;
    s->n_rows = 0;
    s->n_before = 0;
    s->to_row = 0;
    s->last.is_there = false;
}

cam_err_t cam_scope_begin(cam_scope_t *s, const cam_scope_plan_t *plan, cam_scope_use_t use,
                          uint32_t head, uint32_t tick)
{
    const uint32_t taken = s->n_wave + head;
    const uint32_t room = taken < s->n_words ? s->n_words - taken : 0u;
    const uint32_t n_signals = cam_scope_count(plan->signals);
    const uint32_t fitting = n_signals > 0u ? room / n_signals : 0u;
    const uint32_t most = plan->rows != 0u && plan->rows < fitting ? plan->rows : fitting;
    if (most == 0u) {
        return cam_err_scope_memory;
    }
    if (plan->before >= most) {
        return cam_err_scope_before;
    }
    s->plan = *plan;
    s->use = use;
    s->at = taken;
    s->most_rows = most;
    s->n_lost = 0;
    s->start_tick = tick;
    s->first_tick = tick;
    s->last_tick = tick;
    s->trigger_tick = tick;
    s->faults = 0;
    s->number++;
    s->end = cam_scope_open;
    s->phase = cam_scope_armed;
    s->n_signals = 0;
    for (uint32_t i = 0; i < (uint32_t)cam_scope_n_signals; i++) {
        if ((plan->signals >> i & 1u) != 0u) {
            s->order[s->n_signals] = (uint8_t)i;
            s->n_signals++;
        }
    }
    clear_rows(s);
    return cam_ok;
}

cam_err_t cam_scope_start(cam_scope_t *s, uint32_t tick)
{
    return cam_scope_begin(s, &s->set, cam_scope_user, 0, tick);
}

static void end_by(cam_scope_t *s, cam_scope_end_t end)
{
    s->phase = cam_scope_done;
    s->end = end;
}

void cam_scope_stop(cam_scope_t *s)
{
    if (s->phase == cam_scope_armed) { // without a trigger all rows are before it
        s->n_before = s->n_rows;
        s->trigger_tick = s->last_tick;
    }
    if (cam_scope_is_on(s)) {
        end_by(s, cam_scope_stopped);
    }
}

void cam_scope_reserve(cam_scope_t *s, uint32_t n_wave)
{
    s->phase = cam_scope_idle;
    s->use = cam_scope_nobody;
    s->end = cam_scope_open;
    s->n_rows = 0;
    s->n_wave = n_wave;
}

// Recording

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

/// @return value of the trigger
static int32_t trigger_value(const cam_scope_t *s, const cam_tick_record_t *r)
{
    switch (s->plan.trigger.kind) {
    case cam_trigger_time:
        return (int32_t)(r->tick - s->start_tick);
    case cam_trigger_angle:
        return value_of(r, cam_scope_angle_q32);
    case cam_trigger_state:
        return (int32_t)r->want.state;
    case cam_trigger_fault:
        return (int32_t)r->want.faults;
    default:
        return value_of(r, s->plan.trigger.signal);
    }
}

static void check_trigger(cam_scope_t *s, const cam_tick_record_t *r)
{
    const int32_t now = trigger_value(s, r);
    if (s->phase == cam_scope_armed && cam_trigger_fires(&s->plan.trigger, s->last, now)) {
        s->phase = cam_scope_recording;
        s->trigger_tick = r->tick;
        s->faults = r->want.faults;
        s->n_before = s->n_rows;
        s->to_row = s->n_rows > 0u ? s->to_row : 0u; // the first row is of the trigger
    }
    s->last = (cam_trigger_last_t){.is_there = true, .value = now};
    s->last_tick = r->tick;
}

static void add_row(cam_scope_t *s, const cam_tick_record_t *r)
{
    if (s->phase == cam_scope_armed && s->n_rows == s->plan.before) {
        s->oldest = s->oldest + 1u < s->most_rows ? s->oldest + 1u : 0u;
        s->first_tick += s->plan.every;
        s->n_rows--;
    }
    const uint32_t place = s->oldest + s->n_rows;
    const uint32_t row = place < s->most_rows ? place : place - s->most_rows;
    int32_t *words = &s->words[s->at + row * s->n_signals];
    for (uint32_t i = 0; i < s->n_signals; i++) {
        words[i] = value_of(r, s->order[i]);
    }
    s->first_tick = s->n_rows == 0u ? r->tick : s->first_tick;
    s->n_rows++;
    if (s->n_rows - s->n_before == s->most_rows - s->plan.before &&
        s->phase == cam_scope_recording) {
        end_by(s, cam_scope_full);
    }
}

/// Process a record in the selected state.
static void record_tick(cam_scope_t *s, const cam_tick_record_t *r)
{
    const bool is_next = !s->last.is_there || r->tick - s->last_tick == 1u;
    if (!is_next && s->phase == cam_scope_recording) {
        s->n_lost = r->tick - s->last_tick - 1u;
        end_by(s, cam_scope_gap);
        return;
    }
    if (!is_next) {
        clear_rows(s);
    }
    check_trigger(s, r);
    // The ticks are counted also while no row is kept, so that rows are equally spaced.
    if (s->to_row > 0u) {
        s->to_row--;
        return;
    }
    s->to_row = s->plan.every - 1u;
    if (s->phase == cam_scope_recording || s->plan.before > 0u) {
        add_row(s, r);
    }
}

void cam_scope_take(cam_scope_t *s, const cam_tick_record_t *r)
{
    const bool is_old = (int32_t)(r->tick - s->start_tick) < 0;
    if (!cam_scope_is_on(s) || is_old) {
        return;
    }
    if (s->plan.from_state < 0 || (int32_t)r->want.state == s->plan.from_state) {
        record_tick(s, r);
    } else if (s->phase == cam_scope_recording) {
        end_by(s, cam_scope_state_left);
    } else {
        clear_rows(s);
    }
}

cam_scope_span_t cam_scope_span(const cam_scope_t *s, uint32_t offset, uint32_t n)
{
    const uint32_t row_bytes = s->n_signals * (uint32_t)word_bytes;
    const uint32_t ring = s->most_rows * row_bytes;
    const uint32_t place = s->oldest * row_bytes + offset;
    const uint32_t from = place < ring ? place : place - ring;
    const uint8_t *bytes = (const uint8_t *)&s->words[s->at];
    return (cam_scope_span_t){.bytes = &bytes[from], .n = n < ring - from ? n : ring - from};
}
