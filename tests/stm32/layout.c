// SPDX-License-Identifier: Apache-2.0
// Where the image keeps its trace: compiled for the target, read from the object file by
// tick_trace.py.
#include "cam_tick.h"
#include <stddef.h> // offsetof

#define IN_RECORD(member) offsetof(cam_tick_record_t, member)

/// In the order of tick_trace.py.
const uint32_t layout[] = {
    offsetof(cam_t, trace.ring),
    offsetof(cam_t, trace.n_written),
    cam_trace_capacity,
    sizeof(cam_tick_record_t),
    IN_RECORD(tick),
    IN_RECORD(config),
    IN_RECORD(in.clock),
    IN_RECORD(in.encoder.counts),
    IN_RECORD(in.encoder.index_counts),
    IN_RECORD(in.encoder.n_index),
    IN_RECORD(in.encoder.edge_clock),
    IN_RECORD(in.actual_nm[hal_axis_u]),
    IN_RECORD(in.actual_nm[hal_axis_x]),
    IN_RECORD(in.actual_nm[hal_axis_z]),
    IN_RECORD(in.inputs),
    IN_RECORD(in.request),
    IN_RECORD(out[hal_axis_u].pos_nm),
    IN_RECORD(out[hal_axis_x].pos_nm),
    IN_RECORD(out[hal_axis_z].pos_nm),
    IN_RECORD(force_q6),
};
