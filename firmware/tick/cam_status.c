// SPDX-License-Identifier: Apache-2.0
#include "cam_tick_inner.h"
#include "cam_fix.h" // cam_abs_i64

#define COPY(to, from)                                                                             \
    do {                                                                                           \
        _Static_assert(sizeof(to) == sizeof(from) && sizeof(to) % sizeof(uint32_t) == 0u,          \
                       "words");                                                                   \
        cam_trace_copy(&(to), &(from), sizeof(to));                                                \
    } while (false)

/// If as many ticks have begun after the copy as had ended before it, none was in progress.
void cam_status_moment(const cam_t *c, cam_moment_t *now)
{
    const cam_trace_t *t = &c->trace;
    uint32_t n_ended = 0;
    uint32_t n_begun = 0;
    do {
        n_ended = atomic_load_explicit(&t->n_written, memory_order_acquire);
        COPY(now->record, *cam_trace_newest(t));
        COPY(now->spindle, c->spindle);
        COPY(now->motion, c->motion);
        COPY(now->first_faults, c->guard.first_faults);
        COPY(now->jog, c->jog);
        COPY(now->acknowledge, c->acknowledge);
        COPY(now->plan, c->plan);
        atomic_thread_fence(memory_order_acquire);
        n_begun = atomic_load_explicit(&t->n_begun, memory_order_relaxed);
    } while (n_begun != n_ended);
}

cam_status_t cam_status_read(const cam_t *c)
{
    cam_moment_t now;
    cam_status_moment(c, &now);
    const cam_tick_record_t *r = &now.record;
    return (cam_status_t){
        .tick = r->tick,
        .config = r->config,
        .request = r->in.request >> 8,
        .state = r->want.state,
        .faults = r->want.faults,
        .first_fault = now.first_faults,
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
        .edge_distance = now.spindle.edge_distance,
        .n_late = now.spindle.n_late,
        .max_period = now.spindle.max_period,
    };
}

uint32_t cam_status_counts_found(const cam_status_t *status, uint32_t faults,
                                 int32_t counts_per_turn)
{
    const uint32_t of_encoder = CAM_FAULT_BIT(lost_counts) | CAM_FAULT_BIT(index_missing);
    const uint32_t found = (uint32_t)cam_abs_i64(status->edge_distance);
    const bool is_other = found != (uint32_t)counts_per_turn;
    return is_other && (faults & of_encoder) != 0u ? found : 0u;
}
