// SPDX-License-Identifier: Apache-2.0
// Homing, approach and retract, plan by plan: when the axes are out of the work, and which of them
// moves.
#include "cam_plan_inner.h"
#include "unity.h"

enum {
    retract_q10 = -512000,
    turning_q32 = 1000,
    clear_nm = 50000,
    first_nm = -3000,
    origin_nm = 1000,
    begin_q10 = (first_nm + origin_nm) * 1024
};

typedef struct {
    cam_play_config_t cfg;
    cam_tick_record_t r;
    cam_motion_t m;
} bench_t;

static bool plan(bench_t *b)
{
    return cam_positioning_isr(&b->cfg, &b->r, &b->m);
}

/// @return a plan of homing in which all conditions hold
static bench_t homed(void)
{
    const cam_motion_limits_t gentle = {.speed_q10 = 4096, .acceleration_q10 = 64};
    return (bench_t){
        .cfg = {.plan_ticks = 8,
                .per_plan_q30 = 1 << 27,
                .u_retract_q10 = retract_q10,
                .turning_q32 = turning_q32,
                .approach = {gentle, gentle, gentle}},
        .r.angle = {.is_synced = true, .speed_q32 = turning_q32},
        .m = {.state = cam_state_homing, .axis[hal_axis_u].pos_q10 = retract_q10},
    };
}

/// Every single condition that does not hold keeps the state homing.
static void test_homing_ends_when_the_tool_is_out_and_all_stand(void)
{
    static const struct {
        const char *name;
        int32_t u_q10, vel_q10[hal_n_axes], slower_q32;
        bool was_off, is_lost;
    } rows[] = {{.name = "all conditions hold"},
                {.name = "U is not out", .u_q10 = 1},
                {.name = "U moves", .vel_q10 = {1, 0, 0}},
                {.name = "X moves", .vel_q10 = {0, 1024, 0}},
                {.name = "Z moves", .vel_q10 = {0, 0, -1024}},
                {.name = "spindle too slow", .slower_q32 = 1},
                {.name = "drives were off", .was_off = true},
                {.name = "no angle", .is_lost = true}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        bench_t b = homed();
        b.m.axis[hal_axis_u].pos_q10 += rows[i].u_q10;
        for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
            b.m.axis[axis].vel_q10 = rows[i].vel_q10[axis];
        }
        b.r.angle.speed_q32 -= rows[i].slower_q32;
        b.m.was_off = rows[i].was_off;
        b.r.angle.is_synced = !rows[i].is_lost;
        TEST_ASSERT_FALSE_MESSAGE(plan(&b), rows[i].name);
        TEST_ASSERT_EQUAL_INT_MESSAGE(i == 0u ? cam_state_ready : cam_state_homing, b.m.state,
                                      rows[i].name);
        TEST_ASSERT_EQUAL_INT64_MESSAGE(retract_q10, b.m.u_target_q10, rows[i].name);
    }
}

/// In homing and in the state fault the axes count as out of the work, anew for each fault.
static void test_what_belongs_to_the_cut_is_forgotten_outside_of_it(void)
{
    static const cam_state_t states[] = {cam_state_off, cam_state_homing, cam_state_ready,
                                         cam_state_fault};
    for (uint32_t i = 0; i < 4u; i++) {
        bench_t b = {.m = {.state = states[i], .is_clear = i < 3u, .u_target_q10 = 77}};
        b.m.phase_step_q32 = b.m.scale_step_q30 = b.m.height_step_q32 = 1; // only in the cut
        b.m.alpha_q40 = b.m.alpha_u = b.m.spindle_mrpm = 1;
        b.m.faults = 1;
        TEST_ASSERT_FALSE(plan(&b));
        if (states[i] == cam_state_off) { // U follows its measurement
            TEST_ASSERT_EQUAL_INT64(77, b.m.u_target_q10);
        }
        TEST_ASSERT_EQUAL_INT32(0, b.m.phase_step_q32 | b.m.scale_step_q30 | b.m.height_step_q32);
        TEST_ASSERT_EQUAL_INT32(0, b.m.alpha_q40 | b.m.alpha_u | b.m.spindle_mrpm);
        TEST_ASSERT_EQUAL_HEX32(0, b.m.faults);
        TEST_ASSERT_EQUAL(i == 3u, b.m.is_clear); // X and Z stand where they are to be
    }
}

/// @return an engaging controller with U at 0, X clear of the work and Z where the cut begins
static bench_t approaching(void)
{
    static const cam_knot_t knots[2];
    static const cam_table_t table = {.x = {.knots = knots, .n_slices = 2, .span_nm = 1000000}};
    bench_t b = homed();
    b.cfg.table = &table;
    b.cfg.u_retract_q10 = 0;
    b.cfg.x_clear_q10 = clear_nm * 1024;
    b.cfg.z_first_nm = first_nm;
    b.cfg.z_origin_nm = origin_nm;
    b.m.state = cam_state_engaging;
    b.m.axis[hal_axis_u].pos_q10 = 0;
    b.m.axis[hal_axis_x].pos_q10 = clear_nm * 1024;
    b.m.axis[hal_axis_z].pos_q10 = begin_q10;
    return b;
}

/// The tool nears the work only where it will cut: an X that is not clear moves out while Z comes
/// to rest, then Z moves while X comes to rest.
static void test_one_of_x_and_z_moves_at_a_time(void)
{
    enum { any = 1 << 20 };
    static const struct {
        const char *name;
        int32_t u_q10, x_nm, x_vel_q10, z_nm, z_vel_q10; ///< changes of the bench
        int32_t x_low, x_high, z_low, z_high;            ///< [nm / 1024 per tick] speeds afterwards
        bool is_there;
    } rows[] = {
        {"X moves out first", 0, -1, 0, 7, 800, 1, any, -any, 799, false},
        {"Z moves while X rests", 0, 0, 800, 700, 0, 0, 799, -any, -1, false},
        {"X moves to the work", 0, 0, 0, 0, 0, -any, -1, 0, 0, false},
        {"Z passes upwards", 0, 0, 0, 0, 2048, 0, 0, -any, any, false},
        {"Z passes downwards", 0, 0, 0, 0, -2048, 0, 0, -any, any, false},
        {"X may stay where the cut begins", 0, -clear_nm, 0, 0, 0, -any, any, -any, any, true},
        {"U is not at 0", -1, -clear_nm, 0, 0, 0, -any, any, -any, any, false},
    };
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        bench_t b = approaching();
        cam_axis_motion_t *x = &b.m.axis[hal_axis_x];
        cam_axis_motion_t *z = &b.m.axis[hal_axis_z];
        b.m.axis[hal_axis_u].pos_q10 = rows[i].u_q10;
        x->pos_q10 += rows[i].x_nm * 1024;
        x->vel_q10 = rows[i].x_vel_q10;
        z->pos_q10 += rows[i].z_nm * 1024;
        z->vel_q10 = rows[i].z_vel_q10;
        TEST_ASSERT_EQUAL_MESSAGE(rows[i].is_there, plan(&b), rows[i].name);
        TEST_ASSERT_TRUE_MESSAGE(x->vel_q10 >= rows[i].x_low && x->vel_q10 <= rows[i].x_high,
                                 rows[i].name);
        TEST_ASSERT_TRUE_MESSAGE(z->vel_q10 >= rows[i].z_low && z->vel_q10 <= rows[i].z_high,
                                 rows[i].name);
        TEST_ASSERT_EQUAL_INT64_MESSAGE(0, b.m.u_target_q10, rows[i].name);
    }
}

/// Over a measured Z X waits for U, and Z's set-point is its measurement, whatever its filter was
/// in the middle of; in the state fault, too.
static void test_a_measured_z_is_never_commanded(void)
{
    for (int i = 0; i < 3; i++) {
        bench_t b = approaching();
        cam_axis_motion_t *z = &b.m.axis[hal_axis_z];
        b.cfg.is_z_measured = true;
        b.m.state = i == 2 ? cam_state_fault : cam_state_engaging;
        b.m.axis[hal_axis_u].pos_q10 = i == 0 ? -1024 : 0;
        *z = (cam_axis_motion_t){.pos_q10 = 4321 * 1024, .vel_q10 = 900};
        cam_jerk_filter_begin_isr(&b.m.filter[hal_axis_z], z, 2);
        b.m.is_filtering = true;
        b.r.in.actual_nm[hal_axis_z] = 4321;
        (void)plan(&b);
        TEST_ASSERT_EQUAL_INT64(4321 * 1024, z->pos_q10);
        TEST_ASSERT_EQUAL_INT32(0, z->vel_q10);
        TEST_ASSERT_EQUAL(i == 1, b.m.axis[hal_axis_x].vel_q10 < 0);
    }
}

/// The tool swings back to 0 after a fault, and until then it is not out of the work.
static void test_swing_comes_to_rest_after_a_fault(void)
{
    bench_t b = homed();
    b.cfg.swing.is_swung = true;
    b.cfg.swing.full =
        (cam_swing_limits_t){.speed_q32 = 1 << 20, .step_q32 = 1 << 18, .gain_q32 = 1 << 24};
    b.m.state = cam_state_fault;
    b.m.swing.set.pos_q32 = 1 << 26;
    for (int i = 0; !b.m.swing.is_there; i++) {
        TEST_ASSERT_LESS_THAN_INT(10000, i);
        TEST_ASSERT_FALSE(b.m.is_clear);
        (void)plan(&b);
    }
    TEST_ASSERT_INT32_WITHIN(1 << 10, 0, b.m.swing.set.pos_q32);
    TEST_ASSERT_TRUE(b.m.is_clear);
}
