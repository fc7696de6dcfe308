// SPDX-License-Identifier: Apache-2.0
#include "cam_status.h"
#include <stddef.h> // NULL, size_t

/// A word of any structure.
typedef uint32_t __attribute__((may_alias)) any_word_t;

/// Copy words that the interrupt may be writing; such a copy is discarded. C11 calls this a race
/// because the words are not atomic, which would cost time in every tick. Volatile makes the
/// compiler read each word exactly once.
__attribute__((noinline, no_sanitize("thread"))) static void copy_words(void *to, const void *from,
                                                                        size_t n_bytes)
{
    any_word_t *words = to;                   // MISRA D20
    const volatile any_word_t *shared = from; // MISRA D20
    for (size_t i = 0; i < n_bytes / sizeof *words; i++) {
        words[i] = shared[i];
    }
}

#define COPY(to, from)                                                                             \
    do {                                                                                           \
        _Static_assert(sizeof(to) == sizeof(from) && sizeof(to) % sizeof(uint32_t) == 0u,          \
                       "words");                                                                   \
        copy_words(&(to), &(from), sizeof(to));                                                    \
    } while (false)

/// If n ticks have ended before the copy, and number n - 1 is still the newest that has begun after
/// it, no tick was in progress meanwhile.
void cam_status_moment(const cam_t *c, cam_moment_t *now)
{
    uint32_t n_ended = 0;
    uint32_t begun = 0;
    do {
        n_ended = atomic_load_explicit(&c->n_ticks, memory_order_acquire);
        const cam_tick_record_t *newest = atomic_load_explicit(&c->newest, memory_order_acquire);
        if (newest == NULL) {
            *now = (cam_moment_t){.record.want.state = cam_state_off};
            return;
        }
        COPY(now->record, *newest);
        COPY(now->spindle, c->spindle);
        COPY(now->motion, c->motion);
        COPY(now->guard, c->guard);
        COPY(now->jog, c->jog);
        COPY(now->acknowledge, c->acknowledge);
        COPY(now->plan, c->plan);
        atomic_thread_fence(memory_order_acquire);
        begun = atomic_load_explicit(&c->n_begun, memory_order_relaxed);
    } while (begun + 1u != n_ended);
}

cam_status_t cam_status_read(const cam_t *c)
{
    cam_moment_t now;
    cam_status_moment(c, &now);
    const cam_tick_record_t *r = &now.record;
    cam_status_t status = {
        .tick = r->tick,
        .config = r->config,
        .request = r->in.request >> 8,
        .state = r->want.state,
        .faults = r->want.faults,
        .first_fault = now.guard.first_faults,
        .is_synced = r->angle.is_synced,
        .is_retracted = r->want.is_retracted,
        .is_u_at_rest = cam_record_is_u_at_rest(r),
        .inputs = r->in.inputs,
        .outputs = r->want.outputs,
        .jog = now.jog,
        .acknowledge = now.acknowledge,
        .steady = now.plan.steady,
        .pos_q32 = r->angle.pos_q32,
        .speed_q32 = r->angle.speed_q32,
        .z_nm = r->want.z_nm,
        .u_set_q6 = r->want.u_set_q6,
        .u_actual_nm = r->in.actual_nm[hal_axis_u],
        .x_actual_nm = r->in.actual_nm[hal_axis_x],
        .z_actual_nm = r->in.actual_nm[hal_axis_z],
        .following_nm = r->in.actual_nm[hal_axis_u] - (r->want.u_due_q6 >> 6),
        .n_late = now.spindle.n_late,
        .max_period = now.spindle.max_period,
    };
    for (uint32_t i = 0; i < cam_n_faults; i++) {
        status.fault_count[i] = cam_guard_count(&now.guard, (cam_fault_t)i);
    }
    return status;
}
