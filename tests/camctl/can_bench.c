// SPDX-License-Identifier: Apache-2.0
// The firmware with main()'s loop around an ideal machine. CAN frames come on standard input and
// leave on standard output, 72 bytes each: id, bytes, data. A frame with the id `bench_estop`
// presses the emergency stop (data 1) or releases it, bench_button likewise the button acknowledge;
// bench_drive and bench_bus fail a drive and the bus of the drives, and bench_key turns the key
// switch, which is on at the start and turned anew for each commander. From bench_force on the port
// has an output of force; U still follows its set-points. The first word is how many times faster
// than the clock virtual time passes; with a second one the controller demands the button. On a
// busy computer virtual time falls behind; it never runs faster to catch up, since no tool could
// follow it then. Ends with its input.
#include "cam_machine.h" // cam_machine_blackbox
#include "fixture_can.h"
#include "hal_host.h"
#include "sim_inject.h" // sim_operator_key
#include "sim_live.h"   // sim_pace_tick
#include <errno.h>      // errno
#include <poll.h>       // poll
#include <stdlib.h>     // strtod
#include <string.h>     // memcpy
#include <unistd.h>     // read, write

enum { tick_hz = 20000, look_ticks = 5, frame_bytes = 8 + hal_can_max_bytes };

enum { bench_estop = 0x10000, bench_button, bench_key, bench_force, bench_drive, bench_bus };

static fixture_can_t f;
static sim_operator_t people; // turns the key anew for each commander
static uint32_t n_told;       // frames of the port's ring

static bool read_whole(uint8_t *bytes, size_t n)
{
    for (size_t at = 0; at < n;) {
        const ssize_t got = read(STDIN_FILENO, bytes + at, n - at);
        if (got <= 0 && errno != EINTR) {
            return false;
        }
        at += got > 0 ? (size_t)got : 0u;
    }
    return true;
}

static void take(const uint8_t *bytes)
{
    hal_can_frame_t frame = {.n = bytes[4]};
    memcpy(&frame.id, bytes, sizeof frame.id);
    memcpy(frame.data, bytes + 8, sizeof frame.data);
    const bool is_on = frame.data[0] != 0u;
    switch (frame.id) {
    case bench_estop:
        hal_host_fault_estop(is_on);
        break;
    case bench_button:
        hal_host_press(is_on);
        break;
    case bench_key:
        people.is_key_on = is_on;
        break;
    case bench_drive:
        hal_host_fault_drive(is_on);
        break;
    case bench_bus:
        hal_host_fault_bus(is_on);
        break;
    case bench_force:
        hal_host.slow.force.quantum_un = 20000;
        break;
    default:
        (void)hal_host_can_receive(&frame);
        break;
    }
}

/// What is there, as far as the queue has room. @return false at the end of the input
static bool listen(void)
{
    struct pollfd in = {.fd = STDIN_FILENO, .events = POLLIN};
    while (hal_host.slow.n_received - hal_host.slow.n_read < hal_host_can_frames &&
           poll(&in, 1, 0) > 0) {
        uint8_t bytes[frame_bytes];
        if (!read_whole(bytes, sizeof bytes)) {
            return false;
        }
        take(bytes);
    }
    return true;
}

static bool speak(void)
{
    for (; n_told != hal_host.slow.n_sent; n_told++) {
        const hal_can_frame_t *frame = &hal_host.slow.sent[n_told % hal_host_can_frames];
        uint8_t bytes[frame_bytes] = {0};
        memcpy(bytes, &frame->id, sizeof frame->id);
        bytes[4] = (uint8_t)frame->n;
        memcpy(bytes + 8, frame->data, sizeof frame->data);
        if (write(STDOUT_FILENO, bytes, sizeof bytes) != (ssize_t)sizeof bytes) {
            return false;
        }
    }
    return true;
}

/// As fixture_can_start(), but nobody has command.
static void start(void)
{
    fixture_can_boot(&f);
    people = (sim_operator_t){.is_key_on = true, .turns_key = true};
    f.rig.is_silent = true;
    fixture_rig_tick(&f.rig);
}

int main(int n_words, char **words)
{
    const fixture_part_t part = fixture_part_short();
    fixture_can_init(&f, &part, tick_hz);
    if (n_words < 2) {
        return 2;
    }
    if (n_words > 2) {
        hal_host.slow.people = (hal_operator_t){.has_acknowledge = true, .has_key = true};
    }
    start();
    cam_machine_blackbox(&f.rig.machine);
    hal_host.in.axis_nm[hal_axis_x] = 60000000; // clear of the part
    f.rig.lathe.home[hal_axis_x] =
        (ideal_home_t){.side = 1, .edge_nm = 61000000, .pitch_nm = 500000};
    f.rig.lathe.home[hal_axis_u] = (ideal_home_t){.side = 1, .edge_nm = 100000};
    (void)fixture_rig_set(&f.rig, cam_param_lead_ns, 1000000000 / tick_hz);
    sim_pace_t pace;
    sim_pace_init(&pace, tick_hz, strtod(words[1], NULL));
    for (uint32_t i = 0;; i++) {
        if (i % look_ticks == 0u && !listen()) {
            return 0;
        }
        const cam_rights_t *rights = &f.rig.machine.rights;
        const uint32_t session_now = rights->commander != 0u ? rights->session : 0u;
        hal_host_turn_key(sim_operator_key(&people, session_now));
        fixture_can_loop(&f, 1);
        if (!speak()) {
            return 0;
        }
        sim_pace_tick(&pace);
    }
}
