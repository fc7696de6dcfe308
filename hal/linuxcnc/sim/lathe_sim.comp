// SPDX-License-Identifier: Apache-2.0
component lathe_sim "a simulated spindle with encoder and fast tool axis, to try camturn without a machine";
pin in float spindle_speed_cmd "set-point [r/min], as of spindle.0.speed-out";
pin in float u_cmd "set-point of U [mm]";
pin in bit drive_enable;
pin out s32 rawcounts "counts of the encoder, never reset";
pin out s32 counts "counts since the last index edge with index-enable set";
pin io bit index_enable;
pin out float revs "turns since then, for spindle.0.revs";
pin out float speed_rps "speed [turns/s], for spindle.0.speed-in";
pin out bit at_speed;
pin out float u_fb "U [mm]";
pin out bit u_home_switch "U is at or beyond u-switch";
param rw s32 counts_per_turn = 10000;
param rw float run_up_s = 0.2 "time constant of the spindle's speed [s]";
param rw float ripple = 0.002 "of the speed, twice per turn";
param rw float u_hz = 300 "natural frequency of U";
param rw float u_damping = 0.7;
function _;
param rw float u_switch = -0.5 "position of the home switch of U [mm]";
variable double turns;
variable double index_turns;
variable double rps;
variable double u_mm;
variable double u_mm_per_s;
option singleton yes;
license "GPL";
author "the founders of camturn";
;;
#include <rtapi_math.h>

enum { steps = 8 }; // integration steps of U per period

static const double two_pi = 6.283185307179586;

static void move_u(struct __comp_state *__comp_inst, double command_mm, double dt_s)
{
    const double w = two_pi * u_hz;
    for (int i = 0; i < steps; i++) {
        const double pull = w * w * (command_mm - u_mm) - 2.0 * u_damping * w * u_mm_per_s;
        u_mm_per_s += pull * dt_s / steps;
        u_mm += u_mm_per_s * dt_s / steps;
    }
}

FUNCTION(_)
{
    const double dt_s = period * 1e-9;
    const double before = floor(turns);
    rps += (spindle_speed_cmd / 60.0 - rps) * dt_s / (run_up_s + dt_s);
    speed_rps = rps * (1.0 + ripple * sin(2.0 * two_pi * turns));
    turns += speed_rps * dt_s;
    if (floor(turns) != before && index_enable) {
        index_turns = rps < 0.0 ? before : floor(turns);
        index_enable = 0;
    }
    rawcounts = (rtapi_s32)(rtapi_s64)floor(turns * counts_per_turn);
    counts = rawcounts - (rtapi_s32)(rtapi_s64)floor(index_turns * counts_per_turn + 0.5);
    revs = turns - index_turns;
    at_speed = fabs(rps * 60.0 - spindle_speed_cmd) <= 0.01 * fabs(spindle_speed_cmd);
    move_u(__comp_inst, drive_enable ? u_cmd : u_mm, dt_s);
    u_fb = u_mm;
    u_home_switch = u_mm <= u_switch;
}
