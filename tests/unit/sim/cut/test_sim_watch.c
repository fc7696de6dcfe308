// SPDX-License-Identifier: Apache-2.0
// A cut on a bus without wires: the link of this program hands over the frames of a scripted
// controller, one period after the other.
#include "cam_state.h" // cam_state_cutting
#include "canopen.h"   // canopen_id_sync
#include "fixture_image.h"
#include "sim_watch.h"
#include "unity.h"
#include <string.h> // memset

enum { cut_begin = 300, cut_end = 600 }; ///< periods of 1 ms
enum { word_shutdown = 0x06, word_switch_on = 0x07, word_enable = 0x0F };

static fixture_image_t image;
static sim_watch_options_t options;
static sim_watch_t watch;
static common_error_t error;
static int period, gone_at, fault_at;
static bool is_signalled;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_image_make(&image, &part);
    options = (sim_watch_options_t){
        .session = {.config = sim_config_defaults(), .max_s = 5.0, .tolerance_um = 1e6, .seed = 1},
        .tick_hz = 1000.0,
        .guard_ms = 20.0,
        .heartbeat_ms = 50.0,
    };
    period = 0;
    gone_at = fault_at = 1000000;
    is_signalled = false;
}

void tearDown(void)
{
    sim_watch_close(&watch);
}

static void send(sim_bus_t *bus, uint32_t id, uint32_t word, int32_t target)
{
    sim_frame_t frame = {.id = id};
    sim_frame_put(&frame, word, 2);
    sim_frame_put(&frame, (uint32_t)target, 4);
    sim_bus_receive(bus, &frame);
}

/// Send what a controller sends in a period: set-points, its status, SYNC.
static void control(sim_bus_t *bus)
{
    const bool is_fault = period > fault_at;
    const uint32_t word = period < 20   ? word_shutdown
                          : period < 30 ? word_switch_on
                          : is_fault    ? word_shutdown
                                        : word_enable;
    const bool is_turning = period < cut_end && !is_fault;
    const bool is_cutting = period >= cut_begin && is_turning;
    const cam_state_t state = is_fault     ? cam_state_fault
                              : is_cutting ? cam_state_cutting
                                           : cam_state_ready;
    sim_frame_t status = {.id = 0x1C0};
    sim_frame_put(&status, (uint32_t)state, 4);
    sim_frame_put(&status, is_fault ? 1u : 0u, 4);
    const sim_frame_t start = {.n = 2, .data = {canopen_start, 0}};
    sim_bus_receive(bus, &start);
    for (uint32_t axis = 0; axis < (uint32_t)hal_n_axes; axis++) {
        const double at_nm = bus->lathe.drive[axis].pos_micro;
        send(bus, canopen_id_rpdo1 + 2u + axis, word, (int32_t)at_nm);
    }
    send(bus, canopen_id_rpdo1 + 5u, word, is_turning ? 300000 : 0);
    sim_bus_receive(bus, &status);
    sim_bus_receive(bus, &(sim_frame_t){.id = canopen_id_sync});
}

bool sim_link_open(sim_link_t *l, const char *interface, const char *chip, double period_s,
                   common_error_t *e)
{
    (void)interface;
    (void)chip;
    (void)e;
    *l = sim_link_closed();
    l->period_ns = (int64_t)(period_s * 1e9);
    return true;
}

void sim_link_wait(sim_link_t *l, sim_bus_t *bus)
{
    (void)l;
    period++;
    if (period < gone_at) {
        control(bus);
    }
}

sim_bus_outputs_t sim_link_read(const sim_link_t *l)
{
    (void)l;
    return (sim_bus_outputs_t){.is_enabled = false};
}

void sim_link_send(sim_link_t *l, sim_bus_t *bus)
{
    (void)l;
    (void)bus;
}

void sim_link_close(sim_link_t *l)
{
    *l = sim_link_closed();
}

void sim_link_watch_signals(void) {}

bool sim_link_is_stopped(void)
{
    return is_signalled && period > cut_begin;
}

/// Watch until the end, which must be this one.
static void expect_end(const char *name, bool is_good)
{
    memset(&watch, 0, sizeof watch);
    TEST_ASSERT_TRUE_MESSAGE(
        sim_watch_open(&watch, &options, image.bytes, image.size, "short.camtab", &error),
        error.text);
    TEST_ASSERT_TRUE_MESSAGE(sim_watch_connect(&watch, &error), error.text);
    while (watch.end == sim_watch_running && period < 10000) {
        sim_watch_tick(&watch);
    }
    TEST_ASSERT_EQUAL_STRING(name, sim_watch_end_name(&watch));
    TEST_ASSERT_EQUAL(is_good, sim_watch_is_good(&watch));
}

static void test_cut_is_done_when_the_controller_is_ready_again(void)
{
    expect_end("done", true);
    TEST_ASSERT_EQUAL_STRING("ready", sim_watch_state(&watch));
    TEST_ASSERT_DOUBLE_WITHIN(0.002, 0.3, watch.session.cut_s);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 0.3 * 5.0, watch.session.cut_turns); // 300 r/min
    TEST_ASSERT_EQUAL_UINT64(watch.session.n_following, watch.session.work.n);
}

static void test_fault_ends_when_all_rests(void)
{
    fault_at = 400;
    expect_end("fault", false);
    TEST_ASSERT_EQUAL_HEX32(1u, watch.faults);
    TEST_ASSERT_DOUBLE_WITHIN(0.003, 0.4, watch.fault_s);
    TEST_ASSERT_TRUE(watch.stopped_s > watch.fault_s);
}

/// A controller without SYNC is lost. An injection reaches the nodes meanwhile.
static void test_controller_without_sync_is_lost(void)
{
    TEST_ASSERT_TRUE(sim_inject_parse(&options.session.inject[options.session.n_injects++],
                                      "u-block@0.05", sim_inject_on_bus, &error));
    gone_at = 400;
    expect_end("lost", false);
    TEST_ASSERT_TRUE(watch.bus.lathe.drive[hal_axis_u].is_blocked);
}

static void test_time_and_signals_end_it(void)
{
    options.is_staying = true;
    expect_end("timeout", false);
    sim_watch_close(&watch);
    period = 0;
    is_signalled = true;
    expect_end("stopped", true);
}
