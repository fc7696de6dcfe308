// SPDX-License-Identifier: Apache-2.0
#include "sim_bus.h"
#include "sim_units.h" // SIM_TWO_PI

enum { id_sync = 0x080, id_tpdo1 = 0x180, id_status = 0x1C0 };

/// At rest below.
#define REST_NM_PER_S 1000.0
#define REST_RAD_PER_S 0.01

static const uint32_t node_id[sim_bus_n_nodes] = {1, 2, 3, 4, 5};

void sim_bus_init(sim_bus_t *b, const sim_bus_config_t *config, double x_nm, double z_nm)
{
    const double start_nm[hal_n_axes] = {0.0, x_nm, z_nm};
    *b = (sim_bus_t){.config = *config, .period_s = 1.0 / config->machine.tick_hz};
    sim_spindle_init(&b->spindle, &config->machine.spindle);
    sim_encoder_init(&b->encoder, &config->machine.encoder, b->spindle.turn, config->seed);
    for (int i = 0; i < hal_n_axes; i++) {
        sim_drive_init(&b->axis[i], &config->machine.axis[i], start_nm[i], 0.5 * b->period_s);
    }
    for (int i = 0; i < sim_bus_n_nodes; i++) {
        sim_node_init(&b->node[i], node_id[i], i != sim_bus_encoder, config->heartbeat_s);
        b->node[i].is_dead = config->is_foreign[i];
    }
    b->inputs.is_ready = true;
    b->index_s = -1.0;
}

/// The state and the faults of the controller, as its status message has them.
static void take_status(sim_bus_t *b, const sim_frame_t *frame)
{
    if (frame->n == 8u) {
        b->has_status = true;
        b->told_state = frame->data[0];
        b->told_faults = sim_frame_get_u32(frame, 4);
    }
}

/// Where a drive that is somebody else's says that it is.
static void take_foreign(sim_bus_t *b, const sim_frame_t *frame)
{
    for (int i = sim_bus_u; i <= sim_bus_z; i++) {
        if (b->config.is_foreign[i] && frame->id == id_tpdo1 + node_id[i] && frame->n == 6u) {
            b->axis[i - sim_bus_u].pos_nm = (int32_t)sim_frame_get_u32(frame, 2);
        }
    }
}

void sim_bus_receive(sim_bus_t *b, const sim_frame_t *frame)
{
    const double tick_s = b->time_s + 0.5 * b->period_s;
    if (frame->id == id_sync) {
        b->has_sync = true;
        b->n_syncs++;
        b->sync_s = tick_s;
        return;
    }
    if (frame->id == id_status) {
        take_status(b, frame);
    }
    take_foreign(b, frame);
    for (int i = 0; i < sim_bus_n_nodes; i++) {
        sim_node_receive(&b->node[i], frame, tick_s);
    }
}

static void move_axis(sim_bus_t *b, int i)
{
    sim_drive_t *drive = &b->axis[i];
    sim_node_t *node = &b->node[sim_bus_u + i];
    if (b->config.is_foreign[sim_bus_u + i]) {
        return;
    }
    sim_drive_step(drive, node->active.target, sim_cia402_is_following(&node->power));
    if (sim_abs(drive->vel_nm_per_s) < REST_NM_PER_S) {
        sim_cia402_rest(&node->power);
    }
}

static void move_spindle(sim_bus_t *b)
{
    sim_node_t *node = &b->node[sim_bus_spindle];
    const bool is_following = sim_cia402_is_following(&node->power);
    double set = is_following ? node->active.target * (SIM_TWO_PI / 60000.0) : 0.0;
    set = b->is_speed_forced ? b->forced_rad_per_s : set;
    sim_spindle_step(&b->spindle, b->is_reversed ? -set : set, 0.5 * b->period_s);
    if (sim_abs(b->spindle.speed_rad_per_s) < REST_RAD_PER_S) {
        sim_cia402_rest(&node->power);
    }
}

static void half(sim_bus_t *b)
{
    for (int i = 0; i < hal_n_axes; i++) {
        move_axis(b, i);
    }
    move_spindle(b);
}

static void take_sample(sim_bus_t *b)
{
    b->sample = (sim_bus_sample_t){
        .t_s = b->time_s + 0.5 * b->period_s,
        .turn = b->spindle.turn,
        .u_nm = b->axis[hal_axis_u].pos_nm,
        .x_nm = b->axis[hal_axis_x].pos_nm,
        .z_nm = b->axis[hal_axis_z].pos_nm,
    };
}

static uint32_t encoder_value(sim_bus_t *b)
{
    const uint32_t modulus = b->config.encoder_modulus;
    const uint32_t counts = sim_encoder_read(&b->encoder, b->spindle.turn).counts + b->count_offset;
    const uint32_t value = b->is_encoder_stuck ? b->stuck_counts : counts;
    b->stuck_counts = value;
    b->encoder_counts = modulus > 0u ? value % modulus : value;
    return b->encoder_counts;
}

static uint32_t actual_of(sim_bus_t *b, int i)
{
    if (i == sim_bus_encoder) {
        return encoder_value(b);
    }
    if (i == sim_bus_spindle) {
        const double rad_per_s = sim_spindle_true_rad_per_s(&b->spindle);
        return (uint32_t)(int32_t)sim_round(rad_per_s * (60000.0 / SIM_TWO_PI));
    }
    return (uint32_t)sim_drive_measured_nm(&b->axis[i - sim_bus_u]);
}

static void speak(sim_bus_t *b)
{
    b->out.n = 0;
    b->inputs.is_ready = !b->is_ready_broken;
    for (int i = 0; i < sim_bus_n_nodes; i++) {
        sim_node_t *node = &b->node[i];
        sim_node_speak(node, &b->out, actual_of(b, i), b->time_s);
        if (sim_cia402_is_failed(&node->power)) {
            b->inputs.is_ready = false;
        }
    }
    sim_disturb_pass(&b->disturb, &b->out, id_tpdo1 + node_id[sim_bus_encoder], b->time_s);
}

/// The speed of this moment holds for a period but for a millionth of a turn.
static void foresee_index(sim_bus_t *b)
{
    const double per_s = sim_spindle_true_rad_per_s(&b->spindle) / SIM_TWO_PI;
    const double place = b->spindle.turn - b->config.machine.encoder.index_turn;
    const double from = sim_fraction(place); // turns since the index
    const double ahead = per_s > 0.0 ? 1.0 - from : from;
    const double wait_s = ahead / sim_abs(per_s);
    b->index_s = per_s != 0.0 && wait_s < b->period_s && !b->is_index_dead ? wait_s : -1.0;
}

void sim_bus_step(sim_bus_t *b)
{
    half(b);
    take_sample(b);
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
    speak(b);
    foresee_index(b);
}

static void force_speed(sim_bus_t *b, double rad_per_s)
{
    b->is_speed_forced = true;
    b->forced_rad_per_s = rad_per_s;
}

static sim_node_t *node_of(sim_bus_t *b, double id)
{
    for (int i = 0; i < sim_bus_n_nodes; i++) {
        if ((double)b->node[i].id == id) {
            return &b->node[i];
        }
    }
    return &b->node[0];
}

static void inject_node(sim_bus_t *b, const sim_inject_t *inject)
{
    sim_node_t *node = node_of(b, inject->value);
    if (inject->kind == sim_inject_heartbeat_lost) {
        node->is_heartbeat_broken = true;
    } else if (inject->kind == sim_inject_node_dead) {
        node->is_dead = true;
    } else {
        sim_node_fail(node, sim_emcy_internal);
    }
}

static void inject_frames(sim_bus_t *b, const sim_inject_t *inject)
{
    const uint32_t n = (uint32_t)inject->value;
    if (inject->kind == sim_inject_encoder_late) {
        sim_disturb_begin(&b->disturb, sim_disturb_late, 1, inject->value * 1e-6);
    } else if (inject->kind == sim_inject_encoder_missing) {
        sim_disturb_begin(&b->disturb, sim_disturb_missing, n, 0.0);
    } else if (inject->kind == sim_inject_encoder_repeated) {
        sim_disturb_begin(&b->disturb, sim_disturb_repeated, n, 0.0);
    } else {
        sim_disturb_begin(&b->disturb, sim_disturb_swapped, n, 0.0);
    }
}

void sim_bus_inject(sim_bus_t *b, const sim_inject_t *inject, int direction)
{
    switch (inject->kind) {
    case sim_inject_estop:
        b->inputs.is_estop = true;
        break;
    case sim_inject_drive:
        b->is_ready_broken = true;
        break;
    case sim_inject_lost_counts:
        b->count_offset -= (uint32_t)inject->value;
        break;
    case sim_inject_encoder_jump:
        b->count_offset += (uint32_t)(int32_t)inject->value;
        break;
    case sim_inject_encoder_stuck:
        b->is_encoder_stuck = true;
        break;
    case sim_inject_index_dead:
        b->is_index_dead = true;
        break;
    case sim_inject_reverse:
        b->is_reversed = true;
        break;
    case sim_inject_spindle_speed:
        force_speed(b, direction * inject->value * (SIM_TWO_PI / 60.0));
        break;
    case sim_inject_spindle_stop:
        force_speed(b, 0.0);
        break;
    case sim_inject_u_block:
        b->axis[hal_axis_u].is_blocked = true;
        break;
    case sim_inject_heartbeat_lost:
    case sim_inject_node_dead:
    case sim_inject_node_fault:
        inject_node(b, inject);
        break;
    default:
        inject_frames(b, inject);
        break;
    }
}

bool sim_bus_is_at_rest(const sim_bus_t *b)
{
    bool is_at_rest = sim_abs(b->spindle.speed_rad_per_s) < REST_RAD_PER_S;
    for (int i = 0; i < hal_n_axes; i++) {
        is_at_rest = is_at_rest && sim_abs(b->axis[i].vel_nm_per_s) < REST_NM_PER_S;
    }
    return is_at_rest;
}
