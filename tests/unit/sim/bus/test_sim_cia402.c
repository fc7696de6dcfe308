// SPDX-License-Identifier: Apache-2.0
#include "sim_cia402.h"
#include "unity.h"

/// Control words of the standard.
enum {
    disable_voltage = 0x00,
    quick_stop = 0x02,
    shutdown = 0x06,
    switch_on = 0x07,
    enable_operation = 0x0F,
    fault_reset = 0x80,
};

static sim_cia402_t drive;

void setUp(void)
{
    sim_cia402_init(&drive);
    sim_cia402_boot(&drive);
}

static void enable(void)
{
    sim_cia402_control(&drive, shutdown);
    sim_cia402_control(&drive, switch_on);
    sim_cia402_control(&drive, enable_operation);
}

/// The bits by which the standard distinguishes the states.
static void check_status(uint32_t mask, uint32_t value)
{
    TEST_ASSERT_EQUAL_HEX32(value, sim_cia402_status(&drive) & mask);
}

static void test_status_words_of_the_way_up_are_those_of_the_standard(void)
{
    sim_cia402_init(&drive);
    check_status(0x4F, 0x00);
    sim_cia402_boot(&drive);
    check_status(0x4F, 0x40);
    sim_cia402_control(&drive, shutdown);
    check_status(0x6F, 0x21);
    sim_cia402_control(&drive, switch_on);
    check_status(0x6F, 0x23);
    sim_cia402_control(&drive, enable_operation);
    check_status(0x6F, 0x27);
    TEST_ASSERT_TRUE(sim_cia402_is_following(&drive));
}

static void test_status_words_of_the_ways_out_are_those_of_the_standard(void)
{
    enable();
    sim_cia402_control(&drive, quick_stop);
    check_status(0x6F, 0x07);
    sim_cia402_fail(&drive);
    check_status(0x4F, 0x0F);
    sim_cia402_rest(&drive);
    check_status(0x4F, 0x08);
}

static void test_enable_operation_takes_one_step_per_word(void)
{
    sim_cia402_control(&drive, enable_operation);
    TEST_ASSERT_EQUAL(cia402_switch_on_disabled, drive.state);
    sim_cia402_control(&drive, shutdown);
    sim_cia402_control(&drive, enable_operation);
    TEST_ASSERT_EQUAL(cia402_switched_on, drive.state);
    sim_cia402_control(&drive, enable_operation);
    TEST_ASSERT_EQUAL(cia402_operation_enabled, drive.state);
}

static void test_ways_down_follow_the_figure(void)
{
    static const struct {
        uint32_t word;
        cia402_state_t from_operation, from_switched_on, from_ready;
    } row[] = {
        {switch_on, cia402_switched_on, cia402_switched_on, cia402_switched_on},
        {shutdown, cia402_ready_to_switch_on, cia402_ready_to_switch_on, cia402_ready_to_switch_on},
        {disable_voltage, cia402_switch_on_disabled, cia402_switch_on_disabled,
         cia402_switch_on_disabled},
        {quick_stop, cia402_quick_stop_active, cia402_switch_on_disabled,
         cia402_switch_on_disabled},
    };
    for (int i = 0; i < 4; i++) {
        drive.state = cia402_operation_enabled;
        sim_cia402_control(&drive, row[i].word);
        TEST_ASSERT_EQUAL(row[i].from_operation, drive.state);
        drive.state = cia402_switched_on;
        sim_cia402_control(&drive, row[i].word);
        TEST_ASSERT_EQUAL(row[i].from_switched_on, drive.state);
        drive.state = cia402_ready_to_switch_on;
        sim_cia402_control(&drive, row[i].word);
        TEST_ASSERT_EQUAL(row[i].from_ready, drive.state);
    }
}

static void test_quick_stop_ends_disabled_at_rest_or_in_operation_again(void)
{
    enable();
    sim_cia402_control(&drive, quick_stop);
    sim_cia402_control(&drive, enable_operation);
    TEST_ASSERT_EQUAL(cia402_operation_enabled, drive.state);
    sim_cia402_control(&drive, quick_stop);
    sim_cia402_rest(&drive);
    TEST_ASSERT_EQUAL(cia402_switch_on_disabled, drive.state);
}

static void test_fault_stays_until_reset_rises(void)
{
    enable();
    sim_cia402_control(&drive, fault_reset); // no fault: nothing
    TEST_ASSERT_EQUAL(cia402_operation_enabled, drive.state);
    sim_cia402_fail(&drive);
    sim_cia402_rest(&drive);
    sim_cia402_control(&drive, fault_reset); // still held
    TEST_ASSERT_EQUAL(cia402_fault, drive.state);
    sim_cia402_control(&drive, enable_operation);
    TEST_ASSERT_EQUAL(cia402_fault, drive.state);
    sim_cia402_control(&drive, fault_reset);
    TEST_ASSERT_EQUAL(cia402_switch_on_disabled, drive.state);
}

static void test_rest_changes_nothing_in_operation(void)
{
    enable();
    sim_cia402_rest(&drive);
    TEST_ASSERT_TRUE(sim_cia402_is_following(&drive));
}
