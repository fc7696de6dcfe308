// SPDX-License-Identifier: Apache-2.0
#include "sim_bus.h"
#include "unity.h"

/// Control words of the standard, and what else happens to a drive.
enum {
    disable_voltage = 0x00,
    quick_stop = 0x02,
    shutdown = 0x06,
    switch_on = 0x07,
    enable_operation = 0x0F,
    fault_reset = 0x80,
    it_fails = 0x10000,
    it_comes_to_rest
};

static sim_cia402_t drive;

void setUp(void)
{
    sim_cia402_init(&drive);
    sim_cia402_boot(&drive);
}

static void happen(uint32_t event)
{
    if (event == it_fails) {
        sim_cia402_fail(&drive);
    } else if (event == it_comes_to_rest) {
        sim_cia402_rest(&drive);
    } else {
        sim_cia402_control(&drive, event);
    }
}

/// The bits by which the standard distinguishes the states.
static void test_status_words_are_those_of_the_standard(void)
{
    static const struct {
        cia402_state_t state;
        uint32_t mask, value;
    } cases[] = {{cia402_switch_on_disabled, 0x4F, 0x40},
                 {cia402_ready_to_switch_on, 0x6F, 0x21},
                 {cia402_switched_on, 0x6F, 0x23},
                 {cia402_operation_enabled, 0x6F, 0x27},
                 {cia402_quick_stop_active, 0x6F, 0x07},
                 {cia402_fault_reaction_active, 0x4F, 0x0F},
                 {cia402_fault, 0x4F, 0x08}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        drive.state = cases[i].state;
        TEST_ASSERT_EQUAL_HEX32(cases[i].value, sim_cia402_status(&drive) & cases[i].mask);
        TEST_ASSERT_EQUAL(cases[i].state == cia402_operation_enabled,
                          sim_cia402_is_following(&drive));
    }
    sim_cia402_init(&drive);
    TEST_ASSERT_EQUAL_HEX32(0x00, sim_cia402_status(&drive) & 0x4Fu);
    sim_cia402_boot(&drive);
    TEST_ASSERT_EQUAL(cia402_switch_on_disabled, drive.state);
}

/// Enabling takes one step for each word; a quick stop ends disabled at rest or in operation again.
static void test_transitions_follow_the_figure(void)
{
    static const struct {
        cia402_state_t from;
        uint32_t event;
        cia402_state_t to;
    } cases[] = {
        {cia402_switch_on_disabled, enable_operation, cia402_switch_on_disabled},
        {cia402_switch_on_disabled, shutdown, cia402_ready_to_switch_on},
        {cia402_ready_to_switch_on, enable_operation, cia402_switched_on},
        {cia402_ready_to_switch_on, switch_on, cia402_switched_on},
        {cia402_ready_to_switch_on, shutdown, cia402_ready_to_switch_on},
        {cia402_ready_to_switch_on, disable_voltage, cia402_switch_on_disabled},
        {cia402_ready_to_switch_on, quick_stop, cia402_switch_on_disabled},
        {cia402_switched_on, enable_operation, cia402_operation_enabled},
        {cia402_switched_on, switch_on, cia402_switched_on},
        {cia402_switched_on, shutdown, cia402_ready_to_switch_on},
        {cia402_switched_on, disable_voltage, cia402_switch_on_disabled},
        {cia402_switched_on, quick_stop, cia402_switch_on_disabled},
        {cia402_operation_enabled, switch_on, cia402_switched_on},
        {cia402_operation_enabled, shutdown, cia402_ready_to_switch_on},
        {cia402_operation_enabled, disable_voltage, cia402_switch_on_disabled},
        {cia402_operation_enabled, quick_stop, cia402_quick_stop_active},
        {cia402_operation_enabled, fault_reset, cia402_operation_enabled},
        {cia402_operation_enabled, it_comes_to_rest, cia402_operation_enabled},
        {cia402_operation_enabled, it_fails, cia402_fault_reaction_active},
        {cia402_quick_stop_active, enable_operation, cia402_operation_enabled},
        {cia402_quick_stop_active, it_comes_to_rest, cia402_switch_on_disabled},
        {cia402_fault_reaction_active, it_comes_to_rest, cia402_fault},
        {cia402_fault, it_fails, cia402_fault},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        drive.state = cases[i].from;
        happen(cases[i].event);
        TEST_ASSERT_EQUAL(cases[i].to, drive.state);
    }
}

static void test_fault_stays_until_reset_rises(void)
{
    static const uint32_t events[] = {it_fails,    it_comes_to_rest, fault_reset,
                                      fault_reset, enable_operation, fault_reset};
    static const cia402_state_t states[] = {cia402_fault_reaction_active,
                                            cia402_fault,
                                            cia402_fault, // reset is held since before
                                            cia402_fault,
                                            cia402_fault,
                                            cia402_switch_on_disabled};
    drive.state = cia402_operation_enabled;
    happen(fault_reset); // no fault: nothing
    for (uint32_t i = 0; i < sizeof events / sizeof events[0]; i++) {
        happen(events[i]);
        TEST_ASSERT_EQUAL(states[i], drive.state);
    }
}
