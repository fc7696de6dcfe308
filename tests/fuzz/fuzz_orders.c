// SPDX-License-Identifier: Apache-2.0
#include "fuzz_orders.h"
#include "cam_machine.h" // cam_machine_jog, cam_machine_hold
#include "fuzz_rig.h"
#include "hal_host.h"
#include <string.h> // memset

/// The background check of the table costs as much as ten ticks.
enum { poll_ticks = 16 };

static uint32_t n_left; // [ticks] that this input may still take

bool fuzz_orders_has_time(void)
{
    return n_left > 0u;
}

void fuzz_ticks(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        if (i % (uint32_t)poll_ticks == 0u) {
            cam_machine_poll(&fuzz_rig.machine);
        }
        fuzz_rig_tick();
    }
}

void fuzz_let_pass(uint32_t n)
{
    const uint32_t now = n < n_left ? n : n_left;
    fuzz_ticks(now);
    n_left -= now;
}

/// Faults that are there or not, by their numbers.
static void (*const faults[])(bool) = {
    [fuzz_disturb_estop] = hal_host_fault_estop,
    [fuzz_disturb_drive] = hal_host_fault_drive,
    [fuzz_disturb_bus] = hal_host_fault_bus,
    [fuzz_disturb_stuck] = hal_host_fault_encoder_stuck,
    [fuzz_disturb_no_index] = hal_host_fault_index_dead,
};
enum { n_faults = sizeof faults / sizeof faults[0] };

static void mend(void)
{
    for (uint32_t i = 0; i < (uint32_t)n_faults; i++) {
        if (faults[i] != NULL) {
            faults[i](false);
        }
    }
    fuzz_rig.lathe.is_spindle_held = false;
    memset(fuzz_rig.lathe.is_held, 0, sizeof fuzz_rig.lathe.is_held);
    memset(fuzz_rig.lathe.error_nm, 0, sizeof fuzz_rig.lathe.error_nm);
    fuzz_rig.lathe.is_swing_held = false;
}

void fuzz_disturb(uint8_t which, uint16_t code)
{
    const int16_t value = (int16_t)code;
    const uint8_t what = which % 15u;
    fuzz_rig.judge.is_angle_doubtful = fuzz_rig.judge.is_angle_doubtful ||
                                       what == fuzz_disturb_counts || what == fuzz_disturb_stuck ||
                                       what == fuzz_disturb_speed;
    switch (what) {
    case fuzz_disturb_late:
        hal_host_fault_late(code % 400u);
        break;
    case fuzz_disturb_counts:
        hal_host_fault_counts(value);
        break;
    case fuzz_disturb_held:
        fuzz_rig.lathe.is_spindle_held = value < 0;
        break;
    case fuzz_disturb_speed:
        fuzz_rig.lathe.is_spindle_held = true;
        fuzz_rig.lathe.rpm = value * (2500.0 / 1092.0);
        break;
    case 9:
        hal_host.in.encoder.n_index += (uint32_t)(int32_t)value & 0xFFu;
        break;
    case 10:
        hal_host.in.encoder.index_counts = hal_host.in.encoder.index_counts + code - 0x8000u;
        break;
    case fuzz_disturb_button:
        hal_host_press(value < 0);
        break;
    case fuzz_disturb_press:
        fuzz_let_pass(fuzz_rig.judge.tick_hz / 16u);
        hal_host_press(true);
        fuzz_let_pass(fuzz_rig.judge.tick_hz / 10u);
        hal_host_press(false);
        fuzz_let_pass(fuzz_rig.judge.tick_hz / 16u);
        break;
    case fuzz_disturb_key:
        hal_host_turn_key(value < 0);
        break;
    case fuzz_disturb_mend:
        mend();
        break;
    default:
        faults[what](value < 0);
        break;
    }
}

void fuzz_command(uint8_t what, int32_t value)
{
    static cam_err_t (*const simple[16])(cam_machine_t *) = {
        [0] = cam_machine_enable,        [1] = cam_machine_disable, [2] = cam_machine_start,
        [3] = cam_machine_stop,          [4] = cam_machine_reset,   [5] = cam_machine_home,
        [6] = cam_machine_manual,        [11] = cam_machine_hold,   [12] = cam_machine_resume,
        [15] = cam_machine_stage_commit,
    };
    cam_machine_t *m = &fuzz_rig.machine;
    fuzz_rig.judge.n_alone = 0;
    const hal_axis_t axis = (hal_axis_t)(what / 16u % hal_n_axes);
    switch (what % 16u) {
    case 7:
        fuzz_try_verdict(cam_machine_jog(m, axis, value));
        break;
    case 8:
        fuzz_try_verdict(cam_machine_step(m, axis, value * 128));
        break;
    case 9:
        fuzz_try(cam_machine_home_axis(m, axis));
        break;
    case 10:
        fuzz_try_verdict(
            cam_machine_zero(m, axis, axis == hal_axis_x ? 92000000 + value * 256 : value * 256));
        break;
    case 13:
        cam_machine_keep_alive(m);
        break;
    case 14:
        cam_machine_stage_begin(m);
        break;
    default:
        fuzz_try(simple[what % 16u](m));
        break;
    }
}

void fuzz_usual(int32_t value)
{
    static const uint8_t commands[cam_n_states] = {
        [cam_state_off] = 0,         [cam_state_ready] = 2,       [cam_state_fault] = 4,
        [cam_state_manual] = 7,      [cam_state_cutting] = 11,    [cam_state_holding] = 12,
        [cam_state_engaging] = 3,    [cam_state_homing] = 13,     [cam_state_disengaging] = 13,
        [cam_state_rehearsing] = 13, [cam_state_identifying] = 3,
    };
    fuzz_command(commands[fuzz_rig_state()], value);
}

/// What is the same in every session, or what the target makes of the order.
static void carry_out(fuzz_order_t order, void (*other)(fuzz_order_t))
{
    switch (order.what % 8u) {
    case fuzz_order_pause:
        fuzz_let_pass(order.code % 600u + 1u);
        break;
    case fuzz_order_alive:
        cam_machine_keep_alive(&fuzz_rig.machine);
        fuzz_rig.judge.n_alone = 0;
        fuzz_let_pass(order.code % 200u + 1u);
        break;
    default:
        other(order);
        break;
    }
    fuzz_let_pass((order.what >> 3) % 4u); // a command is posted for the next tick
}

void fuzz_orders_play(fuzz_bytes_t *b, uint32_t most_ticks, void (*other)(fuzz_order_t))
{
    n_left = most_ticks;
    while (b->n > 0u && n_left > 0u) {
        fuzz_order_t order = {.what = fuzz_u8(b)};
        order.which = fuzz_u8(b);
        order.code = fuzz_u16(b);
        carry_out(order, other);
    }
    fuzz_let_pass(8);
}
