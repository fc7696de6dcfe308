// SPDX-License-Identifier: Apache-2.0
/// lin_port: what the port has of Linux: command line, clock, real-time thread, CAN sockets, lines,
/// service manager, and its messages.
#ifndef LIN_PORT_H
#define LIN_PORT_H

#include "common_error.h" // common_error_t
#include "hal/hal.h"      // hal_load_t, hal_can_frame_t
#include "lin_bus.h"      // lin_loss_t, lin_cause_t
#include "lin_setup.h"    // lin_thread_config_t, lin_config_t
#include <stdatomic.h>    // is_gone
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t
#include <stdint.h>       // int64_t, uint32_t
#include <time.h>         // clock_gettime

// The command line, read from /proc/self/cmdline, because the common main() has no arguments.

typedef struct {
    char config[512];  ///< path from --config, else from CAMTURN_CONFIG
    const char *print; ///< --help or --version: text to print before exiting, else NULL
    bool is_check;     ///< check the configuration and exit
} lin_options_t;

/// @return false and *e: unknown option, or no configuration given
bool lin_options_read(lin_options_t *o, common_error_t *e);

// The clock of the port, CLOCK_MONOTONIC in ns.

enum { lin_ns_per_s = 1000000000 };

static inline int64_t lin_clock_of(const struct timespec *t)
{
    return (int64_t)t->tv_sec * lin_ns_per_s + t->tv_nsec;
}

static inline int64_t lin_clock_read(clockid_t clock)
{
    struct timespec t;
    (void)clock_gettime(clock, &t);
    return lin_clock_of(&t);
}

/// @return [ns] CLOCK_MONOTONIC now
static inline int64_t lin_clock_now(void)
{
    return lin_clock_read(CLOCK_MONOTONIC);
}

// Calls the tick at a constant rate from a real-time thread. Ticks are at multiples of the period
// within each second of CLOCK_MONOTONIC. If a tick ends after the next one is due (overrun), the
// missed ticks are skipped and not made up. Tick and main() run on one CPU and the tick has the
// higher priority, so it preempts main() like an interrupt. Without permission for real-time
// priority the port still runs, with a warning.

/// Runs one tick. @param now_ns  CLOCK_MONOTONIC at wake-up. @return false after the last tick
typedef bool lin_thread_tick_t(int64_t now_ns);

/// Lock memory and move to the CPU. Missing permissions are reported by hal_text(), with a remedy.
/// @return false and *e if the CPU does not exist. Context: main(), before the tick.
bool lin_thread_prepare(const lin_thread_config_t *config, common_error_t *e);

/// Start the thread, with SCHED_FIFO if permitted. @return false and *e on error. Context: main().
bool lin_thread_start(const lin_thread_config_t *config, lin_thread_tick_t *tick,
                      common_error_t *e);

/// Wait for the end of a tick since the last call. @return false after the last tick. Context:
/// main().
bool lin_thread_wait(void);

/// @return duration of ticks in ns. Context: main().
hal_load_t lin_thread_load(void);

/// @return missed ticks since the start, wraps. Context: main().
uint32_t lin_thread_overruns(void);

// A non-blocking raw CAN socket. The kernel's time stamps of arrival are converted to
// CLOCK_MONOTONIC. Frames longer than 8 bytes are CAN FD.
// Source: Linux, Documentation/networking/can.rst; linux/can/error.h.

enum { lin_can_max_filters = 32 };

/// Filter of received frames.
typedef struct {
    uint32_t id, mask; ///< of 11-bit data frames
} lin_can_filter_t;

/// A socket. One thread (the tick or main()) receives and sends; main() may also call
/// lin_can_rebind().
typedef struct {
    int fd; ///< -1: not open; fd to n_filters are constant after lin_can_open()
    char interface[16];
    uint32_t n_room; ///< [frames] length of the interface's queue (txqueuelen); 0: no queue
    lin_can_filter_t filters[lin_can_max_filters];
    uint32_t n_filters;
    uint32_t n_overflow;  ///< received frames dropped by the kernel so far
    lin_loss_t link;      ///< none, bus_off or interface_down
    lin_loss_t event;     ///< overflow or send since lin_can_take_event()
    _Atomic bool is_gone; ///< the interface was removed; set by the thread that receives and
                          ///< sends, cleared by lin_can_rebind()
} lin_can_t;

/// @param n       1 .. lin_can_max_filters
/// @param is_fd   the interface must support CAN FD
/// @return        false and *e: no CAN in the kernel, no such interface, it is down or without FD
/// Context: main(), before the tick.
bool lin_can_open(lin_can_t *can, const char *interface, const lin_can_filter_t *filters,
                  uint32_t n, bool is_fd, common_error_t *e);

/// Receives the frames of lin_can_receive().
typedef void lin_can_handler_t(void *user, const hal_can_frame_t *frame, int64_t ns);

/// Receive up to 128 frames, with at most six system calls; the rest stays for the next tick.
void lin_can_receive(lin_can_t *can, lin_can_handler_t *take, void *user);

/// Receive one frame, with one or a few system calls. @return false if there is none
bool lin_can_receive_one(lin_can_t *can, hal_can_frame_t *frame);

/// Queue frames with one system call, n <= 32.
/// @return number of frames queued; if less than n, `link` and `event` give the cause
uint32_t lin_can_send(lin_can_t *can, const hal_can_frame_t *frames, uint32_t n);

/// @return event since the last call: none, overflow or send
lin_loss_t lin_can_take_event(lin_can_t *can);

/// Rebind to an interface that was removed and has returned. Context: main(), concurrently with any
/// other function of this module in the tick.
void lin_can_rebind(lin_can_t *can);

// The GPIO lines of the controller by function. A line that can no longer be read or written (its
// chip was unplugged) is lost: the inputs then report emergency stop and not ready until the
// program is restarted.

/// Request all wired lines; outputs are inactive.
/// @return false and *e for the first line that fails. Context: main(), once.
bool lin_lines_open(const lin_config_t *config, common_error_t *e);

/// @return hal_in_* of all lines; an unwired estop or ready line reads as closed or ready, all
///         others as off. Context: tick.
uint32_t lin_lines_read(void);

/// Read the oldest edge of the index line. @return false if there is none. Context: tick.
bool lin_lines_edge(int64_t *ns, bool *is_rising);

/// Write hal_out_*. Only lines that changed or whose last write failed are written, each with one
/// system call; so enable low is retried until it succeeds. Context: tick.
void lin_lines_write(uint32_t bits);

/// Switch enable off and fault on unconditionally. Context: any, including signal handlers.
void lin_lines_safe(void);

/// @return version of the library, static
const char *lin_lines_library(void);

/// @return the first line that was lost, lin_n_lines: none. Context: any.
lin_line_t lin_lines_lost(void);

// Notifies systemd that the program is ready and alive; does nothing without systemd.
// Source: sd_notify(3), "Notes": one datagram to the socket NOTIFY_SOCKET.

/// Notify that the tick runs. Context: main(), once.
void lin_notify_ready(void);

/// Notify that tick and main() are alive, at most four times per WATCHDOG_USEC. If notifications
/// stop, systemd ends the program with SIGABRT, which disables the drives. Context: main().
void lin_notify_alive(int64_t now_ns);

// Status lines of the port, by hal_text(). Context: main().

/// Report the configured machine and warnings about it.
/// @param n_room  [frames] length of the queue of can.interface, 0: no queue
void lin_report_set_up(const lin_config_t *config, uint32_t n_room);

/// Formats a cause: lin_cause_bus_text or lin_cause_drives_text.
typedef void lin_report_put_t(lin_cause_t cause, const lin_config_t *config, char *line,
                              size_t size);

/// Report a packed cause (lin_cause_pack()) if it differs from *last.
void lin_report_change(uint32_t *last, uint32_t word, lin_report_put_t *put,
                       const lin_config_t *config);

/// Report a lost GPIO line, once.
void lin_report_lost_line(void);

/// Report missed ticks since the last call.
/// @param n  missed ticks since the start
void lin_report_overruns(uint32_t n);

#endif
