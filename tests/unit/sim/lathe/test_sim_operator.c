// SPDX-License-Identifier: Apache-2.0
// Somebody at the simulated machine: when he presses the button, and when he turns the key.
#include "sim_inject.h"
#include "unity.h"

static sim_operator_t o;

void setUp(void)
{
    o = (sim_operator_t){.is_present = true, .is_key_on = true, .turns_key = true};
}

static void test_he_presses_for_a_fifth_of_a_second_and_again_where_that_did_not_do(void)
{
    int n_pressed = 0;
    for (int i = 0; i < 1000; i++) {
        const bool is_pressed = sim_operator_step(&o, true, i * 1e-3);
        TEST_ASSERT_TRUE(!is_pressed || i % 500 >= 299);
        n_pressed += is_pressed ? 1 : 0;
    }
    TEST_ASSERT_INT_WITHIN(4, 400, n_pressed);
}

static void test_who_is_not_there_presses_only_what_is_typed(void)
{
    o.is_present = false;
    for (int i = 0; i < 1000; i++) {
        TEST_ASSERT_FALSE(sim_operator_step(&o, true, i * 1e-3));
    }
    sim_operator_press(&o, 1.0, 0.5);
    TEST_ASSERT_TRUE(sim_operator_step(&o, true, 1.49));
    TEST_ASSERT_FALSE(sim_operator_step(&o, true, 1.51));
}

static void test_the_key_is_off_for_one_look_where_a_session_is_new(void)
{
    static const struct {
        uint32_t session;
        bool is_on;
    } looks[] = {{0, true},  {7, false}, {7, true}, {0, true}, // given up
                 {8, false}, {9, false}, {9, true}};           // taken over
    for (uint32_t i = 0; i < sizeof looks / sizeof looks[0]; i++) {
        TEST_ASSERT_EQUAL(looks[i].is_on, sim_operator_key(&o, looks[i].session));
    }
    o.turns_key = false; // nobody turns it
    TEST_ASSERT_TRUE(sim_operator_key(&o, 7));
    o.is_key_on = false;
    TEST_ASSERT_FALSE(sim_operator_key(&o, 7));
}
