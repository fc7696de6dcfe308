// SPDX-License-Identifier: Apache-2.0
// The place of a tick's record, whatever the trace holds; the whole tick is analysed with the first
// place alone.
#include "world.h"
#include "cam_tick_inner.h" // cam_trace_begin_isr

static cam_tick_record_t record;

void main(void)
{
    cam_trace_t *trace = &c.trace;
    trace->n_begun = (uint32_t)any(0, UINT32_MAX);
    trace->n_written = (uint32_t)any(0, UINT32_MAX);
    trace->n_read = (uint32_t)any(0, UINT32_MAX);
    trace->n_missed = (uint32_t)any(0, UINT32_MAX);
    trace->newest = any(0, 1) != 0 ? &trace->ring[any(0, cam_trace_capacity - 1)] : NULL;
    cam_tick_record_t *place = cam_trace_begin_isr(trace);
    place->in.clock = place->tick;
    cam_trace_commit_isr(trace, place);
    record = *cam_trace_newest(trace);
    (void)cam_trace_pop(trace, &record);
    Frama_C_show_each_end();
}
