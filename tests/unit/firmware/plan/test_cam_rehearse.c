// SPDX-License-Identifier: Apache-2.0
// A rehearsal plays the first height with X clear of the work, and ends in the cut or, stopped, out
// of the work. The correction that was learned is in the command alone.
#include "cam_feasible.h"
#include "cam_machine_inner.h" // cam_machine_offer_copy
#include "rig_bench.h"
#include <math.h> // ldexp

static int64_t least_x_nm; ///< of the set-points of X while U was not at rest
static int32_t most_u_q6, least_u_q6;
static int32_t first_z_nm, last_z_nm;

static void begin(int32_t turns, bool is_z_measured)
{
    fixture_rig_init(&rig, &part, 20000);
    set(cam_param_rehearse_turns, turns);
    set(cam_param_z_is_measured, is_z_measured);
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    fixture_rig_ticks(&rig, 2);
    least_x_nm = INT64_MAX;
    most_u_q6 = INT32_MIN;
    least_u_q6 = INT32_MAX;
}

/// Tick as long as the state stays, and note where the axes are while U plays.
static cam_state_t rehearse(uint32_t n_most)
{
    const cam_state_t state = fixture_rig_state();
    for (uint32_t n = 0; n < n_most && rig.last.want.state == state; n++) {
        fixture_rig_tick(&rig);
        if (g_cam.motion.is_playing) {
            const int32_t x_nm = rig.last.out[hal_axis_x].pos_nm;
            const int32_t u_q6 = rig.last.want.u_set_q6;
            least_x_nm = x_nm < least_x_nm ? x_nm : least_x_nm;
            most_u_q6 = u_q6 > most_u_q6 ? u_q6 : most_u_q6;
            least_u_q6 = u_q6 < least_u_q6 ? u_q6 : least_u_q6;
            last_z_nm = rig.last.out[hal_axis_z].pos_nm;
        }
    }
    return rig.last.want.state;
}

/// Up to a part of the lift, in ticks.
static void play_up_to(int32_t scale_q30)
{
    while (!g_cam.motion.is_playing || g_cam.motion.scale_q30 < scale_q30) {
        fixture_rig_tick(&rig);
    }
}

static void test_u_plays_in_full_while_x_is_clear_by_half_the_stroke(void)
{
    static const int32_t clearances_nm[] = {1000000, 0};
    for (int i = 0; i < 2; i++) {
        begin(3, false);
        TEST_ASSERT_EQUAL_INT(cam_state_rehearsing, rig.last.want.state);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine)); // from the approach: at once
        fixture_rig_ticks(&rig, 2);
        TEST_ASSERT_EQUAL_INT(cam_state_ready, rig.last.want.state);
        cam_machine_poll(&rig.machine);
        set(cam_param_x_clearance_nm, clearances_nm[i]);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
        fixture_rig_ticks(&rig, 2);
        first_z_nm = rig.machine.table.z_first_nm;
        TEST_ASSERT_EQUAL_INT(cam_state_engaging, rehearse(200000));
        const cam_machine_t *m = &rig.machine;
        double x[3];
        part.x(part.z_first_nm, x);
        const int64_t away_nm = (int64_t)x[0] + cam_demand_clearance_nm(&m->table, &m->params) +
                                cam_demand_half_stroke_nm(&m->table, &m->params);
        TEST_ASSERT_INT_WITHIN(2, away_nm, least_x_nm);
        TEST_ASSERT_INT32_WITHIN(64 * 200, 64 * 100000, most_u_q6);
        TEST_ASSERT_INT32_WITHIN(64 * 100, 0, least_u_q6);
        TEST_ASSERT_EQUAL_INT32(first_z_nm, last_z_nm);
        TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_cutting, 60000));
        TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_ready, 60000));
        TEST_ASSERT_EQUAL_UINT32(0, rig.last.want.faults);
    }
}

/// After a rehearsal U waits at 0, to the last digit, until the cut is laid; then it settles.
static void test_u_rests_before_the_cut_and_settles_before_the_feed(void)
{
    static const int32_t settling_turns[] = {12, 0};
    for (int is_z_measured = 0; is_z_measured < 2; is_z_measured++) {
        begin(3, is_z_measured != 0);
        TEST_ASSERT_LESS_THAN_UINT32(200000, fixture_rig_until(&rig, cam_state_engaging, 200000));
        uint32_t n = 0;
        for (; !g_cam.motion.is_playing; n++) {
            TEST_ASSERT_LESS_THAN_UINT32(100000, n);
            TEST_ASSERT_EQUAL_INT32(0, rig.last.want.u_set_q6);
            TEST_ASSERT_EQUAL_INT64(0, g_cam.motion.u_target_q10);
            fixture_rig_tick(&rig);
        }
        TEST_ASSERT_GREATER_THAN_UINT32(0, n);
        const int64_t from_q32 = g_cam.plan.engage_at_q32;
        TEST_ASSERT_LESS_THAN_UINT32(200000, fixture_rig_until(&rig, cam_state_cutting, 200000));
        const double turns = ldexp((double)(rig.last.angle.pos_q32 - from_q32), -32);
        TEST_ASSERT_DOUBLE_WITHIN(
            0.1, rig.machine.params.engage_turns + settling_turns[is_z_measured], turns);
    }
}

static void test_stop_ends_a_rehearsal_in_ready(void)
{
    begin(1000, false);
    play_up_to(1 << 29);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_start(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_disable(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_state_ready, rehearse(10000)); // it falls within a few turns
    cam_machine_poll(&rig.machine);
    TEST_ASSERT_TRUE(rig.machine.is_cut_short); // the same pass again
}

/// A rehearsal has no feed: an override in it does not move its end, and applies from the cut on.
static void test_an_override_in_a_rehearsal_is_for_the_cut(void)
{
    begin(3, false);
    play_up_to(1 << 29);
    const int64_t end_q32 = g_cam.plan.disengage_at_q32;
    set(cam_param_feed_override_ppm, 900000);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT64(end_q32, g_cam.plan.disengage_at_q32);
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, rehearse(20000));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_cutting, 60000));
    TEST_ASSERT_INT32_WITHIN(1, 966367642, g_cam.plan.feed_motion.requested_q30); // 0.9 of 2^30
}

static void test_a_modulated_table_is_not_rehearsed(void)
{
    part = fixture_part_modulated();
    begin(3, false);
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, rig.last.want.state);
}

/// A constant correction is commanded on top of the set-point, times the envelope.
static void test_what_was_learned_is_in_the_command(void)
{
    begin(1000, false);
    play_up_to(1 << 30);
    cam_config_t *copy = cam_config_copy(&rig.machine.core->config);
    TEST_ASSERT_NOT_NULL(copy);
    for (int i = 0; i <= cam_learned_points; i++) {
        copy->learned.c[i] = 1500;
    }
    cam_machine_offer_copy(&rig.machine);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_INT32_WITHIN(1, (rig.last.want.u_set_q6 >> 6) + 1500,
                             rig.last.out[hal_axis_u].pos_nm);
    TEST_ASSERT_EQUAL_UINT32(rig.machine.generation, rig.last.config);
}
