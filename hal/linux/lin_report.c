// SPDX-License-Identifier: Apache-2.0
#include "lin_port.h"
#include "hal/hal.h"   // hal_text
#include "lin_setup.h" // lin_check_warn, lin_load_of
#include <stdbool.h>   // bool
#include <stdio.h>     // snprintf

void lin_report_set_up(const lin_config_t *config, uint32_t n_room)
{
    char line[lin_line_bytes];
    (void)snprintf(line, sizeof line, "port: %d ticks/s, %s%s, libgpiod %s",
                   (int)config->thread.tick_hz, config->can.interface,
                   config->can.is_fd ? " (FD)" : "", lin_lines_library());
    hal_text(line);
    lin_check_warn(config, hal_text);
    // A tick queues all its frames at once, possibly with the status frames.
    const uint32_t n_needed = (uint32_t)lin_load_of(config).n_queued;
    if (n_room != 0u && n_room < n_needed) {
        common_error_t warning;
        (void)common_error(
            &warning,
            "warning: %s: its queue holds %u frames, a tick may send %u; a frame "
            "that does not fit causes the fault bus; `ip link set %s txqueuelen 100`",
            config->can.interface, n_room, n_needed, config->can.interface);
        hal_text(warning.text);
    }
}

void lin_report_change(uint32_t *last, uint32_t word, lin_report_put_t *put,
                       const lin_config_t *config)
{
    char line[lin_line_bytes];
    if (word != *last) {
        *last = word;
        put(lin_cause_unpack(word), config, line, sizeof line);
        hal_text(line);
    }
}

void lin_report_lost_line(void)
{
    static bool is_reported;
    const lin_line_t lost = lin_lines_lost();
    if (lost != lin_n_lines && !is_reported) {
        char line[lin_line_bytes];
        (void)snprintf(line, sizeof line,
                       "%s: line lost: emergency stop until the program is restarted",
                       lin_line_name(lost));
        hal_text(line);
        is_reported = true;
    }
}

void lin_report_overruns(uint32_t n)
{
    static uint32_t last;
    char line[lin_line_bytes];
    if (n != last) {
        (void)snprintf(line, sizeof line, "port: %u ticks missed, %u since the start", n - last, n);
        hal_text(line);
        last = n;
    }
}
