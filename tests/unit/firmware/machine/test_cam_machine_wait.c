// SPDX-License-Identifier: Apache-2.0
// What waits for the interrupt, and each reason for it by itself: for every condition of these
// decisions two cases that differ in it alone. Hold, overrides and trim: states, refusals, what is
// kept and what is forgotten. What is demanded of the button.
#include "cam_machine_inner.h" // cam_machine_acknowledge_config
#include "fixture_newer.h"
#include "rig_bench.h"

enum { n_passes = 2 };

static cam_machine_t *const m = &rig.machine;

static void poll_for(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        fixture_rig_tick(&rig);
        cam_machine_poll(m);
    }
}

/// A rate that the interrupt does not know yet, and a spindle that is still too fast, each hold the
/// start back; so does nothing else once they are gone.
static void test_start_waits_for_the_rate_and_for_the_spindle(void)
{
    bring(cam_state_ready);
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
    expect_select(cam_ok);
    fixture_rig_ticks(&rig, 2);
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_cutting, 60000));
    TEST_ASSERT_LESS_THAN_UINT32(400000, fixture_rig_until(&rig, cam_state_ready, 400000));
}

/// Two passes: after the first one the next is handed over, and a start that comes before the
/// interrupt has room for it is busy, whatever else is well.
static void test_start_waits_for_the_pass(void)
{
    cut_first_of_two();
    expect_set(cam_ok, cam_param_phase_udeg, 5);
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_start(m)); // no room for the next pass yet
    TEST_ASSERT_TRUE(m->is_in_pass);
    TEST_ASSERT_EQUAL_UINT32(0, m->pass);
    fixture_rig_ticks(&rig, 2);
    TEST_ASSERT_NOT_EQUAL_INT(cam_err_state, cam_machine_start(m));
    TEST_ASSERT_EQUAL_UINT32(1, m->pass);
    TEST_ASSERT_EQUAL_UINT32(0, m->n_parts);
}

/// After a pass of a table that is used no longer nothing is handed over.
static void test_the_next_pass_needs_the_table(void)
{
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
    cut_first_of_two();
    m->pass = 1; // as if it had been the last one
    expect_set(cam_ok, cam_param_phase_udeg, 5);
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
/// there was a pass. Parts are set from 0 on.
static void test_parts_are_counted_once_at_the_end_of_their_pass(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_param_range, cam_machine_set_parts(m, -1));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_parts(m, INT32_MAX));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_parts(m, 0));
    TEST_ASSERT_EQUAL_UINT32(0, m->n_parts);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_parts(m, 41));
    bring(cam_state_cutting);
    poll_for(1);
    TEST_ASSERT_TRUE(m->is_in_pass);
    TEST_ASSERT_LESS_THAN_UINT32(400000, fixture_rig_until(&rig, cam_state_ready, 400000));
    m->n_requests++; // something is posted and not carried out
    cam_machine_poll(m);
    TEST_ASSERT_TRUE(m->is_in_pass);
    m->n_requests--;
    for (int i = 0; i < 2; i++) {
        cam_machine_poll(m);
        TEST_ASSERT_FALSE(m->is_in_pass);
        TEST_ASSERT_EQUAL_UINT32(42, m->n_parts);
    }
}

/// Home out of ready enables again by itself, unless a fault came between. Downloads wait for its
/// end, for the last command and for the last configuration, each by itself.
static void test_home_ends_where_the_state_is_another(void)
{
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
    m->n_requests++;
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_may_exchange(m));
    m->n_requests--;
    m->generation++;
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_may_exchange(m));
    m->generation--;
    bring(cam_state_ready);
    m->n_requests++;
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_home(m));
    TEST_ASSERT_FALSE(m->homes_again); // nothing was begun
    m->n_requests--;
    m->homes_again = true; // in another state than off there is nothing to enable
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->homes_again);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
}

/// What the slow side has still to do lets the second half of home wait; then it enables.
static void test_home_waits_until_all_homes_are_read(void)
{
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home(m));
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    m->n_requests++; // something is posted and not carried out
    cam_machine_poll(m);
    TEST_ASSERT_TRUE(m->homes_again);
    m->n_requests--;
    m->offsets.n_found++; // another number of homes than the interrupt has found
    cam_machine_poll(m);
    TEST_ASSERT_TRUE(m->homes_again);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    poll_for(2);
    TEST_ASSERT_FALSE(m->homes_again);
    TEST_ASSERT_EQUAL_INT(cam_state_homing, fixture_rig_state());
}

/// In ready a table needs one before it, of the same sense. A damaged one is dropped at once where
/// nothing is enabled: off, and after a fault.
static void test_a_table_in_ready_follows_another_of_its_sense(void)
{
    bring(cam_state_ready);
    m->has_table = false;
    expect_select(cam_err_table_sense);
    m->has_table = true;
    expect_select(cam_ok);
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

/// What the commander leaves is stopped when the interrupt has taken the last request or order, and
/// again while the stop finds no room.
static void test_the_stop_of_a_lost_commander_is_not_forgotten(void)
{
    bring(cam_state_cutting);
    m->is_stop_due = true;
    m->n_requests++;
    cam_machine_poll(m);
    TEST_ASSERT_TRUE(m->is_stop_due);
    m->n_requests--;
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->is_stop_due);
    until(cam_state_disengaging);
    setUp();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(m));
    until(cam_state_manual);
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

// Hold, overrides and trim

/// Hold needs a cut, resume a hold; while the feed is held the axes follow the table as in the cut,
/// and nothing is switched off.
static void test_hold_needs_a_cut_and_resume_a_hold(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_hold(m));
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_hold(m));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    until(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_resume(m));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(m));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(m));
    until(cam_state_holding);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_disable(m));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_start(m));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_home(m));
    fixture_rig_ticks(&rig, 100);
    TEST_ASSERT_EQUAL_INT(cam_state_holding, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_resume(m));
    until(cam_state_cutting);
    until(cam_state_disengaging);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_hold(m));
    until(cam_state_ready);
    TEST_ASSERT_EQUAL_UINT32(1, m->n_parts);
}

/// It outlives a command that is on its way.
static void test_hold_is_forgotten_when_the_cut_ends(void)
{
    bring(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(m));
    until(cam_state_holding);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(m));
    (void)fixture_rig_until(&rig, cam_state_ready, 400000);
    m->n_requests++;
    cam_machine_poll(m);
    TEST_ASSERT_TRUE(m->is_held);
    m->n_requests--;
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->is_held);
    poll_for(2);
    TEST_ASSERT_EQUAL_UINT32(0, m->n_parts); // it was cut short
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    until(cam_state_cutting);
    until(cam_state_ready);
    TEST_ASSERT_EQUAL_UINT32(1, m->n_parts);
}

/// While the interrupt has not taken the last configuration, a hold waits and is not lost. A rate
/// that is due goes with any configuration, whatever it was made for. Both need a table.
static void test_hold_is_handed_over_as_soon_as_there_is_room(void)
{
    bring(cam_state_cutting);
    expect_set(cam_ok, cam_param_phase_udeg, 5);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(m));
    TEST_ASSERT_TRUE(m->is_rate_due);
    until(cam_state_holding);
    TEST_ASSERT_FALSE(m->is_rate_due);
    m->is_rate_due = true;
    set(cam_param_phase_udeg, 1000);
    TEST_ASSERT_FALSE(m->is_rate_due);
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

/// A resume that finds no room is handed over by the next poll, and brings no hold back.
static void test_a_resume_waits_for_room(void)
{
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

static void test_changes_in_the_cut_are_bounded(void)
{
    const int32_t limit_nm = m->params.x_trim_limit_nm;
    m->params.spindle_limit_mrpm = 2800000;
    bring(cam_state_cutting);
    expect_set(cam_err_trim_limit, cam_param_x_trim_nm, -limit_nm - 1);
    TEST_ASSERT_EQUAL_INT64(limit_nm + 1, m->refusal.needed);
    TEST_ASSERT_EQUAL_INT(cam_err_trim_limit, m->refusal.err);
    TEST_ASSERT_EQUAL_INT(cam_param_x_trim_nm, m->refusal.param);
    TEST_ASSERT_EQUAL_INT64(limit_nm, m->refusal.limit);
    set(cam_param_x_trim_nm, -limit_nm);
    set(cam_param_spindle_override_ppm, 1100000);
    expect_set(cam_err_spindle_speed, cam_param_spindle_override_ppm, 1150000);
    TEST_ASSERT_EQUAL_INT64(2875000, m->refusal.needed);
    TEST_ASSERT_EQUAL_INT64(2800000, m->refusal.limit);
    TEST_ASSERT_EQUAL_INT32(1100000, m->params.spindle_override_ppm);
    expect_set(cam_err_param_state, cam_param_feed_nm, 100000);
    expect_set(cam_err_param_range, cam_param_feed_override_ppm, 1500001);
}

static void test_a_ring_helix_has_its_own_feed_or_none(void)
{
    part.is_ring_helix = true;
    fixture_rig_init(&rig, &part, 20000);
    bring(cam_state_cutting);
    expect_set(cam_err_override_rings, cam_param_feed_override_ppm, 900000);
    // Z would exceed its acceleration by the square of that.
    expect_set(cam_err_override_rings, cam_param_spindle_override_ppm, 1100000);
    set(cam_param_spindle_override_ppm, 900000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(m));
    until(cam_state_holding);
}

// Button and command

static void test_button_is_that_of_the_port(void)
{
    const hal_operator_t with_button = {.has_acknowledge = true};
    const struct {
        hal_operator_t port;
        cam_acknowledge_phase_t phase;
        cam_button_t button;
        cam_err_t err;
    } cases[] = {
        {with_button, cam_acknowledge_pressed, cam_button_needed, cam_err_acknowledge},
        {with_button, cam_acknowledge_given, cam_button_given, cam_ok},
        {with_button, cam_acknowledge_used, cam_button_given, cam_ok},
        {{0}, cam_acknowledge_used, cam_button_none, cam_err_acknowledge_none},
        {{.is_acknowledge_waived = true}, cam_acknowledge_used, cam_button_waived, cam_ok},
    };
    cam_status_t status = fixture_rig_status(&rig);
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        m->rights.port = cases[i].port;
        TEST_ASSERT_EQUAL(!cases[i].port.is_acknowledge_waived,
                          cam_machine_acknowledge_config(m).is_demanded);
        status.acknowledge.phase = cases[i].phase;
        TEST_ASSERT_EQUAL_INT(cases[i].button, cam_machine_rights(m, &status).button);
        TEST_ASSERT_EQUAL_INT(cases[i].err, cam_machine_check_acknowledge(m, &status));
    }
}

/// Given up or lost: an enable that waited for the state off does not come by itself.
static void test_a_loss_forgets_the_enable_that_waits(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_rights_take(&m->rights, 5, true, cam_machine_status(m).tick));
    m->homes_again = true;
    cam_machine_release_command(m);
    TEST_ASSERT_EQUAL_UINT8(0, m->rights.commander);
    TEST_ASSERT_TRUE(m->is_stop_due);
    const cam_status_t status = fixture_rig_status(&rig);
    m->rights.n_take_overs = 3;
    TEST_ASSERT_EQUAL_UINT32(3, cam_machine_rights(m, &status).n_take_overs);
    cam_machine_rights_poll(m, &status);
    TEST_ASSERT_FALSE(m->homes_again);
    TEST_ASSERT_FALSE(m->is_stop_due);
}
