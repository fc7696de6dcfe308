// SPDX-License-Identifier: Apache-2.0
#include "cam_recorder.h"
#include "cam_fix.h" // cam_wrap_sub

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
#define FIELD_IS_SET(name, is_set, value, what) is_set,
    static const bool may_set[cam_scope_n_fields] = {CAM_SCOPE_FIELDS(FIELD_IS_SET)};
    if (field >= cam_scope_n_fields || !may_set[field] || field == cam_scope_field_place_nm ||
        field == cam_scope_field_wave_unit) {
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
#define FIELD_VALUE(name, is_set, value, what) (int32_t)(value),
    const int32_t values[cam_scope_n_fields] = {CAM_SCOPE_FIELDS(FIELD_VALUE)};
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
    s->ring.oldest = 0;
    s->ring.n_rows = 0;
    s->ring.n_before = 0;
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
    s->ring = (cam_scope_ring_t){.most_rows = most, .first_tick = tick, .trigger_tick = tick};
    s->start_tick = tick;
    s->last_tick = tick;
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

static void end_by(cam_scope_t *s, cam_scope_end_t end)
{
    s->phase = cam_scope_done;
    s->end = end;
}

void cam_scope_stop(cam_scope_t *s)
{
    if (s->phase == cam_scope_armed) { // without a trigger all rows are before it
        s->ring.n_before = s->ring.n_rows;
        s->ring.trigger_tick = s->last_tick;
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
    s->ring.n_rows = 0;
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

// Trigger

static bool reaches(int32_t level, int32_t last, int32_t now)
{
    return last < level && now >= level;
}

/// @return whether an angle reaches or crosses the level. A step is less than half a turn, so the
///         opposite side of the turn is crossed in the other sense.
static bool passes(const cam_trigger_t *t, int32_t last, int32_t now)
{
    const int32_t before = cam_wrap_sub(last, t->level);
    const int32_t here = cam_wrap_sub(now, t->level);
    const int32_t step = cam_wrap_sub(now, last);
    return t->falls ? step < 0 && before > 0 && here <= 0 : step > 0 && before < 0 && here >= 0;
}

bool cam_trigger_fires(const cam_trigger_t *t, cam_trigger_last_t last, int32_t now)
{
    if (t->kind == cam_trigger_now || t->kind == cam_trigger_time) {
        return t->kind == cam_trigger_now || cam_wrap_sub(now, t->level) >= 0;
    }
    if (!last.is_there) {
        return false;
    }
    switch (t->kind) {
    case cam_trigger_level:
        return t->falls ? reaches(-1 - t->level, -1 - last.value, -1 - now)
                        : reaches(t->level, last.value, now);
    case cam_trigger_angle:
        return passes(t, last.value, now);
    case cam_trigger_state:
        return now == t->level && last.value != t->level;
    default: // a new fault bit
        return ((uint32_t)now & ~(uint32_t)last.value &
                (t->level != 0 ? (uint32_t)t->level : UINT32_MAX)) != 0u;
    }
}

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
        s->ring.trigger_tick = r->tick;
        s->ring.faults = r->want.faults;
        s->ring.n_before = s->ring.n_rows;
        s->to_row = s->ring.n_rows > 0u ? s->to_row : 0u; // the first row is of the trigger
    }
    s->last = (cam_trigger_last_t){.is_there = true, .value = now};
    s->last_tick = r->tick;
}

// Recording

static void add_row(cam_scope_t *s, const cam_tick_record_t *r)
{
    if (s->phase == cam_scope_armed && s->ring.n_rows == s->plan.before) {
        s->ring.oldest = s->ring.oldest + 1u < s->ring.most_rows ? s->ring.oldest + 1u : 0u;
        s->ring.first_tick += s->plan.every;
        s->ring.n_rows--;
    }
    const uint32_t place = s->ring.oldest + s->ring.n_rows;
    const uint32_t row = place < s->ring.most_rows ? place : place - s->ring.most_rows;
    int32_t *words = &s->words[s->at + row * s->n_signals];
    for (uint32_t i = 0; i < s->n_signals; i++) {
        words[i] = value_of(r, s->order[i]);
    }
    s->ring.first_tick = s->ring.n_rows == 0u ? r->tick : s->ring.first_tick;
    s->ring.n_rows++;
    if (s->ring.n_rows - s->ring.n_before == s->ring.most_rows - s->plan.before &&
        s->phase == cam_scope_recording) {
        end_by(s, cam_scope_full);
    }
}

static void record_tick(cam_scope_t *s, const cam_tick_record_t *r)
{
    const bool is_next = !s->last.is_there || r->tick - s->last_tick == 1u;
    if (!is_next && s->phase == cam_scope_recording) {
        s->ring.n_lost = r->tick - s->last_tick - 1u;
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
    const uint32_t ring = s->ring.most_rows * row_bytes;
    const uint32_t place = s->ring.oldest * row_bytes + offset;
    const uint32_t from = place < ring ? place : place - ring;
    const uint8_t *bytes = (const uint8_t *)&s->words[s->at];
    return (cam_scope_span_t){.bytes = &bytes[from], .n = n < ring - from ? n : ring - from};
}
