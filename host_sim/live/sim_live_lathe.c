// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): poll
#include "sim_live.h"
#include <errno.h>  // errno
#include <poll.h>   // poll
#include <stdio.h>  // fprintf, printf, snprintf
#include <string.h> // strchr, strcmp
#include <unistd.h> // read

/// Ticks between two checks of stdin: 5 ms, which nobody notices.
enum { look_ticks = 100 };

static void release(void)
{
    hal_host_fault_estop(false);
    hal_host_fault_drive(false);
    hal_host_fault_bus(false);
}

/// @return false and *e when a word is not a fault of the lathe
static bool parse(sim_inject_t *what, const char *word, common_error_t *e)
{
    char text[2 * sim_live_word_bytes];
    const char *colon = strchr(word, ':');
    const int n_kind = (int)(colon != NULL ? colon - word : (long)strlen(word));
    (void)snprintf(text, sizeof text, "%.*s@t0%s", n_kind, word, colon != NULL ? colon : "");
    if (!sim_inject_parse(what, text, sim_inject_in_live, e)) {
        return false;
    }
    return (what->kind != sim_inject_stop && what->kind != sim_inject_table_flip) ||
           common_error(e, "%s: is no fault of the lathe; tools/camctl commands the controller",
                        word);
}

static void inject(sim_live_t *l, const sim_inject_t *what)
{
    if (what->kind == sim_inject_key) {
        l->people.is_key_on = what->value != 0.0;
    } else if (what->kind == sim_inject_acknowledge) {
        sim_operator_press(&l->people, l->port.time_s, what->value);
    } else { // a fault of the lathe or of the port
    }
    sim_port_inject(&l->port, what, l->session.table.direction);
}

/// Cause a fault typed as KIND or KIND:VALUE.
static void carry_out(sim_live_t *l, const char *word)
{
    common_error_t e;
    sim_inject_t what;
    if (strcmp(word, "release") == 0) {
        release();
    } else if (parse(&what, word, &e)) {
        inject(l, &what);
    } else {
        (void)fprintf(stderr, "lathe: %s\n", e.text);
        return;
    }
    (void)printf("%s: done\n", word);
    (void)fflush(stdout);
}

static void take_byte(sim_live_t *l, char c)
{
    if (c != '\n') {
        l->n_word += l->n_word + 1u < sizeof l->word ? 1u : 0u;
        l->word[l->n_word - 1u] = c;
        return;
    }
    l->word[l->n_word] = '\0';
    if (l->n_word > 0u) {
        carry_out(l, l->word);
    }
    l->n_word = 0;
}

/// Process typed input. @return false at its end
static bool listen_to_words(sim_live_t *l)
{
    struct pollfd in = {.fd = STDIN_FILENO, .events = POLLIN};
    while (poll(&in, 1, 0) > 0) {
        char bytes[sim_live_word_bytes];
        const ssize_t n = read(STDIN_FILENO, bytes, sizeof bytes);
        if (n == 0 || (n < 0 && errno != EINTR)) {
            return false;
        }
        for (ssize_t i = 0; i < n; i++) {
            take_byte(l, bytes[i]);
        }
    }
    return true;
}

static bool is_at_rest(const sim_lathe_t *lathe)
{
    bool rests = sim_lathe_spindle_rests(lathe);
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        rests = rests && sim_lathe_drive_rests(lathe, i);
    }
    return rests;
}

/// Without a controller disable drives and spindle; report that, and where they came to rest.
static void stand_alone(sim_live_t *l)
{
    const sim_lathe_t *lathe = &l->port.lathe;
    hal_host.out.outputs = 0;
    hal_host.out.spindle_mrpm = 0;
    if (!l->was_lost) {
        l->was_lost = true;
        (void)printf("the controller is gone at %.3f s: drives disabled, all axes brake\n",
                     l->port.time_s);
    }
    if (!l->has_rested && is_at_rest(lathe)) {
        const sim_sample_t at = sim_lathe_sample(lathe, l->port.time_s);
        l->has_rested = true;
        (void)printf("at rest at %.3f s: U %.4f mm, X %.4f mm, Z %.4f mm\n", at.t_s, at.u_nm * 1e-6,
                     at.x_nm * 1e-6, at.z_nm * 1e-6);
    }
    (void)fflush(stdout);
}

/// Update the button and the key switch of the operator.
static void attend(sim_live_t *l)
{
    const bool is_closed = (hal_host.in.inputs & (uint32_t)hal_in_estop) == 0u;
    const uint32_t busy = (uint32_t)hal_out_enable | (uint32_t)hal_out_fault;
    const bool is_needed =
        l->wire.played.is_waiting != 0u && is_closed && (hal_host.out.outputs & busy) == 0u;
    hal_host_press(sim_operator_step(&l->people, is_needed, l->port.time_s));
    hal_host_turn_key(sim_operator_key(&l->people, l->wire.played.session));
}

static void tick(sim_live_t *l)
{
    const sim_inject_t *what;
    sim_port_sense(&l->port);
    attend(l);
    hal_host_advance();
    if (!sim_wire_send_sensed(&l->wire) || !sim_wire_receive_written(&l->wire)) {
        stand_alone(l);
        sim_pace_tick(&l->pace);
    }
    while ((what = sim_session_next_inject(&l->session, l->port.time_s)) != NULL) {
        inject(l, what);
    }
    sim_live_gauge(l);
    sim_port_advance(&l->port);
}

void sim_live_lathe(sim_live_t *l)
{
    l->people.is_present = l->options.people == sim_live_present;
    l->people.turns_key = l->options.people != sim_live_absent;
    l->people.is_key_on = l->people.turns_key;
    for (uint32_t i = 0; i % look_ticks != 0u || listen_to_words(l); i++) {
        tick(l);
    }
}
