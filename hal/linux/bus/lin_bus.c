// SPDX-License-Identifier: Apache-2.0
#include "lin_bus.h"
#include "canopen.h" // common_put_u16, common_get_u32

enum { ns_per_ms = 1000000 };

void lin_bus_init(lin_bus_t *b, const lin_config_t *config)
{
    *b = (lin_bus_t){
        .config = *config,
        .timeouts = {.node_ns = config->can.node_timeout_ms * ns_per_ms,
                     .pdo_ns = config->can.pdo_timeout_ms * ns_per_ms,
                     .enable_ns = config->can.enable_ms * ns_per_ms},
        .encoder_node.id = (uint32_t)config->encoder.node,
        .inputs = hal_in_bus_lost,
        .is_silent = true,
        .has_duplicate = true,
    };
    lin_encoder_init(&b->encoder, &config->encoder, config->thread.tick_hz);
    for (int i = 0; i < hal_n_axes; i++) {
        const lin_drive_config_t *drive = &config->drive[i];
        lin_drive_init(&b->drive[i], drive->node, drive->counts, drive->nm);
    }
    lin_drive_init(&b->drive[lin_bus_spindle], config->spindle_node, 1, 1);
}

static uint32_t own_heartbeat(const lin_bus_t *b)
{
    return canopen_id_heartbeat + (uint32_t)b->config.can.node;
}

/// @return whether only a controller sends frames with this identifier
static bool is_controllers(const lin_bus_t *b, uint32_t id)
{
    bool is = id == canopen_id_sync || id == own_heartbeat(b);
    for (int i = 0; i < lin_bus_n_drives; i++) {
        is = is || (b->drive[i].node.id != 0u && id == canopen_id_rpdo1 + b->drive[i].node.id);
    }
    return is;
}

/// List the identifiers of the frames of a node. @return their number, 0 if node is 0
static uint32_t ids_of_node(uint32_t node, uint32_t *ids)
{
    ids[0] = canopen_id_emcy + node;
    ids[1] = canopen_id_tpdo1 + node;
    ids[2] = canopen_id_heartbeat + node;
    return node != 0u ? 3u : 0u;
}

uint32_t lin_bus_ids(const lin_bus_t *b, uint32_t *ids)
{
    uint32_t n = 0;
    ids[n++] = canopen_id_sync;
    ids[n++] = own_heartbeat(b);
    n += ids_of_node(b->encoder_node.id, &ids[n]);
    for (int i = 0; i < lin_bus_n_drives; i++) {
        const uint32_t node = b->drive[i].node.id;
        n += ids_of_node(node, &ids[n]);
        ids[n] = canopen_id_rpdo1 + node;
        n += node != 0u ? 1u : 0u;
    }
    return n;
}

void lin_bus_receive(lin_bus_t *b, const hal_can_frame_t *frame, int64_t ns)
{
    if (is_controllers(b, frame->id)) {
        b->is_other_heard = true;
        b->is_duplicate_heard = b->is_duplicate_heard || frame->id == own_heartbeat(b);
        b->other_ns = ns;
        return;
    }
    if (frame->id == canopen_id_tpdo1 + b->encoder_node.id && frame->n == 4u) {
        lin_encoder_receive(&b->encoder, common_get_u32(frame->data), ns);
        return;
    }
    bool is_taken = lin_node_receive(&b->encoder_node, frame, ns);
    for (int i = 0; i < lin_bus_n_drives && !is_taken; i++) {
        is_taken = lin_drive_receive(&b->drive[i], frame, ns);
    }
}

void lin_bus_link(lin_bus_t *b, lin_loss_t link)
{
    b->link = link;
}

void lin_bus_event(lin_bus_t *b, lin_loss_t event)
{
    b->event = event;
}

static lin_loss_t encoder_loss(lin_bus_t *b, int64_t now_ns)
{
    const lin_loss_t loss = lin_node_judge(&b->encoder_node, now_ns, b->timeouts.node_ns);
    if (loss != lin_loss_none) {
        return loss;
    }
    if (b->encoder_node.emcy != 0u) {
        return lin_loss_emcy;
    }
    return lin_encoder_is_fresh(&b->encoder, now_ns) ? lin_loss_none : lin_loss_pdo;
}

/// Not-ready drives prevent the retract of U. A spindle drive that fails while enabled must not
/// prevent it, so its failure is reported as a loss of the bus.
static lin_loss_t drive_loss(const lin_bus_t *b, int i)
{
    const lin_drive_t *d = &b->drive[i];
    if (d->loss != lin_loss_none || i != lin_bus_spindle || d->is_ready || !d->is_enabled) {
        return d->loss;
    }
    return d->node.emcy != 0u ? lin_loss_emcy : lin_loss_spindle;
}

/// @return whether another controller was heard within the node timeout
static bool is_other_there(const lin_bus_t *b, int64_t now_ns)
{
    return b->is_other_heard && now_ns - b->other_ns <= b->timeouts.node_ns;
}

/// @return the cause with the highest priority: bus, then encoder, then drives
static lin_cause_t find_cause(lin_bus_t *b, int64_t now_ns)
{
    const lin_loss_t encoder = encoder_loss(b, now_ns);
    const lin_loss_t own = b->link != lin_loss_none    ? b->link
                           : b->event != lin_loss_none ? b->event
                           : is_other_there(b, now_ns) ? lin_loss_other_controller
                           : b->is_silent              ? lin_loss_listening
                                                       : lin_loss_none;
    if (own != lin_loss_none) {
        return (lin_cause_t){.loss = own};
    }
    if (encoder != lin_loss_none) {
        return (lin_cause_t){encoder, b->encoder_node.id, b->encoder_node.emcy};
    }
    for (int i = 0; i < lin_bus_n_drives; i++) {
        const lin_node_t *node = &b->drive[i].node;
        const lin_loss_t loss = drive_loss(b, i);
        if (loss != lin_loss_none) {
            return (lin_cause_t){loss, node->id, node->emcy};
        }
    }
    return (lin_cause_t){.loss = lin_loss_none};
}

/// Check all drives, last one first, so that not_ready names the first drive that is not ready.
/// @return hal_in_drive_ready or 0
static uint32_t judge_drives(lin_bus_t *b, int64_t now_ns)
{
    b->not_ready = (lin_cause_t){.loss = lin_loss_none};
    bool is_ready = true;
    for (int i = lin_bus_n_drives - 1; i >= 0; i--) {
        lin_drive_t *d = &b->drive[i];
        lin_drive_judge(d, now_ns, &b->timeouts);
        const bool may_fail = i == lin_bus_spindle && d->is_enabled;
        if (!d->is_ready && !may_fail) {
            is_ready = false;
            b->not_ready = (lin_cause_t){d->loss, d->node.id, d->node.emcy};
        }
    }
    return is_ready && b->link == lin_loss_none ? hal_in_drive_ready : 0u;
}

void lin_bus_judge(lin_bus_t *b, int64_t now_ns)
{
    const uint32_t ready = judge_drives(b, now_ns);
    const lin_cause_t cause = find_cause(b, now_ns);
    // While the fault output is on, the original cause stays; later ones are consequences.
    const bool is_latched =
        (b->inputs & hal_in_bus_lost) != 0u && (b->outputs & hal_out_fault) != 0u;
    b->event = lin_loss_none;
    if (!is_latched) {
        b->cause = cause;
    }
    b->inputs =
        ready | (is_latched || cause.loss != lin_loss_none ? (uint32_t)hal_in_bus_lost : 0u);
}

int32_t lin_bus_actual_nm(const lin_bus_t *b, hal_axis_t axis, const lin_commands_t *commands)
{
    const lin_drive_t *d = &b->drive[axis];
    return d->node.id != 0u ? lin_drive_actual_nm(d) : commands->axis[axis].pos_nm;
}

/// Enable or disable the drives. When the operator has reset the fault, clear the emergency
/// messages of all nodes.
static void apply_outputs(lin_bus_t *b, const lin_commands_t *commands, int64_t now_ns)
{
    const bool was_fault = (b->outputs & hal_out_fault) != 0u;
    const bool is_fault = (commands->outputs & hal_out_fault) != 0u;
    const bool is_enabled = (commands->outputs & hal_out_enable) != 0u && !commands->is_stopping;
    for (int i = 0; i < lin_bus_n_drives; i++) {
        lin_drive_enable(&b->drive[i], is_enabled, now_ns);
        if (was_fault && !is_fault) {
            lin_drive_forget(&b->drive[i]);
        }
    }
    if (was_fault && !is_fault) {
        b->encoder_node.emcy = 0;
    }
    b->outputs = commands->outputs;
}

/// @return the control word; drive faults are reset only in the state off
static uint16_t control(lin_bus_t *b, int i, const lin_commands_t *commands, int64_t now_ns)
{
    const bool may_reset = (commands->outputs & (hal_out_enable | hal_out_fault)) == 0u;
    return lin_drive_control(&b->drive[i], now_ns, may_reset, commands->is_stopping);
}

/// Position and velocity offset of an axis: one FD frame or two classic frames.
static uint32_t make_axis(lin_bus_t *b, int i, const lin_commands_t *commands, int64_t now_ns,
                          hal_can_frame_t *frames)
{
    const lin_drive_t *d = &b->drive[i];
    const hal_setpoint_t *want = &commands->axis[i];
    const int64_t nm_per_s = lin_div_round((int64_t)want->vel_q10 * b->config.thread.tick_hz, 1024);
    frames[0] = (hal_can_frame_t){.id = canopen_id_rpdo1 + d->node.id, .n = 6};
    common_put_u16(frames[0].data, control(b, i, commands, now_ns));
    common_put_i32(frames[0].data + 2, lin_drive_units(d, want->pos_nm));
    if (b->config.can.is_fd) {
        frames[0].n = 12; // 10 is not a valid FD length
        common_put_i32(frames[0].data + 6, lin_drive_units(d, nm_per_s));
        return 1;
    }
    frames[1] = (hal_can_frame_t){.id = canopen_id_rpdo2 + d->node.id, .n = 4};
    common_put_i32(frames[1].data, lin_drive_units(d, nm_per_s));
    return 2;
}

/// Network management: own heartbeat, NMT start of all nodes, NMT start of late nodes.
static uint32_t make_management(lin_bus_t *b, int64_t now_ns, hal_can_frame_t *frames)
{
    uint32_t n = 0;
    const int64_t interval_ns = b->config.can.heartbeat_ms * ns_per_ms;
    if (!b->is_started || now_ns - b->heartbeat_ns >= interval_ns) {
        frames[n++] =
            (hal_can_frame_t){.id = own_heartbeat(b),
                              .n = 1,
                              .data = {b->is_started ? canopen_operational : canopen_boot_up}};
        b->heartbeat_ns = now_ns;
    }
    if (!b->is_started) {
        frames[n++] = (hal_can_frame_t){.id = canopen_id_nmt, .n = 2, .data = {canopen_start, 0}};
        b->is_started = true;
    }
    if ((b->outputs & hal_out_enable) == 0u) {
        n += lin_node_start(&b->encoder_node, now_ns, &frames[n]) ? 1u : 0u;
        for (int i = 0; i < lin_bus_n_drives; i++) {
            n += lin_node_start(&b->drive[i].node, now_ns, &frames[n]) ? 1u : 0u;
        }
    }
    return n;
}

/// Listening starts with the program, and again when another controller is heard while no drive is
/// in operation. It ends when no other controller was heard for node_timeout_ms.
static void listen(lin_bus_t *b, int64_t now_ns)
{
    if (!b->is_begun) {
        b->is_begun = true;
        b->begin_ns = now_ns;
        b->silent_ns = now_ns;
    }
    const bool is_off = (b->outputs & hal_out_enable) == 0u && lin_bus_is_at_rest(b);
    if (is_other_there(b, now_ns)) {
        b->is_silent = b->is_silent || is_off;
        b->silent_ns = b->other_ns;
    } else if (b->is_silent && now_ns - b->silent_ns > b->timeouts.node_ns) {
        b->is_silent = false;
        b->is_other_heard = false;
        b->is_duplicate_heard = false;
    }
    // Every node sends a heartbeat within node_ns; only then a duplicate node number is excluded.
    const bool is_known = now_ns - b->begin_ns > b->timeouts.node_ns;
    b->has_duplicate = b->is_silent && (b->is_duplicate_heard || !is_known);
}

uint32_t lin_bus_make(lin_bus_t *b, const lin_commands_t *commands, int64_t now_ns,
                      hal_can_frame_t *frames)
{
    apply_outputs(b, commands, now_ns);
    listen(b, now_ns);
    if (b->is_silent) {
        return 0;
    }
    uint32_t n = 0;
    for (int i = 0; i < hal_n_axes; i++) {
        if (b->drive[i].node.id != 0u) {
            n += make_axis(b, i, commands, now_ns, &frames[n]);
        }
    }
    const uint32_t spindle = b->drive[lin_bus_spindle].node.id;
    if (spindle != 0u) {
        frames[n] = (hal_can_frame_t){.id = canopen_id_rpdo1 + spindle, .n = 6};
        common_put_u16(frames[n].data, control(b, lin_bus_spindle, commands, now_ns));
        common_put_i32(frames[n].data + 2, commands->is_stopping ? 0 : commands->spindle_mrpm);
        n++;
    }
    frames[n++] = (hal_can_frame_t){.id = canopen_id_sync};
    return n + make_management(b, now_ns, &frames[n]);
}

bool lin_bus_is_at_rest(const lin_bus_t *b)
{
    for (int i = 0; i < lin_bus_n_drives && !b->is_silent; i++) {
        const lin_drive_t *d = &b->drive[i];
        if (d->has_status && d->loss == lin_loss_none &&
            (d->state == cia402_operation_enabled || d->state == cia402_quick_stop_active)) {
            return false;
        }
    }
    return true;
}
