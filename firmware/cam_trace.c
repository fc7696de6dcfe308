// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_trace.h"

void cam_trace_push_isr(cam_trace_t *trace, const cam_tick_record_t *record)
{
    const uint32_t written = atomic_load_explicit(&trace->n_written, memory_order_relaxed);
    const uint32_t read = atomic_load_explicit(&trace->n_read, memory_order_acquire);
    if (written - read >= cam_trace_capacity) {
        const uint32_t dropped = atomic_load_explicit(&trace->n_dropped, memory_order_relaxed);
        atomic_store_explicit(&trace->n_dropped, dropped + 1u, memory_order_relaxed);
        return;
    }
    trace->ring[written % cam_trace_capacity] = *record;
    atomic_store_explicit(&trace->n_written, written + 1u, memory_order_release);
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
