// SPDX-License-Identifier: Apache-2.0
#include "hal_host.h" // hal_host
#include "sim_port.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <string.h> // strstr

static sim_inject_t inject;
static common_error_t error;
static sim_port_t port;

void setUp(void)
{
    const sim_lathe_config_t config = sim_lathe_defaults();
    sim_port_init(&port, &config, 50e6, 0.0, 1);
    sim_port_sense(&port);
}

static void refused(const char *text, const char *why)
{
    TEST_ASSERT_FALSE_MESSAGE(sim_inject_parse(&inject, text, sim_inject_in_run, &error), text);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, why), error.text);
}

static void happen(const char *text)
{
    TEST_ASSERT_TRUE_MESSAGE(sim_inject_parse(&inject, text, sim_inject_in_run, &error),
                             error.text);
    sim_port_inject(&port, &inject, -1);
}

/// A run has an operator of its own, and no button: what presses nothing is refused.
static void test_only_the_live_lathe_has_a_button_and_a_key(void)
{
    static const char *const texts[] = {"acknowledge@1:0.5", "key@t2:1"};
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_FALSE(sim_inject_parse(&inject, texts[i], sim_inject_in_run, &error));
        TEST_ASSERT_NOT_NULL(strstr(error.text, "cannot happen here; camsim run --help"));
        TEST_ASSERT_FALSE(sim_inject_parse(&inject, texts[i], sim_inject_on_bus, &error));
        TEST_ASSERT_NOT_NULL(strstr(error.text, "camsim bus --help"));
        TEST_ASSERT_TRUE(sim_inject_parse(&inject, texts[i], sim_inject_in_live, &error));
    }
    TEST_ASSERT_TRUE(sim_inject_parse(&inject, "late-tick@1:50", sim_inject_in_live, &error));
    TEST_ASSERT_TRUE(sim_inject_parse(&inject, "estop@1", sim_inject_in_live, &error));
    TEST_ASSERT_FALSE(sim_inject_parse(&inject, "node-dead@1:2", sim_inject_in_live, &error));
    TEST_ASSERT_NOT_NULL(strstr(error.text, "camsim live --help"));
}

static void test_parse_takes_kind_time_and_value(void)
{
    TEST_ASSERT_TRUE(sim_inject_parse(&inject, "lost-counts@1.5:30", sim_inject_in_run, &error));
    TEST_ASSERT_EQUAL_INT(sim_inject_lost_counts, inject.kind);
    TEST_ASSERT_TRUE(inject.at_s == 1.5 && inject.value == 30.0 && !inject.is_absolute);
    TEST_ASSERT_TRUE(sim_inject_parse(&inject, "estop@t0.25", sim_inject_in_run, &error));
    TEST_ASSERT_TRUE(inject.at_s == 0.25 && inject.is_absolute);
}

static void test_parse_refuses_what_is_wrong(void)
{
    refused("estop", "no @SECONDS");
    refused("fire@1", "no such kind");
    refused("estop@", "no time");
    refused("estop@-1", "no time");
    refused("estop@nan", "no time");
    refused("estop@tt1", "no time");
    refused("estop@1:2", "takes no value");
    refused("lost-counts@1", "takes counts");
    refused("lost-counts@1:", "takes counts");
    refused("lost-counts@1:1.5", "takes counts");
    refused("spindle-speed@1:inf", "takes r/min");
    refused("late-tick@1:0", "takes percent");
}

static void test_apply_reaches_the_port(void)
{
    happen("estop@0");
    happen("drive@0");
    happen("bus@0");
    TEST_ASSERT_EQUAL_HEX32(hal_in_estop | hal_in_bus_lost, hal_host.in.inputs);
    happen("late-tick@0:80");
    TEST_ASSERT_EQUAL_UINT32(8000u, hal_host.late_clocks);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 40e-6, port.late_s);
}

static void test_apply_reaches_the_clock(void)
{
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
    happen("encoder-stuck@0");
    TEST_ASSERT_EQUAL_UINT32(counts + 200u + 2u, read_on().counts);
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
