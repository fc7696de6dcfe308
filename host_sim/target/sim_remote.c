// SPDX-License-Identifier: Apache-2.0
#include "sim_remote.h"
#include "hal_host.h"   // hal_host_advance
#include "sim_target.h" // sim_target_find
#include <stdlib.h>     // calloc, free
#include <string.h>     // memcpy

static bool lose(sim_remote_t *r)
{
    r->is_lost = true;
    return false;
}

/// @param n  bytes after the request
static bool exchange(sim_remote_t *r, size_t n)
{
    return !r->is_lost &&
           ((sim_emulator_send(&r->emulator, &r->request, sizeof r->request.head + n, &r->error) &&
             sim_emulator_receive(&r->emulator, &r->answer, sizeof r->answer, &r->error)) ||
            lose(r));
}

/// A target built from other sources would answer differently, or not at all.
static bool greet(sim_remote_t *r, const sim_target_t *target, const char *image, common_error_t *e)
{
    if (!sim_emulator_receive(&r->emulator, &r->hello, sizeof r->hello, e)) {
        return false;
    }
    const bool is_same = r->hello.magic == pil_magic && r->hello.headers == PIL_HEADERS &&
                         r->hello.request_bytes == sizeof r->request.head &&
                         r->hello.answer_bytes == sizeof r->answer;
    return is_same ||
           common_error(e,
                        "--target %s: %s: made from other sources than camsim; build both "
                        "again, the image by: cmake --workflow --preset %s",
                        target->name, image, target->preset);
}

static bool start(sim_remote_t *r, const char *name, const char *image, common_error_t *e)
{
    const sim_target_t *target = sim_target_find(name, e);
    if (target == NULL || !sim_target_check_image(target, image, e) ||
        !sim_emulator_start(&r->emulator, target->name, image, e)) {
        return false;
    }
    if (!greet(r, target, image, e)) {
        sim_emulator_stop(&r->emulator);
        return false;
    }
    // The target's port must have the abilities of this one.
    r->request.head.port = (hal_has_edge_time() ? (uint32_t)pil_port_has_edge_time : 0u) |
                           (hal_measures_u() ? (uint32_t)pil_port_measures_u : 0u);
    r->request.head.force = hal_force();
    (void)sim_remote_call(r, pil_op_init, hal_tick_hz(), (int32_t)hal_clock_hz());
    if (r->is_lost) {
        *e = r->error;
        sim_emulator_stop(&r->emulator);
    }
    return !r->is_lost;
}

sim_remote_t *sim_remote_open(const char *target, const char *image, common_error_t *e)
{
    sim_remote_t *r = calloc(1, sizeof *r);
    if (r == NULL) {
        (void)common_error(e, "--target %s: not enough memory; free some", target);
        return NULL;
    }
    if (!start(r, target, image, e)) {
        free(r);
        return NULL;
    }
    return r;
}

void sim_remote_close(sim_remote_t *r)
{
    if (r != NULL) {
        sim_emulator_stop(&r->emulator);
        free(r);
    }
}

/// Read the inputs by the port's own functions, as the firmware would here.
static void sense(pil_request_t *request)
{
    request->clock = hal_clock_isr();
    hal_encoder_read_isr(&request->encoder);
    request->inputs = hal_inputs_read_isr();
    request->swing_q32 = hal_swing_read_q32_isr();
    for (int i = 0; i < hal_n_axes; i++) {
        request->axis_nm[i] = hal_axis_read_nm_isr((hal_axis_t)i);
    }
}

static void actuate(const pil_answer_t *answer)
{
    for (int i = 0; i < hal_n_axes; i++) {
        hal_axis_write_isr((hal_axis_t)i, &answer->axis[i]);
    }
    hal_force_write_isr(answer->force_q6);
    hal_spindle_write_isr(answer->spindle_mrpm);
    hal_outputs_write_isr(answer->outputs);
    if (answer->n_swing != hal_host.out.n_swing) { // both count from hal_init()
        hal_swing_write_isr(&answer->swing);
    }
}

bool sim_remote_tick(sim_remote_t *r, cam_status_t *status)
{
    hal_host_advance();
    r->request.head.op = pil_op_tick;
    sense(&r->request.head);
    if (!exchange(r, 0)) {
        return false;
    }
    actuate(&r->answer);
    *status = r->answer.status;
    // The target's ring is emptied every tick; this one fills and drops like the firmware's.
    if (r->answer.n_records > 0u) {
        *cam_trace_slot_isr(&r->trace, (uint32_t)cam_trace_capacity) = r->answer.record;
        cam_trace_commit_isr(&r->trace);
    }
    return true;
}

/// @param n  bytes after the request
static cam_err_t call(sim_remote_t *r, pil_op_t op, uint32_t a, int32_t b, size_t n)
{
    r->request.head.op = (uint32_t)op;
    r->request.head.a = a;
    r->request.head.b = b;
    return exchange(r, n) ? (cam_err_t)r->answer.err : cam_err_busy;
}

cam_err_t sim_remote_call(sim_remote_t *r, pil_op_t op, uint32_t a, int32_t b)
{
    return call(r, op, a, b, 0);
}

cam_err_t sim_remote_select_table(sim_remote_t *r, const void *image, size_t size)
{
    const uint8_t *bytes = (const uint8_t *)image;
    if (size > r->hello.table_bytes) {
        (void)common_error(&r->error, "the target has room for a table of %u bytes, not of %zu",
                           (unsigned)r->hello.table_bytes, size);
        (void)lose(r);
    }
    for (size_t at = 0; at < size && !r->is_lost; at += pil_chunk_bytes) {
        const size_t n = size - at < pil_chunk_bytes ? size - at : pil_chunk_bytes;
        memcpy(r->request.bytes, bytes + at, n);
        (void)call(r, pil_op_table_bytes, (uint32_t)at, (int32_t)n, n);
    }
    return sim_remote_call(r, pil_op_select_table, (uint32_t)size, 0);
}
