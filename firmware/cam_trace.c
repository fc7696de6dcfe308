// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_trace.h"

static bool is_full(cam_trace_t *trace, uint32_t written)
{
    const uint32_t read = atomic_load_explicit(&trace->n_read, memory_order_acquire);
    return written - read >= cam_trace_capacity;
}

cam_tick_record_t *cam_trace_slot_isr(cam_trace_t *trace)
{
    const uint32_t written = atomic_load_explicit(&trace->n_written, memory_order_relaxed);
    trace->is_spare = is_full(trace, written);
    return trace->is_spare ? &trace->spare : &trace->ring[written % cam_trace_capacity];
}

void cam_trace_commit_isr(cam_trace_t *trace, bool is_kept)
{
    if (!is_kept) {
        return;
    }
    _Atomic uint32_t *counter = trace->is_spare ? &trace->n_dropped : &trace->n_written;
    const uint32_t n = atomic_load_explicit(counter, memory_order_relaxed);
    atomic_store_explicit(counter, n + 1u, memory_order_release);
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
