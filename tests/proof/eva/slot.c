// SPDX-License-Identifier: Apache-2.0
// The place of a tick's record, whatever its counters say; the whole tick is analysed with the
// spare place alone.
#include "world.h"

void main(void)
{
    cam_trace_t *trace = &c.trace;
    trace->n_spared = (uint32_t)any(0, UINT32_MAX);
    trace->n_next = (uint32_t)any(0, UINT32_MAX);
    trace->n_written = (uint32_t)any(0, UINT32_MAX);
    trace->n_read = (uint32_t)any(0, UINT32_MAX);
    trace->n_dropped = (uint32_t)any(0, UINT32_MAX);
    cam_tick_record_t *place = cam_trace_slot_isr(trace, any(0, 1) != 0 ? cam_trace_capacity : 0u);
    place->tick = trace->n_written;
    cam_trace_commit_isr(trace);
    (void)cam_trace_pop(trace, &record);
    Frama_C_show_each_end();
}
