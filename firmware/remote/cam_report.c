// SPDX-License-Identifier: Apache-2.0
#include "cam_remote_inner.h"
#include "cam_fix.h"     // cam_sat_i32, cam_clamp_i64
#include "cam_machine.h" // cam_machine_rights
#include "camturn.h"     // camturn_state_pack

/// [Hz] rate of the status.
enum { status_hz = 100 };

/// Pages of Detail.
enum {
    page_motion,
    page_load,
    page_rate,
    page_table,
    page_crc,
    page_name,
    page_learning = 11,
    page_hand = 16,
    page_changes = 18,
    page_params = 21,
    page_recorder,
    page_progress,
    page_pace,
    page_rights
};

/// Characters of the table's name in a page, where they form one number of 48 bits.
enum { name_chars = 6 };

_Static_assert((page_learning - page_name) * name_chars >= cam_table_name_size, "the whole name");

// Spot check of the state numbers; test_can_messages.py compares all names.
_Static_assert(CAMTURN_STATE_STATE_FAULT_CHOICE == cam_state_fault,
               "camturn.dbc is of other sources");

/// Send a packed frame of n bytes; it is dropped if it does not fit.
static void send(hal_can_frame_t *frame, uint32_t id, int n)
{
    frame->id = id;
    frame->n = (uint32_t)n;
    (void)hal_can_write(frame);
}

static void send_state(const cam_report_t *r, const cam_table_store_t *store,
                       const cam_status_t *status)
{
    struct camturn_state_t m = {
        .state = (uint8_t)status->state,
        .reset_reason = (uint8_t)((uint32_t)r->start.reset & 0xFFu),
        .table_result = (int16_t)store->err,
    };
#define FAULT_BIT(name, what)                                                                      \
    m.fault_##name = (uint8_t)(status->faults >> (uint32_t)cam_fault_##name & 1u);
    CAM_FAULTS(FAULT_BIT)
#undef FAULT_BIT
    hal_can_frame_t frame;
    send(&frame, CAMTURN_STATE_FRAME_ID, camturn_state_pack(frame.data, &m, sizeof frame.data));
}

/// @return [turn / 2^32] drawing's angle at the tool; the firmware counts in the sense of cutting
static uint32_t drawing_angle_q32(const cam_machine_t *m, const cam_status_t *status)
{
    const uint32_t theta_q32 = (uint32_t)(uint64_t)status->pos_q32;
    return m->has_table && m->table.direction < 0 ? 0u - theta_q32 : theta_q32;
}

/// The speed is [turn / 2^32 per tick]; times ticks per minute it is [r/min / 2^32], and
/// 60 000 = 1875 * 2^5 makes it [r/min / 1000 / 2^27].
static void send_motion(const cam_table_store_t *store, const cam_status_t *status)
{
    const int64_t mrpm_q27 = (int64_t)status->speed_q32 * store->machine->tick_hz * 1875;
    const struct camturn_spindle_t spindle = {
        .speed = cam_sat_i32((mrpm_q27 + (INT64_C(1) << 26)) >> 27),
        .angle = status->is_synced ? drawing_angle_q32(store->machine, status) : 0u,
    };
    const struct camturn_axis_u_t u = {
        .u_set = cam_sat_add(status->u_set_q6, 32) >> 6,
        .u_actual = status->u_actual_nm,
    };
    hal_can_frame_t frame;
    send(&frame, CAMTURN_SPINDLE_FRAME_ID,
         camturn_spindle_pack(frame.data, &spindle, sizeof frame.data));
    send(&frame, CAMTURN_AXIS_U_FRAME_ID, camturn_axis_u_pack(frame.data, &u, sizeof frame.data));
}

/// @return cycles of the interrupt in a unit of time, saturated; 0: not measured
static uint32_t tick_time(uint32_t cycles, uint32_t units_per_s, uint32_t most)
{
    const uint32_t cycles_hz = hal_load().cycles_hz;
    const uint64_t time = cycles_hz > 0u ? (uint64_t)cycles * units_per_s / cycles_hz : 0u;
    return time < most ? (uint32_t)time : most;
}

/// @return characters 6 part .. 6 part + 5 of the name, the first in the lowest byte
static uint64_t name_part(const char *name, uint32_t part)
{
    uint64_t chars = 0;
    const uint32_t from = part * name_chars;
    for (uint32_t i = name_chars; i > 0u; i--) {
        const uint32_t at = from + i - 1u;
        chars <<= 8;
        chars |= at < cam_table_name_size ? (uint8_t)name[at] : 0u;
    }
    return chars;
}

/// @return whether a start waits for a steady spindle, or was ended because there was none
static uint8_t start_wait(const cam_machine_t *machine, const cam_status_t *status)
{
    if (status->steady.waited_ticks > 0u) {
        return CAMTURN_DETAIL_START_WAIT_WAITS_CHOICE;
    }
    return machine->is_unsteady ? CAMTURN_DETAIL_START_WAIT_UNSTEADY_CHOICE
                                : CAMTURN_DETAIL_START_WAIT_NONE_CHOICE;
}

enum { most_u24 = (1 << 24) - 1 }; ///< largest number of the signals with 24 bits

/// @return v, or the nearest number that 24 bits with a sign hold
static int32_t in_i24(int32_t v)
{
    return cam_clamp_i32(v, -most_u24 / 2 - 1, most_u24 / 2);
}

static uint32_t in_u24(uint32_t v)
{
    return v < (uint32_t)most_u24 ? v : (uint32_t)most_u24;
}

static bool has_bit(uint32_t mask, uint32_t bit)
{
    return (mask >> bit & 1u) != 0u;
}

/// Fill in what the operator changed, the progress of the pass, command and level.
static void describe_work(struct camturn_detail_t *m, const cam_report_t *r,
                          const cam_machine_t *machine, const cam_status_t *status)
{
    enum { most_turns = (1 << 27) - 1, turn_bits = 25, per_s = 100000000 };
    const cam_params_t *params = &machine->params;
    const uint32_t n_passes = machine->has_table ? machine->table.n_passes : 0u;
    const uint32_t cycles = r->n_loads > 0u ? (uint32_t)(r->load_cycles / r->n_loads) : 0u;
    const cam_progress_t progress = cam_progress(machine);
    const cam_rights_status_t rights = cam_machine_rights(machine, status);
    m->override_of_feed = (uint32_t)params->feed_override_ppm;
    m->override_of_spindle = (uint32_t)params->spindle_override_ppm;
    m->trim_of_x = params->x_trim_nm;
    m->is_held = machine->is_held;
    m->parts_cut = machine->n_parts;
    m->pass = n_passes > 0u ? (uint8_t)(machine->pass + 1u) : 0u;
    m->passes = (uint8_t)n_passes;
    m->recorder_use = (uint8_t)machine->scope.use;
    m->recorder_phase = (uint8_t)machine->scope.phase;
    m->recorder_faults = machine->scope.ring.faults;
    m->has_end = progress.has_end;
    m->turns_left = (uint32_t)cam_clamp_i64(progress.left_q32 >> turn_bits, 0, most_turns);
    m->turns_whole = (uint32_t)cam_clamp_i64(progress.whole_q32 >> turn_bits, 0, most_turns);
    m->pass_speed = in_u24(progress.mrpm / 10u);
    m->tick_time_mean = (uint16_t)tick_time(cycles, (uint32_t)per_s, UINT16_MAX);
    m->commander = (uint8_t)rights.commander;
    m->take_overs = (uint8_t)rights.n_take_overs;
    m->command_losses = (uint8_t)rights.n_losses;
    m->level = (uint8_t)rights.level;
    m->level_left = (uint16_t)rights.level_left_s;
    m->acknowledge = (uint8_t)rights.button;
    m->acknowledge_left = (uint8_t)rights.button_left_s;
}

/// Fill in learning and the state of the parameters.
static void describe_values(struct camturn_detail_t *m, const cam_machine_t *machine)
{
    const cam_ilc_status_t learning = cam_machine_learning(machine);
    m->learn_phase = (uint8_t)learning.phase;
    m->learn_reason = (uint8_t)learning.reason;
    m->learn_harmonics = (uint8_t)learning.n_harmonics;
    m->learn_turns = learning.n_turns;
    m->learn_masked = learning.masked & (uint32_t)most_u24;
    m->learn_error = learning.error_nm;
    m->learn_k1 = in_i24(learning.k1_ns);
    m->learn_k2 = learning.k2_us2;
    m->learn_begin_error = in_u24(learning.begin_error_nm);
    m->learn_correction = learning.correction_nm;
    m->learn_ripple = in_u24(learning.ripple_nturn);
    m->learn_speed = learning.speed_mrpm;
    m->params_kept = (uint8_t)cam_machine_params_kept(machine);
    m->params_version = machine->version & 0xFFFFFu;
    m->params_checksum = machine->checksum;
}

/// Send a page of Detail. All its signals are set; the generated pack function takes those of the
/// page.
static void send_detail(uint32_t page, const cam_report_t *r, const cam_table_store_t *store,
                        const cam_status_t *status)
{
    const cam_machine_t *machine = store->machine;
    const cam_params_t *params = &machine->params;
    const cam_table_t *table = &machine->table;
    const bool has_table = machine->has_table;
    const hal_load_t load = hal_load();
    const int64_t x_nm =
        (int64_t)status->x_actual_nm - cam_offsets_origin_nm(&machine->offsets, params, hal_axis_x);
    const uint64_t chars =
        has_table && page >= page_name ? name_part(table->name, page - page_name) : 0u;
    struct camturn_detail_t m = {
        .page = (uint8_t)page,
        .following_error = in_i24(status->following_nm),
        .z = status->z_nm,
        .is_synced = status->is_synced,
        .is_retracted = status->is_retracted,
        .is_estop = (status->inputs & hal_in_estop) != 0u,
        .is_drive_ready = (status->inputs & hal_in_drive_ready) != 0u,
        .is_bus_lost = (status->inputs & hal_in_bus_lost) != 0u,
        .start_wait = start_wait(machine, status),
        .tick_rate = machine->tick_hz,
        .late_ticks = status->n_late,
        .tick_time_max = tick_time(load.max_cycles, 1000000000u, UINT32_MAX),
        .memory_errors = in_u24(load.n_corrected),
        // Table
        .table_generation = has_table ? store->generation & (uint32_t)most_u24 : 0u,
        .table_size = has_table ? table->image_size : 0u,
        .table_crc = has_table ? table->crc32 : 0u,
        .table_name_0 = chars,
        .table_name_1 = chars,
        .table_name_2 = chars,
        .table_name_3 = chars,
        .table_name_4 = chars,
        .table_name_5 = chars,
        // Jogging and homing
        .homed_u = has_bit(status->jog.homed, hal_axis_u),
        .homed_x = has_bit(status->jog.homed, hal_axis_x),
        .homed_z = has_bit(status->jog.homed, hal_axis_z),
        .on_home_u = (status->inputs & hal_in_home_u) != 0u,
        .on_home_x = (status->inputs & hal_in_home_x) != 0u,
        .on_home_z = (status->inputs & hal_in_home_z) != 0u,
        .hand_orders = (uint16_t)status->jog.serial,
        .x = cam_sat_i32(x_nm),
        .hand_phase = (uint8_t)status->jog.phase,
        .hand_end = (uint8_t)status->jog.end,
        .hand_axis = (uint8_t)status->jog.axis,
        .tool = (uint8_t)params->tool,
    };
    describe_values(&m, machine);
    describe_work(&m, r, machine, status);
    hal_can_frame_t frame;
    send(&frame, CAMTURN_DETAIL_FRAME_ID, camturn_detail_pack(frame.data, &m, sizeof frame.data));
}

void cam_report_send(cam_report_t *r, const cam_table_store_t *store, const cam_status_t *status)
{
    // clang-format off
    static const uint8_t pages[] = {
        page_load, page_rate, page_table, page_crc, page_name, 6, 7, 8, 9, 10,
        page_learning, 12, 13, 14, 15, page_hand, 17, page_changes, page_changes + 1,
        page_params, page_recorder, page_progress, page_pace, page_rights};
    // clang-format on
    const uint32_t period = store->machine->tick_hz / status_hz;
    r->load_cycles += hal_load().last_cycles; // the main loop runs after most interrupts
    r->n_loads++;
    if (status->tick - r->status_tick < period) {
        return;
    }
    // Adding the period keeps the average rate; a pause of more than a period restarts the count.
    r->status_tick += period;
    if (status->tick - r->status_tick >= period) {
        r->status_tick = status->tick;
    }
    r->i_page = r->i_page + 1u < sizeof pages ? r->i_page + 1u : 0u;
    send_state(r, store, status);
    send_motion(store, status);
    send_detail(page_motion, r, store, status);
    send_detail(pages[r->i_page], r, store, status);
    if (pages[r->i_page] == (uint8_t)page_pace) {
        r->load_cycles = 0;
        r->n_loads = 0;
    }
}
