// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_trace.h"

/// A full ring and a trace that nobody wants end up at the same place.
static cam_tick_record_t *spare(cam_trace_t *trace, bool is_wanted)
{
    if (is_wanted) {
        const uint32_t n = atomic_load_explicit(&trace->n_dropped, memory_order_relaxed);
        atomic_store_explicit(&trace->n_dropped, n + 1u, memory_order_relaxed);
    }
    return &trace->spare[trace->n_spared++ & 1u];
}

cam_tick_record_t *cam_trace_slot_isr(cam_trace_t *trace, bool is_wanted)
{
    const uint32_t written = atomic_load_explicit(&trace->n_written, memory_order_relaxed);
    const uint32_t read = atomic_load_explicit(&trace->n_read, memory_order_acquire);
    trace->is_kept = is_wanted && written - read < cam_trace_capacity;
    return trace->is_kept ? &trace->ring[written % cam_trace_capacity] : spare(trace, is_wanted);
}

void cam_trace_commit_isr(cam_trace_t *trace)
{
    if (trace->is_kept) {
        const uint32_t n = atomic_load_explicit(&trace->n_written, memory_order_relaxed);
        atomic_store_explicit(&trace->n_written, n + 1u, memory_order_relaxed);
    }
}

bool cam_trace_pop(cam_trace_t *trace, cam_tick_record_t *record)
{
    const uint32_t read = atomic_load_explicit(&trace->n_read, memory_order_relaxed);
    if (atomic_load_explicit(&trace->n_written, memory_order_acquire) == read) {
        return false;
    }
    *record = trace->ring[read % cam_trace_capacity];
    atomic_store_explicit(&trace->n_read, read + 1u, memory_order_release);
    return true;
}

uint32_t cam_trace_dropped(cam_trace_t *trace)
{
    return atomic_load_explicit(&trace->n_dropped, memory_order_relaxed);
}
