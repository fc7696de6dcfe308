// SPDX-License-Identifier: Apache-2.0
/// Port for Linux: start, tick, end and the functions of hal.h.
#include "hal/hal.h"
#include "lin_setup.h"
#include "lin_bus.h"
#include "lin_port.h"
#include "lin_tick.h"
#include <signal.h>    // sigaction
#include <stdatomic.h> // hand-over from the tick to main()
#include <stdio.h>     // fprintf
#include <stdlib.h>    // exit
#include <string.h>    // memset, strcmp
#include <unistd.h>    // _exit

enum { clock_hz = 10000000, clock_ns = 100, remote_node = 64, max_edges = 8 };
enum { exit_fault = 1, exit_usage = 2 };

/// The port. The tick writes `bus`, `commands`, `now_ns` and `inputs`, main() writes the rest.
static struct {
    lin_config_t config;
    hal_start_t start;
    lin_can_t remote;
    bool is_remote_shared; ///< commands and drives on one interface
    bool is_up;            ///< hal_init() succeeded: outputs must be made safe
    lin_can_t can;
    lin_bus_t bus;
    lin_commands_t commands;
    lin_stop_t stop;
    int64_t now_ns;
    uint32_t inputs;
    _Atomic uint32_t cause, not_ready; ///< lin_cause_pack()
    _Atomic bool is_mute;              ///< another node on the same bus has this node number
} port;

static volatile sig_atomic_t n_signals;

static void on_end(int signal)
{
    (void)signal;
    n_signals = n_signals + 1;
}

/// Switch enable off and stop each drive with one frame. Callable in any state of the program.
static void make_safe(void)
{
    static hal_can_frame_t frames[lin_bus_max_frames];
    static lin_bus_t bus;
    if (!port.is_up) {
        return;
    }
    lin_lines_safe();
    bus = port.bus; // a copy, because the tick may be using it
    port.commands.is_stopping = true;
    const uint32_t n = lin_bus_make(&bus, &port.commands, port.now_ns, frames);
    (void)lin_can_send(&port.can, frames, n);
}

static void on_crash(int signal)
{
    make_safe();
    (void)raise(signal); // SA_RESETHAND restored the default action
}

static void catch_signals(void)
{
    static const int ends[] = {SIGTERM, SIGINT, SIGHUP};
    static const int crashes[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_end;
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++) {
        (void)sigaction(ends[i], &action, NULL);
    }
    action.sa_handler = on_crash;
    action.sa_flags = (int)SA_RESETHAND;
    for (size_t i = 0; i < sizeof crashes / sizeof crashes[0]; i++) {
        (void)sigaction(crashes[i], &action, NULL);
    }
}

/// Open the machine bus and the socket for commands (0x600) and table transfer (0x680).
static bool open_can(common_error_t *e)
{
    uint32_t ids[lin_bus_max_ids];
    lin_can_filter_t filters[lin_can_max_filters];
    const uint32_t n = lin_bus_ids(&port.bus, ids);
    for (uint32_t i = 0; i < n; i++) {
        filters[i] = (lin_can_filter_t){.id = ids[i], .mask = 0x7FF};
    }
    const uint32_t node = (uint32_t)port.config.can.node;
    const lin_can_filter_t remote[] = {{0x600 + node, 0x7FF}, {0x680 + node, 0x7FF}};
    return lin_can_open(&port.can, port.config.can.interface, filters, n, port.config.can.is_fd,
                        e) &&
           lin_can_open(&port.remote, port.config.can.remote, remote, 2, false, e);
}

static void end_if_asked(const lin_options_t *options)
{
    if (options->print != NULL) {
        (void)fputs(options->print, stdout);
        exit(0);
    }
    if (options->is_check) {
        lin_check_warn(&port.config, hal_text);
        (void)printf("%s: the configuration is valid\n", options->config);
        exit(0);
    }
}

static bool bring_up(common_error_t *e)
{
    lin_options_t options;
    port.config = lin_config_defaults();
    if (!lin_options_read(&options, e) ||
        (options.print == NULL && !lin_check_load(&port.config, options.config, e))) {
        return false;
    }
    end_if_asked(&options);
    port.start = lin_halt_text_start(port.config.table_file);
    lin_params_open(port.config.params_file, e);
    if (e->text[0] != '\0') {
        hal_text(e->text); // not fatal: the controller uses its defaults
    }
    lin_blackbox_open(port.config.table_file, e);
    if (e->text[0] != '\0') {
        hal_text(e->text);
    }
    lin_bus_init(&port.bus, &port.config);
    port.is_remote_shared = strcmp(port.config.can.remote, port.config.can.interface) == 0;
    atomic_store(&port.is_mute, port.is_remote_shared);
    return lin_lines_open(&port.config, e) && open_can(e) &&
           lin_table_open(port.config.table_file, port.config.table_max_bytes, e) &&
           lin_thread_prepare(&port.config.thread, e);
}

int hal_init(void)
{
    common_error_t e;
    if (!bring_up(&e)) {
        (void)fprintf(stderr, "camturn-linux: %s\n", e.text);
        return -1;
    }
    port.is_up = true;
    lin_report_set_up(&port.config, port.can.n_room);
    catch_signals();
    return 0;
}

static void take_frame(void *user, const hal_can_frame_t *frame, int64_t ns)
{
    lin_bus_receive(user, frame, ns);
}

/// Read all inputs of the tick.
static void sense(int64_t now_ns)
{
    int64_t edge_ns;
    bool is_rising;
    lin_can_receive(&port.can, take_frame, &port.bus);
    for (int i = 0; i < max_edges && lin_lines_edge(&edge_ns, &is_rising); i++) {
        lin_encoder_edge(&port.bus.encoder, edge_ns, is_rising);
    }
    lin_bus_link(&port.bus, port.can.link);
    lin_bus_event(&port.bus, lin_can_take_event(&port.can));
    lin_bus_judge(&port.bus, now_ns);
    // Drives are ready if both lines and bus report ready. Bus loss comes from the bus only,
    // emergency stop from the lines only.
    const uint32_t lines = lin_lines_read();
    enum { others = 0xFF * hal_in_home_u };
    port.inputs = (lines & (hal_in_estop | others)) |
                  (lines & port.bus.inputs & hal_in_drive_ready) |
                  (port.bus.inputs & hal_in_bus_lost);
    port.now_ns = now_ns;
}

/// @return false after the last tick
static bool tick(int64_t now_ns)
{
    hal_can_frame_t frames[lin_bus_max_frames];
    sense(now_ns);
    const lin_stop_phase_t phase =
        lin_stop_step(&port.stop, (uint32_t)n_signals, port.commands.outputs,
                      lin_bus_is_at_rest(&port.bus), now_ns);
    port.inputs |= phase == lin_stop_retract ? (uint32_t)hal_in_estop : 0u;
    if (phase == lin_stop_run || phase == lin_stop_retract) {
        cam_isr();
    } else {
        hal_outputs_write_isr(0);
        port.commands.is_stopping = true;
    }
    const uint32_t n = lin_bus_make(&port.bus, &port.commands, now_ns, frames);
    (void)lin_can_send(&port.can, frames, n);
    atomic_store(&port.cause, lin_cause_pack(port.bus.cause));
    atomic_store(&port.not_ready, lin_cause_pack(port.bus.not_ready));
    atomic_store(&port.is_mute, port.bus.has_duplicate && port.is_remote_shared);
    return phase != lin_stop_over;
}

uint32_t hal_tick_hz(void)
{
    return (uint32_t)port.config.thread.tick_hz;
}

uint32_t hal_clock_hz(void)
{
    return clock_hz;
}

void hal_tick_start(void)
{
    common_error_t e;
    if (!lin_thread_start(&port.config.thread, tick, &e)) {
        (void)fprintf(stderr, "camturn-linux: %s\n", e.text);
        hal_halt("port: the tick cannot start");
    }
    lin_notify_ready();
}

/// Notify the service manager; once a second report overruns and rebind interfaces that came back.
static void supervise(void)
{
    static int64_t last_ns;
    const int64_t now_ns = lin_clock_now();
    lin_notify_alive(now_ns);
    if (now_ns - last_ns < lin_ns_per_s) {
        return;
    }
    last_ns = now_ns;
    lin_can_rebind(&port.can);
    lin_can_rebind(&port.remote);
    lin_report_overruns(lin_thread_overruns());
}

void hal_idle(void)
{
    static uint32_t last_cause, last_not_ready;
    const bool is_running = lin_thread_wait();
    lin_report_change(&last_cause, atomic_load(&port.cause), lin_cause_bus_text, &port.config);
    lin_report_change(&last_not_ready, atomic_load(&port.not_ready), lin_cause_drives_text,
                      &port.config);
    lin_report_lost_line();
    supervise();
    if (!is_running) {
        hal_text("port: ended by a signal");
        exit(0);
    }
}

void hal_halt(const char *why)
{
    make_safe();
    if (port.is_up) { // otherwise the reason is already printed
        lin_halt_text_halt(why);
        (void)fprintf(stderr, "camturn-linux: halted: %s\n", why);
    }
    _exit(port.is_up ? exit_fault : exit_usage);
}

hal_start_t hal_start(void)
{
    return port.start;
}

hal_load_t hal_load(void)
{
    return lin_thread_load();
}

void hal_text(const char *line)
{
    (void)fprintf(stderr, "%s\n", line);
}

/// The firmware is node 64; identifiers are translated to the configured number. While another node
/// has that number, frames are ignored: they may be for the other node.
bool hal_can_read(hal_can_frame_t *frame)
{
    if (!lin_can_receive_one(&port.remote, frame) || atomic_load(&port.is_mute)) {
        return false;
    }
    frame->id = frame->id - (uint32_t)port.config.can.node + remote_node;
    return true;
}

bool hal_can_write(const hal_can_frame_t *frame)
{
    if (atomic_load(&port.is_mute)) {
        return false;
    }
    hal_can_frame_t own = *frame;
    own.id = frame->id + (uint32_t)port.config.can.node - remote_node;
    return lin_can_send(&port.remote, &own, 1) == 1u;
}

uint32_t hal_clock_isr(void)
{
    return (uint32_t)(port.now_ns / clock_ns);
}

void hal_encoder_read_isr(hal_encoder_t *reading)
{
    *reading = lin_encoder_at(&port.bus.encoder, port.now_ns);
}

int32_t hal_axis_read_nm_isr(hal_axis_t axis)
{
    return lin_bus_actual_nm(&port.bus, axis, &port.commands);
}

/// U is measured if it has a drive; otherwise its position is the set-point.
bool hal_measures_u(void)
{
    return port.bus.drive[hal_axis_u].node.id != 0u;
}

hal_operator_t hal_operator(void)
{
    return lin_operator(&port.config);
}

/// The resolution is the drive's unit; 0 without a drive.
hal_axis_scale_t hal_axis_scale(hal_axis_t axis)
{
    const uint32_t unit_pm = lin_drive_unit_pm(&port.bus.drive[axis]);
    return (hal_axis_scale_t){.command_pm = unit_pm, .measured_pm = unit_pm};
}

uint32_t hal_inputs_read_isr(void)
{
    return port.inputs;
}

void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint)
{
    port.commands.axis[axis] = *setpoint;
}

void hal_spindle_write_isr(int32_t speed_mrpm)
{
    port.commands.spindle_mrpm = speed_mrpm;
}

void hal_outputs_write_isr(uint32_t bits)
{
    port.commands.outputs = bits;
    lin_lines_write(bits);
}
