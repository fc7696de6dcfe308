// SPDX-License-Identifier: Apache-2.0
#include "sim_node.h"

enum { id_nmt = 0x000, id_emcy = 0x080, id_tpdo1 = 0x180 };
enum { id_rpdo1 = 0x200, id_rpdo2 = 0x300, id_heartbeat = 0x700 };

/// Commands of the network master, CiA 301, table "NMT protocol".
enum {
    nmt_start = 0x01,
    nmt_stop = 0x02,
    nmt_pre_operational = 0x80,
    nmt_reset = 0x81,
    nmt_reset_communication = 0x82,
};

enum { rpdo1_bytes = 6, rpdo1_fd_bytes = 12, rpdo2_bytes = 4 };

static void boot(sim_node_t *n)
{
    n->nmt = sim_nmt_pre_operational;
    n->has_booted = false;
    n->has_rpdo = false;
}

void sim_node_init(sim_node_t *n, uint32_t id, bool is_drive, double heartbeat_s)
{
    *n = (sim_node_t){.id = id, .is_drive = is_drive, .heartbeat_s = heartbeat_s};
    sim_cia402_init(&n->power);
    boot(n);
}

static void manage(sim_node_t *n, const sim_frame_t *frame)
{
    if (frame->n != 2u || (frame->data[1] != 0u && frame->data[1] != n->id)) {
        return;
    }
    switch (frame->data[0]) {
    case nmt_start:
        n->nmt = sim_nmt_operational;
        break;
    case nmt_stop:
        n->nmt = sim_nmt_stopped;
        break;
    case nmt_pre_operational:
        n->nmt = sim_nmt_pre_operational;
        break;
    case nmt_reset:
    case nmt_reset_communication:
        boot(n);
        break;
    default:
        break;
    }
}

static void take_rpdo1(sim_node_t *n, const sim_frame_t *frame, double t_s)
{
    if (frame->n != rpdo1_bytes && frame->n != rpdo1_fd_bytes) {
        n->emcy = sim_emcy_pdo_length;
        return;
    }
    n->heard.control_word = sim_frame_get_u16(frame, 0);
    n->heard.target = (int32_t)sim_frame_get_u32(frame, 2);
    if (frame->n == rpdo1_fd_bytes) {
        n->heard.velocity_offset = (int32_t)sim_frame_get_u32(frame, 6);
    }
    n->has_rpdo = true;
    n->rpdo_s = t_s;
}

static void take_rpdo2(sim_node_t *n, const sim_frame_t *frame)
{
    if (frame->n != rpdo2_bytes) {
        n->emcy = sim_emcy_pdo_length;
        return;
    }
    n->heard.velocity_offset = (int32_t)sim_frame_get_u32(frame, 0);
}

void sim_node_receive(sim_node_t *n, const sim_frame_t *frame, double t_s)
{
    if (n->is_dead) {
        return;
    }
    if (frame->id == id_nmt) {
        manage(n, frame);
    }
    if (!n->is_drive || n->nmt != sim_nmt_operational) {
        return;
    }
    if (frame->id == id_rpdo1 + n->id) {
        take_rpdo1(n, frame, t_s);
    } else if (frame->id == id_rpdo2 + n->id) {
        take_rpdo2(n, frame);
    }
}

void sim_node_sync(sim_node_t *n, double t_s)
{
    if (n->is_dead || n->nmt != sim_nmt_operational) {
        return;
    }
    n->sync_s = t_s;
    if (n->has_rpdo) {
        n->has_rpdo = false;
        n->active = n->heard;
        sim_cia402_control(&n->power, n->active.control_word);
    }
}

void sim_node_guard(sim_node_t *n, double t_s, double guard_s)
{
    if (!n->is_drive || !sim_cia402_is_following(&n->power)) {
        return;
    }
    if (n->is_dead || n->nmt != sim_nmt_operational || t_s - n->rpdo_s > guard_s) {
        sim_node_fail(n, sim_emcy_rpdo_timeout);
    } else if (t_s - n->sync_s > guard_s) {
        sim_node_fail(n, sim_emcy_sync_lost);
    }
}

void sim_node_fail(sim_node_t *n, uint32_t emcy)
{
    sim_cia402_fail(&n->power);
    n->emcy = emcy;
}

static void say_emcy(sim_node_t *n, sim_frames_t *out)
{
    enum { generic_error = 1 }; // bit 0 of the error register, CiA 301, object 1001h
    sim_frame_t *frame = sim_frames_add(out, id_emcy + n->id);
    sim_frame_put(frame, n->emcy, 2);
    sim_frame_put(frame, n->emcy != sim_emcy_none ? generic_error : 0u, 1);
    frame->n = 8;
    n->emcy = sim_emcy_none;
}

static void say_tpdo(const sim_node_t *n, sim_frames_t *out, uint32_t actual)
{
    sim_frame_t *frame = sim_frames_add(out, id_tpdo1 + n->id);
    if (n->is_drive) {
        sim_frame_put(frame, sim_cia402_status(&n->power), 2);
    }
    sim_frame_put(frame, actual, 4);
}

static void say_state(sim_node_t *n, sim_frames_t *out, double t_s)
{
    if (!n->has_booted) {
        n->has_booted = true;
        n->heartbeat_due_s = t_s;
        sim_cia402_boot(&n->power);
        sim_frame_put(sim_frames_add(out, id_heartbeat + n->id), sim_nmt_boot_up, 1);
    } else if (t_s >= n->heartbeat_due_s && !n->is_heartbeat_broken) {
        sim_frame_put(sim_frames_add(out, id_heartbeat + n->id), n->nmt, 1);
    } else {
        return;
    }
    while (n->heartbeat_due_s <= t_s) {
        n->heartbeat_due_s += n->heartbeat_s;
    }
}

void sim_node_speak(sim_node_t *n, sim_frames_t *out, uint32_t actual, double t_s)
{
    if (n->is_dead) {
        return;
    }
    if (n->nmt == sim_nmt_operational) {
        say_tpdo(n, out, actual);
    }
    if (n->emcy != sim_emcy_none) {
        say_emcy(n, out);
    }
    say_state(n, out, t_s);
}
