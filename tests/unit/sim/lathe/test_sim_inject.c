// SPDX-License-Identifier: Apache-2.0
#include "hal_host.h" // hal_host
#include "sim_config.h"
#include "sim_port.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <string.h> // strstr

static sim_inject_t inject;
static common_error_t error;
static sim_port_t port;

void setUp(void)
{
    const sim_lathe_config_t config = sim_config_defaults().lathe;
    sim_port_init(&port, &config, 50e6, 0.0, 1);
    sim_port_sense(&port);
}

static bool parse(const char *text, uint32_t where)
{
    error.text[0] = '\0';
    return sim_inject_parse(&inject, text, where, &error);
}

static void happen(const char *text)
{
    TEST_ASSERT_TRUE_MESSAGE(parse(text, sim_inject_in_run), error.text);
    sim_port_inject(&port, &inject, -1);
}

static void test_parse_takes_kind_time_and_value(void)
{
    TEST_ASSERT_TRUE(parse("lost-counts@1.5:30", sim_inject_in_run));
    TEST_ASSERT_EQUAL_INT(sim_inject_lost_counts, inject.kind);
    TEST_ASSERT_TRUE(inject.at_s == 1.5 && inject.value == 30.0 && !inject.is_absolute);
    TEST_ASSERT_TRUE(parse("estop@t0.25", sim_inject_in_live));
    TEST_ASSERT_TRUE(inject.at_s == 0.25 && inject.is_absolute);
    TEST_ASSERT_TRUE(parse("late-tick@1:50", sim_inject_in_live));
    TEST_ASSERT_TRUE(parse("acknowledge@1:0.5", sim_inject_in_live));
    TEST_ASSERT_TRUE(parse("key@t2:1", sim_inject_in_live));
}

/// A run has an operator of its own, and no button and key.
static void test_parse_refuses_what_is_wrong(void)
{
    static const struct {
        uint32_t where;
        const char *text, *why;
    } rows[] = {
        {sim_inject_in_run, "estop", "no @SECONDS"},
        {sim_inject_in_run, "fire@1", "no such kind"},
        {sim_inject_in_run, "estop@", "no time"},
        {sim_inject_in_run, "estop@-1", "no time"},
        {sim_inject_in_run, "estop@nan", "no time"},
        {sim_inject_in_run, "estop@tt1", "no time"},
        {sim_inject_in_run, "estop@1:2", "takes no value"},
        {sim_inject_in_run, "lost-counts@1", "takes counts"},
        {sim_inject_in_run, "lost-counts@1:", "takes counts"},
        {sim_inject_in_run, "lost-counts@1:1.5", "takes counts"},
        {sim_inject_in_run, "spindle-speed@1:inf", "takes r/min"},
        {sim_inject_in_run, "late-tick@1:0", "takes percent"},
        {sim_inject_in_run, "acknowledge@1:0.5", "cannot happen here; camsim run --help"},
        {sim_inject_in_run, "key@t2:1", "cannot happen here; camsim run --help"},
        {sim_inject_on_bus, "acknowledge@1:0.5", "camsim bus --help"},
        {sim_inject_on_bus, "key@t2:1", "camsim bus --help"},
        {sim_inject_in_live, "node-dead@1:2", "camsim live --help"},
    };
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        TEST_ASSERT_FALSE_MESSAGE(parse(rows[i].text, rows[i].where), rows[i].text);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, rows[i].why), error.text);
    }
}

static void test_apply_reaches_port_and_clock(void)
{
    happen("estop@0");
    happen("drive@0");
    happen("bus@0");
    TEST_ASSERT_EQUAL_HEX32(hal_in_estop | hal_in_bus_lost, hal_host.in.inputs);
    happen("late-tick@0:80");
    TEST_ASSERT_EQUAL_UINT32(8000u, hal_host.late_clocks);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 40e-6, port.late_s);
    happen("clock-drift@0:-1000");
    happen("tick-jitter@0:40");
    happen("tick-burst@0:30");
    happen("tick-twice@0:5");
    TEST_ASSERT_TRUE(port.clock.drift == -1e-3 && port.clock.jitter == 0.4);
    TEST_ASSERT_TRUE(port.clock.burst == 0.3 && port.clock.twice == 0.05);
}

/// @return the encoder's reading a hundredth of a turn further on
static hal_encoder_t read_on(void)
{
    port.lathe.spindle.turn += 0.01; // 100 counts
    return sim_lathe_encoder(&port.lathe);
}

static void test_apply_reaches_the_encoder(void)
{
    const uint32_t counts = sim_lathe_encoder(&port.lathe).counts;
    happen("lost-counts@0:7");
    TEST_ASSERT_EQUAL_UINT32(counts + 100u - 7u, read_on().counts);
    happen("encoder-jump@0:9");
    TEST_ASSERT_EQUAL_UINT32(counts + 200u + 2u, read_on().counts);
    happen("encoder-rate@0:-50");
    TEST_ASSERT_EQUAL_UINT32(counts + 252u, read_on().counts);
    happen("encoder-rate@0:100");
    TEST_ASSERT_EQUAL_UINT32(counts + 452u, read_on().counts);
    happen("encoder-stuck@0");
    TEST_ASSERT_EQUAL_UINT32(counts + 452u, read_on().counts);
    happen("encoder-dither@0:1");
    const uint32_t even = read_on().counts + read_on().counts; // it stands and stands a count on
    TEST_ASSERT_EQUAL_UINT32(2u * (counts + 452u) + 1u, even);
}

static void test_index_copies_the_counter_with_its_faults_until_it_dies(void)
{
    port.lathe.spindle.turn = 1.29; // the index lies at 0.3
    (void)sim_lathe_encoder(&port.lathe);
    happen("encoder-jump@0:9");
    const hal_encoder_t before = read_on();
    const hal_encoder_t behind = read_on();
    TEST_ASSERT_EQUAL_UINT32(before.n_index, behind.n_index);
    TEST_ASSERT_EQUAL_UINT32(4294467296u + 13000u + 9u, behind.index_counts);
    happen("index-dead@0");
    port.lathe.spindle.turn = 2.31;
    const hal_encoder_t dead = sim_lathe_encoder(&port.lathe);
    TEST_ASSERT_EQUAL_UINT32(behind.n_index, dead.n_index);
    TEST_ASSERT_EQUAL_UINT32(behind.index_counts, dead.index_counts);
}

static void test_apply_reaches_the_lathe(void)
{
    happen("z-offset@0:-0.5");
    sim_port_sense(&port);
    TEST_ASSERT_EQUAL_INT32(-500000, hal_host.in.axis_nm[hal_axis_z]);
    happen("u-block@0");
    TEST_ASSERT_TRUE(port.lathe.drive[hal_axis_u].is_blocked);
    happen("swing-block@0");
    TEST_ASSERT_TRUE(port.lathe.drive[sim_lathe_swing].is_blocked);
    happen("spindle-speed@0:60");
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -SIM_TWO_PI,
                              port.lathe.forced_rad_per_s); // sense of cutting is -1
    happen("spindle-stop@0");
    TEST_ASSERT_TRUE(port.lathe.is_speed_forced && port.lathe.forced_rad_per_s == 0.0);
    happen("reverse@0");
    TEST_ASSERT_TRUE(port.lathe.is_reversed);
}
