// SPDX-License-Identifier: Apache-2.0
#include "cam_tick_inner.h"
#include "cam_fix.h" // cam_fence_release_isr

cam_tick_record_t *cam_trace_begin_isr(cam_trace_t *trace)
{
    cam_tick_record_t *last = atomic_load_explicit(&trace->newest, memory_order_relaxed);
    const bool is_at_end = last == NULL || last == &trace->ring[cam_trace_capacity - 1];
    cam_tick_record_t *record = is_at_end ? trace->ring : last + 1;
    record->tick = atomic_load_explicit(&trace->n_written, memory_order_relaxed);
    atomic_store_explicit(&trace->n_begun, record->tick + 1u, memory_order_relaxed);
    cam_fence_release_isr();
    return record;
}

void cam_trace_commit_isr(cam_trace_t *trace, cam_tick_record_t *record)
{
    atomic_store_explicit(&trace->newest, record, CAM_ORDER_RELEASE);
    const uint32_t n_begun = atomic_load_explicit(&trace->n_begun, memory_order_relaxed);
    atomic_store_explicit(&trace->n_written, n_begun, CAM_ORDER_RELEASE);
}

/// A word of any structure.
typedef uint32_t __attribute__((may_alias)) any_word_t;

/// C11 calls this a race because the words are not atomic, which would cost time in every tick.
/// Volatile makes the compiler read each word exactly once.
__attribute__((noinline, no_sanitize("thread"))) void cam_trace_copy(void *to, const void *from,
                                                                     size_t n_bytes)
{
    any_word_t *words = to;                   // MISRA D20
    const volatile any_word_t *shared = from; // MISRA D20
    for (size_t i = 0; i < n_bytes / sizeof *words; i++) {
        words[i] = shared[i];
    }
}

/// The tick in progress overwrites the record of the tick cam_trace_capacity before it.
bool cam_trace_pop(cam_trace_t *trace, cam_tick_record_t *record)
{
    bool is_taken = false;
    uint32_t n_left = 0;
    do {
        n_left = atomic_load_explicit(&trace->n_written, memory_order_acquire) - trace->n_read;
        if (n_left >= (uint32_t)cam_trace_capacity) {
            const uint32_t n_gone = n_left - (uint32_t)cam_trace_capacity + 1u;
            trace->n_read += n_gone;
            trace->n_missed += n_gone;
        }
        if (n_left > 0u) {
            const uint32_t tick = trace->n_read;
            cam_trace_copy(record, &trace->ring[tick % cam_trace_capacity], sizeof *record);
            atomic_thread_fence(memory_order_acquire);
            const uint32_t begun = atomic_load_explicit(&trace->n_begun, memory_order_relaxed);
            is_taken = begun - tick <= (uint32_t)cam_trace_capacity;
        }
        trace->n_read += is_taken ? 1u : 0u;
    } while (!is_taken && n_left > 0u);
    return is_taken;
}
