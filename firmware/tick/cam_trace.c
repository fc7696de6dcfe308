// SPDX-License-Identifier: Apache-2.0
#include "cam_trace.h"
#include "cam_fence.h" // cam_fence_acquire_isr

cam_tick_record_t *cam_trace_slot_isr(cam_trace_t *trace, uint32_t room)
{
    const uint32_t written = atomic_load_explicit(&trace->n_written, memory_order_relaxed);
    const uint32_t read = atomic_load_explicit(&trace->n_read, CAM_ORDER_ACQUIRE);
    cam_fence_acquire_isr();
    if (written - read >= room) {
        trace->n_next = written;
        if (room != 0u) {
            const uint32_t n = atomic_load_explicit(&trace->n_dropped, memory_order_relaxed);
            atomic_store_explicit(&trace->n_dropped, n + 1u, memory_order_relaxed);
        }
        return &trace->spare[trace->n_spared++ & 1u];
    }
    trace->n_next = written + 1u;
    return &trace->ring[written % cam_trace_capacity];
}

void cam_trace_commit_isr(cam_trace_t *trace)
{
    atomic_store_explicit(&trace->n_written, trace->n_next, CAM_ORDER_RELEASE);
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
