// SPDX-License-Identifier: Apache-2.0
// The commands of a whole controller through faults and late ticks: U exceeds neither its speed nor
// its acceleration, and a command beyond its limits is a fault, not written.
#include "rig_bench.h"

/// Configuration in force, which a test may spoil after all checks.
static cam_config_t *in_force(void)
{
    return &g_cam.config.half[g_cam.config.offered == &g_cam.config.half[0] ? 0 : 1];
}

/// Press the emergency stop: it must be the only fault. @return U's command of n ticks
static motion_t retract(int n)
{
    motion_t t = motion_of(hal_axis_u);
    for (int i = -2; i < n; i++) { // after two ticks the step and its change are known
        if (i == 0) {
            t.most_step_nm = t.most_change_nm = 0;
            hal_host_fault_estop(true);
        }
        fixture_rig_tick(&rig);
        watch(&t, hal_axis_u);
    }
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop), fixture_rig_status(&rig).faults);
    return t;
}

/// A drive, and what U's command may do from tick to tick when a fault comes in the cut.
typedef struct {
    uint32_t tick_hz;
    struct {
        cam_param_id_t id;
        int32_t value;
    } set[6];
    bool is_fastest;                 ///< at the highest speed of the spindle
    uint32_t ticks, n_places, apart; ///< from the begin of the cut, and from fault to fault
    int32_t most_step_nm;
} course_t;

static const course_t courses[] = {
    // The drive of the default machine of host_sim: 300 Hz, 0.7.
    {.tick_hz = 20000,
     .set = {{cam_param_k1_ns, 742723},
             {cam_param_k2_us2, 281448},
             {cam_param_following_limit_nm, 10000000}},
     .ticks = 2400,
     .n_places = 15,
     .apart = 16,
     .most_step_nm = 20000},
    // Without feed-forward.
    {.tick_hz = 5000,
     .set = {{cam_param_u_acceleration_mm_per_s2, 20000}}, // 800 nm per tick^2
     .is_fastest = true,
     .ticks = 500,
     .n_places = 120,
     .apart = 1,
     .most_step_nm = 80000},
    // At 1 kHz the acceleration of a tick is five times the speed of a tick.
    {.tick_hz = 1000,
     .set = {{cam_param_u_speed_um_per_s, 50000},
             {cam_param_spindle_mrpm, 100000},
             {cam_param_following_limit_nm, 10000000}},
     .n_places = 40,
     .apart = 37,
     .most_step_nm = 50000},
    // A stiff drive of 900 Hz: a window is two ticks, and what the feed-forward adds while the
    // acceleration of the retract ends is a tenth of the speed.
    {.tick_hz = 2000,
     .set = {{cam_param_u_speed_um_per_s, 300000},
             {cam_param_u_acceleration_mm_per_s2, 2000000},
             {cam_param_k1_ns, 282942},
             {cam_param_k2_us2, 31270},
             {cam_param_spindle_mrpm, 100000},
             {cam_param_following_limit_nm, 10000000}},
     .n_places = 20,
     .apart = 37,
     .most_step_nm = 150000},
};

static void start(const course_t *c)
{
    fixture_rig_init(&rig, &part, c->tick_hz);
    for (uint32_t i = 0; i < 6u && c->set[i].value != 0; i++) {
        set(c->set[i].id, c->set[i].value);
    }
    if (c->is_fastest) {
        set(cam_param_spindle_mrpm, (int32_t)cam_machine_highest_mrpm(&rig.machine));
    }
}

static void test_command_through_faults_at_any_angle_keeps_the_limits_of_u(void)
{
    static fixture_rig_whole_t bench;
    for (size_t i = 0; i < sizeof courses / sizeof courses[0]; i++) {
        const course_t *c = &courses[i];
        start(c);
        bring(cam_state_cutting);
        fixture_rig_ticks(&rig, c->ticks);
        fixture_rig_keep(&bench, &rig);
        for (uint32_t at = 0; at < c->n_places; at++) {
            fixture_rig_put(&rig, &bench);
            fixture_rig_ticks(&rig, c->apart * at);
            const motion_t t = retract(600);
            TEST_ASSERT_LESS_OR_EQUAL_INT32(c->most_step_nm, t.most_step_nm);
            TEST_ASSERT_LESS_OR_EQUAL_INT32(in_force()->guard.u.acceleration_q10 / 1024 + 2,
                                            t.most_change_nm);
            TEST_ASSERT_EQUAL_INT32(0, t.step_nm); // at rest
        }
    }
}

/// Stop in each tick of half a turn, the tick before it late or not.
/// @return [nm] how far into the work U's command moves at most
static int32_t deepest_nm(int32_t friction_nm, uint32_t late_percent)
{
    static fixture_rig_whole_t bench;
    start(&courses[0]);
    set(cam_param_u_friction_nm, friction_nm);
    set(cam_param_spindle_mrpm, (int32_t)cam_machine_highest_mrpm(&rig.machine));
    bring(cam_state_cutting);
    fixture_rig_ticks(&rig, 2400);
    fixture_rig_keep(&bench, &rig);
    int32_t deepest_nm = 0;
    for (uint32_t at = 0; at < 240u; at++) {
        fixture_rig_put(&rig, &bench);
        fixture_rig_ticks(&rig, at);
        hal_host_fault_late(late_percent);
        fixture_rig_tick(&rig);
        const int32_t last_nm = hal_host.out.axis[hal_axis_u].pos_nm;
        hal_host_fault_estop(true);
        for (int i = 0; i < 80; i++) {
            fixture_rig_tick(&rig);
            const int32_t deep_nm = hal_host.out.axis[hal_axis_u].pos_nm - last_nm;
            deepest_nm = deep_nm > deepest_nm ? deep_nm : deepest_nm;
        }
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop), fixture_rig_status(&rig).faults);
    }
    return deepest_nm;
}

/// Neither the reversal of friction nor a tick off its time is taken for a speed of U.
static void test_no_single_step_of_the_command_throws_u_into_the_work(void)
{
    static const int32_t frictions_nm[] = {300, 20000};
    const int32_t usual_nm = deepest_nm(0, 0);
    for (size_t i = 0; i < sizeof frictions_nm / sizeof frictions_nm[0]; i++) {
        TEST_ASSERT_INT32_WITHIN(50, usual_nm, deepest_nm(frictions_nm[i], 0));
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT32(usual_nm * 8 / 5, deepest_nm(0, 40));
}

/// A plan that would command X or Z beyond its limits is not carried out: the axis continues as
/// before.
static void test_increments_beyond_the_limits_are_a_fault_before_they_are_commanded(void)
{
    for (uint32_t i = (uint32_t)hal_axis_x; i <= (uint32_t)hal_axis_z; i++) {
        setUp();
        hal_host.in.axis_nm[i] += 500000; // from where the cut begins
        fixture_rig_ticks(&rig, 20);
        bring(i == (uint32_t)hal_axis_x ? cam_state_engaging : cam_state_cutting);
        for (int k = 0; k < 20000 && hal_host.out.axis[i].vel_q10 == 0; k++) {
            fixture_rig_tick(&rig);
        }
        const int32_t vel_q10 = hal_host.out.axis[i].vel_q10;
        TEST_ASSERT_NOT_EQUAL_INT32(0, vel_q10);
        in_force()->command.vel_q10[i] = 0; // the axis moves, and may not
        uint32_t n = 0;
        while (rig.last.want.state != cam_state_fault && n < 20) {
            TEST_ASSERT_INT32_WITHIN(8000, vel_q10, hal_host.out.axis[i].vel_q10);
            fixture_rig_tick(&rig);
            n++;
        }
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(10, n);
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(command), fixture_rig_status(&rig).first_fault);
    }
}

/// What the plan itself detects is a fault beside what its checks find.
static void test_z_off_its_position_is_a_fault(void)
{
    bring(cam_state_cutting);
    rig.lathe.error_nm[hal_axis_z] = 200000;
    until(cam_state_fault);
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(z_range), fixture_rig_status(&rig).first_fault);
}

/// X leaves a clearance of 5 mm in a turn: a count of the encoder moves it by 0.94 um. And a fast
/// observer makes a speed of every count, which the lag of X multiplies.
static void test_counts_of_the_encoder_move_x_off_a_wide_clearance_without_a_fault(void)
{
    static const course_t cases[] = {
        {.tick_hz = 5000,
         .set = {{cam_param_engage_turns, 1},
                 {cam_param_x_clearance_nm, 5000000},
                 {cam_param_spindle_mrpm, 470700}, // no whole number of counts per tick
                 {cam_param_observer_bandwidth_mHz, 400000},
                 {cam_param_following_limit_nm, 10000000}}},
        {.tick_hz = 20000,
         .set = {{cam_param_x_clearance_nm, 20000000},
                 {cam_param_engage_turns, 10},
                 {cam_param_xz_lag_ns, 6366198},
                 {cam_param_spindle_mrpm, 1507300},
                 {cam_param_observer_bandwidth_mHz, 1000000},
                 {cam_param_following_limit_nm, 10000000}}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        start(&cases[i]);
        bring(cam_state_ready);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
        until(cam_state_cutting);
    }
}

/// The slack of the acceleration check takes a tick off its time, in every phase of the section.
static void test_late_tick_anywhere_in_the_section_is_that_fault_or_none(void)
{
    static const struct {
        uint32_t percent, faults;
    } cases[] = {{45, 0}, {80, CAM_FAULT_BIT(late_tick)}};
    static fixture_rig_whole_t moment;
    bring(cam_state_cutting);
    fixture_rig_ticks(&rig, 2400);
    for (uint32_t ticks = 0; ticks < 240; ticks += 8) {
        fixture_rig_keep(&moment, &rig);
        for (uint32_t i = 0; i < 2u; i++) {
            hal_host_fault_late(cases[i].percent);
            fixture_rig_ticks(&rig, 4);
            TEST_ASSERT_EQUAL_HEX32(cases[i].faults, fixture_rig_status(&rig).faults);
            fixture_rig_put(&rig, &moment);
        }
        fixture_rig_ticks(&rig, 8);
    }
}
