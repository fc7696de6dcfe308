// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): MSG_NOSIGNAL
#include "sim_live.h"
#include <errno.h>      // errno
#include <string.h>     // memcpy, strerror
#include <sys/socket.h> // recv, send

/// The first packet of each side.
typedef struct {
    char name[12];
    uint32_t sensed_bytes, written_bytes, tick_hz;
} hello_t;

static bool send_packet(sim_wire_t *w, const void *packet, size_t n)
{
    ssize_t sent = -1;
    do {
        sent = w->is_lost ? 0 : send(w->fd, packet, n, MSG_NOSIGNAL);
    } while (sent < 0 && errno == EINTR);
    w->is_lost = w->is_lost || sent != (ssize_t)n;
    return !w->is_lost;
}

static bool receive_packet(sim_wire_t *w, void *packet, size_t n)
{
    ssize_t got = -1;
    do {
        got = w->is_lost ? 0 : recv(w->fd, packet, n, 0);
    } while (got < 0 && errno == EINTR);
    w->is_lost = w->is_lost || got != (ssize_t)n;
    return !w->is_lost;
}

bool sim_wire_open(sim_wire_t *w, int fd, uint32_t tick_hz, common_error_t *e)
{
    *w = (sim_wire_t){.fd = fd};
    const hello_t own = {.name = "camsim live",
                         .sensed_bytes = sizeof(sim_wire_sensed_t),
                         .written_bytes = sizeof(sim_wire_written_t),
                         .tick_hz = tick_hz};
    hello_t other;
    errno = 0;
    if (!send_packet(w, &own, sizeof own) || !receive_packet(w, &other, sizeof other)) {
        return common_error(e, "--wire %d: no partner: %s; let tools/live start both", fd,
                            errno != 0 ? strerror(errno) : "it has ended");
    }
    return memcmp(&own, &other, sizeof own) == 0 ||
           common_error(e,
                        "--wire %d: the partner is another program or has another tick_hz; let "
                        "tools/live start both",
                        fd);
}

bool sim_wire_send_sensed(sim_wire_t *w)
{
    sim_wire_sensed_t packet = {.clock = hal_host.clock};
    memcpy(packet.in, &hal_host.in, sizeof packet.in);
    return send_packet(w, &packet, sizeof packet);
}

bool sim_wire_receive_sensed(sim_wire_t *w)
{
    sim_wire_sensed_t packet;
    if (!receive_packet(w, &packet, sizeof packet)) {
        return false;
    }
    memcpy(&hal_host.in, packet.in, sizeof packet.in);
    hal_host.in.encoder = hal_host.in.read; // the lathe has applied the faults
    hal_host.clock = packet.clock - hal_host_clock_hz / hal_host.tick_hz;
    return true;
}

bool sim_wire_send_written(sim_wire_t *w, const sim_wire_played_t *played)
{
    sim_wire_written_t packet = {.played = *played};
    memcpy(packet.out, &hal_host.out, sizeof packet.out);
    return send_packet(w, &packet, sizeof packet);
}

bool sim_wire_receive_written(sim_wire_t *w)
{
    sim_wire_written_t packet;
    if (!receive_packet(w, &packet, sizeof packet)) {
        return false;
    }
    memcpy(&hal_host.out, packet.out, sizeof packet.out);
    w->played = packet.played;
    return true;
}
