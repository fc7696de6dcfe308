// SPDX-License-Identifier: Apache-2.0
/// pil_main: the firmware on a target, at camsim's command (pil_wire.h). Ends when camsim closes
/// the wire, with status 0.
#include "cam_machine.h"
#include "cam_trace.h"
#include "hal/hal.h"
#include "mps2_machine.h"
#include "mps2_semihost.h"
#include "pil_time.h"
#include "pil_wire.h"

/// The table is in the PSRAM, the heap of test programs; this image has no heap.
extern uint8_t mps2_heap_start[], mps2_heap_end[];

enum { status_no_wire = 3 };

static cam_machine_t machine;
static pil_request_t request;
static pil_answer_t answer;

static uint32_t table_room(void)
{
    return (uint32_t)((uintptr_t)mps2_heap_end - (uintptr_t)mps2_heap_start);
}

static void init(void)
{
    pil_time = (pil_time_t){.tick_hz = request.a, .clock_hz = (uint32_t)request.b};
    mps2_machine.slow.has_edge_time = (request.port & pil_port_has_edge_time) != 0u;
    mps2_machine.slow.measures_u = (request.port & pil_port_measures_u) != 0u;
    mps2_machine.slow.force = request.force;
    if (hal_init() != 0) {
        hal_halt("pil_main: the port cannot be used");
    }
    cam_machine_init(&machine, &g_cam, hal_tick_hz(), hal_clock_hz());
}

static void tick(void)
{
    pil_time.clock = request.clock;
    mps2_machine.in.encoder = request.encoder;
    mps2_machine.in.inputs = request.inputs;
    mps2_machine.in.swing_q32 = request.swing_q32;
    for (int i = 0; i < hal_n_axes; i++) {
        mps2_machine.in.axis_nm[i] = request.axis_nm[i];
    }
    cam_isr();
    for (int i = 0; i < hal_n_axes; i++) {
        answer.axis[i] = mps2_machine.out.axis[i];
    }
    answer.force_q6 = mps2_machine.out.force_q6;
    answer.spindle_mrpm = mps2_machine.out.spindle_mrpm;
    answer.outputs = mps2_machine.out.outputs;
    answer.swing = mps2_machine.out.swing;
    answer.n_swing = mps2_machine.out.n_swing;
    answer.n_records = cam_trace_pop(&g_cam.trace, &answer.record) ? 1u : 0u;
    answer.status = cam_machine_status(&machine);
    cam_machine_ilc_poll(&machine, answer.status.state, !answer.status.is_u_at_rest);
}

/// camsim checks offsets and sizes before it sends.
static cam_err_t take_table_bytes(uint32_t at, uint32_t n, int32_t wire)
{
    if (n > pil_chunk_bytes || at > table_room() - n) {
        hal_halt("pil_main: table bytes outside the room");
    }
    if (!mps2_file_read(wire, &mps2_heap_start[at], n)) {
        hal_halt("pil_main: the wire broke in a table");
    }
    return cam_ok;
}

static cam_err_t serve(int32_t wire)
{
    switch ((pil_op_t)request.op) {
    case pil_op_init:
        init();
        return cam_ok;
    case pil_op_tick:
        tick();
        return cam_ok;
    case pil_op_get_param:
        answer.value = cam_param_get(&machine.params, (cam_param_id_t)request.a);
        return cam_ok;
    case pil_op_set_param:
        return cam_machine_set_param(&machine, (cam_param_id_t)request.a, request.b);
    case pil_op_table_bytes:
        return take_table_bytes(request.a, (uint32_t)request.b, wire);
    case pil_op_table_flip:
        mps2_heap_start[request.a % table_room()] ^= 1u;
        return cam_ok;
    case pil_op_select_table:
        return cam_machine_select_table(&machine, mps2_heap_start, request.a);
    case pil_op_feasibility:
        answer.feasibility = cam_machine_feasibility(&machine, 0);
        return cam_ok;
    case pil_op_enable:
        return cam_machine_enable(&machine);
    case pil_op_start:
        return cam_machine_start(&machine);
    case pil_op_stop:
        return cam_machine_stop(&machine);
    case pil_op_hold:
        return request.a != 0u ? cam_machine_hold(&machine) : cam_machine_resume(&machine);
    case pil_op_poll:
        cam_machine_poll(&machine);
        return cam_ok;
    case pil_op_learning:
        answer.learning = cam_machine_learning(&machine);
        answer.harmonic = cam_ilc_harmonic(&machine.ilc, request.a);
        return cam_ok;
    }
    hal_halt("pil_main: unknown operation");
}

int main(void)
{
    const pil_hello_t hello = {
        .magic = pil_magic,
        .headers = PIL_HEADERS,
        .request_bytes = sizeof request,
        .answer_bytes = sizeof answer,
        .table_bytes = table_room(),
    };
    const int32_t in = mps2_file_open(PIL_REQUEST_PATH, false);
    const int32_t out = mps2_file_open(PIL_ANSWER_PATH, true);
    if (in < 0 || out < 0 || !mps2_file_write(out, &hello, sizeof hello)) {
        return status_no_wire;
    }
    while (mps2_file_read(in, &request, sizeof request)) {
        answer.err = serve(in);
        if (!mps2_file_write(out, &answer, sizeof answer)) {
            return status_no_wire;
        }
    }
    return 0;
}
