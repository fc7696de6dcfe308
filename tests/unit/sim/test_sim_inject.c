// SPDX-License-Identifier: Apache-2.0
#include "hal_host.h" // hal_host
#include "sim_inject.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <string.h> // strstr

static sim_inject_t inject;
static sim_error_t error;
static sim_machine_t machine;

void setUp(void)
{
    const sim_machine_config_t config = sim_machine_defaults();
    sim_machine_init(&machine, &config, 50e6, 0.0, 1);
}

void tearDown(void) {}

static void refused(const char *text, const char *why)
{
    TEST_ASSERT_FALSE_MESSAGE(sim_inject_parse(&inject, text, sim_inject_in_run, &error), text);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, why), error.text);
}

static void happen(const char *text)
{
    TEST_ASSERT_TRUE_MESSAGE(sim_inject_parse(&inject, text, sim_inject_in_run, &error),
                             error.text);
    sim_inject_apply(&inject, &machine, -1);
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
    refused("lost-counts@1", "wants counts");
    refused("lost-counts@1:", "wants counts");
    refused("lost-counts@1:1.5", "wants counts");
    refused("spindle-speed@1:inf", "wants r/min");
    refused("late-tick@1:0", "wants percent");
}

static void test_apply_reaches_the_port(void)
{
    happen("estop@0");
    happen("drive@0");
    happen("bus@0");
    TEST_ASSERT_EQUAL_HEX32(hal_in_estop | hal_in_bus_lost, hal_host.in.inputs);
    happen("lost-counts@0:7");
    TEST_ASSERT_EQUAL_UINT32((uint32_t)-7, hal_host.fault.count_offset);
    happen("encoder-jump@0:9");
    TEST_ASSERT_EQUAL_UINT32(2u, hal_host.fault.count_offset);
    happen("encoder-stuck@0");
    happen("index-dead@0");
    TEST_ASSERT_TRUE(hal_host.fault.is_encoder_stuck && hal_host.fault.is_index_dead);
    happen("late-tick@0:80");
    TEST_ASSERT_EQUAL_UINT32(8000u, hal_host.late_clocks);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 40e-6, machine.late_s);
}

static void test_apply_reaches_the_machine(void)
{
    happen("z-offset@0:-0.5");
    TEST_ASSERT_EQUAL_INT32(-500000, machine.z_offset_nm);
    happen("u-block@0");
    TEST_ASSERT_TRUE(machine.axis[hal_axis_u].is_blocked);
    happen("spindle-speed@0:60");
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -SIM_TWO_PI,
                              machine.forced_rad_per_s); // sense of cutting is -1
    happen("spindle-stop@0");
    TEST_ASSERT_TRUE(machine.is_speed_forced && machine.forced_rad_per_s == 0.0);
    happen("reverse@0");
    TEST_ASSERT_TRUE(machine.is_reversed);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_parse_takes_kind_time_and_value);
    RUN_TEST(test_parse_refuses_what_is_wrong);
    RUN_TEST(test_apply_reaches_the_port);
    RUN_TEST(test_apply_reaches_the_machine);
    return UNITY_END();
}
