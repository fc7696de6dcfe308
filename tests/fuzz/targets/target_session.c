// SPDX-License-Identifier: Apache-2.0
// A session: commands, parameters, senses and faults in any order, as the operator, the machine and
// bad luck would give them. The input is a start and orders of four bytes each, so that what the
// mutator adds or takes away leaves the others what they were.
#include "cam_machine.h"
#include "fuzz_bytes.h"
#include "fuzz_expect.h"
#include "fuzz_mutate.h"
#include "fuzz_orders.h"
#include "fuzz_rig.h"
#include "hal_host.h" // hal_host

enum { head_bytes = 4, most_ticks = 4000 };

#define PARAMETER(name) cam_param_##name,

/// Parameters that an operator changes. Gains of the feed-forward and learned values are not among
/// them: U is commanded the set-point, which is judged, only where they are 0.
// clang-format off
#define OPERATORS(X) \
    X(x_trim_nm) X(feed_override_ppm) X(spindle_override_ppm) X(phase_udeg) X(amplitude_ppm) \
    X(x_datum_nm) X(z_datum_nm) X(tool) X(tool_1_x_nm) X(tool_2_z_nm) X(spindle_mrpm) X(feed_nm) \
    X(rehearse_turns) X(homing_required) X(u_home) X(x_home) X(z_home) X(x_jog_um_per_s) \
    X(u_home_nm) X(x_home_nm) X(x_home_travel_nm) \
    X(x_low_nm) X(x_high_nm) X(z_low_nm) X(z_high_nm) X(u_jog_um_per_s) X(z_jog_um_per_s) \
    X(u_home_um_per_s) X(u_home_sense) X(x_home_sense) X(z_home_sense) X(x_home_um_per_s) \
    X(z_home_um_per_s) X(u_retract_nm) X(x_clearance_nm) X(engage_turns) X(disengage_turns) \
    X(feed_ramp_turns) X(z_is_measured) X(lead_ns) X(phase_rate_udeg_per_s) X(pass) \
    X(amplitude_rate_ppm_per_s) X(x_trim_rate_nm_per_s) X(x_trim_limit_nm) \
    X(spindle_override_rate_ppm_per_s) X(index_offset_udeg) X(index_tolerance_counts) \
    X(jump_window_counts) X(stopped_mrpm) X(stopped_ms) X(following_limit_nm) X(late_percent) \
    X(z_margin_nm) X(observer_bandwidth_mHz) X(swing_lag_ns) X(swing_range_mdeg) \
    X(spindle_lag_us)
// clang-format on
static const cam_param_id_t ids[] = {OPERATORS(PARAMETER)};
enum { n_ids = sizeof ids / sizeof ids[0] };

/// Parameters that add to the set-point in the command of an axis, or that read far ahead: they are
/// set in some sessions, in which only the quantities that the controller supervises are judged.
// clang-format off
#define WILD(X) \
    X(k1_ns) X(k2_us2) X(xz_lag_ns) X(u_jerk_m_per_s3) X(x_jerk_m_per_s3) X(z_jerk_m_per_s3) \
    X(lead_ns) X(u_stroke_nm)
// clang-format on
static const cam_param_id_t wild_ids[] = {WILD(PARAMETER)};
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

/// In off, where X is free, move it clear of the part; in ready let U play a wave.
static void excite(int32_t place_nm)
{
    static int32_t wave_nm[200];
    const uint8_t *bytes = (const uint8_t *)wave_nm;
    for (int32_t i = 0; i < 200; i++) {
        wave_nm[i] = i < 100 ? 100 * i : 100 * (200 - i);
    }
    cam_machine_t *m = &fuzz_rig.machine;
    hal_host.in.axis_nm[hal_axis_x] += 100000000;
    fuzz_let_pass(16);
    if (cam_machine_wave_begin(m, sizeof wave_nm) == cam_ok) {
        fuzz_try(cam_machine_wave_block(m, 0, bytes, sizeof wave_nm));
        fuzz_try(cam_machine_wave_end(m, cam_crc32(0, bytes, sizeof wave_nm)));
        fuzz_try(cam_machine_scope_set(m, cam_scope_field_place_nm, place_nm));
        fuzz_try_verdict(cam_machine_excite(m, 3, 100));
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
        if (which == 254u) {
            excite(value * 32);
        } else {
            stage(which, code);
        }
        break;
    }
}

static void start(uint8_t how, bool has_button, bool takes_force)
{
    fuzz_start_t from = fuzz_rig_start_of(how);
    from.part = how / 16u % fuzz_rig_n_parts;
    from.has_button = has_button;
    from.takes_force = takes_force;
    fuzz_rig_start(from);
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
    const bool has_button = fuzz_u8(&b) == 1u;
    const bool is_wild = fuzz_u8(&b) == 1u;
    start(how, has_button, fuzz_u8(&b) == 1u);
    fuzz_rig.judge.is_wild = is_wild;
    fuzz_orders_play(&b, most_ticks, carry_out);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
    return fuzz_mutate_orders(data, size, max_size, seed, head_bytes, fuzz_order_bytes);
}
