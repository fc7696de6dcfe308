// SPDX-License-Identifier: Apache-2.0
// The compiled module is linked with LinuxCNC; therefore the line `license` declares it GPL.
component camturn "turns and grinds non-circular sections from tables of the spindle's angle";
description """
Moves a fast tool axis U by a camturn table: set-points follow the angle of the spindle, with dead-time compensation and
feed-forward for the drive. Parameters of the firmware appear as HAL parameters of the same
name with hyphens, for example \\fBcamturn.lead-ns\\fR. Set-up: hal/linuxcnc/README.md.
""";
pin in s32 spindle_rawcounts "counts of the spindle encoder, never reset";
pin in s32 spindle_counts "counts since the last index edge with index-enable set";
pin io bit index_enable "as of HAL encoders: set to wait for an index edge, which resets it";
pin in bit index_is_shared "LinuxCNC counts turns with the same encoder (G33): wait for one edge only after enable";
pin in bit enable "rising: acknowledge a fault, home U if that is needed, enable, find the index; falling: retract, disable";
pin in bit start "rising: cut one pass (M64); falling: end it (M65)";
pin in bit estop_ok "true: the emergency-stop chain is closed";
pin in bit drive_ready "true: the drives can follow";
pin in bit reload_table "rising: read the file of the table again, in off and ready";
pin out bit reloading "true until that is done or refused";
pin in bit record "rising: record at the rate of the tick; falling: end it and write it to a file";
pin out bit recording "true until the file is written";
pin in bit acknowledge "true while the acknowledge button at the machine is pressed; required after power-on, emergency stop, fault";
pin in bit u_home_switch "U is on its home switch, with u-home 2 and 3";
pin in bit u_index "U is on the index mark of its scale, for 0.4 ms or longer, with u-home 3";
pin in bit u_limit_low "U is on the limit switch of its lower end, where U takes forces; from a normally closed contact by its -not pin";
pin in bit u_limit_high ".. upper end";
pin in float u_fb "measured U [mm], used with measures_u=1";
pin in float x_fb "measured X [mm radius], used with measures_x=1";
pin in float z_fb "measured Z [mm, height of the drawing], used with measures_z=1";
pin in float x_trim "trim of X [mm radius], for the wear of the tool; added to x-trim-nm, ramped";
pin in float phase "rotates the shape on the part [degree]; added to phase-udeg, ramped";
pin out float u_cmd "set-point of U [mm], positive towards the axis";
pin out float u_vel "velocity of U [mm/s], without feed-forward: FF1 of pid";
pin out float u_acc "acceleration of U [mm/s2], without feed-forward: FF2 of pid";
pin out float u_force "force of U [N], positive where it drives U up; 0 while the drives are not enabled and without u_force_quantum_un";
pin out float x_cmd "set-point of X [mm radius]";
pin out float z_cmd "set-point of Z [mm]";
pin out float spindle_speed_cmd "set-point of the spindle [r/min], signed";
pin out float u "measured U [mm], from its home";
pin out bit homed "the position of U is known: homed, or u-home is 0";
pin out bit drive_enable "the drives are enabled and hold their axes";
pin out bit fault "a fault is latched";
pin out bit ready "the angle is known, start is accepted";
pin out bit in_cut "the tool cuts at full amplitude (M66 P0 L3)";
pin out u32 state_number "0 off 1 homing 2 ready 3 engaging 4 cutting 5 disengaging 6 fault 7 rehearsing 8 identifying 9 manual 10 holding";
pin out u32 fault_mask "latched faults, a mask in the order of firmware/FAULTS.md";
pin out s32 error_number "last refusal, 0: none (firmware/base/cam_err.h)";
pin out float angle "angle of the spindle [turn], unwrapped";
pin out float spindle_speed "speed of the spindle [r/min]";
pin out float following_error "measured U minus its commanded position [mm]";
pin out u32 late_ticks "late ticks";
pin out float learned_error "rms error of U in the last turn used for learning [mm]";
param r s32 tick_hz_used "rate of the tick [Hz]";
function update "one tick: in the fast thread, after the encoder's function";
function poll "the main loop: in a thread of 1 ms or slower, or after update in the same thread";
modparam dummy table """
\\fBtable=\\fRabsolute path of a .camtab file. Without a valid one the component does not load.""";
modparam dummy tick_hz """\\fBtick_hz=\\fRrate of the thread of \\fBcamturn.update\\fR [Hz], 500 .. 100 000.""";
modparam dummy measures_u """\\fBmeasures_u=1\\fR: u-fb is a measurement; enables learning of the drive's errors.""";
modparam dummy measures_x """\\fBmeasures_x=1\\fR: x-fb is a measurement.""";
modparam dummy measures_z """\\fBmeasures_z=0\\fR: Z is not measured; camturn itself feeds it.""";
modparam dummy u_force_quantum_un """\\fBu_force_quantum_un=\\fRsmallest change of the force of U [uN], 1 .. 1 000 000: U takes forces by u-force, camturn closes its position loop. 0: U takes positions. Needs measures_u=1.""";
modparam dummy u_force_latency_ns """\\fBu_force_latency_ns=\\fRfrom the latch of U's scale to the change of the force [ns], 0 .. 10 000 000.""";
modparam dummy recordings """\\fBrecordings=\\fRabsolute path of the start of the names of recordings: NAME-1.csv, .. Without it nothing is recorded.""";
modparam dummy waive_acknowledge """\\fBwaive_acknowledge=1\\fR: the pin acknowledge is not needed, because the machine has its own button that must be pressed before its drives get power, or is simulated.""";
modparam dummy nominal_time """\\fBnominal_time=1\\fR: time is counted in ticks, for simulation without real time.""";
option singleton yes;
option extra_setup yes;
option extra_cleanup yes;
license "GPL";
author "the founders of camturn";
include "lcn_port.h";
include "lcn_reload.h";
include "lcn_slow.h";
;;
#include <limits.h> // INT_MAX

static char *table = "";
RTAPI_MP_STRING(table, "absolute path of a .camtab file");
static char *recordings = "";
RTAPI_MP_STRING(recordings, "start of the names of recordings");
static int tick_hz = 1000;
RTAPI_MP_INT(tick_hz, "rate of the thread of camturn.update [Hz]");
static int measures_u = 0;
RTAPI_MP_INT(measures_u, "1: u-fb is a measurement");
static int measures_x = 0;
RTAPI_MP_INT(measures_x, "1: x-fb is a measurement");
static int measures_z = 1;
RTAPI_MP_INT(measures_z, "1: z-fb is a measurement");
static int u_force_quantum_un = 0;
RTAPI_MP_INT(u_force_quantum_un, "smallest change of the force of U [uN]; 0: U takes positions");
static int u_force_latency_ns = 0;
RTAPI_MP_INT(u_force_latency_ns, "from the latch of U's scale to the change of the force [ns]");
static int waive_acknowledge = 0;
RTAPI_MP_INT(waive_acknowledge, "1: the pin acknowledge is not needed");
static int nominal_time = 0;
RTAPI_MP_INT(nominal_time, "1: time is counted in ticks");

static hal_s32_t *values; // the parameters, in HAL's memory

static void print_line(const char *line)
{
    rtapi_print_msg(RTAPI_MSG_ERR, "camturn: %s\n", line);
}

// Convert to nanometres, clamped to the range.
static int32_t nm_of_mm(double mm)
{
    const double nm = mm * 1e6;
    if (!(nm > -INT_MAX)) {
        return -INT_MAX; // also for NaN
    }
    return nm < INT_MAX ? (int32_t)(nm < 0.0 ? nm - 0.5 : nm + 0.5) : INT_MAX;
}

// Check the parameters of a U that takes forces; a refusal is printed.
static int check_force(void)
{
    if (u_force_quantum_un < 0 || u_force_quantum_un > 1000000) {
        rtapi_print_msg(RTAPI_MSG_ERR,
                        "camturn: u_force_quantum_un=%d: out of range; give 0 .. 1000000\n",
                        u_force_quantum_un);
    } else if (u_force_latency_ns < 0 || u_force_latency_ns > 10000000) {
        rtapi_print_msg(RTAPI_MSG_ERR,
                        "camturn: u_force_latency_ns=%d: out of range; give 0 .. 10000000\n",
                        u_force_latency_ns);
    } else if (u_force_quantum_un > 0 && measures_u == 0) {
        rtapi_print_msg(RTAPI_MSG_ERR,
                        "camturn: u_force_quantum_un=%d: needs the scale of U; connect u-fb and "
                        "give measures_u=1\n",
                        u_force_quantum_un);
    } else {
        return 0;
    }
    return -EINVAL;
}

static int make_params(const char *prefix)
{
    values = hal_malloc(lcn_slow_n_params() * sizeof *values);
    int err = values == NULL ? -ENOMEM : 0;
    for (int i = 0; err == 0 && i < lcn_slow_n_params(); i++) {
        char name[HAL_NAME_LEN + 1];
        rtapi_snprintf(name, sizeof name, "%s", lcn_slow_param_name(i));
        for (char *c = name; *c != '\0'; c++) {
            *c = *c == '_' ? '-' : *c;
        }
        values[i] = lcn_slow_default(i);
        err = hal_param_s32_newf(HAL_RW, &values[i], comp_id, "%s.%s", prefix, name);
    }
    return err;
}

EXTRA_SETUP()
{
    (void)extra_arg;
    lcn_port_print = print_line;
    if (tick_hz < 500 || tick_hz > 100000) {
        rtapi_print_msg(RTAPI_MSG_ERR, "camturn: tick_hz=%d: out of range; give 500 .. 100000\n",
                        tick_hz);
        return -EINVAL;
    }
    if (check_force() != 0) {
        return -EINVAL;
    }
    const lcn_setup_t setup = {
        .tick_hz = (uint32_t)tick_hz,
        .is_measured = {measures_u != 0, measures_x != 0, measures_z != 0},
        .force_quantum_un = (uint32_t)u_force_quantum_un,
        .force_latency_ns = (uint32_t)u_force_latency_ns,
        .is_waived = waive_acknowledge != 0,
        .is_nominal = nominal_time != 0,
    };
    lcn_port_init(&setup);
    lcn_slow_init(setup.tick_hz, recordings);
    tick_hz_used = tick_hz;
    if (!lcn_slow_load(table)) {
        return -EINVAL;
    }
    const int err = make_params(prefix);
    return err != 0 || lcn_reload_begin(table) ? err : -EAGAIN;
}

EXTRA_CLEANUP()
{
    lcn_reload_end();
}

FUNCTION(update)
{
    const lcn_in_t in = {
        .now_ns = rtapi_get_time(),
        .period_ns = (int32_t)period,
        .spindle = {spindle_rawcounts, spindle_counts, index_enable, index_is_shared},
        .actual_nm = {nm_of_mm(u_fb), nm_of_mm(x_fb), nm_of_mm(z_fb)},
        .is_estop = !estop_ok,
        .is_drive_ready = drive_ready,
        .is_acknowledged = acknowledge,
        .is_u_on_home = u_home_switch,
        .is_u_on_index = u_index,
        .is_u_at_low = u_limit_low,
        .is_u_at_high = u_limit_high,
    };
    lcn_out_t out;
    lcn_port_tick(&in, lcn_slow_turn_counts(), &out);
    if (out.arms_index) {
        index_enable = 1;
    }
    u_cmd = out.pos_nm[lcn_u] * 1e-6;
    u_vel = out.vel_q10[lcn_u] * (tick_hz * 1e-6 / 1024.0);
    u_acc = out.acc_q10[lcn_u] * (1e-6 * tick_hz * tick_hz / 1024.0);
    u_force = out.force_q6 * (1e-3 / 64);
    x_cmd = out.pos_nm[lcn_x] * 1e-6;
    z_cmd = out.pos_nm[lcn_z] * 1e-6;
    spindle_speed_cmd = out.spindle_mrpm * 1e-3;
    drive_enable = out.is_enabled;
    fault = out.is_fault;
    in_cut = out.is_in_cut;
}

FUNCTION(poll)
{
    const lcn_commands_t commands = {
        .enables = enable, .starts = start, .reloads = reload_table, .records = record,
        .x_trim_nm = nm_of_mm(x_trim), .phase_udeg = nm_of_mm(phase)}; // both are millionths
    lcn_slow_poll(values, &commands, (int32_t)period);
    const lcn_status_t now = lcn_slow_status();
    error_number = now.error;
    state_number = now.state;
    u = now.u_nm * 1e-6;
    homed = now.is_homed;
    ready = now.is_ready;
    reloading = now.is_reloading;
    recording = now.is_recording;
    fault_mask = now.faults;
    angle = now.turns;
    spindle_speed = now.rpm;
    following_error = now.following_nm * 1e-6;
    late_ticks = now.n_late;
    learned_error = now.learned_nm * 1e-6;
}
