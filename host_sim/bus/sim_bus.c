// SPDX-License-Identifier: Apache-2.0
#include "sim_bus.h"
#include "canopen.h"   // common_get_u32
#include "sim_units.h" // SIM_TWO_PI

enum { id_status = 0x1C0 };

static const uint32_t node_id[sim_bus_n_nodes] = {1, 2, 3, 4, 5};

void sim_bus_init(sim_bus_t *b, const sim_bus_config_t *config, double x_nm, double z_nm)
{
    *b = (sim_bus_t){.config = *config, .period_s = 1.0 / config->lathe.tick_hz};
    sim_lathe_init(&b->lathe, &config->lathe, 0.5 * b->period_s, x_nm, z_nm, config->seed);
    for (int i = 0; i < sim_bus_n_nodes; i++) {
        sim_node_init(&b->node[i], node_id[i], i != sim_bus_encoder, config->heartbeat_s);
        b->node[i].is_dead = config->is_foreign[i];
    }
    for (int i = 0; i < hal_n_axes; i++) { // only its frames move a foreign drive
        b->lathe.drive[i].is_blocked = config->is_foreign[sim_bus_u + i];
    }
    b->inputs.is_ready = true;
    b->index_s = -1.0;
}

void sim_bus_receive(sim_bus_t *b, const sim_frame_t *frame)
{
    // The controller's frames belong to the tick in the middle of the step.
    const double tick_s = b->time_s + 0.5 * b->period_s;
    if (frame->id == canopen_id_sync) {
        b->has_sync = true;
        b->n_syncs++;
        b->sync_s = tick_s;
        return;
    }
    if (frame->id == id_status && frame->n == 8u) { // the controller's status
        b->has_status = true;
        b->reported_state = frame->data[0];
        b->reported_faults = common_get_u32(frame->data + 4);
    }
    for (int i = 0; i < hal_n_axes; i++) { // position reported by a foreign drive
        const int node = sim_bus_u + i;
        if (b->config.is_foreign[node] && frame->id == canopen_id_tpdo1 + node_id[node] &&
            frame->n == 6u) {
            b->lathe.drive[i].pos_micro = (int32_t)common_get_u32(frame->data + 2);
        }
    }
    for (int i = 0; i < sim_bus_n_nodes; i++) {
        sim_node_receive(&b->node[i], frame, tick_s);
    }
}

/// Advance by half a period with the targets of the last SYNC.
static void half(sim_bus_t *b)
{
    sim_node_t *spindle = &b->node[sim_bus_spindle];
    const bool is_driven = sim_cia402_is_following(&spindle->power);
    sim_setpoints_t set = {
        .spindle_rad_per_s = is_driven ? spindle->active.target * (SIM_TWO_PI / 60000.0) : 0.0,
    };
    for (int i = 0; i < hal_n_axes; i++) {
        const sim_node_t *node = &b->node[sim_bus_u + i];
        set.micro[i] = node->active.target;
        set.is_enabled[i] = sim_cia402_is_following(&node->power);
    }
    sim_lathe_step(&b->lathe, &set);
    for (int i = 0; i < hal_n_axes; i++) {
        if (sim_lathe_drive_rests(&b->lathe, i)) {
            sim_cia402_rest(&b->node[sim_bus_u + i].power);
        }
    }
    if (sim_lathe_spindle_rests(&b->lathe)) {
        sim_cia402_rest(&spindle->power);
    }
}

/// @return the measured value of a node, as sent in its TPDO
static uint32_t actual_of(sim_bus_t *b, int node)
{
    if (node == sim_bus_encoder) {
        const uint32_t modulus = b->config.encoder_modulus;
        const uint32_t counts = sim_lathe_encoder(&b->lathe).counts;
        b->encoder_counts = modulus > 0u ? counts % modulus : counts;
        return b->encoder_counts;
    }
    if (node == sim_bus_spindle) {
        const double rad_per_s = sim_spindle_true_rad_per_s(&b->lathe.spindle);
        return (uint32_t)(int32_t)sim_round(rad_per_s * (60000.0 / SIM_TWO_PI));
    }
    return (uint32_t)sim_lathe_measured_micro(&b->lathe, node - sim_bus_u);
}

/// Queue the frames of all nodes. Injected bus faults act on the encoder's frames.
static void queue_frames(sim_bus_t *b)
{
    b->out.n = 0;
    b->inputs.is_ready = !b->is_ready_broken;
    for (int i = 0; i < sim_bus_n_nodes; i++) {
        sim_node_t *node = &b->node[i];
        sim_node_send(node, &b->out, actual_of(b, i), b->time_s);
        if (sim_cia402_is_failed(&node->power)) {
            b->inputs.is_ready = false;
        }
    }
    sim_disturb_pass(&b->disturb, &b->out, canopen_id_tpdo1 + node_id[sim_bus_encoder], b->time_s);
}

/// Predict the index edge from the present speed, right to a millionth of a turn over a period.
static void foresee_index(sim_bus_t *b)
{
    const sim_spindle_t *spindle = &b->lathe.spindle;
    const double per_s = sim_spindle_true_rad_per_s(spindle) / SIM_TWO_PI;
    const double place = spindle->turn - b->config.lathe.encoder.index_turn;
    const double from = sim_fraction(place); // turns since the index
    const double ahead = per_s > 0.0 ? 1.0 - from : from;
    const double wait_s = ahead / sim_abs(per_s);
    const bool is_near = per_s != 0.0 && wait_s < b->period_s;
    b->index_s = is_near && !b->lathe.is_index_dead ? wait_s : -1.0;
}

void sim_bus_step(sim_bus_t *b)
{
    half(b);
    b->sample = sim_lathe_sample(&b->lathe, b->time_s + 0.5 * b->period_s);
    for (int i = 0; i < sim_bus_n_nodes && b->has_sync; i++) {
        sim_node_sync(&b->node[i], b->sync_s);
    }
    b->has_sync = false;
    half(b);
    b->n_steps++;
    b->time_s = (double)b->n_steps * b->period_s;
    for (int i = 0; i < sim_bus_n_nodes; i++) {
        sim_node_guard(&b->node[i], b->time_s, b->config.guard_s);
    }
    queue_frames(b);
    foresee_index(b);
}

/// Cause a fault of the node whose number is the value of the injection.
static void inject_node(sim_bus_t *b, const sim_inject_t *inject)
{
    int i = 0;
    while (i + 1 < sim_bus_n_nodes && (double)b->node[i].id != inject->value) {
        i++;
    }
    sim_node_t *node = &b->node[i];
    if (inject->kind == sim_inject_heartbeat_lost) {
        node->is_heartbeat_broken = true;
    } else if (inject->kind == sim_inject_node_dead) {
        node->is_dead = true;
    } else {
        sim_node_fail(node, sim_emcy_internal);
    }
}

void sim_bus_inject(sim_bus_t *b, const sim_inject_t *inject, int direction)
{
    const double value = inject->value;
    switch (inject->kind) {
    case sim_inject_estop:
        b->inputs.is_estop = true;
        break;
    case sim_inject_drive:
        b->is_ready_broken = true;
        break;
    case sim_inject_heartbeat_lost:
    case sim_inject_node_dead:
    case sim_inject_node_fault:
        inject_node(b, inject);
        break;
    case sim_inject_encoder_late:
        sim_disturb_begin(&b->disturb, sim_disturb_late, 1, value * 1e-6);
        break;
    case sim_inject_encoder_missing:
        sim_disturb_begin(&b->disturb, sim_disturb_missing, (uint32_t)value, 0.0);
        break;
    case sim_inject_encoder_repeated:
        sim_disturb_begin(&b->disturb, sim_disturb_repeated, (uint32_t)value, 0.0);
        break;
    case sim_inject_encoder_swapped:
        sim_disturb_begin(&b->disturb, sim_disturb_swapped, (uint32_t)value, 0.0);
        break;
    default:
        sim_inject_apply(inject, &b->lathe, direction);
        break;
    }
}

bool sim_bus_is_at_rest(const sim_bus_t *b)
{
    bool is_at_rest = sim_lathe_spindle_rests(&b->lathe);
    for (int i = 0; i < hal_n_axes; i++) {
        is_at_rest = is_at_rest && sim_lathe_drive_rests(&b->lathe, i);
    }
    return is_at_rest;
}
