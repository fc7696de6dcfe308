// SPDX-License-Identifier: Apache-2.0
// A controller in every state senses anything: extreme and random numbers in every word that the
// port hands over. Nothing undefined happens (the presets with sanitizers run this too), U is
// commanded nothing beyond its stroke, and without enable every axis is commanded its measured
// position.
#include "cam_fix.h"
#include "cam_machine.h"
#include "cam_table.h"
#include "fixture_can.h"
#include "fixture_newer.h"
#include "fixture_random.h"
#include "fixture_shaft.h"
#include "hal_host.h"
#include "unity.h"
#include <math.h>   // sin
#include <stdio.h>  // snprintf
#include <stdlib.h> // llabs
#include <string.h> // memcpy

enum { n_bursts = 40 / fixture_rarer, most_burst = 120, n_wave = 200, mm = 1000000 };

/// Words that a tick senses, one bit each.
enum {
    wild_counts = 1u << 0,
    wild_index = 1u << 1,
    wild_n_index = 1u << 2,
    wild_edge_clock = 1u << 3,
    wild_clock = 1u << 4,
    wild_u = 1u << 5, // X and Z follow
    wild_swing = 1u << 8,
    wild_inputs = 1u << 9,
    wild_request = 1u << 10,
    n_wild = 11,
};

/// What a machine has beyond the plain skirt.
enum { rings = 1, z_measured = 2, edge_time = 4, shaft_of_lobes = 8, way_of_z = 16 };

/// A machine with its part; each reaches other code.
typedef struct {
    const char *name;
    uint32_t tick_hz;
    fixture_part_t (*part)(void);
    uint32_t has;
    uint32_t none; ///< states that it has not, a bit each
} case_t;

/// A Z that others lead is not held, and with a modulated speed there is nothing to rehearse.
enum { no_hold = 1u << cam_state_holding, no_rehearsal = 1u << cam_state_rehearsing };

static const case_t cases[] = {
    {"skirt", 20000, fixture_part_short, 0, 0},
    {"stamped", 20000, fixture_part_short, edge_time, 0},
    {"Z measured", 20000, fixture_part_short, z_measured, no_hold},
    {"rings", 20000, fixture_part_short, rings, 0},
    {"modulated", 20000, fixture_part_modulated, 0, no_rehearsal},
    {"swung", 20000, fixture_part_swung, 0, 0},
    {"way", 20000, fixture_part_short, way_of_z, 0},
    {"shaft, Z measured", 2000, fixture_part_short, shaft_of_lobes | z_measured, no_hold},
};
enum { n_cases = sizeof cases / sizeof cases[0] };

static fixture_can_t f;
static fixture_random_t dice;
static uint32_t wild; ///< words that are not true in this burst
static uint32_t hold; ///< [ticks] for which they stay
static uint32_t n_in_burst;
static uint32_t value[n_wild];
static cam_tick_record_t before; ///< of the tick before
static const char *where;

/// All that changes in a tick, to begin burst after burst in the same state.
static struct {
    cam_t cam;
    hal_host_t host;
    unsigned char can[sizeof(fixture_can_t)];
} kept;

static int64_t any(int64_t low, int64_t high)
{
    return fixture_random_range(&dice, low, high);
}

static uint32_t any_word(void)
{
    static const uint32_t extreme[] = {
        0,           1,         0x7FFFFFFFu, 0x80000000u, 0x80000001u, 0xFFFFFFFFu, 0x40000000u,
        0xC0000000u, 33554431u, 33554432u,   -33554433u,  0x01FFFFFFu, 0xFE000000u, 2097151999u,
    };
    const uint32_t n = sizeof extreme / sizeof extreme[0];
    const int64_t kind = any(0, 2);
    return kind == 0 ? (uint32_t)fixture_random_u64(&dice)
                     : extreme[any(0, n - 1)] + (kind == 1 ? 0u : (uint32_t)any(-70000, 70000));
}

/// In the place of cam_isr(): what is sensed is no longer true.
static void wild_isr(void)
{
    for (uint32_t i = 0; i < n_wild && n_in_burst % hold == 0u; i++) {
        value[i] = any_word();
    }
    hal_encoder_t *e = &hal_host.in.read;
    uint32_t request = atomic_load(&g_cam.request);
    uint32_t *words[] = {&e->counts,
                         &e->index_counts,
                         &e->n_index,
                         &e->edge_clock,
                         &hal_host.clock,
                         (uint32_t *)&hal_host.in.axis_nm[hal_axis_u],
                         (uint32_t *)&hal_host.in.axis_nm[hal_axis_x],
                         (uint32_t *)&hal_host.in.axis_nm[hal_axis_z],
                         (uint32_t *)&hal_host.in.swing_q32,
                         &hal_host.in.inputs,
                         &request};
    for (uint32_t i = 5; i < 5u + hal_n_axes; i++) { // half of all words are beyond what is sensed
        value[i] = any(0, 20) != 0 ? (uint32_t)((int32_t)value[i] / 2) : value[i];
    }
    value[9] |= any(0, 20) != 0 ? (uint32_t)hal_in_drive_ready : 0u;
    value[9] &= any(0, 20) != 0 ? ~(uint32_t)(hal_in_estop | hal_in_bus_lost) : ~0u;
    value[10] = value[10] << 8 | (uint32_t)any(0, 12);
    for (uint32_t i = 0; i < n_wild; i++) {
        *words[i] = (wild >> i & 1u) != 0u ? value[i] : *words[i];
    }
    atomic_store(&g_cam.request, request);
    n_in_burst++;
    cam_isr();
}

static void expect(bool is_good, const char *what)
{
    if (!is_good) { // every tick has dozens of them
        char text[200];
        (void)snprintf(text, sizeof text, "%s, state %s, senses 0x%X: %s", where,
                       cam_state_name(f.rig.last.want.state), (unsigned)wild, what);
        TEST_FAIL_MESSAGE(text);
    }
}

/// Held axes continue from their last commands, even at the ends of the words.
static void check_way(const cam_tick_record_t *r)
{
    const uint32_t both = r->want.outputs & before.want.outputs;
    for (uint32_t i = 0; i < hal_n_axes && (both & hal_out_enable) != 0u; i++) {
        const int64_t step_nm = (int64_t)r->out[i].pos_nm - before.out[i].pos_nm;
        const bool is_led = i == hal_axis_z && f.rig.machine.params.z_is_measured != 0;
        expect(is_led || llabs(step_nm) < INT64_C(100) * mm, "an axis jumps");
    }
    before = *r;
}

static void check(void)
{
    const cam_tick_record_t *r = &f.rig.last;
    check_way(r);
    const int32_t half_nm = f.rig.machine.params.u_stroke_nm / 2;
    const int32_t commanded_nm = r->out[hal_axis_u].pos_nm + g_cam.motion.u.home_nm;
    expect(commanded_nm >= -half_nm && commanded_nm <= half_nm,
           "U is commanded a position beyond its stroke");
    if (r->want.state == cam_state_off) {
        const int32_t *is_nm = r->in.actual_nm;
        expect(commanded_nm == cam_clamp_i32(is_nm[hal_axis_u], -half_nm, half_nm),
               "U is not commanded its measured position");
        for (uint32_t i = hal_axis_x; i <= (uint32_t)hal_axis_z; i++) {
            expect(r->out[i].pos_nm == is_nm[i], "X or Z is not commanded its measured position");
        }
    }
    expect(g_cam.spindle.in_turn >= 0 &&
               g_cam.spindle.in_turn < f.rig.machine.params.counts_per_turn,
           "the spindle is in no turn");
}

static void play_burst(void)
{
    memcpy(&g_cam, &kept.cam, sizeof g_cam);
    memcpy(&hal_host, &kept.host, sizeof hal_host);
    memcpy(&f, kept.can, offsetof(fixture_can_t, rig.image));
    memcpy(&f.can, kept.can + offsetof(fixture_can_t, can), sizeof f.can);
    wild = any(0, 2) == 0 ? 1u << any(0, n_wild - 1) : (uint32_t)any(1, (1u << n_wild) - 1);
    hold = any(0, 1) != 0 ? 1u : (uint32_t)any(1, 40);
    n_in_burst = 0;
    const uint32_t n = (uint32_t)any(1, most_burst);
    before.want.outputs = 0;
    f.rig.isr = wild_isr;
    for (uint32_t i = 0; i < n; i++) {
        fixture_can_tick(&f, i);
        check();
    }
    f.rig.isr = NULL;
}

static void set(cam_param_id_t id, int32_t to)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, id, to));
}

static void play_wave(void)
{
    static int32_t wave_nm[n_wave];
    for (int i = 0; i < n_wave; i++) {
        wave_nm[i] = (int32_t)(20000.0 * sin(6.283185307179586 * i / n_wave));
    }
    const uint8_t *bytes = (const uint8_t *)wave_nm;
    cam_machine_t *m = &f.rig.machine;
    TEST_ASSERT_TRUE_MESSAGE(fixture_rig_bring(&f.rig, cam_state_ready), where);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_set(m, cam_scope_field_place_nm, -300000));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(m, sizeof wave_nm));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_block(m, 0, bytes, sizeof wave_nm));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_end(m, cam_crc32(0, bytes, sizeof wave_nm)));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(m, 20, 100).err);
}

static void order_by_hand(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(&f.rig.machine));
    fixture_rig_ticks(&f.rig, 20);
    const hal_axis_t axis = (hal_axis_t)any(hal_axis_u, hal_axis_x); // Z may be led by others
    if (any(0, 1) != 0) {
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&f.rig.machine, axis));
    } else {
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(&f.rig.machine, axis, 1000).err);
    }
}

static void bring_to(cam_state_t state)
{
    switch (state) {
    case cam_state_fault:
        TEST_ASSERT_TRUE_MESSAGE(fixture_rig_bring(&f.rig, cam_state_cutting), where);
        hal_host_fault_estop(true);
        break;
    case cam_state_rehearsing:
        set(cam_param_rehearse_turns, 3);
        TEST_ASSERT_TRUE_MESSAGE(fixture_rig_bring(&f.rig, cam_state_rehearsing), where);
        fixture_rig_ticks(&f.rig, (uint32_t)any(0, 6000));
        break;
    case cam_state_holding:
        TEST_ASSERT_TRUE_MESSAGE(fixture_rig_bring(&f.rig, cam_state_cutting), where);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&f.rig.machine));
        break;
    case cam_state_disengaging:
        TEST_ASSERT_TRUE_MESSAGE(fixture_rig_bring(&f.rig, cam_state_cutting), where);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&f.rig.machine));
        break;
    case cam_state_identifying:
        play_wave();
        break;
    case cam_state_manual:
        order_by_hand();
        break;
    default:
        TEST_ASSERT_TRUE_MESSAGE(fixture_rig_bring(&f.rig, state), where);
        break;
    }
    (void)fixture_can_until(&f, state, true, 40000);
    fixture_can_loop(&f, (uint32_t)any(0, state == cam_state_fault ? 400 : 30));
    TEST_ASSERT_EQUAL_INT_MESSAGE(state, fixture_rig_state(), where);
}

/// The feed swings by a part of its mean over the height.
static void swinging(double z_nm, double w[3])
{
    const double k = 6.283185307179586 / mm; // of the short skirt's height
    w[0] = 0.5 * (1.0 - cos(k * z_nm)) / k;
    w[1] = 0.5 * sin(k * z_nm);
    w[2] = 0.5 * k * cos(k * z_nm);
}

static void begin(const case_t *c)
{
    fixture_part_t part = c->part();
    part.is_ring_helix = (c->has & rings) != 0u;
    part.spindle_mrpm = 1000000;
    fixture_can_init(&f, &part, c->tick_hz);
    if ((c->has & shaft_of_lobes) != 0u) {
        const fixture_shaft_t shaft = fixture_shaft_three();
        fixture_shaft_make(&f.rig.image, &shaft);
    }
    if ((c->has & way_of_z) != 0u) {
        fixture_newer_way(&f.rig.image, swinging, 15, 4);
    }
    hal_host.slow.has_edge_time = (c->has & edge_time) != 0u;
    fixture_can_start(&f);
    set(cam_param_spindle_acceleration_mrad_per_s2, 2000000000); // for the modulated speed
    set(cam_param_following_limit_nm, 1000000);
    set(cam_param_swing_speed_mdeg_per_s, 100000000);
    set(cam_param_swing_acceleration_deg_per_s2, 10000000);
    set(cam_param_z_is_measured, (c->has & z_measured) != 0u ? 1 : 0);
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        f.rig.lathe.home[i] = (ideal_home_t){.side = 1, .edge_nm = 300000, .pitch_nm = 200000};
    }
    set(cam_param_u_home, 3);
    set(cam_param_x_home, 2);
    set(cam_param_z_home, 3);
    hal_host.in.axis_nm[hal_axis_x] = 60 * mm;
    fixture_rig_ticks(&f.rig, 100);
}

static void play_state(const case_t *c, cam_state_t state)
{
    char text[80];
    (void)snprintf(text, sizeof text, "%s from %s", c->name, cam_state_name(state));
    where = text;
    begin(c);
    bring_to(state);
    memcpy(&kept.cam, &g_cam, sizeof g_cam);
    memcpy(&kept.host, &hal_host, sizeof hal_host);
    memcpy(kept.can, &f, sizeof f);
    for (uint32_t i = 0; i < n_bursts; i++) {
        play_burst();
    }
}

static void test_any_senses_in_any_state_are_defined(void)
{
    dice.state = 318;
    for (uint32_t i = 0; i < n_cases; i++) {
        for (uint32_t state = 0; state < cam_n_states; state++) {
            if ((cases[i].none >> state & 1u) == 0u) {
                play_state(&cases[i], (cam_state_t)state);
            }
        }
    }
}
