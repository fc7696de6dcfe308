// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): poll
#include "cam_remote.h"         // cam_can_init
#include "cam_machine.h"        // cam_machine_init, cam_machine_blackbox
#include "sim_live.h"
#include "sim_config.h" // sim_params_apply
#include <errno.h>      // errno
#include <fcntl.h>      // fcntl
#include <poll.h>       // poll
#include <stdio.h>      // fprintf
#include <string.h>     // memcpy
#include <unistd.h>     // read, write

/// Ticks between two checks of stdin: 0.2 ms at 20 kHz.
enum { look_ticks = 4 };

typedef struct {
    cam_machine_t machine;
    cam_can_t remote;
    uint8_t frame[sizeof(hal_can_frame_t)]; ///< from stdin, as far as received
    size_t n_frame;
    uint32_t n_sent; ///< frames of the port's ring that were sent
    bool is_over;    ///< stdin has ended
} controller_t;

static controller_t controller;

/// Read more of a frame. @return true when something was read
static bool read_frame(controller_t *c)
{
    const ssize_t n = read(STDIN_FILENO, c->frame + c->n_frame, sizeof c->frame - c->n_frame);
    c->is_over = n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN);
    c->n_frame += n > 0 ? (size_t)n : 0u;
    return n > 0;
}

/// Hand over received frames, as far as the port's queue has room.
static void receive_frames(controller_t *c)
{
    struct pollfd in = {.fd = STDIN_FILENO, .events = POLLIN};
    while (hal_host.slow.n_received - hal_host.slow.n_read < hal_host_can_frames &&
           poll(&in, 1, 0) > 0 && read_frame(c)) {
        if (c->n_frame == sizeof c->frame) {
            hal_can_frame_t frame;
            memcpy(&frame, c->frame, sizeof frame);
            (void)hal_host_can_receive(&frame);
            c->n_frame = 0;
        }
    }
}

/// Forward the firmware's frames. A reader that stalls loses frames, as on a bus.
static void send_frames(controller_t *c)
{
    for (; c->n_sent != hal_host.slow.n_sent; c->n_sent++) {
        const hal_can_frame_t *frame = &hal_host.slow.sent[c->n_sent % hal_host_can_frames];
        const ssize_t n = write(STDOUT_FILENO, frame, sizeof *frame);
        c->is_over = c->is_over || (n < 0 && errno != EAGAIN && errno != EINTR);
    }
}

/// The lathe is gone: the port reports silent drives.
static void stand_alone(sim_live_t *l)
{
    if (!l->was_lost) {
        l->was_lost = true;
        (void)fprintf(stderr, "controller: the lathe is gone: bus lost, drives not ready\n");
    }
    hal_host_fault_drive(true);
    hal_host_fault_bus(true);
}

/// Warn once that the computer is too slow for the requested speed.
static void warn_of_pace(sim_live_t *l)
{
    if (!l->is_warned && l->pace.lost_ns > 0.0) {
        l->is_warned = true;
        (void)fprintf(stderr, "controller: this computer cannot keep up, so the lathe runs slower "
                              "than it should; give a smaller --speed-up\n");
    }
}

/// @return whether nothing is enabled before the button is pressed
static bool is_waiting(const cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    return cam_machine_rights(m, &status).button == cam_button_needed;
}

static void tick(sim_live_t *l)
{
    if (!sim_wire_receive_sensed(&l->wire)) {
        stand_alone(l);
    }
    hal_host_tick();
    const cam_machine_t *m = &controller.machine;
    const sim_wire_played_t played = {
        .table_crc32 = m->has_table ? m->table.crc32 : 0u,
        .phase_udeg = m->params.phase_udeg,
        .is_waiting = is_waiting(m) ? 1u : 0u,
        .session = m->rights.commander != 0u ? m->rights.session : 0u,
    };
    (void)sim_wire_send_written(&l->wire, &played);
}

/// The part of main() before its loop.
static bool start(sim_live_t *l, common_error_t *e)
{
    const sim_session_options_t *o = &l->session.options;
    const sim_wishes_t wishes = sim_cut_wishes(&l->options.cut);
    cam_params_t params;
    if (!sim_controller_params(&params, sim_config_believed(&o->config),
                               !l->options.cut.is_without_learning, &wishes, e)) {
        return false;
    }
    if (l->options.people != sim_live_waived) {
        hal_host.slow.people = (hal_operator_t){.has_acknowledge = true, .has_key = true};
    }
    cam_machine_init(&controller.machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    cam_machine_blackbox(&controller.machine);
    tick(l); // takes the parameters of before
    if (!sim_params_apply(&controller.machine, &params, e)) {
        return false;
    }
    tick(l);
    hal_host.slow.table = (hal_image_t){.bytes = l->session.image, .size = (uint32_t)l->n_image};
    cam_machine_blackbox(&controller.machine);
    cam_can_init(&controller.remote, &controller.machine);
    return true;
}

bool sim_live_controller(sim_live_t *l, common_error_t *e)
{
    controller_t *c = &controller;
    *c = (controller_t){0};
    (void)fcntl(STDOUT_FILENO, F_SETFL, fcntl(STDOUT_FILENO, F_GETFL) | O_NONBLOCK);
    if (!start(l, e)) {
        return false;
    }
    for (uint32_t i = 0; !c->is_over; i++) {
        if (i % look_ticks == 0u) {
            receive_frames(c);
        }
        cam_machine_poll(&c->machine);
        cam_can_poll(&c->remote);
        tick(l);
        send_frames(c);
        sim_pace_tick(&l->pace);
        warn_of_pace(l);
    }
    return true;
}
