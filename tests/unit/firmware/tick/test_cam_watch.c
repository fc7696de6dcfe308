// SPDX-License-Identifier: Apache-2.0
// Single bits of what only ticks and plans may change flip in the cut: each is seen by the copy or
// the sum of it, mended, and the tool retracts. test_cam_corrupt.c flips the rest of the state.
#include "rig_bench.h"

enum { plan_ticks = 8 };

/// @return ticks until a fault comes, `most` when none came
static uint32_t ticks_until_fault(uint32_t most)
{
    uint32_t n = 0;
    while (n < most && fixture_rig_state() != cam_state_fault) {
        fixture_rig_tick(&rig);
        n++;
    }
    return n;
}

static void test_state_of_the_plan_is_sealed(void)
{
    for (uint32_t bit = 0; bit < 8u * sizeof g_cam.plan; bit += 29u) {
        cut_anew();
        flip(&g_cam.plan, bit);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(plan_ticks + 1u, ticks_until_fault(100));
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(corrupt),
                                fixture_rig_status(&rig).faults & CAM_FAULT_BIT(corrupt));
    }
}

/// @return [nm] U on the machine as it was told
static int32_t u_nm(void)
{
    return hal_host.out.axis[hal_axis_u].pos_nm;
}

/// The place of U on the machine is what homing has found, and nothing else, whichever of both
/// words has flipped. A command made with a false one is not written.
static void test_home_of_u_is_mended_before_it_is_told(void)
{
    int32_t *words[] = {&g_cam.motion.u_home_nm, &g_cam.watch.u_home_nm};
    for (uint32_t bit = 0; bit < 64u; bit++) {
        cut_anew();
        const int32_t home_nm = g_cam.motion.u_home_nm;
        const int32_t before_nm = u_nm();
        flip(words[bit / 32u], bit % 32u);
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT32(before_nm, u_nm());
        fixture_rig_tick(&rig);
        TEST_ASSERT_INT32_WITHIN(20000, before_nm, u_nm());
        TEST_ASSERT_EQUAL_INT32(home_nm, g_cam.motion.u_home_nm);
        TEST_ASSERT_EQUAL_INT32(home_nm, g_cam.watch.u_home_nm);
        TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(corrupt), fixture_rig_status(&rig).faults);
    }
}

/// One that has begun is one that has ended, or the next one is a fault.
static void test_tick_that_did_not_end_is_seen(void)
{
    for (uint32_t bit = 0; bit < 32u; bit++) {
        cut_anew();
        flip(&g_cam.n_begun, bit);
        TEST_ASSERT_EQUAL_UINT32(1, ticks_until_fault(100));
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(corrupt), fixture_rig_status(&rig).first_fault);
    }
}

static void test_pointer_to_the_configuration_is_asked_for_anew(void)
{
    cut_anew();
    const cam_config_t *in_use = g_cam.config.in_use;
    uint32_t faults = CAM_FAULT_BIT(table);
    TEST_ASSERT_EQUAL_PTR(in_use, cam_config_again_isr(&g_cam.config, in_use, &faults));
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(table), faults);
    TEST_ASSERT_EQUAL_PTR(in_use, cam_config_again_isr(&g_cam.config, in_use + 1, &faults));
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(table) | CAM_FAULT_BIT(corrupt), faults);
}

/// What U was told last is in the record as well: no leap where the word of it flips.
static void test_last_command_of_u_is_mended_where_it_is_refused(void)
{
    for (uint32_t bit = 0; bit < 32u; bit++) {
        cut_anew();
        const int32_t before_nm = u_nm();
        const int32_t step_nm = g_cam.command.u.step_nm;
        flip(&g_cam.command.u.nm, bit);
        fixture_rig_tick(&rig);
        TEST_ASSERT_INT32_WITHIN(2000, before_nm + step_nm, u_nm());
    }
}

/// Whatever leads the retract away, U goes on from where it was told, and out of the work.
static void test_retract_that_flipped_begins_again_where_u_is(void)
{
    for (uint32_t bit = 22; bit < 30u; bit++) { // 4 um and more: less is within the limits
        cut_anew();
        flip(&g_cam.n_begun, 0);
        fixture_rig_ticks(&rig, 30);
        flip(&g_cam.guard.filter.sum_pos_q10, bit + g_cam.guard.filter.log2_window);
        fixture_rig_ticks(&rig, 2);
        const int32_t most_nm = 2 * (g_cam.config.in_use->guard.u_acc_q6 >> 6);
        int32_t last_nm = u_nm();
        int32_t step_nm = g_cam.command.u.step_nm;
        for (uint32_t i = 0; i < 4000u; i++) {
            fixture_rig_tick(&rig);
            TEST_ASSERT_INT32_WITHIN(most_nm, step_nm, u_nm() - last_nm);
            step_nm = u_nm() - last_nm;
            last_nm = u_nm();
        }
        TEST_ASSERT_INT32_WITHIN(10, g_cam.config.in_use->guard.u_retract_q10 / 1024,
                                 last_nm + g_cam.motion.u_home_nm);
    }
}

/// X moves off from where it is told to be, not from a set-point that may have flipped.
static void test_x_leaves_from_where_it_is_told(void)
{
    cut_anew();
    flip(&g_cam.n_begun, 0);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT64((int64_t)hal_host.out.axis[hal_axis_x].pos_nm * 1024,
                            g_cam.motion.x_left_q10);
}

/// X and Z are told by at most this more or less than their increment, in the tick of the flip too.
static void test_places_of_x_and_z_are_mended_in_the_tick(void)
{
    for (uint32_t bit = 12; bit < 64u; bit++) { // 4 nm at least
        cut_anew();
        const int32_t before_nm = hal_host.out.axis[hal_axis_x].pos_nm;
        flip(&g_cam.motion.axis[hal_axis_x].pos_q10, bit);
        fixture_rig_tick(&rig);
        TEST_ASSERT_INT32_WITHIN(10, before_nm, hal_host.out.axis[hal_axis_x].pos_nm);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(plan_ticks + 1u, ticks_until_fault(100));
        TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(corrupt), fixture_rig_status(&rig).faults);
    }
}

/// The copy flips instead: what the last record tells is what was told.
static void test_copy_of_a_place_that_flipped_moves_nothing(void)
{
    for (uint32_t bit = 2; bit < 32u; bit++) {
        cut_anew();
        const int32_t before_nm = hal_host.out.axis[hal_axis_x].pos_nm;
        flip(&g_cam.watch.led_nm[hal_axis_x], bit);
        fixture_rig_tick(&rig);
        TEST_ASSERT_INT32_WITHIN(10, before_nm, hal_host.out.axis[hal_axis_x].pos_nm);
        TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(corrupt), fixture_rig_status(&rig).faults);
    }
}

/// An increment is mended in the tick that would use it.
static void test_increment_that_flipped_is_the_slower_of_both(void)
{
    cut_anew();
    const int32_t vel_q10 = g_cam.motion.axis[hal_axis_z].vel_q10;
    flip(&g_cam.motion.axis[hal_axis_z].vel_q10, 20);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT32(vel_q10, g_cam.motion.axis[hal_axis_z].vel_q10);
    TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(corrupt), fixture_rig_status(&rig).faults);
}

static void test_state_is_mended_and_off_enables_nothing(void)
{
    for (uint32_t bit = 0; bit < 32u; bit++) {
        cut_anew();
        flip(&g_cam.motion.state, bit);
        TEST_ASSERT_EQUAL_UINT32(1, ticks_until_fault(100));
        TEST_ASSERT_EQUAL_HEX32(hal_out_fault | hal_out_enable, hal_host.out.outputs);
        setUp();
        fixture_rig_ticks(&rig, 10);
        flip(&g_cam.motion.state, bit);
        fixture_rig_ticks(&rig, 20);
        TEST_ASSERT_EQUAL_HEX32(0, hal_host.out.outputs);
        TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    }
}

static void test_what_would_be_written_is_looked_at(void)
{
    cut_anew();
    cam_tick_record_t r = rig.last;
    TEST_ASSERT_EQUAL_HEX32(0, cam_watch_strayed(&g_cam.watch, &g_cam.command, &r));
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        r = rig.last;
        flip(&r.out[i].pos_nm, 9u * i);
        TEST_ASSERT_NOT_EQUAL_HEX32(0, cam_watch_strayed(&g_cam.watch, &g_cam.command, &r));
    }
}

/// Where the increment leads from the place that was told, to the middle of its nanometre.
static void test_mended_place_is_the_one_told_and_its_increment(void)
{
    cam_watch_t w = {.led_nm = {0, 1000, -2000}};
    cam_axis_command_t t = {.vel_q10 = {0, 3 * 1024, -5 * 1024}};
    cam_motion_t m = {.state = cam_state_cutting};
    m.axis[hal_axis_x] = (cam_axis_motion_t){.pos_q10 = INT64_C(1) << 40, .vel_q10 = 3 * 1024};
    m.axis[hal_axis_z] = (cam_axis_motion_t){.pos_q10 = -(INT64_C(1) << 40), .vel_q10 = 1 << 30};
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(corrupt), cam_watch_mend_isr(&w, &t, &m, NULL));
    TEST_ASSERT_EQUAL_INT64(1003 * 1024 + 512, m.axis[hal_axis_x].pos_q10);
    TEST_ASSERT_EQUAL_INT64(-2005 * 1024 + 512, m.axis[hal_axis_z].pos_q10);
    TEST_ASSERT_EQUAL_INT32(-5 * 1024, m.axis[hal_axis_z].vel_q10);
    TEST_ASSERT_EQUAL_INT32(1003, w.led_nm[hal_axis_x]);
    TEST_ASSERT_EQUAL_INT32(-2005, w.led_nm[hal_axis_z]);
}

/// Which of two increments was flipped nobody knows: the slower one leads, whichever it is.
static void test_mended_increment_is_the_slower_of_two(void)
{
    for (int32_t vel_q10 = -4 * 1024; vel_q10 <= 4 * 1024; vel_q10 += 1024) {
        cam_watch_t w = {.led_nm = {0, 1000, -2000}};
        cam_axis_command_t t = {.vel_q10 = {0, 3 * 1024, -5 * 1024}};
        cam_motion_t m = {.state = cam_state_cutting};
        m.axis[hal_axis_x] = (cam_axis_motion_t){.pos_q10 = INT64_C(1) << 40, .vel_q10 = vel_q10};
        (void)cam_watch_mend_isr(&w, &t, &m, NULL);
        const bool is_slower = vel_q10 > -3 * 1024 && vel_q10 < 3 * 1024;
        const int32_t mended_q10 = is_slower ? vel_q10 : 3 * 1024;
        TEST_ASSERT_EQUAL_INT32(mended_q10, m.axis[hal_axis_x].vel_q10);
        TEST_ASSERT_EQUAL_INT64(1000 * 1024 + 512 + mended_q10, m.axis[hal_axis_x].pos_q10);
    }
}

/// @return [nm] X a second behind the fault, where it has to stand
static int32_t x_at_rest(void)
{
    fixture_rig_ticks(&rig, 20000);
    const int32_t x_nm = hal_host.out.axis[hal_axis_x].pos_nm;
    const int32_t z_nm = hal_host.out.axis[hal_axis_z].pos_nm;
    fixture_rig_ticks(&rig, 2000);
    TEST_ASSERT_EQUAL_INT32(x_nm, hal_host.out.axis[hal_axis_x].pos_nm);
    TEST_ASSERT_EQUAL_INT32(z_nm, hal_host.out.axis[hal_axis_z].pos_nm);
    return x_nm;
}

/// A spindle that turns on without edges is missing them, and nothing else; X and Z come to rest.
static void test_axes_rest_behind_an_index_that_died(void)
{
    cut_anew();
    hal_host_fault_index_dead(true);
    (void)ticks_until_fault(4000);
    const int32_t left_nm = hal_host.out.axis[hal_axis_x].pos_nm;
    rig.is_spindle_held = true; // it turns on
    TEST_ASSERT_INT32_WITHIN(3000, left_nm + rig.machine.params.x_clearance_nm, x_at_rest());
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(index_missing), fixture_rig_status(&rig).faults);
}

/// Whatever is found to be changed in every plan of the state fault, X and Z come to rest.
static void test_axes_rest_behind_a_change_that_is_found_for_ever(void)
{
    cut_anew();
    const int32_t cut_nm = hal_host.out.axis[hal_axis_x].pos_nm;
    int32_t x_nm = 0;
    for (uint32_t i = 0; i < 22000u; i++) {
        g_cam.watch.plan_seal ^= i % plan_ticks == 0u ? 1u : 0u; // once between two plans
        fixture_rig_tick(&rig);
        x_nm = i == 20000u ? hal_host.out.axis[hal_axis_x].pos_nm : x_nm;
    }
    TEST_ASSERT_EQUAL_INT(cam_state_fault, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT32(x_nm, hal_host.out.axis[hal_axis_x].pos_nm);
    TEST_ASSERT_INT32_WITHIN(3000, cut_nm + rig.machine.params.x_clearance_nm, x_nm);
}

/// Of the state and its copy the one that the last record does not know has flipped.
static void test_state_that_the_record_knows_is_the_one_that_stays(void)
{
    for (uint32_t last = 0; last < cam_n_states; last++) {
        for (uint32_t other = 0; other < cam_n_states; other++) {
            const cam_watch_t w = {.state = (cam_state_t)last};
            cam_motion_t m = {.state = (cam_state_t)other};
            TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(corrupt),
                                    cam_watch_mend_state_isr(&w, &m, (cam_state_t)last));
            TEST_ASSERT_EQUAL_INT(last, m.state);
            const cam_watch_t flipped = {.state = (cam_state_t)other};
            m.state = (cam_state_t)last;
            (void)cam_watch_mend_state_isr(&flipped, &m, (cam_state_t)last);
            TEST_ASSERT_EQUAL_INT(last, m.state);
        }
    }
}

/// A plan has led from one state to the next behind the record; what flips then is not mended to
/// the state before it.
static void test_state_that_flips_behind_its_change_is_taken_from_the_copy(void)
{
    for (uint32_t bit = 0; bit < 32u; bit++) {
        const cam_watch_t w = {.state = cam_state_engaging};
        cam_motion_t m = {.state = cam_state_engaging};
        flip(&m.state, bit);
        if (m.state != cam_state_ready) {
            (void)cam_watch_mend_state_isr(&w, &m, cam_state_ready);
            TEST_ASSERT_EQUAL_INT(cam_state_engaging, m.state);
        }
    }
}

/// The flag that axes play is as the last plan left it; a fault alone ends playing between plans.
static void test_playing_that_ends_without_a_fault_is_seen(void)
{
    static const struct {
        cam_state_t state;
        bool was_playing, is_playing;
        uint32_t faults;
    } cases[] = {
        {cam_state_cutting, true, true, 0},
        {cam_state_cutting, true, false, CAM_FAULT_BIT(corrupt)},
        {cam_state_ready, false, true, CAM_FAULT_BIT(corrupt)},
        {cam_state_fault, true, false, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        cam_watch_t w = {0};
        static cam_plan_t plan;
        cam_motion_t m = {.state = cases[i].state, .is_playing = cases[i].was_playing};
        cam_watch_plan_isr(&w, &m, &plan);
        m.is_playing = cases[i].is_playing;
        TEST_ASSERT_EQUAL_HEX32(cases[i].faults, cam_watch_inspect_isr(&w, &m, &plan));
    }
}

/// In off the axes are followed, however they move: that is no fault.
static void test_axes_may_stray_in_off(void)
{
    cam_watch_t w = {.led_nm = {0, 1000, -2000}};
    cam_axis_command_t t = {.vel_q10 = {0, 1024, 1024}};
    cam_motion_t m = {.state = cam_state_off};
    m.axis[hal_axis_x].pos_q10 = 500 * 1024;
    m.axis[hal_axis_z].pos_q10 = -77 * 1024;
    TEST_ASSERT_FALSE(cam_watch_is_on_course_isr(&w, &t, &m));
    TEST_ASSERT_EQUAL_HEX32(0, cam_watch_mend_isr(&w, &t, &m, NULL));
    TEST_ASSERT_EQUAL_INT64(500 * 1024, m.axis[hal_axis_x].pos_q10);
    TEST_ASSERT_EQUAL_INT32(500, w.led_nm[hal_axis_x]);
    TEST_ASSERT_EQUAL_INT32(-77, w.led_nm[hal_axis_z]);
}

/// A place may be its increment and a rounding further than the last one, and not more.
static void test_course_is_the_increment_and_a_rounding(void)
{
    static const struct {
        int64_t x_nm;
        bool is_on_course;
    } cases[] = {{1002, false}, {1003, true}, {1004, true}, {1005, false}};
    for (uint32_t i = 0; i < 8u; i++) {
        const hal_axis_t axis = i < 4u ? hal_axis_x : hal_axis_z;
        cam_watch_t w = {.led_nm = {0}};
        cam_axis_command_t t = {.vel_q10 = {0}};
        cam_motion_t m = {.state = cam_state_cutting};
        w.led_nm[axis] = 1000;
        t.vel_q10[axis] = 3 * 1024 + 1000;
        m.axis[axis].pos_q10 = cases[i % 4u].x_nm * 1024 + 5;
        TEST_ASSERT_EQUAL(cases[i % 4u].is_on_course, cam_watch_is_on_course_isr(&w, &t, &m));
        const int32_t led_nm = cases[i % 4u].is_on_course ? (int32_t)cases[i % 4u].x_nm : 1000;
        TEST_ASSERT_EQUAL_INT32(led_nm, w.led_nm[axis]);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_axes_rest_behind_an_index_that_died);
    RUN_TEST(test_axes_rest_behind_a_change_that_is_found_for_ever);
    RUN_TEST(test_mended_place_is_the_one_told_and_its_increment);
    RUN_TEST(test_mended_increment_is_the_slower_of_two);
    RUN_TEST(test_state_of_the_plan_is_sealed);
    RUN_TEST(test_home_of_u_is_mended_before_it_is_told);
    RUN_TEST(test_tick_that_did_not_end_is_seen);
    RUN_TEST(test_pointer_to_the_configuration_is_asked_for_anew);
    RUN_TEST(test_last_command_of_u_is_mended_where_it_is_refused);
    RUN_TEST(test_retract_that_flipped_begins_again_where_u_is);
    RUN_TEST(test_x_leaves_from_where_it_is_told);
    RUN_TEST(test_copy_of_a_place_that_flipped_moves_nothing);
    RUN_TEST(test_places_of_x_and_z_are_mended_in_the_tick);
    RUN_TEST(test_increment_that_flipped_is_the_slower_of_both);
    RUN_TEST(test_state_is_mended_and_off_enables_nothing);
    RUN_TEST(test_what_would_be_written_is_looked_at);
    RUN_TEST(test_state_that_the_record_knows_is_the_one_that_stays);
    RUN_TEST(test_state_that_flips_behind_its_change_is_taken_from_the_copy);
    RUN_TEST(test_playing_that_ends_without_a_fault_is_seen);
    RUN_TEST(test_axes_may_stray_in_off);
    RUN_TEST(test_course_is_the_increment_and_a_rounding);
    return UNITY_END();
}
