// SPDX-License-Identifier: Apache-2.0
// Who commands, and the level: pure, in ticks of 1 kHz.
#include "cam_param.h"
#include "unity.h"

enum { hz = 1000 };

static cam_rights_t r;

static void begin(bool has_key)
{
    const hal_operator_t port = {.has_key = has_key};
    cam_rights_init(&r, &port, hz);
    r.is_bus_calling = true;
}

void setUp(void)
{
    begin(true);
}

static void take(uint8_t sender, uint32_t tick)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_rights_take(&r, sender, false, tick));
}

static void test_the_first_to_take_has_command_until_it_is_taken_over(void)
{
    static const struct {
        uint8_t sender;
        bool takes_over;
        cam_err_t err;
        uint8_t commander, session, n_take_overs;
    } steps[] = {
        {0, true, cam_err_frame, 0, 0, 0},
        {255, true, cam_err_frame, 0, 0, 0},
        {12, false, cam_ok, 12, 1, 0},
        {9, false, cam_err_not_commander, 12, 1, 0},
        {12, false, cam_err_not_commander, 12, 1, 0},
        {9, true, cam_ok, 9, 2, 1},
        {254, true, cam_ok, 254, 3, 2},
    };
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        TEST_ASSERT_EQUAL_INT(steps[i].err,
                              cam_rights_take(&r, steps[i].sender, steps[i].takes_over, 0));
        for (uint32_t k = 0; k < 256u * 4u; k++) {
            const uint8_t sender = (uint8_t)(k / 4u), s = (uint8_t)(k % 4u);
            const bool is_it =
                steps[i].commander != 0u && sender == steps[i].commander && s == steps[i].session;
            TEST_ASSERT_EQUAL(is_it, cam_rights_is_commander(&r, sender, s));
        }
        TEST_ASSERT_EQUAL_UINT32(steps[i].n_take_overs, r.n_take_overs);
    }
}

static void test_a_session_is_never_0_and_not_the_last_one(void)
{
    uint8_t last = 0;
    for (int i = 0; i < 600; i++) {
        take(1, 0);
        TEST_ASSERT_NOT_EQUAL(0, r.session);
        TEST_ASSERT_NOT_EQUAL(last, r.session);
        last = r.session;
        cam_rights_release(&r);
    }
}

/// While nobody commands there is no loss.
static void test_command_is_lost_after_a_second_of_silence(void)
{
    const uint32_t from = 0xFFFFFF00u; // the ticks wrap
    TEST_ASSERT_FALSE(cam_rights_poll(&r, 0, from));
    take(12, from);
    TEST_ASSERT_FALSE(cam_rights_poll(&r, 0, from + hz));
    cam_rights_hear(&r, from + hz);
    TEST_ASSERT_FALSE(cam_rights_poll(&r, 0, from + 2u * hz));
    TEST_ASSERT_TRUE(cam_rights_poll(&r, 0, from + 2u * hz + 1u));
    TEST_ASSERT_FALSE(cam_rights_poll(&r, 0, from + 4u * hz));
    TEST_ASSERT_FALSE(cam_rights_is_commander(&r, 12, 1));
    TEST_ASSERT_EQUAL_UINT32(1, r.n_losses);
    take(9, 0); // anybody may take it
    TEST_ASSERT_EQUAL_UINT32(0, r.n_take_overs);
    cam_rights_release(&r);
    TEST_ASSERT_FALSE(cam_rights_poll(&r, 0, 100u * hz));
    TEST_ASSERT_EQUAL_UINT32(1, r.n_losses);
}

static void test_a_key_unlocks_for_who_has_command_when_it_is_turned_on(void)
{
    (void)cam_rights_poll(&r, hal_in_key, 0);
    TEST_ASSERT_EQUAL_INT(cam_level_locked, r.level); // nobody commands
    (void)cam_rights_poll(&r, 0, 1);
    take(12, 1);
    TEST_ASSERT_EQUAL_INT(cam_err_locked, cam_rights_check_level(&r));
    (void)cam_rights_poll(&r, hal_in_key, 2);
    TEST_ASSERT_EQUAL_INT(cam_level_key, r.level);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_rights_check_level(&r));
    (void)cam_rights_poll(&r, 0, 3);
    TEST_ASSERT_EQUAL_INT(cam_err_locked, cam_rights_check_level(&r));
}

/// The key is turned off and on again.
static void turn_anew(uint32_t tick)
{
    (void)cam_rights_poll(&r, 0, tick);
    (void)cam_rights_poll(&r, hal_in_key, tick);
}

static void expect_locked_until_the_key_is_turned(uint32_t tick)
{
    (void)cam_rights_poll(&r, hal_in_key, tick);
    TEST_ASSERT_EQUAL_INT(cam_level_locked, r.level);
    TEST_ASSERT_EQUAL_INT(cam_err_locked, cam_rights_check_level(&r));
    turn_anew(tick);
    TEST_ASSERT_EQUAL_INT(cam_level_key, r.level);
}

/// Whoever takes command, takes it over, or has it after a loss, finds it locked: the setter who
/// left the key on did not unlock for him. Neither did one who left it on at power-on, or who
/// turned it while nobody had command.
static void test_a_key_that_was_left_on_unlocks_nobody(void)
{
    take(12, 0); // before the first look at the key
    expect_locked_until_the_key_is_turned(0);
    cam_rights_lock(&r);
    expect_locked_until_the_key_is_turned(1); // lock holds until then as well
    cam_rights_release(&r);
    turn_anew(2);
    take(9, 2);
    expect_locked_until_the_key_is_turned(2);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_rights_take(&r, 12, true, 3));
    expect_locked_until_the_key_is_turned(3);
    TEST_ASSERT_TRUE(cam_rights_poll(&r, hal_in_key, 4u + hz));
    take(9, 4u + hz);
    expect_locked_until_the_key_is_turned(4u + hz);
}

static void test_the_level_ends_with_command(void)
{
    take(12, 0);
    turn_anew(0);
    TEST_ASSERT_EQUAL_INT(cam_level_key, r.level);
    TEST_ASSERT_TRUE(cam_rights_poll(&r, hal_in_key, hz + 1u)); // lost
    TEST_ASSERT_EQUAL_INT(cam_level_locked, r.level);
    take(12, hz + 1u);
    turn_anew(hz + 2u);
    TEST_ASSERT_EQUAL_INT(cam_level_key, r.level);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_rights_take(&r, 9, true, hz + 2u));
    TEST_ASSERT_EQUAL_INT(cam_level_locked, r.level);
}

/// The seconds that are left are rounded up, never below 0, and none of a locked machine.
static void test_the_level_ends_after_ten_minutes(void)
{
    static const uint32_t left[][2] = {
        {5, 600}, {600u * hz, 1}, {4u + 600u * hz, 1}, {6u + 600u * hz, 0}};
    take(12, 0);
    TEST_ASSERT_EQUAL_UINT32(0, cam_rights_level_left_s(&r, 1));
    turn_anew(5);
    for (uint32_t i = 0; i < 4u; i++) { // not polled since
        TEST_ASSERT_EQUAL_UINT32(left[i][1], cam_rights_level_left_s(&r, left[i][0]));
    }
    cam_rights_hear(&r, 600u * hz);
    (void)cam_rights_poll(&r, hal_in_key, 5u + 600u * hz);
    TEST_ASSERT_EQUAL_INT(cam_level_key, r.level);
    (void)cam_rights_poll(&r, hal_in_key, 6u + 600u * hz);
    TEST_ASSERT_EQUAL_INT(cam_level_locked, r.level);
    TEST_ASSERT_EQUAL_UINT32(0, cam_rights_level_left_s(&r, 6u + 600u * hz));
}

/// A program that calls the machine itself is unlocked.
static void test_a_port_without_a_key_is_locked_for_good(void)
{
    begin(false);
    take(12, 0);
    turn_anew(1);
    TEST_ASSERT_EQUAL_INT(cam_err_lock_none, cam_rights_check_level(&r));
    r.is_bus_calling = false;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_rights_check_level(&r));
}
