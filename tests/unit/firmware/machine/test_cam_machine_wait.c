// SPDX-License-Identifier: Apache-2.0
// What waits for the interrupt, and each reason for it by itself: for every condition of these
// decisions two cases that differ in it alone.
#include "cam_machine.h"
#include "cam_machine_jog.h"
#include "fixture_newer.h"
#include "rig_bench.h"

enum { n_passes = 2 };

static void poll_for(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        fixture_rig_tick(&rig);
        cam_machine_poll(&rig.machine);
    }
}

/// A rate that the interrupt does not know yet, and a spindle that is still too fast, each hold the
/// start back; so does nothing else once they are gone.
static void test_start_waits_for_the_rate_and_for_the_spindle(void)
{
    bring(cam_state_ready);
    cam_machine_t *m = &rig.machine;
    m->is_rate_due = true;
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_start(m));
    m->is_rate_due = false;
    const uint32_t limit_mrpm = m->limit_mrpm;
    m->limit_mrpm = 1000;
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_start(m));
    m->limit_mrpm = limit_mrpm;
    m->offsets.has_searched_u = true; // and no home was found
    m->is_rate_due = true;
    TEST_ASSERT_EQUAL_INT(cam_err_not_homed,
                          cam_machine_start(m)); // what people must do comes first
    m->offsets.has_searched_u = false;
    m->is_rate_due = false;
    m->n_requests++; // something is posted and not carried out
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_start(m));
    TEST_ASSERT_FALSE(m->is_in_pass);
    m->n_requests--;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    TEST_ASSERT_TRUE(m->is_in_pass);
}

/// Two passes are selected, and the first one is cut; the slow side has not looked since.
static void cut_first_of_two(void)
{
    static const fixture_pass_t two[n_passes] = {{100000, 300000, 2500000, 0},
                                                 {0, 300000, 2500000, 0}};
    fixture_newer_passes(&rig.image, two, n_passes);
    cam_machine_t *m = &rig.machine;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_select_table(m, rig.image.bytes, rig.image.size));
    fixture_rig_ticks(&rig, 2);
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_cutting, 60000));
    TEST_ASSERT_LESS_THAN_UINT32(400000, fixture_rig_until(&rig, cam_state_ready, 400000));
}

/// Two passes: behind the first one the next is handed over, and a start that comes before the
/// interrupt has room for it is busy, whatever else is well.
static void test_start_waits_for_the_pass(void)
{
    cam_machine_t *m = &rig.machine;
    cut_first_of_two();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(m, cam_param_phase_udeg, 5));
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_start(m)); // no room for the next pass yet
    TEST_ASSERT_TRUE(m->is_in_pass);
    TEST_ASSERT_EQUAL_UINT32(0, m->pass);
    fixture_rig_ticks(&rig, 2);
    TEST_ASSERT_NOT_EQUAL_INT(cam_err_state, cam_machine_start(m));
    TEST_ASSERT_EQUAL_UINT32(1, m->pass);
    TEST_ASSERT_EQUAL_UINT32(0, m->n_parts);
}

/// Behind a pass of a table that is used no longer nothing is handed over.
static void test_the_next_pass_needs_the_table(void)
{
    cam_machine_t *m = &rig.machine;
    cut_first_of_two();
    m->has_table = false;
    const uint32_t generation = m->generation;
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->is_in_pass);
    TEST_ASSERT_EQUAL_UINT32(0, m->pass);
    TEST_ASSERT_EQUAL_UINT32(generation, m->generation);
    TEST_ASSERT_EQUAL_UINT32(0, m->n_parts);
}

/// The part counts once its first pass is ready again, not while that waits for the interrupt.
static void test_the_part_counts_when_its_first_pass_is_ready(void)
{
    cam_machine_t *m = &rig.machine;
    cut_first_of_two();
    m->pass = 1; // as if it had been the last one
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(m, cam_param_phase_udeg, 5));
    cam_machine_poll(m);
    TEST_ASSERT_TRUE(m->is_in_pass);
    TEST_ASSERT_EQUAL_UINT32(0, m->n_parts);
    fixture_rig_ticks(&rig, 2);
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->is_in_pass);
    TEST_ASSERT_EQUAL_UINT32(0, m->pass);
    TEST_ASSERT_EQUAL_UINT32(1, m->n_parts);
}

/// A pass that ended is seen when nothing is pending, the state is no longer that of the work, and
/// there was a pass; one that was stopped is not counted.
static void test_the_end_of_a_pass_is_seen_once(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_cutting);
    poll_for(1);
    TEST_ASSERT_TRUE(m->is_in_pass);
    TEST_ASSERT_LESS_THAN_UINT32(400000, fixture_rig_until(&rig, cam_state_ready, 400000));
    m->n_requests++; // something is posted and not carried out
    cam_machine_poll(m);
    TEST_ASSERT_TRUE(m->is_in_pass);
    m->n_requests--;
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->is_in_pass);
    TEST_ASSERT_EQUAL_UINT32(1, m->n_parts);
    cam_machine_poll(m);
    TEST_ASSERT_EQUAL_UINT32(1, m->n_parts);
}

/// Home out of ready enables again by itself, unless a fault came between.
static void test_home_ends_where_the_state_is_another(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home(m));
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_may_exchange(m)); // it goes on by itself
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_may_exchange(m));
    hal_host_fault_estop(true);
    poll_for(3);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    TEST_ASSERT_FALSE(m->homes_again);
    hal_host_fault_estop(false);
    poll_for(3);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_may_exchange(m));
    m->homes_again = true;
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_may_exchange(m));
    m->homes_again = false;
    bring(cam_state_ready);
    m->homes_again = true; // in another state than off there is nothing to enable
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->homes_again);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
}

/// What the slow side has still to do lets the second half of home wait; then it enables.
static void test_home_waits_until_all_homes_are_read(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home(m));
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    m->offsets.n_found++; // another number of homes than the interrupt has found
    cam_machine_poll(m);
    TEST_ASSERT_TRUE(m->homes_again);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    poll_for(2);
    TEST_ASSERT_FALSE(m->homes_again);
    TEST_ASSERT_EQUAL_INT(cam_state_homing, fixture_rig_state());
}

/// Downloads wait for the last command and for the last configuration, each by itself.
static void test_an_exchange_waits_for_command_and_configuration(void)
{
    cam_machine_t *m = &rig.machine;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_may_exchange(m));
    m->n_requests++;
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_may_exchange(m));
    m->n_requests--;
    m->generation++;
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_may_exchange(m));
    m->generation--;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_may_exchange(m));
}

/// In ready a table needs one before it, of the same sense.
static void test_a_table_in_ready_follows_another_of_its_sense(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_ready);
    m->has_table = false;
    TEST_ASSERT_EQUAL_INT(cam_err_table_sense,
                          cam_machine_select_table(m, rig.image.bytes, rig.image.size));
    m->has_table = true;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_select_table(m, rig.image.bytes, rig.image.size));
}

/// A damaged table is dropped at once where nothing is enabled: off, and behind a fault.
static void test_damage_is_dropped_at_once_in_off_and_fault(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_ready);
    hal_host_fault_estop(true);
    until(cam_state_fault);
    rig.image.bytes[rig.image.size - 1u] ^= 1u;
    const uint32_t posted = m->n_requests;
    for (int i = 0; i < 4000 && m->has_table; i++) {
        poll_for(1);
    }
    TEST_ASSERT_FALSE(m->has_table);
    TEST_ASSERT_EQUAL_UINT32(posted, m->n_requests);
}

/// Stop of a cut whose Z others lead is its usual end, in no other state; a stop that is refused
/// cuts nothing short.
static void test_a_stop_cuts_short_only_what_has_another_end(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_stop(m));
    TEST_ASSERT_FALSE(m->is_cut_short);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    until(cam_state_cutting);
    m->params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(m));
    TEST_ASSERT_FALSE(m->is_cut_short);
    fixture_rig_tick(&rig);
    m->params.z_is_measured = 0;
    until(cam_state_ready);
    poll_for(2);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_engaging, 60000));
    m->params.z_is_measured = 1; // still engaging: it is cut short
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(m));
    TEST_ASSERT_TRUE(m->is_cut_short);
    m->params.z_is_measured = 0;
    until(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_stop(m));
    TEST_ASSERT_TRUE(m->is_cut_short); // a stop that is refused mends nothing
}

/// Hold needs a table, a state of the work, and one that does not end it.
static void test_a_hold_needs_a_table(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_cutting);
    m->has_table = false;
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_hold(m));
    m->is_held = true;
    m->is_rate_due = true; // without a table there is nothing to hand over
    const uint32_t generation = m->generation;
    cam_machine_poll(m);
    TEST_ASSERT_EQUAL_UINT32(generation, m->generation);
    m->has_table = true;
    cam_machine_poll(m);
    TEST_ASSERT_EQUAL_UINT32(generation + 1u, m->generation);
}

/// A hold outlives a command that is on its way, and ends with the work.
static void test_a_hold_ends_with_the_work_only(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_ready);
    m->is_held = true;
    m->n_requests++;
    cam_machine_poll(m);
    TEST_ASSERT_TRUE(m->is_held);
    m->n_requests--;
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->is_held);
}

/// A resume that finds no room is handed over by the next poll, and brings no hold back.
static void test_a_resume_waits_for_room(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_cutting);
    const cam_config_bank_t *bank = &m->core->config;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(m));
    TEST_ASSERT_EQUAL_INT32(0, atomic_load(&bank->offered)->play.feed_rate_q30);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_resume(m));
    TEST_ASSERT_TRUE(m->is_rate_due);
    fixture_rig_tick(&rig);
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->is_rate_due);
    TEST_ASSERT_FALSE(m->is_held);
    TEST_ASSERT_GREATER_THAN_INT32(0, atomic_load(&bank->offered)->play.feed_rate_q30);
    m->params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_INT(cam_err_override_measured, cam_machine_hold(m));
    TEST_ASSERT_FALSE(m->is_held);
}

/// What the commander leaves is stopped when the interrupt has taken the last request, and again
/// while the stop finds no room.
static void test_the_stop_of_a_lost_commander_is_not_forgotten(void)
{
    cam_machine_t *m = &rig.machine;
    bring(cam_state_cutting);
    m->is_stop_due = true;
    m->n_requests++;
    cam_machine_poll(m);
    TEST_ASSERT_TRUE(m->is_stop_due);
    m->n_requests--;
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->is_stop_due);
    until(cam_state_disengaging);
}

/// By hand the stop of a lost commander waits for room in the same way.
static void test_the_stop_of_an_order_waits_for_room(void)
{
    cam_machine_t *m = &rig.machine;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(m));
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(m, hal_axis_x, 1000).err);
    cam_machine_release_command(m);
    cam_machine_poll(m); // the interrupt has not taken the order
    TEST_ASSERT_TRUE(m->is_stop_due);
    fixture_rig_tick(&rig);
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->is_stop_due);
    TEST_ASSERT_EQUAL_INT(cam_jog_rest,
                          atomic_load(&m->core->config.offered)->play.jog.order.begin);
}

/// A table that is not there is not judged: behind a fault by hand a list that changes nothing is
/// taken.
static void test_without_a_table_there_is_nothing_to_judge(void)
{
    cam_machine_t *m = &rig.machine;
    cam_machine_init(m, &g_cam, 20000, hal_clock_hz());
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(m));
    fixture_rig_ticks(&rig, 20);
    hal_host_fault_estop(true);
    until(cam_state_fault);
    cam_machine_stage_begin(m);
    const uint32_t generation = m->generation;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stage_commit(m));
    TEST_ASSERT_EQUAL_UINT32(generation + 1u, m->generation);
    TEST_ASSERT_EQUAL_UINT32(250, cam_machine_feasibility(m, 250).speed_mrpm);
    TEST_ASSERT_EQUAL_UINT32(m->params.spindle_mrpm, cam_machine_feasibility(m, 0).speed_mrpm);
}
