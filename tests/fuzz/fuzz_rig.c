// SPDX-License-Identifier: Apache-2.0
#include "fuzz_rig.h"
#include "cam_config.h"        // cam_config_t
#include "cam_machine_inner.h" // cam_machine_manual, cam_offsets_shift_nm
#include "fixture_image.h"     // fixture_image_make
#include "fixture_newer.h"     // fixture_newer_way
#include "fixture_part.h"      // fixture_part_short
#include "fuzz_expect.h"       // FUZZ_EXPECT
#include "hal_host.h"          // hal_host
#include <math.h>              // cos, sin
#include <stdio.h>             // stderr
#include <stdlib.h>            // getenv
#include <string.h>            // memcpy, memset

enum { skirt, modulated, camshaft, banded };
enum { n_rates = fuzz_rig_n_rates, n_states = 4, mm = 1000000 };

fuzz_rig_t fuzz_rig;

/// Everything that a tick or a command changes.
typedef struct {
    bool is_made;
    cam_t core;
    hal_host_t host;
    fuzz_rig_t rig;
} copy_t;

static copy_t copies[n_rates][fuzz_rig_n_parts][n_states][2][2];
static fixture_image_t images[fuzz_rig_n_parts];

/// Rates, with the spindle's speed at which a turn has 50 ticks or more.
static const struct {
    uint32_t tick_hz;
    int32_t spindle_mrpm;
} rates[n_rates] = {{1000, 1200000}, {2000, 1500000},  {5000, 2000000},  {20000, 2500000},
                    {500, 600000},   {10000, 2500000}, {50000, 2500000}, {100000, 2500000}};

static const cam_state_t states[n_states] = {cam_state_off, cam_state_ready, cam_state_cutting,
                                             cam_state_manual};

/// Z goes back over a tenth of the height, in the middle of its way.
static void there_and_back(double z_nm, double way[3])
{
    const double k = 2.0 * 3.14159265358979323846 / mm;
    way[0] = 1.3 * (1.0 - cos(k * z_nm)) / k;
    way[1] = 1.3 * sin(k * z_nm);
    way[2] = 1.3 * k * cos(k * z_nm);
}

const void *fuzz_rig_image(uint32_t part, size_t *size)
{
    if (images[part].size == 0u) {
        const fixture_part_t parts[fuzz_rig_n_parts] = {fixture_part_short(),
                                                        fixture_part_modulated(),
                                                        fixture_part_swung(), fixture_part_short()};
        fixture_image_t *image = &images[part];
        fixture_image_make(image, &parts[part]);
        if (part == (uint32_t)banded) {
            fixture_newer_way(image, there_and_back, 15, 4);
            const uint32_t way = fixture_newer_last(image);
            fixture_image_put(image, fixture_image_in(way, fixture_in_path), 1u);
            fixture_image_seal(image);
        }
    }
    *size = images[part].size;
    return images[part].bytes;
}

uint32_t fuzz_rig_hz(uint32_t rate)
{
    return rates[rate % (uint32_t)n_rates].tick_hz;
}

fuzz_start_t fuzz_rig_start_of(uint8_t how)
{
    return (fuzz_start_t){.tick_hz = fuzz_rig_hz(how % 4u),
                          .state = states[how / 4u % (uint32_t)n_states]};
}

const cam_tick_record_t *fuzz_rig_record(void)
{
    return cam_trace_newest(&g_cam.trace);
}

cam_state_t fuzz_rig_state(void)
{
    return fuzz_rig.judge.state;
}

void fuzz_rig_encoder(int32_t counts_per_turn)
{
    fixture_encoder_init(&fuzz_rig.lathe.encoder, counts_per_turn, 1, 1234u, 0);
}

bool fuzz_rig_is_traced(void)
{
    static int is_on = -1;
    is_on = is_on < 0 ? getenv("CAM_FUZZ_TRACE") != NULL : is_on;
    return is_on > 0;
}

#define VISIT(name, member, low, high)                                                             \
    FUZZ_EXPECT((int64_t)(member) >= (low) && (int64_t)(member) <= (high), name " is %lld",        \
                (long long)(member));                                                              \
    fuzz_note((int64_t)(member));
#include "ranges_walk.h"

void fuzz_rig_walk_config(cam_config_t *config)
{
    walk_config(config);
}

static uint32_t walked; // generation

/// The configuration changes rarely: each generation of it is checked once.
static void walk(void)
{
    cam_config_t *const first = &g_cam.config.half[0];
    cam_config_t *const in_use =
        atomic_load(&g_cam.config.in_use) == first ? first : &g_cam.config.half[1];
    if (in_use->generation != walked) {
        fuzz_rig_walk_config(in_use);
        walked = in_use->generation;
    }
    walk_state(&g_cam);
}

static void trace(void)
{
    if (fuzz_rig_is_traced()) {
        const cam_tick_record_t *r = fuzz_rig_record();
        (void)printf("%u %s faults %x turn %.4f u %d x %d z %d outputs %x\n", (unsigned)r->tick,
                     cam_state_name(r->want.state), (unsigned)r->want.faults,
                     (double)r->angle.pos_q32 / 4294967296.0,
                     (int)hal_host.out.axis[hal_axis_u].pos_nm,
                     (int)hal_host.out.axis[hal_axis_x].pos_nm,
                     (int)hal_host.out.axis[hal_axis_z].pos_nm, (unsigned)hal_host.out.outputs);
    }
}

/// Note the outputs of the tick, its faults and set-point, and the last refusal.
static void note(void)
{
    const cam_tick_record_t *r = fuzz_rig_record();
    fuzz_note(r->want.faults);
    fuzz_note(r->want.u_due_q6);
    fuzz_note(r->force_q6);
    fuzz_note(fuzz_rig.machine.refusal.needed);
    fuzz_note(fuzz_rig.machine.refusal.limit);
    fuzz_note(hal_host.out.outputs);
    fuzz_note(hal_host.out.spindle_mrpm);
    for (uint32_t i = 0; i < (uint32_t)hal_n_axes; i++) {
        fuzz_note(hal_host.out.axis[i].pos_nm);
        fuzz_note(hal_host.out.axis[i].vel_q10);
        fuzz_note(hal_host.out.axis[i].acc_q10);
    }
}

void fuzz_rig_tick(void)
{
    ideal_machine_move(&fuzz_rig.lathe);
    hal_host_tick();
    trace();
    walk();
    note();
    fuzz_rig.judge.x_shift_nm =
        cam_offsets_shift_nm(&fuzz_rig.machine.offsets, &fuzz_rig.machine.params, hal_axis_x);
    fuzz_judge_tick(&fuzz_rig.judge, &fuzz_rig.machine.params, fuzz_rig.machine.version,
                    fuzz_rig_record());
}

void fuzz_rig_loop(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        cam_machine_poll(&fuzz_rig.machine);
        cam_can_poll(&fuzz_rig.can);
        fuzz_rig_tick();
    }
}

static void set(cam_param_id_t id, int32_t value)
{
    const cam_err_t err = cam_machine_set_param(&fuzz_rig.machine, id, value);
    FUZZ_EXPECT(err == cam_ok, "start: parameter %s: %d", cam_param_info(id)->name, (int)err);
    fuzz_rig_tick();
}

static void begin(uint32_t rate, const fuzz_start_t *start)
{
    const uint32_t hz = rates[rate].tick_hz;
    const uint32_t part = start->part;
    memset(&fuzz_rig, 0, sizeof fuzz_rig);
    hal_host_reset(hz);
    hal_host.slow.people.has_acknowledge = start->has_button;
    hal_host.slow.people.is_acknowledge_waived = !start->has_button;
    hal_host.in.axis_nm[hal_axis_x] = 47 * mm;
    size_t size;
    const void *image = fuzz_rig_image(part, &size);
    hal_host.slow.table = (hal_image_t){.bytes = image, .size = (uint32_t)size};
    cam_machine_init(&fuzz_rig.machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    ideal_machine_init(&fuzz_rig.lathe, fuzz_rig.machine.params.counts_per_turn);
    fuzz_rig_encoder(fuzz_rig.machine.params.counts_per_turn);
    fuzz_rig.lathe.lags_as = &fuzz_rig.machine.params;
    cam_can_init(&fuzz_rig.can, &fuzz_rig.machine);
    FUZZ_EXPECT(fuzz_rig.machine.has_table, "start: no table");
    fuzz_judge_begin(&fuzz_rig.judge, hz, cam_table_rise_nm(&fuzz_rig.machine.table));
    fuzz_rig.judge.has_button = start->has_button;
    fuzz_rig_tick();
    set(cam_param_lead_ns, (int32_t)(1000000000u / hz));
    const int32_t mrpm = rates[rate].spindle_mrpm;
    // The ratio of a modulated speed reaches 1.4 of its mean.
    set(cam_param_spindle_mrpm, part == modulated && mrpm > 1500000 ? 1500000 : mrpm);
    if (fuzz_rig.machine.table.is_swung) {
        set(cam_param_swing_speed_mdeg_per_s, 100000000);
        set(cam_param_swing_acceleration_deg_per_s2, 100000000);
    }
    if (part == modulated) {
        set(cam_param_spindle_acceleration_mrad_per_s2, 2000000000);
    }
    if (start->takes_force) {
        hal_host.slow.force.quantum_un = 20000;
        set(cam_param_servo_integral_mHz, 0);
        set(cam_param_servo_pole_hz, 100);
        set(cam_param_servo_runaway_nm, cam_param_info(cam_param_servo_runaway_nm)->max);
        set(cam_param_servo_crossover_hz, 1);
    }
}

static void until(cam_state_t state)
{
    for (uint32_t n = 0; n < 60000u && fuzz_rig_state() != state; n++) {
        fuzz_rig_loop(1);
    }
    FUZZ_EXPECT(fuzz_rig_state() == state, "start: %s is not reached", cam_state_name(state));
}

static void bring(cam_state_t state)
{
    cam_machine_t *m = &fuzz_rig.machine;
    if (state == cam_state_off) {
        return;
    }
    if (state == cam_state_manual) {
        const cam_err_t by_hand = cam_machine_manual(m);
        FUZZ_EXPECT(by_hand == cam_ok, "start: manual: %d", (int)by_hand);
        until(cam_state_manual);
        return;
    }
    const cam_err_t enabled = cam_machine_enable(m);
    FUZZ_EXPECT(enabled == cam_ok, "start: enable: %d", (int)enabled);
    until(cam_state_ready);
    fuzz_rig_loop(fuzz_rig.judge.tick_hz / 8u); // the spindle runs up
    if (state == cam_state_cutting) {
        const cam_err_t started = cam_machine_start(m);
        FUZZ_EXPECT(started == cam_ok, "start: start: %d", (int)started);
        until(cam_state_cutting);
    }
}

/// Press the button acknowledge for n ticks, with an eighth of a second before and behind it.
static void press(uint32_t n)
{
    fuzz_rig_loop(fuzz_rig.judge.tick_hz / 8u);
    hal_host_press(true);
    fuzz_rig_loop(n);
    hal_host_press(false);
    fuzz_rig_loop(fuzz_rig.judge.tick_hz / 8u);
}

static uint32_t rate_of(uint32_t tick_hz)
{
    uint32_t i = 0;
    while (i + 1u < (uint32_t)n_rates && rates[i].tick_hz != tick_hz) {
        i++;
    }
    return i;
}

static uint32_t place_of(cam_state_t state)
{
    uint32_t i = 0;
    while (i + 1u < (uint32_t)n_states && states[i] != state) {
        i++;
    }
    return i;
}

/// The firmware's lines of text would be most of what a campaign says.
static void be_quiet(void)
{
    static FILE *nowhere;
    if (nowhere == NULL) {
        nowhere = fopen("/dev/null", "w");
        stderr = nowhere != NULL ? nowhere : stderr;
    }
}

void fuzz_rig_start(fuzz_start_t start)
{
    be_quiet();
    const uint32_t rate = rate_of(start.tick_hz);
    copy_t *c = &copies[rate][start.part][place_of(start.state)][start.has_button ? 1 : 0]
                       [start.takes_force ? 1 : 0];
    if (!c->is_made) {
        begin(rate, &start);
        if (start.has_button && start.state != cam_state_off) {
            press(start.tick_hz / 5u);
        }
        bring(start.state);
        c->core = g_cam;
        c->host = hal_host;
        c->rig = fuzz_rig;
        c->is_made = true;
    }
    memcpy(&g_cam, &c->core, sizeof g_cam);
    memcpy(&hal_host, &c->host, sizeof hal_host);
    memcpy(&fuzz_rig, &c->rig, sizeof fuzz_rig);
    walked = UINT32_MAX; // check and note the configuration for every input, not only the first
    fuzz_digest_begin(); // without the ticks that made the copy, which only the first input runs
}

cam_err_t fuzz_rig_select(const void *image, size_t size)
{
    const cam_err_t err = cam_machine_select_table(&fuzz_rig.machine, image, size);
    if (err == cam_ok) {
        fuzz_rig.judge.rise_nm = cam_table_rise_nm(&fuzz_rig.machine.table);
    }
    return err;
}
