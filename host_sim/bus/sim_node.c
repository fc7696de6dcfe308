// SPDX-License-Identifier: Apache-2.0
#include "sim_bus.h"
#include "canopen.h" // common_get_u16

enum { rpdo1_bytes = 6, rpdo1_fd_bytes = 12, rpdo2_bytes = 4 };

static void boot(sim_node_t *n)
{
    n->nmt = canopen_pre_operational;
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
    case canopen_start:
        n->nmt = canopen_operational;
        break;
    case canopen_stop:
        n->nmt = canopen_stopped;
        break;
    case canopen_enter_pre_operational:
        n->nmt = canopen_pre_operational;
        break;
    case canopen_reset:
    case canopen_reset_communication:
        boot(n);
        break;
    default:
        break;
    }
}

void sim_node_receive(sim_node_t *n, const sim_frame_t *frame, double t_s)
{
    if (n->is_dead) {
        return;
    }
    if (frame->id == canopen_id_nmt) {
        manage(n, frame);
    }
    if (!n->is_drive || n->nmt != canopen_operational) {
        return;
    }
    if (frame->id == canopen_id_rpdo1 + n->id) {
        if (frame->n != rpdo1_bytes && frame->n != rpdo1_fd_bytes) {
            n->emcy = sim_emcy_pdo_length;
            return;
        }
        n->heard.control_word = common_get_u16(frame->data);
        n->heard.target = (int32_t)common_get_u32(frame->data + 2);
        if (frame->n == rpdo1_fd_bytes) {
            n->heard.velocity_offset = (int32_t)common_get_u32(frame->data + 6);
        }
        n->has_rpdo = true;
        n->rpdo_s = t_s;
    } else if (frame->id == canopen_id_rpdo2 + n->id) {
        if (frame->n == rpdo2_bytes) {
            n->heard.velocity_offset = (int32_t)common_get_u32(frame->data);
        } else {
            n->emcy = sim_emcy_pdo_length;
        }
    }
}

void sim_node_sync(sim_node_t *n, double t_s)
{
    if (n->is_dead || n->nmt != canopen_operational) {
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
    if (n->is_dead || n->nmt != canopen_operational || t_s - n->rpdo_s > guard_s) {
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

static void queue_heartbeat(sim_node_t *n, sim_frames_t *out, double t_s)
{
    if (!n->has_booted) {
        n->has_booted = true;
        n->heartbeat_due_s = t_s;
        sim_cia402_boot(&n->power);
        sim_frame_put(sim_frames_add(out, canopen_id_heartbeat + n->id), canopen_boot_up, 1);
    } else if (t_s >= n->heartbeat_due_s && !n->is_heartbeat_broken) {
        sim_frame_put(sim_frames_add(out, canopen_id_heartbeat + n->id), n->nmt, 1);
    } else {
        return;
    }
    while (n->heartbeat_due_s <= t_s) {
        n->heartbeat_due_s += n->heartbeat_s;
    }
}

void sim_node_send(sim_node_t *n, sim_frames_t *out, uint32_t actual, double t_s)
{
    if (n->is_dead) {
        return;
    }
    if (n->nmt == canopen_operational) {
        sim_frame_t *frame = sim_frames_add(out, canopen_id_tpdo1 + n->id);
        if (n->is_drive) {
            sim_frame_put(frame, sim_cia402_status(&n->power), 2);
        }
        sim_frame_put(frame, actual, 4);
    }
    if (n->emcy != sim_emcy_none) {
        enum { generic_error = 1 }; // bit 0 of the error register, CiA 301, object 1001h
        sim_frame_t *frame = sim_frames_add(out, canopen_id_emcy + n->id);
        sim_frame_put(frame, n->emcy, 2);
        sim_frame_put(frame, generic_error, 1);
        frame->n = 8;
        n->emcy = sim_emcy_none;
    }
    queue_heartbeat(n, out, t_s);
}
