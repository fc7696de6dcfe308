// SPDX-License-Identifier: Apache-2.0
// How long a cut on a bus without wires is watched. tests/linux has a controller on a bus, whose
// cuts are done, end in a fault or are lost.
#include "fixture_image.h"
#include "sim_watch.h"
#include "unity.h"
#include <string.h> // memset

static fixture_image_t image;
static sim_watch_t watch;
static common_error_t error;
static int period, signalled_at;

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
    (void)bus;
    period++;
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
    return period == signalled_at;
}

/// Watch for a tenth of a second of 1 ms periods. The end must be this one, after so many.
static void expect_end(const char *name, bool is_good, int n_periods)
{
    const fixture_part_t part = fixture_part_short();
    const sim_watch_options_t options = {
        .session = {.config = sim_config_defaults(), .max_s = 0.1, .seed = 1},
        .tick_hz = 1000.0,
        .guard_ms = 20.0,
        .heartbeat_ms = 50.0};
    period = 0;
    memset(&watch, 0, sizeof watch);
    fixture_image_make(&image, &part);
    TEST_ASSERT_TRUE_MESSAGE(
        sim_watch_open(&watch, &options, image.bytes, image.size, "short.camtab", &error),
        error.text);
    TEST_ASSERT_TRUE_MESSAGE(sim_watch_connect(&watch, &error), error.text);
    while (watch.end == sim_watch_running && period < 10000) {
        sim_watch_tick(&watch);
    }
    TEST_ASSERT_EQUAL_STRING(name, sim_watch_end_name(&watch));
    TEST_ASSERT_EQUAL_STRING("-", sim_watch_state(&watch)); // no controller was heard
    TEST_ASSERT_EQUAL(is_good, sim_watch_is_good(&watch));
    TEST_ASSERT_INT_WITHIN(1, n_periods, period);
    sim_watch_close(&watch);
}

static void test_time_and_signals_end_it(void)
{
    expect_end("timeout", false, 101);
    signalled_at = 60;
    expect_end("stopped", true, 60);
}
