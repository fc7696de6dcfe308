// SPDX-License-Identifier: Apache-2.0
// A session: commands, parameters, senses and faults in any order, as the operator, the machine and
// bad luck would give them. The input is a start and orders of four bytes each, so that what the
// mutator adds or takes away leaves the others what they were.
#include "fuzz_bytes.h"
#include "fuzz_expect.h"
#include "fuzz_mutate.h"
#include "fuzz_orders.h"
#include "fuzz_rig.h"
#include "hal_host.h" // hal_host

enum { head_bytes = 4, most_ticks = 4000 };

/// Parameters that an operator changes. Gains of the feed-forward and what is learned are not
/// among them: only where they are 0 is what U is told the set-point that is judged.
static const cam_param_id_t ids[] = {
    cam_param_x_trim_nm,
    cam_param_feed_override_ppm,
    cam_param_spindle_override_ppm,
    cam_param_phase_udeg,
    cam_param_amplitude_ppm,
    cam_param_x_datum_nm,
    cam_param_z_datum_nm,
    cam_param_tool,
    cam_param_tool_1_x_nm,
    cam_param_tool_2_z_nm,
    cam_param_spindle_mrpm,
    cam_param_feed_nm,
    cam_param_rehearse_turns,
    cam_param_homing_required,
    cam_param_u_home,
    cam_param_x_home,
    cam_param_z_home,
    cam_param_x_jog_um_per_s,
    cam_param_u_home_nm,
    cam_param_switch_1_per_turn,
    cam_param_switch_3_per_turn,
    cam_param_x_home_nm,
    cam_param_x_home_travel_nm,
    cam_param_x_low_nm,
    cam_param_x_high_nm,
    cam_param_z_low_nm,
    cam_param_z_high_nm,
    cam_param_u_jog_um_per_s,
    cam_param_z_jog_um_per_s,
    cam_param_u_home_um_per_s,
    cam_param_u_home_sense,
    cam_param_x_home_sense,
    cam_param_z_home_sense,
    cam_param_x_home_um_per_s,
    cam_param_z_home_um_per_s,
    cam_param_u_retract_nm,
    cam_param_x_clearance_nm,
    cam_param_engage_turns,
    cam_param_disengage_turns,
    cam_param_feed_ramp_turns,
    cam_param_z_is_measured,
    cam_param_lead_ns,
    cam_param_phase_rate_udeg_per_s,
    cam_param_pass,
    cam_param_amplitude_rate_ppm_per_s,
    cam_param_x_trim_rate_nm_per_s,
    cam_param_x_trim_limit_nm,
    cam_param_spindle_override_rate_ppm_per_s,
    cam_param_index_offset_udeg,
    cam_param_index_tolerance_counts,
    cam_param_jump_window_counts,
    cam_param_stopped_mrpm,
    cam_param_stopped_ms,
    cam_param_following_limit_nm,
    cam_param_late_percent,
    cam_param_z_margin_nm,
    cam_param_observer_bandwidth_mHz,
    cam_param_swing_lag_ns,
    cam_param_swing_range_mdeg,
    cam_param_spindle_lag_us,
};
enum { n_ids = sizeof ids / sizeof ids[0] };

/// Parameters by which an axis is told more than its set-point, or reads far ahead: they are set in
/// some sessions, in which only what the controller supervises is judged.
static const cam_param_id_t wild_ids[] = {
    cam_param_k1_ns,           cam_param_k2_us2,          cam_param_xz_lag_ns,
    cam_param_u_jerk_m_per_s3, cam_param_x_jerk_m_per_s3, cam_param_z_jerk_m_per_s3,
    cam_param_lead_ns,         cam_param_u_stroke_nm,
};
enum { n_wild_ids = sizeof wild_ids / sizeof wild_ids[0] };

static cam_param_id_t id_of(uint8_t which)
{
    const bool is_wild = fuzz_rig.judge.is_wild && which >= 128u;
    return is_wild ? wild_ids[which % n_wild_ids] : ids[which % n_ids];
}

/// @return a value that people, or a hand that slips, give a parameter
static int32_t value_of(cam_param_id_t id, uint16_t code)
{
    const cam_param_info_t *info = cam_param_info(id);
    const int64_t range = (int64_t)info->max - info->min;
    const int64_t fine = (int16_t)(uint16_t)(code << 2);
    switch (code >> 14) {
    case 0: // near what it was at the start
        return (int32_t)(info->def + fine * (range / 64 < 2000000 ? range / 64 : 2000000) / 32768);
    case 1: // anywhere in its range
        return (int32_t)(info->min + (range * (code & 0x3FFFu)) / 0x3FFF);
    case 2: // at an end of it, or a little beyond
        return (int32_t)((code & 1u) != 0u ? info->max - (fine >> 10) : info->min + (fine >> 10));
    default: // a small number
        return (int32_t)(fine / 4);
    }
}

static void set_parameter(uint8_t which, uint16_t code)
{
    const cam_param_id_t id = id_of(which);
    fuzz_try(cam_machine_set_param(&fuzz_rig.machine, id, value_of(id, code)));
}

static void stage(uint8_t which, uint16_t code)
{
    const cam_param_id_t id = id_of(which);
    fuzz_try(cam_machine_stage(&fuzz_rig.machine, id, value_of(id, code)));
}

/// What is sensed of an axis, of its switch and of its index.
static void sense(uint8_t what, int16_t value)
{
    const uint32_t axis = what % hal_n_axes;
    switch (what / hal_n_axes % 4u) {
    case 0:
        fuzz_rig.lathe.is_held[axis] = value < 0;
        break;
    case 1:
        fuzz_rig.lathe.error_nm[axis] = value * 16;
        break;
    case 2:
        fuzz_rig.lathe.home[axis].side = value > 0 ? 1 : -1;
        fuzz_rig.lathe.home[axis].edge_nm = hal_host.in.axis_nm[axis] / 1000 * 1000 + value * 64;
        fuzz_rig.lathe.home[axis].pitch_nm = (what & 0x80u) != 0u ? 200000 : 0;
        break;
    default:
        fuzz_rig.lathe.is_swing_held = value < 0;
        break;
    }
}

static void carry_out(fuzz_order_t order)
{
    const uint8_t which = order.which;
    const uint16_t code = order.code;
    const int16_t value = (int16_t)code;
    switch (order.what % 8u) {
    case 1:
        fuzz_usual(value);
        break;
    case 2:
        fuzz_command(which, value);
        break;
    case 3:
        set_parameter(which, code);
        break;
    case 4:
        fuzz_disturb(which, code);
        break;
    case 5:
        sense(which, value);
        break;
    default:
        stage(which, code);
        break;
    }
}

static void start(uint8_t how, bool has_button)
{
    static const uint32_t rates[] = {1000, 2000, 5000, 20000};
    static const cam_state_t states[] = {cam_state_off, cam_state_ready, cam_state_cutting,
                                         cam_state_manual};
    fuzz_rig_start((fuzz_start_t){.tick_hz = rates[how % 4u],
                                  .part = how / 16u % fuzz_rig_n_parts,
                                  .has_button = has_button,
                                  .state = states[how / 4u % 4u]});
    fuzz_try(cam_machine_set_param(&fuzz_rig.machine, cam_param_x_high_nm, 50000000));
    fuzz_try(cam_machine_set_param(&fuzz_rig.machine, cam_param_x_low_nm, 45900000));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes_t b = {.at = data, .n = size};
    if (size < (size_t)head_bytes) {
        return -1;
    }
    const uint8_t how = fuzz_u8(&b);
    start(how, fuzz_u8(&b) == 1u);
    fuzz_rig.judge.is_wild = fuzz_u8(&b) == 1u;
    (void)fuzz_u8(&b);
    fuzz_orders_play(&b, most_ticks, carry_out);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
    return fuzz_mutate_orders(data, size, max_size, seed, head_bytes, fuzz_order_bytes);
}
