// SPDX-License-Identifier: Apache-2.0
// Single bits of the controller's own state flip in the cut: each is seen by its check, and the
// tool retracts; a configuration that was changed is not copied and is made anew in off.
#include "cam_scrub.h"
#include "cam_seal.h"
#include "rig_bench.h"
#include <stddef.h> // offsetof
#include <string.h> // memcpy

enum { plan_ticks = 8, a_round = 40 };

/// Tick, and poll as a main loop does, until a fault comes. @return ticks, `most` when none came
static uint32_t ticks_until_fault(uint32_t most)
{
    uint32_t n = 0;
    while (n < most && fixture_rig_state() != cam_state_fault) {
        fixture_rig_tick(&rig);
        cam_machine_poll(&rig.machine);
        n++;
    }
    return n;
}

static void polls(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        cam_machine_poll(&rig.machine);
    }
}

static void test_seal_sees_every_single_bit(void)
{
    uint32_t words[37];
    for (uint32_t i = 0; i < 37u; i++) {
        words[i] = i * 2654435761u;
    }
    const uint32_t sum = cam_seal_more(0, words, 37);
    for (uint32_t bit = 0; bit < 37u * 32u; bit++) {
        flip(words, bit);
        TEST_ASSERT_NOT_EQUAL_UINT32(sum, cam_seal_more(0, words, 37));
        flip(words, bit);
    }
    TEST_ASSERT_EQUAL_HEX32(sum, cam_seal_more(cam_seal_more(0, words, 10), &words[10], 27));
}

static void test_pointer_to_the_configuration_is_mended(void)
{
    for (uint32_t bit = 0; bit < 32u; bit++) {
        cut_anew();
        const cam_config_t *in_use = g_cam.config.in_use;
        uintptr_t at = (uintptr_t)in_use ^ (uintptr_t)1u << bit;
        memcpy((void *)&g_cam.config.offered, &at, sizeof at);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(plan_ticks + 1u, ticks_until_fault(100));
        TEST_ASSERT_EQUAL_PTR(in_use, g_cam.config.offered);
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(corrupt), fixture_rig_status(&rig).first_fault);
    }
}

static void test_pointer_in_use_is_taken_anew(void)
{
    cut_anew();
    uintptr_t at = (uintptr_t)g_cam.config.offered ^ 64u;
    memcpy((void *)&g_cam.config.in_use, &at, sizeof at);
    TEST_ASSERT_EQUAL_UINT32(100, ticks_until_fault(100));
    TEST_ASSERT_EQUAL_PTR(g_cam.config.offered, g_cam.config.in_use);
}

/// An encoder that jumps is no changed state, however far it jumps: what is beyond the quarter of a
/// turn that is believed counts as lost.
static void test_jump_of_the_encoder_is_no_changed_state(void)
{
    for (int32_t counts = -9900; counts <= 9900; counts += 330) {
        cut_anew();
        hal_host_fault_counts(counts);
        fixture_rig_ticks(&rig, 3000);
        const uint32_t jump = counts != 0 ? CAM_FAULT_BIT(encoder_jump) : 0u;
        TEST_ASSERT_EQUAL_HEX32(jump, fixture_rig_status(&rig).faults);
    }
}

static void test_count_to_the_plan_heals(void)
{
    cut_anew();
    for (uint32_t bit = 4; bit < 32u; bit++) {
        flip(&g_cam.until_plan, bit);
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT32(plan_ticks, g_cam.until_plan);
        fixture_rig_ticks(&rig, bit % plan_ticks);
    }
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
}

static void test_whole_turns_of_the_angle_are_watched(void)
{
    for (uint32_t bit = 32; bit < 64u; bit++) {
        cut_anew();
        flip(&g_cam.spindle.pos_q32, bit);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(plan_ticks + 1u, ticks_until_fault(100));
    }
}

static void test_place_in_the_turn_is_watched(void)
{
    static const size_t words[] = {offsetof(cam_spindle_t, index_counts),
                                   offsetof(cam_spindle_t, index_error)};
    for (uint32_t i = 0; i < 2u; i++) {
        for (uint32_t bit = 0; bit < 11u; bit++) {
            cut_anew();
            flip((uint8_t *)&g_cam.spindle + words[i], bit);
            TEST_ASSERT_LESS_OR_EQUAL_UINT32(plan_ticks + 1u, ticks_until_fault(100));
        }
    }
}

static void test_configuration_is_scrubbed(void)
{
    for (uint32_t bit = 5; bit < 8u * sizeof(cam_config_t) - 64u; bit += 1009u) {
        cut_anew();
        cam_config_t *config = &g_cam.config.half[g_cam.config.in_use == &g_cam.config.half[1]];
        TEST_ASSERT_TRUE(cam_config_is_whole(config));
        flip(config, bit);
        TEST_ASSERT_FALSE(cam_config_is_whole(config));
        TEST_ASSERT_NULL(cam_config_copy(&g_cam.config));
        polls(a_round); // no tick meanwhile: what it would do by an arbitrary number is not C's
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(2, ticks_until_fault(100));
    }
}

static void test_configuration_is_made_anew_in_off(void)
{
    fixture_rig_ticks(&rig, 10);
    cam_config_t *config = &g_cam.config.half[g_cam.config.in_use == &g_cam.config.half[1]];
    const int32_t range_q6 = config->guard.u_range_q6;
    flip(&config->guard.u_range_q6, 3);
    TEST_ASSERT_EQUAL_UINT32(a_round, ticks_until_fault(a_round));
    TEST_ASSERT_NOT_EQUAL(config, g_cam.config.in_use);
    TEST_ASSERT_EQUAL_INT32(range_q6, g_cam.config.in_use->guard.u_range_q6);
    TEST_ASSERT_TRUE(cam_config_is_whole(g_cam.config.in_use));
    bring(cam_state_cutting);
}

/// @return the configuration in use, which is to be changed
static cam_config_t *changed(void)
{
    cam_config_t *config = &g_cam.config.half[g_cam.config.in_use == &g_cam.config.half[1]];
    flip(&config->guard.u_range_q6, 3);
    return config;
}

/// What was found waits for the request that is on its way and for room; it is found again.
static void test_a_change_that_is_found_waits_for_request_and_room(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_ready);
    (void)changed();
    const uint32_t generation = m->generation;
    m->n_requests++; // something is posted and not carried out
    polls(2 * a_round);
    TEST_ASSERT_EQUAL_UINT32(generation, m->generation);
    m->n_requests--;
    const uint32_t n_requests = m->n_requests;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(m, cam_param_phase_udeg, 5));
    flip(&g_cam.config.half[g_cam.config.in_use == &g_cam.config.half[0]].guard.u_range_q6, 3);
    polls(2 * a_round);
    TEST_ASSERT_EQUAL_UINT32(generation + 1u, m->generation);
    TEST_ASSERT_EQUAL_UINT32(n_requests, m->n_requests);
    fixture_rig_tick(&rig);
    TEST_ASSERT_LESS_THAN_UINT32(a_round, ticks_until_fault(a_round));
    TEST_ASSERT_EQUAL_UINT32(n_requests + 1u, m->n_requests);
    TEST_ASSERT_EQUAL_UINT32(generation + 2u, m->generation);
}

/// Behind a fault, and without a table, a changed configuration is made anew and nothing else.
static void test_a_change_behind_a_fault_is_only_mended(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_ready);
    hal_host_fault_estop(true);
    TEST_ASSERT_LESS_THAN_UINT32(100, ticks_until_fault(100));
    const uint32_t n_requests = m->n_requests;
    const cam_config_t *config = changed();
    polls(2 * a_round);
    fixture_rig_tick(&rig);
    TEST_ASSERT_NOT_EQUAL(config, g_cam.config.in_use);
    TEST_ASSERT_EQUAL_UINT32(n_requests, m->n_requests);
    hal_host_fault_estop(false);
    cam_machine_init(m, &g_cam, 20000, hal_clock_hz());
    fixture_rig_tick(&rig);
    config = changed();
    polls(2 * a_round);
    fixture_rig_tick(&rig);
    TEST_ASSERT_NOT_EQUAL(config, g_cam.config.in_use);
    TEST_ASSERT_NULL(g_cam.config.in_use->play.table);
}

static void test_scrub_begins_anew_with_another_configuration(void)
{
    bring(cam_state_ready);
    cam_scrub_t scrub = {0};
    TEST_ASSERT_TRUE(cam_scrub_step(&scrub, &g_cam.config));
    TEST_ASSERT_EQUAL_UINT32(cam_scrub_words, scrub.at);
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, cam_param_phase_udeg, 1000));
    TEST_ASSERT_TRUE(cam_scrub_step(&scrub, &g_cam.config));
    TEST_ASSERT_EQUAL_UINT32(cam_scrub_words, scrub.at);
    static const cam_config_bank_t none;
    TEST_ASSERT_TRUE(cam_scrub_step(&scrub, &none));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_seal_sees_every_single_bit);
    RUN_TEST(test_pointer_to_the_configuration_is_mended);
    RUN_TEST(test_pointer_in_use_is_taken_anew);
    RUN_TEST(test_jump_of_the_encoder_is_no_changed_state);
    RUN_TEST(test_count_to_the_plan_heals);
    RUN_TEST(test_whole_turns_of_the_angle_are_watched);
    RUN_TEST(test_place_in_the_turn_is_watched);
    RUN_TEST(test_configuration_is_scrubbed);
    RUN_TEST(test_configuration_is_made_anew_in_off);
    RUN_TEST(test_a_change_that_is_found_waits_for_request_and_room);
    RUN_TEST(test_a_change_behind_a_fault_is_only_mended);
    RUN_TEST(test_scrub_begins_anew_with_another_configuration);
    return UNITY_END();
}
