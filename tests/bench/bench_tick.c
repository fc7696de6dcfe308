// SPDX-License-Identifier: Apache-2.0
/// bench_tick TABLE: how long a tick takes, of the firmware alone and of the whole simulator.
///
/// The firmware alone, at 20 and at 100 kHz, replays what it sensed while cutting through
/// cam_tick_steps_isr(), from a copy of its state, and must end where the recorded run ended. Best
/// of several rounds, one core.
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): clock_gettime
#include "cam_tick.h"           // cam_tick_steps_isr
#include "sim_cut.h"            // sim_cut_t
#include "sim_file.h"           // sim_file_read
#include <stdio.h>              // printf
#include <stdlib.h>             // calloc
#include <string.h>             // memcpy, memset
#include <time.h>               // clock_gettime

enum { n_senses = 100000, n_rounds = 7, max_table_bytes = 1 << 26 };

typedef struct {
    sim_cut_t cut;
    sim_file_t table;
    const char *name;
    cam_t before; ///< the controller before the first recorded tick
    cam_t copy;
    cam_sense_t sense[n_senses];
    cam_tick_record_t last; ///< of the recorded run
    double tick_hz;
} bench_t;

static double now_s(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool open_cut(bench_t *b, bool is_traced)
{
    sim_cut_options_t options = {.session = {.config = sim_config_defaults(), .seed = 1},
                                 .is_traced = is_traced};
    options.session.config.lathe.tick_hz = b->tick_hz;
    common_error_t e;
    memset(&b->cut, 0, sizeof b->cut);
    if (!sim_cut_open(&b->cut, &options, b->table.bytes, b->table.size, b->name, &e)) {
        (void)fprintf(stderr, "bench_tick: %s\n", e.text);
        return false;
    }
    return true;
}

/// Ticks of a whole cut. @return [ns per tick], negative on error
static double time_cut_ns(bench_t *b, bool is_traced)
{
    cam_tick_record_t record;
    if (!open_cut(b, is_traced)) {
        return -1.0;
    }
    const double begin_s = now_s();
    while (b->cut.end == sim_cut_running) {
        sim_cut_tick(&b->cut);
        while (is_traced && cam_trace_pop(&g_cam.trace, &record)) {
        }
    }
    const double ns = (now_s() - begin_s) * 1e9 / (double)b->cut.n_ticks;
    sim_cut_close(&b->cut);
    return ns;
}

/// Cut until the tool is well in the work, then record what the firmware senses.
static bool record_senses(bench_t *b)
{
    if (!open_cut(b, true)) {
        return false;
    }
    while (b->cut.end == sim_cut_running && b->cut.session.cut_turns < 1.0) {
        sim_cut_tick(&b->cut);
        while (cam_trace_pop(&g_cam.trace, &b->last)) {
        }
    }
    memcpy(&b->before, &g_cam, sizeof g_cam);
    for (int i = 0; i < n_senses && b->cut.end == sim_cut_running; i++) {
        sim_cut_tick(&b->cut);
        (void)cam_trace_pop(&g_cam.trace, &b->last);
        b->sense[i] = b->last.in;
    }
    return b->cut.end == sim_cut_running;
}

static double replay_ns(bench_t *b, cam_tick_record_t *out)
{
    memcpy(&b->copy, &b->before, sizeof b->copy);
    const cam_config_t *cfg = cam_config_take_isr(&b->copy.config);
    const double begin_s = now_s();
    for (int i = 0; i < n_senses; i++) {
        out->in = b->sense[i];
        cam_tick_steps_isr(&b->copy, cfg, out);
    }
    return (now_s() - begin_s) * 1e9 / n_senses;
}

static bool is_same(const cam_tick_record_t *a, const cam_tick_record_t *b)
{
    return a->angle.pos_q32 == b->angle.pos_q32 && a->angle.speed_q32 == b->angle.speed_q32 &&
           a->want.u_set_q6 == b->want.u_set_q6 && memcmp(a->out, b->out, sizeof a->out) == 0 &&
           a->want.state == b->want.state;
}

static double smaller(double a, double b)
{
    return a < b ? a : b;
}

/// The firmware alone, at a rate of ticks. @return [ns per tick], negative on error
static double time_firmware_ns(bench_t *b, double tick_hz)
{
    double ns = 1e9;
    cam_tick_record_t out = {0};
    b->tick_hz = tick_hz;
    if (!record_senses(b)) {
        return -1.0;
    }
    for (int i = 0; i < n_rounds; i++) {
        ns = smaller(ns, replay_ns(b, &out));
    }
    sim_cut_close(&b->cut);
    if (!is_same(&out, &b->last)) {
        (void)fprintf(stderr, "bench_tick: the replay did not end where the run ended\n");
        return -1.0;
    }
    return ns;
}

static int run(bench_t *b)
{
    static const double rates_hz[] = {20e3, 100e3};
    static const char *const names[] = {"firmware alone     ", "  at 100 kHz       "};
    double firmware_ns[2];
    double whole_ns = 1e9;
    double traced_ns = 1e9;
    for (int i = 0; i < 2; i++) {
        firmware_ns[i] = time_firmware_ns(b, rates_hz[i]);
        if (firmware_ns[i] < 0.0) {
            return EXIT_FAILURE;
        }
        (void)printf("%s %7.1f ns/tick  %6.2f million ticks/s\n", names[i], firmware_ns[i],
                     1e3 / firmware_ns[i]);
    }
    b->tick_hz = rates_hz[0];
    for (int i = 0; i < n_rounds; i++) {
        whole_ns = smaller(whole_ns, time_cut_ns(b, false));
        traced_ns = smaller(traced_ns, time_cut_ns(b, true));
    }
    if (whole_ns < 0.0) {
        return EXIT_FAILURE;
    }
    (void)printf("whole simulator     %7.1f ns/tick  %6.2f million ticks/s  %.2f x firmware\n",
                 whole_ns, 1e3 / whole_ns, whole_ns / firmware_ns[0]);
    (void)printf("with trace records  %7.1f ns/tick  %6.2f million ticks/s  %.2f x whole\n",
                 traced_ns, 1e3 / traced_ns, traced_ns / whole_ns);
    return EXIT_SUCCESS;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        (void)fprintf(stderr, "usage: bench_tick TABLE\n");
        return EXIT_FAILURE;
    }
    common_error_t e;
    int status = EXIT_FAILURE;
    bench_t *b = calloc(1, sizeof *b);
    if (b == NULL) {
        (void)fprintf(stderr, "bench_tick: not enough memory\n");
        return EXIT_FAILURE;
    }
    b->name = argv[1];
    if (sim_file_read(&b->table, b->name, max_table_bytes, &e)) {
        status = run(b);
        sim_file_free(&b->table);
    } else {
        (void)fprintf(stderr, "bench_tick: %s\n", e.text);
    }
    free(b);
    return status;
}
