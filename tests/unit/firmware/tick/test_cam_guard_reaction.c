// SPDX-License-Identifier: Apache-2.0
// What a fault leads to, on a whole controller: retract, brake, enable, lamp, latch, reset.
#include "rig_bench.h"
#include <math.h>

static const cam_state_t enabled[] = {cam_state_homing, cam_state_ready, cam_state_engaging,
                                      cam_state_cutting, cam_state_disengaging};
enum { n_enabled = sizeof enabled / sizeof enabled[0], patience = 20000 };

static bench_t moment; ///< of the cut, from which several tests start

static bool is_enabled(void)
{
    return (hal_host.out.outputs & hal_out_enable) != 0u;
}

/// [nm] places and steps of the axes as they are written.
typedef struct {
    double at[hal_n_axes], step[hal_n_axes];
    double ago[8][hal_n_axes]; ///< steps of the last 8 ticks
    uint32_t n;
} motion_t;

static void observe(motion_t *m)
{
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        const double at =
            i == hal_axis_u ? rig.last.want.u_set_q6 / 64.0 : (double)hal_host.out.axis[i].pos_nm;
        m->step[i] = at - m->at[i];
        m->at[i] = at;
    }
}

static motion_t start_observing(void)
{
    motion_t m = {.at = {0}};
    observe(&m);
    fixture_rig_tick(&rig);
    observe(&m);
    return m;
}

enum { window_ticks = 16 * 8 }; ///< over which the acceleration of X and Z changes
enum { plan_ticks = 8 };        ///< from plan to plan at 20 kHz: X and Z change their speed there

/// One tick in which no axis may exceed its limits, full ones: the defaults at 20 kHz. X and Z have
/// one speed from plan to plan, so theirs may change by that of a plan, and by no more in 8 ticks.
static void tick_within_limits(motion_t *m)
{
    static const double speed[hal_n_axes] = {20000.0, 5000.0, 10000.0};
    static const double acceleration[hal_n_axes] = {625.0, 5.0, 5.0};
    const motion_t before = *m;
    fixture_rig_tick(&rig);
    observe(m);
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        const double slack = i == hal_axis_u ? 0.1 : 2.01; // whole nanometres
        const double ticks = i == hal_axis_u ? 1.0 : plan_ticks;
        TEST_ASSERT_TRUE(fabs(m->step[i]) <= speed[i] + slack);
        TEST_ASSERT_DOUBLE_WITHIN(ticks * acceleration[i] + slack, before.step[i], m->step[i]);
        if (i != hal_axis_u && m->n >= plan_ticks) {
            const double then = m->ago[m->n % plan_ticks][i];
            TEST_ASSERT_DOUBLE_WITHIN(ticks * acceleration[i] + slack, then, m->step[i]);
        }
        m->ago[m->n % plan_ticks][i] = m->step[i];
    }
    m->n++;
}

/// Press the emergency stop and follow the retract to its end.
static void expect_retract(motion_t *m)
{
    const motion_t first = *m;
    hal_host_fault_estop(true);
    tick_within_limits(m);
    TEST_ASSERT_EQUAL_INT(cam_state_fault, rig.last.want.state);
    TEST_ASSERT_EQUAL_INT32(0, hal_host.out.spindle_mrpm);
    TEST_ASSERT_EQUAL_HEX32(hal_out_enable | hal_out_fault, hal_host.out.outputs);
    uint32_t n = 0;
    while (is_enabled() && n < patience) {
        TEST_ASSERT_FALSE(fixture_rig_status(&rig).is_retracted);
        tick_within_limits(m);
        n++;
    }
    TEST_ASSERT_LESS_THAN_UINT32(patience, n);
    TEST_ASSERT_EQUAL_HEX32(hal_out_fault, hal_host.out.outputs);
    TEST_ASSERT_TRUE(fixture_rig_status(&rig).is_retracted);
    TEST_ASSERT_EQUAL_DOUBLE(-500000.0, m->at[hal_axis_u]);
    // from where X was led in the tick of the fault
    TEST_ASSERT_DOUBLE_WITHIN(1.0 + 1.01 * fabs(first.step[hal_axis_x]), first.at[hal_axis_x] + 1e6,
                              m->at[hal_axis_x]);
    const double brake = m->at[hal_axis_z] - first.at[hal_axis_z];
    const double v = fabs(first.step[hal_axis_z]);
    const double coasting = (plan_ticks + 1 + window_ticks / 2) * (v + 1.0);
    TEST_ASSERT_TRUE(fabs(brake) <= (v + 1.0) * (v + 1.0) / 10.0 + coasting); // v^2 / 2a
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, m->step[i]);
    }
}

static void test_reaction_in_every_enabled_state_retracts_within_limits(void)
{
    for (uint32_t i = 0; i < n_enabled; i++) {
        setUp();
        bring(enabled[i]);
        fixture_rig_ticks(&rig, 100);
        motion_t m = start_observing();
        expect_retract(&m);
    }
}

/// From the steepest places of the section, rising and falling, and from its extremes.
static void test_reaction_from_any_speed_of_u_retracts_within_limits(void)
{
    bring(cam_state_cutting);
    fixture_rig_ticks(&rig, 2400);
    for (uint32_t ticks = 0; ticks < 240; ticks += 15) { // a whole period of the oval
        keep(&moment);
        motion_t m = start_observing();
        expect_retract(&m);
        go_back(&moment);
        fixture_rig_ticks(&rig, 15);
        TEST_ASSERT_EQUAL_INT(cam_state_cutting, rig.last.want.state);
    }
}

static void test_reaction_to_a_lost_drive_drops_enable_at_once(void)
{
    for (uint32_t i = 0; i < n_enabled; i++) {
        setUp();
        bring(enabled[i]);
        hal_host_fault_drive(true);
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_HEX32(hal_out_fault, hal_host.out.outputs);
        TEST_ASSERT_EQUAL_INT32(0, hal_host.out.spindle_mrpm);
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(drive), fixture_rig_status(&rig).first_fault);
        hal_host_fault_drive(false); // the drive is ready again, but the latch holds
        fixture_rig_ticks(&rig, 10);
        TEST_ASSERT_EQUAL_HEX32(hal_out_fault, hal_host.out.outputs);
    }
}

static void test_reaction_to_a_drive_lost_while_retracting_drops_enable_at_once(void)
{
    bring(cam_state_cutting);
    hal_host_fault_estop(true);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_TRUE(is_enabled());
    hal_host_fault_drive(true);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_HEX32(hal_out_fault, hal_host.out.outputs);
    const cam_status_t status = fixture_rig_status(&rig);
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop), status.first_fault);
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive), status.faults);
    TEST_ASSERT_EQUAL_UINT32(1, status.fault_count[cam_fault_drive]);
}

static void test_reaction_while_retracting_takes_no_other_fault_on(void)
{
    bring(cam_state_cutting);
    hal_host_fault_estop(true);
    fixture_rig_tick(&rig);
    hal_host_fault_late(300);
    hal_host_fault_counts(900);
    rig.lathe.error_nm[hal_axis_u] = 900000;
    fixture_rig_ticks(&rig, 5000);
    const cam_status_t status = fixture_rig_status(&rig);
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop), status.faults);
    TEST_ASSERT_EQUAL_UINT32(1, status.n_late); // counted all the same
    TEST_ASSERT_EQUAL_UINT32(40000, status.max_period);
}

static void test_reaction_to_several_faults_of_one_tick_tells_all(void)
{
    bring(cam_state_cutting);
    hal_host_fault_estop(true);
    hal_host_fault_drive(true);
    hal_host_fault_counts(-400);
    rig.lathe.error_nm[hal_axis_u] = 400000;
    fixture_rig_tick(&rig);
    const uint32_t all = CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive) | CAM_FAULT_BIT(encoder_jump) |
                         CAM_FAULT_BIT(following_error);
    const cam_status_t status = fixture_rig_status(&rig);
    TEST_ASSERT_EQUAL_HEX32(all, status.first_fault & all);
    TEST_ASSERT_EQUAL_HEX32(status.first_fault, status.faults);
    for (uint32_t i = 0; i < cam_n_faults; i++) {
        TEST_ASSERT_EQUAL_UINT32((status.faults >> i) & 1u, status.fault_count[i]);
    }
}

static void test_counters_rise_with_every_fault(void)
{
    for (uint32_t n = 1; n <= 3; n++) {
        bring(cam_state_ready);
        hal_host_fault_estop(true);
        fixture_rig_ticks(&rig, 5000);
        TEST_ASSERT_EQUAL_UINT32(n, fixture_rig_status(&rig).fault_count[cam_fault_estop]);
        hal_host_fault_estop(false);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&rig.machine));
        fixture_rig_ticks(&rig, 5000);
    }
}

/// In every phase of the section: the slack of the acceleration check takes a tick off its time.
static void test_late_tick_of_45_percent_anywhere_in_the_section_is_no_fault(void)
{
    bring(cam_state_cutting);
    for (int i = 0; i < 31; i++) {
        fixture_rig_ticks(&rig, 127); // no divisor of the period of 240 ticks
        hal_host_fault_late(45);
        fixture_rig_ticks(&rig, 3);
        TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    }
    TEST_ASSERT_EQUAL_UINT32(14500, fixture_rig_status(&rig).max_period);
    TEST_ASSERT_EQUAL_UINT32(0, fixture_rig_status(&rig).n_late);
}

static void test_late_tick_of_80_percent_anywhere_in_the_section_is_that_fault_alone(void)
{
    bring(cam_state_cutting);
    fixture_rig_ticks(&rig, 2400);
    for (uint32_t ticks = 0; ticks < 240; ticks += 24) {
        keep(&moment);
        hal_host_fault_late(80);
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(late_tick), fixture_rig_status(&rig).first_fault);
        fixture_rig_ticks(&rig, 3);
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(late_tick), fixture_rig_status(&rig).faults);
        go_back(&moment);
        fixture_rig_ticks(&rig, 24);
        TEST_ASSERT_EQUAL_INT(cam_state_cutting, rig.last.want.state);
    }
}

static void test_in_cut_output_is_high_in_the_cut_only(void)
{
    for (uint32_t i = 0; i < n_enabled; i++) {
        setUp();
        bring(enabled[i]);
        const uint32_t in_cut = enabled[i] == cam_state_cutting ? hal_out_in_cut : 0u;
        TEST_ASSERT_EQUAL_HEX32(hal_out_enable | in_cut, hal_host.out.outputs);
    }
}
