// SPDX-License-Identifier: Apache-2.0
#include "lin_setup.h"
#include <string.h> // strcmp

enum { pdo_bytes = 6, offset_bytes = 4, encoder_bytes = 4, fd_bytes = 12, status_bytes = 8 };
enum { status_frames = 5, status_hz = 100 }; // State, Spindle, AxisU, Detail twice: cam_report.c
#define SECOND_NS INT64_C(1000000000)

/// @return greatest number of stuff bits for n bits
static int64_t stuff(int64_t n)
{
    return (n - 1) / 4;
}

/// A classic frame has 34 bits from start to checksum plus the data, all with bit stuffing, then 10
/// bits to its end and 3 of interframe space.
static int64_t classic_ns(const lin_can_config_t *c, int64_t n_bytes)
{
    const int64_t stuffed = 34 + 8 * n_bytes;
    return (stuffed + stuff(stuffed) + 13) * SECOND_NS / c->bitrate;
}

/// An FD frame has, at the nominal bit rate, 17 bits up to the rate switch and 12 after the
/// checksum; at the data bit rate 5 bits and the data, with bit stuffing, then 28: stuff count,
/// checksum for up to 16 bytes, fixed stuff bits, delimiter.
static int64_t fd_ns(const lin_can_config_t *c, int64_t n_bytes)
{
    const int64_t data = 5 + 8 * n_bytes;
    return (17 + stuff(17) + 12) * SECOND_NS / c->bitrate +
           (data + stuff(data) + 28) * SECOND_NS / c->data_bitrate;
}

/// Add the frames to a drive in one tick, and its answer.
static void add_drive(lin_load_t *load, const lin_can_config_t *c, bool is_axis)
{
    const bool is_one = !is_axis || c->is_fd;
    load->tick_ns += is_axis && c->is_fd ? fd_ns(c, fd_bytes) : classic_ns(c, pdo_bytes);
    load->tick_ns += is_one ? 0 : classic_ns(c, offset_bytes);
    load->tick_ns += classic_ns(c, pdo_bytes);
    load->n_queued += is_one ? 1 : 2;
}

lin_load_t lin_load_of(const lin_config_t *config)
{
    const lin_can_config_t *c = &config->can;
    lin_load_t load = {.n_queued = 2}; // SYNC, heartbeat
    int64_t n_nodes = 1;
    for (int i = 0; i < hal_n_axes; i++) {
        if (config->drive[i].node != 0) {
            add_drive(&load, c, true);
            n_nodes++;
        }
    }
    if (config->spindle_node != 0) {
        add_drive(&load, c, false);
        n_nodes++;
    }
    load.tick_ns += classic_ns(c, 0) + classic_ns(c, encoder_bytes);
    const int64_t n_beats = 1000 / c->heartbeat_ms + n_nodes * 2000 / c->node_timeout_ms;
    load.second_ns = n_beats * classic_ns(c, 1);
    if (strcmp(c->remote, c->interface) == 0) {
        load.second_ns += (int64_t)status_hz * status_frames * classic_ns(c, status_bytes);
        load.n_queued += status_frames;
    }
    return load;
}

int64_t lin_load_percent(const lin_load_t *load, int64_t tick_hz)
{
    const int64_t percent_ns = SECOND_NS / 100;
    return (load->tick_ns * tick_hz + load->second_ns + percent_ns - 1) / percent_ns;
}

int64_t lin_load_most_hz(const lin_load_t *load)
{
    const int64_t left_ns = SECOND_NS - load->second_ns;
    return left_ns > 0 ? left_ns / load->tick_ns : 0;
}
